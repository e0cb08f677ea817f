//! Wavefront OBJ to a model.
//!
//! The bytes go through a pass that mends and checks them ([`Cleaner`]), then through tobj, and what tobj makes of them
//! is cut into triangles ([`Polygons`]).

use super::intern::Interner;
use super::mesh::{Corner, Polygons, Triangles};
use super::obj_clean::{Cleaner, Outline, Smoothing};
use super::obj_lines::{lossy, without_comment};
use super::obj_mtl::Materials;
use super::report::{counted, listed};
use super::resolve::Resolver;
use super::{AssetError, ImportReport, Model, guard, read_file};
use crate::description::MaterialDesc;
use glam::{DVec3, Vec2, Vec3};
use std::collections::HashSet;
use std::path::{Path, PathBuf};

/// Largest file, bytes; reading takes several times as much memory.
const MAX_BYTES: u64 = 2 << 30;

/// Reads a model and its materials. `crease` in degrees: see `description::ShapeDesc::Mesh`. What can be mended is, and
/// the report tells; what cannot is refused with the line.
pub fn load_obj(file: &Path, crease: f64) -> Result<Model, AssetError> {
    let bytes = read_file(file, MAX_BYTES)?;
    let mut cleaner = Cleaner::new(file, &bytes)?;
    // One index for position, texture coordinates and normal; polygons whole.
    let options = tobj::LoadOptions { single_index: true, ..tobj::LoadOptions::default() };
    let parsed = guard(|| tobj::load_obj_buf(&mut cleaner, &options, |_| Ok(Default::default())));
    let outline = cleaner.into_outline()?;
    let meshes = match parsed {
        Some(Ok((meshes, _))) => meshes.into_iter().map(|m| m.mesh).collect(),
        Some(Err(error)) => return Err(AssetError::new(file, None, format!("cannot be read as OBJ: {error}"))),
        None => return Err(AssetError::new(file, None, "cannot be read as OBJ")),
    };
    drop(bytes);
    build(file, crease, outline, meshes)
}

fn build(file: &Path, crease: f64, mut outline: Outline, meshes: Vec<tobj::Mesh>) -> Result<Model, AssetError> {
    let faces = std::mem::take(&mut outline.faces);
    let corners = meshes.iter().map(|m| m.indices.len()).sum::<usize>();
    if corners != faces.iter().map(|f| f.corners as usize).sum::<usize>() {
        return Err(AssetError::new(file, None, "cannot be read as OBJ: faces are missing"));
    }
    let with_uvs = meshes.iter().any(|m| !m.texcoords.is_empty());
    let centre = box_centre(&meshes);
    let mut polygons = gather(meshes, centre);
    polygons.faces = faces;
    let made = polygons
        .triangulate(crease, with_uvs)
        .map_err(|large| AssetError::new(file, Some(large.line as usize), large.reason()))?;
    if made.triangles.is_empty() {
        return Err(AssetError::new(file, None, why_empty(&outline, &made)));
    }
    let mut report = ImportReport {
        triangles: made.triangles.len(),
        dropped_degenerate: made.dropped_degenerate,
        dropped_duplicates: made.dropped_duplicates,
        normals: None,
        notes: Vec::new(),
    };
    if made.computed_normals {
        report.normals = Some(how_computed(&polygons, crease));
    }
    let mut model = Model { centre, ..Model::default() };
    assign_materials(file, &outline, &polygons, &made, &mut model, &mut report.notes);
    note_oddities(&outline, &made, &mut report.notes);
    model.report = report;
    Triangles { positions: model.positions, normals: model.normals, uvs: model.uvs, triangles: model.triangles, .. } =
        made;
    Ok(model)
}

/// The centre of the box around all positions.
fn box_centre(meshes: &[tobj::Mesh]) -> DVec3 {
    let (mut lower, mut upper) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for p in meshes.iter().flat_map(|m| m.positions.as_chunks::<3>().0) {
        lower = lower.min(DVec3::from_array(*p));
        upper = upper.max(DVec3::from_array(*p));
    }
    if lower.is_finite() { lower * 0.5 + upper * 0.5 } else { DVec3::ZERO }
}

/// Puts tobj's meshes together, positions about `centre` and each distinct one once.
fn gather(meshes: Vec<tobj::Mesh>, centre: DVec3) -> Polygons {
    let count = meshes.iter().map(|m| m.positions.len() / 3).sum();
    let mut places = Interner::<3>::with_capacity(count);
    let mut corners = Vec::with_capacity(count);
    let mut indices = Vec::with_capacity(meshes.iter().map(|m| m.indices.len()).sum());
    for mesh in meshes {
        let base = corners.len() as u32;
        indices.extend(mesh.indices.iter().map(|i| base + i));
        // Shorter than the positions, that is empty, where the corners of the mesh have none.
        let mut normals = mesh.normals.as_chunks::<3>().0.iter();
        let mut uvs = mesh.texcoords.as_chunks::<2>().0.iter();
        for p in mesh.positions.as_chunks::<3>().0 {
            // Adding 0 makes -0 and 0 the same bits.
            let position = (DVec3::from_array(*p) - centre).as_vec3() + 0.0;
            corners.push(Corner {
                place: places.number(position.to_array().map(f32::to_bits)),
                normal: normals.next().map_or(Vec3::ZERO, |n| unit(DVec3::from_array(*n))),
                uv: uvs.next().map_or(Vec2::ZERO, |[u, v]| Vec2::new(*u as f32, *v as f32)),
            });
        }
    }
    let places = places.into_keys().into_iter().map(|bits| Vec3::from_array(bits.map(f32::from_bits))).collect();
    Polygons { places, corners, indices, faces: Vec::new() }
}

