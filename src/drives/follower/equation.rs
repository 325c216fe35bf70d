//! What an equation says of itself. It knows no solver and no drive.

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

/// q̈ = f(φ, ω, α, q, q̇) of one oscillator on a shaft whose motion φ(t) is given. Its coefficients follow from a law over an
/// angle.
pub trait Equation: Clone + PartialEq + Debug + Serialize + DeserializeOwned + Send + Sync + 'static {
    /// What depends on the angle.
    type Law: Clone + PartialEq + Debug + Serialize + DeserializeOwned + Send + Sync + 'static;
    /// The parameters that may change between communication steps.
    type Parameters: Copy + PartialEq + Debug + Serialize + DeserializeOwned + Send + Sync;
    /// The law at an angle.
    type Local;

    /// The parameters that may change between communication steps.
    fn parameters(&self) -> Self::Parameters;

    /// The same equation with other parameters.
    fn with(&self, parameters: Self::Parameters) -> Self;

    /// Takes up what follows from the law, whose parameters may have been changed; refuses what is no law.
    fn prepare(&mut self, law: &Self::Law) -> Result<(), Fault>;

    /// Whether the equation is linear in q.
    fn is_linear(&self) -> bool {
        true
    }

    /// The equation linearised in q.
    fn linearised(&self) -> Self {
        self.clone()
    }

    /// Whether the oscillator carries the law, which then is taken at the angle φ + q, else at φ.
    fn carries_law(&self) -> bool {
        false
    }

    /// Whether free motions never die out.
    fn is_undamped(&self) -> bool;

    /// The names of its quantities in messages.
    fn words(&self) -> Words;

    /// The loads on the mass.
    fn load(&self) -> &Option<Arc<Load>>;

    /// The same, to change them.
    fn load_mut(&mut self) -> &mut Option<Arc<Load>>;

    /// The process force P(φ) among them.
    fn process(&self) -> Option<&MotionLaw> {
        self.load().as_ref()?.process.as_ref()
    }

    /// Whether a force acts that depends on time, an input.
    fn has_input(&self) -> bool {
        self.load().as_ref().is_some_and(|load| load.input)
    }

    /// The angles in [0, 2π), ascending, at which a derivative of a coefficient jumps: of the law, and of what depends on the
    /// angle of the drive whether the oscillator carries the law or not. Segment i reaches from breakpoint i to the next one, the
    /// last one around the turn.
    fn breakpoints<'a>(&'a self, _law: &'a Self::Law) -> [&'a [f64]; 2] {
        [&[], &[]]
    }

    /// Of which of them the oscillator carries the angle.
    fn carried(&self) -> [bool; 2] {
        [self.carries_law(), false]
    }

    /// The segments of both where drive and oscillator are so; on a breakpoint the one to which they turn.
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

    /// The law where drive and oscillator are so, continued smoothly from its segments.
    fn at(&self, law: &Self::Law, segments: Segments, f: &Flow<f64>) -> Self::Local;

    /// Place and speed from which q and q̇ count: those of the shaft.
    fn base<S: Scalar>(&self, _local: &Self::Local, f: &Flow<S>) -> [S; 2] {
        [f.phi, f.w]
    }

    /// q̈.
    fn acceleration<S: Scalar>(&self, local: &Self::Local, f: &Flow<S>) -> S;

    /// ∂q̈/∂q (1/s²) and ∂q̈/∂q̇ (1/s).
    fn jacobian(&self, local: &Self::Local, f: &Flow<f64>) -> [f64; 2];

    /// Rounding error of q̈ over the unit roundoff where its terms cancel.
    fn rounding(&self, _law: &Self::Law, _segments: Segments, _f: &Flow<f64>) -> f64 {
        0.0
    }

    /// What the roundings of the law's coefficients make of q̈ at the speed 1 rad/s.
    fn roundings(&self, _law: &Self::Law) -> f64 {
        0.0
    }

    /// The angle (rad) from `phi` on over which the coefficients follow a polynomial of degree 8.
    fn reach(&self, law: &Self::Law, segments: Segments, phi: f64) -> f64;

    /// Into how many equal parts symmetry divides the turn.
    fn symmetry(&self, law: &Self::Law) -> usize;

    /// Cost of an evaluation of the law (nominal µs), see [`crate::numerics::work`].
    fn cost(&self, law: &Self::Law) -> f64;

    /// What the internal step of fixed cost follows from where none is asked for.
    fn pace(&self, law: &Self::Law, state: [f64; 2]) -> Pace;

    /// The force with which loads are to hold a follower on its cam, and that of the cam; zeros where they hold none.
    fn contact(&self, _now: impl FnOnce() -> (Self::Local, Flow<f64>)) -> [f64; 2] {
        [0.0; 2]
    }

    /// The equilibrium where the shaft rests at the angle of `f`.
    fn at_rest(&self, _law: &Self::Law, _f: &Flow<f64>) -> Result<[f64; 2], Fault> {
        // The spring is relaxed.
        Ok([0.0; 2])
    }
}

/// The segment of the law, and of what depends on the angle of the drive.
pub type Segments = [usize; 2];

/// How fast a motion changes.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Deserialize, Serialize)]
pub struct Pace {
    /// The highest frequency of the oscillator (rad/s).
    pub frequency: f64,
    /// The angle that one step may turn through (rad).
    pub angle: f64,
    /// The speed by which the oscillator turns through the law, beside that of the shaft (rad/s).
    pub speed: f64,
}

/// The names of the quantities of an equation in messages.
#[derive(Clone, Copy, Debug)]
pub struct Words {
    /// The integrated quantity: "the twist q".
    pub quantity: &'static str,
    /// The turning part: "the cam".
    pub turning: &'static str,
    /// Parameters that may be wrong where no step keeps the tolerance: "J, m, c, b".
    pub parameters: &'static str,
    /// Parameters that may be wrong where the work is too much: "c and J".
    pub frequency: &'static str,
    /// The damping: "b".
    pub damping: &'static str,
    /// What else may help where free motions grow; empty, or a text behind a comma.
    pub instead: &'static str,
}
