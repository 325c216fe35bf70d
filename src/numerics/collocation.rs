//! Gauss collocation: an implicit Runge–Kutta method of order 16 for small systems ẏ = f(t, y).
//!
//! Over a step of length h from (t₀, y₀) the solution is the polynomial of degree 8 that satisfies the equation at
//! the eight Gauss nodes tᵢ = t₀ + θᵢ h:
//!
//! Fᵢ = f(tᵢ, y₀ + h Σⱼ aᵢⱼ Fⱼ),  y(t₀ + θ h) = y₀ + h Σₖ mₖ ∫₀^θ Pₖ,  y₁ = y₀ + h m₀,
//!
//! where mₖ are the Legendre coefficients of the polynomial through the Fᵢ. The method is A-stable and symplectic.
//! The end point is exact to order 16, the polynomial between the ends to order 9. The step is chosen so that the
//! *polynomial* keeps the tolerance: errors at the ends are then of the order of its square and do not add up, so
//! that a caller may read values anywhere in the step without the steps having to end there.
//!
//! Newton's method finds the Fᵢ with the Jacobians of all stages (it solves a linear system at once); y is summed in double-double.
//! A step whose equations cannot be solved is shortened; every result is finite.
//!
//! Source: E. Hairer, G. Wanner, *Solving Ordinary Differential Equations II*, 2nd ed., Springer 1996, section IV.5
//! and IV.8; E. Hairer, C. Lubich, G. Wanner, *Geometric Numerical Integration*, 2nd ed., Springer 2006, II.1.3.

mod length;
mod newton;
mod solution;

use super::double_double::Double;
use super::gauss::{ABSCISSAE, INTEGRALS_IN_POWERS, MATRIX, STAGES, legendre_integrals};
pub use length::fit;
use length::{first_step, growth};
use newton::Newton;
use serde::{Deserialize, Serialize};
use solution::{Solution, largest, remainder, remainder_of_newton, solution};

/// The largest number of equations.
pub const MAX_EQUATIONS: usize = 3;

const CAPACITY: usize = STAGES * MAX_EQUATIONS;

/// The integration gives up a state beyond this: the square of any product of few such numbers would overflow.
pub const UNBOUNDED: f64 = 1e100;

/// Smaller scales count as this, so that relative errors exist for a vanishing state too.
const SMALLEST_SCALE: f64 = 1e-150;

/// Least ratio of the scales of a decaying state from one step to the next: half in about 70 steps, so
/// that the zeros of an oscillation do not count as small states, and its decay does.
const FORGETTING: f64 = 0.99;

/// Newton iterations per attempt; a problem that needs more gets a shorter step.
const ITERATIONS: usize = 15;

/// The contraction of Newton's method beyond which the matrix of its first iteration is too far from the Jacobians along
/// the step to carry errors: over the thousands of steps of an undamped motion a thousandth in each can make them grow
/// without end. A smaller bound changes the estimate little and has more steps factorise twice.
const STALE: f64 = 3e-4;

/// A smaller contraction of the first two corrections is chance: from a stationary state the matrix gives some 1e-4. A larger bound
/// finds more such cases and makes more steps take a third correction.
const LUCKY: f64 = 5e-6;

/// Corrections are compared if no scale has grown by more than this since the previous one: the contraction is off by no more then.
const ALIKE: f64 = 2.0;

/// Least error of the end of a step: some roundings of the state, as the linear equations pass them on.
const ROUNDING: f64 = 4.0 * f64::EPSILON;

/// Attempts per step; 0.25¹⁰⁰ of any step is negligible.
const ATTEMPTS: usize = 100;

/// A system ẏ = f(t, y) of N ≤ [`MAX_EQUATIONS`] equations, smooth over each step.
pub trait System<const N: usize> {
    /// f(t, y); the time is a double-double, so that stages stay apart at any time.
    fn rhs(&self, t: Double, y: &[f64; N]) -> [f64; N];

