//! The periodic motion at the speed of the scene, and the additions of vibration, loads and impacts to the kinetostatic
//! figures.

use super::{Overview, Warning};
use crate::law_motions::shown;
use crate::periodic_turn::{self, Harmonic, NEUTRAL, Turn};
use crate::report::unit::{DEG, NS, RPM};
use crate::report::{Level, Setting, WrittenValue, terminal};
use crate::resource::{Described, Resource, Scene};
use crate::stability::report::{disagreement, must_not_run};
use crate::{oscillator, stability, text};
use camdrive::drives::limits::NOT_FOUND;
use camdrive::drives::parametric::law::Law;
use camdrive::drives::shaft::cam_drive::DriveMode;
use camdrive::drives::variable::Causality;

/// The names of the figures of outputs.
const NAMES: [(&str, &str); 5] = [
    ("q", "largest_deformation"),
    ("force", "largest_force"),
    ("contact_force", "largest_contact_force"),
    ("tau", "largest_torque"),
    ("M_an", "largest_motor_torque_on_the_shaft"),
];

/// A harmonic this close to the natural frequency, as a part of it, may be in resonance; if coefficients vary over the turn,
/// resonances are up to a fifth off.
const NEAR: f64 = 0.25;

/// A deformation, or a harmonic near the natural frequency, this many times as large as all loads would make it without vibration
/// is raised: away from resonance the vibration is at most as large as these.
const RAISED: f64 = 2.0;

/// The same for a speed that is advised: the machine need not keep it exactly.
const CALM: f64 = 1.5;

/// In a resonance the harmonic near the natural frequency alone deforms this many times as much as all loads without vibration.
const RESONANT: f64 = 1.0;

/// A harmonic at the natural frequency with this part of the deformation without vibration is noted, though it raises little.
const NOTED: f64 = 0.1;

/// The remedy against lift-off.
const HOLD: &str = "raise the preload or lower the speed; `camdrive forces` computes both";

/// A start that deforms this many times as much as the periodic motion is far from it: a load applied at once deforms twice.
const FAR: f64 = 2.0;

/// Calm speeds are searched in steps of this part, half the width of a resonance with a damping ratio of 2 %, this many to
/// each side: up to a factor of 1.5, beyond which it is another machine.
const STEPS: (f64, i32) = (0.02, 20);

/// The name of a figure of follower j; 0 for a drive with one.
fn named(j: usize, name: &str) -> String {
    if j == 0 { name.to_owned() } else { format!("follower[{j}].{name}") }
}

/// A speed (rad/s) as people write it.
fn rounded(w: f64) -> f64 {
    text::digits(w * RPM.factor, 3, -4).parse().map_or(w, |rpm: f64| rpm / RPM.factor)
}

/// "follower 2: " before a message on follower j; nothing before one on the only follower.
fn of(scene: &Scene, j: usize) -> String {
    if scene.followers() <= 1 { String::new() } else { format!("follower {j}: ") }
}

/// The keys of the damping of follower j, counted from 1, or of the only one.
fn damping(scene: &Scene, j: usize) -> String {
    let (section, b) = match scene {
        Scene::BacklashDrive(_) => ("backlash".to_owned(), "b"),
        Scene::ParametricDrive(scene) if matches!(scene.law, Law::Crank(_)) => ("crank".to_owned(), "b_T"),
        Scene::ParametricDrive(_) => return "`coefficients.b`".to_owned(),
        Scene::DriveTrain(train) => {
            let joint = train.followers.get(j.saturating_sub(1)).map(|follower| follower.joint);
            let loose = joint.is_some_and(|joint| joint.clearance().is_some());
            (format!("follower[{}].{}", j.max(1), if loose { "backlash" } else { "elasticity" }), "b")
        }
        _ => ("elasticity".to_owned(), "b"),
    };
    format!("`{section}.damping_ratio` or `{section}.{b}`")
}

/// The deformation of a follower with its vibration and without.
struct Rise {
    /// The largest deformation of the periodic motion.
    largest: f64,
    /// The largest one without vibration.
    kinetostatic: f64,
    /// Half the range of that one.
    swing: f64,
    /// The strongest harmonic near the natural frequency.
    near: Option<Harmonic>,
    unit: &'static str,
}

impl Rise {
    /// How many times as much the harmonic near the natural frequency deforms as all loads without vibration.
    fn of_harmonic(&self) -> f64 {
        self.near.as_ref().map_or(0.0, |near| near.amplitude / self.swing)
    }

    /// The larger one of that and the rise of the largest deformation.
    fn factor(&self) -> f64 {
        self.of_harmonic().max(self.largest / self.kinetostatic)
    }

