//! Hill's eigenproblem: all instability boundaries of the undamped oscillator at once, counted by oscillation number.
//!
//! Without damping, m̂ q″ + b̂₁ q′ + (λ ĉ + ĉ₂) q = 0 is a self-adjoint eigenproblem in λ = 1/η² with periodic or
//! antiperiodic ends. Its eigenvalues come in pairs, the ends of the instability of order n, whose eigenfunctions have
//! n zeros in a period; n is even with periodic ends, odd with antiperiodic ones. So the place in the sorted list is
//! the order, however far from j² the eigenvalue lies, and no tongue can be missed, however narrow.
//!
//! In harmonics e^(ipnφ), p n the orders that the symmetry of the turn admits:
//!
//! - Inertia that turns (b̂₁ = m̂′, ĉ₂ = m̂″/2): Σ m̂ₙ₋ₗ (n² + l²)/2 qₗ = λ Σ ĉₙ₋ₗ qₗ, symmetric where ĉ > 0. An
//!   eigenvalue λ ≤ 0 belongs to no speed: the instability reaches from the other boundary to infinite speed.
//! - Fixed inertia: −q″ = λ (ĉ/m̂) q, with η² = 1/λ as the eigenvalue, so ĉ may change its sign. The constant is
//!   eliminated, since it does not oscillate. A damping that is negative somewhere adds a term that depends on η
//!   ([`System::ratio`]); each order takes it at its own η = 1/j.
//!
//! Source: V. A. Yakubovich, V. M. Starzhinskii, *Linear Differential Equations with Periodic Coefficients*, Wiley
//! 1975, chapters II and VIII; W. Magnus, S. Winkler, *Hill's Equation*, Wiley 1966, theorem 2.1.

use super::system::{MOST_HARMONICS, System, first_harmonics};
use crate::harmonic_analysis::{Complex, coefficient};
use crate::work;
use nalgebra::DMatrix;

/// The undamped boundaries of the instability of order n.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pair {
    /// The lower λ, the higher speed; not positive without such a speed.
    pub low: f64,
    /// The higher λ.
    pub high: f64,
}

/// The boundaries of the orders n = 1 …, and how far to trust the truncation.
#[derive(Clone, Debug, PartialEq)]
pub struct Boundaries {
    /// One pair for each n.
    pub pairs: Vec<Pair>,
    /// Harmonics kept on either side.
    pub harmonics: usize,
    /// The largest relative change of the λ of each pair when their number was doubled.
    pub changes: Vec<f64>,
}

impl Boundaries {
    /// The boundaries of a drive whose coefficients do not vary: an empty list.
    pub fn none() -> Self {
        Boundaries { pairs: Vec::new(), harmonics: 0, changes: Vec::new() }
    }

    /// The largest change.
    pub fn change(&self) -> f64 {
        largest(&self.changes)
    }

    /// The boundaries of the order n if the truncation separates them from their neighbours, which are about the part 2/n of λ
    /// away.
    pub fn of(&self, n: usize) -> Option<Pair> {
        (self.changes[n - 1] < TRUSTED / n as f64).then_some(self.pairs[n - 1])
    }
}

fn largest(changes: &[f64]) -> f64 {
    if changes.iter().any(|change| change.is_nan()) {
        f64::INFINITY
    } else {
        changes.iter().copied().fold(0.0, f64::max)
    }
}

/// A change by this part of 1/n leaves the boundaries of the order n a fortieth of the way to their neighbours uncertain.
const TRUSTED: f64 = 0.05;

/// The relative change of the boundaries at which the truncation counts as converged. They serve as the start for the
/// exact boundaries, which Newton's method reaches from there in two steps.
const CONVERGED: f64 = 1e-9;

/// The boundaries of the orders 1 … `orders`.
pub fn boundaries(system: &System, orders: usize) -> Boundaries {
    let functions = Functions::of(system);
    let Some(fluctuation) = system.active.then(|| functions.harmonics(system.fluctuation())) else {
        return converged(&functions, orders);
    };
    let mut all = Boundaries::none();
    for n in 1..=orders {
        let own = converged(&functions.with(&fluctuation, 0.5 * (n * functions.parts) as f64), n);
        all.pairs.extend(own.pairs.last());
        all.changes.extend(own.changes.last());
        all.harmonics = all.harmonics.max(own.harmonics);
    }
    all
}

fn converged(functions: &Functions, orders: usize) -> Boundaries {
    let mut harmonics = first_harmonics(orders);
    let mut pairs = truncated(functions, orders, harmonics);
    let mut changes = vec![f64::INFINITY; orders];
    // The first doubling shows how far to trust the result.
    while changes.first() == Some(&f64::INFINITY) || (largest(&changes) > CONVERGED && 2 * harmonics <= MOST_HARMONICS)
    {
        harmonics *= 2;
        let finer = truncated(functions, orders, harmonics);
        let part = |(a, b): (&Pair, &Pair)| ((a.low - b.low).abs().max((a.high - b.high).abs())) / b.high.abs();
        changes = pairs.iter().zip(&finer).map(part).collect();
        pairs = finer;
    }
    Boundaries { pairs, harmonics, changes }
}

/// The harmonics of the matrices, those that the symmetry of the turn admits.
struct Functions {
    parts: usize,
    kind: Kind,
}

enum Kind {
    /// m̂ and ĉ.
    Turning([Vec<Complex>; 2]),
    /// ĉ/m̂.
    Fixed(Vec<Complex>),
}

impl Functions {
    fn of(system: &System) -> Self {
        let mut functions = Functions { parts: system.parts.max(1), kind: Kind::Fixed(Vec::new()) };
        functions.kind = match system.inertia_turns() {
            true => Kind::Turning([functions.harmonics(system.inertia()), functions.harmonics(system.stiffness())]),
            false => Kind::Fixed(functions.harmonics(system.ratio())),
        };
        functions
    }

