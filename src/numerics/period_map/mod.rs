//! Linear oscillations with periodic coefficients, solved once per period:
//!
//! q̈ + d(τ) q̇ + k(τ) q = g(τ),  d, k, g of period T.
//!
//! The period is divided into cells. In each of them the two free motions from (q, q̇) = (1, 0) and (0, 1) and the forced motion
//! from rest are tabulated as polynomials, so that every solution is, in every period, a combination of these three: (q, q̇) at any
//! time of a cell follows from (q, q̇) at its start. The polynomials count from the start of their own cell, so a solution that
//! grows or decays by any factor over the period keeps its relative accuracy, and an unstable one its accuracy relative to the
//! growing envelope. Over n whole periods the affine map of one period is applied n times, by repeated squaring, so a step over any
//! number of periods costs O(log n).
//!
//! The tables come from Gauss collocation with twelve nodes (module `cell`): at the ends of a cell of order 24, within it of order
//! 13. The lengths of the cells are chosen so that the polynomials keep the tolerance. If the free motion vibrates fast, its phase
//! and the part that does not vibrate are tabulated instead (module `vibration`), in cells as long as the coefficients allow, so
//! that a stiffer equation costs no more.
//!
//! Source: E. Hairer, G. Wanner, *Solving Ordinary Differential Equations II*, 2nd ed., Springer 1996, section IV.5;
//! V. A. Yakubovich, V. M. Starzhinskii, *Linear Differential Equations with Periodic Coefficients*, Wiley 1975.

mod cell;
mod floquet;
mod nodes;
#[cfg(test)]
mod tests;
mod vibration;

use super::collocation::UNBOUNDED;
use super::double_double::{Double, two_product};
use cell::{Cell, Motions};
pub use floquet::{Monodromy, fixed_point, is_resonant, spectral_radius};
pub use nodes::STAGES;
use serde::{Deserialize, Serialize};

/// Cells beyond which no table is made: some 2 MB, computed in about 10 ms.
const MOST_CELLS: usize = 4096;

/// Cells beyond which a period is not computed: a third of a second.
const MOST_CELLS_UNTABULATED: usize = 50_000;

/// A cell shorter than this part of the period means that no cell keeps the tolerance.
const SHORTEST_CELL: f64 = 1e-9;

/// Periods beyond which a time no longer determines the place of the motion in its period.
const MOST_PERIODS: u64 = 1 << 52;

/// Least error of the end of a cell: some roundings.
const ROUNDING: f64 = 2.0 * f64::EPSILON;

/// Coefficients of a polynomial of q: degree [`STAGES`] + 1.
const COEFFICIENTS: usize = STAGES + 2;

/// d, k and g at an instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coefficients {
    /// d (1/s).
    pub damping: f64,
    /// k (1/s²).
    pub stiffness: f64,
    /// g, (unit of q/s²).
    pub forcing: f64,
}

/// A linear equation with periodic coefficients.
pub trait Periodic {
    /// T (s).
    fn period(&self) -> Double;

    /// Ends of the intervals within which the coefficients are smooth (s), ascending in (0, T]; the last one is T.
    fn joints(&self) -> Vec<Double>;

    /// The coefficients at `tau` (s) from the start of the period, continued smoothly from the interval that ends at
    /// the joint of this index.
    fn at(&self, tau: Double, interval: usize) -> Coefficients;

    /// By how much q̇ jumps (unit of q/s) at the joint of this index, `tau` (s) from the start of the period.
    fn jump(&self, _tau: Double, _interval: usize) -> f64 {
        0.0
    }

    /// The longest cell from `tau` (s) on (s); a longer one could hide something between its nodes.
    fn longest_cell(&self, tau: Double, interval: usize) -> f64;

    /// Draws the work of so many evaluations; None if no work is left. A study takes as much as it needs.
    fn draw(&self, _evaluations: usize) -> Option<()> {
        Some(())
    }

