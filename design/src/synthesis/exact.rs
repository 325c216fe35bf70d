//! Linear algebra in double-double numbers: about 32 digits where a narrow dwell makes sixteen too few.
//!
//! The functions cos kφ on ranges of half-width Δφ are nearly dependent, with singular values down to Δφ^(2K); with
//! Householder's method in double-double numbers K = 9 at Δφ = 0.05 rad loses half of the digits and keeps the other.
//!
//! Source: G. H. Golub, C. F. Van Loan, *Matrix Computations*, 4th ed., sections 5.2.2, 5.4.2 (pivoting), 6.2.2
//! (equality constraints, null-space method).

use crate::work;
use camdrive::numerics::double_double::Double;
use std::ops::{Add, Mul, Neg, Sub};
use std::sync::LazyLock;

/// Columns that are left with less than this part of the largest one depend on the others: a thousand roundings.
pub const RANK: f64 = 1e-28;

const ZERO: Double = Double { hi: 0.0, lo: 0.0 };

/// π/2 to 32 digits.
const QUARTER: Double = Double { hi: std::f64::consts::FRAC_PI_2, lo: 6.123233995736766e-17 };

/// 1/n!; of |r| ≤ π/4 the 28th power over 28! is below 1e-32.
static INVERSE_FACTORIALS: LazyLock<[Double; 30]> = LazyLock::new(|| {
    let mut list = [Double::from(1.0); 30];
    for n in 1..list.len() {
        list[n] = list[n - 1].divide(Double::from(n as f64));
    }
    list
});

/// sin φ and cos φ to 30 digits, for |φ| up to some thousand turns.
pub fn sin_cos(phi: f64) -> [Double; 2] {
    let quarters = (phi / QUARTER.hi).round();
    let r = Double::from(phi) - QUARTER * Double::from(quarters);
    let square = -(r * r);
    let terms = &*INVERSE_FACTORIALS;
    let series = |first: usize| terms.iter().skip(first).step_by(2).rev().fold(ZERO, |sum, term| *term + square * sum);
    let (sin, cos) = (r * series(1), series(0));
    match quarters.rem_euclid(4.0) as u8 {
        0 => [sin, cos],
        1 => [cos, -sin],
        2 => [-sin, -cos],
        _ => [-cos, sin],
    }
}

/// Numbers of sixteen or of thirty digits.
pub trait Number:
    Copy + Default + From<f64> + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Neg<Output = Self>
{
    /// Relative rounding of an operation.
    const ROUNDING: f64;
    /// Plain operations that one takes.
    const COST: f64;
    /// A row that depends on others keeps less than this part of itself next to them.
    const DEPENDENT: f64;
    /// The distance of the place that a successor is nearest to, below its point, in units of the program: further where the last
    /// coordinate hardly depends on the others.
    const BELOW: [f64; 4];
    /// The lowest point is known to this part of its height.
    const LEVEL: f64;
    /// self / other.
    fn divide(self, other: Self) -> Self;
    /// √self.
    fn sqrt(self) -> Self;
    /// The nearest plain number.
    fn plain(self) -> f64;
}

impl Number for f64 {
    const ROUNDING: f64 = f64::EPSILON;
    const COST: f64 = 1.0;
    const DEPENDENT: f64 = 1e-9;
    const BELOW: [f64; 4] = [1e4, 1e5, 1e6, 1e7];
    const LEVEL: f64 = 1e-9;

    fn divide(self, other: Self) -> Self {
        self / other
    }

    fn sqrt(self) -> Self {
        f64::sqrt(self)
    }

    fn plain(self) -> f64 {
        self
    }
}

impl Number for Double {
    const ROUNDING: f64 = 1e-32;
    const COST: f64 = work::PRECISE;
    // Rows of conditions at angles that differ by 1e-8 differ in ten digits.
    const DEPENDENT: f64 = 1e-22;
    const BELOW: [f64; 4] = [1e8, 1e12, 1e16, 1e20];
    const LEVEL: f64 = 1e-14;

    fn divide(self, other: Self) -> Self {
        Double::divide(self, other)
    }

    fn sqrt(self) -> Self {
        Double::sqrt(self)
    }

    fn plain(self) -> f64 {
        self.hi
    }
}

