//! Relations between scenes that describe one drive: whatever the law, the start, the sense of rotation and the origin of the
//! angle, all outputs of both agree.
//!
//! The comment of a relation says on which planted fault it was seen to fail.

use super::linkage;
use super::parametric;
use super::run::Run;
use super::scenes::{
    CamScene, MachineScene, Model, Start, Torque, as_plan, as_table, backlash, cycle, decades, fourier, geared, law,
    machine, output, shaft, times, turned,
};
use super::{SENSITIVITY, admitted, config, quadrature};
use camdrive::drives::Fault;
use camdrive::drives::rigid_machine::Follower;
use camdrive::drives::rigid_machine::linkage::{Gear, Kind, Link, Linkage, Mechanism};
use camdrive::drives::unit::{self, Quantity};
use camdrive::drives::variable::{self, Causality, Description};
use camdrive::motion::{Fourier, MotionLaw};
use proptest::prelude::*;
use serde_json::Value;
use std::f64::consts::TAU;
use std::fmt::Debug;

/// How far two runs that must agree may differ.
#[derive(Clone, Copy)]
pub struct Accuracy {
    /// The documented error of a drive, relative to the largest value.
    pub documented: f64,
    /// How many times as much as a change of 1e-10 of a parameter and one of the start make.
    pub magnified: f64,
}

impl Accuracy {
    /// Shaft, parametric drive and machine keep 1e-9. Their steps keep 1e-10 each, which a sensitive drive magnifies.
    pub const INTEGRATED: Self = Accuracy { documented: 1e-9, magnified: SENSITIVITY };
    /// Closed forms: a sensitive drive magnifies the roundings of parameters and angles, of 1e-13 at most.
    const OUTPUT: Self = Accuracy { documented: 1e-12, magnified: 1e-2 };
    const BACKLASH: Self = Accuracy { documented: 1e-10, magnified: 1e-2 };
    /// The search for the periodic motion of a drive with backlash ends where a turn changes the state by 1e-12, and what dies
    /// out slowly needs thousands of turns.
    const PERIODIC_BACKLASH: Self = Accuracy { documented: 1e-8, magnified: 1e-2 };
}

/// A scene of any drive, as the relations see it.
pub trait Scene: Clone + Debug {
    fn resolved(&self) -> (&'static str, Value);
    /// Inputs, and parameters that a scene does not have.
    fn settings(&self) -> Vec<(&'static str, f64)> {
        Vec::new()
    }
    /// Length of the run (s).
    fn span(&self) -> f64;
    fn accuracy(&self) -> Accuracy;
    fn start(&mut self) -> &mut Start;
    fn phi_start(&mut self) -> &mut f64;
    /// A change by 1e-10 that shows how sensitive the drive is.
    fn perturbed(&self) -> Self;
    /// All that depends on the angle turned on by about this angle, and the start with it; also by how much.
    fn turned(&self, angle: f64) -> (Self, f64);
    /// φ → −φ.
    fn reversed(&self) -> Self;
    /// The drive behind a gear: its own shaft turns `k` times as fast as the one that is looked at.
    fn geared(&self, k: usize) -> Self;
    /// A drive that starts where this run is; None where start values cannot say so.
    fn continued(&self, run: &mut Run) -> Option<Self>;
    /// The period of the periodic motion on which the run started (s).
    fn period(&self, run: &mut Run) -> f64;
    /// Outputs whose value is a small difference, and the size of its terms, `of` being the largest values of outputs.
    fn terms(&self, of: &dyn Fn(&str) -> f64) -> Vec<(String, f64)>;
    /// How much of an angle of the shaft an output has.
    fn share_of_angle(&self, name: &str) -> f64 {
        if is_shaft_angle(name) { 1.0 } else { 0.0 }
    }
    /// The motion laws.
    fn laws(&mut self) -> Vec<&mut MotionLaw> {
        Vec::new()
    }

    fn run(&self) -> Result<Run, Fault> {
        Run::new(self.resolved(), &self.settings())
    }
}

impl Scene for CamScene {
    fn resolved(&self) -> (&'static str, Value) {
        self.resolved()
    }

    fn span(&self) -> f64 {
        self.span
    }

    fn accuracy(&self) -> Accuracy {
        match self.model {
            Model::Output => Accuracy::OUTPUT,
            Model::Backlash if self.start == Start::Steady => Accuracy::PERIODIC_BACKLASH,
            Model::Backlash => Accuracy::BACKLASH,
            Model::LinearShaft | Model::Shaft => Accuracy::INTEGRATED,
        }
    }

    fn start(&mut self) -> &mut Start {
        &mut self.start
    }

    fn phi_start(&mut self) -> &mut f64 {
        &mut self.phi_start
    }

    fn perturbed(&self) -> Self {
        self.perturbed()
    }

    fn turned(&self, angle: f64) -> (Self, f64) {
        (CamScene { law: turned(&self.law, angle), phi_start: self.phi_start + angle, ..self.clone() }, angle)
    }

    fn reversed(&self) -> Self {
        self.reversed()
    }

