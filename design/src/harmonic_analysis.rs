//! The finite Fourier series of a table of angles and lifts; complex coefficients of any series.

use camdrive::motion::Fourier;
use camdrive::motion::table::{Points, TableError};
use nalgebra::{DMatrix, DVector};
use std::f64::consts::TAU;

/// A coefficient of a series.
pub type Complex = num_complex::Complex<f64>;

/// The coefficient of e^(ikφ) of a real function, k of either sign.
pub fn coefficient(list: &[Complex], k: i64) -> Complex {
    let value = list.get(k.unsigned_abs() as usize).copied().unwrap_or_default();
    if k < 0 { value.conj() } else { value }
}

/// Points this close to equal distances (rad) are equidistant; the rest changes a lift by 1e-9 of its slope.
const EQUIDISTANT: f64 = 1e-9;

/// Below this part of the largest pivot the points do not determine a harmonic: its coefficients would carry the roundings of
/// the lifts, enlarged ten thousand million times.
const RANK: f64 = 1e-10;

/// A Fourier series and its deviation from the points.
#[derive(Clone, Debug, PartialEq)]
pub struct HarmonicAnalysis {
    /// The series.
    pub series: Fourier,
    /// max |U(φᵢ) − lift| over the points (m).
    pub largest_residual: f64,
    /// Its root mean square (m).
    pub mean_residual: f64,
}

/// The Fourier series of K = `harmonics` that meets the points best by least squares.
///
/// Equidistant points: their discrete Fourier series, aₖ = 2/n Σ uᵢ cos kφᵢ, bₖ = 2/n Σ uᵢ sin kφᵢ. Others: least squares, each
/// point weighted by its angle, by QR. K ≤ (n − 1)/2 for n points without a closing one; at unequal distances also K ≤ π/gap,
/// because a shorter wave may swing unseen in the widest gap.
pub fn analyse(points: Points, harmonics: usize) -> Result<HarmonicAnalysis, TableError> {
    let points = points.open()?;
    let n = points.angles.len();
    let most = (n - 1) / 2;
    let too_many = |most: usize, gap: Option<f64>| TableError::TooManyHarmonics { harmonics, most, gap };
    if harmonics > most {
        return Err(too_many(most, None));
    }
    let series = if is_equidistant(&points.angles, EQUIDISTANT) {
        discrete_series(points.angles[0], &points.lifts, harmonics)
    } else {
        let around = points.angles[0] + TAU - points.angles[n - 1];
        let gap = points.angles.windows(2).fold(around, |gap, pair| gap.max(pair[1] - pair[0]));
        // Angles of five digits make a gap of 15° a little wider.
        let carried = (0.5 * TAU / gap + 1e-3).floor() as usize;
        if harmonics > carried {
            return Err(too_many(carried, Some(gap)));
        }
        least_squares(&points, harmonics).ok_or(too_many(harmonics - 1, None))?
    };
    let residual =
        |i: usize| series.at(points.angles[i] - TAU * (points.angles[i] / TAU).round()).0[0] - points.lifts[i];
    let largest_residual = (0..n).fold(0.0_f64, |largest, i| largest.max(residual(i).abs()));
    let mean_residual = ((0..n).map(|i| residual(i).powi(2)).sum::<f64>() / n as f64).sqrt();
    Ok(HarmonicAnalysis { series, largest_residual, mean_residual })
}

/// A series with coefficients of rounding size, below the last digit of the largest one, set to zero.
pub fn without_rounding(mut series: Fourier) -> Fourier {
    let largest = series.a.iter().chain(&series.b).fold(0.0_f64, |largest, c| c.abs().max(largest));
    for c in series.a.iter_mut().chain(&mut series.b).filter(|c| c.abs() < f64::EPSILON * largest) {
        *c = 0.0;
    }
    series
}

/// True if the angles divide the turn into equal parts, up to `least` (rad).
pub fn is_equidistant(angles: &[f64], least: f64) -> bool {
    let distance = TAU / angles.len() as f64;
    angles.iter().enumerate().all(|(i, phi)| (phi - angles[0] - i as f64 * distance).abs() < least)
}

/// The discrete Fourier series of lifts at φᵢ = first + 2πi/n.
pub fn discrete_series(first: f64, lifts: &[f64], harmonics: usize) -> Fourier {
    let n = lifts.len();
    let wave: Vec<[f64; 2]> = (0..n).map(|i| (TAU * i as f64 / n as f64).sin_cos().into()).collect();
    let part = |part: usize| {
        let sum = |k: usize| lifts.iter().enumerate().map(|(i, u)| u * wave[k * i % n][part]).sum::<f64>();
        (0..=harmonics).map(|k| sum(k) * if k == 0 { 1.0 } else { 2.0 } / n as f64).collect()
    };
    Fourier::new(part(1), part(0)).delayed(first)
}

