//! The published interface of the FMUs: golden files, and what the description says against what the drive does.

use camdrive::drives::variable::{Causality, Kind, Variability};
use camdrive::drives::{AnyDrive, Description, MODELS};
use camdrive_cli::export;
use camdrive_cli::export::documentation::{self, Page};
use camdrive_cli::scene::{self, Resolved};
use camdrive_design::resource::Described;
use std::path::{Path, PathBuf};

/// The folder of the workspace.
fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap()
}

/// The scenes beside the golden files, by name.
fn scenes() -> Vec<(PathBuf, Resolved)> {
    let folder = root().join("modelDescription");
    let mut paths: Vec<PathBuf> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    paths.retain(|path| path.extension().is_some_and(|e| e == "toml"));
    paths.sort();
    assert!(!paths.is_empty());
    paths
        .into_iter()
        .map(|path| {
            let scene = scene::read(&path).unwrap_or_else(|faults| panic!("{faults}"));
            (path, scene)
        })
        .collect()
}

fn build(scene: &Resolved) -> Described {
    scene.resource().build().unwrap()
}

fn descriptions(drive: &AnyDrive) -> Vec<Description> {
    drive.descriptions().to_vec()
}

#[test]
fn the_golden_files_are_what_the_library_writes() {
    let bless = std::env::var_os("BLESS").is_some_and(|v| v == "1");
    let mut stale = Vec::new();
    for (path, scene) in scenes() {
        let xml = export::describe(&scene.resource(), &scene.description).unwrap();
        let golden = path.with_extension("xml");
        if bless {
            std::fs::write(&golden, xml).unwrap();
        } else if std::fs::read_to_string(&golden).ok().as_ref() != Some(&xml) {
            stale.push(golden);
        }
    }
    assert!(
        stale.is_empty(),
        "differ: {stale:#?}\nrenew by: BLESS=1 cargo test -p camdrive-cli --test suite model_description"
    );
}

#[test]
fn every_model_describes_itself_where_the_scene_does_not() {
    for (path, scene) in scenes() {
        let xml = export::describe(&scene.resource(), "").unwrap();
        let own = xml.split(" description=\"").nth(1).unwrap().split('"').next().unwrap();
        let summary = build(&scene).documentation().unwrap().summary;
        assert!(own.ends_with('.') && (20..200).contains(&own.len()) && summary.starts_with(own), "{path:?}: {own}");
    }
}

#[test]
fn every_model_has_a_golden_file() {
    let scenes = scenes();
    for model in MODELS {
        assert!(scenes.iter().any(|(_, scene)| scene.scene.model() == model.name), "{}", model.name);
    }
}

#[test]
fn names_units_and_experiments_keep_the_rules() {
    for (path, scene) in scenes() {
        let drive = build(&scene);
        let list = descriptions(&drive);
        for (i, d) in list.iter().enumerate() {
            let place = format!("{}: {}", path.display(), d.name);
            assert!(d.name.is_ascii() && d.name.len() <= 40 && d.name != "time", "{place}");
            assert!(!list[..i].iter().any(|other| other.name == d.name), "{place}: twice");
            assert!(!d.text.is_empty() && !d.text.ends_with('.'), "{place}: description");
            if let Kind::Real { quantity, min, max, .. } = d.kind {
                assert!(!quantity.name.is_empty(), "{place}: quantity");
                if d.causality == Causality::Parameter {
                    assert!(min.is_finite() && max.is_finite(), "{place}: range");
                }
            } else {
                assert_ne!(d.variability, Variability::Continuous, "{place}");
            }
            if let Some(name) = &d.derivative_of {
                let base = list.iter().find(|other| other.name == *name).unwrap_or_else(|| panic!("{place}: {name}"));
                let (Kind::Real { quantity: q, .. }, Kind::Real { quantity: q_dot, .. }) = (&base.kind, &d.kind) else {
                    panic!("{place}: derivative of what is not real")
                };
                let [kg, m, s, rad] = q.base;
                assert_eq!(q_dot.base, [kg, m, s - 1, rad], "{place}: unit");
            }
            if d.state {
                let has_derivative = list.iter().any(|other| other.derivative_of.as_ref() == Some(&d.name));
                assert!(has_derivative, "{place}: no variable is its derivative");
            }
        }
        let e = drive.experiment();
        assert!(e.stop / e.step <= 1000.0 + 1e-9, "{}: {} steps", path.display(), e.stop / e.step);
        let nanoseconds = 1e9 * e.step;
        assert!((nanoseconds - nanoseconds.round()).abs() < 1e-6 * nanoseconds.min(1.0), "{}", path.display());
    }
}

