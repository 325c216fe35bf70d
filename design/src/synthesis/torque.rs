//! The profile with the least kinetostatic torque: max |U′U″| (the source's torque coefficient C_M of a whole profile).
//!
//! Source: Dresig, Vulfson, *Dynamik der Mechanismen*, section 4.6.3: without danger of vibration the task is to make
//! the largest value of U′U″ small.

use super::deviation::{self, Window};
use super::nonlinear::{Norm, Values};
use super::sampling::{COARSE, angles};
use super::shaft::{Number, Spectrum};
use super::{Basis, Curve};
use camdrive::motion::Fourier;
use std::f64::consts::TAU;

/// U′U″ of the profile with the coefficients x, at samples and where it is largest.
pub fn values(basis: &Basis, x: &[f64]) -> Values {
    let series = basis.series_of(x);
    let torque = torque(&series);
    let target = Curve::default();
    let turn = Window { from: 0.0, to: TAU, order: 0, target: &target };
    // The product has waves twice as short.
    let mut places = angles(0.0, TAU, torque.order(), COARSE);
    places.extend(turn.extremes(&torque, 0.8).into_iter().map(|extreme| extreme.phi));
    let gradient = |phi: &f64| {
        let [_, first, second, ..] = series.at(*phi).0;
        let (slopes, bends) = (basis.row(0, *phi, 1, None), basis.row(0, *phi, 2, None));
        slopes.iter().zip(&bends).map(|(slope, bend)| slope.hi * second + first * bend.hi).collect()
    };
    let values = places.iter().map(|phi| torque.at(*phi).0[0]).collect();
    Values { values, gradients: places.iter().map(gradient).collect(), norm: Norm::Peak }
}

/// max |U′U″|.
pub fn peak(series: &Fourier) -> f64 {
    deviation::peak(&torque(series), 0).value.abs()
}

/// U′U″, of which the kinetostatic torque is −m Ω² times, as the series ½ (U′²)′.
fn torque(series: &Fourier) -> Fourier {
    let slope = Spectrum::of_slope(series);
    slope.times(&slope).series(|n| Number::new(0.0, 0.5 * n as f64))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_torque_is_the_product() {
        let series = Fourier::new(vec![0.3, 0.6, 0.05, -0.1], vec![0.0, -0.02, 0.3, 0.01]);
        let torque = torque(&series);
        for phi in [0.0, 0.4, 2.0, 5.5] {
            let [_, first, second, ..] = series.at(phi).0;
            assert!((torque.at(phi).0[0] - first * second).abs() < 1e-15);
        }
    }
}
