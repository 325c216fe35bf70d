//! The balance of energy of the nonlinear equation: d/dt [(J + m U′²) ψ̇²/2 + c q²/2] = tau ω − b q̇².
//!
//! Collocation does not fulfil it by construction, so what is missing tells of its errors. The linearised equation has
//! no such balance.

use super::solver::Twist;
use crate::numerics::collocation::Collocation;
use crate::numerics::double_double::Double;
use crate::numerics::gauss::{ABSCISSAE, STAGES, WEIGHTS};

impl Twist<'_> {
    /// Takes the last step of `integrator` into the balance. Jumps of the inputs lie between steps, and in no balance.
    pub(super) fn account(&mut self, integrator: &Collocation<2>) {
        if self.equation.linear {
            return;
        }
        let (start, end) = (integrator.start(), integrator.end());
        let length = (end - start).hi;
        // The work by Gauss quadrature at the nodes of the step, of the order of the method.
        let power = |i: usize| {
            let theta = 0.5 * (1.0 + ABSCISSAE[i]);
            let [q, v] = integrator.at_fraction(theta);
            let speed = self.motion.at_instant(start + Double::from(theta * length)).kinematics.0[1];
            self.equation.torque(q, v) * speed - self.equation.b * v * v
        };
        let work: f64 = length * (0..STAGES).map(|i| WEIGHTS[i] * power(i)).sum::<f64>();
        let before = self.energy_at(start, &integrator.at_fraction(0.0));
        let after = self.energy_at(end, &integrator.state());
        self.balance.add(after - before - work, [before, after]);
    }

    /// (J + m U′²) ψ̇²/2 + c q²/2 [J].
    fn energy_at(&self, t: Double, y: &[f64; 2]) -> f64 {
        let f = self.flow(t, y);
        let slope = self.cam(&f).0[1];
        let inertia = self.equation.inertia + self.equation.m * slope * slope;
        0.5 * (inertia * f.cam_speed() * f.cam_speed() + self.equation.c * y[0] * y[0])
    }
}
