//! Numbers for people, those that run in fixed widths so that nothing jitters.

use crate::description::Projection;
use std::time::Duration;

/// Three significant digits and an SI prefix, 6 columns: `  1.23M`-like, right-aligned; below 1000 as it is.
pub fn si(value: f64) -> String {
    const PREFIXES: [&str; 7] = [" ", "k", "M", "G", "T", "P", "E"];
    let (mut scaled, mut prefix) = (value.max(0.0), 0);
    // What would round to 1000 takes the next prefix.
    while scaled >= 999.5 && prefix + 1 < PREFIXES.len() {
        scaled /= 1000.0;
        prefix += 1;
    }
    let decimals = match scaled {
        _ if prefix == 0 => 0,
        s if s < 9.995 => 2,
        s if s < 99.95 => 1,
        _ => 0,
    };
    format!("{scaled:>4.decimals$} {}", PREFIXES[prefix])
}

/// A length of time, 7 columns, right-aligned: `12.3 ms`, `1.23 s`, `1:02.3`, `1:02:03`, `3 d 04 h`.
pub fn time(t: Duration) -> String {
    let s = t.as_secs_f64();
    // Truncated, not rounded: a clock shows what has passed.
    let tenths = (s * 10.0) as u64;
    let text = match tenths {
        _ if s < 1.0 => format!("{} ms", t.as_millis()),
        0..600 => format!("{}.{} s", tenths / 10, tenths % 10),
        600..36_000 => format!("{}:{:02}.{}", tenths / 600, tenths / 10 % 60, tenths % 10),
        36_000..864_000 => format!("{}:{:02}:{:02}", tenths / 36_000, tenths / 600 % 60, tenths / 10 % 60),
        _ => format!("{} d {:02} h", tenths / 864_000, tenths / 36_000 % 24),
    };
    format!("{text:>7}")
}

/// A length of time that is only guessed: whole seconds, minutes or hours, rounded up.
pub fn rough_time(t: Duration) -> String {
    match t.as_secs_f64().ceil() as u64 {
        s @ 0..100 => format!("{s} s"),
        s @ 100..6000 => format!("{} min", s.div_ceil(60)),
        s @ 6000..172_800 => format!("{} h", s.div_ceil(3600)),
        s => format!("{} d", s.div_ceil(86_400)),
    }
}

/// So many samples.
pub fn samples(count: u32) -> String {
    if count == 1 { "1 sample".into() } else { format!("{count} samples") }
}

/// Angle or height of the view.
pub fn view(projection: Projection) -> String {
    match projection {
        Projection::Perspective { fov } => format!("field of view {fov:.1}°"),
        Projection::Orthographic { view_height } => format!("view height {view_height:.3}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn si_numbers_have_six_columns_and_three_digits() {
        for (value, text) in [
            (0.0, "   0  "),
            (7.4, "   7  "),
            (999.4, " 999  "),
            (999.6, "1.00 k"),
            (9_994.0, "9.99 k"),
            (9_996.0, "10.0 k"),
            (99_960.0, " 100 k"),
            (12_345_678.0, "12.3 M"),
            (999_600_000.0, "1.00 G"),
        ] {
            assert_eq!(si(value), text, "{value}");
        }
        assert_eq!(si(f64::NAN).len(), 6);
    }

    #[test]
    fn one_sample_is_not_samples() {
        assert_eq!([samples(1), samples(2)], ["1 sample", "2 samples"]);
    }

    #[test]
    fn times_have_seven_columns() {
        for (seconds, text) in [
            (0.0123, "  12 ms"),
            (0.9999, " 999 ms"),
            (1.19, "  1.1 s"),
            (59.99, " 59.9 s"),
            (62.35, " 1:02.3"),
            (3599.99, "59:59.9"),
            (3723.0, "1:02:03"),
            (100.0 * 3600.0, "4 d 04 h"),
        ] {
            assert_eq!(time(Duration::from_secs_f64(seconds)), text);
        }
    }

    #[test]
    fn guessed_times_are_rounded_up() {
        for (seconds, text) in [(0.2, "1 s"), (99.0, "99 s"), (99.5, "2 min"), (3601.0, "61 min"), (7200.0, "2 h")] {
            assert_eq!(rough_time(Duration::from_secs_f64(seconds)), text);
        }
    }
}
