//! The colour dialog: sliders of red, green, blue and of hue, saturation, value; a code; palettes; a swatch.

use super::prompt::accept_hints;
use crate::description::parse_color;
use crate::math::{Rgb, linear_to_srgb8, srgb8_to_linear};
use crate::tui::color::{ColorMode, Role};
use crate::tui::command::Command;
use crate::tui::field::Field;
use crate::tui::key::{Code, Key};
use crate::tui::keymap::Keymap;
use crate::tui::widget::popup;
use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::Style;
use ratatui::text::{Line, Span};
use ratatui::widgets::Widget;

/// A colour being chosen, as sRGB codes.
#[derive(Clone, Debug)]
pub struct ColorDialog {
    /// Hue in degrees, saturation and value in percent: kept beside the codes, which forget the hue of a grey.
    hsv: [f64; 3],
    codes: [u8; 3],
    row: Row,
    code: Field,
    recent: Vec<[u8; 3]>,
    /// Which of the named and of the recent ones.
    swatch: usize,
}

/// What has the keys.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Row {
    /// Red, green, blue, hue, saturation, value.
    Slider(usize),
    Code,
    Named,
    Recent,
}

const SLIDERS: [(&str, f64); 6] =
    [("red", 255.0), ("green", 255.0), ("blue", 255.0), ("hue", 360.0), ("saturation", 100.0), ("value", 100.0)];

/// Names of the palette, all of CSS.
pub const NAMED: [&str; 20] = [
    "white",
    "silver",
    "gray",
    "black",
    "maroon",
    "firebrick",
    "tomato",
    "coral",
    "orange",
    "gold",
    "khaki",
    "olive",
    "seagreen",
    "limegreen",
    "turquoise",
    "steelblue",
    "royalblue",
    "navy",
    "indigo",
    "orchid",
];

/// A colour that is already linear, as what it looks like.
pub fn codes_of(color: Rgb) -> [u8; 3] {
    [color.r, color.g, color.b].map(linear_to_srgb8)
}

fn linear(codes: [u8; 3]) -> Rgb {
    let [r, g, b] = codes.map(srgb8_to_linear);
    Rgb::new(r, g, b)
}

impl ColorDialog {
    /// Begins with a colour.
    pub fn new(color: Rgb, recent: &[[u8; 3]]) -> Self {
        let codes = codes_of(color);
        let mut dialog = Self {
            hsv: hsv(codes),
            codes,
            row: Row::Slider(0),
            code: Field::default(),
            recent: recent.to_vec(),
            swatch: 0,
        };
        dialog.code = Field::new(&dialog.hex());
        dialog
    }

    /// The colour chosen, linear.
    pub fn color(&self) -> Rgb {
        linear(self.codes)
    }

    /// The colour chosen.
    pub fn codes(&self) -> [u8; 3] {
        self.codes
    }

    fn hex(&self) -> String {
        let [r, g, b] = self.codes;
        format!("#{r:02x}{g:02x}{b:02x}")
    }

    /// Takes a key; whether the colour is another one.
    pub fn key(&mut self, key: Key, command: Option<Command>) -> bool {
        let before = self.codes;
        let typed = matches!(key.code, Code::Char(c) if c == '#' || c.is_ascii_alphanumeric()) && !key.ctrl && !key.alt;
        match (command, self.row) {
            (Some(Command::Step(by) | Command::Focus(by) | Command::StepFar(by)), _) => self.move_row(by),
            (_, Row::Code) if self.code.key(key) => self.read_code(),
            (Some(Command::Turn(by)), Row::Slider(i)) => self.slide(i, f64::from(by)),
            (Some(Command::TurnFar(by)), Row::Slider(i)) => self.slide(i, 10.0 * f64::from(by)),
            (Some(Command::Turn(by) | Command::TurnFar(by)), Row::Named | Row::Recent) => {
                let count = self.swatches().len();
                self.swatch = self.swatch.saturating_add_signed(by.into()).min(count.saturating_sub(1));
                self.take_swatch();
            }
            // Whoever types means a code or a name.
            _ if typed => {
                self.row = Row::Code;
                self.code = Field::default();
                self.code.key(key);
                self.read_code();
            }
            _ => {}
        }
        self.codes != before
    }

    /// Takes a pasted code or name; whether the colour is another one.
    pub fn paste(&mut self, text: &str) -> bool {
        let before = self.codes;
        self.row = Row::Code;
        self.code = Field::new(text.trim());
        self.read_code();
        self.codes != before
    }

