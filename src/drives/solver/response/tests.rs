//! The methods against each other; the drives' tests compare with independent numbers.

mod truth;

use super::*;
use crate::drives::settings::FINEST_TOLERANCE;
use crate::motion::{Cycle, CyclePlan, Fourier, StandardLaw};
use std::f64::consts::TAU;
use truth::Truth;

fn series() -> Fourier {
    Fourier::new(vec![0.01, -0.01, 0.0012, 0.0005, -0.0002], vec![0.0, 0.0, 8e-4, -3e-4, 0.0, 1e-4])
}

impl Response {
    fn q_at(&mut self, law: &MotionLaw, time: f64) -> Result<[f64; 2], Fault> {
        self.at(law, time, &mut Work::default())
    }
}

fn law() -> MotionLaw {
    MotionLaw::Fourier(series())
}

/// The response in pieces where the closed form exists.
fn restart_in_pieces(r: &mut Response, law: &MotionLaw, motion: &AngleMotion, time: f64, state: [f64; 2]) {
    (r.motion, r.until) = (*motion, f64::INFINITY);
    r.next_piece(law, 0, Double::from(time), state).unwrap();
}

#[test]
fn pieces_and_closed_form_agree() {
    let law = law();
    let motion = AngleMotion::uniform(1.5, 0.3, 20.0);
    let period = TAU / 20.0;
    for (c, b) in [(1e5, 40.0), (400.0, 0.0), (1e5, 2000.0), (1e14, 1.0), (1e5, 1e9), (1e-6, 0.0)] {
        let mut closed = Response::new(Equation::new([1.0, c, b]), &law, FINEST_TOLERANCE);
        let mut pieces = closed.clone();
        let start = [1e-4, -0.02];
        closed.restart(&law, &motion, 2.0, f64::INFINITY, start).unwrap();
        restart_in_pieces(&mut pieces, &law, &motion, 2.0, start);
        let (mut error, mut largest) = (0.0f64, 0.0f64);
        for i in 1..=100 {
            let time = 2.0 + period * 0.037 * f64::from(i);
            let (a, b) = (closed.q_at(&law, time).unwrap(), pieces.q_at(&law, time).unwrap());
            (error, largest) = (error.max((a[0] - b[0]).abs()), largest.max(a[0].abs()));
        }
        assert!(error < 1e-13 * largest, "c = {c}, b = {b}: {error:e} of {largest:e}");
    }
}

#[test]
fn a_piece_without_end_is_laid_at_once() {
    // Such a slow cam belongs to a damaged state: no length lets it turn by the angle of a piece.
    let motion = AngleMotion { degree: 1, ..AngleMotion::uniform(0.0, 0.3, 0.0) };
    let mut r = Response::new(Equation::new([1.0, 1600.0, 0.0]), &law(), FINEST_TOLERANCE);
    (r.motion, r.until) = (motion, f64::INFINITY);
    r.next_piece(&law(), 0, Double::from(0.0), [1e-3, 0.0]).unwrap();
    assert!(!r.q_at(&law(), 1.0).is_ok_and(|q| q.iter().all(|q| q.is_finite())));
}

#[test]
fn a_backward_cam_mirrors_the_sine_coefficients() {
    let minus = series().b.iter().map(|b| -b).collect();
    let (law, mirrored) = (law(), MotionLaw::Fourier(Fourier::new(series().a, minus)));
    let oscillator = Equation::new([1.0, 1600.0, 0.0]);
    let mut backward = Response::new(oscillator, &law, FINEST_TOLERANCE);
    let mut forward = Response::new(oscillator, &mirrored, FINEST_TOLERANCE);
    backward.restart(&law, &AngleMotion::uniform(0.0, -0.3, -20.0), 0.0, f64::INFINITY, [0.0; 2]).unwrap();
    forward.restart(&mirrored, &AngleMotion::uniform(0.0, 0.3, 20.0), 0.0, f64::INFINITY, [0.0; 2]).unwrap();
    assert_eq!(backward.q_at(&law, 3.0), forward.q_at(&mirrored, 3.0));
}

/// Numbers in [0, 1) from a fixed seed: the generator of Lehmer with the multiplier of Park and Miller.
struct Dice(u64);

impl Dice {
    fn roll(&mut self) -> f64 {
        self.0 = self.0 * 48271 % 2147483647;
        self.0 as f64 / 2147483647.0
    }

    /// Between `low` and `high`, all magnitudes alike.
    fn magnitude(&mut self, low: f64, high: f64) -> f64 {
        low * (high / low).powf(self.roll())
    }
}

