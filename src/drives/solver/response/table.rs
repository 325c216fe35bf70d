//! A law of any kind at constant speed, tabulated over a turn: a step costs the same however long it is.

use crate::drives::follower::elastic_output::Equation;
use crate::drives::shaft::cam_turn::CamTurn;
use crate::drives::solver::step_control::ROUNDINGS;
use crate::motion::MotionLaw;
use crate::motion::derivatives::lift;
use crate::numerics::angle;
use crate::numerics::double_double::Double;
use crate::numerics::period_map::{Coefficients, PeriodMap, Periodic};
use std::f64::consts::TAU;
use std::sync::Arc;

/// No table if the oscillator turns or decays by more than this in a turn of the cam (rad). Below that the cells of a few radians
/// each, a few microseconds to make and half a kilobyte long, take little time and some 0.1 MB.
const FASTEST: f64 = 512.0;

/// A cell may hold two radians of the finest harmonic of the law; the oscillator shortens it as the tolerance demands.
const REACH: f64 = 2.0;

/// The arguments of the table: the equation of an oscillator on a cam with this law that turns at `w` (rad/s) from `phi_start`
/// (rad).
#[derive(Clone, Debug, PartialEq)]
pub struct Turn {
    pub equation: Equation,
    pub law: Arc<MotionLaw>,
    pub w: f64,
    pub phi_start: f64,
    pub tolerance: f64,
}

/// The equation over a turn.
#[derive(Debug, PartialEq)]
pub struct Table {
    /// The arguments of the table.
    pub turn: Turn,
    /// Effect of roundings of angles and of U″ on q in a turn (m).
    pub roundings: f64,
    /// None if there are too many cells.
    pub map: Option<PeriodMap>,
}

impl Table {
    /// The table of a turn.
    pub fn new(turn: Turn) -> Self {
        let (oscillator, law, w) = (&turn.equation.oscillator, &turn.law, turn.w);
        let map = CamTurn::new(law.breakpoints(), w, turn.phi_start).and_then(|cam| {
            let few = oscillator.rates().1 * cam.period(1).hi <= FASTEST;
            few.then(|| PeriodMap::new(&OnCam { turn: &turn, cam }, turn.tolerance)).flatten()
        });
        // An error of q̇ turns into one of q while the cam turns by this (rad).
        let span = (w.abs() / oscillator.stiffness().sqrt()).min(TAU);
        let squares = (0..law.breakpoints().len()).map(|segment| law.bound_in(segment, 1).powi(2));
        // Four roundings shift a segment of the law, and four roundings of U′ remain in q̇ after it.
        let [slope, curvature] = law.roundings().map(|rounding| ROUNDINGS * rounding * span.min(1.0));
        let of_points = slope + curvature * span.min(1.0);
        let of_angles = 2.0 * f64::EPSILON * (1.0 + span) * squares.sum::<f64>().sqrt();
        // The roundings of a force that acts for that long.
        let forces = (0..law.breakpoints().len()).map(|segment| {
            let [u, slope] = [0, 1].map(|order| law.bound_in(segment, order));
            turn.equation.bound([u, slope, 0.0], [w.abs(), 0.0]).powi(2)
        });
        let of_forces = 2.0 * f64::EPSILON * span * forces.sum::<f64>().sqrt() / (w * w);
        let roundings = turn.equation.of_acceleration().abs() * (of_angles + of_points) + of_forces;
        Table { turn, roundings, map }
    }
}

struct OnCam<'a> {
    turn: &'a Turn,
    cam: CamTurn<'a>,
}

impl OnCam<'_> {
    /// U … U‴ at `tau` (s) in an interval, with an unrounded angle.
    fn law_at(&self, tau: Double, interval: usize) -> [f64; 4] {
        let Turn { law, w, phi_start, .. } = self.turn;
        let phi = angle::remainder(Double::from(*phi_start) + Double::from(*w) * tau);
        let u = law.at_in(self.cam.segment(interval), phi.hi).0;
        std::array::from_fn(|order| u[order] + u[order + 1] * phi.lo)
    }
}

impl Periodic for OnCam<'_> {
    fn period(&self) -> Double {
        self.cam.period(1)
    }

    fn joints(&self) -> Vec<Double> {
        self.cam.joints(self.period())
    }

    fn at(&self, tau: Double, interval: usize) -> Coefficients {
        let [u, slope, curvature, _] = self.law_at(tau, interval);
        let Turn { equation, w, .. } = self.turn;
        Coefficients {
            damping: 2.0 * equation.oscillator.damping(),
            stiffness: equation.oscillator.stiffness(),
            forcing: equation.forcing(lift([u, slope, curvature], [*w, 0.0])),
        }
    }

    /// In absolute coordinates the mass does not jump: q̇ loses at the law's jump of U′ what q̈ gained by the roundings of the
    /// joint.
    fn jump(&self, tau: Double, interval: usize) -> f64 {
        let next = if tau == self.period() { 0 } else { interval + 1 };
        let [before, after] = [interval, next].map(|interval| self.law_at(tau, interval));
        self.turn.equation.of_acceleration() * (after[1] - before[1]) * self.turn.w
    }

    fn longest_cell(&self, _: Double, interval: usize) -> f64 {
        REACH / self.turn.law.resolution_in(self.cam.segment(interval)).max(1.0) / self.turn.w.abs()
    }

    /// Without a table the oscillator, whose coefficients are constant, is solved to the last digit.
    fn by_phase(&self) -> bool {
        false
    }
}
