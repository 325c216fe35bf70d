//! The nearest point of a polyhedron and its lowest one, to thirty digits: the dual active-set method.
//!
//! The least ½ |z − g|² under aᵢ·z ≤ bᵢ. At the optimum z = g − Σ λᵢ aᵢ with λᵢ ≥ 0 over the rows that hold. One row after
//! the other that is exceeded is taken up; on the way the multipliers of the others change, and a row whose multiplier
//! comes to zero lets go. Each full step makes |z − g| larger, so that no set of rows comes back.
//!
//! A point with the least last coordinate is the nearest one to a point far enough below it. Each step of that kind
//! begins where the last one ended; a linear program takes finitely many.
//!
//! Source: D. Goldfarb, A. Idnani, "A numerically stable dual method for solving strictly convex quadratic programs",
//! Math. Programming 27 (1983) 1–33, algorithm of section 3 with the unit matrix; R. T. Rockafellar, "Monotone operators
//! and the proximal point algorithm", SIAM J. Control Optim. 14 (1976) 877–898, section 3.

use super::exact::{add_multiple, dot};
use crate::work;
use camdrive::numerics::double_double::Double;

/// A row that depends on others keeps less than this part of itself beside them: rows of conditions at angles that differ
/// by 1e-8 are told apart to ten digits.
const DEPENDENT: f64 = 1e-22;

/// Rounding error of a row, as part of its terms.
const ROUNDING: f64 = 1e-28;

/// Uncertainty of a point, as part of its goal or of the largest multiplier: some dozen terms of thirty-two digits.
const NOISE: f64 = 1e-31;

/// Rows taken up per unknown: two or three are the rule, a few dozen where many conditions hold at once.
const STEPS: usize = 100;

/// How far below a point the one is that its successor is nearest to, in units of the program: further where the last
/// coordinate hardly depends on the others.
const BELOW: [f64; 4] = [1e8, 1e12, 1e16, 1e20];

/// The lowest point is known to this part of its height.
const LEVEL: f64 = 1e-14;

/// a·z ≤ b with |a| = 1.
struct Row {
    a: Vec<Double>,
    /// a in plain numbers.
    plain: Vec<f64>,
    limit: Double,
    /// |a| of the row as it was given.
    length: f64,
}

impl Row {
    fn excess(&self, z: &[Double]) -> Double {
        dot(&self.a, z) - self.limit
    }
}

fn length(v: &[Double]) -> f64 {
    dot(v, v).hi.sqrt()
}

/// The rows that hold as columns of Q R, Q square: rotated as rows come and go, which takes n² operations where new factors
/// take n³.
///
/// Source: G. H. Golub, C. F. Van Loan, *Matrix Computations*, 4th ed., section 6.5.2.
struct Factors {
    /// By rows.
    q: Vec<Vec<Double>>,
    /// By columns, down to the diagonal.
    r: Vec<Vec<Double>>,
}

impl Factors {
    /// Of no rows yet, in `n` coordinates.
    fn new(n: usize) -> Self {
        let unit = |i: usize| (0..n).map(|j| Double::from(f64::from(u8::from(i == j)))).collect();
        Factors { q: (0..n).map(unit).collect(), r: Vec::new() }
    }

    /// Qᵀ v.
    fn turned(&self, v: &[Double]) -> Vec<Double> {
        let mut turned = vec![Double::default(); v.len()];
        self.q.iter().zip(v).for_each(|(row, v)| add_multiple(&mut turned, *v, row));
        turned
    }

    /// Q v.
    fn back(&self, v: &[Double]) -> Vec<Double> {
        self.q.iter().map(|row| dot(row, v)).collect()
    }

    /// x with R x = y.
    fn parts(&self, y: &[Double]) -> Vec<Double> {
        let mut x = y[..self.r.len()].to_vec();
        for j in (0..x.len()).rev() {
            x[j] = x[j].divide(self.r[j][j]);
            let (above, part) = (&self.r[j][..j], -x[j]);
            add_multiple(&mut x, part, above);
        }
        x
    }

    /// y with Rᵀ y = d.
    fn forward(&self, d: impl Iterator<Item = Double>) -> Vec<Double> {
        let mut y: Vec<Double> = Vec::with_capacity(self.q.len());
        for (column, d) in self.r.iter().zip(d) {
            y.push((d - dot(column, &y)).divide(column[y.len()]));
        }
        y
    }

