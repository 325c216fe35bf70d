//! The motions of a law between its stops, and their characteristic values.
//!
//! A motion leads over the angle β through the lift h, from one zero of U′ to the next. With f(z) = (U − U₀)/h, z = (φ − φ₀)/β:
//! C_v = max f′, C_a₊ = max f″, C_a₋ = min f″, C_j = max |f‴|, C_M₊ = max f′ f″, C_M₋ = min f′ f″ (VDI 2143), so the largest
//! velocity is C_v h Ω/β. They are maxima of the analytic pieces of the law, including the ends, at which f″ and f‴ may jump.

use crate::report::unit::{DEG, ONE, Unit};
use crate::report::{Table, terminal};
use crate::search::{greatest, root, segments};
use crate::text::in_a_turn;
use camdrive::motion::MotionLaw;
use camdrive::numerics::angle::reduce;
use serde::Serialize;
use std::f64::consts::TAU;

/// Samples of a turn, between which stops are searched.
const SAMPLES: f64 = 8192.0;

/// The part of max |U′| below which a follower stands.
const STANDING: f64 = 1e-12;

/// The part of the largest lift below which a motion of a series or a table is a ripple of its rest: HS profiles keep theirs
/// closer, and the spline through 24 points or more swings less next to a rest, as does the noise of a useful table.
const RIPPLE: f64 = 0.01;

/// An angle (rad) of a turn, with roundings of zero removed.
fn rounded(phi: f64) -> f64 {
    if phi.abs() < TAU * f64::EPSILON { 0.0 } else { phi }
}

/// A motion between two stops.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Motion {
    /// The section of its law, `cam`, `follower[1].cam` or `follower[1].tool`.
    pub law: String,
    /// Its start (rad).
    pub from: f64,
    /// Its angle β (rad).
    pub angle: f64,
    /// h.
    pub lift: f64,
    /// The unit of h.
    pub unit: &'static str,
    /// C_v.
    pub velocity: f64,
    /// C_a₊ and C_a₋.
    pub acceleration: [f64; 2],
    /// C_j.
    pub jerk: f64,
    /// C_M₊ and C_M₋.
    pub torque: [f64; 2],
}

impl Motion {
    /// Meaning of the columns of [`Motion::table`].
    pub const SYMBOLS: &str = "From stop to stop, through the lift h over the angle β: the largest velocity is C_v h Ω/β, the \
        accelerations reach from C_a- h (Ω/β)² to C_a+ h (Ω/β)², the largest jerk is C_j h (Ω/β)³, the torques of inertia reach from \
        C_M- m h² Ω²/β³ to C_M+ m h² Ω²/β³. Ripples of rests, below 1 % of the largest lift of a series or a table, are left out.";

    /// A line for each of the motions.
    pub fn table<'a>(motions: impl IntoIterator<Item = &'a Motion>) -> Table {
        let values: [(_, _, fn(&Motion) -> f64); 6] = [
            ("C_v", "C_v", |motion| motion.velocity),
            ("C_a_largest", "C_a+", |motion| motion.acceleration[0]),
            ("C_a_least", "C_a-", |motion| motion.acceleration[1]),
            ("C_j", "C_j", |motion| motion.jerk),
            ("C_M_largest", "C_M+", |motion| motion.torque[0]),
            ("C_M_least", "C_M-", |motion| motion.torque[1]),
        ];
        let rows = Table::of("Motions", motions)
            .column("law", "law", ONE, |motion| &motion.law)
            .column("from", "from", DEG, |motion| in_a_turn(rounded(motion.from)))
            .digits(4)
            .column("to", "to", DEG, |motion| in_a_turn(rounded(motion.from + motion.angle)))
            .digits(4)
            .column("h", "h", ONE, |motion| shown(motion.lift, motion.unit));
        values.into_iter().fold(rows, |rows, (key, heading, of)| rows.column(key, heading, ONE, of)).into()
    }
}

