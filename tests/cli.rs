//! The command line as a user meets it: what it prints, where, and the exit codes.

use camdrive::drives::resource::BUILD;
use camdrive_cli::export::archive::{File, archive};
use camdrive_cli::export::documentation;
use std::collections::{BTreeMap, BTreeSet};
use std::io::{Read as _, Write as _};
use std::path::{Path, PathBuf};
use std::process::Command;

/// The folder of the workspace.
fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap()
}

const SCENE: &str = "examples/transfer_manipulator/scene.toml";
const TAPPET: &str = "examples/tappet/scene.toml";
const VALVE: &str = "examples/valve_train/forces.toml";
const WRONG: &str = "tests/scenes/wrong_dimensions.toml";

/// What a run gives back.
struct Run {
    code: i32,
    out: String,
    err: String,
}

/// With lines that are long enough for every sentence.
fn camdrive(args: &[&str]) -> Run {
    camdrive_with(args, &[("COLUMNS", "10000")])
}

/// With these variables in the environment.
fn camdrive_with(args: &[&str], variables: &[(&str, &str)]) -> Run {
    let mut command = Command::new(env!("CARGO_BIN_EXE_camdrive"));
    for name in ["COLUMNS", "NO_COLOR", "CLICOLOR", "CLICOLOR_FORCE"] {
        command.env_remove(name);
    }
    let output =
        command.current_dir(root()).args(args).envs(variables.iter().copied()).output().expect("camdrive starts");
    Run {
        code: output.status.code().expect("no signal ends camdrive"),
        out: String::from_utf8(output.stdout).expect("UTF-8"),
        err: String::from_utf8(output.stderr).expect("UTF-8"),
    }
}

/// Whether a command refused a file (1) or a value on the command line (2).
fn is_refused(code: i32) -> bool {
    [1, 2].contains(&code)
}

/// An empty folder of this name for one test.
fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).expect("a folder for the test");
    folder
}

/// `PLATFORM=FILE` of the library that was built together with this test; the one beside the executable may be an
/// old one, since `cargo test` does not renew it.
fn runtime() -> String {
    let platform = match std::env::consts::OS {
        "windows" => "win64",
        "macos" => "darwin64",
        _ => "linux64",
    };
    let name = format!("{}camdrive_fmu{}", std::env::consts::DLL_PREFIX, std::env::consts::DLL_SUFFIX);
    let test = std::env::current_exe().expect("the running test");
    let library = test.with_file_name(name);
    assert!(library.exists(), "{} is built with the tests", library.display());
    format!("{platform}={}", library.display())
}

fn text(path: &Path) -> &str {
    path.to_str().expect("a UTF-8 path")
}

/// An attribute of an SVG element.
fn attribute<'a>(tag: &'a str, name: &str) -> Option<&'a str> {
    tag.split_once(&format!(" {name}=\"")).and_then(|(_, rest)| rest.split_once('"')).map(|(value, _)| value)
}

/// Whether a tick is written in digits or as a power of ten; None where it is no number.
fn notation(label: &str) -> Option<&'static str> {
    match label.replace('−', "-").parse::<f64>() {
        Ok(_) if label.contains('e') => Some("exponent"),
        Ok(_) => Some("digits"),
        Err(_) => (label.starts_with("10") || label.contains("·10")).then_some("power"),
    }
}

/// Every diagram in the folder shows its title, its ticks are written in one way, in units that need no small or large
/// numbers, and its texts lie within the picture.
fn assert_diagrams_read_well(folder: &Path) {
    let files = std::fs::read_dir(folder).expect("the folder").map(|entry| entry.expect("an entry").path());
    let diagrams: Vec<PathBuf> = files.filter(|path| path.extension().is_some_and(|e| e == "svg")).collect();
    assert!(!diagrams.is_empty());
    for path in diagrams {
        let svg = std::fs::read_to_string(&path).expect("the diagram");
        let title = attribute(&svg, "aria-label").expect("a title");
        let (title, name) = (title.replace("&quot;", "\"").replace("&lt;", "<").replace("&amp;", "&"), path.display());
        let size: Vec<f64> =
            attribute(&svg, "viewBox").expect("a view box").split(' ').map(|x| x.parse().expect("a number")).collect();
        let (mut shown, mut axes) = (String::new(), BTreeMap::new());
        for element in svg.split("<text").skip(1) {
            let (tag, rest) = element.split_once('>').expect("a tag");
            let label = rest.split("</text>").next().expect("a text").trim();
            let number = |name: &str| attribute(tag, name).and_then(|x| x.parse::<f64>().ok()).expect("a number");
            shown += &format!("{label} ");
            let (x, y, anchor) = (number("x"), number("y"), attribute(tag, "text-anchor").unwrap_or("start"));
            // Letters are half as wide as high on average.
            let long = 0.5 * number("font-size") * label.chars().count() as f64;
            let before = match anchor {
                "middle" => 0.5 * long,
                "end" => long,
                _ => 0.0,
            };
            let turned = attribute(tag, "transform").is_some_and(|transform| transform.contains("rotate"));
            // What is turned runs upwards.
            let ([low, high], most) = if turned {
                ([y - long + before, y + before], size[3])
            } else {
                ([x - before, x - before + long], size[2])
            };
            assert!(0.0 <= low && high <= most, "{name}: \"{label}\" from {low} to {high} of {most}");
            if let Some(way) = notation(label).filter(|_| !turned && anchor != "start") {
                let axis = if anchor == "middle" { format!("y = {y}") } else { format!("x = {x}") };
                axes.entry(axis).or_insert_with(BTreeSet::new).insert(way);
            }
        }
        let title: Vec<&str> = title.split_whitespace().collect();
        assert!(!title.is_empty() && shown.contains(&title[..2].join(" ")), "{name}: no title in {shown}");
        assert!(axes.values().all(|ways| ways.len() == 1), "{name}: {axes:?}");
        for unit in ["[m]", "[rad/s]", "[m/rad]", "[m/rad²]"] {
            assert!(!shown.contains(unit), "{name}: {unit} in {shown}");
        }
    }
}

#[test]
fn without_arguments_it_prints_its_help() {
    let run = camdrive(&[]);
    assert_eq!((run.code, run.err.as_str()), (0, ""));
    assert!(run.out.contains("Usage: camdrive"), "{}", run.out);
}

#[test]
fn every_help_has_an_example() {
    let commands = [
        "new",
        "schema",
        "help",
        "export",
        "check",
        "describe",
        "synthesize",
        "compensate",
        "cam",
        "forces",
        "steady",
        "tradeoff",
        "clearance",
        "stability",
        "completions",
        "run",
    ];
    for command in commands {
        let run = camdrive_with(&[command, "--help"], &[("COLUMNS", "60")]);
        assert_eq!(run.code, 0);
        assert!(run.out.lines().all(|line| line.chars().count() <= 60), "{}", run.out);
        assert!(run.out.contains("Example") && run.out.contains(&format!("camdrive {command} ")), "{}", run.out);
    }
}

#[test]
fn no_line_is_longer_than_the_terminal_is_wide() {
    let folder = folder("width");
    // A path is one word; from the folder of the package it is a short one.
    let folder = text(folder.strip_prefix(root()).unwrap_or(&folder)).to_owned();
    let (profile, scene, runtime) = (format!("{folder}/p.toml"), format!("{folder}/hs.toml"), runtime());
    let loom = "examples/rapier_loom/scene.toml";
    let (elastic, traditional) = ("examples/transfer_manipulator/hs3.toml", "examples/guide_bar/traditional.toml");
    let commands: [&[&str]; 22] = [
        &["check", SCENE, "examples/sealing_machine/scene.toml"],
        &["check", WRONG],
        &["check", TASK],
        &["describe", SCENE],
        &["describe", loom],
        &["describe", "examples/guide_bar/run_up.toml"],
        &["describe", "examples/rod_drive/scene.toml"],
        &["describe", BACKLASH],
        &["export", SCENE, "-o", &folder, "--runtime", &runtime],
        &["steady", loom, "--load", "120 N.m", "--report", &folder],
        &["steady", "examples/sealing_machine/scene.toml"],
        &["compensate", loom, "-o", &scene, "--report", &folder],
        &["cam", loom, "-o", &folder],
        &["cam", "examples/sealing_machine/scene.toml", "-o", &folder],
        &["forces", "examples/sealing_machine/loaded.toml", "-o", &folder],
        &["forces", TAPPET, "--speed", "2000 rpm", "-o", &folder],
        &["stability", elastic, "--quick", "--orders", "3", "-o", &folder],
        &["stability", "examples/rod_drive/scene.toml", "--quick", "--orders", "3", "-o", &folder],
        &["clearance", BACKLASH, "--turns", "4", "-o", &folder],
        &[
            "clearance",
            traditional,
            "--quick",
            "--clearance",
            "20 um",
            "--m1",
            "2 kg",
            "--turns",
            "2",
            "--compare",
            "hs6",
            "-o",
            &folder,
        ],
        &["tradeoff", "examples/guide_bar/scene.toml", "--quick", "--turns", "1", "-o", &folder],
        &["synthesize", TASK, "-o", &profile],
    ];
    for args in commands {
        let run = camdrive_with(args, &[("COLUMNS", "80")]);
        let both = run.out + &run.err;
        assert!(!both.is_empty() && !both.contains('\x1b'), "{args:?}");
        // The path of the library lies where the package is built.
        for line in both.lines().filter(|line| line.trim_start().contains(' ')) {
            assert!(line.chars().count() <= 80, "{args:?}: {line}");
        }
    }
    let run = camdrive_with(&["export", SCENE, "-o", &folder, "--runtime", &runtime], &[("COLUMNS", "60")]);
    // A path is one word.
    let sentences = |line: &&str| !line.trim_start().starts_with('/');
    assert!(run.out.lines().filter(sentences).all(|line| line.chars().count() <= 60), "{}", run.out);
    // Without a terminal and a word of its width, lines have a hundred characters.
    let run = camdrive_with(&["describe", loom], &[]);
    let longest = run.out.lines().map(|line| line.chars().count()).max();
    assert!(longest.is_some_and(|longest| (90..=100).contains(&longest)), "{longest:?}");
    // What programs read is not wrapped.
    let xml = camdrive_with(&["describe", loom, "--xml"], &[("COLUMNS", "80")]);
    assert_eq!(xml.out, camdrive(&["describe", loom, "--xml"]).out);
}

#[test]
fn words_of_messages_have_colours_where_they_are_wanted() {
    for (variables, coloured) in
        [(&[][..], false), (&[("CLICOLOR_FORCE", "1")], true), (&[("CLICOLOR_FORCE", "1"), ("NO_COLOR", "1")], false)]
    {
        let run = camdrive_with(&["check", WRONG], variables);
        assert_eq!(run.err.contains("\x1b[1;31merror:\x1b[0m"), coloured, "{variables:?}: {}", run.err);
        assert_eq!(run.err.contains("\x1b[1;32m= hint:\x1b[0m"), coloured, "{variables:?}: {}", run.err);
        assert_eq!(run.err.contains('\x1b'), coloured, "{variables:?}: {}", run.err);
    }
}

#[test]
fn a_wrong_command_line_ends_with_2() {
    for args in [&["exprot"][..], &["export"], &["check"], &["check", "--wibble"], &["completions", "cmd"]] {
        let run = camdrive(args);
        assert_eq!((run.code, run.out.as_str()), (2, ""), "{args:?}");
        assert!(run.err.contains("error"), "{}", run.err);
    }
}

#[test]
fn check_tells_right_from_wrong() {
    let right = camdrive(&["check", SCENE]);
    assert_eq!((right.code, right.err.as_str()), (0, ""));
    assert!(right.out.starts_with(&format!("{SCENE}: ElasticCamDrive.shaft ok\n")), "{}", right.out);
    let wrong = camdrive(&["check", SCENE, WRONG, "no_such_scene.toml"]);
    assert_eq!((wrong.code, wrong.out.as_str()), (1, ""));
    assert!(wrong.err.contains(&format!("{WRONG}:10:9")), "{}", wrong.err);
    assert!(wrong.err.contains("no_such_scene.toml"), "faults of all scenes are told: {}", wrong.err);
}

#[test]
fn what_is_solved_as_a_train_has_the_name_that_the_scene_gives_it() {
    for (scene, model) in
        [("backlash_lift", "BacklashDrive"), ("machine_loads", "RigidMachine"), ("train_motor", "DriveTrain")]
    {
        let path = format!("tests/fmpy/scenes/{scene}.toml");
        let checked = camdrive(&["check", &path]);
        assert!(checked.out.starts_with(&format!("{path}: {model} ok\n")), "{}", checked.out);
        assert!(camdrive(&["check", "--json", &path]).out.contains(&format!("\"model\": \"{model}\"")));
        assert!(camdrive(&["describe", &path]).out.contains(&format!("{scene} ({model})")));
    }
}

/// All scenes of the repository that are right.
fn right_scenes() -> Vec<String> {
    let folders =
        std::fs::read_dir(root().join("examples")).expect("the examples").map(|entry| entry.expect("an entry").path());
    let files = |folder: PathBuf| std::fs::read_dir(folder).into_iter().flatten().map(|entry| entry.expect("an entry"));
    let all = folders.chain([root().join("tests/fmpy/scenes")]).flat_map(files).map(|entry| entry.path());
    let is_scene = |path: &PathBuf| {
        path.extension().is_some_and(|e| e == "toml")
            && std::fs::read_to_string(path).is_ok_and(|text| text.contains("\nmodel = "))
    };
    all.filter(is_scene).map(|path| text(&path).to_owned()).collect()
}

#[test]
fn check_tells_what_a_scene_amounts_to_and_finds_nothing_odd_in_ours() {
    let scenes = right_scenes();
    assert!(scenes.len() > 20, "{scenes:?}");
    let arguments: Vec<&str> = std::iter::once("check").chain(scenes.iter().map(String::as_str)).collect();
    let run = camdrive(&arguments);
    // Nothing is advised but where a follower is meant to leave its cam, where vibration is strong or has no damping, and where no
    // motion repeats.
    let minded = [
        "lifts off its cam",
        "Resonance with harmonic",
        "Vibration raises",
        "does not repeat",
        "neither grow nor decay",
        "must not run",
    ];
    let reports: Vec<&str> = run.out.split(" ok\n").filter(|report| report.contains("\nAdvice\n")).collect();
    assert!(run.code == 0 && reports.len() > 3, "{}", run.out);
    assert!(reports.iter().all(|report| minded.iter().any(|text| report.contains(text))), "{}", run.out);
    for part in [
        "1800 rpm\n",
        "largest deformation                 0.018 mm",
        "frequency ratio",
        "natural frequency in flight",
        "\nResonances\n",
        "mean speed                              500 rpm",
        "follower[2].largest kinetostatic force",
    ] {
        assert!(run.out.contains(part), "{part} is missing in\n{}", run.out);
    }
    let run = camdrive(&["check", "examples/valve_train/scene.toml"]);
    assert!(run.out.contains("Impacts raise the deformation") && !run.out.contains("Resonance with"), "{}", run.out);
}

#[test]
fn check_has_frequencies_in_the_unit_of_the_scene() {
    let scene = folder("check_frequencies").join("scene.toml");
    let bar = std::fs::read_to_string(root().join("examples/guide_bar/scene.toml")).expect("the scene");
    // c/m = (540π/s)²; a plain number and a stiffness say no unit.
    for (given, shown) in [
        ("natural_frequency = \"270 Hz\"", "270 Hz"),
        ("natural_frequency = \"16200 rpm\"", "16200 rpm"),
        ("natural_frequency = \"1696.46 rad/s\"", "1700 rad/s"),
        ("natural_frequency = 1696.46", "270 Hz"),
        ("c = \"34.5357 kN/mm\"", "270 Hz"),
    ] {
        std::fs::write(&scene, bar.replace("natural_frequency = \"270 Hz\"", given)).expect("the scene");
        let run = camdrive(&["check", text(&scene)]);
        let line = run.out.lines().find(|line| line.contains("natural frequency")).expect("the figure");
        assert!(line.split_once("frequency").is_some_and(|(_, rest)| rest.trim() == shown), "{given}: {line}");
    }
}

