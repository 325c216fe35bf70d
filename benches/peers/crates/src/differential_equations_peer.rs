//! The crate `differential-equations`: Dormand-Prince 5(4) and 8(5,3), Verner 9(8) with its interpolant.

use crate::works::{Backlash, Drive, STEPS, Smooth, TrainBacklash, Work, output_time, work};
use differential_equations::interpolate::Interpolation;
use differential_equations::prelude::*;
use std::cell::Cell;
use std::marker::PhantomData;

struct Equation<const N: usize>(Smooth<N>);

impl<const N: usize> ODE<f64, [f64; N]> for Equation<N> {
    fn diff(&self, t: f64, y: &[f64; N], dydt: &mut [f64; N]) {
        *dydt = (self.0.rate)(t, *y);
    }
}

macro_rules! method {
    ($name:ident, $constructor:ident) => {
        pub fn $name(number: usize, tolerance: f64, out: &mut [[f64; 2]]) -> Option<()> {
            macro_rules! configured {
                () => {
                    ExplicitRungeKutta::$constructor().rtol(tolerance).atol(tolerance).max_steps(10_000_000)
                };
            }
            macro_rules! backlash {
                ($drive:ty) => {{
                    let (start, flank) = <$drive>::start();
                    let drive = Contact::<$drive> { flank: Cell::new(flank), drive: PhantomData };
                    let outputs = Outputs { drive: &drive, out, next: 0, left: 0, events: 0 };
                    // An end further away than any step: the crate refuses to restart less than a step before it.
                    let ivp = IVP::ode(&drive, 0.0, output_time(STEPS[number]) + 1.0, start);
                    ivp.method(configured!()).solout(outputs).solve().expect("a solution");
                }};
            }
            macro_rules! smooth {
                ($equation:ident) => {{
                    let corner = ($equation.corner * 1e3).round() as usize;
                    let mut y = $equation.start;
                    for [first, last] in [[0, corner], [corner, STEPS[number]]] {
                        if first == last {
                            continue;
                        }
                        let times: Vec<f64> = (first + 1..=last).map(output_time).collect();
                        let equation = Equation($equation);
                        let ivp = IVP::ode(&equation, output_time(first), output_time(last), y);
                        let solution = ivp.method(configured!()).t_eval(times).solve().expect("a solution");
                        for (into, at) in out[first..last].iter_mut().zip(&solution.y) {
                            *into = $equation.put(at);
                        }
                        y = *solution.y.last().expect("a state");
                    }
                }};
            }
            match work(number) {
                Work::Two(equation) => smooth!(equation),
                Work::Nine(equation) => smooth!(equation),
                Work::Backlash => backlash!(Backlash),
                Work::TrainBacklash => backlash!(TrainBacklash),
            }
            Some(())
        }
    };
}
method!(dopri5, dopri5);
method!(dop853, dop853);
method!(rkv98, rkv989e);

/// A drive with backlash, with the mode in a cell that the handler of outputs and events shares.
struct Contact<D> {
    flank: Cell<i32>,
    drive: PhantomData<D>,
}

impl<const N: usize, D: Drive<N>> ODE<f64, [f64; N]> for Contact<D> {
    fn diff(&self, t: f64, y: &[f64; N], dydt: &mut [f64; N]) {
        *dydt = D::rate(t, y, self.flank.get());
    }
}

struct Outputs<'a, D> {
    drive: &'a Contact<D>,
    out: &'a mut [[f64; 2]],
    next: usize,
    left: i32,
    events: usize,
}

impl<D> Outputs<'_, D> {
    fn put<const N: usize>(&mut self, t: f64, y: &[f64; N])
    where
        D: Drive<N>,
    {
        self.out[self.next] = D::outputs(t, y, self.drive.flank.get());
        self.next += 1;
    }

    /// The flank at which something happens before t, or 0.
    fn event<const N: usize>(&self, t: f64, y: &[f64; N]) -> i32
    where
        D: Drive<N>,
    {
        // A flight begins with a gap of zero, and its sign is noise: only an approach is an impact.
        let approaches = |side: i32| f64::from(side) * (y[N - 1] - D::on_flank(t, y, side)[1]) < 0.0;
        let hits = |side: i32| D::gap(t, y, side) < 0.0 && (side != self.left || approaches(side));
        match self.drive.flank.get() {
            0 => [-self.left, self.left].into_iter().find(|&side| hits(side)).unwrap_or(0),
            flank if D::force(t, y, flank) < 0.0 => flank,
            _ => 0,
        }
    }
}

impl<const N: usize, D: Drive<N>> Solout<f64, [f64; N]> for Outputs<'_, D> {
    fn solout<I>(
        &mut self,
        t: f64,
        before: f64,
        y: &[f64; N],
        _: &[f64; N],
        interpolator: &mut I,
        _: &mut Solution<f64, [f64; N]>,
    ) -> ControlFlag<f64, [f64; N]>
    where
        I: Interpolation<f64, [f64; N]> + ?Sized,
    {
        if t <= before {
            return ControlFlag::Continue;
        }
        // Guards are looked at wherever an output lies in the step, and at its end.
        let mut low = before;
        while low < t {
            let output = if self.next < self.out.len() { output_time(self.next + 1) } else { f64::INFINITY };
            let mut at = output.min(t);
            let mut state = if at < t { interpolator.interpolate(at).expect("a state in the step") } else { *y };
            let side = self.event(at, &state);
            if side != 0 {
                // Bisection on the interpolant, as finely as time is resolved.
                for _ in 0..60 {
                    let middle = 0.5 * (low + at);
                    if !(middle > low && middle < at) {
                        break;
                    }
                    let there = interpolator.interpolate(middle).expect("a state in the step");
                    if self.event(middle, &there) != 0 {
                        (at, state) = (middle, there);
                    } else {
                        low = middle;
                    }
                }
                self.events += 1;
                assert!(self.events < 20_000, "events without end");
                let side = self.event(at, &state);
                let flank = self.drive.flank.get();
                self.left = side;
                self.drive.flank.set(D::after_event(at, &mut state, flank, side));
                return ControlFlag::ModifyState(at, state);
            }
            if at == output {
                self.put(at, &state);
                if self.next == self.out.len() {
                    return ControlFlag::Terminate;
                }
            }
            low = at;
        }
        ControlFlag::Continue
    }
}
