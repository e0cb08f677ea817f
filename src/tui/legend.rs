//! What the colours of a view stand for, in the lower left corner of the picture.

use super::app::App;
use super::color::{ColorMode, Role};
use super::widget::fit;
use crate::description::{Target, printable};
use crate::render::{View, index_color, viridis};
use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::Style;
use ratatui::text::{Line, Span};
use ratatui::widgets::{Clear, Widget};

/// Columns of the bar of colours.
const BAR: usize = 16;
/// Columns of a name.
const NAME: usize = 24;

/// Draws the legend, unless light is shown.
pub fn draw(app: &App, area: Rect, buffer: &mut Buffer) {
    let lines = lines(app, usize::from(area.height / 2));
    let height = (lines.len() as u16).min(area.height);
    for (line, y) in lines.into_iter().zip(area.bottom() - height..) {
        let width = (line.width() as u16).min(area.width);
        let row = Rect { y, height: 1, width, ..area };
        Clear.render(row, buffer);
        line.render(row, buffer);
    }
}

fn lines(app: &App, most: usize) -> Vec<Line<'static>> {
    let (mode, shown) = (app.mode(), app.shown());
    let view = shown.view();
    let title = Span::styled(format!(" {} ", view.name()), mode.style(Role::Strong));
    let text = |text: String| Span::styled(text, mode.style(Role::Text));
    match view {
        View::Final => Vec::new(),
        View::Normals => vec![Line::from(vec![title, text("x red, y green, z blue, dark -1 to light 1 ".into())])],
        View::Uv => vec![Line::from(vec![title, text("u red, v green, 0 to 1 ".into())])],
        View::Object | View::Material => {
            let mut lines = vec![Line::from(title)];
            let room = most.saturating_sub(1).max(1);
            let listed = if shown.seen().len() <= room { room } else { room - 1 };
            for number in shown.seen().iter().take(listed) {
                let swatch = Span::styled(" ██ ", swatch(mode, index_color(*number)));
                let name = fit(&name(app, view, *number as usize - 1), NAME);
                lines.push(Line::from(vec![swatch, text(format!("{number} {name} "))]));
            }
            if listed < shown.seen().len() {
                lines.push(Line::styled(format!(" and {} more ", shown.seen().len() - listed), mode.style(Role::Dim)));
            }
            lines
        }
        View::NonFinite => {
            let pixels = shown.seen().len();
            let samples: u64 = shown.seen().iter().map(|samples| u64::from(*samples)).sum();
            vec![Line::from(vec![title, text(format!("{samples} samples in {pixels} pixels "))])]
        }
        View::Depth | View::Samples | View::Rays | View::Visits | View::Time | View::Error => {
            let scale = shown.scale();
            let mut spans = vec![title, text(format!("{} ", number(scale.low)))];
            if mode == ColorMode::None {
                spans.push(text("dark to light".into()));
            } else {
                let part = |column: usize| column as f32 / (BAR - 1) as f32;
                spans.extend((0..BAR).map(|column| Span::styled("█", swatch(mode, viridis(part(column))))));
            }
            let steps = if scale.is_log { ", in factors" } else { "" };
            spans.push(text(format!(" {} {}{steps} ", number(scale.high), view.unit().unwrap_or(""))));
            vec![Line::from(spans)]
        }
    }
}

fn swatch(mode: ColorMode, codes: [f32; 3]) -> Style {
    Style::new().fg(mode.color(codes.map(|code| (code * 255.0).round() as u8)))
}

/// What the number `index`, from 0, of the view is called.
fn name(app: &App, view: View, index: usize) -> String {
    let desc = app.desc();
    match view {
        View::Object => Target::Object(index).label(desc),
        _ => match desc.materials.get(index) {
            Some(material) => printable(&material.name).into_owned(),
            None if index == desc.materials.len() => "the default".into(),
            None => "of a model".into(),
        },
    }
}

fn number(x: f32) -> String {
    // Scales end at round numbers, up to rounding.
    let text = format!("{x:.3}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}
