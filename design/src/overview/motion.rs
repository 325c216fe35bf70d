//! The periodic motion at the speed of the scene, and the additions of vibration, loads and impacts to the kinetostatic
//! figures.

use super::{Figure, Overview, Resonance, Warning};
use crate::law_motions::shown;
use crate::periodic_turn::{self, Harmonic, NEUTRAL, NEVER, STANDS, Turn};
use crate::report::unit::{DEG, NS, RPM};
use crate::report::{Level, Setting, WrittenValue, terminal};
use crate::resource::{Resource, Scene};
use crate::stability::report::must_not_run;
use crate::{oscillator, stability, text};
use camdrive::drives::limits::{NO_SPEED, NOT_REPEATED, ON_INPUT, RESONANCE};
use camdrive::drives::parametric::law::Law;
use camdrive::drives::shaft::cam_drive::DriveMode;
use camdrive::numerics::work::{self, Since};
use std::f64::consts::PI;

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

/// Three quarters of that are noted.
const NOTABLE: f64 = 1.5;

/// In a resonance the harmonic near the natural frequency alone deforms this many times as much as all loads without vibration.
const RESONANT: f64 = 1.0;

/// A harmonic at the natural frequency with this part of the deformation without vibration is noted, though it raises little.
const NOTED: f64 = 0.1;

/// The remedy against lift-off.
const HOLD: &str = "raise the preload or lower the speed; `camdrive forces` computes both";

/// The remedy against lift-off on the way to the speed.
const PASS: &str = "pass these speeds quickly, or raise the preload; `camdrive forces` computes it";

/// A start that deforms this many times as much as the periodic motion is far from it: a load applied at once deforms twice.
const FAR: f64 = 2.0;

/// Calm speeds are searched in steps of this part, half the width of a resonance with a damping ratio of 1 %, this many to each
/// side: up to a factor of 1.6, beyond which it is another machine.
const STEPS: (f64, i32) = (0.01, 47);

/// Halvings of the step at the edge of a resonance.
const HALVINGS: usize = 5;

/// Work of the search (nominal µs): three calls of a drive. Where the motion repeats at hardly any speed, each one tried takes
/// thousands of turns.
const SEARCH: f64 = 3.0 * work::BUDGET;

/// The margin of a calm speed to that edge.
const MARGIN: f64 = 0.005;

/// Calm speeds that are tried on each side.
const TRIES: usize = 6;

/// The name of a figure of follower j; 0 for a drive with one.
fn named(j: usize, name: &str) -> String {
    if j == 0 { name.to_owned() } else { format!("follower[{j}].{name}") }
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
}

