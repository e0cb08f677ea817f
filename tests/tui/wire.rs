//! What is sent to the terminal: how near to the picture, how many bytes.

use super::{Stage, scene};
use glimt::description::{
    Background, LightKind, MaterialDesc, ObjectDesc, SceneDesc, ShapeDesc, TextureDesc, TextureSource,
};
use glimt::math::{Rgb, SplitMix64, linear_to_srgb8, srgb8_to_linear};
use glimt::render::{Film, Rect as Tile, RenderEvent, Settings, TileImage, start};
use glimt::scene::compile;
use glimt::tui::app::App;
use glimt::tui::color::{ColorMode, delta_e};
use glimt::tui::preview::Preview;
use glimt::tui::view::view;
use glimt::tui::writer::{Frame, Screen};
use ratatui::backend::{Backend, CrosstermBackend};
use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::Color;
use std::num::NonZeroU16;
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

/// A terminal at the far end.
struct FarEnd {
    parser: vt100::Parser,
    bytes: usize,
}

impl FarEnd {
    fn new(columns: u16, rows: u16) -> Self {
        let [rows, columns] = [rows, columns].map(|n| NonZeroU16::new(n).unwrap());
        Self { parser: vt100::Parser::new(rows, columns, 0), bytes: 0 }
    }

    /// Sends chunks until nothing is left to send.
    fn receive(&mut self, screen: &mut Screen, frame: &Frame, allowance: usize) {
        loop {
            let (chunk, complete) = screen.chunk(frame, allowance);
            // A chunk ends with the segment that exceeds the allowance.
            assert!(chunk.len() <= allowance + 16 * 45, "{} of {allowance}", chunk.len());
            self.parser.process(&chunk);
            // The question at the end of a chunk moves the cursor.
            self.parser.process(b"\x1b[2;3H");
            self.bytes += chunk.len();
            if complete {
                return;
            }
        }
    }

    /// Upper and lower pixel of a cell.
    fn pixels(&self, x: u16, y: u16) -> [[u8; 3]; 2] {
        let cell = self.parser.screen().cell(y, x).unwrap();
        let code = |color| match color {
            vt100::Color::Rgb(r, g, b) => [r, g, b],
            other => panic!("{other:?} at {x}, {y}"),
        };
        match cell.contents() {
            "▀" => [code(cell.fgcolor()), code(cell.bgcolor())],
            "▄" => [code(cell.bgcolor()), code(cell.fgcolor())],
            "█" => [code(cell.fgcolor()); 2],
            "" | " " => [code(cell.bgcolor()); 2],
            other => panic!("{other:?} at {x}, {y}"),
        }
    }
}

/// Cells of pixels; `pixel` gives the sRGB code of a half cell.
fn frame(columns: u16, rows: u16, exact: bool, pixel: impl Fn(u16, u16) -> [u8; 3]) -> Frame {
    let mut buffer = Buffer::empty(Rect::new(0, 0, columns, rows));
    for y in 0..rows {
        for x in 0..columns {
            let code = |y| {
                let [r, g, b] = pixel(x, y);
                Color::Rgb(r, g, b)
            };
            buffer[(x, y)].set_symbol("▀").set_fg(code(2 * y)).set_bg(code(2 * y + 1));
        }
    }
    Frame { buffer, exact }
}

/// Balls over a chequered floor, as the program renders them.
fn balls(width: u32, height: u32) -> Film {
    let mut desc = scene();
    (desc.film.width, desc.film.height) = (width, height);
    let material = |name: &str, color, reflect, texture| MaterialDesc {
        name: name.into(),
        color,
        reflect,
        texture,
        ..MaterialDesc::default()
    };
    let checker = TextureSource::Checker { colors: [Rgb::grey(0.8), Rgb::new(0.02, 0.03, 0.1)], size: 1.0 };
    let texture = TextureDesc { source: checker, scale: glam::DVec2::ONE, offset: glam::DVec2::ZERO };
    // Under a directional light the squares of the floor and the sky are even, as in most pictures of this kind.
    desc.lights[0].kind = LightKind::Directional { direction: glam::DVec3::new(-1.0, -2.0, -0.7) };
    desc.materials.push(MaterialDesc { specular: 0.0, ..material("floor", Rgb::WHITE, 0.0, Some(texture)) });
    desc.materials.push(material("ball", Rgb::new(0.7, 0.2, 0.1), 0.3, None));
    desc.objects.clear();
    for (x, z) in [(-1.2, 0.0), (0.4, 1.0), (1.3, -1.5)] {
        let mut ball = ObjectDesc::new(ShapeDesc::Sphere { radius: 0.8 });
        (ball.translate, ball.material) = (glam::DVec3::new(x, 0.0, z), Some("ball".into()));
        desc.objects.push(ball);
    }
    let mut floor = ObjectDesc::new(ShapeDesc::Plane);
    (floor.translate.y, floor.material) = (-0.8, Some("floor".into()));
    desc.objects.push(floor);
    desc.world.background = Background::Solid(Rgb::new(0.2, 0.4, 0.8));
    film_of(&desc)
}

