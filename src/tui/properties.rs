//! The properties of what is selected: one row for every parameter.

use super::color::{ColorMode, Role};
use super::dialog::color::codes_of;
use super::field::Field;
use super::widget::{fit, rows, window};
use crate::description::parameter::{Kind, Parameter, Value, shared_parameters};
use crate::description::{SceneDesc, Target};
use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::Style;
use ratatui::text::{Line, Span};
use ratatui::widgets::Widget;

/// A parameter of some entries.
#[derive(Clone)]
pub struct Property {
    /// Whose.
    pub targets: Vec<Target>,
    /// Which.
    pub parameter: &'static Parameter,
}

/// Rows with a heading.
pub struct Section {
    /// What they belong to, safe to print.
    pub heading: String,
    /// One a row.
    pub properties: Vec<Property>,
}

/// Where the cursor is, and what is typed there.
#[derive(Clone, Debug, Default)]
pub struct Properties {
    cursor: usize,
    /// A value being typed.
    pub entry: Option<Field>,
}

/// Everything that can be turned of a selection: its own parameters, and for objects those of their materials.
pub fn sections(desc: &SceneDesc, selected: &[Target]) -> Vec<Section> {
    let heading = match selected {
        [] => String::new(),
        [one] => one.label(desc),
        many => format!("{} selected", many.len()),
    };
    let rows = |targets: &[Target]| {
        let shared = shared_parameters(desc, targets).into_iter();
        shared.map(|parameter| Property { targets: targets.to_vec(), parameter }).collect::<Vec<_>>()
    };
    let mut found = vec![Section { heading, properties: rows(selected) }];
    let materials = materials_of(desc, selected);
    if selected.iter().all(|target| matches!(target, Target::Object(_))) && !materials.is_empty() {
        let heading = match &materials[..] {
            [one] => format!("material {}", one.label(desc)),
            many => format!("{} materials", many.len()),
        };
        found.push(Section { heading, properties: rows(&materials) });
    }
    found
}

/// Materials that are selected, or that selected objects are made of, each once.
pub fn materials_of(desc: &SceneDesc, selected: &[Target]) -> Vec<Target> {
    let mut found = Vec::new();
    for target in selected {
        let material = match target {
            Target::Material(_) => Some(*target),
            Target::Object(index) => desc.objects.get(*index).and_then(|object| {
                let name = object.material.as_ref()?;
                desc.materials.iter().position(|material| material.name == *name).map(Target::Material)
            }),
            _ => None,
        };
        found.extend(material.filter(|material| !found.contains(material)));
    }
    found
}

impl Properties {
    /// The row with the cursor.
    pub fn current(&self, sections: &[Section]) -> Option<Property> {
        let all: Vec<_> = sections.iter().flat_map(|section| &section.properties).collect();
        all.get(self.cursor.min(all.len().saturating_sub(1))).map(|property| (*property).clone())
    }

    /// Moves the cursor.
    pub fn step(&mut self, sections: &[Section], by: isize) {
        let count: usize = sections.iter().map(|section| section.properties.len()).sum();
        let last = count.saturating_sub(1);
        self.cursor = self.cursor.min(last).saturating_add_signed(by).min(last);
    }

    /// To the row at a line of the panel that is drawn `height` lines high; whether there is one.
    pub fn go_to(&mut self, sections: &[Section], line: usize, height: usize) -> bool {
        let lines = self.lines(sections);
        let shown = window(lines.len(), self.cursor_line(&lines), height);
        let found = lines.get(shown.start + line).and_then(|line| line.1);
        self.cursor = found.unwrap_or(self.cursor);
        found.is_some()
    }

    /// To the row of this parameter.
    pub fn find(&mut self, sections: &[Section], label: &str) {
        let all = sections.iter().flat_map(|section| &section.properties);
        if let Some(index) = all.into_iter().position(|property| property.parameter.label == label) {
            self.cursor = index;
        }
    }

