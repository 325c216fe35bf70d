//! The loads of rollers, joints and shaft over a turn, and their report.

use super::quantity::{Quantity, TORQUE, Units};
use super::turn::{Extreme, MachineTurn, State};
use super::{Drive, Forces, Machine};
use crate::cam_geometry::{Shape, Tolerances};
use crate::report::unit::{self, DEG, ONE, RPM, Unit, W};
use crate::report::{Advice, Claim, Level, Report, Setting, Table, Value, Verdict, WrittenValue, terminal::shown};
use crate::text::{self, capital, number};
use camdrive::drives::Fault;
use serde::Serialize;
use std::f64::consts::TAU;

/// Significant digits of limiting speeds and preloads.
const FINE: usize = 3;
/// Significant digits above the rounding of the computation.
const EXACT: usize = 12;

/// A quantity over the turn.
#[derive(Clone, Debug, Serialize)]
pub struct Range {
    /// Its name in files.
    pub quantity: String,
    /// Its coherent SI unit.
    pub unit: &'static str,
    /// The largest value.
    pub largest: Extreme,
    /// The least value.
    pub least: Extreme,
    /// The mean over the turn.
    pub mean: f64,
    #[serde(skip)]
    shown: (String, Unit),
}

/// Conditions for force alone to keep a follower on its cam.
#[derive(Clone, Debug, Serialize)]
pub struct Keeping {
    /// The least F₀ (N or N·m) at all speeds from rest to this one, and the angle that demands it; None if no preload helps.
    pub least_preload: Option<Extreme>,
    /// [`MachineTurn::lift_off`].
    pub lift_off_speed: Option<Extreme>,
}

/// A cam and what it moves.
#[derive(Clone, Debug, Serialize)]
pub struct OfDrive {
    /// Its name.
    pub name: String,
    #[serde(skip)]
    spoken: String,
    /// The loads on its parts.
    pub quantities: Vec<Range>,
    /// φ (rad) at which the roller force changes sign; without a geometry the torque on the lever, or the force on the
    /// follower.
    pub sign_changes: Vec<f64>,
    /// The conditions if force alone keeps the contact.
    pub keeping: Option<Keeping>,
}

/// The powers (W) on the mean of a turn. Inertia, springs and gravity take as much as they give, so both are equal but for
/// roundings: the shaft's comes from the forces in the joints, the process's from the motion of the tools.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Power {
    /// The power of the shaft, mean(M) ω.
    pub shaft: f64,
    /// The power of the process, mean(−P ẏ).
    pub process: f64,
    #[serde(skip)]
    largest: f64,
}

/// The forces of a machine over a turn.
#[derive(Clone, Debug, Serialize)]
pub struct ForceAnalysis {
    /// The scene.
    pub scene: String,
    /// ω (rad/s).
    pub speed: f64,
    /// Each cam and its follower.
    pub drives: Vec<OfDrive>,
    /// The total torque on the shaft.
    pub shaft: Range,
    /// The balance of power.
    pub power: Power,
}

impl Range {
    fn new(turn: &MachineTurn<'_>, [key, name]: [&str; 2], (si, unit): Units, of: impl Fn(&State) -> f64) -> Self {
        let lowest = turn.largest(|state| -of(state));
        Range {
            quantity: key.to_owned(),
            unit: si,
            largest: turn.largest(&of),
            least: Extreme { value: -lowest.value, ..lowest },
            mean: turn.mean(of),
            shown: (name.to_owned(), unit),
        }
    }

    /// The end that is farther from 0.
    fn peak(&self) -> Extreme {
        Extreme::greatest([self.largest, self.least], f64::abs).unwrap_or(self.largest)
    }

    /// A value for people; 0 if it is only rounding.
    fn clean(&self, value: f64) -> f64 {
        text::clean(value, self.peak().value.abs())
    }

    /// "torque on the shaft of follower 1 -9.57 N·m at φ = 156°".
    fn text(&self, of: &str) -> String {
        let (peak, (name, unit)) = (self.peak(), &self.shown);
        format!("{name}{of} {} at φ = {}", shown(self.clean(peak.value), unit), angle(peak.phi))
    }
}

