//! What the picture shows if it is not light: a view of the scene or of its render.

use crate::render::{Film, Layers, Scale, TileImage, View};
use std::time::{Duration, Instant};

/// Painting the whole picture anew takes some milliseconds: so often at most while tiles come in.
const PERIOD: Duration = Duration::from_millis(100);

/// The view, its values as far as they are known, and their picture.
#[derive(Clone, Debug)]
pub struct Shown {
    view: View,
    size: (u32, u32),
    /// Of the render.
    layers: Layers,
    /// Of what is traced for the view.
    probed: Film,
    /// Both without pixels as long as they are not wanted.
    picture: Film,
    scale: Scale,
    /// Numbers of objects or materials in sight, in their order.
    seen: Vec<u32>,
    stale: bool,
    painted: Option<Instant>,
}

impl Shown {
    /// Shows light, of a film of this size.
    pub fn new(width: u32, height: u32) -> Self {
        Self {
            view: View::Final,
            size: (width, height),
            layers: Layers::new(width, height),
            probed: Film::new(0, 0),
            picture: Film::new(0, 0),
            scale: Scale::default(),
            seen: Vec::new(),
            stale: false,
            painted: None,
        }
    }

    /// The film has another size now.
    pub fn resize(&mut self, width: u32, height: u32) {
        let view = self.view;
        *self = Self::new(width, height);
        self.set_view(view);
    }

    /// Shows something else.
    pub fn set_view(&mut self, view: View) {
        self.view = view;
        // Values of another kind mean nothing.
        let (width, height) = if view.probe().is_some() { self.size } else { (0, 0) };
        (self.probed, self.picture) = (Film::new(width, height), Film::new(0, 0));
        self.force();
    }

    /// What is shown.
    pub fn view(&self) -> View {
        self.view
    }

    /// What the colours stand for.
    pub fn scale(&self) -> Scale {
        self.scale
    }

    /// Numbers of the objects or materials in sight.
    pub fn seen(&self) -> &[u32] {
        &self.seen
    }

    /// What the render tells of its pixels.
    pub fn layers(&self) -> &Layers {
        &self.layers
    }

    /// A tile of the render.
    pub fn rendered(&mut self, tile: TileImage) {
        self.layers.write(tile);
        self.stale |= self.view != View::Final && self.view.probe().is_none();
    }

    /// A tile of what is traced for the view.
    pub fn probed(&mut self, tile: &TileImage) {
        if self.view.probe().is_some() {
            self.probed.write(tile);
            self.stale = true;
        }
    }

    /// All tiles are there: they are shown without delay.
    pub fn force(&mut self) {
        (self.stale, self.painted) = (true, None);
    }

    /// The picture instead of the film; `None` where light is shown. With it whether it is another than before.
    pub fn refresh(&mut self, now: Instant) -> Option<(&Film, bool)> {
        if self.view == View::Final {
            return None;
        }
        let due = self.painted.is_none_or(|last| now.saturating_duration_since(last) >= PERIOD);
        let paint = self.stale && due;
        if paint {
            let known = self.layers.values(self.view);
            let values = known.as_ref().unwrap_or(&self.probed);
            (self.picture, self.scale) = self.view.paint(values);
            self.seen.clear();
            if matches!(self.view, View::Object | View::Material | View::NonFinite) {
                let numbers = values.pixels().iter().map(|value| value[0] as u32);
                self.seen = numbers.filter(|number| *number > 0).collect();
                if self.view != View::NonFinite {
                    self.seen.sort_unstable();
                    self.seen.dedup();
                }
            }
            (self.stale, self.painted) = (false, Some(now));
        }
        Some((&self.picture, paint))
    }
}
