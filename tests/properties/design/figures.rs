//! What the commands say of one scene is the same, and what its FMU does.

use super::super::limits::root;
use super::super::scenes::{CamScene, Model, backlash, output};
use super::{clearance, forces, stability, steady, *};
use camdrive_design::host::Host;
use camdrive_design::periodic_turn::{from_zero, part};
use camdrive_design::resource::Resource;

/// Figures are the same to this part of the larger one; both are computed by the same function, or are exact to rounding.
const SAME_FIGURE: f64 = 1e-9;

/// What a command of `--json` prints, with its number in a list of files.
fn printed(files: &Files, tool: &str) -> Option<Value> {
    let more: &[&str] = match tool {
        "check" | "steady" => &[],
        "clearance" | "stability" => &["--quick", "-o", "out"],
        _ => &["-o", "out"],
    };
    let arguments: Vec<String> = ["--json"].iter().chain(more).map(|text| (*text).to_owned()).collect();
    let mut found = files.printed(tool, &arguments).ok()?;
    Some(if found.is_array() { found[0].take() } else { found })
}

/// All that the commands say of a scene.
struct Said<'a> {
    files: &'a Files,
    check: Value,
    /// How many figures were compared.
    count: usize,
}

impl Said<'_> {
    fn figure(&self, name: &str) -> Option<f64> {
        self.check["figures"].as_array()?.iter().find(|figure| figure["name"] == name)?["value"].as_f64()
    }

    /// Both are the same, where both are said.
    fn same(&mut self, what: &str, a: Option<f64>, b: Option<f64>) -> Result<(), TestCaseError> {
        if let (Some(a), Some(b)) = (a, b) {
            let close = (a - b).abs() <= SAME_FIGURE * a.abs().max(b.abs()).max(f64::MIN_POSITIVE);
            prop_assert!(close, "{}: {:e} and {:e}", what, a, b);
            self.count += 1;
        }
        Ok(())
    }

    /// A figure of `check`, and what another command says.
    fn figure_is(&mut self, name: &str, other: &Value) -> Result<(), TestCaseError> {
        self.same(name, self.figure(name), other.as_f64())
    }

    /// `steady`: extremes, dwells, resonances, lift-off.
    fn steady(&mut self, steady: &Value) -> Result<(), TestCaseError> {
        for output in steady["turn"]["outputs"].as_array().into_iter().flatten() {
            let (name, j) = part(output["output"].as_str().expect("a name"));
            let called = match name {
                "q" => "largest_deformation",
                "force" => "largest_force",
                "contact_force" => "largest_contact_force",
                "tau" => "largest_torque",
                "M_an" => "largest_motor_torque_on_the_shaft",
                _ => continue,
            };
            let called = if j == 0 { called.to_owned() } else { format!("follower[{j}].{called}") };
            let size = ["least", "largest"].map(|end| output[end].as_f64().expect("a value").abs());
            let size = size[0].max(size[1]);
            // What is zero at rest is no figure of `check`.
            prop_assert!(self.figure(&called).is_some(), "check lacks {}", called);
            self.figure_is(&called, &size.into())?;
        }
        let speed = if self.figure("speed").is_some() { "speed" } else { "mean_speed" };
        if steady["turn"].is_object() {
            self.figure_is(speed, &steady["turn"]["mean_speed"])?;
        }
        if steady["resonances"].as_array().is_some_and(|list| !list.is_empty()) {
            prop_assert_eq!(&self.check["resonances"], &steady["resonances"]);
        }
        if steady["lift_offs"].is_array() {
            prop_assert_eq!(&self.check["lift_offs"], &steady["lift_offs"]);
            self.judges_alike(steady)?;
        }
        Ok(())
    }

    /// `check` and `steady` judge the motion with the same sentences and levels; `check` minds other values, too.
    fn judges_alike(&mut self, steady: &Value) -> Result<(), TestCaseError> {
        let [check, steady] = [&self.check["verdict"], &steady["verdict"]];
        let own = steady["result"].to_string().to_lowercase();
        let message = |warning: &Value| warning["message"].as_str().expect("a message").to_lowercase();
        let mut messages = self.check["warnings"].as_array().expect("warnings").iter().map(message);
        let is_all = messages.all(|message| own.contains(message.trim_end_matches('.')));
        prop_assert!(!is_all || check["level"] == steady["level"], "{} and {}", check, steady);
        self.count += 1;
        Ok(())
    }

    /// `forces`: the load on each tool, speeds of lift-off.
    fn forces(&mut self, found: &Value) -> Result<(), TestCaseError> {
        let drives = found["drives"].as_array().cloned().unwrap_or_default();
        for (j, drive) in drives.iter().enumerate() {
            let of = |name: &str| drive["quantities"].as_array()?.iter().find(|q| q["quantity"] == name).cloned();
            let on_tool = of("tool_load").or_else(|| of("follower_force")).or_else(|| of("lever_torque"));
            let on_tool = on_tool.expect("a load on the tool");
            let size = ["least", "largest"].map(|end| on_tool[end]["value"].as_f64().expect("a value").abs());
            let size: Value = size[0].max(size[1]).into();
            let prefix = [String::new(), format!("follower[{}].", j + 1)];
            for name in prefix.iter().map(|prefix| format!("{prefix}largest_kinetostatic_force")) {
                self.figure_is(&name, &size)?;
            }
        }
        self.lifts_alike(found)?;
        let keeping = drives.iter().filter(|drive| drive["keeping"].is_object());
        let ends: Vec<&Value> = keeping.map(|drive| &drive["keeping"]["lift_off_speed"]).collect();
        let said = self.check["lift_offs"].clone();
        for lift_off in said.as_array().into_iter().flatten() {
            let said = &lift_off["lift_off_speed"];
            prop_assert!(ends.contains(&said), "lift-off: {} is not in {:?}", said, ends);
            self.count += 1;
        }
        Ok(())
    }

    /// `check` and `forces` say of the same followers that they lift off, in the same words.
    fn lifts_alike(&mut self, forces: &Value) -> Result<(), TestCaseError> {
        let [own, other] = [&self.check, forces].map(|found| {
            let all = found["verdict"]["result"].as_array().expect("sentences").iter().filter_map(Value::as_str);
            all.filter(|text| text.contains("lifts off its cam")).map(str::to_owned).collect::<Vec<String>>()
        });
        let alike = own.len() == other.len() && own.iter().zip(&other).all(|(own, other)| own.starts_with(other));
        prop_assert!(alike, "lift-off: {:?} and {:?}", own, other);
        let is_bad = own.is_empty() || self.check["verdict"]["level"] == forces["verdict"]["level"];
        prop_assert!(is_bad, "levels of {:?}", own);
        self.count += own.len();
        Ok(())
    }

    /// `check`, `steady` and `stability` agree on whether there is a motion, and whether it is stable.
    fn motion(&mut self, steady: &Value, stability: Option<&Value>) -> Result<(), TestCaseError> {
        let judged = |found: &Value| found["verdict"]["result"].to_string().to_lowercase();
        let mut said = vec![judged(&self.check), judged(steady)];
        said.extend(stability.map(judged));
        for phrase in [
            "must not run",
            "turns differ",
            "neither grow nor decay: the start never settles",
            "a floquet multiplier is 1",
            "the motion does not repeat within",
            "stands still",
            "follows an input",
        ] {
            let of = said.iter().map(|text| text.contains(phrase)).collect::<Vec<_>>();
            prop_assert!(of.iter().all(|says| *says == of[0]), "{} is said by {:?} of {:?}", phrase, of, said);
        }
        // The linear equation of `stability` ends at a smaller angle.
        let far = said.iter().map(|text| text.contains("more than half a turn")).collect::<Vec<_>>();
        let is_told = said.get(2).is_none_or(|text| text.contains("does not hold there"));
        prop_assert!(far[0] == far[1] && (!far[0] || far.get(2) == Some(&true) || is_told), "{:?}", said);
        let motion = &steady["motions"][0];
        let (exists, stable) = (motion.is_object(), motion["stable"] == true);
        let Some(at) = stability.map(|found| &found["speeds"][0]).filter(|at| at.is_object()) else { return Ok(()) };
        match (at["nonlinear"].as_str(), exists) {
            (Some(kind), true) => prop_assert_eq!(kind, if stable { "stable" } else { "unstable" }),
            (Some(kind), false) => prop_assert_eq!(kind, "none"),
            (None, true) => {
                let [radius, growth] =
                    [&at["radius"], &motion["growth"]].map(|value| value.as_f64().unwrap_or(f64::NAN));
                prop_assert!((radius.ln() - growth).abs() <= 1e-6 * growth.abs().max(1.0), "{} and {}", radius, growth);
                prop_assert_eq!(stable, radius < 1.0 + 1e-9);
            }
            (None, false) => prop_assert!(said[2].contains("no periodic motion exists"), "{}", said[2]),
        }
        self.count += 1;
        Ok(())
    }

    fn compare(&mut self) -> Result<(), TestCaseError> {
        let stability = printed(self.files, "stability");
        if let Some(found) = printed(self.files, "steady") {
            self.steady(&found)?;
            self.motion(&found, stability.as_ref())?;
        }
        if let Some(found) = printed(self.files, "forces") {
            self.forces(&found)?;
        }
        if let Some(found) = stability {
            self.figure_is("natural_frequency", &found["oscillator"]["natural_frequency"])?;
            self.figure_is("damping_ratio", &found["oscillator"]["damping_ratio"])?;
            let here = &found["transients"][0]["steady"];
            let torque =
                self.figure("largest_kinetostatic_torque").or_else(|| self.figure("largest_kinetostatic_force"));
            self.same("kinetostatic load", torque, here["kinetostatic"].as_f64())?;
        }
        if let Some(found) = printed(self.files, "clearance") {
            self.figure_is("speed", &found["machine"]["speed"])?;
            self.figure_is("natural_frequency", &found["machine"]["omega"])?;
            self.figure_is("clearance", &found["machine"]["s"])?;
            self.figure_is("stroke", &found["laws"][0]["stroke"])?;
        }
        Ok(())
    }

    /// The page has each figure as `check` shows it, and one verdict that is none better than those of all commands.
    fn page(&mut self) -> Result<(), TestCaseError> {
        let shown = self.files.run("check", &[]).map_err(TestCaseError::fail)?.0;
        let (_, folder) =
            self.files.run("report", &["-o", "page.html"].map(str::to_owned)).map_err(TestCaseError::fail)?;
        let page = read(&folder, "page.html");
        let from = shown.find("Characteristic values").expect("the values");
        for line in shown[from..].lines().skip(3).take_while(|line| line.starts_with("  ")) {
            let cells: Vec<&str> = line.split("  ").map(str::trim).filter(|cell| !cell.is_empty()).collect();
            let [name, value, ..] = cells[..] else { continue };
            let cell = format!(">{}<", value.replace('\u{a0}', " "));
            prop_assert!(page.replace('\u{a0}', " ").contains(&cell), "{}: {} is not on the page", name, value);
            self.count += 1;
        }
        Ok(())
    }
}

