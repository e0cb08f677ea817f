//! The numbers: progress, rays, threads, camera.

use super::app::{Activity, App, shading_text, view_text};
use super::color::{ColorMode, Role};
use super::format::{rough_time, si, time};
pub use super::layout::Panel;
use super::layout::THREAD_WIDTH;
use crate::render::{Pass, Progress, Rect as Tile};
use glam::DVec3;
use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::text::{Line, Span};
use ratatui::widgets::{Paragraph, Widget};
use std::time::{Duration, Instant};

/// Draws the panel.
pub fn draw(app: &App, panel: Panel, buffer: &mut Buffer) {
    match panel {
        Panel::Side(area) => side(app, area, buffer),
        Panel::Below(area) => below(app, area, buffer),
    }
}

/// Beside the picture: everything, one fact a line.
fn side(app: &App, area: Rect, buffer: &mut Buffer) {
    let mode = app.mode();
    for y in area.top()..area.bottom() {
        if let Some(cell) = buffer.cell_mut((area.x, y)) {
            cell.set_symbol("│").set_style(mode.style(Role::Dim));
        }
    }
    let area = Rect { x: area.x + 2, width: area.width.saturating_sub(3), ..area };
    let width = usize::from(area.width);
    let render = app.desc().render;
    let mut lines = vec![
        Line::styled(app.name().to_string(), mode.style(Role::Strong)),
        Line::styled(
            format!(
                "{}×{}  {}  {} samples  depth {}",
                app.film().width(),
                app.film().height(),
                shading_text(render.shading),
                render.samples,
                render.max_depth
            ),
            mode.style(Role::Dim),
        ),
        Line::default(),
    ];
    let row = |name: &str, value: String| {
        let gap = width.saturating_sub(Span::raw(name).width() + Span::raw(&value).width());
        Line::from(vec![Span::styled(format!("{name}{}", " ".repeat(gap)), mode.style(Role::Dim)), Span::raw(value)])
    };
    if let Some((progress, now)) = app.shown() {
        let elapsed = progress.elapsed(now);
        lines.push(progress_bar(mode, progress, width));
        lines.push(row(
            "samples",
            format!("{} of {}", si(progress.samples_done as f64), si(progress.samples_total as f64)),
        ));
        lines.push(row(&format!("pass {}", pass_count(progress)), pass_text(progress.pass)));
        lines.push(row("elapsed", time(elapsed)));
        lines.push(row("left", left_text(app, progress, now)));
        lines.push(row("first picture", progress.first_picture.map_or("      –".into(), time)));
        lines.push(Line::default());
        lines.push(heading(mode, "Rays", format!("{}/s", si(rate(progress.rays.total(), elapsed))), width));
        let total = progress.rays.total().max(1) as f64;
        for (name, count) in kinds(progress) {
            let mut line = vec![Span::styled(format!("{name:<12}"), mode.style(Role::Dim))];
            line.push(Span::raw(format!("{}  ", si(count as f64))));
            line.extend(bar(mode, count as f64 / total, width.saturating_sub(20)));
            lines.push(Line::from(line));
        }
        lines.push(Line::from(vec![
            Span::styled(format!("{:<12}", "all"), mode.style(Role::Dim)),
            Span::raw(si(progress.rays.total() as f64)),
        ]));
        if progress.non_finite > 0 {
            lines.push(Line::from(vec![
                Span::styled(format!("{:<12}", "not finite"), mode.style(Role::Bad)),
                Span::raw(format!("{}  samples left out", si(progress.non_finite as f64))),
            ]));
        }
        lines.push(Line::default());
        // What stands below the threads, if there is room.
        const CAMERA_LINES: usize = 5;
        let room = usize::from(area.height).saturating_sub(lines.len() + 2);
        let all_fit = progress.workers.len() + CAMERA_LINES <= room;
        threads(mode, progress, now, width, if all_fit { room - CAMERA_LINES } else { room }, &mut lines);
        if !all_fit {
            Paragraph::new(lines).render(area, buffer);
            return;
        }
        lines.push(Line::default());
    }
    let camera = app.desc().camera;
    lines.push(heading(mode, "Camera", view_text(camera.projection), width));
    lines.push(row("position", vector_text(camera.position)));
    lines.push(row("looks at", vector_text(camera.look_at)));
    lines.push(row("distance", format!("{:>9.3}", camera.position.distance(camera.look_at))));
    Paragraph::new(lines).render(area, buffer);
}

