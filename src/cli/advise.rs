//! `glimt advise`: what a scene pays for and does not need.

use super::args::AdviseArgs;
use super::open::Opened;
use super::{Failure, print, say};
use crate::advice::{self, Advice, advise};
use crate::description::{SceneDesc, printable};
use crate::headless::Signals;
use crate::render::{Settings, default_threads};
use serde_json::json;
use std::process::ExitCode;

/// Measures and prints.
pub fn run(args: &AdviseArgs) -> Result<ExitCode, Failure> {
    let signals = Signals::listen().map_err(Failure::could_not)?;
    let opened = Opened::new(args.scene.as_deref(), None, args.isa.chosen()?)?;
    let scene = opened.compile()?;
    let settings = Settings { threads: args.threads.unwrap_or_else(default_threads), ..Settings::default() };
    let found = advise(&opened.desc, &scene, settings, &|| signals.caught().is_some());
    let found = found.map_err(|failure| match (failure, signals.caught()) {
        (advice::Failure::Compile(error), _) => opened.locate(error),
        (failure, Some(number)) => Failure::Signal { number, message: failure.to_string() },
        (failure, None) => Failure::could_not(failure),
    })?;
    let desc = &opened.desc;
    if args.json {
        let all: Vec<_> = found.iter().map(|advice| one(desc, advice)).collect();
        print(json!({ "scene": opened.file.to_string_lossy(), "advice": all }))?;
    } else if found.is_empty() {
        print(format_args!("{}: needs all that it pays for", printable(&opened.file.to_string_lossy())))?;
    } else {
        let lines: Vec<_> = found.iter().map(|advice| line(desc, advice)).collect();
        print(lines.join("\n"))?;
        say("saved: parts of rays and time; error: root mean square and largest change in 8-bit codes");
    }
    Ok(ExitCode::SUCCESS)
}

fn one(desc: &SceneDesc, advice: &Advice) -> serde_json::Value {
    json!({
        "change": advice.change.text(desc),
        "reason": advice.reason,
        "rays_saved": advice.rays,
        "time_saved": advice.time,
        "rmse": advice.rmse,
        "largest": advice.largest,
    })
}

fn line(desc: &SceneDesc, advice: &Advice) -> String {
    format!(
        "{}: {}\n    saves {:.0} % of the rays, {:.0} % of the time; error {:.2}, at most {:.1}",
        advice.change.text(desc),
        advice.reason,
        100.0 * advice.rays,
        100.0 * advice.time,
        advice.rmse,
        advice.largest
    )
}