    /// Takes up the row a with Qᵀ a = `turned`, by a reflection of what is left of it beside the others.
    fn take_up(&mut self, mut turned: Vec<Double>) {
        let mut v = turned.split_off(self.r.len());
        let norm = dot(&v, &v).sqrt();
        // The sign that adds, so that nothing cancels.
        let alpha = if v[0].hi > 0.0 { -norm } else { norm };
        v[0] = v[0] - alpha;
        let factor = Double::from(2.0).divide(dot(&v, &v));
        for row in &mut self.q {
            let row = &mut row[turned.len()..];
            add_multiple(row, -(factor * dot(row, &v)), &v);
        }
        turned.push(alpha);
        self.r.push(turned);
    }

    /// Lets row `i` of those that hold go, by rotations.
    fn let_go(&mut self, i: usize) {
        self.r.remove(i);
        for j in i..self.r.len() {
            let [a, b] = [self.r[j][j], self.r[j][j + 1]];
            let size = (a * a + b * b).sqrt();
            let [c, s] = [a, b].map(|part| part.divide(size));
            for line in self.r[j..].iter_mut().chain(&mut self.q) {
                let [a, b] = [line[j], line[j + 1]];
                (line[j], line[j + 1]) = (c * a + s * b, c * b - s * a);
            }
            self.r[j].truncate(j + 1);
        }
    }
}

/// aᵢ·z ≤ bᵢ and the point that was found last.
pub struct Polyhedron {
    rows: Vec<Row>,
    /// The rows that hold, with their multipliers.
    holding: Vec<(usize, Double)>,
    z: Vec<Double>,
}

impl Polyhedron {
    /// All points of `n` coordinates.
    pub fn new(n: usize) -> Self {
        Polyhedron { rows: Vec::new(), holding: Vec::new(), z: vec![Double::default(); n] }
    }

    /// Adds a row.
    pub fn add(&mut self, a: Vec<Double>, limit: Double) {
        let length = dot(&a, &a).sqrt();
        let a: Vec<Double> = a.into_iter().map(|a| a.divide(length)).collect();
        let plain = a.iter().map(|a| a.hi).collect();
        self.rows.push(Row { a, plain, limit: limit.divide(length), length: length.hi });
    }

    /// The point found last.
    pub fn point(&self) -> &[Double] {
        &self.z
    }

    /// The rows that hold the lowest point, with their multipliers: by how much it sinks for each part of limit more.
    pub fn multipliers(&self) -> impl Iterator<Item = (usize, f64)> {
        self.holding.iter().map(|(row, multiplier)| (*row, multiplier.hi / self.rows[*row].length))
    }

    /// Goes to the point nearest to `goal`, but for `admitted` in each row; whether there is one.
    pub fn nearest(&mut self, goal: &[Double], admitted: f64) -> bool {
        let mut in_noise = 0;
        let mut factors = Factors::new(goal.len());
        for (row, _) in &self.holding {
            factors.take_up(factors.turned(&self.rows[*row].a));
        }
        // A row that is taken up: eight products with Q, and a look at each row in plain numbers.
        let n = goal.len() as f64;
        let cost = 8.0 * n * n * work::PRECISE + 2.0 * n * self.rows.len() as f64;
        for _ in 0..STEPS * goal.len() {
            if !work::draw(cost) {
                return false;
            }
            self.settle(&mut factors, goal);
            let Some((row, by)) = self.most_exceeded(admitted) else { return true };
            // Roundings of a goal far away come back for ever.
            let largest = |size: f64, held: &(usize, Double)| size.max(held.1.hi);
            let noise = NOISE * self.holding.iter().fold(length(goal), largest);
            in_noise += usize::from(by <= noise);
            if in_noise > goal.len() {
                return true;
            }
            if !self.take_up(row, &mut factors) {
                return by <= noise;
            }
        }
        false
    }

