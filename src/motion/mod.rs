//! The cam as a function of its angle: the position function U(φ), 2π-periodic, and its derivatives.
//!
//! It knows no time, mass or stiffness. U is in m, U⁽ⁿ⁾ in m/radⁿ; φ in rad. Names after VDI 2143.

pub mod crank;
pub mod cycle;
pub mod derivatives;
pub mod fourier;
pub mod parameter;
mod parameters;
pub mod pieces;
pub mod plan;
mod points;
pub mod polyline;
mod spline;
pub mod standard_laws;
pub mod table;
pub mod turn;

pub use crank::Crank;
pub use cycle::{Cycle, CyclePlan};
pub use derivatives::{Kinematics, TransferFunctions};
pub use fourier::Fourier;
pub use plan::{MotionPlan, PlanPoint};
pub use polyline::Polyline;
pub use standard_laws::StandardLaw;
pub use table::Table;

use crate::numerics::work::HARMONIC;
use plan::MAX_LENGTH;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// A motion law.
///
/// Between neighbouring breakpoints U is analytic; on a breakpoint a derivative jumps, and the segment selects the one-sided value.
///
/// ```
/// use camdrive::motion::{Fourier, MotionLaw};
///
/// // U = 10 mm · sin φ.
/// let law = MotionLaw::Fourier(Fourier::new(vec![], vec![0.0, 0.01]));
/// let [u, slope, curvature, ..] = law.at(std::f64::consts::FRAC_PI_2).0;
/// assert!((u - 0.01).abs() < 1e-17 && slope.abs() < 1e-17 && (curvature + 0.01).abs() < 1e-17);
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum MotionLaw {
    /// A finite Fourier series (HS profile).
    Fourier(Fourier),
    /// A dwell–rise–dwell–return cycle.
    Cycle(Cycle),
    /// A table of angles and lifts.
    Table(Table),
    /// A motion plan.
    Plan(MotionPlan),
    /// The angle of the shaft, for a mechanism that sits on it.
    Crank(Crank),
    /// Straight lines or monotone curves, with steps.
    Polyline(Polyline),
}

/// A law that consists of pieces.
macro_rules! pieces {
    ($pieces:ident) => {
        MotionLaw::Cycle(Cycle { pieces: $pieces, .. })
            | MotionLaw::Plan(MotionPlan { pieces: $pieces, .. })
            | MotionLaw::Polyline(Polyline { pieces: $pieces, .. })
    };
}

/// The bounds are enlarged by this part, which exceeds the roundings of the bounds and of the bounded values.
const BOUND_ROUNDING: f64 = 1e-12;

impl MotionLaw {
    /// U … U⁗ at the angle `phi` (rad), which lies in [−2π, 2π]; on a breakpoint the right-hand values.
    pub fn at(&self, phi: f64) -> TransferFunctions {
        self.at_in(self.segment(phi, true), phi)
    }

    /// U … U⁗ of `segment`, continued smoothly also a little outside of it.
    pub fn at_in(&self, segment: usize, phi: f64) -> TransferFunctions {
        match self {
            MotionLaw::Fourier(series) => series.at(phi),
            pieces!(pieces) => pieces.at_in(segment, phi),
            MotionLaw::Table(table) => table.at_in(segment, phi),
            MotionLaw::Crank(crank) => crank.at(phi),
        }
    }

    /// U⁽⁵⁾ at `phi`, continued like [`MotionLaw::at_in`].
    pub fn fifth_in(&self, segment: usize, phi: f64) -> f64 {
        let mut coefficients = [0.0; 6];
        self.expand(segment, phi, 1.0, &mut coefficients);
        120.0 * coefficients[5]
    }

    /// U(φ + step x) = Σ cₙ xⁿ continued from segment `segment`: the `coefficients` c₀ …, at least 6 and at most 32.
    pub fn expand(&self, segment: usize, phi: f64, step: f64, coefficients: &mut [f64]) {
        match self {
            MotionLaw::Fourier(series) => series.expand(phi, step, coefficients),
            pieces!(pieces) => pieces.expand(segment, phi, step, coefficients),
            MotionLaw::Table(table) => table.expand(segment, phi, step, coefficients),
            MotionLaw::Crank(crank) => crank.expand(phi, step, coefficients),
        }
    }

    /// The segment that holds `phi`; on a breakpoint (within some roundings of the angle) the segment after it (`forward`) or
    /// before it.
    pub fn segment(&self, phi: f64, forward: bool) -> usize {
        match self {
            MotionLaw::Fourier(_) | MotionLaw::Crank(_) => 0,
            pieces!(pieces) => pieces.segment(phi, forward),
            MotionLaw::Table(table) => table.segment(phi, forward),
        }
    }

