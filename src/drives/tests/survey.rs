//! A survey of `solver.error_estimate`: the estimate against the error over random scenes of every drive, at four tolerances.
//!
//! `SURVEY_SCENES=100 cargo test --release -p camdrive --lib survey -- --ignored --nocapture` prints, for each drive and for each
//! tolerance, in how many of the runs the estimate covers the error, the least and the median ratio of the two. The test fails if
//! less than 98 of 100 are covered, if an estimate is less than a hundredth of the error, or more than a thousand times the error
//! in the median.
//!
//! The truth is the same drive at the finest tolerance on an equivalent scene whose roundings all differ: its laws are turned on
//! the shaft by 1 rad and three times as large (a plan, a cycle and a table then have other coefficients), the machine is three
//! times as heavy. Both runs are rounded, so roundings count √2 times as much. Inputs follow a smooth motion, exact or as an
//! importer rounds them. Rounded ones move the shaft by jumps, which the drive ignores; the truth follows them: if q counts from
//! the shaft, the mass keeps place and speed.

use crate::drives::follower::load::Load;
use crate::drives::settings::{HasSolver, Settings};
use crate::drives::shaft::cam_drive::{DriveMode, Start, StartMode};
use crate::drives::{Drive, Fault, backlash, elastic_output, elastic_shaft, parametric, rigid_machine};
use crate::motion::plan::SegmentLaw;
use crate::motion::table::Points;
use crate::motion::{Cycle, CyclePlan, Fourier, MotionLaw, MotionPlan, PlanPoint, StandardLaw, Table};
use crate::numerics::double_double::{Double, two_product};
use std::f64::consts::TAU;

const TOLERANCES: [f64; 4] = [1e-3, 1e-6, 1e-9, 1e-12];

/// SplitMix64 (Steele, Lea, Flood).
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        (z ^ (z >> 31)) as f64 / 2f64.powi(64)
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.next()
    }

    /// Evenly on a logarithmic scale.
    fn scale(&mut self, low: f64, high: f64) -> f64 {
        self.between(low.ln(), high.ln()).exp()
    }

    fn chance(&mut self, part: f64) -> bool {
        self.next() < part
    }

    fn count(&mut self, from: usize, to: usize) -> usize {
        from + (self.next() * (to - from + 1) as f64) as usize
    }
}

/// The factor of the laws of the equivalent scene, and the angle by which they are turned (rad).
const LARGER: f64 = 3.0;
const TURNED: f64 = 1.0;

fn series(r: &mut Random, mean: f64, size: f64, order: usize) -> Fourier {
    let mut coefficient = |k: usize| {
        let value = size * r.between(-1.0, 1.0) / (k * k) as f64;
        if r.chance(0.2) { 0.0 } else { value }
    };
    let a = (0..=order).map(|k| if k == 0 { mean } else { coefficient(k) }).collect();
    let b = (0..=order).map(|k| if k == 0 { 0.0 } else { coefficient(k) }).collect();
    Fourier::new(a, b)
}

fn law(r: &mut Random, size: f64) -> MotionLaw {
    match r.count(0, 3) {
        0 => MotionLaw::Fourier({
            let order = r.count(1, 6);
            series(r, 0.0, size, order)
        }),
        1 => {
            let any = |r: &mut Random| StandardLaw::ALL[r.count(1, 5)];
            let angles = [r.between(0.5, 1.5), r.between(0.0, 0.8), r.between(0.5, 1.5), r.between(0.0, 0.8)];
            let unit = TAU / angles.iter().sum::<f64>();
            MotionLaw::Cycle(Cycle::new(CyclePlan {
                stroke: size,
                lower: size * r.between(-1.0, 1.0),
                rise_start: r.between(0.0, 6.0),
                rise_angle: angles[0] * unit,
                upper_dwell: angles[1] * unit,
                return_angle: angles[2] * unit,
                rise_law: any(r),
                return_law: any(r),
                inflections: [None; 2],
            }))
        }
        2 => {
            let count = r.count(2, 6);
            let points = (0..count).map(|i| {
                let phi = TAU * (i as f64 + r.between(-0.3, 0.3)) / count as f64;
                let mut value = || Some(size * r.between(-1.0, 1.0));
                let (u, velocity, acceleration, jerk) = (value(), value(), value(), value());
                PlanPoint {
                    phi,
                    u: u.unwrap_or(0.0),
                    velocity,
                    acceleration,
                    free: false,
                    jerk,
                    law: Some(SegmentLaw::Standard(StandardLaw::Polynomial4567)),
                    inflection: None,
                }
            });
            MotionLaw::Plan(MotionPlan::new(points.collect()))
        }
        _ => {
            let (smooth, count) = (series(r, 0.0, size, 3), r.count(12, 60));
            let angles: Vec<f64> = (0..count).map(|i| TAU * (i as f64 + r.between(0.0, 0.5)) / count as f64).collect();
            let lifts = angles.iter().map(|phi| smooth.at(*phi).0[0]).collect();
            MotionLaw::Table(Table::new(Points { angles, lifts }).unwrap())
        }
    }
}

