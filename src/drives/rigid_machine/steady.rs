//! The periodic steady state, found by shooting over one turn of the angle.
//!
//! In the φ-domain, with σ = sgn(w_s), ψ = σ(φ − φ_start) and v = σu = √(2E) > 0, the motion is
//!
//! dv/dψ = σ(M_an − τ)/v,  dt/dψ = √J/v,  φ̇ = σ v/√J
//!
//! and v(0) → v(2π) is a monotone scalar map. Its fixed points are the rotating periodic motions; T = t(2π). The
//! multiplier of an orbit is the slope exp ∮ ∂(dv/dψ)/∂v dψ of the map.
//!
//! Without load every periodic orbit satisfies ½ J_min w_s² ≤ E ≤ ½ J_max w_s². It is unique where the slip stays
//! within ±s_K; otherwise there may be several. **Of the stable orbits the fastest is taken**: the one that a machine
//! reaches that was fast before. The map is scanned for changes of the sign of v(2π) − v(0), so that two orbits
//! closer together than the scan's raster (half a per cent of the speed) may be overlooked.
//!
//! With a lagging torque the map has two dimensions, (v, M_an); Newton's method starts from the orbit without lag,
//! and the orbit must be stable.

use super::inertia::Place;
use super::{Inertia, Motor, RigidMachine};
use crate::drives::{Event, Fault};
use crate::numerics::collocation::{Collocation, System};
use crate::numerics::double_double::Double;
use std::f64::consts::TAU;

/// Tolerance of the scan; the signs are all that matters.
const SCAN_TOLERANCE: f64 = 1e-7;

/// Tolerance of the orbit itself.
const ORBIT_TOLERANCE: f64 = 1e-13;

/// How many speeds of the scan lie where orbits without load can lie, and how many below.
const SCAN: usize = 80;
const SCAN_BELOW: usize = 32;

/// Iterations of the shooting; Newton's method needs a handful, bisection fifty.
const ITERATIONS: usize = 80;

/// A smooth piece of the turn: from and to which ψ.
struct Leg {
    place: Place,
    end: f64,
}

/// The φ-domain form on one leg: v, and of N = 2 the lagging torque. The last is t, or with `VARIATION` the exponent
/// of the multiplier.
struct Turn<'a> {
    inertia: &'a Inertia,
    motor: &'a Motor,
    tau: f64,
    /// σ.
    sense: f64,
    phi_start: f64,
}

struct OnLeg<'a> {
    turn: &'a Turn<'a>,
    place: Place,
}

impl OnLeg<'_> {
    /// √J, φ̇.
    fn speed(&self, psi: Double, v: f64) -> (f64, f64) {
        let root = self.turn.inertia.at(self.place, self.turn.phi_start + self.turn.sense * psi.hi)[0].sqrt();
        // A machine that comes to rest before the turn is over has no φ-domain form; the square root tells.
        (root, self.turn.sense * if v > 0.0 { v } else { f64::NAN } / root)
    }

    /// The longest step in ψ: a wave of J per step.
    fn reach(&self) -> f64 {
        TAU / self.turn.inertia.resolution()
    }
}

/// v, the exponent ∫ ∂(dv/dψ)/∂v dψ, and t.
impl System<3> for OnLeg<'_> {
    fn rhs(&self, psi: Double, y: &[f64; 3]) -> [f64; 3] {
        let (root, w) = self.speed(psi, y[0]);
        let [torque, slope, _] = self.turn.motor.characteristic(w);
        let net = self.turn.sense * (torque - self.turn.tau);
        [net / y[0], slope / (root * y[0]) - net / (y[0] * y[0]), root / y[0]]
    }

    fn jacobian(&self, psi: Double, y: &[f64; 3]) -> [[f64; 3]; 3] {
        let (root, w) = self.speed(psi, y[0]);
        let v = y[0];
        let [torque, slope, curvature] = self.turn.motor.characteristic(w);
        let net = self.turn.sense * (torque - self.turn.tau);
        let exponent = slope / (root * v) - net / (v * v);
        let change =
            self.turn.sense * curvature / (root * root * v) - 2.0 * slope / (root * v * v) + 2.0 * net / (v * v * v);
        [[exponent, 0.0, 0.0], [change, 0.0, 0.0], [-root / (v * v), 0.0, 0.0]]
    }

    fn magnitude(&self, y: &[f64; 3]) -> [f64; 3] {
        [y[0].abs(), 1.0, y[2].abs()]
    }

    fn longest_step(&self, _: Double, _: &[f64; 3]) -> f64 {
        self.reach()
    }
}

