//! Order, smoothness and bounds of the spline, faults of tables.

use super::*;

/// A smooth periodic law, exp(sin φ), and its derivatives.
fn smooth(phi: f64) -> [f64; 5] {
    let (s, c) = phi.sin_cos();
    let e = s.exp();
    [
        e,
        c * e,
        (c * c - s) * e,
        (c * c - 3.0 * s - 1.0) * c * e,
        (c.powi(4) - 6.0 * c * c * s - 4.0 * c * c + 3.0 * s * s + s) * e,
    ]
}

/// Points of the smooth law at unequal distances: n over the turn, the widest twice the narrowest.
fn points(n: usize, start: f64) -> Points {
    let angle = |i: usize| {
        let z = i as f64 / n as f64;
        start + TAU * z + 0.33 * (TAU * z).sin()
    };
    let angles: Vec<f64> = (0..=n).map(angle).collect();
    let lifts = angles.iter().map(|&phi| smooth(phi)[0]).collect();
    Points { angles, lifts }
}

/// The largest errors of U … U⁗ over the turn.
fn errors(table: &Table) -> [f64; 5] {
    let mut errors = [0.0_f64; 5];
    for i in 0..5000 {
        let phi = -TAU + 2.0 * TAU * f64::from(i) / 5000.0;
        let u = table.at_in(table.segment(phi, true), phi).0;
        let exact = smooth(phi);
        for n in 0..5 {
            errors[n] = errors[n].max((u[n] - exact[n]).abs());
        }
    }
    errors
}

#[test]
fn a_smooth_law_is_met_with_order_six() {
    let coarse = errors(&Table::new(points(48, 0.0)).unwrap());
    let fine = errors(&Table::new(points(96, 0.0)).unwrap());
    for n in 0..5 {
        let order = (coarse[n] / fine[n]).log2();
        assert!(order > 5.7 - n as f64 && order < 6.6 - n as f64, "derivative {n}: order {order}, {fine:?}");
    }
}

#[test]
fn the_spline_meets_its_points_and_is_smooth_there_to_the_fourth_derivative() {
    for start in [0.0, -3.0, 5.0] {
        let points = points(30, start);
        let table = Table::new(points.clone()).unwrap();
        let knots = table.breakpoints();
        assert!(knots.len() == 30 && knots.windows(2).all(|w| w[0] < w[1]));
        assert!(knots[0] >= 0.0 && knots[29] < TAU);
        for (&phi, &lift) in points.angles.iter().zip(&points.lifts) {
            let left = table.at_in(table.segment(phi, false), phi).0;
            let right = table.at_in(table.segment(phi, true), phi).0;
            assert!((right[0] - lift).abs() < 1e-14);
            for n in 0..5 {
                assert!((left[n] - right[n]).abs() < 1e-13 * 30.0_f64.powi(n as i32), "at {phi}, order {n}");
            }
        }
    }
}

#[test]
fn four_points_of_a_cosine_by_hand() {
    // U is even about 0 (U′ = U‴ = 0) and odd about π/2 (U = U″ = U⁗ = 0); over ξ = φ/(π/2) that leaves
    // U = 1 − (20 ξ² − 5 ξ⁴ + ξ⁵)/16.
    let quarter = 0.25 * TAU;
    let angles = (0..4).map(|i| f64::from(i) * quarter).collect();
    let table = Table::new(Points { angles, lifts: vec![1.0, 0.0, -1.0, 0.0] }).unwrap();
    let at = |phi: f64| table.at_in(table.segment(phi, true), phi).0;
    for xi in [0.0_f64, 0.1, 0.5, 0.9, 1.0] {
        let u = 1.0 - (20.0 * xi.powi(2) - 5.0 * xi.powi(4) + xi.powi(5)) / 16.0;
        for (phi, sign) in [(xi, 1.0), (-xi, 1.0), (2.0 - xi, -1.0), (xi - 2.0, -1.0)] {
            assert!((at(phi * quarter)[0] - sign * u).abs() < 1e-15, "{phi}");
        }
    }
}

