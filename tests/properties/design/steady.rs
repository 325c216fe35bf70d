//! `steady`: the periodic motions of a machine.

use super::super::scenes::{CamScene, Model};
use super::super::scenes::{MachineScene, Torque, backlash, machine, output, shaft};
use super::*;
use camdrive::drives::AnyDrive;
use camdrive::drives::rigid_machine::Follower;
use camdrive_design::overview;
use camdrive_design::periodic_turn;
use camdrive_design::resource::{Resource, Scene};
use camdrive_design::steady::of_drive;

/// With a motor, which selects motions.
pub fn driven() -> impl Strategy<Value = MachineScene> {
    machine().prop_filter("a motor", |scene| matches!(scene.torque, Torque::Kloss(_)))
}

pub fn files(scene: &MachineScene, image: &Image) -> Files {
    let mut files = Files::default();
    // Mechanisms behind the cams are left out.
    let follower = |follower: &Follower| {
        let cam = files.law(&image.law(&follower.cam, LENGTH));
        json!({"m": image.even(follower.m, MASS), "cam": cam})
    };
    let followers = image.order(scene.followers.iter().map(follower).collect());
    let Torque::Kloss([torque, slip, speed, lag]) = scene.torque else { unreachable!() };
    let mut motor = json!({
        "kind": "kloss", "M_k": image.even(torque, TORQUE), "s_k": slip, "w_s": image.odd(speed, RATE),
    });
    if lag > 0.0 {
        motor["lag"] = image.even(lag, TIME).into();
    }
    files.scene = json!({
        "name": "random", "model": "RigidMachine", "machine": {"J0": image.even(scene.j0, INERTIA)},
        "follower": followers, "motor": motor,
    });
    files
}

fn printed(scene: &MachineScene, image: &Image) -> Result<Value, String> {
    files(scene, image).printed("steady", &["--json".to_owned(), option("load", image.odd(scene.load, TORQUE))])
}

fn holds(scene: &MachineScene, image: &Image) -> Result<(), TestCaseError> {
    let Torque::Kloss([scale, ..]) = scene.torque else { unreachable!() };
    let of = |key: &str, _: &str, around: &Map<String, Value>| {
        let at_zero = |sign, size| match image.turn == 0.0 {
            true => Of::Number(TORQUE, sign, [1e-8, size]),
            false => Of::Nothing,
        };
        // The energy after a turn is right to a rounding, which the motion shows magnified where disturbances hardly decay.
        let decay = around.get("growth").and_then(Value::as_f64).map_or(1.0, |growth| 1.0 - (-growth.abs()).exp());
        let error = 1e-10 + f64::EPSILON / decay;
        match key {
            "period" | "lost_periods" => Of::Number(TIME, Sign::Even, [error, 0.0]),
            "mean_speed" | "least_speed" | "largest_speed" => Of::Number(RATE, Sign::Odd, [error, 0.0]),
            "growth" => Of::Number(NUMBER, Sign::Even, [1e-6, 1.0]),
            "energy" => at_zero(Sign::Even, 0.0),
            "torque" => at_zero(Sign::Odd, scale),
            // The turn has its own relation below.
            "load" | "verdict" | "turn" | "dwells" | "harmonics" | "resonances" => Of::Nothing,
            _ => Of::Same,
        }
    };
    let reading = Reading { of: &of, around: &[], followers: &[] };
    reading.holds(image, printed(scene, &SAME), printed(scene, image))
}

/// Seen to find least and largest speeds that were read from samples.
#[test]
fn rotated() {
    for_all(100, 8, (driven(), rotation()), |(scene, image)| holds(scene, image));
}

/// Seen to find the torque of the motor at the speed without its sign.
#[test]
fn mirrored() {
    for_all(200, 8, driven(), |scene| holds(scene, &MIRROR));
}

/// Seen to find motions of more than a second left out.
#[test]
fn scaled() {
    for_all(356, 8, (driven(), scaling()), |(scene, image)| holds(scene, image));
}

/// Seen to find the inertia of the first follower alone at φ = 0.
#[test]
fn permuted() {
    for_all(400, 8, driven(), |scene| holds(scene, &PERMUTATION));
}

