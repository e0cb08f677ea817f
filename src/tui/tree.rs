//! The tree of the scene: rows, cursor, marks, folding, search.

use super::color::{ColorMode, Role};
use super::dialog::color::codes_of;
use super::field::Field;
use super::widget::{fit, rows, window};
use crate::description::{LightKind, SceneDesc, ShapeDesc, Target};
use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::Style;
use ratatui::text::{Line, Span};
use ratatui::widgets::Widget;

/// What is selected, and how the tree is shown.
#[derive(Clone, Debug)]
pub struct Tree {
    cursor: Target,
    /// In the order in which they were marked.
    marked: Vec<Target>,
    /// What names must contain to be shown.
    filter: Option<Field>,
    /// Groups that were folded or opened by hand.
    folded: [Option<bool>; Group::ALL.len()],
}

/// Entries that stand together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Group {
    /// What there is one of.
    Scene,
    /// Objects.
    Objects,
    /// Lights.
    Lights,
    /// Materials.
    Materials,
}

/// A line of the tree.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Row {
    /// Name of a group, with the number of its entries.
    Heading(Group, usize),
    /// Something with properties.
    Entry(Target),
    /// So many entries of a folded group that are not shown.
    More(Group, usize),
}

/// Groups of more entries than this are folded until they are opened.
const LARGE: usize = 200;

impl Default for Tree {
    fn default() -> Self {
        Self { cursor: Target::Camera, marked: Vec::new(), filter: None, folded: [None; _] }
    }
}

impl Group {
    /// In the order of the tree.
    pub const ALL: [Self; 4] = [Self::Scene, Self::Objects, Self::Lights, Self::Materials];

    fn of(target: Target) -> Self {
        match target {
            Target::Object(_) => Self::Objects,
            Target::Light(_) => Self::Lights,
            Target::Material(_) => Self::Materials,
            Target::Camera | Target::World | Target::Render | Target::Film => Self::Scene,
        }
    }

    fn name(self) -> &'static str {
        match self {
            Self::Scene => "Scene",
            Self::Objects => "Objects",
            Self::Lights => "Lights",
            Self::Materials => "Materials",
        }
    }

    fn len(self, desc: &SceneDesc) -> usize {
        match self {
            Self::Scene => 4,
            Self::Objects => desc.objects.len(),
            Self::Lights => desc.lights.len(),
            Self::Materials => desc.materials.len(),
        }
    }

    fn entry(self, index: usize) -> Target {
        match self {
            Self::Scene => [Target::Camera, Target::World, Target::Render, Target::Film][index.min(3)],
            Self::Objects => Target::Object(index),
            Self::Lights => Target::Light(index),
            Self::Materials => Target::Material(index),
        }
    }

    fn entries(self, desc: &SceneDesc) -> impl Iterator<Item = Target> {
        (0..self.len(desc)).map(move |index| self.entry(index))
    }
}

impl Tree {
    /// The rows: of a folded group only the first entry and those that are selected; while searching all that fit.
    pub fn rows(&self, desc: &SceneDesc) -> Vec<Row> {
        let wanted = self.filter.as_ref().map(|field| field.text().to_lowercase()).filter(|text| !text.is_empty());
        let mut rows = Vec::new();
        for group in Group::ALL {
            let heading = rows.len();
            rows.push(Row::Heading(group, group.len(desc)));
            if let Some(wanted) = &wanted {
                let fits = |target: &Target| {
                    kind_text(desc, *target).contains(wanted) || target.label(desc).to_lowercase().contains(wanted)
                };
                rows.extend(group.entries(desc).filter(fits).map(Row::Entry));
            } else if self.is_folded(group, desc) {
                let mut shown: Vec<_> = self.marked.iter().chain([&self.cursor]).copied().collect();
                shown.retain(|target| Group::of(*target) == group);
                shown.push(group.entry(0));
                shown.sort_unstable();
                shown.dedup();
                rows.extend(shown.iter().copied().map(Row::Entry));
                rows.extend(Some(group.len(desc) - shown.len()).filter(|more| *more > 0).map(|m| Row::More(group, m)));
            } else {
                rows.extend(group.entries(desc).map(Row::Entry));
            }
            // Without entries there is no group.
            if rows.len() == heading + 1 {
                rows.pop();
            }
        }
        rows
    }