    /// Whether fast vibrations may be tabulated by their phase: its error is ε times the radians that it passes.
    fn by_phase(&self) -> bool {
        true
    }
}

/// y ↦ matrix y + shift, y = (q, q̇).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Affine {
    /// The homogeneous part.
    pub matrix: [[f64; 2]; 2],
    /// The image of (0, 0).
    pub shift: [f64; 2],
}

/// A period as a whole.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Period {
    /// From its start to its end; not finite if free motions exceed the range of numbers.
    pub map: Affine,
    /// The homogeneous part, whatever its size.
    pub monodromy: Monodromy,
    /// The largest estimated error of a polynomial, relative to the motion in its cell.
    pub error: f64,
    /// Accumulated error at the ends of the cells, relative to the motion.
    pub drift: f64,
    /// Evaluations of the coefficients.
    pub evaluations: usize,
}

/// The tables of one period.
#[derive(Clone, Debug, PartialEq)]
pub struct PeriodMap {
    period: Double,
    cells: Vec<Cell>,
    whole: Period,
}

/// A solution on its way through the periods.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Trajectory {
    /// The start of the motion (s), and how many periods later the present one starts.
    origin: f64,
    periods: u64,
    /// The start of the present period (s).
    period_start: Double,
    /// The present cell, its start (s), the inverse of half its length (1/s) if it is a cell of polynomials, and (q, q̇) at its
    /// start.
    cell: usize,
    start: Double,
    rate: f64,
    state: [f64; 2],
    /// Coefficients of q and q̇ in powers of x ∈ [−1, 1].
    polynomial: [[f64; 2]; COEFFICIENTS],
    /// Cells and maps over several periods so far.
    pub steps: u64,
}

/// The solution left the range of numbers in which it can continue.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unbounded {
    /// The time (s).
    pub time: f64,
}

impl Affine {
    /// No change.
    pub const IDENTITY: Affine = Affine { matrix: [[1.0, 0.0], [0.0, 1.0]], shift: [0.0, 0.0] };

    /// The image of `y`.
    pub fn at(&self, y: [f64; 2]) -> [f64; 2] {
        let [[a, b], [c, d]] = self.matrix;
        [a * y[0] + b * y[1] + self.shift[0], c * y[0] + d * y[1] + self.shift[1]]
    }

    /// This map after `first`.
    pub fn after(&self, first: &Affine) -> Affine {
        let [[a, b], [c, d]] = self.matrix;
        let [[e, f], [g, h]] = first.matrix;
        Affine { matrix: [[a * e + b * g, a * f + b * h], [c * e + d * g, c * f + d * h]], shift: self.at(first.shift) }
    }
}

impl Period {
    /// Estimated error after so many periods, relative to the motion: the error of the polynomials, times `reserve`, and the error
    /// of the map of the period, as often as a motion whose largest multiplier has this modulus remembers it.
    pub fn error_after(&self, periods: f64, reserve: f64, multiplier: f64) -> f64 {
        // 1/(1 − ρ) is the sum of all ρⁿ.
        let memory = if multiplier < 1.0 { 1.0 / (1.0 - multiplier) } else { f64::INFINITY };
        reserve * (self.error + ROUNDING) + self.drift * periods.min(memory)
    }

    /// The period without tables; None if it takes more than 50 000 cells or more work than is left.
    pub fn of(equation: &dyn Periodic, tolerance: f64) -> Option<Self> {
        let mut count = 0;
        Self::divide(equation, tolerance, &mut |_| {
            count += 1;
            count < MOST_CELLS_UNTABULATED
        })
    }

