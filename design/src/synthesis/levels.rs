//! Tasks with an end in sight: how large an objective must be that an integral of errors keeps its limit, how long dwells
//! can be and how few harmonics suffice for a largest error.
//!
//! Each is one zero of a level that rises or falls with a number: the least integral under |U″| ≤ t falls with t, the
//! integral of the profile with the least ∫e² + λ ∫U″² rises with λ, the Chebyshev level with the width of the dwells
//! (which are nested), and it falls with the harmonics. All bounds and points hold on the way.
//!
//! Source: Dresig, Vulfson, *Dynamik der Mechanismen*, section 4.6.3, equations (3) and (4).

use super::deviation::peak;
use super::family::Family;
use super::semi_infinite::Goal;
use super::{Infeasible, Objective, Optimum, Range, Task, Told, square};
use crate::search::zero;
use crate::text::number;
use camdrive::numerics::double_double::Double;
use std::f64::consts::TAU;

/// A peak is raised by this part of the least one where nothing else is prescribed, so that the program has room.
const ROOM: f64 = 1e-9;

/// ln λ of a weight of the acceleration beside which the errors do not count; its negative where only they do.
const HEAVIEST: f64 = 60.0;

/// The dwells that are tried first are wider or narrower by this factor each.
const GROWTH: f64 = 1.25;

/// Dwells narrower than this part of what the task says are none.
const NARROWEST: f64 = 1e-3;

/// ln of a level that does not exist: far above any.
const NONE: f64 = 700.0;

/// ln of a level over its limit.
fn over(level: f64, limit: f64) -> f64 {
    (level.max(f64::MIN_POSITIVE) / limit).ln()
}

/// The conditions with a level that is known.
pub fn capped(mut families: Vec<Family>, level: f64) -> Vec<Family> {
    for family in families.iter_mut().filter(|family| family.level != 0.0) {
        (family.limit, family.level) = (family.limit + family.level * level, 0.0);
    }
    families
}

impl Task {
    /// The least objective with the integral of the squared errors within its limit, in units of `scale`.
    pub(super) fn within_integral(&self, scale: f64) -> Result<Optimum, Infeasible> {
        let limit = self.integral.unwrap_or(f64::INFINITY) / (scale * scale);
        let errors = self.squares(&self.ranges, self.weights, scale);
        let missed = |found: &Optimum| square(&errors.0, &errors.1, &found.best.x);
        let of_peak = self.objective == Objective::PeakAcceleration;
        let at = |level: f64| if of_peak { self.below_peak(level, scale) } else { self.weighed(level.exp(), scale) };
        let nearest = if of_peak { self.below_peak(f64::INFINITY, scale)? } else { self.weighed(0.0, scale)? };
        if missed(&nearest) > limit {
            return Err(Infeasible::Integral { least: missed(&nearest) * scale * scale });
        }
        let ends = match of_peak {
            true => [self.optimum(scale, Vec::new())?.objective / scale * (1.0 + ROOM), self.sum_of_peaks(&nearest)],
            false => [HEAVIEST, -HEAVIEST],
        };
        let mut excess = |level: f64| at(level).map_or(NONE, |found| over(missed(&found), limit));
        let values = ends.map(&mut excess);
        let level = match values {
            [first, _] if first <= 0.0 => ends[0],
            [_, last] if last >= 0.0 => ends[1],
            _ => zero(&mut excess, ends, values, 1e-15 * ends[1].abs()),
        };
        let found = at(level)?;
        let (a, b) = self.accelerations(scale);
        let objective = if of_peak { level * scale } else { square(&a, &b, &found.best.x) * scale * scale };
        Ok(Optimum { objective, ..found })
    }

    /// The least integral of the squared errors with a sum of peaks of at most `level`.
    fn below_peak(&self, level: f64, scale: f64) -> Result<Optimum, Infeasible> {
        let mut families = self.families(scale);
        families.retain(|family| family.level == 0.0 || level.is_finite());
        let families = capped(families, level);
        let errors = self.squares(&self.ranges, self.weights, scale);
        self.optimum_of(scale, &self.equalities(scale)?, families, Goal::Squares(errors.0.clone()), errors)
    }

    /// The least integral of the squared errors and of `weight` times the squared acceleration.
    fn weighed(&self, weight: f64, scale: f64) -> Result<Optimum, Infeasible> {
        let (mut a, mut b) = self.squares(&self.ranges, self.weights, scale);
        let (rows, values) = self.accelerations(scale);
        let root = Double::from(weight.sqrt());
        a.extend(rows.iter().map(|row| row.iter().map(|v| *v * root).collect()));
        b.extend(values.iter().map(|v| *v * root));
        self.optimum_of(scale, &self.equalities(scale)?, self.families(scale), Goal::Squares(a.clone()), (a, b))
    }

