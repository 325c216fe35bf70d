//! The periodic quintic spline; [`super::table`] says what it is good for.

use super::points::{Bend, Points};
use super::turn::{back, near, reduce};
use std::f64::consts::TAU;

/// The periodic quintic spline.
#[derive(Debug, PartialEq)]
pub struct Spline {
    /// The points that it passes through.
    pub points: Points,
    /// The derivatives at the points, if given.
    pub bends: Vec<Bend>,
    /// The angles of the points (rad), ascending in [0, 2π).
    pub knots: Vec<f64>,
    pieces: Vec<Piece>,
    /// Upper bounds of |U⁽ⁿ⁾| over the turn.
    pub bounds: [f64; 5],
}

/// U = Σ cₙ (φ − origin)ⁿ between two points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Piece {
    /// The first point (rad), moved such that the middle lies within half a turn of 0.
    origin: f64,
    middle: f64,
    width: f64,
    coefficients: [f64; 6],
}

impl Spline {
    /// The spline through points that [`Points::open`] has checked, with a derivative for each point or for none.
    pub fn new(points: Points, bends: Vec<Bend>) -> Self {
        let n = points.angles.len();
        // The first point of the turn [0, 2π) leads.
        let reduced: Vec<f64> = points.angles.iter().map(|&phi| reduce(phi)).collect();
        let lead = (0..n).min_by(|&i, &j| reduced[i].total_cmp(&reduced[j])).unwrap_or(0);
        let knots: Vec<f64> = (0..n).map(|i| reduced[(lead + i) % n]).collect();
        let lifts: Vec<f64> = (0..n).map(|i| points.lifts[(lead + i) % n]).collect();
        let widths: Vec<f64> =
            (0..n).map(|i| if i + 1 < n { knots[i + 1] - knots[i] } else { knots[0] + TAU - knots[i] }).collect();
        let slopes = if bends.is_empty() { slopes(&widths, &lifts, &[]) } else { Vec::new() };
        // U′ and U″ at the ends of piece i.
        let ends = |i: usize, j: usize| match slopes.is_empty() {
            true => {
                let (start, end) = (bends[(lead + i) % n], bends[(lead + j) % n]);
                ([start.slope, start.behind], [end.slope, end.before])
            }
            false => (slopes[i], slopes[j]),
        };
        let pieces: Vec<Piece> = (0..n)
            .map(|i| {
                let j = (i + 1) % n;
                let end = knots[i] + 0.5 * widths[i];
                let middle = near(end, 0.0);
                let origin = if middle == end { knots[i] } else { back(knots[i], 1.0) };
                let (start, stop) = ends(i, j);
                let coefficients = quintic(widths[i], lifts[i], lifts[j] - lifts[i], start, stop);
                Piece { origin, middle, width: widths[i], coefficients }
            })
            .collect();
        let bounds = std::array::from_fn(|order| pieces.iter().fold(0.0, |bound: f64, p| bound.max(p.bound(order))));
        Spline { points, bends, knots, pieces, bounds }
    }

    /// The derivatives at points that [`Points::open`] has checked; the points with these indices are `at_rest`, U′ = U″ = 0.
    pub fn resting(points: &Points, at_rest: &[usize]) -> Vec<Bend> {
        let Points { angles, lifts } = points;
        let next = |i: usize| angles.get(i + 1).copied().unwrap_or(angles[0] + TAU);
        let widths: Vec<f64> = (0..angles.len()).map(|i| next(i) - angles[i]).collect();
        let bend = |[slope, bend]: Slopes| Bend { slope, before: bend, behind: bend };
        slopes(&widths, lifts, at_rest).into_iter().map(bend).collect()
    }

    /// 1 over the least width of a piece (1/rad).
    pub fn finest(&self) -> f64 {
        self.pieces.iter().fold(0.0, |finest, piece| finest.max(1.0 / piece.width))
    }

    /// Piece `index`, the last one beyond the list.
    pub fn piece(&self, index: usize) -> &Piece {
        &self.pieces[index.min(self.pieces.len() - 1)]
    }
}

/// (U′, U″) at a point.
type Slopes = [f64; 2];

