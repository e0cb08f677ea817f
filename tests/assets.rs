//! Models and pictures that people really have: one test for each row of the table of what loading must do, then
//! properties on random input.

use glam::{DVec2, DVec3, Vec3};
use glimt::assets::{self, AssetError, Model, load_image};
use glimt::description::{MaterialDesc, TextureSource, Wrap};
use glimt::math::{Rgb, SplitMix64};
use std::fmt::Write as _;
use std::fs;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};

fn load_obj(file: &Path, crease: f64) -> Result<Model, AssetError> {
    load_obj_on(2, file, crease)
}

fn load_obj_on(threads: usize, file: &Path, crease: f64) -> Result<Model, AssetError> {
    assets::load_obj(file, crease, NonZeroUsize::new(threads).expect("not 0"))
}

/// A directory of its own for each test, removed at its end.
struct Dir(PathBuf);

impl Dir {
    fn new() -> Self {
        static NEXT: AtomicU32 = AtomicU32::new(0);
        let name = format!("glimt-assets-{}-{}", std::process::id(), NEXT.fetch_add(1, Ordering::Relaxed));
        let dir = std::env::temp_dir().join(name);
        fs::create_dir_all(&dir).expect("temporary directory");
        Self(dir)
    }

    fn write(&self, name: &str, bytes: impl AsRef<[u8]>) -> PathBuf {
        let path = self.0.join(name);
        fs::create_dir_all(path.parent().expect("parent")).expect("directory");
        // Writing over a file makes some file systems wait for the disk.
        let _ = fs::remove_file(&path);
        fs::write(&path, bytes).expect("write");
        path
    }

    fn load(&self, obj: impl AsRef<[u8]>) -> Result<Model, AssetError> {
        load_obj(&self.write("model.obj", obj), 30.0)
    }

    /// The material of a one-triangle model whose library has this text after `newmtl m`.
    fn material(&self, mtl: &str) -> (MaterialDesc, Model) {
        self.write("model.mtl", format!("newmtl m\n{mtl}\n"));
        let model = self.load(format!("mtllib model.mtl\n{CORNERS}usemtl m\nf 1 2 3\n")).expect("model");
        (model.materials.first().expect("a material").clone(), model)
    }
}

