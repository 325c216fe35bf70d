//! Normalised rises f: [0, 1] → [0, 1] after VDI 2143: lift f over angle z, both in units of the rise.
//!
//! Every law here is point-symmetric, f(z) = 1 − f(1 − z), and consists of analytic parts that meet at joints.
//!
//! Source: VDI 2143-1; Volmer (ed.), *Getriebetechnik – Kurvengetriebe*, 2nd ed.

use serde::{Deserialize, Serialize};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// A normalised rise.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum StandardLaw {
    /// f = (1 − cos πz)/2; the acceleration jumps at both ends.
    SimpleSine,
    /// f = z − sin(2πz)/2π, Bestehorn's inclined sine.
    InclinedSine,
    /// f = 10 z³ − 15 z⁴ + 6 z⁵.
    #[serde(rename = "polynomial_345")]
    Polynomial345,
    /// f = 35 z⁴ − 84 z⁵ + 70 z⁶ − 20 z⁷.
    #[serde(rename = "polynomial_4567")]
    Polynomial4567,
    /// f″ a sine of frequency 4π on the outer eighths and 4π/3 between them.
    ModifiedSine,
    /// f″ a trapezoid whose slopes are quarters of a sine of frequency 4π.
    ModifiedTrapezoid,
}

use StandardLaw::*;

/// f′ in the sloping part of the modified sine: f″ = 4πV sin 4πz near z = 0.
pub const MODIFIED_SINE: f64 = PI / (4.0 + PI);

/// f′ in the sloping part of the modified trapezoid.
pub const MODIFIED_TRAPEZOID: f64 = 2.0 / (2.0 + PI);

impl StandardLaw {
    /// All laws, in the order of their numbers 1, 2, … as enumeration items.
    pub const ALL: [StandardLaw; 6] =
        [SimpleSine, InclinedSine, Polynomial345, Polynomial4567, ModifiedSine, ModifiedTrapezoid];

