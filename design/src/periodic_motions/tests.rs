//! All periodic motions: the machine with one or three of them, the loom, the free motion.

use super::*;
use camdrive::drives::rigid_machine::{Follower, InertiaFunction};
use camdrive::drives::settings::Settings;
use camdrive::motion::{Fourier, MotionLaw};
use camdrive::numerics::period_map::spectral_radius;

/// The machine at φ = 0.
fn started(scene: &Scene) -> RigidMachine {
    let mut machine = RigidMachine::new(scene.clone()).unwrap();
    machine.start(0.0).unwrap();
    machine
}

/// J = 1 + 0.3 tanh(4 sin φ), whose harmonics fall like e^{−0.38 k}.
fn machine(s_k: f64, lag: Option<f64>) -> Scene {
    let n = 401;
    let angles = (0..n).map(|i| TAU * f64::from(i) / f64::from(n));
    let values: Vec<f64> = angles.clone().map(|phi| 0.3 * (4.0 * phi.sin()).tanh()).collect();
    let coefficient = |k: usize, f: fn(f64) -> f64| {
        let sum: f64 = angles.clone().zip(&values).map(|(phi, v)| v * f(k as f64 * phi)).sum();
        sum * if k == 0 { 1.0 } else { 2.0 } / f64::from(n)
    };
    let a = (0..=90).map(|k| coefficient(k, f64::cos)).collect();
    let b = (0..=90).map(|k| coefficient(k, f64::sin)).collect();
    Scene {
        loads: vec![Default::default()],
        inertia: InertiaFunction { constant: 1.0, varying: Some(MotionLaw::Fourier(Fourier::new(a, b))) },
        followers: Vec::new(),
        motor: Motor::Kloss(Kloss {
            breakdown_torque: 15.0,
            breakdown_slip: s_k,
            synchronous_speed: 50.0,
            dynamics: lag,
        }),
        phi_start: 0.0,
        w_start: 0.0,
        start: MachineStart::Given,
        solver: Settings::default(),
    }
}

#[test]
fn a_machine_may_have_three_periodic_motions() {
    let motions = periodic_motions(&machine(0.08, None), 0.0).unwrap();
    let expected = [(1487.91, true), (1100.23, false), (973.06, true)];
    assert_eq!(motions.len(), 3, "{motions:?}");
    for (motion, (energy, stable)) in motions.iter().zip(expected) {
        assert!((motion.energy - energy).abs() < 6e-3, "{} {energy}", motion.energy);
        assert_eq!(motion.is_stable(), stable);
        assert_eq!(motion.is_stable(), motion.multiplier() < 1.0);
        // ∮ dφ/ω by the trapezoidal rule over the course.
        let sum: f64 =
            motion.course.windows(2).map(|p| (p[1][0] - p[0][0]) * 0.5 * (1.0 / p[0][1] + 1.0 / p[1][1])).sum();
        assert!((sum / motion.period - 1.0).abs() < 1e-4, "{sum} {}", motion.period);
    }
    assert_eq!(periodic_motions(&machine(0.15, None), 0.0).unwrap().len(), 1);
    // A short lag changes them little.
    let lagging = periodic_motions(&machine(0.08, Some(1e-4)), 0.0).unwrap();
    assert_eq!(lagging.len(), 3);
    for (with, without) in lagging.iter().zip(&motions) {
        assert!((with.period / without.period - 1.0).abs() < 2e-3);
        assert!(with.course.len() > 700);
    }
}