/// The text in one line.
fn unwrapped(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

#[test]
fn check_warns_of_forgotten_units() {
    let folder = folder("check_units");
    let scene = folder.join("scene.toml");
    let (bar, loom) = ("examples/guide_bar/scene.toml", "examples/rapier_loom/scene.toml");
    let rods = "examples/rod_drive/scene.toml";
    for (original, from, to, what, hint) in [
        (bar, "\"1800 rpm\"", "1800", "kinetostatic deformation of stroke 152 %", "\"1800 rpm\""),
        (bar, "\"270 Hz\"", "270", "kinetostatic deformation of stroke 65.6 %", "\"270 Hz\""),
        (bar, "ratio = 0.03", "ratio = 3", "damping ratio 3:", "\"3 %\""),
        (bar, "\"0.94 mm\"", "20", "stroke 20000 mm:", "\"0.94 mm\""),
        (bar, "\"1800 rpm\"", "18000", "speed 172000 rpm", "\"1800 rpm\""),
        (loom, "\"500 rpm\"", "500", "follower[1].largest acceleration 200", "\"1800 rpm\""),
        (loom, "s_k = 0.16", "s_k = 16", "breakdown slip 16:", "\"15 %\""),
        (bar, "\"0.94 mm\"", "0.94", "largest velocity 1", "\"0.94 mm\""),
        (BACKLASH, "\"0.05 mm\"", "0.05", "clearance of stroke 2", "\"0.94 mm\""),
        (rods, "\"0.3 m\"", "300", "crank radius 300000 mm:", "\"0.94 mm\""),
        (rods, "\"9 MN.m/rad\"", "9", "frequency ratio", "units of m and c"),
        // All units are there.
        (bar, "\"1800 rpm\"", "\"18000 rpm\"", "kinetostatic deformation of stroke", "Lower the speed, or raise"),
    ] {
        let text_of_scene = std::fs::read_to_string(root().join(original)).expect("the example");
        assert!(text_of_scene.contains(from), "{from}");
        std::fs::write(&scene, text_of_scene.replace(from, to)).expect("the folder can be written to");
        let run = camdrive(&["check", text(&scene)]);
        assert!(run.code == 0 && run.out.contains(" ok\n"), "{}", run.err);
        // Lines are wrapped.
        let told = unwrapped(&run.out);
        assert!(
            told.to_lowercase().contains(&what.to_lowercase()) && told.contains("Advice") && told.contains(hint),
            "{to}: {}",
            run.out
        );
    }
}

/// A scene with this table, and what `check` says of it.
fn check_table(folder: &Path, rows: &str, keys: &str) -> Run {
    let scene = folder.join("scene.toml");
    std::fs::write(folder.join("lift.csv"), rows).expect("the folder can be written to");
    let content = format!(
        "name = \"valve\"\nmodel = \"ElasticCamDrive\"\n[cam]\nlaw = \"table\"\nfile = \"lift.csv\"\nangle_unit = \"deg\"\n\
         lift_unit = \"mm\"\n{keys}[drive]\nspeed = \"3000 rpm\"\n[elasticity]\nplace = \"output\"\nm = \"0.12 kg\"\n\
         natural_frequency = \"910 Hz\"\ndamping_ratio = 0.02\n"
    );
    std::fs::write(&scene, content).expect("the folder can be written to");
    camdrive(&["check", text(&scene)])
}

/// A stored table.
fn stored_table(name: &str) -> String {
    std::fs::read_to_string(root().join("tests/tables").join(name)).expect("a stored table")
}

#[test]
fn a_wrong_row_is_named_and_left_out_on_demand() {
    // Lifts every degree with 3 µm of noise; the one at 100° is 0.27 mm too low.
    let folder = folder("wrong_row");
    let rows = stored_table("wrong_row.csv");
    let mended = rows.replace("\n100;3.8930\n", "\n100;4.1640\n");
    for noise in ["", "noise = \"estimate\"\n", "noise = \"3 um\"\n"] {
        let run = check_table(&folder, &mended, noise);
        assert_eq!(run.code, 0, "{}", run.err);
        let run = check_table(&folder, &rows, noise);
        assert!(run.code == 1 && run.err.contains("lift.csv:101:1") && run.err.contains("1 fault"), "{}", run.err);
        let by = run.err.split_once("the lift at 100 deg is ").and_then(|(_, rest)| rest.split(' ').next());
        let by: f64 = by.and_then(|by| by.parse().ok()).expect(&run.err);
        assert!((by + 0.27).abs() < 0.01 && run.err.contains(" mm off a smooth law"), "{}", run.err);
        assert!(run.err.contains("outliers = \"drop\""), "{}", run.err);
        let run = check_table(&folder, &rows, &format!("{noise}outliers = \"drop\"\n"));
        assert!(run.code == 0 && run.err.contains("line 101 of") && run.err.contains("is left out"), "{}", run.err);
        let scene = folder.join("scene.toml");
        let told = camdrive(&["describe", text(&scene)]).out.contains("1 wrong row left out");
        assert_eq!(told, !noise.is_empty(), "{noise}");
    }
    let run = check_table(&folder, &mended, "outliers = \"keep\"\n");
    assert!(run.code == 1 && run.err.contains("drop"), "{}", run.err);
    // Degrees of a crank that turns twice, in radians; the first row with the one that closes the turn.
    let crank: String = (0..=360)
        .map(|i| {
            let lift = 5.0 - 5.0 * f64::from(i).to_radians().cos() + if i % 360 == 0 { 0.3 } else { 0.0 };
            format!("{:.6};{lift:.4}\n", f64::from(2 * i).to_radians())
        })
        .collect();
    let keys = "turn = \"720 deg\"\n";
    let as_radians = |run: Run| run.err.split_once("the lift at ").map(|(_, rest)| rest.to_owned()).unwrap_or(run.err);
    let path = folder.join("scene.toml");
    check_table(&folder, &crank, keys);
    let radians =
        std::fs::read_to_string(&path).expect("the scene").replace("angle_unit = \"deg\"", "angle_unit = \"rad\"");
    std::fs::write(&path, &radians).expect("the folder can be written to");
    let told = as_radians(camdrive(&["check", text(&path)]));
    assert!(told.starts_with("0 deg is 0.3 mm off"), "{told}");
    std::fs::write(&path, radians.replace(keys, &format!("{keys}outliers = \"drop\"\n")))
        .expect("the folder can be written to");
    let run = camdrive(&["check", text(&path)]);
    assert!(run.code == 0 && run.err.contains("line 1 of") && run.out.contains("10 mm"), "{} {}", run.out, run.err);
}

#[test]
fn rows_of_any_distance_lose_their_noise() {
    // A quarter of a degree on the flank, 5° in the rest, 3 µm of noise, and an angle that is measured twice.
    let folder = folder("fine_and_coarse");
    let rows = stored_table("fine_and_coarse.csv");
    let twice = rows.replacen("\n65.00;", "\n65.00;9.9990\n65.00;", 1);
    assert_ne!(rows, twice);
    for rows in [&rows, &twice] {
        let run = check_table(&folder, rows, "noise = \"estimate\"\n");
        assert!(run.code == 0 && !run.out.contains("Advice"), "{}", run.out);
        let line = run.out.lines().find(|line| line.contains("largest acceleration")).unwrap_or_default();
        let found: f64 = line.split_whitespace().nth(2).and_then(|value| value.parse().ok()).expect(line);
        assert!((found / 5776.0 - 1.0).abs() < 0.01, "{line}");
        let told = camdrive(&["describe", text(&folder.join("scene.toml"))]).out;
        assert!(told.contains("The table of cam is smoothed: noise 2.9e-3 mm (estimated), largest change "), "{told}");
    }
    let run = check_table(&folder, &twice, "");
    assert!(run.code == 1 && run.err.contains("does not exceed"), "{}", run.err);
    // So much noise is none: half a millimetre of a stroke of ten.
    let run = check_table(&folder, &rows, "noise = \"0.5 mm\"\n");
    assert!(run.code == 0 && unwrapped(&run.out).contains("% of the stroke"), "{}", run.out);
}

#[test]
fn check_warns_of_a_rough_lobe_but_not_of_a_rounded_one() {
    let path = folder("check_rough_lobe").join("lobe.toml");
    // cos⁴ over 140°, every second row 8 µm too high.
    let row = |deg: i32| (deg, 10.0 * (f64::from(deg) * std::f64::consts::PI / 140.0).cos().powi(4));
    for (noise, rough) in [(0.0, false), (0.008, true)] {
        let rows =
            (-70..=70).map(row).map(|(deg, u)| format!("{deg};{:.4}\n", u + if deg % 2 == 0 { 0.0 } else { noise }));
        std::fs::write(path.with_extension("csv"), rows.collect::<String>()).expect("a table");
        let scene = "name = \"lobe\"\nmodel = \"ElasticCamDrive\"\ncam = { law = \"table\", file = \"lobe.csv\", angle_unit = \"deg\", \
            lift_unit = \"mm\", outside = \"rest\" }\ndrive = { speed = \"300 rpm\" }\n\
            elasticity = { place = \"output\", m = 1, natural_frequency = \"100 Hz\" }\n";
        std::fs::write(&path, scene).expect("a scene");
        let run = camdrive(&["check", text(&path)]);
        assert!(run.code == 0 && unwrapped(&run.out).contains("the table is rough") == rough, "{noise}: {}", run.out);
    }
}

#[test]
fn tables_that_commands_write_are_read_again() {
    let folder = folder("read_again");
    let law = |name: &str, keys: &str| {
        let scene = format!(
            "name = \"again\"\nmodel = \"ElasticCamDrive\"\ncam = {{ law = \"table\", file = \"{name}\", angle_unit = \"deg\", {keys} }}\n\
             drive = {{ speed = 1 }}\nelasticity = {{ place = \"output\", m = 1, c = 1e4 }}\n"
        );
        std::fs::write(folder.join("again.toml"), scene).expect("a scene");
        let scene =
            camdrive_cli::scene::read(&folder.join("again.toml")).unwrap_or_else(|faults| panic!("{name}: {faults}"));
        assert_eq!(scene.notes, [""; 0], "{name}");
        scene.scene.cam().expect("a law").clone()
    };
    let given = camdrive_cli::scene::read(&root().join(TAPPET)).expect("a scene").scene;
    let given = given.cam().expect("a law");
    assert_eq!(camdrive(&["cam", TAPPET, "-o", text(&folder)]).code, 0);
    let written =
        [("tappet.csv", ""), ("tappet.plcopen.csv", ", interpolation = \"derivatives\""), ("tappet.plc.txt", "")];
    let read = written.map(|(name, more)| law(name, &format!("lift_unit = \"mm\"{more}")));
    for deg in 0..360 {
        let phi = f64::from(deg).to_radians();
        let expected = given.at(phi).0;
        let [csv, plcopen, plc] = [0, 1, 2].map(|i: usize| read[i].at(phi).0);
        // Half of the last digits that a controller gets.
        assert!((csv[0] - expected[0]).abs() < 1e-16 && (plc[0] - expected[0]).abs() < 0.51e-10, "{deg}");
        for (order, digit) in [1e-10, 1e-12 * 57.3, 1e-14 * 57.3 * 57.3].into_iter().enumerate() {
            assert!((plcopen[order] - expected[order]).abs() < 0.51 * digit, "{deg}: {plcopen:?} for {expected:?}");
        }
    }
    let (task, profile) = (small_task(&folder), folder.join("small.toml"));
    let run = camdrive(&["synthesize", &task, "-o", text(&profile), "--report", text(&folder)]);
    assert_eq!(run.code, 0, "{}", run.err);
    let series = std::fs::read_to_string(&profile).expect("the profile")
        + "[drive]\nspeed = 1\n[elasticity]\nplace = \"output\"\nm = 1\nc = 1e4\n";
    std::fs::write(&profile, format!("name = \"small\"\nmodel = \"ElasticCamDrive\"\n{series}")).expect("a scene");
    let given = camdrive_cli::scene::read(&profile).expect("a scene").scene;
    let given = given.cam().expect("a law");
    let again = law("small.profile.csv", "interpolation = \"derivatives\"");
    for &phi in again.breakpoints() {
        let (found, expected) = (again.at(phi).0, given.at(phi).0);
        assert!((0..3).all(|n| (found[n] - expected[n]).abs() < 1e-14), "{phi}: {found:?} for {expected:?}");
    }
}

#[test]
fn a_contour_that_cam_writes_gives_its_law_back() {
    let folder = folder("contour");
    let write = |name: &str, cam: &str, geometry: &str| {
        let scene = format!(
            "name = \"{name}\"\nmodel = \"ElasticCamDrive\"\ncam = {{ {cam} }}\ngeometry = {{ {geometry} }}\n\
             drive = {{ speed = 1 }}\nelasticity = {{ place = \"output\", m = 1, c = 1e4 }}\nload.spring.preload = 1000\n"
        );
        let path = folder.join(format!("{name}.toml"));
        std::fs::write(&path, scene).expect("a scene");
        path
    };
    let law = |path: &Path| camdrive_cli::scene::read(path).unwrap_or_else(|e| panic!("{e}")).cams[0].law.clone();
    let cycle = "law = \"cycle\", stroke = \"10 mm\", rise_law = \"polynomial_4567\", rise_start = \"-20.3 deg\", \
                 rise = \"80 deg\", upper_dwell = \"40 deg\", return = \"70 deg\"";
    let lever = "follower = \"lever\", roller_radius = \"9 mm\", pivot_distance = \"60 mm\", arm_length = \"45 mm\"";
    for (i, geometry) in [
        "follower = \"translating\", roller_radius = \"9 mm\", offset = \"4 mm\", base_radius = \"20 mm\"".to_owned(),
        "follower = \"flat\", base_radius = \"45 mm\", cutter_radius = \"30 mm\", rotation = \"clockwise\"".to_owned(),
        format!("{lever}, start_angle = \"40 deg\", contour = \"groove\""),
        format!("{lever}, prime_radius = \"30 mm\", contour = \"outer\", side = \"right\", transmission = \"60 mm\""),
    ]
    .into_iter()
    .enumerate()
    {
        let given = write("given", cycle, &geometry);
        let run = camdrive(&["cam", text(&given), "-o", text(&folder)]);
        assert!(run.code == 0, "{geometry}: {}", run.err);
        let again = write("again", "law = \"contour\", file = \"given.csv\"", &geometry);
        let (given, found) = (law(&given), law(&again));
        let off = |i: u32| (given.at(f64::from(i) / 573.0).0[0] - found.at(f64::from(i) / 573.0).0[0]).abs();
        let off = (0..3600).map(off).fold(0.0, f64::max);
        assert!(off < 1e-8, "{geometry}: {off:e}");
        let run = camdrive(&["describe", text(&again)]);
        assert!(run.out.contains("The law of cam comes from a contour"), "{}", run.out);
        let run = camdrive(&["forces", text(&again), "--speed", "600 rpm", "-o", text(&folder.join("forces"))]);
        // The spring presses away from a ring.
        assert!(run.code == 0 || geometry.contains("outer"), "{geometry}: {}", run.err);
        assert_eq!(run.out.contains("tilting moment on the follower"), i == 1, "{}", run.out);
    }
}

#[test]
fn check_warns_of_a_rough_table() {
    let scene = folder("check_rough").join("scene.toml");
    let table = std::fs::canonicalize(root().join("tests/scenes/table_rough.csv")).expect("the table");
    let whole = |interpolation: &str| {
        format!(
            "name = \"valve\"\nmodel = \"ElasticCamDrive\"\n[cam]\nlaw = \"table\"\nfile = {:?}\nangle_unit = \"deg\"\n\
             lift_unit = \"mm\"\n{interpolation}[drive]\nspeed = \"3000 rpm\"\n[elasticity]\nplace = \"output\"\n\
             m = \"185 g\"\nc = \"9.5 N/um\"\ndamping_ratio = 0.02\n",
            text(&table)
        )
    };
    std::fs::write(&scene, whole("")).expect("the folder can be written to");
    let run = camdrive(&["check", text(&scene)]);
    // The lifts were given a noise of 5 µm.
    let told = unwrapped(&run.out);
    assert!(run.code == 0 && told.contains("Advice") && told.contains("scatter by 5.2e-3 mm"), "{told}");
    assert!(told.contains("% of the largest value"), "{told}");
    // The noise is estimated to a sixth.
    std::fs::write(&scene, whole("noise = \"estimate\"\n")).expect("the folder can be written to");
    let run = camdrive(&["check", text(&scene)]);
    assert!(
        run.code == 0 && !run.out.contains("Advice") && run.err.contains("smoothing with a noise of 5.8"),
        "{}",
        run.err
    );
    // The FMU says so to those who have no scene.
    let fmu = scene.with_extension("fmu");
    let exported = camdrive(&["export", text(&scene), "-o", text(&fmu), "--runtime", &runtime()]);
    assert_eq!(exported.code, 0, "{}", exported.err);
    let mut archive = zip::ZipArchive::new(std::fs::File::open(&fmu).expect("the FMU")).expect("an archive");
    for file in ["modelDescription.xml", "documentation/index.html"] {
        let content = std::io::read_to_string(archive.by_name(file).expect(file)).expect("UTF-8");
        assert!(content.contains("The table of cam is smoothed: noise 5.8"), "{file}");
    }
    for (noise, origin) in [("\"estimate\"", "estimated"), ("\"4 um\"", "given")] {
        std::fs::write(&scene, whole(&format!("noise = {noise}\n"))).expect("the folder can be written to");
        let said = camdrive(&["describe", text(&scene)]).out;
        assert!(said.contains("e-3 mm") && said.contains(&format!("({origin}), largest change ")), "{said}");
    }
    std::fs::write(&scene, whole("interpolation = \"fourier\"\nharmonics = 12\n"))
        .expect("the folder can be written to");
    let run = camdrive(&["check", text(&scene)]);
    assert!(run.code == 0 && !run.out.contains("Advice"), "{}", run.out);
}

/// The keys of all objects in a JSON value.
fn keys(value: &serde_json::Value, into: &mut BTreeSet<String>) {
    match value {
        serde_json::Value::Object(map) => map.iter().for_each(|(key, value)| {
            into.insert(key.clone());
            keys(value, into);
        }),
        serde_json::Value::Array(list) => list.iter().for_each(|value| keys(value, into)),
        _ => {}
    }
}

/// The section of this command documents every field.
fn assert_documented(command: &str, value: &serde_json::Value) {
    let page = std::fs::read_to_string(root().join("docs/json.md")).expect("the page");
    let section = page.split("\n## ").find(|part| part.starts_with(&format!("`{command}`")));
    let section = section.unwrap_or_else(|| panic!("{command} has no section"));
    let verdict = page.split("\n## ").find(|part| part.starts_with("`verdict`")).expect("the section of verdicts");
    let mut fields = BTreeSet::new();
    keys(value, &mut fields);
    let is_missing = |key: &&String| ![section, verdict].iter().any(|part| part.contains(&format!("`{key}`")));
    let missing: Vec<&String> = fields.iter().filter(is_missing).collect();
    assert!(missing.is_empty(), "{command}: {missing:?}");
}

#[test]
fn results_are_printed_as_json_whose_fields_are_documented() {
    let folder = folder("json");
    let (output, profile) = (text(&folder).to_owned(), folder.join("profile.toml"));
    let task = small_task(&folder);
    for (arguments, code, file) in [
        (&["check", SCENE, WRONG, "tests/fmpy/scenes/output_input.toml"][..], 1, None),
        (&["describe", SCENE], 0, None),
        (&["run", SCENE, "--stop", "1", "--step", "0.5"], 0, None),
        (&["steady", "examples/sealing_machine/scene.toml"], 0, None),
        (&["steady", "examples/rapier_loom/scene.toml", "--load", "250 N.m"], 3, None),
        (&["stability", SCENE, "--orders", "2", "--quick", "-o", &output], 0, Some("transfer_manipulator.json")),
        (&["clearance", BACKLASH, "--turns", "4", "--quick", "-o", &output], 0, Some("backlash_drive.json")),
        (&["forces", TAPPET, "-o", &output], 0, Some("tappet.json")),
        (&["synthesize", &task, "-o", text(&profile), "--report", &output], 0, Some("small.json")),
    ] {
        let run = camdrive(&[arguments, &["--json"]].concat());
        assert_eq!((run.code, run.err.as_str()), (code, ""), "{arguments:?}");
        let value: serde_json::Value = serde_json::from_str(&run.out).unwrap_or_else(|e| panic!("{arguments:?}: {e}"));
        if let Some(file) = file {
            assert_eq!(std::fs::read_to_string(folder.join(file)).expect("the report"), run.out);
        }
        assert_documented(arguments[0], &value);
    }
    let faults = camdrive(&["check", WRONG, "--json"]).out;
    let faults: serde_json::Value = serde_json::from_str(&faults).expect("JSON");
    let first = &faults[0]["faults"][0];
    assert_eq!((&faults[0]["ok"], &first["line"], &first["key"]), (&false.into(), &6.into(), &"cam.a[1]".into()));
    assert!(first["message"].is_string() && first["hint"].is_string(), "{first}");
    assert_eq!(camdrive(&["describe", SCENE, "--xml", "--json"]).code, 2);
}

#[test]
fn describe_shows_the_interface() {
    let run = camdrive(&["describe", SCENE]);
    assert_eq!((run.code, run.err.as_str()), (0, ""));
    for part in [
        "transfer_manipulator (ElasticCamDrive.shaft)",
        "Equations",
        "drive.w",
        "rad/s",
        "der(psi)",
        "Default experiment",
    ] {
        assert!(run.out.contains(part), "{part} is missing in\n{}", run.out);
    }
    let xml = camdrive(&["describe", SCENE, "--xml"]);
    assert_eq!((xml.code, xml.err.as_str()), (0, ""));
    assert!(xml.out.starts_with("<?xml") && xml.out.contains("modelName=\"transfer_manipulator\""), "{}", xml.out);
}

#[test]
fn export_writes_whole_fmus() {
    let folder = folder("export");
    let runtime = runtime();
    let first = folder.join("a").join("transfer_manipulator.fmu");
    let run = camdrive(&["export", SCENE, "-o", text(&folder.join("a")), "--runtime", &runtime]);
    assert_eq!(run.code, 0, "{}", run.err);
    for part in ["transfer_manipulator.fmu", "ElasticCamDrive.shaft", "sha256", "states     2", "variables", "guid"] {
        assert!(run.out.contains(part), "{part} is missing in\n{}", run.out);
    }
    let named = folder.join("named.fmu");
    std::fs::write(&named, "an old file").expect("the folder can be written to");
    let run = camdrive(&["export", SCENE, "-o", text(&named), "--runtime", &runtime]);
    assert_eq!(run.code, 0, "{}", run.err);
    let bytes = std::fs::read(&first).expect("the FMU is there");
    assert!(bytes.starts_with(b"PK"), "an FMU is a zip archive");
    assert_eq!(bytes, std::fs::read(&named).expect("the FMU is there"), "the same scene gives the same bytes");
    let mut names: Vec<_> =
        std::fs::read_dir(&folder).expect("the folder").map(|entry| entry.expect("an entry").file_name()).collect();
    names.sort();
    assert_eq!(names, ["a", "named.fmu"], "nothing is left over");
}

/// The files of an FMU.
fn unzipped(fmu: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut zip = zip::ZipArchive::new(std::fs::File::open(fmu).expect("the FMU")).expect("an archive");
    let count = zip.len();
    let file = |i| {
        let mut file = zip.by_index(i).expect("a file");
        let mut content = Vec::new();
        file.read_to_end(&mut content).expect("its content");
        (file.name().to_owned(), content)
    };
    (0..count).map(file).collect()
}

/// An FMU of these files.
fn zipped(fmu: &Path, files: &BTreeMap<String, Vec<u8>>) -> String {
    let mut zip = zip::ZipWriter::new(std::fs::File::create(fmu).expect("the FMU"));
    for (name, content) in files {
        zip.start_file(name.as_str(), zip::write::SimpleFileOptions::default()).expect("a file");
        zip.write_all(content).expect("its content");
    }
    zip.finish().expect("an archive");
    text(fmu).to_owned()
}

const EXTRA: &str = "extra/org.fmi-standard.fmi-ls-ref/";

/// Scene and tables are in the FMU, wherever they came from, and nothing tells where that was.
#[test]
fn from_an_fmu_the_same_one_is_made() {
    let folder = folder("inside");
    let (elsewhere, scenes) = (folder.join("elsewhere"), folder.join("scenes"));
    for folder in [&elsewhere, &scenes.join("tables")] {
        std::fs::create_dir_all(folder).expect("a folder");
    }
    let table = std::fs::read(root().join("examples/valve_train/lift.csv")).expect("the table");
    let given = std::fs::read_to_string(root().join("examples/valve_train/forces.toml")).expect("the scene");
    for (name, place) in [("inside", "tables/lift.csv"), ("beside", "../elsewhere/lift.csv"), ("absolute", "")] {
        let path = if place.is_empty() { elsewhere.join("lift.csv") } else { scenes.join(place) };
        std::fs::write(&path, &table).expect("a table");
        let named = if place.is_empty() { text(&path).replace('\\', "/") } else { place.to_owned() };
        let scene = scenes.join(format!("{name}.toml"));
        // Comments stay, whatever the table is called.
        let own = given.replace("\"lift.csv\"", &format!("'{named}' # measured"));
        std::fs::write(&scene, format!("# Of the valve gear.\n{own}")).expect("a scene");
        let fmus = ["one.fmu", "two.fmu"].map(|fmu| folder.join(name).join(fmu));
        std::fs::create_dir_all(folder.join(name)).expect("a folder");
        let runtime = runtime();
        for (from, to) in [(&scene, &fmus[0]), (&fmus[0], &fmus[1])] {
            let run = camdrive(&["export", text(from), "-o", text(to), "--runtime", &runtime]);
            assert_eq!(run.code, 0, "{}", run.err);
        }
        assert!(std::fs::read(&fmus[0]).expect("one") == std::fs::read(&fmus[1]).expect("the other"), "{name}");
        let files = unzipped(&fmus[0]);
        let is_kept = name == "inside";
        let inside = if is_kept { named } else { "table_1.csv".to_owned() };
        assert_eq!(files[&format!("{EXTRA}model/{inside}")], table);
        let changed = if is_kept { format!("'{inside}'") } else { format!("\"{inside}\"") };
        let scene_inside = String::from_utf8(files[&format!("{EXTRA}model/scene.toml")].clone()).expect("UTF-8");
        assert!(
            scene_inside.starts_with("# Of the valve gear.\n") && scene_inside.contains(&(changed + " # measured"))
        );
        for (file, content) in files.iter().filter(|(file, _)| !file.starts_with("binaries/")) {
            assert!(!String::from_utf8_lossy(content).contains("elsewhere"), "{file}");
        }
        // Other commands read it as well, and name the FMU where they name the file.
        let said = |file: &Path, command: &str| camdrive(&[command, text(file)]);
        assert_eq!(said(&fmus[0], "describe").out, said(&scene, "describe").out);
        let (check, of_scene) = (said(&fmus[0], "check"), said(&scene, "check"));
        assert_eq!(check.out.replace(text(&fmus[0]), ""), of_scene.out.replace(text(&scene), ""));
        let told = format!("{}/{inside}: smoothing", text(&fmus[0]));
        assert!(check.err.contains(&told), "{}", check.err);
    }
}

#[test]
fn the_manifest_lists_what_is_in_its_folder() {
    let folder = folder("manifest");
    let run = camdrive(&["export", VALVE, SCENE, "-o", text(&folder), "--runtime", &runtime()]);
    assert_eq!(run.code, 0, "{}", run.err);
    for (fmu, count) in [("valve_train_forces.fmu", 3), ("transfer_manipulator.fmu", 2)] {
        let files = unzipped(&folder.join(fmu));
        let name = format!("{EXTRA}fmi-ls-manifest.xml");
        let manifest = String::from_utf8(files[&name].clone()).expect("UTF-8");
        let is_named = manifest.contains("<fmiReferences ")
            && manifest.contains("fmi-ls:fmi-ls-name=\"org.fmi-standard.fmi-ls-ref\"");
        assert!(is_named, "{manifest}");
        let listed: Vec<String> = manifest
            .split("<Related")
            .skip(1)
            .map(|tag| {
                let [source, role] = ["source", "role"].map(|name| attribute(tag, name).expect("an attribute"));
                assert_eq!(role, if source.starts_with("model/") { "model" } else { "result" }, "{tag}");
                format!("{EXTRA}{source}")
            })
            .collect();
        let there = files.into_keys().filter(|file| file.starts_with(EXTRA) && *file != name);
        assert_eq!(listed.iter().cloned().collect::<BTreeSet<_>>(), there.collect());
        assert_eq!(listed.len(), count);
    }
}

fn changes_of_results_are_found(fmu: &Path, changed: &Path) {
    let mut files = unzipped(fmu);
    let name = format!("{EXTRA}result.csv");
    let results = String::from_utf8(files[&name].clone()).expect("UTF-8");
    let mut table = csv::Reader::from_reader(results.as_bytes());
    let column = table.headers().expect("headings").iter().position(|name| name == "y").expect("an output");
    let mut lines: Vec<String> = results.lines().map(str::to_owned).collect();
    let mut cells: Vec<String> = lines[300].split(',').map(str::to_owned).collect();
    let value: f64 = cells[column].parse().expect("a number");
    cells[column] = (value + 1e-5).to_string();
    lines[300] = cells.join(",");
    let mut with = |content: Option<String>| {
        match content {
            Some(content) => files.insert(name.clone(), content.into_bytes()),
            None => files.remove(&name),
        };
        camdrive(&["verify", &zipped(changed, &files)])
    };
    let run = with(Some(lines.join("\n")));
    assert!(run.code == 1 && run.out.contains("\n  1 of 10 outputs does not agree"), "{}{}", run.out, run.err);
    let no: Vec<&str> = run.out.lines().filter(|line| line.ends_with(" no")).collect();
    assert!(no.len() == 1 && no[0].trim().starts_with("y "), "{}", run.out);
    let rows = |keep: &dyn Fn(usize) -> bool| {
        let kept = results.lines().enumerate().filter(|(i, _)| keep(*i));
        Some(kept.map(|(_, line)| line).collect::<Vec<_>>().join("\n"))
    };
    for (content, message) in
        [(rows(&|i| i < 9), "result.csv ends too early, at t = "), (rows(&|i| i != 9), "rows up to t = 6.5 s, not ")]
    {
        let run = with(content);
        assert!(run.code == 1 && run.out.contains(message), "{message}: {}{}", run.out, run.err);
    }
    let second = |column: &str| {
        let cells = |(i, line): (usize, &str)| format!("{line},{}", if i == 0 { column } else { "1" });
        Some(results.lines().enumerate().map(cells).collect::<Vec<_>>().join("\n"))
    };
    lines[300] = cells[..column].join(",");
    for (content, message) in [
        (Some(lines.join("\n")), "result.csv: CSV error"),
        (Some(results.replacen(",y,", ",z,", 1)), "the output `y` has no column"),
        (second("z"), "the FMU has no output `z`"),
        (second("drive.w"), "the FMU has no output `drive.w`"),
        (second("y"), "`y` has two columns"),
        (Some(results.replacen("\n0.0,", "\nzero,", 1)), "line 2: `zero` is no number"),
        (Some(results.replacen("\n0.0,", "\nNaN,", 1)), "line 2: `NaN` is no number"),
        (Some(results.lines().next().expect("a line").to_owned()), "it has no rows"),
        (None, "the FMU holds no results\n  = hint: "),
    ] {
        let run = with(content);
        assert!(run.code == 1 && run.out.is_empty() && run.err.contains(message), "{message}: {}{}", run.out, run.err);
    }
}

fn changes_of_the_scene_are_found(fmu: &Path, changed: &Path) {
    let mut files = unzipped(fmu);
    let scene = format!("{EXTRA}model/scene.toml");
    let own = String::from_utf8(files[&scene].clone()).expect("UTF-8");
    for (content, message) in [
        (format!("# A comment.\n{own}"), ""),
        (own.replacen("17.85 N", "17.8500001 N", 1), "the scene inside is not the drive's"),
        (own.replacen("name = \"", "name = \"t", 1), "the scene inside is not the drive's"),
        (own.replacen("model = ", "modle = ", 1), "changed.fmu"),
    ] {
        assert_ne!(content, own);
        files.insert(scene.clone(), content.into_bytes());
        let run = camdrive(&["verify", &zipped(changed, &files)]);
        let said = run.out.contains("changed: ") && run.out.contains(message);
        assert!(if message.is_empty() { run.code == 0 } else { run.code == 1 && said }, "{}{}", run.out, run.err);
    }
}

#[test]
fn an_fmu_agrees_with_its_results_and_a_changed_one_does_not() {
    let folder = folder("verify");
    // Of each model one; the tests of the FMUs take all.
    let scenes = [
        SCENE,
        TAPPET,
        BACKLASH,
        "examples/loom/scene.toml",
        "examples/rod_drive/scene.toml",
        "examples/rapier_loom/train.toml",
    ];
    let mut args = vec!["export"];
    args.extend(scenes);
    let runtime = runtime();
    args.extend(["-o", text(&folder), "--runtime", &runtime]);
    let run = camdrive(&args);
    assert_eq!(run.code, 0, "{}", run.err);
    let fmus: Vec<PathBuf> = contents(&folder).into_keys().map(|name| folder.join(name)).collect();
    let mut args = vec!["verify", "--json"];
    args.extend(fmus.iter().map(|fmu| text(fmu)));
    let run = camdrive(&args);
    assert_eq!(run.code, 0, "{}{}", run.out, run.err);
    let all: serde_json::Value = serde_json::from_str(&run.out).expect("JSON");
    assert_documented("verify", &all);
    assert_eq!(all.as_array().map(Vec::len), Some(scenes.len()));
    for of in all.as_array().into_iter().flatten() {
        let outputs = of["outputs"].as_array().expect("a list");
        assert!(!outputs.is_empty());
        for output in outputs {
            // Not so wide that whatever is computed agrees.
            let [largest, admissible] = ["largest", "admissible"].map(|key| output[key].as_f64().expect("a number"));
            assert!(largest == 0.0 || admissible < 1e-5 * largest, "{}: {output}", of["file"]);
        }
    }
    assert!(!run.err.contains("note: "), "{}", run.err);
    let (fmu, changed) = (folder.join("transfer_manipulator.fmu"), folder.join("changed.fmu"));
    changes_of_results_are_found(&fmu, &changed);
    changes_of_the_scene_are_found(&fmu, &changed);
    // Each of several FMUs gets its answer, behind a broken one, too.
    std::fs::write(&changed, "no FMU").unwrap();
    let args = ["verify", text(&fmus[0]), text(&changed), text(&fmus[1])];
    let run = camdrive(&args);
    assert!(run.code == 1 && run.err.starts_with("error: ") && run.err.contains("changed.fmu"), "{}", run.err);
    assert!(run.out.matches("outputs agree up to").count() == 2, "{}", run.out);
    let all: serde_json::Value = serde_json::from_str(&camdrive(&[&args[..], &["--json"]].concat()).out).expect("JSON");
    assert_documented("verify", &all);
    assert_eq!([0, 1, 2].map(|i| all[i]["agrees"].as_bool()), [true, false, true].map(Some));
    assert!(all[1]["error"].as_str().is_some_and(|error| error.contains("changed.fmu")), "{all}");
}

/// In the results of an FMU its inputs move, as the table beside them says, and `run` takes that table.
#[test]
fn inputs_move_in_the_experiment() {
    let folder = folder("moving");
    let scenes = ["guide_bar_speed", "train_input", "machine_torques", "train_servo"]
        .map(|name| format!("tests/fmpy/scenes/{name}.toml"));
    let runtime = runtime();
    let mut args = vec!["export", "examples/guide_bar/run_up.toml"];
    args.extend(scenes.iter().map(String::as_str));
    args.extend(["-o", text(&folder), "--runtime", &runtime]);
    let run = camdrive(&args);
    assert_eq!(run.code, 0, "{}", run.err);
    let input = folder.join("input.csv");
    for fmu in contents(&folder).into_keys().map(|name| folder.join(name)) {
        let run = camdrive(&["verify", text(&fmu)]);
        assert!(run.code == 0 && run.err.is_empty(), "{}{}", run.out, run.err);
        let files = unzipped(&fmu);
        let table = |name: &str| {
            let mut table = csv::Reader::from_reader(&files[&format!("{EXTRA}{name}")][..]);
            let names: Vec<String> = table.headers().expect("headings").iter().map(str::to_owned).collect();
            let rows =
                table.records().map(|row| row.expect("a row").iter().map(|x| x.parse().expect("a number")).collect());
            (names, rows.collect::<Vec<Vec<f64>>>())
        };
        let (names, rows) = table("input.csv");
        for (i, name) in names.iter().enumerate().skip(1) {
            let [first, last] = [&rows[0], &rows[rows.len() - 1]].map(|row| row[i]);
            let most = rows.iter().map(|row| row[i]).fold(0.0, f64::max);
            let right = match name.as_str() {
                "phi" => (last - first - 4.0 * std::f64::consts::PI).abs() < 1e-12,
                // The mean speed is half of the last one.
                "w" => (0.5 * (last - first) * rows[rows.len() - 1][0] - 4.0 * std::f64::consts::PI).abs() < 1e-12,
                "a" => first == 0.0 && last == 0.0 && most > 0.0,
                _ => (last - first).log2().fract() == 0.0,
            };
            assert!(right, "{}: {name} from {first} to {last}", fmu.display());
        }
        std::fs::write(&input, &files[&format!("{EXTRA}input.csv")]).expect("a table");
        let run = camdrive(&["run", text(&fmu), "--input", text(&input)]);
        assert!(run.code == 0 && run.err.is_empty(), "{}", run.err);
        let (names, rows) = table("result.csv");
        let lines: Vec<Vec<f64>> = run
            .out
            .lines()
            .skip(1)
            .map(|line| line.split(',').map(|x| x.parse().expect("a number")).collect())
            .collect();
        for (i, name) in names.iter().enumerate() {
            let largest = rows.iter().map(|row| row[i].abs()).fold(0.0, f64::max);
            let off = rows.iter().zip(&lines).map(|(row, line)| (row[i] - line[i]).abs()).fold(0.0, f64::max);
            assert!(rows.len() == lines.len() && off <= 1e-6 * largest + 1e-12, "{}: {name}: {off}", fmu.display());
            assert!(rows.iter().any(|row| row[i] != rows[0][i]), "{}: {name} rests", fmu.display());
        }
        let mut files = unzipped(&fmu);
        files.remove(&format!("{EXTRA}input.csv"));
        let run = camdrive(&["verify", &zipped(&input.with_file_name("without.zip"), &files)]);
        assert!(run.code == 1 && run.out.contains("changed: input.csv is missing"), "{}{}", run.out, run.err);
    }
}

#[test]
fn an_fmu_without_a_scene_is_told_from_a_scene() {
    let folder = folder("no_scene");
    let foreign = BTreeMap::from([("modelDescription.xml".to_owned(), Vec::new())]);
    let empty = zipped(&folder.join("foreign.fmu"), &foreign);
    let none = folder.join("none.fmu");
    std::fs::write(&none, "name = \"x\"\n").expect("a file");
    for command in ["check", "describe", "export", "cam", "steady"] {
        for (fmu, parts) in [
            (&*empty, ["the FMU holds no scene", "name the scene itself"]),
            (text(&none), ["this is no zip archive", "name a scene"]),
            ("absent.fmu", ["the archive cannot be read", "name a scene"]),
        ] {
            let run = camdrive(&[command, fmu]);
            let told = parts.iter().all(|part| run.err.contains(part)) && run.err.contains("= hint: ");
            assert!(run.code == 1 && run.out.is_empty() && told, "{command} {fmu}: {}", run.err);
        }
    }
    // A scene inside that is wrong is told with the place in the FMU.
    let scene = b"name = \"x\"\nmodel = \"ElasticCamDrive\"\nspeed = 3\n".to_vec();
    let wrong = zipped(&folder.join("wrong.fmu"), &BTreeMap::from([(format!("{EXTRA}model/scene.toml"), scene)]));
    let run = camdrive(&["check", &wrong]);
    assert!(run.code == 1 && run.err.contains("wrong.fmu/scene.toml:3:1"), "{}", run.err);
}

#[test]
fn export_writes_nothing_where_a_scene_is_wrong() {
    let folder = folder("export_wrong");
    let run = camdrive(&["export", SCENE, WRONG, "-o", text(&folder), "--runtime", &runtime()]);
    assert_eq!((run.code, run.out.as_str()), (1, ""));
    assert_eq!(std::fs::read_dir(&folder).expect("the folder").count(), 0);
}

#[test]
fn export_refuses_targets_and_libraries_that_do_not_fit() {
    let folder = folder("export_refuses");
    let runtime = runtime();
    let cases = [
        (vec!["export", SCENE, SCENE, "-o", text(&folder), "--runtime", &runtime], "both be written to"),
        (vec!["export", SCENE, SCENE, "-o", "x.fmu", "--runtime", &runtime], "several scenes"),
        (vec!["export", SCENE, "-o", text(&folder), "--runtime", "linux64=no_such_library.so"], "no_such_library.so"),
        (vec!["export", SCENE, "-o", text(&folder), "--runtime", "libcamdrive_fmu.so"], "PLATFORM=FILE"),
        (vec!["export", SCENE, "-o", text(&folder), "--runtime", &runtime, "--runtime", &runtime], "two runtime"),
        (vec!["export", SCENE, "-o", "Cargo.toml", "--runtime", &runtime], "a folder or a file NAME.fmu"),
        (vec!["export", SCENE, "-o", "Cargo.toml/x", "--runtime", &runtime], "Cargo.toml is a file, not a folder"),
        (vec!["export", SCENE, "-o", "missing/folder/x.fmu", "--runtime", &runtime], "missing/folder: the folder does"),
        (vec!["export", SCENE, "-o", "missing/folder/", "--runtime", &runtime], "missing: the folder does not exist"),
        (vec!["export", "examples/tappet/scen.toml"], "did you mean `examples/tappet/scene.toml`?"),
        (vec!["export", SCENE, "-o", "NUL.fmu", "--runtime", &runtime], "NUL.fmu: Windows has a device of this name"),
        (vec!["export", SCENE, "-o", "con/", "--runtime", &runtime], "Windows has a device of this name"),
        (
            vec!["export", SCENE, "-o", "foo.zip", "--runtime", &runtime],
            "called NAME.fmu\n  = hint: the name of a new folder",
        ),
        (vec!["export", SCENE, "-o", "-", "--runtime", &runtime], "-o -: -o takes a folder or a file NAME.fmu"),
    ];
    for (args, message) in cases {
        let run = camdrive(&args);
        assert!(is_refused(run.code) && run.out.is_empty(), "{args:?}");
        assert!(run.err.contains("error: ") && run.err.contains(message), "{args:?}: {}", run.err);
        assert!(!run.err.contains("os error"), "{}", run.err);
    }
    assert_eq!(std::fs::read_dir(&folder).expect("the folder").count(), 0);
    // A folder may have an ending where it is told to be one.
    let ending = folder.join("v1.zip/");
    let run = camdrive(&["export", SCENE, "-o", text(&ending), "--runtime", &runtime]);
    assert!(run.code == 0 && ending.join("transfer_manipulator.fmu").is_file(), "{}", run.err);
}

/// A task that is done at once, in this folder.
fn small_task(folder: &Path) -> String {
    let task = folder.join("task.toml");
    let content = "name = \"small\"\nharmonics = 3\nobjective = \"least_squares\"\nscale = \"40 mm\"\n\
        symmetry = \"even_half_wave\"\n[[dwell]]\ncentre = 0\nwidth = 0.5\nU = 0.5\n\
        [[dwell]]\ncentre = \"180 deg\"\nwidth = 0.5\nU = -0.5\n";
    std::fs::write(&task, content).expect("the folder can be written to");
    text(&task).to_owned()
}

/// The files in a folder with their contents.
#[cfg(unix)]
fn contents(folder: &Path) -> std::collections::BTreeMap<PathBuf, Vec<u8>> {
    let entries = std::fs::read_dir(folder).expect("the folder").map(|entry| entry.expect("an entry").path());
    entries.map(|path| (path.clone(), std::fs::read(path).expect("a file"))).collect()
}

#[cfg(unix)]
#[test]
fn where_the_disk_is_full_every_command_leaves_the_files_of_before() {
    let runtime = runtime();
    let loom = "examples/rapier_loom/scene.toml";
    let small = small_task(&folder("full_disk_task"));
    let commands: [&[&str]; 8] = [
        &["cam", loom, "-o", "."],
        &["synthesize", &small, "-o", "profile.toml", "--report", "."],
        &["compensate", "examples/loom/scene.toml", "-o", "hs.toml", "--report", "."],
        &["steady", loom, "--report", "."],
        &["stability", "examples/rod_drive/scene.toml", "--quick", "--orders", "2", "-o", "."],
        &["clearance", "examples/backlash_drive/scene.toml", "--turns", "4", "--quick", "-o", "."],
        &["tradeoff", "examples/guide_bar/scene.toml", "--quick", "--turns", "1", "-o", "."],
        &["export", SCENE, "examples/guide_bar/scene.toml", "-o", ".", "--runtime", &runtime],
    ];
    for args in commands {
        let folder = folder("full_disk");
        let run = |limit: &str| {
            let args = args.iter().map(|arg| match arg.ends_with(".toml") && arg.contains('/') {
                true => root().join(arg).display().to_string(),
                false => (*arg).to_owned(),
            });
            // The limit of a file [KiB] stands for that of the disk.
            let script = format!("ulimit -f {limit}; exec \"$0\" \"$@\"");
            let mut bash = Command::new("bash");
            bash.current_dir(&folder).args(["-c", &script, env!("CARGO_BIN_EXE_camdrive")]).args(args);
            bash.output().expect("bash starts")
        };
        assert!(run("unlimited").status.success(), "{args:?}");
        let mut sizes: Vec<usize> = contents(&folder).values().map(Vec::len).collect();
        sizes.sort_unstable();
        for (path, content) in contents(&folder) {
            // Its beginning tells that a command wrote it.
            let before = [&content[..content.len().min(500)], b"\nwhat was there before"].concat();
            std::fs::write(path, before).expect("the folder can be written to");
        }
        let before = contents(&folder);
        // All but the largest file have their space; the times that a tradeoff measures change its size a little.
        let largest = sizes[sizes.len() - 1];
        let limit = if args[0] == "tradeoff" { largest * 9 / 10 } else { largest - 1 } / 1024;
        assert!(sizes.len() > 1 && sizes[0] <= 1024 * limit, "{args:?}: {sizes:?}");
        let full = run(&limit.to_string());
        let err = String::from_utf8_lossy(&full.stderr);
        assert_eq!((full.status.code(), full.stdout.len()), (Some(1), 0), "{args:?}: {err}");
        assert!(err.contains("cannot be written") && err.contains("existing files"), "{err}");
        assert!(contents(&folder) == before, "{args:?}");
    }
}

#[cfg(unix)]
#[test]
fn a_signal_leaves_no_hidden_files() {
    let folder = folder("signal");
    let scenes: Vec<String> = (0..4)
        .map(|i| {
            let scene = folder.join(format!("s{i}.toml"));
            let content = std::fs::read_to_string(root().join("examples/guide_bar/scene.toml")).expect("the example");
            std::fs::write(&scene, content.replace("guide_bar", &format!("s{i}")))
                .expect("the folder can be written to");
            text(&scene).to_owned()
        })
        .collect();
    let fmus = folder.join("fmus");
    // The shell meets the first hidden file; its own `kill` is the fastest.
    let script = "\"$@\" >/dev/null & until compgen -G \"$0/.[!.]*\" >/dev/null; do kill -0 $! || exit 9; done; \
                  kill -TERM $!; wait $!";
    let ended = |_: &i32| {
        let mut bash = Command::new("bash");
        bash.args(["-c", script, text(&fmus), env!("CARGO_BIN_EXE_camdrive"), "export", "-o", text(&fmus)]);
        let status = bash.args(["--runtime", &runtime()]).args(&scenes).status().expect("bash starts");
        let names: Vec<PathBuf> = contents(&fmus).into_keys().collect();
        assert!(names.iter().all(|name| name.extension().is_some_and(|e| e == "fmu")), "{names:?}");
        assert!([0, scenes.len()].contains(&names.len()), "{names:?}");
        std::fs::remove_dir_all(&fmus).expect("the folder can be removed");
        status.code() == Some(128 + 15)
    };
    // Now and then all is written before the signal comes.
    assert!((0..10).any(|i| ended(&i)));
}

#[cfg(unix)]
#[test]
fn a_result_has_the_rights_of_the_file_before_but_not_of_its_owner() {
    use std::os::unix::fs::PermissionsExt as _;
    let folder = folder("rights");
    let (task, profile) = (small_task(&folder), folder.join("profile.toml"));
    let mode = || std::fs::metadata(&profile).expect("the profile").permissions().mode() & 0o7777;
    for (before, after) in [(0o4755, 0o755), (0o2640, 0o640)] {
        assert_eq!(camdrive(&["synthesize", &task, "-o", text(&profile)]).code, 0);
        std::fs::set_permissions(&profile, std::fs::Permissions::from_mode(before)).expect("a file of our own");
        assert_eq!((camdrive(&["synthesize", &task, "-o", text(&profile)]).code, mode()), (0, after));
    }
}

/// Whether nothing in the text steers a terminal, turns the direction of writing, or looks like a message of ours that is none.
fn is_harmless(text: &str) -> bool {
    let steers = |c: char| c != '\n' && c.is_control() || ('\u{202a}'..='\u{202e}').contains(&c);
    !text.contains(steers) && !text.lines().any(|line| line.starts_with("error: forged")) && text.len() < 20_000
}

#[cfg(unix)]
#[test]
fn what_files_hold_neither_steers_the_terminal_nor_fills_it() {
    let folder = folder("hostile");
    let evil = "\u{1b}]0;x\u{7}\u{9b}2J\u{7f}\u{202e}\r";
    let write = |name: &str, content: &str| {
        let path = folder.join(name);
        std::fs::write(&path, content).expect("the folder can be written to");
        text(&path).to_owned()
    };
    let drive = "drive = { speed = 1 }\nelasticity = { place = \"output\", m = 1, c = 1e4 }\n";
    let cam = "cam = { law = \"fourier\", a = [0, \"1 mm\"] }\n";
    let escaped = "\\u001B]0;x\\u0007\\u009B2J\\u007F\\u202E\\r\\nerror: forged";
    let model = "model = \"ElasticCamDrive\"\n";
    // Names of files and descriptions of scenes that are right.
    let right =
        format!("name = \"x\"\ndescription = \"{}\"\n{model}{cam}{drive}", escaped.replace("\\nerror", "\\n: error"));
    let right = write(&format!("{evil}\nerror: forged.toml"), &right);
    let xml = text(&folder.join("fmus/")).to_owned();
    let export = ["export", &right, "-o", &xml, "--runtime", &runtime()];
    for args in [
        &["check", &right][..],
        &["describe", &right],
        &["describe", "--json", &right],
        &["describe", "--xml", &right],
        &export,
    ] {
        let run = camdrive(args);
        assert_eq!(run.code, 0, "{args:?}: {}", run.err);
        assert!(is_harmless(&run.out) && is_harmless(&run.err), "{args:?}: {:?} {:?}", run.out, run.err);
    }
    assert!(camdrive(&["describe", &right]).out.contains("␛]0;x␇"));
    // What is wrong in scenes and tables.
    let long = "9".repeat(100_000) + "x";
    let by_table = |table: &str, keys: &str| {
        write("t.csv", table);
        format!("name = \"x\"\n{model}cam = {{ law = \"table\", file = \"t.csv\"{keys} }}\n{drive}")
    };
    for scene in [
        format!("name = \"{escaped}\"\n{model}{cam}{drive}"),
        format!("name = \"x\"\n{model}{cam}{drive}\"{escaped}\" = 1\n"),
        format!("name = \"x\"\nmodel = \"{escaped}\"\n{cam}{drive}"),
        format!("name = \"x\"\n{model}{cam}{}", drive.replace("speed = 1", &format!("speed = \"1 {escaped}\""))),
        format!("name = \"x\"\n{model}cam = {{ law = \"table\", file = \"{escaped}\" }}\n{drive}"),
        by_table(&format!("0;0\n{evil};1\n"), ""),
        format!("name = \"{long}\"\n{model}{cam}{drive}"),
        format!("name = \"x\"\n{model}{cam}{drive}{long} = 1\n"),
        format!("name = \"x\"\nname = \"{long}\"\n{model}{cam}{drive}"),
        by_table(&format!("0;0\n1;{long}\n"), ""),
        by_table(&format!("phi;{long}\n0;0\n"), ", lift_column = \"h\""),
    ] {
        let wrong = write(&format!("{evil}\nerror: forged.wrong.toml"), &scene);
        for args in [&["check", &wrong][..], &["check", "--json", &wrong], &["export", &wrong]] {
            let run = camdrive(args);
            assert_eq!(run.code, 1, "{args:?}: {}", run.err);
            assert!(is_harmless(&run.out) && is_harmless(&run.err), "{args:?}: {:?} {:?}", run.out, run.err);
        }
    }
    // Words of the command line.
    let run = camdrive(&["check", &format!("--{evil}")]);
    assert!(run.code == 2 && is_harmless(&run.err), "{:?}", run.err);
    // The first line of a result names its origin.
    let (task, profile) = (
        write(&format!("{evil}\n[x].toml"), &std::fs::read_to_string(small_task(&folder)).unwrap()),
        folder.join("p.toml"),
    );
    let run = camdrive(&["synthesize", &task, "-o", text(&profile)]);
    let written = std::fs::read_to_string(&profile).expect("the profile");
    assert!(run.code == 0 && is_harmless(&run.out) && is_harmless(&written), "{:?}", run.out);
    assert!(written.lines().next().is_some_and(|line| line.contains(" by camdrive synthesize")), "{written}");
}

#[test]
fn results_replace_results_and_nothing_else() {
    let folder = folder("replaced");
    let scene = folder.join("valve.toml");
    let (valve, profile) = (folder.join("valve.csv"), folder.join("profile.toml"));
    std::fs::copy(root().join("tests/scenes/table_good.csv"), &valve).expect("the table");
    let content = "name = \"valve\"\nmodel = \"ElasticCamDrive\"\n[cam]\nlaw = \"table\"\nfile = \"valve.csv\"\n\
        angle_unit = \"deg\"\nlift_unit = \"mm\"\n[geometry]\nfollower = \"translating\"\nroller_radius = \"5 mm\"\n\
        base_radius = \"60 mm\"\n[drive]\nspeed = 1\n[elasticity]\nplace = \"output\"\nm = 1\nc = 1e4\n";
    std::fs::write(&scene, content).expect("the folder can be written to");
    // The table of the scene has the name of a result.
    let run = camdrive(&["cam", text(&scene), "-o", text(&folder)]);
    assert!(is_refused(run.code) && run.err.contains("valve.csv: the result would overwrite an input"), "{}", run.err);
    assert_eq!(std::fs::read_dir(&folder).expect("the folder").count(), 2);
    // What is replaced is told.
    let task = small_task(&folder);
    let args = ["synthesize", &task, "-o", text(&profile)];
    let (first, second) = (camdrive(&args), camdrive(&args));
    assert!(
        first.out.ends_with("profile.toml\n") && second.out.ends_with("profile.toml (replaced)\n"),
        "{}",
        second.out
    );
    // A file that is protected stays, and so does a folder.
    let mut permissions = std::fs::metadata(&profile).expect("the profile").permissions();
    permissions.set_readonly(true);
    std::fs::set_permissions(&profile, permissions).expect("the profile can be protected");
    let report = folder.join("report");
    let args = ["synthesize", &task, "--report", text(&report), "-o"];
    for (target, reason) in [
        (&profile, "cannot be written: it is write-protected"),
        (&folder, "this is a folder; -o takes a file NAME.toml"),
    ] {
        let run = camdrive(&[&args[..], &[text(target)]].concat());
        assert!(is_refused(run.code) && run.err.contains(reason), "{}", run.err);
    }
    // A scene that a person wrote is kept, before any work begins, unless it is given up.
    for command in [["synthesize", &task], ["compensate", "examples/loom/scene.toml"]] {
        let own = folder.join("own.toml");
        std::fs::write(&own, "# by hand\n").expect("the folder can be written to");
        let args = [&command[..], &["-o", text(&own)]].concat();
        let run = camdrive(&args);
        assert!(is_refused(run.code) && run.err.contains("own.toml: no command wrote this file"), "{}", run.err);
        assert!(run.err.contains("--force"), "{}", run.err);
        assert_eq!(std::fs::read_to_string(&own).expect("the file"), "# by hand\n");
        let run = camdrive(&[&args[..], &["--force"]].concat());
        assert!(run.code == 0 && run.out.contains("own.toml (replaced)\n"), "{}", run.err);
        // Now a command wrote it.
        assert_eq!(camdrive(&args).code, 0);
    }
    for option in ["-o", "--report"] {
        let run = camdrive(&["synthesize", TASK, option, "-"]);
        assert!(is_refused(run.code) && run.err.contains(&format!("{option} -: {option} takes a f")), "{}", run.err);
    }
}

#[test]
fn a_folder_is_not_called_like_a_file_nor_a_scene_like_an_archive() {
    let loom = "examples/rapier_loom/scene.toml";
    let reports: [&[&str]; 7] = [
        &["cam", loom, "-o"],
        &["tradeoff", SCENE, "-o"],
        &["stability", SCENE, "-o"],
        &["clearance", BACKLASH, "-o"],
        &["steady", loom, "--report"],
        &["compensate", loom, "--report"],
        &["synthesize", TASK, "--report"],
    ];
    for args in reports {
        let run = camdrive(&[args, &["nul"]].concat());
        assert!(
            is_refused(run.code) && run.err.contains("nul: Windows has a device of this name"),
            "{args:?}: {}",
            run.err
        );
        let run = camdrive(&[args, &["foo.zip"]].concat());
        let message = format!("foo.zip: {} takes a folder\n  = hint: the name of a new folder ends with /", args[2]);
        assert!(is_refused(run.code) && run.err.contains(&message), "{args:?}: {}", run.err);
    }
    for args in [["synthesize", TASK], ["compensate", loom]] {
        let run = camdrive(&[&args[..], &["-o", "foo.zip"]].concat());
        let message = "foo.zip: a scene or a profile is TOML\n  = hint: -o takes a file NAME.toml";
        assert!(is_refused(run.code) && run.err.contains(message), "{args:?}: {}", run.err);
        // A folder, there or not, is no file, and no file is a folder.
        for (path, message) in [
            ("src", "src: this is a folder; -o takes a file NAME.toml"),
            ("none/", "none/: this is a folder; -o takes a file NAME.toml"),
            ("lpt1.toml", "lpt1.toml: Windows has a device of this name"),
        ] {
            let run = camdrive(&[&args[..], &["-o", path]].concat());
            assert!(is_refused(run.code) && run.err.contains(message), "{args:?}: {}", run.err);
        }
    }
    assert!(!root().join("foo.zip").exists());
    let report = folder("ending").join("v1.zip/");
    let run = camdrive(&["steady", loom, "--report", text(&report)]);
    assert!(run.code == 0 && report.join("rapier_loom.steady.csv").is_file(), "{}", run.err);
}

#[test]
fn files_of_another_kind_are_called_by_their_names() {
    let folder = folder("kinds");
    let file = |name: &str, content: &[u8]| {
        let path = folder.join(name);
        std::fs::write(&path, content).expect("the folder can be written to");
        text(&path).to_owned()
    };
    let (table, archive) = (file("lift.csv", b"phi;U\n0;0\n90;5\n"), file("x.zip", b"PK\x03\x04 and so on"));
    let (xml, json) = (file("x.svg", b"<?xml version=\"1.0\"?>\n<svg/>\n"), file("x.json", b"{\n  \"a\": 1\n}\n"));
    let profile = file("profile.toml", b"[cam]\nlaw = \"fourier\"\na = [0.0, 0.1]\n");
    let synthesize = format!("camdrive synthesize {TASK}");
    let check = format!("`camdrive check {SCENE}`");
    for command in
        ["check", "describe", "run", "export", "steady", "cam", "compensate", "tradeoff", "stability", "clearance"]
    {
        for (path, parts) in [
            (TASK, ["this is a motion task, not a scene", &synthesize]),
            (&profile, ["this is a cam profile, not a scene", "append"]),
            (&table, ["this is a table", "law = \"table\""]),
            (&archive, ["this is an FMU", "camdrive run"]),
            (&xml, ["this is XML, not a scene", "name a scene file"]),
            (&json, ["this is JSON, not a scene", "name a scene file"]),
            (text(&folder), ["this is a folder, not a scene", "name a scene file"]),
        ] {
            let run = camdrive(&[command, path]);
            assert_eq!((run.code, run.out.as_str()), (1, ""), "{command} {path}");
            assert!(parts.iter().all(|part| run.err.contains(part)), "{command} {path}: {}", run.err);
            assert!(!run.err.contains("is not known"), "{command} {path}: {}", run.err);
        }
    }
    for (path, parts) in
        [(SCENE, ["this is a scene, not a task", &*check]), (&archive, ["this is an FMU", "not a task"])]
    {
        let run = camdrive(&["synthesize", path]);
        assert!(run.code == 1 && parts.iter().all(|part| run.err.contains(part)), "{path}: {}", run.err);
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_file_without_end_is_not_read_to_its_end() {
    let folder = folder("endless");
    let scene = folder.join("scene.toml");
    let content = "name = \"x\"\nmodel = \"ElasticCamDrive\"\n[cam]\nlaw = \"table\"\nfile = \"/dev/zero\"\n";
    std::fs::write(&scene, content).expect("the folder can be written to");
    for args in [["check", "/dev/zero"], ["synthesize", "/dev/zero"], ["check", text(&scene)]] {
        let run = camdrive(&args);
        assert!(run.code == 1 && run.err.contains("it has more than 16 MB"), "{args:?}: {}", run.err);
    }
    let run = camdrive(&["export", SCENE, "-o", text(&folder), "--runtime", "linux64=/dev/zero"]);
    assert!(run.code == 1 && run.err.contains("/dev/zero is not a file"), "{}", run.err);
}

#[test]
fn help_prints_commands_and_sections() {
    let run = camdrive(&["help", "export"]);
    assert!(run.code == 0 && run.out.contains("Usage: camdrive export"), "{}{}", run.out, run.err);
    assert_eq!(camdrive(&["help"]).out, camdrive(&[]).out);
    let run = camdrive(&["help", "scene"]);
    assert!(run.out.contains("\nmodel\n") && run.out.contains("elasticity, backlash"), "{}", run.out);
    let run = camdrive(&["help", "scene", "backlash"]);
    assert!(run.out.contains("coefficient of restitution (0 to 1; default 0)"), "{}", run.out);
    let run = camdrive(&["help", "task", "bound"]);
    assert!(run.out.contains("[[bound]]") && run.out.contains("limit"), "{}", run.out);
    for (args, said) in [(["help", "scene", "cams"], "no section cams"), (["help", "exprot", ""], "no command exprot")]
    {
        let run = camdrive(&args);
        assert!(is_refused(run.code) && run.err.contains(said), "{}", run.err);
    }
}

#[test]
fn a_new_scene_replaces_nothing_of_others() {
    let folder = folder("new");
    let scene = folder.join("scene.toml");
    let run = camdrive(&["new", "DriveTrain", "-o", text(&scene)]);
    assert_eq!((run.code, run.err.as_str()), (0, ""));
    // What a user has edited since then.
    let run = camdrive(&["new", "RigidMachine", "-o", text(&scene)]);
    assert!(run.code == 1 && run.err.contains("this file exists; it is kept"), "{}", run.err);
    let run = camdrive(&["new", "RigidMachine", "-o", text(&scene), "--force"]);
    assert_eq!((run.code, run.err.as_str()), (0, ""));
    let run = camdrive(&["check", text(&scene)]);
    assert!(run.code == 0 && run.out.contains("RigidMachine ok"), "{}{}", run.out, run.err);
    std::fs::write(&scene, "name = \"mine\"\n").unwrap();
    let run = camdrive(&["new", "DriveTrain", "-o", text(&scene)]);
    assert!(run.code == 1 && run.err.contains("--force"), "{}", run.err);
    assert_eq!(std::fs::read_to_string(&scene).unwrap(), "name = \"mine\"\n");
    let task = folder.join("task.toml");
    let run = camdrive(&["new", "task", "-o", text(&task)]);
    assert!(run.code == 1 && run.err.contains("scene.toml: this file exists"), "{}", run.err);
    assert!(!task.exists());
    let run = camdrive(&["new", "Press"]);
    assert!(run.code == 2 && run.err.contains("a similar value exists: 'press'"), "{}", run.err);
    assert_eq!(
        camdrive(&["schema", "task"]).out,
        std::fs::read_to_string(root().join("docs/task.schema.json")).unwrap()
    );
}

#[test]
fn every_template_is_right_and_runs_as_it_stands() {
    let list = camdrive(&["new"]).out;
    let names: Vec<&str> = list.lines().map_while(|line| line.split_whitespace().next()).collect();
    assert_eq!(names.len(), 10, "{list}");
    for name in names {
        let folder = folder(&format!("new_{name}"));
        let file = folder.join("main.toml");
        let done = |args: &[&str]| {
            let run = camdrive(args);
            assert!(run.code == 0 && !run.err.contains("warning"), "{name}: {args:?}\n{}{}", run.out, run.err);
            run.out
        };
        done(&["new", name, "-o", text(&file)]);
        for written in std::fs::read_dir(&folder).unwrap().map(|file| file.unwrap().path()) {
            let is_scene = std::fs::read_to_string(&written).unwrap().starts_with("# A scene");
            if is_scene || (written == file && name == "system") {
                let json = done(&["check", "--json", text(&written)]);
                let checked: serde_json::Value = serde_json::from_str(&json).unwrap();
                assert_eq!(checked[0]["verdict"]["level"], "good", "{name}: {json}");
                done(&["run", text(&written), "--stop", "0.1 s"]);
            }
        }
        let target = folder.join("written");
        match name {
            "task" => done(&["synthesize", text(&file), "-o", text(&target.with_extension("toml"))]),
            "study" => done(&["study", text(&file), "-o", text(&target)]),
            // Its page has the errors over the step, which takes long.
            "system" => String::new(),
            _ => done(&["report", text(&file), "-o", text(&target.with_extension("html"))]),
        };
        // Others cross their play or hit its flanks, which a report has to mention.
        if ["dwell-rise-dwell", "measured-lift", "valve-train", "parallel-crank"].contains(&name) {
            let page = std::fs::read_to_string(target.with_extension("html")).unwrap();
            assert!(!page.contains("attention") && page.contains("✔"), "{name}");
        }
    }
}

/// Headings and rows of CSV without quotes.
fn table(csv: &str) -> (Vec<&str>, Vec<Vec<f64>>) {
    let mut lines = csv.lines();
    let headings = lines.next().expect("headings").split(',').collect();
    (headings, lines.map(|line| line.split(',').map(|cell| cell.parse().expect("a number")).collect()).collect())
}

#[test]
fn run_of_a_scene_has_the_values_of_its_drive() {
    let guide_bar = "examples/guide_bar/scene.toml";
    let mut drive = camdrive_cli::scene::read(&root().join(guide_bar)).unwrap().resource().build().unwrap();
    let reference = |drive: &camdrive::drives::AnyDrive, name: &str| {
        drive.descriptions().iter().position(|d| d.name == name).expect("the variable is there")
    };
    let (experiment, w, mode) = (drive.experiment(), reference(&drive, "drive.w"), reference(&drive, "start.mode"));
    let outputs = ["y", "q"].map(|name| reference(&drive, name));
    drive.set_up(0.0, Some(experiment.tolerance));
    drive.set(w, 2000.0 * std::f64::consts::TAU / 60.0).unwrap();
    drive.set(mode, 1.0).unwrap();
    drive.start().unwrap();
    let args = ["--output", "y,q", "--start", "drive.w=2000 rpm", "--start", "start.mode=at_rest"];
    let run = camdrive(&[&["run", guide_bar], &args[..]].concat());
    assert_eq!((run.code, run.err.as_str()), (0, ""));
    let (headings, rows) = table(&run.out);
    assert_eq!(headings, ["time", "y", "q"]);
    assert_eq!(rows.len() as f64, (experiment.stop / experiment.step).round() + 1.0);
    let mut time = 0.0;
    for row in &rows {
        if row[0] > time {
            drive.advance(time, row[0] - time).unwrap();
            time = row[0];
        }
        assert_eq!(row[1..], outputs.map(|output| drive.get(output).unwrap()), "t = {time} s");
    }
    assert!((time, true) == (experiment.stop, rows.iter().any(|row| row[2].abs() > 1e-5)));

    // All outputs; the last step is shortened: 0, 4, 8 and 10 ms.
    let run = camdrive(&["run", guide_bar, "--stop", "10 ms", "--step", "0.004"]);
    let times: Vec<&str> = run.out.lines().skip(1).filter_map(|line| line.split(',').next()).collect();
    assert_eq!(times, ["0.0", "0.004", "0.008", "0.01"], "{}", run.err);
    let folder = folder("run_scene");
    let [csv, json] = ["bar.csv", "bar.json"].map(|name| folder.join(name));
    let run_to = |file: &Path, more: &[&str]| {
        let run =
            camdrive(&[&["run", guide_bar, "--stop", "10 ms", "--step", "4 ms", "-o", text(file)], more].concat());
        assert_eq!((run.code, run.out.as_str(), run.err.as_str()), (0, "", ""));
        std::fs::read_to_string(file).expect("the result is there")
    };
    assert_eq!(run_to(&csv, &[]), run.out);
    // The same as a document, with what `describe` says of the variables.
    let document: serde_json::Value = serde_json::from_str(&run_to(&json, &["--json"])).unwrap();
    let describe: serde_json::Value = serde_json::from_str(&camdrive(&["describe", guide_bar, "--json"]).out).unwrap();
    assert_eq!(["name", "model"].map(|key| &document[key]), ["name", "model"].map(|key| &describe[key]));
    let mut described = describe["variables"].as_array().unwrap().iter().filter(|v| v["causality"] == "output");
    let columns = document["columns"].as_array().unwrap();
    let (headings, rows) = (run.out.lines().next().unwrap(), run.out.lines().skip(1));
    let rows: Vec<Vec<f64>> = rows.map(|row| row.split(',').map(|cell| cell.parse().unwrap()).collect()).collect();
    assert_eq!((columns[0]["name"].as_str(), columns[0]["unit"].as_str()), (Some("time"), Some("s")));
    for (i, column) in columns.iter().enumerate() {
        if i > 0 {
            let variable = described.next().expect("an output");
            for key in ["name", "unit", "description"] {
                assert_eq!(column[key], variable[key], "{key}");
            }
        }
        let name = column["name"].as_str().unwrap();
        assert!(headings.contains(name), "{name}");
        let values: Vec<f64> = column["values"].as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect();
        assert_eq!(values, rows.iter().map(|row| row[i]).collect::<Vec<_>>(), "{name}");
    }
    assert!(described.next().is_none());
}

#[test]
fn inputs_of_a_run_are_linear_between_the_rows_of_their_table() {
    let folder = folder("run_input");
    let file = |name: &str, content: &str| {
        let path = folder.join(name);
        std::fs::write(&path, content).expect("the folder can be written to");
        path
    };
    let scene = std::fs::read_to_string(root().join("examples/guide_bar/run_up.toml")).unwrap();
    let speed = file("speed.toml", &scene.replace("mode = \"input\"", "mode = \"speed\""));
    // From 600 to 1800 rpm between 50 and 250 ms, held outside.
    let ramp = file("ramp.csv", "time [ms];w [rpm]\n50;600\n250;1800\n");
    let end = |scene: &Path, input: &Path, step: &str, output: &str| -> Vec<f64> {
        let args = ["run", text(scene), "--input", text(input), "--stop", "0.3", "--step", step, "--output", output];
        let run = camdrive(&args);
        assert_eq!((run.code, run.err.as_str()), (0, ""), "{step}");
        let (_, rows) = table(&run.out);
        rows.last().unwrap().clone()
    };
    let (low, high) = (20.0 * std::f64::consts::PI, 60.0 * std::f64::consts::PI);
    let phi = 0.05 * low + 0.2 * (low + high) / 2.0 + 0.05 * high;
    let stroke = 0.94e-3;
    let coarse = end(&speed, &ramp, "0.3", "phi,q,y");
    assert!((coarse[1] - phi).abs() < 1e-13 * phi, "{} instead of {phi}", coarse[1]);
    assert!(coarse[2].abs() > 1e-8, "{coarse:?}");
    // Steps that divide the rows, and that do not: the inputs at a communication point are those of the table.
    for step in ["10 ms", "7 ms", "0.1234 ms"] {
        let fine = end(&speed, &ramp, step, "phi,q,y");
        for (i, size) in [(1, phi), (2, stroke), (3, stroke)] {
            assert!((fine[i] - coarse[i]).abs() < 1e-12 * size, "{step}: {fine:?} and {coarse:?}");
        }
    }
    // The same motion by angle and speed, and by the acceleration, too: of them the last one is linear.
    let [at, behind] = [0.05 * low, 0.05 * low + 0.1 * (low + high)];
    let slope = (high - low) / 0.2;
    let both = format!("time,phi,w\n0,0,{low}\n0.05,{at},{low}\n0.25,{behind},{high}\n0.3,{phi},{high}\n");
    let all = format!(
        "time,w,a,phi\n0,{low},0,0\n0.05,{low},0,{at}\n0.0500001,{},{slope},{}\n0.25,{high},{slope},{behind}\n\
         0.2500001,{high},0,{}\n",
        low + 1e-7 * slope,
        at + 1e-7 * low,
        behind + 1e-7 * high
    );
    let inputs = root().join("examples/guide_bar/run_up.toml");
    for (name, content, bound) in [("both.csv", &both, 1e-9), ("all.csv", &all, 1e-4)] {
        let input = file(name, content);
        let first = end(&inputs, &input, "0.3", "q,y");
        for step in ["10 ms", "0.777 ms"] {
            let other = end(&inputs, &input, step, "q,y");
            assert!((1..3).all(|i| (first[i] - other[i]).abs() < 1e-12 * stroke), "{name} {step}: {first:?} {other:?}");
        }
        assert!((1..3).all(|i| (first[i] - coarse[i + 1]).abs() < bound * stroke), "{name}: {first:?} {coarse:?}");
    }
}

#[test]
fn a_wheel_turns_as_the_torques_of_a_table_say() {
    let folder = folder("run_torques");
    let [scene, input] = ["wheel.toml", "torques.csv"].map(|name| folder.join(name));
    // 2 kg·m² at 5 rad/s; a brake that rises to 4 N·m within a second, a drive of 1 N·m that rises to 3 N·m in the next one.
    let wheel = "name = \"wheel\"\nmodel = \"RigidMachine\"\nmachine.J0 = 2\nmotor.kind = \"input\"\nstart.w_start = 5\n\
                 [[follower]]\nm = 1\ncam = { law = \"fourier\", a = [0.01] }\n";
    std::fs::write(&scene, wheel).unwrap();
    std::fs::write(&input, "tau [kN.m];time;M_an\n0,0;0;1\n0,004;1;1\n0,004;2;3\n").unwrap();
    for step in ["0.5", "0.7", "3"] {
        let args = ["run", text(&scene), "--input", text(&input), "--stop", "3", "--step", step, "--output", "w,phi,a"];
        let run = camdrive(&args);
        assert_eq!((run.code, run.err.as_str()), (0, ""));
        let (_, rows) = table(&run.out);
        // w = 5 + ∫ (M - τ) dt / 2, φ = 15 + ∫ (3 - t) (M - τ) dt / 2.
        for (value, expected) in rows.last().unwrap().iter().zip([3.0, 3.0, 145.0 / 12.0, -0.5]) {
            assert!((value - expected).abs() < 1e-12, "{step}: {value} instead of {expected}");
        }
        // The torques of a communication point count in what is read there.
        for row in &rows {
            let [t, a] = [row[0], row[3]];
            let balance = (1.0 + 2.0 * (t - 1.0).clamp(0.0, 1.0) - 4.0 * t.min(1.0)) / 2.0;
            assert!((a - balance).abs() < 1e-12, "{step}: {a} instead of {balance} at {t} s");
        }
    }
}

#[test]
fn a_run_refuses_what_it_cannot_do_and_writes_nothing() {
    let folder = folder("run_wrong");
    let result = folder.join("result.csv");
    std::fs::write(&result, "as it was").unwrap();
    let guide_bar = "examples/guide_bar/scene.toml";
    let run_up = "examples/guide_bar/run_up.toml";
    let cases: [(&[&str], &[&str]); 15] = [
        (
            &["--start", "drive.w=1e9 rpm"],
            &["`drive.w`: 1.0471975511965977e8 rad/s", "expected -1000000 to 1000000 rad/s"],
        ),
        (&["--start", "drive.w=3 mm"], &["`drive.w`", "an angular velocity is expected"]),
        (&["--start", "drive.v=3"], &["no variable `drive.v`", "did you mean `drive.w`?"]),
        (&["--start", "start.mode=steady"], &["not one of at_rest", "steady_state"]),
        (&["--start", "m"], &["NAME=VALUE"]),
        (&["--start", "m=1", "--start", "m=2"], &["`m` is set twice"]),
        (&["--start", "q=1"], &["`q` is computed"]),
        (&["--output", "y,qq"], &["--output", "no variable `qq`"]),
        (&["--step", "0"], &["--step", "at least"]),
        (&["--step", "-1 ms"], &["--step", "at least"]),
        (&["--step", "1 mm"], &["--step", "a time is expected"]),
        (&["--step", "1 ns"], &["--step", "numbers", "hint"]),
        (&["--stop", "0"], &["--stop", "does not exceed"]),
        (&["--stop", "nan"], &["--stop", "finite number"]),
        (&["--input", "x.csv"], &["there are no inputs"]),
    ];
    for (args, parts) in cases {
        let run = camdrive(&[&["run", guide_bar, "-o", text(&result)], args].concat());
        assert!(is_refused(run.code) && run.out.is_empty(), "{args:?}");
        assert!(
            run.err.starts_with("error: ") && parts.iter().all(|part| run.err.contains(part)),
            "{args:?}: {}",
            run.err
        );
    }
    let input = folder.join("input.csv");
    let cases: [(&str, &[&str]); 11] = [
        ("time,w\n0,1\n1,2\n", &["`w` has a column, but not `phi`", "mode = \"speed\""]),
        ("time,phi,v\n0,1,1\n1,2,1\n", &["column 3, \"v\"", "time, phi, w, a"]),
        ("time,phi [mm]\n0,1\n", &["column 2", "is the unit of length"]),
        ("time,phi,phi\n0,1,2\n", &["`phi` has two columns"]),
        ("phi,w\n0,1\n", &["no column `time`"]),
        ("time\n0\n", &["no column of an input"]),
        ("time,phi\n", &["no row with numbers"]),
        ("time,phi\n0,1\n1,x\n", &["input.csv:3:3", "\"x\" is not a finite number"]),
        ("time,phi\n0,1\n1,2\n0.5,3\n", &["input.csv:4:1", "0.5 s does not follow 1 s"]),
        ("time,phi\n0,1\n1,1e300\n", &["input.csv:3:1", "`phi`: 1e300 rad is not admissible"]),
        ("time,phi\n0,1\nx,3\n2,3\n", &["input.csv:3:1", "\"x\" is not a finite number"]),
    ];
    for (content, parts) in cases {
        std::fs::write(&input, content).unwrap();
        let run = camdrive(&["run", run_up, "--input", text(&input), "-o", text(&result)]);
        assert!(is_refused(run.code) && run.out.is_empty(), "{content}");
        assert!(parts.iter().all(|part| run.err.contains(part)), "{content}: {}", run.err);
    }
    // An input by table and by value, and a result in the place of its input.
    std::fs::write(&input, "time,phi\n0,0\n1,2\n").unwrap();
    let run = camdrive(&["run", run_up, "--input", text(&input), "--start", "phi=1"]);
    assert!(is_refused(run.code) && run.err.contains("the table of --input sets `phi`"), "{}", run.err);
    let run = camdrive(&["run", run_up, "--input", text(&input), "-o", text(&input)]);
    assert!(is_refused(run.code) && run.err.contains("would overwrite an input"), "{}", run.err);
    assert_eq!(std::fs::read_to_string(&result).unwrap(), "as it was");
    // The angle leaves its range in the middle: the rows before are kept.
    std::fs::write(&input, "time,phi,w\n0,0,0\n1e-2,0.9e15,1e6\n").unwrap();
    let run =
        camdrive(&["run", run_up, "--input", text(&input), "--stop", "1e9", "--step", "5e8", "-o", text(&result)]);
    assert!(is_refused(run.code) && run.err.contains("from t = "), "{}", run.err);
    assert_eq!(std::fs::read_to_string(&result).unwrap().lines().count(), 2);
}

#[cfg(unix)]
#[test]
fn the_steps_of_the_examples_take_a_program_by_its_name() {
    use std::os::unix::fs::PermissionsExt as _;
    let folder = folder("run_all");
    let camdrive = folder.join("camdrive");
    // It stands for the command line, and tells its own path and what it is to do.
    std::fs::write(&camdrive, "#!/bin/sh\necho \"$0 does $1\"\n").expect("the folder can be written to");
    std::fs::set_permissions(&camdrive, std::fs::Permissions::from_mode(0o755)).expect("it can be made a program");
    let path = format!("{}:{}", text(&folder), std::env::var("PATH").expect("a path"));
    for (example, steps) in [("loom", 7), ("sealing_machine", 6)] {
        let relative = camdrive.strip_prefix(root()).unwrap_or(&camdrive);
        for program in ["camdrive", text(relative)] {
            let mut bash = Command::new("bash");
            // Where the script called itself, it would not end.
            bash.args([
                "-c",
                "ulimit -s 1024; exec \"$0\" \"$1\"",
                &format!("examples/{example}/run_all"),
                text(&folder),
            ]);
            let run = bash
                .current_dir(root())
                .env("PATH", &path)
                .env("CAMDRIVE", program)
                .env("PYTHON", "true")
                .output()
                .expect("bash");
            let out = String::from_utf8_lossy(&run.stdout).into_owned();
            assert!(run.status.success(), "{example}: {}", String::from_utf8_lossy(&run.stderr));
            assert_eq!(out.matches(&format!("{} does ", text(&camdrive))).count(), steps, "{out}");
        }
    }
}

#[test]
fn a_missing_library_beside_the_executable_is_told_with_the_command_that_builds_it() {
    let folder = folder("alone");
    let alone = folder.join(format!("camdrive{}", std::env::consts::EXE_SUFFIX));
    std::fs::hard_link(env!("CARGO_BIN_EXE_camdrive"), &alone).expect("the executable can be linked");
    let output = Command::new(&alone)
        .current_dir(root())
        .args(["export", SCENE, "-o"])
        .arg(&folder)
        .output()
        .expect("camdrive starts");
    let err = String::from_utf8(output.stderr).expect("UTF-8");
    assert_eq!(output.status.code(), Some(1));
    assert!(err.contains("cargo build --release") && err.contains("--runtime"), "{err}");
}

/// What `export` takes for a library of the platform with this start of a file, of these sources.
fn library_of(start: &[u8], sources: &str) -> Vec<u8> {
    [start, b"\0fmi2DoStep\0", sources.as_bytes()].concat()
}

#[test]
fn export_packs_every_library_of_its_own_sources_that_is_at_hand() {
    let folder = folder("platforms");
    let camdrive = folder.join(format!("release/camdrive{}", std::env::consts::EXE_SUFFIX));
    let lay = |place: &str, content: &[u8]| {
        let file = folder.join(place);
        std::fs::create_dir_all(file.parent().unwrap()).unwrap();
        std::fs::write(file, content).unwrap();
    };
    let elf = |machine| [b"\x7fELF\x02\x01\x01".as_slice(), &[0; 9], &[3, 0, machine, 0]].concat();
    let universal = [&[0xca, 0xfe, 0xba, 0xbe, 0, 0, 0, 1, 1, 0, 0, 12][..], &[0; 16]].concat();
    std::fs::create_dir_all(folder.join("release")).unwrap();
    std::fs::hard_link(env!("CARGO_BIN_EXE_camdrive"), &camdrive).unwrap();
    // Beside the executable, and as in target/.
    lay("release/runtimes/linux64/camdrive.so", &library_of(&elf(62), BUILD));
    lay("runtimes/aarch64-linux/camdrive.so", &library_of(&elf(183), BUILD));
    lay("runtimes/darwin64/camdrive.dylib", &library_of(&universal, BUILD));
    lay("share/camdrive/runtimes/win64/camdrive.dll", &library_of(&elf(62), BUILD));
    let export = |platforms: &[&str]| {
        let output = Command::new(&camdrive)
            .current_dir(root())
            .args(["export", SCENE, "-o"])
            .arg(folder.join("t.fmu"))
            .args(platforms)
            .env("COLUMNS", "10000")
            .output()
            .expect("camdrive starts");
        let [out, err] = [output.stdout, output.stderr].map(|bytes| String::from_utf8(bytes).unwrap());
        let packed = out.lines().filter_map(|line| line.trim_start().strip_prefix("platform")?.split_once(':'));
        (packed.map(|(platform, _)| platform.trim().to_owned()).collect::<Vec<_>>().join(" "), err)
    };
    let (packed, err) = export(&[]);
    assert_eq!(packed, "linux64 aarch64-linux darwin64");
    assert!(err.contains("warning: left out:") && err.contains("win64/camdrive.dll is not a shared library"), "{err}");
    assert_eq!(export(&["--platforms", "darwin64,linux64"]), ("linux64 darwin64".to_owned(), String::new()));
    assert_eq!(export(&["--platforms", "aarch64-darwin"]), ("aarch64-darwin".to_owned(), String::new()));
    lay("runtimes/darwin64/camdrive.dylib", &library_of(&universal, "other sources"));
    for (platform, word) in [
        ("aarch64-darwin", "built from other sources than this executable"),
        ("win32", "no runtime library for win32"),
        ("amiga", "possible values: linux64, linux32, aarch64-linux, win64"),
    ] {
        let (packed, err) = export(&["--platforms", platform]);
        assert!(packed.is_empty() && err.contains(word), "{platform}: {packed} {err}");
    }
}

#[test]
fn completions_know_the_commands() {
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let run = camdrive(&["completions", shell]);
        assert_eq!((run.code, run.err.as_str()), (0, ""), "{shell}");
        assert!(run.out.contains("describe") && run.out.contains("runtime"), "{shell}: {}", run.out);
    }
}

/// With a temporary folder of its own, which is empty afterwards.
fn run_fmu(args: &[&str], temporary: &Path) -> Run {
    std::fs::create_dir_all(temporary).unwrap();
    let name = if cfg!(windows) { "TMP" } else { "TMPDIR" };
    let run = camdrive_with(&[&["run"], args].concat(), &[("COLUMNS", "10000"), (name, text(temporary))]);
    assert_eq!(std::fs::read_dir(temporary).unwrap().count(), 0, "{args:?}: the temporary folder holds something");
    run
}

#[test]
fn run_writes_of_an_fmu_what_it_writes_of_its_scene() {
    let folder = folder("run_fmu");
    let (exported, fmu, temporary) = (folder.join("x.fmu"), folder.join("t.FMU"), folder.join("with blanks and ä"));
    let input = folder.join("input.csv");
    std::fs::write(&input, "time [ms],phi,w [rpm]\n0,0,0\n33,0.1,100\n61,0.5,300\n").unwrap();
    let runs: [(&str, &[&str]); 5] = [
        (SCENE, &[]),
        // The step does not divide the time: 0, 0.3, 0.6, 0.9 and 1 s.
        (SCENE, &["--stop", "1 s", "--step", "0.3", "--output", "phi,der(psi,2)", "--start", "drive.w=20 rpm"]),
        (SCENE, &["--stop", "0.1", "--start", "start.mode=steady_state", "--start", "J=15 kg.cm^2"]),
        ("tests/fmpy/scenes/backlash_speed.toml", &["--output", "contact,impacts,tau_mean"]),
        ("examples/guide_bar/run_up.toml", &["--stop", "0.1", "--step", "4e-3", "--input", text(&input)]),
    ];
    for (scene, args) in runs {
        let done = camdrive(&["export", scene, "-o", text(&exported), "--runtime", &runtime()]);
        assert_eq!(done.code, 0, "{}", done.err);
        std::fs::rename(&exported, &fmu).unwrap();
        let own = camdrive(&[&["run", scene], args].concat());
        let run = run_fmu(&[&[text(&fmu)], args].concat(), &temporary);
        assert_eq!((run.code, own.code), (0, 0), "{scene} {args:?}: {}{}", run.err, own.err);
        assert!(run.out == own.out && run.out.lines().count() > 4, "{scene} {args:?}");
    }
    let wrong: [(&[&str], &[&str]); 10] = [
        (&["--start", "J_load"], &["NAME=VALUE"]),
        (&["--start", "mm=1"], &["no variable `mm`"]),
        (&["--start", "phi=1 mm"], &["`phi`", "a value in rad is expected"]),
        (&["--start", "solver.tolerance=-1"], &["`solver.tolerance`: -1", "expected"]),
        (&["--start", "start.mode=steady"], &["\"steady\" is not admissible", "1 (at_rest)"]),
        (&["--start", "start.mode=1.5"], &["\"1.5\" is not admissible", "1 (at_rest)"]),
        (&["--start", "y=1"], &["--start y=1", "`y` is computed"]),
        (&["--output", "taus"], &["no variable `taus`"]),
        (&["--step", "0"], &["--step"]),
        (&["--stop", "nan"], &["--stop"]),
    ];
    for (args, parts) in wrong {
        let run = run_fmu(&[&[text(&fmu)], args].concat(), &temporary);
        assert!(is_refused(run.code) && run.out.is_empty(), "{args:?}");
        assert!(
            run.err.starts_with("error: ") && parts.iter().all(|part| run.err.contains(part)),
            "{args:?}: {}",
            run.err
        );
    }
    let run = run_fmu(&[text(&fmu), "--stop", "1 ms", "--step", "0.5 ms", "--output", "y", "--json"], &temporary);
    let document: serde_json::Value = serde_json::from_str(&run.out).expect("one document");
    let column = &document["columns"][1];
    assert_eq!([&column["name"], &column["unit"], &document["name"]], ["y", "m", "guide_bar_run_up"]);
    assert_eq!((&document["model"], column["values"].as_array().unwrap().len()), (&serde_json::Value::Null, 3));
    let run = camdrive(&["help", "run"]);
    assert!(run.out.contains("camdrive run guide_bar.fmu"), "{}", run.out);
}

/// Writes an FMU with these files.
fn pack(path: &Path, files: &[(&str, &[u8])]) {
    let files: Vec<File> = files.iter().map(|(name, content)| File::new(*name, *content)).collect();
    std::fs::write(path, archive(&files, None).expect("an archive")).expect("the FMU is written");
}

/// The paths and the contents in an archive.
fn unpacked(path: &Path) -> Vec<(String, Vec<u8>)> {
    let mut archive = zip::ZipArchive::new(std::fs::File::open(path).expect("the FMU")).expect("an archive");
    let mut files = Vec::new();
    for i in 0..archive.len() {
        let (mut entry, mut content) = (archive.by_index(i).expect("an entry"), Vec::new());
        std::io::Read::read_to_end(&mut entry, &mut content).expect("its content");
        files.push((entry.name().to_owned(), content));
    }
    files
}

#[test]
fn run_and_verify_refuse_what_is_no_fmu_for_them() {
    let folder = folder("run_no_fmu");
    let (fmu, temporary) = (folder.join("t.fmu"), folder.join("temporary"));
    let exported = camdrive(&["export", SCENE, "-o", text(&fmu), "--runtime", &runtime()]);
    assert_eq!(exported.code, 0, "{}", exported.err);
    let (whole, own) = (std::fs::read(&fmu).unwrap(), unpacked(&fmu));
    let refused = |parts: &[&str]| {
        let parts = [&["error: ", text(&fmu)], parts].concat();
        for run in [run_fmu(&[text(&fmu)], &temporary), camdrive(&["verify", text(&fmu)])] {
            assert_eq!((run.code, run.out.as_str()), (1, ""), "{parts:?}");
            assert!(parts.iter().all(|part| run.err.contains(part)), "{parts:?}: {}", run.err);
            assert!(run.err.matches(text(&fmu)).count() == 1, "{}", run.err);
        }
    };
    // The files for which `keep` holds, and more.
    let with = |keep: &dyn Fn(&str) -> bool, more: &[(&str, &[u8])], parts: &[&str]| {
        let kept = own.iter().filter(|(path, _)| keep(path)).map(|(path, content)| (path.as_str(), &content[..]));
        pack(&fmu, &kept.chain(more.iter().copied()).collect::<Vec<_>>());
        refused(parts);
    };
    const DESCRIPTION: &str = "modelDescription.xml";
    let description = own.iter().find(|(path, _)| path == DESCRIPTION).unwrap();
    let description = std::str::from_utf8(&description.1).unwrap();
    for (old, new, parts) in [
        ("fmiVersion=\"2.0\"", "fmiVersion=\"3.0\"", &["FMI 3.0", "runs FMI 2.0 Co-Simulation", "hint"][..]),
        ("fmiVersion=\"2.0\"", "fmiVersion=\"1.0\"", &["FMI 1.0", "hint"]),
        ("<CoSimulation", "<ModelExchange", &["Model Exchange only", "hint"]),
        ("guid=\"", "guid=\"x", &["guid"]),
        ("<ModelVariables>", "<ModelVariables", &[DESCRIPTION, "line "]),
        ("modelIdentifier=\"", "modelIdentifier=\"../", &["is no name of a library"]),
        ("valueReference=\"1\"", "valueReference=\"-1\"", &["valueReference=\"-1\""]),
        ("<BaseUnit ", "<BaseUnit factor=\"0\" ", &["unit ", "make no unit"]),
    ] {
        assert!(description.contains(old), "{old}");
        let changed = description.replacen(old, new, 1);
        with(&|path| path != DESCRIPTION, &[(DESCRIPTION, changed.as_bytes())], parts);
    }
    let is_library = |path: &str| path.starts_with("binaries/");
    let library = own.iter().find(|(path, _)| is_library(path)).unwrap().0.as_str();
    let others: [(&str, &[u8]); 2] = [("binaries/win128/t.dll", b"x"), ("binaries/amiga/t.library", b"x")];
    with(&|path| !is_library(path), &others, &["has libraries for amiga, win128", "hint"]);
    with(&|path| !is_library(path), &[], &["has libraries for none"]);
    with(&|path| !is_library(path), &[(library, b"no library")], &["cannot be loaded", "hint"]);
    let remote = description.replace("needsExecutionTool=\"false\"", "needsExecutionTool=\"true\"");
    let remote = [(DESCRIPTION, remote.as_bytes()), (library, b"no library")];
    with(&|path| path != DESCRIPTION && !is_library(path), &remote, &["cannot be loaded", "needs camdrive 0"]);
    with(&|path| path != DESCRIPTION, &[], &["modelDescription.xml is not in it", "hint"]);
    with(&|path| !path.starts_with("resources/"), &[], &["drive.bin"]);
    with(&|_| true, &[("resources/../../../evil.txt", b"x")], &["leads out of its folder"]);
    assert!(!temporary.join("evil.txt").exists() && !folder.join("evil.txt").exists());
    for length in [0, 3, whole.len() / 2, whole.len() - 10] {
        std::fs::write(&fmu, &whole[..length]).unwrap();
        refused(&["this is no FMU", "hint"]);
    }
    std::fs::remove_file(&fmu).unwrap();
    refused(&["cannot be read"]);
}

/// A drive of another maker with these capabilities, whose inputs and torque have these units; values of the parameters that tell its
/// library so.
fn foreign_drive(folder: &Path, capabilities: &str, units: [&str; 4]) -> String {
    const UNITS: [(&str, &str, f64); 7] = [
        ("rad", "rad=\"1\"", 1.0),
        ("deg", "rad=\"1\" factor=\"0.017453292519943295\"", std::f64::consts::PI / 180.0),
        ("rad/s", "rad=\"1\" s=\"-1\"", 1.0),
        ("rpm", "rad=\"1\" s=\"-1\" factor=\"0.10471976\"", std::f64::consts::PI / 30.0),
        ("rad/s2", "rad=\"1\" s=\"-2\"", 1.0),
        ("N.m", "kg=\"1\" m=\"2\" s=\"-2\"", 1.0),
        ("N.mm", "kg=\"1\" m=\"2\" s=\"-2\" factor=\"0.001\"", 1e-3),
    ];
    let unit = |name: &str| UNITS.iter().find(|of| of.0 == name).expect("a unit");
    let defined: String =
        UNITS.iter().map(|(name, base, _)| format!("<Unit name=\"{name}\"><BaseUnit {base}/></Unit>\n")).collect();
    let variable = |i: usize, name: &str, causality: &str, real: String| {
        format!(
            "<ScalarVariable name=\"{name}\" valueReference=\"{i}\" causality=\"{causality}\">{real}</ScalarVariable>\n"
        )
    };
    let with_unit = |unit: &str, start: &str| format!("<Real unit=\"{unit}\"{start}/>");
    let inputs = ["phi", "w", "a"].into_iter().zip(units).enumerate();
    let mut variables: String =
        inputs.map(|(i, (name, unit))| variable(i, name, "input", with_unit(unit, " start=\"0\""))).collect();
    for (i, name) in ["m", "h", "by_phi", "by_w", "by_a", "by_tau"].into_iter().enumerate() {
        variables += &variable(i + 3, name, "parameter\" variability=\"fixed", "<Real start=\"1\"/>".to_owned());
    }
    variables += &variable(9, "tau", "output", with_unit(units[3], ""));
    let description = format!(
        "<fmiModelDescription fmiVersion=\"2.0\" modelName=\"drive\" guid=\"{{drive}}\">\n<CoSimulation modelIdentifier=\"drive\" \
         canHandleVariableCommunicationStepSize=\"true\"{capabilities}/>\n<UnitDefinitions>\n{defined}</UnitDefinitions>\n<ModelVariables>\n{variables}\
         </ModelVariables>\n<ModelStructure/>\n</fmiModelDescription>\n"
    );
    packed(folder, "drive", "drive.rs", description.as_bytes(), &[]);
    let scales = ["by_phi", "by_w", "by_a", "by_tau"].into_iter().zip(units);
    let scales: Vec<String> = scales.map(|(name, of)| format!("{name} = {:?}", unit(of).2)).collect();
    format!("h = 0.03, {}", scales.join(", "))
}

/// The speed (rad/s) at 0.2 s of the machine of the test below with such a drive of mass m, of all as one equation, by Runge and Kutta.
fn with_rigid_drive(m: f64) -> f64 {
    let (inertia, ratio, offset, h) = (1.6, -2.0, 40f64.to_radians(), 0.03);
    let rates = |[phi, w]: [f64; 2]| {
        let slip = 1.0 - w / (10.0 * std::f64::consts::PI);
        let motor = 2.0 * 90.0 * slip * 0.18 / (slip * slip + 0.18 * 0.18);
        let (sin, cos) = (ratio * phi + offset).sin_cos();
        let (first, second) = (h * sin, h * cos);
        [w, (motor - m * ratio.powi(3) * first * second * w * w) / (inertia + m * (ratio * first).powi(2))]
    };
    let (steps, mut state) = (20_000, [0.0, 20.0 * std::f64::consts::PI / 3.0]);
    let step = 0.2 / f64::from(steps);
    let along = |[phi, w]: [f64; 2], [a, b]: [f64; 2], by: f64| [phi + by * a, w + by * b];
    for _ in 0..steps {
        let k1 = rates(state);
        let k2 = rates(along(state, k1, step / 2.0));
        let k3 = rates(along(state, k2, step / 2.0));
        let k4 = rates(along(state, k3, step));
        for i in 0..2 {
            state[i] += step / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]);
        }
    }
    state[1]
}

