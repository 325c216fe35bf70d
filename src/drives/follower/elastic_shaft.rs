//! The equation of motion of the twist, written once for numbers and for series.

use crate::drives::follower::equation::{Equation, Pace, Segments, Words};
use crate::drives::follower::flow::Flow;
use crate::drives::follower::load::Load;
use crate::drives::limits::refused_start;
use crate::drives::parameter::parameters;
use crate::drives::{Fault, Rounded};
use crate::motion::{Fourier, MotionLaw};
use crate::numerics::angle;
use crate::numerics::divisor::greatest_common_divisor;
use crate::numerics::double_double::Double;
use crate::numerics::taylor::Scalar;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;
use std::sync::Arc;

/// The angle over which a step of degree 8 may reach, times the resolution K of the law (rad): two radians of
/// the highest harmonic cannot hide between eight nodes.
pub const REACH: f64 = 2.0;

parameters! {
    /// Mass, inertia and shaft.
    Parameters, "elasticity" {
        /// Mass of the follower
        m = "m", "m", MASS in [0.0, 1e9], Tunable;
        /// Moment of inertia of the cam, at the far end of the shaft; above zero
        inertia = "J", "J", INERTIA in [1e-12, 1e9], Fixed;
        /// Torsional stiffness of the input shaft; above zero
        c = "c", "c", ROTATIONAL_STIFFNESS in [1e-12, 1e15], Tunable;
        /// Torsional damping of the input shaft
        b = "b", "b", ROTATIONAL_DAMPING in [0.0, 1e12] or 0.0, Tunable;
    }
}

/// The twist of the shaft.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Twist {
    /// m, J, c, b.
    pub parameters: Parameters,
    /// Whether the equation is linearised in q.
    pub linear: bool,
    /// The loads on the follower.
    pub load: Option<Arc<Load>>,
}

/// U … U⁗ at the cam's angle and, for time derivatives of the linearised equation only, U⁽⁵⁾; of the process force P, P′ and P″ at
/// the drive's angle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cam(pub [f64; 6], pub [f64; 3]);

impl Equation for Twist {
    type Law = MotionLaw;
    type Parameters = Parameters;
    type Local = Cam;

    fn parameters(&self) -> Parameters {
        self.parameters
    }

    fn with(&self, parameters: Parameters) -> Self {
        Twist { parameters, ..self.clone() }
    }

    fn prepare(&mut self, law: &MotionLaw) -> Result<(), Fault> {
        law.validate().map_err(|message| Fault::new(message).of("cam"))?;
        self.load.as_ref().map_or(Ok(()), |load| load.validate("load"))
    }

    fn is_linear(&self) -> bool {
        self.linear
    }

    fn linearised(&self) -> Self {
        Twist { linear: true, ..self.clone() }
    }

    fn carries_law(&self) -> bool {
        !self.linear
    }

    fn is_undamped(&self) -> bool {
        self.parameters.b == 0.0 && self.load.as_ref().is_none_or(|load| load.damping.unwrap_or(0.0) == 0.0)
    }

    fn words(&self) -> Words {
        Words {
            quantity: "the twist q",
            turning: "the cam",
            parameters: "J, m, c, b",
            frequency: "c and J",
            damping: "b",
            instead: if self.linear { ", set shaft.linear = false" } else { "" },
        }
    }

    fn load(&self) -> &Option<Arc<Load>> {
        &self.load
    }

    fn load_mut(&mut self) -> &mut Option<Arc<Load>> {
        &mut self.load
    }

