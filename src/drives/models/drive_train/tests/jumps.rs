//! Jumps of inputs and parameters: which followers leave their flanks, which stay, and which place and velocity continue.

use super::super::*;
use super::reference::{backlash, machine, output, scene, series};
use crate::drives::AnyDrive;
use crate::drives::backlash::{self, BacklashDrive};
use crate::drives::elastic_output::{self, ElasticOutput};
use crate::drives::follower::load::{Load, Spring};
use crate::drives::shaft::cam_drive;
use crate::drives::shaft::motor::{Motor, Reference, Servo, Source, Transmission};
use crate::motion::{Cycle, CyclePlan, MotionLaw, StandardLaw};

/// A drive by the names of its variables.
struct Named {
    drive: AnyDrive,
    time: f64,
}

impl Named {
    fn new<D: Drive>(scene: D::Scene, start: &[(&str, f64)]) -> Self {
        let mut named = Named { drive: AnyDrive::new(D::new(scene).unwrap()), time: 0.0 };
        named.drive.set_up(0.0, None);
        start.iter().for_each(|(name, value)| named.set(name, *value));
        named.drive.start().unwrap();
        named
    }

    fn place(&self, name: &str) -> usize {
        self.drive.descriptions().iter().position(|d| d.name == name).unwrap_or_else(|| panic!("{name}"))
    }

    fn set(&mut self, name: &str, value: f64) {
        self.drive.set(self.place(name), value).unwrap();
    }

    fn get(&mut self, name: &str) -> f64 {
        self.drive.get(self.place(name)).unwrap()
    }

    fn step(&mut self, step: f64) {
        self.drive.advance(self.time, step).unwrap();
        self.time += step;
    }

    /// Goes on in so many steps.
    fn to(&mut self, end: f64, steps: usize) {
        let begin = self.time;
        for i in 1..=steps {
            let step = begin + (end - begin) * i as f64 / steps as f64 - self.time;
            self.step(step);
        }
    }

    fn kinds(&mut self) -> Vec<&'static str> {
        self.drive.events().iter().map(|event| event.kind).collect()
    }
}

/// A follower that may lift off its cam, with m1 = 0.2 kg: 20 N at y = −0.01 m and 500 N/m press it on.
fn pressed(m2: f64, s: f64, e: f64) -> Follower {
    let mut follower = backlash(series(&[0.0, 0.01], &[]), [0.2, m2, 2e4, 2.0, s, e]);
    follower.load = Load {
        gravity: Some(-9.81),
        spring: Some(Spring { preload: 20.0, c: 500.0, at: -0.01 }),
        input: true,
        ..Load::default()
    };
    follower
}

/// x1 and ẋ1 of that follower without m2 after a flight of `time` (s) under a further force.
fn flight([x, v]: [f64; 2], force: f64, time: f64) -> [f64; 2] {
    let (m, c) = (0.2, 500.0_f64);
    let (rate, rest) = ((c / m).sqrt(), (force - m * 9.81 - 20.0 - c * 0.01) / c);
    let (sine, cosine) = (rate * time).sin_cos();
    [rest + (x - rest) * cosine + v / rate * sine, v * cosine - (x - rest) * rate * sine]
}

fn uniform(w: f64) -> Shaft {
    Shaft::Driven(DriveMode::Constant { w, phi_start: 0.0 })
}

