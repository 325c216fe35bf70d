//! A drawing of lines, areas and text, given out as SVG (for the documentation) and as PNG (for importers).
//!
//! The text of the PNG is drawn with an embedded font: a machine without fonts draws the same picture.

use super::xml::{Xml, number};
use camdrive::drives::Fault;
use tiny_skia::{Color, FillRule, LineCap, LineJoin, Paint, PathBuilder, Pixmap, Stroke, Transform};
use ttf_parser::{Face, OutlineBuilder};

/// An opaque colour, red, green, blue.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ink(pub [u8; 3]);

/// Text and axes.
pub const BLACK: Ink = Ink([0x22, 0x22, 0x22]);
/// Grid lines; light enough for print.
pub const GREY: Ink = Ink([0xcc, 0xcc, 0xcc]);
/// Curves; dark, so that a grey print keeps the contrast.
pub const BLUE: Ink = Ink([0x1f, 0x4e, 0x79]);
/// Areas.
pub const PALE: Ink = Ink([0xdd, 0xe6, 0xef]);

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

/// A part of a drawing; lengths in pixels, x to the right, y down.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// Straight lines from point to point.
    Line {
        /// The points.
        points: Vec<[f64; 2]>,
        /// The width of the stroke.
        width: f64,
        /// The colour.
        ink: Ink,
    },
    /// A filled polygon.
    Area {
        /// The corners.
        points: Vec<[f64; 2]>,
        /// The colour.
        ink: Ink,
    },
    /// A line of text in black.
    Text {
        /// Where the anchor lies.
        at: [f64; 2],
        /// The height of the font.
        size: f64,
        /// The anchor.
        anchor: Anchor,
        /// The text.
        text: String,
    },
}

/// Shapes on white, the later ones on top.
#[derive(Clone, Debug, PartialEq)]
pub struct Drawing {
    /// Width.
    pub width: u32,
    /// Height.
    pub height: u32,
    /// The shapes.
    pub shapes: Vec<Shape>,
}

impl Ink {
    fn css(self) -> String {
        let [r, g, b] = self.0;
        format!("#{r:02x}{g:02x}{b:02x}")
    }

    fn paint(self) -> Paint<'static> {
        let [r, g, b] = self.0;
        let mut paint = Paint::default();
        paint.set_color_rgba8(r, g, b, 255);
        paint
    }
}

/// To a hundredth of a pixel.
fn rounded(length: f64) -> f64 {
    (100.0 * length).round() / 100.0
}

impl Drawing {
    /// Writes the drawing as an `svg` element that reads `label` to those who cannot see it.
    pub fn write_svg(&self, xml: &mut Xml, label: &str) {
        let attributes = [
            ("xmlns", "http://www.w3.org/2000/svg".to_owned()),
            ("viewBox", format!("0 0 {} {}", self.width, self.height)),
            ("width", self.width.to_string()),
            ("height", self.height.to_string()),
            ("role", "img".to_owned()),
            ("aria-label", label.to_owned()),
        ];
        xml.element("svg", &attributes, |xml| {
            for shape in &self.shapes {
                shape.write_svg(xml);
            }
        });
    }

    /// The drawing as a PNG file.
    pub fn png(&self) -> Result<Vec<u8>, Fault> {
        let fault = |what: &str| Fault(format!("the picture cannot be drawn: {what}"));
        let mut image = Pixmap::new(self.width, self.height).ok_or_else(|| fault("it has no area"))?;
        image.fill(Color::WHITE);
        let face = Face::parse(dejavu::sans::regular(), 0).map_err(|e| fault(&e.to_string()))?;
        for shape in &self.shapes {
            shape.paint(&mut image, &face);
        }
        image.encode_png().map_err(|e| fault(&e.to_string()))
    }
}

impl Shape {
    fn write_svg(&self, xml: &mut Xml) {
        let list = |points: &[[f64; 2]]| {
            let pairs: Vec<String> = points.iter().map(|[x, y]| format!("{},{}", rounded(*x), rounded(*y))).collect();
            pairs.join(" ")
        };
        match self {
            Shape::Line { points, width, ink } => xml.empty(
                "polyline",
                &[
                    ("points", list(points)),
                    ("fill", "none".to_owned()),
                    ("stroke", ink.css()),
                    ("stroke-width", width.to_string()),
                    ("stroke-linejoin", "round".to_owned()),
                ],
            ),
            Shape::Area { points, ink } => xml.empty("polygon", &[("points", list(points)), ("fill", ink.css())]),
            Shape::Text { at, size, anchor, text } => {
                let anchor = match anchor {
                    Anchor::Start => "start",
                    Anchor::Middle => "middle",
                    Anchor::End => "end",
                };
                let attributes = [
                    ("x", number(rounded(at[0]))),
                    ("y", number(rounded(at[1]))),
                    ("font-size", number(*size)),
                    ("font-family", "sans-serif".to_owned()),
                    ("text-anchor", anchor.to_owned()),
                    ("fill", BLACK.css()),
                ];
                xml.text("text", &attributes, text);
            }
        }
    }

