//! A compensation and its report.

use super::iteration::{Cam, Machine, Quality, Round, rounds};
use super::loaded::LoadedMachine;
use super::periodic_motion::Driving;
use super::restrictions::{RestrictionReserve, Restrictions};
use super::spectral::{POINTS, phase};
use super::{Form, LEAST, Law, Solution, Task, Tool, laws};
use crate::periodic_motions::periodic_motions;
use crate::report::terminal::{range, shown};
use crate::report::unit::{DEG, MS, ONE, PERCENT, RPM, Unit};
use crate::report::{Level, Report, Rows, Table, Verdict};
use crate::synthesis::{KEPT, UNITS};
use crate::text::{counted, digits_beyond, number, rpm, share, time};
use crate::transmission::{self, Transmission};
use crate::{Progress, work};
use camdrive::drives::Fault;
use camdrive::drives::rigid_machine::{Kloss, MachineStart, Motor, Scene};
use camdrive::drives::settings::Settings;
use camdrive::motion::{Fourier, MotionLaw};
use serde::Serialize;
use std::f64::consts::TAU;

/// The least order of the mesh that judges machines: four times the order of the motions of a loom's tools.
const ORDER: usize = 96;

/// The speeds, relative to the design's, at which the finished machine is examined.
const OTHER_SPEEDS: [f64; 5] = [0.25, 0.5, 0.75, 1.1, 1.25];

/// Two periods belong to one motion if they agree to this part: the errors of the finite series are far smaller, and different
/// motions differ by far more.
const SAME_PERIOD: f64 = 1e-4;

/// Parts of the tolerance for a tool's own series if the machine as a whole exceeds it.
const SHARES: [f64; 3] = [0.5, 0.1, 0.01];

/// Options of the compensation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// The error of the accelerations that the finite series or tables of the cams may cause, relative to the largest.
    pub tolerance: f64,
    /// Series or tables.
    pub form: Form,
    /// Rounds of the source's iteration after round 0.
    pub rounds: usize,
}

/// A compensated machine.
#[derive(Clone, Debug, Serialize)]
pub struct Compensation {
    /// The name of the scene.
    pub scene: String,
    /// T (s).
    pub period: f64,
    /// The least and the largest ω (rad/s).
    pub speed: [f64; 2],
    /// w_s (rad/s) of the motor, if any.
    pub synchronous_speed: Option<f64>,
    /// The least J0 (kg·m²) without motor; None if other parts vary with the angle.
    pub least_inertia_without_motor: Option<f64>,
    /// ρ.
    pub factor: f64,
    /// The last harmonics of the motion, relative to its mean.
    pub resolution: f64,
    /// The rounds of the source's iteration; round 0 is the machine with cams cut for uniform speed.
    pub rounds: Vec<Round>,
    /// The size of each tool's cam law, and its remaining error.
    pub cams: Vec<Cut>,
    /// The machine with the finished cams.
    pub finished: Round,
    /// T (s) of the fastest stable motion with the finished cams, if it is not the compensated one.
    pub other_motion: Option<f64>,
    /// The finished machine at other speeds, relative to the design's; None if it finds no periodic motion.
    pub other_speeds: Vec<(f64, Option<Round>)>,
    /// The worst transmission angles of the mechanisms between cams and tools.
    pub transmission: Vec<Transmission>,
    /// The numbers of the tools' followers in the scene.
    pub numbers: Vec<usize>,
    /// The restrictions of the tools with the reserves of the prescribed motions.
    pub prescribed: Vec<RestrictionReserve>,
    /// The motion over the time.
    #[serde(skip)]
    motion: Solution,
    /// The laws of the cams.
    #[serde(skip)]
    pub laws: Vec<MotionLaw>,
    /// True for each tool whose coordinate is an angle.
    #[serde(skip)]
    pub(super) turning: Vec<bool>,
    /// The prescribed y(ψ) of the tools.
    #[serde(skip)]
    pub(super) wanted: Vec<Fourier>,
    #[serde(skip)]
    pub(super) restrictions: Restrictions,
}