/// Quantities of several units.
fn ranges<'a>(title: &str, list: impl IntoIterator<Item = &'a Range>) -> Table {
    let cell = |range: &Range, at: Extreme| {
        let (value, swing) = (range.clean(at.value) * range.shown.1.factor, range.largest.value - range.least.value);
        if value == 0.0 || range.clean(swing) == 0.0 { Value::Number(value) } else { Value::At(value, at.phi) }
    };
    Table::of(title, list)
        .column("quantity", "quantity", ONE, |range| format!("{} [{}]", range.shown.0, range.shown.1.name))
        .column("largest", "largest", ONE, |range| cell(range, range.largest))
        .column("least", "least", ONE, |range| cell(range, range.least))
        .column("mean", "mean", ONE, |range| range.clean(range.mean) * range.shown.1.factor)
        .into()
}

impl Keeping {
    /// From F₀ ≥ −(Q − F₀ Q₁)/Q₁ with Q₁ = dy/dU all over the turn and on the way from rest to the speed, and from
    /// [`MachineTurn::lift_off`].
    fn of(turn: &MachineTurn<'_>, j: usize, drive: &Drive) -> Self {
        let preload = drive.preload();
        let sense = turn.sense(j);
        let helps = turn.largest(|state| -sense(state) * state.drives[j].travel).value < 0.0;
        let w = turn.machine.speed;
        let needed = |state: &State| {
            let Forces { parts: [rest, damping, inertia], travel, .. } = &state.drives[j];
            // At the part s of the speed F₀ must exceed −(Q_rest + s ω Q_damping + s² ω² Q_inertia)/Q₁.
            let at = |s: f64| preload - (rest + s * w * (damping + s * w * inertia)) / travel;
            let summit = -0.5 * damping / (w * inertia);
            [0.0, summit.clamp(0.0, 1.0), 1.0].into_iter().map(at).fold(f64::NEG_INFINITY, f64::max)
        };
        Keeping { least_preload: helps.then(|| turn.largest(needed)), lift_off_speed: turn.lift_off(j) }
    }
}

/// A speed of lift-off, up to which the contact holds.
fn up_to(lift_off: f64, digits: usize) -> String {
    WrittenValue::rounded(lift_off, &RPM, digits, false).to_string()
}

/// "above 1620 rpm", or "even at rest".
fn above(lift_off: f64, digits: usize) -> String {
    if lift_off == 0.0 { "even at rest".to_owned() } else { format!("above {}", up_to(lift_off, digits)) }
}

/// The significant digits that distinguish a speed from the speed of lift-off.
fn telling(speed: f64, lift_off: f64) -> usize {
    let differs = |digits: &usize| {
        let [at, from] = [
            text::rounded(speed.abs() * RPM.factor, *digits),
            text::digits_beyond(lift_off * RPM.factor, *digits, false).parse().unwrap_or(f64::NAN),
        ];
        (at < from) == (speed.abs() < lift_off)
    };
    (FINE..EXACT).find(differs).unwrap_or(EXACT)
}

/// An angle (rad) in degrees of the turn.
fn angle(phi: f64) -> String {
    shown(phi.rem_euclid(TAU), &DEG)
}

/// A list of angles.
fn angles(list: &[f64]) -> String {
    list.iter().copied().map(angle).collect::<Vec<_>>().join(", ")
}

impl OfDrive {
    fn new(turn: &MachineTurn<'_>, j: usize, drive: &Drive) -> Self {
        let told = drive.quantities().into_iter().filter(|quantity| !quantity.part);
        let range = |q: Quantity<'_>| Range::new(turn, [&q.key, &q.name], q.unit, |state| (q.of)(&state.drives[j]));
        let pressing = |state: &State| {
            let forces = &state.drives[j];
            forces.contacts.first().map_or(forces.load, |contact| contact.force)
        };
        OfDrive {
            name: drive.name.clone(),
            spoken: turn.machine.spoken(drive),
            quantities: told.map(range).collect(),
            sign_changes: turn.sign_changes(pressing),
            keeping: drive.is_force_closed().then(|| Keeping::of(turn, j, drive)),
        }
    }

