//! Dwell–rise–dwell–return cycles over one turn.

use super::StandardLaw;
use super::pieces::{Form, Pieces, ROUNDING};
use super::plan::{End, INFLECTION, LARGEST, LEAST_MOTION, Segment};
use super::turn::reduce;
use crate::numerics::number::{Number, Rounded};
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// The motion plan of a cycle (VDI 2143): rise, upper dwell, return, and the lower dwell for the rest of the turn.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CyclePlan {
    /// Lift from the lower to the upper dwell (m); negative if the rise lowers the follower.
    pub stroke: f64,
    /// U in the lower dwell (m).
    pub lower: f64,
    /// Angle at which the rise starts (rad).
    pub rise_start: f64,
    /// Angle of the rise (rad).
    pub rise_angle: f64,
    /// Angle of the upper dwell (rad); may be 0.
    pub upper_dwell: f64,
    /// Angle of the return (rad).
    pub return_angle: f64,
    /// The law of the rise.
    pub rise_law: StandardLaw,
    /// The law of the return, run backwards: U = lower + stroke (1 − f(z)).
    pub return_law: StandardLaw,
    /// Fractions of their angles at which the accelerations of rise and return change sign; the middle without a value.
    pub inflections: [Option<f64>; 2],
}

impl CyclePlan {
    /// Angle of the lower dwell (rad), the rest of the turn; negative if the plan is too long.
    pub fn lower_dwell(&self) -> f64 {
        TAU - (self.rise_angle + self.upper_dwell + self.return_angle)
    }

    /// Whether the values are in their ranges and the angles make at most one turn.
    pub fn validate(&self) -> Result<(), String> {
        let (length, [least, most]) = (LARGEST, INFLECTION);
        let [rise_inflection, return_inflection] = self.inflections.map(|part| part.unwrap_or(0.5));
        for (name, value, min, max) in [
            ("stroke", self.stroke, -length, length),
            ("lower", self.lower, -length, length),
            ("rise_start", self.rise_start, -TAU, TAU),
            ("rise", self.rise_angle, LEAST_MOTION, TAU),
            ("upper_dwell", self.upper_dwell, 0.0, TAU),
            ("return", self.return_angle, LEAST_MOTION, TAU),
            ("rise_inflection", rise_inflection, least, most),
            ("return_inflection", return_inflection, least, most),
        ] {
            if !(value >= min && value <= max) {
                return Err(format!("{name} = {} is out of range; expected {min} to {max}", Number(value)));
            }
        }
        if self.lower_dwell() < -ROUNDING {
            let sum = self.rise_angle + self.upper_dwell + self.return_angle;
            let [rise, upper, back] = [self.rise_angle, self.upper_dwell, self.return_angle].map(Number);
            return Err(format!(
                "rise = {rise} rad, upper_dwell = {upper} rad and return = {back} rad add up to {} rad = {} deg, more than the turn of 2π \
                 rad = 360 deg; together with the lower dwell, which is the rest of the turn, they must make 2π",
                Rounded(sum),
                Rounded(sum.to_degrees())
            ));
        }
        Ok(())
    }
}

/// A dwell–rise–dwell–return cycle with its plan cut into analytic pieces.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(from = "CyclePlan", into = "CyclePlan")]
pub struct Cycle {
    plan: CyclePlan,
    pub(super) pieces: Pieces,
}

impl From<CyclePlan> for Cycle {
    fn from(plan: CyclePlan) -> Self {
        Cycle::new(plan)
    }
}

impl From<Cycle> for CyclePlan {
    fn from(cycle: Cycle) -> Self {
        cycle.plan
    }
}

impl Cycle {
    /// The cycle of this plan. A plan that [`CyclePlan::validate`] refuses stays in the lower dwell; such plans arise while
    /// parameters are set one after the other.
    pub fn new(plan: CyclePlan) -> Self {
        let pieces = if plan.validate().is_ok() { Pieces::new(forms(&plan)) } else { Pieces::at_rest(plan.lower) };
        Cycle { plan, pieces }
    }

