//! The sums that are gathered in a rectangle of pixels.

use super::batch::{Batch, Wanted};
use super::census::{Census, Group};
use super::event::{Cut, ErrorChange, TileImage};
use super::map::{Look, Map};
use super::pass::{COARSEST, Pass};
use super::pixel::Pixel;
use super::rect::Rect;
use super::round::{Round, Seen, share_gained};
use super::scatter::{JUDGED, Scatter};
use crate::math::linear_to_srgb_by_roots;
use crate::shading::Sample;

/// Row and column of the pixels of a tile in blocks of 8 by 8, so that rays traced together are close together.
pub fn blocks(width: u32, height: u32) -> impl Iterator<Item = (u32, u32)> {
    const SIDE: u32 = 8;
    let starts = |size: u32| (0..size).step_by(SIDE as usize);
    starts(height).flat_map(move |y| starts(width).map(move |x| (y, x))).flat_map(move |(y, x)| {
        (y..height.min(y + SIDE)).flat_map(move |row| (x..width.min(x + SIDE)).map(move |column| (row, column)))
    })
}

/// One rectangle between passes: the sums of its samples. Moves from worker to worker by value, so that nothing is
/// shared and the samples of a pixel are added in their order, whoever traces them.
#[derive(Debug)]
pub struct Tile {
    rect: Rect,
    /// The pixels of the finest lattice so far, row by row: what no pass has reached takes no memory and no time. (With
    /// all pixels from the beginning, an edit of the demo took 75 ms to be seen whole instead of 44.)
    pixels: Vec<Pixel>,
    /// How the samples of each of them differ, if that is to be known.
    scatters: Vec<Scatter>,
    /// What the last census made of each of them; empty before the first. Rounds look at nothing else of most pixels.
    /// (With all numbers of a pixel in one place, walking over them took about 5 % of the time of a render of the demo
    /// to an error of 1.)
    groups: Vec<Group>,
    /// What the pixels looked like after the last pass that is judged by what it changes: 8-bit codes by channel.
    codes: Vec<[f32; 3]>,
    /// Pixels between the points of that lattice; 1 when all are there.
    step: u32,
    /// What was last said of its squared error.
    told: Option<f64>,
    /// Whether the error of each pixel has been told.
    has_told_errors: bool,
    /// What was not followed in its pixels.
    cut: Cut,
}

impl Tile {
    /// A rectangle without samples.
    pub fn new(rect: Rect) -> Self {
        Self {
            rect,
            pixels: Vec::new(),
            scatters: Vec::new(),
            groups: Vec::new(),
            codes: Vec::new(),
            step: COARSEST,
            told: None,
            has_told_errors: false,
            cut: Cut::default(),
        }
    }

    /// Columns and rows of the lattice.
    fn size(&self) -> (u32, u32) {
        (self.rect.width.div_ceil(self.step), self.rect.height.div_ceil(self.step))
    }

    /// Makes room for the points of a lattice, the first or one finer than before.
    fn refine(&mut self, step: u32, differences: bool) {
        let factor = (self.step / step) as usize;
        let (coarse_columns, _) = self.size();
        self.step = step;
        let (columns, rows) = self.size();
        self.pixels = spread(&self.pixels, coarse_columns, (columns, rows), factor);
        if differences {
            self.scatters = spread(&self.scatters, coarse_columns, (columns, rows), factor);
        }
    }

    /// Its pixels.
    pub fn rect(&self) -> Rect {
        self.rect
    }

    /// The pixel of the film that is this point of the lattice: column and row.
    pub(super) fn place(&self, at: u32) -> (u32, u32) {
        let ((columns, _), Rect { x, y, .. }) = (self.size(), self.rect);
        (x + at % columns * self.step, y + at / columns * self.step)
    }

    /// Adds the next samples of a point; how many of them are not finite.
    pub(super) fn add(&mut self, at: u32, samples: &[Sample], differences: bool) -> u64 {
        let mut pixel = self.pixels[at as usize];
        let left_out = pixel.non_finite();
        for sample in samples {
            if differences {
                self.scatters[at as usize].note(&pixel, sample);
            }
            pixel.add(sample);
        }
        self.pixels[at as usize] = pixel;
        u64::from(pixel.non_finite() - left_out)
    }

    /// Puts down the pixels of a pass that is the same for every picture. `number`: of the tile among those that are
    /// traced together.
    pub(super) fn enter(&mut self, number: u32, pass: Pass, differences: bool, batch: &mut Batch) {
        // Sums get their memory here, so that starting a render takes none.
        let step = if let Pass::Lattice { step } = pass { step } else { 1 };
        if self.pixels.is_empty() || step < self.step {
            self.refine(step, differences);
        }
        if self.codes.is_empty() && matches!(pass, Pass::Refine { to, .. } if to >= JUDGED) {
            self.codes = codes(self.pixels.iter().map(|pixel| pixel.mean().to_f32()).collect());
        }
        let (Rect { x, y, .. }, (columns, rows)) = (self.rect, self.size());
        blocks(columns, rows).for_each(|(row, column)| {
            let samples = pass.samples_at(x + column * self.step, y + row * self.step);
            if !samples.is_empty() {
                let at = row * columns + column;
                batch.wanted.push(Wanted { tile: number, at, before: samples.start, after: samples.end });
            }
        });
    }

