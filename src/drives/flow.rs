//! Arguments of the equations of vibrations on a turning drive.

use crate::numerics::taylor::Series;

/// Drive and vibration at an instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Flow<S> {
    /// φ (rad), reduced by whole turns.
    pub phi: S,
    /// ω = φ̇ (rad/s).
    pub w: S,
    /// α = φ̈ (rad/s²).
    pub a: S,
    /// q (rad or m).
    pub q: S,
    /// q̇ (rad/s or m/s).
    pub v: S,
}

impl Flow<f64> {
    /// As a function of φ, all else held.
    pub fn over_angle(&self) -> Flow<Series> {
        let Flow { phi, w, a, q, v } = *self;
        Flow { phi: Series([phi, 1.0, 0.0]), w: w.into(), a: a.into(), q: q.into(), v: v.into() }
    }
}
