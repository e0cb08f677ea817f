//! Room that workers trace in, kept from one render to the next.

use crate::shading::Scratch;
use std::sync::{Arc, Mutex, PoisonError};

/// Room for workers, for whoever starts one render after the other: a worker takes one and gives it back when it leaves.
/// (Half a megabyte in many pieces, made anew for each render, tore the heap to pieces: up to 20 KB an edit.)
#[derive(Clone, Debug, Default)]
pub struct Rooms(Arc<Mutex<Vec<Scratch>>>);

impl Rooms {
    pub(super) fn take(&self) -> Scratch {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).pop().unwrap_or_default()
    }

    pub(super) fn give(&self, room: Scratch) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).push(room);
    }
}
