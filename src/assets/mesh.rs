//! Polygons to triangles: degenerate and doubled ones dropped, corners merged into vertices.

use super::fans::Fans;
use super::normals::{Fan, Shape};
use super::obj_clean::{Corners, Face};
use super::obj_outline::Smoothing;
use super::triangulate::{MAX_CONCAVE, Outcome, Triangulator, is_degenerate};
use crate::workers;
use glam::{DVec3, Vec2, Vec3};
use std::borrow::Cow;
use std::collections::HashMap;
use std::num::NonZeroUsize;
use std::ops::Range;

/// Polygons as the file has them.
pub(super) struct Polygons {
    /// Positions; no two that corners use are equal.
    pub places: Vec<Vec3>,
    /// The file's normals, unit length, 0 for those of no use; number 0 stands for none and is 0.
    pub normals: Vec<Vec3>,
    /// Texture coordinates; number 0 stands for none and is 0.
    pub uvs: Vec<Vec2>,
    /// Corners of one face after the other: indices into these.
    pub corners: Corners,
    /// The faces.
    pub faces: Vec<Face>,
    /// Smoothing of each face; a single one if all are alike.
    pub smoothings: Vec<Smoothing>,
}

/// Triangles and the vertices they share.
#[derive(Default)]
pub(super) struct Triangles {
    pub positions: Vec<Vec3>,
    pub normals: Vec<Vec3>,
    pub uvs: Vec<Vec2>,
    pub triangles: Vec<[u32; 3]>,
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

/// A triangle: three corners and its face, [`DROPPED`] if it does not count. An array because memory of zeros comes
/// free, and this is much of it.
pub(super) type Cut = [u32; 4];
const DROPPED: u32 = u32::MAX;

/// A position with normal and texture coordinates.
#[derive(Clone, Copy)]
struct Vertex {
    place: u32,
    normal: Vec3,
    uv: Vec2,
}

/// The vertices at the places of a range.
#[derive(Default)]
struct Vertices {
    /// Normal and texture coordinates of the first vertex at each place.
    normals: Vec<Vec3>,
    uvs: Vec<Vec2>,
    /// Others.
    more: Vec<Vertex>,
    /// Corners that have one of the others, and its index.
    moved: Vec<(u32, u32)>,
}

/// Faces or triangles that a thread takes at a time.
const FACES: usize = 1 << 14;

impl Polygons {
    /// Whether all faces are triangles.
    pub fn are_triangles(&self) -> bool {
        self.corners.places.len() == 3 * self.faces.len()
    }

    /// The corners of a face.
    pub fn corners_of(&self, face: usize) -> Range<u32> {
        let end = self.faces.get(face + 1).map_or(self.corners.places.len() as u32, |next| next.start);
        self.faces[face].start..end
    }

    /// Smoothing of a face.
    pub fn smoothing(&self, face: usize) -> Smoothing {
        match self.smoothings[..] {
            [all] => all,
            _ => self.smoothings[face],
        }
    }

    /// Position of a corner.
    pub fn position(&self, corner: u32) -> Vec3 {
        self.places[self.place(corner) as usize]
    }

    /// Index into `places` of a corner.
    pub fn place(&self, corner: u32) -> u32 {
        self.corners.places[corner as usize]
    }

    /// The file's normal at a corner; 0 if there is none.
    fn normal(&self, corner: u32) -> Vec3 {
        self.corners.normals.get(corner as usize).map_or(Vec3::ZERO, |&i| self.normals[i as usize])
    }

    /// Whether any corner has a normal, and whether all have.
    pub fn have_normals(&self) -> (bool, bool) {
        let of_corners = &self.corners.normals;
        let has = |&i: &u32| self.normals[i as usize] != Vec3::ZERO;
        (of_corners.iter().any(has), !of_corners.is_empty() && of_corners.iter().all(has))
    }

    /// Texture coordinates of a corner; 0 if there are none.
    fn uv(&self, corner: u32) -> Vec2 {
        self.corners.uvs.get(corner as usize).map_or(Vec2::ZERO, |&i| self.uvs[i as usize])
    }

