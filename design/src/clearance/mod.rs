//! The passage of the clearance: every angle of a motion law at which a drive with backlash changes flanks, how hard the impact
//! is, whether further impacts follow, and which natural frequency or speed avoids them.
//!
//! [`law`] finds the angles, [`crate::formulas::passage`] has Kaltofen's closed formulas for one passage, [`borders`] the map
//! of multiple impacts, [`tuning`] the values that it admits. [`passage`] compares the formula with the event-driven model,
//! which starts from the motion of permanent contact ([`contact_motion`]). [`by_model`] finds the values that the model admits;
//! the model decides if the two differ. [`settled`] runs it until it repeats, with all effects of earlier impacts. [`report`]
//! and [`figures`] show the findings.

pub mod borders;
pub mod by_model;
pub mod contact_motion;
pub mod figures;
pub mod law;
pub mod machine;
pub mod passage;
mod printed;
pub mod report;
pub mod settled;
#[cfg(test)]
mod tests;
pub mod tuning;

use crate::Progress;
use crate::formulas::passage::Passage;
use crate::law_motions::{greatest_of, stroke};
use crate::report::terminal::shown;
use crate::report::unit::PERCENT;
use crate::resource::{self, Resource};
use borders::Sequel;
use by_model::ByModel;
use camdrive::drives::backlash::{self, Scene};
use camdrive::drives::shaft::cam_drive::DriveMode;
use camdrive::drives::{Fault, Number, elastic_output, shaft::cam_turn::turns};
use camdrive::motion::MotionLaw;
use contact_motion::{ContactMotion, Release};
use law::{Crossing, Signs};
use machine::Machine;
use passage::{Bench, Clearance, Figures};
use serde::Serialize;
use settled::SettledMotion;
use std::f64::consts::TAU;
use tuning::{Passages, Tuning};

/// Options of a study.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Options {
    /// Clearance instead of the scene's (m).
    pub clearance: Option<f64>,
    /// Mass at the clearance instead of the scene's (kg).
    pub m1: Option<f64>,
    /// Speed instead of the scene's (rad/s).
    pub speed: Option<f64>,
    /// ω = √(c/m2) instead of the scene's, by another stiffness (rad/s); the damping ratio stays.
    pub natural_frequency: Option<f64>,
    /// Damping ratio D = b/(2 m2 ω) instead of the scene's.
    pub damping: Option<f64>,
    /// Turns of the settled motion; as many as it takes to repeat if none are given.
    pub turns: Option<usize>,
    /// Lobes of U″ and of the contact force below this part of the largest one are no passages; [`IGNORE`], and the noise of
    /// a table.
    pub ignore: Option<f64>,
    /// The height of lobes of U″ of the scene's law that are noise (m); 0 for all laws but smoothed tables.
    pub noise: f64,
    /// Leave out the values that the model admits, which take most of the time.
    pub quick: bool,
    /// Further laws in the place of the scene's, with their names and the height of lobes of their U″ that are noise (m).
    pub laws: Vec<(String, MotionLaw, f64)>,
}

/// Lobes this much lower than the largest one are roundings of a law or of a table.
pub const IGNORE: f64 = 1e-9;

/// Passages that the model follows, at most; a law that rests on a vibration has any number of them.
const MOST_FOLLOWED: usize = 40;

/// Internal steps for all passages of a law, and for its settled motion: about a second of computing each.
const MOST_STEPS: f64 = 1e6;

/// An expected error of the formulas above which the report warns.
pub const WARN: f64 = 0.1;

/// The result.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ClearanceAnalysis {
    /// The name of the scene.
    pub scene: String,
    /// The parameters.
    pub machine: Parameters,
    /// The laws, the scene's first.
    pub laws: Vec<Study>,
}

/// The parameters that the formulas depend on, coherent SI.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Parameters {
    /// Mass at the clearance (kg).
    pub m1: f64,
    /// Working mass (kg).
    pub m2: f64,
    /// Stiffness (N/m).
    pub c: f64,
    /// Damping (N·s/m).
    pub b: f64,
    /// Clearance (m).
    pub s: f64,
    /// Coefficient of restitution.
    pub e: f64,
    /// Ω (rad/s).
    pub speed: f64,
    /// ω = √(c/m2) (rad/s).
    pub omega: f64,
    /// μ = m1/m2.
    pub mu: f64,
    /// η = Ω/ω.
    pub eta: f64,
}