fn turned_series(law: &Fourier, larger: f64) -> Fourier {
    let turned = |k: usize| {
        let (sin, cos) = (k as f64 * TURNED).sin_cos();
        [larger * (law.a[k] * cos - law.b[k] * sin), larger * (law.a[k] * sin + law.b[k] * cos)]
    };
    let terms: Vec<[f64; 2]> = (0..law.a.len()).map(turned).collect();
    let [cosines, sines] = [0, 1].map(|i| terms.iter().map(|t| t[i]).collect());
    Fourier::new(cosines, sines)
}

/// The law as another one, turned on the shaft and larger.
fn turned(law: &MotionLaw) -> MotionLaw {
    match law {
        MotionLaw::Fourier(law) => MotionLaw::Fourier(turned_series(law, LARGER)),
        MotionLaw::Cycle(cycle) => {
            let plan = *cycle.plan();
            MotionLaw::Cycle(Cycle::new(CyclePlan {
                stroke: LARGER * plan.stroke,
                lower: LARGER * plan.lower,
                rise_start: (plan.rise_start + TURNED).rem_euclid(TAU),
                ..plan
            }))
        }
        MotionLaw::Plan(plan) => {
            let larger = |value: Option<f64>| value.map(|value| LARGER * value);
            let point = |point: &PlanPoint| PlanPoint {
                phi: point.phi + TURNED,
                u: LARGER * point.u,
                velocity: larger(point.velocity),
                acceleration: larger(point.acceleration),
                jerk: larger(point.jerk),
                ..*point
            };
            MotionLaw::Plan(MotionPlan::new(plan.points().iter().map(point).collect()))
        }
        MotionLaw::Table(table) => {
            let Points { angles, lifts } = table.points();
            let angles = angles.iter().map(|phi| phi + TURNED).collect();
            MotionLaw::Table(Table::new(Points { angles, lifts: lifts.iter().map(|u| LARGER * u).collect() }).unwrap())
        }
        MotionLaw::Crank(_) => law.clone(),
        MotionLaw::Polyline(_) => unreachable!("a force is no cam"),
    }
}

/// The motion of a shaft on its drive.
#[derive(Clone, Debug)]
struct Trajectory {
    /// φ, ω, α and its derivative at the start, on inputs; None at constant speed.
    inputs: Option<[f64; 4]>,
    /// Whether the inputs at each point are numbers without rounding.
    exact: bool,
    /// The communication points (s), the first one 0.
    times: Vec<f64>,
}

impl Trajectory {
    /// From `phi` at the speed `w` over `span` (s).
    fn new(r: &mut Random, kind: usize, [phi, w]: [f64; 2], span: f64) -> Self {
        let count = r.count(2, 12);
        let mut times: Vec<f64> = (0..count).map(|_| span * r.next()).collect();
        times.sort_by(f64::total_cmp);
        times.insert(0, 0.0);
        if r.chance(0.2) {
            times[1] = (times[1] * r.scale(1e-4, 1.0)).max(1e-5 * span);
        }
        let a = if r.chance(0.3) { 0.0 } else { 0.5 * w / span * r.between(-1.0, 1.0) };
        let jerk = if r.chance(0.5) { 0.0 } else { w / (span * span) * r.between(-1.0, 1.0) };
        let exact = kind == 1;
        let mut inputs = (kind > 0).then_some([phi, w, a, jerk]);
        if exact {
            // Few digits: all products below are exact.
            let digits = |x: f64, size: f64, bits: i32| {
                let unit = 2f64.powi(size.abs().log2().ceil() as i32 - bits);
                (x / unit).round() * unit
            };
            times.iter_mut().for_each(|t| *t = digits(*t, span, 16));
            times.dedup();
            inputs =
                Some([digits(phi, 1.0, 8), digits(w, w, 8), if a == 0.0 { 0.0 } else { digits(a, w / span, 6) }, 0.0]);
        }
        Trajectory { inputs, exact, times }
    }