    fn is_folded(&self, group: Group, desc: &SceneDesc) -> bool {
        let entries = group.len(desc);
        entries > 1 && self.folded[group as usize].unwrap_or(entries > LARGE)
    }

    /// Whether the group with the cursor is folded, which a search ignores.
    pub fn is_folded_here(&self, desc: &SceneDesc) -> bool {
        self.filter.is_none() && self.is_folded(Group::of(self.cursor), desc)
    }

    /// Folds or opens the group with the cursor.
    pub fn fold(&mut self, fold: bool) {
        self.folded[Group::of(self.cursor) as usize] = Some(fold);
    }

    /// Folds an open group, or opens a folded one.
    pub fn toggle_fold(&mut self, group: Group, desc: &SceneDesc) {
        self.folded[group as usize] = Some(!self.is_folded(group, desc));
    }

    /// The entry with the cursor.
    pub fn cursor(&self) -> Target {
        self.cursor
    }

    /// What is edited: the marked entries, or else the one with the cursor.
    pub fn selected(&self) -> Vec<Target> {
        if self.marked.is_empty() { vec![self.cursor] } else { self.marked.clone() }
    }

    /// Selects just this.
    pub fn select(&mut self, target: Target) {
        self.marked.clear();
        self.cursor = target;
    }

    /// Selects all of these; the last one gets the cursor.
    pub fn select_all(&mut self, targets: &[Target]) {
        if let Some(last) = targets.last() {
            self.cursor = *last;
            self.marked = if targets.len() > 1 { targets.to_vec() } else { Vec::new() };
        }
    }

    /// Marks or unmarks it.
    pub fn toggle(&mut self, target: Target) {
        self.cursor = target;
        match self.marked.iter().position(|marked| *marked == target) {
            Some(index) => drop(self.marked.remove(index)),
            None => self.marked.push(target),
        }
    }

    /// Adds it to the selection, in which what had the cursor stays if it is a thing in the scene.
    pub fn add(&mut self, target: Target) {
        if self.marked.is_empty() && matches!(self.cursor, Target::Object(_)) && self.cursor != target {
            self.marked.push(self.cursor);
        }
        self.toggle(target);
    }

    /// Nothing is marked.
    pub fn forget_marks(&mut self) {
        self.marked.clear();
    }

    /// Forgets what is not there any more.
    pub fn keep_existing(&mut self, desc: &SceneDesc) {
        self.marked.retain(|target| target.exists(desc));
        if !self.cursor.exists(desc) {
            self.cursor = match self.cursor {
                Target::Object(_) => desc.objects.len().checked_sub(1).map_or(Target::World, Target::Object),
                Target::Light(_) => desc.lights.len().checked_sub(1).map_or(Target::World, Target::Light),
                _ => desc.materials.len().checked_sub(1).map_or(Target::World, Target::Material),
            };
        }
    }

    /// The scene is another one: what was selected is what has its name now, or else its place.
    pub fn follow(&mut self, before: &SceneDesc, now: &SceneDesc) {
        let follow = |target: Target| {
            let name = target.label(before);
            let found = Group::of(target).entries(now).find(|other| other.label(now) == name);
            found.unwrap_or(target)
        };
        self.cursor = follow(self.cursor);
        self.marked = self.marked.iter().map(|target| follow(*target)).collect();
        self.keep_existing(now);
    }

    /// Moves the cursor by rows that are entries.
    pub fn step(&mut self, desc: &SceneDesc, by: isize) {
        let shown = self.shown(desc);
        let Some(last) = shown.len().checked_sub(1) else { return };
        let now = shown.iter().position(|target| *target == self.cursor);
        self.cursor = shown[now.map_or(0, |now| now.saturating_add_signed(by).min(last))];
    }

