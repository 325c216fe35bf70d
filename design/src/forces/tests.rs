use super::turn::State;
use super::*;
use crate::cam_geometry::{Carrier as Held, Cut, Limits, Second, Start};
use camdrive::drives::rigid_machine::linkage::{Branch, FourBar, Gear, Kind, Link, Mechanism, SliderCrank};
use camdrive::motion::{Cycle, CyclePlan, Fourier, StandardLaw};
use std::f64::consts::TAU;

fn series(a: &[f64], b: &[f64]) -> MotionLaw {
    MotionLaw::Fourier(Fourier::new(a.to_vec(), [&[0.0], b].concat()))
}

fn constant(value: f64) -> Option<MotionLaw> {
    Some(series(&[value], &[]))
}

fn bar(length: f64, mass: f64) -> Link {
    Link { length, mass, inertia: mass * length * length / 12.0, centre: [0.5 * length, 0.0] }
}

fn steel(width: f64) -> Option<Material> {
    Some(Material { width, elasticity: [210e9; 2], poisson: [0.3; 2] })
}

fn plan(carrier: Held, angular: bool, start: f64, sense: f64, roller: f64, cut: Cut) -> Option<Plan> {
    let limits = Limits { pressure: 1.0, cutter: 0.0, hub: 0.0 };
    Some(Plan { carrier, angular, start: Start::Coordinate(start), sense, roller, cut, limits })
}

fn lever(pivot: f64, length: f64, transmission: f64, side: f64) -> Held {
    Held::Lever { pivot, length, transmission, side }
}

fn machine(speed: f64, follower: Follower, plan: Option<Plan>, loads: Loads) -> Machine {
    let drive = Drive::new("x".to_owned(), follower, plan, loads).expect("the cam can be placed");
    Machine { name: "x".to_owned(), speed, inertia: None, drives: vec![drive] }.settled().expect("a turn")
}

fn part(kind: Kind, input_offset: f64) -> Mechanism {
    Mechanism { kind, input_offset, output_offset: 0.0 }
}

/// A translating follower with a return spring.
fn valve(speed: f64, stiffness: f64) -> Machine {
    let law = series(&[0.010, -0.0085, -0.0015], &[0.0, 0.0004]);
    let plan = plan(Held::Translating { eccentricity: 0.006 }, false, 0.055, 1.0, 0.016, Cut::Inner);
    let loads = Loads {
        gravity: vec![Point::from(-9.81)],
        spring: Some(Spring { preload: 260.0, stiffness, at: Some(0.0) }),
        process: constant(-40.0),
        material: steel(0.012),
        ..Loads::default()
    };
    machine(speed, Follower::new(1.8, law), plan, loads)
}

/// A roller lever before a four-bar linkage.
fn rocker() -> Machine {
    let law = series(&[0.26, -0.22, -0.04], &[0.0, 0.015]);
    let coupler = Link { length: 0.210, mass: 0.55, inertia: 0.0024, centre: [0.1, 0.006] };
    let (input, output) = (bar(0.09, 0.35), bar(0.12, 0.6));
    let four_bar = FourBar { ground: 0.23, input, coupler, output, branch: Branch::Plus };
    let linkage = Linkage(vec![part(Kind::FourBar(four_bar), 1.1)]);
    let loads = Loads {
        lever_inertia: 0.004,
        gravity: vec![Point::new(0.0, -9.81)],
        process: constant(-12.0),
        material: steel(0.015),
        ..Loads::default()
    };
    let plan = plan(lever(0.16, 0.11, 1.0, 1.0), true, 0.55, 1.0, 0.02, Cut::Groove);
    machine(45.0, Follower { m: 0.03, turns: true, cam: law, linkage }, plan, loads)
}

/// A roller lever before a slider-crank; the cam turns clockwise.
fn slider() -> Machine {
    let law = series(&[0.3, -0.27], &[0.01]);
    let kind =
        SliderCrank { crank: bar(0.13, 0.5), rod: bar(0.3, 0.7), offset: 0.02, slider_mass: 0.3, branch: Branch::Plus };
    let linkage = Linkage(vec![part(Kind::SliderCrank(kind), 1.0)]);
    let loads = Loads { lever_inertia: 0.003, process: constant(-150.0), material: steel(0.014), ..Loads::default() };
    let plan = plan(lever(0.15, 0.1, 1.0, 1.0), true, 0.6, -1.0, 0.018, Cut::Groove);
    machine(50.0, Follower { m: 2.4, turns: false, cam: law, linkage }, plan, loads)
}

