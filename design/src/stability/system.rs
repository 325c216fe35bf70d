//! The oscillator in dimensionless form, its harmonics and its monodromy matrix.
//!
//! With ′ = d/dφ, the means m₀, b₀, c₀ over a turn, ω₀² = c₀/m₀, η = Ω/ω₀ and θ = b₀/(2 m₀ ω₀):
//!
//! m̂ q″ + (d b̂ + b̂₁) q′ + (λ ĉ + d c₁/b₀ + ĉ₂) q = λ f/c₀ + d f₁/b₀ + f₂/m₀,  λ = 1/η², d = 2 θ/η.
//!
//! It is linear in λ and d, so every question of stability is an eigenproblem in one of them. If b = 0, b̂ = 1: damping is then
//! an addition. A modulation μ multiplies the varying part of all coefficients of the left side: m̂ = 1 + μ (m/m₀ − 1) and so
//! on.
//!
//! A damping that is negative somewhere cannot be scaled as a whole: its mean may be 0 or close to it. Then b₀ = ∫ b/m dφ / ∫
//! 1/m dφ is the constant damping with the same decay over a turn (Liouville's formula: the product of the multipliers is
//! exp(−∫ b/m dt)). The difference of b from it stays at every θ: the term of q′ is d + β + b̂₁ with β = (b − b₀)/(m₀ Ω), and
//! b̂ stands for 1 + β η. At another modulation a constant is subtracted from β, so that ∫ β/m̂ dφ = 0 again.

use super::MOST_ORDERS;
use crate::formulas::instability;
use crate::harmonic_analysis::Complex;
use crate::oscillator::{PeriodicOscillator, Terms};
use crate::search::local_maxima;
use crate::work;
use camdrive::drives::Fault;
use camdrive::numerics::angle::WHOLE_TURN;
use camdrive::numerics::divisor::greatest_common_divisor;
use camdrive::numerics::double_double::Double;
use camdrive::numerics::gauss::Gauss;
use camdrive::numerics::period_map::{Coefficients, Period, PeriodMap, Periodic};
use camdrive::numerics::work::EVALUATION;
use std::cell::RefCell;
use std::f64::consts::TAU;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

/// A breakpoint this near the ends of the period counts as lying there (rad): more than the rounding of an angle.
const SLACK: f64 = 1e-12;

/// Harmonics below this part of the mean are roundings of the quadrature.
const LEAST_HARMONIC: f64 = 1e-12;

/// Harmonics from which the symmetry of a turn is read; a drive whose lowest ones are of higher order counts as one without
/// symmetry.
const SYMMETRY_ORDER: usize = 48;

/// The polynomials of the cells keep this relative error; the ends of the cells, which make the monodromy matrix, then err by
/// less than 1e-20 in addition to their roundings. If an inertia or a stiffness nearly vanishes, cancellation has cost its
/// digits, and no cell keeps the first tolerance: the last one still leaves an error of 1e-14 at the ends.
const CELL_TOLERANCES: [f64; 3] = [1e-12, 1e-10, 1e-8];

/// Means over a turn, coherent SI.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Means {
    /// m₀.
    pub m: f64,
    /// b₀; for a damping that is negative somewhere, the constant one with the same decay.
    pub b: f64,
    /// c₀.
    pub c: f64,
}

/// The dimensionless oscillator.
pub struct System<'a> {
    oscillator: &'a PeriodicOscillator,
    /// m₀, b₀, c₀.
    pub mean: Means,
    /// μ.
    pub modulation: f64,
    /// True if the damping is negative somewhere.
    pub active: bool,
    /// Constant taken from β η for ∫ β/m̂ dφ = 0.
    drift: f64,
    /// Into how many equal periods symmetry divides the turn; 0 where the coefficients are constant.
    pub parts: usize,
    /// Nodes and weights of a quadrature over a turn, with the coefficients there.
    samples: Arc<Vec<(f64, f64, Terms)>>,
    /// The highest harmonic that the quadrature resolves.
    order: usize,
    /// The harmonics at μ = 1.
    harmonics: Arc<Harmonics>,
    /// The harmonics of past turns, at all modulations, of turns not in use.
    nodes: Arc<Mutex<Vec<Nodes>>>,
    /// True if a monodromy matrix could not be computed, of this system or of one with another modulation.
    failed: Arc<AtomicBool>,
    /// True if Hill's matrices did not separate the orders, likewise.
    unnumbered: Arc<AtomicBool>,
}

