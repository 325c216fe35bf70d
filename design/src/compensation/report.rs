//! What a compensation has found, as tables and diagrams.

use super::iteration::{Cam, Machine, Quality, Round, rounds};
use super::orbit::{Driving, Orbit};
use super::{Form, Law, Solution, Task, Tool};
use crate::plot::{Axis, Diagram, Series};
use crate::text::{self, Table, number};
use crate::transmission::{self, Transmission};
use camdrive::drives::Fault;
use camdrive::drives::rigid_machine::orbits::periodic_motions;
use camdrive::drives::rigid_machine::{Kloss, MachineStart, Motor, Scene};
use camdrive::drives::solver::Settings;
use camdrive::motion::MotionLaw;
use serde::Serialize;
use std::f64::consts::TAU;

/// The order of the mesh on which machines are judged, at least: four times what the motions of a loom's tools have.
const ORDER: usize = 96;

/// Points of a curve in a diagram.
const POINTS: usize = 720;

/// The speeds, relative to that of the design, at which the finished machine is looked at.
const OTHER_SPEEDS: [f64; 5] = [0.25, 0.5, 0.75, 1.1, 1.25];

/// Two periods are those of one motion when they agree to this part: the errors of the finite series are far smaller, and
/// different motions differ by far more.
const SAME_PERIOD: f64 = 1e-4;

/// Parts of the tolerance that the bound of a tool's own series is given where the machine as a whole exceeds it.
const SHARES: [f64; 3] = [0.5, 0.1, 0.01];

/// What is asked for beside the cams.
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
    /// The same at other speeds, relative to that of the design; None where it finds no periodic motion.
    pub other_speeds: Vec<(f64, Option<Round>)>,
    /// Where the mechanisms between cams and tools pass the force on worst.
    pub transmission: Vec<Transmission>,
    /// The numbers of the tools' followers in the scene.
    pub numbers: Vec<usize>,
    /// The motion over the time.
    #[serde(skip)]
    motion: Solution,
    /// The laws of the cams.
    #[serde(skip)]
    pub laws: Vec<MotionLaw>,
    /// For each tool whether its coordinate is an angle.
    #[serde(skip)]
    turning: Vec<bool>,
    #[serde(skip)]
    speeds: [Vec<[f64; 2]>; 2],
    #[serde(skip)]
    accelerations: Vec<[Vec<[f64; 2]>; 3]>,
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
/// Those of [`Task::solve`] and [`super::Solution::laws`].
pub fn study(scene: &str, task: &Task, options: Options) -> Result<Report, Fault> {
    let solution = task.solve()?;
    // The motor as the period demands it; from here on it is given.
    let mut driving = task.driving;
    if task.driving.motor != Motor::None {
        (driving.motor, driving.period) = (solution.orbit.motor, None);
    }
    let Finished { laws, machine, cams, orbit, round } =
        finish(task, &solution, &driving, options).map_err(|fault| beside_least_inertia(task, fault))?;
    let plain: Vec<Cam> =
        task.tools.iter().map(|tool| machine.cam_of_law(tool, &MotionLaw::Fourier(tool.motion.clone()))).collect();
    let before = machine.orbit(&plain, &driving);
    let course = |j: usize| {
        let tool = &task.tools[j];
        let wanted = |i: usize| {
            let psi = TAU * i as f64 / POINTS as f64;
            [psi, orbit.mean_speed.powi(2) * tool.at(psi)[2]]
        };
        let uncompensated = before.as_ref().map(|before| machine.course(before, &plain[j], POINTS));
        [
            (0..=POINTS).map(wanted).collect(),
            uncompensated.unwrap_or_default(),
            machine.course(&orbit, &cams[j], POINTS),
        ]
    };
    let other_speeds = OTHER_SPEEDS.map(|part| {
        let mut driving = driving;
        match &mut driving.motor {
            Motor::Kloss(Kloss { synchronous_speed, .. }) => *synchronous_speed *= part,
            _ => driving.period = driving.period.map(|period| period / part),
        }
        (part, machine.orbit(&cams, &driving).map(|orbit| machine.judge(&orbit, &cams)))
    });
    Ok(Report {
        scene: scene.to_owned(),
        period: solution.orbit.period(),
        speed: solution.range(),
        synchronous_speed: match solution.orbit.motor {
            Motor::Kloss(Kloss { synchronous_speed, .. }) => Some(synchronous_speed),
            _ => None,
        },
        least_inertia_without_motor: (!task.own.varies()).then(|| task.least_inertia_without_motor()),
        factor: solution.factor,
        resolution: solution.resolution,
        rounds: rounds(task, ORDER.max(solution.speed.order()), options.rounds),
        cams: laws.iter().zip(&round.tools).map(cut).collect(),
        finished: round,
        other_motion: other_motion(task, &laws, &driving, solution.orbit.period())?,
        transmission: pairs(task, &laws)
            .flat_map(|(tool, law)| transmission::of(tool.number, &tool.with_law(&law.law)))
            .collect(),
        numbers: task.tools.iter().map(|tool| tool.number).collect(),
        other_speeds: other_speeds.into(),
        speeds: [
            before.as_ref().map_or(Vec::new(), |before| machine.speeds(before, POINTS)),
            machine.speeds(&orbit, POINTS),
        ],
        accelerations: (0..task.tools.len()).map(course).collect(),
        turning: task.tools.iter().map(Tool::turns).collect(),
        laws: laws.into_iter().map(|law| law.law).collect(),
        motion: solution,
    })
}

