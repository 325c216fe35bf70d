//! The reference cases: parameters, states and sums at the end, instants of the first events.

use super::super::*;
use crate::drives::follower::contact::{self, Mode};
use crate::drives::follower::linkage::{Branch, FourBar, Kind, Link, Linkage, Mechanism, SliderCrank};
use crate::drives::follower::load::{Load, Spring};
use crate::drives::follower::{elastic_output, elastic_shaft, rigid};
use crate::drives::shaft::free::inertia::InertiaFunction;
use crate::drives::shaft::free::motor::Kloss;
use crate::drives::shaft::motor::{Motor, Reference, Servo, Source, TorqueTable, Transmission};
use crate::motion::table::Points;
use crate::motion::{Crank, Cycle, CyclePlan, Fourier, MotionLaw, Polyline, StandardLaw};

pub(super) fn series(a: &[f64], b: &[f64]) -> MotionLaw {
    MotionLaw::Fourier(Fourier::new(a.to_vec(), [&[0.0], b].concat()))
}

fn hs(h: f64) -> MotionLaw {
    series(&[0.0, 0.5867 * h, 0.0, -0.0984 * h, 0.0, 0.0115 * h], &[])
}

fn follower(cam: MotionLaw, m: f64, joint: Joint) -> Follower {
    Follower { rigid: rigid::Follower::new(m, cam), joint, load: Load::default(), roller: Load::default() }
}

pub(super) fn output(cam: MotionLaw, [m, c, b]: [f64; 3], m_x: f64) -> Follower {
    follower(cam, 0.0, Joint::Output(elastic_output::Parameters { m, c, b }, m_x))
}

pub(super) fn shaft(cam: MotionLaw, [m, inertia, c, b]: [f64; 4]) -> Follower {
    follower(cam, 0.0, Joint::Shaft(elastic_shaft::Parameters { m, inertia, c, b }))
}

/// With m1, m2, c, b, s and e.
pub(super) fn backlash(cam: MotionLaw, numbers: [f64; 6]) -> Follower {
    let [m1, m2, c, b, s, e] = numbers;
    follower(cam, 0.0, Joint::Backlash(contact::Parameters { m1, m2, c, b, s, e }))
}

fn bl(e: f64) -> Follower {
    backlash(series(&[0.0, -0.05, 0.006], &[0.004]), [2.0, 8.0, 2000.0, 20.0, 0.002, e])
}

pub(super) fn kloss(m: f64, s: f64, w: f64, lag: Option<f64>) -> Motor {
    let source = Source::Kloss(Kloss { breakdown_torque: m, breakdown_slip: s, synchronous_speed: w, dynamics: lag });
    Motor { source, transmission: Transmission::default() }
}

pub(super) fn machine(j0: f64, [phi, w]: [f64; 2], motor: Motor) -> Machine {
    Machine {
        inertia: InertiaFunction { constant: j0, varying: None },
        load: None,
        friction: None,
        loads: vec![],
        motor,
        phi_start: phi,
        w_start: w,
    }
}

fn loaded(machine: Machine) -> Machine {
    Machine { load: Some(series(&[4.0, 1.5], &[0.8])), friction: Some(0.1), ..machine }
}

pub(super) fn scene(shaft: Shaft, followers: Vec<Follower>) -> Scene {
    Scene { coupling: false, shaft, followers, start: Start::AtRest, solver: Settings::default(), names: Names::Train }
}

/// Runs to the end in so many communication steps.
pub(super) fn run(scene: &Scene, end: f64, steps: usize, tolerance: f64) -> DriveTrain {
    let mut scene = scene.clone();
    scene.solver.tolerance = tolerance;
    let mut train = DriveTrain::of(scene);
    train.log.keep(true);
    train.begin(0.0).unwrap();
    for i in 0..steps {
        let at = |i: usize| end * i as f64 / steps as f64;
        train.go_on(at(i), at(i + 1) - at(i)).unwrap();
    }
    train
}

impl DriveTrain {
    /// φ, φ̇, the other states, ΣP … as the sheet prints them.
    pub(super) fn read(&self, name: &str) -> f64 {
        let mut y = [0.0; MOST_STATES];
        self.run.at(self.time, &mut y);
        let excitation = Excitation { time: self.time, motion: self.motion.as_ref(), inputs: &self.inputs };
        let time = Double::from(self.time);
        let phi = self.motion.map_or(Double::from(y[0]), |m| Double::from(m.at(self.time).reduced));
        let input_values = self.run.input_values(&self.train, &excitation, time, &y);
        let (f, d) = self.train.instant(&self.run.modes, phi, &y, &input_values);
        let (name, j) = name.split_at(name.find(|c: char| c.is_ascii_digit()).unwrap_or(name.len()));
        let j: usize = j.parse().unwrap_or(0);
        let at = |j: usize| self.train.layout.followers[j];
        let w = if self.motion.is_some() { input_values.shaft[0] } else { y[1] };
        let [u, u1, _] = f.cams.get(j).copied().unwrap_or_default();
        let z = if let Some(Joint::Backlash(p)) = self.train.followers.get(j).map(|f| f.joint) {
            match self.run.modes.stands[j].contact {
                Mode::Contact(flank) => [flank.pick(0.0, p.s), 0.0],
                Mode::Free => [y[at(j)] + self.run.modes.stands[j].home(p.s), y[at(j) + 1]],
            }
        } else {
            [0.0; 2]
        };
        match name {
            "phi" => y[0] + self.run.turns * TAU,
            "w" => y[1],
            "a" => d.a,
            "M" => d.torque,
            "motor" => y[self.train.layout.motor],
            "wm" => self.train.machine().unwrap().motor.speed(&y, &self.train.layout),
            "y" => u + y[at(j)],
            "v" => u1 * w + y[at(j) + 1],
            "psi" => y[0] + self.run.turns * TAU + y[at(j)],
            "psidot" => w + y[at(j) + 1],
            "xa" => u + z[0],
            "xav" => u1 * w + z[1],
            "xb" => u + z[0] + y[at(j) + 2],
            "xbv" => u1 * w + z[1] + y[at(j) + 3],
            "N" => d.followers[j].normal,
            "P" => self.run.tallies[j].impulse,
            "loss" => self.run.tallies.iter().map(|t| t.loss).sum(),
            _ => panic!("{name}"),
        }
    }
}

