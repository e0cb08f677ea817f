//! Charts as PNG and SVG.

use super::axis::{Fitted, Side};
use super::{Chart, Data, PALETTE, Point, Series};
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{FontStyle, register_font};

/// Size of a chart. All lengths below are of this measure.
const WIDTH: i32 = 900;
const HEIGHT: i32 = 560;
/// Pixels of the files for each unit: sharp on dense screens too.
const DENSITY: i32 = 2;
/// The pixel picture is drawn this much larger and averaged: plotters has no smooth thick lines.
const OVERSAMPLING: i32 = 2;

/// The name of the font for plotters, and at once the list of families that a viewer of the SVG may choose from.
const FONT: &str = "Noto Sans, DejaVu Sans, Helvetica, Arial, sans-serif";
const REGULAR: &[u8] = include_bytes!("font/NotoSans-Regular.ttf");
const BOLD: &[u8] = include_bytes!("font/NotoSans-Bold.ttf");

/// How much too high the pixel backend of plotters draws texts, in sizes of their font.
const TEXT_TOO_HIGH: f64 = 0.17;

const INK: RGBColor = RGBColor(34, 34, 34);
const SOFT_INK: RGBColor = RGBColor(95, 95, 95);
const GRID: RGBColor = RGBColor(222, 222, 222);
const FAINT_GRID: RGBColor = RGBColor(241, 241, 241);
const LIMIT: RGBColor = RGBColor(178, 24, 43);

impl Chart {
    /// Width, height and sRGB codes of the chart as pixels.
    pub fn to_rgb8(&self) -> Result<(u32, u32, Vec<u8>), String> {
        let (width, height) = (WIDTH * DENSITY, HEIGHT * DENSITY);
        let fine = ((width * OVERSAMPLING) as u32, (height * OVERSAMPLING) as u32);
        let mut large = vec![255u8; fine.0 as usize * fine.1 as usize * 3];
        {
            let area = BitMapBackend::with_buffer(&mut large, fine).into_drawing_area();
            self.draw(&area, DENSITY * OVERSAMPLING, TEXT_TOO_HIGH)?;
        }
        Ok((width as u32, height as u32, averaged(&large, width as usize, height as usize)))
    }

    /// The chart as an SVG document.
    pub fn to_svg(&self) -> Result<String, String> {
        let mut text = String::new();
        {
            let size = ((WIDTH * DENSITY) as u32, (HEIGHT * DENSITY) as u32);
            let area = SVGBackend::with_string(&mut text, size).into_drawing_area();
            self.draw(&area, DENSITY, 0.0)?;
        }
        Ok(text)
    }

    fn draw<B: DrawingBackend>(&self, area: &DrawingArea<B, Shift>, unit: i32, sink: f64) -> Result<(), String> {
        let refused = |_| "the font inside the program is damaged".to_owned();
        register_font(FONT, FontStyle::Normal, REGULAR).map_err(refused)?;
        register_font(FONT, FontStyle::Bold, BOLD).map_err(refused)?;
        let pen = Pen { area, unit: f64::from(unit), sink };
        self.draw_with(&pen).and_then(|()| area.present()).map_err(|error| error.to_string())
    }

