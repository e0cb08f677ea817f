//! Signals that end a render.

#[cfg(unix)]
mod listen {
    use signal_hook::consts::{SIGINT, SIGTERM};
    use std::io;
    use std::sync::Arc;
    use std::sync::atomic::{AtomicUsize, Ordering};

    /// Remembers the last of SIGINT and SIGTERM instead of dying of it.
    pub struct Signals(Arc<AtomicUsize>);

    impl Signals {
        pub fn listen() -> io::Result<Self> {
            let caught = Arc::new(AtomicUsize::new(0));
            for signal in [SIGINT, SIGTERM] {
                signal_hook::flag::register_usize(signal, Arc::clone(&caught), signal as usize)?;
            }
            Ok(Self(caught))
        }

        /// The number of the signal that came, if one did.
        pub fn caught(&self) -> Option<u8> {
            u8::try_from(self.0.load(Ordering::Relaxed)).ok().filter(|number| *number != 0)
        }
    }

    pub fn name(number: u8) -> &'static str {
        signal_hook::low_level::signal_name(number.into()).unwrap_or("a signal")
    }
}

#[cfg(not(unix))]
mod listen {
    use std::io;

    /// Without Unix signals, Ctrl-C ends the process; nothing is written before the render is done.
    pub struct Signals;

    impl Signals {
        pub fn listen() -> io::Result<Self> {
            Ok(Self)
        }

        pub fn caught(&self) -> Option<u8> {
            None
        }
    }

    pub fn name(_number: u8) -> &'static str {
        "a signal"
    }
}

pub use listen::{Signals, name};