    /// Moves the cursor and marks the entries that it leaves and reaches.
    pub fn extend(&mut self, desc: &SceneDesc, by: isize) {
        self.mark_cursor();
        self.step(desc, by);
        self.mark_cursor();
    }

    fn mark_cursor(&mut self) {
        if !self.marked.contains(&self.cursor) {
            self.marked.push(self.cursor);
        }
    }

    /// Nothing is marked any more; a search ends. Whether there was something to end.
    pub fn cancel(&mut self) -> bool {
        let had = !self.marked.is_empty() || self.filter.is_some();
        self.marked.clear();
        self.filter = None;
        had
    }

    /// The search, to be typed into.
    pub fn filter_mut(&mut self) -> &mut Field {
        self.filter.get_or_insert_default()
    }

    /// After a change of the search: the cursor goes to something that is shown.
    pub fn refilter(&mut self, desc: &SceneDesc) {
        if self.filter.as_ref().is_some_and(Field::is_empty) {
            return;
        }
        let shown = self.shown(desc);
        if !shown.contains(&self.cursor)
            && let Some(first) = shown.first()
        {
            self.cursor = *first;
        }
    }

    /// Ends a search that is empty.
    pub fn end_search(&mut self) {
        self.filter.take_if(|field| field.is_empty());
    }

    fn shown(&self, desc: &SceneDesc) -> Vec<Target> {
        let entry = |row| if let Row::Entry(target) = row { Some(target) } else { None };
        self.rows(desc).into_iter().filter_map(entry).collect()
    }

    /// The row at a line of the tree that is drawn `height` lines high.
    pub fn at(&self, desc: &SceneDesc, line: usize, height: usize) -> Option<Row> {
        let height = height.saturating_sub(usize::from(self.filter.is_some()));
        let line = line.checked_sub(usize::from(self.filter.is_some()))?;
        let rows = self.rows(desc);
        let shown = window(rows.len(), self.cursor_row(&rows), height);
        rows.get(shown.start + line).copied()
    }

    fn cursor_row(&self, rows: &[Row]) -> usize {
        rows.iter().position(|row| *row == Row::Entry(self.cursor)).unwrap_or(0)
    }

    /// Draws the rows. `typing`: whether the search takes the keys.
    pub fn draw(
        &self,
        desc: &SceneDesc,
        mode: ColorMode,
        focused: bool,
        typing: bool,
        area: Rect,
        buffer: &mut Buffer,
    ) {
        let mut lines = rows(area);
        let width = usize::from(area.width);
        if let (Some(filter), Some(row)) = (&self.filter, self.filter.as_ref().and_then(|_| lines.next())) {
            let mut spans = vec![Span::styled("/ ", mode.style(Role::Key))];
            if typing {
                spans.extend(filter.spans(width.saturating_sub(2), mode.style(Role::Text)));
            } else {
                spans.push(Span::raw(fit(&filter.text(), width.saturating_sub(2))));
            }
            Line::from(spans).render(row, buffer);
        }
        let all = self.rows(desc);
        if all.is_empty()
            && let Some(row) = lines.next()
        {
            Line::styled("nothing has such a name", mode.style(Role::Dim)).render(row, buffer);
        }
        let height = usize::from(area.height).saturating_sub(usize::from(self.filter.is_some()));
        let shown = window(all.len(), self.cursor_row(&all), height);
        for (index, row) in shown.zip(lines) {
            match all[index] {
                Row::Heading(group, entries) => {
                    let mark = if self.is_folded(group, desc) && self.filter.is_none() { "▸ " } else { "" };
                    let count = if entries > LARGE { format!(" ({entries})") } else { String::new() };
                    let text = format!("{mark}{}{count}", group.name());
                    Line::styled(text, mode.style(Role::Dim)).render(row, buffer);
                }
                Row::More(_, count) => {
                    Line::styled(fit(&format!("  … {count} more"), width), mode.style(Role::Dim)).render(row, buffer);
                }
                Row::Entry(target) => self.draw_entry(desc, mode, focused, target, row, buffer),
            }
        }
    }

