//! `forces`: loads on rollers and shaft.

use super::super::run::Run;
use super::super::scenes::{decades, sign};
use super::cam::{Body, body};
use super::*;
use std::cell::Cell;

/// A follower with its loads, relative to its inertia.
#[derive(Clone, Debug)]
pub struct Loaded {
    body: Body,
    m: f64,
    lever_inertia: f64,
    preload: Option<[f64; 2]>,
    gravity: f64,
    process: Option<MotionLaw>,
    width: Option<f64>,
}

#[derive(Clone, Debug)]
pub struct Scene {
    pub followers: Vec<Loaded>,
    pub w: f64,
}

pub fn any() -> impl Strategy<Value = Scene> {
    let spring = prop_oneof![Just(None), [0.0..2.0_f64, 0.0..2.0_f64].prop_map(Some)];
    let gravity = prop_oneof![Just(0.0), -1.0..1.0_f64];
    let process = prop_oneof![Just(None), (super::super::scenes::law(), -1.0..1.0_f64).prop_map(Some)];
    let width = prop_oneof![Just(None), (0.1..1.0_f64).prop_map(Some)];
    let follower = (body(), decades(-2.0, 2.0), 0.0..1.0_f64, spring, gravity, process, width);
    type Follower = (Body, f64, f64, Option<[f64; 2]>, f64, Option<(MotionLaw, f64)>, Option<f64>);
    (prop::collection::vec(follower, 1..4), decades(-1.0, 2.0), sign()).prop_map(|(list, w, sign)| {
        let loaded = |(body, m, part, spring, gravity, process, width): Follower| {
            let force = m * body.stroke * w * w;
            Loaded {
                m,
                lever_inertia: part * m * body.stroke * body.stroke,
                preload: spring.map(|[preload, stiffness]| [preload * force, stiffness * m * w * w]),
                gravity: gravity * body.stroke * w * w,
                process: process.map(|(law, part)| times(&law, part * force)),
                width: width.map(|width| width * body.stroke),
                body,
            }
        };
        Scene { followers: list.into_iter().map(loaded).collect(), w: sign * w }
    })
}

impl Loaded {
    /// `[[follower]]`.
    pub fn table(&self, image: &Image, files: &mut Files) -> Value {
        let geometry = self.body.geometry(image);
        let (mut forces, mut load) = (json!({}), json!({}));
        if geometry["follower"] == "lever" {
            forces["lever_J"] = image.even(self.lever_inertia, INERTIA).into();
        }
        if let Some([preload, stiffness]) = self.preload {
            load["spring"] = json!({"preload": image.even(preload, FORCE), "c": image.even(stiffness, [1, 0, -2])});
        }
        if self.gravity != 0.0 {
            load["gravity"] = image.even(self.gravity.abs(), [0, 1, -2]).into();
            load["gravity_angle"] = if self.gravity > 0.0 { 0.0 } else { TAU / 2.0 }.into();
        }
        if let Some(process) = &self.process {
            load["process"] = files.law(&image.law(process, FORCE));
            if load["process"]["law"] == "table" {
                load["process"]["interpolation"] = "spline".into();
            }
        }
        if let Some(width) = self.width {
            forces["roller_width"] = image.even(width, LENGTH).into();
            for key in ["E_cam", "E_roller"] {
                forces[key] = image.even(2e11, [1, -1, -2]).into();
            }
        }
        let cam = files.law(&image.law(&self.body.law, LENGTH));
        json!({"m": image.even(self.m, MASS), "cam": cam, "geometry": geometry, "forces": forces, "load": load})
    }
}

/// A tappet on a cam at constant speed: elastic, or as one mass that may leave its cam.
pub fn tappet(scene: &Scene, rigid: bool) -> Files {
    let mut files = Files::default();
    let mut table = scene.followers[0].table(&SAME, &mut files);
    let m = table.as_object_mut().expect("a table").remove("m").expect("a mass");
    if rigid {
        table["backlash"] = json!({"m1": m, "s": "inf"});
        table["model"] = "BacklashDrive".into();
        // The motion has no lever.
        table["forces"].as_object_mut().expect("a table").remove("lever_J");
    } else {
        // Above the speed, so that it starts, and so near that it vibrates.
        let stiff = m.as_f64().expect("a mass") * (12.0 * scene.w).powi(2);
        table["elasticity"] = json!({"place": "output", "m": m, "c": stiff, "damping_ratio": 0.1});
        table["model"] = "ElasticCamDrive".into();
    }
    table["name"] = "random".into();
    table["drive"] = json!({"speed": scene.w});
    files.scene = table;
    files
}