#[test]
fn the_motion_that_a_simulation_starts_with_is_one_of_them() {
    for load in [0.0, 9.0, -9.0] {
        let scene = Scene { start: MachineStart::SteadyState, ..machine(0.3, None) };
        let mut drive = RigidMachine::new(scene.clone()).unwrap();
        let list = drive.variables();
        let variable = |name: &str| &list.0[list.reference(name).unwrap()];
        variable("tau").set(&mut drive, load);
        drive.start(0.0).unwrap();
        let [period, w] = ["start.period", "w"].map(|name| variable(name).value(&drive));
        let motions = periodic_motions(&scene, load).unwrap();
        // A load is also balanced by a motion beyond the breakdown slip, slower for one that brakes and faster for one
        // that drives, which is unstable.
        assert_eq!(motions.len(), if load == 0.0 { 1 } else { 2 }, "{load}");
        let stable: Vec<_> = motions.iter().filter(|motion| motion.is_stable()).collect();
        assert_eq!(stable.len(), 1);
        assert_eq!(motions[0] == *stable[0], load >= 0.0);
        assert!((stable[0].period / period - 1.0).abs() < 1e-12, "{load}");
        let [low, high] = range(&stable[0].course);
        assert!(low <= w && w <= high);
    }
    // Beyond the breakdown torque there is none.
    assert!(periodic_motions(&machine(0.3, None), 16.0).unwrap().is_empty());
    let without = Scene { motor: Motor::None, ..machine(0.3, None) };
    assert!(periodic_motions(&without, 0.0).is_err());
}

/// J = J0 + m U′² with U′ = r sin φ: where the tool rests next to nothing is left of 0.88 kg·m².
#[test]
fn a_machine_of_next_to_no_inertia_at_a_rest_has_the_motion_that_a_simulation_starts_with() {
    for constant in [1e-3, 1e-6, 1e-9] {
        for phase in [0.0, 1.0] {
            let cam = MotionLaw::Fourier(Fourier::new(vec![0.0, 0.1 * f64::cos(phase)], vec![0.1 * f64::sin(phase)]));
            let scene = Scene {
                inertia: InertiaFunction { constant, varying: None },
                followers: vec![Follower::new(88.0, cam)],
                start: MachineStart::SteadyState,
                ..machine(0.2, None)
            };
            let mut drive = RigidMachine::new(scene.clone()).unwrap();
            drive.start(0.0).unwrap();
            let list = drive.variables();
            let [period, energy] =
                ["start.period", "E"].map(|name| list.0[list.reference(name).unwrap()].value(&drive));
            let motions = periodic_motions(&scene, 0.0).unwrap();
            let stable: Vec<_> = motions.iter().filter(|motion| motion.is_stable()).collect();
            assert_eq!(stable.len(), 1, "{constant} {phase}");
            assert!(
                (stable[0].period / period - 1.0).abs() < 1e-9,
                "{constant} {phase}: {} {period}",
                stable[0].period
            );
            assert!(
                (stable[0].energy / energy - 1.0).abs() < 1e-9,
                "{constant} {phase}: {} {energy}",
                stable[0].energy
            );
        }
    }
}

#[test]
fn the_free_motion_keeps_its_energy_and_its_period() {
    let scene = machine(0.3, None);
    let inertia = Inertia::new(scene.inertia, scene.followers);
    let course = free_motion(&inertia, 0.125, -1.0);
    let energy = |[phi, w]: [f64; 2]| inertia.at(Place::at(phi), phi)[0] * w * w;
    let first = energy(course[0]);
    assert!(course.iter().all(|at| (energy(*at) / first - 1.0).abs() < 1e-13 && at[1] < 0.0));
    // The trapezoidal rule over a whole turn of a smooth periodic function is exact to rounding, by the points at equal distances.
    let even = |phi: f64| (phi * 720.0 / TAU - (phi * 720.0 / TAU).round()).abs() < 1e-9;
    let times: Vec<f64> = course.iter().filter(|at| even(at[0])).map(|[_, w]| TAU / 720.0 / w.abs()).collect();
    assert_eq!(times.len(), 721);
    let period: f64 = times[1..].iter().sum();
    assert!((period / 0.125 - 1.0).abs() < 1e-12, "{period}");
}

