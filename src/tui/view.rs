//! The screen as a function of the state.

use super::app::App;
use super::chart;
use super::color::{ColorMode, Role};
use super::dialog::{Dialog, MODELS, ROWS, accept_hints};
use super::widget::{fit, popup, rows};
use super::{legend, panel, side, status};
use crate::description::Target;
use crate::description::parameter::parameter;
use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::Color;
use ratatui::text::{Line, Span};
use ratatui::widgets::Widget;

/// Draws everything.
pub fn view(app: &App, buffer: &mut Buffer) {
    let layout = app.layout();
    app.preview().paint(layout.preview.intersection(buffer.area), buffer, app.mode());
    legend::draw(app, layout.preview.intersection(buffer.area), buffer);
    if let Some(at) = app.cursor() {
        cursor(app.mode(), layout.preview, at, buffer);
    }
    if let Some(area) = layout.panel {
        panel::draw(app, area, buffer);
    }
    if app.shows_chart() {
        chart::draw(app, buffer);
    }
    if let Some(area) = layout.editor {
        side::draw(app, area, buffer);
    }
    if let Some(mistakes) = app.broken_file() {
        broken(app.mode(), mistakes, layout.preview, buffer);
    }
    status::draw(app, layout.status, buffer);
    if let Some(open) = app.dialog() {
        // The last row stays: messages are told there.
        let room = Rect { height: buffer.area.height.saturating_sub(1), ..buffer.area };
        dialog(app, open, room, buffer);
    }
}

fn dialog(app: &App, dialog: &Dialog, room: Rect, buffer: &mut Buffer) {
    let (mode, keymap) = (app.mode(), app.keymap());
    match dialog {
        Dialog::Help(help) => help.draw(mode, keymap, buffer.area, buffer),
        Dialog::Rays(rays) => rays.draw(mode, keymap, room, buffer),
        Dialog::Adviser(adviser) => adviser.draw(mode, keymap, room, buffer),
        Dialog::Palette(palette) => palette.draw(mode, keymap, room, buffer),
        Dialog::Add(menu) => menu.draw(mode, keymap, room, buffer),
        Dialog::Prompt(prompt) => prompt.draw(mode, keymap, room, buffer),
        Dialog::Question(question) => question.draw(mode, keymap, room, buffer),
        Dialog::Model(files) => {
            let size = (room.width.saturating_sub(8).min(60), room.height.saturating_sub(4).min(20));
            let title = format!("Add a model ({})", MODELS.join(", "));
            let inner = popup(mode, room, &title, &accept_hints(keymap), size, buffer);
            files.draw(mode, inner, buffer);
        }
        Dialog::Color(color, targets, label) => {
            let owner = match targets.as_slice() {
                [one] => one.label(app.desc()),
                many => format!("{} materials", many.len()),
            };
            color.draw(mode, keymap, &format!("{label} of {owner}"), room, buffer);
        }
        Dialog::Texture(texture, materials) => {
            let value = |label: &&str| {
                let parameter = parameter(Target::Material(0), label)?;
                let value = parameter.get(app.desc(), materials)?;
                Some(parameter.show(app.desc(), materials.first().copied()?, &value))
            };
            texture.draw(mode, keymap, &ROWS.iter().map(value).collect::<Vec<_>>(), room, buffer);
        }
    }
}

/// What is wrong with the file on the disk, over the lower part of the last good picture.
fn broken(mode: ColorMode, mistakes: &[String], preview: Rect, buffer: &mut Buffer) {
    let height = (mistakes.len() as u16).min((preview.height / 2).saturating_sub(2));
    let width = mistakes.iter().map(|line| Span::raw(line.as_str()).width()).max().unwrap_or(0) as u16;
    if height == 0 {
        return;
    }
    let room = Rect { y: preview.bottom() - height - 2, height: height + 2, ..preview };
    let inner = popup(mode, room, "The file on the disk has mistakes", &[], (width, height), buffer);
    for (line, row) in mistakes.iter().zip(rows(inner)) {
        Line::styled(fit(line, row.width.into()), mode.style(Role::Text)).render(row, buffer);
    }
}

/// The pixel that is pointed at, in a colour that no scene has much of.
fn cursor(mode: ColorMode, preview: Rect, (x, y): (usize, usize), buffer: &mut Buffer) {
    const HERE: [u8; 3] = [255, 0, 200];
    let at = (preview.x + x as u16, preview.y + (y / 2) as u16);
    let Some(cell) = buffer.cell_mut(at) else { return };
    if mode == ColorMode::None {
        cell.set_symbol("+").set_style(mode.style(Role::Bad));
        return;
    }
    let (upper, lower): (Color, Color) = (cell.fg, cell.bg);
    // Not the upper half block that pictures are made of: this is text, which is sent before them.
    let (upper, lower) = if y % 2 == 0 { (mode.color(HERE), lower) } else { (upper, mode.color(HERE)) };
    cell.set_symbol("▄").set_fg(lower).set_bg(upper);
}
