//! Cam profiles for an elastic input shaft: the torque in the shaft over a range of speeds is made small.
//!
//! The periodic twist at constant speed Ω solves the linear equation, written with J = J₃ + m U′² (′ = d/dφ),
//!
//! Ω² (J q′)′ + Ω b q′ + (c + ½ Ω² J″) q = −½ Ω² J′.
//!
//! In the complex harmonics of q and J that is Hill's system
//!
//! Σₗ \[(c + iΩbn) δₙₗ − ½ Ω² (n² + l²) Jₙ₋ₗ\] qₗ = −½ iΩ² n Jₙ,
//!
//! a banded one for an HS profile, and so is the system of the sensitivities: H δq = δf − δH q. The torque in the shaft
//! is M = c q + b Ω q′.
//!
//! Symbols: m follower mass (kg), J₃ inertia of the cam (kg·m²), c (N·m/rad), b (N·m·s/rad), q twist (rad).
//! Validity: |q| small against the angle over which U′U″ changes; the periodic motion exists even where it is unstable,
//! which follows from the multipliers of the drive.
//!
//! Source: Dresig, Vulfson, *Dynamik der Mechanismen*, section 4.6.3, equations (1), (3) to (6); the right-hand side of
//! (1) reads U′U″ here.

use super::banded::Banded;
pub use super::banded::Number;
use super::deviation::Window;
use super::nonlinear::{Norm, Values};
use super::{Basis, Curve};
use camdrive::motion::Fourier;
use std::f64::consts::TAU;

/// Harmonics of q that are taken at first, and at most.
const FIRST: usize = 48;
const MOST: usize = 768;

/// The last harmonics of the torque are below this part of the largest one.
const TAIL: f64 = 1e-10;

/// Samples of the torque over the turn in the optimisation, besides the extremes.
const SAMPLES: usize = 128;

/// Values below this part of the largest one do not bind within a step.
const RELEVANT: f64 = 0.5;

/// Speeds between which the largest torque is looked for at first; the exchange adds the others that count.
pub const SPEEDS: usize = 13;

/// An elastic input shaft with its cam and follower.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shaft {
    /// m (kg).
    pub m: f64,
    /// J₃ (kg·m²).
    pub inertia: f64,
    /// c (N·m/rad).
    pub c: f64,
    /// b (N·m·s/rad).
    pub b: f64,
}

/// Torque to be minimised.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShaftGoal {
    /// The shaft.
    pub shaft: Shaft,
    /// Least speed (rad/s).
    pub slowest: f64,
    /// Largest speed (rad/s).
    pub fastest: f64,
    /// Peak or mean.
    pub norm: Norm,
    /// M/(m Ω²) instead of M: all speeds count alike, else the highest ones count most.
    pub relative: bool,
}

/// The periodic torque at one speed.
pub struct PeriodicTorque {
    /// M(φ) (N·m).
    pub torque: Fourier,
    /// ∂M/∂xⱼ, empty where not asked for.
    pub gradients: Vec<Fourier>,
}

/// Complex harmonics −order … order of a real series.
pub struct Spectrum {
    order: usize,
    list: Vec<Number>,
}

impl Spectrum {
    fn at(&self, n: i64) -> Number {
        let place = n + self.order as i64;
        usize::try_from(place).ok().and_then(|i| self.list.get(i).copied()).unwrap_or(Number::ZERO)
    }

    /// The spectrum of U′.
    pub fn of_slope(series: &Fourier) -> Self {
        let order = series.order();
        let one = |n: i64| {
            let k = n.unsigned_abs() as usize;
            // U = Σ uₙ e^{inφ} with uₖ = (aₖ − ibₖ)/2, and U′ has i n uₙ.
            let u = Number::new(0.5 * series.a[k], -0.5 * series.b[k] * n.signum() as f64);
            Number::new(0.0, n as f64) * u
        };
        Spectrum { order, list: (-(order as i64)..=order as i64).map(one).collect() }
    }

    /// The spectrum of the product.
    pub fn times(&self, other: &Spectrum) -> Self {
        let order = self.order + other.order;
        let mut list = vec![Number::ZERO; 2 * order + 1];
        for (i, a) in self.list.iter().enumerate().filter(|(_, a)| **a != Number::ZERO) {
            for (j, b) in other.list.iter().enumerate() {
                list[i + j] += a * b;
            }
        }
        Spectrum { order, list }
    }

