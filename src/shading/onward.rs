//! How light goes on from surfaces, side by side in arrays: mirrored, and refracted where it gets behind them. The
//! loops become vector code (see [`Task`]); each surface gets the bits that it gets alone.

#![allow(clippy::needless_range_loop)] // Numbers of slots and axes run over several arrays at once.

use crate::bvh::{PACKET, RayPacket, Task, TreeKernels};
use crate::geometry::{fresnel, mirror, reflect, spawn_ray};
use crate::scene::{Material, SLOTS, Scene, Surfaces};
use glam::DVec3;
use std::marker::PhantomData;
use std::ops::Range;

/// Surfaces that light goes on from, in the slots of [`Surfaces`].
#[derive(Debug, Default)]
pub(super) struct Onward {
    /// Which ones, in order.
    pub slots: Vec<u16>,
    optics: Optics,
    ways: Ways,
}

/// What decides how light is divided.
#[derive(Debug)]
#[repr(align(64))]
struct Optics {
    /// k_r
    reflect: [f64; SLOTS],
    /// k_t
    transmit: [f64; SLOTS],
    /// Whether they are divided by Fresnel's equations.
    fresnel: [u8; SLOTS],
    /// Index before the surface over the one behind it.
    eta: [f64; SLOTS],
    /// Whether light may get behind it.
    is_glass: [u8; SLOTS],
}

impl Default for Optics {
    fn default() -> Self {
        let (zero, no) = ([0.0; SLOTS], [0; SLOTS]);
        Self { reflect: zero, transmit: zero, fresnel: no, eta: zero, is_glass: no }
    }
}

/// Where the light goes.
#[derive(Debug)]
#[repr(align(64))]
struct Ways {
    /// Weight of the mirrored ray.
    mirrored: [f64; SLOTS],
    /// Weight of the refracted ray.
    refracted: [f64; SLOTS],
    /// Whether there is one.
    is_refracted: [u8; SLOTS],
    mirrored_rays: RayPacket,
    refracted_rays: RayPacket,
}

impl Default for Ways {
    fn default() -> Self {
        Self {
            mirrored: [0.0; SLOTS],
            refracted: [0.0; SLOTS],
            is_refracted: [0; SLOTS],
            mirrored_rays: RayPacket::default(),
            refracted_rays: RayPacket::default(),
        }
    }
}

impl Onward {
    /// Takes in surfaces that light goes on from: all in these slots, which are of this material.
    pub fn take(&mut self, slots: Range<usize>, material: &Material) {
        let optics = &mut self.optics;
        self.slots.extend(slots.clone().map(|slot| slot as u16));
        optics.reflect[slots.clone()].fill(material.reflect);
        optics.transmit[slots.clone()].fill(material.transmit);
        optics.fresnel[slots.clone()].fill(material.fresnel.into());
        optics.is_glass[slots].fill(0);
    }

    /// Says that light may get behind a surface, and the index before it over the one behind it.
    pub fn put_glass(&mut self, slot: usize, eta: f64) {
        (self.optics.eta[slot], self.optics.is_glass[slot]) = (eta, 1);
    }

    /// Tells the index before an opaque surface over that of its varnish.
    pub fn put_varnish(&mut self, slot: usize, eta: f64) {
        self.optics.eta[slot] = eta;
    }

    /// Divides the light. `is_glass`: whether it may get behind any surface.
    pub fn divide<K: TreeKernels>(&mut self, scene: &Scene, surfaces: &Surfaces, is_glass: bool) {
        match (is_glass, surfaces.rows().is_smooth) {
            (false, false) => self.divide_as::<K, false, false>(scene, surfaces),
            (false, true) => self.divide_as::<K, false, true>(scene, surfaces),
            (true, false) => self.divide_as::<K, true, false>(scene, surfaces),
            (true, true) => self.divide_as::<K, true, true>(scene, surfaces),
        }
    }

    fn divide_as<K: TreeKernels, const GLASS: bool, const SMOOTH: bool>(&mut self, scene: &Scene, surfaces: &Surfaces) {
        let (Some(&first), Some(&last)) = (self.slots.first(), self.slots.last()) else { return };
        // Those between that light ends on are computed for nothing.
        let slots = usize::from(first)..usize::from(last) + 1;
        let optics = &self.optics;
        scene.run(Divide::<K, GLASS, SMOOTH> { slots, optics, kernels: PhantomData }, surfaces, &mut self.ways);
    }

    /// k_r + k_t
    pub fn gain(&self, slot: usize) -> f64 {
        self.optics.reflect[slot] + self.optics.transmit[slot]
    }

    /// Weight of the mirrored ray.
    pub fn mirrored(&self, slot: usize) -> f64 {
        self.ways.mirrored[slot]
    }

    /// Weight of the refracted ray, if there is one.
    pub fn refracted(&self, slot: usize) -> Option<f64> {
        (self.ways.is_refracted[slot] != 0).then_some(self.ways.refracted[slot])
    }

    /// The mirrored rays, by slot.
    pub fn mirrored_rays(&self) -> &RayPacket {
        &self.ways.mirrored_rays
    }

    /// The refracted rays, by slot.
    pub fn refracted_rays(&self) -> &RayPacket {
        &self.ways.refracted_rays
    }
}

/// Divides k_r and k_t of surfaces between the mirrored and the refracted ray. `GLASS`: whether light may get behind
/// them; `SMOOTH`: whether shading normals may differ from those of facets.
struct Divide<'a, K, const GLASS: bool, const SMOOTH: bool> {
    slots: Range<usize>,
    optics: &'a Optics,
    kernels: PhantomData<K>,
}

