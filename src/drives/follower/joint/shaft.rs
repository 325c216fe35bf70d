//! An elastic shaft before the cam: (J + m U′²) ψ̈ + m U′U″ ψ̇² = T + U′ F_L, T = −(c q + b q̇), ψ = φ + q.

use super::{At, CarriedMass, Follower, Kind, MOST, Motion, Now, Put, Stand, TOOL, TURNS, moving};
use crate::drives::Fault;
use crate::drives::follower::elastic_shaft::Parameters;
use crate::drives::limits::refused_start;
use crate::drives::unit;
use crate::drives::variable::Output;
use crate::numerics::taylor::{Arithmetic, Scalar};

/// Steps in which the load grows from zero; Newton's method needs a few iterations between them.
const STEPS: usize = 64;
const ITERATIONS: usize = 8;

static TWIST: [Output; 3] = moving("q", "Deformation of the spring", TURNS, true);

impl Kind for Parameters {
    fn shaft(&self) -> Option<Parameters> {
        Some(*self)
    }

    fn elastic(&self) -> Option<(usize, [f64; 3])> {
        Some((0, [self.inertia, self.c, self.b]))
    }

    fn masses(&self, _: &Follower) -> [f64; 2] {
        [self.m, 0.0]
    }

    fn carried<'a>(&self, _: &'a Follower, _: &Stand) -> [Option<CarriedMass<'a>>; 2] {
        [None, None]
    }

    fn brake<S: Arithmetic>(&self, _: &At<'_, S>, spring: S, sum: S) -> S {
        sum + spring
    }

    fn act<S: Arithmetic>(&self, at: &At<'_, S>, spring: S, a: S) -> Motion<S> {
        let ([u, u1, u2], speed) = (at.cam, at.w + at.y[1]);
        let force = at.on_tool(self.m, [u, u1 * speed]) - u2 * (speed * speed) * self.m;
        let inertia = u1 * u1 * self.m + S::from(self.inertia);
        let cam = (spring + u1 * force) / inertia;
        let zero = S::from(0.0);
        Motion { rates: [at.y[1], cam - a, zero, zero], accelerations: [cam, zero], ..Motion::none() }
    }

    fn outputs<S: Scalar>(&self, now: &Now<'_, S>, put: &mut Put<'_, S>) {
        let Now { at, phi, spring, motion, .. } = now;
        let ([u, u1, u2], [q, v]) = (at.cam, [at.y[0], at.y[1]]);
        let speed = at.w + v;
        let velocity = u1 * speed;
        let acceleration = u2 * speed * speed + u1 * motion.accelerations[0];
        let normal = acceleration * self.m - at.on_tool(self.m, [u, velocity]);
        now.law(put);
        now.moved(&TOOL, [u, velocity, acceleration], put);
        put.all(&TWIST, [q, v, motion.rates[1]]);
        let psi = *phi + q + (now.whole - *phi);
        put.give(&Output::new("psi", "Angle of the cam behind the elastic shaft", &unit::ANGLE), psi);
        now.reaction("force", [normal, *spring], put);
    }

    fn slopes(&self, _: &At<'_, f64>, _: [f64; 2], of: &dyn Fn(&str) -> [f64; 2]) -> [f64; MOST] {
        let q = of("q");
        [q[0], q[1], 0.0, 0.0]
    }

    fn jolt(&self, y: &mut [f64], turn: f64, _: f64, _: Option<[f64; 2]>) {
        y[1] -= turn;
    }

    /// c q = U′(ψ) F_L(U(ψ)), followed from F_L = 0 on, as long as c > d(U′F_L)/dψ. Beyond that the shaft snaps through. The
    /// condition belongs to a conservative system: it is the second derivative of its potential.
    fn rest(&self, at: &At<'_, f64>, phi: f64, y: &mut [f64], _: &mut Stand) -> Result<(), Fault> {
        let (load, push) = (&at.follower.load, at.process + at.input);
        let mut q = 0.0;
        for step in 1..=STEPS {
            let part = step as f64 / STEPS as f64;
            for _ in 0..ITERATIONS {
                let [u, u1, u2, ..] = at.follower.rigid.cam.at_in(at.segment, phi + q).0;
                let force = load.constant_part(self.m) + push - load.stiffness() * u;
                let left = self.c * q - part * u1 * force;
                let slope = self.c - part * (u2 * force - u1 * u1 * load.stiffness());
                if !(slope > 0.0) {
                    let message = format!(
                        "start.mode = equilibrium: the shaft of follower {} snaps through under {} % of its loads; \
                         choose a stiffer shaft, smaller loads or at_rest",
                        at.j + 1,
                        (100.0 * part).round()
                    );
                    return Err(refused_start(message));
                }
                q -= left / slope;
            }
        }
        y[0] = q;
        Ok(())
    }
}
