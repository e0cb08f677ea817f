//! The real program without a terminal: flags, exit codes, files and the JSON object.

use glimt::bvh::Isa;
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

/// An empty directory that the program runs in, removed at the end of the test.
struct Place(PathBuf);

/// A scene with everything in it that is quick: 96 x 64 pixels, 2 samples.
const SCENE: &str = r##"
[film]
width = 96
height = 64
[camera]
position = [0, 1.5, 5]
look_at = [0, 0.4, 0]
[world]
background = { top = "skyblue", bottom = "white" }
[render]
samples = 2
[[light]]
position = [3, 5, 4]
[[material]]
name = "glass"
diffuse = 0.1
reflect = 0.1
transmit = 0.8
ior = 1.3
[[material]]
name = "floor"
texture = { checker = ["white", "navy"], size = 0.8 }
[[object]]
shape = "sphere"
radius = 0.5
translate = [-0.6, 0.5, 0]
material = "glass"
[[object]]
shape = "cuboid"
translate = [0.7, 0.5, -0.5]
[[object]]
shape = "plane"
material = "floor"
"##;

/// A pyramid, in the usual faces of four and three corners.
const MODEL: &str = "v -1 0 -1\nv 1 0 -1\nv 1 0 1\nv -1 0 1\nv 0 2 0\n\
                     f 1 2 3 4\nf 2 1 5\nf 3 2 5\nf 4 3 5\nf 1 4 5\n";

impl Place {
    fn new(test: &str) -> Self {
        let path = std::env::temp_dir().join(format!("glimt-cli-{test}-{}", std::process::id()));
        let _ = fs::remove_dir_all(&path);
        fs::create_dir_all(&path).unwrap();
        fs::write(path.join("room.toml"), SCENE).unwrap();
        Self(path)
    }

    fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_glimt"));
        command
            .args(arguments)
            .current_dir(&self.0)
            .stdin(Stdio::null())
            .env_remove("NO_COLOR")
            .env_remove("GLIMT_ISA");
        command
    }

    fn run(&self, arguments: &[&str]) -> Output {
        self.command(arguments).output().unwrap()
    }

    /// Runs, demands success and returns the JSON object, which must be all that stands on stdout.
    fn json(&self, arguments: &[&str]) -> Value {
        let output = self.run(&[arguments, &["--json"]].concat());
        assert_eq!(output.status.code(), Some(0), "{arguments:?}: {}", stderr(&output));
        serde_json::from_slice(&output.stdout).unwrap()
    }

    fn file(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }

    /// Names of all files, except those that the test began with.
    fn new_files(&self) -> Vec<String> {
        let mut names: Vec<_> =
            fs::read_dir(&self.0).unwrap().map(|e| e.unwrap().file_name().to_string_lossy().into_owned()).collect();
        names.retain(|name| !name.ends_with(".toml") && !name.ends_with(".obj"));
        names.sort();
        names
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

fn stderr(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).unwrap()
}

fn stdout(output: &Output) -> String {
    String::from_utf8(output.stdout.clone()).unwrap()
}

fn picture(file: &Path) -> image::RgbImage {
    image::open(file).unwrap().into_rgb8()
}