    fn breakpoints<'a>(&'a self, law: &'a MotionLaw) -> [&'a [f64]; 2] {
        [law.breakpoints(), self.process().map_or(&[], MotionLaw::breakpoints)]
    }

    #[inline]
    fn at(&self, law: &MotionLaw, [segment, of_process]: Segments, f: &Flow<f64>) -> Cam {
        let [u0, u1, u2, u3, u4] = law.at_in(segment, self.angle(f)).0;
        let process = self.process().map_or([0.0; 3], |process| {
            let [p0, p1, p2, ..] = process.at_in(of_process, angle::reduce(Double::from(f.phi))).0;
            [p0, p1, p2]
        });
        Cam([u0, u1, u2, u3, u4, 0.0], process)
    }

    /// q̈ (rad/s²).
    ///
    /// Nonlinear, U at ψ: (J + m U′²) ψ̈ = −(m U′U″ ψ̇² + b q̇ + c q).
    /// Linear (4.2), U at φ, g = U′U″:
    /// (J + m U′²)(q̈ + α) = −(m ω² g + (b + 2 m ω g) q̇ + (c + m ω² g′ + 2 m α g) q).
    ///
    /// A load F_L adds the torque U′ F_L(U, U′ψ̇, φ, t); linear, with U, U′ω and φ and the stiffness c_r and the damping b_r of
    /// its spring and damper: U′ F_L + (U″ F_L − c_r U′² − b_r ω U′U″) q − b_r U′² q̇.
    #[inline(always)]
    fn acceleration<S: Scalar>(&self, cam: &Cam, f: &Flow<S>) -> S {
        let Parameters { m, inertia, c, b } = self.parameters;
        let [_, d1, d2, d3, d4, d5] = cam.0;
        let angle = f.argument(!self.linear);
        let (u1, u2) = (angle.compose([d1, d2, d3]), angle.compose([d2, d3, d4]));
        let inertia = u1 * u1 * m + S::from(inertia);
        let g = u1 * u2 * m;
        if self.linear {
            let g1 = (u2 * u2 + u1 * angle.compose([d3, d4, d5])) * m;
            let w2 = f.w * f.w;
            let stiffness = S::from(c) + w2 * g1 + f.a * g * 2.0;
            let damping = S::from(b) + f.w * g * 2.0;
            let torque = w2 * g + damping * f.v + stiffness * f.q;
            let torque = self.load.as_deref().map_or(torque, |load| torque - self.loaded(load, cam, f, [u1, u2]));
            -torque / inertia - f.a
        } else {
            let speed = f.cam_speed();
            let torque = g * speed * speed + f.v * b + f.q * c;
            let torque = self.load.as_deref().map_or(torque, |load| torque - self.loaded(load, cam, f, [u1, u2]));
            -torque / inertia - f.a
        }
    }

    fn jacobian(&self, cam: &Cam, f: &Flow<f64>) -> [f64; 2] {
        let Parameters { m, inertia, c, b } = self.parameters;
        let [u, u1, u2, u3, ..] = cam.0;
        let inertia = inertia + m * u1 * u1;
        let (g, g1) = (m * u1 * u2, m * (u2 * u2 + u1 * u3));
        let speed = f.turning(!self.linear);
        // c, b and the torque that a load adds to the shaft's.
        let (c, b, loaded) = self.load.as_deref().map_or((c, b, 0.0), |load| {
            let (force, damping) = (self.force(load, cam, f, [u, u1 * speed]), load.damping.unwrap_or(0.0));
            let by_q = u1 * u1 * load.stiffness() + speed * u1 * u2 * damping - u2 * force;
            (c + by_q, b + u1 * u1 * damping, -u1 * force - by_q * f.q - u1 * u1 * damping * f.v)
        });
        if self.linear {
            let stiffness = c + f.w * f.w * g1 + 2.0 * f.a * g;
            [-stiffness / inertia, -(b + 2.0 * f.w * g) / inertia]
        } else {
            let torque = g * speed * speed + b * f.v + c * f.q + loaded;
            let by_q = -(g1 * speed * speed + c) + torque * 2.0 * g / inertia;
            [by_q / inertia, -(2.0 * g * speed + b) / inertia]
        }
    }

    /// Rounding error of q̈ from U′, U″ and α over the unit roundoff: |α| + m ψ̇² (|U″| max|U″| + |U′| max|U‴|)/(J + m U′²)
    /// (rad/s²), since the sine of the k-th multiple of an angle is rounded k times as much as the angle. If the cam turns slowly
    /// the twist follows the forces of the follower, q̇ all but vanishes, and only this remains of q̈.
    ///
    /// A load's roundings add |F_L| max|U″| and |U′| times the sum of the sizes of its parts.
    fn rounding(&self, law: &MotionLaw, segments: Segments, f: &Flow<f64>) -> f64 {
        let (Parameters { m, inertia, .. }, [segment, _]) = (self.parameters, segments);
        let cam = self.at(law, segments, f);
        let [u, u1, u2, ..] = cam.0;
        // The bounds of the segment: next to a steep rise a gentle return would otherwise count all its errors as rounding.
        let [largest2, largest3] = [2, 3].map(|order| law.bound_in(segment, order));
        let speed = f.turning(!self.linear);
        let products = u2.abs() * largest2 + u1.abs() * largest3;
        let loaded = self.load.as_deref().map_or(0.0, |load| {
            let (at, [_, slope, _]) = ([u, u1 * speed], cam.1);
            let size = load.size(m, at, self.process().map(|_| cam.1[0].abs() + slope.abs()), Some(f.force));
            self.force(load, &cam, f, at).abs() * largest2 + u1.abs() * size
        });
        (m * speed * speed * products + loaded) / (inertia + m * u1 * u1) + f.a.abs()
    }

    fn roundings(&self, law: &MotionLaw) -> f64 {
        let ([slope, curvature], [u1, u2]) = (law.roundings(), [1, 2].map(|order| law.bound(order)));
        self.parameters.m * (u1 * curvature + u2 * slope) / self.parameters.inertia
    }

    fn reach(&self, law: &MotionLaw, [segment, of_process]: Segments, _: f64) -> f64 {
        let process = self.process().map_or(1.0, |process| process.resolution_in(of_process));
        REACH / law.resolution_in(segment).max(process)
    }

    /// U′², U′U″ and U″² + U′U‴ repeat themselves after an equal part of the turn: their harmonics are sums and differences of U's,
    /// and all of these are multiples of the greatest common divisor of 2 k₁ and k − k₁. Two parts for a law with odd harmonics
    /// alone. Under a load U itself counts, and its process force.
    fn symmetry(&self, law: &MotionLaw) -> usize {
        let Some(series) = law.series() else { return 1 };
        let mut orders = harmonics(series);
        if let Some(load) = &self.load {
            let process = load.process.as_ref().map_or(Some(None), |process| process.series().map(Some));
            let Some(process) = process else { return 1 };
            let all = orders.chain(process.into_iter().flat_map(harmonics));
            return all.reduce(greatest_common_divisor).unwrap_or(1);
        }
        let Some(first) = orders.next() else { return 1 };
        orders.fold(2 * first, |divisor, k| greatest_common_divisor(divisor, k - first))
    }

    fn cost(&self, law: &MotionLaw) -> f64 {
        law.cost() + self.process().map_or(0.0, MotionLaw::cost)
    }

    /// The vibration √(c/J); the angle from one breakpoint of the law to the next on the average, or 1/(2 K √(1 + m U′²max/J)), K
    /// the highest harmonic, whichever is smaller: J + m U′² has its complex zeros 1/K √(J/m)/U′max next to the zeros of U′. The
    /// cam turns at |ω| and the present speed of the vibration. A load counts with its spring and its process force.
    fn pace(&self, law: &MotionLaw, [q, v]: [f64; 2]) -> Pace {
        let Parameters { m, inertia, c, .. } = self.parameters;
        let ratio = m * law.bound(1).powi(2) / inertia;
        let resolution = law.resolution().max(self.process().map_or(1.0, MotionLaw::resolution));
        let smooth = 0.5 / (resolution * (1.0 + ratio).sqrt());
        let breakpoints: usize = self.breakpoints(law).iter().map(|list| list.len()).sum();
        let angle = smooth.min(TAU / breakpoints.max(1) as f64);
        let spring = self.load.as_ref().map_or(0.0, |load| load.stiffness() * law.bound(1).powi(2));
        let frequency = ((c + spring) / inertia).sqrt();
        Pace { frequency, angle, speed: if self.linear { 0.0 } else { v.abs() + frequency * q.abs() } }
    }

    fn contact(&self, now: impl FnOnce() -> (Cam, Flow<f64>)) -> [f64; 2] {
        let m = self.parameters.m;
        let holds = |load: &&Load| load.hold(m, 0.0) != 0.0 || load.stiffness() > 0.0;
        let Some(load) = self.load.as_deref().filter(holds) else { return [0.0; 2] };
        let (cam, f) = now();
        [load.hold(m, self.lift(&cam, &f)), self.contact_force(&cam, &f)]
    }

    /// c q = U′ F_L, U at φ + q and q̇ = 0, followed as the load grows from zero: with λ F_L the way is λ = c q/(U′ F_L), and its
    /// equilibria are stable as long as λ grows with q. Linear: c q = U′ F_L + (U″ F_L − c_r U′²) q.
    fn at_rest(&self, law: &MotionLaw, f: &Flow<f64>) -> Result<[f64; 2], Fault> {
        let Some(load) = self.load.as_deref() else { return Ok([0.0; 2]) };
        let c = self.parameters.c;
        // U′ F_L and its derivative.
        let torque = |q: f64| {
            let there = Flow { q, w: f.w, ..*f };
            let cam = self.at(law, self.segments(law, &there), &there);
            let [u, u1, u2, ..] = cam.0;
            let force = self.force(load, &cam, f, [u, 0.0]);
            [u1 * force, u2 * force - u1 * u1 * load.stiffness()]
        };
        let snaps = |q: f64| {
            refused_start(format!(
                "start.mode = equilibrium is refused: the load turns the cam away from drive.phi_start faster than the shaft holds \
                 it, from a twist of {} rad on it snaps through; choose a larger c, a smaller load or another angle",
                Rounded(q)
            ))
        };
        let [start, slope] = torque(0.0);
        if slope >= c {
            return Err(snaps(0.0));
        }
        if self.linear || start == 0.0 {
            return Ok([start / (c - slope), 0.0]);
        }
        // Steps within which the torque follows a cubic; it vanishes within a turn and has crossed c q before.
        let step = 0.05f64.copysign(start) / law.resolution();
        let mut low = 0.0;
        while (c * (low + step) - torque(low + step)[0]) * start < 0.0 {
            low += step;
            let [torque, slope] = torque(low);
            if (torque - slope * low) * start <= 0.0 || low.abs() > TAU {
                return Err(snaps(low));
            }
        }
        // Newton's method from within the bracket, bisection if it leaves it.
        let (mut high, mut q) = (low + step, low);
        for _ in 0..64 {
            let [torque, slope] = torque(q);
            let miss = c * q - torque;
            if miss * start < 0.0 {
                low = q
            } else {
                high = q
            }
            let newton = q - miss / (c - slope);
            let inside = (newton - low) * (newton - high) <= 0.0;
            let next = if inside { newton } else { 0.5 * (low + high) };
            if next == q {
                break;
            }
            q = next;
        }
        if torque(q)[1] < c { Ok([q, 0.0]) } else { Err(snaps(q)) }
    }
}