/// A roller lever on the right before a four-bar linkage and a gear.
fn geared() -> Machine {
    let law = series(&[0.25, -0.25], &[]);
    let four_bar = FourBar {
        ground: 0.22,
        input: bar(0.1, 0.3),
        coupler: bar(0.2, 0.4),
        output: bar(0.13, 0.5),
        branch: Branch::Plus,
    };
    let gear = Gear { ratio: 0.15, inertia: 0.002, output_turns: true };
    let linkage = Linkage(vec![part(Kind::FourBar(four_bar), 0.9), part(Kind::Gear(gear), 0.0)]);
    let loads = Loads { lever_inertia: 0.005, process: constant(25.0), material: steel(0.016), ..Loads::default() };
    let plan = plan(lever(0.17, 0.12, -0.8, -1.0), true, 0.9, 1.0, 0.022, Cut::Groove);
    machine(40.0, Follower { m: 0.9, turns: true, cam: law, linkage }, plan, loads)
}

fn at(machine: &Machine, phi: f64) -> State {
    machine.at(phi, phi).expect("forces")
}

#[track_caller]
fn close(value: f64, expected: f64) {
    // The numbers are printed with 11 digits.
    assert!((value - expected).abs() <= 2e-10 * expected.abs(), "{value} for {expected}");
}

#[track_caller]
fn joint(state: &State, joint: usize, [x, y]: [f64; 2]) {
    let force = state.drives[0].mechanisms[0].joints[joint];
    close(force.re, x);
    close(force.im, y);
}

#[test]
fn a_translating_follower() {
    let machine = valve(60.0, 9e3);
    let state = at(&machine, 0.7);
    let (forces, contact) = (&state.drives[0], state.drives[0].contacts[0]);
    close(contact.force, 389.29215253);
    close(forces.load, 388.91932266);
    close(contact.pressure_angle, 0.043769057114);
    close(contact.side, -17.033510640);
    close(forces.torque, 3.3323281352);
    close(contact.hertzian, 314.42662560e6);
    let state = at(&machine, 4.5);
    close(state.drives[0].contacts[0].force, 394.06149620);
    close(state.drives[0].contacts[0].hertzian, 319.20546355e6);
    close(state.torque, -3.0134249667);
}

#[test]
fn a_lever_before_a_four_bar_linkage() {
    let machine = rocker();
    let state = at(&machine, 0.7);
    let forces = &state.drives[0];
    joint(&state, 0, [-181.46289825, -23.500560195]);
    joint(&state, 1, [-176.82172676, -26.997193544]);
    joint(&state, 2, [-162.36918492, -31.620774952]);
    joint(&state, 3, [154.49937856, 36.498336575]);
    close(forces.mechanisms[0].input, 14.266641460);
    close(forces.load, 15.370939086);
    close(forces.contacts[0].force, 140.14602227);
    close(forces.contacts[0].hertzian, 144.582701780e6);
    close(state.torque, 3.4686504421);
    for (value, expected) in forces.tool.into_iter().zip([1.4909478286, 6.7349626265, 215.67485702]) {
        close(value, expected);
    }
    let state = at(&machine, 4.5);
    joint(&state, 2, [-16.974534536, -1.5873135924]);
    close(state.drives[0].mechanisms[0].input, -0.71051524164);
    // The outer contour of the groove bears.
    close(state.drives[0].contacts[1].force, 22.54328728);
    assert!(state.drives[0].contacts[0].hertzian == 0.0);
    close(state.torque, 0.51669781696);
}

#[test]
fn a_lever_before_a_slider_crank() {
    let state = at(&slider(), 2.4);
    let forces = &state.drives[0];
    joint(&state, 0, [408.35831769, -151.53143219]);
    joint(&state, 1, [391.82968075, -147.96289147]);
    joint(&state, 2, [343.59406244, -142.96693447]);
    joint(&state, 3, [0.0, 142.96693447]);
    close(forces.mechanisms[0].input, -53.528362450);
    close(forces.contacts[0].force, -554.27044754);
    close(forces.contacts[1].hertzian, 264.80958203e6);
    close(state.torque, -9.6377045495);
}

#[test]
fn a_lever_before_a_four_bar_linkage_and_a_gear() {
    let machine = geared();
    let state = at(&machine, 2.4);
    let forces = &state.drives[0];
    joint(&state, 2, [67.702998667, 13.317384968]);
    close(forces.mechanisms[1].input, -8.2251442849);
    close(forces.mechanisms[1].output, -52.152560830);
    close(forces.load, -9.1527000800);
    close(forces.contacts[0].force, 62.676501710);
    close(forces.contacts[0].hertzian, 88.238385313e6);
    close(state.torque, -1.5455779767);
    let state = at(&machine, 4.5);
    close(state.drives[0].contacts[0].pressure_angle, 0.64739566751);
    close(state.drives[0].contacts[0].force, 31.382428160);
    close(state.torque, 0.91762291352);
}
