//! Shading normals: the file's where it has them, else computed.
//!
//! The faces around a position are put together by smoothing group, or across edges that are not sharper than the
//! crease angle, and share the mean of their normals weighted by the angle that each spans there (Thuermer, Wuethrich
//! 1998), which does not depend on how a surface was cut into polygons. Positions count, not indices: exporters
//! double vertices along texture seams.

use super::mesh::Polygons;
use super::obj_outline::Smoothing;
use super::triangulate::newell_normal;
use crate::workers;
use glam::Vec3;
use std::num::NonZeroUsize;

/// Of more faces at one edge than this, only those near in the file are compared.
const EDGE_FACES: usize = 8;

/// A face as seen from one of its corners.
#[derive(Clone, Copy)]
struct Spoke {
    /// Which of the corners at the place.
    corner: u32,
    normal: Vec3,
    /// Angle that the face spans at the corner, radians.
    angle: f32,
    smoothing: Smoothing,
    /// Places of the corners before and after.
    neighbours: [u32; 2],
}

/// What is known of the faces before their corners are smoothed.
pub(super) struct Shape<'a> {
    polygons: &'a Polygons,
    /// Unit normal of each face, 0 if it has none. Arrays because memory of zeros for them comes free.
    normals: Vec<[f32; 3]>,
    /// Whether no normal is 0.
    pub is_complete: bool,
    /// Face of each corner; empty if all are triangles.
    faces: Vec<u32>,
    crease: f64,
}

/// Faces that a thread takes at a time.
const FACES: usize = 1 << 14;

impl<'a> Shape<'a> {
    /// `crease` in degrees.
    pub fn of(polygons: &'a Polygons, crease: f64, threads: NonZeroUsize) -> Self {
        let mut normals = vec![[0.0; 3]; polygons.faces.len()];
        let ranges = (0..).step_by(FACES).zip(normals.chunks_mut(FACES)).collect();
        let complete = workers::map(threads, ranges, |(first, normals): (usize, &mut [[f32; 3]])| {
            for (face, normal) in (first..).zip(normals.iter_mut()) {
                let points = polygons.corners_of(face).map(|i| polygons.position(i));
                *normal = newell_normal(points).normalize_or_zero().as_vec3().to_array();
            }
            normals.iter().all(|&n| n != [0.0; 3])
        });
        let is_complete = complete.into_iter().all(|complete| complete);
        let mut faces = Vec::new();
        if !polygons.are_triangles() {
            faces.reserve_exact(polygons.corners.places.len());
            for (number, face) in (0..).zip(0..polygons.faces.len()) {
                faces.resize(polygons.corners_of(face).end as usize, number);
            }
        }
        Self { polygons, normals, is_complete, faces, crease }
    }

    /// Unit normal of a face, 0 if it has none.
    pub fn normal(&self, face: usize) -> Vec3 {
        Vec3::from_array(self.normals[face])
    }

    fn face(&self, corner: u32) -> usize {
        (if self.faces.is_empty() { corner / 3 } else { self.faces[corner as usize] }) as usize
    }

    /// Places of the nearest corners before and after.
    fn neighbours(&self, corner: u32) -> [u32; 2] {
        if self.faces.is_empty() {
            let place = |turn: u32| self.polygons.place(corner / 3 * 3 + (corner % 3 + turn) % 3);
            let (here, before, after) = (place(0), place(2), place(1));
            return [if before == here { after } else { before }, if after == here { before } else { after }];
        }
        let range = self.polygons.corners_of(self.face(corner));
        neighbours(self.polygons, corner, range.start, range.end - range.start)
    }

    /// Angle at a corner, radians.
    fn angle(&self, corner: u32, neighbours: [u32; 2]) -> f32 {
        let [to, from] = neighbours.map(|p| self.polygons.places[p as usize].as_dvec3());
        let here = self.polygons.position(corner).as_dvec3();
        let (a, b) = (to - here, from - here);
        let cosine = a.dot(b) / (a.length_squared() * b.length_squared()).sqrt();
        // All corners in one place span nothing.
        if cosine.is_finite() { cosine.clamp(-1.0, 1.0).acos() as f32 } else { 0.0 }
    }
}

/// Places of the nearest corners before and after that are somewhere else. They are not looked for far, for this is
/// asked at each corner.
#[inline]
fn neighbours(polygons: &Polygons, corner: u32, start: u32, count: u32) -> [u32; 2] {
    let here = polygons.place(corner);
    let other = |back: bool| {
        let mut at = corner - start;
        let mut place = here;
        for _ in 1..count.min(8) {
            at = match (back, at) {
                (true, 0) => count - 1,
                (true, _) => at - 1,
                (false, _) if at + 1 == count => 0,
                (false, _) => at + 1,
            };
            place = polygons.place(start + at);
            if place != here {
                break;
            }
        }
        place
    };
    [other(true), other(false)]
}

/// The faces around one place, and working memory kept from place to place.
pub(super) struct Fan<'a> {
    shape: &'a Shape<'a>,
    spokes: Vec<Spoke>,
    /// Which spoke stands for the ones that a spoke is smooth with; union-find.
    leader: Vec<u32>,
    sums: Vec<Vec3>,
    /// (neighbouring place, spoke)
    edges: Vec<(u32, u32)>,
    /// (smoothing group, spoke)
    groups: Vec<(u32, u32)>,
    cos_crease: f32,
    cos_half: f32,
    crease_is_smooth: bool,
}

