//! Drives of valid scenes; wrong scenes are in `tests/scenes`.

use super::*;
use crate::document::diagnostics::Position;
use crate::document::keys;
use crate::document::section::Faults;
use camdrive::motion::{MotionLaw, StandardLaw};
use serde_json::Value;
use std::f64::consts::{PI, TAU};

/// The model and its values, before the drive is built.
fn resolved(text: &str) -> (&'static str, Value) {
    let document = Document::new(text.to_owned());
    assert!(document.errors.is_empty(), "{:?}", document.errors);
    let faults = Faults::new("scene.toml", &document);
    let scene = whole_scene(&Section::root(&faults, &document.table, &keys::SCENE), Path::new("../tests/scenes"));
    match scene {
        Some(scene) if faults.is_empty() => {
            let values = serde_json::to_value(&scene.scene).expect("values");
            (scene.scene.model(), values.as_object().expect("a model").values().next().expect("its values").clone())
        }
        _ => panic!("{}", faults.into_diagnostics()),
    }
}

fn number(value: &Value, name: &str) -> f64 {
    let value = value.get("parameters").unwrap_or(value);
    value[name].as_f64().unwrap_or_else(|| panic!("{name} is no number in {value}"))
}

fn cam(value: &Value) -> MotionLaw {
    serde_json::from_value(value["cam"].clone()).expect("a motion law")
}

fn close(a: f64, b: f64) {
    // Conversions of units round a few times.
    assert!((a - b).abs() <= 4.0 * f64::EPSILON * b.abs(), "{a} for {b}");
}

#[test]
fn an_elastic_output_by_frequency_and_ratio() {
    let (model, scene) = resolved(
        r#"
        name = "guide_bar"
        model = "ElasticCamDrive"
        cam = { law = "fourier", scale = "0.94 mm", a = [0.5, -0.5], b = [0.1] }
        drive = { speed = "1800 rpm", phi_start = "90 deg" }
        elasticity = { place = "output", m = "12 kg", natural_frequency = "270 Hz", damping_ratio = "3 %" }
        "#,
    );
    assert_eq!(model, "ElasticCamDrive.output");
    let w0 = 540.0 * PI;
    close(number(&scene, "m"), 12.0);
    close(number(&scene, "c"), 12.0 * w0 * w0);
    close(number(&scene, "b"), 2.0 * 0.03 * 12.0 * w0);
    let series = cam(&scene).series().cloned().expect("a series");
    assert_eq!((series.a, series.b), (vec![0.5 * 0.94e-3, -0.5 * 0.94e-3], vec![0.0, 0.1 * 0.94e-3]));
    close(number(&scene["drive"]["constant"], "w"), 60.0 * PI);
    close(number(&scene["drive"]["constant"], "phi_start"), PI / 2.0);
    assert_eq!(scene["start"]["mode"], "at_rest");
    assert_eq!(number(&scene["solver"], "tolerance"), 0.0);
}

#[test]
fn an_elastic_shaft_refers_frequency_and_ratio_to_the_mean_inertia() {
    let (model, scene) = resolved(
        r#"
        name = "manipulator"
        model = "ElasticCamDrive"
        cam = { law = "fourier", a = [0, 0.2, 0, "20 mm"] }
        drive = { mode = "input" }
        elasticity = { place = "shaft", m = 60, J = "1.5 kg.m2", natural_frequency = 80, damping_ratio = 0.03, linear = true }
        start = { mode = "given", q = "1 deg", q_dot = "0.5 rad/s" }
        solver = { tolerance = 1e-11 }
        "#,
    );
    assert_eq!(model, "ElasticCamDrive.shaft");
    // Mean of U′² = ½ Σ k² aₖ².
    let mean = 1.5 + 60.0 * 0.5 * (0.2 * 0.2 + 9.0 * 0.02 * 0.02);
    let c = number(&scene, "c");
    assert!((c / (mean * 6400.0) - 1.0).abs() < 1e-13, "{c}");
    assert!((number(&scene, "b") / (2.0 * 0.03 * mean * 80.0) - 1.0).abs() < 1e-13);
    assert_eq!((scene["linear"].as_bool(), scene["drive"].as_str()), (Some(true), Some("input")));
    close(number(&scene["start"], "q"), PI / 180.0);
    assert_eq!((number(&scene["start"], "q_dot"), number(&scene["solver"], "tolerance")), (0.5, 1e-11));
}