    /// ∂fᵢ/∂yⱼ, row by row.
    fn jacobian(&self, t: Double, y: &[f64; N]) -> [[f64; N]; N];

    /// The magnitude to which errors of each component are relative; by default the component's own. The integrator takes the
    /// largest value over the step and, with slow forgetting, the steps before.
    fn magnitude(&self, y: &[f64; N]) -> [f64; N] {
        y.map(f64::abs)
    }

    /// Rounding error of f beyond what the rounding of `y` causes: terms that do not depend on `y` may all but cancel, as a load
    /// and the spring that carries it do in slow motion.
    fn rounding(&self, _t: Double, _y: &[f64; N]) -> [f64; N] {
        [0.0; N]
    }

    /// A step beyond which eight nodes could miss what happens between them.
    fn longest_step(&self, _t: Double, _y: &[f64; N]) -> f64 {
        f64::INFINITY
    }
}

/// The reason why the integration cannot go on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Failure {
    /// No step, however short, keeps the tolerance at this time.
    Stalled {
        /// Time of the failure.
        time: f64,
    },
    /// The solution grows beyond 1e100.
    Unbounded {
        /// Time of the failure.
        time: f64,
    },
}

/// Cost and errors of the integration so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Statistics {
    /// Accepted steps.
    pub steps: u64,
    /// Evaluations of f.
    pub evaluations: u64,
    /// The largest estimated relative error of the polynomial over the steps so far.
    pub error_estimate: f64,
    /// The largest estimated relative error of the state so far: the polynomial's error, and what the errors at the ends of earlier
    /// steps have grown to.
    pub state_error: f64,
    /// The estimate at the ends of the steps only, without the error of the polynomials.
    pub error_at_ends: f64,
}

/// The integrator: the state at the end of the last step, the polynomial of that step and the next step's length.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(bound(serialize = "[f64; N]: Serialize, [[f64; N]; N]: Serialize, [Double; N]: Serialize"))]
#[serde(bound(
    deserialize = "[f64; N]: Deserialize<'de>, [[f64; N]; N]: Deserialize<'de>, [Double; N]: Deserialize<'de>"
))]
pub struct Collocation<const N: usize> {
    /// Start of the last step and the state there.
    start: Double,
    from: [Double; N],
    /// End of the last step and the state there.
    end: Double,
    to: [Double; N],
    /// Length of the last step and Legendre coefficients of ẏ over it.
    length: f64,
    modes: [[f64; N]; STAGES],
    /// Magnitudes to which errors are relative.
    scale: [f64; N],
    /// Covariance of the error at the end of the last step.
    covariance: [[f64; N]; N],
    /// The covariance of errors from outside the integration; see [`Collocation::shake`].
    shaken: [[f64; N]; N],
    /// See [`Collocation::end_error`].
    ends: [f64; N],
    /// Length of the next step; 0 while unknown.
    next: f64,
    /// Cost and error estimate.
    pub statistics: Statistics,
}

impl<const N: usize> Collocation<N> {
    /// Starts from the state `y` at time `t`; no step is known yet.
    pub fn new(t: Double, y: [f64; N]) -> Self {
        const { assert!(N <= MAX_EQUATIONS) }
        let y = y.map(Double::from);
        Collocation {
            start: t,
            from: y,
            end: t,
            to: y,
            length: 0.0,
            modes: [[0.0; N]; STAGES],
            scale: [0.0; N],
            covariance: [[0.0; N]; N],
            shaken: [[0.0; N]; N],
            ends: [0.0; N],
            next: 0.0,
            statistics: Statistics::default(),
        }
    }

    /// Goes on from another state, as after a jump; step length and scale are kept as a first guess.
    pub fn restart(&mut self, t: Double, y: [f64; N]) {
        let fresh = Self::new(t, y);
        let &mut Collocation { scale, covariance, shaken, next, statistics, .. } = self;
        *self = Collocation { scale, covariance, shaken, next, statistics, ..fresh };
    }

