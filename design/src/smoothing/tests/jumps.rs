//! Laws whose jumps are known, smooth ones, and specks on them.

use super::*;

fn jumps_of(points: Points) -> (Vec<Jump>, Vec<Vec<WrongRow>>) {
    Rows::new(points).unwrap().jumps_and_specks()
}

/// Lifts to a hundredth of a micrometre.
fn rounded(law: &MotionLaw, count: usize, of: impl Fn(f64) -> f64) -> Points {
    let angles: Vec<f64> = (0..count).map(|i| TAU * (i as f64 + 0.37) / count as f64).collect();
    Points { lifts: angles.iter().map(|phi| (of(law.at(*phi).0[0]) * 1e8).round() * 1e-8).collect(), angles }
}

#[test]
fn jumps_of_the_second_derivative_are_found_with_their_angles() {
    // The cycle begins at 0; its motions have jumps at both ends.
    let law = law(StandardLaw::SimpleSine);
    for count in [180, 360, 720] {
        let (jumps, specks) = jumps_of(rounded(&law, count, |lift| lift));
        let found: Vec<f64> = jumps.iter().map(|jump| jump.angle.to_degrees()).collect();
        assert!(specks.is_empty() && jumps.iter().all(|jump| jump.order == 2), "{count}: {jumps:?}");
        for end in [0.0, 100.0, 160.0, 250.0] {
            let near = |angle: &&f64| (*angle - end + 180.0).rem_euclid(360.0) - 180.0;
            assert!(found.iter().any(|angle| near(&angle).abs() < 0.1), "{count}: {found:?} without {end}");
        }
        assert_eq!(found.len(), 4, "{count}: {found:?}");
    }
}

#[test]
fn a_lift_less_a_clearance_has_kinks_and_no_wrong_row() {
    let law = law(StandardLaw::Polynomial345);
    for count in [180, 360, 720] {
        let points = rounded(&law, count, |lift| (lift - 1e-3).max(0.0));
        let (jumps, specks) = jumps_of(points.clone());
        assert_eq!(jumps.iter().map(|jump| jump.order).collect::<Vec<_>>(), [1, 1], "{count}: {jumps:?}");
        for jump in jumps {
            assert!((law.at(jump.angle).0[0] - 1e-3).abs() < 1e-6, "{count}: {jump:?}");
        }
        assert_eq!((specks, found(points, Outliers::Refuse).wrong), (vec![], vec![]), "{count}");
    }
}

