//! Memory that the process holds. Known on Linux only.

use std::fs;

/// Bytes that are held now, and the most that were held since `forget_peak`.
pub(super) fn held_and_peak() -> Option<(u64, u64)> {
    let status = fs::read_to_string("/proc/self/status").ok()?;
    let field = |name: &str| {
        let value = status.lines().find_map(|line| line.strip_prefix(name))?;
        value.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()?.checked_mul(1024)
    };
    Some((field("VmRSS:")?, field("VmHWM:")?))
}

/// Lets the peak begin anew at what is held now (proc_pid_clear_refs(5)). Where that cannot be, peaks stay what they
/// were.
pub(super) fn forget_peak() {
    let _ = fs::write("/proc/self/clear_refs", "5");
}
