//! A turn of the periodic motion of any drive, from φ = 0 on: the least and largest values of its outputs and where they lie.
//!
//! The drive starts on the motion and advances by equal times; it stops just before and just after each of its events, so that no
//! search spans a jump. Extremes are refined between those points.

mod disturbance;
#[cfg(test)]
mod tests;
mod vibration;

pub use vibration::{Dwell, Harmonic};

use crate::resource::Scene;
use crate::search::{Extreme, root, summit};
use crate::text;
use camdrive::drives::drive_train::{DriveTrain, Periodic, Shaft};
use camdrive::drives::elastic_shaft::{ElasticShaft, Found};
pub use camdrive::drives::limits::NEUTRAL;
use camdrive::drives::parametric::ParametricDrive;
use camdrive::drives::rigid_machine::Motor;
use camdrive::drives::shaft::cam_drive::DriveMode;
use camdrive::drives::shaft::cam_turn::turns;
use camdrive::drives::variable::{Causality, Kind, Variability};
use camdrive::drives::{About, AnyDrive, Description, Drive, Fault, Snapshot};
use serde::Serialize;
use std::f64::consts::TAU;

/// Points of a turn at least; a vibration of 48 periods a turn has thirty.
pub const POINTS: usize = 1440;

/// Points of a sketch: a line of them has no corner on a screen.
const SKETCHED: usize = 480;

/// `solver.tolerance` of the turn, finer than any digit that is shown, and of a sketch, finer than a pixel.
const TOLERANCE: f64 = 1e-13;
const OF_SKETCH: f64 = 1e-7;

/// Points next to an event are this fraction of a step away from it: its instant is known better.
const BESIDE: f64 = 1e-9;

/// The outputs of interest, of each follower where it has them, and of the shaft.
const OUTPUTS: [&str; 9] = ["x", "y", "q", "gap", "force", "contact_force", "tau", "M_an", "w"];

/// An output over the turn.
#[derive(Clone, Debug, Serialize)]
pub struct Range {
    /// Its name.
    pub output: String,
    /// Its unit.
    pub unit: &'static str,
    /// The least value.
    pub least: f64,
    /// φ (rad) there.
    pub least_at: f64,
    /// The largest value.
    pub largest: f64,
    /// φ (rad) there.
    pub largest_at: f64,
    /// The mean over time, the impulses of impacts included.
    pub mean: f64,
    /// The root of the mean square over time, without impulses.
    pub rms: f64,
    /// The largest size; of a torque on a free shaft at least E, next to which it may be rounding.
    #[serde(skip)]
    pub size: f64,
    /// Its values at the points.
    #[serde(skip)]
    pub values: Vec<f64>,
}

impl Range {
    /// The value that is largest in size, with its sign.
    pub fn peak(&self) -> Extreme {
        let [low, high] = [(self.least_at, self.least), (self.largest_at, self.largest)];
        let [low, high] = [low, high].map(|(phi, value)| Extreme { phi, value });
        Extreme::greatest([low, high], f64::abs).unwrap_or(high)
    }

    /// A value of it for people, without roundings.
    pub fn clean(&self, value: f64) -> f64 {
        text::clean(value, self.size)
    }

    /// Its name without the follower's, and the follower's number; 0 if the drive has only one.
    pub fn part(&self) -> (&str, usize) {
        part(&self.output)
    }
}

/// A turn of a periodic motion.
#[derive(Clone, Debug, Serialize)]
pub struct Turn {
    /// T (s).
    pub period: f64,
    /// ±2π/T (rad/s).
    pub mean_speed: f64,
    /// The mean torque (N·m) that the motor has on the shaft, or that a driven shaft needs, over the angle, impacts included.
    pub mean_torque: f64,
    /// The mean power (W) of that.
    pub mean_power: f64,
    /// The torque at φ = 0 (N·m), and there E (J) of a free shaft.
    #[serde(skip)]
    pub at_zero: [f64; 2],
    /// The factors [re, im] by which disturbances grow in a turn, the largest one first; none where they are not known.
    pub multipliers: Vec<[f64; 2]>,
    /// ln of the size of the largest of them.
    #[serde(skip)]
    pub growth: Option<f64>,
    /// The followers (from 1) that their cams pull, and the angles φ (rad) at which the pull begins.
    pub pulls: Vec<(usize, f64)>,
    /// The outputs, in the order of the model.
    pub outputs: Vec<Range>,
    /// Impacts of each follower in the turn; null of one without clearance.
    pub impacts: Vec<Option<f64>>,
    /// The impacts themselves, in their order.
    pub impulses: Vec<Impact>,
    /// φ (rad) of the points over a whole turn.
    #[serde(skip)]
    pub angles: Vec<f64>,
    /// Their instants (s).
    #[serde(skip)]
    pub times: Vec<f64>,
}

