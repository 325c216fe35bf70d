//! Tables from designers, against the laws they were taken from.

use crate::scene::resolve;
use camdrive::drives::parametric::{self, law::Law};
use camdrive::motion::{Fourier, MotionLaw};
use camdrive_design::cam_geometry::cam_table::CamTable;
use camdrive_design::resource::Scene;
use camdrive_design::text::number;
use std::f64::consts::{PI, TAU};
use std::path::Path;

/// The law of a drive with these keys of `[cam]` in addition to `law` and `angle_unit` or its replacement, and the notes on it.
fn cam(folder: &Path, keys: &str) -> Result<(MotionLaw, String), String> {
    let text = format!(
        "name = \"x\"\nmodel = \"ElasticCamDrive\"\ncam = {{ law = \"table\", {keys} }}\ndrive = {{ mode = \"input\" }}\n\
         elasticity = {{ place = \"output\", m = 1, c = 1 }}"
    );
    let scene = resolve("scene.toml", &text, folder).map_err(|faults| faults.to_string())?;
    Ok((scene.scene.cam().expect("a law").clone(), scene.notes.join("\n")))
}

fn stored(keys: &str) -> MotionLaw {
    cam(Path::new("../tests/tables"), keys).unwrap_or_else(|faults| panic!("{keys}: {faults}")).0
}

/// The law, or the faults, of a file with this content.
fn of(content: &str, keys: &str) -> Result<(MotionLaw, String), String> {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("t.csv"), content).expect("a file");
    cam(folder.path(), &format!("file = \"t.csv\", {keys}"))
}

/// The largest |U − expected| at 3600 angles.
fn error(law: &MotionLaw, expected: impl Fn(f64) -> f64) -> f64 {
    let angle = |i: u32| TAU * f64::from(i) / 3600.0 - PI;
    (0..3600).map(|i| (law.at(angle(i)).0[0] - expected(angle(i))).abs()).fold(0.0, f64::max)
}

#[test]
fn crank_degrees_are_those_of_a_cam_that_turns_half_as_fast() {
    // A simple sine over 260 degrees of crank, rounded to a thousandth of the lift; its acceleration jumps at both ends.
    let lift = |phi: f64| {
        let z = (2.0 * phi.to_degrees() + 30.0).rem_euclid(720.0) / 260.0;
        if z < 1.0 { 5.775e-3 * (1.0 - (TAU * z).cos()) } else { 0.0 }
    };
    let file = "file = \"crank_degrees.csv\", scale = \"0.1155 mm\"";
    let law = stored(&format!("{file}, angle_unit = \"deg\", turn = \"720 deg\""));
    assert!(error(&law, lift) < 3e-5, "{}", error(&law, lift));
    assert!((law.at(50.0_f64.to_radians()).0[0] - 11.55e-3).abs() < 1e-12);
    for keys in [
        "turn = \"720 deg\"",
        "turn = \"2 rev\", angle_unit = \"deg\"",
        "turn = 720",
        "turn = 720, angle_unit = \"deg\"",
    ] {
        let other = stored(&format!("{file}, {keys}, angle_column = \"Crank angle [deg]\", lift_column = 2"));
        assert!(error(&other, |phi| law.at(phi).0[0]) < 1e-15, "{keys}");
    }
    let told = cam(Path::new("../tests/tables"), &format!("{file}, angle_unit = \"deg\"")).unwrap_err();
    assert!(told.contains("370 deg after the first one") && told.contains("turn = \"720 deg\""), "{told}");
}

#[test]
fn the_turn_may_be_counted_timed_or_measured_and_begin_anywhere() {
    let lift = |phi: f64| 5e-3 * (1.0 - phi.cos());
    let rows = |first: f64, turn: f64, n: u32| {
        let row = |i: u32| {
            (
                first + turn * f64::from(i) / f64::from(n),
                5.0 * (1.0 - (TAU * (first / turn + f64::from(i) / f64::from(n))).cos()),
            )
        };
        (0..=n).map(row).map(|(x, u)| format!("{x};{u}\n")).collect::<String>()
    };
    for (first, turn, keys) in [
        (0.0, 4096.0, "turn = 4096"),
        (0.0, 0.25, "turn = \"0.25 s\""),
        (0.0, 250.0, "turn = \"250 ms\""),
        (0.0, 250.0, "turn = \"0.25 s\", angle_unit = \"ms\""),
        (10.0, 314.0, "turn = \"314 mm\""),
        (-360.0, 360.0, "angle_unit = \"deg\""),
        (90.0, 720.0, "turn = \"720 deg\""),
        (-0.5, 1.0, "angle_unit = \"rev\""),
    ] {
        let (law, _) = of(&rows(first, turn, 64), &format!("lift_unit = \"mm\", {keys}")).unwrap();
        assert!(error(&law, lift) < 1e-10, "{keys}: {}", error(&law, lift));
    }
    let points =
        "points = [[\"0 ms\", 0], [\"125 ms\", 0.01], [\"62.5 ms\", 0.005], [0.1875, 0.005]], turn = \"0.25 s\"";
    let told = cam(Path::new(""), points).unwrap_err();
    assert!(told.contains("the angle 0.0625 s does not exceed the previous one, 0.125 s"), "{told}");
    for (keys, part) in [
        ("turn = \"720 N\"", "an angle is expected"),
        ("turn = 0", "greater than 0"),
        ("turn = \"720 deg\", angle_unit = \"ms\"", "an angle is expected"),
        ("turn = \"0.25 s\", period = \"90 deg\"", "a time is expected"),
        ("angle_unit = \"deg\", period = \"100 deg\"", "the turn is 3.6 periods"),
        ("angle_unit = \"deg\", period = \"0.001 deg\"", "360000 times 65 points"),
        ("turn = 4096, period = 2048", "2112 counts after the first one; a table covers one period, 2048 counts"),
        ("angle_unit = \"deg\", period = \"720 deg\"", "a whole fraction of the turn"),
        ("angle_unit = \"deg\", outside = \"linear\"", "\"linear\" is not known"),
        ("turn = 4096, lift_column = 1", "column 1 is used twice"),
        ("turn = 2048", "this point is 2112 counts after the first one; a table covers one turn, 2048 counts"),
        ("turn = 8192", "4096 counts before its turn does"),
    ] {
        let told = of(&rows(0.0, 4096.0, 64), keys).unwrap_err();
        assert!(told.contains(part), "{keys}: {told}");
    }
    for content in ["", "phi;U\n", "0;0\n", "0;0\n10;1\n"] {
        for keys in [
            "period = \"90 deg\"",
            "outside = \"rest\"",
            "interpolation = \"monotone\", period = \"90 deg\"",
            "interpolation = \"derivatives\"",
        ] {
            assert!(of(content, &format!("angle_unit = \"deg\", {keys}")).is_err(), "{content:?} {keys}");
        }
    }
}

