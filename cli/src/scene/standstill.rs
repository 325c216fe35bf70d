//! Checks that the motor of a train can start against its load, keep its speed, and hold its angle.

use crate::document::{Section, units::short};
use camdrive::drives::drive_train::{Machine, Scene, Shaft, Start};
use camdrive::drives::shaft::motor::{Reference, Servo, Source};
use camdrive::drives::shaft::train::switching::Instant;
use camdrive::drives::shaft::train::{InputValues, MOST_FOLLOWERS, MOST_STATES, Modes, Train};
use camdrive::numerics::double_double::Double;
use std::f64::consts::TAU;

/// Angles in a turn for the static torque: every degree.
const ANGLES: usize = 360;

/// Refuses a motor that its load stops at the start or in the first turn from rest. Notes a motor that cannot keep a speed, and an
/// unstable position loop.
///
/// From rest a shaft reaches an angle only if the motor's work ∫ M dφ exceeds the work of the static loads up to there: inertia
/// gives no work, damping and impacts take more. M is at most the largest torque of the motor.
pub fn check(root: &Section<'_>, scene: &Scene) -> Vec<String> {
    let mut notes = Vec::new();
    let Shaft::Free(machine) = &scene.shaft else { return notes };
    let [at_rest, most] = torques(&machine.motor.source).map(|torque| torque * machine.motor.transmission.ratio);
    let sense = if at_rest < 0.0 { -1.0 } else { 1.0 };
    let Some(turn) = turn(scene, machine, sense) else { return notes };
    if let Source::Servo(servo) = &machine.motor.source {
        let inertia = turn[1..].iter().map(|[_, inertia]| inertia).sum::<f64>() / ANGLES as f64;
        notes.extend(unstable(servo, machine, inertia));
    }
    if scene.start == Start::SteadyState || at_rest.is_nan() || turn.iter().all(|[torque, _]| *torque == 0.0) {
        return notes;
    }
    // The torque of the load at the start, and its mean up to each later angle.
    let mut taken = vec![turn[0][0]];
    let mut work = 0.0;
    for (i, [torque, _]) in turn.iter().enumerate().skip(1) {
        work += torque;
        taken.push(work / i as f64);
    }
    if machine.w_start != 0.0 {
        if taken[ANGLES] >= most.abs() {
            notes.push(format!(
                "`motor`: the motor cannot keep the speed: at most {} N.m on the shaft, whose loads take {} N.m on average",
                short(most.abs()),
                short(taken[ANGLES])
            ));
        }
        return notes;
    }
    let far = (1..=ANGLES).fold(1, |far, i| if taken[i] > taken[far] { i } else { far });
    let (has, takes, place) = if at_rest.abs() <= taken[0] {
        (at_rest.abs(), taken[0], "at the start".to_owned())
    } else if most.abs() <= taken[far] {
        let degrees = 360.0 * far as f64 / ANGLES as f64;
        (most.abs(), taken[far], format!("on average over the first {degrees} deg"))
    } else {
        return notes;
    };
    let said = format!(
        ": the motor cannot start: {} N.m on the shaft, its load takes {} N.m {place}",
        short(has),
        short(takes)
    );
    let hint = "choose a stronger motor, a higher `ratio`, smaller loads, another `start.phi_start` or a start at speed (`start.w_start`)";
    let fault = root.fault_at("motor", said).of("motor");
    root.faults.report(fault.admissible(format!("more than {} N.m on the shaft", short(takes))).hint(hint));
    notes
}

/// The torque of the rotor at rest, and the largest in its sense; NaN if the sense of rotation is unknown.
fn torques(source: &Source) -> [f64; 2] {
    match source {
        Source::None | Source::Input => [f64::NAN; 2],
        Source::Constant(torque) => [*torque; 2],
        Source::Kloss(kloss) => [kloss.at(0.0), kloss.breakdown_torque.copysign(kloss.synchronous_speed)],
        Source::Table(table) => {
            let at_rest = table.torque(table.piece(0.0), 0.0);
            let most = table.torques.iter().fold(at_rest.abs(), |most, torque| most.max(torque * at_rest.signum()));
            [at_rest, most]
        }
        Source::Servo(servo) => match &servo.reference {
            // Without an integral the servo demands no more than this.
            Reference::Constant(w) if servo.integral == 0.0 && servo.position.is_none() => {
                [servo.limit.min(servo.proportional * w.abs()).copysign(*w); 2]
            }
            Reference::Constant(w) | Reference::Ramp(w) => [servo.limit.copysign(*w); 2],
            Reference::Series(_, series) => [servo.limit.copysign(series.a[0]); 2],
            Reference::Input => [f64::NAN; 2],
        },
    }
}

/// The torque of the loads on a shaft that turns slowly in this sense, and its inertia: at the start, and in the middle of each of
/// equal steps of a turn. None if a follower has no equilibrium.
fn turn(scene: &Scene, machine: &Machine, sense: f64) -> Option<Vec<[f64; 2]>> {
    let mut still = machine.clone();
    still.motor.source = Source::None;
    let train = Train::new(Shaft::Free(still), scene.followers.clone());
    let forces = [0.0; MOST_FOLLOWERS];
    let input_values = InputValues { shaft: [0.0; 2], tau: 0.0, torque: 0.0, reference: 0.0, lag: 0.0, forces };
    let at = |steps: f64| {
        let phi = Double::from(machine.phi_start + sense * TAU * steps / ANGLES as f64);
        let (mut modes, mut now) = (Modes::default(), Instant { phi, y: [0.0; MOST_STATES], input_values });
        modes.segments = train.segments(&train.angles(phi, &now.y), sense > 0.0);
        train.rest(&mut modes, &mut now).ok()?;
        modes.segments = train.segments(&train.angles(phi, &now.y), sense > 0.0);
        let (functions, dynamics) = train.instant(&modes, phi, &now.y, &now.input_values);
        Some([-sense * functions.inertia * dynamics.a, functions.inertia])
    };
    std::iter::once(0.0).chain((0..ANGLES).map(|i| i as f64 + 0.5)).map(at).collect()
}

/// The position loop of a servo on this inertia of the shaft, by Routh's criterion on
/// J s³ + (K_p + b) s² + (K_p K_v + K_i) s + K_i K_v, J and b at the rotor.
fn unstable(servo: &Servo, machine: &Machine, inertia: f64) -> Option<String> {
    let (gain, transmission) = (servo.position?, machine.motor.transmission);
    let square = transmission.ratio * transmission.ratio;
    let rotor = if transmission.coupling.is_some() { transmission.rotor } else { 0.0 };
    let (inertia, damping) = (inertia / square + rotor, servo.proportional + machine.friction.unwrap_or(0.0) / square);
    let slack = inertia * servo.integral - damping * servo.proportional;
    let most = damping * servo.integral / slack;
    (slack > 0.0 && gain >= most).then(|| {
        format!(
            "`motor.K_v`: {} 1/s makes the position loop unstable: with {} kg.m2 at the rotor it is stable below {} 1/s; choose a \
             smaller K_v or K_i, or a larger K_p",
            short(gain),
            short(inertia),
            short(most)
        )
    })
}
