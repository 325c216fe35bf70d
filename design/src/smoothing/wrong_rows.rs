//! The choice of λ, and the rows that a smooth law cannot have.
//!
//! λ has the least robust cross-validation, V (γ + (1 − γ) tr H²/n) of V = n Σ r²/(n − tr H)², whose second factor keeps it from
//! following the noise, or, where σ is known, the least of Mallows' Σ r² + 2 σ² tr H. Since ∂H/∂ ln λ = −H (I − H), tr H² follows from
//! the traces of neighbouring λ.
//!
//! A row is suspected by likelihood: of the curve as a process of white jerk −2 ln L = (n − 1) ln P − ln det₊(I − H), P the
//! minimum, which without row i is P − rᵢ²/(1 − hᵢ), the determinant divided by 1 − hᵢ; the most likely pair of λ and row is
//! taken out, and the next one looked for.
//!
//! Source: M. A. Lukas, *Robust generalized cross-validation for choosing the regularization parameter*, Inverse Problems
//! 22 (2006) 1883–1902; G. Wahba, *Spline Models for Observational Data*, SIAM 1990, sections 4.7 and 4.8.

use super::Outliers;
use super::jumps::Jump;
use super::penalised::Rows;
use std::f64::consts::TAU;

/// Step of the logarithm of the order: the errors are so flat about their least that a tenth does not matter.
const STEP: f64 = 0.2;

/// The order is this much above the best one: the largest errors, next to jumps of U″, then fall by a tenth and the mean ones
/// rise by a fiftieth.
const MARGIN: f64 = 1.05;

/// γ of the robust cross-validation.
const ROBUST: f64 = 0.4;

/// Suspects are taken out from this many σ on; the largest among a few hundred clean rows has as much.
const SUSPECT: f64 = 3.5;

/// A jump of U′ or U″ explains the distance of a row if it explains this much more than leaving the row out; for few wrong rows
/// it explains up to 1.2 times as much.
const JUMP: f64 = 1.2;

/// Rows this close to one next to a jump of U′ or U″ are not wrong, either.
const NEAR: usize = 4;

/// The most suspects.
const MOST_SUSPECTS: usize = 8;

/// A row is wrong from this many σ on: clean tables have at most 5, a row that is wrong by 10 σ has 6 … 10.
pub const WRONG: f64 = 5.5;

/// It is also this many σ from the best law whose U″ jumps nearby. Next to a jump clean rows have up to 9 without it, 3 with
/// it. The second value is for an estimated σ with few rows for their motion, clean ones of which have up to 6.
const WRONG_AT_JUMP: [f64; 2] = [3.5, 6.5];

/// Rows are few if the others determine the lift with a variance above σ² times this,
const MOST_VARIANCE: f64 = 1.5;

/// or if the curve has more than this many freedoms per row.
const MOST_FREEDOM: f64 = 0.6;

/// Errors below this part of the stroke are ignored: a table of exact lifts has no noise to compare them with.
const LEAST_PART: f64 = 1e-4;

/// If rows are few, one that is off by more than this part of the stroke may be the only row of a short motion.
const MOTION: f64 = 0.03;

/// Few rows do not determine σ if the curve goes through them. A row is then wrong if it is off by this many times the distance
/// of the rows around it from the curve without each of them; in 2400 exact tables a row of a short motion has up to 22.
const CLEAR: f64 = 30.0;

/// It is also off by more than this many of the last digits, because rounded lifts of a rest are equal but for one digit.
const DIGITS: f64 = 3.0;

/// A given σ counts as the rows' if the estimated one is at most this many times as large.
const TRUSTED: f64 = 1.5;

/// A row that is off by this many σ may lie at a kink, which no noise hides.
const ALONE: f64 = 100.0;

/// It is wrong if it is off by this many times the distance of the rows around it from the curve without each of them: at kinks
/// a right row has up to 7, and nearly all wrong ones have more than 50.
const CONFIRMED: f64 = 8.0;