/// Compares the read values with the numbers.
fn check(name: &str, scene: &Scene, end: f64, expected: &[(&str, f64, f64)], events: &[f64]) {
    for (tolerance, steps, part) in [(1e-14, 3, 2e-13), (0.0, 1, 1e-9), (0.0, 7, 1e-9)] {
        let train = run(scene, end, steps, tolerance);
        for (what, value, scale) in expected {
            let read = train.read(what);
            let error = (read - value).abs() / scale.max(value.abs());
            assert!(error <= part, "{name} {tolerance} {steps} {what}: {read} {value} {error:e}");
        }
        if steps == 1 {
            let found: Vec<f64> = train.log.iter().map(|event| event.time).collect();
            for (found, event) in found.iter().zip(events) {
                assert!((found - event).abs() <= 1e-9 * event, "{name}: {found} {event}");
            }
            assert!(found.len() >= events.len(), "{name}: {found:?}");
        }
    }
    estimate(name, scene, end);
}

/// The estimated error covers the error of all states, and is not far above the tolerance unless two followers chatter at once.
fn estimate(name: &str, scene: &Scene, end: f64) {
    let states = |train: &DriveTrain| {
        let mut y = [0.0; MOST_STATES];
        train.run.at(train.time, &mut y);
        y[0] += train.run.turns * TAU;
        y
    };
    let exact = states(&run(scene, end, 3, 1e-14));
    for tolerance in [1e-6, 1e-8, 1e-10, 1e-12] {
        let train = run(scene, end, 3, tolerance);
        let sizes = train.run.errors.sizes.iter();
        let error =
            states(&train).iter().zip(&exact).zip(sizes).fold(0.0_f64, |most, ((a, b), s)| most.max((a - b).abs() / s));
        let estimate = train.run.error;
        assert!(error <= estimate + 4e-16, "{name} {tolerance}: {error:e}, estimated {estimate:e}");
        assert!(estimate <= 100.0 * tolerance || name == "two_contacts", "{name} {tolerance}: estimated {estimate:e}");
    }
}

#[test]
fn outputs() {
    let train = Shaft::Free(loaded(machine(0.9, [0.0, 0.0], kloss(60.0, 0.2, 15.0, Some(0.02)))));
    let f0 = output(hs(0.04), [3.0, 12000.0, 20.0], 0.0);
    let f1 = output(series(&[0.0, -0.03, 0.004], &[0.0, 0.002]), [1.2, 9000.0, 6.0], 0.4);
    check(
        "outputs",
        &scene(train, vec![f0, f1]),
        1.2,
        &[
            ("phi", 13.8278766955171, 1.0),
            ("w", 14.807108164271, 1.0),
            ("M", 7.58171059300451, 1.0),
            ("y0", 0.0130308905717516, 0.02),
            ("v0", -0.48402215440047, 0.5),
            ("y1", -0.0117638731780698, 0.02),
            ("v1", 0.303481563256041, 0.5),
        ],
        &[],
    );
}

#[test]
fn elastic_shaft_in_a_train() {
    let train = Shaft::Free(Machine {
        load: Some(series(&[3.0], &[])),
        ..machine(0.5, [0.0, 8.0], kloss(60.0, 0.2, 15.0, None))
    });
    check(
        "shaft",
        &scene(train, vec![shaft(hs(0.1), [40.0, 0.15, 900.0, 1.5])]),
        1.0,
        &[
            ("phi", 14.4464441927694, 1.0),
            ("w", 13.656989420565, 1.0),
            ("psi0", 14.4226887548618, 1.0),
            ("psidot0", 17.5454717952993, 1.0),
            ("M", 44.7517812647158, 1.0),
        ],
        &[],
    );
}

fn backlash_train(e: f64) -> Scene {
    scene(Shaft::Free(machine(0.8, [0.3, 12.0], kloss(60.0, 0.2, 15.0, None))), vec![bl(e)])
}

