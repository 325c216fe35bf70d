//! Every key of a train: its value at the right place, and the message at a wrong one.

use super::*;
use crate::document::Document;
use crate::document::input::Kind;
use camdrive::drives::follower::load::Spring;
use camdrive::drives::shaft::motor::{Reference, Servo, Source, TorqueTable};
use std::f64::consts::TAU;

fn read_text(text: &str, notes: &mut Vec<String>) -> Result<Scene, String> {
    let read = |root: &Section<'_>| {
        for key in ["name", "model", "description"] {
            root.has(key);
        }
        let scene = read(root, "".as_ref());
        root.finish();
        notes.extend(root.faults.notes());
        scene
    };
    let scene = crate::document::input::read("train.toml", &Document::new(text.to_owned()), Kind::Scene, read)
        .map_err(|faults| faults.to_string())?;
    // The form in an FMU.
    let value = serde_json::to_value(&scene).unwrap();
    assert_eq!(serde_json::from_value::<Scene>(value).unwrap(), scene);
    assert_eq!(postcard::from_bytes::<Scene>(&postcard::to_stdvec(&scene).unwrap()).unwrap(), scene);
    Ok(scene)
}

fn scene(text: &str) -> Scene {
    read_text(text, &mut Vec::new()).unwrap_or_else(|faults| panic!("{faults}"))
}

/// Asserts a fault in one line with all of these pieces.
fn refused(text: &str, pieces: &[&str]) {
    let faults = read_text(text, &mut Vec::new()).expect_err(text);
    assert!(pieces.iter().all(|piece| faults.contains(piece)), "{text}\n{faults}");
}

fn stored(name: &str) -> Scene {
    let path = format!("{}/../tests/fmpy/trains/{name}.toml", env!("CARGO_MANIFEST_DIR"));
    scene(&std::fs::read_to_string(path).unwrap())
}

fn free(scene: &Scene) -> &Machine {
    let Shaft::Free(machine) = &scene.shaft else { panic!("driven") };
    machine
}

#[test]
fn all_reference_trains_are_read() {
    let folder = format!("{}/../tests/fmpy/trains", env!("CARGO_MANIFEST_DIR"));
    let names = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let names: Vec<_> = names.filter(|path| path.extension().is_some_and(|ending| ending == "toml")).collect();
    assert!(names.len() > 25);
    for path in names {
        stored(path.file_stem().unwrap().to_str().unwrap());
    }
}

#[test]
fn loads_are_those_of_the_equations() {
    let train = stored("load_backlash");
    let Follower { load, roller, joint, rigid } = &train.followers[0];
    assert_eq!((load.gravity, load.damping, load.constant, load.input), (Some(-9.81), Some(15.0), None, false));
    assert_eq!((roller.gravity, roller.process.is_none(), rigid.m), (Some(-9.81), true, 0.0));
    let process = load.process.as_ref().unwrap();
    let at = |phi: f64| 20.0 * phi.cos() - 12.0 * (2.0 * phi).cos() + 7.0 * phi.sin() + 3.0 * (3.0 * phi).sin();
    assert!([0.3, 2.0, 5.0].iter().all(|&phi| (process.at(phi).0[0] - at(phi)).abs() < 1e-13));
    let Joint::Backlash(backlash) = joint else { panic!("{joint:?}") };
    assert_eq!(
        (backlash.m1, backlash.m2, backlash.c, backlash.b, backlash.s, backlash.e),
        (2.0, 8.0, 2e3, 20.0, 2e-3, 0.0)
    );
    let train = stored("lift_e04");
    let Joint::Backlash(backlash) = train.followers[0].joint else { panic!("no backlash") };
    assert_eq!((backlash.s, backlash.m2, backlash.c, backlash.e), (f64::INFINITY, 0.0, 0.0, 0.4));
    assert_eq!(train.followers[0].load.spring, Some(Spring { preload: 90.0, c: 2500.0, at: 0.0 }));
    assert!(stored("load_rigid").followers[0].load.input);
    let outputs = stored("outputs");
    let Joint::Output(parameters, roller) = outputs.followers[1].joint else { panic!("no spring") };
    assert_eq!((parameters.m, parameters.c, parameters.b, roller), (1.2, 9000.0, 6.0, 0.4));
    let machine = free(&outputs);
    assert_eq!((machine.friction, machine.load.as_ref().unwrap().at(0.0).0[0]), (Some(0.1), 5.5));
    let Joint::Shaft(parameters) = stored("shaft").followers[0].joint else { panic!("no shaft") };
    assert_eq!((parameters.m, parameters.inertia, parameters.c, parameters.b), (40.0, 0.15, 900.0, 1.5));
}

