//! An elastic output: m ÿ = F + F_L, F = −(c q + b q̇), y = U + q; m_x on the cam's side follows the shaft.

use super::{At, CarriedMass, DEFORMATION, FREE_TOOL, Follower, Joint, Kind, MOST, Motion, Now, Put, Stand, balance};
use crate::drives::Fault;
use crate::drives::follower::elastic_output::Parameters;
use crate::drives::variable::Output;
use crate::numerics::taylor::{Arithmetic, Scalar};

impl Kind for Parameters {
    fn elastic(&self) -> Option<(usize, [f64; 3])> {
        Some((0, [self.m, self.c, self.b]))
    }

    fn masses(&self, of: &Follower) -> [f64; 2] {
        [self.m, of.joint.roller().unwrap_or(0.0)]
    }

    fn carried<'a>(&self, of: &'a Follower, _: &Stand) -> [Option<CarriedMass<'a>>; 2] {
        let [_, m] = of.masses();
        [Some(CarriedMass { m, weight: m, load: &of.roller, away: 0.0, is_tool: false }), None]
    }

    fn brake<S: Arithmetic>(&self, at: &At<'_, S>, spring: S, sum: S) -> S {
        sum + at.cam[1] * spring
    }

    fn act<S: Arithmetic>(&self, at: &At<'_, S>, spring: S, a: S) -> Motion<S> {
        let ([u, u1, _], [q, v], x2) = (at.cam, [at.y[0], at.y[1]], at.lift(a));
        let force = spring + at.on_tool(self.m, [u + q, u1 * at.w + v]);
        let tool = force * (1.0 / self.m);
        let none = Motion::none();
        let zero = S::from(0.0);
        Motion { rates: [v, tool - x2, zero, zero], accelerations: [zero, tool], ..none }
    }

    fn outputs<S: Scalar>(&self, now: &Now<'_, S>, put: &mut Put<'_, S>) {
        let Now { at, spring, motion, .. } = now;
        let ([u, u1, _], [q, v], [_, m_x]) = (at.cam, [at.y[0], at.y[1]], at.follower.masses());
        let (speed, roller) = (u1 * at.w, &at.follower.roller);
        let normal = *spring + at.shown_lift(now.a) * m_x - roller.force(m_x, [u, speed], None, None);
        now.law(put);
        now.moved(&FREE_TOOL, [u + q, speed + v, motion.accelerations[1]], put);
        now.moved(&DEFORMATION, [q, v, motion.rates[1]], put);
        let text = "Force of the spring on the tool, -(c q + b der(q)), positive in the sense of y";
        put.give(&Output::new("force", text, now.force()), *spring);
        now.reaction("contact_force", [normal, u1 * normal], put);
    }

    fn slopes(&self, _: &At<'_, f64>, cam: [f64; 2], of: &dyn Fn(&str) -> [f64; 2]) -> [f64; MOST] {
        let y = of("y");
        [y[0] - cam[0], y[1] - cam[1], 0.0, 0.0]
    }

    fn jolt(&self, y: &mut [f64], turn: f64, slope: f64, _: Option<[f64; 2]>) {
        y[1] -= slope * turn;
    }

    /// c q = F_L(x + q): q = (m g + F₀ − F_v + P + F − c_r (x − y₀))/(c + c_r).
    fn rest(&self, at: &At<'_, f64>, _: f64, y: &mut [f64], _: &mut Stand) -> Result<(), Fault> {
        (y[0], y[1]) = (balance(at, [self.c, self.m], at.cam[0])?, 0.0);
        Ok(())
    }
}

impl Joint {
    /// m_x of an elastic output (kg).
    pub fn roller(&self) -> Option<f64> {
        if let Joint::Output(_, m_x) = self { Some(*m_x) } else { None }
    }

    /// Changes m_x.
    pub fn set_roller(&mut self, value: f64) {
        if let Joint::Output(_, m_x) = self {
            *m_x = value;
        }
    }
}