    fn draw_with<B: DrawingBackend>(&self, pen: &Pen<'_, B>) -> Drawn<B> {
        pen.area.fill(&WHITE)?;
        let (x, y) = (Fitted::new(self, Side::X), Fitted::new(self, Side::Y));
        let label_width = y.ticks.iter().map(|(_, label)| pen.width(label, 13.0)).fold(0.0, f64::max);
        let mut top = 16.0;
        pen.text(&self.title, (24.0, top), 19.0, INK, Anchor::TopLeft, true)?;
        top += 26.0;
        if !self.subtitle.is_empty() {
            pen.text(&self.subtitle, (24.0, top), 13.0, SOFT_INK, Anchor::TopLeft, false)?;
            top += 20.0;
        }
        top = self.draw_legend(pen, top + 4.0)?;
        let label_of_y = if self.y.label.is_empty() { 0.0 } else { 24.0 };
        let frame = Frame {
            left: 30.0 + label_of_y + label_width,
            right: f64::from(WIDTH) - 28.0,
            top: top + 8.0,
            bottom: f64::from(HEIGHT) - 56.0,
            x,
            y,
            lanes: self.series.iter().any(|series| matches!(series.data, Data::Spans(_))),
        };
        self.draw_grid(pen, &frame)?;
        for limit in &self.limits {
            let y = frame.at(0.0, limit.y).1;
            pen.dashed((frame.left, y), (frame.right, y), 1.5, LIMIT)?;
            pen.text(&limit.name, (frame.right - 4.0, y - 3.0), 12.0, LIMIT, Anchor::BottomRight, false)?;
        }
        let columns = self.series.iter().filter(|series| matches!(series.data, Data::Columns(_))).count();
        let mut column = 0;
        for (index, series) in self.series.iter().enumerate() {
            let color = color(index);
            match &series.data {
                Data::Guide(line) => {
                    let line: Vec<_> = line.iter().map(|p| frame.at(p.0, p.1)).collect();
                    pen.line(&line, 1.5, color)?;
                }
                Data::Line(points) => {
                    let line: Vec<_> = points.iter().filter(|p| is_drawn(p)).map(|p| frame.at(p.x, p.y)).collect();
                    let (below, above) = self.same_line(index);
                    pen.shared_line(&line, 2.0, color, (below, below + 1 + above))?;
                    self.draw_marks(pen, &frame, points, index)?;
                }
                Data::Points(points) => self.draw_marks(pen, &frame, points, index)?,
                Data::Columns(points) => {
                    let width = 0.8 / columns as f64;
                    let shift = (column as f64 - columns as f64 / 2.0) * width;
                    for p in points.iter().filter(|p| is_drawn(p)) {
                        let (left, top) = frame.at(p.x + shift + 0.04 * width, p.y);
                        let (right, bottom) = frame.at(p.x + shift + 0.96 * width, 0.0);
                        pen.fill(&[(left, top), (right, top), (right, bottom), (left, bottom)], color)?;
                        pen.spread(&frame, &Point { x: p.x + shift + 0.5 * width, ..*p }, INK)?;
                    }
                    column += 1;
                }
                Data::Spans(spans) => {
                    for span in spans {
                        let (left, middle) = frame.at(span.from, span.lane as f64);
                        let right = frame.at(span.to, 0.0).0;
                        let half = 0.38 * (frame.at(0.0, 1.0).1 - frame.at(0.0, 0.0).1).abs();
                        let (top, bottom) = (middle - half, middle + half);
                        pen.fill(&[(left, top), (right, top), (right, bottom), (left, bottom)], color)?;
                        // A hair of white keeps neighbours apart where there is room for it.
                        if right - left > 2.0 {
                            pen.line(&[(right, top), (right, bottom)], 0.5, WHITE)?;
                        }
                    }
                }
            }
        }
        Ok(())
    }

    /// How many lines of the same values are drawn before this one, and after it.
    fn same_line(&self, index: usize) -> (usize, usize) {
        let same = |series: &&Series| series.data == self.series[index].data;
        (self.series[..index].iter().filter(same).count(), self.series[index + 1..].iter().filter(same).count())
    }

    /// Entries from left to right, in as many rows as they need. Where the rows end.
    fn draw_legend<B: DrawingBackend>(&self, pen: &Pen<'_, B>, top: f64) -> Result<f64, Failed<B>> {
        let named: Vec<_> = self.series.iter().enumerate().filter(|(_, series)| !series.name.is_empty()).collect();
        let (mut left, mut top) = (24.0, top);
        if named.is_empty() {
            return Ok(top);
        }
        for (index, series) in named {
            let width = 26.0 + pen.width(&series.name, 13.0) + 18.0;
            if left > 24.0 && left + width > f64::from(WIDTH) - 20.0 {
                (left, top) = (24.0, top + 20.0);
            }
            let (y, color) = (top + 8.0, color(index));
            match &series.data {
                Data::Points(_) => pen.mark((left + 10.0, y), index, color, true, 1.0)?,
                Data::Line(_) => {
                    pen.line(&[(left, y), (left + 20.0, y)], 2.0, color)?;
                    pen.mark((left + 10.0, y), index, color, true, 1.0)?;
                }
                Data::Guide(_) => pen.line(&[(left, y), (left + 20.0, y)], 1.5, color)?,
                Data::Columns(_) | Data::Spans(_) => {
                    let (l, r, t, b) = (left + 4.0, left + 16.0, y - 6.0, y + 6.0);
                    pen.fill(&[(l, t), (r, t), (r, b), (l, b)], color)?;
                }
            }
            pen.text(&series.name, (left + 26.0, y), 13.0, INK, Anchor::Left, false)?;
            left += width;
        }
        Ok(top + 20.0)
    }

