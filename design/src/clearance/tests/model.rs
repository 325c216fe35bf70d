//! The study of whole scenes.

use crate::clearance::borders::Sequel;
use crate::clearance::{ClearanceAnalysis, Options, study};
use crate::report::Value;
use crate::resource::Resource;
use camdrive::drives::Fault;
use camdrive::drives::backlash::{Parameters, Scene};
use camdrive::drives::settings::Settings;
use camdrive::drives::shaft::cam_drive::{DriveMode, Start, StartMode};
use camdrive::motion::plan::SegmentLaw;
use camdrive::motion::table::Points;
use camdrive::motion::{Cycle, CyclePlan, Fourier, MotionLaw, MotionPlan, PlanPoint, StandardLaw, Table};
use std::f64::consts::TAU;

/// Five harmonics, 20 mm; weak jerk at 100.5°, strong jerk at 254.1°.
fn profile() -> MotionLaw {
    MotionLaw::Fourier(Fourier::new(
        vec![0.0, -0.010, 0.0012, 0.0005, -0.0002],
        vec![0.0, 0.0, 0.0008, -0.0003, 0.0, 0.0001],
    ))
}

fn with(mut scene: Scene, change: impl FnOnce(&mut Parameters)) -> Scene {
    change(&mut scene.parameters);
    scene
}

/// μ = 0.25, ω = 500 rad/s, no damping.
fn scene(cam: MotionLaw, eta: f64, s: f64) -> Scene {
    Scene {
        coupling: false,
        parameters: Parameters { m1: 0.5, m2: 2.0, c: 5e5, b: 0.0, s, e: 0.0 },
        cam,
        drive: DriveMode::Constant { w: 500.0 * eta, phi_start: 0.3 },
        start: Start { mode: StartMode::AtRest, q: 0.0, q_dot: 0.0 },
        solver: Settings::default(),
    }
}

fn run(scene: &Scene, options: &Options) -> Result<ClearanceAnalysis, Fault> {
    study(&Resource::new("test", scene.clone()), options, |_| ())
}

fn report(scene: &Scene) -> ClearanceAnalysis {
    run(scene, &Options { turns: Some(4), quick: true, ..Options::default() }).unwrap()
}

#[test]
fn the_known_differences_of_formula_and_model() {
    // η, s [mm], zero [°], K, passage [°], shift of the release [°], errors of τ₁ and I, each with its printed unit.
    let known = [
        (0.02, 0.05, 254.0, (106.0, 1.0), (9.8, 0.1), (-0.008, 1e-3), (-1.3, 0.1), (3.0, 0.1)),
        (0.02, 0.50, 254.0, (1060.0, 10.0), (22.1, 0.1), (-0.008, 1e-3), (-4.2, 0.1), (12.9, 0.1)),
        (0.05, 0.20, 100.0, (121.0, 1.0), (26.6, 0.1), (-0.20, 0.01), (-5.0, 0.1), (4.8, 0.1)),
        (0.05, 0.05, 254.0, (6.8, 0.1), (8.7, 0.1), (-0.05, 0.01), (-1.1, 0.1), (2.7, 0.1)),
        (0.10, 0.05, 100.0, (3.8, 0.1), (13.8, 0.1), (-1.07, 0.01), (-9.8, 0.1), (25.0, 1.0)),
        (0.10, 0.20, 254.0, (3.4, 0.1), (11.4, 0.1), (-0.24, 0.01), (2.6, 0.1), (3.1, 0.1)),
        (0.15, 0.05, 254.0, (0.25, 0.01), (5.3, 0.1), (-0.66, 0.01), (11.0, 1.0), (-11.0, 1.0)),
        (0.15, 0.20, 100.0, (4.5, 0.1), (28.1, 0.1), (-5.38, 0.01), (-27.0, 1.0), (-7.5, 0.1)),
    ];
    for (eta, s, zero, k, angle, shift, time, impulse) in known {
        let report = report(&scene(profile(), eta, 1e-3 * s));
        let study = &report.laws[0];
        // At 0.75 of the resonance of the fifth harmonic the contact force crosses zero where U″ only comes near.
        let releases = if eta < 0.15 { 2 } else { 4 };
        assert_eq!((study.crossings, study.releases, study.passages.len()), (2, Some(releases), releases));
        let near = |phi: f64| (phi.to_degrees() - zero).abs() < 1.0;
        let passage = study.passages.iter().find(|p| p.crossing.is_some_and(|c| near(c.phi))).unwrap();
        let (formula, model) = (passage.formula.unwrap(), passage.model.unwrap());
        let percent = |a: f64, b: f64| 100.0 * (a / b - 1.0);
        let found = [
            (passage.k.unwrap(), k),
            (model.angle.to_degrees(), angle),
            ((model.release - formula.release).to_degrees(), shift),
            (percent(formula.tau, model.tau), time),
            (percent(formula.impulse, model.impulse), impulse),
        ];
        for (i, (found, (printed, unit))) in found.into_iter().enumerate() {
            assert!(
                (found - printed).abs() < 0.51 * unit,
                "η = {eta}, s = {s} mm, {zero}°, number {i}: {found}, not {printed}"
            );
        }
    }
}

