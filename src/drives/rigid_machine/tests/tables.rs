//! Machines that bring their tables along.

use super::*;
use crate::drives::rigid_machine::linkage::{Branch, FourBar, Kind, Link, Linkage, Mechanism};

fn both(scene: &Scene) -> [RigidMachine; 2] {
    let computed = RigidMachine::new(scene.clone()).unwrap();
    let tables = computed.tables().unwrap();
    [computed, RigidMachine::with_tables(scene.clone(), &tables).unwrap()]
}

/// A follower behind a four-bar linkage.
fn linked() -> Scene {
    let bar = |length, mass| Link { length, mass, inertia: 0.01, centre: [0.5 * length, 0.01] };
    let four_bar = FourBar {
        ground: 0.3,
        input: bar(0.1, 0.8),
        coupler: bar(0.29, 1.1),
        output: bar(0.14, 0.0),
        branch: Branch::Plus,
    };
    let behind = Mechanism { kind: Kind::FourBar(four_bar), input_offset: 1.7, output_offset: 1.7 };
    let mut scene = loom(kloss(0.16), 0.0, SYNCHRONOUS);
    scene.followers[1].m = 3.0;
    scene.followers[1].linkage = Linkage(vec![behind]);
    scene
}

#[test]
fn tables_change_nothing_but_the_work() {
    let steady = |scene| Scene { start: MachineStart::SteadyState, ..scene };
    for scene in
        [steady(loom(kloss(0.16), 0.4, 0.0)), steady(linked()), cycles(lagging(), 5.0), cycles(kloss(0.3), 5.0)]
    {
        let mut machines = both(&scene);
        for machine in &mut machines {
            machine.start(0.0).unwrap();
        }
        assert_eq!(machines[0].inertia.range(), machines[1].inertia.range());
        assert_eq!(machines[0].inertia.resolution(), machines[1].inertia.resolution());
        for i in 0..40 {
            for machine in &mut machines {
                machine.advance(0.01 * f64::from(i), 0.01).unwrap();
            }
            for name in ["phi", "w", "a", "J", "M_an", "E"] {
                let [computed, read] = [&machines[0], &machines[1]].map(|machine| get(machine, name));
                assert!((computed - read).abs() <= 1e-12 * computed.abs().max(1e-3), "{name} {computed} {read}");
            }
        }
        // What a table does not hold for is computed: both then have the same one.
        for machine in &mut machines {
            set(machine, "J0", 1.7);
            set(machine, "motor.w_s", -30.0);
            machine.start(0.0).unwrap();
            machine.advance(0.0, 0.3).unwrap();
        }
        let [computed, read] = [&machines[0], &machines[1]].map(|machine| get(machine, "phi"));
        assert!((computed - read).abs() <= 1e-12 * computed.abs(), "{computed} {read}");
    }
}

#[test]
fn the_search_begins_next_to_its_end() {
    let scene = Scene { start: MachineStart::SteadyState, ..loom(kloss(0.16), 0.0, 0.0) };
    let [computed, read] = both(&scene);
    assert_eq!(computed.first_guess, 1.0);
    let torques = Torques::against(&read.motor, 0.0, 1.0);
    let shooting = steady::Shooting::new(&read, torques, steady::ORBIT_TOLERANCE, None).unwrap();
    let energy = shooting.first_energy().unwrap();
    let shot = shooting.shoot(energy).unwrap();
    // The guess has the digits of an f32: one secant leaves roundings.
    assert!(shot.gain.abs() <= f64::from(f32::EPSILON) * energy, "{:e}", shot.gain / energy);
}

#[test]
fn tables_of_another_scene_and_damaged_ones_are_refused() {
    let tables = both(&cycles(kloss(0.16), 5.0))[0].tables().unwrap();
    let own = || loom(kloss(0.16), 0.0, 5.0);
    assert!(RigidMachine::with_tables(own(), &tables).err().unwrap().0.contains("not those of its scene"));
    let own_tables = both(&own())[0].tables().unwrap();
    assert!(RigidMachine::with_tables(own(), &own_tables[..own_tables.len() - 1]).is_err());
    assert!(RigidMachine::with_tables(own(), &[]).is_err());
}
