//! Figures against closed forms, noise against what was added.

use super::roughness::{scatter, scatter_and_error};
use super::*;
use crate::law_motions::motions;
use crate::search::segments;
use crate::smoothing::{Outliers, smooth};
use crate::synthesis::laws::torque_peak;
use camdrive::drives::follower::load::Load;
use camdrive::drives::rigid_machine::{Follower, InertiaFunction, MachineStart, Motor};
use camdrive::drives::settings::Settings;
use camdrive::drives::shaft::cam_drive::{Start, StartMode};
use camdrive::drives::{backlash, elastic_shaft, rigid_machine};
use camdrive::motion::table::Points;
use camdrive::motion::{Cycle, CyclePlan, Fourier, StandardLaw, Table};
use camdrive::numerics::angle::reduce;
use std::f64::consts::TAU;

const REST: Start = Start { mode: StartMode::AtRest, q: 0.0, q_dot: 0.0 };

fn overview(scene: impl Into<Scene>) -> Overview {
    of(&Resource::new("x", scene))
}

fn assert_figures(overview: &Overview, expected: &[(&str, f64)]) {
    for (name, value) in expected {
        let figure = overview.figures.iter().find(|figure| figure.name == *name);
        let found = figure.unwrap_or_else(|| panic!("{name} is missing in {:?}", overview.figures)).value;
        assert!((found - value).abs() <= 1e-13 * value.abs(), "{name}: {found} for {value}");
    }
}

/// U = a cos φ.
fn cosine(a: f64) -> MotionLaw {
    MotionLaw::Fourier(Fourier::new(vec![0.0, a], vec![]))
}

/// The report, each table in one piece.
fn told(overview: &Overview) -> String {
    overview.report("", "").text(usize::MAX, false)
}

#[test]
fn the_figures_of_an_elastic_output_on_a_cosine_are_those_of_the_closed_form() {
    let (m, w0, d, w, a) = (12.0, 1700.0, 0.03, 190.0, 0.5e-3);
    let (c, b) = (m * w0 * w0, 2.0 * d * m * w0);
    let drive = DriveMode::Constant { w, phi_start: 0.0 };
    let scene = elastic_output::Scene {
        coupling: false,
        parameters: elastic_output::Parameters { m, c, b },
        load: Load::default(),
        roller: (0.0, Load::default()),
        cam: cosine(a),
        drive,
        start: REST,
        solver: Settings::default(),
    };
    let overview = overview(scene);
    let eta = w / w0;
    assert_figures(
        &overview,
        &[
            ("speed", w),
            ("natural_frequency", w0),
            ("damping_ratio", d),
            ("frequency_ratio", eta),
            ("stroke", 2.0 * a),
            ("largest_velocity", a * w),
            ("largest_acceleration", a * w * w),
            ("largest_kinetostatic_force", m * a * w * w),
            ("largest_kinetostatic_deformation", a * eta * eta),
            ("kinetostatic_deformation_of_stroke", 0.5 * eta * eta),
        ],
    );
    let [resonance] = overview.resonances[..] else { panic!("one harmonic: {:?}", overview.resonances) };
    assert_eq!(resonance.harmonic, 1);
    let here = a * eta * eta / (1.0 - eta * eta).hypot(2.0 * d * eta);
    assert!((resonance.amplitude.unwrap() / here - 1.0).abs() < 1e-9);
    assert!((resonance.resonant_amplitude.unwrap() / (a / (2.0 * d)) - 1.0).abs() < 1e-9);
    assert!((resonance.speed / w0 - 1.0).abs() < 1e-9);
    assert!(overview.warnings.is_empty(), "{:?}", overview.warnings);
    for part in ["1810 rpm", "271 Hz", "1 mm", "0.095 m/s", "18.1 m/s²", "217 N", "0.625 %"] {
        assert!(told(&overview).contains(part), "{part} is missing in\n{}", told(&overview));
    }
}

#[test]
fn the_figures_of_an_elastic_shaft_are_those_of_its_mean_inertia() {
    let (m, inertia, c, w, a) = (60.0, 1.5, 24e3, 5.0, 0.2);
    let drive = DriveMode::Constant { w: -w, phi_start: 0.0 };
    let (cam, solver) = (cosine(a), Settings::default());
    let scene = elastic_shaft::Scene {
        load: Default::default(),
        parameters: elastic_shaft::Parameters { m, inertia, c, b: 18.0 },
        linear: false,
        cam,
        drive,
        start: REST,
        solver,
    };
    // J = J₀ + m a² sin² φ, and ½ J′ Ω² is the torque of a rigid shaft.
    let (mean, torque) = (inertia + 0.5 * m * a * a, 0.5 * m * a * a * w * w);
    assert_figures(
        &overview(scene),
        &[
            ("natural_frequency", (c / mean).sqrt()),
            ("damping_ratio", 18.0 / (2.0 * (c * mean).sqrt())),
            ("largest_kinetostatic_torque", torque),
            ("largest_kinetostatic_deformation", torque / c),
            ("largest_kinetostatic_force", m * a * w * w),
        ],
    );
}

