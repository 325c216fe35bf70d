//! Single models that become trains because of their loads, motors or a missing flank: the names, the motion and the refusals.

use crate::scene;
use camdrive::drives::variable::{Causality, Kind};
use camdrive::drives::{AnyDrive, Description};
use camdrive_design::forces::Machine;
use std::path::Path;

const BACKLASH: &str = "name = \"x\"\nmodel = \"BacklashDrive\"\n";
const MACHINE: &str = "name = \"x\"\nmodel = \"RigidMachine\"\n";

/// Model and drive.
fn built(text: &str) -> (&'static str, AnyDrive) {
    let scene = scene::resolve("x.toml", text, Path::new("")).unwrap_or_else(|faults| panic!("{text}\n{faults}"));
    let described = scene.resource().build().unwrap();
    let mut drive = described.plan().instance();
    drive.set_up(0.0, None);
    (scene.scene.model(), drive)
}

fn reference(drive: &AnyDrive, name: &str) -> usize {
    drive.descriptions().iter().position(|d| d.name == name).unwrap_or_else(|| panic!("no `{name}`"))
}

/// The outputs at the end of each of so many steps.
fn course<const N: usize>(drive: &mut AnyDrive, end: f64, steps: usize, names: [&str; N]) -> Vec<[f64; N]> {
    let places = names.map(|name| reference(drive, name));
    drive.start().unwrap();
    let step = end / steps as f64;
    let mut at = |i: usize| {
        drive.advance(i as f64 * step, (i + 1) as f64 * step - i as f64 * step).unwrap();
        places.map(|place| drive.get(place).unwrap())
    };
    (0..steps).map(&mut at).collect()
}

/// Asserts the outputs of two independent programs to 1e-9 of their largest magnitude.
fn reach<const N: usize>(text: &str, end: f64, expected: [(&str, f64); N]) {
    let (model, mut drive) = built(text);
    assert_eq!(model, "DriveTrain");
    let course = course(&mut drive, end, 200, expected.map(|(name, _)| name));
    for (i, (name, number)) in expected.into_iter().enumerate() {
        let size = course.iter().fold(0.0_f64, |size, values| size.max(values[i].abs()));
        let found = course[course.len() - 1][i];
        assert!((found - number).abs() <= 1e-9 * size, "{name}: {found} for {number}");
    }
}

/// Asserts that both move alike to 1e-9 of the largest magnitude; the first is a single model, the second a train.
fn alike<const N: usize>(text: &str, train: &str, end: f64, names: [&str; N]) {
    let ((one, mut plain), (other, mut train)) = (built(text), built(train));
    assert!(one != "DriveTrain" && other == "DriveTrain");
    let [plain, train] = [&mut plain, &mut train].map(|drive| course(drive, end, 40, names));
    for (i, name) in names.into_iter().enumerate() {
        let size = plain.iter().fold(0.0_f64, |size, values| size.max(values[i].abs()));
        for (n, (a, b)) in plain.iter().zip(&train).enumerate() {
            assert!((a[i] - b[i]).abs() <= 1e-9 * size, "{text}\n{name} of step {n}: {} for {}", b[i], a[i]);
        }
    }
}

/// Asserts a fault in one line with all of these pieces.
fn refused(text: &str, pieces: &[&str]) {
    let faults = scene::resolve("x.toml", text, Path::new("")).expect_err(text).to_string();
    assert!(pieces.iter().all(|piece| faults.contains(piece)), "{text}\n{faults}");
    assert!(!faults.contains("follower[1].") || text.contains("[[follower]]"), "{faults}");
}

const LOADED: &str = r#"
cam = { law = "fourier", a = [0.0, -0.05, 0.006], b = [0.004] }
drive = { speed = 20, phi_start = 0.3 }
backlash = { m1 = 2, m2 = 8, c = 2000, b = 20, s = 0.002, e = 0 }
[load]
gravity = "9.81 m/s2"
damping = 15
process = { law = "fourier", a = [0.0, 20.0, -12.0], b = [7.0, 0.0, 3.0] }
roller.gravity = "9.81 m/s2"
"#;