    /// Hands the cells to `take`, which says whether there is room for more. None if there is not, if the work is used up, if no
    /// cell keeps the tolerance or if a coefficient is not finite.
    fn divide(equation: &dyn Periodic, tolerance: f64, take: &mut dyn FnMut(Cell) -> bool) -> Option<Self> {
        let period = equation.period();
        let (map, monodromy) = (Affine::IDENTITY, Monodromy::IDENTITY);
        let mut whole = Period { map, monodromy, error: 0.0, drift: 0.0, evaluations: 0 };
        // Roundings differ in sign from cell to cell but repeat from period to period.
        let mut roundings: f64 = 0.0;
        let mut start = Double::default();
        let mut room = true;
        for (interval, joint) in equation.joints().into_iter().enumerate() {
            let mut lengths = Lengths::new(start);
            while (joint - start).hi > 0.0 {
                let remaining = (joint - start).hi;
                let longest = equation.longest_cell(start, interval);
                let fast = lengths.fast(equation, interval, start, longest.min(remaining));
                let wish = if fast { lengths.fast } else { lengths.polynomial };
                let length = share(wish.min(longest), remaining);
                // NaN is no length either.
                if !(length > SHORTEST_CELL * period.hi || length >= remaining) || !room {
                    return None;
                }
                whole.evaluations += cell::EVALUATIONS;
                equation.draw(cell::EVALUATIONS)?;
                let (mut cell, damping) = if fast {
                    let Some((cell, damping, errors)) = Cell::vibrating(equation, interval, start, length) else {
                        lengths.fast = 0.5 * length;
                        continue;
                    };
                    let vibration::Errors { excess, polynomials, rounding } = errors;
                    lengths.fast = length * cell::growth(excess, 1.0);
                    if !(excess <= 1.0) {
                        continue;
                    }
                    whole.error = whole.error.max(polynomials);
                    whole.drift += polynomials + rounding;
                    (cell, damping)
                } else {
                    let Some((cell, damping, error)) = Cell::solve(equation, interval, start, length) else {
                        lengths.polynomial = 0.25 * length;
                        continue;
                    };
                    lengths.polynomial = length * cell::growth(error, tolerance);
                    if !(error <= tolerance) {
                        continue;
                    }
                    whole.error = whole.error.max(error);
                    // The polynomial has order 13, its end order 24.
                    whole.drift += error.powf((2 * STAGES) as f64 / (STAGES + 1) as f64);
                    (cell, damping)
                };
                if length == remaining {
                    cell.map.shift[1] += equation.jump(joint, interval);
                }
                whole.map = cell.map.after(&whole.map);
                whole.monodromy.go_on(&cell.map.matrix, damping);
                roundings += ROUNDING * ROUNDING;
                room = take(cell);
                // The last cell of an interval ends on the joint itself.
                start = if length == remaining { joint } else { start + Double::from(length) };
            }
        }
        whole.drift += roundings.sqrt();
        Some(whole)
    }
}

impl PeriodMap {
    /// The tables with the relative `tolerance`; None if they need more than 4096 cells or more work than is left, or if a
    /// coefficient is not finite.
    pub fn new(equation: &dyn Periodic, tolerance: f64) -> Option<Self> {
        let mut cells = Vec::new();
        let whole = Period::divide(equation, tolerance, &mut |cell| {
            cells.push(cell);
            cells.len() < MOST_CELLS
        })?;
        cells.shrink_to_fit();
        Some(PeriodMap { period: equation.period(), cells, whole })
    }

    /// The period as a whole.
    pub fn whole(&self) -> &Period {
        &self.whole
    }

    /// The period (s).
    pub fn period(&self) -> Double {
        self.period
    }

    /// The map over one period.
    pub fn period_map(&self) -> &Affine {
        &self.whole.map
    }

    /// The largest estimated error of a cell, relative to the motion in it.
    pub fn error(&self) -> f64 {
        self.whole.error
    }

    /// How often the coefficients were evaluated.
    pub fn evaluations(&self) -> usize {
        self.whole.evaluations
    }

    /// How many cells the period has.
    pub fn cells(&self) -> usize {
        self.cells.len()
    }
}

/// The lengths of the next cells.
struct Lengths {
    /// The next cell of polynomials (s).
    polynomial: f64,
    /// The next cell by the phase (s).
    fast: f64,
    /// Cells by the phase have failed up to here (s).
    failed: Double,
}