#[test]
fn a_rigid_drive_of_another_maker_is_coupled_with_the_order_2_in_any_units() {
    let folder = folder("foreign_drive");
    let file = folder.join("system.toml");
    let machine = "name = \"machine\"\nmodel = \"RigidMachine\"\nmachine.J0 = 1.6\n\
                   motor = { kind = \"kloss\", M_k = 90, s_k = 0.18, w_s = \"300 rpm\" }\n";
    std::fs::write(folder.join("machine.toml"), machine).expect("a scene");
    let run = |scales: &str, m: f64, step: f64, is_told: bool| {
        let system = format!(
            "name = \"foreign\"\nstop = 0.2\nstep = {step:?}\n[part.machine]\nscene = \"machine.toml\"\n\
             start = {{ w_start = \"200 rpm\" }}\n[part.drive]\nfmu = \"drive.fmu\"\nshaft = \"machine\"\nratio = -2\n\
             offset = \"40 deg\"\nstart = {{ m = {m:?}, {scales} }}\n"
        );
        std::fs::write(&file, system).expect("a system");
        let run = camdrive(&["run", text(&file), "--output", "machine.w"]);
        assert!(run.code == 0 && run.err.contains("takes no input derivatives") == is_told, "{}", run.err);
        // In any units the work on both sides is compared.
        assert!(run.err.contains("note: machine and drive: "), "{}", run.err);
        table(&run.out).1.pop().expect("rows")[1]
    };
    // κ = 0.22 and 0.9.
    for m in [100.0, 400.0] {
        let exact = with_rigid_drive(m);
        let error = |capabilities: &str, units: [&str; 4], step: f64| {
            let scales = foreign_drive(&folder, capabilities, units);
            (run(&scales, m, step, capabilities.is_empty()) - exact).abs()
        };
        // One that takes derivatives of its inputs refuses those of the second order, and has none of its outputs.
        for capabilities in ["", " canInterpolateInputs=\"true\" maxOutputDerivativeOrder=\"1\""] {
            let errors = [4e-4, 2e-4, 1e-4].map(|step| error(capabilities, ["rad", "rad/s", "rad/s2", "N.m"], step));
            for pair in errors.windows(2) {
                assert!((pair[0] / pair[1]).log2() > 1.8, "{m}{capabilities}: {errors:?}");
            }
            assert!(errors[2] < 1e-3, "{m}{capabilities}: {errors:?}");
            for units in [["deg", "rpm", "rad/s2", "N.mm"], ["rad", "rpm", "rad/s2", "N.m"]] {
                let error = error(capabilities, units, 1e-4);
                assert!((error - errors[2]).abs() < 0.01 * errors[2] + 1e-6, "{units:?}: {error} {errors:?}");
            }
        }
    }
}