#[test]
fn backlash_without_restitution() {
    check(
        "backlash_e0",
        &backlash_train(0.0),
        0.8,
        &[
            ("phi", 12.1109947192104, 1.0),
            ("w", 14.9492071279756, 1.0),
            ("xa0", -0.041676130728845, 0.05),
            ("xav0", -0.312015869770759, 1.0),
            ("xb0", -0.0377022485695266, 0.05),
            ("xbv0", -3.02550743744194, 1.0),
            ("P0", -0.580565103219888, 1.0),
            ("loss", 0.269066190019219, 0.3),
        ],
        &[0.172203264386481, 0.195433264478715, 0.373242680038908],
    );
}

#[test]
fn backlash_with_restitution() {
    check(
        "backlash_e06",
        &backlash_train(0.6),
        0.5,
        &[
            ("phi", 7.67859937878697, 1.0),
            ("w", 14.7598301968251, 1.0),
            ("xa0", -0.0104202491682276, 0.05),
            ("xav0", 0.676111562607312, 1.0),
            ("xb0", -0.135661235633522, 0.05),
            ("xbv0", 0.725520462320645, 1.0),
            ("P0", 0.404462646821003, 1.0),
            ("loss", 0.170034933866405, 0.3),
        ],
        &[0.172203264386481, 0.195433264478715, 0.206145615119258],
    );
}

#[test]
fn two_contacts() {
    let f1 = backlash(series(&[0.0, 0.03, 0.004], &[0.02]), [1.0, 3.0, 4000.0, 10.0, 0.003, 0.3]);
    let train = Shaft::Free(machine(0.05, [0.2, 9.0], kloss(40.0, 0.25, 11.0, None)));
    check(
        "two_contacts",
        &scene(train, vec![bl(0.0), f1]),
        0.8,
        &[
            ("phi", 8.965211991447, 1.0),
            ("w", 11.1201712017026, 1.0),
            ("xa0", 0.0522255549703481, 0.05),
            ("xav0", 0.312853587955346, 1.0),
            ("xb0", 0.101369889441858, 0.05),
            ("xbv0", 0.398048682532783, 1.0),
            ("xa1", -0.0155416485286587, 0.05),
            ("xb1", -0.016012680127485, 0.05),
            ("P0", -0.29695678411244, 1.0),
            ("P1", 0.0115756025634132, 1.0),
            ("loss", 0.261195820316068, 0.3),
        ],
        &[0.00163552897403256, 0.0362787773881733, 0.0364585928013257],
    );
}

#[test]
fn servo_and_rigid_follower() {
    let servo = Servo {
        proportional: 2.0,
        integral: 30.0,
        anti_windup: 15.0,
        limit: 5.0,
        reference: Reference::Ramp(60.0),
        position: None,
    };
    let motor = Motor { source: Source::Servo(servo), transmission: Transmission::default() };
    let train = Shaft::Free(Machine { friction: Some(0.02), ..machine(0.05, [0.0, 0.0], motor) });
    let mut f1 = follower(series(&[0.0, 0.03], &[0.01]), 0.8, Joint::Rigid);
    f1.load.gravity = Some(-9.81);
    let f0 = output(hs(0.06), [1.5, 6000.0, 8.0], 0.0);
    check(
        "servo",
        &scene(train, vec![f0, f1]),
        0.6,
        &[
            ("phi", 10.4103491430712, 1.0),
            ("w", 35.1597518256837, 1.0),
            ("motor", 4.79749884524076, 1.0),
            ("y0", -0.0414399853736773, 0.05),
            ("v0", 2.26683364617827, 1.0),
            ("M", 5.0, 1.0),
        ],
        &[0.388079903331848, 0.496867260950225, 0.525533807969804],
    );
}

pub(super) fn spring_and_weight() -> Load {
    Load { gravity: Some(-9.81), spring: Some(Spring { preload: 90.0, c: 2500.0, at: 0.0 }), ..Load::default() }
}

pub(super) fn lift_cam() -> MotionLaw {
    series(&[0.0, -0.008, 0.0009], &[0.0, 0.0004])
}

#[test]
fn lift_off() {
    for (e, end, expected, events) in [
        (
            0.0,
            0.12,
            &[
                ("xa0", -0.00104578396142975, 0.01),
                ("xav0", 1.21137885810118, 1.0),
                ("P0", 3.56410465517052, 1.0),
                ("loss", 3.52856722028004, 1.0),
                ("N0", 157.33790870028, 100.0),
            ][..],
            &[0.0149809141665695, 0.0338163761054477, 0.0519408277382142][..],
        ),
        (
            0.4,
            0.08,
            &[
                ("xa0", -0.00417020238712716, 0.01),
                ("xav0", 0.822764923843696, 1.0),
                ("P0", 5.31685563160855, 1.0),
                ("loss", 2.28274775169493, 1.0),
            ],
            &[0.0149809141665695, 0.0338163761054477, 0.0393377674304742],
        ),
    ] {
        let mut f = backlash(lift_cam(), [0.6, 0.0, 0.0, 0.0, f64::INFINITY, e]);
        f.roller = spring_and_weight();
        let driven = Shaft::Driven(DriveMode::Constant { w: 170.0, phi_start: 0.0 });
        check("lift", &scene(driven, vec![f]), end, expected, events);
    }
}

fn lifting_train(cam: MotionLaw) -> Scene {
    let mut f = backlash(cam, [0.15, 0.5, 4e5, 60.0, f64::INFINITY, 0.0]);
    (f.load, f.roller) = (spring_and_weight(), Load { gravity: Some(-9.81), ..Load::default() });
    scene(Shaft::Free(machine(0.012, [0.0, 150.0], kloss(12.0, 0.2, 190.0, None))), vec![f])
}

