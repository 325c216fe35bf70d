//! Forces on rollers, joints and shaft over a turn, as numbers, text and CSV.

use super::turn::{Extreme, State, Turn};
use super::{Contact, Drive, Forces, Machine};
use crate::cam_geometry::{Cut, Follower as Carrier, Shape, Side, Tolerances, Verdict};
use crate::text::{self, NONE, Page, Table, number, rpm};
use camdrive::drives::Fault;
use camdrive::drives::rigid_machine::linkage::in_turn;
use serde::Serialize;
use std::f64::consts::TAU;

/// A unit: coherent SI, as people read it, how many of these make it.
pub type Unit = (&'static str, &'static str, f64);

const NEWTON: Unit = ("N", "N", 1.0);
const TORQUE: Unit = ("N·m", "N·m", 1.0);
const PRESSURE: Unit = ("Pa", "MPa", 1e-6);
/// A least value or a mean below this part of the largest one is shown as zero.
const ROUNDING: f64 = 1e-9;
const ANGLE: Unit = ("rad", "°", 360.0 / TAU);

/// Something that varies over the turn.
pub struct Quantity<'a> {
    /// Its name in files.
    pub key: String,
    /// Its name for people.
    pub name: String,
    /// The unit.
    pub unit: Unit,
    /// Whether it is a component, whose largest value says little.
    pub part: bool,
    /// Its value.
    pub of: Box<dyn Fn(&Forces) -> f64 + 'a>,
}

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

/// Conditions that keep a follower on its cam by force alone.
#[derive(Clone, Debug, Serialize)]
pub struct Keeping {
    /// The least F₀ (N or N·m) at this speed and the angle that demands it; None where no preload helps.
    pub least_preload: Option<Extreme>,
    /// [`Turn::lift_off`].
    pub lift_off_speed: Option<Extreme>,
}

/// A cam and what it moves.
#[derive(Clone, Debug, Serialize)]
pub struct OfDrive {
    /// Its name.
    pub name: String,
    /// The loads on its parts.
    pub quantities: Vec<Range>,
    /// φ (rad) where the force of the roller changes its sign; without a geometry the torque on the lever, or the force on the
    /// follower.
    pub sign_changes: Vec<f64>,
    /// Where force alone keeps the contact.
    pub keeping: Option<Keeping>,
    #[serde(skip)]
    notes: [Vec<String>; 2],
}

/// The powers (W) on the mean of a turn. Inertia, springs and gravity take as much as they give, so that both are equal but for
/// roundings: the shaft's comes from the forces in the joints, that of the process from the motion of the tools.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Power {
    /// That of the shaft, mean(M) ω.
    pub shaft: f64,
    /// The power of the process, mean(−P ẏ).
    pub process: f64,
    #[serde(skip)]
    largest: f64,
}

/// The forces of a machine over a turn.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// The scene.
    pub scene: String,
    /// ω (rad/s).
    pub speed: f64,
    /// Each cam with what it moves.
    pub drives: Vec<OfDrive>,
    /// The torque on the shaft of all together.
    pub shaft: Range,
    /// The balance of power.
    pub power: Power,
}