/// The FMU has the extremes where `steady` says them, and none beyond, to this part.
fn fmu_agrees(resource: &Resource, steady: &Value) -> Result<usize, TestCaseError> {
    let mut resource = resource.clone();
    let Some(w) = steady["turn"]["mean_speed"].as_f64().filter(|_| resource.scene.drive().is_some()) else {
        return Ok(0);
    };
    resource.scene = from_zero(&resource.scene, None).expect("a speed");
    let fail = |fault: camdrive::drives::Fault| TestCaseError::fail(fault.to_string());
    let outputs = steady["turn"]["outputs"].as_array().expect("outputs");
    let value = |output: &Value, key: &str| output[key].as_f64().expect("a number");
    let mut instants = Vec::new();
    for (i, output) in outputs.iter().enumerate() {
        for [end, at] in [["least", "least_at"], ["largest", "largest_at"]] {
            let turned = (value(output, at) * w.signum()).rem_euclid(TAU) / w.abs();
            instants.push((turned, Some((i, value(output, end)))));
        }
    }
    instants.extend((1..=500).map(|k| (TAU / w.abs() * f64::from(k) / 500.0, None)));
    instants.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut host = Host::instantiate(&resource).map_err(fail)?;
    let place = |host: &Host, name: &str| host.description().find(name);
    host.set_up(0.0, None, None).map_err(fail)?;
    if let Some(tolerance) = place(&host, "solver.tolerance") {
        host.set(tolerance, 1e-13).map_err(fail)?;
    }
    let mode = place(&host, "start.mode").expect("a mode of the start");
    let items = &resource.build().map_err(fail)?;
    let of = items.descriptions().iter().find(|d| d.name == "start.mode").expect("a mode of the start");
    let camdrive::drives::variable::Kind::Enumeration(kind) = &of.kind else { unreachable!() };
    let Some(item) = kind.items.iter().position(|(name, _)| *name == "steady_state") else { return Ok(0) };
    host.set(mode, 1.0 + item as f64).map_err(fail)?;
    host.enter_initialization().map_err(fail)?;
    let is_unstable = steady["motions"][0]["stable"] == false;
    let started = host.exit_initialization().map_err(fail);
    prop_assert_eq!(started.is_err(), is_unstable, "started on {}: {:?}", steady["motions"], started);
    if is_unstable {
        return Ok(1);
    }
    let (mut time, mut count) = (0.0, 0);
    for (instant, extreme) in instants {
        if instant > time {
            host.do_step(time, instant - time).map_err(fail)?;
            time = instant;
        }
        for (i, output) in outputs.iter().enumerate() {
            let name = output["output"].as_str().expect("a name");
            let place = place(&host, name).expect("an output");
            let got = host.get(place).map_err(fail)?;
            let [least, largest] = ["least", "largest"].map(|end| value(output, end));
            let miss = SAME_FIGURE * least.abs().max(largest.abs());
            prop_assert!(
                got >= least - miss && got <= largest + miss,
                "{} of the FMU: {:e} at {:e} s",
                name,
                got,
                time
            );
            if let Some((_, expected)) = extreme.filter(|(of, _)| *of == i) {
                prop_assert!((got - expected).abs() <= miss, "{} of the FMU: {:e} for {:e}", name, got, expected);
                count += 1;
            }
        }
    }
    Ok(count)
}