/// A cycle with motions of 70 … 140°, some less a clearance: exact, rounded to 1 nm … 1 µm or with noise of 0.2 … 5 µm, at equal
/// distances or not, the angles at which U″ jumps, and those of kinks.
fn case(seed: u64) -> (String, Points, [Vec<f64>; 2]) {
    let mut random = Random(104_729 * seed + 29);
    random.normal();
    let kind = StandardLaw::ALL[seed as usize % 6];
    let n = [180, 360, 720][seed as usize / 6 % 3];
    let [rise_angle, upper_dwell, return_angle] =
        [(70.0, 140.0), (10.0, 70.0), (70.0, 140.0)].map(|(a, b)| random.between(a, b).to_radians());
    let rise_start = random.between(0.0, 1.0);
    let stroke = random.between(0.005, 0.03);
    let laws = (kind, kind);
    let plan = CyclePlan {
        stroke,
        lower: 0.0,
        rise_start,
        rise_angle,
        upper_dwell,
        return_angle,
        rise_law: laws.0,
        return_law: laws.1,
        inflections: [None; 2],
    };
    let law = MotionLaw::Cycle(plan.into());
    let clearance = if random.between(0.0, 1.0) < 0.3 { random.between(0.03, 0.2) * stroke } else { 0.0 };
    let error = [0.0, 1e-9, 1e-8, 1e-7, 1e-6, 2e-7, 1e-6, 5e-6][random.between(0.0, 8.0) as usize];
    let noisy = random.between(0.0, 1.0) < 0.4;
    let jitter = if seed.is_multiple_of(4) { 0.3 } else { 0.0 };
    let angle = |i: usize| TAU * (i as f64 + 0.5 + random.between(-jitter, jitter)) / n as f64;
    let angles: Vec<f64> = (0..n).map(angle).collect();
    let lift = |phi: &f64| {
        let lift = (law.at(*phi).0[0] - clearance).max(0.0);
        let rounded = |digit: f64| (lift / digit).round() * digit;
        if error == 0.0 {
            lift
        } else if noisy {
            lift + error * random.normal()
        } else {
            rounded(error.min(1e-6))
        }
    };
    let lifts = angles.iter().map(lift).collect();
    let ends = [0.0, rise_angle, rise_angle + upper_dwell, rise_angle + upper_dwell + return_angle];
    let ends = if clearance > 0.0 { &ends[1..3] } else { &ends[..] };
    let jumps =
        if kind == StandardLaw::SimpleSine { ends.iter().map(|end| rise_start + end).collect() } else { vec![] };
    let is_in = |i: &usize| law.at(TAU * *i as f64 / 36000.0).0[0] > clearance;
    let kink = |i: usize| (is_in(&i) != is_in(&(i + 1))).then_some(TAU * (i as f64 + 0.5) / 36000.0);
    let kinks = if clearance > 0.0 { (0..36000).filter_map(kink).collect() } else { vec![] };
    let name = format!("{seed}: {} n = {n}, {clearance:.1e}, {error:e} {noisy}", kind.name());
    (name, Points { angles, lifts }, [jumps, kinks])
}

#[test]
fn jumps_and_kinks_are_found_and_smooth_laws_have_none() {
    let (mut alarms, mut wrong, mut known, mut hit) = (Vec::new(), Vec::new(), [0; 2], [0; 2]);
    for seed in 0..72 {
        let (name, points, places) = case(seed);
        let distance = TAU / points.angles.len() as f64;
        let apart = |a: f64, b: f64| ((a - b + PI).rem_euclid(TAU) - PI).abs();
        let (jumps, specks) = jumps_of(points.clone());
        for (i, places) in places.iter().enumerate() {
            let is_found =
                |place: &&f64| jumps.iter().any(|j| j.order == 2 - i && apart(j.angle, **place) < 1.6 * distance);
            known[i] += places.len();
            hit[i] += places.iter().filter(is_found).count();
        }
        let beside = |jump: &&Jump| !places.iter().flatten().any(|place| apart(jump.angle, *place) < 3.0 * distance);
        if jumps.iter().any(|jump| beside(&jump)) || !specks.is_empty() {
            alarms.push((name.clone(), jumps));
        }
        if !places[1].is_empty() {
            wrong.extend(found(points, Outliers::Refuse).wrong.into_iter().map(|row| (name.clone(), row)));
        }
    }
    println!("{hit:?} of {known:?}");
    assert!(wrong.is_empty(), "{wrong:?}");
    assert!(alarms.is_empty(), "{alarms:?}");
    assert!(4 * hit[0] >= 3 * known[0] && 20 * hit[1] >= 19 * known[1], "{hit:?} of {known:?}");
}

#[test]
fn specks_over_some_rows_are_named_row_by_row() {
    let law = law(StandardLaw::Polynomial345);
    for rows in [2, 3, 5, 8] {
        let mut points = measured(&law, 1e-6, 11);
        let first = 200;
        points.lifts[first..first + rows].iter_mut().for_each(|lift| *lift += 4e-5);
        let found: Vec<usize> = jumps_of(points).1.concat().iter().map(|row| row.index).collect();
        // Noise may add a row.
        assert!((first..first + rows).all(|row| found.contains(&row)) && found.len() <= rows + 1, "{rows}: {found:?}");
    }
}

/// Lifts (m) of whole tens of picometres at equal distances.
fn table(count: usize, lift: impl Fn(f64) -> f64) -> Points {
    let angles: Vec<f64> = (0..count).map(|i| TAU * i as f64 / count as f64).collect();
    Points { lifts: angles.iter().map(|phi| (lift(*phi) * 1e11).round() * 1e-11).collect(), angles }
}