    /// Error that the last step added to each component, if its coefficients go on to decay like the last computed ones, plus the
    /// remainder of Newton's method. It is larger than the order of the method implies if waves of different lengths meet and in
    /// short steps.
    pub fn end_error(&self) -> [f64; N] {
        self.ends
    }

    /// Covariance of the error of the state, as far as it is known.
    pub fn error_covariance(&self) -> [[f64; N]; N] {
        self.covariance
    }

    /// Goes on with this covariance of the error, as after a part of the motion that another method computed.
    pub fn set_error_covariance(&mut self, covariance: [[f64; N]; N]) {
        self.covariance = covariance;
    }

    /// Start of the last step.
    pub fn start(&self) -> Double {
        self.start
    }

    /// End of the last step.
    pub fn end(&self) -> Double {
        self.end
    }

    /// The state at the end of the last step.
    pub fn state(&self) -> [f64; N] {
        self.to.map(|y| y.hi)
    }

    /// The state at the time `t` within the last step, from its polynomial.
    pub fn at(&self, t: Double) -> [f64; N] {
        if t == self.end {
            return self.state();
        }
        let theta = if self.length > 0.0 { (t - self.start).hi / self.length } else { 0.0 };
        self.at_fraction(theta)
    }

    /// The state at the fraction θ of the last step.
    pub fn at_fraction(&self, theta: f64) -> [f64; N] {
        let integrals = legendre_integrals(2.0 * theta - 1.0);
        std::array::from_fn(|c| {
            let sum: f64 = (0..STAGES).rev().map(|k| self.modes[k][c] * integrals[k]).sum();
            self.from[c].hi + (self.from[c].lo + self.length * sum)
        })
    }

    /// The coefficients of θʲ in the growth of the component `c` over the fraction θ of the last step.
    pub fn growth(&self, c: usize) -> [f64; STAGES + 1] {
        let sum = |j: usize| (0..STAGES).map(|k| self.modes[k][c] * INTEGRALS_IN_POWERS[k][j]).sum::<f64>();
        std::array::from_fn(|j| self.length * sum(j))
    }

    /// Error of the polynomial of the last step between the ends, for each component: about h m₈/17, as its last
    /// coefficients decay.
    pub fn polynomial_error(&self) -> [f64; N] {
        let pair = |k: usize, c: usize| self.modes[k][c].abs().max(self.modes[k - 1][c].abs());
        std::array::from_fn(|c| {
            let (tail, before) = (pair(STAGES - 1, c), pair(STAGES - 3, c));
            let decay = if tail < before { tail / before } else { 1.0 };
            self.length * tail * decay / (2 * STAGES + 1) as f64
        })
    }

    /// Undoes the last step: the integrator is `earlier` again. The cost stays counted, and a step of the undone length stays
    /// permitted.
    pub fn return_to(&mut self, earlier: &Self) {
        let Statistics { steps, evaluations, .. } = self.statistics;
        let next = self.next.max(self.length);
        let statistics = Statistics { steps, evaluations, ..earlier.statistics };
        *self = Collocation { statistics, next, ..earlier.clone() };
    }

    /// Steps until the last step ends at `target` exactly.
    pub fn advance(&mut self, system: &impl System<N>, target: Double, tolerance: f64) -> Result<(), Failure> {
        while (target - self.end).hi > 0.0 {
            self.step(system, target, tolerance)?;
        }
        Ok(())
    }

