//! Bounces, grazing, dwells, symmetries and the drive without clearance.

use super::*;
use crate::motion::{Cycle, CyclePlan, StandardLaw};
use crate::numerics::work::drawn;

/// m1, thrown off a flank with the acceleration 100 m/s² and the jerk j; m2 is all but free, held by b (N·s/m).
fn thrown([e, b]: [f64; 2], v0: f64, jerk: f64, end: f64) -> (Run, Vec<Event>) {
    let bodies = Bodies::new(&Parameters { m1: 2.0, m2: 1.0, c: 1e-6, b, s: 1.0, e });
    let motion = CubicFlank { speed: 0.0, start: 100.0, jerk };
    let state = State { q: [0.0; 2], home: 0.0, zeta: [0.0, v0] };
    ran(&bodies, &motion, (state, 1), end)
}

#[test]
fn bounces_on_a_pressed_flank_add_up() {
    let (m1, v0, alpha) = (2.0, 0.1, 100.0);
    for e in [0.1, 0.5, 0.8] {
        let (run, events) = thrown([e, 0.0], v0, 0.0, 0.1);
        let total = m1 * v0 * (1.0 + e) / (1.0 - e);
        let until = 2.0 * v0 / (alpha * (1.0 - e));
        assert_eq!(run.panel.mode(), Mode::Contact(Flank::A));
        assert!((run.tally.impulse / total - 1.0).abs() < 1e-9, "e = {e}: {} of {total}", run.tally.impulse);
        assert!((run.tally.energy_loss / (0.5 * m1 * v0 * v0) - 1.0).abs() < 1e-9);
        // The rest is summed when it takes less than 1e-7 of the natural time, here about 1 ms/rad.
        let summed = run.panel.from.start.hi;
        assert!(summed < until && until - summed < 1e-3, "{summed} {until}");
        // The flights last 2 v₀ eⁿ/α, the impulses fall like eⁿ.
        assert!((events[0].time - 2.0 * v0 / alpha).abs() < 1e-12 && events.len() < 31);
        assert!(e < 0.5 || (events[1].value / events[0].value - e).abs() < 1e-9);
    }
}

#[test]
fn bounces_on_a_pressed_flank_add_up_beside_a_weak_damper() {
    // Its force is 1e-11 of the pressing force; 2 v₀/(α (1 − e)) = 2 ms.
    for e in [0.1, 0.6, 0.99, 0.9995] {
        let (m1, v0) = (2.0, 0.1 * (1.0 - e));
        let (run, _) = thrown([e, 1e-9], v0, 0.0, 0.01);
        let total = 0.1 * m1 * (1.0 + e);
        assert!((run.tally.impulse / total - 1.0).abs() < 1e-9, "e = {e}: {} of {total}", run.tally.impulse);
        assert!((run.tally.energy_loss / (0.5 * m1 * v0 * v0) - 1.0).abs() < 1e-9);
        assert_eq!(run.panel.mode(), Mode::Contact(Flank::A));
    }
}

/// Every event up to `to`, in steps short enough for the log, and the sum of force_mean h.
fn observe(drive: &mut BacklashDrive, from: f64, to: f64, events: &mut Vec<Event>) -> f64 {
    let before = drive.clone();
    drive.advance(from, to - from).unwrap();
    if drive.log.dropped() == 0 {
        events.extend(drive.log.iter().copied());
        drive.log.clear();
        return drive.mean()[0] * (to - from);
    }
    *drive = before;
    let middle = 0.5 * (from + to);
    observe(drive, from, middle, events) + observe(drive, middle, to, events)
}

