//! `steady`: the periodic motions of a machine.

use super::super::scenes::{MachineScene, Torque, machine};
use super::*;
use camdrive::drives::rigid_machine::Follower;

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
