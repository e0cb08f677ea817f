//! No input makes the program panic or hang: good scenes, models and pictures, mutated at random for 22 seconds in all.
//!
//! A failure prints the seed; `GLIMT_MUTATION_SEED=<seed> cargo test --test mutation` runs that one input again.
//! `GLIMT_MUTATION_SECONDS=<seconds>` goes on for longer.

mod support;
#[path = "fuzz/targets.rs"]
mod targets;

use glimt::math::SplitMix64;
use image::{DynamicImage, ImageFormat};
use std::io::Cursor;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
use support::*;

const SMALL_SCENE: &str = r##"
[film]
width = 1280
height = 720
[camera]
position = [3, 2, 5]
look_at = [0, 0.5, 0]
up = [0, 1, 0]
projection = "orthographic"
view_height = 4.0
[world]
ambient = "#ffffff"
background = { top = "#87a9d8", bottom = "#f0f0f0" }
ior = 1.0
[render]
shading = "whitted"
max_depth = 8
samples = 16
shadows = "filtered"
numerics = "robust"
[[light]]
kind = "point"
position = [4, 6, 3]
color = "white"
intensity = 0.8
falloff = "inverse-square"
[[light]]
kind = "directional"
direction = [-1, -2, -1]
color = [0.5, 0.5, 0.4]
[[material]]
name = "glass"
color = "violet"
ambient = 0.1
diffuse = 0.1
specular = 0.6
shininess = 80
reflect = 0.1
transmit = 0.8
ior = 1.3
fresnel = true
priority = 2
[[material]]
name = "floor"
texture = { checker = ["#d9d9d9", "#1f2659"], size = 0.8 }
[[object]]
name = "ball"
shape = "sphere"
radius = 0.5
material = "glass"
translate = [0, 0.5, 0]
rotate = [0, 30, 0]
scale = [1, 2, 1]
[[object]]
shape = "cuboid"
size = [1, 2, 3]
material = "floor"
[[object]]
shape = "cylinder"
radius = 0.3
height = 1.2
[[object]]
shape = "cone"
radius = 0.4
height = 1
material = "glass"
[[object]]
shape = "plane"
material = "floor"
translate = [0, -1, 0]
[[object]]
shape = "quad"
size = [2, 3]
[[object]]
shape = "spheres"
data = [[0, 0, 0, 0.5], [0.27, 0.27, 0.54, 0.1667]]
material = "glass"
"##;

const SMALL_MODEL: &str = "\
# a cube with everything\n\
mtllib small.mtl\no cube\ng faces\ns 1\n\
v -1 -1 -1\nv 1 -1 -1 1.0\nv -1 1 -1\nv 1 1 -1\nv -1 -1 1\nv 1 -1 1\nv -1 1 1\nv 1 1 1 0.5 0.5 0.5\n\
vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1 0\nvn 0 0 -1\nvn 0 0 1\nvn 1 0 0\n\
usemtl red\nf 1/1/1 3/2/1 4/3/1 2/4/1\nf 5//2 6//2 8//2 7//2\ns off\nusemtl glass\n\
f 1/1 2/2 6/3 5/4\nf -8 -6 -2 -4\nf 1 5 7 3\nl 1 2 3\nusemtl nowhere\nf 2 4 8 \\\n6\n";

const SMALL_MATERIALS: &str = "\
newmtl red\nKa 0.1 0.1 0.1\nKd 1 0 0\nKs 0.5 0.5 0.5\nNs 32\nillum 2\nmap_Kd missing.png\n\
newmtl glass\nKd 0.1 0.1 0.1\nNi 1.5\nd 0.2\nTf 1 1 1\nillum 7\nKe 0 0 0\n";

/// What a hostile or clumsy hand might type.
const TOKENS: &[&str] = &[
    "0",
    "-0",
    "-1",
    "1",
    "1e308",
    "-1e308",
    "1e309",
    "1e-320",
    "nan",
    "inf",
    "-inf",
    "4294967296",
    "-2147483649",
    "18446744073709551616",
    "9007199254740993",
    "65535",
    "0.1",
    "\"\"",
    "[]",
    "{}",
    "[",
    "]",
    "{",
    "}",
    "=",
    ",",
    "#",
    "\"",
    "'''",
    "\"\"\"",
    "\n",
    "\r\n",
    "\\",
    "/",
    "//",
    "\0",
    "\u{1b}[2J",
    "\u{202e}",
    "é",
    "𝄞",
    "true",
    "false",
    "\"sphere\"",
    "\"mesh\"",
    "\"spheres\"",
    "[[object]]",
    "[[material]]",
    "[[light]]",
    "[render]",
    "[camera]",
    "[0, 0, 0]",
    "[0, 0, 0, 0]",
    "[1e200, 1e200, 1e200]",
    "radius = 1",
    "v 0 0 0",
    "f 1 2 3",
    "f 1 1 1",
    "f -1 -2 -3",
    "f 0/0/0",
    "f 99999999999 1 2",
    "vt 1",
    "vn 0 0 0",
    "usemtl",
    "mtllib",
    "s 1",
    "..",
    "/dev/null",
    "1_000",
    "0x10",
    "1e",
    "+1",
    "1979-05-27",
    "\t",
    " ",
];

