//! Mistakes in the TOML itself.

use super::report::{Report, Words};
use toml::de::Error;

/// Adds what the TOML parser found.
pub(super) fn add<'a>(report: &mut Report<'a>, errors: &[Error]) {
    for error in errors {
        let message = error.message().to_owned();
        report.mistake(error.span().unwrap_or(0..0), move || Words::new(message, ""));
    }
}
