//! A linear equation at constant speed as one with periodic coefficients: its table and its growth.

use crate::drives::follower::equation::{Equation, Segments};
use crate::drives::follower::flow::Flow;
use crate::drives::shaft::cam_drive::{CamDrive, DriveMode};
use crate::drives::shaft::cam_turn::{CamTurn, SLACK};
use crate::drives::solver::step_control::RESERVE_OF_TABLE;
use crate::numerics::double_double::Double;
use crate::numerics::period_map::{Coefficients, Period, PeriodMap, Periodic};
use crate::numerics::work::{EVALUATION, Work, draw};
use std::cell::Cell;
use std::sync::Arc;

/// The equation tabulated over its period, and the arguments of the table.
#[derive(Debug)]
pub struct Table<E: Equation> {
    equation: E,
    law: Arc<E::Law>,
    mode: DriveMode,
    tolerance: f64,
    /// None if the equation is not linear, the speed not constant or zero, or the table too long.
    pub map: Option<PeriodMap>,
    /// The period as a whole; None where it cannot be computed either.
    pub whole: Option<Period>,
    /// ln of the largest modulus of the multipliers over a turn; 0 without a period.
    pub growth: f64,
    /// The same over a period.
    growth_of_period: f64,
}

impl<E: Equation> Table<E> {
    /// Tabulates the equation for this drive to the relative `tolerance`.
    pub fn new(equation: E, drive: &CamDrive<E::Law>, tolerance: f64) -> Self {
        let (law, mode) = (drive.law.clone(), drive.mode.clone());
        let (map, whole) = (None, None);
        let mut table = Table { equation, law, mode, tolerance, map, whole, growth: 0.0, growth_of_period: 0.0 };
        if let DriveMode::Constant { w, phi_start } = table.mode
            && table.equation.is_linear()
            && !table.equation.has_input()
            && let Some(turn) = Turn::new(&table.equation, &table.law, w, phi_start)
        {
            table.map = PeriodMap::new(&turn, tolerance);
            table.whole = table.map.as_ref().map(|map| *map.whole()).or_else(|| Period::of(&turn, tolerance));
            table.growth_of_period =
                table.whole.as_ref().map_or_else(|| turn.slow_growth(), |whole| whole.monodromy.growth());
            table.growth = turn.symmetry as f64 * table.growth_of_period;
        }
        table
    }

    /// Whether it is the table of this equation, this drive and this tolerance.
    pub fn is_for(&self, equation: &E, drive: &CamDrive<E::Law>, tolerance: f64) -> bool {
        let same = self.equation == *equation && self.mode == drive.mode && self.tolerance == tolerance;
        same && (Arc::ptr_eq(&self.law, &drive.law) || self.law == drive.law)
    }

    /// Estimated error after `periods`, relative to the motion.
    pub fn error_after(&self, periods: f64) -> f64 {
        let multiplier = self.growth_of_period.exp();
        self.whole.as_ref().map_or(0.0, |whole| whole.error_after(periods, RESERVE_OF_TABLE, multiplier))
    }
}

/// A period of a linear equation from `phi_start` (rad) at the constant speed `w` (rad/s).
pub struct Turn<'a, E: Equation> {
    equation: &'a E,
    law: &'a E::Law,
    w: f64,
    cam: CamTurn<'a>,
    /// The process force, if it has breakpoints.
    other: Option<CamTurn<'a>>,
    /// The segments in each interval between the joints.
    segments: Vec<Segments>,
    /// The number of equal periods into which symmetry divides the turn.
    symmetry: usize,
    /// The remaining work of the call.
    work: Cell<Work>,
}

impl<'a, E: Equation> Turn<'a, E> {
    /// None if the shaft is at rest.
    pub fn new(equation: &'a E, law: &'a E::Law, w: f64, phi_start: f64) -> Option<Self> {
        let [own, others] = equation.breakpoints(law).map(|list| CamTurn::new(list, w, phi_start));
        let (cam, symmetry) = (own?, equation.symmetry(law));
        let other = others.filter(|_| !equation.breakpoints(law)[1].is_empty());
        let mut turn = Turn { equation, law, w, cam, other, segments: Vec::new(), symmetry, work: Cell::default() };
        turn.segments = turn.intervals().into_iter().map(|(_, segments)| segments).collect();
        Some(turn)
    }

    /// The ends of the intervals, and the segments in each.
    fn intervals(&self) -> Vec<(Double, Segments)> {
        let (own, end) = (self.cam.joints(self.period()), self.period());
        let others = self.other.as_ref().map_or(vec![end], |other| other.joints(end));
        let (mut list, mut at) = (Vec::new(), [0; 2]);
        while let [Some(a), Some(b)] = [own.get(at[0]), others.get(at[1])] {
            let segments = [self.cam.segment(at[0]), self.other.as_ref().map_or(0, |other| other.segment(at[1]))];
            list.push((if (*a - *b).hi <= 0.0 { *a } else { *b }, segments));
            // Closer joints are merged: an interval between them would be lost in rounding.
            let ahead = (*a - *b).hi * self.w.abs();
            at = [at[0] + usize::from(ahead <= SLACK), at[1] + usize::from(ahead >= -SLACK)];
        }
        list
    }

    /// The segments in the interval of this number, which may be the first of the next turn.
    fn within(&self, interval: usize) -> Segments {
        self.segments[interval % self.segments.len()]
    }

    /// ln of the largest modulus of the multipliers if the coefficients hardly change over a vibration or its decay: the integral
    /// of the larger real part of the roots of λ² + d λ + k. It misses only tongues that are narrower than numbers resolve.
    fn slow_growth(&self) -> f64 {
        // Equal places are exact for all harmonics below their number, far beyond those of a scene.
        const PLACES: u32 = 4096;
        let (period, joints) = (self.period(), self.joints());
        let rate = |i: u32| {
            let tau = period * Double::from(f64::from(i) / f64::from(PLACES));
            let c = self.at(tau, joints.partition_point(|joint| (*joint - tau).hi <= 0.0));
            let half = 0.5 * c.damping;
            let root = (half * half - c.stiffness).max(0.0).sqrt();
            // −k/(half + root), without cancellation.
            if half > 0.0 && root > 0.0 { -c.stiffness / (half + root) } else { root - half }
        };
        (0..PLACES).map(rate).sum::<f64>() * period.hi / f64::from(PLACES)
    }
}

impl<E: Equation> Periodic for Turn<'_, E> {
    fn period(&self) -> Double {
        self.cam.period(self.symmetry)
    }

    fn joints(&self) -> Vec<Double> {
        self.intervals().into_iter().map(|(joint, _)| joint).collect()
    }

    fn at(&self, tau: Double, interval: usize) -> Coefficients {
        let rest = Flow { phi: self.cam.angle(tau), w: self.w, a: 0.0, q: 0.0, v: 0.0, force: 0.0 };
        let local = self.equation.at(self.law, self.within(interval), &rest);
        let [by_q, by_speed] = self.equation.jacobian(&local, &rest);
        Coefficients { damping: -by_speed, stiffness: -by_q, forcing: self.equation.acceleration(&local, &rest) }
    }

    fn longest_cell(&self, tau: Double, interval: usize) -> f64 {
        self.equation.reach(self.law, self.within(interval), self.cam.angle(tau)) / self.w.abs()
    }

    fn draw(&self, evaluations: usize) -> Option<()> {
        draw(Some(&self.work), evaluations as f64 * (EVALUATION + self.equation.cost(self.law)))
    }
}