#[test]
fn a_drive_with_backlash_has_two_natural_frequencies_and_one_on_inputs_no_speed() {
    let (m1, m2, c) = (2.0, 8.0, 2e6);
    let (cam, drive, solver) = (cosine(0.01), DriveMode::Input, Settings::default());
    let scene = backlash::Scene {
        coupling: false,
        parameters: backlash::Parameters { m1, m2, c, b: 0.0, s: 5e-5, e: 0.0 },
        cam,
        drive,
        start: REST,
        solver,
    };
    let overview = overview(scene);
    let expected = [
        ("natural_frequency", 500.0),
        // Both masses swing against each other: 1/m = 1/m1 + 1/m2.
        ("natural_frequency_in_flight", (c / 1.6).sqrt()),
        ("clearance", 5e-5),
        ("largest_first_transfer_function", 0.01),
        ("largest_second_transfer_function", 0.01),
    ];
    assert_figures(&overview, &expected);
    assert!(
        overview.figures.iter().all(|figure| figure.name != "speed" && !figure.name.contains("_force")),
        "{:?}",
        overview.figures
    );
    assert!(told(&overview).contains("∞"), "{}", told(&overview));
}

#[test]
fn a_machine_without_motor_keeps_its_energy() {
    let (constant, m, a, w) = (0.1, 2.0, 0.3, 20.0);
    // From the middle of the stroke, where J is largest, and from anywhere.
    for phi_start in [1.5 * std::f64::consts::PI, -0.304, 200.7] {
        let scene = rigid_machine::Scene {
            loads: vec![Default::default()],
            inertia: InertiaFunction { constant, varying: None },
            followers: vec![Follower::new(m, cosine(a))],
            motor: Motor::None,
            phi_start,
            w_start: -w,
            start: MachineStart::Given,
            solver: Settings::default(),
        };
        // ω = √(2E/J), J = J₀ + m a² sin² φ; the trapezoidal rule is exact to rounding for this period.
        let root = |phi: f64| (constant + m * (a * phi.sin()).powi(2)).sqrt();
        let (least, most) = (root(0.0), root(0.5 * std::f64::consts::PI));
        let count = 4000;
        let period = (0..count).map(|i| root(TAU * i as f64 / count as f64)).sum::<f64>() / count as f64;
        let momentum = root(phi_start) * w;
        let mean = momentum / period;
        let overview = overview(scene);
        assert_figures(
            &overview,
            &[
                ("mean_speed", -mean),
                ("speed_fluctuation", (momentum / least - momentum / most) / mean),
                ("follower[1].stroke", 2.0 * a),
                ("follower[1].largest_acceleration", a * mean * mean),
            ],
        );
        for part in ["0.1 kg·m²", "0.28 kg·m²"] {
            assert!(told(&overview).contains(part), "{part} is missing in\n{}", told(&overview));
        }
    }
}

/// A table of this law with `points` points of a turn, stroke 20 mm, rise 100°, return 90°.
fn table(law: StandardLaw, points: usize, lift: impl Fn(usize, f64) -> f64) -> Table {
    let angle = |degrees: f64| degrees.to_radians();
    let plan = CyclePlan {
        stroke: 0.02,
        lower: 0.0,
        rise_start: 0.0,
        rise_angle: angle(100.0),
        upper_dwell: angle(40.0),
        return_angle: angle(90.0),
        rise_law: law,
        return_law: law,
        inflections: [None; 2],
    };
    let cycle = MotionLaw::Cycle(Cycle::new(plan));
    let angles: Vec<f64> = (0..points).map(|i| TAU * i as f64 / points as f64).collect();
    let lifts = angles.iter().enumerate().map(|(i, phi)| lift(i, cycle.at(*phi).0[0])).collect();
    Table::new(Points { angles, lifts }).unwrap()
}

/// Numbers equally distributed between −1 and 1 (splitmix64).
fn random(i: usize) -> f64 {
    let mut z = (i as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 52) as f64 - 1.0
}

/// σ̂ and the error that it makes of U″, where the table is noisy.
fn noise(table: &Table) -> Option<[f64; 2]> {
    scatter(table.points()).and_then(|_| scatter_and_error(table))
}

