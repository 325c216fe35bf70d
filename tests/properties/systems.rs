//! Coupled FMUs: against the same system as one drive train, and against each other.

use camdrive::drives::variable::{Causality, Kind};
use camdrive_cli::{scene, system};
use camdrive_design::coupling::exchange::Coupling;
use camdrive_design::coupling::stability::Exchange::{self, *};
use camdrive_design::coupling::stability::set;
use camdrive_design::resource::Scene;
use tempfile::TempDir;

/// A system in a folder.
struct Files(TempDir);

const MACHINE: &str =
    "[machine]\nJ0 = 1.2\n[motor]\nkind = \"kloss\"\nM_k = 30\ns_k = 0.2\nw_s = 31\n[start]\nw_start = 30\n";
const CAM: &str = "law = \"fourier\"\na = [0, 0.1, 0, -0.02]\nb = [0.01]\n";
const OUTPUT: &str = "place = \"output\"\nm = 8\nc = 40000\nb = 20\n";
const SHAFT: &str = "place = \"shaft\"\nm = 8\nJ = 0.1\nc = 600\nb = 1\n";

impl Files {
    fn new() -> Self {
        Files(tempfile::tempdir().unwrap())
    }

    fn write(&self, name: &str, text: &str) {
        std::fs::write(self.0.path().join(name), text).unwrap();
    }

    fn path(&self, name: &str) -> std::path::PathBuf {
        self.0.path().join(name)
    }

    /// A machine, an elastic cam drive for each of these, and all of it as a train.
    fn elastic(exchange: &str, drives: &[(&str, &str)]) -> Self {
        let files = Files::new();
        files.write("machine.toml", &format!("name = \"machine\"\nmodel = \"RigidMachine\"\n{MACHINE}"));
        let mut train = format!("name = \"train\"\nmodel = \"DriveTrain\"\n{MACHINE}");
        let mut system = format!(
            "name = \"system\"\nstop = 0.1\nstep = 1e-3\nexchange = \"{exchange}\"\n[part.machine]\nscene = \"machine.toml\"\n"
        );
        for (i, (cam, elasticity)) in drives.iter().enumerate() {
            let name = format!("drive_{i}");
            let head = format!("name = \"{name}\"\nmodel = \"ElasticCamDrive\"\n[drive]\nmode = \"input\"\n");
            files.write(&format!("{name}.toml"), &format!("{head}[cam]\n{cam}[elasticity]\n{elasticity}"));
            system += &format!("[part.{name}]\nscene = \"{name}.toml\"\nshaft = \"machine\"\n");
            train += &format!("[[follower]]\n[follower.cam]\n{cam}[follower.elasticity]\n{elasticity}");
        }
        files.write("train.toml", &train);
        files.write("system.toml", &system);
        files
    }

    fn coupled(&self, exchange: Exchange, repeats: u32) -> Coupling {
        let system = system::read(&self.path("system.toml")).unwrap_or_else(|faults| panic!("{faults}"));
        system.coupled(exchange, repeats).unwrap_or_else(|fault| panic!("{fault}"))
    }

    /// These variables of parts at 0.1 s.
    fn at_end(&self, exchange: Exchange, repeats: u32, step: f64, variables: &[(usize, &str)]) -> Vec<f64> {
        let mut coupling = self.coupled(exchange, repeats);
        coupling.begin(0.0, None).and_then(|()| coupling.start()).unwrap_or_else(|fault| panic!("{fault}"));
        let steps = (0.1 / step).round() as u32;
        for i in 0..steps {
            coupling.advance(f64::from(i) * step, step).unwrap_or_else(|fault| panic!("{fault}"));
        }
        variables.iter().map(|(part, name)| get(&mut coupling, *part, name)).collect()
    }

    /// These variables of the train at 0.1 s.
    fn exact(&self, names: &[&str]) -> Vec<f64> {
        let mut train =
            scene::read(&self.path("train.toml")).unwrap_or_else(|f| panic!("{f}")).resource().build().unwrap();
        train.set_up(0.0, None);
        train.start().unwrap();
        train.advance(0.0, 0.1).unwrap();
        let place = |name: &str| train.descriptions().iter().position(|d| d.name == name).unwrap();
        let places: Vec<usize> = names.iter().map(|name| place(name)).collect();
        places.into_iter().map(|place| train.get(place).unwrap()).collect()
    }
}