#[test]
fn a_cycle_fills_its_turn() {
    for (angles, rise, lower) in [
        ("rise = \"120 deg\", upper_dwell = \"60 deg\", return = \"100 deg\"", 120.0, 80.0),
        ("upper_dwell = \"60 deg\", return = \"100 deg\", lower_dwell = \"80 deg\"", 120.0, 80.0),
        ("rise = \"180 deg\", upper_dwell = 0, return = \"180 deg\"", 180.0, 0.0),
        ("rise = 2.0944, upper_dwell = 1.0472, return = 1.7453, lower_dwell = 1.3963", f64::NAN, 80.0),
    ] {
        let (_, scene) = resolved(&format!(
            "name = \"x\"\nmodel = \"ElasticCamDrive\"\n\
             cam = {{ law = \"cycle\", stroke = \"0.4 m\", rise_law = \"bestehorn\", return_law = \"modtrap\", {angles} }}\n\
             drive = {{ mode = \"input\" }}\nelasticity = {{ place = \"output\", m = 1, c = 1 }}"
        ));
        let MotionLaw::Cycle(cycle) = cam(&scene) else { panic!("no cycle") };
        let plan = cycle.plan();
        assert_eq!((plan.rise_law, plan.return_law), (StandardLaw::InclinedSine, StandardLaw::ModifiedTrapezoid));
        if !rise.is_nan() {
            assert!((plan.rise_angle - rise / 360.0 * TAU).abs() < 1e-14);
        }
        // Four angles of four digits meet the turn to 1e-4 rad; the lower dwell takes up the rest.
        assert!((plan.lower_dwell() - lower / 360.0 * TAU).abs() < 1e-4);
    }
}

#[test]
fn tables_become_splines_or_series() {
    let scene = |more: &str| {
        resolved(&format!(
            "name = \"x\"\nmodel = \"ElasticCamDrive\"\n\
             cam = {{ law = \"table\", file = \"table_good.csv\", angle_unit = \"deg\", lift_unit = \"mm\", {more} }}\n\
             drive = {{ mode = \"input\" }}\nelasticity = {{ place = \"output\", m = 1, c = 1 }}"
        ))
        .1
    };
    // The file holds 5 mm (1 − cos φ), rounded to 1e-6 mm.
    let series = cam(&scene("interpolation = \"fourier\", harmonics = 2")).series().cloned().expect("a series");
    for (coefficient, exact) in series.a.iter().zip([5e-3, -5e-3, 0.0]) {
        assert!((coefficient - exact).abs() < 1e-9, "{coefficient}");
    }
    let MotionLaw::Table(table) = cam(&scene("angle_column = \"phi\", lift_column = \"U\"")) else {
        panic!("no table")
    };
    assert_eq!(table.points().angles.len(), 12);
    assert!((table.points().lifts[6] - 0.01).abs() < 1e-9);
    // The exchanged columns are no table of angles: the refusal shows that the keys have an effect.
    let text = "name = \"x\"\nmodel = \"RigidMachine\"\n[machine]\nJ0 = 1\n[machine.J]\nlaw = \"table\"\n\
                file = \"table_good.csv\"\nangle_column = 2\nlift_column = 1\n";
    let faults = resolve("scene.toml", text, Path::new("../tests/scenes")).expect_err("not ascending");
    assert!(faults.to_string().contains("does not exceed"), "{faults}");
}

