//! The equation of motion of the twist, written once for numbers and for series.

use super::Parameters;
pub use crate::drives::flow::Flow;
use crate::motion::MotionLaw;
use crate::numerics::taylor::Scalar;

/// The parameters of the equation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Equation {
    /// Mass of the follower m (kg).
    pub m: f64,
    /// Moment of inertia of the cam J (kg·m²).
    pub inertia: f64,
    /// Stiffness of the shaft c (N·m/rad).
    pub c: f64,
    /// Damping of the shaft b (N·m·s/rad).
    pub b: f64,
    /// Whether the equation is linearised in q.
    pub linear: bool,
}

/// U … U⁗ and, for time derivatives of the linearised equation alone, U⁽⁵⁾ at the angle on which the cam acts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cam(pub [f64; 6]);

impl<S: Scalar> Flow<S> {
    /// ψ̇ = ω + q̇.
    pub fn cam_speed(&self) -> S {
        self.w + self.v
    }

    /// The angle at which the transfer functions are taken: φ where the equation is linearised, else ψ = φ + q.
    pub fn argument(&self, linear: bool) -> S {
        if linear { self.phi } else { self.phi + self.q }
    }

    /// The rate of this angle.
    pub fn turning(&self, linear: bool) -> S {
        if linear { self.w } else { self.cam_speed() }
    }
}

impl Equation {
    /// The equation with these parameters.
    pub fn new(&Parameters { m, inertia, c, b }: &Parameters, linear: bool) -> Self {
        Equation { m, inertia, c, b, linear }
    }

    /// q̈ (rad/s²).
    ///
    /// Nonlinear, U at ψ: (J + m U′²) ψ̈ = −(m U′U″ ψ̇² + b q̇ + c q).
    /// Linear (4.2), U at φ, g = U′U″:
    /// (J + m U′²)(q̈ + α) = −(m ω² g + (b + 2 m ω g) q̇ + (c + m ω² g′ + 2 m α g) q).
    /// Without forcing (`forced` = 0 instead of 1) the linear equation is the homogeneous one.
    pub fn acceleration<S: Scalar>(&self, cam: &Cam, f: &Flow<S>, forced: f64) -> S {
        let [_, d1, d2, d3, d4, d5] = cam.0;
        let angle = f.argument(self.linear);
        let (u1, u2) = (angle.compose([d1, d2, d3]), angle.compose([d2, d3, d4]));
        let inertia = u1 * u1 * self.m + S::from(self.inertia);
        let g = u1 * u2 * self.m;
        if self.linear {
            let g1 = (u2 * u2 + u1 * angle.compose([d3, d4, d5])) * self.m;
            let w2 = f.w * f.w;
            let stiffness = S::from(self.c) + w2 * g1 + f.a * g * 2.0;
            let damping = S::from(self.b) + f.w * g * 2.0;
            -(w2 * g * forced + damping * f.v + stiffness * f.q) / inertia - f.a * forced
        } else {
            let speed = f.cam_speed();
            -(g * speed * speed + f.v * self.b + f.q * self.c) / inertia - f.a
        }
    }

    /// ∂q̈/∂q (1/s²) and ∂q̈/∂q̇ (1/s).
    pub fn jacobian(&self, cam: &Cam, f: &Flow<f64>) -> [f64; 2] {
        let [_, u1, u2, u3, ..] = cam.0;
        let inertia = self.inertia + self.m * u1 * u1;
        let (g, g1) = (self.m * u1 * u2, self.m * (u2 * u2 + u1 * u3));
        if self.linear {
            let stiffness = self.c + f.w * f.w * g1 + 2.0 * f.a * g;
            [-stiffness / inertia, -(self.b + 2.0 * f.w * g) / inertia]
        } else {
            let speed = f.cam_speed();
            let torque = g * speed * speed + self.b * f.v + self.c * f.q;
            let by_q = -(g1 * speed * speed + self.c) + torque * 2.0 * g / inertia;
            [by_q / inertia, -(2.0 * g * speed + self.b) / inertia]
        }
    }

    /// ∂q̈/∂φ (1/s²).
    pub fn slope(&self, cam: &Cam, f: &Flow<f64>) -> f64 {
        self.acceleration(cam, &f.over_angle(), 1.0).derivative(1)
    }

    /// Rounding error of q̈ from U′, U″ and α over the unit roundoff: |α| + m ψ̇² (|U″| max|U″| + |U′| max|U‴|)/(J + m U′²)
    /// (rad/s²), since the sine of the k-th multiple of an angle is rounded k times as much as the angle. Where the
    /// cam turns slowly the twist follows the forces of the follower, q̇ all but vanishes, and this is what remains of q̈.
    pub fn rounding(&self, cam: &Cam, f: &Flow<f64>, [largest2, largest3]: [f64; 2]) -> f64 {
        let [_, u1, u2, ..] = cam.0;
        let speed = if self.linear { f.w } else { f.cam_speed() };
        let products = u2.abs() * largest2 + u1.abs() * largest3;
        self.m * speed * speed * products / (self.inertia + self.m * u1 * u1) + f.a.abs()
    }

    /// y = U(ψ), or U + U′ q where the equation is linearised (m).
    pub fn lift<S: Scalar>(&self, cam: &Cam, f: &Flow<S>) -> S {
        let [d0, d1, d2, d3, ..] = cam.0;
        let angle = f.argument(self.linear);
        let u = angle.compose([d0, d1, d2]);
        if self.linear { u + angle.compose([d1, d2, d3]) * f.q } else { u }
    }

    /// ẏ = U′ ψ̇, or (U′ + U″ q) ω + U′ q̇ (m/s).
    pub fn lift_speed<S: Scalar>(&self, cam: &Cam, f: &Flow<S>) -> S {
        let [_, d1, d2, d3, d4, _] = cam.0;
        let angle = f.argument(self.linear);
        let u1 = angle.compose([d1, d2, d3]);
        if self.linear { (u1 + angle.compose([d2, d3, d4]) * f.q) * f.w + u1 * f.v } else { u1 * f.cam_speed() }
    }

    /// tau = −(c q + b q̇) (N·m).
    pub fn torque<S: Scalar>(&self, q: S, v: S) -> S {
        -(q * self.c + v * self.b)
    }
}

impl Cam {
    /// The transfer functions of `law` at `angle` without U⁽⁵⁾.
    pub fn at(law: &MotionLaw, segment: usize, angle: f64) -> Self {
        let [u0, u1, u2, u3, u4] = law.at_in(segment, angle).0;
        Cam([u0, u1, u2, u3, u4, 0.0])
    }

    /// The transfer functions of `law` at `angle` with U⁽⁵⁾.
    pub fn with_fifth(law: &MotionLaw, segment: usize, angle: f64) -> Self {
        let mut cam = Self::at(law, segment, angle);
        cam.0[5] = law.fifth_in(segment, angle);
        cam
    }
}
