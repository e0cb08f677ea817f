//! Where methods fail: experiments S1 to S21 of numerics.md through the renderer's own code, each against an oracle.

mod acne;
mod boxes;
mod cause;
mod hostile;
mod invariance;
mod map;
mod media;
mod numbers;
mod oracle;
mod quadrics;
mod refraction;
mod run;
mod scenes;
mod solids;
mod spheres;
mod sweep;
mod terminator;
mod trials;
mod triangles;
mod vectors;

pub use map::{Map, map};
pub use run::{Finding, Plan, all_hold, run, summary};
pub use sweep::{Row, Sweep};
pub use trials::{Effort, PRESETS};

/// One experiment.
pub struct Experiment {
    /// As in numerics.md: `S1`.
    pub id: &'static str,
    /// In words.
    pub title: &'static str,
    /// What is taken for the truth.
    pub oracle: &'static str,
    /// Carries it out.
    pub run: fn(&Effort) -> Vec<Sweep>,
}

const DD: &str = "double-double";

/// All experiments.
pub const EXPERIMENTS: &[Experiment] = &[
    Experiment { id: "S1", title: "balls from afar", oracle: DD, run: spheres::far },
    Experiment { id: "S2", title: "balls just grazed", oracle: DD, run: spheres::grazing },
    Experiment { id: "S3", title: "balls as floors", oracle: DD, run: spheres::floor },
    Experiment { id: "S4", title: "cylinders", oracle: DD, run: quadrics::cylinder },
    Experiment { id: "S5", title: "cones", oracle: DD, run: quadrics::cone },
    Experiment {
        id: "S6",
        title: "rims, edges and apices",
        oracle: "crossings of a closed solid",
        run: quadrics::joints,
    },
    Experiment { id: "S7", title: "boxes that are touched", oracle: "exact arithmetic", run: boxes::slabs },
    Experiment { id: "S8", title: "closed meshes", oracle: "no way out; f64 boxes", run: triangles::watertight },
    Experiment { id: "S9", title: "slivers and grazed triangles", oracle: DD, run: triangles::slivers },
    Experiment { id: "S10", title: "acne and lost contacts", oracle: "convexity", run: acne::acne },
    Experiment { id: "S11", title: "refraction", oracle: DD, run: refraction::refraction },
    Experiment { id: "S12", title: "energy", oracle: "a white furnace shows 1", run: refraction::energy },
    Experiment { id: "S13", title: "media", oracle: "the same bodies, made otherwise", run: media::media },
    Experiment { id: "S14", title: "terminator", oracle: "the ball itself", run: terminator::terminator },
    Experiment { id: "S15", title: "scale and mirror", oracle: "the scene itself", run: invariance::equivariance },
    Experiment { id: "S16", title: "translation", oracle: "the scene at the origin", run: invariance::translation },
    Experiment { id: "S17", title: "determinism", oracle: "one thread", run: invariance::determinism },
    Experiment { id: "S18", title: "hostile input", oracle: "an error or a picture", run: hostile::hostile },
    Experiment { id: "S19", title: "accumulation", oracle: DD, run: numbers::accumulation },
    Experiment { id: "S20", title: "sRGB codes", oracle: DD, run: numbers::codes },
    Experiment { id: "S21", title: "texture coordinates", oracle: "closed forms", run: numbers::texture_coordinates },
];