/// The finite law of a cam.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Cut {
    /// The highest harmonic of a series.
    pub harmonics: Option<usize>,
    /// The number of points of a table.
    pub points: Option<usize>,
    /// The largest error of the tool's acceleration in the finished machine, relative to the largest acceleration: from its own
    /// law and, by the speed of the machine, from all others; rounded up to two digits.
    pub truncation: f64,
}

/// Compensates a machine and examines the result.
///
/// # Errors
/// The errors of [`Task::solve`] and `laws::of`, and a study that takes more work than one may.
pub fn study(
    scene: &str,
    task: &Task,
    options: Options,
    progress: &(dyn Fn(Progress) + Sync),
) -> Result<Compensation, Fault> {
    let hint = "a larger J0 or breakdown slip helps, a motor without `lag`, motions that are series instead of cycles, or a larger \
                --tolerance";
    work::within(work::BUDGET, hint, progress, |tell| looked_at(scene, task, options, tell))?
}

/// See [`study`].
fn looked_at(scene: &str, task: &Task, options: Options, progress: &dyn Fn(Progress)) -> Result<Compensation, Fault> {
    let solution = task.solve_with(progress)?;
    let stage = |stage| progress(Progress { done: 0, total: 1, stage });
    stage("laws");
    // The motor with the demanded period; from here on it is given.
    let mut driving = task.driving;
    if task.driving.motor != Motor::None {
        (driving.motor, driving.period) = (solution.periodic.motor, None);
    }
    let Finished { laws, machine, cams, round } =
        finish(task, &solution, &driving, options).map_err(|fault| beside_least_inertia(task, fault))?;
    stage("other speeds");
    let wanted: Vec<Fourier> = task.tools.iter().map(|tool| tool.wanted.clone()).collect();
    let other_speeds = OTHER_SPEEDS.iter().filter(|_| task.loaded.is_none()).map(|&part| {
        let mut driving = driving;
        match &mut driving.motor {
            Motor::Kloss(Kloss { synchronous_speed, .. }) => *synchronous_speed *= part,
            _ => driving.period = driving.period.map(|period| period / part),
        }
        (part, machine.periodic_motion(&cams, &driving).map(|periodic| machine.judge(&periodic, &cams)))
    });
    Ok(Compensation {
        scene: scene.to_owned(),
        period: solution.periodic.period(),
        speed: solution.range(),
        synchronous_speed: match solution.periodic.motor {
            Motor::Kloss(Kloss { synchronous_speed, .. }) => Some(synchronous_speed),
            _ => None,
        },
        least_inertia_without_motor: (!task.own.varies()).then(|| task.least_inertia_without_motor()),
        factor: solution.factor,
        resolution: solution.resolution,
        rounds: match &solution.loaded {
            None => rounds(task, ORDER.max(solution.speed.order()), options.rounds),
            // The round with cams for uniform speed.
            Some(found) => {
                let laws: Vec<&MotionLaw> = task.tools.iter().map(|tool| &tool.motion).collect();
                on_loaded(task, found, &laws, solution.speed.order()).map(|(.., round)| round).into_iter().collect()
            }
        },
        cams: laws.iter().zip(&round.tools).map(cut).collect(),
        finished: round,
        other_motion: other_motion(task, &laws, &driving, solution.periodic.period())?,
        transmission: pairs(task, &laws)
            .flat_map(|(tool, law)| transmission::of(tool.number, &tool.with_law(&law.law)))
            .collect(),
        numbers: task.tools.iter().map(|tool| tool.number).collect(),
        other_speeds: other_speeds.collect(),
        prescribed: task.restrictions.kept(&wanted),
        wanted,
        restrictions: task.restrictions.clone(),
        turning: task.tools.iter().map(Tool::turns).collect(),
        laws: laws.into_iter().map(|law| law.law).collect(),
        motion: solution,
    })
}

/// A fault of a machine that may be too close to the least inertia.
fn beside_least_inertia(task: &Task, fault: Fault) -> Fault {
    if task.own.varies() {
        return fault;
    }
    let given = task.own.function.constant;
    let least = digits_beyond(task.least_inertia_without_motor(), LEAST, true);
    let message = format!(
        "{}. (J0 = {given} kg.m2; without a motor it must exceed {least} kg.m2, and the cams need more harmonics the closer it comes)",
        fault.sentence()
    );
    fault.with_message(message)
}

