//! The covariance of the errors that rounding and the neglected terms of the series cause, carried along with the motion.
//!
//! Between switching instants an error moves like the free motion: δ(T) = M δ(0). A release leaves it alone, since nothing jumps.
//! An impact comes earlier by δζ/ζ̇⁻, so that with n = δζ/ζ̇⁻
//!
//! δζ⁺ = −e δζ⁻,  δζ̇⁺ = −e δζ̇⁻ + (ζ̈⁺ + e ζ̈⁻) n,
//! δq⁺ = δq⁻ + (1 + e) δζ⁻,  δq̇⁺ = δq̇⁻ + (1 + e) δζ̇⁻ + (q̈⁺ − q̈⁻ − (1 + e) ζ̈⁻) n.
//!
//! So a grazing impact (ζ̇⁻ → 0) multiplies errors, and the estimate with them. The estimate is linear: if it reaches the size of
//! the motion, all digits are lost.
//!
//! Source: R. I. Leine, H. Nijmeijer, *Dynamics and Bifurcations of Non-Smooth Mechanical Systems*, Springer 2004,
//! section 7.4 (jump of the fundamental solution matrix).

use crate::drives::follower::contact::{Bodies, Mode, State};
use crate::drives::solver::step_control::{RESERVE, ROUNDINGS};
use crate::numerics::double_double::Double;
use serde::{Deserialize, Serialize};

/// The covariance of ζ, ζ̇, q, q̇.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Covariance {
    /// At the last switching instant.
    matrix: [[f64; 4]; 4],
    /// The time since (s), up to the current panel.
    elapsed: f64,
    /// Errors added since then, including the current panel: variances of roundings, sums of neglected terms.
    rounded: [f64; 4],
    neglected: [f64; 4],
    /// Roundings that a panel adds, in units of the first terms of its series.
    rounding: f64,
}

/// ζ̇, ζ̈, q̈ on one side of an impact.
pub struct Side {
    /// ζ̇ (m/s).
    pub speed: f64,
    /// ζ̈ and q̈ (m/s²).
    pub accelerations: [f64; 2],
}

impl Side {
    /// In this mode and state on a flank that moves with `u`.
    pub fn of(bodies: &Bodies, mode: Mode, state: &State, u: &crate::motion::Kinematics) -> Self {
        let accelerations = match mode {
            Mode::Free => [bodies.gap_derivatives(state.q, u)[0], bodies.free_derivatives(state.q)[0]],
            Mode::Contact(_) => [0.0, bodies.bound_derivatives(state.q, u)[0]],
        };
        Side { speed: state.zeta[1], accelerations }
    }
}

impl Covariance {
    /// No errors; the flank's roundings are so many times those of its values.
    pub fn new(roundings: f64) -> Self {
        Covariance { rounding: ROUNDINGS * f64::EPSILON * roundings, ..Covariance::default() }
    }

    /// Begins a panel: adds its roundings and neglected terms up to its end, in ζ, ζ̇, q, q̇.
    pub fn enter(&mut self, [sizes, neglected]: [[f64; 4]; 2]) {
        self.round(sizes);
        for i in 0..4 {
            self.neglected[i] += neglected[i];
        }
    }

    /// Leaves the panel this long (s) after its start.
    pub fn leave(&mut self, after: f64) {
        self.elapsed += after;
    }

    /// Adds the rounding of numbers of these sizes in ζ, ζ̇, q, q̇.
    pub fn round(&mut self, sizes: [f64; 4]) {
        for i in 0..4 {
            let rounding = self.rounding * sizes[i];
            self.rounded[i] += rounding * rounding;
        }
    }