/// φ of the release near `phi` and the time of the passage near `time` in closed form: permanent contact as the sum of its
/// harmonics until F_K = 0, then the flight of two masses on a spring and a damper to the other flank.
fn passage(scene: &Scene, w: f64, from: char, phi: f64, time: f64) -> [f64; 2] {
    let Parameters { m1, m2, c, b, s, .. } = scene.parameters;
    let cam = &scene.cam;
    let MotionLaw::Fourier(series) = cam else { unreachable!() };
    let u = |phi: f64, order: usize| cam.at(phi).0[order] * w.powi(order as i32);
    let contact = |phi: f64| {
        let mut q = [0.0; 2];
        for (k, (cos, sin)) in series.a.iter().zip(&series.b).enumerate() {
            // Re (re + i im) e^(ikφ) with (re + i im)(c − m2 ν² + i ν b) = m2 ν² (a − i b).
            let nu = k as f64 * w;
            let (real, imaginary) = (c - m2 * nu * nu, nu * b);
            let factor = m2 * nu * nu / (real * real + imaginary * imaginary);
            let (re, im) = (factor * (cos * real - sin * imaginary), factor * (-sin * real - cos * imaginary));
            let (sin, cos) = (k as f64 * phi).sin_cos();
            q = [q[0] + re * cos - im * sin, q[1] - nu * (re * sin + im * cos)];
        }
        q
    };
    let force = |phi: f64| {
        let [q, q_dot] = contact(phi);
        m1 * u(phi, 2) - c * q - b * q_dot
    };
    let zero = |f: &dyn Fn(f64) -> f64, mut low: f64, mut high: f64| {
        let rising = f(high) > 0.0;
        assert_ne!(rising, f(low) > 0.0);
        for _ in 0..100 {
            let middle = 0.5 * (low + high);
            if (f(middle) > 0.0) == rising { high = middle } else { low = middle }
        }
        low
    };
    let release = zero(&force, phi - 1e-5, phi + 1e-5);
    let [q, q_dot] = contact(release);
    let (share, reduced) = (m2 / (m1 + m2), m1 * m2 / (m1 + m2));
    let (damping, frequency) = (0.5 * b / reduced, (c / reduced - (0.5 * b / reduced).powi(2)).sqrt());
    let across = if from == 'A' { s } else { -s };
    // x1 is off the centre of mass by −share q.
    let gap = |t: f64| {
        let (sin, cos) = (frequency * t).sin_cos();
        let then = (-damping * t).exp() * (q * cos + (q_dot + damping * q) / frequency * sin);
        u(release, 0) + u(release, 1) * t - u(release + w * t, 0) + share * (q + q_dot * t - then) - across
    };
    [release, zero(&gap, 0.999 * time, 1.001 * time)]
}

#[test]
fn releases_and_times_of_passage_are_those_of_the_closed_form() {
    // Flights, or the contact before them, of about half a radian of the fastest vibration.
    let law = |a: &[f64], b: &[f64]| MotionLaw::Fourier(Fourier::new(a.to_vec(), b.to_vec()));
    let damped = law(&[0.0, -6.2e-3, 3e-3, -7e-4], &[0.0, -1.14e-2, -7e-4, 7e-4]);
    let undamped = law(
        &[0.0, 6.170272e-4, -5.430396e-4, 3.488901e-4, -2.939738e-4, -2.317017e-4],
        &[0.0, -1.5756131e-2, 1.106072e-3, -1.30038e-4, -1.497498e-4, -2.411653e-4],
    );
    let drive = |w: f64| DriveMode::Constant { w, phi_start: 0.0 };
    let damped =
        Scene { drive: drive(-94.0), ..with(scene(damped, 0.0, 0.0), |p| (p.m1, p.c, p.b) = (8.0, 2.33e7, 6820.0)) };
    let undamped = Scene {
        drive: drive(-1.474754),
        ..with(scene(undamped, 0.0, 7.3e-9), |p| (p.m1, p.c) = (1.7431e-2, 8.779589e4))
    };
    let damped = [3e-9, 6e-9, 8e-9, 1e-8].map(|s| (with(damped.clone(), |p| p.s = s), -94.0));
    for (scene, w) in damped.into_iter().chain([(undamped, -1.474754)]) {
        for found in &report(&scene).laws[0].passages {
            let model = found.model.unwrap();
            let [release, time] = passage(&scene, w, found.from, model.release, model.time);
            assert!((model.release - release).abs() < 1e-13, "s = {}: {model:?}, {release}", scene.parameters.s);
            // u of the closed form is known to 1e-18 m, a ten-thousand-millionth of s.
            assert!((model.time / time - 1.0).abs() < 1e-9, "s = {}: {model:?}, {time}", scene.parameters.s);
        }
    }
}