#[test]
fn lift_off_in_a_train() {
    check(
        "lift_train",
        &lifting_train(lift_cam()),
        0.15,
        &[
            ("phi", 27.3275139327169, 1.0),
            ("w", 187.973388254063, 1.0),
            ("xa0", 0.00400926187986684, 0.01),
            ("xav0", 1.49357790730632, 1.0),
            ("xb0", -0.00100671474653625, 0.01),
            ("xbv0", -1.66374826495584, 1.0),
            ("N0", 2185.02631200945, 100.0),
            ("P0", 2.57950158029862, 1.0),
            ("loss", 5.46454785766229, 1.0),
        ],
        &[0.0174073815901246, 0.0359830450421741, 0.0397358679752581],
    );
}

fn cycle(stroke: f64, rise: StandardLaw, fall: StandardLaw) -> MotionLaw {
    let deg = |x: f64| x.to_radians();
    MotionLaw::Cycle(Cycle::new(CyclePlan {
        stroke,
        lower: 0.0,
        rise_start: deg(20.0),
        rise_angle: deg(120.0),
        upper_dwell: deg(60.0),
        return_angle: deg(100.0),
        rise_law: rise,
        return_law: fall,
        inflections: [None; 2],
    }))
}

#[test]
fn laws_in_pieces() {
    let cam = cycle(0.05, StandardLaw::Polynomial345, StandardLaw::ModifiedSine);
    let train = Shaft::Free(loaded(machine(0.9, [0.0, 8.0], kloss(60.0, 0.2, 15.0, None))));
    check(
        "cycle_output",
        &scene(train, vec![output(cam, [3.0, 12000.0, 20.0], 0.0)]),
        1.0,
        &[
            ("phi", 14.3707017235595, 1.0),
            ("w", 14.8172596781298, 1.0),
            ("y0", 0.0428991875930361, 0.05),
            ("a", 2.40549189116252, 10.0),
        ],
        &[],
    );
    let cam = cycle(0.012, StandardLaw::Polynomial345, StandardLaw::ModifiedSine);
    check(
        "cycle_lift",
        &lifting_train(cam),
        0.06,
        &[
            ("phi", 10.3695355395108, 1.0),
            ("w", 186.144498473369, 1.0),
            ("xa0", 0.0230156630726504, 0.01),
            ("xb0", 0.0229873644595581, 0.01),
            ("P0", 0.700125401900597, 1.0),
        ],
        &[0.00982595414022469, 0.0321415720175391],
    );
    let cam = cycle(0.012, StandardLaw::ModifiedSine, StandardLaw::SimpleSine);
    let mut jump = lifting_train(cam);
    let mut f = backlash(jump.followers[0].rigid.cam.clone(), [0.6, 0.0, 0.0, 0.0, f64::INFINITY, 0.0]);
    f.roller = spring_and_weight();
    jump.followers = vec![f];
    check(
        "cycle_jump",
        &jump,
        0.06,
        &[
            ("phi", 10.3809898350756, 1.0),
            ("w", 186.569206067487, 1.0),
            ("xa0", 0.0120355536220479, 0.01),
            ("xav0", -1.17478565847836, 1.0),
            ("a", 179.108153567633, 100.0),
            ("P0", 1.76701118913267, 1.0),
        ],
        &[0.0108028171810113, 0.0215266137842262, 0.0218015307208838, 0.0327214886227547],
    );
}

#[test]
fn transmissions() {
    let out = || vec![output(hs(0.04), [3.0, 12000.0, 20.0], 0.0)];
    let mut motor = kloss(20.0, 0.2, 45.0, Some(0.02));
    motor.transmission = Transmission { ratio: 3.0, rotor: 0.02, coupling: None };
    let stiff = Shaft::Free(loaded(machine(0.9, [0.0, 0.0], motor.clone())));
    check(
        "ratio",
        &scene(stiff, out()),
        1.0,
        &[
            ("phi", 10.0922403819822, 1.0),
            ("w", 14.9058111771265, 1.0),
            ("motor", 1.27879940720284, 1.0),
            ("y0", -0.0229874795760311, 0.03),
            ("v0", -0.087523207959432, 0.5),
        ],
        &[],
    );
    motor.transmission.coupling = Some([800.0, 1.2]);
    let elastic = Shaft::Free(loaded(machine(0.9, [0.0, 0.0], motor)));
    check(
        "coupling",
        &scene(elastic, out()),
        1.0,
        &[
            ("phi", 10.1915651103953, 1.0),
            ("w", 14.8999130490062, 1.0),
            ("wm", 44.7338911652578, 1.0),
            ("motor", 1.13225359763961, 1.0),
            ("y0", -0.0236275145019588, 0.03),
        ],
        &[],
    );
    let servo = Servo {
        proportional: 0.5,
        integral: 8.0,
        anti_windup: 16.0,
        limit: 2.5,
        reference: Reference::Ramp(200.0),
        position: None,
    };
    let transmission = Transmission { ratio: 4.0, rotor: 0.002, coupling: Some([300.0, 0.4]) };
    let motor = Motor { source: Source::Servo(servo), transmission };
    let train = Shaft::Free(Machine { friction: Some(0.02), ..machine(0.06, [0.0, 0.0], motor) });
    check(
        "coupling_servo",
        &scene(train, vec![output(hs(0.06), [1.5, 6000.0, 8.0], 0.0)]),
        0.6,
        &[
            ("phi", 8.89631396151544, 1.0),
            ("w", 29.822219952184, 1.0),
            ("wm", 111.61964062816, 1.0),
            ("motor", 1.70506406523555, 1.0),
            ("y0", -0.044692077691738, 0.05),
        ],
        &[0.44640342878606, 0.462506326134282, 0.577280978758409],
    );
}

