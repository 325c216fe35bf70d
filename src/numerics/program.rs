//! The operations of a [`Tape`] as they run: the solution of differential equations as power series in time.
//!
//! From the values of the states the coefficients of all results follow order by order: products and quotients by the recurrences
//! of power series, states from their rates, y⁽ⁿ⁺¹⁾ = rate⁽ⁿ⁾ h/(n + 1) with the unit of time h. A function of an angle φ, known by
//! its own series in δ = φ − φ(0), is the sum of its coefficients times the series of the powers of δ, which all functions of this
//! angle share.
//!
//! Operations that no result needs are left out. Equal operations of up to four parts run as one, on the four numbers of a pack: a
//! product of series then has no sum across its lanes, and each instruction works on several parts.
//!
//! Source: A. Griewank, A. Walther, *Evaluating Derivatives*, 2nd ed., SIAM 2008, section 13.2.

use super::tape::{NONE, Op, Tape};

/// The numbers of a pack.
const PACK: usize = 4;

type Pack = [f64; PACK];

/// An operation as it runs. Numbers and packs are named by where their series begin, numbers among all numbers, packs among all
/// packs; the last one is the result.
#[derive(Clone, Copy, Debug)]
enum Step {
    /// Terms, the first of them and their number, and a constant.
    Sum(usize, usize, f64, usize),
    Sums(usize, usize, Pack, usize),
    /// A row.
    Signal(usize, usize),
    /// An angle, and its number.
    Powers(usize, usize),
    /// An angle with its rate, and its number.
    Led([usize; 2], usize),
    /// An angle with its rate and the rate of that, and its number.
    Ahead([usize; 3], usize),
    /// The number of an angle and a row.
    Function(usize, usize, usize),
    Functions(usize, usize, usize),
    Bend(usize, usize, usize),
    Bends(usize, usize, usize),
    Product(usize, usize, usize),
    Products(usize, usize, usize),
    Quotient(usize, usize, usize),
}

/// A state, or a pack of them, and the rates.
#[derive(Clone, Copy, Debug)]
enum Rate {
    One(usize, usize),
    Four(usize, usize),
}

/// The operations of one set of equations.
#[derive(Clone, Debug, Default)]
pub struct Program {
    /// The highest order of the series of a state.
    order: usize,
    steps: Vec<Step>,
    /// Terms of the sums: place and factor.
    terms: Vec<(usize, f64)>,
    packed: Vec<(usize, Pack)>,
    rates: Vec<Rate>,
    /// Where the states and the kept results begin, and the number of states.
    results: Vec<usize>,
    states: usize,
    /// Where each known series begins; its coefficients lie a pack apart.
    rows: Vec<usize>,
    /// The packs of rows that are functions of an angle, with its number.
    functions: Vec<(usize, usize)>,
    /// The numbers of packs of series, of packs of rows, and of angles with powers.
    counts: [usize; 3],
}

/// The next multiple of a pack.
fn whole(count: usize) -> usize {
    count.next_multiple_of(PACK)
}

/// Distance from one series to the next: angles are known two orders ahead.
fn stride(order: usize) -> usize {
    order + 2
}

/// The same of rows, which have three coefficients more than the order.
fn row_stride(order: usize) -> usize {
    whole(order + 3)
}

/// The pack of these numbers, if they are its first ones in turn.
fn together(mut seats: impl Iterator<Item = usize>) -> Option<usize> {
    let first = seats.next().filter(|seat| seat.is_multiple_of(PACK))?;
    (first + 1..).zip(seats).all(|(next, seat)| next == seat).then_some(first / PACK)
}

impl Program {
    /// Compiles a recording for series up to this order; in `kept` the numbers of results take the place of places on the tape.
    pub fn compile(&mut self, tape: &Tape, order: usize, kept: &mut [usize], sorter: &mut Sorter) {
        sorter.sort(tape, kept);
        let [packs, rows] = sorter.seat(tape);
        (self.order, self.states, self.counts) = (order, tape.states(), [packs, rows, tape.angles]);
        self.steps.clear();
        self.terms.clear();
        self.packed.clear();
        self.rates.clear();
        self.functions.clear();
        let mut start = 0;
        while let Some(group) = sorter.group(tape, start) {
            start += group.len();
            if group[0] < self.states {
                self.integrate(tape, sorter, group);
            } else {
                self.operate(tape, sorter, group);
            }
        }
        let begins = |seat: &usize| place(*seat, stride(order));
        self.results.clear();
        self.results.extend(sorter.seats[0][..self.states].iter().map(begins));
        for kept in kept.iter_mut().filter(|kept| **kept != NONE) {
            self.results.push(begins(&sorter.seats[0][*kept]));
            *kept = self.results.len() - 1;
        }
        self.rows.clear();
        self.rows.extend(
            sorter.seats[1].iter().map(|seat| if *seat == NONE { NONE } else { place(*seat, row_stride(order)) }),
        );
    }