#[test]
fn what_is_named_a_derivative_is_marked_as_one() {
    let linked = root().join("tests/fmpy/scenes/machine_linkage.toml");
    let mut count = 0;
    for (path, scene) in scenes().into_iter().chain([(linked.clone(), scene::read(&linked).unwrap())]) {
        let list = descriptions(&build(&scene));
        let xml = export::describe(&scene.resource(), &scene.description).unwrap();
        for d in list.iter().filter(|d| d.name.starts_with("der(") && d.causality == Causality::Output) {
            let inner = d.name["der(".len()..].trim_end_matches(')');
            let base = inner.strip_suffix(",2").map_or(inner.to_owned(), |once| format!("der({once})"));
            let index = list.iter().position(|other| other.name == base).unwrap() + 1;
            let variable = &xml[xml.find(&format!("<ScalarVariable name=\"{}\"", d.name)).unwrap()..];
            let real = &variable[..variable.find("</ScalarVariable>").unwrap()];
            assert!(real.contains(&format!("derivative=\"{index}\"")), "{}: {real}", path.display());
            count += 1;
        }
    }
    assert!(count > 40, "{count}");
}

#[test]
fn the_documentation_is_complete_and_well_formed() {
    for (path, scene) in scenes() {
        let mut drive = build(&scene);
        let documentation = drive.documentation().unwrap();
        let place = path.display();
        assert!(!documentation.summary.is_empty() && !documentation.equations.is_empty(), "{place}");
        assert!(
            !documentation.accuracy.is_empty() && !documentation.limits.is_empty() && !documentation.sources.is_empty(),
            "{place}"
        );
        assert!(!drive.curves().is_empty(), "{place}: no picture");
        assert!(!documentation.left_out.is_empty(), "{place}");
        let page = Page { description: &scene.description, ..Page::default() };
        let page = documentation::html(&scene.resource(), &mut drive, &page).unwrap();
        assert_well_formed(&page, &place.to_string());
        // Each formula once, and nothing about what this drive has not.
        assert_eq!(page.matches("class=\"formula\"").count(), documentation.equations.len(), "{place}");
        assert!(!page.contains("no such") && !page.contains("<math"), "{place}");
        // All digits of a number are those of a platform, and the guid is a hash of the page.
        assert!(!page.contains(" data-v="), "{place}");
    }
}

fn assert_well_formed(page: &str, place: &str) {
    use quick_xml::events::Event;
    let mut reader = quick_xml::Reader::from_str(page);
    loop {
        // The reader itself compares the names of the tags.
        match reader.read_event() {
            Ok(Event::Eof) => return,
            Ok(Event::GeneralRef(entity)) => {
                let known = ["lt", "gt", "amp", "quot", "apos"];
                assert!(known.contains(&&*entity) || entity.starts_with('#'), "{place}: {entity:?}");
            }
            Ok(_) => {}
            Err(e) => panic!("{place}: {e} at byte {}", reader.error_position()),
        }
    }
}