    /// Triangles with at most one vertex for each distinct position, normal and texture coordinate, and the face of
    /// each. `crease` in degrees.
    pub fn triangulate(&self, crease: f64, threads: NonZeroUsize) -> Result<(Triangles, Vec<Cut>), TooLarge> {
        let mut result = Triangles::default();
        let mut cuts = self.cut(threads, &mut result)?;
        self.drop_duplicates(threads, &mut cuts, &mut result);

        let (any, all) = self.have_normals();
        let is_smooth = |s: &Smoothing| match s {
            Smoothing::Flat => false,
            Smoothing::Crease => crease > 0.0,
            Smoothing::Group(_) => true,
        };
        let shape = (!all && (any || self.smoothings.iter().any(is_smooth))).then(|| Shape::of(self, crease, threads));
        if all || shape.is_some() {
            let missing = shape.as_ref().map_or_else(HashMap::new, |shape| self.missing_normals(shape, &cuts));
            let normals = Normals { shape: shape.as_ref(), missing: &missing };
            let vertices = self.vertices(Some(&normals), threads);
            let slots = self.slots(&vertices);
            if !missing.is_empty() || !self.are_flat(&cuts, &slots, &vertices, threads) {
                result.computed_normals = shape.is_some();
                self.number(&cuts, &slots, &vertices, true, &mut result);
                return Ok((result, cuts));
            }
        }
        let vertices = if self.corners.uvs.is_empty() { Vertices::default() } else { self.vertices(None, threads) };
        self.number(&cuts, &self.slots(&vertices), &vertices, false, &mut result);
        Ok((result, cuts))
    }

    /// Cuts the faces into triangles that have an area.
    fn cut(&self, threads: NonZeroUsize, result: &mut Triangles) -> Result<Vec<Cut>, TooLarge> {
        // A face of n corners has room for n - 2 triangles.
        let room = |faces: &Range<usize>| {
            let end = self.corners_of(faces.end - 1).end;
            (end - self.faces[faces.start].start) as usize - 2 * faces.len()
        };
        let mut cuts = vec![[0; 4]; self.corners.places.len() - 2 * self.faces.len()];
        let ranges = workers::pieces(self.faces.len(), FACES);
        let slices = workers::slices(&mut cuts, ranges.iter().map(room));
        let work = ranges.into_iter().zip(slices).collect();
        for part in workers::map(threads, work, |(faces, cuts)| self.cut_faces(faces, cuts)) {
            let (dropped, crossing) = part?;
            result.dropped_degenerate += dropped;
            if result.crossing.0 == 0 {
                result.crossing.1 = crossing.1;
            }
            result.crossing.0 += crossing.0;
        }
        if result.dropped_degenerate > 0 {
            cuts.retain(|cut| cut[3] != DROPPED);
        }
        Ok(cuts)
    }

    /// Cuts some of the faces. Returns how many triangles were dropped, and how many polygons cross themselves with the
    /// line of the first.
    fn cut_faces(&self, faces: Range<usize>, cuts: &mut [Cut]) -> Result<(usize, (usize, u32)), TooLarge> {
        let mut triangulator = Triangulator::default();
        let (mut distinct, mut points, mut triangles) = (Vec::new(), Vec::new(), Vec::new());
        let (mut dropped, mut crossing) = (0, (0, 0));
        let mut cuts = cuts.iter_mut();
        for face in faces {
            let corners = self.corners_of(face);
            let Range { start, end } = corners;
            triangles.clear();
            if end - start == 3 {
                triangles.push([start, start + 1, start + 2]);
            } else {
                // Corners that stay in place are no corners.
                distinct.clear();
                distinct.extend(corners.filter(|&i| {
                    let after = if i + 1 == end { start } else { i + 1 };
                    self.place(i) != self.place(after)
                }));
                points.clear();
                points.extend(distinct.iter().map(|&i| self.position(i)));
                let line = self.faces[face].line;
                match triangulator.triangulate(&points, &mut triangles) {
                    Outcome::Covered => {}
                    Outcome::SelfCrossing if crossing.0 == 0 => crossing = (1, line),
                    Outcome::SelfCrossing => crossing.0 += 1,
                    Outcome::TooLarge => return Err(TooLarge { line, corners: points.len() }),
                }
                triangles.iter_mut().flatten().for_each(|local| *local = distinct[*local as usize]);
            }
            let all = triangles.iter().map(Some).chain(std::iter::repeat(None)).take((end - start) as usize - 2);
            for (triangle, cut) in all.zip(&mut cuts) {
                *cut = match triangle {
                    Some(&[a, b, c]) if !is_degenerate(self.position(a), self.position(b), self.position(c)) => {
                        [a, b, c, face as u32]
                    }
                    _ => {
                        dropped += 1;
                        [0, 0, 0, DROPPED]
                    }
                };
            }
        }
        Ok((dropped, crossing))
    }

