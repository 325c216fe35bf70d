//! The two bodies, the contact conditions and the effect of a switching instant on the state.

use super::flank::FlankMotion;
use crate::drives::parameter::parameters;
use crate::motion::Kinematics;
use crate::numerics::double_double::Double;
use crate::numerics::oscillator::Oscillator;
use serde::{Deserialize, Serialize};

/// A flank of the clearance.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Flank {
    /// x1 = U; pushes m1 in +x.
    A,
    /// x1 = U + s; pushes m1 in −x.
    B,
}

/// Position of m1.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Mode {
    /// On a flank.
    Contact(Flank),
    /// Between the flanks.
    #[default]
    Free,
}

impl Flank {
    /// The one of the two that belongs to this flank.
    #[inline(always)]
    pub fn pick<T>(self, a: T, b: T) -> T {
        if self == Flank::A { a } else { b }
    }

    /// σ: the direction of the force that the flank can exert.
    pub fn sign(self) -> f64 {
        self.pick(1.0, -1.0)
    }
}

parameters! {
    /// The bodies.
    Parameters, "backlash" {
        /// Mass at the clearance
        m1 = "m1", "m1", MASS in [1e-9, 1e9] about 1.0, Fixed;
        /// Mass on the spring
        m2 = "m2", "m2", MASS in [1e-9, 1e9] about 1.0, Fixed;
        /// Stiffness of the spring between m1 and m2
        c = "c", "c", STIFFNESS in [1e-6, 1e15] about 1e6, Fixed;
        /// Damping between m1 and m2
        b = "b", "b", DAMPING in [0.0, 1e12] or 0.0 about 100.0, Fixed;
        /// Clearance: flank B is at U + s
        s = "s", "s", LENGTH in [0.0, 1e3] about 1e-4, Fixed;
        /// Coefficient of restitution, 0 plastic, 1 elastic
        e = "e", "e", NUMBER in [0.0, 1.0] or 0.0, Fixed;
    }
}

/// Parameters of which s may be infinite, a value that text formats cannot write.
pub mod one_sided {
    use super::Parameters;
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    /// The value of s without flank B, beyond its range.
    const NONE: f64 = -1.0;

    /// Writes the parameters.
    pub fn serialize<S: Serializer>(parameters: &Parameters, serializer: S) -> Result<S::Ok, S::Error> {
        let s = if parameters.s == f64::INFINITY { NONE } else { parameters.s };
        Parameters { s, ..*parameters }.serialize(serializer)
    }

    /// Reads the parameters.
    pub fn deserialize<'a, D: Deserializer<'a>>(deserializer: D) -> Result<Parameters, D::Error> {
        let parameters = Parameters::deserialize(deserializer)?;
        Ok(Parameters { s: if parameters.s == NONE { f64::INFINITY } else { parameters.s }, ..parameters })
    }
}

/// The masses with their spring and damper, the clearance and the restitution.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Bodies {
    /// Mass at the clearance (kg).
    pub m1: f64,
    /// Mass on the spring (kg).
    pub m2: f64,
    /// Stiffness (N/m).
    pub c: f64,
    /// Damping (N·s/m).
    pub b: f64,
    /// Clearance (m).
    pub s: f64,
    /// Coefficient of restitution.
    pub e: f64,
    /// m2/(m1 + m2), the part of q by which x1 is off the centre of mass.
    pub share: f64,
    /// m2 on the spring, its other end moved by the flank: ω² = c/m2.
    pub bound: Oscillator,
    /// m1 and m2 against each other: ω₂² = c (1/m1 + 1/m2).
    pub relative: Oscillator,
}

/// The relative state of the bodies; x1 = U + `home` + ζ, x2 = x1 + q.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct State {
    /// q = x2 − x1 (m) and q̇ (m/s).
    pub q: [f64; 2],
    /// The zero of ζ (m): 0 (flank A) or s (flank B). Near that flank ζ keeps all its digits.
    pub home: f64,
    /// ζ = x1 − U − `home` (m) and ζ̇ (m/s).
    pub zeta: [f64; 2],
}

/// State after a switching instant.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Phase {
    /// The position of m1.
    pub mode: Mode,
    /// The relative state.
    pub state: State,
    /// The order of the zero with which the gap begins, if it does.
    pub zeros: usize,
}

/// The start of a panel, which determines the panel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Beginning {
    /// The time (s).
    pub start: Double,
    /// The smooth segment of the flank.
    pub segment: usize,
    /// The mode and the state.
    pub phase: Phase,
    /// The longest length of the panel (s).
    pub longest: f64,
}

/// Forces below this part of (m1 + m2) max|Ü| are rounding errors: the terms of F_K cancel near a release.
const FORCE_RESOLUTION: f64 = 1e-12;

