//! Under loads, against numbers of two independent programs, against an integration of the equation itself and against relations
//! that hold for any loads.

use super::*;
use crate::drives::follower::load::Spring;
use crate::drives::variable::Causality;
use crate::motion::table::Points;
use crate::motion::{Polyline, Table};
use crate::numerics::gauss::Gauss;

/// HS profile of the reference with the stroke `h` (m).
fn hs(h: f64) -> MotionLaw {
    MotionLaw::Fourier(Fourier::new(vec![0.0, 0.5867 * h, 0.0, -0.0984 * h, 0.0, 0.0115 * h], vec![]))
}

/// The load Q of the reference.
fn load_q() -> Load {
    Load {
        gravity: Some(-9.81),
        spring: Some(Spring { preload: 40.0, c: 3000.0, at: 0.01 }),
        damping: Some(15.0),
        process: Some(MotionLaw::Fourier(Fourier::new(vec![0.0, 20.0, -12.0], vec![0.0, 7.0, 0.0, 3.0]))),
        ..Load::default()
    }
}

fn reference_scene() -> Scene {
    let mode = DriveMode::Constant { w: 14.0, phi_start: 0.0 };
    Scene { load: load_q(), ..scene([2.0, 20000.0, 16.0], hs(0.06), mode, at_rest()) }
}

fn get(drive: &ElasticOutput, name: &str) -> f64 {
    named(&drive.variables(), name).value(drive)
}

fn set(drive: &mut ElasticOutput, name: &str, value: f64) {
    named(&drive.variables(), name).set(drive, value);
}

fn set_derivative(drive: &mut ElasticOutput, name: &str, order: usize, value: f64) {
    named(&drive.variables(), name).set_derivative(drive, order, value);
}

fn assert_close(found: f64, expected: f64, tolerance: f64, case: &str) {
    assert!((found - expected).abs() <= tolerance, "{case}: {found} instead of {expected}");
}

#[test]
fn the_case_of_the_reference() {
    for steps in [1, 9, 1000] {
        let drive = &mut drive(reference_scene());
        run(drive, 0.9, 0.9 / f64::from(steps));
        for (name, expected, scale) in [
            ("y", 0.025163614349626, 0.03),
            ("der(y)", 0.0122018586467936, 0.5),
            ("contact_force", 96.3053413825294, 100.0),
            ("tau", 0.00220785268877654, 3.0),
        ] {
            assert_close(get(drive, name), expected, 1e-12 * scale, &format!("{name} in {steps} steps"));
        }
    }
}

/// Numbers from a fixed seed, as in the tests of the response.
struct Dice(u64);

impl Dice {
    fn roll(&mut self) -> f64 {
        self.0 = self.0 * 48271 % 2147483647;
        self.0 as f64 / 2147483647.0
    }
    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.roll()
    }
    fn magnitude(&mut self, low: f64, high: f64) -> f64 {
        low * (high / low).powf(self.roll())
    }
    fn one_of<T>(&mut self, value: T) -> Option<T> {
        (self.roll() < 0.6).then_some(value)
    }
}

/// A law of the values of this size: a series, a cycle or a table.
fn random_law(dice: &mut Dice, size: f64, series: bool) -> MotionLaw {
    let mut values = |count: usize, fall: f64| -> Vec<f64> {
        (0..count).map(|k| size * dice.between(-1.0, 1.0) / (1.0 + fall * (k * k) as f64)).collect()
    };
    let kind = if series { 0 } else { 1 + (values(1, 0.0)[0] > 0.0) as u32 };
    match kind {
        0 => MotionLaw::Fourier(Fourier::new(values(6, 1.0), values(4, 1.0))),
        1 => MotionLaw::Cycle(Cycle::new(CyclePlan {
            stroke: size,
            lower: values(1, 0.0)[0],
            rise_start: 6.0 * values(1, 0.0)[0] / size,
            rise_angle: 1.5,
            upper_dwell: 0.7,
            return_angle: 1.2,
            rise_law: Polynomial345,
            return_law: SimpleSine,
            inflections: [None; 2],
        })),
        _ => {
            let angles = (0..9).map(|i| 0.3 + 0.68 * f64::from(i)).collect();
            MotionLaw::Table(Table::new(Points { angles, lifts: values(9, 0.0) }).unwrap())
        }
    }
}

/// The same for a force, which may also consist of lines with a step.
fn random_process(dice: &mut Dice, size: f64, series: bool) -> MotionLaw {
    if series || dice.roll() < 0.5 {
        return random_law(dice, size, series);
    }
    let (first, lifts) = (dice.between(0.0, 1.0), (0..6).map(|_| size * dice.between(-1.0, 1.0)).collect());
    let angles = [0.0, 1.3, 1.3, 2.0, 4.0, 5.5].iter().map(|phi| first + phi).collect();
    MotionLaw::Polyline(Polyline::new(Points { angles, lifts }).unwrap())
}

