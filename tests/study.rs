//! Studies and comparisons through the real program, with tiny settings: exit codes, files, and what is in them.

use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

/// An empty directory that the program runs in, removed at the end of the test.
struct Place(PathBuf);

const SCENE: &str = "
[film]
width = 48
height = 32
[render]
samples = 4
max_depth = 3
[[light]]
position = [3, 5, 4]
[[material]]
name = \"mirror\"
reflect = 0.6
[[object]]
shape = \"sphere\"
material = \"mirror\"
[[object]]
shape = \"plane\"
translate = [0, -1, 0]
material = \"mirror\"
";

impl Place {
    fn new(test: &str) -> Self {
        let path = std::env::temp_dir().join(format!("glimt-study-{test}-{}", std::process::id()));
        let _ = fs::remove_dir_all(&path);
        fs::create_dir_all(&path).unwrap();
        fs::write(path.join("room.toml"), SCENE).unwrap();
        Self(path)
    }

    fn command(&self, line: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_glimt"));
        command.args(line.split_whitespace()).current_dir(&self.0).stdin(Stdio::null());
        command.env("XDG_CACHE_HOME", self.0.join("cache")).stdout(Stdio::piped()).stderr(Stdio::piped());
        command
    }

    /// Runs, demands this exit code, and returns what stands on stdout.
    fn run(&self, line: &str, code: i32) -> String {
        let Output { status, stdout, stderr } = self.command(line).output().unwrap();
        let stderr = String::from_utf8(stderr).unwrap();
        assert_eq!(status.code(), Some(code), "{line}: {stderr}");
        assert!(code == 2 || !stderr.contains("error"), "{line}: {stderr}");
        if code == 2 { stderr } else { String::from_utf8(stdout).unwrap() }
    }

