//! A drawing of lines, areas and text, given out as SVG here; the command line paints it as PNG, too.

/// A place or a direction; lengths in pixels, x to the right, y down.
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

/// Which point of a text lies at its place.
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
        /// Dash and gap, which run on around corners; None for a solid line.
        dash: Option<[f64; 2]>,
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
        /// Where the anchor lies.
        at: Point,
        /// The height of the font.
        size: f64,
        /// The anchor.
        anchor: Anchor,
        /// The text.
        text: String,
        /// Whether it runs upwards.
        upright: bool,
    },
}

/// Shapes on white, the later ones on top.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Drawing {
    /// Width and height.
    pub size: [u32; 2],
    /// The shapes.
    pub shapes: Vec<Shape>,
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
    /// Where a point of the data lies.
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
        Shape::Line { points, width, ink, dash: None }
    }

    /// A text from left to right.
    pub fn text(at: Point, size: f64, anchor: Anchor, text: impl Into<String>) -> Shape {
        Shape::Text { at, size, anchor, text: text.into(), upright: false }
    }

    fn svg(&self) -> String {
        let list = |points: &[Point]| {
            let pairs: Vec<String> = points.iter().map(|[x, y]| format!("{},{}", rounded(*x), rounded(*y))).collect();
            pairs.join(" ")
        };
        match self {
            Shape::Line { points, width, ink, dash } => format!(
                "<polyline points=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"{width}\" stroke-linejoin=\"round\"{}/>",
                list(points),
                ink.css(),
                dash.map_or(String::new(), |[dash, gap]| format!(" stroke-dasharray=\"{dash} {gap}\""))
            ),
            Shape::Area { points, ink } => format!("<polygon points=\"{}\" fill=\"{}\"/>", list(points), ink.css()),
            Shape::Disc { at: [x, y], radius, ink } => {
                format!("<circle cx=\"{}\" cy=\"{}\" r=\"{radius}\" fill=\"{}\"/>", rounded(*x), rounded(*y), ink.css())
            }
            Shape::Text { at, size, anchor, text, upright } => {
                let [x, y] = at.map(rounded);
                let turn = if *upright { format!(" transform=\"rotate(-90 {x} {y})\"") } else { String::new() };
                format!(
                    "<text x=\"{x}\" y=\"{y}\" font-size=\"{size}\" font-family=\"sans-serif\" text-anchor=\"{}\" \
                     fill=\"{}\"{turn}>{}</text>",
                    format!("{anchor:?}").to_lowercase(),
                    BLACK.css(),
                    escaped(text)
                )
            }
        }
    }
}

impl Drawing {
    /// The drawing as an `svg` element that reads `label` to those who cannot see it, shown `scale` times as large.
    pub fn svg(&self, label: &str, scale: f64) -> String {
        let [width, height] = self.size;
        let [shown, high] = self.size.map(|length| rounded(scale * f64::from(length)));
        let mut text = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{shown}\" height=\"{high}\" viewBox=\"0 0 {width} {height}\" \
             role=\"img\" aria-label=\"{}\">\n<rect width=\"{width}\" height=\"{height}\" fill=\"{}\"/>\n",
            escaped(label),
            WHITE.css()
        );
        for shape in &self.shapes {
            text += &(shape.svg() + "\n");
        }
        text + "</svg>\n"
    }
}

impl Ink {
    fn css(self) -> String {
        let [r, g, b] = self.0;
        format!("#{r:02x}{g:02x}{b:02x}")
    }
}

/// To a hundredth of a pixel, without the sign of a zero.
fn rounded(length: f64) -> f64 {
    (100.0 * length).round() / 100.0 + 0.0
}

/// A text as XML has it.
pub fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;")
}
