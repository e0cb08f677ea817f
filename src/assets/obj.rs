//! Wavefront OBJ to a model.
//!
//! The text is cut into parts, which threads mend, check and have tobj parse ([`Part`]); they are put together
//! ([`Outline`], [`Polygons`]) and what they say is cut into triangles. Nothing depends on the number of threads.

use super::intern::{Interner, hash};
use super::mesh::{Cut, Polygons, Triangles};
use super::obj_clean::{Before, Corners, Face};
use super::obj_lines::{Lines, lossy, without_comment};
use super::obj_mtl::Materials;
use super::obj_outline::{Outline, Smoothing};
use super::obj_part::Part;
use super::report::{counted, listed};
use super::resolve::Resolver;
use super::{AssetError, ImportReport, Model, read_file_on};
use crate::description::MaterialDesc;
use crate::workers;
use glam::{DVec3, Vec2, Vec3};
use std::collections::HashSet;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

/// Largest file, bytes; reading takes several times as much memory.
const MAX_BYTES: u64 = 2 << 30;

/// Bytes of text that a thread takes at a time: what tobj makes of them fits a cache.
const PART: usize = 1 << 18;

/// Reads a model and its materials. `crease` in degrees: see `description::ShapeDesc::Mesh`. What can be mended is, and
/// the report tells; what cannot is refused with the line. The result is the same for any number of threads.
pub fn load_obj(file: &Path, crease: f64, threads: NonZeroUsize) -> Result<Model, AssetError> {
    let mut parts = read_parts(file, threads)?;
    let outline = Outline::of(file, parts.iter_mut().map(|part| &mut part.found))?;
    let (polygons, centre) = gather(parts, &outline, threads);
    build(file, crease, &outline, &polygons, centre, threads)
}

fn read_parts(file: &Path, threads: NonZeroUsize) -> Result<Vec<Part>, AssetError> {
    let bytes = read_file_on(threads, file, MAX_BYTES)?;
    let parts = Lines::new(file, &bytes)?.parts(PART);
    // Line numbers and indices that count back need to know what stands before.
    let counts = workers::map(threads, parts.clone(), Before::count);
    let before = counts.into_iter().scan(Before::default(), |sum, count| {
        let before = *sum;
        *sum = sum.and(count);
        Some(before)
    });
    let parts = parts.into_iter().zip(before).collect();
    workers::map(threads, parts, |(lines, before)| Part::read(file, lines, before)).into_iter().collect()
}

fn build(
    file: &Path,
    crease: f64,
    outline: &Outline,
    polygons: &Polygons,
    centre: DVec3,
    threads: NonZeroUsize,
) -> Result<Model, AssetError> {
    let (made, cuts) = polygons
        .triangulate(crease, threads)
        .map_err(|large| AssetError::new(file, Some(large.line as usize), large.reason()))?;
    if made.triangles.is_empty() {
        return Err(AssetError::new(file, None, why_empty(outline, &made)));
    }
    let mut report = ImportReport {
        triangles: made.triangles.len(),
        dropped_degenerate: made.dropped_degenerate,
        dropped_duplicates: made.dropped_duplicates,
        normals: None,
        notes: Vec::new(),
    };
    if made.computed_normals {
        report.normals = Some(how_computed(polygons, crease));
    }
    let mut model = Model { centre, ..Model::default() };
    assign_materials(file, outline, polygons, &cuts, &mut model, &mut report.notes);
    note_oddities(outline, &made, &mut report.notes);
    model.report = report;
    Triangles { positions: model.positions, normals: model.normals, uvs: model.uvs, triangles: model.triangles, .. } =
        made;
    Ok(model)
}

/// Puts the parts together, positions about the centre of their box, which is returned too.
fn gather(mut parts: Vec<Part>, outline: &Outline, threads: NonZeroUsize) -> (Polygons, DVec3) {
    let lengths: Vec<usize> = parts.iter().map(|part| part.positions.len() / 3).collect();
    let count = lengths.iter().sum();
    let centre = box_centre(&parts, count, threads);

    let mut places = vec![Vec3::ZERO; count];
    let slices = workers::slices(&mut places, lengths.iter().copied());
    let work = slices.into_iter().zip(parts.iter_mut().map(|part| std::mem::take(&mut part.positions))).collect();
    workers::map(threads, work, |(places, positions): (&mut [Vec3], Vec<f64>)| {
        for (place, position) in places.iter_mut().zip(positions.as_chunks::<3>().0) {
            // Adding 0 makes -0 and 0 the same bits.
            *place = (DVec3::from_array(*position) - centre).as_vec3() + 0.0;
        }
    });

    let (mut normals, mut uvs) = (vec![Vec3::ZERO], vec![Vec2::ZERO]);
    let total = |of: fn(&Part) -> usize| parts.iter().map(of).sum();
    normals.reserve_exact(total(|part| part.normals.len()));
    uvs.reserve_exact(total(|part| part.uvs.len()));
    let mut faces = Vec::with_capacity(total(|part| part.found.faces.len()));
    let mut start = 0;
    for part in &parts {
        normals.extend_from_slice(&part.normals);
        uvs.extend_from_slice(&part.uvs);
        faces.extend(part.found.faces.iter().map(|face| Face { start: face.start + start, ..*face }));
        start += part.found.corners.places.len() as u32;
    }
    let corners = join_corners(&parts, &first_of_equals(&places, threads), threads);
    let mut smoothings = outline.each(faces.len(), |run| run.smoothing);
    if smoothings.is_empty() {
        smoothings.push(outline.runs.first().map_or(Smoothing::Crease, |run| run.smoothing));
    }
    (Polygons { places, normals, uvs, corners, faces, smoothings }, centre)
}