    fn draw_grid<B: DrawingBackend>(&self, pen: &Pen<'_, B>, frame: &Frame) -> Drawn<B> {
        let (left, right, top, bottom) = (frame.left, frame.right, frame.top, frame.bottom);
        let (in_x, in_y) = (self.x.names.is_empty(), self.y.names.is_empty());
        for value in &frame.x.minor {
            let x = frame.at(*value, 0.0).0;
            pen.line(&[(x, top), (x, bottom)], 1.0, FAINT_GRID)?;
        }
        for value in &frame.y.minor {
            let y = frame.at(0.0, *value).1;
            pen.line(&[(left, y), (right, y)], 1.0, FAINT_GRID)?;
        }
        let mut free = 0.0;
        for (value, label) in &frame.x.ticks {
            let x = frame.at(*value, 0.0).0;
            if in_x {
                pen.line(&[(x, top), (x, bottom)], 1.0, GRID)?;
            }
            // Labels that would touch are left out.
            let half = pen.width(label, 13.0) / 2.0;
            if x - half >= free {
                pen.text(label, (x, bottom + 8.0), 13.0, SOFT_INK, Anchor::Top, false)?;
                free = x + half + 6.0;
            }
        }
        for (value, label) in &frame.y.ticks {
            let y = frame.at(0.0, *value).1;
            if in_y {
                pen.line(&[(left, y), (right, y)], 1.0, GRID)?;
            }
            pen.text(label, (left - 8.0, y), 13.0, SOFT_INK, Anchor::Right, false)?;
        }
        pen.line(&[(left, bottom), (right, bottom)], 1.2, SOFT_INK)?;
        pen.line(&[(left, top), (left, bottom)], 1.2, SOFT_INK)?;
        pen.text(&self.x.label, ((left + right) / 2.0, bottom + 32.0), 14.0, INK, Anchor::Top, false)?;
        pen.upward(&self.y.label, (30.0, (top + bottom) / 2.0), 14.0, INK)
    }

    fn draw_marks<B: DrawingBackend>(
        &self,
        pen: &Pen<'_, B>,
        frame: &Frame,
        points: &[Point],
        index: usize,
    ) -> Drawn<B> {
        for p in points.iter().filter(|p| is_drawn(p)) {
            pen.spread(frame, p, color(index))?;
            let solid = !frame.y.is_below(p.y) && !frame.x.is_below(p.x);
            let at = frame.at(p.x, p.y);
            // Where later marks lie on it, it shows as their rim.
            let covers = |other: &Point| {
                let (x, y) = frame.at(other.x, other.y);
                is_drawn(other) && (x - at.0).hypot(y - at.1) < 4.0
            };
            let above = self.series[index + 1..].iter().filter(|later| later.data.points().iter().any(covers)).count();
            pen.mark(at, index, color(index), solid, 1.0 + 0.4 * above as f64)?;
        }
        Ok(())
    }
}

/// A strip of this width with a coloured square before each text, dark on white, to stand below a picture: its height
/// and sRGB codes.
pub fn legend(width: u32, entries: &[(String, [u8; 3])]) -> Result<(u32, Vec<u8>), String> {
    let refused = |_| "the font inside the program is damaged".to_owned();
    register_font(FONT, FontStyle::Normal, REGULAR).map_err(refused)?;
    const ROW: u32 = 24;
    // Where each entry stands, once its text has been measured.
    let mut places = Vec::new();
    let mut empty = [255; 3];
    {
        let area = BitMapBackend::with_buffer(&mut empty, (1, 1)).into_drawing_area();
        let pen = Pen { area: &area, unit: 1.0, sink: TEXT_TOO_HIGH };
        let (mut left, mut row) = (12.0, 0);
        for (text, _) in entries {
            let wide = 18.0 + pen.width(text, 13.0) + 18.0;
            if left > 12.0 && left + wide > f64::from(width) {
                (left, row) = (12.0, row + 1);
            }
            places.push((left, f64::from(row * ROW) + 18.0));
            left += wide;
        }
    }
    let rows = places.last().map_or(0, |(_, y)| *y as u32 / ROW + 1);
    let (height, n) = (rows * ROW + 12, OVERSAMPLING as u32);
    let mut large = vec![255u8; (width * n * height * n * 3) as usize];
    {
        let area = BitMapBackend::with_buffer(&mut large, (width * n, height * n)).into_drawing_area();
        let pen = Pen { area: &area, unit: f64::from(n), sink: TEXT_TOO_HIGH };
        let draw = || {
            for ((text, [r, g, b]), (x, y)) in entries.iter().zip(&places) {
                let square = |half: f64, color: RGBColor| {
                    let (x, y) = (x + 6.0, *y);
                    pen.fill(
                        &[(x - half, y - half), (x + half, y - half), (x + half, y + half), (x - half, y + half)],
                        color,
                    )
                };
                // A rim, so that white is seen on white.
                square(6.5, SOFT_INK)?;
                square(5.5, RGBColor(*r, *g, *b))?;
                pen.text(text, (x + 18.0, *y), 13.0, INK, Anchor::Left, false)?;
            }
            area.present()
        };
        draw().map_err(|error| error.to_string())?;
    }
    Ok((height, averaged(&large, width as usize, height as usize)))
}