    /// The real series, each harmonic times its factor.
    pub fn series(&self, factor: impl Fn(i64) -> Number) -> Fourier {
        let harmonics = (0..=self.order as i64).map(|n| factor(n) * self.at(n));
        let (mut a, b): (Vec<f64>, Vec<f64>) = harmonics.map(|c| (2.0 * c.re, -2.0 * c.im)).unzip();
        a[0] *= 0.5;
        Fourier::new(a, b)
    }
}

impl Shaft {
    /// The periodic torque of a profile at speed `w` (rad/s), with its derivatives after the coefficients of `basis` if
    /// one is given; None where the equations are singular or need too many harmonics.
    pub fn periodic_torque(&self, series: &Fourier, w: f64, basis: Option<&Basis>) -> Option<PeriodicTorque> {
        let slope = Spectrum::of_slope(series);
        let mut inertia = slope.times(&slope);
        inertia.list.iter_mut().for_each(|p| *p *= self.m);
        inertia.list[inertia.order] += self.inertia;
        // Odd harmonics alone leave only even ones in J and q.
        let stride =
            if (0..=inertia.order).all(|n| n % 2 == 0 || inertia.at(n as i64) == Number::ZERO) { 2 } else { 1 };
        let mut harmonics = FIRST.max(2 * inertia.order);
        loop {
            let count = harmonics / stride;
            let q = Hill { shaft: self, w, inertia: &inertia, stride, count };
            let factors = q.factors()?;
            let mut twist: Vec<Number> = (0..2 * count + 1).map(|i| q.forcing(i, inertia.at(q.harmonic(i)))).collect();
            factors.solve(&mut twist);
            let torque = q.torque(&twist);
            let size = |n: usize| torque.a[n].powi(2) + torque.b[n].powi(2);
            let largest = (0..torque.a.len()).map(size).fold(0.0, f64::max);
            let tail = (9 * torque.order() / 10..torque.a.len()).map(size).fold(0.0, f64::max);
            if tail > TAIL * TAIL * largest {
                harmonics *= 2;
                if harmonics > MOST {
                    return None;
                }
                continue;
            }
            let gradients = basis.map_or(Vec::new(), |basis| {
                let one = |unit: Fourier| q.gradient(&factors, &twist, &slope.times(&Spectrum::of_slope(&unit)));
                basis.units().map(one).collect()
            });
            return Some(PeriodicTorque { torque: trimmed(torque, TAIL * largest.sqrt()), gradients });
        }
    }
}

/// Hill's system at one speed.
struct Hill<'a> {
    shaft: &'a Shaft,
    w: f64,
    inertia: &'a Spectrum,
    /// Only the harmonics that are multiples of it occur.
    stride: usize,
    /// Unknowns are the harmonics −count·stride … count·stride.
    count: usize,
}

impl Hill<'_> {
    fn harmonic(&self, i: usize) -> i64 {
        (i as i64 - self.count as i64) * self.stride as i64
    }

    /// c + iΩbn.
    fn impedance(&self, n: i64) -> Number {
        Number::new(self.shaft.c, self.shaft.b * self.w * n as f64)
    }

    /// ½ Ω² (n² + l²).
    fn coupling(&self, n: i64, l: i64) -> f64 {
        0.5 * self.w * self.w * (n * n + l * l) as f64
    }

    /// −½ iΩ² n Jₙ.
    fn forcing(&self, i: usize, inertia: Number) -> Number {
        Number::new(0.0, -0.5 * self.w * self.w * self.harmonic(i) as f64) * inertia
    }

    fn factors(&self) -> Option<Banded> {
        let element = |i: usize, j: usize| {
            let (n, l) = (self.harmonic(i), self.harmonic(j));
            let own = if i == j { self.impedance(n) } else { Number::ZERO };
            own - self.inertia.at(n - l) * self.coupling(n, l)
        };
        Banded::new(2 * self.count + 1, (self.inertia.order / self.stride).min(2 * self.count), element)
    }

    /// M of these harmonics of the twist.
    fn torque(&self, twist: &[Number]) -> Fourier {
        let order = self.count * self.stride;
        let mut list = vec![Number::ZERO; 2 * order + 1];
        list.iter_mut().step_by(self.stride).zip(twist).for_each(|(all, twist)| *all = *twist);
        Spectrum { order, list }.series(|n| self.impedance(n))
    }

    /// ∂M where J changes by 2 m times `product` = U′ δU′.
    fn gradient(&self, factors: &Banded, twist: &[Number], product: &Spectrum) -> Fourier {
        let change = |n: i64| product.at(n) * (2.0 * self.shaft.m);
        let reach = product.order as i64;
        let right = |i: usize| {
            let n = self.harmonic(i);
            let near = |j: &usize| (self.harmonic(*j) - n).abs() <= reach;
            let sum: Number = (0..twist.len())
                .filter(near)
                .map(|j| change(n - self.harmonic(j)) * self.coupling(n, self.harmonic(j)) * twist[j])
                .sum();
            self.forcing(i, change(n)) + sum
        };
        let mut twist: Vec<Number> = (0..twist.len()).map(right).collect();
        factors.solve(&mut twist);
        self.torque(&twist)
    }
}

