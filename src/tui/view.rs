//! The screen as a function of the state.

use super::app::{Activity, App, Tone};
use super::chart;
use super::color::{ColorMode, Role};
use super::command::{BINDINGS, Command, key_of};
use super::panel;
use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::text::{Line, Span};
use ratatui::widgets::{Block, BorderType, Clear, Paragraph, Widget};

/// Draws everything.
pub fn view(app: &App, buffer: &mut Buffer) {
    let layout = app.layout();
    app.preview().paint(layout.preview.intersection(buffer.area), buffer, app.mode());
    if let Some(area) = layout.panel {
        panel::draw(app, area, buffer);
    }
    if app.shows_chart() {
        chart::draw(app, buffer);
    }
    status(app, layout.status, buffer);
    if app.shows_help() {
        help(app.mode(), buffer.area, buffer);
    }
}

/// Messages on the left, the keys that matter now on the right.
fn status(app: &App, area: Rect, buffer: &mut Buffer) {
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
    if app.is_zoomed() {
        left.push(Span::styled(format!("{:.1}× ", app.preview().zoom()), mode.style(Role::Strong)));
    }
    if let Some(message) = app.message() {
        let role = match message.tone {
            Tone::Plain => Role::Text,
            Tone::Good => Role::Good,
            Tone::Bad => Role::Bad,
        };
        left.push(Span::styled(message.text.clone(), mode.style(role)));
    }
    let left = Line::from(left);
    let mut room = usize::from(area.width).saturating_sub(left.width() + 2);
    let mut right = Vec::new();
    for (key, text) in hints(app) {
        let width = Span::raw(&key).width() + text.len() + 3;
        // The first that does not fit ends the list: the most useful ones come first.
        if width > room {
            break;
        }
        room -= width;
        right.push(Span::styled(key, mode.style(Role::Key)));
        right.push(Span::styled(format!(" {text}  "), mode.style(Role::Dim)));
    }
    left.render(area, buffer);
    Line::from(right).right_aligned().render(area, buffer);
}

/// The keys that matter now, the most useful first.
fn hints(app: &App) -> Vec<(String, &'static str)> {
    let hint = |command, text| (key_of(command), text);
    let mut hints = vec![hint(Command::ToggleHelp, if app.shows_help() { "close" } else { "keys" })];
    if app.is_zoomed() {
        hints.push(hint(Command::Fit, "whole picture"));
        hints.push(("←↓↑→".into(), "move"));
    }
    match app.activity() {
        Activity::Compiling | Activity::Failed => {}
        Activity::Rendering => hints.extend([hint(Command::TogglePause, "pause"), hint(Command::SaveImage, "save")]),
        Activity::Paused => hints.extend([hint(Command::TogglePause, "go on"), hint(Command::SaveImage, "save")]),
        Activity::Finished => hints.push(hint(Command::Samples(1), "more samples")),
    }
    if !app.is_zoomed() {
        hints.push(("←↓↑→".into(), "orbit"));
    }
    hints.insert(1, hint(Command::Quit, "quit"));
    hints
}

/// All keys, in a box over the rest: in two columns if they fit.
fn help(mode: ColorMode, room: Rect, buffer: &mut Buffer) {
    let mut names: Vec<&str> = BINDINGS.iter().map(|binding| binding.group).collect();
    names.dedup();
    // Every other group goes to the right, which makes the columns about as long.
    let column = |parity: usize| {
        let groups = names.iter().enumerate().filter(|(i, _)| i % 2 == parity).map(|(_, name)| *name);
        help_lines(mode, &groups.collect::<Vec<_>>())
    };
    let (left, right) = (column(0), column(1));
    let (left_width, right_width) = (widest(&left), widest(&right));
    let (width, height) = (left_width + right_width + 7, left.len().max(right.len()) as u16 + 2);
    let (columns, width, height) = if width <= room.width {
        (vec![left, right], width, height)
    } else {
        let all = help_lines(mode, &names);
        let (width, height) = (widest(&all) + 4, all.len() as u16 + 2);
        (vec![all], width, height)
    };
    let area = Rect {
        x: room.x + room.width.saturating_sub(width) / 2,
        y: room.y + room.height.saturating_sub(height) / 2,
        width: width.min(room.width),
        height: height.min(room.height),
    };
    Clear.render(area, buffer);
    let block = Block::bordered().border_type(BorderType::Rounded).border_style(mode.style(Role::Dim));
    let block = block.title(Line::styled(" Keys ", mode.style(Role::Strong)));
    let mut inner = block.inner(area);
    block.render(area, buffer);
    inner = Rect { x: inner.x + 1, width: inner.width.saturating_sub(2), ..inner };
    for lines in columns {
        let width = widest(&lines);
        Paragraph::new(lines).render(inner, buffer);
        inner = Rect { x: inner.x + width + 3, width: inner.width.saturating_sub(width + 3), ..inner };
    }
}

fn widest(lines: &[Line]) -> u16 {
    lines.iter().map(Line::width).max().unwrap_or(0) as u16
}

/// The groups with their keys, an empty line between two.
fn help_lines(mode: ColorMode, groups: &[&'static str]) -> Vec<Line<'static>> {
    let of = |group: &'static str| BINDINGS.iter().filter(move |binding| binding.group == group);
    let widths = groups.iter().flat_map(|group| of(group)).map(|binding| Span::raw(binding.keys_text()).width());
    let key_width = widths.max().unwrap_or(0);
    let mut lines = Vec::new();
    for group in groups {
        if !lines.is_empty() {
            lines.push(Line::default());
        }
        lines.push(Line::styled(*group, mode.style(Role::Strong)));
        for binding in of(group) {
            let keys = binding.keys_text();
            let gap = key_width - Span::raw(&keys).width();
            lines.push(Line::from(vec![
                Span::styled(keys, mode.style(Role::Key)),
                Span::raw(format!("{}  {}", " ".repeat(gap), binding.help_text())),
            ]));
        }
    }
    lines
}
