//! The linearised drive as an oscillator with periodic coefficients.

use super::{Parameters, Scene};
use crate::drives::follower::elastic_shaft::REACH;
use crate::drives::oscillator::{PeriodicOscillator, Terms};
use crate::drives::shaft::cam_drive::DriveMode;
use crate::drives::unit;

/// J(φ) q̈ + (b + Ω J′) q̇ + (c + Ω² J″/2) q = −Ω² J′/2, J(φ) = J + m U′².
///
/// Source: Dresig, Vulfson, *Dynamik der Mechanismen*, section 4.6.3 (1); J(φ) gathers its terms.
pub(super) fn of(scene: &Scene) -> PeriodicOscillator {
    let (&Scene { linear, .. }, Parameters { m, inertia, c, b }) = (scene, scene.parameters);
    let (law, resolved) = (scene.cam.clone(), scene.cam.clone());
    let terms = move |segment: usize, phi: f64| {
        let [_, u1, u2, u3, _] = law.at_in(segment, phi).0;
        let (g, g1) = (m * u1 * u2, m * (u2 * u2 + u1 * u3));
        Terms { m: inertia + m * u1 * u1, b, b1: 2.0 * g, c, c2: g1, f: 0.0, f2: -g }
    };
    let (speed, start) = match scene.drive {
        DriveMode::Constant { w, phi_start } => (Some(w), phi_start),
        DriveMode::Input => (None, 0.0),
    };
    PeriodicOscillator {
        terms: Box::new(terms),
        breakpoints: scene.cam.breakpoints().to_vec(),
        reach: Box::new(move |segment| REACH / resolved.resolution_in(segment).max(1.0)),
        cost: scene.cam.cost(),
        inertia_turns: true,
        speed,
        start,
        coordinate: &unit::ANGLE,
        load: &unit::TORQUE,
        note: (!linear)
            .then(|| "The drive of the scene is not linear; this is its linearisation about q = 0.".to_owned()),
    }
}