#[test]
fn a_table_of_a_law_is_not_noisy_and_one_with_noise_tells_its_size() {
    for law in StandardLaw::ALL {
        for points in [60, 180, 360, 720] {
            assert_eq!(noise(&table(law, points, |_, u| u)), None, "{} {points}", law.name());
        }
        // ±5 µm have the standard deviation 5 µm/√3.
        let [size, _] = noise(&table(law, 360, |i, u| u + 5e-6 * random(i))).expect("noise");
        assert!((size / (5e-6 / 3f64.sqrt()) - 1.0).abs() < 0.15, "{}: {size}", law.name());
        // Rounded to 1 µm, where the law moves: a standard deviation of 1 µm/√12 there, on 190° of 360°.
        let [size, _] = noise(&table(law, 360, |_, u| (u * 1e6).round() / 1e6)).expect("rounding");
        assert!((size / 0.21e-6 - 1.0).abs() < 0.25, "{}: {size}", law.name());
    }
    // Of any spacing.
    let angles: Vec<f64> = (0..400).map(|i| (TAU / 400.0) * (i as f64 + 0.3 * random(7 * i + 5))).collect();
    let lifts: Vec<f64> = angles.iter().enumerate().map(|(i, phi)| 0.01 * phi.cos() + 1e-6 * random(i)).collect();
    let [size, _] = noise(&Table::new(Points { angles, lifts }).unwrap()).expect("noise");
    assert!((size / (1e-6 / 3f64.sqrt()) - 1.0).abs() < 0.15, "{size}");
}

#[test]
fn noise_is_told_as_what_the_spline_makes_of_it() {
    let noisy = table(StandardLaw::ModifiedSine, 360, |i, _| 5e-6 * random(i));
    let [_, told] = noise(&noisy).expect("noise");
    let law = MotionLaw::Table(noisy);
    let square = |i: u32| law.at(TAU * (f64::from(i) + 0.5) / 4096.0).0[2].powi(2);
    let found = ((0..4096).map(square).sum::<f64>() / 4096.0).sqrt();
    assert!((told / found - 1.0).abs() < 0.15, "{told} for {found} m/rad²");
}

#[test]
fn too_few_points_are_no_noise_and_told_as_such() {
    let told = |table: Table| {
        let mut overview = Overview::default();
        overview.roughness("cam", &MotionLaw::Table(table), "m");
        overview.warnings.pop().map(|Warning { message, hint }| message + &hint)
    };
    for law in StandardLaw::ALL {
        for points in [12, 20, 24, 30, 36, 45, 72, 91] {
            assert_eq!(noise(&table(law, points, |_, u| u)), None, "{} {points}", law.name());
        }
    }
    let exact = |points| told(table(StandardLaw::ModifiedSine, points, |_, u| u));
    assert!(exact(20).expect("a warning").contains("leave U″ uncertain"));
    assert_eq!(exact(72), None);
    // A kink scatters, too, but in few rows.
    let kinked = table(StandardLaw::ModifiedSine, 360, |_, u| (u - 1e-3).max(0.0));
    assert_eq!(noise(&kinked), None);
    assert_eq!(told(kinked), None);
    // Half the noise taken out leaves a table rough, and all of it does not.
    let noisy = table(StandardLaw::ModifiedSine, 360, |i, u| u + 1e-5 * random(i));
    let smoothed = |noise| {
        smooth(noisy.points().clone(), noise, Outliers::Refuse, &[])
            .map(|smooth| told(Table::new(smooth.points).unwrap()))
    };
    assert!(smoothed(Some(2e-6)).unwrap().expect("a warning").contains("in place of a `noise` that is too small"));
    assert_eq!(smoothed(None).unwrap(), None);
    assert!(told(noisy).expect("a warning").contains("smooth it by `noise"));
}

#[test]
fn a_table_has_the_motions_of_its_law() {
    for law in [StandardLaw::ModifiedSine, StandardLaw::Polynomial345, StandardLaw::ModifiedTrapezoid] {
        for (points, within) in [(24, 0.2), (72, 0.02), (360, 2e-3), (3600, 2e-4)] {
            let mut motions = motions("cam", &MotionLaw::Table(table(law, points, |_, u| u)), "m");
            motions.sort_by(|a, b| b.lift.total_cmp(&a.lift));
            assert_eq!(motions.len(), 2, "{} {points}: {motions:?}", law.name());
            for (motion, angle) in motions.iter().zip([100_f64, 90.0]) {
                let exact = [angle.to_radians(), law.peak(1), law.peak(2), -law.peak(2), torque_peak(law)];
                let found =
                    [motion.angle, motion.velocity, motion.acceleration[0], motion.acceleration[1], motion.torque[0]];
                for (found, exact) in found.into_iter().zip(exact) {
                    assert!((found / exact - 1.0).abs() < within, "{} {points}: {motion:?}", law.name());
                }
            }
        }
    }
}

#[test]
fn a_tool_behind_mechanisms_is_told_under_its_own_name() {
    let tool = Tool { section: "follower[1].tool".to_owned(), law: cosine(0.02), unit: "m" };
    let machine = rigid_machine::Scene {
        loads: vec![Default::default()],
        inertia: InertiaFunction { constant: 1.0, varying: None },
        followers: Vec::new(),
        motor: Motor::None,
        phi_start: 0.0,
        w_start: 1.0,
        start: MachineStart::Given,
        solver: Settings::default(),
    };
    let motions = of(&Resource { tools: vec![tool], ..Resource::new("x", machine) }).motions;
    assert!(motions.len() == 2 && motions.iter().all(|motion| motion.law == "follower[1].tool"), "{motions:?}");
    assert!((motions[0].velocity - StandardLaw::SimpleSine.peak(1)).abs() < 1e-9);
}