#[test]
fn impulses_are_what_the_contact_force_leaves_of_the_momentum() {
    // Each bounce lasts e times the previous one; after the last one F_K acts alone, and force_mean is its mean.
    let slow = |e: f64, b: f64| scene(5.0, 1e-9, b, e);
    let fast = |e: f64, b: f64| scene(50.0, 3e-4, b, e);
    for (scene, end) in [
        (fast(0.3, 0.0), 0.25),
        (fast(0.3, 60.0), 0.25),
        (fast(0.3, 1e6), 0.25),
        (fast(0.6, 60.0), 0.25),
        (fast(0.9, 2e3), 0.25),
        (slow(0.9, 60.0), 2.5),
        (slow(0.99, 0.0), 2.5),
        (slow(0.99, 60.0), 2.5),
    ] {
        let case = (scene.parameters.e, scene.parameters.b);
        let mut drive = started(scene.clone());
        let mut events = Vec::new();
        let received = observe(&mut drive, 0.0, end, &mut events);
        let switching: Vec<&Event> = events.iter().filter(|event| event.about == About::Machine).collect();
        let (mut contacts, mut accumulated) = (vec![[0.0, switching[0].time]], 0);
        for (n, impact) in switching.iter().enumerate().filter(|(_, event)| event.kind.starts_with("impact")) {
            let next = switching.get(n + 1);
            let left = next.map_or(end, |next| next.time);
            if next.map_or(drive.now.mode != Mode::Free, |next| next.kind.starts_with("release") && left > impact.time)
            {
                let before = switching[n - 1];
                assert_eq!(before.kind, impact.kind, "{case:?}");
                contacts.push([impact.time + (impact.time - before.time) * case.0 / (1.0 - case.0), left]);
                accumulated += 1;
            }
        }
        let mut again = started(scene);
        let (mut time, mut pressed) = (0.0, 0.0);
        for [from, to] in contacts {
            if from > time {
                again.advance(time, from - time).unwrap();
            }
            again.advance(from, to - from).unwrap();
            (time, pressed) = (to, pressed + again.mean()[0] * (to - from));
        }
        let listed: Vec<f64> = switching.iter().filter(|event| event.unit == "N.s").map(|event| event.value).collect();
        let size: f64 = listed.iter().map(|impulse| impulse.abs()).sum();
        for impulse in [drive.now.tally.impulse, listed.iter().sum()] {
            let error = (impulse - (received - pressed)).abs() / size;
            assert!(accumulated > 1 && error < 1e-11, "{case:?}: {accumulated} accumulations, {error:e}");
        }
    }
}

#[test]
fn bounces_that_the_flank_cuts_short_do_not_end_in_sticking() {
    // The acceleration of the flank falls from 100 m/s² to zero within 1 ms; the bounces would last 40 ms.
    let (run, events) = thrown([0.9, 0.0], 0.2, -1e5, 0.003);
    assert_eq!(run.panel.mode(), Mode::Free);
    assert!(events.iter().all(|e| e.kind != "bounces summed"));
}

#[test]
fn a_step_of_countless_switching_instants_ends_with_a_clear_fault() {
    // 1e4 s of elastic bounces; 1 s of a vibration at 1e12 rad/s that opens and closes the contact near a release.
    let elastic = scene(50.0, 3e-4, 0.0, 1.0);
    let mut stiff = scene(50.0, 1e-4, 0.0, 0.5);
    (stiff.parameters.m2, stiff.parameters.c) = (1e-9, 1e15);
    let _limited = drawn::limit(1e4);
    for (scene, step) in [(elastic, 1e4), (stiff, 1.0)] {
        let fault = started(scene).advance(0.0, step).unwrap_err();
        assert!(
            fault.to_string().contains("work than one call may take")
                && fault.to_string().contains("shorten the communication step"),
            "{fault}"
        );
    }
}

#[test]
fn a_mass_that_rests_for_no_time_is_released() {
    // z = 1 mm − 1 m/s t + 50 m/s² t²: m1 meets flank A, which falls away from it at 100 m/s².
    let bodies = Bodies::new(&Parameters { m1: 1.0, m2: 1.0, c: 1e-6, b: 0.0, s: 1.0, e: 0.0 });
    let motion = CubicFlank { speed: 0.0, start: -100.0, jerk: 0.0 };
    let state = State { q: [0.0; 2], home: 0.0, zeta: [1e-3, -1.0] };
    let (run, events) = ran(&bodies, &motion, (state, 0), 2e-3);
    let events: Vec<(&str, f64)> = events.iter().map(|e| (e.kind, e.time)).collect();
    assert_eq!(events.len(), 2, "{events:?}");
    assert_eq!((events[0].0, events[1].0), ("impact on flank A", "release from flank A"));
    assert_eq!(events[0].1, events[1].1);
    assert_eq!((run.panel.mode(), run.tally.impacts), (Mode::Free, 1.0));
}