    /// The packs of rows that are functions of this angle.
    fn functions_of(&self, angle: usize) -> impl Iterator<Item = usize> {
        self.functions.iter().filter(move |(which, _)| *which == angle).map(|(_, row)| *row)
    }

    /// Whether a known series is needed.
    pub fn reads(&self, row: usize) -> bool {
        self.rows.get(row).is_some_and(|at| *at != NONE)
    }

    /// How many elements its lists have.
    pub fn sizes(&self) -> [usize; 7] {
        let Program { steps, terms, packed, rates, results, rows, functions, .. } = self;
        [steps.len(), terms.len(), packed.len(), rates.len(), results.len(), rows.len(), functions.len()]
    }

    /// Makes room for lists of so many elements.
    pub fn make_room(&mut self, sizes: [usize; 7]) {
        resize(&mut self.steps, sizes[0]);
        resize(&mut self.terms, sizes[1]);
        resize(&mut self.packed, sizes[2]);
        resize(&mut self.rates, sizes[3]);
        resize(&mut self.results, sizes[4]);
        resize(&mut self.rows, sizes[5]);
        resize(&mut self.functions, sizes[6]);
    }

    /// The rates of a group of states.
    fn integrate(&mut self, tape: &Tape, sorter: &Sorter, group: &[usize]) {
        let (n, seats) = (stride(self.order), &sorter.seats[0]);
        let rate = |state: &usize| seats[tape.rates[*state]];
        match together(group.iter().map(rate)) {
            Some(pack) if group.len() > 1 => self.rates.push(Rate::Four(seats[group[0]] / PACK * n, pack * n)),
            _ => self.rates.extend(group.iter().map(|state| Rate::One(place(seats[*state], n), place(rate(state), n)))),
        }
    }

    /// The steps of a group of operations.
    fn operate(&mut self, tape: &Tape, sorter: &Sorter, group: &[usize]) {
        let (n, long, [seats, rows]) = (stride(self.order), row_stride(self.order), &sorter.seats);
        let at = |of: usize| place(seats[of], n);
        let own = seats[group[0]] / PACK * n;
        let ops = || group.iter().filter_map(|place| tape.op(*place));
        let pack = |operand: &dyn Fn(Op) -> usize| together(ops().map(|op| seats[operand(op)]));
        let row = |row: usize| place(rows[row], long);
        let angle = |powers: usize| match tape.op(powers) {
            Some(Op::Powers(_, which) | Op::Led(_, which) | Op::Ahead(_, which, _)) => which,
            _ => 0,
        };
        for op in ops() {
            if let Op::Function(powers, row) | Op::Bend(powers, row) = op {
                let function = (angle(powers), rows[row] / PACK * long);
                if !self.functions.contains(&function) {
                    self.functions.push(function);
                }
            }
        }
        let several = group.len() > 1;
        let Some(first) = ops().next() else { return };
        let four = match first {
            Op::Sum(_, count, _) if several => self.pack_sums(tape, sorter, group, count),
            Op::Product(..) if several => {
                let a = pack(&|op| if let Op::Product(a, _) = op { a } else { 0 });
                let b = pack(&|op| if let Op::Product(_, b) = op { b } else { 0 });
                a.zip(b).map(|(a, b)| Step::Products(a * n, b * n, own))
            }
            Op::Function(powers, _) | Op::Bend(powers, _) if several => {
                let seat = |op| if let Op::Function(_, row) | Op::Bend(_, row) = op { rows[row] } else { NONE };
                together(ops().map(seat)).map(|pack| {
                    let (which, row) = (angle(powers), pack * long);
                    match first {
                        Op::Bend(..) => Step::Bends(which, row, own),
                        _ => Step::Functions(which, row, own),
                    }
                })
            }
            _ => None,
        };
        if let Some(step) = four {
            return self.steps.push(step);
        }
        for (place, op) in group.iter().zip(ops()) {
            let step = match op {
                Op::Sum(first, count, constant) => {
                    self.terms
                        .extend(tape.terms[first..first + count].iter().map(|(place, factor)| (at(*place), *factor)));
                    Step::Sum(self.terms.len() - count, count, constant, at(*place))
                }
                Op::Signal(which) => Step::Signal(row(which), at(*place)),
                Op::Powers(of, which) => Step::Powers(at(of), which),
                Op::Led(of, which) => Step::Led([at(of), at(of + 1)], which),
                Op::Ahead(powers, which, a) => {
                    let Some(Op::Led(of, _)) = tape.op(powers) else { continue };
                    Step::Ahead([at(of), at(of + 1), at(a)], which)
                }
                Op::Function(powers, which) => Step::Function(angle(powers), row(which), at(*place)),
                Op::Bend(powers, which) => Step::Bend(angle(powers), row(which), at(*place)),
                Op::Product(a, b) => Step::Product(at(a), at(b), at(*place)),
                Op::Quotient(a, b) => Step::Quotient(at(a), at(b), at(*place)),
            };
            self.steps.push(step);
        }
    }

