//! What keys mean: one table that feeds dispatch, the help screen and the README.

use super::key::{Code, Key};

/// What the user wants done.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Command {
    /// Leave.
    Quit,
    /// Stop the workers, or let them go on.
    TogglePause,
    /// Render from the beginning.
    Restart,
    /// Write the PNG as the picture is now.
    SaveImage,
    /// Show or hide the help screen.
    ToggleHelp,
    /// Stop the program and return to the shell, until `fg`.
    Suspend,
    /// Send the whole screen again.
    Redraw,
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
    /// Steps larger.
    Zoom(i8),
    /// Show the whole picture.
    Fit,
    /// Move what is shown of a zoomed picture: steps to the right, and downward.
    Shift(i8, i8),
}

/// When a binding holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum When {
    /// Always.
    Always,
    /// While the whole picture is in view.
    Fitted,
    /// While a part of the picture is in view.
    Zoomed,
}

/// One line of the help screen: keys that belong together, and the command of each.
#[derive(Clone, Copy, Debug)]
pub struct Binding {
    /// Heading it stands under.
    pub group: &'static str,
    /// Keys in the order in which they are listed.
    pub keys: &'static [(Key, Command)],
    /// What they do, for people.
    pub help: &'static str,
    /// When they do it.
    pub when: When,
}

use Command::*;

/// Every binding. All keys are such as terminals have sent for decades, and none that tmux, screen or zellij take.
pub const BINDINGS: &[Binding] = &[
    always("General", &[(Key::char('q'), Quit), (Key::ctrl('c'), Quit)], "quit"),
    always("General", &[(Key::char(' '), TogglePause)], "pause, go on"),
    always("General", &[(Key::char('r'), Restart)], "render again"),
    always("General", &[(Key::char('s'), SaveImage)], "save the PNG now"),
    always("General", &[(Key::char('?'), ToggleHelp)], "show or hide the keys"),
    always("General", &[(Key::ctrl('l'), Redraw)], "draw the screen again"),
    always("General", &[(Key::ctrl('z'), Suspend)], "to the shell; fg returns"),
    Binding {
        when: When::Fitted,
        ..always(
            "Camera",
            &[
                (Key::plain(Code::Left), Orbit(-1, 0)),
                (Key::plain(Code::Down), Orbit(0, -1)),
                (Key::plain(Code::Up), Orbit(0, 1)),
                (Key::plain(Code::Right), Orbit(1, 0)),
            ],
            "orbit",
        )
    },
    always(
        "Camera",
        &[
            (Key::char('h'), Orbit(-1, 0)),
            (Key::char('j'), Orbit(0, -1)),
            (Key::char('k'), Orbit(0, 1)),
            (Key::char('l'), Orbit(1, 0)),
        ],
        "orbit",
    ),
    always(
        "Camera",
        &[
            (Key::char('H'), Pan(-1, 0)),
            (Key::char('J'), Pan(0, -1)),
            (Key::char('K'), Pan(0, 1)),
            (Key::char('L'), Pan(1, 0)),
        ],
        "pan",
    ),
    always(
        "Camera",
        &[
            (Key::shift(Code::Left), Pan(-1, 0)),
            (Key::shift(Code::Down), Pan(0, -1)),
            (Key::shift(Code::Up), Pan(0, 1)),
            (Key::shift(Code::Right), Pan(1, 0)),
        ],
        "pan",
    ),
    always("Camera", &[(Key::char('i'), Dolly(1)), (Key::char('o'), Dolly(-1))], "move in, out"),
    always("Camera", &[(Key::char('f'), Widen(-1)), (Key::char('F'), Widen(1))], "narrower, wider view"),
    always("Camera", &[(Key::char('c'), ResetCamera)], "the scene's own camera"),
    always(
        "Render",
        &[(Key::char('n'), Samples(1)), (Key::char('N'), Samples(-1))],
        "twice, half the samples; half, twice the error",
    ),
    always("Render", &[(Key::char('E'), ToggleAdaptive)], "samples where the error is"),
    always("Render", &[(Key::char('G'), ToggleChart)], "chart of the error"),
    always("Render", &[(Key::char('d'), Depth(1)), (Key::char('D'), Depth(-1))], "depth up, down"),
    always("Render", &[(Key::char('m'), CycleShading)], "next lighting model"),
    always(
        "Preview",
        &[(Key::char('+'), Zoom(1)), (Key::char('='), Zoom(1)), (Key::char('-'), Zoom(-1))],
        "larger, smaller",
    ),
    always("Preview", &[(Key::char('0'), Fit)], "the whole picture"),
    Binding {
        when: When::Zoomed,
        ..always(
            "Preview",
            &[
                (Key::plain(Code::Left), Shift(-1, 0)),
                (Key::plain(Code::Down), Shift(0, 1)),
                (Key::plain(Code::Up), Shift(0, -1)),
                (Key::plain(Code::Right), Shift(1, 0)),
            ],
            "move",
        )
    },
];