/// Segment, angle and coefficients in the order in which a turn asked for them. The next turn mostly asks for the same,
/// whatever λ and d: coefficients rich in harmonics limit the cells by their own reach.
type Nodes = Vec<(usize, f64, Terms)>;

/// Nodes that are kept of a turn: some 6 MB.
const MOST_NODES: usize = 1 << 16;

/// The reason why a turn cannot be followed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unfollowed {
    /// The free motions grow or decay beyond the range of numbers.
    Range,
    /// It takes too many cells, or no cell keeps the tolerance.
    Cells,
}

/// The complex coefficients of the orders 0 … of the two functions that make the boundaries.
#[derive(Default)]
struct Harmonics {
    /// m/m₀.
    inertia: Vec<Complex>,
    /// c/c₀.
    stiffness: Vec<Complex>,
}

/// The most harmonics, but for one doubling: some tenths of a second of work. If coefficients have jumps in a derivative, the
/// boundaries then still have five digits or more.
pub const MOST_HARMONICS: usize = 96;

/// The first number of harmonics for so many orders.
pub const fn first_harmonics(orders: usize) -> usize {
    orders / 2 + 12
}

/// The highest harmonic of the turn that [`super::hill::boundaries`] may ask for, in a turn with symmetry `parts`.
fn highest_harmonic(parts: usize) -> usize {
    let most = [MOST_HARMONICS, 2 * first_harmonics(MOST_ORDERS)];
    parts.max(1) * (2 * most[0].max(most[1]) + 1)
}

/// The 2×2 map of (q, q′) over a period.
pub type Matrix = [[f64; 2]; 2];

impl<'a> System<'a> {
    /// The system of an oscillator.
    ///
    /// # Errors
    /// Means that make no oscillator.
    pub fn new(oscillator: &'a PeriodicOscillator) -> Result<Self, Fault> {
        let mut system = Self::sampled(oscillator, SYMMETRY_ORDER)?;
        let parts = system.symmetry();
        if parts > 0 {
            system = Self::sampled(oscillator, highest_harmonic(parts))?;
        }
        Ok(System { parts, ..system })
    }

    /// The system without symmetry, with a quadrature that resolves harmonics up to `order`.
    fn sampled(oscillator: &'a PeriodicOscillator, order: usize) -> Result<Self, Fault> {
        let samples = sample(oscillator, order);
        let mean = |term: fn(&Terms) -> f64| samples.iter().map(|(_, w, t)| w * term(t)).sum::<f64>();
        let mut mean = Means { m: mean(|t| t.m), b: mean(|t| t.b), c: mean(|t| t.c) };
        let unit = oscillator.load.unit;
        if !(mean.m > 0.0 && mean.c > 0.0) {
            return Err(Fault::new(format!(
                "the means over a turn, inertia {}, stiffness {} (loads in {unit}), must be positive: without them there \
                 is no natural frequency",
                mean.m, mean.c
            )));
        }
        if let Some((phi, _, t)) = samples.iter().find(|(_, _, t)| t.m <= 0.0) {
            return Err(Fault::new(format!(
                "the inertia {} at {phi:.4} rad must be positive all around the turn",
                t.m
            )));
        }
        let rounding = LEAST_HARMONIC * samples.iter().map(|(_, _, t)| t.b.abs()).fold(0.0, f64::max);
        let active = samples.iter().any(|(_, _, t)| t.b < -rounding);
        if active {
            let over_inertia = |g: fn(&Terms) -> f64| samples.iter().map(|(_, w, t)| w * g(t) / t.m).sum::<f64>();
            mean.b = over_inertia(|t| t.b) / over_inertia(|_| 1.0);
            // The mean of harmonics is 0 but for rounding.
            mean.b = if mean.b.abs() <= rounding { 0.0 } else { mean.b };
        }
        if mean.b < 0.0 || mean.b.is_nan() {
            return Err(Fault::new(format!(
                "free motions grow at every speed: over a turn the damping does as much as a constant one of {} (loads in \
                 {unit}), its mean over the inertia; add constant damping until that is at least 0",
                mean.b
            )));
        }
        let samples = Arc::new(samples);
        let (harmonics, nodes) = (Arc::default(), Arc::default());
        let (failed, unnumbered) = (Arc::default(), Arc::default());
        let mut system = System {
            oscillator,
            mean,
            modulation: 1.0,
            active,
            drift: 0.0,
            parts: 0,
            samples,
            order,
            harmonics,
            nodes,
            failed,
            unnumbered,
        };
        let [inertia, stiffness] = [system.coefficients(order, &|t| t.m), system.coefficients(order, &|t| t.c)];
        system.harmonics = Arc::new(Harmonics { inertia, stiffness });
        Ok(system)
    }

