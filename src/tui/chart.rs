//! The error over time, as it is estimated: log-log, with the error to reach and when it will be.

use super::app::App;
use super::color::Role;
use super::layout::{Layout, Panel};
use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::symbols::Marker;
use ratatui::text::{Line, Span};
use ratatui::widgets::{Axis, Block, Chart, Clear, Dataset, GraphType, Widget};
use std::time::Duration;

/// Where the chart goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Place {
    /// On the screen.
    pub area: Rect,
    /// Whether nothing else is there.
    pub is_free: bool,
}

const ROWS: u16 = 13;
const COLUMNS: u16 = 42;
/// A panel at the side of so many rows has the chart below its numbers.
const TALL: u16 = 48;

/// Below the numbers in a tall panel at the side, else in the corner of the picture; `None` if the screen is too small.
pub fn place(layout: &Layout) -> Option<Place> {
    if let Some(Panel::Side(panel)) = layout.panel
        && panel.height >= TALL
    {
        let area = Rect { x: panel.x + 1, y: panel.bottom() - ROWS, width: panel.width - 1, height: ROWS };
        return Some(Place { area, is_free: true });
    }
    let preview = layout.preview;
    let (width, height) = (COLUMNS.min(preview.width), ROWS.min(preview.height));
    let area = Rect { x: preview.right() - width, y: preview.bottom() - height, width, height };
    (width >= 24 && height >= 7).then_some(Place { area, is_free: false })
}

/// Draws the chart over what is there.
pub fn draw(app: &App, buffer: &mut Buffer) {
    let (Some(place), mode) = (place(app.layout()), app.mode()) else { return };
    let area = place.area.intersection(buffer.area);
    Clear.render(area, buffer);
    let title = Line::from(vec![
        Span::styled(" Error ", mode.style(Role::Strong)),
        Span::styled("of 255, over time ", mode.style(Role::Dim)),
    ]);
    let block = Block::bordered().border_style(mode.style(Role::Dim)).title(title);
    let Some(numbers) = app.numbers().filter(|numbers| !numbers.error_history.is_empty()) else {
        let inner = block.inner(area);
        block.render(area, buffer);
        Line::styled("nothing can be said yet", mode.style(Role::Dim)).render(inner, buffer);
        return;
    };
    let log = |(time, error): (f64, f64)| (time.max(1e-3).log10(), error.max(1e-3).log10());
    let points: Vec<_> = numbers.error_history.iter().map(|point| log(*point)).collect();
    // The crossing is where the clock says that the time left ends: a line from the last point to either end of the
    // range.
    let last = points.last().copied().unwrap_or_default();
    let elapsed = numbers.elapsed.as_secs_f64();
    let forecast: Vec<_> = match (numbers.target, numbers.eta) {
        (Some(target), Some(eta)) if eta.high > Duration::ZERO => {
            let at = |left: Duration| log((elapsed + left.as_secs_f64(), target));
            vec![at(eta.low), last, at(eta.high)]
        }
        _ => Vec::new(),
    };
    let all = || points.iter().chain(&forecast);
    let target = numbers.target.map(|target| target.max(1e-3).log10());
    let ends = |values: &mut dyn Iterator<Item = f64>| {
        let (low, high) = values.fold((f64::MAX, f64::MIN), |(low, high), v| (low.min(v), high.max(v)));
        // A chart of no extent has no scale.
        [low - 0.05, high.max(low + 0.2) + 0.05]
    };
    let x = ends(&mut all().map(|point| point.0));
    let y = ends(&mut all().map(|point| point.1).chain(target));
    let aim: Vec<_> = target.map(|target| vec![(x[0], target), (x[1], target)]).unwrap_or_default();
    let set = |points, role| {
        let set = Dataset::default().data(points).graph_type(GraphType::Line).marker(Marker::Braille);
        set.style(mode.style(role))
    };
    let sets = vec![set(&aim, Role::Good), set(&forecast, Role::Dim), set(&points, Role::Bar)];
    let codes = |log: f64| format!("{:.2}", 10f64.powf(log));
    let axis = |bounds: [f64; 2], label: &dyn Fn(f64) -> String| {
        let labels = [bounds[0], (bounds[0] + bounds[1]) / 2.0, bounds[1]].map(label);
        Axis::default().bounds(bounds).labels(labels).style(mode.style(Role::Dim))
    };
    let chart = Chart::new(sets).block(block).x_axis(axis(x, &time)).y_axis(axis(y, &codes));
    chart.legend_position(None).render(area, buffer);
}

/// A time in seconds, given as its logarithm, in few characters.
fn time(log: f64) -> String {
    match 10f64.powf(log) {
        s if s < 10.0 => format!("{s:.2} s"),
        s if s < 100.0 => format!("{s:.0} s"),
        s if s < 6000.0 => format!("{:.0} min", s / 60.0),
        s => format!("{:.0} h", s / 3600.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tui::layout::{Parts, lay_out};

    #[test]
    fn the_chart_lies_on_the_screen_and_off_the_picture_where_there_is_room() {
        for (columns, rows) in [(80, 24), (200, 60), (30, 9), (24, 8), (10, 4), (0, 0)] {
            let layout = lay_out((columns, rows), (1280, 720), 2, Parts { editor: false, numbers: true });
            let Some(Place { area, is_free }) = place(&layout) else {
                assert!(columns < 40);
                continue;
            };
            assert_eq!(area.intersection(Rect::new(0, 0, columns, rows)), area);
            assert_eq!(is_free, area.intersection(layout.preview).is_empty());
            assert_eq!(is_free, columns == 200);
        }
    }
}
