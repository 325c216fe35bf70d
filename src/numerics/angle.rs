//! Angles modulo one turn, without the error growth of a naive `φ % 2π`.

use super::double_double::{Double, two_product, two_sum};
use std::f64::consts::TAU;

/// 2π as the unevaluated sum of three `f64`, 160 bits.
const TURN: [f64; 3] = [TAU, 2.4492935982947064e-16, -5.989539619436679e-33];

/// 2π in double-double.
pub const WHOLE_TURN: Double = Double { hi: TURN[0], lo: TURN[1] };

/// 2π as the sum of two numbers of 33 bits, whose products with up to 2²⁰ turns are exact, and the rest.
#[allow(clippy::approx_constant)] // The first 33 bits of 2π; the other two parts hold the rest.
const TURN_IN_PARTS: [f64; 3] = [6.2831853069365025, 2.4308402025215864e-10, 8.089064995183803e-21];

/// Up to this many turns the products with [`TURN_IN_PARTS`] are exact.
const SOME_TURNS: f64 = 1048576.0;

/// A number to which the nearest whole number is added by rounding, without a call of `round`.
pub const ROUNDER: f64 = 1.5 * 4503599627370496.0;

/// The remainder of `angle` (rad) modulo 2π in [−π, π], error ≤ 1e-16 rad for |angle| ≤ 1e15 rad.
///
/// The quotient is subtracted in triple precision, so the result does not lose digits with the number of turns.
pub fn reduce(angle: Double) -> f64 {
    remainder(angle).hi
}

/// The remainder as [`reduce`] returns it, with its rounding error.
pub fn remainder(angle: Double) -> Double {
    if angle.hi.abs() <= 0.5 * TAU {
        return two_sum(angle.hi, angle.lo);
    }
    let turns = angle.hi / TURN[0];
    if turns.abs() <= SOME_TURNS {
        let turns = turns + ROUNDER - ROUNDER;
        let [first, second, third] = TURN_IN_PARTS;
        // The first difference is exact, too.
        let rest = two_sum(angle.hi - turns * first, -turns * second);
        return two_sum(rest.hi, rest.lo + (angle.lo - turns * third));
    }
    let turns = turns.round();
    let rest = angle - two_product(turns, TURN[0]) - two_product(turns, TURN[1]) - Double::from(turns * TURN[2]);
    // The quotient may be off by one if the angle lies near half a turn.
    let correction = (rest.hi / TURN[0]).round();
    rest - two_product(correction, TURN[0]) - two_product(correction, TURN[1])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_million_turns_leave_the_fraction() {
        let million = two_product(1e6, TURN[0]) + two_product(1e6, TURN[1]);
        for fraction in [0.0, 0.25, -1.5, 3.0] {
            let rest = reduce(million + Double::from(fraction));
            assert!((rest - fraction).abs() < 2e-16, "{fraction}: {rest}");
        }
    }

    #[test]
    fn the_quotient_may_be_off_by_one_near_half_a_turn() {
        // At 10¹⁴ turns neighbouring quotients are 1/64 apart.
        for i in -20..=20 {
            for half in [-0.5, 0.5] {
                let fraction = (half + f64::from(i) / 1024.0) * TAU;
                let rest = reduce(two_product(1e14, TURN[0]) + two_product(1e14, TURN[1]) + Double::from(fraction));
                let expected = if fraction.abs() <= 0.5 * TAU { fraction } else { fraction - TAU.copysign(half) };
                assert!(rest.abs() <= 0.5 * TAU && (rest - expected).abs() < 2e-15 || i == 0, "{half} {i}: {rest}");
            }
        }
    }

    #[test]
    fn the_turn_is_known_to_160_bits() {
        // 2⁴⁷ times what the first two parts of 2π lack.
        let angle = Double { hi: 2f64.powi(47) * TURN[0], lo: 2f64.powi(47) * TURN[1] };
        assert!((reduce(angle) - 8.42952762444e-19).abs() < 1e-29, "{:e}", reduce(angle));
    }

    #[test]
    fn the_sine_of_the_remainder_is_the_sine_of_the_angle() {
        for angle in [1.0, 1e3, -4.7e8, 1e12, 3.3e14] {
            let rest = reduce(two_sum(angle, 0.0));
            assert!(rest.abs() <= 0.50001 * TAU && (rest.sin() - f64::sin(angle)).abs() < 3e-16, "{angle}: {rest}");
        }
    }
}
