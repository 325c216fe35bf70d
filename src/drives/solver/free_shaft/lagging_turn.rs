//! The turn of a machine whose motor's torque lags behind its characteristic, as a map of two dimensions.
//!
//! In the angle ψ = σ(φ − φ_start), with v = √(2E) > 0 and the torque M_an as unknowns,
//!
//! dv/dψ = σ(M_an − τ)/v,  dM_an/dψ = (M_Kloss(φ̇) − M_an)/(T_el |φ̇|),  dt/dψ = √J/v,  φ̇ = σ v/√J
//!
//! and (v, M_an) at ψ = 0 → ψ = 2π is a map of two dimensions. Newton's method starts from the periodic motion without lag. If that
//! fails, it starts from the motion with a lag of many turns, over which M_an and v are constant: M_an = τ, and in time the
//! characteristic has this mean, ∮(M_Kloss − τ)√J dψ = 0. The periodic motion must be stable. A disturbance q of E on it follows
//! the linear equation
//!
//! q″ + q′/(T_el|φ̇|) + k q = 0,  k = −[M_Kloss′(φ̇) − σ(M_Kloss − M_an)/|φ̇|]/(2E T_el),
//!
//! whose Floquet multipliers have the product exp(−∮ dψ/(T_el|φ̇|)) = exp(−T/T_el) (Liouville).

use crate::drives::follower::place::Place;
use crate::drives::shaft::free::inertia::Inertia;
use crate::drives::shaft::free::motor::{Kloss, Motor};
use crate::drives::shaft::free::{State, beside};
use crate::numerics::collocation::{Collocation, System};
use crate::numerics::double_double::Double;
use crate::numerics::gauss::Gauss;
use crate::numerics::period_map::{Coefficients, Period, Periodic};
use crate::numerics::work::{EVALUATION, Work, draw};
use std::cell::Cell;
use std::f64::consts::TAU;

/// Tolerance of the periodic motion.
const PERIODIC_TOLERANCE: f64 = 1e-13;

/// Tolerance of the disturbances on it.
const GROWTH_TOLERANCE: f64 = 1e-10;

/// Iterations of Newton's method, which needs a handful.
const ITERATIONS: usize = 80;

/// A smooth piece of the turn, up to its end ψ.
struct Leg {
    place: Place,
    end: f64,
}

/// A turn of a machine whose motor lags.
pub struct LaggingTurn<'a> {
    inertia: &'a Inertia,
    motor: &'a Motor,
    /// The load (N·m).
    tau: f64,
    /// σ.
    sense: f64,
    /// φ at the start (rad) and the interval between borders that holds it.
    phi_start: f64,
    interval: usize,
    /// The remaining work of the call; a study takes as much as it needs.
    work: Option<&'a Cell<Work>>,
}

/// v, the lagging torque and t.
struct OnLeg<'a> {
    turn: &'a LaggingTurn<'a>,
    place: Place,
}

impl OnLeg<'_> {
    /// √J, φ̇.
    fn speed(&self, psi: Double, v: f64) -> (f64, f64) {
        let root = self.turn.inertia.at(self.place, self.turn.phi_start + self.turn.sense * psi.hi)[0].sqrt();
        // A machine that comes to rest before the end of the turn has no φ-domain form; the square root is NaN then.
        (root, self.turn.sense * if v > 0.0 { v } else { f64::NAN } / root)
    }
}

