//! Contact and impact of all followers with backlash at once.
//!
//! **Contact.** With α = φ̈, F_i(α) = m1 (U″ φ̇² + U′ α) + S − F_L1 for each follower at its flank, the set in contact follows from
//!
//! J_s α + Σ σ_i U_i′ max(0, σ_i F_i(α)) = T_s,  contact i holds where σ_i F_i(α) > 0,
//!
//! whose left side grows with α, so the solution is unique. J_s, T_s are inertia and torque without the contacts.
//!
//! **Impact.** All velocities except ẋ1 and φ̇ stay. With Δ = Δφ̇ and P_j(Δ) = m1 (−(1 + e) ż⁻ + U′ Δ) for all that touch or hit,
//!
//! J_s Δ + Σ σ_j U_j′ max(0, σ_j P_j(Δ)) = 0.
//!
//! P_j = 0 means that the flank recedes from m1 and the contact opens. The loss is Σ ½ (1 − e) |P| |ż⁻|.
//!
//! Symbols: σ = 1 on flank A, −1 on flank B; P impulse on m1 (N·s) in the sense of y; z gap (m).
//! Source: F. Pfeiffer, C. Glocker, *Multibody Dynamics with Unilateral Contacts*, Wiley 1996, chapters 5, 6, 8.

use super::{Functions, InputValues, MOST_FOLLOWERS, MOST_STATES, Modes, Point, Train};
use crate::drives::follower::contact::{self, Flank, Mode};
use crate::numerics::double_double::Double;

/// A follower at its flank: its force max(0, σ (offset + slope α)) acts on the shaft with σ U′.
#[derive(Clone, Copy, Default)]
struct Member {
    sigma: f64,
    slope: f64,
    offset: f64,
    gain: f64,
}

impl Member {
    fn force(&self, alpha: f64) -> f64 {
        self.offset + self.gain * alpha
    }

    fn pressed(&self, alpha: f64) -> f64 {
        self.sigma * (self.sigma * self.force(alpha)).max(0.0)
    }
}

/// α of α + Σ U′ pressed(α)/J = `free`.
fn balance(members: &[Member], inertia: f64, free: f64) -> f64 {
    let excess = |alpha: f64| alpha - free + members.iter().map(|m| m.slope * m.pressed(alpha)).sum::<f64>() / inertia;
    let (mut low, mut high) = (f64::NEG_INFINITY, f64::INFINITY);
    for kink in members.iter().map(|m| -m.offset / m.gain).filter(|kink| kink.is_finite()) {
        if excess(kink) <= 0.0 { low = low.max(kink) } else { high = high.min(kink) }
    }
    // A place between the kinks next to the solution shows which contacts hold there.
    let probe = match (low.is_finite(), high.is_finite()) {
        (true, true) => 0.5 * (low + high),
        (true, false) => low + low.abs().max(1.0),
        (false, true) => high - high.abs().max(1.0),
        (false, false) => free,
    };
    let (mut weight, mut torque) = (inertia, 0.0);
    for m in members.iter().filter(|m| m.sigma * m.force(probe) > 0.0) {
        weight += m.slope * m.gain;
        torque += m.slope * m.offset;
    }
    if inertia.is_finite() { (inertia * free - torque) / weight } else { free }
}

/// The train at an instant.
pub struct Instant {
    /// φ (rad), within a turn if the shaft is free.
    pub phi: Double,
    /// The states.
    pub y: [f64; MOST_STATES],
    /// The external values.
    pub input_values: InputValues<f64>,
}

/// These modes with all contacts at the given flanks open.
fn opened(modes: &Modes, at_flank: &[Option<Flank>; MOST_FOLLOWERS]) -> Modes {
    let mut open = *modes;
    let at_flank = at_flank.iter().zip(&mut open.stands).filter(|(flank, _)| flank.is_some());
    at_flank.for_each(|(_, stand)| stand.contact = Mode::Free);
    open
}

/// The result of impacts.
#[derive(Clone, Copy, Debug, Default)]
pub struct Strike {
    /// Δφ̇.
    pub turn: f64,
    /// P of each follower.
    pub impulses: [f64; MOST_FOLLOWERS],
    /// ż⁺ of each follower that touched or hit.
    pub after: [f64; MOST_FOLLOWERS],
    /// Energy lost (J).
    pub losses: [f64; MOST_FOLLOWERS],
}