/// Loads on an oscillator with m, c and b that a cam moves by about `size`.
fn random_load(dice: &mut Dice, mcb: [f64; 3], size: f64, series: bool) -> Load {
    let [m, c, b] = mcb;
    let force = size * c;
    let spring = Spring {
        preload: dice.between(-1.0, 1.0) * force,
        c: dice.magnitude(1e-3, 3.0) * c,
        at: dice.between(-3.0, 3.0) * size,
    };
    Load {
        gravity: dice.one_of(-force / m),
        constant: dice.one_of(-0.7 * force),
        spring: dice.one_of(spring),
        damping: dice.one_of(0.3 * b),
        process: (dice.roll() < 0.8).then(|| random_process(dice, force, series)),
        input: false,
        ..Load::default()
    }
}

/// y, ẏ at the last of the `stops` (s), from the first on, with a smooth motion between them: m ÿ = −c (y − x) − b (ẏ − ẋ) + F_L by
/// Gragg's rule, extrapolated to the order 16; `at` returns φ, ω at a time and `input` F.
fn integrated(
    scene: &Scene,
    start: [f64; 2],
    stops: &[f64],
    at: impl Fn(f64) -> [f64; 2],
    input: impl Fn(f64) -> f64,
) -> [f64; 2] {
    let Parameters { m, c, b } = scene.parameters;
    let Load { gravity, constant, spring, damping, process, .. } = &scene.load;
    let (mut state, spring) = (start, spring.unwrap_or_default());
    let finest = (c + spring.c).max((b + damping.unwrap_or(0.0)).powi(2) / m) / m;
    for ends in stops.windows(2).filter(|ends| ends[1] - ends[0] > 1e-13 * ends[1].abs()) {
        let middle = at(0.5 * (ends[0] + ends[1]))[0];
        let there = |law: &MotionLaw, phi: f64| {
            law.at_in(law.segment(angle::reduce(Double::from(middle)), true), angle::reduce(Double::from(phi))).0
        };
        let rate = |t: f64, [y, v]: [f64; 2]| {
            let [phi, w] = at(t);
            let [x, slope, ..] = there(&scene.cam, phi);
            let p = process.as_ref().map_or(0.0, |law| there(law, phi)[0]);
            let loads = m * gravity.unwrap_or(0.0) + constant.unwrap_or(0.0)
                - spring.preload
                - spring.c * (y - spring.at)
                - damping.unwrap_or(0.0) * v
                + p
                + input(t);
            [v, (-c * (y - x) - b * (v - slope * w) + loads) / m]
        };
        let turned = (at(ends[1])[0] - at(ends[0])[0]).abs();
        let count = (1.0 + (ends[1] - ends[0]) * finest.sqrt() / 0.7 + turned / 0.15) as u32;
        let big = (ends[1] - ends[0]) / f64::from(count);
        for i in 0..count {
            let t0 = ends[0] + f64::from(i) * big;
            let mut table: Vec<[f64; 2]> = Vec::new();
            for row in 1..=8_u32 {
                let h = big / f64::from(2 * row);
                let (mut before, mut now) = (state, {
                    let r = rate(t0, state);
                    [0, 1].map(|k| state[k] + h * r[k])
                });
                for n in 1..2 * row {
                    let r = rate(t0 + f64::from(n) * h, now);
                    (before, now) = (now, [0, 1].map(|k| before[k] + 2.0 * h * r[k]));
                }
                table.push(now);
                for k in (0..table.len() - 1).rev() {
                    let ratio = (f64::from(row) / f64::from(k as u32 + 1)).powi(2) - 1.0;
                    table[k] = [0, 1].map(|i| table[k + 1][i] + (table[k + 1][i] - table[k][i]) / ratio);
                }
            }
            state = table[0];
        }
    }
    state
}

/// The times up to `end` (s) at which a shaft at the constant speed `w` from `phi` on passes breakpoints of the laws.
fn stops(scene: &Scene, [phi, w]: [f64; 2], end: f64) -> Vec<f64> {
    let laws = [Some(&scene.cam), scene.load.process.as_ref()];
    let breakpoints = laws.into_iter().flatten().flat_map(|law| law.breakpoints().to_vec());
    let mut times: Vec<f64> = breakpoints
        .flat_map(|b| {
            let first = ((b - phi) * w.signum()).rem_euclid(TAU) / w.abs();
            (0..).map(move |turn| first + f64::from(turn) * TAU / w.abs()).take_while(move |t| *t < end)
        })
        .chain([0.0, end])
        .collect();
    times.sort_by(f64::total_cmp);
    times
}

/// A scene under random loads, its speed and a time of some turns.
fn random_scene(dice: &mut Dice, series: [bool; 2]) -> (Scene, [f64; 2], f64) {
    let (m, w) = (dice.magnitude(0.1, 10.0), dice.magnitude(3.0, 100.0) * if dice.roll() < 0.5 { 1.0 } else { -1.0 });
    let frequency = w.abs() * dice.magnitude(1.7, 30.0);
    let (c, size) = (m * frequency * frequency, dice.magnitude(1e-3, 0.1));
    let b = 2.0 * dice.magnitude(1e-3, 2.0) * m * frequency;
    let (phi, cam) = (dice.between(-9.0, 9.0), random_law(dice, size, series[0]));
    let load = random_load(dice, [m, c, b], size, series[1]);
    let start = Start { mode: StartMode::Given, q: 0.1 * size, q_dot: 0.1 * size * w };
    let mode = DriveMode::Constant { w, phi_start: phi };
    (Scene { load, ..scene([m, c, b], cam, mode, start) }, [phi, w], dice.between(0.3, 3.0) * TAU / w.abs())
}