#[test]
fn decimal_commas_and_several_headings_are_the_same_table() {
    let lift = |phi: f64| 5e-3 * (1.0 - phi.cos());
    for file in ["tab.txt", "blank.txt", "two_headings.csv"] {
        let law = stored(&format!("file = \"{file}\", angle_unit = \"deg\", lift_unit = \"mm\""));
        assert!(error(&law, lift) < 2e-7, "{file}: {}", error(&law, lift));
    }
    let (_, notes) = of("Points;4\n0;0\n90;1\n180;2\n270;1\n", "angle_unit = \"deg\"").unwrap();
    assert!(notes.contains("line 1 of") && notes.contains("\"Points;4\", is taken as a heading"), "{notes}");
    let (_, notes) = of("0;0\n90;1\n180;2\n270;1\nerr;err\nEndTable\n", "angle_unit = \"deg\"").unwrap();
    assert!(notes.contains("line 5 of") && notes.contains("\"err;err\", is taken as the end of the table"), "{notes}");
    assert!(!notes.contains("EndTable"), "{notes}");
}

#[test]
fn headings_in_latin_1_are_told() {
    let folder = tempfile::tempdir().unwrap();
    let bytes = [&b"Winkel [\xb0];Hub\n"[..], b"0;0\n90;1\n180;2\n270;1\n"].concat();
    std::fs::write(folder.path().join("t.csv"), bytes).unwrap();
    let (law, notes) = cam(
        folder.path(),
        "file = \"t.csv\", angle_column = \"Winkel [°]\", lift_column = \"Hub\", angle_unit = \"deg\"",
    )
    .unwrap();
    assert!(notes.contains("it is read as Latin-1") && (law.at(PI).0[0] - 2.0).abs() < 1e-12, "{notes}");
}

#[test]
fn an_open_lobe_rests_outside_and_one_of_four_is_repeated() {
    let lobe = |phi: f64| if phi.abs() < 7.0 * PI / 18.0 { 0.01 * (phi * 9.0 / 7.0).cos().powi(4) } else { 0.0 };
    let keys = "angle_unit = \"deg\", lift_unit = \"mm\"";
    let file = format!("file = \"lobe.csv\", {keys}");
    let law = stored(&format!("{file}, outside = \"rest\""));
    // Its lifts are rounded to a ten thousandth of a millimetre.
    assert!(error(&law, lobe) < 2e-7, "{}", error(&law, lobe));
    for phi in [1.4, 2.0, 3.1, -2.5, -1.4] {
        assert_eq!(law.at(phi).0, [0.0; 5]);
    }
    let series = stored(&format!("{file}, outside = \"rest\", interpolation = \"fourier\", harmonics = 18"));
    assert!(error(&series, lobe) < 3e-6, "{}", error(&series, lobe));
    let monotone = stored(&format!("{file}, outside = \"rest\", interpolation = \"monotone\""));
    assert!(error(&monotone, lobe) < 1e-4 && monotone.at(2.0).0 == [0.0; 5], "{}", error(&monotone, lobe));
    let told = cam(Path::new("../tests/tables"), &file).unwrap_err();
    assert!(
        told.contains("210 deg before its turn does") && told.contains("`outside = \"rest\"` is for a lobe"),
        "{told}"
    );

    let four = |phi: f64| 3e-3 * (1.0 - (4.0 * phi).cos());
    let file = format!("file = \"one_of_four.csv\", {keys}");
    for (more, accuracy) in
        [("", 2e-7), (", interpolation = \"monotone\"", 3e-5), (", interpolation = \"fourier\", harmonics = 8", 1e-7)]
    {
        let law = stored(&format!("{file}, period = \"90 deg\"{more}"));
        assert!(error(&law, four) < accuracy, "{more}: {}", error(&law, four));
    }
    // In degrees of a crank that turns twice as often.
    let twice = stored(&format!("{file}, period = \"90 deg\", turn = \"720 deg\""));
    assert!(error(&twice, |phi| 3e-3 * (1.0 - (8.0 * phi).cos())) < 2e-7);
    let told = cam(Path::new("../tests/tables"), &format!("{file}, period = \"72 deg\"")).unwrap_err();
    assert!(told.contains("75 deg after the first one; a table covers one period, 72 deg"), "{told}");
    let told = cam(Path::new("../tests/tables"), &format!("{file}, period = \"120 deg\"")).unwrap_err();
    assert!(told.contains("30 deg before its period does"), "{told}");
}