    fn geared(&self, k: usize) -> Self {
        let times = k as f64;
        let scene = CamScene {
            law: geared(&self.law, k),
            w: self.w / times,
            phi_start: self.phi_start / times,
            ..self.clone()
        };
        if !matches!(self.model, Model::Shaft | Model::LinearShaft) {
            return scene;
        }
        let [second, c, b] = [self.second, self.c, self.b].map(|value| value * times * times);
        CamScene { second, c, b, q: self.q / times, q_dot: self.q_dot / times, ..scene }
    }

    fn continued(&self, run: &mut Run) -> Option<Self> {
        if self.model == Model::Backlash && run.get("contact") == 0.0 {
            return None;
        }
        let [phi_start, q, q_dot] = run.all(["phi", "q", "der(q)"]);
        Some(CamScene { start: Start::Given, phi_start, q, q_dot, ..self.clone() })
    }

    fn period(&self, _: &mut Run) -> f64 {
        TAU / self.w.abs()
    }

    fn terms(&self, of: &dyn Fn(&str) -> f64) -> Vec<(String, f64)> {
        let force = self.c * of("q") + self.b * of("der(q)");
        let [_, slope, curvature] = [0, 1, 2].map(|order| self.law.bound(order));
        let terms = match self.model {
            Model::Output => {
                // The forces on the mass of a periodic motion have the mean 0 to their roundings, 1e-15; a soft spring makes of that an
                // offset.
                let offset = match self.start {
                    Start::Steady => 1e-3 * (self.b * of("der(q)") + self.m * of("der(q,2)")) / self.c,
                    _ => 0.0,
                };
                vec![
                    ("q", offset),
                    ("y", of("q").max(offset)),
                    // The size of a vibration is that of q.
                    ("der(q)", (self.c / self.m).sqrt() * of("q")),
                    ("der(y)", of("der(q)").max((self.c / self.m).sqrt() * of("q"))),
                    ("force", force),
                    ("tau", slope * force),
                    ("der(y,2)", force / self.m),
                    ("der(q,2)", force / self.m),
                ]
            }
            Model::LinearShaft | Model::Shaft => {
                let push = self.m * slope * curvature * of("der(psi)").powi(2);
                vec![("tau", force), ("der(psi,2)", (force + push) / self.second), ("der(y)", slope * of("der(psi)"))]
            }
            Model::Backlash => {
                let force = force + self.m * of("der(x1,2)");
                let momentum = self.m * of("der(x1)") + self.second * of("der(y)");
                let mean = momentum * INSTANTS as f64 / self.span;
                let energy = momentum * (of("der(x1)") + of("der(y)"));
                vec![
                    ("force", force),
                    ("tau", slope * force),
                    ("der(y,2)", force / self.second),
                    ("der(x1,2)", force / self.m),
                    // In a rest it is but the rounding of U′ω.
                    ("der(x1)", slope * self.w.abs()),
                    ("impulse", momentum),
                    ("force_mean", mean),
                    ("tau_mean", slope * mean),
                    ("energy_loss", energy),
                    ("damping_loss", energy),
                ]
            }
        };
        terms.into_iter().map(|(name, size)| (name.to_owned(), size)).collect()
    }

    fn laws(&mut self) -> Vec<&mut MotionLaw> {
        vec![&mut self.law]
    }
}

impl Scene for MachineScene {
    fn resolved(&self) -> (&'static str, Value) {
        self.resolved()
    }

    fn settings(&self) -> Vec<(&'static str, f64)> {
        self.inputs()
    }

    fn span(&self) -> f64 {
        self.span
    }

    fn accuracy(&self) -> Accuracy {
        Accuracy::INTEGRATED
    }

    fn start(&mut self) -> &mut Start {
        &mut self.start
    }

    fn phi_start(&mut self) -> &mut f64 {
        &mut self.phi_start
    }

    fn perturbed(&self) -> Self {
        self.perturbed()
    }

    fn turned(&self, angle: f64) -> (Self, f64) {
        let scene = self.clone().with_laws(|law| turned(law, angle));
        (MachineScene { phi_start: self.phi_start + angle, ..scene }, angle)
    }

    fn reversed(&self) -> Self {
        self.reversed()
    }

    fn geared(&self, k: usize) -> Self {
        let by = k as f64;
        let torque = match self.torque {
            Torque::Kloss([m, s, w, lag]) => Torque::Kloss([m * by, s, w / by, lag]),
            Torque::Input(m) => Torque::Input(m * by),
            Torque::None => Torque::None,
        };
        let mut scene = self.clone().with_laws(|law| geared(law, k));
        scene.varying.iter_mut().for_each(|law| *law = times(law, by * by));
        let [phi_start, w_start] = [self.phi_start, self.w_start].map(|value| value / by);
        let [load, torque_start] = [self.load, self.torque_start].map(|value| value * by);
        MachineScene { j0: self.j0 * by * by, torque, phi_start, w_start, load, torque_start, ..scene }
    }

    fn continued(&self, run: &mut Run) -> Option<Self> {
        let [phi_start, w_start] = run.all(["phi", "w"]);
        let torque_start = if matches!(self.torque, Torque::Kloss(_)) { run.get("M_an") } else { 0.0 };
        Some(MachineScene { start: Start::Given, phi_start, w_start, torque_start, ..self.clone() })
    }