    /// The angles in [0, 2π), ascending, at which a derivative jumps: in a cycle or a plan one of order ≤ 4; in a table order 5, or
    /// order 2 with given derivatives; of lines and monotone curves U, U′ or U″. Segment i reaches from breakpoint i to breakpoint
    /// i + 1, the last one around the turn. Empty if U is smooth all around.
    pub fn breakpoints(&self) -> &[f64] {
        match self {
            MotionLaw::Fourier(_) | MotionLaw::Crank(_) => &[],
            pieces!(pieces) => pieces.breakpoints(),
            MotionLaw::Table(table) => table.breakpoints(),
        }
    }

    /// An upper bound of |U⁽ᵒʳᵈᵉʳ⁾| over the turn (m/radᵒʳᵈᵉʳ), order ≤ 4, to locate events with certainty.
    pub fn bound(&self, order: usize) -> f64 {
        let bound = match self {
            MotionLaw::Fourier(series) => series.bound(order),
            pieces!(pieces) => {
                (0..pieces.breakpoints().len()).map(|segment| pieces.bound_in(segment, order)).fold(0.0, f64::max)
            }
            MotionLaw::Table(table) => table.bound(order),
            MotionLaw::Crank(crank) => crank.bound(order),
        };
        bound * (1.0 + BOUND_ROUNDING)
    }

    /// The bound within one segment; in a dwell the derivatives vanish.
    pub fn bound_in(&self, segment: usize, order: usize) -> f64 {
        let bound = match self {
            MotionLaw::Fourier(series) => series.bound(order),
            pieces!(pieces) => pieces.bound_in(segment, order),
            MotionLaw::Table(table) => table.bound_in(segment, order),
            MotionLaw::Crank(crank) => crank.bound(order),
        };
        bound * (1.0 + BOUND_ROUNDING)
    }

    /// The harmonic order that resolves the law: a polynomial of degree 16 over an angle of 2/K rad meets U to
    /// about 1e-16 of its amplitude within a segment. At least 1.
    pub fn resolution(&self) -> f64 {
        match self {
            MotionLaw::Fourier(series) => series.order().max(1) as f64,
            MotionLaw::Cycle(Cycle { pieces, .. }) | MotionLaw::Plan(MotionPlan { pieces, .. }) => {
                (0..pieces.breakpoints().len()).map(|segment| pieces.resolution_in(segment)).fold(1.0, f64::max)
            }
            // Each segment is itself a polynomial of degree 5 at most.
            MotionLaw::Table(_) | MotionLaw::Crank(_) | MotionLaw::Polyline(_) => 1.0,
        }
    }

    /// The harmonic order that resolves one segment.
    pub fn resolution_in(&self, segment: usize) -> f64 {
        match self {
            MotionLaw::Cycle(Cycle { pieces, .. }) | MotionLaw::Plan(MotionPlan { pieces, .. }) => {
                pieces.resolution_in(segment)
            }
            _ => self.resolution(),
        }
    }

    /// How far the roundings of coefficients from given points may move U′ and U″ (m/rad, m/rad²): for points at the distance 1/R
    /// by ε (|U| + 2π |U′|) Rⁿ; a polynomial of degree 7 sums up coefficients sixteen times as large.
    pub fn roundings(&self) -> [f64; 2] {
        let (finest, sums) = match self {
            MotionLaw::Polyline(lines) if lines.is_monotone() => (lines.finest(), 1.0),
            MotionLaw::Fourier(_) | MotionLaw::Cycle(_) | MotionLaw::Crank(_) | MotionLaw::Polyline(_) => {
                return [0.0; 2];
            }
            MotionLaw::Table(table) => (table.finest(), 1.0),
            MotionLaw::Plan(_) => (self.resolution(), 16.0),
        };
        let slope = sums * f64::EPSILON * (self.bound(0) + TAU * self.bound(1)) * finest;
        [slope, slope * finest]
    }

    /// Cost of an evaluation (nominal µs), see [`crate::numerics::work`]: a law of pieces costs as much as ten harmonics.
    pub fn cost(&self) -> f64 {
        HARMONIC * self.series().map_or(10.0, |series| series.order() as f64)
    }

    /// The Fourier series, if the law is one.
    pub fn series(&self) -> Option<&Fourier> {
        match self {
            MotionLaw::Fourier(series) => Some(series),
            _ => None,
        }
    }