    /// True if no speed like that is advised.
    fn is_rough(self) -> bool {
        self.factor() >= CALM
    }
}

impl Overview {
    /// Adds the figures of the periodic motion, and its warnings; `advised` if the speed is one that may be advised.
    pub(super) fn steady(&mut self, resource: &Resource, advised: bool) {
        let Some(turn) = self.turn.take() else { return self.without_motion(resource, advised) };
        for range in &turn.outputs {
            let (part, j) = range.part();
            if let Some((_, name)) = NAMES.iter().find(|(of, _)| *of == part) {
                self.sized(named(j, name), range.peak().value.abs(), range.unit, range.size);
            }
        }
        if let Some(turns) = turn.settles().filter(|_| turn.outputs.iter().any(|range| range.part().0 == "q")) {
            self.figure("turns_until_settled", turns, "1");
        }
        for dwell in turn.dwells(&resource.scene) {
            let name = named(periodic_turn::part(&dwell.output).1, "largest_vibration_in_a_dwell");
            match self.figures.iter_mut().find(|figure| figure.name == name) {
                Some(figure) if figure.value >= dwell.largest => {}
                Some(figure) => (figure.value, figure.shown) = (dwell.largest, dwell.shown(dwell.largest)),
                None => self.sized(name, dwell.largest, dwell.unit, dwell.size),
            }
        }
        let starts = far_starts(resource, &turn);
        // Another speed need not cure those.
        let spared = self.warnings.len() + starts.len();
        self.hits(resource, &turn);
        self.is_unstable(resource, &turn);
        self.resonates(resource, &turn, if advised { None } else { Some(spared) });
        for message in starts {
            self.cures.push((self.warnings.len(), Setting::new("start.mode", "steady_state")));
            let hint = "set `start.mode` = \"steady_state\" to begin on the periodic motion".to_owned();
            self.minds(Level::Mind, message, hint);
        }
        self.turn = Some(turn);
    }

    /// Adds a warning on the motion.
    fn minds(&mut self, level: Level, message: String, hint: String) {
        self.of_motion.push((self.warnings.len(), level));
        self.warnings.push(Warning { message, hint });
    }

    /// Warns of a speed at which no motion repeats.
    fn without_motion(&mut self, resource: &Resource, advised: bool) {
        if !matches!(resource.scene.drive(), Some(DriveMode::Constant { w, .. }) if *w != 0.0) {
            return;
        }
        // Other inputs need not repeat with the turns.
        let has_inputs = |drive: &Described| drive.descriptions().iter().any(|d| d.causality == Causality::Input);
        if resource.build().is_ok_and(|drive| has_inputs(&drive)) {
            return;
        }
        let Some(fault) = self.motionless.clone() else { return };
        let j = resource.scene.followers().min(1);
        let mut message = periodic_turn::reason(&fault);
        let ratio = self.value(&named(j, "frequency_ratio")).unwrap_or(0.0);
        let harmonic = (1.0 / ratio).round();
        if message == NOT_FOUND && (harmonic * ratio - 1.0).abs() <= NEAR {
            let ratio = text::number(harmonic * ratio);
            message += &format!(" near a resonance: harmonic {harmonic} has {ratio} times the natural frequency");
        }
        if linear(&resource.scene).is_some_and(|growth| growth <= 1.0 + NEUTRAL) {
            message += "; the linear equation is stable at this speed (`camdrive stability`)";
        }
        let spared = self.warnings.len();
        let hint = self.cure(resource, j, if advised { None } else { Some(spared) });
        let level = if fault.motionless.as_deref() == Some(NOT_FOUND) { Level::Mind } else { Level::Bad };
        self.minds(level, message, hint);
    }

    /// Warns of followers that leave their cams in the periodic motion, and notes the impacts of others.
    fn hits(&mut self, resource: &Resource, turn: &Turn) {
        for (j, impacts) in turn.impacts.iter().enumerate() {
            let Some(impacts) = impacts.filter(|impacts| *impacts > 0.0) else { continue };
            let of = if turn.impacts.len() == 1 { "the follower".to_owned() } else { format!("follower {}", j + 1) };
            let own = turn.impulses.iter().filter(|impact| impact.follower == j + 1);
            let hardest = own.max_by(|a, b| a.impulse.total_cmp(&b.impulse)).map_or(String::new(), |hardest| {
                format!(
                    ", the hardest at {} with {}",
                    terminal::shown(hardest.phi, &DEG),
                    terminal::shown(hardest.impulse, &NS)
                )
            });
            let count = text::counted(text::number(impacts), "impact");
            match resource.scene.is_one_sided(j) {
                true => {
                    let message = format!("{of} lifts off its cam and has {count} a turn{hardest}");
                    self.minds(Level::Mind, message, HOLD.to_owned());
                }
                false => self.notes.push(format!("{of} has {count} a turn{hardest}")),
            }
        }
        for pull in turn.pulls() {
            self.minds(Level::Mind, pull.trim_end_matches('.').to_owned(), HOLD.to_owned());
        }
    }

