//! Noise in a table of lifts, which interpolation enlarges in U″.
//!
//! σ̂ₘ = √(mean of squares of the m-th divided differences, each divided by the root of the sum of its squared weights).
//! White noise of the standard deviation σ has σ̂ₘ = σ for every order m. What a law adds falls with m: where U‴ jumps
//! σ̂₁₀/σ̂₈ = 0.906, where U″ jumps 0.84, where it is smooth nearly nothing. So the table is noisy where σ̂₁₀/σ̂₈ > 0.95, and
//! σ̂₈ is the noise. At points h apart the quintic spline makes of it errors of U″ whose root mean square over the turn is 3.89 σ/h².

use super::{Overview, Warning, angles, largest, shown};
use camdrive::motion::table::Points;
use camdrive::motion::{MotionLaw, Table};
use std::f64::consts::TAU;

/// σ̂₁₀/σ̂₈ above which a table is noisy: between 0.906 of laws and 1 of noise.
const NOISY: f64 = 0.95;

/// The factor from σ/h² to the root mean square error of U″ of the periodic quintic spline.
const AMPLIFICATION: f64 = 3.89;

/// The part of max |U″| that this error may reach; its peaks are some three times as large.
const TOLERATED: f64 = 0.02;

/// σ̂₈ in the unit of the lift and the root mean square error of U″ that it makes; None where the table is not noisy.
pub fn noise(table: &Table) -> Option<[f64; 2]> {
    let eight = scatter(table.points()).filter(|_| !table.is_bent())?;
    let angles = &table.points().angles;
    let n = angles.len();
    let around = |i: usize| angles[i % n] + TAU * (i / n) as f64;
    // Half the way between the neighbours of point i.
    let distance = |i: usize| 0.5 * (around(i + 2) - around(i));
    let inverse = ((0..n).map(|i| distance(i).powi(-4)).sum::<f64>() / n as f64).sqrt();
    let noise = table.scale.abs() * eight;
    Some([noise, AMPLIFICATION * noise * inverse])
}

/// σ̂₈, the standard deviation of the noise of lifts; None where they are not noisy.
pub fn scatter(points: &Points) -> Option<f64> {
    let (eight, ten) = (deviation(points, 8)?, deviation(points, 10)?);
    (ten > NOISY * eight).then_some(eight)
}

/// σ̂ of the order m; None where there are too few points for it.
fn deviation(points: &Points, m: usize) -> Option<f64> {
    let n = points.angles.len();
    if n <= m {
        return None;
    }
    // In mean distances, so that products of ten of them stay near 1.
    let place = |i: usize| (points.angles[i % n] + TAU * (i / n) as f64) * n as f64 / TAU;
    let square = |first: usize| {
        let (mut sum, mut weights) = (0.0, 0.0);
        for j in first..=first + m {
            let others = (first..=first + m).filter(|i| *i != j);
            let weight = 1.0 / others.map(|i| place(j) - place(i)).product::<f64>();
            sum += weight * points.lifts[j % n];
            weights += weight * weight;
        }
        sum * sum / weights
    };
    Some(((0..n).map(square).sum::<f64>() / n as f64).sqrt())
}

impl Overview {
    /// Warns where the law of this section is a table whose noise shows in U″.
    pub(super) fn roughness(&mut self, section: &str, law: &MotionLaw) {
        let MotionLaw::Table(table) = law else { return };
        let Some([noise, error]) = noise(table) else { return };
        let peak = largest(&angles().map(|phi| law.at(phi).0[2]).collect::<Vec<f64>>());
        if error > TOLERATED * peak {
            let share = 100.0 * error / peak;
            let size = if section == "machine.J" { format!("{noise:.1e} kg.m2") } else { shown(noise, "m") };
            self.warnings.push(Warning {
                message: format!(
                    "{section}: the table is rough: its lifts scatter by {size} about a smooth law, and the spline makes \
                     of that {share:.0} % of the largest U″ with this noise in it (root mean square)"
                ),
                hint: "smooth it by `noise = \"estimate\"`, or take `interpolation = \"fourier\"` with few `harmonics`; rounded lifts scatter too: \
                       write more digits"
                    .to_owned(),
            });
        }
    }
}