/// `n` at unit length whatever its size; 0 stays 0.
fn unit(n: DVec3) -> Vec3 {
    (n / n.abs().max_element()).normalize_or_zero().as_vec3()
}

fn why_empty(outline: &Outline, made: &Triangles) -> String {
    match &outline.unknown.1 {
        _ if made.dropped_degenerate > 0 => "every face has zero area".to_owned(),
        Some((line, keyword)) => format!("has no faces; is it an OBJ file? (line {line} begins with `{keyword}`)"),
        None if outline.free_form > 0 => {
            "has no faces, only free-form curves or surfaces; export it as polygons".into()
        }
        None => "has no faces".to_owned(),
    }
}

fn how_computed(polygons: &Polygons, crease: f64) -> String {
    let missing = polygons.corners.iter().filter(|c| c.normal == Vec3::ZERO).count();
    let which = if missing == polygons.corners.len() { "normals" } else { "missing normals" };
    let has_groups = polygons.faces.iter().any(|f| matches!(f.smoothing, Smoothing::Group(_)));
    let has_creases = polygons.faces.iter().any(|f| f.smoothing == Smoothing::Crease);
    match (has_groups, has_creases) {
        (true, true) => format!("{which} computed (smoothing groups, else crease {crease} degrees)"),
        (true, false) => format!("{which} computed (smoothing groups)"),
        (false, true) => format!("{which} computed (crease {crease} degrees)"),
        (false, false) => format!("{which} computed (flat)"),
    }
}

/// Loads the libraries and gives each triangle its material, in order of first use.
fn assign_materials(
    file: &Path,
    outline: &Outline,
    polygons: &Polygons,
    made: &Triangles,
    model: &mut Model,
    notes: &mut Vec<String>,
) {
    let mut resolver = Resolver::beside(file);
    let mut library = Materials::default();
    let mut loaded = HashSet::new();
    let mut missing = Vec::new();
    for written in &outline.libraries {
        let found = find_libraries(written, file, &mut resolver);
        if found.is_empty() {
            missing.push(lossy(without_comment(written)));
        }
        for path in found {
            if loaded.insert(path.clone())
                && let Err(error) = library.load(&path, &mut resolver)
            {
                notes.push(format!("material library not usable: {error}"));
            }
        }
    }
    if !missing.is_empty() {
        notes.push(format!("material library not found: {}", listed(&missing)));
    }

    // By `Face::material`, the faces without one last: index into the model's materials, once it is known.
    let mut chosen: Vec<Option<u32>> = vec![None; outline.materials.len() + 1];
    let mut default = None;
    let mut unknown = Vec::new();
    let mut found_any = false;
    model.triangle_materials.reserve(made.triangles.len());
    for &face in &made.faces {
        let number = polygons.faces[face as usize].material;
        let slot = (number as usize).min(outline.materials.len());
        let index = *chosen[slot].get_or_insert_with(|| {
            let name = outline.materials.get(number as usize);
            let next = model.materials.len() as u32;
            match name.and_then(|name| library.find(name)) {
                Some(material) => {
                    found_any = true;
                    model.materials.push(material.clone());
                    next
                }
                None => {
                    unknown.extend(name.map(|name| lossy(without_comment(name))));
                    *default.get_or_insert_with(|| {
                        model.materials.push(MaterialDesc::default());
                        next
                    })
                }
            }
        });
        model.triangle_materials.push(index);
    }
    if !found_any {
        model.materials.clear();
    }
    if model.materials.len() <= 1 {
        model.triangle_materials = Vec::new();
    }
    if !unknown.is_empty() && missing.is_empty() {
        notes.push(format!("{} not found: {}", counted(unknown.len(), "material"), listed(&unknown)));
    }
    notes.extend(library.notes());
}

/// The libraries of one `mtllib` line: the whole of it is a name if there is such a file, else there are several names,
/// which end in `.mtl` if they have blanks.
fn find_libraries(written: &[u8], file: &Path, resolver: &mut Resolver) -> Vec<PathBuf> {
    for whole in [written, without_comment(written)] {
        let name = String::from_utf8_lossy(whole);
        if let Some(path) = resolver.find(name.trim_matches('"'), file) {
            return vec![path];
        }
    }
    let text = String::from_utf8_lossy(without_comment(written));
    let mut found = Vec::new();
    let mut name = String::new();
    for word in text.split_whitespace() {
        if !name.is_empty() {
            name.push(' ');
        }
        name.push_str(word);
        if word.to_lowercase().ends_with(".mtl") {
            found.extend(resolver.find(&name, file));
            name.clear();
        }
    }
    if found.is_empty() {
        found.extend(text.split_whitespace().take(64).filter_map(|word| resolver.find(word, file)));
    }
    found
}

/// Notes on what was left out.
fn note_oddities(outline: &Outline, made: &Triangles, notes: &mut Vec<String>) {
    if made.crossing.0 > 0 {
        let polygons = counted(made.crossing.0, "polygon");
        notes.push(format!("{polygons} crossing themselves (line {})", made.crossing.1));
    }
    if outline.lines_and_points > 0 {
        notes.push(format!("{} skipped", counted(outline.lines_and_points, "line or point element")));
    }
    if outline.free_form > 0 {
        notes.push(format!("{} skipped", counted(outline.free_form, "free-form statement")));
    }
    if outline.colored > 0 {
        notes.push(format!("colours of {} ignored", counted(outline.colored, "vertex")));
    }
    if outline.weighted > 0 {
        notes.push(format!("weights of {} ignored", counted(outline.weighted, "vertex")));
    }
    if let (count, Some((line, keyword))) = &outline.unknown {
        notes.push(format!("{} ignored (line {line}: {keyword})", counted(*count, "unknown line")));
    }
}
