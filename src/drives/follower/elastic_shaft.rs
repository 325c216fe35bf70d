//! The equation of motion of the twist, written once for numbers and for series.

use crate::drives::Fault;
use crate::drives::follower::equation::{Equation, Pace, Words};
use crate::drives::follower::flow::Flow;
use crate::drives::parameter::parameters;
use crate::motion::MotionLaw;
use crate::numerics::angle;
use crate::numerics::divisor::greatest_common_divisor;
use crate::numerics::double_double::Double;
use crate::numerics::taylor::Scalar;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// The angle over which a step of degree 8 may reach, times the resolution K of the law (rad): two radians of
/// the highest harmonic cannot hide between eight nodes.
pub const REACH: f64 = 2.0;

parameters! {
    /// Mass, inertia and shaft.
    Parameters, "elasticity" {
        /// Mass of the follower
        m = "m", "m", MASS in [0.0, 1e9], Tunable;
        /// Moment of inertia of the cam, at the far end of the shaft; above zero
        inertia = "J", "J", INERTIA in [1e-12, 1e9], Fixed;
        /// Torsional stiffness of the input shaft; above zero
        c = "c", "c", ROTATIONAL_STIFFNESS in [1e-12, 1e15], Tunable;
        /// Torsional damping of the input shaft
        b = "b", "b", ROTATIONAL_DAMPING in [0.0, 1e12] or 0.0, Tunable;
    }
}

/// The twist of the shaft.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Twist {
    /// m, J, c, b.
    pub parameters: Parameters,
    /// Whether the equation is linearised in q.
    pub linear: bool,
}

/// U … U⁗ and, for time derivatives of the linearised equation alone, U⁽⁵⁾ at the angle on which the cam acts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cam(pub [f64; 6]);

impl Equation for Twist {
    type Law = MotionLaw;
    type Parameters = Parameters;
    type Local = Cam;

    fn parameters(&self) -> Parameters {
        self.parameters
    }

    fn with(&self, parameters: Parameters) -> Self {
        Twist { parameters, ..*self }
    }

    fn prepare(&mut self, law: &MotionLaw) -> Result<(), Fault> {
        law.validate().map_err(|message| Fault::new(message).of("cam"))
    }

    fn is_linear(&self) -> bool {
        self.linear
    }

    fn linearised(&self) -> Self {
        Twist { linear: true, ..*self }
    }

    fn carries_law(&self) -> bool {
        !self.linear
    }

    fn is_undamped(&self) -> bool {
        self.parameters.b == 0.0
    }

    fn words(&self) -> Words {
        Words {
            quantity: "the twist q",
            turning: "the cam",
            parameters: "J, m, c, b",
            frequency: "c and J",
            damping: "b",
            instead: if self.linear { ", set shaft.linear = false" } else { "" },
        }
    }

    fn breakpoints(law: &MotionLaw) -> &[f64] {
        law.breakpoints()
    }

    fn at(&self, law: &MotionLaw, segment: usize, f: &Flow<f64>) -> Cam {
        let [u0, u1, u2, u3, u4] = law.at_in(segment, self.angle(f)).0;
        Cam([u0, u1, u2, u3, u4, 0.0])
    }

    /// q̈ (rad/s²).
    ///
    /// Nonlinear, U at ψ: (J + m U′²) ψ̈ = −(m U′U″ ψ̇² + b q̇ + c q).
    /// Linear (4.2), U at φ, g = U′U″:
    /// (J + m U′²)(q̈ + α) = −(m ω² g + (b + 2 m ω g) q̇ + (c + m ω² g′ + 2 m α g) q).
    fn acceleration<S: Scalar>(&self, cam: &Cam, f: &Flow<S>) -> S {
        let Parameters { m, inertia, c, b } = self.parameters;
        let [_, d1, d2, d3, d4, d5] = cam.0;
        let angle = f.argument(!self.linear);
        let (u1, u2) = (angle.compose([d1, d2, d3]), angle.compose([d2, d3, d4]));
        let inertia = u1 * u1 * m + S::from(inertia);
        let g = u1 * u2 * m;
        if self.linear {
            let g1 = (u2 * u2 + u1 * angle.compose([d3, d4, d5])) * m;
            let w2 = f.w * f.w;
            let stiffness = S::from(c) + w2 * g1 + f.a * g * 2.0;
            let damping = S::from(b) + f.w * g * 2.0;
            -(w2 * g + damping * f.v + stiffness * f.q) / inertia - f.a
        } else {
            let speed = f.cam_speed();
            -(g * speed * speed + f.v * b + f.q * c) / inertia - f.a
        }
    }

    fn jacobian(&self, cam: &Cam, f: &Flow<f64>) -> [f64; 2] {
        let Parameters { m, inertia, c, b } = self.parameters;
        let [_, u1, u2, u3, ..] = cam.0;
        let inertia = inertia + m * u1 * u1;
        let (g, g1) = (m * u1 * u2, m * (u2 * u2 + u1 * u3));
        if self.linear {
            let stiffness = c + f.w * f.w * g1 + 2.0 * f.a * g;
            [-stiffness / inertia, -(b + 2.0 * f.w * g) / inertia]
        } else {
            let speed = f.cam_speed();
            let torque = g * speed * speed + b * f.v + c * f.q;
            let by_q = -(g1 * speed * speed + c) + torque * 2.0 * g / inertia;
            [by_q / inertia, -(2.0 * g * speed + b) / inertia]
        }
    }

