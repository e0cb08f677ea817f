//! Flags, as clap reads them.

use super::Failure;
use super::compare::CompareArgs;
use super::open::Opened;
use super::study::StudyCommand;
use crate::bvh::Isa;
use crate::description::{DEMO, FilmDesc, Filter, Numerics, SceneDesc, Shading, Shadows, limits};
use crate::render::{Settings, View};
use crate::tui::ColorChoice;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use clap::{Args, Parser, Subcommand};
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// `glimt [SCENE]`, `glimt render`, `glimt check`.
#[derive(Debug, Parser)]
#[command(
    name = "glimt",
    version,
    about = "Renders scenes by ray tracing, live in the terminal",
    args_conflicts_with_subcommands = true,
    after_help = "Exit codes: 0 done, 1 could not, 2 asked wrongly, 130 and 143 stopped by SIGINT and SIGTERM."
)]
pub struct Cli {
    #[command(subcommand)]
    pub command: Option<Command>,
    #[command(flatten)]
    pub show: RenderArgs,
}

#[derive(Debug, Subcommand)]
pub enum Command {
    /// Render to a PNG file, without the interface
    Render(RenderArgs),
    /// Say what a scene has, and what is wrong with it
    Check(CheckArgs),
    /// Say what a scene pays for and does not need, with what that saves
    Advise(AdviseArgs),
    /// Say why a pixel has its colour, ray by ray
    Explain(ExplainArgs),
    /// List the keys of the interface
    Keys(KeysArgs),
    /// Say how far two pictures are apart
    Compare(CompareArgs),
    /// Measure speed, accuracy and growth, and draw them
    #[command(subcommand)]
    Study(StudyCommand),
}

#[derive(Debug, Args)]
pub struct CheckArgs {
    /// Scene (.toml) or model (.obj) [default: the demo scene, which is built in]
    pub scene: Option<PathBuf>,
    #[command(flatten)]
    pub isa: IsaArg,
    #[command(flatten)]
    pub color: ColorArg,
}

#[derive(Debug, Args)]
pub struct AdviseArgs {
    /// Scene (.toml) or model (.obj) [default: the demo scene, which is built in]
    pub scene: Option<PathBuf>,
    /// As JSON
    #[arg(long)]
    pub json: bool,
    /// Render threads [default: all processors]
    #[arg(short, long, value_name = "N", value_parser = threads, allow_negative_numbers = true)]
    pub threads: Option<NonZeroUsize>,
    #[command(flatten)]
    pub isa: IsaArg,
    #[command(flatten)]
    pub color: ColorArg,
}

#[derive(Debug, Args)]
pub struct KeysArgs {
    /// As a table in Markdown
    #[arg(long)]
    pub markdown: bool,
    #[command(flatten)]
    pub color: ColorArg,
}

/// What is rendered, and how.
#[derive(Debug, Args)]
pub struct SceneArgs {
    /// Scene (.toml) or model (.obj) [default: the demo scene, which is built in]
    pub scene: Option<PathBuf>,
    /// Pixels across and down, instead of the scene's
    #[arg(long, value_name = "WxH", value_parser = size, allow_hyphen_values = true)]
    pub size: Option<(u32, u32)>,
    /// Samples a pixel; with --error or --time the most that a pixel gets
    #[arg(long, value_name = "N", value_parser = whole(1, limits::MAX_SAMPLES), allow_negative_numbers = true)]
    pub samples: Option<u32>,
    /// Refine where the picture is wrong until its error is down to this: root mean square in 8-bit codes
    #[arg(long, value_name = "CODES", value_parser = error, allow_negative_numbers = true)]
    pub error: Option<f64>,
    /// How samples make a pixel
    #[arg(long, value_name = "FILTER", value_parser = named(Filter::NAMES))]
    pub filter: Option<Filter>,
    /// Reflections and refractions along a path
    #[arg(long, value_name = "N", value_parser = whole(0, limits::MAX_DEPTH), allow_negative_numbers = true)]
    pub max_depth: Option<u32>,
    /// Lighting model
    #[arg(long, value_name = "MODEL", value_parser = named(Shading::NAMES))]
    pub shading: Option<Shading>,
    /// What glass does to shadow rays
    #[arg(long, value_name = "KIND", value_parser = named(Shadows::NAMES))]
    pub shadows: Option<Shadows>,
    /// Arithmetic that finds the hits
    #[arg(long, value_name = "PRESET", value_parser = named(Numerics::NAMES))]
    pub numerics: Option<Numerics>,
    #[command(flatten)]
    pub isa: IsaArg,
}