#[test]
fn nothing_is_shown_in_a_plain_unit() {
    assert_eq!([shown(0.0, "N"), shown(0.0, "N.m"), shown(0.0, "m")], ["0 N", "0 N·m", "0 mm"]);
}

#[test]
fn the_motions_of_a_cycle_have_the_characteristic_values_of_their_laws() {
    for (law, inflection) in StandardLaw::ALL.into_iter().flat_map(|law| [(law, None), (law, Some(0.4))]) {
        let plan = CyclePlan {
            stroke: 0.04,
            lower: 0.01,
            rise_start: 5.5,
            rise_angle: 1.5,
            upper_dwell: 0.7,
            return_angle: 2.0,
            rise_law: law,
            return_law: law,
            inflections: [None, inflection],
        };
        let motions = motions("cam", &MotionLaw::Cycle(Cycle::new(plan)), "m");
        let [back, rise] = &motions[..] else { panic!("{motions:?}") };
        // An inflection at λ divides C_a₊ and C_M₊ by 2λ, C_a₋ and C_M₋ by 2(1 − λ), C_j by the square of the smaller one.
        let [p, q] = inflection.map_or([1.0; 2], |part| [2.0 * part, 2.0 - 2.0 * part]);
        for (motion, [p, q], [from, angle, lift]) in
            [(rise, [1.0; 2], [5.5, 1.5, 0.04]), (back, [p, q], [1.4168146928, 2.0, -0.04])]
        {
            for (found, value) in [motion.from, motion.angle, motion.lift].into_iter().zip([from, angle, lift]) {
                assert!((found - value).abs() < 1e-10, "{law:?} {motion:?}");
            }
            let ([a, b], [m, n]) = (motion.acceleration, motion.torque);
            let found = [motion.velocity, a * p, -b * q, motion.jerk * p.min(q).powi(2), m * p, -n * q];
            let [v, a, j, m] = [law.peak(1), law.peak(2), law.peak(3), torque_peak(law)];
            for (found, exact) in found.into_iter().zip([v, a, a, j, m, m]) {
                assert!((found / exact - 1.0).abs() < 1e-9, "{law:?} {motion:?}: {found} for {exact}");
            }
        }
    }
    // A cosine between its stops is the simple sine.
    let motions = motions("cam", &cosine(0.02), "m");
    assert_eq!(motions.len(), 2);
    assert!((motions[0].angle - TAU / 2.0).abs() < 1e-12 && (motions[0].lift.abs() - 0.04).abs() < 1e-15);
    assert!((motions[0].acceleration[0] - StandardLaw::SimpleSine.peak(2)).abs() < 1e-9);
}

/// The i-th random number between these.
fn between(low: f64, high: f64, i: usize) -> f64 {
    low + 0.5 * (high - low) * (1.0 + random(i))
}

