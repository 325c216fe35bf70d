//! Differential equations recorded once as a list of operations; their solution follows as a power series in time.
//!
//! ẏ = f(y, t) is written over [`Arithmetic`]; run on [`Var`], it leaves its operations on a [`Tape`]. From the values of the
//! states the coefficients of all results then follow order by order: products and quotients by the recurrences of power series,
//! states from their rates, y⁽ⁿ⁺¹⁾ = rate⁽ⁿ⁾ h/(n + 1) with the unit of time h. A function of an angle φ, known by its own series
//! in φ − φ(0), is the sum of its coefficients times the series of the powers of φ − φ(0), which all functions of this angle share.
//!
//! A [`Var`] is a factor times a result plus a constant, so that scaling and shifting leave nothing on the tape; sums of sums are
//! one operation; results that neither a rate nor a kept result needs are left out. Convolutions are plain dot products: the
//! coefficients of second factors are kept in reverse order, too.
//!
//! Source: A. Griewank, A. Walther, *Evaluating Derivatives*, 2nd ed., SIAM 2008, section 13.2.

use super::taylor::Arithmetic;
use std::cell::RefCell;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// No place.
pub const NONE: usize = usize::MAX;

/// Dot products take so many terms at a time; as many zeros follow each series.
const LANES: usize = 4;

/// The most of them in a sum: orders end at 24.
const WIDEST: usize = 6;

#[derive(Clone, Copy, Debug, PartialEq)]
enum Op {
    /// A constant and terms: the first of them and their number.
    Sum(usize, usize, f64),
    /// A known function of time.
    Signal(usize),
    /// The powers of an angle, no number itself.
    Powers(usize, usize),
    /// The same where the next state is the rate of the angle, and the rate of that is known: two orders ahead.
    Led(usize, usize),
    /// Those powers, led by this rate of the rate.
    Ahead(usize, usize, usize),
    /// A function of an angle: which powers, row of its coefficients.
    Function(usize, usize),
    /// Its second derivative with respect to time: which powers that are ahead, row of its coefficients.
    Bend(usize, usize),
    Product(usize, usize),
    Quotient(usize, usize),
}

/// The operations and the series of their results.
#[derive(Clone, Debug, Default)]
pub struct Tape {
    states: usize,
    /// The highest order of the series of a state.
    order: usize,
    /// The operations, after the states.
    ops: Vec<Op>,
    /// Terms of the sums: place and factor.
    terms: Vec<(usize, f64)>,
    /// The rate of each state.
    rates: Vec<usize>,
    /// Numbers of known series and of angles with powers.
    counts: [usize; 2],
    /// The series of states and operations.
    series: Vec<f64>,
    /// For each place, its place among the reversed series.
    mirrors: Vec<usize>,
    reversed: Vec<f64>,
    /// Known series: functions of time, in its unit, and of angles.
    rows: Vec<f64>,
    /// For each angle, by order from 0, the coefficients of the powers xᵏ.
    powers: Vec<f64>,
}

/// A factor times a number on a tape, plus a constant; without tape the constant alone.
#[derive(Clone, Copy)]
pub struct Var<'a> {
    tape: Option<&'a RefCell<Tape>>,
    place: usize,
    factor: f64,
    constant: f64,
}

/// The next multiple of the lanes.
fn whole(count: usize) -> usize {
    count.next_multiple_of(LANES)
}

impl Tape {
    /// Forgets everything and begins anew with so many states, for series up to this order; memory is kept.
    pub fn begin(&mut self, states: usize, order: usize) {
        assert!(order <= LANES * WIDEST);
        (self.states, self.order, self.counts) = (states, order, [0; 2]);
        self.ops.clear();
        self.terms.clear();
        self.rates.clear();
    }

    /// Makes room for as much again as now, so that another recording of about this size fits.
    pub fn make_room(&mut self) {
        self.ops.reserve_exact(self.ops.capacity());
        self.terms.reserve_exact(self.terms.capacity());
        self.mirrors.reserve_exact(self.mirrors.capacity());
        for numbers in [&mut self.series, &mut self.reversed, &mut self.rows, &mut self.powers] {
            numbers.reserve_exact(numbers.len());
        }
    }

    /// Distance from one series to the next: room for three coefficients more than the order, and for whole lanes from any place.
    fn stride(&self) -> usize {
        whole(self.order + 2) + LANES
    }

    /// From the powers of one angle to those of the next.
    fn angle(&self) -> usize {
        (self.order + 2) * self.stride()
    }