#[derive(Debug, Args)]
pub struct RenderArgs {
    #[command(flatten)]
    pub scene: SceneArgs,
    /// Where the picture goes [default: <SCENE>.png in this directory; of another view <SCENE>-VIEW.png]
    #[arg(short, long, value_name = "PNG")]
    pub output: Option<PathBuf>,
    /// What the picture shows
    #[arg(long, value_name = "VIEW", default_value = "final", value_parser = named(View::NAMES))]
    pub view: View,
    /// Worker threads [default: all processors]
    #[arg(long, value_name = "N", value_parser = threads, allow_negative_numbers = true)]
    pub threads: Option<NonZeroUsize>,
    /// Render the best picture that can be had in this many seconds
    #[arg(long, value_name = "SECONDS", value_parser = seconds, allow_negative_numbers = true)]
    pub time: Option<Duration>,
    /// Side of a tile in pixels, a multiple of 8; changes nothing in the picture
    #[arg(
        long, value_name = "N", hide = true, default_value_t = Settings::default().tile_size,
        value_parser = tile_size, allow_negative_numbers = true
    )]
    pub tile_size: u32,
    /// Print one JSON object about the render on stdout; no interface
    #[arg(long)]
    pub json: bool,
    /// Print nothing but errors; no interface
    #[arg(short, long)]
    pub quiet: bool,
    #[command(flatten)]
    pub color: ColorArg,
}

#[derive(Debug, Args)]
pub struct ExplainArgs {
    #[command(flatten)]
    pub scene: SceneArgs,
    /// Column and row of the pixel, from 0 at the upper left
    #[arg(long, value_name = "X,Y", value_parser = pixel, allow_hyphen_values = true)]
    pub pixel: (u32, u32),
    /// Whose rays are shown, from 0 [default: the first that is not finite, or else 0]
    #[arg(long, value_name = "N", value_parser = whole(0, limits::MAX_SAMPLES - 1), allow_negative_numbers = true)]
    pub sample: Option<u32>,
    /// Print one JSON object on stdout
    #[arg(long)]
    pub json: bool,
    #[command(flatten)]
    pub color: ColorArg,
}

#[derive(Debug, Args)]
pub struct IsaArg {
    /// Instruction set to trace with: portable (or sse2), avx2 or avx512 [default: GLIMT_ISA, or the fastest here]
    #[arg(long, value_name = "NAME", value_parser = str::parse::<Isa>)]
    isa: Option<Isa>,
}

impl IsaArg {
    /// What the flag says, or else [`usual_isa`].
    pub fn chosen(&self) -> Result<Isa, Failure> {
        self.isa.map_or_else(usual_isa, Ok)
    }
}

/// What the variable `GLIMT_ISA` says, or else the fastest that there is.
pub fn usual_isa() -> Result<Isa, Failure> {
    const VARIABLE: &str = "GLIMT_ISA";
    match std::env::var_os(VARIABLE) {
        Some(name) if !name.is_empty() => {
            let name = name.to_string_lossy();
            name.parse().map_err(|error| Failure::Asked(format!("the variable {VARIABLE} is '{name}': {error}")))
        }
        _ => Ok(Isa::best()),
    }
}

#[derive(Debug, Args)]
pub struct ColorArg {
    /// Colours of the terminal
    #[arg(long, value_name = "WHEN", default_value = "auto", value_parser = color())]
    pub color: ColorChoice,
}

