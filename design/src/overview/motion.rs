//! The periodic motion at the speed of the scene, and the additions of vibration, loads and impacts to the kinetostatic
//! figures.

use super::{Overview, Warning};
use crate::law_motions::shown;
use crate::periodic_turn::{self, Harmonic, NEUTRAL, Turn};
use crate::report::unit::RPM;
use crate::report::{Setting, WrittenValue};
use crate::resource::{Described, Resource, Scene};
use crate::text;
use camdrive::drives::shaft::cam_drive::DriveMode;
use camdrive::drives::variable::Causality;

/// The names of the figures of outputs.
const NAMES: [(&str, &str); 5] = [
    ("q", "largest_deformation"),
    ("force", "largest_force"),
    ("contact_force", "largest_contact_force"),
    ("tau", "largest_torque"),
    ("M_an", "largest_motor_torque"),
];

/// A harmonic this close to the natural frequency, as a part of it, may be in resonance; if coefficients vary over the turn,
/// resonances are up to a fifth off.
const NEAR: f64 = 0.25;

/// A resonance raises a harmonic near the natural frequency that deforms this many times as much as all loads would without
/// vibration: away from resonance the vibration is at most as large as these.
const RAISED: f64 = 2.0;

/// A start that deforms this many times as much as the periodic motion is far from it: a load applied at once deforms twice.
const FAR: f64 = 2.0;

/// Calmer speeds are searched in steps of this part, half the width of a resonance with a damping ratio of 2 %, this many to
/// each side: up to a factor of 1.5, beyond which it is another machine.
const STEPS: (f64, i32) = (0.02, 20);

/// The name of a figure of follower j; 0 for a drive with one.
fn named(j: usize, name: &str) -> String {
    if j == 0 { name.to_owned() } else { format!("follower[{j}].{name}") }
}

/// A speed (rad/s) as people write it.
fn rounded(w: f64) -> f64 {
    text::digits(w * RPM.factor, 4, -4).parse().map_or(w, |rpm: f64| rpm / RPM.factor)
}

impl Overview {
    /// Adds the figures of the periodic motion, and its warnings.
    pub(super) fn steady(&mut self, resource: &Resource) {
        let Some(turn) = self.turn.take() else { return self.without_motion(resource) };
        for range in &turn.outputs {
            let (part, j) = range.part();
            if let Some((_, name)) = NAMES.iter().find(|(of, _)| *of == part) {
                self.figure(named(j, name), range.peak().value.abs(), range.unit);
            }
        }
        if let Some(turns) = turn.settles().filter(|_| turn.outputs.iter().any(|range| range.part().0 == "q")) {
            self.figure("turns_until_settled", turns, "1");
        }
        for dwell in turn.dwells(&resource.scene) {
            let name = named(periodic_turn::part(&dwell.output).1, "largest_vibration_in_a_dwell");
            match self.figures.iter_mut().find(|figure| figure.name == name) {
                Some(figure) if figure.value >= dwell.largest => {}
                Some(figure) => (figure.value, figure.shown) = (dwell.largest, shown(dwell.largest, dwell.unit)),
                None => self.figure(name, dwell.largest, dwell.unit),
            }
        }
        self.lifts_off(resource, &turn);
        self.resonates(resource, &turn);
        self.starts_far(resource, &turn);
        self.turn = Some(turn);
    }

    /// Warns of a speed at which no motion repeats.
    fn without_motion(&mut self, resource: &Resource) {
        if !matches!(resource.scene.drive(), Some(DriveMode::Constant { w, .. }) if *w != 0.0) {
            return;
        }
        // Other inputs need not repeat with the turns.
        let has_inputs = |drive: &Described| drive.descriptions().iter().any(|d| d.causality == Causality::Input);
        if resource.build().is_ok_and(|drive| has_inputs(&drive)) {
            return;
        }
        if let Some(fault) = &self.motionless {
            let hint = "choose more damping or another speed".to_owned();
            self.warnings.push(Warning { message: periodic_turn::reason(fault), hint });
        }
    }

    /// Warns of followers that leave their cams in the periodic motion.
    fn lifts_off(&mut self, resource: &Resource, turn: &Turn) {
        for (j, impacts) in turn.impacts.iter().enumerate() {
            let Some(impacts) = impacts.filter(|impacts| *impacts > 0.0 && resource.scene.is_one_sided(j)) else {
                continue;
            };
            let of = if turn.impacts.len() == 1 { "the follower".to_owned() } else { format!("follower {}", j + 1) };
            let message =
                format!("{of} lifts off its cam and has {} a turn", text::counted(text::number(impacts), "impact"));
            let hint = "raise the preload or lower the speed; `camdrive forces` computes both".to_owned();
            self.warnings.push(Warning { message, hint });
        }
    }