/// The motions of the law in a turn, in the order of their angles, without the ripples of rests; empty if it never stops.
pub fn motions(section: &str, law: &MotionLaw, unit: &'static str) -> Vec<Motion> {
    let standing = STANDING * law.bound(1);
    let slope = |phi: f64| law.at(phi.rem_euclid(TAU)).0[1];
    let (plan, pieces) = (matches!(law, MotionLaw::Plan(_) | MotionLaw::Cycle(_)), segments(law.breakpoints()));
    // The intervals in which U rises, falls or rests, ascending. Flat parts within a moving segment do not count.
    let mut places: Vec<([f64; 2], f64)> = Vec::new();
    for (segment, ends) in pieces.iter().enumerate() {
        let [start, end] = *ends;
        // A point at which the follower stands is a stop of a plan, even if U′ keeps its sign.
        if plan && slope(start).abs() <= standing {
            places.push(([start; 2], 0.0));
        }
        if law.bound_in(segment, 1) <= standing {
            places.push((*ends, 0.0));
            continue;
        }
        let parts = ((end - start) * SAMPLES / TAU).ceil();
        let middles = (0..parts as usize).map(|i| start + (end - start) * (i as f64 + 0.5) / parts);
        let moving = middles.map(|phi| ([phi; 2], slope(phi))).filter(|(_, slope)| slope.abs() > standing);
        places.extend(moving.map(|(phi, slope)| (phi, slope.signum())));
    }
    let count = places.len();
    let around = |i: usize| {
        let (ends, sign) = places[i % count];
        (ends.map(|phi| phi + TAU * ((i / count) as f64 - 1.0)), sign)
    };
    let Some(first) = (count..2 * count).find(|i| around(*i).1 != around(i - 1).1) else { return Vec::new() };
    let (mut ends, mut start) = (Vec::new(), first);
    for i in first + 1..=first + count {
        let sign = around(start).1;
        if around(i).1 != sign {
            if sign != 0.0 {
                ends.push([start, i].map(|i| stop(around(i - 1), around(i), slope)));
            }
            start = i;
        }
    }
    let lift = |[from, to]: [f64; 2]| law.at(to.rem_euclid(TAU)).0[0] - law.at(from.rem_euclid(TAU)).0[0];
    let ripple = match law {
        MotionLaw::Cycle(_) | MotionLaw::Plan(_) => 0.0,
        _ => RIPPLE * ends.iter().fold(0.0, |most: f64, ends| most.max(lift(*ends).abs())),
    };
    ends.retain(|ends| lift(*ends).abs() > ripple);
    ends.into_iter().map(|ends| motion(section, unit, law, ends, lift(ends))).collect()
}

/// The zero of U′ between two places, at the end of a rest or between two motions of different sense.
fn stop(before: ([f64; 2], f64), behind: ([f64; 2], f64), slope: impl Fn(f64) -> f64) -> f64 {
    match (before, behind) {
        (([_, end], 0.0), _) => end,
        (_, ([start, _], 0.0)) => start,
        (([_, before], _), ([behind, _], _)) => root(slope, [before, behind]),
    }
}

fn motion(section: &str, unit: &'static str, law: &MotionLaw, ends: [f64; 2], lift: f64) -> Motion {
    let [from, to] = ends;
    let angle = to - from;
    let turns = [0.0, TAU].map(|turn| law.breakpoints().iter().map(move |phi| phi + turn));
    let inner = turns.into_iter().flatten().filter(|phi| from < *phi && *phi < to);
    let ends: Vec<f64> = [from].into_iter().chain(inner).chain([to]).collect();
    let pieces: Vec<[f64; 2]> = ends.windows(2).map(|ends| [ends[0], ends[1]]).collect();
    let peak = |value: &dyn Fn([f64; 5]) -> f64| {
        let at = |i: usize, phi: f64| {
            let middle = 0.5 * (pieces[i][0] + pieces[i][1]);
            let turn = TAU * (middle / TAU).floor();
            value(law.at_in(law.segment(middle - turn, true), phi - turn).0)
        };
        greatest(&pieces, at).value
    };
    let both = |value: &dyn Fn([f64; 5]) -> f64| [peak(value), -peak(&|u| -value(u))];
    let [z, h] = [angle, lift];
    Motion {
        law: section.to_owned(),
        unit,
        from,
        angle,
        lift,
        velocity: peak(&|u| u[1] / h) * z,
        acceleration: both(&|u| u[2] / h).map(|a| a * z.powi(2)),
        jerk: peak(&|u| (u[3] / h).abs()) * z.powi(3),
        torque: both(&|u| u[1] / h * (u[2] / h)).map(|m| m * z.powi(3)),
    }
}

/// The greatest value over the turn of a function of U … U⁗.
pub fn greatest_of(law: &MotionLaw, value: impl Fn([f64; 5]) -> f64) -> f64 {
    let at = |segment: usize, phi: f64| value(law.at_in(segment, reduce(phi.into())).0);
    greatest(&segments(law.breakpoints()), at).value
}

/// The greatest less the least value of a position.
pub fn stroke(law: &MotionLaw, position: impl Fn([f64; 5]) -> f64) -> f64 {
    greatest_of(law, &position) + greatest_of(law, |u| -position(u))
}

/// The value in the unit in which people read the quantity.
pub(crate) fn shown(value: f64, unit: &str) -> String {
    terminal::shown(value, &Unit::of(unit))
}
