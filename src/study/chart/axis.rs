//! Ends and ticks of axes.

use super::{Axis, Chart, Data, Scale};

/// An axis with its ends and ticks.
pub(super) struct Fitted {
    low: f64,
    high: f64,
    scale: Scale,
    /// Values with their labels.
    pub ticks: Vec<(f64, String)>,
    /// Values between them with a fainter line.
    pub minor: Vec<f64>,
}

/// Along which side.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Side {
    X,
    Y,
}

/// How much wider than the data an axis is, at each end.
const MARGIN: f64 = 0.04;

impl Fitted {
    pub fn new(chart: &Chart, side: Side) -> Self {
        let axis = if side == Side::X { &chart.x } else { &chart.y };
        let (low, high) = ends(chart, axis, side);
        let mut fitted = Self { low, high, scale: axis.scale, ticks: Vec::new(), minor: Vec::new() };
        if !axis.names.is_empty() {
            fitted.ticks = axis.names.iter().enumerate().map(|(i, name)| (i as f64, name.clone())).collect();
        } else {
            match axis.scale {
                Scale::Linear => fitted.linear_ticks(),
                Scale::Log => fitted.log_ticks(),
            }
        }
        fitted
    }

    /// Where a value lies: 0 at the low end, 1 at the high one. Values beyond are at the ends.
    pub fn place(&self, value: f64) -> f64 {
        let place = match self.scale {
            Scale::Linear => (value - self.low) / (self.high - self.low),
            Scale::Log if value <= 0.0 => 0.0,
            Scale::Log => (value.ln() - self.low.ln()) / (self.high.ln() - self.low.ln()),
        };
        place.clamp(0.0, 1.0)
    }

    /// Whether a value is so low that it is only shown at the low end.
    pub fn is_below(&self, value: f64) -> bool {
        self.scale == Scale::Log && value < self.low * (1.0 - 1e-9)
    }

    fn contains(&self, value: f64) -> bool {
        let slack = |end: f64| if self.scale == Scale::Log { 1e-9 * end } else { 1e-9 * (self.high - self.low) };
        (self.low - slack(self.low)..=self.high + slack(self.high)).contains(&value)
    }

    fn linear_ticks(&mut self) {
        let step = nice_step((self.high - self.low) / 6.0);
        let first = (self.low / step).ceil() as i64;
        let digits = (-step.log10().floor()).clamp(0.0, 12.0) as usize;
        // A step of 2.5 needs one digit more than its size tells.
        let digits = digits + usize::from((step * 10f64.powi(digits as i32)).fract().abs() > 1e-6);
        self.ticks = (first..first + 20)
            .map(|i| i as f64 * step)
            .filter(|value| self.contains(*value))
            .map(|value| (value, if value.abs() >= 1e5 { large(value) } else { format!("{value:.digits$}") }))
            .collect();
    }

    /// Powers of ten, and 1, 2, 5 of each where there is room for them.
    fn log_ticks(&mut self) {
        // What f64 holds, whatever the ends are.
        let power = |end: f64| end.log10().clamp(-323.0, 308.0);
        let (first, last) = (power(self.low).floor() as i32, power(self.high).ceil() as i32);
        let decades = power(self.high) - power(self.low);
        let labelled: &[f64] = if decades <= 3.2 { &[1.0, 2.0, 5.0] } else { &[1.0] };
        let stride = (decades / 9.0).ceil().max(1.0) as i32;
        for power in first..=last {
            for digit in [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0] {
                let value = digit * 10f64.powi(power);
                if !self.contains(value) {
                    continue;
                }
                if labelled.contains(&digit) && power.rem_euclid(stride) == 0 {
                    self.ticks.push((value, large(value)));
                } else if decades <= 6.0 {
                    self.minor.push(value);
                }
            }
        }
        if self.ticks.len() < 2 {
            self.minor.clear();
            self.linear_ticks();
        }
    }
}

/// `0.001` to `10000`, and `1e5` beyond.
fn large(value: f64) -> String {
    if value == 0.0 {
        return "0".to_owned();
    }
    match value.abs().log10() {
        magnitude if !(-3.01..4.99).contains(&magnitude) => format!("{value:.0e}"),
        magnitude => format!("{value:.*}", (-(magnitude + 1e-9).floor()).max(0.0) as usize),
    }
}

/// The least of 1, 2, 2.5, 5 times a power of ten that is not below `step`.
fn nice_step(step: f64) -> f64 {
    let power = 10f64.powf(step.log10().floor());
    [1.0, 2.0, 2.5, 5.0].map(|digit| digit * power).into_iter().find(|nice| *nice >= step).unwrap_or(10.0 * power)
}