    /// Warns of a motion from which disturbances lead away, and of two equations of a shaft that disagree on it.
    fn is_unstable(&mut self, resource: &Resource, turn: &Turn) {
        let growth = turn.growth.filter(|growth| *growth >= NEUTRAL);
        let (speed, linear) = (text::rpm(turn.mean_speed), linear(&resource.scene));
        let hint = "`camdrive stability` lists the unstable speeds, and the damping that stabilises them".to_owned();
        match (growth, linear) {
            (Some(growth), None) if oscillator::of(&resource.scene).is_ok() => {
                self.minds(Level::Bad, must_not_run(turn.mean_speed, growth.exp()), hint);
            }
            (Some(_), linear) => {
                let stable = linear.is_some_and(|growth| growth <= 1.0 + NEUTRAL);
                let but = if stable { "; the linear equation is stable there (`camdrive stability`)" } else { "" };
                let hint = format!("choose another speed or more damping ({})", damping(&resource.scene, 0));
                let message = format!("the periodic motion at {speed} rpm is unstable: turns differ{but}");
                self.minds(Level::Mind, message, hint);
            }
            (None, Some(radius)) if radius > 1.0 + NEUTRAL => {
                self.minds(Level::Mind, disagreement(turn.mean_speed, radius), hint);
            }
            _ => {}
        }
    }

    /// A value by its name.
    pub(super) fn value(&self, name: &str) -> Option<f64> {
        self.figures.iter().find(|figure| figure.name == name).map(|figure| figure.value)
    }

    /// The deformation of follower j, counted from 1, or of the only one; None without an elastic member or a speed.
    fn rise(&self, j: usize, turn: &Turn) -> Option<Rise> {
        let swing = self.swings.get(j.saturating_sub(1)).copied().filter(|swing| *swing > 0.0)?;
        let natural = self.value(&named(j, "natural_frequency"))?;
        let kinetostatic = self.value(&named(j, "largest_kinetostatic_deformation"))?;
        let range = turn.outputs.iter().find(|range| range.part() == ("q", j))?;
        let near = turn.strongest(range, [1.0 - NEAR, 1.0 + NEAR].map(|part| part * natural));
        Some(Rise { largest: range.peak().value.abs(), kinetostatic, swing, near, unit: range.unit })
    }

    /// Warns of deformations that resonances, other vibration or impacts raise, and notes weak resonances; an advised speed, which
    /// spares no warning, has to be calm.
    fn resonates(&mut self, resource: &Resource, turn: &Turn, spared: Option<usize>) {
        for j in 0..=resource.scene.followers() {
            let Some(rise) = self.rise(j, turn) else { continue };
            let (of, times) = (of(&resource.scene, j), text::number(rise.largest / rise.kinetostatic));
            let [largest, without, swing] =
                [rise.largest, rise.kinetostatic, rise.swing].map(|value| shown(value, rise.unit));
            let has_impacts = turn.impacts.get(j.saturating_sub(1)).copied().flatten().is_some_and(|count| count > 0.0);
            let near = rise.near.as_ref().map(|near| (near, shown(near.amplitude, near.unit)));
            let damping = damping(&resource.scene, j);
            if rise.factor() < if spared.is_some() { RAISED } else { CALM } {
                let ratio = self.value(&named(j, "damping_ratio")).unwrap_or(0.0);
                let natural = self.value(&named(j, "natural_frequency")).unwrap_or(f64::NAN);
                let meets = |near: &Harmonic| (near.frequency / natural - 1.0).abs() <= ratio;
                if let Some((near, amplitude)) = near.filter(|(near, _)| meets(near) && rise.of_harmonic() >= NOTED) {
                    let note = format!(
                        "{of}harmonic {} meets the natural frequency: its amplitude is {amplitude}, and the deformation reaches \
                         {largest}, {times} times its kinetostatic value",
                        near.harmonic
                    );
                    // No speed like that is advised.
                    match spared {
                        Some(_) => self.notes.push(note),
                        None => self.minds(Level::Good, note, String::new()),
                    }
                }
                continue;
            }
            let (message, hint) = match near {
                _ if has_impacts => (
                    format!("{of}impacts raise the deformation from {without} to {largest}"),
                    match resource.scene.is_one_sided(j.saturating_sub(1)) {
                        true => HOLD.to_owned(),
                        false => format!("choose another speed, more damping ({damping}) or less clearance"),
                    },
                ),
                Some((near, amplitude)) if rise.of_harmonic() >= RESONANT => {
                    let exceeds = self.exceeds(j, &rise);
                    let lost = if exceeds { "; the tool misses its law by more than the stroke" } else { "" };
                    (
                        format!(
                            "{of}resonance with harmonic {}: its amplitude is {amplitude}; without vibration all loads \
                             deform by ±{swing}{lost}",
                            near.harmonic
                        ),
                        self.cure(resource, j, spared.filter(|_| !exceeds)),
                    )
                }
                near => {
                    let near = near.map_or(String::new(), |(near, amplitude)| {
                        format!(
                            "; the strongest harmonic near the natural frequency is {} with {amplitude}",
                            near.harmonic
                        )
                    });
                    (
                        format!("{of}vibration raises the deformation from {without} to {largest}{near}"),
                        format!("choose a smoother law, a higher natural frequency or more damping ({damping})"),
                    )
                }
            };
            self.minds(Level::Mind, message, hint);
        }
    }