fn pick<'a, T>(rng: &mut SplitMix64, items: &'a [T]) -> &'a T {
    &items[(rng.next_u64() % items.len() as u64) as usize]
}

/// A place in `text` on a character border.
fn border(rng: &mut SplitMix64, text: &str) -> usize {
    let mut at = (rng.next_u64() % (text.len() as u64 + 1)) as usize;
    while !text.is_char_boundary(at) {
        at -= 1;
    }
    at
}

/// Start and end of the run of digits, letters or the like that holds a random place.
fn word(rng: &mut SplitMix64, text: &str) -> (usize, usize) {
    let at = border(rng, text);
    let is_word = |c: char| c.is_alphanumeric() || "+-._#".contains(c);
    let start = text[..at].char_indices().rev().take_while(|(_, c)| is_word(*c)).last().map_or(at, |(i, _)| i);
    let end = at + text[at..].chars().take_while(|c| is_word(*c)).map(char::len_utf8).sum::<usize>();
    (start, end)
}

/// `text` with up to a few changes: words replaced by hostile ones or by words of `other`, lines doubled, dropped,
/// swapped, parts cut or spliced, single characters changed.
fn mutate(rng: &mut SplitMix64, text: &str, other: &str) -> String {
    let mut text = text.to_string();
    for _ in 0..=rng.next_u64() % 4 {
        match rng.next_u64() % 12 {
            0..=3 => {
                let (start, end) = word(rng, &text);
                text.replace_range(start..end, pick::<&str>(rng, TOKENS));
            }
            4 => {
                let (start, end) = word(rng, &text);
                let (from, to) = word(rng, other);
                text.replace_range(start..end, &other[from..to]);
            }
            5 => {
                let at = border(rng, &text);
                text.insert_str(at, pick::<&str>(rng, TOKENS));
            }
            6 => {
                let (a, b) = (border(rng, &text), border(rng, &text));
                let end = a.max(b).min(a.min(b) + 40);
                let end = (end..=text.len()).find(|&i| text.is_char_boundary(i)).unwrap_or(text.len());
                text.replace_range(a.min(b)..end, "");
            }
            7 | 8 => {
                let mut lines: Vec<&str> = text.lines().collect();
                if lines.is_empty() {
                    continue;
                }
                let n = lines.len() as u64;
                let (a, b) = ((rng.next_u64() % n) as usize, (rng.next_u64() % n) as usize);
                match rng.next_u64() % 3 {
                    0 => lines.swap(a, b),
                    1 => lines.insert(a, lines[b]),
                    _ => drop(lines.remove(a)),
                }
                text = lines.join("\n") + "\n";
            }
            9 => {
                let at = border(rng, &text);
                text.truncate(at);
            }
            10 => {
                let (at, from) = (border(rng, &text), border(rng, other));
                text = format!("{}{}", &text[..at], &other[from..]);
            }
            _ => {
                let at = border(rng, &text);
                let c = char::from_u32((rng.next_u64() % 0x250) as u32).unwrap_or('x');
                text.insert(at, c);
            }
        }
    }
    text
}

/// Runs `case` on seeds for a while, or on the one that the environment names. Says which seed failed.
fn run(what: &str, seconds: u64, mut case: impl FnMut(u64)) {
    let number = |name: &str| std::env::var(name).ok().and_then(|s| s.parse().ok());
    let one = number("GLIMT_MUTATION_SEED");
    let time = Duration::from_secs(number("GLIMT_MUTATION_SECONDS").unwrap_or(seconds));
    let start = Instant::now();
    let mut seed = one.unwrap_or(1);
    loop {
        if let Err(panic) = catch_unwind(AssertUnwindSafe(|| case(seed))) {
            eprintln!("{what}: seed {seed} panicked; GLIMT_MUTATION_SEED={seed} runs it again");
            std::panic::resume_unwind(panic);
        }
        seed += 1;
        if one.is_some() || start.elapsed() > time {
            break;
        }
    }
    println!("{what}: {seed} inputs");
}