    fn move_row(&mut self, by: i8) {
        let mut order: Vec<_> = (0..SLIDERS.len()).map(Row::Slider).collect();
        order.extend([Row::Code, Row::Named]);
        if !self.recent.is_empty() {
            order.push(Row::Recent);
        }
        let now = order.iter().position(|row| *row == self.row).unwrap_or(0);
        self.row = order[(now as isize + isize::from(by.signum())).rem_euclid(order.len() as isize) as usize];
        self.swatch = 0;
    }

    fn slide(&mut self, slider: usize, by: f64) {
        if slider < 3 {
            self.codes[slider] = (f64::from(self.codes[slider]) + by).clamp(0.0, 255.0) as u8;
            self.set_codes(self.codes);
        } else {
            let (value, largest) = (&mut self.hsv[slider - 3], SLIDERS[slider].1);
            *value = if slider == 3 { (*value + by).rem_euclid(360.0) } else { (*value + by).clamp(0.0, largest) };
            self.codes = rgb(self.hsv);
            self.code = Field::new(&self.hex());
        }
    }

    fn set_codes(&mut self, codes: [u8; 3]) {
        self.codes = codes;
        let [h, s, v] = hsv(codes);
        // Grey has no hue and black no saturation: the sliders stay where they were.
        let saturation = if v == 0.0 { self.hsv[1] } else { s };
        self.hsv = [if s == 0.0 { self.hsv[0] } else { h }, saturation, v];
        self.code = Field::new(&self.hex());
    }

    fn read_code(&mut self) {
        let text = self.code.text();
        if let Some(color) = parse_color(&text).or_else(|| parse_color(&format!("#{text}"))) {
            self.set_codes(codes_of(color));
            self.code = Field::new(&text);
        }
    }

    fn swatches(&self) -> Vec<[u8; 3]> {
        match self.row {
            Row::Recent => self.recent.clone(),
            _ => NAMED.iter().map(|name| parse_color(name).map_or([0; 3], codes_of)).collect(),
        }
    }

    fn take_swatch(&mut self) {
        if let Some(codes) = self.swatches().get(self.swatch) {
            self.set_codes(*codes);
        }
    }

    /// Draws the box.
    pub fn draw(&self, mode: ColorMode, keymap: &Keymap, title: &str, room: Rect, buffer: &mut Buffer) {
        let height = 9 + u16::from(!self.recent.is_empty());
        let inner = popup(mode, right_of(room), title, &accept_hints(keymap), (46, height), buffer);
        let swatch_width = if inner.width >= 44 { 8 } else { 0 };
        let left = Rect { width: inner.width - swatch_width, ..inner };
        let line = |y: u16| Rect { y: inner.y + y, height: u16::from(y < inner.height), ..left };
        for (i, (name, largest)) in SLIDERS.into_iter().enumerate() {
            let value = if i < 3 { f64::from(self.codes[i]) } else { self.hsv[i - 3] };
            let chosen = self.row == Row::Slider(i);
            let area = line(i as u16);
            let bar = usize::from(area.width).saturating_sub(19);
            let mut spans = vec![
                Span::styled(if chosen { "▸ " } else { "  " }, mode.style(Role::Key)),
                Span::styled(format!("{name:<11}"), mode.style(if chosen { Role::Strong } else { Role::Dim })),
            ];
            let at = ((value / largest) * bar.saturating_sub(1) as f64).round() as usize;
            for x in 0..bar {
                let part = x as f64 / bar.saturating_sub(1).max(1) as f64;
                let color = mode.color(self.slider_color(i, part));
                let (symbol, style) =
                    if x == at { ("┃", mode.style(Role::Strong)) } else { ("━", Style::new().fg(color)) };
                spans.push(Span::styled(symbol, style));
            }
            spans.push(Span::styled(
                format!(" {value:>4.0}"),
                mode.style(if chosen { Role::Strong } else { Role::Text }),
            ));
            Line::from(spans).render(area, buffer);
        }
        let heading = |name: &'static str, row: Row| {
            let chosen = self.row == row;
            vec![
                Span::styled(if chosen { "▸ " } else { "  " }, mode.style(Role::Key)),
                Span::styled(format!("{name:<10}"), mode.style(if chosen { Role::Strong } else { Role::Dim })),
            ]
        };
        let mut code = heading("code, name", Row::Code);
        if self.row == Row::Code {
            code.push(Span::raw(" "));
            code.extend(self.code.spans(usize::from(left.width).saturating_sub(14), mode.style(Role::Text)));
        } else {
            code.push(Span::raw(format!(" {}", self.hex())));
        }
        Line::from(code).render(line(6), buffer);
        let named: Vec<_> = NAMED.iter().map(|name| parse_color(name).map_or([0; 3], codes_of)).collect();
        for (name, row, colors, y) in [("named", Row::Named, &named, 7), ("recent", Row::Recent, &self.recent, 8)] {
            if colors.is_empty() {
                continue;
            }
            let mut spans = heading(name, row);
            spans.push(Span::raw(" "));
            for (i, codes) in colors.iter().enumerate() {
                let here = self.row == row && i == self.swatch;
                let symbol = if here { "◆" } else { "█" };
                spans.push(Span::styled(symbol, Style::new().fg(mode.color(*codes))));
            }
            if self.row == row && row == Row::Named {
                spans
                    .push(Span::styled(format!(" {}", NAMED[self.swatch.min(NAMED.len() - 1)]), mode.style(Role::Dim)));
            }
            Line::from(spans).render(line(y), buffer);
        }
        for y in 0..6.min(inner.height) {
            for x in 1..swatch_width {
                if let Some(cell) = buffer.cell_mut((left.right() + x, inner.y + y)) {
                    cell.set_symbol("█").set_fg(mode.color(self.codes));
                }
            }
        }
    }

    /// What the colour would be if slider `i` stood at `part` of its length.
    fn slider_color(&self, i: usize, part: f64) -> [u8; 3] {
        if i < 3 {
            let mut codes = self.codes;
            codes[i] = (255.0 * part).round() as u8;
            return codes;
        }
        let mut hsv = self.hsv;
        hsv[i - 3] = SLIDERS[i].1 * part;
        if i == 3 {
            // A grey shows no hues.
            [hsv[1], hsv[2]] = [100.0, 100.0];
        }
        rgb(hsv)
    }
}

