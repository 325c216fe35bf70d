//! Linear equations with a banded complex matrix: elimination with partial pivoting.
//!
//! Source: G. H. Golub, C. F. Van Loan, *Matrix Computations*, 4th ed., section 4.3.5.

use num_complex::Complex;

/// A complex number.
pub type Number = Complex<f64>;

/// The factors of a matrix with as many sub- as superdiagonals.
pub struct Banded {
    size: usize,
    /// Diagonals on each side.
    side: usize,
    /// Row i holds the columns i − side to i + 2 side: pivoting fills in as many again.
    rows: Vec<Vec<Number>>,
    pivots: Vec<usize>,
}

impl Banded {
    /// Factorises the matrix with these elements; None where it is singular or not finite.
    pub fn new(size: usize, side: usize, element: impl Fn(usize, usize) -> Number) -> Option<Self> {
        let row = |i: usize| {
            let column = |place: usize| (i + place).checked_sub(side).filter(|j| place <= 2 * side && *j < size);
            (0..=3 * side).map(|place| column(place).map_or(Number::ZERO, |j| element(i, j))).collect()
        };
        let mut band = Banded { size, side, rows: (0..size).map(row).collect(), pivots: Vec::with_capacity(size) };
        for k in 0..size {
            let last = (k + side).min(size - 1);
            let weight = |i: usize| band.at(i, k).norm_sqr();
            let pivot = (k..=last).max_by(|i, j| weight(*i).total_cmp(&weight(*j)))?;
            let far = (k + 2 * side).min(size - 1);
            for j in k..=far {
                let (a, b) = (band.at(k, j), band.at(pivot, j));
                *band.place(k, j) = b;
                *band.place(pivot, j) = a;
            }
            let head = band.at(k, k);
            if head.norm_sqr() == 0.0 || !head.norm_sqr().is_finite() {
                return None;
            }
            band.pivots.push(pivot);
            let (above, below) = band.rows.split_at_mut(k + 1);
            let top = &above[k][side..];
            for (i, row) in below[..last - k].iter_mut().enumerate() {
                // Column k of row k + 1 + i.
                let row = &mut row[side - 1 - i..];
                let factor = row[0] / head;
                row[0] = factor;
                for (entry, top) in row[1..].iter_mut().zip(&top[1..=far - k]) {
                    *entry -= factor * top;
                }
            }
        }
        Some(band)
    }

    fn at(&self, i: usize, j: usize) -> Number {
        self.rows[i][j + self.side - i]
    }

    fn place(&mut self, i: usize, j: usize) -> &mut Number {
        &mut self.rows[i][j + self.side - i]
    }

    /// Replaces the right-hand side by the solution.
    pub fn solve(&self, x: &mut [Number]) {
        for k in 0..self.size {
            x.swap(k, self.pivots[k]);
            for i in k + 1..=(k + self.side).min(self.size - 1) {
                let step = self.at(i, k) * x[k];
                x[i] -= step;
            }
        }
        for k in (0..self.size).rev() {
            let far = (k + 2 * self.side).min(self.size - 1);
            let sum: Number = (k + 1..=far).map(|j| self.at(k, j) * x[j]).sum();
            x[k] = (x[k] - sum) / self.at(k, k);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_product_with_the_solution_is_the_right_hand_side() {
        // A zero in the first place makes it exchange rows; the numbers have no pattern.
        for (size, side) in [(1, 1), (4, 3), (9, 2), (30, 5)] {
            let element = |i: usize, j: usize| {
                let mixed = ((3 * i + 7 * j) % 11) as f64 - 5.0;
                Number::new(if i + j == 0 { 0.0 } else { mixed }, ((i * j) % 5) as f64 - 1.5)
            };
            let inside = |i: usize, j: usize| i.abs_diff(j) <= side;
            let solution: Vec<Number> = (0..size).map(|i| Number::new(i as f64 - 3.0, 1.0)).collect();
            let row = |i: usize| (0..size).filter(|j| inside(i, *j)).map(|j| element(i, j) * solution[j]).sum();
            let mut x: Vec<Number> = (0..size).map(row).collect();
            Banded::new(size, side, element).unwrap().solve(&mut x);
            for (x, solution) in x.iter().zip(&solution) {
                assert!((x - solution).norm_sqr() < 1e-18, "{size} {side}: {x} {solution}");
            }
        }
        assert!(Banded::new(3, 1, |_, _| Number::ZERO).is_none());
    }
}
