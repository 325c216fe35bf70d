//! The train at rest under its loads, the shaft held.
//!
//! * elastic output, and m2 behind its spring: c q = F_L(x + q), hence q = (m g + F₀ − F_v + P + F − c_r (x − y₀))/(c + c_r);
//! * elastic shaft: c q = U′(ψ) F_L(U(ψ)), ψ = φ + q, followed from F_L = 0 on, as long as c > d(U′F_L)/dψ: beyond, it snaps through;
//! * clearance: m1 lies on flank A where N = −c q − F_L1 ≥ 0, on flank B where N ≤ 0 there. Without loads it may be anywhere, and
//!   a spring may hold it between them: neither is a start.
//!
//! Source: derived here; the stability condition is that of a conservative system (second derivative of the potential).

use super::switching::Instant;
use super::{Functions, Joint, Modes, Train};
use crate::drives::Fault;
use crate::drives::follower::contact::{Flank, Mode};
use crate::drives::limits::refused_start;

/// Steps of the load from nothing on; between them Newton's method needs a few iterations.
const STEPS: usize = 64;
const ITERATIONS: usize = 8;

impl Train {
    /// Puts the springs to where they balance the loads.
    ///
    /// # Errors
    /// Where nothing holds a tool, or m1 at a flank, and where an elastic shaft snaps through.
    pub fn rest(&self, modes: &mut Modes, now: &mut Instant) -> Result<(), Fault> {
        let Instant { phi, y, given } = now;
        let angles = self.angles(*phi, y);
        let f = Functions::at(self, modes, &angles);
        for (j, follower) in self.followers.iter().enumerate() {
            let (at, load) = (self.layout.followers[j], &follower.load);
            let (place, push) = (f.cams[j][0], f.process[j] + given.forces[j]);
            let balance = |c: f64, m: f64, x: f64| {
                let stiffness = c + load.stiffness();
                let q = (load.constant_part(m) + push - load.stiffness() * x) / stiffness;
                if stiffness > 0.0 { Ok(q) } else { Err(nothing_holds(j, "its tool")) }
            };
            match follower.joint {
                Joint::Rigid => {}
                Joint::Output(p, _) => (y[at], y[at + 1]) = (balance(p.c, p.m, place)?, 0.0),
                Joint::Shaft(_) => y[at] = self.twist(modes, (j, push), &angles)?,
                Joint::Backlash(p) => {
                    let mut lie = |flank: Flank| {
                        let x1 = place + flank.pick(0.0, p.s);
                        let mut force = -self.load_of_m1(j, [x1, 0.0], f.process[j], given.forces[j]);
                        if p.m2 > 0.0 {
                            y[at + 2] = balance(p.c, p.m2, x1)?;
                            force -= p.c * y[at + 2];
                        }
                        (modes.contacts[j], modes.beyond[j]) = (Mode::Contact(flank), flank == Flank::B);
                        Ok(force)
                    };
                    let on_a = lie(Flank::A)?;
                    if on_a < 0.0 && p.s.is_infinite() {
                        return Err(nothing_holds(j, "it on its cam"));
                    }
                    if on_a <= 0.0 && p.s.is_finite() {
                        let on_b = lie(Flank::B)?;
                        if on_a < 0.0 && on_b > 0.0 || on_a == 0.0 && on_b == 0.0 {
                            return Err(nothing_holds(j, "it at a flank of its clearance"));
                        }
                        // A spring that is relaxed just there holds it.
                        if on_a == 0.0 {
                            lie(Flank::A)?;
                        }
                    }
                }
            }
        }
        Ok(())
    }

    /// q of the elastic shaft of follower j, whose process force and input are `push`.
    fn twist(&self, modes: &Modes, (j, push): (usize, f64), angles: &[f64]) -> Result<f64, Fault> {
        let follower = &self.followers[j];
        let Joint::Shaft(p) = follower.joint else { return Ok(0.0) };
        let segment = modes.segments[1 + j][0];
        let (mut q, phi) = (0.0, angles[0]);
        for step in 1..=STEPS {
            let part = step as f64 / STEPS as f64;
            for _ in 0..ITERATIONS {
                let [u, u1, u2, ..] = follower.rigid.cam.at_in(segment, phi + q).0;
                let force = follower.load.constant_part(p.m) + push - follower.load.stiffness() * u;
                let left = p.c * q - part * u1 * force;
                let slope = p.c - part * (u2 * force - u1 * u1 * follower.load.stiffness());
                if !(slope > 0.0) {
                    let message = format!(
                        "start.mode = equilibrium: the shaft of follower {} snaps through under {} % of its loads; \
                         choose a stiffer shaft, smaller loads or at_rest",
                        j + 1,
                        (100.0 * part).round()
                    );
                    return Err(refused_start(message));
                }
                q -= left / slope;
            }
        }
        Ok(q)
    }
}

fn nothing_holds(j: usize, what: &str) -> Fault {
    refused_start(format!(
        "start.mode = equilibrium: nothing holds follower {} where it is: neither spring nor load holds {what}; choose at_rest, \
         or give the follower a spring or a force",
        j + 1
    ))
}
