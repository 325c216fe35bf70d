//! Places at which the law of a table has a jump of U, U′ or U″, and specks: neighbouring rows that are off together.
//!
//! Around every gap the lifts are fitted by a polynomial of degree 4, and by one whose derivatives of order k to 4 jump at a
//! place c. Each order is one more column, (φ − c)₊ᵏ, so one orthogonalisation gives the residual squares Rₖ of all of them.
//! U⁽ᵏ⁾ jumps if Rₖ at the best c is clearly below the best Rₖ₊₁, and no change over some rows fits as well. A speck is a block
//! of rows without which the polynomial through both sides fits much better.
//!
//! Source: G. A. F. Seber, A. J. Lee, *Linear Regression Analysis*, 2nd ed., Wiley 2003, sections 4.3 and 11.3.

use super::WrongRow;
use super::penalised::Rows;
use std::f64::consts::TAU;

/// Degree of the polynomials.
const DEGREE: usize = 4;

/// Rows on each side of a gap: somewhat more than twice the freedoms, and wide ones for noise that hides the law in few rows.
const WIDTHS: [usize; 4] = [8, 12, 18, 27];

/// A derivative jumps if this lowers the squares by this many times the remaining variance: smooth laws from 180 rows on have
/// up to 100 in the narrowest windows.
const CLEAR: f64 = 144.0;

/// A derivative may also change over this many gaps, or these parts of a short angle,
const BLENDS: [f64; 6] = [3.0, 4.0, 5.0, 6.5, 8.0, 12.0];

/// which is a quarter of the shortest ramp of an acceleration that differs from a jump among noise (rad),
const RAMP: f64 = 0.035;

/// and does not jump unless the squares are this many times larger.
const BLENDED: f64 = 1.5;

/// A jump is reported if a spline turns it into at least this part of the largest U″ nearby,
const RELEVANT: f64 = 0.5;

/// this angle to either side (rad),
const REACH: f64 = 0.35;

/// and this part of the largest U″ of all. Jumps of standard laws and of cams made of arcs are larger; ramps of smooth laws over few
/// rows look like less.
const LEAST: f64 = 0.2;

/// The largest mean distance of rows (rad) among which U″ may jump: ramps of smooth laws are shorter than a few longer ones.
const COARSE: f64 = TAU / 160.0;

/// Two rows at less than this part of the distance of those about them were measured as a pair.
const PAIR: f64 = 0.3;

/// A kink is reported from this many times those parts on: smooth laws of few rows have a quarter less, kinks of a clearance
/// many times more.
const KINK: f64 = 3.0;

/// Fits with up to this many times the variance of the noise are within it.
const WITHIN: f64 = 4.0;

/// The most rows of a speck.
const MOST_ROWS: usize = 20;

/// Its largest length (rad): over longer blocks the law itself changes.
const LONGEST: f64 = 0.2;

/// A block of up to 8 rows is a speck if its mean square from the polynomial is this many times the variance next to it; smooth
/// laws have at most a quarter of this, and more over longer blocks, by the square of their length.
const SPECK: f64 = 40.0;

/// A speck ends with rows that are off by this many σ.
const EDGE: f64 = 5.0;

/// A gap that is this many times its neighbours, between equal lifts, is a rest whose rows are missing.
const REST: f64 = 2.5;

/// Rows closer than this part of their mean distance are measured at one angle: no place between them can be resolved.
const SAME: f64 = 0.05;

/// Rounded or exact lifts have errors of at least this part of the stroke.
const EXACT: f64 = 1e-10;

/// A jump of U⁽ᵒʳᵈᵉʳ⁾.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Jump {
    /// Its angle (rad).
    pub angle: f64,
    /// 0: the lift, 1: U′, 2: U″.
    pub order: usize,
    /// Its size (m/radᵒʳᵈᵉʳ).
    pub by: f64,
    /// The gap in which it lies.
    gap: usize,
    /// The variance of the rows about the law with the jump, and the factor by which it is larger without any.
    variance: f64,
    better: f64,
}

impl Jump {
    /// A jump of U′ at a row.
    pub fn kink(angle: f64, by: f64, row: usize) -> Self {
        Self { angle, order: 1, by, gap: row, variance: 0.0, better: 0.0 }
    }

    /// True if both are the same jump, one of which may have been moved to a row.
    pub fn is_at(&self, other: &Jump) -> bool {
        (self.gap, self.order) == (other.gap, other.order)
    }
}

/// Neighbouring rows that are off together.
#[derive(Clone, Copy, Debug)]
struct Block {
    first: usize,
    rows: usize,
    variance: f64,
    times: f64,
}