/// The largest mean distance of rows (rad) for jumps and specks: with fewer rows the ramps of smooth laws look like them.
const SPARSE: f64 = TAU / 90.0;

/// Lifts that differ by less than this part of the stroke are the same.
const LEAST_STEP: f64 = 1e-9;

/// A wrong row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WrongRow {
    /// Its index in the table.
    pub index: usize,
    /// Its lift minus the lift of the law through the others.
    pub by: f64,
    /// The same in units of σ.
    pub times: f64,
}

/// Faulty and strange rows of a table.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TableFaults {
    /// Rows that are wrong.
    pub wrong: Vec<WrongRow>,
    /// The rows of each speck that is not left out: neighbours that are off together.
    pub specks: Vec<Vec<WrongRow>>,
    /// Jumps of the law.
    pub jumps: Vec<Jump>,
}

/// The judgement of the curves of all λ.
pub struct Look {
    /// The best order.
    pub order: f64,
    /// σ of the noise about its curve.
    pub noise: f64,
    /// tr H.
    pub freedom: f64,
    suspect: Suspect,
}

/// The row that is most likely wrong.
#[derive(Clone, Copy)]
struct Suspect {
    index: usize,
    /// Its distance in σ from the curve without it; the curve's σ and order.
    times: f64,
    sigma: f64,
    order: f64,
}

impl Rows {
    /// The best order, for known or estimated noise, and the most suspicious row.
    pub fn look(&self, noise: Option<f64>) -> Look {
        let n: f64 = self.weights.iter().sum();
        let last = ((2 * self.knots.len()) as f64).ln() / STEP;
        let orders: Vec<f64> = (0..=last as usize).map(|i| (STEP * i as f64).exp()).collect();
        let (mut likely, mut suspect) = (f64::INFINITY, Suspect { index: 0, times: 0.0, sigma: 0.0, order: 1.0 });
        let mut sums = Vec::new();
        for order in &orders {
            let fit = self.fit(&self.lifts, *order);
            let (mut squares, mut trace) = (0.0, 0.0);
            for i in (0..self.lifts.len()).filter(|i| self.weights[*i] > 0.0) {
                let (residual, rest) = (fit.residuals[i], 1.0 - fit.leverages[i]);
                squares += residual * residual;
                trace += fit.leverages[i];
                let least = fit.least - residual * residual / rest;
                let value = (n - 2.0) * least.ln() - fit.log + rest.ln();
                if value < likely {
                    let sigma = (least / (n - 2.0)).sqrt();
                    let times = residual.abs() / rest.sqrt() / sigma;
                    (likely, suspect) = (value, Suspect { index: i, times, sigma, order: *order });
                }
            }
            sums.push([squares, trace]);
        }
        let criterion = |i: usize| {
            let [squares, trace] = sums[i];
            if let Some(noise) = noise {
                return squares + 2.0 * noise * noise * trace;
            }
            let (low, high) = (i.saturating_sub(1), (i + 1).min(sums.len() - 1));
            let product = (sums[high][1] - sums[low][1]) / (6.0 * STEP * (high - low) as f64);
            squares / (n - trace).powi(2) * (ROBUST + (1.0 - ROBUST) * (trace - product).max(0.0) / n)
        };
        let finite = (0..sums.len()).filter(|i| criterion(*i).is_finite());
        let best = finite.min_by(|i, j| criterion(*i).total_cmp(&criterion(*j))).unwrap_or(0);
        // The minimum of the parabola through it and its neighbours.
        let [low, high] = [best.saturating_sub(1), (best + 1).min(sums.len() - 1)].map(&criterion);
        let shift = 0.5 * (low - high) / (low - 2.0 * criterion(best) + high);
        let shift = if shift.abs() <= 1.0 { STEP * shift } else { 0.0 };
        let [squares, freedom] = sums[best];
        Look { order: MARGIN * orders[best] * shift.exp(), noise: (squares / (n - freedom)).sqrt(), freedom, suspect }
    }

