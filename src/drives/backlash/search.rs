//! The search for the first switching instant of a motion in closed form ([`super::waves`]).
//!
//! It goes on in leaps of two radians of the fastest wave of F_K on a flank or of the gap in flight: a Taylor polynomial
//! about the place reached and a bound of its remainder, R xᴺ with R = Σ |A| (ν h)ᴺ/N!, lie below the function, and up to
//! the first zero of that polynomial there is no event ([`first_zero`]). About that zero four terms do, so that the
//! next polynomial ends on the event. No event can be jumped over.

use super::contact::{Bodies, Flank, Mode};
use super::panel::{Found, Panel};
use super::waves::{FEW, Guard, SOME, TERMS, Waves, product};
use crate::numerics::first_zero::{Precision, first_zero, first_zero_of, partial_sums};
use crate::numerics::forced::apply;

/// The remainder, relative to the amplitudes, that is below the rounding of the function.
const NEGLIGIBLE: f64 = 1e-17;

/// A panel shorter than this part of a leap is left to the power series: its gap keeps all digits while it is small,
/// that of the closed form is rounded as u is.
const SHORTEST: f64 = 0.5;

/// A gap that has to be above this part of the amplitudes, after the first leap, for its sign to be beyond doubt.
const CLEAR: f64 = 1e-13;

/// Searches until a panel ends where it has come to: leaps and events, and near misses, each of which halves what is left.
const MOST_SEARCHES: usize = 40;

/// Where a search has come to.
pub(super) struct Search {
    /// How far there is no event [s].
    pub(super) clear: f64,
    pub(super) event: Option<(Found, f64)>,
}

/// A place of the search.
struct Place {
    /// After the start of the panel [s].
    at: f64,
    /// e^(iφ).
    z: [f64; 2],
    /// The free vibration q, q̇.
    free: [f64; 2],
    /// Whether they have come from leap to leap, with the roundings of each.
    passed_on: bool,
}

/// What the function searched is compared with.
struct Limits {
    /// The sum of its amplitudes.
    size: f64,
    /// R after few, some and all terms.
    remainders: [f64; 3],
    /// The force that counts as zero [N].
    resolution: f64,
    /// The order of the zero with which the gap begins.
    zeros: usize,
}

impl Limits {
    /// Whether the polynomial of a look, of a near one or of one over a leap, is the function itself up to `x`.
    fn settles(&self, near: bool, x: f64) -> bool {
        let square = x * x;
        let fourth = square * square;
        let [few, _, all] = self.remainders;
        let remainder = if near { few * fourth } else { all * fourth * fourth * fourth };
        remainder <= NEGLIGIBLE * self.size
    }
}

/// The powers in [`Limits::settles`].
const _: () = assert!(FEW == 4 && TERMS == 12);

impl Panel {
    /// The first event within `end` [s], or how far there is none; None where the power series has to look.
    pub(super) fn search(
        &self,
        bodies: &Bodies,
        waves: &Waves,
        guard: &Guard,
        (zeros, resolution): (usize, f64),
        end: f64,
    ) -> Option<Search> {
        let amplitude = self.oscillator(bodies).free_motion(self.vibration).amplitude();
        let free_size = match self.mode {
            Mode::Contact(_) => (bodies.c + bodies.b * bodies.bound.stiffness().sqrt()) * amplitude,
            Mode::Free => bodies.share * amplitude,
        };
        let limits = Limits {
            size: guard.size + free_size,
            remainders: [0, 1, 2].map(|i| guard.remainders[i] + free_size * guard.free_remainders[i]),
            resolution,
            zeros,
        };
        let leap = guard.leap;
        let arrive = |at: f64| {
            let (z, free) = self.phases(bodies, waves, at);
            Place { at, z, free, passed_on: false }
        };
        let mut place = Place { at: 0.0, z: self.turn, free: self.vibration, passed_on: false };
        let mut near = false;
        for _ in 0..MOST_SEARCHES {
            let next = if !near && self.is_clear(bodies, waves, guard, &limits, &place) {
                None
            } else if near {
                self.look::<2, FEW, { FEW + 1 }>(bodies, waves, guard, &limits, &place)?
            } else {
                self.look::<{ TERMS / 2 }, TERMS, { TERMS + 1 }>(bodies, waves, guard, &limits, &place)?
            };
            let Some((found, x)) = next else {
                // Four terms tell nothing of a whole leap.
                if near {
                    near = false;
                    continue;
                }
                place.at += leap;
                if place.at >= end {
                    return Some(Search { clear: place.at, event: None });
                }
                (place.z, place.free) = (product(place.z, guard.turn), apply(&guard.map, place.free));
                place.passed_on = true;
                continue;
            };
            let here = place.at + x * leap;
            if here < SHORTEST * leap {
                return None;
            }
            if limits.settles(near, x) && !place.passed_on {
                return Some(Search { clear: here, event: Some((found, here)) });
            }
            // A look that does not end the search with four terms is taken again with all.
            near = !near;
            place = arrive(here);
        }
        (place.at >= SHORTEST * leap).then_some(Search { clear: place.at, event: None })
    }

