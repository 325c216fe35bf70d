//! `camdrive compensate SCENE`

use super::deliver::{ReportFiles, ReportFormat};
use super::measured::Measured;
use super::output::Bar;
use super::{Failure, driving, failure, files, quantity, read, wrong_argument};
use crate::document::{Document, Kind, input};
use crate::task;
use camdrive::drives::drive_train::{self, Follower, Joint, Shaft};
use camdrive::drives::rigid_machine::{self, Inertia, InertiaFunction, Motor, Scene};
use camdrive::drives::shaft::motor::{Reference, Source};
use camdrive::drives::unit;
use camdrive::motion::MotionLaw;
use camdrive_design::compensation::loaded::LoadedMachine;
use camdrive_design::compensation::periodic_motion::Driving;
use camdrive_design::compensation::report::{Compensation, Options, study};
use camdrive_design::compensation::{Form, Restrictions, Task, Tool};
use camdrive_design::report::{Advice, Claim, Level, Setting, Verdict};
use camdrive_design::resource;
use camdrive_design::text;
use clap::builder::PossibleValuesParser;
use std::f64::consts::TAU;
use std::path::{Path, PathBuf};
use toml_edit::{Table, value};

/// The most reported rounds of the iteration: by then it has converged to the last digit, or does not converge.
const MOST_ROUNDS: i64 = 100;

/// The forms of the laws.
const FORMS: [(&str, Form); 3] = [("auto", Form::Auto), ("series", Form::Series), ("table", Form::Table)];

/// Correct the cams of a machine for the fluctuation of its speed.
///
/// The laws of the followers prescribe the motions of the tools over the phase of time 2πt/T. After mechanisms, [follower.tool]
/// prescribes the tool; without it, the motion that the lever's law gives. The inertia of tools and links makes the speed of the
/// machine fluctuate. The result is a scene with laws U(φ) that still move the tools as prescribed. The report shows the rounds of
/// the classical iteration, the machine with the finished cams, and the same machine at other speeds. A compensation takes at most
/// 1.2e11 counted operations, about two minutes; a longer one ends with an error that says how far it came.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  camdrive compensate examples/rapier_loom/scene.toml -o compensated.toml
  camdrive compensate examples/rapier_loom/scene.toml --period \"120 ms\" \\
      --report study/
  camdrive export compensated.toml")]
pub struct Args {
    /// Scene file (TOML) of a RigidMachine, or of a DriveTrain with rigid followers; their loads and their motor count
    scene: PathBuf,
    /// The scene with the compensated cams [default: NAME.compensated.toml]
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Period, "120 ms" or in s: sets the synchronous speed of the motor accordingly; required for a machine without a motor
    #[arg(long, value_name = "TIME", allow_hyphen_values = true)]
    period: Option<String>,
    /// Constant load torque, "30 N.m"; positive brakes
    #[arg(long, value_name = "TORQUE", default_value = "0", allow_hyphen_values = true)]
    load: String,
    /// Followers whose cams stay as they are, counted from 1
    #[arg(long, value_name = "NUMBER", value_delimiter = ',')]
    keep: Vec<usize>,
    /// How much the finite laws of the cams may change a tool's acceleration, relative to its largest value
    #[arg(long, value_name = "PART", default_value_t = 1e-6, allow_negative_numbers = true)]
    tolerance: f64,
    /// Write the laws as Fourier series in the angle, or as tables next to the result, with points of periodic splines of degree 5.
    /// auto writes a table if a series would need more harmonics than a scene admits. Motions that are not series get tables with
    /// their derivatives
    #[arg(long, value_name = "FORM", default_value = FORMS[0].0, value_parser = PossibleValuesParser::new(FORMS.map(|(name, _)| name)))]
    laws: String,
    /// Rounds of the iteration to report
    #[arg(long, value_name = "NUMBER", default_value_t = 3, allow_negative_numbers = true, value_parser = clap::value_parser!(u16).range(..=MOST_ROUNDS))]
    rounds: u16,
    /// Motion task (TOML) with bounds, tolerances, exact points and distances; the tools are checked against it in every round. Its
    /// laws belong to the followers in their order
    #[arg(long, value_name = "FILE")]
    task: Option<PathBuf>,
    /// Folder for tables and diagrams: NAME.json, NAME.compensation.csv, for the rounds NAME.courses.csv, NAME.spectra.csv,
    /// NAME.speed.svg, NAME.tool1.svg, NAME.tool1.spectrum.svg …, for distances NAME.distance.svg
    #[arg(long, value_name = "FOLDER")]
    report: Option<PathBuf>,
    #[command(flatten)]
    measured: Measured,
    /// Scene of a cam drive that gets the compensated cam of a follower, as NUMBER=FILE; written next to the result as FILE's name
    /// with .compensated.toml
    #[arg(long, value_name = "NUMBER=FILE")]
    cam: Vec<String>,
    /// Replace scenes even if no command wrote them
    #[arg(long)]
    force: bool,
    #[command(flatten)]
    format: ReportFormat,
}

