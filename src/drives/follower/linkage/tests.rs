//! The loops close; derivatives match the positions, energies the moving links.

use super::*;
use crate::drives::follower::rigid::Follower;
use crate::motion::{Fourier, MotionLaw};
use std::f64::consts::TAU;

fn bar(length: f64, mass: f64, inertia: f64, centre: [f64; 2]) -> Link {
    Link { length, mass, inertia, centre }
}

fn four_bar([ground, a, b, c]: [f64; 4], branch: Branch) -> FourBar {
    FourBar {
        ground,
        input: bar(a, 0.4, 2e-4, [0.012, 0.001]),
        coupler: bar(b, 0.7, 6e-4, [0.05, -0.004]),
        output: bar(c, 0.5, 3e-4, [0.02, 0.0]),
        branch,
    }
}

fn crank_rocker(branch: Branch) -> FourBar {
    four_bar([0.10, 0.03, 0.09, 0.06], branch)
}

/// The input link is longer than the distance of the pivots: both links turn right round.
fn drag_link(branch: Branch) -> FourBar {
    four_bar([0.03, 0.09, 0.08, 0.07], branch)
}

fn slider_crank(branch: Branch) -> SliderCrank {
    SliderCrank {
        crank: bar(0.05, 0.6, 5e-4, [0.01, 0.0]),
        rod: bar(0.16, 0.8, 2e-3, [0.06, 0.003]),
        offset: 0.02,
        slider_mass: 1.3,
        branch,
    }
}

fn chain() -> Linkage {
    let part = |kind, [input_offset, output_offset]: [f64; 2]| Mechanism { kind, input_offset, output_offset };
    Linkage(vec![
        part(Kind::Gear(Gear { ratio: -0.8, inertia: 1e-3, output_turns: true }), [0.1, 0.0]),
        part(Kind::FourBar(crank_rocker(Branch::Plus)), [1.9, 1.7]),
        part(Kind::SliderCrank(slider_crank(Branch::Plus)), [1.2, 0.05]),
    ])
}

/// The jet of an input that runs with its parameter.
fn running<const N: usize>(value: f64) -> Series<N> {
    let mut derivatives = [0.0; N];
    derivatives[0] = value;
    derivatives[1] = 1.0;
    Series::of_derivatives(derivatives)
}

/// The derivatives of `f` at `x` by central differences of order 6, each from values of the order below.
fn check_derivatives(f: impl Fn(f64) -> [f64; 5], x: f64, orders: usize, scale: f64) {
    let h = 2e-3;
    let at = f(x);
    for n in 0..orders {
        let d = |k: f64| f(x + k * h)[n] - f(x - k * h)[n];
        let slope = (45.0 * d(1.0) - 9.0 * d(2.0) + d(3.0)) / (60.0 * h);
        let scale = scale * (1.0 + at[n + 1].abs());
        assert!((slope - at[n + 1]).abs() < 1e-8 * scale, "order {n} at {x}: {slope} {}", at[n + 1]);
    }
}

#[test]
fn the_loop_of_a_four_bar_closes_all_around() {
    for branch in [Branch::Plus, Branch::Minus] {
        for linkage in [crank_rocker(branch), drag_link(branch)] {
            let psi = |theta: f64| linkage.moved(Series([theta])).0.value();
            let mut before = psi(-0.01);
            for i in 0..300 {
                // Three turns: ψ goes on without a jump.
                let theta = TAU * f64::from(i) / 100.0;
                let f = psi(theta);
                assert!((f - before).abs() < 0.3, "{branch:?} at {theta}");
                before = f;
                let (g, a, c) = (linkage.ground, linkage.input.length, linkage.output.length);
                let (x, y) = (g + c * f.cos() - a * theta.cos(), c * f.sin() - a * theta.sin());
                assert!((x.hypot(y) - linkage.coupler.length).abs() < 1e-15, "{theta}");
                check_derivatives(|theta| linkage.moved(running(theta)).0.derivatives(), theta, 4, 1.0);
                check_derivatives(|theta| linkage.moved(running(theta)).1.inertia.derivatives(), theta, 3, 1.0);
            }
        }
        let turned =
            |linkage: FourBar| linkage.moved(Series([1.0 + TAU])).0.value() - linkage.moved(Series([1.0])).0.value();
        assert!(turned(crank_rocker(branch)).abs() < 1e-14 && (turned(drag_link(branch)) - TAU).abs() < 1e-14);
    }
}