/// Σ aᵢ bᵢ, of as many terms as the shorter one has: in four sums, so that no addition waits for the one before.
pub fn dot<N: Number>(a: &[N], b: &[N]) -> N {
    let n = a.len().min(b.len());
    let (a, b) = (a[..n].chunks_exact(4), b[..n].chunks_exact(4));
    let rest = a.remainder().iter().zip(b.remainder()).fold(N::default(), |sum, (a, b)| sum + *a * *b);
    let mut sums = [N::default(); 4];
    for (a, b) in a.zip(b) {
        for i in 0..4 {
            sums[i] = sums[i] + a[i] * b[i];
        }
    }
    (sums[0] + sums[1]) + (sums[2] + sums[3]) + rest
}

/// target += factor · source.
pub fn add_multiple<N: Number>(target: &mut [N], factor: N, source: &[N]) {
    for (t, s) in target.iter_mut().zip(source) {
        *t = *t + factor * *s;
    }
}

/// Householder factors of a matrix with pivoted columns, A P = Q R.
pub struct Factors {
    /// Column by column: above the diagonal R, from it on the reflector v.
    columns: Vec<Vec<Double>>,
    /// The diagonal of R.
    diagonal: Vec<Double>,
    /// 2/|v|².
    factors: Vec<Double>,
    /// The column of A in each place.
    order: Vec<usize>,
    /// Rows of A.
    rows: usize,
}

impl Factors {
    /// Factors of the matrix with these columns, all of `rows` numbers; a column that is left with less than the part `rank` of
    /// the largest one depends on the others.
    pub fn new(mut columns: Vec<Vec<Double>>, rows: usize, rank: f64) -> Self {
        work::draw(work::PRECISE * (rows * columns.len() * columns.len().min(rows)) as f64);
        let mut order: Vec<usize> = (0..columns.len()).collect();
        let (mut diagonal, mut factors) = (Vec::new(), Vec::new());
        let rest = |column: &[Double], from: usize| dot(&column[from..], &column[from..]);
        let largest = columns.iter().map(|c| rest(c, 0).hi).fold(0.0, f64::max);
        for j in 0..columns.len().min(rows) {
            let norms: Vec<f64> = columns[j..].iter().map(|c| rest(c, j).hi).collect();
            let pivot = j + (0..norms.len()).fold(0, |best, i| if norms[i] > norms[best] { i } else { best });
            if norms[pivot - j] <= rank * rank * largest {
                break;
            }
            columns.swap(j, pivot);
            order.swap(j, pivot);
            let norm = rest(&columns[j], j).sqrt();
            // The sign that adds, so that nothing cancels.
            let alpha = if columns[j][j].hi > 0.0 { -norm } else { norm };
            columns[j][j] = columns[j][j] - alpha;
            let factor = Double::from(2.0).divide(rest(&columns[j], j));
            let (done, open) = columns.split_at_mut(j + 1);
            let v = &done[j][j..];
            for column in open {
                let along = factor * dot(v, &column[j..]);
                add_multiple(&mut column[j..], -along, v);
            }
            diagonal.push(alpha);
            factors.push(factor);
        }
        Factors { columns, diagonal, factors, order, rows }
    }

    /// The number of independent columns.
    pub fn rank(&self) -> usize {
        self.diagonal.len()
    }

    /// Q v in place.
    fn rotate_back(&self, v: &mut [Double]) {
        (0..self.rank()).rev().for_each(|j| self.reflect(j, v));
    }

    fn reflect(&self, j: usize, v: &mut [Double]) {
        let reflector = &self.columns[j][j..];
        let along = self.factors[j] * dot(reflector, &v[j..]);
        add_multiple(&mut v[j..], -along, reflector);
    }

    /// Column `i` of Q.
    pub fn column_of_q(&self, i: usize) -> Vec<Double> {
        let mut v = vec![ZERO; self.rows];
        v[i] = Double::from(1.0);
        self.rotate_back(&mut v);
        v
    }

    /// x with R (Pᵀ x) = y; zero where columns depend on others.
    pub fn back(&self, y: &[Double]) -> Vec<Double> {
        let n = self.rank();
        let mut x = vec![ZERO; self.order.len()];
        for j in (0..n).rev() {
            let sum = (j + 1..n).fold(y[j], |sum, k| sum - self.columns[k][j] * x[self.order[k]]);
            x[self.order[j]] = sum.divide(self.diagonal[j]);
        }
        x
    }

    /// y with Rᵀ y = Pᵀ g.
    pub fn forward(&self, g: &[Double]) -> Vec<Double> {
        let mut y: Vec<Double> = Vec::with_capacity(self.rank());
        for j in 0..self.rank() {
            let rest = g[self.order[j]] - dot(&self.columns[j][..j], &y);
            y.push(rest.divide(self.diagonal[j]));
        }
        y
    }