    /// Sums with so many terms as one, if their terms lie together.
    fn pack_sums(&mut self, tape: &Tape, sorter: &Sorter, group: &[usize], count: usize) -> Option<Step> {
        let (n, seats, start) = (stride(self.order), &sorter.seats[0], self.packed.len());
        let sums = || {
            group.iter().filter_map(|place| {
                if let Some(Op::Sum(first, _, c)) = tape.op(*place) { Some((first, c)) } else { None }
            })
        };
        for k in 0..count {
            let Some(pack) = together(sums().map(|(first, _)| seats[tape.terms[first + k].0])) else {
                self.packed.truncate(start);
                return None;
            };
            let mut factors = [0.0; PACK];
            factors.iter_mut().zip(sums()).for_each(|(factor, (first, _))| *factor = tape.terms[first + k].1);
            self.packed.push((pack * n, factors));
        }
        let mut constants = [0.0; PACK];
        constants.iter_mut().zip(sums()).for_each(|(own, (_, c))| *own = c);
        Some(Step::Sums(start, count, constants, seats[group[0]] / PACK * n))
    }
}

/// Gives a list room for so many elements and no more.
pub fn resize<T>(own: &mut Vec<T>, count: usize) {
    own.reserve_exact(count.saturating_sub(own.len()));
    own.shrink_to(count);
}

/// Where the series of the number in this seat begins, for packs of series of this length.
fn place(seat: usize, stride: usize) -> usize {
    seat / PACK * PACK * stride + seat % PACK
}

/// What a compilation needs beyond its result.
#[derive(Clone, Debug, Default)]
pub struct Sorter {
    /// For each place how many operations in turn lead to it; [`NONE`] if nothing needs it.
    depths: Vec<usize>,
    /// What distinguishes places that are not to share a pack.
    signs: Vec<u64>,
    /// The needed places, those of equal operations one after another.
    sequence: Vec<usize>,
    /// The seats of places, and of rows, in the packs.
    seats: [Vec<usize>; 2],
}

impl Sorter {
    /// Makes room for so many times as many places and rows as now.
    pub fn make_room(&mut self, times: usize) {
        let [places, rows] = &mut self.seats;
        let all = [&mut self.depths, &mut self.sequence, places, rows];
        all.into_iter().for_each(|own| own.reserve_exact(times * own.capacity() - own.len()));
        self.signs.reserve_exact(times * self.signs.capacity() - self.signs.len());
    }

    /// Finds out what is needed, and puts equal operations one after another, each behind its operands.
    fn sort(&mut self, tape: &Tape, kept: &[usize]) {
        let (states, count) = (tape.states(), tape.states() + tape.ops.len());
        let (depths, signs) = (&mut self.depths, &mut self.signs);
        depths.clear();
        depths.resize(count, NONE);
        signs.clear();
        signs.resize(count, 0);
        depths[..states].fill(0);
        let results = tape.rates.iter().chain(kept).filter(|place| **place != NONE);
        results.for_each(|place| depths[*place] = 0);
        for (i, op) in tape.ops.iter().enumerate().rev() {
            if depths[states + i] != NONE {
                tape.operands(*op, |place| depths[place] = 0);
            }
        }
        signs.iter_mut().zip(&tape.classes[0]).for_each(|(sign, class)| *sign = *class as u64);
        for (i, op) in tape.ops.iter().enumerate() {
            if depths[states + i] == NONE {
                continue;
            }
            let (mut depth, mut sign) = (0, tape.sign(*op));
            tape.operands(*op, |place| {
                depth = depth.max(depths[place]);
                // Multiplication by an odd number with many digits spreads them.
                sign = (sign ^ signs[place]).wrapping_mul(0x9e37_79b9_7f4a_7c15).rotate_left(29);
            });
            (depths[states + i], signs[states + i]) = (depth + 1, sign);
        }
        self.sequence.clear();
        self.sequence.extend((0..count).filter(|place| depths[*place] != NONE));
        // There are few, and most are in order.
        for i in 1..self.sequence.len() {
            let key = |place: usize| (depths[place], signs[place], place);
            let (place, mut j) = (self.sequence[i], i);
            while j > 0 && key(self.sequence[j - 1]) > key(place) {
                self.sequence[j] = self.sequence[j - 1];
                j -= 1;
            }
            self.sequence[j] = place;
        }
    }

