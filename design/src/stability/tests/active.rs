//! Damping that is negative over a part of the turn, against an independent integration (DOP853 of SciPy at 1e-13, and
//! Brent's method for boundaries, critical damping and its place).

use super::*;

/// m(φ) q̈ + b(φ) q̇ + c(φ) q = 0.
fn damped(m: Fourier, b: Fourier, c: Fourier) -> PeriodicOscillator {
    let reach = 2.0 / m.order().max(b.order()).max(c.order()) as f64;
    let value = |series: &Fourier, phi: f64| series.at(phi).0[0];
    let terms =
        move |_: usize, phi: f64| Terms { m: value(&m, phi), b: value(&b, phi), c: value(&c, phi), ..Terms::default() };
    // Pieces of a turn in which a mass that varies this little is smooth.
    oscillator(Box::new(terms), 0.5 * reach, false)
}

fn fluctuation(a: &[f64], b: &[f64]) -> Fourier {
    Fourier::new([&[0.0], a].concat(), [&[0.0], b].concat())
}

struct Case {
    oscillator: PeriodicOscillator,
    theta: f64,
    /// Floquet multipliers at η = 1, the larger one first.
    multipliers: [f64; 2],
    /// Of the orders j = ½, 1, 3/2 both boundaries at θ = 0, θ* and where.
    orders: [[f64; 4]; 3],
}

fn cases() -> [Case; 4] {
    let varied = || series(&[0.3], &[]);
    [
        Case {
            oscillator: damped(series(&[], &[]), fluctuation(&[0.0417, 0.0044], &[]), varied()),
            theta: 0.0,
            multipliers: [1.05324555, 0.94944621],
            orders: [
                [1.8460386168433607, 2.1484091320875383, 0.07498058431148338, 1.99162937],
                [0.9811160710815123, 1.003572886230849, 0.01126474183817862, 0.99230389],
                [0.6607795085139879, 0.6636580548381218, 0.0021620718943776993, 0.66221988],
            ],
        },
        Case {
            oscillator: damped(series(&[], &[]), fluctuation(&[], &[0.1]), varied()),
            theta: 0.0,
            multipliers: [1.03008231, 0.97079621],
            orders: [
                [1.8948251020308569, 2.0951920755361035, 0.050140950298206595, 1.9924792],
                [0.9865778360183984, 1.0016531718962107, 0.007548952419157382, 0.99408658],
                [0.6618680446905587, 0.6637696043473655, 0.0014263967503815086, 0.66281812],
            ],
        },
        // ∫ b/m dφ / ∫ 1/m dφ = 0.010435607626104, though the mean of b is 0.
        Case {
            oscillator: damped(series(&[0.4], &[]), fluctuation(&[-0.05], &[0.0, 0.2]), series(&[0.3], &[0.0, 0.1])),
            theta: 0.005217803813052,
            multipliers: [1.37724671, 0.67595562],
            orders: [
                [1.9740874052026756, 2.073392078704006, 0.026852822529416478, 2.0228514],
                [0.9517636153388607, 1.0666079674489075, 0.052227642952765135, 1.00705487],
                [0.6651501262516595, 0.6737097154850316, 0.005924505327181886, 0.66940244],
            ],
        },
        Case {
            oscillator: damped(series(&[], &[]), fluctuation(&[0.0, 0.5], &[0.8]), varied()),
            theta: 0.0,
            multipliers: [2.14336216, 0.46655671],
            orders: [
                [1.7258536346501836, 2.220311397260177, 0.12657296192649475, 1.95487242],
                [0.8268316848202133, 1.0835966402019963, 0.1257274164820499, 0.94637757],
                [0.596151529650824, 0.640985414565954, 0.033898624141558566, 0.61859153],
            ],
        },
    ]
}

#[test]
fn a_damping_of_mean_zero_makes_instabilities() {
    for (i, case) in cases().iter().enumerate() {
        let system = System::new(&case.oscillator).unwrap();
        assert!((system.damping_ratio() - case.theta).abs() < 1e-14, "{i}: {}", system.damping_ratio());
        let found = multipliers(&system.followed(1.0, 2.0 * case.theta).unwrap());
        for ([re, im], expected) in found.into_iter().zip(case.multipliers) {
            assert!((re - expected).abs() < 1e-8 && im == 0.0, "{i}: {re} {im} {expected}");
        }
        for ((tongue, apex), [low, high, theta, at]) in tongues(&system, 3).into_iter().zip(case.orders) {
            let [found_low, found_high] = tongue.undamped().unwrap();
            assert!((found_low - low).abs() < 1e-9 && (found_high - high).abs() < 1e-9, "{i}: {tongue:?} {low} {high}");
            let apex = apex.unwrap();
            assert!((apex.theta / theta - 1.0).abs() < 1e-7 && (apex.eta - at).abs() < 1e-5, "{i}: {apex:?} {theta}");
        }
    }
}

#[test]
fn a_damping_of_mean_zero_neither_damps_nor_ends_the_study() {
    let [case, ..] = cases();
    // The mean of the first comes out as −1.3e-17, that of the second as more than 0.
    for oscillator in [case.oscillator, cases().into_iter().nth(1).unwrap().oscillator] {
        let options = Options { speeds: vec![1.0, 1.5], ..Options::default() };
        let report = study(["mean_zero", "ParametricDrive"], &oscillator, &options, &|_| {}).unwrap();
        assert_eq!(report.oscillator.damping_ratio, 0.0);
        assert!(!report.eigenproblem.incomplete && report.eigenproblem.lost.is_none(), "{:?}", report.eigenproblem);
        let [inside, outside] = &report.speeds[..] else { panic!("two speeds") };
        assert!(inside.order == Some(1.0) && inside.radius > 1.02 && inside.critical_damping > 1e-3, "{inside:?}");
        // The product of the multipliers is 1.
        assert!(!outside.stable && (outside.radius - 1.0).abs() < 1e-12, "{outside:?}");
        assert!(report.over_damping.len() > 2 && report.over_modulation.len() > 2);
        let about = report.verdict().certainty.join("\n");
        assert!(about.contains("negative over a part of the turn"), "{about}");
    }
}

#[test]
fn a_damping_that_feeds_all_motions_is_refused() {
    // The mirror image of the third case in time: ∫ b/m dφ < 0.
    let oscillator = damped(series(&[0.4], &[]), fluctuation(&[0.05], &[0.0, -0.2]), series(&[0.3], &[]));
    let fault = System::new(&oscillator).err().unwrap().to_string();
    assert!(fault.contains("free motions grow at every speed") && fault.contains("-0.0104356"), "{fault}");
}

#[test]
fn a_damping_that_is_nowhere_negative_is_scaled_as_a_whole() {
    let oscillator = damped(series(&[], &[]), series(&[0.9], &[]).scaled(0.02), series(&[0.3], &[]));
    let system = System::new(&oscillator).unwrap();
    assert!(!system.active && (system.damping_ratio() - 0.01).abs() < 1e-15);
}
