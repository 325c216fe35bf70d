//! Rows that are wrong among those that are not.

use super::bars::{SPACINGS, case};
use super::*;

fn wrong_in(points: Points, noise: Option<f64>) -> Vec<WrongRow> {
    Rows::new(points).unwrap().leave_out_wrong(noise, Outliers::Refuse).wrong
}

/// Where the rows tell the motion without one of them: from 120 rows on; with fewer, no clean row is named, either.
#[test]
fn a_row_that_is_wrong_by_ten_sigma_is_named_and_no_other() {
    let mut all = Vec::new();
    for spacing in SPACINGS {
        let mut missed = [Vec::new(), Vec::new()];
        for seed in 0..2 {
            for least in [30.0, 120.0] {
                let clean = case(spacing, seed, least);
                for noise in [None, Some(clean.sigma)] {
                    assert_eq!(wrong_in(clean.points.clone(), noise), [], "{} {noise:?}", clean.name);
                }
            }
            let mut case = case(spacing, seed, 120.0);
            let mut random = Random(31 * seed + 5);
            let row = (random.between(0.0, 1.0) * case.points.lifts.len() as f64) as usize;
            let error =
                10.0_f64.powf(1.0 + random.between(0.0, 1.0)) * case.sigma * if seed % 2 == 0 { 1.0 } else { -1.0 };
            case.points.lifts[row] += error;
            for (noise, missed) in [None, Some(case.sigma)].into_iter().zip(&mut missed) {
                let wrong = wrong_in(case.points.clone(), noise);
                assert!(wrong.iter().all(|wrong| wrong.index == row), "{}: {wrong:?} not {row}", case.name);
                match wrong[..] {
                    [wrong] => {
                        assert!((wrong.by - error).abs() < 6.0 * case.sigma, "{}: {wrong:?} {error:e}", case.name)
                    }
                    _ => missed.push(case.name.clone()),
                }
            }
        }
        println!("{spacing:?}: {missed:?}");
        all.extend(missed);
    }
    assert!(all.iter().all(|missed| missed.len() <= 1), "{all:?}");
}

/// Exact or rounded lifts of a cycle with motions of 8 … 140°, and their rows.
fn exact(seed: u64) -> Points {
    let mut random = Random(104_729 * seed + 17);
    random.normal();
    let kind = StandardLaw::ALL[seed as usize % 6];
    let n = (16.0 * 45_f64.powf(random.between(0.0, 1.0))).round() as usize;
    let [rise_angle, upper_dwell, return_angle] =
        [(8.0, 140.0), (0.0, 70.0), (8.0, 140.0)].map(|(a, b)| random.between(a, b).to_radians());
    let rise_start = random.between(-3.0, 3.0);
    let mut inflection = || (random.between(0.0, 1.0) < 0.5).then(|| random.between(0.2, 0.8));
    let inflections = [inflection(), inflection()];
    let stroke = random.between(0.005, 0.03);
    let laws = [kind, kind];
    let [rise_law, return_law] = laws;
    let plan = CyclePlan {
        stroke,
        lower: 0.0,
        rise_start,
        rise_angle,
        upper_dwell,
        return_angle,
        rise_law,
        return_law,
        inflections,
    };
    let law = MotionLaw::Cycle(plan.into());
    let mut place = |i: usize| i as f64 + if seed.is_multiple_of(3) { random.between(-0.4, 0.4) } else { 0.0 };
    let mut angles: Vec<f64> = (0..n).map(|i| TAU * place(i) / n as f64).collect();
    angles.sort_by(f64::total_cmp);
    let digit = [0.0, 1e-7, 1e-6, 1e-5][seed as usize / 2 % 4];
    let round = |u: f64| if digit > 0.0 { (u / digit).round() * digit } else { u };
    Points { lifts: angles.iter().map(|phi| round(law.at(*phi).0[0])).collect(), angles }
}

#[test]
fn exact_tables_have_no_wrong_row_however_short_their_motions_are() {
    // Those of 2400 in which one row is all that the table has of a motion of few degrees, and others.
    let short = [57, 68, 79, 99, 105, 219, 337, 384, 466, 477, 495, 503, 516, 794, 2150];
    for seed in short.into_iter().chain(0..30) {
        assert_eq!(wrong_in(exact(seed), None), [], "{seed}");
    }
}

/// By a hundredth of the stroke, from 100 rows on.
#[test]
fn a_wrong_row_of_an_exact_table_is_named() {
    let (mut tables, mut missed) = (0, Vec::new());
    for seed in 0..48 {
        let mut points = exact(seed);
        let n = points.lifts.len();
        if n < 100 {
            continue;
        }
        tables += 1;
        let stroke = points.lifts.iter().fold(0.0, |a: f64, u| a.max(*u));
        let row = (Random(seed).between(0.0, 1.0) * n as f64) as usize;
        points.lifts[row] += 0.01 * stroke * if seed % 2 == 0 { 1.0 } else { -1.0 };
        let wrong: Vec<usize> = wrong_in(points, None).iter().map(|row| row.index).collect();
        if wrong != [row] {
            missed.push((seed, row, wrong));
        }
    }
    assert!(tables > 20 && missed.len() * 16 <= tables, "{tables}: {missed:?}");
}

#[test]
fn an_angle_may_be_measured_twice_and_the_first_one_at_the_end_too() {
    let law = law(StandardLaw::Polynomial345);
    let mut points = measured(&law, 3e-6, 5);
    for (row, angle) in [(100, points.angles[100]), (361, TAU), (362, TAU)] {
        points.angles.insert(row, angle);
        points.lifts.insert(row, law.at(angle).0[0]);
    }
    points.lifts[362] = points.lifts[0];
    points.lifts[361] += 2e-6;
    let smoothed = smooth(points, None, Outliers::Refuse, &[]).unwrap();
    assert_eq!((smoothed.point[100], smoothed.point[101], smoothed.point[361]), (100, 100, 0));
    assert!((smoothed.noise / 3e-6 - 1.0).abs() < 0.2 && error(&law, smoothed.points) < 0.03);
}