#[test]
fn bounds_hold_and_are_not_far_off() {
    let table = Table::new(points(20, 0.0)).unwrap();
    let mut peaks = [0.0_f64; 5];
    for i in 0..20_000 {
        let phi = TAU * f64::from(i) / 20_000.0;
        let segment = table.segment(phi, true);
        for (n, u) in table.at_in(segment, phi).0.into_iter().enumerate() {
            assert!(u.abs() <= table.bound_in(segment, n) && u.abs() <= table.bound(n), "{phi} {n}");
            peaks[n] = peaks[n].max(u.abs());
        }
    }
    for (n, peak) in peaks.into_iter().enumerate() {
        // The hull of a parabola, U‴ of the widest piece, reaches beyond it by part of its bend.
        assert!(table.bound(n) < 1.2 * peak, "order {n}: {} for {peak}", table.bound(n));
    }
}

#[test]
fn neighbours_at_very_unequal_distances_do_no_harm() {
    let mut points = points(48, 0.0);
    // The second point moves to just after the first one.
    points.angles[1] = points.angles[0] + 1e-5;
    points.lifts[1] = smooth(points.angles[1])[0];
    let with = errors(&Table::new(points.clone()).unwrap());
    points.angles.remove(1);
    points.lifts.remove(1);
    let without = errors(&Table::new(points).unwrap());
    // U‴ and U⁗ between the two points are left to the roundings of their lifts.
    for n in 0..3 {
        assert!(with[n] < 1.1 * without[n], "order {n}: {with:?}, without the point {without:?}");
    }
}

#[test]
fn faults_of_a_table_are_told_with_index_and_value() {
    let table = |angles: &[f64], lifts: &[f64]| {
        Table::new(Points { angles: angles.to_vec(), lifts: lifts.to_vec() }).map(|_| ()).unwrap_err()
    };
    assert_eq!(table(&[], &[]), TableError::TooFew { points: 0 });
    assert_eq!(table(&[0.0, 1.0], &[0.0]), TableError::Lengths { angles: 2, lifts: 1 });
    assert!(matches!(table(&[0.0, 1.0], &[0.0, f64::NAN]), TableError::OutOfRange { index: 1, .. }));
    assert_eq!(
        table(&[0.0, 2.0, 2.0, 4.0], &[0.0; 4]),
        TableError::NotAscending { index: 2, previous: 2.0, angle: 2.0 }
    );
    assert_eq!(table(&[0.0, 2.0, 4.0, 7.0], &[0.0; 4]), TableError::TooLong { index: 3, span: 7.0 });
    assert_eq!(
        table(&[0.0, 1.5, 3.0, 4.5, TAU], &[0.0, 1.0, 2.0, 1.0, 0.1]),
        TableError::NotPeriodic { index: 4, first: 0.0, last: 0.1 }
    );
    assert_eq!(table(&[0.0, 2.0, 4.0, TAU], &[0.0, 1.0, 2.0, 0.0]), TableError::TooFew { points: 3 });
    let open = table(&[0.0, 1.0, 2.0, 3.0], &[0.0, 1.0, 2.0, 1.0]);
    assert!(matches!(open, TableError::NotClosed { index: 3, .. }));
    assert_eq!(open.index(), Some(3));
}

