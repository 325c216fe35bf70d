//! The place of a legend within the axes: in a corner, at a side or anywhere else that the data leave free.

use super::LETTER;
use super::area::{seen, within};
use crate::drawing::{Anchor, Point, Shape};

/// Between the legend and the axes, and around it, where markers reach.
const EDGE: f64 = 6.0;
const MARKER: f64 = 8.0;
/// Places tried along each axis: so many parts of the way from one end to the other.
const PARTS: usize = 16;

/// The left upper corner of the best free place of this width and height between these left and right, bottom and top ends:
/// a corner of the axes before a side, a side before what is between, and of these the uppermost and rightmost. None where
/// the shapes are everywhere.
pub fn free_place(size: Point, [[left, right], [bottom, top]]: [[f64; 2]; 2], shapes: &[Shape]) -> Option<Point> {
    let first = [left + EDGE, top + EDGE];
    let room = [right - EDGE - size[0] - first[0], bottom - EDGE - size[1] - first[1]];
    if room.iter().any(|room| *room < 0.0) {
        return None;
    }
    let inner = |i: usize| usize::from(0 < i && i < PARTS);
    let mut places: Vec<[usize; 2]> = (0..=PARTS).flat_map(|j| (0..=PARTS).rev().map(move |i| [i, j])).collect();
    places.sort_by_key(|[i, j]| inner(*i) + inner(*j));
    let at = |place: [usize; 2]| std::array::from_fn(|n| first[n] + room[n] * place[n] as f64 / PARTS as f64);
    let is_free = |corner: &Point| {
        let around = std::array::from_fn(|n| [corner[n] - MARKER, corner[n] + size[n] + MARKER]);
        !shapes.iter().any(|shape| reaches(shape, around))
    };
    places.into_iter().map(at).find(is_free)
}

/// True if a shape reaches into the rectangle with these ends.
fn reaches(shape: &Shape, rectangle: [[f64; 2]; 2]) -> bool {
    match shape {
        Shape::Line { points, .. } => !seen(points, rectangle).is_empty(),
        Shape::Area { points, .. } => !within(points, rectangle).is_empty(),
        Shape::Disc { at, .. } => !seen(&[*at, *at], rectangle).is_empty(),
        Shape::Text { at: [x, y], size, anchor, text, upright } => {
            let length = LETTER * size * text.chars().count() as f64;
            let start = match anchor {
                Anchor::Start => 0.0,
                Anchor::Middle => -0.5 * length,
                Anchor::End => -length,
            };
            let corner =
                |along: f64, above: f64| if *upright { [x - above, y - along] } else { [x + along, y - above] };
            let end = start + length;
            let covered = [corner(start, 0.0), corner(end, 0.0), corner(end, *size), corner(start, *size)];
            !within(&covered, rectangle).is_empty()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::drawing::BLACK;

    #[test]
    fn a_legend_takes_the_best_place_that_is_free() {
        let ends = [[0.0, 400.0], [300.0, 0.0]];
        let [right, left, upper, lower] = [400.0 - EDGE - 100.0, EDGE, EDGE, 300.0 - EDGE - 60.0];
        let place = |shapes: &[Shape]| free_place([100.0, 60.0], ends, shapes);
        let line = |from: Point, to: Point| Shape::line(vec![from, to], 1.0, BLACK);
        let area = |points: Vec<Point>| Shape::Area { points, ink: BLACK };
        assert_eq!(place(&[]), Some([right, upper]));
        let rising = line([0.0, 300.0], [400.0, 0.0]);
        assert_eq!(place(std::slice::from_ref(&rising)), Some([left, upper]));
        let cross = place(&[rising, line([0.0, 0.0], [400.0, 300.0])]).unwrap();
        assert!(cross[1] == upper && left < cross[0] && cross[0] < right, "{cross:?}");
        // An area that a legend would lie within is in its way, too.
        assert_eq!(place(&[area(vec![[0.0, 0.0], [400.0, 0.0], [400.0, 300.0], [0.0, 300.0]])]), None);
        let half = area(vec![[200.0, 0.0], [400.0, 0.0], [400.0, 300.0], [200.0, 300.0]]);
        assert_eq!(place(&[half]), Some([left, upper]));
        // A marker alone, a name, and lines so near to the axes that only the middle is left.
        assert_eq!(place(&[Shape::Disc { at: [350.0, 30.0], radius: 2.0, ink: BLACK }]), Some([left, upper]));
        assert_eq!(place(&[Shape::text([390.0, 40.0], 10.0, Anchor::End, "name")]), Some([left, upper]));
        let sides = [
            line([0.0, 10.0], [400.0, 10.0]),
            line([0.0, 290.0], [400.0, 290.0]),
            line([10.0, 0.0], [10.0, 300.0]),
            line([390.0, 0.0], [390.0, 300.0]),
        ];
        let [x, y] = place(&sides).unwrap();
        assert!(left < x && x < right && upper < y && y < lower, "{x} {y}");
        assert_eq!(free_place([500.0, 60.0], ends, &[]), None);
    }
}
