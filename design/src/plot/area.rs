//! Areas and lines cut off at the ends of the axes.
//!
//! Source: I. E. Sutherland, G. W. Hodgman, "Reentrant polygon clipping", Commun. ACM 17 (1974) 32–42.

use crate::drawing::Point;

/// The part of the polygon `outline` with x and y between these ends; empty where there is none.
pub fn within(outline: &[Point], [x, y]: [[f64; 2]; 2]) -> Vec<Point> {
    // The four half-planes, each by a distance that is positive inside.
    let sides: [&dyn Fn(&Point) -> f64; 4] = [&|p| p[0] - x[0], &|p| x[1] - p[0], &|p| p[1] - y[0], &|p| y[1] - p[1]];
    sides.iter().fold(outline.to_vec(), |polygon, distance| cut(&polygon, distance))
}

/// The part of a polygon where the distance is not negative.
fn cut(polygon: &[Point], distance: &dyn Fn(&Point) -> f64) -> Vec<Point> {
    let mut part = Vec::with_capacity(polygon.len() + 4);
    for (i, to) in polygon.iter().enumerate() {
        let from = &polygon[(i + polygon.len() - 1) % polygon.len()];
        let (before, after) = (distance(from), distance(to));
        if (before < 0.0) != (after < 0.0) {
            let share = before / (before - after);
            part.push([from[0] + share * (to[0] - from[0]), from[1] + share * (to[1] - from[1])]);
        }
        if after >= 0.0 {
            part.push(*to);
        }
    }
    part
}

/// The parts of the line along `points` with x and y between these ends.
pub fn seen(points: &[Point], [x, y]: [[f64; 2]; 2]) -> Vec<Vec<Point>> {
    let mut parts: Vec<Vec<Point>> = Vec::new();
    let mut joined = false;
    for pair in points.windows(2) {
        let ([x0, y0], [x1, y1]) = (pair[0], pair[1]);
        let (dx, dy) = (x1 - x0, y1 - y0);
        // Liang and Barsky: the part of the segment between the shares `from` and `to` is inside.
        let (mut from, mut to) = (0.0_f64, 1.0_f64);
        for (way, room) in [(-dx, x0 - x[0]), (dx, x[1] - x0), (-dy, y0 - y[0]), (dy, y[1] - y0)] {
            if way < 0.0 {
                from = from.max(room / way);
            } else if way > 0.0 {
                to = to.min(room / way);
            } else if room < 0.0 {
                to = -1.0;
            }
        }
        if from > to {
            joined = false;
            continue;
        }
        let at = |share: f64| [x0 + share * dx, y0 + share * dy];
        match parts.last_mut().filter(|_| joined && from == 0.0) {
            Some(part) => part.push(at(to)),
            None => parts.push(vec![at(from), at(to)]),
        }
        joined = to == 1.0;
    }
    parts
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Twice the area, by the shoelace formula.
    fn size(polygon: &[Point]) -> f64 {
        let pairs = polygon.iter().zip(polygon.iter().cycle().skip(1));
        pairs.map(|(a, b)| a[0] * b[1] - b[0] * a[1]).sum::<f64>().abs()
    }

    #[test]
    fn a_polygon_is_cut_at_the_ends_of_the_axes() {
        let unit = [[0.0, 1.0]; 2];
        let diamond = [[0.5, -0.5], [1.5, 0.5], [0.5, 1.5], [-0.5, 0.5]];
        assert_eq!(size(&within(&diamond, unit)), 2.0);
        let half = [[0.5, -1.0], [3.0, -1.0], [3.0, 2.0], [0.5, 2.0]];
        assert_eq!(size(&within(&half, unit)), 1.0);
        let inside = [[0.1, 0.1], [0.9, 0.1], [0.5, 0.9]];
        assert_eq!(within(&inside, unit), inside);
        assert!(within(&[[2.0, 2.0], [3.0, 2.0], [3.0, 3.0]], unit).is_empty());
        assert!(within(&[], unit).is_empty());
    }

    #[test]
    fn a_line_is_cut_into_the_parts_that_are_seen() {
        let unit = [[0.0, 1.0]; 2];
        let line = [[0.5, 0.5], [0.5, 1.5], [0.75, 1.5], [0.75, 0.5], [2.0, 0.5], [2.0, 9.0]];
        let expected = vec![vec![[0.5, 0.5], [0.5, 1.0]], vec![[0.75, 1.0], [0.75, 0.5], [1.0, 0.5]]];
        assert_eq!(seen(&line, unit), expected);
        assert_eq!(seen(&[[0.1, 0.2], [0.3, 0.4], [0.5, 0.9]], unit), [[[0.1, 0.2], [0.3, 0.4], [0.5, 0.9]]]);
        assert!(seen(&[[-1.0, 2.0], [2.0, 2.0]], unit).is_empty() && seen(&[], unit).is_empty());
    }
}
