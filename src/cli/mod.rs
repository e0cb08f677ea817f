//! Commands: from arguments to an exit code. Everything that can go wrong is told on stderr in plain words.

mod advise;
mod args;
mod check;
mod compare;
mod explain;
mod failure;
mod latency;
mod model_scene;
mod open;
mod overhead;
mod stability;
mod study;

use crate::description::{FilmDesc, printable};
use crate::headless::{self, Report, Seconds, TooLarge, Unfinished, check_memory};
use crate::output::{check_target, save_png};
use crate::scene::MOST_BODIES;
use crate::tui;
use args::{CheckArgs, Cli, Command, KeysArgs, RenderArgs};
use check::Inventory;
use clap::Parser;
use clap::error::{ContextKind, ErrorKind};
use failure::Failure;
use open::Opened;
use std::ffi::OsString;
use std::fmt::Display;
use std::io::{self, IsTerminal, Write};
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;
use std::time::Instant;
use tui::ColorChoice;

/// Runs the program with these arguments (the first is its own name).
pub fn run(arguments: impl IntoIterator<Item = OsString>) -> ExitCode {
    let begun = Instant::now();
    let cli = match Cli::try_parse_from(arguments) {
        Ok(cli) => cli,
        Err(help_or_mistake) => return answer(&help_or_mistake),
    };
    let (color, done) = match &cli.command {
        Some(Command::Render(args)) => (args.color.color, render(args, begun)),
        Some(Command::Check(args)) => (args.color.color, check(args)),
        Some(Command::Advise(args)) => (args.color.color, advise::run(args)),
        Some(Command::Explain(args)) => (args.color.color, explain::explain(args)),
        Some(Command::Keys(args)) => (args.color.color, keys(args)),
        Some(Command::Compare(args)) => (args.color.color, compare::compare(args)),
        Some(Command::Study(command)) => (command.color(), study::run(command)),
        None => (cli.show.color.color, show(&cli.show, begun)),
    };
    match done {
        Ok(code) => code,
        Err(failure) => {
            say(failure.render(colored_stderr(color)));
            ExitCode::from(failure.exit_code())
        }
    }
}

/// Help and version on stdout, mistakes in the arguments on stderr.
fn answer(from_clap: &clap::Error) -> ExitCode {
    let text = match from_clap.kind() {
        ErrorKind::ArgumentConflict => match from_clap.get(ContextKind::InvalidArg) {
            Some(twice) => format!("error: {twice} is given twice; give it once"),
            // Clap takes the second of two scenes for a command.
            None => {
                "error: there can be one scene, and a command (such as render) stands before all options".to_owned()
            }
        },
        _ => from_clap.render().to_string(),
    };
    let safe: Vec<_> = text.trim_end().lines().map(printable).collect();
    let safe = safe.join("\n");
    if from_clap.use_stderr() {
        say(safe);
        return ExitCode::from(2);
    }
    match print(safe) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => ExitCode::from(failure.exit_code()),
    }
}

/// `glimt [SCENE]`: the interface, or without a terminal the same as `render`.
fn show(args: &RenderArgs, begun: Instant) -> Result<ExitCode, Failure> {
    if args.json || args.quiet || !terminal_to_draw_on() {
        if !args.json && !args.quiet {
            say("no terminal to draw on: rendering to a file instead (glimt render does the same)");
        }
        return render(args, begun);
    }
    let keymap = tui::keymap::load().map_err(Failure::Asked)?;
    let (mut opened, output) = open(args)?;
    if !opened.says_where_to_end() {
        args.end_usually(&mut opened.desc);
    }
    let options = tui::Options {
        source: opened.source(),
        directory: opened.directory(),
        keymap,
        scene_name: opened.name().to_string_lossy().into_owned(),
        desc: opened.desc.clone(),
        compiled: opened.compiled.take().map(Arc::new),
        output,
        threads: args.settings().threads,
        time: args.time,
        isa: opened.isa,
        color: args.color.color,
        view: args.view,
    };
    let outcome = tui::run(options).map_err(|error| match error {
        tui::Error::Compile(error) => opened.locate(error),
        other => Failure::could_not(other),
    })?;
    if !outcome.line.is_empty() {
        say(outcome.line);
    }
    Ok(ExitCode::from(outcome.exit_code))
}