/// The machine of the scene.
struct Machine {
    name: String,
    /// The files of the scene.
    files: Vec<PathBuf>,
    task: Task,
    /// The followers that move tools, counted from 0.
    tools: Vec<usize>,
    /// For each tool, whether the law of its cam is an angle.
    turning: Vec<bool>,
    /// φ at the start (rad).
    phi_start: f64,
}

/// The machine and the followers of a train, if the compensation can handle them, and its motor as in a RigidMachine.
fn train(args: &Args, scene: &drive_train::Scene) -> Result<(drive_train::Machine, Vec<Follower>, Motor), Failure> {
    let drive_train::Scene { shaft, followers, .. } = scene.clone();
    let refused = |why: &str, hint: &str| failure(format!("{}: {why}", args.scene.display())).hint(hint);
    let Shaft::Free(machine) = shaft else {
        return Err(refused("the motion of the shaft is prescribed", "give [machine] and [motor] instead of [drive]"));
    };
    let elastic = followers.iter().position(|follower| follower.joint != Joint::Rigid);
    let (source, coupling) = (&machine.motor.source, machine.motor.transmission.coupling);
    let (position, varies) = match source {
        Source::Servo(servo) => (servo.position.is_some(), !matches!(servo.reference, Reference::Constant(_))),
        _ => (false, false),
    };
    for (wrong, why, hint) in [
        (
            elastic.is_some(),
            "tools on elasticities or with clearance do not follow their cams exactly",
            "leave out [follower.elasticity] and [follower.backlash]",
        ),
        (coupling.is_some(), "with a coupling or a belt the rotor vibrates against the shaft", "leave it out"),
        (position, "with a position loop the servo has two states, and a compensation handles one", "leave out K_v"),
        (varies, "the reference speed of the servo changes with time or is an input", "set w_ref to a value"),
        (
            *source == Source::None,
            "without a motor the loads stop the machine",
            "add a [motor], or leave out the loads",
        ),
    ] {
        if wrong {
            return Err(refused(why, hint));
        }
    }
    let motor = if let Source::Kloss(kloss) = source { Motor::Kloss(*kloss) } else { Motor::Input };
    Ok((machine, followers, motor))
}

