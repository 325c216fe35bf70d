//! Advice is right as it stands: what a command says to set is set in its file, and what it claims holds then and, of a limit,
//! no longer beyond it. Claims on the motion are checked on the drive, others by the command that made them.

use super::super::run::Run;
use super::super::scenes::{CamScene, MachineScene};
use super::forces::tappet;
use super::{clearance, compensate, forces, stability, steady, *};
use camdrive::drives::shaft::cam_drive::DriveMode;
use std::collections::BTreeMap;

/// How far beyond a limit its claim has to fail.
const BEYOND: f64 = 0.01;

/// Free motions that grow by less in a turn do not grow: the drive keeps 1e-9.
const STABLE: f64 = 1e-7;

/// What a claim on a motion may miss: it is printed with all digits, and settings with three or more.
const MISS: f64 = 1e-6;

/// A command on a file.
#[derive(Clone)]
struct Advised {
    files: Files,
    tool: &'static str,
    arguments: Vec<String>,
}

/// How many claims of each kind were checked.
type Counts = BTreeMap<String, usize>;

/// The place of a key in a file; its last part, and the table around it, need not be there.
fn place<'a>(file: &'a mut Value, key: &str) -> &'a mut Value {
    key.split('.').fold(file, |table, part| match part.split_once('[') {
        None => &mut table[part],
        Some((list, number)) => {
            let number: usize = number.trim_end_matches(']').parse().expect("a number");
            &mut table[list][number - 1]
        }
    })
}

/// A number with its unit, made larger by a factor.
fn scaled(value: &Value, factor: f64) -> Value {
    match value {
        Value::String(text) => {
            let (number, unit) = text.split_once(' ').expect("a number with its unit");
            format!("{} {unit}", factor * number.parse::<f64>().expect("a number")).into()
        }
        number => (factor * number.as_f64().expect("a number")).into(),
    }
}

/// Values beyond a limit, for which the claim fails; steps of masters are tried by powers of two.
fn beyond(tool: &str, one: &Value) -> Vec<Value> {
    let value = &one["value"];
    let intervals = one["reach"]["outside"].as_array().into_iter().flatten();
    // In the middle, or well above a border without another one.
    let speed = |end: &Value| end.as_str().and_then(|text| text.strip_suffix(" rpm")?.parse::<f64>().ok());
    let inside = |ends: &Value| match (speed(&ends[0]), speed(&ends[1])) {
        (Some(low), Some(high)) => format!("{} rpm", 0.5 * (low + high)),
        (Some(low), None) => format!("{} rpm", 1.5 * low),
        _ => panic!("no interval: {ends}"),
    };
    if one["reach"].is_object() {
        return intervals.map(|ends| inside(ends).into()).collect();
    }
    match one["reach"].as_str() {
        Some("at_least") => vec![scaled(value, 1.0 - BEYOND)],
        Some("at_most") if tool == "system" => vec![scaled(value, 2.0)],
        Some("at_most") => vec![scaled(value, 1.0 + BEYOND)],
        _ => Vec::new(),
    }
}

/// The values of an output of a run.
fn column(columns: &Value, name: &str) -> Option<Vec<f64>> {
    let column = columns.as_array()?.iter().find(|column| column["name"] == name)?;
    Some(column["values"].as_array()?.iter().map(|value| value.as_f64().unwrap_or(f64::NAN)).collect())
}

impl Advised {
    fn new(tool: &'static str, files: Files, more: &[&str]) -> Self {
        let arguments = ["--json"].iter().chain(more).map(|argument| (*argument).to_owned()).collect();
        Advised { files, tool, arguments }
    }

    /// What another command prints of the file.
    fn printed(&self, tool: &str, arguments: &[&str]) -> Result<Value, String> {
        let arguments: Vec<String> = arguments.iter().map(|argument| (*argument).to_owned()).collect();
        self.files.printed(tool, &arguments)
    }