    /// Returns the place of the operation; an existing one is used again.
    fn push(&mut self, op: Op) -> usize {
        let known = self.ops.iter().rposition(|known| *known == op);
        self.states
            + known.unwrap_or_else(|| {
                self.ops.push(op);
                self.ops.len() - 1
            })
    }

    /// Adds a known series.
    pub fn new_row(&mut self) -> usize {
        self.counts[0] += 1;
        self.counts[0] - 1
    }

    /// So many coefficients of a known series, up to three more than the order.
    pub fn row(&mut self, row: usize, count: usize) -> &mut [f64] {
        let stride = self.stride();
        &mut self.rows[row * stride..][..count]
    }

    /// The coefficients of a result: for a state up to the order, for others to one less.
    pub fn series(&self, place: usize) -> &[f64] {
        &self.series[place * self.stride()..][..=self.order]
    }

    /// Sets the value of a state.
    pub fn set(&mut self, state: usize, value: f64) {
        let stride = self.stride();
        self.series[state * stride] = value;
    }

    /// Ends the recording: leaves out operations that neither rates nor the results `kept` need, and writes the new places into
    /// `kept`.
    pub fn finish(&mut self, kept: &mut [usize]) {
        let (states, count) = (self.states, self.states + self.ops.len());
        // For each place whether it is needed, then its new place.
        let mut places = std::mem::take(&mut self.mirrors);
        places.clear();
        places.resize(count, NONE);
        let needed = self.rates.iter().chain(kept.iter());
        needed.filter(|place| **place != NONE).for_each(|place| places[*place] = 0);
        for (i, op) in self.ops.iter().enumerate().rev() {
            if places[states + i] == NONE {
                continue;
            }
            match *op {
                Op::Sum(first, count, _) => {
                    self.terms[first..first + count].iter().for_each(|(place, _)| places[*place] = 0);
                }
                Op::Product(a, b) | Op::Quotient(a, b) => (places[a], places[b]) = (0, 0),
                Op::Powers(a, _) | Op::Led(a, _) => places[a] = 0,
                Op::Ahead(powers, _, a) => (places[powers], places[a]) = (0, 0),
                Op::Function(powers, _) | Op::Bend(powers, _) => places[powers] = 0,
                Op::Signal(_) => {}
            }
        }
        (0..states).for_each(|state| places[state] = state);
        let (mut used, mut terms) = (0, 0);
        for i in 0..self.ops.len() {
            if places[states + i] == NONE {
                continue;
            }
            self.ops[used] = match self.ops[i] {
                Op::Sum(first, count, constant) => {
                    for k in 0..count {
                        let (place, factor) = self.terms[first + k];
                        self.terms[terms + k] = (places[place], factor);
                    }
                    terms += count;
                    Op::Sum(terms - count, count, constant)
                }
                Op::Product(a, b) => Op::Product(places[a], places[b]),
                Op::Quotient(a, b) => Op::Quotient(places[a], places[b]),
                Op::Powers(a, which) => Op::Powers(places[a], which),
                Op::Led(a, which) => Op::Led(places[a], which),
                Op::Ahead(powers, which, a) => Op::Ahead(places[powers], which, places[a]),
                Op::Function(powers, row) => Op::Function(places[powers], row),
                Op::Bend(powers, row) => Op::Bend(places[powers], row),
                op @ Op::Signal(_) => op,
            };
            places[states + i] = states + used;
            used += 1;
        }
        self.ops.truncate(used);
        self.terms.truncate(terms);
        let moved = self.rates.iter_mut().chain(kept).filter(|place| **place != NONE);
        moved.for_each(|place| *place = places[*place]);
        self.lay_out(places);
    }