    /// The places of a pack from the `start` on; None at the end of the sequence.
    fn group(&self, tape: &Tape, start: usize) -> Option<&[usize]> {
        let first = *self.sequence.get(start)?;
        let equal = |place: &&usize| {
            let same = match [first, **place].map(|place| tape.op(place)) {
                [None, None] | [Some(Op::Product(..)), Some(Op::Product(..))] => true,
                [Some(Op::Sum(_, a, _)), Some(Op::Sum(_, b, _))] => a == b,
                [Some(Op::Function(a, _)), Some(Op::Function(b, _))] => a == b,
                [Some(Op::Bend(a, _)), Some(Op::Bend(b, _))] => a == b,
                _ => false,
            };
            same && self.depths[first] == self.depths[**place] && self.signs[first] == self.signs[**place]
        };
        let others = self.sequence[start + 1..].iter().take(PACK - 1).take_while(equal).count();
        Some(&self.sequence[start..=start + others])
    }

    /// Seats places and rows; returns the numbers of packs.
    fn seat(&mut self, tape: &Tape) -> [usize; 2] {
        let mut seats = std::mem::take(&mut self.seats);
        for (seats, count) in seats.iter_mut().zip([self.depths.len(), tape.classes[1].len()]) {
            seats.clear();
            seats.resize(count, NONE);
        }
        let (mut halls, mut start) = ([Hall::default(), Hall::default()], 0);
        while let Some(group) = self.group(tape, start) {
            start += group.len();
            if !matches!(tape.op(group[0]), Some(Op::Powers(..) | Op::Led(..) | Op::Ahead(..))) {
                halls[0].seat(&mut seats[0], group.iter().copied());
            }
            let rows = || group.iter().filter_map(|place| tape.row(*place));
            if rows().all(|row| seats[1][row] == NONE) {
                halls[1].seat(&mut seats[1], rows());
            }
            rows().for_each(|row| {
                if seats[1][row] == NONE {
                    halls[1].seat(&mut seats[1], std::iter::once(row));
                }
            });
        }
        self.seats = seats;
        halls.map(|hall| hall.packs)
    }
}

/// Packs that are taken, and the next seat in the one for numbers that are alone.
#[derive(Default)]
struct Hall {
    packs: usize,
    next: usize,
}

impl Hall {
    /// Several together take a pack; those that are alone share one.
    fn seat(&mut self, seats: &mut [usize], mut group: impl Iterator<Item = usize>) {
        let (Some(first), second) = (group.next(), group.next()) else { return };
        if second.is_some() {
            let all = [first].into_iter().chain(second).chain(group);
            all.enumerate().for_each(|(lane, place)| seats[place] = PACK * self.packs + lane);
            self.packs += 1;
            return;
        }
        if self.next.is_multiple_of(PACK) {
            self.next = PACK * self.packs;
            self.packs += 1;
        }
        seats[first] = self.next;
        self.next += 1;
    }
}

/// The series of a program.
#[derive(Clone, Debug, Default)]
pub struct Expansion {
    /// The series of states and operations, pack after pack.
    series: Vec<Pack>,
    /// Known series: functions of time, in its unit, and of angles.
    rows: Vec<f64>,
    angles: Vec<Powers>,
    /// The series of the states and of the kept results.
    results: Vec<f64>,
    /// The highest order of the series of a state.
    order: usize,
}