    /// The name in scenes and enumerations.
    pub const fn name(self) -> &'static str {
        match self {
            SimpleSine => "simple_sine",
            InclinedSine => "inclined_sine",
            Polynomial345 => "polynomial_345",
            Polynomial4567 => "polynomial_4567",
            ModifiedSine => "modified_sine",
            ModifiedTrapezoid => "modified_trapezoid",
        }
    }

    /// The number of the enumeration item, from 1.
    pub fn number(self) -> usize {
        1 + Self::ALL.iter().position(|&law| law == self).unwrap_or(0)
    }

    /// The law with this number; the last one beyond the list.
    pub fn from_number(number: usize) -> Self {
        Self::ALL[number.clamp(1, Self::ALL.len()) - 1]
    }

    /// The joints of the analytic parts within (0, 1), ascending.
    pub fn joints(self) -> &'static [f64] {
        match self {
            ModifiedSine => &[0.125, 0.875],
            ModifiedTrapezoid => &[0.125, 0.375, 0.625, 0.875],
            _ => &[],
        }
    }

    /// f … f⁗ at `z` in [0, 1]; on a joint the right-hand values.
    pub fn at(self, z: f64) -> [f64; 5] {
        self.at_in(self.joints().partition_point(|&joint| joint <= z), z)
    }

    /// f … f⁗ of the analytic part `part` (0, 1, …), also outside of it.
    pub fn at_in(self, part: usize, z: f64) -> [f64; 5] {
        // The upper half follows from the lower one: 1 − z is exact there, so f keeps its digits near z = 1.
        let opposite = self.joints().len().saturating_sub(part);
        if part > opposite || (part == opposite && z > 0.5) {
            let [f, f1, f2, f3, f4] = self.lower_half(opposite, 1.0 - z);
            [1.0 - f, f1, -f2, f3, -f4]
        } else {
            self.lower_half(part, z)
        }
    }

    /// f … f⁗ of the part `part`, which begins at z < ½.
    fn lower_half(self, part: usize, z: f64) -> [f64; 5] {
        let y = 1.0 - z;
        let (u, s) = (z * y, y - z);
        match (self, part) {
            (SimpleSine, _) => {
                let (sin, cos) = (PI * z).sin_cos();
                let half = (FRAC_PI_2 * z).sin();
                let p2 = PI * PI;
                [half * half, 0.5 * PI * sin, 0.5 * p2 * cos, -0.5 * p2 * PI * sin, -0.5 * p2 * p2 * cos]
            }
            (InclinedSine, _) => inclined_sine(1.0, TAU, z),
            // Polynomials in Bernstein form, whose terms are all positive and cancel nothing.
            (Polynomial345, _) => [
                z.powi(3) * (10.0 * y * y + z * (5.0 * y + z)),
                30.0 * u * u,
                60.0 * u * s,
                60.0 - 360.0 * u,
                -360.0 * s,
            ],
            (Polynomial4567, _) => [
                z.powi(4) * (35.0 * y.powi(3) + z * (21.0 * y * y + z * (7.0 * y + z))),
                140.0 * u * u * u,
                420.0 * u * u * s,
                840.0 * u * (1.0 - 5.0 * u),
                840.0 * s * (1.0 - 10.0 * u),
            ],
            (ModifiedSine, 0) => inclined_sine(MODIFIED_SINE, 2.0 * TAU, z),
            (ModifiedSine, _) => {
                let (v, w) = (MODIFIED_SINE, 2.0 * TAU / 3.0);
                let (sin, cos) = (w * (z - 0.125)).sin_cos();
                [
                    (2.0 + PI * z - 2.25 * cos) / (4.0 + PI),
                    v * (1.0 + 3.0 * sin),
                    3.0 * v * w * cos,
                    -3.0 * v * w * w * sin,
                    -3.0 * v * w * w * w * cos,
                ]
            }
            (ModifiedTrapezoid, 0) => inclined_sine(MODIFIED_TRAPEZOID, 2.0 * TAU, z),
            (ModifiedTrapezoid, 1) => {
                let (v, w, t) = (MODIFIED_TRAPEZOID, 2.0 * TAU, z - 0.125);
                [v * (0.125 - 1.0 / w + t + 0.5 * w * t * t), v * (1.0 + w * t), v * w, 0.0, 0.0]
            }
            (ModifiedTrapezoid, _) => {
                let (v, w, r) = (MODIFIED_TRAPEZOID, 2.0 * TAU, z - 0.5);
                let (sin, cos) = (w * r).sin_cos();
                [
                    0.5 + v * ((1.0 + PI) * r + sin / w),
                    v * (1.0 + PI + cos),
                    -v * w * sin,
                    -v * w * w * cos,
                    v * w * w * w * sin,
                ]
            }
        }
    }

    /// f⁽ⁿ⁾(z) stepⁿ/n! of the analytic part `part`, as many as there are `coefficients`, at least 5.
    pub fn expand(self, part: usize, z: f64, step: f64, coefficients: &mut [f64]) {
        coefficients[..5].copy_from_slice(&self.at_in(part, z));
        // Beyond the quadratic terms each part is a polynomial or a harmonic.
        let inner = part > 0 && part < self.joints().len();
        let frequency = match self {
            ModifiedSine if inner => 2.0 * TAU / 3.0,
            _ => self.frequency(),
        };
        for n in 5..coefficients.len() {
            coefficients[n] = match (self, n) {
                (Polynomial345, 5) => 720.0,
                (Polynomial4567, 5) => 10080.0 * (5.0 * z * (1.0 - z) - 1.0),
                (Polynomial4567, 6) => 50400.0 * (1.0 - 2.0 * z),
                (Polynomial4567, 7) => -100800.0,
                (Polynomial345 | Polynomial4567, _) => 0.0,
                _ => -frequency * frequency * coefficients[n - 2],
            };
        }
        let mut factor = 1.0;
        for (n, c) in coefficients.iter_mut().enumerate().skip(1) {
            factor *= step / n as f64;
            *c *= factor;
        }
    }

    /// The largest |f⁽ⁿ⁾| over the rise, n = 0 … 4; order 1, 2 and 3 are C_v, C_a and C_j of VDI 2143.
    pub fn peak(self, order: usize) -> f64 {
        let sines = |v: f64, c_v: f64| {
            let w = 2.0 * TAU;
            [1.0, c_v, v * w, v * w * w, v * w * w * w]
        };
        let peaks = match self {
            SimpleSine => [1.0, PI / 2.0, PI.powi(2) / 2.0, PI.powi(3) / 2.0, PI.powi(4) / 2.0],
            InclinedSine => [1.0, 2.0, TAU, TAU.powi(2), TAU.powi(3)],
            Polynomial345 => [1.0, 1.875, 10.0 / f64::sqrt(3.0), 60.0, 360.0],
            Polynomial4567 => [1.0, 2.1875, 84.0 * f64::sqrt(5.0) / 25.0, 52.5, 840.0],
            ModifiedSine => sines(MODIFIED_SINE, 4.0 * MODIFIED_SINE),
            ModifiedTrapezoid => sines(MODIFIED_TRAPEZOID, 2.0),
        };
        peaks[order]
    }

    /// The angular frequency per z that resolves the law: the highest frequency of its sines, or the simple sine's for a
    /// polynomial, which every polynomial of its degree resolves.
    pub fn frequency(self) -> f64 {
        match self {
            SimpleSine | Polynomial345 | Polynomial4567 => PI,
            InclinedSine => TAU,
            ModifiedSine | ModifiedTrapezoid => 2.0 * TAU,
        }
    }
}

/// f = v (z − sin(wz)/w) and its derivatives: f″ = v w sin wz.
fn inclined_sine(v: f64, w: f64, z: f64) -> [f64; 5] {
    let (sin, cos) = (w * z).sin_cos();
    let half = (0.5 * w * z).sin();
    [v * minus_sine(w * z) / w, 2.0 * v * half * half, v * w * sin, v * w * w * cos, -v * w * w * w * sin]
}

