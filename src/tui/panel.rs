//! The numbers: progress, rays, threads, camera.

use super::app::{Activity, App};
use super::color::{ColorMode, Role};
use super::format::{rough_time, samples, si, time, view};
pub use super::layout::Panel;
use super::layout::THREAD_WIDTH;
use super::numbers::Numbers;
use crate::bvh::Isa;
use crate::render::{Pass, Rect as Tile};
use glam::DVec3;
use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::text::{Line, Span};
use ratatui::widgets::{Paragraph, Widget};

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
                "{}×{}  {}  {}  depth {}",
                app.film().width(),
                app.film().height(),
                render.shading.name(),
                samples(render.samples),
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
    if let Some(numbers) = app.numbers() {
        lines.push(progress_bar(mode, numbers, width));
        let of = numbers.samples.1.map_or(String::new(), |total| format!(" of {}", si(total as f64)));
        lines.push(row("samples", format!("{}{of}", si(numbers.samples.0 as f64))));
        lines.push(row(&format!("pass {}", pass_count(numbers)), pass_text(numbers.pass)));
        lines.push(row("elapsed", time(numbers.elapsed)));
        lines.push(row("left", left_text(app, numbers)));
        lines.push(row("error", error_text(numbers)));
        lines.push(row("cut rays add", cut_text(numbers)));
        lines.push(row("first picture", numbers.first_picture.map_or("      –".into(), time)));
        lines.push(Line::default());
        lines.push(heading(mode, "Rays", format!("{}/s", si(numbers.rate(numbers.rays.total()))), width));
        let total = numbers.rays.total().max(1) as f64;
        for (name, count) in kinds(numbers) {
            let mut line = vec![Span::styled(format!("{name:<12}"), mode.style(Role::Dim))];
            line.push(Span::raw(format!("{}  ", si(count as f64))));
            line.extend(bar(mode, count as f64 / total, width.saturating_sub(20)));
            lines.push(Line::from(line));
        }
        lines.push(Line::from(vec![
            Span::styled(format!("{:<12}", "all"), mode.style(Role::Dim)),
            Span::raw(si(numbers.rays.total() as f64)),
        ]));
        if numbers.non_finite > 0 {
            lines.push(Line::from(vec![
                Span::styled(format!("{:<12}", "not finite"), mode.style(Role::Bad)),
                Span::raw(format!("{}  samples left out", si(numbers.non_finite as f64))),
            ]));
            let command = numbers.first_non_finite.map_or(String::new(), |pixel| app.explain_command(pixel));
            lines.extend(wrapped(&command, width).into_iter().map(|line| Line::styled(line, mode.style(Role::Dim))));
        }
        if numbers.overfull > 0 {
            lines.push(Line::from(vec![
                Span::styled(format!("{:<12}", "overfull"), mode.style(Role::Bad)),
                Span::raw(format!("{}  in too many bodies", si(numbers.overfull as f64))),
            ]));
        }
        lines.push(Line::default());
        // What stands below the threads, if there is room.
        const CAMERA_LINES: usize = 5;
        let room = usize::from(area.height).saturating_sub(lines.len() + 2);
        let all_fit = numbers.workers.len() + CAMERA_LINES <= room;
        let busy = format!("{}  {}", app.isa().map_or("", Isa::name), busy_text(numbers));
        lines.push(heading(mode, "Threads", busy, width));
        threads(mode, numbers, if all_fit { room - CAMERA_LINES } else { room }, &mut lines);
        if !all_fit {
            Paragraph::new(lines).render(area, buffer);
            return;
        }
        lines.push(Line::default());
    }
    let camera = app.desc().camera;
    lines.push(heading(mode, "Camera", view(camera.projection), width));
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
    let until = render.error.map_or_else(|| samples(render.samples), |error| format!("error {error}"));
    let facts = [
        format!("{}×{}", app.film().width(), app.film().height()),
        render.shading.name().to_owned(),
        until,
        format!("depth {}", render.max_depth),
        view(app.desc().camera.projection),
    ];
    let name = vec![
        Span::styled("── ", mode.style(Role::Dim)),
        Span::styled(app.name().to_string(), mode.style(Role::Strong)),
    ];
    let facts = facts.map(|fact| vec![Span::styled(format!("  {fact}"), mode.style(Role::Dim))]);
    let mut title = side_by_side([name].into_iter().chain(facts), width);
    let rest = width.saturating_sub(title.width() + 1);
    title.push_span(Span::styled(format!(" {}", "─".repeat(rest)), mode.style(Role::Dim)));
    let mut lines = vec![title];
    if let Some(numbers) = app.numbers() {
        let pass = match numbers.error {
            Some(_) => format!("   error {}", error_text(numbers)),
            None => format!("   pass {}", pass_count(numbers)),
        };
        let pass = format!("{pass}   cut {}", cut_text(numbers));
        let mut line = progress_bar(mode, numbers, width.saturating_sub(Span::raw(&pass).width()));
        line.push_span(Span::styled(pass, mode.style(Role::Dim)));
        lines.push(line);
        let label = |text: &'static str| Span::styled(text, mode.style(Role::Dim));
        let mut times: Vec<_> = [
            ("elapsed ", time(numbers.elapsed)),
            ("   left ", format!("{:<14}", left_text(app, numbers))),
            ("   first picture ", numbers.first_picture.map_or("      –".into(), time)),
        ]
        .map(|(name, text)| vec![label(name), Span::raw(text)])
        .into();
        if numbers.overfull > 0 {
            let text = format!(" {} overfull", si(numbers.overfull as f64));
            times.push(vec![Span::styled(text, mode.style(Role::Bad))]);
        }
        lines.push(side_by_side(times, width));
        let mut rays = vec![vec![label("rays "), Span::raw(format!("{}/s ", si(numbers.rate(numbers.rays.total()))))]];
        // Fits in 80 columns.
        rays.extend(kinds(numbers).map(|(name, count)| {
            vec![label(" "), label(name.get(..7).unwrap_or(name)), Span::raw(format!(" {}", si(count as f64)))]
        }));
        lines.push(side_by_side(rays, width));
        if numbers.non_finite > 0 {
            // Of more use than the threads, if there is no room for both.
            let command = numbers.first_non_finite.map_or(String::new(), |pixel| app.explain_command(pixel));
            let text = format!("{} not finite: {command}", si(numbers.non_finite as f64));
            lines.extend(wrapped(&text, width).into_iter().map(|line| Line::styled(line, mode.style(Role::Bad))));
        }
        let rows = usize::from(area.height).saturating_sub(lines.len());
        thread_grid(mode, numbers, width, rows, &mut lines);
    }
    let area = Rect { x: area.x + 1, width: area.width.saturating_sub(2), ..area };
    Paragraph::new(lines).render(area, buffer);
}

