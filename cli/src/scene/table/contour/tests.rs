//! Contours as measuring machines write them, against the law that they were cut for.

use crate::scene::resolve;
use camdrive::motion::MotionLaw;
use std::f64::consts::{PI, TAU};
use std::path::Path;

const CONTOUR: &str = include_str!("../../../../../tests/tables/contour.csv");
const ROLLER: &str = "follower = \"translating\", roller_radius = \"9 mm\", base_radius = \"16 mm\"";

/// The law of a drive with these keys of `[cam]` beside a file with this content, and of `[geometry]`; with notes and description.
fn of(content: &str, keys: &str, geometry: &str) -> Result<(MotionLaw, String), String> {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("t.csv"), content).expect("a file");
    scene(&format!("cam = {{ law = \"contour\", file = \"t.csv\", {keys} }}\n{geometry}"), folder.path())
}

fn scene(cam: &str, folder: &Path) -> Result<(MotionLaw, String), String> {
    let text = format!(
        "name = \"x\"\nmodel = \"ElasticCamDrive\"\n{cam}\ndrive = {{ mode = \"input\" }}\n\
         elasticity = {{ place = \"output\", m = 1, c = 1 }}"
    );
    let scene = resolve("scene.toml", &text, folder).map_err(|faults| faults.to_string())?;
    Ok((scene.cams[0].law.clone(), scene.notes.join("\n") + &scene.description))
}

/// The largest error against 10 mm of the law 4-5-6-7 over 65° up and 65° down (m).
fn error(law: &MotionLaw) -> f64 {
    let lift = |phi: f64| {
        let z = (phi.to_degrees().rem_euclid(360.0) - 65.0).abs().min(65.0) / 65.0;
        let z = 1.0 - z;
        1e-2 * z.powi(4) * (35.0 + z * (-84.0 + z * (70.0 - 20.0 * z)))
    };
    let angle = |i: u32| TAU * f64::from(i) / 3600.0 - PI;
    (0..3600).map(|i| (law.at(angle(i)).0[0] - lift(angle(i))).abs()).fold(0.0, f64::max)
}

fn points() -> Vec<[f64; 2]> {
    let number = |cell: &str| cell.parse::<f64>().ok();
    let row = |line: &str| line.split_once(';').and_then(|(x, y)| Some([number(x)?, number(y)?]));
    CONTOUR.lines().filter_map(row).collect()
}

/// A file of the points, each written by `row`.
fn file(points: &[[f64; 2]], row: impl Fn([f64; 2]) -> String) -> String {
    points.iter().map(|point| row(*point) + "\n").collect()
}

#[test]
fn a_contour_gives_its_law_in_every_dialect() {
    let geometry = format!("geometry = {{ {ROLLER} }}");
    let (law, told) = of(CONTOUR, "", &geometry).unwrap();
    // Its points are rounded to a tenth of a micrometre.
    assert!(error(&law) < 1.5e-7, "{:e}", error(&law));
    assert!(
        told.contains("`cam`: the law comes from the contour") && told.contains("The law of cam comes from"),
        "{told}"
    );
    let (points, mut other) = (points(), points());
    let polar = |[x, y]: [f64; 2]| [x.hypot(y), y.atan2(x).to_degrees()];
    other.reverse();
    other.rotate_left(77);
    other.push(other[0]);
    let comma = |[x, y]: [f64; 2]| format!("{x:.5}\t{y:.5}").replace('.', ",");
    for (content, keys) in [
        (file(&points, |[x, y]| format!("{x} {y}")), "length_unit = \"mm\""),
        (file(&other, comma), "length_unit = \"mm\""),
        ("n,y [in],x [in]\n".to_owned() + &file(&other, |[x, y]| format!("1,{:.7},{:.7}", y / 25.4, x / 25.4)), ""),
        ("r [mm];angle [deg]\n".to_owned() + &file(&points, |p| format!("{:.6};{:.6}", polar(p)[0], polar(p)[1])), ""),
        (
            file(&other, |p| format!("{:.8};{:.6}", polar(p)[1].to_radians(), polar(p)[0])),
            "length_unit = \"mm\", r_column = 2, angle_column = 1",
        ),
        (
            file(&points, |p| format!("{:.6};{:.6}", polar(p)[0], polar(p)[1])),
            "length_unit = \"mm\", angle_unit = \"deg\"",
        ),
    ] {
        let (again, _) = of(&content, keys, &geometry).unwrap_or_else(|faults| panic!("{keys}: {faults}"));
        assert!(error(&again) < 2e-7, "{keys}: {:e}", error(&again));
    }
}

#[test]
fn what_gives_no_law_is_told_with_its_place() {
    let told = |content: &str, keys: &str, geometry: &str| of(content, keys, geometry).unwrap_err();
    let geometry = format!("geometry = {{ {ROLLER} }}");
    let gap: String = CONTOUR
        .lines()
        .enumerate()
        .filter(|(i, _)| !(100..120).contains(i))
        .map(|(_, line)| format!("{line}\n"))
        .collect();
    let (polar, cartesian) = ("angle_unit = \"deg\"", "length_unit = \"in\"");
    for (content, keys, geometry, parts) in [
        (&*gap, "", &*geometry, &["t.csv:101", "no point in the", "measure the whole turn"][..]),
        (CONTOUR, polar, &geometry, &["`cam.angle_unit`", "the points are x and y"]),
        (CONTOUR, cartesian, &geometry, &["`cam.length_unit`", "heading of its column says mm"]),
        (CONTOUR, "turn = 720", &geometry, &["`cam.turn` is not known"]),
        (CONTOUR, "", "", &["`cam.law`", "add a section [geometry]"]),
        (
            CONTOUR,
            "",
            &geometry.replace("16 mm", "17 mm"),
            &["`cam.file`", "least radius of the contour is 15.9999 mm"],
        ),
        (CONTOUR, "", &geometry.replace("9 mm", "90 mm"), &["t.csv:", "undercut", "cannot follow"]),
        ("1 2\n3 4\n", "", &geometry, &["a contour of 2 points"]),
        (
            &file(&points(), |[x, y]| format!("{} {y}", x + 40.0)),
            "length_unit = \"mm\"",
            &geometry,
            &["does not go around the cam's centre once"],
        ),
    ] {
        let text = told(content, keys, geometry);
        assert!(parts.iter().all(|part| text.contains(part)), "{parts:?}: {text}");
    }
    let text = "name = \"x\"\nmodel = \"RigidMachine\"\nmachine.J0 = 1\n[[follower]]\nm = 1\ncam = { law = \"contour\", file = \"t.csv\" }";
    let told = resolve("scene.toml", text, Path::new("")).unwrap_err().to_string();
    assert!(told.contains("add a section [follower.geometry]"), "{told}");
    let load =
        "cam = { law = \"fourier\", a = [0, 0.01] }\nload = { process = { law = \"contour\", file = \"t.csv\" } }";
    let text = scene(load, Path::new("")).unwrap_err();
    assert!(text.contains("next to the `[geometry]` of its follower") && text.contains("\n1 fault"), "{text}");
}
