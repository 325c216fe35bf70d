//! Lines of borders and limits across a diagram. Names of upright lines stand above the plot, at their lines, as many as have room;
//! names of level lines on the line, where the data leave room, and at the end of the axis where their line is beyond it.

use super::area::seen;
use super::look::RULED;
use super::{LETTER, Rule, TEXT};
use crate::drawing::{Anchor, Frame, Point, Shape};
use crate::text::number;

/// Height of the names in pixels.
const SMALL: f64 = TEXT - 1.5;
/// Between a name and its line; between two names, or a name and the ends of the axes; room that a marker takes around its point.
const GAP: f64 = 3.0;
const EDGE: f64 = 6.0;
const MARKER: f64 = 6.0;

/// The place of a name: left, top, right and bottom of what it covers.
type Cover = [f64; 4];

/// Obstacles that names keep clear of: lines, and points alone.
pub type Obstacles = Vec<Vec<Point>>;

/// The place of a rule along the axes: x of an upright line, y of a level one.
pub type Place = [Option<f64>; 2];

/// Draws the rules at these places into the frame; values beyond it have the unit of the axis.
pub fn draw_rules(shapes: &mut Vec<Shape>, rules: &[(&Rule, Place)], (frame, unit): (&Frame, &str), data: Obstacles) {
    let [[left, right], [bottom, top]] = frame.ends;
    let [[first, last], [low, high]] = frame.ranges;
    let mut obstacles = data;
    let (mut level, mut above) = (Vec::new(), Vec::new());
    for (rule, place) in rules {
        let line = match (rule, place) {
            (Rule::Vertical(_, name), [Some(x), _]) if (first..=last).contains(x) => {
                let [x, _] = frame.at([*x, low]);
                above.extend(place_above(name, x, [left, right], &above).map(|from| (name, from)));
                vec![[x, bottom], [x, top]]
            }
            (Rule::Horizontal(value, name), [_, Some(y)]) => {
                let [_, at] = frame.at([first, y.clamp(low, high)]);
                let arrow = if *y > high { "↑ " } else { "↓ " };
                let is_seen = (low..=high).contains(y);
                if !name.is_empty() {
                    let beyond = || format!("{arrow}{name}: {}{unit}", number(*value));
                    level.push((if is_seen { name.clone() } else { beyond() }, at));
                }
                if is_seen { vec![[left, at], [right, at]] } else { continue }
            }
            _ => continue,
        };
        shapes.push(RULED.line(line.clone()));
        obstacles.push(line);
    }
    let text = |at, name: &str| Shape::text(at, SMALL, Anchor::Start, name);
    shapes.extend(above.into_iter().map(|(name, [from, _])| text([from, top - GAP - 1.0], name)));
    for (name, y) in level {
        // Its own line, along which it stands, is in nobody's way.
        let others: Obstacles = obstacles.iter().filter(|line| **line != [[left, y], [right, y]]).cloned().collect();
        let [west, north, east, south] = clearest(&covers(&name, y, frame.ends), &others);
        // The base line is a little above the end of what a text covers.
        shapes.push(text([west, south - 0.2 * SMALL], &name));
        obstacles.push(vec![[west, north], [east, south]]);
        obstacles.push(vec![[west, south], [east, north]]);
    }
}

/// Where a name stands above the plot, from left to right: about its line, else beside it, clear of the names that are there.
fn place_above(name: &str, x: f64, [left, right]: [f64; 2], others: &[(&String, [f64; 2])]) -> Option<[f64; 2]> {
    let long = LETTER * SMALL * name.chars().count() as f64;
    let places =
        [x - 0.5 * long, x, x - long].map(|from| from.min(right - long).max(left)).map(|from| [from, from + long]);
    let is_free =
        |[from, to]: &[f64; 2]| others.iter().all(|(_, other)| *to + EDGE <= other[0] || other[1] + EDGE <= *from);
    places.into_iter().find(is_free).filter(|_| !name.is_empty())
}

