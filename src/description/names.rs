//! The words of the scene language for its choices: the same in files, flags and reports.

use super::{Falloff, Filter, Numerics, Shading, Shadows, Wrap};

macro_rules! names {
    ($choice:ident { $($name:literal => $value:ident),+ }) => {
        impl $choice {
            /// Every value with its name.
            pub const NAMES: &[(&str, Self)] = &[$(($name, Self::$value)),+];

            /// Its name.
            pub const fn name(self) -> &'static str {
                match self {
                    $(Self::$value => $name),+
                }
            }
        }
    };
}

names!(Shading { "lambert" => Lambert, "phong" => Phong, "whitted" => Whitted });
names!(Shadows { "opaque" => Opaque, "filtered" => Filtered });
names!(Falloff { "none" => None, "inverse-square" => InverseSquare });
names!(Wrap { "repeat" => Repeat, "clamp" => Clamp, "mirror" => Mirror });
names!(Filter { "box" => Box, "tent" => Tent });
names!(Numerics { "classic" => Classic, "fast" => Fast, "robust" => Robust, "reference" => Reference });