#[test]
fn torque_table() {
    let table = TorqueTable {
        speeds: vec![0.0, 5.0, 10.0, 13.0, 15.0, 18.0],
        torques: vec![40.0, 46.0, 60.0, 45.0, 0.0, -50.0],
    };
    assert!((table.torque(table.piece(7.0), 7.0) - 52.1376).abs() < 1e-12);
    assert!((table.torque(table.piece(14.0), 14.0) - 25.1991676036).abs() < 1e-9);
    let motor = Motor { source: Source::Table(table), transmission: Transmission::default() };
    let train = Shaft::Free(loaded(machine(0.9, [0.0, -2.0], motor)));
    check(
        "table",
        &scene(train, vec![output(hs(0.04), [3.0, 12000.0, 20.0], 0.0)]),
        1.2,
        &[
            ("phi", 14.4128498816335, 1.0),
            ("w", 14.6945826138407, 1.0),
            ("y0", -0.0106699374670167, 0.03),
            ("M", 6.73073868449789, 1.0),
        ],
        &[],
    );
}

#[test]
fn servo_with_a_position_loop() {
    let reference = Reference::Series(10.0, Fourier::new(vec![20.0, 2.0], vec![0.0, 6.0, -3.0]));
    let servo =
        Servo { proportional: 2.0, integral: 30.0, anti_windup: 15.0, limit: 5.0, reference, position: Some(12.0) };
    let motor = Motor { source: Source::Servo(servo), transmission: Transmission::default() };
    let train = Shaft::Free(Machine { friction: Some(0.02), ..machine(0.05, [0.3, 0.0], motor) });
    let mut f1 = follower(series(&[0.0, 0.03], &[0.01]), 0.8, Joint::Rigid);
    f1.load.gravity = Some(-9.81);
    let f0 = output(hs(0.06), [1.5, 6000.0, 8.0], 0.0);
    check(
        "servo_position",
        &scene(train, vec![f0, f1]),
        0.9,
        &[
            ("phi", 19.5141609115616, 1.0),
            ("w", 25.4022388660357, 1.0),
            ("motor", 1.10503059154198, 1.0),
            ("y0", 0.028339016666652, 0.05),
            ("M", -4.7569001120377, 1.0),
        ],
        &[0.394820137781703, 0.40815455817346, 0.536083569307699],
    );
}

#[test]
fn loads() {
    let load = Load {
        gravity: Some(-9.81),
        spring: Some(Spring { preload: 40.0, c: 3000.0, at: 0.01 }),
        damping: Some(15.0),
        process: Some(series(&[0.0, 20.0, -12.0], &[7.0, 0.0, 3.0])),
        ..Load::default()
    };
    let driven = |w: f64, phi_start: f64| Shaft::Driven(DriveMode::Constant { w, phi_start });
    let mut f = output(hs(0.06), [2.0, 20000.0, 16.0], 0.0);
    f.load = load.clone();
    check(
        "load_output",
        &scene(driven(14.0, 0.0), vec![f]),
        0.9,
        &[("y0", 0.025163614349626, 0.03), ("v0", 0.0122018586467936, 0.5)],
        &[],
    );
    let mut f = shaft(hs(0.06), [25.0, 0.1, 1200.0, 1.0]);
    f.load = load.clone();
    check("load_shaft", &scene(driven(14.0, 0.0), vec![f]), 0.9, &[("psidot0", 12.1665048428263, 1.0)], &[]);
    let mut f = bl(0.0);
    f.load = Load { spring: None, ..load };
    f.roller.gravity = Some(-9.81);
    check(
        "load_backlash",
        &scene(driven(20.0, 0.3), vec![f]),
        0.6,
        &[
            ("xa0", -0.0421210497716215, 0.05),
            ("xav0", -0.0641580002411233, 1.0),
            ("xb0", 0.0164851868472915, 0.05),
            ("xbv0", -1.10757361983927, 1.0),
            ("N0", -53.8317409201792, 100.0),
            ("P0", -0.363483794278535, 1.0),
            ("loss", 0.136796760191905, 0.2),
        ],
        &[0.204489952473781, 0.241096885986446, 0.255603389272205],
    );
}