/// x − sin x without cancellation.
fn minus_sine(x: f64) -> f64 {
    // The series needs eight terms for full precision up to 1; beyond, the difference loses at most three bits.
    if x.abs() > 1.0 {
        return x - x.sin();
    }
    let mut term = x * x * x / 6.0;
    let mut sum = term;
    for k in 2..9 {
        let n = f64::from(2 * k);
        term *= -x * x / (n * (n + 1.0));
        sum += term;
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    /// C_v, C_a, C_j as published, to the printed digits.
    const PUBLISHED: [(StandardLaw, [&str; 3]); 6] = [
        (SimpleSine, ["1.5708", "4.9348", "15.50"]),
        (InclinedSine, ["2.0000", "6.2832", "39.478"]),
        (Polynomial345, ["1.8750", "5.7735", "60.000"]),
        (Polynomial4567, ["2.1875", "7.5132", "52.500"]),
        (ModifiedSine, ["1.7596", "5.528", "69.47"]),
        (ModifiedTrapezoid, ["2.0000", "4.888", "61.43"]),
    ];

    #[test]
    fn the_constants_are_the_published_ones() {
        for (law, published) in PUBLISHED {
            let own = [law.peak(1), law.peak(2), law.peak(3)];
            for (own, printed) in own.into_iter().zip(published) {
                let digits = printed.split('.').nth(1).map_or(0, str::len);
                assert_eq!(format!("{own:.digits$}"), printed, "{law:?}");
            }
        }
    }

    #[test]
    fn the_curves_reach_their_peaks_and_do_not_exceed_them() {
        const N: usize = 20_000;
        for law in StandardLaw::ALL {
            let mut peaks = [0.0_f64; 5];
            for part in 0..=law.joints().len() {
                let edge = |i: usize| if i == 0 { 0.0 } else { law.joints().get(i - 1).copied().unwrap_or(1.0) };
                for i in 0..=N {
                    let f = law.at_in(part, edge(part) + (edge(part + 1) - edge(part)) * i as f64 / N as f64);
                    for n in 0..5 {
                        peaks[n] = peaks[n].max(f[n].abs());
                    }
                }
            }
            for n in 0..5 {
                let ratio = peaks[n] / law.peak(n);
                assert!(ratio > 1.0 - 1e-7 && ratio < 1.0 + 1e-14, "{law:?} order {n}: {ratio}");
            }
        }
    }

    #[test]
    fn a_rise_leads_from_rest_to_rest() {
        for law in StandardLaw::ALL {
            let (start, end, middle) = (law.at(0.0), law.at(1.0), law.at(0.5));
            assert_eq!((start[0], start[1], end[0], end[1]), (0.0, 0.0, 1.0, 0.0), "{law:?}");
            assert!((middle[0] - 0.5).abs() < 1.2e-16, "{law:?}");
            if law != SimpleSine {
                assert_eq!((start[2], end[2].abs()), (0.0, 0.0), "{law:?}");
            }
        }
    }

    #[test]
    fn velocity_and_acceleration_pass_the_joints() {
        for law in StandardLaw::ALL {
            for (part, &joint) in law.joints().iter().enumerate() {
                let (left, right) = (law.at_in(part, joint), law.at_in(part + 1, joint));
                for n in 0..3 {
                    assert!((left[n] - right[n]).abs() < 4e-15, "{law:?} at {joint}, order {n}");
                }
            }
        }
    }

    #[test]
    fn each_derivative_is_that_of_the_one_before() {
        let h = 1e-4;
        for law in StandardLaw::ALL {
            for part in 0..=law.joints().len() {
                // Also beyond the part: the continuation is the same analytic function.
                for i in 0..=50 {
                    let z = -0.05 + 1.1 * f64::from(i) / 50.0;
                    let f = |k: f64| law.at_in(part, z + k * h);
                    for n in 0..4 {
                        // Central difference of order 4; its error is h⁴/30 f⁽ⁿ⁺⁵⁾ plus rounding over h.
                        let slope = (8.0 * (f(1.0)[n] - f(-1.0)[n]) - (f(2.0)[n] - f(-2.0)[n])) / (12.0 * h);
                        let scale = law.peak(n + 1);
                        // The mirrored half continues the same function at its joint (z = ½), so no point is special.
                        assert!((slope - f(0.0)[n + 1]).abs() < 1e-8 * scale, "{law:?} part {part} z {z} order {n}");
                    }
                }
            }
        }
    }

    #[test]
    fn the_foot_of_the_inclined_sine_keeps_its_digits() {
        // f = (2π)² z³/6 (1 − (2πz)²/20 + …)
        for z in [1e-12, 1e-6, 1e-3] {
            let x = TAU * z;
            let exact = x * x * z / 6.0 * (1.0 - x * x / 20.0 * (1.0 - x * x / 42.0));
            assert!((InclinedSine.at(z)[0] / exact - 1.0).abs() < 1e-14, "{z}");
        }
        assert!((minus_sine(1.0) / (1.0 - 1.0_f64.sin()) - 1.0).abs() < 1e-15);
    }

    #[test]
    fn numbers_find_their_law_and_serialise_by_name() {
        for (i, law) in StandardLaw::ALL.into_iter().enumerate() {
            assert_eq!((law.number(), StandardLaw::from_number(i + 1)), (i + 1, law));
            assert_eq!(serde_json::to_string(&law).unwrap(), format!("\"{}\"", law.name()));
        }
    }
}
