//! `camdrive steady SCENE`

use super::measured::Measured;
use super::output::Bar;
use super::{Failure, Format, NO_MOTION, driving, failure, files, read};
use crate::scene::Resolved;
use crate::scene::forces::machine;
use camdrive::drives::Fault;
use camdrive::drives::drive_train;
use camdrive::drives::rigid_machine::{Inertia, Kloss, Motor, Scene};
use camdrive_design::forces::Machine;
use camdrive_design::forces::report::LiftOff;
use camdrive_design::periodic_motions::{Motions, PeriodicMotion, all_motions, free_motion, periodic_motions, range};
use camdrive_design::periodic_train::{self, Turn};
use camdrive_design::plot::{Axis, Diagram, Series};
use camdrive_design::resource;
use camdrive_design::text::{self, Table, number};
use camdrive_design::transmission::{self, Transmission};
use serde_json::{Value, json};
use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::path::PathBuf;
use std::process::ExitCode;

/// Finds all periodic solutions of a machine.
///
/// With a motor there may be several, stable and unstable ones, or none: then it stalls. The multiplier is the factor by which a
/// small disturbance grows in a turn. For comparison the motion of the machine without torques with
/// the same period; without a motor it is all there is, and --period is needed. With a motor --period finds the
/// synchronous speed with which the fastest stable motion has that period. The exit code is 3 where there is no periodic
/// motion.
///
/// Of a DriveTrain the motion near the speed of its motor or its start: all multipliers, torque and power of the motor, what forces,
/// deformations and impacts its followers have, and from which speed on they leave their cams.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  camdrive steady examples/rapier_loom/scene.toml
  camdrive steady examples/rapier_loom/scene.toml --period \"120 ms\"
  camdrive steady examples/rapier_loom/scene.toml --load \"40 N.m\" --report study/")]
pub struct Args {
    /// Scene file (TOML) of a RigidMachine or a DriveTrain
    scene: PathBuf,
    /// Prescribed period, "120 ms" or in s
    #[arg(long, value_name = "TIME")]
    period: Option<String>,
    /// Constant load torque, "30 N.m"; positive brakes
    #[arg(long, value_name = "TORQUE", default_value = "0", allow_hyphen_values = true)]
    load: String,
    /// Folder for the speed over the turn: NAME.steady.csv and NAME.steady.svg
    #[arg(long, value_name = "FOLDER")]
    report: Option<PathBuf>,
    #[command(flatten)]
    measured: Measured,
    #[command(flatten)]
    format: Format,
}

/// The synchronous speed is found when it yields the period to this part.
const FOUND: f64 = 1e-13;

/// Steps of the secant method; the period is nearly inversely proportional to the speed, so that a handful suffices.
const STEPS: usize = 40;

pub fn run(args: &Args) -> Result<ExitCode, Failure> {
    args.measured.need(args.report.as_ref())?;
    if let Some(folder) = &args.report {
        files::no_file(folder, "--report")?;
    }
    let place = args.scene.display();
    let train = read(&args.scene)?;
    if let resource::Scene::DriveTrain(scene) = &train.scene {
        return of_train(args, &train, scene);
    }
    let (resolved, mut scene) = driving::machine(&args.scene, "steady")?;
    let (load, period) = driving::load(&place.to_string(), &scene.motor, &args.load, args.period.as_ref())?;
    let fault = |fault: Fault| failure(format!("{place}: {fault}"));
    let mut synchronous = None;
    let (Motions { found: motions, lost }, free) = match (scene.motor, period) {
        (Motor::Input | Motor::None, period) => {
            (Motions { found: Vec::new(), lost: Vec::new() }, period.map(|period| (period, 1.0)))
        }
        (Motor::Kloss(_), period) => {
            let motions = Bar::beside(&resolved.name, |_| {
                if let Some(period) = period {
                    let speed = synchronous_speed(&mut scene, load, period).map_err(Fault::new)?;
                    synchronous = Some((period, speed));
                }
                all_motions(&scene, load)
            })
            .map_err(fault)?;
            let free = motions
                .found
                .iter()
                .find(|motion| motion.is_stable())
                .map(|motion| (motion.period, motion.course.first().map_or(1.0, |[_, w]| w.signum())));
            (motions, free)
        }
    };
    let inertia = Inertia::new(scene.inertia.clone(), scene.followers.clone());
    let free = free.map(|(period, sense)| (period, free_motion(&inertia, period, sense)));
    let followers = inertia.followers.iter().enumerate();
    let mechanisms = followers.flat_map(|(j, follower)| transmission::of(j + 1, follower)).collect();
    let verdict = verdict(&scene, &motions, load);
    let (inputs, name) = (resolved.files, resolved.name);
    found(args, &inputs, Found { name, load, synchronous, verdict, motions, lost, free, mechanisms, train: None })
}