    /// The row that is exceeded most, and by how much; `admitted` as of [`Polyhedron::nearest`].
    fn most_exceeded(&self, admitted: f64) -> Option<(usize, f64)> {
        let rounding = ROUNDING * length(&self.z);
        // Plain numbers tell which rows can be the one: |a| = 1, so that a sum of n products errs by n roundings of |z|.
        let plain: Vec<f64> = self.z.iter().map(|z| z.hi).collect();
        let size = plain.iter().fold(0.0, |size: f64, z| size.hypot(*z));
        let ends = |row: &Row| {
            let by = row.plain.iter().zip(&plain).map(|(a, z)| a * z).sum::<f64>() - row.limit.hi;
            let uncertain = plain.len() as f64 * f64::EPSILON * (size + row.limit.hi.abs());
            [by - uncertain, by + uncertain]
        };
        let ends: Vec<[f64; 2]> = self.rows.iter().map(ends).collect();
        let least = ends.iter().fold(0.0, |least: f64, [low, _]| least.max(*low));
        let beyond = |(i, (row, [_, high])): (usize, (&Row, &[f64; 2]))| {
            let by = if *high < least { return None } else { row.excess(&self.z).hi };
            (by > admitted / row.length + rounding).then_some((i, by))
        };
        self.rows.iter().zip(&ends).enumerate().filter_map(beyond).max_by(|a, b| a.1.total_cmp(&b.1))
    }

    /// Goes to a point with the least last coordinate, as near to the present one as there is; whether there is one.
    pub fn lowest(&mut self, admitted: f64) -> bool {
        for below in BELOW {
            let before = self.z.clone();
            let mut goal = before.clone();
            let last = goal.len() - 1;
            goal[last] = goal[last] - Double::from(below);
            if !self.nearest(&goal, admitted) {
                return false;
            }
            self.holding.iter_mut().for_each(|(_, multiplier)| *multiplier = multiplier.divide(Double::from(below)));
            let way: Vec<Double> = self.z.iter().zip(&before).map(|(z, before)| *z - *before).collect();
            // A point that far away and lower by more than this would have been nearer.
            if dot(&way, &way).hi / (2.0 * below) <= admitted.max(LEVEL * self.z[last].hi.abs()) {
                break;
            }
        }
        true
    }

    /// To the point nearest to `goal` with the rows that hold as equations, apart from those that would pull.
    fn settle(&mut self, factors: &mut Factors, goal: &[Double]) {
        loop {
            let turned = factors.turned(goal);
            let mut place = factors.forward(self.holding.iter().map(|(row, _)| self.rows[*row].limit));
            let away: Vec<Double> = turned.iter().zip(&place).map(|(goal, on)| *goal - *on).collect();
            let multipliers = factors.parts(&away);
            self.holding.iter_mut().zip(multipliers).for_each(|(row, multiplier)| row.1 = multiplier);
            let largest = self.holding.iter().fold(0.0, |largest: f64, (_, multiplier)| largest.max(multiplier.hi));
            let pulling: Vec<usize> =
                (0..self.holding.len()).filter(|i| !(self.holding[*i].1.hi > -ROUNDING * largest)).collect();
            if pulling.is_empty() {
                place.extend(&turned[place.len()..]);
                self.z = factors.back(&place);
                return;
            }
            for i in pulling.into_iter().rev() {
                self.holding.remove(i);
                factors.let_go(i);
            }
        }
    }

