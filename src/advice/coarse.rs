//! Meshes of more triangles than are seen.

use crate::scene::Mesh;
use glam::DVec3;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;

/// Mean area of the triangles, object space.
pub(super) fn mean_area(mesh: &Mesh) -> f64 {
    let area = |triangle| mesh.normal_of(triangle).length() / 2.0;
    (0..mesh.len() as u32).map(area).sum::<f64>() / mesh.len().max(1) as f64
}

/// A coarser model as the text of an OBJ file, in the space of the mesh's own file, and the number of its triangles:
/// corners that share a cell of a grid become one in their middle, and triangles that have lost a corner go (vertex
/// clustering, Rossignac and Borrel 1993). Nothing moves farther than the diagonal of a cell.
pub(super) fn coarser(mesh: &Mesh, cell: f64) -> (String, usize) {
    let cell_of = |p: DVec3| (p / cell).round().to_array().map(|v| v as i64);
    // Sum and number of the corners in each cell, and its number.
    let mut cells: BTreeMap<[i64; 3], (DVec3, f64, usize)> = BTreeMap::new();
    let mut triangles = Vec::new();
    let mut seen = BTreeSet::new();
    for triangle in 0..mesh.len() as u32 {
        let corners = mesh.corners(triangle);
        for corner in corners {
            let next = cells.len() + 1;
            let (sum, count, _) = cells.entry(cell_of(corner)).or_insert((DVec3::ZERO, 0.0, next));
            (*sum, *count) = (*sum + corner, *count + 1.0);
        }
        let [a, b, c] = corners.map(cell_of);
        let mut key = [a, b, c];
        key.sort_unstable();
        if a != b && b != c && c != a && seen.insert(key) {
            triangles.push([a, b, c]);
        }
    }
    let mut text = String::from("# made coarser by glimt\n");
    let mut middles: Vec<_> = cells.values().map(|(sum, count, number)| (*number, *sum / *count)).collect();
    middles.sort_by_key(|(number, _)| *number);
    for (_, middle) in middles {
        let p = mesh.centre + middle;
        // Writing into a string cannot fail.
        let _ = writeln!(text, "v {} {} {}", p.x as f32, p.y as f32, p.z as f32);
    }
    for corners in &triangles {
        let [a, b, c] = corners.map(|cell| cells[&cell].2);
        let _ = writeln!(text, "f {a} {b} {c}");
    }
    (text, triangles.len())
}
