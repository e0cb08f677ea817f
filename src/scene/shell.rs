//! The connected parts of a mesh: the bars of a fence, the leaves of a tree.

use super::Mesh;
use glam::{DMat3, DVec3};
use std::collections::HashMap;

/// A part of a mesh that hangs together, as a box around it in object space, turned as the part lies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shell {
    /// The middle of the box.
    pub middle: DVec3,
    /// Halves of its edges.
    pub edges: [DVec3; 3],
}

impl Shell {
    fn around(corners: &[DVec3]) -> Self {
        let axes = main_axes(corners);
        let (mut lower, mut upper) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for corner in corners {
            let place = axes.transpose() * *corner;
            (lower, upper) = (lower.min(place), upper.max(place));
        }
        let half = (upper - lower) / 2.0;
        Self {
            middle: axes * ((lower + upper) / 2.0),
            edges: [axes.x_axis * half.x, axes.y_axis * half.y, axes.z_axis * half.z],
        }
    }
}

impl Mesh {
    /// Its parts that share no corner, found when they are first asked for. Corners in one place are one, whatever
    /// their normals are.
    pub fn shells(&self) -> &[Shell] {
        self.shells.get_or_init(|| {
            let mut numbers = HashMap::with_capacity(self.positions.len());
            let places: Vec<u32> = (0..)
                .zip(&self.positions)
                .map(|(i, place)| *numbers.entry(place.to_array().map(|c| (c + 0.0).to_bits())).or_insert(i))
                .collect();
            let mut parents: Vec<u32> = (0..places.len() as u32).collect();
            let triangles = || self.triangles.iter().map(|triangle| triangle.map(|i| places[i as usize]));
            for [a, b, c] in triangles() {
                let root = root(&mut parents, a);
                for other in [b, c] {
                    let other = self::root(&mut parents, other);
                    parents[other as usize] = root;
                }
            }
            // In the order of the triangles, so that nothing depends on how a map hashes; each corner once.
            let mut parts: Vec<Vec<DVec3>> = Vec::new();
            let (mut part_of, mut is_taken) = (vec![None; places.len()], vec![false; places.len()]);
            for corner in triangles().flatten() {
                let part = *part_of[root(&mut parents, corner) as usize].get_or_insert_with(|| {
                    parts.push(Vec::new());
                    parts.len() - 1
                });
                if !std::mem::replace(&mut is_taken[corner as usize], true) {
                    parts[part].push(self.positions[corner as usize].as_dvec3());
                }
            }
            parts.iter().map(|corners| Shell::around(corners)).collect()
        })
    }
}

/// The root of an element in a forest of disjoint sets; ways are halved as they are walked.
fn root(parents: &mut [u32], mut element: u32) -> u32 {
    while parents[element as usize] != element {
        let next = parents[parents[element as usize] as usize];
        parents[element as usize] = next;
        element = next;
    }
    element
}

/// The directions in which points spread, most first: unit, each perpendicular to the others.
fn main_axes(points: &[DVec3]) -> DMat3 {
    let middle = points.iter().sum::<DVec3>() / points.len() as f64;
    let spread = points.iter().fold(DMat3::ZERO, |sum, point| {
        let off = *point - middle;
        sum + DMat3::from_cols(off * off.x, off * off.y, off * off.z)
    });
    let first = main_axis(spread).unwrap_or(DVec3::X);
    // What is left across the first.
    let across = DMat3::IDENTITY - DMat3::from_cols(first * first.x, first * first.y, first * first.z);
    let second = main_axis(across * spread * across).unwrap_or(first.any_orthonormal_vector());
    let second = (second - first * first.dot(second)).normalize_or(first.any_orthonormal_vector());
    DMat3::from_cols(first, second, first.cross(second))
}