#[test]
fn a_machine_with_followers_and_motor() {
    let (model, scene) = resolved(
        r#"
        name = "loom"
        model = "RigidMachine"
        machine = { J0 = 2.8, J = { law = "fourier", a = [0, "0.1 kg.m2"] } }
        follower = [{ m = 1.6, cam = { law = "fourier", a = [0, 1] } }, { m = "60 kg", cam = { law = "fourier", a = [0, 2] } }]
        motor = { kind = "kloss", M_k = "220 N.m", s_k = "16 %", w_s = "500 rpm", lag = "2 ms" }
        start = { mode = "steady_state", w_start = "490 rpm" }
        "#,
    );
    assert_eq!(model, "RigidMachine");
    assert_eq!(number(&scene["inertia"], "constant"), 2.8);
    assert_eq!(scene["inertia"]["varying"]["fourier"]["a"][1], 0.1);
    assert_eq!((number(&scene["followers"][0], "m"), number(&scene["followers"][1], "m")), (1.6, 60.0));
    let motor = &scene["motor"]["kloss"];
    assert_eq!((number(motor, "breakdown_torque"), number(motor, "breakdown_slip")), (220.0, 0.16));
    close(number(motor, "synchronous_speed"), 500.0 * TAU / 60.0);
    assert_eq!(number(motor, "dynamics"), 2e-3);
    assert_eq!(scene["start"], "steady_state");
}

#[test]
fn loads_of_a_follower_behind_a_mechanism() {
    let text = r#"
        name = "machine"
        model = "RigidMachine"
        machine.J0 = 1
        [[follower]]
        J = 0.03
        cam = { law = "fourier", a = [0.26, -0.22] }
        linkage = [
            { kind = "gear", ratio = 1 },
            { kind = "four_bar", ground = 0.23, input = { length = 0.09 }, coupler = { length = 0.21 },
              output = { length = 0.12 }, input_offset = 1.1 },
        ]
        [follower.geometry]
        follower = "lever"
        pivot_distance = 0.16
        arm_length = 0.11
        roller_radius = 0.02
        start_angle = 0.55
        [follower.load]
        gravity = "9.81 m/s2"
        gravity_angle = ["90 deg", "-90 deg"]
        spring = { preload = "2 N.m", c = "3 N.m/rad", at = "90 deg" }
        process = { law = "fourier", a = ["-12 N.m"] }
        [follower.forces]
        lever_J = "4e-3 kg.m2"
        roller_width = "15 mm"
        E_roller = "110 GPa"
        nu_cam = 0.25
        [[follower]]
        m = 1
        cam = { law = "fourier", a = [0.0, 0.1] }
        [follower.load]
        gravity = 10
        process = "-5 N"
    "#;
    let scene = resolve("scene.toml", text, Path::new("")).unwrap_or_else(|faults| panic!("{faults}"));
    let [behind, alone] = &scene.loads[..] else { panic!("{:?}", scene.loads) };
    let [first, second] = behind.load.frames[..] else { panic!("{behind:?}") };
    assert!((first[1] - 9.81).abs() < 1e-15 && (second[1] + 9.81).abs() < 1e-15 && first[0].abs() < 1e-15);
    let spring = behind.load.spring.expect("a spring");
    assert_eq!((spring.preload, spring.c, spring.at), (2.0, 3.0, PI / 2.0));
    let process = |loads: &Loads| loads.load.process.as_ref().expect("a force").at(1.0).0[0];
    assert_eq!((process(behind), behind.lever_inertia), (-12.0, 4e-3));
    let material = behind.material.expect("a roller");
    assert_eq!((material.width, material.elasticity, material.poisson), (0.015, [210e9, 110e9], [0.25, 0.3]));
    // Gravity acts against the motion by default.
    assert_eq!((alone.load.gravity, alone.load.frames.len(), behind.load.gravity), (Some(-10.0), 0, None));
    assert_eq!((process(alone), alone.material, alone.load.spring), (-5.0, None, None));
}

