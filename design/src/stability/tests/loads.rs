//! Loads on an elastic shaft, where stiffness, damping and torque vary with the angle, and on a parametric drive.

use super::super::{StabilityAnalysis, study_scene};
use super::backwards::{assert_same, quick};
use crate::resource::{Resource, Scene};
use camdrive::drives::Drive as _;
use camdrive::drives::elastic_shaft::{self, ElasticShaft};
use camdrive::drives::follower::load::{Load, Spring};
use camdrive::drives::parametric::crank::{ParallelCrank, SecondCrank};
use camdrive::drives::parametric::law::{Coordinate, CrankLaw, Law, SeriesLaw};
use camdrive::drives::parametric::{self, ParametricDrive};
use camdrive::drives::settings::Settings;
use camdrive::drives::shaft::cam_drive::{DriveMode, Start, StartMode};
use camdrive::motion::table::Points;
use camdrive::motion::{Cycle, CyclePlan, Fourier, MotionLaw, Polyline, StandardLaw};
use std::f64::consts::TAU;

const AT_REST: Start = Start { mode: StartMode::AtRest, q: 0.0, q_dot: 0.0 };

fn report(scene: impl Into<Scene>) -> StabilityAnalysis {
    study_scene(&Resource::new("x", scene), &quick(&[]), &|_| ()).unwrap()
}

fn series(a: &[f64], b: &[f64]) -> Fourier {
    Fourier::new(a.to_vec(), [&[0.0], b].concat())
}

/// A massless follower under a constant force F on U = r cos φ: J q̈ + b q̇ + (c + r F cos φ) q = −r F sin φ, of which the
/// stiffness alone makes the drive unstable about twice its natural frequency.
#[test]
fn a_static_load_excites_parametrically() {
    let [inertia, c, b, r, force] = [0.4, 90.0, 0.15, 0.05, 700.0];
    for w in [30.2, -30.2, 14.0] {
        let drive = DriveMode::Constant { w, phi_start: 0.0 };
        let loaded = elastic_shaft::Scene {
            parameters: elastic_shaft::Parameters { m: 0.0, inertia, c, b },
            linear: true,
            load: Load { constant: Some(force), ..Load::default() },
            cam: MotionLaw::Fourier(series(&[0.0, r], &[])),
            drive: drive.clone(),
            start: AT_REST,
            solver: Settings::default(),
        };
        let [m, b, c] = [series(&[inertia], &[]), series(&[b], &[]), series(&[c, r * force], &[])];
        let f = Some(series(&[], &[-r * force]));
        let law = Law::Series(SeriesLaw { coordinate: Coordinate::Rotation, m, b, c, f });
        let (load, solver) = (Load::default(), Settings::default());
        let same = parametric::Scene { law, drive, load, start: AT_REST, solver };
        let [loaded, same] = [report(loaded), report(same)];
        assert_eq!(w.abs() == 30.2, loaded.speeds[0].radius > 1.0, "{w}: {:?}", loaded.speeds[0]);
        // The torque on the shaft is that of its own spring.
        let without = |report: StabilityAnalysis| StabilityAnalysis { courses: Vec::new(), ..report };
        assert!(w != 14.0 || loaded.courses[0].iter().zip(&same.courses[0]).any(|(a, b)| (a[1] - b[1]).abs() > 0.1));
        assert_same(&without(loaded), &without(same), 1.0);
    }
}

/// The multipliers of the study are those of the drive itself, and the torque over the turn is that of its shaft.
#[test]
fn the_study_of_a_loaded_shaft_is_that_of_its_motion() {
    let process = MotionLaw::Cycle(Cycle::new(CyclePlan {
        stroke: 120.0,
        lower: -20.0,
        rise_start: 5.5,
        rise_angle: 1.3,
        upper_dwell: 0.4,
        return_angle: 1.6,
        rise_law: StandardLaw::Polynomial345,
        return_law: StandardLaw::ModifiedSine,
        inflections: [None; 2],
    }));
    let spring = Some(Spring { preload: 300.0, c: 4e3, at: 0.02 });
    let load = Load { gravity: Some(-9.81), spring, damping: Some(60.0), process: Some(process), ..Load::default() };
    for w in [19.0, -19.0] {
        let scene = elastic_shaft::Scene {
            parameters: elastic_shaft::Parameters { m: 12.0, inertia: 0.3, c: 600.0, b: 0.4 },
            linear: true,
            load: load.clone(),
            cam: MotionLaw::Fourier(series(&[0.01, 0.06], &[0.02, 0.004])),
            drive: DriveMode::Constant { w, phi_start: 0.4 },
            start: AT_REST,
            solver: Settings::default(),
        };
        // q, q̇ and tau a turn after a start.
        let moved = |mode, [q, q_dot]: [f64; 2], time: f64| {
            let mut drive =
                ElasticShaft::new(elastic_shaft::Scene { start: Start { mode, q, q_dot }, ..scene.clone() }).unwrap();
            drive.start(0.0).unwrap();
            drive.advance(0.0, time).unwrap();
            let list = drive.variables();
            let mut values = list.places();
            drive.evaluate(&mut values);
            ["q", "der(q)", "tau"].map(|name| values[list.0[list.reference(name).unwrap()].index])
        };
        let turn = TAU / w.abs();
        let [start, by_q, by_speed] =
            [[0.0; 2], [1.0, 0.0], [0.0, 1.0]].map(|start| moved(StartMode::Given, start, turn));
        let [a, c] = [0, 1].map(|i| by_q[i] - start[i]);
        let [b, d] = [0, 1].map(|i| by_speed[i] - start[i]);
        let report = report(scene.clone());
        let [[re, im], [re2, im2]] = report.speeds[0].multipliers;
        assert!((re + re2 - (a + d)).abs() < 1e-9 && (re * re2 - im * im2 - (a * d - b * c)).abs() < 1e-9, "{w}");
        for [phi, torque, _] in report.courses[0].iter().step_by(37) {
            let time = ((phi - 0.4) / w).rem_euclid(turn);
            let [_, _, tau] = moved(StartMode::SteadyState, [0.0; 2], time);
            assert!((torque + tau).abs() < 1e-6, "{w} at {phi}: {torque} {tau}");
        }
    }
}

