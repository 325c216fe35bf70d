//! A step of the collocation for any number of equations, in memory that is taken once.
//!
//! Where ṗ = v, the rates of p at the nodes are the v there, so that Newton's method solves for the other rates F alone:
//!
//! vᵢ = v₀ + h Σ aᵢⱼ Fⱼ,  pᵢ = p₀ + h Σ aᵢⱼ vⱼ,  Σⱼ (δᵢⱼ − h aᵢⱼ ∂f/∂v − h² (a²)ᵢⱼ ∂f/∂p) ΔFⱼ = f − Fᵢ.
//!
//! The first guess is F = 0, a motion that coasts.

use super::contraction::Contraction;
use super::newton::{NEWTON_ROUNDING, ROUNDINGS_OF_F};
use super::solved::{powers, response, tail};
use super::{ALIKE, ITERATIONS, SMALLEST_SCALE};
use crate::numerics::double_double::Double;
use crate::numerics::gauss::{NOISE_OF_MODES, STAGES, legendre_integrals};
use crate::numerics::lu::{factorise_rows, solve_rows};
use crate::numerics::radau::{MATRIX, NODES, PROJECTION, SQUARE};

/// Equations ẏ = f(t, y).
pub trait Equations {
    /// ẏ at the fraction θ of the step.
    fn rates(&mut self, theta: f64, y: &[f64], rates: &mut [f64]);
    /// ∂ẏ/∂yₖ where the rates were taken last.
    fn slopes(&mut self, k: usize, slopes: &mut [f64]);
}

/// What the rate of a state is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Rate {
    /// Zero.
    Zero,
    /// Another state.
    State(usize),
    /// A function of the states.
    Function,
}

/// Nominal work of a multiplication with its addition (µs).
const OPERATION: f64 = 2e-4;

/// Numbers at the nodes, or Legendre coefficients.
type Nodes = [f64; STAGES];

/// The step that was solved last.
#[derive(Clone, Debug, Default)]
pub struct Stages {
    /// The states whose rates are unknown, and of each the state whose rate it is.
    unknowns: Vec<(usize, Option<usize>)>,
    /// By state: value and rate at the nodes, the Legendre coefficients of the rate.
    y: Vec<Nodes>,
    f: Vec<Nodes>,
    modes: Vec<Nodes>,
    /// Magnitudes to which errors are relative.
    scale: Vec<f64>,
    /// ∂f/∂y, by state and unknown.
    slopes: Vec<Nodes>,
    /// Newton's matrix, by node and unknown.
    matrix: Vec<f64>,
    pivots: Vec<usize>,
    right: Vec<f64>,
    /// A state and its rates.
    now: [Vec<f64>; 2],
    length: f64,
    /// Estimated errors of each state: of the polynomial, and at the end, with the sign of the last coefficient.
    pub errors: Vec<[f64; 2]>,
    /// A bound of the rates of the free motion (1/s).
    pub rate: f64,
    /// Nominal work of the linear equations (µs).
    pub work: f64,
}

impl Stages {
    /// Makes room for states with such rates.
    pub fn lay_out(&mut self, rates: &[Rate]) {
        let count = rates.len();
        let is_function = |k: usize| rates[k] == Rate::Function;
        let of = |v: usize| (0..count).find(|k| rates[*k] == Rate::State(v));
        self.unknowns.clear();
        // A state that is the rate of two is taken for the first of them, as is what is no rate of its own.
        self.unknowns.extend((0..count).filter(|k| is_function(*k)).map(|v| (v, of(v))));
        for k in 0..count {
            if let Rate::State(v) = rates[k]
                && !(is_function(v) && of(v) == Some(k))
            {
                self.unknowns.push((k, None));
            }
        }
        // Of the two states of a gap that is closed one is unknown when it opens: no step takes memory.
        let (m, closed) = (self.unknowns.len(), rates.iter().filter(|rate| **rate == Rate::Zero).count());
        self.make_room(count, m + closed.div_ceil(2));
        self.make_room(count, m);
    }

    /// Room for so many states and unknown rates.
    #[inline(never)]
    fn make_room(&mut self, count: usize, unknowns: usize) {
        let size = STAGES * unknowns;
        for numbers in [&mut self.y, &mut self.f, &mut self.modes] {
            numbers.resize(count, [0.0; STAGES]);
        }
        self.slopes.resize(count * unknowns, [0.0; STAGES]);
        self.pivots.resize(size, 0);
        self.errors.resize(count, [0.0; 2]);
        let [now, rates] = &mut self.now;
        self.matrix.resize(size * size, 0.0);
        for (numbers, length) in [(&mut self.right, size), (&mut self.scale, count), (now, count), (rates, count)] {
            numbers.resize(length, 0.0);
        }
    }