#[test]
fn a_force_that_lifts_a_follower_does_so_at_once() {
    for (name, there, back) in [("follower[1].F", 60.0, 0.0), ("follower[1].load.preload", -40.0, 20.0)] {
        for (steps, toggled) in [(1, false), (10, true), (100, false)] {
            let mut train = Named::new::<DriveTrain>(scene(uniform(20.0), vec![pressed(0.0, f64::INFINITY, 0.0)]), &[]);
            train.to(0.05, 5 * steps);
            assert_eq!(train.get("follower[1].contact"), 1.0);
            if toggled {
                // A value set and taken back before the step has no effect.
                train.set(name, there);
                assert_eq!(train.get("follower[1].contact"), 0.0, "{name}");
                train.set(name, back);
                assert_eq!(train.get("follower[1].contact"), 1.0, "{name}");
                train.step(1e-9);
                assert_eq!(train.get("follower[1].contact"), 1.0, "{name}");
            }
            train.set(name, there);
            let phi = 20.0 * train.time;
            let end = flight([0.01 * phi.cos(), -0.2 * phi.sin()], 60.0, 0.06 - train.time);
            train.to(0.06, steps);
            let got = ["follower[1].x1", "der(follower[1].x1)"].map(|name| train.get(name));
            for ((got, end), size) in got.into_iter().zip(end).zip([0.01, 1.0]) {
                assert!((got - end).abs() < 1e-11 * size, "{name} {steps}: {got} {end}");
            }
            assert_eq!(train.get("follower[1].impacts"), 0.0, "{name} {steps}");
        }
    }
}

#[test]
fn a_torque_that_turns_a_cam_away_leaves_its_follower() {
    // The third derivative of the gap is negative there, the second one is not.
    let shaft = Machine { loads: vec![Default::default()], ..machine(0.01, [1.0, 20.0], Motor::default()) };
    let mut train = Named::new::<DriveTrain>(scene(Shaft::Free(shaft), vec![pressed(0.0, f64::INFINITY, 0.0)]), &[]);
    train.to(0.05, 7);
    let names = ["phi", "w", "follower[1].x1", "der(follower[1].x1)"];
    let [phi, w, x, v] = names.map(|name| train.get(name));
    train.set("tau", -200.0);
    train.to(0.053, 3);
    let [x, v] = flight([x, v], 0.0, 0.003);
    let expected = [phi + w * 0.003 + 0.5 * 2e4 * 0.003 * 0.003, w + 2e4 * 0.003, x, v];
    for (name, expected) in names.iter().zip(expected) {
        let got = train.get(name);
        assert!((got - expected).abs() < 1e-10 * (1.0 + expected.abs()), "{name}: {got} {expected}");
    }
    assert_eq!(train.get("follower[1].impacts"), 0.0);
}

/// u = 2 (ω_ref − ω) N·m, at most 5 N·m.
fn servo() -> Motor {
    let servo = Servo {
        proportional: 2.0,
        integral: 0.0,
        anti_windup: 0.0,
        limit: 5.0,
        reference: Reference::Input,
        position: None,
    };
    Motor { source: Source::Servo(servo), transmission: Transmission::default() }
}

#[test]
fn a_servo_at_its_limit_lifts_nobody() {
    // The demand jumps to 2 MN·m, the torque to 5 N·m.
    let shaft = Shaft::Free(machine(0.05, [0.7, 20.0], servo()));
    let mut train = Named::new::<DriveTrain>(scene(shaft, vec![pressed(0.0, f64::INFINITY, 0.0)]), &[("w_ref", 20.0)]);
    train.to(0.01, 3);
    for w_ref in [1e6, -1e6] {
        train.drive.events().clear();
        train.set("w_ref", w_ref);
        assert_eq!((train.get("follower[1].contact"), train.get("M_an")), (1.0, 5.0_f64.copysign(w_ref)));
        train.step(0.001);
        assert_eq!((train.get("follower[1].contact"), train.get("follower[1].impacts")), (1.0, 0.0));
        assert_eq!(train.kinds(), ["torque of the servo at its limit"]);
    }
}

