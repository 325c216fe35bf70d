//! Linear programs to thirty digits: the simplex method in double-double numbers.
//!
//! The least t under aᵢ·z ≤ bᵢ, where t is the last of the unknowns z. As many rows as unknowns hold z as equations. The
//! primal method starts where all rows are fulfilled and lets that equation go along whose edge t falls fastest, until
//! another row stops it; at first nothing is held, so that it descends from the inside and no corner is met in which
//! more rows meet than are needed. Where t falls no more, the optimum is found. Rows added later are taken up by the
//! dual method, which lets t grow until none of them is exceeded.
//!
//! Source: G. B. Dantzig, *Linear Programming and Extensions*, 1963, chapters 5 and 11; C. E. Lemke, "The dual method of
//! solving the linear programming problem", Naval Res. Logist. Q. 1 (1954) 36–47.

use super::exact::{add_multiple, dot};
use camdrive::numerics::double_double::Double;

/// What is below this part of the numbers that it is the sum of is rounding: the inverse of a program in orthonormal
/// coordinates keeps some 26 of 32 digits.
const PIVOT: f64 = 1e-22;

/// Pivots per unknown: two or three are the rule, a few dozen where many conditions hold at once.
const PIVOTS: usize = 100;

/// Where many rows meet in one point the primal method may go round in circles. Then it descends between limits that are
/// wider by about this, each by another amount, and the dual method takes the last steps.
const WIDER: f64 = 1e-9;

/// Pivots after which the slacks, kept in plain numbers, are computed anew.
const FRESH: usize = 16;

/// What holds one of the equations.
#[derive(Clone, Copy, PartialEq)]
enum Holder {
    /// Nothing yet: the unknown stays where it is.
    Free,
    /// A row.
    Row(usize),
}

/// a·z ≤ b.
struct Row {
    a: Vec<Double>,
    plain: Vec<f64>,
    limit: Double,
}

/// A program with its present solution.
pub struct Simplex {
    rows: Vec<Row>,
    holders: Vec<Holder>,
    /// The columns of the inverse of the matrix of the equations.
    inverse: Vec<Vec<Double>>,
    z: Vec<Double>,
    /// By how much limits are wider, on the average.
    wider: f64,
}

/// What rows lack of their limits, in numbers of sixteen digits.
struct Slacks {
    list: Vec<f64>,
    /// Each row times the columns of the inverse; empty where nobody asks.
    tableau: Vec<Vec<f64>>,
    /// Pivots since they were exact.
    age: usize,
}

impl Simplex {
    /// Of unknowns that are zero, and a level that is at least `least`.
    pub fn new(unknowns: usize, least: f64) -> Self {
        let mut program =
            Simplex { rows: Vec::new(), holders: Vec::new(), inverse: Vec::new(), z: Vec::new(), wider: 0.0 };
        program.z = vec![Double::default(); unknowns + 1];
        let mut floor = vec![Double::default(); unknowns + 1];
        floor[unknowns] = Double::from(-1.0);
        program.add(floor, Double::from(-least));
        program
    }

    /// Adds a row; its last part is that of the level.
    pub fn add(&mut self, a: Vec<Double>, limit: Double) {
        self.rows.push(Row { plain: a.iter().map(|v| v.hi).collect(), a, limit });
    }

    /// The unknowns, without the level.
    pub fn unknowns(&self) -> &[Double] {
        &self.z[..self.z.len() - 1]
    }

    /// The level.
    pub fn level(&self) -> Double {
        self.z[self.z.len() - 1]
    }

    /// The rows that hold the optimum, with their multipliers: by how much the level falls for each part of limit more.
    pub fn multipliers(&self) -> Vec<(usize, f64)> {
        let last = self.z.len() - 1;
        let of = |(holder, column): (&Holder, &Vec<Double>)| match holder {
            Holder::Row(row) => Some((*row, -column[last].hi)),
            Holder::Free => None,
        };
        self.holders.iter().zip(&self.inverse).filter_map(of).collect()
    }