    /// The system with the modulation `factor` instead of 1.
    pub fn modulated(&self, factor: f64) -> System<'a> {
        let (samples, harmonics, nodes) = (self.samples.clone(), self.harmonics.clone(), self.nodes.clone());
        let (failed, unnumbered) = (self.failed.clone(), self.unnumbered.clone());
        let mut system =
            System { modulation: factor, drift: 0.0, samples, harmonics, nodes, failed, unnumbered, ..*self };
        if self.active {
            let over_inertia = |g: &dyn Fn(&Terms) -> f64| system.coefficients(0, &|t| g(t) / t.m)[0].re;
            system.drift = over_inertia(&|t| t.b - 1.0) / over_inertia(&|_| 1.0);
        }
        system
    }

    /// The modulation at which the inertia vanishes somewhere; infinite if it does not vary.
    pub fn greatest_modulation(&self) -> f64 {
        let least = self.samples.iter().map(|(_, _, t)| t.m).fold(f64::INFINITY, f64::min) / self.mean.m;
        if least < 1.0 - LEAST_HARMONIC { 1.0 / (1.0 - least) } else { f64::INFINITY }
    }

    /// True if b₁ = m′ and c₂ = m″/2.
    pub fn inertia_turns(&self) -> bool {
        self.oscillator.inertia_turns
    }

    /// The harmonics that the printed formulas take.
    pub fn printed(&self) -> instability::Harmonics {
        instability::Harmonics { m: self.inertia(), c: self.stiffness(), turning: self.inertia_turns() }
    }

    /// ω₀ (rad/s).
    pub fn natural_frequency(&self) -> f64 {
        (self.mean.c / self.mean.m).sqrt()
    }

    /// θ of the scene.
    pub fn damping_ratio(&self) -> f64 {
        self.mean.b / (2.0 * self.mean.m * self.natural_frequency())
    }

    /// The length of a period (rad).
    pub fn period(&self) -> f64 {
        TAU / self.parts.max(1) as f64
    }

    /// The coefficients in dimensionless form; `f` is f/c₀, `f1` f₁/b₀ and `f2` f₂/m₀.
    fn scaled(&self, t: &Terms) -> Terms {
        let Means { m, b, c } = self.mean;
        let varied = |value: f64, mean: f64| 1.0 + self.modulation * (value / mean - 1.0);
        Terms {
            m: varied(t.m, m),
            b: match b {
                _ if self.active => 1.0 + self.modulation * (t.b - b) / (m * self.natural_frequency()) - self.drift,
                0.0 => 1.0,
                b => varied(t.b, b),
            },
            b1: self.modulation * t.b1 / m,
            c: varied(t.c, c),
            c1: if t.c1 == 0.0 { 0.0 } else { self.modulation * t.c1 / b },
            c2: self.modulation * t.c2 / m,
            f: t.f / c,
            f1: if t.f1 == 0.0 { 0.0 } else { t.f1 / b },
            f2: t.f2 / m,
        }
    }

    /// The factors c₀ and b₀ d/λ of q and q′ in the load of the drive's own spring and damper at φ, if others act as well.
    pub fn own(&self, phi: f64) -> Option<[f64; 2]> {
        self.oscillator
            .own
            .as_ref()
            .map(|own| own(phi))
            .map(|[b, c]| [if b == 0.0 { 0.0 } else { b / self.mean.b }, c / self.mean.c])
    }

    /// The damping term of q′ with b̂ = `b`, at η = 1/`inverse`.
    pub fn damping(&self, b: f64, inverse: f64, d: f64) -> f64 {
        if self.active { d + inverse * (b - 1.0) } else { d * b }
    }

    /// The coefficients of m̂ of the orders up to [`System::highest_harmonic`]: (1/2π) ∫ m̂ e^(−ikφ) dφ.
    pub fn inertia(&self) -> Vec<Complex> {
        self.varied(&self.harmonics.inertia)
    }

    /// The coefficients of ĉ.
    pub fn stiffness(&self) -> Vec<Complex> {
        self.varied(&self.harmonics.stiffness)
    }

    /// The coefficients of ĉ/m̂. For an active damping those of ĉ/m̂ − ¼ (β η/m̂)², its part in the equation of y = q exp(½ ∫
    /// β/m̂ dφ) at θ = 0; the other part is [`System::fluctuation`] over η.
    pub fn ratio(&self) -> Vec<Complex> {
        if self.active {
            return self.coefficients(self.order, &|t| t.c / t.m - 0.25 * ((t.b - 1.0) / t.m).powi(2));
        }
        let constant = self.harmonics.inertia[1..].iter().all(|c| c.re.abs().max(c.im.abs()) < LEAST_HARMONIC);
        if constant { self.stiffness() } else { self.coefficients(self.order, &|t| t.c / t.m) }
    }

    /// The coefficients of −½ (β η/m̂)′ for an active damping.
    pub fn fluctuation(&self) -> Vec<Complex> {
        let list = self.coefficients(self.order, &|t| (t.b - 1.0) / t.m);
        // The derivative of e^(ikφ) is i k e^(ikφ).
        list.into_iter().enumerate().map(|(k, c)| Complex::new(0.0, -0.5 * k as f64) * c).collect()
    }

    fn varied(&self, list: &[Complex]) -> Vec<Complex> {
        let factor = |k: usize| if k == 0 { 1.0 } else { self.modulation };
        list.iter().enumerate().map(|(k, value)| value * factor(k)).collect()
    }

    /// The coefficients of a function of the dimensionless coefficients up to `order`.
    pub fn coefficients(&self, order: usize, g: &dyn Fn(&Terms) -> f64) -> Vec<Complex> {
        let mut list = vec![Complex::default(); order + 1];
        for (phi, weight, terms) in self.samples.iter() {
            let value = weight * g(&self.scaled(terms));
            let (step, mut wave) = (Complex::cis(-phi), Complex::from(1.0));
            for sum in &mut list {
                *sum += wave * value;
                wave *= step;
            }
        }
        list
    }

    /// The highest harmonic that the quadrature resolves.
    pub fn highest_harmonic(&self) -> usize {
        self.order
    }

    /// The least value of a function of the dimensionless coefficients.
    pub fn least(&self, g: &dyn Fn(&Terms) -> f64) -> f64 {
        self.samples.iter().map(|(_, _, t)| g(&self.scaled(t))).fold(f64::INFINITY, f64::min)
    }

    /// The greatest absolute value of a function of the dimensionless coefficients: the samples' maximum, refined between them.
    pub fn greatest(&self, g: &dyn Fn(&Terms) -> f64) -> f64 {
        // From one sample to the next a function rises by less.
        const NEAR: f64 = 0.98;
        let size = |t: &Terms| g(&self.scaled(t)).abs();
        let values: Vec<(f64, f64)> = self.samples.iter().map(|(phi, _, t)| (*phi, size(t))).collect();
        let sampled = values.iter().map(|(_, value)| *value).fold(0.0, f64::max);
        let (mut greatest, mut start) = (sampled, 0.0);
        for (end, segment) in intervals(self.oscillator, 0.0, TAU) {
            let f = |phi: f64| size(&(self.oscillator.terms)(segment, phi));
            let inside: Vec<&(f64, f64)> = values.iter().filter(|(phi, _)| start < *phi && *phi < end).collect();
            for i in (0..inside.len()).filter(|i| inside[*i].1 >= NEAR * sampled) {
                let before = if i == 0 { start } else { inside[i - 1].0 };
                let places = [before, inside[i].0, inside.get(i + 1).map_or(end, |(phi, _)| *phi)];
                greatest = local_maxima(&places, greatest, &f).into_iter().map(f).fold(greatest, f64::max);
            }
            start = end;
        }
        greatest
    }

    /// The greatest common divisor of the orders of the harmonics, checked against the coefficients themselves.
    fn symmetry(&self) -> usize {
        let terms: [fn(&Terms) -> f64; 3] = [|t| t.m, |t| t.b, |t| t.c];
        let lists = terms.map(|term| self.coefficients(SYMMETRY_ORDER, &term));
        let significant =
            |k: &usize| lists.iter().any(|list| list[*k].re.abs().max(list[*k].im.abs()) > LEAST_HARMONIC);
        let parts = (1..=SYMMETRY_ORDER).filter(significant).fold(0, greatest_common_divisor);
        let varies =
            self.samples.iter().any(|(_, _, t)| terms.iter().any(|g| (g(&self.scaled(t)) - 1.0).abs() > 1e-11));
        match parts {
            0 if varies => 1,
            p if p < 2 || self.repeats(p) => p,
            _ => 1,
        }
    }

    /// True if the coefficients repeat `parts` times in a turn, checked at angles that no symmetry prefers.
    fn repeats(&self, parts: usize) -> bool {
        (0..40).all(|i| {
            let phi = (0.1 + 0.618_033_988_75 * f64::from(i)).rem_euclid(1.0) * TAU / parts as f64;
            let at = |phi: f64| self.scaled(&(self.oscillator.terms)(segment_at(self.oscillator, phi), phi));
            let (first, other) = (at(phi), at(phi + TAU / parts as f64));
            let same = |g: fn(&Terms) -> f64| (g(&first) - g(&other)).abs() < 1e-10;
            same(|t| t.m) && same(|t| t.b) && same(|t| t.c)
        })
    }

    /// The tables of the whole turn with the load; None if they cannot be computed.
    pub fn table(&self, lambda: f64, d: f64) -> Option<PeriodMap> {
        let turn = PeriodEquation::new(self, lambda, d, 1, true);
        CELL_TOLERANCES.iter().find_map(|tolerance| PeriodMap::new(&turn, *tolerance))
    }

    /// The monodromy matrix of (q, q′) over a period.
    ///
    /// # Errors
    /// A matrix that cannot be computed.
    pub fn followed(&self, lambda: f64, d: f64) -> Result<Matrix, Unfollowed> {
        let turn = PeriodEquation::new(self, lambda, d, self.parts.max(1), false);
        let period = CELL_TOLERANCES.iter().find_map(|tolerance| Period::of(&turn, *tolerance));
        let matrix = period.ok_or(Unfollowed::Cells)?.map.matrix;
        if matrix.iter().flatten().all(|entry| entry.is_finite()) { Ok(matrix) } else { Err(Unfollowed::Range) }
    }

    /// The monodromy matrix of (q, q′) over a period; NaN if it cannot be computed, see [`System::has_failed`].
    pub fn monodromy(&self, lambda: f64, d: f64) -> Matrix {
        self.followed(lambda, d).unwrap_or_else(|_| {
            self.failed.store(true, Ordering::Relaxed);
            [[f64::NAN; 2]; 2]
        })
    }

    /// True if a monodromy matrix could not be computed so far.
    pub fn has_failed(&self) -> bool {
        self.failed.load(Ordering::Relaxed)
    }

    /// True if Hill's matrices did not separate the orders at some modulation so far.
    pub fn has_unnumbered(&self) -> bool {
        self.unnumbered.load(Ordering::Relaxed)
    }

    /// Notes that Hill's matrices did not separate the orders.
    pub fn mark_unnumbered(&self) {
        self.unnumbered.store(true, Ordering::Relaxed);
    }

    /// The angle at which motions under load start (rad).
    pub fn start(&self) -> f64 {
        self.oscillator.start
    }

    /// The dimensionless coefficients at an angle of the turn (rad).
    pub fn at(&self, phi: f64) -> Terms {
        self.scaled(&(self.oscillator.terms)(segment_at(self.oscillator, phi), phi))
    }
}

