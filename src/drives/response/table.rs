//! A law of any kind at constant speed, tabulated over a turn: a step costs the same however long it is.

use crate::drives::cam_turn::CamTurn;
use crate::motion::MotionLaw;
use crate::numerics::angle;
use crate::numerics::double_double::Double;
use crate::numerics::oscillator::Oscillator;
use crate::numerics::period_map::{Coefficients, PeriodMap, Periodic};
use std::f64::consts::TAU;
use std::sync::Arc;

/// No table where the oscillator turns or decays by more than this in a turn of the cam (rad): cells of a few radians
/// each, a few microseconds to make and half a kilobyte long, then still are an instant's work and some 0.1 MB.
const FASTEST: f64 = 512.0;

/// A cell may hold two radians of the finest harmonic of the law; the oscillator shortens it as the tolerance demands.
const REACH: f64 = 2.0;

/// Map of the oscillator over a turn, and what it was tabulated for.
#[derive(Debug, PartialEq)]
pub struct Table {
    oscillator: Oscillator,
    law: Arc<MotionLaw>,
    w: f64,
    phi_start: f64,
    tolerance: f64,
    /// What roundings of angles and of U″ make of q in a turn (m).
    pub roundings: f64,
    /// None where there are too many cells.
    pub map: Option<PeriodMap>,
}

impl Table {
    /// The table of this oscillator behind a cam with this law that turns at `w` (rad/s) from `phi_start` (rad).
    pub fn new(oscillator: Oscillator, law: Arc<MotionLaw>, w: f64, phi_start: f64, tolerance: f64) -> Self {
        let map = CamTurn::new(law.breakpoints(), w, phi_start).and_then(|cam| {
            let (_, fast) = oscillator.rates();
            let few = fast * cam.period(1).hi <= FASTEST;
            few.then(|| PeriodMap::new(&Turn { oscillator, law: &law, w, phi_start, cam }, tolerance)).flatten()
        });
        // An error of q̇ turns into one of q while the cam turns by this (rad).
        let span = (w.abs() / oscillator.stiffness().sqrt()).min(TAU);
        let squares = (0..law.breakpoints().len()).map(|segment| law.bound_in(segment, 1).powi(2));
        // Four roundings shift a segment of the law, and four of U′ stay in q̇ behind it.
        let roundings = 2.0 * f64::EPSILON * (1.0 + span) * squares.sum::<f64>().sqrt();
        Table { oscillator, law, w, phi_start, tolerance, roundings, map }
    }

    /// Whether it is the table of these.
    pub fn is_for(
        &self,
        oscillator: &Oscillator,
        law: &Arc<MotionLaw>,
        w: f64,
        phi_start: f64,
        tolerance: f64,
    ) -> bool {
        let same = self.is_of(oscillator, w, phi_start) && self.tolerance == tolerance;
        same && (Arc::ptr_eq(&self.law, law) || self.law == *law)
    }

    /// Whether it is that of this oscillator and this motion of the cam, whose law has not changed.
    pub fn is_of(&self, oscillator: &Oscillator, w: f64, phi_start: f64) -> bool {
        self.oscillator == *oscillator && self.w == w && self.phi_start == phi_start
    }
}

struct Turn<'a> {
    oscillator: Oscillator,
    law: &'a MotionLaw,
    w: f64,
    phi_start: f64,
    cam: CamTurn<'a>,
}

impl Turn<'_> {
    /// U … U‴ at `tau` (s) in an interval, whose angle is not rounded.
    fn law_at(&self, tau: Double, interval: usize) -> [f64; 4] {
        let phi = angle::remainder(Double::from(self.phi_start) + Double::from(self.w) * tau);
        let u = self.law.at_in(self.cam.segment(interval), phi.hi).0;
        std::array::from_fn(|order| u[order] + u[order + 1] * phi.lo)
    }
}

/// q̈ + 2δ q̇ + ω₀² q = −U″ ω².
impl Periodic for Turn<'_> {
    fn period(&self) -> Double {
        self.cam.period(1)
    }

    fn joints(&self) -> Vec<Double> {
        self.cam.joints(self.period())
    }

    fn at(&self, tau: Double, interval: usize) -> Coefficients {
        let u = self.law_at(tau, interval);
        Coefficients {
            damping: 2.0 * self.oscillator.damping(),
            stiffness: self.oscillator.stiffness(),
            forcing: -u[2] * self.w * self.w,
        }
    }

    /// Absolutely, the mass has no jump: what q̈ gained by the roundings of the joint, q̇ gets back as the law's jump of U′ there.
    fn jump(&self, tau: Double, interval: usize) -> f64 {
        let next = if tau == self.period() { 0 } else { interval + 1 };
        let [before, after] = [interval, next].map(|interval| self.law_at(tau, interval));
        (before[1] - after[1]) * self.w
    }

    fn longest_cell(&self, _: Double, interval: usize) -> f64 {
        REACH / self.law.resolution_in(self.cam.segment(interval)).max(1.0) / self.w.abs()
    }

    /// Without a table the oscillator, whose coefficients are constant, is solved to the last digit.
    fn by_phase(&self) -> bool {
        false
    }
}
