//! An interface without a terminal, to be told keys and looked at.

use glimt::description::{LightDesc, ObjectDesc, Projection, RenderDesc, SceneDesc, ShapeDesc};
use glimt::render::{Pass, Rect as Tile, RenderEvent, TileImage, TileStats};
use glimt::scene::{compile, recompile};
use glimt::tui::app::App;
use glimt::tui::color::ColorMode;
use glimt::tui::decode::{Mouse, MouseAction};
use glimt::tui::event::{Effect, Event};
use glimt::tui::key::Key;
use glimt::tui::view::view;
use ratatui::Terminal;
use ratatui::backend::TestBackend;
use ratatui::buffer::Buffer;
use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

pub const WIDTH: u32 = 64;
pub const HEIGHT: u32 = 36;

/// A red ball and a light.
pub fn scene() -> SceneDesc {
    let mut desc = SceneDesc::default();
    (desc.film.width, desc.film.height) = (WIDTH, HEIGHT);
    desc.render = RenderDesc { samples: 4, ..RenderDesc::default() };
    desc.lights.push(LightDesc::default());
    desc.objects.push(ObjectDesc::new(ShapeDesc::Sphere { radius: 1.0 }));
    desc
}

/// An interface and the time it lives in.
pub struct Stage {
    pub app: App,
    pub now: Instant,
    pub effects: Vec<Effect>,
}

impl Stage {
    pub fn new(size: (u16, u16), mode: ColorMode) -> Self {
        let app = App::new(scene(), "balls", Path::new("balls.png"), 2, mode, size);
        Self { app, now: Instant::now(), effects: Vec::new() }
    }

    /// With the first render begun.
    pub fn started(size: (u16, u16)) -> Self {
        let mut stage = Self::new(size, ColorMode::Truecolor);
        assert!(stage.compile());
        stage
    }

    /// With the first render finished: left half red, right half blue.
    pub fn finished(size: (u16, u16)) -> Self {
        let mut stage = Self::started(size);
        stage.tile(|x, _| if x < WIDTH / 2 { [1.0, 0.0, 0.0] } else { [0.0, 0.0, 1.0] });
        stage.tell(Event::Render(RenderEvent::Finished));
        stage.tell(Event::Saved(Ok(100)));
        stage
    }

    pub fn tell(&mut self, event: Event) {
        self.now += Duration::from_millis(40);
        self.effects.extend(self.app.update(event, self.now));
    }

    pub fn keys(&mut self, keys: &str) {
        for c in keys.chars() {
            self.tell(Event::Key(Key::char(c)));
        }
    }

    /// Keys by name, such as `Tab`, `Shift-Left` or `Ctrl-R`.
    pub fn press(&mut self, names: &str) {
        for name in names.split_whitespace() {
            self.tell(Event::Key(name.parse().unwrap()));
        }
    }

    /// With another scene, its first render begun.
    pub fn with(desc: SceneDesc, size: (u16, u16)) -> Self {
        let app = App::new(desc, "balls", Path::new("balls.png"), 2, ColorMode::Truecolor, size);
        let mut stage = Self { app, now: Instant::now(), effects: Vec::new() };
        assert!(stage.compile());
        stage
    }

    pub fn desc(&self) -> &SceneDesc {
        self.app.desc()
    }

    pub fn click(&mut self, column: u16, row: u16, held: bool) {
        self.tell(Event::Mouse(Mouse { column, row, action: MouseAction::Press, held }));
    }

    /// Names of what is selected.
    pub fn selected(&self) -> Vec<String> {
        self.app.editor().selected().iter().map(|target| target.label(self.desc())).collect()
    }

    /// What the loop does after a batch of events, when it has waited for the picture before; whether there was
    /// something to compile.
    pub fn compile(&mut self) -> bool {
        self.app.refresh(self.now);
        self.compile_at(self.now + Duration::from_secs(3600))
    }

    /// What the loop does after a batch of events.
    pub fn compile_at(&mut self, now: Instant) -> bool {
        let Some((desc, previous, changed)) = self.app.begin_compile(now) else { return false };
        let compiled = match previous.as_deref() {
            Some(previous) if !changed.is_empty() => recompile(&desc, previous, &changed),
            previous => compile(&desc, previous),
        };
        self.tell(Event::Compiled(compiled.map(Arc::new)));
        true
    }

    /// A tile that is the whole film, as the first pass reports it.
    pub fn tile(&mut self, pixel: impl Fn(u32, u32) -> [f32; 3]) {
        let rect = Tile { x: 0, y: 0, width: WIDTH, height: HEIGHT };
        let pixels = (0..HEIGHT).flat_map(|y| (0..WIDTH).map(move |x| (x, y))).map(|(x, y)| pixel(x, y)).collect();
        let pass = Pass::sequence(4)[0];
        let stats = TileStats { samples: 100, busy: Duration::from_millis(30), ..TileStats::default() };
        self.tell(Event::Render(RenderEvent::TileFinished {
            worker: 0,
            tile: TileImage { rect, pixels, ..TileImage::default() },
            stats,
            pass,
        }));
    }

    pub fn buffer(&mut self) -> Buffer {
        self.app.refresh(self.now);
        let (columns, rows) = self.app.size();
        let mut terminal = Terminal::new(TestBackend::new(columns, rows)).unwrap();
        terminal.draw(|frame| view(&self.app, frame.buffer_mut())).unwrap();
        terminal.backend().buffer().clone()
    }

    pub fn text(&mut self) -> String {
        let buffer = self.buffer();
        let row = |y| (0..buffer.area.width).map(|x| buffer[(x, y)].symbol()).collect::<String>();
        (0..buffer.area.height).map(row).collect::<Vec<_>>().join("\n")
    }

    pub fn status(&mut self) -> String {
        self.text().lines().last().unwrap().to_owned()
    }

    pub fn samples_fov_depth(&self) -> (u32, f64, u32) {
        let Projection::Perspective { fov } = self.app.desc().camera.projection else { panic!("not in this scene") };
        (self.app.desc().render.samples, fov, self.app.desc().render.max_depth)
    }
}