    /// Whether the parameters, as set by the user, make a law; the message names quantity, value and range.
    pub fn validate(&self) -> Result<(), String> {
        let finite = (0..5).all(|order| self.bound(order).is_finite());
        match self {
            MotionLaw::Cycle(cycle) => cycle.plan().validate().map_err(|e| format!("the cam's plan: {e}"))?,
            MotionLaw::Plan(plan) => plan.validate().map_err(|e| format!("the motion plan: cam.{e}"))?,
            MotionLaw::Fourier(_) if !finite => {
                return Err(format!("the cam's Fourier coefficients must be finite and of at most {MAX_LENGTH:e} m"));
            }
            MotionLaw::Table(table) if !finite => {
                return Err(format!("cam.scale = {} makes the lifts of the table infinite", table.scale));
            }
            MotionLaw::Polyline(lines) if !(finite && lines.scale().is_finite()) => {
                return Err(format!("scale = {} makes the values of the points infinite", lines.scale()));
            }
            _ => {}
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::table::Points;
    use super::*;

    /// One law of each kind and each standard law.
    fn laws() -> Vec<MotionLaw> {
        let plan = |law| CyclePlan {
            stroke: 0.04,
            lower: -0.01,
            rise_start: -0.5,
            rise_angle: 1.5,
            upper_dwell: 0.7,
            return_angle: 2.0,
            rise_law: law,
            return_law: law,
            inflections: [None; 2],
        };
        let angles: Vec<f64> = (0..40).map(|i| TAU * f64::from(i) / 40.0).collect();
        let lifts = angles.iter().map(|phi| 0.02 * phi.sin().exp()).collect();
        let mut laws = vec![
            MotionLaw::Fourier(Fourier::new(vec![0.0, 0.02, 0.0, -0.003, 0.0, 2e-4], vec![0.0, 0.01])),
            MotionLaw::Table(Table::new(Points { angles, lifts }).unwrap()),
        ];
        let (angles, lifts) = (vec![0.5, 1.0, 1.0, 3.0, 5.0], vec![0.0, 0.0, -0.02, 0.01, 0.03]);
        let points = Points { angles, lifts };
        laws.extend(
            [Polyline::new(points.clone()), Polyline::monotone(points)]
                .map(|lines| MotionLaw::Polyline(lines.unwrap())),
        );
        laws.extend(StandardLaw::ALL.map(|law| MotionLaw::Cycle(Cycle::new(plan(law)))));
        let shifted = |law| CyclePlan { inflections: [Some(0.3), Some(0.62)], ..plan(law) };
        laws.extend(StandardLaw::ALL.map(|law| MotionLaw::Cycle(Cycle::new(shifted(law)))));
        laws.push(plan::tests::of_all_kinds());
        laws
    }

    /// Start and length of segment `i`.
    fn extent(law: &MotionLaw, i: usize) -> (f64, f64) {
        let b = law.breakpoints();
        match b.len() {
            0 => (0.0, TAU),
            n if i + 1 == n => (b[i], b[0] + TAU - b[i]),
            _ => (b[i], b[i + 1] - b[i]),
        }
    }

    #[test]
    fn bounds_hold_in_segments_and_over_the_turn() {
        for law in laws() {
            for i in 0..law.breakpoints().len().max(1) {
                let (start, width) = extent(&law, i);
                for k in 0..=200 {
                    let u = law.at_in(i, start + width * f64::from(k) / 200.0).0;
                    for n in 0..5 {
                        let bound = law.bound_in(i, n);
                        // The ends of the segment are rounded, so U⁽ⁿ⁾ is taken slightly outside of it.
                        assert!(u[n].abs() <= bound + 1e-15 * law.bound((n + 1).min(4)), "{law:?} {i} order {n}");
                        assert!(bound <= law.bound(n));
                    }
                }
            }
        }
    }

    #[test]
    fn the_fifth_derivative_is_that_of_the_fourth() {
        for law in laws() {
            for i in 0..law.breakpoints().len().max(1) {
                let (start, width) = extent(&law, i);
                for k in 0..=10 {
                    let phi = start + width * f64::from(k) / 10.0;
                    let h = 1e-3 / law.resolution_in(i);
                    let fourth = |k: f64| law.at_in(i, phi + k * h).0[4];
                    let slope = (8.0 * (fourth(1.0) - fourth(-1.0)) - (fourth(2.0) - fourth(-2.0))) / (12.0 * h);
                    let scale = law.bound_in(i, 4) * law.resolution_in(i).max(1.0 / width);
                    assert!((slope - law.fifth_in(i, phi)).abs() <= 1e-8 * scale, "{law:?} {i} at {phi}");
                }
            }
        }
    }

    #[test]
    fn the_taylor_coefficients_sum_up_to_the_law() {
        for law in laws() {
            for i in 0..law.breakpoints().len().max(1) {
                let (start, width) = extent(&law, i);
                for k in 0..=6 {
                    let phi = start + width * f64::from(k) / 6.0;
                    for step in [1.5, -1.5].map(|step| step / law.resolution_in(i)) {
                        let mut c = [0.0; 25];
                        law.expand(i, phi, step, &mut c);
                        for x in [0.0, 0.3, 1.0] {
                            let sum = c.iter().rev().fold(0.0, |sum, c| sum * x + c);
                            let value = law.at_in(i, phi + step * x).0[0];
                            // A law may be point-symmetric: its part for z > ½ is the same function.
                            let size = law.bound(0).max(value.abs());
                            assert!((sum - value).abs() < 4e-14 * size, "{law:?} {i} at {phi}: {sum} {value}");
                        }
                    }
                }
            }
        }
    }

    /// The error of the interpolant at the 17 Chebyshev points of [a, a + width], relative to the bound of U.
    fn interpolation_error(law: &MotionLaw, segment: usize, a: f64, width: f64) -> f64 {
        const N: usize = 17;
        let angle = |x: f64| a + 0.5 * width * (1.0 + x);
        let node = |i: usize| (TAU / 4.0 * (2 * i + 1) as f64 / N as f64).cos();
        let values: Vec<f64> = (0..N).map(|i| law.at_in(segment, angle(node(i))).0[0]).collect();
        let weight = |i: usize| (1.0 - 2.0 * (i % 2) as f64) * (TAU / 4.0 * (2 * i + 1) as f64 / N as f64).sin();
        let mut error: f64 = 0.0;
        for k in 0..50 {
            // Between the nodes, by the barycentric formula.
            let x = -0.9999 + 1.9998 * f64::from(k) / 49.0;
            let (mut above, mut below) = (0.0, 0.0);
            for i in 0..N {
                let w = weight(i) / (x - node(i));
                (above, below) = (above + w * values[i], below + w);
            }
            error = error.max((above / below - law.at_in(segment, angle(x)).0[0]).abs());
        }
        error / law.bound(0)
    }

    #[test]
    fn a_polynomial_of_degree_16_meets_the_law_over_the_angle_that_the_resolution_gives() {
        for law in laws() {
            for i in 0..law.breakpoints().len().max(1) {
                let (start, width) = extent(&law, i);
                let part = width.min(2.0 / law.resolution_in(i));
                for k in 0..5 {
                    let a = start + (width - part) * f64::from(k) / 4.0;
                    let error = interpolation_error(&law, i, a, part);
                    // The roundings of angles around 6 rad, times U′.
                    assert!(error < 5e-15, "{law:?}, segment {i}: {error:e}");
                }
                assert!(law.resolution_in(i) <= law.resolution());
            }
        }
    }

    #[test]
    fn no_angle_yields_a_nan_or_a_panic() {
        for law in laws() {
            for phi in [-1e9, -2.0 * TAU, -TAU, -1e-300, 0.0, TAU, 50.0] {
                for forward in [false, true] {
                    let u = law.at_in(law.segment(phi, forward), phi).0;
                    assert!(u.iter().all(|u| u.is_finite()) && u[0].abs() <= law.bound(0), "{law:?} at {phi}");
                }
            }
            law.at(f64::NAN);
            law.at_in(1000, 1.0);
        }
    }

    #[test]
    fn validity_is_told_by_name() {
        let mut laws = laws();
        assert!(laws.iter().all(|law| law.validate() == Ok(())));
        laws[0].set_parameter(1, f64::INFINITY);
        assert!(laws[0].validate().unwrap_err().contains("Fourier"));
        laws[1].set_parameter(0, f64::INFINITY);
        assert!(laws[1].validate().unwrap_err().contains("cam.scale"));
        for lines in &mut laws[2..4] {
            lines.set_parameter(0, f64::INFINITY);
            assert!(lines.validate().unwrap_err().contains("scale"));
        }
        laws[4].set_parameter(3, 5.0);
        let message = laws[4].validate().unwrap_err();
        assert!(message.contains("rise = 5 rad") && message.contains("2π"), "{message}");
    }
}
