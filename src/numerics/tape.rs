//! Differential equations recorded once as a list of operations, which a [`Program`] carries out on power series.
//!
//! ẏ = f(y, t) is written over [`Arithmetic`]; run on [`Var`], it leaves its operations on a [`Tape`]. A [`Var`] is a factor times a
//! result plus a constant, so that scaling and shifting leave nothing on the tape; sums of sums are one operation.
//!
//! [`Program`]: super::program::Program

use super::taylor::Arithmetic;
use std::cell::RefCell;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// No place.
pub const NONE: usize = usize::MAX;

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Op {
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

/// The operations, as they are recorded.
#[derive(Clone, Debug, Default)]
pub struct Tape {
    /// The class of each state, then of each known series: parts of one kind have series of one class at the same places.
    pub(super) classes: [Vec<usize>; 2],
    /// The operations, after the states.
    pub(super) ops: Vec<Op>,
    /// Terms of the sums: place and factor.
    pub(super) terms: Vec<(usize, f64)>,
    /// The rate of each state.
    pub(super) rates: Vec<usize>,
    /// The number of angles with powers.
    pub(super) angles: usize,
}

/// A factor times a number on a tape, plus a constant; without tape the constant alone.
#[derive(Clone, Copy)]
pub struct Var<'a> {
    tape: Option<&'a RefCell<Tape>>,
    place: usize,
    factor: f64,
    constant: f64,
}

impl Tape {
    /// Forgets everything and begins anew with states of these classes; memory is kept.
    pub fn begin(&mut self, states: impl Iterator<Item = usize>) {
        self.classes.iter_mut().for_each(Vec::clear);
        self.classes[0].extend(states);
        self.angles = 0;
        self.ops.clear();
        self.terms.clear();
        self.rates.clear();
    }

    /// Makes room for a recording so many times as large as the largest so far.
    pub fn make_room(&mut self, times: usize) {
        self.ops.reserve_exact(times * self.ops.capacity() - self.ops.len());
        self.terms.reserve_exact(times * self.terms.capacity() - self.terms.len());
        self.classes[1].reserve_exact(times * self.classes[1].capacity() - self.classes[1].len());
    }

    pub(super) fn states(&self) -> usize {
        self.classes[0].len()
    }

    /// Returns the place of the operation; an existing one is used again.
    fn push(&mut self, op: Op) -> usize {
        let known = self.ops.iter().rposition(|known| *known == op);
        self.states()
            + known.unwrap_or_else(|| {
                self.ops.push(op);
                self.ops.len() - 1
            })
    }

    /// Adds a known series of this class.
    pub fn new_row(&mut self, class: usize) -> usize {
        self.classes[1].push(class);
        self.classes[1].len() - 1
    }

    /// The operation whose result is at this place; None of a state.
    pub(super) fn op(&self, place: usize) -> Option<Op> {
        place.checked_sub(self.states()).map(|i| self.ops[i])
    }

    /// The row of a known function at this place.
    pub(super) fn row(&self, place: usize) -> Option<usize> {
        match self.op(place)? {
            Op::Signal(row) | Op::Function(_, row) | Op::Bend(_, row) => Some(row),
            _ => None,
        }
    }

    /// What distinguishes the operation from others, apart from its operands.
    pub(super) fn sign(&self, op: Op) -> u64 {
        let class = |row: usize| 8 * self.classes[1][row] as u64;
        match op {
            Op::Sum(..) => 1,
            Op::Signal(row) => 2 + class(row),
            Op::Powers(..) | Op::Led(..) | Op::Ahead(..) => 3,
            Op::Function(_, row) => 4 + class(row),
            Op::Bend(_, row) => 5 + class(row),
            Op::Product(..) => 6,
            Op::Quotient(..) => 7,
        }
    }

    /// Passes on the places of the operands.
    pub(super) fn operands(&self, op: Op, mut take: impl FnMut(usize)) {
        match op {
            Op::Sum(first, count, _) => self.terms[first..first + count].iter().for_each(|(place, _)| take(*place)),
            Op::Product(a, b) | Op::Quotient(a, b) | Op::Ahead(a, _, b) => [a, b].into_iter().for_each(take),
            Op::Powers(a, _) | Op::Led(a, _) | Op::Function(a, _) | Op::Bend(a, _) => take(a),
            Op::Signal(_) => {}
        }
    }
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
        let which = tape.borrow().angles;
        tape.borrow_mut().angles += 1;
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
            let op = on.op(part.place);
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
            let Some(Op::Function(powers, row)) = on.op(of[0].place) else { return None };
            let (Op::Powers(angle, which) | Op::Led(angle, which)) = on.op(powers)? else { return None };
            let plain = [of[0], w].iter().all(|part| part.factor == 1.0 && part.constant == 0.0);
            if !plain || angle + 1 != w.place || on.states() <= w.place {
                return None;
            }
            let i = powers - on.states();
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
