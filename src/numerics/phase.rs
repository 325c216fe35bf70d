//! Sine and cosine of phases that grow at constant rates, right to the last digit after any number of turns.
//!
//! ψ(t) = 2π (θ + ν t). The rate is kept in three parts. The products of the parts with at most 26 bits and the halves of t are
//! exact, and whole steps of a table of one turn are subtracted before any rounding. The remaining phase is below π/256, for which
//! a few terms of the series are enough.
//!
//! Source: S. Gal, B. Bachelis, "An accurate elementary mathematical library for the IEEE floating point standard",
//! ACM Trans. Math. Softw. 17 (1991) 26–45 (tables); T. J. Dekker, Numer. Math. 18 (1971) 224–242 (exact products).

use super::angle::ROUNDER;
use super::double_double::Double;
use serde::{Deserialize, Serialize};

/// Steps of the table around the turn.
const STEPS: usize = 256;

/// One step (rad).
const STEP: f64 = std::f64::consts::TAU / STEPS as f64;

/// Sine and cosine at the steps.
static TABLE: [[f64; 2]; STEPS] = table();

/// 256/2π as the unevaluated sum of two `f64`.
const STEPS_PER_RADIAN: Double = Double { hi: 40.74366543152521, lo: -2.518870614423358e-15 };

/// Two phases ψᵢ(t) = ψᵢ(0) + rateᵢ · t, computed side by side.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Phases {
    /// The rates in steps per second, and their three parts: the first 26 bits, the next 53 and the rest.
    rate: [f64; 2],
    coarse: [f64; 2],
    fine: [f64; 2],
    rest: [f64; 2],
    /// [`ROUNDER`] and the whole steps at t = 0.
    rounder: [f64; 2],
    /// Phase at t = 0 beyond whole steps, within ± ½.
    start: [f64; 2],
    /// Up to this |t| (s) the products need no reduction of their own.
    near: f64,
}

impl Phases {
    /// The phases with these `rates` (rad/s) and these values (rad) at these times (s).
    pub fn new(rates: [Double; 2], known: [(f64, f64); 2]) -> Self {
        let mut phases = Phases { near: f64::INFINITY, ..Phases::default() };
        for i in 0..2 {
            let rate = rates[i] * STEPS_PER_RADIAN;
            let coarse = leading_half(rate.hi);
            let below = rate - Double::from(coarse);
            (phases.rate[i], phases.coarse[i], phases.fine[i], phases.rest[i]) = (rate.hi, coarse, below.hi, below.lo);
            let (phase, time) = known[i];
            let start = (Double::from(phase) - rates[i] * Double::from(time)) * STEPS_PER_RADIAN;
            let whole = start.hi.round();
            phases.rounder[i] = ROUNDER + whole % STEPS as f64;
            phases.start[i] = (start - Double::from(whole)).hi;
            // Then the smaller products are below 2⁵ steps, and their roundings below 2⁻⁴⁸ of a step.
            phases.near = phases.near.min(f64::from(1 << 30) / rate.hi.abs());
        }
        phases
    }

    /// Sine and cosine of both phases at `t` (s), error about 1e-16.
    pub fn both(&self, t: f64) -> [[f64; 2]; 2] {
        self.sin_cos(t)
    }

    /// Sine and cosine of the first phase.
    pub fn first(&self, t: f64) -> [f64; 2] {
        let [first] = self.sin_cos(t);
        first
    }