    fn period(&self, run: &mut Run) -> f64 {
        run.get("start.period")
    }

    fn terms(&self, of: &dyn Fn(&str) -> f64) -> Vec<(String, f64)> {
        let Torque::Kloss([m, slip, speed, lag]) = self.torque else { return Vec::new() };
        // What an error of the speed makes of the torque.
        let torque = 2.0 * m / (slip * speed.abs()) * of("w");
        let acceleration = (torque + m + self.load.abs()) / self.j0;
        let tools = (1..=self.followers.len()).flat_map(|j| {
            ["U", "lever"]
                .map(|tool| (format!("der({tool}[{j}],2)"), of(&format!("der({tool}[{j}])")) / of("w") * acceleration))
        });
        let own = [("M_an", torque), ("a", acceleration), ("der(M_an)", (torque + m) / lag)];
        own.into_iter().map(|(name, size)| (name.to_owned(), size)).chain(tools).collect()
    }

    fn laws(&mut self) -> Vec<&mut MotionLaw> {
        self.followers.iter_mut().map(|follower| &mut follower.cam).chain(&mut self.varying).collect()
    }
}

/// The instants at which the outputs of a run are compared, beside that at its start.
const INSTANTS: usize = 16;

/// All outputs of a run, from where it is, at equal distances.
#[derive(Debug)]
pub struct Course {
    outputs: Vec<(String, &'static Quantity)>,
    instants: Vec<Vec<f64>>,
}

/// Outputs that count from the start.
const SUMS: [&str; 3] = ["impulse", "energy_loss", "damping_loss"];

impl Course {
    pub fn of(run: &mut Run, span: f64) -> Result<Self, Fault> {
        let (outputs, begin) = (run.outputs(), run.time);
        let first = run.values();
        let mut instants = vec![first.clone()];
        for i in 1..=INSTANTS {
            run.to(begin + span * i as f64 / INSTANTS as f64)?;
            instants.push(run.values());
        }
        for (i, (name, _)) in outputs.iter().enumerate() {
            if SUMS.contains(&name.rsplit('.').next().unwrap_or(name)) {
                instants.iter_mut().for_each(|values| values[i] -= first[i]);
            }
            if name.ends_with("_mean") {
                // Before the first step there is no mean.
                instants[0][i] = 0.0;
            }
        }
        Ok(Course { outputs, instants })
    }

    /// The course of a whole run of the scene.
    pub fn of_scene<S: Scene>(scene: &S) -> Result<Self, Fault> {
        Self::of(&mut scene.run()?, scene.span())
    }

    /// The same course, with steps to these shares of it, too.
    pub fn through(run: &mut Run, span: f64, shares: &[f64]) -> Result<Self, Fault> {
        let outputs = run.outputs();
        let mut instants = vec![run.values()];
        for i in 1..=INSTANTS {
            let [from, to] = [i - 1, i].map(|i| i as f64 / INSTANTS as f64);
            for share in shares.iter().filter(|share| (from..to).contains(*share)) {
                run.to(span * share)?;
            }
            run.to(span * to)?;
            instants.push(run.values());
        }
        Ok(Course { outputs, instants })
    }

    /// Without outputs that tell of a step.
    pub fn without_means(mut self) -> Self {
        let is_mean = |i: usize| self.outputs[i].0.ends_with("_mean");
        let kept: Vec<usize> = (0..self.outputs.len()).filter(|i| !is_mean(*i)).collect();
        self.outputs = kept.iter().map(|i| self.outputs[*i].clone()).collect();
        self.instants.iter_mut().for_each(|values| *values = kept.iter().map(|i| values[*i]).collect());
        self
    }

    /// With other names of its outputs.
    pub fn renamed(mut self, name: &dyn Fn(&str) -> String) -> Self {
        self.outputs.iter_mut().for_each(|(own, _)| *own = name(own));
        self
    }

    /// How many outputs of the other one this one has.
    pub fn shares(&self, other: &Course) -> usize {
        other.outputs.iter().filter(|(name, _)| self.outputs.iter().any(|(own, _)| own == name)).count()
    }

    /// Seen by another one, who finds `change` of each output instead.
    fn seen(mut self, change: impl Fn(&str, &Quantity, f64) -> f64) -> Self {
        for values in &mut self.instants {
            for (value, (name, quantity)) in values.iter_mut().zip(&self.outputs) {
                *value = change(name, quantity, *value);
            }
        }
        self
    }

    /// The largest distance from `from`; 0 of an output that is not there.
    fn largest(&self, name: &str, from: f64) -> f64 {
        let place = self.outputs.iter().position(|(own, _)| own == name);
        let column = place.into_iter().flat_map(|i| self.instants.iter().map(move |values| values[i]));
        column.fold(0.0, |largest: f64, value| largest.max((value - from).abs()))
    }

    /// Whether both are the same motion, as far as a change of `perturbed` leaves this one what it is. Outputs that the
    /// other one does not have are left out.
    pub fn agrees<S: Scene>(&self, expected: &Course, perturbed: &[Course; 2], scene: &S) -> Result<(), TestCaseError> {
        self.agrees_within(expected, perturbed, scene, 0.0)
    }