    /// How many rates are unknown.
    pub fn unknowns(&self) -> usize {
        self.unknowns.len()
    }

    /// Finds a bound of the rates of the free motion about `y` at the start of a step.
    pub fn find_rate(&mut self, equations: &mut impl Equations, y: &[Double]) {
        y.iter().zip(&mut self.now[0]).for_each(|(y, now)| *now = y.hi);
        let [now, rates] = &mut self.now;
        equations.rates(0.0, now, rates);
        self.take_slopes(equations, 0);
        self.rate = self.bound(1);
    }

    /// Solves a step of length `h` from `from`; the estimated error of its polynomial, relative to the largest values over the step
    /// or the `sizes` so far. None where Newton's method does not converge.
    pub fn solve(
        &mut self,
        equations: &mut impl Equations,
        (from, sizes): (&[Double], &[f64]),
        h: f64,
        tolerance: f64,
    ) -> Option<f64> {
        self.length = h;
        self.f.fill([0.0; STAGES]);
        let (mut contraction, mut is_known) = (Contraction::new(tolerance), false);
        self.scale.iter_mut().zip(from).for_each(|(scale, y)| *scale = y.hi.abs().max(SMALLEST_SCALE));
        for _ in 0..ITERATIONS {
            self.spread(|k| from[k]);
            let alike = self.measure();
            self.evaluate(equations, !is_known);
            if !is_known {
                self.factorise()?;
            }
            let size = self.correct()?;
            if contraction.ends_with(size, alike, || self.rounding()) {
                self.spread(|k| from[k]);
                self.measure();
                if contraction.is_stale() {
                    self.evaluate(equations, true);
                    self.factorise()?;
                }
                let rest = contraction.remainder(|| self.rounding());
                return Some(self.conclude(rest, sizes));
            }
            is_known = !contraction.is_slow();
        }
        None
    }

    /// y at the nodes, as F and the values at the start say.
    fn spread(&mut self, from: impl Fn(usize) -> Double) {
        let h = self.length;
        for (k, y) in self.y.iter_mut().enumerate() {
            *y = along(from(k), h, &self.f[k]);
        }
        for &(v, p) in &self.unknowns {
            if let Some(p) = p {
                self.f[p] = self.y[v];
                self.y[p] = along(from(p), h, &self.f[p]);
            }
        }
    }

    /// Takes up the magnitudes; whether they are about those of before.
    fn measure(&mut self) -> bool {
        let mut alike = true;
        for (scale, y) in self.scale.iter_mut().zip(&self.y) {
            let before = *scale;
            *scale = y.iter().fold(before, |most, y| most.max(y.abs()));
            alike &= *scale <= ALIKE * before;
        }
        alike
    }

    /// f − F at the nodes as right-hand sides, and the slopes where the `matrix` is to be made.
    fn evaluate(&mut self, equations: &mut impl Equations, matrix: bool) {
        let m = self.unknowns.len();
        for i in 0..STAGES {
            self.rates_at(equations, i);
            for (right, &(v, _)) in self.right[i * m..].iter_mut().zip(&self.unknowns) {
                *right = self.now[1][v] - self.f[v][i];
            }
            if matrix {
                self.take_slopes(equations, i);
            }
        }
    }

    /// Takes the equations to the node `i`.
    pub fn rates_at(&mut self, equations: &mut impl Equations, i: usize) {
        let [now, rates] = &mut self.now;
        now.iter_mut().zip(&self.y).for_each(|(now, y)| *now = y[i]);
        equations.rates(NODES[i], now, rates);
    }

    /// The slopes at the node `i`.
    fn take_slopes(&mut self, equations: &mut impl Equations, i: usize) {
        let column = &mut self.now[1];
        for (k, slopes) in self.slopes.chunks_exact_mut(self.unknowns.len().max(1)).enumerate() {
            equations.slopes(k, column);
            slopes.iter_mut().zip(&self.unknowns).for_each(|(slope, &(v, _))| slope[i] = column[v]);
        }
    }

    /// The bound of the rates with the slopes at so many nodes: of the products ∂fᵢ/∂yⱼ ∂fⱼ/∂yᵢ, which do not depend on units.
    #[inline(never)]
    fn bound(&self, nodes: usize) -> f64 {
        let m = self.unknowns.len();
        let most =
            |k: usize, u: usize| self.slopes[k * m + u][..nodes].iter().fold(0.0_f64, |most, a| most.max(a.abs()));
        let square = |u: usize| {
            let all = self.unknowns.iter().enumerate();
            let own = self.unknowns[u].1.map_or(0.0, |p| most(p, u));
            own + all.map(|(w, &(v, _))| most(v, u) * most(self.unknowns[u].0, w)).sum::<f64>()
        };
        (0..m).map(square).fold(0.0, f64::max).sqrt()
    }

