//! Views of scene and render, and the ray tree of a pixel.

use super::editor::three;
use super::stage::{HEIGHT, Stage, WIDTH};
use glimt::description::Target;
use glimt::render::{Pass, Rect as Tile, RenderEvent, Settings, TileImage, TileStats, View, start_probe, viridis};
use glimt::shading::Probe;
use glimt::tui::dialog::Dialog;
use glimt::tui::event::{Effect, Event};
use ratatui::style::Color;
use std::num::NonZeroUsize;

/// What the newest effect asks to be traced for the view.
fn asked(stage: &Stage) -> Option<Probe> {
    let last = stage.effects.iter().rev().find_map(|effect| match effect {
        Effect::Probe(wanted) => Some(wanted.as_ref().map(|(_, probe)| *probe)),
        _ => None,
    });
    last.expect("a view was asked for")
}

/// Does what the loop does for the view.
fn trace(stage: &mut Stage) {
    let wanted = stage.effects.iter().rev().find_map(|effect| match effect {
        Effect::Probe(wanted) => Some(wanted.clone()),
        _ => None,
    });
    let (scene, probe) = wanted.flatten().expect("something is to be traced");
    let settings = Settings { threads: NonZeroUsize::MIN, ..Settings::default() };
    for event in start_probe(scene, probe, settings).events() {
        stage.tell(Event::Probed(event));
    }
}

fn color(code: [f32; 3]) -> Color {
    let [r, g, b] = code.map(|c| (c * 255.0).round() as u8);
    Color::Rgb(r, g, b)
}

#[test]
fn keys_go_through_the_views_and_come_back_to_the_picture() {
    let mut stage = Stage::with(three(), (120, 40));
    stage.tile(|_, _| [1.0, 0.0, 0.0]);
    let area = stage.app.layout().preview;
    let at = (area.x + area.width / 2, area.y + area.height / 2);
    assert_eq!(stage.buffer()[at].fg, Color::Rgb(255, 0, 0));
    for (name, view) in View::NAMES.iter().skip(1) {
        stage.keys(")");
        assert_eq!((stage.app.shown().view(), asked(&stage)), (*view, view.probe()));
        if view.probe().is_some() {
            trace(&mut stage);
        }
        let text = stage.text();
        let legend = text.lines().nth(usize::from(area.bottom()) - 1).unwrap();
        let listed = matches!(view, View::Object | View::Material);
        assert!(legend.contains(name) || (listed && text.contains(name)), "{name}\n{text}");
        assert_ne!(stage.buffer()[at].fg, Color::Rgb(255, 0, 0), "{name}");
    }
    stage.keys(")");
    assert_eq!((stage.app.shown().view(), asked(&stage)), (View::Final, None));
    assert_eq!(stage.buffer()[at].fg, Color::Rgb(255, 0, 0));
    stage.keys("((");
    assert_eq!(stage.app.shown().view(), View::Error);
}

#[test]
fn the_legend_has_the_colours_of_the_picture_and_the_names_of_the_scene() {
    let mut stage = Stage::with(three(), (200, 60));
    stage.press(":");
    stage.keys("show objects");
    stage.press("Enter");
    trace(&mut stage);
    let (area, text) = (stage.app.layout().preview, stage.text());
    for (index, name) in ["left", "right", "floor"].into_iter().enumerate() {
        let all: Vec<_> = text.lines().collect();
        let row = all.iter().rposition(|line| line.contains(&format!("██ {} {name}", index + 1))).expect(name) as u16;
        let buffer = stage.buffer();
        let swatch = buffer[(area.x + 1, row)].fg;
        assert_eq!(swatch, color(glimt::render::index_color(index as u32 + 1)));
        // A pixel in the middle of the object has that colour.
        let scene = glimt::scene::compile(stage.desc(), None).unwrap();
        let is_it =
            |x: u32, y: u32| scene.pick(x, y).map(|pick| Target::Object(pick.object)) == Some(Target::Object(index));
        let shown = (0..area.height).flat_map(|y| (0..area.width).map(move |x| (x, y))).any(|(x, y)| {
            let pixel = stage.app.preview().film_pixel(x.into(), 2 * usize::from(y));
            pixel.is_some_and(|(x, y)| is_it(x, y)) && buffer[(area.x + x, area.y + y)].fg == swatch
        });
        assert!(shown, "{name}");
    }
    // Depth: a bar from the first colour to the last, with numbers at both ends.
    stage.press(":");
    stage.keys("show depth");
    stage.press("Enter");
    trace(&mut stage);
    let row = area.bottom() - 1;
    let text = stage.text();
    let legend = text.lines().nth(row.into()).unwrap();
    assert!(legend.contains("units"), "{legend}");
    let first = legend.chars().position(|c| c == '█').unwrap() as u16;
    let buffer = stage.buffer();
    assert_eq!(buffer[(first, row)].fg, color(viridis(0.0)));
    assert_eq!(buffer[(first + 15, row)].fg, color(viridis(1.0)));
}