impl ShaftGoal {
    /// Unit of M at speed `w`.
    fn unit(&self, w: f64) -> f64 {
        if self.relative { self.shaft.m * w * w } else { 1.0 }
    }

    /// The goal where U counts in units of `scale`.
    pub fn scaled(self, scale: f64) -> Self {
        let shaft = Shaft { m: self.shaft.m * scale * scale, ..self.shaft };
        ShaftGoal { shaft, ..self }
    }

    /// Equally spaced speeds of the range.
    pub fn speeds(&self, count: usize) -> Vec<f64> {
        let step = (self.fastest - self.slowest) / (count.max(2) - 1) as f64;
        (0..count.max(2)).map(|i| self.slowest + step * i as f64).collect()
    }

    /// The largest |M| of a profile at speed `w`, over m Ω² where that is the goal; infinite where there is none.
    pub fn peak(&self, series: &Fourier, w: f64) -> f64 {
        match self.shaft.periodic_torque(series, w, None) {
            Some(periodic) => largest(&periodic.torque) / self.unit(w),
            None => f64::INFINITY,
        }
    }

    /// The goal of a profile over `speeds`.
    pub fn over(&self, series: &Fourier, speeds: &[f64]) -> f64 {
        match self.norm {
            Norm::Peak => speeds.iter().map(|w| self.peak(series, *w)).fold(0.0, f64::max),
            Norm::Rms => {
                let square = |w: &f64| match self.shaft.periodic_torque(series, *w, None) {
                    Some(periodic) => mean_square(&periodic.torque) / self.unit(*w).powi(2),
                    None => f64::INFINITY,
                };
                (speeds.iter().map(square).sum::<f64>() / speeds.len() as f64).sqrt()
            }
        }
    }

    /// The torques that count, with their derivatives; None where there is no periodic motion.
    pub fn values(&self, basis: &Basis, x: &[f64], speeds: &[f64]) -> Option<Values> {
        let series = basis.series_of(x);
        let (mut values, mut gradients) = (Vec::new(), Vec::new());
        for &w in speeds {
            let periodic = self.shaft.periodic_torque(&series, w, Some(basis))?;
            let unit = self.unit(w);
            match self.norm {
                Norm::Peak => {
                    let target = Curve::default();
                    let turn = Window { from: 0.0, to: TAU, order: 0, target: &target };
                    let mut places: Vec<f64> = (0..SAMPLES).map(|i| TAU * i as f64 / SAMPLES as f64).collect();
                    places.extend(turn.extremes(&periodic.torque, 0.7).into_iter().map(|e| e.phi));
                    for phi in places {
                        values.push(periodic.torque.at(phi).0[0] / unit);
                        gradients.push(periodic.gradients.iter().map(|g| g.at(phi).0[0] / unit).collect());
                    }
                }
                Norm::Rms => {
                    // The mean of the square is the sum over the harmonics (Parseval), which are the residuals then.
                    let root = (0.5 / speeds.len() as f64).sqrt() / unit;
                    for n in 0..periodic.torque.a.len() {
                        let share = if n == 0 { root * 2f64.sqrt() } else { root };
                        for part in [|s: &Fourier, n: usize| s.a[n], |s: &Fourier, n: usize| s.b[n]] {
                            values.push(share * part(&periodic.torque, n));
                            gradients.push(periodic.gradients.iter().map(|g| share * part(g, n)).collect());
                        }
                    }
                }
            }
        }
        if self.norm == Norm::Peak {
            let largest = values.iter().fold(0.0_f64, |l, v| v.abs().max(l));
            let keep: Vec<bool> = values.iter().map(|v| v.abs() >= RELEVANT * largest).collect();
            let mut kept = keep.iter();
            values.retain(|_| *kept.next().unwrap_or(&true));
            let mut kept = keep.iter();
            gradients.retain(|_| *kept.next().unwrap_or(&true));
        }
        Some(Values { values, gradients, norm: self.norm })
    }
}

