//! The turn against printed numbers, closed forms and balances of power; the study that leaves out parts of a train.

use super::*;
use crate::resource::Resource;
use crate::tradeoff::Options;
use camdrive::drives::drive_train::{self, Follower, Joint, Machine, Start};
use camdrive::drives::elastic_output::Parameters;
use camdrive::drives::follower::load::{Load, Spring};
use camdrive::drives::rigid_machine::{self, InertiaFunction, Kloss};
use camdrive::drives::settings::Settings;
use camdrive::drives::shaft::motor::{Motor, Source, Transmission};
use camdrive::drives::{Drive, backlash};
use camdrive::motion::{Fourier, MotionLaw};

fn series(a: &[f64], b: &[f64]) -> MotionLaw {
    MotionLaw::Fourier(Fourier::new(a.to_vec(), b.to_vec()))
}

fn hs(h: f64) -> MotionLaw {
    series(&[0.0, 0.5867 * h, 0.0, -0.0984 * h, 0.0, 0.0115 * h], &[])
}

fn follower(cam: MotionLaw, joint: Joint) -> Follower {
    Follower { rigid: rigid_machine::Follower::new(0.0, cam), joint, load: Load::default(), roller: Load::default() }
}

/// J₀ = 0.9 kg·m², an asynchronous motor, a load that varies over the turn, and friction.
fn machine(source: Source) -> Machine {
    Machine {
        inertia: InertiaFunction { constant: 0.9, varying: None },
        load: Some(series(&[4.0, 1.5], &[0.0, 0.8])),
        friction: Some(0.1),
        loads: vec![],
        motor: Motor { source, transmission: Transmission::default() },
        phi_start: 1.0,
        w_start: 0.0,
    }
}

fn kloss() -> Source {
    let (breakdown_torque, breakdown_slip, synchronous_speed, dynamics) = (60.0, 0.2, 15.0, None);
    Source::Kloss(Kloss { breakdown_torque, breakdown_slip, synchronous_speed, dynamics })
}

fn scene(shaft: Shaft, followers: Vec<Follower>) -> drive_train::Scene {
    drive_train::Scene {
        coupling: false,
        shaft,
        followers,
        start: Start::AtRest,
        solver: Settings::default(),
        names: camdrive::drives::drive_train::Names::default(),
    }
}

fn output() -> Follower {
    let mut output = follower(hs(0.04), Joint::Output(Parameters { m: 3.0, c: 12000.0, b: 20.0 }, 0.0));
    output.load.gravity = Some(-9.81);
    output
}

/// One-sided: m1 and m2 on a spring that keeps them on the cam.
fn valve() -> Follower {
    let parameters = backlash::Parameters { m1: 0.2, m2: 1.0, c: 4e5, b: 60.0, s: f64::INFINITY, e: 0.0 };
    let mut valve = follower(hs(0.01), Joint::Backlash(parameters));
    valve.load.spring = Some(Spring { preload: 2000.0, c: 2500.0, at: 0.0 });
    valve
}

fn turn_of(scene: drive_train::Scene) -> Result<Turn, Fault> {
    of(&Scene::from(scene), None, 0.0)
}

/// φ and ω over the turn.
fn course(turn: &Turn) -> Vec<[f64; 2]> {
    let w = &turn.output("w").unwrap().values;
    turn.angles.iter().zip(w).map(|(phi, w)| [*phi, *w]).collect()
}

fn near(value: f64, right: f64, part: f64) {
    assert!((value - right).abs() <= part * right.abs(), "{value} {right}");
}