    #[inline(always)]
    fn sin_cos<const N: usize>(&self, t: f64) -> [[f64; 2]; N] {
        let high = leading_half(t);
        let low = t - high;
        let mut first = [0.0; N];
        let mut x = [0.0; N];
        if t.abs() <= self.near {
            for i in 0..N {
                let p = high * self.coarse[i];
                first[i] = p + self.rounder[i];
                x[i] = (p - (first[i] - self.rounder[i]) + self.start[i]) + (low * self.rate[i] + high * self.fine[i]);
            }
        } else {
            for i in 0..N {
                (first[i], x[i]) = self.far(i, high, low);
            }
        }
        let second = x.map(|x| x + ROUNDER);
        let angle: [f64; N] = std::array::from_fn(|i| STEP * (x[i] - (second[i] - ROUNDER)));
        let square = angle.map(|x| x * x);
        // The next terms are 8e-18 and 1e-20 at π/256.
        let sine: [f64; N] =
            std::array::from_fn(|i| angle[i] + angle[i] * square[i] * (square[i] * (1.0 / 120.0) - 1.0 / 6.0));
        let below_one: [f64; N] =
            std::array::from_fn(|i| square[i] * (square[i] * (1.0 / 24.0 - square[i] * (1.0 / 720.0)) - 0.5));
        std::array::from_fn(|i| {
            let step = first[i].to_bits().wrapping_add(second[i].to_bits()) as usize % STEPS;
            let [s, c] = TABLE[step];
            [s + (s * below_one[i] + c * sine[i]), c + (c * below_one[i] - s * sine[i])]
        })
    }

    /// Whole steps, added to [`ROUNDER`], and the remaining phase, at any time.
    #[cold]
    #[inline(never)]
    fn far(&self, i: usize, high: f64, low: f64) -> (f64, f64) {
        let (mut whole, mut x) = (self.rounder[i], self.start[i]);
        let middle = leading_half(self.fine[i]);
        // From the smallest to the largest; remainders and differences are exact.
        for product in [
            (high + low) * self.rest[i] + low * (self.fine[i] - middle),
            low * middle,
            high * (self.fine[i] - middle),
            high * middle,
            low * self.coarse[i],
            high * self.coarse[i],
        ] {
            let steps = product % STEPS as f64;
            whole += steps.round();
            x += steps - steps.round();
        }
        (whole, x)
    }
}

/// One step (rad) as a number of 33 bits and the rest.
const STEP_PARTS: [f64; 2] = [0.024543692605220713, 9.495469541415925e-13];

/// Beyond this an angle no longer splits into exact steps (rad); 33 bits times 19 bits are exact.
const FAR: f64 = 1e4;

/// Sine and cosine of an angle (rad), error about 2e-16; fast up to some turns.
#[inline(always)]
pub fn sin_cos(angle: f64) -> [f64; 2] {
    if !(angle.abs() <= FAR) {
        return angle.sin_cos().into();
    }
    let rounded = angle * STEPS_PER_RADIAN.hi + ROUNDER;
    let whole = rounded - ROUNDER;
    let x = (angle - whole * STEP_PARTS[0]) - whole * STEP_PARTS[1];
    let square = x * x;
    let sine = x + x * square * (square * (1.0 / 120.0) - 1.0 / 6.0);
    let below_one = square * (square * (1.0 / 24.0 - square * (1.0 / 720.0)) - 0.5);
    let [s, c] = TABLE[rounded.to_bits() as usize % STEPS];
    [s + (s * below_one + c * sine), c + (c * below_one - s * sine)]
}

/// The first 26 bits of a number.
fn leading_half(x: f64) -> f64 {
    f64::from_bits(x.to_bits() & !0x7ff_ffff)
}

/// Sine and cosine at the steps, to the last digit: Taylor series in whole numbers of 2⁻⁶², within an eighth of a
/// turn.
const fn table() -> [[f64; 2]; STEPS] {
    /// 2π · 2¹²⁰.
    const TURN: i128 = 8351785813007552717653752915327115495;
    const ONE: i128 = 1 << 62;
    const QUARTER: usize = STEPS / 4;
    let mut table = [[0.0; 2]; STEPS];
    let mut i = 0;
    while i <= STEPS / 8 {
        let angle = (TURN / STEPS as i128 * i as i128) >> 58;
        let (mut sine, mut cosine, mut term, mut n) = (0, 0, ONE, 0);
        while term != 0 {
            match n % 4 {
                0 => cosine += term,
                1 => sine += term,
                2 => cosine -= term,
                _ => sine -= term,
            }
            n += 1;
            term = ((term * angle) >> 62) / n;
        }
        let (s, c) = (sine as f64 / ONE as f64, cosine as f64 / ONE as f64);
        let mirrored = QUARTER - i;
        let mut quarter = 0;
        while quarter < 4 {
            // The angle and its mirror image, a quarter of a turn further each time.
            table[(i + quarter * QUARTER) % STEPS] = quarters_on([s, c], quarter);
            table[(mirrored + quarter * QUARTER) % STEPS] = quarters_on([c, s], quarter);
            quarter += 1;
        }
        i += 1;
    }
    table
}