/// A block of the equations of the slopes.
#[derive(Clone, Copy)]
struct Block([[f64; 2]; 2]);

impl Block {
    fn times(self, x: Slopes) -> Slopes {
        self.0.map(|[a, b]| a * x[0] + b * x[1])
    }

    fn product(self, other: Block) -> Block {
        let columns = other.transposed().0.map(|column| self.times(column));
        Block(columns).transposed()
    }

    fn transposed(self) -> Block {
        let Block([[a, b], [c, d]]) = self;
        Block([[a, c], [b, d]])
    }

    fn inverse(self) -> Block {
        let Block([[a, b], [c, d]]) = self;
        let determinant = a * d - b * c;
        Block([[d, -b], [-c, a]].map(|row| row.map(|x| x / determinant)))
    }

    fn minus(self, other: Block) -> Block {
        Block(std::array::from_fn(|i| minus(self.0[i], other.0[i])))
    }
}

fn minus(x: Slopes, y: Slopes) -> Slopes {
    [x[0] - y[0], x[1] - y[1]]
}

/// An eliminated point: its slopes as a function of the slopes of the next and of the last point.
struct Row {
    inverse: Block,
    next: Block,
    with_last: Block,
    right: Slopes,
}

/// The slopes at the points, from the continuity of U‴ and U⁗ there.
///
/// These are the conditions for the least ∫U‴² dφ with given U at the points: a symmetric, positive definite system of 2×2 blocks,
/// cyclically tridiagonal, which is eliminated in order without pivoting, the last point at the end. The points `at_rest` have zero
/// slopes and drop out of the equations of their neighbours.
fn slopes(widths: &[f64], lifts: &[f64], at_rest: &[usize]) -> Vec<Slopes> {
    let n = widths.len();
    let rise = |i: usize| lifts[(i + 1) % n] - lifts[i];
    // The blocks of the equations of point i: on the diagonal, coupling with point i + 1, and the right-hand side.
    let (mut diagonal, mut right) = (Vec::with_capacity(n), Vec::with_capacity(n));
    for i in 0..n {
        let before = (i + n - 1) % n;
        let (g, h) = (widths[before], widths[i]);
        let mixed = 36.0 / (h * h) - 36.0 / (g * g);
        diagonal
            .push(Block([[192.0 * (1.0 / h.powi(3) + 1.0 / g.powi(3)), mixed], [mixed, 9.0 * (1.0 / h + 1.0 / g)]]));
        right.push([
            360.0 * (rise(i) / h.powi(4) + rise(before) / g.powi(4)),
            60.0 * (rise(i) / h.powi(3) - rise(before) / g.powi(3)),
        ]);
    }
    for &i in at_rest {
        (diagonal[i], right[i]) = (Block([[1.0, 0.0], [0.0, 1.0]]), [0.0; 2]);
    }
    let coupling = |i: usize| {
        let h = widths[i];
        if at_rest.contains(&i) || at_rest.contains(&((i + 1) % n)) {
            return Block([[0.0; 2]; 2]);
        }
        Block([[168.0 / h.powi(3), -24.0 / (h * h)], [24.0 / (h * h), -3.0 / h]])
    };

    // Forward: eliminates points 0 … n − 2 from the following one and from the last one.
    let (last, zero) = (n - 1, Block([[0.0; 2]; 2]));
    let mut with_last = coupling(last).transposed();
    let mut rows: Vec<Row> = Vec::with_capacity(last);
    for i in 0..last {
        let is_penultimate = i + 1 == last;
        if is_penultimate {
            with_last = with_last.minus(zero.minus(coupling(i)));
        }
        let (inverse, b) = (diagonal[i].inverse(), right[i]);
        let next = if is_penultimate { zero } else { coupling(i) };
        rows.push(Row { inverse, next, with_last, right: b });
        let eliminator = with_last.transposed().product(inverse);
        diagonal[last] = diagonal[last].minus(eliminator.product(with_last));
        right[last] = minus(right[last], eliminator.times(b));
        if !is_penultimate {
            let eliminator = next.transposed().product(inverse);
            diagonal[i + 1] = diagonal[i + 1].minus(eliminator.product(next));
            right[i + 1] = minus(right[i + 1], eliminator.times(b));
            with_last = zero.minus(eliminator.product(with_last));
        }
    }

    let mut slopes = vec![[0.0; 2]; n];
    slopes[last] = diagonal[last].inverse().times(right[last]);
    for i in (0..last).rev() {
        let Row { inverse, next, with_last, right } = &rows[i];
        let known = minus(minus(*right, next.times(slopes[i + 1])), with_last.times(slopes[last]));
        slopes[i] = inverse.times(known);
    }
    slopes
}

