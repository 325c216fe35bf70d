//! Mechanisms on the shaft itself against their bodies, whose positions and velocities follow here from complex numbers.

use super::linkage::{Branch, FourBar, Gear, Kind, Link, Linkage, Mechanism, SliderCrank};
use super::*;
use crate::motion::Crank;

const OFFSET: f64 = 0.7;
const CRANK: Link = Link { length: 0.08, mass: 8.0, inertia: 0.05, centre: [0.02, -0.003] };
const TOOL: f64 = 12.0;

fn slider_crank() -> SliderCrank {
    let rod = Link { length: 0.5, mass: 12.0, inertia: 0.35, centre: [0.2, 0.01] };
    SliderCrank { crank: CRANK, rod, offset: 0.01, slider_mass: 40.0, branch: Branch::Plus }
}

/// Of `input`, `coupler`, `output` and `ground`; the first is the shortest.
fn four_bar([a, b, c, ground]: [f64; 4]) -> FourBar {
    let bar = |length, mass, inertia, centre| Link { length, mass, inertia, centre };
    FourBar {
        ground,
        input: bar(a, 0.35, 3e-4, [0.02, 0.0]),
        coupler: bar(b, 0.55, 2.4e-3, [0.1, 0.006]),
        output: bar(c, 0.6, 9e-4, [0.06, 0.0]),
        branch: Branch::Plus,
    }
}

fn on_shaft(kinds: Vec<Kind>, offset: f64) -> Scene {
    let mechanism = |kind| Mechanism { kind, input_offset: 0.0, output_offset: 0.1 };
    let turns = matches!(kinds.last(), Some(Kind::FourBar(_) | Kind::Gear(_)));
    let linkage = Linkage(kinds.into_iter().map(mechanism).collect());
    let follower = Follower { m: TOOL, turns, cam: MotionLaw::Crank(Crank { offset }), linkage };
    let inertia = InertiaFunction { constant: 0.9, varying: None };
    Scene { inertia, followers: vec![follower], ..loom(Motor::None, 3.0, 12.0) }
}

type Point = [f64; 2];

fn times([a, b]: Point, [c, d]: Point) -> Point {
    [a * c - b * d, a * d + b * c]
}

/// m |v|² + J β̇² of a link with this first joint's velocity, direction and rate of turning.
fn energy(link: &Link, joint: Point, direction: Point, rate: f64) -> f64 {
    let spin = times(times(link.centre, direction), [0.0, rate]);
    let [vx, vy] = [joint[0] + spin[0], joint[1] + spin[1]];
    link.mass * (vx * vx + vy * vy) + link.inertia * rate * rate
}

/// s, s′ and J of the slider-crank at θ.
fn slider_crank_at(m: &SliderCrank, theta: f64) -> [f64; 3] {
    let (r, l) = (m.crank.length, m.rod.length);
    let (sin, cos) = theta.sin_cos();
    // The rod's angle β: l sin β = e − r sin θ.
    let sine = (m.offset - r * sin) / l;
    let cosine = (1.0 - sine * sine).sqrt();
    let rate = -r * cos / (l * cosine);
    let slope = -r * sin - l * sine * rate;
    let pin = [-r * sin, r * cos];
    let links = energy(&m.crank, [0.0; 2], [cos, sin], 1.0) + energy(&m.rod, pin, [cosine, sine], rate);
    [r * cos + l * cosine, slope, 0.9 + links + (m.slider_mass + TOOL) * slope * slope]
}

/// ψ within (−π, π], ψ′ and J of the four-bar linkage at θ.
fn four_bar_at(m: &FourBar, theta: f64) -> [f64; 3] {
    let (a, b, c) = (m.input.length, m.coupler.length, m.output.length);
    let (sin, cos) = theta.sin_cos();
    let (pin, d) = ([a * cos, a * sin], [m.ground - a * cos, -a * sin]);
    let d2 = d[0] * d[0] + d[1] * d[1];
    // The end of the coupler: pin + d (k + i h), |pin → end| = b and |end → ground| = c.
    let k = 0.5 * (1.0 + (b * b - c * c) / d2);
    let h = (b * b / d2 - k * k).sqrt();
    let coupler = times(d, [k, h]);
    let output = [pin[0] + coupler[0] - m.ground, pin[1] + coupler[1]];
    // a i e^{iθ} + i β′ coupler = i ψ′ output, dotted with the coupler and with the output.
    let dot = |x: Point, y: Point| x[0] * y[0] + x[1] * y[1];
    let side = |x: Point, y: Point| x[0] * y[1] - x[1] * y[0];
    let psi = side(pin, coupler) / side(output, coupler);
    let beta = side(pin, output) / -side(coupler, output);
    assert!((dot(coupler, coupler).sqrt() - b).abs() < 1e-14 && (dot(output, output).sqrt() - c).abs() < 1e-14);
    let links = energy(&m.input, [0.0; 2], [cos, sin], 1.0)
        + energy(&m.coupler, [-pin[1], pin[0]], coupler.map(|x| x / b), beta)
        + energy(&m.output, [0.0; 2], output.map(|x| x / c), psi);
    [output[1].atan2(output[0]), psi, 0.9 + links + TOOL * psi * psi]
}

