//! A drawing of lines, areas and text as SVG; the command line paints it as PNG, too.

use quick_xml::escape::escape;
use std::f64::consts::TAU;

/// A place or a direction; lengths in the unit of the drawing, x to the right, y down.
pub type Point = [f64; 2];

/// An opaque colour, red, green, blue.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ink(pub [u8; 3]);

/// Text and axes.
pub const BLACK: Ink = Ink([0x22, 0x22, 0x22]);
/// The ground.
pub const WHITE: Ink = Ink([0xff, 0xff, 0xff]);
/// Curves; dark, so that a grey print keeps the contrast.
pub const BLUE: Ink = Ink([0x1f, 0x4e, 0x79]);

/// The point of a text that lies at its place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Anchor {
    /// The left end of the base line.
    Start,
    /// The middle of the base line.
    Middle,
    /// The right end of the base line.
    End,
}

/// A part of a drawing.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// Straight lines from point to point.
    Line {
        /// The points.
        points: Vec<Point>,
        /// The width of the stroke.
        width: f64,
        /// The colour.
        ink: Ink,
        /// Dashes and gaps by turns, which run on around corners; empty for a solid line.
        dash: &'static [f64],
    },
    /// A filled polygon.
    Area {
        /// The corners.
        points: Vec<Point>,
        /// The colour.
        ink: Ink,
    },
    /// A filled circle.
    Disc {
        /// The middle.
        at: Point,
        /// The radius.
        radius: f64,
        /// The colour.
        ink: Ink,
    },
    /// A line of text in black.
    Text {
        /// The place of the anchor.
        at: Point,
        /// The height of the font.
        size: f64,
        /// The anchor.
        anchor: Anchor,
        /// The text.
        text: String,
        /// True if it runs upwards.
        upright: bool,
    },
}

/// Shapes on white, the later ones on top.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Drawing {
    /// Width and height.
    pub size: [f64; 2],
    /// The unit of lengths.
    pub unit: Unit,
    /// The shapes.
    pub shapes: Vec<Shape>,
}

/// The unit of a drawing.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Unit {
    /// For the screen; files have hundredths.
    #[default]
    Pixel,
    /// True size; files have tenths of a micrometre.
    Millimetre,
}

/// The rectangle of a plot, with the ranges of x and y that it shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// Left and right, bottom and top.
    pub ends: [[f64; 2]; 2],
    /// First and last value along x, lowest and highest one along y.
    pub ranges: [[f64; 2]; 2],
}

impl Frame {
    /// The place of a point of the data.
    pub fn at(&self, point: Point) -> Point {
        std::array::from_fn(|i| {
            let ([first, last], [low, high]) = (self.ends[i], self.ranges[i]);
            first + (last - first) * (point[i] - low) / (high - low)
        })
    }
}

impl Shape {
    /// A solid line.
    pub fn line(points: Vec<Point>, width: f64, ink: Ink) -> Shape {
        Shape::Line { points, width, ink, dash: &[] }
    }

    /// A text from left to right.
    pub fn text(at: Point, size: f64, anchor: Anchor, text: impl Into<String>) -> Shape {
        Shape::Text { at, size, anchor, text: text.into(), upright: false }
    }

    /// The shape, moved by this way.
    pub fn moved(mut self, [x, y]: Point) -> Shape {
        let shift = |at: &mut Point| *at = [at[0] + x, at[1] + y];
        match &mut self {
            Shape::Line { points, .. } | Shape::Area { points, .. } => points.iter_mut().for_each(shift),
            Shape::Disc { at, .. } | Shape::Text { at, .. } => shift(at),
        }
        self
    }

    fn svg(&self, unit: Unit) -> String {
        let length = |length: f64| unit.rounded(length);
        let list = |points: &[Point]| {
            points.iter().map(|[x, y]| format!("{},{}", length(*x), length(*y))).collect::<Vec<_>>().join(" ")
        };
        match self {
            Shape::Line { points, width, ink, dash } => {
                let dash: Vec<String> = dash.iter().map(f64::to_string).collect();
                let dash =
                    if dash.is_empty() { dash.concat() } else { format!(" stroke-dasharray=\"{}\"", dash.join(" ")) };
                let (points, ink) = (list(points), ink.css());
                format!("<polyline points=\"{points}\" fill=\"none\" stroke=\"{ink}\" stroke-width=\"{width}\"{dash}/>")
            }
            Shape::Area { points, ink } => format!("<polygon points=\"{}\" fill=\"{}\"/>", list(points), ink.css()),
            Shape::Disc { at: [x, y], radius, ink } => {
                format!("<circle cx=\"{}\" cy=\"{}\" r=\"{radius}\" fill=\"{}\"/>", length(*x), length(*y), ink.css())
            }
            Shape::Text { at, size, anchor, text, upright } => {
                let ([x, y], size) = (at.map(length), length(*size));
                let turn = if *upright { format!(" transform=\"rotate(-90 {x} {y})\"") } else { String::new() };
                let anchor = format!("{anchor:?}").to_lowercase();
                let (ink, text) = (BLACK.css(), escape(text));
                format!(
                    "<text x=\"{x}\" y=\"{y}\" font-size=\"{size}\" text-anchor=\"{anchor}\" fill=\"{ink}\"{turn}>{text}</text>"
                )
            }
        }
    }
}

/// Points of an arc, two degrees apart, from one angle to another (rad), counter-clockwise to a larger one.
pub fn arc([x, y]: Point, radius: f64, [from, to]: [f64; 2]) -> Vec<Point> {
    let parts = (180.0 * (to - from).abs() / TAU).ceil().max(1.0);
    let angle = |i: usize| from + (to - from) * i as f64 / parts;
    (0..=parts as usize).map(|i| [x + radius * angle(i).cos(), y - radius * angle(i).sin()]).collect()
}

impl Drawing {
    /// The drawing as an `svg` element with `label` for screen readers, shown `scale` times as large.
    pub fn svg(&self, label: &str, scale: f64) -> String {
        let [width, height] = self.size.map(|length| self.unit.rounded(length));
        let [shown, high] = self.size.map(|length| self.unit.rounded(scale * length));
        let (unit, label, white) = (self.unit.name(), escape(label), WHITE.css());
        let mut text = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{shown}{unit}\" height=\"{high}{unit}\" \
             viewBox=\"0 0 {width} {height}\" font-family=\"sans-serif\" stroke-linejoin=\"round\" role=\"img\" \
             aria-label=\"{label}\">\n<rect width=\"{width}\" height=\"{height}\" fill=\"{white}\"/>\n"
        );
        for shape in &self.shapes {
            text += &(shape.svg(self.unit) + "\n");
        }
        text + "</svg>\n"
    }
}

impl Unit {
    fn name(self) -> &'static str {
        if self == Unit::Pixel { "" } else { "mm" }
    }

    /// A length as in files; a zero has no sign.
    fn rounded(self, length: f64) -> f64 {
        let parts = if self == Unit::Pixel { 1e2 } else { 1e4 };
        (parts * length).round() / parts + 0.0
    }
}

impl Ink {
    fn css(self) -> String {
        let [r, g, b] = self.0;
        format!("#{r:02x}{g:02x}{b:02x}")
    }
}