    /// The optimum by the primal method, from the point nearest to the present one on the way to `inside`, where all rows
    /// without level are fulfilled; whether it was reached. Rows may be exceeded by what limits were widened by.
    pub fn descend(&mut self, inside: &[Double]) -> bool {
        self.descend_between(inside, 0.0) || self.descend_between(inside, WIDER)
    }

    fn descend_between(&mut self, inside: &[Double], wider: f64) -> bool {
        self.retreat(inside);
        let n = self.z.len();
        let unit = |i: usize| {
            let mut v = vec![Double::default(); n];
            v[i] = Double::from(1.0);
            v
        };
        self.inverse = (0..n).map(unit).collect();
        self.holders = vec![Holder::Free; n];
        self.wider = wider;
        let reached = self.descended();
        self.wider = 0.0;
        self.refine();
        reached
    }

    fn descended(&mut self) -> bool {
        let mut slacks = self.slacks(true);
        for _ in 0..PIVOTS * self.z.len() {
            let Some((place, sign)) = self.edge(&slacks) else { return true };
            let direction: Vec<Double> = self.inverse[place].iter().map(|v| Double::from(sign) * *v).collect();
            let Some((row, step)) = self.stop(place, sign, &direction, &slacks) else { return false };
            let change: Vec<Double> = direction.iter().map(|d| *d * step).collect();
            self.exchange(row, place, &mut slacks);
            self.advance(&change, &mut slacks);
        }
        false
    }

    /// The optimum by the dual method from that of fewer rows, exceeded by at most `tolerance`; whether it was reached.
    pub fn ascend(&mut self, tolerance: f64) -> bool {
        let mut slacks = self.slacks(false);
        for _ in 0..PIVOTS * self.z.len() {
            let exceeded = (0..slacks.list.len()).filter(|i| slacks.list[*i] < -tolerance);
            let Some(row) = exceeded.min_by(|i, j| slacks.list[*i].total_cmp(&slacks.list[*j])) else {
                if slacks.age == 0 {
                    return true;
                }
                self.refine();
                slacks = self.slacks(false);
                continue;
            };
            let slack = self.slack(row);
            if slack.hi >= -tolerance {
                slacks.list[row] = slack.hi;
                continue;
            }
            let Some(place) = self.leaving(row) else { return false };
            self.exchange(row, place, &mut slacks);
            let change: Vec<Double> = self.inverse[place].iter().map(|v| *v * slack).collect();
            self.advance(&change, &mut slacks);
        }
        false
    }

    /// To where all rows are fulfilled.
    fn retreat(&mut self, inside: &[Double]) {
        let n = self.z.len() - 1;
        let value = |row: &Row, y: &[Double]| (dot(&row.a[..n], y) - row.limit).hi;
        let mut part = 0.0_f64;
        for row in self.rows.iter().filter(|row| row.plain[n] == 0.0) {
            let [here, there] = [value(row, &self.z), value(row, inside)];
            if here > 0.0 {
                part = part.max(if there < here { (here / (here - there)).min(1.0) } else { 1.0 });
            }
        }
        // A little further than to the first row, so that it is not met at the beginning.
        let part = Double::from((1.1 * part).min(1.0));
        for (z, inside) in self.z[..n].iter_mut().zip(inside) {
            *z = *z + part * (*inside - *z);
        }
        let needed = |row: &Row| value(row, &self.z) / -row.plain[n];
        let highest = self.rows.iter().filter(|row| row.plain[n] < 0.0).map(needed).fold(f64::NEG_INFINITY, f64::max);
        // Above all rows, for the same reason.
        self.z[n] = Double::from(highest + 0.1 * highest.abs());
    }

    fn slack(&self, row: usize) -> Double {
        // Multiples of the golden section are nowhere alike.
        let wider = self.wider * (0.5 + (row as f64 * 0.618_033_988_749_894_9).fract());
        self.rows[row].limit + Double::from(wider) - dot(&self.rows[row].a, &self.z)
    }

