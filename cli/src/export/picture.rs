//! The picture of a drive: its curves in panels one above the other, under the title.

use camdrive::drives::Curve;
use camdrive_design::drawing::{Anchor, BLACK, BLUE, Drawing, Frame, Ink, Shape};
use camdrive_design::plot::ticks::{angular_step, decimal, decimal_step};

const WIDTH: f64 = 720.0;
const TITLE: f64 = 48.0;
const PANEL: f64 = 170.0;
/// Above and below the area of a panel: room for its name and for the numbers of the axis.
const ABOVE: f64 = 26.0;
const BELOW: f64 = 26.0;
const LEFT: f64 = 84.0;
const RIGHT: f64 = 28.0;
const TEXT: f64 = 13.0;
/// Grid lines; light enough for print.
const GREY: Ink = Ink([0xcc; 3]);
/// The ground of the icon.
const PALE: Ink = Ink([0xdd, 0xe6, 0xef]);
/// So many parts of the turn have room below a panel.
const PARTS: f64 = 8.0;

/// The curves under the title, with the model's name below it in small.
pub fn of_curves(title: &str, subtitle: &str, curves: &[Curve]) -> Drawing {
    let mut shapes = vec![
        Shape::text([LEFT, 28.0], 19.0, Anchor::Start, title),
        Shape::text([WIDTH - RIGHT, 28.0], TEXT, Anchor::End, subtitle),
    ];
    for (i, curve) in curves.iter().enumerate() {
        shapes.extend(panel(curve, TITLE + PANEL * i as f64));
    }
    Drawing { size: [WIDTH, TITLE + PANEL * curves.len() as f64 + 8.0].map(|length| length as u32), shapes }
}

/// A square icon: the first curve on a pale disc, without axes.
pub fn icon(curves: &[Curve]) -> Drawing {
    let mut shapes = vec![Shape::Disc { at: [50.0; 2], radius: 48.0, ink: PALE }];
    if let Some(curve) = curves.first() {
        let frame = Frame { ends: [[16.0, 84.0], [68.0, 32.0]], ranges: [0, 1].map(|axis| range(curve, axis)) };
        shapes.push(drawn(curve, &frame, 3.0));
    }
    Drawing { size: [100; 2], shapes }
}

fn drawn(curve: &Curve, frame: &Frame, width: f64) -> Shape {
    let finite = curve.points.iter().filter(|p| p.iter().all(|c| c.is_finite()));
    Shape::line(finite.map(|p| frame.at(*p)).collect(), width, BLUE)
}

/// Smallest and largest finite coordinate; a constant gets room above and below.
fn range(curve: &Curve, axis: usize) -> [f64; 2] {
    let finite = curve.points.iter().map(|p| p[axis]).filter(|v| v.is_finite());
    let (low, high) = finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
    // What differs by rounding only is constant.
    let magnitude = low.abs().max(high.abs());
    if low > high {
        [-1.0, 1.0]
    } else if high - low <= 1e-12 * magnitude || magnitude == 0.0 {
        let room = if magnitude > 0.0 { magnitude } else { 1.0 };
        [low - room, high + room]
    } else {
        [low, high]
    }
}

fn panel(curve: &Curve, top: f64) -> Vec<Shape> {
    let x = range(curve, 0);
    let angle = curve.x_label.contains('°');
    let x_step = if angle { angular_step(x[1] - x[0], PARTS) } else { decimal_step(x[1] - x[0]) };
    let [low, high] = range(curve, 1);
    let y_step = decimal_step(high - low);
    let y = [(low / y_step).floor() * y_step, (high / y_step).ceil() * y_step];
    let (bottom, above) = (top + PANEL - BELOW, top + ABOVE);
    let frame = Frame { ends: [[LEFT, WIDTH - RIGHT], [bottom, above]], ranges: [x, y] };
    let mut shapes = Vec::new();
    for tick in ticks(y, y_step) {
        let [_, height] = frame.at([x[0], tick]);
        let ink = if tick == 0.0 { BLACK } else { GREY };
        shapes.push(Shape::line(vec![[LEFT, height], [WIDTH - RIGHT, height]], 1.0, ink));
        shapes.push(Shape::text([LEFT - 8.0, height + 0.35 * TEXT], TEXT, Anchor::End, decimal(tick, y_step)));
    }
    for tick in ticks(x, x_step) {
        let [across, _] = frame.at([tick, y[0]]);
        shapes.push(Shape::line(vec![[across, bottom], [across, above]], 1.0, GREY));
        shapes.push(Shape::text([across, bottom + 1.3 * TEXT], TEXT, Anchor::Middle, decimal(tick, x_step)));
    }
    let heading = format!("{} over {}: {}", curve.y_label, curve.x_label, curve.title);
    shapes.push(Shape::text([LEFT, above - 0.6 * TEXT], TEXT, Anchor::Start, heading));
    shapes.push(drawn(curve, &frame, 2.0));
    shapes
}

/// The multiples of `step` in the range.
fn ticks([low, high]: [f64; 2], step: f64) -> impl Iterator<Item = f64> {
    // A millionth of a step makes up for the rounding of the borders.
    let (first, last) = ((low / step - 1e-6).ceil() as i64, (high / step + 1e-6).floor() as i64);
    (first..=last).map(move |i| i as f64 * step)
}

#[cfg(test)]
mod tests {
    use super::super::png::png;
    use super::*;

    #[test]
    fn odd_curves_are_drawn_all_the_same() {
        let curve = |points: Vec<[f64; 2]>| Curve {
            title: String::new(),
            x_label: "t".to_owned(),
            y_label: "y".to_owned(),
            points,
        };
        for points in [vec![], vec![[0.0, 0.0]], vec![[0.0, 3.0], [1.0, 3.0]], vec![[0.0, f64::NAN], [1.0, 1e-300]]] {
            let curves = [curve(points)];
            assert!(png(&of_curves("title", "", &curves)).is_ok());
            assert!(png(&icon(&curves)).is_ok());
        }
    }
}
