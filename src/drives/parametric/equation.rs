//! The equation of motion, written once for numbers and for series.

use super::coefficients::{Coefficients, Values};
use crate::drives::cam_drive::AngleMotion;
pub use crate::drives::flow::Flow;
use crate::drives::step_control::Words;
use crate::numerics::collocation::{Collocation, System};
use crate::numerics::double_double::Double;
use crate::numerics::taylor::Scalar;

/// Names of this drive's quantities in messages.
pub const WORDS: Words = Words {
    quantity: "q",
    turning: "the drive",
    parameters: "the coefficients",
    frequency: "the stiffness and the mass",
};

impl Values {
    /// q̈ = (f − b q̇ − c q)/m, less α where q counts from the drive.
    pub fn acceleration<S: Scalar>(&self, flow: &Flow<S>, relative: bool) -> S {
        let acceleration =
            (of(flow, &self.f) - of(flow, &self.b) * flow.v - of(flow, &self.c) * flow.q) / of(flow, &self.m);
        if relative { acceleration - flow.a } else { acceleration }
    }

    /// −(c q + b q̇): the force that spring and damper transmit (N·m or N).
    pub fn transmitted<S: Scalar>(&self, flow: &Flow<S>) -> S {
        -(of(flow, &self.c) * flow.q + of(flow, &self.b) * flow.v)
    }

    /// ½ (m′ q̇² + c′ q²): the torque by which the drive feeds ½ m q̇² + ½ c q² where m and c vary (N·m).
    pub fn parametric_torque<S: Scalar>(&self, flow: &Flow<S>) -> S {
        (slope(flow, &self.m) * flow.v * flow.v + slope(flow, &self.c) * flow.q * flow.q) * 0.5
    }

    /// c (N·m/rad or N/m).
    pub fn stiffness<S: Scalar>(&self, flow: &Flow<S>) -> S {
        of(flow, &self.c)
    }
}

fn of<S: Scalar>(flow: &Flow<S>, &[d0, d1, d2, _]: &[f64; 4]) -> S {
    flow.phi.compose([d0, d1, d2])
}

fn slope<S: Scalar>(flow: &Flow<S>, &[_, d1, d2, d3]: &[f64; 4]) -> S {
    flow.phi.compose([d1, d2, d3])
}

/// The vibration as a system of first order, y = (q, q̇), on a motion of the drive.
pub struct Vibration<'a> {
    /// m, b, c, f.
    pub coefficients: &'a Coefficients,
    /// Whether q counts from the drive.
    pub relative: bool,
    /// φ(t).
    pub motion: &'a AngleMotion,
}

impl Vibration<'_> {
    fn flow(&self, t: Double, y: &[f64; 2]) -> Flow<f64> {
        let shaft = self.motion.at_instant(t);
        let [_, w, a, ..] = shaft.kinematics.0;
        Flow { phi: shaft.reduced, w, a, q: y[0], v: y[1] }
    }

    /// ∂q̈/∂φ at the end of the last step (1/s²).
    pub fn slope(&self, integrator: &Collocation<2>) -> f64 {
        let flow = self.flow(integrator.end(), &integrator.state());
        self.coefficients.at(flow.phi).acceleration(&flow.over_angle(), self.relative).derivative(1)
    }
}

impl System<2> for Vibration<'_> {
    fn rhs(&self, t: Double, y: &[f64; 2]) -> [f64; 2] {
        let flow = self.flow(t, y);
        [y[1], self.coefficients.at(flow.phi).acceleration(&flow, self.relative)]
    }

    fn jacobian(&self, t: Double, y: &[f64; 2]) -> [[f64; 2]; 2] {
        let Values { m, b, c, .. } = self.coefficients.at(self.flow(t, y).phi);
        [[0.0, 1.0], [-c[0] / m[0], -b[0] / m[0]]]
    }

    fn longest_step(&self, t: Double, y: &[f64; 2]) -> f64 {
        let Flow { phi, w, a, .. } = self.flow(t, y);
        let reach = self.coefficients.reach(phi);
        (reach / w.abs()).min((2.0 * reach / a.abs()).sqrt())
    }
}