/// What the FMU of `tests/foreign/cart.rs` says of itself, in Latin-1.
const CART: &str = r#"<?xml version="1.0" encoding="ISO-8859-1"?>
<fmiModelDescription fmiVersion="2.0" modelName="Cart with blanks" guid="{cart}">
<CoSimulation modelIdentifier="cart" canHandleVariableCommunicationStepSize="VARIABLE"/>
<UnitDefinitions>
  <Unit name="mm"><BaseUnit m="1" factor="0.001"/></Unit>
  <Unit name="mm/s"><BaseUnit m="1" s="-1" factor="0.001"/><DisplayUnit name="furlong/h" factor="0.0179"/></Unit>
  <Unit name="degC"><BaseUnit K="1" offset="273.15"/><DisplayUnit name="degF" factor="1.8" offset="32"/></Unit>
</UnitDefinitions>
<TypeDefinitions>
  <SimpleType name="Gear"><Enumeration><Item name="none" value="0"/><Item name="high" value="7"/></Enumeration></SimpleType>
  <SimpleType name="Speed"><Real unit="mm/s" min="-100" max="100"/></SimpleType>
</TypeDefinitions>
<ModelVariables>
  <ScalarVariable name="x" valueReference="0" causality="output" description="Länge"><Real unit="mm"/></ScalarVariable>
  <ScalarVariable name="u" valueReference="1" causality="input"><Real declaredType="Speed" start="0"/></ScalarVariable>
  <ScalarVariable name="T" valueReference="2" causality="parameter"><Real unit="degC" start="20"/></ScalarVariable>
  <ScalarVariable name="gear" valueReference="0" causality="input" variability="discrete">
    <Enumeration declaredType="Gear" start="0"/></ScalarVariable>
  <ScalarVariable name="open" valueReference="1" causality="input" variability="discrete">
    <Boolean start="false"/></ScalarVariable>
  <ScalarVariable name="text" valueReference="0" causality="parameter"><String start="a"/></ScalarVariable>
</ModelVariables>
<ModelStructure/>
</fmiModelDescription>
"#;

/// Compiles the library of another maker, and packs it with this word for whether its steps may differ.
fn cart(folder: &Path, variable_steps: &str) -> PathBuf {
    let description: Vec<u8> = CART.replace("VARIABLE", variable_steps).chars().map(|c| c as u8).collect();
    packed(folder, "cart", "cart.rs", &description, &[("resources/start.txt", b"1.5")])
}

/// Compiles a library of `tests/foreign`, and packs it with its model description and more files as NAME.fmu.
fn packed(folder: &Path, name: &str, source: &str, description: &[u8], more: &[(&str, &[u8])]) -> PathBuf {
    let library = folder.join(format!("{name}{}", std::env::consts::DLL_SUFFIX));
    if !library.exists() {
        let done = Command::new(Path::new(env!("CARGO")).with_file_name("rustc"))
            .args(["--edition", "2024", "-o", text(&library)])
            .arg(root().join("tests/foreign").join(source))
            .output()
            .expect("the compiler of this test starts");
        assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    }
    let fmu = folder.join(format!("{name}.fmu"));
    let runtime = runtime();
    let (platform, _) = runtime.split_once('=').unwrap();
    let path = format!("binaries/{platform}/{name}{}", std::env::consts::DLL_SUFFIX);
    let library = std::fs::read(&library).unwrap();
    let files = [("modelDescription.xml", description), (path.as_str(), library.as_slice())];
    pack(&fmu, &[&files, more].concat());
    fmu
}

/// The FMU of `tests/foreign/misbehaving.rs` with this guid and default experiment.
fn misbehaving(folder: &Path, guid: &str, experiment: &str) -> PathBuf {
    let description = format!(
        r#"<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="bad" guid="{guid}">
<CoSimulation modelIdentifier="bad" canHandleVariableCommunicationStepSize="true" maxOutputDerivativeOrder="2"/>
<DefaultExperiment startTime="0" {experiment}/>
<ModelVariables>
  <ScalarVariable name="y" valueReference="0" causality="output"><Real/></ScalarVariable>
  <ScalarVariable name="fault" valueReference="0" causality="parameter" variability="fixed">
    <Integer start="0"/></ScalarVariable>
</ModelVariables>
<ModelStructure><Outputs><Unknown index="1"/></Outputs></ModelStructure>
</fmiModelDescription>
"#
    );
    packed(folder, "bad", "misbehaving.rs", description.as_bytes(), &[])
}

