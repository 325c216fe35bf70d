//! Drives that turn backwards against an integration of their own and against their mirror images.

use super::super::{Options, StabilityAnalysis, study_scene};
use super::series;
use crate::resource::Resource;
use camdrive::drives::Fault;
use camdrive::drives::elastic_shaft;
use camdrive::drives::parametric;
use camdrive::drives::parametric::law::{Coordinate, Law, SeriesLaw};
use camdrive::drives::settings::Settings;
use camdrive::drives::shaft::cam_drive::{DriveMode, Start, StartMode};
use camdrive::motion::{Cycle, CyclePlan, Fourier, MotionLaw, StandardLaw};
use std::f64::consts::TAU;

/// m(φ) q̈ + b(φ) q̇ + c(φ) q = f(φ).
struct Coefficients {
    m: Fourier,
    b: Fourier,
    c: Fourier,
    f: Fourier,
}

fn mirrored(series: &Fourier) -> Fourier {
    Fourier::new(series.a.clone(), series.b.iter().map(|b| -b).collect())
}

impl Coefficients {
    fn mirrored(&self) -> Self {
        let Coefficients { m, b, c, f } = self;
        Coefficients { m: mirrored(m), b: mirrored(b), c: mirrored(c), f: mirrored(f) }
    }

    fn study(&self, w: f64, options: &Options) -> Result<StabilityAnalysis, Fault> {
        let Coefficients { m, b, c, f } = self;
        let [m, b, c, f] = [m, b, c, f].map(Fourier::clone);
        let scene = parametric::Scene {
            load: Default::default(),
            law: Law::Series(SeriesLaw { coordinate: Coordinate::Translation, m, b, c, f: Some(f) }),
            drive: DriveMode::Constant { w, phi_start: 0.4 * w.signum() },
            start: Start { mode: StartMode::AtRest, q: 0.0, q_dot: 0.0 },
            solver: Settings::default(),
        };
        study_scene(&Resource::new("x", scene), options, &|_| ())
    }

    /// The product and the sum of the multipliers at φ = w t, by the classical Runge-Kutta method.
    fn multipliers(&self, w: f64) -> [f64; 2] {
        const STEPS: usize = 40_000;
        let h = TAU / w.abs() / STEPS as f64;
        let rate = |t: f64, [q, v]: [f64; 2]| {
            let [m, b, c] = [&self.m, &self.b, &self.c].map(|series| series.at(w * t).0[0]);
            [v, -(b * v + c * q) / m]
        };
        let map = [[1.0, 0.0], [0.0, 1.0]].map(|mut y| {
            for i in 0..STEPS {
                let t = i as f64 * h;
                let ahead = |k: [f64; 2], part: f64| [y[0] + part * h * k[0], y[1] + part * h * k[1]];
                let a = rate(t, y);
                let b = rate(t + 0.5 * h, ahead(a, 0.5));
                let c = rate(t + 0.5 * h, ahead(b, 0.5));
                let d = rate(t + h, ahead(c, 1.0));
                y = std::array::from_fn(|j| y[j] + h / 6.0 * (a[j] + 2.0 * (b[j] + c[j]) + d[j]));
            }
            y
        });
        [map[0][0] * map[1][1] - map[0][1] * map[1][0], map[0][0] + map[1][1]]
    }
}

pub(super) fn quick(speeds: &[f64]) -> Options {
    Options { speeds: speeds.to_vec(), quick: true, orders: Some(4), ..Options::default() }
}

#[test]
fn a_drive_that_turns_backwards_has_the_multipliers_of_its_own_motion() {
    let scene = |m, b, c| Coefficients { m, b, c, f: series(&[], &[0.4]) };
    let known = scene(series(&[], &[]), Fourier::new(vec![0.1], vec![0.0, 0.3]), series(&[0.3], &[]));
    for (coefficients, w) in [
        (known, -2.0),
        (scene(series(&[], &[0.4]), Fourier::new(vec![0.08], vec![]), series(&[0.3], &[])), -1.9),
        (scene(series(&[0.1, 0.05], &[0.2, -0.1]), series(&[0.3], &[0.5]), series(&[0.2], &[-0.1, 0.2])), -0.7),
    ] {
        let report = coefficients.study(w, &quick(&[])).unwrap();
        let at = report.speeds[0];
        let [product, sum] = coefficients.multipliers(w);
        let [[a, b], [c, d]] = at.multipliers;
        assert!((a * c - b * d - product).abs() < 1e-9 * (1.0 + product.abs()), "{w}: {at:?} {product}");
        assert!((a + c - sum).abs() < 1e-9 * (1.0 + sum.abs()), "{w}: {at:?} {sum}");
        assert!(report.note.as_ref().is_some_and(|note| note.contains("backwards")), "{:?}", report.note);
        if w == -2.0 {
            // The other sense is another drive.
            let forward = coefficients.study(-w, &quick(&[])).unwrap().speeds[0].radius;
            assert!((at.radius.ln() - 0.312).abs() < 1e-3 && (forward.ln() + 0.157).abs() < 1e-3, "{at:?} {forward}");
        }
        let image = coefficients.mirrored().study(-w, &quick(&[])).unwrap();
        assert_same(&report, &image, 1.0);
        // As an option the speed says the sense itself; the turn is sampled from another start on.
        let asked = coefficients.study(-w, &quick(&[w])).unwrap();
        assert_same(&StabilityAnalysis { courses: Vec::new(), ..asked }, &image, 1.0);
    }
}