/// A fault of a machine that may be too near to the least inertia.
fn beside_least_inertia(task: &Task, Fault(fault): Fault) -> Fault {
    if task.own.varies() {
        return Fault(fault);
    }
    let (given, least) = (task.own.function.constant, task.least_inertia_without_motor());
    Fault(format!(
        "{fault}. (J0 = {given} kg.m2; without motor it has to be above {least:.6} kg.m2, and the nearer to that the more harmonics the cams need)"
    ))
}

/// The machine with finite series.
struct Finished<'a> {
    laws: Vec<Law>,
    machine: Machine<'a>,
    cams: Vec<Cam>,
    orbit: Orbit,
    round: Round,
}

/// The laws with which the tools of the finished machine move to the tolerance. What a finite law does to its tool's
/// acceleration is known beforehand; what it does to the machine's inertia, and so to its speed, is found on its motion.
fn finish<'a>(task: &'a Task, solution: &Solution, driving: &Driving, options: Options) -> Result<Finished<'a>, Fault> {
    let with = |share: f64| -> Result<Finished<'a>, Fault> {
        let laws = solution.laws(&task.tools, share * options.tolerance, options.form)?;
        let machine = Machine::along(task, ORDER.max(2 * task.order()).max(solution.speed.order()), solution);
        let cams: Vec<Cam> = pairs(task, &laws).map(|(tool, law)| machine.cam_of_law(tool, &law.law)).collect();
        let orbit = machine.orbit(&cams, driving).ok_or_else(|| {
            Fault("no periodic motion of the machine with the finished cams was found near the wanted one; a larger J0 or breakdown slip helps".to_owned())
        })?;
        let mut round = machine.judge(&orbit, &cams);
        for ((tool, law), quality) in pairs(task, &laws).zip(&mut round.tools) {
            quality.deviation = machine.miss(&orbit, tool, &law.law, solution);
        }
        Ok(Finished { laws, machine, cams, orbit, round })
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