/// The periodic motion of a train.
fn of_train(args: &Args, resolved: &Resolved, scene: &drive_train::Scene) -> Result<ExitCode, Failure> {
    let place = args.scene.display();
    if args.period.is_some() || args.load != "0" {
        return Err(failure(format!(
            "{place}: --load and --period are for a machine without elastic followers and loads\n  = hint: write the load as `machine.load.torque` into the scene, and choose the speed by its motor"
        )));
    }
    let turn = Bar::beside(&resolved.name, |_| periodic_train::of(scene));
    let mut turn = turn.map_err(|fault| failure(format!("{place}: {fault}")))?;
    let motions = vec![std::mem::take(&mut turn.motion)];
    let verdict = format!("The periodic motion is {}.", if motions[0].is_stable() { "stable" } else { "unstable" });
    let lift_offs = machine(resolved).and_then(Machine::lift_offs).unwrap_or_default();
    let (train, inputs, name) = (Some((turn, lift_offs)), resolved.files.clone(), resolved.name.clone());
    let (lost, mechanisms) = (Vec::new(), Vec::new());
    found(
        args,
        &inputs,
        Found { name, load: 0.0, synchronous: None, verdict, motions, lost, free: None, mechanisms, train },
    )
}

/// Tells and writes what was found.
fn found(args: &Args, inputs: &[PathBuf], found: Found) -> Result<ExitCode, Failure> {
    let mut written = String::new();
    if let Some(folder) = &args.report {
        let title = format!("Periodic motions of {}", found.name);
        let (motions, free) = (&found.motions, found.free.as_ref());
        let mut diagram = diagram(title, motions, free);
        let courses = args.measured.lay_over([("steady", &mut diagram)])?;
        let parts = [("steady.csv", csv(motions, free)), ("steady.svg", Ok(diagram.svg()))];
        let parts = files::report(folder, &found.name, parts)?;
        written = format!("\n{}", files::write(&parts, &[inputs, &courses].concat())?);
    }
    args.format.print(|width| found.text(width) + &written, || text::json(&found.data()))?;
    Ok(if found.motions.is_empty() && found.free.is_none() { ExitCode::from(NO_MOTION) } else { ExitCode::SUCCESS })
}

/// The result.
struct Found {
    name: String,
    /// (N·m).
    load: f64,
    /// The period asked for (s) and the synchronous speed that yields it (rad/s).
    synchronous: Option<(f64, f64)>,
    verdict: String,
    motions: Vec<PeriodicMotion>,
    /// See [`Motions::lost`].
    lost: Vec<f64>,
    free: Option<Free>,
    mechanisms: Vec<Transmission>,
    /// Of a train, with the speeds at which its followers leave their cams.
    train: Option<(Turn, Vec<LiftOff>)>,
}