#[test]
fn limits_of_the_inertia() {
    let free = |j: f64| Shaft::Free(machine(j, [0.3, 12.0], Motor::default()));
    check(
        "limit_J1e3",
        &scene(free(1e3), vec![bl(0.0)]),
        0.5,
        &[
            ("phi", 6.29974583316266, 1.0),
            ("w", 11.9988841844925, 1.0),
            ("xa0", -0.0439301955164329, 0.05),
            ("xbv0", -0.684553020165588, 1.0),
            ("N0", 183.117667008545, 100.0),
            ("P0", 0.101837207554947, 1.0),
        ],
        &[0.196614639181846, 0.222741057813247, 0.4162661940736],
    );
    check(
        "limit_J1e6",
        &scene(free(1e6), vec![bl(0.0)]),
        0.5,
        &[
            ("phi", 6.29999974582461, 1.0),
            ("w", 11.9999988841159, 1.0),
            ("xbv0", -0.684475121326587, 1.0),
            ("P0", 0.101844825018883, 1.0),
        ],
        &[0.196613873508329, 0.222740048228233],
    );
    let driven = Shaft::Driven(DriveMode::Constant { w: 12.0, phi_start: 0.3 });
    check(
        "limit_Jinf",
        &scene(driven, vec![bl(0.0)]),
        0.5,
        &[
            ("xa0", -0.0439290687042273, 0.05),
            ("xav0", 0.0532398360371701, 1.0),
            ("xb0", -0.124384171438714, 0.1),
            ("xbv0", -0.684475043337435, 1.0),
            ("N0", 183.135005952045, 100.0),
            ("P0", 0.101844832643523, 1.0),
            ("loss", 0.126531666236793, 0.2),
        ],
        &[0.196613872741871, 0.222740047217622, 0.416262964786004],
    );
}

#[test]
fn periodic_motion() {
    let mut f = output(hs(0.04), [3.0, 12000.0, 20.0], 0.0);
    f.load.gravity = Some(-9.81);
    let shaft = Shaft::Free(loaded(machine(0.9, [0.0, 0.0], kloss(60.0, 0.2, 15.0, None))));
    let train = Scene { start: Start::SteadyState, ..scene(shaft, vec![f]) };
    let begun = run(&train, 1.0, 0, 0.0);
    for (what, value) in [("w", 14.834951322737), ("y0", 0.013661175937604), ("v0", 0.014547572202273)] {
        assert!((begun.read(what) - value).abs() < 1e-12, "{what}: {}", begun.read(what));
    }
    let [period, multiplier] = begun.run.period;
    assert!((period - 0.422775956727908).abs() < 1e-13, "{period}");
    let printed = 0.0023514211761_f64.hypot(0.2407085147409);
    assert!((multiplier - printed).abs() < 1e-9 * printed, "{multiplier} {printed}");
}

#[test]
fn a_follower_that_stays_on_its_flank_has_a_periodic_motion() {
    // Without the clearance it is an elastic output with m1 on the cam's side.
    let [m1, m2, c, b] = [0.2, 1.5, 40000.0, 30.0];
    let spring = Spring { preload: 900.0, c: 2500.0, at: 0.0 };
    let shaft = || Shaft::Free(machine(0.9, [0.0, 0.0], kloss(60.0, 0.2, 15.0, None)));
    let parameters = contact::Parameters { m1, m2, c, b, s: f64::INFINITY, e: 0.3 };
    let mut leaving = follower(hs(0.02), 0.0, Joint::Backlash(parameters));
    let mut staying = output(hs(0.02), [m2, c, b], m1);
    (leaving.load.spring, staying.load.spring) = (Some(spring), Some(spring));
    let [one, other] =
        [leaving, staying].map(|f| DriveTrain::new(scene(shaft(), vec![f])).unwrap().periodic_motion().unwrap());
    assert!((one.period - other.period).abs() < 1e-11 * other.period, "{} {}", one.period, other.period);
    assert!((one.multiplier - other.multiplier).abs() < 1e-8, "{} {}", one.multiplier, other.multiplier);
}

fn lines(points: &[[f64; 2]]) -> MotionLaw {
    let (angles, lifts) = points.iter().map(|[angle, value]| (angle.to_radians(), *value)).unzip();
    MotionLaw::Polyline(Polyline::new(Points { angles, lifts }).unwrap())
}

/// A servo that drives a slider-crank on the shaft.
pub(super) fn press_scene() -> Scene {
    let servo = Servo {
        proportional: 3.0,
        integral: 12.0,
        anti_windup: 4.0,
        limit: 60.0,
        reference: Reference::Constant(96.0),
        position: None,
    };
    let transmission = Transmission { ratio: 8.0, rotor: 0.03, coupling: None };
    let motor = Motor { source: Source::Servo(servo), transmission };
    let crank = SliderCrank {
        crank: Link { length: 0.08, mass: 8.0, inertia: 0.05, centre: [0.02, 0.0] },
        rod: Link { length: 0.5, mass: 12.0, inertia: 0.35, centre: [0.2, 0.01] },
        offset: 0.01,
        slider_mass: 0.0,
        branch: Branch::Plus,
    };
    let mechanism = Mechanism { kind: Kind::SliderCrank(crank), input_offset: 0.0, output_offset: 0.0 };
    let mut f = follower(MotionLaw::Crank(Crank { offset: 0.0 }), 40.0, Joint::Rigid);
    f.rigid.linkage = Linkage(vec![mechanism]);
    f.load.gravity = Some(9.81);
    f.load.frames = vec![[9.81, 0.0]];
    f.load.process =
        Some(lines(&[[0.0, 0.0], [330.0, 0.0], [330.0, -20000.0], [345.0, -90000.0], [356.0, -90000.0], [360.0, 0.0]]));
    scene(Shaft::Free(machine(60.0, [3.0, 12.0], motor)), vec![f])
}