#[test]
fn elastic_bounces_never_stick() {
    let (run, _) = thrown([1.0, 0.0], 0.1, 0.0, 0.1);
    assert_eq!(run.panel.mode(), Mode::Free);
    assert_eq!(run.tally.energy_loss, 0.0);
    // 2 v₀/α = 2 ms each.
    assert!((run.tally.impacts - 50.0).abs() <= 1.0, "{}", run.tally.impacts);
}

#[test]
fn a_grazing_mass_strikes_only_if_it_reaches_the_flank() {
    // m1 = m2 = c = 1 on a resting flank: z = z₀ + ½(q₀ − q), lowest at q = −q₀ > 0.
    for margin in [1e-3, 1e-6, 1e-9, 1e-12] {
        for sign in [1.0, -1.0] {
            let bodies = Bodies::new(&Parameters { m1: 1.0, m2: 1.0, c: 1.0, b: 0.0, s: 10.0, e: 0.0 });
            let motion = CubicFlank { speed: 0.0, start: 0.0, jerk: 0.0 };
            let state = State { q: [-1.0, 0.0], home: 0.0, zeta: [1.0 + sign * margin, 0.0] };
            let (_, events) = ran(&bodies, &motion, (state, 0), 4.0);
            let impacts: Vec<&Event> = events.iter().filter(|e| e.kind.starts_with("impact")).collect();
            assert_eq!(impacts.len(), if sign < 0.0 { 1 } else { 0 }, "{margin} {sign}");
            for impact in impacts {
                // z = ½(1 + cos √2t) − margin: the speed at z = 0 is √(2 margin (1 − margin)).
                let speed = (2.0 * margin * (1.0 - margin)).sqrt();
                // A depth of 1e-12 is known to 1e-16.
                assert!((impact.value - speed).abs() < 1e-3 * speed, "{margin}: {impact:?}, {speed}");
            }
        }
    }
}

#[test]
fn mirrored_drives_move_alike() {
    let end = 0.1;
    let mut drive = started(scene(50.0, 3e-4, 60.0, 0.5));
    drive.advance(0.0, end).unwrap();
    let mut mirrored = scene(50.0, 3e-4, 60.0, 0.5);
    let MotionLaw::Fourier(series) = profile() else { unreachable!() };
    let negative = |c: Vec<f64>| c.into_iter().map(|c| -c).collect();
    mirrored.cam = MotionLaw::Fourier(Fourier::new(negative(series.a), negative(series.b)));
    let mut mirrored = started(mirrored);
    mirrored.advance(0.0, end).unwrap();
    for (one, other) in drive.log.iter().zip(mirrored.log.iter()) {
        let swapped =
            one.kind.replace("flank A", "flank X").replace("flank B", "flank A").replace("flank X", "flank B");
        assert_eq!(swapped, other.kind);
        assert!((one.time - other.time).abs() < 1e-13, "{one:?} {other:?}");
        assert!(
            one.unit != "N.s" || one.about == About::Solver || (one.value + other.value).abs() < 1e-11,
            "{one:?} {other:?}"
        );
    }
    assert!((drive.now.point.state.q[0] + mirrored.now.point.state.q[0]).abs() < 1e-14);
}