impl SceneArgs {
    /// Opens the scene and puts the flags into it. `time`: the seconds that the render has.
    pub fn open(&self, time: Option<Duration>) -> Result<Opened, Failure> {
        let film = self.size.map(|(width, height)| FilmDesc { width, height });
        let mut opened = Opened::new(self.scene.as_deref(), film, self.isa.chosen()?)?;
        self.override_scene(&mut opened.desc, time);
        Ok(opened)
    }

    /// The command that shows the rays of a pixel of this very picture.
    pub fn explain_command(&self, (x, y): (u32, u32)) -> String {
        let scene = self.scene.as_deref().unwrap_or(Path::new(DEMO)).to_string_lossy();
        let mut line = format!("glimt explain {scene} --pixel {x},{y}");
        let flags = [
            ("size", self.size.map(|(width, height)| format!("{width}x{height}"))),
            ("samples", self.samples.map(|samples| samples.to_string())),
            ("error", self.error.map(|error| error.to_string())),
            ("filter", self.filter.map(|filter| filter.name().into())),
            ("max-depth", self.max_depth.map(|depth| depth.to_string())),
            ("shading", self.shading.map(|shading| shading.name().into())),
            ("shadows", self.shadows.map(|shadows| shadows.name().into())),
            ("numerics", self.numerics.map(|numerics| numerics.name().into())),
        ];
        for (flag, value) in flags {
            line.extend(value.map(|value| format!(" --{flag} {value}")));
        }
        line
    }

    /// Replaces what the scene says by what the flags say.
    fn override_scene(&self, desc: &mut SceneDesc, time: Option<Duration>) {
        if let Some((width, height)) = self.size {
            (desc.film.width, desc.film.height) = (width, height);
        }
        let render = &mut desc.render;
        if self.samples.is_some() || self.error.is_some() || time.is_some() {
            // Where rendering ends is asked for here: the scene's own end does not count.
            let endless = time.map(|_| 0.0);
            render.error = self.error.or(endless);
            let most = if self.error.is_some() { limits::ADAPTIVE_SAMPLES } else { limits::MAX_SAMPLES };
            render.samples = self.samples.unwrap_or(most);
        }
        render.filter = self.filter.unwrap_or(render.filter);
        render.max_depth = self.max_depth.unwrap_or(render.max_depth);
        render.shading = self.shading.unwrap_or(render.shading);
        render.shadows = self.shadows.unwrap_or(render.shadows);
        render.numerics = self.numerics.unwrap_or(render.numerics);
    }
}

impl RenderArgs {
    /// What the interface does with a scene that says no end, if no flag does: it refines where the picture is wrong.
    pub fn end_usually(&self, desc: &mut SceneDesc) {
        if self.scene.samples.is_none() && self.scene.error.is_none() && self.time.is_none() {
            (desc.render.error, desc.render.samples) = (Some(limits::USUAL_ERROR), limits::ADAPTIVE_SAMPLES);
        }
    }

    /// Threads and tiles.
    pub fn settings(&self) -> Settings {
        Settings { threads: self.threads.unwrap_or_else(crate::render::default_threads), tile_size: self.tile_size }
    }
}

/// Most threads that can be asked for: more than any machine has processors, fewer than break one.
const MAX_THREADS: usize = 1024;

pub(super) fn size(text: &str) -> Result<(u32, u32), String> {
    let form = "write it as 1280x720";
    let (width, height) = text.split_once(['x', 'X', '×']).ok_or(form)?;
    let side = |text: &str| match text.trim().parse::<u32>() {
        Ok(side) if (1..=limits::MAX_SIDE).contains(&side) => Ok(side),
        Err(_) if !is_whole(text.trim()) => Err(form.to_owned()),
        _ => Err(format!("width and height are from 1 to {}", limits::MAX_SIDE)),
    };
    Ok((side(width)?, side(height)?))
}

fn pixel(text: &str) -> Result<(u32, u32), &'static str> {
    let number = |text: &str| text.trim().parse().ok();
    let found = text.split_once(',').and_then(|(x, y)| Some((number(x)?, number(y)?)));
    found.ok_or("write it as 320,200: column and row from 0")
}

/// Whether this is a whole number, however large, perhaps with a sign.
fn is_whole(text: &str) -> bool {
    let digits = text.strip_prefix(['-', '+']).unwrap_or(text);
    !digits.is_empty() && digits.bytes().all(|b| b.is_ascii_digit())
}

