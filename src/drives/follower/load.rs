//! Loads on a mass.
//!
//! F_L(y, ẏ, φ, t) = m g + F₀ − F_v − c (y − y₀) − b ẏ + P(φ) + F(t)
//!
//! Symbols: y place of the mass (m or rad), F_L sum of the loads (N or N·m), positive in the sense of y; m the mass (kg or kg·m²),
//! g gravity along y (m/s²), F₀ a constant force, F_v and c preload (at y₀) and stiffness of a return spring, b damping to the
//! ground, P process force over the angle φ of the drive, F an input of the FMU.
//!
//! Loads that a scene leaves out are None: they cost nothing and have no variable. Valid for linear springs and dampers; P is taken
//! at the angle of the drive also where the cam sits behind an elastic shaft.

use crate::drives::Fault;
use crate::motion::MotionLaw;
use crate::numerics::taylor::Arithmetic;
use serde::{Deserialize, Serialize};

/// The loads on one mass.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Load {
    /// g (m/s²), the component along y.
    pub gravity: Option<f64>,
    /// g (m/s²) in the frame of each mechanism before the tool, for its links; empty without mechanisms. `gravity` is the tool's.
    pub frames: Vec<[f64; 2]>,
    /// F₀.
    pub constant: Option<f64>,
    /// F_v, c, y₀.
    pub spring: Option<Spring>,
    /// b.
    pub damping: Option<f64>,
    /// P(φ).
    pub process: Option<MotionLaw>,
    /// Whether F is an input.
    pub input: bool,
}

/// A return spring.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Spring {
    /// F_v: force at `at`, positive against y.
    pub preload: f64,
    /// c.
    pub c: f64,
    /// y₀.
    pub at: f64,
}

impl Load {
    /// Whether it is empty.
    pub fn is_none(&self) -> bool {
        *self == Load::default()
    }

    /// Refuses a process force whose parameters make no law; the load has this `name`.
    pub fn validate(&self, name: &str) -> Result<(), Fault> {
        self.process.as_ref().map_or(Ok(()), MotionLaw::validate).map_err(|message| {
            let name = format!("{name}.process");
            Fault::new(format!("{name}: {message}")).of(name)
        })
    }

    /// Conditions of the text: the parts of F_L.
    pub fn conditions(&self) -> [(&'static str, bool); 6] {
        [
            ("gravity", self.gravity.is_some()),
            ("constant", self.constant.is_some()),
            ("spring", self.spring.is_some()),
            ("damping", self.damping.is_some()),
            ("process", self.process.is_some()),
            ("F", self.input),
        ]
    }

    /// c of the return spring; 0 without one.
    pub fn stiffness(&self) -> f64 {
        self.spring.map_or(0.0, |spring| spring.c)
    }

    /// The part that depends neither on y nor on time, on the mass `m`: m g + F₀ − F_v + c y₀.
    pub fn constant_part(&self, m: f64) -> f64 {
        let spring = self.spring.map_or(0.0, |spring| spring.c * spring.at - spring.preload);
        m * self.gravity.unwrap_or(0.0) + self.constant.unwrap_or(0.0) + spring
    }

    /// The force in the sense of y with which spring, gravity and constant force press on the mass `m` at y.
    pub fn hold(&self, m: f64, y: f64) -> f64 {
        self.constant_part(m) - self.stiffness() * y
    }

    /// F_L on the mass `m` at y, ẏ, with P = `process` and F = `input`.
    pub fn force<S: Arithmetic>(&self, m: f64, [y, v]: [S; 2], process: Option<S>, input: Option<S>) -> S {
        let spring = self.spring.map(|spring| -((y - S::from(spring.at)) * spring.c));
        let damping = self.damping.map(|b| -(v * b));
        let still = m * self.gravity.unwrap_or(0.0) + self.constant.unwrap_or(0.0)
            - self.spring.map_or(0.0, |spring| spring.preload);
        [spring, damping, process, input].into_iter().flatten().fold(S::from(still), |sum, part| sum + part)
    }

    /// The sum of the sizes of the parts of F_L.
    pub fn size(&self, m: f64, [y, v]: [f64; 2], process: Option<f64>, input: Option<f64>) -> f64 {
        let spring = self.spring.map_or(0.0, |Spring { preload, c, at }| preload.abs() + c * (y.abs() + at.abs()));
        let constant = (m * self.gravity.unwrap_or(0.0)).abs() + self.constant.unwrap_or(0.0).abs();
        let moved = (self.damping.unwrap_or(0.0) * v).abs() + process.unwrap_or(0.0).abs() + input.unwrap_or(0.0).abs();
        constant + spring + moved
    }

    /// The potential of gravity, F₀ and the spring (J).
    pub fn potential(&self, m: f64, y: f64) -> f64 {
        let spring = self.spring.map_or(0.0, |Spring { preload, c, at }| preload * y + 0.5 * c * (y - at).powi(2));
        spring - (m * self.gravity.unwrap_or(0.0) + self.constant.unwrap_or(0.0)) * y
    }
}