/// Result for one law.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Study {
    /// "scene", or the name by which the law is compared.
    pub law: String,
    /// max U − min U over the turn (m).
    pub stroke: f64,
    /// max |U″| (m).
    pub acceleration: f64,
    /// Zeros of U″ with a change of sign.
    pub crossings: usize,
    /// Zeros left out as too small.
    pub ignored: usize,
    /// Changes of sign of the exact contact force; None if it has no periodic motion.
    pub releases: Option<usize>,
    /// The largest contact force of the periodic motion without clearance (N); None without such a motion.
    pub contact_force: Option<f64>,
    /// The least angle between neighbouring zeros of U″ (rad).
    pub least_spacing: Option<f64>,
    /// The passages, by angle.
    pub passages: Vec<Clearance>,
    /// Whether all passages stay without further impacts.
    pub calm: Calm,
    /// The frequencies, speeds and clearances without multiple impacts, by the formulas.
    pub tuning: Option<Tuning>,
    /// The values that the model admits; None if e > 0, which rebounds m1 at all of them, and if that takes long.
    pub by_model: Option<ByModel>,
    /// The motion that the drive settles to.
    pub settled: Option<SettledMotion>,
    /// Parts that could not be computed, and reasons to distrust the formulas.
    pub remarks: Vec<String>,
    /// U″ over the turn.
    #[serde(skip)]
    pub course: Vec<[f64; 2]>,
}

/// Whether each passage ends with one impact and lasting contact.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Calm {
    /// By the formulas, for the zeros of U″; None if one of them has no K.
    pub by_formulas: Option<bool>,
    /// By the model, for all changes of sign of the contact force; None if it could not be followed.
    pub by_model: Option<bool>,
}

/// Studies the passages of the clearance.
///
/// # Errors
/// A model without clearance, a shaft at rest, options out of range.
pub fn study(resource: &Resource, options: &Options, progress: impl Fn(Progress)) -> Result<ClearanceAnalysis, Fault> {
    let scene = scene(resource, options)?;
    let w = speed(&scene, options)?;
    let omega = (scene.parameters.c / scene.parameters.m2).sqrt();
    let backlash::Parameters { m1, m2, c, b, s, e } = scene.parameters;
    let machine = Parameters { m1, m2, c, b, s, e, speed: w, omega, mu: m1 / m2, eta: w.abs() / omega };
    if !(machine.mu > 0.0 && machine.mu.is_finite() && omega > 0.0 && omega.is_finite()) {
        return Err(Fault::new(format!("m1/m2 = {} and √(c/m2) = {omega} rad/s must be finite and not 0", machine.mu)));
    }
    let own = ("scene".to_owned(), scene.cam.clone(), options.noise);
    let laws: Vec<&(String, MotionLaw, f64)> = std::iter::once(&own).chain(&options.laws).collect();
    let mut studies = Vec::new();
    for (done, (name, law, noise)) in laws.iter().enumerate() {
        progress(Progress { done, total: laws.len(), stage: name });
        let scene = Scene { cam: law.clone(), ..scene.clone() };
        studies.push(of_law(name, &scene, &machine, options, *noise));
    }
    Ok(ClearanceAnalysis { scene: resource.name.clone(), machine, laws: studies })
}

