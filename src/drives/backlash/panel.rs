//! A panel: a span of time in one mode over which the flank moves smoothly and by no more than a fraction of its
//! finest harmonic. Within it the motion is known in closed form at any instant.
//!
//! Contact: q is the response of m2 on its spring to −ü as a Chebyshev polynomial ([`ForcedStep`]), exact to rounding
//! at any stiffness. Flight: q is a damped free oscillation, and the gap
//!
//! ζ(t) = ζ₀ + ζ̇₀ t − μ₂ [q(t) − q₀ − q̇₀ t] − ∫₀ᵗ (t − θ) ü(θ) dθ,  μ₂ = m2/(m1 + m2),
//!
//! since the centre of mass moves uniformly. No term cancels while the gap is small.

use super::contact::{Bodies, Flank, Mode, State};
use super::flank::FlankMotion;
use crate::motion::Kinematics;
use crate::numerics::chebyshev;
use crate::numerics::double_double::Double;
use crate::numerics::events::safe_step;
use crate::numerics::forced::{self, ForcedStep};
use crate::numerics::gauss::{ABSCISSAE, STAGES, WEIGHTS};
use crate::numerics::quadrature::Gauss;
use serde::{Deserialize, Serialize};

/// K|w| times the length of a panel: a polynomial of degree 16 then meets u to rounding (see
/// [`crate::motion::MotionLaw::resolution`]), and eight Gauss nodes integrate it.
const ANGLE: f64 = 2.0;

/// ω times the length of a panel, so that a drive at rest has panels of finite length too.
const LONGEST: f64 = 100.0;

/// An oscillation is integrated against eight Gauss nodes per this phase [rad]: error (2/4)¹⁶/16! of the integrand.
const PHASE: f64 = 2.0;

/// Up to this phase [rad] four nodes do: error 4!⁴/(9·8!³) 0.1⁸ = 6e-18 of the integrand.
const SHORT_PHASE: f64 = 0.1;

/// A motion that decays has vanished, e⁻⁴⁰ = 4e-18, after this multiple of its time.
const DECAY: f64 = 40.0;

/// The shortest first step of a flight that begins without velocity, as a part of the shortest time in which anything
/// changes. A mass that is back earlier has moved by 1e-14 of a typical displacement, next to the rounding of x1.
const ARMING: f64 = 1e-7;

/// A panel; see the module.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct Panel {
    /// When it starts [s].
    pub start: Double,
    /// How long it holds [s].
    pub length: f64,
    /// The smooth segment of the flank.
    pub segment: usize,
    /// The segment at the end.
    pub next_segment: usize,
    /// Where m1 is.
    pub mode: Mode,
    /// The state at the start.
    pub state: State,
    /// How many derivatives of the gap, from its value on, are exactly zero at the start.
    pub zeros: usize,
    forced: ForcedStep,
    /// The bound of |u⁗| [m/s⁴].
    fourth: f64,
    /// The force that counts as zero [N].
    resolution: f64,
}

/// What the search in a panel finds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Found {
    /// Nothing up to this time after the start of the panel [s].
    Nothing(f64),
    /// Release from the flank.
    Release(f64),
    /// Impact on the flank.
    Impact(Flank, f64),
}

impl Panel {
    /// The panel that starts at `start` in this state, at most `longest` [s] long.
    pub fn new(
        bodies: &Bodies,
        flank: &impl FlankMotion,
        (start, segment): (Double, usize),
        (mode, state, zeros): (Mode, State, usize),
        longest: f64,
    ) -> Self {
        let first = flank.rate(segment, start, 0.0);
        let mut length = longest.min(LONGEST / bodies.bound.stiffness().sqrt()).min(ANGLE / first);
        // The rate over the panel counts, which is higher where the speed rises.
        while flank.rate(segment, start, length) * length > 1.01 * ANGLE {
            length *= 0.5;
        }
        let (length, next_segment) = flank.stay(segment, start, length);
        let mut panel = Panel {
            start,
            length,
            segment,
            next_segment,
            mode,
            state,
            zeros,
            forced: ForcedStep::default(),
            fourth: flank.fourth(segment, start, length),
            resolution: bodies.resolution(flank, start),
        };
        if let Mode::Contact(_) = mode {
            panel.force_q(bodies, flank);
        }
        panel
    }

    /// Computes the motion of q under −ü.
    fn force_q(&mut self, bodies: &Bodies, flank: &impl FlankMotion) {
        let admissible = forced::admissible_length(&bodies.bound, self.length);
        if admissible < self.length {
            (self.length, self.next_segment) = (admissible, self.segment);
        }
        if self.length > 0.0 {
            let half = 0.5 * self.length;
            let forcing = |x: f64| -self.flank(flank, half * (1.0 + x)).0[2];
            // The absolute tolerance is the rounding error of ü.
            let rounding = f64::EPSILON * flank.acceleration(self.start);
            let fit = chebyshev::fit(forcing, f64::EPSILON, rounding);
            self.forced = ForcedStep::new(&bodies.bound, self.length, fit.polynomial, self.state.q);
        }
    }