/// v, the lagging torque and t.
struct WithLag<'a>(OnLeg<'a>);

impl System<3> for WithLag<'_> {
    fn rhs(&self, psi: Double, y: &[f64; 3]) -> [f64; 3] {
        let turn = self.0.turn;
        let (root, w) = self.0.speed(psi, y[0]);
        let lag = turn.motor.lag().unwrap_or(f64::NAN);
        let rate = (turn.motor.characteristic(w)[0] - y[1]) / lag;
        [turn.sense * (y[1] - turn.tau) / y[0], rate * root / y[0], root / y[0]]
    }

    fn jacobian(&self, psi: Double, y: &[f64; 3]) -> [[f64; 3]; 3] {
        let turn = self.0.turn;
        let (root, w) = self.0.speed(psi, y[0]);
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
        let Motor::Kloss { breakdown_torque, .. } = self.0.turn.motor else { return [1.0; 3] };
        [y[0].abs(), *breakdown_torque, y[2].abs()]
    }

    fn longest_step(&self, _: Double, _: &[f64; 3]) -> f64 {
        self.0.reach()
    }
}

impl Turn<'_> {
    /// The smooth pieces that the shaft passes from the start, in their order.
    fn legs(&self, mut interval: usize) -> Vec<Leg> {
        let borders = self.inertia.borders().len();
        if borders == 0 {
            return vec![Leg { place: self.inertia.place(0), end: TAU }];
        }
        let mut legs = Vec::with_capacity(borders + 1);
        let mut at = self.phi_start;
        let mut psi = 0.0;
        while psi < TAU {
            let (low, high) = self.inertia.ends(interval);
            let width = if legs.is_empty() { if self.sense > 0.0 { high - at } else { at - low } } else { high - low };
            psi = (psi + width.max(0.0)).min(TAU);
            legs.push(Leg { place: self.inertia.place(interval), end: psi });
            interval = if self.sense > 0.0 { (interval + 1) % borders } else { (interval + borders - 1) % borders };
            at = 0.0;
            // The raster of the borders cannot have more pieces than this.
            if legs.len() > borders + 1 {
                break;
            }
        }
        if let Some(last) = legs.last_mut() {
            last.end = TAU;
        }
        legs
    }

    /// The values after a turn that starts with `y`; None where the machine comes to rest.
    fn run<'a, S: System<3>>(
        &'a self,
        legs: &[Leg],
        y: [f64; 3],
        tolerance: f64,
        system: impl Fn(OnLeg<'a>) -> S,
    ) -> Option<[f64; 3]> {
        let mut c = Collocation::<3>::new(Double::from(0.0), y);
        for leg in legs {
            let on_leg = system(OnLeg { turn: self, place: leg.place });
            c.advance(&on_leg, Double::from(leg.end), tolerance).ok()?;
            // Below a billionth of the first speed the time scale of the turn has gone: this is a standstill.
            if c.state()[0] < 1e-9 * y[0] {
                return None;
            }
        }
        Some(c.state())
    }

    /// v(2π) − v(0), the slope of the map and T.
    fn shoot(&self, legs: &[Leg], v: f64, tolerance: f64) -> Option<[f64; 3]> {
        let [end, exponent, period] = self.run(legs, [v, 0.0, 0.0], tolerance, |leg| leg)?;
        Some([end - v, exponent.exp(), period])
    }

    /// The brackets of the stable orbits, the fastest first, and the number of all orbits found.
    fn scan(&self, legs: &[Leg], speeds: impl Iterator<Item = f64>) -> (Vec<(f64, f64)>, usize) {
        let mut stable = Vec::new();
        let mut orbits = 0;
        let mut above: Option<(f64, f64)> = None;
        for v in speeds {
            // A machine that comes to rest has lost speed.
            let gain = self.shoot(legs, v, SCAN_TOLERANCE).map_or(f64::NEG_INFINITY, |s| s[0]);
            if let Some((faster, gain_above)) = above {
                if gain >= 0.0 && gain_above < 0.0 {
                    stable.push((v, faster));
                    orbits += 1;
                } else if gain < 0.0 && gain_above >= 0.0 {
                    orbits += 1;
                }
            }
            above = Some((v, gain));
        }
        (stable, orbits)
    }

    /// The fixed point between `low`, from which the machine speeds up, and `high`, from which it slows down.
    fn refine(&self, legs: &[Leg], (mut low, mut high): (f64, f64)) -> Option<(f64, f64)> {
        let mut v = 0.5 * (low + high);
        let mut best = None;
        for _ in 0..ITERATIONS {
            let Some([gain, slope, period]) = self.shoot(legs, v, ORBIT_TOLERANCE) else {
                low = v;
                v = 0.5 * (low + high);
                continue;
            };
            best = Some((v, period));
            if gain == 0.0 {
                break;
            }
            if gain > 0.0 {
                low = v;
            } else {
                high = v;
            }
            let newton = v - gain / (slope - 1.0);
            let next = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
            // Rounding of the turn's integration moves v by some units in the last place.
            if (next - v).abs() <= 2e-16 * v {
                break;
            }
            v = next;
        }
        best
    }

    /// The orbit (v, M_an) of a motor with lag next to the orbit `v` without; also T and the spectral radius.
    fn refine_with_lag(&self, legs: &[Leg], v: f64, torque_scale: f64) -> Option<([f64; 2], f64, f64)> {
        let root = self.inertia.at(legs[0].place, self.phi_start)[0].sqrt();
        let mut y = [v, self.motor.characteristic(self.sense * v / root)[0]];
        let shoot = |y: [f64; 2]| self.run(legs, [y[0], y[1], 0.0], ORBIT_TOLERANCE, WithLag);
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
                return Some((y, shoot(y)?[2], spectral_radius(map)));
            }
            smallest = smallest.min(size);
        }
        None
    }
}