#[test]
fn an_edit_traces_the_view_again_and_the_render_goes_on_beside_it() {
    let mut stage = Stage::with(three(), (120, 40));
    stage.keys(")");
    trace(&mut stage);
    let before = stage.buffer();
    // Tiles of the render do not show, but are not lost.
    stage.tile(|_, _| [1.0, 0.0, 0.0]);
    assert_eq!(stage.app.film().pixel(3, 3), [1.0, 0.0, 0.0]);
    let area = stage.app.layout().preview;
    assert_eq!(stage.buffer()[(area.x + 30, area.y + 20)], before[(area.x + 30, area.y + 20)]);
    let asked_before = stage.effects.len();
    stage.keys("i");
    assert!(stage.compile());
    assert!(stage.effects[asked_before..].iter().any(|e| matches!(e, Effect::Probe(Some((_, Probe::Normals))))));
    trace(&mut stage);
    assert_ne!(stage.buffer()[(area.x + 30, area.y + 20)].fg, Color::Rgb(255, 0, 0));
    // A film of another size.
    let mut desc = three();
    (desc.film.width, desc.film.height) = (33, 20);
    let mut small = Stage::with(desc, (80, 24));
    small.keys("))");
    trace(&mut small);
    small.text();
}

#[test]
fn samples_errors_and_losses_are_shown_as_the_render_tells_them() {
    let mut stage = Stage::with(three(), (120, 40));
    stage.tell(Event::Render(RenderEvent::TileFinished {
        worker: 0,
        tile: TileImage {
            rect: Tile { x: 0, y: 0, width: WIDTH, height: HEIGHT },
            pixels: vec![[0.5; 3]; (WIDTH * HEIGHT) as usize],
            samples: (0..WIDTH * HEIGHT).map(|at| if at % WIDTH < WIDTH / 2 { 1 } else { 16 }).collect(),
            errors: (0..WIDTH * HEIGHT).map(|at| if at % WIDTH < WIDTH / 2 { 0.0 } else { 1.0 }).collect(),
            non_finite: (0..WIDTH * HEIGHT).map(|at| u32::from(at == 0)).collect(),
            ..TileImage::default()
        },
        stats: TileStats { non_finite: 1, overfull: 2, ..TileStats::default() },
        pass: Pass::sequence(4)[0],
    }));
    // The panel tells how many samples were lost and how to see why, and how many were in more glass than is kept track
    // of.
    stage.now += std::time::Duration::from_secs(1);
    let text: String = stage.text().split_whitespace().collect::<Vec<_>>().join(" ");
    for told in ["1 not finite: glimt explain --pixel 0,0 --size", "robust --shading whitted", "2 overfull"] {
        assert!(text.contains(told), "no {told} in {text}");
    }
    let area = stage.app.layout().preview;
    let (left, right) = ((area.x + 10, area.y + area.height / 2), (area.right() - 10, area.y + area.height / 2));
    for view in ["samples per pixel", "estimated error"] {
        stage.press(":");
        stage.keys(&format!("show {view}"));
        stage.press("Enter");
        let buffer = stage.buffer();
        assert_eq!((buffer[left].fg, buffer[right].fg), (color(viridis(0.0)), color(viridis(1.0))), "{view}");
    }
    assert!(stage.text().contains("of 255"));
    stage.keys(")");
    assert!(stage.text().contains("1 samples in 1 pixels"), "{}", stage.text());
}

#[test]
fn the_ray_tree_of_the_pixel_under_the_cursor_opens_scrolls_and_closes() {
    for size in [(200, 60), (80, 24), (80, 9), (20, 6)] {
        let mut stage = Stage::with(three(), size);
        stage.press("Enter");
        let (x, y) = stage.app.cursor().expect("there is a cursor");
        let (x, y) = stage.app.preview().film_pixel(x, y).unwrap();
        stage.keys("Y");
        assert!(matches!(stage.app.dialog(), Some(Dialog::Rays(_))));
        let text = stage.text();
        if size.0 < 80 {
            continue;
        }
        assert!(text.contains(&format!("Why this colour? Pixel {x},{y}")), "{text}");
        assert!(text.contains("camera ray, in the world") && (size.1 < 24 || text.contains("k_a I_a C")), "{text}");
        let top = stage.text();
        stage.press("Down Down");
        if size.1 < 20 {
            assert_ne!(stage.text(), top);
        }
        stage.press("Up Up");
        assert!(stage.text().contains("camera ray"));
        stage.press("Esc");
        assert!(stage.app.dialog().is_none() && stage.app.cursor().is_some());
    }
    // Without the cursor: the pixel that was clicked.
    let mut stage = Stage::with(three(), (200, 60));
    let area = stage.app.layout().preview;
    stage.click(area.x + 40, area.y + 30, false);
    let (x, y) = stage.app.preview().film_pixel(40, 60).unwrap();
    stage.keys("Y");
    assert!(stage.text().contains(&format!("Pixel {x},{y}")), "{}", stage.text());
    // The numbers are those of the scene as it was compiled.
    let told =
        glimt::render::explain(&glimt::scene::compile(stage.desc(), None).unwrap(), stage.desc(), (x, y), 1, None);
    let sum = told.tree.lines().last().unwrap().text.clone();
    assert!(stage.text().contains(&sum), "{sum}\n{}", stage.text());
}
