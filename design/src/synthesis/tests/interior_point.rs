//! Linear and quadratic programs by another program, as a reference.

use clarabel::algebra::CscMatrix;
use clarabel::solver::{
    DefaultSettingsBuilder, DefaultSolver, IPSolver, NonnegativeConeT, SolverStatus, SupportedConeT,
};
use nalgebra::DMatrix;

/// The y with the least q·y under A y ≤ b.
pub fn interior_point(q: &[f64], a: &DMatrix<f64>, b: &[f64]) -> Vec<f64> {
    let settings = DefaultSettingsBuilder::default()
        .verbose(false)
        .tol_gap_abs(1e-11)
        .tol_gap_rel(1e-11)
        .tol_feas(1e-11)
        .max_iter(300)
        .build()
        .unwrap();
    let cones: [SupportedConeT<f64>; 1] = [NonnegativeConeT(b.len())];
    let linear = CscMatrix::zeros((q.len(), q.len()));
    let mut solver = DefaultSolver::new(&linear, q, &sparse(a), b, &cones, settings).unwrap();
    solver.solve();
    let known = [SolverStatus::Solved, SolverStatus::AlmostSolved, SolverStatus::InsufficientProgress];
    assert!(known.contains(&solver.solution.status), "{:?}", solver.solution.status);
    solver.solution.x.clone()
}

/// The matrix with its zeros left out, as the optimiser takes it.
fn sparse(m: &DMatrix<f64>) -> CscMatrix<f64> {
    let (mut columns, mut rows, mut values) = (vec![0], Vec::new(), Vec::new());
    for j in 0..m.ncols() {
        for i in 0..m.nrows() {
            if m[(i, j)] != 0.0 {
                rows.push(i);
                values.push(m[(i, j)]);
            }
        }
        columns.push(rows.len());
    }
    CscMatrix::new(m.nrows(), m.ncols(), columns, rows, values)
}