    /// The instant `theta` [s] after the start.
    pub fn instant(&self, theta: f64) -> Double {
        self.start + Double::from(theta)
    }

    /// u and its derivatives `theta` after the start.
    pub fn flank(&self, flank: &impl FlankMotion, theta: f64) -> Kinematics {
        flank.at(self.segment, self.instant(theta))
    }

    /// |d²F_K/dt²| ≤ m1 |u⁗| + (c/ω + b) N over `horizon`, where N = √(q⃛² + ω² q̈²) grows no faster than |u⁗|: the
    /// energy of an oscillator under a force, whatever its damping.
    fn force_bound(&self, bodies: &Bodies, [q2, q3, _]: [f64; 3], horizon: f64) -> f64 {
        let omega = bodies.bound.stiffness().sqrt();
        let energy = (q3 * q3 + (omega * q2).powi(2)).sqrt() + self.fourth * horizon;
        bodies.m1 * self.fourth + (bodies.c / omega + bodies.b) * energy
    }

    /// |d⁴z/dt⁴| ≤ |u⁗| + (c/ω₂ + b) N/m1 with N = √(q⃛² + ω₂² q̈²), which does not grow in flight.
    fn gap_bound(&self, bodies: &Bodies, [q2, q3, _]: [f64; 3]) -> f64 {
        let omega = bodies.relative.stiffness().sqrt();
        let energy = (q3 * q3 + (omega * q2).powi(2)).sqrt();
        self.fourth + (bodies.c / omega + bodies.b) * energy / bodies.m1
    }

    /// The state `theta` [s] after the start.
    pub fn at(&self, bodies: &Bodies, flank: &impl FlankMotion, theta: f64) -> State {
        if theta == 0.0 {
            return self.state;
        }
        let mut state = self.state;
        state.q = self.spring(bodies, theta);
        if self.mode == Mode::Free {
            let share = bodies.m2 / (bodies.m1 + bodies.m2);
            let beyond = self.beyond_tangent(bodies, state.q, theta);
            let [mut path, mut speed] = [0.0; 2];
            for i in 0..STAGES {
                let rest = 0.5 * (1.0 - ABSCISSAE[i]) * theta;
                let weight = WEIGHTS[i] * theta * self.flank(flank, theta - rest).0[2];
                path += weight * rest;
                speed += weight;
            }
            let [zeta, rate] = self.state.zeta;
            state.zeta = [zeta + rate * theta - share * beyond[0] - path, rate - share * beyond[1] - speed];
        }
        state
    }

    /// q and q̇ `theta` after the start.
    fn spring(&self, bodies: &Bodies, theta: f64) -> [f64; 2] {
        match self.mode {
            Mode::Contact(_) => self.forced.at(&bodies.bound, theta),
            Mode::Free => forced::apply(&bodies.relative.free(Double::from(theta)), self.state.q),
        }
    }

    /// q(θ) − q₀ − q̇₀ θ and q̇(θ) − q̇₀ in flight, by quadrature of q̈ where the differences would cancel.
    fn beyond_tangent(&self, bodies: &Bodies, q: [f64; 2], theta: f64) -> [f64; 2] {
        if bodies.relative.rates().1 * theta > PHASE {
            return [q[0] - self.state.q[0] - self.state.q[1] * theta, q[1] - self.state.q[1]];
        }
        let mut sums = [0.0; 2];
        for i in 0..STAGES {
            let rest = 0.5 * (1.0 - ABSCISSAE[i]) * theta;
            let [q2, _, _] = bodies.free_derivatives(self.spring(bodies, theta - rest));
            sums[0] += WEIGHTS[i] * theta * rest * q2;
            sums[1] += WEIGHTS[i] * theta * q2;
        }
        sums
    }

    /// The rate of the fastest change in the panel [rad/s].
    pub fn rate(&self, bodies: &Bodies, flank: &impl FlankMotion) -> f64 {
        flank.rate(self.segment, self.start, self.length) + bodies.relative.rates().1.max(bodies.bound.rates().1)
    }

