//! Coefficients that nearly vanish, and what the report says of orders and speeds.

use super::{crank, critical, mathieu, oscillator, series};
use crate::oscillator::{PeriodicOscillator, Terms};
use crate::report::Level;
use crate::stability::system::System;
use crate::stability::{Options, modulation, study};
use crate::work;
use std::f64::consts::{PI, TAU};

/// m = 1 + μ cos φ, whose zero is near: the cells have to become short towards it.
fn inertia(mu: f64) -> PeriodicOscillator {
    let m = series(&[mu], &[]);
    let terms = move |_: usize, phi: f64| Terms { m: m.at(phi).0[0], b: 0.04, c: 1.0, ..Terms::default() };
    oscillator(Box::new(terms), 0.5 * (2.0 * (1.0 - mu)).sqrt(), false)
}

/// The same as [`crank`], with cells that shorten towards the dead centres only.
fn stiff_crank(sigma: f64) -> PeriodicOscillator {
    let away: Vec<f64> = (0..).map(|k| sigma.sqrt() * 2f64.powi(k)).take_while(|x| *x < 1.0).collect();
    let mut ends: Vec<f64> =
        [0.0, PI, TAU].iter().flat_map(|c| away.iter().flat_map(move |x| [c - x, c + x])).collect();
    ends.retain(|end| (0.0..TAU).contains(end));
    ends.sort_by(f64::total_cmp);
    let lengths: Vec<f64> = ends.windows(2).map(|pair| 0.5 * (pair[1] - pair[0])).chain([sigma.sqrt()]).collect();
    let scene = crank(sigma, false);
    PeriodicOscillator { breakpoints: ends, reach: Box::new(move |segment| lengths[segment]), ..scene }
}

#[test]
fn a_coupling_rod_that_is_all_but_rigid_has_its_narrow_tongues() {
    // σ → 0 leaves a notch of the width √σ, of which the second order is right to O(√σ).
    for sigma in [5e-6, 1e-6, 1e-8] {
        let scene = stiff_crank(sigma);
        let bounds = System::new(&scene).unwrap().printed();
        for (n, theta) in (1..).zip(critical(&scene, 4)) {
            let second = bounds.bounds(2 * n).second_order;
            assert!((theta / second - 1.0).abs() < 5.0 * sigma.sqrt() * n as f64, "{sigma}, {n}: {theta:e} {second:e}");
            assert!((theta / (0.5 * sigma.sqrt()) - 1.0).abs() < 5.0 * sigma.sqrt() * n as f64);
        }
    }
}

#[test]
fn an_inertia_that_nearly_vanishes_has_its_first_orders() {
    // By an explicit Runge-Kutta method of order 8 at 1e-12: boundaries in η and θ* of the orders 1/2 and 3/2.
    let expected = [
        (1, [2.259_085_762_4, 14.368_307_622_1], 0.239_581_062_7),
        (3, [1.384_272_270_5, 1.448_024_551_8], 2.691_305_150e-3),
    ];
    let scene = inertia(0.999);
    let report = study(["m", "test"], &scene, &Options { quick: true, ..Options::default() }, &|_| ()).unwrap();
    for (n, ends, theta) in expected {
        let order = &report.orders[n - 1];
        let near = |value: f64, expected: f64| (value / expected - 1.0).abs() < 1e-8;
        assert!(near(order.undamped[0], ends[0]) && near(order.undamped[1], ends[1]), "{order:?}");
        assert!(near(order.critical_damping.unwrap(), theta), "{order:?}");
    }
    // The others would need more harmonics than are taken, and are told.
    assert!(!report.eigenproblem.incomplete && report.eigenproblem.lost == Some(2.0));
    assert!(report.verdict().certainty.iter().any(|line| line.contains("Orders from 2 on are left out")));
    let report = study(["m", "test"], &inertia(0.99), &Options { quick: true, ..Options::default() }, &|_| ()).unwrap();
    assert!(report.eigenproblem.lost.is_none() && report.orders.len() == 8);
    // Stable without damping, unstable by damping that differs over the turn: ρ = 1.0516757976 at θ = 0.1.
    let options = Options { quick: true, damping: Some(0.1), speeds: vec![21.1 / 60.0 * TAU], ..Options::default() };
    let report = study(["m", "test"], &scene, &options, &|_| ()).unwrap();
    let at = &report.speeds[0];
    assert!((at.radius / 1.051_675_797_6 - 1.0).abs() < 1e-8 && at.order == Some(0.5), "{at:?}");
    assert!((0.11..0.13).contains(&at.critical_damping), "{at:?}");
}

#[test]
fn orders_whose_boundaries_are_not_found_are_told() {
    let scene = mathieu(0.3);
    let options = Options { quick: true, ..Options::default() };
    let mut report = study(["mathieu", "test"], &scene, &options, &|_| ()).unwrap();
    assert!(!report.verdict().certainty.iter().any(|line| line.contains("left out")));
    report.eigenproblem.lost = Some(4.5);
    // No order is unstable: that says nothing of those that were not found.
    report.orders.iter_mut().for_each(|order| order.damped = None);
    let verdict = report.verdict();
    let claim = verdict.result.iter().find(|line| line.contains("are stable at every speed")).unwrap();
    assert!(claim.starts_with("Orders up to 4 ") && verdict.level == Level::Mind, "{verdict:?}");
    report.orders.clear();
    assert!(report.verdict().result.iter().any(|line| line.starts_with("No order below 4.5 is judged")));
    assert!(report.verdict().certainty.iter().any(|line| line.contains("Orders from 4.5 on are left out")));
}

