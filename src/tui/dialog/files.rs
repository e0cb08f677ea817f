//! The file picker: directories, and the files that can be opened.

use crate::description::printable;
use crate::tui::color::{ColorMode, Role};
use crate::tui::command::Command;
use crate::tui::field::Field;
use crate::tui::key::{Code, Key};
use crate::tui::preview::UPPER_HALF;
use crate::tui::widget::{fit, rows, window};
use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::text::{Line, Span};
use ratatui::widgets::Widget;
use std::ffi::OsString;
use std::path::{Path, PathBuf};

/// What a directory holds that is worth showing.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Entry {
    /// Files come after directories.
    pub is_file: bool,
    /// As the system spells it.
    pub name: OsString,
}

/// A picture made small.
#[derive(Clone, Debug, PartialEq)]
pub struct Thumbnail {
    /// Size of the picture itself, texels.
    pub size: (u32, u32),
    /// Of the small one.
    pub width: usize,
    /// sRGB codes, row by row.
    pub pixels: Vec<[u8; 3]>,
}

/// Largest side of a [`Thumbnail`].
pub const THUMBNAIL: usize = 48;

/// What the picker wants done.
#[derive(Clone, Debug, PartialEq)]
pub enum Wish {
    /// Tell what this directory holds.
    List(PathBuf),
    /// Another row is under the cursor.
    Look(PathBuf),
    /// This file was chosen.
    Take(PathBuf),
}

/// A list of files.
#[derive(Clone, Debug)]
pub struct Files {
    directory: PathBuf,
    /// `None` until it is known.
    entries: Option<Result<Vec<Entry>, String>>,
    filter: Field,
    cursor: usize,
}

/// Names of files that are wanted end in one of these, in any case.
pub fn ends_in(name: &Path, endings: &[&str]) -> bool {
    let ending = name.extension().map(|ending| ending.to_string_lossy().to_lowercase());
    ending.is_some_and(|ending| endings.contains(&ending.as_str()))
}

impl Files {
    /// Begins in a directory, whose content has to be asked for.
    pub fn new(directory: &Path) -> Self {
        Self { directory: directory.to_owned(), entries: None, filter: Field::default(), cursor: 0 }
    }

    /// Where it is.
    pub fn directory(&self) -> &Path {
        &self.directory
    }

    /// Takes in what a directory holds. What comes late, of another one, is dropped. Tells what is to be looked at.
    pub fn listed(&mut self, directory: &Path, entries: Result<Vec<Entry>, String>) -> Option<Wish> {
        if directory == self.directory {
            self.entries = Some(entries.map(|mut entries| {
                entries.sort();
                entries
            }));
            self.cursor = 0;
        }
        self.look()
    }

    /// Rows: the way up, then what fits the filter.
    fn shown(&self) -> Vec<Option<&Entry>> {
        let wanted = self.filter.text().to_lowercase();
        let entries = self.entries.iter().flatten().flatten();
        let fits = entries.filter(|entry| entry.name.to_string_lossy().to_lowercase().contains(&wanted));
        let up = (wanted.is_empty() && self.directory.parent().is_some()).then_some(None);
        up.into_iter().chain(fits.map(Some)).collect()
    }

    fn path(&self, entry: Option<&Entry>) -> PathBuf {
        match entry {
            Some(entry) => self.directory.join(&entry.name),
            None => self.directory.parent().unwrap_or(&self.directory).to_owned(),
        }
    }

    fn look(&self) -> Option<Wish> {
        let entry = self.shown().get(self.cursor).copied()??;
        entry.is_file.then(|| Wish::Look(self.path(Some(entry))))
    }

    fn enter(&mut self, directory: PathBuf) -> Option<Wish> {
        *self = Self::new(&directory);
        Some(Wish::List(directory))
    }

    /// Takes a key that is typed or moves.
    pub fn key(&mut self, key: Key, command: Option<Command>) -> Option<Wish> {
        let count = self.shown().len();
        let step = |by: isize| self.cursor.saturating_add_signed(by).min(count.saturating_sub(1));
        match command {
            Some(Command::Step(rows)) => self.cursor = step(rows.into()),
            Some(Command::Page(pages) | Command::StepFar(pages)) => self.cursor = step(isize::from(pages) * 10),
            Some(Command::Accept) => {
                let entry = self.shown().get(self.cursor).copied()?;
                let path = self.path(entry);
                return match entry {
                    Some(entry) if entry.is_file => Some(Wish::Take(path)),
                    _ => self.enter(path),
                };
            }
            _ if key.code == Code::Backspace && self.filter.is_empty() => {
                let parent = self.directory.parent()?.to_owned();
                return self.enter(parent);
            }
            _ if self.filter.key(key) => self.cursor = 0,
            _ => return None,
        }
        self.look()
    }

