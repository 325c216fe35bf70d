//! The crate `diffsol`: Tsitouras 5(4) and BDF, dense output by `interpolate`, events by its root finding.

use crate::works::{Backlash, Drive, STEPS, TrainBacklash, Work, output_time, work};
use diffsol::{NalgebraLU, NalgebraMat, OdeBuilder, OdeSolverMethod, OdeSolverStopReason, Vector};
use std::cell::Cell;

type Matrix = NalgebraMat<f64>;

/// The step of the difference quotient that stands for the Jacobian.
const DIFFERENCE: f64 = 1e-7;

/// J v of a right-hand side by a difference quotient.
fn jacobian<const N: usize>(rate: impl Fn(&[f64; N]) -> [f64; N], y: [f64; N], v: [f64; N], f: &mut [f64]) {
    let moved: [f64; N] = std::array::from_fn(|i| y[i] + DIFFERENCE * v[i]);
    let (f0, f1) = (rate(&y), rate(&moved));
    (0..N).for_each(|i| f[i] = (f1[i] - f0[i]) / DIFFERENCE);
}

fn all<const N: usize>(y: &[f64]) -> [f64; N] {
    y.try_into().expect("all states")
}

fn state<const N: usize>(y: &impl Vector<T = f64>) -> [f64; N] {
    std::array::from_fn(|i| y.get_index(i))
}

macro_rules! method {
    ($name:ident, $solver:ident $(::<$linear:ty>)?) => {
        pub fn $name(number: usize, tolerance: f64, out: &mut [[f64; 2]]) -> Option<()> {
            macro_rules! backlash {
                ($drive:ty, $n:literal) => {{
                    let (start, side) = <$drive>::start();
                    let flank = Cell::new(side);
                    let rate = |t: f64, y: &[f64; $n]| <$drive>::rate(t, y, flank.get());
                    let problem = OdeBuilder::<Matrix>::new()
                        .rtol(tolerance)
                        .atol([tolerance; $n])
                        .h0(1e-5)
                        .rhs_implicit(
                            |y, _, t, f| f.copy_from_slice(&rate(t, &all(y))),
                            |y, _, t, v, f| jacobian(|y| rate(t, y), all(y), all(v), f),
                        )
                        .init(|_, _, y| y.copy_from_slice(&start), $n)
                        .root(
                            |y, _, t, g| {
                                let y = all::<$n>(y);
                                match flank.get() {
                                    0 => {
                                        g[0] = <$drive>::gap(t, &y, 1);
                                        g[1] = <$drive>::gap(t, &y, -1);
                                    }
                                    side => {
                                        g[0] = <$drive>::force(t, &y, side);
                                        g[1] = 1.0;
                                    }
                                }
                            },
                            2,
                        )
                        .build()
                        .expect("a problem");
                    let solver = problem.$solver$(::<$linear>)?().expect("a solver");
                    run_backlash::<$n, $drive, _>(solver, &flank, out);
                }};
            }
            macro_rules! smooth {
                ($equation:ident, $n:literal) => {{
                    let corner = ($equation.corner * 1e3).round() as usize;
                    let mut y = $equation.start;
                    for [first, last] in [[0, corner], [corner, STEPS[number]]] {
                        if first == last {
                            continue;
                        }
                        let start = y;
                        let problem = OdeBuilder::<Matrix>::new()
                            .t0(output_time(first))
                            .rtol(tolerance)
                            .atol([tolerance; $n])
                            .h0(1e-4)
                            .rhs_implicit(
                                |y, _, t, f| f.copy_from_slice(&($equation.rate)(t, all(y))),
                                |y, _, t, v, f| {
                                    jacobian(|y| ($equation.rate)(t, *y), all(y), all(v), f);
                                },
                            )
                            .init(move |_, _, y| y.copy_from_slice(&start), $n)
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
                                y = state(&at);
                                out[i] = $equation.put(&y);
                                i += 1;
                            }
                        }
                    }
                }};
            }
            match work(number) {
                Work::Two(equation) => smooth!(equation, 2),
                Work::Nine(equation) => smooth!(equation, 9),
                Work::Backlash => backlash!(Backlash, 4),
                Work::TrainBacklash => backlash!(TrainBacklash, 11),
            }
            Some(())
        }
    };
}
method!(tsit45, tsit45);
method!(bdf, bdf::<NalgebraLU<f64>>);

fn run_backlash<'a, const N: usize, D: Drive<N>, Eqn>(
    mut solver: impl OdeSolverMethod<'a, Eqn>,
    flank: &Cell<i32>,
    out: &mut [[f64; 2]],
) where
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
            out[i] = D::outputs(t, &state::<N>(&at), flank.get());
            i += 1;
        }
        if let OdeSolverStopReason::RootFound(t, index) = reason {
            events += 1;
            assert!(events < 20_000, "events without end");
            solver.state_mut_back(t).expect("the state at the root");
            let state = solver.state_mut();
            let mut y: [f64; N] = self::state(state.y);
            let was = flank.get();
            let side = if was != 0 {
                was
            } else if index == 0 {
                1
            } else {
                -1
            };
            let approach = f64::from(side) * (y[N - 1] - D::on_flank(t, &y, side)[1]);
            // A flight begins with a gap of zero, and its sign is noise: only an approach is an impact.
            if was != 0 || approach < -1e-10 {
                flank.set(D::after_event(t, &mut y, was, side));
            }
            let rate = D::rate(t, &y, flank.get());
            for k in 0..N {
                state.y.set_index(k, y[k]);
                state.dy.set_index(k, rate[k]);
            }
        }
    }
}