#[test]
fn a_smoothed_rest_of_few_rows_rests() {
    let keys = "angle_unit = \"deg\", lift_unit = \"mm\", noise = \"estimate\"";
    let law = stored(&format!("file = \"fine_and_coarse.csv\", {keys}"));
    for i in 300..720 {
        let u = law.at(TAU * f64::from(i) / 720.0).0[0];
        // Three times the noise of 3 µm.
        assert!(u.abs() < 9e-6, "{}°: {u:e}", f64::from(i) / 2.0);
    }
    // Unmeasured rows next to the lobe keep its level, and a wrong one is left out.
    let lobe = |wrong: f64| {
        let row = |i: i32| {
            let lift = 10.0 * (f64::from(i) * PI / 140.0).cos().powi(4) + 3e-3 * (f64::from(i * i) * 1.7).sin();
            format!("{i};{:.4}\n", lift + if i == 20 { wrong } else { 0.0 })
        };
        (-70..=70).map(row).collect::<String>()
    };
    for noise in ["", ", noise = \"estimate\"", ", noise = 2e-6"] {
        let keys = format!("angle_unit = \"deg\", lift_unit = \"mm\", outside = \"rest\"{noise}");
        let told = of(&lobe(0.1), &keys).unwrap_err();
        let by = told.split_once("the lift at 20 deg is ").and_then(|(_, rest)| rest.split(' ').next());
        let by: f64 = by.and_then(|by| by.parse().ok()).expect(&told);
        assert!((by - 0.1).abs() < 0.01 && told.contains(" mm off") && told.contains(":91:1"), "{told}");
        let (law, notes) = of(&lobe(0.1), &format!("{keys}, outliers = \"drop\"")).unwrap();
        let (right, _) = of(&lobe(0.0), &keys).unwrap();
        assert!(notes.contains("line 91 of"), "{notes}");
        for i in 0..720 {
            let phi = TAU * f64::from(i) / 720.0;
            let [found, right] = [&law, &right].map(|law| law.at(phi).0[0]);
            assert!((found - right).abs() < 1e-5, "{noise} {}°: {found:e} {right:e}", f64::from(i) / 2.0);
        }
        // Well away from its ends the rest is one level.
        let level = law.at(PI).0[0];
        assert!([2.0, 2.5, 4.0].iter().all(|phi| (law.at(*phi).0[0] - level).abs() < 1e-8), "{noise}");
    }
}

#[test]
fn ends_that_differ_within_the_noise_have_their_mean() {
    // Lifts that scatter by some 3 µm.
    let scatter = |i: u32| 3e-3 * (f64::from(i) * f64::from(i) * 1.7).sin() * 1.4;
    let rows = |last: f64| {
        let row = |i: u32| (f64::from(3 * i), 5.0 * (1.0 - f64::from(3 * i).to_radians().cos()) + scatter(i));
        (0..120).map(row).chain([(360.0, last)]).map(|(x, u)| format!("{x};{u:.6}\n")).collect::<String>()
    };
    let keys = "angle_unit = \"deg\", lift_unit = \"mm\"";
    let (law, notes) = of(&rows(0.008), keys).unwrap();
    assert!(
        notes.contains("0 mm and 0.008 mm, differ within the noise: both were set to their mean, 0.004 mm"),
        "{notes}"
    );
    assert!((law.at(0.0).0[0] - 4e-6).abs() < 1e-15);
    let told = of(&rows(0.2), keys).unwrap_err();
    assert!(told.contains("the lift 0.2 mm one turn after the first point is not its lift 0 mm"), "{told}");
    assert!(of(&rows(0.2), &format!("{keys}, noise = \"0.05 mm\"")).is_ok());
    // The last digit of rounded lifts.
    let lobe = |last: &str| format!("0;0.000\n10;0.5\n20;1.5\n30;2.000\n40;1.5\n50;0.5\n60;{last}\n");
    let (law, notes) = of(&lobe("0.001"), &format!("{keys}, outside = \"rest\"")).unwrap();
    assert!(notes.contains("their mean, 0.0005 mm") && (law.at(3.0).0[0] - 5e-7).abs() < 1e-15, "{notes}");
    let told = of(&lobe("0.30"), &format!("{keys}, outside = \"rest\"")).unwrap_err();
    assert!(told.contains("the ends of the lobe, 0 mm and 0.3 mm, differ"), "{told}");
    let told = of(&rows(0.0), &format!("{keys}, outside = \"rest\"")).unwrap_err();
    assert!(told.contains("covers the whole turn"), "{told}");
}

#[test]
fn a_spline_that_overshoots_is_told_and_a_monotone_curve_does_not() {
    let step: String = (0..36).map(|i| format!("{};{}\n", 10 * i, if (10..20).contains(&i) { 4 } else { 0 })).collect();
    let keys = "angle_unit = \"deg\", lift_unit = \"mm\"";
    let (spline, notes) = of(&step, keys).unwrap();
    let place = notes.split("`cam`: at ").nth(1).and_then(|rest| rest.split(" deg the spline").next()).expect(&notes);
    let u = spline.at(place.parse::<f64>().expect("an angle").to_radians()).0[0];
    let beyond = 100.0 * (u - 4e-3).max(-u) / 4e-3;
    assert!(beyond > 5.0 && notes.contains(&format!("by {beyond:.1} % of the range")), "{beyond}: {notes}");
    let (curve, notes) = of(&step, &format!("{keys}, interpolation = \"monotone\"")).unwrap();
    assert!(notes.is_empty() && error(&curve, |_| 2e-3) <= 2e-3 * (1.0 + 1e-12), "{notes}");
    assert!(of(&step.replace(";4", ";0.001"), keys).unwrap().1.contains("the spline leaves"));
    let smooth: String = (0..36).map(|i| format!("{};{}\n", 10 * i, f64::from(10 * i).to_radians().sin())).collect();
    assert_eq!(of(&smooth, keys).unwrap().1, "");
}