const KINDS: [[bool; 2]; 4] = [[true, true], [true, false], [false, true], [false, false]];

#[test]
fn random_loads_at_constant_speed_move_the_mass_as_an_integration_does() {
    let dice = &mut Dice(20261126);
    for number in 0..80 {
        let (scene, [phi, w], end) = random_scene(dice, KINDS[number % 4]);
        let mut drive = drive(scene.clone());
        let from = [get(&drive, "y"), get(&drive, "der(y)")];
        let expected = integrated(&scene, from, &stops(&scene, [phi, w], end), |t| [phi + w * t, w], |_| 0.0);
        run(&mut drive, end, end / [1.0, 7.0, 300.0][number % 3]);
        let size = scene.cam.bound(0) + drive.deformation()[0].abs();
        let rate = drive.response.equation().oscillator.stiffness().sqrt();
        assert_close(get(&drive, "y"), expected[0], 2e-12 * size, &format!("{number}: {scene:?}"));
        assert_close(get(&drive, "der(y)"), expected[1], 2e-12 * size * rate, &format!("{number}: {scene:?}"));
        let [.., estimate] = drive.statistics();
        assert!(0.0 < estimate && estimate < 1e-10, "{number}: {estimate:e}");
    }
}

/// F and its derivatives at a time, and φ, ω, α.
fn input(t: f64, size: f64) -> [f64; 4] {
    [
        size * (1.0 - 3.0 * t + 5.0 * t * t - 40.0 * t * t * t),
        size * (-3.0 + 10.0 * t - 120.0 * t * t),
        size * (10.0 - 240.0 * t),
        size * -240.0,
    ]
}

/// Runs the scene, whose shaft follows its inputs from φ, ω, α on, to `end` (s) under the input F.
fn run_under(scene: &Scene, motion: [f64; 3], end: f64, steps: u32, size: f64) -> ElasticOutput {
    let [phi, w, a] = motion;
    let mut drive = ElasticOutput::new(scene.clone()).unwrap();
    let (is_input, list) = (drive.cam.is_input(), drive.variables());
    let force = named(&list, "F");
    let shaft = is_input.then(|| ["phi", "w", "a"].map(|name| named(&list, name)));
    let enter = |drive: &mut ElasticOutput, t: f64| {
        for (variable, value) in shaft.into_iter().flatten().zip([phi + (w + 0.5 * a * t) * t, w + a * t, a]) {
            variable.set(drive, value);
        }
        let [f, derivatives @ ..] = input(t, size);
        force.set(drive, f);
        for (i, derivative) in derivatives.into_iter().enumerate() {
            force.set_derivative(drive, i + 1, derivative);
        }
    };
    enter(&mut drive, 0.0);
    drive.start(0.0).unwrap();
    for n in 0..steps {
        let [time, next] = [n, n + 1].map(|n| end * f64::from(n) / f64::from(steps));
        enter(&mut drive, time);
        drive.apply(time).unwrap();
        drive.advance(time, next - time).unwrap();
    }
    drive
}

/// F = 3 N + 50 N/s t, each step with its value and its derivative: numbers of an integration.
#[test]
fn the_derivative_of_an_input_force_acts_at_constant_speed() {
    let law = MotionLaw::Fourier(Fourier::new(vec![0.0, 0.01], vec![]));
    let mode = DriveMode::Constant { w: 10.0, phi_start: 0.0 };
    let load = Load { input: true, ..Load::default() };
    let mut drive = ElasticOutput::new(Scene { load, ..scene([1.0, 1e4, 20.0], law, mode, at_rest()) }).unwrap();
    for n in 0..4 {
        let time = 0.05 * f64::from(n);
        set(&mut drive, "F", 3.0 + 50.0 * time);
        set_derivative(&mut drive, "F", 1, 50.0);
        if n == 0 { drive.start(time) } else { drive.apply(time) }.unwrap();
        drive.advance(time, 0.05).unwrap();
    }
    assert_close(get(&drive, "q"), 0.00121298, 5e-9, "q");
    assert_close(get(&drive, "der(q)"), 0.00840802, 5e-9, "der(q)");
}