/// A cycloid of these starts and lengths of rise and return (degrees).
fn cycloid(phi: f64, [rise, length]: [f64; 2], [back, last]: [f64; 2]) -> f64 {
    let part = |start: f64, length: f64| {
        let x = ((phi.to_degrees() - start) / length).clamp(0.0, 1.0);
        x - (TAU * x).sin() / TAU
    };
    part(rise, length) - part(back, last)
}

#[test]
fn a_right_row_beside_a_kink_is_not_wrong_and_one_that_is_off_is() {
    let law = |phi: f64| (0.01 * cycloid(phi, [40.0, 70.0], [130.0, 70.0]) - 1e-4).max(0.0);
    let points = table(180, law);
    let found = found(points, Outliers::Refuse);
    assert!(found.wrong.is_empty(), "{found:?}");
    assert!(
        found.jumps.iter().any(|jump| jump.order == 1 && (jump.angle.to_degrees() - 48.0).abs() < 2.0),
        "{found:?}"
    );
    let mut points = table(180, |phi| 0.01 * cycloid(phi, [40.0, 70.0], [130.0, 70.0]));
    for row in [24, 35, 60, 80, 120] {
        points.lifts[row] += 2e-5;
        let wrong: Vec<usize> =
            super::found(points.clone(), Outliers::Refuse).wrong.iter().map(|row| row.index).collect();
        assert_eq!(wrong, [row]);
        points.lifts[row] -= 2e-5;
    }
    let mut points = table(120, |phi| 0.01 * cycloid(phi, [30.0, 90.0], [160.0, 100.0]));
    points.lifts[7] += 5e-6;
    let wrong: Vec<usize> = super::found(points, Outliers::Refuse).wrong.iter().map(|row| row.index).collect();
    assert_eq!(wrong, [7]);
}

#[test]
fn few_rows_of_smooth_laws_have_no_jumps() {
    let bell = |phi: f64| 0.008 * (-((phi.to_degrees() - 180.0) / 22.0).powi(2)).exp();
    let motion = |phi: f64| 0.008 * cycloid(phi, [0.0, 100.0], [150.0, 100.0]);
    for points in [table(60, bell), table(60, motion), table(72, motion)] {
        let found = found(points, Outliers::Refuse);
        assert_eq!((found.jumps, found.specks), (vec![], vec![]));
    }
}

#[test]
fn jumps_that_are_certain_are_those_of_the_law() {
    for kind in StandardLaw::ALL {
        // Of 720 rows that of the law with jumps.
        let counts = if kind == StandardLaw::SimpleSine { &[180, 360, 720][..] } else { &[180, 360] };
        for &count in counts {
            for digit in [0.0, 1e-9, 1e-8] {
                let law = law(kind);
                let mut points = table(count, |phi| law.at(phi).0[0]);
                if digit > 0.0 {
                    points.lifts.iter_mut().for_each(|lift| *lift = (*lift / digit).round() * digit);
                }
                let certain = certain(&points, &found(points.clone(), Outliers::Refuse).jumps);
                let angles: Vec<f64> = certain.iter().map(|jump| jump.angle.to_degrees()).collect();
                let known: &[f64] = if kind == StandardLaw::SimpleSine { &[0.0, 100.0, 160.0, 250.0] } else { &[] };
                // Of 720 rows the last digits hide the jumps.
                let all = digit < 5e-9 || count < 720;
                assert!(
                    angles.len() <= known.len() && (!all || angles.len() == known.len()),
                    "{kind:?} {count} {digit}: {certain:?}"
                );
                let near = |angle: &f64| {
                    known.iter().any(|end| ((angle - end + 180.0).rem_euclid(360.0) - 180.0).abs() < 0.05)
                };
                assert!(angles.iter().all(near), "{kind:?} {count} {digit}: {certain:?}");
            }
        }
    }
}
