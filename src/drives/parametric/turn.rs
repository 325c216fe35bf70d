//! The equation at constant speed as one with periodic coefficients: its table, its growth, its periodic solution.

use super::coefficients::{Coefficients, Values};
use super::law::Law;
use crate::drives::cam_drive::{CamDrive, DriveMode};
use crate::drives::cam_turn::turns;
use crate::drives::limits::refused_start;
use crate::drives::step_control::RESERVE_OF_TABLE;
use crate::drives::{Fault, Number, Rounded};
use crate::numerics::angle;
use crate::numerics::double_double::Double;
use crate::numerics::period_map::{self, Period, PeriodMap, Periodic};
use crate::numerics::work::{EVALUATION, Work, draw};
use std::cell::Cell;
use std::sync::Arc;

/// The equation tabulated over its period, and what it was tabulated for.
#[derive(Debug)]
pub struct Table {
    law: Arc<Law>,
    mode: DriveMode,
    tolerance: f64,
    /// None where the speed is not constant, zero, or the table too long.
    pub map: Option<PeriodMap>,
    /// The period as a whole; None where it cannot be computed either.
    whole: Option<Period>,
    /// ln of the largest modulus of the multipliers over a turn; 0 where the drive does not turn at constant speed.
    pub growth: f64,
    /// Over a period.
    growth_of_period: f64,
}

impl Table {
    /// Tabulates the equation for this drive to the relative `tolerance`.
    pub fn new(coefficients: &Coefficients, drive: &CamDrive<Law>, tolerance: f64) -> Self {
        let (law, mode) = (drive.law.clone(), drive.mode.clone());
        let mut table = Table { law, mode, tolerance, map: None, whole: None, growth: 0.0, growth_of_period: 0.0 };
        let DriveMode::Constant { w, phi_start } = table.mode else { return table };
        if !turns(w) {
            return table;
        }
        let symmetry = coefficients.symmetry() as f64;
        let work = &Cell::new(Work::default());
        let turn = Turn { coefficients, w, phi_start, symmetry, work };
        table.map = PeriodMap::new(&turn, tolerance);
        table.whole = table.map.as_ref().map(|map| *map.whole()).or_else(|| Period::of(&turn, tolerance));
        table.growth_of_period =
            table.whole.as_ref().map_or_else(|| turn.slow_growth(), |whole| whole.monodromy.growth());
        table.growth = symmetry * table.growth_of_period;
        table
    }

    /// Whether it is the table of this drive and this tolerance.
    pub fn is_for(&self, drive: &CamDrive<Law>, tolerance: f64) -> bool {
        let same = self.mode == drive.mode && self.tolerance == tolerance;
        same && (Arc::ptr_eq(&self.law, &drive.law) || self.law == drive.law)
    }

    /// Estimated error after `periods`, relative to the motion.
    pub fn error_after(&self, periods: f64) -> f64 {
        let multiplier = self.growth_of_period.exp();
        self.whole.as_ref().map_or(0.0, |whole| whole.error_after(periods, RESERVE_OF_TABLE, multiplier))
    }

    /// (q, q̇) of the periodic solution at the start of the turn; refused where it does not exist or does not attract.
    pub fn periodic(&self, coefficients: &Coefficients) -> Result<[f64; 2], Fault> {
        let DriveMode::Constant { w, phi_start } = self.mode else {
            return Err(refused_start(
                "start.mode = steady_state needs a constant speed; this drive follows its inputs: set start.mode = \
                 at_rest or given",
            ));
        };
        if !turns(w) {
            return at_rest(w, &coefficients.at(angle::reduce(Double::from(phi_start))));
        }
        let unstable = |why: String| {
            refused_start(format!(
                "start.mode = steady_state is refused at drive.w = {} rad/s: {why}; change drive.w, raise the damping, \
                 or set start.mode = at_rest",
                Number(w)
            ))
        };
        if self.growth > 0.0 {
            return Err(unstable(format!(
                "the periodic solution is unstable, free vibrations grow by exp({}) in a turn",
                Rounded(self.growth)
            )));
        }
        if self.growth == 0.0 {
            return Err(unstable("without damping free vibrations never die out".to_owned()));
        }
        let fixed = |whole: &Period| period_map::fixed_point(&whole.map.matrix, [0.0; 2], whole.map.shift);
        self.whole.as_ref().and_then(fixed).ok_or_else(|| {
            unstable("its period has too many vibrations or harmonics for the work of one call".to_owned())
        })
    }
}

/// The equilibrium q = f/c of a drive at rest.
fn at_rest(w: f64, &Values { b, c, f, .. }: &Values) -> Result<[f64; 2], Fault> {
    if b[0] > 0.0 && c[0] > 0.0 {
        return Ok([f[0] / c[0], 0.0]);
    }
    Err(refused_start(format!(
        "start.mode = steady_state is refused at drive.w = {} rad/s: with a stiffness of {} and a damping of {} at \
         drive.phi_start no motion comes to rest; both must be above 0",
        Number(w),
        Number(c[0]),
        Number(b[0])
    )))
}

/// A period of the coefficients from `phi_start` at constant speed.
struct Turn<'a> {
    coefficients: &'a Coefficients,
    w: f64,
    phi_start: f64,
    /// Into how many equal periods symmetry divides the turn.
    symmetry: f64,
    /// Work that the call has left.
    work: &'a Cell<Work>,
}

impl Turn<'_> {
    /// ln of the largest modulus of the multipliers where the coefficients hardly change over a vibration or its decay: the
    /// integral of the larger real part of the roots of λ² + d λ + k. Tongues that it misses are narrower than any number
    /// tells.
    fn slow_growth(&self) -> f64 {
        // Equal places are exact for all harmonics below their number, far beyond those that a scene takes.
        const PLACES: u32 = 4096;
        let period = self.period();
        let rate = |i: u32| {
            let c = self.at(period * Double::from(f64::from(i) / f64::from(PLACES)), 0);
            let half = 0.5 * c.damping;
            let root = (half * half - c.stiffness).max(0.0).sqrt();
            // −k/(half + root), without cancellation.
            if half > 0.0 && root > 0.0 { -c.stiffness / (half + root) } else { root - half }
        };
        (0..PLACES).map(rate).sum::<f64>() * period.hi / f64::from(PLACES)
    }

    fn angle(&self, tau: Double) -> f64 {
        angle::reduce(Double::from(self.phi_start) + Double::from(self.w) * tau)
    }
}

impl Periodic for Turn<'_> {
    fn period(&self) -> Double {
        angle::WHOLE_TURN.divide(Double::from(self.symmetry * self.w.abs()))
    }

    fn joints(&self) -> Vec<Double> {
        vec![self.period()]
    }

    fn at(&self, tau: Double, _: usize) -> period_map::Coefficients {
        let Values { m, b, c, f } = self.coefficients.at(self.angle(tau));
        period_map::Coefficients { damping: b[0] / m[0], stiffness: c[0] / m[0], forcing: f[0] / m[0] }
    }

    fn longest_cell(&self, tau: Double, _: usize) -> f64 {
        self.coefficients.reach(self.angle(tau)) / self.w.abs()
    }

    fn draw(&self, evaluations: usize) -> Option<()> {
        draw(Some(self.work), evaluations as f64 * (EVALUATION + self.coefficients.cost()))
    }
}