#[test]
fn in_the_limit_of_slow_drives_and_short_passages_the_model_is_the_formula() {
    // U = −cos φ has U⁗ = 0 at its zeros of U″, so that the errors are of the second order in η and Δφ.
    let cosine = MotionLaw::Fourier(Fourier::new(vec![0.0, -0.02], vec![]));
    for k in [0.01, 0.7, 2.0, 14.0, 22.7, 40.0] {
        for mu in [0.05, 0.25, 2.0] {
            let eta: f64 = 1e-4;
            let scene = with(scene(cosine.clone(), eta, k * 0.02 * eta.powi(3)), |p| p.m1 = mu * 2.0);
            let report = report(&scene);
            for passage in &report.laws[0].passages {
                let (formula, model) = (passage.formula.unwrap(), passage.model.unwrap());
                assert!((passage.k.unwrap() / k - 1.0).abs() < 1e-12);
                let values =
                    |f: &crate::clearance::passage::Figures| [f.tau, f.time, f.angle, f.impulse, f.loss, f.vibration];
                for (i, (a, b)) in values(&formula).into_iter().zip(values(&model)).enumerate() {
                    assert!((a / b - 1.0).abs() < 1e-5, "μ = {mu}, K = {k}, number {i}: {a} {b}");
                }
                assert_eq!(formula.sequel, model.sequel, "μ = {mu}, K = {k}");
                match formula.sequel {
                    Sequel::Immediate => assert!(formula.force.is_none() && model.force.is_none()),
                    _ => {
                        assert!((formula.elongation.unwrap() / model.elongation.unwrap() - 1.0).abs() < 1e-3);
                        assert!((formula.force.unwrap() / model.force.unwrap() - 1.0).abs() < 1e-3);
                    }
                }
                if let (Sequel::Elastic, Some(a), Some(b)) =
                    (formula.sequel, formula.release_after, model.release_after)
                {
                    assert!((a / b - 1.0).abs() < 1e-3, "μ = {mu}, K = {k}: {a} {b}");
                }
                let until = formula.release_after.unwrap_or(TAU);
                for point in passage.course.iter().filter(|point| point.tau < until) {
                    let [a, b] = point.q.map(Option::unwrap);
                    let [f, g] = point.force.map(Option::unwrap);
                    assert!(
                        (a - b).abs() < 1e-4 * a.abs().max(1.0) && (f - g).abs() < 1e-4 * f.abs().max(1.0),
                        "{point:?}"
                    );
                }
            }
        }
    }
}

#[test]
fn mirrored_and_reversed_drives_have_the_same_passages() {
    let MotionLaw::Fourier(series) = profile() else { unreachable!() };
    let one = report(&scene(profile(), 0.1, 2e-4));
    let negative = MotionLaw::Fourier(series.scaled(-1.0));
    let mirrored = report(&scene(negative, 0.1, 2e-4));
    // U(−φ) at −Ω is the same motion.
    let b: Vec<f64> = series.b.iter().map(|b| -b).collect();
    let backward = MotionLaw::Fourier(Fourier::new(series.a.clone(), b));
    let reversed =
        report(&Scene { drive: DriveMode::Constant { w: -50.0, phi_start: 0.0 }, ..scene(backward, 0.1, 2e-4) });
    let passages = |report: &ClearanceAnalysis| report.laws[0].passages.clone();
    for (a, b) in passages(&one).iter().zip(passages(&mirrored)) {
        assert_ne!(a.from, b.from);
        let (a, b) = (a.model.unwrap(), b.model.unwrap());
        assert!((a.impulse - b.impulse).abs() < 1e-9 * a.impulse && (a.release - b.release).abs() < 1e-9);
        assert_eq!(a.sequel, b.sequel);
        assert!(a.force.zip(b.force).is_none_or(|(a, b)| (a - b).abs() < 1e-9 * a));
    }
    for (a, b) in passages(&one).iter().zip(passages(&reversed).iter().rev()) {
        assert_eq!(a.from, b.from);
        assert!((a.spacing - b.spacing).abs() < 1e-9);
        let (a, b) = (a.model.unwrap(), b.model.unwrap());
        assert!((a.impulse - b.impulse).abs() < 1e-9 * a.impulse && (a.release + b.release - TAU).abs() < 1e-9);
    }
}

