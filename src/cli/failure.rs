//! What went wrong, and whose fault it is.

use crate::description::{Diagnostic, printable};
use std::fmt::Display;

/// Why a command ends without having done its work.
#[derive(Debug)]
pub enum Failure {
    /// Bad arguments, a bad scene or a bad model: what to change, in one line.
    Asked(String),
    /// Mistakes in a scene file.
    Scene(Vec<Diagnostic>),
    /// The machine or glimt failed.
    CouldNot(String),
    /// A signal ended it.
    Signal {
        /// Its number.
        number: u8,
        /// What that cut off.
        message: String,
    },
}

impl Failure {
    /// The scene or the arguments are wrong.
    pub fn asked(error: impl Display) -> Self {
        Self::Asked(error.to_string())
    }

    /// The work failed.
    pub fn could_not(error: impl Display) -> Self {
        Self::CouldNot(error.to_string())
    }

    /// 1 could not, 2 asked wrongly, 128 + the number of a signal.
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::CouldNot(_) => 1,
            Self::Asked(_) | Self::Scene(_) => 2,
            Self::Signal { number, .. } => 128 + number,
        }
    }

    /// For stderr, with escape sequences if `color`; without a newline at the end.
    pub fn render(&self, color: bool) -> String {
        let (red, plain) = if color { ("\x1b[1;31m", "\x1b[0m") } else { ("", "") };
        match self {
            Self::Asked(message) | Self::CouldNot(message) => format!("{red}error{plain}: {}", printable(message)),
            Self::Signal { message, .. } => message.clone(),
            Self::Scene(mistakes) => {
                let shown: Vec<_> = mistakes.iter().map(|mistake| mistake.render(color)).collect();
                shown.join("\n\n")
            }
        }
    }
}