#[test]
fn inputs_move_and_load_the_drive_as_an_integration_does() {
    let dice = &mut Dice(333);
    for number in 0..24 {
        // Ramps over smooth laws, in which the integration knows no breakpoint; constant speeds over all.
        let ramp = number % 2 == 0;
        let (mut scene, [phi, w], end) = random_scene(dice, if ramp { [true; 2] } else { KINDS[number / 2 % 4] });
        let size = 0.3 * scene.parameters.c * scene.cam.bound(0);
        scene.load.input = true;
        scene.solver.tolerance = 1e-13;
        if number % 4 < 3 {
            scene.drive = DriveMode::Input;
        }
        let a = if ramp && number % 4 < 3 { 0.3 * w / end } else { 0.0 };
        let start = &run_under(&scene, [phi, w, a], 1e-9 * end, 1, 0.0);
        let [x, slope, ..] = scene.cam.at(angle::reduce(Double::from(phi))).0;
        let from = [x + scene.start.q, slope * w + scene.start.q_dot];
        let (at, force) = (|t: f64| [phi + (w + 0.5 * a * t) * t, w + a * t], |t: f64| input(t, size)[0]);
        let expected = integrated(&scene, from, &stops(&scene, [phi, w], end), at, force);
        for steps in [7, 500, 4000] {
            let drive = run_under(&scene, [phi, w, a], end, steps, size);
            let whole = scene.cam.bound(0) + drive.deformation()[0].abs();
            let rate = start.response.equation().oscillator.stiffness().sqrt();
            let case = format!("{number} in {steps} steps: {scene:?}");
            assert_close(get(&drive, "y"), expected[0], 2e-11 * whole, &case);
            assert_close(get(&drive, "der(y)"), expected[1], 2e-11 * whole * rate, &case);
        }
    }
}

#[test]
fn a_force_that_changes_at_communication_points_only_adds_its_exact_deflection() {
    // Undamped: r = F/k (1 − cos ωt) from rest, at once and after a change at 0.3 s, whatever the steps between.
    let (m, c, c_r) = (2.0, 2e4, 3e3);
    let spring = Some(Spring { c: c_r, ..Spring::default() });
    let mode = DriveMode::Constant { w: 14.0, phi_start: 0.2 };
    let of = |input: bool, steps: u32| {
        let load = Load { spring, input, ..Load::default() };
        let mut drive =
            drive(Scene { load, ..scene([m, c, 0.0], cycle(Polynomial345, Polynomial345), mode.clone(), at_rest()) });
        for (force, [from, to]) in [(50.0, [0.0, 0.3]), (-20.0, [0.3, 40.0])] {
            if input {
                set(&mut drive, "F", force);
                drive.apply(from).unwrap();
            }
            for n in 0..steps {
                let [a, b] = [n, n + 1].map(|n| from + (to - from) * f64::from(n) / f64::from(steps));
                drive.advance(a, b - a).unwrap();
            }
        }
        (get(&drive, "q"), drive.response.is_on_table())
    };
    let (k, omega) = (c + c_r, ((c + c_r) / m).sqrt());
    let expected =
        (50.0 * (f64::cos(omega * 39.7) - f64::cos(omega * 40.0)) - 20.0 * (1.0 - f64::cos(omega * 39.7))) / k;
    for steps in [1, 17, 1000] {
        let ((under, on_table), (without, _)) = (of(true, steps), of(false, steps));
        assert_close(under - without, expected, 1e-12 * 70.0 / k, &format!("{steps} steps"));
        assert!(on_table);
    }
}

#[test]
fn an_equilibrium_stays_where_the_loads_balance_the_springs() {
    let dice = &mut Dice(77);
    for number in 0..40 {
        let (mut scene, [phi, _], _) = random_scene(dice, KINDS[number % 4]);
        let Parameters { m, c, .. } = scene.parameters;
        scene.start = Start { mode: StartMode::Equilibrium, ..at_rest() };
        scene.load.input = true;
        let force = 0.1 * c * scene.cam.bound(0);
        let reduced = angle::reduce(Double::from(phi));
        let p = scene.load.process.as_ref().map_or(0.0, |law| law.at(reduced).0[0]);
        let spring = scene.load.spring.unwrap_or_default();
        let still = m * scene.load.gravity.unwrap_or(0.0) + scene.load.constant.unwrap_or(0.0) - spring.preload;
        let y = (c * scene.cam.at(reduced).0[0] + spring.c * spring.at + still + force + p) / (c + spring.c);
        for mode in [
            DriveMode::Constant { w: 0.0, phi_start: phi },
            DriveMode::Constant { w: 3.0, phi_start: phi },
            DriveMode::Input,
        ] {
            let turns = mode.speed() != 0.0;
            let mut drive = ElasticOutput::new(Scene { drive: mode, ..scene.clone() }).unwrap();
            if drive.cam.is_input() {
                drive.cam.set_inputs([phi, 0.0, 0.0]);
            }
            set(&mut drive, "F", force);
            drive.start(0.0).unwrap();
            let size = y.abs() + scene.cam.bound(0) + (p.abs() + still.abs()) / c;
            assert_close(get(&drive, "y"), y, 1e-14 * size, &format!("{scene:?}"));
            assert_close(get(&drive, "der(q)"), 0.0, 0.0, "at the start");
            if !turns {
                for (time, end) in [(0.0, 0.01), (0.01, 100.0), (100.0, 1000.0)] {
                    drive.advance(time, end - time).unwrap();
                    assert_close(get(&drive, "y"), y, 1e-13 * size, &format!("at rest until {end}: {scene:?}"));
                    assert_close(get(&drive, "der(y,2)"), 0.0, 1e-12 * size * c / m, "at rest");
                }
            }
        }
    }
    // Nothing holds the mass.
    for mode in [StartMode::Equilibrium, StartMode::SteadyState] {
        let start = Start { mode, ..at_rest() };
        let load = Load { gravity: Some(-9.81), damping: Some(3.0), ..Load::default() };
        let free =
            Scene { load, ..scene([2.0, 0.0, 1.0], hs(0.06), DriveMode::Constant { w: 14.0, phi_start: 0.0 }, start) };
        let message = ElasticOutput::new(free).unwrap().start(0.0).unwrap_err().to_string();
        assert!(message.contains("start.mode") && message.contains("c = 0"), "{message}");
    }
}