    /// φ, ω, α at a communication point, before they are rounded.
    fn at(&self, t: f64) -> [Double; 3] {
        let [phi, w, a, jerk] = self.inputs.unwrap_or_default().map(Double::from);
        let (t, part) = (Double::from(t), |n: f64| Double::from(1.0).divide(Double::from(n)));
        let half = part(2.0);
        [phi + w * t + a * t * t * half + jerk * t * t * t * part(6.0), w + a * t + jerk * t * t * half, a + jerk * t]
    }

    /// The jumps of φ and ω when the rounded inputs of point `i` are set.
    fn jump(&self, i: usize) -> [f64; 2] {
        let [before, now] = [i - 1, i].map(|i| self.at(self.times[i]).map(|x| x.hi));
        let jerk = self.inputs.unwrap_or_default()[3];
        let h = Double::from(self.times[i]) - Double::from(self.times[i - 1]);
        let start = Trajectory { inputs: Some([before[0], before[1], before[2], jerk]), exact: false, times: vec![] };
        let [phi, w, _] = start.at(h.hi);
        let phi = phi + two_product(before[1], h.lo);
        [(Double::from(now[0]) - phi).hi, (Double::from(now[1]) - w).hi]
    }
}

/// Runs through the trajectory; calls `read` at each communication point, returns the estimate. `turned`: the angle by which the
/// shaft is turned; `kick` makes the drive follow a jump of the shaft.
fn run<D: Drive<Scene = S> + HasSolver, S, const N: usize>(
    scene: S,
    course: &Trajectory,
    turned: f64,
    mut kick: impl FnMut(&mut D, [f64; 2], [f64; 3], f64),
    read: impl Fn(&D) -> [f64; N],
) -> Result<(Vec<[f64; N]>, f64), Fault> {
    let mut drive = D::new(scene)?;
    let variables = drive.variables().0;
    let set = |drive: &mut D, t: f64| {
        let Some([.., jerk]) = course.inputs else { return };
        for (reference, value) in course.at(t).into_iter().enumerate() {
            let value = value.hi + if reference == 0 { turned } else { 0.0 };
            variables[reference].set(drive, value);
        }
        if jerk != 0.0 {
            variables[2].set_derivative(drive, 1, jerk);
        }
    };
    set(&mut drive, 0.0);
    drive.start(0.0)?;
    let mut values = vec![read(&drive)];
    for i in 1..course.times.len() {
        let [from, to] = [course.times[i - 1], course.times[i]];
        set(&mut drive, from);
        if i > 1 && course.inputs.is_some() && !course.exact {
            kick(&mut drive, course.jump(i - 1), course.at(from).map(|x| x.hi), from - course.times[i - 2]);
        }
        drive.apply(from)?;
        drive.advance(from, to - from)?;
        values.push(read(&drive));
    }
    let estimate = drive.statistics()[2];
    Ok((values, estimate))
}

/// The largest difference at any communication point, each value relative to the largest over the run.
fn difference<const N: usize>(got: &[[f64; N]], truth: &[[f64; N]], larger: f64) -> f64 {
    let worst = |k: usize| {
        let largest = truth.iter().fold(0.0, |largest, y| f64::max(largest, (y[k] / larger).abs()));
        let error = got.iter().zip(truth).fold(0.0, |error, (y, z)| f64::max(error, (y[k] - z[k] / larger).abs()));
        if error == 0.0 { 0.0 } else { error / largest }
    };
    (0..N).map(worst).fold(0.0, f64::max)
}

/// A row of the survey: estimate and error of each run, with the number of its scene.
#[derive(Default)]
struct Rows(Vec<([String; 2], usize, [f64; 2])>);

impl Rows {
    /// Adds a scene of this kind with its estimate.
    fn add(&mut self, kind: &str, tolerance: f64, number: usize, [error, estimate]: [f64; 2]) {
        if chosen(number) {
            println!("{kind} {tolerance:e} {number}: error {error:e}, estimate {estimate:e}");
        }
        // A drive that does not move has no error.
        if error > 0.0 {
            self.0.push(([kind.to_owned(), format!("{tolerance:.0e}")], number, [error, estimate]));
        }
    }