/// An impact.
#[derive(Clone, Debug, Serialize)]
pub struct Impact {
    /// The number of the follower, from 1.
    pub follower: usize,
    /// φ (rad) there.
    pub phi: f64,
    /// The part it hits, "flank A".
    pub on: &'static str,
    /// Its impulse (N·s).
    pub impulse: f64,
}

/// The last part of a name, and the number of its follower: of `follower[2].q` and of `q[2]` those are q and 2.
pub fn part(name: &str) -> (&str, usize) {
    let number = |text: &str| text.split(']').next().and_then(|n| n.parse().ok()).unwrap_or(0);
    match (name.strip_prefix("follower[").and_then(|rest| rest.split_once("].")), name.split_once('[')) {
        (Some((j, last)), _) => (last, number(j)),
        (None, Some((last, j))) => (last, number(j)),
        (None, None) => (name, 0),
    }
}

/// A drive on its way through a turn.
struct Walk {
    drive: AnyDrive,
    /// Its state at φ = 0.
    begin: Snapshot,
    /// Its time (s).
    time: f64,
}

impl Walk {
    /// Goes back to φ = 0.
    fn restart(&mut self) {
        self.drive.restore(&self.begin);
        self.time = 0.0;
    }

    fn to(&mut self, time: f64) -> Result<(), Fault> {
        if time > self.time {
            self.drive.advance(self.time, time - self.time)?;
            self.time = time;
        }
        Ok(())
    }

    /// A column of values for each of these variables.
    fn values(&mut self, times: &[f64], variables: &[usize]) -> Result<Vec<Vec<f64>>, Fault> {
        self.restart();
        let mut columns = vec![Vec::with_capacity(times.len()); variables.len()];
        for time in times {
            self.to(*time)?;
            for (variable, column) in variables.iter().zip(&mut columns) {
                column.push(self.drive.get(*variable)?);
            }
        }
        Ok(columns)
    }
}

/// The scene from φ = 0 on, at this speed (rad/s) where it has a prescribed one or follows inputs.
///
/// # Errors
/// If the scene follows inputs and `speed` is None.
pub fn from_zero(scene: &Scene, speed: Option<f64>) -> Result<Scene, Fault> {
    let mut scene = scene.clone();
    match &mut scene {
        // Without torques it is the start that has the speed.
        Scene::RigidMachine(machine) if machine.motor != Motor::None => machine.phi_start = 0.0,
        Scene::DriveTrain(train) => {
            if let Shaft::Free(machine) = &mut train.shaft {
                machine.phi_start = 0.0;
            }
        }
        _ => {}
    }
    let Some(mode) = scene.drive_mut() else { return Ok(scene) };
    let own = match (&*mode, speed) {
        (_, Some(speed)) => Ok(speed),
        (DriveMode::Constant { w, .. }, None) => Ok(*w),
        _ => Err(Fault::new("the drive follows its inputs, so that its speed is not known")
            .hint("give --speed, \"1800 rpm\"")),
    };
    *mode = DriveMode::Constant { w: own?, phi_start: 0.0 };
    Ok(scene)
}

/// The place of a variable.
pub fn place(all: &[Description], name: &str) -> Option<usize> {
    all.iter().position(|d| d.name == name)
}

/// The number of an item of the enumeration `start.mode`.
fn start_mode(all: &[Description], start: &str) -> Option<(usize, f64)> {
    let mode = place(all, "start.mode")?;
    let Kind::Enumeration(items) = &all[mode].kind else { return None };
    let item = items.items.iter().position(|(name, _)| *name == start)?;
    Some((mode, 1.0 + item as f64))
}

/// A drive of the scene, to be set up further and started at φ = 0.
fn prepared(scene: &Scene, start: &str, tolerance: f64) -> Result<AnyDrive, Fault> {
    let mut drive = scene.build()?.plan().instance();
    drive.set_up(0.0, None);
    let all = drive.descriptions().to_vec();
    let tolerance = place(&all, "solver.tolerance").map(|place| (place, tolerance));
    for (place, value) in start_mode(&all, start).into_iter().chain(tolerance) {
        drive.set(place, value)?;
    }
    Ok(drive)
}