#[test]
fn the_periodic_motion_under_loads_repeats_itself() {
    let dice = &mut Dice(4711);
    for number in 0..40 {
        let (mut scene, [_, w], _) = random_scene(dice, KINDS[number % 4]);
        scene.start = Start { mode: StartMode::SteadyState, ..at_rest() };
        scene.load.input = true;
        let mut drive = ElasticOutput::new(scene.clone()).unwrap();
        set(&mut drive, "F", 0.1 * scene.parameters.c * scene.cam.bound(0));
        drive.start(0.0).unwrap();
        let first = drive.deformation();
        run(&mut drive, 3.0 * TAU / w.abs(), 0.37 * TAU / w.abs());
        let rate = drive.response.equation().oscillator.stiffness().sqrt();
        let size = first[0].abs() + scene.cam.bound(0);
        assert_near(off(drive.deformation(), first, size, rate), 1e-11, &format!("{number}: {scene:?}"));
    }
}

#[test]
fn loads_without_size_are_none() {
    for cam in [hs(0.06), cycle(Polynomial345, ModifiedSine)] {
        let mode = DriveMode::Constant { w: 14.0, phi_start: 0.3 };
        let bare = scene([2.0, 2e4, 16.0], cam, mode, given());
        let nothing = Load {
            gravity: Some(0.0),
            constant: Some(0.0),
            spring: Some(Spring::default()),
            damping: Some(0.0),
            process: Some(MotionLaw::Fourier(Fourier::new(vec![0.0; 3], vec![]))),
            input: true,
            ..Load::default()
        };
        let on_roller = Load { process: None, input: false, ..nothing.clone() };
        let loaded = Scene { load: nothing.clone(), roller: (0.0, on_roller), ..bare.clone() };
        let misplaced = Scene { roller: (1.0, nothing), ..bare.clone() };
        assert!(ElasticOutput::new(misplaced).unwrap_err().to_string().contains("on the mass only"));
        let (mut bare, mut loaded) = (drive(bare), drive(loaded));
        run(&mut bare, 0.9, 0.01);
        run(&mut loaded, 0.9, 0.01);
        for name in ["y", "der(y)", "der(y,2)", "q", "der(q,2)", "force", "tau"] {
            let expected = get(&bare, name);
            assert_close(get(&loaded, name), expected, 1e-12 * expected.abs(), name);
        }
        assert_eq!(get(&loaded, "contact_force"), get(&loaded, "force"));
        assert!(bare.variables().reference("contact_force").is_none());
    }
}

#[test]
fn energy_is_balanced_with_a_roller_and_all_loads() {
    // ΔE = ∫ (tau ω + P ẏ − b q̇² − b_r ẏ² − b_x ẋ²) dt, with the potentials of gravity, constants and springs in E.
    let dice = &mut Dice(99);
    for number in 0..12 {
        let (mut scene, [phi, w], end) = random_scene(dice, KINDS[number % 4]);
        let Parameters { m, c, b } = scene.parameters;
        let m_x = 0.4 * m;
        let on_roller = Load { process: None, ..random_load(dice, [m, c, b], scene.cam.bound(0), true) };
        scene.roller = (m_x, on_roller.clone());
        let stops = stops(&scene, [phi, w], end);
        let drive = &mut drive(scene.clone());
        let list = drive.variables();
        let get = |drive: &ElasticOutput, name: &str| named(&list, name).value(drive);
        let energy = |drive: &ElasticOutput| {
            let [x, y, v, q] = ["x", "y", "der(y)", "q"].map(|name| get(drive, name));
            let x1 = v - get(drive, "der(q)");
            0.5 * (m * v * v + c * q * q + m_x * x1 * x1) + scene.load.potential(m, y) + on_roller.potential(m_x, x)
        };
        let force = |load: &Load, phi: f64| {
            let phi = angle::reduce(Double::from(phi));
            load.process.as_ref().map_or(0.0, |law| law.at_in(law.segment(phi, true), phi).0[0])
        };
        let (before, mut work, mut exchanged) = (energy(drive), 0.0, 0.0);
        let rate = drive.parameters.equation().under(&scene.load).oscillator.rates().1.max(6.0 * w.abs());
        for ends in stops.windows(2).filter(|ends| ends[1] - ends[0] > 1e-9 * end) {
            let count = (1.0 + (ends[1] - ends[0]) * rate / 4.0).floor();
            let length = (ends[1] - ends[0]) / count;
            for i in 0..count as u32 {
                let start = ends[0] + f64::from(i) * length;
                let [part, size] = Gauss::with(16).integrate(length, |s| {
                    let there = &mut drive.clone();
                    there.advance(start, s).unwrap();
                    let (v, r) = (get(there, "der(y)"), get(there, "der(q)"));
                    let x1 = v - r;
                    let p = force(&scene.load, get(there, "phi"));
                    let [b_r, b_x] = [&scene.load, &on_roller].map(|load| load.damping.unwrap_or(0.0));
                    let power = get(there, "tau") * w + p * v - b * r * r - b_r * v * v - b_x * x1 * x1;
                    [power, power.abs()]
                });
                (work, exchanged) = (work + part, exchanged + size);
                drive.advance(start, start + length - start).unwrap();
            }
        }
        let missed = (energy(drive) - before - work).abs();
        assert!(missed < 1e-11 * (exchanged + before.abs()), "{number}: {missed:e} of {exchanged:e}: {scene:?}");
    }
}

