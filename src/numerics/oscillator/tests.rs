//! Against numbers computed with 60 digits from the closed forms.

use super::*;
use crate::numerics::chebyshev;
use crate::numerics::double_double::two_product;
use crate::numerics::forced::{ForcedStep, admissible_length, apply};

/// ω₀², δ, t and the four elements of the free motion: under-, critically and overdamped, from no spring at all to
/// 3·10¹² rad of phase.
#[rustfmt::skip]
const FREE: &[(f64, f64, f64, [f64; 4])] = &[
    (10000.0, 0.0, 6283.0, [0.9496003151262661, 0.0031346330169909242, -31.34633016990924, 0.9496003151262661]),
    (10000.0, 3.0, 0.37, [0.24219168123977064, -0.002163524274746817, 21.63524274746817, 0.25517282688825155]),
    (10000.0, 100.0, 0.05, [0.04042768199451279, 0.0003368973499542733, -3.368973499542733, -0.02695178799634186]),
    (10000.0, 100.00000010000001, 0.05, [0.040427682275260605, 0.00033689735107726455, -3.3689735107726455, -0.026951788007571774]),
    (10000.0, 99.9999999, 0.05, [0.04042768171376502, 0.0003368973488312822, -3.3689734883128217, -0.02695178798511195]),
    (10000.0, 1e9, 2.0, [0.9999900000500024, 4.999950000250025e-10, -4.999950000250024e-06, -2.4999750001250184e-15]),
    (10000.0, 1e9, 100000.0, [0.6065306597126342, 3.0326532985631786e-10, -3.0326532985631786e-06, -1.516326649281593e-15]),
    (0.0, 0.0, 3.0, [1.0, 3.0, 0.0, 1.0]),
    (0.0, 5.0, 0.3, [1.0, 0.0950212931632136, 0.0, 0.04978706836786395]),
    (1e-14, 2.0, 1000.0, [0.9999999999975007, 0.2499999999993753, -2.499999999993753e-15, -6.249999999984386e-16]),
    (1e13, 0.25, 7.0, [0.09975476972735875, -4.499596325747362e-08, 449959.63257473614, 0.09975479222534038]),
    (2.5e9, 1e-07, 6e7, [-0.000970013607803603, -4.5621424589825786e-08, 114.05356147456446, -0.0009700136077944786]),
];

/// ω₀², δ, ν, t and the q, q̇ that Re[(3 − 4i) e^(i(0.7 + νt))] causes from rest: at, near and far from resonance.
#[rustfmt::skip]
const FORCED: &[(f64, f64, f64, f64, [f64; 2])] = &[
    (10000.0, 2.0, 100.0, 0.5, [-0.0037029910396811044, 0.6959039927423883]),
    (10000.0, 0.0, 100.0, 0.5, [-0.005928217390408002, 1.0948871023561935]),
    (10000.0, 0.0, 100.00000010000001, 30.0, [0.3250730180069348, -67.58427291828069]),
    (10000.0, 0.0, 99.9999999, 60000.0, [-1039.7908732841806, -108112.38274051686]),
    (10000.0, 0.0, 100.00000000000011, 60000.0, [-1043.0311277448575, -107800.12087246984]),
    (10000.0, 1e-09, 100.00000000010002, 60000.0, [-1043.0030682131276, -107796.57433440552]),
    (10000.0, 0.0, 99.0, 0.3, [-0.007380401837022972, -0.18818535921325374]),
    (10000.0, 0.0, 98.0, 0.3, [-0.007007273452017198, -0.29042461284802784]),
    (10000.0, 150.0, 100.0, 0.1, [-5.745328322536393e-05, -0.015644025437946518]),
    (10000.0, 100.0, 99.9, 0.1, [-8.328463306126295e-05, -0.02357037896914838]),
    (1e12, 20.0, 100.0, 0.3, [-3.498052075001454e-13, 1.7924793818570487e-09]),
    (0.0001, 0.0, 100.0, 0.3, [0.0039034606332809425, -0.038601830078026166]),
    (10000.0, 10000000.0, 100.0, 0.3, [-1.9301848927751563e-09, -1.8090813248949137e-08]),
];