/// The period (s) of a drive at the start of its turn: that in which its angle grows by a turn.
fn period(walk: &mut Walk, phi: usize, w: Option<usize>) -> Result<f64, Fault> {
    let (begin, speed) = (walk.drive.get(phi)?, w.map_or(Ok(0.0), |w| walk.drive.get(w))?);
    let step = TAU / speed.abs() / 64.0;
    if !step.is_finite() {
        return Err(Fault::new("the shaft stands still: there is no turn"));
    }
    let turned = |walk: &mut Walk, from: f64, to: f64| -> Result<f64, Fault> {
        walk.time = from;
        walk.to(to)?;
        Ok((walk.drive.get(phi)? - begin).abs() - TAU)
    };
    let (mut before, mut saved) = (0.0, walk.drive.save());
    // A shaft that is ten times slower on the mean than at φ = 0 still ends its turn.
    for k in 1..=640 {
        if turned(walk, before, k as f64 * step)? >= 0.0 {
            break;
        }
        (before, saved) = (k as f64 * step, walk.drive.save());
    }
    let ends = [before, before + step];
    let mut miss = |time: f64| {
        walk.drive.restore(&saved);
        turned(walk, before, time).unwrap_or(f64::NAN)
    };
    if (ends.map(&mut miss)).map(f64::is_sign_negative) == [true, true] {
        return Err(Fault::new("the shaft does not turn round"));
    }
    Ok(root(miss, ends))
}

/// The reason of a drive at the speed zero.
pub const STANDS: &str = "the shaft stands still: there is no motion to judge";

/// Free motions without damping.
pub const NEVER: &str = "free motions neither grow nor decay: the start never settles";

/// What a turn makes of small disturbances: the columns of its map, and ln of the factor by which the largest one grows.
type Disturbed = (Vec<Vec<f64>>, f64);

/// A drive of the scene that has started on its periodic motion at φ = 0, at this speed (rad/s) where it follows inputs, under a
/// constant load (N·m) where it is a machine; of a motion that may be unstable, what a turn makes of disturbances.
///
/// # Errors
/// The drive's fault if there is no such motion.
fn started(
    tolerance: f64,
    scene: &Scene,
    speed: Option<f64>,
    load: f64,
) -> Result<(AnyDrive, Option<Disturbed>), Fault> {
    let mut scene = from_zero(scene, speed)?;
    if matches!(scene.drive(), Some(DriveMode::Constant { w, .. }) if !turns(*w)) {
        return Err(Fault::new(STANDS).motionless(STANDS));
    }
    match &mut scene {
        Scene::DriveTrain(train) => {
            train.solver.tolerance = tolerance;
            let mut train = DriveTrain::new(train.clone())?;
            let Periodic { map, multiplier, .. } = train.periodic_motion()?;
            let map = map.iter().map(|column| column[..map.len()].to_vec()).collect();
            return Ok((AnyDrive::from(train).under_way(), Some((map, multiplier.ln()))));
        }
        Scene::ElasticShaft(shaft) => {
            shaft.solver.tolerance = tolerance;
            let mut drive = ElasticShaft::new(shaft.clone())?;
            let Found { map, growth, .. } = drive.periodic_motion()?;
            return Ok((AnyDrive::from(drive).under_way(), Some((map.map(Vec::from).into(), growth))));
        }
        Scene::ParametricDrive(own) => {
            own.solver.tolerance = tolerance;
            let mut drive = ParametricDrive::new(own.clone())?;
            let Found { map, growth, .. } = drive.periodic_motion()?;
            return Ok((AnyDrive::from(drive).under_way(), Some((map.map(Vec::from).into(), growth))));
        }
        _ => {}
    }
    let without_torques = matches!(&scene, Scene::RigidMachine(machine) if machine.motor == Motor::None);
    let mut drive = prepared(&scene, if without_torques { "given" } else { "steady_state" }, tolerance)?;
    if load != 0.0 {
        let tau = place(drive.descriptions(), "tau").ok_or_else(|| Fault::new("the machine has no load `tau`"))?;
        drive.set(tau, load)?;
    }
    drive.start()?;
    Ok((drive, None))
}