    /// Takes one step with the relative `tolerance` that does not reach beyond `limit`. Does nothing if `limit` is reached already.
    pub fn step(&mut self, system: &impl System<N>, limit: Double, tolerance: f64) -> Result<(), Failure> {
        let remaining = (limit - self.end).hi;
        if remaining <= 0.0 {
            return Ok(());
        }
        let y = self.state();
        let longest = system.longest_step(self.end, &y);
        let guess = if self.next > 0.0 { self.next } else { first_step(&system.jacobian(self.end, &y)) };
        let mut h = fit(guess.min(longest), remaining);
        for _ in 0..ATTEMPTS {
            if (self.end + Double::from(h) - self.end).hi <= 0.0 {
                // A step too short to change the time would repeat for ever.
                break;
            }
            match self.attempt(system, h, tolerance) {
                Some(solution) if solution.error <= tolerance => {
                    self.accept(solution, h, limit, h == remaining, tolerance)?;
                    return Ok(());
                }
                Some(solution) => h *= growth(solution.error, tolerance),
                None => h *= 0.25,
            }
            self.next = h;
            h = fit(h, remaining);
        }
        let grown = y.iter().any(|y| y.abs() > UNBOUNDED.sqrt());
        let time = self.end.hi;
        Err(if grown { Failure::Unbounded { time } } else { Failure::Stalled { time } })
    }

    fn accept(
        &mut self,
        solution: Solution<N>,
        h: f64,
        limit: Double,
        limited: bool,
        tolerance: f64,
    ) -> Result<(), Failure> {
        self.start = self.end;
        self.from = self.to;
        self.to = std::array::from_fn(|c| self.from[c] + Double::from(h * solution.modes[0][c]));
        self.end = if limited { limit } else { self.start + Double::from(h) };
        (self.length, self.modes, self.scale) = (h, solution.modes, solution.scale);
        let proposal = h * growth(solution.error, tolerance);
        // A step that was cut short at the limit says nothing against its proposed length.
        self.next = if limited { proposal.max(self.next) } else { proposal };
        self.statistics.steps += 1;
        self.statistics.error_estimate = self.statistics.error_estimate.max(solution.error);
        self.ends = solution.ends;
        self.carry_error(&solution);
        if self.to.iter().any(|y| y.hi.is_nan() || y.hi.abs() > UNBOUNDED) {
            return Err(Failure::Unbounded { time: self.end.hi });
        }
        Ok(())
    }

    /// Adds an error that does not come from the integration, of independent sign, to the state at the end of the last step; it is
    /// carried along.
    pub fn disturb(&mut self, error: [f64; N]) {
        for (c, error) in error.into_iter().enumerate() {
            self.covariance[c][c] += error * error;
        }
    }

    /// Adds an error as [`Collocation::disturb`] does, kept apart from the errors of the integration: it does not measure how large
    /// the motion is.
    pub fn shake(&mut self, error: [f64; N]) {
        for (c, error) in error.into_iter().enumerate() {
            self.shaken[c][c] += error * error;
        }
    }

    /// The standard deviations by which the state has been shaken.
    pub fn shaken(&self) -> [f64; N] {
        std::array::from_fn(|c| self.shaken[c][c].sqrt())
    }

    /// Forgets how large the motion has been, as far as the relative error of the state does not exceed the largest one so far: the
    /// motion from here on is measured by itself.
    pub fn forget(&mut self) {
        for c in 0..N {
            // `min` ignores NaN.
            self.scale[c] = self.scale[c].min(self.covariance[c][c].sqrt() / self.statistics.error_at_ends);
        }
    }

    /// Changes component `c` of the state at the end of the last step by this.
    pub fn push(&mut self, c: usize, change: f64) {
        self.to[c] = self.to[c] + Double::from(change);
    }

    /// Carries the error of the state over the step, y₁ = M y₀ + own error: the covariance becomes M P Mᵀ plus the square of the
    /// error that the end of the step adds. Errors of independent sign grow, turn and decay as the motion does.
    fn carry_error(&mut self, solution: &Solution<N>) {
        self.covariance = carried(&solution.map, &self.covariance);
        if self.shaken != [[0.0; N]; N] {
            self.shaken = carried(&solution.map, &self.shaken);
        }
        let mut state_error: f64 = 0.0;
        for c in 0..N {
            self.covariance[c][c] += solution.own[c].powi(2);
            state_error = state_error.max(self.covariance[c][c].sqrt() / solution.scale[c]);
        }
        self.statistics.error_at_ends = self.statistics.error_at_ends.max(state_error);
        self.statistics.state_error = self.statistics.state_error.max(solution.error + state_error);
    }