/// The drive with backlash of the scene and its options.
fn scene(resource: &Resource, options: &Options) -> Result<Scene, Fault> {
    let mut scene: Scene = match resource.scene.clone() {
        resource::Scene::BacklashDrive(scene) => scene,
        resource::Scene::ElasticOutput(elastic) => {
            let elastic_output::Scene { parameters, cam, drive, start, solver, .. } = elastic;
            let elastic_output::Parameters { m, c, b } = parameters;
            let (Some(s), Some(m1)) = (options.clearance, options.m1) else {
                return Err(Fault::new("an ElasticCamDrive with an elastic output has no clearance of its own")
                    .hint("give --clearance and --m1, the mass between the flanks; its m becomes m2"));
            };
            Scene {
                parameters: backlash::Parameters { m1, m2: m, c, b, s, e: 0.0 },
                cam,
                drive,
                coupling: false,
                start,
                solver,
            }
        }
        resource::Scene::DriveTrain(_) => {
            return Err(Fault::new("the study is for a single drive without loads that has both flanks")
                .hint("write a follower of a train as a scene of its own, without `load` and with `s`"));
        }
        other => {
            let model = other.model();
            return Err(Fault::new(format!(
                "the model is {model}; the study is for a BacklashDrive, or for an ElasticCamDrive with \
                 place = \"output\" together with --clearance and --m1"
            ))
            .hint("write a follower of a machine or a train as a scene of its own"));
        }
    };
    scene.parameters.s = options.clearance.unwrap_or(scene.parameters.s);
    scene.parameters.m1 = options.m1.unwrap_or(scene.parameters.m1);
    let [clearance, m1] = [options.clearance, options.m1].map(|given| if given.is_some() { "--" } else { "" });
    let checked = [("clearance", clearance, scene.parameters.s, "m"), ("m1", m1, scene.parameters.m1, "kg")];
    for (name, dashes, value, unit) in checked {
        if !(value > 0.0 && value.is_finite()) {
            let option = format!("{dashes}{name}");
            return Err(Fault::new(format!("{option}: {value} {unit} is not greater than 0"))
                .of(option)
                .hint(format!("give another one by --{name}")));
        }
    }
    if let Some(omega) = options.natural_frequency {
        if !(omega > 0.0 && omega.is_finite()) {
            return Err(Fault::new(format!("--natural-frequency is {omega} rad/s, it must be greater than 0"))
                .of("--natural-frequency")
                .hint("write for example \"80 Hz\""));
        }
        let backlash::Parameters { m2, c, b, .. } = &mut scene.parameters;
        let before = (*c / *m2).sqrt();
        (*c, *b) = (*m2 * omega * omega, *b * (omega / before));
    }
    if let Some(ratio) = options.damping {
        if !(ratio >= 0.0 && ratio.is_finite()) {
            return Err(Fault::new(format!("--damping is {ratio}, it must be at least 0"))
                .of("--damping")
                .hint("write for example 0.03"));
        }
        let backlash::Parameters { m2, c, b, .. } = &mut scene.parameters;
        *b = 2.0 * ratio * (*c * *m2).sqrt();
    }
    if options.ignore.is_some_and(|ignore| !(0.0..1.0).contains(&ignore)) {
        return Err(Fault::new("--ignore is a part of the largest value, from 0 to below 1")
            .of("--ignore")
            .hint("write for example 1e-3"));
    }
    Ok(scene)
}

/// The speed to study (rad/s).
fn speed(scene: &Scene, options: &Options) -> Result<f64, Fault> {
    let w = match (options.speed, &scene.drive) {
        (Some(w), _) => w,
        (None, DriveMode::Constant { w, .. }) => *w,
        (None, DriveMode::Input | DriveMode::Speed { .. }) => {
            return Err(Fault::new("the inputs move the drive of this scene")
                .hint("give the speed of the study, --speed \"300 rpm\""));
        }
    };
    if turns(w) && w.is_finite() {
        return Ok(w);
    }
    Err(Fault::new(format!("the speed is {} rpm: a shaft at rest passes no clearance", Number(w * 60.0 / TAU)))
        .hint("give --speed \"300 rpm\""))
}

/// The angle from `from` to `to` in the sense of the motion, in (0, 2π] (rad).
fn ahead(from: f64, to: f64, w: f64) -> f64 {
    let angle = ((to - from) * w.signum()).rem_euclid(TAU);
    if angle > 0.0 { angle } else { TAU }
}

/// The distance of two angles, at most π (rad).
fn apart(a: f64, b: f64) -> f64 {
    let angle = (a - b).rem_euclid(TAU);
    angle.min(TAU - angle)
}

fn of_law(name: &str, scene: &Scene, machine: &Parameters, options: &Options, noise: f64) -> Study {
    let w = machine.speed;
    let ignore = options.ignore.unwrap_or_else(|| match noise {
        0.0 => IGNORE,
        noise => noise / greatest_of(&scene.cam, |u| u[2].abs()),
    });
    let Signs { crossings, largest, ignored } = law::signs(&scene.cam, w > 0.0, ignore);
    let course = (0..=720).map(|i| TAU * f64::from(i) / 720.0);
    let usable: Vec<&Crossing> = crossings.iter().filter(|crossing| crossing.jerk != 0.0).collect();
    let mut study = Study {
        law: name.to_owned(),
        stroke: stroke(&scene.cam, |u| u[0]),
        acceleration: largest,
        crossings: crossings.len(),
        ignored,
        least_spacing: spacing(&crossings),
        tuning: Tuning::new(
            borders::admissible(machine.mu),
            &Passages {
                jerks: usable.iter().map(|crossing| crossing.jerk.abs()).collect(),
                curvatures: usable.iter().map(|crossing| (crossing.fifth / crossing.jerk).abs()).collect(),
                s: scene.parameters.s,
                omega: machine.omega,
                speed: w.abs(),
                m2: machine.m2,
            },
        ),
        course: course.map(|phi| [phi, scene.cam.at(phi - TAU * (phi / TAU).round()).0[2]]).collect(),
        ..Study::default()
    };
    if noise > 0.0 {
        study.remarks.push(format!(
            "The table is smoothed: lobes of U″ and of the contact force below {} of the largest one count as its noise, not \
             as passages.",
            shown(ignore, &PERCENT)
        ));
    }
    if let Err(fault) = study.follow(scene, machine, &crossings, (options, ignore)) {
        study.remarks.push(format!("The event-driven model cannot be run: {fault}."));
        study.passages = passages(scene, machine, &crossings, None);
    }
    let of_crossings = study.passages.iter().filter(|passage| passage.crossing.is_some());
    let by_formulas: Option<Vec<Sequel>> = of_crossings.map(|passage| Some(passage.formula?.sequel)).collect();
    study.calm = Calm {
        by_formulas: by_formulas.map(|sequels| sequels.iter().all(|sequel| *sequel == Sequel::None)),
        by_model: by_model::is_calm(&study.passages, study.releases),
    };
    remark(&mut study);
    study
}