    fn slacks(&self, tableau: bool) -> Slacks {
        let plain: Vec<Vec<f64>> = self.inverse.iter().map(|v| v.iter().map(|v| v.hi).collect()).collect();
        let product = |row: &Row| plain.iter().map(|v| row.plain.iter().zip(v).map(|(a, v)| a * v).sum()).collect();
        let rows = if tableau { &self.rows[..] } else { &[] };
        let list = (0..self.rows.len()).map(|i| self.slack(i).hi).collect();
        Slacks { list, tableau: rows.iter().map(product).collect(), age: 0 }
    }

    /// The equation that may go and the sign of its column along which t falls furthest then; None at the optimum. How
    /// far is asked in plain numbers, for it is only a choice.
    fn edge(&self, slacks: &Slacks) -> Option<(usize, f64)> {
        let last = self.z.len() - 1;
        let signs: Vec<f64> = self.inverse.iter().map(|v| if v[last].hi > 0.0 { -1.0 } else { 1.0 }).collect();
        let mut steps = vec![f64::INFINITY; self.z.len()];
        for ((slack, parts), _) in slacks.list.iter().zip(&slacks.tableau).zip(self.held()).filter(|(_, held)| !held) {
            for ((step, part), sign) in steps.iter_mut().zip(parts).zip(&signs) {
                let rate = sign * part;
                if rate > 0.0 && *step * rate > slack.max(0.0) {
                    *step = slack.max(0.0) / rate;
                }
            }
        }
        let falls = |i: &usize| {
            let rate = self.inverse[*i][last].hi;
            let fall = if self.holders[*i] == Holder::Free { rate.abs() } else { rate };
            (fall > PIVOT * length(&self.inverse[*i])).then_some((*i, steps[*i] * fall))
        };
        let furthest = (0..steps.len()).filter_map(|i| falls(&i)).max_by(|a, b| a.1.total_cmp(&b.1));
        furthest.map(|(place, _)| (place, signs[place]))
    }

    /// Which rows hold an equation.
    fn held(&self) -> Vec<bool> {
        let mut held = vec![false; self.rows.len()];
        for holder in &self.holders {
            if let Holder::Row(row) = holder {
                held[*row] = true;
            }
        }
        held
    }

    /// The row that is met first along a column of the inverse with a sign, and after which step: the nearest in plain
    /// numbers, confirmed in exact ones.
    fn stop(&self, place: usize, sign: f64, direction: &[Double], slacks: &Slacks) -> Option<(usize, Double)> {
        let held = self.held();
        let step = |i: usize| {
            let rate = sign * slacks.tableau[i][place];
            if rate > 0.0 && !held[i] { slacks.list[i].max(0.0) / rate } else { f64::INFINITY }
        };
        let mut steps: Vec<f64> = (0..self.rows.len()).map(step).collect();
        let mut confirmed: Option<(usize, Double)> = None;
        loop {
            let nearest = (0..steps.len()).min_by(|i, j| steps[*i].total_cmp(&steps[*j]))?;
            if steps[nearest] == f64::INFINITY || confirmed.is_some_and(|(_, step)| step.hi <= steps[nearest]) {
                return confirmed;
            }
            steps[nearest] = f64::INFINITY;
            let row = &self.rows[nearest];
            let rate = dot(&row.a, direction);
            if rate.hi > PIVOT * length(direction) * length(&row.a) {
                let slack = self.slack(nearest);
                let step = if slack.hi > 0.0 { slack.divide(rate) } else { Double::default() };
                if confirmed.is_none_or(|(_, shortest)| step.hi < shortest.hi) {
                    confirmed = Some((nearest, step));
                }
            }
        }
    }

    /// Which equation gives way to `row`, which is exceeded: one that holds nothing, else the one whose multiplier is the
    /// first to reach zero.
    fn leaving(&self, row: usize) -> Option<usize> {
        let parts: Vec<f64> = self.inverse.iter().map(|v| dot(&self.rows[row].a, v).hi).collect();
        let least = PIVOT * parts.iter().fold(0.0, |largest, p| p.abs().max(largest));
        let free = (0..parts.len()).filter(|i| self.holders[*i] == Holder::Free && parts[*i].abs() > least);
        if let Some(place) = free.max_by(|i, j| parts[*i].abs().total_cmp(&parts[*j].abs())) {
            return Some(place);
        }
        let multiplier = |i: usize| -self.inverse[i][parts.len() - 1].hi;
        let ratio = |i: usize| multiplier(i).max(0.0) / parts[i];
        let falling = || (0..parts.len()).filter(|i| parts[*i] > least);
        let smallest = falling().map(ratio).fold(f64::INFINITY, f64::min);
        // Among equal ratios the largest part is the safest pivot.
        let equal = falling().filter(|i| ratio(*i) <= smallest * (1.0 + 1e-12));
        equal.max_by(|i, j| parts[*i].total_cmp(&parts[*j]))
    }