/// A turn of the periodic motion of a scene, see [`started`].
///
/// # Errors
/// The drive's fault if there is no such motion.
pub fn of(scene: &Scene, speed: Option<f64>, load: f64) -> Result<Turn, Fault> {
    let (drive, found) = started(TOLERANCE, scene, speed, load)?;
    let mut turn = Turn::of(drive, true)?;
    if let Some((map, growth)) = found {
        (turn.multipliers, turn.growth) = (disturbance::eigenvalues(&map), Some(growth));
    } else {
        turn.multipliers = disturbance::multipliers(&from_zero(scene, speed)?, &turn).unwrap_or_default();
        turn.growth = turn.multipliers.first().map(|[re, im]| re.hypot(*im).ln());
    }
    Ok(turn)
}

/// The same turn for the eye: fewer points, the extremes are the points', and nothing is disturbed.
///
/// # Errors
/// The drive's fault if there is no such motion.
pub fn sketch(scene: &Scene) -> Result<Turn, Fault> {
    Turn::of(started(OF_SKETCH, scene, None, 0.0)?.0, false)
}

impl Turn {
    /// The turn of a drive that is on a periodic motion at φ = 0, fine or as a sketch.
    fn of(drive: AnyDrive, fine: bool) -> Result<Turn, Fault> {
        let all = drive.descriptions().to_vec();
        let phi = place(&all, "phi").ok_or_else(|| Fault::new("the drive has no angle of its own"))?;
        let followed: Vec<(usize, &'static str)> =
            all.iter().enumerate().filter_map(|(i, d)| Some((i, shown(d)?))).collect();
        let outputs: Vec<usize> = followed.iter().map(|(of, _)| *of).collect();
        let mut walk = Walk { begin: drive.save(), drive, time: 0.0 };
        let period = period(&mut walk, phi, place(&all, "w"))?;
        let read = Columns::of(&all, phi, &outputs);
        let Instants { times, pulls, impulses, columns } = match fine {
            true => {
                let mut found = instants(&mut walk, period, phi, POINTS, &[])?;
                found.columns = walk.values(&found.times, &read)?;
                found
            }
            // Beside its impacts a sketch has no points: a jump is as wide as a line.
            false => instants(&mut walk, period, phi, SKETCHED, &read)?,
        };
        let turned = Columns { read, values: columns };
        let mut angles = turned.of_variable(phi).to_vec();
        let columns: Vec<Vec<f64>> = outputs.iter().map(|of| turned.of_variable(*of).to_vec()).collect();
        let extremes = match fine {
            true => extremes(&mut walk, &times, &outputs, &columns, phi)?,
            false => columns.iter().map(|values| of_points(&angles, values)).collect(),
        };
        let (first, end) = (angles[0], angles[times.len() - 1]);
        let mean_speed = (TAU / period).copysign(end - first);
        let whole = TAU * (first / TAU).floor();
        angles.iter_mut().for_each(|phi| *phi -= whole);
        let energy = place(&all, "E").map_or(0.0, |energy| turned.of_variable(energy)[0]);
        let means = followed.iter().map(|(of, _)| turned.mean_with_impulses(&all, &times, &all[*of].name));
        let means: Vec<Option<f64>> = means.collect();
        let ranges = followed.iter().zip(columns).zip(extremes).zip(means).map(
            |((((of, unit), values), [low, high]), with_impulses)| {
                let square: Vec<f64> = values.iter().map(|v| v * v).collect();
                Range {
                    output: all[*of].name.clone(),
                    unit,
                    least: low.value,
                    least_at: low.phi,
                    largest: high.value,
                    largest_at: high.phi,
                    mean: with_impulses.unwrap_or_else(|| mean(&times, &values)),
                    rms: mean(&times, &square).sqrt(),
                    size: [low.value, high.value, if *unit == "N.m" { energy } else { 0.0 }]
                        .map(f64::abs)
                        .into_iter()
                        .fold(0.0, f64::max),
                    values,
                }
            },
        );
        let ranges: Vec<Range> = ranges.collect();
        let (torque, power) = turned.torques(&all, &times, (mean_speed, &ranges));
        Ok(Turn {
            period,
            mean_speed,
            mean_torque: torque[0],
            mean_power: power,
            at_zero: [torque[1], energy],
            multipliers: Vec::new(),
            growth: None,
            pulls,
            outputs: ranges,
            impacts: turned.impacts(&all),
            impulses,
            angles,
            times,
        })
    }

    /// The followers, from 0, whose contact opens on a shaft that a motor turns.
    pub fn opened<'a>(&'a self, scene: &'a Scene) -> impl Iterator<Item = usize> + 'a {
        let hits = |j: usize| self.impacts.get(j).copied().flatten().is_some_and(|impacts| impacts > 0.0);
        let pulled = |j: usize| self.pulls.iter().any(|(follower, _)| *follower == j + 1);
        let free = scene.drive().is_none();
        (0..scene.followers()).filter(move |j| free && (pulled(*j) || scene.is_one_sided(*j) && hits(*j)))
    }

    /// The output with this name.
    pub fn output(&self, name: &str) -> Option<&Range> {
        self.outputs.iter().find(|of| of.output == name)
    }

    /// Largest less least speed as part of the mean.
    pub fn fluctuation(&self) -> f64 {
        let [least, largest] = self.speeds();
        (largest - least) / self.mean_speed.abs()
    }

    /// The least and the largest speed (rad/s).
    pub fn speeds(&self) -> [f64; 2] {
        self.output("w").map_or([self.mean_speed; 2], |w| [w.least, w.largest])
    }
}

/// Variables at the points of a turn.
struct Columns {
    read: Vec<usize>,
    values: Vec<Vec<f64>>,
}

impl Columns {
    /// What a turn reads: its outputs, and what its means, torques and impacts follow from.
    fn of(all: &[Description], phi: usize, outputs: &[usize]) -> Vec<usize> {
        let mut read = vec![phi];
        read.extend(outputs);
        read.extend(["E", "M_an", "w"].iter().filter_map(|name| place(all, name)));
        read.extend(outputs.iter().filter_map(|of| place(all, &format!("{}_mean", all[*of].name))));
        read.extend(counts_of_impacts(all));
        read.sort_unstable();
        read.dedup();
        read
    }