#[test]
fn the_free_motion_with_next_to_no_inertia_where_the_follower_rests() {
    for constant in [0.1, 1e-3, 1e-6] {
        let law = MotionLaw::Fourier(Fourier::new(vec![0.0, 0.3], vec![]));
        let inertia = Inertia::new(InertiaFunction { constant, varying: None }, vec![Follower::new(2.0, law)]);
        // ∮ √(J₀ + m a² sin² φ) dφ = 4 √(J₀ + m a²) E(k), k² = m a²/(J₀ + m a²), by the arithmetic-geometric mean.
        let most = constant + 2.0 * 0.3 * 0.3;
        let (mut a, mut b, mut weight) = (1.0, (constant / most).sqrt(), 1.0);
        let mut sum = 0.5 * (1.0 - constant / most);
        for _ in 0..12 {
            let c: f64 = 0.5 * (a - b);
            (a, b) = (0.5 * (a + b), (a * b).sqrt());
            sum += weight * c * c;
            weight *= 2.0;
        }
        let action = 4.0 * most.sqrt() * (0.25 * TAU / a) * (1.0 - sum);
        let [_, fastest] = range(&free_motion(&inertia, 0.125, 1.0));
        let expected = action / 0.125 / constant.sqrt();
        assert!((fastest / expected - 1.0).abs() < 1e-12, "{constant}: {fastest} {expected}");
    }
}

/// A machine of constant inertia.
fn uniform(s_k: f64, synchronous_speed: f64, lag: Option<f64>) -> Scene {
    Scene {
        inertia: InertiaFunction { constant: 2.0, varying: None },
        motor: Motor::Kloss(Kloss { breakdown_torque: 15.0, breakdown_slip: s_k, synchronous_speed, dynamics: lag }),
        ..machine(s_k, None)
    }
}

/// The slips s at which 2 M_K s s_K/(s² + s_K²) = τ, the slow motion last.
fn slips(s_k: f64, load: f64) -> [f64; 2] {
    let root = (15.0_f64.powi(2) - load * load).sqrt();
    [(15.0 - root) / load * s_k, (15.0 + root) / load * s_k]
}

/// M_Kloss′(ω) at the slip s.
fn steepness(s: f64, s_k: f64, w_s: f64) -> f64 {
    -2.0 * 15.0 * s_k / w_s.abs() * (s_k * s_k - s * s) / (s * s + s_k * s_k).powi(2)
}

#[test]
fn the_multiplier_of_a_machine_of_constant_inertia_in_closed_form() {
    // exp(2π M′(ω)/(J ω)), from motors that hardly pull to those whose multiplier is no number any more.
    for (s_k, w_s) in [(0.2, 50.0), (0.03, 50.0), (0.03, -50.0), (1e-3, 5.0), (1e-5, 2.0)] {
        let load = 6.0 * f64::signum(w_s);
        let motions = periodic_motions(&uniform(s_k, w_s, None), load).unwrap();
        assert_eq!(motions.len(), 2, "{s_k}");
        for (motion, s) in motions.iter().zip(slips(s_k, load.abs())) {
            let w = w_s * (1.0 - s);
            let growth = TAU * steepness(s, s_k, w_s) / (2.0 * w.abs());
            assert!((motion.growth / growth - 1.0).abs() < 1e-9, "{s_k} {s}: {} {growth}", motion.growth);
            assert_eq!(motion.is_stable(), s < s_k);
            assert!((motion.period * w.abs() / TAU - 1.0).abs() < 1e-12);
            assert!(motion.course.iter().all(|at| (at[1] / w - 1.0).abs() < 1e-11), "{s_k} {s}");
            assert!(motion.multiplier() >= 0.0);
        }
    }
}