impl Drive {
    /// All that varies, in the order of the flow of force from the cam to the tool.
    pub fn quantities(&self) -> Vec<Quantity<'_>> {
        let mut list: Vec<Quantity<'_>> = Vec::new();
        let mut add = |key: &str, name: &str, unit: Unit, part: bool, of: Box<dyn Fn(&Forces) -> f64>| {
            let (key, name) = (key.replace(['–', ' '], "_"), name.to_owned());
            list.push(Quantity { key, name, unit, part, of });
        };
        let flat = self.is_flat();
        for (i, bearing) in self.contacts.iter().enumerate() {
            let (key, name) = match (self.plan.map(|plan| plan.cut), bearing.side) {
                (Some(Cut::Conjugate(_)), _) => (format!("_{}", bearing.name), format!(", cam {}", bearing.name)),
                (Some(Cut::Groove), Side::Inner) => ("_inner".to_owned(), ", inner contour".to_owned()),
                (Some(Cut::Groove), _) => ("_outer".to_owned(), ", outer contour".to_owned()),
                _ => (String::new(), String::new()),
            };
            let mut of = |what: &str, words: &str, unit: Unit, of: fn(&Contact) -> f64| {
                let value = Box::new(move |forces: &Forces| of(&forces.contacts[i]));
                add(&format!("{what}{key}"), &format!("{words}{name}"), unit, false, value);
            };
            if flat {
                of("contact_force", "force on the face", NEWTON, |contact| contact.force);
            } else if self.is_force_closed() {
                of("roller_force", "roller force", NEWTON, |contact| contact.force);
            } else {
                of("roller_force", "roller force", NEWTON, |contact| contact.force.max(0.0));
            }
            // Both flanks of a groove have the same.
            if !flat && (i == 0 || !bearing.name.is_empty()) {
                of("pressure_angle", "pressure angle", ANGLE, |contact| contact.pressure_angle);
            }
            if self.loads.material.is_some() {
                of("hertzian_pressure", "Hertzian pressure", PRESSURE, |contact| contact.hertzian);
            }
        }
        if flat {
            let moment = |forces: &Forces| forces.contacts[0].side;
            add("tilting_moment", "tilting moment on the follower", TORQUE, false, Box::new(moment));
        }
        if self.contacts.iter().any(|bearing| matches!(bearing.cam.follower, Carrier::Translating { .. })) {
            let bearing = |forces: &Forces| {
                let bears = forces.contacts.iter().max_by(|a, b| a.force.total_cmp(&b.force));
                bears.map_or(0.0, |contact| contact.side)
            };
            add("side_force", "side force of the follower", NEWTON, false, Box::new(bearing));
        }
        let (key, name, unit) = match self.follower.cam_turns() {
            true => ("lever_torque", self.turned(), TORQUE),
            false => ("follower_force", "force on the follower", NEWTON),
        };
        add(key, name, unit, false, Box::new(|forces| forces.load));
        for (i, mechanism) in self.follower.linkage.0.iter().enumerate() {
            let (key, name) = (format!("linkage{}", i + 1), format!("linkage[{}] ({})", i + 1, mechanism.name()));
            let input = Box::new(move |forces: &Forces| forces.mechanisms[i].input);
            // Without inertia of the lever that of the first one is the torque on the lever.
            let same = i == 0 && self.loads.lever_inertia == 0.0;
            add(&format!("{key}_input"), &format!("{name}: torque on its input"), TORQUE, same, input);
            for (k, joint) in super::mechanism::joints(mechanism, self.loads.teeth).iter().enumerate() {
                let at = move |forces: &Forces| forces.mechanisms[i].joints[k];
                let key = format!("{key}_{joint}");
                add(&key, &format!("{name}: {joint}"), NEWTON, false, Box::new(move |forces| at(forces).norm()));
                add(&format!("{key}_x"), "", NEWTON, true, Box::new(move |forces| at(forces).re));
                add(&format!("{key}_y"), "", NEWTON, true, Box::new(move |forces| at(forces).im));
            }
        }
        if let Some(last) = self.follower.linkage.0.len().checked_sub(1) {
            let (name, unit) =
                if self.follower.turns { ("torque on the tool", TORQUE) } else { ("force on the tool", NEWTON) };
            add("tool_load", name, unit, false, Box::new(move |forces| forces.mechanisms[last].output));
        }
        add("torque", "torque on the shaft", TORQUE, false, Box::new(|forces| forces.torque));
        list
    }
}

impl Range {
    fn new(turn: &Turn<'_>, [key, name]: [&str; 2], unit: Unit, of: impl Fn(&State) -> f64) -> Self {
        let lowest = turn.largest(|state| -of(state));
        Range {
            quantity: key.to_owned(),
            unit: unit.0,
            largest: turn.largest(&of),
            least: Extreme { value: -lowest.value, ..lowest },
            mean: turn.mean(of),
            shown: (name.to_owned(), unit),
        }
    }

    fn row(&self) -> Vec<String> {
        let (name, (_, unit, factor)) = &self.shown;
        let (most, least) = (&self.largest, &self.least);
        let size = most.value.abs().max(least.value.abs());
        // What roundings leave of nothing.
        let is_zero = |value: f64| value.abs() <= ROUNDING * size;
        let value = |value: f64| if is_zero(value) { "0".to_owned() } else { number(factor * value) };
        let phi = |at: &Extreme| if is_zero(at.value) { NONE.to_owned() } else { format!("{}°", in_turn(at.phi, 1)) };
        let cells = [value(most.value), phi(most), value(least.value), phi(least), value(self.mean)];
        [format!("{name} [{unit}]")].into_iter().chain(cells).collect()
    }
}

