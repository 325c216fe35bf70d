//! The loads of rollers, joints and shaft over a turn, and their report.

use super::quantity::{Quantity, TORQUE, Units};
use super::turn::{Extreme, MachineTurn, State};
use super::{Drive, Held, Machine};
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
/// This part of the largest value of a kind is rounding.
const ROUNDING: f64 = 1e-12;

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
    /// The largest size of its kind.
    #[serde(skip)]
    size: f64,
}

/// Conditions for force alone to keep a follower on its cam.
#[derive(Clone, Debug, Serialize)]
pub struct Keeping {
    /// [`MachineTurn::least_preload`].
    pub least_preload: Option<Extreme>,
    /// [`MachineTurn::held`].
    #[serde(flatten)]
    pub held: Held,
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
    #[serde(skip)]
    may_leave: bool,
    /// See [`Drive::is_held`].
    #[serde(skip)]
    is_held: bool,
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
        let largest = turn.largest(&of);
        let size = largest.value.abs().max(lowest.value.abs());
        Range {
            quantity: key.to_owned(),
            unit: si,
            largest,
            least: Extreme { value: -lowest.value, ..lowest },
            mean: turn.mean(of),
            shown: (name.to_owned(), unit.sized(size)),
            size,
        }
    }

    /// The end that is farther from 0.
    fn peak(&self) -> Extreme {
        Extreme::greatest([self.largest, self.least], f64::abs).unwrap_or(self.largest)
    }

    /// A value for people; 0 if it is only rounding.
    fn clean(&self, value: f64) -> f64 {
        if value.abs() <= ROUNDING * self.size { 0.0 } else { text::clean(value, self.peak().value.abs()) }
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

/// A speed up to which the contact holds.
fn up_to(lift_off: f64, digits: usize) -> String {
    WrittenValue::rounded(lift_off, &RPM, digits, false).to_string()
}

/// The significant digits that distinguish a speed from the speed of lift-off.
fn telling(speed: f64, lift_off: f64) -> usize {
    let differs = |digits: &usize| {
        let [at, from] = [
            text::rounded(speed.abs() * RPM.factor, *digits),
            text::digits_beyond(lift_off * RPM.factor, *digits, false).parse().unwrap_or(f64::NAN),
        ];
        at != from && (at < from) == (speed.abs() < lift_off)
    };
    (FINE..EXACT).find(differs).unwrap_or(EXACT)
}

/// A difference of powers; roundings have no size of their own.
fn apart_by(part: f64) -> String {
    if part <= ROUNDING { "rounding".to_owned() } else { format!("{} of the largest power", number(part)) }
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
        let mut quantities: Vec<Range> = told.map(range).collect();
        let sizes: Vec<(&str, f64)> = quantities.iter().map(|of| (of.unit, of.size)).collect();
        for of in &mut quantities {
            of.size = sizes.iter().filter(|(unit, _)| *unit == of.unit).fold(0.0, |most, (_, size)| most.max(*size));
        }
        OfDrive {
            name: drive.name.clone(),
            spoken: turn.machine.spoken(drive),
            quantities,
            sign_changes: turn.sign_changes(pressing),
            keeping: drive
                .is_force_closed()
                .then(|| Keeping { least_preload: turn.least_preload(j), held: turn.held(j) }),
            may_leave: drive.loads.may_leave,
            is_held: drive.is_held(),
        }
    }

    /// The judgement on contact at this speed (rad/s); None if its cam holds it on both sides.
    fn contact(&self, speed: f64) -> Option<(Level, String)> {
        if self.keeping.is_some() && !self.is_held {
            return Some((Level::Mind, format!("No load of the scene holds {} on its cam.", self.spoken)));
        }
        Some(self.keeping.as_ref()?.held.judged(&self.spoken, speed, self.may_leave))
    }
}

/// "the real follower 2".
fn real(the: &str) -> String {
    format!("the real {}", the.trim_start_matches("the "))
}