impl System<3> for OnLeg<'_> {
    fn rhs(&self, psi: Double, y: &[f64; 3]) -> [f64; 3] {
        let turn = self.turn;
        let (root, w) = self.speed(psi, y[0]);
        let lag = turn.motor.lag().unwrap_or(f64::NAN);
        let rate = (turn.motor.characteristic(w)[0] - y[1]) / lag;
        [turn.sense * (y[1] - turn.tau) / y[0], rate * root / y[0], root / y[0]]
    }

    fn jacobian(&self, psi: Double, y: &[f64; 3]) -> [[f64; 3]; 3] {
        let turn = self.turn;
        let (root, w) = self.speed(psi, y[0]);
        let lag = turn.motor.lag().unwrap_or(f64::NAN);
        let v = y[0];
        let [torque, slope, _] = turn.motor.characteristic(w);
        let rate = (torque - y[1]) / lag;
        [
            [-turn.sense * (y[1] - turn.tau) / (v * v), turn.sense / v, 0.0],
            [turn.sense * slope / (lag * v) - rate * root / (v * v), -root / (lag * v), 0.0],
            [-root / (v * v), 0.0, 0.0],
        ]
    }

    fn magnitude(&self, y: &[f64; 3]) -> [f64; 3] {
        let Motor::Kloss(Kloss { breakdown_torque, .. }) = self.turn.motor else { return [1.0; 3] };
        [y[0].abs(), *breakdown_torque, y[2].abs()]
    }

    fn longest_step(&self, _: Double, _: &[f64; 3]) -> f64 {
        TAU / self.turn.inertia.resolution()
    }
}

impl<'a> LaggingTurn<'a> {
    /// The turn against the load `tau` (N·m) from the angle of a state on.
    pub fn new(inertia: &'a Inertia, motor: &'a Motor, tau: f64, start: &State, work: Option<&'a Cell<Work>>) -> Self {
        let (phi_start, interval) = (start.angle.hi, start.interval);
        LaggingTurn { inertia, motor, tau, sense: motor.sense(), phi_start, interval, work }
    }

    /// The smooth pieces that the shaft passes from the start, in their order.
    fn legs(&self) -> Vec<Leg> {
        let (borders, forward) = (self.inertia.borders().len(), self.sense > 0.0);
        let (mut interval, mut psi, mut legs) = (self.interval, 0.0, Vec::with_capacity(borders + 1));
        let (low, high) = self.inertia.ends(interval);
        let mut width = if forward { high - self.phi_start } else { self.phi_start - low };
        // The first piece is passed in two parts; without borders its ends are infinitely far away.
        while psi < TAU && legs.len() <= borders + 1 {
            psi = (psi + width.max(0.0)).min(TAU);
            legs.push(Leg { place: self.inertia.place(interval), end: psi });
            if psi < TAU {
                (interval, _) = beside(interval, borders, forward);
                let (low, high) = self.inertia.ends(interval);
                width = high - low;
            }
        }
        legs.iter_mut().last().into_iter().for_each(|last| last.end = TAU);
        legs
    }

    /// ln of the largest modulus of the multipliers of the periodic motion (v, M_an), and the motion; None if the machine comes to
    /// rest on it.
    pub fn growth_and_motion(&self, motion: [f64; 2]) -> Option<(f64, Motion<'_>)> {
        let motion = Motion { turn: self, lag: self.motor.lag()?, pieces: self.pieces(motion)? };
        let growth = match Period::of(&motion, GROWTH_TOLERANCE) {
            Some(whole) => whole.monodromy.growth(),
            // The lag is some millionths of the turn: the torque follows at once.
            None => motion.growth_without_lag(),
        };
        Some((growth, motion))
    }

    /// The steps of the motion (v, M_an).
    fn pieces(&self, [v, torque]: [f64; 2]) -> Option<Vec<(Place, Collocation<3>)>> {
        let mut pieces = Vec::new();
        self.follow(&self.legs(), [v, torque, 0.0], |place, c| pieces.push((place, c.clone())))?;
        Some(pieces)
    }

    /// (v, M_an) after a turn that begins with `y`.
    pub fn after(&self, y: [f64; 2]) -> Option<[f64; 2]> {
        self.run(&self.legs(), [y[0], y[1], 0.0]).map(|[v, torque, _]| [v, torque])
    }

    /// The values after a turn that starts with `y`; None if the machine comes to rest or the work is used up.
    fn run(&self, legs: &[Leg], y: [f64; 3]) -> Option<[f64; 3]> {
        self.follow(legs, y, |_, _| ())
    }

