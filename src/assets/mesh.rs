//! Polygons to triangles: degenerate and doubled ones dropped, corners merged into vertices.

use super::intern::Interner;
use super::normals::corner_normals;
use super::obj_clean::Face;
use super::triangulate::{MAX_CONCAVE, Outcome, Triangulator, is_degenerate};
use glam::{DVec3, Vec2, Vec3};

/// What polygon corners refer to.
#[derive(Clone, Copy)]
pub(super) struct Corner {
    /// Index into [`Polygons::places`].
    pub place: u32,
    /// The file's normal, unit length; 0 if there is none of use.
    pub normal: Vec3,
    /// Texture coordinates; 0 if there are none.
    pub uv: Vec2,
}

/// Polygons as the file has them.
pub(super) struct Polygons {
    /// Distinct positions.
    pub places: Vec<Vec3>,
    /// Distinct corners, more or less.
    pub corners: Vec<Corner>,
    /// Index into `corners` of each corner of each face in turn.
    pub indices: Vec<u32>,
    /// The faces; their corner counts add up to the length of `indices`.
    pub faces: Vec<Face>,
}

/// Triangles and the vertices they share.
#[derive(Default)]
pub(super) struct Triangles {
    pub positions: Vec<Vec3>,
    pub normals: Vec<Vec3>,
    pub uvs: Vec<Vec2>,
    pub triangles: Vec<[u32; 3]>,
    /// Face of each triangle.
    pub faces: Vec<u32>,
    pub dropped_degenerate: usize,
    pub dropped_duplicates: usize,
    /// Polygons that cross themselves, and the line of the first.
    pub crossing: (usize, u32),
    /// Whether `normals` come from the faces, at least in part.
    pub computed_normals: bool,
}

/// A concave polygon with too many corners: its line and their number.
pub(super) struct TooLarge {
    pub line: u32,
    pub corners: usize,
}

impl Polygons {
    /// Positions of the corner at `index` (into `indices`).
    pub fn position(&self, index: usize) -> Vec3 {
        self.places[self.place(index) as usize]
    }

    /// Index into `places` of the corner at `index` (into `indices`).
    pub fn place(&self, index: usize) -> u32 {
        self.corners[self.indices[index] as usize].place
    }

    /// Triangles with at most one vertex for each distinct position, normal and texture coordinate.
    pub fn triangulate(&self, crease: f64, with_uvs: bool) -> Result<Triangles, TooLarge> {
        let mut result = Triangles::default();
        // Triangles of indices into `self.indices`, because corners have normals and vertices do not yet exist.
        let of_corners = self.cut(&mut result)?;
        let mut normals = corner_normals(self, crease).filter(|n| !self.is_flat(&of_corners, &n.of_corners));
        if let Some(normals) = &mut normals {
            self.complete(&of_corners, &mut normals.of_corners);
        }
        result.computed_normals = normals.as_ref().is_some_and(|n| n.computed);
        let normal_at = |index: u32| normals.as_ref().map_or(Vec3::ZERO, |n| n.of_corners[index as usize]);

        let mut vertices = Interner::<6>::with_capacity(self.places.len());
        // The vertex last made of a corner: mostly the one that is wanted.
        let mut latest = vec![(u32::MAX, Vec3::ZERO); self.corners.len()];
        let mut vertex = |index: u32| {
            let corner = self.indices[index as usize] as usize;
            let normal = normal_at(index);
            if latest[corner].0 == u32::MAX || latest[corner].1 != normal {
                let Corner { place, uv, .. } = self.corners[corner];
                // Adding 0 makes -0 and 0 the same bits.
                let [nx, ny, nz] = (normal + 0.0).to_array().map(f32::to_bits);
                let [u, v] = (uv + 0.0).to_array().map(f32::to_bits);
                latest[corner] = (vertices.number([place, nx, ny, nz, u, v]), normal);
            }
            latest[corner].0
        };
        result.triangles = of_corners.iter().map(|t| t.map(&mut vertex)).collect();
        let float = f32::from_bits;
        let keys = vertices.into_keys();
        result.positions = keys.iter().map(|k| self.places[k[0] as usize]).collect();
        if normals.is_some() {
            result.normals = keys.iter().map(|k| Vec3::new(float(k[1]), float(k[2]), float(k[3]))).collect();
        }
        if with_uvs {
            result.uvs = keys.iter().map(|k| Vec2::new(float(k[4]), float(k[5]))).collect();
        }
        Ok(result)
    }

