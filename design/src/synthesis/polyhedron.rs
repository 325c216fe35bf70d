//! The nearest point of a polyhedron and its lowest one, to thirty digits: the dual active-set method.
//!
//! The least ½ |z − g|² under aᵢ·z ≤ bᵢ. At the optimum z = g − Σ λᵢ aᵢ with λᵢ ≥ 0 over the rows that hold. One row after
//! the other that is exceeded is taken up; on the way the multipliers of the others change, and a row whose multiplier
//! comes to zero lets go. Each full step makes |z − g| larger, so that no set of rows comes back.
//!
//! A point with the least last coordinate is the nearest one to a point far enough below it. Each step of that kind
//! begins where the last one ended; a linear program takes finitely many.
//!
//! Any independent rows are a start, those apart that would pull. So the method runs in plain numbers first, and
//! numbers of thirty digits decide from there.
//!
//! Source: D. Goldfarb, A. Idnani, "A numerically stable dual method for solving strictly convex quadratic programs",
//! Math. Programming 27 (1983) 1–33, algorithm of section 3 with the unit matrix; R. T. Rockafellar, "Monotone operators
//! and the proximal point algorithm", SIAM J. Control Optim. 14 (1976) 877–898, section 3.

use super::exact::{Number, add_multiple, dot};
use crate::work;
use camdrive::numerics::double_double::Double;
use nalgebra::DVectorView;

/// Plain numbers cannot decide on rows that are exceeded by less.
const PLAIN: f64 = 1e-6;

/// Rounding error of a row, in roundings of its terms.
const ROUNDING: f64 = 1e4;

/// Uncertainty of a point, in roundings of its goal or of the largest multiplier: some dozen terms.
const NOISE: f64 = 10.0;

/// Rows taken up per unknown: two or three are the rule, a few dozen where many conditions hold at once.
const STEPS: usize = 100;

/// a·z ≤ b with |a| = 1.
struct Row<N> {
    a: Vec<N>,
    /// a in plain numbers.
    plain: Vec<f64>,
    limit: N,
    /// |a| of the row as it was given.
    length: f64,
}

impl<N: Number> Row<N> {
    fn excess(&self, z: &[N]) -> N {
        dot(&self.a, z) - self.limit
    }
}

fn length<N: Number>(v: &[N]) -> f64 {
    dot(v, v).plain().sqrt()
}

/// The rows that hold as columns of Q R, Q square: rotated as rows come and go, which takes n² operations where new factors
/// take n³.
///
/// Source: G. H. Golub, C. F. Van Loan, *Matrix Computations*, 4th ed., section 6.5.2.
struct Factors<N> {
    /// By rows.
    q: Vec<Vec<N>>,
    /// By columns, down to the diagonal.
    r: Vec<Vec<N>>,
}

impl<N: Number> Factors<N> {
    /// Without rows yet, in `n` coordinates.
    fn new(n: usize) -> Self {
        let unit = |i: usize| (0..n).map(|j| N::from(f64::from(u8::from(i == j)))).collect();
        Factors { q: (0..n).map(unit).collect(), r: Vec::new() }
    }

    /// Qᵀ v.
    fn turned(&self, v: &[N]) -> Vec<N> {
        let mut turned = vec![N::default(); v.len()];
        self.q.iter().zip(v).for_each(|(row, v)| add_multiple(&mut turned, *v, row));
        turned
    }

    /// Q v.
    fn back(&self, v: &[N]) -> Vec<N> {
        self.q.iter().map(|row| dot(row, v)).collect()
    }

    /// x with R x = y.
    fn parts(&self, y: &[N]) -> Vec<N> {
        let mut x = y[..self.r.len()].to_vec();
        for j in (0..x.len()).rev() {
            x[j] = x[j].divide(self.r[j][j]);
            let (above, part) = (&self.r[j][..j], -x[j]);
            add_multiple(&mut x, part, above);
        }
        x
    }

    /// y with Rᵀ y = d.
    fn forward(&self, d: impl Iterator<Item = N>) -> Vec<N> {
        let mut y: Vec<N> = Vec::with_capacity(self.q.len());
        for (column, d) in self.r.iter().zip(d) {
            y.push((d - dot(column, &y)).divide(column[y.len()]));
        }
        y
    }