#[test]
fn a_damped_drive_settles_to_one_passage_per_change_of_sign() {
    // D = 0.6: nothing of a vibration lasts to the next passage.
    let damped = with(scene(profile(), 0.05, 5e-5), |p| p.b = 1200.0);
    let report = run(&damped, &Options { quick: true, ..Options::default() }).unwrap();
    let study = &report.laws[0];
    let settled = study.settled.unwrap();
    assert!(settled.repeats && settled.turns == 20, "{settled:?}");
    assert_eq!(settled.impacts, 2.0);
    let models: Vec<_> = study.passages.iter().map(|p| p.model.unwrap()).collect();
    let (largest, loss) =
        (models.iter().map(|f| f.impulse).fold(0.0, f64::max), models.iter().map(|f| f.loss).sum::<f64>());
    assert!((settled.largest_impulse / largest - 1.0).abs() < 1e-6, "{settled:?}");
    assert!((settled.loss / loss - 1.0).abs() < 1e-6, "{settled:?}");
    assert!(study.passages.iter().all(|p| p.left < 1e-6));
}

#[test]
fn restitution_is_told_from_the_formulas() {
    let report = report(&with(scene(profile(), 0.05, 5e-5), |p| p.e = 0.5));
    let study = &report.laws[0];
    assert!(study.passages.iter().all(|p| p.model.unwrap().sequel == Sequel::Rebound));
    assert!(report.verdict().advice[0].text.contains("(restitution 0.5)"), "{:?}", report.verdict());
    for passage in &study.passages {
        // P = m1 (1 + e) |ż|, loss ½ m1 (1 − e²) ż².
        let model = passage.model.unwrap();
        let approach = model.impulse / (0.5 * 1.5);
        assert!((model.loss - 0.5 * 0.5 * 0.75 * approach * approach).abs() < 1e-9 * model.loss);
    }
}

#[test]
fn laws_are_compared_at_the_same_task() {
    let plan = CyclePlan {
        stroke: 0.04,
        lower: 0.0,
        rise_start: 0.0,
        rise_angle: 1.5,
        upper_dwell: 1.0,
        return_angle: 1.5,
        rise_law: StandardLaw::InclinedSine,
        return_law: StandardLaw::InclinedSine,
        inflections: [None; 2],
    };
    let cycle = |law| MotionLaw::Cycle(Cycle::new(CyclePlan { rise_law: law, return_law: law, ..plan }));
    let sine = cycle(StandardLaw::ModifiedSine);
    let laws = vec![("modified_sine".to_owned(), sine, 0.0), ("profile".to_owned(), profile(), 0.0)];
    let damped = with(scene(cycle(StandardLaw::InclinedSine), 0.02, 5e-5), |p| p.b = 300.0);
    let report = run(&damped, &Options { turns: Some(4), quick: true, laws, ..Options::default() }).unwrap();
    assert_eq!(report.laws.len(), 3);
    let [bestehorn, sine, _] = [&report.laws[0], &report.laws[1], &report.laws[2]];
    assert!((bestehorn.stroke - 0.04).abs() < 1e-15 && (sine.stroke - 0.04).abs() < 1e-15);
    // f‴(½) = −4π² of Bestehorn's law, −V (4π/3)² 3 … of the modified sine: the harder passage.
    for (study, law) in [(bestehorn, StandardLaw::InclinedSine), (sine, StandardLaw::ModifiedSine)] {
        let expected = 0.04 / 1.5f64.powi(3) * law.at(0.5)[3].abs();
        let jerks: Vec<f64> = study.passages.iter().filter_map(|p| Some(p.crossing?.jerk.abs())).collect();
        assert_eq!(jerks.len(), 2);
        assert!(jerks.iter().all(|jerk| (jerk / expected - 1.0).abs() < 1e-12));
        // Rise and return are mirror images.
        assert!((study.least_spacing.unwrap() - 2.5).abs() < 1e-12);
    }
    let report = report.report();
    let laws = report.tables().find(|table| table.title == "Laws").unwrap();
    assert!(laws.rows.len() == 3 && laws.rows[1][0] == "modified_sine".into(), "{:?}", laws.rows);
}