/// The lower part of a high screen, so that the dialog hides little of the picture.
fn right_of(room: Rect) -> Rect {
    if room.height < 30 {
        room
    } else {
        Rect { y: room.y + room.height / 2, height: room.height - room.height / 2, ..room }
    }
}

/// Hue in degrees, saturation and value in percent, of sRGB codes (Smith 1978).
fn hsv(codes: [u8; 3]) -> [f64; 3] {
    let [r, g, b] = codes.map(f64::from);
    let (largest, smallest) = (r.max(g).max(b), r.min(g).min(b));
    let range = largest - smallest;
    let hue = match range {
        0.0 => 0.0,
        _ if largest == r => ((g - b) / range).rem_euclid(6.0),
        _ if largest == g => (b - r) / range + 2.0,
        _ => (r - g) / range + 4.0,
    };
    let saturation = if largest == 0.0 { 0.0 } else { range / largest };
    [60.0 * hue, 100.0 * saturation, 100.0 * largest / 255.0]
}

/// The other way.
fn rgb([hue, saturation, value]: [f64; 3]) -> [u8; 3] {
    let (saturation, value) = (saturation / 100.0, value / 100.0);
    [5.0, 3.0, 1.0].map(|n| {
        let k = (n + hue / 60.0) % 6.0;
        let channel = value - value * saturation * k.min(4.0 - k).clamp(0.0, 1.0);
        (255.0 * channel).round() as u8
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_code_survives_the_way_over_hue_saturation_value() {
        for r in (0..=255).step_by(15) {
            for g in (0..=255).step_by(17) {
                for b in (0..=255).step_by(5) {
                    assert_eq!(rgb(hsv([r, g, b])), [r, g, b]);
                }
            }
        }
        assert_eq!(hsv([255, 0, 0]), [0.0, 100.0, 100.0]);
        assert_eq!(hsv([0, 0, 128])[0], 240.0);
        assert_eq!(rgb([120.0, 100.0, 50.0]), [0, 128, 0]);
    }

    #[test]
    fn the_named_colours_have_their_names() {
        for name in NAMED {
            assert!(parse_color(name).is_some(), "{name}");
        }
    }

    #[test]
    fn a_grey_keeps_the_hue_that_it_was_made_from() {
        let mut dialog = ColorDialog::new(linear([200, 100, 50]), &[]);
        let hue = dialog.hsv[0];
        dialog.slide(4, -100.0);
        assert_eq!(dialog.codes, [200; 3]);
        dialog.slide(4, 75.0);
        assert_eq!((dialog.hsv[0], dialog.codes), (hue, [200, 100, 50]));
        dialog.slide(0, -300.0);
        assert_eq!(dialog.codes[0], 0);
    }
}