impl Lengths {
    /// No length is known at `start` (s).
    fn new(start: Double) -> Self {
        Lengths { polynomial: f64::INFINITY, fast: f64::INFINITY, failed: start }
    }

    /// Whether the cell from `start` of at most this length (s) goes by the phase: it may be long enough for many vibrations, and
    /// short ones have not failed before.
    fn fast(&mut self, equation: &dyn Periodic, interval: usize, start: Double, longest: f64) -> bool {
        if !equation.by_phase() || (self.failed - start).hi > 0.0 {
            return false;
        }
        let frequency = equation.at(start, interval).stiffness.sqrt();
        let enough = |length: f64| 0.5 * length * frequency >= vibration::FEWEST;
        if enough(longest) && !enough(self.fast) {
            // Over so few vibrations the coefficients change too much; later cells try again.
            self.failed = start + Double::from(2.0 * vibration::FEWEST / frequency);
            self.fast = f64::INFINITY;
            return false;
        }
        enough(longest)
    }
}

/// The part to take of the `remaining` interval if `wish` is wished for: equal parts, so that none is a sliver. A wish like the
/// last part is met despite rounding.
fn share(wish: f64, remaining: f64) -> f64 {
    let parts = (remaining / wish - 1e-6).ceil();
    if parts > 1.0 { remaining / parts } else { remaining }
}

impl Trajectory {
    /// A trajectory from the state `y` at the start of a period, at the time `origin` (s).
    pub fn new(map: &PeriodMap, origin: f64, y: [f64; 2]) -> Self {
        let mut trajectory =
            Trajectory { origin, period_start: Double::from(origin), state: y, ..Trajectory::default() };
        trajectory.enter(map, 0);
        trajectory
    }

    /// How many periods lie between the start of the motion and the time `t`.
    pub fn periods(&self, map: &PeriodMap, t: f64) -> f64 {
        (t - self.origin) / map.period.hi
    }

    /// Whether the present cell is one of `map`.
    pub fn is_in(&self, map: &PeriodMap) -> bool {
        self.cell < map.cells.len()
    }

    /// Goes on to the cell that holds the time `t`, at or after the start of the present cell.
    pub fn reach(&mut self, map: &PeriodMap, t: f64) -> Result<(), Unbounded> {
        while self.since_start(map, t) > 2.0 {
            self.pass_cells(map, t)?;
        }
        Ok(())
    }

    /// (q, q̇) at the time `t`, at or after the start of the present cell; None if it is beyond the cell, or the cell is not one of
    /// polynomials.
    #[inline]
    pub fn within(&self, t: f64) -> Option<[f64; 2]> {
        let x = self.place(t);
        (x <= 1.0).then(|| self.polynomial_at(x))
    }

    /// (q, q̇) at the time `t` in the present cell.
    pub fn at(&self, map: &PeriodMap, t: f64) -> [f64; 2] {
        let Cell { half, motions, .. } = &map.cells[self.cell];
        match motions {
            Motions::Polynomials(_) => self.polynomial_at(self.place(t)),
            Motions::Vibration(vibration) => vibration.at(*half, self.since_start(map, t), self.state),
        }
    }

    #[inline]
    fn polynomial_at(&self, x: f64) -> [f64; 2] {
        let c = &self.polynomial;
        let square = x * x;
        // Even and odd powers apart: two short chains of dependent operations instead of one long one.
        let (mut even, mut odd) = (c[COEFFICIENTS - 2], c[COEFFICIENTS - 1]);
        for j in (0..COEFFICIENTS - 2).step_by(2).rev() {
            for i in 0..2 {
                even[i] = even[i] * square + c[j][i];
                odd[i] = odd[i] * square + c[j + 1][i];
            }
        }
        [even[0] + x * odd[0], even[1] + x * odd[1]]
    }

    /// x of the time `t`: −1 at the start of the present cell, 1 at its end; not finite if it is not one of polynomials.
    fn place(&self, t: f64) -> f64 {
        ((t - self.start.hi) - self.start.lo) * self.rate - 1.0
    }