    /// Takes one step of fixed cost to `end`: `iterations` of Newton's method, each with its own matrix; one is enough for a linear
    /// equation. The error estimate shows how accurate the step was.
    ///
    /// # Errors
    ///
    /// The estimate exceeds `worst`, or Newton's method does not converge.
    pub fn step_of_fixed_cost(
        &mut self,
        system: &impl System<N>,
        end: Double,
        iterations: usize,
        worst: f64,
    ) -> Result<(), Failure> {
        let time = self.end.hi;
        let h = (end - self.end).hi;
        match self.attempt_with(system, h, iterations) {
            Some(solution) if solution.error <= worst => self.accept(solution, h, end, true, worst),
            _ => Err(Failure::Stalled { time }),
        }
    }

    /// Solves the collocation equations for a step of length `h`; None if Newton's method does not converge.
    fn attempt(&mut self, system: &impl System<N>, h: f64, tolerance: f64) -> Option<Solution<N>> {
        let mut f = self.first_guess(system, h);
        let mut newton = Newton::unknown();
        // Unknown before the first correction; comparisons with NaN are false.
        let (mut last, mut measure) = (f64::NAN, [0.0; N]);
        // Newton's error does not shrink with the step, so it is kept far below the tolerance.
        let enough = (1e-4 * tolerance).max(1e-16);
        for iteration in 0..ITERATIONS {
            let (parts, scale) = self.correct(system, h, &mut f, &mut newton)?;
            let size = largest(&parts);
            // A component at rest at the start has no size before the first correction moves it: corrections relative to different
            // scales show no contraction.
            let alike = (0..N).all(|c| scale[c] <= ALIKE * measure[c]);
            let rate = if alike { size / last } else { f64::NAN };
            // Either the remaining corrections are small, or rounding stops the contraction. The first correction starts from a
            // state at rest: the second may be small by chance, the third is not.
            let likely = if iteration == 1 { rate.max(LUCKY) } else { rate };
            let converged = rate < 1.0 && size * likely / (1.0 - likely) <= enough;
            if size <= enough || converged || (rate > 0.3 && size <= newton.rounding(&scale, h)) {
                if rate > STALE && !(size > enough && rate > 0.3) {
                    newton.factorise(system, h, |i| self.node(i, h), &self.stages(&f, h))?;
                }
                let rest = remainder(size, rate, || newton.rounding(&scale, h));
                return Some(solution(f, scale, &newton, h, [rest; N]));
            }
            newton.is_known &= !(rate > 0.05);
            (last, measure) = (size, scale);
        }
        None
    }

    /// An attempt with a given number of iterations; the remaining contraction counts as error.
    fn attempt_with(&mut self, system: &impl System<N>, h: f64, iterations: usize) -> Option<Solution<N>> {
        let mut f = self.first_guess(system, h);
        let mut newton = Newton::unknown();
        let (mut sizes, mut parts) = ([f64::NAN; 2], [f64::NAN; N]);
        for _ in 0..iterations {
            newton.is_known = false;
            (parts, _) = self.correct(system, h, &mut f, &mut newton)?;
            sizes = [sizes[1], largest(&parts)];
        }
        // The first stages are at rest and do not measure the motion.
        let scale = self.scale_over(system, &self.state(), &self.stages(&f, h));
        let rate = sizes[1] / sizes[0];
        let is_rounding = sizes[1] <= newton.rounding(&scale, h);
        if rate >= 1.0 && !is_rounding {
            return None;
        }
        // One iteration solves linear equations; only roundings remain for the next one.
        let noise = newton.noise(&scale);
        let rest = std::array::from_fn(|c| match iterations {
            1 => 0.0,
            _ if is_rounding => parts[c].max(h * noise[c] / scale[c]),
            _ => remainder_of_newton(parts[c], rate),
        });
        let mut solution = solution(f, scale, &newton, h, rest);
        solution.error += largest(&rest);
        Some(solution)
    }