/// The names that users and importers rely on, per golden file of a published model: inputs | outputs | parameters. There may
/// be more outputs and parameters, but no further inputs.
const NAMES: [(&str, &str, &str, &str); 19] = [
    ("ElasticCamDrive.output.constant", "", "x y der(y) der(y,2) q der(q) force tau phi w", "m c b"),
    ("ElasticCamDrive.output.input", "phi w a", "x y der(y) der(y,2) q der(q) force tau", "m c b"),
    ("ElasticCamDrive.shaft.constant", "", "q der(q) psi y der(y) tau phi w", "m J c b shaft.linear"),
    ("ElasticCamDrive.shaft.input", "phi w a", "q der(q) psi y der(y) tau", "m J c b shaft.linear"),
    ("BacklashDrive.constant", "", BACKLASH, "m1 m2 c b s e"),
    ("BacklashDrive.input", "phi w a", BACKLASH, "m1 m2 c b s e"),
    ("BacklashDrive.loads", "phi w a F", BACKLASH, "m1 m2 c b s e load.g load.b load.roller.F0 cam.a[1]"),
    (
        "ParametricDrive.crank.constant",
        "",
        "phi w psi der(psi) der(psi,2) q der(q) tau growth",
        "J c_T1 c_T2 c_AB R b_T second.angle f.a[0]",
    ),
    (
        "ParametricDrive.crank.input",
        "phi w a",
        "psi der(psi) der(psi,2) q der(q) tau stiffness",
        "J c_T1 c_T2 c_AB R b_T",
    ),
    (
        "ParametricDrive.series.constant",
        "",
        "phi w q der(q) der(q,2) tau stiffness growth",
        "m.a[0] m.b[2] b.a[1] c.a[3] f.b[1]",
    ),
    (
        "ParametricDrive.loads",
        "phi w a F",
        "q der(q) der(q,2) force stiffness",
        "m.a[0] load.g load.F0 load.preload load.c load.at load.b load.process.scale",
    ),
    ("ParametricDrive.series.input", "phi w a", "q der(q) der(q,2) force stiffness", "m.a[0] b.a[0] c.a[2]"),
    ("RigidMachine.kloss", "tau", "phi w a M_an J E U[1] der(U[1]) der(U[1],2)", "motor.M_k motor.s_k motor.w_s J0"),
    ("RigidMachine.input", "tau M_an", "phi w a J E U[1] der(U[1]) der(U[1],2)", "J0 phi_start w_start"),
    ("RigidMachine.none", "tau", "phi w a J E U[1] der(U[1]) der(U[1],2)", "J0 follower[1].m follower[1].cam.a[0]"),
    (
        "RigidMachine.loads",
        "tau follower[1].F",
        "phi w a M_an J E U[1] der(U[1]) der(U[1],2) U[2] follower[1].force follower[1].tau",
        "J0 load.b motor.i motor.J follower[1].m follower[2].cam.a[1] follower[1].load.c phi_start w_start",
    ),
    (
        "DriveTrain.motor",
        "",
        "phi w a M_an J E motor.phi motor.w follower[1].U follower[1].y der(follower[1].y) follower[1].q follower[1].force \
         follower[1].tau follower[2].psi",
        "J0 motor.M_k motor.T_el motor.i motor.J motor.c motor.b load.M.a[1] load.b follower[1].m_roller follower[3].load.g \
         follower[3].load.preload follower[3].load.b follower[2].J follower[3].m phi_start w_start",
    ),
    (
        "DriveTrain.servo",
        "tau w_ref phi_ref",
        "phi w a M_an J E motor.saturated follower[1].U follower[1].tau",
        "motor.K_p motor.K_i motor.K_aw motor.M_max motor.K_v follower[1].m follower[1].crank.offset",
    ),
    (
        "DriveTrain.input",
        "phi w a follower[3].F",
        "follower[1].y follower[2].x1 follower[2].gap follower[2].contact follower[2].impulse follower[2].impacts follower[2].tau_mean",
        "follower[1].m follower[1].c follower[2].m1 follower[2].s follower[2].cam.a[1]",
    ),
];
const BACKLASH: &str = "x1 der(x1) y der(y) q gap contact force force_mean impulse impacts energy_loss tau tau_mean";