    /// True if the tool would miss its law by the whole stroke: then a little slower or faster does not help.
    fn exceeds(&self, j: usize, rise: &Rise) -> bool {
        let share = self.value(&named(j, "kinetostatic_deformation_of_stroke")).unwrap_or(0.0);
        share * rise.largest / rise.kinetostatic >= 1.0
    }

    /// A remedy against the deformation of follower j: calm speeds, where warnings to spare are known, natural frequency, damping.
    fn cure(&mut self, resource: &Resource, j: usize, spared: Option<usize>) -> String {
        let damping = damping(&resource.scene, j);
        let calm = spared.map_or(Vec::new(), |spared| calm_speeds(resource, spared));
        let speeds: Vec<String> = calm.iter().map(|speed| format!("{} rpm", text::rpm(*speed))).collect();
        if let Some(speed) = calm.first() {
            let setting = Setting::new("drive.speed", WrittenValue::nearest(*speed, &RPM, 3));
            self.cures.push((self.warnings.len(), setting));
        }
        match &speeds[..] {
            [] => format!("choose another natural frequency, another law or more damping ({damping})"),
            speeds => {
                format!(
                    "run at {}, or choose another natural frequency or more damping ({damping})",
                    speeds.join(" or ")
                )
            }
        }
    }
}

/// The factor by which free motions of a shaft's linear equation grow in a turn; None for a drive that is linear, or no shaft.
fn linear(scene: &Scene) -> Option<f64> {
    if matches!(scene, Scene::ElasticShaft(shaft) if !shaft.linear) { stability::growth(scene) } else { None }
}

/// The nearest speeds (rad/s) below and above at which a check warns of no more than it does here without the motion.
fn calm_speeds(resource: &Resource, spared: usize) -> Vec<f64> {
    let Some(DriveMode::Constant { w, .. }) = resource.scene.drive().cloned() else { return Vec::new() };
    let is_calm = |speed: f64| {
        let mut other = resource.clone();
        if let Some(DriveMode::Constant { w, .. }) = other.scene.drive_mut() {
            *w = speed;
        }
        // Most speeds fail at this, which costs least.
        let still = super::kinetostatic(&other);
        let rises =
            |turn: &Turn| (0..=other.scene.followers()).any(|j| still.rise(j, turn).is_some_and(Rise::is_rough));
        if still.turn.as_ref().is_none_or(rises) {
            return false;
        }
        let found = super::at(&other, true);
        let leaves = found.lift_offs.iter().filter_map(|of| of.lift_off_speed.as_ref());
        found.warnings.len() <= spared && leaves.map(|from| from.value).all(|from| from > speed.abs())
    };
    let side = |sign: f64| (1..=STEPS.1).map(|i| rounded(w * (1.0 + sign * STEPS.0).powi(i))).find(|w| is_calm(*w));
    [-1.0, 1.0].into_iter().filter_map(side).collect()
}

/// Messages on starts that deform far more than the periodic motion.
fn far_starts(resource: &Resource, turn: &Turn) -> Vec<String> {
    if matches!(resource.scene, Scene::RigidMachine(_)) {
        return Vec::new();
    }
    let Ok(peaks) = periodic_turn::start_peaks(&resource.scene, turn) else { return Vec::new() };
    let all = turn.outputs.iter().filter(|range| range.part().0 == "q").zip(peaks);
    let far = all.filter(|(range, peak)| {
        let own = range.peak().value.abs();
        *peak >= FAR * own && own > 0.0
    });
    far.map(|(range, peak)| {
        let [start, steady] = [peak, range.peak().value.abs()].map(|value| shown(value, range.unit));
        format!("{}the start deforms {start}, the periodic motion {steady}", of(&resource.scene, range.part().1))
    })
    .collect()
}