fn moved(points: &Points) -> Points {
    let Points { angles, lifts } = points;
    Points { angles: angles.iter().map(|phi| phi + 1.0).collect(), lifts: lifts.iter().map(|u| 3.0 * u).collect() }
}

/// The law with its angles moved by a radian and its values three times as large.
fn turned(law: &MotionLaw) -> MotionLaw {
    match law {
        MotionLaw::Fourier(series) => MotionLaw::Fourier(series.delayed(1.0).scaled(3.0)),
        MotionLaw::Cycle(cycle) => {
            let plan = *cycle.plan();
            let rise_start = (plan.rise_start + 1.0).rem_euclid(TAU);
            MotionLaw::Cycle(Cycle::new(CyclePlan {
                stroke: 3.0 * plan.stroke,
                lower: 3.0 * plan.lower,
                rise_start,
                ..plan
            }))
        }
        MotionLaw::Table(table) => MotionLaw::Table(Table::new(moved(table.points())).unwrap()),
        MotionLaw::Polyline(lines) => MotionLaw::Polyline(Polyline::new(moved(lines.points())).unwrap()),
        MotionLaw::Plan(_) | MotionLaw::Crank(_) => unreachable!("no random law is a plan or a crank"),
    }
}

#[test]
fn neither_size_nor_origin_of_the_angle_changes_the_motion_and_the_estimate_covers_the_error() {
    let dice = &mut Dice(5);
    let (mut covered, mut count) = (0, 0);
    for number in 0..120 {
        let (scene, [phi, w], end) = random_scene(dice, KINDS[number % 4]);
        let spring = scene.load.spring.map(|s| Spring { preload: 3.0 * s.preload, at: 3.0 * s.at, ..s });
        let load = Load {
            gravity: scene.load.gravity.map(|g| 3.0 * g),
            constant: scene.load.constant.map(|f| 3.0 * f),
            process: scene.load.process.as_ref().map(turned),
            spring,
            ..scene.load.clone()
        };
        let start = Start { q: 3.0 * scene.start.q, q_dot: 3.0 * scene.start.q_dot, ..scene.start };
        let mode = DriveMode::Constant { w, phi_start: phi + 1.0 };
        let larger = Scene { load, cam: turned(&scene.cam), drive: mode, start, ..scene.clone() };
        let (mut one, mut other) = (drive(scene.clone()), drive(larger));
        let (mut error, mut largest) = (0.0_f64, 0.0_f64);
        for n in 1..=20 {
            let [from, to] = [n - 1, n].map(|n| end * f64::from(n) / 20.0);
            one.advance(from, to - from).unwrap();
            other.advance(from, to - from).unwrap();
            let [q, expected] = [get(&one, "q"), get(&other, "q") / 3.0];
            (error, largest) = (error.max((q - expected).abs()), largest.max(q.abs()));
        }
        assert!(error < 1e-11 * largest, "{number}: {error:e} of {largest:e}: {scene:?}");
        let estimate = one.statistics()[2] + other.statistics()[2];
        (covered, count) = (covered + u32::from(error <= estimate * largest), count + 1);
    }
    assert!(covered * 100 >= 98 * count, "{covered} of {count}");
}

#[test]
fn the_estimate_covers_the_error_of_coarse_tolerances() {
    let dice = &mut Dice(6);
    let (mut covered, mut count) = (0, 0);
    for number in 0..60 {
        let (mut scene, [phi, w], end) = random_scene(dice, KINDS[number % 4]);
        let size = 0.3 * scene.parameters.c * scene.cam.bound(0);
        (scene.load.input, scene.drive) = (true, DriveMode::Input);
        let motion = [phi, w, 0.3 * w / end];
        let of = |tolerance: f64| {
            let mut scene = scene.clone();
            scene.solver.tolerance = tolerance;
            let drive = run_under(&scene, motion, end, 60, size);
            (get(&drive, "q"), drive.statistics()[2], drive.loaded.as_ref().unwrap().largest)
        };
        let ((truth, ..), (q, estimate, largest)) = (of(1e-13), of(dice.magnitude(1e-9, 1e-3)));
        (covered, count) = (covered + u32::from((q - truth).abs() <= estimate * largest), count + 1);
    }
    assert!(covered * 100 >= 98 * count, "{covered} of {count}");
}