#[test]
fn the_derivatives_of_a_four_bar_are_those_of_the_implicit_equation() {
    // F = 0 differentiated by hand, up to the third order.
    for branch in [Branch::Plus, Branch::Minus] {
        let linkage = crank_rocker(branch);
        let (g, a, c) = (linkage.ground, linkage.input.length, linkage.output.length);
        for theta in [0.3, 1.7, 3.0, 4.4, 5.9] {
            let [psi, p1, p2, p3, _] = linkage.moved::<5>(running(theta)).0.derivatives();
            let (sd, cd) = (theta - psi).sin_cos();
            let ft = a * g * theta.sin() + a * c * sd;
            let fp = -c * g * psi.sin() - a * c * sd;
            let (ftt, ftp) = (a * g * theta.cos() + a * c * cd, -a * c * cd);
            let fpp = -c * g * psi.cos() + a * c * cd;
            let (fttt, fttp) = (-ft, a * c * sd);
            let (ftpp, fppp) = (-a * c * sd, c * g * psi.sin() + a * c * sd);
            let q1 = -ft / fp;
            let q2 = -(ftt + 2.0 * ftp * q1 + fpp * q1 * q1) / fp;
            let third = fttt + 3.0 * fttp * q1 + 3.0 * ftpp * q1 * q1 + fppp * q1.powi(3);
            let q3 = -(third + 3.0 * ftp * q2 + 3.0 * fpp * q1 * q2) / fp;
            assert!((p1 - q1).abs() < 1e-14 && (p2 - q2).abs() < 1e-13 && (p3 - q3).abs() < 1e-12, "{theta}");
        }
    }
}

#[test]
fn a_parallelogram_passes_the_angle_on() {
    // a = c, b = g: ψ = θ on one branch, as long as the links are not in one line.
    let mut linkage = crank_rocker(Branch::Plus);
    (linkage.input.length, linkage.output.length, linkage.coupler.length) = (0.05, 0.05, 0.10);
    for theta in [0.3, 1.0, 2.0, 2.8] {
        let (psi, inertia) = linkage.moved(running::<5>(theta));
        let f = psi.derivatives();
        assert!((f[0] - theta).abs() < 1e-14 && (f[1] - 1.0).abs() < 1e-13 && f[2].abs() < 1e-12 && f[3].abs() < 1e-11);
        // Coupler in translation: all its mass moves with the crank.
        let rotating = |link: &Link| link.inertia + link.mass * (link.centre[0].powi(2) + link.centre[1].powi(2));
        let closed = rotating(&linkage.input) + rotating(&linkage.output) + 0.7 * 0.05 * 0.05;
        assert!((inertia.inertia.value() - closed).abs() < 1e-15);
    }
}

#[test]
fn the_slider_follows_the_crank() {
    for branch in [Branch::Plus, Branch::Minus] {
        let linkage = slider_crank(branch);
        for i in 0..100 {
            let theta = TAU * f64::from(i) / 100.0;
            let s = linkage.moved(Series([theta])).0.value();
            let rod = (s - 0.05 * theta.cos()).hypot(0.02 - 0.05 * theta.sin());
            assert!((rod - 0.16).abs() < 1e-16);
            check_derivatives(|theta| linkage.moved(running(theta)).0.derivatives(), theta, 4, 0.1);
            check_derivatives(|theta| linkage.moved(running(theta)).1.inertia.derivatives(), theta, 3, 0.1);
        }
    }
}

