//! The balance of energy: ½ J φ̇² changes by the work ∫ (M_an − τ) dφ of the torques.
//!
//! Collocation fulfils it by construction as long as the work is summed at its own nodes (E itself is what the steps in the
//! angle solve for, and of u = √J φ̇ the square is kept by any Gauss method). Here the work is that of the torques at the
//! speeds that the machine shows, by a rule with other nodes and of higher order: what is missing then is the error of the
//! energy.
//!
//! Source: E. Hairer, C. Lubich, G. Wanner, *Geometric Numerical Integration*, 2nd ed., Springer 2006, theorem IV.2.1
//! (quadratic first integrals).

use super::RigidMachine;
use super::passage::Passage;
use super::raster::Tabulated;
use super::solver::Piece;
use super::torques::Torques;
use crate::numerics::collocation::Collocation;
use crate::numerics::double_double::Double;
use crate::numerics::gauss::STAGES;
use crate::numerics::interpolant::{columns, combine};
use crate::numerics::lobatto::{self, INNER};
use crate::numerics::quadrature::Gauss;

/// The nodes of the rule. The torques at the speeds of the collocation polynomial miss those of the equation by a multiple
/// of the Legendre polynomial of degree 8, which times the next ones of the expansion has a degree of 16 and more: from
/// nine nodes on, the sum sees it. Ten, of order 20, err less than the states do.
const NODES: usize = 10;

/// The columns of the matrix that integrates from the nodes of the collocation to the points between.
static COLUMNS: [[f64; INNER]; STAGES] = columns(&lobatto::MATRIX);

/// The mean of N over the step, apart from the nodes: at points between them and at the ends, where it is `ends`.
pub fn mean_apart(
    from: Double,
    length: f64,
    net: &[f64; STAGES],
    reciprocal: &Tabulated,
    torques: &Torques,
    ends: [f64; 2],
) -> f64 {
    let e = combine(&COLUMNS, net).map(|sum| from.hi + length * sum);
    let mut mean = lobatto::END_WEIGHT * (ends[0] + ends[1]);
    for i in 0..INNER {
        mean += lobatto::WEIGHTS[i] * torques.net((e[i] * reciprocal.between[i]).max(0.0).sqrt());
    }
    mean
}

impl Passage {
    /// E at the beginning and at the abscissa `x` [J].
    pub fn energies_to(&self, x: f64) -> [f64; 2] {
        [self.from.energy.hi, self.energy_at(x).hi]
    }
}

impl Piece<'_> {
    /// By what ½u² misses the work of the torques over the part `theta` of the last step of `c` [J].
    pub fn missing<const N: usize>(&self, c: &Collocation<N>, theta: f64) -> f64 {
        let length = (c.end() - c.start()).hi;
        let [work] = Gauss::with(NODES).integrate(theta, |part| {
            let t = c.start() + Double::from(part * length);
            [self.power(t, &c.at_fraction(part))]
        });
        let increment = if theta == 1.0 { c.state() } else { c.at_fraction(theta) };
        self.energy_gain(&increment) - length * work
    }
}

impl RigidMachine {
    /// |Σ(ΔE − ∫(M_an − τ) dφ)| since the start, relative to the largest energy.
    pub(super) fn energy_residual(&self) -> f64 {
        let mut balance = self.balance;
        if let Some(passage) = &self.passage {
            balance.add(self.missing_in(passage, self.abscissa), passage.energies_to(self.abscissa));
        } else if let Some(missing) = self.missing_on_grid() {
            balance.add(missing, [0.0, self.state.energy()]);
        }
        balance.residual()
    }

    /// By what E misses the work of the torques from the beginning of the passage to the abscissa `x` [J].
    pub(super) fn missing_in(&self, passage: &Passage, x: f64) -> f64 {
        self.missing_under(&self.torques, passage, x)
    }

    /// The same under other torques than the present ones.
    pub(super) fn missing_under(&self, torques: &Torques, passage: &Passage, x: f64) -> f64 {
        let interval = self.raster.cells()[passage.from.cell].interval;
        let [work] = Gauss::with(NODES).integrate(1.0 + x, |along| {
            let x = along - 1.0;
            let phi = passage.from.angle.hi + torques.sense * passage.advance(x);
            let inertia = self.raster.profile.value(&self.inertia, interval, phi);
            [torques.net((2.0 * passage.energy_at(x).hi / inertia).max(0.0).sqrt())]
        });
        let gain = if x == 1.0 { (passage.energy - passage.from.energy).hi } else { passage.work_to(x) };
        gain - 0.5 * passage.length * work
    }
}
