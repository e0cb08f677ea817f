//! The rays that make a sample, and every term of the light that comes back along them.

use crate::math::Rgb;
use serde::Serialize;
use std::fmt;

/// A ray, where it ends, and what follows from that.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RayTree {
    /// What it is for.
    pub kind: RayKind,
    /// World space.
    pub origin: [f64; 3],
    /// Unit, world space.
    pub direction: [f64; 3],
    /// Weight in the radiance of the ray that it comes from.
    pub share: f64,
    /// Weight in the sample.
    pub weight: f64,
    /// What it starts in.
    pub medium: Medium,
    /// Nodes and leaves of the hierarchies that it looks at.
    pub visits: u64,
    /// Surfaces on its way of bodies inside of others, which change nothing.
    pub passed: Vec<Passed>,
    /// Where it ends.
    pub end: End,
    /// What comes back along it: the sum of all terms at its end.
    pub radiance: Rgb,
}

/// What a ray is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum RayKind {
    /// From the eye.
    Camera,
    /// Mirrored.
    Reflection,
    /// Through a transparent surface.
    Refraction,
}

/// What light runs through.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Medium {
    /// The body; `None`: the world around all bodies.
    pub object: Option<String>,
    /// Refractive index.
    pub ior: f64,
}

/// A surface that is there for no ray.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Passed {
    /// Whose it is.
    pub object: String,
    /// Distance along the ray.
    pub t: f64,
}

/// Where a ray ends.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum End {
    /// It meets nothing.
    Background,
    /// On a surface.
    Surface(Box<SurfaceTerms>),
}

/// A surface and the terms of I = k_a I_a C + k_d sum I_i (n, l_i) C + k_s sum I_i (v, r_i)^s + k_r I_r + k_t I_t.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SurfaceTerms {
    /// What is met.
    pub object: String,
    /// Which triangle or face of it.
    pub primitive: u32,
    /// Distance along the ray.
    pub t: f64,
    /// Bound of the error of the point, scene units.
    pub error: f64,
    /// World space.
    pub point: [f64; 3],
    /// Unit, world space, on the viewer's side.
    pub normal: [f64; 3],
    /// Whether the ray goes into the body.
    pub entering: bool,
    /// What is behind a transparent surface.
    pub beyond: Option<Medium>,
    /// What it is made of.
    pub material: String,
    /// Of the material.
    pub coefficients: Coefficients,
    /// C
    pub color: Rgb,
    /// k_a I_a C
    pub ambient: Rgb,
    /// One a light.
    pub lights: Vec<LightTerm>,
    /// Mirrored and refracted rays, and those that were not followed.
    pub branches: Vec<Branch>,
}

/// Numbers of a material, as in the scene file.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Coefficients {
    /// Ambient.
    pub k_a: f64,
    /// Diffuse.
    pub k_d: f64,
    /// Specular.
    pub k_s: f64,
    /// s
    pub shininess: f64,
    /// Reflection.
    pub k_r: f64,
    /// Transmission.
    pub k_t: f64,
    /// Refractive index.
    pub ior: f64,
}

/// What a light gives to a surface.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LightTerm {
    /// Which one.
    pub light: String,
    /// Whether the surface looks away from it.
    pub behind: bool,
    /// The part of it that arrives.
    pub part: f64,
    /// 8-bit codes that the sample may change by at most, since no shadow ray was traced: half of the light is taken.
    pub unasked: Option<f64>,
    /// The first thing between the surface and the light, if that takes some of it.
    pub shadow_of: Option<String>,
    /// (n, l)
    pub cosine: f64,
    /// k_d I (n, l) C, as it arrives.
    pub diffuse: Rgb,
    /// k_s I (v, r)^s, as it arrives.
    pub specular: Rgb,
    /// What is added for both.
    pub sum: Rgb,
    /// Nodes and leaves of the hierarchies that the shadow ray looks at until it meets anything.
    pub visits: u64,
}

/// How light goes on.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Branch {
    /// Along this ray.
    Ray(Box<RayTree>),
    /// It was not followed.
    Cut(Cut),
}

/// Rays that were not followed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Cut {
    /// Which ones; `None`: both.
    pub kind: Option<RayKind>,
    /// Weight in the sample.
    pub weight: f64,
    /// Whether the path is as long as it may be; else it weighs too little.
    pub depth: bool,
}

impl RayTree {
    /// Nodes and leaves that all its rays look at, shadow rays included.
    pub fn all_visits(&self) -> u64 {
        let End::Surface(surface) = &self.end else { return self.visits };
        let lights: u64 = surface.lights.iter().map(|light| light.visits).sum();
        let branches = surface.branches.iter().map(|branch| match branch {
            Branch::Ray(ray) => ray.all_visits(),
            Branch::Cut(_) => 0,
        });
        self.visits + lights + branches.sum::<u64>()
    }

    /// The tree as lines, each with how deep it stands.
    pub fn lines(&self) -> Vec<Line> {
        let mut lines = Vec::new();
        self.write(0, &mut lines);
        lines
    }