/// Loads on a parametric drive are coefficients, but for the force on its own spring; a crank turns against its damper.
#[test]
fn the_study_of_a_loaded_parametric_drive_is_that_of_its_coefficients() {
    let [m, f] = [series(&[2.0, 0.3], &[0.2]), series(&[1.0, 0.0, 3.0], &[2.0])];
    let process = series(&[0.0, 5.0], &[0.0, -2.0]);
    let spring = Some(Spring { preload: 4.0, c: 15.0, at: 0.3 });
    let process_law = Some(MotionLaw::Fourier(process));
    let load = Load { constant: Some(7.0), spring, damping: Some(0.4), process: process_law, ..Load::default() };
    let scene = |b: f64, c: f64, f: Fourier, load: Load| {
        let (b, c) = (series(&[b, 0.05], &[]), series(&[c, 5.0, 0.0, 8.0], &[]));
        let law = Law::Series(SeriesLaw { coordinate: Coordinate::Rotation, m: m.clone(), b, c, f: Some(f) });
        let drive = DriveMode::Constant { w: 5.0, phi_start: 0.0 };
        report(parametric::Scene { law, drive, load, start: AT_REST, solver: Settings::default() })
    };
    let loaded = scene(0.3, 40.0, f.clone(), load);
    let force = series(&[f.a[0] + 7.0 - 4.0 + 15.0 * 0.3, 5.0, 3.0], &[2.0, -2.0]);
    let same = scene(0.7, 55.0, force, Load::default());
    assert!(loaded.courses[0].iter().zip(&same.courses[0]).any(|(a, b)| (a[1] - b[1]).abs() > 0.1));
    let without = |report: StabilityAnalysis| StabilityAnalysis { courses: Vec::new(), ..report };
    assert_same(&without(loaded), &without(same), 1.0);
}

/// The force over the turn is that of the drive in motion, on a crank against a damper and a force with steps.
#[test]
fn the_force_on_the_shafts_of_a_loaded_crank_is_that_of_its_motion() {
    let points = Points { angles: vec![0.5, 2.0, 2.0, 4.0], lifts: vec![0.0, 2e3, -3e3, 1e3] };
    let process = Some(MotionLaw::Polyline(Polyline::new(points).unwrap()));
    let load = Load { constant: Some(-800.0), damping: Some(90.0), process, ..Load::default() };
    let crank = ParallelCrank { c_t1: 3.0e6, c_t2: 6.0e6, c_ab: 5e7, r: 0.3, second: SecondCrank::None };
    let law = Law::Crank(CrankLaw { crank, inertia: 300.0, damping: 2000.0, load: None, harmonics: None });
    for w in [23.0, -23.0] {
        let drive = DriveMode::Constant { w, phi_start: 0.4 };
        let (load, start) = (load.clone(), Start { mode: StartMode::SteadyState, ..AT_REST });
        let scene = parametric::Scene { law: law.clone(), drive, load, start, solver: Settings::default() };
        let report = report(scene.clone());
        for [phi, torque, _] in report.courses[0].iter().step_by(37) {
            let time = ((phi - 0.4) / w).rem_euclid(TAU / w.abs());
            let mut drive = ParametricDrive::new(scene.clone()).unwrap();
            drive.start(0.0).unwrap();
            drive.advance(0.0, time).unwrap();
            let list = drive.variables();
            let mut values = list.places();
            drive.evaluate(&mut values);
            let tau = values[list.0[list.reference("tau").unwrap()].index];
            assert!((torque + tau).abs() < 1e-8 * 1e4, "{w} at {phi}: {torque} {tau}");
        }
    }
}