/// The larger modulus of the eigenvalues of a 2 × 2 matrix.
fn spectral_radius([[a, b], [c, d]]: [[f64; 2]; 2]) -> f64 {
    let (mean, determinant) = (0.5 * (a + d), a * d - b * c);
    let root = mean * mean - determinant;
    if root < 0.0 { determinant.sqrt() } else { mean.abs() + root.sqrt() }
}

impl RigidMachine {
    /// Puts the machine on its periodic orbit under the load that acts at the start.
    pub(super) fn start_periodically(&mut self, time: f64) -> Result<(), Fault> {
        let Motor::Kloss { breakdown_torque, breakdown_slip, synchronous_speed, .. } = self.motor else {
            return Err(Fault::new(
                "`start.mode` = steady_state needs a motor with a characteristic: a torque that does not depend on the speed selects no periodic motion; use `given`",
            ));
        };
        let sense = synchronous_speed.signum();
        self.place_at_start(sense * synchronous_speed.abs());
        let (low, high) = self.inertia.range();
        let turn = Turn {
            inertia: &self.inertia,
            motor: &self.motor,
            tau: self.load.now(),
            sense,
            phi_start: self.state.angle.hi,
        };
        let legs = turn.legs(self.state.interval);
        let speed = synchronous_speed.abs();
        // A stable orbit keeps the slip within ±s_K on average; a fifth more leaves room for its fluctuation.
        let top = high.sqrt() * speed * (1.0 + breakdown_slip.min(1.0)) * 1.2;
        let bottom = low.sqrt() * speed * (1.0 - breakdown_slip).max(0.1) * 0.8;
        let even = |i: usize| top + (bottom - top) * i as f64 / SCAN as f64;
        let below = |i: usize| bottom * 0.02_f64.powf((i + 1) as f64 / SCAN_BELOW as f64);
        let (stable, orbits) = turn.scan(&legs, (0..=SCAN).map(even).chain((0..SCAN_BELOW).map(below)));
        let none = || {
            Fault(format!(
                "`start.mode` = steady_state: with `tau` = {} N.m there is no stable periodic motion; the motor (breakdown torque {breakdown_torque} N.m) stalls or runs away. Reduce the load or use `given`",
                self.load.now()
            ))
        };
        let &bracket = stable.first().ok_or_else(none)?;
        let (mut v, mut period) = turn.refine(&legs, bracket).ok_or_else(none)?;
        let mut torque = 0.0;
        if self.motor.lag().is_some() {
            let (orbit, t, radius) = turn.refine_with_lag(&legs, v, breakdown_torque).ok_or_else(none)?;
            if radius > 1.0 {
                return Err(Fault(format!(
                    "`start.mode` = steady_state: the periodic motion is unstable (a disturbance grows by {radius:.4} per turn); change `motor.T_el` or use `given`"
                )));
            }
            ([v, torque], period) = (orbit, t);
        }
        self.state.u = Double::from(sense * v);
        self.state.w = self.state.u.hi / self.inertia_here()[0].sqrt();
        self.state.torque = torque;
        self.period = period;
        self.events.push(Event {
            time,
            kind: if orbits > 1 {
                "several periodic motions exist; the fastest stable one was taken"
            } else {
                "periodic motion found"
            },
            quantity: "period",
            value: period,
            unit: "s",
            solver: true,
        });
        Ok(())
    }
}