/// Without torques J φ̇² is constant; J, U and U̇ match the bodies', through several turns there and back.
fn follows(scene: Scene, at: impl Fn(f64) -> [f64; 3]) {
    for w_start in [12.0, -12.0] {
        let mut machine = started(Scene { w_start, ..scene.clone() });
        let energy = 0.5 * at(3.0 + OFFSET)[2] * w_start * w_start;
        let mut before = f64::NAN;
        for i in 0..400 {
            let [phi, w, inertia, u, speed] = ["phi", "w", "J", "U[1]", "der(U[1])"].map(|name| get(&machine, name));
            let [position, slope, expected] = at(phi + OFFSET);
            assert_near(inertia, expected, 1e-13, &format!("J at {phi}"));
            assert!((u + 0.1 - position).abs() < 1e-13, "U at {phi}: {u} {position}");
            assert!((speed - slope * w).abs() < 1e-12, "der(U) at {phi}: {speed} {}", slope * w);
            assert_near(0.5 * expected * w * w, energy, 1e-12, &format!("energy at {phi}"));
            assert!(i == 0 || (u - before).abs() < 0.03, "a jump at {phi}");
            before = u;
            machine.advance(0.005 * f64::from(i), 0.005).unwrap();
        }
        assert!((get(&machine, "phi") - 3.0).abs() > 2.0 * TAU);
        // U̇ and Ü are the time derivatives of U.
        let [u, speed] = ["U[1]", "der(U[1])"].map(|name| series(&machine, name, Seed::Time));
        let rates = ["der(U[1])", "der(U[1],2)"].map(|name| get(&machine, name));
        for (order, rate) in [(1, rates[0]), (2, rates[1])] {
            assert!((u.derivative(order) - rate).abs() < 1e-10 * rate.abs());
            assert!((speed.derivative(order - 1) - rate).abs() < 1e-10 * rate.abs());
        }
    }
}

#[test]
fn a_slider_crank_on_the_shaft_has_the_inertia_of_its_bodies() {
    follows(on_shaft(vec![Kind::SliderCrank(slider_crank())], OFFSET), |theta| slider_crank_at(&slider_crank(), theta));
}

#[test]
fn a_four_bar_linkage_on_the_shaft_has_the_inertia_of_its_bodies() {
    let linkage = four_bar([0.04, 0.2, 0.12, 0.21]);
    follows(on_shaft(vec![Kind::FourBar(linkage)], OFFSET), |theta| four_bar_at(&linkage, theta));
}

/// A quick return: the first linkage goes round with the shaft, the slider-crank on it stops at no angle.
#[test]
fn a_mechanism_that_goes_round_may_drive_one_that_does_not() {
    let double = FourBar { branch: Branch::Minus, ..four_bar([0.09, 0.08, 0.07, 0.03]) };
    let scene = on_shaft(vec![Kind::FourBar(double), Kind::SliderCrank(slider_crank())], OFFSET);
    let mut machine = started(scene);
    let (energy, mut before) = (get(&machine, "E"), f64::NAN);
    for i in 0..300 {
        let [u, speed] = ["U[1]", "der(U[1])"].map(|name| get(&machine, name));
        assert!(i == 0 || (u - before).abs() < 0.002 * 25.0, "a jump by {}", u - before);
        assert!(speed.is_finite());
        assert_near(get(&machine, "E"), energy, 1e-12, "E");
        before = u;
        machine.advance(0.005 * f64::from(i), 0.005).unwrap();
    }
}

#[test]
fn the_offset_is_an_angle_of_the_start() {
    let kind = || vec![Kind::SliderCrank(slider_crank())];
    let [mut ahead, mut machine] = [on_shaft(kind(), 0.0), on_shaft(kind(), 0.0)].map(started);
    set(&mut ahead, "follower[1].crank.offset", OFFSET);
    ahead.start(0.0).unwrap();
    machine.start.phi += OFFSET;
    machine.start(0.0).unwrap();
    for machine in [&mut ahead, &mut machine] {
        run(machine, 1.0, 10);
    }
    assert!((get(&machine, "phi") - OFFSET - get(&ahead, "phi")).abs() < 1e-11);
    assert_near(get(&machine, "der(U[1],2)"), get(&ahead, "der(U[1],2)"), 1e-10, "acceleration");
    assert!(machine.variables().reference("lever[1]").is_none(), "the crank is the shaft itself");
}

#[test]
fn what_is_not_the_same_after_a_turn_is_refused() {
    let gear = |ratio| Kind::Gear(Gear { ratio, inertia: 0.0, output_turns: true });
    let double = Kind::FourBar(FourBar { branch: Branch::Minus, ..four_bar([0.09, 0.08, 0.07, 0.03]) });
    let slider = || Kind::SliderCrank(slider_crank());
    for kinds in [vec![], vec![double], vec![gear(2.0)], vec![gear(0.5), slider()]] {
        let message = RigidMachine::new(on_shaft(kinds, 0.0)).err().unwrap().to_string();
        assert!(message.contains("follower[1].linkage") && message.contains("after a turn"), "{message}");
    }
    assert!(RigidMachine::new(on_shaft(vec![gear(-2.0), slider(),], 0.0)).is_ok());
}
