//! A drawing as PNG, for importers; without letters, since an icon has no letters.

use camdrive::drives::Fault;
use camdrive_design::drawing::{Drawing, Ink, Shape};
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

/// The file of an image without transparency. Lines have few colours: a palette of up to 256 colours halves the file. Its rows are
/// often equal and compress best without a filter.
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
        // The palette contains every colour, in order.
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
    let mut fill = |path: Option<tiny_skia::Path>, ink: Ink| {
        if let Some(path) = path {
            image.fill_path(&path, &colour(ink), FillRule::Winding, scale, None);
        }
    };
    match shape {
        Shape::Line { points, width, ink, dash } => {
            let Some(path) = path(points, false) else { return };
            let dash = StrokeDash::new(dash.iter().map(|length| *length as f32).collect(), 0.0);
            let stroke = Stroke { width: *width as f32, line_join: LineJoin::Round, dash, ..Stroke::default() };
            image.stroke_path(&path, &colour(*ink), &stroke, scale, None);
        }
        Shape::Area { points, ink } => fill(path(points, true), *ink),
        Shape::Disc { at: [x, y], radius, ink } => {
            fill(PathBuilder::from_circle(*x as f32, *y as f32, *radius as f32), *ink);
        }
        Shape::Text { .. } => (),
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

#[cfg(test)]
mod tests {
    use super::*;
    use camdrive_design::drawing::{BLUE, Unit};

    #[test]
    fn ink_lands_where_it_should() {
        let square = vec![[10.0, 10.0], [20.0, 10.0], [20.0, 20.0], [10.0, 20.0]];
        let line = Shape::line(vec![[40.0, 5.0], [40.0, 35.0]], 4.0, BLUE);
        let shapes = vec![Shape::Area { points: square, ink: BLUE }, line];
        let drawing = Drawing { size: [60.0, 40.0], unit: Unit::Pixel, shapes };
        let image = Pixmap::decode_png(&png(&drawing, 1.0).unwrap()).unwrap();
        let pixel = |x, y| {
            let p = image.pixel(x, y).unwrap();
            [p.red(), p.green(), p.blue()]
        };
        assert_eq!(pixel(15, 15), BLUE.0);
        assert_eq!(pixel(30, 15), [255; 3]);
        assert_eq!([pixel(40, 20), pixel(40, 2)], [BLUE.0, [255; 3]]);
    }
}