/// The numbers of a drive that turns backwards beside those of its mirror image, where q counts in this `sense`.
pub(super) fn assert_same(back: &StabilityAnalysis, image: &StabilityAnalysis, sense: f64) {
    let same = |a: f64, b: f64| (a - b).abs() <= 1e-9 * (1.0 + a.abs());
    for (a, b) in back.speeds.iter().zip(&image.speeds) {
        assert!(same(a.speed, b.speed) && same(a.radius, b.radius), "{a:?} {b:?}");
    }
    for (a, b) in back.orders.iter().zip(&image.orders) {
        assert!(same(a.critical_damping.unwrap_or(-1.0), b.critical_damping.unwrap_or(-1.0)), "{a:?} {b:?}");
        assert!(same(a.undamped[0], b.undamped[0]), "{a:?} {b:?}");
    }
    for (a, b) in back.courses.iter().zip(&image.courses) {
        assert_eq!(a.len(), b.len());
        for (a, b) in a.iter().rev().zip(b) {
            assert!(same(a[0], TAU - b[0]) && same(a[2], sense * b[2]), "{a:?} {b:?}");
            assert!(same(a[1], sense * b[1]) || a[1].is_nan() && b[1].is_nan(), "{a:?} {b:?}");
        }
    }
}

#[test]
fn a_shaft_on_a_cycle_that_turns_backwards_is_its_mirror_image() {
    // The segments of the law are mirrored with it, whether or not one of them begins at 0.
    for start in [0.0, 0.5, 5.0] {
        let cycle = |back: bool| {
            let [rise, dwell, fall] = [1.6, 0.4, 2.5];
            let plan = CyclePlan {
                stroke: 0.15,
                lower: 0.0,
                rise_start: if back { (TAU - (start + rise + dwell + fall)).rem_euclid(TAU) } else { start },
                rise_angle: if back { fall } else { rise },
                upper_dwell: dwell,
                return_angle: if back { rise } else { fall },
                rise_law: if back { StandardLaw::Polynomial345 } else { StandardLaw::ModifiedSine },
                return_law: if back { StandardLaw::ModifiedSine } else { StandardLaw::Polynomial345 },
                inflections: [None; 2],
            };
            MotionLaw::Cycle(Cycle::new(plan))
        };
        let run = |cam: MotionLaw, w: f64| {
            let scene = elastic_shaft::Scene {
                load: Default::default(),
                parameters: elastic_shaft::Parameters { m: 40.0, inertia: 1.2, c: 900.0, b: 3.0 },
                linear: true,
                cam,
                drive: DriveMode::Constant { w, phi_start: 0.0 },
                start: Start { mode: StartMode::AtRest, q: 0.0, q_dot: 0.0 },
                solver: Settings::default(),
            };
            study_scene(&Resource::new("x", scene), &quick(&[]), &|_| ()).unwrap()
        };
        // The angle q of the shaft is mirrored, too.
        assert_same(&run(cycle(false), -9.0), &run(cycle(true), 9.0), -1.0);
    }
}

#[test]
fn one_study_is_of_one_sense() {
    let one = || series(&[], &[]);
    let drive = Coefficients { m: one(), b: series(&[], &[]), c: series(&[0.3], &[]), f: series(&[], &[]) };
    for (w, options) in [
        (2.0, quick(&[1.0, -1.0])),
        (-2.0, Options { range: Some([0.5, 3.0]), ..quick(&[]) }),
        (2.0, Options { range: Some([-0.5, -3.0]), ..quick(&[]) }),
    ] {
        let message = drive.study(w, &options).unwrap_err().to_string();
        assert!(message.contains("opposite signs"), "{message}");
    }
    assert!(drive.study(-2.0, &Options { range: Some([-0.5, -3.0]), ..quick(&[]) }).is_ok());
}
