//! Key figures of a scene in the units that engineers read: speed, natural frequency, largest acceleration and force,
//! the nearest resonances; and implausible values, such as a forgotten unit (`implausible`, `roughness`).
//!
//! Loads and deformations are kinetostatic: the drive does not vibrate. An elastic drive counts as m q̈ + b q̇ + c q = f + Ω²
//! f₂ with the means m, b, c over a turn ([`crate::oscillator`]): harmonic k of its load deforms it by |f + Ω² f₂|ₖ / |c − m
//! (kΩ)² + i b kΩ|, largest near kΩ = ω₀ = √(c/m).

mod characteristic;
mod implausible;
mod machine;
mod motion;
mod report;
mod roughness;
#[cfg(test)]
mod tests;
pub(crate) mod train;
mod vibration;

pub use machine::running;

pub use characteristic::Jump;

use crate::forces::Machine;
use crate::forces::report::LiftOff;
use crate::law_motions::{Motion, greatest_of, shown, stroke};
use crate::oscillator;
use crate::periodic_turn::{self, Turn};
use crate::report::unit::HZ;
use crate::report::{Level, Setting, Unit, terminal};
use crate::resource::{Resource, Scene, Tool};
use crate::text::clean;
use camdrive::drives::Fault;
use camdrive::drives::backlash;
use camdrive::drives::elastic_output;
use camdrive::drives::follower::load::Load;
use camdrive::drives::parametric::law::{CrankLaw, Law};
use camdrive::drives::shaft::cam_drive::DriveMode;
use camdrive::motion::MotionLaw;
use serde::Serialize;

/// The characteristic values of a scene.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Overview {
    /// Its figures, in the order of the report.
    pub figures: Vec<Figure>,
    /// The motions of its laws between their stops, with their characteristic values.
    pub motions: Vec<Motion>,
    /// The jumps of derivatives of its plans.
    pub jumps: Vec<Jump>,
    /// The resonances nearest to the speed; without a speed the strongest ones. None if coefficients vary over the turn: the
    /// resonances of their means are off (18 % in the transfer manipulator), and [`crate::stability`] has the right ones.
    pub resonances: Vec<Resonance>,
    /// The resonances of all harmonics.
    #[serde(skip)]
    every: Vec<Resonance>,
    /// The harmonics near the natural frequency that the judgement may name: the follower, 0 for the only one, and k.
    #[serde(skip)]
    pub(crate) named: Vec<(usize, usize)>,
    /// True if the coefficients vary.
    #[serde(skip)]
    pub varies: bool,
    /// The speeds from which on force no longer keeps the followers on their cams.
    pub lift_offs: Vec<LiftOff>,
    /// Its cams and their followers.
    #[serde(skip)]
    machine: Option<Machine>,
    /// True if the laws are left out.
    #[serde(skip)]
    sketched: bool,
    /// Half the range of the kinetostatic deformation of each elastic member, at the speed of the scene; NaN for a rigid
    /// follower.
    #[serde(skip)]
    swings: Vec<f64>,
    /// A turn of the periodic motion at the speed of the scene.
    #[serde(skip)]
    pub turn: Option<Turn>,
    /// The reason if there is none.
    #[serde(skip)]
    pub(crate) motionless: Option<Fault>,
    /// Implausible values.
    pub warnings: Vec<Warning>,
    /// The warnings that are about the motion, by their indices, and their levels.
    #[serde(skip)]
    of_motion: Vec<(usize, Level)>,
    /// Findings on the motion that warn of nothing.
    #[serde(skip)]
    notes: Vec<String>,
    /// Settings that remedy warnings, by the indices of the warnings.
    #[serde(skip)]
    pub(crate) cures: Vec<(usize, Setting)>,
}

/// A quantity and its value.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Figure {
    /// For example "natural_frequency" or "follower(1).stroke".
    pub name: String,
    /// In the coherent SI unit.
    pub value: f64,
    /// Its unit; "1" for a pure number.
    pub unit: &'static str,
    /// The value for people.
    #[serde(skip)]
    pub shown: String,
}