/// The machine with finite series.
struct Finished<'a> {
    laws: Vec<Law>,
    machine: Machine<'a>,
    cams: Vec<Cam>,
    round: Round,
}

/// The laws with which the tools of the finished machine move to the tolerance. The direct effect of a finite law on its tool's
/// acceleration is known beforehand; its effect on the machine's inertia, and so on its speed, is found on its motion.
fn finish<'a>(task: &'a Task, solution: &Solution, driving: &Driving, options: Options) -> Result<Finished<'a>, Fault> {
    let with = |share: f64| -> Result<Finished<'a>, Fault> {
        let laws = laws::of(solution, &task.tools, share * options.tolerance, options.form)?;
        if let Some(found) = &solution.loaded {
            let of_laws: Vec<&MotionLaw> = laws.iter().map(|law| &law.law).collect();
            let (machine, cams, mut round) = on_loaded(task, found, &of_laws, solution.speed.order())?;
            let tools = round.tools.iter_mut().zip(&laws);
            tools.for_each(|(quality, law)| quality.deviation = quality.deviation.max(law.truncation));
            return Ok(Finished { laws, machine, cams, round });
        }
        let machine = Machine::along(task, ORDER.max(2 * task.order()).max(solution.speed.order()), solution);
        let cams: Vec<Cam> = pairs(task, &laws).map(|(tool, law)| machine.cam_of_law(tool, &law.law)).collect();
        let periodic = machine.periodic_motion(&cams, driving).ok_or_else(|| {
            Fault::new("no periodic motion of the machine with the finished cams was found near the wanted one; a larger J0 or breakdown slip helps".to_owned())
        })?;
        let mut round = machine.judge(&periodic, &cams);
        for ((tool, law), quality) in pairs(task, &laws).zip(&mut round.tools) {
            // If laws have corners, the error is known at the points of the mesh, and the law's between them.
            quality.deviation = match task.has_corners() {
                true => quality.deviation.max(law.truncation),
                false => machine.miss(&periodic, tool, &law.law, solution),
            };
        }
        Ok(Finished { laws, machine, cams, round })
    };
    let mut best = with(1.0)?;
    for share in SHARES {
        if best.round.tools.iter().all(|tool| tool.deviation <= options.tolerance) {
            break;
        }
        // If that many harmonics are not admissible, the error stays and is stated.
        let Ok(finer) = with(share) else { break };
        best = finer;
    }
    Ok(best)
}

/// The machine under loads with these laws of its cams, near the found motion.
fn on_loaded<'a>(
    task: &'a Task,
    (loaded, near): &(LoadedMachine, [f64; 3]),
    laws: &[&MotionLaw],
    order: usize,
) -> Result<(Machine<'a>, Vec<Cam>, Round), Fault> {
    let mut finished = loaded.clone();
    finished.kept.append(&mut finished.tools);
    let first = finished.kept.len() - laws.len();
    finished.kept[first..].iter_mut().zip(laws).for_each(|(tool, law)| tool.rigid.cam = (*law).clone());
    let course = finished.motion(task.driving.load, None, Some(*near))?;
    let (machine, periodic) = Machine::on(task, ORDER.max(2 * task.order()).max(order), &course);
    let cams: Vec<Cam> = task.tools.iter().zip(laws).map(|(tool, law)| machine.cam_of_law(tool, law)).collect();
    let round = machine.judge(&periodic, &cams);
    Ok((machine, cams, round))
}

/// The period of the fastest stable motion, to which a motor leads the finished machine from its start, if it is not the
/// compensated one.
fn other_motion(task: &Task, laws: &[Law], driving: &Driving, period: f64) -> Result<Option<f64>, Fault> {
    if !matches!(driving.motor, Motor::Kloss(_)) || task.loaded.is_some() {
        return Ok(None);
    }
    let tools = pairs(task, laws).map(|(tool, law)| tool.with_law(&law.law));
    let scene = Scene {
        loads: vec![],
        inertia: task.own.function.clone(),
        followers: task.own.followers.iter().cloned().chain(tools).collect(),
        motor: driving.motor,
        phi_start: 0.0,
        w_start: TAU / period,
        start: MachineStart::Given,
        solver: Settings::default(),
    };
    let motions = periodic_motions(&scene, driving.load)?;
    let fastest = motions.iter().find(|motion| motion.is_stable()).map(|motion| motion.period);
    Ok(fastest.filter(|other| (other / period - 1.0).abs() > SAME_PERIOD))
}