    /// Prints and judges.
    fn tell(&self, name: &str) -> bool {
        let mut labels: Vec<&str> = self.0.iter().flat_map(|row| row.0.iter().map(String::as_str)).collect();
        labels.sort_unstable();
        labels.dedup();
        let figures = |of: &dyn Fn(&[String; 2]) -> bool| {
            let mut ratios: Vec<(f64, usize)> =
                self.0.iter().filter(|row| of(&row.0)).map(|row| (row.2[1] / row.2[0].max(1e-17), row.1)).collect();
            ratios.sort_by(|a, b| a.0.total_cmp(&b.0));
            let covered = ratios.iter().filter(|r| r.0 >= 1.0).count() as f64 / ratios.len() as f64;
            (ratios.len(), 100.0 * covered, ratios[0], ratios[ratios.len() / 2].0)
        };
        let print = |what: &str, (count, covered, (least, number), median): (usize, f64, (f64, usize), f64)| {
            println!("{what:34} {count:6} {covered:8.1} {least:10.1e} (scene {number:4}) {median:10.1e}");
        };
        for label in labels {
            print(&format!("  {label}"), figures(&|of| of.iter().any(|of| of == label)));
        }
        let whole = figures(&|_| true);
        print(name, whole);
        whole.1 >= 98.0 && whole.2.0 >= 0.01 && whole.3 <= 1000.0
    }
}

/// Whether everything about this scene is printed.
fn chosen(number: usize) -> bool {
    std::env::var("SURVEY_SCENE").is_ok_and(|n| n == number.to_string())
}

fn scenes() -> usize {
    std::env::var("SURVEY_SCENES").ok().and_then(|n| n.parse().ok()).unwrap_or(100)
}

fn settings(tolerance: f64) -> Settings {
    Settings { tolerance, ..Settings::default() }
}

fn kind_of(law: &MotionLaw) -> &'static str {
    match law {
        MotionLaw::Fourier(_) => "series",
        MotionLaw::Cycle(_) => "cycle",
        MotionLaw::Plan(_) => "plan",
        MotionLaw::Table(_) => "table",
        MotionLaw::Crank(_) => "crank",
        MotionLaw::Polyline(_) => "lines",
    }
}

const KINDS: [&str; 3] = ["constant speed", "exact inputs", "rounded inputs"];
const FINEST: f64 = 1e-14;

fn start(r: &mut Random, size: f64, frequency: f64) -> Start {
    if r.chance(0.4) {
        return Start { mode: StartMode::AtRest, q: 0.0, q_dot: 0.0 };
    }
    let q = size * r.between(-1.0, 1.0);
    Start { mode: StartMode::Given, q, q_dot: frequency * size * r.between(-1.0, 1.0) }
}

fn mode(course: &Trajectory, w: f64, phi_start: f64) -> DriveMode {
    if course.inputs.is_some() { DriveMode::Input } else { DriveMode::Constant { w, phi_start } }
}

/// Follows no jump.
fn still<D>(_: &mut D, _: [f64; 2], _: [f64; 3], _: f64) {}

fn shaft(linear: bool) -> Rows {
    let (r, mut rows) = (&mut Random(20 + u64::from(linear)), Rows::default());
    for number in 0..3 * scenes() {
        let size = r.scale(0.01, 0.5);
        let cam = law(r, size);
        let m = r.scale(0.1, 100.0);
        let inertia = m * cam.bound(1).max(1e-3).powi(2) * r.scale(0.03, 30.0);
        let c = r.scale(1e2, 1e5);
        let frequency = (c / inertia).sqrt();
        let w = frequency / r.scale(1.0 / 3.0, 30.0) * if r.chance(0.3) { -1.0 } else { 1.0 };
        let b = if r.chance(0.15) { 0.0 } else { 2.0 * r.scale(1e-3, 1.0) * (c * inertia).sqrt() };
        let (phi, span) = (r.between(-10.0, 10.0), r.scale(0.3, 30.0) * TAU / w.abs());
        let course = Trajectory::new(r, number % 3, [phi, w], span);
        let kind = format!("{}, {}", kind_of(&cam), KINDS[number % 3]);
        let size = r.scale(1e-6, 0.1);
        let scene = elastic_shaft::Scene {
            load: Default::default(),
            parameters: elastic_shaft::Parameters { m, inertia, c, b },
            linear,
            cam,
            drive: mode(&course, w, phi),
            start: start(r, size, frequency),
            solver: settings(FINEST),
        };
        let same = elastic_shaft::Scene {
            cam: turned(&scene.cam),
            parameters: elastic_shaft::Parameters { m: m / (LARGER * LARGER), ..scene.parameters },
            drive: mode(&course, w, phi + TURNED),
            ..scene.clone()
        };
        let kick = |drive: &mut elastic_shaft::ElasticShaft, [phi, w]: [f64; 2], _: [f64; 3], _: f64| {
            drive.before[2] -= phi;
            drive.before[3] -= w;
        };
        let Ok((truth, _)) = run(same, &course, TURNED, kick, |drive| drive.state) else { continue };
        for tolerance in TOLERANCES {
            let scene = elastic_shaft::Scene { solver: settings(tolerance), ..scene.clone() };
            let Ok((got, estimate)) =
                run(scene, &course, 0.0, still, |drive: &elastic_shaft::ElasticShaft| drive.state)
            else {
                continue;
            };
            rows.add(&kind, tolerance, number, [difference(&got, &truth, 1.0), estimate]);
        }
    }
    rows
}