    /// Makes Newton's matrix.
    fn factorise(&mut self) -> Option<()> {
        let (h, m) = (self.length, self.unknowns.len());
        let size = STAGES * m;
        for i in 0..STAGES {
            for u in 0..m {
                let row = &mut self.matrix[(i * m + u) * size..][..size];
                for (w, &(v, p)) in self.unknowns.iter().enumerate() {
                    let by_v = -h * self.slopes[v * m + u][i];
                    let by_p = p.map_or(0.0, |p| -h * h * self.slopes[p * m + u][i]);
                    for j in 0..STAGES {
                        row[j * m + w] = MATRIX[i][j] * by_v + SQUARE[i][j] * by_p;
                    }
                }
                row[i * m + u] += 1.0;
            }
        }
        self.rate = self.bound(STAGES);
        self.work += OPERATION * (size * size * size) as f64 / 3.0;
        factorise_rows(&mut self.matrix, size, &mut self.pivots)
    }

    /// Solves for the right-hand sides.
    fn invert(&mut self) {
        self.work += OPERATION * (self.pivots.len() * self.pivots.len()) as f64;
        solve_rows(&self.matrix, self.pivots.len(), &self.pivots, &mut self.right);
    }

    /// Adds the solution to F; how large it is as a part of the magnitudes.
    fn correct(&mut self) -> Option<f64> {
        self.invert();
        let m = self.unknowns.len();
        let mut size = 0.0;
        for (n, change) in self.right.iter().enumerate() {
            let (v, p) = self.unknowns[n % m];
            self.f[v][n / m] += change;
            let measure = 1.0 / self.scale[v] + p.map_or(0.0, |p| self.length / self.scale[p]);
            let part = self.length * change.abs() * measure;
            // `max` would swallow a NaN.
            size = if part <= size { size } else { part };
        }
        size.is_finite().then_some(size)
    }

    /// The corrections, as a part of the magnitudes, that may be rounding alone.
    fn rounding(&mut self) -> f64 {
        self.take_noise();
        let part = |&(v, _): &(usize, Option<usize>)| ROUNDINGS_OF_F * self.length * self.now[1][v] / self.scale[v];
        self.unknowns.iter().map(part).fold(NEWTON_ROUNDING, f64::max)
    }

    /// Takes up the changes of each F where states are rounded, with a sign that differs from node to node.
    fn take_noise(&mut self) {
        let m = self.unknowns.len();
        for (n, right) in self.right.iter_mut().enumerate() {
            let (i, u) = (n / m, n % m);
            let terms = self.scale.iter().enumerate().map(|(k, scale)| self.slopes[k * m + u][i].abs() * scale);
            *right = f64::EPSILON * terms.sum::<f64>() * if i % 2 == 0 { 1.0 } else { -1.0 };
        }
        self.invert();
        let [_, noise] = &mut self.now;
        noise.fill(0.0);
        for (n, change) in self.right.iter().enumerate() {
            let (v, p) = self.unknowns[n % m];
            noise[v] = noise[v].max(change.abs());
            if let Some(p) = p {
                noise[p] = f64::EPSILON * self.scale[v];
            }
        }
    }

    /// The polynomial of the step and its errors, with what Newton's method left; the largest relative one.
    fn conclude(&mut self, rest: f64, sizes: &[f64]) -> f64 {
        self.take_noise();
        let (h, mut largest) = (self.length, 0.0_f64);
        let stiff = ((2 * STAGES + 1) as f64 * response(0.5 * h * self.rate)).min(1.0);
        for (k, [between, end]) in self.errors.iter_mut().enumerate() {
            self.modes[k] = projected(&self.f[k]);
            let noise = self.now[1][k];
            let [tail, decay] = tail(|j| self.modes[k][j], NOISE_OF_MODES * noise);
            let size = h * tail / (2 * STAGES + 1) as f64;
            // The velocity of what is stiff is the derivative of a place that is right at the nodes: of one order less, which is half of
            // what two orders diminish.
            (*between, *end) = (size * decay, stiff * size * decay.sqrt());
            let scale = self.scale[k].max(sizes.get(k).copied().unwrap_or(0.0));
            largest = largest.max(between.max(*end).max(h * noise) / scale);
        }
        // The polynomial has order 9 and the end order 15, but for what is stiff.
        let power = largest.powf((2 * STAGES - 1) as f64 / (STAGES + 1) as f64);
        for (k, [_, end]) in self.errors.iter_mut().enumerate() {
            *end = (*end + (power + rest) * self.scale[k]).copysign(self.modes[k][STAGES - 1]);
        }
        largest
    }