/// What a foreign library does to its process, and what is said of it. The last word of each is what `run` returns.
#[test]
fn a_foreign_library_that_fails_fails_its_run() {
    let folder = folder("misbehaving");
    let (fmu, temporary) = (misbehaving(&folder, "g", r#"stopTime="1" stepSize="0.25""#), folder.join("a folder"));
    let cases = [
        (0, "", 5, 0),
        (1, "from t = 0.25 s to 0.5 s: fmi2DoStep: the library of the FMU ends its process (exit code 0)", 2, 1),
        (2, "ends its process (exit code 3)", 2, 1),
        (3, "fmi2DoStep: the library of the FMU crashes", 2, 1),
        (4, "fmi2DoStep: the library of the FMU crashes", 2, 1),
        (5, "\"y\": 7, 7, 7\n", 5, 0),
        (6, "`y` is NaN at t = 0.5 s", 5, 1),
        (7, "does not return within 1 s", 2, 1),
        (8, "warning: from t = 0.25 s to 0.5 s: the FMU ends the simulation; the result ends at t = 0.25 s", 2, 0),
        (9, "fmi2Terminate: the library of the FMU crashes", 5, 1),
        (10, "setting a variable: the library of the FMU crashes", 0, 1),
        (11, "fmi2EnterInitializationMode: the library of the FMU crashes", 0, 1),
        (12, "fmi2ExitInitializationMode: the library of the FMU crashes", 0, 1),
        (13, "fmi2FreeInstance: the library of the FMU crashes", 5, 1),
        (14, "fmi2FreeInstance: the library of the FMU does not return within 1 s", 5, 1),
        (16, "from t = 0.25 s to 0.5 s: fmi2DoStep: the FMU returns fmi2Error", 2, 1),
    ];
    let file = folder.join("kept.csv");
    for (fault, said, rows, code) in cases {
        let start = format!("fault={fault}");
        let run = run_fmu(&[text(&fmu), "--start", &start, "--timeout", "1 s"], &temporary);
        assert!(run.code == code && run.err.contains(said), "{fault}: {} {}", run.code, run.err);
        // Where nothing was computed there are no headings.
        assert_eq!(run.out.lines().skip(1).count(), rows, "{fault}: {}", run.out);
        let json = run_fmu(&[text(&fmu), "--start", &start, "--timeout", "1 s", "--json"], &temporary);
        assert!(json.code == code && json.err.contains(said), "{fault}: {}", json.err);
        // A run that fails keeps the rows before.
        let kept = run_fmu(&[text(&fmu), "--start", &start, "--timeout", "1 s", "-o", text(&file)], &temporary);
        assert_eq!(kept.code, code, "{fault}: {}", kept.err);
        assert_eq!(file.is_file(), rows > 0, "{fault}");
        if rows > 0 {
            assert_eq!(std::fs::read_to_string(&file).unwrap(), run.out, "{fault}");
            std::fs::remove_file(&file).unwrap();
            let document: serde_json::Value = serde_json::from_str(&json.out).expect("one document");
            assert_eq!(document["columns"][1]["values"].as_array().unwrap().len(), rows);
            assert_eq!(document["ended"].is_string(), rows < 5, "{fault}");
        }
    }
    // What a library starts ends with its process.
    #[cfg(target_os = "linux")]
    {
        let run = run_fmu(&[text(&fmu), "--start", "fault=15"], &temporary);
        assert_eq!(run.code, 0, "{}", run.err);
        let is_left = |process: &std::fs::DirEntry| {
            let line = std::fs::read_to_string(process.path().join("cmdline"));
            line.is_ok_and(|line| line.starts_with("sleep\0") && line.contains("12345.678"))
        };
        assert!(!std::fs::read_dir("/proc").unwrap().flatten().any(|process| is_left(&process)));
    }
}

/// Of a study the row fails, also before its first step.
#[test]
fn a_foreign_library_that_fails_fails_its_row() {
    let folder = folder("misbehaving_rows");
    let fmu = misbehaving(&folder, "g", r#"stopTime="1" stepSize="0.25""#);
    // Derivatives that are NaN are none.
    let lines = "time = \"1 s\"\nmeasures = [\"last y\", \"mean y\"]\nvary = [{ name = \"fault\", values = [0, 1, 3, 4, \
                 5, 6, 7, 9, 10, 11, 12, 13, 14] }]\n";
    let (file, store) = study_over(&folder, &fmu, "store", lines);
    let run = camdrive(&["study", text(&file), "-o", text(&store), "--timeout", "1", "--threads", "2", "--json"]);
    let said: serde_json::Value = serde_json::from_str(&run.out).unwrap_or_else(|_| panic!("{}", run.err));
    assert_eq!(["ok", "refused", "failed"].map(|key| said[key].as_u64()), [2, 0, 11].map(Some));
    let of = |measure: usize| said["measures"][measure]["largest"].as_f64().unwrap();
    assert!((of(0) - 1.0).abs() < 1e-12 && (of(1) - 0.5).abs() < 1e-12);
    // An FMU that ends the simulation is measured up to there.
    let ending = "time = 1\nmeasures = [\"last y\", \"max y\"]\nvary = [{ name = \"fault\", values = [8] }]\n";
    let (file, store) = study_over(&folder, &fmu, "ended", ending);
    let run = camdrive(&["study", text(&file), "-o", text(&store)]);
    let why =
        "First ended early: run 0: from t = 0.25 s to 0.5 s: the FMU ends the simulation; measured up to t = 0.25 s.";
    let said = run.out.split_whitespace().collect::<Vec<_>>().join(" ");
    for part in ["1 run: 1 ok, 0 refused, 0 failed", why, "last y: 0.25", "max y: 0.25"] {
        assert!(said.contains(part), "{part}: {} {}", run.out, run.err);
    }
    // In a system the part is named.
    let system = folder.join("system.toml");
    let part = "[part.bad]\nfmu = \"bad.fmu\"\nstart = { fault = 3 }\n";
    std::fs::write(&system, format!("name = \"s\"\nstop = \"1 s\"\nstep = \"0.25 s\"\n{part}")).unwrap();
    let run = camdrive(&["run", text(&system)]);
    assert!(run.code == 1 && run.err.contains("part bad: fmi2DoStep: the library of the FMU crashes"), "{}", run.err);
    let fmu = misbehaving(&folder, "dead", r#"stopTime="1" stepSize="0.25""#);
    let (file, store) = study_over(&folder, &fmu, "dead", lines);
    let run = camdrive(&["study", text(&file), "-o", text(&store), "--threads", "2"]);
    for said in
        ["13 runs: 0 ok, 0 refused, 13 failed", "First failed: run 0: fmi2Instantiate: the library of the FMU crashes"]
    {
        assert!(run.out.contains(said), "{said}: {} {}", run.out, run.err);
    }
    for wrong in ["0", "-1 s", "1 m", "nan"] {
        let run = camdrive(&["run", text(&fmu), "--timeout", wrong]);
        assert!(run.code != 0 && run.err.contains("--timeout"), "{wrong}: {}", run.err);
    }
}

#[test]
fn a_default_experiment_that_is_none_is_refused() {
    let folder = folder("default_experiment");
    for step in ["NaN", "0", "-0.1", "INF"] {
        let fmu = misbehaving(&folder, "g", &format!(r#"stopTime="1" stepSize="{step}""#));
        let run = camdrive(&["run", text(&fmu)]);
        assert!(run.code == 1 && run.err.contains("--step, by default:"), "{step}: {}", run.err);
        assert_eq!(camdrive(&["run", text(&fmu), "--step", "0.5"]).code, 0, "{step}");
    }
    let fmu = misbehaving(&folder, "g", r#"stopTime="NaN" stepSize="0.1""#);
    let run = camdrive(&["run", text(&fmu)]);
    assert!(run.code == 1 && run.err.contains("--stop, by default:"), "{}", run.err);
}

#[test]
fn run_drives_an_fmu_of_another_maker() {
    let folder = folder("run_foreign");
    let (fmu, temporary) = (cart(&folder, "true"), folder.join("a folder"));
    let with = |more: &[&str]| {
        let args = [text(&fmu), "--stop", "1 s", "--step", "0.5", "--output", "x,u,T,gear,open"];
        run_fmu(&[&args, more].concat(), &temporary)
    };
    let assert_rows = |run: &Run, expected: &[[f64; 6]]| {
        let (_, rows) = table(&run.out);
        let near = |(row, expected): (&Vec<f64>, &[f64; 6])| {
            row.iter().zip(expected).all(|(value, expected)| (value - expected).abs() < 1e-12)
        };
        assert!(rows.len() == expected.len() && rows.iter().zip(expected).all(near), "{}{}", run.out, run.err);
    };
    // x = 1.5 mm + u t; values and units are those of the FMU.
    let run = with(&["--start", "u=2 mm/s", "--start", "gear=high", "--start", "open=true", "--start", "T=68 degF"]);
    assert_eq!(run.err, "warning: 100 % of the oil is cold\n");
    assert_eq!(table(&run.out).0, ["time", "x [mm]", "u [mm/s]", "T [degC]", "gear", "open"]);
    let rows = [0.0, 0.5, 1.0].map(|t| [t, 1.5 + 2.0 * t, 2.0, 20.0, 7.0, 1.0]);
    assert_rows(&run, &rows);
    for word in ["0.0179 furlong/h", "0.001 m/s", "6 cm/min", "1 mm/s"] {
        let run = with(&["--start", &format!("u={word}")]);
        assert_rows(&run, &[0.0, 0.5, 1.0].map(|t| [t, 1.5 + t, 1.0, 20.0, 0.0, 0.0]));
    }
    let run = with(&["--json"]);
    let document: serde_json::Value = serde_json::from_str(&run.out).expect("one document");
    let columns = document["columns"].as_array().unwrap().iter();
    let units: Vec<&str> = columns.map(|column| column["unit"].as_str().unwrap()).collect();
    assert_eq!(units, ["s", "mm", "mm/s", "degC", "", ""]);
    assert_eq!(document["columns"][1]["description"], "Länge");
    // u = 2 t mm/s is held during a step: x = 1.5 mm + 0 + 0.5 · 1 mm; what is discrete is held from row to row.
    let input = folder.join("input.csv");
    for headings in ["time,u [m/s],gear,open", "time [s],u [mm/s],gear,open"] {
        let u = if headings.contains("mm") { 2.0 } else { 0.002 };
        std::fs::write(&input, format!("{headings}\n0,0,0,0\n1,{u},7,1\n2,{u},0,0\n")).unwrap();
        let run = with(&["--input", text(&input)]);
        let rows = [[0.0, 1.5, 0.0, 20.0, 0.0, 0.0], [0.5, 1.5, 1.0, 20.0, 0.0, 0.0], [1.0, 2.0, 2.0, 20.0, 7.0, 1.0]];
        assert_rows(&run, &rows);
    }
    let cases: [(&str, &[&str]); 8] = [
        ("u=2", &["`u`: 2 may be in SI or in mm/s", "\"2 mm/s\""]),
        ("u=2 kg", &["`u`", "a value in m.s-1 is expected"]),
        ("u=200 mm/s", &["`u`: 0.2", "expected -0.1 to 0.1"]),
        ("gear=low", &["\"low\" is not admissible", "0 (none), 7 (high)"]),
        ("open=2", &["`open`: 2 is not admissible"]),
        ("T=20 K/W", &["`T`"]),
        ("text=b", &["no variable `text`"]),
        (
            "u=7 mm/s",
            &["from t = 0.5 s to 1 s: the FMU ends the simulation at t = 0.5 s: the cart is at its end", "not known"],
        ),
    ];
    for (start, parts) in cases {
        let run = with(&["--start", start]);
        // An FMU that ends the simulation gives its rows so far.
        assert_eq!(is_refused(run.code), start != "u=7 mm/s", "{start}");
        assert!(parts.iter().all(|part| run.err.contains(part)), "{start}: {}", run.err);
    }
    // It is the same in every unit.
    assert_eq!(with(&["--start", "u=0"]).code, 0);
    let run = run_fmu(&[text(&fmu)], &temporary);
    assert!(run.err.contains("--stop: the FMU has no stop time"), "{}", run.err);
    cart(&folder, "false");
    let run = run_fmu(&[text(&fmu), "--stop", "1", "--step", "0.3"], &temporary);
    assert!(is_refused(run.code) && run.err.contains("steps of one length only"), "{}", run.err);
    assert_eq!(run_fmu(&[text(&fmu), "--stop", "1", "--step", "0.1"], &temporary).code, 0);
}

#[test]
fn tradeoff_writes_tables_and_diagrams() {
    let folder = folder("tradeoff");
    let run = camdrive(&["tradeoff", SCENE, "--quick", "--turns", "1", "-o", text(&folder.join("study"))]);
    assert_eq!((run.code, run.err.as_str()), (0, ""), "no progress bar where nobody looks");
    for part in ["Settings", "Features that could be left out", "Advice", "For errors up to ", "ns per ms", "Certainty"]
    {
        assert!(run.out.contains(part), "{part} is missing in\n{}", run.out);
    }
    for (ending, part) in [
        ("settings.csv", "cost_ns_per_ms"),
        ("features.csv", "cost_ratio_percent"),
        ("json", "\"advice\""),
        ("html", "<h2>Speed against accuracy"),
        ("work_precision.svg", "CPU time per machine time [ns/ms]"),
        ("communication_step.svg", "Communication step [ms]"),
    ] {
        let path = folder.join("study").join(format!("transfer_manipulator.{ending}"));
        let content = std::fs::read_to_string(&path).expect("the file is written");
        assert!(content.contains(part), "{part} is missing in {}", path.display());
    }
    assert_diagrams_read_well(&folder.join("study"));
}

#[test]
fn tradeoff_refuses_what_gives_no_study() {
    let wrong = camdrive(&["tradeoff", SCENE, "--turns", "0"]);
    assert_eq!((wrong.code, wrong.out.as_str()), (2, ""));
    assert!(wrong.err.contains("--turns"), "{}", wrong.err);
    let unit = camdrive(&["tradeoff", "examples/guide_bar/run_up.toml", "--speed", "3 m"]);
    assert!(is_refused(unit.code));
    assert!(unit.err.contains("--speed") && unit.err.contains("hint"), "{}", unit.err);
    let scene = camdrive(&["tradeoff", WRONG]);
    assert!(is_refused(scene.code) && scene.err.contains(WRONG), "{}", scene.err);
    let file = folder("tradeoff_file").join("here");
    std::fs::write(&file, "").expect("the folder can be written to");
    let run = camdrive(&["tradeoff", SCENE, "--quick", "-o", text(&file)]);
    assert!(is_refused(run.code) && run.err.contains("folder"), "{}", run.err);
}

#[test]
fn compensate_writes_a_scene_that_is_right() {
    let folder = folder("compensate");
    let (scene, report) = (folder.join("loom.toml"), folder.join("report"));
    let loom = "examples/rapier_loom/scene.toml";
    let run = camdrive(&["compensate", loom, "-o", text(&scene), "--report", text(&report), "--explain"]);
    assert_eq!(run.code, 0, "{}", run.err);
    for figure in ["120.091672", "round 3", "finished", "0.317728", "13.4", "at 25 % of the speed"] {
        assert!(run.out.contains(figure), "{figure}: {}", run.out);
    }
    let written = std::fs::read_to_string(&scene).unwrap();
    // The scene is kept as its author wrote it, apart from the cams.
    assert!(written.contains("# gripper") && written.contains("\"500 rpm\"") && written.contains("rapier_loom_hs"));
    assert_eq!(camdrive(&["check", text(&scene)]).code, 0);
    for ending in [
        "compensation.csv",
        "json",
        "courses.csv",
        "spectra.csv",
        "speed.svg",
        "tool1.svg",
        "tool1.spectrum.svg",
        "tool2.svg",
        "tool2.spectrum.svg",
    ] {
        assert!(report.join(format!("rapier_loom.{ending}")).is_file(), "{ending}");
    }
    assert_diagrams_read_well(&report);
    let csv = std::fs::read_to_string(report.join("rapier_loom.compensation.csv")).unwrap();
    assert!(csv.lines().count() == 11 && csv.starts_with("machine,speed_part,period_ms,speed_low_rpm"));
    // What a task asks of tools that were made for another one.
    let run = camdrive(&["compensate", loom, "-o", text(&scene), "--task", "examples/loom/task.toml"]);
    for part in ["of the 9 restrictions", "The prescribed motions themselves miss `gripper: point[1].U`", "reserve as"]
    {
        assert!(run.code == 0 && run.out.contains(part), "{part}: {}{}", run.out, run.err);
    }
    // A prescribed period moves the synchronous speed.
    let run = camdrive(&["compensate", loom, "-o", text(&scene), "--period", "120 ms", "--explain"]);
    assert!(run.code == 0 && run.out.contains("motor: 500.38 rpm"), "{}{}", run.out, run.err);
    assert!(std::fs::read_to_string(&scene).unwrap().contains("w_s = 52.39987814901"));
    // A load is no part of a scene.
    let run = camdrive(&["compensate", loom, "-o", text(&scene), "--load", "40 N.m"]);
    assert!(run.code == 0 && run.out.contains("input `tau`"), "{}{}", run.out, run.err);
    // Without motor the start gives the period.
    let free = folder.join("free.toml");
    let text_of_loom = std::fs::read_to_string(root().join(loom)).unwrap();
    let (head, _) = text_of_loom.split_once("[motor]").unwrap();
    std::fs::write(&free, format!("{head}[motor]\nkind = \"none\"\n")).unwrap();
    let run = camdrive(&["compensate", text(&free), "-o", text(&scene), "--period", "120 ms"]);
    assert!(run.code == 0 && run.out.contains("start.w_start = "), "{}{}", run.out, run.err);
    let written = std::fs::read_to_string(&scene).unwrap();
    let w = written.split("w_start = ").nth(1).and_then(|rest| rest.split([' ', '}', '\n']).next()).unwrap();
    let w: f64 = w.parse().unwrap();
    // Between the least and the largest speed, and not their mean.
    assert!((49.0..57.0).contains(&w) && (w - 52.36).abs() > 0.1, "{w}");
}

/// Whether a printed row says that the cam of this number has a table.
fn has_table(printed: &str, cam: &str) -> bool {
    printed.lines().any(|line| line.split_whitespace().next() == Some(cam) && line.contains("table of"))
}

#[test]
fn compensate_writes_tables_where_series_are_too_long() {
    let folder = folder("compensate_tables");
    let (light, target) = (folder.join("light.toml"), folder.join("out/light_hs.toml"));
    let loom = std::fs::read_to_string(root().join("examples/rapier_loom/scene.toml")).unwrap();
    let (head, _) = loom.split_once("[motor]").unwrap();
    let head = head.replace("2.8 kg.m2", "0.35 kg.m2");
    std::fs::write(&light, format!("{head}[motor]\nkind = \"none\"\n")).unwrap();
    let args = ["compensate", text(&light), "-o", text(&target), "--period", "120 ms"];
    let run = camdrive(&args);
    assert!(run.code == 0 && has_table(&run.out, "1"), "{}{}", run.out, run.err);
    assert!(folder.join("out/light_hs.follower2.csv").is_file());
    assert_eq!(camdrive(&["check", text(&target)]).code, 0);
    let run = camdrive(&[&args[..], &["--laws", "series"]].concat());
    assert!(run.code == 1 && run.err.contains("--laws table"), "{}", run.err);
}

#[test]
fn compensate_writes_tables_with_derivatives_of_cycles() {
    let folder = folder("compensate_cycles");
    let target = folder.join("hs.toml");
    let args = ["compensate", "examples/rapier_loom/cycles.toml", "-o", text(&target)];
    let run = camdrive(&[&args[..], &["--report", text(&folder), "--tolerance", "1e-5"]].concat());
    assert!(run.code == 0 && has_table(&run.out, "2"), "{}{}", run.out, run.err);
    assert_diagrams_read_well(&folder);
    let table = std::fs::read_to_string(folder.join("hs.follower1.csv")).unwrap();
    assert!(table.starts_with("phi_rad,lift_m,dU,ddU_before,ddU_behind\n"), "{table}");
    assert!(std::fs::read_to_string(&target).unwrap().contains("interpolation = \"derivatives\""));
    // The scene has the law that was found: the machine with it has the period that was told.
    assert_eq!(camdrive(&["check", text(&target)]).code, 0);
    let [found, steady] = [
        std::fs::read_to_string(folder.join("loom_of_cycles.json")).unwrap(),
        camdrive(&["steady", text(&target), "--json"]).out,
    ]
    .map(|json| serde_json::from_str::<serde_json::Value>(&json).unwrap());
    let [told, own] = [&found["finished"], &steady["motions"][0]].map(|motion| motion["period"].as_f64().unwrap());
    assert!((told / own - 1.0).abs() < 1e-9, "{told} {own}");
    let run = camdrive(&[&args[..], &["--laws", "series"]].concat());
    assert!(run.code == 1 && run.err.contains("leave corners") && run.err.contains("--laws table"), "{}", run.err);
    // Without its derivatives the file is no such table.
    let short: Vec<String> = table.lines().map(|line| line.split(',').take(4).collect::<Vec<_>>().join(",")).collect();
    std::fs::write(folder.join("hs.follower1.csv"), short.join("\n")).unwrap();
    let run = camdrive(&["check", text(&target)]);
    assert!(run.code == 1 && run.err.contains("column 5 is missing"), "{}{}", run.out, run.err);
}

#[test]
fn the_accuracy_of_a_levers_law_is_told_once() {
    let scene = "examples/sealing_machine/scene.toml";
    assert!(camdrive(&["check", scene]).err.contains("the lever's law has"));
    assert_eq!(camdrive(&["steady", scene]).err, "");
}

#[test]
fn cam_says_which_key_keeps_the_second_arm_off() {
    let folder = folder("cam_second_arm");
    let scene = folder.join("scene.toml");
    let loom = std::fs::read_to_string(root().join("examples/rapier_loom/scene.toml")).unwrap();
    std::fs::write(&scene, loom.replace("second_arm_angle = \"90 deg\"", "second_arm_angle = \"30 deg\"")).unwrap();
    let run = camdrive(&["cam", text(&scene), "-o", text(&folder)]);
    for part in [
        "follower1 P",
        "the second arm turns through the line",
        "change `second_arm_angle` from 30.000°",
        "above 59.297°",
        "below 202.344°",
    ] {
        assert!(run.code == 1 && run.err.contains(part), "{part}: {}", run.err);
    }
}

/// A machine with loads on its tools and on its shaft, and a constant motor behind a gear.
const LOADED: &str = "tests/fmpy/scenes/machine_loads.toml";

#[test]
fn compensate_knows_loads_and_every_motor() {
    let folder = folder("compensate_loads");
    let scene = folder.join("loads.toml");
    let run = camdrive(&["compensate", LOADED, "-o", text(&scene), "--report", text(&folder)]);
    assert_eq!(run.code, 0, "{}", run.err);
    let report = std::fs::read_to_string(folder.join("machine_loads.json")).unwrap();
    let report: serde_json::Value = serde_json::from_str(&report).unwrap();
    let run = camdrive(&["steady", text(&scene), "--json"]);
    let steady: serde_json::Value = serde_json::from_str(&run.out).unwrap_or_else(|_| panic!("{}{}", run.out, run.err));
    let [period, own] = [&report["period"], &steady["motions"][0]["period"]].map(|period| period.as_f64().unwrap());
    assert!((period / own - 1.0).abs() < 1e-9, "{period} {own}");
    for (cam, round) in report["cams"].as_array().unwrap().iter().zip(report["rounds"][0]["tools"].as_array().unwrap())
    {
        assert!(cam["truncation"].as_f64().unwrap() <= 1e-6 && round["deviation"].as_f64().unwrap() > 0.01, "{report}");
    }
    // The laws are of the scene that has the loads still.
    let written = std::fs::read_to_string(&scene).unwrap();
    assert!(written.contains("process") && written.contains("spring") && written.contains("loads.follower1.csv"));
}

#[test]
fn compensate_says_what_it_cannot_do() {
    let folder = folder("compensate_refuses");
    let loom = "examples/rapier_loom/scene.toml";
    let text_of_loom = std::fs::read_to_string(root().join(loom)).unwrap();
    let light = folder.join("light.toml");
    std::fs::write(&light, text_of_loom.replace("2.8 kg.m2", "0.2 kg.m2").replace("steady_state", "given")).unwrap();
    let free = folder.join("free.toml");
    let (head, _) = text_of_loom.split_once("[motor]").unwrap();
    std::fs::write(&free, format!("{head}[motor]\nkind = \"none\"\n")).unwrap();
    let trains = [
        "kind = \"servo\"\nK_p = 9\nM_max = 22\nw_ref = 50\nK_v = 3",
        "kind = \"servo\"\nK_p = 9\nM_max = 22\nw_ref = { frequency = \"2 Hz\", a = [50, 2] }",
        "kind = \"constant\"\ntorque = 5\nJ = 0.1\ncoupling = { c = 1e5 }",
        "kind = \"none\"",
    ];
    let trains = trains.map(|motor| {
        let path = folder.join(format!("train{}.toml", motor.len()));
        let head = head.replace("RigidMachine", "DriveTrain").replace("steady_state", "at_rest");
        std::fs::write(&path, format!("{head}[motor]\n{motor}\n")).unwrap();
        text(&path).to_owned()
    });
    for (args, parts) in [
        (&[SCENE][..], &["RigidMachine", "ElasticCamDrive"][..]),
        (&["modelDescription/DriveTrain.motor.toml"], &["elasticities", "hint: leave out [follower.elasticity]"]),
        (&["modelDescription/DriveTrain.input.toml"], &["the shaft is prescribed", "hint: give [machine]"]),
        (&[&trains[0]], &["position loop", "hint: leave out K_v"]),
        (&[&trains[1]], &["changes with time", "hint: set w_ref to a value"]),
        (&[&trains[2]], &["coupling", "hint: leave it out"]),
        (&[&trains[3]], &["the loads stop the machine", "hint: add a [motor]"]),
        (&[LOADED, "--period", "120 ms"], &["--period", "hint: change its torque"]),
        (&[text(&light)], &["0.2 kg.m2", "0.317728", "with this motor about 0.325"]),
        (&[loom, "--load", "300 N.m"], &["300 N.m", "breakdown torque 220"]),
        (&[loom, "--keep", "3"], &["no follower 3", "has 2"]),
        (&[loom, "--period", "0"], &["--period", "positive"]),
        (&[loom, "--period", "12 kg"], &["--period", "hint"]),
        (
            &[loom, "--period", "1 ns"],
            &[
                "--period",
                "rpm, with a motor whose synchronous speed is 500 rpm",
                "admissible: 1.200e-3 to 1.200e1 s",
                "hint",
            ],
        ),
        (&[loom, "--period", "120"], &["--period", "\"120 ms\""]),
        (&[text(&free), "--period", "1 ns"], &["--period", "admissible: 6.283e-6"]),
        (&[loom, "--tolerance", "0"], &["--tolerance", "between 0 and 1"]),
        (&[loom, "--tolerance", "1e-15"], &["tool 1", "harmonics"]),
        (&[loom, "--keep", "1,2"], &["no follower has a cam"]),
        (&[loom, "--task", "examples/loom/task.toml", "--keep", "2"], &["--task", "law for follower 2", "hint"]),
        (&[loom, "--task", "examples/loom/scene.toml"], &["scene.toml"]),
        (&[loom, "--cam", "7=x.toml"], &["--cam", "1, 2"]),
        (&[loom, "--cam", &format!("1={SCENE}"), "--cam", &format!("2={SCENE}")], &["--cam", "another result"]),
        (&[text(&free), "--period", "120 ms", "--load", "30 N.m"], &["without a motor nothing balances", "hint"]),
    ] {
        let target = folder.join("never.toml");
        let run = camdrive(&[&["compensate", "-o", text(&target)], args].concat());
        assert!(is_refused(run.code), "{args:?}: {}", run.out);
        assert!(parts.iter().all(|part| run.err.contains(part)), "{args:?}: {}", run.err);
        assert!(!target.exists());
    }
    // A tool has the number of its follower.
    let run = camdrive(&["compensate", loom, "--keep", "1", "-o", text(&folder.join("second.toml"))]);
    assert!(run.out.contains("tool 2: deviation") && !run.out.contains("tool 1: deviation"), "{}", run.out);
    let own = folder.join("own.toml");
    std::fs::write(&own, &text_of_loom).unwrap();
    let run = camdrive(&["compensate", text(&own), "-o", text(&own)]);
    assert!(is_refused(run.code) && run.err.contains("would overwrite an input"), "{}", run.err);
    assert_eq!(std::fs::read_to_string(&own).unwrap(), text_of_loom);
}

#[test]
fn stability_writes_tables_and_maps() {
    let folder = folder("stability");
    let scene = "examples/transfer_manipulator/hs3.toml";
    let run = camdrive(&["stability", scene, "--orders", "3", "-o", text(&folder.join("study"))]);
    assert_eq!((run.code, run.err.as_str()), (0, ""), "no progress bar where nobody looks");
    // The peak of the torque is 1.12 times the kinetostatic one, the example says.
    for part in [
        "may run",
        "decay by 99.4 %",
        "Motion by both equations",
        "465 to 555",
        "Unstable speeds",
        "Resonances",
        "1.12 ",
        "linearisation",
    ] {
        assert!(run.out.contains(part), "{part} is missing in\n{}", run.out);
    }
    for (ending, part) in [
        ("csv", "critical_damping"),
        ("json", "\"multipliers\""),
        ("map.csv", "modulation"),
        ("damping.svg", "j = 2"),
        ("modulation.svg", "Speed [rpm]"),
        ("amplification.csv", "kinetostatic"),
        ("amplification.svg", "Amplification R"),
    ] {
        let path = folder.join("study").join(format!("transfer_hs3.{ending}"));
        let content = std::fs::read_to_string(&path).expect("the file is written");
        assert!(content.contains(part), "{part} is missing in {}", path.display());
    }
    assert_diagrams_read_well(&folder.join("study"));
    let quick = folder.join("quick");
    let run = camdrive(&["stability", scene, "--quick", "--speed", "500 rpm", "--orders", "2", "-o", text(&quick)]);
    assert!(
        run.code == 0
            && run.out.contains("free motions grow by 80.4 % a turn")
            && run.out.contains("By the linear equation: avoid 465 to 555 rpm"),
        "{}",
        run.out
    );
    assert!(!quick.join("transfer_hs3.damping.svg").exists());
}

#[test]
fn stability_refuses_what_it_cannot_study() {
    let cases: [(&[&str], &str); 10] = [
        (&["examples/rapier_loom/scene.toml"], "elastic input shaft"),
        (&["examples/valve_train/scene.toml"], "write a follower of a machine or a train as a scene of its own"),
        (&[SCENE, "--speed", "3 m"], "--speed"),
        (&[SCENE, "--speed=0 rpm"], "does not turn at speed 0"),
        (&[SCENE, "--speed=-46 rpm", "--speed=46 rpm"], "opposite signs"),
        (&[SCENE, "--from", "90 rpm", "--to", "40 rpm"], "--to"),
        (&[SCENE, "--damping=-0.1"], "--damping"),
        (&[SCENE, "--orders", "0"], "--orders"),
        (&[SCENE, "--modulation", "nan"], "--modulation"),
        (&[WRONG], WRONG),
    ];
    for (args, message) in cases {
        let run = camdrive(&[&["stability"], args].concat());
        assert!(is_refused(run.code) && run.out.is_empty(), "{args:?}");
        assert!(run.err.contains("error: ") && run.err.contains(message), "{args:?}: {}", run.err);
    }
    let file = folder("stability_file").join("here");
    std::fs::write(&file, "").expect("the folder can be written to");
    let run = camdrive(&["stability", SCENE, "--quick", "-o", text(&file)]);
    assert!(is_refused(run.code) && run.err.contains("folder"), "{}", run.err);
}

#[test]
fn a_measured_course_is_laid_over_a_computed_one() {
    let folder = folder("measured");
    let course = folder.join("course.csv");
    let write = |content: &str| std::fs::write(&course, content).expect("the folder can be written to");
    let examined = |measured: &str| {
        let given = ["--quick", "--orders", "2", "-o", text(&folder), "--measured", measured];
        camdrive(&[&["stability", SCENE][..], &given].concat())
    };
    let (file, named) = (text(&course).to_owned(), format!("load={}", text(&course)));
    write("phi [deg];M [kN.m]\n-90;0,1\n-45;0,2\n0;0.2\n45;0.3\n90;0.45\n");
    let svg = || std::fs::read_to_string(folder.join("transfer_manipulator.load.svg")).expect("the diagram");
    for measured in [&file, &named] {
        let run = examined(measured);
        assert_eq!((run.code, run.err.as_str()), (0, ""));
        let svg = svg();
        for part in ["M, 46.2 rpm", "kinetostatic, 46.2 rpm", "measured, course", "Torque M [N·m]"] {
            assert!(svg.contains(part), "{part} is missing in\n{svg}");
        }
    }
    // −90° lies at 270°, and no line leads from 315° back to 0°: 100, 200 and then 200, 300, 450 N·m.
    let svg = svg();
    let lines: Vec<Vec<f64>> = svg
        .split("<polyline")
        .filter(|part| part.contains("#2a7d4f"))
        .map(|part| part.split_once("points=\"").expect("points").1.split('"').next().expect("an end"))
        .map(|points| points.split_whitespace().map(|point| point.split_once(',').expect("x,y").1))
        .map(|heights| heights.map(|height| height.parse().expect("a number")).collect())
        .collect();
    // The last one is that of the legend.
    let lines: [Vec<f64>; 3] = lines.try_into().expect("two pieces and the legend");
    assert_eq!(lines.iter().map(Vec::len).collect::<Vec<_>>(), [2, 3, 2], "{lines:?}");
    // Coordinates are printed with two decimals.
    let ratio = (lines[0][0] - lines[1][1]) / (lines[0][0] - lines[1][2]);
    assert!((ratio - 200.0 / 350.0).abs() < 1e-3 && (lines[0][1] - lines[1][0]).abs() < 0.011, "{lines:?}");

    for (content, parts) in [
        ("phi [deg],M [kN.m]\n0,1\n1,x\n", &["course.csv:3:3", "\"x\" is not a finite number", "hint"][..]),
        ("0,1\n1,2\n1,3\n", &["course.csv:3:1", "1 deg does not exceed the previous one", "hint: sort"]),
        ("0,1\n400,2\n", &["course.csv:2:1", "400 deg is more than a turn", "admissible: 0 to 360 deg"]),
        ("0,1\n", &["a curve of 1 points", "admissible: at least 2"]),
        ("0\n1\n", &["course.csv:1:1", "column 2 is missing"]),
        ("phi [deg],F [kN]\n0,1\n1,2\n", &["course.csv:1:11", "\"kN\" is the unit of force; a torque is expected"]),
        ("phi [mm],M [N.m]\n0,1\n1,2\n", &["course.csv:1:1", "\"mm\" is the unit of length; an angle is expected"]),
    ] {
        write(content);
        // Forces of a cam are told at once; a study reads its file after its work.
        let run = camdrive(&[
            "forces",
            "examples/tappet/scene.toml",
            "-o",
            text(&folder),
            "--measured",
            &format!("torque={file}"),
        ]);
        assert!(is_refused(run.code) && parts.iter().all(|part| run.err.contains(part)), "{content}: {}", run.err);
    }
    let missing = examined("nowhere.csv");
    assert!(is_refused(missing.code) && missing.err.contains("the curve does not exist"), "{}", missing.err);
    let other = examined(&format!("lod={file}"));
    assert!(is_refused(other.code) && other.err.contains("admissible: load"), "{}", other.err);
}

#[test]
fn each_diagram_takes_measured_courses_in_its_own_units() {
    let folder = folder("measured_elsewhere");
    let course = folder.join("course.csv");
    let write = |content: &str| std::fs::write(&course, content).expect("the folder can be written to");
    let file = text(&course).to_owned();
    write("0,1\n90,2\n");
    let (sealing, at) = ("examples/sealing_machine/scene.toml", format!("torque={file}"));
    let forces = |measured: &str| camdrive(&["forces", sealing, "-o", text(&folder), "--measured", measured]);
    let run = forces(&file);
    assert!(is_refused(run.code) && run.err.contains("admissible: torque, follower1.roller_force"), "{}", run.err);
    assert_eq!(forces(&at).code, 0);
    let torque = std::fs::read_to_string(folder.join("sealing_machine.torque.svg")).expect("the diagram");
    assert!(torque.contains("measured, course"));
    let steady = camdrive(&["steady", sealing, "--measured", &format!("steady={file}")]);
    assert!(is_refused(steady.code) && steady.err.contains("--report"), "{}", steady.err);
    let report = text(&folder);
    let laid_over = |args: &[&str], heading: &str, file: &str| {
        write(&format!("phi [deg],{heading}\n0,40\n90,41\n"));
        let run = camdrive(args);
        assert_eq!(run.code, 0, "{args:?}: {}", run.err);
        let svg = std::fs::read_to_string(folder.join(file)).expect("the diagram");
        assert!(svg.contains("measured, course"), "{file}");
        // The heading's unit is that of this diagram alone.
        write("phi,v [K]\n0,40\n90,41\n");
        assert!(is_refused(camdrive(args).code), "{args:?}");
    };
    let named = |diagram: &str| format!("{diagram}={file}");
    laid_over(
        &["steady", sealing, "--report", report, "--measured", &named("steady")],
        "w [rpm]",
        "sealing_machine.steady.svg",
    );
    // Lengths of this task count in scale = 10 mm; courses have their own units nevertheless.
    let profile = folder.join("p.toml");
    let synthesize = ["synthesize", TASK, "-o", text(&profile), "--report", report, "--measured"];
    laid_over(&[&synthesize[..], &[&named("position")]].concat(), "U [mm]", "dwell_synthesis.position.svg");
    let cam = ["cam", "examples/rapier_loom/scene.toml", "-o", report, "--measured"];
    let loom = "rapier_loom.follower2";
    laid_over(
        &[&cam[..], &[&named("follower2.pressure_angle")]].concat(),
        "alpha [deg]",
        &format!("{loom}.pressure_angle.svg"),
    );
    laid_over(&[&cam[..], &[&named("follower2.curvature")]].concat(), "k [1/m]", &format!("{loom}.curvature.svg"));
    let compensate =
        ["compensate", "examples/rapier_loom/scene.toml", "-o", text(&profile), "--report", report, "--measured"];
    laid_over(&[&compensate[..], &[&named("speed")]].concat(), "w [rpm]", "rapier_loom.speed.svg");
    laid_over(&[&compensate[..], &[&named("tool1")]].concat(), "a [m/s2]", "rapier_loom.tool1.svg");
}

const BACKLASH: &str = "examples/backlash_drive/scene.toml";

#[test]
fn clearance_writes_tables_and_diagrams() {
    let folder = folder("clearance").join("study");
    let run = camdrive(&["clearance", BACKLASH, "--turns", "4", "-o", text(&folder)]);
    assert_eq!((run.code, run.err.as_str()), (0, ""), "no progress bar where nobody looks");
    // The example's README has these numbers.
    for part in [
        "254  ",
        "0.0225",
        "0.033 ",
        "opens again",
        "283 to 508 rpm",
        "Settled motion",
        "Change the damping ratio from ",
    ] {
        assert!(run.out.contains(part), "{part} is missing in\n{}", run.out);
    }
    for (ending, part) in [
        ("json", "\"passages\""),
        ("passages.csv", "impulse_Ns"),
        ("after_impact.csv", "q_over_s_model"),
        ("passage_time.csv", "tau1"),
        ("map.csv", "elastic"),
        ("passage_time.svg", "Dynamic clearance"),
        ("multiple_impacts.svg", "Mass ratio"),
        ("deformation.svg", "Deformation"),
        ("force.svg", "Contact force"),
        ("acceleration.svg", "U″ [mm/rad²]"),
    ] {
        let path = folder.join(format!("backlash_drive.{ending}"));
        let content = std::fs::read_to_string(&path).expect("the file is written");
        assert!(content.contains(part), "{part} is missing in {}", path.display());
        if ending == "json" {
            let value: serde_json::Value = serde_json::from_str(&content).expect("JSON");
            assert!(value["laws"][0]["by_model"]["searched"].is_array());
            assert_documented("clearance", &value);
        }
    }
    assert_diagrams_read_well(&folder);
}

#[test]
fn clearance_compares_laws_and_takes_an_elastic_output() {
    let folder = folder("clearance_laws");
    let scene = "examples/guide_bar/traditional.toml";
    let given = ["--clearance", "20 um", "--m1", "1.5 kg", "--turns", "4", "--quick"];
    let compare = ["--compare", "bestehorn,modsine,hs6,examples/guide_bar/scene.toml", "-o", text(&folder)];
    let run = camdrive(&[&["clearance", scene][..], &given, &compare].concat());
    assert_eq!((run.code, run.err.as_str()), (0, ""));
    for part in ["m1 1.5 kg", "Laws", "inclined_sine", "modified_sine", "hs6", "guide_bar", "largest U″"] {
        assert!(run.out.contains(part), "{part} is missing in\n{}", run.out);
    }
}

#[test]
fn clearance_trusts_the_model_where_the_formulas_differ() {
    let folder = folder("clearance_verdict");
    let scene = "examples/guide_bar/traditional.toml";
    let given = ["--clearance", "0.05 mm", "--m1", "2 kg", "--turns", "4", "-o", text(&folder), "--explain"];
    let run = camdrive(&[&["clearance", scene][..], &given].concat());
    let compared = camdrive(&[&["clearance", scene, "--quick"][..], &given, &["--compare", "bestehorn,hs7"]].concat());
    assert_eq!((run.code, run.err.as_str(), compared.code, compared.err.as_str()), (0, "", 0, ""));
    let both = run.out + &compared.out;
    for part in [
        "Without earlier vibration the contact opens 10 times a turn",
        "opens again",
        "Laws without further impacts",
        "disagree on further impacts after a passage: scene.",
        "disagree on further impacts after a passage: scene, inclined_sine",
    ] {
        assert!(both.contains(part), "{part} is missing in\n{both}");
    }
}

#[test]
fn clearance_refuses_what_has_none() {
    let file = folder("clearance_file").join("here");
    std::fs::write(&file, "").expect("the folder can be written to");
    let elastic = "examples/guide_bar/scene.toml";
    for (args, part) in [
        (vec!["examples/rapier_loom/scene.toml"], "the model is RigidMachine; the study is for a BacklashDrive"),
        (vec!["examples/transfer_manipulator/scene.toml"], "ElasticCamDrive.shaft"),
        (vec!["examples/valve_train/scene.toml"], "write a follower of a train as a scene of its own"),
        (vec![elastic, "--clearance", "1 mm"], "= hint: give --clearance and --m1"),
        (
            vec![elastic, "--clearance", "1 mm", "--m1", "0 kg"],
            "--m1: \"0 kg\" is out of range\n  = admissible: greater than 0 kg",
        ),
        (vec!["examples/guide_bar/run_up.toml", "--clearance", "1 mm", "--m1", "1 kg"], "--speed"),
        (vec![BACKLASH, "--clearance", "3 kg"], "--clearance"),
        (vec![BACKLASH, "--compare", "bestehorn"], "has no cycle"),
        (vec![BACKLASH, "--compare", "wobble"], "`wobble` is not known"),
        (vec![BACKLASH, "--compare", "hs0"], "hs1"),
        (vec![BACKLASH, "--compare", "no_such_scene.toml"], "no_such_scene.toml"),
        (vec![BACKLASH, "--compare", "examples/rapier_loom/scene.toml"], "has no cam"),
        (vec![BACKLASH, "-o", text(&file)], "folder"),
        (vec![WRONG], WRONG),
    ] {
        let run = camdrive(&[&["clearance"], &args[..]].concat());
        assert!(is_refused(run.code) && run.out.is_empty(), "{args:?}");
        assert!(run.err.contains("error") && run.err.contains(part), "{args:?}: {}", run.err);
    }
}

#[test]
fn steady_finds_the_periodic_motions() {
    let folder = folder("steady");
    let loom = "examples/rapier_loom/scene.toml";
    let run = camdrive(&["steady", loom, "--report", text(&folder)]);
    assert_eq!(run.code, 0, "{}", run.err);
    for figure in ["runs at 500 rpm", "decays to 1 %", "(474 to 533 rpm)", "without torques"] {
        assert!(run.out.contains(figure), "{figure}: {}", run.out);
    }
    assert!(folder.join("rapier_loom.steady.csv").is_file() && folder.join("rapier_loom.steady.svg").is_file());
    assert_diagrams_read_well(&folder);
    let run = camdrive(&["steady", loom, "--load", "120 N.m"]);
    assert!(run.out.contains("Slower than about 230 rpm") && run.out.contains("2 (unstable)"), "{}", run.out);
    let run = camdrive(&["steady", loom, "--load", "250 N.m"]);
    // Without any periodic motion the exit code says so.
    assert!(run.code == 3 && run.out.contains("stalls"), "{}", run.out);
    let run = camdrive(&["steady", loom, "--period", "120 ms"]);
    assert!(run.code == 0 && run.out.contains("a synchronous speed of the motor of 500.17"), "{}{}", run.out, run.err);
    let run = camdrive(&["steady", loom, "--period", "120 ms", "--json"]);
    let found: serde_json::Value = serde_json::from_str(&run.out).expect("JSON");
    let [period, speed] = [&found["motions"][0]["period"], &found["synchronous_speed"]].map(|n| n.as_f64().unwrap());
    assert!((period / 0.12 - 1.0).abs() < 1e-14 && (speed / 52.378_064_850_15 - 1.0).abs() < 1e-12, "{period} {speed}");
    for (args, part) in [
        (&["tests/fmpy/scenes/machine_torque_input.toml"][..], "is an input"),
        (&[SCENE, "--load", "3 N.m"], "RigidMachine"),
        (&["tests/fmpy/scenes/machine_free.toml"], "--period"),
        (&[loom, "--period", "0"], "positive"),
        (&[loom, "--period", "1 ns"], "admissible: 1.200e-3 to 1.200e1 s"),
        (&["tests/fmpy/scenes/machine_free.toml", "--period", "1 ns"], "admissible: 6.283e-6"),
    ] {
        let run = camdrive(&[&["steady"], args].concat());
        assert!(is_refused(run.code) && run.err.contains(part), "{args:?}: {}", run.err);
    }
}

#[test]
fn steady_finds_the_motion_of_a_train() {
    let folder = folder("steady_train");
    let (train, report) = (folder.join("train.toml"), folder.join("report"));
    let scene = |load: &str| {
        format!(
            "name = \"train\"\nmodel = \"DriveTrain\"\n\
             machine = {{ J0 = 0.9, load = {{ torque = {{ law = \"fourier\", a = [4.0, 1.5], b = [0.8] }}, friction = 0.1 }} }}\n\
             motor = {{ kind = \"kloss\", M_k = 60, s_k = 0.2, w_s = 15 }}\n[[follower]]\n\
             cam = {{ law = \"fourier\", a = [0.0, 0.023468, 0.0, -0.003936, 0.0, 0.00046] }}\n\
             elasticity = {{ place = \"output\", m = 3, c = 12000, b = 20 }}\nload = {load}\n"
        )
    };
    std::fs::write(&train, scene("{ gravity = \"9.81 m/s2\" }")).unwrap();
    let run = camdrive(&["steady", text(&train), "--report", text(&report), "--explain"]);
    assert_eq!((run.code, run.err.as_str()), (0, ""));
    for part in ["423", "stable", "−2.4e-3", "0.241", "fluctuates", "a mean torque of", "follower[1].q [mm]"] {
        assert!(run.out.contains(part), "{part}: {}", run.out);
    }
    assert!(report.join("train.steady.csv").is_file() && report.join("train.steady.svg").is_file());
    let data = camdrive(&["steady", text(&train), "--json"]).out;
    let data: serde_json::Value = serde_json::from_str(&data).expect("JSON");
    assert_eq!((&data["motions"][0]["stable"], &data["turn"]["impacts"]), (&true.into(), &serde_json::json!([null])));
    assert!(data["turn"]["multipliers"][0][1].as_f64().is_some_and(|im| (im.abs() - 0.2407085).abs() < 1e-7));
    // A spring that would let the tool go: steady and describe tell from which speed on, check names the model.
    std::fs::write(&train, scene("{ spring = { preload = \"10 N\", c = 100, at = 0 } }")).unwrap();
    for command in ["steady", "describe"] {
        let run = camdrive(&[command, text(&train)]);
        assert!(run.out.contains("The real follower lifts off "), "{command}: {}", run.out);
    }
    // A report says once that a follower lifts off.
    let page = folder.join("valve.html");
    assert_eq!(camdrive(&["report", "examples/valve_train/scene.toml", "-o", text(&page)]).code, 0);
    let page = std::fs::read_to_string(&page).unwrap();
    assert_eq!(page.split("<h2").nth(1).unwrap().matches("lifts off").count(), 1);
    let note = camdrive(&["check", text(&train)]);
    assert!(note.err.contains("use [follower.backlash] with s = \"inf\" in a DriveTrain"), "{}", note.err);
    assert!(note.out.contains("follower[1].natural frequency") && note.out.contains("mean speed"), "{}", note.out);
    // An unstable or a missing motion, and options of other machines.
    for (args, part) in [
        (&[text(&train), "--period", "1 s"][..], "--speed or the motor decides the speed"),
        (&[text(&train), "--speed", "1 rpm"], "choose the speed by the motor"),
        (&["modelDescription/DriveTrain.input.toml"], "give --speed"),
    ] {
        let run = camdrive(&[&["steady"], args].concat());
        assert!(is_refused(run.code) && run.err.contains(part), "{args:?}: {}", run.err);
    }
    let run = camdrive(&["steady", "modelDescription/DriveTrain.servo.toml"]);
    assert!(run.code == 3 && run.out.contains("The shaft follows an input"), "{}", run.out);
    let run = camdrive(&["forces", "examples/valve_train/scene.toml", "-o", text(&report)]);
    assert!(is_refused(run.code) && run.err.contains("lifts off its cam at 2400 rpm"), "{}", run.err);
}

const TASK: &str = "examples/dwell_synthesis/task.toml";

#[test]
fn synthesize_writes_a_profile_that_export_takes() {
    let folder = folder("synthesize");
    let report = folder.join("report");
    let (profile, scene) = (folder.join("profile.toml"), folder.join("scene.toml"));
    let run = camdrive(&["synthesize", TASK, "-o", text(&profile), "--report", text(&report)]);
    assert_eq!((run.code, run.err.as_str()), (0, ""));
    for part in [
        "dwell_synthesis",
        "met to 0.01 mm (`dwell[",
        "]`) from 0 to 2250 rpm",
        "the global optimum",
        "Resonances",
        "profile.toml",
    ] {
        assert!(run.out.contains(part), "{part} is missing in\n{}", run.out);
    }
    for name in [
        "profile.csv",
        "laws.csv",
        "speed.csv",
        "dwell_width.csv",
        "json",
        "position.svg",
        "velocity.svg",
        "acceleration.svg",
        "torque.svg",
        "deviation.svg",
        "harmonics.svg",
        "speed.svg",
        "dwell_width.svg",
    ] {
        let path = report.join(format!("dwell_synthesis.{name}"));
        let content = std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        assert!(!content.contains("NaN"), "{name}");
        if name == "json" {
            assert_documented("synthesize", &serde_json::from_str(&content).expect("JSON"));
        }
    }
    assert_diagrams_read_well(&report);
    // The fragment completes a scene without cam.
    let machine = "name = \"dwelling\"\nmodel = \"ElasticCamDrive\"\n[drive]\nspeed = \"1800 rpm\"\n\
                   [elasticity]\nplace = \"output\"\nm = 12\nnatural_frequency = \"270 Hz\"\n\n";
    let fragment = std::fs::read_to_string(&profile).expect("the profile");
    std::fs::write(&scene, machine.to_owned() + &fragment).expect("the folder can be written to");
    let fmu = folder.join("dwelling.fmu");
    let run = camdrive(&["export", text(&scene), "-o", text(&fmu), "--runtime", &runtime()]);
    assert_eq!(run.code, 0, "{}", run.err);
    assert!(fmu.exists());
}

#[test]
fn synthesize_completes_a_scene() {
    let folder = folder("synthesize_scene");
    let scene = std::fs::canonicalize(root().join("examples/guide_bar/scene.toml")).expect("the example");
    let task = folder.join("task.toml");
    let dwells =
        "[[dwell]]\ncentre = 0\nwidth = 0.5\nU = 0.5\n[[dwell]]\ncentre = \"180 deg\"\nwidth = 0.5\nU = -0.5\n";
    let content = format!(
        "name = \"new_guide_bar\"\nharmonics = 3\nobjective = \"least_squares\"\nscale = \"0.94 mm\"\n\
         symmetry = \"even_half_wave\"\nscene = {:?}\n{dwells}",
        text(&scene)
    );
    std::fs::write(&task, content).expect("the folder can be written to");
    let profile = folder.join("new.toml");
    let run = camdrive(&["synthesize", text(&task), "-o", text(&profile), "--explain"]);
    assert_eq!((run.code, run.err.as_str()), (0, ""));
    // The source's cubics are off by a percent here and by 1e-4 in the dwell.
    assert!(run.out.contains("The cubics (4.6.4.1 (2) to (6)) of the source fail here"), "{}", run.out);
    let run = camdrive(&["check", text(&profile)]);
    assert_eq!((run.code, run.err.as_str()), (0, ""));
    // An input is not overwritten.
    let run = camdrive(&["synthesize", text(&task), "-o", text(&task)]);
    assert_eq!(run.code, 1);
    assert!(run.err.contains("overwrite"), "{}", run.err);
}

#[test]
fn synthesize_tells_all_faults_of_a_task() {
    let folder = folder("synthesize_faults");
    let task = folder.join("task.toml");
    let content = "name = \"t\"\nharmonics = 0\nobjective = \"chebyshef\"\npionts = 3\nscale = \"5 N\"\n\
                   [[dwell]]\ncentre = \"0 mm\"\nwidth = \"400 deg\"\nU = 0\n[[range]]\nfrom = 1\nto = 0.5\nU = 0\n\
                   [[range]]\nfrom = \"20 deg\"\nto = \"20 deg\"\nU = 0\n\
                   [[point]]\nphi = 0\n[[bound]]\nof = \"ddU\"\n";
    std::fs::write(&task, content).expect("the folder can be written to");
    let run = camdrive(&["synthesize", text(&task)]);
    assert_eq!((run.code, run.out.as_str()), (1, ""));
    for part in [
        "task.toml:2:13",
        "chebyshev",
        "`pionts` is not known in a task",
        "is a force; a length is expected",
        "`dwell[1].centre`",
        "`dwell[1].width`",
        "is not a range",
        "write for example to = \"380 deg\"; a single angle is a [[point]]",
        "has no U",
        "bounds nothing",
    ] {
        assert!(run.err.contains(part), "{part} is missing in\n{}", run.err);
    }
}

#[test]
fn synthesize_meets_a_measured_flank() {
    let folder = folder("flank");
    let flank = |from: i32| {
        let lift = |phi: i32| 500.0 * (3.0 * f64::from(phi).to_radians().sin()).tanh();
        let points: String = (from..=95).map(|phi| format!("{phi},{}\n", lift(phi))).collect();
        std::fs::write(folder.join("flank.csv"), format!("phi,U\n{points}")).expect("the folder can be written to");
    };
    let task = |more: &str| {
        let target = "law = \"table\"\nfile = \"flank.csv\"\nangle_unit = \"deg\"\nlift_unit = \"mm\"\n";
        let range = "[[range]]\nfrom = \"-70 deg\"\nto = \"95 deg\"\n[range.target]\n";
        let head = "name = \"flank\"\nobjective = \"chebyshev\"\nharmonics = 5\n";
        let content = format!("{head}{range}{target}{more}\n[[point]]\nphi = \"180 deg\"\nU = 0\n");
        let file = folder.join("task.toml");
        std::fs::write(&file, content).expect("the folder can be written to");
        let to = folder.join("profile.toml");
        camdrive(&["synthesize", text(&file), "-o", text(&to), "--json"])
    };
    flank(-70);
    let run = task("");
    assert_eq!((run.code, run.err.as_str()), (0, ""));
    let json: serde_json::Value = serde_json::from_str(&run.out).expect("JSON");
    // 0.01037395219791388 is the optimum to tanh(3 sin φ)/2 itself; the spline through a point per degree errs by 5e-11.
    let level = json["objective"]["value"].as_f64().expect("a number");
    assert!((level - 0.01037395219791388).abs() < 1e-9, "{level}");
    let run = task("noise = \"estimate\"");
    assert!(run.code == 1 && run.err.contains("195 deg before its turn does"), "{}", run.err);
    flank(-60);
    let run = task("");
    assert!(run.code == 1 && run.err.contains("reaches from -60 deg to 95 deg, not from -70 deg"), "{}", run.err);
}

#[test]
fn synthesize_says_what_cannot_be_met() {
    let folder = folder("synthesize_infeasible");
    let task = folder.join("task.toml");
    let points = "[[point]]\nphi = 0\nU = 0.5\n[[point]]\nphi = \"180 deg\"\nU = -0.5\n";
    let content = "name = \"t\"\nharmonics = 5\nobjective = \"peak_torque\"\n";
    let bound = "[[bound]]\nof = \"ddU\"\nlimit = 0.2\n";
    std::fs::write(&task, format!("{content}{points}{bound}")).expect("the folder can be written to");
    let run = camdrive(&["synthesize", text(&task), "-o", text(&folder.join("p.toml"))]);
    assert_eq!((run.code, run.out.as_str()), (1, ""));
    // A stroke of 1 over half a turn takes an acceleration of at least 4/π² = 0.405.
    assert!(run.err.contains("U″ must leave -0.2 to 0.2") && run.err.contains("by 0.2"), "{}", run.err);
    assert!(run.err.contains("`bound[1]`") && run.err.contains("m/rad²"), "{}", run.err);
    assert!(!folder.join("p.toml").exists());
    // A tolerance is called by its key, and so is a point.
    let dwell =
        |centre: u32, more: &str| format!("[[dwell]]\ncentre = \"{centre} deg\"\nwidth = 0.5\nU = 0.{centre}\n{more}");
    let head = "name = \"t\"\nharmonics = 3\nobjective = \"chebyshev\"\n";
    let fail = |content: String, parts: &[&str]| {
        std::fs::write(&task, content).expect("the folder can be written to");
        let run = camdrive(&["synthesize", text(&task), "-o", text(&folder.join("p.toml"))]);
        assert_eq!(run.code, 1, "{}", run.out);
        assert!(parts.iter().all(|part| run.err.contains(part)), "{parts:?} in\n{}", run.err);
    };
    let tight = "tolerance = 1e-9\n";
    fail(
        head.to_owned() + &dwell(10, tight) + &dwell(60, tight) + &dwell(90, ""),
        &["`dwell[", "].tolerance`", "hint"],
    );
    let twice = "[[point]]\nphi = 0\nU = 0.5\n[[point]]\nphi = \"360 deg\"\nU = 0.4\n";
    fail(head.to_owned() + &dwell(90, "") + twice, &["`point[", "].U`", "at best U"]);
    fail(
        head.to_owned() + &dwell(10, "") + &dwell(20, ""),
        &["`dwell[2]` and `dwell[1]` overlap from 5.67605512 deg", "`U`"],
    );
}

#[test]
fn synthesize_takes_a_shaft_by_its_natural_frequency() {
    let folder = folder("synthesize_shaft");
    let task = folder.join("task.toml");
    let dwells = "[[dwell]]\ncentre = 0\nwidth = 1\nU = 0.5\n[[dwell]]\ncentre = \"180 deg\"\nwidth = 1\nU = -0.5\n";
    let head = "name = \"t\"\nharmonics = 3\nobjective = \"chebyshev\"\nscale = 0.4\nsymmetry = \"even_half_wave\"\n";
    let shaft = "[shaft]\nm = 60\nJ = 1.5\nslowest = 3\nfastest = 8\n";
    let run = |elasticity: &str| {
        std::fs::write(&task, format!("{head}{dwells}{shaft}{elasticity}")).expect("the folder can be written to");
        let _ = std::fs::remove_file(folder.join("p.toml"));
        camdrive(&["synthesize", text(&task), "-o", text(&folder.join("p.toml"))])
    };
    // √(c/J) = 125 rad/s, b/(2 √(c J)) = 0.04.
    let (itself, ratios) = (run("c = 23437.5\nb = 15\n"), run("natural_frequency = 125\ndamping_ratio = 0.04\n"));
    assert_eq!((itself.code, &itself.out), (ratios.code, &ratios.out), "{}", ratios.err);
    assert!(itself.out.contains("The largest torque of the nonlinear drive differs by at most"), "{}", itself.out);
    for (elasticity, part) in [
        ("c = 1\nnatural_frequency = 1\nb = 1\n", "`c` determines it already"),
        ("c = 1\n", "`shaft.b` is missing"),
        ("c = 1\ndamping_ratio = 0\n", "greater than 0"),
    ] {
        let run = run(elasticity);
        assert!(run.code == 1 && run.err.contains(part), "{part} is missing in\n{}", run.err);
    }
}

#[test]
fn options_of_studies_are_refused_with_their_range() {
    let (rods, backlash) = ("examples/rod_drive/scene.toml", "examples/backlash_drive/scene.toml");
    for (arguments, part) in [
        (["stability", rods, "--speed", "0 rpm"], "--speed: the drive does not turn at speed 0"),
        (["stability", rods, "--damping", "-0.1"], "--damping: -0.1 is out of range\n  = admissible: 0 to 10"),
        (
            ["stability", rods, "--modulation", "-1"],
            "--modulation: -1 is out of range\n  = admissible: 0.000001 to 100",
        ),
        (["stability", rods, "--speed", "1e-9"], "a turn cannot be followed"),
        (["clearance", backlash, "--turns", "1"], "--turns: 1 is not from 4 to 1000000"),
        (
            ["clearance", backlash, "--clearance", "-1"],
            "--clearance: \"-1\" is out of range\n  = admissible: greater than 0 m",
        ),
        (["clearance", backlash, "--compare", "examples/rapier_loom/scene.toml"], "--compare: the scene rapier_loom"),
    ] {
        let run = camdrive(&arguments);
        assert!(is_refused(run.code) && run.err.contains(part), "{part} is missing in\n{}", run.err);
    }
}

/// A scene whose cam has a geometry, with this change of its text.
fn with_geometry(folder: &Path, from: &str, to: &str) -> PathBuf {
    let scene = "name = \"valve\"\nmodel = \"ElasticCamDrive\"\n[cam]\nlaw = \"cycle\"\nstroke = \"10 mm\"\n\
        rise = \"90 deg\"\nreturn = \"90 deg\"\nupper_dwell = \"30 deg\"\nrise_law = \"modified_sine\"\n\
        [geometry]\nfollower = \"translating\"\noffset = \"3 mm\"\nroller_radius = \"8 mm\"\nbase_radius = \"30 mm\"\n\
        [drive]\nspeed = \"300 rpm\"\n[elasticity]\nplace = \"output\"\nm = \"1 kg\"\nc = \"9 kN/m\"\n";
    assert!(scene.contains(from), "{from}");
    let path = folder.join("scene.toml");
    std::fs::write(&path, scene.replacen(from, to, 1)).expect("the folder can be written to");
    path
}

#[test]
fn cam_writes_contours_and_tables() {
    let folder = folder("cam");
    let (scene, output) = (with_geometry(&folder, "", ""), folder.join("cut"));
    let run = camdrive(&["cam", text(&scene), "-o", text(&output), "--chord-error", "2 um"]);
    assert_eq!((run.code, run.err.as_str()), (0, ""));
    for part in ["valve: disc cam", "30 mm", "largest pressure angle", "chord error", "valve.dxf"] {
        assert!(run.out.contains(part), "{part} is missing in\n{}", run.out);
    }
    for (ending, part) in [
        ("csv", "phi_deg,lift_mm,height_mm"),
        ("dxf", "INNER_CONTOUR"),
        ("svg", "Drawn at φ = 0"),
        ("pressure_angle.svg", "admissible"),
        ("curvature.svg", "Curvature of the roller"),
        ("plcopen.csv", "MasterPosition[deg];SlavePosition[mm]"),
        ("plc.txt", "360.000000\t0.0000000"),
        ("json", "\"chord_error\""),
    ] {
        let path = output.join(format!("valve.{ending}"));
        let content = std::fs::read_to_string(&path).expect("the file is written");
        assert!(content.contains(part), "{part} is missing in {}", path.display());
    }
    // A disc bulges everywhere in its dwells: the curvature of the contour is 1/30 mm there, that of the path 1/38 mm.
    let table = std::fs::read_to_string(output.join("valve.csv")).expect("the table");
    let last: Vec<&str> = table.lines().last().expect("a line").split(',').collect();
    let column = |name: &str| table.lines().next().and_then(|head| head.split(',').position(|other| other == name));
    for (name, radius) in [("curvature_1_per_mm", 38.0), ("inner_curvature_1_per_mm", 30.0)] {
        let value: f64 = last[column(name).expect("the column")].parse().expect("a number");
        assert!((value * radius - 1.0).abs() < 1e-9, "{name}: {value}");
    }
    assert_diagrams_read_well(&output);
    // The FMU takes no notice: the interface is the same without geometry.
    let xml = |scene: &Path| camdrive(&["describe", text(scene), "--xml"]).out;
    let with = xml(&scene);
    let plain = with_geometry(
        &folder,
        "[geometry]\nfollower = \"translating\"\noffset = \"3 mm\"\nroller_radius = \"8 mm\"\nbase_radius = \"30 mm\"\n",
        "",
    );
    assert!(with.contains("valve") && with == xml(&plain));
}

#[test]
fn cam_warns_of_what_runs_badly_and_refuses_what_cannot_be_cut() {
    let folder = folder("cam_refuses");
    let target = folder.join("cut");
    let size = "roller_radius = \"8 mm\"\nbase_radius = \"30 mm\"";
    let steep = with_geometry(&folder, size, "roller_radius = \"16 mm\"\nprime_radius = \"17 mm\"");
    let run = camdrive(&["cam", text(&steep), "-o", text(&target)]);
    assert!(run.code == 1 && run.err.contains("error: valve: undercut of the inner contour"), "{}", run.err);
    assert!(run.out.contains("valve: largest pressure angle") && run.out.contains("at φ = "), "{}", run.out);
    assert!(run.err.contains("--force") && run.out.contains("fault") && !target.exists());
    let run = camdrive(&["cam", text(&steep), "-o", text(&target), "--force"]);
    assert!(run.code == 0 && run.out.contains("undercut") && target.join("valve.dxf").is_file(), "{}", run.err);
    let flat = with_geometry(&folder, "base_radius = \"30 mm\"", "base_radius = \"9 mm\"");
    let run = camdrive(&["cam", text(&flat), "-o", text(&target)]);
    assert!(run.code == 0 && run.out.contains("valve: largest pressure angle "), "{}", run.out);
}

#[test]
fn cam_says_what_it_cannot_do() {
    let folder = folder("cam_wrong");
    let scene = with_geometry(&folder, "", "");
    let file = folder.join("here");
    std::fs::write(&file, "").expect("the folder can be written to");
    let cases: [(&[&str], &[&str]); 10] = [
        (&[SCENE], &["has no geometry of a cam", "[geometry]"]),
        (&["examples/rod_drive/scene.toml"], &["ParametricDrive has no cam"]),
        (&[WRONG], &[WRONG]),
        (&[text(&scene), "-o", text(&file)], &["-o takes a folder"]),
        (&[text(&scene), "--chord-error", "1 s"], &["--chord-error", "a time", "1 um"]),
        (&[text(&scene), "--chord-error", "0"], &["--chord-error", "out of range", "1e-9"]),
        (&[text(&scene), "--chord-error=-1 um"], &["--chord-error", "out of range"]),
        (&[text(&scene), "--table-error", "nan"], &["--table-error", "finite"]),
        (&[text(&scene), "--follower", "1"], &["--follower", "not a machine"]),
        (&["no_such_scene.toml"], &["cannot be read"]),
    ];
    for (args, parts) in cases {
        let run = camdrive(&[&["cam"], args].concat());
        assert!(is_refused(run.code) && run.out.is_empty(), "{args:?}");
        assert!(parts.iter().all(|part| run.err.contains(part)), "{args:?}: {}", run.err);
    }
}

#[test]
fn synthesize_gives_a_follower_of_a_machine_its_cam() {
    let folder = folder("synthesize_follower");
    let (task, machine) = ("examples/loom/task.toml", "examples/loom/scene.toml");
    let target = folder.join("loom.toml");
    let run =
        camdrive(&["synthesize", task, "--law", "gripper", "--scene", machine, "--follower", "1", "-o", text(&target)]);
    assert_eq!(run.code, 0, "{}", run.err);
    let written = std::fs::read_to_string(&target).expect("the scene is written");
    // The rest of the machine is as it was, with the geometry beside the new law.
    assert!(written.contains("name = \"loom\"") && written.contains("scale = \"45 mm\""), "{written}");
    assert!(!written.contains("scale = \"400 mm\"") && written.matches("[follower.geometry]").count() == 2);
    assert_eq!(camdrive(&["check", text(&target)]).code, 0);
    let never = folder.join("never.toml");
    let cases: [(&[&str], &str); 6] = [
        (&["--follower", "1"], "name the machine with --scene"),
        (&["--scene", machine], "several cams"),
        (&["--scene", machine, "--follower", "3"], "no follower 3; the scene has 2"),
        (&["--scene", machine, "--follower", "0"], "no follower 0"),
        (&["--scene", "examples/loom/gripper.toml", "--follower", "1"], "not a machine"),
        (&["--scene", "no_such_scene.toml"], "cannot be read"),
    ];
    for (args, message) in cases {
        let run = camdrive(&[&["synthesize", task, "--law", "sley", "-o", text(&never)], args].concat());
        assert!(is_refused(run.code) && run.out.is_empty(), "{args:?}");
        assert!(run.err.contains("error: ") && run.err.contains(message), "{args:?}: {}", run.err);
    }
    // Without --law each follower gets its own, and the report tells how the tools keep their restrictions.
    let report = folder.join("report");
    let run = camdrive(&["synthesize", task, "--scene", machine, "-o", text(&target), "--report", text(&report)]);
    assert_eq!(run.code, 0, "{}", run.err);
    assert!(run.out.contains("restriction[2]") && run.out.contains("(sley)"), "{}", run.out);
    let written = std::fs::read_to_string(&target).expect("the scene is written");
    assert!(!written.contains("scale = \"45 mm\"") && !written.contains("scale = \"400 mm\""), "{written}");
    assert_eq!(camdrive(&["check", text(&target)]).code, 0);
    let told = std::fs::read_to_string(report.join("tools.json")).expect("the report");
    let told: serde_json::Value = serde_json::from_str(&told).expect("JSON");
    assert_eq!(told["laws"].as_array().map(Vec::len), Some(2));
    assert!(report.join("tools.sley.profile.csv").is_file() && report.join("tools.gripper.position.svg").is_file());
    assert!(told["restrictions"][0]["reserve"].as_f64() > Some(0.0), "{}", told["restrictions"]);
    for (args, message) in [
        (&["--law", "reed"][..], "choose gripper, sley"),
        (&["--scene", "examples/loom/gripper.toml"], "2 laws for the followers 1 to 2"),
    ] {
        let run = camdrive(&[&["synthesize", task, "-o", text(&never)], args].concat());
        assert!(is_refused(run.code) && run.err.contains(message), "{args:?}: {}", run.err);
    }
    assert!(!never.exists());
}

#[test]
fn cam_cuts_what_moves_a_lever() {
    let folder = folder("cam_lever");
    let scene = folder.join("scene.toml");
    let text_of_scene = "name = \"x\"\nmodel = \"RigidMachine\"\n[machine]\nJ0 = 1\n[[follower]]\nm = 2\n\
        cam = { law = \"fourier\", a = [\"0 deg\", \"12 deg\"] }\nlinkage = [{ kind = \"gear\", radius = \"0.3 m\" }]\n\
        [follower.geometry]\nfollower = \"lever\"\npivot_distance = \"180 mm\"\narm_length = \"110 mm\"\n\
        roller_radius = \"20 mm\"\nbase_radius = \"70 mm\"\n";
    std::fs::write(&scene, text_of_scene).expect("the folder can be written to");
    let run = camdrive(&["cam", text(&scene), "-o", text(&folder)]);
    assert_eq!(run.code, 0, "{}", run.err);
    // r² = d² + l² − 2 d l cos ψ of the prime circle, and 24° above it.
    let least = ((0.18_f64.powi(2) + 0.11_f64.powi(2) - 0.09_f64.powi(2)) / (2.0 * 0.18 * 0.11)).acos().to_degrees();
    assert!(
        run.out.contains(&format!("{least:.1}°")) && run.out.contains(&format!("{:.1}°", least + 24.0)),
        "{}",
        run.out
    );
    let table = std::fs::read_to_string(folder.join("x.follower1.csv")).expect("the table is written");
    assert!(table.starts_with("phi_deg,lift_deg,lever_deg"), "{table}");
}

#[test]
fn forces_tells_what_rollers_and_joints_bear() {
    let folder = folder("forces");
    let run = camdrive(&["forces", TAPPET, "-o", text(&folder)]);
    assert_eq!((run.code, run.err.as_str()), (0, ""));
    for part in
        ["at constant 573 rpm", "lifts off above 1600 rpm, first at φ = 247°", "without a preload", "tappet.torque.svg"]
    {
        assert!(run.out.contains(part), "{part} is missing in\n{}", run.out);
    }
    let report = |name: &str| -> serde_json::Value {
        let json = std::fs::read_to_string(folder.join(format!("{name}.json"))).expect("the report");
        serde_json::from_str(&json).expect("JSON")
    };
    let range = |report: &serde_json::Value, j: usize, name: &str| {
        let list = report["drives"][j]["quantities"].as_array().expect("a list").clone();
        let found = list.into_iter().find(|q| q["quantity"] == name).unwrap_or_else(|| panic!("no {name}"));
        ["least", "largest"].map(|end| found[end]["value"].as_f64().expect("a number"))
    };
    // The numbers of the examples' pages, in their three digits.
    let close = |value: f64, expected: f64| assert!((value - expected).abs() < 3e-3 * expected.abs(), "{value}");
    let tappet = report("tappet");
    for (name, [least, largest]) in
        [("roller_force", [377.0, 456.0]), ("hertzian_pressure", [313e6, 336e6]), ("torque", [-4.08, 3.62])]
    {
        let [low, high] = range(&tappet, 0, name);
        close(low, least);
        close(high, largest);
    }
    close(range(&tappet, 0, "side_force")[1], 105.0);
    let table = std::fs::read_to_string(folder.join("tappet.csv")).expect("the table");
    let head =
        "phi_deg,roller_force_N,pressure_angle_deg,hertzian_pressure_N_per_mm2,side_force_N,follower_force_N,torque_Nm";
    assert!(table.starts_with(&format!("{head}\n0,")) && table.lines().count() == 1442, "{table}");
    let run = camdrive(&["forces", TAPPET, "-o", text(&folder), "--speed", "2000 rpm"]);
    assert!(run.out.contains("Raise the preload of the return spring from 260 N to 517 N"), "{}", run.out);
    let message =
        format!("error: {TAPPET}: the real follower lifts off its cam at 2000 rpm; this model keeps contact.");
    assert!(run.code == 1 && run.err.replace("\n  ", " ").starts_with(&message), "{}", run.err);
    let run = camdrive(&["forces", TAPPET, "-o", text(&folder), "--speed", "-2000 rpm", "--json"]);
    assert!(
        run.code == 1 && run.err.replace("\n  ", " ").starts_with(&message.replace("2000", "-2000")),
        "{}",
        run.err
    );
    let machine = "examples/sealing_machine/loaded.toml";
    let run = camdrive(&["forces", machine, "-o", text(&folder)]);
    assert_eq!((run.code, run.err.as_str()), (0, ""));
    let sealing = report("sealing_loaded");
    close(range(&sealing, 0, "roller_force_P")[1], 392.0);
    close(range(&sealing, 0, "linkage1_input_pivot")[1], 391.0);
    close(range(&sealing, 1, "roller_force_outer")[1], 2020.0);
    close(range(&sealing, 1, "hertzian_pressure_outer")[1], 467e6);
    assert_eq!([0, 1].map(|j| sealing["drives"][j]["sign_changes"].as_array().map(Vec::len)), [Some(6), Some(2)]);
    let joints = folder.join("sealing_loaded.follower1.linkage2.svg");
    assert!(std::fs::read_to_string(joints).is_ok_and(|svg| svg.contains("rod–slider")));
    assert_diagrams_read_well(&folder);
    // A mechanism bears without a cam that is known as a body.
    let scene = std::fs::read_to_string(root().join(machine)).expect("the scene");
    let bare: Vec<&str> = scene.split("\n\n").filter(|part| !part.contains("geometry")).collect();
    let path = folder.join("bare.toml");
    std::fs::write(&path, bare.join("\n\n").replace("roller_width = \"16 mm\"\n", "")).expect("a file");
    let run = camdrive(&["forces", text(&path), "-o", text(&folder.join("bare"))]);
    assert_eq!((run.code, run.err.as_str()), (0, ""));
    assert!(run.out.contains("the torque on the lever changes sign") && !run.out.contains("roller"), "{}", run.out);
}

#[test]
fn forces_of_drives_without_rollers_and_joints() {
    let folder = folder("forces_bare");
    let machine = "name = \"press\"\nmodel = \"RigidMachine\"\nmachine.J0 = 3\nstart.w_start = \"20 rad/s\"\n";
    let tool = "[[follower]]\nm = 2\ncam = { law = \"fourier\", a = [0, \"-50 mm\"] }\nload.process = \"-30 N\"\n";
    // ½ J′ω² of J = J0 + 0.5 cos 2φ, and m U′U″ω² − P U′ of the tool; each has its largest value at a known angle.
    for (name, more, largest) in [
        ("own", "machine.J = { law = \"fourier\", a = [0, 0, 0.5] }\n", 0.5 * 400.0),
        ("tool", tool, {
            let torque = |phi: f64| 2.0 * 0.05 * 0.05 * 400.0 * 0.5 * (2.0 * phi).sin() + 30.0 * 0.05 * phi.sin();
            (0..400_000).map(|i| torque(f64::from(i) / 4e5 * std::f64::consts::TAU)).fold(0.0, f64::max)
        }),
    ] {
        let (scene, output) = (folder.join("scene.toml"), folder.join(name));
        std::fs::write(&scene, format!("{machine}{more}")).expect("a file");
        let run = camdrive(&["forces", text(&scene), "-o", text(&output), "--speed", "20 rad/s", "--json"]);
        assert_eq!((run.code, run.err.as_str()), (0, ""), "{name}");
        let report: serde_json::Value = serde_json::from_str(&run.out).expect("JSON");
        let found = report["shaft"]["largest"]["value"].as_f64().expect("a torque");
        assert!((found / largest - 1.0).abs() < 1e-9, "{name}: {found} for {largest}");
        let table = std::fs::read_to_string(output.join("press.torque.csv")).expect("the table");
        assert!(table.starts_with("phi_deg,torque_Nm,power_W\n0,"), "{table}");
        let run = camdrive(&["forces", text(&scene), "-o", text(&output), "--speed", "20 rad/s"]);
        let power = format!("peak power {} W", camdrive_design::text::number(20.0 * largest));
        assert!(run.out.contains(&power) && output.join("press.torque.svg").exists(), "{power}: {}", run.out);
    }
    let run = camdrive(&["forces", SCENE, "-o", text(&folder.join("cam"))]);
    assert!(run.code == 0 && run.out.contains("The force on the follower changes sign"), "{}{}", run.out, run.err);
}

/// A press force that was measured every 5° has a step of 10 kN, which no spline rings around, or a peak of 50 kN, which is no lift.
#[test]
fn forces_over_the_turn_are_monotone_or_lines_of_any_size() {
    let folder = folder("forces_lines");
    let peak = |phi: u32| 25e3 * (1.0 - (9.0 * f64::from(phi - 140).to_radians()).cos());
    type Force = Box<dyn Fn(u32) -> f64>;
    let cases: [(u32, Force); 2] = [
        (155, Box::new(|phi| if (155..=180).contains(&phi) { -10e3 } else { 0.0 })),
        (160, Box::new(move |phi| if (140..=180).contains(&phi) { -peak(phi) } else { 0.0 })),
    ];
    for ((highest, force), interpolation) in
        cases.iter().flat_map(|case| ["", ", interpolation = \"linear\""].map(|more| (case, more)))
    {
        let highest = *highest;
        let rows = (0..72).map(|i| format!("{};{:.6}\n", 5 * i, force(5 * i)));
        std::fs::write(folder.join("force.csv"), rows.collect::<String>()).expect("a table");
        let scene = "name = \"press\"\nmodel = \"ElasticCamDrive\"\ncam = { law = \"fourier\", a = [0.04, -0.04] }\n\
            geometry = { follower = \"translating\", roller_radius = 0.03, base_radius = 0.08 }\n\
            load.process = { law = \"table\", file = \"force.csv\", angle_unit = \"deg\", lift_unit = \"N\" MORE }\n\
            load.spring = { preload = 500, c = 1e4 }\ndrive = { speed = \"100 rpm\" }\n\
            elasticity = { place = \"output\", m = 20, natural_frequency = \"100 Hz\", damping_ratio = 1 }\n";
        let path = folder.join("press.toml");
        std::fs::write(&path, scene.replace(" MORE", interpolation)).expect("a scene");
        let run = camdrive(&["forces", text(&path), "-o", text(&folder.join("out")), "--json"]);
        assert_eq!((run.code, run.err.as_str()), (0, ""));
        let report: serde_json::Value = serde_json::from_str(&run.out).expect("JSON");
        let roller = &report["drives"][0]["quantities"][0];
        // N cos α = m ÿ + F_v + c (y − y₀) − P, tan α = U′/(r + U).
        let expected = |deg: u32| {
            let (s, c) = f64::from(deg).to_radians().sin_cos();
            let (u, w) = (0.04 * (1.0 - c), 100.0 * std::f64::consts::TAU / 60.0);
            (0.8 * c * w * w + 500.0 + 1e4 * u - force(deg)) * (1.0_f64).hypot(0.04 * s / (0.11 + u))
        };
        for (end, deg) in [("largest", highest), ("least", 0)] {
            let found = roller[end]["value"].as_f64().expect("a force");
            // The extreme of a curve lies beside its highest point, since the other forces change there.
            let tolerance = if interpolation.is_empty() { 1e-5 } else { 1e-9 };
            assert!((found / expected(deg) - 1.0).abs() < tolerance, "{end}: {found} for {}", expected(deg));
        }
        assert_eq!(report["drives"][0]["sign_changes"], serde_json::json!([]));
    }
}

#[test]
fn what_of_forces_the_motion_leaves_out_is_said() {
    let folder = folder("left_out");
    let left_out = "the real follower lifts off above 1600 rpm; this model keeps contact. To simulate lift-off use a BacklashDrive with s = \"inf\"";
    let note = format!("note: {TAPPET}: {left_out}\n");
    assert_eq!(camdrive(&["check", TAPPET]).err, note);
    let json: serde_json::Value = serde_json::from_str(&camdrive(&["check", TAPPET, "--json"]).out).expect("JSON");
    assert_eq!(json[0]["notes"], serde_json::json!([left_out]));
    let run = camdrive(&["export", TAPPET, "-o", text(&folder), "--runtime", &runtime()]);
    assert!(run.code == 0 && run.err.contains(&note), "{}", run.err);
    let described = format!("Roller tappet of a feed pump with its return spring. T{}.", &left_out[1..]);
    assert!(camdrive(&["describe", TAPPET]).out.contains(&described));
    let described = described.replace('"', "&quot;");
    let xml = camdrive(&["describe", TAPPET, "--xml"]).out;
    assert!(xml.contains(&format!("description=\"{described}\"")), "{xml}");
    let scene = camdrive_cli::scene::read(&root().join(TAPPET)).expect("a scene");
    let mut drive = scene.resource().build().expect("a drive");
    let page = documentation::Page { description: &scene.description, ..Default::default() };
    let page = documentation::html(&scene.resource(), &mut drive, &page).expect("a page");
    // A number stays in the line of its unit.
    assert!(page.replace('\u{a0}', " ").contains(&described));
    // Where force keeps no follower on its cam, no speed is told.
    let machine = "examples/sealing_machine/scene.toml";
    let note = format!("note: {machine}: forces.lever_J is not part of the motion of the FMU\n");
    let told = camdrive(&["check", machine]).err;
    assert!(told.ends_with(&note), "{told}");
    assert_eq!(camdrive(&["check", SCENE]).err, "");
}

#[test]
fn forces_says_what_it_cannot_do() {
    let folder = folder("forces_wrong");
    let geometry = "[geometry]\nfollower = \"translating\"\noffset = \"3 mm\"\nroller_radius = \"8 mm\"\nbase_radius = \"30 mm\"\n";
    let driven = with_geometry(&folder, "speed = \"300 rpm\"", "mode = \"input\"");
    let inputs = folder.join("inputs.toml");
    std::fs::rename(&driven, &inputs).expect("it is there");
    let sharp = geometry.replace("8 mm", "16 mm").replace("base_radius = \"30 mm\"", "prime_radius = \"17 mm\"");
    let pressed = "[forces]\nroller_width = \"9 mm\"\n[load]\nspring.preload = \"1 kN\"\n";
    let undercut = with_geometry(&folder, geometry, &(sharp + pressed));
    let cases: [(&[&str], &[&str]); 6] = [
        (&["examples/rod_drive/scene.toml"], &["ParametricDrive has no cam"]),
        (&[WRONG], &[WRONG]),
        (&[text(&inputs)], &["has no speed", "--speed"]),
        (&[TAPPET, "--speed", "2 mm"], &["--speed", "an angular velocity"]),
        (&[TAPPET, "--speed", "1e200"], &["--speed", "is out of range", "admissible: -1e6 to 1e6 rad/s"]),
        (&[text(&undercut)], &["at φ = ", "the inner contour of valve is undercut", "camdrive cam"]),
    ];
    for (args, parts) in cases {
        let target = folder.join("never");
        let run = camdrive(&[&["forces", "-o", text(&target)], args].concat());
        assert!(is_refused(run.code) && run.out.is_empty(), "{args:?}");
        assert!(parts.iter().all(|part| run.err.contains(part)), "{args:?}: {}", run.err);
        assert!(!target.exists());
    }
    assert_eq!(camdrive(&["forces", text(&inputs), "--speed", "0", "-o", text(&folder.join("rest"))]).code, 0);
}

/// A study of the guide bar over speed and natural frequency, 40 runs in three parts, and a store of it.
fn study(name: &str, more: &str) -> (PathBuf, String) {
    let folder = folder(name);
    let scene = root().join("examples/guide_bar/scene.toml");
    let text = format!(
        r#"
scene = {scene:?}
turns = 3
measures = ["max |q|", "last y"]

[[vary]]
name = "elasticity.natural_frequency"
values = ["270 Hz", "300 Hz"]

[[vary]]
name = "drive.w"
from = "600 rpm"
to = "2400 rpm"
count = 20
{more}"#
    );
    let file = folder.join("study.toml");
    std::fs::write(&file, text).unwrap();
    (folder, file.to_str().unwrap().to_owned())
}

/// The files of the parts of a store.
fn parts(store: &Path) -> BTreeMap<String, Vec<u8>> {
    let files = std::fs::read_dir(store.join("runs")).expect("the parts");
    let file =
        |path: PathBuf| (path.file_name().unwrap().to_string_lossy().into_owned(), std::fs::read(&path).unwrap());
    files.map(|entry| file(entry.unwrap().path())).collect()
}

#[test]
fn a_study_has_the_same_bits_for_any_number_of_threads_and_jobs() {
    let (folder, file) = study("study", "");
    let store = |name: &str| folder.join(name);
    let run = |name: &str, more: &[&str]| camdrive(&[&["study", &file, "-o", text(&store(name))], more].concat());
    let whole = run("one", &["--threads", "1", "--json"]);
    assert_eq!((whole.code, whole.err.as_str()), (0, ""));
    let said: serde_json::Value = serde_json::from_str(&whole.out).unwrap();
    assert_eq!((&said["rows"], &said["ok"], &said["missing_parts"]), (&40.into(), &40.into(), &0.into()));
    let column =
        |i: usize| ["name", "role", "unit"].map(|field| said["columns"][i][field].as_str().unwrap().to_owned());
    assert_eq!(column(1), ["elasticity.natural_frequency", "varied", "Hz"]);
    assert_eq!(column(2), ["drive.w", "varied", "rad/s"]);
    assert_eq!(column(3), ["max |q|", "measured", "m"]);
    let one = parts(&store("one"));
    assert_eq!(one.keys().collect::<Vec<_>>(), ["part-00000.parquet", "part-00001.parquet", "part-00002.parquet"]);
    assert!(one.values().all(|part| part.starts_with(b"PAR1") && part.ends_with(b"PAR1")));
    assert_eq!(run("many", &["--threads", "5"]).code, 0);
    assert_eq!(parts(&store("many")), one);
    for (part, missing) in [("2/3", "2 parts"), ("3/3", "1 part"), ("1/3", "")] {
        let run = run("jobs", &["--part", part]);
        assert!(run.code == 0 && run.out.contains("ok") && run.out.contains(missing), "{}{}", run.out, run.err);
    }
    assert_eq!(parts(&store("jobs")), one);
    // A part that is lost or cut is computed anew, and nothing else.
    std::fs::remove_file(store("many").join("runs/part-00001.parquet")).unwrap();
    std::fs::write(store("many").join("runs/part-00002.parquet"), &one["part-00002.parquet"][..100]).unwrap();
    let there = run("many", &[]);
    assert!(there.code == 1 && there.err.contains("--resume computes the missing runs"), "{}", there.err);
    let resumed = run("many", &["--resume"]);
    assert!(
        resumed.code == 0 && resumed.out.contains("40 runs: 40 ok") && resumed.out.contains(": 24 runs in "),
        "{}",
        resumed.out
    );
    assert_eq!(parts(&store("many")), one);
    let kept = std::fs::read(store("one").join("study.json")).unwrap();
    std::fs::write(&file, std::fs::read_to_string(&file).unwrap().replace("turns = 3", "turns = 4")).unwrap();
    let other = run("one", &["--resume"]);
    assert!(
        other.code == 1 && other.err.contains("store is of another study; they differ in `study`"),
        "{}",
        other.err
    );
    assert!(parts(&store("one")) == one && std::fs::read(store("one").join("study.json")).unwrap() == kept);
}

#[test]
fn runs_that_are_refused_or_fail_are_rows_with_a_message() {
    let (folder, file) =
        study("study_refused", "\n[[vary]]\nname = \"elasticity.damping_ratio\"\nvalues = [0.03, -1]\n");
    let run = camdrive(&["study", &file, "-o", text(&folder.join("store"))]);
    assert!(
        run.code == 0 && run.out.contains("80 runs") && run.out.contains("40 ok, 40 refused, 0 failed"),
        "{}{}",
        run.out,
        run.err
    );
    assert!(run.out.contains("First refused: run 1: `elasticity.damping_ratio`: -1 is out of range"), "{}", run.out);
    let explained = camdrive(&["study", &file, "--explain", "--json"]);
    let said: serde_json::Value = serde_json::from_str(&explained.out).unwrap();
    assert_eq!((&said["rows"], &said["parts"]), (&80.into(), &5.into()));
    assert!(said["seconds"].as_f64().unwrap() > 0.0 && said["bytes"].as_f64().unwrap() > 80.0 * 8.0 * 5.0, "{said}");
    assert!(!root().join("study-study").exists());
}

#[test]
fn rows_of_a_file_and_samples_are_variants() {
    let (folder, file) = study("study_file", "");
    let text_of = |vary: &str| {
        let scene = root().join("examples/guide_bar/scene.toml");
        format!("scene = {scene:?}\ntime = \"20 ms\"\nmeasures = [\"last y\"]\n{vary}")
    };
    std::fs::write(
        folder.join("rows.csv"),
        "# speeds\ndrive.w [rpm],m,start.mode\n1800,12,at_rest\n900,13,steady_state\n",
    )
    .unwrap();
    std::fs::write(&file, text_of("vary = [{ file = \"rows.csv\" }]\n")).unwrap();
    let run = camdrive(&["study", &file, "-o", text(&folder.join("a")), "--json"]);
    let said: serde_json::Value = serde_json::from_str(&run.out).unwrap_or_else(|_| panic!("{}", run.err));
    assert_eq!((&said["rows"], &said["columns"][1]["unit"]), (&2.into(), &"rad/s".into()));
    std::fs::write(folder.join("rows.csv"), "drive.w [rpm],m\n1800,12 m\n").unwrap();
    let run = camdrive(&["study", &file, "-o", text(&folder.join("b"))]);
    assert!(run.code == 1 && run.err.contains("rows.csv, line 2, m") && run.err.contains("is a length"), "{}", run.err);
    let samples = "runs = 50\nvary = [{ name = \"m\", deviation = \"100 g\" }, { name = \"c\", from = 3e7, to = 4e7, scale = \"log\" }]\n";
    for (name, seed) in [("c", ""), ("d", ""), ("e", "seed = 2\n")] {
        std::fs::write(&file, text_of(&format!("{seed}{samples}"))).unwrap();
        let run = camdrive(&["study", &file, "-o", text(&folder.join(name))]);
        assert!(run.code == 0 && run.out.contains("50 ok"), "{}{}", run.out, run.err);
    }
    assert!(
        parts(&folder.join("c")) == parts(&folder.join("d")) && parts(&folder.join("c")) != parts(&folder.join("e"))
    );
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_keeps_the_parts_before() {
    let (folder, file) = study("study_full", "");
    let store = folder.join("store");
    assert_eq!(camdrive(&["study", &file, "-o", text(&store), "--part", "1/3"]).code, 0);
    let before = parts(&store);
    // Nothing larger than a kibibyte can be written.
    let command = format!("ulimit -f 1; exec \"$0\" study '{file}' -o '{}' --resume", text(&store));
    let output =
        Command::new("bash").args(["-c", &command, env!("CARGO_BIN_EXE_camdrive")]).output().expect("bash starts");
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(
        output.status.code() == Some(1) && said.contains("cannot be written") && said.contains("--resume"),
        "{said}"
    );
    assert_eq!(parts(&store), before);
    assert_eq!(camdrive(&["study", &file, "-o", text(&store), "--resume"]).code, 0);
    assert_eq!(parts(&store).len(), 3);
}

#[test]
fn turns_of_a_driven_train_and_loads_that_do_not_hold_are_measured() {
    let folder = folder("study_train");
    let (file, store) = (folder.join("study.toml"), folder.join("store"));
    let run = |scene: &str, measures: &str, vary: &str| {
        let scene = root().join("examples").join(scene).join("scene.toml");
        let content = format!("scene = {scene:?}\nturns = 2.5\nmeasures = {measures}\nvary = [{vary}]\n");
        std::fs::write(&file, content).unwrap();
        let _ = std::fs::remove_dir_all(&store);
        let run = camdrive(&["study", text(&file), "-o", text(&store)]);
        assert!(run.code == 0 && run.out.contains(" 0 refused, 0 failed"), "{}{}", run.out, run.err);
        run.out
    };
    // Two turns and a half, and half of that.
    let out = run("valve_train", r#"["max phi", "mean phi"]"#, r#"{ name = "drive.w", values = ["1600 rpm"] }"#);
    assert!(out.contains("max phi: 900°") && out.contains("mean phi: 450°"), "{out}");
    // The contact force of the tappet changes its sign at this speed, which its drive tells at every communication point.
    run("tappet", r#"["max force"]"#, r#"{ name = "drive.w", values = [200] }"#);
}

/// A study over a file, with these lines; and its store.
fn study_over(folder: &Path, scene: &Path, store: &str, lines: &str) -> (PathBuf, PathBuf) {
    let (file, store) = (folder.join(format!("{store}.toml")), folder.join(store));
    std::fs::write(&file, format!("scene = {scene:?}\n{lines}")).unwrap();
    let _ = std::fs::remove_dir_all(&store);
    (file, store)
}

/// Measures of a study of one run.
fn measured(folder: &Path, scene: &Path, lines: &str) -> Vec<f64> {
    let (file, store) = study_over(folder, scene, "single", lines);
    let run = camdrive(&["study", text(&file), "-o", text(&store), "--json"]);
    let said: serde_json::Value = serde_json::from_str(&run.out).unwrap_or_else(|_| panic!("{}", run.err));
    assert_eq!(said["ok"], 1, "{}", run.out);
    said["measures"].as_array().unwrap().iter().map(|of| of["least"].as_f64().unwrap()).collect()
}

/// The last row of a run.
fn last_row(args: &[&str]) -> Vec<f64> {
    let run = camdrive(&[&["run"], args].concat());
    assert_eq!(run.code, 0, "{}", run.err);
    run.out.lines().last().unwrap().split(',').map(|number| number.parse().unwrap()).collect()
}

#[test]
fn a_study_of_a_system_has_the_bits_of_single_runs() {
    let folder = folder("study_system");
    let system = root().join("examples/two_cams/system.toml");
    let ssp = camdrive(&["system", text(&system), "-o", text(&folder.join("ssp")), "--json"]);
    assert_eq!(ssp.code, 0, "{}", ssp.err);
    let last = "measures = [\"last machine.w\", \"last pusher.q\", \"last gripper.tau\", \"last machine.phi\"]\n";
    let outputs = ["--output", "machine.w,pusher.q,gripper.tau,machine.phi", "--stop", "0.1005"];
    for file in [&system, &folder.join("ssp/two_cams.ssp")] {
        for (speed, mass) in [("200 rpm", "3 kg"), ("31 rad/s", "4100 g")] {
            let vary = format!(
                "time = \"100.5 ms\"\nstep = \"1 ms\"\n{last}vary = [{{ name = \"machine.w_start\", values = [{speed:?}] }}, {{ name = \"pusher.m\", values = [{mass:?}] }}]"
            );
            let [speed, mass] = [format!("machine.w_start={speed}"), format!("pusher.m={mass}")];
            let single = last_row(
                &[&[text(file), "--step", "1e-3", "--start", &speed, "--start", &mass], &outputs[..]].concat(),
            );
            assert_eq!(measured(&folder, file, &vary), single[1..], "{}", file.display());
        }
    }
    // Keys of a part's scene and of the system, against files that have these values.
    let vary = "time = \"100.5 ms\"\nstep = \"0.5 ms\"\nvary = [{ name = \"pusher.elasticity.natural_frequency\", values = [\"90 Hz\"] }, \
                { name = \"part.gripper.ratio\", values = [3] }, { name = \"machine.machine.J0\", values = [\"1.5 kg.m2\"] }]\n";
    for name in ["machine.toml", "pusher.toml", "gripper.toml", "system.toml"] {
        let content = std::fs::read_to_string(root().join("examples/two_cams").join(name)).unwrap();
        let changed = content.replace("80 Hz", "90 Hz").replace("ratio = 2", "ratio = 3");
        let changed = changed.replace("1.2 kg.m2", "1.5 kg.m2");
        std::fs::write(folder.join(name), changed).unwrap();
    }
    let single = last_row(&[&[text(&folder.join("system.toml")), "--step", "0.5 ms"], &outputs[..]].concat());
    assert_eq!(measured(&folder, &system, &format!("{last}{vary}")), single[1..]);
}

#[test]
fn a_study_of_a_system_has_the_same_bytes_for_any_number_of_threads_and_jobs() {
    let folder = folder("study_system_threads");
    let lines = r#"
turns = 0.3
settle = "5 ms"
measures = ["max |pusher.q|", "mean gripper.tau", "machine.w at 20 deg"]
[[vary]]
name = "machine.w_start"
values = ["200 rpm", "1e12 rpm"]
[[vary]]
name = "gripper.elasticity.damping_ratio"
values = [0.03, -1]
[[vary]]
name = "pusher.m"
from = "2 kg"
to = "4 kg"
count = 10
"#;
    let (file, store) = study_over(&folder, &root().join("examples/two_cams/system.toml"), "one", lines);
    let run = |store: &Path, more: &[&str]| camdrive(&[&["study", text(&file), "-o", text(store)], more].concat());
    let whole = run(&store, &["--threads", "1"]);
    assert!(whole.code == 0 && whole.out.contains("10 ok, 30 refused, 0 failed"), "{}{}", whole.out, whole.err);
    let first = "First refused: run 10: ";
    assert!(
        whole.out.contains(first) && whole.out.contains("gripper.toml: `elasticity.damping_ratio`: -1"),
        "{}",
        whole.out
    );
    let one = parts(&store);
    let other = folder.join("other");
    let _ = std::fs::remove_dir_all(&other);
    assert_eq!(run(&other, &["--part", "2/2", "--threads", "3"]).code, 0);
    assert_eq!(run(&other, &["--resume", "--threads", "5"]).code, 0);
    assert!(one.len() == 3 && parts(&other) == one);
}

#[test]
fn a_study_of_an_fmu_measures_what_its_scene_does() {
    let folder = folder("study_fmu");
    let scene = root().join("examples/guide_bar/scene.toml");
    let fmu = folder.join("guide_bar.fmu");
    assert_eq!(camdrive(&["export", text(&scene), "-o", text(&fmu), "--runtime", &runtime()]).code, 0);
    let lines = "turns = 2\nsettle = 0.3\nvary = { name = \"drive.w\", values = [\"1500 rpm\"] }\nmeasures = [\"max |q|\", \
                 \"min q\", \"rms q\", \"last q\", \"q at 200 deg\", \"harmonic 7 of q\", \"max phi\"]\n";
    let lines = lines.replace("vary = {", "vary = [{").replace("] }\n", "] }]\n");
    let [of_fmu, of_scene] = [&fmu, &scene].map(|file| measured(&folder, file, &lines));
    for (a, b) in of_fmu.iter().zip(&of_scene) {
        assert!((a - b).abs() < 1e-6 * b.abs().max(of_scene[0]), "{of_fmu:?} {of_scene:?}");
    }
    // The store knows the FMU.
    let (file, store) = study_over(&folder, &fmu, "resumed", &lines);
    let run = |more: &[&str]| camdrive(&[&["study", text(&file), "-o", text(&store)], more].concat());
    assert_eq!((run(&[]).code, run(&["--resume"]).code), (0, 0));
    let other = root().join("examples/guide_bar/traditional.toml");
    assert_eq!(camdrive(&["export", text(&other), "-o", text(&fmu), "--runtime", &runtime()]).code, 0);
    let mixed = run(&["--resume"]);
    assert!(mixed.code == 1 && mixed.err.contains("another study; they differ in `tables`"), "{}", mixed.err);
}

#[test]
fn a_study_of_an_fmu_of_another_maker() {
    let folder = folder("study_foreign");
    let fmu = cart(&folder, "false\" canBeInstantiatedOnlyOncePerProcess=\"true");
    let lines = "time = \"1 s\"\nstep = \"0.3 s\"\nmeasures = [\"last x\", \"mean x\", \"min x\"]\nvary = [{ name = \"u\", values = \
                 [\"2 mm/s\", \"0.0025 m/s\", \"4 mm/s\", \"1 m/s\"] }, { name = \"T\", values = [\"68 degF\"] }]\n";
    let (file, store) = study_over(&folder, &fmu, "store", lines);
    let run = camdrive(&["study", text(&file), "-o", text(&store), "--threads", "4", "--json"]);
    let said: serde_json::Value = serde_json::from_str(&run.out).unwrap_or_else(|_| panic!("{}", run.err));
    assert_eq!(
        [&said["threads"], &said["ok"], &said["refused"], &said["failed"]].map(|n| n.as_u64()),
        [4, 3, 1, 0].map(Some)
    );
    // x = 1.5 mm + u t; the mean over a second is that at its half. The end lies within a step. At 4 mm/s the cart ends the simulation
    // at 0.6 s.
    let of = |measure: usize, which: &str| said["measures"][measure][which].as_f64().unwrap();
    let found = [of(0, "least"), of(0, "largest"), of(1, "least"), of(1, "largest"), of(2, "largest")];
    let expected = [3.5e-3, 4e-3, 2.5e-3, 2.75e-3, 1.5e-3];
    assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12), "{found:?}");
    assert_eq!((&said["columns"][1]["unit"], &said["columns"][2]["unit"]), (&"m.s-1".into(), &"K".into()));
    std::fs::remove_dir_all(&store).unwrap();
    let run = camdrive(&["study", text(&file), "-o", text(&store)]);
    for said in
        ["First ended early: run 2: from t = 0.6 s to 0.8", "ends the simulation", "First refused: run 3: `u`: 1 "]
    {
        assert!(run.out.contains(said), "{said}: {}", run.out);
    }
    let without = lines.replace("step = \"0.3 s\"\n", "");
    let (file, store) = study_over(&folder, &fmu, "without", &without);
    let run = camdrive(&["study", text(&file), "-o", text(&store)]);
    assert!(run.code == 1 && run.err.contains("`step` is missing") && !store.exists(), "{}", run.err);
}

/// An elastic shaft with J/J0 = 0.9 is stable up to 16.7 ms without repeated steps, and up to 65.7 ms with one repetition.
#[test]
fn a_step_that_is_too_long_is_told_the_longest_one_that_is_taken() {
    let folder = folder("longest");
    let load = "name = \"d\"\nmodel = \"ElasticCamDrive\"\ncam = { law = \"fourier\", a = [0.0, 1e-3] }\ndrive = { mode = \"input\" }\n\
                elasticity = { place = \"shaft\", J = 0.9, m = 1e-9, c = 1000, b = 0.3 }\nstart = { mode = \"given\", q = 1e-6 }\n";
    std::fs::write(folder.join("d.toml"), load).unwrap();
    std::fs::write(
        folder.join("m.toml"),
        "name = \"m\"\nmodel = \"RigidMachine\"\nmachine = { J0 = 1 }\nmotor = { kind = \"none\" }\n",
    )
    .unwrap();
    let check = |step: f64, repeat: &str| {
        let parts = "exchange = \"interpolated\"\npart.m = { scene = \"m.toml\", start = { w_start = 0.01 } }\npart.d = { scene = \"d.toml\", shaft = \"m\" }\n";
        let system = folder.join("s.toml");
        std::fs::write(&system, format!("name = \"s\"\nstop = {}\nstep = {step}\n{repeat}{parts}", 100.0 * step))
            .unwrap();
        camdrive(&["check", text(&system)])
    };
    for (step, repeat, most) in
        [(0.08, "", "65.7 ms"), (0.08, "repeat = 1\n", "65.7 ms"), (0.02, "repeat = 0\n", "16.7 ms")]
    {
        let run = check(step, repeat);
        assert!(is_refused(run.code) && run.err.contains(&format!("at most {most}")), "{step} {repeat}: {}", run.err);
    }
    for (step, repeat) in [(0.065, ""), (0.016, "repeat = 0\n")] {
        assert_eq!(check(step, repeat).code, 0, "{step} {repeat}");
    }
}

#[test]
fn values_that_make_a_step_unstable_are_refused() {
    let folder = folder("unstable");
    let system = "examples/two_cams/system.toml";
    // 0.02 kg·m² admit 8 ms, the 1.2 kg·m² of the scene much more.
    for (system, start, step, said) in [
        (system, "machine.J0=1e-4", "1 ms", "--start: at 1 ms the exchange on the shaft of `machine` is unstable"),
        (system, "machine.J0=0.02", "20 ms", "--start: at 20 ms the exchange on the shaft of `machine` is unstable"),
        ("examples/loom/system.toml", "machine.J0=2", "20 ms", "--step: at 20 ms the exchange on the shaft of"),
    ] {
        let run = camdrive(&["run", system, "--start", start, "--step", step, "--output", "machine.w"]);
        assert!(is_refused(run.code) && run.out.is_empty() && run.err.contains(said), "{start}: {}", run.err);
    }
    let run = camdrive(&["run", system, "--start", "machine.J0=100", "--step", "100 ms", "--output", "machine.w"]);
    assert_eq!(run.code, 0, "{}", run.err);
    let file = folder.join("study.toml");
    let place = root().join(system);
    let vary = "[[vary]]\nname = \"machine.J0\"\nvalues = [1e-4, 1.2, -1]\n";
    let text_of = format!("scene = {:?}\ntime = \"10 ms\"\nmeasures = [\"max machine.w\"]\n{vary}", text(&place));
    std::fs::write(&file, text_of).expect("a study");
    let study = camdrive(&["study", text(&file), "-o", text(&folder.join("store"))]);
    let told = study.out.clone() + &study.err;
    assert!(study.code == 0 && told.contains("1 ok, 2 refused") && told.contains("is unstable"), "{told}");
    // A value out of its range is told as such.
    std::fs::write(&file, std::fs::read_to_string(&file).unwrap().replace("1e-4, 1.2, -1", "-1")).expect("a study");
    let study = camdrive(&["study", text(&file), "-o", text(&folder.join("other"))]);
    let told = study.out + &study.err;
    assert!(told.contains("`machine.J0`: -1 ") && told.contains("is not admissible"), "{told}");
}

#[test]
fn torques_are_connected_once_and_with_their_impulses() {
    let folder = folder("torques");
    let parts = root().join("examples/backlash_machine");
    let part = |name: &str| format!("[part.{name}]\nscene = {:?}\n", text(&parts.join(format!("{name}.toml"))));
    let wire = |from: &str, to: &str| format!("[[connection]]\nfrom = \"{from}\"\nto = \"{to}\"\n");
    let head = format!("name = \"torques\"\nstop = 0.1\nstep = 1e-4\n{}{}", part("machine"), part("pusher"));
    let file = folder.join("system.toml");
    let check = |rest: &str| {
        std::fs::write(&file, format!("{head}{rest}")).expect("a system");
        camdrive(&["check", text(&file)])
    };
    let motion: String =
        ["phi", "w", "a"].map(|name| wire(&format!("machine.{name}"), &format!("pusher.{name}"))).concat();
    let plain = check(&format!("{motion}{}", wire("pusher.tau", "machine.tau")));
    assert!(plain.code == 0 && plain.err.contains("`pusher.tau` is without impulses"), "{}", plain.err);
    let mean = wire("pusher.tau_mean", "machine.tau");
    let whole = check(&format!("{motion}{mean}"));
    assert!(whole.code == 0 && !whole.err.contains("impulses"), "{}", whole.err);
    // By its shaft and by a connection, or by two connections, with impulses or without.
    let both = [mean, wire("pusher.tau", "machine.tau")];
    for (name, connection) in ["tau_mean", "tau"].into_iter().zip(&both) {
        for rest in [format!("shaft = \"machine\"\n{connection}"), format!("{motion}{}{connection}", both.concat())] {
            let twice = check(&rest);
            let said = format!("`pusher.{name}` acts on `machine` already");
            assert!(twice.code == 1 && twice.err.contains(&said), "{said}: {}", twice.err);
        }
    }
}

#[test]
fn files_of_another_kind_are_named_with_the_command_that_takes_them() {
    let files = [
        ("examples/guide_bar/study.toml", "this is a study", "study", &["study", "report"][..]),
        ("examples/two_cams/system.toml", "this is a system", "run", &["system", "check", "run", "report"]),
        ("examples/dwell_synthesis/task.toml", "this is a motion task", "synthesize", &["synthesize"]),
    ];
    let commands = [
        "check",
        "describe",
        "export",
        "run",
        "forces",
        "cam",
        "clearance",
        "stability",
        "steady",
        "tradeoff",
        "compensate",
        "synthesize",
        "study",
        "system",
        "report",
        "verify",
    ];
    for (file, what, taker, takers) in files {
        for command in commands.into_iter().filter(|command| !takers.contains(command)) {
            let run = camdrive(&[command, file]);
            assert!(run.code == 1 && run.err.contains(what), "{command} {file}: {}", run.err);
            let hint = [format!("`camdrive {taker} "), format!("`{taker}` take it")];
            assert!(hint.iter().any(|hint| run.err.contains(hint)), "{command} {file}: {}", run.err);
        }
    }
}

#[test]
fn a_study_tells_what_numbers_without_a_unit_mean() {
    let folder = folder("study_units");
    let scene = root().join("examples/guide_bar/scene.toml");
    let explain = |vary: &str| {
        let file = folder.join("study.toml");
        let study = format!("scene = {:?}\nturns = 1\nmeasures = [\"max |q|\"]\nvary = [{{ {vary} }}]\n", text(&scene));
        std::fs::write(&file, study).expect("a study");
        let run = camdrive(&["study", text(&file), "--explain", "-o", text(&folder.join("store"))]);
        assert_eq!(run.code, 0, "{}", run.err);
        run.err.split_whitespace().collect::<Vec<_>>().join(" ")
    };
    for name in ["drive.w", "drive.speed"] {
        let plain = explain(&format!("name = \"{name}\", values = [900, 1200]"));
        assert!(
            plain.contains(&format!(
                "`{name}` without a unit is in rad/s: 900 to 1200 rad/s, which is 8590 to 11500 rpm"
            )),
            "{plain}"
        );
        assert!(plain.contains("run 0: ") && plain.contains("the tool would hardly follow the cam"), "{plain}");
        assert_eq!(explain(&format!("name = \"{name}\", values = [\"900 rpm\", \"1200 rpm\"]")), "");
    }
}

/// A torque that acts with another factor than the motion, on the shaft itself or through another part.
#[test]
fn work_that_is_lost_between_a_drive_and_its_shaft_is_told() {
    let folder = folder("balance");
    let parts = root().join("examples/two_cams");
    let part = |name: &str| format!("[part.{name}]\nscene = {:?}\n", text(&parts.join(format!("{name}.toml"))));
    let wire = |from: &str, to: &str, factor: u8| {
        format!("[[connection]]\nfrom = \"{from}\"\nto = \"{to}\"\nfactor = {factor}\n")
    };
    let motion: String =
        ["phi", "w", "a"].map(|name| wire(&format!("machine.{name}"), &format!("pusher.{name}"), 2)).concat();
    // τ = m h² a at φ = 90°: what comes in goes out.
    let scales = foreign_drive(&folder, "", ["rad", "rad/s", "N.m", "N.m"]).replace("h = 0.03", "h = 1");
    let gear = format!("[part.gear]\nfmu = \"drive.fmu\"\nstart = {{ phi = \"90 deg\", m = 1, {scales} }}\n");
    let head = format!("name = \"balance\"\nstop = 0.2\nstep = 1e-3\n{}{}", part("machine"), part("pusher"));
    let file = folder.join("system.toml");
    let ran = |command: &str, rest: &str| {
        std::fs::write(&file, format!("{head}{rest}")).expect("a system");
        let run = camdrive(&[command, text(&file)]);
        assert_eq!(run.code, 0, "{}", run.err);
        (run.out + &run.err).split_whitespace().collect::<Vec<_>>().join(" ")
    };
    let direct = |factor: u8| format!("{motion}{}", wire("pusher.tau", "machine.tau", factor));
    let by_gear = |factor: u8| {
        format!("{gear}{motion}{}{}", wire("pusher.tau", "gear.a", 1), wire("gear.tau", "machine.tau", factor))
    };
    let lost = " J of work are exchanged; the shaft of machine gives ";
    let check = ran("check", &direct(1));
    assert!(
        check.contains("pusher.tau acts on machine with the factor 1; with 2") && !check.contains("No fault"),
        "{check}"
    );
    let told = ran("run", &direct(1));
    assert!(told.contains("acts on machine with the factor 1") && told.contains(lost), "{told}");
    let told = ran("run", &by_gear(1));
    assert!(told.contains(lost) && told.contains("through gear"), "{told}");
    assert!(ran("check", &direct(2)).contains("No fault"));
    for right in [direct(2), by_gear(2)] {
        let told = ran("run", &right);
        assert!(!told.contains(lost), "{told}");
    }
}

#[test]
fn shafts_convert_the_units_of_fmus() {
    let folder = folder("units_of_shafts");
    let parts = root().join("examples/two_cams");
    let fmu = folder.join("pusher.fmu");
    let scene = parts.join("pusher.toml");
    assert_eq!(camdrive(&["export", text(&scene), "-o", text(&fmu), "--runtime", &runtime()]).code, 0);
    let mut files = unzipped(&fmu);
    let description = String::from_utf8(files.remove("modelDescription.xml").expect("it")).expect("text");
    let (head, tail) = description.split_once("name=\"w\"").expect("w");
    let tail = tail.replacen("unit=\"rad/s\"", "unit=\"U/min\"", 1);
    let unit = "<UnitDefinitions>\n    <Unit name=\"U/min\"><BaseUnit s=\"-1\" rad=\"1\" factor=\"0.1047197551196598\"/></Unit>";
    let changed = format!("{head}name=\"w\"{tail}").replacen("<UnitDefinitions>", unit, 1);
    files.insert("modelDescription.xml".to_owned(), changed.into_bytes());
    zipped(&fmu, &files);
    let machine = format!("[part.machine]\nscene = {:?}\n", text(&parts.join("machine.toml")));
    let drive = "[part.pusher]\nfmu = \"pusher.fmu\"\nshaft = \"machine\"\nratio = 2\n";
    let file = folder.join("system.toml");
    std::fs::write(&file, format!("name = \"units\"\nstop = 0.1\nstep = 1e-3\n{machine}{drive}")).expect("a system");
    let check = camdrive(&["check", text(&file), "--json"]);
    let found: serde_json::Value = serde_json::from_str(&check.out).expect("JSON");
    let factor = |name: &str| {
        let all = found[0]["connections"].as_array().expect("connections");
        all.iter().find(|c| c["to"] == name).and_then(|c| c["factor"].as_f64()).expect("a factor")
    };
    assert!((factor("pusher.w") / (2.0 * 30.0 / std::f64::consts::PI) - 1.0).abs() < 1e-12, "{}", check.out);
    assert!(factor("pusher.phi") == 2.0 && factor("pusher.a") == 2.0 && factor("machine.tau") == 2.0, "{}", check.out);
    // It is a shaft all the same.
    assert!(found[0]["shafts"][0]["limit"]["frequency"].as_f64().expect("rad/s") > 0.0, "{}", check.out);
}

#[test]
fn a_run_of_a_system_tells_the_step_that_is_needed() {
    let folder = folder("needed");
    let parts = root().join("examples/two_cams");
    let system = std::fs::read_to_string(parts.join("system.toml")).expect("a file");
    let of_parts = system.replace("scene = \"", &format!("scene = \"{}/", text(&parts)));
    let file = folder.join("held.toml");
    std::fs::write(&file, of_parts.replacen("step =", "exchange = \"held\"\nstep =", 1)).expect("a system");
    let shared = |step: f64| {
        let diagram = folder.join("run.svg");
        let step = step.to_string();
        let options = ["--step", &step, "--stop", "0.3", "--json", "--output", "machine.w,pusher.q", "--diagram"];
        let run = camdrive(&[&["run", text(&file)][..], &options, &[text(&diagram)]].concat());
        assert_eq!(run.code, 0, "{}", run.err);
        let svg = std::fs::read_to_string(diagram).expect("a diagram");
        assert!(svg.contains("machine.w [rpm]") && svg.contains("pusher.q ["), "{svg}");
        serde_json::from_str::<serde_json::Value>(&run.out).expect("JSON")["shared"].clone()
    };
    let number = |value: &serde_json::Value| value.as_f64();
    let at_first = shared(1e-3);
    for (i, drive) in ["pusher", "gripper"].into_iter().enumerate() {
        assert_eq!((&at_first[i]["shaft"], &at_first[i]["drive"]), (&"machine".into(), &drive.into()));
        let needed = number(&at_first[i]["needed_step"]).expect("a shorter step");
        let then = &shared(needed)[i];
        let part = number(&then["difference"]).expect("J") / number(&then["exchanged"]).expect("J");
        assert!((0.7e-3..1.4e-3).contains(&part), "{drive}: {part} at {needed} s");
    }
    for (option, said) in [("plot.png", "expected a file NAME.svg"), ("-", "--diagram -: --diagram takes a file")] {
        let run = camdrive(&["run", text(&file), "--diagram", option]);
        assert!(is_refused(run.code) && run.err.contains(said), "{}", run.err);
    }
}

/// A system in this folder: its file and its archive.
fn two_cams(folder: &Path) -> [PathBuf; 2] {
    let read = |name: &str| std::fs::read(root().join("examples/two_cams").join(name)).expect("a file");
    for name in ["machine.toml", "pusher.toml", "gripper.toml", "system.toml"] {
        std::fs::write(folder.join(name), read(name)).expect("a file");
    }
    let file = folder.join("system.toml");
    let written = camdrive(&["system", text(&file), "-o", text(folder)]);
    assert_eq!(written.code, 0, "{}", written.err);
    [file, folder.join("two_cams.ssp")]
}

/// A system as its file says it, by the drives in the tool, and as an archive, by the libraries of its FMUs.
#[test]
fn a_system_runs_alike_from_its_file_and_from_its_archive() {
    let folder = folder("system");
    let [file, ssp] = two_cams(&folder);
    let file = text(&file);
    let options = ["--step", "1 ms", "--stop", "0.1 s"];
    let [of_file, of_archive] = [file, text(&ssp)].map(|path| camdrive(&[&["run", path][..], &options].concat()));
    assert!(of_file.code == 0 && of_file.out.lines().count() == 102, "{}", of_file.err);
    assert_eq!(of_file.out, of_archive.out, "{}", of_archive.err);
    assert!(of_file.err.contains("machine and pusher: ") && of_file.err == of_archive.err, "{}", of_archive.err);
    for (option, said) in [
        (["--start", "gripper.phi=1"], "the input is connected"),
        (["--step", "1 s"], "--step: at 1 s the exchange on the shaft of `machine` is unstable"),
    ] {
        let run = camdrive(&[&["run", "examples/loom/system.toml"][..], &option].concat());
        assert!(is_refused(run.code) && run.out.is_empty() && run.err.contains(said), "{option:?}: {}", run.err);
    }
    // The FMUs in the archive hold their scenes.
    let run = camdrive(&["run", text(&ssp), "--start", "machine.J0=1e-4"]);
    assert!(is_refused(run.code) && run.err.contains("--start: at 1.2 ms the exchange on the shaft"), "{}", run.err);
    let check = camdrive(&["check", text(&ssp)]);
    assert!(check.code == 0 && check.out.contains("two_cams.ssp: system of 3 parts ok"), "{}{}", check.out, check.err);
}

/// Changes of the structure of [`two_cams`] that no system has: what is replaced by what.
fn wrong_structures() -> Vec<(&'static str, String)> {
    let element = |what: &str| format!("<ssd:Elements>{what}");
    let binding = |what: &str| {
        format!(
            "<ssd:Elements><ssd:Component name=\"b\" source=\"resources/pusher.fmu\"><ssd:ParameterBindings>\
             <ssd:ParameterBinding {what}</ssd:ParameterBindings></ssd:Component>"
        )
    };
    let value = |what: &str| {
        let set = "><ssd:ParameterValues><ssv:ParameterSet version=\"1.0\" name=\"s\"><ssv:Parameters>";
        binding(&format!(
            "{set}<ssv:Parameter name=\"m\">{what}</ssv:Parameter></ssv:Parameters></ssv:ParameterSet>\
             </ssd:ParameterValues></ssd:ParameterBinding>"
        ))
    };
    vec![
        ("startElement=\"machine\"", "startElement=\"motor\"".to_owned()),
        ("startElement=\"machine\" ", String::new()),
        ("endConnector=\"phi\"", "endConnector=\"psi\"".to_owned()),
        ("factor=\"", "factor=\"1e999".to_owned()),
        ("<ssc:LinearTransformation", "<ssc:BooleanMappingTransformation/><ssc:LinearTransformation".to_owned()),
        ("<ssc:LinearTransformation", "<ssc:EnumerationMappingTransformation/><ssc:LinearTransformation".to_owned()),
        ("\"1.0\" name=\"two_cams\" gen", "\"2.0\" name=\"two_cams\" gen".to_owned()),
        ("name=\"w_start\"", "name=\"w_begin\"".to_owned()),
        ("resources/pusher.fmu", "resources/other.fmu".to_owned()),
        ("resources/pusher.fmu", "../pusher.fmu".to_owned()),
        ("resources/pusher.fmu", "%2e%2e/pusher.fmu".to_owned()),
        ("resources/pusher.fmu", "file:///pusher.fmu".to_owned()),
        ("resources/pusher.fmu", "resources/100%.fmu".to_owned()),
        ("resources/pusher.fmu", "set.ssv".to_owned()),
        ("application/x-fmu-sharedlibrary", "application/x-ssp-package".to_owned()),
        ("implementation=\"CoSimulation\"", "implementation=\"ModelExchange\"".to_owned()),
        ("name=\"pusher\"", "name=\"machine\"".to_owned()),
        ("startTime=\"", "startTime=\"1".to_owned()),
        (" stopTime=\"1.2\"", " stopTime=\"-1\"".to_owned()),
        ("<ssd:Elements>", element("<ssd:System name=\"inner\"/>")),
        ("<ssd:Elements>", element("<ssd:SignalDictionaryReference name=\"bus\" dictionary=\"d\"/>")),
        ("<ssd:Elements>", "<ssd:SignalDictionaries/><ssd:Elements>".to_owned()),
        ("<ssd:Elements>", binding("source=\"none.ssv\"/>")),
        ("<ssd:Elements>", binding("source=\"set.ssv\"/>")),
        ("<ssd:Elements>", binding("source=\"https://example.org/set.ssv\"/>")),
        ("<ssd:Elements>", binding("source=\"set.ssv\" sourceBase=\"component\"/>")),
        ("<ssd:Elements>", binding("source=\"set.csv\" type=\"text/csv\"/>")),
        ("<ssd:Elements>", binding("/>")),
        ("<ssd:Elements>", binding("source=\"set.ssv\"><ssd:ParameterMapping/></ssd:ParameterBinding>")),
        ("<ssd:Elements>", value("<ssv:Real value=\"3\" unit=\"lb\"/>")),
        ("<ssd:Elements>", value("<ssv:Real value=\"-3\"/>")),
        ("<ssd:Elements>", value("<ssv:String value=\"heavy\"/>")),
        ("<ssd:Connections>", "<ssd:Connections".to_owned()),
    ]
}

/// The file with the messages is written anew by BLESS=1.
#[test]
fn a_wrong_archive_of_a_system_is_refused_with_its_reason() {
    let folder = folder("wrong_system");
    let [_, ssp] = two_cams(&folder);
    let mut files = unzipped(&ssp);
    let structure = String::from_utf8(files.remove("SystemStructure.ssd").expect("the structure")).expect("text");
    let machine = files["resources/machine.fmu"].clone();
    files.insert("my parts/machine 1.fmu".to_owned(), machine);
    files.insert("set.ssv".to_owned(), b"<ParameterSet version=\"2.0\" name=\"s\"/>".to_vec());
    let mut changed = |from: &str, to: &str| {
        assert!(structure.contains(from), "{from}");
        files.insert("SystemStructure.ssd".to_owned(), structure.replacen(from, to, 1).into_bytes());
        let run = camdrive(&["run", &zipped(&folder.join("changed.ssp"), &files), "--stop", "2 ms"]);
        (run.code, run.err.replace(&*folder.to_string_lossy(), "").replace('\\', "/"))
    };
    assert_eq!(changed("source=\"resources/machine.fmu\"", "source=\"my%20parts/machine%201.fmu\"").0, 0);
    let (code, err) = changed(" stopTime=\"1.2\"", "");
    assert!(code == 0 && err.contains("has no stopTime, so the run ends at 1 s"), "{err}");
    let mut said = String::new();
    for (from, to) in wrong_structures() {
        let (code, err) = changed(from, &to);
        assert_eq!(code, 1, "{from} → {to}");
        said += &format!("# {from} → {to}\n{err}\n");
    }
    files.remove("SystemStructure.ssd");
    let empty = BTreeMap::new();
    for (name, files) in [("no_structure.ssp", &files), ("empty.ssp", &empty)] {
        let run = camdrive(&["run", &zipped(&folder.join(name), files)]);
        assert!(is_refused(run.code));
        said += &format!("# {name}\n{}\n", run.err.replace(&*folder.to_string_lossy(), "").replace('\\', "/"));
    }
    std::fs::write(folder.join("none.ssp"), "none").expect("a file");
    for command in ["run", "check"] {
        let run = camdrive(&[command, text(&folder.join("none.ssp"))]);
        assert!(
            is_refused(run.code) && run.err.contains("this is no zip archive") && run.err.contains("none.ssp\n"),
            "{}",
            run.err
        );
    }
    let stored = root().join("tests/ssp.txt");
    if std::env::var_os("BLESS").is_some_and(|v| v == "1") {
        std::fs::write(&stored, &said).expect("the messages");
    }
    assert!(std::fs::read_to_string(&stored).unwrap_or_default().replace("\r\n", "\n") == said, "now:\n{said}");
}

/// FMUs that hold their scenes are wired, judged and repeated as the scenes are.
#[test]
fn fmus_of_scenes_are_judged_as_the_scenes() {
    let folder = folder("judged");
    let written = camdrive(&["system", "examples/two_cams/system.toml", "-o", text(&folder)]);
    assert_eq!(written.code, 0, "{}", written.err);
    let given = std::fs::read_to_string(root().join("examples/two_cams/system.toml")).expect("a system");
    let mut of_fmus = given.clone();
    for name in ["machine", "pusher", "gripper"] {
        of_fmus = of_fmus.replace(&format!("scene = \"{name}.toml\""), &format!("fmu = \"{name}.fmu\""));
    }
    let file = folder.join("system.toml");
    let told = |path: &str| -> serde_json::Value {
        let run = camdrive(&["check", path, "--json"]);
        assert_eq!(run.code, 0, "{}", run.err);
        serde_json::from_str::<serde_json::Value>(&run.out).expect("JSON")[0].take()
    };
    let said = |of_fmus: &str| {
        std::fs::write(&file, of_fmus).expect("a system");
        camdrive(&["check", text(&file)])
    };
    let scenes = told("examples/two_cams/system.toml");
    assert_eq!(said(&of_fmus).code, 0);
    let fmus = told(text(&file));
    for key in ["shafts", "loops", "connections", "notes", "repeats"] {
        assert!(!scenes[key].is_null() && scenes[key] == fmus[key], "{key}: {} {}", scenes[key], fmus[key]);
    }
    assert_eq!(scenes["repeats"], 1);
    let options = ["--step", "1 ms", "--stop", "0.1 s"];
    let [one, two] =
        ["examples/two_cams/system.toml", text(&file)].map(|path| camdrive(&[&["run", path][..], &options].concat()));
    assert!(one.code == 0 && one.out == two.out, "{}{}", one.err, two.err);
    // A machine without an input for each torque.
    let runtime = runtime();
    let plain = text(&folder.join("machine.fmu")).to_owned();
    let exported = camdrive(&["export", "examples/two_cams/machine.toml", "-o", &plain, "--runtime", &runtime]);
    assert_eq!(exported.code, 0, "{}", exported.err);
    let run = said(&of_fmus);
    for part in ["has no input `pusher.tau`", "admissible: tau", "torques = [\"pusher\", \"gripper\"]"] {
        assert!(run.code == 1 && run.err.contains(part), "{part}: {}", run.err);
    }
}

/// `check` refuses what `run` would.
#[test]
fn an_fmu_of_another_maker_is_checked_in_a_system() {
    let folder = folder("checked");
    cart(&folder, "false");
    let file = folder.join("system.toml");
    let check = |system: &str| {
        std::fs::write(&file, format!("name = \"carts\"\n{system}")).expect("a system");
        [camdrive(&["check", text(&file)]), camdrive(&["check", "--json", text(&file)])]
    };
    let parts = "[part.cart]\nfmu = \"cart.fmu\"\n[part.other]\nfmu = \"cart.fmu\"\n";
    for (times, more, said) in [
        ("stop = 3.5e-3\nstep = 1e-3\n", "", "system.toml:3"),
        ("stop = 3.5e-3\nstep = 1e-3\n", "", "part cart takes steps of one length only"),
        ("stop = 3e-3\nstep = 1e-3\nrepeat = 2\n", "", "part cart cannot restore its state"),
        ("stop = 3e-3\nstep = 1e-3\n", "[[connection]]\nfrom = \"other.x\"\nto = \"cart.open\"\n", "different types"),
        ("stop = 3e-3\nstep = 1e-3\n", "[[connection]]\nfrom = \"other.x\"\nto = \"cart.u\"\n", "same dimension"),
    ] {
        let [run, _] = check(&format!("{times}{parts}{more}"));
        assert!(run.code == 1 && run.err.contains(said), "{said}: {}", run.err);
    }
    // A text has its unit, a number none: it may be SI or that of the FMU.
    for offset in ["0.03", "\"0.03 m/s\"", "\"30 mm/s\""] {
        let speed = "[part.bar]\nscene = \"bar.toml\"\n";
        let scene = "name = \"bar\"\nmodel = \"ElasticCamDrive\"\ncam = { law = \"fourier\", a = [0, \"1 mm\"] }\n\
             drive = { speed = \"600 rpm\" }\nelasticity = { place = \"output\", m = 12, c = 1e6 }\n";
        std::fs::write(folder.join("bar.toml"), scene).expect("a scene");
        let connection = format!("[[connection]]\nfrom = \"bar.der(y)\"\nto = \"cart.u\"\noffset = {offset}\n");
        let [run, data] = check(&format!("stop = 3e-3\nstep = 1e-3\n{parts}{speed}{connection}"));
        if offset == "0.03" {
            assert!(run.code == 1 && run.err.contains("0.03 may be in SI or in mm/s"), "{}", run.err);
            continue;
        }
        assert_eq!(run.code, 0, "{}", run.err);
        let data: serde_json::Value = serde_json::from_str(&data.out).expect("JSON");
        let found = &data[0]["connections"][0];
        let close = |key: &str, expected: f64| (found[key].as_f64().unwrap() / expected - 1.0).abs() < 1e-12;
        assert!(close("factor", 1000.0) && close("offset", 30.0), "{found}");
    }
    // Whole numbers go to inputs of their type as they are.
    let mut files = unzipped(&folder.join("cart.fmu"));
    let described: String = files["modelDescription.xml"].iter().copied().map(char::from).collect();
    let described = described.replace("<Enumeration declaredType=\"Gear\" start=\"0\"/>", "<Integer start=\"0\"/>");
    files.insert("modelDescription.xml".to_owned(), described.chars().map(|c| c as u8).collect());
    zipped(&folder.join("cart.fmu"), &files);
    let contact = root().join("tests/systems/parts/contact.toml");
    let contact = text(&contact).replace('\\', "/");
    let parts = format!("[part.cart]\nfmu = \"cart.fmu\"\n[part.contact]\nscene = \"{contact}\"\n");
    for (more, said) in [
        ("", None),
        ("factor = 2\n", Some("`gear` is no real number, so it has no factor")),
        ("offset = 2\n", Some("`gear` is no real number, so it has no offset")),
    ] {
        let connection = format!("[[connection]]\nfrom = \"contact.impacts\"\nto = \"cart.gear\"\n{more}");
        let [run, _] = check(&format!("stop = 3e-3\nstep = 1e-3\n{parts}{connection}"));
        let told = said.map_or(run.code == 0, |said| run.code == 1 && run.err.contains(said));
        assert!(told, "{more}: {}", run.err);
    }
    // What a part refuses at its start.
    let machine = "name = \"machine\"\nmodel = \"RigidMachine\"\nmachine.J0 = 1\n";
    std::fs::write(folder.join("machine.toml"), machine).expect("a scene");
    let [run, data] = check("stop = 1\nstep = 1e-3\n[part.m]\nscene = \"machine.toml\"\nstart = { J0 = 0 }\n");
    assert!(run.code == 1 && run.err.contains("part m: ") && data.code == 1, "{}", run.err);
}

/// The report of a system of these files, NAME and TEXT, the first one the system.
fn coupling_report(name: &str, files: &[(&str, &str)]) -> (Run, serde_json::Value) {
    let folder = folder(name);
    for (name, content) in files {
        let path = folder.join(name);
        std::fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
        std::fs::write(path, content).expect("a file");
    }
    let run = camdrive(&["system", text(&folder.join(files[0].0)), "--study", "--json", "-o", text(&folder)]);
    let report = serde_json::from_str(&run.out).unwrap_or_default();
    (run, report)
}

const COUPLED_MACHINE: &str = r#"name = "machine"
model = "RigidMachine"
machine = { J0 = 1.2 }
motor = { kind = "kloss", M_k = 30, s_k = 0.2, w_s = 31 }
start = { w_start = 20, phi_start = 0.4 }
[[follower]]
m = 2
cam = { law = "fourier", a = [0, 0.02], b = [0.03] }
"#;
const ON_OUTPUT: &str = "elasticity = { place = \"output\", m = 4, c = 40000, b = 20, m_roller = 0.5 }";
const ON_SHAFT: &str = "elasticity = { place = \"shaft\", m = 4, J = 0.02, c = 200, b = 0.5 }";
const HARMONIC: &str = "cam = { law = \"fourier\", a = [0, 0.03, 0, -0.004], b = [0.01, 0.002] }";

/// A machine with a drive of this model, and what its scene and its part say besides.
fn coupled(model: &str, scene: &str, part: &str) -> [String; 2] {
    let head = "name = \"s\"\nstop = 0.1\nstep = 1e-3\n[part.machine]\nscene = \"machine.toml\"\n";
    [
        format!("{head}[part.drive]\nscene = \"a/drive.toml\"\nshaft = \"machine\"\n{part}\n"),
        format!("name = \"drive\"\nmodel = \"{model}\"\ndrive = {{ mode = \"input\" }}\n{scene}\n"),
    ]
}

/// Coupled FMUs at short steps against the train, which has another solver: every output agrees.
#[test]
fn a_system_and_its_one_train_move_alike() {
    let output = format!("{HARMONIC}\n{ON_OUTPUT}");
    let shaft = format!("{HARMONIC}\n{ON_SHAFT}");
    let loaded = format!(
        "{output}\nload = {{ gravity = 9.81, damping = 3, process = {{ law = \"fourier\", a = [5, 30], b = [20] }} }}"
    );
    let cycle = "cam = { law = \"cycle\", stroke = \"20 mm\", rise_start = \"300 deg\", rise = \"100 deg\", \
                 upper_dwell = \"60 deg\", return = \"120 deg\", rise_law = \"polynomial_345\", return_law = \"modified_sine\" }";
    let cycle = format!("{cycle}\n{ON_OUTPUT}");
    let lift: String =
        (0..36).map(|i| format!("{},{}\n", 10 * i, 0.01 * f64::from(10 * i).to_radians().sin())).collect();
    let table = format!("cam = {{ law = \"table\", file = \"lift.csv\", angle_unit = \"deg\" }}\n{ON_OUTPUT}");
    let clearance = format!("{HARMONIC}\nbacklash = {{ m1 = 0.3, m2 = 2, c = 20000, b = 40, s = 0.002 }}");
    let train = format!(
        "[[follower]]\nm = 0.5\n{HARMONIC}\n[[follower]]\n{HARMONIC}\n{ON_SHAFT}\n[[follower]]\nm = 2\ncrank = {{ offset = 0.2 }}\n\
         [[follower.linkage]]\nkind = \"slider_crank\"\ncrank = {{ length = 0.05, m = 0.3 }}\nrod = {{ length = 0.2, m = 0.4 }}\n"
    );
    for (model, scene, part, count) in [
        ("ElasticCamDrive", &*output, "", 17),
        ("ElasticCamDrive", &output, "ratio = 2\noffset = 0.5", 17),
        ("ElasticCamDrive", &output, "ratio = -3\noffset = -1\nstart = { m = 3, b = 50 }", 17),
        ("ElasticCamDrive", &loaded, "ratio = -1\noffset = 0.3", 17),
        ("ElasticCamDrive", &shaft, "ratio = -2\noffset = 0.5", 13),
        ("ElasticCamDrive", &cycle, "offset = \"200 deg\"", 17),
        ("ElasticCamDrive", &table, "", 17),
        ("BacklashDrive", &clearance, "ratio = -1\noffset = 0.5", 11),
        ("DriveTrain", &train, "", 29),
    ] {
        let [system, drive] = coupled(model, scene, part);
        let files = [
            ("system.toml", &*system),
            ("machine.toml", COUPLED_MACHINE),
            ("a/drive.toml", &drive),
            ("a/lift.csv", &lift),
        ];
        let (run, report) = coupling_report("one_train", &files);
        let said = format!("{model} {part}: {}", run.err);
        assert!(run.code == 0 && report["fmu"] == "s_train.fmu", "{said}");
        assert_eq!(report["outputs"].as_array().map_or(0, Vec::len), count, "{said}");
        let errors = report["rows"].as_array().expect("rows").iter().filter_map(|row| row["error"].as_f64());
        let least = errors.fold(f64::INFINITY, f64::min);
        assert!(least < 2e-6, "{said}: {least}");
    }
}

/// The report of an example: orders, a step beyond stability, and the one FMU.
#[test]
fn a_coupling_report_tells_steps_and_packs_the_one_fmu() {
    let folder = folder("coupling_report");
    let run = camdrive(&["system", "examples/loom/system.toml", "--study", "--json", "-o", text(&folder)]);
    assert_eq!(run.code, 0, "{}", run.err);
    let report: serde_json::Value = serde_json::from_str(&run.out).expect("JSON");
    assert_eq!(run.out, std::fs::read_to_string(folder.join("loom_system.json")).expect("the report"));
    let verdict = report["verdict"].to_string();
    for said in [
        "With run.py errors stay within 1 % at steps up to 250 µs",
        "With camdrive run errors stay within 1 % at steps up to 2 ms",
        "With a master that holds inputs no step from 62.5 µs on",
        "The one FMU loom_system_train.fmu",
    ] {
        assert!(verdict.contains(said), "{verdict}");
    }
    let rows = report["rows"].as_array().expect("rows");
    let row = |exchange: &str, repeats: u32, step: f64| {
        let is = |row: &&serde_json::Value| {
            let near = (row["step"].as_f64().expect("a step") / step - 1.0).abs() < 1e-9;
            near && row["exchange"] == exchange && row["repeats"] == repeats
        };
        rows.iter().find(is).unwrap_or_else(|| panic!("{exchange} {step}"))
    };
    assert!(row("held", 0, 2e-3)["unstable"].as_str().is_some_and(|said| said.contains("grow beyond 1.74 ms")));
    for (exchange, repeats, order) in
        [("held", 0, 1.0), ("extrapolated", 0, 2.0), ("interpolated", 0, 2.0), ("interpolated", 1, 3.0)]
    {
        let found = row(exchange, repeats, 125e-6)["order"].as_f64().expect("an order");
        assert!((found - order).abs() < 0.1, "{exchange} {repeats}: {found}");
    }
    for name in ["loom_system.csv", "loom_system.svg"] {
        assert!(folder.join(name).is_file(), "{name}");
    }
    let fmu = folder.join("loom_system_train.fmu");
    let checked = camdrive(&["verify", text(&fmu)]);
    assert_eq!(checked.code, 0, "{}{}", checked.out, checked.err);
}

/// The page of a store, of a study by its usual store, of a system; and what has none.
#[test]
fn pages_of_studies_and_systems() {
    let (folder, file) = study("report", "\n[[vary]]\nname = \"start.mode\"\nvalues = [\"at_rest\"]\n");
    let (store, page) = (folder.join("store"), folder.join("page.html"));
    let report = |what: &str| camdrive(&["report", what, "-o", text(&page)]);
    let missing = folder.join("without.toml");
    std::fs::copy(&file, &missing).expect("a study");
    let made = camdrive(&["study", &file, "-o", text(&store), "--part", "1/3"]);
    assert!(made.code == 0 && made.out.contains("2 parts not there yet"), "{}{}", made.out, made.err);
    let of_part = report(text(&store));
    assert_eq!((of_part.code, of_part.err.as_str()), (0, ""));
    assert!(std::fs::read_to_string(&page).expect("the page").contains("16 runs of 40: 16 ok"));
    assert_eq!(camdrive(&["study", &file, "-o", text(&store), "--resume"]).code, 0);
    assert_eq!(report(text(&store)).code, 0);
    // On a page a number keeps its unit in its line.
    let whole = std::fs::read_to_string(&page).expect("the page");
    assert!(whole.contains("\u{a0}mm"), "{whole}");
    let whole = whole.replace('\u{a0}', " ");
    let data = camdrive(&["study", &file, "-o", text(&store), "--resume", "--json"]);
    let data: serde_json::Value = serde_json::from_str(&data.out).expect("JSON");
    assert_eq!((&data["computed"], &data["ok"]), (&0.into(), &40.into()));
    for sentence in data["verdict"]["result"].as_array().expect("sentences") {
        assert!(whole.contains(sentence.as_str().expect("a sentence")), "{sentence}: {whole}");
    }
    let [low, high] = [0, 1].map(|end| data["measures"][0]["runs"][end].as_u64().expect("a run"));
    assert!(low != high && whole.contains("<td>least max |q|</td>"), "{whole}");
    assert!(whole.contains(&format!("<td data-v=\"{high}\">{high}</td>")), "{high}: {whole}");
    let system = report("examples/two_cams/system.toml");
    assert_eq!(system.code, 0, "{}", system.err);
    let told = std::fs::read_to_string(&page).expect("the page");
    for said in ["Ways to couple", "System of 3 parts", "<td>gripper</td>", "pusher.tau", "With run.py errors stay"] {
        assert!(told.contains(said), "{said}");
    }
    std::fs::remove_file(&page).expect("the page");
    for (what, said) in [
        (text(&missing), "`camdrive study "),
        (text(&folder), "this is no store of a study"),
        (TASK, "`camdrive synthesize "),
        ("tests/tables/lobe.csv", "a table or another text"),
        (&format!("{file}.none"), "cannot be read"),
    ] {
        let run = report(what);
        assert!(run.code == 1 && run.err.contains(said) && run.err.contains("= hint:"), "{what}: {}", run.err);
    }
    assert!(!page.exists());
}

/// What no train can be is compared with itself at short steps.
#[test]
fn a_coupling_report_of_foreign_fmus_is_against_short_steps() {
    let [system, drive] = coupled("ElasticCamDrive", &format!("{HARMONIC}\n{ON_OUTPUT}"), "");
    let folder = folder("foreign_report");
    std::fs::write(folder.join("drive.toml"), drive).expect("a scene");
    let exported = camdrive(&["export", text(&folder.join("drive.toml")), "-o", text(&folder.join("drive.fmu"))]);
    assert_eq!(exported.code, 0, "{}", exported.err);
    let system = system
        .replace("scene = \"a/drive.toml\"", "fmu = \"drive.fmu\"")
        .replace("[part.machine]", "repeat = 1\n[part.machine]");
    std::fs::write(folder.join("machine.toml"), COUPLED_MACHINE).expect("a scene");
    std::fs::write(folder.join("system.toml"), system).expect("a system");
    let run = camdrive(&["system", text(&folder.join("system.toml")), "--study", "-o", text(&folder.join("out"))]);
    assert_eq!(run.code, 0, "{}", run.err);
    assert!(
        run.err.contains("it cannot be one DriveTrain: part drive: the content of an FMU is unknown"),
        "{}",
        run.err
    );
    assert!(
        run.out.contains("in steps of 15.6 µs, each repeated 2 times") && !run.out.contains("one FMU"),
        "{}",
        run.out
    );
    assert!(!folder.join("out/s_train.fmu").exists());
}

#[test]
fn the_standard_input_pipes_and_devices_are_read_once() {
    let (folder, scene) = (folder("streams"), root().join("examples/guide_bar/scene.toml"));
    let commands = format!(
        "set -e; cat {0} | \"$1\" check -; \"$1\" check <(cat {0}); \"$1\" check /dev/stdin < {0}; mkfifo a.toml a.fmu
         cat {0} > a.toml & \"$1\" run a.toml --output y --stop '1 ms'",
        scene.display()
    );
    let bash = |script: &str| {
        let mut bash = Command::new("bash");
        bash.current_dir(&folder).args(["-c", script, "bash", env!("CARGO_BIN_EXE_camdrive")]);
        bash.output().expect("bash starts")
    };
    let done = bash(&commands);
    let out = String::from_utf8(done.stdout).unwrap();
    assert!(done.status.success() && out.matches("ElasticCamDrive").count() >= 3, "{out}");
    assert!(out.contains("time,y\n"), "{out}");
    // An FMU is read from a file of its own.
    for line in ["run -", "run <(cat)", "check -", "verify -", "verify <(cat)"] {
        let done = bash(&format!("printf 'PK\\003\\004' | \"$1\" {line}"));
        let err = String::from_utf8(done.stderr).unwrap();
        let said = err.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(
            done.status.code() == Some(1) && said.contains("with a name that ends in .fmu, not from a pipe"),
            "{err}"
        );
        assert!(!said.contains("not an FMU"), "{err}");
    }
    // Opening it would wait for what never comes.
    let done = bash("timeout 20 \"$1\" run a.fmu");
    assert_eq!(done.status.code(), Some(1));
    assert!(
        String::from_utf8(done.stderr).unwrap().contains("a.fmu: the FMU cannot be read: it is a pipe or a device")
    );
}

#[test]
fn a_wrong_argument_ends_with_exit_code_2() {
    let (scene, machine) = ("examples/guide_bar/scene.toml", "examples/backlash_machine/train.toml");
    let (run_up, backlash) = ("examples/guide_bar/run_up.toml", "examples/backlash_drive/scene.toml");
    for args in [
        &["run", scene, "--stop", "12 kg"][..],
        &["run", scene, "--step", "-1 s"],
        &["run", scene, "--start", "m"],
        &["run", scene, "--output", "none"],
        &["run", scene, "--diagram", "a.png"],
        &["help", "nothing"],
        &["help", "scene", "nothing"],
        &["cam", "examples/tappet/scene.toml", "--follower", "3"],
        &["cam", "examples/tappet/scene.toml", "--chord-error", "1 km"],
        &["tradeoff", run_up, "--turns", "nan"],
        &["tradeoff", scene, "--turns", "1e99"],
        &["tradeoff", run_up, "--ramp", "0"],
        &["clearance", backlash, "--clearance", "0"],
        &["clearance", backlash, "--m1", "-1kg"],
        &["clearance", backlash, "--natural-frequency", "0"],
        &["clearance", backlash, "--turns", "0"],
        &["clearance", backlash, "--compare", "nothing"],
        &["export", scene, "--runtime", "xx=yy"],
        &["steady", machine, "--load", "3 N.m"],
        &["export", scene, "-o", "a.zip"],
        &["nothing"],
    ] {
        let run = camdrive(args);
        assert_eq!(run.code, 2, "{args:?}: {}", run.err);
    }
    // A fault of a scene is none of the command line.
    assert_eq!(camdrive(&["run", "tests/scenes/empty.toml"]).code, 1);
}

#[test]
fn files_that_no_command_wrote_are_kept() {
    let folder = folder("kept");
    let (results, page) = (folder.join("cam"), folder.join("page.html"));
    let cam = ["cam", "examples/tappet/scene.toml", "-o", text(&results)];
    let forces = ["forces", "examples/tappet/scene.toml", "-o", text(&results)];
    let report = ["report", "examples/guide_bar/scene.toml", "-o", text(&page)];
    for (args, file) in [
        (&cam[..], results.join("tappet.csv")),
        (&cam, results.join("tappet.dxf")),
        (&cam, results.join("tappet.plc.txt")),
        (&forces, results.join("tappet.torque.csv")),
        (&report, page.clone()),
    ] {
        // Results of the command itself are replaced.
        for _ in 0..2 {
            let run = camdrive(args);
            assert_eq!(run.code, 0, "{args:?}: {}", run.err);
        }
        std::fs::write(&file, "<!DOCTYPE html>\nmy notes\n").unwrap();
        let run = camdrive(args);
        assert!(run.code == 1 && run.err.contains("no command wrote this file; it is kept"), "{args:?}: {}", run.err);
        assert!(std::fs::read_to_string(&file).unwrap().contains("my notes"));
        assert_eq!(camdrive(&[args, &["--force"]].concat()).code, 0);
        assert!(!std::fs::read_to_string(&file).unwrap().contains("my notes"));
        if args != report {
            std::fs::remove_dir_all(&results).unwrap();
        }
    }
}

#[test]
fn parts_of_a_store_that_are_not_theirs_are_seen() {
    let folder = folder("sealed");
    let scene = root().join("examples/guide_bar/scene.toml");
    let study = |name: &str, speed: u32| {
        let file = folder.join(name);
        let vary = format!("[[vary]]\nname = \"drive.w\"\nfrom = {speed}\nto = 200\ncount = 32\n");
        let head = format!("scene = {:?}\nturns = 1\nmeasures = [\"last q\"]\n", text(&scene));
        std::fs::write(&file, head + &vary).unwrap();
        file
    };
    let (one, other) = (study("one.toml", 100), study("other.toml", 101));
    let run = |file: &Path, store: &Path, more: &[&str]| {
        camdrive(&[&["study", text(file), "-o", text(store)], more].concat())
    };
    let (store, second) = (folder.join("store"), folder.join("second"));
    for (file, store) in [(&one, &store), (&other, &second)] {
        let done = run(file, store, &[]);
        assert_eq!(done.code, 0, "{}", done.err);
    }
    let [first, last] = ["runs/part-00000.parquet", "runs/part-00001.parquet"].map(|part| store.join(part));
    let whole = [&first, &last].map(|part| std::fs::read(part).unwrap());
    let mut flipped = whole[1].clone();
    flipped[100] ^= 1;
    let wrong = [
        whole[0].clone(),
        flipped,
        whole[1][..whole[1].len() - 9].to_vec(),
        std::fs::read(second.join("runs/part-00001.parquet")).unwrap(),
    ];
    for bytes in wrong {
        std::fs::write(&last, bytes).unwrap();
        let report = camdrive(&["report", text(&store), "-o", text(&folder.join("page.html"))]);
        assert!(
            report.code == 1 && report.err.contains("part-00001.parquet: this part is damaged, or belongs to another")
        );
        let done = run(&one, &store, &["--resume"]);
        assert!(done.code == 0 && done.err.contains("its runs are computed again"), "{}", done.err);
        assert!(std::fs::read(&last).unwrap() == whole[1]);
    }
}

/// A scene that takes an unusual name of a variable cannot be written; an FMU may have it.
#[test]
fn names_in_csv_are_quoted_and_no_formulas() {
    let csv = |names: &[&str]| camdrive_design::text::csv([names.iter().map(|name| (*name).to_owned()).collect()]);
    assert_eq!(csv(&["time", "der(y,2)"]).unwrap(), "time,\"der(y,2)\"\n");
    let hard = ["a \"b\"", "a\nb", "=1+1", "@x", "-x", "+x", "'=x"];
    let line = csv(&hard).unwrap();
    assert_eq!(line, "\"a \"\"b\"\"\",\"a\nb\",'=1+1,'@x,'-x,'+x,'=x\n");
    let mut reader = csv::Reader::from_reader(line.as_bytes());
    let read: Vec<&str> = reader.headers().unwrap().iter().map(camdrive_design::text::heading).collect();
    assert_eq!(read[..6], hard[..6]);
}

#[test]
fn a_changed_description_is_seen() {
    let folder = folder("changed_description");
    let fmu = folder.join("guide_bar.fmu");
    let exported = camdrive(&["export", "examples/guide_bar/scene.toml", "-o", text(&fmu), "--runtime", &runtime()]);
    assert_eq!(exported.code, 0, "{}", exported.err);
    assert_eq!(camdrive(&["verify", text(&fmu)]).code, 0);
    for (from, to, said) in [
        ("start=\"12.0\"", "start=\"12.5\"", "start is \"12.5\", the scene gives \"12.0\""),
        ("stopTime=\"", "stopTime=\"1", "<DefaultExperiment>: stopTime is"),
        ("max=\"", "max=\"1", "max is"),
    ] {
        let changed = folder.join("changed.fmu");
        let mut files = unzipped(&fmu);
        let xml = String::from_utf8(files["modelDescription.xml"].clone()).unwrap();
        files.insert("modelDescription.xml".to_owned(), xml.replacen(from, to, 1).into_bytes());
        zipped(&changed, &files);
        let run = camdrive(&["verify", text(&changed)]);
        assert!(
            run.code == 1 && run.out.contains("modelDescription.xml: <") && run.out.contains(said),
            "{said}: {}",
            run.out
        );
    }
}

#[cfg(unix)]
#[test]
fn temporary_folders_go_with_a_signal() {
    let folder = folder("signalled");
    let (fmu, temporary) = (folder.join("guide_bar.fmu"), folder.join("tmp"));
    std::fs::create_dir(&temporary).unwrap();
    let exported = camdrive(&["export", "examples/guide_bar/scene.toml", "-o", text(&fmu), "--runtime", &runtime()]);
    assert_eq!(exported.code, 0, "{}", exported.err);
    // A closed terminal is no reason to end for a program that ignores it.
    let script = "for signal in TERM HUP; do
        \"$1\" run \"$2\" --stop '1e6 s' --step '1 ms' > /dev/null & run=$!
        until [ -n \"$(ls \"$3\")\" ]; do sleep 0.05; done
        sleep 0.3; kill -$signal $run; wait $run; echo $?; ls \"$3\"
        done
        trap '' HUP
        \"$1\" run \"$2\" --stop '1e6 s' --step '1 ms' > /dev/null & run=$!
        until [ -n \"$(ls \"$3\")\" ]; do sleep 0.05; done
        sleep 0.3; kill -HUP $run; sleep 0.3; kill -TERM $run; wait $run; echo $?; ls \"$3\"";
    // The tests themselves may run behind `nohup`.
    let mut bash = Command::new("env");
    bash.env("TMPDIR", &temporary).args(["--default-signal=HUP", "bash", "-c", script, "bash"]);
    let done = bash.arg(env!("CARGO_BIN_EXE_camdrive")).args([&fmu, &temporary]).output().expect("bash starts");
    // 128 and the number of the signal; no folder is left.
    assert_eq!(String::from_utf8(done.stdout).unwrap(), "143\n129\n143\n");
}