/// A motor that starts the finished machine leads it to its fastest stable motion: the period of that, where it is not the
/// compensated one.
fn other_motion(task: &Task, laws: &[Law], driving: &Driving, period: f64) -> Result<Option<f64>, Fault> {
    if !matches!(driving.motor, Motor::Kloss(_)) {
        return Ok(None);
    }
    let tools = pairs(task, laws).map(|(tool, law)| tool.with_law(&law.law));
    let scene = Scene {
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

fn percent(value: f64) -> String {
    format!("{} %", number(100.0 * value))
}

/// A row of figures of a machine.
fn row(name: String, round: Option<&Round>, tools: usize) -> Vec<String> {
    let Some(round) = round else {
        return std::iter::once(name)
            .chain(vec!["none found".to_owned()])
            .chain(vec![String::new(); 2 + 3 * tools])
            .collect();
    };
    let mut cells =
        vec![name, format!("{:.12}", round.period), format!("{:.4}", round.speed[0]), format!("{:.4}", round.speed[1])];
    for tool in &round.tools {
        let extra = match tool.highest_extra {
            Some(highest) => format!("{} (to {highest})", tool.extra_harmonics),
            None => "0".to_owned(),
        };
        cells.extend([percent(tool.overshoot), percent(tool.deviation), extra]);
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
        let tools = self.finished.tools.len();
        let mut head: Vec<String> = ["machine", "T [s]", "least w [rad/s]", "largest w"].map(str::to_owned).into();
        for j in &self.numbers {
            head.extend([format!("tool {j}: overshoot"), "deviation".to_owned(), "extra harmonics".to_owned()]);
        }
        let mut rows: Vec<Vec<String>> =
            self.rounds.iter().enumerate().map(|(i, round)| row(format!("round {i}"), Some(round), tools)).collect();
        rows.push(row("finished cams".to_owned(), Some(&self.finished), tools));
        for (part, round) in &self.other_speeds {
            rows.push(row(format!("at {} of the speed", percent(*part)), round.as_ref(), tools));
        }
        Table { head, rows }
    }

    /// What was found, in sentences.
    pub fn about(&self) -> Vec<String> {
        let mut lines = vec![format!(
            "Period T = {:.15} s, w = {:.6} … {:.6} rad/s (resolved to {} of its mean).",
            self.period,
            self.speed[0],
            self.speed[1],
            number(self.resolution)
        )];
        if let Some(speed) = self.synchronous_speed {
            lines.push(format!("Synchronous speed of the motor {speed:.12} rad/s ({:.8} rpm).", speed * 60.0 / TAU));
        }
        if let Some(least) = self.least_inertia_without_motor {
            lines.push(format!("Without motor J0 would have to be at least {least:.6} kg.m2."));
        }
        lines.push(format!(
            "Each round of the iteration reduces the error by the factor {:.4} in the end.",
            self.factor
        ));
        if let Some(period) = self.other_motion {
            lines.push(format!(
                "Mind: the finished machine has several periodic motions. The compensated one is not the fastest stable one, T = {period:.9} s, to which the motor brings the machine and with which start.mode = steady_state begins; `camdrive steady` lists them."
            ));
        }
        for (j, cut) in self.numbers.iter().zip(&self.cams) {
            let law = match (cut.harmonics, cut.points) {
                (Some(harmonics), _) => format!("{harmonics} harmonics"),
                (None, points) => format!("a table of {} points", points.unwrap_or_default()),
            };
            lines.push(format!(
                "Cam {j}: {law}; the acceleration differs from the prescribed one by at most {} of its largest value.",
                number(cut.truncation)
            ));
        }
        lines.extend(self.transmission.iter().map(Transmission::sentence));
        lines
    }

    /// The numbers of the table as CSV, in SI units.
    ///
    /// # Errors
    /// None in practice: the writer fills memory.
    pub fn csv(&self) -> Result<String, Fault> {
        let head = "machine,speed_part,period_s,least_speed_rad_s,largest_speed_rad_s,tool,overshoot,deviation,\
                    extra_harmonics,highest_extra";
        let mut rows = Vec::new();
        let rounds = self.rounds.iter().enumerate().map(|(i, round)| (format!("round {i}"), 1.0, Some(round)));
        let finished = std::iter::once(("finished".to_owned(), 1.0, Some(&self.finished)));
        let others = self.other_speeds.iter().map(|(part, round)| ("finished".to_owned(), *part, round.as_ref()));
        for (name, part, round) in rounds.chain(finished).chain(others) {
            let Some(round) = round else { continue };
            for (j, tool) in self.numbers.iter().zip(&round.tools) {
                rows.push(vec![
                    name.clone(),
                    part.to_string(),
                    round.period.to_string(),
                    round.speed[0].to_string(),
                    round.speed[1].to_string(),
                    j.to_string(),
                    tool.overshoot.to_string(),
                    tool.deviation.to_string(),
                    tool.extra_harmonics.to_string(),
                    tool.highest_extra.map_or(String::new(), |highest| highest.to_string()),
                ]);
            }
        }
        text::csv(head, rows)
    }

    /// ω over the angle, before and after.
    pub fn speed_diagram(&self) -> Diagram {
        let [before, after] = &self.speeds;
        let curve =
            |name: &str, points: &[[f64; 2]]| Series::line(name, points.iter().map(|[phi, w]| [phi.to_degrees(), *w]));
        let series = vec![curve("cams for uniform speed", before), curve("compensated cams", after)];
        let axes = [Axis::angular("Angle of the main shaft [°]").between(0.0, 360.0), Axis::linear("Speed [rad/s]")];
        Diagram::new(format!("Speed of {} over a turn", self.scene), axes, series, Vec::new())
    }

    /// The acceleration of tool `j` over time, as wanted, before and after.
    pub fn acceleration_diagram(&self, j: usize) -> Diagram {
        let names = ["as prescribed", "cams for uniform speed", "compensated cams"];
        let curves = self.accelerations[j].iter().zip(names);
        let series = curves.map(|(points, name)| Series::line(name, points.iter().map(|[psi, a]| [psi / TAU, *a])));
        let label = match self.turning[j] {
            true => "Angular acceleration of the tool [rad/s²]",
            false => "Acceleration of the tool [m/s²]",
        };
        let title = format!("Acceleration of tool {} of {} over a period", self.numbers[j], self.scene);
        let axes = [Axis::linear("Time per period [1]").between(0.0, 1.0), Axis::linear(label)];
        Diagram::new(title, axes, series.collect(), Vec::new())
    }
}
