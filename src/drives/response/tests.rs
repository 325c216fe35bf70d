//! The two courses against each other; the drives' tests compare with independent numbers.

use super::*;

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
        let mut closed = Response::new(Oscillator::of_mass(1.0, c, b), &law);
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
    let mut backward = Response::new(oscillator, &law);
    let mut forward = Response::new(oscillator, &mirrored);
    backward.restart(&law, &AngleMotion::uniform(0.0, -0.3, -20.0), 0.0, f64::INFINITY, [0.0; 2]).unwrap();
    forward.restart(&mirrored, &AngleMotion::uniform(0.0, 0.3, 20.0), 0.0, f64::INFINITY, [0.0; 2]).unwrap();
    assert_eq!(backward.at(&law, 3.0), forward.at(&mirrored, 3.0));
}
