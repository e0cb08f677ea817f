//! Repeated measurements and their statistics.
//!
//! Settings are measured in interleaved rounds: a machine that grows warm or busy then slows all of them alike, and
//! their ratios hold. The order in each round is shuffled by a seed, so that none always follows the same other.

use super::Clock;
use crate::math::SplitMix64;
use serde::Serialize;
use std::time::Duration;

/// How often and in which order settings are measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Plan {
    /// How many settings there are.
    pub settings: usize,
    /// How often each is measured.
    pub rounds: usize,
    /// Rounds before these, that are not kept: they fill caches and wake the processor.
    pub warm_up: usize,
    /// Of the order.
    pub seed: u64,
}

/// One measurement.
#[derive(Clone, Debug, PartialEq)]
pub struct Timed<T> {
    /// From 0.
    pub round: usize,
    /// Wall time.
    pub time: Duration,
    /// What was made.
    pub value: T,
}

impl Plan {
    /// The settings of each round, in their order; warm-up rounds come first.
    pub fn orders(&self) -> Vec<Vec<usize>> {
        let mut random = SplitMix64(self.seed);
        let mut shuffled = || {
            let mut order: Vec<usize> = (0..self.settings).collect();
            for last in (1..order.len()).rev() {
                order.swap(last, (random.unit() * (last + 1) as f64) as usize);
            }
            order
        };
        (0..self.warm_up + self.rounds).map(|_| shuffled()).collect()
    }

    /// Calls `run` with each setting in each round and times it. For every setting its measurements in the order of
    /// rounds; the first error ends it.
    pub fn measure<T, E>(
        &self,
        clock: &impl Clock,
        mut run: impl FnMut(usize) -> Result<T, E>,
    ) -> Result<Vec<Vec<Timed<T>>>, E> {
        let mut measured: Vec<Vec<Timed<T>>> = (0..self.settings).map(|_| Vec::new()).collect();
        for (number, order) in self.orders().into_iter().enumerate() {
            for setting in order {
                let begun = clock.now();
                let value = run(setting)?;
                let time = clock.now().saturating_sub(begun);
                if let Some(round) = number.checked_sub(self.warm_up) {
                    measured[setting].push(Timed { round, time, value });
                }
            }
        }
        Ok(measured)
    }
}

/// What repeated measurements say.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Stats {
    /// Measurements.
    pub count: usize,
    /// The smallest: what disturbs a measurement makes it longer, so for times the truest.
    pub min: f64,
    /// A quarter is below.
    pub lower_quartile: f64,
    /// Half is below.
    pub median: f64,
    /// A quarter is above.
    pub upper_quartile: f64,
    /// The largest.
    pub max: f64,
    /// Median of the distances from the median.
    pub mad: f64,
}

impl Stats {
    /// `None` of nothing, and of numbers that are not finite. Quantiles are interpolated linearly (Hyndman and Fan
    /// 1996, type 7).
    pub fn of(numbers: &[f64]) -> Option<Self> {
        if numbers.is_empty() || !numbers.iter().all(|n| n.is_finite()) {
            return None;
        }
        let mut sorted = numbers.to_vec();
        sorted.sort_by(f64::total_cmp);
        let median = quantile(&sorted, 0.5);
        let mut distances: Vec<f64> = sorted.iter().map(|n| (n - median).abs()).collect();
        distances.sort_by(f64::total_cmp);
        Some(Self {
            count: sorted.len(),
            min: sorted[0],
            lower_quartile: quantile(&sorted, 0.25),
            median,
            upper_quartile: quantile(&sorted, 0.75),
            max: sorted[sorted.len() - 1],
            mad: quantile(&distances, 0.5),
        })
    }

    /// Of the times of measurements, in seconds.
    pub fn of_times<T>(measured: &[Timed<T>]) -> Option<Self> {
        Self::of(&measured.iter().map(|m| m.time.as_secs_f64()).collect::<Vec<_>>())
    }
}

fn quantile(sorted: &[f64], part: f64) -> f64 {
    let place = part * (sorted.len() - 1) as f64;
    let below = sorted[place.floor() as usize];
    below + (sorted[place.ceil() as usize] - below) * place.fract()
}

/// A power law `y = factor * x^exponent`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PowerLaw {
    /// The slope on log-log paper.
    pub exponent: f64,
    /// Standard error of the exponent; 0 for two points.
    pub error: f64,
    /// y at x = 1.
    pub factor: f64,
}

