//! The table of the periodic motion.

use super::*;

/// The same machine without the table.
fn without_table(scene: Scene) -> RigidMachine {
    let mut machine = started(scene);
    assert!(machine.in_angle.cycle.is_some());
    machine.in_angle.cycle = None;
    machine
}

#[test]
fn a_machine_that_reads_the_table_moves_as_one_that_solves() {
    let backwards = Motor::Kloss(Kloss {
        breakdown_torque: 220.0,
        breakdown_slip: 0.16,
        synchronous_speed: -SYNCHRONOUS,
        dynamics: None,
    });
    let scenes = [
        loom(kloss(0.16), 0.0, 0.7 * SYNCHRONOUS),
        loom(kloss(0.02), 1.3, SYNCHRONOUS),
        loom(backwards, -2.0, -1.2 * SYNCHRONOUS),
        cycles(kloss(0.16), 0.7 * SYNCHRONOUS),
        cycles(backwards, -0.9 * SYNCHRONOUS),
    ];
    for (number, scene) in scenes.into_iter().enumerate() {
        for tolerance in [0.0, 1e-6, 1e-13] {
            let solver = Settings { tolerance, ..Settings::default() };
            let scene = Scene { solver, ..scene.clone() };
            let (mut reads, mut solves) = (started(scene.clone()), without_table(scene));
            let list = reads.variables();
            let compared = ["phi", "w", "E"].map(|name| (name, &list.0[list.reference(name).unwrap()]));
            for i in 0..1000 {
                let h = 9e-3;
                reads.advance(f64::from(i) * h, h).unwrap();
                solves.advance(f64::from(i) * h, h).unwrap();
                let bound = 2.0 * reads.solver.error_estimate.max(solves.solver.error_estimate);
                for (name, variable) in compared {
                    let (one, other) = (variable.value(&reads), variable.value(&solves));
                    // The passed angle counts, at least half a radian per step.
                    let part = if name == "phi" { reads.state.travelled.max(1.0) / other.abs() } else { 1.0 };
                    assert_near(one, other, 2.0 * bound * part.max(1.0), &format!("{number} {tolerance} {name} {i}"));
                }
            }
            // Most turns repeat earlier ones.
            let [few, many] = [&reads, &solves].map(|machine| machine.solver.evaluations);
            assert!(2.0 * few < many, "{number} {tolerance}: {few} {many}");
            assert!(reads.solver.steps <= 1.1 * solves.solver.steps);
        }
    }
}

#[test]
fn another_load_has_no_table_and_a_load_at_the_start_its_own() {
    let mut machine = started(loom(kloss(0.16), 0.0, SYNCHRONOUS));
    run(&mut machine, 1.0, 100);
    let before = machine.solver.evaluations;
    run(&mut machine, 1.0, 100);
    assert_eq!(machine.solver.evaluations, before);
    set(&mut machine, "tau", 20.0);
    machine.apply(1.0).unwrap();
    run(&mut machine, 1.0, 100);
    assert!(machine.solver.evaluations > before + 1000.0);

    let mut loaded = RigidMachine::new(loom(kloss(0.16), 0.0, SYNCHRONOUS)).unwrap();
    set(&mut loaded, "tau", 20.0);
    loaded.start(0.0).unwrap();
    run(&mut loaded, 1.0, 100);
    let before = loaded.solver.evaluations;
    run(&mut loaded, 1.0, 100);
    assert_eq!(loaded.solver.evaluations, before);
    // A restored machine makes the same table.
    let bytes = postcard::to_stdvec(&loaded).unwrap();
    let mut restored: RigidMachine = postcard::from_bytes(&bytes).unwrap();
    restored.restored(&loaded).unwrap();
    run(&mut loaded, 1.0, 77);
    run(&mut restored, 1.0, 77);
    assert_eq!(restored.state, loaded.state);
    // Without a balance of the torques there is no periodic motion.
    set(&mut loaded, "tau", 300.0);
    loaded.start(0.0).unwrap();
    assert!(loaded.in_angle.cycle.is_none());
}