#[test]
fn tables_for_controllers_are_read_again_to_the_digit() {
    let lift = MotionLaw::Fourier(Fourier::new(vec![0.02, -0.015, 0.004], vec![0.0, 0.001, -0.002]));
    let table = CamTable::new(&lift, false, 1e-6);
    let keys = "angle_unit = \"deg\", lift_unit = \"mm\"";
    let (law, notes) = of(&table.plcopen(), &format!("{keys}, interpolation = \"derivatives\"")).unwrap();
    assert_eq!(notes, "");
    let (plain, _) = of(&table.two_columns(), keys).unwrap();
    for [phi, u, u1, u2] in &table.rows {
        let found = law.at(*phi % TAU).0;
        // Half of the last digits of lift, velocity and acceleration, and of the angle.
        let degree = TAU / 360.0;
        assert!((found[0] - u).abs() < 0.51e-10 + u1.abs() * 1e-8, "{phi}");
        assert!((found[1] - u1).abs() < 0.51e-12 / degree + u2.abs() * 1e-8, "{phi}: {} {u1}", found[1]);
        assert!((found[2] - u2).abs() < 0.51e-14 / degree / degree + 1e-9, "{phi}: {} {u2}", found[2]);
        assert!((plain.at(*phi % TAU).0[0] - u).abs() < 0.51e-10 + u1.abs() * 1e-8);
    }
}

#[test]
fn x_y_v_a_have_the_units_of_their_headings_or_are_by_the_radian() {
    let rows = |head: &str, by: f64, more: &str| {
        let row = |i: u32| {
            let (s, c) = (TAU * f64::from(i) / 72.0).sin_cos();
            format!("{} {} {} {}{more}\n", 5 * i, 10.0 * s, 10.0 * c * by, -10.0 * s * by * by)
        };
        format!("{head}{}", (0..=72).map(row).collect::<String>())
    };
    let keys = "lift_unit = \"mm\", interpolation = \"derivatives\"";
    let (degree, lift) = (TAU / 360.0, |phi: f64| 0.01 * phi.sin());
    for (table, keys) in [
        (rows("X[deg] Y[mm] V[mm/deg] A[mm/deg2]\n", degree, ""), "angle_unit = \"deg\""),
        (rows("X Y V[mm/deg] A[mm/deg2] J[mm/deg3]\n", degree, " 7"), "angle_unit = \"deg\""),
        (rows("phi_deg U_mm dU_mm_per_rad ddU_mm_per_rad2 dddU_mm_per_rad3\n", 1.0, " 7"), "angle_unit = \"deg\""),
        (rows("", 1.0, ""), "angle_unit = \"deg\""),
        (rows("X Y V[mm/s] A[mm/s2]\n", TAU / 360.0, ""), "turn = \"360 s\""),
    ] {
        let (law, _) = of(&table, &format!("{keys}, lift_unit = \"mm\", interpolation = \"derivatives\"")).unwrap();
        assert!(error(&law, lift) < 1e-9, "{keys}: {}", error(&law, lift));
    }
    // The jerk is no U″ after the points.
    let told = of(&rows("", 1.0, " 2000"), &format!("angle_unit = \"deg\", {keys}")).unwrap_err();
    assert!(told.contains("U″ of this table is") && told.contains("times the value from its U′"), "{told}");
    // Degrees without their unit.
    let told = of(&rows("", degree, ""), &format!("angle_unit = \"deg\", {keys}")).unwrap_err();
    assert!(
        told.contains("U′ of this table is 0.0175 times the value from its lifts") && told.contains("V [mm/deg]"),
        "{told}"
    );
}

