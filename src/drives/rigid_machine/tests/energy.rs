//! The balance of energy, over random machines: with every kind of motor, law and load.

use super::estimate::{Random, random_machine, set_torques};
use super::*;

type Machine = (Scene, [f64; 3], [f64; 3], f64);

fn by(tolerance: f64) -> Settings {
    Settings { tolerance, ..Settings::default() }
}

fn fixed_cost(step_size: f64) -> Settings {
    Settings { method: Method::FixedCost, step_size, ..Settings::default() }
}

/// Runs of some communication steps on varying torques; the residual and the error estimate, None where it ends in a fault.
fn residual((scene, load, driving, duration): &Machine, solver: Settings) -> Option<[f64; 2]> {
    let mut machine = RigidMachine::new(Scene { solver, ..scene.clone() }).ok()?;
    machine.load.set(load[0]);
    machine.driving.set(driving[0]);
    machine.start(0.0).ok()?;
    for i in 0..20 {
        let (t, h) = (duration * f64::from(i) / 20.0, duration / 20.0);
        set_torques(&mut machine, *load, *driving, t);
        machine.advance(t, h).ok()?;
    }
    Some(["solver.energy_residual", "solver.error_estimate"].map(|name| get(&machine, name)))
}

/// Machines whose laws are series and others with laws of every kind.
fn machines() -> impl Iterator<Item = Machine> {
    let mut r = Random(77);
    (0..48).map(move |n| match n % 2 {
        0 => random_machine(&mut r, n / 2),
        _ => wide_estimate::random_machine(&mut r, n / 2),
    })
}

#[test]
fn the_balance_closes_as_well_as_the_tolerance_asks() {
    let (mut known, mut falls) = (0, 0);
    for machine in machines() {
        let tolerances = [1e-4, 1e-7, 1e-10];
        let residuals = tolerances.map(|tolerance| residual(&machine, by(tolerance)));
        let [Some([coarse, _]), Some(_), Some([fine, _])] = residuals else { continue };
        for (tolerance, [residual, estimate]) in tolerances.into_iter().zip(residuals.into_iter().flatten()) {
            // Steps at the tolerance add up in a motor that is nearly synchronous.
            assert!(residual <= 30.0 * tolerance && residual <= estimate, "{tolerance:e}: {residual:e}, {estimate:e}");
        }
        known += 1;
        // Without a motor the solver is exact.
        falls += i32::from(coarse > 1e-10 && fine < 1e-3 * coarse);
        assert!(coarse < 1e-10 || fine < 1e-3 * coarse, "{coarse:e} {fine:e}");
    }
    assert!(known >= 46 && falls >= 24, "{known} {falls}");
}

#[test]
fn steps_that_are_too_coarse_miss_the_balance() {
    let mut large = 0;
    for machine in machines() {
        let scene = Scene { solver: fixed_cost(0.0), ..machine.0.clone() };
        let usual = RigidMachine::new(scene).and_then(|mut machine| machine.start(0.0).map(|()| machine.grid.size));
        let Ok(usual) = usual else { continue };
        let [fine, coarse] = [0.5, 4.0].map(|factor| residual(&machine, fixed_cost(factor * usual)));
        if let (Some([fine, _]), Some([coarse, _])) = (fine, coarse) {
            large += i32::from(coarse > 1e-5 && coarse > 1e3 * fine);
        }
    }
    assert!(large >= 5, "{large}");
}

#[test]
fn the_balance_is_that_of_the_outputs() {
    // On a grid of coarse steps the answer does not depend on the communication step, by which the work is summed here.
    let mut largest_told = 0.0_f64;
    for (scene, step_size) in [(loom(lagging(), 0.3, 10.0), 0.015), (loom(kloss(0.16), 0.3, 10.0), 0.015)] {
        let mut machine = started(Scene { solver: fixed_cost(step_size), ..scene });
        let (steps, h) = (2000, 1e-4);
        let power = |machine: &RigidMachine| get(machine, "M_an") * get(machine, "w");
        let (before, mut work, mut largest) = (get(&machine, "E"), 0.0, 0.0_f64);
        let mut last = power(&machine);
        for i in 0..steps {
            machine.advance(f64::from(2 * i) * h, h).unwrap();
            let middle = power(&machine);
            machine.advance(f64::from(2 * i + 1) * h, h).unwrap();
            let end = power(&machine);
            work += h / 3.0 * (last + 4.0 * middle + end);
            last = end;
            largest = largest.max(get(&machine, "E"));
        }
        let missing = (get(&machine, "E") - before - work).abs() / largest;
        let told = get(&machine, "solver.energy_residual");
        // Simpson's rule itself errs by some 1e-13.
        assert!((told - missing).abs() < 0.05 * told + 1e-12, "{told:e} {missing:e}");
        largest_told = largest_told.max(told);
    }
    assert!(largest_told > 1e-11, "{largest_told:e}");
}

#[test]
fn a_restored_machine_goes_on_with_its_balance() {
    let mut machine = started(Scene { solver: by(1e-6), ..loom(kloss(0.16), 0.3, 10.0) });
    run(&mut machine, 0.4, 40);
    let told = get(&machine, "solver.energy_residual");
    assert!(told > 0.0);
    let mut again: RigidMachine = postcard::from_bytes(&postcard::to_stdvec(&machine).unwrap()).unwrap();
    again.restored(&machine);
    assert_eq!(get(&again, "solver.energy_residual"), told);
}
