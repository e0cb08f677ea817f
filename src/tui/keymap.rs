//! Which keys are bound to which command here: the table, changed by the user's own file.

use super::bindings::BINDINGS;
use super::command::{Action, Binding, Command, Scope};
use super::key::Key;
use crate::description::printable;
use directories::ProjectDirs;
use std::collections::BTreeMap;
use std::io::ErrorKind;
use std::path::PathBuf;
use toml::de::{DeTable, DeValue};

/// The keys of every action.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Keymap {
    /// By name of the action; those that are missing have the keys of the table.
    changed: BTreeMap<String, Vec<Key>>,
}

/// Where the user's own keys are written: `~/.config/glimt/keys.toml`. `None` without a home.
pub fn file() -> Option<PathBuf> {
    ProjectDirs::from("", "", "glimt").map(|directories| directories.config_dir().join("keys.toml"))
}

/// The table as the user's own file changes it. No file changes nothing.
///
/// # Errors
/// What is wrong with the file: name, line, and what to do.
pub fn load() -> Result<Keymap, String> {
    let Some(file) = file() else { return Ok(Keymap::default()) };
    let name = file.to_string_lossy();
    let text = match std::fs::read_to_string(&file) {
        Ok(text) => text,
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(Keymap::default()),
        Err(error) => return Err(format!("cannot read {}: {error}", printable(&name))),
    };
    Keymap::parse(&text).map_err(|(line, mistake)| format!("{}:{line}: {}", printable(&name), printable(&mistake)))
}

impl Keymap {
    /// Reads lines such as `undo = "u"` and `redo = ["U", "Ctrl-R"]`; an empty list takes a command its keys away. A
    /// mistake comes with its line.
    pub fn parse(text: &str) -> Result<Self, (usize, String)> {
        let line = |at: usize| 1 + text.as_bytes()[..at.min(text.len())].iter().filter(|byte| **byte == b'\n').count();
        let table = DeTable::parse(text)
            .map_err(|error| (line(error.span().map_or(0, |span| span.start)), error.message().to_owned()))?;
        let mut map = Self::default();
        let mut lines = BTreeMap::new();
        for (name, value) in table.get_ref() {
            let at = line(name.span().start);
            let name = name.get_ref().as_ref();
            if !actions().any(|(_, action)| action.name() == name) {
                let alike = |action: &Action| strsim::jaro_winkler(&action.name(), name);
                let nearest = actions().map(|(_, action)| action).max_by(|a, b| alike(a).total_cmp(&alike(b)));
                let nearest = nearest.map(Action::name).unwrap_or_default();
                return Err((
                    at,
                    format!("there is no command {name}; did you mean {nearest}? (glimt keys lists them)"),
                ));
            }
            let key = |value: &DeValue| -> Result<Key, (usize, String)> {
                let text =
                    value.as_str().ok_or_else(|| (at, format!("{name} needs a key in quotes, or a list of them")))?;
                text.parse().map_err(|advice| (at, format!("\"{text}\" is no key; {advice}")))
            };
            let keys = match value.get_ref() {
                DeValue::Array(keys) => keys.iter().map(|value| key(value.get_ref())).collect::<Result<_, _>>()?,
                value => vec![key(value)?],
            };
            lines.insert(name.to_owned(), at);
            map.changed.insert(name.to_owned(), keys);
        }
        map.check().map_err(|(name, mistake)| (lines.get(&name).copied().unwrap_or(1), mistake))?;
        Ok(map)
    }

