//! The result of a compensation, as tables and diagrams.

use super::iteration::{Cam, Machine, Quality, Round, rounds};
use super::loaded::Loaded;
use super::periodic_motion::Driving;
use super::restrictions::{Kept, Restrictions};
use super::{Form, Law, Solution, Task, Tool, laws};
use crate::periodic_motions::periodic_motions;
use crate::synthesis::{KEPT, UNITS};
use crate::text::{self, Table, counted, number};
use crate::transmission::{self, Transmission};
use crate::{Progress, work};
use camdrive::drives::Fault;
use camdrive::drives::rigid_machine::{Kloss, MachineStart, Motor, Scene};
use camdrive::drives::settings::Settings;
use camdrive::motion::{Fourier, MotionLaw};
use serde::Serialize;
use std::f64::consts::TAU;

/// The order of the mesh on which machines are judged, at least: four times what the motions of a loom's tools have.
const ORDER: usize = 96;

/// The speeds, relative to that of the design, at which the finished machine is looked at.
const OTHER_SPEEDS: [f64; 5] = [0.25, 0.5, 0.75, 1.1, 1.25];

/// Two periods are those of one motion when they agree to this part: the errors of the finite series are far smaller, and
/// different motions differ by far more.
const SAME_PERIOD: f64 = 1e-4;

/// Parts of the tolerance that the bound of a tool's own series is given where the machine as a whole exceeds it.
const SHARES: [f64; 3] = [0.5, 0.1, 0.01];

/// Options of the compensation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// The error of the accelerations that the finite series or tables of the cams may cause, relative to the largest.
    pub tolerance: f64,
    /// Series or tables.
    pub form: Form,
    /// Rounds of the source's iteration beside round 0.
    pub rounds: usize,
}

/// A compensated machine.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// The name of the scene.
    pub scene: String,
    /// T (s).
    pub period: f64,
    /// The least and the largest ω (rad/s).
    pub speed: [f64; 2],
    /// w_s (rad/s) of the motor, where there is one.
    pub synchronous_speed: Option<f64>,
    /// The least J0 (kg·m²) without motor; None where other parts vary with the angle.
    pub least_inertia_without_motor: Option<f64>,
    /// ρ.
    pub factor: f64,
    /// The last harmonics of the motion, relative to its mean.
    pub resolution: f64,
    /// The rounds of the source's iteration; round 0 is the machine with cams cut for uniform speed.
    pub rounds: Vec<Round>,
    /// For each tool what the law of its cam consists of, and the error that this leaves.
    pub cams: Vec<Cut>,
    /// The machine with the finished cams.
    pub finished: Round,
    /// T (s) of the fastest stable motion with the finished cams, where that is another one than the compensated.
    pub other_motion: Option<f64>,
    /// The finished machine at other speeds, relative to that of the design; None where it finds no periodic motion.
    pub other_speeds: Vec<(f64, Option<Round>)>,
    /// Where the mechanisms between cams and tools pass the force on worst.
    pub transmission: Vec<Transmission>,
    /// The numbers of the tools' followers in the scene.
    pub numbers: Vec<usize>,
    /// How well the prescribed motions themselves keep what is asked of the tools.
    pub prescribed: Vec<Kept>,
    /// The motion over the time.
    #[serde(skip)]
    motion: Solution,
    /// The laws of the cams.
    #[serde(skip)]
    pub laws: Vec<MotionLaw>,
    /// For each tool whether its coordinate is an angle.
    #[serde(skip)]
    pub(super) turning: Vec<bool>,
    /// y(ψ) of the tools as prescribed.
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
    /// The largest error of the tool's acceleration in the finished machine, relative to the largest acceleration: that of its
    /// own law and, by the speed of the machine, of all others; rounded up to two digits.
    pub truncation: f64,
}

/// Compensates a machine and looks at the result.
///
/// # Errors
/// Those of [`Task::solve`] and [`super::Solution::laws`], and a study that takes more work than one may.
pub fn study(
    scene: &str,
    task: &Task,
    options: Options,
    progress: &(dyn Fn(Progress) + Sync),
) -> Result<Report, Fault> {
    let hint = "a larger J0 or breakdown slip helps, a motor without `lag`, motions that are series instead of cycles, or a larger \
                --tolerance";
    work::within(work::BUDGET, hint, progress, |tell| looked_at(scene, task, options, tell)).map_err(Fault::new)?
}

