//! What the equations of the vibrations on a turning drive are functions of.

/// Drive and vibration at an instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Flow<S> {
    /// φ [rad], reduced by whole turns.
    pub phi: S,
    /// ω = φ̇ [rad/s].
    pub w: S,
    /// α = φ̈ [rad/s²].
    pub a: S,
    /// q [rad or m].
    pub q: S,
    /// q̇ [rad/s or m/s].
    pub v: S,
}