#[test]
fn a_demand_just_below_its_limit_rises_to_it() {
    // Below the limit from 25 ms on; 10 µs later ω_ref begins to rise, and u = 10 − (10 − u₀) exp(−40 t).
    let shaft = Shaft::Free(machine(0.05, [0.0, 0.0], servo()));
    let mut train = Named::new::<DriveTrain>(scene(shaft, Vec::new()), &[("w_ref", 5.0)]);
    train.step(0.02501);
    let place = train.place("w_ref");
    train.drive.set_input_derivative(place, 1, 200.0).unwrap();
    train.step(0.001);
    let times: Vec<f64> = train.drive.events().iter().map(|event| event.time).collect();
    let below = 5.0 * f64::exp(-40.0 * 1e-5);
    let expected = [0.025, 0.02501 + ((10.0 - below) / 5.0).ln() / 40.0];
    assert!(
        times.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12) && times.len() == 2,
        "{times:?} {expected:?}"
    );
}

/// Sets φ, ω, α.
fn put(drive: &mut Named, [phi, w, a]: [f64; 3]) {
    [("phi", phi), ("w", w), ("a", a)].into_iter().for_each(|(name, value)| drive.set(name, value));
}

fn on_inputs(follower: Follower, [phi, w, a]: [f64; 3]) -> Named {
    let scene = scene(Shaft::Driven(DriveMode::Input), vec![follower]);
    Named::new::<DriveTrain>(scene, &[("phi", phi), ("w", w), ("a", a)])
}

const MASSES: [&str; 4] = ["follower[1].x1", "der(follower[1].x1)", "follower[1].y", "der(follower[1].y)"];

#[test]
fn a_mass_that_leaves_the_flank_which_overtakes_it_keeps_its_velocity() {
    for lift in [1e-7, 2e-5] {
        let mut follower = backlash(series(&[0.01, -0.01], &[]), [0.2, 0.3, 1e5, 0.0, f64::INFINITY, 0.8]);
        follower.load.spring = Some(Spring { preload: 20.0, c: 500.0, at: 0.0 });
        let (mut train, mut n) = (on_inputs(follower, [0.0, 100.0, 0.0]), 0);
        let angle = |n: i32| 1e-3 * f64::from(n);
        while train.get("follower[1].impacts") == 0.0 {
            put(&mut train, [angle(n), 100.0, 0.0]);
            train.step(1e-5);
            n += 1;
        }
        let before = MASSES.map(|name| train.get(name));
        let phi = (1.0 - 100.0 * (0.01 - 0.01 * angle(n).cos() + lift)).acos();
        let (u, speed) = (0.01 - 0.01 * phi.cos(), phi.sin());
        assert!(before[0] < u && before[1] > speed, "the flank overtakes a mass that leaves it");
        put(&mut train, [phi, 100.0, 0.0]);
        let after = MASSES.map(|name| train.get(name));
        assert!((after[0] - u).abs() < 1e-16, "{after:?} {u}");
        for i in 1..4 {
            assert!((after[i] - before[i]).abs() < 1e-14, "{lift} {i}: {before:?} {after:?}");
        }
        assert_eq!((train.get("follower[1].impacts"), train.get("follower[1].contact")), (1.0, 0.0));
    }
}

