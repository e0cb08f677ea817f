//! The screen as a function of the state.

use super::app::{Activity, App, Tone};
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
    status(app, layout.status, buffer);
    if app.shows_help() {
        help(app.mode(), layout.preview.union(panel_area(app)), buffer);
    }
}

fn panel_area(app: &App) -> Rect {
    match app.layout().panel {
        Some(panel::Panel::Side(area) | panel::Panel::Below(area)) => area,
        None => app.layout().preview,
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

/// All keys, in a box over the picture.
fn help(mode: ColorMode, room: Rect, buffer: &mut Buffer) {
    let mut groups: Vec<(&str, Vec<(String, String)>)> = Vec::new();
    for binding in BINDINGS {
        if groups.last().is_none_or(|(name, _)| *name != binding.group) {
            groups.push((binding.group, Vec::new()));
        }
        if let Some((_, lines)) = groups.last_mut() {
            lines.push((binding.keys_text(), binding.help_text()));
        }
    }
    let key_width = groups.iter().flat_map(|(_, lines)| lines).map(|(keys, _)| Span::raw(keys).width());
    let key_width = key_width.max().unwrap_or(0);
    let mut lines = Vec::new();
    for (name, bindings) in groups {
        lines.push(Line::styled(name, mode.style(Role::Strong)));
        for (keys, text) in bindings {
            let gap = key_width - Span::raw(&keys).width();
            lines.push(Line::from(vec![
                Span::raw(" ".repeat(gap + 1)),
                Span::styled(keys, mode.style(Role::Key)),
                Span::raw(format!("  {text}")),
            ]));
        }
    }
    let width = lines.iter().map(Line::width).max().unwrap_or(0) as u16 + 4;
    let height = lines.len() as u16 + 2;
    let area = Rect {
        x: room.x + room.width.saturating_sub(width) / 2,
        y: room.y + room.height.saturating_sub(height) / 2,
        width: width.min(room.width),
        height: height.min(room.height),
    };
    Clear.render(area, buffer);
    let block = Block::bordered().border_type(BorderType::Rounded).border_style(mode.style(Role::Dim));
    let block = block.title(Line::styled(" Keys ", mode.style(Role::Strong)));
    let inner = block.inner(area);
    block.render(area, buffer);
    let inner = Rect { x: inner.x + 1, width: inner.width.saturating_sub(2), ..inner };
    Paragraph::new(lines).render(inner, buffer);
}