fn film_of(desc: &SceneDesc) -> Film {
    let scene = Arc::new(compile(desc, None).unwrap());
    let mut film = Film::new(scene.width, scene.height);
    for event in start(scene, Settings::default()).events() {
        if let RenderEvent::TileFinished { tile, .. } = event {
            film.write(&tile);
        }
    }
    film
}

/// A film by formula.
fn film(width: u32, height: u32, pixel: impl Fn(u32, u32) -> [f32; 3]) -> Film {
    let mut film = Film::new(width, height);
    let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| pixel(x, y)).collect();
    film.write(&TileImage { rect: Tile { x: 0, y: 0, width, height }, pixels, ..TileImage::default() });
    film
}

/// The exact mean of the film's part of a half cell, linear: columns and rows divide the film evenly here.
fn exact(film: &Film, columns: u32, rows: u32, x: u32, y: u32) -> [f64; 3] {
    let (wide, high) = (film.width() / columns, film.height() / rows);
    assert_eq!((wide * columns, high * rows), (film.width(), film.height()));
    let mut sum = [0.0; 3];
    for j in y * high..(y + 1) * high {
        for i in x * wide..(x + 1) * wide {
            for (sum, v) in sum.iter_mut().zip(film.pixel(i, j)) {
                *sum += f64::from(v.clamp(0.0, 1.0)) / f64::from(wide * high);
            }
        }
    }
    sum
}

#[test]
fn what_the_far_end_shows_is_the_box_filtered_film_to_55_decibels() {
    let (width, height) = (960, 480);
    let gradient = film(width, height, |x, y| [x as f32 / 960.0, y as f32 / 480.0, 0.3]);
    // Squares that shrink to a pixel: the mean of black and white is not the code in the middle.
    let chirp = film(width, height, |x, y| {
        let size = 1 + (959 - x) / 60;
        if (x / size + y / size) % 2 == 0 { [1.0; 3] } else { [0.0; 3] }
    });
    for (name, film) in [("gradient", gradient), ("checker", chirp), ("balls", balls(width, height))] {
        let mut preview = Preview::default();
        preview.set_film(width, height);
        preview.set_area(120, 30);
        preview.refresh(&film);
        let area = Rect::new(0, 0, 120, 30);
        let mut buffer = Buffer::empty(area);
        preview.paint(area, &mut buffer, ColorMode::Truecolor);
        let stock = stock_bytes(&buffer);
        let (mut far, mut screen) = (FarEnd::new(120, 30), Screen::default());
        far.receive(&mut screen, &Frame { buffer, exact: true }, usize::MAX / 2);
        let mut squares = 0.0;
        for y in 0..60u16 {
            for x in 0..120u16 {
                let shown = far.pixels(x, y / 2)[usize::from(y % 2)];
                let curve = |v: f64| 255.0 * if v <= 0.0031308 { 12.92 * v } else { 1.055 * v.powf(1.0 / 2.4) - 0.055 };
                for (code, mean) in shown.iter().zip(exact(&film, 120, 60, x.into(), y.into())) {
                    squares += (f64::from(*code) - curve(mean)).powi(2);
                }
            }
        }
        let decibels = 10.0 * (255.0 * 255.0 / (squares / (120.0 * 60.0 * 3.0))).log10();
        assert!(decibels >= 55.0, "{name}: {decibels:.1} dB");
        println!("{name}: {decibels:.1} dB, {} bytes, {stock} from ratatui's own backend", far.bytes);
        let even = if name == "balls" { 0.9 } else { 1.0 };
        assert!(far.bytes as f64 <= even * stock as f64, "{name}: {} bytes of {stock}", far.bytes);
    }
}

/// What ratatui's own backend sends for a whole screen.
fn stock_bytes(buffer: &Buffer) -> usize {
    let mut bytes = Vec::new();
    let cells = buffer.area.positions().map(|p| (p.x, p.y, &buffer[p]));
    CrosstermBackend::new(&mut bytes).draw(cells).unwrap();
    bytes.len()
}