fn machine(args: &Args) -> Result<Machine, Failure> {
    let place = args.scene.display().to_string();
    let mut resolved = read(&args.scene)?;
    let mut loaded = None;
    let (inertia, followers, motor, phi_start);
    if let resource::Scene::DriveTrain(scene) = &resolved.scene {
        let (machine, all, kind) = train(args, scene)?;
        (motor, phi_start, followers) =
            (kind, machine.phi_start, all.iter().map(|follower| follower.rigid.clone()).collect());
        let constant = machine.inertia.constant + machine.motor.stiff_rotor();
        inertia = InertiaFunction { constant, ..machine.inertia.clone() };
        loaded = Some((machine, all));
    } else {
        let scene: Scene;
        (resolved, scene) = driving::machine(&args.scene, "compensation")?;
        (inertia, followers, motor, phi_start) = (scene.inertia, scene.followers, scene.motor, scene.phi_start);
    }
    let own_torque = loaded.as_ref().is_some_and(|(machine, _)| machine.motor.source != Source::Input);
    let (load, period) = match (motor, &args.period) {
        (Motor::Input, None) if own_torque => (quantity("load", &args.load, &unit::TORQUE)?, None),
        (Motor::Input, Some(_)) if own_torque => {
            let hint =
                "change its torque, its table or w_ref; with --period a motor of kind \"kloss\" gets another w_s";
            return Err(wrong_argument("--period: the motor for this period is unknown").hint(hint));
        }
        _ => driving::load(&place, &motor, &args.load, args.period.as_ref())?,
    };
    let followers: Vec<rigid_machine::Follower> = followers;
    let count = followers.len();
    if let Some(wrong) = args.keep.iter().find(|j| !(1..=count).contains(j)) {
        return Err(wrong_argument(format!(
            "--keep: there is no follower {wrong}; the scene has {count}, counted from 1"
        )));
    }
    if !(args.tolerance > 0.0 && args.tolerance < 1.0) {
        return Err(wrong_argument(format!("--tolerance: {} is not between 0 and 1", args.tolerance)));
    }
    let (mut tools, mut kept, mut moved, mut turning) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    for (j, follower) in followers.into_iter().enumerate() {
        if args.keep.contains(&(j + 1)) || !follower.has_cam() {
            kept.push(follower);
            continue;
        }
        let turns = follower.cam_turns();
        tools.push(Tool::of(j + 1, follower));
        moved.push(j);
        turning.push(turns);
    }
    if tools.is_empty() {
        return Err(failure(format!("{place}: no follower has a cam to compensate")));
    }
    let mut files = resolved.files;
    let restrictions =
        args.task.as_ref().map(|path| restrictions(path, &tools, args.tolerance, &mut files)).transpose()?;
    let loaded = loaded.map(|(machine, followers)| {
        let (tools, kept): (Vec<_>, Vec<_>) = followers.into_iter().enumerate().partition(|(j, _)| moved.contains(j));
        let [kept, tools] = [kept, tools].map(|list| list.into_iter().map(|(_, follower)| follower).collect());
        LoadedMachine { machine, kept, tools }
    });
    let task = Task {
        own: Inertia::new(inertia, kept),
        tools,
        driving: Driving { motor, load, period },
        restrictions: restrictions.unwrap_or_default(),
        loaded,
    };
    Ok(Machine { name: resolved.name, files, task, tools: moved, turning, phi_start })
}

/// Restrictions of the tools from a motion task; adds the task's files to the list.
fn restrictions(
    path: &Path,
    tools: &[Tool],
    tolerance: f64,
    files: &mut Vec<PathBuf>,
) -> Result<Restrictions, Failure> {
    let assignment = task::read(path).map_err(failure)?;
    files.push(path.to_owned());
    files.extend(assignment.files.iter().cloned());
    Restrictions::of(&assignment, tools, tolerance).map_err(|missing| {
        wrong_argument(format!(
            "--task: {} has a law for follower {missing}, whose tool is not compensated",
            path.display()
        ))
        .hint("the laws of a task belong to the followers in their order; leave --keep out")
    })
}

pub fn run(args: &Args) -> Result<(), Failure> {
    let machine = machine(args)?;
    let output = args.output.clone().unwrap_or_else(|| PathBuf::from(format!("{}.compensated.toml", machine.name)));
    files::no_foreign(&output, &machine.files, args.force)?;
    if let Some(folder) = &args.report {
        files::no_file(folder, "--report")?;
    }
    args.measured.need(args.report.as_ref())?;
    let form = FORMS.into_iter().find(|(name, _)| *name == args.laws).map_or(Form::Auto, |(_, form)| form);
    let options = Options { tolerance: args.tolerance, rounds: args.rounds.into(), form };
    let findings = Bar::during(&machine.name, |progress| study(&machine.name, &machine.task, options, &progress))
        .map_err(|fault| failure(fault.within(args.scene.display())))?;
    let cams = cams(&machine, &findings, &output)?;
    let mut inputs = machine.files.clone();
    let mut results = vec![(output.clone(), compensated(args, &machine, &findings, &cams)?)];
    for pair in &args.cam {
        let (target, scene, read) = with_cam(pair, &machine, &cams, &output)?;
        files::no_foreign(&target, &read, args.force)?;
        inputs.extend(read);
        if results.iter().any(|(other, _)| *other == target) {
            return Err(wrong_argument(format!(
                "--cam: \"{pair}\" would be written to {}, like another result",
                target.display()
            ))
            .hint("rename the file, or choose another -o"));
        }
        results.push((target, scene));
    }
    results.extend(cams.iter().filter_map(|cam| cam.points.clone()));
    let mut report = findings.report();
    on_start(&machine, &findings, &mut report.verdict);
    let results = results.into_iter().map(|(path, text)| (path, text.into_bytes())).collect();
    let place = ReportFiles {
        folder: args.report.as_deref(),
        more: results,
        inputs,
        measured: Some(&args.measured),
        scene: None,
        force: args.force,
    };
    args.format.deliver(report, &findings, place)
}