/// The kinds of steps in [`errors_of_a_run`].
#[derive(Clone, Copy, Debug, PartialEq)]
enum Case {
    /// A series at constant speed: in closed form, by one rule a step, in pieces.
    Closed,
    /// In closed form over few turns, with a natural frequency close to a harmonic: terms that all but cancel.
    Beat,
    Hermite,
    Pieces,
    /// A ramp of the speed, set anew in each step, for a series by one rule a step.
    RampOfSeries,
    /// The same for a cycle of VDI 2143 laws with dwells, in pieces, and at constant speed.
    RampOfCycle,
    Cycle,
}

fn random_cycle(dice: &mut Dice) -> MotionLaw {
    let pick = |dice: &mut Dice| StandardLaw::ALL[(dice.roll() * StandardLaw::ALL.len() as f64) as usize];
    let shares = [0.2, 0.0, 0.2, 0.0].map(|least| least + 0.5 * dice.roll());
    let unit = TAU / shares.iter().sum::<f64>();
    MotionLaw::Cycle(Cycle::new(CyclePlan {
        stroke: 0.02,
        lower: 0.0,
        rise_start: TAU * dice.roll(),
        rise_angle: shares[0] * unit,
        upper_dwell: shares[1] * unit,
        return_angle: shares[2] * unit,
        rise_law: pick(dice),
        return_law: pick(dice),
        inflections: [None; 2],
    }))
}

fn random_series(dice: &mut Dice) -> Fourier {
    let order = 1 + (8.0 * dice.roll()) as usize;
    let coefficients = |dice: &mut Dice| {
        (0..=order).map(|k| (2.0 * dice.roll() - 1.0) * 0.02 / (1 + k * k) as f64).collect::<Vec<f64>>()
    };
    Fourier::new(coefficients(dice), coefficients(dice))
}

/// The law three times as large, turned by a radian: all roundings differ.
fn rounded_otherwise(law: &MotionLaw) -> MotionLaw {
    match law {
        MotionLaw::Fourier(series) => {
            let turned = |k: usize| {
                let (sin, cos) = (k as f64).sin_cos();
                let (a, b) = (series.a[k], series.b[k]);
                [3.0 * (a * cos - b * sin), 3.0 * (a * sin + b * cos)]
            };
            let terms: Vec<[f64; 2]> = (0..=series.order()).map(turned).collect();
            let [a, b] = [0, 1].map(|i| terms.iter().map(|term| term[i]).collect());
            MotionLaw::Fourier(Fourier::new(a, b))
        }
        MotionLaw::Cycle(cycle) => {
            let plan = *cycle.plan();
            let rise_start = (plan.rise_start + 1.0).rem_euclid(TAU);
            MotionLaw::Cycle(Cycle::new(CyclePlan { stroke: 3.0 * plan.stroke, rise_start, ..plan }))
        }
        _ => unreachable!("all random laws are series or cycles"),
    }
}

/// c and b of a random oscillator with m = 1; a beating one has an almost resonant harmonic.
fn random_oscillator(dice: &mut Dice, case: Case, series: &Fourier, w: f64) -> [f64; 2] {
    let omega = w.abs() * dice.magnitude(0.3, 100.0);
    let ratio = if dice.roll() < 0.2 { 0.0 } else { dice.magnitude(1e-4, 5.0) };
    if case != Case::Beat {
        return [omega * omega, 2.0 * ratio * omega];
    }
    let k = 1.0 + (series.order() as f64 * dice.roll()).floor();
    let beside = dice.magnitude(0.006, 0.1) * if dice.roll() < 0.5 { 1.0 } else { -1.0 };
    let omega = w.abs() * k * (1.0 + beside);
    [omega * omega, 2.0 * omega * dice.magnitude(1e-5, 1e-2)]
}