/// The orders of the nonzero harmonics of a series.
fn harmonics(series: &Fourier) -> impl Iterator<Item = usize> {
    (1..=series.order()).filter(|&k| series.a[k] != 0.0 || series.b[k] != 0.0)
}

impl Twist {
    /// F_L (N) on the follower at `y` with this speed.
    fn force<S: Scalar>(&self, load: &Load, cam: &Cam, f: &Flow<S>, y: [S; 2]) -> S {
        let process = load.process.is_some().then(|| f.phi.compose(cam.1));
        load.force(self.parameters.m, y, process, load.input.then_some(f.force))
    }

    /// The torque of a load on the cam (N·m).
    #[inline(never)]
    fn loaded<S: Scalar>(&self, load: &Load, cam: &Cam, f: &Flow<S>, [u1, u2]: [S; 2]) -> S {
        let [d0, d1, d2, ..] = cam.0;
        let speed = f.turning(!self.linear);
        let force = self.force(load, cam, f, [f.argument(!self.linear).compose([d0, d1, d2]), u1 * speed]);
        if !self.linear {
            return u1 * force;
        }
        let b = load.damping.unwrap_or(0.0);
        let by_q = u2 * force - u1 * u1 * load.stiffness() - speed * u1 * u2 * b;
        u1 * force + by_q * f.q - u1 * u1 * b * f.v
    }