#[test]
fn no_mutated_scene_panics_or_hangs() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut paths = Vec::new();
    files(&root.join("scenes"), "toml", &mut paths);
    files(&root.join("tests/scenes/good"), "toml", &mut paths);
    let read = |p: PathBuf| std::fs::read_to_string(&p).ok().map(|text| (p, text));
    let mut scenes: Vec<(PathBuf, String)> = paths.into_iter().filter_map(read).collect();
    // Files of many thousand lines teach no more than their first ones and cost much more.
    scenes.retain(|(_, text)| text.len() < 20_000);
    scenes.push((root.join("scenes/small.toml"), SMALL_SCENE.into()));
    run("scenes", 12, |seed| {
        let mut rng = SplitMix64(seed);
        let ((path, text), (_, other)) = (pick(&mut rng, &scenes), pick(&mut rng, &scenes));
        let text = if seed <= scenes.len() as u64 {
            scenes[seed as usize - 1].1.clone()
        } else {
            mutate(&mut rng, text, other)
        };
        targets::scene_text(&text, path, rng.next_u64());
    });
}

#[test]
fn no_mutated_model_panics_or_hangs() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let folder = folder("models");
    let mut paths = Vec::new();
    files(&root.join("scenes"), "obj", &mut paths);
    let mut models: Vec<String> = paths.iter().filter_map(|p| std::fs::read_to_string(p).ok()).collect();
    models.retain(|text| text.len() < 20_000);
    models.push(SMALL_MODEL.into());
    run("models", 8, |seed| {
        let mut rng = SplitMix64(seed ^ 0x5eed << 32);
        let (text, other) = (pick(&mut rng, &models), pick(&mut rng, &models));
        let which = rng.next_u64() % 3;
        let text = if which == 0 { text.clone() } else { mutate(&mut rng, text, other) };
        let mtl = if which == 1 { SMALL_MATERIALS.into() } else { mutate(&mut rng, SMALL_MATERIALS, &text) };
        targets::model(text.as_bytes(), mtl.as_bytes(), &folder, rng.next_u64());
    });
    std::fs::remove_dir_all(&folder).ok();
}

#[test]
fn no_mutated_picture_panics_or_hangs() {
    let folder = folder("pictures");
    let picture = DynamicImage::ImageRgba8(image::RgbaImage::from_fn(9, 7, |x, y| {
        image::Rgba([x as u8 * 28, y as u8 * 36, (x * y) as u8, 255 - x as u8])
    }));
    let formats =
        [("png", ImageFormat::Png), ("jpg", ImageFormat::Jpeg), ("bmp", ImageFormat::Bmp), ("tga", ImageFormat::Tga)];
    let pictures = formats.map(|(extension, format)| {
        let mut bytes = Vec::new();
        let picture = if extension == "jpg" { DynamicImage::ImageRgb8(picture.to_rgb8()) } else { picture.clone() };
        picture.write_to(&mut Cursor::new(&mut bytes), format).expect("a picture can be encoded");
        (extension, bytes)
    });
    run("pictures", 2, |seed| {
        let mut rng = SplitMix64(seed ^ 0x91c << 32);
        let (extension, bytes) = pick(&mut rng, &pictures);
        let mut bytes = bytes.clone();
        for _ in 0..rng.next_u64() % 4 {
            let Some(last) = bytes.len().checked_sub(1) else { break };
            let at = (rng.next_u64() % (last as u64 + 1)) as usize;
            match rng.next_u64() % 5 {
                0 => bytes.truncate(at),
                1 => bytes.insert(at, rng.next_u64() as u8),
                // Most sizes, kinds and lengths stand in the first bytes.
                2 => bytes[at.min(at % 32)] = *pick(&mut rng, &[0, 1, 0x7f, 0x80, 0xff]),
                _ => bytes[at] = rng.next_u64() as u8,
            }
        }
        let extension = if rng.next_u64().is_multiple_of(8) { pick(&mut rng, &formats).0 } else { extension };
        targets::picture(&bytes, extension, &folder);
    });
    std::fs::remove_dir_all(&folder).ok();
}

/// An empty directory of this run.
fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("mutation-{name}-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("the tests' directory can be written");
    folder
}
