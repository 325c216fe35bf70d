//! The picture of a drive: its curves in panels, one above the other, below the title; and its icon.

use camdrive::drives::Curve;
use camdrive_design::drawing::{Anchor, BLUE, Drawing, Ink, Shape, Unit};
use camdrive_design::plot::{Axis, Diagram, Series, TEXT};

const WIDTH: f64 = 460.0;
const TITLE: f64 = 40.0;
const PANEL: f64 = 135.0;
/// Above and below the plot of a panel: room for its name and for the numbers of the axis.
const ABOVE: f64 = 22.0;
const BELOW: f64 = 22.0;
const LEFT: f64 = 68.0;
const RIGHT: f64 = 22.0;
/// The magnification of the picture.
pub const SCALE: f64 = 1.3;
/// The pixels of an FMU's icon per unit of its drawing.
pub const ICON: f64 = 2.0;
/// The background of the icon.
const PALE: Ink = Ink([0xdd, 0xe6, 0xef]);

/// The curves below the title, with the model's name next to it in small letters.
pub fn of_curves(title: &str, subtitle: &str, curves: &[Curve]) -> Drawing {
    let mut shapes = vec![
        Shape::text([LEFT, 24.0], 14.5, Anchor::Start, title),
        Shape::text([WIDTH - RIGHT, 24.0], TEXT, Anchor::End, subtitle),
    ];
    for (i, curve) in curves.iter().enumerate() {
        let top = TITLE + PANEL * i as f64;
        let (_, parts) = diagram(curve).plot([[LEFT, WIDTH - RIGHT], [top + PANEL - BELOW, top + ABOVE]]);
        let heading = format!("{}: {}", curve.y_label, curve.title);
        shapes.push(Shape::text([LEFT, top + ABOVE - 7.0], TEXT, Anchor::Start, heading));
        shapes.extend(parts.concat());
    }
    // All of them have the same abscissa.
    let end = TITLE + PANEL * curves.len() as f64;
    let at = [0.5 * (LEFT + WIDTH - RIGHT), end + 12.0];
    shapes.extend(curves.first().map(|curve| Shape::text(at, TEXT, Anchor::Middle, &curve.x_label)));
    Drawing { size: [WIDTH, end + 22.0], unit: Unit::Pixel, shapes }
}

/// A square icon: the first curve on a pale disc, without axes.
pub fn icon(curves: &[Curve]) -> Drawing {
    let mut shapes = vec![Shape::Disc { at: [50.0; 2], radius: 48.0, ink: PALE }];
    if let Some(curve) = curves.first() {
        let (frame, _) = diagram(curve).plot([[16.0, 84.0], [68.0, 32.0]]);
        let finite = curve.points.iter().filter(|p| p.iter().all(|c| c.is_finite()));
        shapes.push(Shape::line(finite.map(|p| frame.at(*p)).collect(), 3.0, BLUE));
    }
    Drawing { size: [100.0; 2], unit: Unit::Pixel, shapes }
}

/// The diagram of a curve, without title.
pub fn diagram(curve: &Curve) -> Diagram {
    let finite = || curve.points.iter().map(|p| p[0]).filter(|x| x.is_finite());
    let [low, high] = finite().fold([f64::INFINITY, f64::NEG_INFINITY], |[l, h], x| [l.min(x), h.max(x)]);
    let x = if curve.x_label.contains('°') { Axis::angular(&curve.x_label) } else { Axis::linear(&curve.x_label) };
    let x = if low < high { x.between(low, high) } else { x };
    Diagram::new("", [x, Axis::linear(&curve.y_label)], vec![Series::line("", curve.points.clone())], Vec::new())
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
            assert!(of_curves("title", "", &curves).svg("", SCALE).contains("title"));
            assert!(png(&icon(&curves), ICON).is_ok());
        }
    }
}
