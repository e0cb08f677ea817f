//! The picture in cells: each shows two pixels, one above the other.

use super::color::ColorMode;
use crate::math::{linear_to_srgb8, srgb8_to_linear};
use crate::render::{Film, Rect as Tile};
use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::Color;

/// The film, box-filtered in linear light to the half cells of an area (exact area weights, channels clamped to what
/// a PNG can hold, so that the preview is the PNG made smaller). Half cells are taken as square. Only what changed is
/// computed again.
#[derive(Clone, Debug)]
pub struct Preview {
    film: (u32, u32),
    area: (u16, u16),
    zoom: f64,
    /// Middle of what is shown, in parts of the film.
    centre: (f64, f64),
    across: Axis,
    down: Axis,
    codes: Vec<[u8; 3]>,
    stale: Vec<bool>,
    any_stale: bool,
}

/// How film pixels fall on preview pixels along one direction.
#[derive(Clone, Debug, Default, PartialEq)]
struct Axis {
    /// Preview pixels of the whole film at this zoom, and the first that is shown.
    whole: usize,
    first: usize,
    /// Empty preview pixels before the picture.
    margin: usize,
    /// One entry for each preview pixel shown.
    boxes: Vec<Footprint>,
}

/// The film pixels under one preview pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Footprint {
    first: usize,
    last: usize,
    /// Parts of the first and the last film pixel that are covered; those between count whole.
    first_weight: f64,
    last_weight: f64,
}

impl Axis {
    /// `length` film pixels in steps of about `step` on `room` preview pixels, with `centre` (0..1) in the middle.
    fn new(length: u32, step: f64, room: usize, centre: f64) -> Self {
        let length = f64::from(length);
        // Whole preview pixels on the whole film, so that no pixel of the preview is half empty.
        let whole = ((length / step).round() as usize).max(1);
        let step = length / whole as f64;
        let shown = whole.min(room);
        let first = (centre * whole as f64 - shown as f64 / 2.0).round().clamp(0.0, (whole - shown) as f64) as usize;
        let boxes =
            (first..first + shown).map(|i| Footprint::new(i as f64 * step, (i + 1) as f64 * step, length)).collect();
        Self { whole, first, margin: (room - shown) / 2, boxes }
    }

    /// Preview pixels that show any of the film pixels `start..end`.
    fn touching(&self, start: u32, end: u32) -> std::ops::Range<usize> {
        let from = self.boxes.partition_point(|b| b.last < start as usize);
        let to = self.boxes.partition_point(|b| b.first < end as usize);
        from..to.max(from)
    }

    /// The middle of what is shown, in parts of the film.
    fn centre(&self) -> f64 {
        (self.first as f64 + self.boxes.len() as f64 / 2.0) / self.whole.max(1) as f64
    }
}

impl Footprint {
    fn new(start: f64, end: f64, length: f64) -> Self {
        let end = end.min(length);
        let first = start.floor().clamp(0.0, length - 1.0);
        let last = (end.ceil() - 1.0).clamp(first, length - 1.0);
        let (first_weight, last_weight) =
            if first == last { (end - start, end - start) } else { (first + 1.0 - start, end - last) };
        Self { first: first as usize, last: last as usize, first_weight, last_weight }
    }

    fn weight(&self, i: usize) -> f64 {
        if i == self.first {
            self.first_weight
        } else if i == self.last {
            self.last_weight
        } else {
            1.0
        }
    }

    fn length(&self) -> f64 {
        if self.first == self.last {
            self.first_weight
        } else {
            self.first_weight + self.last_weight + (self.last - self.first - 1) as f64
        }
    }
}

/// A film pixel may become this many preview pixels wide.
const LARGEST_PIXEL: f64 = 16.0;
/// Characters without colour, by lightness on a dark ground (Bourke, "Character representation of grey scale images").
const RAMP: &[u8] = b" .'`^\",:;Il!i><~+_-?][}{1)(|\\/tfjrxnuvczXYUJCLQ0OZmwqpdbkhao*#MW&8%B@$";

impl Default for Preview {
    /// Nothing to show yet.
    fn default() -> Self {
        Self {
            film: (1, 1),
            area: (0, 0),
            zoom: 1.0,
            centre: (0.5, 0.5),
            across: Axis::default(),
            down: Axis::default(),
            codes: Vec::new(),
            stale: Vec::new(),
            any_stale: false,
        }
    }
}

impl Preview {
    /// Size of the film in pixels.
    pub fn set_film(&mut self, width: u32, height: u32) {
        if self.film != (width, height) {
            self.film = (width.max(1), height.max(1));
            self.fit();
        }
    }

    /// Size of the area in cells.
    pub fn set_area(&mut self, columns: u16, rows: u16) {
        if self.area != (columns, rows) {
            self.area = (columns, rows);
            self.lay_out();
        }
    }