/// The possible places of a name: above and below its line, all along it; the usual place first.
fn covers(name: &str, y: f64, [[left, right], [bottom, top]]: [[f64; 2]; 2]) -> Vec<Cover> {
    let long = LETTER * SMALL * name.chars().count() as f64;
    let (usual, other) = (left + EDGE, right - EDGE - long);
    // In quarters of the way from the usual place to the other end, that end before the places between.
    let starts = [0.0, 4.0, 2.0, 1.0, 3.0].map(|quarter| usual + (other - usual) * quarter / 4.0);
    let sides = [y - GAP - SMALL, y + GAP];
    let all = starts.iter().flat_map(|from| sides.map(|side| [*from, side, from + long, side + SMALL]));
    let (inside, outside): (Vec<Cover>, Vec<Cover>) =
        all.partition(|[w, n, e, s]| left <= *w && *e <= right && top <= *n && *s <= bottom);
    if inside.is_empty() { outside } else { inside }
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
        let free = covers("limit", 200.0, ends);
        assert!(free.len() == 10 && free.iter().all(|cover| inside(*cover)));
        // The usual place is at the left end, above the line.
        assert_eq!(clearest(&free, &Vec::new()), free[0]);
        assert!(free[0][3] < 200.0 && free[0][0] < 10.0);
        // A curve upwards there: the name moves to the right; one along the line above it: below it.
        assert_eq!(clearest(&free, &vec![vec![[20.0, 0.0], [20.0, 300.0]]]), free[2]);
        assert!(clearest(&free, &vec![vec![[0.0, 190.0], [400.0, 190.0]]])[1] > 200.0);
        // Next to the upper end there is no room above.
        assert!(covers("limit", 5.0, ends).iter().all(|cover| inside(*cover) && cover[1] > 5.0));
        // A name longer than the diagram still has a place.
        assert!(!covers(&"long ".repeat(200), 50.0, ends).is_empty());
    }

    #[test]
    fn names_above_the_plot_stand_at_their_lines_as_many_as_have_room() {
        let rules: Vec<Rule> = [200.0, 225.0, 210.0, 390.0].map(|x| Rule::Vertical(x, format!("k = {x}"))).into();
        let placed: Vec<(&Rule, Place)> =
            rules.iter().zip([200.0, 225.0, 210.0, 390.0].map(|x| [Some(x), None])).collect();
        let frame = Frame { ends: [[0.0, 400.0], [300.0, 20.0]], ranges: [[0.0, 400.0], [0.0, 1.0]] };
        let mut shapes = Vec::new();
        draw_rules(&mut shapes, &placed, (&frame, "°"), Vec::new());
        let names: Vec<(f64, &str)> = shapes
            .iter()
            .filter_map(|shape| match shape {
                Shape::Text { at: [x, y], text, .. } if *y < 20.0 => Some((*x, text.as_str())),
                _ => None,
            })
            .collect();
        assert_eq!(shapes.len() - names.len(), 4);
        let long = LETTER * SMALL * 7.0;
        assert_eq!(names[0], (200.0 - 0.5 * long, "k = 200"));
        // The next one begins at its line, the third has no room, the last one ends where the plot ends.
        assert_eq!(names[1..], [(225.0, "k = 225"), (400.0 - long, "k = 390")]);
        // Beyond the axis a name has the value; without a name there is nothing to tell.
        let rules = ["limit", ""].map(|name| Rule::Horizontal(7.0, name.to_owned()));
        let placed: Vec<(&Rule, Place)> = rules.iter().map(|rule| (rule, [None, Some(7.0)])).collect();
        let mut shapes = Vec::new();
        draw_rules(&mut shapes, &placed, (&frame, "°"), Vec::new());
        assert!(matches!(&shapes[..], [Shape::Text { text, .. }] if text == "↑ limit: 7°"), "{shapes:?}");
    }
}
