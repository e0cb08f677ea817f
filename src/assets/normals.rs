//! Shading normals: the file's where it has them, else computed.
//!
//! The faces around a position are put together by smoothing group, or across edges that are not sharper than the
//! crease angle, and share the mean of their normals weighted by the angle that each spans there (Thuermer, Wuethrich
//! 1998), which does not depend on how a surface was cut into polygons. Positions count, not indices: exporters
//! double vertices along texture seams.

use super::mesh::Polygons;
use super::obj_clean::Smoothing;
use super::triangulate::newell_normal;
use glam::Vec3;

/// Normals of all corners.
pub(super) struct Normals {
    /// Unit normal of each corner, in the order of [`Polygons::indices`].
    pub of_corners: Vec<Vec3>,
    /// Whether any of them was computed.
    pub computed: bool,
}

/// Of more faces at one edge than this, only those near in the file are compared.
const EDGE_FACES: usize = 8;

/// A face as seen from one of its corners.
#[derive(Clone, Copy)]
struct Spoke {
    corner: u32,
    normal: Vec3,
    /// Angle that the face spans at the corner, radians.
    angle: f32,
    smoothing: Smoothing,
    /// Places of the corners before and after.
    neighbours: [u32; 2],
}

/// What is known of the faces before their corners are smoothed.
struct Shape {
    /// Unit normal of each face, 0 if it has none.
    normals: Vec<Vec3>,
    /// First corner of each face.
    starts: Vec<u32>,
    /// Face of each corner.
    faces: Vec<u32>,
    /// Angle at each corner, radians.
    angles: Vec<f32>,
}

/// Normals of all corners; `None` if the file has none and wants every face flat. `crease` in degrees.
pub(super) fn corner_normals(polygons: &Polygons, crease: f64) -> Option<Normals> {
    let Polygons { places, corners, indices, faces } = polygons;
    let is_smooth = |s: Smoothing| match s {
        Smoothing::Flat => false,
        Smoothing::Crease => crease > 0.0,
        Smoothing::Group(_) => true,
    };
    let mut of_corners: Vec<Vec3> = indices.iter().map(|&i| corners[i as usize].normal).collect();
    if of_corners.iter().all(|&n| n != Vec3::ZERO) {
        return Some(Normals { of_corners, computed: false });
    }
    if of_corners.iter().all(|&n| n == Vec3::ZERO) && !faces.iter().any(|f| is_smooth(f.smoothing)) {
        return None;
    }

    let shape = Shape::of(polygons);
    // Corners by place: `around[first[p]..first[p + 1]]` are those at place p.
    let mut first = vec![0_u32; places.len() + 2];
    for &i in indices {
        first[corners[i as usize].place as usize + 2] += 1;
    }
    for p in 2..first.len() {
        first[p] += first[p - 1];
    }
    let mut around = vec![0_u32; indices.len()];
    for (i, &corner) in (0..).zip(indices) {
        let slot = &mut first[corners[corner as usize].place as usize + 1];
        around[*slot as usize] = i;
        *slot += 1;
    }
    let mut fan = Fan::new(crease);
    for range in first.windows(2).take(places.len()) {
        let at_place = &around[range[0] as usize..range[1] as usize];
        if !fan.smooth_as_one(at_place, polygons, &shape, &mut of_corners) {
            fan.smooth_in_parts(at_place, polygons, &shape, &mut of_corners);
        }
    }
    Some(Normals { of_corners, computed: true })
}

impl Shape {
    fn of(polygons: &Polygons) -> Self {
        let (corners, faces) = (polygons.indices.len(), polygons.faces.len());
        let mut shape = Self {
            normals: Vec::with_capacity(faces),
            starts: Vec::with_capacity(faces),
            faces: Vec::with_capacity(corners),
            angles: Vec::with_capacity(corners),
        };
        let mut start = 0;
        for (number, face) in (0..).zip(&polygons.faces) {
            let range = start..start + face.corners;
            let points = range.clone().map(|i| polygons.position(i as usize));
            shape.normals.push(newell_normal(points).normalize_or_zero().as_vec3());
            shape.starts.push(start);
            shape.faces.extend(range.clone().map(|_| number));
            shape.angles.extend(range.map(|i| {
                let places = neighbours(polygons, i, start, face.corners);
                let [to, from] = places.map(|p| polygons.places[p as usize].as_dvec3());
                let here = polygons.position(i as usize).as_dvec3();
                let (a, b) = (to - here, from - here);
                let cosine = a.dot(b) / (a.length_squared() * b.length_squared()).sqrt();
                // All corners in one place span nothing.
                if cosine.is_finite() { cosine.clamp(-1.0, 1.0).acos() as f32 } else { 0.0 }
            }));
            start += face.corners;
        }
        shape
    }
}

/// Places of the nearest corners before and after that are somewhere else. They are not looked for far, for this is
/// asked at each corner.
#[inline]
fn neighbours(polygons: &Polygons, corner: u32, start: u32, count: u32) -> [u32; 2] {
    let here = polygons.place(corner as usize);
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
            place = polygons.place((start + at) as usize);
            if place != here {
                break;
            }
        }
        place
    };
    [other(true), other(false)]
}

/// The faces around one place, and working memory kept from place to place.
struct Fan {
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

impl Fan {
    fn new(crease: f64) -> Self {
        // Edges exactly at the angle count as smooth, whatever the rounding.
        let cosine = |degrees: f64| (degrees.clamp(0.0, 180.0).to_radians().cos() - 1e-6) as f32;
        Self {
            spokes: Vec::new(),
            leader: Vec::new(),
            sums: Vec::new(),
            edges: Vec::new(),
            groups: Vec::new(),
            cos_crease: cosine(crease),
            cos_half: cosine(crease / 2.0),
            crease_is_smooth: crease > 0.0,
        }
    }

    /// On most places of most models all faces belong together: sets the missing normals if that is so.
    fn smooth_as_one(&self, at_place: &[u32], polygons: &Polygons, shape: &Shape, normals: &mut [Vec3]) -> bool {
        let Some(&corner) = at_place.first() else { return true };
        let first = shape.faces[corner as usize] as usize;
        let (smoothing, first_normal) = (polygons.faces[first].smoothing, shape.normals[first]);
        if smoothing == Smoothing::Flat || smoothing == Smoothing::Crease && !self.crease_is_smooth {
            return false;
        }
        let mut sum = Vec3::ZERO;
        for &i in at_place {
            let face = shape.faces[i as usize] as usize;
            let normal = shape.normals[face];
            let near = smoothing != Smoothing::Crease || normal.dot(first_normal) >= self.cos_half;
            if polygons.faces[face].smoothing != smoothing || !near {
                return false;
            }
            sum += normal * shape.angles[i as usize];
        }
        let mean = sum.normalize_or_zero();
        for &i in at_place {
            set_missing(&mut normals[i as usize], mean, shape.normals[shape.faces[i as usize] as usize]);
        }
        true
    }

    /// Finds out which faces belong together and sets the missing normals.
    fn smooth_in_parts(&mut self, at_place: &[u32], polygons: &Polygons, shape: &Shape, normals: &mut [Vec3]) {
        self.spokes.clear();
        self.spokes.extend(at_place.iter().filter_map(|&corner| {
            let number = shape.faces[corner as usize] as usize;
            let (face, normal) = (polygons.faces[number], shape.normals[number]);
            (normal != Vec3::ZERO).then(|| Spoke {
                corner,
                normal,
                angle: shape.angles[corner as usize],
                smoothing: face.smoothing,
                neighbours: neighbours(polygons, corner, shape.starts[number], face.corners),
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