impl<'a> Fan<'a> {
    /// Working memory for the places of a shape.
    pub fn new(shape: &'a Shape<'a>) -> Self {
        // Edges exactly at the angle count as smooth, whatever the rounding.
        let cosine = |degrees: f64| (degrees.clamp(0.0, 180.0).to_radians().cos() - 1e-6) as f32;
        Self {
            shape,
            spokes: Vec::new(),
            leader: Vec::new(),
            sums: Vec::new(),
            edges: Vec::new(),
            groups: Vec::new(),
            cos_crease: cosine(shape.crease),
            cos_half: cosine(shape.crease / 2.0),
            crease_is_smooth: shape.crease > 0.0,
        }
    }

    /// Sets those `normals` of the corners at a place that are 0. They stay 0 where the face has none.
    pub fn smooth(&mut self, corners: &[u32], normals: &mut [Vec3]) {
        if !self.smooth_as_one(corners, normals) {
            self.smooth_in_parts(corners, normals);
        }
    }

    /// On most places of most models all faces belong together: sets the missing normals if that is so.
    fn smooth_as_one(&self, corners: &[u32], normals: &mut [Vec3]) -> bool {
        let shape = self.shape;
        let Some(&corner) = corners.first() else { return true };
        let first = shape.face(corner);
        let (smoothing, first_normal) = (shape.polygons.smoothing(first), shape.normal(first));
        if smoothing == Smoothing::Flat || smoothing == Smoothing::Crease && !self.crease_is_smooth {
            return false;
        }
        let is_near = |&corner: &u32| {
            let face = shape.face(corner);
            shape.polygons.smoothing(face) == smoothing
                && (smoothing != Smoothing::Crease || shape.normal(face).dot(first_normal) >= self.cos_half)
        };
        // Asked first because angles take long.
        if !corners.iter().all(is_near) {
            return false;
        }
        let mut sum = Vec3::ZERO;
        for &corner in corners {
            sum += shape.normal(shape.face(corner)) * shape.angle(corner, shape.neighbours(corner));
        }
        let mean = sum.normalize_or_zero();
        for (&corner, normal) in corners.iter().zip(normals) {
            set_missing(normal, mean, shape.normal(shape.face(corner)));
        }
        true
    }

    /// Finds out which faces belong together and sets the missing normals.
    fn smooth_in_parts(&mut self, corners: &[u32], normals: &mut [Vec3]) {
        let shape = self.shape;
        self.spokes.clear();
        self.spokes.extend((0..).zip(corners).filter_map(|(number, &corner)| {
            let face = shape.face(corner);
            let normal = shape.normal(face);
            let neighbours = shape.neighbours(corner);
            (normal != Vec3::ZERO).then(|| Spoke {
                corner: number,
                normal,
                angle: shape.angle(corner, neighbours),
                smoothing: shape.polygons.smoothing(face),
                neighbours,
            })
        }));
        self.join_spokes();
        self.sums.clear();
        self.sums.resize(self.spokes.len(), Vec3::ZERO);
        for i in 0..self.spokes.len() {
            let leader = self.find(i as u32);
            self.sums[leader as usize] += self.spokes[i].normal * self.spokes[i].angle;
        }
        for i in 0..self.spokes.len() {
            let leader = self.find(i as u32);
            let mean = self.sums[leader as usize].normalize_or_zero();
            let Spoke { corner, normal, .. } = self.spokes[i];
            set_missing(&mut normals[corner as usize], mean, normal);
        }
    }

    fn join_spokes(&mut self) {
        self.leader.clear();
        self.leader.extend(0..self.spokes.len() as u32);
        self.edges.clear();
        self.groups.clear();
        for (spoke, i) in self.spokes.iter().zip(0..) {
            match spoke.smoothing {
                Smoothing::Group(group) => self.groups.push((group, i)),
                Smoothing::Crease if self.crease_is_smooth => {
                    self.edges.extend(spoke.neighbours.map(|place| (place, i)));
                }
                _ => {}
            }
        }
        self.groups.sort_unstable();
        for k in 1..self.groups.len() {
            let (before, this) = (self.groups[k - 1], self.groups[k]);
            if before.0 == this.0 {
                self.join(before.1, this.1);
            }
        }
        self.edges.sort_unstable();
        for k in 0..self.edges.len() {
            let (place, i) = self.edges[k];
            for m in k + 1..self.edges.len().min(k + EDGE_FACES) {
                let (other, j) = self.edges[m];
                if other != place {
                    break;
                }
                if self.spokes[i as usize].normal.dot(self.spokes[j as usize].normal) >= self.cos_crease {
                    self.join(i, j);
                }
            }
        }
    }

    fn find(&mut self, mut i: u32) -> u32 {
        while self.leader[i as usize] != i {
            let above = self.leader[self.leader[i as usize] as usize];
            self.leader[i as usize] = above;
            i = above;
        }
        i
    }

    fn join(&mut self, i: u32, j: u32) {
        let (i, j) = (self.find(i), self.find(j));
        self.leader[i.max(j) as usize] = i.min(j);
    }
}

/// Sets a normal that is 0 to the mean around it, unless that is of no use: sheets back to back cancel, and a normal
/// must not look away from its own face.
fn set_missing(target: &mut Vec3, mean: Vec3, own: Vec3) {
    if *target == Vec3::ZERO {
        *target = if mean.dot(own) > 1e-3 { mean } else { own };
    }
}
