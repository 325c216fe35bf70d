//! The crate `ode_solvers`: Dormand-Prince 5(4) and 8(5,3) with dense output. It has no events, so no backlash.

use crate::works::{BACKLASH, STEPS, Smooth, output_time, smooth};
use ode_solvers::{Dop853, Dopri5, OutputType, SVector, System};

type State = SVector<f64, 2>;

struct Equation(Smooth);

impl System<f64, State> for Equation {
    fn system(&self, t: f64, y: &State, dy: &mut State) {
        *dy = State::from((self.0.rate)(t, [y[0], y[1]]));
    }
}

macro_rules! method {
    ($name:ident, $type:ident, $beta:literal, $fac_min:literal, $fac_max:literal) => {
        pub fn $name(work: usize, tolerance: f64, out: &mut [[f64; 2]]) -> Option<()> {
            solve(work, out, |equation, from, to, y| {
                // The parameters of `new`, but for the limit on steps and the test for stiffness, which is wrong here.
                let (f, span, never) = (Equation(equation), to - from, 1_000_000);
                let mut solver = $type::from_param(
                    f,
                    from,
                    to,
                    1e-3,
                    y,
                    tolerance,
                    tolerance,
                    0.9,
                    $beta,
                    $fac_min,
                    $fac_max,
                    span,
                    0.0,
                    never,
                    never,
                    OutputType::Dense,
                );
                solver.integrate().expect("a solution");
                let (x, y) = solver.results().get();
                (x.clone(), y.clone())
            })
        }
    };
}
method!(dopri5, Dopri5, 0.04, 0.2, 10.0);
method!(dop853, Dop853, 0.0, 0.333, 6.0);

fn solve(
    work: usize,
    out: &mut [[f64; 2]],
    integrate: impl Fn(Smooth, f64, f64, State) -> (Vec<f64>, Vec<State>),
) -> Option<()> {
    if work == BACKLASH {
        return None;
    }
    let equation = smooth(work);
    let corner = (equation.corner * 1e3).round() as usize;
    let pieces: &[[usize; 2]] = if corner > 0 { &[[0, corner], [corner, STEPS[work]]] } else { &[[0, STEPS[work]]] };
    let mut y = State::from(equation.start);
    for &[first, last] in pieces {
        // One output further: at the very end the crate extrapolates from the step before.
        let (times, states) = integrate(equation, output_time(first), output_time(last + 1), y);
        for i in first + 1..=last {
            // The crate sums its output times; what that shifts them by is made good to first order.
            let k = i - first;
            let (x, at) = (times[k], states[k]);
            let rate = State::from((equation.rate)(x, [at[0], at[1]]));
            let exact = at + rate * (output_time(i) - x);
            out[i - 1] = [exact[0] * equation.scale[0], exact[1] * equation.scale[1]];
            y = exact;
        }
    }
    Some(())
}
