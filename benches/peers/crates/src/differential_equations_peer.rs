//! The crate `differential-equations`: Dormand-Prince 5(4) and 8(5,3), Verner 9(8) with its interpolant.

use crate::works::{BACKLASH, STEPS, Smooth, backlash, output_time, smooth};
use differential_equations::interpolate::Interpolation;
use differential_equations::prelude::*;
use std::cell::Cell;

struct Equation(Smooth);

impl ODE<f64, [f64; 2]> for Equation {
    fn diff(&self, t: f64, y: &[f64; 2], dydt: &mut [f64; 2]) {
        *dydt = (self.0.rate)(t, *y);
    }
}

macro_rules! method {
    ($name:ident, $constructor:ident) => {
        pub fn $name(work: usize, tolerance: f64, out: &mut [[f64; 2]]) -> Option<()> {
            macro_rules! configured {
                () => {
                    ExplicitRungeKutta::$constructor().rtol(tolerance).atol(tolerance).max_steps(10_000_000)
                };
            }
            if work == BACKLASH {
                let drive = Backlash { flank: Cell::new(backlash::start().1) };
                let end = output_time(STEPS[work]);
                let outputs = Outputs { drive: &drive, out, next: 0, left: 0, events: 0 };
                let ivp = IVP::ode(&drive, 0.0, end, backlash::start().0).method(configured!()).solout(outputs);
                ivp.solve().expect("a solution");
                return Some(());
            }
            let equation = Equation(smooth(work));
            let corner = (equation.0.corner * 1e3).round() as usize;
            let mut y = equation.0.start;
            for [first, last] in [[0, corner], [corner, STEPS[work]]] {
                if first == last {
                    continue;
                }
                let times: Vec<f64> = (first + 1..=last).map(output_time).collect();
                let ivp = IVP::ode(&equation, output_time(first), output_time(last), y);
                let solution = ivp.method(configured!()).t_eval(times).solve().expect("a solution");
                for (into, at) in out[first..last].iter_mut().zip(&solution.y) {
                    *into = [at[0] * equation.0.scale[0], at[1] * equation.0.scale[1]];
                }
                y = *solution.y.last().expect("a state");
            }
            Some(())
        }
    };
}
method!(dopri5, dopri5);
method!(dop853, dop853);
method!(rkv98, rkv989e);

/// The backlash, with the mode in a cell that the handler of outputs and events shares.
struct Backlash {
    flank: Cell<i32>,
}

impl ODE<f64, [f64; 4]> for Backlash {
    fn diff(&self, t: f64, y: &[f64; 4], dydt: &mut [f64; 4]) {
        *dydt = backlash::rate(t, y, self.flank.get());
    }
}

struct Outputs<'a> {
    drive: &'a Backlash,
    out: &'a mut [[f64; 2]],
    next: usize,
    left: i32,
    events: usize,
}

impl Outputs<'_> {
    fn put(&mut self, t: f64, y: &[f64; 4]) {
        self.out[self.next] = backlash::outputs(t, y, self.drive.flank.get());
        self.next += 1;
    }

    /// The flank at which something happens before t, or 0.
    fn event(&self, t: f64, y: &[f64; 4]) -> i32 {
        match self.drive.flank.get() {
            0 => [-self.left, self.left].into_iter().find(|&side| backlash::gap(t, y, side) < 0.0).unwrap_or(0),
            flank if backlash::force(t, y, flank) < 0.0 => flank,
            _ => 0,
        }
    }
}

impl Solout<f64, [f64; 4]> for Outputs<'_> {
    fn solout<I>(
        &mut self,
        t: f64,
        before: f64,
        y: &[f64; 4],
        _: &[f64; 4],
        interpolator: &mut I,
        _: &mut Solution<f64, [f64; 4]>,
    ) -> ControlFlag<f64, [f64; 4]>
    where
        I: Interpolation<f64, [f64; 4]> + ?Sized,
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
                self.drive.flank.set(backlash::after_event(at, &mut state, flank, side));
                return ControlFlag::ModifyState(at, state);
            }
            if at == output {
                self.put(at, &state);
            }
            low = at;
        }
        ControlFlag::Continue
    }
}
