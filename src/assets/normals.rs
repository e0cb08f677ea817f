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

    // Corners by place: `around[first[p]..first[p + 1]]` are those at place p.
    let mut first = vec![0_u32; places.len() + 2];
    for &i in indices {
        first[corners[i as usize].place as usize + 2] += 1;
    }
    for p in 2..first.len() {
        first[p] += first[p - 1];
    }
    let mut around = vec![0_u32; indices.len()];
    let mut face_normals = Vec::with_capacity(faces.len());
    // Face and its first corner, of each corner.
    let mut face_of = Vec::with_capacity(indices.len());
    let mut start = 0;
    for (number, face) in faces.iter().enumerate() {
        let range = start..start + face.corners;
        let points = range.clone().map(|i| polygons.position(i as usize));
        face_normals.push(newell_normal(points).normalize_or_zero().as_vec3());
        for i in range {
            let slot = &mut first[polygons.place(i as usize) as usize + 1];
            around[*slot as usize] = i;
            *slot += 1;
            face_of.push((number as u32, start));
        }
        start += face.corners;
    }

    let mut fan = Fan::new(crease);
    for range in first.windows(2).take(places.len()) {
        let at_place = &around[range[0] as usize..range[1] as usize];
        if at_place.iter().all(|&i| of_corners[i as usize] != Vec3::ZERO) {
            continue;
        }
        fan.spokes.clear();
        for &i in at_place {
            let (number, start) = face_of[i as usize];
            let face = faces[number as usize];
            let normal = face_normals[number as usize];
            if normal != Vec3::ZERO {
                fan.spokes.push(spoke(polygons, i, start, face.corners, normal, face.smoothing));
            }
        }
        fan.smooth(&mut of_corners);
    }
    Some(Normals { of_corners, computed: true })
}

fn spoke(polygons: &Polygons, corner: u32, start: u32, count: u32, normal: Vec3, smoothing: Smoothing) -> Spoke {
    let here = polygons.place(corner as usize);
    // The nearest corner in steps of `step` that is somewhere else; not looked for far, for this is asked at each.
    let other = |step: u32| {
        let mut at = corner - start;
        for _ in 1..count.min(8) {
            at = (at + step) % count;
            if polygons.place((start + at) as usize) != here {
                break;
            }
        }
        polygons.place((start + at) as usize)
    };
    let neighbours = [other(count - 1), other(1)];
    let [to, from] = neighbours.map(|p| polygons.places[p as usize].as_dvec3());
    let place = polygons.places[here as usize].as_dvec3();
    let (a, b) = (to - place, from - place);
    let cosine = a.dot(b) / (a.length_squared() * b.length_squared()).sqrt();
    let angle = if cosine.is_finite() { cosine.clamp(-1.0, 1.0).acos() as f32 } else { 0.0 };
    Spoke { corner, normal, angle, smoothing, neighbours }
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

    /// Sets the normals of the corners at this place that have none.
    fn smooth(&mut self, normals: &mut [Vec3]) {
        self.gather();
        self.sums.clear();
        self.sums.resize(self.spokes.len(), Vec3::ZERO);
        for i in 0..self.spokes.len() {
            let leader = self.find(i as u32);
            self.sums[leader as usize] += self.spokes[i].normal * self.spokes[i].angle;
        }
        for i in 0..self.spokes.len() {
            let Spoke { corner, normal, .. } = self.spokes[i];
            let target = &mut normals[corner as usize];
            if *target == Vec3::ZERO {
                let leader = self.find(i as u32);
                let mean = self.sums[leader as usize].normalize_or_zero();
                // Sheets back to back cancel; a normal that looks away from its own face is of no use.
                *target = if mean.dot(normal) > 1e-3 { mean } else { normal };
            }
        }
    }

    /// Finds out which spokes are smooth with which.
    fn gather(&mut self) {
        let count = self.spokes.len() as u32;
        self.leader.clear();
        let Some(first) = self.spokes.first() else { return };
        // On most places of most models all faces belong together.
        let alike = match first.smoothing {
            Smoothing::Flat => false,
            Smoothing::Group(_) => self.spokes.iter().all(|s| s.smoothing == first.smoothing),
            Smoothing::Crease => {
                let near = |s: &Spoke| s.smoothing == Smoothing::Crease && s.normal.dot(first.normal) >= self.cos_half;
                self.crease_is_smooth && self.spokes.iter().all(near)
            }
        };
        if alike {
            self.leader.resize(count as usize, 0);
            return;
        }
        self.leader.extend(0..count);
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