    /// Makes room for all series; operations then name, instead of places, where these begin, or where a reversed one ends.
    fn lay_out(&mut self, mut mirrors: Vec<usize>) {
        let (stride, angle, last) = (self.stride(), self.angle(), self.order);
        mirrors.clear();
        mirrors.resize(self.states + self.ops.len(), NONE);
        let mut reversed = 0;
        let mut mirror = |mirrors: &mut [usize], place: usize| {
            if mirrors[place] == NONE {
                mirrors[place] = reversed * stride + last;
                reversed += 1;
            }
            mirrors[place]
        };
        for i in 0..self.ops.len() {
            self.ops[i] = match self.ops[i] {
                Op::Sum(first, count, constant) => {
                    self.terms[first..first + count].iter_mut().for_each(|(place, _)| *place *= stride);
                    Op::Sum(first, count, constant)
                }
                Op::Signal(row) => Op::Signal(row * stride),
                Op::Powers(a, which) => Op::Powers(a * stride, which * angle),
                Op::Led(a, which) => Op::Led(a * stride, which * angle),
                Op::Ahead(powers, which, a) => {
                    let Op::Led(of, _) = self.ops[powers - self.states] else { continue };
                    Op::Ahead(of, which * angle, a * stride)
                }
                Op::Function(powers, row) => {
                    let (Op::Powers(_, at) | Op::Led(_, at)) = self.ops[powers - self.states] else { continue };
                    Op::Function(at, row * stride)
                }
                Op::Bend(powers, row) => {
                    let Op::Ahead(_, at, _) = self.ops[powers - self.states] else { continue };
                    Op::Bend(at, row * stride)
                }
                Op::Product(a, b) => {
                    let (a, b) = if mirrors[a] != NONE { (b, a) } else { (a, b) };
                    Op::Product(a * stride, mirror(&mut mirrors, b))
                }
                Op::Quotient(a, b) => Op::Quotient(a * stride, mirror(&mut mirrors, b)),
            };
        }
        self.mirrors = mirrors;
        let [rows, angles] = self.counts;
        let sizes = [self.states + self.ops.len(), reversed, rows, angles * (self.order + 2)];
        let all = [&mut self.series, &mut self.reversed, &mut self.rows, &mut self.powers];
        for (numbers, size) in all.into_iter().zip(sizes) {
            numbers.clear();
            numbers.resize(size * stride, 0.0);
        }
    }

    /// Computes the coefficients of the states up to `order`, of all others to one order less, in the `unit` of time (s).
    pub fn expand(&mut self, order: usize, unit: f64) {
        let (stride, states) = (self.stride(), self.states);
        let starts = self.series.chunks_exact(stride).zip(&self.mirrors).take(states);
        starts.filter(|(_, end)| **end != NONE).for_each(|(row, end)| self.reversed[*end] = row[0]);
        (0..order).for_each(|n| self.go_on(n, unit));
    }

    /// The coefficients of order n, those of the states of the next one.
    fn go_on(&mut self, n: usize, unit: f64) {
        let (dot, raise) = SUMS[n / LANES];
        let (stride, angle) = (self.stride(), self.angle());
        let Tape { states, ops, terms, rates, series, mirrors, reversed, rows, powers, .. } = self;
        // Lanes that reach beyond what is known find zeros.
        if n.is_multiple_of(LANES) {
            for (place, row) in series.chunks_exact_mut(stride).enumerate() {
                row[n] = if place < *states { row[n] } else { 0.0 };
                row[n + 1..][..LANES - 1].copy_from_slice(&[0.0; LANES - 1]);
            }
        }
        let mut own = *states * stride;
        for (op, end) in ops.iter().zip(&mirrors[*states..]) {
            let value = match *op {
                Op::Sum(first, count, constant) => {
                    let start = if n == 0 { constant } else { 0.0 };
                    terms[first..first + count].iter().fold(start, |sum, (at, factor)| sum + factor * series[at + n])
                }
                Op::Signal(row) => rows[row + n],
                Op::Powers(of, at) => {
                    raise(&mut powers[at..][..angle], stride, &series[of..][..=n]);
                    0.0
                }
                Op::Led(of, at) => {
                    if n == 0 {
                        series[of + 1] = unit * series[of + stride];
                        (0..2).for_each(|n| raise(&mut powers[at..][..angle], stride, &series[of..][..=n]));
                    }
                    0.0
                }
                Op::Ahead(of, at, a) => {
                    let [first, second] = [n + 1, n + 2].map(|n| unit / n as f64);
                    series[of + n + 1] = first * series[of + stride + n];
                    series[of + n + 2] = second * (first * series[a + n]);
                    raise(&mut powers[at..][..angle], stride, &series[of..][..n + 3]);
                    0.0
                }
                Op::Function(at, row) => dot(&rows[row..], &powers[at + n * stride..]),
                Op::Bend(at, row) => {
                    let (c, powers) = (&rows[row..], &powers[at + (n + 2) * stride..]);
                    let beyond = LANES * (n / LANES + 1);
                    let rest = if beyond <= n + 2 { sum::<1>(&c[beyond..], &powers[beyond..]) } else { 0.0 };
                    ((n + 1) * (n + 2)) as f64 / (unit * unit) * (dot(c, powers) + rest)
                }
                Op::Product(a, b) => dot(&series[a..], &reversed[b - n..]),
                Op::Quotient(a, b) => {
                    let rest = dot(&series[own..], &reversed[b - n..]);
                    (series[a + n] - rest) / reversed[b]
                }
            };
            series[own + n] = value;
            if *end != NONE {
                reversed[*end - n] = value;
            }
            own += stride;
        }
        let factor = unit / (n + 1) as f64;
        for (state, (rate, end)) in rates.iter().zip(&*mirrors).enumerate() {
            let value = factor * series[rate * stride + n];
            series[state * stride + n + 1] = value;
            if *end != NONE {
                reversed[*end - n - 1] = value;
            }
        }
    }
}