/// `glimt render`
fn render(args: &RenderArgs, begun: Instant) -> Result<ExitCode, Failure> {
    let (opened, output) = open(args)?;
    let scene = Arc::new(opened.compile()?);
    if !args.quiet {
        for warning in &scene.summary.warnings {
            say(format_args!("warning: {}", printable(warning)));
        }
    }
    let settings = args.settings();
    let rendered = headless::render(Arc::clone(&scene), args.view, settings, args.time, args.quiet).map_err(
        |error| match error {
            Unfinished::Signal { number, .. } => Failure::Signal { number, message: error.to_string() },
            other => Failure::could_not(other),
        },
    )?;
    let saving = Instant::now();
    save_png(&rendered.film, &output).map_err(Failure::could_not)?;
    let seconds = Seconds {
        load: (opened.load_time + scene.summary.load_time).as_secs_f64(),
        build: (opened.build_time + scene.summary.build_time).as_secs_f64(),
        first_picture: rendered.first_picture.as_secs_f64(),
        trace: rendered.time.as_secs_f64(),
        save: saving.elapsed().as_secs_f64(),
        total: begun.elapsed().as_secs_f64(),
    };
    let mut report = Report::new(&scene, &rendered, settings, (args.view, args.time), &opened.file, &output, seconds);
    report.explain = rendered.progress.first_non_finite.map(|pixel| args.scene.explain_command(pixel));
    if !args.quiet {
        if report.non_finite > 0 {
            let samples = if report.non_finite == 1 { "sample was" } else { "samples were" };
            let look = report.explain.as_deref().map_or(String::new(), |look| format!("; see {}", printable(look)));
            say(format_args!("warning: {} {samples} not finite and left out{look}", report.non_finite));
        }
        if report.overfull_media > 0 {
            let samples = if report.overfull_media == 1 { "sample" } else { "samples" };
            say(format_args!(
                "warning: in {} {samples} a ray was inside of more than {MOST_BODIES} transparent bodies at once; what it entered \
                 beyond was passed over",
                report.overfull_media
            ));
        }
        say(&report);
        if let (Some([low, high]), Some(unit)) = (report.scale, args.view.unit()) {
            say(format_args!("{} from {low} (first colour) to {high} {unit} (last)", args.view.name()));
        }
    }
    if args.json {
        let json = serde_json::to_string(&report).map_err(Failure::could_not)?;
        write_out(json)
            .map_err(|error| Failure::CouldNot(format!("the picture is saved, but not its report: {error}")))?;
    }
    Ok(ExitCode::SUCCESS)
}

/// `glimt check`
fn check(args: &CheckArgs) -> Result<ExitCode, Failure> {
    let opened = Opened::new(args.scene.as_deref(), None, args.isa.chosen()?)?;
    let scene = opened.compile()?;
    print(Inventory { opened: &opened, scene: &scene }.to_string().trim_end())?;
    Ok(ExitCode::SUCCESS)
}

/// `glimt keys`
fn keys(args: &KeysArgs) -> Result<ExitCode, Failure> {
    let keymap = tui::keymap::load().map_err(Failure::Asked)?;
    if args.markdown {
        print(keymap.markdown().trim_end())?;
        return Ok(ExitCode::SUCCESS);
    }
    let file = tui::keymap::file().map(|file| file.to_string_lossy().into_owned());
    let place =
        file.map(|file| format!("\nOther keys: {} (for example: undo = [\"u\", \"Ctrl-U\"])", printable(&file)));
    print(format_args!("{}{}", keymap.table(), place.unwrap_or_default()))?;
    Ok(ExitCode::SUCCESS)
}

/// The scene with the flags put into it, and where its picture goes. A path that cannot be written to and a
/// picture that is too large are found before the work, not after it.
fn open(args: &RenderArgs) -> Result<(Opened, PathBuf), Failure> {
    let opened = args.scene.open(args.time)?;
    let output = args.output.clone().unwrap_or_else(|| opened.default_output(args.view));
    if output.as_os_str() == "-" {
        let advice = "name a file such as picture.png";
        return Err(Failure::Asked(format!("pictures are not written to standard output; {advice}")));
    }
    if output.extension().is_some_and(|ending| !ending.eq_ignore_ascii_case("png")) {
        let name = output.to_string_lossy().into_owned();
        return Err(Failure::Asked(format!("cannot write {name}: glimt writes PNG; end the name with .png")));
    }
    check_target(&output).map_err(Failure::asked)?;
    let FilmDesc { width, height } = opened.desc.film;
    check_memory(width, height).map_err(|TooLarge { needed, available }| {
        let gigabytes = |bytes: u64| bytes as f64 / 1e9;
        Failure::CouldNot(format!(
            "a picture of {width}x{height} needs {:.1} GB of memory, and {:.1} GB are free; ask for a smaller --size",
            gigabytes(needed),
            gigabytes(available)
        ))
    })?;
    Ok((opened, output))
}

/// Whether the interface can run here.
fn terminal_to_draw_on() -> bool {
    let dumb = std::env::var_os("TERM").is_some_and(|term| term == "dumb");
    io::stdin().is_terminal() && io::stdout().is_terminal() && !dumb
}

/// Whether errors are coloured.
fn colored_stderr(choice: ColorChoice) -> bool {
    let unset = |name| std::env::var_os(name).is_none_or(|value| value.is_empty());
    match choice {
        ColorChoice::Auto => io::stderr().is_terminal() && unset("NO_COLOR"),
        ColorChoice::Truecolor | ColorChoice::Indexed => true,
        ColorChoice::Never => false,
    }
}

/// A line on stderr. Who closed it does not want to know.
fn say(line: impl Display) {
    let _ = writeln!(io::stderr(), "{line}");
}

/// Lines on stdout. A reader that went away, as `head` does, has read enough.
fn print(text: impl Display) -> Result<(), Failure> {
    match write_out(text) {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => {
            Err(Failure::CouldNot(format!("cannot write to standard output: {error}")))
        }
        _ => Ok(()),
    }
}

/// Lines on stdout.
fn write_out(text: impl Display) -> io::Result<()> {
    let mut stdout = io::stdout().lock();
    writeln!(stdout, "{text}").and_then(|()| stdout.flush())
}