/// The true and the estimated error of a random oscillator on a random law over 1 to 50 turns; None if no rule is accurate over the
/// step. The truth: [`Truth`] for a series at constant speed, else pieces at the finest tolerance with other roundings.
fn errors_of_a_run(dice: &mut Dice, case: Case) -> Option<[f64; 2]> {
    let series = random_series(dice);
    let law = match case {
        Case::RampOfCycle | Case::Cycle => random_cycle(dice),
        _ => MotionLaw::Fourier(series.clone()),
    };
    let w = dice.magnitude(0.1, 1000.0) * if dice.roll() < 0.5 { 1.0 } else { -1.0 };
    let [c, b] = random_oscillator(dice, case, &series, w);
    let oscillator = Equation::new([1.0, c, b]);
    let period = TAU / w.abs();
    let stop = dice.magnitude(1.0, if case == Case::Beat { 3.0 } else { 50.0 }) * period;
    let step = period / dice.magnitude(30.0, 1000.0);
    let tolerance = dice.magnitude(1e-10, 1e-3);
    let phi = dice.roll();
    let ramped = matches!(case, Case::RampOfSeries | Case::RampOfCycle);
    let a = if ramped { w / stop * (2.0 * dice.roll() - 1.0) } else { 0.0 };
    let exact = Truth { series: &series, b, c, phi, w };
    let whole = AngleMotion::uniform(0.0, phi, w);
    let other = rounded_otherwise(&law);
    let mut finest = Response::new(oscillator, &other, FINEST_TOLERANCE);
    let mut tested = Response::new(oscillator, &law, tolerance);
    let (mut state, mut expected) = ([0.0; 2], [0.0; 2]);
    match case {
        Case::Closed | Case::Beat => tested.restart(&law, &whole, 0.0, f64::INFINITY, state).unwrap(),
        Case::Cycle => {
            tested.restart(&law, &whole, 0.0, f64::INFINITY, state).unwrap();
            finest.restart(&other, &AngleMotion::uniform(0.0, phi + 1.0, w), 0.0, f64::INFINITY, expected).unwrap();
        }
        Case::Pieces => restart_in_pieces(&mut tested, &law, &whole, 0.0, state),
        _ => {}
    }
    let (mut error, mut largest) = (0.0f64, 0.0f64);
    let steps = (stop / step) as u32;
    for i in 0..steps {
        let (time, end) = (f64::from(i) * step, f64::from(i + 1) * step);
        let mut moved = AngleMotion::uniform(time, whole.at(time).reduced, w);
        if ramped {
            let coefficients = [phi + (w + 0.5 * a * time) * time, w + a * time, a];
            moved.coefficients[..3].copy_from_slice(&coefficients);
            moved.degree = 2;
        }
        state = match case {
            Case::Closed | Case::Beat | Case::Pieces | Case::Cycle => tested.q_at(&law, end).unwrap(),
            Case::Hermite | Case::RampOfSeries => {
                tested.motion = moved;
                let mut now = Instant { time, q: state.into(), ..Instant::default() };
                tested.by_quadrature(&law, end, &mut now)?;
                now.q.array()
            }
            Case::RampOfCycle => {
                tested.restart(&law, &moved, time, end, state).unwrap();
                tested.q_at(&law, end).unwrap()
            }
        };
        if ramped {
            moved.coefficients[0] += 1.0;
            finest.restart(&other, &moved, time, end, expected.map(|x| 3.0 * x)).unwrap();
            expected = finest.q_at(&other, end).unwrap().map(|x| x / 3.0);
        } else if case == Case::Cycle {
            expected = finest.q_at(&other, end).unwrap().map(|x| x / 3.0);
        } else if i % (steps / 100).max(1) == 0 {
            expected[0] = exact.at(end);
        } else {
            continue;
        }
        largest = largest.max(expected[0].abs());
        error = error.max((state[0] - expected[0]).abs());
    }
    Some([error / largest, tested.error(f64::from(steps) * step)])
}

fn estimates_are_honest(case: Case, count: usize) {
    let mut dice = Dice(20261121);
    let runs: Vec<[f64; 2]> =
        std::iter::repeat_with(|| errors_of_a_run(&mut dice, case)).flatten().take(count).collect();
    let below = runs.iter().filter(|[error, estimate]| error <= estimate).count();
    let mut ratios: Vec<f64> = runs.iter().map(|[error, estimate]| estimate / error).collect();
    ratios.sort_by(f64::total_cmp);
    let median = ratios[runs.len() / 2];
    println!("{case:?}: {below} of {} below, median {median:.1}, least {:.2}", runs.len(), ratios[0]);
    assert!(below * 100 >= 99 * runs.len(), "{case:?}: {below} of {}", runs.len());
    assert!(median <= 100.0, "{case:?}: median {median}");
}

#[test]
fn the_estimate_of_the_closed_form_is_honest() {
    estimates_are_honest(Case::Closed, 600);
    estimates_are_honest(Case::Beat, 200);
}

#[test]
fn the_estimates_of_leaps_are_honest() {
    estimates_are_honest(Case::Hermite, 200);
    estimates_are_honest(Case::RampOfSeries, 200);
}