/// The coefficients of the quintic over `width` with value `u`, increase `rise` and (U′, U″) at both ends.
fn quintic(width: f64, u: f64, rise: f64, start: Slopes, end: Slopes) -> [f64; 6] {
    let (h, h2) = (width, width * width);
    // In units of the width: the rest of value, slope and curvature at the end, for the upper three powers.
    let r0 = rise - h * start[0] - 0.5 * h2 * start[1];
    let r1 = h * (end[0] - start[0]) - h2 * start[1];
    let r2 = h2 * (end[1] - start[1]);
    [
        u,
        start[0],
        0.5 * start[1],
        (10.0 * r0 - 4.0 * r1 + 0.5 * r2) / (h2 * h),
        (-15.0 * r0 + 7.0 * r1 - r2) / (h2 * h2),
        (6.0 * r0 - 3.0 * r1 + 0.5 * r2) / (h2 * h2 * h),
    ]
}

/// U, U′, U″ at the fraction x ∈ [0, 1] of a piece of degree 5 of this width with these U, U′, U″ at its ends.
pub fn within(width: f64, start: [f64; 3], end: [f64; 3], x: f64) -> [f64; 3] {
    let ([u, u1, u2], [v, v1, v2]) = (start, end);
    let coefficients = quintic(width, u, v - u, [u1, u2], [v1, v2]);
    let [u, u1, u2, ..] = Piece { origin: 0.0, middle: 0.5 * width, width, coefficients }.at(x * width);
    [u, u1, u2]
}

impl Piece {
    /// U … U⁗ at `phi`.
    pub fn at(&self, phi: f64) -> [f64; 5] {
        let t = near(phi, self.middle) - self.origin;
        let [c0, c1, c2, c3, c4, c5] = self.coefficients;
        [
            c0 + t * (c1 + t * (c2 + t * (c3 + t * (c4 + t * c5)))),
            c1 + t * (2.0 * c2 + t * (3.0 * c3 + t * (4.0 * c4 + t * (5.0 * c5)))),
            2.0 * c2 + t * (6.0 * c3 + t * (12.0 * c4 + t * (20.0 * c5))),
            6.0 * c3 + t * (24.0 * c4 + t * (60.0 * c5)),
            24.0 * c4 + t * (120.0 * c5),
        ]
    }

    /// U⁽⁵⁾.
    pub fn fifth(&self) -> f64 {
        120.0 * self.coefficients[5]
    }

    /// The largest Bernstein coefficient of the derivative of this order: the polynomial lies in their hull.
    pub fn bound(&self, order: usize) -> f64 {
        let degree = 5 - order;
        // The derivative in powers of (φ − origin)/width.
        let mut powers = [0.0; 6];
        for (k, power) in powers.iter_mut().enumerate().take(degree + 1) {
            let falling: f64 = (k + 1..=k + order).map(|j| j as f64).product();
            *power = falling * self.coefficients[k + order] * self.width.powi(k as i32);
        }
        let mut bound: f64 = 0.0;
        for j in 0..=degree {
            let sum: f64 = (0..=j).map(|k| powers[k] * binomial(j, k) / binomial(degree, k)).sum();
            bound = bound.max(sum.abs());
        }
        // The rounding of the sums is some ulp of their largest terms.
        bound + 1e-15 * powers.iter().map(|p| p.abs()).sum::<f64>() * 4.0
    }
}

fn binomial(n: usize, k: usize) -> f64 {
    (0..k).map(|i| (n - i) as f64 / (i + 1) as f64).product()
}