    /// The coefficients of θʲ in what a state grows by over the fraction θ of the step.
    pub fn growth(&self, state: usize) -> [f64; STAGES + 1] {
        integral(&self.modes[state]).map(|sum| self.length * sum)
    }

    /// Carries small errors of the start over the fraction θ of the step; afterwards the rates are those of the errors.
    pub fn carry(&mut self, errors: &mut [f64], theta: f64) {
        let (h, m) = (self.length, self.unknowns.len());
        for (n, right) in self.right.iter_mut().enumerate() {
            let (i, u) = (n / m, n % m);
            *right = errors.iter().enumerate().map(|(k, e)| self.slopes[k * m + u][i] * e).sum();
            let coasting = NODES[i] * h;
            for &(v, p) in &self.unknowns {
                *right += p.map_or(0.0, |p| self.slopes[p * m + u][i] * coasting * errors[v]);
            }
        }
        self.invert();
        for (n, change) in self.right.iter().enumerate() {
            self.f[self.unknowns[n % m].0][n / m] = *change;
        }
        self.spread(|k| Double::from(errors[k]));
        let integrals = legendre_integrals(2.0 * theta - 1.0);
        for (e, f) in errors.iter_mut().zip(&self.f) {
            *e += h * projected(f).iter().zip(integrals).map(|(mode, integral)| mode * integral).sum::<f64>();
        }
    }
}

/// The values at the nodes of a step of length `h` of what begins at `from` and has these rates there.
// Sums of 64 products would be written out wherever this is called, and so would those below.
#[inline(never)]
fn along(from: Double, h: f64, f: &Nodes) -> Nodes {
    std::array::from_fn(|i| {
        let sum: f64 = MATRIX[i].iter().zip(f).map(|(a, f)| a * f).sum();
        from.hi + (from.lo + h * sum)
    })
}

/// The Legendre coefficients of the polynomial with these values at the nodes.
#[inline(never)]
fn projected(values: &Nodes) -> Nodes {
    std::array::from_fn(|k| PROJECTION[k].iter().zip(values).map(|(p, value)| p * value).sum())
}

/// The coefficients of θʲ in the integral of what has these Legendre coefficients.
#[inline(never)]
fn integral(modes: &Nodes) -> [f64; STAGES + 1] {
    powers(|k| modes[k])
}