pub(super) fn error(text: &str) -> Result<f64, String> {
    let (low, high) = (limits::ERROR.start(), limits::ERROR.end());
    let found = text.parse().ok().filter(|number| limits::ERROR.contains(number));
    found.ok_or_else(|| format!("must be from {low} to {high}"))
}

/// The longest time that can be asked for: a week.
const MAX_SECONDS: f64 = 604_800.0;

fn seconds(text: &str) -> Result<Duration, String> {
    let found = text.parse().ok().filter(|seconds| (0.001..=MAX_SECONDS).contains(seconds));
    found.map(Duration::from_secs_f64).ok_or_else(|| format!("must be from 0.001 to {MAX_SECONDS}"))
}

pub(super) fn threads(text: &str) -> Result<NonZeroUsize, String> {
    let in_range = |n: &NonZeroUsize| n.get() <= MAX_THREADS;
    text.parse().ok().filter(in_range).ok_or_else(|| format!("must be from 1 to {MAX_THREADS}"))
}

/// A whole number from `low` to `high`.
pub(super) fn whole(low: u32, high: u32) -> impl TypedValueParser<Value = u32> {
    move |text: &str| {
        let found = text.parse().ok().filter(|number| (low..=high).contains(number));
        found.ok_or_else(|| format!("must be from {low} to {high}"))
    }
}

/// A difference of colours in 8-bit codes.
pub(super) fn codes(text: &str) -> Result<f64, &'static str> {
    text.parse().ok().filter(|codes| (0.0..=255.0).contains(codes)).ok_or("must be from 0 to 255")
}

fn tile_size(text: &str) -> Result<u32, &'static str> {
    let usable = |n: &u32| n.is_multiple_of(8) && (8..=1024).contains(n);
    text.parse().ok().filter(usable).ok_or("must be a multiple of 8 from 8 to 1024")
}

/// One of the values of a table, by name.
pub(super) fn named<T: Copy + Send + Sync + 'static>(
    names: &'static [(&'static str, T)],
) -> impl TypedValueParser<Value = T> {
    PossibleValuesParser::new(names.iter().map(|(name, _)| PossibleValue::new(*name))).try_map(move |text| {
        names.iter().find(|(name, _)| *name == text).map(|(_, value)| *value).ok_or("no such value")
    })
}