/// Below the picture: the same facts, many a line.
fn below(app: &App, area: Rect, buffer: &mut Buffer) {
    let mode = app.mode();
    let width = usize::from(area.width).saturating_sub(2);
    let render = app.desc().render;
    let facts = format!(
        "  {}×{}  {}  {} samples  depth {}  {} ",
        app.film().width(),
        app.film().height(),
        shading_text(render.shading),
        render.samples,
        render.max_depth,
        view_text(app.desc().camera.projection),
    );
    let title = vec![
        Span::styled("── ", mode.style(Role::Dim)),
        Span::styled(app.name().to_string(), mode.style(Role::Strong)),
        Span::styled(facts, mode.style(Role::Dim)),
    ];
    let rest = width.saturating_sub(Line::from(title.clone()).width());
    let mut lines = vec![Line::from(title)];
    lines[0].push_span(Span::styled("─".repeat(rest), mode.style(Role::Dim)));
    if let Some((progress, now)) = app.shown() {
        let elapsed = progress.elapsed(now);
        let pass = format!("   pass {}", pass_count(progress));
        let mut line = progress_bar(mode, progress, width.saturating_sub(pass.len()));
        line.push_span(Span::styled(pass, mode.style(Role::Dim)));
        lines.push(line);
        let label = |text: &'static str| Span::styled(text, mode.style(Role::Dim));
        lines.push(Line::from(vec![
            label("elapsed "),
            Span::raw(time(elapsed)),
            label("   left "),
            Span::raw(format!("{:<14}", left_text(app, progress, now))),
            label("   first picture "),
            Span::raw(progress.first_picture.map_or("      –".into(), time)),
        ]));
        let mut rays = vec![label("rays "), Span::raw(format!("{}/s ", si(rate(progress.rays.total(), elapsed))))];
        for (name, count) in kinds(progress) {
            rays.push(label(" "));
            // Fits in 80 columns.
            rays.push(Span::styled(name.get(..7).unwrap_or(name).to_string(), mode.style(Role::Dim)));
            rays.push(Span::raw(format!(" {}", si(count as f64))));
        }
        if progress.non_finite > 0 {
            rays.push(Span::styled(format!(" {} not finite", si(progress.non_finite as f64)), mode.style(Role::Bad)));
        }
        lines.push(Line::from(rays));
        let rows = usize::from(area.height).saturating_sub(lines.len());
        thread_grid(mode, progress, now, width, rows, &mut lines);
    }
    let area = Rect { x: area.x + 1, width: area.width.saturating_sub(2), ..area };
    Paragraph::new(lines).render(area, buffer);
}

fn heading(mode: ColorMode, name: &'static str, value: String, width: usize) -> Line<'static> {
    let gap = width.saturating_sub(name.len() + Span::raw(&value).width());
    Line::from(vec![Span::styled(name, mode.style(Role::Strong)), Span::raw(format!("{}{value}", " ".repeat(gap)))])
}

/// A bar of `width` columns, filled to `part`; whole columns only, rounded down.
fn bar(mode: ColorMode, part: f64, width: usize) -> [Span<'static>; 2] {
    let filled = ((part.clamp(0.0, 1.0) * width as f64) as usize).min(width);
    [
        Span::styled("━".repeat(filled), mode.style(Role::Bar)),
        Span::styled("─".repeat(width - filled), mode.style(Role::Dim)),
    ]
}

fn progress_bar(mode: ColorMode, progress: &Progress, width: usize) -> Line<'static> {
    let part = progress.samples_done as f64 / progress.samples_total.max(1) as f64;
    let mut spans = bar(mode, part, width.saturating_sub(7)).to_vec();
    spans.push(Span::styled(format!("  {:>3} %", progress.percent()), mode.style(Role::Strong)));
    Line::from(spans)
}

fn pass_count(progress: &Progress) -> String {
    format!("{:>2} / {}", progress.pass_number, progress.passes_total)
}

fn pass_text(pass: Option<Pass>) -> String {
    match pass {
        None => String::new(),
        Some(Pass::Lattice { step: 1 }) => "every pixel".into(),
        Some(Pass::Lattice { step }) => format!("every {step}th pixel"),
        Some(Pass::Refine { from, to }) if from + 1 == to => format!("sample {to}"),
        Some(Pass::Refine { from, to }) => format!("samples {}–{to}", from + 1),
    }
}

/// Time that is left: a range, or why there is none.
fn left_text(app: &App, progress: &Progress, now: Instant) -> String {
    match (app.activity(), progress.eta(now)) {
        (Activity::Finished, _) => "nothing".into(),
        (Activity::Failed, _) | (_, None) => "–".into(),
        (_, Some(eta)) => {
            let (low, high) = (rough_time(eta.low), rough_time(eta.high));
            match (low.split_once(' '), high.split_once(' ')) {
                _ if low == high => low,
                (Some((number, unit)), Some((_, same))) if unit == same => format!("{number}–{high}"),
                _ => format!("{low} – {high}"),
            }
        }
    }
}