impl Keeping {
    /// F₀ ≥ −(Q − F₀ Q₁)/Q₁ with Q₁ = dy/dU all over the turn, and [`Turn::lift_off`].
    fn of(turn: &Turn<'_>, j: usize, drive: &Drive) -> Self {
        let preload: f64 = drive.loads.on().map(|load| load.spring.map_or(0.0, |spring| spring.preload)).iter().sum();
        let sense = turn.sense(j);
        let helps = turn.largest(|state| -sense(state) * state.drives[j].travel).value < 0.0;
        let needed = |state: &State| preload - state.drives[j].load / state.drives[j].travel;
        Keeping { least_preload: helps.then(|| turn.largest(needed)), lift_off_speed: turn.lift_off(j) }
    }
}

/// "from 1623.3 rpm on" of a speed of lift-off.
fn from(lift_off: f64) -> String {
    if lift_off == 0.0 { "even at rest".to_owned() } else { format!("from {} rpm on", rpm(lift_off)) }
}

/// Angles in a row.
fn angles(list: &[f64]) -> String {
    list.iter().map(|phi| format!("{}°", in_turn(*phi, 2))).collect::<Vec<_>>().join(", ")
}

impl OfDrive {
    fn new(turn: &Turn<'_>, j: usize, drive: &Drive, speed: f64) -> Self {
        let told = drive.quantities().into_iter().filter(|quantity| !quantity.part);
        let range = |q: Quantity<'_>| Range::new(turn, [&q.key, &q.name], q.unit, |state| (q.of)(&state.drives[j]));
        let pressing = |state: &State| {
            let forces = &state.drives[j];
            forces.contacts.first().map_or(forces.load, |contact| contact.force)
        };
        let mut of = OfDrive {
            name: drive.name.clone(),
            quantities: told.map(range).collect(),
            sign_changes: turn.sign_changes(pressing),
            keeping: drive.is_force_closed().then(|| Keeping::of(turn, j, drive)),
            notes: [Vec::new(), Vec::new()],
        };
        of.notes = of.notes(drive, speed);
        of
    }

    /// The speed of lift-off where this speed (rad/s) reaches it.
    fn lost_at(&self, speed: f64) -> Option<f64> {
        let lift_off = self.keeping.as_ref()?.lift_off_speed?.value;
        (speed.abs() >= lift_off).then_some(lift_off)
    }

    /// Remarks and warnings.
    fn notes(&self, drive: &Drive, speed: f64) -> [Vec<String>; 2] {
        let (mut known, mut mind) = (Vec::new(), Vec::new());
        let unit = if drive.follower.turns { "N·m" } else { "N" };
        let what = match drive.plan {
            Some(_) if drive.is_flat() => "force on the face",
            Some(_) => "force of the roller",
            None if drive.follower.cam_turns() => drive.turned(),
            None => "force on the follower",
        };
        let place = |phi: f64| format!("φ = {}°", in_turn(phi, 2));
        let changes = angles(&self.sign_changes);
        if let Some(Keeping { least_preload, lift_off_speed }) = &self.keeping {
            if let Some(lift_off) = self.lost_at(speed) {
                let how = if changes.is_empty() {
                    "never presses".to_owned()
                } else {
                    format!("changes its sign at φ = {changes}")
                };
                let preload = if least_preload.is_some() { "a larger preload, " } else { "" };
                let speed = if lift_off == 0.0 { "" } else { "a lower speed, " };
                let or = if preload.len() + speed.len() > 0 { "or " } else { "" };
                mind.push(format!(
                    "{}: the {what} {how}; nothing keeps it on the cam. Remedies: {preload}{speed}{or}a cam that holds it on both sides (groove, conjugate).",
                    self.name
                ));
            }
            known.push(match *lift_off_speed {
                Some(Extreme { phi, value }) => {
                    format!("The follower leaves the cam {}, first at {}.", from(value), place(phi))
                }
                None => "The follower stays on the cam at any speed.".to_owned(),
            });
            known.push(match *least_preload {
                Some(Extreme { value, .. }) if value <= 0.0 => {
                    "It needs no preload of a spring at this speed.".to_owned()
                }
                Some(Extreme { phi, value }) => format!(
                    "Least preload of a return spring at this speed: {} {unit}, needed at {}.",
                    text::digits(value, 5, -4),
                    place(phi)
                ),
                None => "No preload of a spring at the tool keeps it there: somewhere it would pull the roller off."
                    .to_owned(),
            });
        } else {
            known.push(match changes.is_empty() {
                true => format!("The {what} never changes its sign: no play would be crossed."),
                false => format!("The {what} changes its sign, and any play would be crossed, at φ = {changes}."),
            });
        }
        // What a tenth of a millimetre shows: whether there is a cam at all.
        let coarse = Tolerances { chord: 1e-4, table: 1e-4 };
        match drive.plan.map(|plan| Shape::new(&self.name, &drive.follower.cam, plan, coarse)) {
            Some(Ok(shape)) => mind.extend(shape.complaints(Verdict::Fault)),
            Some(Err(fault)) => mind.push(format!("{}: {fault}", self.name)),
            None => {}
        }
        if drive.plan.is_some() && drive.loads.material.is_none() {
            known.push("With `roller_width` in [forces] the Hertzian pressure follows.".to_owned());
        }
        [known, mind]
    }
}

