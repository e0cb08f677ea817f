//! Views of the scene and its render, and why a pixel has its colour.

use super::{App, Tone};
use crate::render::{RenderEvent, View, explain};
use crate::tui::dialog::{Dialog, Rays};
use crate::tui::event::Effect;
use crate::tui::shown::Shown;
use std::time::Instant;

impl App {
    /// What the picture shows.
    pub fn shown(&self) -> &Shown {
        &self.shown
    }

    /// Shows something else.
    pub fn show(&mut self, view: View) -> Vec<Effect> {
        self.shown.set_view(view);
        self.preview.mark_all();
        self.tell(Tone::Plain, format!("view: {}", view.name()));
        vec![self.probe()]
    }

    /// What has to be traced for the view.
    pub(super) fn probe(&self) -> Effect {
        Effect::Probe(self.scene.clone().zip(self.shown.view().probe()))
    }

    /// What was traced for the view.
    pub(super) fn probed(&mut self, event: RenderEvent) {
        match event {
            RenderEvent::TileFinished { tile, .. } => self.shown.probed(&tile),
            RenderEvent::Finished => self.shown.force(),
            RenderEvent::Failed(error) => self.tell(Tone::Bad, error.to_string()),
            RenderEvent::TileStarted { .. } | RenderEvent::Estimated { .. } => {}
        }
    }

    /// Brings the picture up to date.
    pub(super) fn refresh_picture(&mut self, now: Instant) {
        match self.shown.refresh(now) {
            Some((picture, is_new)) => {
                if is_new {
                    self.preview.mark_all();
                }
                self.preview.refresh(picture);
            }
            None => self.preview.refresh(&self.film),
        }
    }

    /// Shows the rays of the pixel under the cursor, or that was clicked last, or in the middle.
    pub(super) fn explain(&mut self) {
        let Some(scene) = self.scene.clone() else {
            self.tell(Tone::Plain, "nothing is known here yet".into());
            return;
        };
        let under_cursor = self.cursor.and_then(|(x, y)| self.preview.film_pixel(x, y));
        let middle = (scene.width / 2, scene.height / 2);
        let (x, y) = under_cursor.or(self.clicked).unwrap_or(middle);
        let (x, y) = (x.min(scene.width - 1), y.min(scene.height - 1));
        let explanation = explain(&scene, self.editor.desc(), (x, y), 1, None);
        let samples = self.shown.layers().samples(x, y).max(1);
        self.dialog = Some(Dialog::Rays(Rays::new(&explanation, self.film.pixel(x, y), samples)));
    }
}