/// Compares all that is said of a scene; the number of figures that were the same.
fn agree(files: &Files, resource: &Resource, page: bool) -> Result<usize, TestCaseError> {
    let check = printed(files, "check").filter(|found| found["ok"] == true);
    let check = check.ok_or_else(|| TestCaseError::reject("the scene is refused"))?;
    let mut said = Said { files, check, count: 0 };
    said.compare()?;
    if page {
        said.page()?;
    }
    let fmu = printed(files, "steady").map_or(Ok(0), |steady| fmu_agrees(resource, &steady))?;
    Ok(said.count + fmu)
}

/// An elastic output with loads on its tool, alone or in a train.
fn loaded() -> impl Strategy<Value = Files> {
    let load = [0.0..2.0_f64, 0.0..0.5_f64, -1.0..1.0_f64, 0.0..0.2_f64];
    let slow = output().prop_filter("few vibrations in a turn", |scene: &CamScene| {
        let natural = (scene.c / scene.m).sqrt();
        natural < 40.0 * scene.w.abs() && scene.b > 0.02 * natural * scene.m
    });
    (slow, load, any::<[bool; 2]>()).prop_map(|(scene, [preload, stiffness, gravity, damping], [acts, train])| {
        let mut files = Files::default();
        let cam = files.law(&scene.law);
        let force = scene.m * scene.law.bound(2) * scene.w * scene.w;
        let mut follower = json!({
            "cam": cam, "elasticity": {"place": "output", "m": scene.m, "c": scene.c, "b": scene.b},
        });
        if acts {
            follower["load"] = json!({
                "spring": {"preload": preload * force, "c": stiffness * scene.c}, "damping": damping * scene.b,
                "gravity": gravity * force / scene.m,
            });
        }
        let drive = json!({"speed": scene.w});
        files.scene = if train {
            follower["elasticity"].as_object_mut().expect("a table").remove("place");
            json!({"name": "random", "model": "DriveTrain", "drive": drive, "follower": [follower]})
        } else {
            follower["name"] = "random".into();
            follower["model"] = "ElasticCamDrive".into();
            follower["drive"] = drive;
            follower
        };
        files
    })
}