impl Power {
    fn text(&self) -> String {
        let size = self.largest.abs();
        if self.process == 0.0 {
            let part = self.shaft.abs() / size;
            return format!(
                "Over the turn the shaft gives no power ({part:.0e} of the largest power, {} W): there is no process.",
                number(size)
            );
        }
        let watts = |power: f64| if power.abs() <= ROUNDING * size { "0".to_owned() } else { number(power) };
        format!(
            "Over the turn the shaft gives {} W and the process takes {} W; they differ by {:.0e} of the largest power, {} W.",
            watts(self.shaft),
            watts(self.process),
            (self.shaft - self.process).abs() / size,
            number(size)
        )
    }
}

impl Report {
    /// The report of this turn.
    pub fn new(machine: &Machine, turn: &Turn<'_>) -> Self {
        let names = ["torque", "total torque on the shaft"];
        let shaft = Range::new(turn, names, TORQUE, |state| state.torque);
        let taken = turn.mean(|state| state.drives.iter().map(|forces| forces.process).sum());
        let largest = shaft.largest.value.abs().max(shaft.least.value.abs());
        let [of_shaft, process, largest] = [shaft.mean, taken, largest].map(|torque| torque * machine.speed);
        let of_drive = |(j, drive)| OfDrive::new(turn, j, drive, machine.speed);
        Report {
            scene: machine.name.clone(),
            speed: machine.speed,
            drives: machine.drives.iter().enumerate().map(of_drive).collect(),
            power: Power { shaft: of_shaft, process, largest },
            shaft,
        }
    }

    /// That followers leave their cams at this speed, for each of them.
    pub fn lost(&self) -> Vec<String> {
        let of = |drive: &OfDrive| {
            let lift_off = drive.lost_at(self.speed).filter(|lift_off| self.speed.abs() > *lift_off)?;
            let holds = match lift_off {
                0.0 => "not even at rest".to_owned(),
                _ => format!("up to {} rpm", rpm(lift_off)),
            };
            Some(format!("{} leaves its cam at {} rpm (contact holds {holds})", drive.name, rpm(self.speed)))
        };
        self.drives.iter().filter_map(of).collect()
    }

    /// The report for lines of this width.
    pub fn text(&self, width: usize) -> String {
        let rpm = text::digits(self.speed * 60.0 / TAU, 6, -4);
        let mut page =
            Page::new(format!("{}: forces at constant {rpm} rpm, without friction and clearance", self.scene), width);
        let head = "quantity  largest  at φ  least  at φ  mean";
        for drive in &self.drives {
            page.table(&drive.name, &Table::new(head, drive.quantities.iter().map(Range::row)));
            page.section("", &drive.notes[0]);
        }
        let own = self.drives.first().and_then(|drive| drive.quantities.last());
        let alone = self.drives.len() == 1 && own.is_some_and(|own| own.largest == self.shaft.largest);
        if !alone {
            page.table("Shaft", &Table::new(head, [self.shaft.row()]));
        }
        page.section("Power", (self.power.largest != 0.0).then(|| self.power.text()));
        page.section("Notes", self.drives.iter().flat_map(|drive| &drive.notes[1])).text()
    }
}