    /// Takes up the row a with Qᵀ a = `turned`, by a reflection of its part outside the others.
    fn take_up(&mut self, mut turned: Vec<N>) {
        let mut v = turned.split_off(self.r.len());
        let norm = dot(&v, &v).sqrt();
        // The sign that adds, so that nothing cancels.
        let alpha = if v[0].plain() > 0.0 { -norm } else { norm };
        v[0] = v[0] - alpha;
        let factor = N::from(2.0).divide(dot(&v, &v));
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
pub struct Polyhedron<N = Double> {
    rows: Vec<Row<N>>,
    /// The rows that hold, with their multipliers.
    holding: Vec<(usize, N)>,
    factors: Factors<N>,
    z: Vec<N>,
}

impl Polyhedron {
    /// Goes to the point nearest to `goal`, but for `admitted` in each row; whether there is one.
    pub fn nearest(&mut self, goal: &[Double], admitted: f64) -> bool {
        let plain: Vec<f64> = goal.iter().map(|g| g.hi).collect();
        self.propose(admitted, |program| program.approach(&plain, admitted));
        self.approach(goal, admitted)
    }

    /// Goes to a point with the least last coordinate, as near to the present one as there is; whether there is one.
    pub fn lowest(&mut self, admitted: f64) -> bool {
        self.propose(admitted, |program| program.sink(admitted));
        self.sink(admitted)
    }

    /// Lets the rows hold that hold in plain numbers: a start that takes a twentieth of the work, whatever it is worth.
    fn propose(&mut self, admitted: f64, solve: impl FnOnce(&mut Polyhedron<f64>) -> bool) {
        if self.most_exceeded(admitted).is_none_or(|(_, by)| by < PLAIN) {
            return;
        }
        let plain = |row: &Row<Double>| Row {
            a: row.plain.clone(),
            plain: row.plain.clone(),
            limit: row.limit.hi,
            length: row.length,
        };
        let mut program = Polyhedron::new(self.z.len());
        program.rows = self.rows.iter().map(plain).collect();
        program.z = self.z.iter().map(|z| z.hi).collect();
        program.hold(self.holding.iter().map(|(row, _)| *row));
        if solve(&mut program) {
            self.hold(program.holding.into_iter().map(|(row, _)| row));
        }
    }
}

impl<N: Number> Polyhedron<N> {
    /// All points of `n` coordinates.
    pub fn new(n: usize) -> Self {
        Polyhedron { rows: Vec::new(), holding: Vec::new(), factors: Factors::new(n), z: vec![N::default(); n] }
    }

    /// Lets these rows hold, but those that depend on others.
    fn hold(&mut self, rows: impl Iterator<Item = usize>) {
        self.factors = Factors::new(self.z.len());
        self.holding.clear();
        for row in rows {
            let turned = self.factors.turned(&self.rows[row].a);
            if length(&turned[self.holding.len()..]) > N::DEPENDENT {
                self.factors.take_up(turned);
                self.holding.push((row, N::default()));
            }
        }
    }

    /// Adds a row.
    pub fn add(&mut self, a: Vec<N>, limit: N) {
        let length = dot(&a, &a).sqrt();
        let a: Vec<N> = a.into_iter().map(|a| a.divide(length)).collect();
        let plain = a.iter().map(|a| a.plain()).collect();
        self.rows.push(Row { a, plain, limit: limit.divide(length), length: length.plain() });
    }

    /// The point found last.
    pub fn point(&self) -> &[N] {
        &self.z
    }

    /// The rows that hold the lowest point, with their multipliers: by how much it sinks for each part of limit more.
    pub fn multipliers(&self) -> impl Iterator<Item = (usize, f64)> {
        self.holding.iter().map(|(row, multiplier)| (*row, multiplier.plain() / self.rows[*row].length))
    }

    /// [`Polyhedron::nearest`] from the rows that hold.
    fn approach(&mut self, goal: &[N], admitted: f64) -> bool {
        let mut in_noise = 0;
        // A row that is taken up: eight products with Q, and a look at each row in plain numbers.
        let n = goal.len() as f64;
        let cost = 8.0 * n * n * N::COST + 2.0 * n * self.rows.len() as f64;
        for _ in 0..STEPS * goal.len() {
            if !work::draw(cost) {
                return false;
            }
            self.settle(goal);
            let Some((row, by)) = self.most_exceeded(admitted) else { return true };
            // Roundings of a goal far away come back for ever.
            let largest = |size: f64, held: &(usize, N)| size.max(held.1.plain());
            let noise = NOISE * N::ROUNDING * self.holding.iter().fold(length(goal), largest);
            in_noise += usize::from(by <= noise);
            if in_noise > goal.len() {
                return true;
            }
            if !self.take_up(row) {
                return by <= noise;
            }
        }
        false
    }

    /// The row that is exceeded most, and by how much; `admitted` as of [`Polyhedron::nearest`].
    fn most_exceeded(&self, admitted: f64) -> Option<(usize, f64)> {
        let rounding = ROUNDING * N::ROUNDING * length(&self.z);
        // Plain numbers select the rows that can be the one: |a| = 1, so that a sum of n products errs by n roundings of |z|.
        let plain: Vec<f64> = self.z.iter().map(|z| z.plain()).collect();
        let size = plain.iter().fold(0.0, |size: f64, z| size.hypot(*z));
        let z = DVectorView::from_slice(&plain, plain.len());
        let ends = |row: &Row<N>| {
            let by = DVectorView::from_slice(&row.plain, plain.len()).dot(&z) - row.limit.plain();
            let uncertain = plain.len() as f64 * f64::EPSILON * (size + row.limit.plain().abs());
            [by - uncertain, by + uncertain]
        };
        let ends: Vec<[f64; 2]> = self.rows.iter().map(ends).collect();
        let least = ends.iter().fold(0.0, |least: f64, [low, _]| least.max(*low));
        let beyond = |(i, (row, [_, high])): (usize, (&Row<N>, &[f64; 2]))| {
            let by = if *high < least { return None } else { row.excess(&self.z).plain() };
            (by > admitted / row.length + rounding).then_some((i, by))
        };
        self.rows.iter().zip(&ends).enumerate().filter_map(beyond).max_by(|a, b| a.1.total_cmp(&b.1))
    }

    /// [`Polyhedron::lowest`] from the rows that hold.
    fn sink(&mut self, admitted: f64) -> bool {
        for below in N::BELOW {
            let before = self.z.clone();
            let mut goal = before.clone();
            let last = goal.len() - 1;
            goal[last] = goal[last] - N::from(below);
            if !self.approach(&goal, admitted) {
                return false;
            }
            self.holding.iter_mut().for_each(|(_, multiplier)| *multiplier = multiplier.divide(N::from(below)));
            let way: Vec<N> = self.z.iter().zip(&before).map(|(z, before)| *z - *before).collect();
            // A point that far away and lower by more than this would have been nearer.
            if dot(&way, &way).plain() / (2.0 * below) <= admitted.max(N::LEVEL * self.z[last].plain().abs()) {
                break;
            }
        }
        true
    }

    /// To the point nearest to `goal` with the rows that hold as equations, apart from those that would pull.
    fn settle(&mut self, goal: &[N]) {
        loop {
            let turned = self.factors.turned(goal);
            let mut place = self.factors.forward(self.holding.iter().map(|(row, _)| self.rows[*row].limit));
            let away: Vec<N> = turned.iter().zip(&place).map(|(goal, on)| *goal - *on).collect();
            let multipliers = self.factors.parts(&away);
            self.holding.iter_mut().zip(multipliers).for_each(|(row, multiplier)| row.1 = multiplier);
            let largest =
                self.holding.iter().fold(0.0, |largest: f64, (_, multiplier)| largest.max(multiplier.plain()));
            let pulling: Vec<usize> = (0..self.holding.len())
                .filter(|i| !(self.holding[*i].1.plain() > -ROUNDING * N::ROUNDING * largest))
                .collect();
            if pulling.is_empty() {
                place.extend(&turned[place.len()..]);
                self.z = self.factors.back(&place);
                return;
            }
            for i in pulling.into_iter().rev() {
                self.holding.remove(i);
                self.factors.let_go(i);
            }
        }
    }

    /// Takes up a row that is exceeded; whether some point keeps it together with those that hold.
    fn take_up(&mut self, row: usize) -> bool {
        let mut multiplier = N::default();
        let mut turned = self.factors.turned(&self.rows[row].a);
        // Each round but the last one lets a row go.
        for _ in 0..=self.holding.len() {
            let rest = self.rows[row].excess(&self.z);
            if rest.plain() <= 0.0 {
                break;
            }
            // a = Σ rᵢ aᵢ + d with d perpendicular to the rows that hold.
            let parts = self.factors.parts(&turned);
            let perpendicular = &turned[parts.len()..];
            let square = dot(perpendicular, perpendicular);
            let free = square.plain() > N::DEPENDENT.powi(2);
            let ratio = |i: usize| (self.holding[i].1.divide(parts[i]), Some(i));
            let falling = (0..parts.len()).filter(|i| parts[*i].plain() > 0.0).map(ratio);
            let full = free.then(|| (rest.divide(square), None));
            let Some((step, gone)) = falling.chain(full).min_by(|a, b| a.0.plain().total_cmp(&b.0.plain())) else {
                return false;
            };
            for (part, (_, multiplier)) in parts.iter().zip(&mut self.holding) {
                *multiplier = *multiplier - step * *part;
            }
            multiplier = multiplier + step;
            if free {
                let mut way = vec![N::default(); parts.len()];
                way.extend(perpendicular);
                add_multiple(&mut self.z, -step, &self.factors.back(&way));
            }
            match gone {
                Some(i) => {
                    self.holding.remove(i);
                    self.factors.let_go(i);
                    turned = self.factors.turned(&self.rows[row].a);
                }
                None => break,
            }
        }
        if multiplier.plain() > 0.0 {
            self.holding.push((row, multiplier));
            self.factors.take_up(turned);
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
