//! Dense linear equations of a small, fixed capacity, without allocation.

/// A factorisation P A = L U of a matrix of at most `CAPACITY` rows.
pub struct Lu<const CAPACITY: usize> {
    /// L below the diagonal (its ones are not stored), U on and above it.
    factors: [[f64; CAPACITY]; CAPACITY],
    /// The row exchanged with row k in step k.
    pivots: [usize; CAPACITY],
    size: usize,
}

impl<const CAPACITY: usize> Lu<CAPACITY> {
    /// No matrix yet.
    pub fn empty() -> Self {
        Lu { factors: [[0.0; CAPACITY]; CAPACITY], pivots: [0; CAPACITY], size: 0 }
    }

    /// The factors of the leading `size` × `size` block of `matrix`; None if it is singular or not finite.
    pub fn new(matrix: [[f64; CAPACITY]; CAPACITY], size: usize) -> Option<Self> {
        let mut lu = Lu { factors: matrix, ..Lu::empty() };
        lu.factorise(size)?;
        Some(lu)
    }

    /// The matrix to write before [`Lu::factorise`], so that a large one stands on the stack only once.
    pub fn matrix(&mut self) -> &mut [[f64; CAPACITY]; CAPACITY] {
        &mut self.factors
    }

    /// [`factorise`]s the leading `size` × `size` block of the matrix; None if it is singular or not finite.
    pub fn factorise(&mut self, size: usize) -> Option<()> {
        self.size = size;
        factorise(&mut self.factors, &mut self.pivots[..size])
    }

    /// Replaces the right-hand side by the solution.
    pub fn solve(&self, x: &mut [f64; CAPACITY]) {
        solve(&self.factors, &self.pivots[..self.size], x);
    }
}

/// Factorises the leading block of the matrix, as large as the number of pivots, by elimination with partial pivoting; None if it
/// is singular or not finite.
pub fn factorise<const N: usize>(matrix: &mut [[f64; N]], pivots: &mut [usize]) -> Option<()> {
    let size = pivots.len();
    for k in 0..size {
        let pivot = (k..size).max_by(|&i, &j| matrix[i][k].abs().total_cmp(&matrix[j][k].abs()))?;
        let head = matrix[pivot][k];
        if head == 0.0 || !head.is_finite() {
            return None;
        }
        matrix.swap(k, pivot);
        pivots[k] = pivot;
        let (above, below) = matrix.split_at_mut(k + 1);
        let row = &above[k];
        for other in &mut below[..size - k - 1] {
            let factor = other[k] / head;
            other[k] = factor;
            if factor != 0.0 {
                for (o, r) in other[k + 1..size].iter_mut().zip(&row[k + 1..size]) {
                    *o -= factor * r;
                }
            }
        }
    }
    Some(())
}

/// Replaces the right-hand side by the solution, with the factors of [`factorise`].
pub fn solve<const N: usize>(factors: &[[f64; N]], pivots: &[usize], x: &mut [f64; N]) {
    let size = pivots.len();
    for k in 0..size {
        x.swap(k, pivots[k]);
    }
    for k in 0..size {
        for i in k + 1..size {
            x[i] -= factors[i][k] * x[k];
        }
    }
    for k in (0..size).rev() {
        let row = &factors[k];
        let sum: f64 = (k + 1..size).map(|j| row[j] * x[j]).sum();
        x[k] = (x[k] - sum) / row[k];
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_product_with_the_solution_is_the_right_hand_side() {
        // A Hilbert-like matrix with a zero in the first pivot place; the last row and column are not used.
        let mut a = [[0.0; 5]; 5];
        for (i, row) in a.iter_mut().enumerate() {
            for (j, entry) in row.iter_mut().enumerate() {
                *entry = 1.0 / (1.0 + (i + 2 * j) as f64) - if i + j == 0 { 1.0 } else { 0.0 };
            }
        }
        let solution = [1.0, -2.0, 3.0, -4.0];
        let mut x = [0.0; 5];
        for i in 0..4 {
            x[i] = (0..4).map(|j| a[i][j] * solution[j]).sum();
        }
        let mut again = x;
        Lu::new(a, 4).unwrap().solve(&mut x);
        for i in 0..4 {
            assert!((x[i] - solution[i]).abs() < 1e-11, "{x:?}");
        }
        // In the place of an earlier, larger matrix.
        let mirror = std::array::from_fn(|i| std::array::from_fn(|j| if i + j == 4 { 1.0 } else { 0.0 }));
        let mut lu = Lu::new(mirror, 5).unwrap();
        *lu.matrix() = a;
        lu.factorise(4).unwrap();
        lu.solve(&mut again);
        assert_eq!(again, x);
    }

    #[test]
    fn a_singular_or_infinite_matrix_has_no_factorisation() {
        assert!(Lu::new([[1.0, 2.0], [2.0, 4.0]], 2).is_none());
        assert!(Lu::new([[f64::NAN, 2.0], [2.0, 4.0]], 2).is_none());
        assert!(Lu::new([[f64::INFINITY, 2.0], [2.0, 4.0]], 2).is_none());
    }
}
