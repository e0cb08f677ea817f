//! The last row: what is going on, the last message, and the keys that matter now.

use super::app::{Activity, App, Focus, Message, Tone};
use super::color::Role;
use super::command::{Command, Motion, Scope};
use super::format::time;
use super::widget::hint_line;
use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::text::{Line, Span};
use ratatui::widgets::Widget;

/// Messages on the left, the keys that matter now on the right.
pub fn draw(app: &App, area: Rect, buffer: &mut Buffer) {
    let mode = app.mode();
    let percent = format!("{:>3} % ", app.percent());
    let (word, role) = match app.activity() {
        Activity::Compiling => ("loading", Role::Key),
        Activity::Rendering => ("rendering", Role::Key),
        Activity::Paused => ("paused", Role::Strong),
        Activity::Finished => ("finished", Role::Good),
        Activity::Failed => ("failed", Role::Bad),
    };
    let mut left = vec![Span::styled(format!(" {word:<9} "), mode.style(role))];
    // Elsewhere the panel shows it.
    if app.layout().panel.is_none() && app.activity() != Activity::Finished {
        left.push(Span::raw(percent));
    }
    // Elsewhere the title shows it.
    if app.layout().editor.is_none() && app.editor().history().is_unsaved() {
        left.push(Span::styled("● ", mode.style(Role::Mark)));
    }
    if app.is_zoomed() {
        left.push(Span::styled(format!("{:.1}× ", app.preview().zoom()), mode.style(Role::Strong)));
    }
    let told = |message: &Message| {
        let role = match message.tone {
            Tone::Plain => Role::Text,
            Tone::Good => Role::Good,
            Tone::Bad => Role::Bad,
        };
        Span::styled(format!("{}  ", message.text), mode.style(role))
    };
    if let Some(message) = app.message() {
        left.extend([message].into_iter().chain(app.note()).map(told));
    } else if let Some(transform) = app.transform() {
        left.push(Span::styled(transform.text(), mode.style(Role::Strong)));
    } else if let Some(note) = app.note() {
        left.push(told(note));
    } else if app.broken_file().is_some() {
        left.push(Span::styled("the file on the disk has mistakes", mode.style(Role::Bad)));
    } else if let Some(latency) = app.latency() {
        left.push(Span::styled(format!("edit {}", time(latency).trim_start()), mode.style(Role::Dim)));
    }
    let left = Line::from(left);
    let room = usize::from(area.width).saturating_sub(left.width() + 1);
    let right = hint_line(mode, &hints(app), room);
    left.render(area, buffer);
    right.right_aligned().render(area, buffer);
}

/// The keys that matter now, the most useful first.
fn hints(app: &App) -> Vec<(String, &'static str)> {
    let keys = app.keymap();
    let any = |command, text| (keys.key_of(command), text);
    let scope = app.scope();
    let here = |command, text| (keys.key_in(scope, command), text);
    match scope {
        // The box tells its own.
        Scope::Dialog if app.dialog().is_some() => Vec::new(),
        Scope::Dialog => vec![here(Command::Accept, "take"), here(Command::Cancel, "back")],
        Scope::Transform => vec![
            here(Command::Accept, "keep"),
            here(Command::Cancel, "take back"),
            ("x y z".into(), "axis"),
            ("←↓↑→".into(), "nudge"),
            ("0-9".into(), "type"),
        ],
        Scope::Pick => vec![
            here(Command::Accept, "select"),
            here(Command::Mark, "add"),
            here(Command::Explain, "why"),
            here(Command::Cancel, "end"),
            ("←↓↑→".into(), "move"),
        ],
        Scope::Tree if app.editor().tree.is_folded_here(app.desc()) => vec![
            any(Command::ToggleHelp, "keys"),
            here(Command::Turn(1), "open the group"),
            any(Command::Filter, "search"),
            any(Command::Focus(1), "properties"),
        ],
        Scope::Tree => vec![
            any(Command::ToggleHelp, "keys"),
            any(Command::Transform(Motion::Move), "move"),
            any(Command::Add, "add"),
            here(Command::Mark, "mark"),
            any(Command::Filter, "search"),
            any(Command::Focus(1), "properties"),
        ],
        Scope::Properties => vec![
            any(Command::ToggleHelp, "keys"),
            ("←→".into(), "turn"),
            here(Command::Accept, "type"),
            here(Command::Reset, "default"),
            any(Command::Undo, "undo"),
            any(Command::Focus(1), "picture"),
        ],
        _ => picture_hints(app),
    }
}

fn picture_hints(app: &App) -> Vec<(String, &'static str)> {
    let hint = |command, text| (app.keymap().key_of(command), text);
    let pause = (app.keymap().key_in(Scope::Picture, Command::TogglePause), "pause");
    let mut hints = vec![hint(Command::ToggleHelp, "keys"), hint(Command::Quit, "quit")];
    if app.is_zoomed() {
        hints.push(hint(Command::Fit, "whole picture"));
        hints.push(("←↓↑→".into(), "move"));
    }
    match app.activity() {
        Activity::Compiling | Activity::Failed => {}
        Activity::Rendering => hints.push(pause),
        Activity::Paused => hints.push((pause.0, "go on")),
        Activity::Finished => hints.push(hint(Command::Samples(1), "more samples")),
    }
    hints.push(hint(Command::Focus(1), if app.focus() == Focus::Picture { "edit" } else { "picture" }));
    if !app.is_zoomed() {
        hints.push(("←↓↑→".into(), "orbit"));
    }
    hints
}
