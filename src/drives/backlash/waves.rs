//! The closed form of the motion at constant speed where U is a Fourier series with few harmonics.
//!
//! On a flank q is the response to the harmonics of −ü and the free vibration of m2; in flight q is the free vibration of
//! m1 against m2 and the centre of mass moves uniformly, so that
//!
//! x1 = X₀ + V τ − μ q,  μ = m2/(m1 + m2),
//!
//! where τ counts from the start of the panel. Every quantity is a sum of waves of known frequencies. [`super::search`] finds
//! the switching instants from their Taylor coefficients.
//!
//! With a rebound the flights stay with the power series.
//!
//! Source: Dresig, Vulfson, *Dynamik der Mechanismen*, section 4.6.2 (response to HS profiles).

use super::contact::{Bodies, Mode, State};
use super::flank::FlankMotion;
use super::panel::{Pair, Panel, Point, REACH, Reading, Rules};
use super::search::Search;
use super::slow::stiff_rate;
use crate::drives::cam_turn::turns;
use crate::drives::response::progression;
use crate::motion::{Fourier, Kinematics};
use crate::numerics::double_double::{Double, two_product};
use crate::numerics::oscillator::Oscillator;
use crate::numerics::phase::{sin_cos, sin_cos_of_both};

/// The most harmonics; with more a power series costs less.
const MOST_HARMONICS: usize = 8;

/// Terms of the Taylor polynomials: the remainder is 2¹²/12! = 9e-6 of the amplitudes after a leap.
pub(super) const TERMS: usize = 12;

/// Terms that mostly show that there is no zero: the remainder is 2⁶/6! = 0.09 of the amplitudes.
pub(super) const SOME: usize = 6;

/// Terms about a place just before a zero.
pub(super) const FEW: usize = 4;

const PAIRS: usize = TERMS / 2;

/// The longest panel in leaps: after 16 rad the phases of the waves have lost less than two of their bits.
const MOST_LEAPS: usize = 8;

/// What a harmonic adds to u, u̇, q and q̇ on a flank: `cosine` cos kφ + `sine` sin kφ. Aligned for packed arithmetic.
#[repr(align(16))]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Wave {
    cosine: [f64; 4],
    sine: [f64; 4],
}

/// What the search in one mode knows beforehand.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Guard {
    /// The length of a leap [s].
    pub(super) leap: f64,
    /// The harmonics of the function, as of cos kφ and sin kφ.
    harmonics: [[f64; 2]; MOST_HARMONICS],
    /// The Taylor coefficients of a harmonic with the value and the slope (per radian) 1.
    series: [[Pair; PAIRS]; MOST_HARMONICS],
    /// The Taylor coefficients of a free vibration with the value 1, and with the slope 1/s.
    free: [[Pair; PAIRS]; 2],
    /// The sum of the amplitudes of the harmonics.
    pub(super) size: f64,
    /// The remainders of the harmonics after few, some and all terms, and of a free vibration of the amplitude 1.
    pub(super) remainders: [f64; 3],
    pub(super) free_remainders: [f64; 3],
    /// By what a leap turns e^(iφ), and what it makes of a free vibration.
    pub(super) turn: [f64; 2],
    pub(super) map: [[f64; 2]; 2],
}

/// The waves of a drive at constant speed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Waves {
    /// a₀ [m].
    pub(super) mean: f64,
    /// φ̇ [rad/s].
    pub(super) speed: f64,
    /// The orders are first, first + distance …
    first: usize,
    distance: usize,
    count: usize,
    waves: [Wave; MOST_HARMONICS],
    /// (kφ̇)², for ü [1/s²].
    squares: [f64; MOST_HARMONICS],
    /// Sums of the amplitudes of u, u̇, q and q̇.
    sizes: [f64; 4],
    bound: Guard,
    flight: Guard,
}