impl Expansion {
    /// Makes room for the series of a program.
    pub fn make_room(&mut self, program: &Program) {
        fn grow<T: Clone>(own: &mut Vec<T>, count: usize, by: T) {
            if own.len() < count {
                own.resize(count, by);
            }
        }
        let ([packs, rows, angles], order) = (program.counts, program.order);
        self.order = order;
        grow(&mut self.series, packs * stride(order), [0.0; PACK]);
        grow(&mut self.rows, PACK * rows * row_stride(order), 0.0);
        grow(&mut self.results, program.results.len() * (order + 1), 0.0);
        grow(&mut self.angles, angles, Powers::default());
        self.angles.iter_mut().for_each(|angle| angle.make_room(stride(order)));
    }

    /// Sets the value of a state.
    pub fn set(&mut self, program: &Program, state: usize, value: f64) {
        self.series.as_flattened_mut()[program.results[state]] = value;
        self.results[state * (self.order + 1)] = value;
    }

    /// Sets the coefficients of a known series, up to three more than the order.
    pub fn set_row(&mut self, program: &Program, row: usize, values: impl Iterator<Item = f64>) {
        let Some(own) = program.rows.get(row).and_then(|at| self.rows.get_mut(*at..)) else { return };
        own.iter_mut().step_by(PACK).zip(values).for_each(|(own, value)| *own = value);
    }

    /// The coefficients of a result: for a state up to the order, for others to one less.
    pub fn series(&self, result: usize) -> &[f64] {
        &self.results[result * (self.order + 1)..][..=self.order]
    }

    /// Computes the coefficients of the states up to `order`, of all others to one order less, in the `unit` of time (s).
    pub fn expand(&mut self, program: &Program, order: usize, unit: f64) {
        self.angles.iter_mut().for_each(|angle| angle.origin = None);
        self.expand_on(program, order, unit);
    }

    /// The same from states close by, without filling the series of functions of an angle anew: c₀ + c₁ δ … about φ(0) are
    /// cₙ + (n + 1) cₙ₊₁ ε about φ(0) + ε up to ε². Afterwards these series have to be filled anew.
    pub fn expand_close_by(&mut self, program: &Program, order: usize, unit: f64) {
        self.expand_on(program, order, unit);
    }

    fn expand_on(&mut self, program: &Program, order: usize, unit: f64) {
        for n in 0..order {
            self.go_on(program, n, unit);
        }
        // Series of a lower order serve the states alone.
        let count = if order < self.order { program.states } else { program.results.len() };
        let results = self.results.chunks_exact_mut(self.order + 1).zip(&program.results).take(count);
        for (k, (result, at)) in results.enumerate() {
            let count = if k < program.states { order + 1 } else { order };
            let series = self.series[at / PACK..][..count].iter().map(|c| c[at % PACK]);
            result.iter_mut().zip(series).for_each(|(own, c)| *own = c);
        }
    }

    /// The coefficients of order n, those of the states of the next one.
    fn go_on(&mut self, program: &Program, n: usize, unit: f64) {
        let Expansion { series, rows, angles, .. } = self;
        let rows = rows.as_chunks_mut::<PACK>().0;
        let twice = ((n + 1) * (n + 2)) as f64 / (unit * unit);
        let now = PACK * n;
        for step in &program.steps {
            let numbers = series.as_flattened_mut();
            match *step {
                Step::Sum(first, count, constant, own) => {
                    let start = if n == 0 { constant } else { 0.0 };
                    let terms = &program.terms[first..first + count];
                    numbers[own + now] = terms.iter().fold(start, |sum, (at, factor)| sum + factor * numbers[at + now]);
                }
                Step::Sums(first, count, constants, own) => {
                    let mut sum = if n == 0 { constants } else { [0.0; PACK] };
                    for (at, factors) in &program.packed[first..first + count] {
                        let c = &series[at + n];
                        (0..PACK).for_each(|k| sum[k] += factors[k] * c[k]);
                    }
                    series[own + n] = sum;
                }
                Step::Signal(row, own) => numbers[own + now] = rows[row / PACK + n][row % PACK],
                Step::Powers(of, which) => {
                    if n == 0 {
                        angles[which].begin(numbers[of], program.functions_of(which), rows);
                    }
                    angles[which].raise(n, numbers[of + now]);
                }
                Step::Led([of, rate], which) => {
                    if n == 0 {
                        angles[which].begin(numbers[of], program.functions_of(which), rows);
                        numbers[of + PACK] = unit * numbers[rate];
                        angles[which].raise(0, numbers[of]);
                        angles[which].raise(1, numbers[of + PACK]);
                    }
                }
                Step::Ahead([of, w, a], which) => {
                    let [first, second] = [n + 1, n + 2].map(|n| unit / n as f64);
                    numbers[w + now + PACK] = first * numbers[a + now];
                    let next = second * numbers[w + now + PACK];
                    numbers[of + now + 2 * PACK] = next;
                    angles[which].raise(n + 2, next);
                }
                Step::Function(which, row, own) => {
                    numbers[own + now] = angles[which].function(n, &rows[row / PACK..], row % PACK);
                }
                Step::Functions(which, row, own) => series[own + n] = angles[which].functions(n, &rows[row..]),
                Step::Bend(which, row, own) => {
                    numbers[own + now] = twice * angles[which].function(n + 2, &rows[row / PACK..], row % PACK);
                }
                Step::Bends(which, row, own) => {
                    series[own + n] = angles[which].functions(n + 2, &rows[row..]).map(|c| twice * c);
                }
                Step::Product(a, b, own) => {
                    let value = product(&series[a / PACK..][..=n], &series[b / PACK..][..=n], [a % PACK, b % PACK]);
                    series.as_flattened_mut()[own + now] = value;
                }
                Step::Products(a, b, own) => series[own + n] = products(&series[a..][..=n], &series[b..][..=n]),
                Step::Quotient(a, b, own) => {
                    let lanes = [own % PACK, b % PACK];
                    let rest = product(&series[own / PACK..][..n], &series[b / PACK + 1..][..n], lanes);
                    let numbers = series.as_flattened_mut();
                    numbers[own + now] = (numbers[a + now] - rest) / numbers[b];
                }
            }
        }
        let factor = unit / (n + 1) as f64;
        for rate in &program.rates {
            match *rate {
                Rate::One(state, rate) => {
                    let numbers = series.as_flattened_mut();
                    numbers[state + now + PACK] = factor * numbers[rate + now];
                }
                Rate::Four(state, rate) => series[state + n + 1] = series[rate + n].map(|c| factor * c),
            }
        }
    }
}

