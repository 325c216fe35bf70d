//! The motion of flank A, as the contact and the search for switching instants need it.

use crate::motion::Kinematics;
use crate::numerics::double_double::Double;

/// The moving flank A; flank B runs at the constant distance s above it.
pub trait FlankMotion {
    /// u, u̇ … u⁗ at `time`, continued smoothly from `segment`.
    fn at(&self, segment: usize, time: Double) -> Kinematics;

    /// U′ at `time` (m/rad).
    fn slope(&self, segment: usize, time: Double) -> f64;

    /// u(time + span x) = Σ cₙ xⁿ continued smoothly from `segment`: the coefficients c₀ …, at least 6.
    fn expand(&self, segment: usize, time: Double, span: f64, coefficients: &mut [f64]);

    /// Cost of an expansion (nominal µs).
    fn cost(&self) -> f64 {
        EXPANSION
    }

    /// The motion from one time to another (s), in words for messages.
    fn describe(&self, way: [f64; 2]) -> String;

    /// Whether the speed is constant.
    fn is_uniform(&self) -> bool;

    /// φ̇ if it is constant (rad/s).
    fn speed(&self) -> f64;

    /// Upper bounds of |u| (m) and |u̇| (m/s) with the speed at `time` (s).
    fn sizes(&self, time: f64) -> [f64; 2];

    /// How many times larger than roundings of its values the roundings of the law's coefficients are, at least one.
    fn roundings(&self) -> f64 {
        1.0
    }

    /// An upper bound of |ü| in `segment` at `time`; in a dwell the bound of all segments, since they caused the motion that
    /// settles there.
    fn acceleration(&self, segment: usize, time: Double) -> f64;

    /// K|w|, the highest rate at which u changes in `segment` at `time` (rad/s).
    fn rate(&self, segment: usize, time: Double) -> f64;

    /// The segment that u moves in at `time`.
    fn segment(&self, time: Double) -> usize;

    /// How long u stays in `segment`, at most `longest` (s), and the segment that follows.
    fn stay(&self, segment: usize, time: Double, longest: f64) -> (f64, usize);
}

/// Cost of an expansion (nominal µs).
pub const EXPANSION: f64 = 0.3;