/// Each tool with its law.
fn pairs<'a>(task: &'a Task, laws: &'a [Law]) -> impl Iterator<Item = (&'a Tool, &'a Law)> {
    task.tools.iter().zip(laws)
}

fn cut((law, quality): (&Law, &Quality)) -> Cut {
    let (harmonics, points) = match &law.law {
        MotionLaw::Fourier(series) => (Some(series.order()), None),
        law => (None, Some(law.breakpoints().len())),
    };
    Cut { harmonics, points, truncation: rounded_up(quality.deviation) }
}

/// The next larger number of two digits.
fn rounded_up(value: f64) -> f64 {
    if value <= 0.0 || value.is_nan() {
        return value;
    }
    let digits = 1 - value.log10().floor() as i32;
    let scaled = (value * 10f64.powi(digits)).ceil();
    // Written and read, so that a power of ten leaves no rounding behind.
    format!("{scaled}e{}", -digits).parse().unwrap_or(value)
}

/// The reserve of a restriction; 0 if it is kept but for roundings.
fn reserve(one: &RestrictionReserve) -> f64 {
    if one.kept && one.reserve <= KEPT * one.value.abs() { 0.0 } else { one.reserve }
}

/// The largest deviation of a tool's acceleration.
fn deviation(round: &Round) -> f64 {
    round.tools.iter().map(|tool| tool.deviation).fold(0.0, f64::max)
}

/// A machine: its name, its speed relative to the design's, its motion.
type Row<'a> = (String, f64, Option<&'a Round>);

impl Compensation {
    /// ω (rad/s) of the compensated motion at the angle φ (rad).
    pub fn speed_at(&self, phi: f64) -> f64 {
        self.motion.speed_at(phi)
    }

    /// The rounds and the machine with the finished cams, each with its name.
    pub(super) fn machines(&self) -> impl Iterator<Item = (String, &Round)> {
        let rounds = self.rounds.iter().enumerate().map(|(i, round)| (format!("round {i}"), round));
        rounds.chain(std::iter::once(("finished".to_owned(), &self.finished)))
    }

    fn verdict(&self) -> Verdict {
        let mut verdict = Verdict::default();
        let after = self.cams.iter().map(|cut| cut.truncation).fold(0.0, f64::max);
        let before = self
            .rounds
            .first()
            .map_or(String::new(), |round| format!(" ({} with cams for uniform speed)", share(deviation(round))));
        let after = share(after);
        let told = format!("The acceleration of a tool deviates from the prescribed one by at most {after}{before}.");
        verdict.result(Level::Good, told);
        let (speed, period) = (range(self.speed, &RPM), time(self.period));
        let part = shown((self.speed[1] - self.speed[0]).abs() * self.period / TAU, &PERCENT);
        verdict.result(Level::Good, format!("The speed fluctuates by {part}, {speed}, in the period of {period}."));
        if let Some(period) = self.other_motion {
            verdict.result(Level::Mind, format!(
                "The motor brings the machine to a faster stable motion, T = {}; start.mode = steady_state begins there too.",
                time(period)
            ));
            verdict.advice("List the motions of the finished machine with `camdrive steady`. With another motor or J0 the compensated one may be the fastest.");
        }
        let others = self.other_speeds.iter().filter_map(|(part, round)| Some((deviation(round.as_ref()?), *part)));
        if let Some((worst, part)) = others.max_by(|a, b| a.0.total_cmp(&b.0)) {
            let (worst, part) = (share(worst), shown(part, &PERCENT));
            verdict.result(
                Level::Good,
                format!("At other speeds it deviates by up to {worst} (at {part} of this speed)."),
            );
            verdict.advice("Compensate again for another speed (`--period`).");
        }
        for one in self.transmission.iter().filter(|one| !one.is_usual()) {
            verdict.result(Level::Mind, one.sentence());
        }
        self.judge_restrictions(&mut verdict);
        verdict.certainty(format!(
            "The motion is resolved to {} of its mean speed. Tools and mechanisms are rigid.",
            number(self.resolution)
        ));
        verdict
    }