#[test]
fn press() {
    let train = press_scene();
    check(
        "press",
        &train,
        0.78,
        &[
            ("phi", 12.2031365166528, 1.0),
            ("w", 12.0060868002694, 1.0),
            ("motor", 15.0588944013349, 1.0),
            ("a", -32.1190434213295, 100.0),
        ],
        &[],
    );
}

#[test]
fn four_bar() {
    let mut motor = kloss(20.0, 0.2, 30.0, None);
    motor.transmission = Transmission { ratio: 2.0, rotor: 0.004, coupling: None };
    let link = |length, mass, inertia, centre| Link { length, mass, inertia, centre };
    let four_bar = FourBar {
        ground: 0.21,
        input: link(0.04, 0.35, 0.0003, [0.02, 0.0]),
        coupler: link(0.2, 0.55, 0.0024, [0.1, 0.006]),
        output: link(0.12, 0.6, 0.0009, [0.06, 0.0]),
        branch: Branch::Plus,
    };
    let mechanism = Mechanism { kind: Kind::FourBar(four_bar), input_offset: 0.0, output_offset: 0.0 };
    let mut f = follower(MotionLaw::Crank(Crank { offset: 0.4 }), 0.03, Joint::Rigid);
    f.rigid.turns = true;
    f.rigid.linkage = Linkage(vec![mechanism]);
    f.load.frames = vec![[0.0, -9.81]];
    f.load.process = Some(lines(&[
        [0.0, -2.0],
        [90.0, -2.0],
        [150.0, -14.0],
        [200.0, -14.0],
        [200.0, 3.0],
        [300.0, 1.0],
        [360.0, -2.0],
    ]));
    let shaft = Machine { friction: Some(0.05), ..machine(0.15, [0.0, 6.0], motor) };
    check(
        "four_bar",
        &scene(Shaft::Free(shaft), vec![f]),
        0.8,
        &[("phi", 11.7260129350849, 1.0), ("w", 14.9649700303409, 1.0), ("a", 1.51610273279994, 10.0)],
        &[],
    );
}

#[test]
fn equilibrium() {
    let load = lines(&[[0.0, 5.0], [70.0, 5.0], [110.0, 25.0], [110.0, 8.0], [250.0, 2.0], [360.0, 5.0]]);
    let shaft_of =
        Machine { load: Some(load), friction: Some(0.3), ..machine(0.5, [0.7, 0.0], kloss(60.0, 0.2, 15.0, None)) };
    let weight = || Load { gravity: Some(-9.81), ..Load::default() };
    let mut f0 = output(hs(0.04), [3.0, 4000.0, 20.0], 0.0);
    f0.load = Load { spring: Some(Spring { preload: 40.0, c: 3000.0, at: 0.01 }), ..weight() };
    let mut f1 = shaft(hs(0.1), [40.0, 0.15, 900.0, 1.5]);
    f1.load = weight();
    let mut f2 = backlash(lift_cam(), [0.3, 1.5, 40000.0, 30.0, f64::INFINITY, 0.0]);
    (f2.load, f2.roller) = (spring_and_weight(), weight());
    let train = Scene { start: Start::Equilibrium, ..scene(Shaft::Free(shaft_of), vec![f0, f1, f2]) };
    let begun = run(&train, 0.6, 0, 0.0);
    for (what, value) in [("y0", 0.00551321179585351), ("psi1", 0.704616882879973), ("xb2", -0.00770772910839558)] {
        assert!((begun.read(what) - value).abs() < 1e-15, "{what}: {}", begun.read(what));
    }
    check(
        "equilibrium",
        &train,
        0.6,
        &[
            ("phi", 7.09468338889146, 1.0),
            ("w", 14.560863727945, 1.0),
            ("y0", 0.00772453385195597, 0.01),
            ("psi1", 7.07066910703799, 1.0),
            ("xb2", -0.00732996080974156, 0.01),
            ("N2", 90.2940559076064, 100.0),
        ],
        &[],
    );
}

#[test]
fn the_log_tells_once_of_each_follower_whose_cam_begins_to_pull() {
    let held = |mut f: Follower, preload: f64| {
        f.load.spring = Some(Spring { preload, c: 2500.0, at: 0.0 });
        f
    };
    let followers = |preload: f64| {
        vec![
            held(follower(hs(0.02), 0.6, Joint::Rigid), preload),
            held(output(hs(0.02), [0.6, 1e6, 20.0], 0.0), preload),
            held(shaft(hs(0.02), [0.6, 0.1, 1e4, 2.0]), preload),
            output(hs(0.02), [0.6, 1e6, 20.0], 0.0),
            held(backlash(hs(0.02), [0.2, 0.4, 1e6, 20.0, f64::INFINITY, 0.0]), preload),
        ]
    };
    let told = |preload: f64| {
        let driven = Shaft::Driven(DriveMode::Constant { w: 100.0, phi_start: 0.0 });
        let mut train = run(&scene(driven, followers(preload)), 0.0, 0, 0.0);
        let mut told = Vec::new();
        for n in 0..200 {
            train.log.clear();
            train.go_on(f64::from(n) * 1e-3, 1e-3).unwrap();
            told.extend(train.log.iter().filter(|e| e.kind.contains("[follower.backlash]")).map(|e| e.follower));
        }
        told.sort_unstable();
        told
    };
    assert_eq!(told(30.0), [1, 2, 3]);
    assert_eq!(told(3000.0), [0; 0]);
}

