//! The motions of a law between its stops, and their characteristic values.
//!
//! A motion leads over the angle β through the lift h, from one zero of U′ to the next. With f(z) = (U − U₀)/h, z = (φ − φ₀)/β:
//! C_v = max |f′|, C_a = max |f″|, C_j = max |f‴|, C_M = max |f′ f″| (VDI 2143), so that the largest velocity is C_v h Ω/β.

use super::{Overview, Warning, shown};
use crate::search::zero;
use crate::text::Table;
use camdrive::motion::{MotionLaw, MotionPlan};
use serde::Serialize;
use std::f64::consts::TAU;

/// Samples of a turn: peaks of smooth laws to six digits.
const SAMPLES: usize = 8192;

/// The part of max |U′| below which a follower stands.
const STANDING: f64 = 1e-12;

/// The part of the largest |U″| that is no jump of it but rounding.
const NO_JUMP: f64 = 1e-9;

/// The most motions that are told: more than those of any cam, fewer than those of a series of high order.
const MOST_MOTIONS: usize = 12;

/// A motion between two stops.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Motion {
    /// The section of its law, `cam` or `follower[1].cam`.
    pub law: String,
    /// Where it begins (rad).
    pub from: f64,
    /// Its angle β (rad).
    pub angle: f64,
    /// h.
    pub lift: f64,
    /// The unit of h.
    pub unit: &'static str,
    /// C_v.
    pub velocity: f64,
    /// C_a.
    pub acceleration: f64,
    /// C_j.
    pub jerk: f64,
    /// C_M.
    pub torque: f64,
}

impl Motion {
    /// What the columns of [`Motion::table`] mean.
    pub const SYMBOLS: &str = "From stop to stop, through the lift h over the angle β: the largest velocity is C_v h Ω/β, the \
        largest acceleration C_a h (Ω/β)², the largest jerk C_j h (Ω/β)³, the largest torque of inertia C_M m h² Ω²/β³.";

    /// A line for each of the motions.
    pub fn table(motions: &[Motion]) -> Table {
        let row = |motion: &Motion| {
            let Motion { velocity, acceleration, jerk, torque, .. } = *motion;
            let place = [motion.from, motion.from + motion.angle].map(|phi| shown(phi, "rad"));
            let lift = shown(motion.lift, motion.unit);
            let values = [velocity, acceleration, jerk, torque].map(super::digits);
            [vec![motion.law.clone()], place.to_vec(), vec![lift], values.to_vec()].concat()
        };
        Table::new("law  from  to  h  C_v  C_a  C_j  C_M", motions.iter().map(row))
    }

    /// For a terminal.
    pub fn text(&self) -> String {
        let [from, to] = [self.from, self.from + self.angle].map(|phi| shown(phi, "rad"));
        let [v, a, j, m] = [self.velocity, self.acceleration, self.jerk, self.torque].map(super::digits);
        format!("{from} … {to}, {}; C_v {v}, C_a {a}, C_j {j}, C_M {m}", shown(self.lift, self.unit))
    }
}

/// The motions of the law in a turn, in the order of their angles; none where it never stops or stops too often.
pub fn motions(section: &str, law: &MotionLaw, unit: &'static str) -> Vec<Motion> {
    let standing = STANDING * law.bound(1);
    let sign = |phi: f64| {
        let slope = law.at(phi).0[1];
        if slope.abs() <= standing { 0.0 } else { slope.signum() }
    };
    // Breakpoints are samples, since dwells end there.
    let even = (0..SAMPLES).map(|i| TAU * i as f64 / SAMPLES as f64);
    let mut angles: Vec<f64> = even.chain(law.breakpoints().iter().copied()).collect();
    angles.sort_by(f64::total_cmp);
    let cells: Vec<[f64; 2]> =
        angles.iter().zip(angles.iter().skip(1).chain(&[angles[0] + TAU])).map(|(a, b)| [*a, *b]).collect();
    let middle = |i: usize| sign(0.5 * (cells[i % cells.len()][0] + cells[i % cells.len()][1]));
    let Some(first) = (0..cells.len()).find(|&i| middle(i) != middle(i + cells.len() - 1)) else { return Vec::new() };
    let around = |i: usize| cells[i % cells.len()][0] + TAU * (i / cells.len()) as f64;
    let (mut list, mut start) = (Vec::new(), first);
    for i in first + 1..=first + cells.len() {
        if middle(i) != middle(start) {
            if middle(start) != 0.0 {
                let stop = |i: usize| stop(law, [around(i + cells.len() - 1) - TAU, around(i), around(i + 1)]);
                list.push(Motion { law: section.to_owned(), unit, ..motion(law, stop(start), stop(i)) });
            }
            start = i;
        }
    }
    if list.len() > MOST_MOTIONS { Vec::new() } else { list }
}

