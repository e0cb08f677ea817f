//! Studies: speed and accuracy measured and drawn.
//!
//! A study renders through the same path as everything else, in a loop over settings, and ends in a [`Report`]: raw
//! samples, tables, [charts](chart::Chart). `clock` and [`Plan`] measure, [`metrics`] compares pictures.

mod clock;
mod console;
mod flip;
mod kernel;
mod machine;
mod measure;
mod report;
mod table;
mod threads;
mod trial;

pub mod chart;
pub mod metrics;
pub mod stability;

pub use clock::{Clock, SystemClock};
pub use console::{Console, StudyError};
pub use kernel::{KernelOptions, kernel};
pub use machine::Machine;
pub use measure::{Plan, PowerLaw, Stats, Timed};
pub use report::Report;
pub use table::{Cell, Table, four_figures};
pub use threads::threads;
pub use trial::{Trial, render};