    /// The smallest x with Aᵀ x = d, by x = Q y with Rᵀ y = Pᵀ d; columns that depend on others are not asked.
    pub fn smallest(&self, d: &[Double]) -> Vec<Double> {
        let mut x = self.forward(d);
        x.resize(self.rows, ZERO);
        self.rotate_back(&mut x);
        x
    }

    /// For each column that depends on others the x with 1 in its place and A x as small as the rank says.
    fn dependent(&self) -> Vec<Vec<Double>> {
        let of = |j: usize| {
            let along: Vec<Double> = self.columns[j][..self.rank()].iter().map(|r| -*r).collect();
            let mut x = self.back(&along);
            x[self.order[j]] = Double::from(1.0);
            x
        };
        (self.rank()..self.order.len()).map(of).collect()
    }

    /// An x with the least |A x − b|.
    pub fn solve(&self, b: &[Double]) -> Vec<Double> {
        self.split(b).0
    }

    /// That x and the remainder b − A x.
    pub fn split(&self, b: &[Double]) -> (Vec<Double>, Vec<Double>) {
        let mut rest = b.to_vec();
        (0..self.rank()).for_each(|j| self.reflect(j, &mut rest));
        let x = self.back(&rest);
        rest[..self.rank()].fill(ZERO);
        self.rotate_back(&mut rest);
        (x, rest)
    }
}

/// The solutions of C x = d: a particular one and an orthonormal basis of C x = 0.
pub struct Solutions {
    /// C x = d, or the least |C x − d| without a solution.
    pub particular: Vec<Double>,
    /// The free directions.
    pub free: Vec<Vec<Double>>,
}

impl Solutions {
    /// Solutions for the rows of C and their right-hand sides, with `n` unknowns; `rank` as of [`Factors::new`].
    pub fn new(c: &[Vec<Double>], d: &[Double], n: usize, rank: f64) -> Self {
        let factors = Factors::new(c.to_vec(), n, rank);
        let rank = factors.rank();
        Solutions { particular: factors.smallest(d), free: (rank..n).map(|i| factors.column_of_q(i)).collect() }
    }

    /// `center` + Σ yᵢ freeᵢ.
    pub fn moved(&self, center: &[Double], y: &[Double]) -> Vec<Double> {
        let mut x = center.to_vec();
        for (y, direction) in y.iter().zip(&self.free) {
            add_multiple(&mut x, *y, direction);
        }
        x
    }

    /// A row in the coordinates of the free directions; a row of one law has zeros for the others, as most directions have.
    pub fn projected(&self, row: &[Double]) -> Vec<Double> {
        let used = |a: &Double| *a != ZERO;
        let [first, end] = [row.iter().position(used), row.iter().rposition(used).map(|last| last + 1)];
        let (first, end) = (first.unwrap_or(0), end.unwrap_or(0));
        let along =
            |direction: &[Double]| if direction.iter().any(used) { dot(&row[first..end], direction) } else { ZERO };
        self.free.iter().map(|direction| along(&direction[first..end])).collect()
    }

    /// The x among the solutions with the least |A x − b|, A by rows.
    pub fn least_squares(&self, a: &[Vec<Double>], b: &[Double]) -> Vec<Double> {
        let rest: Vec<Double> = a.iter().zip(b).map(|(row, b)| *b - dot(row, &self.particular)).collect();
        self.moved(&self.particular, &self.factors(a, RANK).solve(&rest))
    }

    /// The factors of A on the free directions; `rank` as of [`Factors::new`].
    pub fn factors(&self, a: &[Vec<Double>], rank: f64) -> Factors {
        let column = |direction: &Vec<Double>| a.iter().map(|row| dot(row, direction)).collect();
        Factors::new(self.free.iter().map(column).collect(), a.len(), rank)
    }
}

/// Coordinates y of vectors x in which the rows of a matrix are orthonormal, and of the directions that they do not see.
pub struct Coordinates {
    factors: Factors,
    unseen: Vec<Vec<Double>>,
}

impl Coordinates {
    /// Coordinates from the factors; with `all` also in the null space of their matrix, else that part stays where it is.
    pub fn new(factors: Factors, all: bool) -> Self {
        let unseen = if all { factors.dependent() } else { Vec::new() };
        Coordinates { factors, unseen }
    }