    /// The judgement on contact at this speed (rad/s), with the speed up to which force keeps the follower on its cam; None if
    /// its cam holds it on both sides.
    fn contact(&self, part: &str, speed: f64) -> Option<(Level, String)> {
        let lift_off = self.keeping.as_ref()?.lift_off_speed;
        let fine = lift_off.map_or(FINE, |lift_off| telling(speed, lift_off.value));
        let at = WrittenValue::nearest(speed, &RPM, fine);
        Some(match lift_off {
            None => (Level::Good, format!("{part} stays on its cam at any speed.")),
            Some(Extreme { value, phi }) if speed.abs() < value => {
                let lifts = format!("would lift off {}, first at φ = {}", above(value, fine), angle(phi));
                (Level::Good, format!("{part} stays on its cam at {at}; it {lifts}."))
            }
            Some(Extreme { value, .. }) => {
                let holds = match value == 0.0 {
                    true => "it has no contact even at rest".to_owned(),
                    false => format!("contact holds up to {}", up_to(value, fine)),
                };
                let level = if speed.abs() > value { Level::Bad } else { Level::Mind };
                (level, format!("{part} lifts off its cam at {at}; {holds}."))
            }
        })
    }
}

/// The name of the force or torque that keeps the follower on its cam.
fn pressing(drive: &Drive) -> &'static str {
    match drive.plan {
        Some(_) if drive.is_flat() => "force on the face",
        Some(_) => "roller force",
        None if drive.follower.cam_turns() => drive.turned(),
        None => "force on the follower",
    }
}

impl Keeping {
    /// Adds the preload that keeps a follower on its cam, and the other remedies if contact is `lost`: the force that changes
    /// sign, and its angles.
    fn advise(&self, verdict: &mut Verdict, machine: &Machine, drive: &Drive, lost: Option<(&str, &String)>) {
        let part = capital(&machine.spoken(drive));
        let claim = || Claim::Contact { follower: machine.number(drive) };
        let unit = if drive.follower.turns { unit::NM } else { unit::N };
        // Rounded away from the least preload.
        let given = WrittenValue::rounded(drive.preload(), &unit, FINE, lost.is_none());
        let preload = self.least_preload.map(|at| (machine.preload(drive, at.value, &unit), angle(at.phi)));
        let Some((what, changes)) = lost else {
            match preload {
                Some((preload, _)) if self.least_preload.is_some_and(|at| at.value > 0.0) => {
                    let text =
                        format!("{part}: keep the preload of the return spring above {} (now {given}).", preload.least);
                    verdict.advice(Advice::new(text).set(preload.setting, claim()));
                }
                _ => {
                    verdict.result(Level::Good, format!("{part}: the contact needs no preload at this speed."));
                }
            };
            return;
        };
        let how = match changes.is_empty() {
            true => "never presses".to_owned(),
            false => format!("changes sign at φ = {changes}"),
        };
        let of = if machine.drives.len() == 1 { "The".to_owned() } else { format!("{part}: the") };
        verdict.result(Level::Mind, format!("{of} {what} {how}."));
        if let Some((preload, phi)) = preload {
            let text = match preload.setting.is_some() {
                true => format!(
                    "{part}: raise the preload of the return spring from {given} to {} (needed at φ = {phi}).",
                    preload.least
                ),
                false => {
                    format!("{part}: add a return spring with a preload of {} (needed at φ = {phi}).", preload.least)
                }
            };
            verdict.advice(Advice::new(text).set(preload.setting, claim()));
        }
        if let Some(at) = self.lift_off_speed.filter(|at| at.value > 0.0) {
            let speed = Setting::at_most("drive.speed", at.value.copysign(machine.speed), &RPM, FINE);
            let text = format!("{part}: or run below {}.", up_to(at.value, FINE));
            verdict.advice(Advice::new(text).set([speed], claim()));
        }
        // A motion in which the follower leaves its cam has no second flank.
        let held = (drive.plan.is_some() && !drive.is_flat() && !drive.loads.may_leave)
            .then(|| Setting::new(machine.key(drive, "geometry.contour"), "groove"));
        let text = format!("{part}: or use a groove or conjugate cams, which hold it on both sides.");
        verdict.advice(Advice::new(text).set(held, claim()));
    }
}

/// A preload of the return springs of a drive, and its setting if it has a spring.
struct Preload {
    least: String,
    setting: Option<Setting>,
}