impl Held {
    /// The judgement on contact at this speed (rad/s), 0 if it is not known: `the` is "the follower", which may leave its cam in the
    /// model or not.
    pub fn judged(&self, the: &str, speed: f64, may_leave: bool) -> (Level, String) {
        let (the, keeps) = match may_leave {
            true => (capital(the), ""),
            false => (capital(&real(the)), "; this model keeps contact"),
        };
        let Some(Extreme { value, phi }) = self.lift_off_speed else {
            if self.lost {
                return (Level::Bad, format!("{the} lifts off its cam, as the speed fluctuates{keeps}."));
            }
            return (Level::Good, format!("{the} stays on its cam at any speed."));
        };
        if value == 0.0 {
            return (Level::Bad, format!("{the} lifts off its cam even at rest{keeps}."));
        }
        let fine = telling(speed, value);
        let (at, limit, phi) = (WrittenValue::nearest(speed, &RPM, fine), up_to(value, fine), angle(phi));
        if self.lost {
            let constant = if value > speed.abs() { "At constant speed contact" } else { "Contact" };
            let holds = format!("{constant} holds up to {limit}, where it opens first at φ = {phi}.");
            return (Level::Bad, format!("{the} lifts off its cam at {at}{keeps}. {holds}"));
        }
        if let Some(regained) = self.regained_speed {
            let until = WrittenValue::rounded(regained, &RPM, fine, true);
            let passes = format!("{the} lifts off its cam between {limit} and {until}{keeps}. At {at} it has contact.");
            return (Level::Mind, passes);
        }
        let lifts = format!("lifts off above {limit}, first at φ = {phi}");
        let sentence = match may_leave && speed != 0.0 {
            true => format!("{the} stays on its cam at {at}; it {lifts}."),
            false => format!("{the} {lifts}{keeps}."),
        };
        (Level::Good, sentence)
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
    /// Adds the preload that keeps a follower on its cam, and the other remedies if contact is `lost`.
    fn advise(&self, verdict: &mut Verdict, machine: &Machine, drive: &Drive, lost: bool) {
        // The only follower needs no name.
        let of = |text: String| match &*machine.spoken(drive) {
            "the follower" => capital(&text),
            name => format!("{}: {text}", capital(name)),
        };
        let claim = || Claim::Contact { follower: machine.number(drive) };
        let unit = if drive.follower.turns { unit::NM } else { unit::N };
        // Rounded away from the least preload.
        let given = WrittenValue::rounded(drive.preload(), &unit, FINE, !lost);
        let preload = self.least_preload.map(|at| (machine.preload(drive, at.value, &unit), angle(at.phi)));
        if !lost {
            match preload {
                Some((preload, _))
                    if self.least_preload.is_some_and(|at| text::clean(at.value, drive.preload()) > 0.0) =>
                {
                    let text = format!("keep the preload of the return spring above {} (now {given}).", preload.least);
                    verdict.advice(Advice::new(of(text)).set(preload.setting, claim()));
                }
                _ => {
                    verdict.result(
                        Level::Good,
                        of("at this speed the follower stays on its cam without a preload.".to_owned()),
                    );
                }
            };
            return;
        }
        // Where the speed fluctuates, that at constant speed may be less than there is.
        let raises = |at: Extreme| at.value > drive.preload();
        if let Some((preload, phi)) = preload.filter(|_| self.least_preload.is_some_and(raises)) {
            let text = match preload.setting.is_some() {
                true => format!(
                    "raise the preload of the return spring from {given} to {} (needed at φ = {phi}).",
                    preload.least
                ),
                false => {
                    format!("add a return spring with a preload of {} (needed at φ = {phi}).", preload.least)
                }
            };
            verdict.advice(Advice::new(of(text)).set(preload.setting, claim()));
        }
        let lowers = |at: &Extreme| at.value > 0.0 && at.value <= machine.speed.abs();
        if let Some(at) = self.held.lift_off_speed.filter(lowers) {
            let speed = Setting::at_most("drive.speed", at.value.copysign(machine.speed), &RPM, FINE);
            let text = format!("or run below {}.", up_to(at.value, FINE));
            verdict.advice(Advice::new(of(text)).set([speed], claim()));
        }
        // A motion in which the follower leaves its cam has no second flank.
        let held = (drive.plan.is_some() && !drive.is_flat() && !drive.loads.may_leave)
            .then(|| Setting::new(machine.key(drive, "geometry.contour"), "groove"));
        let text = "or use a groove or conjugate cams, which hold the follower on both sides.".to_owned();
        verdict.advice(Advice::new(of(text)).set(held, claim()));
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
        let of = |drive: &OfDrive| drive.contact(self.speed).filter(|(level, _)| *level == Level::Bad);
        let small = |sentence: String| {
            let (first, rest) = sentence.split_at(1);
            (first.to_lowercase() + rest).trim_end_matches('.').to_owned()
        };
        self.drives.iter().filter_map(of).map(|(_, sentence)| small(sentence)).collect()
    }

    fn verdict(&self, machine: &Machine) -> Verdict {
        let mut verdict = Verdict::default();
        let name = |drive: &Drive| capital(&machine.spoken(drive));
        let is_one = machine.drives.len() == 1;
        let all = || self.drives.iter().zip(&machine.drives);
        for (found, drive) in all() {
            if let (Some((level, sentence)), Some(keeping)) = (found.contact(self.speed), &found.keeping) {
                verdict.result(level, sentence);
                keeping.advise(&mut verdict, machine, drive, level != Level::Good);
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
        let (mean, size) = (self.power.shaft, self.power.largest);
        let shown = ("power".to_owned(), W.sized(size));
        let power = Range { quantity: "power".to_owned(), unit: "W", largest, least, mean, shown, size };
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
            format!("The power of the shaft (from forces) and of the process (from the tools' motion) differ by {}.", apart_by(apart)),
        ]);
        report
    }
}

/// How far only its loads keep a follower on its cam.
#[derive(Clone, Debug, Serialize)]
pub struct LiftOff {
    /// Its name: "follower1".
    pub follower: String,
    /// Its name in a sentence.
    #[serde(skip)]
    pub spoken: String,
    /// Its number in the machine, from 0.
    #[serde(skip)]
    pub number: usize,
    /// The speed of the scene (rad/s).
    #[serde(skip)]
    pub speed: f64,
    /// See [`MachineTurn::held`].
    #[serde(flatten)]
    pub held: Held,
    /// True if the FMU's motion contains the flight.
    pub may_leave: bool,
}

impl LiftOff {
    /// The judgement as in [`Held::judged`].
    pub fn judged(&self) -> (Level, String) {
        self.held.judged(&self.spoken, self.speed, self.may_leave)
    }

