//! The settings of a scene that a study tries.

use crate::description::{Numerics, RenderDesc, Shading, limits};

/// What is tried.
#[derive(Clone, Debug)]
pub struct Sweep {
    /// Lighting models.
    pub shadings: Vec<Shading>,
    /// Arithmetic.
    pub numerics: Vec<Numerics>,
    /// Depths at which ray trees are cut.
    pub depths: Vec<u32>,
    /// Samples for every pixel.
    pub samples: Vec<u32>,
    /// Errors that adaptive sampling aims at, 8-bit codes.
    pub errors: Vec<f64>,
    /// Every combination, instead of one change at a time from what the scene says.
    pub all: bool,
    /// How often each is measured.
    pub repeats: usize,
    /// The error that an answer is wanted for, 8-bit codes.
    pub below: f64,
    /// Most samples of the reference.
    pub reference_samples: u32,
}

/// One way to render the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Setting {
    pub shading: Shading,
    pub numerics: Numerics,
    pub max_depth: u32,
    pub sampling: Sampling,
}

/// Which samples are traced.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Sampling {
    /// This many to every pixel.
    Uniform(u32),
    /// Where the picture is wrong, until its error is estimated to be this, 8-bit codes.
    Adaptive(f64),
}

impl Setting {
    pub(super) fn of(render: &RenderDesc) -> Self {
        let &RenderDesc { shading, numerics, max_depth, samples, error, .. } = render;
        let sampling = error.map_or(Sampling::Uniform(samples), Sampling::Adaptive);
        Self { shading, numerics, max_depth, sampling }
    }

    pub(super) fn render(&self, scene: &RenderDesc) -> RenderDesc {
        let &Self { shading, numerics, max_depth, sampling } = self;
        let (samples, error) = match sampling {
            Sampling::Uniform(samples) => (samples, None),
            Sampling::Adaptive(error) => (limits::ADAPTIVE_SAMPLES, Some(error)),
        };
        RenderDesc { shading, numerics, max_depth, samples, error, ..*scene }
    }

    pub(super) fn is_local(&self) -> bool {
        self.shading != Shading::Whitted
    }

    pub(super) fn name(&self) -> String {
        let depth = if self.is_local() { String::new() } else { format!(", depth {}", self.max_depth) };
        format!("{}, {}{depth}, {}", self.shading.name(), self.numerics.name(), self.sampling.name())
    }
}

impl Sampling {
    pub(super) fn name(self) -> String {
        match self {
            Self::Uniform(1) => "1 sample".to_owned(),
            Self::Uniform(samples) => format!("{samples} samples"),
            Self::Adaptive(error) => format!("to error {error}"),
        }
    }
}

impl Sweep {
    /// The same and this setting.
    pub(super) fn with(&self, own: Setting) -> Self {
        let mut sweep = self.clone();
        add(&mut sweep.depths, own.max_depth);
        add(&mut sweep.numerics, own.numerics);
        add(&mut sweep.shadings, own.shading);
        sweep
    }

    /// Its settings, for a scene that says `own`.
    pub(super) fn settings(&self, own: Setting) -> Vec<Setting> {
        let uniform = self.samples.iter().map(|samples| Sampling::Uniform(*samples));
        let adaptive = self.errors.iter().map(|error| Sampling::Adaptive(*error));
        let samplings: Vec<Sampling> = uniform.chain(adaptive).collect();
        let mut settings = Vec::new();
        for &shading in &self.shadings {
            for &numerics in &self.numerics {
                for &max_depth in &self.depths {
                    let one = Setting { shading, numerics, max_depth, ..own };
                    let changes = usize::from(shading != own.shading)
                        + usize::from(numerics != own.numerics)
                        + usize::from(max_depth != own.max_depth);
                    // Local models have no ray tree to cut.
                    let same = one.is_local() && max_depth != own.max_depth;
                    if (self.all || changes <= 1) && !same {
                        settings.extend(samplings.iter().map(|&sampling| Setting { sampling, ..one }));
                    }
                }
            }
        }
        settings
    }
}

fn add<T: PartialEq + Copy>(list: &mut Vec<T>, own: T) {
    if !list.contains(&own) {
        list.push(own);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_change_at_a_time_or_everything_and_local_models_once_for_all_depths() {
        let own = Setting::of(&RenderDesc::default());
        let sweep = Sweep {
            shadings: vec![Shading::Lambert, Shading::Whitted],
            numerics: vec![Numerics::Fast, Numerics::Robust],
            depths: vec![1, 4, 8],
            samples: vec![1],
            errors: vec![2.0],
            all: false,
            repeats: 1,
            below: 1.0,
            reference_samples: 64,
        };
        // Own, lambert, fast, two depths; two samplings each.
        assert_eq!(sweep.settings(own).len(), 2 * 5);
        // Whitted with 2 x 3, lambert with 2.
        assert_eq!(Sweep { all: true, ..sweep }.settings(own).len(), 2 * 8);
    }
}