fn color() -> impl TypedValueParser<Value = ColorChoice> {
    let always = PossibleValue::new("truecolor").alias("always");
    let values = [PossibleValue::new("auto"), always, PossibleValue::new("256"), PossibleValue::new("never")];
    PossibleValuesParser::new(values)
        .try_map(|text| if text == "always" { Ok(ColorChoice::Truecolor) } else { text.parse() })
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    fn parse(line: &str) -> Result<Cli, String> {
        Cli::try_parse_from(line.split(' ')).map_err(|e| e.to_string())
    }

    #[test]
    fn the_flags_are_consistent() {
        Cli::command().debug_assert();
    }

    #[test]
    fn every_flag_changes_what_it_says() {
        let line = "glimt a.toml --size 64x48 --samples 3 --max-depth 0 --shading phong --shadows filtered \
                    --numerics fast --threads 5 --tile-size 16";
        let args = parse(&line.split_whitespace().collect::<Vec<_>>().join(" ")).unwrap().show;
        let mut desc = SceneDesc::default();
        args.scene.override_scene(&mut desc, args.time);
        assert_eq!((desc.film.width, desc.film.height), (64, 48));
        assert_eq!((desc.render.samples, desc.render.max_depth), (3, 0));
        assert_eq!((desc.render.shading, desc.render.shadows), (Shading::Phong, Shadows::Filtered));
        assert_eq!(desc.render.numerics, Numerics::Fast);
        assert_eq!((args.settings().threads.get(), args.settings().tile_size), (5, 16));
    }

    #[test]
    fn what_ends_a_render_is_what_the_flags_say_where_they_say_anything() {
        let ends = |flags: &str| {
            let mut desc = SceneDesc::default();
            (desc.render.samples, desc.render.error) = (9, Some(2.0));
            let args = parse(&format!("glimt{flags}")).unwrap().show;
            args.scene.override_scene(&mut desc, args.time);
            (desc.render.samples, desc.render.error)
        };
        assert_eq!(ends(""), (9, Some(2.0)));
        assert_eq!(ends(" --samples 5"), (5, None));
        assert_eq!(ends(" --error 0.5"), (limits::ADAPTIVE_SAMPLES, Some(0.5)));
        assert_eq!(ends(" --samples 64 --error 0.5"), (64, Some(0.5)));
        assert_eq!(ends(" --time 3"), (limits::MAX_SAMPLES, Some(0.0)));
        assert_eq!(ends(" --time 3 --samples 8"), (8, Some(0.0)));
    }

    #[test]
    fn the_interface_refines_to_half_a_code_where_nobody_says_an_end() {
        let ends = |flags: &str| {
            let mut desc = SceneDesc::default();
            let args = parse(&format!("glimt{flags}")).unwrap().show;
            args.scene.override_scene(&mut desc, args.time);
            args.end_usually(&mut desc);
            (desc.render.samples, desc.render.error)
        };
        assert_eq!(ends(" --max-depth 2"), (limits::ADAPTIVE_SAMPLES, Some(limits::USUAL_ERROR)));
        assert_eq!(ends(" --samples 5"), (5, None));
        assert_eq!(ends(" --error 3"), (limits::ADAPTIVE_SAMPLES, Some(3.0)));
        assert_eq!(ends(" --time 3"), (limits::MAX_SAMPLES, Some(0.0)));
        for (text, says) in [
            ("", false),
            ("[render]\nmax_depth = 3 # samples = 4", false),
            ("[render]\nsamples = 16", true),
            ("render = { error = 1 }", true),
            ("\u{feff}[render]\nerror = 2.0", true),
        ] {
            assert_eq!(crate::description::says_where_to_end(text), says, "{text}");
        }
    }

    #[test]
    fn no_flags_change_nothing() {
        let mut desc = SceneDesc::default();
        parse("glimt render a.toml").unwrap();
        parse("glimt").unwrap().show.scene.override_scene(&mut desc, None);
        assert_eq!(desc, SceneDesc::default());
    }

    #[test]
    fn values_out_of_range_are_refused_with_the_range() {
        for (flags, hint) in [
            ("--size 640", "1280x720"),
            ("--size 0x480", "from 1 to 32768"),
            ("--size 99999x1", "from 1 to 32768"),
            ("--size=-3x4", "from 1 to 32768"),
            ("--size -1x5", "from 1 to 32768"),
            ("--size 5x99999999999999999999", "from 1 to 32768"),
            ("--size 5x-", "1280x720"),
            ("--threads -1", "from 1 to 1024"),
            ("--samples -1", "from 1 to 1048576"),
            ("--max-depth -1", "from 0 to 64"),
            ("--threads 0", "from 1 to 1024"),
            ("--threads 99999999999999999999", "from 1 to 1024"),
            ("--samples 0", "from 1 to 1048576"),
            ("--error 0", "from 0.01 to 64"),
            ("--error NaN", "from 0.01 to 64"),
            ("--error -1", "from 0.01 to 64"),
            ("--time 0", "from 0.001 to 604800"),
            ("--time inf", "from 0.001 to 604800"),
            ("--filter lanczos", "box, tent"),
            ("--max-depth 65", "from 0 to 64"),
            ("--tile-size 12", "multiple of 8"),
            ("--shading gouraud", "lambert, phong, whitted"),
            ("--shadows soft", "opaque, filtered"),
            ("--numerics exact", "classic, fast, robust, reference"),
            ("--isa mmx", "no such instruction set; here there is portable"),
            ("--view heat", "normals, depth, uv, object"),
            ("--color sometimes", "auto, truecolor, 256, never"),
        ] {
            let message = parse(&format!("glimt {flags}")).unwrap_err();
            assert!(message.contains(hint), "{flags}: {message}");
        }
    }
}
