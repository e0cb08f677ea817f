//! Surfaces and the light that falls on them, side by side in arrays. The loops become vector code (see
//! [`Task`](crate::bvh::Task)); each surface gets the bits that it gets alone.

#![allow(clippy::needless_range_loop)] // Numbers of slots and axes run over several arrays at once.

use super::sampler::terms;
use crate::bvh::{PACKET, RayPacket, Task, TreeKernels};
use crate::description::{Falloff, LightKind};
use crate::geometry::ShadowStart;
use crate::math::Rgb;
use crate::scene::{Illumination, Light, Material, SLOTS, Surfaces};
use glam::DVec3;
use std::marker::PhantomData;
use std::ops::Range;

/// Surfaces that light can fall on, in the slots of [`Surfaces`].
#[derive(Debug)]
#[repr(align(64))]
pub(super) struct Lit {
    pub count: usize,
    /// Runs of surfaces that are alike in whether they have highlights, one after the other.
    runs: Vec<(Range<usize>, bool)>,
    /// C
    pub color: [[f64; SLOTS]; 3],
    /// k_a
    ambient: [f64; SLOTS],
    /// k_d
    diffuse: [f64; SLOTS],
    /// k_s
    specular: [f64; SLOTS],
    /// s
    shininess: [f64; SLOTS],
    /// Of the paths that end there.
    pub weight: [f64; SLOTS],
    point: [[f64; SLOTS]; 3],
    /// Where shadow rays start.
    start: [[f64; SLOTS]; 3],
    /// Unit, on the viewer's side.
    normal: [[f64; SLOTS]; 3],
    /// Unit, toward the viewer.
    view: [[f64; SLOTS]; 3],
    /// What they send out so far.
    sums: [[f64; SLOTS]; 3],
}

impl Default for Lit {
    fn default() -> Self {
        let zero = [0.0; SLOTS];
        Self {
            count: 0,
            runs: Vec::new(),
            color: [zero; 3],
            ambient: zero,
            diffuse: zero,
            specular: zero,
            shininess: zero,
            weight: zero,
            point: [zero; 3],
            start: [zero; 3],
            normal: [zero; 3],
            view: [zero; 3],
            sums: [zero; 3],
        }
    }
}

/// Light on its way to surfaces, slot by slot.
#[derive(Debug)]
#[repr(align(64))]
pub(super) struct Beams {
    /// Unit, toward the light.
    direction: [[f64; SLOTS]; 3],
    /// Of the angle to the normal.
    cosine: [f64; SLOTS],
    radiance: [[f64; SLOTS]; 3],
    /// Diffuse light that it brings to the sample at most, if that is asked for.
    most: [f64; SLOTS],
    /// Whether the light falls on the surface.
    reaches: [u8; SLOTS],
    /// Whether there is a shadow ray.
    has_ray: [u8; SLOTS],
    /// The part of it that arrives.
    pub part: [f64; SLOTS],
    /// Toward the light: first slot by slot, then those only that are traced.
    pub shadow_rays: RayPacket,
}

impl Default for Beams {
    fn default() -> Self {
        let zero = [0.0; SLOTS];
        Self {
            direction: [zero; 3],
            cosine: zero,
            radiance: [zero; 3],
            most: zero,
            reaches: [0; SLOTS],
            has_ray: [0; SLOTS],
            part: zero,
            shadow_rays: RayPacket::default(),
        }
    }
}

/// A surface that light can fall on.
#[derive(Clone, Copy)]
pub(super) struct LitSurface {
    pub color: Rgb,
    diffuse: f64,
    specular: f64,
    shininess: f64,
    normal: DVec3,
    view: DVec3,
}

/// Light on its way to a surface in front of it.
#[derive(Clone, Copy)]
pub(super) struct Beam {
    direction: DVec3,
    /// Of the angle to the normal.
    pub cosine: f64,
    pub radiance: Rgb,
    /// The part of it that arrives.
    pub part: f64,
}

impl LitSurface {
    /// k_d (n, l) C
    #[inline(always)]
    pub fn diffuse(&self, beam: &Beam) -> Rgb {
        self.color * (self.diffuse * beam.cosine)
    }

    /// k_s (v, r)^s
    #[inline(always)]
    pub fn highlight<K: TreeKernels>(&self, beam: &Beam) -> f64 {
        let mirrored = self.normal * (2.0 * beam.cosine) - beam.direction;
        self.specular * K::highlight(mirrored.dot(self.view), self.shininess)
    }

    /// Whether light that falls on it comes back.
    #[inline(always)]
    pub fn responds<const TERMS: u8>(&self) -> bool {
        (self.diffuse != 0.0) | (TERMS & terms::HIGHLIGHTS != 0 && self.specular > 0.0)
    }