impl Machine {
    /// A follower in a sentence: "follower 2", "the follower" where there is one.
    fn spoken(&self, drive: &Drive) -> String {
        let number = self.number(drive).filter(|_| self.drives.len() > 1);
        number.map_or("the follower".to_owned(), |number| format!("follower {number}"))
    }

    /// The number of a follower in its scene; None for a drive of its own.
    fn number(&self, drive: &Drive) -> Option<usize> {
        self.part(drive)?.strip_prefix("follower")?.parse().ok()
    }

    /// The key of a follower as the scene has it.
    fn key(&self, drive: &Drive, key: &str) -> String {
        self.number(drive).map_or(key.to_owned(), |number| format!("follower[{number}].{key}"))
    }

    /// The least preload (N or N·m) of all springs of a drive together; one of them takes the share that the others leave.
    fn preload(&self, drive: &Drive, least: f64, unit: &Unit) -> Preload {
        let keys = ["load.spring.preload", "load.roller.spring.preload"];
        let springs = drive.loads.on().into_iter().zip(keys).find_map(|(load, key)| Some((load.spring?.preload, key)));
        let setting = springs
            .map(|(own, key)| Setting::at_least(self.key(drive, key), least - (drive.preload() - own), unit, FINE));
        Preload { least: WrittenValue::rounded(least, unit, FINE, true).to_string(), setting }
    }
}

impl ForceAnalysis {
    /// The extremes of this turn.
    pub fn new(turn: &MachineTurn<'_>) -> Self {
        let machine = turn.machine;
        let shaft = Range::new(turn, ["torque", "total torque on the shaft"], TORQUE, |state| state.torque);
        let taken = turn.mean(|state| state.drives.iter().map(|forces| forces.process).sum());
        let [of_shaft, process, largest] = [shaft.mean, taken, shaft.peak().value].map(|torque| torque * machine.speed);
        ForceAnalysis {
            scene: machine.name.clone(),
            speed: machine.speed,
            drives: machine.drives.iter().enumerate().map(|(j, drive)| OfDrive::new(turn, j, drive)).collect(),
            power: Power { shaft: of_shaft, process, largest: largest.abs() },
            shaft,
        }
    }

    /// A sentence for each follower that leaves its cam at this speed.
    pub fn lost(&self) -> Vec<String> {
        let of = |drive: &OfDrive| drive.contact(&drive.spoken, self.speed).filter(|(level, _)| *level == Level::Bad);
        self.drives.iter().filter_map(of).map(|(_, sentence)| sentence.trim_end_matches('.').to_owned()).collect()
    }