    /// The same command on a file with these values.
    fn with(&self, set: &[(&str, Value)]) -> Self {
        let mut other = self.clone();
        for (key, value) in set {
            *place(&mut other.files.scene, key) = value.clone();
        }
        other
    }

    /// Checks all that is advised.
    fn hold(&self, counts: &mut Counts) -> Result<(), String> {
        let (text, folder) = self.files.run(self.tool, &self.arguments)?;
        let mut found = parsed(&text);
        // `check` has a list of files.
        if self.tool == "check" {
            found = found[0].take();
        }
        for advice in found["verdict"]["advice"].as_array().expect("a list") {
            let list = advice["set"].as_array().expect("a list");
            let (text, claim) = (&advice["text"], &advice["claim"]);
            let Some(kind) = claim["kind"].as_str() else {
                assert!(list.is_empty(), "without a claim nothing is set: {advice}");
                continue;
            };
            let set: Vec<(&str, Value)> =
                list.iter().map(|one| (one["key"].as_str().expect("a key"), one["value"].clone())).collect();
            let held = |set: &[(&str, Value)]| {
                let other = self.with(set);
                other.holds(self, claim, &found, &folder).map_err(|fault| format!("{text} {set:?}: {fault}"))
            };
            if !held(&set)? {
                return Err(format!("{text} {set:?}: it does not hold"));
            }
            for (i, one) in list.iter().enumerate() {
                for value in beyond(self.tool, one) {
                    let mut other = set.clone();
                    other[i].1 = value;
                    if held(&other)? {
                        return Err(format!("{text}: it holds with {other:?}, too"));
                    }
                }
            }
            *counts.entry(format!("{} {kind}", self.tool)).or_default() += 1;
        }
        Ok(())
    }