/// The bounces of a mass pressed on a flank are over after 1/(1 − e) times the next one. They are summed if that is within this
/// part of the time in which the pressing force changes or the damper absorbs the velocity. The remaining velocity then is less
/// than 1e-7 of what that force produces in such a time, and the error of the sums is the product of both.
const CLOSURE: f64 = 1e-7;

/// With a higher restitution more than ten thousand bounces would precede those that can be summed.
const LIVELY: f64 = 0.999;

/// Such a bounce counts as contact if it is shorter than this part of the shortest time in which flank and spring change: the
/// remaining velocity is 5e-7 of what the pressing force produces in such a time, the mean distance from the flank 1e-13 of the way
/// …
const BRIEF: f64 = 1e-6;

/// … and than this part of m1/b or of the time in which the force turns: the damper absorbs the remaining velocity within some
/// thousand such bounces, over which the mean distance from the flank is 1e-7 of the way in that time.
const DAMPED: f64 = 1e-3;

/// A velocity counts as zero below this part of the velocity that the force resolution gives m1 in the shortest time of any change:
/// 1e-16 of the velocities of the flank.
const FAINT: f64 = 1e-4;

/// Outcome of an impact on a flank.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Impact {
    /// The impulse of the flank on m1 (N·s).
    pub impulse: f64,
    /// The energy lost (J).
    pub loss: f64,
    /// The position of m1 after the impact.
    pub after: Mode,
    /// The order of the zero with which the gap begins, if it does.
    pub zeros: usize,
    /// The energy that the damper absorbs in bounces that count as contact (J).
    pub damped: f64,
    /// The part of `impulse` from bounces that are still to come, summed in closed form (N·s).
    pub bounces: f64,
}

impl Bodies {
    /// The bodies with these parameters.
    pub fn new(&Parameters { m1, m2, c, b, s, e }: &Parameters) -> Self {
        let (cd, bd) = (Double::from(c), Double::from(b));
        // 1/m1 + 1/m2 = (m1 + m2)/(m1 m2).
        let inverse = (Double::from(m1) + Double::from(m2)).divide(Double::from(m1) * Double::from(m2));
        let relative = Oscillator::new(cd * inverse, Double::from(0.5) * bd * inverse);
        let share = m2 / (m1 + m2);
        Bodies { m1, m2, c, b, s, e, share, bound: Oscillator::of_mass(m2, c, b), relative }
    }

    /// The oscillator that moves q.
    pub fn oscillator(&self, mode: Mode) -> &Oscillator {
        match mode {
            Mode::Contact(_) => &self.bound,
            Mode::Free => &self.relative,
        }
    }

    /// The place of a flank relative to flank A (m).
    pub fn place(&self, flank: Flank) -> f64 {
        flank.pick(0.0, self.s)
    }

    /// c q + b q̇, the force of the spring and the damper on m1 (N).
    pub fn link(&self, q: f64, q_dot: f64) -> f64 {
        self.c * q + self.b * q_dot
    }

    /// q̈, q⃛, q⁗ in contact: m2 q̈ = −(c q + b q̇) − m2 ü.
    pub fn bound_derivatives(&self, q: [f64; 2], u: &Kinematics) -> [f64; 3] {
        let q2 = -self.link(q[0], q[1]) / self.m2 - u.0[2];
        let q3 = -self.link(q[1], q2) / self.m2 - u.0[3];
        let q4 = -self.link(q2, q3) / self.m2 - u.0[4];
        [q2, q3, q4]
    }

    /// q̈, q⃛, q⁗ in flight: q̈ = −(1/m1 + 1/m2)(c q + b q̇).
    pub fn free_derivatives(&self, q: [f64; 2]) -> [f64; 3] {
        let inverse = 1.0 / self.m1 + 1.0 / self.m2;
        let q2 = -inverse * self.link(q[0], q[1]);
        let q3 = -inverse * self.link(q[1], q2);
        [q2, q3, -inverse * self.link(q2, q3)]
    }

    /// F_K, dF_K/dt, d²F_K/dt² in contact: F_K = m1 ü − c q − b q̇.
    pub fn force(&self, q: [f64; 2], u: &Kinematics) -> [f64; 3] {
        let [q2, q3, _] = self.bound_derivatives(q, u);
        [
            self.m1 * u.0[2] - self.link(q[0], q[1]),
            self.m1 * u.0[3] - self.link(q[1], q2),
            self.m1 * u.0[4] - self.link(q2, q3),
        ]
    }

    /// z̈, z⃛ in flight: m1 z̈ = c q + b q̇ − m1 ü.
    pub fn gap_derivatives(&self, q: [f64; 2], u: &Kinematics) -> [f64; 2] {
        let [q2, _, _] = self.free_derivatives(q);
        [self.link(q[0], q[1]) / self.m1 - u.0[2], self.link(q[1], q2) / self.m1 - u.0[3]]
    }

