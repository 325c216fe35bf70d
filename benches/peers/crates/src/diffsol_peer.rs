//! The crate `diffsol`: Tsitouras 5(4) and BDF, dense output by `interpolate`, events by its root finding.

use crate::works::{BACKLASH, STEPS, backlash, output_time, smooth};
use diffsol::{NalgebraLU, NalgebraMat, OdeBuilder, OdeSolverMethod, OdeSolverStopReason, Vector};
use std::cell::Cell;

type Matrix = NalgebraMat<f64>;

/// The step of the difference quotient that stands for the Jacobian.
const DIFFERENCE: f64 = 1e-7;

macro_rules! method {
    ($name:ident, $solver:ident $(::<$linear:ty>)?) => {
        pub fn $name(work: usize, tolerance: f64, out: &mut [[f64; 2]]) -> Option<()> {
            if work == BACKLASH {
                let flank = Cell::new(backlash::start().1);
                let problem = OdeBuilder::<Matrix>::new()
                    .rtol(tolerance)
                    .atol([tolerance; 4])
                    .h0(1e-5)
                    .rhs_implicit(
                        |y, _, t, f| f.copy_from_slice(&backlash::rate(t, y, flank.get())),
                        |y, _, t, v, f| {
                            let moved: [f64; 4] = std::array::from_fn(|i| y[i] + DIFFERENCE * v[i]);
                            let (f0, f1) = (backlash::rate(t, y, flank.get()), backlash::rate(t, &moved, flank.get()));
                            (0..4).for_each(|i| f[i] = (f1[i] - f0[i]) / DIFFERENCE);
                        },
                    )
                    .init(|_, _, y| y.copy_from_slice(&backlash::start().0), 4)
                    .root(
                        |y, _, t, g| match flank.get() {
                            0 => {
                                g[0] = backlash::gap(t, y, 1);
                                g[1] = backlash::gap(t, y, -1);
                            }
                            side => {
                                g[0] = backlash::force(t, y, side);
                                g[1] = 1.0;
                            }
                        },
                        2,
                    )
                    .build()
                    .expect("a problem");
                return run_backlash(problem.$solver$(::<$linear>)?().expect("a solver"), &flank, out);
            }
            let equation = smooth(work);
            let corner = (equation.corner * 1e3).round() as usize;
            let mut y = equation.start;
            for [first, last] in [[0, corner], [corner, STEPS[work]]] {
                if first == last {
                    continue;
                }
                let start = y;
                let problem = OdeBuilder::<Matrix>::new()
                    .t0(output_time(first))
                    .rtol(tolerance)
                    .atol([tolerance; 2])
                    .h0(1e-4)
                    .rhs_implicit(
                        |y, _, t, f| f.copy_from_slice(&(equation.rate)(t, [y[0], y[1]])),
                        |y, _, t, v, f| {
                            let f0 = (equation.rate)(t, [y[0], y[1]]);
                            let f1 = (equation.rate)(t, [y[0] + DIFFERENCE * v[0], y[1] + DIFFERENCE * v[1]]);
                            (0..2).for_each(|i| f[i] = (f1[i] - f0[i]) / DIFFERENCE);
                        },
                    )
                    .init(move |_, _, y| y.copy_from_slice(&start), 2)
                    .build()
                    .expect("a problem");
                let mut solver = problem.$solver$(::<$linear>)?().expect("a solver");
                solver.set_stop_time(output_time(last)).expect("a stop time");
                let mut at = solver.state().y.clone();
                let mut i = first;
                while i < last {
                    solver.step().expect("a step");
                    while i < last && output_time(i + 1) <= solver.state().t {
                        solver.interpolate_inplace(output_time(i + 1), &mut at).expect("a state in the step");
                        y = [at.get_index(0), at.get_index(1)];
                        out[i] = [y[0] * equation.scale[0], y[1] * equation.scale[1]];
                        i += 1;
                    }
                }
            }
            Some(())
        }
    };
}
method!(tsit45, tsit45);
method!(bdf, bdf::<NalgebraLU<f64>>);

fn four(y: &impl Vector<T = f64>) -> [f64; 4] {
    std::array::from_fn(|i| y.get_index(i))
}

fn run_backlash<'a, Eqn>(
    mut solver: impl OdeSolverMethod<'a, Eqn>,
    flank: &Cell<i32>,
    out: &mut [[f64; 2]],
) -> Option<()>
where
    Eqn: diffsol::OdeEquations<T = f64> + 'a,
{
    let mut at = solver.state().y.clone();
    let (mut i, mut events) = (0, 0);
    while i < out.len() {
        let reason = solver.step().expect("a step");
        let until = match reason {
            OdeSolverStopReason::RootFound(t, _) => t,
            _ => solver.state().t,
        };
        while i < out.len() && output_time(i + 1) <= until {
            let t = output_time(i + 1);
            solver.interpolate_inplace(t, &mut at).expect("a state in the step");
            out[i] = backlash::outputs(t, &four(&at), flank.get());
            i += 1;
        }
        if let OdeSolverStopReason::RootFound(t, index) = reason {
            events += 1;
            assert!(events < 20_000, "events without end");
            solver.state_mut_back(t).expect("the state at the root");
            let state = solver.state_mut();
            let mut y = four(state.y);
            let was = flank.get();
            let side = if was != 0 {
                was
            } else if index == 0 {
                1
            } else {
                -1
            };
            let approach = f64::from(side) * (y[3] - backlash::on_flank(t, side)[1]);
            // A flight begins with a gap of zero, and its sign is noise: only an approach is an impact.
            if was != 0 || approach < -1e-10 {
                flank.set(backlash::after_event(t, &mut y, was, side));
            }
            let rate = backlash::rate(t, &y, flank.get());
            for k in 0..4 {
                state.y.set_index(k, y[k]);
                state.dy.set_index(k, rate[k]);
            }
        }
    }
    Some(())
}