#[test]
fn gravity_acts_along_its_angle_and_a_spring_has_its_preload_at_the_least_place() {
    let drive = "drive = { speed = 1 }\n[[follower]]\ncam = { law = \"fourier\", a = [0.01, 0.03] }\n";
    let load = |text: &str| scene(&format!("{drive}m = 2\nload = {{ {text} }}")).followers.remove(0).load;
    for (angle, along) in [("0 deg", 10.0), ("60 deg", 5.0), ("-180 deg", -10.0)] {
        let found = load(&format!("gravity = 10, gravity_angle = \"{angle}\"")).gravity.unwrap();
        assert!((found - along).abs() < 1e-14, "{angle}: {found}");
    }
    assert_eq!(load("force = \"-3 N\"").constant, Some(-3.0));
    let spring = load("spring = { c = \"2 N/mm\" }").spring.unwrap();
    assert!((spring.at + 0.02).abs() < 1e-12 && spring.c == 2e3 && spring.preload == 0.0, "{spring:?}");
    // Links have their own weight; the tool moves along the x axis of the last frame.
    let linked = format!(
        "{drive}m = 2\nlinkage = [{{ kind = \"slider_crank\", crank = {{ length = 0.1, m = 1 }}, rod = {{ length = 0.4 }} }}]\n\
         load = {{ gravity = 10, gravity_angle = [\"30 deg\"] }}\n"
    );
    let Load { gravity, frames, .. } = scene(&linked).followers.remove(0).load;
    let (s, c) = (TAU / 12.0).sin_cos();
    assert_eq!((gravity, frames), (Some(10.0 * c), vec![[10.0 * c, 10.0 * s]]));
}

