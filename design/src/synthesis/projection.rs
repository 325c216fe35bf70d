//! The point of a polyhedron nearest to the origin, to thirty digits: the dual active-set method.
//!
//! The least ½ |y|² under aᵢ·y ≤ bᵢ. At the optimum y = −Σ λᵢ aᵢ with λᵢ ≥ 0 over the rows that hold. One row after the
//! other that is exceeded is taken up; on the way the multipliers of the others change, and a row whose multiplier comes
//! to zero lets go. Each full step makes |y| larger, so that no set of rows comes back.
//!
//! Source: D. Goldfarb, A. Idnani, "A numerically stable dual method for solving strictly convex quadratic programs",
//! Math. Programming 27 (1983) 1–33, algorithm of section 3 with the unit matrix.

use super::exact::{Factors, RANK, add_multiple, dot};
use camdrive::numerics::double_double::Double;

/// What is left of a row beside others, as part of it, when it depends on them: rows of conditions at angles that differ
/// by 1e-8 are told apart to ten digits.
const DEPENDENT: f64 = 1e-22;

/// A row that holds.
struct Active {
    a: Vec<Double>,
    multiplier: Double,
}

/// The nearest point under the rows met so far.
pub struct Projection {
    y: Vec<Double>,
    active: Vec<Active>,
}

impl Projection {
    /// The origin of `n` coordinates.
    pub fn new(n: usize) -> Self {
        Projection { y: vec![Double::default(); n], active: Vec::new() }
    }

    /// The point.
    pub fn point(&self) -> &[Double] {
        &self.y
    }

    /// Takes up a row that is exceeded; whether some point keeps it together with those that hold.
    pub fn add(&mut self, a: Vec<Double>, limit: Double) -> bool {
        let mut multiplier = Double::default();
        // Each round but the last one lets a row go.
        for _ in 0..=self.active.len() {
            let rest = dot(&a, &self.y) - limit;
            if rest.hi <= 0.0 {
                break;
            }
            // a = Σ rᵢ aᵢ + z with z perpendicular to the rows that hold.
            let columns = self.active.iter().map(|row| row.a.clone()).collect();
            let parts = Factors::new(columns, a.len(), RANK).solve(&a);
            let mut z = a.clone();
            for (part, row) in parts.iter().zip(&self.active) {
                add_multiple(&mut z, -*part, &row.a);
            }
            let square = dot(&z, &z);
            let free = square.hi > DEPENDENT * DEPENDENT * dot(&a, &a).hi;
            let ratio = |i: &usize| self.active[*i].multiplier.divide(parts[*i]);
            let falling = (0..parts.len()).filter(|i| parts[*i].hi > 0.0);
            let first = falling.min_by(|i, j| ratio(i).hi.total_cmp(&ratio(j).hi));
            let full = free.then(|| rest.divide(square));
            let (step, gone) = match (full, first.map(|i| (i, ratio(&i)))) {
                (None, None) => return false,
                (Some(full), Some((i, t))) if t.hi < full.hi => (t, Some(i)),
                (Some(full), _) => (full, None),
                (None, Some((i, t))) => (t, Some(i)),
            };
            for (part, row) in parts.iter().zip(&mut self.active) {
                row.multiplier = row.multiplier - step * *part;
            }
            multiplier = multiplier + step;
            if free {
                add_multiple(&mut self.y, -step, &z);
            }
            match gone {
                Some(i) => {
                    self.active.remove(i);
                }
                None => break,
            }
        }
        if multiplier.hi > 0.0 {
            self.active.push(Active { a, multiplier });
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use super::super::exact::numbers;
    use super::*;

    #[test]
    fn the_nearest_point_of_a_wedge() {
        // x + y ≥ 2 alone: (1, 1). With x ≥ 3/2 also: (3/2, 1/2). With y ≤ 0: (2, 0), and the first x ≥ 3/2 lets go.
        let mut nearest = Projection::new(2);
        let expect = |nearest: &Projection, expected: [f64; 2]| {
            for (found, expected) in nearest.point().iter().zip(expected) {
                assert!((*found - Double::from(expected)).hi.abs() < 1e-29, "{:?}", nearest.point());
            }
        };
        assert!(nearest.add(numbers(&[-1.0, -1.0]), Double::from(-2.0)));
        expect(&nearest, [1.0, 1.0]);
        assert!(nearest.add(numbers(&[-1.0, 0.0]), Double::from(-1.5)));
        expect(&nearest, [1.5, 0.5]);
        assert!(nearest.add(numbers(&[0.0, 1.0]), Double::default()));
        expect(&nearest, [2.0, 0.0]);
        assert_eq!(nearest.active.len(), 2);
        // x ≤ 1 contradicts them.
        assert!(!nearest.add(numbers(&[1.0, 0.0]), Double::from(1.0)));
    }
}