#[test]
fn names_are_those_that_importers_rely_on() {
    let scenes = scenes();
    for (file, inputs, outputs, parameters) in NAMES {
        let of_file = |(path, _): &&(PathBuf, Resolved)| path.file_stem().is_some_and(|stem| stem == file);
        let (_, scene) = scenes.iter().find(of_file).unwrap_or_else(|| panic!("{file}"));
        let list = descriptions(&build(scene));
        let of = |causality| {
            let chosen = list.iter().filter(move |d| d.causality == causality);
            chosen.map(|d| d.name.as_str()).collect::<Vec<_>>()
        };
        assert_eq!(of(Causality::Input), inputs.split_whitespace().collect::<Vec<_>>(), "{file}");
        let constant = if file.ends_with(".constant") { "drive.w drive.phi_start" } else { "" };
        // Where a closed form is at rounding level anyway there is none.
        let closed = ["ElasticCamDrive.output.constant", "BacklashDrive.constant"];
        let tolerance = if closed.contains(&file) { "" } else { "solver.tolerance" };
        assert!(!tolerance.is_empty() || !of(Causality::Parameter).contains(&"solver.tolerance"), "{file}");
        let cam = if file.starts_with("Rigid") || file.starts_with("DriveTrain") {
            "start.mode"
        } else {
            "start.mode start.q start.q_dot"
        };
        for (causality, names) in [
            (Causality::Output, outputs),
            (Causality::Parameter, parameters),
            (Causality::Parameter, constant),
            (Causality::Parameter, cam),
            (Causality::Parameter, tolerance),
            (Causality::Local, "solver.steps solver.evaluations solver.error_estimate"),
        ] {
            for name in names.split_whitespace() {
                assert!(of(causality).contains(&name), "{file}: no {causality:?} `{name}`");
            }
        }
    }
}

/// The array that a name belongs to with its index, for each of its brackets: `der(U[2],2)` is in `der(U[],2)`.
fn arrays(name: &str) -> Vec<(String, usize)> {
    let outer = if name.starts_with("der(") { &name[name.find([',', ')']).unwrap()..] } else { "" };
    let brackets = name.match_indices('[').map(|(at, _)| {
        let index = name[at + 1..].split(']').next().unwrap();
        (format!("{}[]{outer}", &name[..at]), index.parse().unwrap())
    });
    brackets.collect()
}

#[test]
fn the_elements_of_an_array_follow_one_another() {
    // FMI 2.0, section 2.2.9: "All array elements are given in a consecutive sequence of ScalarVariables."
    let folder = root();
    let linked = scene::read(&folder.join("tests/fmpy/scenes/machine_linkage.toml")).unwrap();
    for (path, scene) in scenes().into_iter().chain([(PathBuf::from("machine_linkage"), linked)]) {
        let list = descriptions(&build(&scene));
        let arrays: Vec<_> = list.iter().map(|d| arrays(&d.name)).collect();
        for (array, _) in arrays.iter().flatten() {
            let of = |place: &Vec<(String, usize)>| place.iter().find(|(name, _)| name == array).map(|(_, i)| *i);
            let stretch = arrays.iter().map(of).skip_while(Option::is_none).take_while(Option::is_some).flatten();
            let stretch: Vec<usize> = stretch.collect();
            assert_eq!(stretch.len(), arrays.iter().filter_map(of).count(), "{}: {array}", path.display());
            assert!(stretch.is_sorted(), "{}: {array}", path.display());
        }
    }
}

/// Numbers in [−1, 1), the same in every run (the generator of Knuth's MMIX).
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
}

/// Positions of the variables that the condition picks.
fn positions(list: &[Description], condition: impl Fn(&Description) -> bool) -> Vec<usize> {
    (0..list.len()).filter(|&i| condition(&list[i])).collect()
}

fn set_inputs(drive: &mut AnyDrive, inputs: &[usize], random: &mut Random) {
    for &input in inputs {
        drive.set(input, 10.0 * random.next()).unwrap();
    }
}

