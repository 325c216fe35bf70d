//! The drive as an oscillator with periodic coefficients, for studies of its stability.

use super::Scene;
use super::variables::{of_coefficients, quantities};
use crate::drives::oscillator::{PeriodicOscillator, Terms};
use crate::drives::shaft::cam_drive::DriveMode;

pub(super) fn of(scene: &Scene) -> PeriodicOscillator {
    let coefficients = scene.law.coefficients();
    let pieces = coefficients.pieces();
    let (speed, start) = match scene.drive {
        DriveMode::Constant { w, phi_start } => (Some(w), phi_start),
        DriveMode::Input => (None, 0.0),
    };
    let coordinate = scene.law.coordinate();
    let (breakpoints, reaches) = pieces.into_iter().unzip::<f64, f64, Vec<f64>, Vec<f64>>();
    let (least, cost) = (coefficients.least_reach(), coefficients.cost());
    PeriodicOscillator {
        terms: Box::new(move |_, phi| {
            let values = coefficients.at(phi);
            Terms { m: values.m[0], b: values.b[0], c: values.c[0], f: values.f[0], ..Terms::default() }
        }),
        breakpoints,
        reach: Box::new(move |segment| reaches.get(segment).copied().unwrap_or(least)),
        cost,
        inertia_turns: false,
        speed,
        start,
        coordinate: quantities(coordinate)[0],
        load: of_coefficients(coordinate)[3],
        note: None,
    }
}
