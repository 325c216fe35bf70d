//! The interface of an equation of motion. It knows no solver and no drive.

use crate::drives::Fault;
use crate::drives::follower::flow::Flow;
use crate::drives::follower::load::Load;
use crate::motion::{MotionLaw, turn};
use crate::numerics::angle;
use crate::numerics::double_double::Double;
use crate::numerics::taylor::Scalar;
use serde::{Serialize, de::DeserializeOwned};
use std::fmt::Debug;
use std::sync::Arc;

/// q̈ = f(φ, ω, α, q, q̇) of one oscillator on a shaft whose motion φ(t) is given. A law over an angle gives its coefficients.
pub trait Equation: Clone + PartialEq + Debug + Serialize + DeserializeOwned + Send + Sync + 'static {
    /// The law over the angle.
    type Law: Clone + PartialEq + Debug + Serialize + DeserializeOwned + Send + Sync + 'static;
    /// The parameters that may change between communication steps.
    type Parameters: Copy + PartialEq + Debug + Serialize + DeserializeOwned + Send + Sync;
    /// The law at an angle.
    type Local;

    /// The parameters that may change between communication steps.
    fn parameters(&self) -> Self::Parameters;

    /// The same equation with other parameters.
    fn with(&self, parameters: Self::Parameters) -> Self;

    /// Derives what follows from the law after its parameters may have changed; refuses parameters that make no law.
    fn prepare(&mut self, law: &Self::Law) -> Result<(), Fault>;

    /// Whether the equation is linear in q.
    fn is_linear(&self) -> bool {
        true
    }

    /// The equation linearised in q.
    fn linearised(&self) -> Self {
        self.clone()
    }

    /// Whether the oscillator carries the law, which then is taken at the angle φ + q instead of φ.
    fn carries_law(&self) -> bool {
        false
    }

    /// Whether free motions never die out.
    fn is_undamped(&self) -> bool;

    /// The names of its quantities in messages.
    fn words(&self) -> Words;

    /// The loads on the mass.
    fn load(&self) -> &Option<Arc<Load>>;

    /// The loads, to change them.
    fn load_mut(&mut self) -> &mut Option<Arc<Load>>;

    /// The process force P(φ) among them.
    fn process(&self) -> Option<&MotionLaw> {
        self.load().as_ref()?.process.as_ref()
    }

    /// Whether a force acts that depends on time, an input.
    fn has_input(&self) -> bool {
        self.load().as_ref().is_some_and(|load| load.input)
    }

    /// The angles in [0, 2π), ascending, at which a derivative of a coefficient jumps: of the law and of the process force, which
    /// depends on the drive's angle even if the oscillator carries the law. Segment i reaches from breakpoint i to the next one,
    /// the last one around the turn.
    fn breakpoints<'a>(&'a self, _law: &'a Self::Law) -> [&'a [f64]; 2] {
        [&[], &[]]
    }

    /// For each of the two, whether the oscillator carries its angle.
    fn carried(&self) -> [bool; 2] {
        [self.carries_law(), false]
    }

    /// The segments of both in this state of drive and oscillator; on a breakpoint the segment ahead.
    #[inline(always)]
    fn segments(&self, law: &Self::Law, f: &Flow<f64>) -> Segments {
        let (carried, breakpoints) = (self.carried(), self.breakpoints(law));
        if let [[], []] = breakpoints {
            return [0; 2];
        }
        [0, 1].map(|i| match breakpoints[i] {
            [] => 0,
            list => {
                let reduced = angle::reduce(Double::from(f.argument(carried[i])));
                turn::segment(list, reduced, f.turning(carried[i]) >= 0.0)
            }
        })
    }

    /// The law in this state of drive and oscillator, continued smoothly from its segments.
    fn at(&self, law: &Self::Law, segments: Segments, f: &Flow<f64>) -> Self::Local;

    /// Place and velocity from which q and q̇ count: the shaft's.
    fn base<S: Scalar>(&self, _local: &Self::Local, f: &Flow<S>) -> [S; 2] {
        [f.phi, f.w]
    }

    /// q̈.
    fn acceleration<S: Scalar>(&self, local: &Self::Local, f: &Flow<S>) -> S;

    /// ∂q̈/∂q (1/s²) and ∂q̈/∂q̇ (1/s).
    fn jacobian(&self, local: &Self::Local, f: &Flow<f64>) -> [f64; 2];

    /// Rounding error of q̈ over the unit roundoff if its terms cancel.
    fn rounding(&self, _law: &Self::Law, _segments: Segments, _f: &Flow<f64>) -> f64 {
        0.0
    }

    /// The effect of the roundings of the law's coefficients on q̈ at the speed 1 rad/s.
    fn roundings(&self, _law: &Self::Law) -> f64 {
        0.0
    }

    /// The angle (rad) from `phi` on over which the coefficients follow a polynomial of degree 8.
    fn reach(&self, law: &Self::Law, segments: Segments, phi: f64) -> f64;

    /// The number of equal parts into which symmetry divides the turn.
    fn symmetry(&self, law: &Self::Law) -> usize;

    /// Cost of an evaluation of the law (nominal µs), see [`crate::numerics::work`].
    fn cost(&self, law: &Self::Law) -> f64;

    /// The quantities that determine the default internal step of fixed cost.
    fn pace(&self, law: &Self::Law, state: [f64; 2]) -> Pace;

    /// The force with which loads are to hold a follower on its cam, and the cam's force; zeros without such loads.
    fn contact(&self, _now: impl FnOnce() -> (Self::Local, Flow<f64>)) -> [f64; 2] {
        [0.0; 2]
    }

    /// The equilibrium with the shaft at rest at the angle of `f`.
    fn at_rest(&self, _law: &Self::Law, _f: &Flow<f64>) -> Result<[f64; 2], Fault> {
        // The spring is relaxed.
        Ok([0.0; 2])
    }
}

/// The segments of the law and of the process force.
pub type Segments = [usize; 2];

/// How fast a motion changes.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Deserialize, Serialize)]
pub struct Pace {
    /// The highest frequency of the oscillator (rad/s).
    pub frequency: f64,
    /// The angle that one step may turn through (rad).
    pub angle: f64,
    /// The additional speed with which the oscillator turns through the law (rad/s).
    pub speed: f64,
}

/// The names of the quantities of an equation in messages.
#[derive(Clone, Copy, Debug)]
pub struct Words {
    /// The integrated quantity: "the twist q".
    pub quantity: &'static str,
    /// The turning part: "the cam".
    pub turning: &'static str,
    /// Parameters that may be wrong if no step keeps the tolerance: "J, m, c, b".
    pub parameters: &'static str,
    /// Parameters that may be wrong if the work is too much: "c and J".
    pub frequency: &'static str,
    /// The damping: "b".
    pub damping: &'static str,
    /// Another remedy for growing free motions; empty, or a text after a comma.
    pub instead: &'static str,
}