#[test]
fn of_many_faults_the_first_are_told_and_the_others_counted() {
    // If each fault counted the lines before it, either would take a quarter of an hour.
    let scene = |law: &str| format!("name = \"x\"\nmodel = \"RigidMachine\"\n[machine]\nJ0 = 1\n[machine.J]\n{law}");
    let faults = |law: &str, folder: &Path| resolve("scene.toml", &scene(law), folder).expect_err("all wrong").0;
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("wrong.csv"), "phi;J\n".to_owned() + &"one;1\n".repeat(400_000)).unwrap();
    let told = faults("law = \"table\"\nfile = \"wrong.csv\"\n", folder.path());
    assert_eq!(told.len(), 9);
    let lines: Vec<usize> = told.iter().filter_map(|fault| Some(fault.position.as_ref()?.line)).collect();
    assert_eq!(lines, [2, 3, 4, 5, 6, 7, 8, 9]);
    assert_eq!(told[8].message, "the table has 399992 more faults like these");
    let told = faults(&format!("law = \"fourier\"\na = [{}]\n", "true, ".repeat(200_000)), folder.path());
    assert_eq!(told.len(), 101);
    let Some(Position { column, excerpt: [before, here], .. }) = &told[99].position else { panic!("{}", told[99]) };
    assert_eq!((*column, before.chars().count(), here.chars().count()), (600, 41, 61), "{before}{here}");
    assert_eq!(told[100].message, "there are 199900 more faults");
}

#[test]
fn an_elastic_drive_has_the_loads_of_its_scene() {
    let text = r#"
        name = "loaded"
        model = "ElasticCamDrive"
        cam = { law = "fourier", scale = 0.06, a = [0.0, 0.5867, 0.0, -0.0984, 0.0, 0.0115] }
        drive = { speed = 14 }
        elasticity = { place = "output", m = 2, c = 20000, b = 16, m_roller = 0.3 }
        start.mode = "equilibrium"
        [load]
        gravity = "9.81 m/s2"
        spring = { preload = "40 N", c = 3000, at = 0.01 }
        damping = 15
        process = { law = "fourier", a = [0.0, 20.0, -12.0], b = [7.0, 0.0, 3.0] }
        roller = { gravity = "9.81 m/s2", force = -5 }
    "#;
    let drive = resolve("loaded.toml", text, "".as_ref()).unwrap().resource().build().unwrap();
    let names: Vec<&str> = drive.descriptions().iter().map(|d| d.name.as_str()).collect();
    let expected = ["load.g", "load.preload", "load.c", "load.at", "load.b", "load.process.b[3]", "load.roller.F0"];
    assert!(expected.iter().all(|name| names.contains(name)), "{names:?}");
    assert!(!names.contains(&"F") && !names.contains(&"load.F0"), "{names:?}");
    let shaft = text.replace("m_roller = 0.3", "J = 1").replace("\"output\"", "\"shaft\"");
    let faults = resolve("loaded.toml", &shaft, "".as_ref()).unwrap_err().to_string();
    assert!(faults.contains("`load.roller` has no meaning here"), "{faults}");
    let shaft = shaft.replace("        roller = {", "        #");
    let drive = resolve("loaded.toml", &shaft, "".as_ref()).unwrap().resource().build().unwrap();
    assert!(expected[..6].iter().all(|name| drive.descriptions().iter().any(|d| d.name == *name)));
}

#[test]
fn scenes_may_be_in_utf_16() {
    let text = "# Größe\nname = \"utf\"\nmodel = \"ElasticCamDrive\"\ncam = { law = \"fourier\", a = [0, \"1 mm\"] }\n\
                drive = { speed = \"600 rpm\" }\nelasticity = { place = \"output\", m = \"1 kg\", c = 1 }\n";
    let folder = tempfile::tempdir().expect("a folder");
    let read = |bytes: Vec<u8>| {
        let path = folder.path().join("scene.toml");
        std::fs::write(&path, bytes).expect("a file");
        super::read(&path).map(|scene| scene.name).map_err(|faults| faults.to_string())
    };
    let units = |unit: fn(u16) -> [u8; 2]| text.encode_utf16().flat_map(unit).collect::<Vec<u8>>();
    let (little, big) = (units(u16::to_le_bytes), units(u16::to_be_bytes));
    for bytes in [
        text.as_bytes().to_vec(),
        [&[0xff, 0xfe], &little[..]].concat(),
        [&[0xfe, 0xff], &big[..]].concat(),
        little,
        big,
    ] {
        assert_eq!(read(bytes), Ok("utf".to_owned()));
    }
    let workbook = read(b"PK\x03\x04\0\0xl/workbook.xml\0".to_vec()).unwrap_err();
    assert!(workbook.contains("this is a workbook (.xlsx), not a scene"), "{workbook}");
}