fn kinds(progress: &Progress) -> [(&'static str, u64); 4] {
    let rays = progress.rays;
    [("camera", rays.camera), ("shadow", rays.shadow), ("reflection", rays.reflection), ("refraction", rays.refraction)]
}

fn rate(count: u64, elapsed: Duration) -> f64 {
    if elapsed.is_zero() { 0.0 } else { count as f64 / elapsed.as_secs_f64() }
}

fn share(busy: Duration, elapsed: Duration) -> f64 {
    if elapsed.is_zero() { 0.0 } else { (busy.as_secs_f64() / elapsed.as_secs_f64()).min(1.0) }
}

fn vector_text(v: DVec3) -> String {
    v.to_array().map(|c| format!("{c:>9.3}")).join(" ")
}

/// A heading, and a line for each thread, in at most `room` lines under the heading's two.
fn threads(
    mode: ColorMode,
    progress: &Progress,
    now: Instant,
    width: usize,
    room: usize,
    lines: &mut Vec<Line<'static>>,
) {
    let elapsed = progress.elapsed(now);
    lines.push(heading(mode, "Threads", busy_text(progress, elapsed), width));
    lines.push(Line::styled("  # busy, idle    tiles  rays/s   tile at", mode.style(Role::Dim)));
    let count = progress.workers.len();
    let listed = if count <= room { count } else { room.saturating_sub(1) };
    for (i, worker) in progress.workers.iter().enumerate().take(listed) {
        let part = share(worker.busy, elapsed);
        let mut spans = vec![Span::styled(format!("{:>3} ", i + 1), mode.style(Role::Dim))];
        spans.extend(bar(mode, part, 6));
        spans.push(Span::raw(format!(
            "{:>4} % {}  {} {:>10}",
            (part * 100.0) as u32,
            si(worker.tiles as f64),
            si(rate(worker.rays, elapsed)),
            tile_text(worker.current),
        )));
        lines.push(Line::from(spans));
    }
    if listed < count {
        lines.push(Line::styled(format!("    and {} more", count - listed), mode.style(Role::Dim)));
    }
}

/// As many threads a line as fit, under a heading.
fn thread_grid(
    mode: ColorMode,
    progress: &Progress,
    now: Instant,
    width: usize,
    rows: usize,
    lines: &mut Vec<Line<'static>>,
) {
    let elapsed = progress.elapsed(now);
    let in_a_row = (width / usize::from(THREAD_WIDTH)).max(1);
    let count = progress.workers.len();
    let cells = rows.saturating_sub(1) * in_a_row;
    let listed = if count <= cells { count } else { cells.saturating_sub(1) };
    let cell = |i: usize| -> Vec<Span<'static>> {
        let Some(worker) = progress.workers.get(i) else { return Vec::new() };
        if i >= listed {
            let text = format!("   and {} more; all {}", count - listed, busy_text(progress, elapsed));
            return vec![Span::styled(text, mode.style(Role::Dim))];
        }
        let part = share(worker.busy, elapsed);
        let mut spans = vec![Span::styled(format!("{:>2} ", i + 1), mode.style(Role::Dim))];
        spans.extend(bar(mode, part, 5));
        spans.push(Span::raw(format!(
            "{:>4} % {} {} {:<9}",
            (part * 100.0) as u32,
            si(worker.tiles as f64),
            si(rate(worker.rays, elapsed)),
            tile_text(worker.current),
        )));
        spans
    };
    let heading = " # busy, idle   tiles rays/s tile      ".repeat(in_a_row.min(count));
    lines.push(Line::styled(heading, mode.style(Role::Dim)));
    for row in 0..count.min(cells).div_ceil(in_a_row) {
        lines.push(Line::from((0..in_a_row).flat_map(|column| cell(row * in_a_row + column)).collect::<Vec<_>>()));
    }
}

fn tile_text(tile: Option<Tile>) -> String {
    tile.map_or("–".into(), |tile| format!("{},{}", tile.x, tile.y))
}

/// How busy all threads are together.
fn busy_text(progress: &Progress, elapsed: Duration) -> String {
    let shares: f64 = progress.workers.iter().map(|worker| share(worker.busy, elapsed)).sum();
    let percent = 100.0 * shares / progress.workers.len().max(1) as f64;
    format!("{:>3} % busy", percent as u32)
}