    /// Drops every triangle that has the places of one before it in the same sense.
    fn drop_duplicates(&self, threads: NonZeroUsize, cuts: &mut Vec<Cut>, result: &mut Triangles) {
        // Rotated so that the lowest comes first: the same triangle has the same key, and its other side another.
        let key = |cut: &Cut| {
            let [a, b, c] = [cut[0], cut[1], cut[2]].map(|corner| self.place(corner));
            if a < b && a < c {
                [a, b, c]
            } else if b < c {
                [b, c, a]
            } else {
                [c, a, b]
            }
        };
        let later = workers::map(threads, self.shares(threads), |places| {
            let fans = Fans::of(cuts.iter().map(|cut| key(cut)[0]), places);
            let (mut keys, mut later) = (Vec::new(), Vec::new());
            for (_, triangles) in fans.iter().filter(|(_, triangles)| triangles.len() > 1) {
                keys.clear();
                keys.extend(triangles.iter().map(|&t| (key(&cuts[t as usize]), t)));
                keys.sort_unstable();
                later.extend(keys.windows(2).filter(|pair| pair[0].0 == pair[1].0).map(|pair| pair[1].1));
            }
            later
        });
        result.dropped_duplicates = later.iter().map(Vec::len).sum();
        if result.dropped_duplicates > 0 {
            later.iter().flatten().for_each(|&t| cuts[t as usize][3] = DROPPED);
            cuts.retain(|cut| cut[3] != DROPPED);
        }
    }

    /// The places, shared out among the threads.
    fn shares(&self, threads: NonZeroUsize) -> Vec<Range<u32>> {
        // No thread for less than this.
        const LEAST: usize = 1 << 12;
        let size = self.places.len().div_ceil(threads.get()).max(LEAST);
        workers::pieces(self.places.len(), size).into_iter().map(|r| r.start as u32..r.end as u32).collect()
    }

    /// Polygons can have triangles and yet no normal: that of the first triangle for each corner of such.
    fn missing_normals(&self, shape: &Shape, cuts: &[Cut]) -> HashMap<u32, Vec3> {
        let mut missing = HashMap::new();
        if shape.is_complete {
            return missing;
        }
        for &[a, b, c, _] in cuts.iter().filter(|cut| shape.normal(cut[3] as usize) == Vec3::ZERO) {
            let geometric = self.geometric_normal([a, b, c]).normalize_or(DVec3::Z).as_vec3();
            for corner in [a, b, c] {
                if self.normal(corner) == Vec3::ZERO {
                    missing.entry(corner).or_insert(geometric);
                }
            }
        }
        missing
    }

    /// Normal of a triangle, length twice its area.
    fn geometric_normal(&self, corners: [u32; 3]) -> DVec3 {
        let [a, b, c] = corners.map(|corner| self.position(corner).as_dvec3());
        (b - a).cross(c - a)
    }

    /// The vertices that the corners are to have, with normals if these are given.
    fn vertices(&self, normals: Option<&Normals>, threads: NonZeroUsize) -> Vertices {
        let shares = workers::map(threads, self.shares(threads), |places| self.vertices_at(places, normals));
        let mut shares = shares.into_iter();
        let mut vertices = shares.next().unwrap_or_default();
        for share in shares {
            let base = vertices.more.len() as u32;
            vertices.normals.extend(share.normals);
            vertices.uvs.extend(share.uvs);
            vertices.more.extend(share.more);
            vertices.moved.extend(share.moved.iter().map(|&(corner, index)| (corner, base + index)));
        }
        vertices
    }