/// Every pixel the mean of the finer ones.
fn averaged(large: &[u8], width: usize, height: usize) -> Vec<u8> {
    let n = OVERSAMPLING as usize;
    let stride = width * n * 3;
    let mut small = Vec::with_capacity(width * height * 3);
    for y in 0..height {
        for x in 0..width {
            for channel in 0..3 {
                let sum: usize =
                    (0..n * n).map(|i| large[(y * n + i / n) * stride + (x * n + i % n) * 3 + channel] as usize).sum();
                small.push(((sum + n * n / 2) / (n * n)) as u8);
            }
        }
    }
    small
}

type Failed<B> = DrawingAreaErrorKind<<B as DrawingBackend>::ErrorType>;
type Drawn<B> = Result<(), Failed<B>>;

fn is_drawn(point: &Point) -> bool {
    point.x.is_finite() && point.y.is_finite()
}

fn color(index: usize) -> RGBColor {
    let [r, g, b] = PALETTE[index % PALETTE.len()].0;
    RGBColor(r, g, b)
}

/// The rectangle of the data.
struct Frame {
    left: f64,
    right: f64,
    top: f64,
    bottom: f64,
    x: Fitted,
    y: Fitted,
    /// Whether y counts downward.
    lanes: bool,
}

impl Frame {
    fn at(&self, x: f64, y: f64) -> (f64, f64) {
        let up = if self.lanes { 1.0 - self.y.place(y) } else { self.y.place(y) };
        (self.left + (self.right - self.left) * self.x.place(x), self.bottom - (self.bottom - self.top) * up)
    }
}

/// Which point of a text is given.
#[derive(Clone, Copy)]
enum Anchor {
    TopLeft,
    Top,
    Left,
    Right,
    BottomRight,
}

/// Draws in units instead of pixels.
struct Pen<'a, B: DrawingBackend> {
    area: &'a DrawingArea<B, Shift>,
    unit: f64,
    /// How much lower than told texts are put, in sizes of their font.
    sink: f64,
}