/// min Σ wᵢ (U(φᵢ) − uᵢ)²; None if the points do not determine the coefficients.
fn least_squares(points: &Points, harmonics: usize) -> Option<Fourier> {
    let Points { angles, lifts } = points;
    let n = angles.len();
    let weight = |i: usize| {
        let next = if i + 1 < n { angles[i + 1] } else { angles[0] + TAU };
        let before = if i > 0 { angles[i - 1] } else { angles[n - 1] - TAU };
        (0.5 * (next - before)).sqrt()
    };
    // Columns: 1, cos φ, sin φ, cos 2φ, sin 2φ …
    let matrix = DMatrix::from_fn(n, 2 * harmonics + 1, |i, column| {
        let angle = column.div_ceil(2) as f64 * angles[i];
        weight(i) * if column % 2 == 0 && column > 0 { angle.sin() } else { angle.cos() }
    });
    let mut right = DVector::from_fn(n, |i, _| weight(i) * lifts[i]);
    let qr = matrix.qr();
    qr.q_tr_mul(&mut right);
    let r = qr.r();
    let pivots = r.diagonal().abs();
    if pivots.min() <= RANK * pivots.max() {
        return None;
    }
    let x = r.solve_upper_triangular(&right.rows(0, 2 * harmonics + 1))?;
    let a = (0..=harmonics).map(|k| x[if k == 0 { 0 } else { 2 * k - 1 }]).collect();
    let b = (0..=harmonics).map(|k| if k == 0 { 0.0 } else { x[2 * k] }).collect();
    Some(Fourier::new(a, b))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn series() -> Fourier {
        Fourier::new(vec![0.02, 0.574, -0.076, 0.0, 0.011], vec![0.0, -0.03, 0.2, 0.004, -0.007])
    }

    fn sample(series: &Fourier, angles: Vec<f64>) -> Points {
        let lifts = angles.iter().map(|&phi| series.at(phi).0[0]).collect();
        Points { angles, lifts }
    }

    #[test]
    fn the_discrete_series_of_a_finite_series_is_itself() {
        let given = series();
        for first in [0.0, -2.0, 0.3] {
            // With and without the closing point, up to the highest number of harmonics.
            for (n, closing, harmonics) in [(9, 0, 4), (24, 1, 11), (360, 1, 7)] {
                let angles = (0..n + closing).map(|i| first + TAU * i as f64 / n as f64).collect();
                let found = analyse(sample(&given, angles), harmonics).unwrap();
                for k in 0..=harmonics {
                    let expected = if k < 5 { (given.a[k], given.b[k]) } else { (0.0, 0.0) };
                    // Roundings of the sampled angles and of sums of n terms.
                    assert!((found.series.a[k] - expected.0).abs() < 2e-15, "a[{k}] of {n} points from {first}");
                    assert!((found.series.b[k] - expected.1).abs() < 2e-15, "b[{k}] of {n} points from {first}");
                }
                assert!(found.largest_residual < 2e-15 && found.mean_residual <= found.largest_residual);
            }
        }
    }

    #[test]
    fn unequal_distances_give_the_same_series_by_least_squares() {
        let given = series();
        let angles = (0..40).map(|i| f64::from(i) * TAU / 40.0 + 0.02 * f64::from(i * i % 7 - 3)).collect();
        let found = analyse(sample(&given, angles), 6).unwrap();
        for k in 0..=6 {
            let expected = if k < 5 { (given.a[k], given.b[k]) } else { (0.0, 0.0) };
            assert!((found.series.a[k] - expected.0).abs() < 1e-15, "a[{k}]");
            assert!((found.series.b[k] - expected.1).abs() < 1e-15, "b[{k}]");
        }
        assert!(found.largest_residual < 2e-15);
    }

    #[test]
    fn a_gap_carries_no_wave_shorter_than_twice_its_width() {
        // 5° on a flank and 15° elsewhere: 12 harmonics at most, though 40 points would determine 19.
        let even = [(0..24).map(|i| 5 * i).collect::<Vec<_>>(), (0..16).map(|i| 120 + 15 * i).collect()].concat();
        let angles: Vec<f64> = even.into_iter().map(|deg| f64::from(deg).to_radians()).collect();
        assert!(analyse(sample(&series(), angles.clone()), 12).unwrap().largest_residual < 1e-14);
        let error = analyse(sample(&series(), angles), 13).unwrap_err();
        assert!(
            matches!(error, TableError::TooManyHarmonics { most: 12, gap: Some(gap), .. } if (gap - TAU / 24.0).abs() < 1e-12),
            "{error:?}"
        );
    }

    #[test]
    fn the_residual_is_what_the_left_out_harmonics_carry() {
        // cos 5φ is orthogonal to the lower harmonics on 16 points, so it stays whole.
        let given = Fourier::new(vec![0.0, 1.0, 0.0, 0.0, 0.0, 0.25], vec![]);
        let angles = (0..16).map(|i| TAU * f64::from(i) / 16.0).collect();
        let found = analyse(sample(&given, angles), 4).unwrap();
        assert!((found.largest_residual - 0.25).abs() < 1e-15);
        assert!((found.mean_residual - 0.25 / f64::sqrt(2.0)).abs() < 1e-15);
    }

    #[test]
    fn too_many_harmonics_are_refused() {
        let angles = (0..12).map(|i| TAU * f64::from(i) / 12.0).collect();
        let error = analyse(sample(&series(), angles), 6).unwrap_err();
        assert_eq!(error, TableError::TooManyHarmonics { harmonics: 6, most: 5, gap: None });
    }
}
