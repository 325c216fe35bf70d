//! Jumps of the inputs: their effect on the masses.

use super::panel::Point;
use super::{Arrival, Run, release};
use crate::drives::EventLog;
use crate::drives::follower::contact::{Bodies, Flank, Mode, Phase};
use crate::drives::follower::flank::FlankMotion;
use crate::numerics::double_double::Double;

/// The motion right before a jump.
pub struct MotionBefore<'a> {
    /// Whether m1 is on a flank.
    pub mode: Mode,
    /// Place and velocity.
    pub point: &'a Point,
}

impl Run {
    /// Takes up a jump of the inputs: masses keep place and velocity, but a mass on a flank follows it and takes up
    /// the impulse m1 Δu̇. A free mass that the jump puts beyond a flank is set on it, and strikes it if it moves
    /// towards it.
    pub fn take_up(
        &mut self,
        bodies: &Bodies,
        flank: &impl FlankMotion,
        before: MotionBefore,
        time: f64,
        log: &mut EventLog,
    ) -> Phase {
        let MotionBefore { mode: from, point: end } = before;
        let place = (Double::from(time), flank.segment(Double::from(time)));
        let u = flank.at(place.1, place.0);
        let jump = [u.0[0] - end.u[0], u.0[1] - end.u[1]];
        let resolution = bodies.resolution(flank, place);
        let mut state = end.state;
        match from {
            Mode::Contact(contact) => {
                state.q = [state.q[0] - jump[0], state.q[1] - jump[1]];
                self.push(bodies.m1 * jump[1], flank.slope(place.1, place.0));
                let (mode, zeros) =
                    if bodies.s == 0.0 { (from, 0) } else { bodies.settle(contact, state.q, &u, resolution) };
                if mode == Mode::Free {
                    log.push(release(contact, place.0, ("force", bodies.force(state.q, &u)[0], "N")));
                }
                Phase { mode, state, zeros }
            }
            Mode::Free => {
                state.zeta = [state.zeta[0] - jump[0], state.zeta[1] - jump[1]];
                // The roundings of the differences above.
                let rounding = [0, 1].map(|n| 8.0 * f64::EPSILON * (u.0[n].abs() + end.u[n].abs()));
                for contact in [Flank::A, Flank::B] {
                    let sign = contact.sign();
                    let beyond = bodies.place(contact) - state.home - state.zeta[0];
                    let resting = beyond.abs() <= rounding[0] && state.zeta[1].abs() <= rounding[1];
                    if !resting && sign * beyond <= 0.0 {
                        continue;
                    }
                    state.q[0] -= beyond;
                    (state.home, state.zeta[0]) = (bodies.place(contact), 0.0);
                    if resting {
                        state.q[1] += state.zeta[1];
                        state.zeta[1] = 0.0;
                        let (mode, zeros) = bodies.settle(contact, state.q, &u, resolution);
                        return Phase { mode, state, zeros };
                    }
                    if sign * state.zeta[1] > 0.0 {
                        return Phase { mode: Mode::Free, state, zeros: 1 };
                    }
                    let contact = Arrival { hit: contact, state, time: place.0, segment: place.1 };
                    return self.strike(bodies, flank, contact, log);
                }
                Phase { mode: Mode::Free, state, zeros: 0 }
            }
        }
    }
}