/// The centre of the box around all positions that faces use.
fn box_centre(parts: &[Part], count: usize, threads: NonZeroUsize) -> DVec3 {
    let used: Vec<AtomicBool> = std::iter::repeat_with(AtomicBool::default).take(count).collect();
    workers::map(threads, parts.iter().collect(), |part: &Part| {
        for &index in &part.found.corners.places {
            let used = &used[index as usize - 1];
            // Most are set already, and reading takes no cache line from others.
            if !used.load(Ordering::Relaxed) {
                used.store(true, Ordering::Relaxed);
            }
        }
    });
    let mut used = &used[..];
    let work = parts
        .iter()
        .map(|part| {
            let (of_part, rest) = used.split_at(part.positions.len() / 3);
            used = rest;
            (of_part, part.positions.as_chunks::<3>().0)
        })
        .collect();
    let empty = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let boxes = workers::map(threads, work, |(used, positions)| {
        positions
            .iter()
            .zip(used)
            .filter(|(_, used)| used.load(Ordering::Relaxed))
            .fold(empty, |(lower, upper), (p, _)| (lower.min(DVec3::from_array(*p)), upper.max(DVec3::from_array(*p))))
    });
    let (lower, upper) = boxes.into_iter().fold(empty, |a, b| (a.0.min(b.0), a.1.max(b.1)));
    if lower.is_finite() { lower * 0.5 + upper * 0.5 } else { DVec3::ZERO }
}

/// So many places are compared on one thread.
const FEW: usize = 1 << 14;

/// For each place the first that equals it; empty if all are distinct.
fn first_of_equals(places: &[Vec3], threads: NonZeroUsize) -> Vec<u32> {
    // Equal ones have equal hashes: each thread looks at its share of these.
    let shares = if places.len() < FEW { 1 } else { threads.get() };
    let doubles = workers::map(threads, (0..shares).collect(), |share| {
        let mut interner = Interner::<3>::with_capacity(places.len() / shares);
        let (mut firsts, mut doubles) = (Vec::with_capacity(places.len() / shares), Vec::new());
        for (index, place) in (0..).zip(places) {
            let key = place.to_array().map(f32::to_bits);
            if shares > 1 && (hash(&key) >> 40) % shares != share {
                continue;
            }
            let number = interner.number(key) as usize;
            match firsts.get(number) {
                Some(&first) => doubles.push((index, first)),
                None => firsts.push(index),
            }
        }
        doubles
    });
    if doubles.iter().all(Vec::is_empty) {
        return Vec::new();
    }
    let mut first: Vec<u32> = (0..places.len() as u32).collect();
    for (index, equal) in doubles.into_iter().flatten() {
        first[index as usize] = equal;
    }
    first
}

/// The corners of all parts; `first` as of [`first_of_equals`].
fn join_corners(parts: &[Part], first: &[u32], threads: NonZeroUsize) -> Corners {
    let join = |of: fn(&Corners) -> &Vec<u32>, map: &(dyn Fn(u32) -> u32 + Sync)| {
        if parts.iter().all(|part| of(&part.found.corners).is_empty()) {
            return Vec::new();
        }
        let count = |part: &Part| part.found.corners.places.len();
        let mut joined = vec![0; parts.iter().map(count).sum()];
        let slices = workers::slices(&mut joined, parts.iter().map(count));
        let work = slices.into_iter().zip(parts).collect();
        workers::map(threads, work, |(joined, part): (&mut [u32], &Part)| {
            // A part where no face has any stays at 0.
            joined.iter_mut().zip(of(&part.found.corners)).for_each(|(to, &from)| *to = map(from));
        });
        joined
    };
    Corners {
        places: if first.is_empty() {
            join(|corners| &corners.places, &|index| index - 1)
        } else {
            join(|corners| &corners.places, &|index| first[index as usize - 1])
        },
        uvs: join(|corners| &corners.uvs, &|index| index),
        normals: join(|corners| &corners.normals, &|index| index),
    }
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
    let which = if polygons.have_normals().0 { "missing normals" } else { "normals" };
    let has_groups = polygons.smoothings.iter().any(|s| matches!(s, Smoothing::Group(_)));
    let has_creases = polygons.smoothings.contains(&Smoothing::Crease);
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
    cuts: &[Cut],
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
            if loaded.insert(path.clone()) {
                if let Err(error) = library.load(&path, &mut resolver) {
                    notes.push(format!("material library not usable: {error}"));
                }
                model.libraries.push(path);
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
    let of_faces = outline.each(polygons.faces.len(), |run| run.material);
    // Where all faces are alike, one triangle stands for all.
    let cuts = if of_faces.is_empty() { &cuts[..1] } else { cuts };
    model.triangle_materials.reserve(cuts.len());
    for cut in cuts {
        let number = of_faces.get(cut[3] as usize).copied().unwrap_or(outline.runs[0].material);
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