    fn paint(&self, image: &mut Pixmap, face: &Face) {
        match self {
            Shape::Line { points, width, ink } => {
                let Some(path) = path(points, false) else { return };
                let stroke = Stroke {
                    width: *width as f32,
                    line_cap: LineCap::Butt,
                    line_join: LineJoin::Round,
                    ..Stroke::default()
                };
                image.stroke_path(&path, &ink.paint(), &stroke, Transform::identity(), None);
            }
            Shape::Area { points, ink } => {
                let Some(path) = path(points, true) else { return };
                image.fill_path(&path, &ink.paint(), FillRule::Winding, Transform::identity(), None);
            }
            Shape::Text { at, size, anchor, text } => {
                let mut pen = Pen::new(face, *size);
                pen.x = match anchor {
                    Anchor::Start => at[0],
                    Anchor::Middle => at[0] - pen.length(text) / 2.0,
                    Anchor::End => at[0] - pen.length(text),
                } as f32;
                pen.y = at[1] as f32;
                pen.write(text);
                if let Some(path) = pen.path.finish() {
                    image.fill_path(&path, &BLACK.paint(), FillRule::Winding, Transform::identity(), None);
                }
            }
        }
    }
}

fn path(points: &[[f64; 2]], closed: bool) -> Option<tiny_skia::Path> {
    let mut path = PathBuilder::new();
    for (i, [x, y]) in points.iter().enumerate() {
        if i == 0 {
            path.move_to(*x as f32, *y as f32);
        } else {
            path.line_to(*x as f32, *y as f32);
        }
    }
    if closed {
        path.close();
    }
    path.finish()
}

/// Writes the outlines of glyphs along a base line.
struct Pen<'a> {
    face: &'a Face<'a>,
    /// Pixels per font unit.
    scale: f32,
    /// The current place on the base line.
    x: f32,
    y: f32,
    path: PathBuilder,
}

impl<'a> Pen<'a> {
    fn new(face: &'a Face<'a>, size: f64) -> Self {
        let scale = size as f32 / f32::from(face.units_per_em());
        Pen { face, scale, x: 0.0, y: 0.0, path: PathBuilder::new() }
    }

    fn advance(&self, c: char) -> f32 {
        let glyph = self.face.glyph_index(c).unwrap_or_default();
        self.scale * f32::from(self.face.glyph_hor_advance(glyph).unwrap_or(0))
    }

    fn length(&self, text: &str) -> f64 {
        text.chars().map(|c| f64::from(self.advance(c))).sum()
    }

    fn write(&mut self, text: &str) {
        let face = self.face;
        for c in text.chars() {
            let advance = self.advance(c);
            face.outline_glyph(face.glyph_index(c).unwrap_or_default(), self);
            self.x += advance;
        }
    }
}

/// Font units have y upwards.
impl OutlineBuilder for Pen<'_> {
    fn move_to(&mut self, x: f32, y: f32) {
        self.path.move_to(self.x + self.scale * x, self.y - self.scale * y);
    }
    fn line_to(&mut self, x: f32, y: f32) {
        self.path.line_to(self.x + self.scale * x, self.y - self.scale * y);
    }
    fn quad_to(&mut self, x1: f32, y1: f32, x: f32, y: f32) {
        let (s, x0, y0) = (self.scale, self.x, self.y);
        self.path.quad_to(x0 + s * x1, y0 - s * y1, x0 + s * x, y0 - s * y);
    }
    fn curve_to(&mut self, x1: f32, y1: f32, x2: f32, y2: f32, x: f32, y: f32) {
        let (s, x0, y0) = (self.scale, self.x, self.y);
        self.path.cubic_to(x0 + s * x1, y0 - s * y1, x0 + s * x2, y0 - s * y2, x0 + s * x, y0 - s * y);
    }
    fn close(&mut self) {
        self.path.close();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ink_lands_where_it_should() {
        let square = vec![[10.0, 10.0], [20.0, 10.0], [20.0, 20.0], [10.0, 20.0]];
        let text = Shape::Text { at: [50.0, 30.0], size: 20.0, anchor: Anchor::Middle, text: "φ".to_owned() };
        let drawing = Drawing { width: 60, height: 40, shapes: vec![Shape::Area { points: square, ink: BLUE }, text] };
        let image = Pixmap::decode_png(&drawing.png().unwrap()).unwrap();
        let pixel = |x, y| {
            let p = image.pixel(x, y).unwrap();
            [p.red(), p.green(), p.blue()]
        };
        assert_eq!(pixel(15, 15), BLUE.0);
        assert_eq!(pixel(30, 15), [255; 3]);
        // The stem of the φ stands in its middle.
        assert!((15..30).any(|y| pixel(50, y)[0] < 100));
    }
}