#[test]
fn slow_motion_is_the_same_motion() {
    // t → λt: Ω/λ, c/λ², b/λ.
    let (end, lambda) = (0.1, 3.0);
    let mut drive = started(scene(50.0, 3e-4, 60.0, 0.5));
    drive.advance(0.0, end).unwrap();
    let mut slow = scene(50.0 / lambda, 3e-4, 60.0 / lambda, 0.5);
    slow.parameters.c /= lambda * lambda;
    let mut slow = started(slow);
    slow.advance(0.0, lambda * end).unwrap();
    for (one, other) in drive.log.iter().zip(slow.log.iter()) {
        assert_eq!(one.kind, other.kind);
        assert!((lambda * one.time - other.time).abs() < 1e-12, "{one:?} {other:?}");
    }
    assert!((drive.now.tally.impulse / lambda - slow.now.tally.impulse).abs() < 1e-12);
}

#[test]
fn without_clearance_the_drive_is_the_elastic_output_drive() {
    // Q = ν²X/(1 − ν² + 2iδν) for one harmonic.
    for b in [60.0, 4000.0] {
        let w = 180.0;
        let mut scene = scene(w, 0.0, b, 0.0);
        scene.cam = MotionLaw::Fourier(Fourier::new(vec![0.0, 0.01], vec![]));
        scene.start.mode = StartMode::SteadyState;
        let (m2, c) = (scene.parameters.m2, scene.parameters.c);
        let mut drive = started(scene);
        let omega = (c / m2).sqrt();
        let (nu, delta) = (w / omega, b / (2.0 * m2 * omega));
        let (re, im) = (1.0 - nu * nu, 2.0 * delta * nu);
        let size = 0.01 * nu * nu / re.hypot(im);
        for step in 0..200 {
            let t = f64::from(step) * 0.173;
            let phase = w * t - im.atan2(re);
            assert!((drive.now.point.state.q[0] - size * phase.cos()).abs() < 1e-12 * size, "b = {b}, t = {t}");
            assert!(drive.now.point.state.zeta == [0.0; 2] && drive.now.tally.impacts == 0.0);
            drive.advance(t, f64::from(step + 1) * 0.173 - t).unwrap();
        }
    }
}

#[test]
fn a_cycle_with_dwells_keeps_the_balances() {
    for law in [StandardLaw::Polynomial345, StandardLaw::ModifiedTrapezoid, StandardLaw::SimpleSine] {
        for e in [0.0, 0.4] {
            let mut scene = scene(40.0, 1e-4, 200.0, e);
            scene.cam = MotionLaw::Cycle(Cycle::new(CyclePlan {
                rise_law: law,
                return_law: law,
                inflections: [None; 2],
                stroke: 0.02,
                rise_start: 0.3,
                rise_angle: 1.8,
                upper_dwell: 1.0,
                return_angle: 2.2,
                lower: 0.0,
            }));
            let mut drive = started(scene);
            let (p0, e0) = (momentum(&drive), energy(&drive));
            let (mut impulse, mut work) = (0.0, 0.0);
            let h = 2.7e-3;
            for step in 0..300 {
                drive.advance(f64::from(step) * h, h).unwrap();
                impulse += drive.mean()[0] * h;
                work += drive.mean()[1] * 40.0 * h;
                let z = drive.now.point.state.home + drive.now.point.state.zeta[0];
                assert!((0.0..=1e-4).contains(&z), "{z}");
            }
            let losses = drive.now.tally.energy_loss + drive.damping_loss();
            assert!((momentum(&drive) - p0 - impulse).abs() < 1e-10, "{law:?} {e}");
            assert!((energy(&drive) - e0 - work + losses).abs() < 1e-10 * losses, "{law:?} {e}");
            assert!(drive.now.tally.impacts > 10.0);
        }
    }
}

