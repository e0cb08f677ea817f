//! Studies: speed and accuracy measured and drawn.
//!
//! A study renders through the same path as everything else, in a loop over settings, and ends in a [`Report`]: raw
//! samples, tables, [charts](chart::Chart). `clock` and [`Plan`] measure, [`metrics`] compares pictures.

mod accuracy;
mod clock;
mod console;
mod flip;
mod growth;
mod kernel;
mod machine;
mod measure;
mod memory;
mod plain;
mod reference;
mod report;
mod scale;
mod sweep;
mod table;
mod threads;
mod trial;

pub mod chart;
pub mod metrics;
pub mod stability;

pub use accuracy::accuracy;
pub use clock::{Clock, SystemClock};
pub use console::{Console, StudyError};
pub use growth::landscape;
pub use kernel::{KernelOptions, kernel};
pub use machine::Machine;
pub use measure::{Plan, PowerLaw, Stats, Timed};
pub use plain::plain;
pub use reference::default_cache;
pub use report::Report;
pub use scale::scale;
pub use sweep::Sweep;
pub use table::{Cell, Table, four_figures};
pub use threads::threads;
pub use trial::{Trial, render};