#[test]
fn forces_over_the_turn_are_lines_in_their_own_range() {
    let drive = "drive = { speed = 1 }\n[[follower]]\nm = 2\ncam = { law = \"fourier\", a = [0.01, 0.03] }\n";
    let process =
        |text: &str| scene(&format!("{drive}load.process = {text}")).followers.remove(0).load.process.unwrap();
    let press =
        "[[\"0 deg\", 0], [\"330 deg\", 0], [\"330 deg\", \"-20 kN\"], [\"345 deg\", \"-90 kN\"], [\"360 deg\", 0]]";
    let lines = process(&format!("{{ points = {press} }}"));
    assert!(matches!(lines, MotionLaw::Polyline(_)));
    assert!((lines.at(337.5_f64.to_radians()).0[0] + 55e3).abs() < 1e-8);
    assert_eq!(lines, process(&format!("{{ law = \"linear\", points = {press} }}")));
    assert_eq!(lines, process(&format!("{{ law = \"table\", interpolation = \"linear\", points = {press} }}")));
    assert_eq!(process("-7").at(1.0).0[0], -7.0);
    let halved = process(&format!(
        "{{ scale = \"0.5 N\", points = {} }}",
        press.replace("\"-20 kN\"", "-20e3").replace("\"-90 kN\"", "-90e3")
    ));
    assert!((halved.at(5.9).0[0] - 0.5 * lines.at(5.9).0[0]).abs() < 1e-9);
    assert!(process("{ law = \"cycle\", stroke = \"-90 kN\", rise = 1, upper_dwell = 1, return = 1, rise_law = \"modified_sine\" }").at(1.5).0[0] == -9e4);
    let spline = process(
        "{ interpolation = \"spline\", points = [[0, 0], [1.5, \"20 kN\"], [3, 0], [4.5, \"-20 kN\"], [\"360 deg\", 0]] }",
    );
    assert!(matches!(&spline, MotionLaw::Table(_)) && (spline.at(1.5).0[0] - 2e4).abs() < 1e-8);
    for (text, said) in [
        (
            "{ points = [[0, 0], [1, 5], [1, 6], [1, 7], [3, 0], [5, 0]] }",
            &["does not exceed the previous one", "two with one angle are a step"][..],
        ),
        ("{ points = [[0, 0], [1, \"5 mm\"], [3, 0], [5, 0]] }", &["points[1][2]", "5 mm", "a force is expected"]),
        (
            "{ points = [[0, 0], [1, 5, 6], [3, 0], [5, 0]] }",
            &["a pair of numbers is expected", "[\"32 deg\", \"80 N\"]"],
        ),
        ("{ points = [[0, 0], [1, 5]] }", &["ends here", "360 deg"]),
        ("{ points = [[0, 1e13], [3, 0], [6, 0]] }", &["1e13 N is out of range", "1e12 N"]),
        ("{ points = [[0, 0], [360, 0]] }", &["a table covers one turn"]),
        ("{ points = [[0, 0]] }", &["lines need at least 2"]),
        ("{ points = [[0, 0], [3, 0]], angle_unit = \"deg\" }", &["angle_unit", "every point has its own unit"]),
        ("{ points = [[0, 0], [3, 0]], file = \"force.csv\" }", &["give `points` or `file`, not both"]),
    ] {
        refused(&format!("{drive}load.process = {text}"), said);
    }
    let cam = |law: &str| format!("drive = {{ speed = 1 }}\n[[follower]]\nm = 2\ncam = {law}");
    refused(
        &cam("{ law = \"linear\", points = [[0, 0], [3, 0.1]] }"),
        &["cam.law", "the acceleration would be infinite", "a spline"],
    );
    refused(
        &cam("{ law = \"cycle\", stroke = 1e5, rise = 1, upper_dwell = 1, return = 1, rise_law = \"modified_sine\" }"),
        &["-10000 to 10000 m"],
    );
    refused(
        &cam("{ law = \"table\", points = [[0, 0], [1.5, 2e4], [3, 0], [4.5, 0]] }"),
        &["20000 m is out of range", "10000 m"],
    );
}