const LIFTING: &str = r#"
cam = { law = "fourier", a = [0.0, -0.008, 0.0009], b = [0.0, 0.0004] }
drive = { speed = 170 }
backlash = { m1 = 0.6, s = "inf", e = 0 }
load = { gravity = "9.81 m/s2", spring = { preload = "90 N", c = 2500, at = 0 } }
"#;

#[test]
fn loads_and_lift_off_of_a_backlash_drive_are_in_its_motion() {
    let loaded = [
        ("x1", -0.0421210497716215),
        ("der(x1)", -0.0641580002411233),
        ("y", 0.0164851868472915),
        ("der(y)", -1.10757361983927),
        ("force", -53.8317409201792),
        ("tau", 0.172686842346847),
        ("impulse", -0.363483794278535),
        ("energy_loss", 0.136796760191905),
    ];
    reach(&format!("{BACKLASH}{LOADED}"), 0.6, loaded);
    let lifting = [
        ("x1", -0.00104578396142975),
        ("der(x1)", 1.21137885810118),
        ("force", 157.33790870028),
        ("tau", 1.12115185986691),
        ("impulse", 3.56410465517052),
        ("energy_loss", 3.52856722028004),
    ];
    reach(&format!("{BACKLASH}{LIFTING}"), 0.12, lifting);
    let bouncing = [
        ("x1", -0.00417020238712716),
        ("der(x1)", 0.822764923843696),
        ("impulse", 5.31685563160855),
        ("energy_loss", 2.28274775169493),
    ];
    reach(&format!("{BACKLASH}{LIFTING}").replace("e = 0 }", "e = 0.4 }"), 0.08, bouncing);
}

/// A reference train as the scene of a RigidMachine.
fn stored(name: &str) -> String {
    let path = format!("{}/../tests/fmpy/trains/{name}.toml", env!("CARGO_MANIFEST_DIR"));
    std::fs::read_to_string(path).unwrap().replace("DriveTrain", "RigidMachine")
}

#[test]
fn loads_and_motors_of_a_rigid_machine_are_in_its_motion() {
    let press = [
        ("phi", 12.2031365166528),
        ("w", 12.0060868002694),
        ("a", -32.1190434213295),
        ("follower[1].force", 62878.3563888403),
        ("motor.I", 15.0588944013349),
        ("follower[1].tau", 2108.11365820767),
    ];
    reach(&stored("press"), 0.78, press);
    let four_bar = [
        ("phi", 11.7260129350849),
        ("w", 14.9649700303409),
        ("a", 1.51610273279994),
        ("follower[1].force", 0.514337529502273),
        ("follower[1].tau", -0.0659163772090079),
    ];
    reach(&stored("four_bar"), 0.8, four_bar);
}

/// Numbers in [0, 1), the same in every run (the generator of Knuth's MMIX).
struct Random(u64);

impl Random {
    fn within(&mut self, low: f64, high: f64) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        low + (high - low) * (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }
}

