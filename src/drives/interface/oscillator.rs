//! The linear oscillation of a drive whose coefficients repeat themselves every turn.

use super::unit::Quantity;

/// m(φ) q̈ + [b(φ) + Ω b₁(φ)] q̇ + [c(φ) + Ω² c₂(φ)] q = f(φ) + Ω² f₂(φ) at φ = Ω t, one degree of freedom q.
///
/// Either b₁ = c₂ = 0, or the inertia turns with the drive: b₁ = m′ and c₂ = m″/2, as the kinetic energy ½ m ψ̇²
/// with m at ψ = φ + q has it.
pub struct PeriodicOscillator {
    /// The coefficients at an angle (rad) in [−2π, 2π], continued smoothly from a segment.
    pub terms: Box<dyn Fn(usize, f64) -> Terms + Send + Sync>,
    /// The angles in [0, 2π), ascending, at which a derivative of a coefficient jumps. Segment i reaches from
    /// breakpoint i to the next one, the last one around the turn; without breakpoints there is one segment.
    pub breakpoints: Vec<f64>,
    /// An angle (rad) over which the coefficients of a segment follow a polynomial of degree 8.
    pub reach: Box<dyn Fn(usize) -> f64 + Send + Sync>,
    /// Cost of the coefficients at an angle (nominal µs), see [`crate::numerics::work`].
    pub cost: f64,
    /// Whether b₁ = m′ and c₂ = m″/2.
    pub inertia_turns: bool,
    /// The speed Ω of the scene (rad/s); None where the drive follows its inputs.
    pub speed: Option<f64>,
    /// The angle at which the scene starts (rad).
    pub start: f64,
    /// Quantity of q.
    pub coordinate: &'static Quantity,
    /// Quantity of c q.
    pub load: &'static Quantity,
    /// How the equation comes from that of the scene where it is not the same: "linearised about q = 0".
    pub note: Option<String>,
}

/// The coefficients of [`PeriodicOscillator`] at an angle, coherent SI.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Terms {
    /// m (kg or kg·m²).
    pub m: f64,
    /// b (N·s/m or N·m·s/rad).
    pub b: f64,
    /// b₁ (kg/rad or kg·m²/rad).
    pub b1: f64,
    /// c (N/m or N·m/rad).
    pub c: f64,
    /// c₂ (kg/rad² or kg·m²/rad²).
    pub c2: f64,
    /// f (N or N·m).
    pub f: f64,
    /// f₂ (kg·m or kg·m²).
    pub f2: f64,
}