    /// Gives the rows `at_rest` the level L that minimises the minimum, a square of lifts y + L e with e = 1 for these rows:
    /// with the residuals r of y and rₑ of e, L = −Σ e r/Σ e rₑ.
    pub fn settle(&mut self, noise: Option<f64>, at_rest: &[usize]) {
        let order = self.look(noise).order;
        let mut rest = vec![0.0; self.lifts.len()];
        at_rest.iter().for_each(|row| rest[*row] = 1.0);
        let sum = |residuals: Vec<f64>| at_rest.iter().map(|row| residuals[*row]).sum::<f64>();
        let level = -sum(self.fit(&self.lifts, order).residuals) / sum(self.fit(&rest, order).residuals);
        at_rest.iter().for_each(|row| self.lifts[*row] += level);
    }

    /// Leaves wrong rows out, for known or estimated noise, and returns its findings. Rows next to a jump of the law are right.
    pub fn leave_out_wrong(&mut self, noise: Option<f64>, outliers: Outliers) -> TableFaults {
        let n = self.lifts.len();
        let law = outliers != Outliers::DropOfCurve;
        let (mut jumps, mut specks) = if law { self.jumps_and_specks() } else { Default::default() };
        if self.unit > SPARSE {
            specks.clear();
        }
        let mut wrong = if outliers == Outliers::Drop { std::mem::take(&mut specks).concat() } else { Vec::new() };
        wrong.iter().for_each(|row| self.weights[row.index] = 0.0);
        let at_kink = |index: usize| {
            let apart = |jump: &Jump| {
                let angle = (self.angles[index] - jump.angle + 0.5 * TAU).rem_euclid(TAU) - 0.5 * TAU;
                jump.order > 0 && angle.abs() <= NEAR as f64 * self.unit
            };
            jumps.iter().any(apart)
        };
        let kinks: Vec<bool> = (0..n).map(at_kink).collect();
        let (mut suspects, mut bends): (Vec<usize>, Vec<usize>) = Default::default();
        let mut look = self.look(None);
        while look.suspect.times >= SUSPECT && suspects.len() + bends.len() < MOST_SUSPECTS.min(n / 16) {
            let Suspect { index, order, .. } = look.suspect;
            let beside = |bend: &usize| (index + n - bend + NEAR) % n <= 2 * NEAR;
            let bend = kinks[index] || bends.iter().any(beside) || self.beside_jump(index, order)[1] >= JUMP;
            if bend { &mut bends } else { &mut suspects }.push(index);
            self.weights[index] = 0.0;
            look = self.look(None);
        }
        bends.iter().for_each(|index| self.weights[*index] = 1.0);
        let mut sorted = self.lifts.clone();
        sorted.sort_by(f64::total_cmp);
        let range = sorted[n - 1] - sorted[0];
        let steps = sorted.windows(2).map(|pair| pair[1] - pair[0]).filter(|step| *step > LEAST_STEP * range);
        let digit = steps.fold(range, f64::min);
        // Lifts that equal their neighbours belong to an unmeasured rest, or are rounded.
        let same = |i: &usize| [1, n - 1].iter().all(|to| self.lifts[(i + to) % n] == self.lifts[*i]);
        let told = n - (0..n).filter(same).count();
        let mut sigma = look.noise.max(look.suspect.sigma) * (n as f64 / told as f64).sqrt();
        let few = |look: &Look| look.freedom > MOST_FREEDOM * n as f64;
        let known = noise.filter(|noise| sigma <= TRUSTED * noise);
        if let Some(noise) = known {
            (look, sigma) = (self.look(known), noise);
        }
        let fit = self.fit(&self.lifts, look.order);
        let off = |i: usize| fit.residuals[i].abs() / (1.0 - fit.leverages[i]).sqrt();
        if self.unit > SPARSE {
            jumps.clear();
        }
        // There is no kink between equal lifts.
        let in_rest = |i: usize| [2, n - 1, n - 2].iter().all(|to| self.lifts[(i + to) % n] == self.lifts[(i + 1) % n]);
        for index in suspects.iter().copied() {
            let (by, variance) = (fit.residuals[index], fit.leverages[index]);
            let distance = by.abs() / (1.0 + variance).sqrt();
            let near = (1..=NEAR).flat_map(|d| [(index + d) % n, (index + n - d) % n]);
            let right = |i: &usize| self.weights[*i] > 0.0 && !suspects.contains(i);
            let most = near.filter(right).map(off).fold(0.0, f64::max);
            self.weights[index] = 1.0;
            let few = few(&look) || variance > MOST_VARIANCE;
            let clear = few && distance >= CLEAR * most && by.abs() > DIGITS * digit;
            let far = distance >= WRONG * sigma && !(few && by.abs() > MOTION * range);
            let at_jump = WRONG_AT_JUMP[usize::from(few && known.is_none())];
            if by.abs() > LEAST_PART * range
                && (clear || far && self.beside_jump(index, look.order)[0] >= at_jump * sigma)
            {
                let row = WrongRow { index, by, times: by.abs() / sigma };
                if law && row.times >= ALONE && distance < CONFIRMED * most && !in_rest(index) {
                    jumps.push(self.kink(index));
                } else {
                    wrong.push(row);
                }
            }
        }
        wrong.iter().for_each(|row| self.weights[row.index] = 0.0);
        wrong.sort_by_key(|row| row.index);
        jumps.sort_by(|a, b| a.angle.total_cmp(&b.angle));
        TableFaults { wrong, specks, jumps }
    }