    /// Whether a claim on the file that a command has `found` things of before, and written to `folder`, holds for this one.
    fn holds(&self, before: &Self, claim: &Value, found: &Value, folder: &TempDir) -> Result<bool, String> {
        let number = |key: &str| claim[key].as_f64().expect("a number");
        let j = claim["follower"].as_u64().unwrap_or(1) as usize - 1;
        match claim["kind"].as_str().expect("a kind") {
            "stable" => {
                let speeds: Vec<f64> =
                    claim["at"].as_array().expect("speeds").iter().filter_map(Value::as_f64).collect();
                let speeds = if speeds.is_empty() { vec![self.started()?.1] } else { speeds };
                let radii: Result<Vec<f64>, String> = speeds.iter().map(|speed| self.radius(*speed)).collect();
                Ok(radii?.into_iter().all(|radius| radius <= 1.0 + STABLE))
            }
            "contact" => {
                let found = self.printed("forces", &["--json", "-o", "out"])?;
                let speed = found["speed"].as_f64().expect("a speed").abs();
                // A cam that holds on both sides has no speed of lift-off.
                let from = found["drives"][j]["keeping"]["lift_off_speed"]["value"].as_f64();
                let keeps = from.is_none_or(|from| from >= speed);
                if self.files.scene["backlash"]["s"] == "inf" && self.leaves()? == keeps {
                    return Err(format!("contact {}, not so the drive", if keeps { "holds" } else { "is lost" }));
                }
                let said = self.printed("check", &["--json"])?[0]["verdict"]["result"].to_string();
                if keeps && found["drives"].as_array().is_some_and(|all| all.len() == 1) && said.contains("lifts off") {
                    return Err(format!("contact holds, but `check` says {said}"));
                }
                Ok(keeps)
            }
            "cut" => {
                let found = self.printed("cam", &["--json", "--force", "-o", "out"])?;
                let cams = found["followers"][j]["cams"].as_array().expect("cams").iter();
                let findings = cams.flat_map(|cam| cam["findings"].as_array().expect("findings"));
                let is_undercut = |of: &Value| of["what"].as_str().is_some_and(|what| what.contains("undercut"));
                Ok(findings.filter(|of| is_undercut(of)).all(|of| of["verdict"] != "bad"))
            }
            "speed" if before.tool == "compensate" => self.is_compensated(folder, number("mean")),
            "speed" => {
                // In the period of this speed the machine makes a turn.
                let period = TAU / number("mean").abs();
                let [stop, step] = ["stop", "step"].map(|name| format!("--{name}={period:e} s"));
                let on_it = self.with(&[("start.mode", "steady_state".into())]);
                let phi = match on_it.printed("run", &["--json", &stop, &step]) {
                    Ok(run) => column(&run["columns"], "phi").expect("an angle"),
                    // A motor is too stiff for a start within a call.
                    Err(fault) if fault.contains("needs more work") => return Ok(true),
                    Err(fault) => return Err(fault),
                };
                Ok(((phi[1] - phi[0]) / TAU - number("mean").signum()).abs() < MISS)
            }
            "plausible" => {
                // Other commands have the advice of `check` on the motion.
                let warnings = |of: &Advised| -> Result<usize, String> {
                    Ok(of.printed("check", &["--json"])?[0]["warnings"].as_array().expect("warnings").len())
                };
                Ok(warnings(self)? < warnings(before)?)
            }
            "deviation" => {
                let found = self.printed("synthesize", &["--json", "-o", "profile.toml"])?;
                let ranges = found["deviations_of_the_motion"].as_array().expect("deviations").iter();
                Ok(ranges.filter_map(|range| range[0].as_f64()).all(|deviation| deviation <= number("at_most")))
            }
            "error" if before.tool == "system" => {
                let found = self.printed("system", &["--json", "--study", "-o", "out"])?;
                let file = &self.files.scene;
                let repeats = file["repeat"].as_u64().unwrap_or(0);
                let is_own = |row: &&Value| {
                    row["step"] == found["step"] && row["exchange"] == file["exchange"] && row["repeats"] == repeats
                };
                let row = found["rows"].as_array().expect("rows").iter().find(is_own);
                Ok(row.and_then(|row| row["error"].as_f64()).is_some_and(|error| error <= number("at_most")))
            }
            "error" => self.is_followed(before, claim, found),
            "impulse" => Ok(self.largest_impulse()? <= number("at_most")),
            kind => panic!("no check of {kind}"),
        }
    }

    /// Whether the compensated machine starts on the motion of this mean speed (rad/s) under the input `tau` that is set.
    fn is_compensated(&self, folder: &TempDir, mean: f64) -> Result<bool, String> {
        let mut machine: Value = toml::from_str(&read(folder, "cams.toml")).expect("a scene");
        *place(&mut machine, "start.mode") = self.files.scene["start"]["mode"].clone();
        let text = toml::to_string(&machine).expect("a scene");
        let machine = scene::resolve("cams.toml", &text, folder.path()).map_err(|faults| faults.to_string())?;
        let load = self.files.scene["tau"].as_f64().expect("a torque");
        let drive = machine.scene.build().map_err(|fault| fault.to_string())?;
        let mut run = Run::of(drive, &[("tau", load)], &[]).map_err(|fault| fault.to_string())?;
        let from = run.get("phi");
        run.to(TAU / mean.abs()).map_err(|fault| fault.to_string())?;
        Ok(((run.get("phi") - from) / TAU - mean.signum()).abs() < MISS)
    }