#[test]
fn inertia_and_coefficients_are_monotone_and_have_no_steps() {
    let scene = |text: &str| resolve("scene.toml", text, Path::new("")).map_err(|faults| faults.to_string());
    let points = "[[\"0 deg\", 0.2], [\"60 deg\", 0.2], [\"90 deg\", 0.5], [\"200 deg\", 0.5], [\"300 deg\", 0.3]]";
    let machine = |keys: &str| {
        scene(&format!(
            "name = \"x\"\nmodel = \"RigidMachine\"\n[machine]\nJ0 = 1\nJ = {{ law = \"table\", {keys} }}\n"
        ))
    };
    let law = |keys: &str| -> MotionLaw {
        let Scene::RigidMachine(machine) = machine(keys).unwrap().scene else { panic!("no machine") };
        machine.inertia.varying.expect("a law")
    };
    let (curve, lines) =
        (law(&format!("points = {points}")), law(&format!("points = {points}, interpolation = \"linear\"")));
    let deg = |law: &MotionLaw, deg: f64| law.at(deg.to_radians()).0[0];
    assert!((deg(&lines, 75.0) - 0.35).abs() < 1e-14 && (deg(&curve, 75.0) - 0.35).abs() < 1e-14);
    assert!((deg(&lines, 67.5) - 0.275).abs() < 1e-14 && (deg(&curve, 67.5) - 0.246_875).abs() < 1e-14);
    let stepped = points.replace("\"90 deg\"", "\"60 deg\"");
    let told = machine(&format!("points = {stepped}")).unwrap_err();
    assert!(told.contains("60 deg does not exceed the previous one"), "{told}");
    let told = machine("points = [[0, 0.1], [1, 0.2], [3, 0.4], [5, 0.2], [\"360 deg\", 0.3]]").unwrap_err();
    assert!(told.contains("the table is not periodic: the value 0.3 kg.m2"), "{told}");

    // 6 + cos φ + … in kN·m/rad every 5°.
    let stiffness = |phi: f64| 6e3 + 1e3 * phi.cos() - 2e2 * (3.0 * phi).sin();
    let rows = (0..72).map(|i| format!("[\"{} deg\", {}]", 5 * i, stiffness(f64::from(5 * i).to_radians())));
    let rows = rows.collect::<Vec<_>>().join(", ");
    let drive = |more: &str| {
        let c = format!("c = {{ law = \"table\", points = [{rows}]{more} }}");
        let scene = scene(&format!(
            "name = \"x\"\nmodel = \"ParametricDrive\"\ndrive = {{ speed = 1 }}\n[coefficients]\nm = 1\n{c}\n"
        ))
        .unwrap();
        let Scene::ParametricDrive(parametric::Scene { law: Law::Series(law), .. }) = &scene.scene else {
            panic!("no series")
        };
        let series = &law.c;
        let error = error(&MotionLaw::Fourier(series.clone()), stiffness);
        (error, series.order(), scene.notes.join("\n"))
    };
    let (error, order, notes) = drive(", interpolation = \"spline\"");
    assert!(
        error < 1.0 && order == 4 && notes.contains("`coefficients.c`: 4 harmonics meet the law to"),
        "{error} {order} {notes}"
    );
    // PCHIP flattens the summits by h²/8 U″.
    let (error, order, _) = drive("");
    assert!(error < 4.0 && order <= 64, "{error} {order}");
    let (error, order, _) = drive(", interpolation = \"fourier\", harmonics = 3");
    assert!(error < 1e-9 && order == 3, "{error} {order}");
}

#[test]
fn headings_have_units_where_they_are_clear() {
    let folder = tempfile::tempdir().unwrap();
    let read = |headings: &str, keys: &str| {
        let rows: String =
            (0..72).map(|i| format!("{};{:.6}\n", 5 * i, 5.0 * (1.0 - f64::from(5 * i).to_radians().cos()))).collect();
        std::fs::write(folder.path().join("t.csv"), format!("{headings}\n{rows}")).unwrap();
        cam(folder.path(), &format!("file = \"t.csv\", {keys}")).map(|(law, notes)| (law.at(PI).0[0], notes))
    };
    for headings in
        ["phi [deg];s [mm]", "phi_deg;s_mm", "# probe 3 um\nphi [deg];s (probe) [mm]", "Probe;3 um\nphi;s\ndeg;mm"]
    {
        let (lift, notes) =
            read(headings, "angle_unit = \"deg\"").unwrap_or_else(|faults| panic!("{headings}: {faults}"));
        assert!((lift - 0.01).abs() < 1e-9 && notes.is_empty(), "{headings}: {lift} {notes}");
        assert!(read(headings, "").is_ok() && read(headings, "angle_unit = \"deg\", lift_unit = \"mm\"").is_ok());
        let told = read(headings, "lift_unit = \"um\"").unwrap_err();
        assert!(told.contains("`cam.lift_unit`: the heading of its column says mm"), "{told}");
    }
    // Letters and words that are no units, and units of other quantities.
    for (headings, note) in [
        ("phi_in;s_m", ""),
        ("Winkel in Grad;Hub", ""),
        ("Probe;20 um\nphi;s", ""),
        ("phi [Grad];s [-]", ""),
        ("phi;s [1/100 mm]", "\"1/100 mm\" in the heading of column 2 is not the unit of a length; `lift_unit` holds"),
        ("time [s];s", "\"s\" in the heading of column 1 is not the unit of an angle; `angle_unit` holds"),
    ] {
        let (lift, notes) =
            read(headings, "angle_unit = \"deg\", lift_unit = \"mm\"").unwrap_or_else(|e| panic!("{headings}: {e}"));
        assert!((lift - 0.01).abs() < 1e-9 && notes.contains(note), "{headings}: {lift} {notes}");
        assert_eq!(notes.is_empty(), note.is_empty(), "{headings}: {notes}");
    }
    // Noise at both ends of a lobe.
    let noisy: String = (0..71)
        .map(|i: u32| {
            let noise = 3e-3 * (f64::from(i * i) * 1.7 + 0.9).sin() * 1.4;
            format!(
                "{};{:.4}\n",
                2 * i,
                5.0 * (1.0 - (f64::from(i) / 35.0 * PI).cos()) + noise + if i == 70 { -3e-3 } else { 0.0 }
            )
        })
        .collect();
    std::fs::write(folder.path().join("lobe.csv"), noisy).unwrap();
    let keys = "file = \"lobe.csv\", angle_unit = \"deg\", lift_unit = \"mm\", outside = \"rest\"";
    for noise in ["", ", noise = \"estimate\"", ", noise = \"3 um\""] {
        let (law, _) =
            cam(folder.path(), &format!("{keys}{noise}")).unwrap_or_else(|faults| panic!("{noise}: {faults}"));
        assert!((law.at(70_f64.to_radians()).0[0] - 0.01).abs() < 1e-5, "{noise}");
    }
    // A left-out row is reported with the law.
    let exact: String = (0..360)
        .map(|i| {
            format!("{i};{:.7}\n", 5.0 * (1.0 - f64::from(i).to_radians().cos()) + if i == 70 { 0.1 } else { 0.0 })
        })
        .collect();
    std::fs::write(folder.path().join("wrong.csv"), exact).unwrap();
    let text = "name = \"x\"\nmodel = \"ElasticCamDrive\"\ncam = { law = \"table\", file = \"wrong.csv\", angle_unit = \"deg\", lift_unit = \"mm\", \
                outliers = \"drop\" }\ndrive = { mode = \"input\" }\nelasticity = { place = \"output\", m = 1, c = 1 }";
    let scene = resolve("scene.toml", text, folder.path()).unwrap_or_else(|faults| panic!("{faults}"));
    assert!(scene.description.contains("1 wrong row of the table of cam is left out."), "{}", scene.description);
}