    /// The kink at a row, from the slopes next to it.
    fn kink(&self, row: usize) -> Jump {
        let n = self.lifts.len();
        let slope = |from: usize| {
            let (from, to) = (from % n, (from + 1) % n);
            (self.lifts[to] - self.lifts[from]) / (self.angles[to] - self.angles[from]).rem_euclid(TAU)
        };
        Jump::kink(self.angles[row], slope(row) - slope(row + n - 1), row)
    }

    /// The least distance of row `index`, over its standard deviation by σ, from a law whose U″ jumps near its knot; and the
    /// ratio of the decreases of the minimum by a jump of U″ or U′ and by leaving out the row.
    ///
    /// x³ − 3x²/2 + x/2, continued periodically, is a law whose U″ jumps once; x² − x one whose U′ does. With the residuals r
    /// of its values b, h = Σ w b r, and p = Σ w b rᵧ for the residuals rᵧ of the lifts, the residuals of lifts and jump are rᵧ
    /// − r p/h, and their minimum is lower by p²/h.
    fn beside_jump(&self, index: usize, order: f64) -> [f64; 2] {
        let (m, fit) = (self.knots.len() as i64, self.fit(&self.lifts, order));
        let own = fit.residuals[index].powi(2) / (1.0 - fit.leverages[index]);
        let knot = |half: i64| self.knots[(self.knot[index] as i64 + half.div_euclid(2)).rem_euclid(m) as usize];
        let mut found = [f64::INFINITY, 0.0_f64];
        for half in -3..=3 {
            let place = knot(half) + 0.5 * (knot(half + 1) - knot(half)).rem_euclid(TAU);
            for second in [false, true] {
                let law = |x: f64| x * (x - 1.0) * if second { x - 0.5 } else { 1.0 };
                let jump: Vec<f64> =
                    self.angles.iter().map(|angle| law(((angle - place) / TAU).rem_euclid(1.0))).collect();
                let other = self.fit(&jump, order);
                let product: f64 = (0..jump.len()).map(|i| self.weights[i] * jump[i] * fit.residuals[i]).sum();
                found[1] = found[1].max(product * product / other.least / own);
                if second {
                    let residual = fit.residuals[index] - product / other.least * other.residuals[index];
                    let rest = 1.0 - fit.leverages[index] - other.residuals[index].powi(2) / other.least;
                    found[0] = found[0].min(residual.abs() / rest.sqrt());
                }
            }
        }
        found
    }
}
