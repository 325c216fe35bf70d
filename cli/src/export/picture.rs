//! The picture of a drive: its curves in panels one above the other, under the title.

use super::drawing::{Anchor, BLACK, BLUE, Drawing, GREY, PALE, Shape};
use camdrive::drives::Curve;

const WIDTH: f64 = 720.0;
const TITLE: f64 = 48.0;
const PANEL: f64 = 170.0;
/// Above and below the area of a panel: room for its name and for the numbers of the axis.
const ABOVE: f64 = 26.0;
const BELOW: f64 = 26.0;
const LEFT: f64 = 84.0;
const RIGHT: f64 = 28.0;
const TEXT: f64 = 13.0;

/// The curves under the title, with the model's name below it in small.
pub fn of_curves(title: &str, subtitle: &str, curves: &[Curve]) -> Drawing {
    let mut shapes = vec![
        Shape::Text { at: [LEFT, 28.0], size: 19.0, anchor: Anchor::Start, text: title.to_owned() },
        Shape::Text { at: [WIDTH - RIGHT, 28.0], size: TEXT, anchor: Anchor::End, text: subtitle.to_owned() },
    ];
    for (i, curve) in curves.iter().enumerate() {
        shapes.extend(panel(curve, TITLE + PANEL * i as f64));
    }
    Drawing { width: WIDTH as u32, height: (TITLE + PANEL * curves.len() as f64 + 8.0) as u32, shapes }
}

/// A square icon: the first curve on a pale disc, without axes.
pub fn icon(curves: &[Curve]) -> Drawing {
    const SIDE: f64 = 100.0;
    let disc = (0..72).map(|i| {
        let (s, c) = (f64::from(i) * std::f64::consts::TAU / 72.0).sin_cos();
        [50.0 + 48.0 * c, 50.0 + 48.0 * s]
    });
    let mut shapes = vec![Shape::Area { points: disc.collect(), ink: PALE }];
    if let Some(curve) = curves.first() {
        let area = Area { left: 16.0, right: 84.0, top: 32.0, bottom: 68.0, x: range(curve, 0), y: range(curve, 1) };
        shapes.push(Shape::Line { points: area.place(curve), width: 3.0, ink: BLUE });
    }
    Drawing { width: SIDE as u32, height: SIDE as u32, shapes }
}

/// A rectangle in pixels and the ranges of x and y that it shows.
struct Area {
    left: f64,
    right: f64,
    top: f64,
    bottom: f64,
    x: [f64; 2],
    y: [f64; 2],
}

impl Area {
    fn at(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let share = |v: f64, [low, high]: [f64; 2]| (v - low) / (high - low);
        [
            self.left + (self.right - self.left) * share(x, self.x),
            self.bottom - (self.bottom - self.top) * share(y, self.y),
        ]
    }

    fn place(&self, curve: &Curve) -> Vec<[f64; 2]> {
        curve.points.iter().filter(|p| p.iter().all(|c| c.is_finite())).map(|p| self.at(*p)).collect()
    }
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
    let x_step = if angle { angular_step(x[1] - x[0]) } else { decimal_step(x[1] - x[0]) };
    let [low, high] = range(curve, 1);
    let y_step = decimal_step(high - low);
    let y = [(low / y_step).floor() * y_step, (high / y_step).ceil() * y_step];
    let area = Area { left: LEFT, right: WIDTH - RIGHT, top: top + ABOVE, bottom: top + PANEL - BELOW, x, y };
    let mut shapes = Vec::new();
    for tick in ticks(y, y_step) {
        let ([left, height], [right, _]) = (area.at([x[0], tick]), area.at([x[1], tick]));
        let ink = if tick == 0.0 { BLACK } else { GREY };
        shapes.push(Shape::Line { points: vec![[left, height], [right, height]], width: 1.0, ink });
        shapes.push(label([left - 8.0, height + 0.35 * TEXT], Anchor::End, decimal(tick, y_step)));
    }
    for tick in ticks(x, x_step) {
        let ([across, bottom], [_, top]) = (area.at([tick, y[0]]), area.at([tick, y[1]]));
        shapes.push(Shape::Line { points: vec![[across, bottom], [across, top]], width: 1.0, ink: GREY });
        shapes.push(label([across, bottom + 1.3 * TEXT], Anchor::Middle, decimal(tick, x_step)));
    }
    let heading = format!("{} over {}: {}", curve.y_label, curve.x_label, curve.title);
    shapes.push(label([LEFT, top + ABOVE - 0.6 * TEXT], Anchor::Start, heading));
    shapes.push(Shape::Line { points: area.place(curve), width: 2.0, ink: BLUE });
    shapes
}

fn label(at: [f64; 2], anchor: Anchor, text: String) -> Shape {
    Shape::Text { at, size: TEXT, anchor, text }
}

/// 1, 2 or 5 times a power of ten, three to six of them in `span`.
fn decimal_step(span: f64) -> f64 {
    let power = 10f64.powf((span / 6.0).log10().floor());
    [1.0, 2.0, 5.0, 10.0].into_iter().map(|m| m * power).find(|step| span / step <= 6.0).unwrap_or(10.0 * power)
}

/// A divisor of the turn in degrees, or a multiple of it.
fn angular_step(span: f64) -> f64 {
    [10.0, 15.0, 30.0, 45.0, 60.0, 90.0, 180.0, 360.0]
        .into_iter()
        .find(|step| span / step <= 8.0)
        .unwrap_or_else(|| decimal_step(span))
}

/// The multiples of `step` in the range.
fn ticks([low, high]: [f64; 2], step: f64) -> impl Iterator<Item = f64> {
    // A millionth of a step makes up for the rounding of the borders.
    let (first, last) = ((low / step - 1e-6).ceil() as i64, (high / step + 1e-6).floor() as i64);
    (first..=last).map(move |i| i as f64 * step)
}

/// The tick's number with as many decimals as the step needs.
fn decimal(tick: f64, step: f64) -> String {
    if tick == 0.0 {
        return "0".to_owned();
    }
    let exponent = step.log10().floor();
    let (decimals, digits) = ((-exponent).max(0.0) as usize, (tick.abs().log10().floor() - exponent).max(0.0) as usize);
    let text = if (1e-4..1e6).contains(&step) { format!("{tick:.decimals$}") } else { format!("{tick:.digits$e}") };
    text.replace('-', "−")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_round() {
        assert_eq!(decimal_step(7.3), 2.0);
        assert!((decimal_step(0.032) - 0.01).abs() < 1e-15);
        assert_eq!(angular_step(360.0), 45.0);
        assert_eq!(decimal(-0.25, 0.05), "−0.25");
        assert_eq!([0.0, 8e6, -1.2e7].map(|tick| decimal(tick, 2e6)), ["0", "8e6", "−1.2e7"]);
        assert_eq!(ticks([0.0, 360.0], 45.0).count(), 9);
    }

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
            assert!(of_curves("title", "", &curves).png().is_ok());
            assert!(icon(&curves).png().is_ok());
        }
    }
}