fn get(coupling: &mut Coupling, part: usize, name: &str) -> f64 {
    let host = &mut coupling.parts()[part];
    let place = host.description().find(name).unwrap();
    host.get(place).unwrap()
}

/// A way to exchange values, how often a step is repeated, its order, and what it gains at least over held inputs at 1 ms.
type Way = (Exchange, u32, f64, f64);

const WAYS: [Way; 6] = [
    (Held, 0, 1.0, 1.0),
    (GaussSeidel, 0, 1.0, 0.9),
    (Extrapolated, 0, 2.0, 25.0),
    (Interpolated, 0, 2.0, 25.0),
    (Interpolated, 1, 3.0, 3e4),
    (Interpolated, 2, 4.0, 1e5),
];

/// Errors of the speed of the machine and the vibration of the first drive.
fn errors(files: &Files, exact: &[f64], exchange: Exchange, repeats: u32, step: f64) -> Vec<f64> {
    let found = files.at_end(exchange, repeats, step, &[(0, "w"), (1, "q")]);
    found.iter().zip(exact).map(|(found, exact)| ((found - exact) / exact).abs()).collect()
}

#[test]
fn each_exchange_has_its_order_and_tends_to_the_train() {
    for drives in [&[(CAM, OUTPUT)][..], &[(CAM, SHAFT)], &[(CAM, OUTPUT), (CAM, SHAFT)]] {
        let files = Files::elastic("interpolated", drives);
        let exact = files.exact(&["w", "follower[1].q"]);
        let held = errors(&files, &exact, Held, 0, 1e-3);
        for (exchange, repeats, order, gain) in WAYS {
            let [coarse, fine] = [1e-3, 2.5e-4].map(|step| errors(&files, &exact, exchange, repeats, step));
            for i in 0..2 {
                let found = (coarse[i] / fine[i]).log2() / 2.0;
                let said = format!("{drives:?} {exchange:?} {repeats}: {coarse:?} {fine:?}");
                assert!(found > order - 0.15 && coarse[i] * gain <= held[i], "{said}: order {found}");
            }
        }
    }
}

/// A roller of up to three times the inertia of the machine: its torque as a signal is stable at no step.
#[test]
fn rigid_loads_above_the_inertia_of_the_machine_take_effective_inertia() {
    let heavy = format!("{OUTPUT}m_roller = 150\n");
    let signal = Files::elastic("interpolated", &[(CAM, &heavy)]);
    let refusal = system::read(&signal.path("system.toml")).unwrap_err().to_string();
    assert!(refusal.contains("no step is stable") && refusal.contains("effective_inertia"), "{refusal}");
    let files = Files::elastic("effective_inertia", &[(CAM, &heavy)]);
    let exact = files.exact(&["w", "follower[1].q"]);
    for (repeats, order, most) in [(0, 2.0, 3e-3), (1, 3.0, 4e-6), (2, 3.0, 4e-6)] {
        let [coarse, fine] = [1e-3, 5e-4].map(|step| errors(&files, &exact, EffectiveInertia, repeats, step));
        for i in 0..2 {
            let found = (coarse[i] / fine[i]).log2();
            assert!(found > order - 0.1 && coarse[i] < most, "{repeats}: {coarse:?} {fine:?}: order {found}");
        }
    }
}

/// Rounds of a repeated step grow from 0.41 of the inertia of the machine on.
#[test]
fn steps_are_repeated_unasked_where_that_is_stable() {
    for (roller, kappa, expected) in [(5.0, 0.107, 1), (15.0, 0.32, 0), (25.0, 0.54, 0)] {
        let elasticity = format!("{OUTPUT}m_roller = {roller}\n");
        let files = Files::elastic("interpolated", &[(CAM, &elasticity)]);
        let exact = files.exact(&["w", "follower[1].q"]);
        let system = system::read(&files.path("system.toml")).unwrap_or_else(|faults| panic!("{faults}"));
        let found = system.shafts[0].limit.kappa;
        assert!((found / kappa - 1.0).abs() < 0.05 && system.repeats == expected, "{roller}: {found}");
        // As it runs, and with one repetition where that may be asked for.
        for repeats in [expected, u32::from(kappa < 0.4)] {
            let error = errors(&files, &exact, Interpolated, repeats, 5e-4);
            assert!(error.iter().all(|error| *error < 2e-3), "{roller} {repeats}: {error:?}");
        }
        let text = std::fs::read_to_string(files.path("system.toml")).unwrap();
        files.write("system.toml", &text.replacen("step =", "repeat = 1\nstep =", 1));
        assert_eq!(system::read(&files.path("system.toml")).is_ok(), kappa < 0.4, "{roller}");
    }
}