impl Waves {
    /// The waves of `series` at the speed `w` [rad/s] under these bodies; None where the closed form does not serve:
    /// at rest, with too many harmonics, where a mode does not oscillate, near a resonance.
    pub fn new(bodies: &Bodies, series: &Fourier, w: f64) -> Option<Self> {
        let (first, distance) = progression(series);
        if !turns(w) || first == 0 || bodies.bound.frequency().is_none() || bodies.relative.frequency().is_none() {
            return None;
        }
        let orders = (first..=series.order()).step_by(distance);
        let count = orders.clone().count();
        let mut waves = Waves {
            mean: series.a[0],
            speed: w,
            first,
            distance,
            count,
            waves: Default::default(),
            squares: [0.0; MOST_HARMONICS],
            sizes: [0.0; 4],
            bound: Guard::default(),
            flight: Guard::default(),
        };
        if count > MOST_HARMONICS {
            return None;
        }
        let sense = w.signum();
        let mut force = [[0.0; 2]; MOST_HARMONICS];
        let mut cam = [[0.0; 2]; MOST_HARMONICS];
        let mut rates = [0.0; MOST_HARMONICS];
        for (i, k) in orders.enumerate() {
            let (a, b, rate) = (series.a[k], series.b[k], k as f64 * w);
            let nu = two_product(k as f64, w.abs());
            // ψ = φ sgn w grows: see the elastic output.
            let response = bodies.bound.harmonic([nu.hi * nu.hi * a, -nu.hi * nu.hi * sense * b], nu);
            if response.resonant.is_some() {
                return None;
            }
            let [re, im] = response.steady;
            let wave =
                Wave { cosine: [a, rate * b, re, -nu.hi * im], sine: [b, -rate * a, -sense * im, -nu.hi * sense * re] };
            let square = nu.hi * nu.hi;
            let pressed = |u: f64, q: f64, q_dot: f64| -bodies.m1 * square * u - bodies.link(q, q_dot);
            force[i] = [pressed(a, wave.cosine[2], wave.cosine[3]), pressed(b, wave.sine[2], wave.sine[3])];
            cam[i] = [-a, -b];
            (waves.waves[i], waves.squares[i], rates[i]) = (wave, square, rate);
            for n in 0..4 {
                waves.sizes[n] += length([wave.cosine[n], wave.sine[n]]);
            }
        }
        waves.bound = Guard::new(&bodies.bound, (&rates[..count], w), force);
        waves.flight = Guard::new(&bodies.relative, (&rates[..count], w), cam);
        Some(waves)
    }

    /// Whether power series treat the fast modes apart, in contact or in flight.
    pub(super) fn is_stiff(&self, bodies: &Bodies) -> bool {
        [&bodies.bound, &bodies.relative].into_iter().any(|own| stiff_rate(own, self.fastest()).is_some())
    }

    /// The rate of the highest harmonic [rad/s].
    pub(super) fn fastest(&self) -> f64 {
        (self.first + self.distance * (self.count - 1)) as f64 * self.speed.abs()
    }

    /// e^(ikφ) for the harmonics in turn, from e^(iφ), given to `each`.
    #[inline(always)]
    fn powers(&self, z: [f64; 2], mut each: impl FnMut(usize, [f64; 2])) {
        let (turn, mut power) = (raised(z, self.distance), raised(z, self.first));
        each(0, power);
        for i in 1..self.count.min(MOST_HARMONICS) {
            power = product(power, turn);
            each(i, power);
        }
    }

    /// The first N of u, u̇ and, on a flank, the response q, q̇.
    #[inline(always)]
    fn driven<const N: usize>(&self, z: [f64; 2]) -> [f64; N] {
        let mut sum = [0.0; N];
        sum[0] = self.mean;
        self.powers(z, |i, [c, s]| {
            let Wave { cosine, sine } = self.waves[i];
            for n in 0..N {
                sum[n] += cosine[n] * c + sine[n] * s;
            }
        });
        sum
    }

    /// u, u̇ … u⁗.
    fn kinematics(&self, z: [f64; 2]) -> Kinematics {
        let mut u = [self.mean, 0.0, 0.0, 0.0, 0.0];
        self.powers(z, |i, [c, s]| {
            let Wave { cosine, sine } = self.waves[i];
            let [place, speed] = [0, 1].map(|n| cosine[n] * c + sine[n] * s);
            let [bent, bent_speed] = [place, speed].map(|x| -self.squares[i] * x);
            for (sum, own) in u.iter_mut().zip([place, speed, bent, bent_speed, -self.squares[i] * bent]) {
                *sum += own;
            }
        });
        Kinematics(u)
    }

    /// ü.
    fn acceleration(&self, z: [f64; 2]) -> f64 {
        let mut sum = 0.0;
        self.powers(z, |i, [c, s]| {
            let Wave { cosine, sine } = self.waves[i];
            sum -= self.squares[i] * (cosine[0] * c + sine[0] * s);
        });
        sum
    }

    fn guard(&self, mode: Mode) -> &Guard {
        if mode == Mode::Free { &self.flight } else { &self.bound }
    }
}