#[test]
fn the_estimates_of_cycles_are_honest() {
    estimates_are_honest(Case::Cycle, 200);
    estimates_are_honest(Case::RampOfCycle, 200);
}

#[test]
fn the_estimates_of_pieces_are_honest() {
    estimates_are_honest(Case::Pieces, 200);
}

/// The true and the estimated error of a cycle from rest at this speed, angle and natural frequency. The truth: q at some times,
/// with 34 digits, −ẍ times the impulse response by Gauss's rule on cells of a radian.
fn error_and_estimate(plan: CyclePlan, motion: [f64; 3], table: bool, reference: &[(f64, f64)]) -> [f64; 2] {
    let [w, phi, omega] = motion;
    let law = Arc::new(MotionLaw::Cycle(Cycle::new(plan)));
    let mut response = Response::new(Equation::new([1.0, omega * omega, 0.0]), &law, FINEST_TOLERANCE);
    if table {
        response.tabulate(None, &law, &DriveMode::Constant { w, phi_start: phi });
    }
    response.restart(&law, &AngleMotion::uniform(0.0, phi, w), 0.0, f64::INFINITY, [0.0; 2]).unwrap();
    assert_eq!(response.is_on_table(), table);
    let largest = reference.iter().fold(0.0, |largest: f64, (_, q)| largest.max(q.abs()));
    let errors = reference.iter().map(|&(time, q)| (response.q_at(&law, time).unwrap()[0] - q).abs() / largest);
    let error = errors.fold(0.0, f64::max);
    [error, response.error(reference[reference.len() - 1].0)]
}

fn simple_sines(rise_angle: f64) -> CyclePlan {
    CyclePlan {
        stroke: 0.02,
        lower: 0.0,
        rise_start: 0.5,
        rise_angle,
        upper_dwell: 0.2,
        return_angle: 2.0,
        rise_law: StandardLaw::SimpleSine,
        return_law: StandardLaw::SimpleSine,
        inflections: [None; 2],
    }
}

#[test]
fn a_steep_segment_does_not_hide_the_errors_of_another() {
    let (rise_law, return_law) = (StandardLaw::Polynomial4567, StandardLaw::Polynomial4567);
    let inflections = [Some(0.99), None];
    let plan = CyclePlan { return_angle: 3.0, rise_law, return_law, inflections, ..simple_sines(0.001) };
    // Within the return.
    let reference = [
        (0.25, 1.5636697204990926e-06),
        (0.5, 1.8349414923184644e-06),
        (0.75, -1.3239313567196198e-07),
        (1.0, -1.937768814677821e-06),
        (1.25, -1.3807371853836859e-06),
    ];
    let [error, estimate] = error_and_estimate(plan, [2.0, 0.73, 180.0], false, &reference);
    assert!(error <= estimate && estimate <= 1e-12, "{error:e}, estimate {estimate:e}");
}

#[test]
fn jumps_of_the_acceleration_are_not_late() {
    let reference = [
        (0.03125, -0.009404601161392264),
        (0.0625, 0.026242574004379775),
        (0.125, -0.025234307523351582),
        (0.25, 0.012503345740988913),
        (0.375, 0.06285603773545693),
    ];
    let [error, estimate] = error_and_estimate(simple_sines(0.05), [30.0, 0.1, 60.0], false, &reference);
    assert!(error <= estimate && estimate <= 1e-12, "{error:e}, estimate {estimate:e}");
}

#[test]
fn the_first_piece_has_an_estimate_too() {
    let plan = CyclePlan { rise_law: StandardLaw::Polynomial4567, ..simple_sines(0.25) };
    let [error, estimate] = error_and_estimate(plan, [30.0, 0.1, 60.0], false, &[(0.015625, -0.0019175684532447578)]);
    assert!(error <= estimate && 0.0 < estimate && estimate <= 1e-12, "{error:e}, estimate {estimate:e}");
}

#[test]
fn roundings_of_angles_keep_no_speed_in_a_table() {
    let plan = CyclePlan { rise_start: 5.9, inflections: [Some(0.01), None], ..simple_sines(0.008) };
    let reference = [
        (0.5, 0.0026871720653916117),
        (1.0, 0.021473639944253727),
        (1.5, -0.016108929961278429),
        (2.0, -0.023752641198897435),
        (3.0, 0.022340193203499641),
        (4.0, 0.0015030253878843646),
    ];
    let [error, estimate] = error_and_estimate(plan, [-2.0, 1.0, 3.0], true, &reference);
    assert!(error <= estimate && estimate <= 1e-12, "{error:e}, estimate {estimate:e}");
}