    /// Takes up a row that is exceeded; whether some point keeps it together with those that hold.
    fn take_up(&mut self, row: usize, factors: &mut Factors) -> bool {
        let mut multiplier = Double::default();
        let mut turned = factors.turned(&self.rows[row].a);
        // Each round but the last one lets a row go.
        for _ in 0..=self.holding.len() {
            let rest = self.rows[row].excess(&self.z);
            if rest.hi <= 0.0 {
                break;
            }
            // a = Σ rᵢ aᵢ + d with d perpendicular to the rows that hold.
            let parts = factors.parts(&turned);
            let perpendicular = &turned[parts.len()..];
            let square = dot(perpendicular, perpendicular);
            let free = square.hi > DEPENDENT * DEPENDENT;
            let ratio = |i: usize| (self.holding[i].1.divide(parts[i]), Some(i));
            let falling = (0..parts.len()).filter(|i| parts[*i].hi > 0.0).map(ratio);
            let full = free.then(|| (rest.divide(square), None));
            let Some((step, gone)) = falling.chain(full).min_by(|a, b| a.0.hi.total_cmp(&b.0.hi)) else { return false };
            for (part, (_, multiplier)) in parts.iter().zip(&mut self.holding) {
                *multiplier = *multiplier - step * *part;
            }
            multiplier = multiplier + step;
            if free {
                let mut way = vec![Double::default(); parts.len()];
                way.extend(perpendicular);
                add_multiple(&mut self.z, -step, &factors.back(&way));
            }
            match gone {
                Some(i) => {
                    self.holding.remove(i);
                    factors.let_go(i);
                    turned = factors.turned(&self.rows[row].a);
                }
                None => break,
            }
        }
        if multiplier.hi > 0.0 {
            self.holding.push((row, multiplier));
            factors.take_up(turned);
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use super::super::exact::numbers;
    use super::*;

    fn expect(found: &Polyhedron, expected: &[f64]) {
        for (found, expected) in found.point().iter().zip(expected) {
            assert!((*found - Double::from(*expected)).hi.abs() < 1e-18, "{found:?}");
        }
    }

    #[test]
    fn the_nearest_point_of_a_wedge() {
        // x + y ≥ 2 alone: (1, 1). With x ≥ 3/2 also: (3/2, 1/2). With y ≤ 0: (2, 0), and the first x ≥ 3/2 lets go.
        let mut wedge = Polyhedron::new(2);
        let origin = numbers(&[0.0, 0.0]);
        for (row, limit, expected) in
            [([-1.0, -1.0], -2.0, [1.0, 1.0]), ([-1.0, 0.0], -1.5, [1.5, 0.5]), ([0.0, 1.0], 0.0, [2.0, 0.0])]
        {
            wedge.add(numbers(&row), Double::from(limit));
            assert!(wedge.nearest(&origin, 0.0));
            expect(&wedge, &expected);
        }
        assert_eq!(wedge.holding.len(), 2);
        // x ≤ 1 contradicts them.
        wedge.add(numbers(&[1.0, 0.0]), Double::from(1.0));
        assert!(!wedge.nearest(&origin, 0.0));
    }

    #[test]
    fn the_best_constant_of_three_numbers() {
        // |y − 1|, |y − 4|, |y − 9| ≤ t: y = 5, t = 4. With y ≤ 4: t = 5.
        let mut program = Polyhedron::new(2);
        for c in [1.0, 4.0, 9.0] {
            program.add(numbers(&[1.0, -1.0]), Double::from(c));
            program.add(numbers(&[-1.0, -1.0]), Double::from(-c));
        }
        assert!(program.lowest(1e-25));
        expect(&program, &[5.0, 4.0]);
        program.add(numbers(&[1.0, 0.0]), Double::from(4.0));
        assert!(program.lowest(1e-25));
        expect(&program, &[4.0, 5.0]);
        let multipliers: Vec<(usize, f64)> = program.multipliers().collect();
        assert!(multipliers.len() == 2 && multipliers.iter().all(|(_, part)| (part - 1.0).abs() < 1e-12));
    }

    #[test]
    fn an_unknown_that_nobody_asks_for_stays() {
        let mut program = Polyhedron::new(3);
        program.add(numbers(&[1.0, 0.0, -1.0]), Double::from(-3.0));
        program.add(numbers(&[-1.0, 0.0, -1.0]), Double::from(1.0));
        assert!(program.lowest(1e-25));
        expect(&program, &[-2.0, 0.0, 1.0]);
    }

    #[test]
    fn roundings_of_a_goal_far_away_end() {
        // |Σ yₖ cos kφ − 0.3 cos φ| ≤ t + 1e-5 at twenty near angles, |yₖ| ≤ 1: t = −1e-5, and much of y is open.
        let mut program = Polyhedron::new(17);
        for i in 0..16 {
            for sign in [1.0, -1.0] {
                program
                    .add((0..17).map(|k| Double::from(if k == i { sign } else { 0.0 })).collect(), Double::from(1.0));
            }
        }
        for phi in (0..20).map(|i| 0.1 * f64::from(i)) {
            for sign in [1.0, -1.0] {
                let row: Vec<f64> = (0..16).map(|k| sign * (f64::from(k) * phi).cos()).chain([-1.0]).collect();
                program.add(numbers(&row), Double::from(sign * 0.3 * phi.cos() + 1e-5));
            }
        }
        assert!(program.lowest(1e-24));
        assert!((program.point()[16].hi + 1e-5).abs() < 1e-16);
    }
}