    fn angle(&self, f: &Flow<f64>) -> f64 {
        angle::reduce(Double::from(f.argument(!self.linear)))
    }

    /// The cam with U⁽⁵⁾.
    pub fn with_fifth(&self, law: &MotionLaw, segments: Segments, f: &Flow<f64>) -> Cam {
        let mut cam = self.at(law, segments, f);
        cam.0[5] = law.fifth_in(segments[0], self.angle(f));
        cam
    }

    /// y = U(ψ), or U + U′ q if the equation is linearised (m).
    #[inline(always)]
    pub fn lift<S: Scalar>(&self, cam: &Cam, f: &Flow<S>) -> S {
        let [d0, d1, d2, d3, ..] = cam.0;
        let angle = f.argument(!self.linear);
        let u = angle.compose([d0, d1, d2]);
        if self.linear { u + angle.compose([d1, d2, d3]) * f.q } else { u }
    }

    /// ẏ = U′ ψ̇, or (U′ + U″ q) ω + U′ q̇ (m/s).
    #[inline(always)]
    pub fn lift_speed<S: Scalar>(&self, cam: &Cam, f: &Flow<S>) -> S {
        let [_, d1, d2, d3, d4, _] = cam.0;
        let angle = f.argument(!self.linear);
        let u1 = angle.compose([d1, d2, d3]);
        if self.linear { (u1 + angle.compose([d2, d3, d4]) * f.q) * f.w + u1 * f.v } else { u1 * f.cam_speed() }
    }

