//! Which colours the terminal gets, and how different two colours look.

use super::ColorChoice;
use crate::math::srgb8_to_linear;
use ratatui::style::{Color, Modifier, Style};
use std::sync::LazyLock;

/// What the terminal can show.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ColorMode {
    /// 24 bits.
    Truecolor,
    /// The fixed part of the palette of 256: the 6x6x6 cube and the greys.
    Indexed,
    /// No colours: pictures are made of characters.
    None,
}

impl ColorMode {
    /// The flag, else what the environment (read by `variable`) says. SSH does not forward `COLORTERM`, so terminals
    /// are also known by name. Inside tmux 24 bits are safe: it maps them to what the terminal outside can show.
    pub fn detect(choice: ColorChoice, variable: impl Fn(&str) -> Option<String>) -> Self {
        let variable = |name| variable(name).unwrap_or_default();
        match choice {
            ColorChoice::Truecolor => return Self::Truecolor,
            ColorChoice::Indexed => return Self::Indexed,
            ColorChoice::Never => return Self::None,
            ColorChoice::Auto => {}
        }
        if !variable("NO_COLOR").is_empty() {
            return Self::None;
        }
        let term = variable("TERM");
        let named = ["kitty", "ghostty", "alacritty", "foot", "wezterm", "contour", "rio", "direct"];
        let truecolor = matches!(variable("COLORTERM").as_str(), "truecolor" | "24bit")
            || named.iter().any(|name| term.contains(name))
            || !variable("WT_SESSION").is_empty()
            || !variable("TMUX").is_empty();
        match term.as_str() {
            "dumb" | "vt100" | "vt220" => Self::None,
            _ if truecolor => Self::Truecolor,
            _ => Self::Indexed,
        }
    }

    /// The colour to send for an sRGB code.
    pub fn color(self, [r, g, b]: [u8; 3]) -> Color {
        match self {
            Self::Truecolor => Color::Rgb(r, g, b),
            Self::Indexed => Color::Indexed(nearest_index([r, g, b])),
            Self::None => Color::Reset,
        }
    }

    /// How a part of the interface looks. The colours are of middle lightness, so that they can be read on black and
    /// on white: the ground is the user's own.
    pub fn style(self, role: Role) -> Style {
        let color = |rgb| Style::new().fg(self.color(rgb));
        let plain = Style::new();
        match (role, self) {
            (Role::Text, _) => plain,
            (Role::Strong, _) => plain.add_modifier(Modifier::BOLD),
            (Role::Dim, Self::None) => plain.add_modifier(Modifier::DIM),
            (Role::Key | Role::Bar | Role::Good, Self::None) => plain,
            (Role::Bad | Role::Cursor, Self::None) => plain.add_modifier(Modifier::REVERSED),
            (Role::Mark, Self::None) => plain.add_modifier(Modifier::BOLD),
            (Role::Dim, _) => color([128, 132, 140]),
            (Role::Key | Role::Bar | Role::Mark, _) => color([214, 142, 48]),
            // Light on dark whatever the user's own ground is.
            (Role::Cursor, _) => Style::new().fg(self.color([250, 250, 250])).bg(self.color([58, 96, 140])),
            (Role::Good, _) => color([72, 160, 100]),
            (Role::Bad, _) => color([220, 80, 76]).add_modifier(Modifier::BOLD),
        }
    }
}

/// Parts of the interface by meaning.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// Values.
    Text,
    /// Headings.
    Strong,
    /// Labels, lines, what is empty.
    Dim,
    /// Names of keys.
    Key,
    /// Filled part of a bar.
    Bar,
    /// The row that has the keys.
    Cursor,
    /// What is selected.
    Mark,
    /// What went well.
    Good,
    /// What went wrong.
    Bad,
}

const CUBE: [u8; 6] = [0, 95, 135, 175, 215, 255];

