//! The crate `ode_solvers`: Dormand-Prince 5(4) and 8(5,3) with dense output. It has no events, so no backlash.

use crate::works::{STEPS, Smooth, Work, output_time, work};
use ode_solvers::{Dop853, Dopri5, OutputType, SVector, System};

struct Equation<const N: usize>(Smooth<N>);

impl<const N: usize> System<f64, SVector<f64, N>> for Equation<N> {
    fn system(&self, t: f64, y: &SVector<f64, N>, dy: &mut SVector<f64, N>) {
        *dy = SVector::from((self.0.rate)(t, y.data.0[0]));
    }
}

macro_rules! method {
    ($name:ident, $type:ident, $beta:literal, $fac_min:literal, $fac_max:literal) => {
        pub fn $name(number: usize, tolerance: f64, out: &mut [[f64; 2]]) -> Option<()> {
            macro_rules! integrate {
                () => {
                    |equation, from, to, y| {
                        // The parameters of `new`, but for the limit on steps and the test for stiffness, which is
                        // wrong here.
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
                    }
                };
            }
            match work(number) {
                Work::Two(equation) => solve(equation, STEPS[number], out, integrate!()),
                Work::Nine(equation) => solve(equation, STEPS[number], out, integrate!()),
                Work::Backlash | Work::TrainBacklash => return None,
            }
            Some(())
        }
    };
}
method!(dopri5, Dopri5, 0.04, 0.2, 10.0);
method!(dop853, Dop853, 0.0, 0.333, 6.0);

fn solve<const N: usize>(
    equation: Smooth<N>,
    steps: usize,
    out: &mut [[f64; 2]],
    integrate: impl Fn(Smooth<N>, f64, f64, SVector<f64, N>) -> (Vec<f64>, Vec<SVector<f64, N>>),
) {
    let corner = (equation.corner * 1e3).round() as usize;
    let pieces: &[[usize; 2]] = if corner > 0 { &[[0, corner], [corner, steps]] } else { &[[0, steps]] };
    let mut y = SVector::from(equation.start);
    for &[first, last] in pieces {
        // One output further: at the very end the crate extrapolates from the step before.
        let (times, states) = integrate(equation, output_time(first), output_time(last + 1), y);
        for i in first + 1..=last {
            // The crate sums its output times; what that shifts them by is made good to first order.
            let k = i - first;
            let (x, at) = (times[k], states[k]);
            let rate = SVector::from((equation.rate)(x, at.data.0[0]));
            y = at + rate * (output_time(i) - x);
            out[i - 1] = equation.put(&y.data.0[0]);
        }
    }
}
