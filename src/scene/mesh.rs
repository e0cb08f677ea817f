//! Triangle meshes with their trees, in object space.

use super::Shell;
use crate::assets::{ImportReport, Model};
use crate::bvh::{BvhStats, Isa, PacketRoom, Rays, TreeKernels, TriangleHit, Triangles};
use crate::description::MaterialDesc;
use crate::geometry::{Aabb, Ray, SurfacePoint, sphere_uv, triangle_surface};
use crate::workers;
use glam::{DVec2, DVec3, Vec2, Vec3};
use std::num::NonZeroUsize;
use std::path::PathBuf;
use std::sync::OnceLock;

/// A mesh about its own centre: its object space is the file's, moved by -`centre`.
#[derive(Debug)]
pub struct Mesh {
    /// Centre of the model's box in the space of the file.
    pub centre: DVec3,
    /// Materials of the file.
    pub materials: Vec<MaterialDesc>,
    /// The material libraries that it was read with.
    pub libraries: Vec<PathBuf>,
    /// What importing found.
    pub report: ImportReport,
    /// Enclosed volume, 0 or more.
    pub volume: f64,
    pub(super) positions: Vec<Vec3>,
    normals: Vec<Vec3>,
    uvs: Vec<Vec2>,
    pub(super) triangles: Vec<[u32; 3]>,
    triangle_materials: Vec<u32>,
    /// See [`Mesh::shells`].
    pub(super) shells: OnceLock<Vec<Shell>>,
    tree: Triangles,
    /// Of the tree: walking it takes milliseconds where there are a million triangles.
    stats: BvhStats,
}

impl Mesh {
    /// Builds the tree. A mesh that is inside out as a whole is turned: its signed volume tells.
    pub fn new(model: Model, isa: Isa, threads: NonZeroUsize) -> Self {
        let Model { centre, positions, normals, uvs, mut triangles, triangle_materials, materials, libraries, report } =
            model;
        let corners_of = |t: &[u32; 3]| t.map(|i| positions[i as usize]);
        let signed_volume_of = |t: &[u32; 3]| {
            let [a, b, c] = corners_of(t).map(|p| p.as_dvec3());
            a.dot(b.cross(c)) / 6.0
        };
        // Pieces of one size, so that the sum does not depend on the number of threads.
        let pieces = triangles.chunks(1 << 14).collect();
        let volumes = workers::map(threads, pieces, |piece| piece.iter().map(signed_volume_of).sum::<f64>());
        let signed_volume: f64 = volumes.into_iter().sum();
        if signed_volume < 0.0 {
            triangles.iter_mut().for_each(|t| t.swap(1, 2));
        }
        let tree = Triangles::build(triangles.len(), |i| corners_of(&triangles[i]), isa, threads);
        let volume = signed_volume.abs();
        let stats = tree.stats();
        Self {
            stats,
            centre,
            materials,
            libraries,
            report,
            volume,
            positions,
            normals,
            uvs,
            triangles,
            triangle_materials,
            shells: OnceLock::new(),
            tree,
        }
    }

    /// How many triangles there are.
    pub fn len(&self) -> usize {
        self.triangles.len()
    }

    /// Whether there is no triangle.
    pub fn is_empty(&self) -> bool {
        self.triangles.is_empty()
    }

    /// Its box in object space.
    pub fn bounds(&self) -> Aabb {
        self.tree.tree().bounds()
    }

    /// Describes the tree.
    pub fn stats(&self) -> BvhStats {
        self.stats
    }

    /// Index of a triangle's material among the file's.
    pub fn material_of(&self, triangle: u32) -> u32 {
        self.triangle_materials.get(triangle as usize).copied().unwrap_or(0)
    }

    /// The corners of a triangle, counter-clockwise from outside.
    pub fn corners(&self, triangle: u32) -> [DVec3; 3] {
        self.triangles[triangle as usize].map(|i| self.positions[i as usize].as_dvec3())
    }

    /// Outward normal of a triangle, not of unit length.
    pub fn normal_of(&self, triangle: u32) -> DVec3 {
        let [a, b, c] = self.corners(triangle);
        (b - a).cross(c - a)
    }

    /// Whether triangles have shading normals.
    pub fn is_smooth(&self) -> bool {
        !self.normals.is_empty()
    }

    /// The shading normals of a triangle's corners; `None` if it is flat.
    pub fn shading_normals(&self, triangle: u32) -> Option<[DVec3; 3]> {
        self.is_smooth().then(|| self.triangles[triangle as usize].map(|i| self.normals[i as usize].as_dvec3()))
    }

    /// The closest hit of a ray of object space; of hits at the same t the smallest index.
    #[inline(always)]
    pub fn intersect<K: TreeKernels>(&self, ray: &Ray) -> Option<TriangleHit> {
        self.tree.intersect::<K>(ray)
    }

    /// Whether a ray of object space meets any triangle.
    #[inline(always)]
    pub fn occluded<K: TreeKernels>(&self, ray: &Ray) -> bool {
        self.tree.occluded::<K>(ray)
    }

    /// Nodes and blocks of triangles that a ray of object space looks at; with `any`, until it meets one.
    pub fn visits<K: TreeKernels>(&self, ray: &Ray, any: bool) -> u64 {
        self.tree.visits::<K>(ray, any)
    }

    /// See [`Triangles::intersect_packet`].
    pub(super) fn intersect_packet<K: TreeKernels>(
        &self,
        rays: &impl Rays,
        room: &mut PacketRoom,
        found: impl FnMut(usize, Option<TriangleHit>),
    ) {
        self.tree.intersect_packet::<K>(rays, room, found);
    }

    /// See [`Triangles::occluded_packet`].
    pub(super) fn occluded_packet<K: TreeKernels>(
        &self,
        rays: &impl Rays,
        room: &mut PacketRoom,
        found: impl FnMut(usize),
    ) {
        self.tree.occluded_packet::<K>(rays, room, found);
    }

    /// The surface at weights u, v of the second and third corner: on the facet's plane to within rounding.
    pub fn surface(&self, triangle: u32, u: f64, v: f64) -> SurfacePoint {
        triangle_surface(self.corners(triangle), u, v)
    }

    /// Whether the file has texture coordinates.
    pub fn has_uv(&self) -> bool {
        !self.uvs.is_empty()
    }

    /// Texture coordinates at these weights: the file's, or longitude and latitude about the centre.
    pub fn uv(&self, triangle: u32, u: f64, v: f64) -> DVec2 {
        if !self.has_uv() {
            return sphere_uv(self.surface(triangle, u, v).point);
        }
        let [a, b, c] = self.triangles[triangle as usize].map(|i| self.uvs[i as usize].as_dvec2());
        a + (b - a) * u + (c - a) * v
    }
}
