//! A panel: a span of time in one mode over which the motion is known to rounding, as power series of time, up to its first
//! event.

use super::overdamped;
use super::series::{FlankSeries, MOST_TERMS, REACH, Series};
use super::switching::{Search, Switch};
use crate::drives::follower::contact::{Beginning, Bodies, Mode, State};
use crate::drives::follower::flank::FlankMotion;
use crate::motion::Kinematics;
use crate::numerics::double_double::Double;
use crate::numerics::gauss::Gauss;
use crate::numerics::number::all_finite;
use crate::numerics::pair::Pair;
use serde::{Deserialize, Serialize};

/// Cost of a panel with the search for its event, without the expansion of u (nominal µs).
const PANEL: f64 = 0.7;

/// A panel; see the module.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct Panel {
    /// The start of the panel.
    pub from: Beginning,
    /// The duration (s).
    pub length: f64,
    /// The first event, after the start (s).
    pub event: Option<(Switch, f64)>,
    /// The segment at the end.
    pub next_segment: usize,
    /// The motion.
    pub series: Series,
    /// In flight the centre of mass at the start (m) and its velocity (m/s).
    centre: [f64; 2],
    /// Cost of computing it (nominal µs).
    #[serde(skip)]
    pub cost: f64,
}

/// The motion at an instant.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Point {
    /// The relative state.
    pub state: State,
    /// u (m), u̇ (m/s) and, in contact, ü (m/s²).
    pub u: [f64; 3],
}

impl Point {
    /// x1 (m) and ẋ1 (m/s).
    pub fn place(&self) -> [f64; 2] {
        let State { home, zeta, .. } = self.state;
        [self.u[0] + (home + zeta[0]), self.u[1] + zeta[1]]
    }

    /// Whether all numbers are finite.
    pub fn is_finite(&self) -> bool {
        all_finite(self.place()) && all_finite(self.state.q)
    }
}

impl Panel {
    /// Becomes the panel from there on, with series of so many terms: in place, since it is too large to be moved.
    pub fn lay(&mut self, bodies: &Bodies, flank: &impl FlankMotion, from: Beginning, terms: usize) {
        let Beginning { start, segment, phase, longest } = from;
        let oscillator = bodies.oscillator(phase.mode);
        let flank_rate = flank.rate(segment, start);
        let rate = oscillator.rates().1.max(flank_rate);
        let slow = overdamped::slow_rate(oscillator, flank_rate);
        let mut u = FlankSeries::new(flank, &from, terms, REACH / slow.unwrap_or(rate));
        let mut q =
            slow.and_then(|_| overdamped::elongation(oscillator, &phase, &u, flank.acceleration(segment, start)));
        if slow.is_some() && q.is_none() {
            u = FlankSeries::new(flank, &from, terms, REACH / rate);
        }
        self.series.take(bodies, &phase, &u, q.get_or_insert_with(|| u.elongation(oscillator, &phase)));
        let State { q: [q0, v0], home, zeta } = phase.state;
        self.centre = [u.u[0] + home + zeta[0] + bodies.share * q0, u.u[1] / u.span + zeta[1] + bodies.share * v0];
        (self.length, self.next_segment) = flank.stay(segment, start, u.span.min(longest));
        (self.from, self.event, self.cost) = (from, None, PANEL + u.cost);
        // Without clearance the other flank holds m1.
        if self.length > 0.0 && bodies.s > 0.0 {
            let contact = phase.mode != Mode::Free;
            let resolution = if contact { bodies.resolution(flank, (start, segment)) } else { 0.0 };
            let search = Search { from: &self.from, series: &self.series, length: self.length, rate, resolution };
            self.event = search.first_event(bodies);
        }
    }

    /// The position of m1.
    pub fn mode(&self) -> Mode {
        self.from.phase.mode
    }

    /// The state `theta` (s) after the start, with u, u̇ … u⁗.
    pub fn event_at(&self, bodies: &Bodies, flank: &impl FlankMotion, theta: f64) -> (State, Kinematics) {
        (self.at(bodies, theta).state, flank.at(self.from.segment, self.instant(theta)))
    }

