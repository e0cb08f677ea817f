//! Charts made of characters.

use super::axis::{Fitted, Side};
use super::{Chart, Data, PALETTE, Point};
use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::{Color, Style};
use ratatui::symbols::Marker;
use ratatui::text::Line;
use ratatui::widgets::Widget;
use ratatui::widgets::canvas::{Canvas, Context, Line as Stroke};
use std::fmt::Write;

/// How a chart is shown in a terminal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TerminalStyle {
    /// Columns.
    pub width: u16,
    /// Lines.
    pub height: u16,
    /// Whether escape sequences of colours are sent.
    pub color: bool,
}

/// Signs of the series, in the order of their colours.
const SIGNS: [&str; 6] = ["●", "■", "▲", "◆", "▼", "✚"];
const GREY: Color = Color::Indexed(244);
const RED: Color = Color::Indexed(160);

impl Chart {
    /// The chart as lines of characters. It is made larger if `style` leaves no room for it.
    pub fn to_terminal(&self, style: TerminalStyle) -> String {
        let (x, y) = (Fitted::new(self, Side::X), Fitted::new(self, Side::Y));
        let legend = self.legend(style.width.max(40));
        let label_width = y.ticks.iter().map(|(_, label)| label.chars().count()).max().unwrap_or(0) as u16;
        let area = Rect::new(0, 0, style.width.max(40), style.height.max(12 + legend.len() as u16));
        let mut buffer = Buffer::empty(area);
        let top = 1 + legend.len() as u16;
        let plot = Rect::new(label_width + 1, top + 1, area.width - label_width - 2, area.height - top - 4);
        buffer.set_string(0, 0, &self.title, Style::new());
        for (row, entries) in (1..).zip(&legend) {
            let mut column = 0;
            for (index, entry) in entries {
                buffer.set_string(column, row, entry, Style::new().fg(color(*index)));
                column += entry.chars().count() as u16 + 3;
            }
        }
        buffer.set_string(0, top, &self.y.label, Style::new().fg(GREY));
        let lanes = self.series.iter().any(|series| matches!(series.data, Data::Spans(_)));
        let view = View { x, y, lanes };
        self.canvas(&view).render(plot, &mut buffer);
        view.label(plot, &mut buffer);
        let below = area.height - 1;
        let column = (plot.x + plot.width / 2).saturating_sub(self.x.label.chars().count() as u16 / 2);
        buffer.set_string(column, below, &self.x.label, Style::new().fg(GREY));
        written(&buffer, style.color)
    }

    /// Rows of entries with the index of their series.
    fn legend(&self, width: u16) -> Vec<Vec<(usize, String)>> {
        let mut rows: Vec<Vec<(usize, String)>> = Vec::new();
        let mut room = 0;
        for (index, series) in self.series.iter().enumerate().filter(|(_, series)| !series.name.is_empty()) {
            let sign = match series.data {
                Data::Points(_) | Data::Line(_) => SIGNS[index % SIGNS.len()],
                Data::Guide(_) => "─",
                Data::Columns(_) | Data::Spans(_) => "█",
            };
            let entry = format!("{sign} {}", series.name);
            let needed = entry.chars().count() + 3;
            if needed > room {
                rows.push(Vec::new());
                room = usize::from(width) + 3;
            }
            room = room.saturating_sub(needed);
            if let Some(row) = rows.last_mut() {
                row.push((index, entry));
            }
        }
        rows
    }