    /// Chooses the pixels of a round of refinement.
    pub(super) fn choose(&self, number: u32, round: &Round, batch: &mut Batch) {
        let Rect { x, y, width, height } = self.rect;
        blocks(width, height).for_each(|(row, column)| {
            let (at, x, y) = (row * width + column, x + column, y + row);
            let group = self.groups[at as usize];
            if round.looks_into(group, x, y) {
                let before = self.pixels[at as usize].traced();
                let after = round.wanted(group, before, x, y);
                if after > before {
                    batch.wanted.push(Wanted { tile: number, at, before, after });
                }
            }
        });
    }

    /// Samples that were traced of the pixels that were wanted of it.
    pub(super) fn samples(&self, number: u32, batch: &Batch) -> u64 {
        batch.of(number).iter().map(|wanted| u64::from(self.pixels[wanted.at as usize].traced() - wanted.before)).sum()
    }

    /// Puts down what all pixels look like.
    pub(super) fn write(&self, map: &Map) {
        let Rect { x, y, width, .. } = self.rect;
        for (at, (pixel, scatter)) in (0..).zip(self.pixels.iter().zip(&self.scatters)) {
            map.begin(x + at % width, y + at / width, Look::of(pixel, scatter));
        }
    }

    /// Puts down what the pixels look like that were traced in a round.
    pub(super) fn note(&mut self, number: u32, round: &Round, batch: &Batch, census: &mut Census) {
        let Rect { x, y, width, .. } = self.rect;
        for &Wanted { at, before, .. } in batch.of(number) {
            round.note(&mut self.seen(at), before, (x + at % width, y + at / width), census);
        }
    }