impl Train {
    /// Functions of the angle and accelerations at an instant.
    pub fn instant(
        &self,
        modes: &Modes,
        phi: Double,
        y: &[f64],
        input_values: &InputValues<f64>,
    ) -> (Functions<f64>, super::Dynamics<f64>) {
        let angles = self.angles(phi, y);
        let functions = Functions::at(self, modes, &angles);
        let dynamics = self.dynamics(&Point { modes, y, f: &functions, input_values });
        (functions, dynamics)
    }

    /// φ̇ (rad/s).
    pub fn speed(&self, now: &Instant) -> f64 {
        if self.machine().is_some() { now.y[1] } else { now.input_values.shaft[0] }
    }

    /// J without the followers at a flank; infinite for a driven shaft.
    fn carried(&self, functions: &Functions<f64>) -> f64 {
        if self.machine().is_some() { functions.inertia } else { f64::INFINITY }
    }

    /// φ̈, and N of each follower at a flank if those that press stay; σ N is negative if the follower leaves.
    pub fn pressing(
        &self,
        modes: &Modes,
        at_flank: &[Option<Flank>; MOST_FOLLOWERS],
        now: &Instant,
    ) -> ([f64; MOST_FOLLOWERS], f64) {
        let (modes, w) = (opened(modes, at_flank), self.speed(now));
        let (f, d) = self.instant(&modes, now.phi, &now.y, &now.input_values);
        let point = Point { modes: &modes, y: &now.y, f: &f, input_values: &now.input_values };
        let mut members = [Member::default(); MOST_FOLLOWERS];
        for (j, flank, p) in self.touching(at_flank) {
            let (member, [u, u1, u2]) = (&mut members[j], f.cams[j]);
            let own = p.on_m1(&self.follower(j, &point, w), [u + flank.pick(0.0, p.s), u1 * w]);
            let offset = p.m1 * u2 * w * w + d.spring[j] - own;
            *member = Member { sigma: flank.sign(), slope: u1, offset, gain: p.m1 * u1 };
        }
        let alpha = balance(&members, self.carried(&f), d.a);
        (members.map(|member| member.force(alpha)), alpha)
    }

    /// The followers at these flanks.
    pub fn touching(
        &self,
        at_flank: &[Option<Flank>; MOST_FOLLOWERS],
    ) -> impl Iterator<Item = (usize, Flank, contact::Parameters)> {
        let of = |(j, flank): (usize, &Option<Flank>)| Some((j, (*flank)?, self.clearance(j)?));
        at_flank.iter().enumerate().filter_map(of)
    }

    /// The result when followers hit their flanks while others touch theirs.
    pub fn strike(&self, modes: &Modes, at_flank: &[Option<Flank>; MOST_FOLLOWERS], now: &Instant) -> Strike {
        let ((f, _), y) = (self.instant(&opened(modes, at_flank), now.phi, &now.y, &now.input_values), &now.y);
        let mut members = [Member::default(); MOST_FOLLOWERS];
        let mut strike = Strike::default();
        for (j, flank, p) in self.touching(at_flank) {
            let (u1, before) = (f.cams[j][1], y[self.layout.followers[j] + 1]);
            let offset = -p.m1 * (1.0 + p.e) * before;
            members[j] = Member { sigma: flank.sign(), slope: u1, offset, gain: p.m1 * u1 };
        }
        strike.turn = balance(&members, self.carried(&f), 0.0);
        for (j, _, p) in self.touching(at_flank) {
            let (member, before) = (&members[j], y[self.layout.followers[j] + 1]);
            strike.impulses[j] = member.pressed(strike.turn);
            strike.losses[j] = 0.5 * (1.0 - p.e) * (strike.impulses[j] * before).abs();
            let held = strike.impulses[j] != 0.0;
            strike.after[j] = if held { -p.e * before } else { before - member.slope * strike.turn };
        }
        strike
    }

    /// Changes the velocities by a strike.
    pub fn take_up(
        &self,
        strike: &Strike,
        at_flank: &[Option<Flank>; MOST_FOLLOWERS],
        slopes: &[f64; MOST_FOLLOWERS],
        y: &mut [f64],
    ) {
        let turn = strike.turn;
        if let Some(machine) = self.machine() {
            y[1] += turn;
            if machine.motor.transmission.coupling.is_some() {
                y[self.layout.coupling + 1] -= turn;
            }
        }
        for (j, follower) in self.followers.iter().enumerate() {
            let struck = at_flank[j].map(|_| [strike.impulses[j], strike.after[j]]);
            follower.joint.jolt(&mut y[self.layout.followers[j]..], turn, slopes[j], struck);
        }
    }
}