/// The largest size of an output over a turn of a drive that has started, at small steps and by a parabola through three of them.
fn largest(mut drive: AnyDrive, name: &str, period: f64) -> [f64; 2] {
    const STEPS: usize = 20_000;
    let output = drive.descriptions().iter().position(|d| d.name == name).expect("the output");
    let step = period / STEPS as f64;
    let mut values = vec![drive.get(output).unwrap()];
    for k in 0..STEPS {
        drive.advance(k as f64 * step, step).unwrap();
        values.push(drive.get(output).unwrap());
    }
    let summit = |v: &[f64]| {
        let (rise, bend) = (0.5 * (v[2] - v[0]), v[2] - 2.0 * v[1] + v[0]);
        let inside = bend != 0.0 && rise.abs() <= bend.abs();
        if inside { (v[1] - 0.5 * rise * rise / bend).abs().max(v[1].abs()) } else { v[1].abs() }
    };
    [
        values.iter().fold(0.0, |most: f64, value| most.max(value.abs())),
        values.windows(3).map(summit).fold(values[0].abs(), f64::max),
    ]
}

/// What `check` and `steady` say of the periodic motion is what the drive does.
fn figures_agree(scene: Scene) -> Result<(), TestCaseError> {
    let resource = Resource::new("x", scene);
    let found = of_drive(&resource, None, Vec::new()).map_err(|fault| TestCaseError::reject(fault.to_string()))?;
    let Some(turn) = &found.turn else { return Err(TestCaseError::reject("no periodic motion")) };
    let figures = overview::of(&resource).figures;
    for range in &turn.outputs {
        let (part, j) = range.part();
        let called = match part {
            "q" => "largest_deformation",
            "tau" => "largest_torque",
            "force" => "largest_force",
            _ => continue,
        };
        let name = if j == 0 { called.to_owned() } else { format!("follower[{j}].{called}") };
        let size = range.peak().value.abs();
        let figure = figures.iter().find(|figure| figure.name == name).map(|figure| figure.value);
        prop_assert_eq!(figure, Some(size), "{}", name);
        let drive = periodic_turn::started(&resource.scene, None, 0.0).unwrap().0;
        let [reached, summit] = largest(drive, &range.output, turn.period);
        // Just beside an event a step of this size does not come.
        let apart = if turn.impacts.iter().flatten().any(|impacts| *impacts > 0.0) { f64::INFINITY } else { 1e-6 };
        prop_assert!(size >= reached * (1.0 - 1e-9), "{}: {} for {}", range.output, size, reached);
        prop_assert!(size <= summit * (1.0 + apart), "{}: {} for {}", range.output, size, summit);
    }
    Ok(())
}

/// Seen to find an extreme that was left at a sample.
#[test]
fn figures_of_check_are_those_of_steady_and_of_the_drive() {
    let drives = prop_oneof![output(), shaft(Model::Shaft, 10.0), shaft(Model::LinearShaft, 10.0), backlash()];
    // Below, more than 48 vibrations a turn fall between the points.
    let slow = drives.prop_filter("few vibrations in a turn", |scene: &CamScene| {
        let inertia = if scene.model == Model::Output { scene.m } else { scene.second };
        let natural = (scene.c / inertia).sqrt();
        natural < 40.0 * scene.w.abs() && scene.b > 0.02 * natural * inertia
    });
    for_all(500, 24, slow, |scene| {
        let (model, values) = scene.resolved();
        let variant = match model {
            "ElasticCamDrive.output" => "ElasticOutput",
            "ElasticCamDrive.shaft" => "ElasticShaft",
            other => other,
        };
        figures_agree(serde_json::from_value(json!({ variant: values })).expect("a scene"))
    });
}

/// The same for every example at constant speed.
#[test]
fn figures_of_the_examples_agree() {
    let examples = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples");
    let mut count = 0;
    for folder in std::fs::read_dir(examples).expect("the examples") {
        let Ok(scene) = scene::read(&folder.expect("a folder").path().join("scene.toml")) else { continue };
        match figures_agree(scene.scene) {
            Ok(()) => count += 1,
            Err(TestCaseError::Reject(_)) => {}
            Err(TestCaseError::Fail(reason)) => panic!("{}: {reason}", scene.name),
        }
    }
    assert!(count >= 6, "{count} examples");
}