impl Overview {
    /// Adds the figures of the periodic motion, and its warnings; `advised` if other speeds are not to be.
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
        let spared = self.warnings.len() - self.of_motion.len() + starts.len();
        self.is_unstable(resource, &turn);
        self.leaves_range();
        self.resonates(resource, &turn, if advised { None } else { Some(spared) });
        for message in starts {
            self.cures.push((self.warnings.len(), Setting::new("start.mode", "steady_state")));
            let hint = "set `start.mode` = \"steady_state\" to begin on the periodic motion".to_owned();
            self.minds(Level::Mind, message, hint);
        }
        self.turn = Some(turn);
    }

    /// Warns of angles beyond half a turn.
    fn leaves_range(&mut self) {
        for (name, level) in [("largest_deformation", Level::Bad), ("largest_kinetostatic_deformation", Level::Mind)] {
            let is_far = |figure: &&Figure| {
                figure.unit == "rad" && figure.value >= PI && figure.name.rsplit('.').next() == Some(name)
            };
            let far = self.figures.iter().filter(is_far).map(|figure| (figure.name.replace('_', " "), &figure.shown));
            let messages = far
                .map(|(name, shown)| format!("{name} {shown}: more than half a turn, beyond the range of the model"));
            for message in messages.collect::<Vec<_>>() {
                self.minds(level, message, "lower the speed, or raise the natural frequency".to_owned());
            }
        }
    }

    /// Adds a warning on the motion.
    fn minds(&mut self, level: Level, message: String, hint: String) {
        self.of_motion.push((self.warnings.len(), level));
        self.warnings.push(Warning { message, hint });
    }

    /// Warns of a speed at which no motion repeats.
    fn without_motion(&mut self, resource: &Resource, advised: bool) {
        let Some(fault) = self.motionless.clone() else { return };
        let constant = matches!(resource.scene.drive(), Some(DriveMode::Constant { .. }));
        if matches!(resource.scene, Scene::RigidMachine(_)) || fault.motionless.is_none() && !constant {
            return;
        }
        if let Some(reason @ (STANDS | ON_INPUT | NO_SPEED)) = fault.motionless.as_deref() {
            self.notes.push(reason.to_owned());
            return;
        }
        let j = resource.scene.followers().min(1);
        let mut message = periodic_turn::reason(&fault);
        let is_open = message.starts_with(NOT_REPEATED);
        let ratio = self.value(&named(j, "frequency_ratio")).unwrap_or(0.0);
        let harmonic = (1.0 / ratio).round();
        if is_open && (harmonic * ratio - 1.0).abs() <= NEAR {
            let ratio = text::number(harmonic * ratio);
            message += &format!(" near a resonance: harmonic {harmonic} has {ratio} times the natural frequency");
        }
        if linear(&resource.scene).is_some_and(|growth| growth <= 1.0 + NEUTRAL) {
            message += "; the linear equation is stable at this speed (`camdrive stability`)";
        }
        self.leaves_range();
        let spared = self.warnings.len() - self.of_motion.len();
        let mut hint = self.cure(resource, j, if advised { None } else { Some(spared) });
        if message == RESONANCE {
            hint = format!("set {} above 0, or choose another speed", damping(&resource.scene, j));
        }
        let level = if is_open { Level::Mind } else { Level::Bad };
        self.minds(level, message, hint);
    }

    /// Warns of followers that leave their cams, and notes the impacts of others.
    pub(super) fn lifts_off(&mut self, resource: &Resource) {
        let turn = self.turn.take();
        let mut lost = Vec::new();
        for of in &self.lift_offs {
            let (level, mut message) = of.judged();
            if level > Level::Good {
                let flies = resource.scene.is_one_sided(of.number);
                let hits = turn.as_ref().filter(|_| flies).and_then(|turn| hits(turn, of.number, "It"));
                message += &hits.map_or(String::new(), |hits| format!(" {hits}."));
                lost.push((level, message, if of.held.lost { HOLD } else { PASS }));
            }
        }
        lost.into_iter().for_each(|(level, message, hint)| self.minds(level, message, hint.to_owned()));
        for j in 0..turn.as_ref().map_or(0, |turn| turn.impacts.len()) {
            let of =
                if resource.scene.followers() <= 1 { "the follower".to_owned() } else { format!("follower {}", j + 1) };
            let is_told = self.lift_offs.iter().any(|lift_off| lift_off.number == j && lift_off.held.lost);
            let hits = turn.as_ref().filter(|_| !is_told).and_then(|turn| hits(turn, j, &of));
            match resource.scene.is_one_sided(j) {
                true => hits.into_iter().for_each(|hits| self.minds(Level::Bad, hits, HOLD.to_owned())),
                false => self.notes.extend(hits),
            }
        }
        self.turn = turn;
    }

    /// Warns of a motion from which disturbances lead away, or that keeps them.
    fn is_unstable(&mut self, resource: &Resource, turn: &Turn) {
        let is_deformation = |range: &periodic_turn::Range| range.part().0 == "q";
        let growth = turn.growth.filter(|growth| *growth >= NEUTRAL);
        let (speed, linear) = (terminal::shown(turn.mean_speed, &RPM), linear(&resource.scene));
        let hint = "`camdrive stability` lists the unstable speeds, and the damping that stabilises them".to_owned();
        match (growth, linear) {
            (Some(growth), None) if oscillator::of(&resource.scene).is_ok() => {
                self.minds(Level::Bad, must_not_run(turn.mean_speed, growth.exp()), hint);
            }
            (Some(_), linear) => {
                let stable = linear.is_some_and(|growth| growth <= 1.0 + NEUTRAL);
                let but = if stable { "; the linear equation is stable there (`camdrive stability`)" } else { "" };
                let hint = format!("choose another speed or more damping ({})", damping(&resource.scene, 0));
                let message = format!("the periodic motion at {speed} is unstable: turns differ{but}");
                self.minds(Level::Mind, message, hint);
            }
            _ if turn.growth.is_some_and(|growth| growth > -NEUTRAL) && turn.outputs.iter().any(is_deformation) => {
                let hint = format!("set {} above 0", damping(&resource.scene, 0));
                self.minds(Level::Mind, NEVER.to_owned(), hint);
            }
            _ => {}
        }
    }

    /// The natural frequency (rad/s) of follower j, counted from 1, or of the only one.
    pub fn natural(&self, j: usize) -> Option<f64> {
        self.value(&named(j, "natural_frequency"))
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

    /// Warns of deformations that resonances, other vibration or impacts raise, and notes weak resonances; calm speeds are
    /// advised where the warnings to spare are known.
    fn resonates(&mut self, resource: &Resource, turn: &Turn, spared: Option<usize>) {
        for j in 0..=resource.scene.followers() {
            let Some(rise) = self.rise(j, turn) else { continue };
            let (of, times) = (of(&resource.scene, j), text::number(rise.largest / rise.kinetostatic));
            let [largest, without, swing] =
                [rise.largest, rise.kinetostatic, rise.swing].map(|value| shown(value, rise.unit));
            let has_impacts = turn.impacts.get(j.saturating_sub(1)).copied().flatten().is_some_and(|count| count > 0.0);
            let near = rise.near.as_ref().map(|near| (near, shown(near.amplitude, near.unit)));
            let damping = damping(&resource.scene, j);
            if rise.factor() < RAISED {
                let ratio = self.value(&named(j, "damping_ratio")).unwrap_or(0.0);
                let natural = self.value(&named(j, "natural_frequency")).unwrap_or(f64::NAN);
                let meets = |near: &Harmonic| (near.frequency / natural - 1.0).abs() <= ratio;
                let met = near.filter(|(near, _)| meets(near) && rise.of_harmonic() >= NOTED);
                if met.is_none() && !has_impacts && rise.factor() >= NOTABLE {
                    self.notes.push(format!("{of}vibration raises the deformation from {without} to {largest}"));
                }
                if let Some((near, amplitude)) = met {
                    let note = format!(
                        "{of}harmonic {} meets the natural frequency: its amplitude is {amplitude}, and the deformation reaches \
                         {largest}, {times} times its kinetostatic value",
                        near.harmonic
                    );
                    self.name((j, near.harmonic));
                    self.notes.push(note);
                }
                continue;
            }
            rise.near.iter().for_each(|near| self.name((j, near.harmonic)));
            let (message, hint) = match near {
                _ if has_impacts => (
                    format!("{of}impacts raise the deformation from {without} to {largest}"),
                    match &resource.scene {
                        scene if scene.is_one_sided(j.saturating_sub(1)) => HOLD.to_owned(),
                        Scene::BacklashDrive(_) => {
                            "`camdrive clearance` tries other speeds, dampings and clearances".to_owned()
                        }
                        _ => format!("choose another speed, more damping ({damping}) or less clearance"),
                    },
                ),
                Some((near, amplitude)) if rise.of_harmonic() >= RESONANT => {
                    let lost =
                        if self.exceeds(j, &rise) { "; the tool misses its law by more than the stroke" } else { "" };
                    (
                        format!(
                            "{of}resonance with harmonic {}: its amplitude is {amplitude}; without vibration the \
                             deformation varies by ±{swing}{lost}",
                            near.harmonic
                        ),
                        self.cure(resource, j, spared),
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

    /// Lists a harmonic that the judgement names.
    fn name(&mut self, named: (usize, usize)) {
        self.named.push(named);
        let is_named = |of: &&Resonance| of.harmonic == named.1;
        if self.resonances.iter().all(|of| !is_named(&of)) {
            self.resonances.extend(self.every.iter().filter(is_named));
            self.resonances.sort_unstable_by_key(|of| of.harmonic);
        }
    }

    /// True if the tool would miss its law by the whole stroke.
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

/// The scene at another speed (rad/s).
fn at_speed(resource: &Resource, speed: f64) -> Resource {
    let mut other = resource.clone();
    if let Some(DriveMode::Constant { w, .. }) = other.scene.drive_mut() {
        *w = speed;
    }
    other
}

/// True if a deformation is raised at this speed, or no motion is found.
fn is_rough(resource: &Resource, speed: f64) -> bool {
    let other = at_speed(resource, speed);
    let still = super::sketched(&other);
    let raised = |turn: &Turn| {
        (0..=other.scene.followers()).any(|j| still.rise(j, turn).is_some_and(|rise| rise.factor() >= RAISED))
    };
    still.turn.as_ref().is_none_or(raised)
}

/// The nearest speeds (rad/s) below and above, with a margin, at which a check warns of no more than it does here without the
/// motion.
fn calm_speeds(resource: &Resource, spared: usize) -> Vec<f64> {
    let Some(DriveMode::Constant { w, .. }) = resource.scene.drive().cloned() else { return Vec::new() };
    let is_calm =
        |speed: f64| !is_rough(resource, speed) && super::at(&at_speed(resource, speed), true).warnings.len() <= spared;
    let since = Since::now();
    let side = |sign: f64| {
        let (mut rough, mut tries) = (Some(w), 0);
        for i in (1..=STEPS.1).take_while(|_| since.drawn() < SEARCH) {
            let mut speed = w * (1.0 + sign * STEPS.0).powi(i);
            if is_rough(resource, speed) {
                rough = Some(speed);
                continue;
            }
            // The edge of what is rough; farther on only what else a check minds is in the way.
            if let Some(mut within) = rough.take() {
                for _ in 0..HALVINGS {
                    let middle = 0.5 * (within + speed);
                    *(if is_rough(resource, middle) { &mut within } else { &mut speed }) = middle;
                }
                speed *= 1.0 + sign * MARGIN;
            }
            let written = text::digits_beyond(speed * RPM.factor, 3, sign > 0.0);
            let speed = written.parse().map_or(speed, |rpm: f64| rpm / RPM.factor);
            if is_calm(speed) {
                return Some(speed);
            }
            tries += 1;
            if tries == TRIES {
                break;
            }
        }
        None
    };
    [-1.0, 1.0].into_iter().filter_map(side).collect()
}

/// The impacts of follower j, counted from 0, which is called `of`.
fn hits(turn: &Turn, j: usize, of: &str) -> Option<String> {
    let impacts = turn.impacts.get(j).copied().flatten().filter(|impacts| *impacts > 0.0)?;
    let own = turn.impulses.iter().filter(|impact| impact.follower == j + 1);
    let hardest = own.max_by(|a, b| a.impulse.total_cmp(&b.impulse)).map_or(String::new(), |hardest| {
        let [phi, impulse] = [terminal::shown(hardest.phi, &DEG), terminal::shown(hardest.impulse, &NS)];
        format!(", the hardest at {phi} with {impulse}")
    });
    Some(format!("{of} has {} a turn{hardest}", text::counted(text::number(impacts), "impact")))
}

/// Messages on starts that deform far more than the periodic motion.
fn far_starts(resource: &Resource, turn: &Turn) -> Vec<String> {
    // From no start does the drive reach an unstable motion.
    if matches!(resource.scene, Scene::RigidMachine(_)) || turn.growth.is_some_and(|growth| growth >= NEUTRAL) {
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