#[test]
fn dependencies_are_those_of_the_directional_derivatives() {
    let mut faults = Vec::new();
    for (path, scene) in scenes() {
        let mut drive = build(&scene);
        let list = descriptions(&drive);
        let inputs = positions(&list, |d| d.causality == Causality::Input);
        let knowns = positions(&list, |d| d.causality == Causality::Input || d.state);
        let is_derivative_of_state =
            |d: &Description| list.iter().any(|s| s.state && d.derivative_of.as_ref() == Some(&s.name));
        let unknowns = positions(&list, |d| d.causality == Causality::Output || is_derivative_of_state(d));
        let (continuous, discrete): (Vec<usize>, Vec<usize>) =
            unknowns.into_iter().partition(|&u| list[u].variability == Variability::Continuous);
        let mut seen = vec![vec![false; knowns.len()]; continuous.len()];
        let step = 3.7 * drive.experiment().step;
        let mut random = Random(1);
        let switches = positions(&list, |d| d.causality == Causality::Parameter && d.kind == Kind::Boolean);
        for round in 0..200 {
            // A switch may be thrown without a new model description.
            let i = round % 100;
            if i == 0 {
                drive.reset();
                drive.set_up(0.0, None);
                for &switch in &switches {
                    drive.set(switch, f64::from(round / 100)).unwrap();
                }
                set_inputs(&mut drive, &inputs, &mut random);
                drive.start().unwrap();
            }
            for (column, &k) in knowns.iter().enumerate() {
                let derivatives = drive.directional_derivatives(&continuous, &[(k, 1.0)]).unwrap();
                for (row, derivative) in derivatives.into_iter().enumerate() {
                    seen[row][column] |= derivative != 0.0;
                }
            }
            drive.advance(f64::from(i) * step, step).unwrap();
            // What of the discrete outputs moves when an input is set must be declared.
            for &input in &inputs {
                let values =
                    |drive: &mut AnyDrive| -> Vec<f64> { discrete.iter().map(|&u| drive.get(u).unwrap()).collect() };
                let before = values(&mut drive);
                drive.set(input, 10.0 * random.next()).unwrap();
                for ((&u, before), after) in discrete.iter().zip(before).zip(values(&mut drive)) {
                    if differ(before, after) && !list[u].dependencies.contains(&list[input].name) {
                        let (path, name, input) = (path.display(), &list[u].name, &list[input].name);
                        faults.push(format!("{path}: `{name}` depends on `{input}`"));
                    }
                }
            }
        }
        for (row, &u) in continuous.iter().enumerate() {
            let found: Vec<&str> =
                (0..knowns.len()).filter(|&c| seen[row][c]).map(|c| list[knowns[c]].name.as_str()).collect();
            let mut told: Vec<&str> = list[u].dependencies.iter().map(String::as_str).collect();
            told.sort_by_key(|name| list.iter().position(|d| d.name == *name));
            if told != found {
                let (path, name) = (path.display(), &list[u].name);
                faults.push(format!("{path}: dependencies of `{name}`: declared {told:?}, found {found:?}"));
            }
        }
    }
    faults.dedup();
    assert!(faults.is_empty(), "\n{}", faults.join("\n"));
}

/// Whether two values differ by more than rounding.
fn differ(a: f64, b: f64) -> bool {
    (a - b).abs() > 1e-9 * (a.abs() + b.abs())
}

/// The unknowns of the initialisation.
fn initial_unknowns(list: &[Description]) -> Vec<usize> {
    positions(list, |d| d.causality == Causality::Output || d.state || d.derivative_of.is_some())
}

/// Before the start: inputs of random values, a vibration, and the sample-th choice of all enumerations and switches.
fn prepare(drive: &mut AnyDrive, list: &[Description], sample: usize, random: &mut Random) {
    drive.reset();
    drive.set_up(0.0, None);
    let mut choices = sample;
    for (reference, d) in list.iter().enumerate().filter(|(_, d)| d.causality == Causality::Parameter) {
        let options = match d.kind {
            Kind::Enumeration(e) => e.items.len(),
            Kind::Boolean => 2,
            _ => 0,
        };
        if 0 < options {
            let first = usize::from(d.kind != Kind::Boolean);
            drive.set(reference, (first + choices % options) as f64).unwrap();
            choices /= options;
        }
        // At rest relative to the cam some forces vanish and with them what they depend on.
        if d.name == "start.q" || d.name == "start.q_dot" {
            drive.set(reference, 1e-3).unwrap();
        }
        // Where w alone is an input, φ is as random as it is among inputs, and what the speed presses as large as what springs do.
        if list[0].name == "w" {
            match &*d.name {
                "drive.phi_start" => drive.set(reference, 10.0 * random.next()).unwrap(),
                "start.q" if sample % 8 < 4 => drive.set(reference, 1e-6).unwrap(),
                _ => {}
            }
        }
    }
    set_inputs(drive, &positions(list, |d| d.causality == Causality::Input), random);
}