    /// Whether it has highlights.
    #[inline(always)]
    pub fn shines<const TERMS: u8>(&self) -> bool {
        TERMS & terms::HIGHLIGHTS != 0 && self.specular > 0.0
    }

    /// I k_d (n, l) C + I k_s (v, r)^s, as it arrives.
    #[inline(always)]
    pub fn response<K: TreeKernels, const TERMS: u8>(&self, beam: &Beam) -> Rgb {
        let diffuse = self.diffuse(beam);
        let response = if TERMS & terms::HIGHLIGHTS != 0 {
            // In one piece, so that loops over surfaces become vector code.
            let specular = self.highlight::<K>(beam);
            diffuse + Rgb::grey(if self.specular > 0.0 { specular } else { 0.0 })
        } else {
            diffuse
        };
        beam.radiance * response * beam.part
    }
}

#[inline(always)]
fn vector(from: &[[f64; SLOTS]; 3], i: usize) -> DVec3 {
    DVec3::new(from[0][i], from[1][i], from[2][i])
}

#[inline(always)]
fn color(from: &[[f64; SLOTS]; 3], i: usize) -> Rgb {
    Rgb::new(from[0][i], from[1][i], from[2][i])
}

#[inline(always)]
fn put(to: &mut [[f64; SLOTS]; 3], i: usize, v: DVec3) {
    (to[0][i], to[1][i], to[2][i]) = (v.x, v.y, v.z);
}

#[inline(always)]
fn put_color(to: &mut [[f64; SLOTS]; 3], i: usize, c: Rgb) {
    (to[0][i], to[1][i], to[2][i]) = (c.r, c.g, c.b);
}

impl Lit {
    /// Forgets all surfaces.
    pub fn clear(&mut self) {
        self.runs.clear();
    }

    /// Says what the surfaces in the next slots are made of; `None`: they are not there.
    pub fn made_of(&mut self, slots: Range<usize>, material: Option<&Material>) {
        let shine = material.is_some_and(|material| material.specular > 0.0);
        match self.runs.last_mut() {
            Some((last, of_last)) if *of_last == shine => last.end = slots.end,
            _ => self.runs.push((slots.clone(), shine)),
        }
        let of = |coefficient: fn(&Material) -> f64| material.map_or(0.0, coefficient);
        self.ambient[slots.clone()].fill(of(|m| m.ambient));
        self.diffuse[slots.clone()].fill(of(|m| m.diffuse));
        self.specular[slots.clone()].fill(of(|m| m.specular));
        self.shininess[slots].fill(of(|m| m.shininess));
    }

    /// What a surface sends out so far.
    pub fn sum(&self, slot: usize) -> Rgb {
        color(&self.sums, slot)
    }

    /// One of the surfaces.
    #[inline(always)]
    pub fn get(&self, slot: usize) -> LitSurface {
        LitSurface {
            color: color(&self.color, slot),
            diffuse: self.diffuse[slot],
            specular: self.specular[slot],
            shininess: self.shininess[slot],
            normal: vector(&self.normal, slot),
            view: vector(&self.view, slot),
        }
    }
}

impl Beams {
    /// The light on its way to one of the surfaces.
    #[inline(always)]
    pub fn get(&self, slot: usize) -> Beam {
        Beam {
            direction: vector(&self.direction, slot),
            cosine: self.cosine[slot],
            radiance: color(&self.radiance, slot),
            part: self.part[slot],
        }
    }

    /// Whether the light falls on a surface.
    #[inline(always)]
    pub fn reaches(&self, slot: usize) -> bool {
        self.reaches[slot] != 0
    }

    /// Whether there is a shadow ray for a surface. None is needed where the light itself is.
    #[inline(always)]
    pub fn has_ray(&self, slot: usize) -> bool {
        self.has_ray[slot] != 0
    }

    /// Diffuse light that comes to the sample at most, as [`Shine`] has found it.
    #[inline(always)]
    pub fn most(&self, slot: usize) -> f64 {
        self.most[slot]
    }
}

/// Turns surfaces toward the viewer and gives them the ambient light k_a I_a C.
pub(super) struct Begin {
    /// I_a
    pub ambient: Rgb,
}

impl Task for Begin {
    type Input = Surfaces;
    type Output = Lit;

