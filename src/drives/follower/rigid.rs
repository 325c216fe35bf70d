//! Rigid followers, moved by the cams of the machine.

use super::linkage::{Extreme, Linkage};
use super::place::{Place, pieces};
use crate::drives::{Fault, Rounded};
use crate::motion::MotionLaw;
use crate::numerics::powers::{EVALUATIONS, Fitting};
use crate::numerics::taylor::Series;
use crate::numerics::work::Work;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// A tool moved by a cam of the machine, directly or by a lever and mechanisms.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Follower {
    /// The tool's mass m (kg), or its moment of inertia (kg·m²) if it turns.
    pub m: f64,
    /// Whether the tool's coordinate is an angle.
    pub turns: bool,
    /// U(φ) of the tool (m or rad); with mechanisms the angle of the lever (rad), or of the shaft if they sit on it.
    pub cam: MotionLaw,
    /// The mechanisms between lever and tool.
    pub linkage: Linkage,
}

/// Tolerance of a polynomial of the inertia, as part of its largest value: some roundings of the mechanisms' formulas.
const ROUNDING: f64 = 2e-14;

/// The polynomial of degree 15 meets a wave of the order 1 to rounding over this width (rad).
const WAVE: f64 = 2.6;

/// How many times finer than the law the inertia may be; a mechanism closer to a singular position is refused or keeps a small
/// error.
const FINEST: f64 = 256.0;

/// The most samples of a turn, and the highest ratio of the speeds of lever and shaft at which they still lie within two degrees of
/// the lever's turn.
const MOST_SAMPLES: f64 = 65536.0;
const HIGHEST_RATIO: f64 = MOST_SAMPLES / 32.0;

impl Follower {
    /// A mass that the cam moves directly.
    pub fn new(m: f64, cam: MotionLaw) -> Self {
        Follower { m, turns: false, cam, linkage: Linkage::default() }
    }

    /// The word of variables and scenes for the part that moves its mechanisms or its tool.
    pub fn mover(&self) -> &'static str {
        if self.has_cam() { "cam" } else { "crank" }
    }

    /// Whether a cam moves it instead of the shaft itself.
    pub fn has_cam(&self) -> bool {
        !matches!(self.cam, MotionLaw::Crank(_))
    }

    /// Whether there is a lever between its cam and mechanisms.
    pub fn has_lever(&self) -> bool {
        self.has_cam() && !self.linkage.is_empty()
    }

    /// Whether the cam's law is an angle, of a lever or of a turning tool.
    pub fn cam_turns(&self) -> bool {
        self.turns || !self.linkage.is_empty()
    }

    /// The tool's position and its derivatives; `cam` holds those of the law.
    pub fn tool<const N: usize>(&self, cam: [f64; N]) -> [f64; N] {
        self.linkage.tool(cam)
    }

    /// J of tool and links and its derivatives with respect to the variable of `cam`, the law with its derivatives; one order less
    /// than `cam`, the last is zero.
    pub fn inertia<const N: usize>(&self, cam: [f64; N]) -> [f64; N] {
        let mut derivatives = self.linkage.moved(self.m, Series::of_derivatives(cam), &[]).inertia.derivatives();
        if let Some(unknown) = derivatives.last_mut() {
            *unknown = 0.0;
        }
        derivatives
    }

    /// Refuses mechanisms that cannot be assembled all around, or come too close to a singular position; `prefix` names them.
    pub fn check_linkage(&self, prefix: &str) -> Result<(), Fault> {
        if !self.has_cam() && self.linkage.turns() != Some(0.0) {
            let message = ": it turns with the shaft, but its output is not the same again after a turn of the shaft; end it with a \
                 slider-crank, or with a four-bar linkage whose input link is shorter than `ground`, before it only gears of an \
                 integer ratio. A rotor belongs to `machine.J0` and `machine.J`";
            return Err(Fault::named(prefix, message));
        }
        if self.linkage.is_empty() {
            return Ok(());
        }
        let ratio = self.cam.bound(1);
        if !(ratio <= HIGHEST_RATIO) {
            let message = format!(
                ": the cam turns its lever up to {} times as fast as the shaft, by up to {} deg; at most \
                 {HIGHEST_RATIO} times is admissible: check the unit of the motion law",
                Rounded(ratio),
                Rounded(self.cam.bound(0).to_degrees())
            );
            return Err(Fault::named(prefix, message));
        }
        self.linkage.check(prefix, self.samples(), |phi| self.lever(phi))
    }

    /// Cost of an evaluation of its inertia (nominal µs).
    pub fn cost(&self) -> f64 {
        self.cam.cost() + self.linkage.cost()[0]
    }

    /// For each mechanism the position of its least transmission angle over the turn.
    pub fn transmission(&self) -> Vec<Extreme> {
        self.linkage.extremes(self.samples(), |phi| self.lever(phi))
    }

    /// As many samples of a turn as resolve the waves of the law and the turns of the lever; the worst positions are then refined.
    fn samples(&self) -> usize {
        let fastest = self.cam.bound(1) * self.linkage.step_up();
        let count = (32.0 * self.cam.resolution().max(fastest)).clamp(256.0, MOST_SAMPLES);
        count.max(8.0 * self.cam.breakpoints().len() as f64) as usize
    }

    /// χ(φ).
    fn lever(&self, phi: f64) -> f64 {
        self.cam.at(phi.rem_euclid(TAU)).0[0]
    }

    /// The harmonic order that resolves the inertia, see `Inertia::resolution`: twice the law's, doubled until polynomials meet its
    /// values; infinite if the work of a call is not enough to find it.
    pub fn linked_resolution(&self) -> f64 {
        let law = 2.0 * self.cam.resolution();
        let (fitting, mut work) = (Fitting::default(), Work::default());
        let mut finer = 1.0;
        while finer < FINEST && !self.is_resolved_by(finer * law, &fitting, &mut work) {
            if work.is_exhausted() {
                return f64::INFINITY;
            }
            finer *= 2.0;
        }
        finer * law
    }

    fn is_resolved_by(&self, order: f64, fitting: &Fitting, work: &mut Work) -> bool {
        let (mut missed, mut largest) = (0.0_f64, 0.0_f64);
        for (low, high) in pieces(self.cam.breakpoints()) {
            let count = ((high - low) * order / WAVE).ceil().max(1.0);
            let (width, place) = ((high - low) / count, Place::at(0.5 * (low + high)));
            for i in 0..count as usize {
                if work.draw(EVALUATIONS as f64 * self.cost()).is_err() {
                    return false;
                }
                let (_, misses) = fitting.over(low + i as f64 * width, width, |phi| {
                    let [u, u1, ..] = place.evaluate(&self.cam, phi).0;
                    self.inertia([u, u1])[0]
                });
                for [inertia, own] in misses {
                    // `max` would drop NaN.
                    if own.is_nan() {
                        return false;
                    }
                    (missed, largest) = (missed.max(own), largest.max(inertia));
                }
            }
        }
        missed <= ROUNDING * largest
    }
}