impl Study {
    /// Adds the event-driven model's findings: the passages from permanent contact on, the values that it admits, the settled
    /// motion.
    ///
    /// # Errors
    /// A scene that it refuses.
    fn follow(
        &mut self,
        scene: &Scene,
        machine: &Parameters,
        crossings: &[Crossing],
        (options, ignore): (&Options, f64),
    ) -> Result<(), Fault> {
        let mut model = Machine::new(scene, machine.speed)?;
        model.allow(MOST_STEPS);
        let motion = ContactMotion::new(&mut model, scene, ignore);
        let run = motion.as_ref().ok().map(|motion| (&mut model, motion));
        self.passages = passages(scene, machine, crossings, run);
        let mut start = [0.0; 2];
        match motion {
            Ok(motion) => {
                let releases = motion.releases.len();
                self.releases = Some(releases);
                self.contact_force = motion.largest_force(&mut model).ok();
                if scene.parameters.e == 0.0 && !options.quick {
                    let variation = by_model::Variation { scene, machine, crossings, ignore };
                    self.by_model = variation.around(&motion, options.turns);
                }
                start = motion.samples[0].q;
                let followed = self.passages.iter().filter(|p| p.model.is_some() || p.fault.is_some()).count();
                if releases > followed {
                    self.remarks.push(format!(
                        "The model has followed {followed} of {releases} changes of sign of the contact force; more would \
                         take too long."
                    ));
                }
            }
            Err(fault) => self.remarks.push(format!("The model has not followed the passages: {fault}.")),
        }
        model.allow(MOST_STEPS);
        match settled::run(&mut model, start, options.turns) {
            Ok(settled) => self.settled = Some(settled),
            Err(fault) => self.remarks.push(format!("The settled motion has not been found: {fault}.")),
        }
        Ok(())
    }
}

fn spacing(crossings: &[Crossing]) -> Option<f64> {
    let following = crossings.iter().cycle().skip(1);
    crossings.iter().zip(following).map(|(a, b)| ahead(a.phi, b.phi, 1.0)).reduce(f64::min)
}

/// The zeros of U″ with their exact releases: the nearest one of the same sense, each at most once.
fn pairs(crossings: &[Crossing], releases: &[Release], w: f64) -> Vec<(Option<usize>, Option<usize>)> {
    let falling = |crossing: &Crossing| crossing.jerk * w < 0.0;
    let nearest = |of: &dyn Fn(usize) -> Option<f64>, count: usize| {
        let candidates = (0..count).filter_map(|i| Some((i, of(i)?)));
        candidates.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(i, _)| i)
    };
    let distance = |c: usize, r: usize| {
        let same = falling(&crossings[c]) == releases[r].falling;
        same.then(|| apart(crossings[c].phi, releases[r].phi))
    };
    let of_crossing = |c: usize| nearest(&|r| distance(c, r), releases.len());
    let of_release = |r: usize| nearest(&|c| distance(c, r), crossings.len());
    let mut list: Vec<_> =
        (0..crossings.len()).map(|c| (Some(c), of_crossing(c).filter(|r| of_release(*r) == Some(c)))).collect();
    let lonely = |r: &usize| !list.iter().any(|(_, other)| *other == Some(*r));
    let others: Vec<_> = (0..releases.len()).filter(lonely).map(|r| (None, Some(r))).collect();
    list.extend(others);
    let phi = |(c, r): &(Option<usize>, Option<usize>)| c.map(|c| crossings[c].phi).or(r.map(|r| releases[r].phi));
    list.sort_by(|a, b| phi(a).unwrap_or(0.0).total_cmp(&phi(b).unwrap_or(0.0)));
    list
}

