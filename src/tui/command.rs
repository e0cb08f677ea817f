//! What a person can ask for, and where its keys hold.

use super::key::Key;
use crate::render::View;

/// What the user wants done.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Command {
    /// Leave; asks about changes that are not saved.
    Quit,
    /// Show or hide the help screen.
    ToggleHelp,
    /// Find a command by its name.
    OpenPalette,
    /// The next (1) or the previous (-1) part of the screen gets the keys.
    Focus(i8),
    /// Show or hide the tree and the properties.
    TogglePanel,
    /// Show or hide the numbers.
    ToggleNumbers,
    /// Take the last change back.
    Undo,
    /// Do again what was taken back.
    Redo,
    /// Write the scene to its file.
    SaveScene,
    /// Write the scene to a file to be named.
    SaveSceneAs,
    /// Write the PNG as the picture is now.
    SaveImage,
    /// Measure what the scene does not need.
    Advise,
    /// Stop the workers, or let them go on.
    TogglePause,
    /// Render from the beginning.
    Restart,
    /// Send the whole screen again.
    Redraw,
    /// Stop the program and return to the shell, until `fg`.
    Suspend,
    /// Open the menu of things to add.
    Add,
    /// Move, turn or scale the selection.
    Transform(Motion),
    /// Hide or show the selection.
    ToggleHidden,
    /// Give the selected thing another name.
    Rename,
    /// A copy of each selected thing.
    Duplicate,
    /// Remove the selection.
    Delete,
    /// Move the selected thing in its list: steps down.
    Reorder(i8),
    /// Choose the colour of the selection.
    EditColor,
    /// Choose the texture of the selection.
    EditTexture,
    /// Move a cursor over the picture to pick with.
    PickMode,
    /// Tell why a pixel has its colour.
    Explain,
    /// The next (1) or the previous (-1) view of scene and render.
    CycleView(i8),
    /// This view.
    ShowView(View),
    /// Move the eye about the point looked at: steps to the right, and upward.
    Orbit(i8, i8),
    /// Move eye and point looked at: steps to the right, and upward.
    Pan(i8, i8),
    /// Steps toward the point looked at.
    Dolly(i8),
    /// Steps to a wider angle of view.
    Widen(i8),
    /// Back to the camera of the scene file.
    ResetCamera,
    /// The selection fills the view.
    Frame,
    /// Keep the camera under a digit.
    StoreView,
    /// The camera that was kept under a digit.
    RecallView(u8),
    /// Samples a pixel: doublings.
    Samples(i8),
    /// Samples where the error is, or the same everywhere.
    ToggleAdaptive,
    /// Show or hide the chart of the error.
    ToggleChart,
    /// Reflections and refractions along a path: how many more.
    Depth(i8),
    /// The next lighting model.
    CycleShading,
    /// So many more threads.
    Threads(i8),
    /// Steps larger.
    Zoom(i8),
    /// Show the whole picture.
    Fit,
    /// Move what is shown of a zoomed picture: steps to the right, and downward.
    Shift(i8, i8),
    /// Search the tree.
    Filter,
    /// Mark or unmark the row of the tree.
    Mark,
    /// Mark rows while moving: steps down.
    Extend(i8),
    /// Move in a list: rows down.
    Step(i8),
    /// Move in a list: screens down.
    Page(i8),
    /// To the beginning (-1) or the end (1) of a list.
    Ends(i8),
    /// To the right (1) or to the left (-1): nudge a value, move a cursor.
    Turn(i8),
    /// The same by a large step.
    TurnFar(i8),
    /// Up or down by a large step.
    StepFar(i8),
    /// Yes; enter; take this.
    Accept,
    /// No; back; leave everything as it was.
    Cancel,
    /// Back to the value that it has where nothing is written.
    Reset,
    /// Along which axis.
    Axis(u8),
    /// The axes of the world, or those of the view.
    ToggleViewAxes,
}

/// Ways to transform objects.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Motion {
    /// Translation.
    Move,
    /// Rotation.
    Rotate,
    /// Scaling.
    Scale,
}

/// Where a key has its meaning.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Scope {
    /// Whatever is open.
    Anywhere,
    /// On the screen, whatever part has the keys; no dialog is open.
    Screen,
    /// The picture has the keys.
    Picture,
    /// The picture has the keys, and all of it is in view.
    Fitted,
    /// The picture has the keys, and a part of it is in view.
    Zoomed,
    /// The tree has the keys.
    Tree,
    /// The properties have the keys.
    Properties,
    /// The selection is being moved, turned or scaled.
    Transform,
    /// A cursor is on the picture.
    Pick,
    /// A dialog is open. Characters without a meaning are typed.
    Dialog,
}

impl Scope {
    /// When its keys hold, for people; empty: always.
    pub fn text(self) -> &'static str {
        match self {
            Self::Anywhere | Self::Screen => "",
            Self::Picture => "in the picture",
            Self::Fitted => "in the picture, not zoomed",
            Self::Zoomed => "in the picture, zoomed",
            Self::Tree => "in the tree",
            Self::Properties => "in the properties",
            Self::Transform => "while moving, turning, scaling",
            Self::Pick => "while picking",
            Self::Dialog => "in dialogs",
        }
    }

    /// Scopes whose keys hold at the same time as those of this one, itself first.
    pub fn open(self) -> &'static [Self] {
        match self {
            Self::Fitted => &[Self::Fitted, Self::Picture, Self::Screen, Self::Anywhere],
            Self::Zoomed => &[Self::Zoomed, Self::Picture, Self::Screen, Self::Anywhere],
            Self::Picture => &[Self::Picture, Self::Screen, Self::Anywhere],
            Self::Tree => &[Self::Tree, Self::Screen, Self::Anywhere],
            Self::Properties => &[Self::Properties, Self::Screen, Self::Anywhere],
            Self::Transform => &[Self::Transform, Self::Anywhere],
            Self::Pick => &[Self::Pick, Self::Anywhere],
            Self::Dialog => &[Self::Dialog, Self::Anywhere],
            Self::Screen => &[Self::Screen, Self::Anywhere],
            Self::Anywhere => &[Self::Anywhere],
        }
    }
}

/// A command with its name and its keys.
#[derive(Clone, Copy, Debug)]
pub struct Action {
    /// What it does: the line of the palette; with `-` for spaces, its name in the configuration file.
    pub title: &'static str,
    /// What is done.
    pub command: Command,
    /// The first one is the one that the screen names.
    pub keys: &'static [Key],
}

/// One line of the help screen: actions that belong together.
#[derive(Clone, Copy, Debug)]
pub struct Binding {
    /// Heading it stands under.
    pub group: &'static str,
    /// Where its keys hold.
    pub scope: Scope,
    /// What its keys do, for people.
    pub help: &'static str,
    /// In the order in which their keys are listed.
    pub actions: &'static [Action],
}

impl Action {
    /// Its name in the configuration file: `save-scene-as`.
    pub fn name(&self) -> String {
        self.title.replace(' ', "-")
    }
}
