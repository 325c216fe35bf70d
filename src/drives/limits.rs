//! What a call may ask: angles that are numbers, and no more than the work of one call ([`crate::numerics::work`]).

use super::{Fault, Number, Rounded};
use std::f64::consts::TAU;

/// The greatest angle [rad]: beyond it neighbouring numbers are an eighth of a radian apart, and more.
pub const LARGEST_ANGLE: f64 = 1e15;

/// The greatest angular velocity of a drive [rad/s]: ten million revolutions per minute.
pub const FASTEST: f64 = 1e6;

/// The greatest sizes of the inputs phi [rad], w [rad/s] and a [rad/s²]. The last one follows from differences over as short
/// steps as a simulator may take, so that it may be any number.
pub const INPUTS: [f64; 3] = [LARGEST_ANGLE, FASTEST, f64::MAX];

/// What is said where a call ends since its work is used up: it was to go on from one time to another and has `reached` a time
/// between them [s], with what turns and how fast [rad/s]; the `hint` tells what would help beside shorter steps.
pub fn too_much([from, to]: [f64; 2], reached: f64, (turning, speed): (&str, f64), hint: &str) -> Fault {
    let length = to - from;
    Fault(format!(
        "the {} s to t = {} s need more than the work of one call: {turning} makes {} turns at {} rad/s, and only t = {} s \
         is reached; shorten the communication step, {hint}",
        Rounded(length),
        Number(to),
        Rounded(length * speed.abs() / TAU),
        Rounded(speed),
        Number(reached)
    ))
}

/// What is said of a saved state that no drive of the scene can be in.
pub fn no_state() -> Fault {
    Fault::new("the serialised state is none of this drive: its numbers do not fit together")
}

/// Refuses a step to the time `to` [s], at which the angle is beyond all that tells where in its turn a shaft is.
pub fn check_angle(angle: f64, to: f64) -> Result<(), Fault> {
    // A comparison with NaN is false.
    if angle.abs() <= LARGEST_ANGLE { Ok(()) } else { Err(beyond(angle, to)) }
}

#[cold]
fn beyond(angle: f64, to: f64) -> Fault {
    Fault(format!(
        "at t = {} s the drive angle is {} rad: beyond {LARGEST_ANGLE:e} rad a number does not tell where in its turn the \
         drive is; shorten the communication step, or lower the speed or the acceleration",
        Number(to),
        Rounded(angle)
    ))
}
