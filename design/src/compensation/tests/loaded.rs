//! Machines under loads and with motors of any kind, against the machine without them and the train that has them.

use super::*;
use crate::compensation::loaded::LoadedMachine;
use camdrive::drives::Drive;
use camdrive::drives::drive_train::{self, DriveTrain, Joint, Names, Shaft, Start};
use camdrive::drives::follower::load::{Load, Spring};
use camdrive::drives::shaft::motor::{self, Reference, Servo, Source, TorqueTable, Transmission};
use camdrive::motion::Polyline;

/// The machine of the task as one with these loads on its tools, and with this motor.
fn loaded(mut task: Task, source: Source, loads: [Load; 2]) -> Task {
    let followers = task.tools.iter().zip(loads).map(|(tool, load)| drive_train::Follower {
        rigid: tool.with_law(&tool.motion),
        joint: Joint::Rigid,
        load,
        roller: Load::default(),
    });
    let machine = drive_train::Machine {
        inertia: task.own.function.clone(),
        load: None,
        friction: None,
        loads: vec![],
        motor: motor::Motor { source: source.clone(), transmission: Transmission::default() },
        phi_start: 0.0,
        w_start: 0.0,
    };
    task.loaded = Some(LoadedMachine { machine, kept: Vec::new(), tools: followers.collect() });
    task.driving.motor = match source {
        Source::None => Motor::None,
        Source::Kloss(kloss) => Motor::Kloss(kloss),
        _ => Motor::Input,
    };
    task
}

fn kloss(task: &Task) -> Kloss {
    let Motor::Kloss(kloss) = task.driving.motor else { unreachable!() };
    kloss
}

const NONE: Load = Load {
    gravity: None,
    frames: Vec::new(),
    constant: None,
    spring: None,
    damping: None,
    process: None,
    input: false,
};
const UNLOADED: [Load; 2] = [NONE, NONE];

/// The largest differences of both machines' laws, as parts of the largest lift and curvature, and of their periods.
fn apart(one: &Task, other: &Task) -> [f64; 3] {
    let [one, other] = [one, other].map(|task| {
        let solution = task.solve().unwrap();
        (solution.periodic.period(), laws::of(&solution, &task.tools, 1e-8, Form::Auto).unwrap())
    });
    let mut most = [error(one.0, other.0), 0.0, 0.0];
    for (a, b) in one.1.iter().zip(&other.1) {
        for (k, n) in [(1, 0), (2, 2)] {
            let miss = |phi: f64| (a.law.at(phi).0[n] - b.law.at(phi).0[n]).abs() / b.law.bound(n);
            most[k] = (0..700).map(|i| miss(0.008_976 * f64::from(i))).fold(most[k], f64::max);
        }
    }
    most
}

#[test]
fn loads_of_nothing_leave_the_machine_as_it_is() {
    let plain = loom(2.8);
    let nothing = Load { constant: Some(0.0), spring: Some(Spring::default()), damping: Some(0.0), ..Load::default() };
    for loads in [UNLOADED, [nothing.clone(), nothing]] {
        let apart = apart(&loaded(plain.clone(), Source::Kloss(kloss(&plain)), loads), &plain);
        assert!(apart[0] < 1e-12 && apart[1] < 1e-9 && apart[2] < 1e-7, "{apart:?}");
    }
    // With a torque that lags, backwards, against a load, with a prescribed period.
    let mut lagging = loom(2.8);
    if let Motor::Kloss(kloss) = &mut lagging.driving.motor {
        (kloss.dynamics, kloss.synchronous_speed) = (Some(0.01), -kloss.synchronous_speed);
    }
    lagging.driving.load = -25.0;
    let mut prescribed = loom(2.8);
    prescribed.driving.period = Some(0.13);
    for plain in [lagging, prescribed] {
        let apart = apart(&loaded(plain.clone(), Source::Kloss(kloss(&plain)), UNLOADED), &plain);
        assert!(apart[0] < 1e-10 && apart[1] < 1e-8 && apart[2] < 1e-6, "{apart:?}");
    }
}