const fn always(group: &'static str, keys: &'static [(Key, Command)], help: &'static str) -> Binding {
    Binding { group, keys, help, when: When::Always }
}

impl Binding {
    /// Its keys as text: `q Ctrl-C`, `h j k l`, `Shift-←↓↑→`.
    pub fn keys_text(&self) -> String {
        if self.keys.iter().all(|(key, _)| key.shift) {
            let arrows = self.keys.iter().map(|(key, _)| Key::plain(key.code).to_string());
            return format!("Shift-{}", arrows.collect::<String>());
        }
        self.keys.iter().map(|(key, _)| key.to_string()).collect::<Vec<_>>().join(" ")
    }

    /// What it does and when, as text.
    pub fn help_text(&self) -> String {
        match self.when {
            When::Always => self.help.to_string(),
            When::Fitted => format!("{} (if not zoomed)", self.help),
            When::Zoomed => format!("{} (if zoomed)", self.help),
        }
    }
}

/// What `key` means now.
pub fn command_for(key: Key, zoomed: bool) -> Option<Command> {
    let holds = |when| match when {
        When::Always => true,
        When::Fitted => !zoomed,
        When::Zoomed => zoomed,
    };
    let candidates = BINDINGS.iter().filter(|binding| holds(binding.when));
    candidates.flat_map(|binding| binding.keys).find(|(bound, _)| *bound == key).map(|(_, command)| *command)
}

/// The key of `command` that is listed first: what the status line names.
pub fn key_of(command: Command) -> String {
    let all = BINDINGS.iter().flat_map(|binding| binding.keys);
    all.clone().find(|(_, bound)| *bound == command).map(|(key, _)| key.to_string()).unwrap_or_default()
}

/// The table as Markdown: what the README holds.
pub fn markdown() -> String {
    let mut text = String::from("| | Keys | What they do |\n|---|---|---|\n");
    let mut group = "";
    for binding in BINDINGS {
        let heading = if binding.group == group { "" } else { binding.group };
        group = binding.group;
        let keys = binding.keys.iter().map(|(key, _)| format!("`{key}`")).collect::<Vec<_>>().join(" ");
        text += &format!("| {heading} | {keys} | {} |\n", binding.help_text());
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_key_means_two_things_at_once() {
        for zoomed in [false, true] {
            for (key, command) in BINDINGS.iter().filter(|b| b.when == When::Always).flat_map(|b| b.keys) {
                assert_eq!(command_for(*key, zoomed), Some(*command), "{key}");
            }
        }
        assert_eq!(command_for(Key::plain(Code::Left), false), Some(Orbit(-1, 0)));
        assert_eq!(command_for(Key::plain(Code::Left), true), Some(Shift(-1, 0)));
    }

    #[test]
    fn no_binding_needs_more_than_a_legacy_terminal_or_what_multiplexers_take() {
        for (key, _) in BINDINGS.iter().flat_map(|binding| binding.keys) {
            let taken = ['a', 'b', 'g', 'h', 'n', 'o', 'p', 'q', 's', 't', 'i', 'j', 'm'].map(Key::ctrl);
            assert!(!taken.contains(key) && !key.alt && key.code != Code::Other, "{key}");
            // Escape cannot be told from the beginning of a split sequence.
            assert!(key.code != Code::Escape, "{key}");
        }
    }
}
