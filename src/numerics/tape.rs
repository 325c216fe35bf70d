//! Differential equations recorded once as a list of operations, whose solution follows as a power series in time.
//!
//! ẏ = f(y, t) is written over [`Arithmetic`]; run on [`Var`], it leaves its operations on a [`Tape`]. From the values of the states
//! the coefficients of all results then follow order by order: those of a product, a quotient or a root by the recurrences of
//! power series, those of a state from its rate, y⁽ⁿ⁺¹⁾ = rate⁽ⁿ⁾ h/(n + 1) with the unit of time h. A function of an angle φ,
//! known by its own series in φ − φ(0), is the sum of its coefficients times the series of the powers of φ − φ(0), which
//! all functions of this angle share.
//!
//! Operations with constants are done while recording: what is zero leaves nothing on the tape.
//!
//! Source: A. Griewank, A. Walther, *Evaluating Derivatives*, 2nd ed., SIAM 2008, section 13.2.

use super::taylor::Arithmetic;
use std::cell::RefCell;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// Coefficients of a series, at most.
pub const COEFFICIENTS: usize = 32;

/// Coefficients of a series.
pub type Row = [f64; COEFFICIENTS];

#[derive(Clone, Copy, Debug)]
enum Op {
    Constant(f64),
    /// A known function of time.
    Given(usize),
    /// The powers of an angle, no number itself.
    Powers(usize, usize),
    /// A function of an angle: place of the powers, row of its coefficients.
    Function(usize, usize),
    Sum(usize, usize),
    Difference(usize, usize),
    Shifted(usize, f64),
    Scaled(usize, f64),
    Product(usize, usize),
    Square(usize),
    Quotient(usize, usize),
}

/// The operations, and the series of their results.
#[derive(Clone, Debug, Default)]
pub struct Tape {
    states: usize,
    /// The operations behind the states.
    ops: Vec<Op>,
    /// The rate of each state.
    rates: Vec<usize>,
    /// By state and operation.
    series: Vec<f64>,
    /// Known series: functions of time, in its unit, and of angles.
    pub rows: Vec<Row>,
    /// xᵏ by angle, order n and power k.
    powers: Vec<[Row; COEFFICIENTS]>,
}

/// A number on a tape, or a constant.
#[derive(Clone, Copy)]
pub struct Var<'a> {
    tape: Option<&'a RefCell<Tape>>,
    place: usize,
    constant: f64,
}

impl Tape {
    /// Forgets all and begins anew with so many states and known series; room once taken is kept.
    pub fn begin(&mut self, states: usize, rows: usize) {
        self.states = states;
        self.ops.clear();
        self.rates.clear();
        self.rows.resize(rows, [0.0; COEFFICIENTS]);
        self.powers.clear();
    }

    /// Makes room for operations and angles.
    pub fn reserve(&mut self, ops: usize, angles: usize) {
        self.ops.reserve(ops);
        self.rates.reserve(self.states);
        self.powers.reserve(angles);
        self.series.resize((self.states + self.ops.capacity()) * COEFFICIENTS, 0.0);
    }

    fn push(&mut self, op: Op) -> usize {
        self.ops.push(op);
        let count = self.states + self.ops.len();
        if self.series.len() < count * COEFFICIENTS {
            self.series.resize(count * COEFFICIENTS, 0.0);
        }
        count - 1
    }

    /// The series of a result.
    pub fn series(&self, place: usize) -> &[f64] {
        &self.series[place * COEFFICIENTS..][..COEFFICIENTS]
    }

    /// Sets the value of a state.
    pub fn set(&mut self, state: usize, value: f64) {
        self.series[state * COEFFICIENTS] = value;
    }