    /// The time from the start to `time` (s), to the last digit or two: the first difference is exact if it is small.
    #[inline(always)]
    pub fn until(&self, time: f64) -> f64 {
        (time - self.from.start.hi) - self.from.start.lo
    }

    /// The instant `theta` (s) after the start.
    pub fn instant(&self, theta: f64) -> Double {
        self.from.start + Double::from(theta)
    }

    /// The motion `theta` (s) after the start. In flight x1 is at −μ q from the centre of mass, which moves uniformly.
    pub fn at(&self, bodies: &Bodies, theta: f64) -> Point {
        let contact = self.mode() != Mode::Free;
        let sums = if contact { self.series.at::<true>(theta) } else { self.series.at::<false>(theta) };
        let [[first, q], [rate, q_dot], [acceleration, _]] = sums.map(Pair::array);
        let (q, State { home, zeta, .. }) = ([q, q_dot], self.from.phase.state);
        if contact {
            return Point { state: State { q, home, zeta }, u: [first, rate, acceleration] };
        }
        let [place, speed] = self.centre;
        let [x, x_dot] = [place + theta * speed - bodies.share * q[0], speed - bodies.share * q[1]];
        // Rounding may put m1 beyond a flank that it has not reached.
        let zeta = [first.clamp(-home, bodies.s - home), rate];
        Point { state: State { q, home, zeta }, u: [x - home - zeta[0], x_dot - zeta[1], 0.0] }
    }

    /// The time to the first event, or to the end of the panel (s).
    pub fn limit(&self) -> f64 {
        self.event.map_or(self.length, |(_, at)| at)
    }

    /// ∫ F_K dt, ∫ U′ F_K dt between two times after the start.
    pub fn integrals(&self, flank: &impl FlankMotion, way: [f64; 2]) -> [f64; 2] {
        if self.mode() == Mode::Free {
            return [0.0; 2];
        }
        match self.series.terms_at(way[1] / self.series.span) {
            ..=14 => self.integrals_by::<14>(flank, way),
            15..=18 => self.integrals_by::<18>(flank, way),
            _ => self.integrals_by::<MOST_TERMS>(flank, way),
        }
    }

    /// [`Panel::integrals`] from N terms of the series.
    fn integrals_by<const N: usize>(&self, flank: &impl FlankMotion, way: [f64; 2]) -> [f64; 2] {
        let (uniform, speed) = (flank.is_uniform(), flank.speed());
        let slope = |theta: f64| flank.slope(self.from.segment, self.instant(theta));
        let [force, torque] = self.integrate(way, |theta| {
            let [force, rate] = self.series.force_and_rate::<N>(theta).array();
            [force, force * if uniform { rate } else { slope(theta) }]
        });
        // U′ = u̇/ω at constant speed.
        let torque = match (uniform, speed) {
            (true, 0.0) => force * slope(0.0),
            (true, _) => torque / speed,
            (false, _) => torque,
        };
        [force, torque]
    }

    /// ∫ b q̇² dt from the start to `theta` (s).
    pub fn damping_loss(&self, bodies: &Bodies, theta: f64) -> f64 {
        if bodies.b == 0.0 {
            return 0.0;
        }
        let [loss] = self.integrate([0.0, theta], |theta| {
            let [_, q_dot] = self.series.at::<false>(theta)[1].array();
            [bodies.b * q_dot * q_dot]
        });
        loss
    }

    /// The integrals of products of two quantities between two times after the start. A product changes by at most four radians
    /// in a panel; n nodes integrate a wave over w radians to w²ⁿ (n!)⁴/((2n + 1) ((2n)!)³): 2e-16, 4e-17, 2e-24.
    fn integrate<const N: usize>(&self, [from, to]: [f64; 2], f: impl Fn(f64) -> [f64; N]) -> [f64; N] {
        if to <= from {
            return [0.0; N];
        }
        let nodes = match 4.0 * (to - from) / self.series.span {
            ..=1.0 => 6,
            ..=2.5 => 8,
            _ => 12,
        };
        Gauss::with(nodes).integrate(to - from, |s| f(from + s))
    }
}