    /// Adds whether the restrictions are kept.
    fn judge_restrictions(&self, verdict: &mut Verdict) {
        let count = self.prescribed.len();
        if count == 0 {
            return;
        }
        let kept = |list: &[RestrictionReserve]| list.iter().filter(|one| one.kept).count();
        let all = kept(&self.finished.restrictions);
        verdict.result(Level::Good, format!("The finished cams keep {all} of the {count} restrictions."));
        for (one, prescribed) in self.finished.restrictions.iter().zip(&self.prescribed).filter(|(one, _)| !one.kept) {
            let (level, whose) = match prescribed.kept {
                true => (Level::Bad, "The tools miss"),
                false => (Level::Mind, "The prescribed motions themselves miss"),
            };
            let (miss, place) = (shown(-one.reserve, &self.unit(one)), shown(one.phase, &DEG));
            verdict.result(level, format!("{whose} `{}` by {miss} at ψ = {place}.", one.name));
        }
        for follower in &self.restrictions.unasked {
            verdict.certainty(format!("Follower {follower} is not checked: the task has no law for it."));
        }
    }

    /// The unit of the restricted quantity.
    fn unit(&self, one: &RestrictionReserve) -> Unit {
        let tool = self.numbers.iter().position(|number| one.tools.first().is_some_and(|tool| tool.0 == *number));
        let turning = tool.is_some_and(|tool| self.turning[tool]);
        let unit = UNITS[one.order.min(3)];
        Unit::of(&if turning { unit.replacen('m', "rad", 1) } else { unit.to_owned() })
    }

