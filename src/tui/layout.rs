//! Where things stand on the screen.

use ratatui::layout::Rect;

/// Areas of the screen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Layout {
    /// The picture.
    pub preview: Rect,
    /// Tree and properties, right of all but the status.
    pub editor: Option<Rect>,
    /// Numbers, where there is room for them.
    pub panel: Option<Panel>,
    /// Messages and keys: the last row.
    pub status: Rect,
}

/// The numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Panel {
    /// Right of the picture, [`SIDE_WIDTH`] wide.
    Side(Rect),
    /// Below the picture, as wide as the screen.
    Below(Rect),
}

/// Columns of a panel at the side.
pub const SIDE_WIDTH: u16 = 44;
/// Columns of tree and properties on a wide screen.
pub const EDITOR_WIDTH: u16 = 46;
/// Columns for a thread in a panel below.
pub const THREAD_WIDTH: u16 = 39;
/// Rows of a panel below, without those of threads.
pub const BELOW_ROWS: u16 = 5;
/// A screen of so many columns has room for a panel at the side in any case.
const WIDE: u16 = 140;
/// Rows of threads in a panel below.
const THREAD_ROWS: u16 = 4;

/// Which parts are wanted; each is shown if there is room.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Parts {
    /// Tree and properties.
    pub editor: bool,
    /// The numbers.
    pub numbers: bool,
}

/// Divides a screen of `(columns, rows)` for a film of `(width, height)` pixels.
pub fn lay_out((columns, rows): (u16, u16), film: (u32, u32), threads: usize, parts: Parts) -> Layout {
    let status = Rect::new(0, rows.saturating_sub(1), columns, rows.min(1));
    let mut above = Rect::new(0, 0, columns, rows.saturating_sub(1));
    let mut editor = None;
    if parts.editor && above.width >= 12 && above.height >= 4 {
        let width = match columns {
            160.. => EDITOR_WIDTH,
            110.. => 38,
            56.. => 30,
            // No room for both: the editor alone.
            _ => columns,
        };
        above.width -= width;
        editor = Some(Rect { x: above.width, width, ..above });
    }
    let bare = Layout { preview: above, editor, panel: None, status };
    if !parts.numbers || above.width == 0 {
        return bare;
    }
    let side = (editor.is_none() && columns >= SIDE_WIDTH + 30 && above.height >= 16).then(|| {
        let preview = Rect { width: columns - SIDE_WIDTH, ..above };
        let panel = Rect { x: preview.width, width: SIDE_WIDTH, ..above };
        Layout { preview, panel: Some(Panel::Side(panel)), ..bare }
    });
    let in_a_row = usize::from(above.width.saturating_sub(2) / THREAD_WIDTH).max(1);
    let thread_rows = threads.div_ceil(in_a_row).clamp(1, THREAD_ROWS.into()) as u16;
    let height = BELOW_ROWS + thread_rows;
    let below = (above.width >= 40 && above.height >= height + 6).then(|| {
        let preview = Rect { height: above.height - height, ..above };
        let panel = Rect { y: preview.height, height, ..above };
        Layout { preview, panel: Some(Panel::Below(panel)), ..bare }
    });
    match (side, below) {
        (Some(side), Some(below)) => {
            let roomier = fitted(side.preview, film) >= fitted(below.preview, film);
            if columns >= WIDE || roomier { side } else { below }
        }
        (side, below) => side.or(below).unwrap_or(bare),
    }
}

/// Whether a screen of so many columns has tree and properties from the start.
pub fn has_room_for_editor(columns: u16) -> bool {
    columns >= 100
}

/// Size of the fitted picture in an area.
fn fitted(area: Rect, (width, height): (u32, u32)) -> f64 {
    let (width, height) = (f64::from(width), f64::from(height));
    let scale = (f64::from(area.width) / width).min(2.0 * f64::from(area.height) / height);
    width * height * scale * scale
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: [Parts; 4] = [
        Parts { editor: false, numbers: false },
        Parts { editor: false, numbers: true },
        Parts { editor: true, numbers: false },
        Parts { editor: true, numbers: true },
    ];

    #[test]
    fn the_areas_lie_on_the_screen_and_do_not_overlap() {
        for columns in 0..220 {
            for rows in 0..70 {
                for (film, threads) in [((1280, 720), 2), ((100, 900), 64), ((1, 1), 1)] {
                    for parts in ALL {
                        let screen = Rect::new(0, 0, columns, rows);
                        let Layout { preview, editor, panel, status } = lay_out((columns, rows), film, threads, parts);
                        let panel = panel.map_or(Rect::ZERO, |p| match p {
                            Panel::Side(area) | Panel::Below(area) => area,
                        });
                        let areas = [preview, editor.unwrap_or(Rect::ZERO), panel, status];
                        for (i, area) in areas.iter().enumerate() {
                            assert_eq!(area.intersection(screen).area(), area.area(), "{area} on {screen}");
                            assert!(areas[..i].iter().all(|other| other.intersection(*area).area() == 0));
                        }
                        assert_eq!(areas.iter().map(|area| area.area()).sum::<u32>(), screen.area());
                    }
                }
            }
        }
    }

    #[test]
    fn a_wide_screen_has_its_panel_at_the_side_and_a_usual_one_below() {
        let panel = |columns, rows, film| lay_out((columns, rows), film, 2, ALL[1]).panel;
        assert!(matches!(panel(200, 60, (1280, 720)), Some(Panel::Side(_))));
        assert!(matches!(panel(80, 24, (1280, 720)), Some(Panel::Below(_))));
        assert!(matches!(panel(80, 24, (400, 900)), Some(Panel::Side(_))));
        assert_eq!(panel(20, 5, (1280, 720)), None);
        // With the editor at the side numbers are below.
        let both = lay_out((80, 24), (1280, 720), 2, ALL[3]);
        assert_eq!(both.editor.map(|area| area.width), Some(30));
        assert!(matches!(both.panel, Some(Panel::Below(area)) if area.width == 50));
    }
}