    /// Everything inside the frame, in a square of side 1.
    fn canvas<'a>(&'a self, view: &'a View) -> Canvas<'a, impl Fn(&mut Context<'_>) + 'a> {
        let columns = self.series.iter().filter(|series| matches!(series.data, Data::Columns(_))).count();
        Canvas::default().marker(Marker::Braille).x_bounds([0.0, 1.0]).y_bounds([0.0, 1.0]).paint(move |context| {
            let mut stroke = |from: (f64, f64), to: (f64, f64), color| {
                context.draw(&Stroke::new(from.0, from.1, to.0, to.1, color));
            };
            stroke((0.0, 0.0), (1.0, 0.0), GREY);
            stroke((0.0, 0.0), (0.0, 1.0), GREY);
            for limit in &self.limits {
                let y = view.y.place(limit.y);
                (0..40).for_each(|i| stroke((f64::from(i) / 40.0, y), (f64::from(i) / 40.0 + 0.012, y), RED));
            }
            let mut column = 0;
            for (index, series) in self.series.iter().enumerate() {
                let color = color(index);
                let mut path = |points: Vec<(f64, f64)>| {
                    points.windows(2).for_each(|pair| stroke(pair[0], pair[1], color));
                };
                match &series.data {
                    Data::Guide(line) => path(line.iter().map(|p| view.at(p.0, p.1)).collect()),
                    Data::Line(points) => path(points.iter().map(|p| view.at(p.x, p.y)).collect()),
                    Data::Points(_) => {}
                    Data::Columns(points) => {
                        let width = 0.8 / columns as f64;
                        let shift = (f64::from(column) - columns as f64 / 2.0) * width;
                        for p in points {
                            for part in 1..16 {
                                let (x, y) = view.at(p.x + shift + width * f64::from(part) / 16.0, p.y);
                                stroke((x, 0.0), (x, y), color);
                            }
                        }
                        column += 1;
                    }
                    Data::Spans(spans) => {
                        let half = (view.y.place(1.0) - view.y.place(0.0)) * 0.35;
                        for span in spans {
                            let (from, y) = view.at(span.from, span.lane as f64);
                            let to = view.x.place(span.to);
                            (-4..=4).for_each(|i| {
                                let y = y + half * f64::from(i) / 4.0;
                                stroke((from, y), (to, y), color);
                            });
                        }
                    }
                }
            }
            context.layer();
            for (index, series) in self.series.iter().enumerate() {
                if let Data::Line(points) | Data::Points(points) = &series.data {
                    for Point { x, y, .. } in points.iter().filter(|p| p.x.is_finite() && p.y.is_finite()) {
                        let (x, y) = view.at(*x, *y);
                        context.print(x, y, Line::styled(SIGNS[index % SIGNS.len()], color(index)));
                    }
                }
            }
        })
    }
}

fn color(index: usize) -> Color {
    Color::Indexed(PALETTE[index % PALETTE.len()].1)
}

struct View {
    x: Fitted,
    y: Fitted,
    lanes: bool,
}

impl View {
    fn at(&self, x: f64, y: f64) -> (f64, f64) {
        let up = self.y.place(y);
        (self.x.place(x), if self.lanes { 1.0 - up } else { up })
    }

    /// Writes the labels of ticks beside and below the frame, as many as fit.
    fn label(&self, plot: Rect, buffer: &mut Buffer) {
        let grey = Style::new().fg(GREY);
        let mut last = u16::MAX;
        for (value, label) in &self.y.ticks {
            let up = self.at(0.0, *value).1;
            let row = plot.y + ((1.0 - up) * f64::from(plot.height - 1)).round() as u16;
            if row.abs_diff(last) >= 1 {
                let column = (plot.x - 1).saturating_sub(label.chars().count() as u16);
                buffer.set_string(column, row, label, grey);
                last = row;
            }
        }
        let mut free = 0;
        for (value, label) in &self.x.ticks {
            let width = label.chars().count() as u16;
            let column = plot.x + (self.x.place(*value) * f64::from(plot.width - 1)).round() as u16;
            let column = column.saturating_sub(width / 2);
            if column >= free && column + width <= buffer.area.width {
                buffer.set_string(column, plot.bottom(), label, grey);
                free = column + width + 1;
            }
        }
    }
}

/// The lines of a buffer, without blanks at their ends.
fn written(buffer: &Buffer, colored: bool) -> String {
    let mut text = String::new();
    for row in buffer.area.rows() {
        let mut line = String::new();
        let mut last = Color::Reset;
        let mut cells: Vec<_> = row.columns().map(|place| &buffer[(place.x, place.y)]).collect();
        while cells.last().is_some_and(|cell| cell.symbol() == " ") {
            cells.pop();
        }
        for cell in cells {
            if colored && cell.fg != last {
                let _ = match cell.fg {
                    Color::Indexed(index) => write!(line, "\x1b[38;5;{index}m"),
                    _ => write!(line, "\x1b[39m"),
                };
                last = cell.fg;
            }
            line += cell.symbol();
        }
        if last != Color::Reset {
            line += "\x1b[39m";
        }
        let _ = writeln!(text, "{line}");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::super::tests::example;
    use super::*;

    #[test]
    fn every_size_holds_title_labels_and_signs_and_no_colours_unless_asked() {
        for (width, height) in [(1, 1), (60, 20), (200, 60)] {
            let text = example().to_terminal(TerminalStyle { width, height, color: false });
            for part in ["Error against", "time (s)", "error (codes)", "● first", "●", "■", "0.5", "10"] {
                assert!(text.contains(part), "{part} at {width}x{height}:\n{text}");
            }
            assert!(!text.contains('\x1b'));
            assert!(text.lines().all(|line| line.chars().count() <= usize::from(width.max(40))));
        }
        let text = example().to_terminal(TerminalStyle { width: 80, height: 24, color: true });
        assert!(
            text.contains("\x1b[38;5;32m")
                && text.lines().all(|line| !line.contains('\x1b') || line.ends_with("\x1b[39m"))
        );
    }
}