    /// A value by its name.
    pub(super) fn value(&self, name: &str) -> Option<f64> {
        self.figures.iter().find(|figure| figure.name == name).map(|figure| figure.value)
    }

    /// The harmonic of the deformation of follower j that a resonance raises, with half the range of the deformation without vibration.
    fn raised(&self, j: usize, turn: &Turn) -> Option<(Harmonic, f64)> {
        let without = *self.swings.get(j.saturating_sub(1))?;
        let natural = self.value(&named(j, "natural_frequency"))?;
        let is_near =
            |of: &Harmonic| (of.frequency / natural - 1.0).abs() <= NEAR && periodic_turn::part(&of.output).1 == j;
        let near = turn.harmonics().into_iter().filter(is_near);
        let strongest = near.max_by(|a, b| a.amplitude.total_cmp(&b.amplitude))?;
        (strongest.amplitude >= RAISED * without).then_some((strongest, without))
    }

    /// Warns of deformations that a resonance raises.
    fn resonates(&mut self, resource: &Resource, turn: &Turn) {
        for j in 0..=resource.scene.followers() {
            let Some((harmonic, without)) = self.raised(j, turn) else { continue };
            let of = if j == 0 { String::new() } else { format!("follower {j}: ") };
            let [amplitude, without] = [harmonic.amplitude, without].map(|value| shown(value, harmonic.unit));
            let message = format!(
                "{of}resonance with harmonic {}: its amplitude is {amplitude}; without vibration all loads deform by ±{without}",
                harmonic.harmonic
            );
            let calm = self.calm_speeds(resource, j);
            let speeds: Vec<String> = calm.iter().map(|speed| format!("{} rpm", text::rpm(*speed))).collect();
            let hint = match &speeds[..] {
                [] => "choose another natural frequency, more damping, or a law without this harmonic".to_owned(),
                speeds => {
                    format!("run at {}, or choose another natural frequency or more damping", speeds.join(" or "))
                }
            };
            if let Some(speed) = calm.first() {
                self.cures
                    .push((self.warnings.len(), Setting::new("drive.speed", WrittenValue::nearest(*speed, &RPM, 4))));
            }
            self.warnings.push(Warning { message, hint });
        }
    }

    /// The nearest speeds (rad/s) below and above that are stable and do not raise the deformation of follower j like that.
    fn calm_speeds(&self, resource: &Resource, j: usize) -> Vec<f64> {
        let Some(DriveMode::Constant { w, .. }) = resource.scene.drive().cloned() else { return Vec::new() };
        let is_calm = |speed: f64| {
            let mut other = resource.clone();
            if let Some(mode) = other.scene.drive_mut() {
                *mode = DriveMode::Constant { w: speed, phi_start: 0.0 };
            }
            let figures = super::kinetostatic(&other);
            let is_stable = |turn: &Turn| turn.growth.is_none_or(|growth| growth < NEUTRAL);
            figures.turn.as_ref().is_some_and(|turn| is_stable(turn) && figures.raised(j, turn).is_none())
        };
        let side = |sign: f64| (1..=STEPS.1).map(|i| rounded(w * (1.0 + sign * STEPS.0).powi(i))).find(|w| is_calm(*w));
        [-1.0, 1.0].into_iter().filter_map(side).collect()
    }

    /// Warns of a start that deforms far more than the periodic motion.
    fn starts_far(&mut self, resource: &Resource, turn: &Turn) {
        if matches!(resource.scene, Scene::RigidMachine(_)) {
            return;
        }
        let Ok(peaks) = periodic_turn::start_peaks(&resource.scene, turn) else { return };
        for (range, peak) in turn.outputs.iter().filter(|range| range.part().0 == "q").zip(peaks) {
            let own = range.peak().value.abs();
            if peak >= FAR * own && own > 0.0 {
                let (j, [start, steady]) = (range.part().1, [peak, own].map(|value| shown(value, range.unit)));
                let of = if j == 0 { String::new() } else { format!("follower {j}: ") };
                let message = format!("{of}the start deforms {start}, the periodic motion {steady}");
                self.cures.push((self.warnings.len(), Setting::new("start.mode", "steady_state")));
                let hint = "set `start.mode` = \"steady_state\" to begin on the periodic motion".to_owned();
                self.warnings.push(Warning { message, hint });
            }
        }
    }
}