#[test]
fn without_force_a_loaded_backlash_drive_moves_as_the_plain_one() {
    let mut random = Random(1);
    for mode in ["at_rest", "given", "at_rest", "given"] {
        let mut number = |low: f64, high: f64| random.within(low, high);
        let given = format!("q = {}, q_dot = {}", number(-0.002, 0.002), number(-0.1, 0.1));
        let plain = format!(
            "{BACKLASH}cam = {{ law = \"fourier\", a = [0, {}, {}], b = [{}] }}\ndrive = {{ speed = {}, phi_start = {} }}\n\
             backlash = {{ m1 = {}, m2 = {}, c = {}, b = {}, s = {} }}\nstart = {{ mode = \"{mode}\"{}{} }}\n",
            number(0.02, 0.05),
            number(-0.01, 0.01),
            number(-0.01, 0.01),
            number(8.0, 20.0),
            number(0.0, 6.0),
            number(1.0, 3.0),
            number(4.0, 9.0),
            number(2e3, 5e3),
            number(5.0, 30.0),
            number(1e-3, 4e-3),
            if mode == "given" { ", " } else { "" },
            if mode == "given" { &given } else { "" },
        );
        let names = ["x1", "der(x1)", "y", "der(y)", "q", "gap", "contact", "impulse", "energy_loss", "damping_loss"];
        let own = ["der(q)", "force", "force_mean", "tau", "tau_mean", "impacts", "phi", "w", "der(x1,2)", "der(y,2)"];
        for names in [&names[..], &own[..]] {
            for name in names {
                alike(&plain, &format!("{plain}load.spring.c = 0\n"), 0.5, [name]);
            }
        }
    }
    // Without the other flank, as long as m1 does not reach it.
    let one = format!("{BACKLASH}{LOADED}").replace("0.002", "1000").split("[load]").next().unwrap().to_owned();
    let inf = format!("{}load.gravity = 1e-12", one.replace("s = 1000", "s = \"inf\""));
    alike(&one, &inf, 0.4, ["x1", "der(x1)", "y", "der(y)", "force_mean", "impulse"]);
}

#[test]
fn without_force_a_loaded_rigid_machine_moves_as_the_plain_one() {
    let mut random = Random(2);
    for motor in ["none", "kloss", "kloss", "lag"] {
        let mut number = |low: f64, high: f64| random.within(low, high);
        let w = number(15.0, 40.0);
        let kloss = format!("kind = \"kloss\"\nM_k = {}\ns_k = {}\nw_s = {w}\n", number(40.0, 80.0), number(0.1, 0.3));
        let motor = match motor {
            "none" => "kind = \"none\"\n".to_owned(),
            "lag" => kloss + "lag = 0.02\n",
            _ => kloss,
        };
        let plain = format!(
            "{MACHINE}start = {{ phi_start = {}, w_start = {} }}\nmachine.J0 = {}\n[motor]\n{motor}[[follower]]\nm = {}\n\
             cam = {{ law = \"fourier\", a = [0, {}, {}], b = [{}] }}\n[[follower]]\nJ = {}\n\
             cam = {{ law = \"fourier\", a = [0.2, {}], b = [{}] }}\n",
            number(0.0, 6.0),
            0.8 * w,
            number(0.3, 2.0),
            number(1.0, 20.0),
            number(0.02, 0.08),
            number(-0.02, 0.02),
            number(-0.02, 0.02),
            number(0.1, 0.5),
            number(0.1, 0.4),
            number(-0.1, 0.1),
        );
        let names = ["phi", "w", "a", "J", "E", "U[1]", "der(U[1])", "der(U[1],2)", "U[2]", "der(U[2])", "der(U[2],2)"];
        alike(&plain, &format!("{plain}load.spring.c = 0\n"), 0.5, names);
        if plain.contains("kloss") {
            alike(&plain, &format!("{plain}load.force = 0\n"), 0.5, ["M_an"]);
            let steady = plain.replace("start = {", "start = { mode = \"steady_state\",");
            alike(&steady, &format!("{steady}load.force = 0\n"), 0.5, ["w", "U[1]", "start.period"]);
        }
    }
}

/// The properties of a variable that importers see.
fn seen(d: &Description) -> (String, Causality, String) {
    let kind = match &d.kind {
        Kind::Real { quantity, .. } => quantity.unit.to_owned(),
        Kind::Enumeration(items) => items.name.to_owned(),
        other => format!("{other:?}"),
    };
    (d.name.clone(), d.causality, kind)
}