/// A series without the last harmonics, all below `least`.
fn trimmed(mut series: Fourier, least: f64) -> Fourier {
    let told = |k: &usize| series.a[*k].abs().max(series.b[*k].abs()) >= least;
    let order = (0..series.a.len()).rev().find(told).unwrap_or(0);
    series.a.truncate(order + 1);
    series.b.truncate(order + 1);
    series
}

fn largest(series: &Fourier) -> f64 {
    super::deviation::peak(series, 0).value.abs()
}

fn mean_square(series: &Fourier) -> f64 {
    let waves = (1..series.a.len()).map(|k| series.a[k].powi(2) + series.b[k].powi(2)).sum::<f64>();
    series.a[0].powi(2) + 0.5 * waves
}

#[cfg(test)]
mod tests {
    use super::super::study::symmetric_task;
    use super::super::{Objective, Symmetry, laws};
    use super::*;
    use std::f64::consts::PI;

    /// The transfer manipulator: follower of 60 kg, stroke 0.4 m, U in strokes here; ω₀ = 80.66 rad/s.
    const SHAFT: Shaft = Shaft { m: 9.6, inertia: 1.5, c: 2.4e4, b: 17.85 };
    const W0: f64 = 80.66;

    fn goal(norm: Norm) -> ShaftGoal {
        ShaftGoal { shaft: SHAFT, slowest: 0.04 * W0, fastest: 0.14 * W0, norm, relative: true }
    }

    #[test]
    fn the_magnification_of_known_laws() {
        let hs = |order: usize| {
            let series = symmetric_task(order, PI / 6.0, Objective::Chebyshev).solve().unwrap().series;
            laws::as_rival("hs", &series)
        };
        let rivals = laws::rivals(&symmetric_task(3, PI / 6.0, Objective::Chebyshev));
        let named = |name: &str| rivals.iter().find(|r| r.name == name).unwrap().clone();
        for (law, at_06, at_08) in [
            (hs(3), 1.12, 1.47),
            (hs(5), 1.92, 2.61),
            (named("inclined_sine"), 1.52, 2.13),
            (named("polynomial_345"), 1.21, 1.68),
            (named("modified_sine"), 1.08, 1.38),
            (named("modified_trapezoid"), 2.45, 2.71),
            (named("simple_sine"), 1.11, 1.03),
        ] {
            let found = [0.06, 0.08].map(|eta| goal(Norm::Peak).peak(&law.series, eta * W0) / law.torque);
            // The table has three digits.
            assert!((found[0] - at_06).abs() < 0.011 && (found[1] - at_08).abs() < 0.011, "{found:?} {at_06} {at_08}");
        }
    }

    #[test]
    fn the_gradients_are_those_of_the_torque() {
        let basis = Basis::new(5, Symmetry { even: false, half_wave: true });
        let x = [0.02, 0.59, 0.01, -0.11, -0.02, 0.016, 0.003];
        for norm in [Norm::Peak, Norm::Rms] {
            let goal = goal(norm);
            let at = |x: &[f64]| goal.shaft.periodic_torque(&basis.series_of(x), 0.11 * W0, Some(&basis)).unwrap();
            let here = at(&x);
            for j in 0..x.len() {
                let moved = |h: f64| {
                    let mut x = x;
                    x[j] += h;
                    at(&x).torque
                };
                let (plus, minus) = (moved(1e-5), moved(-1e-5));
                for phi in [0.3, 2.0, 5.0] {
                    let slope = (plus.at(phi).0[0] - minus.at(phi).0[0]) / 2e-5;
                    let found = here.gradients[j].at(phi).0[0];
                    assert!((slope - found).abs() < 1e-5 * (1.0 + found.abs()), "{j} {phi}: {slope} {found}");
                }
            }
        }
    }
}