#[test]
fn motors_of_one_characteristic_are_one_motor() {
    let plain = loom(2.8);
    let own = kloss(&plain);
    // Points on the curve of Kloss; between them the cubic errs by some 1e-6 of the torque.
    let speeds: Vec<f64> = (0..190).map(|i| 30.0 + 0.15 * f64::from(i)).collect();
    let torques = speeds.iter().map(|w| Motor::Kloss(own).characteristic(*w)[0]).collect();
    let apart_by_table =
        apart(&loaded(plain.clone(), Source::Table(TorqueTable { speeds, torques }), UNLOADED), &plain);
    assert!(apart_by_table[0] < 1e-6 && apart_by_table[1] < 1e-5, "{apart_by_table:?}");
    // A line, by two points and by many, by a servo without integral, by a constant torque against friction.
    let line = |speeds: &[f64]| {
        let torques = speeds.iter().map(|w| 12.0 * (51.0 - w)).collect();
        Source::Table(TorqueTable { speeds: speeds.to_vec(), torques })
    };
    let by_points = loaded(plain.clone(), line(&[0.0, 100.0]), UNLOADED);
    let servo = Servo {
        proportional: 12.0,
        integral: 0.0,
        anti_windup: 0.0,
        limit: 1e4,
        reference: Reference::Constant(51.0),
        position: None,
    };
    let mut constant = loaded(plain.clone(), Source::Constant(12.0 * 51.0), UNLOADED);
    let machine = &mut constant.loaded.as_mut().unwrap().machine;
    (machine.friction, machine.w_start) = (Some(12.0), 45.0);
    let many: Vec<f64> = (0..41).map(|i| 2.5 * f64::from(i)).collect();
    for other in [loaded(plain.clone(), line(&many), UNLOADED), loaded(plain, Source::Servo(servo), UNLOADED), constant]
    {
        let apart = apart(&other, &by_points);
        assert!(apart[0] < 1e-11 && apart[1] < 1e-8 && apart[2] < 1e-6, "{apart:?}");
    }
}

/// The largest error of each tool's acceleration on the periodic motion that the train itself simulates with these laws, as part
/// of the largest wanted one, and the period.
fn simulated(task: &Task, laws: &[MotionLaw], guess: f64) -> (Vec<f64>, f64) {
    let LoadedMachine { machine, kept, tools } = task.loaded.clone().unwrap();
    let tools = tools.into_iter().zip(laws).map(|(mut tool, law)| {
        tool.rigid.cam = law.clone();
        tool
    });
    let first = kept.len();
    let scene = drive_train::Scene {
        coupling: false,
        shaft: Shaft::Free(drive_train::Machine { w_start: guess, ..machine }),
        followers: kept.into_iter().chain(tools).collect(),
        start: Start::SteadyState,
        solver: Settings { tolerance: 1e-12, ..Settings::default() },
        names: Names::Train,
    };
    let mut train = DriveTrain::new(scene).unwrap();
    let period = train.periodic_motion().unwrap().period;
    let list = train.variables();
    let places = task.tools.iter().enumerate().map(|(j, _)| {
        let name = format!("der(follower[{}].y,2)", first + j + 1);
        list.0[list.reference(&name).unwrap()].index
    });
    let (places, mut values): (Vec<usize>, _) = (places.collect(), list.places());
    let w = list.0[list.reference("w").unwrap()].index;
    let mut most = vec![0.0_f64; laws.len()];
    train.evaluate(&mut values);
    let omega = (TAU / period).copysign(values[w]);
    for i in 0..700 {
        let time = |i: i32| period * f64::from(i) / 700.0;
        train.advance(time(i), time(i + 1) - time(i)).unwrap();
        train.evaluate(&mut values);
        for ((tool, place), most) in task.tools.iter().zip(&places).zip(&mut most) {
            let wanted = omega * omega * tool.at(omega * time(i + 1))[2];
            *most = most.max((values[*place] - wanted).abs() / tool.acceleration(omega)[1]);
        }
    }
    (most, period)
}