#[test]
fn the_multiplier_is_the_slope_of_the_map() {
    // A central difference of order 4 of E(0) → E(2π), where the motor is soft enough for it.
    for (s_k, load) in [(0.08, 0.0), (0.3, 9.0), (0.5, -6.0)] {
        let scene = machine(s_k, None);
        let drive = started(&scene);
        let map = TurnMap::new(drive.mesh(), load, PERIODIC_TOLERANCE, None).unwrap();
        for motion in periodic_motions(&scene, load).unwrap() {
            let gain = |part: f64| map.shoot(motion.energy * (1.0 + part)).unwrap().gain;
            let h = 1e-3;
            let slope = (8.0 * (gain(h) - gain(-h)) - (gain(2.0 * h) - gain(-2.0 * h))) / (12.0 * h * motion.energy);
            assert!((motion.multiplier() - 1.0 - slope).abs() < 2e-7, "{s_k}: {} {slope}", motion.multiplier());
        }
    }
}

#[test]
fn the_multipliers_of_a_lagging_torque_in_closed_form() {
    // q″ + q′/(T ω) + k q = 0 with constant coefficients: exp(2π Re λ), real and complex ones.
    let (s_k, load, w_s) = (0.3, 9.0, 50.0);
    for lag in [1.0, 0.2, 0.02, 1e-3, 1e-6] {
        let motions = periodic_motions(&uniform(s_k, w_s, Some(lag)), load).unwrap();
        assert_eq!(motions.len(), 2, "{lag}");
        for (motion, s) in motions.iter().zip(slips(s_k, load)) {
            let w = w_s * (1.0 - s);
            let (d, k) = (1.0 / (lag * w), -steepness(s, s_k, w_s) / (2.0 * w * w * lag));
            let discriminant = 0.25 * d * d - k;
            // The greater root of λ² + d λ + k = 0.
            let rate = if discriminant < 0.0 { -0.5 * d } else { -k / (0.5 * d + discriminant.sqrt()) };
            // Where the torque follows at once: k/d² of the rate is neglected.
            let bound = if lag < 1e-5 { 2.0 * (k / d / d).abs() } else { 1e-8 };
            assert!((motion.growth / (TAU * rate) - 1.0).abs() < bound, "{lag} {s}: {} {}", motion.growth, TAU * rate);
        }
    }
}

#[test]
fn the_multipliers_of_a_lagging_torque_are_those_of_the_map() {
    // J varies: the map (v, M) → (v, M) by differences, its determinant exp(−T/T_el).
    let (lag, load) = (1.0, 9.0);
    let scene = machine(0.3, Some(lag));
    let motions = periodic_motions(&scene, load).unwrap();
    assert_eq!(motions.len(), 2);
    let inertia = Inertia::new(scene.inertia.clone(), scene.followers.clone());
    let (interval, angle) = inertia.interval(0.0, true);
    let start = State { interval, angle: angle.into(), ..State::default() };
    let at_start = |motion: &PeriodicMotion| [(2.0 * motion.energy).sqrt(), motion.torque];
    for motion in motions {
        let turn = LaggingTurn::new(&inertia, &scene.motor, load, &start, None);
        let y = at_start(&motion);
        let after = |k: [f64; 2]| turn.after([y[0] * (1.0 + k[0]), y[1] + 15.0 * k[1]]).unwrap();
        let column = |k: [f64; 2], scale: f64| {
            let h = 1e-4;
            let [up, down] = [after([k[0] * h, k[1] * h]), after([-k[0] * h, -k[1] * h])];
            [0, 1].map(|i| (up[i] - down[i]) / (2.0 * h * scale))
        };
        let [[a, c], [b, d]] = [column([1.0, 0.0], y[0]), column([0.0, 1.0], 15.0)];
        let determinant = a * d - b * c;
        assert!((determinant / (-motion.period / lag).exp() - 1.0).abs() < 1e-4, "{determinant}");
        let radius = spectral_radius(&[[a, b], [c, d]]);
        assert!((motion.multiplier() / radius - 1.0).abs() < 1e-5, "{} {radius}", motion.multiplier());
    }
}