impl<B: DrawingBackend> Pen<'_, B> {
    fn px(&self, (x, y): (f64, f64)) -> (i32, i32) {
        ((x * self.unit).round() as i32, (y * self.unit).round() as i32)
    }

    /// Plotters gives the size of a line of text, 1.24 times that of its letters.
    fn font(&self, size: f64, bold: bool) -> FontDesc<'static> {
        let style = if bold { FontStyle::Bold } else { FontStyle::Normal };
        FontDesc::new(FontFamily::Name(FONT), size * 1.24 * self.unit, style)
    }

    fn width(&self, text: &str, size: f64) -> f64 {
        self.font(size, false).box_size(text).map_or(0.0, |(width, _)| f64::from(width) / self.unit)
    }

    fn text(&self, text: &str, at: (f64, f64), size: f64, color: RGBColor, anchor: Anchor, bold: bool) -> Drawn<B> {
        let (h, v) = match anchor {
            Anchor::TopLeft => (HPos::Left, VPos::Top),
            Anchor::Top => (HPos::Center, VPos::Top),
            Anchor::Left => (HPos::Left, VPos::Center),
            Anchor::Right => (HPos::Right, VPos::Center),
            Anchor::BottomRight => (HPos::Right, VPos::Bottom),
        };
        let style = TextStyle::from(self.font(size, bold)).color(&color).pos(Pos::new(h, v));
        let at = (at.0, at.1 + self.sink * size);
        self.area.draw(&Text::new(text.to_owned(), self.px(at), style))
    }

    /// Text that runs upward, centred.
    fn upward(&self, text: &str, at: (f64, f64), size: f64, color: RGBColor) -> Drawn<B> {
        let font = self.font(size, false).transform(FontTransform::Rotate270);
        let style = TextStyle::from(font).color(&color).pos(Pos::new(HPos::Center, VPos::Center));
        self.area.draw(&Text::new(text.to_owned(), self.px(at), style))
    }

    /// Segment by segment: plotters joins thick ones in spikes that reach beyond any picture where a line turns back.
    fn line(&self, points: &[(f64, f64)], width: f64, color: RGBColor) -> Drawn<B> {
        let thick = (width * self.unit).round() as u32;
        for pair in points.windows(2) {
            let ends = vec![self.px(pair[0]), self.px(pair[1])];
            self.area.draw(&PathElement::new(ends, color.stroke_width(thick)))?;
        }
        for joint in points.iter().skip(1).take(points.len().saturating_sub(2)) {
            self.area.draw(&Circle::new(self.px(*joint), thick / 2, color.filled()))?;
        }
        Ok(())
    }

    /// One of several lines in the same place: each of them has its turn, dash by dash. `turn`: which, of how many.
    fn shared_line(&self, points: &[(f64, f64)], width: f64, color: RGBColor, (turn, of): (usize, usize)) -> Drawn<B> {
        if of == 1 {
            return self.line(points, width, color);
        }
        const DASH: f64 = 9.0;
        let (mut run, period) = (0.0, DASH * of as f64);
        for pair in points.windows(2) {
            let ((ax, ay), (bx, by)) = (pair[0], pair[1]);
            let length = (bx - ax).hypot(by - ay);
            let at = |s: f64| (ax + (bx - ax) * s / length, ay + (by - ay) * s / length);
            // Dashes begin where the whole way is their turn past a period.
            let mut start = ((run / period).floor()) * period + DASH * turn as f64 - run;
            while start < length {
                let (from, to) = (start.max(0.0), (start + DASH).min(length));
                if from < to {
                    self.line(&[at(from), at(to)], width, color)?;
                }
                start += period;
            }
            run += length;
        }
        Ok(())
    }

    fn dashed(&self, from: (f64, f64), to: (f64, f64), width: f64, color: RGBColor) -> Drawn<B> {
        let mut x = from.0;
        while x < to.0 {
            self.line(&[(x, from.1), ((x + 6.0).min(to.0), to.1)], width, color)?;
            x += 10.0;
        }
        Ok(())
    }

    fn fill(&self, points: &[(f64, f64)], color: RGBColor) -> Drawn<B> {
        let points: Vec<_> = points.iter().map(|p| self.px(*p)).collect();
        self.area.draw(&Polygon::new(points, color.filled()))
    }

    /// A mark whose form goes with the colour, so that charts can be read in grey too.
    fn mark(&self, (x, y): (f64, f64), index: usize, color: RGBColor, solid: bool, size: f64) -> Drawn<B> {
        const FORMS: [&[(f64, f64)]; 6] = [
            &[],
            &[(-0.88, -0.88), (0.88, -0.88), (0.88, 0.88), (-0.88, 0.88)],
            &[(0.0, -1.15), (1.1, 0.8), (-1.1, 0.8)],
            &[(0.0, -1.25), (1.25, 0.0), (0.0, 1.25), (-1.25, 0.0)],
            &[(0.0, 1.15), (1.1, -0.8), (-1.1, -0.8)],
            &[
                (-1.2, -0.4),
                (-0.4, -0.4),
                (-0.4, -1.2),
                (0.4, -1.2),
                (0.4, -0.4),
                (1.2, -0.4),
                (1.2, 0.4),
                (0.4, 0.4),
                (0.4, 1.2),
                (-0.4, 1.2),
                (-0.4, 0.4),
                (-1.2, 0.4),
            ],
        ];
        let form = FORMS[index % FORMS.len()];
        let shape = |radius: f64, color: RGBColor| {
            if form.is_empty() {
                let radius = (radius * self.unit).round() as i32;
                self.area.draw(&Circle::new(self.px((x, y)), radius, color.filled()))
            } else {
                self.fill(&form.iter().map(|(dx, dy)| (x + dx * radius, y + dy * radius)).collect::<Vec<_>>(), color)
            }
        };
        // A rim of white parts marks that lie over each other.
        shape(4.6 * size + 1.0, WHITE)?;
        shape(4.6 * size, color)?;
        if solid { Ok(()) } else { shape(2.8 * size, WHITE) }
    }

    /// The vertical bar of a point's spread.
    fn spread(&self, frame: &Frame, point: &Point, color: RGBColor) -> Drawn<B> {
        let Some((low, high)) = point.spread else { return Ok(()) };
        let (x, low) = frame.at(point.x, low);
        let high = frame.at(point.x, high).1;
        self.line(&[(x, low), (x, high)], 1.2, color)?;
        for end in [low, high] {
            self.line(&[(x - 3.0, end), (x + 3.0, end)], 1.2, color)?;
        }
        Ok(())
    }
}