#[test]
fn noise_costs_no_more_than_37_bytes_a_cell() {
    let mut random = SplitMix64(5);
    let codes: Vec<[u8; 3]> = (0..80 * 48).map(|_| [(); 3].map(|()| random.next_u64() as u8)).collect();
    let frame = frame(80, 24, true, |x, y| codes[usize::from(y) * 80 + usize::from(x)]);
    let (mut far, mut screen) = (FarEnd::new(80, 24), Screen::default());
    far.receive(&mut screen, &frame, usize::MAX / 2);
    assert!(far.bytes <= 37 * 80 * 24, "{} a cell", far.bytes as f64 / (80.0 * 24.0));
}

/// A picture that converges: noise of ever smaller size over a gradient.
fn converging(step: u32, exact: bool) -> Frame {
    let seed = |x: u16, y: u16| SplitMix64(u64::from(step) << 32 | u64::from(x) << 16 | u64::from(y));
    frame(80, 24, exact, |x, y| {
        let mut random = seed(x, y);
        let noise = (random.next_u64() % 1000) as f64 / 1000.0 - 0.5;
        let light = f64::from(x) / 100.0 + 0.1 + 0.3 * noise / f64::from(step + 1);
        [linear_to_srgb8(light), linear_to_srgb8(light * 0.8), linear_to_srgb8(srgb8_to_linear(90))]
    })
}

#[test]
fn colours_are_held_while_nobody_can_see_the_difference_and_exact_at_the_end() {
    let (mut far, mut screen) = (FarEnd::new(80, 24), Screen::default());
    let (mut all, mut everything) = (FarEnd::new(80, 24), Screen::default());
    for step in 0..60 {
        let frame = converging(step, false);
        far.receive(&mut screen, &frame, usize::MAX / 2);
        all.receive(&mut everything, &Frame { exact: true, ..frame.clone() }, usize::MAX / 2);
        for y in 0..24 {
            for x in 0..80 {
                let wanted = [frame.buffer[(x, y)].fg, frame.buffer[(x, y)].bg];
                for (wanted, shown) in wanted.into_iter().zip(far.pixels(x, y)) {
                    let Color::Rgb(r, g, b) = wanted else { panic!("no colour") };
                    assert!(delta_e([r, g, b], shown) <= 1.0, "step {step}: {wanted:?} as {shown:?}");
                }
            }
        }
    }
    assert!(2 * far.bytes < all.bytes, "{} against {}", far.bytes, all.bytes);
    let last = converging(59, true);
    far.receive(&mut screen, &last, usize::MAX / 2);
    for y in 0..24 {
        for x in 0..80 {
            assert_eq!(far.pixels(x, y), all.pixels(x, y));
        }
    }
    assert!(screen.chunk(&last, 1000).0.is_empty());
}

#[test]
fn small_chunks_reach_the_same_screen_with_the_status_line_first() {
    let mut stage = Stage::finished((80, 24));
    let frame = Frame { buffer: stage.buffer(), exact: true };
    let (mut whole, mut slow) = (FarEnd::new(80, 24), FarEnd::new(80, 24));
    whole.receive(&mut Screen::default(), &frame, usize::MAX / 2);
    let mut screen = Screen::default();
    let (first, complete) = screen.chunk(&frame, 300);
    slow.parser.process(&first);
    assert!(!complete);
    assert!(slow.parser.screen().contents().contains("finished"));
    slow.receive(&mut screen, &frame, 300);
    assert_eq!(slow.parser.screen().contents_formatted(), whole.parser.screen().contents_formatted());
    // Text as the view has it.
    for (row, line) in stage.text().lines().enumerate().skip(18) {
        let shown: String = slow.parser.screen().rows(0, 80).nth(row).unwrap();
        assert_eq!(shown.trim_end(), line.trim_end());
    }
}

#[test]
fn a_wide_character_in_a_name_does_not_shift_what_follows() {
    let mut app = App::new(scene(), "球と円", Path::new("球.png"), 2, ColorMode::Truecolor, (80, 24));
    app.refresh(Instant::now());
    let mut buffer = Buffer::empty(Rect::new(0, 0, 80, 24));
    view(&app, &mut buffer);
    let (mut far, mut screen) = (FarEnd::new(80, 24), Screen::default());
    far.receive(&mut screen, &Frame { buffer, exact: true }, usize::MAX / 2);
    let row = far.parser.screen().rows(0, 80).find(|row| row.contains('球')).unwrap();
    assert!(row.contains("球と円  64×36  whitted"), "{row}");
}