impl Guard {
    fn new(oscillator: &Oscillator, (rates, w): (&[f64], f64), harmonics: [[f64; 2]; MOST_HARMONICS]) -> Self {
        let own = oscillator.rates().1;
        let fastest = rates.iter().fold(own, |fastest, rate| fastest.max(rate.abs()));
        let leap = REACH / fastest;
        let [s, c] = sin_cos(w * leap);
        let map = oscillator.free(Double::from(leap));
        let mut guard = Guard { leap, harmonics, turn: [c, s], map, ..Guard::default() };
        let remainders = |rate: f64| {
            [FEW, SOME, TERMS].map(|terms| (1..=terms).map(|n| rate.abs() * leap / n as f64).product::<f64>())
        };
        for (i, &rate) in rates.iter().enumerate() {
            let amplitude = length(harmonics[i]);
            guard.size += amplitude;
            for (sum, own) in guard.remainders.iter_mut().zip(remainders(rate)) {
                *sum += amplitude * own;
            }
            let mut term = 1.0;
            for n in 0..TERMS {
                guard.series[i][n / 2].0[n % 2] = term;
                // The signs of cos, sin, −cos, −sin: value and slope alternate.
                term *= rate * leap / (n + 1) as f64 * if n % 2 == 0 { 1.0 } else { -1.0 };
            }
        }
        let (damping, stiffness) = (2.0 * oscillator.damping() * leap, oscillator.stiffness() * leap * leap);
        for (free, start) in guard.free.iter_mut().zip([[1.0, 0.0], [0.0, leap]]) {
            let mut c = [0.0; TERMS];
            [c[0], c[1]] = start;
            for n in 0..TERMS - 2 {
                let next = (n + 1) as f64;
                c[n + 2] = -(damping * next * c[n + 1] + stiffness * c[n]) / (next * (next + 1.0));
            }
            for n in 0..TERMS {
                free[n / 2].0[n % 2] = c[n];
            }
        }
        guard.free_remainders = remainders(own);
        guard
    }

    /// The first N = 2 P Taylor coefficients, per leap, of `factor` times the harmonics and of a free vibration with
    /// this value and slope.
    #[inline(always)]
    pub(super) fn series<const P: usize, const N: usize>(
        &self,
        waves: &Waves,
        factor: f64,
        z: [f64; 2],
        [value, slope]: [f64; 2],
    ) -> [f64; N] {
        let mut sum: [[f64; 2]; P] =
            std::array::from_fn(|j| [0, 1].map(|i| value * self.free[0][j].0[i] + slope * self.free[1][j].0[i]));
        waves.powers(z, |i, [c, s]| {
            let [a, b] = self.harmonics[i].map(|amplitude| factor * amplitude);
            let start = [a * c + b * s, b * c - a * s];
            for (sum, Pair(term)) in sum.iter_mut().zip(&self.series[i]) {
                *sum = [sum[0] + start[0] * term[0], sum[1] + start[1] * term[1]];
            }
        });
        std::array::from_fn(|n| sum[n / 2][n % 2])
    }
}

impl Panel {
    /// Makes this panel, which holds its start alone, one with the closed form, up to its first event; false where the
    /// closed form does not serve.
    pub(super) fn lay_in_waves(
        &mut self,
        bodies: &Bodies,
        flank: &impl FlankMotion,
        zeros: usize,
        longest: f64,
        rules: Rules,
    ) -> bool {
        let Some(waves) = &bodies.waves else { return false };
        // The gap of the closed form is rounded as u is, that of the power series as the gap is. A plastic impact forgets what
        // the gap has erred by; a rebound passes it on.
        let passed_on = self.mode == Mode::Free && bodies.e > 0.0;
        if longest < f64::INFINITY || passed_on {
            return false;
        }
        let guard = waves.guard(self.mode);
        if stiff_rate(self.oscillator(bodies), waves.fastest()).is_some() {
            return false;
        }
        self.turn = flank.turn(self.start);
        let [u, u_dot, q, q_dot] = waves.driven(self.turn);
        if self.mode == Mode::Free {
            self.vibration = self.state.q;
            let State { q, home, zeta } = self.state;
            self.centre = [u + home + zeta[0] + bodies.share * q[0], u_dot + zeta[1] + bodies.share * q[1]];
        } else {
            self.vibration = [self.state.q[0] - q, self.state.q[1] - q_dot];
        }
        let end = MOST_LEAPS as f64 * guard.leap;
        let found = if rules.locked {
            Some(Search { clear: end, event: None })
        } else {
            self.search(bodies, waves, guard, (zeros, bodies.resolution(flank, self.start)), end)
        };
        let Some(Search { clear, event }) = found else { return false };
        (self.in_waves, self.length, self.event) = (true, clear, event);
        (self.span, self.per_span) = (guard.leap, 1.0 / guard.leap);
        true
    }

    /// e^(iφ) and the free vibration q, q̇ `theta` [s] after the start.
    #[inline(always)]
    pub(super) fn phases(&self, bodies: &Bodies, waves: &Waves, theta: f64) -> ([f64; 2], [f64; 2]) {
        let oscillator = self.oscillator(bodies);
        let frequency = oscillator.frequency().unwrap_or_default().hi;
        let [[s, c], own] = sin_cos_of_both([waves.speed * theta, frequency * theta]);
        (product(self.turn, [c, s]), oscillator.free_motion(self.vibration).at(theta, own))
    }