    fn draw_entry(
        &self,
        desc: &SceneDesc,
        mode: ColorMode,
        focused: bool,
        target: Target,
        area: Rect,
        buffer: &mut Buffer,
    ) {
        let marked = self.marked.contains(&target);
        let here = self.cursor == target;
        let mark = if marked { "● " } else { "  " };
        let kind = kind_text(desc, target).to_owned();
        let hidden = is_hidden(desc, target);
        let width = usize::from(area.width);
        let swatch = swatch(desc, target).filter(|_| mode != ColorMode::None);
        let right = if hidden { format!("hidden {kind}") } else { kind };
        let right_width = Span::raw(&right).width() + 2 * usize::from(swatch.is_some());
        let name_width = width.saturating_sub(2 + right_width + 1);
        let name = fit(&target.label(desc), name_width.max(width.saturating_sub(2).min(8)));
        let (name_style, right_style) = match (here && focused, here, marked) {
            (true, ..) => (mode.style(Role::Cursor), mode.style(Role::Cursor)),
            (_, _, true) => (mode.style(Role::Mark), mode.style(Role::Dim)),
            (_, true, _) => (mode.style(Role::Strong), mode.style(Role::Dim)),
            _ if hidden => (mode.style(Role::Dim), mode.style(Role::Dim)),
            _ => (mode.style(Role::Text), mode.style(Role::Dim)),
        };
        let mark = if here && !focused && !marked { "▸ " } else { mark };
        let mark_style = if here && focused { name_style } else { mode.style(Role::Mark) };
        let mut spans = vec![
            Span::styled(mark, mark_style),
            Span::styled(name, name_style),
            Span::styled(format!(" {right}"), right_style),
        ];
        if let Some(codes) = swatch {
            spans.push(Span::styled(" ", right_style));
            spans.push(Span::styled("█", Style::new().fg(mode.color(codes))));
        }
        Line::from(spans).render(area, buffer);
    }
}

/// What kind of thing it is, in a word.
fn kind_text(desc: &SceneDesc, target: Target) -> &'static str {
    match target {
        Target::Object(index) => match desc.objects.get(index).map(|object| &object.shape) {
            Some(ShapeDesc::Sphere { .. }) => "sphere",
            Some(ShapeDesc::Cuboid { .. }) => "cuboid",
            Some(ShapeDesc::Cylinder { .. }) => "cylinder",
            Some(ShapeDesc::Cone { .. }) => "cone",
            Some(ShapeDesc::Plane) => "plane",
            Some(ShapeDesc::Quad { .. }) => "quad",
            Some(ShapeDesc::Mesh { .. }) => "model",
            Some(ShapeDesc::Spheres { .. }) => "spheres",
            None => "",
        },
        Target::Light(index) => match desc.lights.get(index).map(|light| light.kind) {
            Some(LightKind::Point { .. }) => "point",
            Some(LightKind::Directional { .. }) => "directional",
            None => "",
        },
        _ => "",
    }
}

fn is_hidden(desc: &SceneDesc, target: Target) -> bool {
    match target {
        Target::Object(index) => desc.objects.get(index).is_some_and(|object| !object.visible),
        Target::Light(index) => desc.lights.get(index).is_some_and(|light| !light.visible),
        _ => false,
    }
}

/// The colour of lights and materials.
fn swatch(desc: &SceneDesc, target: Target) -> Option<[u8; 3]> {
    match target {
        Target::Light(index) => desc.lights.get(index).map(|light| codes_of(light.color)),
        Target::Material(index) => desc.materials.get(index).map(|material| codes_of(material.color)),
        Target::Object(index) => {
            let name = desc.objects.get(index)?.material.as_ref()?;
            desc.materials.iter().find(|material| material.name == *name).map(|material| codes_of(material.color))
        }
        _ => None,
    }
}