/// Sums of so many whole lanes. Lengths that the compiler knows take a third of the instructions of a loop.
const SUMS: [(fn(&[f64], &[f64]) -> f64, fn(&mut [f64], usize, &[f64])); WIDEST] = [
    (sum::<1>, raise::<1>),
    (sum::<2>, raise::<2>),
    (sum::<3>, raise::<3>),
    (sum::<4>, raise::<4>),
    (sum::<5>, raise::<5>),
    (sum::<WIDEST>, raise::<WIDEST>),
];

/// The coefficients of order n of the powers (x − x(0))ᵏ, k = 0 … n, one after another behind those of the orders before, with the
/// coefficients `x` up to this order: the sum of xₘ times those of order n − m of the next lower powers, in L whole lanes.
fn raise<const L: usize>(powers: &mut [f64], stride: usize, x: &[f64]) {
    let n = x.len() - 1;
    let (before, now) = powers.split_at_mut(n * stride);
    if n == 0 {
        now[0] = 1.0;
        return;
    }
    // Of a straight course there is one.
    let last = x.iter().rposition(|x| *x != 0.0).unwrap_or(0);
    let mut sums = [[0.0; LANES]; L];
    for (x, lower) in x[1..].iter().take(last).zip(before.chunks_exact(stride).rev()) {
        let lower = &lower.as_chunks::<LANES>().0[..L];
        for i in 0..L {
            sums[i] = std::array::from_fn(|k| sums[i][k] + x * lower[i][k]);
        }
    }
    now[1..][..LANES * L].copy_from_slice(sums.as_flattened());
    // Two orders ahead the highest power may lie behind these lanes.
    if n > LANES * L {
        now[n] = x[1] * before[(n - 1) * stride + n - 1];
    }
}

/// Σ aᵢ bᵢ of L whole lanes.
fn sum<const L: usize>(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; LANES];
    for (a, b) in a[..LANES * L].as_chunks::<LANES>().0.iter().zip(b[..LANES * L].as_chunks::<LANES>().0) {
        (0..LANES).for_each(|k| sums[k] += a[k] * b[k]);
    }
    (sums[0] + sums[2]) + (sums[1] + sums[3])
}

impl<'a> Var<'a> {
    fn on(tape: &'a RefCell<Tape>, place: usize) -> Self {
        Var { tape: Some(tape), place, factor: 1.0, constant: 0.0 }
    }

    fn push(tape: &'a RefCell<Tape>, op: Op) -> Self {
        Var::on(tape, tape.borrow_mut().push(op))
    }

    /// The state with this number.
    pub fn state(tape: &'a RefCell<Tape>, number: usize) -> Self {
        Var::on(tape, number)
    }

    /// The function of time in this row.
    pub fn signal(tape: &'a RefCell<Tape>, row: usize) -> Self {
        Var::push(tape, Op::Signal(row))
    }

    /// The powers of this angle, for [`Var::function`].
    pub fn powers(self, tape: &'a RefCell<Tape>) -> usize {
        let angle = self.place(tape);
        let which = tape.borrow().counts[1];
        tape.borrow_mut().counts[1] += 1;
        tape.borrow_mut().push(Op::Powers(angle, which))
    }

    /// The function of an angle in this row.
    pub fn function(tape: &'a RefCell<Tape>, powers: usize, row: usize) -> Self {
        Var::push(tape, Op::Function(powers, row))
    }

    /// The place on the tape; scaled or shifted results are put there first.
    pub fn place(self, tape: &'a RefCell<Tape>) -> usize {
        match self.tape {
            Some(_) if self.factor == 1.0 && self.constant == 0.0 => self.place,
            _ => Var::sum(tape, [self, Var::from(0.0)]).place,
        }
    }

