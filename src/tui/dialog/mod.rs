//! Boxes over the screen that take the keys until they are closed.

mod adviser;
pub mod color;
pub mod files;
mod help;
mod menu;
mod palette;
mod prompt;
mod rays;
mod texture;

pub use adviser::Adviser;
pub use color::ColorDialog;
pub use files::{Files, Wish};
pub use help::Help;
pub use menu::{ADDITIONS, AddMenu, Addition};
pub use palette::Palette;
pub use prompt::{About, Prompt, Purpose, Question, accept_hints};
pub use rays::Rays;
pub use texture::{Ask, MODELS, PICTURES, ROWS, TextureDialog};

use crate::description::Target;

/// What is open.
#[derive(Clone, Debug)]
pub enum Dialog {
    /// All keys.
    Help(Help),
    /// All commands.
    Palette(Palette),
    /// What the scene does not need.
    Adviser(Adviser),
    /// What to add.
    Add(AddMenu),
    /// A line of text.
    Prompt(Prompt),
    /// A model to add.
    Model(Files),
    /// A colour: of these targets, the parameter of this label.
    Color(ColorDialog, Vec<Target>, &'static str),
    /// A texture of these materials.
    Texture(TextureDialog, Vec<Target>),
    /// Why a pixel has its colour.
    Rays(Rays),
    /// One key answers.
    Question(Question),
}