    /// Whether a key means two things at once, or nothing is left to leave with.
    fn check(&self) -> Result<(), (String, String)> {
        let bound: Vec<_> = actions()
            .flat_map(|(binding, action)| self.keys(action).iter().map(move |key| (binding.scope, *key, action)))
            .collect();
        for (i, (scope, key, action)) in bound.iter().enumerate() {
            for (other_scope, other_key, other) in &bound[..i] {
                let together = scope.open().contains(other_scope) || other_scope.open().contains(scope);
                if key == other_key && together && action.command != other.command {
                    let changed = if self.changed.contains_key(&action.name()) { action } else { other };
                    let mistake = format!("{key} would mean both {} and {}", action.name(), other.name());
                    return Err((changed.name(), mistake));
                }
            }
        }
        for (scope, command) in [(Scope::Screen, Command::Quit), (Scope::Dialog, Command::Cancel)] {
            if !bound.iter().any(|(s, _, action)| *s == scope && action.command == command) {
                let name = actions().find(|(b, a)| b.scope == scope && a.command == command).map(|(_, a)| a.name());
                let name = name.unwrap_or_default();
                return Err((name.clone(), format!("{name} needs a key: there would be no way out")));
            }
        }
        Ok(())
    }

    /// Keys of an action of the table.
    pub fn keys<'a>(&'a self, action: &'a Action) -> &'a [Key] {
        self.changed.get(&action.name()).map_or(action.keys, Vec::as_slice)
    }

    /// What `key` means where the keys of `scope` hold.
    pub fn find(&self, key: Key, scope: Scope) -> Option<Command> {
        let of = |scope: Scope| actions().filter(move |(binding, _)| binding.scope == scope);
        let mut open = scope.open().iter().flat_map(|scope| of(*scope));
        open.find(|(_, action)| self.keys(action).contains(&key)).map(|(_, action)| action.command)
    }

    /// The key of `command` that is listed first, in any scope: what the screen names. Empty if it has none.
    pub fn key_of(&self, command: Command) -> String {
        let keys = actions().filter(|(_, action)| action.command == command).flat_map(|(_, action)| self.keys(action));
        keys.map(ToString::to_string).next().unwrap_or_default()
    }

    /// The same where only the keys of `scope` are asked for.
    pub fn key_in(&self, scope: Scope, command: Command) -> String {
        let here = actions().filter(|(binding, action)| binding.scope == scope && action.command == command);
        here.flat_map(|(_, action)| self.keys(action)).map(ToString::to_string).next().unwrap_or_default()
    }

    /// Keys of a line of the help screen as text: `q Ctrl-C`, `←↓↑→ h j k l`.
    pub fn text(&self, binding: &Binding) -> String {
        let lists: Vec<_> = binding.actions.iter().map(|action| self.keys(action)).collect();
        let ranks = lists.iter().map(|keys| keys.len()).max().unwrap_or(0);
        let nth = |rank: usize| -> Vec<String> {
            lists.iter().filter_map(|keys| keys.get(rank)).map(ToString::to_string).collect()
        };
        (0..ranks).map(|rank| shortened(&nth(rank))).collect::<Vec<_>>().join(" ")
    }

    /// The table as Markdown: what the README holds.
    pub fn markdown(&self) -> String {
        let mut text = String::from("| | Keys | What they do | Names in `keys.toml` |\n|---|---|---|---|\n");
        let mut group = "";
        for binding in BINDINGS {
            let heading = if binding.group == group { "" } else { binding.group };
            group = binding.group;
            let keys = binding.actions.iter().flat_map(|action| self.keys(action));
            let keys: Vec<_> = keys.map(|key| format!("`{key}`")).collect();
            let names: Vec<_> = binding.actions.iter().map(|action| format!("`{}`", action.name())).collect();
            let (keys, names) = (keys.join(" "), names.join(" "));
            text += &format!("| {heading} | {keys} | {} | {names} |\n", binding.help_text());
        }
        text
    }

    /// The table for a terminal: keys, name in the configuration file, what it does.
    pub fn table(&self) -> String {
        let mut text = String::new();
        let mut group = "";
        for (binding, action) in actions() {
            if group != binding.group {
                text += &format!("{}{}\n", if group.is_empty() { "" } else { "\n" }, binding.group);
                group = binding.group;
            }
            let keys = self.keys(action).iter().map(ToString::to_string).collect::<Vec<_>>().join(" ");
            text += format!("  {keys:<16} {:<26} {}", action.name(), binding.scope.text()).trim_end();
            text.push('\n');
        }
        text
    }
}