fn printed(scene: &Scene, image: &Image) -> Result<Value, String> {
    let mut files = Files::default();
    let followers = image.order(scene.followers.iter().map(|loaded| loaded.table(image, &mut files)).collect());
    files.scene = json!({"name": "random", "model": "RigidMachine", "machine": {"J0": 1.0}, "follower": followers});
    let speed = option("speed", image.odd(scene.w, RATE));
    files.printed("forces", &["--json".to_owned(), "-o".to_owned(), "out".to_owned(), speed])
}

fn holds(scene: &Scene, image: &Image) -> Result<(), TestCaseError> {
    let is_smooth = |loaded: &Loaded| has_no_rest(&loaded.body.law) && loaded.process.as_ref().is_none_or(has_no_rest);
    let smooth = scene.followers.iter().all(is_smooth);
    let force = scene.followers.iter().map(|f| f.m * f.body.stroke * scene.w * scene.w).fold(0.0, f64::max);
    let torque = scene.followers.iter().map(|f| f.m * (f.body.stroke * scene.w).powi(2)).fold(0.0, f64::max);
    let of = |key: &str, above: &str, around: &Map<String, Value>| {
        let quantity = around.get("quantity").and_then(Value::as_str).unwrap_or_default();
        let sign = match quantity {
            "torque" if image.sense < 0.0 => Sign::Odd,
            _ => Sign::Even,
        };
        let (units, size) = match around.get("unit").and_then(Value::as_str) {
            Some("N") => (FORCE, force),
            Some("N·m") => (TORQUE, torque),
            Some("Pa") => ([1, -1, -2], 0.0),
            _ => (NUMBER, 1.0),
        };
        match key {
            // Forces of one sign and pressure angles have kinks, over which Simpson's rule keeps the three digits that are shown.
            "mean" if !["torque", "lever_torque", "follower_force"].contains(&quantity) => {
                let largest = around["largest"]["value"].as_f64().expect("a number");
                Of::Number(units, sign, [5e-4, largest.abs()])
            }
            "value" | "mean" | "largest" | "least" if !quantity.is_empty() => Of::Number(units, sign, [1e-8, size]),
            "speed" => Of::Number(RATE, Sign::Odd, [1e-12, 0.0]),
            "shaft" | "process" if !around.contains_key("quantity") && around.contains_key("process") => {
                Of::Number([1, 2, -3], Sign::Even, [1e-8, torque * scene.w.abs()])
            }
            "value" if above == "least_preload" => Of::Number(FORCE, Sign::Even, [1e-8, force]),
            "value" => Of::Number(RATE, Sign::Even, [1e-8, 0.0]),
            // Several places may have none.
            "phi" if around.get("value").is_some_and(|value| value.as_f64() == Some(0.0)) => Of::Nothing,
            "phi"
                if around.get(above).is_some_and(|at| at["value"].as_f64().is_some_and(|v| v.abs() <= 1e-9 * size)) =>
            {
                Of::Nothing
            }
            "phi" if smooth => Of::Angle(1e-4),
            "sign_changes" if smooth => Of::Angle(1e-6),
            "phi" | "sign_changes" | "name" | "scene" | "verdict" => Of::Nothing,
            _ => Of::Same,
        }
    };
    let reading = Reading { of: &of, around: &["sign_changes"], followers: &["drives"] };
    reading.holds(image, printed(scene, &SAME), printed(scene, image))
}

/// Seen to find a spring with its preload at φ = 0 instead of at the least position.
#[test]
fn rotated() {
    for_all(4100, 8, (any(), rotation()), |(scene, image)| holds(scene, image));
}

/// Seen to find a power from the speed without its sign.
#[test]
fn mirrored() {
    for_all(4200, 8, any(), |scene| holds(scene, &MIRROR));
}

/// Seen to find the inertia of a lever divided by the transmission instead of its square.
#[test]
fn scaled() {
    for_all(4300, 8, (any(), scaling()), |(scene, image)| holds(scene, image));
}

