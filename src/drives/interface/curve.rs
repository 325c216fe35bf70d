//! Curves that picture a drive, for the documentation and an importer's window.

use crate::motion::MotionLaw;
use std::f64::consts::TAU;

/// A curve y(x), in the units of its labels.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// Title, for example "Position function U(φ)".
    pub title: String,
    /// Quantity and unit of the abscissa, for example "φ (°)".
    pub x_label: String,
    /// Quantity and unit of the ordinate, for example "U (mm)".
    pub y_label: String,
    /// The points; straight lines join neighbours.
    pub points: Vec<[f64; 2]>,
}

/// Points of a turn: half a degree apart, finer than a drawing shows.
const POINTS: usize = 720;

impl Curve {
    /// `ordinate` of the angle φ ∈ [0, 2π] (rad) over a turn, φ shown in degrees.
    pub fn over_turn(title: &str, y_label: &str, ordinate: impl Fn(f64) -> f64) -> Curve {
        let angles = (0..=POINTS).map(|i| TAU * i as f64 / POINTS as f64);
        Curve {
            title: title.to_owned(),
            x_label: "φ [°]".to_owned(),
            y_label: y_label.to_owned(),
            points: angles.map(|phi| [phi.to_degrees(), ordinate(phi)]).collect(),
        }
    }

    /// U(φ) (mm) and its first two derivatives (mm/radⁿ) over a turn, φ in degrees.
    pub fn of_law(law: &MotionLaw) -> Vec<Curve> {
        let names = [
            ("Position function U(φ)", "U [mm]"),
            ("First transfer function U′(φ)", "U′ [mm/rad]"),
            ("Second transfer function U″(φ)", "U″ [mm/rad²]"),
        ];
        let curve = |(n, (title, label))| Curve::over_turn(title, label, |phi| 1e3 * law.at(phi).0[n]);
        names.into_iter().enumerate().map(curve).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::Fourier;

    #[test]
    fn the_curves_of_a_cosine() {
        let law = MotionLaw::Fourier(Fourier::new(vec![0.0, 2e-3], vec![]));
        let curves = Curve::of_law(&law);
        // U = 2 mm cos φ: at 180° U = −2 mm, U′ = 0, U″ = +2 mm.
        let at_half: Vec<f64> = curves.iter().map(|c| c.points[POINTS / 2][1]).collect();
        assert!((at_half[0] + 2.0).abs() < 1e-12 && at_half[1].abs() < 1e-12 && (at_half[2] - 2.0).abs() < 1e-12);
        assert_eq!(curves[0].points[POINTS][0], 360.0);
    }
}
