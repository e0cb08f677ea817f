//! argv -> command -> exit code.

use glimt::description::printable;
use std::io::{self, Write};
use std::panic;
use std::process::ExitCode;

fn main() -> ExitCode {
    // Of any thread; the interface puts its own hook in place of this one while it owns the screen.
    panic::set_hook(Box::new(|panic| {
        let what = panic.to_string().replace('\n', " ");
        let _ = writeln!(io::stderr(), "glimt {}. This is a bug; please report it.", printable(&what));
    }));
    panic::catch_unwind(|| glimt::cli::run(std::env::args_os())).unwrap_or(ExitCode::FAILURE)
}