    /// Whether the run with these settings has no larger errors than claimed, for less work than the one before where that does as
    /// well.
    fn is_followed(&self, before: &Self, claim: &Value, found: &Value) -> Result<bool, String> {
        let size = claim["step"].as_f64().or(found["experiment"]["step"].as_f64()).expect("a step");
        let stop = found["experiment"]["stop"].as_f64().expect("an end");
        let run = |of: &Self, more: &[&str]| {
            let (stop, step) = (format!("--stop={stop:e} s"), format!("--step={size:e} s"));
            let arguments = ["--json", &stop, &step].iter().chain(more).copied().collect::<Vec<_>>();
            of.printed("run", &arguments).map(|found| found["columns"].clone())
        };
        let exact = before.with(&[("solver.tolerance", 1e-12.into()), ("solver.method", "adaptive".into())]);
        let reference = run(&exact, &[])?;
        let error = |of: &Self| -> Result<f64, String> {
            let columns = run(of, &[])?;
            let names =
                reference.as_array().expect("columns").iter().map(|right| right["name"].as_str().expect("a name"));
            let of_output = |name: &str| {
                let [right, own] = [&reference, &columns].map(|columns| column(columns, name).expect("the output"));
                let largest = right.iter().fold(0.0, |largest: f64, value| largest.max(value.abs()));
                let difference = right.iter().zip(&own).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                if difference > 0.0 { difference / largest } else { 0.0 }
            };
            Ok(names.filter(|name| !name.starts_with("solver.")).map(of_output).fold(0.0, f64::max))
        };
        // Closed forms count none.
        let work = |of: &Self| {
            let found = run(of, &["--output=solver.evaluations"]).ok()?;
            column(&found, "solver.evaluations").map(|values| values[values.len() - 1])
        };
        let most = claim["at_most"].as_f64().expect("an error");
        let (worst, usual) = (error(self)?, error(before)?);
        let (own, without) = (work(self), work(before));
        // Longer communication steps save none of it.
        let saves = usual <= most && claim["step"].is_null();
        let cheaper = !saves || own.zip(without).is_none_or(|(own, without)| own < without);
        match worst <= most && cheaper {
            true => Ok(true),
            false => Err(format!("the error is {worst:e}, with {own:?} evaluations instead of {without:?}")),
        }
    }

    /// The factor by which free motions of the linear equation grow in a turn at a speed (rad/s): that of the map of q, q̇ over a
    /// turn of the drive, from three starts.
    fn radius(&self, speed: f64) -> Result<f64, String> {
        let mut at_speed = self.with(&[("drive.speed", speed.into())]);
        if at_speed.files.scene["elasticity"]["place"] == "shaft" {
            *place(&mut at_speed.files.scene, "elasticity.linear") = true.into();
        }
        // About as large in q as in q̇ over the time of an oscillation.
        let scale = speed.abs();
        let end = |q: f64, rate: f64| {
            let start = json!({"mode": "given", "q": q, "q_dot": rate * scale});
            let drive = at_speed
                .with(&[("start", start)])
                .files
                .resolved()?
                .scene
                .build()
                .map_err(|fault| fault.to_string())?;
            let mut run = Run::of(drive, &[], &[]).map_err(|fault| fault.to_string())?;
            run.to(TAU / speed.abs()).map_err(|fault| fault.to_string())?;
            let [q, rate] = run.all(["q", "der(q)"]);
            Ok::<_, String>([q, rate / scale])
        };
        const SIZE: f64 = 1e-3;
        let (rest, first, second) = (end(0.0, 0.0)?, end(SIZE, 0.0)?, end(0.0, SIZE)?);
        let column = |end: [f64; 2]| [0, 1].map(|i| (end[i] - rest[i]) / SIZE);
        let ([a, c], [b, d]) = (column(first), column(second));
        let (trace, determinant) = (a + d, a * d - b * c);
        let root = 0.25 * trace * trace - determinant;
        Ok(if root < 0.0 { determinant.abs().sqrt() } else { 0.5 * trace.abs() + root.sqrt() })
    }

    /// The drive at the start that the scene names, and its speed.
    fn started(&self) -> Result<(Run, f64), String> {
        let scene = self.files.resolved()?.scene;
        let Some(&DriveMode::Constant { w, .. }) = scene.drive() else { panic!("a constant speed") };
        let run = scene.build().and_then(|drive| Run::of(drive, &[], &[]));
        run.map(|run| (run, w)).map_err(|fault| fault.to_string())
    }