/// Σ aᵢ b_{n−i} of these lanes of two packs.
fn product(a: &[Pack], b: &[Pack], lanes: [usize; 2]) -> f64 {
    let [i, j] = lanes.map(|lane| lane % PACK);
    a.iter().zip(b.iter().rev()).fold(0.0, |sum, (a, b)| sum + a[i] * b[j])
}

/// The same of all lanes. Two sums at a time hide how long an addition takes.
fn products(a: &[Pack], b: &[Pack]) -> Pack {
    let ((a, a_rest), (b_rest, b)) = (a.as_chunks::<2>(), b.as_rchunks::<2>());
    let mut sums = [[0.0; PACK]; 2];
    for (a, b) in a.iter().zip(b.iter().rev()) {
        for k in 0..PACK {
            sums[0][k] += a[0][k] * b[1][k];
            sums[1][k] += a[1][k] * b[0][k];
        }
    }
    for (a, b) in a_rest.iter().zip(b_rest) {
        (0..PACK).for_each(|k| sums[0][k] += a[k] * b[k]);
    }
    std::array::from_fn(|k| sums[0][k] + sums[1][k])
}

/// Σ aᵢ b_{n−i} of numbers and packs.
fn scaled(a: &[f64], b: &[Pack]) -> Pack {
    let ((a, a_rest), (b_rest, b)) = (a.as_chunks::<2>(), b.as_rchunks::<2>());
    let mut sums = [[0.0; PACK]; 2];
    for (a, b) in a.iter().zip(b.iter().rev()) {
        for k in 0..PACK {
            sums[0][k] += a[0] * b[1][k];
            sums[1][k] += a[1] * b[0][k];
        }
    }
    for (a, b) in a_rest.iter().zip(b_rest) {
        (0..PACK).for_each(|k| sums[0][k] += a * b[k]);
    }
    std::array::from_fn(|k| sums[0][k] + sums[1][k])
}

/// The powers of δ = φ − φ(0) by orders.
#[derive(Clone, Debug, Default)]
struct Powers {
    /// φ(0) about which functions of φ are known; None before the first series about it.
    origin: Option<f64>,
    /// δ and δ⁴.
    delta: Vec<f64>,
    fourth: Vec<f64>,
    /// The last coefficient of δ that is not zero.
    last: usize,
    /// δ⁴ⁱ … δ⁴ⁱ⁺³ as packs, one i after another.
    powers: Vec<Pack>,
}

impl Powers {
    /// Makes room for so many orders.
    fn make_room(&mut self, count: usize) {
        if self.delta.len() != count {
            [&mut self.delta, &mut self.fourth].into_iter().for_each(|own| own.resize(count, 0.0));
            self.powers.resize(count.div_ceil(PACK) * count, [0.0; PACK]);
        }
    }