#[test]
fn every_law_has_all_its_intervals_of_admissible_frequencies() {
    let of = |law: MotionLaw, e: f64| with(scene(law, 0.05, 5e-5), |p| (p.b, p.e) = (300.0, e));
    let other = || MotionLaw::Fourier(Fourier::new(vec![0.0, -0.012, 0.001], vec![0.0, 0.0005]));
    let options = || Options { turns: Some(2), laws: vec![("other".to_owned(), other(), 0.0)], ..Options::default() };
    let report = run(&of(profile(), 0.0), &options()).unwrap();
    let alone = run(&of(other(), 0.0), &Options { turns: Some(2), ..Options::default() }).unwrap();
    assert!(report.laws[1].by_model.is_some() && report.laws[1].by_model == alone.laws[0].by_model);
    // In a study of several laws, too.
    let cells = |findings: &ClearanceAnalysis| {
        let report = findings.report();
        let laws = report.tables().find(|table| table.title == "Laws").unwrap().clone();
        laws.rows.into_iter().filter_map(|row| row.into_iter().last()).collect::<Vec<Value>>()
    };
    for (study, cell) in report.laws.iter().zip(cells(&report)) {
        let Value::Text(cell) = cell else { panic!("intervals") };
        let intervals = &study.by_model.as_ref().unwrap().frequency;
        assert_eq!(cell.matches(" to ").count(), intervals.len(), "{cell}");
    }
    // Where there is none it is said why.
    let lively = run(&of(profile(), 0.3), &options()).unwrap();
    assert!(cells(&lively).iter().all(|cell| *cell == Value::Empty));
    assert!(lively.verdict().advice[0].text.contains("m1 rebounds after each impact"), "{:?}", lively.verdict());
}

#[test]
fn what_cannot_be_studied_says_why() {
    let plain = scene(profile(), 0.05, 5e-5);
    let refused = |scene: &Scene, options: Options, parts: &[&str]| {
        let fault = run(scene, &options).unwrap_err().to_string();
        assert!(parts.iter().all(|part| fault.contains(part)), "{fault}");
    };
    refused(&Scene { drive: DriveMode::Input, ..plain.clone() }, Options::default(), &["inputs", "--speed"]);
    refused(&plain, Options { speed: Some(0.0), ..Options::default() }, &["0 rpm", "--speed"]);
    refused(&with(plain.clone(), |p| p.s = 0.0), Options::default(), &["clearance", "0 m", "--clearance"]);
    refused(&plain, Options { clearance: Some(-1.0), ..Options::default() }, &["clearance", "-1 m"]);
    refused(&plain, Options { damping: Some(-0.1), ..Options::default() }, &["--damping", "-0.1", "at least 0"]);
    refused(&plain, Options { ignore: Some(1.0), ..Options::default() }, &["--ignore"]);
    // At a resonance without damping there is no motion of permanent contact; the formulas remain, and the run from rest.
    let resonant = report(&Scene { drive: DriveMode::Constant { w: 250.0, phi_start: 0.0 }, ..plain.clone() });
    let study = &resonant.laws[0];
    assert!(study.releases.is_none() && study.passages.iter().all(|p| p.formula.is_some() && p.model.is_none()));
    assert!(study.settled.is_some());
    assert!(
        study.remarks.iter().any(|remark| remark.contains("harmonic 2 of U is in resonance")),
        "{:?}",
        study.remarks
    );
    // A cam without stroke.
    let still = report(&Scene { cam: MotionLaw::Fourier(Fourier::new(vec![0.1], vec![])), ..plain });
    assert!(still.laws[0].passages.is_empty() && still.laws[0].tuning.is_none());
    assert!(still.verdict().result[0].contains("never opens"), "{:?}", still.verdict());
}

