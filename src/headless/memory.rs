//! Memory: what the process held, and what a picture needs. Known on Linux only.

/// Bytes that rendering a picture takes for each pixel: film 12, sums of samples 80, the map between rounds 16,
/// sRGB codes and PNG 3 each, and some for what is on its way between threads.
const BYTES_PER_PIXEL: u64 = 128;

/// A picture that is too large for this machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TooLarge {
    /// Bytes that it needs.
    pub needed: u64,
    /// Bytes that are free.
    pub available: u64,
}

/// Whether a picture of this size fits into the memory that is free now. Where that is not known, it is taken to.
pub fn check_memory(width: u32, height: u32) -> Result<(), TooLarge> {
    let needed = u64::from(width) * u64::from(height) * BYTES_PER_PIXEL;
    match field("/proc/meminfo", "MemAvailable:") {
        Some(available) if needed > available => Err(TooLarge { needed, available }),
        _ => Ok(()),
    }
}

/// Most memory that the process held so far, in bytes.
pub fn peak() -> Option<u64> {
    field("/proc/self/status", "VmHWM:")
}

/// Bytes that a line such as `name: 123 kB` of a file tells.
fn field(file: &str, name: &str) -> Option<u64> {
    let text = std::fs::read_to_string(file).ok()?;
    let value = text.lines().find_map(|line| line.strip_prefix(name))?;
    value.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()?.checked_mul(1024)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_small_picture_fits() {
        assert_eq!(check_memory(64, 64), Ok(()));
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn the_system_tells_what_the_process_held() {
        assert!(peak().unwrap() > 1 << 20);
        assert_eq!(field("/proc/meminfo", "NoSuchThing:"), None);
    }
}