/// A law with this mean stiffness, inertia and damping, and the same for a turned and larger motion.
fn parametric_laws(
    r: &mut Random,
    crank: bool,
    means: [f64; 3],
    load: &Option<Fourier>,
) -> (parametric::law::Law, parametric::law::Law) {
    use parametric::crank::{ParallelCrank, SecondCrank};
    use parametric::law::{Coordinate, CrankLaw, Law, SeriesLaw};
    let [mean, m, damping] = means;
    let larger = |load: &Option<Fourier>| load.as_ref().map(|load| turned_series(load, LARGER));
    if crank {
        let second = match r.count(0, 3) {
            0 | 1 => SecondCrank::None,
            2 => SecondCrank::OwnShafts(r.between(-3.0, 3.0)),
            _ => SecondCrank::SharedShafts(r.between(-3.0, 3.0)),
        };
        let (sigma, radius) = (r.scale(1e-3, 1e2), r.scale(0.05, 1.0));
        let of = |c: f64| ParallelCrank {
            c_t1: c * mean * 3.0,
            c_t2: c * mean * 4.0,
            c_ab: c * mean / (sigma * radius * radius),
            r: radius,
            second,
        };
        let of = |c: f64, load: Option<Fourier>| {
            Law::Crank(CrankLaw { crank: of(c), inertia: c * m, damping: c * damping, load, harmonics: None })
        };
        // A crank has no other angle.
        let three = |load: &Fourier| {
            let [a, b] = [&load.a, &load.b].map(|x| x.iter().map(|x| LARGER * x).collect());
            Fourier::new(a, b)
        };
        (of(1.0, load.clone()), of(LARGER, load.as_ref().map(three)))
    } else {
        let [of_m, of_b, of_c] = [(m, 0.3), (damping, 0.5), (mean, 0.8)].map(|(mean, part)| {
            let order = r.count(1, 5);
            series(r, mean, 0.5 * part * mean, order)
        });
        let same = [&of_m, &of_b, &of_c].map(|law| turned_series(law, LARGER));
        let [m, b, c] = [of_m, of_b, of_c];
        let of =
            |[m, b, c]: [Fourier; 3], f| Law::Series(SeriesLaw { coordinate: Coordinate::Translation, m, b, c, f });
        (of([m, b, c], load.clone()), of(same, larger(load)))
    }
}

fn parametric(crank: bool) -> Rows {
    use parametric::{ParametricDrive, Scene};
    let (r, mut rows) = (&mut Random(40 + u64::from(crank)), Rows::default());
    for number in 0..3 * scenes() {
        let (mean, m) = (r.scale(1e2, 1e6), r.scale(0.1, 100.0));
        let damping = if r.chance(0.15) { 0.0 } else { 2.0 * r.scale(1e-3, 1.0) * (m * mean).sqrt() };
        let order = r.count(1, 5);
        let load = r.chance(0.5).then(|| series(r, 0.1 * mean, 0.1 * mean, order));
        let (law, same) = parametric_laws(r, crank, [mean, m, damping], &load);
        let frequency = (mean / m).sqrt();
        let w = frequency / r.scale(1.0 / 3.0, 30.0) * if r.chance(0.3) { -1.0 } else { 1.0 };
        let (phi, span) = (r.between(-10.0, 10.0), r.scale(0.3, 30.0) * TAU / w.abs());
        let course = Trajectory::new(r, number % 3, [phi, w], span);
        let kind = KINDS[number % 3];
        let size = r.scale(1e-6, 0.1);
        let scene = Scene {
            law,
            drive: mode(&course, w, phi),
            load: Default::default(),
            start: start(r, size, frequency),
            solver: settings(FINEST),
        };
        let turned = if crank { 0.0 } else { TURNED };
        let same = Scene { law: same, drive: mode(&course, w, phi + turned), ..scene.clone() };
        let kick = |drive: &mut ParametricDrive, [phi, w]: [f64; 2], _: [f64; 3], _: f64| {
            if crank {
                drive.before[2] -= phi;
                drive.before[3] -= w;
            }
        };
        let Ok((truth, _)) = run(same, &course, turned, kick, |drive| drive.state) else { continue };
        // Only roundings move an oscillator at rest without loads.
        if scene.start.mode == StartMode::AtRest
            && load.is_none()
            && course.inputs.is_none_or(|[_, _, a, j]| a == 0.0 && j == 0.0)
        {
            continue;
        }
        for tolerance in TOLERANCES {
            let scene = Scene { solver: settings(tolerance), ..scene.clone() };
            let Ok((got, estimate)) = run(scene, &course, 0.0, still, |drive: &ParametricDrive| drive.state) else {
                continue;
            };
            rows.add(kind, tolerance, number, [difference(&got, &truth, 1.0), estimate]);
        }
    }
    rows
}

