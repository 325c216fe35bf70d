//! How the lines and points of a series look.

use super::{Area, fine, thick};
use plotters::element::DashedPathElement;
use plotters::prelude::*;

/// Dark colours of clearly different lightness, so that a grey print keeps them apart.
const COLOURS: [RGBColor; 6] = [
    RGBColor(0x1f, 0x4e, 0x79),
    RGBColor(0xc0, 0x5a, 0x10),
    RGBColor(0x2a, 0x7d, 0x4f),
    RGBColor(0x7a, 0x2f, 0x6b),
    RGBColor(0x00, 0x00, 0x00),
    RGBColor(0x8a, 0x7a, 0x10),
];
/// Dash and gap in pixels; no gap is a solid line.
const DASHES: [(i32, i32); 5] = [(1, 0), (8, 4), (2, 3), (12, 3), (5, 6)];

/// The shapes that mark points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Marker {
    Disc,
    OpenSquare,
    Triangle,
    OpenCircle,
    Diamond,
    Cross,
    OpenTriangle,
    Square,
    OpenDiamond,
    Plus,
}

/// A line of more points is a curve: of its points only some, evenly spread, carry the marker by which it is known.
const MOST_MARKERS: usize = 24;
const MARKERS_OF_A_CURVE: usize = 8;

/// In the order of the series.
pub const MARKERS: [Marker; 10] = [
    Marker::Disc,
    Marker::OpenSquare,
    Marker::Triangle,
    Marker::OpenCircle,
    Marker::Diamond,
    Marker::Cross,
    Marker::OpenTriangle,
    Marker::Square,
    Marker::OpenDiamond,
    Marker::Plus,
];

/// The look of series i.
#[derive(Clone, Copy)]
pub struct Look {
    colour: RGBColor,
    dash: (i32, i32),
    marker: Marker,
}

/// Of lines behind the data.
pub const RULED: Look = Look { colour: RGBColor(0x66, 0x66, 0x66), dash: (3, 4), marker: Marker::Disc };

pub fn look(i: usize) -> Look {
    Look { colour: COLOURS[i % COLOURS.len()], dash: DASHES[i % DASHES.len()], marker: MARKERS[i % MARKERS.len()] }
}

/// The points of series `i` that carry its marker: all, or some of a curve, which begin elsewhere in each series.
pub fn marked(points: &[(i32, i32)], joined: bool, i: usize) -> Vec<(i32, i32)> {
    if !joined || points.len() <= MOST_MARKERS {
        return points.to_vec();
    }
    let stride = points.len().div_ceil(MARKERS_OF_A_CURVE);
    points.iter().skip((2 * i + 1) * stride / 5 % stride).step_by(stride).copied().collect()
}

/// A polyline, dashed by its look; the dashes run on around corners.
pub fn draw_line(area: &Area<'_>, points: &[(i32, i32)], look: Look) -> Result<(), Box<dyn std::error::Error>> {
    let style = thick(look.colour, 2);
    let (dash, gap) = (fine(look.dash.0), fine(look.dash.1));
    if gap == 0 {
        area.draw(&PathElement::new(points.to_vec(), style))?;
    } else {
        area.draw(&DashedPathElement::new(points.to_vec(), dash, gap, style))?;
    }
    Ok(())
}

/// The marker of a look.
pub fn draw_marker(area: &Area<'_>, (x, y): (i32, i32), look: Look) -> Result<(), Box<dyn std::error::Error>> {
    let (full, line) = (ShapeStyle::from(look.colour).filled(), thick(look.colour, 2));
    let white = ShapeStyle::from(WHITE).filled();
    let polygon = |corners: &[(i32, i32)]| -> Vec<(i32, i32)> {
        corners.iter().map(|(i, j)| (x + fine(*i), y + fine(*j))).collect()
    };
    let square = [(-4, -4), (4, -4), (4, 4), (-4, 4)];
    let triangle = [(0, -6), (5, 4), (-5, 4)];
    let diamond = [(0, -6), (5, 0), (0, 6), (-5, 0)];
    let closed = |corners: &[(i32, i32)]| {
        let mut outline = polygon(corners);
        outline.push(outline[0]);
        outline
    };
    let open = |corners: &[(i32, i32)]| -> Result<(), Box<dyn std::error::Error>> {
        area.draw(&Polygon::new(polygon(corners), white))?;
        area.draw(&PathElement::new(closed(corners), line))?;
        Ok(())
    };
    match look.marker {
        Marker::Disc => area.draw(&Circle::new((x, y), fine(4), full))?,
        Marker::OpenCircle => {
            area.draw(&Circle::new((x, y), fine(5), white))?;
            area.draw(&Circle::new((x, y), fine(5), line))?;
        }
        Marker::Square => area.draw(&Polygon::new(polygon(&square), full))?,
        Marker::Triangle => area.draw(&Polygon::new(polygon(&triangle), full))?,
        Marker::Diamond => area.draw(&Polygon::new(polygon(&diamond), full))?,
        Marker::OpenSquare => open(&square)?,
        Marker::OpenTriangle => open(&triangle)?,
        Marker::OpenDiamond => open(&diamond)?,
        Marker::Cross => area.draw(&Cross::new((x, y), fine(4), line))?,
        Marker::Plus => {
            area.draw(&PathElement::new(vec![(x - fine(5), y), (x + fine(5), y)], line))?;
            area.draw(&PathElement::new(vec![(x, y - fine(5)), (x, y + fine(5))], line))?;
        }
    }
    Ok(())
}