    fn vertices_at(&self, places: Range<u32>, normals: Option<&Normals>) -> Vertices {
        let fans = Fans::of(self.corners.places.iter().copied(), places);
        let mut vertices = Vertices::default();
        let mut fan = normals.and_then(|n| n.shape).map(Fan::new);
        let (mut of_corners, mut keys) = (Vec::new(), Vec::new());
        for (place, corners) in fans.iter() {
            of_corners.clear();
            if let Some(normals) = normals {
                of_corners.extend(corners.iter().map(|&corner| self.normal(corner)));
                if let Some(fan) = &mut fan {
                    fan.smooth(corners, &mut of_corners);
                }
                if !normals.missing.is_empty() {
                    for (normal, corner) in of_corners.iter_mut().zip(corners) {
                        if *normal == Vec3::ZERO {
                            *normal = normals.missing.get(corner).copied().unwrap_or_default();
                        }
                    }
                }
            } else {
                of_corners.resize(corners.len(), Vec3::ZERO);
            }
            let normal = of_corners.first().copied().unwrap_or_default();
            let uv = corners.first().map_or(Vec2::ZERO, |&corner| self.uv(corner));
            // Adding 0 makes -0 and 0 the same bits.
            vertices.normals.push(normal + 0.0);
            vertices.uvs.push(uv + 0.0);
            let is_first = |(&n, &corner): (&Vec3, &u32)| n == normal && self.uv(corner) == uv;
            if of_corners.iter().zip(corners).all(is_first) {
                continue;
            }
            let bits = |v: Vec3, uv: Vec2| [v.x, v.y, v.z, uv.x, uv.y].map(|x| (x + 0.0).to_bits());
            keys.clear();
            keys.extend(of_corners.iter().zip(corners).map(|(&n, &corner)| (bits(n, self.uv(corner)), corner)));
            keys.sort_unstable();
            for alike in keys.chunk_by(|a, b| a.0 == b.0).filter(|alike| alike[0].0 != bits(normal, uv)) {
                let ([x, y, z, u, v], _) = alike[0];
                let [x, y, z, u, v] = [x, y, z, u, v].map(f32::from_bits);
                let index = vertices.more.len() as u32;
                vertices.more.push(Vertex { place, normal: Vec3::new(x, y, z), uv: Vec2::new(u, v) });
                vertices.moved.extend(alike.iter().map(|&(_, corner)| (corner, index)));
            }
        }
        vertices
    }

    /// The vertex of each corner: its place, or one of `more` counted on from the number of places.
    fn slots(&self, vertices: &Vertices) -> Cow<'_, [u32]> {
        let mut slots = Cow::Borrowed(&self.corners.places[..]);
        if !vertices.moved.is_empty() {
            let slots = slots.to_mut();
            for &(corner, index) in &vertices.moved {
                slots[corner as usize] = self.places.len() as u32 + index;
            }
        }
        slots
    }

    /// Whether every normal is, to the precision that files are written in, that of its triangle.
    fn are_flat(&self, cuts: &[Cut], slots: &[u32], vertices: &Vertices, threads: NonZeroUsize) -> bool {
        let is_flat = |&[a, b, c, _]: &Cut| {
            let geometric = self.geometric_normal([a, b, c]).normalize_or_zero();
            [a, b, c].iter().all(|&corner| {
                let slot = slots[corner as usize] as usize;
                let normal = vertices.normals.get(slot);
                let normal = normal.unwrap_or_else(|| &vertices.more[slot - vertices.normals.len()].normal).as_dvec3();
                normal.dot(geometric) > 0.0 && normal.cross(geometric).length_squared() < 2e-8
            })
        };
        workers::map(threads, cuts.chunks(FACES).collect(), |cuts: &[Cut]| cuts.iter().all(is_flat))
            .into_iter()
            .all(|flat| flat)
    }

    /// Numbers the vertices in the order in which triangles use them.
    fn number(&self, cuts: &[Cut], slots: &[u32], vertices: &Vertices, with_normals: bool, result: &mut Triangles) {
        const UNUSED: u32 = u32::MAX;
        let places = self.places.len();
        let mut numbers = vec![UNUSED; places + vertices.more.len()];
        let mut order = Vec::with_capacity(numbers.len());
        result.triangles = cuts
            .iter()
            .map(|&[a, b, c, _]| {
                [a, b, c].map(|corner| {
                    let slot = slots[corner as usize];
                    let number = &mut numbers[slot as usize];
                    if *number == UNUSED {
                        *number = order.len() as u32;
                        order.push(slot);
                    }
                    *number
                })
            })
            .collect();
        let order = || order.iter().map(|&slot| slot as usize);
        let more = |slot: usize| &vertices.more[slot - places];
        let position = |slot| self.places[if slot < places { slot } else { more(slot).place as usize }];
        result.positions = order().map(position).collect();
        if with_normals {
            let normal = |slot| if slot < places { vertices.normals[slot] } else { more(slot).normal };
            result.normals = order().map(normal).collect();
        }
        if !self.corners.uvs.is_empty() {
            let uv = |slot| if slot < places { vertices.uvs[slot] } else { more(slot).uv };
            result.uvs = order().map(uv).collect();
        }
    }
}

/// Where the normals of corners come from, beside the file.
struct Normals<'a> {
    /// Given if not all are in the file.
    shape: Option<&'a Shape<'a>>,
    /// Of corners that get none from the shape.
    missing: &'a HashMap<u32, Vec3>,
}

/// Says what is wrong and what to do.
impl TooLarge {
    pub fn reason(&self) -> String {
        format!("a concave polygon of {} corners; at most {MAX_CONCAVE}: split it", self.corners)
    }
}
