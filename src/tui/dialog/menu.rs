//! The menu of things to add.

use super::prompt::accept_hints;
use crate::tui::color::{ColorMode, Role};
use crate::tui::command::Command;
use crate::tui::key::{Code, Key};
use crate::tui::keymap::Keymap;
use crate::tui::widget::{fit, popup, rows, window};
use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::text::{Line, Span};
use ratatui::widgets::Widget;

/// What can be added.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Addition {
    /// A ball.
    Sphere,
    /// A box.
    Cuboid,
    /// A cylinder.
    Cylinder,
    /// A cone.
    Cone,
    /// An endless floor.
    Plane,
    /// A rectangle.
    Quad,
    /// A mesh from a file that is asked for.
    Model,
    /// A light that shines from a point.
    PointLight,
    /// A light that shines from far away.
    DirectionalLight,
    /// A material.
    Material,
}

/// Letter, name and what it stands for.
pub const ADDITIONS: [(char, &str, Addition); 10] = [
    ('s', "sphere", Addition::Sphere),
    ('b', "cuboid (box)", Addition::Cuboid),
    ('c', "cylinder", Addition::Cylinder),
    ('k', "cone", Addition::Cone),
    ('p', "plane", Addition::Plane),
    ('q', "quad", Addition::Quad),
    ('f', "model from a file", Addition::Model),
    ('l', "point light", Addition::PointLight),
    ('d', "directional light", Addition::DirectionalLight),
    ('m', "material", Addition::Material),
];

/// Which line is chosen.
#[derive(Clone, Copy, Debug, Default)]
pub struct AddMenu {
    cursor: usize,
}

impl AddMenu {
    /// Takes a letter or a move; what was chosen.
    pub fn key(&mut self, key: Key, command: Option<Command>) -> Option<Addition> {
        match command {
            Some(Command::Step(by)) => {
                self.cursor = self.cursor.saturating_add_signed(by.into()).min(ADDITIONS.len() - 1);
                None
            }
            Some(Command::Accept) => Some(ADDITIONS[self.cursor].2),
            _ => ADDITIONS.iter().find(|(letter, ..)| key.code == Code::Char(*letter)).map(|(.., found)| *found),
        }
    }

    /// Draws the box.
    pub fn draw(self, mode: ColorMode, keymap: &Keymap, room: Rect, buffer: &mut Buffer) {
        let inner = popup(mode, room, "Add", &accept_hints(keymap), (28, ADDITIONS.len() as u16), buffer);
        let shown = window(ADDITIONS.len(), self.cursor, inner.height.into());
        for (index, area) in shown.zip(rows(inner)) {
            let (letter, name, _) = ADDITIONS[index];
            let chosen = index == self.cursor;
            let name = fit(name, usize::from(inner.width).saturating_sub(3));
            let (key, text) = if chosen { (Role::Cursor, Role::Cursor) } else { (Role::Key, Role::Text) };
            let spans = [Span::styled(format!("{letter}  "), mode.style(key)), Span::styled(name, mode.style(text))];
            Line::from(spans.to_vec()).render(area, buffer);
        }
    }
}