    /// The largest impulse in the second half of some turns.
    fn largest_impulse(&self) -> Result<f64, String> {
        const TURNS: usize = 40;
        // So short a part of a turn has fewer events than the log holds.
        const PARTS: usize = 256;
        let (mut run, w) = self.started()?;
        let mut largest: f64 = 0.0;
        for part in 1..=TURNS * PARTS {
            run.to(part as f64 / PARTS as f64 * TAU / w.abs()).map_err(|fault| fault.to_string())?;
            let impacts = run.drive.events().iter().filter(|event| event.kind.starts_with("impact"));
            let hardest = impacts.fold(0.0, |hardest: f64, event| hardest.max(event.value.abs()));
            largest = largest.max(if part > TURNS / 2 * PARTS { hardest } else { 0.0 });
            run.drive.events().clear();
        }
        Ok(largest)
    }

    /// Whether a follower of one mass, which may leave its cam, does so within two turns.
    fn leaves(&self) -> Result<bool, String> {
        let (mut run, w) = self.started()?;
        run.to(2.0 * TAU / w.abs()).map_err(|fault| fault.to_string())?;
        Ok(run.drive.events().count() > 0)
    }
}

/// So many random values from this seed on.
fn random<S: Strategy>(first: u64, count: u64, strategy: S) -> impl Iterator<Item = S::Value> {
    let count = count * u64::from(chosen()[1]);
    (first..first + count).map(move |seed| {
        let mut runner = TestRunner::new(config(1, 0, seed));
        strategy.new_tree(&mut runner).expect("a scene").current()
    })
}

/// An example, whose tables come along.
fn example(path: &str) -> Files {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("the root").join("examples").join(path);
    let text = std::fs::read_to_string(&path).expect("an example");
    let folder = path.parent().expect("its folder").display().to_string();
    Files { scene: toml::from_str(&text).expect("a scene"), folder, ..Files::default() }
}

/// Follows the advice on all of these.
fn all(list: impl IntoIterator<Item = Advised>) -> Counts {
    let (mut counts, mut failures, mut refused, mut asked) = (Counts::new(), String::new(), Vec::new(), 0);
    for advised in list {
        asked += 1;
        match advised.hold(&mut counts) {
            Ok(()) => (),
            Err(fault) if fault.starts_with("error") => refused.push(fault),
            Err(fault) => {
                let scene = toml::to_string(&advised.files.scene).expect("a scene");
                let _ = writeln!(failures, "{}: {fault}\n{scene}", advised.tool);
            }
        }
    }
    assert!(failures.is_empty(), "{failures}");
    assert!(2 * refused.len() <= asked, "{} of {asked} are refused: {}", refused.len(), refused[0]);
    counts
}

/// Seen to find a preload that was enough at the speed of the machine, but not on the way there.
#[test]
fn of_forces() {
    let examples = ["tappet/scene.toml", "valve_train/forces.toml", "sealing_machine/loaded.toml"].map(example);
    let elastic = random(5000, 12, forces::any()).map(|scene| tappet(&scene, false));
    let rigid = random(5050, 12, forces::any()).map(|scene| tappet(&scene, true));
    let files = examples.into_iter().chain(elastic).chain(rigid);
    let counts = all(files.map(|files| Advised::new("forces", files, &["-o", "out"])));
    assert!(counts["forces contact"] >= 8, "{counts:?}");
}