#[test]
fn given_derivatives_are_met_on_either_side_of_a_point() {
    // A parabola and a cubic between four points are polynomials of degree 5 too, and U″ jumps where they meet.
    let jump = |phi: f64| if phi < 3.0 { [phi * phi, 2.0 * phi, 2.0] } else { cubic(phi) };
    fn cubic(phi: f64) -> [f64; 3] {
        // From U = 9, U′ = 6 at 3 back to U = U′ = 0 at 2π.
        let (h, x) = (TAU - 3.0, phi - 3.0);
        let (b, c) = (-(27.0 + 12.0 * h) / (h * h), (18.0 + 6.0 * h) / h.powi(3));
        [9.0 + 6.0 * x + b * x * x + c * x.powi(3), 6.0 + 2.0 * b * x + 3.0 * c * x * x, 2.0 * b + 6.0 * c * x]
    }
    let angles = vec![0.0, 1.0, 3.0, 5.0];
    let lifts = angles.iter().map(|phi| jump(*phi)[0]).collect();
    let mut bends: Vec<Bend> =
        angles.iter().map(|phi| Bend { slope: jump(*phi)[1], before: jump(*phi)[2], behind: jump(*phi)[2] }).collect();
    (bends[0].before, bends[2].before) = (cubic(TAU)[2], 2.0);
    let points = Points { angles, lifts };
    let table = Table::bent(points.clone(), bends.clone()).unwrap();
    for i in 0..100 {
        let phi = TAU * f64::from(i) / 100.0;
        let u = table.at_in(table.segment(phi, true), phi).0;
        assert!((0..3).all(|n| (u[n] - jump(phi)[n]).abs() < 1e-12), "{phi}: {u:?}");
        assert!(u[2].abs() <= table.bound(2));
    }
    let curvature = |forward: bool| table.at_in(table.segment(3.0, forward), 3.0).0[2];
    assert!((curvature(false) - 2.0).abs() < 1e-13 && (curvature(true) - cubic(3.0)[2]).abs() < 1e-13);
    let bytes = postcard::to_stdvec(&table).unwrap();
    assert_eq!(postcard::from_bytes::<Table>(&bytes).unwrap(), table);
    bends.pop();
    assert_eq!(Table::bent(points.clone(), bends.clone()), Err(TableError::Lengths { angles: 4, lifts: 3 }));
    bends.push(Bend { slope: f64::INFINITY, ..Bend::default() });
    assert!(matches!(Table::bent(points, bends), Err(TableError::OutOfRange { index: 3, .. })));
}

#[test]
fn the_scale_multiplies_all_derivatives() {
    let mut table = Table::new(points(20, 0.0)).unwrap();
    let one = table.at_in(3, 1.0).0;
    table.scale = -2.0;
    assert_eq!(table.at_in(3, 1.0).0, one.map(|u| -2.0 * u));
    assert!(table.bound(2) > 0.0);
}

#[test]
fn a_table_that_ends_far_from_its_first_point_is_read_back() {
    // A closing point shows that the last piece is as long as that.
    let points =
        Points { angles: vec![0.1, 0.3, 0.5, 0.8, 1.0, 0.1 + TAU], lifts: vec![0.0, 1e-3, 4e-3, 2e-3, 1e-3, 0.0] };
    let bends = vec![Bend::default(); 5];
    for table in [Table::new(points.clone()).unwrap(), Table::bent(points, bends).unwrap()] {
        let bytes = postcard::to_stdvec(&table).unwrap();
        assert_eq!(postcard::from_bytes::<Table>(&bytes).unwrap(), table);
    }
}

/// A polynomial 4-5-6-7 up and down over 2.4 rad, at rest elsewhere: U, U″ and the largest |U″|.
fn lobe(phi: f64) -> [f64; 2] {
    let z = (1.0 - (phi / 1.2).abs()).clamp(0.0, 1.0);
    let u = z.powi(4) * (35.0 + z * (-84.0 + z * (70.0 - 20.0 * z)));
    [u, z * z * (420.0 + z * (-1680.0 + z * (2100.0 - 840.0 * z))) / 1.44]
}

#[test]
fn an_open_lobe_rests_beyond_its_ends_and_is_met_within() {
    let errors = |n: usize| {
        let mut angles: Vec<f64> = (0..=n).map(|i| -1.2 + 2.4 * i as f64 / n as f64).collect();
        angles.push(0.5 * TAU);
        let lifts = angles.iter().map(|phi| lobe(*phi)[0]).collect();
        let table = Table::resting(Points { angles, lifts }, &[0, n, n + 1]).unwrap();
        let at = |phi: f64| table.at_in(table.segment(phi, true), phi).0;
        for phi in [1.3, 2.0, 4.0, 5.0] {
            assert_eq!(at(phi), [0.0; 5], "{phi}");
        }
        (0..=1000).fold([0.0_f64; 2], |[u, bend], k| {
            let phi = -1.2 + 2.4 * f64::from(k) / 1000.0;
            let (found, right) = (at(phi), lobe(phi));
            [u.max((found[0] - right[0]).abs()), bend.max((found[2] - right[1]).abs())]
        })
    };
    // U″ reaches 5.22; its derivative jumps at the top.
    let [coarse, fine] = [errors(24), errors(48)];
    assert!(coarse[0] < 1e-4 && coarse[1] < 0.05 && fine[0] < 2e-6 && fine[1] < 5e-3, "{coarse:?} {fine:?}");
}