#[test]
fn random_motions_of_all_laws_begin_and_end_at_their_rests() {
    use camdrive::motion::plan::SegmentLaw;
    use camdrive::motion::{MotionPlan, PlanPoint};
    let near = |a: f64, b: f64| (a - b - TAU * ((a - b) / TAU).round()).abs() < 1e-13;
    for i in 0..600 {
        let law = StandardLaw::ALL[i % StandardLaw::ALL.len()];
        let part = |k: usize, low: f64, high: f64| between(low, high, 8 * i + k);
        let [rise, dwell, back] =
            [part(0, 0.05, 2.5), if i % 5 == 0 { 0.0 } else { part(1, 0.01, 1.2) }, part(2, 0.05, 2.5)];
        let [start, stroke] = [part(3, -TAU, TAU), part(4, 0.005, 0.05) * if i % 2 == 0 { 1.0 } else { -1.0 }];
        let plan = CyclePlan {
            stroke,
            lower: part(5, -0.1, 0.1),
            rise_start: start,
            rise_angle: rise,
            upper_dwell: dwell,
            return_angle: back,
            rise_law: law,
            return_law: law,
            inflections: [None; 2],
        };
        let point = |phi: f64, u: f64, law: Option<SegmentLaw>| PlanPoint {
            phi: phi.rem_euclid(TAU),
            u,
            velocity: None,
            acceleration: None,
            free: false,
            jerk: None,
            law,
            inflection: None,
        };
        let fall = start + rise + dwell;
        // The law of a segment stands at its end.
        let own = Some(SegmentLaw::Standard(law));
        let mut points = vec![point(start, 0.0, None), point(start + rise, stroke, own), point(fall + back, 0.0, own)];
        if dwell > 0.0 {
            points.push(point(fall, stroke, None));
        }
        points.sort_by(|a, b| a.phi.total_cmp(&b.phi));
        for cam in [MotionLaw::Cycle(Cycle::new(plan)), MotionLaw::Plan(MotionPlan::new(points))] {
            let motions = motions("cam", &cam, "m");
            assert_eq!(motions.len(), 2, "{i} {law:?}: {motions:?}");
            for (from, angle, lift) in [(start, rise, stroke), (fall, back, -stroke)] {
                let found = motions.iter().find(|motion| near(motion.from, from));
                let motion = found.unwrap_or_else(|| panic!("{i} {law:?}: none from {from} in {motions:?}"));
                assert!((motion.angle - angle).abs() < 1e-13, "{i} {law:?}: {motion:?} for {angle}");
                assert!((motion.lift - lift).abs() < 1e-15, "{i} {law:?}: {motion:?} for {lift}");
                let ([a, b], [m, n]) = (motion.acceleration, motion.torque);
                let [v, c, j, t] = [law.peak(1), law.peak(2), law.peak(3), torque_peak(law)];
                for (value, exact) in [(motion.velocity, v), (a, c), (b, -c), (motion.jerk, j), (m, t), (n, -t)] {
                    assert!((value / exact - 1.0).abs() < 1e-11, "{i} {law:?}: {value} for {exact} in {motion:?}");
                }
            }
        }
        // A cosine between its stops is the simple sine, also where a stop lies in the middle between two samples.
        let shift = if i % 2 == 0 { start } else { TAU * (i as f64 + 0.5) / 8192.0 };
        let cosine = MotionLaw::Fourier(Fourier::new(vec![0.0, stroke], vec![]).delayed(shift));
        let motions = motions("cam", &cosine, "m");
        assert_eq!(motions.len(), 2, "{i}: {motions:?}");
        for motion in motions {
            assert!(
                near(2.0 * motion.from, 2.0 * shift) && (motion.angle - 0.5 * TAU).abs() < 1e-12,
                "{i}: {motion:?}"
            );
            assert!((motion.acceleration[0] / StandardLaw::SimpleSine.peak(2) - 1.0).abs() < 1e-11, "{i}: {motion:?}");
        }
    }
}

#[test]
fn figures_do_not_depend_on_the_origin_of_the_angle() {
    let scene = |shift: f64| {
        let plan = CyclePlan {
            stroke: 0.12,
            lower: -0.035,
            rise_start: 4.8382 + shift,
            rise_angle: 2.7733,
            upper_dwell: 0.0,
            return_angle: 3.5098,
            rise_law: StandardLaw::SimpleSine,
            return_law: StandardLaw::ModifiedSine,
            inflections: [Some(0.5481), None],
        };
        backlash::Scene {
            coupling: false,
            parameters: backlash::Parameters { m1: 0.0287, m2: 0.149, c: 2540.0, b: 41.0, s: 1.2e-4, e: 0.0 },
            cam: MotionLaw::Cycle(Cycle::new(plan)),
            drive: DriveMode::Constant { w: 41.0, phi_start: 0.0 },
            start: REST,
            solver: Settings::default(),
        }
    };
    let own = overview(scene(0.0));
    // The harmonics of U″ by Simpson's rule over each smooth part.
    let law = scene(0.0).cam;
    let mut sums = [[0.0; 2]; 8];
    for (segment, [from, to]) in segments(law.breakpoints()).into_iter().enumerate() {
        const PARTS: usize = 4000;
        let width = (to - from) / PARTS as f64;
        for i in 0..=PARTS {
            let weight = if i % PARTS == 0 { 1.0 } else { 2.0 + 2.0 * (i % 2) as f64 } * width / (1.5 * TAU);
            let phi = from + i as f64 * width;
            for (k, sum) in (1..).zip(&mut sums) {
                let (sin, cos) = (f64::from(k) * phi).sin_cos();
                let value = weight * law.at_in(segment, reduce(phi.into())).0[2];
                *sum = [sum[0] + value * cos, sum[1] + value * sin];
            }
        }
    }
    let backlash::Parameters { m2, c, b, .. } = scene(0.0).parameters;
    assert!(!own.resonances.is_empty());
    for resonance in &own.resonances {
        let (w, [a, b1]) = (41.0 * resonance.harmonic as f64, sums[resonance.harmonic - 1]);
        let amplitude = m2 * 41.0 * 41.0 * a.hypot(b1) / (c - m2 * w * w).hypot(b * w);
        assert!((resonance.amplitude.unwrap() / amplitude - 1.0).abs() < 1e-10, "{resonance:?} for {amplitude}");
    }
    for i in 0..40 {
        let other = overview(scene(between(-1.4, 1.4, i)));
        for (figure, own) in other.figures.iter().zip(&own.figures) {
            assert!((figure.value / own.value - 1.0).abs() < 1e-12, "{figure:?} and {own:?}");
        }
        for (resonance, own) in other.resonances.iter().zip(&own.resonances) {
            assert_eq!(resonance.harmonic, own.harmonic);
            assert!((resonance.amplitude.unwrap() / own.amplitude.unwrap() - 1.0).abs() < 1e-11, "{resonance:?}");
        }
    }
}

