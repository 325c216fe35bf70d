//! The law of the lever that makes a tool move as prescribed: the mechanisms between them backwards.
//!
//! χ(φ) = f⁻¹(y(φ)), y a finite Fourier series. χ is analytic and periodic, so that its harmonics fall geometrically; the
//! series is cut where the rest is at rounding level, and what is left of it in the tool's acceleration is measured.

use crate::drives::rigid_machine::linkage::{Linkage, Obstacle};
use crate::motion::Fourier;
use crate::motion::harmonic_analysis::analyse;
use crate::motion::table::Points;
use std::f64::consts::TAU;

/// The highest harmonic of a law, as scenes have it.
const HIGHEST: usize = 256;

/// Positions at which the mechanisms are turned back: four for the shortest wave, so that its aliases are beyond
/// [`HIGHEST`].
const POSITIONS: usize = 1024;

/// The error of the tool's acceleration that a law may have, relative to its largest value. Laws that need more harmonics
/// than there are have a tool near a dead centre.
const COARSEST: f64 = 1e-9;

/// The part of the largest acceleration that the harmonics left out may have together.
const REST: f64 = 1e-13;

/// The lever's law.
#[derive(Clone, Debug, PartialEq)]
pub struct LeverLaw {
    /// χ(φ) [rad].
    pub series: Fourier,
    /// max |y″ − y″_wanted| / max |y″_wanted| over the turn.
    pub error: f64,
}

/// The law that makes the tool behind `linkage` move as `tool`, beginning next to the lever's angle `near` [rad].
///
/// # Errors
/// A sentence that says at which angle which mechanism hinders it.
pub fn lever_law(linkage: &Linkage, tool: &Fourier, near: f64) -> Result<LeverLaw, String> {
    let mut inputs = linkage.inputs(near);
    let [at_near] = linkage.tool([near]);
    if !at_near.is_finite() {
        return Err(format!(
            "the mechanisms cannot be assembled at the lever's angle {:.4} deg, next to which its motion is to begin",
            near.to_degrees()
        ));
    }
    let mut angles = Vec::with_capacity(POSITIONS);
    let mut lifts = Vec::with_capacity(POSITIONS);
    for i in 0..=POSITIONS {
        let phi = TAU * i as f64 / POSITIONS as f64;
        let wanted = tool.at(phi).0[0];
        let lever = linkage.lever_at(wanted, &mut inputs).map_err(|obstacle| {
            let (mechanism, output, what) = match obstacle {
                Obstacle::OutOfReach { mechanism, output } => (mechanism, output, "cannot reach the output"),
                Obstacle::DeadCentre { mechanism, output } => (mechanism, output, "is at a dead centre at the output"),
            };
            format!(
                "at phi = {:.4} deg, where the tool is to be at {wanted:.6}, mechanism {} {what} {output:.6} (with the lever at {:.4} deg the tool is at {at_near:.6})",
                phi.to_degrees(),
                mechanism + 1,
                near.to_degrees()
            )
        })?;
        angles.push(phi);
        lifts.push(lever);
    }
    // A lever that has turned right round comes back to another angle.
    let (first, last) = (lifts[0], lifts[POSITIONS]);
    if (first - last).abs() > 1e-9 * (1.0 + first.abs()) {
        return Err(format!(
            "the lever would not come back after a turn: it ends {:.4} deg away from where it began",
            (last - first).to_degrees()
        ));
    }
    (angles.pop(), lifts.pop());
    let full = analyse(Points { angles, lifts }, HIGHEST).map_err(|e| e.to_string())?.series;
    let weight = |k: usize| (k * k) as f64 * (full.a[k].powi(2) + full.b[k].powi(2)).sqrt();
    let largest = (1..=HIGHEST).map(weight).fold(f64::MIN_POSITIVE, f64::max);
    // Harmonics at rounding level carry nothing of the motion, whatever their number makes of them in the acceleration.
    let rounding = f64::EPSILON * full.a.iter().chain(&full.b).fold(0.0, |m: f64, c| m.max(c.abs()));
    let mut rest = 0.0;
    let order = (1..=HIGHEST)
        .rev()
        .find(|k| {
            rest += weight(*k);
            rest > REST * largest && weight(*k) > rounding * (k * k) as f64
        })
        .unwrap_or(1);
    let series = Fourier::new(full.a[..=order].to_vec(), full.b[..=order].to_vec());
    let error = error(linkage, &series, tool);
    if !(error <= COARSEST) {
        return Err(format!(
            "a series of {order} harmonics for the lever leaves an error of {error:.1e} of the tool's acceleration, more than {COARSEST:e}: the motion leads too near to a dead centre"
        ));
    }
    Ok(LeverLaw { series, error })
}

/// max |y″ − y″_wanted| / max |y″_wanted|, between the positions of the analysis too.
fn error(linkage: &Linkage, lever: &Fourier, tool: &Fourier) -> f64 {
    // A tool that stands still is measured by its place.
    let place = tool.a.iter().fold(f64::MIN_POSITIVE, |m, a| m.max(a.abs()));
    let (mut missed, mut largest) = (0.0_f64, 1e-6 * place);
    for i in 0..4 * POSITIONS {
        let phi = TAU * (i as f64 + 0.3) / (4 * POSITIONS) as f64;
        let [u, u1, u2, ..] = lever.at(phi).0;
        let [.., actual] = linkage.tool([u, u1, u2]);
        let wanted = tool.at(phi).0[2];
        largest = largest.max(wanted.abs());
        // Not the maximum of two numbers, which would drop what is none.
        let miss = (actual - wanted).abs();
        missed = if miss <= missed { missed } else { miss };
    }
    missed / largest
}
