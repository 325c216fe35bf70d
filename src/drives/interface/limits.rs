//! Limits of a call: angles that a number resolves, and the work of one call ([`crate::numerics::work`]).

use super::{Fault, Rounded};

/// The greatest angle (rad): beyond it neighbouring numbers are an eighth of a radian or more apart.
pub const LARGEST_ANGLE: f64 = 1e15;

/// The greatest angular velocity of a drive (rad/s): ten million revolutions per minute.
pub const FASTEST: f64 = 1e6;

/// The greatest angular acceleration of a drive (rad/s²): a shaft at the greatest speed that alternates once a turn.
pub const STEEPEST: f64 = FASTEST * FASTEST;

/// The greatest sizes of the inputs phi (rad), w (rad/s) and a (rad/s²).
pub const INPUTS: [f64; 3] = [LARGEST_ANGLE, FASTEST, STEEPEST];

/// The fault of a communication step that takes more than the work of a call. It was to go on from one time to another and has
/// `reached` a time between them (s); `motion` says what turns and how fast, the `hint` what helps in addition to shorter steps.
pub fn step_too_much([from, to]: [f64; 2], reached: f64, motion: &str, hint: &str) -> Fault {
    Fault::new(format!(
        "the {} s to t = {} s need more work than one call may take: {motion}, and only {} s are done; shorten the \
         communication step, {hint}",
        Rounded(to - from),
        Rounded(to),
        Rounded(reached - from)
    ))
}

/// A growth in a turn below this is none: free motions without damping come back but for roundings.
pub const NEUTRAL: f64 = 1e-9;

/// The reason of a drive that follows an input.
pub const ON_INPUT: &str = "the shaft follows an input, and its motion need not repeat";

/// The reason of a machine of which no speed is known.
pub const NO_SPEED: &str = "no speed is known near which the shaft turns steadily: set start.w_start";

/// The reason at a resonance without damping.
pub const RESONANCE: &str = "no periodic motion exists: the load is in resonance, a Floquet multiplier is 1";

/// Begins the reasons of [`open`].
pub const NOT_REPEATED: &str = "the motion does not repeat within the first ";

/// The reason for a search that ends after so many turns from the start.
pub fn open(turns: usize) -> String {
    match turns {
        0 | 1 => format!("{NOT_REPEATED}turn from its start"),
        turns => format!("{NOT_REPEATED}{turns} turns from its start"),
    }
}

/// The fault of a start whose periodic motion takes more than the work of a call to find; the `hint` says what helps.
pub fn search_too_much(hint: &str) -> Fault {
    no_periodic_motion("the search for the periodic motion needs more work than one call may take", "")
        .motionless(open(0))
        .hint(hint)
}

/// The fault of a start in a periodic motion, which there is not for this `reason`; the `rest` tells what else to choose.
pub fn no_periodic_motion(reason: impl Into<String>, rest: &str) -> Fault {
    let reason = reason.into();
    Fault::named("start.mode", format!(" = steady_state: {reason}{rest}")).motionless(reason)
}

/// The same of a periodic motion that "needs" or "is" something.
pub fn periodic_motion_that(predicate: &str, rest: &str) -> Fault {
    let fault = refused_start(format!("start.mode = steady_state {predicate}{rest}"));
    fault.motionless(format!("a periodic motion {predicate}"))
}

/// The fault of a start that no periodic motion allows.
pub fn refused_start(message: impl Into<String>) -> Fault {
    Fault::new(message).of("start.mode")
}

/// The fault of a saved state that no drive of the scene can have.
pub fn no_state() -> Fault {
    Fault::new("the serialised state does not belong to this drive: its numbers contradict each other")
}

/// Refuses a step to the time `to` (s) at which the angle (rad) is too large to determine the position within a turn.
pub fn check_angle(angle: f64, to: f64) -> Result<(), Fault> {
    // Comparisons with NaN are false.
    if angle.abs() <= LARGEST_ANGLE { Ok(()) } else { Err(beyond(angle, to)) }
}

#[cold]
fn beyond(angle: f64, to: f64) -> Fault {
    let found = if angle.is_finite() { format!("{} rad", Rounded(angle)) } else { "not finite".to_owned() };
    Fault::new(format!(
        "at t = {} s the drive angle is {found}: beyond {LARGEST_ANGLE:e} rad numbers do not resolve the position within a \
         turn; shorten the communication step, or lower the speed or the acceleration",
        Rounded(to)
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_angle_is_refused_beyond_the_greatest_one() {
        assert_eq!([check_angle(LARGEST_ANGLE, 1.0), check_angle(-LARGEST_ANGLE, 1.0)], [Ok(()), Ok(())]);
        for (angle, said) in
            [(-1.5e15, "is -1.5e15 rad: beyond 1e15 rad"), (f64::NAN, "is not finite: beyond 1e15 rad")]
        {
            let told = check_angle(angle, 2.5).unwrap_err().to_string();
            assert!(told.starts_with("at t = 2.5 s the drive angle ") && told.contains(said), "{told}");
        }
        // rad, rad/s, rad/s².
        assert_eq!(INPUTS, [1e15, 1e6, 1e12]);
    }

    #[test]
    fn a_step_that_is_too_much_is_told_with_what_was_done_of_it() {
        let told = step_too_much([1.0, 4.0], 1.5, "the shaft turns", "or rest").to_string();
        assert!(told.starts_with("the 3 s to t = 4 s need more work"), "{told}");
        assert!(told.ends_with("the shaft turns, and only 0.5 s are done; shorten the communication step, or rest"));
    }
}