/// A harmonic of the load that meets the natural frequency at some speed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Resonance {
    /// k.
    pub harmonic: usize,
    /// ω₀/k (rad/s).
    pub speed: f64,
    /// The amplitude of q in this harmonic at the speed of the scene (m or rad).
    pub amplitude: Option<f64>,
    /// That amplitude at the resonance; None without damping, where it grows without bound.
    pub resonant_amplitude: Option<f64>,
    /// The unit of both.
    pub unit: &'static str,
}

/// A value that is implausible, though it can be computed.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Warning {
    /// The key with its value, and why it is implausible.
    pub message: String,
    /// A remedy.
    pub hint: String,
}

/// A law, and the tool's position and transfer functions as a function of the law's.
type Moved<'a> = (&'a MotionLaw, &'a dyn Fn([f64; 5]) -> [f64; 5]);

/// The overview of a scene.
pub fn of(resource: &Resource) -> Overview {
    at(resource, false)
}

/// The overview of a scene, or of one at a speed that may be `advised`, without advice on other speeds.
fn at(resource: &Resource, advised: bool) -> Overview {
    let mut overview = kinetostatic(resource);
    for Tool { section, law, unit } in &resource.tools {
        overview.law(section, law, unit);
    }
    // The motion of a nonlinear shaft is judged itself.
    let judged = matches!(&resource.scene, Scene::ElasticShaft(shaft) if !shaft.linear) && overview.turn.is_some();
    implausible::warn(&mut overview, judged);
    overview.lift_offs = overview.machine.clone().map(Machine::lift_offs).and_then(Result::ok).unwrap_or_default();
    overview.lifts_off(resource);
    overview.steady(resource, advised);
    overview.show_frequencies(&HZ);
    overview
}

/// The figures of the scene without vibration.
fn kinetostatic(resource: &Resource) -> Overview {
    let mut overview = Overview { machine: Machine::of(resource).ok(), ..Overview::default() };
    match periodic_turn::of(&resource.scene, None, 0.0) {
        Ok(turn) => {
            overview.machine.iter_mut().for_each(|machine| machine.mark(&resource.scene, &turn));
            overview.turn = Some(turn);
        }
        Err(fault) => overview.motionless = Some(fault),
    }
    tell(&mut overview, &resource.scene);
    overview
}

/// The figures of its elastic members alone, with a sketch of its motion.
fn sketched(resource: &Resource) -> Overview {
    let turn = periodic_turn::sketch(&resource.scene).ok();
    let mut overview = Overview { turn, sketched: true, ..Overview::default() };
    tell(&mut overview, &resource.scene);
    overview
}

fn tell(overview: &mut Overview, scene: &Scene) {
    match scene {
        Scene::ElasticOutput(elastic_output::Scene { parameters, cam, drive, load, .. }) => {
            let speed = overview.driven(drive);
            overview.elastic(&vibration::behind_cam(cam, *parameters, load, speed), Some((cam, false)));
            overview.cam(cam, speed);
        }
        Scene::ElasticShaft(scene) => {
            let speed = overview.driven(&scene.drive);
            overview.elastic(&oscillator::of_shaft(scene), Some((&scene.cam, true)));
            overview.cam(&scene.cam, speed);
        }
        Scene::BacklashDrive(backlash::Scene { parameters, cam, drive, .. }) => {
            let backlash::Parameters { m1, m2, c, b, s, .. } = *parameters;
            let speed = overview.driven(drive);
            let own = elastic_output::Parameters { m: m2, c, b };
            overview.elastic(&vibration::behind_cam(cam, own, &Load::default(), speed), Some((cam, false)));
            overview.speed("natural_frequency_in_flight", (c * (m1 + m2) / (m1 * m2)).sqrt());
            overview.clearance(cam, s);
            overview.cam(cam, speed);
        }
        Scene::ParametricDrive(scene) => {
            overview.driven(&scene.drive);
            if let Law::Crank(CrankLaw { crank, .. }) = &scene.law {
                overview.figure("crank_radius", crank.r, "m");
            }
            overview.elastic(&oscillator::of_coefficients(scene), None);
        }
        Scene::RigidMachine(scene) => machine::tell(overview, scene),
        Scene::DriveTrain(scene) => train::tell(overview, scene),
    }
}