fn named<D: Drive, const N: usize>(drive: &D, names: [&str; N]) -> [f64; N] {
    let list = drive.variables();
    names.map(|name| list.0[list.reference(name).unwrap()].value(drive))
}

fn output() -> Rows {
    use elastic_output::*;
    let (r, mut rows) = (&mut Random(60), Rows::default());
    for number in 0..3 * scenes() {
        let size = r.scale(1e-3, 0.1);
        let cam = law(r, size);
        let (m, w) = (r.scale(0.1, 100.0), r.scale(0.3, 300.0) * if r.chance(0.3) { -1.0 } else { 1.0 });
        let frequency = w.abs() * r.scale(0.3, 100.0);
        let c = m * frequency * frequency;
        let b = if r.chance(0.2) { 0.0 } else { 2.0 * r.scale(1e-3, 1.5) * m * frequency };
        let (phi, span) = (r.between(-10.0, 10.0), r.scale(0.1, 30.0) * TAU / w.abs());
        let course = Trajectory::new(r, number % 3, [phi, w], span);
        let kind = format!("{}, {}", kind_of(&cam), KINDS[number % 3]);
        let size = size * r.scale(1e-4, 1.0);
        let scene = Scene {
            coupling: false,
            parameters: Parameters { m, c, b },
            load: Load::default(),
            roller: (0.0, Load::default()),
            cam: cam.clone(),
            drive: mode(&course, w, phi),
            start: start(r, size, frequency),
            solver: settings(FINEST),
        };
        let larger = |start: Start| Start { q: LARGER * start.q, q_dot: LARGER * start.q_dot, ..start };
        let same = Scene {
            cam: turned(&cam),
            drive: mode(&course, w, phi + TURNED),
            start: larger(scene.start),
            ..scene.clone()
        };
        let Ok((mut truth, _)) =
            run(same, &course, TURNED, still, |drive: &ElasticOutput| named(drive, ["q", "der(q)"]))
        else {
            continue;
        };
        // The jumps of the inputs start the free motion; they do not move the mass.
        if number % 3 == 2 {
            let oscillator =
                crate::numerics::oscillator::Oscillator::new(Double::from(c / m), Double::from(0.5 * b / m));
            let mut free = [0.0; 2];
            for i in 1..course.times.len() {
                if i > 1 {
                    let ([phi, w], now) = (course.jump(i - 1), course.at(course.times[i - 1]).map(|x| x.hi));
                    let [_, slope, curvature, ..] = cam.at(now[0] % TAU).0;
                    free[0] -= slope * phi;
                    free[1] -= slope * w + curvature * now[1] * phi;
                }
                let [[a, b], [c, d]] = oscillator.free(Double::from(course.times[i] - course.times[i - 1]));
                free = [a * free[0] + b * free[1], c * free[0] + d * free[1]];
                for k in 0..2 {
                    truth[i][k] += LARGER * free[k];
                }
            }
        }
        for tolerance in TOLERANCES {
            let scene = Scene { solver: settings(tolerance), ..scene.clone() };
            let read = |drive: &ElasticOutput| named(drive, ["q", "der(q)"]);
            let Ok((got, estimate)) = run(scene, &course, 0.0, still, read) else { continue };
            rows.add(&kind, tolerance, number, [difference(&got, &truth, LARGER), estimate]);
        }
    }
    rows
}