    /// Takes the null space of the matrix in units of `size`.
    pub fn with_unseen(mut self, size: f64) -> Self {
        self.unseen.iter_mut().flatten().for_each(|v| *v = *v * Double::from(size));
        self
    }

    /// Their number.
    pub fn len(&self) -> usize {
        self.factors.rank() + self.unseen.len()
    }

    /// A row over x as one over y.
    pub fn row(&self, row: &[Double]) -> Vec<Double> {
        let mut coordinates = self.factors.forward(row);
        coordinates.extend(self.unseen.iter().map(|direction| dot(row, direction)));
        coordinates
    }

    /// x.
    pub fn vector(&self, y: &[Double]) -> Vec<Double> {
        let (seen, unseen) = y.split_at(self.factors.rank());
        let mut x = self.factors.back(seen);
        for (y, direction) in unseen.iter().zip(&self.unseen) {
            add_multiple(&mut x, *y, direction);
        }
        x
    }
}

/// Plain numbers as ones of thirty digits.
#[cfg(test)]
pub fn numbers(values: &[f64]) -> Vec<Double> {
    values.iter().map(|v| Double::from(*v)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sine_and_cosine_to_thirty_digits() {
        for phi in [0.0, 1e-9, 0.7, 1.0, 2.5, -4.0, 300.0] {
            let [s, c] = sin_cos(phi);
            assert!((s.hi - f64::sin(phi)).abs() < 2e-16 && (c.hi - f64::cos(phi)).abs() < 2e-16, "{phi}");
            let one = s * s + c * c - Double::from(1.0);
            assert!(one.hi.abs() < 1e-30, "{phi}: {one:?}");
        }
        // sin 1 = 0.84147098480789650665250232163029900
        let error = sin_cos(1.0)[0] - Double { hi: 0.8414709848078965, lo: 1.776845092935536e-18 };
        assert!(error.hi.abs() < 1e-31);
    }

    #[test]
    fn the_hilbert_matrix_of_ten_rows() {
        // Its condition is 1.6e13; the solution of ones comes back to all digits of an f64.
        let h = |i: usize, j: usize| Double::from(1.0).divide(Double::from((i + j + 1) as f64));
        let columns: Vec<Vec<Double>> = (0..10).map(|j| (0..10).map(|i| h(i, j)).collect()).collect();
        let b: Vec<Double> = (0..10).map(|i| (0..10).fold(ZERO, |sum, j| sum + h(i, j))).collect();
        for x in Factors::new(columns, 10, RANK).solve(&b) {
            assert!((x - Double::from(1.0)).hi.abs() < 1e-16);
        }
    }

    #[test]
    fn least_squares_with_a_condition() {
        // The point of x + y = 2 nearest to (3, 0).
        let solutions = Solutions::new(&[numbers(&[1.0, 1.0])], &numbers(&[2.0]), 2, RANK);
        let x = solutions.least_squares(&[numbers(&[1.0, 0.0]), numbers(&[0.0, 1.0])], &numbers(&[3.0, 0.0]));
        assert!((x[0].hi - 2.5).abs() < 1e-30 && (x[1].hi + 0.5).abs() < 1e-30);
    }

    #[test]
    fn a_column_twice_counts_once() {
        let factors = Factors::new(vec![numbers(&[1.0, 2.0]), numbers(&[1.0, 2.0])], 2, RANK);
        assert_eq!(factors.rank(), 1);
        let x = factors.solve(&numbers(&[3.0, 6.0]));
        assert!((x[0] + x[1] - Double::from(3.0)).hi.abs() < 1e-30);
    }

    #[test]
    fn coordinates_see_everything() {
        // x + 2y + 3z and half of it see one direction; with all of them any x has a y, and rows keep their values.
        let columns = vec![numbers(&[1.0, 0.5]), numbers(&[2.0, 1.0]), numbers(&[3.0, 1.5])];
        let coordinates = Coordinates::new(Factors::new(columns, 2, RANK), true);
        assert_eq!(coordinates.len(), 3);
        let (row, y) = (numbers(&[0.3, -0.7, 5.0]), numbers(&[1.0, -2.0, 0.5]));
        let difference = dot(&coordinates.row(&row), &y) - dot(&row, &coordinates.vector(&y));
        assert!(difference.hi.abs() < 1e-29);
        let seen = coordinates.row(&numbers(&[1.0, 2.0, 3.0]));
        assert!(seen[1].hi.abs() < 1e-29 && seen[2].hi.abs() < 1e-29);
    }
}