    /// f at the nodes for the state at rest.
    fn first_guess(&mut self, system: &impl System<N>, h: f64) -> [[f64; N]; STAGES] {
        self.statistics.evaluations += STAGES as u64;
        let y = self.state();
        std::array::from_fn(|i| system.rhs(self.node(i, h), &y))
    }

    /// The time of the node `i` of a step of length `h`.
    fn node(&self, i: usize, h: f64) -> Double {
        self.end + Double::from(0.5 * (1.0 + ABSCISSAE[i]) * h)
    }

    /// The states at the nodes, y₀ + h Σ aᵢⱼ Fⱼ.
    fn stages(&self, f: &[[f64; N]; STAGES], h: f64) -> [[f64; N]; STAGES] {
        std::array::from_fn(|i| {
            std::array::from_fn(|c| {
                let sum: f64 = (0..STAGES).map(|j| MATRIX[i][j] * f[j][c]).sum();
                self.to[c].hi + (self.to[c].lo + h * sum)
            })
        })
    }

    /// Corrects the Fᵢ once, with the given matrix or a new one. Returns the size of the correction relative to the scale for each
    /// component, and the matrix. None if the equations cannot be solved.
    fn correct(
        &mut self,
        system: &impl System<N>,
        h: f64,
        f: &mut [[f64; N]; STAGES],
        newton: &mut Newton<N>,
    ) -> Option<([f64; N], [f64; N])> {
        let stages = self.stages(f, h);
        let mut correction = [0.0; CAPACITY];
        for i in 0..STAGES {
            let value = system.rhs(self.node(i, h), &stages[i]);
            for c in 0..N {
                correction[i * N + c] = value[c] - f[i][c];
            }
        }
        self.statistics.evaluations += STAGES as u64;
        if !newton.is_known {
            newton.factorise(system, h, |i| self.node(i, h), &stages)?;
        }
        newton.lu.solve(&mut correction);
        let scale = self.scale_over(system, &self.state(), &stages);
        let mut parts = [0.0; N];
        for i in 0..STAGES {
            for c in 0..N {
                f[i][c] += correction[i * N + c];
                // `max` would swallow a NaN.
                let part = h * correction[i * N + c].abs() / scale[c];
                parts[c] = if part <= parts[c] { parts[c] } else { part };
            }
        }
        parts.iter().all(|part| part.is_finite()).then_some((parts, scale))
    }

    /// The largest magnitudes over the step and before it.
    fn scale_over(&self, system: &impl System<N>, old: &[f64; N], stages: &[[f64; N]; STAGES]) -> [f64; N] {
        let mut scale = self.scale.map(|s| (FORGETTING * s).max(SMALLEST_SCALE));
        for y in stages.iter().chain([old]) {
            let magnitude = system.magnitude(y);
            for c in 0..N {
                scale[c] = scale[c].max(magnitude[c]);
            }
        }
        scale
    }
}

/// M P Mᵀ.
fn carried<const N: usize>(map: &[[f64; N]; N], covariance: &[[f64; N]; N]) -> [[f64; N]; N] {
    let product = |a: &[[f64; N]; N], b: &dyn Fn(usize, usize) -> f64| -> [[f64; N]; N] {
        std::array::from_fn(|r| std::array::from_fn(|c| (0..N).map(|k| a[r][k] * b(k, c)).sum()))
    };
    let half = product(map, &|k, c| covariance[k][c]);
    product(&half, &|k, c| map[c][k])
}

#[cfg(test)]
mod tests;
