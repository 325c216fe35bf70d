//! Tables of all standard laws by seeds, as they are measured.

use super::*;
use nalgebra::{DMatrix, DVector, SymmetricEigen};

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Spacing {
    Equal,
    Jittered,
    Graded,
    Pairs,
    Lobe,
    Quantised,
    /// Rows only every 12 … 25° in the rests.
    Coarse,
}

pub const SPACINGS: [Spacing; 7] = [
    Spacing::Equal,
    Spacing::Jittered,
    Spacing::Graded,
    Spacing::Pairs,
    Spacing::Lobe,
    Spacing::Quantised,
    Spacing::Coarse,
];

/// A table of a known law.
pub struct Case {
    pub name: String,
    pub law: MotionLaw,
    pub points: Points,
    pub sigma: f64,
}

/// 30 … 720 points, or more than `least`, with noise of 1 … 10 µm.
pub fn case(spacing: Spacing, seed: u64, least: f64) -> Case {
    let mut random = Random(7919 * seed + 1_000_003 * spacing as u64);
    random.normal();
    let kind = StandardLaw::ALL[seed as usize % 6];
    let n = (least * (720.0 / least).powf(random.between(0.0, 1.0))).round() as usize;
    let mut sigma = 1e-6 * 10_f64.powf(random.between(0.0, 1.0));
    let [rise, dwell, back] =
        [(50.0, 140.0), (0.0, 70.0), (50.0, 140.0)].map(|(a, b)| random.between(a, b).to_radians());
    let start = random.between(-3.0, 3.0);
    let plan = CyclePlan {
        stroke: random.between(0.005, 0.03),
        lower: 0.0,
        rise_start: start,
        rise_angle: rise,
        upper_dwell: dwell,
        return_angle: back,
        rise_law: kind,
        return_law: kind,
        inflections: [None; 2],
    };
    let law = MotionLaw::Cycle(plan.into());
    // Whether the cam moves within this angle.
    let moves = |phi: f64, margin: f64| {
        let x = (phi - start).rem_euclid(TAU);
        x < rise + margin || x > TAU - margin || (x - rise - dwell > -margin && x < rise + dwell + back + margin)
    };
    let even = |count: usize| (0..count).map(move |i| TAU * i as f64 / count as f64);
    let mut angles: Vec<f64> = match spacing {
        Spacing::Jittered => even(n).map(|phi| phi + random.between(-0.4, 0.4) * TAU / n as f64).collect(),
        Spacing::Pairs => {
            let base = (n as f64 * random.between(0.7, 0.95)) as usize;
            let twin = |_| {
                TAU * (random.between(0.0, base as f64).floor()) / base as f64 + 10_f64.powf(random.between(-5.8, -2.7))
            };
            even(base).chain((base..n).map(twin).collect::<Vec<_>>()).collect()
        }
        Spacing::Graded => {
            // Three to eight times as dense where the cam moves, with soft borders.
            let ratio = random.between(3.0, 8.0);
            let density = |phi: f64| {
                (0..9).map(|k| if moves(phi + 0.04 * f64::from(k - 4), 0.1) { ratio } else { 1.0 }).sum::<f64>()
            };
            let sums: Vec<f64> =
                even(20_000).scan(0.0, |sum, phi| Some(std::mem::replace(sum, *sum + density(phi)))).collect();
            let whole = sums[19_999] + density(TAU);
            even(n).map(|part| TAU * sums.partition_point(|sum| *sum < whole * part / TAU) as f64 / 20_000.0).collect()
        }
        Spacing::Coarse => {
            let step = random.between(12.0, 25.0).to_radians();
            let flank = even(3600).filter(|phi| moves(*phi, 0.05)).count() as f64 * TAU / 3600.0;
            let fine = flank / (n as f64 - ((TAU - flank) / step).round()).max(0.5 * n as f64);
            let next = |phi: &f64| {
                let reach = if moves(*phi, 0.05) { fine } else { step };
                // A rest ends with a row.
                let ahead = (1..).map(|k| phi + 1e-3 * f64::from(k)).take_while(|x| *x < phi + reach);
                let border = if moves(*phi, 0.05) { None } else { ahead.into_iter().find(|x| moves(*x, 0.05)) };
                let next = border.unwrap_or(phi + reach).max(phi + 0.3 * fine);
                (next < TAU - 0.3 * fine).then_some(next)
            };
            std::iter::successors(Some(0.0), next).collect()
        }
        _ => even(n).collect(),
    };
    angles.sort_by(f64::total_cmp);
    angles.dedup_by(|b, a| *b - *a < 2e-6);
    let mut lifts: Vec<f64> = angles.iter().map(|phi| law.at(*phi).0[0] + sigma * random.normal()).collect();
    if spacing == Spacing::Lobe {
        // The rest below the lobe is not measured.
        let rests = |phi: f64| !moves(phi, 0.05) && (phi - start).rem_euclid(TAU) > rise + dwell + back;
        angles.iter().zip(&mut lifts).filter(|(phi, _)| rests(**phi)).for_each(|(_, lift)| *lift = 0.0);
    }
    if spacing == Spacing::Quantised {
        let digit = if seed % 4 < 2 { 1e-5 } else { 2.54e-5 };
        lifts.iter_mut().for_each(|lift| *lift = (*lift / digit).round() * digit);
        sigma = sigma.hypot(digit / 12_f64.sqrt());
    }
    let name = format!("{spacing:?} {seed}: {} n = {}, {sigma:.1e} m", kind.name(), angles.len());
    Case { name, law, points: Points { angles, lifts }, sigma }
}