#[test]
fn an_admissible_frequency_speed_or_clearance_is_one_for_the_model_too() {
    // The weak passage of the profile is followed by a release; what the formulas recommend mends it, with room for
    // their own error of some per cent.
    let plain = with(scene(profile(), 0.05, 5e-5), |p| p.b = 100.0);
    let sequels = |options: Options| -> Vec<Sequel> {
        let report = run(&plain, &Options { turns: Some(2), quick: true, ..options }).unwrap();
        report.laws[0].passages.iter().map(|p| p.model.unwrap().sequel).collect()
    };
    assert!(sequels(Options::default()).contains(&Sequel::Elastic));
    let report = run(&plain, &Options { turns: Some(2), ..Options::default() }).unwrap();
    let tuning = report.laws[0].tuning.as_ref().unwrap();
    let (omega, speed, s) = (tuning.frequency[0][1], tuning.speed[0][0], tuning.clearance[0][1]);
    for options in [
        Options { natural_frequency: Some(0.93 * omega), ..Options::default() },
        Options { speed: Some(1.07 * speed), ..Options::default() },
        Options { clearance: Some(0.8 * s), ..Options::default() },
        Options { m1: Some(1.5 * tuning.mass[0][0]), ..Options::default() },
    ] {
        assert_eq!(sequels(options), [Sequel::None; 2]);
    }
    // So do the borders that the model itself has, to their digits.
    let by_model = report.laws[0].by_model.as_ref().unwrap();
    assert_eq!(report.laws[0].calm.by_model, Some(false));
    let (omega, speed, s) = (by_model.frequency.last().unwrap()[1], by_model.speed[0][0], by_model.clearance[0][1]);
    let (m1, damping) = (by_model.mass[0][0], by_model.damping[0][0]);
    for (calm, part) in [(true, 0.999), (false, 1.001)] {
        for options in [
            Options { natural_frequency: Some(part * omega), ..Options::default() },
            Options { speed: Some(speed / part), ..Options::default() },
            Options { clearance: Some(part * s), ..Options::default() },
            Options { m1: Some(m1 / part), ..Options::default() },
            Options { damping: Some(damping / part), ..Options::default() },
        ] {
            assert_eq!(sequels(options) == [Sequel::None; 2], calm, "{part}");
        }
    }
    // What the motion settles to at a change, within the border, is what a study at its value finds; the gentlest is first.
    let impulses: Vec<f64> = by_model.changes.iter().map(|change| change.settled.largest_impulse).collect();
    assert!(impulses.len() >= 5 && impulses.is_sorted(), "{impulses:?}");
    let change = by_model.changes.iter().find(|change| change.quantity == "damping ratio").unwrap();
    assert_eq!(change.value, crate::text::rounded(1.05 * damping, 3));
    let there = Options { damping: Some(change.value), turns: Some(2), quick: true, ..Options::default() };
    let there = run(&plain, &there).unwrap().laws[0].settled.unwrap();
    assert!((there.largest_impulse / change.settled.largest_impulse - 1.0).abs() < 1e-9, "{there:?}");
    // Damping ratio and mass ratio stay.
    let slower = Options { natural_frequency: Some(250.0), turns: Some(2), quick: true, ..Options::default() };
    let other = run(&plain, &slower).unwrap();
    assert!((other.machine.omega - 250.0).abs() < 1e-10 && other.machine.mu == 0.25 && other.machine.b == 50.0);
}

#[test]
fn countless_bounces_end_with_a_word_of_it() {
    // Elastic bounces within a clearance of an atom.
    let lively = with(scene(profile(), 0.002, 1e-12), |p| (p.e, p.b) = (1.0, 1.0));
    let report = run(&lively, &Options { turns: Some(1000), ..Options::default() }).unwrap();
    let study = &report.laws[0];
    assert!(study.passages.iter().all(|p| p.formula.is_some()) && study.settled.is_none());
    assert!(study.remarks.iter().any(|remark| remark.contains("too often to be followed")), "{:?}", study.remarks);
}

#[test]
fn the_tables_and_diagrams_hold_all_passages() {
    use crate::clearance::figures;
    let report = report(&scene(profile(), 0.05, 5e-5));
    let lines = |text: String| text.lines().count();
    let files: std::collections::BTreeMap<_, _> = report.report().files().into_iter().collect();
    let lines = |ending: &str| lines(files[ending].clone().unwrap());
    assert_eq!(lines("passages.csv"), 1 + 2 * 2);
    assert_eq!(lines("after_impact.csv"), 1 + 2 * 401);
    assert_eq!(lines("passage_time.csv"), 1 + 7 * 201);
    assert!(lines("map.csv") > 500);
    let json: serde_json::Value = serde_json::to_value(&report).unwrap();
    assert_eq!(json["laws"][0]["passages"].as_array().unwrap().len(), 2);
    for diagram in [
        figures::passage_time(&report),
        figures::multiple_impacts(&report),
        figures::deformation(&report),
        figures::force(&report),
        figures::acceleration(&report),
    ] {
        assert!(diagram.series.iter().all(|series| !series.points.is_empty()), "{}", diagram.title);
        assert!(diagram.svg().contains(&diagram.x.label.split(' ').next().unwrap().to_owned()));
    }
}

