//! Where and when a study was made: what stands above its numbers.

use crate::bvh::Isa;
use serde::Serialize;
use std::io;
use std::time::{SystemTime, UNIX_EPOCH};
use xxhash_rust::xxh3::xxh3_64;

/// The machine and its state.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Machine {
    /// The processor's name; "unknown" where the system does not tell.
    pub cpu: String,
    /// Processors that this process may use.
    pub threads: usize,
    /// Operating system, its version, and the processor's family.
    pub system: String,
    /// Vector instructions that rays are traced with.
    pub isa: String,
    /// Processes that wanted to run in the last minute, when the study began.
    pub load: Option<f64>,
}

impl Machine {
    /// This one, now.
    pub fn here() -> Self {
        let read = |file: &str| std::fs::read_to_string(file).unwrap_or_default();
        let cpu = read("/proc/cpuinfo")
            .lines()
            .find_map(|line| line.strip_prefix("model name")?.split_once(':').map(|(_, name)| name.trim().to_owned()));
        let version = read("/proc/sys/kernel/osrelease");
        Self {
            cpu: cpu.unwrap_or_else(|| "unknown".to_owned()),
            threads: crate::render::default_threads().get(),
            system: [std::env::consts::OS, version.trim(), std::env::consts::ARCH]
                .into_iter()
                .filter(|part| !part.is_empty())
                .collect::<Vec<_>>()
                .join(" "),
            isa: Isa::best().name().to_owned(),
            load: read("/proc/loadavg").split(' ').next().and_then(|load| load.parse().ok()),
        }
    }
}

/// A hash of this very program, whose results another one may not have.
pub fn program() -> io::Result<u64> {
    Ok(xxh3_64(&std::env::current_exe().and_then(std::fs::read)?))
}

/// This moment in UTC, as RFC 3339 writes it.
pub fn date() -> String {
    let seconds = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs());
    rfc3339(seconds)
}

/// The calendar is Hinnant's `civil_from_days`: years that begin in March, in eras of 400.
fn rfc3339(seconds: u64) -> String {
    let days = seconds / 86_400 + 719_468;
    let (era, day) = (days / 146_097, days % 146_097);
    let year = (day - day / 1460 + day / 36_524 - day / 146_096) / 365;
    let day = day - (365 * year + year / 4 - year / 100);
    let march = (5 * day + 2) / 153;
    let month = if march < 10 { march + 3 } else { march - 9 };
    let (year, day) = (era * 400 + year + u64::from(month <= 2), day - (153 * march + 2) / 5 + 1);
    let (hour, minute, second) = (seconds / 3600 % 24, seconds / 60 % 60, seconds % 60);
    format!("{year:04}-{month:02}-{day:02}T{hour:02}:{minute:02}:{second:02}Z")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_moments() {
        let moments = [0, 951_782_400, 951_868_799, 1_709_164_800, 4_107_542_399].map(rfc3339);
        let expected = [
            "1970-01-01T00:00:00Z",
            "2000-02-29T00:00:00Z",
            "2000-02-29T23:59:59Z",
            "2024-02-29T00:00:00Z",
            "2100-02-28T23:59:59Z",
        ];
        assert_eq!(moments, expected);
    }
}