impl Found {
    fn text(&self, width: usize) -> String {
        let mut out = format!("{}\n", self.name);
        if let Some((period, speed)) = self.synchronous {
            let rpm = speed * 60.0 / TAU;
            let _ =
                writeln!(out, "The period of {period} s needs the synchronous speed {speed:.14} rad/s ({rpm:.9} rpm).");
        }
        let _ = writeln!(out, "{}\n", self.verdict);
        for period in &self.lost {
            let _ = writeln!(
                out,
                "Note: without the lag of the motor's torque there would be one more motion, T = {period:.9} s. With the lag none was found near it: there is none, or disturbances grow too fast to follow it around a turn.\n"
            );
        }
        if !self.motions.is_empty() || self.free.is_some() {
            out += &table(&self.motions, self.free.as_ref()).text(width);
        }
        for mechanism in &self.mechanisms {
            let _ = writeln!(out, "{}", mechanism.sentence());
        }
        if let Some((turn, lift_offs)) = &self.train {
            out += &turn.text(width);
            lift_offs.iter().for_each(|of| out += &(of.text() + "\n"));
        }
        out
    }

    fn data(&self) -> Value {
        let speeds = |period: f64, course: &[[f64; 2]]| {
            let [least, largest] = range(course);
            json!({ "period": period, "mean_speed": (TAU / period).copysign(largest + least), "least_speed": least, "largest_speed": largest })
        };
        let motion = |motion: &PeriodicMotion| {
            let mut data = speeds(motion.period, &motion.course);
            data["stable"] = motion.is_stable().into();
            data["growth"] = motion.growth.into();
            data["energy"] = motion.energy.into();
            data["torque"] = motion.torque.into();
            data
        };
        let (turn, lift_offs) = self.train.as_ref().map(|(turn, list)| (turn, list)).unzip();
        json!({
            "train": turn,
            "lift_offs": lift_offs,
            "name": self.name,
            "load": self.load,
            "synchronous_speed": self.synchronous.map(|(_, speed)| speed),
            "verdict": self.verdict,
            "motions": self.motions.iter().map(motion).collect::<Vec<Value>>(),
            "lost_periods": self.lost,
            "without_torques": self.free.as_ref().map(|(period, course)| speeds(*period, course)),
            "mechanisms": self.mechanisms,
        })
    }
}

/// The verdict on the motions.
fn verdict(scene: &Scene, motions: &[PeriodicMotion], load: f64) -> String {
    let stable = motions.iter().filter(|motion| motion.is_stable()).count();
    match (scene.motor, motions.len(), stable) {
        (Motor::Kloss(Kloss { breakdown_torque, synchronous_speed, .. }), 0, _) => format!(
            "No periodic motion was found against the load of {load} N.m: the motor (breakdown torque {breakdown_torque} N.m) {}.",
            if load * synchronous_speed >= 0.0 { "stalls" } else { "runs away" }
        ),
        (Motor::Kloss(_), 1, 0) => "One periodic motion, unstable: the machine stalls or runs away.".to_owned(),
        (Motor::Kloss(_), n, 0) => {
            format!("{n} periodic motions, none of them stable: the machine stalls or runs away.")
        }
        (Motor::Kloss(_), 1, 1) => "One periodic motion, stable.".to_owned(),
        (Motor::Kloss(_), n, s) => format!(
            "{n} periodic motions, {s} of them stable; `start.mode` = steady_state begins with the fastest stable one."
        ),
        _ => "Without a motor any period is possible; the motion with the prescribed one:".to_owned(),
    }
}

/// The motor's synchronous speed with which the fastest stable motion has this period.
fn synchronous_speed(scene: &mut Scene, load: f64, period: f64) -> Result<f64, String> {
    let Motor::Kloss(Kloss { synchronous_speed: given, .. }) = scene.motor else { return Err(String::new()) };
    let mut measure = |speed: f64| -> Result<f64, String> {
        if let Motor::Kloss(Kloss { synchronous_speed, .. }) = &mut scene.motor {
            *synchronous_speed = speed;
        }
        let motions = periodic_motions(scene, load).map_err(|fault| fault.to_string())?;
        let fastest = motions.iter().find(|motion| motion.is_stable());
        let motion = fastest.ok_or_else(|| {
            format!("with a synchronous speed of {} rpm there is no stable periodic motion against the load of {load} N.m: the motor stalls", text::rpm(speed))
        })?;
        Ok(motion.period)
    };
    // ln T over ln w_s is nearly straight.
    let mut speeds = [given, given * measure(given)? / period];
    let mut misses = [(measure(given)? / period).ln(), (measure(speeds[1])? / period).ln()];
    for _ in 0..STEPS {
        if misses[1].abs() <= FOUND || misses[0] == misses[1] {
            break;
        }
        let rise = (misses[1] - misses[0]) / (speeds[1] / speeds[0]).ln();
        let next = speeds[1] * (-misses[1] / rise).clamp(-1.0, 1.0).exp();
        if next == speeds[1] {
            break;
        }
        (speeds, misses) = ([speeds[1], next], [misses[1], (measure(next)? / period).ln()]);
    }
    if misses[1].abs() > 1e3 * FOUND {
        return Err(format!(
            "no synchronous speed yields the period of {period} s; the nearest period found is {} s",
            period * misses[1].exp()
        ));
    }
    Ok(speeds[1])
}