    /// N = m ÿ − F_L (N), the force of the cam on the follower; 0 without a load.
    ///
    /// ÿ = U″ ψ̇² + U′ ψ̈, or (U″ + U‴ q) ω² + 2 U″ ω q̇ + (U′ + U″ q) α + U′ q̈.
    #[inline(never)]
    pub fn contact_force<S: Scalar>(&self, cam: &Cam, f: &Flow<S>) -> S {
        let Some(load) = self.load.as_deref() else { return S::from(0.0) };
        let acceleration = self.acceleration(cam, f) + f.a;
        let [_, d1, d2, d3, d4, d5] = cam.0;
        let angle = f.argument(!self.linear);
        let (u1, u2) = (angle.compose([d1, d2, d3]), angle.compose([d2, d3, d4]));
        let lift = if self.linear {
            let bent = u2 + angle.compose([d3, d4, d5]) * f.q;
            bent * f.w * f.w + u2 * f.w * f.v * 2.0 + u2 * f.q * f.a + u1 * acceleration
        } else {
            let speed = f.cam_speed();
            u2 * speed * speed + u1 * acceleration
        };
        lift * self.parameters.m - self.force(load, cam, f, [self.lift(cam, f), self.lift_speed(cam, f)])
    }

    /// tau = −(c q + b q̇) (N·m).
    pub fn torque<S: Scalar>(&self, q: S, v: S) -> S {
        -(q * self.parameters.c + v * self.parameters.b)
    }
}