    /// How many times larger than fitted the picture is.
    pub fn zoom(&self) -> f64 {
        self.zoom
    }

    /// Shows the whole picture.
    pub fn fit(&mut self) {
        (self.zoom, self.centre) = (1.0, (0.5, 0.5));
        self.lay_out();
    }

    /// Multiplies the zoom. The middle stays where it is.
    pub fn zoom_by(&mut self, factor: f64) {
        let largest = (self.fitted_step() * LARGEST_PIXEL).max(1.0);
        self.zoom = (self.zoom * factor).clamp(1.0, largest);
        // Repeated roots come back to 1 only nearly.
        if self.zoom < 1.001 {
            self.zoom = 1.0;
        }
        self.lay_out();
    }

    /// Moves what is shown by parts of its own size, right and down.
    pub fn shift(&mut self, right: f64, below: f64) {
        let part = |axis: &Axis| axis.boxes.len() as f64 / axis.whole.max(1) as f64;
        self.centre.0 += right * part(&self.across);
        self.centre.1 += below * part(&self.down);
        self.lay_out();
    }

    /// The film pixel in the middle of the preview pixel (x, y) of the area, two rows of which are a row of cells;
    /// `None` beside the picture.
    pub fn film_pixel(&self, x: usize, y: usize) -> Option<(u32, u32)> {
        let middle = |axis: &Axis, at: usize| {
            let footprint = axis.boxes.get(at.checked_sub(axis.margin)?)?;
            Some(((footprint.first + footprint.last) / 2) as u32)
        };
        Some((middle(&self.across, x)?, middle(&self.down, y)?))
    }

    /// The preview pixel of the picture that is nearest to (x, y); `None` if there is no picture.
    pub fn nearest(&self, x: usize, y: usize) -> Option<(usize, usize)> {
        let clamp = |axis: &Axis, at: usize| {
            let last = (axis.margin + axis.boxes.len()).checked_sub(1).filter(|_| !axis.boxes.is_empty())?;
            Some(at.clamp(axis.margin, last))
        };
        Some((clamp(&self.across, x)?, clamp(&self.down, y)?))
    }

    /// Size of the area in preview pixels.
    pub fn pixels(&self) -> (usize, usize) {
        (self.area.0.into(), 2 * usize::from(self.area.1))
    }

    /// Film pixels a preview pixel, with the whole picture in view.
    fn fitted_step(&self) -> f64 {
        let across = f64::from(self.film.0) / f64::from(self.area.0.max(1));
        let down = f64::from(self.film.1) / (2.0 * f64::from(self.area.1.max(1)));
        across.max(down)
    }

    fn lay_out(&mut self) {
        let step = self.fitted_step() / self.zoom;
        self.across = Axis::new(self.film.0, step, self.area.0.into(), self.centre.0);
        self.down = Axis::new(self.film.1, step, 2 * usize::from(self.area.1), self.centre.1);
        // Whole cells above the picture; half a one may be left below.
        self.down.margin &= !1;
        // Shifts beyond the edge are forgotten.
        self.centre = (self.across.centre(), self.down.centre());
        let count = self.across.boxes.len() * self.down.boxes.len();
        self.codes.clear();
        self.codes.resize(count, [0; 3]);
        self.stale.clear();
        self.stale.resize(count, true);
        self.any_stale = true;
    }

    /// These film pixels have changed.
    pub fn mark(&mut self, tile: Tile) {
        let columns = self.across.touching(tile.x, tile.x + tile.width);
        for row in self.down.touching(tile.y, tile.y + tile.height) {
            let start = row * self.across.boxes.len();
            self.stale[start + columns.start..start + columns.end].fill(true);
        }
        self.any_stale = true;
    }

    /// All film pixels have changed.
    pub fn mark_all(&mut self) {
        self.stale.fill(true);
        self.any_stale = true;
    }

    /// Computes what has changed. `film` has the size given to [`Preview::set_film`].
    pub fn refresh(&mut self, film: &Film) {
        if !self.any_stale || (film.width(), film.height()) != self.film {
            return;
        }
        let columns = &self.across.boxes;
        if columns.is_empty() {
            return;
        }
        let stale_rows = self.stale.chunks_mut(columns.len()).zip(self.codes.chunks_mut(columns.len()));
        for ((stale, codes), row) in stale_rows.zip(&self.down.boxes) {
            for ((stale, code), column) in stale.iter_mut().zip(codes).zip(columns) {
                if std::mem::take(stale) {
                    *code = mean(film, column, row);
                }
            }
        }
        self.any_stale = false;
    }