fn backlash() -> Rows {
    use backlash::*;
    let (r, mut rows) = (&mut Random(80), Rows::default());
    for number in 0..3 * scenes() {
        let size = r.scale(1e-3, 0.1);
        let cam = law(r, size);
        let m2 = r.scale(0.5, 20.0);
        let (m1, w) = (m2 * r.scale(0.1, 3.0), r.scale(1.0, 300.0));
        let frequency = w * r.scale(3.0, 40.0);
        let (c, s) = (m2 * frequency * frequency, size * r.scale(1e-3, 0.1));
        let b = if r.chance(0.3) { 0.0 } else { 2.0 * r.scale(1e-3, 0.5) * m2 * frequency };
        let e = if r.chance(0.5) { 0.0 } else { r.between(0.0, 0.95) };
        let (phi, span) = (r.between(-10.0, 10.0), r.scale(0.1, 10.0) * TAU / w);
        let course = Trajectory::new(r, number % 3, [phi, w], span);
        let kind = format!("{}, {}", kind_of(&cam), KINDS[number % 3]);
        let size = 0.1 * s;
        let scene = Scene {
            coupling: false,
            parameters: Parameters { m1, m2, c, b, s, e },
            cam,
            drive: mode(&course, w, phi),
            start: start(r, size, frequency),
            solver: settings(0.0),
        };
        let start = Start { q: LARGER * scene.start.q, q_dot: LARGER * scene.start.q_dot, ..scene.start };
        let same = Scene {
            cam: turned(&scene.cam),
            parameters: Parameters { s: LARGER * s, ..scene.parameters },
            drive: mode(&course, w, phi + TURNED),
            start,
            ..scene.clone()
        };
        let read = |drive: &BacklashDrive| named(drive, ["x1", "y", "der(x1)", "der(y)"]);
        let Ok((truth, _)) = run(same, &course, TURNED, still, read) else { continue };
        let top = course.times.iter().map(|t| course.at(*t)[1].hi.abs()).fold(0.0, f64::max);
        let speed = scene.cam.bound(1) * if course.inputs.is_some() { top } else { w };
        let sizes = [scene.cam.bound(0), scene.cam.bound(0), speed, speed];
        for tolerance in TOLERANCES {
            let scene = Scene { solver: settings(tolerance), ..scene.clone() };
            let Ok((got, estimate)) = run(scene.clone(), &course, 0.0, still, read) else { continue };
            let of = |y: &[f64; 4], z: &[f64; 4]| {
                (0..4).map(|k| (y[k] - z[k] / LARGER).abs() / sizes[k]).fold(0.0, f64::max)
            };
            if chosen(number) {
                println!("{scene:?}\n{course:?}\n{got:?}\n{truth:?}");
            }
            // Errors beyond the motion itself no longer measure an error.
            let error = got.iter().zip(&truth).map(|(y, z)| of(y, z)).fold(0.0, f64::max).min(1.0);
            rows.add(&kind, tolerance, number, [error, estimate]);
        }
    }
    rows
}

/// The inputs of a machine of a kind: value, rate and half of the second derivative.
struct Signals {
    kind: usize,
    varies: bool,
    load: [f64; 3],
    driving: [f64; 3],
}

impl Signals {
    /// φ, ω and a lagging torque at the times of a trajectory, and the error estimate; torques and inertia are so many times
    /// larger.
    fn motion(&self, scene: rigid_machine::Scene, larger: f64, course: &Trajectory) -> Option<(Vec<[f64; 3]>, f64)> {
        let mut machine = rigid_machine::RigidMachine::new(scene).ok()?;
        let list = machine.variables();
        let set = |machine: &mut rigid_machine::RigidMachine, t: f64| {
            for (name, [a, b, c]) in [("tau", self.load), ("M_an", self.driving)] {
                if name == "M_an" && self.kind != 2 {
                    continue;
                }
                let reference = list.reference(name).unwrap();
                list.0[reference].set(machine, larger * (a + t * (b + t * c)));
                if self.varies {
                    list.0[reference].set_derivative(machine, 1, larger * (b + 2.0 * c * t));
                    list.0[reference].set_derivative(machine, 2, larger * 2.0 * c);
                }
            }
        };
        set(&mut machine, 0.0);
        machine.start(0.0).ok()?;
        let mut values = vec![];
        for points in course.times.windows(2) {
            set(&mut machine, points[0]);
            machine.apply(points[0]).ok()?;
            machine.advance(points[0], points[1] - points[0]).ok()?;
            let [phi, w] = named(&machine, ["phi", "w"]);
            let torque = if self.kind == 1 { named(&machine, ["M_an"])[0] / larger } else { 0.0 };
            values.push([phi, w, torque]);
        }
        Some((values, machine.statistics()[2]))
    }
}