fn ends(chart: &Chart, axis: &Axis, side: Side) -> (f64, f64) {
    if let Some(range) = axis.range {
        return range;
    }
    if !axis.names.is_empty() {
        return (-0.6, axis.names.len() as f64 - 0.4);
    }
    let mut values = Vec::new();
    let mut from_zero = false;
    for series in &chart.series {
        let points = series.data.points().iter();
        match (side, &series.data) {
            (Side::X, Data::Guide(line)) => values.extend(line.iter().map(|p| p.0)),
            (Side::Y, Data::Guide(line)) => values.extend(line.iter().map(|p| p.1)),
            (Side::X, Data::Spans(spans)) => values.extend(spans.iter().flat_map(|span| [span.from, span.to])),
            (Side::Y, Data::Spans(spans)) => values.extend(spans.iter().map(|span| span.lane as f64)),
            (Side::X, _) => values.extend(points.map(|p| p.x)),
            (Side::Y, data) => {
                from_zero |= matches!(data, Data::Columns(_));
                values.extend(points.flat_map(|p| [p.y, p.spread.map_or(p.y, |s| s.0), p.spread.map_or(p.y, |s| s.1)]));
            }
        }
    }
    if side == Side::Y {
        values.extend(chart.limits.iter().map(|limit| limit.y));
    }
    values.retain(|value| value.is_finite() && (axis.scale == Scale::Linear || *value > 0.0));
    let low = values.iter().copied().fold(f64::INFINITY, f64::min);
    let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    match axis.scale {
        _ if values.is_empty() => (1.0, 10.0),
        Scale::Log => {
            // The quotient may be beyond f64 where its logarithm is not.
            let ratio = (1.5 * MARGIN * (high.ln() - low.ln()).max(2f64.ln())).exp();
            let (low, high) = if high / low < 1.5 { (low / 2.0, high * 2.0) } else { (low / ratio, high * ratio) };
            (low.max(f64::MIN_POSITIVE), high.min(f64::MAX))
        }
        Scale::Linear => {
            // A quantity that starts near nothing is shown from nothing.
            let low = if from_zero || (low >= 0.0 && low < 0.6 * high) { 0.0 } else { low };
            let room = if high > low { MARGIN * (high - low) } else { 0.5 };
            (if low == 0.0 { 0.0 } else { low - room }, high + room)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::chart::{Point, Series};

    fn labels(axis: Axis, values: &[f64]) -> String {
        let points = values.iter().map(|value| Point::new(*value, 1.0)).collect();
        let series = vec![Series { name: String::new(), data: Data::Points(points) }];
        let chart = Chart {
            title: String::new(),
            subtitle: String::new(),
            x: axis,
            y: Axis::linear(""),
            series,
            limits: Vec::new(),
        };
        let labels: Vec<_> = Fitted::new(&chart, Side::X).ticks.into_iter().map(|(_, label)| label).collect();
        labels.join(" ")
    }

    #[test]
    fn ticks_are_round_numbers_inside_the_axis() {
        let log = || Axis::log("");
        assert_eq!(labels(log(), &[1.0, 100.0]), "1 2 5 10 20 50 100");
        assert_eq!(labels(log(), &[0.003, 0.2]), "0.005 0.01 0.02 0.05 0.1 0.2");
        assert_eq!(labels(log(), &[1e-3, 1e5]), "0.001 0.01 0.1 1 10 100 1000 10000 1e5");
        assert_eq!(labels(log(), &[1e-9, 1e9]), "1e-9 1e-6 0.001 1 1000 1e6 1e9");
        // Errors that are not finite are written as the largest number that there is.
        assert_eq!(labels(log(), &[1e-300, f64::MAX]), "1e-276 1e-207 1e-138 1e-69 1 1e69 1e138 1e207 1e276");
        assert_eq!(labels(log(), &[1.0, f64::MAX]), "1 1e37 1e74 1e111 1e148 1e185 1e222 1e259 1e296");
        for values in [[f64::MIN_POSITIVE, f64::MAX], [5e-324, 1.0], [f64::MAX, f64::MAX]] {
            assert!((1..=20).contains(&labels(log(), &values).split(' ').count()), "{values:?}");
        }
        let linear = || Axis::linear("");
        assert_eq!(labels(linear(), &[0.0, 10.0]), "0 2 4 6 8 10");
        assert_eq!(labels(linear(), &[100.0, 101.0]), "100.0 100.2 100.4 100.6 100.8 101.0");
        assert_eq!(labels(linear(), &[0.0, 1.3]), "0.00 0.25 0.50 0.75 1.00 1.25");
        let names = || Axis::names("", vec!["a".to_owned(), "b".to_owned()]);
        assert_eq!(labels(names(), &[0.0, 1.0]), "a b");
    }

    #[test]
    fn values_lie_by_ratio_or_difference_and_never_outside() {
        let fitted = |axis| {
            let chart = Chart {
                title: String::new(),
                subtitle: String::new(),
                x: axis,
                y: Axis::linear(""),
                series: Vec::new(),
                limits: Vec::new(),
            };
            Fitted::new(&chart, Side::X)
        };
        let log = fitted(Axis { range: Some((1.0, 100.0)), ..Axis::log("") });
        assert_eq!([0.0, 0.1, 1.0, 10.0, 100.0, 1e9].map(|v| log.place(v)), [0.0, 0.0, 0.0, 0.5, 1.0, 1.0]);
        assert!(log.is_below(0.0) && log.is_below(0.9) && !log.is_below(1.0));
        let linear = fitted(Axis { range: Some((-1.0, 1.0)), ..Axis::linear("") });
        assert_eq!([-2.0, -1.0, 0.0, 1.0, 5.0].map(|v| linear.place(v)), [0.0, 0.0, 0.5, 1.0, 1.0]);
    }
}
