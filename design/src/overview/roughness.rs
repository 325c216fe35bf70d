//! Noise of a table of lifts, and too few points: the errors of interpolation.
//!
//! σ̂ = √(mean of squares of the 8th divided differences, each divided by the root of the sum of its squared weights). White
//! noise of the standard deviation σ has σ̂ = σ, from all points and from every second one. The contribution of a law grows
//! with the distance of the points: every second one has 4.7 times as much of it at a jump of U″, and more elsewhere. So the
//! table is noisy if that factor is below 3.5 and a tenth of the squares is above a tenth of their mean; σ̂ is then the noise.
//! The quintic spline through points h apart turns it into errors of U″ whose root mean square over the turn is 3.89 σ̂/h²,
//! with the h of each difference. Without noise this is the size of the errors of the sampling itself.

use super::{Overview, Warning};
use crate::law_motions::{greatest_of, shown};
use crate::report::Setting;
use camdrive::motion::table::{Bend, Points};
use camdrive::motion::{MotionLaw, Table};
use std::f64::consts::TAU;

/// The order of the differences: higher ones span more of the motion, lower ones contain more of it.
const ORDER: usize = 8;

/// The fewest points for the differences of every second one: with fewer, these contain only the motion.
const LEAST_POINTS: usize = 26;

/// σ̂ of every second point over σ̂ below which a table is noisy. Among 600 cycles of all standard laws with 26 … 720 points
/// one exact table in ten thousand is below.
const NOISY: f64 = 3.5;

/// A tenth of the squares of differences exceeds this part of their mean in noise; a kink or a jump affects only a few.
const SPREAD: f64 = 0.1;

/// The factor from σ/h² to the root mean square error of U″ of the periodic quintic spline.
const AMPLIFICATION: f64 = 3.89;

/// The tolerated part of max |U″| for this error; its peaks are some three times as large.
const TOLERATED: f64 = 0.02;

/// The tolerated part for sampling without noise: its estimate may be several times too large.
const TOLERATED_OF_SAMPLING: f64 = 0.05;

/// σ̂ in the unit of the lift, and the root mean square error of U″ from such noise; None with too few points.
pub fn scatter_and_error(table: &Table) -> Option<[f64; 2]> {
    let points = table.points();
    let n = points.angles.len();
    // A spline next to a rest has derivatives as if they were given.
    let bends = table.bends();
    let spline =
        bends.iter().all(|bend| bend.before == bend.behind) && (bends.is_empty() || bends.contains(&Bend::default()));
    (ORDER < n && spline).then(|| {
        let size = |weight: fn(f64) -> f64| table.scale.abs() * deviation(points, 1, weight);
        [size(|_| 1.0), AMPLIFICATION * size(|distance| distance.powi(-4))]
    })
}

/// σ̂, the standard deviation of the noise of lifts; None if they are not noisy.
pub(super) fn scatter(points: &Points) -> Option<f64> {
    let enough = points.angles.len() >= LEAST_POINTS;
    let mut squares = enough.then(|| squares(points, 1, |_| 1.0))?;
    squares.sort_by(f64::total_cmp);
    let mean = mean(&squares);
    let is_everywhere = squares[squares.len() * 9 / 10] > SPREAD * mean;
    let sigma = mean.sqrt();
    (is_everywhere && deviation(points, 2, |_| 1.0) < NOISY * sigma).then_some(sigma)
}

/// σ̂ of points that are `step` points apart; the mean of squares is weighted by their distance (rad).
fn deviation(points: &Points, step: usize, weight: fn(f64) -> f64) -> f64 {
    mean(&squares(points, step, weight)).sqrt()
}

fn mean(squares: &[f64]) -> f64 {
    squares.iter().sum::<f64>() / squares.len() as f64
}

/// The squares of the differences; σ̂ is the root of their mean.
fn squares(points: &Points, step: usize, weight: fn(f64) -> f64) -> Vec<f64> {
    let n = points.angles.len();
    // In mean distances, so that products of eight of them stay near 1.
    let place = |i: usize| (points.angles[i % n] + TAU * (i / n) as f64) * n as f64 / (TAU * step as f64);
    let square = |first: usize| {
        let chosen = || (0..=ORDER).map(|k| first + k * step);
        let (mut sum, mut weights) = (0.0, 0.0);
        for j in chosen() {
            let weight = 1.0 / chosen().filter(|i| *i != j).map(|i| place(j) - place(i)).product::<f64>();
            sum += weight * points.lifts[j % n];
            weights += weight * weight;
        }
        let distance = (place(first + ORDER * step) - place(first)) * TAU / (n * ORDER) as f64;
        sum * sum / weights * weight(distance * step as f64)
    };
    (0..n).map(square).collect()
}

impl Overview {
    /// Warns if the law of this section is a table whose noise shows in U″, or whose points are too few for it.
    pub(super) fn roughness(&mut self, section: &str, law: &MotionLaw, unit: &str) {
        let MotionLaw::Table(table) = law else { return };
        let Some([sigma, error]) = scatter_and_error(table) else { return };
        let share = error / greatest_of(law, |u| u[2].abs());
        let noisy = scatter(table.points()).is_some();
        if share <= if noisy { TOLERATED } else { TOLERATED_OF_SAMPLING } {
            return;
        }
        let percent = 100.0 * share;
        let message = if noisy {
            let size = shown(sigma, unit);
            format!(
                "{section}: the table is rough: its lifts scatter by {size} about a smooth law; in U″ of the spline this \
                 is a noise of {percent:.0} % of the largest value, noise included (root mean square)"
            )
        } else {
            format!(
                "{section}: the points of the table leave U″ uncertain by up to about {percent:.0} % of its largest value (root mean \
                 square)"
            )
        };
        let hint = if noisy {
            "smooth it by `noise = \"estimate\"`, also in place of a `noise` that is too small, or take `interpolation = \"fourier\"` with few `harmonics`; rounded lifts scatter too: write more digits"
        } else {
            "take points at smaller distances, above all where the acceleration jumps, or the law itself (a cycle, a plan); \
             enlarge a given `noise` or set it to \"estimate\""
        };
        if noisy {
            let key = format!("{section}.noise");
            self.cures.push((self.warnings.len(), Setting::new(key, "estimate")));
        }
        self.warnings.push(Warning { message, hint: hint.to_owned() });
    }
}