/// Where U′ vanishes between the middles of two neighbouring cells: at the border between them, or beside it.
fn stop(law: &MotionLaw, [before, border, behind]: [f64; 3]) -> f64 {
    let mut slope = |phi: f64| law.at(phi.rem_euclid(TAU)).0[1];
    let ends = [0.5 * (before + border), 0.5 * (border + behind)];
    let slopes = ends.map(&mut slope);
    if slope(border).abs() <= STANDING * law.bound(1) || slopes[0] * slopes[1] >= 0.0 {
        return border;
    }
    zero(&mut slope, ends, slopes, 0.0)
}

fn motion(law: &MotionLaw, from: f64, to: f64) -> Motion {
    let angle = to - from;
    // Just inside, where both ends have the derivatives of the motion, not of the dwell beside it.
    let at = |i: usize| law.at((from + angle * (i as f64 + 0.5) / SAMPLES as f64).rem_euclid(TAU)).0;
    let lift = law.at(to.rem_euclid(TAU)).0[0] - law.at(from.rem_euclid(TAU)).0[0];
    let most = |value: &dyn Fn([f64; 5]) -> f64| (0..SAMPLES).map(|i| value(at(i)).abs()).fold(0.0, f64::max);
    Motion {
        law: String::new(),
        unit: "m",
        from,
        angle,
        lift,
        velocity: most(&|u| u[1]) * angle / lift.abs(),
        acceleration: most(&|u| u[2]) * angle.powi(2) / lift.abs(),
        jerk: most(&|u| u[3]) * angle.powi(3) / lift.abs(),
        torque: most(&|u| u[1] * u[2]) * angle.powi(3) / (lift * lift),
    }
}

impl Overview {
    /// The motions of the law, and what of a plan is hardly meant.
    pub(super) fn motions(&mut self, section: &str, law: &MotionLaw, unit: &'static str) {
        self.motions.extend(motions(section, law, unit));
        if let MotionLaw::Plan(plan) = law {
            self.jumps(section, law, unit);
            self.overshoots(section, plan, law, unit);
        }
    }

    /// Warns where U″ jumps.
    fn jumps(&mut self, section: &str, law: &MotionLaw, unit: &str) {
        let unit = if unit == "rad" { "1/rad" } else { "m/rad2" };
        for &phi in law.breakpoints() {
            let [before, behind] = [false, true].map(|forward| law.at_in(law.segment(phi, forward), phi).0[2]);
            if (behind - before).abs() > NO_JUMP * law.bound(2) {
                let [at, jump] = [shown(phi, "rad"), shown(behind - before, unit)];
                self.warnings.push(Warning {
                    message: format!("{section}: U″ jumps by {jump} at {at}"),
                    hint: "leave out an inflection beside the point, or give ddU".to_owned(),
                });
            }
        }
    }

    /// Warns where U leaves the range of the points at both ends of a segment.
    fn overshoots(&mut self, section: &str, plan: &MotionPlan, law: &MotionLaw, unit: &str) {
        const PARTS: usize = 500;
        let points = plan.points();
        for (i, to) in points.iter().enumerate() {
            let from = points[(i + points.len() - 1) % points.len()];
            let start = if i == 0 { from.phi - TAU } else { from.phi };
            let at = |k: usize| law.at((start + (to.phi - start) * k as f64 / PARTS as f64).rem_euclid(TAU)).0[0];
            let (low, high) = (from.u.min(to.u), from.u.max(to.u));
            let beyond = (1..PARTS).map(|k| (at(k) - high).max(low - at(k))).fold(0.0, f64::max);
            if beyond > NO_JUMP * law.bound(0) {
                self.warnings.push(Warning {
                    message: format!(
                        "{section}: the motion overshoots on the way to point[{}], by {}",
                        i + 1,
                        shown(beyond, unit)
                    ),
                    hint: "give the segment another law, inflection or angle, or lower dU or ddU at its ends"
                        .to_owned(),
                });
            }
        }
    }
}
