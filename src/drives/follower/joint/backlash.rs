//! Clearance between the cam's flanks, one or two, and m1, with or without m2 on a spring.
//!
//! In contact m2 ẍ2 = S + F_L2, S = −(c q + b q̇), N = m1 ẍ1 + S − F_L1; in flight m1 ẍ1 = −S + F_L1, x1 = U + z, + s if z counts
//! from flank B. Without m2 all loads act on m1.

use super::{
    At, CarriedMass, Change, DEFORMATION, FREE_TOOL, Follower, Guard, Kind, MOST, Motion, Now, Put, Stand, TOOL,
    balance, either, nothing_holds,
};
use crate::drives::Fault;
use crate::drives::follower::contact::{Flank, Mode, Parameters};
use crate::drives::unit;
use crate::drives::variable::{Output, Role};
use crate::numerics::taylor::{Arithmetic, Scalar};

impl Parameters {
    /// F_L on m1 at x1, ẋ1.
    pub fn on_m1<S: Arithmetic>(&self, at: &At<'_, S>, x1: [S; 2]) -> S {
        let own = at.follower.roller.force(self.m1, x1, None, None);
        if self.m2 > 0.0 { own } else { own + at.on_tool(self.m1, x1) }
    }
}

static X1: [[Output; 3]; 2] = either("x1", "Place of the mass at the cam", true);

impl Kind for Parameters {
    fn has(&self, number: &str) -> bool {
        match number {
            "s" => self.s.is_finite(),
            "m2" | "c" | "b" => self.m2 > 0.0,
            _ => true,
        }
    }

    fn clearance(&self) -> Option<Parameters> {
        Some(*self)
    }

    fn elastic(&self) -> Option<(usize, [f64; 3])> {
        (self.m2 > 0.0).then_some((2, [self.m2, self.c, self.b]))
    }

    fn frequency(&self) -> f64 {
        (self.c / self.m1).sqrt()
    }

    fn masses(&self, _: &Follower) -> [f64; 2] {
        [self.m2, self.m1]
    }