fn read(files: &Files) -> system::System {
    system::read(&files.path("system.toml")).unwrap_or_else(|faults| panic!("{faults}"))
}

/// Parameters and what the limits make of them are those of the FMU, whatever sets them.
#[test]
fn what_start_sets_is_in_the_limits() {
    let files = Files::elastic("interpolated", &[(CAM, &format!("{OUTPUT}m_roller = 5\n"))]);
    let text = std::fs::read_to_string(files.path("system.toml")).unwrap();
    let plain = read(&files).shafts[0].limit;
    let with = |machine: &str, drive: &str| {
        let text =
            text.replace("scene = \"machine.toml\"", &format!("scene = \"machine.toml\"\nstart = {{ {machine} }}"));
        files.write("system.toml", &text.replace("shaft =", &format!("start = {{ {drive} }}\nshaft =")));
        read(&files).shafts[0].limit
    };
    let light = with("J0 = 0.6, w_start = 20", "");
    assert!((light.inertia - 0.6).abs() < 1e-12 && (light.kappa / plain.kappa - 2.0).abs() < 1e-9);
    let other = with("", "m_roller = 10, c = 160000");
    assert!((other.kappa / plain.kappa - 2.0).abs() < 1e-9 && (other.frequency / plain.frequency - 2.0).abs() < 1e-9);
    let other = with("", "\"cam.a[1]\" = 0, \"cam.a[3]\" = 0, \"cam.b[1]\" = 0.02");
    // U′ is largest between the points at which it is looked for.
    let expected = 5.0 * 4e-4 / 1.2;
    assert!((0.999..=1.0).contains(&(other.kappa / expected)), "{} for {expected}", other.kappa);
}

/// What a scene gets by the name of a variable is what its FMU has under this name.
#[test]
fn scenes_take_parameters_as_their_fmus_do() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/fmpy/scenes");
    let paths = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let (mut taken, mut left) = (0, Vec::new());
    for path in paths.filter(|path| path.extension().is_some_and(|e| e == "toml")) {
        let Ok(resolved) = scene::read(&path) else { continue };
        let values = |scene: &Scene| -> Option<Vec<f64>> {
            let mut drive = scene.build().ok()?;
            let all = drive.descriptions().to_vec();
            let parameters = (0..all.len()).filter(|place| all[*place].causality == Causality::Parameter);
            Some(parameters.map(|place| drive.get(place).unwrap()).collect())
        };
        let drive = resolved.scene.build().unwrap();
        let parameters: Vec<_> =
            drive.descriptions().iter().filter(|about| about.causality == Causality::Parameter).collect();
        let before = values(&resolved.scene).unwrap();
        for (i, about) in parameters.iter().enumerate().filter(|(_, about)| matches!(about.kind, Kind::Real { .. })) {
            let (mut changed, value) = (resolved.scene.clone(), 0.999 * before[i]);
            if !set(&mut changed, &about.name, value) {
                left.push(format!("{}: {}", resolved.scene.model(), about.name));
                continue;
            }
            let Some(after) = values(&changed) else { continue };
            let others = (0..before.len()).filter(|k| *k != i && before[*k] != after[*k]).count();
            let beside = ["start.", "solver.", "motor.", "drive.", "load.", "].load.", "_start"];
            let is_beside = beside.iter().any(|part| about.name.contains(part)) && after[i] == before[i];
            assert!(others == 0 && (is_beside || after[i] == value), "{}: {}", path.display(), about.name);
            taken += usize::from(!is_beside && before[i] != 0.0);
        }
    }
    assert!(taken > 100, "{taken}");
    assert!(left.iter().all(|name| name.starts_with("ParametricDrive")), "{left:?}");
}