    fn names(&self, directory: &str) -> Vec<String> {
        let entries = fs::read_dir(self.0.join(directory)).unwrap();
        let mut names: Vec<_> = entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    /// Writes a picture that is `code` everywhere except in the first pixel.
    fn picture(&self, name: &str, (width, height): (u32, u32), code: u8, first: u8) {
        let mut picture = image::RgbImage::from_pixel(width, height, image::Rgb([code; 3]));
        picture.put_pixel(0, 0, image::Rgb([first; 3]));
        picture.save(self.0.join(name)).unwrap();
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// The header lines, the names of the columns, and the rows of a table of raw samples.
fn csv_of(file: &Path) -> (Vec<String>, Vec<String>, Vec<Vec<String>>) {
    let text = fs::read_to_string(file).unwrap();
    let header = text.lines().take_while(|line| line.starts_with("# ")).map(String::from).collect();
    let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_reader(text.as_bytes());
    let columns = reader.headers().unwrap().iter().map(String::from).collect();
    let rows = reader.records().map(|row| row.unwrap().iter().map(String::from).collect()).collect();
    (header, columns, rows)
}

/// Whether every tag of a document that begins with `<svg` is closed in its order, and no text holds a bare `<` or `&`.
fn is_well_formed(svg: &str) -> bool {
    let mut open = Vec::new();
    for part in svg.split('<').skip(1) {
        let Some((tag, text)) = part.split_once('>') else { return false };
        let entities = ["&lt;", "&gt;", "&amp;", "&quot;", "&apos;", "&#"];
        if text.match_indices('&').any(|(at, _)| !entities.iter().any(|entity| text[at..].starts_with(entity))) {
            return false;
        }
        let name = tag.trim_start_matches('/').split_whitespace().next().unwrap_or("").trim_end_matches('/');
        if tag.starts_with('/') {
            if open.pop() != Some(name) {
                return false;
            }
        } else if !tag.ends_with('/') && !tag.starts_with(['?', '!']) {
            if tag.matches('"').count() % 2 != 0 {
                return false;
            }
            open.push(name);
        }
    }
    open.is_empty() && svg.starts_with("<svg")
}

/// What every study leaves behind; the JSON object and the rows of the CSV file.
fn check_files(place: &Place, directory: &str, name: &str, charts: &[&str]) -> (Value, Vec<Vec<String>>) {
    let file = |ending: &str| place.0.join(directory).join(format!("{name}{ending}"));
    let (header, columns, rows) = csv_of(&file(".csv"));
    assert!(header[0].starts_with("# glimt ") && header[0].contains(&format!("study {name}, 20")), "{header:?}");
    assert!(!rows.is_empty() && rows.iter().all(|row| row.len() == columns.len()));
    let json: Value = serde_json::from_slice(&fs::read(file(".json")).unwrap()).unwrap();
    assert_eq!(json["study"], name);
    assert_eq!(json["glimt"], env!("CARGO_PKG_VERSION"));
    assert!(json["date"].as_str().unwrap().ends_with('Z'));
    for key in ["cpu", "threads", "system", "isa"] {
        assert!(!json["machine"][key].is_null(), "{key}");
    }
    assert!(json["settings"].is_object() && json["summary"].is_object());
    assert_eq!(json["samples"]["columns"], serde_json::json!(columns));
    assert_eq!(json["samples"]["rows"].as_array().unwrap().len(), rows.len());
    let mut expected = vec![format!("{name}.csv"), format!("{name}.json")];
    for chart in charts {
        let dash = if chart.is_empty() { "" } else { "-" };
        let png = image::open(file(&format!("{dash}{chart}.png"))).unwrap().into_rgb8();
        let white = png.pixels().filter(|pixel| pixel.0 == [255; 3]).count();
        assert!(png.width() >= 1000 && white > 1000 && white < (png.width() * png.height()) as usize, "{chart}");
        let svg = fs::read_to_string(file(&format!("{dash}{chart}.svg"))).unwrap();
        assert!(is_well_formed(&svg) && svg.contains("<text"), "{chart}");
        expected.extend([format!("{name}{dash}{chart}.png"), format!("{name}{dash}{chart}.svg")]);
    }
    expected.sort();
    assert_eq!(place.names(directory), expected);
    (json, rows)
}

#[test]
fn malformed_documents_are_told_from_well_formed_ones() {
    assert!(is_well_formed("<svg a=\"1\"><g><line b=\"2\"/>text &amp; more</g></svg>"));
    for bad in ["<svg><g></svg>", "<svg>a & b</svg>", "<svg a=\"1></svg>", "<g></g>", "<svg>", "<svg"] {
        assert!(!is_well_formed(bad), "{bad}");
    }
}

#[test]
fn compare_measures_and_judges() {
    let place = Place::new("compare");
    place.picture("a.png", (8, 4), 100, 100);
    place.picture("b.png", (8, 4), 110, 110);
    place.picture("c.png", (8, 4), 100, 228);
    place.picture("d.png", (4, 8), 100, 100);
    let json = |line: &str, code| -> Value { serde_json::from_str(&place.run(line, code)).unwrap() };
    let same = json("compare a.png a.png --json --max-rmse 0", 0);
    assert_eq!((same["rmse"].as_f64(), same["psnr"].is_null(), same["flip"].as_f64()), (Some(0.0), true, Some(0.0)));
    let shifted = json("compare a.png b.png --json", 0);
    assert!((shifted["rmse"].as_f64().unwrap() - 10.0).abs() < 1e-4, "{shifted}");
    assert!((shifted["psnr"].as_f64().unwrap() - 28.1308).abs() < 1e-3, "{shifted}");
    // 128 codes in one of 32 pixels.
    let one = json("compare a.png c.png --json --diff map.png", 0);
    assert!((one["rmse"].as_f64().unwrap() - 128.0 / 32f64.sqrt()).abs() < 1e-4, "{one}");
    assert!((one["max"].as_f64().unwrap() - 128.0).abs() < 1e-4, "{one}");
    let map = image::open(place.0.join("map.png")).unwrap().into_rgb8();
    assert_eq!(map.dimensions(), (8, 4));
    let lit: Vec<_> = map.enumerate_pixels().filter(|(_, _, p)| p.0 != [0, 0, 4]).map(|(x, y, _)| (x, y)).collect();
    assert_eq!(lit, [(0, 0)]);
    let table = place.run("compare a.png b.png --max-rmse 10.01", 0);
    assert!(table.contains("RMSE") && table.contains("10.00") && table.contains("FLIP"), "{table}");
    place.run("compare a.png b.png --max-rmse 9.99", 1);
    for (line, hint) in [
        ("compare a.png d.png", "a.png is 8x4, d.png is 4x8"),
        ("compare a.png none.png", "none.png"),
        ("compare a.png room.toml", "room.toml"),
        ("compare a.png", "<B>"),
        ("compare a.png b.png --max-rmse -1", "from 0 to 255"),
        ("compare a.png b.png --diff none/map.png", "make it first"),
    ] {
        let said = place.run(line, 2);
        assert!(said.contains(hint), "{line}: {said}");
    }
}

#[test]
fn study_threads_measures_every_thread_of_every_round() {
    let place = Place::new("threads");
    let text = place.run("study threads room.toml --threads 1,3 --repeats 2 --out t --quiet", 0);
    assert!(text.contains("speed-up") && text.contains("19430"), "{text}");
    let (json, rows) = check_files(&place, "t", "threads", &["", "gantt-1", "gantt-3"]);
    // Two rounds of one thread and of three.
    assert_eq!(rows.len(), 2 + 6);
    let shares = rows.iter().map(|row| (row[5].parse::<f64>().unwrap(), row[6].parse::<f64>().unwrap()));
    for (busy, idle) in shares {
        assert!((0.0..=1.0).contains(&busy) && (busy + idle - 1.0).abs() < 1e-9, "{busy} {idle}");
    }
    let measured = json["summary"]["threads"].as_array().unwrap();
    assert_eq!(measured.len(), 2);
    assert_eq!(measured[0]["speedup"]["median"], 1.0);
    assert_eq!(measured[1]["seconds"]["count"], 2);
    // Rays do not depend on who traces them.
    let rays = |threads: &str, round: &str| -> u64 {
        let of_run = rows.iter().filter(|row| row[0] == threads && row[1] == round);
        of_run.map(|row| row[8].parse::<u64>().unwrap()).sum()
    };
    assert!(rays("1", "0") > 0 && rays("1", "0") == rays("3", "1"));
}

#[test]
fn study_scale_grows_and_fits() {
    let place = Place::new("scale");
    let text = place.run("study scale --quick --max 1000 --out s --quiet", 0);
    assert!(text.contains("exponent"), "{text}");
    let (_, rows) = check_files(&place, "s", "scale", &["", "memory", "lights-pixels-depth"]);
    for growing in ["triangles", "spheres", "lights", "pixels", "depth"] {
        let sizes: Vec<u64> = rows.iter().filter(|row| row[0] == growing).map(|row| row[1].parse().unwrap()).collect();
        assert!(sizes.len() >= 2, "{growing}: {sizes:?}");
    }
    // Sixteen times the pixels are sixteen times the camera rays, so more rays; more lights are more shadow rays.
    for growing in ["lights", "pixels", "depth"] {
        let rays: Vec<u64> = rows.iter().filter(|row| row[0] == growing).map(|row| row[5].parse().unwrap()).collect();
        assert!(rays.is_sorted() && rays[0] < rays[rays.len() - 1], "{growing}: {rays:?}");
    }
}

#[test]
fn study_accuracy_finds_the_front_and_keeps_its_reference() {
    let place = Place::new("accuracy");
    let line = "study accuracy room.toml --samples 1,16 --error 2 --max-depth 1 --shading phong,whitted --numerics fast,robust \
                --repeats 1 --reference-samples 512 --below 3 --out a --quiet";
    let first = place.run(line, 0);
    assert!(first.contains("The cheapest setting below 3 codes") || first.contains("No setting"), "{first}");
    assert!(first.contains("level off") && !first.contains("from the cache"), "{first}");
    let (json, rows) = check_files(&place, "a", "accuracy", &["", "numerics", "depth", "flip"]);
    let settings = json["summary"]["settings"].as_array().unwrap();
    // The scene's own, phong, fast, depth 1; two numbers of samples and an error each.
    assert_eq!((settings.len(), rows.len()), (12, 12));
    let error = |name: &str| {
        let found = settings.iter().find(|s| s["setting"] == name).unwrap_or_else(|| panic!("{name} in {settings:?}"));
        found["error"]["rmse"].as_f64().unwrap()
    };
    let own = error("whitted, robust, depth 3, 16 samples");
    assert!(own < error("whitted, robust, depth 3, 1 sample"));
    assert!(own < error("phong, robust, 16 samples") && own < error("whitted, robust, depth 1, 16 samples"));
    assert!((1.0..4.0).contains(&error("whitted, robust, depth 3, to error 2")), "{settings:?}");
    assert!(json["summary"]["reference"]["error"].as_f64().unwrap() < own);
    assert!(settings.iter().any(|s| s["on_front"] == true));
    let second = place.run(line, 0);
    assert!(second.contains("from the cache"), "{second}");
    let kept = place.names("cache/glimt");
    assert_eq!(kept.len(), 1);
    // What is damaged is made anew.
    fs::write(place.0.join("cache/glimt").join(&kept[0]), b"glimt reference\nnonsense").unwrap();
    assert!(!place.run(line, 0).contains("from the cache"));
    // Another scene has another reference.
    fs::write(place.0.join("room.toml"), SCENE.replace("0.6", "0.5")).unwrap();
    place.run(line, 0);
    assert_eq!(place.names("cache/glimt").len(), 2);
}

#[test]
fn study_overhead_makes_one_picture_in_three_ways() {
    let place = Place::new("overhead");
    let scene = SCENE.replacen("[render]", "[render]\nfilter = \"tent\"", 1);
    fs::write(place.0.join("tent.toml"), scene).unwrap();
    for line in ["room.toml --samples 5 --threads 3", "tent.toml --samples 1 --threads 1"] {
        let text = place.run(&format!("study overhead {line} --repeats 2 --screen 80x24 --out o --quiet"), 0);
        assert!(text.contains("the same, bit for bit"), "{text}");
    }
    let (json, rows) = check_files(&place, "o", "overhead", &[""]);
    assert_eq!(rows.len(), 3 * 2);
    assert_eq!(json["summary"]["same_picture"], true);
    // Only the interface sends something to a terminal.
    assert!(rows.iter().all(|row| (row[0] == "shown by the interface") == (row[4] != "0")), "{rows:?}");
}

#[test]
fn what_is_asked_wrongly_is_refused_before_any_work() {
    let place = Place::new("wrong");
    fs::write(place.0.join("file"), "").unwrap();
    for (line, hint) in [
        ("study", "threads"),
        ("study speed", "unrecognized subcommand"),
        ("study threads none.toml", "none.toml"),
        ("study threads room.toml --threads 0", "from 1 to 1024"),
        ("study threads room.toml --out file", "file"),
        ("study accuracy room.toml --samples 0", "from 1 to"),
        ("study scale --max 1", "from 1000 to"),
    ] {
        let said = place.run(line, 2);
        assert!(said.contains(hint), "{line}: {said}");
    }
    assert_eq!(place.names("."), ["file", "room.toml"]);
}

#[cfg(unix)]
#[test]
fn a_study_that_is_stopped_leaves_nothing() {
    use std::io::{BufRead, BufReader};

    let place = Place::new("stopped");
    let mut child = place.command("study threads --threads 1 --repeats 1000 --size 640x400 --out t").spawn().unwrap();
    // It listens to signals before it says what it does.
    let mut said = String::new();
    BufReader::new(child.stderr.as_mut().unwrap()).read_line(&mut said).unwrap();
    assert!(said.contains("of 1001"), "{said}");
    let pid = rustix::process::Pid::from_raw(child.id() as i32).unwrap();
    rustix::process::kill_process(pid, rustix::process::Signal::INT).unwrap();
    let code = child.wait().unwrap().code();
    assert_eq!(code, Some(130));
    assert_eq!(place.names("."), ["room.toml"]);
}