#[test]
fn energy_over_a_thousand_turns() {
    // A constant torque drives and only impacts dissipate: E + Σ losses − M (φ − φ₀) is constant.
    let torque = 0.2;
    let motor = Motor { source: Source::Constant(torque), transmission: Transmission::default() };
    let (c0, c1) = (2000.0, 9000.0);
    let bouncing = backlash(series(&[0.0, -0.05, 0.006], &[0.004]), [2.0, 8.0, c0, 0.0, 0.002, 0.3]);
    let elastic = output(hs(0.02), [1.2, c1, 0.0], 0.0);
    let scene = scene(Shaft::Free(machine(0.8, [0.3, 12.0], motor)), vec![bouncing, elastic]);
    let mut train = DriveTrain::of(scene);
    train.begin(0.0).unwrap();
    let energy = |train: &DriveTrain| {
        let mut y = [0.0; MOST_STATES];
        train.run.at(train.time, &mut y);
        let q = [y[train.train.layout.followers[0] + 2], y[train.train.layout.followers[1]]];
        let square = |name: &str| train.read(name).powi(2);
        let kinetic = 0.8 * square("w") + 2.0 * square("xav0") + 8.0 * square("xbv0") + 1.2 * square("v1");
        0.5 * (kinetic + c0 * q[0] * q[0] + c1 * q[1] * q[1])
    };
    let (before, start) = (energy(&train), train.read("phi"));
    let mut largest = 0.0_f64;
    while train.read("phi") - start < 1000.0 * TAU {
        train.go_on(train.time, 0.5).unwrap();
        let work = torque * (train.read("phi") - start);
        let left = energy(&train) + train.read("loss") - work - before;
        largest = largest.max(left.abs() / (before + work));
    }
    // It is chaotic: its losses depend on roundings.
    assert!(train.run.tallies[0].impacts > 1000.0 && train.read("loss") > 100.0);
    assert!(largest < 1e-9, "{largest:e}");
}

#[test]
fn saved_and_restored_in_chatter() {
    // Two followers bounce at once; each copy, read back from its bytes, goes on to the last bit.
    let one = bl(0.0);
    let other = backlash(series(&[0.0, 0.03, 0.004], &[0.02]), [1.0, 3.0, 4000.0, 10.0, 0.003, 0.3]);
    let scene = scene(Shaft::Free(machine(0.05, [0.2, 9.0], kloss(40.0, 0.25, 11.0, None))), vec![one, other]);
    let mut train = DriveTrain::of(scene);
    train.begin(0.0).unwrap();
    let (mut impacts, mut in_flight) = (0.0, 0);
    for i in 0..400 {
        let bytes = postcard::to_stdvec(&train).unwrap();
        let mut copy: DriveTrain = postcard::from_bytes(&bytes).unwrap();
        copy.restored(&train).unwrap();
        let (time, step) = (2e-4 * f64::from(i), 2e-4);
        train.go_on(time, step).unwrap();
        copy.go_on(time, step).unwrap();
        assert_eq!(postcard::to_stdvec(&train).unwrap(), postcard::to_stdvec(&copy).unwrap(), "{time}");
        impacts = train.run.tallies[1].impacts;
        in_flight += i32::from(train.run.modes.stands[1].contact == Mode::Free);
    }
    assert!(impacts > 20.0 && in_flight > 20, "{impacts} {in_flight}");
}

#[test]
fn a_stiff_output_is_rigid() {
    let free = || Shaft::Free(machine(0.9, [0.0, 10.0], kloss(60.0, 0.2, 15.0, None)));
    let rigid = run(&scene(free(), vec![follower(hs(0.04), 3.0, Joint::Rigid)]), 0.1, 1, 0.0);
    // D = 1: the transient of the start dies away at once.
    let c: f64 = 1e12;
    let stiff = run(&scene(free(), vec![output(hs(0.04), [3.0, c, 2.0 * (3.0 * c).sqrt()], 0.0)]), 0.1, 1, 0.0);
    for (name, size) in [("phi", 1.3), ("w", 14.8), ("a", 100.0)] {
        let difference = (rigid.read(name) - stiff.read(name)).abs() / size;
        assert!(difference < 1e-9, "{name}: {difference:e}");
    }
}

#[test]
fn the_estimate_counts_the_step_that_is_not_yet_left() {
    let f0 = output(hs(0.04), [3.0, 12000.0, 20.0], 0.0);
    let of = scene(Shaft::Free(machine(0.9, [0.0, 8.0], kloss(60.0, 0.2, 15.0, Some(0.02)))), vec![f0]);
    let train = run(&of, 1e-4, 1, 1e-3);
    assert!(train.run.error == 0.0 && train.run.ahead > 0.0, "{:e} {:e}", train.run.error, train.run.ahead);
    let mut values = vec![0.0; 200];
    train.evaluate(&mut values);
    assert!(values.contains(&train.run.ahead));
}
