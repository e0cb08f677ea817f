//! What the view and the session read.

use super::{Activity, App, Focus, Message};
use crate::bvh::Isa;
use crate::description::{SceneDesc, printable};
use crate::render::{Film, Progress};
use crate::tui::chart;
use crate::tui::color::ColorMode;
use crate::tui::command::Scope;
use crate::tui::dialog::Dialog;
use crate::tui::editor::Editor;
use crate::tui::event::Exit;
use crate::tui::keymap::Keymap;
use crate::tui::layout::Layout;
use crate::tui::numbers::Numbers;
use crate::tui::preview::Preview;
use crate::tui::transform::Transform;
use std::sync::Arc;
use std::time::Duration;

impl App {
    /// As it is edited now.
    pub fn desc(&self) -> &SceneDesc {
        self.editor.desc()
    }

    /// Name of the scene, safe to print.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Colours of the terminal.
    pub fn mode(&self) -> ColorMode {
        self.mode
    }

    /// Where things stand on the screen.
    pub fn layout(&self) -> &Layout {
        &self.layout
    }

    /// Columns and rows of the screen.
    pub fn size(&self) -> (u16, u16) {
        self.size
    }

    /// The picture in cells.
    pub fn preview(&self) -> &Preview {
        &self.preview
    }

    /// The picture in pixels.
    pub fn film(&self) -> &Arc<Film> {
        &self.film
    }

    /// The numbers to show.
    pub fn numbers(&self) -> Option<&Numbers> {
        self.numbers.as_ref()
    }

    /// The instruction set that rays are traced with, once there is a scene.
    pub fn isa(&self) -> Option<Isa> {
        self.scene.as_ref().map(|scene| scene.isa())
    }

    /// The command that shows the rays of a pixel of this picture outside of the interface, safe to print.
    pub fn explain_command(&self, (x, y): (u32, u32)) -> String {
        let file = self.editor.file().map_or(String::new(), |file| format!("{} ", printable(&file.to_string_lossy())));
        let (render, film) = (&self.desc().render, &self.film);
        format!(
            "glimt explain {file}--pixel {x},{y} --size {}x{} --samples {} --numerics {} --shading {} --shadows {} --max-depth {}",
            film.width(),
            film.height(),
            render.samples,
            render.numerics.name(),
            render.shading.name(),
            render.shadows.name(),
            render.max_depth
        )
    }

    /// What is going on.
    pub fn activity(&self) -> Activity {
        self.activity
    }

    /// Time from the last edit to the first whole picture of it.
    pub fn latency(&self) -> Option<Duration> {
        self.latency
    }

    /// The last thing the user should know.
    pub fn message(&self) -> Option<&Message> {
        self.message.as_ref()
    }

    /// What became of the picture.
    pub fn note(&self) -> Option<&Message> {
        self.note.as_ref()
    }

    /// What is edited and selected.
    pub fn editor(&self) -> &Editor {
        &self.editor
    }

    /// What each key means.
    pub fn keymap(&self) -> &Keymap {
        &self.keymap
    }

    /// The dialog that is open.
    pub fn dialog(&self) -> Option<&Dialog> {
        self.dialog.as_ref()
    }

    /// Which part has the keys when nothing else takes them.
    pub fn focus(&self) -> Focus {
        self.focus
    }

    /// The move, turn or scale that is under way.
    pub fn transform(&self) -> Option<&Transform> {
        self.transform.as_ref()
    }

    /// The pixel of the preview that the cursor is on, while there is one.
    pub fn cursor(&self) -> Option<(usize, usize)> {
        self.cursor
    }

    /// Whether the search of the tree is being typed.
    pub fn is_searching(&self) -> bool {
        self.searching
    }

    /// Why the scene's file cannot be shown as it is on the disk.
    pub fn broken_file(&self) -> Option<&[String]> {
        self.broken_file.as_deref()
    }

    /// Whose keys hold now.
    pub fn scope(&self) -> Scope {
        if self.dialog.is_some() || self.searching || self.editor.properties.entry.is_some() {
            Scope::Dialog
        } else if self.transform.is_some() {
            Scope::Transform
        } else if self.cursor.is_some() {
            Scope::Pick
        } else {
            match self.focus {
                Focus::Picture if self.is_zoomed() => Scope::Zoomed,
                Focus::Picture => Scope::Fitted,
                Focus::Tree => Scope::Tree,
                Focus::Properties => Scope::Properties,
            }
        }
    }

    /// Whether the chart of the error is open: by itself where it has a place of its own.
    pub fn shows_chart(&self) -> bool {
        self.chart.unwrap_or_else(|| chart::place(&self.layout).is_some_and(|place| place.is_free))
    }

    /// Whether only a part of the picture is shown.
    pub fn is_zoomed(&self) -> bool {
        self.preview.zoom() > 1.0
    }

    /// Where pictures go, safe to print.
    pub fn output_text(&self) -> String {
        printable(&self.output.to_string_lossy()).into_owned()
    }

    /// Whether the picture shown is the last one of its render: its colours have to be exact.
    pub fn is_final(&self) -> bool {
        self.activity == Activity::Finished
    }

    /// Whether clocks on the screen run.
    pub fn is_running(&self) -> bool {
        matches!(self.activity, Activity::Compiling | Activity::Rendering)
    }

    /// Why the interface ends, when it does.
    pub fn exit(&self) -> Option<&Exit> {
        self.exit.as_ref()
    }

    /// The last save: how much of the picture was done, or why it failed.
    pub fn saved(&self) -> Option<&Result<u32, String>> {
        self.saved.as_ref()
    }

    /// Whether a save is under way.
    pub fn is_saving(&self) -> bool {
        self.saves_running > 0
    }

    /// Whole percent of the running or finished render.
    pub fn percent(&self) -> u32 {
        self.progress.as_ref().map_or(0, Progress::percent)
    }
}