#[test]
fn free_motion_in_every_damping_regime() {
    for &(stiffness, damping, t, expected) in FREE {
        let m = Oscillator::new(stiffness.into(), damping.into()).free(t.into());
        let m = [m[0][0], m[0][1], m[1][0], m[1][1]];
        // If the motion oscillates, an element is as accurate as its amplitude; otherwise it is accurate by itself.
        let (envelope, rate) = ((-damping * t).exp(), stiffness.sqrt());
        let amplitude = if stiffness > damping * damping { [1.0, 1.0 / rate, rate, 1.0] } else { [0.0; 4] };
        for i in 0..4 {
            let scale = expected[i].abs() + envelope * amplitude[i];
            assert!((m[i] - expected[i]).abs() <= 2e-15 * scale, "{stiffness} {damping} {t}: {m:?} {expected:?}");
        }
    }
}

#[test]
fn a_harmonic_from_rest_on_beside_and_far_from_resonance() {
    for &(stiffness, damping, nu, t, expected) in FORCED {
        let oscillator = Oscillator::new(stiffness.into(), damping.into());
        let turned = Complex::new(3.0, -4.0);
        let response = oscillator.harmonic([turned.re, turned.im], Double::from(nu));
        let driven = |t: f64| {
            let psi = angle::reduce(two_product(nu, t) + Double::from(0.7));
            let (s, c) = psi.sin_cos();
            let [re, im] = response.steady;
            let [q, v] = response.resonant.map_or([0.0; 2], |part| oscillator.resonant(&part, c, s, t.into()));
            [re * c - im * s + q, -nu * (re * s + im * c) + v]
        };
        let start = driven(0.0);
        let free = apply(&oscillator.free(t.into()), [-start[0], -start[1]]);
        let motion = driven(t);
        let [re, im] = response.steady;
        let amplitude = re.hypot(im).max(expected[0].hypot(expected[1] / nu));
        for i in 0..2 {
            let error = (motion[i] + free[i] - expected[i]).abs() / [1.0, nu][i];
            assert!(error <= 3e-15 * amplitude, "{stiffness} {damping} {nu} {i}: {error:e} of {amplitude:e}");
        }
    }
}

#[test]
fn polynomial_forcing_at_any_stiffness() {
    // q = sin κt is prescribed and the forcing computed from it; h is one unit of the forcing's own time scale.
    let kappa: f64 = 2.0;
    for (stiffness, damping) in [
        (0.0, 0.0),
        (0.0, 3.0),
        (1e-9, 1e-3),
        (1.0, 1.0),
        (25.0, 0.1),
        (100.0, 10.0),
        (1e3, 200.0),
        (2e3, 4e4),
        (1e4, 1e9),
        (3e3, 0.0),
        (1e5, 1.0),
        (1e9, 1e5),
        (1e14, 0.0),
    ] {
        let oscillator = Oscillator::new(Double::from(stiffness), Double::from(damping));
        let exact = |t: f64| [(kappa * t).sin(), kappa * (kappa * t).cos()];
        let length = admissible_length(&oscillator, 1.0);
        let forcing = |t: f64| (stiffness - kappa * kappa) * exact(t)[0] + 2.0 * damping * exact(t)[1];
        let fit = chebyshev::fit(|x| forcing(0.5 * length * (1.0 + x)), 1e-14, 0.0);
        let step = ForcedStep::new(&oscillator, length, fit.polynomial, exact(0.0));
        for i in 0..=8 {
            let t = length * f64::from(i) / 8.0;
            let (found, expected) = (step.at(&oscillator, t), exact(t));
            for (i, (f, e)) in found.into_iter().zip(expected).enumerate() {
                // The rounding of q swings at the natural frequency and shows in q̇ as ω₀ times that.
                let tolerance = 3e-14 + if i == 1 { 1e-15 * stiffness.sqrt() } else { 0.0 };
                assert!((f - e).abs() < tolerance, "ω₀² = {stiffness}, δ = {damping}, t = {t}: {found:?} {expected:?}");
            }
        }
    }
}

#[test]
fn stiffness_does_not_shorten_the_step() {
    for rate in [1e2, 1e5, 1e9] {
        let stiff = Oscillator::new(Double::from(rate * rate), Double::from(0.0));
        assert_eq!(admissible_length(&stiff, 1.0), 1.0);
        // ω₀²/2δ = 0.5 1/s against 2δ: widely split rates.
        let split = Oscillator::new(Double::from(rate), Double::from(rate));
        assert_eq!(admissible_length(&split, 1.0), 1.0);
    }
}