#[test]
fn jumps_and_overshoots_of_a_plan_are_told() {
    use camdrive::motion::{MotionPlan, PlanPoint};
    let point = |phi: f64, u: f64| PlanPoint {
        phi,
        u,
        velocity: None,
        acceleration: None,
        free: false,
        jerk: None,
        law: None,
        inflection: None,
    };
    let told = |points: Vec<PlanPoint>| {
        let mut overview = Overview::default();
        overview.motions("cam", &MotionLaw::Plan(MotionPlan::new(points)), "m");
        overview
    };
    // U‴ = C_j h/β³ at both ends of a modified sine.
    let jumps = told(vec![point(0.0, 0.0), point(2.0, 0.03), point(4.0, 0.01)]).jumps;
    assert!(jumps.iter().all(|jump| jump.derivative == 3) && jumps.len() == 3, "{jumps:?}");
    assert!((jumps[1].size / (StandardLaw::ModifiedSine.peak(3) * -0.05 / 8.0) - 1.0).abs() < 1e-9, "{jumps:?}");
    // A rest between two rises is a stop.
    let motions = told(vec![point(0.5, 0.0), point(1.0, 0.01), point(3.0, 0.03), point(5.0, 0.0)]).motions;
    let stops: Vec<[f64; 2]> = motions.iter().map(|motion| [motion.from, motion.lift]).collect();
    let near = |a: &[f64; 2], b: &[f64; 2]| (a[0] - b[0]).abs() < 1e-9 && (a[1] - b[1]).abs() < 1e-15;
    let expected = [[0.5, 0.01], [1.0, 0.02], [3.0, -0.03]];
    assert!(expected.iter().all(|one| stops.iter().any(|stop| near(one, stop))) && stops.len() == 3, "{stops:?}");
    let warnings =
        |points: Vec<PlanPoint>| told(points).warnings.into_iter().map(|warning| warning.message).collect::<Vec<_>>();
    assert_eq!(warnings(vec![point(0.0, 0.0), point(2.0, 0.03), point(4.0, 0.01)]), [""; 0]);
    // Half a simple sine on both sides with their inflections in the middle: vₘ (π/2)/(β/2), vₘ = (h/β)/(σ₀/2 + 1/π).
    let turn = PlanPoint { free: true, inflection: Some(0.5), ..point(2.0, 0.03) };
    let back = PlanPoint { inflection: Some(0.5), ..point(6.0, 0.0) };
    let said = warnings(vec![turn, back]);
    assert!(said.len() == 1 && said[0].starts_with("cam: U″ jumps by ") && said[0].ends_with("at 115°"), "{said:?}");
    let fast = PlanPoint { velocity: Some(0.2), ..point(2.0, 0.03) };
    let said = warnings(vec![point(0.0, 0.0), fast, point(4.0, 0.05)]);
    assert!(said.iter().any(|said| said.starts_with("cam: the motion overshoots on the way to point[")), "{said:?}");
}

/// A machine on a servo behind a gear and a coupling.
fn servo_behind_a_coupling() -> camdrive::drives::drive_train::Machine {
    use camdrive::drives::drive_train::Machine;
    use camdrive::drives::shaft::motor::{self, Reference, Servo, Source, Transmission};
    let servo = Servo {
        proportional: 2.0,
        integral: 30.0,
        anti_windup: 15.0,
        limit: 50.0,
        reference: Reference::Constant(60.0),
        position: None,
    };
    let transmission = Transmission { ratio: 3.0, rotor: 0.02, coupling: Some([500.0, 1.0]) };
    Machine {
        inertia: InertiaFunction { constant: 0.4, varying: None },
        load: None,
        friction: Some(0.05),
        loads: vec![],
        motor: motor::Motor { source: Source::Servo(servo), transmission },
        phi_start: 0.0,
        w_start: 0.0,
    }
}