/// Name of the motion of a machine without torques.
const FREE: &str = "without torques";

type Free = (f64, Vec<[f64; 2]>);

fn name(i: usize, motion: &PeriodicMotion) -> String {
    format!("{} ({})", i + 1, if motion.is_stable() { "stable" } else { "unstable" })
}

/// The multiplier, that of a steep motor as power of ten.
fn multiplier(motion: &PeriodicMotion) -> String {
    let power = motion.growth / std::f64::consts::LN_10;
    // A mass that ends every turn on its flank forgets all of it.
    if power.abs() < 300.0 || power == f64::NEG_INFINITY {
        number(motion.multiplier())
    } else {
        format!("10^{power:.0}")
    }
}

fn table(motions: &[PeriodicMotion], free: Option<&Free>) -> Table {
    let head = "motion  T [s]  mean w [rpm]  least w  largest w  fluctuation  multiplier  E at 0 [J]";
    let row = |name: String, period: f64, course: &[[f64; 2]], rest: [String; 2]| {
        let ([low, high], mean) = (range(course).map(|w| w * 60.0 / TAU), 60.0 / period);
        let mean = if high < 0.0 { -mean } else { mean };
        let [multiplier, energy] = rest;
        vec![
            name,
            format!("{period:.14}"),
            format!("{mean:.8}"),
            format!("{low:.5}"),
            format!("{high:.5}"),
            format!("{} %", number(100.0 * (high - low) / mean.abs())),
            multiplier,
            energy,
        ]
    };
    let of = |(i, motion): (usize, &PeriodicMotion)| {
        let rest = [multiplier(motion), format!("{:.6}", motion.energy)];
        row(name(i, motion), motion.period, &motion.course, rest)
    };
    let mut rows: Vec<Vec<String>> = motions.iter().enumerate().map(of).collect();
    rows.extend(free.map(|(period, course)| row(FREE.into(), *period, course, ["1".into(), "–".into()])));
    Table::new(head, rows)
}

/// The courses of the speed with the names of the motions.
fn courses<'a>(
    motions: &'a [PeriodicMotion],
    free: Option<&'a Free>,
) -> impl Iterator<Item = (String, &'a Vec<[f64; 2]>)> {
    let all = motions.iter().enumerate().map(|(i, motion)| (name(i, motion), &motion.course));
    all.chain(free.map(|(_, course)| (FREE.to_owned(), course)))
}

/// The courses as CSV, one line for each point.
fn csv(motions: &[PeriodicMotion], free: Option<&Free>) -> Result<String, Fault> {
    let rows = courses(motions, free).flat_map(|(name, course)| course.iter().map(move |point| (name.clone(), point)));
    text::csv("motion,phi_rad,w_rad_s", rows)
}

fn diagram(title: String, motions: &[PeriodicMotion], free: Option<&Free>) -> Diagram {
    let series = courses(motions, free)
        .map(|(name, course)| Series::line(name, course.iter().map(|[phi, w]| [phi.to_degrees(), *w])));
    let axes = [Axis::angular("Angle of the main shaft [°]"), Axis::linear("Speed [rad/s]")];
    Diagram::new(title, axes, series.collect(), Vec::new())
}
