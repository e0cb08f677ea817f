//! Tree and properties, one above the other.

use super::app::{App, Focus};
use super::color::Role;
use super::widget::fit;
use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::text::{Line, Span};
use ratatui::widgets::Widget;

/// Where things stand in the column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SideLayout {
    /// Name of the scene.
    pub title: Rect,
    /// Rows of the tree.
    pub tree: Rect,
    /// The line between.
    pub line: Rect,
    /// Rows of the properties.
    pub properties: Rect,
}

impl SideLayout {
    /// Divides the column: the tree gets what it needs, but leaves half to the properties. Where there is room for one
    /// of them only, it is the one that has the keys.
    pub fn new(app: &App, area: Rect) -> Self {
        let inner = Rect { x: area.x + 2, width: area.width.saturating_sub(3), ..area };
        let title = Rect { height: inner.height.min(1), ..inner };
        let rest = inner.height - title.height;
        let wanted = app.editor().tree.rows(app.desc()).len() + usize::from(app.is_searching());
        let wanted = u16::try_from(wanted).unwrap_or(u16::MAX);
        let tree_height = match (rest, app.focus()) {
            (0..10, Focus::Properties) => 0,
            (0..10, _) => rest,
            _ => wanted.clamp(4, (rest - 1) / 2),
        };
        let tree = Rect { y: title.bottom(), height: tree_height, ..inner };
        let line_height = u16::from(tree_height > 0 && tree_height < rest);
        let line = Rect { y: tree.bottom(), height: line_height, ..area };
        let properties = Rect { y: line.bottom(), height: rest - tree_height - line_height, ..inner };
        Self { title, tree, line, properties }
    }
}

/// Draws the column.
pub fn draw(app: &App, area: Rect, buffer: &mut Buffer) {
    let mode = app.mode();
    let layout = SideLayout::new(app, area);
    for y in area.top()..area.bottom() {
        if let Some(cell) = buffer.cell_mut((area.x, y)) {
            cell.set_symbol("│").set_style(mode.style(Role::Dim));
        }
    }
    let width = usize::from(layout.title.width);
    let mark = if app.editor().history().is_unsaved() { " ● not saved" } else { "" };
    let name = fit(app.name(), width.saturating_sub(Span::raw(mark).width()).min(Span::raw(app.name()).width()));
    let title = [Span::styled(name, mode.style(Role::Strong)), Span::styled(mark, mode.style(Role::Mark))];
    Line::from(title.to_vec()).render(layout.title, buffer);
    let focused = |focus| app.focus() == focus && app.dialog().is_none() && app.transform().is_none();
    let tree = &app.editor().tree;
    tree.draw(app.desc(), mode, focused(Focus::Tree), app.is_searching(), layout.tree, buffer);
    if layout.line.height > 0 {
        let line = format!("├{}", "─".repeat(usize::from(layout.line.width).saturating_sub(1)));
        Line::styled(line, mode.style(Role::Dim)).render(layout.line, buffer);
    }
    let sections = app.editor().sections();
    let properties = &app.editor().properties;
    properties.draw(app.desc(), &sections, mode, focused(Focus::Properties), layout.properties, buffer);
}