/// Sine and cosine of an angle some quarters of a turn further.
const fn quarters_on([s, c]: [f64; 2], quarters: usize) -> [f64; 2] {
    match quarters {
        0 => [s, c],
        1 => [c, -s],
        2 => [-s, -c],
        _ => [-c, s],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::angle;
    use crate::numerics::double_double::two_product;

    #[test]
    fn the_table_holds_sines_and_cosines() {
        for (i, [s, c]) in TABLE.into_iter().enumerate() {
            let turn = Double { hi: std::f64::consts::TAU, lo: 2.4492935982947064e-16 };
            let (sine, cosine) = angle::reduce(turn * Double::from(i as f64 / STEPS as f64)).sin_cos();
            // The reduced angle is rounded by up to 2.2e-16.
            assert!((s - sine).abs() < 3e-16 && (c - cosine).abs() < 3e-16, "{i}");
            assert!((s * s + c * c - 1.0).abs() < 3e-16);
        }
        assert_eq!([TABLE[0], TABLE[64], TABLE[128], TABLE[192]], [[0.0, 1.0], [1.0, -0.0], [-0.0, -1.0], [-1.0, 0.0]]);
    }

    #[test]
    fn phases_keep_their_digits_from_the_first_to_the_1e12th_turn_and_backwards() {
        for (rate, phase, origin) in [(50.26, 0.0, 0.0), (-377.0, 2.5, 1.25), (1e6, -1e12, 1e3), (1e-9, 0.3, -7.0)] {
            let phases = Phases::new([Double::from(rate), Double::from(-rate)], [(phase, origin), (1.0, origin)]);
            for i in 0..400 {
                let t = f64::from(i) * 0.1370 * 10f64.powi(i % 8) + 1e-3;
                let reduced = |phase: f64, rate: f64| {
                    let since = Double::from(t) - Double::from(origin);
                    angle::reduce(Double::from(phase) + two_product(rate, since.hi) + Double::from(rate * since.lo))
                };
                let expected = [reduced(phase, rate).sin_cos(), reduced(1.0, -rate).sin_cos()];
                for (found, (s, c)) in phases.both(t).into_iter().zip(expected) {
                    // The reference has the rounding of an angle of up to π.
                    assert!(
                        (found[0] - s).abs() < 4e-16 && (found[1] - c).abs() < 4e-16,
                        "{rate} at {t}: {found:?} {s} {c}"
                    );
                }
                assert_eq!(phases.first(t), phases.both(t)[0]);
            }
        }
    }

    #[test]
    fn sine_and_cosine_of_an_angle() {
        for i in -20000..=20000 {
            let angle = f64::from(i) * 1.234e-3;
            let [s, c] = sin_cos(angle);
            assert!((s - angle.sin()).abs() < 2.3e-16 && (c - angle.cos()).abs() < 2.3e-16, "{angle}");
        }
        assert!(sin_cos(f64::INFINITY)[0].is_nan() && sin_cos(f64::NAN)[1].is_nan());
    }

    #[test]
    fn a_phase_that_rests() {
        let phases = Phases::new([Double::from(0.0); 2], [(0.5, 3.0), (-1e3, 3.0)]);
        for t in [0.0, 1e9, -1e300] {
            let [[s, c], _] = phases.both(t);
            assert!((s - 0.5f64.sin()).abs() < 2e-16 && (c - 0.5f64.cos()).abs() < 2e-16);
        }
        assert!(phases.first(f64::INFINITY)[0].is_nan());
    }
}