#[test]
fn a_picture_is_written_beside_the_working_directory_and_nothing_else() {
    let place = Place::new("default");
    let output = place.run(&["render", "room.toml"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert!(stdout(&output).is_empty());
    assert!(stderr(&output).contains("saved room.png: 96x64, 2 samples a pixel"), "{}", stderr(&output));
    assert_eq!(place.new_files(), ["room.png"]);
    let picture = picture(&place.file("room.png"));
    assert_eq!(picture.dimensions(), (96, 64));
    // Sky above, a floor of two colours below.
    let colors = |y: u32| picture.rows().nth(y as usize).unwrap().collect::<std::collections::HashSet<_>>().len();
    assert!(colors(63) > 2, "the floor has {} colours", colors(63));
    assert!(picture.get_pixel(0, 0).0[2] > picture.get_pixel(0, 0).0[0], "the sky is blue");
}

#[test]
fn without_a_terminal_the_bare_program_renders_and_says_so() {
    let place = Place::new("bare");
    let output = place.run(&["room.toml", "--size", "16x9", "-o", "small.png"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert!(stderr(&output).starts_with("no terminal to draw on"), "{}", stderr(&output));
    assert!(stdout(&output).is_empty());
    assert_eq!(picture(&place.file("small.png")).dimensions(), (16, 9));
}

#[test]
fn the_demo_scene_is_inside_the_program() {
    let place = Place::new("demo");
    let report = place.json(&["--size", "32x18", "--samples", "1", "--quiet"]);
    assert_eq!(report["output"], "demo.png");
    assert_eq!(report["contents"]["textures"], 2);
    assert_eq!(report["warnings"], Value::Array(Vec::new()));
    assert_eq!(picture(&place.file("demo.png")).dimensions(), (32, 18));
    let checked = place.run(&["check"]);
    assert_eq!(checked.status.code(), Some(0), "{}", stderr(&checked));
}

#[test]
fn every_flag_shows_in_the_report_and_most_in_the_picture() {
    let place = Place::new("flags");
    let plain = place.json(&["render", "room.toml"]);
    let text = |value: &Value| value.as_str().unwrap().to_owned();
    for (flag, value, field, changes_picture) in [
        ("--size", "48x64", "size", true),
        ("--threads", "3", "threads", false),
        ("--samples", "3", "samples", true),
        ("--max-depth", "0", "max_depth", true),
        ("--shading", "phong", "shading", true),
        ("--shading", "lambert", "shading", true),
        ("--shadows", "filtered", "shadows", true),
        ("--tile-size", "8", "tile_size", false),
    ] {
        let report = place.json(&["render", "room.toml", flag, value]);
        match &report[field] {
            Value::String(name) => assert_eq!(name, value),
            Value::Array(size) => assert_eq!(format!("{}x{}", size[0], size[1]), value),
            number => assert_eq!(number.to_string(), value),
        }
        let changed = text(&report["pixel_hash"]) != text(&plain["pixel_hash"]);
        assert_eq!(changed, changes_picture, "{flag} {value}");
    }
    for numerics in ["classic", "fast", "robust", "reference"] {
        assert_eq!(place.json(&["render", "room.toml", "--numerics", numerics])["numerics"], numerics);
    }
}

#[test]
fn the_instruction_set_is_that_of_the_flag_or_the_variable_and_shows_everywhere() {
    let place = Place::new("isa");
    let (mut hashes, here) = (Vec::new(), Isa::ALL.into_iter().filter(|isa| isa.is_available()));
    for isa in here.map(Isa::name) {
        let asked = place.json(&["render", "room.toml", "--isa", isa]);
        assert_eq!(asked["isa"], isa);
        hashes.push(asked["pixel_hash"].clone());
        let output = place.command(&["check", "room.toml"]).env("GLIMT_ISA", isa).output().unwrap();
        assert!(stdout(&output).contains(&format!("traced with {isa}")), "{}", stdout(&output));
        let output = place.command(&["render", "room.toml", "--size", "8x8"]).env("GLIMT_ISA", isa).output().unwrap();
        assert!(stderr(&output).lines().any(|line| line.starts_with("rendering 8x8") && line.ends_with(isa)));
        // The flag wins.
        let output = place.command(&["check", "--isa", "portable"]).env("GLIMT_ISA", isa).output().unwrap();
        assert!(stdout(&output).contains("traced with portable"), "{}", stdout(&output));
    }
    hashes.dedup();
    assert_eq!(hashes.len(), 1, "the picture depends on the instruction set");
    for (variable, hint) in [("", None), ("avx1024", Some("avx1024")), ("\u{1b}[31m", Some("GLIMT_ISA"))] {
        let output = place.command(&["check", "room.toml"]).env("GLIMT_ISA", variable).output().unwrap();
        let told = stderr(&output);
        assert_eq!(output.status.code(), Some(if hint.is_some() { 2 } else { 0 }), "{told}");
        let list = "no such instruction set; here there is portable";
        assert!(hint.is_none_or(|hint| told.contains(hint) && told.contains(list)), "{told}");
        assert!(!told.contains('\x1b'), "{told}");
    }
    #[cfg(target_arch = "x86_64")]
    assert_eq!(place.json(&["render", "room.toml", "--isa", "sse2"])["isa"], "portable");
}

#[test]
fn the_study_of_kernels_measures_what_it_is_asked_to_and_writes_its_files() {
    let place = Place::new("study-kernel");
    let asked =
        ["study", "kernel", "room.toml", "--isa", "portable", "--rays", "500", "--repeats", "1", "--out", "out"];
    let output = place.run(&asked);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let text = stdout(&output);
    for word in
        ["primary", "shadow", "mirrored", "random", "fast", "robust", "reference", "single", "packet", "portable"]
    {
        assert!(text.contains(word), "{word} is missing in\n{text}");
    }
    let written: Value = serde_json::from_slice(&fs::read(place.file("out/kernel.json")).unwrap()).unwrap();
    assert_eq!(written["settings"]["rays"], 500);
    // Four kinds, three presets, two modes, one round; and the names of the columns.
    let samples = fs::read_to_string(place.file("out/kernel.csv")).unwrap();
    assert_eq!(samples.lines().filter(|line| !line.starts_with('#')).count(), 1 + 4 * 3 * 2);
    let refused = place.run(&["study", "kernel", "room.toml", "--isa", "avx1024", "--out", "none"]);
    assert_eq!(refused.status.code(), Some(2));
    assert!(stderr(&refused).contains("here there is portable") && !place.file("none").exists());
}

#[test]
fn the_report_is_complete_and_adds_up() {
    let place = Place::new("report");
    let report = place.json(&["render", "room.toml", "-o", "a.png", "--threads", "2"]);
    assert_eq!(report["version"], env!("CARGO_PKG_VERSION"));
    assert_eq!((&report["scene"], &report["output"]), (&"room.toml".into(), &"a.png".into()));
    assert_eq!(report["size"], serde_json::json!([96, 64]));
    let rays = |kind: &str| report["rays"][kind].as_u64().unwrap();
    assert_eq!(rays("camera"), 96 * 64 * 2);
    assert!(["shadow", "reflection", "refraction"].iter().all(|kind| rays(kind) > 0));
    let sum: u64 = ["camera", "shadow", "reflection", "refraction"].iter().map(|kind| rays(kind)).sum();
    assert_eq!(rays("total"), sum);
    assert!(report["rays_per_second"].as_f64().unwrap() > 0.0);

    let seconds = |part: &str| report["seconds"][part].as_f64().unwrap();
    let parts = ["load", "build", "trace", "save"].map(seconds);
    assert!(parts.iter().all(|part| *part >= 0.0));
    assert!(parts.iter().sum::<f64>() <= seconds("total") + 1e-6, "{parts:?} of {}", seconds("total"));
    assert!(seconds("first_picture") > 0.0 && seconds("first_picture") <= seconds("trace"));

    let workers = report["workers"].as_array().unwrap();
    assert_eq!(workers.len(), 2);
    assert_eq!(workers.iter().map(|w| w["rays"].as_u64().unwrap()).sum::<u64>(), sum);
    assert!(workers.iter().map(|w| w["tiles"].as_u64().unwrap()).sum::<u64>() >= 6);
    assert!(workers.iter().map(|w| w["busy_seconds"].as_f64().unwrap()).sum::<f64>() > 0.0);

    assert_eq!(report["non_finite"], 0);
    let peak = &report["peak_memory_bytes"];
    assert!(peak.as_u64().is_some_and(|bytes| bytes > 1 << 20) || (peak.is_null() && cfg!(not(target_os = "linux"))));
    let hash = report["pixel_hash"].as_str().unwrap();
    assert!(hash.len() == 16 && u64::from_str_radix(hash, 16).is_ok(), "{hash}");
    assert_eq!((&report["contents"]["objects"], &report["contents"]["lights"]), (&3.into(), &1.into()));
    assert!(report["imports"].as_array().unwrap().is_empty());
    assert!(report["warnings"].is_array());
    assert!(Isa::ALL.iter().any(|isa| report["isa"] == isa.name()));
    // The plane has no box; a node for the sphere and the cuboid is all the tree.
    let tree = &report["tree"];
    assert_eq!((&tree["primitives"], &tree["nodes"], &tree["depth"]), (&2.into(), &1.into(), &1.into()));
    assert_eq!(
        (&tree["fill"], &tree["bytes"], &tree["bytes_per_primitive"]),
        (&1.0.into(), &256.into(), &128.0.into())
    );
    assert!(tree["sah_cost"].as_f64().unwrap() > 1.0);
}

#[test]
fn every_size_and_more_threads_than_tiles_give_a_whole_picture() {
    let place = Place::new("sizes");
    for size in ["1x1", "1x7", "7x1", "33x9"] {
        let one = place.json(&["render", "room.toml", "--size", size, "-o", "one.png", "--threads", "1"]);
        let many = place.json(&["render", "room.toml", "--size", size, "-o", "many.png", "--threads", "40"]);
        assert_eq!(one["pixel_hash"], many["pixel_hash"], "{size}");
        assert_eq!(many["workers"].as_array().unwrap().len(), 40);
        assert_eq!(fs::read(place.file("one.png")).unwrap(), fs::read(place.file("many.png")).unwrap());
        let (width, height) = picture(&place.file("one.png")).dimensions();
        assert_eq!(format!("{width}x{height}"), size);
    }
}

#[test]
fn quiet_says_nothing_and_json_is_all_there_is_on_stdout() {
    let place = Place::new("quiet");
    let output = place.run(&["render", "room.toml", "--quiet"]);
    assert_eq!(output.status.code(), Some(0));
    assert!(output.stdout.is_empty() && output.stderr.is_empty(), "{}", stderr(&output));
    let output = place.run(&["room.toml", "--json"]);
    assert_eq!(stdout(&output).lines().count(), 1);
    assert!(stdout(&output).starts_with('{') && stdout(&output).ends_with("}\n"));
    assert!(stderr(&output).contains("saved room.png"));
}

#[test]
fn a_model_is_rendered_with_a_camera_lights_and_a_floor() {
    let place = Place::new("model");
    fs::write(place.file("pyramid.OBJ"), MODEL).unwrap();
    let report = place.json(&["render", "pyramid.OBJ", "--size", "60x80", "--samples", "1", "-o", "p.png"]);
    assert_eq!((&report["contents"]["triangles"], &report["contents"]["lights"]), (&6.into(), &2.into()));
    assert_eq!(report["imports"][0]["file"], "pyramid.OBJ");
    assert_eq!(report["imports"][0]["triangles"], 6);
    // Six triangles are a block of eight under one node.
    let tree = &report["imports"][0]["tree"];
    assert_eq!([&tree["primitives"], &tree["nodes"], &tree["leaves"]], [6, 1, 1]);
    assert_eq!((&tree["fill"], &tree["bytes"]), (&0.75.into(), &(256 + 320).into()));
    assert_eq!(tree["bytes_per_primitive"], 96.0);
    let picture = picture(&place.file("p.png"));
    assert_eq!(picture.dimensions(), (60, 80));
    // The model stands in the middle, before floor and sky that the edges show.
    assert_ne!(picture.get_pixel(30, 40), picture.get_pixel(0, 40));
    let checked = place.run(&["check", "pyramid.OBJ"]);
    assert!(stdout(&checked).contains("6 triangles"), "{}", stdout(&checked));
    let tree = "depth 1, SAH cost 1.0, 1 node, 1 block 75 % full, 576 bytes (96.0 each)";
    assert!(stdout(&checked).contains(tree), "{}", stdout(&checked));

    fs::write(place.file("broken.obj"), "v 1 2 3\nf 1 2 3\n").unwrap();
    let output = place.run(&["render", "broken.obj"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).starts_with("error: broken.obj"), "{}", stderr(&output));
}

#[test]
fn what_a_model_names_and_does_not_get_is_a_warning_everywhere() {
    let place = Place::new("missing");
    fs::write(place.file("lost.obj"), format!("mtllib gone.mtl\n{MODEL}")).unwrap();
    fs::write(place.file("half.mtl"), "newmtl a\nKd 1 0 0\nmap_Kd gone.png\nNs many\n").unwrap();
    fs::write(place.file("half.obj"), format!("mtllib half.mtl\nusemtl a\n{MODEL}")).unwrap();
    let scene = format!("{SCENE}[[object]]\nshape = \"mesh\"\nfile = \"lost.obj\"\n");
    fs::write(place.file("lost.toml"), scene).unwrap();
    for (scene, expected) in [
        ("lost.obj", &["lost.obj: material library not found: gone.mtl"][..]),
        ("lost.toml", &["lost.obj: material library not found: gone.mtl"]),
        ("half.obj", &["half.obj: 1 texture not found: gone.png", "half.obj: 1 line of material libraries ignored"]),
    ] {
        let checked = stdout(&place.run(&["check", scene]));
        let report = place.json(&["render", scene, "--size", "8x6", "--samples", "1", "-o", "a.png", "--quiet"]);
        let rendered = stderr(&place.run(&["render", scene, "--size", "8x6", "--samples", "1", "-o", "a.png"]));
        assert!(!checked.contains("nothing wrong") && checked.contains("can be rendered, with "), "{checked}");
        for warning in expected {
            for told in [&checked, &rendered, &report["warnings"].to_string().replace('"', "\nwarning: ")] {
                assert!(told.contains(&format!("warning: {warning}")), "{warning} is missing in\n{told}");
            }
        }
    }
    let quiet = place.run(&["render", "lost.obj", "--size", "8x6", "-o", "a.png", "--quiet"]);
    assert!(quiet.stderr.is_empty(), "{}", stderr(&quiet));
    // What was computed is no warning.
    fs::write(place.file("plain.obj"), MODEL).unwrap();
    assert!(stdout(&place.run(&["check", "plain.obj"])).contains("nothing wrong"));
}

#[test]
fn check_lists_what_a_scene_has_and_writes_nothing() {
    let place = Place::new("check");
    let output = place.run(&["check", "room.toml"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let text = stdout(&output);
    for part in [
        "room.toml",
        "96x64, 2 samples",
        "whitted",
        "objects     3",
        "lights      1",
        "materials",
        "trees in",
        "traced with",
    ] {
        assert!(text.contains(part), "{part} is missing in\n{text}");
    }
    assert!(place.new_files().is_empty());
}

#[test]
fn a_bad_scene_is_told_with_its_place_and_leaves_nothing() {
    let place = Place::new("bad");
    fs::write(place.file("bad.toml"), SCENE.replace("radius = 0.5", "radios = 0.5")).unwrap();
    for command in [&["check", "bad.toml"][..], &["render", "bad.toml"], &["bad.toml", "--json"]] {
        let output = place.run(command);
        assert_eq!(output.status.code(), Some(2));
        assert!(stdout(&output).is_empty());
        let text = stderr(&output);
        assert!(text.contains("bad.toml:") && text.contains("radios") && text.contains("radius"), "{text}");
        assert!(!text.contains('\x1b'), "no escape sequences where there is no terminal");
    }
    let colored = place.run(&["check", "bad.toml", "--color", "always"]);
    assert!(stderr(&colored).contains('\x1b'));
    assert!(place.new_files().is_empty());
}

#[test]
fn what_cannot_be_asked_is_refused_with_code_2_before_anything_is_rendered() {
    let place = Place::new("refused");
    fs::create_dir(place.file("folder.toml")).unwrap();
    fs::write(place.file("binary.toml"), [b'[', 0xff, 0xfe]).unwrap();
    for (command, hint) in [
        (&["render", "missing.toml"][..], "no such file"),
        (&["render", "folder.toml"], "directory"),
        (&["render", "binary.toml"], "not UTF-8"),
        (&["render", "missing.obj"], "missing.obj"),
        (&["render", "room.toml", "-o", "."], "file name"),
        (&["render", "room.toml", "-o", "/"], "file name"),
        (&["render", "room.toml", "-o", "../"], "file name"),
        (&["render", "room.toml", "-o", "no/such/place.png"], "make it first"),
        (&["render", "room.toml", "-o", "picture.jpg"], ".png"),
        (&["render", "room.toml", "-o", "room.toml"], ".png"),
        (&["render", "room.toml", "--sise", "1x1"], "--size"),
        (&["render", "room.toml", "-o", "-"], "standard output"),
        (&["render", "room.toml", "--size", "0x1"], "from 1"),
        (&["render", "room.toml", "--size", "-1x5"], "from 1 to 32768"),
        (&["render", "room.toml", "--max-depth", "-1"], "from 0 to 64"),
        (&["render", "room.toml", "--threads", "2", "--threads", "3"], "--threads <N> is given twice"),
        (&["room.toml", "-q", "-q"], "--quiet is given twice"),
        (&["--threads", "2", "render", "room.toml"], "before all options"),
        (&["render", "room.toml", "--shading", "gouraud"], "whitted"),
        (&["room.toml", "room.toml"], "one scene"),
        (&["--threads"], "--threads"),
        (&["check", "--isa", "avx1024"], "here there is portable"),
    ] {
        let output = place.run(command);
        assert_eq!(output.status.code(), Some(2), "{command:?}: {}", stderr(&output));
        assert!(stderr(&output).contains(hint), "{command:?}: {}", stderr(&output));
        assert!(!stderr(&output).contains("panicked"), "{command:?}: {}", stderr(&output));
        assert!(stdout(&output).is_empty());
    }
    assert_eq!(fs::read_to_string(place.file("room.toml")).unwrap(), SCENE);
    assert!(place.new_files().is_empty(), "{:?}", place.new_files());
}

#[test]
fn what_shows_only_after_parsing_is_told_with_its_place_in_the_scene() {
    let place = Place::new("after");
    fs::write(place.file("broken.obj"), "v 0 0 0\nf 1 2 3\n").unwrap();
    fs::write(place.file("broken.png"), "no picture").unwrap();
    fs::write(place.file("tinted.mtl"), "newmtl a\nmap_Kd broken.png\n").unwrap();
    fs::write(place.file("tinted.obj"), format!("mtllib tinted.mtl\nusemtl a\n{MODEL}")).unwrap();
    // A title that the parser leaves out of the count would shift all places.
    let start = SCENE.lines().count();
    for (entry, line, column, expected, marked) in [
        (
            "[[object]]\nshape = \"cuboid\"\nscale = [1e-12, 1, 1]\nsize = [1e-12, 1, 1e12]",
            3,
            9,
            "the transform flattens it",
            "scale = [1e-12, 1, 1]",
        ),
        ("[[object]]\nshape = \"mesh\"\nfile = \"broken.obj\"", 3, 8, "error: broken.obj:2: ", "needed here"),
        ("[[object]]\nshape = \"mesh\"\nfile = \"tinted.obj\"", 3, 8, "error: broken.png: ", "\"tinted.obj\""),
        (
            "[[material]]\nname = \"wood\"\ntexture = { file = \"broken.png\" }",
            3,
            11,
            "error: broken.png: ",
            "needed here",
        ),
    ] {
        for mark in ["", "\u{feff}"] {
            fs::write(place.file("late.toml"), format!("{mark}{SCENE}{entry}\n")).unwrap();
            for command in [&["check", "late.toml"][..], &["render", "late.toml", "-o", "a.png"]] {
                let output = place.run(command);
                let text = stderr(&output);
                assert_eq!(output.status.code(), Some(2), "{text}");
                let at = format!("late.toml:{}:{column}", start + line);
                for part in [at.as_str(), expected, marked, "^^^"] {
                    assert!(text.contains(part), "{part} is missing in\n{text}");
                }
            }
        }
    }
    assert!(!place.file("a.png").exists());
}

#[test]
fn a_model_without_its_ending_is_one_error() {
    let place = Place::new("ending");
    fs::write(place.file("pyramid"), format!("# made by hand\n\n{MODEL}")).unwrap();
    let text = stderr(&place.run(&["check", "pyramid"]));
    assert!(text.contains("looks like an OBJ model") && text.contains("pyramid.obj"), "{text}");
    assert_eq!(text.lines().count(), 1, "{text}");
    // A scene with a mistake is still a scene.
    fs::write(place.file("short.toml"), "f = 3\n").unwrap();
    assert!(stderr(&place.run(&["check", "short.toml"])).contains("short.toml:1:1"));
}

#[test]
fn one_is_singular() {
    let place = Place::new("one");
    let text = stderr(&place.run(&["render", "room.toml", "--samples", "1", "--threads", "1"]));
    assert!(text.contains("1 sample a pixel, 1 thread, ") && !text.contains("1 samples"), "{text}");
}

#[test]
fn names_of_files_cannot_send_escape_sequences() {
    let place = Place::new("escape");
    for command in [&["render", "\x1b[31mred.toml"][..], &["\x1b]0;x\x07.obj"], &["--\x1b[31m"], &["check", "\x1bc"]] {
        let output = place.run(command);
        assert_eq!(output.status.code(), Some(2));
        assert!(!stderr(&output).contains(['\x1b', '\x07']), "{:?}", stderr(&output));
    }
}

#[cfg(target_os = "linux")]
#[test]
fn keys_are_listed_as_the_users_own_file_has_them() {
    let place = Place::new("keys");
    let keys = |arguments: &[&str]| {
        let mut command = place.command(&["keys"]);
        command.args(arguments).env("XDG_CONFIG_HOME", place.0.join("config")).output().unwrap()
    };
    let plain = stdout(&keys(&[]));
    assert!(plain.lines().any(|line| line.split_whitespace().eq(["u", "undo"])), "{plain}");
    assert!(plain.contains("config/glimt/keys.toml"), "{plain}");
    fs::create_dir_all(place.0.join("config/glimt")).unwrap();
    let write = |text: &str| fs::write(place.0.join("config/glimt/keys.toml"), text).unwrap();
    write("undo = [\"Ctrl-U\", \"u\"]\n");
    let changed = stdout(&keys(&[]));
    assert!(changed.lines().any(|line| line.split_whitespace().eq(["Ctrl-U", "u", "undo"])), "{changed}");
    assert!(stdout(&keys(&["--markdown"])).contains("`Ctrl-U`"));
    write("# mine\nundoo = \"u\"\n");
    let wrong = keys(&[]);
    assert_eq!(wrong.status.code(), Some(2));
    let told = stderr(&wrong);
    assert!(told.contains("keys.toml:2") && told.contains("did you mean undo"), "{told}");
}

#[test]
fn help_and_version_are_answers_on_stdout() {
    let place = Place::new("help");
    for command in [&["--help"][..], &["render", "--help"], &["check", "--help"], &["--version"]] {
        let output = place.run(command);
        assert_eq!(output.status.code(), Some(0));
        assert!(!output.stdout.is_empty() && output.stderr.is_empty());
    }
}

#[cfg(unix)]
mod unix {
    use super::*;
    use std::io::{BufRead, BufReader};
    use std::os::unix::process::ExitStatusExt;

    #[test]
    fn a_signal_stops_it_with_nothing_written() {
        for (signal, code) in [("INT", 130), ("TERM", 143)] {
            let place = Place::new(&format!("signal-{signal}"));
            // Hours of work.
            let arguments = ["render", "room.toml", "--size", "2000x2000", "--samples", "4096"];
            let mut child = place.command(&arguments).stderr(Stdio::piped()).spawn().unwrap();
            let mut lines = BufReader::new(child.stderr.take().unwrap()).lines();
            assert!(lines.next().unwrap().unwrap().starts_with("rendering "));
            let killed = Command::new("kill").args([&format!("-{signal}"), &child.id().to_string()]).status().unwrap();
            assert!(killed.success());
            let status = child.wait().unwrap();
            assert_eq!((status.code(), status.signal()), (Some(code), None));
            let last = lines.last().unwrap().unwrap();
            assert!(last.contains(&format!("stopped by SIG{signal}")), "{last}");
            assert!(place.new_files().is_empty(), "{:?}", place.new_files());
        }
    }

    #[test]
    fn a_reader_that_goes_away_is_no_panic() {
        let place = Place::new("pipe");
        for arguments in ["check room.toml", "render room.toml --size 8x8 --json", "--help"] {
            let program = env!("CARGO_BIN_EXE_glimt");
            let script = format!("(sleep 0.2; '{program}' {arguments} 2>errors.txt; echo $? >code.txt) | true");
            let status = Command::new("sh").args(["-c", &script]).current_dir(&place.0).status().unwrap();
            assert!(status.success());
            let errors = fs::read_to_string(place.file("errors.txt")).unwrap();
            assert!(!errors.contains("panic"), "{errors}");
            // A report that is lost is an error, text that nobody reads to its end is none.
            assert_eq!(errors.contains("error: the picture is saved, but"), arguments.contains("--json"), "{errors}");
            let code = fs::read_to_string(place.file("code.txt")).unwrap();
            assert_eq!(code.trim(), if arguments.contains("--json") { "1" } else { "0" });
        }
        // Nor is a stderr that is closed.
        let script = format!("'{}' render room.toml --size 8x8 2>&-", env!("CARGO_BIN_EXE_glimt"));
        assert!(Command::new("sh").args(["-c", &script]).current_dir(&place.0).status().unwrap().success());
    }

    #[test]
    fn pipes_are_refused_at_once() {
        let place = Place::new("fifo");
        assert!(Command::new("mkfifo").arg(place.file("pipe")).status().unwrap().success());
        let fifo = place.run(&["render", "room.toml", "-o", "pipe"]);
        let stdout_pipe = place.run(&["render", "room.toml", "-o", "/dev/stdout"]);
        for output in [fifo, stdout_pipe] {
            assert_eq!(output.status.code(), Some(2), "{}", stderr(&output));
            assert!(stderr(&output).contains("name a file such as picture.png"), "{}", stderr(&output));
            assert!(stdout(&output).is_empty());
        }
    }

    #[test]
    fn a_link_to_a_missing_file_is_told_as_such() {
        let place = Place::new("dangling");
        std::os::unix::fs::symlink("gone.obj", place.file("knot.obj")).unwrap();
        let scene = format!("{SCENE}[[object]]\nshape = \"mesh\"\nfile = \"knot.obj\"\n");
        fs::write(place.file("link.toml"), scene).unwrap();
        let text = stderr(&place.run(&["check", "link.toml"]));
        assert!(text.contains("what it leads to does not exist") && !text.contains("did you mean"), "{text}");
    }

    #[test]
    fn a_file_of_spheres_that_would_fill_memory_is_refused() {
        let place = Place::new("spheres");
        fs::File::create(place.file("many.csv")).unwrap().set_len((256 << 20) + 1).unwrap();
        let scene = format!("{SCENE}[[object]]\nshape = \"spheres\"\nfile = \"many.csv\"\n");
        fs::write(place.file("many.toml"), scene).unwrap();
        let output = place.run(&["check", "many.toml"]);
        assert_eq!(output.status.code(), Some(2));
        assert!(stderr(&output).contains("larger than 256 MiB"), "{}", stderr(&output));
    }

    #[test]
    fn a_device_is_written_to_and_a_link_is_followed() {
        let place = Place::new("device");
        let output = place.run(&["render", "room.toml", "-o", "/dev/null", "--quiet"]);
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        assert!(!fs::metadata("/dev/null").unwrap().is_file());
        std::os::unix::fs::symlink("target.png", place.file("link.png")).unwrap();
        fs::write(place.file("target.png"), "old").unwrap();
        assert_eq!(place.run(&["render", "room.toml", "-o", "link.png"]).status.code(), Some(0));
        assert_eq!(picture(&place.file("target.png")).dimensions(), (96, 64));
        assert!(fs::symlink_metadata(place.file("link.png")).unwrap().is_symlink());
    }
}

#[test]
fn explain_prints_the_rays_of_a_pixel_and_the_colour_that_the_picture_has() {
    let place = Place::new("explain");
    let told = place.json(&["explain", "room.toml", "--pixel", "38,30", "--sample", "1"]);
    place.json(&["render", "room.toml", "-o", "room.png", "--threads", "1"]);
    let picture = image::open(place.file("room.png")).unwrap().to_rgb8();
    assert_eq!(told["codes"], serde_json::json!(picture.get_pixel(38, 30).0));
    assert_eq!((&told["samples"], &told["sample"], &told["non_finite"]), (&2.into(), &1.into(), &0.into()));
    let surface = &told["tree"]["end"]["surface"];
    assert_eq!((&surface["material"], &surface["coefficients"]["k_t"]), (&"glass".into(), &0.8.into()));

    let text = place.run(&["explain", "room.toml", "--pixel", "38,30"]);
    let text = String::from_utf8(text.stdout).unwrap();
    for words in
        ["camera ray", "hits object 1 at t = ", "k_a I_a C = ", "light light 1: ", "k_r I_r", "k_t I_t", "error"]
    {
        assert!(text.contains(words), "{words}\n{text}");
    }
    let codes = picture.get_pixel(38, 30).0.map(|code| code.to_string()).join(" ");
    assert!(text.trim_end().ends_with(&format!("(mean of 2 samples), sRGB {codes}")), "{text}");

    for (arguments, hint) in [
        (["--pixel", "96,0", "--sample", "0"], "the last one of the picture is 95,63"),
        (["--pixel", "3;4", "--sample", "0"], "write it as 320,200"),
        (["--pixel", "0,0", "--sample", "2"], "the last one of this pixel is 1"),
    ] {
        let output = place.run(&[&["explain", "room.toml"][..], &arguments[..]].concat());
        assert_eq!(output.status.code(), Some(2));
        assert!(stderr(&output).contains(hint), "{}", stderr(&output));
    }
}

#[test]
fn a_view_is_a_picture_of_its_own_and_lost_samples_name_the_command_that_shows_them() {
    let place = Place::new("views");
    let report = place.json(&["render", "room.toml", "--view", "object"]);
    assert_eq!((&report["view"], &report["output"]), (&"object".into(), &"room-object.png".into()));
    let picture = image::open(place.file("room-object.png")).unwrap().to_rgb8();
    let colors: std::collections::BTreeSet<_> = picture.pixels().map(|pixel| pixel.0).collect();
    assert_eq!(colors.len(), 4, "three objects and nothing");
    let report = place.json(&["render", "room.toml", "--view", "samples"]);
    assert_eq!(report["scale"], serde_json::json!([1.0, 2.0]));

    fs::write(
        place.file("sea.toml"),
        "[film]\nwidth = 8\nheight = 8\n[camera]\nposition = [0, 2, 0]\nlook_at = [0, 0, -6]\nprojection = \"perspective\"\n\
         fov = 10\n[world]\nbackground = { top = \"white\", bottom = \"navy\" }\n[render]\nsamples = 1\n[[material]]\nname = \"thin\"\ntransmit = 1\nior = 0.75\n\
         [[object]]\nshape = \"plane\"\nmaterial = \"thin\"\n",
    )
    .unwrap();
    let output = place.run(&["render", "sea.toml", "--numerics", "classic", "--json"]);
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    let command = "glimt explain sea.toml --pixel 0,0 --numerics classic";
    assert_eq!((&report["non_finite"], &report["explain"]), (&64.into(), &command.into()));
    assert!(stderr(&output).contains(command), "{}", stderr(&output));
    let told = place.json(&command.split(' ').skip(1).collect::<Vec<_>>());
    assert_eq!(told["non_finite"], 1);
}
