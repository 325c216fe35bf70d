//! The variants of a study: the product of its axes, or samples of distributions.
//!
//! Row i is a function of the plan and of i alone, so that any part of a study can be computed anywhere.
//!
//! Source of the Latin hypercube: M. D. McKay, R. J. Beckman, W. J. Conover, *Technometrics* 21 (1979) 239–245: each of n runs
//! has one of n equally probable intervals of every quantity, in random order, and a random place in it.

use statrs::function::erf::erf_inv;
use std::f64::consts::SQRT_2;

/// The most rows of a study, and the most of a Latin hypercube.
pub const MOST_ROWS: u64 = 10_000_000;

/// The distribution of a sampled quantity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Spread {
    /// Equally probable between two values.
    Uniform([f64; 2]),
    /// The same for the logarithm; both values are above zero.
    Logarithmic([f64; 2]),
    /// A normal distribution.
    Normal {
        /// Its mean.
        mean: f64,
        /// Its standard deviation.
        deviation: f64,
    },
}

impl Spread {
    /// The value below which the part u in (0, 1) of the distribution lies.
    pub fn quantile(self, u: f64) -> f64 {
        match self {
            Spread::Uniform([from, to]) => from + u * (to - from),
            Spread::Logarithmic([from, to]) => from * (to / from).powf(u),
            Spread::Normal { mean, deviation } => mean + deviation * SQRT_2 * erf_inv(2.0 * u - 1.0),
        }
    }
}

/// The way of drawing samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sampling {
    /// Each quantity evenly over its distribution.
    LatinHypercube,
    /// Independent of each other.
    Random,
}

/// The samples of several quantities, drawn together.
#[derive(Clone, Debug, PartialEq)]
pub struct Samples {
    runs: u32,
    seed: u64,
    spreads: Vec<Spread>,
    /// For each quantity of a Latin hypercube the interval of each run.
    intervals: Vec<Vec<u32>>,
}

/// Mixes the bits of a number (SplitMix64: G. L. Steele, D. Lea, C. H. Flood, OOPSLA 2014).
fn mixed(number: u64) -> u64 {
    let mut z = number.wrapping_add(0x9E37_79B9_7F4A_7C15);
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ (z >> 31)
}

/// The random number of a run and a quantity.
fn random(seed: u64, quantity: usize, run: u64) -> u64 {
    mixed(mixed(mixed(seed) ^ quantity as u64) ^ run)
}

impl Samples {
    /// This many runs with these distributions.
    pub fn new(sampling: Sampling, runs: u32, seed: u64, spreads: Vec<Spread>) -> Self {
        let permutation = |quantity: usize| {
            let mut order: Vec<u32> = (0..runs).collect();
            for i in (1..order.len()).rev() {
                // From other random numbers than the places in the intervals.
                let other = random(!seed, quantity, i as u64);
                order.swap(i, ((u128::from(other) * (i as u128 + 1)) >> 64) as usize);
            }
            order
        };
        let intervals = match sampling {
            Sampling::LatinHypercube => (0..spreads.len()).map(permutation).collect(),
            Sampling::Random => Vec::new(),
        };
        Samples { runs, seed, spreads, intervals }
    }

    /// The number of runs.
    pub fn runs(&self) -> u32 {
        self.runs
    }

    /// The value of a quantity in a run.
    pub fn value(&self, quantity: usize, run: u32) -> f64 {
        // In (0, 1), ends excluded.
        let u = ((random(self.seed, quantity, run.into()) >> 12) as f64 + 0.5) / (1u64 << 52) as f64;
        let u = match self.intervals.get(quantity) {
            Some(intervals) => (f64::from(intervals[run as usize]) + u) / f64::from(self.runs),
            None => u,
        };
        self.spreads[quantity].quantile(u)
    }
}

/// `count` values from the first to the last, evenly or, both above zero, in equal ratios.
pub fn grid([from, to]: [f64; 2], count: usize, logarithmic: bool) -> Vec<f64> {
    let last = count.saturating_sub(1).max(1) as f64;
    let value = |i: usize| match i {
        0 => from,
        _ if i + 1 == count => to,
        _ if logarithmic => from * (to / from).powf(i as f64 / last),
        _ => from + (to - from) * (i as f64 / last),
    };
    (0..count).map(value).collect()
}

/// The place of row `row` of the product on each of the axes of these lengths: the last axis goes fastest.
pub fn places(lengths: &[u64], row: u64) -> Vec<u64> {
    let mut left = row;
    let mut places: Vec<u64> = lengths
        .iter()
        .rev()
        .map(|length| {
            let place = left % length;
            left /= length;
            place
        })
        .collect();
    places.reverse();
    places
}

