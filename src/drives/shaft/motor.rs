//! Motors with their transmission: the torque on the shaft.
//!
//! All data are the rotor's: angle φ_m, speed ω_m = φ̇_m, torque M. Stiff, ω_m = i φ̇ and M_an = i M; its rotor adds i² J_m to the
//! shaft's inertia. With a coupling or belt of stiffness c_k and damping b_k, both at the shaft,
//!
//! J_m φ̈_m = M(φ̇_m) − T_k/i,  M_an = T_k = c_k θ + b_k θ̇,  θ = φ_m/i − φ.
//!
//! | kind | M | state |
//! |---|---|---|
//! | constant, input | as given | – |
//! | table | monotone cubic over ω_m, constant beyond its ends | – |
//! | Kloss | sgn(ω_s) 2 M_K s s_K/(s² + s_K²), s = (ω_s − ω_m)/ω_s; with a lag T_el Ṁ = M_Kloss − M | M with a lag |
//! | servo | clip(u, ±M_max), u = K_p (ω_ref + K_v e − ω_m) + I, İ = K_i (ω_ref + K_v e − ω_m) − K_aw (u − M) | I, and ∫ω_ref with K_v |
//!
//! with e = φ_ref − φ_m, φ_ref = φ_m(0) + ∫ω_ref dt, or an input if ω_ref is one.
//!
//! Symbols: i = ω_m/φ̇ ratio, not zero, negative if the rotor turns the other way; J_m (kg·m²); K_p (N·m·s), K_i (N·m), K_aw and
//! K_v (1/s). Source: M. Kloss, Archiv für Elektrotechnik 5 (1916) 59–87; F. N. Fritsch, J. Butland, SIAM J. Sci. Stat. Comput. 5
//! (1984) 300–304; K. J. Åström, T. Hägglund, *PID Controllers*, section 3.5 (back-calculation).

use super::free::motor::Kloss;
use crate::motion::Fourier;
use serde::{Deserialize, Serialize};

/// A motor with its transmission.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Motor {
    /// The source of the torque.
    pub source: Source,
    /// i, J_m, coupling.
    pub transmission: Transmission,
}

/// The source of the rotor's torque.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Source {
    /// M = 0.
    #[default]
    None,
    /// M is an input.
    Input,
    /// M (N·m) is constant.
    Constant(f64),
    /// M(ω_m).
    Table(TorqueTable),
    /// An asynchronous motor.
    Kloss(Kloss),
    /// A controlled motor.
    Servo(Servo),
}

/// Points of a torque over the speed, which ascends.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TorqueTable {
    /// ω_m (rad/s).
    pub speeds: Vec<f64>,
    /// M (N·m).
    pub torques: Vec<f64>,
}

/// A speed control of PI kind with limited torque, with or without a position loop.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Servo {
    /// K_p (N·m·s/rad).
    pub proportional: f64,
    /// K_i (N·m/rad).
    pub integral: f64,
    /// K_aw (1/s).
    pub anti_windup: f64,
    /// M_max (N·m).
    pub limit: f64,
    /// ω_ref.
    pub reference: Reference,
    /// K_v (1/s) of the position loop.
    pub position: Option<f64>,
}

/// The speed that a servo is to keep.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Reference {
    /// ω_ref (rad/s) is constant.
    Constant(f64),
    /// ω_ref = Σ Aₖ cos kνt + Bₖ sin kνt (rad/s) over the time of the FMU, ν (rad/s) first.
    Series(f64, Fourier),
    /// A ramp from rest: ω_ref = r t (rad/s), r (rad/s²).
    Ramp(f64),
    /// Inputs.
    Input,
}

/// The transmission between rotor and shaft.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Transmission {
    /// i.
    pub ratio: f64,
    /// J_m (kg·m²).
    pub rotor: f64,
    /// c_k (N·m/rad) and b_k (N·m·s/rad) at the shaft.
    pub coupling: Option<[f64; 2]>,
}

impl Default for Transmission {
    fn default() -> Self {
        Transmission { ratio: 1.0, rotor: 0.0, coupling: None }
    }
}
