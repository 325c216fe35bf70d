//! A drive with one degree of freedom and periodic coefficients.
//!
//! m(φ) q̈ + b(φ) q̇ + c(φ) q = f(φ), φ(t) prescribed. The coefficients are finite Fourier series, or a parallel-crank drive's: J
//! ψ̈ + b_T q̇ + c_T(φ) q = f(φ) with ψ = φ + q (modules [`crank`] and [`law`]).
//!
//! Symbols: m mass (kg·m² or kg), b damping (N·m·s/rad or N·s/m), c stiffness (N·m/rad or N/m), f torque or force on the mass,
//! positive in the sense of q, q angle (rad) or length (m); φ drive angle (rad). Signs: φ, ψ and torques are positive in the same
//! sense; tau = −(c q + b q̇) is the torque from the drive into the unit and loads the drive if it is positive.
//!
//! Loads on the mass add F_L(y, ẏ, φ, t) to f, y = q or ψ, see [`load`](crate::drives::follower::load); the forces of their return
//! spring and damper go to the ground and are no part of tau.
//!
//! Energy: d/dt (½ m q̇² + ½ c q²) = f q̇ − b q̇² + ω ½ (m′ q̇² + c′ q²); the last term, `tau_parametric` times ω, is the power
//! that the drive feeds into the vibration as m and c vary. It is of second order in q.
//!
//! Stability: free motions grow or decay over a turn by the Floquet multipliers; `growth` is ln of the largest modulus. If it is
//! positive the drive is parametrically unstable, and the motion grows; the computation ends beyond 1e100.
//!
//! Validity: q small enough for a linear equation; m > 0 over the whole turn.
//!
//! Source: Dresig, Vulfson, *Dynamik der Mechanismen*, sections 4.5.1–4.5.3.

#[cfg(test)]
mod tests;
mod variables;

use crate::drives::follower::load::Load;
use crate::drives::follower::parametric::Vibration;
pub use crate::drives::follower::parametric::{coefficients, crank, law};
use crate::drives::settings::{HasSolver, Settings};
use crate::drives::shaft::cam_drive::{CamDrive, DriveMode, Start};
use crate::drives::solver::oscillation::{Oscillation, as_every_oscillation};
use crate::drives::{About, Curve, Drive, Event, EventLog, Experiment, Fault, List, Text};
use coefficients::Coefficients;
use crank::SecondCrank;
use law::{Coordinate, Law};
use serde::{Deserialize, Serialize};
use std::sync::Arc;
pub use variables::{of_coefficients, quantities};

/// The drive as a scene describes it, coherent SI.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Scene {
    /// The source of the coefficients.
    pub law: Law,
    /// φ.
    pub drive: DriveMode,
    /// Loads on the mass.
    #[serde(default)]
    pub load: Load,
    /// Initial state.
    pub start: Start,
    /// `solver.tolerance` and, on inputs, `solver.method`, `solver.step_size`.
    pub solver: Settings,
}

/// The drive in operation.
pub type ParametricDrive = Oscillation<Vibration>;

impl Drive for ParametricDrive {
    type Scene = Scene;

    const MODEL: &'static str = "ParametricDrive";

    fn new(scene: Scene) -> Result<Self, Fault> {
        let Scene { law, drive, load, start, solver } = scene;
        law.validate()?;
        let load = (!load.is_none()).then(|| Arc::new(load));
        Ok(Oscillation::of(Vibration::of(&law, load), CamDrive::new(law, drive), start, solver))
    }

    fn variables(&self) -> List<Self> {
        variables::list(self)
    }

    fn text(&self) -> Text {
        let (series, crank) = match &*self.cam.law {
            Law::Series(law) => (Some(law), None),
            Law::Crank(crank) => (None, Some(crank)),
        };
        let second = |wanted: fn(&SecondCrank) -> bool| crank.is_some_and(|crank| wanted(&crank.crank.second));
        let conditions = [
            ("series", series.is_some()),
            ("rotation", self.cam.law.coordinate() == Coordinate::Rotation),
            ("crank", crank.is_some()),
            ("own shafts", second(|second| matches!(second, SecondCrank::OwnShafts(_)))),
            ("shared shafts", second(|second| matches!(second, SecondCrank::SharedShafts(_)))),
            ("harmonics", crank.is_some_and(|crank| crank.harmonics.is_some())),
            ("load", self.equation.load.is_some()),
            ("inputs", self.cam.is_input()),
            ("method", self.has_method()),
        ];
        let parts = self.equation.load.as_deref().map_or_else(|| Load::default().conditions(), Load::conditions);
        let conditions = [&conditions[..], &parts].concat();
        Text::new(include_str!("text.toml"), &conditions)
    }

    fn curves(&self) -> Vec<Curve> {
        let Coefficients { m, b, c, f } = &*self.equation.coefficients;
        let [mass, damping, stiffness, force] = match self.cam.law.coordinate() {
            Coordinate::Rotation => ["m [kg·m²]", "b [N·m·s/rad]", "c [N·m/rad]", "f [N·m]"],
            Coordinate::Translation => ["m [kg]", "b [N·s/m]", "c [N/m]", "f [N]"],
        };
        let mut curves = vec![Curve::over_turn("Stiffness c(φ)", stiffness, |phi| c.at(phi)[0])];
        let titles = [("Mass m(φ)", mass), ("Damping b(φ)", damping), ("Load f(φ)", force)];
        for (series, (title, label)) in [m, b, f].into_iter().zip(titles) {
            if series.bound(1) > 0.0 {
                curves.push(Curve::over_turn(title, label, |phi| series.at(phi).0[0]));
            }
        }
        curves
    }

    fn experiment(&self) -> Experiment {
        // Growth and decay take some turns.
        Experiment::of_turns(20.0, self.cam.mode.speed())
    }

    fn start(&mut self, time: f64) -> Result<(), Fault> {
        self.log.clear();
        self.begin(time)?;
        if self.growth > 0.0 {
            let (kind, quantity) = ("parametrically unstable", "growth per turn");
            self.log.push(Event {
                time,
                kind,
                quantity,
                value: self.growth,
                unit: "1",
                follower: 0,
                about: About::Solver,
            });
        }
        Ok(())
    }

    as_every_oscillation!();
}