/// The segment that holds `phi` in [0, 2π].
fn segment_at(oscillator: &PeriodicOscillator, phi: f64) -> usize {
    let breakpoints = &oscillator.breakpoints;
    let phi = phi.rem_euclid(TAU);
    match breakpoints.partition_point(|b| *b <= phi + SLACK) {
        0 => breakpoints.len().saturating_sub(1),
        after => after - 1,
    }
}

/// The ends of the smooth intervals within `length` after `start`, counted from there, each with its segment.
fn intervals(oscillator: &PeriodicOscillator, start: f64, length: f64) -> Vec<(f64, usize)> {
    let way = |b: &f64| (b - start).rem_euclid(TAU);
    let inside = |way: &f64| SLACK < *way && *way < length - SLACK;
    let mut ends: Vec<f64> = oscillator.breakpoints.iter().map(way).filter(inside).chain([length]).collect();
    ends.sort_by(f64::total_cmp);
    let mut last = 0.0;
    ends.into_iter()
        .map(|end| {
            let segment = segment_at(oscillator, start + 0.5 * (last + end));
            last = end;
            (end, segment)
        })
        .collect()
}

/// Gauss nodes over the turn, weights of sum 1 and the coefficients. Neither the coefficients nor the waves of order `order`
/// turn by more than 4 rad over a cell, and 16 nodes integrate the product to rounding.
pub fn sample(oscillator: &PeriodicOscillator, order: usize) -> Vec<(f64, f64, Terms)> {
    let mut samples = Vec::new();
    let mut start = 0.0;
    for (end, segment) in intervals(oscillator, 0.0, TAU) {
        let longest = (oscillator.reach)(segment).min(4.0 / order.max(1) as f64);
        let cells = ((end - start) / longest).ceil().max(1.0);
        let length = (end - start) / cells;
        for cell in 0..cells as usize {
            let from = start + length * cell as f64;
            for [place, weight] in Gauss::with(16).nodes::<16>(length) {
                let phi = from + place;
                samples.push((phi, weight / TAU, (oscillator.terms)(segment, phi)));
            }
        }
        start = end;
    }
    samples
}

