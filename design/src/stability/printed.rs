//! The printed formulas of instability ([`crate::formulas::instability`]) compared with the exact values, and θ* of a parallel
//! crank.
//!
//! **Parallel crank**, θ* over the stiffness of shafts and rod: σ = c₁₂/(c_AB R²), ζ = (√(1 + σ) − √σ)², r₂ₙ = −(1 − ζ) ζⁿ⁻¹. By
//! the source's (7), θ* = ¼ (|r₂ⱼ| + ½ rⱼ²), of a single crank
//!
//! (1 − ζ)/4, (1 − ζ²)/8, (1 − ζ) ζ²/4 for j = 1, 2, 3, and (1 − ζ) ζ/4 for j = 2 without r₂ (its curve 4).
//!
//! The exact θ* come from the same oscillator with another c_AB. The source errs in that r₃ = 0 lets the second term of j = 3
//! vanish: r₂ r₄ and r₂³ outweigh r₆, and its conclusion, no danger at Ω ≈ ω₀/3, does not hold.
//!
//! Source: Dresig, Vulfson, *Dynamik der Mechanismen*, section 4.5.3 (7), figure 4.23c.

use super::system::System;
use super::tongue::Tongue;
use super::{NEGLIGIBLE, Order, StabilityAnalysis, hill};
use crate::formulas::instability::Bounds;
use crate::oscillator::of_coefficients;
use crate::report::unit::{ONE, RPM};
use crate::report::{Report, Rows, Table};
use crate::{parallel, resource};
use camdrive::drives::parametric::Scene;
use camdrive::drives::parametric::law::Law;
use serde::Serialize;

/// Orders of the source's diagram.
const CRANK_ORDERS: usize = 3;
/// σ of the diagram: from a notch at the dead centres to a pure sine.
const RANGE: [f64; 2] = [0.01, 10.0];
/// The widest range, for a scene outside the diagram's.
const WIDEST: [f64; 2] = [1e-4, 1e4];
/// Points of a curve over three decades.
pub(super) const POINTS: usize = 49;

/// θ* of a parallel crank over its stiffness.
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
    pub points: Vec<CrankPoint>,
}

/// θ* at a σ.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct CrankPoint {
    /// σ.
    pub sigma: f64,
    /// Exact; None if the boundaries are not found.
    pub exact: Option<f64>,
    /// By the approximations.
    #[serde(flatten)]
    pub bounds: Bounds,
}

/// The curves of a scene with a parallel crank; None for other scenes and for a constant stiffness.
pub fn curves(scene: &resource::Scene, done: &(dyn Fn() + Sync)) -> Option<Crank> {
    let resource::Scene::ParametricDrive(scene) = scene else { return None };
    let Law::Crank(law) = &scene.law else { return None };
    let sigma = law.crank.sigma();
    let low = (0.5 * sigma).clamp(WIDEST[0], RANGE[0]);
    let high = (2.0 * sigma).clamp(RANGE[1], WIDEST[1]);
    let places: Vec<f64> = (0..POINTS).map(|i| low * (high / low).powf(i as f64 / (POINTS - 1) as f64)).collect();
    let rows = parallel::map(&places, |sigma| row(scene, *sigma), done);
    let curve = |n: usize| {
        let of_order: Vec<(f64, CrankPoint)> = rows.iter().filter_map(|row| row.get(n).copied()).collect();
        Some(Curve { j: of_order.first()?.0, points: of_order.into_iter().map(|(_, point)| point).collect() })
    };
    let curves: Vec<Curve> = (0..CRANK_ORDERS).filter_map(curve).collect();
    (!curves.is_empty()).then_some(Crank { sigma, curves })
}

/// j and θ* of the first orders of the scene with the σ of another rod.
pub fn row(scene: &Scene, sigma: f64) -> Vec<(f64, CrankPoint)> {
    let mut scene = scene.clone();
    if let Law::Crank(law) = &mut scene.law {
        law.crank.c_ab = law.crank.shafts() / (sigma * law.crank.r * law.crank.r);
    }
    let oscillator = of_coefficients(&scene);
    let Some(system) = System::new(&oscillator).ok().filter(|s| s.parts > 0) else {
        return Vec::new();
    };
    let (start, harmonics) = (hill::boundaries(&system, CRANK_ORDERS), system.printed());
    let order = |n: usize| {
        let twice = n * system.parts;
        let tongue = Tongue::numbered(&system, n, &start);
        let exact = tongue.and_then(|tongue| tongue.apex(&system)).map(|apex| apex.theta);
        (0.5 * twice as f64, CrankPoint { sigma, exact, bounds: harmonics.bounds(twice) })
    };
    (1..=CRANK_ORDERS).map(order).collect()
}

/// Adds the bounds to the orders in a file.
pub(super) fn hidden(rows: Rows<'_, Order>, w0: f64) -> Rows<'_, Order> {
    rows.hidden("three_term", ONE, |o| o.bounds.three_term)
        .hidden("second_order", ONE, |o| o.bounds.second_order)
        .hidden("printed", ONE, |o| o.bounds.printed)
        .hidden("determinant", ONE, |o| o.bounds.determinant)
        .hidden("without_mean", ONE, |o| o.bounds.without_mean)
        .hidden("approximate", RPM, move |o| o.approximate.map(|ends| ends.map(|eta| eta * w0)))
}

/// Compares the printed formulas with the exact values, and names their misprints and their effect in this scene.
pub(super) fn explain(findings: &StabilityAnalysis, report: &mut Report) {
    if findings.orders.is_empty() {
        return;
    }
    let w0 = findings.oscillator.natural_frequency;
    let speeds = move |ends: Option<[f64; 2]>| ends.map(|ends| ends.map(|eta| eta * w0));
    let bound = |value: f64| if value < NEGLIGIBLE { 0.0 } else { value };
    report.explain_table(
        Table::of("Critical damping ratio and borders by printed formulas", findings.listed(true))
            .column("order", "order", ONE, |o| o.j)
            .column("", "exact", ONE, |o| o.critical_damping.unwrap_or(f64::INFINITY))
            .column("", "three terms", ONE, move |o| bound(o.bounds.three_term))
            .column("", "second order", ONE, move |o| bound(o.bounds.second_order))
            .column("", "(14), (16) as printed", ONE, move |o| bound(o.bounds.printed))
            .column("", "(9), (10)", ONE, move |o| bound(o.bounds.determinant))
            .column("", "unstable at this damping", RPM, move |o| speeds(o.damped))
            .column("", "by (9), (13)", RPM, move |o| speeds(o.approximate)),
    );
    let misprints = "Dresig, Vulfson, Dynamik der Mechanismen, 4.5.2, is printed wrong: (15), (16) add moduli where the modulus of \
                     a complex sum belongs; (9) has lost the entry k_j of its first row, (12) the factor Ω of b₂ⱼ, both \
                     corrected here. Second order: Yakubovich, Starzhinskii. None of them decides anything.";
    let crank = "Section 4.5.3 takes the second term of order 3 as zero since r₃ = 0, and Ω ≈ ω₀/3 as safe; but r₂ r₄ and r₂³ \
                 outweigh r₆, so formula and borders miss this order.";
    let of_crank = findings.crank.as_ref().map(|_| crank);
    report.explain("Printed formulas", [misprints].into_iter().chain(of_crank).map(str::to_owned));
}