    /// Begins at this angle, and moves the functions of it there.
    fn begin(&mut self, angle: f64, functions: impl Iterator<Item = usize>, rows: &mut [Pack]) {
        let away = angle - *self.origin.get_or_insert(angle);
        if away == 0.0 {
            return;
        }
        for row in functions {
            let own = &mut rows[row..][..whole(self.delta.len() + 1)];
            for n in 1..own.len() {
                let next = own[n];
                (0..PACK).for_each(|k| own[n - 1][k] += n as f64 * away * next[k]);
            }
        }
        self.origin = Some(angle);
    }

    /// The coefficients of order n, with that of φ. Powers follow from those four lower: the product with δ⁴ has fewer terms.
    fn raise(&mut self, n: usize, c: f64) {
        let count = self.delta.len();
        if n == 0 {
            (self.last, self.powers[0]) = (0, [1.0, 0.0, 0.0, 0.0]);
            return;
        }
        self.delta[n] = c;
        // Of a straight course there is one.
        self.last = if c == 0.0 { self.last } else { n };
        let [one, two, three, four] = scaled(&self.delta[1..=self.last], &self.powers[n - self.last..n]);
        (self.powers[n], self.fourth[n]) = ([0.0, one, two, three], four);
        for i in 1..=n / PACK {
            let last = (PACK * self.last).clamp(PACK, n + PACK - PACK * i);
            let lower = &self.powers[(i - 1) * count..][..=n - PACK];
            self.powers[i * count + n] = scaled(&self.fourth[PACK..=last], &lower[n - last..]);
        }
    }

    /// The coefficients of order n of functions with these coefficients.
    fn functions(&self, n: usize, c: &[Pack]) -> Pack {
        let mut sums = [[0.0; PACK]; 2];
        for (c, powers) in
            c.as_chunks::<PACK>().0[..=n / PACK].iter().zip(self.powers[n..].iter().step_by(self.delta.len()))
        {
            for k in 0..PACK {
                sums[0][k] = sums[0][k] + c[0][k] * powers[0] + c[1][k] * powers[1];
                sums[1][k] = sums[1][k] + c[2][k] * powers[2] + c[3][k] * powers[3];
            }
        }
        std::array::from_fn(|k| sums[0][k] + sums[1][k])
    }

