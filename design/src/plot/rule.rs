//! Straight lines behind the data, with their names where the data leave room.

use super::area::seen;
use super::look::RULED;
use super::{LETTER, Rule, TEXT};
use crate::drawing::{Anchor, Point, Shape};

/// Height of the names in pixels.
const SMALL: f64 = TEXT - 2.0;
/// Between a name and its line; between a name and the ends of the axes; room that a marker takes around its point.
const GAP: f64 = 3.0;
const EDGE: f64 = 6.0;
const MARKER: f64 = 6.0;

/// The place of a name: left, top, right and bottom of what it covers.
type Cover = [f64; 4];

/// Obstacles that names keep clear of: lines, and points alone.
pub type Obstacles = Vec<Vec<Point>>;

/// The place of a rule: x of a vertical line, y of a horizontal one.
pub type Place = [Option<f64>; 2];

/// Draws the rules between the left and right, bottom and top ends of the plot.
pub fn draw_rules(shapes: &mut Vec<Shape>, rules: &[(&Rule, Place)], ends: [[f64; 2]; 2], data: Obstacles) {
    let [[left, right], [bottom, top]] = ends;
    let line = |at: Place| match at {
        [Some(x), _] => Some(vec![[x, bottom], [x, top]]),
        [None, Some(y)] => Some(vec![[left, y], [right, y]]),
        [None, None] => None,
    };
    shapes.extend(rules.iter().filter_map(|(_, at)| line(*at)).map(|line| RULED.line(line)));
    let mut obstacles = data;
    for (i, (rule, at)) in rules.iter().enumerate() {
        let (name, is_vertical) = match rule {
            Rule::Vertical(_, name) => (name, true),
            Rule::Horizontal(_, name) => (name, false),
            _ => continue,
        };
        let Some(place) = at[usize::from(!is_vertical)] else { continue };
        let others = rules.iter().enumerate().filter(|(j, _)| *j != i).filter_map(|(_, (_, at))| line(*at));
        let in_the_way: Obstacles = obstacles.iter().cloned().chain(others).collect();
        let cover = clearest(&covers(name, place, is_vertical, ends), &in_the_way);
        let [west, north, east, south] = cover;
        // The base line is a little above the end of what a text covers.
        let base = 0.2 * SMALL;
        let at = if is_vertical { [east - base, south] } else { [west, south - base] };
        let (size, anchor, text) = (SMALL, Anchor::Start, name.clone());
        shapes.push(Shape::Text { at, size, anchor, text, upright: is_vertical });
        // The next name keeps clear of this one.
        obstacles.push(vec![[west, north], [east, south]]);
        obstacles.push(vec![[west, south], [east, north]]);
    }
}

/// Where a name may be: on both sides of its line, all along it; the usual place first.
fn covers(name: &str, place: f64, is_vertical: bool, [[left, right], [bottom, top]]: [[f64; 2]; 2]) -> Vec<Cover> {
    let (long, high) = (LETTER * SMALL * name.chars().count() as f64, SMALL);
    let sides = [place - GAP - high, place + GAP];
    // In quarters of the way from the usual place to the other end, that end before the places between.
    let quarters = [0.0, 4.0, 2.0, 1.0, 3.0];
    let (usual, other) =
        if is_vertical { (bottom - EDGE - long, top + EDGE) } else { (left + EDGE, right - EDGE - long) };
    let starts = quarters.map(|quarter| usual + (other - usual) * quarter / 4.0);
    let of = |start: f64, side: f64| {
        if is_vertical { [side, start, side + high, start + long] } else { [start, side, start + long, side + high] }
    };
    let all: Vec<Cover> = starts.iter().flat_map(|start| sides.map(|side| of(*start, side))).collect();
    let inside: Vec<Cover> =
        all.iter().copied().filter(|[w, n, e, s]| left <= *w && *e <= right && top <= *n && *s <= bottom).collect();
    if inside.is_empty() { all } else { inside }
}

/// The first of the places that the fewest obstacles reach.
fn clearest(covers: &[Cover], obstacles: &Obstacles) -> Cover {
    let reach = |[west, north, east, south]: Cover| {
        let around = [[west - MARKER, east + MARKER], [north - MARKER, south + MARKER]];
        let touches = |line: &&Vec<Point>| match line[..] {
            [point] => !seen(&[point, point], around).is_empty(),
            _ => !seen(line, around).is_empty(),
        };
        obstacles.iter().filter(touches).count()
    };
    covers.iter().copied().min_by_key(|cover| reach(*cover)).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_keep_clear_of_the_data() {
        let ends = [[0.0, 400.0], [300.0, 0.0]];
        let inside = |[w, n, e, s]: Cover| 0.0 <= w && w < e && e <= 400.0 && 0.0 <= n && n < s && s <= 300.0;
        let free = covers("one turn", 200.0, true, ends);
        assert_eq!(free.len(), 10);
        assert!(free.iter().all(|cover| inside(*cover)));
        // The usual place is at the bottom, left of the line.
        assert_eq!(clearest(&free, &Vec::new()), free[0]);
        assert!(free[0][2] < 200.0 && free[0][3] > 290.0);
        // A curve along the bottom: the name moves to the top; one that falls along the left side: to the right side.
        let low = vec![vec![[0.0, 280.0], [400.0, 280.0]]];
        assert_eq!(clearest(&free, &low), free[2]);
        let beside = vec![vec![[190.0, 0.0], [190.0, 300.0]]];
        assert!(clearest(&free, &beside)[0] > 200.0);
        // Next to the left end there is no room on the left.
        assert!(covers("one turn", 5.0, true, ends).iter().all(|cover| cover[0] > 5.0));
        assert!(covers("limit", 5.0, false, ends).iter().all(|cover| inside(*cover) && cover[1] > 5.0));
        // A name longer than the diagram still has a place.
        assert!(!covers(&"long ".repeat(200), 50.0, false, ends).is_empty());
    }
}
