//! One description of a chart, drawn as PNG, as SVG and in the terminal.

mod axis;
mod draw;
mod terminal;

pub use draw::legend;
pub use terminal::TerminalStyle;

/// What is drawn: nothing here knows pixels or characters.
#[derive(Clone, Debug, PartialEq)]
pub struct Chart {
    /// What is seen, in bold.
    pub title: String,
    /// Under what conditions; may be empty.
    pub subtitle: String,
    /// To the right.
    pub x: Axis,
    /// Upward.
    pub y: Axis,
    /// The first takes the first colour, and so on.
    pub series: Vec<Series>,
    /// Dashed horizontal lines.
    pub limits: Vec<Limit>,
}

/// How values lie along a side of the chart.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    /// Quantity and unit: `time (s)`.
    pub label: String,
    /// Spacing.
    pub scale: Scale,
    /// Values at both ends; else as the data ask for.
    pub range: Option<(f64, f64)>,
    /// For an axis of things instead of numbers: the names of 0, 1, 2...
    pub names: Vec<String>,
}

/// Spacing of an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// Equal differences are equally far apart.
    Linear,
    /// Equal ratios are. What is not above 0 is drawn at the lower end, hollow.
    Log,
}

/// Data of one name and colour.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    /// In the legend; the series has no entry there if it is empty.
    pub name: String,
    /// Where and how.
    pub data: Data,
}

/// Data and how they are drawn.
#[derive(Clone, Debug, PartialEq)]
pub enum Data {
    /// Marks.
    Points(Vec<Point>),
    /// Marks joined by lines, in the order given.
    Line(Vec<Point>),
    /// A thin line through (x, y) without marks: a model, an ideal, a front.
    Guide(Vec<(f64, f64)>),
    /// Columns of height y at x = 0, 1, 2...; those of several series stand side by side.
    Columns(Vec<Point>),
    /// Stretches `from..to` of x in the lanes 0, 1, 2... of y, counted from above.
    Spans(Vec<Span>),
}

/// A measured point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// To the right.
    pub x: f64,
    /// Upward.
    pub y: f64,
    /// How far it scatters: the ends of a vertical bar.
    pub spread: Option<(f64, f64)>,
}

/// A stretch of time in a lane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Span {
    /// Which lane.
    pub lane: usize,
    /// Begin.
    pub from: f64,
    /// End.
    pub to: f64,
}

/// A value of y that must be reached or not be exceeded.
#[derive(Clone, Debug, PartialEq)]
pub struct Limit {
    /// What it means.
    pub name: String,
    /// Where it is.
    pub y: f64,
}

impl Point {
    /// A point without spread.
    pub fn new(x: f64, y: f64) -> Self {
        Self { x, y, spread: None }
    }
}

impl Axis {
    /// Of equal differences.
    pub fn linear(label: impl Into<String>) -> Self {
        Self { label: label.into(), scale: Scale::Linear, range: None, names: Vec::new() }
    }

    /// Of equal ratios.
    pub fn log(label: impl Into<String>) -> Self {
        Self { scale: Scale::Log, ..Self::linear(label) }
    }

    /// Of things.
    pub fn names(label: impl Into<String>, names: Vec<String>) -> Self {
        Self { names, ..Self::linear(label) }
    }
}

impl Data {
    /// Marked points, if it has any.
    fn points(&self) -> &[Point] {
        match self {
            Self::Points(points) | Self::Line(points) | Self::Columns(points) => points,
            Self::Guide(_) | Self::Spans(_) => &[],
        }
    }
}

/// Eight colours that are told apart with any kind of colour vision, the lightest last (Okabe and Ito 2008; their
/// yellow is left out, since it vanishes on white). Each with the nearest of a terminal's 256.
const PALETTE: [([u8; 3], u8); 7] = [
    ([0, 114, 178], 32),
    ([213, 94, 0], 166),
    ([0, 158, 115], 36),
    ([204, 121, 167], 175),
    ([86, 180, 233], 75),
    ([230, 159, 0], 214),
    ([110, 110, 110], 244),
];

#[cfg(test)]
mod tests {
    use super::*;

    pub(super) fn example() -> Chart {
        let points = |factor: f64| -> Vec<Point> {
            (0..6).map(|i| Point::new(f64::from(1 << i), factor / f64::from(1 << i))).collect()
        };
        Chart {
            title: "Error against <time> & \"more\"".to_owned(),
            subtitle: "made up".to_owned(),
            x: Axis::log("time (s)"),
            y: Axis::log("error (codes)"),
            series: vec![
                Series { name: "first".to_owned(), data: Data::Line(points(3.0)) },
                Series { name: "second".to_owned(), data: Data::Points(points(0.5)) },
                Series { name: "never".to_owned(), data: Data::Points(vec![Point::new(4.0, 0.0)]) },
            ],
            limits: vec![Limit { name: "wanted".to_owned(), y: 1.0 }],
        }
    }

    #[test]
    fn a_picture_has_every_series_in_its_colour_and_much_white() {
        let (width, height, pixels) = example().to_rgb8().unwrap();
        assert_eq!(pixels.len(), width as usize * height as usize * 3);
        let count = |color: [u8; 3]| pixels.chunks(3).filter(|pixel| *pixel == color).count();
        for (color, _) in &PALETTE[..3] {
            assert!(count(*color) > 50, "{color:?}");
        }
        assert!(count([255; 3]) * 10 > 8 * pixels.len() / 3);
    }

    #[test]
    fn a_legend_is_as_wide_as_asked_and_has_every_colour() {
        let entries = [("first".to_owned(), [200, 10, 20]), ("second".to_owned(), [10, 200, 20])];
        for (width, rows) in [(300, 1), (100, 2)] {
            let (height, pixels) = legend(width, &entries).unwrap();
            assert_eq!(pixels.len(), (width * height * 3) as usize);
            assert_eq!((height - 12) / 24, rows);
            for (_, color) in &entries {
                assert!(pixels.chunks(3).filter(|pixel| pixel == color).count() > 80);
            }
        }
        assert_eq!(legend(100, &[]).unwrap().0, 12);
    }

    #[test]
    fn the_vector_picture_has_the_texts_as_text_and_nothing_unescaped() {
        let svg = example().to_svg().unwrap();
        for text in ["Error against &lt;time&gt; &amp;", "made up", "time (s)", "error (codes)", "first", "wanted"] {
            assert!(svg.contains(text), "{text} in {svg}");
        }
        assert!(!svg.contains("<time>"));
    }

    #[test]
    fn charts_without_data_or_of_one_point_are_drawn() {
        for series in [
            vec![],
            vec![Series { name: "one".to_owned(), data: Data::Line(vec![Point::new(3.0, 3.0)]) }],
            vec![Series { name: "none".to_owned(), data: Data::Points(vec![Point::new(f64::NAN, 0.0)]) }],
        ] {
            for (x, y) in [(Axis::log("x"), Axis::log("y")), (Axis::linear("x"), Axis::linear("y"))] {
                let chart = Chart { series: series.clone(), x, y, ..example() };
                chart.to_rgb8().unwrap();
                chart.to_svg().unwrap();
                chart.to_terminal(TerminalStyle { width: 20, height: 6, color: true });
            }
        }
    }
}
