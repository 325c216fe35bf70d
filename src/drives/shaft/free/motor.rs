//! Motor of the machine: none, an asynchronous motor after Kloss, or a torque from outside.

use crate::drives::limits::FASTEST;
use crate::drives::parameter::parameters;
use crate::numerics::taylor::Scalar;
use serde::{Deserialize, Serialize};

/// The source of the driving torque M_an.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Motor {
    /// M_an = 0.
    #[default]
    None,
    /// An asynchronous motor.
    Kloss(Kloss),
    /// M_an is an input.
    Input,
}

/// The admissible T_el (s).
pub const LAG: [f64; 2] = [1e-9, 1e3];

/// An asynchronous motor, reduced to the shaft of the machine (gear ratio included).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Kloss {
    /// Breakdown torque M_K (N·m).
    pub breakdown_torque: f64,
    /// Breakdown slip s_K (1), positive.
    pub breakdown_slip: f64,
    /// Synchronous speed w_s (rad/s), not zero; negative turns the machine backwards.
    pub synchronous_speed: f64,
    /// Electrical time constant T_el (s) of a torque that lags behind the characteristic; None without lag.
    pub dynamics: Option<f64>,
}

parameters! {
    for Kloss, "motor" {
        /// Breakdown torque, at the shaft where there is no gear
        breakdown_torque = "motor.M_k", "M_k", TORQUE in [0.0, 1e12], Fixed;
        /// Breakdown slip
        breakdown_slip = "motor.s_k", "s_k", NUMBER in [1e-9, 1e3], Fixed;
        /// Synchronous speed, at the shaft where there is no gear, not zero; negative turns the machine backwards
        synchronous_speed = "motor.w_s", "w_s", ANGULAR_VELOCITY in [-FASTEST, FASTEST], Fixed;
    }
}

/// The torque of an asynchronous motor after Kloss, and its derivatives of order 1 and 2 with respect to w.
///
/// M = sgn(w_s) 2 M_K s s_K / (s² + s_K²), s = (w_s − w) / w_s
///
/// Symbols: M torque on the shaft (N·m), positive in the sense of φ; M_K breakdown torque (N·m); s slip (1); s_K
/// breakdown slip (1); w speed of the shaft (rad/s); w_s synchronous speed (rad/s), w_s ≠ 0.
/// The rational form is regular at synchronism (s = 0), at standstill (s = 1), in reversal (s > 1: the torque opposes
/// the motion) and where the load drives the motor (s < 0: it brakes). Constant voltage, no stator resistance,
/// quasi-stationary currents.
///
/// Source: M. Kloss, "Drehmoment und Schlüpfung des Drehstrommotors", Archiv für Elektrotechnik 5 (1916) 59–87.
pub fn kloss(breakdown_torque: f64, breakdown_slip: f64, synchronous_speed: f64, w: f64) -> [f64; 3] {
    // σ = s / s_K; sgn(w_s) / w_s = 1 / |w_s| serves the derivatives.
    let sigma = (synchronous_speed - w) / (synchronous_speed * breakdown_slip);
    let rate = -1.0 / (synchronous_speed * breakdown_slip);
    // The branch in 1/σ keeps the powers finite at any slip.
    let [f, f1, f2] = if sigma.abs() <= 1.0 {
        let n = 1.0 / (1.0 + sigma * sigma);
        let s2 = sigma * sigma;
        [2.0 * sigma * n, 2.0 * (1.0 - s2) * n * n, 4.0 * sigma * (s2 - 3.0) * n * n * n]
    } else {
        let r = 1.0 / sigma;
        let r2 = r * r;
        let n = 1.0 / (1.0 + r2);
        [2.0 * r * n, 2.0 * r2 * (r2 - 1.0) * n * n, 4.0 * r * r2 * (1.0 - 3.0 * r2) * n * n * n]
    };
    let torque = breakdown_torque.copysign(breakdown_torque * synchronous_speed);
    [torque * f, torque * rate * f1, torque * rate * rate * f2]
}

impl Motor {
    /// The torque of the characteristic at the speed `w` with its derivatives of order 1 and 2; zero without one.
    pub fn characteristic(&self, w: f64) -> [f64; 3] {
        match *self {
            Motor::Kloss(Kloss { breakdown_torque, breakdown_slip, synchronous_speed, .. }) => {
                kloss(breakdown_torque, breakdown_slip, synchronous_speed, w)
            }
            Motor::None | Motor::Input => [0.0; 3],
        }
    }

    /// σ, the sense in which a motor with a characteristic turns the shaft.
    pub fn sense(&self) -> f64 {
        match *self {
            Motor::Kloss(Kloss { synchronous_speed, .. }) => synchronous_speed.signum(),
            Motor::None | Motor::Input => 1.0,
        }
    }

    /// The characteristic as part of an output equation.
    pub fn torque<S: Scalar>(&self, w: S) -> S {
        w.compose(self.characteristic(w.value()))
    }

    /// M_an at the speed `w`; `known` is its value if it is an input or a state.
    pub fn driving<S: Scalar>(&self, w: S, known: S) -> S {
        match self {
            Motor::Kloss(Kloss { dynamics: None, .. }) => self.torque(w),
            Motor::None | Motor::Kloss(_) | Motor::Input => known,
        }
    }

    /// T_el (s) of a motor whose torque is a state.
    pub fn lag(&self) -> Option<f64> {
        match *self {
            Motor::Kloss(Kloss { dynamics, .. }) => dynamics,
            Motor::None | Motor::Input => None,
        }
    }
}