    /// [`LaggingTurn::run`] with a `visit` to each step.
    fn follow(&self, legs: &[Leg], y: [f64; 3], mut visit: impl FnMut(Place, &Collocation<3>)) -> Option<[f64; 3]> {
        let mut c = Collocation::<3>::new(Double::from(0.0), y);
        // Three unknowns instead of two.
        let cost = 2.0 * EVALUATION + self.inertia.cost();
        for &Leg { place, end } in legs {
            let (on_leg, end) = (OnLeg { turn: self, place }, Double::from(end));
            while (end - c.end()).hi > 0.0 {
                let before = c.statistics.evaluations;
                c.step(&on_leg, end, PERIODIC_TOLERANCE).ok()?;
                draw(self.work, cost * (c.statistics.evaluations - before) as f64)?;
                visit(place, &c);
            }
            // Below a billionth of the first speed the time scale of the turn is lost: this is a standstill.
            if c.state()[0] < 1e-9 * y[0] {
                return None;
            }
        }
        Some(c.state())
    }

    /// The periodic motion (v, M_an) of a motor with lag near the periodic motion `v` without lag, or near the one with a lag of
    /// many turns; also T.
    pub fn refine(&self, v: f64, torque_scale: f64) -> Option<([f64; 2], f64)> {
        let legs = &self.legs();
        let root = self.inertia.at(legs[0].place, self.phi_start)[0].sqrt();
        let without = [v, self.motor.characteristic(self.sense * v / root)[0]];
        self.newton(legs, without, torque_scale)
            .or_else(|| self.newton(legs, [self.at_constant_torque(legs)?, self.tau], torque_scale))
    }

    /// v of the fastest stable motion with a lag of many turns, to a millionth.
    fn at_constant_torque(&self, legs: &[Leg]) -> Option<f64> {
        let Motor::Kloss(Kloss { breakdown_slip, synchronous_speed, .. }) = self.motor else { return None };
        let (mut roots, mut psi) = (Vec::new(), 0.0);
        for Leg { place, end } in legs {
            // Eight places in a wave of J are enough for a start. Some hundred speeds are tried at each.
            let count = (8.0 / TAU * (end - psi) * self.inertia.resolution()).ceil().max(1.0);
            draw(self.work, count * (self.inertia.cost() + 10.0 * EVALUATION))?;
            let width = (end - psi) / count;
            let at = |i: usize| self.inertia.at(*place, self.phi_start + self.sense * (psi + (i as f64 + 0.5) * width));
            roots.extend((0..count as usize).map(|i| (width, at(i)[0].sqrt())));
            psi = *end;
        }
        let excess = |v: f64| -> f64 {
            let part = |(width, root): &(f64, f64)| {
                self.sense * (self.motor.characteristic(self.sense * v / root)[0] - self.tau) * root * width
            };
            roots.iter().map(part).sum()
        };
        // From above all stable motions down to the speed at which the motor is beyond its breakdown slip in the whole turn.
        let (least, largest) = self.inertia.range();
        let mut high = 1.2 * largest.sqrt() * synchronous_speed.abs() * (1.0 + breakdown_slip.min(1.0));
        let bottom = 0.8 * least.sqrt() * synchronous_speed.abs() * (1.0 - breakdown_slip).max(0.1);
        let mut low = high;
        while excess(low) < 0.0 {
            if low < bottom {
                return None;
            }
            (high, low) = (low, 0.99 * low);
        }
        while high - low > 1e-6 * high {
            let middle = 0.5 * (low + high);
            if excess(middle) < 0.0 { high = middle } else { low = middle }
        }
        Some(low)
    }

