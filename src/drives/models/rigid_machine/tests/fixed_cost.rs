//! The method `fixed_cost`: bounded work, an honest error estimate, the same numbers for any communication step.

use super::estimate::{Random, Tally, errors, random_machine};
use super::*;
use crate::drives::solver::free_shaft::grid::MOST_CUTS;

fn fixed_cost(step_size: f64) -> Settings {
    Settings { method: Method::FixedCost, step_size, ..Settings::default() }
}

#[test]
fn the_estimate_is_honest_at_fixed_cost() {
    let mut r = Random(5);
    let (mut tally, mut faults) = (Tally::default(), 0);
    let mut usual = Vec::new();
    for kind in 0..144 {
        let (mut scene, load, driving, duration) = random_machine(&mut r, kind);
        // Half of the machines with the usual step, half with a step between a third and five times as long.
        let own = kind % 16 < 8;
        scene.solver = fixed_cost(0.0);
        let asked = started(scene.clone()).in_time.grid.size * r.order(0.3, 5.0);
        if !own {
            scene.solver = fixed_cost(asked);
        }
        let Some(found) = errors(scene, load, driving, duration) else {
            println!("fault: kind {}, own step {own}", kind % 8);
            faults += 1;
            continue;
        };
        tally.add(kind, found);
        if own {
            usual.push(found[0]);
        }
    }
    usual.sort_by(f64::total_cmp);
    let at = |part: f64| usual[(part * usual.len() as f64) as usize];
    println!("usual step: errors {:e} {:e} {:e} {:e}", at(0.1), at(0.5), at(0.9), at(0.99));
    // Machines without a motor may be driven to many times their first speed, for which the usual step is too long.
    assert!(tally.machines >= 126, "{} machines, {faults} faults", tally.machines);
    tally.assert_honest();
    assert!(at(0.5) < 1e-12 && at(0.9) < 1e-6, "{:e} {:e}", at(0.5), at(0.9));
}

/// A load that changes during every step, if requested, and the evaluations of each step.
fn works(mut machine: RigidMachine, varying: bool) -> Vec<[f64; 2]> {
    let (mut time, mut r, mut works) = (0.0, Random(3), Vec::new());
    for _ in 0..300 {
        let h = r.order(1e-6, 0.05);
        if varying {
            machine.shaft.loads.signal_mut(0).unwrap().set(20.0 * f64::sin(50.0 * time));
            machine.shaft.loads.signal_mut(0).unwrap().set_derivative(1, 1000.0 * f64::cos(50.0 * time));
        }
        let before = machine.solver.evaluations;
        machine.advance(time, h).unwrap();
        time += h;
        works.push([h, machine.solver.evaluations - before]);
    }
    works
}

#[test]
fn the_work_of_a_communication_step_is_bounded() {
    // A solution takes 8 evaluations to begin with and 8 per iteration; a border costs two.
    let solution = 8.0 * (1.0 + 4.0);
    let smooth = loom(kloss(0.16), 0.3, 0.0);
    let lag = loom(lagging(), 0.3, 10.0);
    let bordered = cycles(kloss(0.16), 10.0);
    for (scene, per_step) in [(smooth, 1.0), (lag, 1.0), (bordered, 1.0 + 2.0 * MOST_CUTS as f64)] {
        for (step_size, varying) in [(1e-4, false), (1e-3, false), (1e-3, true)] {
            let machine = started(Scene { solver: fixed_cost(step_size), ..scene.clone() });
            for [h, work] in works(machine, varying) {
                let bound = ((h / step_size).ceil() + 1.0) * per_step * solution;
                assert!(work <= bound, "{work} evaluations over {h} s, bound {bound}");
            }
        }
    }
}

#[test]
fn the_answer_does_not_depend_on_the_communication_step() {
    let turns_back = loom(kloss(0.16), 0.3, 10.0);
    for (scene, load) in [
        (loom(kloss(0.16), 0.3, 0.0), 0.0),
        (loom(lagging(), 0.3, 10.0), 20.0),
        (turns_back, 300.0),
        (cycles(kloss(0.16), 10.0), 5.0),
    ] {
        // Powers of two, so that the last point is the same to the last bit.
        let ends = [1, 8, 1024].map(|steps| {
            let mut machine = started(Scene { solver: fixed_cost(0.0), ..scene.clone() });
            machine.shaft.loads.signal_mut(0).unwrap().set(load);
            run(&mut machine, 0.75, steps);
            let events: Vec<_> = machine.events().iter().map(|event| event.time).collect();
            let state = ["phi", "w", "a", "M_an"].map(|name| get(&machine, name));
            (state, events, machine.solver.error_estimate, machine.solver.steps)
        });
        assert!(ends[0] == ends[1] && ends[0] == ends[2], "{ends:?}");
        assert_eq!(ends[0].1.len(), usize::from(load == 300.0));
        // The adaptive method is more accurate.
        let mut machine = started(scene);
        machine.shaft.loads.signal_mut(0).unwrap().set(load);
        run(&mut machine, 0.75, 1);
        for (value, name) in ends[0].0.into_iter().zip(["phi", "w"]) {
            let error = (value / get(&machine, name) - 1.0).abs();
            assert!(error < 1e-7 && error < 3.0 * ends[0].2 + 1e-9, "{name}: {error:e}, {:e}", ends[0].2);
        }
    }
}

#[test]
fn a_load_that_jumps_is_met_at_the_communication_point() {
    let mut ends = [Settings::default(), fixed_cost(0.0)].map(|solver| {
        let mut machine = started(Scene { solver, ..loom(kloss(0.16), 0.3, 40.0) });
        for i in 0..100 {
            machine.shaft.loads.signal_mut(0).unwrap().set(if i % 2 == 0 { 50.0 } else { -30.0 });
            machine.advance(f64::from(i) * 0.0037, 0.0037).unwrap();
        }
        machine
    });
    for name in ["phi", "w", "E"] {
        let [adaptive, fixed] = &mut ends;
        assert_near(get(fixed, name), get(adaptive, name), 1e-8, name);
    }
}

#[test]
fn steps_that_are_too_long_are_refused() {
    for (scene, step_size) in [
        (loom(kloss(0.16), 0.3, 40.0), 0.05),
        (loom(lagging(), 0.3, 0.0), 0.5),
        (cycles(kloss(0.16), 40.0), 0.3),
        (cycles(kloss(0.16), 40.0), 1e-9),
    ] {
        let mut machine = started(Scene { solver: fixed_cost(step_size), ..scene });
        let fault = (0..20).find_map(|n| machine.advance(f64::from(n), 1.0).err()).unwrap();
        assert!(fault.to_string().contains("solver.step_size"), "{fault}");
        assert!(machine.is_finite());
    }
}

#[test]
fn a_restored_machine_goes_on_bit_by_bit_at_fixed_cost() {
    let mut machine = started(Scene { solver: fixed_cost(0.0), ..cycles(kloss(0.16), 10.0) });
    run(&mut machine, 0.3217, 17);
    let bytes = postcard::to_allocvec(&machine).unwrap();
    let mut copy: RigidMachine = postcard::from_bytes(&bytes).unwrap();
    copy.restored(&started(Scene { solver: fixed_cost(0.0), ..cycles(kloss(0.16), 20.0) })).unwrap();
    for n in 0..50 {
        let time = 0.3217 + f64::from(n) * 0.0113;
        for m in [&mut machine, &mut copy] {
            m.advance(time, 0.0113).unwrap();
        }
        assert_eq!(["phi", "w", "a"].map(|name| get(&machine, name)), ["phi", "w", "a"].map(|name| get(&copy, name)));
    }
}
