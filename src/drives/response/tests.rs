//! The two courses against each other; the drives' tests compare with independent numbers.

use super::*;
use crate::drives::solver::FINEST_TOLERANCE;

fn series() -> Fourier {
    Fourier::new(vec![0.01, -0.01, 0.0012, 0.0005, -0.0002], vec![0.0, 0.0, 8e-4, -3e-4, 0.0, 1e-4])
}

fn law() -> MotionLaw {
    MotionLaw::Fourier(series())
}

/// The response in pieces where the closed form exists.
fn restart_in_pieces(r: &mut Response, law: &MotionLaw, motion: &AngleMotion, time: f64, state: [f64; 2]) {
    (r.motion, r.until, r.closed) = (*motion, f64::INFINITY, false);
    r.piece.leaves = 0;
    r.next_piece(law, Double::from(time), state).unwrap();
}

#[test]
fn pieces_and_closed_form_agree() {
    let law = law();
    let motion = AngleMotion::uniform(1.5, 0.3, 20.0);
    let period = TAU / 20.0;
    for (c, b) in [(1e5, 40.0), (400.0, 0.0), (1e5, 2000.0), (1e14, 1.0), (1e5, 1e9), (1e-6, 0.0)] {
        let mut closed = Response::new(Oscillator::of_mass(1.0, c, b), &law, FINEST_TOLERANCE);
        let mut pieces = closed.clone();
        let start = [1e-4, -0.02];
        closed.restart(&law, &motion, 2.0, f64::INFINITY, start).unwrap();
        restart_in_pieces(&mut pieces, &law, &motion, 2.0, start);
        let (mut error, mut largest) = (0.0f64, 0.0f64);
        for i in 1..=100 {
            let time = 2.0 + period * 0.037 * f64::from(i);
            let (a, b) = (closed.at(&law, time).unwrap(), pieces.at(&law, time).unwrap());
            (error, largest) = (error.max((a[0] - b[0]).abs()), largest.max(a[0].abs()));
        }
        assert!(error < 1e-13 * largest, "c = {c}, b = {b}: {error:e} of {largest:e}");
    }
}

#[test]
fn a_backward_cam_mirrors_the_sine_coefficients() {
    let minus = series().b.iter().map(|b| -b).collect();
    let (law, mirrored) = (law(), MotionLaw::Fourier(Fourier::new(series().a, minus)));
    let oscillator = Oscillator::of_mass(1.0, 1600.0, 0.0);
    let mut backward = Response::new(oscillator, &law, FINEST_TOLERANCE);
    let mut forward = Response::new(oscillator, &mirrored, FINEST_TOLERANCE);
    backward.restart(&law, &AngleMotion::uniform(0.0, -0.3, -20.0), 0.0, f64::INFINITY, [0.0; 2]).unwrap();
    forward.restart(&mirrored, &AngleMotion::uniform(0.0, 0.3, 20.0), 0.0, f64::INFINITY, [0.0; 2]).unwrap();
    assert_eq!(backward.at(&law, 3.0), forward.at(&mirrored, 3.0));
}

/// Numbers in [0, 1) from a fixed seed: the generator of Lehmer with the multiplier of Park and Miller.
struct Dice(u64);

impl Dice {
    fn roll(&mut self) -> f64 {
        self.0 = self.0 * 48271 % 2147483647;
        self.0 as f64 / 2147483647.0
    }

    /// Between `low` and `high`, of all magnitudes alike.
    fn magnitude(&mut self, low: f64, high: f64) -> f64 {
        low * (high / low).powf(self.roll())
    }
}

/// How steps are taken in [`errors_of_a_run`].
#[derive(Clone, Copy, Debug, PartialEq)]
enum Course {
    Leaps,
    Pieces,
}

/// The true and the estimated error of a random oscillator on a random law at constant speed over 1 to 50 turns; None
/// where no rule reaches over the step.
fn errors_of_a_run(dice: &mut Dice, course: Course) -> Option<[f64; 2]> {
    let order = 1 + (8.0 * dice.roll()) as usize;
    let coefficients = |dice: &mut Dice| {
        (0..=order).map(|k| (2.0 * dice.roll() - 1.0) * 0.02 / (1 + k * k) as f64).collect::<Vec<f64>>()
    };
    let law = MotionLaw::Fourier(Fourier::new(coefficients(dice), coefficients(dice)));
    let w = dice.magnitude(0.1, 1000.0) * if dice.roll() < 0.5 { 1.0 } else { -1.0 };
    let omega = w.abs() * dice.magnitude(0.3, 100.0);
    let ratio = if dice.roll() < 0.2 { 0.0 } else { dice.magnitude(1e-4, 5.0) };
    let oscillator = Oscillator::of_mass(1.0, omega * omega, 2.0 * ratio * omega);
    let period = TAU / w.abs();
    let turns = dice.magnitude(1.0, 50.0);
    let step = period / dice.magnitude(30.0, 1000.0);
    let tolerance = dice.magnitude(1e-10, 1e-3);
    let motion = AngleMotion::uniform(0.0, dice.roll(), w);
    let mut state = [0.0; 2];
    let mut truth = Response::new(oscillator, &law, tolerance);
    truth.restart(&law, &motion, 0.0, f64::INFINITY, state).unwrap();
    let mut tested = Response::new(oscillator, &law, tolerance);
    if course == Course::Pieces {
        restart_in_pieces(&mut tested, &law, &motion, 0.0, state);
    }
    let (mut error, mut largest) = (0.0f64, 0.0f64);
    let mut time = 0.0;
    for i in 1..=(turns * period / step) as u32 {
        let end = f64::from(i) * step;
        state = match course {
            Course::Pieces => tested.at(&law, end).unwrap(),
            Course::Leaps => {
                let shaft = motion.at(time);
                let moved = AngleMotion::uniform(time, shaft.reduced, w);
                tested.leap(&law, &moved, [time, end], state)?
            }
        };
        let expected = truth.at(&law, end).unwrap()[0];
        largest = largest.max(expected.abs());
        error = error.max((state[0] - expected).abs());
        time = end;
    }
    Some([error / largest, tested.error])
}

#[test]
fn the_error_is_below_its_estimate_and_not_far_below() {
    for course in [Course::Leaps, Course::Pieces] {
        let mut dice = Dice(20261121);
        let runs: Vec<[f64; 2]> =
            std::iter::repeat_with(|| errors_of_a_run(&mut dice, course)).flatten().take(240).collect();
        let below = runs.iter().filter(|[error, estimate]| error <= estimate).count();
        let mut ratios: Vec<f64> = runs.iter().map(|[error, estimate]| estimate / error).collect();
        ratios.sort_by(f64::total_cmp);
        let median = ratios[runs.len() / 2];
        assert!(below * 100 >= 99 * runs.len(), "{course:?}: {below} of {}", runs.len());
        assert!(median <= 100.0, "{course:?}: median {median}");
    }
}
