//! Every command with its keys: the one table that feeds dispatch, the help screen, the palette, the configuration file
//! and the README.

use super::command::{Action, Binding, Command, Motion, Scope};
use super::key::{Code, Key};
use crate::render::View;
use Command::*;

const UP: Key = Key::plain(Code::Up);
const DOWN: Key = Key::plain(Code::Down);
const LEFT: Key = Key::plain(Code::Left);
const RIGHT: Key = Key::plain(Code::Right);
const ENTER: Key = Key::plain(Code::Enter);
const ESCAPE: Key = Key::plain(Code::Escape);
const FAR_UP: Key = Key::shift(Code::Up);
const FAR_DOWN: Key = Key::shift(Code::Down);
const FAR_LEFT: Key = Key::shift(Code::Left);
const FAR_RIGHT: Key = Key::shift(Code::Right);
const BACK: Key = Key::plain(Code::Backspace);
/// For terminals and links on which Escape is slow or lost.
const AWAY: Key = Key::ctrl('x');

const fn key(c: char) -> Key {
    Key::char(c)
}

const fn row(group: &'static str, scope: Scope, help: &'static str, actions: &'static [Action]) -> Binding {
    Binding { group, scope, help, actions }
}

const fn act(title: &'static str, command: Command, keys: &'static [Key]) -> Action {
    Action { title, command, keys }
}

