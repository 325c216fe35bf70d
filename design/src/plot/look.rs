//! The look of the lines and points of a series.

use crate::drawing::{BLUE, Ink, Point, Shape, WHITE};

/// Dark colours of clearly different lightness, so that a grey print keeps them apart.
const COLOURS: [Ink; 6] = [
    BLUE,
    Ink([0xc0, 0x5a, 0x10]),
    Ink([0x2a, 0x7d, 0x4f]),
    Ink([0x7a, 0x2f, 0x6b]),
    Ink([0x00; 3]),
    Ink([0x8a, 0x7a, 0x10]),
];
/// Dashes and gaps in pixels.
const DASHES: [&[f64]; 5] = [&[], &[8.0, 4.0], &[2.0, 3.0], &[12.0, 3.0, 3.0, 3.0], &[5.0, 6.0]];

/// A line of more points is a curve: of its points only some, evenly spread, carry the marker by which it is known.
const MOST_MARKERS: usize = 24;
const MARKERS_OF_A_CURVE: usize = 8;

/// The shapes that mark points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    Disc,
    Square,
    Triangle,
    Diamond,
    Cross,
    Plus,
}

/// In the order of the series: the shape, and whether it is open.
pub const MARKERS: [(Form, bool); 10] = [
    (Form::Disc, false),
    (Form::Square, true),
    (Form::Triangle, false),
    (Form::Disc, true),
    (Form::Diamond, false),
    (Form::Cross, true),
    (Form::Triangle, true),
    (Form::Square, false),
    (Form::Diamond, true),
    (Form::Plus, true),
];

/// The look of a series.
#[derive(Clone, Copy)]
pub struct Look {
    ink: Ink,
    dash: &'static [f64],
    marker: (Form, bool),
}

/// Lines behind the data.
pub const RULED: Look = Look { ink: Ink([0x66; 3]), dash: &[3.0, 4.0], marker: MARKERS[0] };

/// Dashed lines behind the data: a colour that black borders and grey areas set off.
pub const DASHED: Look = Look { ink: COLOURS[1], dash: &[6.0, 4.0], marker: MARKERS[0] };

/// The look of series i.
pub fn look(i: usize) -> Look {
    Look { ink: COLOURS[i % COLOURS.len()], dash: DASHES[i % DASHES.len()], marker: MARKERS[i % MARKERS.len()] }
}

/// The points of series `i` that carry its marker: all, or some of a curve, which begin elsewhere in each series; none of a curve
/// that is alone.
pub fn marked(points: &[Point], joined: bool, i: usize, alone: bool) -> Vec<Point> {
    if joined && alone && points.len() > MOST_MARKERS {
        return Vec::new();
    }
    if !joined || points.len() <= MOST_MARKERS {
        return points.to_vec();
    }
    let stride = points.len().div_ceil(MARKERS_OF_A_CURVE);
    points.iter().skip((2 * i + 1) * stride / 5 % stride).step_by(stride).copied().collect()
}

impl Look {
    /// A line of this look.
    pub fn line(&self, points: Vec<Point>) -> Shape {
        Shape::Line { points, width: 2.0, ink: self.ink, dash: self.dash }
    }

    /// The marker of this look.
    pub fn marker(&self, at: Point) -> Vec<Shape> {
        let (ink, (form, open)) = (self.ink, self.marker);
        let moved = |offsets: &[Point]| offsets.iter().map(|by| [at[0] + by[0], at[1] + by[1]]).collect::<Vec<Point>>();
        let stroke = |offsets: &[Point]| Shape::line(moved(offsets), 2.0, ink);
        let outline: &[Point] = match form {
            Form::Disc if open => {
                return [(6.0, ink), (4.0, WHITE)].map(|(radius, ink)| Shape::Disc { at, radius, ink }).into();
            }
            Form::Disc => return vec![Shape::Disc { at, radius: 4.0, ink }],
            Form::Cross => return vec![stroke(&[[-4.0, -4.0], [4.0, 4.0]]), stroke(&[[-4.0, 4.0], [4.0, -4.0]])],
            Form::Plus => return vec![stroke(&[[-5.0, 0.0], [5.0, 0.0]]), stroke(&[[0.0, -5.0], [0.0, 5.0]])],
            Form::Square => &[[-4.0, -4.0], [4.0, -4.0], [4.0, 4.0], [-4.0, 4.0], [-4.0, -4.0]],
            Form::Triangle => &[[0.0, -6.0], [5.0, 4.0], [-5.0, 4.0], [0.0, -6.0]],
            Form::Diamond => &[[0.0, -6.0], [5.0, 0.0], [0.0, 6.0], [-5.0, 0.0], [0.0, -6.0]],
        };
        let area = Shape::Area { points: moved(outline), ink: if open { WHITE } else { ink } };
        if open { vec![area, stroke(outline)] } else { vec![area] }
    }
}