    fn carried<'a>(&self, of: &'a Follower, stand: &Stand) -> [Option<CarriedMass<'a>>; 2] {
        let Mode::Contact(flank) = stand.contact else { return [None, None] };
        let (m, away) = (self.m1, flank.pick(0.0, self.s));
        let tool = CarriedMass { m: 0.0, weight: m, load: &of.load, away, is_tool: true };
        [Some(CarriedMass { m, weight: m, load: &of.roller, away, is_tool: false }), (self.m2 == 0.0).then_some(tool)]
    }

    fn brake<S: Arithmetic>(&self, at: &At<'_, S>, spring: S, sum: S) -> S {
        let held = if self.m2 > 0.0 { spring } else { -at.input };
        if at.stand.is_held() { sum + at.cam[1] * held } else { sum }
    }

    fn act<S: Arithmetic>(&self, at: &At<'_, S>, spring: S, a: S) -> Motion<S> {
        let ([u, u1, _], w, x2, mut motion) = (at.cam, at.w, at.lift(a), Motion::none());
        let place = match at.stand.contact {
            Mode::Contact(flank) => [u + S::from(flank.pick(0.0, self.s)), u1 * w],
            Mode::Free => [u + at.y[0] + S::from(at.stand.home(self.s)), u1 * w + at.y[1]],
        };
        let own = self.on_m1(at, place);
        let a1 = if at.stand.is_held() {
            motion.normal = x2 * self.m1 + spring - own;
            x2
        } else {
            let a1 = (own - spring) * (1.0 / self.m1);
            (motion.rates[0], motion.rates[1]) = (at.y[1], a1 - x2);
            a1
        };
        motion.accelerations[0] = a1;
        if self.m2 > 0.0 {
            let (q, v) = (at.y[2], at.y[3]);
            let force = spring + at.on_tool(self.m2, [place[0] + q, place[1] + v]);
            let tool = force * (1.0 / self.m2);
            motion.accelerations[1] = tool;
            (motion.rates[2], motion.rates[3]) = (v, tool - a1);
        }
        motion
    }

    fn guards(&self, stand: &Stand, watch: &mut dyn FnMut(Guard)) {
        match stand.contact {
            Mode::Contact(_) if self.s == 0.0 => {}
            Mode::Contact(flank) => {
                watch(Guard { state: None, shift: 0.0, sign: flank.sign(), zeros: 0, change: Change::Release });
            }
            Mode::Free => {
                for flank in [Flank::A, Flank::B].into_iter().filter(|flank| flank.pick(0.0, self.s).is_finite()) {
                    let shift = stand.home(self.s) - flank.pick(0.0, self.s);
                    let (sign, change) = (flank.sign(), Change::Impact(flank));
                    watch(Guard { state: Some(0), shift, sign, zeros: stand.zeros, change });
                }
            }
        }
    }

    fn outputs<S: Scalar>(&self, now: &Now<'_, S>, put: &mut Put<'_, S>) {
        let Now { at, motion, .. } = now;
        let ([u, u1, _], w, y) = (at.cam, at.w, at.y);
        let (gap, speed) = (S::from(at.stand.home(self.s)) + y[0], u1 * w + y[1]);
        let (place, [first, tool]) = (u + gap, motion.accelerations);
        now.law(put);
        now.moved(&X1, [place, speed, first], put);
        put.give(&Output::new("gap", "Distance of the mass at the cam from flank A", now.place()), gap);
        if self.m2 > 0.0 {
            now.moved(&FREE_TOOL, [place + y[2], speed + y[3], tool], put);
            now.moved(&DEFORMATION, [y[2], y[3], motion.rates[3]], put);
        } else {
            now.moved(&TOOL, [place, speed, first], put);
        }
        now.reaction("force", [motion.normal, u1 * motion.normal], put);
        self.counts(now, put);
    }

    fn slopes(&self, at: &At<'_, f64>, cam: [f64; 2], of: &dyn Fn(&str) -> [f64; 2]) -> [f64; MOST] {
        let x1 = if at.stand.is_held() { cam } else { of("x1") };
        let y = if self.m2 > 0.0 { of("y") } else { x1 };
        [x1[0] - cam[0], x1[1] - cam[1], y[0] - x1[0], y[1] - x1[1]]
    }

    fn jolt(&self, y: &mut [f64], turn: f64, slope: f64, struck: Option<[f64; 2]>) {
        y[1] = struck.map_or(y[1] - slope * turn, |[_, after]| after);
        if let (true, Some([impulse, _])) = (self.m2 > 0.0, struck) {
            y[3] -= impulse / self.m1;
        }
    }

    /// m1 lies on flank A if N = −c q − F_L1 ≥ 0, on flank B if N ≤ 0 there. Without loads it may be anywhere, and a spring may
    /// hold it between the flanks: neither is a start.
    fn rest(&self, at: &At<'_, f64>, _: f64, y: &mut [f64], stand: &mut Stand) -> Result<(), Fault> {
        let mut lie = |flank: Flank| {
            let x1 = at.cam[0] + flank.pick(0.0, self.s);
            let mut force = -self.on_m1(at, [x1, 0.0]);
            if self.m2 > 0.0 {
                y[2] = balance(at, [self.c, self.m2], x1)?;
                force -= self.c * y[2];
            }
            (stand.contact, stand.beyond) = (Mode::Contact(flank), flank == Flank::B);
            Ok(force)
        };
        let on_a = lie(Flank::A)?;
        if on_a < 0.0 && self.s.is_infinite() {
            return Err(nothing_holds(at.j, ["", " on its cam"]));
        }
        if on_a <= 0.0 && self.s.is_finite() {
            let on_b = lie(Flank::B)?;
            if on_a < 0.0 && on_b > 0.0 || on_a == 0.0 && on_b == 0.0 {
                return Err(nothing_holds(at.j, ["", " at a flank of its clearance"]));
            }
            // A relaxed spring holds it just there.
            if on_a == 0.0 {
                lie(Flank::A)?;
            }
        }
        Ok(())
    }
}

impl Parameters {
    /// The position of m1, and the sums over impacts and damper.
    fn counts<S: Scalar>(&self, now: &Now<'_, S>, put: &mut Put<'_, S>) {
        let (Now { at, counts, .. }, two) = (now, self.s.is_finite());
        let mode = if let Mode::Contact(flank) = at.stand.contact { flank.sign() } else { 0.0 };
        let text = if two { "1 on flank A, 0 in flight, -1 on flank B" } else { "1 on the cam, 0 in flight" };
        let mut count =
            |name, text, quantity, role, value| put.give(&Output::new(name, text, quantity).role(role), value);
        count("contact", text, &unit::NUMBER, Role::Count(if two { -1 } else { 0 }, 1), S::from(mode));
        // A jump of the inputs carries a mass in contact along.
        let mut impulse = S::from(counts.impulse);
        if at.stand.is_held() && now.driven {
            let flank = at.cam[1] * at.w;
            impulse = (flank - S::from(flank.value())) * self.m1 + impulse;
        }
        count("impulse", "Sum of the impulses of the cam since the start", &unit::IMPULSE, Role::Discrete, impulse);
        count("impacts", "Impacts since the start", &unit::NUMBER, Role::Count(0, i32::MAX), S::from(counts.impacts));
        count(
            "energy_loss",
            "Energy lost in impacts since the start",
            &unit::ENERGY,
            Role::Discrete,
            S::from(counts.loss),
        );
        let [force, torque] = counts.means.map(S::from);
        let text = "Mean force of the drive on m1 over the last communication step, impulses included";
        count("force_mean", text, now.force(), Role::Discrete, force);
        let text = "Mean torque of the follower on the drive over the last communication step, impulses included";
        count("tau_mean", text, &unit::TORQUE, Role::Discrete, torque);
        if self.m2 > 0.0 {
            let text = "Energy dissipated by the damper";
            count("damping_loss", text, &unit::ENERGY, Role::Local, S::from(counts.damped));
        }
    }
}