/// A spring, a weight and a process with steps, smooth ones where `smooth`.
fn heavy(smooth: bool) -> [Load; 2] {
    let (angles, lifts) = [(0.0, 0.0), (4.0, 0.0), (4.0, -400.0), (4.6, -1500.0), (5.0, 0.0)].into_iter().unzip();
    let process = match smooth {
        true => MotionLaw::Fourier(Fourier::new(vec![-200.0, 150.0, 0.0, -60.0], vec![0.0, 80.0])),
        false => MotionLaw::Polyline(Polyline::new(Points { angles, lifts }).unwrap()),
    };
    let spring = Some(Spring { preload: 60.0, c: 900.0, at: -0.1 });
    [
        Load { spring, damping: Some(12.0), ..Load::default() },
        Load { gravity: Some(-9.81), constant: Some(35.0), process: Some(process), ..Load::default() },
    ]
}

#[test]
fn tools_move_as_prescribed_under_loads_and_with_every_motor() {
    let plain = loom(2.8);
    let table = TorqueTable { speeds: vec![0.0, 30.0, 45.0, 52.0, 60.0], torques: vec![40.0, 60.0, 50.0, 0.0, -60.0] };
    let servo = |limit: f64| Servo {
        proportional: 9.0,
        integral: 60.0,
        anti_windup: 7.0,
        limit,
        reference: Reference::Constant(104.0),
        position: None,
    };
    let lagging = Kloss { dynamics: Some(0.01), ..kloss(&plain) };
    let transmission = Transmission { ratio: 2.0, rotor: 0.04, coupling: None };
    let load = MotionLaw::Fourier(Fourier::new(vec![6.0, 3.0], vec![0.0, -4.0]));
    for (source, smooth, tolerance, ratio) in [
        (Source::Kloss(kloss(&plain)), true, 1e-6, false),
        (Source::Kloss(kloss(&plain)), false, 1e-5, false),
        (Source::Kloss(lagging), true, 1e-6, false),
        (Source::Table(table), false, 1e-5, false),
        (Source::Servo(servo(300.0)), true, 1e-6, true),
        (Source::Servo(servo(22.0)), true, 1e-5, true),
        (Source::Constant(500.0), true, 1e-6, false),
    ] {
        let friction = if let Source::Constant(_) = source { 9.0 } else { 0.2 };
        let mut task = loaded(plain.clone(), source.clone(), heavy(smooth));
        let machine = &mut task.loaded.as_mut().unwrap().machine;
        (machine.friction, machine.load, machine.w_start) = (Some(friction), Some(load.clone()), 50.0);
        if ratio {
            machine.motor.transmission = transmission;
            task.own.function.constant += 0.16;
        }
        let options = report::Options { tolerance, rounds: 0, form: Form::Auto };
        let report =
            report::study("loom", &task, options, &|_| ()).unwrap_or_else(|fault| panic!("{source:?}: {fault}"));
        let (missed, period) = simulated(&task, &report.laws, TAU / report.period);
        assert!(error(period, report.period) < 1e-7, "{source:?}: {period} {}", report.period);
        for (cut, miss) in report.cams.iter().zip(&missed) {
            assert!(cut.truncation <= tolerance && *miss <= 1.05 * cut.truncation + 1e-7, "{source:?}: {miss} {cut:?}");
        }
        // Cams for uniform speed miss, as the train has it.
        let plain: Vec<MotionLaw> = task.tools.iter().map(|tool| tool.motion.clone()).collect();
        let (missed, period) = simulated(&task, &plain, TAU / report.period);
        assert!(error(report.rounds[0].period, period) < 1e-7);
        for (miss, told) in missed.iter().zip(&report.rounds[0].tools) {
            assert!((miss / told.deviation - 1.0).abs() < 0.02 && told.deviation > 0.05, "{source:?}: {miss} {told:?}");
        }
    }
}