#[test]
fn a_train_is_told_by_its_motor_its_shaft_and_its_followers() {
    use camdrive::drives::drive_train::{self, Follower as OfTrain, Joint, Shaft};
    use camdrive::drives::follower::load::Spring;
    let (m, c, b, back, a, w) = (3.0, 12000.0, 24.0, 1000.0, 0.01, 20.0);
    let of = |m: f64, joint: Joint, load: Load| OfTrain {
        rigid: Follower::new(m, cosine(a)),
        joint,
        load,
        roller: Load::default(),
    };
    let spring = Load { spring: Some(Spring { preload: 50.0, c: back, at: 0.0 }), ..Load::default() };
    let followers = || {
        let output = Joint::Output(elastic_output::Parameters { m, c, b }, 0.5);
        let lifted = Joint::Backlash(backlash::Parameters { m1: 0.2, m2: 0.8, c, b, s: f64::INFINITY, e: 0.0 });
        let shaft = Joint::Shaft(elastic_shaft::Parameters { m: 0.0, inertia: 0.2, c: 800.0, b: 0.0 });
        vec![
            of(0.0, output, spring.clone()),
            of(2.0, Joint::Rigid, Load::default()),
            of(0.0, lifted, spring.clone()),
            of(0.0, shaft, Load::default()),
        ]
    };
    let train = |shaft: Shaft| drive_train::Scene {
        coupling: false,
        shaft,
        followers: followers(),
        start: drive_train::Start::AtRest,
        solver: Settings::default(),
        names: drive_train::Names::default(),
    };
    let driven = train(Shaft::Driven(DriveMode::Constant { w, phi_start: 0.0 }));
    let w0 = ((c + back) / m).sqrt();
    let of_followers = [
        ("follower[1].natural_frequency", w0),
        ("follower[1].damping_ratio", b / (2.0 * m * w0)),
        ("follower[1].largest_kinetostatic_force", 50.0 + a * ((m + 0.5) * w * w - back)),
        ("follower[2].stroke", 2.0 * a),
        ("follower[2].largest_kinetostatic_force", 2.0 * a * w * w),
        ("follower[3].natural_frequency", ((c + back) / 0.8_f64).sqrt()),
        ("follower[3].natural_frequency_in_flight", (c / 0.16_f64).sqrt()),
        ("follower[4].natural_frequency", (800.0_f64 / 0.2).sqrt()),
    ];
    let found = overview(driven.clone());
    assert_figures(&found, &of_followers);
    assert_figures(&found, &[("speed", w), ("follower[1].frequency_ratio", w / w0)]);
    assert!(found.resonances.is_empty() && found.figures.iter().all(|figure| figure.name != "follower[3].clearance"));
    // J = J0 + (m_x + m + m1) U'² between its bounds.
    let found = overview(train(Shaft::Free(servo_behind_a_coupling())));
    let value = |name: &str| found.figures.iter().find(|figure| figure.name == name).map_or(f64::NAN, |f| f.value);
    let near = |name: &str, right: f64| {
        assert!((value(name) - right).abs() < 1e-3 * right, "{name}: {} for {right}", value(name));
    };
    let most = 0.4 + 2.7 * a * a;
    near("least_inertia", 0.4);
    near("largest_inertia", most);
    let (mean, rotor) = (0.5 * (0.4 + most), 9.0 * 0.02);
    near("coupling_frequency", (500.0 * (1.0 / mean + 1.0 / rotor)).sqrt());
    near("control_frequency", (30.0 * 9.0 / (mean + rotor)).sqrt());
    near("control_damping_ratio", 3.0 * 2.0 / (2.0 * (30.0 * (mean + rotor)).sqrt()));
    near("torque_limit", 50.0);
    near("mean_speed", 20.0);
    // A damping ratio above 1 of the first follower is told with its name.
    let mut stiff = driven;
    stiff.followers[0].joint = Joint::Output(elastic_output::Parameters { m, c, b: 1e4 }, 0.5);
    let warnings = overview(stiff).warnings;
    assert!(warnings.iter().any(|warning| warning.message.starts_with("follower[1].damping ratio")), "{warnings:?}");
}

/// The guide bar of the examples with this law, at this speed (rpm).
fn guide_bar(cam: MotionLaw, rpm: f64) -> Overview {
    let (m, w0) = (12.0, TAU * 270.0);
    overview(elastic_output::Scene {
        coupling: false,
        parameters: elastic_output::Parameters { m, c: m * w0 * w0, b: 0.06 * m * w0 },
        load: Load::default(),
        roller: (0.0, Load::default()),
        cam,
        drive: DriveMode::Constant { w: TAU * rpm / 60.0, phi_start: 0.0 },
        start: REST,
        solver: Settings::default(),
    })
}

/// U = s (a₁ cos φ + a₃ cos 3φ + a₅ cos 5φ).
fn hs_profile() -> MotionLaw {
    let a = [0.0, 0.5867065, 0.0, -0.0983694, 0.0, 0.0115306];
    MotionLaw::Fourier(Fourier::new(a.map(|a| 0.94e-3 * a).to_vec(), vec![]))
}

