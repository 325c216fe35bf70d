//! The linear equation at constant speed as one with periodic coefficients, and its table.

use super::equation::{Cam, Equation, Flow};
use super::solver::REACH;
use crate::drives::cam_drive::{CamDrive, DriveMode};
use crate::drives::cam_turn::CamTurn;
use crate::drives::step_control::RESERVE_OF_TABLE;
use crate::motion::MotionLaw;
use crate::numerics::angle;
use crate::numerics::divisor::greatest_common_divisor;
use crate::numerics::double_double::Double;
use crate::numerics::period_map::{Coefficients, PeriodMap, Periodic, spectral_radius};
use std::sync::Arc;

/// The equation tabulated over its period, and what it was tabulated for.
#[derive(Debug)]
pub struct Table {
    equation: Equation,
    law: Arc<MotionLaw>,
    mode: DriveMode,
    tolerance: f64,
    /// None where the equation is not linear, the speed not constant or the table too long.
    pub map: Option<PeriodMap>,
    /// The largest modulus of the Floquet multipliers over its period; 0 without a table.
    multiplier: f64,
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
        let multiplier = map.as_ref().map_or(0.0, |map| spectral_radius(&map.period_map().matrix));
        Table { equation, law, mode, tolerance, map, multiplier }
    }

    /// Estimated error after so many of its periods, relative to the motion.
    pub fn error_after(&self, periods: f64) -> f64 {
        let error = |map: &PeriodMap| map.whole().error_after(periods, RESERVE_OF_TABLE, self.multiplier);
        self.map.as_ref().map_or(0.0, error)
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
    cam: CamTurn<'a>,
    /// Into how many equal periods symmetry divides the turn.
    symmetry: usize,
}

impl<'a> Turn<'a> {
    /// None where the equation is not linear or the cam at rest.
    pub fn new(equation: Equation, law: &'a MotionLaw, w: f64, phi_start: f64) -> Option<Self> {
        let cam = CamTurn::new(law, w, phi_start)?;
        equation.linear.then(|| Turn { equation, law, w, cam, symmetry: symmetry(law) })
    }
}

impl Periodic for Turn<'_> {
    fn period(&self) -> Double {
        angle::WHOLE_TURN.divide(Double::from(self.symmetry as f64 * self.w.abs()))
    }

    fn joints(&self) -> Vec<Double> {
        let mut joints = self.cam.passages();
        joints.push(self.period());
        joints
    }

    fn at(&self, tau: Double, interval: usize) -> Coefficients {
        let phi = self.cam.angle(tau);
        let cam = Cam::at(self.law, self.cam.segment(interval), phi);
        let rest = Flow { phi, w: self.w, a: 0.0, q: 0.0, v: 0.0 };
        let [by_q, by_speed] = self.equation.jacobian(&cam, &rest);
        Coefficients { damping: -by_speed, stiffness: -by_q, forcing: self.equation.acceleration(&cam, &rest, 1.0) }
    }

    fn longest_cell(&self, _: Double, interval: usize) -> f64 {
        self.cam.time_for(REACH, interval)
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