    /// The rate of the next state.
    pub fn is_rate(self, tape: &'a RefCell<Tape>) {
        let place = self.place(tape);
        tape.borrow_mut().rates.push(place);
    }

    /// One operation for both; the terms of sums are merged.
    fn sum(tape: &'a RefCell<Tape>, parts: [Self; 2]) -> Self {
        let mut on = tape.borrow_mut();
        let (first, mut constant) = (on.terms.len(), 0.0);
        for part in parts {
            constant += part.constant;
            if part.tape.is_none() {
                continue;
            }
            let op = part.place.checked_sub(on.states).map(|i| on.ops[i]);
            let (from, count) = match op {
                Some(Op::Sum(from, count, own)) => {
                    constant += part.factor * own;
                    (from, count)
                }
                _ => (NONE, 1),
            };
            for k in 0..count {
                let (place, factor) = if from == NONE { (part.place, 1.0) } else { on.terms[from + k] };
                let factor = part.factor * factor;
                match on.terms[first..].iter_mut().find(|(known, _)| *known == place) {
                    Some((_, sum)) => *sum += factor,
                    None => on.terms.push((place, factor)),
                }
            }
        }
        let count = on.terms.len() - first;
        let known = on.ops.iter().rev().find_map(|op| match *op {
            Op::Sum(from, size, c) if size == count && c == constant => {
                (on.terms[from..from + size] == on.terms[first..]).then_some(from)
            }
            _ => None,
        });
        let first = known.inspect(|_| on.terms.truncate(first)).unwrap_or(first);
        Var::on(tape, on.push(Op::Sum(first, count, constant)))
    }

    /// The place of a multiple, and the factor.
    fn multiple(self, tape: &'a RefCell<Tape>) -> (usize, f64) {
        if self.tape.is_some() && self.constant == 0.0 { (self.place, self.factor) } else { (self.place(tape), 1.0) }
    }
}

impl From<f64> for Var<'_> {
    fn from(constant: f64) -> Self {
        Var { tape: None, place: NONE, factor: 0.0, constant }
    }
}

impl Arithmetic for Var<'_> {
    /// From the series of the function itself, where the angle is a state and the next one is its rate.
    #[inline(never)]
    fn bend(of: [Self; 3], w: Self, a: Self) -> Self {
        let led = of[0].tape.and_then(|tape| {
            let mut on = tape.borrow_mut();
            let op = |on: &Tape, place: usize| place.checked_sub(on.states).map(|i| on.ops[i]);
            let Some(Op::Function(powers, row)) = op(&on, of[0].place) else { return None };
            let (Op::Powers(angle, which) | Op::Led(angle, which)) = op(&on, powers)? else { return None };
            let plain = [of[0], w].iter().all(|part| part.factor == 1.0 && part.constant == 0.0);
            if !plain || angle + 1 != w.place || on.states <= w.place {
                return None;
            }
            let i = powers - on.states;
            on.ops[i] = Op::Led(angle, which);
            Some((tape, powers, which, row))
        });
        let Some((tape, powers, which, row)) = led else { return of[2] * (w * w) + of[1] * a };
        let ahead = Var::push(tape, Op::Ahead(powers, which, a.place(tape)));
        Var::push(tape, Op::Bend(ahead.place, row))
    }
}

impl Add for Var<'_> {
    type Output = Self;
    fn add(self, o: Self) -> Self {
        match (self.tape, o.tape) {
            (_, None) => Var { constant: self.constant + o.constant, ..self },
            (None, _) => Var { constant: self.constant + o.constant, ..o },
            (Some(tape), Some(_)) => Var::sum(tape, [self, o]),
        }
    }
}

impl Sub for Var<'_> {
    type Output = Self;
    fn sub(self, o: Self) -> Self {
        self + -o
    }
}

impl Neg for Var<'_> {
    type Output = Self;
    fn neg(self) -> Self {
        self * -1.0
    }
}

impl Mul<f64> for Var<'_> {
    type Output = Self;
    fn mul(self, factor: f64) -> Self {
        if factor == 0.0 {
            return Var::from(0.0);
        }
        Var { factor: self.factor * factor, constant: self.constant * factor, ..self }
    }
}

