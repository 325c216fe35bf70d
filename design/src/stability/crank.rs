//! θ*(σ) of a parallel crank: the damping beyond which an instability vanishes, over the stiffness of shafts and rod.
//!
//! σ = c₁₂/(c_AB R²), ζ = (√(1 + σ) − √σ)², r₂ₙ = −(1 − ζ) ζⁿ⁻¹. By the source's (7), θ* = ¼ (|r₂ⱼ| + ½ rⱼ²), of a single crank
//!
//! (1 − ζ)/4, (1 − ζ²)/8, (1 − ζ) ζ²/4 for j = 1, 2, 3, and (1 − ζ) ζ/4 for j = 2 without r₂ (its curve 4).
//!
//! The exact θ* beside them come from the same oscillator with another c_AB. That r₃ = 0 lets the second term of j = 3 vanish is
//! an error of the source: r₂ r₄ and r₂³ outweigh r₆, and its conclusion, no danger at Ω ≈ ω₀/3, does not hold.
//!
//! Source: Dresig, Vulfson, *Dynamik der Mechanismen*, section 4.5.3 (7) and figure 4.23c.

use super::bounds::{Bounds, Harmonics};
use super::hill;
use super::system::System;
use super::tongue::Tongue;
use crate::oscillator::of_coefficients;
use crate::parallel;
use crate::resource;
use camdrive::drives::parametric::Scene;
use camdrive::drives::parametric::law::Law;
use serde::Serialize;

/// Orders of the source's diagram.
const ORDERS: usize = 3;
/// σ of the diagram: from a notch at the dead centres to a pure sine.
const RANGE: [f64; 2] = [0.01, 10.0];
/// How far it is widened for that of the scene.
const WIDEST: [f64; 2] = [1e-4, 1e4];
/// Points of a curve over three decades.
pub(super) const POINTS: usize = 49;

/// The curves.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Crank {
    /// σ of the scene.
    pub sigma: f64,
    /// By order.
    pub curves: Vec<Curve>,
}

/// The curve of an order.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Curve {
    /// j.
    pub j: f64,
    /// By σ.
    pub points: Vec<Point>,
}

/// θ* at a σ.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Point {
    /// σ.
    pub sigma: f64,
    /// Exact; None where the boundaries are not found.
    pub exact: Option<f64>,
    /// By the approximations.
    #[serde(flatten)]
    pub bounds: Bounds,
}

/// The curves of a scene with a parallel crank; None of another one, and where the stiffness is constant.
pub fn curves(scene: &resource::Scene, done: &(dyn Fn() + Sync)) -> Option<Crank> {
    let resource::Scene::ParametricDrive(scene) = scene else { return None };
    let Law::Crank(law) = &scene.law else { return None };
    let sigma = law.crank.sigma();
    let low = (0.5 * sigma).clamp(WIDEST[0], RANGE[0]);
    let high = (2.0 * sigma).clamp(RANGE[1], WIDEST[1]);
    let places: Vec<f64> = (0..POINTS).map(|i| low * (high / low).powf(i as f64 / (POINTS - 1) as f64)).collect();
    let rows = parallel::map(&places, |sigma| row(scene, *sigma), done);
    let curve = |n: usize| {
        let of_order: Vec<(f64, Point)> = rows.iter().filter_map(|row| row.get(n).copied()).collect();
        Some(Curve { j: of_order.first()?.0, points: of_order.into_iter().map(|(_, point)| point).collect() })
    };
    let curves: Vec<Curve> = (0..ORDERS).filter_map(curve).collect();
    (!curves.is_empty()).then_some(Crank { sigma, curves })
}

/// j and θ* of the first orders of the scene with the σ of another rod.
pub fn row(scene: &Scene, sigma: f64) -> Vec<(f64, Point)> {
    let mut scene = scene.clone();
    if let Law::Crank(law) = &mut scene.law {
        law.crank.c_ab = law.crank.shafts() / (sigma * law.crank.r * law.crank.r);
    }
    let oscillator = of_coefficients(&scene);
    let Some(system) = System::new(&oscillator).ok().filter(|s| s.parts > 0) else {
        return Vec::new();
    };
    let (start, harmonics) = (hill::boundaries(&system, ORDERS), Harmonics::new(&system));
    let order = |n: usize| {
        let twice = n * system.parts;
        let tongue = Tongue::numbered(&system, n, &start);
        let exact = tongue.and_then(|tongue| tongue.apex(&system)).map(|apex| apex.theta);
        (0.5 * twice as f64, Point { sigma, exact, bounds: harmonics.bounds(twice) })
    };
    (1..=ORDERS).map(order).collect()
}
