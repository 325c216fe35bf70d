//! A drawing as PNG, for importers. Its text is drawn with an embedded font: a machine without fonts draws the same picture.

use camdrive::drives::Fault;
use camdrive_design::drawing::{Anchor, BLACK, Drawing, Ink, Shape};
use skrifa::outline::{DrawSettings, OutlinePen};
use skrifa::prelude::{FontRef, LocationRef, Size};
use skrifa::{GlyphId, MetadataProvider};
use tiny_skia::{Color, FillRule, LineJoin, Paint, PathBuilder, Pixmap, Stroke, StrokeDash, Transform};

/// The drawing as a PNG file, `scale` times as large.
pub fn png(drawing: &Drawing, scale: f64) -> Result<Vec<u8>, Fault> {
    let fault = |what: &str| Fault::new(format!("the picture cannot be drawn: {what}"));
    let [width, height] = drawing.size.map(|length| (scale * length).ceil() as u32);
    let mut image = Pixmap::new(width, height).ok_or_else(|| fault("it has no area"))?;
    image.fill(Color::WHITE);
    let font = FontRef::new(dejavu::sans::regular()).map_err(|e| fault(&e.to_string()))?;
    for shape in &drawing.shapes {
        paint(shape, &mut image, &font, Transform::from_scale(scale as f32, scale as f32));
    }
    image.encode_png().map_err(|e| fault(&e.to_string()))
}

fn paint(shape: &Shape, image: &mut Pixmap, font: &FontRef, scale: Transform) {
    let mut fill = |path: Option<tiny_skia::Path>, ink: Ink, transform: Transform| {
        if let Some(path) = path {
            image.fill_path(&path, &colour(ink), FillRule::Winding, transform.post_concat(scale), None);
        }
    };
    match shape {
        Shape::Line { points, width, ink, dash } => {
            let Some(path) = path(points, false) else { return };
            let dash = StrokeDash::new(dash.iter().map(|length| *length as f32).collect(), 0.0);
            let stroke = Stroke { width: *width as f32, line_join: LineJoin::Round, dash, ..Stroke::default() };
            image.stroke_path(&path, &colour(*ink), &stroke, scale, None);
        }
        Shape::Area { points, ink } => fill(path(points, true), *ink, Transform::identity()),
        Shape::Disc { at: [x, y], radius, ink } => {
            fill(PathBuilder::from_circle(*x as f32, *y as f32, *radius as f32), *ink, Transform::identity());
        }
        Shape::Text { at, size, anchor, text, upright } => {
            let mut pen = Pen::new(font, *size);
            let before = match anchor {
                Anchor::Start => 0.0,
                Anchor::Middle => 0.5 * pen.length(text),
                Anchor::End => pen.length(text),
            };
            let [x, y] = at.map(|length| length as f32);
            (pen.x, pen.y) = (x - before as f32, y);
            pen.write(text);
            let angle = if *upright { -90.0 } else { 0.0 };
            fill(pen.path.finish(), BLACK, Transform::from_rotate_at(angle, x, y));
        }
    }
}

fn colour(ink: Ink) -> Paint<'static> {
    let [r, g, b] = ink.0;
    let mut paint = Paint::default();
    paint.set_color_rgba8(r, g, b, 255);
    paint
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
    font: &'a FontRef<'a>,
    /// Of the letters, in pixels.
    size: Size,
    /// The current place on the base line.
    x: f32,
    y: f32,
    path: PathBuilder,
}

impl<'a> Pen<'a> {
    fn new(font: &'a FontRef<'a>, size: f64) -> Self {
        Pen { font, size: Size::new(size as f32), x: 0.0, y: 0.0, path: PathBuilder::new() }
    }

    fn glyph(&self, c: char) -> GlyphId {
        self.font.charmap().map(c).unwrap_or_default()
    }

    fn advance(&self, c: char) -> f32 {
        let metrics = self.font.glyph_metrics(self.size, LocationRef::default());
        metrics.advance_width(self.glyph(c)).unwrap_or(0.0)
    }

    fn length(&self, text: &str) -> f64 {
        text.chars().map(|c| f64::from(self.advance(c))).sum()
    }

    fn write(&mut self, text: &str) {
        let outlines = self.font.outline_glyphs();
        let settings = |size| DrawSettings::unhinted(size, LocationRef::default());
        for c in text.chars() {
            // A glyph that the font does not have leaves a gap.
            if let Some(outline) = outlines.get(self.glyph(c)) {
                let _ = outline.draw(settings(self.size), self);
            }
            self.x += self.advance(c);
        }
    }
}

/// Outlines have y upwards.
impl OutlinePen for Pen<'_> {
    fn move_to(&mut self, x: f32, y: f32) {
        self.path.move_to(self.x + x, self.y - y);
    }
    fn line_to(&mut self, x: f32, y: f32) {
        self.path.line_to(self.x + x, self.y - y);
    }
    fn quad_to(&mut self, x1: f32, y1: f32, x: f32, y: f32) {
        let (x0, y0) = (self.x, self.y);
        self.path.quad_to(x0 + x1, y0 - y1, x0 + x, y0 - y);
    }
    fn curve_to(&mut self, x1: f32, y1: f32, x2: f32, y2: f32, x: f32, y: f32) {
        let (x0, y0) = (self.x, self.y);
        self.path.cubic_to(x0 + x1, y0 - y1, x0 + x2, y0 - y2, x0 + x, y0 - y);
    }
    fn close(&mut self) {
        self.path.close();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use camdrive_design::drawing::{BLUE, Unit};

    #[test]
    fn ink_lands_where_it_should() {
        let square = vec![[10.0, 10.0], [20.0, 10.0], [20.0, 20.0], [10.0, 20.0]];
        let text = Shape::text([50.0, 30.0], 20.0, Anchor::Middle, "φ");
        let drawing = Drawing {
            size: [60.0, 40.0],
            unit: Unit::Pixel,
            shapes: vec![Shape::Area { points: square, ink: BLUE }, text],
        };
        let image = Pixmap::decode_png(&png(&drawing, 1.0).unwrap()).unwrap();
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