fn passages(
    scene: &Scene,
    machine: &Parameters,
    crossings: &[Crossing],
    model: Option<(&mut Machine, &ContactMotion)>,
) -> Vec<Clearance> {
    let Parameters { s, speed: w, omega, mu, eta, .. } = *machine;
    let releases = model.as_ref().map_or(&[][..], |(_, motion)| &motion.releases);
    let pairs = pairs(crossings, releases, w);
    let angles: Vec<f64> = if releases.is_empty() {
        crossings.iter().map(|c| c.phi).collect()
    } else {
        releases.iter().map(|r| r.phi).collect()
    };
    let slope = |phi: f64| scene.cam.at(phi - TAU * (phi / TAU).round()).0[1];
    let mut bench = model.map(|(machine, motion)| Bench { machine, motion, scene, slope: &slope });
    let mut list = Vec::new();
    let mut followed = 0;
    for (crossing, release) in pairs {
        let crossing = crossing.map(|c| crossings[c]);
        let release = release.map(|r| releases[r]);
        let phi = release.map(|r| r.phi).or(crossing.map(|c| c.phi)).unwrap_or(0.0);
        let falling = release.map_or_else(|| crossing.is_some_and(|c| c.jerk * w < 0.0), |r| r.falling);
        let spacing = angles.iter().map(|other| ahead(phi, *other, w)).filter(|a| *a > 1e-12).fold(TAU, f64::min);
        let k = crossing.filter(|c| c.jerk != 0.0).map(|c| s / (c.jerk.abs() * eta.powi(3)));
        let passage = k.filter(|k| k.is_finite() && *k > 0.0).map(|k| Passage::new(mu, k));
        let mut clearance = Clearance {
            from: if falling { 'A' } else { 'B' },
            k,
            formula: passage.zip(crossing).map(|(p, c)| Figures::by_formula(&p, &c, scene, w)),
            model: None,
            fault: None,
            quasi_static: crossing.filter(|c| c.jerk != 0.0).map(|c| eta * eta * (c.fifth / c.jerk).abs()),
            truncation: None,
            spacing,
            left: 0.0,
            course: passage.as_ref().map(Figures::course).unwrap_or_default(),
            crossing,
        };
        if let (Some(bench), Some(release)) = (&mut bench, release)
            && followed < MOST_FOLLOWED
            && !bench.machine.is_exhausted()
        {
            followed += 1;
            // Without a formula the clearance itself gives a scale: s = Ü-free flight of a tenth of a period.
            let scale = clearance.formula.map_or(0.1 * TAU / omega, |formula| formula.time);
            match bench.follow(&release, spacing / w.abs(), scale) {
                Ok((figures, course)) => {
                    clearance.model = Some(figures);
                    clearance.course = merged(clearance.course, course);
                }
                Err(fault) => clearance.fault = Some(fault.to_string()),
            }
        }
        let figures = clearance.formula.or(clearance.model);
        clearance.truncation = crossing
            .zip(figures)
            .filter(|(c, _)| c.jerk != 0.0)
            .map(|(c, figures)| figures.angle * (c.fourth / (4.0 * c.jerk)).abs());
        let rest = figures.map_or(spacing, |figures| (spacing - figures.angle).max(0.0));
        clearance.left = (-0.5 * scene.parameters.b / scene.parameters.m2 * rest / w.abs()).exp();
        list.push(clearance);
    }
    list
}

/// The points of the formula with those of the model.
fn merged(formula: Vec<passage::VibrationPoint>, model: Vec<passage::VibrationPoint>) -> Vec<passage::VibrationPoint> {
    if formula.is_empty() {
        return model;
    }
    let both = formula.into_iter().zip(model);
    both.map(|(a, b)| passage::VibrationPoint { q: [a.q[0], b.q[1]], force: [a.force[0], b.force[1]], ..a }).collect()
}

/// Notes what the passages ignore.
fn remark(study: &mut Study) {
    let left = study.passages.iter().map(|p| p.left).fold(0.0, f64::max);
    let remarks = &mut study.remarks;
    if left > WARN && !study.passages.is_empty() {
        remarks.push(format!(
            "Up to {} of the vibration after an impact is left at the next passage. The table of passages ignores it; the \
             settled motion includes it.",
            shown(left, &PERCENT)
        ));
    }
}