/// The nearest of the fixed 240 colours by CIE76.
fn nearest_index(rgb: [u8; 3]) -> u8 {
    let steps = rgb.map(|c| (0..6).min_by_key(|&i| CUBE[i].abs_diff(c)).unwrap_or(0));
    let cube = (16 + 36 * steps[0] + 6 * steps[1] + steps[2]) as u8;
    let mean = (u32::from(rgb[0]) + u32::from(rgb[1]) + u32::from(rgb[2])) / 3;
    let step = (mean.saturating_sub(3) / 10).min(23) as u8;
    let grey = 8 + 10 * step;
    if delta_e(rgb, [grey; 3]) < delta_e(rgb, steps.map(|i| CUBE[i])) { 232 + step } else { cube }
}

/// CIE76 difference of two sRGB codes (D65): about 1 is what the eye can just see, black to white is 100.
pub fn delta_e(a: [u8; 3], b: [u8; 3]) -> f32 {
    if a == b {
        return 0.0;
    }
    let (a, b) = (lab(a), lab(b));
    ((a[0] - b[0]).powi(2) + (a[1] - b[1]).powi(2) + (a[2] - b[2]).powi(2)).sqrt()
}

static LINEAR: LazyLock<[f32; 256]> = LazyLock::new(|| std::array::from_fn(|c| srgb8_to_linear(c as u8) as f32));

/// CIE L*a*b* of an sRGB code, white D65.
fn lab(rgb: [u8; 3]) -> [f32; 3] {
    let [r, g, b] = rgb.map(|c| LINEAR[c as usize]);
    let f = |t: f32| if t > 216.0 / 24389.0 { t.cbrt() } else { (24389.0 / 27.0 * t + 16.0) / 116.0 };
    let x = f((0.412_456_4 * r + 0.357_576_1 * g + 0.180_437_5 * b) / 0.950_47);
    let y = f(0.212_672_9 * r + 0.715_152_2 * g + 0.072_175 * b);
    let z = f((0.019_333_9 * r + 0.119_192 * g + 0.950_304_1 * b) / 1.088_83);
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn detect(variables: &[(&str, &str)]) -> ColorMode {
        ColorMode::detect(ColorChoice::Auto, |name| {
            variables.iter().find(|(n, _)| *n == name).map(|(_, value)| value.to_string())
        })
    }

    #[test]
    fn the_environment_tells_the_colours() {
        assert_eq!(detect(&[("TERM", "xterm-256color")]), ColorMode::Indexed);
        assert_eq!(detect(&[("TERM", "xterm-256color"), ("COLORTERM", "truecolor")]), ColorMode::Truecolor);
        assert_eq!(detect(&[("TERM", "xterm-kitty")]), ColorMode::Truecolor);
        assert_eq!(detect(&[("TERM", "xterm-direct")]), ColorMode::Truecolor);
        assert_eq!(detect(&[("TERM", "screen-256color"), ("TMUX", "/tmp/tmux-0/default,1,0")]), ColorMode::Truecolor);
        assert_eq!(detect(&[("TERM", "xterm-kitty"), ("NO_COLOR", "1")]), ColorMode::None);
        assert_eq!(detect(&[("TERM", "xterm-kitty"), ("NO_COLOR", "")]), ColorMode::Truecolor);
        assert_eq!(ColorMode::detect(ColorChoice::Indexed, |_| Some("1".into())), ColorMode::Indexed);
    }

    #[test]
    fn differences_are_those_of_the_book() {
        assert!((delta_e([0; 3], [255; 3]) - 100.0).abs() < 0.01);
        // Red is L 53.24, a 80.09, b 67.20.
        let [l, a, b] = lab([255, 0, 0]);
        assert!((l - 53.24).abs() < 0.02 && (a - 80.09).abs() < 0.05 && (b - 67.20).abs() < 0.05, "{l} {a} {b}");
        assert_eq!(delta_e([1, 2, 3], [1, 2, 3]), 0.0);
    }

    #[test]
    fn palette_colours_are_their_own_nearest() {
        for step in 0..24 {
            let grey = 8 + 10 * step;
            assert_eq!(nearest_index([grey; 3]), 232 + step);
        }
        assert_eq!(nearest_index([95, 135, 255]), 16 + 36 + 12 + 5);
        assert_eq!(nearest_index([255; 3]), 231);
        assert_eq!(nearest_index([0; 3]), 16);
    }
}
