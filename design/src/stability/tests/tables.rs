//! The tables of critical damping and of boundaries, as eigenvalues of Hill's truncated matrices in another program.

use super::*;

/// The numbers of that program are good to this.
const GOOD: f64 = 1e-9;

#[test]
fn critical_damping_of_the_classical_cases() {
    let one = || series(&[], &[]);
    let half = 0.3 / 2_f64.sqrt();
    // The order is twice j.
    type Case = (&'static str, PeriodicOscillator, Vec<(usize, f64)>);
    let cases: Vec<Case> = vec![
        ("ε = 0.1", mathieu(0.1), vec![(1, 0.0250009717567)]),
        (
            "ε = 0.3",
            mathieu(0.3),
            vec![(1, 0.0750251926169), (2, 0.0112763026794), (3, 0.0021575254722), (4, 0.0004574912890)],
        ),
        (
            "ε = 0.8",
            mathieu(0.8),
            vec![(1, 0.2003365253196), (2, 0.0805970466576), (3, 0.0428500697461), (4, 0.0253900953198)],
        ),
        ("mass", parametric(series(&[0.3], &[]), one()), vec![(1, 0.0754558985484), (2, 0.0)]),
        ("r₂ = 0.1", parametric(one(), series(&[0.3, 0.1], &[])), vec![(2, 0.0134187180253)]),
        ("r₂ = −0.1", parametric(one(), series(&[0.3, -0.1], &[])), vec![(2, 0.0359221212358)]),
        ("cancelling", parametric(one(), series(&[0.4, 0.08], &[])), vec![(2, 0.0005406324740)]),
        ("turned", parametric(one(), series(&[half], &[half])), vec![(2, 0.0112763026794)]),
        ("sines", parametric(one(), series(&[0.3, 0.05], &[0.2, 0.1])), vec![(2, 0.0112412067157)]),
        ("r₁, r₃", parametric(one(), series(&[0.2, 0.0, 0.2], &[])), vec![(4, 0.0133684595165)]),
        ("in phase", parametric(series(&[0.2], &[]), series(&[0.2], &[])), vec![(1, 0.0), (2, 0.0), (3, 0.0)]),
        ("in antiphase", parametric(series(&[0.2], &[]), series(&[-0.2], &[])), vec![(1, 0.0990716918946)]),
        ("HS1", shaft(&[1.0], 1.0), vec![(1, 0.1306343056928), (2, 0.0085791586717), (3, 0.0004051212668)]),
        ("HS5, 10", shaft(&HS5, 10.0), vec![(1, 0.0222766265743), (2, 0.0206637384255), (3, 0.0102158656215)]),
        ("HS5, 3", shaft(&HS5, 3.0), vec![(1, 0.0040084696272), (2, 0.0441512332166), (3, 0.0265081529055)]),
    ];
    for (name, oscillator, expected) in cases {
        let orders = expected.iter().map(|(n, _)| *n).max().unwrap();
        let found = critical(&oscillator, orders);
        for (n, expected) in expected {
            let found = found[n - 1];
            assert!((found - expected).abs() < GOOD, "{name}, order {n}: {found} instead of {expected}");
        }
    }
}

#[test]
fn critical_damping_of_parallel_cranks() {
    // σ; one crank, j = 1, 2, 3; two cranks, j = 2.
    let table = [
        (0.01, [0.044119120912, 0.038234747680, 0.033755821288], 0.036510299141),
        (0.02, [0.059611854532, 0.049376085556, 0.042126876646], 0.045641103979),
        (0.05, [0.086551539743, 0.066435887378, 0.053794266428], 0.056761593034),
        (0.1, [0.111832122452, 0.080089987210, 0.062169925419], 0.061601047098),
        (0.2, [0.140247555585, 0.093071157495, 0.069353857623], 0.060588268681),
        (0.3, [0.157425530576, 0.099837780543, 0.072793175448], 0.056758840876),
        (0.5, [0.178427927233, 0.107113801703, 0.076247306125], 0.048958423900),
        (1.0, [0.203469196797, 0.114483921443, 0.079468342263], 0.035518043499),
        (2.0, [0.222367023243, 0.119189599558, 0.081360916578], 0.022701937920),
        (5.0, [0.237630434830, 0.122495004894, 0.082601783533], 0.010868495642),
        (10.0, [0.243718333464, 0.123696469086, 0.083032225791], 0.005813877568),
    ];
    for (sigma, single, double) in table {
        let scene = crank(sigma, false);
        let found = critical(&scene, 3);
        let two = crank(sigma, true);
        let system = System::new(&two).unwrap();
        assert_eq!(system.parts, 4, "two cranks at a right angle repeat themselves four times in a turn");
        let of_two = tongues(&system, 1)[0].1.unwrap().theta;
        assert!((of_two - double).abs() < GOOD, "σ = {sigma}, double: {of_two}");
        // The classical bounds are closed forms in ζ; ζ (1 − ζ)/4 is that of two cranks, whose r₂ is zero.
        let zeta = ((1.0 + sigma).sqrt() - sigma.sqrt()).powi(2);
        let closed = [(1.0 - zeta) / 4.0, (1.0 - zeta * zeta) / 8.0, (1.0 - zeta) * zeta * zeta / 4.0];
        let bounds = System::new(&scene).unwrap().printed();
        for n in 0..3 {
            assert!((found[n] - single[n]).abs() < GOOD, "σ = {sigma}, j = {}: {}", n + 1, found[n]);
            let bound = bounds.bounds(2 * (n + 1)).three_term;
            assert!((bound - closed[n]).abs() < GOOD, "σ = {sigma}, j = {}: {bound}", n + 1);
        }
        let bound = system.printed().bounds(4).three_term;
        assert!((bound - 0.25 * zeta * (1.0 - zeta)).abs() < GOOD, "σ = {sigma}, double: {bound}");
    }
}

#[test]
fn boundaries_of_the_stability_map() {
    // Mathieu's equation with ε = 0.3: order and θ, η at the two boundaries.
    let table = [
        (1, 0.0, [1.8475591044955, 2.1469989059395]),
        (2, 0.0, [0.9812738941999, 1.0037097396049]),
        (3, 0.0, [0.6608665764887, 0.6637376211669]),
        (4, 0.0, [0.4966861831225, 0.4971432424490]),
        (1, 0.02, [1.8525754991362, 2.1411794787163]),
        (1, 0.05, [1.8831440170837, 2.1063923779291]),
    ];
    let scene = mathieu(0.3);
    let system = System::new(&scene).unwrap();
    let all = tongues(&system, 4);
    for (n, theta, expected) in table {
        let (tongue, _) = &all[n - 1];
        let found = tongue.interval(&system, theta).unwrap();
        assert!((0..2).all(|k| (found[k] - expected[k]).abs() < GOOD), "{n}, {theta}: {found:?}");
    }
    for theta in [0.02, 0.05] {
        let left = all.iter().filter(|(tongue, _)| tongue.interval(&system, theta).is_some());
        assert_eq!(left.count(), 1, "the others have vanished");
    }
}