/// Seen to find the torque of the first follower alone on the shaft.
#[test]
fn permuted() {
    for_all(4400, 8, any(), |scene| holds(scene, &PERMUTATION));
}

/// At which speeds a follower of one mass leaves its cam, and the extremes of its loads, as its drive has them.
fn holds_of_the_drive(scene: &Scene, compared: &Cell<usize>) -> Result<(), TestCaseError> {
    let files = tappet(scene, true);
    if ["groove", "conjugate"].iter().any(|both| files.scene["geometry"]["contour"] == *both) {
        return Ok(());
    }
    let arguments = ["--json", "-o", "out"].map(str::to_owned);
    let found = files.printed("forces", &arguments).map_err(TestCaseError::reject)?;
    let w = scene.w;
    let started = |files: &Files, w: f64| -> Result<Run, TestCaseError> {
        let mut files = files.clone();
        files.scene["drive"]["speed"] = w.into();
        let resolved = files.resolved().map_err(TestCaseError::reject)?;
        let run = resolved.scene.build().and_then(|drive| Run::of(drive, &[], &[]));
        run.map_err(|fault| TestCaseError::reject(fault.to_string()))
    };
    let moved = |run: &mut Run, time: f64| run.to(time).map_err(|fault| TestCaseError::fail(fault.to_string()));
    let keeping = &found["drives"][0]["keeping"];
    let lift_off = keeping["lift_off_speed"]["value"].as_f64().filter(|_| keeping.is_object());
    if keeping.is_object() && lift_off.is_none_or(|from| from > w.abs() * (1.0 + NEAR)) {
        let quantities = found["drives"][0]["quantities"].as_array().expect("a list");
        let sizes = |quantity: &&Value| COMPARED.iter().find(|(name, _)| quantity["quantity"] == *name);
        for (quantity, (_, output)) in quantities.iter().filter_map(|quantity| Some((quantity, sizes(&quantity)?))) {
            let at =
                |key: &str| [&quantity[key]["phi"], &quantity[key]["value"]].map(|v| v.as_f64().expect("a number"));
            let size = at("largest")[1].abs().max(at("least")[1].abs());
            for [phi, value] in ["largest", "least"].map(at) {
                let mut run = started(&files, w)?;
                // On either side of a jump.
                let mut miss = f64::INFINITY;
                let time = (phi * w.signum()).rem_euclid(TAU) / w.abs() + TAU / w.abs();
                for beside in [-SIDE, 0.0, SIDE] {
                    moved(&mut run, time * (1.0 + beside))?;
                    miss = miss.min((run.get(output) - value).abs());
                }
                prop_assert!(miss <= 1e-6 * size, "{output} at {phi}: off by {miss:e} of {size:e}");
            }
        }
    }
    let Some(from) = lift_off.filter(|from| *from > 0.0) else { return Ok(()) };
    compared.set(compared.get() + 1);
    for factor in [1.0 - NEAR, 1.0 + NEAR] {
        let mut run = started(&files, (factor * from).copysign(w))?;
        moved(&mut run, 2.0 * TAU / (factor * from))?;
        let leaves = run.drive.events().count() > 0;
        prop_assert!(leaves == (factor > 1.0), "{factor} of {from}: {leaves}");
    }
    Ok(())
}

/// This part above and below a speed of lift-off.
const NEAR: f64 = 1e-3;
/// This part beside a place.
const SIDE: f64 = 1e-9;
/// Quantities and the outputs that they are.
const COMPARED: [(&str, &str); 2] = [("follower_force", "force"), ("torque", "tau")];

/// Seen to find the weight of a follower of one mass left out.
#[test]
fn of_the_drive() {
    let compared = Cell::new(0);
    // A spring that keeps the contact at rest.
    let pressed = any().prop_map(|mut scene| {
        let follower = &mut scene.followers[0];
        let force = follower.m * follower.body.stroke * scene.w * scene.w;
        follower.preload.get_or_insert([0.0; 2])[0] += 2.0 * force;
        scene
    });
    for_all(4500, 32, pressed, |scene| holds_of_the_drive(scene, &compared));
    assert!(compared.get() >= 8, "{compared:?}");
}
