//! The flank of a cam on a prescribed shaft: u(t) = U(φ(t)).

use super::angle_series::AngleSeries;
use super::cam_drive::AngleMotion;
use super::passage::first_end;
use crate::drives::follower::flank::{EXPANSION, FlankMotion};
use crate::motion::{Kinematics, MotionLaw};
use crate::numerics::double_double::Double;
use std::f64::consts::TAU;

/// The number of evaluations of the law for its derivatives.
const DERIVATIVES: f64 = 5.0;
/// Cost of the composition with a motion per degree of the motion (nominal µs).
const COMPOSITION: f64 = 0.5;
/// The number of points at which U′ is then integrated.
const POINTS: f64 = 12.0;
/// Cost of the angle at one of them (nominal µs).
const ANGLE: f64 = 0.05;

/// The flank of a cam on its shaft.
pub struct CamFlank<'a> {
    /// U(φ).
    pub law: &'a MotionLaw,
    /// φ(t).
    pub motion: &'a AngleMotion,
    /// Bounds of |U|, |U′| and |U″|.
    pub bounds: [f64; 3],
}

/// The most coefficients of a series.
const MOST_COEFFICIENTS: usize = 32;

impl CamFlank<'_> {
    /// φ̇, φ̈, … at `time`; the entry 0 is unused.
    fn derivatives<const N: usize>(&self, time: Double) -> [f64; N] {
        self.motion.derivatives((time - Double::from(self.motion.origin)).hi)
    }

    fn reduced(&self, time: Double) -> f64 {
        self.motion.at_instant(time).reduced
    }
}

impl FlankMotion for CamFlank<'_> {
    fn at(&self, segment: usize, time: Double) -> Kinematics {
        let shaft = self.motion.at_instant(time);
        self.law.at_in(segment, shaft.reduced).along(&shaft.kinematics)
    }

    fn slope(&self, segment: usize, time: Double) -> f64 {
        self.law.at_in(segment, self.reduced(time)).0[1]
    }

    fn expand(&self, segment: usize, time: Double, span: f64, coefficients: &mut [f64]) {
        let phi = self.reduced(time);
        let w = self.motion.coefficients[1];
        if self.motion.is_uniform() {
            self.law.expand(segment, phi, w * span, coefficients);
            return;
        }
        // Inserts the motion into the series of U by Horner's rule.
        let (a, degree) = (AngleSeries::of(self.motion, time).scaled(span), self.motion.degree);
        let count = coefficients.len();
        let mut law = [0.0; MOST_COEFFICIENTS];
        self.law.expand(segment, phi, 1.0, &mut law[..count]);
        coefficients.fill(0.0);
        for &c in law[..count].iter().rev() {
            for n in (0..count).rev() {
                coefficients[n] = (1..=degree.min(n)).map(|j| a[j] * coefficients[n - j]).sum();
            }
            coefficients[0] += c;
        }
    }

    fn cost(&self) -> f64 {
        let law = self.law.cost();
        let composed = COMPOSITION * self.motion.degree as f64 + POINTS * (ANGLE + law);
        EXPANSION + DERIVATIVES * law + if self.motion.is_uniform() { 0.0 } else { composed }
    }

    fn describe(&self, way: [f64; 2]) -> String {
        self.motion.describe("the cam", way)
    }

    fn is_uniform(&self) -> bool {
        self.motion.is_uniform()
    }

    fn speed(&self) -> f64 {
        self.motion.coefficients[1]
    }

    fn sizes(&self, time: f64) -> [f64; 2] {
        let [_, w] = self.derivatives(Double::from(time));
        [self.bounds[0], self.bounds[1] * w.abs()]
    }

    fn roundings(&self) -> f64 {
        let [slope, curvature] = self.law.roundings();
        let part = |rounding: f64, bound: f64| rounding / bound.max(f64::MIN_POSITIVE);
        1.0 + part(slope, self.bounds[1]).max(part(curvature, self.bounds[2])) / f64::EPSILON
    }

    fn acceleration(&self, segment: usize, time: Double) -> f64 {
        let [_, w, a] = self.derivatives(time);
        let [_, mut slope, mut curvature] = self.bounds;
        if !self.law.breakpoints().is_empty() && self.law.bound_in(segment, 2) > 0.0 {
            [slope, curvature] = [1, 2].map(|order| self.law.bound_in(segment, order));
        }
        curvature * w * w + slope * a.abs()
    }

    fn rate(&self, segment: usize, time: Double) -> f64 {
        let [_, w] = self.derivatives(time);
        self.law.resolution_in(segment) * w.abs()
    }

    fn segment(&self, time: Double) -> usize {
        let course = AngleSeries::of(self.motion, time);
        self.law.segment(course.angle[0], course.forward())
    }

    fn stay(&self, segment: usize, time: Double, longest: f64) -> (f64, usize) {
        let breakpoints = self.law.breakpoints();
        let count = breakpoints.len();
        if count == 0 {
            return (longest, 0);
        }
        let (start, next) = (breakpoints[segment], breakpoints[(segment + 1) % count]);
        let width = if count == 1 { TAU } else { (next - start).rem_euclid(TAU) };
        let course = AngleSeries::of(self.motion, time);
        let mut below = (course.angle[0] - start).rem_euclid(TAU);
        // A start within a rounding before the segment must not count as almost a turn after it.
        if below > 0.5 * (width + TAU) {
            below = 0.0;
        }
        let passed = first_end([below, width - below], count == 1, &course.scaled(longest), 0.0);
        match passed.map(|(at, up)| (at * longest, up)).filter(|(at, _)| *at < longest) {
            Some((at, up)) => (at, (segment + if up { 1 } else { count - 1 }) % count),
            None => (longest, segment),
        }
    }
}
