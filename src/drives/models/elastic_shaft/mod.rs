//! A cam drive whose input shaft is elastic.
//!
//! The drive turns the near end of the shaft by φ(t); its far end carries the cam, at ψ = φ + q, which moves the
//! follower to y = U(ψ).
//!
//! Nonlinear: (J + m U′²) ψ̈ + m U′U″ ψ̇² + b q̇ + c q = 0, U at ψ.
//! Linear in q, U at φ, ω = φ̇, α = φ̈: (J + m U′²) q̈ + (b + 2 m ω U′U″) q̇
//! + \[c + m ω² (U″² + U′U‴) + 2 m α U′U″\] q = −m ω² U′U″ − (J + m U′²) α.
//!
//! Loads on the follower add the torque U′ F_L(U, U′ψ̇, φ, t) to the right-hand side, see [`load`](crate::drives::follower::load).
//!
//! Symbols: m mass of the follower (kg), J moment of inertia of the cam (kg·m²), c stiffness (N·m/rad) and b damping (N·m·s/rad) of
//! the shaft, q twist (rad). Signs: φ, ψ, tau positive in the same sense; tau = −(c q + b q̇) is the torque from the drive into the
//! cam unit and loads the drive if it is positive.
//!
//! Validity: the follower never leaves the cam; the linear equation needs |q| small against the angle over which U′U″ changes. J >
//! 0: without it the frequency at U′ = 0 is infinite.
//!
//! Source: Dresig, Vulfson, *Dynamik der Mechanismen*, section 4.6.3; the right-hand side of its equation (1) reads
//! U′U″ here, as the derivation and its own rigid limit demand.

#[cfg(test)]
pub(super) mod tests;
mod variables;

use crate::drives::follower::elastic_shaft::Twist;
pub use crate::drives::follower::elastic_shaft::{Parameters, REACH};
use crate::drives::follower::load::Load;
use crate::drives::parameter::parameters;
use crate::drives::settings::{HasSolver, Settings};
use crate::drives::shaft::cam_drive::{CamDrive, DriveMode, Start};
pub use crate::drives::solver::oscillation::Found;
use crate::drives::solver::oscillation::{Oscillation, as_every_oscillation};
use crate::drives::{Curve, Drive, EventLog, Experiment, Fault, List, Text};
use crate::motion::MotionLaw;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

parameters!(Parameters of ElasticShaft.equation.parameters);

/// The drive as a scene describes it, coherent SI.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Scene {
    /// m, J, c, b.
    pub parameters: Parameters,
    /// Whether the equation is linearised in the twist.
    pub linear: bool,
    /// Loads on the follower.
    #[serde(default)]
    pub load: Load,
    /// U.
    pub cam: MotionLaw,
    /// φ.
    pub drive: DriveMode,
    /// Initial state.
    pub start: Start,
    /// `solver.tolerance`, `solver.method`, `solver.step_size`.
    pub solver: Settings,
}

/// The drive in operation.
pub type ElasticShaft = Oscillation<Twist>;

impl Drive for ElasticShaft {
    type Scene = Scene;

    const MODEL: &'static str = "ElasticCamDrive.shaft";

    fn new(scene: Scene) -> Result<Self, Fault> {
        let Scene { parameters, linear, load, cam, drive, start, solver } = scene;
        let load = (!load.is_none()).then(|| Arc::new(load));
        Ok(Oscillation::of(Twist { parameters, linear, load }, CamDrive::new(cam, drive), start, solver))
    }

    fn variables(&self) -> List<Self> {
        variables::list(self)
    }

    fn text(&self) -> Text {
        let linear = self.equation.linear;
        let periodic = linear && !self.has_method();
        let loaded = self.equation.load.is_some();
        let conditions = [
            ("linear", linear),
            ("periodic", periodic),
            ("inputs", self.cam.is_input()),
            ("load", loaded),
            ("method", self.has_method()),
        ];
        let parts = self.equation.load.as_deref().map_or_else(|| Load::default().conditions(), Load::conditions);
        let conditions = [&conditions[..], &parts].concat();
        Text::new(include_str!("text.toml"), &conditions)
    }

    fn curves(&self) -> Vec<Curve> {
        Curve::of_law(&self.cam.law)
    }

    fn experiment(&self) -> Experiment {
        Experiment::of_turns(5.0, self.cam.mode.speed())
    }

    fn start(&mut self, time: f64) -> Result<(), Fault> {
        self.begin(time)
    }

    as_every_oscillation!();
}
