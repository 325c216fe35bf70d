//! Trains with parts much faster than the motion, which go by collocation.

use super::super::*;
use super::reference::{backlash, hs, kloss, machine, output, scene, series, shaft};
use crate::drives::models::elastic_shaft::{self, ElasticShaft};
use crate::drives::shaft::cam_drive::{Start as CamStart, StartMode};

/// Counted from here no step is one of those that try the collocation.
const UNTRIED: f64 = 1e17;

/// The states, and all sums of the followers, after each of so many communication steps up to `end`.
fn states(train: &mut DriveTrain, end: f64, steps: usize) -> Vec<[f64; MOST_STATES]> {
    let at = |i: usize| end * i as f64 / steps as f64;
    let read = |train: &DriveTrain| {
        let mut y = [0.0; MOST_STATES];
        train.run.at(train.time, &mut y);
        y[0] += train.run.turns * TAU;
        y
    };
    let step = |i| {
        train.go_on(at(i), at(i + 1) - at(i)).unwrap();
        read(train)
    };
    (0..steps).map(step).collect()
}

fn started(scene: &Scene, tolerance: f64) -> DriveTrain {
    let mut scene = scene.clone();
    scene.solver.tolerance = tolerance;
    let mut train = DriveTrain::of(scene);
    train.log.keep(true);
    train.begin(0.0).unwrap();
    train
}

/// The same by series alone.
fn by_series(scene: &Scene, tolerance: f64) -> DriveTrain {
    let mut train = started(scene, tolerance);
    train.run = Run::default();
    let (y, _) = train.first_states();
    train.run =
        Run::begin(&train.train, Double::default(), &y[..train.train.layout.count], Modes::default(), tolerance);
    train.run.steps = UNTRIED;
    let outside = Outside { time: 0.0, motion: train.motion.as_ref(), inputs: &train.inputs };
    train.run.choose_modes(&train.train, &outside, false, &mut train.log).unwrap();
    train.run.first(&train.train, &outside, f64::INFINITY).unwrap();
    train
}

/// The largest difference of the states, each over its largest size; of the angle of a free shaft in radians.
fn difference(one: &[[f64; MOST_STATES]], other: &[[f64; MOST_STATES]]) -> f64 {
    let size = |k: usize| one.iter().fold(f64::MIN_POSITIVE, |most, y| most.max(y[k].abs()));
    let of = |k: usize| one.iter().zip(other).fold(0.0_f64, |most, (a, b)| most.max((a[k] - b[k]).abs())) / size(k);
    (0..MOST_STATES).map(of).fold(0.0, f64::max)
}

fn driven(w: f64) -> Shaft {
    Shaft::Driven(DriveMode::Constant { w, phi_start: 0.0 })
}

/// The follower of 20 kg on a shaft of 2e9 N·m/rad, with this damping (N·m·s/rad).
fn on_stiff_shaft(b: f64) -> Scene {
    scene(driven(18.0), vec![shaft(hs(0.1), [20.0, 0.05, 2e9, b])])
}

#[test]
fn a_stiff_shaft_takes_the_steps_of_its_motion() {
    for b in [600.0, 2e4] {
        let of = on_stiff_shaft(b);
        let (mut train, mut truth) = (started(&of, 0.0), by_series(&of, 1e-13));
        let (found, exact) = (states(&mut train, 0.1, 50), states(&mut truth, 0.1, 50));
        let error = difference(&exact, &found);
        assert!(error < 1e-9 && error < train.run.error + train.run.ahead, "{b}: {error:e}, {:e}", train.run.error);
        let mut single = ElasticShaft::new(elastic_shaft::Scene {
            load: Default::default(),
            parameters: elastic_shaft::Parameters { m: 20.0, inertia: 0.05, c: 2e9, b },
            linear: false,
            cam: hs(0.1),
            drive: DriveMode::Constant { w: 18.0, phi_start: 0.0 },
            start: CamStart { mode: StartMode::AtRest, q: 0.0, q_dot: 0.0 },
            solver: Settings::default(),
        })
        .unwrap();
        single.start(0.0).unwrap();
        single.advance(0.0, 0.1).unwrap();
        let last = found[found.len() - 1];
        let largest = found.iter().fold(0.0_f64, |most, y| most.max(y[0].abs()));
        assert!((single.state[0] - last[0]).abs() < 1e-9 * largest, "{b}: {} {}", single.state[0], last[0]);
        // What the start excites is resolved, and dies away.
        let first = train.run.steps;
        states_from(&mut train, 0.1, 1.1);
        assert!(train.run.steps - first < 400.0, "{b}: {}", train.run.steps - first);
    }
}

/// Goes on from one time to another.
fn states_from(train: &mut DriveTrain, from: f64, to: f64) {
    for i in 0..100 {
        let at = |i: usize| from + (to - from) * i as f64 / 100.0;
        train.go_on(at(i), at(i + 1) - at(i)).unwrap();
    }
}

#[test]
fn a_vibration_that_lasts_is_resolved_by_series() {
    let of = on_stiff_shaft(0.0);
    let (mut train, mut same) = (started(&of, 0.0), by_series(&of, 1e-10));
    let (found, exact) = (states(&mut train, 0.02, 10), states(&mut same, 0.02, 10));
    assert_eq!(found, exact);
}