    fn write(&self, depth: usize, lines: &mut Vec<Line>) {
        let mut line = |depth, emphasis, text| lines.push(Line { depth, emphasis, text });
        let term = match self.kind {
            RayKind::Camera => "camera ray".into(),
            RayKind::Reflection => format!("k_r I_r: reflected ray, share {}", number(self.share)),
            RayKind::Refraction => format!("k_t I_t: refracted ray, share {}", number(self.share)),
        };
        let weight = if self.kind == RayKind::Camera { String::new() } else { weight(self.weight) };
        let text = format!("{term}{weight}, in {}, {} visits", self.medium, self.visits);
        line(depth, Emphasis::Ray, text);
        for passed in &self.passed {
            let text = format!("passes {} at t = {}: inside of another body", passed.object, number(passed.t));
            line(depth + 1, Emphasis::Plain, text);
        }
        let End::Surface(s) = &self.end else {
            line(depth + 1, Emphasis::Sum, format!("meets nothing: background {}", color(self.radiance)));
            return;
        };
        let primitive = if s.primitive > 0 { format!(" ({})", s.primitive) } else { String::new() };
        let side = if s.entering { "" } else { ", from inside" };
        let text = format!("hits {}{primitive} at t = {}{side}, error {:.1e}", s.object, number(s.t), s.error);
        line(depth + 1, Emphasis::Hit, text);
        let text = format!("at {}, normal {}", vector(s.point), vector(s.normal));
        line(depth + 1, Emphasis::Plain, text);
        let behind = s.beyond.as_ref().map_or(String::new(), |medium| format!(", behind it {medium}"));
        let text = format!("material {}, C = {}{behind}", s.material, color(s.color));
        line(depth + 1, Emphasis::Plain, text);
        let k = &s.coefficients;
        line(depth + 1, Emphasis::Term, format!("k_a I_a C = {} (k_a {})", color(s.ambient), number(k.k_a)));
        for light in &s.lights {
            let state = match (light.unasked, &light.shadow_of, light.behind) {
                (Some(codes), ..) => format!("not asked: at most {} codes", number(codes)),
                (.., true) => "behind the surface".into(),
                (_, Some(object), _) if light.part == 0.0 => format!("in shadow of {object}"),
                (_, Some(object), _) => format!("{} % through {object}", number(100.0 * light.part)),
                (_, None, _) if light.part == 0.0 => "in shadow".into(),
                (_, None, _) => format!("visible, cosine {}", number(light.cosine)),
            };
            line(depth + 1, Emphasis::Term, format!("light {}: {state}", light.light));
            if light.part != 0.0 {
                let text = format!("k_d I (n, l) C = {} (k_d {})", color(light.diffuse), number(k.k_d));
                line(depth + 2, Emphasis::Term, text);
                let of = format!("(k_s {}, s {})", number(k.k_s), number(k.shininess));
                line(depth + 2, Emphasis::Term, format!("k_s I (v, r)^s = {} {of}", color(light.specular)));
            }
        }
        for branch in &s.branches {
            match branch {
                Branch::Ray(ray) => ray.write(depth + 1, lines),
                Branch::Cut(cut) => {
                    lines.push(Line { depth: depth + 1, emphasis: Emphasis::Cut, text: cut.to_string() })
                }
            }
        }
        let text = format!("sum {}", color(self.radiance));
        lines.push(Line { depth: depth + 1, emphasis: Emphasis::Sum, text });
    }
}

/// A line of a ray tree in words.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Line {
    /// Steps to the right.
    pub depth: usize,
    /// What it is.
    pub emphasis: Emphasis,
    /// Safe to print.
    pub text: String,
}

/// What a line tells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Emphasis {
    /// A ray begins.
    Ray,
    /// It ends on something.
    Hit,
    /// A fact about that.
    Plain,
    /// A term of the sum.
    Term,
    /// Rays that were not followed.
    Cut,
    /// What comes back.
    Sum,
}

impl fmt::Display for RayTree {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for Line { depth, text, .. } in self.lines() {
            writeln!(f, "{}{text}", "  ".repeat(depth))?;
        }
        Ok(())
    }
}

impl fmt::Display for Medium {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = self.object.as_deref().unwrap_or("the world");
        write!(f, "{name} (index {})", number(self.ior))
    }
}

impl fmt::Display for Cut {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let what = match self.kind {
            None => "k_r I_r + k_t I_t",
            Some(RayKind::Refraction) => "k_t I_t",
            Some(_) => "k_r I_r",
        };
        let why = if self.depth { "max_depth is reached" } else { "weighs too little" };
        write!(f, "{what}: not followed{}, {why}", weight(self.weight))
    }
}

fn weight(weight: f64) -> String {
    format!(", weight {}", number(weight))
}

/// In six digits that count.
fn number(x: f64) -> String {
    if x == 0.0 || (1e-3..1e6).contains(&x.abs()) {
        let digits = 5 - (x.abs().max(1.0).log10() as i32).clamp(0, 5);
        let text = format!("{x:.*}", digits as usize);
        let short = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
        return short.into();
    }
    format!("{x:.3e}")
}

fn color(c: Rgb) -> String {
    format!("({:.5} {:.5} {:.5})", c.r, c.g, c.b)
}

fn vector([x, y, z]: [f64; 3]) -> String {
    format!("({} {} {})", number(x), number(y), number(z))
}