/// `Shift-←↓↑→` for `Shift-←`, `Shift-↓` and so on; single characters that are arrows or neighbours stand together.
fn shortened(keys: &[String]) -> String {
    let arrow = |key: &String| ["←", "→", "↑", "↓"].iter().any(|arrow| key.ends_with(arrow));
    if keys.len() > 1 && keys.iter().all(arrow) {
        let held = |key: &String| key.trim_end_matches(['←', '→', '↑', '↓']).to_owned();
        if keys.iter().all(|key| held(key) == held(&keys[0])) {
            let arrows = keys.iter().filter_map(|key| key.chars().last());
            return held(&keys[0]) + &arrows.collect::<String>();
        }
    }
    if keys.len() > 4 {
        return format!("{}–{}", keys[0], keys[keys.len() - 1]);
    }
    keys.join(" ")
}

/// Every action of the table with the line that it stands in.
pub fn actions() -> impl Iterator<Item = (&'static Binding, &'static Action)> {
    BINDINGS.iter().flat_map(|binding| binding.actions.iter().map(move |action| (binding, action)))
}

impl Binding {
    /// What it does and where, as text.
    pub fn help_text(&self) -> String {
        match self.scope.text() {
            "" => self.help.to_owned(),
            scope => format!("{} ({scope})", self.help),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tui::key::Code;

    #[test]
    fn no_key_of_the_table_means_two_things_at_once() {
        assert_eq!(Keymap::default().check(), Ok(()));
        let map = Keymap::default();
        for (binding, action) in actions() {
            for key in action.keys {
                assert_eq!(map.find(*key, binding.scope), Some(action.command), "{key}: {}", action.title);
            }
        }
        assert_eq!(map.find(Key::plain(Code::Left), Scope::Fitted), Some(Command::Orbit(-1, 0)));
        assert_eq!(map.find(Key::plain(Code::Left), Scope::Zoomed), Some(Command::Shift(-1, 0)));
        assert_eq!(map.find(Key::char('q'), Scope::Dialog), None);
    }

    #[test]
    fn a_file_changes_keys() {
        let map = Keymap::parse("# mine\nundo = \"Ctrl-U\"\nsave-scene = [\"w\", 'Ctrl-W']\npause = []\n").unwrap();
        assert_eq!(map.find(Key::ctrl('u'), Scope::Tree), Some(Command::Undo));
        assert_eq!(map.find(Key::char('u'), Scope::Tree), None);
        assert_eq!(map.find(Key::ctrl('w'), Scope::Fitted), Some(Command::SaveScene));
        assert_eq!(map.key_of(Command::Undo), "Ctrl-U");
        assert_eq!(map.key_in(Scope::Screen, Command::TogglePause), "");
        assert!(map.markdown().contains("`Ctrl-U`") && map.table().contains("Ctrl-U           undo"));
        assert_eq!(Keymap::parse(""), Ok(Keymap::default()));
    }

    #[test]
    fn mistakes_in_the_file_are_told_with_line_and_advice() {
        for (text, line, words) in [
            ("\nunod = \"u\"", 2, "did you mean undo?"),
            ("undo = 3", 1, "undo needs a key in quotes"),
            ("undo = [\"u\", true]", 1, "undo needs a key in quotes"),
            ("quit = \"q\"\nundo = \"Hyper-u\"", 2, "is no key; write it as"),
            ("a = ", 1, ""),
            ("redo = \"R\"\n\nundo = \"q\"", 3, "q would mean both"),
            ("quit = []", 1, "quit needs a key"),
            ("leave-as-it-was = []", 1, "needs a key"),
        ] {
            let (found, mistake) = Keymap::parse(text).unwrap_err();
            assert!(found == line && mistake.contains(words), "{text}: {found}: {mistake}");
        }
    }
}