#[test]
fn a_lag_costs_the_same_however_short() {
    let of = |lag: f64| {
        let motor = Shaft::Free(machine(0.5, [0.0, 0.5], kloss(60.0, 0.12, 62.8, Some(lag))));
        scene(motor, vec![super::reference::follower(hs(0.1), 30.0, Joint::Rigid)])
    };
    let mut before = [0.0; MOST_STATES];
    for lag in [1e-4, 1e-6, 1e-9] {
        let mut train = started(&of(lag), 0.0);
        let found = states(&mut train, 1.0, 100);
        assert!(train.run.steps < 600.0, "{lag}: {}", train.run.steps);
        if lag == 1e-4 {
            let error = difference(&states(&mut by_series(&of(lag), 1e-13), 1.0, 100), &found);
            assert!(error < 1e-9 && error < train.run.error + train.run.ahead, "{error:e}");
        }
        // The lag shifts the motion by about itself.
        let shift = (found[99][1] - before[1]).abs() / 60.0;
        assert!(before[1] == 0.0 || shift < 1e-3, "{lag}: {shift:e}");
        before = found[99];
    }
    let Shaft::Free(motor) = of(1.0).shaft else { unreachable!() };
    let rigid = machine(motor.inertia.constant, [0.0, 0.5], kloss(60.0, 0.12, 62.8, None));
    let none = scene(Shaft::Free(rigid), vec![super::reference::follower(hs(0.1), 30.0, Joint::Rigid)]);
    let last = states(&mut started(&none, 1e-12), 1.0, 100)[99];
    assert!((last[1] - before[1]).abs() < 1e-7 * last[1], "{} {}", last[1], before[1]);
}

/// Random numbers between 0 and 1.
fn random(seed: &mut u64) -> f64 {
    *seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
    (*seed >> 11) as f64 / (1u64 << 53) as f64
}

/// A train of up to three followers of every kind, most of them stiff.
fn random_train(seed: &mut u64) -> Scene {
    let mut power = |low: f64, high: f64| 10f64.powf(low + (high - low) * random(seed));
    let mut followers = Vec::new();
    for kind in 0..3 {
        let cam = series(&[0.0, 0.03 * power(-0.3, 0.3), 0.004 * power(-0.5, 0.2)], &[0.01 * power(-0.5, 0.3)]);
        let (m, rate, damping) = (power(-0.5, 0.5), power(3.0, 4.6), power(-1.3, 0.0));
        let (c, b) = (m * rate * rate, 2.0 * damping * m * rate);
        match (3.0 * power(-1.0, 0.3)) as usize + kind {
            0 => {}
            1 => followers.push(output(cam, [m, c, b], 0.3 * m)),
            2 => followers.push(shaft(cam, [20.0 * m, 0.05 * m, 0.05 * c, 0.05 * b])),
            _ => followers.push(backlash(cam, [0.5 * m, m, c, b, 1e-4 * power(0.0, 1.0), 0.0])),
        }
    }
    let motor = kloss(50.0, 0.15, 40.0, (power(-1.0, 1.0) > 1.0).then(|| power(-5.0, -2.0)));
    scene(Shaft::Free(machine(0.3, [power(-1.0, 0.5), 30.0], motor)), followers)
}

#[test]
fn stiff_trains_move_as_their_series_do() {
    let (mut seed, mut honest, mut stiff, mut count) = (5, 0, 0, 0);
    for case in 0..60 {
        let of = random_train(&mut seed);
        let (mut train, mut truth) = (started(&of, 0.0), by_series(&of, 1e-13));
        let (found, exact) = (states(&mut train, 0.06, 20), states(&mut truth, 0.06, 20));
        let (error, estimate) = (difference(&exact, &found), train.run.error + train.run.ahead);
        let impacts = |train: &DriveTrain| train.run.tallies.iter().map(|tally| tally.impacts).sum::<f64>();
        let same = impacts(&train) == impacts(&truth);
        count += 1;
        honest += usize::from(error <= estimate);
        stiff += usize::from(train.run.steps < 150.0);
        assert!(error < 1e-6 || !same, "case {case}: {error:e}, estimated {estimate:e}, {} steps", train.run.steps);
    }
    assert!(100 * honest >= 98 * count, "{honest} of {count}");
    assert!(stiff > count / 3, "{stiff} of {count}");
}

#[test]
fn a_stiff_train_does_not_depend_on_communication_points() {
    let of = on_stiff_shaft(2e4);
    let whole = states(&mut started(&of, 0.0), 0.3, 1)[0];
    for steps in [7, 1000] {
        let parts = states(&mut started(&of, 0.0), 0.3, steps);
        assert_eq!(parts[steps - 1], whole, "{steps}");
    }
}

#[test]
fn a_stiff_train_is_restored_bit_by_bit() {
    let motor = Shaft::Free(machine(0.5, [0.2, 30.0], kloss(60.0, 0.12, 40.0, Some(1e-5))));
    let flight = backlash(hs(0.04), [0.5, 1.0, 4e8, 2e4, 2e-4, 0.0]);
    let of = scene(motor, vec![flight, shaft(hs(0.02), [20.0, 0.05, 1e8, 2e3])]);
    let mut train = started(&of, 0.0);
    for i in 0..40 {
        let time = 0.01 * f64::from(i);
        train.go_on(time, 0.01).unwrap();
        let bytes = postcard::to_stdvec(&train).unwrap();
        let mut copy: DriveTrain = postcard::from_bytes(&bytes).unwrap();
        copy.restored(&train).unwrap();
        let ends = [train.clone(), copy].map(|mut train| {
            train.go_on(time + 0.01, 0.01).unwrap();
            postcard::to_stdvec(&train).unwrap()
        });
        assert!(ends[0] == ends[1], "{time}");
    }
    assert!(train.run.steps < 2000.0, "{}", train.run.steps);
}