    /// Every line: of which section, and the number of its property if it is no heading.
    fn lines(&self, sections: &[Section]) -> Vec<(usize, Option<usize>)> {
        let mut lines = Vec::new();
        let mut number = 0;
        for (index, section) in sections.iter().enumerate() {
            lines.push((index, None));
            for _ in &section.properties {
                lines.push((index, Some(number)));
                number += 1;
            }
        }
        lines
    }

    fn cursor_line(&self, lines: &[(usize, Option<usize>)]) -> usize {
        let last = lines.iter().rposition(|line| line.1.is_some()).unwrap_or(0);
        lines.iter().position(|line| line.1 == Some(self.cursor)).unwrap_or(last)
    }

    /// Draws the rows.
    pub fn draw(
        &self,
        desc: &SceneDesc,
        sections: &[Section],
        mode: ColorMode,
        focused: bool,
        area: Rect,
        buffer: &mut Buffer,
    ) {
        let lines = self.lines(sections);
        let cursor = self.cursor_line(&lines);
        let all: Vec<_> = sections.iter().flat_map(|section| &section.properties).collect();
        let shown = window(lines.len(), cursor, area.height.into());
        for (index, row) in shown.zip(rows(area)) {
            match lines[index] {
                (section, None) => {
                    let heading = fit(&sections[section].heading, row.width.into());
                    Line::styled(heading, mode.style(Role::Strong)).render(row, buffer);
                }
                (_, Some(number)) => self.draw_row(desc, all[number], mode, focused && index == cursor, row, buffer),
            }
        }
        if all.is_empty() && area.height > 1 {
            let note = "several kinds: nothing in common";
            let row = Rect { y: area.y + 1, height: 1, ..area };
            Line::styled(fit(note, area.width.into()), mode.style(Role::Dim)).render(row, buffer);
        }
    }

    fn draw_row(
        &self,
        desc: &SceneDesc,
        property: &Property,
        mode: ColorMode,
        here: bool,
        row: Rect,
        buffer: &mut Buffer,
    ) {
        let width = usize::from(row.width);
        let parameter = property.parameter;
        let label_width = (width / 2).min(19);
        let label_role = if here { Role::Strong } else { Role::Dim };
        let mut spans = vec![
            Span::styled(if here { "▸ " } else { "  " }, mode.style(Role::Key)),
            Span::styled(fit(parameter.label, label_width.saturating_sub(1)), mode.style(label_role)),
            Span::raw(" "),
        ];
        let room = width.saturating_sub(2 + label_width);
        let value = parameter.get(desc, &property.targets);
        match (&value, &self.entry) {
            (_, Some(field)) if here => spans.extend(field.spans(room, mode.style(Role::Text))),
            (Some(value), _) => {
                let target = property.targets.first().copied().unwrap_or(Target::Film);
                let text = match value {
                    Value::Mixed => "mixed".to_owned(),
                    value => parameter.show(desc, target, value),
                };
                let swatch = match value {
                    Value::Color(color) if mode != ColorMode::None => Some(codes_of(*color)),
                    _ => None,
                };
                let role = match value {
                    _ if here => Role::Cursor,
                    Value::Mixed => Role::Dim,
                    _ => Role::Text,
                };
                let text =
                    if matches!(parameter.kind, Kind::Choice(_)) && here { format!("‹ {text} ›") } else { text };
                let unit = if parameter.unit.is_empty() { String::new() } else { format!(" {}", parameter.unit) };
                let text_room = room.saturating_sub(2 * usize::from(swatch.is_some()));
                let text_width = Span::raw(&text).width().min(text_room);
                spans.push(Span::styled(fit(&text, text_width), mode.style(role)));
                if let Some(codes) = swatch {
                    spans.push(Span::raw(" "));
                    spans.push(Span::styled("██", Style::new().fg(mode.color(codes))));
                }
                spans.push(Span::styled(fit(&unit, text_room - text_width), mode.style(Role::Dim)));
            }
            (None, _) => {}
        }
        Line::from(spans).render(row, buffer);
    }
}