/// See [`study`].
fn looked_at(scene: &str, task: &Task, options: Options, progress: &dyn Fn(Progress)) -> Result<Report, Fault> {
    let solution = task.solve_with(progress)?;
    let stage = |stage| progress(Progress { done: 0, total: 1, stage });
    stage("laws");
    // The motor as the period demands it; from here on it is given.
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
    Ok(Report {
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
            // That with cams for uniform speed.
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

/// A fault of a machine that may be too near to the least inertia.
fn beside_least_inertia(task: &Task, fault: Fault) -> Fault {
    if task.own.varies() {
        return fault;
    }
    let (given, least) = (task.own.function.constant, task.least_inertia_without_motor());
    Fault::new(format!(
        "{fault}. (J0 = {given} kg.m2; without a motor it must be above {least:.6} kg.m2, and the closer to that, the more harmonics the cams need)"
    ))
}

/// The machine with finite series.
struct Finished<'a> {
    laws: Vec<Law>,
    machine: Machine<'a>,
    cams: Vec<Cam>,
    round: Round,
}

/// The laws with which the tools of the finished machine move to the tolerance. What a finite law does to its tool's
/// acceleration is known beforehand; what it does to the machine's inertia, and so to its speed, is found on its motion.
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
            // Where laws have corners, the error is known at the points of the mesh, and of the law between them.
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
        // Where that many harmonics are not admissible the error stays, and is stated.
        let Ok(finer) = with(share) else { break };
        best = finer;
    }
    Ok(best)
}

/// The machine under loads with these laws of its cams, near the motion that was found.
fn on_loaded<'a>(
    task: &'a Task,
    (loaded, near): &(Loaded, [f64; 3]),
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

/// A motor that starts the finished machine leads it to its fastest stable motion: the period of that, where it is not the
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
    // Written and read, lest a power of ten leave a rounding behind.
    format!("{scaled}e{}", -digits).parse().unwrap_or(value)
}

/// The reserve as people read it: what is kept but for roundings has none.
fn shown(one: &Kept) -> f64 {
    if one.kept && one.reserve <= KEPT * one.value.abs() { 0.0 } else { one.reserve }
}

fn percent(value: f64) -> String {
    format!("{} %", number(100.0 * value))
}

/// A row of figures of a machine.
fn row(name: String, round: Option<&Round>, of_series: bool, columns: usize) -> Vec<String> {
    let Some(round) = round else {
        let mut cells = vec![name, "none found".to_owned()];
        cells.resize(columns, String::new());
        return cells;
    };
    let [least, largest] = round.speed.map(|w| format!("{:.3}", w * 60.0 / TAU));
    let mut cells = vec![name, format!("{:.12}", round.period), least, largest];
    for tool in &round.tools {
        cells.extend([percent(tool.overshoot), percent(tool.deviation)]);
        if of_series {
            let highest = tool.highest_extra.map_or(String::new(), |highest| format!(" (to {highest})"));
            cells.push(format!("{}{highest}", tool.extra_harmonics));
        }
    }
    cells
}

impl Report {
    /// ω (rad/s) of the compensated motion at the angle φ (rad).
    pub fn speed_at(&self, phi: f64) -> f64 {
        self.motion.speed_at(phi)
    }

    /// The table of the machines: rounds, finished, other speeds.
    pub fn table(&self) -> Table {
        // A motion that is no series has no harmonics beyond its own.
        let of_series = self.machines().any(|(_, round)| round.tools.iter().any(|tool| tool.highest_extra.is_some()));
        let mut head: Vec<String> = ["machine", "T [s]", "least w [rpm]", "largest w"].map(str::to_owned).into();
        for j in &self.numbers {
            let columns = ["overshoot", "deviation", "extra harmonics"].into_iter().take(2 + usize::from(of_series));
            head.extend(columns.map(|column| format!("tool {j}: {column}")));
        }
        let named = |name: String| if name == "finished" { "finished cams".to_owned() } else { name };
        let machines = self.machines().map(|(name, round)| row(named(name), Some(round), of_series, head.len()));
        let mut rows: Vec<Vec<String>> = machines.collect();
        for (part, round) in &self.other_speeds {
            rows.push(row(format!("at {} of the speed", percent(*part)), round.as_ref(), of_series, head.len()));
        }
        Table { head, rows }
    }

    /// The result in sentences.
    pub fn about(&self) -> Vec<String> {
        let mut lines = vec![format!(
            "Period T = {:.15} s, w from {:.5} to {:.5} rpm (resolved to {} of its mean).",
            self.period,
            self.speed[0] * 60.0 / TAU,
            self.speed[1] * 60.0 / TAU,
            number(self.resolution)
        )];
        if let Some(speed) = self.synchronous_speed {
            lines.push(format!("Synchronous speed of the motor {speed:.12} rad/s ({:.8} rpm).", speed * 60.0 / TAU));
        }
        if let Some(least) = self.least_inertia_without_motor {
            lines.push(format!("Without a motor J0 would have to be at least {least:.6} kg.m2."));
        }
        lines.push(format!(
            "In the end each round of the iteration reduces the error by the factor {:.4}.",
            self.factor
        ));
        if let Some(period) = self.other_motion {
            lines.push(format!(
                "Note: the finished machine has several periodic motions. The compensated one is not the fastest stable one, T = {period:.9} s, to which the motor brings the machine and with which start.mode = steady_state begins; `camdrive steady` lists them."
            ));
        }
        for (j, cut) in self.numbers.iter().zip(&self.cams) {
            let law = match (cut.harmonics, cut.points) {
                (Some(harmonics), _) => counted(harmonics, "harmonic"),
                (None, points) => format!("a table of {} points", points.unwrap_or_default()),
            };
            lines.push(format!(
                "Cam {j}: {law}; the acceleration differs from the prescribed one by at most {} of its largest value.",
                number(cut.truncation)
            ));
        }
        lines.extend(self.transmission.iter().map(Transmission::sentence));
        lines.extend(self.on_restrictions());
        lines
    }