    /// Rounding error of q̈ from U′, U″ and α over the unit roundoff: |α| + m ψ̇² (|U″| max|U″| + |U′| max|U‴|)/(J + m U′²)
    /// (rad/s²), since the sine of the k-th multiple of an angle is rounded k times as much as the angle. Where the
    /// cam turns slowly the twist follows the forces of the follower, q̇ all but vanishes, and this is what remains of q̈.
    fn rounding(&self, law: &MotionLaw, segment: usize, f: &Flow<f64>) -> f64 {
        let Parameters { m, inertia, .. } = self.parameters;
        let [_, u1, u2, ..] = self.at(law, segment, f).0;
        // Those of the segment: beside a steep rise a gentle return would count all it errs by as rounding.
        let [largest2, largest3] = [2, 3].map(|order| law.bound_in(segment, order));
        let speed = f.turning(!self.linear);
        let products = u2.abs() * largest2 + u1.abs() * largest3;
        m * speed * speed * products / (inertia + m * u1 * u1) + f.a.abs()
    }

    fn roundings(&self, law: &MotionLaw) -> f64 {
        let ([slope, curvature], [u1, u2]) = (law.roundings(), [1, 2].map(|order| law.bound(order)));
        self.parameters.m * (u1 * curvature + u2 * slope) / self.parameters.inertia
    }

    fn reach(&self, law: &MotionLaw, segment: usize, _: f64) -> f64 {
        REACH / law.resolution_in(segment).max(1.0)
    }

    /// U′², U′U″ and U″² + U′U‴ repeat themselves after an equal part of the turn: their harmonics are the sums and
    /// differences of those of U, all of which are multiples of the greatest common divisor of 2 k₁ and k − k₁. Two parts
    /// for a law with odd harmonics alone.
    fn symmetry(&self, law: &MotionLaw) -> usize {
        let Some(series) = law.series() else { return 1 };
        let mut orders = (1..=series.order()).filter(|&k| series.a[k] != 0.0 || series.b[k] != 0.0);
        let Some(first) = orders.next() else { return 1 };
        orders.fold(2 * first, |divisor, k| greatest_common_divisor(divisor, k - first))
    }

    fn cost(&self, law: &MotionLaw) -> f64 {
        law.cost()
    }

    /// The vibration √(c/J); the angle from one breakpoint of the law to the next on the average, or 1/(2 K √(1 + m U′²max/J)),
    /// K the highest harmonic, whichever is smaller: J + m U′² has its complex zeros 1/K √(J/m)/U′max beside those of U′.
    /// The cam turns at |ω| and the speed that the vibration has now.
    fn pace(&self, law: &MotionLaw, [q, v]: [f64; 2]) -> Pace {
        let Parameters { m, inertia, c, .. } = self.parameters;
        let ratio = m * law.bound(1).powi(2) / inertia;
        let smooth = 0.5 / (law.resolution() * (1.0 + ratio).sqrt());
        let angle = smooth.min(TAU / law.breakpoints().len().max(1) as f64);
        let frequency = (c / inertia).sqrt();
        Pace { frequency, angle, speed: if self.linear { 0.0 } else { v.abs() + frequency * q.abs() } }
    }
}

impl Twist {
    fn angle(&self, f: &Flow<f64>) -> f64 {
        angle::reduce(Double::from(f.argument(!self.linear)))
    }

    /// The cam with U⁽⁵⁾.
    pub fn with_fifth(&self, law: &MotionLaw, segment: usize, f: &Flow<f64>) -> Cam {
        let mut cam = self.at(law, segment, f);
        cam.0[5] = law.fifth_in(segment, self.angle(f));
        cam
    }

    /// y = U(ψ), or U + U′ q where the equation is linearised (m).
    pub fn lift<S: Scalar>(&self, cam: &Cam, f: &Flow<S>) -> S {
        let [d0, d1, d2, d3, ..] = cam.0;
        let angle = f.argument(!self.linear);
        let u = angle.compose([d0, d1, d2]);
        if self.linear { u + angle.compose([d1, d2, d3]) * f.q } else { u }
    }

    /// ẏ = U′ ψ̇, or (U′ + U″ q) ω + U′ q̇ (m/s).
    pub fn lift_speed<S: Scalar>(&self, cam: &Cam, f: &Flow<S>) -> S {
        let [_, d1, d2, d3, d4, _] = cam.0;
        let angle = f.argument(!self.linear);
        let u1 = angle.compose([d1, d2, d3]);
        if self.linear { (u1 + angle.compose([d2, d3, d4]) * f.q) * f.w + u1 * f.v } else { u1 * f.cam_speed() }
    }

    /// tau = −(c q + b q̇) (N·m).
    pub fn torque<S: Scalar>(&self, q: S, v: S) -> S {
        -(q * self.parameters.c + v * self.parameters.b)
    }
}