/// The words of a text in lines of at most this width where they fit.
fn wrapped(text: &str, width: usize) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split(' ').filter(|word| !word.is_empty()) {
        match lines.last_mut() {
            Some(line) if line.chars().count() + 1 + word.chars().count() <= width => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}

/// Facts in a line, as many from the first as fit whole.
fn side_by_side(facts: impl IntoIterator<Item = Vec<Span<'static>>>, width: usize) -> Line<'static> {
    let mut line = Line::default();
    for fact in facts {
        if line.width() + fact.iter().map(Span::width).sum::<usize>() > width {
            break;
        }
        line.extend(fact);
    }
    line
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

fn progress_bar(mode: ColorMode, numbers: &Numbers, width: usize) -> Line<'static> {
    let part = numbers.part;
    let mut spans = bar(mode, part, width.saturating_sub(7)).to_vec();
    spans.push(Span::styled(format!("  {:>3} %", numbers.percent), mode.style(Role::Strong)));
    Line::from(spans)
}

/// "0.72 → 0.50": how wrong the picture is, in 8-bit codes, and how wrong it may be.
fn error_text(numbers: &Numbers) -> String {
    let error = numbers.error.map_or("–".into(), |error| format!("{error:.2}"));
    numbers.target.map_or(error.clone(), |target| format!("{error} → {target:.2}"))
}

/// "≤ 0.02 %": what rays that were not followed can add, of white.
fn cut_text(numbers: &Numbers) -> String {
    match numbers.cut {
        None => "no bound".into(),
        Some(0.0) => "nothing".into(),
        Some(bound) => format!("≤ {:.2} %", (100.0 * bound).max(0.01)),
    }
}

fn pass_count(numbers: &Numbers) -> String {
    let of = numbers.pass_number.1.map_or(String::new(), |total| format!(" / {total}"));
    format!("{:>2}{of}", numbers.pass_number.0)
}

fn pass_text(pass: Option<Pass>) -> String {
    match pass {
        None => String::new(),
        Some(Pass::Lattice { step: 1 }) => "every pixel".into(),
        Some(Pass::Lattice { step }) => format!("every {step}th pixel"),
        Some(Pass::Adapt { .. }) => "where it is wrong".into(),
        Some(Pass::Refine { from, to }) if from + 1 == to => format!("sample {to}"),
        Some(Pass::Refine { from, to }) => format!("samples {}–{to}", from + 1),
    }
}

/// Time that is left: a range, or why there is none.
fn left_text(app: &App, numbers: &Numbers) -> String {
    match (app.activity(), numbers.eta) {
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

fn kinds(numbers: &Numbers) -> [(&'static str, u64); 4] {
    let rays = numbers.rays;
    [("camera", rays.camera), ("shadow", rays.shadow), ("reflection", rays.reflection), ("refraction", rays.refraction)]
}

fn vector_text(v: DVec3) -> String {
    v.to_array().map(|c| format!("{c:>9.3}")).join(" ")
}

/// A heading, and a line for each thread, in at most `room` lines under the heading's two.
fn threads(mode: ColorMode, numbers: &Numbers, room: usize, lines: &mut Vec<Line<'static>>) {
    lines.push(Line::styled("  #     busy idle  tiles rays/s   tile at", mode.style(Role::Dim)));
    let count = numbers.workers.len();
    let listed = if count <= room { count } else { room.saturating_sub(1) };
    for (i, worker) in numbers.workers.iter().enumerate().take(listed) {
        let busy = numbers.busy(worker);
        let mut spans = vec![Span::styled(format!("{:>3} ", i + 1), mode.style(Role::Dim))];
        spans.extend(bar(mode, busy, 3));
        spans.push(Span::raw(format!(
            "{} {} {} {:>9}",
            busy_idle(busy),
            si(worker.tiles as f64),
            si(numbers.rate(worker.rays)),
            tile_text(worker.current),
        )));
        lines.push(Line::from(spans));
    }
    if listed < count {
        lines.push(Line::styled(format!("    and {} more", count - listed), mode.style(Role::Dim)));
    }
}

/// As many threads a line as fit, under a heading.
fn thread_grid(mode: ColorMode, numbers: &Numbers, width: usize, rows: usize, lines: &mut Vec<Line<'static>>) {
    let in_a_row = (width / usize::from(THREAD_WIDTH)).max(1);
    let count = numbers.workers.len();
    let cells = rows.saturating_sub(1) * in_a_row;
    let listed = if count <= cells { count } else { cells.saturating_sub(1) };
    let cell = |i: usize| -> Vec<Span<'static>> {
        let Some(worker) = numbers.workers.get(i) else { return Vec::new() };
        if i >= listed {
            let text = format!("   and {} more; all {}", count - listed, busy_text(numbers));
            return vec![Span::styled(text, mode.style(Role::Dim))];
        }
        let text = format!(
            "{} {} {}  {:<10}",
            busy_idle(numbers.busy(worker)),
            si(worker.tiles as f64),
            si(numbers.rate(worker.rays)),
            tile_text(worker.current),
        );
        vec![Span::styled(format!("{:>2} ", i + 1), mode.style(Role::Dim)), Span::raw(text)]
    };
    let heading = " #  busy idle  tiles rays/s  tile      ".repeat(in_a_row.min(count));
    lines.push(Line::styled(heading, mode.style(Role::Dim)));
    for row in 0..count.min(cells).div_ceil(in_a_row) {
        lines.push(Line::from((0..in_a_row).flat_map(|column| cell(row * in_a_row + column)).collect::<Vec<_>>()));
    }
}

fn tile_text(tile: Option<Tile>) -> String {
    tile.map_or("–".into(), |tile| format!("{},{}", tile.x, tile.y))
}

/// How busy a thread is, and how idle: 10 columns.
fn busy_idle(busy: f64) -> String {
    let percent = (100.0 * busy) as u32;
    format!("{percent:>4}%{:>4}%", 100u32.saturating_sub(percent))
}

/// How busy all threads are together.
fn busy_text(numbers: &Numbers) -> String {
    format!("{:>3} % busy", (100.0 * numbers.all_busy()) as u32)
}