    fn of_variable(&self, variable: usize) -> &[f64] {
        self.read.binary_search(&variable).map_or(&[], |at| &self.values[at])
    }

    /// The mean torque on the shaft (N·m) with that at φ = 0, and the mean power (W): of the motor, or what a driven shaft needs.
    fn torques(&self, all: &[Description], times: &[f64], (speed, outputs): (f64, &[Range])) -> ([f64; 2], f64) {
        if let Some(motor) = place(all, "M_an") {
            let [torque, w] = [motor, place(all, "w").unwrap_or(motor)].map(|of| self.of_variable(of));
            let power: Vec<f64> = torque.iter().zip(w).map(|(torque, w)| torque * w).collect();
            let power = mean(times, &power);
            return ([power / speed, torque[0]], power);
        }
        let taken = outputs.iter().filter(|of| of.part().0 == "tau");
        let sums = taken.fold([0.0; 2], |[mean, at_zero], of| [mean + of.mean, at_zero + of.values[0]]);
        (sums, sums[0] * speed)
    }

    /// The mean of a force or torque with the impulses of impacts, from its means over the steps; None without impacts.
    fn mean_with_impulses(&self, all: &[Description], times: &[f64], name: &str) -> Option<f64> {
        let column = self.of_variable(place(all, &format!("{name}_mean"))?);
        let steps = times.windows(2).map(|ends| ends[1] - ends[0]);
        Some(steps.zip(&column[1..]).map(|(step, mean)| step * mean).sum::<f64>() / times[times.len() - 1])
    }

    /// Impacts of each follower in the turn.
    fn impacts(&self, all: &[Description]) -> Vec<Option<f64>> {
        let outputs = all.iter().filter(|d| d.causality == Causality::Output);
        let followers = outputs.map(|d| part(&d.name).1).max().unwrap_or(0).max(1);
        let mut impacts = vec![None; followers];
        for of in counts_of_impacts(all) {
            let counts = self.of_variable(of);
            impacts[part(&all[of].name).1.saturating_sub(1)] = Some(counts[counts.len() - 1] - counts[0]);
        }
        impacts
    }
}

/// The outputs that count impacts.
fn counts_of_impacts(all: &[Description]) -> impl Iterator<Item = usize> {
    let counts = |d: &Description| d.causality == Causality::Output && part(&d.name).0 == "impacts";
    all.iter().enumerate().filter(move |(_, d)| counts(d)).map(|(i, _)| i)
}

/// The unit of an output of interest.
fn shown(d: &Description) -> Option<&'static str> {
    let Kind::Real { quantity, .. } = d.kind else { return None };
    let (last, number) = part(&d.name);
    let is_output = d.causality == Causality::Output && d.variability == Variability::Continuous;
    // The law of a train's follower is called follower[1].U, the tool of a machine U[1].
    let is_tool = last == "U" && number > 0;
    (is_output && (OUTPUTS.contains(&last) || is_tool)).then_some(quantity.unit)
}