fn machine(kind: usize) -> Rows {
    use rigid_machine::*;
    let (r, mut rows) = (&mut Random(100 + kind as u64), Rows::default());
    for number in 0..3 * scenes() {
        let constant = r.scale(0.05, 5.0);
        let followers: Vec<Follower> = (0..r.count(0, 3))
            .map(|_| {
                let size = r.scale(0.01, 0.3);
                Follower::new(constant * r.scale(0.03, 1.0) / (size * size), law(r, size))
            })
            .collect();
        let kinds = followers.iter().map(|f| kind_of(&f.cam)).max().unwrap_or("constant J");
        let synchronous = r.scale(5.0, 300.0) * if r.chance(0.3) { -1.0 } else { 1.0 };
        let torque = constant * synchronous * synchronous * r.scale(0.02, 1.0);
        let turn = TAU / synchronous.abs();
        let (breakdown_slip, lag) = (r.scale(0.05, 0.5), turn * r.scale(0.02, 2.0));
        let motor = |larger: f64| {
            let kloss = |dynamics| {
                let breakdown_torque = larger * torque;
                Motor::Kloss(Kloss { breakdown_torque, breakdown_slip, synchronous_speed: synchronous, dynamics })
            };
            match kind {
                0 => kloss(None),
                1 => kloss(Some(lag)),
                2 => Motor::Input,
                _ => Motor::None,
            }
        };
        let (phi_start, w_start) = (r.between(-10.0, 10.0), synchronous * r.between(0.1, 1.2));
        let span = turn * r.scale(0.3, 20.0);
        let course = Trajectory::new(r, 0, [0.0, 0.0], span);
        let varies = if r.chance(0.3) { 1.0 } else { 0.0 };
        let mut signal = || {
            let [a, b, c] = [0; 3].map(|_| 0.2 * torque * r.between(-1.0, 1.0));
            [a, varies * b / span, varies * c / (span * span)]
        };
        let (load, driving) = (signal(), signal());
        let scene = |solver: Settings, turned: Option<()>| {
            let larger = if turned.is_some() { LARGER } else { 1.0 };
            let other = |cam: &MotionLaw| if turned.is_some() { self::turned(cam) } else { cam.clone() };
            Scene {
                loads: vec![Default::default()],
                inertia: InertiaFunction { constant: larger * constant, varying: None },
                followers: followers.iter().map(|f| Follower::new(f.m / larger, other(&f.cam))).collect(),
                motor: motor(larger),
                phi_start: phi_start + if turned.is_some() { TURNED } else { 0.0 },
                w_start,
                start: MachineStart::Given,
                solver,
            }
        };
        let signals = Signals { kind, varies: varies != 0.0, load, driving };
        let Some((truth, _)) = signals.motion(scene(settings(FINEST), Some(())), LARGER, &course) else { continue };
        let top = truth.iter().map(|y| y[1].abs()).fold(w_start.abs(), f64::max);
        let mut passed = 0.0;
        for i in 0..truth.len() {
            passed += (truth[i][0] - if i > 0 { truth[i - 1][0] } else { phi_start + TURNED }).abs();
        }
        for tolerance in TOLERANCES {
            let Some((got, estimate)) = signals.motion(scene(settings(tolerance), None), 1.0, &course) else {
                continue;
            };
            if chosen(number) {
                println!("{:?}\n{course:?} {load:?} {driving:?}\n{got:?}\n{truth:?}", scene(settings(tolerance), None));
            }
            let error = got.iter().zip(&truth).map(|(y, z)| {
                let of_phi = (y[0] - (z[0] - TURNED)).abs() / passed.max(1.0);
                let of_torque = if kind == 1 { (y[2] - z[2]).abs() / torque } else { 0.0 };
                of_phi.max((y[1] - z[1]).abs() / top).max(of_torque)
            });
            rows.add(kinds, tolerance, number, [error.fold(0.0, f64::max), estimate]);
        }
    }
    rows
}

#[test]
#[ignore = "minutes"]
fn survey() {
    println!("{:34} {:>6} {:>8} {:>10} {:12} {:>10}", "", "runs", "covered", "least", "", "median");
    let only = std::env::var("SURVEY").unwrap_or_default();
    let drives: [(&str, &dyn Fn() -> Rows); 10] = [
        ("linear shaft", &|| shaft(true)),
        ("nonlinear shaft", &|| shaft(false)),
        ("series", &|| parametric(false)),
        ("crank", &|| parametric(true)),
        ("elastic output", &output),
        ("backlash", &backlash),
        ("machine, Kloss", &|| machine(0)),
        ("machine, lag", &|| machine(1)),
        ("machine, torque input", &|| machine(2)),
        ("machine, no motor", &|| machine(3)),
    ];
    let failed: Vec<&str> = drives.iter().filter(|d| d.0.contains(&only) && !d.1().tell(d.0)).map(|d| d.0).collect();
    assert!(failed.is_empty(), "{failed:?}");
}
