//! From a compiled scene to a stream of finished tiles.
//!
//! [`start`] hands the scene to worker threads and returns a [`RenderHandle`] at once. Tiles come back by value over
//! the handle's own channel; a [`Film`] collects them into the picture, a [`Progress`] into numbers. The picture is a
//! function of the scene alone: bit-identical for any thread count, tile size, pause and resume.

mod batch;
mod census;
mod control;
mod convergence;
mod event;
mod explain;
mod film;
mod forecast;
mod job;
mod layers;
mod map;
mod pass;
mod pixel;
mod points;
mod progress;
mod rect;
mod rooms;
mod round;
mod scatter;
mod stopwatch;
mod thin;
mod tile;
mod view;

pub use crate::shading::RayCounts;
pub use batch::BATCH;
pub use event::{Cut, ErrorChange, RenderError, RenderEvent, TileImage, TileStats};
pub use explain::{Explanation, explain};
pub use film::Film;
pub use forecast::Eta;
pub use job::{RenderHandle, Settings, default_threads, start, start_in, start_probe};
pub use layers::Layers;
pub use pass::Pass;
pub use points::FilmPoints;
pub use progress::{Progress, WorkerProgress};
pub use rect::Rect;
pub use rooms::Rooms;
pub use scatter::JUDGED;
pub use tile::{Tile, blocks};
pub use view::{Scale, View, index_color, viridis};