/// The coefficients of θʲ of the polynomial with these values at the nodes.
pub fn through(values: &Nodes) -> Nodes {
    let integral = integral(&projected(values));
    std::array::from_fn(|j| (j + 1) as f64 * integral[j + 1])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// ẏ = f(t, y) in closures.
    struct Of<F, J>(f64, F, J);

    impl<const N: usize, F: Fn(f64, [f64; N]) -> [f64; N], J: Fn(f64, [f64; N]) -> [[f64; N]; N]> Equations
        for (Of<F, J>, [f64; N], f64)
    {
        fn rates(&mut self, theta: f64, y: &[f64], rates: &mut [f64]) {
            self.1.copy_from_slice(y);
            self.2 = theta * self.0.0;
            rates.copy_from_slice(&(self.0.1)(self.2, self.1));
        }

        fn slopes(&mut self, k: usize, slopes: &mut [f64]) {
            let rows = (self.0.2)(self.2, self.1);
            slopes.iter_mut().zip(rows).for_each(|(slope, row)| *slope = row[k]);
        }
    }

    /// A step of q̈ = −ω² q − b q̇ from q, q̇; the solver, its relative error, and the end.
    fn vibration(h: f64, [omega, b]: [f64; 2], from: [f64; 2]) -> (Stages, f64, [f64; 2]) {
        let square = omega * omega;
        let f = move |_, [q, v]: [f64; 2]| [v, -square * q - b * v];
        let mut stages = Stages::default();
        stages.lay_out(&[Rate::State(1), Rate::Function]);
        let mut equations = (Of(h, f, move |_, _| [[0.0, 1.0], [-square, -b]]), [0.0; 2], 0.0);
        let start = from.map(Double::from);
        let error = stages.solve(&mut equations, (&start, &[]), h, 1e-12).unwrap();
        let end = [0, 1].map(|k| from[k] + stages.growth(k).iter().sum::<f64>());
        (stages, error, end)
    }

    #[test]
    fn the_end_of_a_step_is_of_order_15_and_its_polynomial_of_order_9() {
        let errors = |h: f64| {
            let (stages, estimate, end) = vibration(h, [1.0, 0.0], [1.0, 0.0]);
            let between = (0..=100).fold(0.0_f64, |most, n| {
                let theta = f64::from(n) / 100.0;
                let y = 1.0 + stages.growth(0).iter().rev().fold(0.0, |sum, c| sum * theta + c);
                most.max((y - (theta * h).cos()).abs())
            });
            assert!(between < estimate && estimate < 30.0 * between, "{h}: {between:e}, estimated {estimate:e}");
            [(end[0] - h.cos()).hypot(end[1] + h.sin()), between]
        };
        let [coarse, fine] = [errors(4.0), errors(2.5)];
        let order = |k: usize| (coarse[k] / fine[k]).ln() / (4.0f64 / 2.5).ln();
        assert!((15.0..16.3).contains(&order(0)) && (8.5..9.5).contains(&order(1)), "{} {}", order(0), order(1));
    }

    #[test]
    fn what_is_stiff_and_at_rest_stays_there() {
        // A vibration of 1e6 radians in the step is gone at its end; a motion with it is not.
        let (_, _, end) = vibration(1.0, [1e6, 0.0], [1.0, 0.0]);
        assert!(end[0].abs() < 1e-8 && end[1].abs() < 10.0, "{end:?}");
        // Prothero and Robinson: ẏ = λ (y − sin t) + cos t, y = sin t.
        for lambda in [-1.0, -1e4, -1e9] {
            let mut stages = Stages::default();
            stages.lay_out(&[Rate::Function, Rate::Zero]);
            let f = move |t: f64, [y, _]: [f64; 2]| [lambda * (y - t.sin()) + t.cos(), 0.0];
            let mut equations = (Of(0.5, f, move |_, _| [[lambda, 0.0], [0.0; 2]]), [0.0; 2], 0.0);
            let error =
                stages.solve(&mut equations, (&[Double::default(), Double::from(3.0)], &[]), 0.5, 1e-12).unwrap();
            let end = stages.growth(0).iter().sum::<f64>();
            assert!((end - 0.5f64.sin()).abs() < 1e-13 && error < 1e-8, "{lambda:e}: {end} {error:e}");
            assert_eq!(stages.growth(1), [0.0; STAGES + 1]);
            assert!((stages.rate + lambda).abs() <= 1e-9 * stages.rate);
        }
    }

    #[test]
    fn errors_are_carried_as_the_motion_carries_them() {
        let (mut stages, _, _) = vibration(1.3, [2.0, 0.3], [1.0, -0.5]);
        let mut errors = [1e-9, 3e-9];
        stages.carry(&mut errors, 1.0);
        // A linear equation carries them as it does any motion.
        let (_, _, expected) = vibration(1.3, [2.0, 0.3], [1e-9, 3e-9]);
        assert!((0..2).all(|k| (errors[k] - expected[k]).abs() < 1e-15), "{errors:?} {expected:?}");
    }

    #[test]
    fn a_rate_of_two_states_and_one_that_grows_without_end() {
        // y₀, y₁ = ∫ y₂: exact for polynomials.
        let mut stages = Stages::default();
        stages.lay_out(&[Rate::State(2), Rate::State(2), Rate::Function]);
        let mut equations = (
            Of(
                2.0,
                |t: f64, [_, _, v]: [f64; 3]| [v, v, 3.0 * t * t],
                |_, _| [[0.0, 0.0, 1.0], [0.0, 0.0, 1.0], [0.0; 3]],
            ),
            [0.0; 3],
            0.0,
        );
        let start = [0.0, 1.0, 0.0].map(Double::from);
        stages.solve(&mut equations, (&start, &[]), 2.0, 1e-10).unwrap();
        for k in 0..2 {
            assert!((stages.growth(k).iter().sum::<f64>() - 4.0).abs() < 1e-13);
        }
        // ẏ = y², y = 1/(1 − t), has no solution over a step of 2.
        stages.lay_out(&[Rate::Function]);
        let mut equations = (Of(2.0, |_, [y]: [f64; 1]| [y * y], |_, [y]: [f64; 1]| [[2.0 * y]]), [0.0], 0.0);
        let solved = stages.solve(&mut equations, (&[Double::from(1.0)], &[]), 2.0, 1e-10);
        assert!(solved.is_none_or(|error| error > 1e-3), "{solved:?}");
    }
}