    /// The force below which F_K counts as zero (N).
    pub fn resolution(&self, flank_motion: &impl FlankMotion, (time, segment): (Double, usize)) -> f64 {
        FORCE_RESOLUTION * (self.m1 + self.m2) * flank_motion.acceleration(segment, time)
    }

    /// Whether m1, without velocity relative to `flank`, stays on it, and the order of the zero of the gap if not.
    ///
    /// A pressing F_K keeps m1 on the flank. A pulling one releases it at once, z ∝ t². At F_K = 0 the first derivative that is not
    /// zero decides by its sign, z ∝ t³ or slower.
    pub fn settle(&self, flank: Flank, q: [f64; 2], u: &Kinematics, resolution: f64) -> (Mode, usize) {
        let sign = flank.sign();
        let [force, rate, bend] = self.force(q, u).map(|f| sign * f);
        let steady = rate.abs() <= resolution * self.relative.stiffness().sqrt();
        let rising = if steady { bend >= 0.0 } else { rate >= 0.0 };
        if force > resolution || (force >= -resolution && rising) {
            (Mode::Contact(flank), 0)
        } else if force < -resolution {
            (Mode::Free, 2)
        } else {
            (Mode::Free, 3)
        }
    }

    /// The impact of m1 on `flank`; updates the state.
    ///
    /// ż⁺ = −e ż⁻, P = −m1 (1 + e) ż⁻, loss ½ m1 (1 − e²) (ż⁻)². Without a rebound F_K decides whether m1 stays. A rebound against
    /// a pressing force F_K > 0 returns after 2ż⁺/α, α = F_K/m1; the bounces end after 2ż⁺/(α (1 − e)) with the further impulse m1
    /// ż⁺ (1 + e)/(1 − e) and the loss ½ m1 (ż⁺)². If that time is short ([`CLOSURE`], [`BRIEF`]) m1 stays at once and the bounces
    /// are summed. Bounces that the force or the damper ends sooner count as contact; F_K includes their impulse. A pulling force
    /// never ends in sticking. `rate` is the flank's (rad/s).
    pub fn impact(&self, flank: Flank, state: &mut State, u: &Kinematics, rate: f64, resolution: f64) -> Impact {
        let sign = flank.sign();
        // Rounding may show a grazing mass as receding.
        let approach = (sign * state.zeta[1]).min(0.0) * sign;
        // At F_K = 0 bounces would otherwise go on until their velocity underflows.
        let negligible = FAINT * resolution / (self.m1 * (rate + self.relative.rates().1));
        let rebound = if approach.abs() > negligible { -self.e * approach } else { 0.0 };
        // The velocity of x1 rises by ż⁺ − ż⁻, the velocity of x2 stays.
        state.q[1] += state.zeta[1] - rebound;
        state.home = self.place(flank);
        state.zeta = [0.0, rebound];
        let mut impact = Impact {
            impulse: self.m1 * (rebound - approach),
            loss: 0.5 * self.m1 * ((1.0 - self.e) * (1.0 + self.e)) * approach * approach,
            after: Mode::Free,
            zeros: 1,
            damped: 0.0,
            bounces: 0.0,
        };
        // The state as if m1 were stuck.
        let stuck = [state.q[0], state.q[1] + rebound];
        if rebound == 0.0 {
            (impact.after, impact.zeros) = self.settle(flank, stuck, u, resolution);
        } else {
            let [force, change, _] = self.force(stuck, u).map(|f| sign * f);
            let bounce = 2.0 * self.m1 * rebound.abs() / force;
            let turning = (change / force).abs();
            let steady = bounce * (rate + self.relative.rates().0.max(self.bound.rates().0));
            let fading = bounce * (turning + self.b / self.m1);
            let last = 1.0 - self.e;
            let lively = self.e > LIVELY && steady <= BRIEF && fading <= DAMPED;
            if force > resolution && (lively || steady + fading <= CLOSURE * last) {
                (impact.after, impact.zeros) = (Mode::Contact(flank), 0);
                state.q = stuck;
                let rest = 0.5 * self.m1 * rebound * rebound;
                if steady + fading < last {
                    impact.bounces = self.m1 * rebound * (1.0 + self.e) / last;
                    impact.impulse += impact.bounces;
                    impact.loss += rest;
                } else {
                    impact.impulse -= self.m1 * rebound;
                    *if self.b > 0.0 { &mut impact.damped } else { &mut impact.loss } += rest;
                }
            }
        }
        if let Mode::Contact(_) = impact.after {
            state.zeta = [0.0; 2];
        }
        impact
    }
}