#[test]
fn motors_with_their_transmission() {
    let motor = |text: &str| {
        let mut notes = Vec::new();
        let scene = read_text(&format!("machine = {{ J0 = 1 }}\n[motor]\n{text}"), &mut notes)
            .unwrap_or_else(|e| panic!("{e}"));
        let Shaft::Free(machine) = scene.shaft else { panic!("driven") };
        (machine.motor, notes)
    };
    assert_eq!(free(&scene("machine = { J0 = 1 }")).motor, Default::default());
    assert_eq!(motor("kind = \"input\"").0.source, Source::Input);
    assert_eq!(motor("kind = \"constant\"\ntorque = \"5 N.m\"").0.source, Source::Constant(5.0));
    let table = TorqueTable { speeds: vec![0.0, 10.0], torques: vec![5.0, -1.0] };
    assert_eq!(motor("kind = \"table\"\npoints = [[0, 5], [\"10 rad/s\", -1]]").0.source, Source::Table(table));
    let servo = |text: &str| match motor(&format!("kind = \"servo\"\nK_p = 2\nK_i = 30\nM_max = 5\n{text}")).0.source {
        Source::Servo(servo) => servo,
        other => panic!("{other:?}"),
    };
    let Servo { proportional, integral, anti_windup, limit, reference, position } = servo("w_ref = \"600 rpm\"");
    assert_eq!((proportional, integral, anti_windup, limit, position), (2.0, 30.0, 15.0, 5.0, None));
    assert!(matches!(reference, Reference::Constant(w) if (w - TAU * 10.0).abs() < 1e-12));
    assert_eq!(servo("w_ref = { ramp = 60 }\nK_aw = \"3 1/s\"").reference, Reference::Ramp(60.0));
    let Servo { reference, position, .. } = servo("w_ref = \"input\"\nK_v = 12");
    assert_eq!((reference, position), (Reference::Input, Some(12.0)));
    let Reference::Series(frequency, series) =
        servo("w_ref = { frequency = \"2 Hz\", a = [20, 2], b = [6, -3] }").reference
    else {
        panic!("no series")
    };
    assert!((frequency - 2.0 * TAU).abs() < 1e-12);
    assert_eq!((series.a, series.b), (vec![20.0, 2.0, 0.0], vec![0.0, 6.0, -3.0]));
    let (behind, _) = motor("kind = \"constant\"\ntorque = 5\nratio = -3\nJ = 0.02\ncoupling = { c = 800, b = 1.2 }");
    assert_eq!(
        (behind.transmission.ratio, behind.transmission.rotor, behind.transmission.coupling),
        (-3.0, 0.02, Some([800.0, 1.2]))
    );
    let (belted, notes) = motor(
        "kind = \"constant\"\ntorque = 5\nJ = 0.02\nbelt = { EA = \"60 kN\", length = 0.5, radius = 0.1, preload = 300 }",
    );
    assert_eq!(
        (belted.transmission.coupling, notes),
        (Some([2400.0, 0.0]), vec!["`motor.belt`: both strands stay taut up to 60 N.m at the shaft".to_owned()])
    );
    for (text, said) in [
        ("kind = \"constant\"\ntorque = 5\nratio = 0", &["motor.ratio", "a value other than 0"][..]),
        ("kind = \"constant\"\ntorque = 5\ncoupling = { c = 800 }", &["motor.J", "greater than 0 kg.m2"]),
        (
            "kind = \"constant\"\ntorque = 5\nJ = 1\ncoupling = { c = 800 }\nbelt = {}",
            &["give `coupling` or `belt`, not both"],
        ),
        ("kind = \"constant\"\ntorque = 5\nM_max = 3", &["M_max", "kind = \"servo\""]),
        ("kind = \"table\"\npoints = [[3, 5], [1, 4]]", &["does not exceed the previous one, 3 rad/s"]),
        ("kind = \"table\"\npoints = [[3, 5]]", &["has 1 point", "2 to 200"]),
        ("kind = \"kloss\"\nM_k = 5\ns_k = 0.2\nw_s = 0", &["motor.w_s", "the slip is not defined"]),
        ("kind = \"servo\"\nK_p = 0\nM_max = 3\nw_ref = 1", &["motor.K_p", "greater than 0"]),
        ("kind = \"servo\"\nK_p = 2\nM_max = 3\nw_ref = \"inputs\"", &["neither a number nor \"input\""]),
        ("kind = \"servo\"\nK_p = 2\nM_max = 3\nw_ref = { ramp = 3, a = [1] }", &["w_ref.a", "a ramp has one slope"]),
        ("kind = \"servos\"", &["did you mean `servo`?"]),
    ] {
        refused(&format!("[machine]\nJ0 = 1\n[motor]\n{text}"), said);
    }
}