    /// u, u̇, q and q̇ `theta` [s] after the start.
    #[inline(always)]
    pub(super) fn waves_at(&self, bodies: &Bodies, waves: &Waves, theta: f64) -> [f64; 4] {
        self.sums_of_waves(waves, self.phases(bodies, waves, theta))
    }

    /// The same where e^(iφ) and the free vibration are known.
    #[inline(always)]
    fn sums_of_waves(&self, waves: &Waves, (z, free): ([f64; 2], [f64; 2])) -> [f64; 4] {
        if self.mode == Mode::Free {
            let [u, u_dot] = waves.driven(z);
            return [u, u_dot, free[0], free[1]];
        }
        let [u, u_dot, q, q_dot] = waves.driven(z);
        [u, u_dot, q + free[0], q_dot + free[1]]
    }

    /// The motion `theta` [s] after the start, without ü.
    pub(super) fn point_in_waves(&self, bodies: &Bodies, waves: &Waves, theta: f64) -> Point {
        self.point_of_waves(bodies, waves, theta, self.phases(bodies, waves, theta))
    }

    /// The state `theta` [s] after the start, with u, u̇ … u⁗.
    pub(super) fn event_in_waves(&self, bodies: &Bodies, waves: &Waves, theta: f64) -> (State, Kinematics) {
        let phases = self.phases(bodies, waves, theta);
        (self.point_of_waves(bodies, waves, theta, phases).state, waves.kinematics(phases.0))
    }

    #[inline(always)]
    fn point_of_waves(&self, bodies: &Bodies, waves: &Waves, theta: f64, phases: ([f64; 2], [f64; 2])) -> Point {
        let [u, u_dot, q, q_dot] = self.sums_of_waves(waves, phases);
        let mut state = State { q: [q, q_dot], ..self.state };
        if self.mode == Mode::Free {
            let [place, speed] = self.in_flight(bodies, theta, state.q).place;
            // Rounding may put m1 behind a flank that it has not reached.
            state.zeta = [(place - u - state.home).clamp(-state.home, bodies.s - state.home), speed - u_dot];
        }
        Point { state, u: [u, u_dot, 0.0] }
    }

    /// What is read of a flight: x1 is off the centre of mass, which moves uniformly, by −μ q.
    #[inline(always)]
    pub(super) fn in_flight(&self, bodies: &Bodies, theta: f64, q: [f64; 2]) -> Reading {
        let [place, speed] = self.centre;
        Reading { place: [place + theta * speed - bodies.share * q[0], speed - bodies.share * q[1]], q }
    }

    /// What is read on a flank, from e^(iφ) and the free vibration.
    #[inline(always)]
    pub(super) fn on_flank(&self, waves: &Waves, z: [f64; 2], free: [f64; 2]) -> Reading {
        let [u, u_dot, q, q_dot] = waves.driven(z);
        Reading { place: [u + self.state.home, u_dot], q: [q + free[0], q_dot + free[1]] }
    }

    /// ü `theta` [s] after the start.
    pub(super) fn wave_acceleration(&self, bodies: &Bodies, waves: &Waves, theta: f64) -> f64 {
        waves.acceleration(self.phases(bodies, waves, theta).0)
    }

    /// The sizes of what is summed in ζ, ζ̇, q and q̇.
    pub(super) fn wave_sizes(&self, bodies: &Bodies, waves: &Waves, theta: f64) -> [f64; 4] {
        let oscillator = self.oscillator(bodies);
        let rate = oscillator.rates().1;
        // The phase is rounded in proportion to its own size.
        let free = oscillator.free_motion(self.vibration).amplitude() * (1.0 + 0.5 * rate * theta);
        let [u, u_dot, q, q_dot] = waves.sizes;
        if self.mode == Mode::Free {
            let share = bodies.share * free;
            return [u + share, u_dot + rate * share, free, rate * free];
        }
        [0.0, 0.0, q + free, q_dot + rate * free]
    }
}

/// The product of two complex numbers.
#[inline(always)]
pub(super) fn product([a, b]: [f64; 2], [c, d]: [f64; 2]) -> [f64; 2] {
    [a * c - b * d, a * d + b * c]
}

/// zⁿ for n ≥ 1.
#[inline(always)]
fn raised(z: [f64; 2], n: usize) -> [f64; 2] {
    match n {
        1 => z,
        2 => product(z, z),
        _ => (1..n).fold(z, |power, _| product(power, z)),
    }
}

fn length([a, b]: [f64; 2]) -> f64 {
    (a * a + b * b).sqrt()
}