#[test]
fn a_drive_that_connections_move_is_judged_as_on_a_shaft() {
    let files = Files::elastic("interpolated", &[(CAM, &format!("{OUTPUT}m_roller = 5\n"))]);
    let on_shaft = read(&files);
    let text = std::fs::read_to_string(files.path("system.toml")).unwrap();
    let mut wired = text.replace("shaft = \"machine\"\n", "");
    for (from, to) in [("machine.phi", "drive_0.phi"), ("machine.w", "drive_0.w"), ("machine.a", "drive_0.a")] {
        wired += &format!("[[connection]]\nfrom = \"{from}\"\nto = \"{to}\"\nfactor = 2\n");
    }
    files.write("system.toml", &wired);
    assert_eq!(read(&files).shafts, [], "no torque comes back");
    wired += "[[connection]]\nfrom = \"drive_0.tau\"\nto = \"machine.tau\"\nfactor = 2\n";
    files.write("system.toml", &wired);
    let by_wires = read(&files);
    files.write("system.toml", &text.replace("shaft =", "ratio = 2\nshaft ="));
    assert_eq!(by_wires.shafts, read(&files).shafts);
    assert!((by_wires.shafts[0].limit.kappa / on_shaft.shafts[0].limit.kappa - 4.0).abs() < 1e-9);
}

#[test]
fn a_torque_has_the_factor_of_its_motion() {
    let files = Files::elastic("interpolated", &[(CAM, OUTPUT)]);
    let text = std::fs::read_to_string(files.path("system.toml")).unwrap();
    let wired = |factors: [f64; 4], offsets: [f64; 4]| {
        let ends = [
            ("machine.phi", "drive_0.phi"),
            ("machine.w", "drive_0.w"),
            ("machine.a", "drive_0.a"),
            ("drive_0.tau", "machine.tau"),
        ];
        let mut wired = text.replace("shaft = \"machine\"\n", "");
        for (i, (from, to)) in ends.into_iter().enumerate() {
            let [factor, offset] = [factors[i], offsets[i]];
            wired += &format!(
                "[[connection]]\nfrom = \"{from}\"\nto = \"{to}\"\nfactor = {factor:?}\noffset = {offset:?}\n"
            );
        }
        files.write("system.toml", &wired);
        read(&files).unbalanced()
    };
    for ratio in [1.0, 2.0, -1.0, -0.3] {
        for factor in [1.0, 2.0, -1.0, -0.3] {
            let said = wired([ratio, ratio, ratio, factor], [0.7, 0.0, 0.0, 0.0]);
            assert_eq!(said.is_empty(), ratio == factor, "{ratio} {factor}: {said:?}");
        }
    }
    assert!(wired([2.0, 1.0, 1.0, 1.0], [0.0; 4])[0].contains("contradict"));
    assert!(wired([1.0; 4], [0.0, 3.0, 0.0, 0.0])[0].contains("contradict"));
    assert!(wired([1.0; 4], [0.0, 0.0, 0.0, 3.0])[0].contains("feels 3 N·m more"));
}

/// Two rigid followers of a train on a machine that takes them for its own inertia: κ = 0 of what would be 1.6.
#[test]
fn a_train_with_rigid_followers_has_an_effective_inertia() {
    let files = Files::new();
    let followers = format!("[[follower]]\nm = 150\n[follower.cam]\n{CAM}[[follower]]\nm = 60\n[follower.cam]\n{CAM}");
    files.write("machine.toml", &format!("name = \"machine\"\nmodel = \"RigidMachine\"\n{MACHINE}"));
    files
        .write("rigid.toml", &format!("name = \"rigid\"\nmodel = \"DriveTrain\"\ndrive.mode = \"input\"\n{followers}"));
    files.write("train.toml", &format!("name = \"train\"\nmodel = \"DriveTrain\"\n{MACHINE}{followers}"));
    files.write(
        "system.toml",
        "name = \"system\"\nstop = 0.1\nstep = 1e-3\nexchange = \"effective_inertia\"\n[part.machine]\nscene = \"machine.toml\"\n\
         [part.rigid]\nscene = \"rigid.toml\"\nshaft = \"machine\"\n",
    );
    assert_eq!(read(&files).shafts[0].limit.kappa, 0.0);
    let exact = files.exact(&["w"])[0];
    let [coarse, fine] = [1e-3, 5e-4].map(|step| {
        let found = files.at_end(EffectiveInertia, 1, step, &[(0, "w")])[0];
        ((found - exact) / exact).abs()
    });
    assert!(coarse < 1e-5 && coarse / fine > 6.0, "{coarse} {fine}");
}