#[test]
fn a_torque_that_lags_by_many_turns() {
    // M_an ≈ τ and so E are constant, and the speed √(2E/J) is that at which the characteristic has the mean τ in time:
    // ∮(M_Kloss − τ)√J dφ = 0, to first order in T/T_el. J varies by a factor of about 7, and ω beyond the breakdown slip.
    let series = Fourier::new(vec![0.0, 0.2, 0.06], vec![0.0, 0.0, 0.02]);
    let inertia: Vec<f64> =
        (0..4000).map(|i| 0.3 + 10.0 * series.at(TAU * f64::from(i) / 4000.0).0[1].powi(2)).collect();
    let motor = |lag| {
        Motor::Kloss(Kloss { breakdown_torque: 100.0, breakdown_slip: 0.1, synchronous_speed: 60.0, dynamics: lag })
    };
    let load = 20.0;
    let mut excess =
        |v: f64| inertia.iter().map(|j| (motor(None).characteristic(v / j.sqrt())[0] - load) * j.sqrt()).sum::<f64>();
    for lag in [1.0, 10.0, 100.0] {
        let scene = Scene {
            inertia: InertiaFunction { constant: 0.3, varying: None },
            followers: vec![Follower::new(10.0, MotionLaw::Fourier(series.clone()))],
            motor: motor(Some(lag)),
            ..machine(0.1, None)
        };
        let motions = periodic_motions(&scene, load).unwrap();
        assert_eq!(motions.len(), 1, "{lag}");
        let v = (2.0 * motions[0].energy).sqrt();
        let ends = [0.95 * v, 1.05 * v];
        let values = ends.map(&mut excess);
        let constant = crate::search::zero(&mut excess, ends, values, 0.0);
        let expected = inertia.iter().map(|j| j.sqrt()).sum::<f64>() * TAU / 4000.0 / constant;
        let off = motions[0].period / expected - 1.0;
        assert!(off.abs() < 0.01 * expected / lag, "{lag}: {off:e}");
        assert!((motions[0].torque / load - 1.0).abs() < 0.2 * expected / lag, "{lag}: {}", motions[0].torque);
    }
}

#[test]
fn motions_that_cannot_be_followed_are_told() {
    // Without lag there are two. With it disturbances leave the slow one 10^80 times larger after a turn, and Newton's method
    // slides to the fast one.
    let scene = |lag| Scene {
        inertia: InertiaFunction {
            constant: 1.0,
            varying: Some(MotionLaw::Fourier(Fourier::new(vec![0.0, 0.02], vec![]))),
        },
        motor: Motor::Kloss(Kloss {
            breakdown_torque: 400.0,
            breakdown_slip: 0.01,
            synchronous_speed: 10.0,
            dynamics: lag,
        }),
        ..machine(0.01, None)
    };
    let without = periodic_motions(&scene(None), 160.0).unwrap();
    let all = all_motions(&scene(Some(1e-3)), 160.0).unwrap();
    assert_eq!((without.len(), all.found.len(), all.lost.len()), (2, 1, 1));
    assert!(all.found[0].is_stable() && (all.found[0].period / without[0].period - 1.0).abs() < 1e-9);
    assert!((all.lost[0] / without[1].period - 1.0).abs() < 1e-9);
    // A soft motor hides none.
    assert!(all_motions(&uniform(0.3, 50.0, Some(1e-3)), 6.0).unwrap().lost.is_empty());
}