    /// The same for a law that has an error of its own.
    fn agrees_within<S: Scene>(
        &self,
        expected: &Course,
        perturbed: &[Course; 2],
        scene: &S,
        of_law: f64,
    ) -> Result<(), TestCaseError> {
        let Accuracy { documented, magnified } = scene.accuracy();
        let terms = scene.terms(&|name| expected.largest(name, 0.0));
        for (i, (name, quantity)) in expected.outputs.iter().enumerate() {
            let Some(own) = self.outputs.iter().position(|(own, _)| own == name) else { continue };
            // An angle is as large as what is passed of it, and its own roundings.
            let (from, rounding) = if is_shaft_angle(name) { (expected.instants[0][i], 1e-15) } else { (0.0, 0.0) };
            let difference = terms.iter().find(|(of, _)| of == name).map_or(0.0, |(_, size)| *size);
            let least = if quantity.base == [0; 4] { 1.0 } else { difference };
            let scale = expected.largest(name, from).max(least);
            for k in 0..expected.instants.len() {
                let (value, right) = (self.instants[k][own], expected.instants[k][i]);
                let change = |perturbed: &Course| (perturbed.instants[k][i] - right).abs();
                let sensitivity = magnified * perturbed.iter().map(change).sum::<f64>();
                if sensitivity > 1e-2 * scale {
                    // Chaotic from here on.
                    prop_assume!(k > 1);
                    break;
                }
                // Each of them may be off by what is documented.
                let admissible = (2.0 * documented + of_law) * scale + sensitivity + rounding * right.abs();
                let difference = (value - right).abs();
                prop_assert!(
                    difference <= admissible,
                    "{name} at instant {k}: {value:e} instead of {right:e}: {difference:e} > {admissible:e}"
                );
            }
        }
        Ok(())
    }
}

fn is_shaft_angle(name: &str) -> bool {
    ["phi", "psi"].contains(&name.rsplit('.').next().unwrap_or(name))
}

/// Whether it belongs to the shaft, not to a tool that turns.
fn is_of_shaft(name: &str, quantity: &Quantity) -> bool {
    let shaft = ["Angle", "AngularVelocity", "AngularAcceleration", "Torque", "TorqueRate"].contains(&quantity.name);
    shaft && !["U[", "lever["].iter().any(|tool| name.trim_start_matches("der(").starts_with(tool))
}

/// The courses of a scene that is a little different, and of one that starts 1e-10 rad further on: what both changes make of a
/// vibration together passes through 0 where the rounding of an angle alone does not.
pub fn perturbed<S: Scene>(scene: &S) -> Result<[Course; 2], TestCaseError> {
    let mut later = scene.clone();
    *later.phi_start() += 1e-10;
    Ok([admitted(Course::of_scene(&scene.perturbed()))?, admitted(Course::of_scene(&later))?])
}

/// The image of the scene, seen as `change` says, moves as the scene does.
pub fn same<S: Scene>(
    scene: &S,
    image: Result<Course, Fault>,
    change: impl Fn(&str, &Quantity, f64) -> f64,
) -> Result<(), TestCaseError> {
    let expected = admitted(Course::of_scene(scene))?;
    let perturbed = perturbed(scene)?;
    alike(image)?.seen(change).agrees(&expected, &perturbed, scene)
}

/// An image of a scene that is admitted is admitted, unless its numbers are out of range.
pub fn alike<T>(image: Result<T, Fault>) -> Result<T, TestCaseError> {
    image.map_err(|fault| {
        let text = fault.to_string();
        if text.contains("is not admissible") {
            TestCaseError::reject(text)
        } else {
            TestCaseError::fail(format!("the image alone is refused: {text}"))
        }
    })
}

/// Where the angle is counted from does not matter, nor does a number of whole turns.
///
/// Seen to find: an offset of 1e-7 rad of negative angles, and a periodic start of a machine with the energy of φ = 0 at negative angles.
pub fn origin<S: Scene>(scene: &S, angle: f64, turns: i32) -> Result<(), TestCaseError> {
    let (mut image, angle) = scene.turned(angle);
    let shift = angle + TAU * f64::from(turns);
    *image.phi_start() += TAU * f64::from(turns);
    same(scene, Course::of_scene(&image), |name, _, value| value - scene.share_of_angle(name) * shift)
}

/// Seen from behind, φ → −φ, the drive turns the other way round.
///
/// Seen to find: speeds that are 1e-6 greater where they are negative.
fn sense<S: Scene>(scene: &S) -> Result<(), TestCaseError> {
    let back = |name: &str, quantity: &Quantity, value: f64| if is_of_shaft(name, quantity) { -value } else { value };
    same(scene, Course::of_scene(&scene.reversed()), back)
}

/// In other units of mass, length and time, 1/`units` of kg, m and s: each parameter and each output has its own.
///
/// Seen to find: 1e-9 kg·m² more of J, an absolute number.
fn units<S: Scene>(scene: &S, units: [f64; 3]) -> Result<(), TestCaseError> {
    units_but(scene, units, &|_| None)
}

/// The same, where `known` says the powers of kg, m and s of parameters whose variable says nothing of them.
pub fn units_but<S: Scene>(
    scene: &S,
    units: [f64; 3],
    known: &dyn Fn(&str) -> Option<[i32; 3]>,
) -> Result<(), TestCaseError> {
    let factor = |quantity: &Quantity| (0..3).map(|i| units[i].powi(quantity.base[i].into())).product::<f64>();
    let mut own = admitted(scene.run())?;
    let descriptions = own.drive.descriptions().to_vec();
    // The lifts of a table have a unit, its factor has none; those of a lever and of a tool that turns are angles.
    let turns = |tool: &str| {
        let of_follower =
            |d: &Description| ["U", "lever"].iter().any(|output| tool.replace("follower", output) == d.name);
        let is_angle =
            |d: &Description| matches!(d.kind, variable::Kind::Real { quantity, .. } if quantity.name == "Angle");
        descriptions.iter().any(|d| of_follower(d) && is_angle(d))
    };
    let mut settings = Vec::new();
    for (i, description) in descriptions.iter().enumerate() {
        if ![Causality::Parameter, Causality::Input].contains(&description.causality) {
            continue;
        }
        let variable::Kind::Real { quantity, .. } = description.kind else { continue };
        let powers = known(&description.name).map(|powers| (0..3).map(|i| units[i].powi(powers[i])).product());
        let by = powers.unwrap_or_else(|| match description.name.strip_suffix(".scale") {
            Some("inertia") => factor(&unit::INERTIA),
            Some(cam) if !turns(cam.trim_end_matches(".cam")) => factor(&unit::LENGTH),
            Some(_) => 1.0,
            None => factor(quantity),
        });
        settings.push((description.name.as_str(), by * own.drive.get(i).expect("a value")));
    }
    let image = Run::new(scene.resolved(), &settings).and_then(|mut run| Course::of(&mut run, scene.span() * units[2]));
    same(scene, image, |_, quantity, value| value / factor(quantity))
}

/// Behind a gear that makes `k` turns of one: a cam U(kφ), all inertias, stiffnesses and dampings of the shaft k² times as large.
///
/// Seen to find: harmonics beyond the 16th left out.
fn gear<S: Scene>(scene: &S, k: usize) -> Result<(), TestCaseError> {
    let by = k as f64;
    same(scene, Course::of_scene(&scene.geared(k)), |name, quantity, value| match quantity.name {
        "Torque" | "TorqueRate" if is_of_shaft(name, quantity) => value / by,
        "MomentOfInertia" => value / (by * by),
        // Of free vibrations in a turn.
        _ if name == "growth" => value / by,
        _ if is_of_shaft(name, quantity) => value * by,
        _ => value,
    })
}

/// With laws of one kind that move as far as its own ones did, and with the same laws in another form, which has this relative
/// `error`.
///
/// Seen to find: the inflection of a plan forgotten.
fn form<S: Scene>(scene: &S, law: &MotionLaw, other: &MotionLaw, error: f64) -> Result<(), TestCaseError> {
    let with = |form: &MotionLaw| {
        let mut scene = scene.clone();
        scene.laws().into_iter().for_each(|own| *own = times(form, own.bound(1) / law.bound(1)));
        scene
    };
    let of_law = |law: &MotionLaw| Course::of_scene(&with(law));
    let expected = admitted(of_law(law))?;
    let perturbed = perturbed(&with(law))?;
    alike(of_law(other))?.agrees_within(&expected, &perturbed, &with(law), error)
}

/// The run has gone on for a while; a drive that starts in this `mode` where it is moves as it does from there on.
fn goes_on<S: Scene>(scene: &S, share: f64, mode: Start) -> Result<(), TestCaseError> {
    let span = scene.span();
    let mut run = admitted(scene.run())?;
    let mut until = share * span;
    admitted(run.to(until))?;
    let mut image = scene.continued(&mut run);
    while image.is_none() && until < span {
        // Until mass 1 is on a flank.
        until += 0.05 * span;
        admitted(run.to(until))?;
        image = scene.continued(&mut run);
    }
    let Some(mut image) = image else { return Err(TestCaseError::reject("never in contact")) };
    *image.start() = mode;
    let expected = admitted(Course::of(&mut run, span))?;
    let perturbed = perturbed(&image)?;
    alike(Course::of_scene(&image))?.agrees(&expected, &perturbed, &image)
}

/// The outputs at an instant are the start values of a drive that moves as the first one does from there on.
///
/// Seen to find: `start.q_dot` with the other sign.
fn restart<S: Scene>(scene: &S, share: f64) -> Result<(), TestCaseError> {
    goes_on(scene, share, Start::Given)
}

/// Wherever a drive starts on its periodic motion, it is the same motion.
///
/// Seen to find: a periodic start in the phase of φ = 0.
fn one_orbit<S: Scene>(scene: &S, share: f64) -> Result<(), TestCaseError> {
    goes_on(scene, share, Start::Steady)
}

/// A drive on its periodic motion returns after so many periods, its shaft turned by as many turns.
///
/// Seen to find: q̇ of the periodic start 1e-6 too large.
pub fn return_to_start<S: Scene>(scene: &S, periods: u32) -> Result<(), TestCaseError> {
    let mut run = admitted(scene.run())?;
    let period = scene.period(&mut run);
    let phi = run.get("phi");
    let expected = admitted(Course::of(&mut run, scene.span()))?;
    let perturbed = perturbed(scene)?;
    let mut run = admitted(scene.run())?;
    admitted(run.to(period * f64::from(periods)))?;
    let turns = f64::from(periods).copysign(run.get("phi") - phi);
    let back = |name: &str, _: &Quantity, value: f64| value - scene.share_of_angle(name) * TAU * turns;
    admitted(Course::of(&mut run, scene.span()))?.seen(back).agrees(&expected, &perturbed, scene)
}

/// Two followers of half the mass, links and gears included, move as one does.
///
/// Seen to find: J of the tables without that of the first follower.
fn split(scene: &MachineScene) -> Result<(), TestCaseError> {
    let mut image = scene.clone();
    let halves = image.followers.iter().map(|follower| heavier(follower, 0.5)).collect::<Vec<_>>();
    // Those of the first half keep their numbers.
    image.followers = [halves.clone(), halves].concat();
    same(scene, Course::of_scene(&image), |_, _, value| value)
}

/// With all its masses times a factor.
pub fn heavier(follower: &Follower, factor: f64) -> Follower {
    let mut other = follower.clone();
    other.m *= factor;
    for mechanism in &mut other.linkage.0 {
        let change = |link: &mut Link| (link.mass, link.inertia) = (factor * link.mass, factor * link.inertia);
        match &mut mechanism.kind {
            Kind::Gear(gear) => gear.inertia *= factor,
            Kind::FourBar(linkage) => {
                [&mut linkage.input, &mut linkage.coupler, &mut linkage.output].into_iter().for_each(change)
            }
            Kind::SliderCrank(linkage) => {
                [&mut linkage.crank, &mut linkage.rod].into_iter().for_each(change);
                linkage.slider_mass *= factor;
            }
        }
    }
    other
}

/// A tool behind a gear i moves as one whose cam is i times as large, one behind i and 1/i as without gears; what turns with
/// their inputs adds to its inertia.
///
/// Seen to find: the inertia at the input of a gear multiplied by its ratio.
fn gears(scene: &MachineScene, ratio: f64, share: f64) -> Result<(), TestCaseError> {
    let gear = |ratio: f64, inertia: f64| Mechanism {
        kind: Kind::Gear(Gear { ratio, inertia, output_turns: true }),
        input_offset: 0.0,
        output_offset: 0.0,
    };
    let mut direct = scene.clone();
    direct.followers.iter_mut().for_each(|follower| (follower.turns, follower.linkage) = (true, Linkage::default()));
    let of_tool = |follower: &Follower, cam: f64, gears: Vec<Mechanism>, m: f64| Follower {
        m,
        turns: true,
        cam: times(&follower.cam, cam),
        linkage: Linkage(gears),
    };
    let behind = |change: &dyn Fn(&Follower) -> Follower| {
        let followers = direct.followers.iter().map(change).collect();
        Course::of_scene(&MachineScene { followers, ..direct.clone() })
    };
    // The tool turns `ratio` times as fast as the lever.
    let one = behind(&|f| {
        let lever = f.m * ratio * ratio;
        of_tool(f, 1.0 / ratio, vec![gear(ratio, share * lever)], f.m * (1.0 - share))
    });
    same(&direct, one, |_, _, value| value)?;
    let two = behind(&|f| {
        let between = f.m / (ratio * ratio);
        let gears = vec![gear(ratio, 0.25 * f.m), gear(1.0 / ratio, 0.25 * between)];
        of_tool(f, 1.0, gears, 0.5 * f.m)
    });
    same(&direct, two, |_, _, value| value)
}

/// E of the periodic motion at the start changes with the angle of the start as the torques say: dE/dφ = M_an − τ.
///
/// Seen to find: a periodic start with the energy of φ = 0 at negative angles.
fn energy_at_start(scene: &MachineScene) -> Result<(), TestCaseError> {
    let at = |phi_start: f64| -> Result<[f64; 2], Fault> {
        let [energy, torque] = MachineScene { phi_start, ..scene.clone() }.run()?.all(["E", "M_an"]);
        Ok([energy, torque - scene.load])
    };
    // Up to the next breakpoint.
    let breakpoints = scene.clone().laws().iter().flat_map(|law| law.breakpoints().to_vec()).collect::<Vec<_>>();
    let ahead = breakpoints.iter().map(|angle| (angle - scene.phi_start).rem_euclid(TAU)).fold(0.3, f64::min);
    let from = scene.phi_start;
    let [start, end] = [admitted(at(from))?, alike(at(from + ahead))?];
    let change = |count: usize| -> Result<[f64; 2], Fault> {
        let half = 0.5 * ahead / count as f64;
        let mut sums = [0.0; 2];
        for middle in (0..count).map(|i| from + half * (2 * i + 1) as f64) {
            for (x, weight) in quadrature() {
                let [_, torque] = at(middle + half * x)?;
                sums = [sums[0] + half * weight * torque, sums[1] + (half * weight * torque).abs()];
            }
        }
        Ok(sums)
    };
    let mut sums = alike(change(1))?;
    let error = |sums: [f64; 2]| (end[0] - start[0] - sums[0]).abs();
    let admissible = 2.0 * scene.accuracy().documented * (start[0].max(end[0]) + sums[1]);
    if error(sums) > admissible {
        // Too few panels, perhaps.
        sums = alike(change(4))?;
    }
    prop_assert!(error(sums) <= admissible, "{:e} instead of {:e} J of {:e}", end[0] - start[0], sums[0], start[0]);
    Ok(())
}

/// Starts of a drive in some modes.
fn started<S: Scene>(
    scenes: impl Strategy<Value = S>,
    modes: impl Strategy<Value = Start>,
) -> impl Strategy<Value = S> {
    (scenes, modes).prop_map(|(mut scene, mode)| {
        *scene.start() = mode;
        scene
    })
}

fn any_start() -> impl Strategy<Value = Start> {
    prop_oneof![1 => Just(Start::AtRest), 2 => Just(Start::Given), 2 => Just(Start::Steady)]
}

/// Of machines, with an inertia that varies by itself in some of them. On the periodic motion the load is what a motor carries.
fn machines(
    machines: impl Strategy<Value = MachineScene>,
    modes: impl Strategy<Value = Start>,
) -> impl Strategy<Value = MachineScene> {
    let varying = prop_oneof![2 => Just(None), 1 => (law(), 0.01..0.3_f64).prop_map(Some)];
    (machines, modes, varying).prop_map(|(mut scene, mode, varying)| {
        scene.varying = varying.map(|(law, share)| times(&law, share * scene.j0 / law.bound(0)));
        match (mode, scene.torque) {
            (Start::Steady, Torque::Kloss([m, ..])) => {
                scene.start = Start::Steady;
                scene.load = scene.load.clamp(-0.3 * m, 0.3 * m);
            }
            (Start::Steady, _) => {}
            _ => scene.start = Start::Given,
        }
        scene
    })
}

/// Of machines whose J is smooth all around, with a motor that follows at once, and a negative angle within half a turn of 0.
fn smooth() -> impl Strategy<Value = MachineScene> {
    (machine().prop_filter("a motor", |scene| matches!(scene.torque, Torque::Kloss(_))), fourier(), -3.1..0.0_f64)
        .prop_map(|(scene, law, phi_start)| {
            let mut scene = scene.with_laws(|own| times(&law, own.bound(1) / law.bound(1)));
            if let Torque::Kloss([m, slip, _, lag]) = &mut scene.torque {
                // A steep motor takes many steps of each search.
                (*slip, *lag) = (slip.clamp(0.1, 1.0), 0.0);
                scene.load = scene.load.clamp(-0.3 * *m, 0.3 * *m);
            }
            MachineScene { phi_start, start: Start::Steady, ..scene }
        })
}

/// Of machines whose tools are behind mechanisms.
fn linked() -> impl Strategy<Value = MachineScene> {
    (machine(), prop::collection::vec(linkage::smooth(), 1..3)).prop_map(|(scene, followers)| {
        // As heavy as those in their place.
        let inertia =
            |f: &Follower| (0..16).map(|i| f.inertia(f.cam.at(TAU * f64::from(i) / 16.0).0)[0]).sum::<f64>() / 16.0;
        let followers: Vec<Follower> = followers
            .into_iter()
            .zip(scene.followers.iter().cycle())
            .map(|(follower, own)| {
                let by = inertia(own) / inertia(&follower).max(1e-12);
                heavier(&follower, by)
            })
            .collect();
        MachineScene { followers, ..scene }
    })
}

/// Mechanisms cost ten times as much.
fn some_linked() -> impl Strategy<Value = MachineScene> {
    prop_oneof![5 => machine(), 1 => linked()]
}

/// Of drives with backlash, whose search for the periodic motion takes up to 2000 turns.
fn not_periodic<S: Scene>(
    scenes: impl Strategy<Value = S>,
    modes: impl Strategy<Value = Start>,
) -> impl Strategy<Value = S> {
    started(scenes, modes).prop_map(|mut scene| {
        if *scene.start() == Start::Steady {
            *scene.start() = Start::Given;
        }
        scene
    })
}

/// Series and the same as a table. With h the distance of the points, its quintic spline meets U″ to about (Kh)⁴/720 = 4e-11 of
/// its size and U‴, which q̇ of a stiff drive follows, to (Kh)³/60 = 3e-8.
fn series_and_table() -> impl Strategy<Value = [MotionLaw; 2]> {
    fourier().prop_map(|law| {
        let series = law.series().expect("a series");
        let few = |list: &[f64]| list.iter().take(3).copied().collect();
        let series = Fourier::new(few(&series.a), few(&series.b));
        let table = as_table(&series, 1000);
        [MotionLaw::Fourier(series), table]
    })
}

/// Whether a law has a plan that passes `k` times in a turn: two points of a plan are a thousandth apart.
fn has_plan(law: &MotionLaw, k: usize) -> bool {
    let MotionLaw::Cycle(cycle) = law else { return true };
    let plan = cycle.plan();
    let short = |dwell: f64| 1e-9 < dwell && dwell < 2e-3 * k as f64;
    !short(plan.lower_dwell()) && !short(plan.upper_dwell)
}

/// Scenes and gears behind which cycles are plans.
fn behind_gears<S: Scene>(scenes: impl Strategy<Value = S>) -> impl Strategy<Value = (S, usize)> {
    (scenes, 2..5_usize)
        .prop_filter("a plan", |(scene, k)| scene.clone().laws().into_iter().all(|law| has_plan(law, *k)))
}

/// A cycle and the same as a plan.
fn cycle_and_plan() -> impl Strategy<Value = [MotionLaw; 2]> {
    cycle().prop_filter("a plan", |law| has_plan(law, 1)).prop_map(|law| {
        let MotionLaw::Cycle(cycle) = &law else { unreachable!("a cycle") };
        let plan = as_plan(cycle);
        [law, plan]
    })
}

fn decades_around(one: f64) -> impl Strategy<Value = f64> {
    decades(-one, one)
}

/// Cases of a relation in each drive; the suite is to be short.
const CASES: u32 = 12;

/// Many of the random drives have no periodic motion.
const REJECTS: u32 = 100 * CASES;

/// The relations of all drives.
macro_rules! of_drives {
    ($($name:ident: $scene:expr, $modes:ident, $seed:expr;)*) => {$(
        mod $name {
            use super::*;

            proptest! {
                #![proptest_config(config(CASES, REJECTS, $seed))]

                #[test]
                fn origin_of_the_angle(scene in $modes($scene, any_start()), angle in -7.0..7.0_f64, turns in -9..9) {
                    origin(&scene, angle, turns)?;
                }

                #[test]
                fn sense_of_rotation(scene in $modes($scene, any_start())) { sense(&scene)?; }

                #[test]
                fn units_of_the_quantities(
                    scene in $modes($scene, any_start()), kg in decades_around(1.5), m in decades_around(1.5), s in decades_around(1.5)
                ) {
                    units(&scene, [kg, m, s])?;
                }

                #[test]
                fn restart_from_outputs(scene in $modes($scene, any_start()), share in 0.0..1.0_f64) {
                    restart(&scene, share)?;
                }

                #[test]
                fn one_periodic_motion(scene in $modes($scene, Just(Start::Steady)), share in 0.0..1.0_f64) {
                    prop_assume!(*scene.clone().start() == Start::Steady);
                    one_orbit(&scene, share)?;
                }

                #[test]
                fn return_after_periods(scene in $modes($scene, Just(Start::Steady)), periods in 1..5_u32) {
                    prop_assume!(*scene.clone().start() == Start::Steady);
                    return_to_start(&scene, periods)?;
                }
            }
        }
    )*};
}

of_drives! {
    elastic_output: output(), started, 41;
    linear_shaft: shaft(Model::LinearShaft, 10.0), started, 42;
    nonlinear_shaft: shaft(Model::Shaft, 10.0), started, 43;
    backlash_drive: backlash(), started, 44;
    parametric_series: parametric::of_series(), started, 45;
    parametric_crank: parametric::of_crank(), started, 46;
    rigid_machine: some_linked(), machines, 47;
}

/// The relations of drives with motion laws.
macro_rules! of_cams {
    ($($name:ident: $scene:expr, $modes:ident, $seed:expr;)*) => {$(
        mod $name {
            use super::*;

            proptest! {
                #![proptest_config(config(CASES, REJECTS, $seed))]

                #[test]
                fn behind_a_gear((scene, k) in behind_gears($modes($scene, any_start()))) { gear(&scene, k)?; }

                #[test]
                fn series_as_table(scene in $modes($scene, any_start()), [law, other] in series_and_table()) {
                    form(&scene, &law, &other, 1e-7)?;
                }

                #[test]
                fn cycle_as_plan(scene in $modes($scene, any_start()), [law, other] in cycle_and_plan()) {
                    form(&scene, &law, &other, 0.0)?;
                }
            }
        }
    )*};
}

of_cams! {
    cam_with_elastic_output: output(), started, 51;
    cam_with_linear_shaft: shaft(Model::LinearShaft, 10.0), started, 52;
    cam_with_shaft: shaft(Model::Shaft, 10.0), started, 53;
    cam_with_backlash: backlash(), not_periodic, 54;
    cams_of_machine: some_linked(), machines, 55;
}

proptest! {
    #![proptest_config(config(CASES, REJECTS, 57))]

    #[test]
    fn parametric_series_behind_a_gear(scene in started(parametric::of_series(), any_start()), k in 2..5_usize) {
        gear(&scene, k)?;
    }

    #[test]
    fn follower_in_two(scene in machines(some_linked(), any_start())) { split(&scene)?; }

    #[test]
    fn tool_behind_gears(scene in machines(machine(), any_start()), ratio in decades_around(1.0), share in 0.0..1.0_f64) {
        gears(&scene, ratio, share)?;
    }
}

proptest! {
    // Each takes a dozen searches for the periodic motion.
    #![proptest_config(config(CASES / 3, REJECTS, 58))]

    #[test]
    fn energy_of_periodic_starts(scene in smooth()) { energy_at_start(&scene)?; }
}