    /// Puts the picture into the cells of `area`, whose size is that given to [`Preview::set_area`].
    pub fn paint(&self, area: Rect, buffer: &mut Buffer, mode: ColorMode) {
        let pixel = |x: usize, y: usize| -> Option<[u8; 3]> {
            let (x, y) = (x.checked_sub(self.across.margin)?, y.checked_sub(self.down.margin)?);
            let columns = self.across.boxes.len();
            if x < columns { self.codes.get(y * columns + x).copied() } else { None }
        };
        for y in 0..area.height {
            for x in 0..area.width {
                let (upper, lower) = (pixel(x.into(), 2 * usize::from(y)), pixel(x.into(), 2 * usize::from(y) + 1));
                let Some(cell) = buffer.cell_mut((area.x + x, area.y + y)) else { continue };
                match (upper, lower) {
                    (None, None) => {}
                    _ if mode == ColorMode::None => {
                        let mut bytes = [0; 4];
                        cell.set_symbol(ramp(upper, lower).encode_utf8(&mut bytes));
                    }
                    (Some(upper), lower) => {
                        let lower = lower.map_or(Color::Reset, |lower| mode.color(lower));
                        cell.set_symbol(UPPER_HALF).set_fg(mode.color(upper)).set_bg(lower);
                    }
                    // The picture begins with a whole cell.
                    (None, Some(_)) => {}
                }
            }
        }
    }
}

/// Upper pixel in the foreground colour, lower one in the background colour.
pub const UPPER_HALF: &str = "▀";

/// Mean of the film under a preview pixel, as an sRGB code. Plain loops: most of the time of a frame is spent here.
fn mean(film: &Film, column: &Footprint, row: &Footprint) -> [u8; 3] {
    let width = film.width() as usize;
    let (mut r, mut g, mut b) = (0.0, 0.0, 0.0);
    for y in row.first..=row.last {
        let line = &film.pixels()[y * width + column.first..=y * width + column.last];
        let (mut red, mut green, mut blue) = (0.0, 0.0, 0.0);
        for pixel in line {
            red += in_range(pixel[0]);
            green += in_range(pixel[1]);
            blue += in_range(pixel[2]);
        }
        // Those at the ends were counted whole.
        let (first, last) = (line[0], line[line.len() - 1]);
        let less = [1.0 - column.first_weight, if line.len() > 1 { 1.0 - column.last_weight } else { 0.0 }];
        let weight = row.weight(y);
        r += weight * (red - less[0] * in_range(first[0]) - less[1] * in_range(last[0]));
        g += weight * (green - less[0] * in_range(first[1]) - less[1] * in_range(last[1]));
        b += weight * (blue - less[0] * in_range(first[2]) - less[1] * in_range(last[2]));
    }
    let area = column.length() * row.length();
    [linear_to_srgb8(r / area), linear_to_srgb8(g / area), linear_to_srgb8(b / area)]
}

/// What a PNG can hold of a channel.
#[inline(always)]
fn in_range(value: f32) -> f64 {
    f64::from(value.clamp(0.0, 1.0))
}