/// From which speed on force no longer keeps a follower on its cam, whatever moves it.
#[derive(Clone, Debug, Serialize)]
pub struct LiftOff {
    /// Its name: "follower1".
    pub follower: String,
    /// See [`Turn::lift_off`].
    pub lift_off_speed: Option<Extreme>,
    /// Whether the motion of the FMU knows the flight.
    pub may_leave: bool,
}

impl LiftOff {
    /// In a sentence.
    pub fn text(&self) -> String {
        let held = if self.may_leave { "" } else { "; the motion of the FMU keeps the contact" };
        match self.lift_off_speed {
            None => format!("{} stays on its cam at any speed.", self.follower),
            Some(Extreme { phi, value }) => {
                let at = in_turn(phi, 2);
                format!("{} leaves its cam {}, first at φ = {at}°, as a rigid body{held}.", self.follower, from(value))
            }
        }
    }
}

impl Machine {
    /// The speeds of lift-off of all followers that nothing but their loads keeps on their cams.
    ///
    /// # Errors
    /// Those of [`Drive::at`].
    pub fn lift_offs(mut self) -> Result<Vec<LiftOff>, Fault> {
        // They do without the pressure in the contact, which an undercut cam does not have.
        self.drives.iter_mut().for_each(|drive| drive.loads.material = None);
        let turn = self.turn()?;
        let of = |(j, drive): (usize, &Drive)| {
            // Where the scene names nothing that acts, nothing tells what holds the follower.
            let acts = drive.loads.lever_inertia > 0.0 || drive.loads.on().iter().any(|load| !load.is_none());
            let name = drive.name.rsplit_once('.').map_or("the follower", |(_, follower)| follower);
            (acts && drive.is_force_closed()).then(|| LiftOff {
                follower: name.to_owned(),
                lift_off_speed: turn.lift_off(j),
                may_leave: drive.loads.may_leave,
            })
        };
        Ok(self.drives.iter().enumerate().filter_map(of).collect())
    }

    /// What the motion of an FMU leaves out, and the speeds from which its followers would leave their cams though in that motion
    /// they cannot, in a sentence; None without either.
    pub fn left_out(self) -> Option<String> {
        let lever = self.drives.iter().any(|drive| drive.loads.lever_inertia > 0.0);
        let instead = if self.drives.iter().any(|drive| drive.name.contains('.')) {
            "[follower.backlash] with s = \"inf\" in a DriveTrain"
        } else {
            "BacklashDrive with s = \"inf\""
        };
        let leaving =
            self.lift_offs().unwrap_or_default().into_iter().filter(|of| !of.may_leave).filter_map(|of| {
                Some(format!("{} would leave its cam {}", of.follower, from(of.lift_off_speed?.value)))
            });
        let leaving = leaving.collect::<Vec<_>>().join(", ");
        let leaving = if leaving.is_empty() {
            leaving
        } else {
            format!("contact holds at any speed; in the machine {leaving} ({instead} models that)")
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

/// The torque and the power of the shaft over the turn.
///
/// # Errors
/// None in practice: the writer fills memory.
pub fn shaft_csv(turn: &Turn<'_>, speed: f64) -> Result<String, Fault> {
    let row = |state: &State| (state.phi.to_degrees(), vec![state.torque, state.torque * speed]);
    text::csv("phi_deg,torque_Nm,power_W", turn.states().map(row))
}

/// Every quantity of a drive over the turn.
///
/// # Errors
/// None in practice: the writer fills memory.
pub fn csv(turn: &Turn<'_>, j: usize, drive: &Drive) -> Result<String, Fault> {
    let quantities = drive.quantities();
    let mut head = "phi_deg".to_owned();
    for Quantity { key, unit: (_, unit, _), .. } in &quantities {
        head += &format!(",{key}_{}", unit.replace('·', "").replace('°', "deg"));
    }
    let row = |state: &State| {
        let values = quantities.iter().map(|q| q.unit.2 * (q.of)(&state.drives[j]));
        (state.phi.to_degrees(), values.collect::<Vec<f64>>())
    };
    text::csv(&head, turn.states().map(row))
}
