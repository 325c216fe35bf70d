//! The angles at which a motion law lets the contact change flanks: the zeros of U″ with a change of sign.
//!
//! Quasi-statically the contact force is F_K = (m1 + m2) Ω²U″, so each of them is a passage of the clearance, and U‴ there
//! decides how hard it is. Rests, U″ = 0 over an angle, are no passages of their own.

use crate::law_motions::greatest_of;
use crate::search::segments;
use camdrive::motion::MotionLaw;
use camdrive::numerics::first_root::first_root;
use serde::Serialize;
use std::f64::consts::TAU;

/// A zero of U″ with a change of sign.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Crossing {
    /// φ in [0, 2π) (rad).
    pub phi: f64,
    /// U‴ there, in the segment in which the motion goes on (m).
    pub jerk: f64,
    /// U⁗ there (m).
    pub fourth: f64,
    /// U⁽⁵⁾ there (m).
    pub fifth: f64,
}

/// The zeros of U″ that matter for the clearance, and its size.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Signs {
    /// The zeros with a change of sign, by angle.
    pub crossings: Vec<Crossing>,
    /// max |U″| (m).
    pub largest: f64,
    /// The number of zeros left out because their lobes of U″ stay below the ignored share.
    pub ignored: usize,
}

/// Coefficients of the Taylor series of U; over an angle of 1/k for the highest harmonic k the rest is below 1/30!.
const TERMS: usize = 32;

/// U″ this small a part of its largest value is a rounding error of a sum over harmonics.
const ROUNDING: f64 = 1e-13;

/// Per piece of the law of about one radian of its highest harmonic: enough to see the height of a lobe to a per cent.
const SAMPLES: usize = 8;

/// Pieces of the turn within which the Taylor series converges at once: segment, start, width.
fn pieces(law: &MotionLaw) -> Vec<(usize, f64, f64)> {
    let mut pieces = Vec::new();
    for (segment, [start, end]) in segments(law.breakpoints()).into_iter().enumerate() {
        let parts = ((end - start) * law.resolution_in(segment)).ceil().max(1.0);
        let part = (end - start) / parts;
        pieces.extend((0..parts as usize).map(|i| (segment, start + i as f64 * part, part)));
    }
    pieces
}

/// The signs of U″ around the turn. Lobes that stay below the part `ignore` of the largest one count as rest. `forward` is the
/// sense in which the shaft turns; it selects the one-sided U‴ at a jump.
pub fn signs(law: &MotionLaw, forward: bool, ignore: f64) -> Signs {
    let pieces = pieces(law);
    let within = |phi: f64| phi - TAU * (phi / TAU).round();
    let largest = greatest_of(law, |u| u[2].abs());
    let zeros = zeros(law, &pieces, ROUNDING * largest);
    // Lobe i reaches from zero i to the next one, the last one around the turn; a lobe may lie between two samples.
    let end = |lobe: usize| zeros.get(lobe + 1).copied().unwrap_or(zeros[0] + TAU);
    let mut heights: Vec<f64> =
        (0..zeros.len()).map(|lobe| law.at(within(0.5 * (zeros[lobe] + end(lobe)))).0[2]).collect();
    for (segment, start, width) in pieces {
        for i in 0..SAMPLES {
            let phi = start + width * (i as f64 + 0.5) / SAMPLES as f64;
            let value = law.at_in(segment, within(phi)).0[2];
            let lobe = (zeros.partition_point(|zero| *zero <= phi) + zeros.len()).wrapping_sub(1);
            let height = lobe.checked_rem(zeros.len()).and_then(|lobe| heights.get_mut(lobe));
            if let Some(height) = height.filter(|height| value.abs() > height.abs()) {
                *height = value;
            }
        }
    }
    // In the sense of the motion, each with the angle at which it begins.
    let begin = |lobe: usize| if forward { zeros[lobe] } else { end(lobe) };
    let mut begins: Vec<f64> = (0..zeros.len()).map(begin).collect();
    if !forward {
        begins.reverse();
        heights.reverse();
    }
    let kept = changes(&heights, ignore.max(ROUNDING) * largest);
    let ignored = changes(&heights, f64::MIN_POSITIVE).len() - kept.len();
    let crossing = |phi: f64| {
        let phi = phi.rem_euclid(TAU);
        let segment = law.segment(phi, forward);
        let [.., jerk, fourth] = law.at_in(segment, within(phi)).0;
        Crossing { phi, jerk, fourth, fifth: law.fifth_in(segment, within(phi)) }
    };
    let mut crossings: Vec<Crossing> = kept.into_iter().map(|lobe| crossing(begins[lobe])).collect();
    crossings.sort_by(|a, b| a.phi.total_cmp(&b.phi));
    Signs { crossings, largest, ignored }
}

/// The lobes with which the sign changes: those of at least the height `least` after one of the other sign, whatever lower ones
/// lie between. `heights` have signs and go around the turn in the sense of the motion.
pub fn changes(heights: &[f64], least: f64) -> Vec<usize> {
    let mut high: Vec<usize> = (0..heights.len()).filter(|lobe| heights[*lobe].abs() >= least).collect();
    let mut sign = high.last().map_or(0.0, |lobe| heights[*lobe].signum());
    high.retain(|lobe| std::mem::replace(&mut sign, heights[*lobe].signum()) != heights[*lobe].signum());
    high
}

/// The angles at which U″ changes its sign or begins or ends to be 0, ascending from the first piece on. None is missed: each
/// is the certified first zero of a series after the one before it.
fn zeros(law: &MotionLaw, pieces: &[(usize, f64, f64)], rounding: f64) -> Vec<f64> {
    let (mut zeros, mut first, mut sign) = (Vec::new(), None, None);
    for &(segment, start, width) in pieces {
        let mut at = 0.0;
        // A polynomial of this degree has no more zeros.
        for round in 0..TERMS {
            let phi = start + at;
            let series =
                second_derivative(law, segment, phi, width - at, if round > 0 { f64::INFINITY } else { rounding });
            let lead = series.iter().find(|c| **c != 0.0).map_or(0.0, |c| c.signum());
            first = first.or(Some(lead));
            if sign.replace(lead).is_some_and(|before| before != lead) {
                zeros.push(phi);
            }
            let Some(zero) = first_root(&series.map(|c| lead * c), 1.0).filter(|x| *x > 0.0) else { break };
            at += zero * (width - at);
            if at >= width * (1.0 - ON_END) {
                break;
            }
        }
    }
    if sign != first {
        zeros.insert(0, pieces.first().map_or(0.0, |piece| piece.1));
    }
    zeros
}

/// A zero this close to the end of a piece, as a part of it, is the beginning of the next one.
const ON_END: f64 = 1e-13;

/// The coefficients of U″(φ + width x) in x, up to a factor; a value at x = 0 up to `zero` counts as 0.
fn second_derivative(law: &MotionLaw, segment: usize, phi: f64, width: f64, zero: f64) -> [f64; TERMS - 2] {
    let mut c = [0.0; TERMS];
    law.expand(segment, phi - TAU * (phi / TAU).round(), width, &mut c);
    let mut series: [f64; TERMS - 2] = std::array::from_fn(|n| ((n + 1) * (n + 2)) as f64 * c[n + 2]);
    if series[0].abs() <= zero * width * width {
        series[0] = 0.0;
    }
    series
}