#[test]
fn the_printed_motion_with_its_multipliers_and_its_balance() {
    let turn = turn_of(scene(Shaft::Free(machine(kloss())), vec![output()])).unwrap();
    let (period, course) = (turn.period, course(&turn));
    near(period, 0.422775956727908, 1e-12);
    near(course[0][1], 14.834951322737, 1e-12);
    // Printed: −0.0023514211761 ± 0.2407085147409 i, 7.7e-9.
    for [re, im] in &turn.multipliers[..2] {
        assert!((re + 0.0023514211761).abs() < 1e-9, "{re}");
        near(im.abs(), 0.2407085147409, 2e-9);
    }
    let [re, im] = turn.multipliers[2];
    assert!(turn.multipliers.len() == 3 && im == 0.0 && (re - 7.7e-9).abs() < 2e-9, "{re} {im}");
    // What the motor gives in a turn: 2π · 4 N·m to the load, ∫b ω dφ to friction, the printed rest to the damper.
    let friction: f64 =
        course.windows(2).map(|ends| 0.05 * (ends[0][1] + ends[1][1]) * (ends[1][0] - ends[0][0])).sum();
    near(turn.mean_power * period, 4.0 * TAU + friction + 0.184080433981744, 1e-6);
    let force = turn.outputs.iter().find(|range| range.output == "follower[1].force").unwrap();
    // On the mean the spring carries the weight.
    near(force.mean, 3.0 * 9.81, 1e-6);
    let scene = Resource::new("train", scene(Shaft::Free(machine(kloss())), vec![output()]));
    let text = crate::steady::of_drive(&scene, None).unwrap().report().text(100, true);
    assert!(text.contains("0.241 ") && text.contains("follower[1].force [N]"), "{text}");
}

#[test]
fn extremes_are_right_to_many_digits() {
    // At constant speed the output has a closed form: |q| of harmonic k is m k² Ω² X/|c − m k² Ω² + i k Ω b|.
    let drive = Shaft::Driven(DriveMode::Constant { w: 14.0, phi_start: 0.5 });
    let joint = Joint::Output(Parameters { m: 3.0, c: 12000.0, b: 20.0 }, 0.0);
    let turn = turn_of(scene(drive, vec![follower(series(&[0.0, 0.0, 0.01], &[]), joint)])).unwrap();
    let kw = 28.0_f64;
    let amplitude = 0.01 * 3.0 * kw * kw / (12000.0 - 3.0 * kw * kw).hypot(20.0 * kw);
    let q = turn.outputs.iter().find(|range| range.output == "follower[1].q").unwrap();
    near(q.largest, amplitude, 1e-11);
    near(q.least, -amplitude, 1e-11);
    // Both halves of the turn have the same extremes: the first counts.
    assert!(q.least_at.max(q.largest_at) < TAU / 2.0 && q.peak().phi == q.least_at.min(q.largest_at));
    // Damping is what the drive has to give: ½ b (kΩ q)².
    near(turn.mean_power, 10.0 * (kw * amplitude).powi(2), 1e-9);
    near(turn.mean_torque, turn.mean_power / 14.0, 1e-12);
}

#[test]
fn impacts_are_counted_and_their_momentum_is_part_of_the_torque() {
    // A stiff follower that leaves its cam from 129.036187 rad/s on and comes down without rebound.
    let scene = |w: f64| {
        let parameters = backlash::Parameters { m1: 0.6, m2: 0.0, c: 0.0, b: 0.0, s: f64::INFINITY, e: 0.0 };
        let mut lifted = follower(series(&[0.0, -0.008, 0.0009], &[0.0, 0.0, 0.0004]), Joint::Backlash(parameters));
        lifted.load.gravity = Some(-9.81);
        lifted.load.spring = Some(Spring { preload: 90.0, c: 2500.0, at: 0.0 });
        scene(Shaft::Driven(DriveMode::Constant { w, phi_start: 0.0 }), vec![lifted])
    };
    let calm = turn_of(scene(128.9)).unwrap();
    assert!(calm.impacts == [Some(0.0)] && calm.mean_power.abs() < 1e-9, "{:?} {}", calm.impacts, calm.mean_power);
    let turn = turn_of(scene(150.0)).unwrap();
    assert!(turn.impacts[0].unwrap() >= 1.0, "{:?}", turn.impacts);
    // An impact takes P²/(2m), and the drive gives that.
    let taken: f64 = turn.impulses.iter().map(|impact| impact.impulse.powi(2) / (2.0 * 0.6)).sum();
    assert_eq!(turn.impulses.len() as f64, turn.impacts[0].unwrap());
    near(turn.mean_power * turn.period, taken, 1e-6);
    let tau = turn.output("follower[1].tau").unwrap();
    assert_eq!(tau.mean, turn.mean_torque);
    // The drive gives what the impacts take.
    let mut train = DriveTrain::new(scene(150.0)).unwrap();
    train.start(0.0).unwrap();
    let list = train.variables();
    let loss = &list.0[list.reference("follower[1].energy_loss").unwrap()];
    let mut after = |turns: f64| {
        let (from, period) = (turns - 10.0, turn.period);
        train.advance(from * period, 10.0 * period).unwrap();
        loss.value(&train)
    };
    let [before, then] = [10.0, 20.0].map(&mut after);
    near(turn.mean_power * turn.period, 0.1 * (then - before), 1e-7);
}