    /// Takes one certified step of the search from `from` [s] after the start on.
    pub fn search(&self, bodies: &Bodies, flank: &impl FlankMotion, from: f64) -> Found {
        let state = self.at(bodies, flank, from);
        let u = self.flank(flank, from);
        let left = self.length - from;
        // A step that no longer moves the instant has arrived at the zero.
        let arrived = |step: f64| step <= f64::EPSILON * from;
        match self.mode {
            Mode::Contact(contact) => {
                let sign = contact.sign();
                let [force, rate, _] = bodies.force(state.q, &u).map(|f| sign * f);
                let guard = force + self.resolution;
                // A horizon of one radian keeps the bound sharp.
                let horizon = left.min(1.0 / bodies.bound.stiffness().sqrt());
                let bound = self.force_bound(bodies, bodies.bound_derivatives(state.q, &u), horizon);
                let step = safe_step([guard, rate], bound, horizon);
                if step < horizon && arrived(step) {
                    return Found::Release(self.polish(bodies, flank, sign, from));
                }
                Found::Nothing(from + step)
            }
            Mode::Free => {
                let [z2, z3] = bodies.gap_derivatives(state.q, &u);
                let [zeta, rate] = state.zeta;
                let zeros = if from == 0.0 { self.zeros } else { 0 };
                let bound = self.gap_bound(bodies, bodies.free_derivatives(state.q));
                let mut nearest = (f64::INFINITY, Flank::A);
                for flank in [Flank::A, Flank::B] {
                    let sign = flank.sign();
                    let mut gap = [sign * (state.home - bodies.place(flank) + zeta), sign * rate, sign * z2, sign * z3];
                    if state.home == bodies.place(flank) {
                        gap[..zeros].fill(0.0);
                    }
                    let step = safe_step(gap, bound, left);
                    if step < nearest.0 {
                        nearest = (step, flank);
                    }
                }
                let (mut step, hit) = nearest;
                if from == 0.0 && zeros >= 2 {
                    step = step.max(ARMING / self.rate(bodies, flank)).min(left);
                } else if step < left && arrived(step) {
                    return Found::Impact(hit, from);
                }
                Found::Nothing(from + step)
            }
        }
    }

    /// The zero of F_K just before `theta`, where it has fallen to the resolution below zero.
    fn polish(&self, bodies: &Bodies, flank: &impl FlankMotion, sign: f64, theta: f64) -> f64 {
        let mut zero = theta;
        for _ in 0..3 {
            let u = self.flank(flank, zero);
            let [force, rate, _] = bodies.force(self.at(bodies, flank, zero).q, &u).map(|f| sign * f);
            let next = zero - force / rate;
            // A force that only just reaches zero keeps the instant at which it is seen to pull.
            let plausible = rate < 0.0 && next >= 0.0 && (next - theta).abs() * self.rate(bodies, flank) <= 1e-4;
            if !plausible {
                return theta;
            }
            zero = next;
        }
        zero.min(self.length)
    }

    /// ∫ F_K dt, ∫ U′ F_K dt and ∫ b q̇² dt between two times after the start, and how many quadratures that took.
    pub fn integrals(&self, bodies: &Bodies, flank: &impl FlankMotion, from: f64, to: f64) -> ([f64; 3], f64) {
        let mut sums = [0.0; 3];
        let touching = matches!(self.mode, Mode::Contact(_));
        if to <= from || !(touching || bodies.b > 0.0) {
            return (sums, 0.0);
        }
        let oscillator = if touching { &bodies.bound } else { &bodies.relative };
        let (slow, fast) = oscillator.rates();
        if !touching && fast * (to - from) > PHASE {
            // In flight the damper takes what the relative motion loses: ½μ q̇² + ½c q², μ = m1 m2/(m1 + m2).
            let reduced = bodies.m1 * (bodies.m2 / (bodies.m1 + bodies.m2));
            let energy = |[q, q_dot]: [f64; 2]| 0.5 * (reduced * q_dot * q_dot + bodies.c * q * q);
            sums[2] = (energy(self.spring(bodies, from)) - energy(self.spring(bodies, to))).max(0.0);
            return (sums, 1.0);
        }
        // Of a real pair of roots the fast one counts until it has decayed, then the slow one.
        let decayed = if slow < fast { DECAY / fast } else { 0.0 };
        let forcing = 2.0 * flank.rate(self.segment, self.start, self.length);
        let mut count = 0.0;
        for (begin, end, rate) in [(from, to.min(decayed), fast), (from.max(decayed), to, slow)] {
            let phase = (rate + forcing) * (end - begin);
            if begin >= end {
                continue;
            }
            let parts = (phase / PHASE).ceil().max(1.0);
            let width = (end - begin) / parts;
            let rule = Gauss::with(if phase <= SHORT_PHASE { 4 } else { 8 });
            for part in 0..parts as usize {
                let left = begin + part as f64 * width;
                let [force, torque, damping] = rule.integrate(width, |s| {
                    let theta = left + s;
                    let q = self.spring(bodies, theta);
                    let damping = bodies.b * q[1] * q[1];
                    if !touching {
                        return [0.0, 0.0, damping];
                    }
                    let [force, _, _] = bodies.force(q, &self.flank(flank, theta));
                    [force, force * flank.slope(self.segment, self.instant(theta)), damping]
                });
                sums = [sums[0] + force, sums[1] + torque, sums[2] + damping];
            }
            count += parts;
        }
        (sums, count)
    }
}
