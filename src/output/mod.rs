//! Pictures to files, whole or not at all.

mod atomic;
mod png;

pub use atomic::{check_target, write_whole};
pub use png::{encode_png, save_png};