/// The mean over time of values at these instants, between which they are linear.
fn mean(times: &[f64], values: &[f64]) -> f64 {
    let parts = times.windows(2).zip(values.windows(2));
    let sum: f64 = parts.map(|(t, v)| 0.5 * (t[1] - t[0]) * (v[0] + v[1])).sum();
    sum / (times[times.len() - 1] - times[0])
}

/// The points of a turn, and what happens between them.
struct Instants {
    times: Vec<f64>,
    pulls: Vec<(usize, f64)>,
    impulses: Vec<Impact>,
    columns: Vec<Vec<f64>>,
}

/// The instants of the points: equal parts of the turn and, where nothing is read at once, both sides of each event.
fn instants(walk: &mut Walk, period: f64, phi: usize, points: usize, read: &[usize]) -> Result<Instants, Fault> {
    walk.restart();
    let mut columns = vec![Vec::with_capacity(points + 1); read.len()];
    let mut record = |drive: &mut AnyDrive| -> Result<(), Fault> {
        read.iter().zip(&mut columns).try_for_each(|(of, column)| drive.get(*of).map(|value| column.push(value)))
    };
    record(&mut walk.drive)?;
    let (mut pulls, mut impulses) = (Vec::new(), Vec::new());
    let step = period / points as f64;
    let mut times = vec![0.0];
    for k in 1..=points {
        let to = if k == points { period } else { k as f64 * step };
        walk.drive.events().clear();
        let before = walk.drive.get(phi)?;
        walk.to(to)?;
        record(&mut walk.drive)?;
        let (from, turned) = (times[times.len() - 1], walk.drive.get(phi)? - before);
        for event in walk.drive.events().iter().filter(|event| event.about == About::Machine) {
            if let Some(on) = event.kind.strip_prefix("impact on ") {
                let phi = (before + turned * (1.0 - (to - event.time) / step)).rem_euclid(TAU);
                impulses.push(Impact { follower: event.follower.max(1), phi, on, impulse: event.value.abs() });
            }
            if !read.is_empty() {
                continue;
            }
            times.extend(
                [event.time - BESIDE * step, event.time + BESIDE * step].iter().filter(|t| from < **t && **t < to),
            );
        }
        let pulled: Vec<usize> = walk
            .drive
            .events()
            .iter()
            .filter(|event| event.about == About::Loads)
            .map(|event| event.follower.max(1))
            .collect();
        for follower in pulled {
            pulls.push((follower, walk.drive.get(phi)?.rem_euclid(TAU)));
        }
        times.push(to);
    }
    times.sort_by(f64::total_cmp);
    times.dedup();
    Ok(Instants { times, pulls, impulses, columns })
}

/// The least and the largest of these values.
fn of_points(angles: &[f64], values: &[f64]) -> [Extreme; 2] {
    let point = |(phi, value): (&f64, &f64)| Extreme { phi: *phi, value: *value };
    let points = || angles.iter().zip(values).map(point);
    let order = |a: &Extreme, b: &Extreme| a.value.total_cmp(&b.value);
    let none = Extreme { phi: 0.0, value: 0.0 };
    [points().min_by(order).unwrap_or(none), points().max_by(order).unwrap_or(none)]
}