/// The eigenvector of the largest eigenvalue of a symmetric matrix: a column of a high power of it.
fn main_axis(mut matrix: DMat3) -> Option<DVec3> {
    let columns = |m: &DMat3| [m.x_axis, m.y_axis, m.z_axis];
    for _ in 0..24 {
        let size = columns(&matrix).into_iter().fold(0.0, |size: f64, column| size.max(column.abs().max_element()));
        if !(size > 0.0 && size.is_finite()) {
            return None;
        }
        matrix *= 1.0 / size;
        matrix *= matrix;
    }
    columns(&matrix).into_iter().max_by(|a, b| a.length_squared().total_cmp(&b.length_squared()))?.try_normalize()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::assets::Model;
    use crate::bvh::Isa;
    use crate::math::SplitMix64;
    use glam::{DQuat, Vec3};
    use std::num::NonZeroUsize;

    /// The corners of a box, six faces of two triangles; each face has corners of its own if `hard`.
    fn add_box(model: &mut Model, [middle, half]: [DVec3; 2], turn: DQuat, hard: bool) {
        let corner = |k: usize| {
            let sign = |bit: usize| if k >> bit & 1 == 0 { -1.0 } else { 1.0 };
            (middle + turn * (half * DVec3::new(sign(0), sign(1), sign(2)))).as_vec3()
        };
        let start = model.positions.len() as u32;
        if !hard {
            model.positions.extend((0..8).map(corner));
        }
        for face in [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]] {
            let number = if hard {
                let first = model.positions.len() as u32;
                model.positions.extend(face.map(corner));
                [first, first + 1, first + 2, first + 3]
            } else {
                face.map(|k| start + k as u32)
            };
            let [a, b, c, d] = number;
            model.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }

    fn mesh(model: Model) -> Mesh {
        Mesh::new(model, Isa::Portable, NonZeroUsize::MIN)
    }

    #[test]
    fn every_part_gets_the_box_that_it_was_made_from_however_it_is_turned() {
        let mut random = SplitMix64(12);
        for hard in [false, true] {
            let mut model = Model::default();
            let boxes: Vec<_> = (0..20)
                .map(|i| {
                    let mut number = || random.range(-1.0, 1.0);
                    let turn = DQuat::from_xyzw(number(), number(), number(), number()).normalize();
                    let middle = DVec3::new(10.0 * f64::from(i), 3.0 * number(), 3.0 * number());
                    (middle, DVec3::new(3.0, 0.2, 0.05), turn)
                })
                .collect();
            for (middle, half, turn) in &boxes {
                add_box(&mut model, [*middle, *half], *turn, hard);
            }
            let mesh = mesh(model);
            assert_eq!(mesh.shells().len(), boxes.len());
            for (shell, (middle, half, turn)) in mesh.shells().iter().zip(&boxes) {
                assert!(shell.middle.distance(*middle) < 1e-4, "{shell:?}, made at {middle}");
                let axes = DMat3::from_quat(*turn) * DMat3::from_diagonal(*half);
                for (edge, made) in shell.edges.into_iter().zip([axes.x_axis, axes.y_axis, axes.z_axis]) {
                    assert!(edge.distance(made).min(edge.distance(-made)) < 1e-3, "{edge}, made {made}");
                }
            }
        }
    }

    #[test]
    fn parts_that_share_one_corner_are_one_and_what_has_no_extent_has_a_box_too() {
        let mut model = Model::default();
        add_box(&mut model, [DVec3::ZERO, DVec3::ONE], DQuat::IDENTITY, true);
        add_box(&mut model, [DVec3::splat(2.0), DVec3::ONE], DQuat::IDENTITY, true);
        assert_eq!(mesh(model).shells().len(), 1);

        let flat = [Vec3::ZERO, Vec3::X, Vec3::X * 2.0];
        let model = Model { positions: flat.to_vec(), triangles: vec![[0, 1, 2]], ..Model::default() };
        let line = mesh(model);
        let [shell] = line.shells() else { panic!("one triangle is one part") };
        assert!(shell.middle.distance(DVec3::X) < 1e-12);
        assert!((shell.edges[0].abs() - DVec3::X).length() < 1e-12 && shell.edges[1].length() < 1e-12);
    }
}