/// The errors of the Fourier series of the least Σ (s − y)² + λ ∫ s‴² dφ, λ by Mallows' criterion.
fn penalised_series(case: &Case) -> [f64; 3] {
    const HARMONICS: usize = 80;
    let Points { angles, lifts } = &case.points;
    let n = angles.len() as f64;
    let order = |j: usize| (j / 2 + 1) as f64;
    // cos kφ and sin kφ over k³, so that the penalty is λ times the sum of squares.
    let wave = |j: usize, phi: f64| if j.is_multiple_of(2) { (order(j) * phi).cos() } else { (order(j) * phi).sin() } / order(j).powi(3);
    let mut matrix = DMatrix::from_fn(angles.len(), 2 * HARMONICS, |i, j| wave(j, angles[i]));
    let means: Vec<f64> = matrix.column_iter().map(|column| column.sum() / n).collect();
    for (mut column, mean) in matrix.column_iter_mut().zip(&means) {
        column.add_scalar_mut(-mean);
    }
    let mean = lifts.iter().sum::<f64>() / n;
    let right = DVector::from_iterator(lifts.len(), lifts.iter().map(|lift| lift - mean));
    let eigen = SymmetricEigen::new(matrix.tr_mul(&matrix));
    let parts = eigen.eigenvectors.tr_mul(&matrix.tr_mul(&right));
    let known: Vec<(f64, f64)> = eigen.eigenvalues.iter().copied().zip(parts.iter().copied()).collect();
    let criterion = |lambda: &f64| {
        let one = |(value, part): &(f64, f64)| {
            let kept = value.max(1e-14) / (value.max(1e-14) + lambda);
            2.0 * case.sigma * case.sigma * kept - part * part / value.max(1e-14) * (1.0 - (1.0 - kept).powi(2))
        };
        known.iter().map(one).sum::<f64>()
    };
    let lambdas = (0..300).map(|k| n * (0.12 * f64::from(k) - 34.0).exp());
    let lambda = lambdas.min_by(|a, b| criterion(a).total_cmp(&criterion(b))).unwrap();
    let scaled =
        DVector::from_iterator(known.len(), known.iter().map(|(value, part)| part / (value.max(0.0) + lambda)));
    let series = &eigen.eigenvectors * scaled;
    let constant = mean - series.iter().zip(&means).map(|(b, mean)| b * mean).sum::<f64>();
    errors(&case.law, |phi| {
        let one = |(j, b): (usize, &f64)| [b * wave(j, phi), -order(j).powi(2) * b * wave(j, phi)];
        series.iter().enumerate().map(one).fold([constant, 0.0], |[u, bend], [a, b]| [u + a, bend + b])
    })
}

/// Of 6 tables of each spacing 5 meet the bars, of all 42 all but one, and none misses them by three times.
#[test]
fn tables_of_all_laws_and_spacings_lose_their_noise() {
    let mut all = Vec::new();
    for spacing in SPACINGS {
        let mut missed = [Vec::new(), Vec::new()];
        for seed in 0..6 {
            let case = case(spacing, seed, 30.0);
            let exact = case.points.angles.iter().map(|phi| case.law.at(*phi).0[0]).collect();
            let [most, ..] = of_spline(&case.law, closed(Points { lifts: exact, ..case.points.clone() }));
            let series = penalised_series(&case);
            for (noise, missed) in [Some(case.sigma), None].into_iter().zip(&mut missed) {
                let smoothed =
                    smooth(case.points.clone(), noise, Outliers::Refuse, &[]).map(|smoothed| smoothed.points);
                let own = of_spline(&case.law, smoothed.unwrap_or_else(|_| closed(case.points.clone())));
                let ratios = [own[1] / series[1] / 1.5, own[2] / series[2] / 1.5];
                let bar = own[0] / (3.0 * case.sigma + 1.5 * most);
                let worst = ratios.into_iter().fold(if spacing == Spacing::Coarse { 0.0 } else { bar }, f64::max);
                assert!(worst < 3.0, "{} {noise:?}: {ratios:?} {bar}", case.name);
                if worst > 1.0 {
                    missed.push((case.name.clone(), ratios, bar));
                }
            }
        }
        println!("{spacing:?}: {:?} {missed:.2?}", missed.each_ref().map(Vec::len));
        all.push(missed);
    }
    assert!(all.iter().flatten().all(|missed| missed.len() <= 1), "{all:?}");
    assert!([0, 1].iter().all(|i| all.iter().map(|missed| missed[*i].len()).sum::<usize>() <= 1), "{all:?}");
}

/// With the first point once more, one turn later.
fn closed(mut points: Points) -> Points {
    points.angles.push(points.angles[0] + TAU);
    points.lifts.push(points.lifts[0]);
    points
}