    /// The rounds and the machine with the finished cams, each with its name.
    pub(super) fn machines(&self) -> impl Iterator<Item = (String, &Round)> {
        let rounds = self.rounds.iter().enumerate().map(|(i, round)| (format!("round {i}"), round));
        rounds.chain(std::iter::once(("finished".to_owned(), &self.finished)))
    }

    /// The unit of what is restricted.
    fn unit(&self, one: &Kept) -> String {
        let tool = self.numbers.iter().position(|number| one.tools.first().is_some_and(|tool| tool.0 == *number));
        UNITS[one.order.min(3)].replace('m', if tool.is_some_and(|tool| self.turning[tool]) { "rad" } else { "m" })
    }

    /// How far the restrictions are kept, in sentences.
    fn on_restrictions(&self) -> Vec<String> {
        let count = self.prescribed.len();
        if count == 0 {
            return Vec::new();
        }
        let kept = |list: &[Kept]| list.iter().filter(|one| one.kept).count();
        let unasked = self.restrictions.unasked.iter();
        let unasked = unasked.map(|j| format!("Note: the task has no law for follower {j}, and it is not checked."));
        let plain =
            self.rounds.first().map(|round| format!("; cams for uniform speed keep {}", kept(&round.restrictions)));
        let (all, plain) = (kept(&self.finished.restrictions), plain.unwrap_or_default());
        let mut lines = vec![format!("The finished cams keep {all} of the {count} restrictions{plain}.")];
        lines.extend(unasked);
        let pairs = self.finished.restrictions.iter().zip(&self.prescribed);
        lines.extend(pairs.filter(|(one, _)| !one.kept).map(|(one, prescribed)| {
            let whose = if prescribed.kept { "the tools miss" } else { "the prescribed motions themselves miss" };
            let (miss, place) = (number(-one.reserve), number(one.phase.to_degrees()));
            format!("Note: {whose} `{}` by {miss} {} at {place} deg.", one.name, self.unit(one))
        }));
        let first = count - self.restrictions.clearances().len();
        lines.extend(self.finished.restrictions[first..].iter().map(|one| {
            let [least, reserve, place] = [one.value, shown(one), one.phase.to_degrees()].map(number);
            format!("Least {}: {least} m at {place} deg, reserve {reserve} m.", one.name)
        }));
        lines
    }

    /// The table of what the tools have to keep: the reserve of the prescribed motion, of each round and of the finished
    /// machine; None where nothing is asked.
    pub fn restrictions(&self) -> Option<Table> {
        let mut head = vec!["restriction".to_owned(), "reserve as prescribed".to_owned()];
        head.extend(self.machines().map(|(name, _)| name));
        head.extend(["value there", "at [deg]"].map(str::to_owned));
        let row = |(i, prescribed): (usize, &Kept)| {
            let reserves = self.machines().map(|(_, round)| number(shown(&round.restrictions[i])));
            let last = &self.finished.restrictions[i];
            let place = [number(last.value), number(last.phase.to_degrees())];
            let name = format!("{} [{}]", prescribed.name, self.unit(prescribed));
            [name, number(shown(prescribed))].into_iter().chain(reserves).chain(place).collect()
        };
        let rows: Vec<Vec<String>> = self.prescribed.iter().enumerate().map(row).collect();
        (!rows.is_empty()).then_some(Table { head, rows })
    }

    /// The numbers of the table as CSV, in SI units.
    ///
    /// # Errors
    /// None in practice: the writer fills memory.
    pub fn csv(&self) -> Result<String, Fault> {
        let head = "machine,speed_part,period_s,least_speed_rad_s,largest_speed_rad_s,tool,overshoot,deviation,\
                    extra_harmonics,highest_extra";
        let mut rows = Vec::new();
        let machines = self.machines().map(|(name, round)| (name, 1.0, Some(round)));
        let others = self.other_speeds.iter().map(|(part, round)| ("finished".to_owned(), *part, round.as_ref()));
        for (name, part, round) in machines.chain(others) {
            let Some(round) = round else { continue };
            for (j, tool) in self.numbers.iter().zip(&round.tools) {
                rows.push((name.clone(), part, round.period, round.speed, j, tool));
            }
        }
        text::csv(head, rows)
    }
}