    /// Computes the coefficients of the states up to `order`, those of the rest to one order less, in the `unit` of time (s).
    pub fn expand(&mut self, order: usize, unit: f64) {
        let Tape { states, ops, rates, series, rows, powers } = self;
        for n in 0..order {
            for (i, op) in ops.iter().enumerate() {
                let (known, rest) = series.split_at_mut((*states + i) * COEFFICIENTS);
                let of = |place: usize| &known[place * COEFFICIENTS..][..=n];
                let value = match *op {
                    Op::Constant(value) => {
                        if n == 0 {
                            value
                        } else {
                            0.0
                        }
                    }
                    Op::Given(row) => rows[row][n],
                    Op::Powers(angle, place) => {
                        raise(&mut powers[place], of(angle), n);
                        0.0
                    }
                    Op::Function(place, row) if n > 0 => dot(&rows[row][1..=n], &powers[place][n][1..=n]),
                    Op::Function(_, row) => rows[row][0],
                    Op::Sum(a, b) => of(a)[n] + of(b)[n],
                    Op::Difference(a, b) => of(a)[n] - of(b)[n],
                    Op::Shifted(a, c) => of(a)[n] + if n == 0 { c } else { 0.0 },
                    Op::Scaled(a, c) => c * of(a)[n],
                    Op::Product(a, b) => convolution(of(a), of(b)),
                    Op::Square(a) => square(of(a)),
                    Op::Quotient(a, b) => {
                        let (a, b) = (of(a), of(b));
                        (a[n] - convolution(&rest[..n], &b[1..])) / b[0]
                    }
                };
                rest[n] = value;
            }
            let factor = unit / (n + 1) as f64;
            for (state, &rate) in rates.iter().enumerate() {
                series[state * COEFFICIENTS + n + 1] = factor * series[rate * COEFFICIENTS + n];
            }
        }
    }
}

/// Row n of the powers of x − x(0): the coefficients of order n of its powers 1 … n.
fn raise(powers: &mut [Row; COEFFICIENTS], x: &[f64], n: usize) {
    if n == 0 {
        return;
    }
    let (below, row) = powers.split_at_mut(n);
    let row = &mut row[0];
    row[..=n].fill(0.0);
    row[1] = x[n];
    for (i, &x) in x.iter().enumerate().take(n).skip(1).filter(|(_, x)| **x != 0.0) {
        let lower = &below[n - i][1..=n - i];
        for (power, lower) in row[2..].iter_mut().zip(lower) {
            *power += x * lower;
        }
    }
}

/// Σ aᵢ bᵢ.
#[inline]
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; 4];
    let (a4, b4) = (a.chunks_exact(4), b.chunks_exact(4));
    let rest: f64 = a4.remainder().iter().zip(b4.remainder()).map(|(a, b)| a * b).sum();
    for (a, b) in a4.zip(b4) {
        for k in 0..4 {
            sums[k] += a[k] * b[k];
        }
    }
    (sums[0] + sums[2]) + (sums[1] + sums[3]) + rest
}

/// Σ aᵢ b₍ₙ₋ᵢ₎ of two lists of n + 1 numbers.
#[inline]
fn convolution(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; 4];
    let (a4, b4) = (a.chunks_exact(4), b.rchunks_exact(4));
    let rest: f64 = a4.remainder().iter().zip(b4.remainder().iter().rev()).map(|(a, b)| a * b).sum();
    for (a, b) in a4.zip(b4) {
        for k in 0..4 {
            sums[k] += a[k] * b[3 - k];
        }
    }
    (sums[0] + sums[2]) + (sums[1] + sums[3]) + rest
}

/// Coefficient n of the square.
#[inline]
fn square(a: &[f64]) -> f64 {
    let n = a.len() - 1;
    let half = a.len() / 2;
    let middle = if n.is_multiple_of(2) { a[half] * a[half] } else { 0.0 };
    2.0 * convolution(&a[..half], &a[a.len() - half..]) + middle
}

impl<'a> Var<'a> {
    fn on(tape: &'a RefCell<Tape>, place: usize) -> Self {
        Var { tape: Some(tape), place, constant: 0.0 }
    }

    fn push(tape: &'a RefCell<Tape>, op: Op) -> Self {
        Var::on(tape, tape.borrow_mut().push(op))
    }

    /// The state with this number.
    pub fn state(tape: &'a RefCell<Tape>, number: usize) -> Self {
        Var::on(tape, number)
    }

    /// The function of time in this row.
    pub fn given(tape: &'a RefCell<Tape>, row: usize) -> Self {
        Var::push(tape, Op::Given(row))
    }

    /// The powers of this angle, for [`Var::function`].
    pub fn powers(self, tape: &'a RefCell<Tape>) -> usize {
        let angle = self.place(tape);
        let place = tape.borrow().powers.len();
        tape.borrow_mut().powers.push([[0.0; COEFFICIENTS]; COEFFICIENTS]);
        Var::push(tape, Op::Powers(angle, place));
        place
    }