    #[inline(always)]
    fn run(self, surfaces: &Surfaces, lit: &mut Lit) {
        let (rows, directions, ambient) = (surfaces.rows(), surfaces.directions(), self.ambient);
        lit.count = rows.count.min(PACKET);
        for i in 0..lit.count {
            put(&mut lit.point, i, rows.point(i));
            put(&mut lit.start, i, rows.shadow_start(i).point());
            put(&mut lit.normal, i, rows.normal(i));
            put(&mut lit.view, i, -vector(directions, i));
        }
        for i in 0..lit.count {
            put_color(&mut lit.sums, i, ambient * color(&lit.color, i) * lit.ambient[i]);
        }
    }
}

/// Sends light to all surfaces that it is in front of.
pub(super) struct Shine<K, const TERMS: u8> {
    pub light: Light,
    /// Whether it is to be known how much it brings at most.
    pub spare: bool,
    pub kernels: PhantomData<K>,
}

impl<K: TreeKernels, const TERMS: u8> Task for Shine<K, TERMS> {
    type Input = Lit;
    type Output = Beams;

    #[inline(always)]
    fn run(self, lit: &Lit, beams: &mut Beams) {
        let Light { kind, radiance } = self.light;
        // Loops for each kind, so that none asks for it surface by surface.
        match kind {
            LightKind::Directional { .. } => shine::<K, TERMS>(Light { kind, radiance }, lit, beams),
            LightKind::Point { position, falloff: Falloff::None } => {
                let kind = LightKind::Point { position, falloff: Falloff::None };
                shine::<K, TERMS>(Light { kind, radiance }, lit, beams);
            }
            LightKind::Point { position, falloff: Falloff::InverseSquare } => {
                let kind = LightKind::Point { position, falloff: Falloff::InverseSquare };
                shine::<K, TERMS>(Light { kind, radiance }, lit, beams);
            }
        }
        for i in 0..lit.count.min(PACKET) {
            beams.reaches[i] &= u8::from(lit.get(i).responds::<TERMS>());
        }
        if self.spare {
            for i in 0..lit.count.min(PACKET) {
                let (surface, beam) = (lit.get(i), beams.get(i));
                beams.most[i] = lit.weight[i] * (beam.radiance * surface.diffuse(&beam)).largest();
            }
        }
    }
}

#[inline(always)]
fn shine<K: TreeKernels, const TERMS: u8>(light: Light, lit: &Lit, beams: &mut Beams) {
    for i in 0..lit.count.min(PACKET) {
        let (Illumination { direction, radiance, .. }, is_apart) = light.shine(vector(&lit.point, i));
        let cosine = vector(&lit.normal, i).dot(direction);
        put(&mut beams.direction, i, direction);
        put_color(&mut beams.radiance, i, radiance);
        (beams.cosine[i], beams.part[i]) = (cosine, 0.0);
        // What is not a number reaches the sample, which is counted then.
        let behind = cosine <= 0.0;
        beams.reaches[i] = u8::from(is_apart & !behind);
    }
    if TERMS & terms::SHADOWS == 0 {
        return;
    }
    for i in 0..lit.count.min(PACKET) {
        let start = ShadowStart::at(vector(&lit.start, i));
        let (ray, has_ray) = match light.kind {
            LightKind::Directional { direction } => (start.ray_along::<K>(-direction), true),
            LightKind::Point { position, .. } => match start.ray_to::<K>(position) {
                Some(ray) => (ray, true),
                None => (start.ray_along::<K>(DVec3::Y), false),
            },
        };
        beams.shadow_rays.rows.put(i, &ray);
        beams.has_ray[i] = u8::from(has_ray);
    }
}

/// Adds what arrives of beams to what surfaces send out.
pub(super) struct Respond<K, const TERMS: u8>(pub PhantomData<K>);

impl<K: TreeKernels, const TERMS: u8> Task for Respond<K, TERMS> {
    type Input = Beams;
    type Output = Lit;

    #[inline(always)]
    fn run(self, beams: &Beams, lit: &mut Lit) {
        for run in 0..lit.runs.len() {
            let (slots, shine) = lit.runs[run].clone();
            // Powers only where there are highlights.
            if shine && TERMS & terms::HIGHLIGHTS != 0 {
                respond::<K, TERMS>(slots, beams, lit);
            } else {
                respond::<K, 0>(slots, beams, lit);
            }
        }
    }
}

#[inline(always)]
fn respond<K: TreeKernels, const TERMS: u8>(slots: Range<usize>, beams: &Beams, lit: &mut Lit) {
    for i in slots.start..slots.end.min(PACKET) {
        let (surface, beam, sum) = (lit.get(i), beams.get(i), color(&lit.sums, i));
        let response = surface.response::<K, TERMS>(&beam);
        // Not 0 times what arrives, which may be infinite.
        let added = if beam.part != 0.0 { sum + response } else { sum };
        put_color(&mut lit.sums, i, added);
    }
}
