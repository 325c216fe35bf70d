//! Arguments of the equations of vibrations on a turning drive.

use crate::numerics::taylor::{Scalar, Series};

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
    /// F (N or N·m), an input of the FMU; 0 without one.
    pub force: S,
}

impl<S: Scalar> Flow<S> {
    /// ψ̇ = ω + q̇.
    pub fn cam_speed(&self) -> S {
        self.w + self.v
    }

    /// The angle of the law: ψ = φ + q if the oscillator carries it, else φ.
    pub fn argument(&self, carried: bool) -> S {
        if carried { self.phi + self.q } else { self.phi }
    }

    /// The rate of this angle.
    pub fn turning(&self, carried: bool) -> S {
        if carried { self.cam_speed() } else { self.w }
    }
}

impl Flow<f64> {
    /// The arguments as functions of φ, with everything else constant.
    pub fn over_angle(&self) -> Flow<Series> {
        let Flow { phi, w, a, q, v, force } = *self;
        let phi = Series([phi, 1.0, 0.0]);
        Flow { phi, w: w.into(), a: a.into(), q: q.into(), v: v.into(), force: force.into() }
    }
}