#[test]
fn the_variables_are_those_of_the_single_model() {
    let of = |text: &str| built(text).1.descriptions().iter().map(seen).collect::<Vec<_>>();
    let follower = "[[follower]]\nm = 2\ncam = { law = \"fourier\", a = [0, 0.1] }\n";
    let linked = "[[follower]]\nm = 2\ncrank = {}\nlinkage = [{ kind = \"slider_crank\", crank = { length = 0.1 }, rod = { length = 0.4 } }]\n";
    let machine =
        format!("{MACHINE}[motor]\nkind = \"kloss\"\nM_k = 5\ns_k = 0.1\nw_s = 5\n[machine]\nJ0 = 1\n{follower}");
    let constant = format!("{BACKLASH}{LOADED}").split("[load]").next().unwrap().to_owned();
    let inputs = constant.replace("speed = 20, phi_start = 0.3", "mode = \"input\"");
    for (plain, load) in [
        (constant, "load.force = -2\n"),
        (inputs, "load.force = -2\n"),
        (machine.clone(), "load.force = -2\n"),
        (machine.clone() + linked, "load.damping = 2\n"),
        (machine.replace("w_s = 5", "w_s = 5\nlag = 0.1"), "load.damping = 2\n"),
    ] {
        let loaded = of(&format!("{plain}{load}"));
        for variable in of(&plain) {
            // Variables of the other solver alone.
            let own = ["solver.method", "solver.step_size", "der(M_an)"];
            assert!(loaded.contains(&variable) || own.contains(&&*variable.0), "{variable:?}");
        }
        let of_trains =
            |name: &str| name.contains("follower[1].") && plain.contains("Backlash") || name.ends_with("].U");
        assert!(!loaded.iter().any(|(name, ..)| of_trains(name)));
    }
    // A rotor with a lag starts with the same torque as the single model.
    let (_, mut drive) = built(&format!("{}load.damping = 2\n", machine.replace("w_s = 5", "w_s = 5\nlag = 0.1")));
    let start = reference(&drive, "motor.M_start");
    drive.set(start, 1.5).unwrap();
    assert!((course(&mut drive, 1e-9, 1, ["M_an"])[0][0] - 1.5).abs() < 1e-6);
}

#[test]
fn an_input_of_the_load_is_one_of_the_drive() {
    let (_, mut drive) = built(&format!("{BACKLASH}{LOADED}input = true\n"));
    let force = reference(&drive, "F");
    drive.set(force, 80.0).unwrap();
    let pushed = course(&mut drive, 0.1, 10, ["y"])[9][0];
    let (_, mut constant) = built(&format!("{BACKLASH}{LOADED}force = 80\n"));
    assert!((course(&mut constant, 0.1, 10, ["y"])[9][0] - pushed).abs() < 1e-12);
    let (_, mut ramp) = built(&format!("{BACKLASH}{LOADED}input = true\n"));
    ramp.start().unwrap();
    ramp.set_input_derivative(force, 1, 1600.0).unwrap();
    ramp.advance(0.0, 0.1).unwrap();
    let (_, mut still) = built(&format!("{BACKLASH}{LOADED}input = true\n"));
    let [ramped, still] = [ramp.get(reference(&ramp, "y")).unwrap(), course(&mut still, 0.1, 1, ["y"])[0][0]];
    assert!(ramped > still + 1e-3, "{ramped} with a growing force, {still} without");
    let slope = drive.directional_derivatives(&[reference(&drive, "der(y,2)")], &[(force, 1.0)]).unwrap();
    assert!((slope[0] - 0.125).abs() < 1e-12, "{slope:?}");
    let by_place = drive.directional_derivatives(&[reference(&drive, "q")], &[(reference(&drive, "y"), 1.0)]);
    assert_eq!(by_place.unwrap(), [1.0]);
}