/// The character of a cell without colours.
fn ramp(upper: Option<[u8; 3]>, lower: Option<[u8; 3]>) -> char {
    let light = |p: Option<[u8; 3]>| {
        let [r, g, b] = p.unwrap_or_default().map(srgb8_to_linear);
        0.2126 * r + 0.7152 * g + 0.0722 * b
    };
    let code = usize::from(linear_to_srgb8((light(upper) + light(lower)) / 2.0));
    RAMP[code * RAMP.len() / 256] as char
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::SplitMix64;
    use crate::render::TileImage;

    fn noise(width: u32, height: u32, random: &mut SplitMix64) -> TileImage {
        let pixels = (0..width * height).map(|_| [(); 3].map(|()| (random.next_u64() % 1200) as f32 / 1000.0));
        TileImage { rect: Tile { x: 0, y: 0, width, height }, pixels: pixels.collect(), ..TileImage::default() }
    }

    /// The filter again, as slowly and plainly as can be: the overlap of every film pixel with the box.
    fn brute_force(film: &Film, preview: &Preview, x: usize, y: usize) -> [f64; 3] {
        let overlap = |i: u32, start: f64, end: f64| (end.min(f64::from(i + 1)) - start.max(f64::from(i))).max(0.0);
        let (step_x, step_y) = (
            f64::from(film.width()) / preview.across.whole as f64,
            f64::from(film.height()) / preview.down.whole as f64,
        );
        let (left, top) = ((preview.across.first + x) as f64 * step_x, (preview.down.first + y) as f64 * step_y);
        let mut sum = [0.0; 3];
        for j in 0..film.height() {
            for i in 0..film.width() {
                let weight = overlap(i, left, left + step_x) * overlap(j, top, top + step_y) / (step_x * step_y);
                for (sum, value) in sum.iter_mut().zip(film.pixel(i, j)) {
                    *sum += weight * f64::from(value.clamp(0.0, 1.0));
                }
            }
        }
        sum
    }

    #[test]
    fn every_pixel_is_the_exact_mean_of_its_box_at_any_size_zoom_and_shift() {
        let mut random = SplitMix64(3);
        for _ in 0..60 {
            let mut pick = |n: u64| (random.next_u64() % n) as u32 + 1;
            let (width, height, columns, rows) = (pick(40), pick(40), pick(30) as u16, pick(20) as u16);
            let mut film = Film::new(width, height);
            film.write(&noise(width, height, &mut random));
            let mut preview = Preview::default();
            preview.set_film(width, height);
            preview.set_area(columns, rows);
            preview.zoom_by(1.0 + (random.next_u64() % 5) as f64 / 2.0);
            preview.shift((random.next_u64() % 3) as f64 - 1.0, 0.3);
            preview.refresh(&film);
            let across = preview.across.boxes.len();
            assert!(across <= columns.into() && preview.down.boxes.len() <= 2 * usize::from(rows));
            for (i, code) in preview.codes.iter().enumerate() {
                let exact = brute_force(&film, &preview, i % across, i / across);
                for (code, exact) in code.iter().zip(exact) {
                    // Equal but where the sum rounds across a code's edge.
                    assert!((linear_to_srgb8(exact - 1e-9)..=linear_to_srgb8(exact + 1e-9)).contains(code));
                }
            }
        }
    }

    #[test]
    fn tile_by_tile_gives_the_same_as_all_at_once() {
        let mut random = SplitMix64(4);
        let (mut film, mut preview) = (Film::new(50, 37), Preview::default());
        preview.set_film(50, 37);
        preview.set_area(17, 9);
        preview.zoom_by(1.7);
        preview.refresh(&film);
        for _ in 0..200 {
            let (x, y) = ((random.next_u64() % 43) as u32, (random.next_u64() % 30) as u32);
            let mut tile = noise(7, 7, &mut random);
            tile.rect = Tile { x, y, ..tile.rect };
            film.write(&tile);
            preview.mark(tile.rect);
            if x % 3 == 0 {
                preview.refresh(&film);
            }
        }
        preview.refresh(&film);
        let mut fresh = preview.clone();
        fresh.lay_out();
        fresh.refresh(&film);
        assert_eq!(preview.codes, fresh.codes);
    }

    #[test]
    fn the_fitted_picture_keeps_its_aspect_and_is_centred() {
        let mut preview = Preview::default();
        preview.set_film(1280, 720);
        preview.set_area(80, 60);
        assert_eq!((preview.across.boxes.len(), preview.down.boxes.len()), (80, 45));
        assert_eq!((preview.across.margin, preview.down.margin), (0, 36));
        preview.set_area(200, 20);
        assert_eq!((preview.across.boxes.len(), preview.down.boxes.len()), (71, 40));
        assert_eq!(preview.across.margin, 64);
    }

    #[test]
    fn zoom_and_shift_stop_at_their_limits_and_fit_returns() {
        let mut preview = Preview::default();
        preview.set_film(320, 180);
        preview.set_area(40, 20);
        for _ in 0..50 {
            preview.zoom_by(1.5);
            preview.shift(1.0, 1.0);
        }
        assert_eq!(preview.zoom(), 128.0);
        assert_eq!(preview.across.boxes.last().map(|b| b.last), Some(319));
        assert_eq!(preview.down.boxes.last().map(|b| b.last), Some(179));
        preview.shift(-1.0, 0.0);
        assert!(preview.across.boxes.last().is_some_and(|b| b.last < 319), "no shift beyond the edge is remembered");
        for _ in 0..60 {
            preview.zoom_by(1.0 / 1.5);
        }
        assert_eq!(preview.zoom(), 1.0);
        assert_eq!(preview.across.boxes.len(), 40);
    }

    #[test]
    fn every_size_of_film_and_area_can_be_painted() {
        for (width, height) in [(1, 1), (1, 999), (999, 1), (64, 64)] {
            for (columns, rows) in [(0, 0), (1, 1), (0, 5), (300, 2), (2, 100)] {
                let mut preview = Preview::default();
                preview.set_film(width, height);
                preview.set_area(columns, rows);
                preview.zoom_by(3.0);
                preview.mark(Tile { x: 0, y: 0, width, height });
                preview.refresh(&Film::new(width, height));
                let area = Rect::new(0, 0, columns, rows);
                preview.paint(area, &mut Buffer::empty(area), ColorMode::Truecolor);
                preview.paint(area, &mut Buffer::empty(area), ColorMode::None);
            }
        }
    }
}
