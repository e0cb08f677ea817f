//! `glimt check`: what a scene has, and what is suspicious in it.

use super::open::Opened;
use crate::bvh::BvhStats;
use crate::description::printable;
use crate::scene::{Imported, Scene};
use std::fmt;

/// What `glimt check` prints about a scene that can be rendered.
pub struct Inventory<'a> {
    pub opened: &'a Opened,
    pub scene: &'a Scene,
}

impl fmt::Display for Inventory<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (scene, render, summary) = (self.scene, &self.scene.render, &self.scene.summary);
        writeln!(f, "{}", printable(&self.opened.file.to_string_lossy()))?;
        let mut row = |name: &str, value: String| writeln!(f, "  {name:<12}{value}");
        row("picture", format!("{}x{}, {}", scene.width, scene.height, count(render.samples as usize, "sample")))?;
        row("shading", format!("{}, depth {}", render.shading.name(), render.max_depth))?;
        row("shadows", render.shadows.name().to_owned())?;
        row("numerics", render.numerics.name().to_owned())?;
        row("traced with", scene.isa().name().to_owned())?;
        row("objects", thousands(summary.objects))?;
        row("primitives", thousands(summary.primitives))?;
        row("triangles", triangles(summary.triangles, summary.instanced_triangles))?;
        row("lights", thousands(summary.lights))?;
        row("materials", thousands(summary.materials))?;
        row("pictures", thousands(summary.textures))?;
        row("tree", tree(&summary.tree))?;
        let milliseconds = |time: std::time::Duration| format!("{:.1} ms", time.as_secs_f64() * 1e3);
        row("read in", milliseconds(self.opened.load_time + summary.load_time))?;
        row("trees in", milliseconds(self.opened.build_time + summary.build_time))?;
        for Imported { file, report, tree: over_triangles } in &summary.imports {
            write!(f, "{}: {}", printable(&file.to_string_lossy()), count(report.triangles, "triangle"))?;
            if report.dropped_degenerate > 0 {
                write!(f, "; {} dropped (no area)", thousands(report.dropped_degenerate))?;
            }
            if report.dropped_duplicates > 0 {
                write!(f, "; {} dropped (duplicates)", thousands(report.dropped_duplicates))?;
            }
            if let Some(normals) = &report.normals {
                write!(f, "; {}", printable(normals))?;
            }
            writeln!(f)?;
            writeln!(f, "  {:<12}{}", "tree", tree(over_triangles))?;
        }
        for warning in &summary.warnings {
            writeln!(f, "warning: {}", printable(warning))?;
        }
        match summary.warnings.len() {
            0 => writeln!(f, "nothing wrong"),
            n => writeln!(f, "can be rendered, with {}", count(n, "warning")),
        }
    }
}

/// "depth 6, SAH cost 31.4, 7,160 nodes, 13,021 blocks 84 % full, 5,999,616 bytes (52.9 each)".
fn tree(stats: &BvhStats) -> String {
    if stats.primitives == 0 {
        return "empty".to_owned();
    }
    format!(
        "depth {}, SAH cost {:.1}, {}, {} {:.0} % full, {} bytes ({:.1} each)",
        stats.depth,
        stats.sah_cost,
        count(stats.nodes, "node"),
        count(stats.blocks, "block"),
        100.0 * stats.fill,
        thousands(stats.bytes),
        stats.bytes_per_primitive(),
    )
}

fn triangles(stored: usize, instanced: usize) -> String {
    match stored == instanced {
        true => thousands(stored),
        false => format!("{}, {} with every instance", thousands(stored), thousands(instanced)),
    }
}

/// "1 triangle", "1,234 triangles".
fn count(number: usize, noun: &str) -> String {
    format!("{} {noun}{}", thousands(number), if number == 1 { "" } else { "s" })
}

/// Digits in groups of three.
fn thousands(number: usize) -> String {
    let digits = number.to_string();
    let mut grouped = String::new();
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index).is_multiple_of(3) {
            grouped.push(',');
        }
        grouped.push(digit);
    }
    grouped
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_grouped_by_threes_and_nouns_agree() {
        let shown = [0, 7, 999, 1000, 69_451, 1_234_567].map(thousands);
        assert_eq!(shown, ["0", "7", "999", "1,000", "69,451", "1,234,567"]);
        assert_eq!([count(1, "light"), count(2, "light")], ["1 light", "2 lights"]);
    }
}