    /// Takes pasted text: a filter.
    pub fn paste(&mut self, text: &str) -> Option<Wish> {
        self.filter.paste(text);
        self.cursor = 0;
        self.look()
    }

    /// Draws path, filter and list.
    pub fn draw(&self, mode: ColorMode, area: Rect, buffer: &mut Buffer) {
        let width = usize::from(area.width);
        let mut lines = rows(area);
        let path = self.directory.to_string_lossy();
        let path = printable(&path);
        // The end of a path tells more than its beginning.
        let skipped = path.chars().count().saturating_sub(width);
        let path: String = path.chars().skip(skipped).collect();
        if let Some(row) = lines.next() {
            Line::styled(fit(&path, width), mode.style(Role::Dim)).render(row, buffer);
        }
        if let Some(row) = lines.next() {
            let mut spans = vec![Span::styled("/ ", mode.style(Role::Key))];
            spans.extend(self.filter.spans(width.saturating_sub(2), mode.style(Role::Text)));
            Line::from(spans).render(row, buffer);
        }
        let shown = self.shown();
        let note = match &self.entries {
            None => Some(("reading…".to_owned(), Role::Dim)),
            Some(Err(reason)) => Some((printable(reason).into_owned(), Role::Bad)),
            Some(Ok(_)) if shown.is_empty() => Some(("nothing here fits".to_owned(), Role::Dim)),
            Some(Ok(_)) => None,
        };
        let range = window(shown.len(), self.cursor, usize::from(area.height).saturating_sub(3));
        for (index, row) in range.zip(lines.by_ref()) {
            let (name, role) = match shown[index] {
                None => ("../".into(), Role::Dim),
                Some(entry) => {
                    let name = entry.name.to_string_lossy();
                    let name = printable(&name);
                    if entry.is_file { (name.into_owned(), Role::Text) } else { (format!("{name}/"), Role::Strong) }
                }
            };
            let role = if index == self.cursor { Role::Cursor } else { role };
            Line::styled(fit(&name, width), mode.style(role)).render(row, buffer);
        }
        if let (Some((note, role)), Some(row)) = (note, lines.next()) {
            Line::styled(fit(&note, width), mode.style(role)).render(row, buffer);
        }
    }
}

impl Thumbnail {
    /// Makes a picture small: every pixel is that in the middle of its box.
    pub fn new((width, height): (u32, u32), texels: &[[u8; 3]]) -> Self {
        let largest = width.max(height).max(1) as usize;
        let small = |side: u32| (side as usize * THUMBNAIL / largest).clamp(1, THUMBNAIL);
        let (across, down) = (small(width), small(height));
        let texel = |x: usize, y: usize| {
            let (x, y) = ((2 * x + 1) * width as usize / (2 * across), (2 * y + 1) * height as usize / (2 * down));
            texels.get(y * width as usize + x).copied().unwrap_or_default()
        };
        let pixels = (0..down).flat_map(|y| (0..across).map(move |x| (x, y))).map(|(x, y)| texel(x, y)).collect();
        Self { size: (width, height), width: across, pixels }
    }

    /// Draws it into `area` as large as fits, two pixels a cell.
    pub fn draw(&self, mode: ColorMode, area: Rect, buffer: &mut Buffer) {
        let height = self.pixels.len() / self.width.max(1);
        let scale = (f64::from(area.width) / self.width as f64).min(2.0 * f64::from(area.height) / height as f64);
        let (across, down) = ((self.width as f64 * scale) as u16, (height as f64 * scale) as u16);
        let pixel = |x: u16, y: u16| {
            let part =
                |at: u16, of: u16, count: usize| (2 * usize::from(at) + 1) * count / (2 * usize::from(of.max(1)));
            let (x, y) = (part(x, across, self.width), part(y.min(down.saturating_sub(1)), down, height));
            self.pixels.get(y * self.width + x).copied().unwrap_or_default()
        };
        for y in 0..down.div_ceil(2) {
            for x in 0..across {
                if let Some(cell) = buffer.cell_mut((area.x + x, area.y + y)) {
                    let (upper, lower) = (pixel(x, 2 * y), pixel(x, 2 * y + 1));
                    if mode == ColorMode::None {
                        let light = |c: [u8; 3]| c.iter().map(|c| u32::from(*c)).sum::<u32>();
                        let shade = (light(upper) + light(lower)) as usize * 5 / (6 * 256);
                        cell.set_symbol([" ", "░", "▒", "▓", "█"][shade.min(4)]);
                    } else {
                        cell.set_symbol(UPPER_HALF).set_fg(mode.color(upper)).set_bg(mode.color(lower));
                    }
                }
            }
        }
    }
}