/// A free shaft with a follower of its own as the machine: it gets an input for the torque.
#[test]
fn a_train_may_be_the_machine() {
    let files = Files::elastic("interpolated", &[(CAM, OUTPUT), (CAM, SHAFT)]);
    let own = format!("[[follower]]\n[follower.cam]\n{CAM}[follower.elasticity]\n{OUTPUT}");
    files.write("machine.toml", &format!("name = \"machine\"\nmodel = \"DriveTrain\"\n{MACHINE}{own}"));
    let text = std::fs::read_to_string(files.path("system.toml")).unwrap();
    let at = text.find("[part.drive_0]").unwrap();
    let of_one = text[at..].find("[part.drive_1]").unwrap();
    files.write("system.toml", &format!("{}{}", &text[..at], &text[at + of_one..]));
    let exact = files.exact(&["w", "follower[2].q"]);
    let [coarse, fine] = [1e-3, 5e-4].map(|step| errors(&files, &exact, Interpolated, 1, step));
    for i in 0..2 {
        assert!(coarse[i] < 1e-5 && coarse[i] / fine[i] > 6.0, "{coarse:?} {fine:?}");
    }
}

#[test]
fn the_train_of_the_backlash_machine_is_the_one_of_its_example() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/backlash_machine");
    let system = system::read(&folder.join("system.toml")).unwrap_or_else(|faults| panic!("{faults}"));
    let train = scene::read(&folder.join("train.toml")).unwrap_or_else(|faults| panic!("{faults}"));
    assert!(system.train().map(|single| single.scene.scene) == Ok(train.scene));
}

/// Each with what is told of it.
#[test]
fn what_no_train_can_be_is_told() {
    let other = "[[connection]]\nfrom = \"drive_0.force\"\nto = \"drive_0.F\"\n";
    let lag = MACHINE.replace("s_k = 0.2", "s_k = 0.2\nlag = 0.05");
    let steady = MACHINE.replace("w_start = 30", "mode = \"steady_state\"");
    let elastic = |place: &str| {
        format!("name = \"drive_0\"\nmodel = \"ElasticCamDrive\"\n[drive]\nmode = \"input\"\n[cam]\n{CAM}{place}")
    };
    let output = elastic(&format!("[elasticity]\n{OUTPUT}"));
    let cycle = output.replace(CAM, "law = \"cycle\"\nstroke = 0.01\nrise = 2\nupper_dwell = 1\nreturn = 2\nrise_law = \"modified_sine\"\nreturn_law = \"modified_sine\"\n");
    let linear = elastic(&format!("[elasticity]\n{SHAFT}linear = true\n"));
    let begun = format!("{output}[start]\nmode = \"given\"\nq = 0.001\n");
    let parametric = "name = \"drive_0\"\nmodel = \"ParametricDrive\"\n[drive]\nmode = \"input\"\n[coefficients]\nm = 1\nc = 100\nf = { law = \"fourier\", a = [0, 1] }\n";
    for (machine, drive, part, said) in [
        (
            MACHINE,
            &*output,
            "ratio = 1.5\n",
            "part drive_0: with the ratio 1.5 its law is no series of at most 256 harmonics",
        ),
        (MACHINE, &output, "ratio = 200\n", "part drive_0: with the ratio 200 its law is no series of"),
        (
            MACHINE,
            &cycle,
            "ratio = 2\n",
            "part drive_0: only harmonic laws, and cycles at the ratio 1, turn by 2 φ + 0 in a train",
        ),
        (
            MACHINE,
            &output,
            "start = { \"cam.a[1]\" = 0.2 }\n",
            "part drive_0: `start` sets `cam.a[1]`, which a train does not have",
        ),
        (
            MACHINE,
            &output,
            "[part.other]\nscene = \"machine.toml\"\n",
            "a train has one shaft, but 2 parts sit on none",
        ),
        (MACHINE, &linear, "", "as a train: "),
        (MACHINE, &begun, "", "part drive_0: a train has no such `start`"),
        (MACHINE, parametric, "", "part drive_0: a ParametricDrive is no follower of a train"),
        (
            MACHINE,
            &format!("{output}[load]\ninput = true\n"),
            other,
            "the connection from drive_0.force to drive_0.F is not between a shaft",
        ),
        (&lag, &output, "", "part machine: the torque of its motor, which lags"),
        (&steady, &output, "", "part machine: alone it starts in another periodic motion"),
    ] {
        let files = Files::elastic("interpolated", &[(CAM, OUTPUT)]);
        files.write("machine.toml", &format!("name = \"machine\"\nmodel = \"RigidMachine\"\n{machine}"));
        files.write("drive_0.toml", drive);
        let text = std::fs::read_to_string(files.path("system.toml")).unwrap();
        files.write("system.toml", &format!("{}{part}", text.replace("1e-3", "1e-6")));
        let system = system::read(&files.path("system.toml")).unwrap_or_else(|faults| panic!("{said}: {faults}"));
        let found = system.train().err().unwrap_or_else(|| panic!("{said}"));
        assert!(found.contains(said) && !found.contains('\n'), "{said}: {found}");
    }
}