#[test]
fn jumps_are_those_of_a_backlash_drive() {
    for e in [0.0, 0.3] {
        let parameters = crate::drives::backlash::Parameters { m1: 0.2, m2: 0.5, c: 3e5, b: 30.0, s: 3e-4, e };
        let cam = series(&[0.0, 0.01, 0.002], &[]);
        let follower = backlash(cam.clone(), [0.2, 0.5, 3e5, 30.0, 3e-4, e]);
        // Each step ends at most 4.5e-5 rad and 0.135 rad/s from the start of the next one.
        let inputs = |t: f64| {
            let (sine, cosine) = (300.0 * t).sin_cos();
            [100.0 * t + 0.01 * sine, 100.0 + 3.0 * cosine, -900.0 * sine]
        };
        let [phi, w, a] = inputs(0.0);
        let alone = backlash::Scene {
            coupling: false,
            parameters,
            cam,
            drive: DriveMode::Input,
            start: cam_drive::Start { mode: cam_drive::StartMode::AtRest, q: 0.0, q_dot: 0.0 },
            solver: Settings::default(),
        };
        let mut alone = Named::new::<BacklashDrive>(alone, &[("phi", phi), ("w", w), ("a", a)]);
        let mut train = on_inputs(follower, [phi, w, a]);
        let mut free = 0;
        for n in 0..60 {
            let time = 1e-3 * f64::from(n);
            for drive in [&mut alone, &mut train] {
                put(drive, inputs(time));
                drive.step(1e-3);
            }
            for (name, size) in ["x1", "der(x1)", "y", "der(y)"].into_iter().zip([0.01, 1.0, 0.01, 1.0]) {
                let own = if let Some(place) = name.strip_prefix("der(") {
                    format!("der(follower[1].{place}")
                } else {
                    format!("follower[1].{name}")
                };
                let [one, other] = [alone.get(name), train.get(&own)];
                assert!((one - other).abs() < 1e-7 * size, "{e} {time} {name}: {one} {other}");
            }
            assert_eq!(alone.get("contact"), train.get("follower[1].contact"), "{e} {time}");
            free += i32::from(alone.get("contact") == 0.0);
        }
        assert!(free > 5, "{free}");
    }
}

#[test]
fn a_cam_that_slows_down_pulls_only_a_follower_between_two_flanks() {
    for (m2, s) in [(0.0, f64::INFINITY), (0.3, f64::INFINITY), (0.0, 1e-3), (0.3, 1e-3)] {
        let w = 20.0;
        let mut train = on_inputs(pressed(m2, s, 0.0), [4.0, w, 0.0]);
        // Uniform motion is no jump, however it is rounded.
        for n in 0..1000 {
            let time = 1e-4 * f64::from(n);
            put(&mut train, [4.0 + w * time, w, 0.0]);
            train.step(1e-4);
        }
        assert_eq!((train.get("follower[1].contact"), train.kinds().len()), (1.0, 0), "{s}");
        let names = if m2 > 0.0 { &MASSES[..] } else { &MASSES[..2] };
        let before: Vec<f64> = names.iter().map(|name| train.get(name)).collect();
        let impulse = train.get("follower[1].impulse");
        let slope = -0.01 * 6.0_f64.sin();
        assert!(slope > 0.0);
        put(&mut train, [4.0 + w * 0.1, 5.0, 0.0]);
        let after: Vec<f64> = names.iter().map(|name| train.get(name)).collect();
        let pulled = if s.is_finite() { 0.2 * slope * (5.0 - w) } else { 0.0 };
        for (i, (before, after)) in before.iter().zip(&after).enumerate() {
            let change = if i == 1 { pulled / 0.2 } else { 0.0 };
            assert!((after - before - change).abs() < 1e-14, "{s} {i}: {before} {after}");
        }
        assert!((train.get("follower[1].impulse") - impulse - pulled).abs() < 1e-14);
        assert_eq!(train.get("follower[1].contact"), if s.is_finite() { 1.0 } else { 0.0 });
        train.step(1e-6);
        let gap = train.get("follower[1].x1") - 0.01 * (6.0_f64 + 5e-6).cos();
        assert!(if s.is_finite() { gap.abs() < 1e-16 } else { (gap - 1e-6 * 15.0 * slope).abs() < 1e-10 }, "{gap}");
        assert_eq!(train.get("follower[1].impacts"), 0.0);
    }
}

/// A rise of 10 mm from 160° to 240°, and back from 270° to 340°.
fn with_dwells() -> MotionLaw {
    let deg = |x: f64| x.to_radians();
    MotionLaw::Cycle(Cycle::new(CyclePlan {
        stroke: 0.01,
        lower: 0.0,
        rise_start: deg(160.0),
        rise_angle: deg(80.0),
        upper_dwell: deg(30.0),
        return_angle: deg(70.0),
        rise_law: StandardLaw::Polynomial345,
        return_law: StandardLaw::Polynomial345,
        inflections: [None; 2],
    }))
}