/// A table whose pieces are polynomials 3-4-5 between rests, as U, U′ and U″ at equal distances.
fn polynomial(step: usize, scale: [f64; 2]) -> String {
    let part = |z: f64| {
        [
            z * z * z * (10.0 - 15.0 * z + 6.0 * z * z),
            30.0 * (z * (1.0 - z)).powi(2),
            60.0 * z * (1.0 - 3.0 * z + 2.0 * z * z),
        ]
    };
    let row = |degree: usize| {
        let (z, down) = (degree as f64 / 120.0, (degree as f64 - 180.0) / 120.0);
        let [u, v, a] = match degree {
            0..120 => part(z),
            120..180 => [1.0, 0.0, 0.0],
            180..300 => part(1.0 - down)
                .into_iter()
                .zip([1.0, -1.0, 1.0])
                .map(|(d, s)| d * s)
                .collect::<Vec<_>>()
                .try_into()
                .unwrap(),
            _ => [0.0; 3],
        };
        format!("{degree};{};{};{}\n", 20.0 * u, scale[0] * v / 6.0, scale[1] * a / 720.0)
    };
    "phi [deg];U [mm];V [mm/deg];A [mm/deg2]\n".to_owned() + &(0..=360).step_by(step).map(row).collect::<String>()
}

#[test]
fn rests_alone_tell_their_law() {
    let keys = "interpolation = \"derivatives\"";
    let (right, _) = of(&polynomial(5, [1.0, 1.0]), keys).unwrap();
    let rests = "X [deg],Y [mm],V [mm/deg],A [mm/deg2]\n0,0,0,0\n120,20,0,0\n180,20,0,0\n300,0,0,0\n360,0,0,0\n";
    let (law, _) = of(rests, keys).unwrap();
    assert!(error(&law, |phi| right.at(phi).0[0]) < 1e-12, "{}", error(&law, |phi| right.at(phi).0[0]));
    // U″ is zero in every row where the law turns from one velocity to another.
    let even = "0;0;0;0\n90;5;6.36620;0\n180;15;6.36620;0\n270;20;0;0\n360;0;0;0\n";
    let (law, _) =
        of(even, &format!("{keys}, angle_unit = \"deg\", lift_unit = \"mm\"")).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(law.at(PI / 2.0).0[2], 0.0);
}

#[test]
fn derivatives_of_another_angle_are_refused_by_what_the_lifts_know() {
    let told = |step: usize, scale: [f64; 2]| of(&polynomial(step, scale), "interpolation = \"derivatives\"");
    for step in [2, 5, 10] {
        assert!(told(step, [1.0, 1.0]).is_ok(), "{step}");
        for part in [0.017_453, 0.3, 0.5, 0.8, 0.95, 1.05, 1.2, 2.0, 3.0, 57.3, -1.0] {
            let slopes = told(step, [part, 1.0]).unwrap_err();
            assert!(
                slopes.contains("U′ of this table is") && slopes.contains("times the value from its lifts"),
                "{part}: {slopes}"
            );
            // U′ shows less of U″ than the lifts show of U′.
            if step > 5 && (part - 1.0_f64).abs() < 0.1 {
                continue;
            }
            let bends = told(step, [1.0, part]).unwrap_err();
            assert!(
                bends.contains("U″ of this table is") && bends.contains("times the value from its U′"),
                "{part}: {bends}"
            );
        }
    }
}

#[test]
fn before_the_seam_the_closing_row_holds() {
    let rows = |first: &str, last: &str| {
        let middle = "30;150;0;0;0.0355555555556\n105;250;2.66666666667;0.0355555555556;-0.0355555555556\n\
                      180;350;0;-0.0355555555556;-0.0355555555556\n255;250;-2.66666666667;-0.0355555555556;0.0355555555556\n";
        let head = "phi [deg];U [mm];dU [mm/deg];ddU0 [mm/deg2];ddU1 [mm/deg2]\n";
        of(&format!("{head}-30;150;{first}\n{middle}330;150;{last}\n"), "interpolation = \"derivatives\"")
    };
    let before = "0.0355555555556";
    let (right, _) = rows(&format!("0;{before};0"), &format!("0;{before};0")).unwrap();
    let (law, _) = rows("0;0;0", &format!("0;{before};{before}")).unwrap();
    for order in 0..3 {
        let off = |phi: f64| (law.at(phi).0[order] - right.at(phi).0[order]).abs();
        assert!((0..720).all(|i| off((f64::from(i) + 0.5).to_radians() / 2.0) < 1e-12), "{order}");
    }
    let told = rows(&format!("0;{before};0"), &format!("0.5;{before};0")).unwrap_err();
    assert!(told.contains("t.csv:7") && told.contains("U′ of this row, which closes the turn"), "{told}");
    // One U″ in each row, and two rows where it jumps.
    let single = "phi [deg];U [mm];dU [mm/deg];ddU [mm/deg2]\n-30;150;0;0\n30;150;0;0\n30;150;0;0.0355555555556\n\
                  105;250;2.66666666667;0.0355555555556\n105;250;2.66666666667;-0.0355555555556\n180;350;0;-0.0355555555556\n\
                  255;250;-2.66666666667;-0.0355555555556\n255;250;-2.66666666667;0.0355555555556\n330;150;0;0.0355555555556\n";
    let (law, _) = of(single, "interpolation = \"derivatives\"").unwrap();
    let off = |phi: f64| (law.at(phi).0[2] - right.at(phi).0[2]).abs();
    assert!((0..720).all(|i| off((f64::from(i) + 0.5).to_radians() / 2.0) < 1e-12));
}