#[test]
fn what_the_single_models_do_not_have_is_refused() {
    let lifting = format!("{BACKLASH}{LIFTING}");
    let loaded = format!("{BACKLASH}{LOADED}");
    let follower = "[[follower]]\nm = 2\ncam = { law = \"fourier\", a = [0, 0.1] }\n";
    let machine = |text: &str| format!("{MACHINE}{follower}{text}");
    let motor = "[machine]\nJ0 = 1\n[motor]\nkind = \"constant\"\ntorque = 5\n";
    for (text, said) in [
        (
            lifting.replace("load = {", "load = { force = 500, spring.c = 0 }\n#"),
            &["`backlash.s`: nothing brings the follower back", "in `load`"][..],
        ),
        (lifting.replace("m1 = 0.6", "m1 = 0.6, c = 5"), &["`backlash.c`", "without `m2`"]),
        (lifting.replace("\"inf\"", "0.1"), &["`backlash.m2`"]),
        (lifting.replace("\"inf\"", "\"none\""), &["neither a number nor \"inf\""]),
        (format!("start.mode = \"given\"\n{lifting}"), &["`start.mode`: without `m2` there is no spring"]),
        (format!("solver.method = \"fixed_cost\"\n{loaded}"), &["solver.method", "locates its events"]),
        (loaded.replace("s = 0.002", "s = 0"), &["`backlash.s`: without clearance"]),
        (loaded.replace("m1 = 2", "m1 = -2"), &["`backlash.m1`: -2 is out of range"]),
        (loaded.replace("roller.gravity", "mass.gravity"), &["did you mean `roller`?"]),
        (machine("elasticity = { m = 1 }\n[machine]\nJ0 = 1"), &["follower[1].elasticity", "are rigid", "DriveTrain"]),
        (machine("backlash = { m1 = 1 }\n[machine]\nJ0 = 1"), &["follower[1].backlash", "are rigid"]),
        (
            machine(&format!("{motor}J = 1\ncoupling = {{ c = 5 }}")),
            &["`motor.coupling`: the rotor would not", "DriveTrain"],
        ),
        (machine("[machine]\nJ0 = 1\nload.input = true"), &["machine.load.input", "always has the input tau"]),
        (machine(&format!("{motor}[machine.load]\ntorque = 6")), &["the motor cannot start: 5 N.m on the shaft"]),
        (machine(&format!("{motor}[solver]\nmethod = \"fixed_cost\"")), &["solver.method", "locates its events"]),
        (machine(&format!("{motor}[start]\nmode = \"equilibrium\"")), &["given, steady_state"]),
        (machine(&format!("{motor}[start]\nmode = \"steady_state\"")), &["no speed is known", "choose given"]),
        (machine("[motor]\nkind = \"none\""), &["`machine` is missing"]),
    ] {
        refused(&text, said);
    }
}

#[test]
fn a_shaft_that_turns_backwards_has_its_own_speed_of_lift_off() {
    // 523.08 rpm is the minimum over the turn; damping presses where the cam falls, so that +40 rad/s would give 578.42 rpm.
    let scene = |speed: f64| {
        let text = format!(
            "name = \"neg\"\nmodel = \"DriveTrain\"\ndrive = {{ speed = {speed} }}\n[[follower]]\ncam = {{ law = \"fourier\", a = \
             [0, 0.02, 0.005], b = [0.01] }}\nbacklash = {{ m1 = 1, s = \"inf\" }}\nload = {{ spring = {{ preload = 50, c = 2000 }}, \
             damping = 30 }}\n"
        );
        crate::scene::resolve("neg.toml", &text, "".as_ref()).expect("a scene")
    };
    for (speed, rpm) in [(-40.0, 523.08), (40.0, 578.42)] {
        let of = Machine::of(&scene(speed).resource()).and_then(|machine| machine.lift_offs()).expect("speeds");
        let found = of[0].held.lift_off_speed.expect("a speed").value * 30.0 / std::f64::consts::PI;
        assert!((found - rpm).abs() < 0.01, "{speed} rad/s: {found} rpm");
    }
}

const TRAIN: &str = "name = \"x\"\nmodel = \"DriveTrain\"\n";

/// The notes on a scene.
fn notes(text: &str) -> Vec<String> {
    scene::resolve("x.toml", text, Path::new("")).unwrap_or_else(|faults| panic!("{text}\n{faults}")).notes
}