    fn verdict(&self, machine: &Machine) -> Verdict {
        let mut verdict = Verdict::default();
        let name = |drive: &Drive| capital(&machine.spoken(drive));
        let is_one = machine.drives.len() == 1;
        let all = || self.drives.iter().zip(&machine.drives);
        for (found, drive) in all() {
            if let (Some((level, sentence)), Some(keeping)) = (found.contact(&name(drive), self.speed), &found.keeping)
            {
                let changes = angles(&found.sign_changes);
                verdict.result(level, sentence);
                let lost = (level != Level::Good).then_some((pressing(drive), &changes));
                keeping.advise(&mut verdict, machine, drive, lost);
            }
        }
        let is_crossed = |(found, _): &(&OfDrive, _)| found.keeping.is_none() && !found.sign_changes.is_empty();
        let crossed = all().filter(is_crossed).map(|(found, drive)| {
            let the = if is_one { "the".to_owned() } else { format!("{}: the", machine.spoken(drive)) };
            format!("{the} {} changes sign at φ = {}", pressing(drive), angles(&found.sign_changes))
        });
        let crossed: Vec<String> = crossed.collect();
        if !crossed.is_empty() {
            let crossed = text::capital(&crossed.join("; "));
            verdict.result(Level::Mind, format!("{crossed}. Any play is crossed there."));
        }
        // A tenth of a millimetre shows whether there is a cam at all.
        let coarse = Tolerances { chord: 1e-4, table: 1e-4 };
        for (drive, plan) in machine.drives.iter().filter_map(|drive| Some((drive, drive.plan?))) {
            let faults = match Shape::new(&name(drive), &drive.follower.cam, plan, coarse) {
                Ok(shape) => shape.complaints(Level::Bad),
                Err(fault) => vec![format!("{}: {fault}", name(drive))],
            };
            for fault in faults {
                verdict.result(Level::Mind, fault);
            }
        }
        let largest = |key: &str| {
            let of_kind = all().flat_map(|(found, drive)| found.quantities.iter().map(move |range| (range, drive)));
            let of_kind = of_kind.filter(|(range, _)| range.quantity.starts_with(key));
            let most = of_kind.max_by(|(a, _), (b, _)| a.peak().value.abs().total_cmp(&b.peak().value.abs()))?;
            Some(most.0.text(&if is_one { String::new() } else { format!(" of {}", machine.spoken(most.1)) }))
        };
        let keys = ["roller_force", "contact_force", "hertzian_pressure"];
        let loads: Vec<String> = keys.into_iter().filter_map(largest).chain([self.shaft.text("")]).collect();
        let Power { shaft, largest, .. } = self.power;
        let [mean, most] = [text::clean(shaft, largest), largest].map(|power| shown(power, &W));
        let loads = loads.join(", ");
        verdict.result(Level::Good, format!("Largest magnitudes: {loads}. Mean power {mean}, peak power {most}."));
        let names = |of: &dyn Fn(&OfDrive, &Drive) -> bool| {
            let those = all().filter(|(found, drive)| drive.plan.is_some() && of(found, drive));
            let names: Vec<String> = those.map(|(_, drive)| machine.spoken(drive)).collect();
            let of = if is_one { String::new() } else { format!(" ({})", names.join(", ")) };
            (!names.is_empty()).then_some(of)
        };
        if let Some(names) = names(&|found, _| found.keeping.is_none() && !found.sign_changes.is_empty()) {
            verdict.advice(format!("Keep the clearance between roller and cam small{names}."));
        }
        if let Some(names) = names(&|_, drive| drive.loads.material.is_none()) {
            verdict.advice(format!("Set `roller_width` in [forces] to get the Hertzian pressure{names}."));
        }
        verdict.certainty(
            "Kinetostatic: rigid bodies at constant speed, without friction, clearance, vibration and impacts.",
        );
        verdict
    }

    /// The report.
    pub fn report(&self, turn: &MachineTurn<'_>) -> Report {
        let machine = turn.machine;
        let speed = shown(self.speed, &RPM);
        let mut report = Report::new(&self.scene, format!("kinetostatic forces at constant {speed}"));
        report.verdict = self.verdict(machine);
        report.diagram("torque", super::figures::torque(turn, machine));
        for ((j, drive), found) in machine.drives.iter().enumerate().zip(&self.drives) {
            let part = machine.part(drive);
            let title = if machine.drives.len() == 1 { "Loads".to_owned() } else { capital(&machine.spoken(drive)) };
            report.table(ranges(&title, &found.quantities));
            let course = Table::file(part.unwrap_or_default(), turn.states());
            let course = course.column("phi", "φ", DEG, |state| state.phi);
            let course = drive.quantities().iter().fold(course, |table, q| {
                table.column(&q.key, &q.name, q.unit.1.clone(), |state| (q.of)(&state.drives[j]))
            });
            report.table(course);
            for (key, diagram) in super::figures::of_drive(turn, j, drive) {
                report.diagram(&part.map_or(key.clone(), |part| format!("{part}.{key}")), diagram);
            }
        }
        let at_speed = |at: Extreme| Extreme { value: at.value * self.speed, ..at };
        let [largest, least] = [self.shaft.largest, self.shaft.least].map(at_speed);
        let [largest, least] = if self.speed < 0.0 { [least, largest] } else { [largest, least] };
        let (mean, shown) = (self.power.shaft, ("power".to_owned(), W));
        let power = Range { quantity: "power".to_owned(), unit: "W", largest, least, mean, shown };
        report.table(ranges("Shaft", [&self.shaft, &power]));
        report.table(
            Table::file("torque", turn.states())
                .column("phi", "φ", DEG, |state| state.phi)
                .column("torque", "torque", unit::NM, |state| state.torque)
                .column("power", "power", W, |state| state.torque * self.speed),
        );
        let apart = (self.power.shaft - self.power.process).abs() / self.power.largest;
        report.explain("How it is computed", [
            "The tool's load m ÿ − F passes through the mechanisms to the cam. Virtual work gives the roller force N = Q/(n · dp/dU) \
             and the shaft torque M = Q U′ (Dresig, Holzweißig, Maschinendynamik, section 2.4)."
                .to_owned(),
            "Hertzian pressure of a line contact: p = √(N E*/(π L R)) (Johnson, Contact Mechanics, section 4.2).".to_owned(),
            format!("The power of the shaft (from forces) and of the process (from the tools' motion) differ by {} of the largest power.", number(apart)),
        ]);
        report
    }
}