    /// The first event within a leap from `place`, in leaps, and where F_K vanishes; N = 2 P terms, M = N + 1. The outer None
    /// where the power series has to look.
    #[inline(always)]
    fn look<const P: usize, const N: usize, const M: usize>(
        &self,
        bodies: &Bodies,
        waves: &Waves,
        guard: &Guard,
        limits: &Limits,
        place: &Place,
    ) -> Option<Option<(Found, f64)>> {
        // Another look follows at a place that leaps have led to.
        let precision = if place.passed_on { Precision::Near } else { Precision::Full };
        let remainder = limits.remainders[if N == FEW { 0 } else { 2 }];
        let series = self.function::<P, N>(bodies, waves, guard, limits, place);
        match self.mode {
            Mode::Contact(_) => {
                let mut force = [0.0; M];
                force[..N].copy_from_slice(&series);
                force[N] = -remainder;
                if partial_sums(&force)[0] > 0.0 {
                    return Some(None);
                }
                Some(first_zero_of(&force, 1.0, precision).map(|x| {
                    let last = !place.passed_on && limits.settles(N == FEW, x);
                    (Found::Release, if last { polished(&force[..N], limits.resolution, x) } else { x })
                }))
            }
            Mode::Free => self.first_impact::<N, M>(
                bodies,
                &series,
                (limits.zeros, place.at == 0.0),
                (remainder, CLEAR * limits.size, guard.leap),
                precision,
            ),
        }
    }

    /// Whether some terms already tell that there is no event within a leap from `place`.
    #[inline(always)]
    fn is_clear(&self, bodies: &Bodies, waves: &Waves, guard: &Guard, limits: &Limits, place: &Place) -> bool {
        let remainder = limits.remainders[1];
        // A flight begins on a flank.
        if self.mode == Mode::Free && place.at == 0.0 {
            return false;
        }
        let [least, greatest] = partial_sums(&self.function::<{ SOME / 2 }, SOME>(bodies, waves, guard, limits, place));
        if self.mode == Mode::Free {
            (least - remainder).min(bodies.s - greatest - remainder) > CLEAR * limits.size
        } else {
            least > remainder
        }
    }

    /// The function searched over the leap from `place`, as N = 2 P Taylor coefficients: on a flank σF_K and the force that
    /// counts as zero, in flight the distance from flank A.
    #[inline(always)]
    fn function<const P: usize, const N: usize>(
        &self,
        bodies: &Bodies,
        waves: &Waves,
        guard: &Guard,
        limits: &Limits,
        place: &Place,
    ) -> [f64; N] {
        let [q, v] = place.free;
        match self.mode {
            Mode::Contact(contact) => {
                let sign = contact.sign();
                let acceleration = -(2.0 * bodies.bound.damping() * v + bodies.bound.stiffness() * q);
                let start = [-sign * bodies.link(q, v), -sign * bodies.link(v, acceleration)];
                let mut force = guard.series::<P, N>(waves, sign, place.z, start);
                force[0] += limits.resolution;
                force
            }
            Mode::Free => {
                let share = -bodies.share;
                let mut gap = guard.series::<P, N>(waves, 1.0, place.z, [share * q, share * v]);
                gap[0] += self.centre[0] + place.at * self.centre[1] - waves.mean;
                gap[1] += self.centre[1] * guard.leap;
                gap
            }
        }
    }

    /// The first impact on either flank within a leap, from the series of the distance from flank A.
    #[inline(always)]
    fn first_impact<const N: usize, const M: usize>(
        &self,
        bodies: &Bodies,
        gap: &[f64; N],
        (zeros, first): (usize, bool),
        (remainder, clear, leap): (f64, f64, f64),
        precision: Precision,
    ) -> Option<Option<(Found, f64)>> {
        let [least, greatest] = partial_sums(gap);
        let rooms = [least - remainder, bodies.s - greatest - remainder];
        // The nearer flank first: an impact there shortens the search for the other.
        let order = if rooms[0] < rooms[1] { [Flank::A, Flank::B] } else { [Flank::B, Flank::A] };
        let (mut end, mut found) = (1.0, None);
        for flank in order {
            let room = if flank == Flank::A { rooms[0] } else { rooms[1] };
            let leaving = first && self.state.home == bodies.place(flank);
            if room > clear && !leaving {
                continue;
            }
            let sign = flank.sign();
            let mut c = [0.0; M];
            for n in 0..N {
                c[n] = sign * gap[n];
            }
            c[0] -= sign * bodies.place(flank);
            c[N] = -remainder;
            let zero = if leaving {
                // The state knows the beginning of the gap better.
                (c[0], c[1]) = (sign * self.state.zeta[0], sign * self.state.zeta[1] * leap);
                c[..zeros].fill(0.0);
                first_zero(&c, end)
            } else if first && !(c[0] > clear) {
                return None;
            } else {
                first_zero_of(&c, end, precision)
            };
            if let Some(x) = zero {
                (end, found) = (x, Some((Found::Impact(flank), x)));
            }
        }
        Some(found)
    }
}

/// Where F_K vanishes, just before `x` where it has fallen to the resolution below zero; `force` has that resolution added.
fn polished(force: &[f64], resolution: f64, x: f64) -> f64 {
    let mut zero = x;
    for _ in 0..3 {
        let (mut value, mut slope) = (0.0, 0.0);
        for &c in force.iter().rev() {
            slope = slope * zero + value;
            value = value * zero + c;
        }
        let next = zero - (value - resolution) / slope;
        // A force that only just reaches zero keeps the instant at which it is seen to pull.
        if !(slope < 0.0 && (next - x).abs() <= 1e-4) {
            return x;
        }
        zero = next;
    }
    zero.min(x)
}