#[test]
fn a_motor_that_its_load_holds_is_refused() {
    // The crank lifts m: ∫ m g dU, with the rod much longer than the crank m g r (1 − cos φ).
    let lift =
        "[machine]\nJ0 = 1\n[[follower]]\nm = 2\ncam = { law = \"fourier\", a = [0, -0.1] }\nload = { gravity = 10 }\n";
    let spring = "[machine]\nJ0 = 1\n[[follower]]\ncam = { law = \"fourier\", a = [0, -0.1] }\n\
                  backlash = { m1 = 1, s = \"inf\" }\nload = { spring = { preload = 20, c = 0, at = 0 } }\n";
    let soft = "[machine]\nJ0 = 1\n[[follower]]\ncam = { law = \"fourier\", a = [0, -0.1] }\n\
                elasticity = { place = \"output\", m = 2, c = 1e6 }\nload = { gravity = 10 }\n";
    let constant = |torque: f64| format!("[motor]\nkind = \"constant\"\ntorque = {torque}\n");
    let servo = |more: &str| format!("[motor]\nkind = \"servo\"\nM_max = 3\nK_p = 0.2\n{more}\n");
    let machine = |load: f64| format!("[machine]\nJ0 = 1\nload.torque = {load}\n");
    let (step, kloss) = (
        "[machine]\nJ0 = 1\nload.torque.points = [[0, 50], [3, 50], [3, 44], [\"360 deg\", 44]]\n",
        "[motor]\nkind = \"kloss\"\nM_k = 60\ns_k = 0.2\nw_s = 15\nratio = 2\n",
    );
    // 2 sin(φ) at φ = 90°; the mean over the way to φ, 2 (1 − cos φ)/φ, is 1.449 at 133.56°.
    let from = |phi: f64| format!("start.phi_start = \"{phi} deg\"\n");
    for load in [lift, spring, soft] {
        let said = [
            "the motor cannot start: 1.4 N.m on the shaft",
            "takes 1.449",
            "over the first 134 deg",
            "more than 1.449",
        ];
        refused(&format!("{TRAIN}{}{load}", constant(1.4)), &said);
        let said = ["`motor`: the motor cannot start: 1.9 N.m on the shaft", "takes 2 N.m at the start", "greater"];
        refused(&format!("{TRAIN}{}{}{load}", from(90.0), constant(1.9)), &said[..2]);
        // The other way it is the same hill.
        refused(&format!("{TRAIN}{}{load}", constant(-1.4)), &["1.4 N.m on the shaft", "takes 1.449"]);
        refused(&format!("{TRAIN}{}{}{load}", from(-90.0), constant(-1.9)), &["takes 2 N.m at the start"]);
        for torque in [1.5, -1.5] {
            notes(&format!("{TRAIN}{}{load}", constant(torque)));
        }
        // From the top it falls, and its work over the turn is 2 π M.
        notes(&format!("{TRAIN}{}{}{load}", from(180.0), constant(0.1)));
        notes(&format!("{TRAIN}{}{load}", servo("w_ref = 10\nK_i = 1")));
    }
    for (text, said) in [
        (machine(6.0) + &constant(5.0), &["5 N.m on the shaft", "takes 6 N.m at the start", "start.w_start"][..]),
        (machine(-6.0) + &constant(-5.0), &["takes 6 N.m at the start"]),
        (machine(6.0) + &servo("w_ref = 10"), &["2 N.m on the shaft", "takes 6 N.m"]),
        (machine(6.0) + &servo("w_ref = 10\nK_i = 1"), &["3 N.m on the shaft"]),
        (machine(6.0) + &servo("w_ref = 10\nK_i = 1\nratio = 2"), &["6 N.m on the shaft", "more than 6 N.m"]),
        (machine(-6.0) + &servo("w_ref = { ramp = 10 }\nratio = -1"), &["3 N.m on the shaft", "takes 6 N.m"]),
        (
            machine(5.0) + "[motor]\nkind = \"table\"\npoints = [[-2, 2], [2, 2], [10, 8]]",
            &["2 N.m on the shaft", "takes 5"],
        ),
        (format!("{step}{kloss}"), &["46.15", "takes 50 N.m at the start"]),
    ] {
        refused(&format!("{TRAIN}{text}"), said);
    }
    // After the step the shaft has the speed for the higher torque.
    notes(&format!("{TRAIN}start.phi_start = \"180 deg\"\n{step}{kloss}"));
    // A load that drives needs no motor, and a shaft without load needs no torque.
    for text in [machine(-6.0) + &constant(5.0), machine(6.0) + &constant(-5.0), machine(0.0) + &constant(0.0)] {
        assert!(notes(&format!("{TRAIN}{text}")).is_empty());
    }
    // It may run at this speed, though not for long.
    let running = notes(&format!("{TRAIN}start.w_start = 1\n{}{}", machine(6.0), constant(5.0)));
    assert!(running.len() == 1 && running[0].contains("cannot keep the speed: at most 5 N.m"), "{running:?}");
    assert!(notes(&format!("{TRAIN}start.w_start = 1\n{lift}{}", constant(0.1))).is_empty());
}