/// The start values; none where there is no start, as a steady state need not exist.
fn start_values(drive: &mut AnyDrive, unknowns: &[usize]) -> Option<Vec<f64>> {
    unknowns.iter().map(|&u| drive.get(u).ok()).collect()
}

/// Values that differ from the present one and that the range admits.
fn others(d: &Description, value: f64, random: &mut Random) -> Vec<f64> {
    match d.kind {
        Kind::Enumeration(e) => (1..=e.items.len()).map(|n| n as f64).filter(|n| *n != value).collect(),
        Kind::Boolean => vec![1.0 - value],
        Kind::Integer { .. } => panic!("`{}`: no drive has such a parameter", d.name),
        Kind::Real { quantity, min, max, .. } => {
            let size = if value == 0.0 { 0.1 * quantity.usual() } else { 0.1 * value.abs() };
            [value + size * random.next(), value - size * random.next()].map(|other| other.clamp(min, max)).to_vec()
        }
    }
}

#[test]
fn initial_dependencies_are_those_of_the_initialisation() {
    let mut faults = Vec::new();
    for (path, scene) in scenes() {
        let mut drive = build(&scene);
        let list = descriptions(&drive);
        let knowns = positions(&list, |d| matches!(d.causality, Causality::Input | Causality::Parameter));
        let unknowns = initial_unknowns(&list);
        let mut seen = vec![vec![false; knowns.len()]; unknowns.len()];
        let mut random = Random(2);
        for sample in 0..36 {
            prepare(&mut drive, &list, sample, &mut random);
            let Some(before) = start_values(&mut drive, &unknowns) else { continue };
            for (column, &known) in knowns.iter().enumerate() {
                let value = drive.get(known).unwrap();
                let others = if list[known].causality == Causality::Input {
                    (0..4).map(|_| 10.0 * random.next()).collect()
                } else {
                    others(&list[known], value, &mut random)
                };
                for other in others {
                    drive.set(known, other).unwrap();
                    if let Some(after) = start_values(&mut drive, &unknowns) {
                        for row in 0..unknowns.len() {
                            seen[row][column] |= differ(before[row], after[row]);
                        }
                    }
                }
                drive.set(known, value).unwrap();
            }
        }
        for (row, &u) in unknowns.iter().enumerate() {
            let place = format!("{}: `{}`", path.display(), list[u].name);
            for (column, &k) in knowns.iter().enumerate() {
                let (told, found) = (list[u].depends_initially_on(&list[k]), seen[row][column]);
                if found && !told {
                    faults.push(format!("{place} depends on `{}` at the start", list[k].name));
                }
                // Of a group of parameters some may not matter; inputs are told one by one.
                if told && !found && list[k].causality == Causality::Input {
                    faults.push(format!("{place} does not depend on `{}` at the start", list[k].name));
                }
            }
        }
    }
    assert!(faults.is_empty(), "\n{}", faults.join("\n"));
}

