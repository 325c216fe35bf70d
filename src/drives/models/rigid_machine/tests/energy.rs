//! The balance of energy: ½ J φ̇² changes by ∫ (M_an − τ) φ̇ dtat the communication points. While the torques do not depend on
//! time, the steps in the angle and those of fixed cost are the same for every communication step.

use super::*;
use crate::numerics::gauss::Gauss;

/// Error of E against the work of the torques over 0.4 s, as part of the energy that motor, load and machine exchange.
fn missed(scene: Scene, solver: Settings) -> f64 {
    let mut machine = started(Scene { solver, ..scene });
    machine.shaft.loads.signal_mut(0).unwrap().set(20.0);
    let before = get(&machine, "E");
    let (mut work, mut exchanged) = (0.0, before);
    for panel in 0..200 {
        let (start, length) = (f64::from(panel) * 2e-3, 2e-3);
        let [part, size] = Gauss::with(8).integrate(length, |s| {
            let mut there = machine.clone();
            there.advance(start, s).unwrap();
            let [driving, w] = ["M_an", "w"].map(|name| get(&there, name));
            [(driving - 20.0) * w, (driving.abs() + 20.0) * w.abs()]
        });
        machine.advance(start, length).unwrap();
        (work, exchanged) = (work + part, exchanged + size);
    }
    (get(&machine, "E") - before - work).abs() / exchanged
}

#[test]
fn the_balance_closes_as_well_as_the_tolerance_asks() {
    let missing = [1e-4, 1e-7, 1e-10].map(|tolerance| {
        let missing = missed(loom(kloss(0.16), 0.3, 10.0), Settings { tolerance, ..Settings::default() });
        assert!(missing <= 3.0 * tolerance, "{tolerance:e}: {missing:e}");
        missing
    });
    assert!(missing[0] > 1e-10 && missing[2] < 1e-3 * missing[0], "{missing:?}");
}

#[test]
fn steps_that_are_too_coarse_miss_the_balance() {
    for motor in [kloss(0.16), lagging()] {
        let [fine, coarse] = [0.002, 0.015].map(|step_size| {
            let solver = Settings { method: Method::FixedCost, step_size, ..Settings::default() };
            missed(loom(motor, 0.3, 10.0), solver)
        });
        assert!(fine < 1e-14 && coarse > 100.0 * fine, "{fine:e} {coarse:e}");
    }
}