impl PowerLaw {
    /// Least squares of the logarithms. `None` unless there are two different positive x with positive y.
    pub fn fit(points: &[(f64, f64)]) -> Option<Self> {
        let logs: Vec<(f64, f64)> =
            points.iter().filter(|(x, y)| *x > 0.0 && *y > 0.0).map(|(x, y)| (x.ln(), y.ln())).collect();
        let n = logs.len() as f64;
        let mean = |f: fn(&(f64, f64)) -> f64| logs.iter().map(f).sum::<f64>() / n;
        let (x, y) = (mean(|p| p.0), mean(|p| p.1));
        let spread: f64 = logs.iter().map(|p| (p.0 - x).powi(2)).sum();
        if logs.len() < 2 || spread < 1e-12 {
            return None;
        }
        let exponent = logs.iter().map(|p| (p.0 - x) * (p.1 - y)).sum::<f64>() / spread;
        let offset = y - exponent * x;
        let residual: f64 = logs.iter().map(|p| (p.1 - offset - exponent * p.0).powi(2)).sum();
        let error = if logs.len() > 2 { (residual / (n - 2.0) / spread).sqrt() } else { 0.0 };
        Some(Self { exponent, error, factor: offset.exp() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::cell::Cell;

    /// A clock whose hands stand still until they are moved.
    struct MockClock(Cell<Duration>);

    impl Clock for MockClock {
        fn now(&self) -> Duration {
            self.0.get()
        }
    }

    #[test]
    fn every_setting_is_measured_once_a_round_and_the_clock_is_believed() {
        let clock = MockClock(Cell::new(Duration::from_secs(100)));
        let plan = Plan { settings: 3, rounds: 4, warm_up: 1, seed: 7 };
        let mut calls = 0;
        let measured = plan
            .measure(&clock, |setting| {
                calls += 1;
                // Setting s takes 10 * (s + 1) ms, and a millisecond more at every call.
                clock.0.set(clock.0.get() + Duration::from_millis(10 * (setting as u64 + 1) + calls));
                Ok::<_, ()>(calls)
            })
            .unwrap();
        assert_eq!(calls, 15);
        for (setting, measured) in measured.iter().enumerate() {
            assert_eq!(measured.iter().map(|m| m.round).collect::<Vec<_>>(), [0, 1, 2, 3]);
            for m in measured {
                // The first three calls were the warm-up.
                assert!(m.value > 3 && (m.value - 1) / 3 == m.round as u64 + 1);
                assert_eq!(m.time, Duration::from_millis(10 * (setting as u64 + 1) + m.value));
            }
        }
    }

    #[test]
    fn rounds_differ_in_order_and_the_seed_decides_it() {
        let plan = Plan { settings: 6, rounds: 20, warm_up: 0, seed: 1 };
        let orders = plan.orders();
        assert_eq!(orders, plan.orders());
        assert_ne!(orders, Plan { seed: 2, ..plan }.orders());
        assert!(orders.windows(2).filter(|pair| pair[0] != pair[1]).count() > 15);
        for mut order in orders {
            order.sort();
            assert_eq!(order, [0, 1, 2, 3, 4, 5]);
        }
    }

    #[test]
    fn an_error_ends_the_measurement() {
        let clock = MockClock(Cell::new(Duration::ZERO));
        let mut calls = 0;
        let plan = Plan { settings: 2, rounds: 2, warm_up: 0, seed: 0 };
        let outcome = plan.measure(&clock, |_| {
            calls += 1;
            if calls == 2 { Err("no") } else { Ok(()) }
        });
        assert_eq!((outcome, calls), (Err("no"), 2));
    }

    #[test]
    fn statistics_of_known_numbers() {
        let stats = Stats::of(&[9.0, 1.0, 3.0, 5.0, 7.0]).unwrap();
        let all = [stats.min, stats.lower_quartile, stats.median, stats.upper_quartile, stats.max, stats.mad];
        assert_eq!(all, [1.0, 3.0, 5.0, 7.0, 9.0, 2.0]);
        let stats = Stats::of(&[4.0, 1.0]).unwrap();
        assert_eq!((stats.lower_quartile, stats.median, stats.mad), (1.75, 2.5, 1.5));
        // One outlier moves the mean, not these.
        let stats = Stats::of(&[1.0, 1.0, 1.0, 1.0, 1e6]).unwrap();
        assert_eq!((stats.median, stats.mad), (1.0, 0.0));
        assert_eq!(Stats::of(&[]), None);
        assert_eq!(Stats::of(&[1.0, f64::NAN]), None);
    }

    #[test]
    fn power_laws_are_found_and_their_error_is_that_of_the_noise() {
        let exact: Vec<_> = (1..9).map(|i| (f64::from(1 << i), 3.0 * f64::from(1 << i).powf(1.5))).collect();
        let law = PowerLaw::fit(&exact).unwrap();
        assert!((law.exponent - 1.5).abs() < 1e-12 && (law.factor - 3.0).abs() < 1e-9 && law.error < 1e-12);
        // By hand: x = 1, e, e^2 and ln y = 0, 1, 1: slope 1/2, residuals -1/6, 1/3, -1/6, error sqrt(1/6 / 2).
        let e = 1f64.exp();
        let law = PowerLaw::fit(&[(1.0, 1.0), (e, e), (e * e, e)]).unwrap();
        assert!((law.exponent - 0.5).abs() < 1e-12 && (law.error - (1.0f64 / 12.0).sqrt()).abs() < 1e-12);
        assert_eq!(PowerLaw::fit(&[(1.0, 2.0)]), None);
        assert_eq!(PowerLaw::fit(&[(2.0, 2.0), (2.0, 3.0)]), None);
        assert_eq!(PowerLaw::fit(&[(0.0, 2.0), (2.0, 3.0)]), None);
    }
}