#[test]
fn what_contradicts_itself_is_refused() {
    let cam = "cam = { law = \"fourier\", a = [0, 0.03] }\n";
    let follower = |text: &str| format!("drive = {{ speed = 1 }}\n[[follower]]\n{cam}{text}");
    let elastic = "elasticity = { place = \"output\", m = 1, c = 1e4 }\n";
    let one_sided = "backlash = { m1 = 1, m2 = 2, c = 1e4, s = \"inf\" }\n";
    for (text, said) in [
        ("solver = {}", &["`machine` or `drive` is missing", "[machine] for a shaft"][..]),
        (
            "drive = { speed = 1 }\nmachine = { J0 = 1 }",
            &["`machine`: the drive prescribes the motion already", "not both"],
        ),
        ("drive = { speed = 1 }\nmotor = { kind = \"none\" }", &["`motor` has no meaning here: the drive prescribes"]),
        ("drive = { speed = 1 }\nstart = { w_start = 1 }", &["start.w_start", "[drive] prescribes the motion"]),
        ("machine = { J0 = 1 }\nstart = { w = 1 }", &["did you mean `w_start`?"]),
        ("machine = { J0 = 1 }\nstart = { mode = \"given\" }", &["at_rest, steady_state, equilibrium"]),
        ("machine = { J0 = 1 }\nsolver = { method = \"fixed_cost\" }", &["solver.method", "locates its events"]),
        (&follower(&format!("{elastic}m = 1")), &["follower[1].m", "`elasticity` has the masses"]),
        (&follower(""), &["follower[1].m", "is missing"]),
        (
            &follower("backlash = { m1 = 1, m2 = 2, c = 1e4, s = 0 }"),
            &["`follower[1].backlash.s`: without clearance", "greater than 0 m, or \"inf\"", "m_roller"],
        ),
        (
            &follower(&format!("{elastic}backlash = {{ m1 = 1, m2 = 2, c = 1e4, s = 0 }}")),
            &["follower[1].backlash", "has an elasticity already"],
        ),
        (
            &follower(&format!("{elastic}linkage = [{{ kind = \"gear\", radius = 0.1 }}]")),
            &["follower[1].linkage", "behind `elasticity` are not modelled"],
        ),
        (
            &follower("elasticity = { place = \"shaft\", m = 1, J = 1, c = 1e4, linear = true }"),
            &["elasticity.linear", "the whole equation"],
        ),
        (
            &follower("elasticity = { place = \"shaft\", m = 1, J = 1, c = 1e4, m_roller = 1 }"),
            &["m_roller", "place = \"output\""],
        ),
        (&follower(one_sided), &["backlash.s", "nothing brings the follower back", "spring = { preload = \"90 N\" }"]),
        (
            &follower(&format!("{one_sided}load = {{ force = -10, process = {{ law = \"fourier\", a = [20, 5] }} }}")),
            &["nothing brings the follower back"],
        ),
        (
            &follower(&format!("{one_sided}load = {{ gravity = 10, gravity_angle = 0 }}")),
            &["nothing brings the follower back"],
        ),
        (&follower("backlash = { m1 = 1, m2 = 2, c = 1e4, s = \"none\" }"), &["neither a number nor \"inf\""]),
        (&follower("backlash = { m1 = 1, c = 1e4, s = \"inf\" }\nload.gravity = 10"), &["backlash.c", "without `m2`"]),
        (&follower("backlash = { m1 = 1, m2 = 0, c = 1e4, s = 1 }"), &["backlash.m2", "out of range"]),
        (&follower("m = 1\nload = { roller = { force = 1 } }"), &["load.roller", "no mass on the cam's side"]),
        (&follower("J = 1\nload = { gravity = 10 }"), &["load.gravity", "counts as balanced"]),
        (&follower("m = 1\nload = { gravity_angle = 1 }"), &["load.gravity_angle", "there is no gravity"]),
        (&follower("m = 1\nload = { g = 10 }"), &["did you mean `gravity`?"]),
        (&follower("m = 1\nload = { spring = { preload = -5 } }"), &["spring.preload", "at least 0 N"]),
    ] {
        refused(text, said);
    }
    for text in [
        "load = { gravity = 10 }",
        "load = { force = -1 }",
        "load = { spring = { c = 5 } }",
        "load = { roller = { force = -1 } }",
        "load = { input = true }",
    ] {
        scene(&follower(&format!("{one_sided}{text}")));
    }
    scene(&follower("backlash = { m1 = 1, s = \"inf\" }\nload.gravity = 10"));
    let many = format!("drive = {{ speed = 1 }}\n{}", format!("[[follower]]\nm = 1\n{cam}").repeat(17));
    refused(&many, &["`follower`: there are 17 of them", "at most 16"]);
}