#[test]
fn a_mass_at_rest_in_a_dwell_rises_with_any_law() {
    // F_K grows from zero as slowly as the law begins; a mass with restitution must not bounce without end meanwhile.
    for law in StandardLaw::ALL {
        for e in [0.0, 0.5, 0.7055754424178495, 1.0] {
            let mut scene = scene(71.77168521432267, 2.5315471307450462e-5, 0.0, e);
            (scene.parameters.m1, scene.parameters.m2, scene.parameters.c) =
                (1.2588556460051805, 1.3124240218301784, 306694.57729719696);
            scene.cam = MotionLaw::Cycle(Cycle::new(CyclePlan {
                rise_law: law,
                return_law: law,
                inflections: [None; 2],
                stroke: 0.01,
                rise_start: 1.0963374489420756,
                rise_angle: 2.217318476088689,
                upper_dwell: 0.5774431998043689,
                return_angle: 2.552212476394079,
                lower: 0.0,
            }));
            scene.drive = DriveMode::Constant { w: 71.77168521432267, phi_start: 0.1695009411611736 };
            let mut drive = started(scene);
            // The rise begins at 0.0129 s.
            drive.advance(0.0, 0.0135).unwrap();
            let moved = drive.now.point.u[0] + drive.now.point.state.home + drive.now.point.state.zeta[0];
            assert!(drive.now.tally.impacts < 2e4 && moved > 0.0, "{law:?} {e}: {:?}", drive.now.tally);
        }
    }
}

#[test]
fn stiff_and_overdamped_drives_keep_the_balances() {
    // Two turns at natural frequencies up to 5e5 rad/s, and with modes that die out within 1e-12 s.
    for (c, b, e) in [(5e5, 1e8, 0.5), (5e11, 1e3, 0.0), (5e11, 0.0, 0.0), (5e5, 1e12, 1.0), (5e-4, 0.0, 0.0)] {
        let scene = scene(50.0, 3e-4, 60.0, e);
        let mut drive = started(Scene { parameters: Parameters { c, b, e, ..scene.parameters }, ..scene });
        let (p0, e0) = (momentum(&drive), energy(&drive));
        let (mut impulse, mut work, mut largest) = (0.0, 0.0, e0);
        let h = 4e-3;
        for step in 0..60 {
            drive.advance(f64::from(step) * h, h).unwrap();
            impulse += drive.mean()[0] * h;
            work += drive.mean()[1] * 50.0 * h;
            largest = f64::max(largest, energy(&drive));
        }
        let losses = drive.now.tally.energy_loss + drive.damping_loss();
        let momentum_error = (momentum(&drive) - p0 - impulse).abs();
        let energy_error = (energy(&drive) - e0 - work + losses).abs() / largest.max(losses);
        assert!(
            momentum_error < 1e-9 && energy_error < 1e-9,
            "c = {c:e}, b = {b:e}: {momentum_error:e} {energy_error:e}"
        );
    }
}

#[test]
fn a_steep_rise_does_not_blur_the_release_on_a_gentle_return() {
    // Within the return U does not depend on the rise, and neither does the motion.
    let after_return = |rise_angle: f64, inflection: Option<f64>| {
        let plan = CyclePlan {
            stroke: 0.01,
            lower: 0.0,
            rise_start: -rise_angle,
            rise_angle,
            upper_dwell: 0.0,
            return_angle: 3.2,
            rise_law: StandardLaw::ModifiedSine,
            return_law: StandardLaw::ModifiedSine,
            inflections: [inflection, None],
        };
        let mut drive = BacklashDrive::new(Scene {
            coupling: false,
            parameters: Parameters { m1: 1.0, m2: 2.0, c: 1.8e5, b: 30.0, s: 1e-4, e: 0.0 },
            cam: MotionLaw::Cycle(Cycle::new(plan)),
            drive: DriveMode::Constant { w: 30.0, phi_start: 0.05 },
            start: Start { mode: StartMode::AtRest, q: 0.0, q_dot: 0.0 },
            solver: Settings::default(),
        })
        .unwrap();
        drive.start(0.0).unwrap();
        drive.advance(0.0, 2.9 / 30.0).unwrap();
        (drive.now.tally.impacts, drive.now.point.state.q)
    };
    let (impacts, q) = after_return(1.0, None);
    let (same, beside) = after_return(0.001, Some(0.99));
    assert!(impacts > 0.0 && impacts == same, "{impacts} {same}");
    assert!((q[0] - beside[0]).abs() < 1e-10 * q[0].abs().max(1e-4), "{q:?} {beside:?}");
}
