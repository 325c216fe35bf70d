//! The instant at which the cam leaves a segment of its law.
//!
//! The motion of the cam over a step is a polynomial, φ of the drive plus q of the collocation: its certified first root shows
//! every exit from the segment, however brief.

use crate::drives::follower::flow::Flow;
use crate::drives::shaft::cam_drive::AngleMotion;
use crate::drives::shaft::passage::exit;
use crate::numerics::angle;
use crate::numerics::collocation::Collocation;
use crate::numerics::double_double::{Double, two_sum};
use std::f64::consts::TAU;

/// Coefficients of this polynomial: φ is of degree 10 at most, q of less.
const COEFFICIENTS: usize = 11;

/// The position of the cam in its segment at the start of a step.
pub struct Place {
    /// The angle from the start of the segment (rad).
    offset: f64,
    /// The length of the segment (rad).
    span: f64,
    /// The time (s).
    start: Double,
    /// φ, reduced (rad), and q (rad).
    phi: f64,
    q: f64,
    /// Whether the law is taken at φ + q instead of φ.
    carried: bool,
}

/// The cam leaves its segment.
#[derive(Clone, Copy)]
pub struct Exit {
    /// The time (s).
    pub time: Double,
    /// Whether it leaves at the end of the segment.
    pub forward: bool,
}

impl Place {
    /// The cam in a segment between the `breakpoints` in the state `f` at `start`.
    pub fn new((breakpoints, segment): (&[f64], usize), start: Double, f: &Flow<f64>, carried: bool) -> Self {
        let lower = breakpoints[segment];
        let upper = breakpoints.get(segment + 1).copied().unwrap_or(breakpoints[0] + TAU);
        let span = upper - lower;
        // Nearest to the middle: a cam slightly before the segment must not count as almost a turn after it.
        let offset = 0.5 * span + angle::reduce(two_sum(f.argument(carried), -0.5 * (lower + upper)));
        Place { offset, span, start, phi: f.phi, q: f.q, carried }
    }

    /// The exit from the segment in the last step of `integrator`, on this `motion` of the drive.
    pub fn exit(&self, motion: &AngleMotion, integrator: &Collocation<2>) -> Option<Exit> {
        let length = (integrator.end() - self.start).hi;
        let mut way = growth(motion, self.start, length);
        if self.carried {
            for (way, twisting) in way.iter_mut().zip(integrator.growth(0)) {
                *way += twisting;
            }
        }
        way[0] = self.offset;
        let (theta, forward) = exit(&way, (0.0, self.span))?;
        Some(Exit { time: self.start + Double::from(theta * length), forward })
    }

    /// The time (s) by which a step to the breakpoint, which ended in the state `f`, ended too late: the polynomial of the longer
    /// step locates the breakpoint only to the accuracy of polynomials.
    pub fn delay(&self, f: &Flow<f64>, forward: bool) -> f64 {
        self.beyond(f, forward) / f.turning(self.carried)
    }

    /// The angle (rad) from the breakpoint to the state `f`.
    pub fn beyond(&self, f: &Flow<f64>, forward: bool) -> f64 {
        // Less than half a turn per step, so the difference of reduced angles shows the direction.
        let turned = angle::reduce(two_sum(f.phi, -self.phi)) + if self.carried { f.q - self.q } else { 0.0 };
        self.offset + turned - if forward { self.span } else { 0.0 }
    }
}

/// The coefficients of θʲ, j ≥ 1, of φ over a step of `length` from `start`.
fn growth(motion: &AngleMotion, start: Double, length: f64) -> [f64; COEFFICIENTS] {
    let tau = (start - Double::from(motion.origin)).hi;
    let mut growth = [0.0; COEFFICIENTS];
    let mut power = 1.0;
    for order in 1..=motion.degree {
        power *= length / order as f64;
        let mut derivative = 0.0;
        for j in (order..=motion.degree).rev() {
            derivative = motion.coefficients[j] + derivative * tau / (j + 1 - order) as f64;
        }
        growth[order] = derivative * power;
    }
    growth
}
