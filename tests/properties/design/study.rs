//! `study`: the measures of a run.

use super::super::scenes::{CamScene, Model, output, shaft};
use super::*;

/// The accuracy asked for, and what a measure may differ by: both runs may be off by it, in the other sense.
const ACCURACY: f64 = 1e-8;
const APART: f64 = 3e-8;

/// One of the elastic drives.
fn elastic() -> impl Strategy<Value = CamScene> {
    prop_oneof![output(), shaft(Model::Shaft, 10.0)]
}

fn printed(scene: &CamScene, image: &Image) -> Result<Value, String> {
    let mut files = Files::default();
    let cam = files.law(&image.law(&scene.law, LENGTH));
    let of_shaft = scene.model == Model::Shaft;
    let [stiffness, damping] = if of_shaft { [TORQUE, [1, 2, -1]] } else { [[1, 0, -2], [1, 0, -1]] };
    let mut elasticity = json!({
        "place": "output", "m": image.even(scene.m, MASS), "c": image.even(scene.c, stiffness), "b": image.even(scene.b, damping),
    });
    if of_shaft {
        elasticity["place"] = "shaft".into();
        elasticity["J"] = image.even(scene.second, INERTIA).into();
    }
    files.scene = json!({
        "name": "random", "model": "ElasticCamDrive", "cam": cam, "elasticity": elasticity,
        "drive": {"speed": image.odd(scene.w, RATE), "phi_start": image.angle(scene.phi_start)},
    });
    let degrees = image.angle(1.0).to_degrees();
    files.study = format!(
        "scene = \"scene.toml\"\nturns = 2\nsettle = 0.3\naccuracy = {ACCURACY:e}\nvary = [{{ name = \"start.q\", values = [0] }}]\n\
         measures = [\"max y\", \"min y\", \"rms y\", \"mean y\", \"max |der(y)|\", \"harmonic 2 of y\", \"y at {degrees} deg\", \"last y\"]\n"
    );
    let result = files.printed("study", &["--json", "-o", "store"].map(str::to_owned))?;
    let least = |measure: &Value| measure["least"].clone();
    Ok(json!({ "measures": result["measures"].as_array().expect("a list").iter().map(least).collect::<Vec<_>>() }))
}

fn holds(scene: &CamScene, image: &Image) -> Result<(), TestCaseError> {
    let (before, after) = (printed(scene, &SAME), printed(scene, image));
    // Velocities count in their own unit; all others are lengths, right to a part of the largest.
    let size = before.as_ref().map_or(0.0, |before| {
        let of = |i: usize| before["measures"][i].as_f64().unwrap_or(0.0).abs();
        of(0).max(of(1))
    });
    let apart = |result: Result<Value, String>| {
        result.map(|mut result| {
            result["speed"] = result["measures"][4].take();
            result["measures"][4] = json!(0);
            result
        })
    };
    let of = |key: &str, _: &str, _: &Map<String, Value>| match key {
        "measures" => Of::Number(LENGTH, Sign::Even, [APART, size]),
        _ => Of::Number([0, 1, -1], Sign::Even, [APART, 0.0]),
    };
    let reading = Reading { of: &of, around: &[], followers: &[] };
    reading.holds(image, apart(before), apart(after))
}

#[test]
fn rotated() {
    for_all(2100, 8, (elastic(), rotation()), |(scene, image)| holds(scene, image));
}

#[test]
fn mirrored() {
    for_all(2200, 8, elastic(), |scene| holds(scene, &MIRROR));
}

#[test]
fn scaled() {
    for_all(2300, 8, (elastic(), scaling()), |(scene, image)| holds(scene, image));
}