/// The equation over one period, φ taking the place of time.
struct PeriodEquation<'a> {
    system: &'a System<'a>,
    lambda: f64,
    d: f64,
    parts: usize,
    loaded: bool,
    /// The angle at which the period starts (rad).
    start: f64,
    intervals: Vec<(f64, usize)>,
    /// The nodes of a turn before, as far as they are not overwritten yet, and the next one of this turn.
    nodes: RefCell<(Nodes, usize)>,
}

impl<'a> PeriodEquation<'a> {
    fn new(system: &'a System<'a>, lambda: f64, d: f64, parts: usize, loaded: bool) -> Self {
        let start = if loaded { system.oscillator.start } else { 0.0 };
        let intervals = intervals(system.oscillator, start, TAU / parts as f64);
        let nodes = system.nodes.lock().unwrap_or_else(PoisonError::into_inner).pop().unwrap_or_default();
        PeriodEquation { system, lambda, d, parts, loaded, start, intervals, nodes: RefCell::new((nodes, 0)) }
    }

    /// The coefficients of a segment at an angle (rad).
    fn terms(&self, segment: usize, phi: f64) -> Terms {
        let (nodes, next) = &mut *self.nodes.borrow_mut();
        if *next == MOST_NODES {
            return (self.system.oscillator.terms)(segment, phi);
        }
        if nodes.get(*next).is_none_or(|node| (node.0, node.1) != (segment, phi)) {
            let node = (segment, phi, (self.system.oscillator.terms)(segment, phi));
            match nodes.get_mut(*next) {
                Some(old) => *old = node,
                None => nodes.push(node),
            }
        }
        *next += 1;
        nodes[*next - 1].2
    }
}