/// Adds the requirements for the start of the compensated machine.
fn on_start(machine: &Machine, findings: &Compensation, verdict: &mut Verdict) {
    let Driving { motor, load, .. } = machine.task.driving;
    if motor == Motor::None {
        let w = findings.speed_at(machine.phi_start);
        let text =
            format!("Without a motor the machine keeps the period that it starts with: start.w_start = {w:.9} rad/s.");
        verdict.result(Level::Good, text);
    } else if load != 0.0 {
        // `steady_state` starts with the fastest stable motion.
        let starts = findings.other_motion.is_none();
        let start = match starts {
            true => ", and `start.mode` to \"steady_state\", so that the machine starts in this motion",
            false => "",
        };
        let text = format!(
            "Set the input `tau` of the FMU to {load} N·m before initialisation{start}: the load is not part of the scene."
        );
        let mean = (TAU / findings.period).copysign(findings.speed_at(machine.phi_start));
        let set = [Setting::new("tau", load), Setting::new("start.mode", "steady_state")];
        let set = set.into_iter().filter(|_| starts);
        verdict.advice(Advice::new(text).set(set, Claim::Speed { mean }));
    }
}

/// Names the tables of the scene by a path from the folder of the result.
fn carry_over(document: &mut Document, scene: &Path) {
    let folder = scene.parent().unwrap_or(Path::new(""));
    document.name_files(&|file| {
        let path = folder.join(file);
        path.canonicalize().unwrap_or(path).display().to_string()
    });
}

/// The keys for the tool's motion, which replace the lever's.
const OF_THE_TOOL: [&str; 2] = ["tool", "lever_start"];

/// The name of a scene with compensated cams: the scene's name, as far as the longest name allows, with an ending that
/// distinguishes HS profiles, which are series, from tables.
fn renamed(name: &str, cams: &[Cam]) -> String {
    let of_series = cams.iter().all(|cam| cam.points.is_none());
    let ending = if of_series { "_hs" } else { "_table" };
    let most = resource::LONGEST_NAME - ending.len();
    format!("{}{ending}", &name[..name.len().min(most)])
}

/// A compensated cam as in a scene.
struct Cam {
    /// `[cam]`.
    table: Table,
    /// The file with the points of a table, next to the scenes.
    points: Option<(PathBuf, String)>,
}