impl Drop for Dir {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// Four corners of the unit square in z = 0, counter-clockwise from +z.
const CORNERS: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

fn load(obj: impl AsRef<[u8]>) -> Result<Model, AssetError> {
    Dir::new().load(obj)
}

fn good(obj: impl AsRef<[u8]>) -> Model {
    let model = load(obj).unwrap_or_else(|e| panic!("refused: {e}"));
    validate(&model);
    model
}

/// The line and the text of the error.
fn refused(obj: impl AsRef<[u8]>) -> (Option<usize>, String) {
    let error = load(obj).expect_err("accepted");
    (error.line, error.to_string())
}

fn has_note(model: &Model, part: &str) -> bool {
    model.report.normals.iter().chain(&model.report.notes).any(|n| n.contains(part))
}

/// What every model promises.
fn validate(model: &Model) {
    let Model { positions, normals, uvs, triangles, triangle_materials, materials, report, .. } = model;
    assert!(model.centre.is_finite());
    assert!(positions.iter().all(|p| p.is_finite()));
    assert!(normals.is_empty() || normals.len() == positions.len());
    assert!(normals.iter().all(|n| (n.length() - 1.0).abs() < 1e-5), "normals are units");
    assert!(uvs.is_empty() || uvs.len() == positions.len());
    assert!(uvs.iter().all(|uv| uv.is_finite()));
    assert!(triangles.iter().flatten().all(|&i| (i as usize) < positions.len()));
    assert_eq!(triangles.len(), report.triangles);
    assert!(!triangles.is_empty());
    if materials.len() > 1 {
        assert_eq!(triangle_materials.len(), triangles.len());
        assert!(triangle_materials.iter().all(|&m| (m as usize) < materials.len()));
    } else {
        assert!(triangle_materials.is_empty());
    }
    for &[a, b, c] in triangles {
        let [a, b, c] = [a, b, c].map(|i| positions[i as usize].as_dvec3());
        assert!(a != b && b != c && c != a);
    }
    for m in materials {
        assert!(m.color.is_finite());
        let k = [m.ambient, m.diffuse, m.specular, m.reflect, m.transmit];
        assert!(k.iter().all(|v| (0.0..=1.0).contains(v)), "{m:?}");
        assert!(m.shininess >= 1.0 && m.ior > 0.0);
    }
}

/// Twice the vector area of each triangle, in the sense of its winding.
fn crosses(model: &Model) -> Vec<DVec3> {
    let corner = |i: u32| model.positions[i as usize].as_dvec3();
    model.triangles.iter().map(|&[a, b, c]| (corner(b) - corner(a)).cross(corner(c) - corner(a))).collect()
}

/// Sum of the unsigned areas of the triangles.
fn area(model: &Model) -> f64 {
    crosses(model).iter().map(|c| c.length() / 2.0).sum()
}

/// Every corner of every triangle: position in the file's space, and normal.
fn corners(model: &Model) -> impl Iterator<Item = (DVec3, Option<Vec3>)> {
    model.triangles.iter().flatten().map(|&i| {
        let i = i as usize;
        (model.centre + model.positions[i].as_dvec3(), model.normals.get(i).copied())
    })
}

// The rows of the table.

#[test]
fn a_colour_of_one_number_is_grey() {
    let (m, _) = Dir::new().material("Kd 0.5");
    assert_eq!(m.color, Rgb::WHITE);
    assert_eq!(m.diffuse, 0.5);
    let (m, _) = Dir::new().material("Kd 0.8 0.4");
    assert_eq!(m.color, Rgb::new(1.0, 0.5, 1.0), "b defaults to r");
}

#[test]
fn a_vertex_may_have_a_weight() {
    let model = good("v 0 0 0 1\nv 1 0 0 1.0\nv 0 1 0 0.5\nf 1 2 3\n");
    assert_eq!(area(&model), 0.5, "weights matter to free-form surfaces only");
    assert!(has_note(&model, "weights of 1 vertex ignored"));
    assert_eq!(good("v 0 0 0 0\nv 1 0 0 0\nv 0 1 0 0\nf 1 2 3\n").triangles.len(), 1);
}

#[test]
fn some_vertices_may_have_colours() {
    let model = good("v 0 0 0 1 0 0\nv 1 0 0\nv 0 1 0 0.5 0.5 0.5 1\nv 1 1 0 1 0\nf 1 2 3\nf 4 3 2\n");
    assert_eq!(area(&model), 1.0);
    assert!(has_note(&model, "colours of 2 vertices ignored"));
}

#[test]
fn a_coordinate_that_is_no_number_of_size_is_refused_with_its_line() {
    for (bad, why) in [
        ("nan", "not a finite number"),
        ("-inf", "not a finite number"),
        ("1e39", "too large"),
        ("-1e400", "not a finite number"),
        ("1.#QNAN", "not a number"),
        ("0,5", "decimal point"),
        ("x", "not a number"),
    ] {
        let (line, text) = refused(format!("# first\nv 0 0 0\nv 1 0 {bad}\nv 0 1 0\nf 1 2 3\n"));
        assert_eq!(line, Some(3), "{text}");
        assert!(text.contains(bad) && text.contains(why), "{text}");
        assert!(text.contains("model.obj:3: "), "{text}");
        let (line, _) = refused(format!("{CORNERS}vt 0 {bad}\nf 1/1 2/1 3/1\n"));
        assert_eq!(line, Some(5));
    }
    let (line, text) = refused("v 0 0\n");
    assert_eq!((line, text.contains("needs 3 numbers and has 2")), (Some(1), true));
    assert_eq!(good("v -3e38 0 0\nv 3e38 0 0\nv 0 3e38 0\nf 1 2 3").triangles.len(), 1);
}

#[test]
fn normals_on_some_faces_only_are_completed() {
    let obj = format!("{CORNERS}v 0 0 1\nvn 1 0 9\nf 1//1 2//1 3//1\nf 1/ 3// 4\nf 1//1 4 5\n");
    let model = good(obj);
    assert!(has_note(&model, "missing normals computed"));
    let given = Vec3::new(1.0, 0.0, 9.0).normalize();
    let normals: Vec<_> = corners(&model).map(|(_, n)| n.expect("normals")).collect();
    assert!(normals[..3].iter().all(|&n| (n - given).length() < 1e-6));
    assert!(normals[3..6].iter().all(|&n| n.dot(Vec3::Z) > 0.999));
    assert!(normals[6..].iter().all(|&n| n.dot(Vec3::X) > 0.999), "a face with one normal has none: {normals:?}");
}

#[test]
fn normals_of_no_use_are_computed() {
    let obj = format!("{CORNERS}vn 0 0 0\nvn nan 0 1\nvn -1.#IND 0 0\nvn 0 0 1e300\nf 1//1 2//2 3//3 4//4\n");
    assert!(good(obj).normals.is_empty(), "the face is flat");
}

#[test]
fn a_concave_polygon_is_covered_exactly() {
    // An arrow head whose fan from the first corner is wrong, a star, a comb.
    let arrow: &[[f64; 2]] = &[[0.0, 0.0], [2.0, 1.0], [0.0, 2.0], [1.0, 1.0]];
    let star: Vec<[f64; 2]> = (0..10)
        .map(|i| {
            let (r, a) = (if i % 2 == 0 { 1.0 } else { 0.3 }, i as f64 * std::f64::consts::TAU / 10.0);
            [r * a.cos(), r * a.sin()]
        })
        .collect();
    let comb: Vec<[f64; 2]> =
        (0..21).map(|i| [i as f64, if i % 2 == 0 { 0.1 } else { 5.0 }]).chain([[20.0, 0.0], [0.0, 0.0]]).collect();
    let comb: Vec<_> = comb.into_iter().rev().collect();
    for polygon in [arrow, &star, &comb] {
        for turn in 0..polygon.len() {
            let mut turned = polygon.to_vec();
            turned.rotate_left(turn);
            check_polygon(&turned);
        }
    }
}

/// In several planes and both windings: n - 2 triangles, all wound as the polygon, areas adding up to its own.
fn check_polygon(polygon: &[[f64; 2]]) {
    let planes: [fn([f64; 2]) -> [f64; 3]; 4] =
        [|[x, y]| [x, y, 0.0], |[x, y]| [y, 3.0, x], |[x, y]| [-7.0, x, y], |[x, y]| [x, y, 0.5 * x - 0.25 * y]];
    for plane in planes {
        for reverse in [false, true] {
            let mut points: Vec<_> = polygon.iter().map(|&p| plane(p)).collect();
            if reverse {
                points.reverse();
            }
            let mut obj = String::new();
            points.iter().for_each(|[x, y, z]| writeln!(obj, "v {x} {y} {z}").expect("string"));
            obj.push('f');
            (1..=points.len()).for_each(|i| write!(obj, " {i}").expect("string"));
            let model = good(&obj);
            let newell: DVec3 =
                (0..points.len()).map(|i| DVec3::from(points[i]).cross(points[(i + 1) % points.len()].into())).sum();
            let crosses = crosses(&model);
            assert_eq!(crosses.len(), polygon.len() - 2);
            assert!(crosses.iter().all(|c| c.dot(newell) > 0.0), "winding kept");
            let (sum, expected) = (crosses.iter().map(|c| c.length()).sum::<f64>(), newell.length());
            assert!((sum - expected).abs() < 1e-5 * expected, "{sum} {expected} {polygon:?}");
        }
    }
}

#[test]
fn comments_and_continued_lines_are_read() {
    let model = good("v 0 0 0 # origin\nv 1 0 \\\n  0\nv 0 1 0#y\n# ends in \\\nf 1 \\\n 2 3 # note \\\nl 1 2\n");
    assert_eq!((model.triangles.len(), area(&model)), (1, 0.5));
    assert!(has_note(&model, "1 line or point element skipped"));
}

#[test]
fn options_of_a_map_are_applied() {
    let dir = Dir::new();
    let png = dir.write("tex/wood.png", "");
    let (m, model) = dir.material("map_Kd -s 2 3 2 -o 0.5 -bm 2 -imfchan m -clamp on -mm 0 1 -t 1 tex\\wood.png");
    let texture = m.texture.expect("texture");
    assert_eq!(texture.source, TextureSource::Image { file: png.clone(), wrap: Wrap::Clamp });
    assert_eq!((texture.scale, texture.offset), (DVec2::new(2.0, 3.0), DVec2::new(0.5, 0.0)));
    assert_eq!(m.diffuse, 1.0);
    assert_eq!(model.report.notes, Vec::<String>::new());
    let (m, _) = dir.material("Kd 0 0 0\nmap_Kd -clamp off -s 4 \"tex/wood.png\"");
    let texture = m.texture.expect("texture");
    assert_eq!(texture.source, TextureSource::Image { file: png, wrap: Wrap::Repeat });
    assert_eq!((texture.scale, m.diffuse), (DVec2::new(4.0, 1.0), 1.0), "black beside a texture means nothing");
}

#[test]
fn a_map_is_found_beside_the_library_then_the_model_then_in_any_case() {
    let dir = Dir::new();
    dir.write("a.png", "");
    let beside_library = dir.write("mtl/a.png", "");
    let beside_model = dir.write("b.png", "");
    let odd_case = dir.write("mtl/Textures/Wood Grain.PNG", "");
    dir.write("mtl/x.mtl", "newmtl a\nmap_Kd a.png\nnewmtl b\nmap_Kd b.png\nnewmtl c\nmap_Kd textures\\wood grain.png\nnewmtl d\nmap_Kd C:\\Art\\B.png\n");
    let uses: String =
        ["a", "b", "c", "d"].iter().zip(1..).map(|(m, i)| format!("usemtl {m}\nf 1 2 {}\n", i + 2)).collect();
    let model = dir.load(format!("mtllib mtl/x.mtl\n{CORNERS}v 0 2 0\nv 0 3 0\n{uses}")).expect("model");
    let found: Vec<_> = model.materials.iter().map(|m| m.texture.clone().expect("found").source).collect();
    let expected = [beside_library, beside_model.clone(), odd_case, beside_model];
    for (found, file) in found.iter().zip(expected) {
        let TextureSource::Image { file: found, .. } = found else { panic!("an image") };
        assert_eq!(found.canonicalize().expect("exists"), file.canonicalize().expect("exists"));
    }
}

#[test]
fn names_may_have_blanks_and_comments_behind_them() {
    let dir = Dir::new();
    dir.write("a.png", "");
    dir.write("my wood.png", "");
    let file = |m: MaterialDesc| match m.texture.expect("texture").source {
        TextureSource::Image { file, .. } => file.file_name().expect("name").to_string_lossy().into_owned(),
        TextureSource::Checker { .. } => panic!("an image"),
    };
    assert_eq!(file(dir.material("map_Kd a.png # x").0), "a.png");
    assert_eq!(file(dir.material("map_Kd my wood.png").0), "my wood.png");
    dir.write("number #2.png", "");
    assert_eq!(file(dir.material("map_Kd number #2.png").0), "number #2.png");
    dir.write("m.mtl", "newmtl Material #1\nKd 1 0 0\nnewmtl Material #2  \nKd 0 1 0\n");
    let obj = format!("mtllib m.mtl\n{CORNERS}usemtl Material #2\nf 1 2 3\nusemtl Material #1\nf 1 3 4\n");
    let colors: Vec<_> = dir.load(obj).expect("model").materials.iter().map(|m| m.color).collect();
    assert_eq!(colors, [Rgb::new(0.0, 1.0, 0.0), Rgb::new(1.0, 0.0, 0.0)], "in order of first use");
}

#[test]
fn a_line_that_cannot_be_used_costs_itself_only() {
    let dir = Dir::new();
    let (m, model) = dir.material("Kd spectral red.rfl\nKa xyz 1 1 1\nKs 0.25\nd -halo 0.5\nillum 4\nNs oops\nNi 1.4");
    assert_eq!((m.specular, m.transmit, m.ior), (0.25, 0.5, 1.4));
    for part in ["model.mtl:2: spectral", "model.mtl:3: xyz", "model.mtl:7: `oops`", "-halo"] {
        assert!(has_note(&model, part), "{part}: {:?}", model.report.notes);
    }
}

#[test]
fn less_common_keywords_and_other_case_are_read() {
    let dir = Dir::new();
    dir.write("a.png", "");
    let (m, model) =
        dir.material("kd 0.5 0.25 0\nKS .5\nTr 0.25\nILLUM 4\nMAP_KD a.png\nmap_Ke glow.png\nnI 1.2\nns 10");
    assert_eq!((m.transmit, m.specular, m.reflect, m.ior, m.shininess), (0.25, 0.5, 0.5, 1.2, 10.0));
    assert!(m.texture.is_some());
    assert!(has_note(&model, "map_Ke"));
    assert_eq!(dir.material("Tf 0.75 0.5 0.5\nillum 6").0.transmit, 0.75);
    assert_eq!(dir.material("Tf 1 1 1\nillum 4").0.transmit, 0.0, "exporters write it for opaque things");
}

#[test]
fn illum_chooses_the_lighting() {
    let dir = Dir::new();
    let of = |illum: &str| dir.material(&format!("Kd 0.5\nKs 0.25\nd 0.25\nillum {illum}"));
    let (m, _) = of("0.0");
    assert_eq!((m.color, m.ambient, m.diffuse, m.specular), (Rgb::grey(0.5), 1.0, 0.0, 0.0));
    for (illum, specular, reflect, transmit, fresnel) in [
        ("1", 0.0, 0.0, 0.0, false),
        ("2.0", 0.25, 0.0, 0.0, false),
        ("3", 0.25, 0.25, 0.0, false),
        ("4", 0.25, 0.25, 0.75, false),
        ("5", 0.25, 0.25, 0.0, true),
        ("6", 0.25, 0.25, 0.75, false),
        ("7", 0.25, 0.25, 0.75, true),
        ("8", 0.25, 0.0, 0.0, false),
        ("9", 0.25, 0.0, 0.0, false),
        ("10", 0.25, 0.0, 0.0, false),
    ] {
        let (m, model) = of(illum);
        assert_eq!((m.specular, m.reflect, m.transmit, m.fresnel), (specular, reflect, transmit, fresnel), "{illum}");
        assert_eq!(m.diffuse, 0.5 * (1.0 - transmit), "what passes is not scattered too");
        assert_eq!(has_note(&model, "illum 10"), illum == "10");
        assert_eq!(has_note(&model, "opaque in spite of d"), transmit == 0.0);
    }
    assert!(has_note(&of("11").1, "there is no illum 11"));
}

#[test]
fn a_missing_library_or_picture_is_named_and_replaced() {
    let dir = Dir::new();
    let model = dir.load(format!("mtllib no such.mtl\n{CORNERS}usemtl m\nf 1 2 3\n")).expect("model");
    assert_eq!(model.materials, []);
    assert!(has_note(&model, "material library not found: no such.mtl"));
    let (m, model) = dir.material("Kd 0.5 0.5 0\nmap_Kd gone.png\nnewmtl other\nmap_Kd gone.png\nmap_Kd lost.png");
    assert_eq!((m.texture, m.color), (None, Rgb::new(1.0, 1.0, 0.0)));
    assert!(has_note(&model, "2 textures not found: gone.png, lost.png"), "{:?}", model.report.notes);
    dir.write("model.mtl", "newmtl m\nKd 1\n");
    let obj = format!("mtllib model.mtl\n{CORNERS}f 1 2 3\nusemtl m\nf 1 3 4\nusemtl n\nf 1 2 4\n");
    let model = dir.load(obj).expect("model");
    validate(&model);
    assert_eq!(model.triangle_materials, [0, 1, 0]);
    assert_eq!(model.materials[0], MaterialDesc::default());
    assert!(has_note(&model, "1 material not found: n"));
}

#[test]
fn an_index_that_names_nothing_is_refused_with_its_line() {
    for (face, part) in [
        ("f 1 2 0", "start at 1"),
        ("f 1 2 5", "too high: the file has 4 vertices"),
        ("f 1 2 -5", "only 4 vertices"),
        ("f 1/1 2/1 3/2", "the file has 1 texture coordinates"),
        ("f 1//1 2//1 3//-2", "only 1 normals"),
        ("f 1 2 99999999999999999999999", "too high"),
        ("f 1 2 3.5", "not a corner"),
        ("f 1 2 /3", "not a corner"),
        ("f 1 2 3/1/1/1", "not a corner"),
        ("f 1 2 -", "not a corner"),
    ] {
        let (line, text) = refused(format!("{CORNERS}vt 0 0\nvn 0 0 1\nf 1 2 3\n{face}\n"));
        assert!(line == Some(8) && text.contains(part), "{face}: {text}");
    }
}

#[test]
fn indices_may_count_back_or_look_ahead() {
    let back = good("v 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1\nv 1 1 0\nf -1 -2 -3\n");
    assert_eq!(area(&back), 1.0);
    assert!(crosses(&back).iter().all(|c| c.z > 0.0));
    let ahead = good("f 1 2 3\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nf 1//1 2//1 4//1\nf 1 2 3\nv 0 2 0\n");
    assert_eq!((ahead.triangles.len(), ahead.report.dropped_duplicates), (2, 1));
    assert_eq!(area(&ahead), 1.5);
}

/// Positions and faces of an icosahedron split `levels` times, on the unit sphere, faces wound outward.
fn icosphere(levels: usize) -> String {
    let p = (1.0 + 5f64.sqrt()) / 2.0;
    let mut triangles: Vec<[DVec3; 3]> = Vec::new();
    let corners: Vec<DVec3> = [-1.0, 1.0]
        .iter()
        .flat_map(|&a| [-p, p].map(|b| [DVec3::new(0.0, a, b), DVec3::new(a, b, 0.0), DVec3::new(b, 0.0, a)]))
        .flatten()
        .collect();
    for (i, &a) in corners.iter().enumerate() {
        for (j, &b) in corners.iter().enumerate().skip(i + 1) {
            for &c in &corners[j + 1..] {
                if [a - b, b - c, c - a].iter().all(|e| (e.length() - 2.0).abs() < 1e-9) {
                    let outward = (b - a).cross(c - a).dot(a) > 0.0;
                    triangles.push(if outward { [a, b, c] } else { [a, c, b] });
                }
            }
        }
    }
    for _ in 0..levels {
        triangles = triangles
            .into_iter()
            .flat_map(|[a, b, c]| {
                let [ab, bc, ca] = [(a + b) / 2.0, (b + c) / 2.0, (c + a) / 2.0];
                [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
            })
            .map(|t| t.map(DVec3::normalize))
            .collect();
    }
    let mut obj = String::new();
    for (i, t) in triangles.iter().enumerate() {
        // Vertices doubled on purpose: places count, not indices. Rounded, so that doubles are equal.
        for p in t.map(DVec3::normalize) {
            writeln!(obj, "v {:.6} {:.6} {:.6}", p.x, p.y, p.z).expect("string");
        }
        writeln!(obj, "f {} {} {}", 3 * i + 1, 3 * i + 2, 3 * i + 3).expect("string");
    }
    obj
}

/// A cube about the origin, edges 2, quads wound outward.
const CUBE: &str = "v -1 -1 -1\nv 1 -1 -1\nv 1 1 -1\nv -1 1 -1\nv -1 -1 1\nv 1 -1 1\nv 1 1 1\nv -1 1 1\n\
                    f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";

#[test]
fn without_normals_edges_are_smooth_up_to_the_crease_angle() {
    let cube = good(CUBE);
    assert!(cube.normals.is_empty(), "flat");
    assert_eq!(cube.positions.len(), 8);
    assert!(cube.report.notes.is_empty(), "{:?}", cube.report.notes);

    let dir = Dir::new();
    let path = dir.write("cube.obj", CUBE);
    let round = load_obj(&path, 91.0).expect("cube");
    assert_eq!(round.positions.len(), 8);
    for (p, n) in corners(&round) {
        // Each corner of the cube belongs to three right angles, however the squares are cut.
        assert!((n.expect("smooth") - p.normalize().as_vec3()).length() < 1e-6);
    }
    assert!(has_note(&round, "normals computed (crease 91 degrees)"));

    let sphere = good(icosphere(3));
    assert_eq!(sphere.triangles.len(), 20 * 64);
    assert_eq!(sphere.positions.len(), 10 * 64 + 2, "doubled vertices are merged");
    for (p, n) in corners(&sphere) {
        assert!(n.expect("smooth").as_dvec3().dot(p) > 0.9999);
    }
    let flat = load_obj(&dir.write("sphere.obj", icosphere(3)), 0.0).expect("sphere");
    assert!(flat.normals.is_empty());
}

#[test]
fn the_tip_of_a_fine_cone_has_one_normal() {
    // Angles of 4e-5 at the tip: too small for a cosine in f32.
    let n = 100_000;
    let mut obj = "v 0 0 1\n".to_owned();
    for i in 0..n {
        let a = i as f64 * std::f64::consts::TAU / n as f64;
        writeln!(obj, "v {} {} 0", a.cos(), a.sin()).expect("string");
    }
    (0..n).for_each(|i| writeln!(obj, "f 1 {} {}", i + 2, (i + 1) % n + 2).expect("string"));
    let model = good(obj);
    assert_eq!(model.positions.len(), n + 1);
    let tip = corners(&model).find(|(p, _)| p.z == 1.0).expect("tip").1.expect("smooth");
    assert!((tip - Vec3::Z).length() < 1e-3, "{tip}");
}

#[test]
fn an_edge_is_sharp_by_its_own_angle() {
    // A roof of two slopes 80 degrees apart beside a row of gentle strips: one sharp edge, many smooth ones.
    let mut obj = String::new();
    let turns = [0.0, 10.0, 20.0, 30.0, 110.0, 120.0_f64];
    let (mut x, mut y) = (0.0, 0.0);
    for k in 0..=turns.len() {
        writeln!(obj, "v {x} {y} 0\nv {x} {y} 1").expect("string");
        let angle = turns.get(k).copied().unwrap_or_default().to_radians();
        (x, y) = (x + angle.cos(), y - angle.sin());
    }
    for k in 0..turns.len() {
        let i = 2 * k + 1;
        writeln!(obj, "f {} {} {} {}", i, i + 1, i + 3, i + 2).expect("string");
    }
    let model = good(obj);
    let per_place = |k: usize| {
        let here = corners(&model).nth(6 * k).expect("strip").0;
        let mut normals: Vec<_> =
            corners(&model).filter(|(p, _)| *p == here).map(|(_, n)| n.expect("normal")).collect();
        normals.dedup_by(|a, b| (*a - *b).length() < 1e-6);
        normals.sort_by(|a, b| a.x.total_cmp(&b.x));
        normals.dedup_by(|a, b| (*a - *b).length() < 1e-6);
        normals.len()
    };
    assert_eq!([1, 2, 3, 4, 5].map(per_place), [1, 1, 1, 2, 1]);
}

#[test]
fn smoothing_groups_are_followed() {
    let with = |s: &str| CUBE.replace("\nf", &format!("\n{s}\nf"));
    let smooth = good(with("s 1"));
    assert_eq!(smooth.normals.len(), 8);
    assert!(has_note(&smooth, "smoothing groups"));
    assert!(good(with("s off")).normals.is_empty());
    assert!(good(with("s 0")).normals.is_empty());
    // Two groups: top and bottom against the sides.
    let two = "f 1 4 3 2\nf 5 6 7 8\ns 2\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";
    let model = good(format!("{}s 1\n{two}", &CUBE[..CUBE.find('f').expect("faces")]));
    assert_eq!(model.positions.len(), 16);
    for (_, n) in corners(&model) {
        let n = n.expect("normal").abs();
        assert!(n.z > 0.999 || n.z < 1e-3, "{n}");
    }
    // The same group in another object is another group.
    let apart = good(format!("{CORNERS}v 0 0 1\nv 0 1 1\no a\ns 1\nf 1 2 3 4\no b\nf 1 4 6 5\n"));
    assert!(apart.normals.is_empty());
}

#[test]
fn flat_normals_of_a_file_are_left_out() {
    let normals = "vn 0 0 -1\nvn 0 0 1\nvn 0 -1 0\nvn 1 0 0\nvn 0 1 0\nvn -1 0 0\n";
    let mut number = 0;
    let faces: String = CUBE[CUBE.find('f').expect("faces")..]
        .lines()
        .map(|l| {
            number += 1;
            let corners: String = l[1..].split_whitespace().map(|v| format!(" {v}//{number}")).collect();
            format!("f{corners}\n")
        })
        .collect();
    let vertices = &CUBE[..CUBE.find('f').expect("faces")];
    assert!(good(format!("{vertices}{normals}{faces}")).normals.is_empty());
    let tilted = normals.replace("vn 0 0 1\n", "vn 0.1 0 1\n");
    assert_eq!(good(format!("{vertices}{tilted}{faces}")).normals.len(), 24);
}

#[test]
fn the_first_library_that_exists_counts_and_names_may_have_blanks() {
    let dir = Dir::new();
    dir.write("b.mtl", "newmtl m\nKd 0 1 0\nnewmtl only b\nKd 0 0 1\n");
    let color = |line: &str, name: &str| {
        let model = dir.load(format!("{line}\n{CORNERS}usemtl {name}\nf 1 2 3\n")).expect("model");
        assert!(!has_note(&model, "library"), "{:?}", model.report.notes);
        model.materials[0].color
    };
    assert_eq!(color("mtllib a.mtl b.mtl", "m"), Rgb::new(0.0, 1.0, 0.0));
    dir.write("a.mtl", "newmtl m\nKd 1 0 0\n");
    assert_eq!(color("mtllib a.mtl b.mtl", "m"), Rgb::new(1.0, 0.0, 0.0));
    assert_eq!(color("mtllib a.mtl b.mtl", "only b"), Rgb::new(0.0, 0.0, 1.0));
    dir.write("my materials.mtl", "newmtl m\nKd 0 0 1\n");
    assert_eq!(color("mtllib my materials.mtl", "m"), Rgb::new(0.0, 0.0, 1.0));
    assert_eq!(color("mtllib my materials.mtl a.mtl # both", "m"), Rgb::new(0.0, 0.0, 1.0));
    assert_eq!(color("mtllib A.MTL", "m"), Rgb::new(1.0, 0.0, 0.0));
}

#[test]
fn any_end_of_line_and_any_blanks_are_read() {
    let plain = "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl m\nf 1 2 3\n";
    let dir = Dir::new();
    dir.write("m.mtl", "\u{feff}newmtl m\r\n\tKd 1 0 0  \r\n");
    for text in [
        plain.replace('\n', "\r\n"),
        plain.replace('\n', "\r"),
        format!("\u{feff}{plain}"),
        plain.replace(' ', "\t"),
        plain.replace('\n', " \t \n  \t"),
        plain.trim_end().to_owned(),
    ] {
        let model = dir.load(&text).unwrap_or_else(|e| panic!("{text:?}: {e}"));
        assert_eq!((area(&model), model.materials[0].color), (0.5, Rgb::new(1.0, 0.0, 0.0)), "{text:?}");
    }
    let latin1 = b"# caf\xe9\no caf\xe9\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl caf\xe9\nf 1 2 3\n";
    let model = good(latin1);
    assert!(has_note(&model, "caf\u{fffd}"), "{:?}", model.report.notes);
}

#[test]
fn free_form_lines_and_points_are_skipped_and_counted() {
    let model = good(format!(
        "{CORNERS}vp 0 0\ncstype bezier\ndeg 3\ncurv 0 1 1 2 3 4\nend\np 1\nl 1 2\nf 1 2\nf 1 2 3\nwhat\n"
    ));
    assert_eq!(model.triangles.len(), 1);
    for part in
        ["5 free-form statements skipped", "3 line or point elements skipped", "1 unknown line ignored (line 14: what)"]
    {
        assert!(has_note(&model, part), "{part}: {:?}", model.report.notes);
    }
}

#[test]
fn triangles_without_area_and_doubles_are_dropped_and_counted() {
    let model =
        good(format!("{CORNERS}v 2 0 0\nv 0 0 0\nf 1 2 3\nf 1 1 2\nf 1 2 5\nf 6 1 2\nf 2 3 1\nf 3 2 1\nf 1 2 3 4 4\n"));
    assert_eq!(model.report.dropped_degenerate, 4);
    assert_eq!(model.report.dropped_duplicates, 2, "the other side is no double");
    assert_eq!(model.triangles.len(), 3);
    assert_eq!(model.report.to_string(), "3 triangles; 4 dropped (zero area); 2 dropped (duplicates)");
    // A sliver is no line: its middle is off by the last bit.
    let sliver = good("v -1 0 0\nv 1 0 0\nv 0 1e-30 0\nv 0 0.5 0\nv 0 -0.5 0\nf 1 2 3\nf 1 2 4\nf 2 1 5\n");
    assert_eq!(sliver.report.dropped_degenerate, 0);
    let (_, text) = refused(format!("{CORNERS}f 1 1 1\n"));
    assert!(text.contains("every face has zero area"), "{text}");
}

// Properties.

#[test]
fn corners_on_an_edge_leave_no_gap() {
    // A square with the middles of its sides: no triangle may span a side.
    let model = good("v 0 0 0\nv 1 0 0\nv 2 0 0\nv 2 1 0\nv 2 2 0\nv 1 2 0\nv 0 2 0\nv 0 1 0\nf 1 2 3 4 5 6 7 8\n");
    assert_eq!((model.triangles.len(), area(&model)), (6, 4.0));
    let mut used = [false; 8];
    model.triangles.iter().flatten().for_each(|&i| used[i as usize] = true);
    assert!(used.iter().all(|&u| u));
}

#[test]
fn random_simple_polygons_are_covered_exactly() {
    let mut rng = SplitMix64(11);
    for round in 0..300 {
        let n = 4 + (rng.next_u64() % 40) as usize;
        let mut points: Vec<DVec2> = (0..n).map(|_| DVec2::new(rng.unit(), rng.unit())).collect();
        // Uncrossing pairs of edges shortens the tour and so ends in a simple polygon.
        let side = |a: DVec2, b: DVec2, c: DVec2| (b - a).perp_dot(c - a);
        let mut crossed = true;
        while crossed {
            crossed = false;
            for i in 0..n {
                for j in i + 2..n {
                    let (a, b, c, d) = (points[i], points[i + 1], points[j], points[(j + 1) % n]);
                    let apart = (j + 1) % n != i;
                    if apart && side(a, b, c) * side(a, b, d) < 0.0 && side(c, d, a) * side(c, d, b) < 0.0 {
                        points[i + 1..=j].reverse();
                        crossed = true;
                    }
                }
            }
        }
        // f32 grid, so that the areas are exact.
        let points: Vec<_> = points.iter().map(|p| [f64::from(p.x as f32), f64::from(p.y as f32)]).collect();
        if round < 30 {
            check_polygon(&points);
        } else {
            let mut obj: String = points.iter().map(|[x, y]| format!("v {x} {y} 1\n")).collect();
            obj.push('f');
            (1..=n).for_each(|i| write!(obj, " {i}").expect("string"));
            let shoelace: f64 =
                (0..n).map(|i| DVec2::from(points[i]).perp_dot(points[(i + 1) % n].into())).sum::<f64>().abs() / 2.0;
            assert!((area(&good(obj)) - shoelace).abs() < 1e-6, "{points:?}");
        }
    }
}

#[test]
fn a_polygon_that_crosses_itself_is_told() {
    let model = good("v 0 0 0\nv 4 0 0\nv 4 4 0\nv 2 -2 0\nv 0 4 0\nf 1 2 3 4 5\n");
    assert!(has_note(&model, "1 polygon crossing themselves (line 6)"), "{:?}", model.report.notes);
}

#[test]
fn a_polygon_may_be_large_but_not_too_large() {
    // Teeth below a straight line: no fan is right, and half of the corners are reflex.
    let comb = |teeth: usize| {
        let mut obj = format!("v {} 1 0\nv -1 1 0\n", 2 * teeth);
        (0..2 * teeth).for_each(|i| writeln!(obj, "v {i} {} 0", if i % 2 == 0 { -5 } else { 0 }).expect("string"));
        obj.push('f');
        (1..=2 * teeth + 2).for_each(|i| write!(obj, " {i}").expect("string"));
        obj
    };
    let model = good(comb(1000));
    assert_eq!((model.triangles.len(), model.report.dropped_degenerate), (2000, 0));
    assert!(crosses(&model).iter().all(|c| c.z > 0.0));
    let (line, text) = refused(comb(5000));
    assert_eq!(line, Some(10_003), "{text}");
    assert!(text.contains("a concave polygon of 10002 corners"), "{text}");
    // A disc is a fan, whatever its size.
    let mut disc = String::new();
    (0..20_000).for_each(|i| {
        let a = i as f64 * std::f64::consts::TAU / 20_000.0;
        writeln!(disc, "v {} {} 0", a.cos(), a.sin()).expect("string");
    });
    disc.push('f');
    (1..=20_000).for_each(|i| write!(disc, " {i}").expect("string"));
    assert!((area(&good(disc)) - std::f64::consts::PI).abs() < 1e-6);
}

#[test]
fn positions_far_from_the_origin_keep_their_shape() {
    let model = good("v 1e6 1e6 1e6\nv 1000000.001 1e6 1e6\nv 1e6 1000000.001 1e6\nf 1 2 3\n");
    assert!((model.centre - DVec3::new(1e6 + 5e-4, 1e6 + 5e-4, 1e6)).length() < 1e-9);
    assert!((area(&model) - 5e-7).abs() < 1e-12);
}

#[test]
fn texture_coordinates_split_vertices_and_fill_with_zero() {
    let model = good(format!("{CORNERS}vt 0 0\nvt 1\nvt 0.5 0.5 0.5\nf 1/1 2/2 3/3\nf 1/1 3/1 4/1\nf 2 3 4\n"));
    assert_eq!(model.positions.len(), 6, "4 at the corners, 2 more for other coordinates");
    let at = |t: usize, c: usize| model.uvs[model.triangles[t][c] as usize].to_array();
    assert_eq!([at(0, 0), at(0, 1), at(0, 2)], [[0.0, 0.0], [1.0, 0.0], [0.5, 0.5]]);
    assert_eq!([at(2, 0), at(2, 1)], [[0.0, 0.0], [0.0, 0.0]]);
    assert!(good(format!("{CORNERS}vt 0 0\nf 1 2 3\n")).uvs.is_empty());
}

#[test]
fn what_is_no_model_is_refused_with_a_reason() {
    let dir = Dir::new();
    for (bytes, part) in [
        (&b""[..], "has no faces"),
        (b"v 0 0 0\n", "has no faces"),
        (b"solid cube\nfacet normal 0 0 1\n", "is it an OBJ file? (line 1 begins with `solid`)"),
        (b"\xff\xfev\0 \0", "UTF-16"),
        (b"BLENDER\0\0\0", "not a text file"),
        (b"cstype bezier\n", "free-form"),
    ] {
        let text = dir.load(bytes).expect_err("refused").to_string();
        assert!(text.contains(part), "{text}");
    }
    for (path, part) in [(dir.0.clone(), "is a directory"), (dir.0.join("none.obj"), "cannot be read")] {
        let text = load_obj(&path, 30.0).expect_err("refused").to_string();
        assert!(text.contains(part), "{text}");
    }
}

/// About 1.5 MB of everything that one line says about others: indices that count back or look ahead, materials,
/// groups, objects, continued lines.
fn tangle(rng: &mut SplitMix64) -> String {
    let mut obj = "mtllib m.mtl\nvn 0 0 1\nvt 0.5 0.5\n".to_owned();
    let mut vertices = 0;
    for block in 0..6000 {
        let mut below = |n: u64| rng.next_u64() % n;
        for _ in 0..4 + below(4) {
            let [x, y, z] = [0; 3].map(|_| below(200) as f64 / 8.0);
            writeln!(obj, "v {x} {y} \\\n {z} # {block}\nvt {x} {y}\nvn {z} 1 {y}").expect("string");
            vertices += 1;
        }
        match below(12) {
            0 => writeln!(obj, "usemtl m{}", below(4)),
            1 => writeln!(obj, "s {}", below(3)),
            2 => writeln!(obj, "o {block}"),
            3 => writeln!(obj, "l 1 2\nwhat is this"),
            _ => Ok(()),
        }
        .expect("string");
        for _ in 0..5 {
            let form = below(5);
            obj.push('f');
            for _ in 0..3 + below(9) / 4 {
                let i = if below(2) == 0 { below(4) as i64 - 4 } else { 1 + below(vertices) as i64 };
                match form {
                    0 | 1 => write!(obj, " {i}"),
                    2 => write!(obj, " {i}/{i}"),
                    3 => write!(obj, " {i}//-1"),
                    _ => writeln!(obj, " {i}/1/{i} \\"),
                }
                .expect("string");
            }
            obj.push('\n');
        }
    }
    obj + "f 1 2 3 # the end\n"
}

#[test]
fn any_number_of_threads_reads_the_same() {
    let dir = Dir::new();
    dir.write("m.mtl", "newmtl m0\nKd 1 0 0\nnewmtl m1\nKd 0 1 0\nnewmtl m2\nKd 0 0 1\n");
    let mut rng = SplitMix64(3);
    let obj = tangle(&mut rng);
    let path = dir.write("model.obj", &obj);
    let one = load_obj_on(1, &path, 30.0).expect("model");
    validate(&one);
    assert!(one.report.triangles > 20_000 && one.materials.len() == 4, "{}", one.report);
    assert!(one.uvs.len() == one.positions.len() && one.normals.len() == one.positions.len());
    for threads in [2, 3, 8] {
        let many = load_obj_on(threads, &path, 30.0).expect("model");
        assert_eq!(format!("{one:?}"), format!("{many:?}"), "{threads} threads");
    }
    // Of two errors the first is told, wherever the text is cut.
    for _ in 0..20 {
        let lines: Vec<&str> = obj.lines().collect();
        let at = (rng.next_u64() % (lines.len() as u64 - 2)) as usize + 2;
        if lines[at - 1].ends_with('\\') || lines[at - 2].ends_with('\\') {
            continue;
        }
        let (before, after) = (lines[..at].join("\n"), lines[at..].join("\n"));
        let path = dir.write("model.obj", format!("{before}\nv 1 oops 2\n{after}\nf 1 2 0\n"));
        for threads in [1, 4] {
            let error = load_obj_on(threads, &path, 30.0).expect_err("refused");
            assert_eq!((error.line, error.reason.contains("oops")), (Some(at + 1), true), "{error}");
        }
    }
}

#[test]
fn big_models_pass_the_limits_of_a_batch() {
    // A grid of 200 x 200 quads in several forms, so that the pass in front of tobj cuts it up often.
    let n = 200;
    let mut obj = String::new();
    for y in 0..=n {
        for x in 0..=n {
            writeln!(obj, "v {x} {y} 0\nvt {} {}", x as f64 / n as f64, y as f64 / n as f64).expect("string");
        }
    }
    obj.push_str("vn 0 0 1\n");
    for y in 0..n {
        for x in 0..n {
            let i = y * (n + 1) + x + 1;
            let corner = |i: usize| match y % 4 {
                0 => format!("{i}"),
                1 => format!("{i}/{i}"),
                2 => format!("{i}//1"),
                _ => format!("{i}/{i}/1"),
            };
            let [a, b, c, d] = [i, i + 1, i + n + 2, i + n + 1].map(corner);
            writeln!(obj, "f {a} {b} {c} {d}").expect("string");
        }
    }
    let model = good(obj);
    assert_eq!(model.triangles.len(), 2 * n * n);
    assert_eq!(area(&model), (n * n) as f64);
    assert!(model.normals.is_empty());
    assert!(crosses(&model).iter().all(|c| c.z == 1.0), "in order and wound as they were");
}

#[test]
fn mutated_models_load_or_are_refused() {
    let dir = Dir::new();
    dir.write("a.png", "");
    let mtl = "newmtl a\nKd 0.5 0.2 0.1\nKs 0.5\nNs 20\nd 0.5\nillum 7\nNi 1.5\nmap_Kd -s 2 2 2 -clamp on a.png\n\
               newmtl b c # note\nKa 0.1\nTr 0.3\nillum 4.0\nmap_Kd a.png # x\nTf 1 1 1\n";
    let obj = format!(
        "\u{feff}# glimt\r\nmtllib m.mtl\no one\n{CUBE}vt 0 0\nvt 1 0\nvt 1 1 0\nvn 0 0 1\nvn 1e-3 -2.5E+1 .5\n\
         usemtl a\ns 1\nf 1/1/1 2/2/1 3/3/2\nf -1 -2 -3 -4\ns off\nusemtl b c\nf 1//1 2//2 \\\n 3//1 # x\n\
         g two\nv 1 2 3 0.5\nv 4 5 6 1 0 0\nl 1 2\np 3\ncurv 0 1 2\nf 1 2 3 4 5 6 7 8\ns 2\nf 9 10 1\n"
    );
    let pieces = [
        "nan",
        "inf",
        "1e39",
        "-1",
        "0",
        "/",
        "//",
        "\\\n",
        "#",
        "\r",
        "\n",
        "\t",
        " ",
        "f ",
        "v ",
        "vn ",
        "vt ",
        "s 1\n",
        "o x\n",
        "usemtl a\n",
        "mtllib m.mtl\n",
        "99999999999",
        "-99999999999",
        "1 1 1 1 1 1 ",
        "\u{feff}",
        "Kd 0.5\n",
        "illum 1e9\n",
        "newmtl \n",
        "map_Kd -s\n",
        "map_Kd -o 1 \n",
        "d -halo\n",
        "Kd spectral\n",
        ".",
        "-",
        "e",
        "\0",
        "é",
    ];
    let mut rng = SplitMix64(2026);
    let mut mutate = |text: &str| -> Vec<u8> {
        let mut bytes = text.as_bytes().to_vec();
        for _ in 0..1 + rng.next_u64() % 3 {
            let mut at = |len: usize| (rng.next_u64() % (len as u64 + 1)) as usize;
            let (i, j) = (at(bytes.len()), at(bytes.len()));
            let (i, j) = (i.min(j), i.max(j).min(i.min(j) + 12));
            match at(5) {
                0 => drop(bytes.splice(i..i, pieces[at(pieces.len() - 1)].bytes())),
                1 => drop(bytes.drain(i..j)),
                2 => {
                    let copy = bytes[i..j].to_vec();
                    let to = at(bytes.len());
                    bytes.splice(to..to, copy);
                }
                3 => bytes.truncate(i.max(bytes.len() / 4)),
                4 => {
                    if let Some(byte) = bytes.get_mut(i) {
                        *byte = at(255) as u8;
                    }
                }
                _ => drop(bytes.splice(i..j, pieces[at(pieces.len() - 1)].bytes())),
            }
        }
        bytes
    };
    let (mut loaded, mut refused) = (0, 0);
    for round in 0..3000 {
        dir.write("m.mtl", mutate(mtl));
        let bytes = mutate(&obj);
        let path = dir.write("model.obj", &bytes);
        match load_obj(&path, [0.0, 30.0, 180.0][round % 3]) {
            Ok(model) => {
                validate(&model);
                assert!(!has_note(&model, "cannot be read as"), "{:?}", model.report.notes);
                loaded += 1;
            }
            Err(error) => {
                assert!(!error.reason.is_empty() && error.file == path);
                // Only what concerns the whole file has no line: never an accident in tobj.
                assert!(!error.reason.contains("cannot be read as"), "{error}: {:?}", String::from_utf8_lossy(&bytes));
                refused += 1;
            }
        }
    }
    assert!(loaded > 300 && refused > 300, "{loaded} {refused}");
}

// Pictures.

fn encode(dir: &Dir, name: &str, picture: image::DynamicImage) -> PathBuf {
    let path = dir.0.join(name);
    picture.save(&path).expect("saved");
    path
}

fn texels(path: &Path) -> Vec<[u8; 3]> {
    load_image(path).unwrap_or_else(|e| panic!("{e}")).texels
}

#[test]
fn pictures_of_every_kind_become_8_bit_rgb() {
    let dir = Dir::new();
    let rgb = image::RgbImage::from_fn(3, 2, |x, y| image::Rgb([x as u8 * 100, y as u8 * 200, 7]));
    let expected: Vec<[u8; 3]> = rgb.pixels().map(|p| p.0).collect();
    for name in ["a.png", "a.bmp", "a.tga"] {
        let path = encode(&dir, name, rgb.clone().into());
        let image = load_image(&path).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!((image.width, image.height), (3, 2));
        assert_eq!(image.texels, expected, "{name}: row 0 on top");
    }
    let grey = image::RgbImage::from_pixel(16, 16, image::Rgb([90; 3]));
    let jpeg = texels(&encode(&dir, "a.jpg", grey.into()));
    assert!(jpeg.iter().flatten().all(|v| v.abs_diff(90) <= 2));

    let deep = image::ImageBuffer::from_fn(256, 2, |x, y| image::Luma([(x * 257 + y * 128) as u16]));
    let deep = texels(&encode(&dir, "deep.png", image::DynamicImage::ImageLuma16(deep)));
    for x in 0..255 {
        assert_eq!(deep[x], [x as u8; 3]);
        assert_eq!(deep[256 + x], [x as u8; 3], "128 / 257 is rounded down");
    }
    let half = image::ImageBuffer::from_pixel(1, 1, image::Rgb([129_u16, 128, 65535]));
    assert_eq!(texels(&encode(&dir, "half.png", image::DynamicImage::ImageRgb16(half))), [[1, 0, 255]]);
    let clear = image::RgbaImage::from_pixel(1, 1, image::Rgba([10, 20, 30, 0]));
    assert_eq!(texels(&encode(&dir, "clear.png", clear.into())), [[10, 20, 30]], "alpha is dropped");
    let grey_alpha = image::ImageBuffer::from_pixel(1, 1, image::LumaA([50_u8, 9]));
    assert_eq!(texels(&encode(&dir, "ga.png", image::DynamicImage::ImageLumaA8(grey_alpha))), [[50; 3]]);
}

#[test]
fn a_picture_is_told_by_its_content() {
    let dir = Dir::new();
    let png = encode(&dir, "a.png", image::RgbImage::from_pixel(1, 1, image::Rgb([1, 2, 3])).into());
    for name in ["a.jpg", "a", "a.txt", "a.tga"] {
        let path = dir.0.join(name);
        fs::copy(&png, &path).expect("copied");
        assert_eq!(texels(&path), [[1, 2, 3]], "{name}");
    }
}

#[test]
fn a_picture_that_cannot_be_used_is_an_error_with_file_and_reason() {
    let dir = Dir::new();
    let png = encode(&dir, "a.png", image::RgbImage::from_pixel(64, 64, image::Rgb([1, 2, 3])).into());
    let whole = fs::read(png).expect("read");
    // A header of 100,000 x 100,000 with a right checksum: the PNG and the BMP.
    let mut bomb = whole[..33].to_vec();
    for at in [16, 20] {
        bomb[at..at + 4].copy_from_slice(&100_000_u32.to_be_bytes());
    }
    let crc = crc32(&bomb[12..29]).to_be_bytes();
    bomb[29..33].copy_from_slice(&crc);
    let mut bmp = b"BM\0\0\0\0\0\0\0\0\x36\0\0\0\x28\0\0\0".to_vec();
    bmp.extend([100_000_u32.to_le_bytes(), 100_000_u32.to_le_bytes()].concat());
    bmp.extend([1, 0, 24, 0]);
    bmp.extend([0; 24]);
    for (name, bytes, part) in [
        ("bomb.png", &bomb[..], "16384"),
        ("bomb.bmp", &bmp, "too large"),
        ("cut.png", &whole[..whole.len() / 2], ""),
        ("empty.png", b"", ""),
        ("text.png", b"hello, this is text and no picture", ""),
        ("text.txt", b"hello, this is text and no picture", "known kind"),
        ("a.gif", b"GIF89a\x01\0\x01\0\0\0\0", "known kind"),
    ] {
        let path = dir.write(name, bytes);
        let error = load_image(&path).expect_err(name);
        assert_eq!(error.file, path);
        assert!(error.reason.contains(part) && !error.reason.is_empty(), "{error}");
        println!("{error}");
    }
    assert!(load_image(&dir.0).expect_err("directory").reason.contains("directory"));
    assert!(load_image(&dir.0.join("none.png")).expect_err("missing").reason.contains("cannot be read"));
}

#[test]
fn mutated_pictures_load_or_are_refused() {
    let dir = Dir::new();
    let picture = image::RgbImage::from_fn(9, 7, |x, y| image::Rgb([x as u8 * 20, y as u8 * 30, 99]));
    let mut rng = SplitMix64(5);
    for name in ["a.png", "a.bmp", "a.tga", "a.jpg"] {
        let whole = fs::read(encode(&dir, name, picture.clone().into())).expect("read");
        for _ in 0..300 {
            let mut bytes = whole.clone();
            for _ in 0..1 + rng.next_u64() % 4 {
                let at = (rng.next_u64() % bytes.len().min(80) as u64) as usize;
                bytes[at] = rng.next_u64() as u8;
            }
            if let Ok(image) = load_image(&dir.write(name, &bytes)) {
                assert_eq!(image.texels.len(), image.width as usize * image.height as usize);
            }
        }
    }
}

/// CRC of PNG chunks.
fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0_u32, |crc, &b| {
        (0..8).fold(crc ^ u32::from(b), |c, _| if c & 1 == 1 { (c >> 1) ^ 0xedb8_8320 } else { c >> 1 })
    })
}
