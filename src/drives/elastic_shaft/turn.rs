//! The linear equation at constant speed as one with periodic coefficients, and its table.

use super::equation::{Cam, Equation, Flow};
use super::solver::REACH;
use crate::drives::cam_drive::{CamDrive, DriveMode};
use crate::motion::MotionLaw;
use crate::numerics::angle;
use crate::numerics::double_double::Double;
use crate::numerics::period_map::{Coefficients, PeriodMap, Periodic};
use std::f64::consts::TAU;
use std::sync::Arc;

/// 2π in double-double.
pub const TURN: Double = Double { hi: TAU, lo: 2.449_293_598_294_706_4e-16 };

/// A breakpoint this near the start of the turn counts as lying there [rad]: more than the rounding of an angle.
const SLACK: f64 = 1e-12;

/// The equation tabulated over its period, and what it was tabulated for.
#[derive(Debug)]
pub struct Table {
    equation: Equation,
    law: Arc<MotionLaw>,
    mode: DriveMode,
    tolerance: f64,
    /// None where the equation is not linear, the speed not constant or the table too long.
    pub map: Option<PeriodMap>,
}

impl Table {
    /// Tabulates the equation for this cam to the relative `tolerance`.
    pub fn new(equation: Equation, cam: &CamDrive, tolerance: f64) -> Self {
        let (law, mode) = (cam.law.clone(), cam.mode.clone());
        let map = match mode {
            DriveMode::Constant { w, phi_start } => {
                Turn::new(equation, &law, w, phi_start).and_then(|turn| PeriodMap::new(&turn, tolerance))
            }
            DriveMode::Input => None,
        };
        Table { equation, law, mode, tolerance, map }
    }

    /// Whether it is the table of this equation, this cam and this tolerance.
    pub fn is_for(&self, equation: Equation, cam: &CamDrive, tolerance: f64) -> bool {
        let same = self.equation == equation && self.mode == cam.mode && self.tolerance == tolerance;
        same && (Arc::ptr_eq(&self.law, &cam.law) || self.law == cam.law)
    }
}

/// A turn of the cam from `phi_start` at constant speed.
pub struct Turn<'a> {
    equation: Equation,
    law: &'a MotionLaw,
    w: f64,
    phi_start: f64,
    /// Into how many equal periods symmetry divides the turn.
    symmetry: usize,
    /// The segment of the law with which the turn starts.
    segment: usize,
}

impl<'a> Turn<'a> {
    /// None where the equation is not linear or the cam at rest.
    pub fn new(equation: Equation, law: &'a MotionLaw, w: f64, phi_start: f64) -> Option<Self> {
        if !equation.linear || w == 0.0 {
            return None;
        }
        let start = angle::reduce(Double::from(phi_start));
        let segment = law.segment(start + SLACK * w.signum(), 0.0 < w);
        Some(Turn { equation, law, w, phi_start, symmetry: symmetry(law), segment })
    }

    fn segment(&self, interval: usize) -> usize {
        let count = self.law.breakpoints().len().max(1);
        if 0.0 < self.w { (self.segment + interval) % count } else { (self.segment + count - interval % count) % count }
    }
}

impl Periodic for Turn<'_> {
    fn period(&self) -> Double {
        TURN.divide(Double::from(self.symmetry as f64 * self.w.abs()))
    }

    fn joints(&self) -> Vec<Double> {
        let start = angle::reduce(Double::from(self.phi_start));
        let way = |breakpoint: &f64| ((breakpoint - start) * self.w.signum()).rem_euclid(TAU);
        let inside = |way: &f64| SLACK < *way && *way < TAU - SLACK;
        let mut ways: Vec<f64> = self.law.breakpoints().iter().map(way).filter(inside).collect();
        ways.sort_by(f64::total_cmp);
        let mut joints: Vec<Double> = ways.into_iter().map(|way| Double::from(way / self.w.abs())).collect();
        joints.push(self.period());
        joints
    }

    fn at(&self, tau: Double, interval: usize) -> Coefficients {
        let phi = angle::reduce(Double::from(self.phi_start) + Double::from(self.w) * tau);
        let cam = Cam::at(self.law, self.segment(interval), phi);
        let rest = Flow { phi, w: self.w, a: 0.0, q: 0.0, v: 0.0 };
        let [by_q, by_speed] = self.equation.jacobian(&cam, &rest);
        Coefficients { damping: -by_speed, stiffness: -by_q, forcing: self.equation.acceleration(&cam, &rest, 1.0) }
    }

    fn longest_cell(&self, interval: usize) -> f64 {
        REACH / self.law.resolution_in(self.segment(interval)).max(1.0) / self.w.abs()
    }
}

/// The number of equal parts of a turn after which U′², U′U″ and U″² + U′U‴ repeat themselves: their harmonics are
/// the sums and differences of those of U, all of which are multiples of the greatest common divisor of 2 k₁ and
/// k − k₁. Two for a law with odd harmonics alone.
fn symmetry(law: &MotionLaw) -> usize {
    let Some(series) = law.series() else { return 1 };
    let mut orders = (1..=series.order()).filter(|&k| series.a[k] != 0.0 || series.b[k] != 0.0);
    let Some(first) = orders.next() else { return 1 };
    orders.fold(2 * first, |divisor, k| greatest_common_divisor(divisor, k - first))
}

fn greatest_common_divisor(a: usize, b: usize) -> usize {
    if b == 0 { a } else { greatest_common_divisor(b, a % b) }
}
