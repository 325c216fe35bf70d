//! One cell: collocation of q̈ = g − d q̇ − k q at the Gauss nodes for two free motions and one forced. If the free motion vibrates
//! many times, the cell holds its phase and the part that does not vibrate (module `vibration`).
//!
//! With t = t_mid + H x and a = q̈ at the nodes, q̇ = q̇₀ + H S₁ a and q = q₀ + H (1 + x) q̇₀ + H² S₁² a, hence (1 + H D S₁ + H² K
//! S₁²) a = g − d q̇₀ − k (q₀ + H (1 + x) q̇₀), D and K diagonal: twelve equations with three right-hand sides. This is the Gauss
//! method of order 24, A-stable; its matrix is half the size of the matrix for (q, q̇).

use super::nodes::{ABSCISSAE, INTEGRAL, LEGENDRE, PROJECTION, SECOND_INTEGRAL, STAGES, WEIGHTS, integrate};
use super::vibration::{self, Vibration};
use super::{Affine, COEFFICIENTS, Coefficients, Periodic};
use crate::numerics::double_double::Double;
use crate::numerics::lu::Lu;

/// How often a cell evaluates the coefficients: at the nodes and, for its error, at both ends.
pub const EVALUATIONS: usize = STAGES + 2;

/// A tabulated cell.
#[derive(Clone, Debug, PartialEq)]
pub struct Cell {
    /// From the start of the period (s).
    pub start: Double,
    /// H, half of the length (s).
    pub half: f64,
    /// From the start of the cell to its end.
    pub map: Affine,
    /// The motions between them.
    pub motions: Motions,
}

/// The free and the forced motions within a cell.
#[derive(Clone, Debug, PartialEq)]
pub enum Motions {
    /// As polynomials.
    Polynomials(Polynomials),
    /// By the phase of the free motion.
    Vibration(Vibration),
}

/// Three motions as polynomials: index 0 is the motion from (1, 0), 1 the motion from (0, 1), 2 the forced one.
#[derive(Clone, Debug, PartialEq)]
pub struct Polynomials {
    /// H (s).
    half: f64,
    /// Coefficients of q̇ in powers of x ∈ [−1, 1].
    speed: [[f64; 3]; STAGES + 1],
    /// q in the middle of the cell.
    middle: [f64; 3],
}

impl Cell {
    /// Returns the cell from `start` over `length` (s) by its phase, ∫d over it, and its error; None if the free motion does not
    /// vibrate fast enough.
    pub fn vibrating(
        equation: &dyn Periodic,
        interval: usize,
        start: Double,
        length: f64,
    ) -> Option<(Cell, f64, vibration::Errors)> {
        let half = 0.5 * length;
        let (vibration, errors) = Vibration::solve(equation, interval, start, length)?;
        let map = vibration.map(half);
        let damping = vibration.damping();
        Some((Cell { start, half, map, motions: Motions::Vibration(vibration) }, damping, errors))
    }

    /// Returns the cell from `start` over `length` (s) by polynomials, ∫d over it, and their estimated relative error; None if the
    /// coefficients are not finite or the equations singular.
    pub fn solve(equation: &dyn Periodic, interval: usize, start: Double, length: f64) -> Option<(Cell, f64, f64)> {
        let half = 0.5 * length;
        let mut matrix = [[0.0; STAGES]; STAGES];
        let mut motions = [[0.0; STAGES]; 3];
        let mut whole_damping = 0.0;
        for i in 0..STAGES {
            let x = 1.0 + ABSCISSAE[i];
            let Coefficients { damping, stiffness, forcing } = equation.at(start + Double::from(half * x), interval);
            let (first, second) = (half * damping, half * half * stiffness);
            whole_damping += WEIGHTS[i] * first;
            for j in 0..STAGES {
                matrix[i][j] = first * INTEGRAL[i][j] + second * SECOND_INTEGRAL[i][j];
            }
            matrix[i][i] += 1.0;
            for (motion, value) in motions.iter_mut().zip([-stiffness, -damping - stiffness * half * x, forcing]) {
                motion[i] = value;
            }
        }
        let ends = [0.0, 2.0].map(|x| equation.at(start + Double::from(half * x), interval));
        let lu = Lu::new(matrix, STAGES)?;
        let mut polynomials = Polynomials { half, speed: [[0.0; 3]; STAGES + 1], middle: [0.0; 3] };
        let mut map = Affine::IDENTITY;
        let mut error: f64 = 0.0;
        for (which, acceleration) in motions.iter_mut().enumerate() {
            lu.solve(acceleration);
            let y0 = [[1.0, 0.0], [0.0, 1.0], [0.0, 0.0]][which];
            let (end, part) = polynomials.tabulate(which, y0, acceleration, &ends);
            if which < 2 {
                (map.matrix[0][which], map.matrix[1][which]) = (end[0], end[1]);
            } else {
                map.shift = end;
            }
            // `max` would swallow a NaN.
            error = if part <= error { error } else { part };
        }
        let cell = Cell { start, half, map, motions: Motions::Polynomials(polynomials) };
        error.is_finite().then_some((cell, whole_damping, error))
    }
}