/// Every command. All keys are such as terminals have sent for decades, and none that tmux, screen or zellij take but
/// Ctrl-P, which many know from elsewhere and beside which there is another.
pub const BINDINGS: &[Binding] = &[
    row("General", Scope::Screen, "quit", &[act("quit", Quit, &[key('q')])]),
    row("General", Scope::Anywhere, "quit, out of dialogs too", &[act("quit from anywhere", Quit, &[Key::ctrl('c')])]),
    row("General", Scope::Screen, "all keys", &[act("help", ToggleHelp, &[key('?')])]),
    row("General", Scope::Screen, "find a command", &[act("find a command", OpenPalette, &[key(':'), Key::ctrl('p')])]),
    row(
        "General",
        Scope::Screen,
        "picture, tree, properties",
        &[
            act("next part", Focus(1), &[Key::plain(Code::Tab)]),
            act("previous part", Focus(-1), &[Key::shift(Code::Tab)]),
        ],
    ),
    row("General", Scope::Screen, "show or hide the panel", &[act("show or hide the panel", TogglePanel, &[key('b')])]),
    row(
        "General",
        Scope::Screen,
        "show or hide the numbers",
        &[act("show or hide the numbers", ToggleNumbers, &[key('B')])],
    ),
    row("General", Scope::Anywhere, "draw the screen again", &[act("draw again", Redraw, &[Key::ctrl('l')])]),
    row("General", Scope::Anywhere, "to the shell; fg returns", &[act("to the shell", Suspend, &[Key::ctrl('z')])]),
    row(
        "File",
        Scope::Screen,
        "undo, redo",
        &[act("undo", Undo, &[key('u')]), act("redo", Redo, &[key('U'), Key::ctrl('r')])],
    ),
    row(
        "File",
        Scope::Screen,
        "save the scene, save as",
        &[act("save scene", SaveScene, &[key('w')]), act("save scene as", SaveSceneAs, &[key('W')])],
    ),
    row("File", Scope::Screen, "save the PNG now", &[act("save picture", SaveImage, &[key('s')])]),
    row("File", Scope::Screen, "what the scene does not need", &[act("advise", Advise, &[key('A')])]),
    row("Selection", Scope::Screen, "add", &[act("add", Add, &[key('a')])]),
    row(
        "Selection",
        Scope::Screen,
        "move, turn, scale",
        &[
            act("move", Transform(Motion::Move), &[key('g')]),
            act("turn", Transform(Motion::Rotate), &[key('t')]),
            act("scale", Transform(Motion::Scale), &[key('z')]),
        ],
    ),
    row("Selection", Scope::Screen, "hide or show", &[act("hide or show", ToggleHidden, &[key('v')])]),
    row("Selection", Scope::Screen, "rename", &[act("rename", Rename, &[key('e')])]),
    row("Selection", Scope::Screen, "duplicate", &[act("duplicate", Duplicate, &[key('y')])]),
    row("Selection", Scope::Screen, "delete", &[act("delete", Delete, &[key('x'), Key::plain(Code::Delete)])]),
    row(
        "Selection",
        Scope::Screen,
        "up, down in its list",
        &[act("move up in the list", Reorder(-1), &[key('<')]), act("move down in the list", Reorder(1), &[key('>')])],
    ),
    row(
        "Selection",
        Scope::Screen,
        "colour, texture",
        &[act("choose colour", EditColor, &[key('C')]), act("choose texture", EditTexture, &[key('T')])],
    ),
    row(
        "Camera",
        Scope::Fitted,
        "orbit",
        &[
            act("orbit left", Orbit(-1, 0), &[LEFT]),
            act("orbit down", Orbit(0, -1), &[DOWN]),
            act("orbit up", Orbit(0, 1), &[UP]),
            act("orbit right", Orbit(1, 0), &[RIGHT]),
        ],
    ),
    row(
        "Camera",
        Scope::Picture,
        "orbit",
        &[
            act("turn the eye left", Orbit(-1, 0), &[key('h')]),
            act("turn the eye down", Orbit(0, -1), &[key('j')]),
            act("turn the eye up", Orbit(0, 1), &[key('k')]),
            act("turn the eye right", Orbit(1, 0), &[key('l')]),
        ],
    ),
    row(
        "Camera",
        Scope::Picture,
        "pan",
        &[
            act("pan left", Pan(-1, 0), &[FAR_LEFT, key('H')]),
            act("pan down", Pan(0, -1), &[FAR_DOWN, key('J')]),
            act("pan up", Pan(0, 1), &[FAR_UP, key('K')]),
            act("pan right", Pan(1, 0), &[FAR_RIGHT, key('L')]),
        ],
    ),
    row(
        "Camera",
        Scope::Screen,
        "nearer, farther",
        &[act("nearer", Dolly(1), &[key('i')]), act("farther", Dolly(-1), &[key('o')])],
    ),
    row(
        "Camera",
        Scope::Screen,
        "narrower, wider view",
        &[act("narrower view", Widen(-1), &[key('f')]), act("wider view", Widen(1), &[key('F')])],
    ),
    row("Camera", Scope::Screen, "the file's own camera", &[act("reset camera", ResetCamera, &[key('c')])]),
    row("Camera", Scope::Screen, "frame the selection", &[act("frame selection", Frame, &[key('.')])]),
    row("Camera", Scope::Screen, "keep the view (then 1-9)", &[act("keep view", StoreView, &[key('V')])]),
    row(
        "Camera",
        Scope::Screen,
        "views kept",
        &[
            act("view 1", RecallView(1), &[key('1')]),
            act("view 2", RecallView(2), &[key('2')]),
            act("view 3", RecallView(3), &[key('3')]),
            act("view 4", RecallView(4), &[key('4')]),
            act("view 5", RecallView(5), &[key('5')]),
            act("view 6", RecallView(6), &[key('6')]),
            act("view 7", RecallView(7), &[key('7')]),
            act("view 8", RecallView(8), &[key('8')]),
            act("view 9", RecallView(9), &[key('9')]),
        ],
    ),
    row("Render", Scope::Screen, "pause, go on", &[act("pause", TogglePause, &[key('p')])]),
    row("Render", Scope::Picture, "pause, go on", &[act("pause the render", TogglePause, &[key(' ')])]),
    row("Render", Scope::Screen, "render again", &[act("render again", Restart, &[key('r')])]),
    row(
        "Render",
        Scope::Screen,
        "twice, half the samples; half, twice the error",
        &[act("twice the samples", Samples(1), &[key('n')]), act("half the samples", Samples(-1), &[key('N')])],
    ),
    row(
        "Render",
        Scope::Screen,
        "samples where the error is",
        &[act("samples where the error is", ToggleAdaptive, &[key('E')])],
    ),
    row("Render", Scope::Screen, "chart of the error", &[act("chart of the error", ToggleChart, &[key('G')])]),
    row(
        "Render",
        Scope::Screen,
        "depth up, down",
        &[act("more depth", Depth(1), &[key('d')]), act("less depth", Depth(-1), &[key('D')])],
    ),
    row(
        "Render",
        Scope::Screen,
        "fewer, more threads",
        &[act("fewer threads", Threads(-1), &[key('[')]), act("more threads", Threads(1), &[key(']')])],
    ),
    row("Render", Scope::Screen, "next lighting model", &[act("next lighting model", CycleShading, &[key('m')])]),
    row("Picture", Scope::Picture, "pick with a cursor", &[act("pick", PickMode, &[ENTER])]),
    row(
        "Picture",
        Scope::Screen,
        "larger, smaller",
        &[act("zoom in", Zoom(1), &[key('+'), key('=')]), act("zoom out", Zoom(-1), &[key('-')])],
    ),
    row(
        "Picture",
        Scope::Screen,
        "next, previous view: normals, depth, ...",
        &[
            act("show next view", CycleView(1), &[key(')')]),
            act("show previous view", CycleView(-1), &[key('(')]),
            act("show light", ShowView(View::Final), &[]),
            act("show normals", ShowView(View::Normals), &[]),
            act("show depth", ShowView(View::Depth), &[]),
            act("show texture coordinates", ShowView(View::Uv), &[]),
            act("show objects", ShowView(View::Object), &[]),
            act("show materials", ShowView(View::Material), &[]),
            act("show samples per pixel", ShowView(View::Samples), &[]),
            act("show rays per pixel", ShowView(View::Rays), &[]),
            act("show hierarchy visits", ShowView(View::Visits), &[]),
            act("show time per pixel", ShowView(View::Time), &[]),
            act("show estimated error", ShowView(View::Error), &[]),
            act("show samples not finite", ShowView(View::NonFinite), &[]),
        ],
    ),
    row("Picture", Scope::Screen, "why this colour?", &[act("why this colour", Explain, &[key('Y')])]),
    row("Picture", Scope::Screen, "the whole picture", &[act("whole picture", Fit, &[key('0')])]),
    row(
        "Picture",
        Scope::Zoomed,
        "move",
        &[
            act("show more left", Shift(-1, 0), &[LEFT]),
            act("show more below", Shift(0, 1), &[DOWN]),
            act("show more above", Shift(0, -1), &[UP]),
            act("show more right", Shift(1, 0), &[RIGHT]),
        ],
    ),
    row(
        "Picking",
        Scope::Pick,
        "move the cursor",
        &[
            act("cursor left", Turn(-1), &[LEFT, key('h')]),
            act("cursor down", Step(1), &[DOWN, key('j')]),
            act("cursor up", Step(-1), &[UP, key('k')]),
            act("cursor right", Turn(1), &[RIGHT, key('l')]),
        ],
    ),
    row(
        "Picking",
        Scope::Pick,
        "by eight",
        &[
            act("cursor far left", TurnFar(-1), &[FAR_LEFT, key('H')]),
            act("cursor far down", StepFar(1), &[FAR_DOWN, key('J')]),
            act("cursor far up", StepFar(-1), &[FAR_UP, key('K')]),
            act("cursor far right", TurnFar(1), &[FAR_RIGHT, key('L')]),
        ],
    ),
    row(
        "Picking",
        Scope::Pick,
        "select, add to the selection",
        &[act("pick this", Accept, &[ENTER]), act("pick this too", Mark, &[key(' ')])],
    ),
    row("Picking", Scope::Pick, "why this colour?", &[act("why this pixel", Explain, &[key('Y')])]),
    row("Picking", Scope::Pick, "end", &[act("end picking", Cancel, &[ESCAPE, AWAY, key('q')])]),
    row(
        "Tree",
        Scope::Tree,
        "up, down",
        &[act("row up", Step(-1), &[UP, key('k')]), act("row down", Step(1), &[DOWN, key('j')])],
    ),
    row(
        "Tree",
        Scope::Tree,
        "a screen up, down",
        &[
            act("rows up", Page(-1), &[Key::plain(Code::PageUp)]),
            act("rows down", Page(1), &[Key::plain(Code::PageDown)]),
        ],
    ),
    row(
        "Tree",
        Scope::Tree,
        "first, last",
        &[act("first row", Ends(-1), &[Key::plain(Code::Home)]), act("last row", Ends(1), &[Key::plain(Code::End)])],
    ),
    row(
        "Tree",
        Scope::Tree,
        "fold, open a group",
        &[act("fold the group", Turn(-1), &[LEFT, key('h')]), act("open the group", Turn(1), &[RIGHT, key('l')])],
    ),
    row("Tree", Scope::Tree, "mark", &[act("mark", Mark, &[key(' ')])]),
    row(
        "Tree",
        Scope::Tree,
        "mark while moving",
        &[act("mark up", Extend(-1), &[FAR_UP, key('K')]), act("mark down", Extend(1), &[FAR_DOWN, key('J')])],
    ),
    row("Tree", Scope::Screen, "search the tree", &[act("search the tree", Filter, &[key('/')])]),
    row("Tree", Scope::Tree, "to the properties", &[act("to the properties", Accept, &[ENTER])]),
    row("Tree", Scope::Tree, "unmark; end the search", &[act("unmark all", Cancel, &[ESCAPE, AWAY])]),
    row(
        "Properties",
        Scope::Properties,
        "up, down",
        &[act("property up", Step(-1), &[UP, key('k')]), act("property down", Step(1), &[DOWN, key('j')])],
    ),
    row(
        "Properties",
        Scope::Properties,
        "a screen up, down",
        &[
            act("properties up", Page(-1), &[Key::plain(Code::PageUp)]),
            act("properties down", Page(1), &[Key::plain(Code::PageDown)]),
        ],
    ),
    row(
        "Properties",
        Scope::Properties,
        "first, last",
        &[
            act("first property", Ends(-1), &[Key::plain(Code::Home)]),
            act("last property", Ends(1), &[Key::plain(Code::End)]),
        ],
    ),
    row(
        "Properties",
        Scope::Properties,
        "less, more",
        &[act("less", Turn(-1), &[LEFT, key('h')]), act("more", Turn(1), &[RIGHT, key('l')])],
    ),
    row(
        "Properties",
        Scope::Properties,
        "much less, more",
        &[act("much less", TurnFar(-1), &[FAR_LEFT, key('H')]), act("much more", TurnFar(1), &[FAR_RIGHT, key('L')])],
    ),
    row("Properties", Scope::Properties, "type a value", &[act("type a value", Accept, &[ENTER])]),
    row("Properties", Scope::Properties, "the default value", &[act("default value", Reset, &[BACK])]),
    row("Properties", Scope::Properties, "to the tree", &[act("to the tree", Cancel, &[ESCAPE, AWAY])]),
    row(
        "Moving",
        Scope::Transform,
        "axis (again: none)",
        &[
            act("along x", Axis(0), &[key('x')]),
            act("along y", Axis(1), &[key('y')]),
            act("along z", Axis(2), &[key('z')]),
        ],
    ),
    row("Moving", Scope::Transform, "world or view axes", &[act("view axes", ToggleViewAxes, &[key('v')])]),
    row(
        "Moving",
        Scope::Transform,
        "nudge",
        &[
            act("nudge left", Turn(-1), &[LEFT, key('h')]),
            act("nudge down", Step(1), &[DOWN, key('j')]),
            act("nudge up", Step(-1), &[UP, key('k')]),
            act("nudge right", Turn(1), &[RIGHT, key('l')]),
        ],
    ),
    row(
        "Moving",
        Scope::Transform,
        "by large steps",
        &[
            act("nudge far left", TurnFar(-1), &[FAR_LEFT, key('H')]),
            act("nudge far down", StepFar(1), &[FAR_DOWN, key('J')]),
            act("nudge far up", StepFar(-1), &[FAR_UP, key('K')]),
            act("nudge far right", TurnFar(1), &[FAR_RIGHT, key('L')]),
        ],
    ),
    row(
        "Moving",
        Scope::Transform,
        "keep, take back",
        &[
            act("keep the move", Accept, &[ENTER, key(' ')]),
            act("take the move back", Cancel, &[ESCAPE, AWAY, key('q')]),
        ],
    ),
    row(
        "Dialogs",
        Scope::Dialog,
        "up, down",
        &[act("dialog up", Step(-1), &[UP]), act("dialog down", Step(1), &[DOWN])],
    ),
    row(
        "Dialogs",
        Scope::Dialog,
        "less, more",
        &[act("dialog left", Turn(-1), &[LEFT]), act("dialog right", Turn(1), &[RIGHT])],
    ),
    row(
        "Dialogs",
        Scope::Dialog,
        "much less, more",
        &[act("dialog far left", TurnFar(-1), &[FAR_LEFT]), act("dialog far right", TurnFar(1), &[FAR_RIGHT])],
    ),
    row(
        "Dialogs",
        Scope::Dialog,
        "a screen up, down",
        &[
            act("dialog page up", Page(-1), &[Key::plain(Code::PageUp)]),
            act("dialog page down", Page(1), &[Key::plain(Code::PageDown)]),
        ],
    ),
    row(
        "Dialogs",
        Scope::Dialog,
        "next, previous field",
        &[
            act("next field", Focus(1), &[Key::plain(Code::Tab)]),
            act("previous field", Focus(-1), &[Key::shift(Code::Tab)]),
        ],
    ),
    row(
        "Dialogs",
        Scope::Dialog,
        "take, leave as it was",
        &[act("take", Accept, &[ENTER]), act("leave as it was", Cancel, &[ESCAPE, AWAY])],
    ),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_binding_needs_more_than_a_legacy_terminal_or_what_multiplexers_take() {
        for action in BINDINGS.iter().flat_map(|binding| binding.actions) {
            for (i, key) in action.keys.iter().enumerate() {
                // tmux: B; screen: A; zellij: B G H N O P Q S T; a terminal sends Tab, Enter and line feed as I M J; V
                // and S Q are the line discipline's.
                let taken = ['a', 'b', 'g', 'h', 'n', 'o', 'p', 'q', 's', 't', 'i', 'j', 'm', 'v'].map(Key::ctrl);
                // The one exception has a key before it that nobody takes.
                let excused = *key == Key::ctrl('p') && i > 0;
                assert!((!taken.contains(key) || excused) && !key.alt && key.code != Code::Other, "{key}");
                // Escape may come late or not at all.
                assert!(key.code != Code::Escape || action.keys.len() > 1, "{}", action.title);
            }
        }
    }

    /// Keys that hold everywhere must not do something else where a mode is open, unless they say what they do there:
    /// axes by their letters, `v` for the view, and what leaves. Arrows and their letters move whatever is open.
    #[test]
    fn a_key_of_a_mode_does_not_mean_something_else_on_the_screen() {
        let moves = |command: Command| matches!(command, Turn(_) | TurnFar(_) | Step(_) | StepFar(_));
        let keys_of = |scope: Scope| {
            let rows = BINDINGS.iter().filter(move |binding| binding.scope == scope);
            let actions = rows.flat_map(|binding| binding.actions);
            actions.flat_map(|action| action.keys.iter().map(|key| (*key, action.command))).collect::<Vec<_>>()
        };
        for (mode, excused) in [(Scope::Pick, "q"), (Scope::Transform, "xyzvq"), (Scope::Dialog, "")] {
            for (key, command) in keys_of(mode) {
                let is_excused = matches!(key.code, Code::Char(c) if excused.contains(c));
                for (_, other) in keys_of(Scope::Screen).into_iter().filter(|(other, _)| *other == key) {
                    let same = other == command || moves(command) || matches!((command, other), (Focus(_), Focus(_)));
                    assert!(same || is_excused, "{key} while {}: {command:?}, elsewhere {other:?}", mode.text());
                }
            }
        }
    }

    #[test]
    fn every_name_stands_for_one_action_and_every_action_but_views_by_name_has_a_key() {
        let actions: Vec<_> = BINDINGS.iter().flat_map(|binding| binding.actions).collect();
        for (i, action) in actions.iter().enumerate() {
            let by_name = matches!(action.command, ShowView(_));
            assert!(!action.keys.is_empty() || by_name, "{}", action.title);
            assert!(actions[..i].iter().all(|other| other.name() != action.name()), "{}", action.title);
        }
    }
}