#[test]
fn a_position_loop_that_grows_is_told() {
    // K_p (K_p K_v + K_i) > J K_i K_v with J = 1 + 1 of the shaft at i = 2, 0.5 at the rotor, and its own 0.5: K_v < 2·30/(30 − 4).
    let of = |gain: f64, more: &str| {
        let motor =
            format!("kind = \"servo\"\nK_p = 2\nK_i = 30\nM_max = 50\nw_ref = 10\nratio = 2\nJ = 0.5\nK_v = {gain}\n");
        let follower = "[[follower]]\nm = 2\ncam = { law = \"fourier\", a = [0, 1] }\n";
        notes(&format!("{TRAIN}[motor]\n{motor}[machine]\nJ0 = 1\n{more}{follower}"))
    };
    let unstable = of(2.4, "");
    assert!(unstable.len() == 1 && unstable[0].contains("below 2.307"), "{unstable:?}");
    assert!(
        unstable[0].starts_with("`motor.K_v`: 2.4 1/s makes the position loop unstable: with 1 kg.m2"),
        "{unstable:?}"
    );
    assert!(of(2.3, "").is_empty() && of(2.4, "load.friction = 1\n").is_empty());
    assert_eq!(
        of(2.4, "[motor.coupling]\nc = 800\n[machine]\nJ0 = 1\n".trim_end_matches("[machine]\nJ0 = 1\n")).len(),
        1
    );
}

#[test]
fn nothing_balances_where_no_load_presses() {
    let equilibrium = "start.mode = \"equilibrium\"\n";
    let plain = format!("{BACKLASH}{LOADED}").split("[load]").next().unwrap().to_owned();
    refused(&format!("{equilibrium}{plain}"), &["x.toml:1", "without loads m1 may be anywhere", "at_rest"]);
    let slow = plain.replace("speed = 20", "speed = 0.1");
    // A spring with zero force within the clearance: 1 mm above flank A, which is at −0.05 cos 0.3 + ….
    let held = |at: f64| format!("{equilibrium}{slow}[load]\nroller.spring = {{ c = 500, at = {at} }}\n");
    let a = -0.05 * 0.3_f64.cos() + 0.006 * 0.6_f64.cos() + 0.004 * 0.3_f64.sin();
    refused(&held(a + 0.001), &["holds follower 1 at a flank of its clearance"]);
    for (at, contact) in [(a - 0.001, 1.0), (a + 0.003, -1.0)] {
        let (_, mut drive) = built(&held(at));
        drive.start().unwrap();
        assert_eq!(drive.get(reference(&drive, "contact")).unwrap(), contact);
    }
    refused(&format!("{equilibrium}{plain}load.spring.c = 0"), &["at a flank of its clearance", "a force"]);
    // A spring that is relaxed at the flank holds m1 there.
    let cam = "cam = { law = \"fourier\", a = [0.0, -0.5] }\ndrive = { speed = 0.1 }\nbacklash = { m1 = 2, m2 = 8, c = 2000, s = 0.002 }\n";
    let (_, mut drive) =
        built(&format!("{BACKLASH}{equilibrium}{cam}[load]\nroller.spring = {{ c = 500, at = -0.5 }}\n"));
    drive.start().unwrap();
    assert_eq!(drive.get(reference(&drive, "contact")).unwrap(), 1.0);
}