/// The least and the largest value of each output, with the angles at them.
fn extremes(
    walk: &mut Walk,
    times: &[f64],
    outputs: &[usize],
    columns: &[Vec<f64>],
    phi: usize,
) -> Result<Vec<[Extreme; 2]>, Fault> {
    walk.restart();
    let mut found = vec![[const { Vec::new() }; 2]; outputs.len()];
    // From which point on each of them is sought.
    let mut wanted: Vec<(usize, usize, usize, usize)> = Vec::new();
    for (i, values) in columns.iter().enumerate() {
        for side in 0..2 {
            let value = |k: usize| if side == 0 { -values[k] } else { values[k] };
            let (most, size) = (0..times.len())
                .map(value)
                .fold((f64::NEG_INFINITY, 0.0), |(most, size), v| (v.max(most), v.abs().max(size)));
            // The first of those that differ by roundings.
            let top = (0..times.len()).find(|k| value(*k) >= most - 1e-12 * size).unwrap_or(0);
            // A local summit may be higher between its points than the highest of all points.
            let may_be = |k: &usize| {
                let beside = [k.saturating_sub(1), (k + 1).min(times.len() - 1)].map(value);
                let (low, high) = (beside[0].min(beside[1]), beside[0].max(beside[1]));
                *k == top || value(*k) >= high && value(*k) > low && 2.0 * value(*k) - low >= value(top)
            };
            wanted.extend((0..times.len()).filter(may_be).map(|k| (k.saturating_sub(1), k, i, side)));
        }
    }
    wanted.sort_unstable();
    let step = times[times.len() - 1] / POINTS as f64;
    for (from, top, i, side) in wanted {
        walk.to(times[from])?;
        let (saved, begin, sign) = (walk.drive.save(), times[from], if side == 0 { -1.0 } else { 1.0 });
        let mut at = |t: f64, of: usize| {
            walk.drive.restore(&saved);
            let reached = if t > begin { walk.drive.advance(begin, t - begin) } else { Ok(()) };
            reached.and_then(|()| walk.drive.get(of)).unwrap_or(f64::NAN)
        };
        // A search does not pass an event, whose two points are next to each other.
        let close = |a: usize, b: usize| times[b] - times[a] <= 4.0 * BESIDE * step;
        let low = if close(from, top) { top } else { from };
        let next = (top + 1).min(times.len() - 1);
        let high = if close(top, next) { top } else { next };
        let start = (times[top], sign * columns[i][top]);
        let mut value = |t: f64| sign * at(t, outputs[i]);
        let (time, best) =
            if low < high { summit(&mut value, [times[low], times[high]], start, 1e-9 * step) } else { start };
        // On a plateau roundings decide on the place.
        let time = if best - start.1 <= 1e-12 * best.abs() { start.0 } else { time };
        found[i][side].push(Extreme { phi: at(time, phi), value: sign * best });
        walk.drive.restore(&saved);
        walk.time = begin;
    }
    let none = Extreme { phi: 0.0, value: 0.0 };
    let best =
        |side: usize, all: &[Extreme]| Extreme::greatest(all.iter().copied(), |v| if side == 0 { -v } else { v });
    Ok(found.iter().map(|sides| [0, 1].map(|side| best(side, &sides[side]).unwrap_or(none))).collect())
}

/// A disturbance that has decayed to this part is gone.
pub const GONE: f64 = 0.01;

/// The most turns of a start that are followed.
const MOST_TURNS: f64 = 50.0;

/// Points of a turn of a start: its peaks are compared by a factor.
const POINTS_OF_START: f64 = 360.0;

impl Turn {
    /// The turns in which a disturbance decays to a hundredth, one at least; None where it does not, or where that is not known.
    pub fn settles(&self) -> Option<f64> {
        self.growth.filter(|growth| *growth < -NEUTRAL).map(|growth| (GONE.ln() / growth).max(1.0))
    }
}

/// The largest sizes of the deformations, in the order of the outputs, from the start that the scene says until it has settled.
///
/// # Errors
/// What the drive says.
pub fn start_peaks(scene: &Scene, turn: &Turn) -> Result<Vec<f64>, Fault> {
    let mut drive = scene.build()?.plan().instance();
    drive.set_up(0.0, None);
    drive.start()?;
    let all = drive.descriptions().to_vec();
    let outputs: Vec<usize> =
        turn.outputs.iter().filter(|of| of.part().0 == "q").filter_map(|of| place(&all, &of.output)).collect();
    let turns = turn.settles().unwrap_or(MOST_TURNS).clamp(1.0, MOST_TURNS);
    let count = (turns * POINTS_OF_START).ceil() as usize;
    let mut walk = Walk { begin: drive.save(), drive, time: 0.0 };
    let times: Vec<f64> = (0..=count).map(|k| k as f64 * turn.period / POINTS_OF_START).collect();
    let columns = walk.values(&times, &outputs)?;
    Ok(columns.iter().map(|column| column.iter().fold(0.0, |most: f64, q| most.max(q.abs()))).collect())
}

/// Why the drive has no periodic motion, without the key that asked for it and what else that could be.
pub fn reason(fault: &Fault) -> String {
    fault.motionless.clone().unwrap_or_else(|| fault.sentence())
}