#[test]
fn the_slider_crank_of_the_textbook() {
    // Centric, λ = r/l: s = r [cos θ + √(1 − λ² sin² θ)/λ], s″ = −r [cos θ + (λ cos 2θ + λ³ sin⁴ θ)/(1 − λ² sin² θ)^{3/2}].
    let linkage = SliderCrank { offset: 0.0, ..slider_crank(Branch::Plus) };
    let (r, lambda) = (0.05_f64, 0.05 / 0.16_f64);
    for i in 0..50 {
        let theta = TAU * f64::from(i) / 50.0;
        let (sin, cos) = theta.sin_cos();
        let root = 1.0 - lambda * lambda * sin * sin;
        let [s, _, s2, ..] = linkage.moved::<5>(running(theta)).0.derivatives();
        let bracket = cos + (lambda * (2.0 * theta).cos() + lambda.powi(3) * sin.powi(4)) / root.powf(1.5);
        assert!((s - r * (cos + root.sqrt() / lambda)).abs() < 1e-15);
        assert!((s2 + r * bracket).abs() < 1e-15);
    }
    // Reduced to two masses, the rod with m l²/4-like moment J = m x (l − x) rotates and translates as its two point masses.
    let (m, x, l) = (0.8, 0.06, 0.16);
    let rod = bar(l, m, m * x * (l - x), [x, 0.0]);
    let massless = bar(0.05, 0.0, 0.0, [0.0, 0.0]);
    let linkage = SliderCrank { crank: massless, rod, offset: 0.0, slider_mass: 0.0, branch: Branch::Plus };
    for theta in [0.4, 1.3, 2.9, 4.4] {
        let (s, inertia) = linkage.moved::<5>(running(theta));
        let closed = m * (1.0 - x / l) * r * r + m * x / l * s.derivatives()[1].powi(2);
        assert!((inertia.inertia.value() - closed).abs() < 1e-16);
    }
}

/// Place and angle of a link whose first joint is at `joint` and whose second one at `end`.
fn place(joint: [f64; 2], end: [f64; 2], centre: [f64; 2]) -> [f64; 3] {
    let beta = (end[1] - joint[1]).atan2(end[0] - joint[0]);
    let (s, c) = beta.sin_cos();
    [joint[0] + centre[0] * c - centre[1] * s, joint[1] + centre[0] * s + centre[1] * c, beta]
}

#[test]
fn the_reduced_inertia_is_twice_the_kinetic_energy_at_unit_speed() {
    // Places of the centres of mass by hand, velocities by differences.
    let (four_bar, slider) = (crank_rocker(Branch::Plus), slider_crank(Branch::Minus));
    let bars = |theta: f64| {
        let psi = four_bar.moved(Series([theta])).0.value();
        let pin = [0.03 * theta.cos(), 0.03 * theta.sin()];
        let end = [0.10 + 0.06 * psi.cos(), 0.06 * psi.sin()];
        [
            place([0.0; 2], pin, four_bar.input.centre),
            place(pin, end, four_bar.coupler.centre),
            place([0.10, 0.0], end, four_bar.output.centre),
        ]
    };
    let rods = |theta: f64| {
        let s = slider.moved(Series([theta])).0.value();
        let pin = [0.05 * theta.cos(), 0.05 * theta.sin()];
        [place([0.0; 2], pin, slider.crank.centre), place(pin, [s, 0.02], slider.rod.centre), [s, 0.02, 0.0]]
    };
    let energy = |places: &dyn Fn(f64) -> [[f64; 3]; 3], links: [Link; 3], theta: f64| -> f64 {
        let h = 1e-3;
        let velocity = |i: usize, part: usize| {
            let d = |k: f64| {
                let change = places(theta + k * h)[i][part] - places(theta - k * h)[i][part];
                // An angle may pass ±180°.
                if part == 2 { change - TAU * (change / TAU).round() } else { change }
            };
            (45.0 * d(1.0) - 9.0 * d(2.0) + d(3.0)) / (60.0 * h)
        };
        (0..3)
            .map(|i| {
                let [x, y, turn] = [0, 1, 2].map(|part| velocity(i, part));
                links[i].mass * (x * x + y * y) + links[i].inertia * turn * turn
            })
            .sum()
    };
    let mass = Link { mass: slider.slider_mass, ..Link::default() };
    for theta in [0.4, 1.3, 2.9, 4.4, 5.9] {
        let own = four_bar.moved::<2>(running(theta)).1.inertia.value();
        let links = [four_bar.input, four_bar.coupler, four_bar.output];
        assert!((own - energy(&bars, links, theta)).abs() < 1e-12);
        let own = slider.moved::<2>(running(theta)).1.inertia.value();
        assert!((own - energy(&rods, [slider.crank, slider.rod, mass], theta)).abs() < 1e-12);
    }
}

#[test]
fn the_motion_of_a_chain_is_that_of_its_mechanisms() {
    let chain = chain();
    for i in 0..=60 {
        let lever = -0.6 + 0.02 * f64::from(i);
        let moved = |lever: f64| chain.moved(2.0, running::<5>(lever), &[]);
        check_derivatives(|lever| moved(lever).tool.derivatives(), lever, 4, 0.2);
        check_derivatives(|lever| moved(lever).inertia.derivatives(), lever, 3, 0.2);
        // The whole is the sum of the parts, each with the square of the transmission before it.
        let slope = moved(lever).tool.derivatives()[1];
        let parts = chain.0.iter().fold((0.0, 1.0, lever), |(sum, before, input), mechanism| {
            let (output, own) = mechanism.moved(running::<2>(input));
            (sum + own.inertia.value() * before * before, before * output.derivatives()[1], output.value())
        });
        assert!((moved(lever).inertia.value() - parts.0 - 2.0 * slope * slope).abs() < 1e-14);
    }
}