    /// Carries the covariance to a switching instant at the end of motion in `mode`.
    pub fn carry(&mut self, bodies: &Bodies, mode: Mode) {
        let oscillator = if mode == Mode::Free { &bodies.relative } else { &bodies.bound };
        let [[a, b], [c, d]] = oscillator.free(Double::from(self.elapsed));
        let (s, t) = (bodies.share, self.elapsed);
        let map = if mode == Mode::Free {
            // x1 is off the centre of mass, which moves uniformly, by −s q.
            [
                [1.0, t, s * (1.0 - a), s * (t - b)],
                [0.0, 1.0, -s * c, s * (1.0 - d)],
                [0.0, 0.0, a, b],
                [0.0, 0.0, c, d],
            ]
        } else {
            [[0.0; 4], [0.0; 4], [0.0, 0.0, a, b], [0.0, 0.0, c, d]]
        };
        self.transform(&map);
        let from = if mode == Mode::Free { 0 } else { 2 };
        for i in from..4 {
            self.matrix[i][i] += self.rounded[i] + self.neglected[i] * self.neglected[i];
        }
        (self.elapsed, self.rounded, self.neglected) = (0.0, [0.0; 4], [0.0; 4]);
    }

    /// Takes up an impact between these sides; `stays` if m1 does not leave the flank again.
    pub fn strike(&mut self, e: f64, before: &Side, after: &Side, stays: bool) {
        let [z, q] = [0, 1].map(|i| [before.accelerations[i], after.accelerations[i]]);
        let earlier = |jump: f64| if before.speed == 0.0 { 0.0 } else { jump / before.speed };
        let mut map = [
            [-e, 0.0, 0.0, 0.0],
            [earlier(z[1] + e * z[0]), -e, 0.0, 0.0],
            [1.0 + e, 0.0, 1.0, 0.0],
            [earlier(q[1] - q[0] - (1.0 + e) * z[0]), 1.0 + e, 0.0, 1.0],
        ];
        if stays {
            (map[0], map[1]) = ([0.0; 4], [0.0; 4]);
        }
        self.transform(&map);
    }

    /// P ← M P Mᵀ, which is symmetric.
    fn transform(&mut self, map: &[[f64; 4]; 4]) {
        let mut half = [[0.0; 4]; 4];
        for i in 0..4 {
            for k in 0..4 {
                for j in 0..4 {
                    half[i][j] += map[i][k] * self.matrix[k][j];
                }
            }
        }
        self.matrix = [[0.0; 4]; 4];
        for i in 0..4 {
            for j in 0..=i {
                let sum = (0..4).map(|k| half[i][k] * map[j][k]).sum();
                (self.matrix[i][j], self.matrix[j][i]) = (sum, sum);
            }
        }
    }

    /// A bound of the errors up to the end of a panel of the length `ahead` (s), whatever the phase of the free motion and the
    /// correlation of the errors: errors of x1, x2 relative to the place and of ẋ1, ẋ2 relative to the velocity in `largest` (m),
    /// (m/s); 1 if all digits are lost.
    pub fn relative(&self, bodies: &Bodies, ahead: f64, [place, speed]: [f64; 2]) -> f64 {
        // A cam without a stroke moves nothing.
        if place == 0.0 {
            return 0.0;
        }
        let [z, y, q, v] = [0, 1, 2, 3].map(|i| {
            let variance = self.matrix[i][i] + self.rounded[i] + self.neglected[i] * self.neglected[i];
            RESERVE * variance.sqrt()
        });
        // A free vibration turns an error of q̇ into one of q and back.
        let vibration = [q + v / bodies.bound.stiffness().sqrt(), v + q * bodies.relative.stiffness().sqrt()];
        let drift = z + (self.elapsed + ahead) * y;
        let parts = [(drift + vibration[0]) / place, if speed > 0.0 { (y + vibration[1]) / speed } else { 0.0 }];
        // NaN is none of these, and output values are themselves rounded.
        let kept = parts.iter().all(|&part| part < 1.0);
        if kept { (parts[0].max(parts[1]) + self.rounding).min(1.0) } else { 1.0 }
    }
}