impl Drop for PeriodEquation<'_> {
    fn drop(&mut self) {
        let nodes = std::mem::take(&mut self.nodes.get_mut().0);
        self.system.nodes.lock().unwrap_or_else(PoisonError::into_inner).push(nodes);
    }
}

impl Periodic for PeriodEquation<'_> {
    fn period(&self) -> Double {
        WHOLE_TURN.divide(Double::from(self.parts as f64))
    }

    fn joints(&self) -> Vec<Double> {
        let mut joints: Vec<Double> = self.intervals.iter().map(|(end, _)| Double::from(*end)).collect();
        joints.pop();
        joints.push(self.period());
        joints
    }

    fn at(&self, phi: Double, interval: usize) -> Coefficients {
        let t = self.system.scaled(&self.terms(self.intervals[interval].1, (self.start + phi.hi).rem_euclid(TAU)));
        Coefficients {
            // No speed belongs to λ < 0.
            damping: (self.system.damping(t.b, self.lambda.max(0.0).sqrt(), self.d) + t.b1) / t.m,
            stiffness: (self.lambda * t.c + self.d * t.c1 + t.c2) / t.m,
            forcing: if self.loaded { (self.lambda * t.f + self.d * t.f1 + t.f2) / t.m } else { 0.0 },
        }
    }

    fn longest_cell(&self, _: Double, interval: usize) -> f64 {
        (self.system.oscillator.reach)(self.intervals[interval].1)
    }

    fn draw(&self, evaluations: usize) -> Option<()> {
        // A thousand plain operations in a nominal microsecond.
        work::draw(1e3 * evaluations as f64 * (EVALUATION + self.system.oscillator.cost)).then_some(())
    }
}
