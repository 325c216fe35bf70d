//! Jumps of the inputs: their effect on a mass in flight, on one that they set on a flank, and on one that cannot leave it.

use super::interface::{march, ramp, set, with_inputs};
use super::*;

/// x1, ẋ1, x2, ẋ2.
fn places(drive: &BacklashDrive) -> [f64; 4] {
    let ([x, v], q) = (drive.now.point.place(), drive.now.point.state.q);
    [x, v, x + q[0], v + q[1]]
}

/// A drive whose mass flies at this time, on uniform inputs up to there; None if it does not.
fn flying(e: f64, time: f64) -> Option<BacklashDrive> {
    let mut drive = with_inputs(e);
    march(&mut drive, time, 1e-3, ramp(0.0));
    (drive.now.mode == Mode::Free).then_some(drive)
}

/// Sets inputs with which m1 is `ahead` (m) of a flank and moves away from it at `speed` (m/s), in the sense in which the flank
/// pushes, and with which the flank accelerates at about `push` (m/s²) in that sense.
fn meet(drive: &mut BacklashDrive, flank: Flank, [ahead, speed, push]: [f64; 3]) {
    let ([x, v, ..], sign) = (places(drive), flank.sign());
    let target = x - drive.bodies.place(flank) - sign * ahead;
    let mut phi = 50.0 * drive.now.time;
    for _ in 0..20 {
        let [u, slope, ..] = profile().at(phi).0;
        phi -= (u - target) / slope;
    }
    let [_, slope, curvature, ..] = profile().at(phi).0;
    let w = (v - sign * speed) / slope;
    set(drive, phi, w, (sign * push - curvature * w * w) / slope);
}

/// Times at which the mass may fly.
fn times() -> impl Iterator<Item = f64> {
    (0..12).map(|n| 0.036 + 7.3e-4 * f64::from(n))
}

#[test]
fn a_mass_that_comes_to_rest_on_a_flank_stays_there_while_it_is_pressed() {
    let (mut cases, mut inexact) = (0, 0);
    for flank in [Flank::A, Flank::B] {
        for (time, push) in times().flat_map(|time| [(time, 1e3), (time, -1e3)]) {
            let Some(mut drive) = flying(0.5, time) else { continue };
            let (before, tally, end) = (places(&drive), drive.now.tally, drive.now.point);
            meet(&mut drive, flank, [0.0, 0.0, push]);
            drive.apply(time).unwrap();
            let [u, u1] = [0, 1].map(|n| drive.now.point.u[n] - end.u[n]);
            let z = end.state.home + end.state.zeta[0] - u - drive.bodies.place(flank);
            inexact += usize::from(z != 0.0 && end.state.zeta[1] != u1);
            let expected = if push > 0.0 { Mode::Contact(flank) } else { Mode::Free };
            assert_eq!((drive.now.mode, drive.now.tally), (expected, tally), "{flank:?} {time} {push}");
            for (before, after) in before.into_iter().zip(places(&drive)) {
                assert!((after - before).abs() < 1e-15 * (1.0 + before.abs()), "{flank:?} {time}: {before} {after}");
            }
            drive.advance(time, 1e-5).unwrap();
            assert_eq!((drive.now.mode, drive.now.tally.impacts), (expected, tally.impacts), "{flank:?} {time} {push}");
            cases += 1;
        }
    }
    assert!(cases >= 12 && inexact >= 4, "{inexact} of {cases} jumps are rounded");
}

#[test]
fn a_mass_that_is_put_on_a_flank_strikes_it_only_if_it_moves_towards_it() {
    let e = 0.5;
    for flank in [Flank::A, Flank::B] {
        for time in times() {
            let Some(mut drive) = flying(e, time) else { continue };
            let (before, tally) = (places(&drive), drive.now.tally);
            // 10 µm beyond the flank, away from it; then towards it.
            meet(&mut drive, flank, [-1e-5, 0.1, 0.0]);
            drive.apply(time).unwrap();
            let after = places(&drive);
            assert_eq!((drive.now.mode, drive.now.tally), (Mode::Free, tally));
            assert!((after[0] - before[0] - flank.sign() * 1e-5).abs() < 1e-15, "{before:?} {after:?}");
            for n in 1..4 {
                assert!((after[n] - before[n]).abs() < 1e-15 * (1.0 + before[n].abs()), "{n}: {before:?} {after:?}");
            }
            let mut ahead = drive.clone();
            ahead.advance(time, 1e-6).unwrap();
            assert_eq!(ahead.now.tally.impacts, tally.impacts);
            drive.now.point = drive.end.point;
            meet(&mut drive, flank, [-1e-5, -0.1, 0.0]);
            drive.apply(time).unwrap();
            let (after, impulse) = (places(&drive), drive.now.tally.impulse - tally.impulse);
            assert_eq!(drive.now.tally.impacts, tally.impacts + 1.0);
            assert!((impulse - flank.sign() * drive.parameters.m1 * (1.0 + e) * 0.1).abs() < 1e-13, "{impulse}");
            assert!((after[1] - before[1] - impulse / drive.parameters.m1).abs() < 1e-13, "{before:?} {after:?}");
            for n in 2..4 {
                assert!((after[n] - before[n]).abs() < 1e-15 * (1.0 + before[n].abs()), "{n}: {before:?} {after:?}");
            }
        }
    }
}