impl<K: TreeKernels, const GLASS: bool, const SMOOTH: bool> Task for Divide<'_, K, GLASS, SMOOTH> {
    type Input = Surfaces;
    type Output = Ways;

    #[inline(always)]
    fn run(self, surfaces: &Surfaces, ways: &mut Ways) {
        let Self { slots, optics, .. } = self;
        let (rows, [dx, dy, dz]) = (surfaces.rows(), surfaces.directions());
        for i in slots.start..slots.end.min(PACKET) {
            let direction = DVec3::new(dx[i], dy[i], dz[i]);
            let facet = rows.facet(i);
            let normal = if SMOOTH { rows.normal(i) } else { facet };
            let place = Place { direction, normal, facet, entering: rows.side(i) > 0.0 };
            let (k, fresnel) = ([optics.reflect[i], optics.transmit[i]], optics.fresnel[i] != 0);
            let mut split = place.split_opaque(k, fresnel, optics.eta[i]);
            if GLASS {
                let glass = place.split_glass::<K, SMOOTH>(k, fresnel, optics.eta[i], split.normal);
                split = if optics.is_glass[i] != 0 { glass } else { split };
            }
            let (point, normal, error) = (rows.point(i), rows.geometric_normal(i), rows.point_error(i));
            let way = if SMOOTH { reflect(direction, split.normal, facet) } else { mirror(direction, split.normal) };
            let mirrored = spawn_ray::<K>(point, normal, error, way);
            ways.mirrored[i] = split.reflect;
            ways.mirrored_rays.rows.put(i, &mirrored);
            if GLASS {
                let refracted = spawn_ray::<K>(point, normal, error, split.direction);
                (ways.refracted[i], ways.is_refracted[i]) = (split.transmit, split.is_refracted.into());
                ways.refracted_rays.rows.put(i, &refracted);
            }
        }
    }
}

/// Where a ray meets a surface. Normals are unit, on the viewer's side.
struct Place {
    direction: DVec3,
    /// For shading.
    normal: DVec3,
    facet: DVec3,
    /// Whether the ray goes into the body.
    entering: bool,
}

/// How light goes on at a surface. Numbers and directions mean nothing where there is no refracted ray.
#[derive(Clone, Copy)]
struct Split {
    /// The normal that both rays belong to: on the side of the viewer.
    normal: DVec3,
    /// Weight of the mirrored ray.
    reflect: f64,
    /// Weight of the refracted ray.
    transmit: f64,
    /// Its direction.
    direction: DVec3,
    is_refracted: bool,
}

impl Place {
    /// Where light does not get behind the surface: a mirror, or a varnish whose reflection follows Fresnel.
    #[inline(always)]
    fn split_opaque(&self, [reflect, _]: [f64; 2], fresnel: bool, eta: f64) -> Split {
        let Self { direction, .. } = *self;
        // Toward its silhouette a smooth surface may seem to face away.
        let normal = if direction.dot(self.normal) < 0.0 { self.normal } else { self.facet };
        let weight = if fresnel { reflectance(direction, normal, eta) } else { 1.0 };
        Split { normal, reflect: reflect * weight, transmit: 0.0, direction, is_refracted: false }
    }

    /// Where it may; `normal`: the one for shading, if that does not seem to face away.
    #[inline(always)]
    fn split_glass<K: TreeKernels, const SMOOTH: bool>(
        &self,
        [reflect, transmit]: [f64; 2],
        by_fresnel: bool,
        eta: f64,
        normal: DVec3,
    ) -> Split {
        let Self { direction, facet, entering, .. } = *self;
        // A smooth normal may bend the ray to the wrong side of the facet; the facet's own normal does not.
        let (bent, is_bent) = refract::<K>(direction, normal, eta, entering);
        let (mut onward, mut at, mut is_refracted) = (bent, normal, is_bent);
        if SMOOTH {
            let (plain, is_plain) = refract::<K>(direction, facet, eta, entering);
            let fits = (bent.dot(facet) < 0.0) | (normal == facet);
            (onward, at) = if fits { (bent, normal) } else { (plain, facet) };
            is_refracted = is_bent & (fits | is_plain);
        }
        let energy = reflect + transmit;
        let reflectance = fresnel(-direction.dot(at), -onward.dot(at), eta);
        let divided = [energy * reflectance, energy * (1.0 - reflectance)];
        let [mirrored, refracted] = if by_fresnel { divided } else { [reflect, transmit] };
        Split {
            normal: if is_refracted { at } else { normal },
            // All of it, where nothing gets through.
            reflect: if is_refracted { mirrored } else { energy },
            transmit: refracted,
            direction: onward,
            is_refracted,
        }
    }
}

/// The refracted direction, and whether there is one.
#[inline(always)]
fn refract<K: TreeKernels>(direction: DVec3, normal: DVec3, eta: f64, entering: bool) -> (DVec3, bool) {
    match K::refract(direction, normal, eta, entering) {
        Some(bent) => (bent, true),
        None => (direction, false),
    }
}

/// Fresnel's reflectance for a ray that meets an opaque surface.
#[inline(always)]
fn reflectance(direction: DVec3, normal: DVec3, eta: f64) -> f64 {
    let cos_in = -direction.dot(normal);
    let cos2_out = 1.0 - eta * eta * (1.0 - cos_in * cos_in);
    let partial = fresnel(cos_in, cos2_out.sqrt(), eta);
    if cos2_out < 0.0 { 1.0 } else { partial }
}