#[test]
fn directional_derivatives_are_limits_of_differences() {
    for (path, scene) in scenes() {
        let mut drive = build(&scene);
        let list = descriptions(&drive);
        let inputs = positions(&list, |d| d.causality == Causality::Input);
        let states = positions(&list, |d| d.state);
        // Importers ask for a row of all outputs at once; the standard excludes other types than Real only.
        let outputs = positions(&list, |d| d.causality == Causality::Output && matches!(d.kind, Kind::Real { .. }));
        let mut random = Random(3);
        drive.set_up(0.0, None);
        set_inputs(&mut drive, &inputs, &mut random);
        drive.start().unwrap();
        let step = 3.7 * drive.experiment().step;
        for i in 0..20 {
            drive.advance(f64::from(i) * step, step).unwrap();
            set_inputs(&mut drive, &inputs, &mut random);
            for &input in &inputs {
                let value = drive.get(input).unwrap();
                let state: Vec<f64> = states.iter().map(|&s| drive.get(s).unwrap()).collect();
                // The error of a central difference is least where truncation ∝ ε² meets rounding ∝ 1/ε.
                let epsilon = 1e-5;
                let mut at = |value: f64| -> (Vec<f64>, bool) {
                    drive.set(input, value).unwrap();
                    let held = states.iter().zip(&state).all(|(&s, before)| drive.get(s).unwrap() == *before);
                    (outputs.iter().map(|&o| drive.get(o).unwrap()).collect(), held)
                };
                let ((above, held_above), (below, held_below)) = (at(value + epsilon), at(value - epsilon));
                let (centre, _) = at(value);
                // A mass in contact is carried along by the flank; then the states are not held.
                if !(held_above && held_below) {
                    continue;
                }
                let derivatives = drive.directional_derivatives(&outputs, &[(input, 1.0)]).unwrap();
                for (n, (&output, derivative)) in outputs.iter().zip(derivatives).enumerate() {
                    let difference = (above[n] - below[n]) / (2.0 * epsilon);
                    let scale = difference.abs() + centre[n].abs() + 1e-9;
                    assert!(
                        (derivative - difference).abs() < 1e-5 * scale,
                        "{}: ∂{}/∂{} = {derivative}, difference {difference}",
                        path.display(),
                        list[output].name,
                        list[input].name
                    );
                }
            }
        }
    }
}

#[test]
fn before_the_start_directional_derivatives_are_limits_of_differences() {
    for (path, scene) in scenes() {
        let mut drive = build(&scene);
        let list = descriptions(&drive);
        let knowns = positions(&list, |d| {
            // A tolerance makes rounding errors; they have no derivative.
            matches!(d.causality, Causality::Input | Causality::Parameter)
                && matches!(d.kind, Kind::Real { .. })
                && !d.name.starts_with("solver.")
        });
        let mut unknowns = initial_unknowns(&list);
        unknowns.retain(|&u| matches!(list[u].kind, Kind::Real { .. }));
        let start = list.iter().position(|d| d.name == "start.mode");
        for mode in 1..=if start.is_some() { 3 } else { 1 } {
            drive.reset();
            drive.set_up(0.0, None);
            set_inputs(&mut drive, &positions(&list, |d| d.causality == Causality::Input), &mut Random(4));
            if start.is_some_and(|start| drive.set(start, f64::from(mode)).is_err())
                || start_values(&mut drive, &unknowns).is_none()
            {
                continue;
            }
            for &known in &knowns {
                let Kind::Real { quantity, min, max, .. } = list[known].kind else { continue };
                let value = drive.get(known).unwrap();
                // The error of a central difference is least where truncation ∝ ε² meets rounding ∝ 1/ε.
                let size = if value == 0.0 || quantity.name == "Angle" { quantity.usual() } else { value.abs() };
                let (lower, upper) = ((value - 1e-5 * size).max(min), (value + 1e-5 * size).min(max));
                let mut at = |value: f64| -> Option<Vec<f64>> {
                    drive.set(known, value).unwrap();
                    start_values(&mut drive, &unknowns)
                };
                let (Some(above), Some(below), Some(centre)) = (at(upper), at(lower), at(value)) else { continue };
                let derivatives = drive.directional_derivatives(&unknowns, &[(known, 1.0)]).unwrap();
                for (n, (&unknown, derivative)) in unknowns.iter().zip(derivatives).enumerate() {
                    let difference = (above[n] - below[n]) / (upper - lower);
                    let scale = difference.abs() + (centre[n].abs() + 1e-9) / size;
                    let (unknown, known) = (&list[unknown], &list[known]);
                    assert!(
                        (derivative - difference).abs() < 1e-5 * scale,
                        "{}, mode {mode}: ∂{}/∂{} = {derivative}, difference {difference}",
                        path.display(),
                        unknown.name,
                        known.name,
                    );
                }
            }
        }
    }
}
