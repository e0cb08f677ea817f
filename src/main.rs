//! argv -> command -> exit code.

use glimt::description::printable;
use std::io::{self, Write};
use std::panic;
use std::process::ExitCode;
use std::sync::{Arc, Mutex};

fn main() -> ExitCode {
    // A panic may be caught where it happens, so it is told at the end and only if the work has failed.
    let last_panic = Arc::new(Mutex::new(String::new()));
    let noted = Arc::clone(&last_panic);
    panic::set_hook(Box::new(move |panic| {
        if let Ok(mut noted) = noted.lock() {
            *noted = panic.to_string().replace('\n', " ");
        }
    }));
    let code = panic::catch_unwind(|| glimt::cli::run(std::env::args_os())).unwrap_or(ExitCode::FAILURE);
    match last_panic.lock() {
        Ok(panic) if code != ExitCode::SUCCESS && !panic.is_empty() => {
            let _ = writeln!(io::stderr(), "glimt {}. This is a bug; please report it.", printable(&panic));
        }
        _ => {}
    }
    code
}
