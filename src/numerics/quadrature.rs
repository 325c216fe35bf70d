//! Gauss–Legendre quadrature with 6, 8 or 16 nodes; the rule with eight is that of the collocation ([`gauss`]).
//!
//! Source: M. Abramowitz, I. A. Stegun, *Handbook of Mathematical Functions*, section 25.4.30; the nodes are the
//! roots of the Legendre polynomials, computed to 40 digits.

use super::gauss;

/// The nodes x > 0 with their weights; the rule is symmetric about 0.
type Half = &'static [(f64, f64)];

const GAUSS_6: Half = &[
    (0.2386191860831969, 0.467913934572691),
    (0.6612093864662645, 0.3607615730481386),
    (0.932469514203152, 0.17132449237917036),
];

const GAUSS_16: Half = &[
    (0.09501250983763744, 0.1894506104550685),
    (0.2816035507792589, 0.18260341504492358),
    (0.45801677765722737, 0.16915651939500254),
    (0.6178762444026438, 0.14959598881657674),
    (0.755404408355003, 0.12462897125553388),
    (0.8656312023878318, 0.09515851168249279),
    (0.9445750230732326, 0.062253523938647894),
    (0.9894009349916499, 0.027152459411754096),
];

/// A Gauss rule with 6, 8 or 16 nodes; n nodes are exact for polynomials of degree 2n − 1.
#[derive(Clone, Copy, Debug)]
pub struct Gauss(Half);

impl Gauss {
    /// The smallest rule with at least `nodes` nodes, at most 16.
    pub fn with(nodes: usize) -> Self {
        Gauss(match nodes {
            0..=6 => GAUSS_6,
            7..=8 => &gauss::HALF,
            _ => GAUSS_16,
        })
    }

    /// The places of the first N nodes and their weights for the interval from 0 to `length`.
    pub fn nodes<const N: usize>(self, length: f64) -> [[f64; 2]; N] {
        let half = 0.5 * length;
        let mut nodes = [[0.0; 2]; N];
        let both = self.0.iter().flat_map(|(x, weight)| [(1.0 - x, weight), (1.0 + x, weight)]);
        for (node, (place, weight)) in nodes.iter_mut().zip(both) {
            *node = [half * place, half * weight];
        }
        nodes
    }

    /// ∫ f(s) ds from 0 to `length`, for several integrands at once.
    pub fn integrate<const N: usize>(self, length: f64, mut f: impl FnMut(f64) -> [f64; N]) -> [f64; N] {
        let half = 0.5 * length;
        let mut sum = [0.0; N];
        for &(x, weight) in self.0 {
            let (left, right) = (f(half * (1.0 - x)), f(half * (1.0 + x)));
            for n in 0..N {
                sum[n] += weight * (left[n] + right[n]);
            }
        }
        sum.map(|s| half * s)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn n_nodes_integrate_degree_two_n_minus_one() {
        for (nodes, degree) in [(6, 11), (8, 15), (16, 31)] {
            let [even, odd] =
                Gauss::with(nodes).integrate(2.0, |s| [(s - 1.0).powi(degree - 1), (s / 2.0).powi(degree)]);
            assert!((even - 2.0 / f64::from(degree)).abs() < 1e-15, "{nodes}: {even}");
            assert!((odd - 2.0 / f64::from(degree + 1)).abs() < 1e-15, "{nodes}: {odd}");
            let [beyond, _] = Gauss::with(nodes).integrate(2.0, |s| [(s - 1.0).powi(degree + 1), 0.0]);
            assert!((beyond - 2.0 / f64::from(degree + 2)).abs() > 1e-11, "{nodes} nodes are exact for too much");
        }
    }
}