/// Speeds to avoid, and the damping that makes them stable, of drives that run near them.
#[test]
fn of_stability() {
    let near = |(scene, part): (stability::Scene, f64)| {
        let mut files = stability::files(&scene, &SAME);
        let found = files.printed("stability", &["--json", "--quick", "-o", "out"].map(str::to_owned)).ok()?;
        let [low, high] =
            [0, 1].map(|i| found["orders"].as_array()?.iter().find_map(|order| order["damped"][i].as_f64()));
        let eta = low? * (high.unwrap_or(1.2 * low?) / low?).powf(part);
        files.scene["drive"]["speed"] = (eta * found["oscillator"]["natural_frequency"].as_f64()?).into();
        Some(files)
    };
    let examples = ["hs3", "scene", "inflection"].map(|name| example(&format!("transfer_manipulator/{name}.toml")));
    let random = random(5400, 4, (stability::any(), -1.0..2.0_f64)).filter_map(near);
    let files = examples.into_iter().chain(random);
    let counts = all(files.map(|files| Advised::new("stability", files, &["--quick", "-o", "out"])));
    assert!(counts["stability stable"] >= 4, "{counts:?}");
}

/// Cams whose rollers are large.
#[test]
fn of_cams() {
    let large = |scene: forces::Scene| {
        let mut files = tappet(&scene, false);
        let radius = &mut files.scene["geometry"]["roller_radius"];
        *radius = (1.8 * radius.as_f64().expect("a radius")).into();
        files
    };
    let examples = ["tappet/scene.toml", "sealing_machine/scene.toml"].map(example);
    let files = examples.into_iter().chain(random(5100, 8, forces::any()).map(large));
    let counts = all(files.map(|files| Advised::new("cam", files, &["--force", "-o", "out"])));
    assert!(counts["cam cut"] >= 3, "{counts:?}");
}

/// Impacts without restitution, which no change of another quantity cures. Seen to find a motion that depends on its start.
#[test]
fn of_clearances() {
    let drive = |scene: CamScene| clearance::files(&CamScene { e: 0.0, ..scene }, &SAME);
    let files =
        [example("backlash_drive/scene.toml")].into_iter().chain(random(5200, 2, clearance::loose()).map(drive));
    let counts = all(files.map(|files| Advised::new("clearance", files, &["-o", "out"])));
    assert!(counts["clearance impulse"] >= 1, "{counts:?}");
}

/// With the synchronous speed that gives a machine another period.
#[test]
fn of_periods() {
    let machine = |files: Files| {
        let found = files.printed("steady", &["--json".to_owned()]).ok()?;
        let period =
            1.05 * found["motions"].as_array()?.iter().find(|motion| motion["stable"] == true)?["period"].as_f64()?;
        Some(Advised::new("steady", files, &[&format!("--period={period:e} s")]))
    };
    let random = random(5300, 6, steady::driven()).map(|scene: MachineScene| steady::files(&scene, &SAME));
    let counts = all([example("rapier_loom/scene.toml")].into_iter().chain(random).filter_map(machine));
    assert!(counts["steady speed"] >= 3, "{counts:?}");
}

#[test]
fn of_solvers() {
    let files = ["transfer_manipulator/scene.toml", "sealing_machine/scene.toml"].map(example);
    let counts = all(files.map(|files| Advised::new("tradeoff", files, &["--quick", "-o", "out"])));
    assert!(counts["tradeoff error"] >= 2, "{counts:?}");
}

/// Of a machine with compensated cams under a load, which stands in no scene.
#[test]
fn of_compensations() {
    let loaded = |scene: compensate::Scene| {
        let load = option("load", scene.load);
        Advised::new("compensate", scene.files(&SAME), &["-o", "cams.toml", "--rounds=0", "--report=out", &load])
    };
    let counts = all(random(5700, 2, compensate::any()).map(loaded));
    assert!(counts["compensate speed"] >= 1, "{counts:?}");
}

