//! The texture dialog: pictures in a directory, the one under the cursor made small, how it is wrapped and scaled.

use super::files::{Files, Thumbnail, Wish};
use super::prompt::accept_hints;
use crate::description::printable;
use crate::tui::color::{ColorMode, Role};
use crate::tui::command::Command;
use crate::tui::key::Key;
use crate::tui::keymap::Keymap;
use crate::tui::widget::{fit, popup};
use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::text::{Line, Span};
use ratatui::widgets::Widget;
use std::path::{Path, PathBuf};

/// Endings of pictures that can be read.
pub const PICTURES: &[&str] = &["png", "jpg", "jpeg", "bmp", "tga"];
/// Endings of models that can be read.
pub const MODELS: &[&str] = &["obj"];

/// Parameters of the material that stand beside the picture, by label.
pub const ROWS: [&str; 3] = ["wrap", "texture scale u", "texture scale v"];

/// A texture being chosen.
#[derive(Clone, Debug)]
pub struct TextureDialog {
    /// Where pictures are looked for.
    pub files: Files,
    /// The picture under the cursor, with its file, or why there is none.
    look: Option<(PathBuf, Option<Result<Thumbnail, String>>)>,
    /// Which of [`ROWS`] has the keys; `None`: the list of files.
    row: Option<usize>,
}

/// What the dialog wants done.
#[derive(Clone, Debug, PartialEq)]
pub enum Ask {
    /// Of the files.
    Files(Wish),
    /// Turn the parameter of this label by so many steps, fine or not.
    Nudge(&'static str, i32, bool),
    /// Keep everything.
    Keep,
}

impl TextureDialog {
    /// Begins in a directory.
    pub fn new(directory: &Path) -> Self {
        Self { files: Files::new(directory), look: None, row: None }
    }

    /// Takes a key.
    pub fn key(&mut self, key: Key, command: Option<Command>) -> Option<Ask> {
        match (command, self.row) {
            (Some(Command::Focus(by)), row) => {
                let now = row.map_or(0, |row| row + 1) as isize + isize::from(by);
                self.row = (now.rem_euclid(ROWS.len() as isize + 1) as usize).checked_sub(1);
                None
            }
            (Some(Command::Step(by)), Some(row)) => {
                self.row = row.checked_add_signed(by.into()).filter(|row| *row < ROWS.len());
                None
            }
            (Some(Command::Turn(by)), Some(row)) => Some(Ask::Nudge(ROWS[row], by.into(), true)),
            (Some(Command::TurnFar(by)), Some(row)) => Some(Ask::Nudge(ROWS[row], by.into(), false)),
            (Some(Command::Accept), Some(_)) => Some(Ask::Keep),
            (_, Some(_)) => None,
            (_, None) => {
                let wish = self.files.key(key, command)?;
                match &wish {
                    // To what is left to be said about the picture.
                    Wish::Take(_) => self.row = Some(0),
                    Wish::Look(file) => self.looking_at(file),
                    Wish::List(_) => self.look = None,
                }
                Some(Ask::Files(wish))
            }
        }
    }

    /// The picture that is asked for.
    pub fn looking_at(&mut self, file: &Path) {
        self.look = Some((file.to_owned(), None));
    }

    /// A picture has come; one that is not looked at any more is dropped.
    pub fn looked(&mut self, file: &Path, picture: Result<Thumbnail, String>) {
        if let Some((wanted, found)) = &mut self.look
            && wanted == file
        {
            *found = Some(picture);
        }
    }

    /// Draws the box. `values`: those of [`ROWS`], where they apply.
    pub fn draw(&self, mode: ColorMode, keymap: &Keymap, values: &[Option<String>], room: Rect, buffer: &mut Buffer) {
        let size = (room.width.saturating_sub(8).min(90), room.height.saturating_sub(4).min(26));
        let inner = popup(mode, room, "Texture", &accept_hints(keymap), size, buffer);
        let list = Rect { width: inner.width / 2, ..inner };
        self.files.draw(mode, list, buffer);
        let right = Rect { x: list.right() + 2, width: (inner.width - list.width).saturating_sub(2), ..inner };
        let rows = (ROWS.len() as u16 + 2).min(right.height);
        let picture = Rect { height: right.height - rows, ..right };
        let note = match &self.look {
            Some((_, Some(Ok(thumbnail)))) => {
                thumbnail.draw(mode, picture, buffer);
                format!("{}×{}", thumbnail.size.0, thumbnail.size.1)
            }
            Some((_, Some(Err(reason)))) => printable(reason).into_owned(),
            Some((_, None)) => "reading…".into(),
            None => String::new(),
        };
        let width = usize::from(right.width);
        let line = |i: u16| Rect { y: picture.bottom() + i, height: u16::from(i < rows), ..right };
        Line::styled(fit(&note, width), mode.style(Role::Dim)).render(line(0), buffer);
        for (i, (label, value)) in ROWS.iter().zip(values).enumerate() {
            let chosen = self.row == Some(i);
            let spans = vec![
                Span::styled(if chosen { "▸ " } else { "  " }, mode.style(Role::Key)),
                Span::styled(format!("{label:<17}"), mode.style(if chosen { Role::Strong } else { Role::Dim })),
                Span::raw(value.clone().unwrap_or_else(|| "–".into())),
            ];
            Line::from(spans).render(line(i as u16 + 2), buffer);
        }
    }
}