    /// Lets `row` take over an equation.
    fn exchange(&mut self, row: usize, place: usize, slacks: &mut Slacks) {
        let a = &self.rows[row].a;
        let parts: Vec<Double> = self.inverse.iter().map(|v| dot(a, v)).collect();
        let leaving: Vec<Double> = self.inverse[place].iter().map(|v| v.divide(parts[place])).collect();
        for (i, column) in self.inverse.iter_mut().enumerate().filter(|(i, _)| *i != place) {
            add_multiple(column, -parts[i], &leaving);
        }
        self.inverse[place] = leaving;
        self.holders[place] = Holder::Row(row);
        for products in &mut slacks.tableau {
            let along = products[place] / parts[place].hi;
            products.iter_mut().zip(&parts).for_each(|(product, part)| *product -= part.hi * along);
            products[place] = along;
        }
    }

    fn advance(&mut self, change: &[Double], slacks: &mut Slacks) {
        for (z, change) in self.z.iter_mut().zip(change) {
            *z = *z + *change;
        }
        slacks.age += 1;
        if slacks.age >= FRESH {
            self.refine();
            *slacks = self.slacks(!slacks.tableau.is_empty());
            return;
        }
        let change: Vec<f64> = change.iter().map(|c| c.hi).collect();
        for (slack, row) in slacks.list.iter_mut().zip(&self.rows) {
            *slack -= row.plain.iter().zip(&change).map(|(a, c)| a * c).sum::<f64>();
        }
    }

    /// Makes the equations hold to the last digits.
    fn refine(&mut self) {
        let miss = |holder: &Holder| if let Holder::Row(row) = holder { self.slack(*row) } else { Double::default() };
        let misses: Vec<Double> = self.holders.iter().map(miss).collect();
        for (miss, column) in misses.iter().zip(&self.inverse) {
            add_multiple(&mut self.z, *miss, column);
        }
    }
}

fn length(v: &[Double]) -> f64 {
    v.iter().map(|v| v.hi * v.hi).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::super::exact::numbers;
    use super::*;

    #[test]
    fn the_best_constant_of_three_numbers() {
        // min max |y − cᵢ| of 1, 4, 9 is 4 at y = 5.
        let mut program = Simplex::new(1, 0.0);
        for c in [1.0, 4.0, 9.0] {
            program.add(numbers(&[1.0, -1.0]), Double::from(c));
            program.add(numbers(&[-1.0, -1.0]), Double::from(-c));
        }
        assert!(program.descend(&numbers(&[0.0])));
        assert!((program.unknowns()[0].hi - 5.0).abs() < 1e-28 && (program.level().hi - 4.0).abs() < 1e-28);
        // y ≤ 4 moves it; so does the primal method from y = 0.
        program.add(numbers(&[1.0, 0.0]), Double::from(4.0));
        assert!(program.ascend(1e-25));
        assert!((program.level().hi - 5.0).abs() < 1e-28);
        assert!(program.descend(&numbers(&[0.0])));
        assert!((program.level().hi - 5.0).abs() < 1e-28);
    }

    #[test]
    fn an_unknown_that_nobody_asks_for_stays() {
        let mut program = Simplex::new(2, -9.0);
        program.add(numbers(&[1.0, 0.0, -1.0]), Double::from(-3.0));
        program.add(numbers(&[-1.0, 0.0, -1.0]), Double::from(1.0));
        assert!(program.descend(&numbers(&[0.0, 0.0])));
        assert!((program.level().hi - 1.0).abs() < 1e-28 && program.unknowns()[1].hi == 0.0);
    }
}