#[test]
fn the_least_and_the_largest_speed_do_not_depend_on_the_origin_of_the_angle() {
    let at = |shift: f64, s_k: f64, w_s: f64, lag: Option<f64>| {
        let scene = machine(s_k, lag);
        let Some(MotionLaw::Fourier(series)) = &scene.inertia.varying else { unreachable!() };
        let varying = Some(MotionLaw::Fourier(series.delayed(shift)));
        let Motor::Kloss(kloss) = scene.motor else { unreachable!() };
        let motor = Motor::Kloss(Kloss { synchronous_speed: w_s, ..kloss });
        Scene { inertia: InertiaFunction { varying, ..scene.inertia }, motor, ..scene }
    };
    let near = |[a, b]: [f64; 2], [c, d]: [f64; 2]| (a / c - 1.0).abs().max((b / d - 1.0).abs());
    for (s_k, lag) in [(0.08, None), (0.08, Some(1e-3)), (0.3, Some(0.05))] {
        let own = periodic_motions(&at(0.0, s_k, 50.0, lag), 0.0).unwrap();
        for i in 1..8 {
            let turned = periodic_motions(&at(0.7313 * f64::from(i), s_k, 50.0, lag), 0.0).unwrap();
            assert_eq!(turned.len(), own.len());
            for (turned, own) in turned.iter().zip(&own) {
                let error = near(range(&turned.course), range(&own.course));
                assert!(error < 2e-11, "{s_k} {lag:?} {i}: {error:e}");
                let mut last = f64::NEG_INFINITY;
                for [phi, _] in &turned.course {
                    assert!(*phi > last, "{phi} after {last}");
                    last = *phi;
                }
            }
        }
        // J(φ) is odd but for its mean: the machine that turns the other way is that machine half a turn later.
        for (back, own) in periodic_motions(&at(0.5 * TAU, s_k, -50.0, lag), 0.0).unwrap().iter().zip(&own) {
            let [low, high] = range(&own.course);
            assert!(near(range(&back.course), [-high, -low]) < 2e-11, "{s_k} {lag:?}");
            assert!(back.course.windows(2).all(|pair| pair[1][0] < pair[0][0]));
        }
    }
    // ω √J is constant, and J reaches from 1 − 0.3 tanh 4 to 1 + 0.3 tanh 4, but for the harmonics beyond the 90th.
    let of = |shift: f64| {
        let scene = at(shift, 0.3, 50.0, None);
        let inertia = Inertia::new(scene.inertia, scene.followers);
        let course = free_motion(&inertia, 0.125, -1.0);
        (range(&course), course)
    };
    let ([low, high], _) = of(0.0);
    let swing = 0.3 * 4f64.tanh();
    assert!((low / high - ((1.0 + swing) / (1.0 - swing)).sqrt()).abs() < 1e-12, "{low} {high}");
    for i in 1..20 {
        let (turned, course) = of(0.31 * f64::from(i));
        assert!(near(turned, [low, high]) < 1e-13, "{i}: {turned:?} for {low} {high}");
        assert!(course[0][0] == TAU && course[course.len() - 1][0] == 0.0);
    }
}

#[test]
fn the_extremes_of_a_press_on_a_table_are_those_of_its_crank() {
    // r = 80 mm, l = 320 mm, 45 kg, its lift as a table of 180 points; an integration of the exact crank by DOP853 says
    // 37.450898 … 41.084733 rad/s.
    let (r, l) = (0.08_f64, 0.32_f64);
    let angles: Vec<f64> = (0..180).map(|i| TAU * f64::from(i) / 180.0).collect();
    let lift = |phi: &f64| r * phi.cos() + (l * l - (r * phi.sin()).powi(2)).sqrt() - l + r;
    let lifts = angles.iter().map(lift).collect();
    let table = camdrive::motion::Table::new(camdrive::motion::table::Points { angles, lifts }).unwrap();
    let scene = Scene {
        inertia: InertiaFunction { constant: 1.5, varying: None },
        followers: vec![camdrive::drives::rigid_machine::Follower::new(45.0, MotionLaw::Table(table))],
        motor: Motor::Kloss(Kloss {
            breakdown_torque: 120.0,
            breakdown_slip: 0.18,
            synchronous_speed: 375.0 * TAU / 60.0,
            dynamics: None,
        }),
        ..machine(0.18, None)
    };
    let [low, high] = range(&periodic_motions(&scene, 0.0).unwrap()[0].course);
    assert!((low - 37.450898).abs() < 1e-6 && (high - 41.084733).abs() < 1e-6, "{low} {high}");
}