/// The factor by which the twist of an elastic shaft grows in a step, on a machine that nothing else acts on.
fn grown(files: &Files, exchange: Exchange, repeats: u32, step: f64) -> f64 {
    /// Steps until the fastest growing motion alone is left, and steps over which it is measured, in windows.
    const STEPS: [u32; 2] = [1000, 3000];
    const WINDOW: u32 = 20;
    /// Beyond this change the growth is known.
    const KNOWN: f64 = 1e5;
    let mut coupling = files.coupled(exchange, repeats);
    coupling.begin(0.0, None).and_then(|()| coupling.start()).unwrap_or_else(|fault| panic!("{fault}"));
    let mut largest: Vec<f64> = Vec::new();
    let [settled, all] = STEPS.map(|steps| (steps / WINDOW) as usize);
    for i in 0..STEPS[1] {
        coupling.advance(f64::from(i) * step, step).unwrap_or_else(|fault| panic!("{fault}"));
        if i % WINDOW == 0 {
            let change = largest.last().zip(largest.first()).map_or(1.0, |(last, first): (&f64, &f64)| last / first);
            if !(KNOWN.recip()..KNOWN).contains(&change) {
                break;
            }
            largest.push(0.0);
        }
        let size = get(&mut coupling, 1, "q").abs();
        largest.iter_mut().rev().take(1).for_each(|most| *most = most.max(size));
    }
    let last = largest.len() - 1;
    let first = if largest.len() >= all { settled } else { 0 };
    (largest[last] / largest[first]).powf(1.0 / f64::from((last - first) as u32 * WINDOW))
}

/// Linear pairs run just below and just above the largest steps: they grow by less and by more than 1e-3 a step.
#[test]
fn runs_grow_beyond_the_largest_steps() {
    let ways =
        [(Held, 0), (Extrapolated, 0), (GaussSeidel, 0), (Interpolated, 0), (Interpolated, 1), (Interpolated, 2)];
    let mut checked = 0;
    for mu in [0.05, 0.5, 5.0] {
        // J = 1, k = 1; a mass too small to be felt.
        let damping = 2.0 * 0.02 * f64::sqrt(mu);
        let files = Files::new();
        files.write(
            "machine.toml",
            "name = \"machine\"\nmodel = \"RigidMachine\"\n[machine]\nJ0 = 1\n[start]\nw_start = 1e-3\n",
        );
        files.write(
            "drive.toml",
            &format!(
                "name = \"drive\"\nmodel = \"ElasticCamDrive\"\n[drive]\nmode = \"input\"\n[cam]\n{CAM}[elasticity]\n\
                 place = \"shaft\"\nlinear = true\nm = 1e-12\nJ = {mu}\nc = 1\nb = {damping}\n[start]\nmode = \"given\"\nq = 1e-6\n"
            ),
        );
        files.write(
            "system.toml",
            "name = \"system\"\nstop = 1\nstep = 1e-3\nrepeat = 0\n[part.machine]\nscene = \"machine.toml\"\n\
             [part.drive]\nscene = \"drive.toml\"\nshaft = \"machine\"\n",
        );
        for (exchange, repeats) in ways {
            let system =
                system::read_as(&files.path("system.toml"), exchange).unwrap_or_else(|faults| panic!("{faults}"));
            let Some(limit) = system.limits(repeats)[0].limit.stable else { continue };
            let [below, above] = [0.98, 1.02].map(|part| grown(&files, exchange, repeats, part * limit) - 1.0);
            checked += 1;
            assert!(below < 1e-3 && above > 1e-3, "{mu} {exchange:?} {repeats}: {below} and {above} at {limit} s");
        }
    }
    assert!(checked >= 12, "{checked}");
}