impl Polynomials {
    /// Tabulates the motion from `y0` with these accelerations at the nodes; returns its end and the estimated relative error. The
    /// coefficients belong to the ends of the cell.
    fn tabulate(
        &mut self,
        which: usize,
        y0: [f64; 2],
        acceleration: &[f64; STAGES],
        coefficients: &[Coefficients; 2],
    ) -> ([f64; 2], f64) {
        let half = self.half;
        let modes: [f64; STAGES] =
            std::array::from_fn(|k| (0..STAGES).map(|j| PROJECTION[k][j] * acceleration[j]).sum());
        let speed = integrate(&modes, y0[1], half);
        let position: [f64; STAGES + 1] = integrate(speed[..STAGES].try_into().expect("as many"), y0[0], half);
        self.middle[which] = (0..=STAGES).step_by(2).map(|k| position[k] * LEGENDRE[k][0]).sum();
        for k in 0..=STAGES {
            for j in (k % 2..=k).step_by(2) {
                self.speed[j][which] += speed[k] * LEGENDRE[k][j];
            }
        }
        // The last coefficient of q̇ would enter q beyond the degree of `position`; it vanishes in the middle by parity.
        let velocity = |i: usize| y0[1] + half * (0..STAGES).map(|j| INTEGRAL[i][j] * acceleration[j]).sum::<f64>();
        let velocities: [f64; STAGES] = std::array::from_fn(velocity);
        let sum = |f: &[f64; STAGES]| (0..STAGES).map(|i| WEIGHTS[i] * f[i]).sum::<f64>();
        let end = [y0[0] + half * sum(&velocities), y0[1] + half * sum(acceleration)];
        // Between the nodes the polynomial of q̈ misses the equation by about m₁₂ P₁₂, which is ±1 at the ends; the integral of P₁₂
        // is 25 times smaller. The error of q̇ is relative to the largest q̇; the error of q is smaller.
        let missed = |[q, v]: [f64; 2], side: f64, c: &Coefficients| {
            let polynomial = modes.iter().rev().fold(0.0, |sum, mode| sum * side + mode);
            let forcing = if which == 2 { c.forcing } else { 0.0 };
            (forcing - c.damping * v - c.stiffness * q - polynomial).abs()
        };
        let missed = missed(y0, -1.0, &coefficients[0]) + missed(end, 1.0, &coefficients[1]);
        let error = 2.0 * half * missed / (2 * STAGES + 1) as f64;
        let motion = velocities.iter().fold(y0[1].abs(), |largest, v| largest.max(v.abs()));
        (end, if error == 0.0 { 0.0 } else { error / motion })
    }

    /// The coefficients of q and q̇ in powers of x for the solution that has the state `y` at the start.
    pub fn at(&self, y: [f64; 2]) -> [[f64; 2]; COEFFICIENTS] {
        let combine = |c: &[f64; 3]| c[0] * y[0] + c[1] * y[1] + c[2];
        let mut polynomial = [[0.0; 2]; COEFFICIENTS];
        polynomial[0][0] = combine(&self.middle);
        for (j, c) in self.speed.iter().enumerate() {
            let speed = combine(c);
            polynomial[j][1] = speed;
            polynomial[j + 1][0] = self.half * speed * RECIPROCALS[j];
        }
        polynomial
    }
}

/// 1/(j + 1).
const RECIPROCALS: [f64; STAGES + 1] = {
    let mut r = [1.0; STAGES + 1];
    let mut j = 1;
    while j <= STAGES {
        r[j] = 1.0 / (j + 1) as f64;
        j += 1;
    }
    r
};

/// An error below this may be rounding and does not shorten the next cell: otherwise the last digit of a sine would decide the
/// number of cells. Two roundings of the forcing can make 7e-15 of it.
const NOISE: f64 = 1e-14;

/// The factor for the length of a cell after this error, which goes with length¹³ or faster. Aiming at an eighteenth of the
/// tolerance (0.8¹³) makes rejections rare.
pub fn growth(error: f64, tolerance: f64) -> f64 {
    let least = if error <= NOISE { 1.0 } else { 0.2 };
    (0.8 * (tolerance / error.max(NOISE)).powf(1.0 / (STAGES + 1) as f64)).clamp(least, 4.0)
}