impl Mul for Var<'_> {
    type Output = Self;
    fn mul(self, o: Self) -> Self {
        let Some(tape) = self.tape else { return o * self.constant };
        if o.tape.is_none() {
            return self * o.constant;
        }
        let ((a, f), (b, g)) = (self.multiple(tape), o.multiple(tape));
        Var { factor: f * g, ..Var::push(tape, Op::Product(a.min(b), a.max(b))) }
    }
}

impl Div for Var<'_> {
    type Output = Self;
    fn div(self, o: Self) -> Self {
        let Some(tape) = o.tape else { return self * (1.0 / o.constant) };
        let ((a, f), (b, g)) = (self.multiple(tape), o.multiple(tape));
        Var { factor: f / g, ..Var::push(tape, Op::Quotient(a, b)) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Records ẏ = f(y) and expands it from `start`.
    fn expanded<const N: usize>(start: [f64; N], f: impl Fn([Var; N]) -> [Var; N]) -> Tape {
        let mut tape = Tape::default();
        tape.begin(N, 20);
        let tape = RefCell::new(tape);
        f(std::array::from_fn(|k| Var::state(&tape, k))).into_iter().for_each(|rate| rate.is_rate(&tape));
        let mut tape = tape.into_inner();
        tape.finish(&mut []);
        start.iter().enumerate().for_each(|(k, y)| tape.set(k, *y));
        tape.expand(20, 0.5);
        tape
    }

    #[test]
    fn the_series_of_known_solutions() {
        // y = 1/(1 + t): ẏ = −y²; z = √(1 + 2t) by ż = 1/z; v = (1 + t)² by v̇ = 2 √v, as 2 w, ẇ = 1.
        let tape = expanded([1.0, 1.0, 1.0], |[y, z, w]| [-(y * y), Var::from(1.0) / z, Var::from(1.0) + w * 0.0]);
        // The unit of time is half a second.
        for n in 0..=20 {
            assert!((tape.series(0)[n] - (-0.5_f64).powi(n as i32)).abs() < 1e-15);
        }
        // √(1 + 2t) = Σ C(½, n) (2t)ⁿ at 2t = τ.
        let mut binomial = 1.0;
        for n in 0..=20 {
            assert!((tape.series(1)[n] - binomial).abs() < 1e-14, "{n}");
            binomial *= (0.5 - n as f64) / (n + 1) as f64;
        }
        assert_eq!(tape.series(2)[..3], [1.0, 0.5, 0.0]);
    }

    #[test]
    fn functions_of_an_angle_are_those_of_its_series() {
        // φ̈ = −sin φ with the series of the sine about φ(0): the energy ½ φ̇² − cos φ stays.
        let mut tape = Tape::default();
        tape.begin(2, 24);
        let rows = [tape.new_row(), tape.new_row()];
        let tape = RefCell::new(tape);
        let [phi, w] = [0, 1].map(|k| Var::state(&tape, k));
        let powers = phi.powers(&tape);
        let [sine, cosine] = rows.map(|row| Var::function(&tape, powers, row));
        w.is_rate(&tape);
        (-sine).is_rate(&tape);
        // The acceleration of the sine from its series, and by the chain rule.
        let (bend, chain) = (Var::bend([sine, cosine, -sine], w, -sine), -(sine * (w * w)) - cosine * sine);
        let mut kept = [w * w * 0.5 - cosine, sine, bend, chain].map(|result| result.place(&tape));
        let mut tape = tape.into_inner();
        tape.finish(&mut kept);
        let mut factorial = 1.0;
        for n in 0..=24 {
            factorial *= (n as f64).max(1.0);
            let (s, c) = (1.0 + n as f64 * std::f64::consts::FRAC_PI_2).sin_cos();
            (tape.row(0, 25)[n], tape.row(1, 25)[n]) = (s / factorial, c / factorial);
        }
        tape.set(0, 1.0);
        tape.set(1, 0.7);
        tape.expand(24, 0.3);
        let [energy, sine, bend, chain] = kept.map(|place| tape.series(place));
        for n in 0..22 {
            let exact = ((n + 1) * (n + 2)) as f64 * sine[n + 2] / 0.09;
            assert!(
                (bend[n] - exact).abs() < 1e-13 && (chain[n] - exact).abs() < 1e-13,
                "{n}: {} {} {exact}",
                bend[n],
                chain[n]
            );
        }
        assert!((energy[0] - (0.245 - 1.0_f64.cos())).abs() < 1e-15);
        assert!(energy[1..24].iter().all(|c| c.abs() < 1e-15), "{energy:?}");
    }
}