#[test]
fn a_mass_between_the_flanks_flies_on() {
    let mut cases = 0;
    for (flank, time) in [Flank::A, Flank::B].into_iter().flat_map(|flank| times().map(move |time| (flank, time))) {
        let Some(mut drive) = flying(0.5, time) else { continue };
        let (before, tally) = (places(&drive), drive.now.tally);
        // Towards the flank, but 10 µm before it; without the relative speed, too.
        for speed in [-0.1, 0.0] {
            drive.now.point = drive.end.point;
            meet(&mut drive, flank, [1e-5, speed, 1e3]);
            drive.apply(time).unwrap();
            assert_eq!((drive.now.mode, drive.now.tally), (Mode::Free, tally));
            for (before, after) in before.into_iter().zip(places(&drive)) {
                assert!((after - before).abs() < 1e-15 * (1.0 + before.abs()), "{flank:?} {time}: {before} {after}");
            }
        }
        cases += 1;
    }
    assert!(cases >= 6, "{cases}");
}

#[test]
fn a_flank_that_is_torn_away_releases_its_mass() {
    let mut drive = with_inputs(0.0);
    march(&mut drive, 0.02, 1e-3, ramp(0.0));
    let (Mode::Contact(contact), [_, v, ..]) = (drive.now.mode, places(&drive)) else { panic!("the mass flies") };
    let [_, slope, ..] = profile().at(1.0001).0;
    // ü = −1 km/s² in the sense in which the flank pushes, and 0.01 m/s more.
    let (w, a) = ((v + contact.sign() * 0.01) / slope, -contact.sign() * 1e3 / slope);
    set(&mut drive, 1.0001, w, a);
    let (tally, [.., y, y_dot]) = (drive.now.tally, places(&drive));
    drive.apply(0.02).unwrap();
    // At once, not only after m2 has moved.
    let [.., y_now, y_dot_now] = places(&drive);
    assert!(drive.now.mode == Mode::Free && (y_now - y).abs() < 1e-16 && (y_dot_now - y_dot).abs() < 1e-15);
    drive.events().clear();
    drive.advance(0.02, 1e-6).unwrap();
    assert_eq!((drive.now.mode, drive.now.tally.impacts), (Mode::Free, tally.impacts));
    let kinds: Vec<&str> = drive.log.iter().map(|event| event.kind).collect();
    assert_eq!(kinds, [if contact == Flank::A { "release from flank A" } else { "release from flank B" }]);
    let push = drive.now.tally.impulse - tally.impulse;
    assert!((push - drive.parameters.m1 * contact.sign() * 0.01).abs() < 1e-15, "{push}");
}

#[test]
fn without_clearance_no_jump_and_no_pull_releases_the_mass() {
    let mut scene = scene(50.0, 0.0, 60.0, 0.5);
    scene.drive = DriveMode::Input;
    let mut drive = BacklashDrive::new(scene).unwrap();
    set(&mut drive, 0.0, 50.0, 0.0);
    drive.start(0.0).unwrap();
    let (mut signs, h) = ([false; 2], 1e-3);
    for step in 0..200 {
        let time = f64::from(step) * h;
        let jump = if step % 50 == 49 { 0.01 } else { 0.0 };
        set(&mut drive, 50.0 * time + jump, 50.0, 0.0);
        drive.advance(time, h).unwrap();
        assert_eq!((drive.now.mode, drive.now.tally.impacts), (Mode::Contact(Flank::A), 0.0), "at {time} s");
        let u = drive.flank().at(0, Double::from(drive.now.time));
        let [force, ..] = drive.bodies.force(drive.now.point.state.q, &u);
        signs[usize::from(force > 0.0)] = true;
    }
    // The log only reports that the inputs jump.
    let about: Vec<About> = drive.log.iter().map(|event| event.about).collect();
    assert_eq!((signs, about), ([true; 2], vec![About::Inputs]));
}
