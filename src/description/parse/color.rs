//! Colours.

use super::nearest::{did_you_mean, quoted};
use super::report::{Report, Words};
use super::value::Value;
use crate::description::interval::Interval;
use crate::math::{Rgb, linear_to_srgb8, srgb8_to_linear};
use csscolorparser::NAMED_COLORS;
use toml::de::DeValue;

const FORMS: &str = r##"a colour is "#rrggbb", "#rgb", a CSS name such as "tomato", or [r, g, b] in linear light"##;

/// `"#rrggbb"`, `"#rgb"` or a CSS name (sRGB, any case) to linear colour; `None` if it is neither.
pub fn parse_color(text: &str) -> Option<Rgb> {
    let codes = match text.strip_prefix('#') {
        Some(hex) => hex_codes(hex)?,
        None => named_codes(text)?,
    };
    let [r, g, b] = codes.map(srgb8_to_linear);
    Some(Rgb::new(r, g, b))
}

/// `#rrggbb` for a colour that is exactly one; [`parse_color`] gives the same colour back.
pub fn color_code(color: Rgb) -> Option<String> {
    let [r, g, b] = [color.r, color.g, color.b].map(linear_to_srgb8);
    let code = format!("#{r:02x}{g:02x}{b:02x}");
    (parse_color(&code) == Some(color)).then_some(code)
}

fn hex_codes(hex: &str) -> Option<[u8; 3]> {
    let digits: Vec<u8> = hex.chars().map(|c| c.to_digit(16).map(|digit| digit as u8)).collect::<Option<_>>()?;
    match digits[..] {
        [r, g, b] => Some([17 * r, 17 * g, 17 * b]),
        [r1, r0, g1, g0, b1, b0] => Some([16 * r1 + r0, 16 * g1 + g0, 16 * b1 + b0]),
        _ => None,
    }
}

/// Names are letters only. What could be hexadecimal is none, and csscolorparser would take it without a #.
fn named_codes(name: &str) -> Option<[u8; 3]> {
    if !name.bytes().all(|b| b.is_ascii_alphabetic()) || name.bytes().all(|b| b.is_ascii_hexdigit()) {
        return None;
    }
    let [r, g, b, alpha] = csscolorparser::parse(name).ok()?.to_rgba8();
    // "transparent" is the one name that is not opaque.
    (alpha == 255).then_some([r, g, b])
}

impl<'a> Value<'a> {
    /// A colour in any of its forms.
    pub fn color(self, report: &mut Report<'a>) -> Option<Rgb> {
        match self.toml.get_ref() {
            DeValue::String(text) => {
                let found = parse_color(text);
                if found.is_none() {
                    report.mistake(self.span(), move || wrong_color(text).help(FORMS));
                }
                found
            }
            DeValue::Array(_) => {
                let [r, g, b] = self.elements(report, "3 numbers, or a colour in quotes")?;
                let [r, g, b] = [r, g, b].map(|channel| channel.number(report, Interval::LIGHT));
                Some(Rgb::new(r?, g?, b?))
            }
            _ => {
                self.wrong_type(report, "a colour", Some(FORMS));
                None
            }
        }
    }
}

fn wrong_color(text: &str) -> Words {
    let label = match text.strip_prefix('#') {
        Some(hex) if hex.chars().all(|c| c.is_ascii_hexdigit()) => {
            format!("has {} hexadecimal digits, must have 3 or 6", hex.chars().count())
        }
        Some(_) => "must have 3 or 6 hexadecimal digits (0-9, a-f) after the #".to_owned(),
        None if !text.is_empty() && text.chars().all(|c| c.is_ascii_hexdigit()) => "is a # missing?".to_owned(),
        None => did_you_mean(text, NAMED_COLORS.keys().map(|name| name.as_str()), "not a colour name"),
    };
    Words::new(format!("{} is not a colour", quoted(text)), label)
}