#[test]
fn a_drive_under_loads_is_restored_bit_by_bit_and_tuned_as_one_that_starts_there() {
    let dice = &mut Dice(8);
    for number in 0..16 {
        let (mut scene, [phi, w], end) = random_scene(dice, KINDS[number % 4]);
        (scene.load.input, scene.load.damping) = (true, Some(0.1 * scene.parameters.b));
        scene.load.process = Some(random_process(dice, scene.parameters.c * scene.cam.bound(0), KINDS[number % 4][1]));
        let mut original = drive(scene.clone());
        let made = original.clone();
        set(&mut original, "F", 0.1 * scene.parameters.c * scene.cam.bound(0));
        run(&mut original, end, 0.013 * end);
        // The first tunable of a law: a coefficient, a stroke, a factor.
        let list = original.variables();
        let first = list.0.iter().find(|v| v.description.name.starts_with("load.process.")).unwrap();
        let tuned_to = 1.5 * first.value(&original);
        for tuned in [false, true] {
            if tuned {
                first.set(&mut original, tuned_to);
                set(&mut original, "load.b", 0.2 * scene.parameters.b);
            }
            let bytes = postcard::to_stdvec(&original).unwrap();
            let mut copy: ElasticOutput = postcard::from_bytes(&bytes).unwrap();
            let mut made = made.clone();
            if tuned {
                first.set(&mut made, tuned_to);
                set(&mut made, "load.b", 0.2 * scene.parameters.b);
            }
            copy.restored(&made).unwrap();
            let before = original.deformation();
            for drive in [&mut original, &mut copy] {
                set_derivative(drive, "F", 1, 3.0);
                drive.apply(drive.now.time).unwrap();
                let now = drive.now.time;
                run(drive, now + 0.5 * end, 0.1 * end);
            }
            assert_eq!(original.deformation(), copy.deformation(), "{number}: {scene:?}");
            assert_eq!(get(&original, "contact_force"), get(&copy, "contact_force"));
            if tuned {
                let time = made_time(end);
                let start = Start { mode: StartMode::Given, q: before[0], q_dot: before[1] };
                let mode = DriveMode::Constant { w, phi_start: phi + w * time };
                let mut fresh = ElasticOutput::new(Scene { start, drive: mode, ..scene.clone() }).unwrap();
                first.set(&mut fresh, tuned_to);
                set(&mut fresh, "load.b", 0.2 * scene.parameters.b);
                set(&mut fresh, "F", 0.1 * scene.parameters.c * scene.cam.bound(0));
                fresh.start(0.0).unwrap();
                set_derivative(&mut fresh, "F", 1, 3.0);
                run(&mut fresh, 0.5 * end, 0.1 * end);
                let size = scene.cam.bound(0) + before[0].abs();
                let rate = fresh.response.equation().oscillator.stiffness().sqrt();
                assert_near(
                    off(original.deformation(), fresh.deformation(), size, rate),
                    1e-11,
                    &format!("{number}: {scene:?}"),
                );
            }
        }
    }
}

/// The time at which the parameters are tuned.
fn made_time(end: f64) -> f64 {
    1.5 * end
}

#[test]
fn a_mass_without_springs_falls() {
    // c = 0: free fall, slowed by b and b_r down to a steady speed.
    for (b_r, b) in [(0.0, 0.0), (3.0, 0.0), (1e-6, 0.0), (100.0, 50.0)] {
        let process = Some(MotionLaw::Fourier(Fourier::new(vec![6.0], vec![])));
        let load = Load { gravity: Some(-9.81), damping: Some(b_r), process, ..Load::default() };
        let mode = DriveMode::Constant { w: 0.0, phi_start: 1.0 };
        let mut drive = drive(Scene { load, ..scene([2.0, 0.0, b], hs(0.06), mode, at_rest()) });
        let start = get(&drive, "y");
        for time in [0.001, 1.0, 30.0] {
            run(&mut drive, time, time);
            let (g, k) = (6.0 / 2.0 - 9.81, (b + b_r) / 2.0);
            let x: f64 = k * time;
            let fallen = if x < 1e-2 {
                g * time * time * (0.5 - x / 6.0 + x * x / 24.0 - x * x * x / 120.0 + x.powi(4) / 720.0)
            } else {
                g / k * (time + (-x).exp_m1() / k)
            };
            assert_close(
                get(&drive, "y") - start,
                fallen,
                1e-12 * (fallen.abs() + 0.1),
                &format!("{b_r} {b} after {time} s"),
            );
        }
    }
}