#[test]
fn what_is_impossible_is_told_with_its_place() {
    // The lever swings by ±57.3° about 100°; the slider-crank's rod is too short at 0 and 180°.
    let swing = |phi: f64| phi.sin();
    let refusal = |linkage: &Linkage| linkage.check("follower[1].linkage", 400, swing).unwrap_err().to_string();
    let of = |kind| Linkage(vec![Mechanism { kind, input_offset: 100f64.to_radians(), output_offset: 0.0 }]);
    assert_eq!(chain().check("follower[1].linkage", 400, |phi| 0.3 * phi.sin()), Ok(()));
    let mut linkage = crank_rocker(Branch::Plus);
    linkage.coupler.length = 0.05;
    let message = refusal(&of(Kind::FourBar(linkage)));
    assert!(message.starts_with("`follower[1].linkage[1]`: at phi = 90.0000 deg its input angle is 157.2958 deg"));
    assert!(message.contains("do not reach each other"), "{message}");
    // d = |g − a e^{iθ}| is largest, b + c, at the end of the swing.
    let theta = 100f64.to_radians() + 1.0;
    let diagonal = (0.1f64.powi(2) + 0.03f64.powi(2) - 2.0 * 0.1 * 0.03 * theta.cos()).sqrt();
    linkage.coupler.length = diagonal - 0.06 + 1e-9;
    assert!(refusal(&of(Kind::FourBar(linkage))).contains("may go either way"));
    linkage.coupler.length = diagonal - 0.06 + 1e-5;
    assert_eq!(of(Kind::FourBar(linkage)).check("", 400, swing), Ok(()));
    let mut slider = slider_crank(Branch::Plus);
    slider.rod.length = 0.029;
    let message = refusal(&of(Kind::SliderCrank(slider)));
    assert!(message.contains("the rod does not reach") && message.contains("90.0000 deg"), "{message}");
    slider.rod.length = 0.0;
    let message = refusal(&of(Kind::SliderCrank(slider)));
    assert!(message.starts_with("`follower[1].linkage[1].rod.length` = 0: it must be 1e-6"), "{message}");
}

#[test]
fn the_parameters_by_number() {
    for mechanism in chain().0 {
        let list = mechanism.parameters();
        for (i, parameter) in list.iter().enumerate() {
            let mut changed = mechanism;
            *changed.parameter_mut(i).unwrap() = 0.123;
            assert_ne!(changed, mechanism, "{}", parameter.name());
            assert!(format!("follower[99].linkage[16].{}", parameter.name()).len() <= 40);
        }
        assert_eq!(mechanism.clone().parameter_mut(list.len()), None);
    }
}

#[test]
fn the_resolution_of_a_follower_is_what_its_inertia_needs() {
    let cam = MotionLaw::Fourier(Fourier::new(vec![0.0, 0.1], vec![0.0, 0.0, 0.1]));
    let follower = Follower { m: 2.0, turns: false, cam, linkage: chain() };
    // A small swing about a good position; a constant ratio, which has no more waves than the cam alone.
    assert_eq!(follower.linked_resolution(), 4.0);
    let constant = Linkage(vec![chain().0[0]]);
    assert_eq!(Follower { linkage: constant, ..follower.clone() }.linked_resolution(), 4.0);
    // A swing close to a position in which the output may go either way.
    let mut linkage = crank_rocker(Branch::Plus);
    linkage.coupler.length = 0.06;
    let near = Mechanism { kind: Kind::FourBar(linkage), input_offset: 1.4, output_offset: 0.0 };
    let cam = MotionLaw::Fourier(Fourier::new(vec![0.0, 0.0], vec![0.0, 0.75]));
    let follower = Follower { cam, linkage: Linkage(vec![near]), ..follower };
    assert_eq!(follower.check_linkage(""), Ok(()));
    let order = follower.linked_resolution();
    assert!((8.0..=64.0).contains(&order), "{order}");
}