/// Rows by angle, from a middle and in units of half of their length, and the polynomial through them.
struct Window {
    places: Vec<f64>,
    middle: f64,
    half: f64,
    fit: Fit,
}

/// Orthonormal columns, and the residual of the lifts.
#[derive(Clone)]
struct Fit {
    columns: Vec<Vec<f64>>,
    left: Vec<f64>,
}

fn product(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn take(from: &mut [f64], part: f64, of: &[f64]) {
    from.iter_mut().zip(of).for_each(|(x, y)| *x -= part * y);
}

impl Fit {
    /// The polynomial through lifts at these places.
    fn new(places: &[f64], lifts: Vec<f64>) -> Self {
        let mut fit = Fit { columns: Vec::new(), left: lifts };
        (0..=DEGREE).for_each(|k| {
            fit.add(places.iter().map(|x| x.powi(k as i32)).collect());
        });
        fit
    }

    /// Adds a column, and returns its factor.
    fn add(&mut self, mut column: Vec<f64>) -> f64 {
        let whole = product(&column, &column);
        // Once more against the roundings of the first time.
        for _ in 0..2 {
            for other in &self.columns {
                let part = product(other, &column);
                take(&mut column, part, other);
            }
        }
        let length = product(&column, &column).sqrt();
        // A column without a direction of its own explains nothing.
        if !(length > 1e-9 * whole.sqrt()) {
            return 0.0;
        }
        column.iter_mut().for_each(|x| *x /= length);
        let part = product(&column, &self.left);
        take(&mut self.left, part, &column);
        self.columns.push(column);
        part / length
    }

    fn squares(&self) -> f64 {
        product(&self.left, &self.left)
    }
}

impl Window {
    /// (φ − c)₊ᵏ.
    fn beyond(&self, c: f64, k: usize) -> Vec<f64> {
        let c = (c - self.middle) / self.half;
        self.places.iter().map(|x| if *x > c { (x - c).powi(k as i32) } else { 0.0 }).collect()
    }

    /// The squares left by laws whose derivatives from the order 5 (none), 4 … 0 to the fourth jump at `c`, and the jumps of
    /// these orders.
    fn jumping(&self, c: f64) -> [[f64; 2]; 6] {
        let (mut fit, mut found) = (self.fit.clone(), [[self.fit.squares(), 0.0]; 6]);
        for (order, found) in (0..=4).rev().zip(&mut found[1..]) {
            let factor = fit.add(self.beyond(c, order)) * (1..=order).product::<usize>() as f64;
            *found = [fit.squares(), factor / self.half.powi(order as i32)];
        }
        found
    }

    /// The squares left by the best law whose derivative of the order `next` jumps at two places, some rows apart around `c`.
    fn bending(&self, c: f64, next: usize, gap: f64) -> f64 {
        let places = BLENDS.into_iter().flat_map(|apart| [-1.0, -0.5, 0.0, 0.5, 1.0].map(|shift| [apart, shift]));
        let squares = places.map(|[apart, shift]| {
            let mut fit = self.fit.clone();
            [-0.5, 0.5].into_iter().for_each(|half| {
                fit.add(self.beyond(c + gap * (shift + half * apart), next));
            });
            (next + 1..=DEGREE).for_each(|k| {
                fit.add(self.beyond(c, k));
            });
            fit.squares()
        });
        squares.fold(f64::INFINITY, f64::min)
    }
}

impl Rows {
    /// The angle of a row counted on around the turn.
    fn angle(&self, i: i64) -> f64 {
        let n = self.angles.len();
        let (row, turn) = (i.rem_euclid(n as i64) as usize, i.div_euclid(n as i64));
        // The last rows may share the first knot, one turn earlier.
        let back = row > n / 2 && self.angles[row] < self.angles[n / 2];
        self.angles[row] + TAU * (turn + i64::from(back)) as f64
    }

    /// The rows, with additional ones in rests of which a table has only the ends, and the row before each of them.
    fn with_rests(&self) -> (Rows, Vec<Option<usize>>) {
        let n = self.lifts.len();
        let gap = |i: usize| self.angle((i % n) as i64 + 1) - self.angle((i % n) as i64);
        let (mut angles, mut lifts, mut rows) = (Vec::new(), Vec::new(), Vec::new());
        for i in 0..n {
            let (angle, [before, own, next]) = (self.angle(i as i64), [i + n - 1, i, i + 1].map(gap));
            angles.push(angle);
            lifts.push(self.lifts[i]);
            rows.push(Some(i));
            if self.lifts[i] == self.lifts[(i + 1) % n] && own > REST * before.min(next) {
                let count = ((own / before.min(next)) as usize - 1).min(2 * WIDTHS[WIDTHS.len() - 1]);
                angles.extend((1..=count).map(|k| angle + own * k as f64 / (count + 1) as f64));
                lifts.resize(angles.len(), self.lifts[i]);
                rows.resize(angles.len(), None);
            }
        }
        let n = angles.len();
        let knot = (0..n).collect();
        (Rows { knots: angles.clone(), angles, lifts, weights: vec![1.0; n], knot, unit: TAU / n as f64 }, rows)
    }

    fn window(&self, rows: impl Iterator<Item = i64> + Clone) -> Window {
        let n = self.lifts.len() as i64;
        let ends = [self.angle(rows.clone().next().unwrap_or(0)), self.angle(rows.clone().last().unwrap_or(0))];
        let (middle, half) = (0.5 * (ends[0] + ends[1]), 0.5 * (ends[1] - ends[0]));
        let lifts: Vec<f64> = rows.clone().map(|i| self.lifts[i.rem_euclid(n) as usize]).collect();
        let places: Vec<f64> = rows.map(|i| (self.angle(i) - middle) / half).collect();
        let fit = Fit::new(&places, lifts.iter().map(|lift| lift - lifts[0]).collect());
        Window { places, middle, half, fit }
    }

    /// The variance of the last digit, which is at most the least step of the lifts, and the variance of exact lifts.
    fn exact(&self) -> [f64; 2] {
        let mut sorted = self.lifts.clone();
        sorted.sort_by(f64::total_cmp);
        let least = EXACT * (sorted[sorted.len() - 1] - sorted[0]);
        let steps = sorted.windows(2).map(|pair| pair[1] - pair[0]).filter(|step| *step > least);
        [steps.fold(f64::INFINITY, f64::min).max(least), least].map(|step| step.powi(2) / 12.0)
    }

    /// The jumps of the law, and the rows of each speck with their distances from the law of the others.
    pub fn jumps_and_specks(&self) -> (Vec<Jump>, Vec<Vec<WrongRow>>) {
        if self.lifts.len() < 4 * WIDTHS[0] {
            return Default::default();
        }
        let (all, rows) = self.with_rests();
        let (jumps, blocks) = all.found();
        let own = |[row, by, variance]: [f64; 3]| {
            Some(WrongRow { index: rows[row as usize]?, by, times: by.abs() / variance.sqrt() })
        };
        let is_off = |row: &WrongRow| row.times >= EDGE;
        let speck = |block: &Block| {
            let mut speck: Vec<WrongRow> = all.off(block).into_iter().filter_map(own).collect();
            speck.truncate(speck.iter().rposition(is_off).map_or(0, |last| last + 1));
            speck.split_off(speck.iter().position(is_off).unwrap_or(0))
        };
        let specks = blocks.iter().map(speck);
        // Single rows are searched elsewhere.
        (jumps, specks.filter(|speck| speck.len() > 1).collect())
    }

    /// The jumps, and the blocks of rows that are off.
    fn found(&self) -> (Vec<Jump>, Vec<Block>) {
        let n = self.lifts.len();
        let [exact, least] = self.exact();
        let mut floor = exact;
        let mut jumps: Vec<Jump> = Vec::new();
        let (mut noise, mut rough) = (f64::INFINITY, Vec::new());
        for width in WIDTHS.into_iter().filter(|width| 4 * width <= n) {
            let freedom = (2 * width - DEGREE - 6) as f64;
            let window = |gap: usize| self.window((gap as i64 + 1 - width as i64)..(gap as i64 + 1 + width as i64));
            if width == WIDTHS[0] {
                let variances: Vec<f64> = (0..n).map(|gap| window(gap).fit.squares() / (freedom + 5.0)).collect();
                let part = |above: f64, of: usize| {
                    let mut moving: Vec<f64> = variances.iter().copied().filter(|variance| *variance > above).collect();
                    moving.sort_by(f64::total_cmp);
                    moving.get(moving.len() / of).copied()
                };
                noise = part(exact, 2).unwrap_or(exact);
                // Equal rows of a rise and a return make steps of exact lifts that are no digits.
                floor = part(0.0, 4).map_or(exact, |quarter| quarter.max(least)).min(exact);
                rough = variances.into_iter().map(|variance| variance > noise).collect();
            }
            let fits = |jump: &Jump| width == WIDTHS[0] || jump.variance <= WITHIN * noise;
            // A lower order always explains somewhat more.
            let explains = |jump: &Jump| jump.better * (1.0 + CLEAR / freedom).powi(jump.order as i32);
            // Below the least step of the lifts only U″ shows its jumps: next to kinks the fits are worse than exact.
            let sought = |gap: usize, floor: f64| self.jump(gap, &window(gap), [floor, noise], freedom).filter(fits);
            let finer = |gap: usize| sought(gap, floor).filter(|jump| jump.order == 2);
            let all: [Vec<Jump>; 2] =
                [(0..n).filter_map(|gap| sought(gap, exact)).collect(), (0..n).filter_map(finer).collect()];
            for mut found in all {
                found.sort_by(|a, b| explains(b).total_cmp(&explains(a)));
                for jump in found {
                    let near = |other: &Jump| self.apart(jump.gap, other.gap) < width;
                    if jumps.iter().any(near) {
                        continue;
                    }
                    let beside = (0..5).map(|i| (jump.gap + n + i - 2) % n).filter(|_| jump.order == 2);
                    let finest = beside.filter_map(finer).max_by(|a, b| explains(a).total_cmp(&explains(b)));
                    jumps.push(finest.unwrap_or(jump));
                }
            }
        }
        let specks = self.specks([exact, noise], &rough, &mut jumps);
        let bends = self.bends();
        let largest = |near: &dyn Fn(usize) -> bool| {
            bends.iter().enumerate().filter(|(i, _)| near(*i)).fold(0.0_f64, |most, (_, bend)| most.max(bend.abs()))
        };
        let all = largest(&|_| true);
        let relevant = |jump: &Jump| {
            if jump.order == 2 && self.unit > COARSE || self.is_paired(jump.gap) {
                return false;
            }
            let reach = (REACH / self.unit) as usize;
            let local = largest(&|i| self.apart(i, jump.gap) <= reach);
            let factor = if jump.order < 2 { KINK } else { 1.0 };
            self.bend_of(jump) >= factor * (RELEVANT * local).max(LEAST * all)
        };
        jumps.retain(relevant);
        let first = self.angles[0];
        jumps.iter_mut().for_each(|jump| jump.angle = first + (jump.angle - first).rem_euclid(TAU));
        jumps.sort_by(|a, b| a.angle.total_cmp(&b.angle));
        (jumps, specks)
    }

    /// The rows between two of them.
    fn apart(&self, i: usize, j: usize) -> usize {
        let n = self.lifts.len();
        (i + n - j).rem_euclid(n).min((j + n - i).rem_euclid(n))
    }

    /// True if rows around a gap are so close that a wrong one looks like a jump.
    fn is_paired(&self, gap: usize) -> bool {
        let gap = gap as i64;
        let mean = (self.angle(gap + 5) - self.angle(gap - 4)) / 9.0;
        (gap - 4..gap + 5).any(|i| self.angle(i + 1) - self.angle(i) < PAIR * mean)
    }

    /// U″ at each row, over eight of them.
    fn bends(&self) -> Vec<f64> {
        let n = self.lifts.len() as i64;
        let lift = |i: i64| self.lifts[i.rem_euclid(n) as usize];
        let slope = |i: i64| (lift(i + 4) - lift(i)) / (self.angle(i + 4) - self.angle(i));
        (0..n).map(|i| 2.0 * (slope(i) - slope(i - 4)) / (self.angle(i + 4) - self.angle(i - 4))).collect()
    }

    /// The U″ into which a spline turns the jump; rows closer than most show no larger one.
    fn bend_of(&self, jump: &Jump) -> f64 {
        let gap = jump.gap as i64;
        let length = (self.angle(gap + 1) - self.angle(gap)).max(self.unit);
        jump.by.abs() / length.powi(2 - jump.order as i32)
    }

    /// The jump in or next to a gap, if any.
    fn jump(&self, gap: usize, window: &Window, [exact, noise]: [f64; 2], freedom: f64) -> Option<Jump> {
        let [from, to] = [self.angle(gap as i64), self.angle(gap as i64 + 1)];
        let (floor, length) = (exact * freedom, to - from);
        if length <= SAME * self.unit {
            return None;
        }
        let first = window.jumping(0.5 * (from + to));
        let clear = 1.0 + CLEAR / freedom;
        // Wide windows are for noise alone.
        let wide = window.places.len() > 2 * WIDTHS[0] && first[5][0] > WITHIN * noise * freedom;
        if wide || first[0][0] + floor < clear * (first[5][0] + floor) {
            return None;
        }
        let look = |best: &mut [[f64; 3]; 6], c: f64| {
            for (best, [left, by]) in best.iter_mut().zip(window.jumping(c)) {
                if left + floor < best[0] {
                    *best = [left + floor, c, by];
                }
            }
        };
        let mut best = [[f64::INFINITY, 0.5 * (from + to), 0.0]; 6];
        (-2..=18).step_by(2).for_each(|part| look(&mut best, from + length * f64::from(part) / 16.0));
        // The best places of all orders, in ever smaller steps.
        let likely = (0..3).find(|order| best[4 - order][0] >= (1.0 + 0.3 * CLEAR / freedom) * best[5 - order][0])?;
        for order in likely..=(likely + 1).max(3) {
            let mut step = length / 16.0;
            for _ in 0..9 {
                let middle = best[5 - order][1];
                (-3..=3).for_each(|part| look(&mut best, middle + step * f64::from(part)));
                step *= 0.25;
            }
        }
        let order = (0..3).find(|order| best[4 - order][0] >= clear * best[5 - order][0])?;
        let [left, angle, by] = best[5 - order];
        let noisy = noise > exact && left <= WITHIN * noise * freedom;
        let unit = if noisy { length.max(RAMP) } else { length };
        if order > 0 && window.bending(angle, order + 1, unit) + floor < BLENDED * left {
            return None;
        }
        Some(Jump { angle, order, by, gap, variance: left / freedom, better: best[0][0] / left })
    }

    /// Specks of two rows and more; removes jumps that are their borders.
    fn specks(&self, [exact, noise]: [f64; 2], rough: &[bool], jumps: &mut Vec<Jump>) -> Vec<Block> {
        let (n, beside) = (self.lifts.len(), WIDTHS[0]);
        let freedom = (2 * beside - DEGREE - 1) as f64;
        let mut found: Vec<Block> = Vec::new();
        let most = MOST_ROWS.min((LONGEST / self.unit) as usize);
        for rows in (2..=most).filter(|rows| 2 * (rows + 2 * beside) <= n) {
            // Next to a speck no polynomial is as close as elsewhere.
            for first in (0..n).filter(|first| rough[(first + n - 1) % n] || rough[(first + rows - 1) % n]) {
                let (start, end) = (first as i64, (first + rows) as i64);
                let all = (start - beside as i64)..(end + beside as i64);
                let others =
                    self.window(all.clone().filter(|i| *i < start || *i >= end)).fit.squares() + exact * freedom;
                let whole = self.window(all).fit.squares() + exact * (freedom + rows as f64);
                let variance = others / freedom;
                // More rows than these determine the variance of noise.
                let known = if variance <= WITHIN * noise { variance.max(noise) } else { variance };
                let times = (whole - others).max(0.0) / rows as f64 / known;
                if times >= SPECK * (rows as f64 / beside as f64).max(1.0).powi(2) {
                    found.push(Block { first, rows, variance, times });
                }
            }
        }
        found.sort_by(|a, b| b.times.total_cmp(&a.times));
        let mut specks: Vec<Block> = Vec::new();
        for speck in found {
            let middle = (speck.first + speck.rows / 2) % n;
            let reach = speck.rows / 2 + beside;
            let overlaps = |other: &Block| {
                let apart = self.apart(middle, (other.first + other.rows / 2) % n);
                apart <= speck.rows / 2 + other.rows / 2 + beside
            };
            let better = |jump: &Jump| {
                jump.order > 0
                    && self.apart(middle, jump.gap) <= reach
                    && jump.variance < (2.0 * speck.variance).max(WITHIN * noise.max(exact))
            };
            if specks.iter().any(overlaps) || jumps.iter().any(better) {
                continue;
            }
            jumps.retain(|jump| self.apart(middle, jump.gap) > reach);
            specks.push(speck);
        }
        specks
    }

    /// The rows of a speck: index, distance from the polynomial through both sides, variance.
    fn off(&self, speck: &Block) -> Vec<[f64; 3]> {
        let n = self.lifts.len() as i64;
        let (start, end, beside) = (speck.first as i64, (speck.first + speck.rows) as i64, WIDTHS[0] as i64);
        // In addition to the polynomial each row that is off has its own column, whose factor is its distance.
        let distance = |row: i64| {
            let others = (start - beside..end + beside).filter(|i| !(start..end).contains(i) || *i == row);
            let mut window = self.window(others.clone());
            window.fit.add(others.map(|i| if i == row { 1.0 } else { 0.0 }).collect())
        };
        (start..end).map(|row| [row.rem_euclid(n) as f64, distance(row), speck.variance]).collect()
    }
}