/// The speed from which on force no longer keeps a follower on its cam.
#[derive(Clone, Debug, Serialize)]
pub struct LiftOff {
    /// Its name: "follower1".
    pub follower: String,
    /// Its name in a sentence.
    #[serde(skip)]
    pub spoken: String,
    /// The speed of the scene (rad/s).
    #[serde(skip)]
    speed: f64,
    /// See [`MachineTurn::lift_off`].
    pub lift_off_speed: Option<Extreme>,
    /// True if the FMU's motion contains the flight.
    pub may_leave: bool,
}

impl LiftOff {
    /// The finding as a sentence.
    pub fn text(&self) -> String {
        let (follower, kept) = (capital(&self.spoken), if self.may_leave { "" } else { "; this model keeps contact" });
        let Some(Extreme { phi, value }) = self.lift_off_speed else {
            return format!("{follower} stays on its cam at any speed.");
        };
        let lifts = if self.may_leave && value <= self.speed { "lifts off" } else { "would lift off" };
        let (above, phi) = (above(value, FINE), angle(phi));
        format!("{follower} {lifts} its cam {above}, first at φ = {phi} (kinetostatic){kept}.")
    }
}

impl Machine {
    /// The speeds of lift-off of all followers that only their loads keep on their cams.
    ///
    /// # Errors
    /// The errors of [`Drive::at`].
    pub fn lift_offs(mut self) -> Result<Vec<LiftOff>, Fault> {
        // Without the pressure in the contact, which an undercut cam does not have.
        self.drives.iter_mut().for_each(|drive| drive.loads.material = None);
        let turn = self.turn()?;
        let of = |(j, drive): (usize, &Drive)| {
            // A scene without any load says nothing about what holds the follower.
            let acts = drive.loads.lever_inertia > 0.0 || drive.loads.on().iter().any(|load| !load.is_none());
            let name = self.part(drive).unwrap_or("the follower");
            (acts && drive.is_force_closed()).then(|| LiftOff {
                follower: name.to_owned(),
                spoken: self.spoken(drive),
                speed: self.speed.abs(),
                lift_off_speed: turn.lift_off(j),
                may_leave: drive.loads.may_leave,
            })
        };
        Ok(self.drives.iter().enumerate().filter_map(of).collect())
    }

    /// A sentence on the loads that the FMU's motion leaves out, and on the speeds from which followers would leave their cams
    /// although they cannot in that motion; None without either.
    pub fn left_out(self) -> Option<String> {
        let lever = self.drives.iter().any(|drive| drive.loads.lever_inertia > 0.0);
        let instead = if self.drives.iter().any(|drive| drive.name.contains('.')) {
            "[follower.backlash] with s = \"inf\" in a DriveTrain"
        } else {
            "BacklashDrive with s = \"inf\""
        };
        let leaving =
            self.lift_offs().unwrap_or_default().into_iter().filter(|of| !of.may_leave).filter_map(|of| {
                Some(format!("{} would lift off {}", of.spoken, above(of.lift_off_speed?.value, FINE)))
            });
        let leaving = leaving.collect::<Vec<_>>().join(", ");
        let leaving = if leaving.is_empty() {
            leaving
        } else {
            format!(
                "contact holds at any speed; in the machine {leaving} (kinetostatic; use {instead} to simulate lift-off)"
            )
        };
        match (lever, leaving.is_empty()) {
            (false, true) => None,
            (false, false) => Some(format!("in the motion of the FMU {leaving}")),
            (true, alone) => {
                let rest = if alone { leaving } else { format!(", in which {leaving}") };
                Some(format!("forces.lever_J is not part of the motion of the FMU{rest}"))
            }
        }
    }
}