impl Overview {
    /// A quantity in coherent SI.
    fn figure(&mut self, name: impl Into<String>, value: f64, unit: &'static str) {
        self.sized(name, value, unit, 0.0);
    }

    /// A quantity that may be rounding next to values of this size.
    fn sized(&mut self, name: impl Into<String>, value: f64, unit: &'static str, size: f64) {
        self.figures.push(Figure { name: name.into(), value, unit, shown: shown(clean(value, size), unit) });
    }

    /// A speed or a natural frequency (rad/s).
    fn speed(&mut self, name: &str, value: f64) {
        self.figure(name, value, "rad/s");
    }

    /// Shows people the natural frequencies in this unit.
    pub fn show_frequencies(&mut self, unit: &Unit) {
        for figure in self.figures.iter_mut().filter(|of| of.unit == "rad/s" && of.name.contains("_frequency")) {
            figure.shown = terminal::shown(figure.value, unit);
        }
    }

    /// A part of something.
    fn share(&mut self, name: &str, value: f64) {
        self.figures.push(Figure { name: name.to_owned(), value, unit: "1", shown: shown(100.0 * value, "%") });
    }

    /// The speed of a drive, if it has one of its own.
    fn driven(&mut self, drive: &DriveMode) -> Option<f64> {
        let DriveMode::Constant { w, .. } = *drive else { return None };
        self.speed("speed", w);
        Some(w)
    }

    /// A clearance, if there is a second flank.
    fn clearance(&mut self, cam: &MotionLaw, s: f64) {
        if s.is_finite() {
            self.figure("clearance", s, "m");
        }
        let share = s / stroke(cam, |u| u[0]);
        if share.is_finite() {
            self.share("clearance_of_stroke", share);
        }
    }

    /// The law of a section of the scene.
    fn law(&mut self, section: &str, law: &MotionLaw, unit: &'static str) {
        if self.sketched {
            return;
        }
        self.roughness(section, law, unit);
        self.motions(section, law, unit);
    }

    /// The motion of the only cam.
    fn cam(&mut self, law: &MotionLaw, speed: Option<f64>) {
        self.law("cam", law, "m");
        self.motion(0, "", (law, &|u| u), speed, false);
    }

    /// The largest kinetostatic load on the tool of follower j, counted from 0, at this speed (rad/s).
    fn load(&self, j: usize, speed: f64) -> Option<f64> {
        let machine = self.machine.as_ref()?;
        let drives = vec![machine.drives.get(j)?.clone()];
        let machine = Machine { speed, inertia: None, drives, name: String::new() };
        let turn = machine.turn().ok()?;
        Some(turn.largest(|state| state.drives[0].on_tool().abs()).value)
    }

    /// The motion of the tool of follower j, counted from 0; position and transfer functions follow from a law's.
    fn motion(&mut self, j: usize, prefix: &str, (law, tool): Moved, speed: Option<f64>, turns: bool) {
        if self.sketched {
            return;
        }
        let load = speed.and_then(|speed| self.load(j, speed)).filter(|load| *load > 0.0);
        let mut tell = |name: &str, value: f64, unit: [&'static str; 2]| {
            self.figure(format!("{prefix}{name}"), value, unit[usize::from(turns)]);
        };
        tell("stroke", stroke(law, |u| tool(u)[0]), ["m", "rad"]);
        let [slope, curvature] = [1, 2].map(|n| greatest_of(law, |u| tool(u)[n].abs()));
        let Some(speed) = speed else {
            tell("largest_first_transfer_function", slope, ["m/rad", "1"]);
            tell("largest_second_transfer_function", curvature, ["m/rad2", "1/rad"]);
            return;
        };
        tell("largest_velocity", slope * speed.abs(), ["m/s", "rad/s"]);
        tell("largest_acceleration", curvature * speed * speed, ["m/s2", "rad/s2"]);
        if let Some(load) = load {
            tell(if turns { "largest_kinetostatic_torque" } else { "largest_kinetostatic_force" }, load, ["N", "N.m"]);
        }
    }
}