#[test]
fn what_a_measured_table_does_within_its_noise_is_no_passage() {
    let cycle = MotionLaw::Cycle(Cycle::new(CyclePlan {
        stroke: 0.02,
        lower: 0.0,
        rise_start: 0.3,
        rise_angle: 1.9,
        upper_dwell: 0.8,
        return_angle: 1.7,
        rise_law: StandardLaw::Polynomial345,
        return_law: StandardLaw::InclinedSine,
        inflections: [None; 2],
    }));
    let angles: Vec<f64> = (0..720).map(|i| TAU * f64::from(i) / 720.0).collect();
    for (seed, noise) in [(1, 2e-6), (2, 2e-6), (3, 1e-5), (4, 5e-7)] {
        // Twelve equally distributed numbers less six have about the normal distribution.
        let mut state = 0x9e37_79b9_u64 + seed;
        let mut random = || {
            let mut sum = -6.0;
            for _ in 0..12 {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                sum += (state >> 11) as f64 / (1u64 << 53) as f64;
            }
            sum
        };
        let lifts = angles.iter().map(|phi| cycle.at(*phi).0[0] + noise * random()).collect();
        let smooth = crate::smoothing::smooth(
            Points { angles: angles.clone(), lifts },
            None,
            crate::smoothing::Outliers::Refuse,
            &[],
        )
        .unwrap();
        // What the noise makes of U″ in the middle of both dwells, where nothing else does.
        let law = MotionLaw::Table(Table::new(smooth.points).unwrap());
        let rests = [[2.5, 2.7], [5.2, 6.2]].map(|[from, to]: [f64; 2]| {
            (0..200).map(|i| law.at(from + (to - from) * f64::from(i) / 200.0).0[2].powi(2)).sum::<f64>() / 200.0
        });
        let found = (0.2 * rests[0] + 0.8 * rests[1]).sqrt();
        assert!((0.07..0.5).contains(&(found / smooth.left)), "{noise:e}: {found:e} for {:e}", smooth.left);
        let damped = with(scene(law, 0.02, 5e-5), |p| p.b = 300.0);
        let options = |noise| Options { turns: Some(2), quick: true, noise, ..Options::default() };
        let with_noise = &run(&damped, &options(0.0)).unwrap().laws[0];
        let without = &run(&damped, &options(smooth.left)).unwrap().laws[0];
        println!(
            "{noise:e}: {} {:?} {} {:?}",
            with_noise.crossings, with_noise.releases, without.crossings, without.releases
        );
        assert!(with_noise.crossings > 12, "{}", with_noise.crossings);
        assert!(without.crossings <= 6, "{:?}", without.passages.iter().map(|p| p.crossing).collect::<Vec<_>>());
        assert!(without.remarks.iter().any(|remark| remark.contains("noise")));
    }
}