    /// The function of an angle in this row.
    pub fn function(tape: &'a RefCell<Tape>, powers: usize, row: usize) -> Self {
        Var::push(tape, Op::Function(powers, row))
    }

    /// Where it is on the tape; a constant is put there.
    pub fn place(self, tape: &'a RefCell<Tape>) -> usize {
        match self.tape {
            Some(_) => self.place,
            None => tape.borrow_mut().push(Op::Constant(self.constant)),
        }
    }

    /// The rate of the next state.
    pub fn is_rate(self, tape: &'a RefCell<Tape>) {
        let place = self.place(tape);
        tape.borrow_mut().rates.push(place);
    }
}

impl From<f64> for Var<'_> {
    fn from(constant: f64) -> Self {
        Var { tape: None, place: 0, constant }
    }
}

impl Arithmetic for Var<'_> {}

impl Add for Var<'_> {
    type Output = Self;
    fn add(self, o: Self) -> Self {
        match (self.tape, o.tape) {
            (None, None) => Var::from(self.constant + o.constant),
            (None, Some(_)) => o + self,
            (Some(_), None) if o.constant == 0.0 => self,
            (Some(tape), None) => Var::push(tape, Op::Shifted(self.place, o.constant)),
            (Some(tape), Some(_)) => Var::push(tape, Op::Sum(self.place, o.place)),
        }
    }
}

impl Sub for Var<'_> {
    type Output = Self;
    fn sub(self, o: Self) -> Self {
        match (self.tape, o.tape) {
            (Some(tape), Some(_)) => Var::push(tape, Op::Difference(self.place, o.place)),
            _ => self + -o,
        }
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
        match self.tape {
            None => Var::from(self.constant * factor),
            Some(_) if factor == 0.0 => Var::from(0.0),
            Some(_) if factor == 1.0 => self,
            Some(tape) => Var::push(tape, Op::Scaled(self.place, factor)),
        }
    }
}

impl Mul for Var<'_> {
    type Output = Self;
    fn mul(self, o: Self) -> Self {
        match (self.tape, o.tape) {
            (_, None) => self * o.constant,
            (None, _) => o * self.constant,
            (Some(tape), Some(_)) if self.place == o.place => Var::push(tape, Op::Square(self.place)),
            (Some(tape), Some(_)) => Var::push(tape, Op::Product(self.place, o.place)),
        }
    }
}

impl Div for Var<'_> {
    type Output = Self;
    fn div(self, o: Self) -> Self {
        match (self.tape, o.tape) {
            (_, None) => self * (1.0 / o.constant),
            (_, Some(tape)) => Var::push(tape, Op::Quotient(self.place(tape), o.place)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Records ẏ = f(y) and expands it from `start`.
    fn expanded<const N: usize>(start: [f64; N], f: impl Fn([Var; N]) -> [Var; N]) -> Tape {
        let mut tape = Tape::default();
        tape.begin(N, 0);
        tape.reserve(16, 0);
        let tape = RefCell::new(tape);
        f(std::array::from_fn(|k| Var::state(&tape, k))).into_iter().for_each(|rate| rate.is_rate(&tape));
        let mut tape = tape.into_inner();
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
        tape.begin(2, 2);
        let tape = RefCell::new(tape);
        let [phi, w] = [0, 1].map(|k| Var::state(&tape, k));
        let powers = phi.powers(&tape);
        let [sine, cosine] = [0, 1].map(|row| Var::function(&tape, powers, row));
        w.is_rate(&tape);
        (-sine).is_rate(&tape);
        let energy = (w * w * 0.5 - cosine).place(&tape);
        let mut tape = tape.into_inner();
        let mut factorial = 1.0;
        for n in 0..COEFFICIENTS {
            factorial *= (n as f64).max(1.0);
            let (s, c) = (1.0 + n as f64 * std::f64::consts::FRAC_PI_2).sin_cos();
            (tape.rows[0][n], tape.rows[1][n]) = (s / factorial, c / factorial);
        }
        tape.set(0, 1.0);
        tape.set(1, 0.7);
        tape.expand(24, 0.3);
        let energy = tape.series(energy);
        assert!((energy[0] - (0.245 - 1.0_f64.cos())).abs() < 1e-15);
        assert!(energy[1..24].iter().all(|c| c.abs() < 1e-15), "{energy:?}");
    }
}