/// The compensated cams; the points of tables go to files next to the result.
fn cams(machine: &Machine, findings: &Compensation, output: &Path) -> Result<Vec<Cam>, Failure> {
    let stem = output.file_stem().unwrap_or_default().to_string_lossy();
    let cam = |(law, place): (&MotionLaw, usize)| match law {
        MotionLaw::Fourier(series) => Ok(Cam { table: files::cam(series, 1.0), points: None }),
        MotionLaw::Table(points) => {
            let name = format!("{stem}.follower{}.csv", machine.tools[place] + 1);
            let lift = if machine.turning[place] { "lift_rad" } else { "lift_m" };
            let mut table = Table::new();
            table["law"] = value("table");
            table["file"] = value(name.clone());
            let (places, bends) = (points.points(), points.bends());
            let row = |(i, (phi, u)): (usize, (&f64, &f64))| {
                let bend = bends.get(i).map(|bend| [bend.slope, bend.before, bend.behind]);
                [&[*phi, *u], bend.as_slice().as_flattened()].concat().iter().map(|x| format!("{x:?}")).collect()
            };
            let mut head = format!("phi_rad,{lift}");
            if points.is_bent() {
                table["interpolation"] = value("derivatives");
                head += ",dU,ddU_before,ddU_behind";
            }
            let rows = places.angles.iter().zip(&places.lifts).enumerate().map(row);
            let head = head.split(',').map(str::to_owned).collect();
            let text = text::csv(std::iter::once(head).chain(rows)).map_err(failure)?;
            Ok(Cam { table, points: Some((output.parent().unwrap_or(Path::new("")).join(name), text)) })
        }
        _ => Err(failure("a compensated cam is a series or a table")),
    };
    findings.laws.iter().zip(0..).map(cam).collect()
}

/// The scene with the compensated cams.
fn compensated(args: &Args, machine: &Machine, findings: &Compensation, cams: &[Cam]) -> Result<String, Failure> {
    let (_, mut document) = input::document(&args.scene, Kind::Scene)?;
    carry_over(&mut document, &args.scene);
    document.set("name", renamed(&machine.name, cams));
    let unexpected = || failure(format!("{}: the followers are not [[follower]] tables", args.scene.display()));
    for (cam, j) in cams.iter().zip(&machine.tools) {
        let follower = format!("follower[{}]", j + 1);
        // The tool's motion behind mechanisms prescribed the cam; the lever's law replaces it.
        for key in OF_THE_TOOL {
            document.remove(&format!("{follower}.{key}"));
        }
        document.set(&format!("{follower}.cam"), cam.table.clone()).ok_or_else(unexpected)?;
    }
    if let (Some(speed), Some(_)) = (findings.synchronous_speed, &args.period) {
        document.set("motor.w_s", speed);
    }
    if machine.task.driving.motor == Motor::None {
        // Only this gives the machine the speed that belongs to the period.
        document.set("start.w_start", findings.speed_at(machine.phi_start));
    }
    Ok(files::signed(&document, "Scene with the compensated cams", &args.scene, "compensate"))
}

/// The scene of a cam drive with the compensated cam of a follower, and the files of the scene.
fn with_cam(
    pair: &str,
    machine: &Machine,
    cams: &[Cam],
    output: &Path,
) -> Result<(PathBuf, String, Vec<PathBuf>), Failure> {
    let wrong = || {
        let tools: Vec<String> = machine.tools.iter().map(|j| (j + 1).to_string()).collect();
        wrong_argument(format!(
            "--cam: \"{pair}\" is not NUMBER=FILE with the number of a compensated follower ({})",
            tools.join(", ")
        ))
        .hint("write for example --cam 1=gripper.toml")
    };
    let (number, file) = pair.split_once('=').ok_or_else(wrong)?;
    let number: usize = number.trim().parse().map_err(|_| wrong())?;
    let place = machine.tools.iter().position(|j| j + 1 == number).ok_or_else(wrong)?;
    let path = PathBuf::from(file.trim());
    let scene = read(&path)?;
    if machine.turning[place] {
        return Err(wrong_argument(format!(
            "--cam: the cam of follower {number} moves a lever or a tool by an angle; the cam of {} moves a mass along a line",
            path.display()
        )));
    }
    let (_, mut document) = input::document(&path, Kind::Scene)?;
    if !document.table.contains_key("cam") {
        return Err(wrong_argument(format!("--cam: {} is a machine, not a drive with one cam", path.display())));
    }
    document.set("name", renamed(&scene.name, &cams[place..=place]));
    carry_over(&mut document, &path);
    document.set("cam", cams[place].table.clone());
    let stem = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let target = output.parent().unwrap_or(Path::new("")).join(format!("{stem}.compensated.toml"));
    let what = format!("Scene with the compensated cam of follower {number} instead of the cam");
    Ok((target, files::signed(&document, &what, &path, "compensate"), scene.files))
}