    /// 1 + x of the time `t` in any cell.
    fn since_start(&self, map: &PeriodMap, t: f64) -> f64 {
        ((t - self.start.hi) - self.start.lo) / map.cells[self.cell].half
    }

    /// From the present cell to the one that holds `t`, or to the end of the period, and over the whole periods
    /// that lie between that and `t`.
    #[cold]
    fn pass_cells(&mut self, map: &PeriodMap, t: f64) -> Result<(), Unbounded> {
        let elapsed = (t - self.period_start.hi) - self.period_start.lo;
        let mut cell = self.cell;
        loop {
            let y = map.cells[cell].map.at(self.state);
            cell += 1;
            self.steps += 1;
            if !is_bounded(y) {
                return Err(Unbounded { time: t.min((self.period_start + map.end(cell - 1)).hi) });
            }
            self.state = y;
            if cell == map.cells.len() {
                self.next_periods(map, (elapsed / map.period.hi).floor().max(1.0) as u64)?;
                self.enter(map, 0);
                return Ok(());
            }
            if elapsed <= map.end(cell).hi {
                self.enter(map, cell);
                return Ok(());
            }
        }
    }

    /// From the end of the present period to the start of the `count`-th one after it, `count` ≥ 1.
    fn next_periods(&mut self, map: &PeriodMap, count: u64) -> Result<(), Unbounded> {
        if self.periods.saturating_add(count) > MOST_PERIODS {
            return Err(Unbounded { time: self.period_start.hi });
        }
        self.pass_periods(map, count - 1)?;
        self.begin_period(map, count);
        Ok(())
    }

    fn begin_period(&mut self, map: &PeriodMap, count: u64) {
        self.periods = self.periods.saturating_add(count);
        let n = self.periods as f64;
        self.period_start = Double::from(self.origin) + two_product(n, map.period.hi) + Double::from(n * map.period.lo);
    }

    /// Applies the map of a period `count` times.
    fn pass_periods(&mut self, map: &PeriodMap, count: u64) -> Result<(), Unbounded> {
        let mut power = map.whole.map;
        let mut rest = count;
        let before = self.state;
        while rest > 0 {
            if rest % 2 == 1 {
                self.state = power.at(self.state);
                self.steps += 1;
            }
            rest /= 2;
            power = power.after(&power);
        }
        if is_bounded(self.state) {
            return Ok(());
        }
        // The time of the overflow: the powers that leave the state bounded, the largest ones first.
        self.state = before;
        let mut passed = 0;
        for exponent in (0..u64::BITS - count.leading_zeros()).rev() {
            let power = (0..exponent).fold(map.whole.map, |power, _| power.after(&power));
            let y = power.at(self.state);
            if is_bounded(y) && passed + (1 << exponent) <= count {
                self.state = y;
                passed += 1 << exponent;
            }
        }
        self.begin_period(map, passed + 1);
        Err(Unbounded { time: self.period_start.hi })
    }

    /// Starts in `cell` of the present period from the present state.
    fn enter(&mut self, map: &PeriodMap, cell: usize) {
        let tabulated = &map.cells[cell];
        self.cell = cell;
        self.start = self.period_start + tabulated.start;
        match &tabulated.motions {
            Motions::Polynomials(polynomials) => {
                (self.rate, self.polynomial) = (1.0 / tabulated.half, polynomials.at(self.state));
            }
            Motions::Vibration(_) => self.rate = f64::INFINITY,
        }
    }
}

impl PeriodMap {
    /// The end of `cell`, from the start of the period (s).
    fn end(&self, cell: usize) -> Double {
        self.cells.get(cell + 1).map_or(self.period, |next| next.start)
    }
}

fn is_bounded(y: [f64; 2]) -> bool {
    // A NaN is in no range.
    y.iter().all(|y| y.abs() <= UNBOUNDED)
}
