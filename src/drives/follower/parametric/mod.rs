//! The equation of motion, written once for numbers and for series.

pub mod coefficients;
pub mod crank;
pub mod law;

use crate::drives::follower::equation::{Equation, Pace, Segments, Words};
use crate::drives::follower::flow::Flow;
use crate::drives::limits::refused_start;
use crate::drives::{Fault, Number};
use crate::numerics::taylor::Scalar;
use coefficients::{Coefficients, Values};
use law::Law;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

impl Values {
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

/// The vibration, as the law of the drive has it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Vibration {
    /// m, b, c and f after the law; shared by all instances with the same ones.
    pub coefficients: Arc<Coefficients>,
    /// Whether q counts from the drive.
    pub relative: bool,
    /// √(max c/min m), and half a radian of the highest harmonic of the coefficients (near a dip of the crank's stiffness an
    /// eighth of its width).
    pace: Pace,
}

impl Vibration {
    /// That of this law.
    pub fn of(law: &Law) -> Self {
        let coefficients = law.coefficients();
        let (frequency, angle) = (coefficients.highest_frequency(), 0.25 * coefficients.least_reach());
        let pace = Pace { frequency, angle, speed: 0.0 };
        Vibration { coefficients: Arc::new(coefficients), relative: law.is_relative(), pace }
    }
}

impl Equation for Vibration {
    type Law = Law;
    type Parameters = ();
    type Local = Values;

    fn parameters(&self) {}

    fn with(&self, (): ()) -> Self {
        self.clone()
    }

    fn prepare(&mut self, law: &Law) -> Result<(), Fault> {
        let anew = Vibration::of(law);
        if *self != anew {
            *self = anew;
        }
        law.validate()
    }

    fn is_undamped(&self) -> bool {
        self.coefficients.b.bound(0) == 0.0
    }

    fn words(&self) -> Words {
        Words {
            quantity: "q",
            turning: "the drive",
            parameters: "the coefficients",
            frequency: "the stiffness and the mass",
            damping: if self.relative { "b_T" } else { "b" },
            instead: "",
        }
    }

    fn at(&self, _: &Law, _: Segments, f: &Flow<f64>) -> Values {
        self.coefficients.at(f.phi)
    }

    fn base<S: Scalar>(&self, _: &Values, f: &Flow<S>) -> [S; 2] {
        if self.relative { [f.phi, f.w] } else { [S::from(0.0); 2] }
    }

    /// q̈ = (f − b q̇ − c q)/m, less α where q counts from the drive.
    fn acceleration<S: Scalar>(&self, values: &Values, flow: &Flow<S>) -> S {
        let Values { m, b, c, f } = values;
        let acceleration = (of(flow, f) - of(flow, b) * flow.v - of(flow, c) * flow.q) / of(flow, m);
        if self.relative { acceleration - flow.a } else { acceleration }
    }

    fn jacobian(&self, Values { m, b, c, .. }: &Values, _: &Flow<f64>) -> [f64; 2] {
        [-c[0] / m[0], -b[0] / m[0]]
    }

    fn reach(&self, _: &Law, _: Segments, phi: f64) -> f64 {
        self.coefficients.reach(phi)
    }

    fn symmetry(&self, _: &Law) -> usize {
        self.coefficients.symmetry()
    }

    fn cost(&self, _: &Law) -> f64 {
        self.coefficients.cost()
    }

    fn pace(&self, _: &Law, _: [f64; 2]) -> Pace {
        self.pace
    }

    /// q = f/c.
    fn at_rest(&self, _: &Law, flow: &Flow<f64>) -> Result<[f64; 2], Fault> {
        let Values { b, c, f, .. } = self.coefficients.at(flow.phi);
        if b[0] > 0.0 && c[0] > 0.0 {
            return Ok([f[0] / c[0], 0.0]);
        }
        Err(refused_start(format!(
            "start.mode = steady_state is refused at drive.w = {} rad/s: with a stiffness of {} and a damping of {} at \
             drive.phi_start no motion comes to rest; both must be above 0",
            Number(flow.w),
            Number(c[0]),
            Number(b[0])
        )))
    }
}