/// Rows of a part: a hundred parts, none so small that files outnumber rows, none so large that its loss costs much.
pub fn rows_of_part(rows: u64) -> u64 {
    rows.div_ceil(100).clamp(16, 10_000)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn products_count_with_the_last_axis_fastest() {
        let lengths = [2, 3, 4];
        let all: Vec<Vec<u64>> = (0..24).map(|row| places(&lengths, row)).collect();
        assert_eq!(
            (&all[0][..], &all[1][..], &all[4][..], &all[23][..]),
            (&[0, 0, 0][..], &[0, 0, 1][..], &[0, 1, 0][..], &[1, 2, 3][..])
        );
        assert!(all.windows(2).all(|pair| pair[0] < pair[1]));
        assert_eq!(places(&[], 0), Vec::<u64>::new());
    }

    #[test]
    fn grids_have_their_ends() {
        assert_eq!(grid([1.0, 3.0], 5, false), [1.0, 1.5, 2.0, 2.5, 3.0]);
        let decades = grid([0.1, 10.0], 3, true);
        assert!(decades[0] == 0.1 && decades[2] == 10.0 && (decades[1] - 1.0).abs() < 1e-15);
        assert_eq!((grid([2.0, 5.0], 1, false), grid([2.0, 5.0], 0, false)), (vec![2.0], vec![]));
    }

    #[test]
    fn a_hypercube_has_one_run_in_every_interval() {
        let spreads = vec![
            Spread::Uniform([2.0, 4.0]),
            Spread::Logarithmic([0.1, 10.0]),
            Spread::Normal { mean: 1.0, deviation: 0.5 },
        ];
        let samples = Samples::new(Sampling::LatinHypercube, 1000, 7, spreads.clone());
        let parts = |quantity: usize, part: fn(f64) -> f64| {
            let mut found: Vec<usize> =
                (0..1000).map(|run| (1000.0 * part(samples.value(quantity, run))) as usize).collect();
            found.sort_unstable();
            found
        };
        let all: Vec<usize> = (0..1000).collect();
        assert_eq!(parts(0, |x| (x - 2.0) / 2.0), all);
        assert_eq!(parts(1, |x| (x.log10() + 1.0) / 2.0), all);
        let mean = (0..1000).map(|run| samples.value(2, run)).sum::<f64>() / 1000.0;
        let square = (0..1000).map(|run| (samples.value(2, run) - mean).powi(2)).sum::<f64>() / 1000.0;
        assert!((mean - 1.0).abs() < 2e-3 && (square.sqrt() - 0.5).abs() < 2e-3, "{mean} {square}");
        // The quantities are not in the same order.
        let correlation = |sampling: Sampling, seed: u64| {
            let samples = Samples::new(sampling, 1000, seed, vec![Spread::Uniform([-1.0, 1.0]); 2]);
            (0..1000).map(|run| samples.value(0, run) * samples.value(1, run)).sum::<f64>() / 1000.0 * 3.0
        };
        for seed in 0..20 {
            for sampling in [Sampling::LatinHypercube, Sampling::Random] {
                // Four standard deviations.
                assert!(correlation(sampling, seed).abs() < 4.0 / 1000.0_f64.sqrt(), "{seed}");
            }
        }
        let other = Samples::new(Sampling::LatinHypercube, 1000, 8, spreads);
        assert_ne!(other.value(0, 3), samples.value(0, 3));
    }

    #[test]
    fn quantiles_are_those_of_the_normal_distribution() {
        let normal = Spread::Normal { mean: 3.0, deviation: 2.0 };
        // M. Abramowitz, I. A. Stegun, table 26.5.
        for (u, z) in
            [(0.5, 0.0), (0.975, 1.959_963_984_540_054), (0.999, 3.090_232_306_167_813), (1e-6, -4.753_424_308_822_899)]
        {
            assert!((normal.quantile(u) - 3.0 - 2.0 * z).abs() < 1e-8, "{u} {}", normal.quantile(u));
        }
        assert_eq!(Spread::Uniform([1.0, 5.0]).quantile(0.25), 2.0);
    }

    #[test]
    fn parts_are_neither_many_nor_large() {
        assert_eq!([1, 1600, 10_000, 1_000_000, MOST_ROWS].map(rows_of_part), [16, 16, 100, 10_000, 10_000]);
    }
}