#[test]
fn controllers_begin_and_end_their_tables() {
    let lift = |i: u32| 5.0 * (1.0 - (TAU * f64::from(i) / 36.0).cos());
    let rows = |separator: &str, comment: &str| {
        (0..=36).map(|i| format!("{}{separator}{:.4}{comment}\n", 10 * i, lift(i))).collect::<String>()
    };
    let keys = "angle_unit = \"deg\", lift_unit = \"mm\"";
    for (begin, separator, comment, end) in [
        (
            "Tablename = LIFT   # name\nTable-ID = 17\nLines = 37\nBegintable   # begin\n",
            "   ",
            "    # MasterPos SlavePos",
            "EndTable  # end\n",
        ),
        ("* CAM 1\n[TABLE]\nMaster;Slave\n", ";", "", "[END]\n\n"),
        ("; points\nX;Y\n", ";", " // point", "END_CAM;\n; of the table\n"),
        ("(* cam *)\nCAM : ARRAY\n", "\t", "\t(* point *)", "END_VAR\n"),
        ("Master,Slave,Type\n", ",", ",Cubic", "End of table\n"),
        ("/* cam\n", " ", "", "*/\n}\n"),
        ("", ";", "", "Checksum: 4711\n"),
    ] {
        let (law, _) =
            of(&format!("{begin}{}{end}", rows(separator, comment)), keys).unwrap_or_else(|e| panic!("{end}: {e}"));
        assert!((law.at(PI / 2.0).0[0] - 5e-3).abs() < 1e-9, "{end}");
    }
    for end in ["36O;0\n", "nan;nan\n", "370;n/a\n", "END\n370;1\n"] {
        assert!(of(&(rows(";", "") + end), keys).is_err(), "{end}");
    }
    // Lifts alone, at equal distances.
    for (head, keys) in [
        ("", "angle_step = \"10 deg\", lift_unit = \"mm\""),
        ("Hub [mm]\n", "angle_step = 10, angle_unit = \"deg\""),
        ("36 points\n", "angle_step = \"25 ms\", turn = \"0.9 s\", lift_unit = \"mm\""),
    ] {
        for count in [36, 37] {
            let column: String = (0..count).map(|i| format!("{:.4}\n", lift(i))).collect();
            let (law, _) = of(&(head.to_owned() + &column), keys).unwrap_or_else(|e| panic!("{head}: {e}"));
            assert!((law.at(PI / 2.0).0[0] - 5e-3).abs() < 1e-9, "{head}");
        }
    }
    let count: String = "36\n".to_owned() + &(0..36).map(|i| format!("{}\n", lift(i))).collect::<String>();
    let told = of(&count, "angle_step = \"10 deg\"").unwrap_err();
    assert!(told.contains("is the count of the other rows, or a value"), "{told}");
    for (keys, part) in [
        ("angle_step = \"10 deg\", angle_column = 1", "`cam.angle_column`"),
        ("angle_step = \"-10 deg\"", "`cam.angle_step`"),
        ("angle_step = \"9 deg\", lift_unit = \"mm\"", "ends here"),
    ] {
        let column: String = (0..36).map(|i| format!("{}\n", lift(i))).collect();
        let told = of(&column, keys).unwrap_err();
        assert!(told.contains(part), "{keys}: {told}");
    }
}

#[test]
fn what_is_no_text_is_named() {
    let zip = |name: &str| [b"PK\x03\x04\0\0".as_slice(), name.as_bytes(), b"\0\0"].concat();
    let ole = b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1\0".to_vec();
    for (content, part) in [
        (zip("xl/workbook.xml"), "is a workbook (.xlsx)"),
        (zip("application/vnd.oasis.opendocument.spreadsheet"), "is a workbook (.ods)"),
        (zip("a"), "another zip archive"),
        (ole, "is a workbook (.xls)"),
        (b"%PDF-1.7\n".to_vec(), "is a PDF document"),
    ] {
        let folder = tempfile::tempdir().expect("a folder");
        std::fs::write(folder.path().join("t.csv"), content).expect("a file");
        let told = cam(folder.path(), "file = \"t.csv\", angle_unit = \"deg\"").unwrap_err();
        assert!(told.contains(part) && told.contains("save the table as CSV"), "{told}");
    }
}

/// The warnings of the tables of a scene whose law is in a file with this content.
fn warnings(content: &str, keys: &str) -> Vec<String> {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("t.csv"), content).expect("a file");
    let text = format!(
        "name = \"x\"\nmodel = \"ElasticCamDrive\"\ncam = {{ law = \"table\", file = \"t.csv\", {keys} }}\ndrive = {{ mode = \"input\" }}\n\
         elasticity = {{ place = \"output\", m = 1, c = 1 }}"
    );
    let scene = resolve("scene.toml", &text, folder.path()).unwrap_or_else(|faults| panic!("{keys}: {faults}"));
    scene.smoothed.into_iter().filter_map(|table| table.warning).map(|warning| warning.message).collect()
}