    /// The plan.
    pub fn plan(&self) -> &CyclePlan {
        &self.plan
    }
}

/// Rise, upper dwell, return and lower dwell of a valid plan.
fn forms(plan: &CyclePlan) -> Vec<([f64; 2], Form)> {
    let CyclePlan { stroke, lower, rise_angle, upper_dwell, return_angle, rise_law, return_law, inflections, .. } =
        *plan;
    let rise = reduce(plan.rise_start);
    let dwell = rise + rise_angle;
    let fall = dwell + upper_dwell;
    let rest = fall + return_angle;
    let end = |phi: f64, u: f64| End { phi, u, v: 0.0, turns: false };
    let motion = |ends: [End; 2], angle: f64, law: StandardLaw, inflection: Option<f64>| {
        Segment { ends, angle, law }.forms(inflection.unwrap_or(0.5))
    };
    let mut forms = motion([end(rise, 0.0), end(dwell, stroke)], rise_angle, rise_law, inflections[0]);
    forms.push(([dwell, fall], Form::straight(dwell, stroke, 0.0)));
    forms.extend(motion([end(fall, stroke), end(rest, 0.0)], return_angle, return_law, inflections[1]));
    forms.push(([rest, rise + TAU], Form::straight(rest, 0.0, 0.0)));
    // Added last, so that the lower position does not round the stroke.
    for (_, form) in &mut forms {
        form.base += lower;
    }
    forms
}

#[cfg(test)]
mod tests {
    use super::*;
    use StandardLaw::*;
    use std::f64::consts::PI;

    fn plan() -> CyclePlan {
        CyclePlan {
            stroke: 0.04,
            lower: 0.01,
            rise_start: 4.5,
            rise_angle: 1.5,
            upper_dwell: 0.7,
            return_angle: 2.0,
            rise_law: ModifiedTrapezoid,
            return_law: ModifiedSine,
            inflections: [None; 2],
        }
    }

    fn at(cycle: &Cycle, phi: f64) -> [f64; 5] {
        cycle.pieces.at_in(cycle.pieces.segment(phi, true), phi).0
    }

    #[test]
    fn the_cycle_is_its_law_on_the_rise_and_mirrored_on_the_return() {
        for (rise_law, return_law) in [(InclinedSine, Polynomial345), (ModifiedTrapezoid, ModifiedSine)] {
            let plan = CyclePlan { rise_law, return_law, ..plan() };
            let cycle = Cycle::new(plan);
            for i in 0..100 {
                let z = (f64::from(i) + 0.5) / 100.0;
                let (f, g) = (rise_law.at(z), return_law.at(z));
                let u = at(&cycle, 4.5 + 1.5 * z);
                let v = at(&cycle, 4.5 + 1.5 + 0.7 + 2.0 * z - TAU);
                assert!((u[0] - (0.01 + 0.04 * f[0])).abs() < 1e-16);
                assert!((v[0] - (0.05 - 0.04 * g[0])).abs() < 1e-16);
                for n in 1..5 {
                    let (a, b) = (0.04 / 1.5_f64.powi(n as i32), 0.04 / 2.0_f64.powi(n as i32));
                    assert!((u[n] - a * f[n]).abs() < 1e-14 * a * rise_law.peak(n).max(1.0) * 10.0, "{z} {n}");
                    assert!((v[n] + b * g[n]).abs() < 1e-14 * b * return_law.peak(n).max(1.0) * 10.0, "{z} {n}");
                }
            }
            assert_eq!(at(&cycle, 6.3), [0.05, 0.0, 0.0, 0.0, 0.0]);
            assert_eq!(at(&cycle, 4.0), [0.01, 0.0, 0.0, 0.0, 0.0]);
        }
    }