    /// Σ wⱼ max |Uⱼ″|.
    fn sum_of_peaks(&self, found: &Optimum) -> f64 {
        let of = |law: usize| peak(&self.basis.series(law, &found.best.x, 1.0), 2).value.abs();
        self.laws.iter().enumerate().map(|(law, weight)| weight * of(law)).sum()
    }

    /// The Chebyshev task with the longest dwells or the fewest harmonics, where the objective asks for them, and what was
    /// tried: the factor of the widths or the harmonics, and the least largest error with them (m), infinite for none.
    pub fn as_chebyshev(&self, progress: Told<'_>) -> Result<(Task, Vec<[f64; 2]>), Infeasible> {
        match self.objective {
            Objective::LongestDwell { tolerance, dwells } => self.longest(tolerance, dwells, progress),
            Objective::FewestHarmonics { tolerance } => self.fewest(tolerance, progress),
            _ => Ok((self.clone(), Vec::new())),
        }
    }

    /// Words of a hint on bounds, where there are some.
    fn or_bounds(&self) -> &'static str {
        if self.bounds.is_empty() { "" } else { ", or widen the bounds" }
    }

    fn longest(
        &self,
        tolerance: f64,
        [first, end]: [usize; 2],
        progress: Told<'_>,
    ) -> Result<(Task, Vec<[f64; 2]>), Infeasible> {
        let stretched = |(i, range): (usize, &Range), factor: f64| {
            let part = if (first..end).contains(&i) { 0.5 * factor } else { 0.5 };
            let (middle, width) = (0.5 * (range.from + range.to), range.to - range.from);
            Range { from: middle - part * width, to: middle + part * width, ..range.clone() }
        };
        let at = |factor: f64| Task {
            ranges: self.ranges.iter().enumerate().map(|range| stretched(range, factor)).collect(),
            objective: Objective::Chebyshev,
            ..self.clone()
        };
        let mut tried = Vec::new();
        let mut level = |factor: f64| {
            let level = at(factor).solve().map_or(f64::INFINITY, |profile| profile.objective);
            tried.push([factor, level]);
            progress(tried.len(), tried.len() + 1);
            over(level, tolerance).min(NONE)
        };
        let widest = TAU / self.ranges[first..end].iter().map(|r| r.to - r.from).fold(0.0, f64::max);
        let (mut here, mut value) = (1.0_f64.min(widest), level(1.0_f64.min(widest)));
        let growth = if value > 0.0 { 1.0 / GROWTH } else { GROWTH };
        let (other, there) = loop {
            let next = (here * growth).min(widest);
            if next == here || next < NARROWEST {
                let which = if next == here { "a whole turn" } else { "a thousandth of these widths" };
                let least = Some(tolerance * value.exp()).filter(|least| *least > f64::EPSILON * self.scale());
                let [least, tolerance] = [least.unwrap_or(0.0), tolerance].map(number);
                let bounds = if value > 0.0 { self.or_bounds() } else { "" };
                return Err(Infeasible::Numerical(format!(
                    "longest dwell: dwells of {which} deviate by {least} m, the tolerance is {tolerance} m: there is no longest \
                     one\n  = hint: take another tolerance, number of harmonics or start `width`{bounds}"
                )));
            }
            let there = level(next);
            if (there > 0.0) != (value > 0.0) {
                break (next, there);
            }
            (here, value) = (next, there);
        };
        let mut of_logarithm = |x: f64| level(x.exp());
        let factor = zero(&mut of_logarithm, [here.ln(), other.ln()], [value, there], 1e-15).exp();
        Ok((at(factor), tried))
    }

    fn fewest(&self, tolerance: f64, progress: Told<'_>) -> Result<(Task, Vec<[f64; 2]>), Infeasible> {
        let (most, mut tried, mut last) = (self.basis.order(), Vec::new(), None);
        for order in self.basis.harmonics() {
            let task = Task { basis: self.basis.up_to(order), objective: Objective::Chebyshev, ..self.clone() };
            let solved = task.solve();
            let level = solved.as_ref().map_or(f64::INFINITY, |profile| profile.objective);
            tried.push([order as f64, level]);
            progress(order, most);
            if level <= tolerance {
                return Ok((task, tried));
            }
            last = Some(solved);
        }
        match last {
            Some(Err(fault)) => Err(fault),
            _ => Err(Infeasible::Numerical(format!(
                "fewest harmonics: with all {most} the largest error is {} m, the tolerance is {} m\n  = hint: raise \
                 `harmonics`, or take a wider tolerance or shorter ranges{}",
                number(tried.last().map_or(f64::INFINITY, |[_, level]| *level)),
                number(tolerance),
                self.or_bounds()
            ))),
        }
    }
}