    /// One of its pixels.
    fn seen(&mut self, at: u32) -> Seen<'_> {
        let at = at as usize;
        Seen { pixel: &self.pixels[at], scatter: &mut self.scatters[at], group: &mut self.groups[at] }
    }

    /// Judges the pixels that may be other than before, when all tiles have been traced.
    pub(super) fn judge(&mut self, round: &Round, batch: &mut Batch, census: &mut Census) {
        let Rect { x, y, width, height } = self.rect;
        let Batch { window, stale, .. } = batch;
        let is_first = self.groups.is_empty();
        self.groups.resize(self.pixels.len(), Group::default());
        let (mut change, mut is_there) = (0.0, false);
        for row in 0..height {
            if !round.map.take_stale(x, y + row, width, stale) {
                continue;
            }
            if !std::mem::replace(&mut is_there, true) {
                round.map.look_around(self.rect, window);
            }
            window.fit(row as usize, stale);
            for (column, _) in stale.iter().enumerate().filter(|(_, stale)| **stale) {
                let mut seen = self.seen(row * width + column as u32);
                let before = f64::from(seen.scatter.judged);
                if !is_first {
                    census.remove(*seen.group, before);
                }
                round.judge(&mut seen, window.fits[column], (x + column as u32, y + row), census);
                change += f64::from(seen.scatter.judged) - before;
            }
        }
        self.told = Some(self.told() + change);
    }

    /// What was last said of its squared error: about the work that it will be.
    pub(super) fn told(&self) -> f64 {
        self.told.unwrap_or_default()
    }

    /// What a round has made of the tile: if these are few, the pixels that were traced. In rounds that have a plan
    /// errors are told too, for the first time of all pixels, and how those of the traced ones have changed: from what
    /// the last census said to what they say of themselves.
    pub(super) fn refined(&mut self, number: u32, round: &Round, batch: &Batch) -> (TileImage, Option<ErrorChange>) {
        let wanted = batch.of(number);
        let traced = || wanted.iter().map(|wanted| wanted.at as usize);
        let is_part = self.has_told_errors == round.plan.is_some() && wanted.len() < self.pixels.len() / 2;
        let mut image = self.image(is_part.then(|| wanted.iter().map(|wanted| wanted.at).collect()));
        if round.plan.is_none() {
            return (image, None);
        }
        self.has_told_errors = true;
        let before = |at: usize| round.error_before(&self.scatters[at], self.groups[at]);
        let now = |at: usize| round.corrected(self.scatters[at].own);
        let root = |square: f64| square.sqrt() as f32;
        image.errors = match is_part {
            true => traced().map(|at| root(now(at))).collect(),
            false => (0..self.pixels.len()).map(|at| root(before(at))).collect(),
        };
        if !is_part {
            traced().for_each(|at| image.errors[at] = root(now(at)));
        }
        (image, Some(ErrorChange { before: Some(traced().map(before).sum()), now: traced().map(now).sum() }))
    }

    /// What was not followed in its pixels, counted anew.
    pub(super) fn count_cut(&mut self) -> Cut {
        self.cut = Cut::of(self.pixels.iter());
        self.cut
    }

    /// What was not followed in the pixels that are wanted of it: summed, and of the worst.
    pub(super) fn cut_of(&self, number: u32, batch: &Batch) -> Cut {
        Cut::of(batch.of(number).iter().map(|wanted| &self.pixels[wanted.at as usize]))
    }

    /// What was not followed in all of its pixels, of which those that were wanted had this before.
    pub(super) fn recount_cut(&mut self, number: u32, before: Cut, batch: &Batch) -> Cut {
        if before.largest > 0.0 && before.largest >= self.cut.largest {
            return self.count_cut();
        }
        let now = self.cut_of(number, batch);
        self.cut =
            Cut { sum: (self.cut.sum + now.sum - before.sum).max(0.0), largest: self.cut.largest.max(now.largest) };
        self.cut
    }

    /// The errors of all pixels, which look like this now, by what they have changed in a pass of all pixels, which is
    /// what missed edges do too; and how the sum of their squares has changed.
    pub(super) fn own_errors(&mut self, pass: Pass, pixels: &[[f32; 3]]) -> Option<(ErrorChange, Vec<f32>)> {
        let Pass::Refine { from, to } = pass else { return None };
        if self.codes.is_empty() {
            return None;
        }
        let gained = share_gained(from, to);
        let left = ((1.0 - gained) / gained / 3.0) as f32;
        // (With the table of `linear_to_srgb_near`, value by value, this took 1.3 % of the time of 16 samples.)
        let before = std::mem::replace(&mut self.codes, codes(pixels.to_vec()));
        let change2 = |(a, b): (&[f32; 3], &[f32; 3])| (0..3).map(|c| (a[c] - b[c]) * (a[c] - b[c])).sum::<f32>();
        let mut errors: Vec<f32> = before.iter().zip(&self.codes).map(|pair| left * change2(pair)).collect();
        let now = errors.iter().map(|error2| f64::from(*error2)).sum();
        errors.iter_mut().for_each(|error| *error = error.sqrt());
        Some((ErrorChange { before: self.told.replace(now), now }, errors))
    }

    /// The pixels as they are known, each the mean of its samples: these, or all of the finest lattice so far.
    pub(super) fn image(&self, points: Option<Vec<u32>>) -> TileImage {
        let mut image = TileImage { rect: self.rect, step: self.step, ..TileImage::default() };
        match &points {
            None => image.take(self.pixels.iter()),
            Some(points) => image.take(points.iter().map(|at| &self.pixels[*at as usize])),
        }
        TileImage { points, ..image }
    }
}

impl Cut {
    fn of<'a>(pixels: impl Iterator<Item = &'a Pixel>) -> Self {
        pixels
            .map(Pixel::cut)
            .fold(Self::default(), |cut, weight| Self { sum: cut.sum + weight, largest: cut.largest.max(weight) })
    }
}

impl TileImage {
    fn take<'a>(&mut self, pixels: impl Iterator<Item = &'a Pixel> + Clone) {
        self.pixels = pixels.clone().map(|pixel| pixel.mean().to_f32()).collect();
        self.samples = pixels.clone().map(Pixel::traced).collect();
        if pixels.clone().any(|pixel| pixel.non_finite() > 0) {
            self.non_finite = pixels.map(Pixel::non_finite).collect();
        }
    }
}

/// 8-bit codes of linear light, not rounded.
fn codes(mut pixels: Vec<[f32; 3]>) -> Vec<[f32; 3]> {
    pixels.as_flattened_mut().iter_mut().for_each(|channel| *channel = 255.0 * linear_to_srgb_by_roots(*channel));
    pixels
}

/// The points of a lattice of this size, of which those of a coarser one are known.
fn spread<T: Copy + Default>(coarse: &[T], coarse_columns: u32, (columns, rows): (u32, u32), factor: usize) -> Vec<T> {
    let mut fine = vec![T::default(); columns as usize * rows as usize];
    for (row, line) in coarse.chunks(coarse_columns.max(1) as usize).enumerate() {
        for (column, point) in line.iter().enumerate() {
            fine[row * factor * columns as usize + column * factor] = *point;
        }
    }
    fine
}

/// Whether tiles of this side start on the coarsest lattice.
pub(super) fn is_valid_side(side: u32) -> bool {
    side > 0 && side.is_multiple_of(COARSEST)
}