    #[test]
    fn the_angle_may_come_from_any_turn() {
        let cycle = Cycle::new(plan());
        for i in 0..200 {
            let phi = -PI + TAU * f64::from(i) / 200.0;
            for turns in [-1.0, 1.0] {
                let other = phi + turns * TAU;
                let segment = cycle.pieces.segment(phi, true);
                let (u, v) = (cycle.pieces.at_in(segment, phi).0, cycle.pieces.at_in(segment, other).0);
                for n in 0..5 {
                    // The two angles differ by a rounding of 2π.
                    assert!(
                        (u[n] - v[n]).abs() < 1e-13 * (1.0 + cycle.pieces.bound_in(segment, n.min(4))),
                        "{phi} {n}"
                    );
                }
            }
        }
    }

    #[test]
    fn the_pieces_join_with_continuous_velocity_and_acceleration() {
        for rise_start in [-6.0, -1.0, 0.0, 2.0, 5.5, TAU] {
            let cycle = Cycle::new(CyclePlan { rise_start, ..plan() });
            let breakpoints = cycle.pieces.breakpoints().to_vec();
            assert_eq!(breakpoints.len(), 5 + 1 + 3 + 1);
            assert!(breakpoints.windows(2).all(|w| w[0] < w[1]));
            for &b in &breakpoints {
                let left = cycle.pieces.at_in(cycle.pieces.segment(b, false), b).0;
                let right = cycle.pieces.at_in(cycle.pieces.segment(b, true), b).0;
                assert_ne!(cycle.pieces.segment(b, false), cycle.pieces.segment(b, true));
                for n in 0..3 {
                    assert!((left[n] - right[n]).abs() < 1e-14, "rise_start {rise_start}, at {b}, order {n}");
                }
                assert!((left[3] - right[3]).abs() + (left[4] - right[4]).abs() > 1e-3);
            }
        }
    }

    #[test]
    fn bounds_hold_in_each_piece() {
        let cycle = Cycle::new(plan());
        for i in 0..10_000 {
            let phi = TAU * f64::from(i) / 10_000.0;
            let segment = cycle.pieces.segment(phi, true);
            for (n, u) in cycle.pieces.at_in(segment, phi).0.into_iter().enumerate() {
                assert!(u.abs() <= cycle.pieces.bound_in(segment, n) * (1.0 + 1e-14), "{phi} {n}");
            }
        }
    }

    #[test]
    fn dwells_may_be_missing() {
        let half = CyclePlan { rise_angle: PI, return_angle: PI, upper_dwell: 0.0, rise_law: SimpleSine, ..plan() };
        let cycle = Cycle::new(CyclePlan { return_law: SimpleSine, rise_start: 0.0, ..half });
        assert_eq!(cycle.pieces.breakpoints().len(), 2);
        // Simple sine over two halves is a cosine.
        for i in 0..100 {
            let phi = TAU * f64::from(i) / 100.0;
            let u = at(&cycle, phi);
            assert!((u[0] - (0.03 - 0.02 * phi.cos())).abs() < 1e-16);
            assert!((u[1] - 0.02 * phi.sin()).abs() < 1e-16);
            assert!((u[4] + 0.02 * phi.cos()).abs() < 1e-16);
        }
    }

    #[test]
    fn a_plan_beyond_the_turn_is_refused_with_its_values() {
        let long = CyclePlan { return_angle: 4.1, ..plan() };
        let message = long.validate().unwrap_err();
        for part in ["rise = 1.5 rad", "upper_dwell = 0.7 rad", "return = 4.1 rad", "2π"] {
            assert!(message.contains(part), "{message}");
        }
        // Rests meanwhile, without NaN.
        assert_eq!(at(&Cycle::new(long), 1.0), [0.01, 0.0, 0.0, 0.0, 0.0]);
        let nan = CyclePlan { lower: f64::NAN, ..plan() };
        assert!(nan.validate().unwrap_err().starts_with("lower = "));
        assert_eq!(at(&Cycle::new(nan), 1.0), [0.0; 5]);
        assert!(CyclePlan { rise_angle: 0.0, ..plan() }.validate().is_err());
        // Degrees that make 360 in sum may miss 2π by roundings.
        let full = CyclePlan { rise_angle: 2.0, upper_dwell: TAU - 4.0 + 1e-14, ..plan() };
        assert!(full.validate().is_ok() && Cycle::new(full).pieces.breakpoints().len() == 9);
    }
}