    /// The periodic motion near `y`, and T.
    fn newton(&self, legs: &[Leg], mut y: [f64; 2], torque_scale: f64) -> Option<([f64; 2], f64)> {
        let shoot = |y: [f64; 2]| self.run(legs, [y[0], y[1], 0.0]);
        let mut smallest = f64::INFINITY;
        for _ in 0..ITERATIONS {
            let end = shoot(y)?;
            // Differences over a millionth of the scale: Newton's method gains six digits per iteration with them.
            let steps = [1e-6 * y[0], 1e-6 * torque_scale];
            let mut map = [[0.0; 2]; 2];
            for column in 0..2 {
                let mut beside = y;
                beside[column] += steps[column];
                let moved = shoot(beside)?;
                for row in 0..2 {
                    map[row][column] = (moved[row] - end[row]) / steps[column];
                }
            }
            let [[a, b], [c, d]] = [[map[0][0] - 1.0, map[0][1]], [map[1][0], map[1][1] - 1.0]];
            let (r, s) = (y[0] - end[0], y[1] - end[1]);
            let determinant = a * d - b * c;
            let correction = [(r * d - b * s) / determinant, (a * s - c * r) / determinant];
            let size = (correction[0] / y[0]).abs().max((correction[1] / torque_scale).abs());
            if !size.is_finite() {
                return None;
            }
            y = [y[0] + correction[0], y[1] + correction[1]];
            if size < 1e-14 || (size < 1e-11 && size >= smallest) {
                return Some((y, shoot(y)?[2]));
            }
            smallest = smallest.min(size);
        }
        None
    }
}

/// A periodic motion, and the growth of a small disturbance of E on it, see the head of this file.
pub struct Motion<'a> {
    turn: &'a LaggingTurn<'a>,
    lag: f64,
    /// The smooth piece of J, and the periodic motion on it.
    pieces: Vec<(Place, Collocation<3>)>,
}

impl Motion<'_> {
    /// The ends of its pieces in φ.
    pub fn pieces(&self) -> Vec<[f64; 2]> {
        let ends = |(_, motion): &(Place, Collocation<3>)| {
            let [a, b] = [motion.start(), motion.end()].map(|psi| self.turn.phi_start + self.turn.sense * psi.hi);
            [a.min(b), a.max(b)]
        };
        self.pieces.iter().map(ends).collect()
    }

    /// ω (rad/s) in a piece.
    pub fn speed(&self, piece: usize, phi: f64) -> f64 {
        let LaggingTurn { sense, phi_start, .. } = self.turn;
        sense * self.at(piece, Double::from(sense * (phi - phi_start)))[1]
    }

    /// v, |φ̇|, M_Kloss − M_an and M_Kloss′ on this piece.
    fn at(&self, piece: usize, psi: Double) -> [f64; 4] {
        let (place, motion) = &self.pieces[piece];
        let [v, torque, _] = motion.at(psi);
        let (_, w) = OnLeg { turn: self.turn, place: *place }.speed(psi, v);
        let [kloss, slope, _] = self.turn.motor.characteristic(w);
        [v, w.abs(), kloss - torque, slope]
    }

    /// ∮ M_Kloss′/(J|φ̇|) dψ.
    fn growth_without_lag(&self) -> f64 {
        let rule = Gauss::with(8);
        let of = |piece: usize| -> f64 {
            let (start, end) = (self.pieces[piece].1.start(), self.pieces[piece].1.end());
            let [sum] = rule.integrate((end - start).hi, |s| {
                // J|φ̇| = 2E/|φ̇|.
                let [v, w, _, slope] = self.at(piece, start + Double::from(s));
                [slope * w / (v * v)]
            });
            sum
        };
        (0..self.pieces.len()).map(of).sum()
    }
}

impl Periodic for Motion<'_> {
    fn period(&self) -> Double {
        self.pieces.last().map_or(Double::from(TAU), |(_, motion)| motion.end())
    }

    fn joints(&self) -> Vec<Double> {
        self.pieces.iter().map(|(_, motion)| motion.end()).collect()
    }

    fn at(&self, psi: Double, piece: usize) -> Coefficients {
        let [v, w, ahead, slope] = Motion::at(self, piece, psi);
        let stiffness = (self.turn.sense * ahead / w - slope) / (v * v * self.lag);
        Coefficients { damping: 1.0 / (self.lag * w), stiffness, forcing: 0.0 }
    }

    fn longest_cell(&self, _: Double, _: usize) -> f64 {
        // The steps of the periodic motion, which are the pieces, resolve it.
        f64::INFINITY
    }
}