    /// Rounds, finished machine, other speeds.
    fn machines_table<'a>(&'a self) -> Table {
        let machines = self.machines().map(|(name, round)| (name, 1.0, Some(round)));
        let at = |part: f64| format!("at {} of the speed", shown(part, &PERCENT));
        let others = self.other_speeds.iter().map(|(part, round)| (at(*part), *part, round.as_ref()));
        let rows: Vec<Row> = machines.chain(others).collect();
        let mut table = Table::of("Machine, from cams for uniform speed (round 0) to the finished ones", &rows)
            .key("compensation")
            .column("machine", "machine", ONE, |row: &Row| &row.0)
            .hidden("speed_part", ONE, |row| row.1)
            .column("period", "T", MS, |row| row.2.map(|round| round.period))
            .digits(9)
            .column("speed", "speed", RPM, |row| row.2.map(|round| round.speed));
        for (j, number) in self.numbers.iter().enumerate() {
            let key = |what: &str| format!("tool{number}_{what}");
            let of = move |row: &Row<'a>| row.2.map(|round| &round.tools[j]);
            let heading = format!("tool {number}: deviation");
            table = table
                .column(key("deviation"), heading, PERCENT, |row| of(row).map(|tool| tool.deviation))
                .column(key("overshoot"), "overshoot", PERCENT, |row| of(row).map(|tool| tool.overshoot))
                .hidden(key("extra_harmonics"), ONE, |row| of(row).map(|tool| tool.extra_harmonics))
                .hidden(key("highest_extra"), ONE, |row| of(row)?.highest_extra);
        }
        table.into()
    }

    /// The restrictions of the tools: the reserve of the prescribed motions, with cams for uniform speed and of the finished
    /// machine.
    fn restrictions_table(&self) -> Table {
        let rows: Vec<(usize, &RestrictionReserve, f64)> =
            self.prescribed.iter().enumerate().map(|(i, one)| (i, one, self.unit(one).factor)).collect();
        let last = |row: &(usize, &RestrictionReserve, f64)| &self.finished.restrictions[row.0];
        let first = |row: &(usize, &RestrictionReserve, f64)| {
            self.rounds.first().map(|round| row.2 * reserve(&round.restrictions[row.0]))
        };
        Table::of("Restrictions", &rows)
            .column("restriction", "restriction", ONE, |row| format!("{} [{}]", row.1.name, self.unit(row.1).name))
            .column("prescribed", "reserve as prescribed", ONE, |row| row.2 * reserve(row.1))
            .column("uniform", "with cams for uniform speed", ONE, first)
            .column("finished", "finished cams", ONE, |row| row.2 * reserve(last(row)))
            .column("value", "value there", ONE, |row| row.2 * last(row).value)
            .column("phase", "at ψ", DEG, |row| last(row).phase)
            .column("kept", "kept", ONE, |row| last(row).kept)
            .into()
    }

    /// Rows of each machine with a quantity `of` its tools' motions, and of the prescribed ones.
    fn over_machines<'a>(
        &self,
        mut table: Rows<'a, (String, &'a Round, usize)>,
        of: fn(&Round, &Fourier, usize) -> f64,
    ) -> Table {
        for (j, number) in self.numbers.iter().enumerate() {
            let unit = Unit::of(if self.turning[j] { "rad/s2" } else { "m/s2" });
            table = table
                .hidden(format!("tool{number}"), unit.clone(), |row| of(row.1, &row.1.motions[j], row.2))
                .hidden(format!("tool{number}_prescribed"), unit, |row| of(row.1, &self.wanted[j], row.2));
        }
        table.into()
    }

    /// The report.
    pub fn report(&self) -> Report {
        let mut report = Report::new(&self.scene, "compensated cams");
        report.verdict = self.verdict();
        let cams: Vec<(&usize, &Cut)> = self.numbers.iter().zip(&self.cams).collect();
        let law = |cut: &Cut| match (cut.harmonics, cut.points) {
            (Some(harmonics), _) => counted(harmonics, "harmonic"),
            (None, points) => format!("table of {} points", points.unwrap_or_default()),
        };
        report.table(
            Table::of("Cams", &cams)
                .column("follower", "follower", ONE, |cam| *cam.0)
                .column("law", "law", ONE, |cam| law(cam.1))
                .column("deviation", "deviation of the acceleration", PERCENT, |cam| cam.1.truncation),
        );
        report.table(self.machines_table()).table(self.restrictions_table());
        report.lines("Mechanisms", self.transmission.iter().filter(|one| one.is_usual()).map(Transmission::sentence));
        let over = |count: usize| -> Vec<(String, &Round, usize)> {
            self.machines().flat_map(|(name, round)| (0..count).map(move |i| (name.clone(), round, i))).collect()
        };
        let points = over(POINTS + 1);
        let courses = Table::file("courses", &points)
            .hidden("machine", ONE, |row| &row.0)
            .hidden("phase", DEG, |row| phase(row.2))
            .hidden("time", MS, |row| phase(row.2) / row.1.mean_speed().abs())
            .hidden("speed", RPM, |row| row.1.speeds.at(phase(row.2)).0[0]);
        report.table(
            self.over_machines(courses, |round, series, i| round.mean_speed().powi(2) * series.at(phase(i)).0[2]),
        );
        let harmonics = over(self.machines().map(|(_, round)| round.speeds.order()).min().unwrap_or(0) + 1);
        let spectra = Table::file("spectra", &harmonics)
            .hidden("machine", ONE, |row| &row.0)
            .hidden("harmonic", ONE, |row| row.2)
            .hidden("speed_cosine", RPM, |row| row.1.speeds.a[row.2])
            .hidden("speed_sine", RPM, |row| row.1.speeds.b[row.2]);
        report.table(self.over_machines(spectra, Round::harmonic));
        for (key, diagram) in self.diagrams() {
            report.diagram(&key, diagram);
        }
        let least = self.least_inertia_without_motor;
        let least = least
            .map(|j| format!("Without a motor J0 would have to be at least {} kg·m².", digits_beyond(j, LEAST, true)));
        let factor = format!(
            "Near the end each round of the iteration (K. Kaltofen, HS-Bewegungen trotz veränderlicher Antriebsgeschwindigkeit, section 3) reduces the error by the factor {}. Newton's method finds the finished cams directly.",
            number(self.factor)
        );
        let motor = self.synchronous_speed.map(|speed| format!("Synchronous speed of the motor: {} rpm.", rpm(speed)));
        report.explain("How it is computed", [factor].into_iter().chain(least).chain(motor));
        report
    }
}