#[test]
fn a_resonance_is_judged_once_and_speeds_that_are_advised_are_calm() {
    for (rpm, harmonic) in [(3240.0, 5), (3049.0, 5), (5400.0, 3)] {
        let found = guide_bar(hs_profile(), rpm);
        let [Warning { message, hint }] = &found.warnings[..] else { panic!("{:?}", found.warnings) };
        assert!(message.starts_with(&format!("resonance with harmonic {harmonic}: ")), "{message}");
        assert!(hint.contains("`elasticity.damping_ratio`"), "{hint}");
        let words: Vec<&str> = hint.split([' ', ',']).collect();
        let advised: Vec<f64> =
            words.windows(2).filter(|pair| pair[1] == "rpm").map(|pair| pair[0].parse().unwrap()).collect();
        assert_eq!(advised.len(), 2, "{hint}");
        // At 5400 rpm the bar vibrates by more than its stroke.
        assert_eq!(message.contains("more than the stroke"), rpm > 5000.0, "{message}");
        for calm in advised {
            let there = guide_bar(hs_profile(), calm);
            assert!(there.warnings.is_empty(), "{calm}: {:?}", there.warnings);
            // None is nearer, but for the margin and the rounding.
            let nearer = if calm < rpm { 1.012 * calm } else { calm / 1.012 };
            assert!(!guide_bar(hs_profile(), nearer).warnings.is_empty(), "{nearer}");
            let [largest, still] = ["largest_deformation", "largest_kinetostatic_deformation"];
            assert!(there.value(largest).unwrap() < 2.0 * there.value(still).unwrap(), "{calm}");
        }
    }
    // Its profile has no ninth harmonic; the traditional one has.
    let plan = CyclePlan {
        stroke: 0.94e-3,
        lower: 0.0,
        rise_start: TAU * 32.0 / 360.0,
        rise_angle: TAU * 116.0 / 360.0,
        upper_dwell: TAU * 64.0 / 360.0,
        return_angle: TAU * 116.0 / 360.0,
        rise_law: StandardLaw::InclinedSine,
        return_law: StandardLaw::InclinedSine,
        inflections: [None; 2],
    };
    let weak = guide_bar(MotionLaw::Cycle(Cycle::new(plan)), 1800.0);
    assert!(weak.warnings.is_empty() && weak.notes[0].starts_with("harmonic 9 meets the natural frequency"));
    assert_eq!((weak.judgement().level, weak.verdict().result.len()), (Level::Good, 2));
    assert!(guide_bar(hs_profile(), 1800.0).judgement().result.is_empty());
}

/// The transfer manipulator of the examples at this speed (rpm).
fn manipulator(rpm: f64) -> Resource {
    let plan = CyclePlan {
        stroke: 0.4,
        lower: 0.0,
        rise_start: TAU / 12.0,
        rise_angle: TAU / 3.0,
        upper_dwell: TAU / 6.0,
        return_angle: TAU / 3.0,
        rise_law: StandardLaw::ModifiedTrapezoid,
        return_law: StandardLaw::ModifiedTrapezoid,
        inflections: [None; 2],
    };
    let scene = elastic_shaft::Scene {
        load: Default::default(),
        parameters: elastic_shaft::Parameters { m: 60.0, inertia: 1.5, c: 24e3, b: 17.85 },
        linear: false,
        cam: MotionLaw::Cycle(Cycle::new(plan)),
        drive: DriveMode::Constant { w: TAU * rpm / 60.0, phi_start: 0.0 },
        start: REST,
        solver: Settings::default(),
    };
    Resource::new("x", scene)
}

#[test]
fn both_equations_of_a_shaft_are_judged_and_their_commands_agree() {
    use crate::{stability, steady};
    let options = stability::Options { quick: true, orders: Some(2), ..stability::Options::default() };
    for (rpm, level, both, linear) in [
        // The trapezoid doubles the torque without any resonance.
        (46.0, Level::Mind, "Vibration raises the deformation from 0.468° to 1.12°", "load reaches 473 N·m"),
        (330.0, Level::Good, "", "Linear equation at 330 rpm: free motions grow by 23.8 % a turn."),
        // Another motion, of 28.9°, is stable, too; the start from rest leads to this one, as a run does.
        (230.0, Level::Good, "Vibration raises the deformation", "the shaft twists by up to 22.8°"),
        // Its linear equation has 121°: the search begins with the start from rest.
        (243.22, Level::Good, "", "the shaft twists by up to 24.4° and takes up to 10.3 kN·m"),
        (560.0, Level::Mind, "The periodic motion at 560 rpm is unstable: turns differ.", "is unstable: turns differ"),
    ] {
        let scene = manipulator(rpm);
        let [check, steady] = [of(&scene).verdict(), steady::of_drive(&scene, None).unwrap().verdict()];
        let stability = stability::study_scene(&scene, &options, &|_| {}).unwrap().verdict();
        for verdict in [&check, &steady] {
            assert!(verdict.result.iter().any(|sentence| sentence.contains(both)), "{rpm}: {:?}", verdict.result);
        }
        assert!(stability.result.iter().any(|sentence| sentence.contains(linear)), "{rpm}: {:?}", stability.result);
        assert_eq!([check.level, steady.level, stability.level], [level; 3], "{rpm}");
    }
}