#[test]
fn a_rounded_table_has_the_passages_of_its_law() {
    // φ [°] and U of the rests, so slow that the vibration of a rest is noise, too.
    let laws = [
        vec![(10.0, 0.0), (110.0, 0.02), (170.0, 0.02), (290.0, 0.0)],
        vec![(10.0, 0.0), (60.0, 0.01), (100.0, 0.01), (160.0, 0.02), (200.0, 0.02), (300.0, 0.0)],
    ];
    use StandardLaw::{InclinedSine, Polynomial345};
    for (rests, law, shift, w, unit) in [
        (0, InclinedSine, 0.0, 0.45, 2e-6),
        (0, InclinedSine, 100.0, -0.45, 2e-6),
        (0, Polynomial345, 215.0, 0.45, 2e-5),
        (1, InclinedSine, 0.0, 0.45, 2e-6),
        (1, Polynomial345, 0.0, 0.45, 2e-6),
        (1, Polynomial345, 77.0, -0.45, 2e-6),
    ] {
        let point = |(phi, u): &(f64, f64)| PlanPoint {
            phi: (phi + shift).rem_euclid(360.0).to_radians(),
            u: *u,
            velocity: None,
            acceleration: None,
            free: false,
            jerk: None,
            law: Some(SegmentLaw::Standard(law)),
            inflection: None,
        };
        let mut points: Vec<PlanPoint> = laws[rests].iter().map(point).collect();
        points.sort_by(|a, b| a.phi.total_cmp(&b.phi));
        let exact = MotionLaw::Plan(MotionPlan::new(points));
        let angles: Vec<f64> = (0..360).map(|i| TAU * f64::from(i) / 360.0).collect();
        let lifts = angles.iter().map(|phi| (exact.at(*phi).0[0] / unit).round() * unit).collect();
        let smooth =
            crate::smoothing::smooth(Points { angles, lifts }, None, crate::smoothing::Outliers::Refuse, &[]).unwrap();
        let of = |law: MotionLaw, noise: f64, ignore: Option<f64>| {
            let mut scene = with(scene(law, 0.0, 5e-5), |p| p.b = 60.0);
            scene.drive = DriveMode::Constant { w, phi_start: 0.0 };
            let options = Options { turns: Some(2), quick: true, noise, ignore, ..Options::default() };
            run(&scene, &options).unwrap().laws.remove(0)
        };
        let table = of(MotionLaw::Table(Table::new(smooth.points).unwrap()), smooth.left, None);
        let exact = of(exact, 0.0, Some(0.02));
        assert_eq!((table.crossings, table.releases), (exact.crossings, exact.releases), "{rests} {shift} {w}");
        assert_eq!(table.passages.len(), exact.crossings);
        for (passage, of_law) in table.passages.iter().zip(&exact.passages) {
            let [formula, model, of_exact] = [passage.formula, passage.model, of_law.model].map(Option::unwrap);
            let expected = of_law.formula.unwrap();
            assert!(
                (of_exact.release - expected.release).abs() < 1e-6,
                "{rests} {shift} {w}: {of_exact:?} {expected:?}"
            );
            // In a rest the release is where the noise lets it.
            for found in [formula, model] {
                let off = (found.release - expected.release).to_degrees();
                assert!(passage.from == of_law.from && off.abs() < 4.0, "{rests} {shift} {w}: {found:?} {expected:?}");
            }
        }
    }
}

#[test]
fn a_rest_from_which_the_vibration_has_gone_ends_where_the_law_moves_on() {
    // Rise, rest, rise and rest, return and rest; φ [°].
    for (law, b, w, shift) in [
        (StandardLaw::InclinedSine, 60.0, 0.45, 0.0),
        (StandardLaw::Polynomial345, 60.0, -0.45, 77.0),
        (StandardLaw::Polynomial4567, 300.0, 0.45, 200.0),
        (StandardLaw::InclinedSine, 600.0, -0.45, 123.0),
        // After so long a rest q is exactly 0.
        (StandardLaw::Polynomial345, 1000.0, 0.2, 0.0),
        (StandardLaw::Polynomial345, 1000.0, -0.2, 15.0),
        (StandardLaw::Polynomial345, 3000.0, 0.2, 41.0),
    ] {
        let point = |(phi, u): (f64, f64)| PlanPoint {
            phi: (phi + shift).rem_euclid(360.0).to_radians(),
            u,
            velocity: None,
            acceleration: None,
            free: false,
            jerk: None,
            law: Some(SegmentLaw::Standard(law)),
            inflection: None,
        };
        let rests = [(10.0, 0.0), (60.0, 0.01), (100.0, 0.01), (160.0, 0.02), (200.0, 0.02), (300.0, 0.0)];
        let mut points = rests.map(point).to_vec();
        points.sort_by(|a, b| a.phi.total_cmp(&b.phi));
        let mut scene = with(scene(MotionLaw::Plan(MotionPlan::new(points)), 0.0, 5e-5), |p| p.b = b);
        scene.drive = DriveMode::Constant { w, phi_start: 0.0 };
        let options = Options { turns: Some(2), quick: true, ignore: Some(0.05), ..Options::default() };
        let study = run(&scene, &options).unwrap().laws.remove(0);
        // Three inflections, and the rest between the rises.
        assert_eq!((study.crossings, study.releases, study.passages.len()), (4, Some(4), 4), "{law:?} {b} {w}");
        for passage in study.passages {
            let (at, model) = (passage.crossing.unwrap().phi, passage.model.unwrap());
            let off = (model.release - at).to_degrees();
            assert!(off.abs() < 0.1, "{law:?} {b} {w}: {} {off} off {} {model:?}", passage.from, at.to_degrees());
        }
    }
}