    /// The harmonics that the symmetry admits.
    fn harmonics(&self, all: Vec<Complex>) -> Vec<Complex> {
        all.into_iter().step_by(self.parts).collect()
    }

    /// Adds the effect of a fluctuation of the damping at η = 1/j; no drive with an inertia that turns has one.
    fn with(&self, fluctuation: &[Complex], j: f64) -> Self {
        let kind = match &self.kind {
            Kind::Fixed(ratio) => {
                let sum = |(a, b): (&Complex, &Complex)| a + b / j;
                Kind::Fixed(ratio.iter().zip(fluctuation).map(sum).collect())
            }
            Kind::Turning(both) => Kind::Turning(both.clone()),
        };
        Functions { parts: self.parts, kind }
    }
}

/// The boundaries from `harmonics` harmonics on either side.
fn truncated(functions: &Functions, orders: usize, harmonics: usize) -> Vec<Pair> {
    let sector = |half: bool| eigenvalues(functions, half, harmonics, orders);
    let (periodic, antiperiodic) = (sector(false), sector(true));
    let pair = |n: usize| {
        let (list, at) = if n.is_multiple_of(2) { (&periodic, n - 2) } else { (&antiperiodic, n - 1) };
        Pair { low: list[at].min(list[at + 1]), high: list[at].max(list[at + 1]) }
    };
    (1..=orders).map(pair).collect()
}

/// The λ of one kind of ends, in the order of the oscillation numbers, without number 0.
fn eigenvalues(functions: &Functions, half: bool, harmonics: usize, orders: usize) -> Vec<f64> {
    // The eigenvalues of a full matrix of 2 `harmonics` rows.
    if !work::draw(5.0 * (2.0 * harmonics as f64).powi(3)) {
        return vec![f64::NAN; orders + 2];
    }
    let parts = functions.parts as f64;
    let waves: Vec<f64> = (1..=harmonics).map(|n| parts * (n as f64 - if half { 0.5 } else { 0.0 })).collect();
    let mut sorted: Vec<f64> = match &functions.kind {
        Kind::Turning([inertia, stiffness]) => {
            let inertia = product(inertia, half, harmonics);
            let stiffness = product(stiffness, half, harmonics);
            let wave = |i: usize| wave_of(i, half, &waves);
            let matrix = DMatrix::from_fn(inertia.nrows(), inertia.ncols(), |i, j| {
                0.5 * (wave(i).powi(2) + wave(j).powi(2)) * inertia[(i, j)]
            });
            // L⁻¹ A L⁻ᵀ with C = L Lᵀ.
            let Some(cholesky) = stiffness.cholesky() else { return vec![f64::NAN; orders + 2] };
            let l = cholesky.l();
            let left = l.solve_lower_triangular(&matrix).unwrap_or(matrix);
            let both = l.solve_lower_triangular(&left.transpose()).unwrap_or(left);
            let mut list: Vec<f64> = both.symmetric_eigenvalues().iter().copied().collect();
            list.sort_by(f64::total_cmp);
            list.split_off(if half { 0 } else { 1 })
        }
        Kind::Fixed(ratio) => {
            let ratio = product(ratio, half, harmonics);
            let (first, constant) = if half { (0, 0.0) } else { (1, ratio[(0, 0)]) };
            let size = ratio.nrows() - first;
            let wave = |i: usize| wave_of(i + first, half, &waves);
            let entry = |i: usize, j: usize| {
                let eliminated = if half { 0.0 } else { ratio[(i + 1, 0)] * ratio[(0, j + 1)] / constant };
                (ratio[(i + first, j + first)] - eliminated) / (wave(i) * wave(j))
            };
            let squares = DMatrix::from_fn(size, size, entry).symmetric_eigenvalues();
            let mut list: Vec<f64> = squares.iter().map(|square| 1.0 / square).filter(|lambda| *lambda > 0.0).collect();
            list.sort_by(f64::total_cmp);
            list
        }
    };
    sorted.resize(sorted.len().max(orders + 2), f64::NAN);
    sorted
}

/// The order of the wave that row i stands for: 1, cos, sin, cos, sin … or without the constant.
fn wave_of(i: usize, half: bool, waves: &[f64]) -> f64 {
    if half {
        waves[i / 2]
    } else if i == 0 {
        0.0
    } else {
        waves[(i - 1) / 2]
    }
}

/// The matrix of the multiplication by a function with the coefficients `g`, in the orthonormal basis
/// (1,) √2 cos, √2 sin of the waves.
fn product(g: &[Complex], half: bool, harmonics: usize) -> DMatrix<f64> {
    // Row → (number of the wave, whether a sine); a wave has the order n or n − ½.
    let row = |i: usize| if half { (i / 2 + 1, i % 2 == 1) } else { (i.div_ceil(2), i > 0 && i.is_multiple_of(2)) };
    let size = 2 * harmonics + usize::from(!half);
    DMatrix::from_fn(size, size, |i, j| {
        let ((n, sine), (l, other)) = (row(i), row(j));
        let difference = coefficient(g, n as i64 - l as i64);
        let sum = coefficient(g, (n + l) as i64 - i64::from(half));
        // 1 = √2 cos 0 / √2 on either side.
        let factor = if n == 0 && l == 0 {
            0.5
        } else if n == 0 || l == 0 {
            std::f64::consts::FRAC_1_SQRT_2
        } else {
            1.0
        };
        factor
            * match (sine, other) {
                (false, false) => difference.re + sum.re,
                (true, true) => difference.re - sum.re,
                (false, true) => difference.im - sum.im,
                (true, false) => -difference.im - sum.im,
            }
    })
}