    /// The same of one of them.
    fn function(&self, n: usize, c: &[Pack], lane: usize) -> f64 {
        let rows = c.as_chunks::<PACK>().0[..=n / PACK].iter();
        let powers = self.powers[n..].iter().step_by(self.delta.len());
        let lane = lane % PACK;
        rows.zip(powers).fold(0.0, |sum, (c, powers)| {
            sum + ((c[0][lane] * powers[0] + c[1][lane] * powers[1])
                + (c[2][lane] * powers[2] + c[3][lane] * powers[3]))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::tape::Var;
    use super::super::taylor::Arithmetic;
    use super::*;
    use std::cell::RefCell;

    /// A program and its series.
    struct Ready(Program, Expansion);

    impl Ready {
        fn of(tape: &Tape, order: usize, kept: &mut [usize]) -> Self {
            let (mut program, mut expansion) = (Program::default(), Expansion::default());
            program.compile(tape, order, kept, &mut Sorter::default());
            expansion.make_room(&program);
            Ready(program, expansion)
        }

        /// The series of the results from these states.
        fn expand(&mut self, start: &[f64], order: usize, unit: f64) {
            start.iter().enumerate().for_each(|(k, y)| self.1.set(&self.0, k, *y));
            self.1.expand(&self.0, order, unit);
        }
    }

    /// Records ẏ = f(y) and expands it from `start`.
    fn expanded<const N: usize>(start: [f64; N], f: impl Fn([Var; N]) -> [Var; N]) -> Expansion {
        let mut tape = Tape::default();
        tape.begin(0..N);
        let tape = RefCell::new(tape);
        f(std::array::from_fn(|k| Var::state(&tape, k))).into_iter().for_each(|rate| rate.is_rate(&tape));
        let mut ready = Ready::of(&tape.into_inner(), 20, &mut []);
        ready.expand(&start, 20, 0.5);
        ready.1
    }

    #[test]
    fn the_series_of_known_solutions() {
        // y = 1/(1 + t): ẏ = −y²; z = √(1 + 2t) by ż = 1/z; v = (1 + t)² by v̇ = 2 √v, as 2 w, ẇ = 1.
        let found = expanded([1.0, 1.0, 1.0], |[y, z, w]| [-(y * y), Var::from(1.0) / z, Var::from(1.0) + w * 0.0]);
        // The unit of time is half a second.
        for n in 0..=20 {
            assert!((found.series(0)[n] - (-0.5_f64).powi(n as i32)).abs() < 1e-15);
        }
        // √(1 + 2t) = Σ C(½, n) (2t)ⁿ at 2t = τ.
        let mut binomial = 1.0;
        for n in 0..=20 {
            assert!((found.series(1)[n] - binomial).abs() < 1e-14, "{n}");
            binomial *= (0.5 - n as f64) / (n + 1) as f64;
        }
        assert_eq!(found.series(2)[..3], [1.0, 0.5, 0.0]);
    }

    #[test]
    fn equal_parts_share_packs_and_keep_their_own_numbers() {
        // Six vibrations of one class, q̈ = −c q − f(q) q̇, of which the places of one or five or six make no pack.
        let coefficient = |j: usize| 0.3 + 0.1 * j as f64;
        let of = |count: usize| {
            let mut tape = Tape::default();
            tape.begin((0..2 * count).map(|k| k % 2));
            let tape = RefCell::new(tape);
            let state = |k: usize| Var::state(&tape, k);
            for j in 0..count {
                let [q, v] = [state(2 * j), state(2 * j + 1)];
                v.is_rate(&tape);
                (-(q * coefficient(j)) - q * v).is_rate(&tape);
            }
            let mut ready = Ready::of(&tape.into_inner(), 12, &mut []);
            let start: Vec<f64> = (0..2 * count).map(|k| 0.1 * (k + 1) as f64).collect();
            ready.expand(&start, 12, 0.7);
            ready
        };
        let packs =
            |Ready(program, _): &Ready| program.steps.iter().filter(|step| matches!(step, Step::Products(..))).count();
        let six = of(6);
        assert_eq!((packs(&six), packs(&of(1))), (2, 0));
        for j in 0..6 {
            let [q, v] = [0, 1].map(|k| six.1.series(2 * j + k));
            assert_eq!(q[0], 0.1 * (2 * j + 1) as f64);
            for n in 0..12 {
                let rate: f64 = -coefficient(j) * q[n] - (0..=n).map(|i| q[i] * v[n - i]).sum::<f64>();
                assert!((q[n + 1] * (n + 1) as f64 - 0.7 * v[n]).abs() < 1e-15);
                assert!((v[n + 1] * (n + 1) as f64 - 0.7 * rate).abs() < 1e-14, "{j} {n}");
            }
        }
    }

    #[test]
    fn functions_of_an_angle_are_those_of_its_series() {
        // φ̈ = −sin φ with the series of the sine about φ(0): the energy ½ φ̇² − cos φ stays.
        let mut tape = Tape::default();
        tape.begin(0..2);
        let rows = [0, 1].map(|class| tape.new_row(class));
        let tape = RefCell::new(tape);
        let [phi, w] = [0, 1].map(|k| Var::state(&tape, k));
        let powers = phi.powers(&tape);
        let [sine, cosine] = rows.map(|row| Var::function(&tape, powers, row));
        w.is_rate(&tape);
        (-sine).is_rate(&tape);
        // The acceleration of the sine from its series, and by the chain rule.
        let (bend, chain) = (Var::bend([sine, cosine, -sine], w, -sine), -(sine * (w * w)) - cosine * sine);
        let mut kept = [w * w * 0.5 - cosine, sine, bend, chain].map(|result| result.place(&tape));
        let Ready(program, mut expansion) = Ready::of(&tape.into_inner(), 24, &mut kept);
        let mut coefficients = [[0.0; 27]; 2];
        let mut factorial = 1.0;
        for n in 0..27 {
            factorial *= (n as f64).max(1.0);
            let (s, c) = (1.0 + n as f64 * std::f64::consts::FRAC_PI_2).sin_cos();
            (coefficients[0][n], coefficients[1][n]) = (s / factorial, c / factorial);
        }
        rows.iter().zip(coefficients).for_each(|(row, c)| expansion.set_row(&program, *row, c.into_iter()));
        expansion.set(&program, 0, 1.0);
        expansion.set(&program, 1, 0.7);
        expansion.expand(&program, 24, 0.3);
        let [energy, sine, bend, chain] = kept.map(|result| expansion.series(result));
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