/// Scenes of every model.
fn any_files() -> impl Strategy<Value = Files> {
    let shafts = (stability::any(), 0..3).prop_map(|(scene, undamped)| {
        let mut files = stability::files(&scene, &SAME);
        for section in ["elasticity", "coefficients", "crank"] {
            if let Some(section) = files.scene.get_mut(section).filter(|_| undamped == 0) {
                let section = section.as_object_mut().expect("a table");
                for key in ["damping_ratio", "b", "b_T"] {
                    section.remove(key);
                }
            }
        }
        files
    });
    let plays = backlash().prop_map(|scene| CamScene {
        model: Model::Backlash,
        b: scene.b.max(0.1 * (scene.c * scene.second).sqrt()),
        ..scene
    });
    let plays = plays.prop_map(|scene| clearance::files(&scene, &SAME));
    let machines = steady::driven().prop_map(|scene| steady::files(&scene, &SAME));
    let tappets = (forces::any(), any::<bool>()).prop_map(|(scene, rigid)| forces::tappet(&scene, rigid));
    prop_oneof![3 => loaded(), 2 => shafts, 1 => plays, 1 => machines, 2 => tappets]
}

/// Seen to find a natural frequency without the return spring, and a force without the preload.
#[test]
fn of_random_scenes() {
    for_all(900, 100, any_files(), |files| {
        let resource = files.resolved().map_err(TestCaseError::reject)?.resource();
        let count = agree(files, &resource, false)?;
        if count == 0 { Err(TestCaseError::reject("nothing to compare")) } else { Ok(()) }
    });
}

/// The same for all examples, with their pages.
#[test]
fn of_the_examples() {
    let (mut count, mut failures) = (0, String::new());
    for folder in std::fs::read_dir(root().join("examples")).expect("the examples") {
        let folder = folder.expect("a folder").path();
        let Ok(scene) = scene::read(&folder.join("scene.toml")) else { continue };
        let files = Files { folder: folder.display().to_string(), ..Files::default() };
        match agree(&files, &scene.resource(), true) {
            Ok(same) => count += same,
            Err(reason) => failures += &format!("{}: {reason}\n", scene.name),
        }
    }
    assert!(failures.is_empty(), "{failures}");
    assert!(count >= 200, "{count} figures");
}