/// Drives in the resonance of a harmonic, each of whose calm speeds is set as it is printed.
#[test]
fn of_resonances() {
    let resonant = (super::super::scenes::output(), 3..12_u8).prop_map(|(scene, k)| {
        let natural = f64::from(k) * scene.w.abs();
        let c = scene.m * natural * natural;
        CamScene { c, b: scene.b.max(0.02 * scene.m * natural), ..scene }
    });
    let mut list = Vec::new();
    for scene in random(5800, 30, resonant) {
        let mut files = Files::default();
        let cam = files.law(&scene.law);
        files.scene = json!({
            "name": "random", "model": "ElasticCamDrive", "cam": cam, "drive": {"speed": scene.w},
            "elasticity": {"place": "output", "m": scene.m, "c": scene.c, "b": scene.b}, "start": {"mode": "steady_state"},
        });
        let advised = Advised::new("check", files, &[]);
        let Ok(found) = advised.printed("check", &["--json"]) else { continue };
        for advice in found[0]["verdict"]["advice"].as_array().expect("a list") {
            let text = advice["text"].as_str().expect("a text").replace(',', "");
            let words: Vec<&str> = text.split(' ').collect();
            for pair in words.windows(2).filter(|pair| pair[1] == "rpm" && text.starts_with("Run at ")) {
                let calm = advised.with(&[("drive.speed", pair.join(" ").into())]);
                let there = calm.printed("check", &["--json"]).expect("a check")[0]["warnings"].clone();
                // The law stays as it is.
                let is_of_law =
                    |warning: &Value| warning["message"].as_str().is_some_and(|text| text.starts_with("cam: "));
                assert!(there.as_array().is_some_and(|list| list.iter().all(is_of_law)), "{text} {pair:?}: {there}");
            }
        }
        list.push(advised);
    }
    let counts = all(list);
    assert!(counts["check plausible"] >= 5, "{counts:?}");
}

/// Tables with noise, of a lobe and of a law with dwells.
#[test]
fn of_tables() {
    let table = |(law, noise): (MotionLaw, f64)| {
        let stroke = law.bound(0);
        let lift = |i: usize| {
            let phi = TAU * i as f64 / 360.0;
            // Of all lengths of wave.
            let rough = (1e4 * (1.0 + phi) * (i as f64)).sin();
            format!("{phi};{}\n", law.at(phi).0[0] + noise * stroke * rough)
        };
        let tables = vec![(0..360).map(lift).collect()];
        let scene = json!({
            "name": "random", "model": "ElasticCamDrive", "cam": {"law": "table", "file": "1.csv"},
            "drive": {"speed": 1.0}, "elasticity": {"place": "output", "m": 1.0, "c": 1e4, "b": 20.0},
            "start": {"mode": "steady_state"},
        });
        Advised::new("check", Files { scene, tables, ..Files::default() }, &[])
    };
    let laws = (super::super::scenes::law(), super::super::scenes::decades(-5.0, -3.0));
    let counts = all(random(5600, 10, laws).map(table));
    assert!(counts["check plausible"] >= 3, "{counts:?}");
}

/// Two dwells opposite to each other, of any width.
#[test]
fn of_tasks() {
    let task = |(width, harmonics): (f64, usize)| {
        let dwell = |centre: f64, u: f64| json!({"centre": centre, "width": width, "U": u});
        let scene = json!({
            "name": "random", "harmonics": harmonics, "symmetry": "even_half_wave", "objective": "least_squares",
            "dwell": [dwell(0.0, 0.5), dwell(0.5 * TAU, -0.5)],
        });
        Advised::new("synthesize", Files { scene, ..Files::default() }, &["-o", "profile.toml"])
    };
    let harmonics = prop_oneof![Just(1_usize), Just(3), Just(5)];
    let counts = all(random(5500, 4, (0.8..1.6_f64, harmonics)).map(task));
    assert!(counts["synthesize deviation"] >= 2, "{counts:?}");
}

#[test]
fn of_masters() {
    let counts = all([Advised::new("system", example("two_cams/system.toml"), &["--study", "-o", "out"])]);
    assert!(counts["system error"] >= 1, "{counts:?}");
}