#[test]
fn without_a_speed_there_is_no_motion() {
    let fault = turn_of(scene(Shaft::Free(machine(Source::Input)), vec![output()])).unwrap_err().to_string();
    assert!(fault.contains("w_start"), "{fault}");
    // A constant torque that balances load and friction at some speed, near which it starts.
    let started = Machine { w_start: 20.0, ..machine(Source::Constant(5.5)) };
    let turn = turn_of(scene(Shaft::Free(started), vec![])).unwrap();
    near(turn.mean_torque, 5.5, 1e-12);
    // b ω on the mean over the angle.
    let course = course(&turn);
    let mean: f64 = course.windows(2).map(|ends| 0.5 * (ends[0][1] + ends[1][1]) * (ends[1][0] - ends[0][0])).sum();
    near(mean / TAU, 15.0, 1e-6);
}

#[test]
fn the_study_leaves_out_followers_springs_clearances_and_loads() {
    let scene = scene(Shaft::Free(machine(kloss())), vec![output(), valve()]);
    let options = Options { quick: true, turns: Some(3.0), ..Options::default() };
    let report = crate::tradeoff::study(&Resource::new("train", scene), &options, &|_| {}).unwrap();
    let feature = |name: &str| report.features.iter().find(|f| f.feature == name).unwrap_or_else(|| panic!("{name}"));
    for name in [
        "follower 1",
        "follower 2",
        "the elasticity of follower 1",
        "the loads of follower 1",
        "the clearance of follower 2",
        "clearance and elasticity of follower 2",
        "the load of the shaft",
        "the friction of the shaft",
        "the transient",
    ] {
        let found = feature(name);
        assert_eq!(found.fault, None, "{name}");
        assert!(found.change.is_some_and(f64::is_finite), "{name}");
    }
    assert!(report.features.iter().all(|f| f.feature != "the loads of follower 2"));
    // Without follower 1 the other one is still compared under its own number, and nothing of the one left out.
    let without = &feature("follower 1").changes;
    assert!(without.contains_key("follower[2].force") && !without.contains_key("follower[1].force"), "{without:?}");
    // The valve never leaves its cam, so that its clearance changes nothing.
    let held = feature("the clearance of follower 2");
    assert!(held.changes["follower[2].y"] < 1e-9 && held.changes["w"] < 1e-9, "{:?}", held.changes);
}

#[test]
fn a_follower_left_out_does_not_rename_the_others_of_a_machine() {
    let rigid = |h: f64| {
        let mut follower = follower(hs(h), Joint::Rigid);
        follower.rigid.m = 2.0;
        follower
    };
    let followers = vec![rigid(0.04), rigid(0.01)];
    let names = drive_train::Names::Machine(0.0);
    let scene = drive_train::Scene { names, ..scene(Shaft::Free(machine(kloss())), followers) };
    let options = Options { quick: true, turns: Some(3.0), ..Options::default() };
    let report = crate::tradeoff::study(&Resource::new("machine", scene), &options, &|_| {}).unwrap();
    let without = &report.features.iter().find(|feature| feature.feature == "follower 1").unwrap().changes;
    assert!(without.contains_key("U[2]") && !without.contains_key("U[1]"), "{without:?}");
    // Four times the stroke of the other: taken for it, it would differ by more than its own size.
    assert!(without["U[2]"] < 0.5, "{without:?}");
}