#[test]
fn a_motion_that_begins_behind_a_dwell_is_as_fine_as_any() {
    let cam = with_dwells();
    for (w, c, phi_start) in [(100.0, 3e5, -0.2), (20.0, 3e5, -0.2), (100.0, 3e7, -0.2), (100.0, 3e5, 2.7)] {
        let drive = DriveMode::Constant { w, phi_start };
        let alone = elastic_output::Scene {
            coupling: false,
            parameters: elastic_output::Parameters { m: 0.5, c, b: 30.0 },
            cam: cam.clone(),
            drive: drive.clone(),
            start: cam_drive::Start { mode: cam_drive::StartMode::AtRest, q: 0.0, q_dot: 0.0 },
            solver: Settings::default(),
            load: Load::default(),
            roller: (0.0, Load::default()),
        };
        let mut alone = Named::new::<ElasticOutput>(alone, &[]);
        let mut train =
            Named::new::<DriveTrain>(scene(Shaft::Driven(drive), vec![output(cam.clone(), [0.5, c, 30.0], 0.0)]), &[]);
        let (mut error, mut largest) = (0.0_f64, 0.0_f64);
        for _ in 0..400 {
            let step = 2.0 * TAU / w / 400.0;
            alone.step(step);
            train.step(step);
            let q = alone.get("q");
            error = error.max((q - train.get("follower[1].q")).abs());
            largest = largest.max(q.abs());
        }
        assert!(error < 1e-10 * largest, "{w} {c} {phi_start}: {:e}", error / largest);
        let estimate = train.get("solver.error_estimate");
        assert!(
            error <= estimate * largest && estimate < 1e-9,
            "{w} {c} {phi_start}: {:e} {estimate:e}",
            error / largest
        );
    }
}

#[test]
fn bounces_on_a_dwell_are_followed_as_far_as_they_show() {
    // Thrown up by 20 N more than its weight, from 10 ms on back onto its cam.
    let (m, e, weight, lift) = (0.2, 0.9, 20.0, 40.0);
    let mut follower = backlash(with_dwells(), [m, 0.0, 0.0, 0.0, f64::INFINITY, e]);
    follower.load = Load { constant: Some(-weight), input: true, ..Load::default() };
    let mut train = Named::new::<DriveTrain>(scene(uniform(0.5), vec![follower]), &[("follower[1].F", lift)]);
    train.to(0.01, 1);
    train.set("follower[1].F", 0.0);
    let (up, down) = ((lift - weight) / m, weight / m);
    // The flight begins at the height h with the velocity v; at the first impact it is w.
    let (h, v) = (0.5 * up * 1e-4, up * 0.01);
    let w: f64 = (v * v + 2.0 * down * h).sqrt();
    let (mut begin, mut speed, mut height) = (0.01, v, h);
    let mut end = 0.01 + (v + w) / down;
    let (mut n, mut error) = (0, 0.0_f64);
    for i in 1..=4000 {
        let time = 0.01 + 1e-4 * f64::from(i);
        train.to(time, 1);
        while time > end && n < 200 {
            n += 1;
            (begin, speed, height) = (end, w * f64::powi(e, n), 0.0);
            end = begin + 2.0 * speed / down;
        }
        let since = time - begin;
        let x = if time > end { 0.0 } else { height + speed * since - 0.5 * down * since * since };
        error = error.max((train.get("follower[1].x1") - x).abs());
    }
    assert!(error < 1e-12 && n == 200 && train.get("follower[1].contact") == 1.0, "{error:e} {n}");
    let [impulse, loss] = ["follower[1].impulse", "follower[1].energy_loss"].map(|name| train.get(name));
    assert!((impulse - m * w * (1.0 + e) / (1.0 - e)).abs() < 1e-12 && (loss - 0.5 * m * w * w).abs() < 1e-12);
}
