//! Input signals that the host feeds into a drive.

use std::f64::consts::{PI, TAU};

/// The highest order of input derivatives that the host sets, as far as the drive takes them.
pub const HIGHEST_DERIVATIVE: usize = 8;

/// A run-up from standstill to a speed, and on at that speed.
///
/// w = Ω (z − sin(2πz)/2π), z = t/T; for t ≥ T w = Ω. The acceleration starts and ends without a jump (Bestehorn's sinoid). It
/// is no polynomial, so the communication step matters to a host that passes values only.
///
/// Symbols: Ω the speed (rad/s), T the duration of the run-up (s).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RunUp {
    /// Ω (rad/s).
    pub speed: f64,
    /// T (s).
    pub ramp: f64,
}

impl RunUp {
    /// True if the ramp has ended at `t` (s); a communication point at its end may be a rounding too early.
    fn over(&self, t: f64) -> bool {
        t >= self.ramp * (1.0 - 1e-12)
    }

    /// φ(t) (rad).
    pub fn angle(&self, t: f64) -> f64 {
        let &RunUp { speed, ramp } = self;
        if self.over(t) {
            return speed * (t - 0.5 * ramp);
        }
        // z²/2 − (1 − cos 2πz)/4π², where the difference of the cosine is 2 sin²(πz).
        let (z, s) = (t / ramp, (PI * t / ramp).sin() / TAU);
        speed * ramp * (0.5 * z * z - 2.0 * s * s)
    }

    /// w(t) (rad/s).
    pub fn speed(&self, t: f64) -> f64 {
        let z = t / self.ramp;
        if self.over(t) { self.speed } else { self.speed * (z - (TAU * z).sin() / TAU) }
    }

    /// The derivative of order `order` ≥ 0 of the acceleration a = ẇ (rad/s²⁺ᵒʳᵈᵉʳ), for the time after `t`.
    pub fn acceleration(&self, t: f64, order: usize) -> f64 {
        if self.over(t) {
            return 0.0;
        }
        let rate = TAU / self.ramp;
        let x = rate * t;
        let scale = self.speed / self.ramp;
        match order {
            0 => 2.0 * scale * (0.5 * x).sin().powi(2),
            // −cos⁽ⁿ⁾ x.
            n => -scale * rate.powi(n as i32) * [x.cos(), -x.sin(), -x.cos(), x.sin()][n % 4],
        }
    }
}

/// An input and its motion in the run-up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Signal {
    /// `phi`.
    Angle,
    /// `w`.
    Speed,
    /// `a`; if present, the only motion input that gets derivatives: the others' follow.
    Acceleration,
    /// `M_an`: the inertia at the start times the acceleration.
    Torque,
    /// Any other input keeps its start value.
    Constant,
}

impl Signal {
    /// The signal of the input with this name.
    pub fn of(name: &str) -> Self {
        match name {
            "phi" => Signal::Angle,
            "w" => Signal::Speed,
            "a" => Signal::Acceleration,
            "M_an" => Signal::Torque,
            _ => Signal::Constant,
        }
    }

    /// The derivative of this order at `t` (s), the value for order 0; `inertia` is J at the start (kg·m²). None if the host
    /// sets none.
    pub fn derivative(self, run_up: &RunUp, inertia: f64, t: f64, order: usize) -> Option<f64> {
        match (self, order) {
            (Signal::Angle, 0) => Some(run_up.angle(t)),
            (Signal::Speed, 0) => Some(run_up.speed(t)),
            (Signal::Speed, _) => Some(run_up.acceleration(t, order - 1)),
            (Signal::Acceleration, _) => Some(run_up.acceleration(t, order)),
            (Signal::Torque, _) => Some(inertia * run_up.acceleration(t, order)),
            (Signal::Angle | Signal::Constant, _) => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_run_up_is_its_own_derivative() {
        let run_up = RunUp { speed: 7.0, ramp: 0.5 };
        let h = 1e-4;
        for i in 1..50 {
            let t = 0.011 * f64::from(i);
            let slope = |f: &dyn Fn(f64) -> f64| (f(t + h) - f(t - h)) / (2.0 * h);
            let close = |a: f64, b: f64, scale: f64| assert!((a - b).abs() < 1e-5 * scale, "{t}: {a} {b}");
            close(slope(&|t| run_up.angle(t)), run_up.speed(t), 7.0);
            close(slope(&|t| run_up.speed(t)), run_up.acceleration(t, 0), 14.0);
            if (t - 0.5).abs() > 2.0 * h {
                for n in 0..4 {
                    let scale = 14.0 * (TAU / 0.5).powi(n as i32 + 1);
                    close(slope(&|t| run_up.acceleration(t, n)), run_up.acceleration(t, n + 1), scale);
                }
            }
        }
        assert_eq!((run_up.angle(0.0), run_up.speed(0.0), run_up.acceleration(0.0, 0)), (0.0, 0.0, 0.0));
        assert!((run_up.angle(0.5) - 1.75).abs() < 1e-15 && run_up.speed(3.0) == 7.0);
    }
}