    /// The finding as a sentence.
    pub fn text(&self) -> String {
        self.judged().1
    }
}

impl Machine {
    /// The contacts of all followers that only their loads keep on their cams.
    ///
    /// # Errors
    /// The errors of [`Drive::at`].
    pub fn lift_offs(mut self) -> Result<Vec<LiftOff>, Fault> {
        // Without the pressure in the contact, which an undercut cam does not have.
        self.drives.iter_mut().for_each(|drive| drive.loads.material = None);
        if !self.drives.iter().any(Drive::is_held) {
            return Ok(Vec::new());
        }
        let turn = self.turn()?;
        let of = |(number, drive): (usize, &Drive)| {
            let follower = self.part(drive).unwrap_or("the follower").to_owned();
            drive.is_held().then(|| LiftOff {
                follower,
                spoken: self.spoken(drive),
                number,
                speed: self.speed,
                held: turn.held(number),
                may_leave: drive.loads.may_leave,
            })
        };
        Ok(self.drives.iter().enumerate().filter_map(of).collect())
    }

    /// Sentences on the loads that the FMU's motion leaves out, and on the speeds above which followers lift off although they cannot
    /// in that motion; None without either.
    pub fn left_out(self) -> Option<String> {
        let lever = self.drives.iter().any(|drive| drive.loads.lever_inertia > 0.0);
        let instead = if self.drives.iter().any(|drive| drive.name.contains('.')) {
            "[follower.backlash] with s = \"inf\" in a DriveTrain"
        } else {
            "a BacklashDrive with s = \"inf\""
        };
        let leaving = self.lift_offs().unwrap_or_default().into_iter().filter(|of| !of.may_leave).filter_map(|of| {
            let above = match of.held.lift_off_speed?.value {
                0.0 => "even at rest".to_owned(),
                value => format!("above {}", up_to(value, FINE)),
            };
            Some(format!("{} lifts off {above}", real(&of.spoken)))
        });
        let leaving = leaving.collect::<Vec<_>>().join(", ");
        let lever = lever.then(|| "forces.lever_J is not part of the motion of the FMU".to_owned());
        let leaving = (!leaving.is_empty())
            .then(|| format!("{leaving}; this model keeps contact. To simulate lift-off use {instead}"));
        match (lever, leaving) {
            (Some(lever), Some(leaving)) => Some(format!("{lever}. {}", capital(&leaving))),
            (lever, leaving) => lever.or(leaving),
        }
    }
}