    fn cut(&self, result: &mut Triangles) -> Result<Vec<[u32; 3]>, TooLarge> {
        let mut kept = Vec::with_capacity(self.indices.len() - 2 * self.faces.len());
        let mut seen = Interner::<3>::with_capacity(kept.capacity());
        let mut triangulator = Triangulator::default();
        let (mut distinct, mut points, mut cut) = (Vec::new(), Vec::new(), Vec::new());
        let mut start = 0;
        for (number, face) in self.faces.iter().enumerate() {
            let corners = start as usize..(start + face.corners) as usize;
            cut.clear();
            if face.corners == 3 {
                cut.push([start, start + 1, start + 2]);
            } else {
                // Corners that stay in place are no corners.
                distinct.clear();
                distinct.extend(corners.clone().zip(start..).filter_map(|(i, index)| {
                    let after = if i + 1 == corners.end { corners.start } else { i + 1 };
                    (self.place(i) != self.place(after)).then_some(index)
                }));
                points.clear();
                points.extend(distinct.iter().map(|&i| self.position(i as usize)));
                match triangulator.triangulate(&points, &mut cut) {
                    Outcome::Covered => {}
                    Outcome::SelfCrossing if result.crossing.0 == 0 => result.crossing = (1, face.line),
                    Outcome::SelfCrossing => result.crossing.0 += 1,
                    Outcome::TooLarge => return Err(TooLarge { line: face.line, corners: points.len() }),
                }
                cut.iter_mut().flatten().for_each(|local| *local = distinct[*local as usize]);
            }
            result.dropped_degenerate += face.corners as usize - 2 - cut.len();
            for &triangle in &cut {
                let [a, b, c] = triangle.map(|i| self.place(i as usize));
                let [pa, pb, pc] = [a, b, c].map(|place| self.places[place as usize]);
                if is_degenerate(pa, pb, pc) {
                    result.dropped_degenerate += 1;
                    continue;
                }
                // Rotated so that the same triangle has the same key, and its other side another.
                let key = if a < b && a < c {
                    [a, b, c]
                } else if b < c {
                    [b, c, a]
                } else {
                    [c, a, b]
                };
                if (seen.number(key) as usize) < kept.len() {
                    result.dropped_duplicates += 1;
                    continue;
                }
                kept.push(triangle);
                result.faces.push(number as u32);
            }
            start += face.corners;
        }
        Ok(kept)
    }

    /// Sets the normals that are still missing (polygons can have triangles and yet no normal) to a triangle's.
    fn complete(&self, triangles: &[[u32; 3]], normals: &mut [Vec3]) {
        for &triangle in triangles {
            if triangle.iter().any(|&i| normals[i as usize] == Vec3::ZERO) {
                let [a, b, c] = triangle.map(|i| self.position(i as usize).as_dvec3());
                let geometric = (b - a).cross(c - a).normalize_or(DVec3::Z).as_vec3();
                for i in triangle.map(|i| i as usize) {
                    if normals[i] == Vec3::ZERO {
                        normals[i] = geometric;
                    }
                }
            }
        }
    }

    /// Whether every normal is, to the precision that files are written in, that of its triangle.
    fn is_flat(&self, triangles: &[[u32; 3]], normals: &[Vec3]) -> bool {
        triangles.iter().all(|&triangle| {
            let [a, b, c] = triangle.map(|i| self.position(i as usize).as_dvec3());
            let geometric = (b - a).cross(c - a).normalize_or_zero();
            triangle.iter().all(|&i| {
                let normal = normals[i as usize].as_dvec3();
                normal.dot(geometric) > 0.0 && normal.cross(geometric).length_squared() < 2e-8
            })
        })
    }
}

/// Says what is wrong and what to do.
impl TooLarge {
    pub fn reason(&self) -> String {
        format!("a concave polygon of {} corners; at most {MAX_CONCAVE}: split it", self.corners)
    }
}