#[test]
fn jumps_and_kinks_are_told_with_their_angles() {
    let keys = "angle_unit = \"deg\", lift_unit = \"mm\"";
    let rows =
        |lift: &dyn Fn(f64) -> f64| (0..360).map(|i| format!("{i};{:.5}\n", lift(f64::from(i)))).collect::<String>();
    // Parabolas of 75° between 30.4° and 330.4°: U″ = ±0.00711 mm/°² jumps at their ends and in their middle.
    let parabola = |x: f64| {
        let z = 1.0 - ((x - 180.4).abs() / 150.0).min(1.0);
        20.0 * if z < 0.5 { 2.0 * z * z } else { 1.0 - 2.0 * (1.0 - z).powi(2) }
    };
    let told = warnings(&rows(&parabola), keys);
    let angles = ["30.4 deg, 105.4 deg, 255.4 deg, 330.4 deg", "by up to 7.1e-3 mm/°²", "the spline has these jumps"];
    assert!(told.len() == 1 && angles.iter().all(|part| told[0].contains(part)), "{told:?}");
    // A lift less a clearance: at ±80° of 180.3° the cosine has the slope 10 π/220 sin(80/110 π) mm/°.
    let whole = |x: f64| 5.0 * (1.0 + (((x - 180.3).abs() / 110.0).min(1.0) * PI).cos());
    let kinked = |x: f64| (whole(x) - whole(180.3 + 80.0)).max(0.0);
    let told = warnings(&rows(&kinked), keys);
    let slope = format!("by up to {} mm/°", number(5.0 * PI / 110.0 * (80.0 / 110.0 * PI).sin()));
    assert!(told.len() == 1 && told[0].contains("U′ jumps at") && told[0].contains(&slope), "{told:?} {slope}");
    assert!(told[0].contains(" 100.3 deg, 260.3 deg,"), "{told:?}");
}

#[test]
fn laws_whose_acceleration_jumps_keep_its_peak() {
    let parabola = |z: f64| if z < 0.5 { 2.0 * z * z } else { 1.0 - 2.0 * (1.0 - z).powi(2) };
    let harmonic = |z: f64| 0.5 * (1.0 - (PI * z).cos());
    let laws: [(&dyn Fn(f64) -> f64, f64); 2] = [(&parabola, 4.0), (&harmonic, 0.5 * PI * PI)];
    // Rises and returns of 110° about a dwell of 40°, over the turn and as one of two periods.
    for (law, peak) in laws {
        for count in [180, 360, 720] {
            for (parts, keys) in [(1.0, ""), (2.0, ", period = \"180 deg\"")] {
                let lift = |x: f64| 10.0 * law(((130.0 - (x - 180.0).abs()) / 110.0).clamp(0.0, 1.0));
                let row = |i: i32| 360.0 * f64::from(i) / f64::from(count);
                let rows = (0..=count).map(row);
                let rows: String = rows.map(|x| format!("{:.9};{:.9}\n", x / parts, lift(x))).collect();
                let (law, notes) = of(&rows, &format!("angle_unit = \"deg\", lift_unit = \"mm\"{keys}"))
                    .unwrap_or_else(|e| panic!("{e}"));
                let most =
                    (0..7200).map(|i| law.at(TAU * (f64::from(i) + 0.5) / 7200.0).0[2].abs()).fold(0.0, f64::max);
                let exact = 0.01 * peak * (parts / 110_f64.to_radians()).powi(2);
                assert!((most / exact - 1.0).abs() < 0.02, "{count} {keys}: {most} {exact} {notes}");
            }
        }
    }
}

#[test]
fn the_level_of_the_rest_beside_a_noisy_lobe_is_fitted() {
    // A polynomial 3-4-5 up and down over 240° with 12 µm of noise, 24 µm at both ends.
    let law = |x: f64| {
        let z = 1.0 - ((x - 180.0).abs() / 120.0).min(1.0);
        10.0 * z.powi(3) * (10.0 - 15.0 * z + 6.0 * z * z)
    };
    let row = |i: i32| {
        let random = 0.04 * ((12.9898 * f64::from(i)).sin() * 43758.5453).fract().abs() - 0.02;
        let noise = if [0, 250].contains(&i) { 0.024 } else { random };
        format!("{};{:.5}\n", i + 55, law(f64::from(i + 55)) + noise)
    };
    let table = (0..=250).map(row).collect::<String>();
    let keys = "angle_unit = \"deg\", lift_unit = \"mm\", outside = \"rest\"";
    for noise in ["\"estimate\"", "\"12 um\""] {
        let (found, _) = of(&table, &format!("{keys}, noise = {noise}")).unwrap();
        // The largest U″ is 10 · 5.77/(2/3 π)² mm.
        let largest = 10e-3 * 5.7735 / (TAU / 3.0).powi(2);
        let bend = |x: f64| found.at(x.to_radians()).0[2];
        let joints = (400..700).chain(2900..3200).map(|i| f64::from(i) / 10.0);
        let most = joints.map(|x| (bend(x) - 1e-3 * second(&law, x)).abs()).fold(0.0, f64::max);
        assert!(most < 0.25 * largest, "{noise}: {}", most / largest);
        assert!(found.at(0.0).0[0].abs() < 16e-6, "{noise}: {:e}", found.at(0.0).0[0]);
    }
}

/// The second derivative of a law of the angle in degrees (1/rad²).
fn second(law: &dyn Fn(f64) -> f64, x: f64) -> f64 {
    let step = 0.01_f64;
    (law(x + step) - 2.0 * law(x) + law(x - step)) / step.to_radians().powi(2)
}
