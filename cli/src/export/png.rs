//! A drawing as PNG, for importers. Its letters are outlines of its own: a machine without fonts draws the same picture.

use camdrive::drives::Fault;
use camdrive_design::drawing::{Anchor, BLACK, Drawing, Ink, Shape};
use std::collections::BTreeSet;
use tiny_skia::{Color, FillRule, LineJoin, Paint, PathBuilder, Pixmap, Stroke, StrokeDash, Transform};

/// The drawing as a PNG file, `scale` times as large.
pub fn png(drawing: &Drawing, scale: f64) -> Result<Vec<u8>, Fault> {
    let fault = |what: &str| Fault::new(format!("the picture cannot be drawn: {what}"));
    let [width, height] = drawing.size.map(|length| (scale * length).ceil() as u32);
    let mut image = Pixmap::new(width, height).ok_or_else(|| fault("it has no area"))?;
    image.fill(Color::WHITE);
    for shape in &drawing.shapes {
        paint(shape, &mut image, Transform::from_scale(scale as f32, scale as f32));
    }
    encode(&image).map_err(|e| fault(&e.to_string()))
}

/// The file of an image without transparency. Lines and letters have few colours: where a byte can count them, it does, which
/// halves the file. Its rows are often the same, and are packed best as they are.
fn encode(image: &Pixmap) -> Result<Vec<u8>, png::EncodingError> {
    let runs = image.pixels().chunk_by(|one, next| one == next);
    let runs: Vec<(usize, [u8; 3])> =
        runs.map(|run| (run.len(), [run[0].red(), run[0].green(), run[0].blue()])).collect();
    let palette: Vec<[u8; 3]> = BTreeSet::from_iter(runs.iter().map(|run| run.1)).into_iter().collect();
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, image.width(), image.height());
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(png::Compression::High);
    encoder.set_filter(png::Filter::NoFilter);
    let data: Vec<u8> = if palette.len() <= 256 {
        encoder.set_color(png::ColorType::Indexed);
        encoder.set_palette(palette.concat());
        // Every colour stands in the palette, which is in order.
        let number = |colour| palette.partition_point(|other| *other < colour) as u8;
        runs.iter().flat_map(|&(length, colour)| vec![number(colour); length]).collect()
    } else {
        encoder.set_color(png::ColorType::Rgb);
        runs.iter().flat_map(|&(length, colour)| colour.repeat(length)).collect()
    };
    encoder.write_header()?.write_image_data(&data)?;
    Ok(file)
}

fn paint(shape: &Shape, image: &mut Pixmap, scale: Transform) {
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
            let (glyphs, unit): (Vec<Glyph>, _) = (text.chars().map(Glyph::of).collect(), *size as f32 / UNITS_OF_SIZE);
            let length = unit * glyphs.iter().map(|glyph| glyph.advance).sum::<f32>();
            let before = match anchor {
                Anchor::Start => 0.0,
                Anchor::Middle => 0.5 * length,
                Anchor::End => length,
            };
            let [x, y] = at.map(|length| length as f32);
            let (mut pen, mut letters) = (x - before, PathBuilder::new());
            for glyph in glyphs {
                glyph.draw(&mut letters, [pen, y], unit);
                pen += unit * glyph.advance;
            }
            let angle = if *upright { -90.0 } else { 0.0 };
            fill(letters.finish(), BLACK, Transform::from_rotate_at(angle, x, y));
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

/// The letters of pictures, from DejaVu Sans: packaging/glyphs writes the file and tells its form.
const GLYPHS: &str = include_str!("glyphs.txt");
/// Its unit is this part of the size of letters.
const UNITS_OF_SIZE: f32 = 2048.0;

/// A letter: how far it moves the pen, and its outline as the path of an SVG, y upwards.
#[derive(Clone, Copy, Default)]
struct Glyph {
    advance: f32,
    outline: &'static str,
}

impl Glyph {
    /// That of a character, or the box of those that the file does not have.
    fn of(c: char) -> Self {
        let wanted = u32::from(c).to_string();
        let line = |name: &str| GLYPHS.lines().find_map(|line| line.split_once(' ').filter(|line| line.0 == name));
        let (_, glyph) = line(&wanted).or_else(|| line("-")).unwrap_or_default();
        let (advance, outline) = glyph.split_once(' ').unwrap_or((glyph, ""));
        Glyph { advance: advance.parse().unwrap_or(0.0), outline }
    }

    /// Adds the outline with its origin at a place, so many pixels to a unit.
    fn draw(self, path: &mut PathBuilder, [x0, y0]: [f32; 2], scale: f32) {
        let mut words = self.outline.split(' ');
        let mut point = [0.0; 2];
        while let Some(command) = words.next() {
            let mut next = || {
                point = [0, 1].map(|_| words.next().and_then(|word| word.parse().ok()).unwrap_or(0.0));
                (x0 + scale * point[0], y0 - scale * point[1])
            };
            match command {
                "M" => {
                    let (x, y) = next();
                    path.move_to(x, y);
                }
                "L" => {
                    let (x, y) = next();
                    path.line_to(x, y);
                }
                "Q" => {
                    let ((x1, y1), (x, y)) = (next(), next());
                    path.quad_to(x1, y1, x, y);
                }
                _ => path.close(),
            }
        }
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
