//! Where a legend lies within the axes: in a corner, at a side or anywhere else that the data leave free.

use super::area::{seen, within};
use super::fine;
use super::rule::Obstacles;

/// Between the legend and the axes, and around it, where markers reach, in pixels.
const EDGE: i32 = 6;
const MARKER: i32 = 8;
/// Places tried along each axis: so many parts of the way from one end to the other.
const PARTS: i32 = 16;

/// The left upper corner of the best free place of this width and height between the corners (left, bottom) and (right, top):
/// a corner of the axes before a side, a side before what is between, and of these the uppermost and rightmost. None where
/// lines, points or areas are everywhere.
pub fn free_place(
    size: (i32, i32),
    [(left, bottom), (right, top)]: [(i32, i32); 2],
    lines: &Obstacles,
    areas: &[Vec<(i32, i32)>],
) -> Option<(i32, i32)> {
    let float = |lines: &[Vec<(i32, i32)>]| -> Vec<Vec<(f64, f64)>> {
        let of = |line: &Vec<(i32, i32)>| line.iter().map(|(x, y)| (f64::from(*x), f64::from(*y))).collect();
        lines.iter().map(of).collect()
    };
    let (lines, areas) = (float(lines), float(areas));
    let first = (left + fine(EDGE), top + fine(EDGE));
    let room = (right - fine(EDGE) - size.0 - first.0, bottom - fine(EDGE) - size.1 - first.1);
    if room.0 < 0 || room.1 < 0 {
        return None;
    }
    let is_free = |(x, y): (i32, i32)| {
        let span = |low: i32, size: i32| [f64::from(low - fine(MARKER)), f64::from(low + size + fine(MARKER))];
        let (x, y) = (span(x, size.0), span(y, size.1));
        let is_clear = |line: &Vec<(f64, f64)>| match line[..] {
            [point] => seen(&[point, point], x, y).is_empty(),
            _ => seen(line, x, y).is_empty(),
        };
        lines.iter().all(is_clear) && areas.iter().all(|outline| within(outline, x, y).is_empty())
    };
    let inner = |i: i32| i32::from(0 < i && i < PARTS);
    let mut places: Vec<(i32, i32)> = (0..=PARTS).flat_map(|j| (0..=PARTS).rev().map(move |i| (i, j))).collect();
    places.sort_by_key(|(i, j)| inner(*i) + inner(*j));
    let at = |(i, j): (i32, i32)| (first.0 + room.0 * i / PARTS, first.1 + room.1 * j / PARTS);
    places.into_iter().map(at).find(|place| is_free(*place))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_legend_takes_the_best_place_that_is_free() {
        let corners = [(0, fine(300)), (fine(400), 0)];
        let size = (fine(100), fine(60));
        let (right, left) = (fine(400 - EDGE - 100), fine(EDGE));
        let (upper, lower) = (fine(EDGE), fine(300 - EDGE - 60));
        let place = |lines: &[[(i32, i32); 2]], areas: &[Vec<(i32, i32)>]| {
            let fine_of = |points: &[(i32, i32)]| points.iter().map(|(x, y)| (fine(*x), fine(*y))).collect::<Vec<_>>();
            let lines: Obstacles = lines.iter().map(|line| fine_of(line)).collect();
            let areas: Vec<Vec<(i32, i32)>> = areas.iter().map(|outline| fine_of(outline)).collect();
            free_place(size, corners, &lines, &areas)
        };
        assert_eq!(place(&[], &[]), Some((right, upper)));
        let rising = [(0, 300), (400, 0)];
        assert_eq!(place(&[rising], &[]), Some((left, upper)));
        let falling = [(0, 0), (400, 300)];
        let cross = place(&[rising, falling], &[]).unwrap();
        assert!(cross.1 == upper && left < cross.0 && cross.0 < right, "{cross:?}");
        let frame = |e: i32| vec![(e, e), (400 - e, e), (400 - e, 300 - e), (e, 300 - e)];
        // An area that a legend would lie within is in its way, too.
        assert_eq!(place(&[], &[frame(0)]), None);
        assert_eq!(place(&[], &[vec![(200, 0), (400, 0), (400, 300), (200, 300)]]), Some((left, upper)));
        // A point alone, and lines so near to the axes that only the middle is left.
        assert_eq!(place(&[[(350, 30), (350, 30)]], &[]), Some((left, upper)));
        let sides = [[(0, 10), (400, 10)], [(0, 290), (400, 290)], [(10, 0), (10, 300)], [(390, 0), (390, 300)]];
        let inside = place(&sides, &[]).unwrap();
        assert!(left < inside.0 && inside.0 < right && upper < inside.1 && inside.1 < lower, "{inside:?}");
        assert_eq!(free_place((fine(500), fine(60)), corners, &Vec::new(), &[]), None);
    }
}