#[test]
fn the_log_tells_once_that_the_cam_begins_to_pull() {
    let of = |preload: f64, load: Load| {
        let spring = Some(Spring { preload, c: 2500.0, at: 0.0 });
        let load = Load { spring: load.spring.map_or(spring, |_| None), ..load };
        let mode = DriveMode::Constant { w: 100.0, phi_start: 0.0 };
        let mut drive = drive(Scene { load, ..scene([0.6, 1e6, 20.0], hs(0.02), mode, at_rest()) });
        for n in 0..200 {
            drive.advance(f64::from(n) * 1e-3, 1e-3).unwrap();
        }
        let log: Vec<String> = drive.log.iter().map(|e| format!("{} {} {}", e.time, e.kind, e.value)).collect();
        log
    };
    let told = of(30.0, Load::default());
    assert!(told.len() == 1 && told[0].contains("BacklashDrive with s = \"inf\""), "{told:?}");
    assert_eq!(of(3000.0, Load::default()).len(), 0);
    // Neither damping nor a process force holds a follower.
    assert_eq!(of(0.0, Load { spring: Some(Spring::default()), damping: Some(3.0), ..Load::default() }).len(), 0);
}

#[test]
fn dependencies_and_derivatives_of_a_drive_under_loads() {
    let law = |a: f64| Some(MotionLaw::Fourier(Fourier::new(vec![a, 20.0], vec![0.0, 7.0])));
    let load = Load { input: true, process: law(3.0), ..load_q() };
    let roller = Load { damping: Some(2.0), process: None, ..load_q() };
    for (m_roller, on_roller) in [(0.0, Load::default()), (0.7, roller.clone()), (0.0, roller)] {
        let has_roller = m_roller > 0.0;
        let scene = Scene {
            load: load.clone(),
            roller: (m_roller, on_roller),
            ..scene([1.5, 8e3, 7.0], MotionLaw::Fourier(series()), DriveMode::Input, given())
        };
        let model = MODELS.iter().find(|m| m.name == ElasticOutput::MODEL).unwrap();
        let mut any = (model.build)(&postcard::to_stdvec(&(&scene, [0_u8; 0].as_slice())).unwrap()).unwrap();
        any.set_up(0.0, None);
        for (name, value) in [("phi", 0.7), ("w", 20.0), ("a", 5.0), ("F", 11.0)] {
            any.set(super::reference(&any, name), value).unwrap();
        }
        any.start().unwrap();
        any.advance(0.0, 0.01).unwrap();
        let all = any.descriptions().to_vec();
        let is_known = |i: &usize| all[*i].state || all[*i].causality == Causality::Input;
        let knowns: Vec<usize> = (0..all.len()).filter(is_known).collect();
        assert_eq!(knowns.len(), 6);
        assert_eq!(all.iter().any(|d| d.name == "m_roller"), has_roller);
        for (i, unknown) in all.iter().enumerate().filter(|(_, d)| d.causality == Causality::Output) {
            for &known in &knowns {
                let derivative = any.directional_derivatives(&[i], &[(known, 1.0)]).unwrap()[0];
                let declared = unknown.dependencies.contains(&all[known].name);
                assert_eq!(derivative != 0.0, declared, "∂{}/∂{}", unknown.name, all[known].name);
            }
        }
        // Time derivatives, by a short step.
        let mut drive = ElasticOutput::new(scene).unwrap();
        let enter = |drive: &mut ElasticOutput| {
            for (name, value) in [("phi", 0.7), ("w", 20.0), ("a", 5.0), ("F", 11.0)] {
                set(drive, name, value);
            }
            set_derivative(drive, "F", 1, 300.0);
        };
        enter(&mut drive);
        drive.start(0.0).unwrap();
        drive.advance(0.0, 0.01).unwrap();
        let list = drive.variables();
        let h = 1e-5;
        let ahead = [-h, h].map(|dt| {
            let mut there = ElasticOutput::new(drive_scene(&drive)).unwrap();
            enter(&mut there);
            there.start(0.0).unwrap();
            there.advance(0.0, 0.01 + dt).unwrap();
            there
        });
        for v in list.0.iter().filter(|v| v.series().is_some()) {
            let series = (v.series().unwrap())(&drive, Seed::Time, v.index);
            let [back, now, on] = [&ahead[0], &drive, &ahead[1]].map(|d| v.value(d));
            let scale = now.abs() + series.derivative(1).abs() / 100.0 + series.derivative(2).abs() / 1e4;
            assert_close(series.0[0], now, 1e-15 * now.abs(), &v.description.name);
            assert_close(series.derivative(1), (on - back) / (2.0 * h), 1e-6 * scale * 100.0, &v.description.name);
            assert_close(
                series.derivative(2),
                (on - 2.0 * now + back) / (h * h),
                1e-3 * scale * 1e4,
                &v.description.name,
            );
        }
    }
}

/// The scene from which this drive on inputs was made.
fn drive_scene(drive: &ElasticOutput) -> Scene {
    let loaded = drive.loaded.as_ref().unwrap();
    let [load, roller] = (*loaded.loads).clone();
    Scene {
        load,
        roller: (loaded.m_roller, roller),
        ..scene([1.5, 8e3, 7.0], MotionLaw::Fourier(series()), DriveMode::Input, given())
    }
}
