//! Straight lines behind the data, with their names where the data leave room.

use super::area::seen;
use super::look::{RULED, draw_line};
use super::{Area, LETTER, Rule, TEXT, fine, style};
use plotters::prelude::*;
use plotters::style::FontTransform;
use plotters::style::text_anchor::{HPos, Pos, VPos};

/// Height of the names in pixels.
const SMALL: f64 = TEXT - 2.0;
/// Between a name and its line; between a name and the ends of the axes; room that a marker takes around its point.
const GAP: i32 = 3;
const EDGE: i32 = 6;
const MARKER: i32 = 6;

/// The place of a name: left, top, right and bottom of what it covers.
type Cover = [i32; 4];

/// What names keep clear of: lines, and points alone.
pub type Obstacles = Vec<Vec<(i32, i32)>>;

/// The place of a rule: x of a vertical line, y of a horizontal one.
pub type Place = (Option<i32>, Option<i32>);

/// Draws the rules between the corners (left, bottom) and (right, top) of the diagram; returns the data with what it drew.
pub fn draw_rules(
    area: &Area<'_>,
    rules: &[(&Rule, Place)],
    corners: [(i32, i32); 2],
    data: Obstacles,
) -> Result<Obstacles, Box<dyn std::error::Error>> {
    let [(left, bottom), (right, top)] = corners;
    let line = |at: Place| match at {
        (Some(x), _) => Some(vec![(x, bottom), (x, top)]),
        (None, Some(y)) => Some(vec![(left, y), (right, y)]),
        (None, None) => None,
    };
    for line in rules.iter().filter_map(|(_, at)| line(*at)) {
        draw_line(area, &line, RULED)?;
    }
    let mut obstacles = data;
    for (i, (rule, at)) in rules.iter().enumerate() {
        let (name, is_vertical) = match rule {
            Rule::Vertical(_, name) => (name, true),
            Rule::Horizontal(_, name) => (name, false),
            _ => continue,
        };
        let Some(place) = (if is_vertical { at.0 } else { at.1 }) else { continue };
        let others = rules.iter().enumerate().filter(|(j, _)| *j != i).filter_map(|(_, (_, at))| line(*at));
        let in_the_way: Obstacles = obstacles.iter().cloned().chain(others).collect();
        let cover = clearest(&covers(name, place, is_vertical, corners), &in_the_way);
        let [west, north, east, south] = cover;
        let text = style(SMALL).pos(Pos::new(HPos::Left, VPos::Bottom));
        let (text, anchor) =
            if is_vertical { (text.transform(FontTransform::Rotate270), (east, south)) } else { (text, (west, south)) };
        area.draw(&Text::new(name.clone(), anchor, text))?;
        // The next name keeps clear of this one.
        obstacles.push(vec![(west, north), (east, south)]);
        obstacles.push(vec![(west, south), (east, north)]);
    }
    obstacles.extend(rules.iter().filter_map(|(_, at)| line(*at)));
    Ok(obstacles)
}

/// Where a name may be: on both sides of its line, all along it; the usual place first.
fn covers(name: &str, place: i32, is_vertical: bool, [(left, bottom), (right, top)]: [(i32, i32); 2]) -> Vec<Cover> {
    let (long, high) = (fine((LETTER * SMALL * name.chars().count() as f64) as i32), fine(SMALL as i32));
    let (gap, edge) = (fine(GAP), fine(EDGE));
    let sides = [place - gap - high, place + gap];
    // In quarters of the way from the usual place to the other end, that end before the places between.
    let quarters = [0, 4, 2, 1, 3];
    let (usual, other) =
        if is_vertical { (bottom - edge - long, top + edge) } else { (left + edge, right - edge - long) };
    let starts = quarters.map(|quarter| usual + (other - usual) * quarter / 4);
    let of = |start: i32, side: i32| {
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
        let room = fine(MARKER);
        let span = |low: i32, high: i32| [f64::from(low - room), f64::from(high + room)];
        let (x, y) = (span(west, east), span(north, south));
        let touches = |line: &&Vec<(i32, i32)>| {
            let points: Vec<(f64, f64)> = line.iter().map(|(x, y)| (f64::from(*x), f64::from(*y))).collect();
            match points[..] {
                [point] => !seen(&[point, point], x, y).is_empty(),
                _ => !seen(&points, x, y).is_empty(),
            }
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
        let corners = [(0, fine(300)), (fine(400), 0)];
        let inside = |[w, n, e, s]: Cover| 0 <= w && w < e && e <= fine(400) && 0 <= n && n < s && s <= fine(300);
        let free = covers("one turn", fine(200), true, corners);
        assert_eq!(free.len(), 10);
        assert!(free.iter().all(|cover| inside(*cover)));
        // The usual place is at the bottom, left of the line.
        assert_eq!(clearest(&free, &Vec::new()), free[0]);
        assert!(free[0][2] < fine(200) && free[0][3] > fine(290));
        // A curve along the bottom: the name moves to the top; one that falls along the left side: to the right side.
        let low = vec![vec![(0, fine(280)), (fine(400), fine(280))]];
        assert_eq!(clearest(&free, &low), free[2]);
        let beside = vec![vec![(fine(190), 0), (fine(190), fine(300))]];
        assert!(clearest(&free, &beside)[0] > fine(200));
        // Next to the left end there is no room on the left.
        assert!(covers("one turn", fine(5), true, corners).iter().all(|cover| cover[0] > fine(5)));
        assert!(covers("limit", fine(5), false, corners).iter().all(|cover| inside(*cover) && cover[1] > fine(5)));
        // A name longer than the diagram still has a place.
        assert!(!covers(&"long ".repeat(200), fine(50), false, corners).is_empty());
    }
}