#[test]
fn a_study_that_takes_too_much_work_ends_and_says_so() {
    let scene = mathieu(0.3);
    let studied = |budget: f64| {
        work::within(budget, "do less", &|_| (), |tell| study(["m", "test"], &scene, &Options::default(), tell).is_ok())
    };
    assert_eq!(studied(work::BUDGET), Ok(true));
    let message = studied(1e6).unwrap_err().to_string();
    assert!(message.contains("1.0e6 operations") && message.contains("reached: orders, "), "{message}");
}

#[test]
fn every_order_that_is_listed_is_in_the_map_over_the_modulation() {
    let scene = crank(0.2, false);
    let options = Options { damping: Some(0.03), orders: Some(11), ..Options::default() };
    let report = study(["crank", "test"], &scene, &options, &|_| ()).unwrap();
    let drawn = |j: f64, theta: f64| {
        report.over_modulation.iter().any(|r| r.j == j && r.theta == Some(theta) && r.lines.len() > 8)
    };
    for order in &report.orders {
        assert!(drawn(order.j, 0.0), "{}", order.j);
        let below = order.modulation_ratio.is_some_and(|ratio| ratio * report.ranges[2][1] > 1.1);
        assert!(!below || drawn(order.j, 0.03), "{order:?}");
    }
    assert_eq!(report.orders.len(), 11);
    // The lines of the map at the modulation of the scene are the boundaries of the list.
    for region in &report.over_modulation {
        let order = report.orders.iter().find(|order| order.j == region.j).unwrap();
        let ends = if region.theta == Some(0.0) { Some(order.undamped) } else { order.damped };
        let row = region.lines.iter().position(|line| line[0] >= 1.0).unwrap_or(0);
        if let (Some(ends), [.., before, after]) = (ends, &region.lines[..=row]) {
            for k in 0..2 {
                let (low, high) = (before[k + 1].min(after[k + 1]), before[k + 1].max(after[k + 1]));
                assert!((low * 0.999..high * 1.001).contains(&ends[k]), "{}: {ends:?} {before:?} {after:?}", region.j);
            }
        }
    }
}

#[test]
fn the_modulation_at_which_an_order_becomes_unstable_is_told_without_maps_too() {
    let scene = mathieu(0.3);
    let system = System::new(&scene).unwrap();
    let options = Options { quick: true, damping: Some(0.09), orders: Some(12), ..Options::default() };
    let report = study(["mathieu", "test"], &scene, &options, &|_| ()).unwrap();
    assert!(report.over_modulation.is_empty());
    let critical = 1.0 / report.orders[0].modulation_ratio.unwrap();
    assert!(critical > 1.1, "stable");
    let apex = |n: usize, modulation: f64| {
        let system = system.modulated(modulation);
        modulation::tongue(&system, n).unwrap().apex(&system).unwrap().theta
    };
    assert!((apex(1, critical) - 0.09).abs() < 1e-9);
    // Beyond the eighth order as well.
    let options = Options { damping: Some(1e-7), ..options };
    let report = study(["mathieu", "test"], &scene, &options, &|_| ()).unwrap();
    let ratio = report.orders[8].modulation_ratio.unwrap();
    assert!((apex(9, 1.0 / ratio) - 1e-7).abs() < 1e-12);
}

#[test]
fn a_stable_speed_is_not_called_unstable() {
    let scene = mathieu(0.3);
    let options = Options { quick: true, damping: Some(5.0), speeds: vec![2.0], ..Options::default() };
    let report = study(["mathieu", "test"], &scene, &options, &|_| ()).unwrap();
    let verdict = report.verdict();
    assert_eq!(verdict.level, Level::Good);
    assert!(verdict.result[0].contains("machine may run"), "{verdict:?}");
    // 0.07491, rounded up.
    assert!(verdict.certainty.iter().any(|line| line.contains("damping ratio below 0.075 ")), "{verdict:?}");
}

#[test]
fn what_cannot_be_followed_is_told_with_its_reason() {
    let scene = mathieu(0.3);
    let at = |speed: f64, damping: f64| {
        let options = Options { quick: true, speeds: vec![speed], damping: Some(damping), ..Options::default() };
        study(["mathieu", "test"], &scene, &options, &|_| ())
    };
    // Vibrations are followed by their phase, however many; what does not vibrate is not.
    let report = at(1e-9, 0.1).unwrap();
    assert!(report.speeds[0].stable && report.speeds[0].radius == 0.0);
    let text = at(1e-9, 5.0).unwrap_err().to_string();
    assert!(text.contains("η = 1e-9") && text.contains("decay about 1e9 times"), "{text}");
}
