//! The compensated cams as laws of a scene: a Fourier series in φ, or a table if the series would be too long.
//!
//! Near the bound of feasibility the machine almost comes to rest while the tools are fastest. The law then changes over a
//! small part of the turn only, and its series needs more harmonics than a scene may have; a table has its points closer there.
//!
//! The error of a law is the error of the tool's acceleration on the wanted motion, max|ÿ − ÿ_wanted|/max|ÿ_wanted| with ÿ =
//! f(U(φ))¨, U̇ = U′ω, Ü = U″ω² + U′ω̇ against y = f(U(ψ)): both sides in closed form, the maximum found between the places of
//! comparison.

use super::corners::{Instant, WantedTurn, divided};
use super::spectral::{Mesh, amplitude, largest, largest_between};
use super::{Angle, Solution, Tool};
use crate::harmonic_analysis::without_rounding;
use camdrive::drives::Fault;
use camdrive::motion::fourier::HIGHEST_HARMONIC;
use camdrive::motion::table::{MOST_POINTS, Points};
use camdrive::motion::{Fourier, MotionLaw, Table};
use std::f64::consts::TAU;

/// Harmonics below this part of the largest lift are roundings of the phases of the lift.
const ROUNDING: f64 = 2e-16;

/// Places for the shortest wave, and within a piece of a table, at which errors are measured: enough to identify the largest
/// maximum, which is then refined.
const PLACES: usize = 12;

/// Least order of the waves in the search for the remainder of a series. The waves reach about twice the order of the series,
/// because harmonics fall geometrically, and this order for a short one.
const SHORTEST: usize = 32;

/// The points of the first table for the shortest wave of the tool.
const FIRST_POINTS: usize = 4;

/// The widest piece of the first table if laws have corners (rad).
const WIDEST: f64 = TAU / 64.0;

/// The most tables: each divides the pieces that miss the tolerance, as their order of four demands.
const TABLES: usize = 12;

/// Tables in a row without progress: the first ones do not resolve the place at which the machine almost comes to rest.
const STALE: usize = 3;

/// The most parts of a piece in one of these rounds: beyond it the order is no guide.
const MOST_PARTS: f64 = 8.0;

/// Form of the laws.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Form {
    /// A series if it is short enough, else a table.
    #[default]
    Auto,
    /// Fourier series in φ.
    Series,
    /// Points of a periodic spline of degree 5.
    Table,
}

/// The law of a compensated cam.
#[derive(Clone, Debug, PartialEq)]
pub struct Law {
    /// U_cam(φ) (m); (rad) for a lever or a tool that turns.
    pub law: MotionLaw,
    /// The largest error of the tool's acceleration that it causes on the wanted motion, relative to the largest acceleration.
    pub truncation: f64,
}

/// |ÿ − ÿ_wanted| (m/s² or rad/s²) with this law of the cam, Ω (rad/s) the motion's.
pub fn miss(tool: &Tool, law: &MotionLaw, mean_speed: f64, at: Instant) -> f64 {
    let [u, u1, u2, ..] = law.at(at.angle).0;
    let got = tool.moved([u, u1 * at.speed, u2 * at.speed * at.speed + u1 * at.change])[2];
    (got - mean_speed * mean_speed * tool.at(at.phase)[2]).abs()
}

/// The places at which a law is measured, in the phase ψ of the design: [`PLACES`] for each shortest wave of its error, or for
/// each piece. `angle` leads to φ, `fastest` is the largest φ′(ψ).
pub fn places(law: &MotionLaw, angle: &Angle, fastest: f64) -> Vec<f64> {
    match law {
        MotionLaw::Fourier(series) => {
            let waves = (2 * series.order()).max(SHORTEST) as f64;
            let n = (PLACES as f64 * waves * fastest).ceil() as usize;
            (0..=n).map(|i| TAU * i as f64 / n as f64).collect()
        }
        law => {
            let mut knots: Vec<f64> = law.breakpoints().iter().map(|phi| angle.inverse(*phi)).collect();
            knots.extend(knots.first().map(|first| first + TAU));
            divided(&knots, |_| PLACES)
        }
    }
}

/// Properties of the wanted motion.
struct Wanted<'a> {
    solution: &'a Solution,
    angle: Angle,
    /// The largest φ′(ψ).
    fastest: f64,
    tolerance: f64,
}

impl Wanted<'_> {
    fn instant(&self, psi: f64) -> Instant {
        if let Some(corners) = &self.solution.corners {
            return corners.instant(psi.rem_euclid(TAU), true);
        }
        let [speed, slope, ..] = self.solution.speed.at(psi).0;
        Instant {
            angle: self.angle.at(psi).rem_euclid(TAU),
            speed,
            change: slope * self.solution.mean_speed(),
            phase: psi,
        }
    }

    /// The largest error, refined between the places.
    fn error(&self, tool: &Tool, law: &MotionLaw) -> f64 {
        let omega = self.solution.mean_speed();
        let places = places(law, &self.angle, self.fastest);
        largest_between(&places, |psi| miss(tool, law, omega, self.instant(psi)))[1] / tool.acceleration(omega)[1]
    }

    /// The series with as few harmonics as the tolerance allows; the least error if they are too many.
    fn series(&self, tool: &Tool) -> Result<Law, f64> {
        // At equidistant angles the waves of the series have no error of phase; five points for each wave of the highest
        // harmonic keep the aliases out.
        let mesh = Mesh::new(5 * HIGHEST_HARMONIC / 2);
        let lifts: Vec<f64> = (0..mesh.len()).map(|i| tool.driven(self.angle.inverse(mesh.point(i)))[0]).collect();
        let full = without_rounding(mesh.series(&lifts));
        let floor = ROUNDING * largest(tool.wanted.order(), |psi| tool.driven(psi)[0])[1];
        let last = (1..=HIGHEST_HARMONIC).rev().find(|k| amplitude(&full, *k) > floor).unwrap_or(1);
        let cut = |order: usize| MotionLaw::Fourier(Fourier::new(full.a[..=order].to_vec(), full.b[..=order].to_vec()));
        let longest = cut(last);
        let least = self.error(tool, &longest);
        if least > self.tolerance || least.is_nan() {
            return Err(least);
        }
        // On the same places for all orders; the error falls with the order but for roundings.
        let omega = self.solution.mean_speed();
        let peak = tool.acceleration(omega)[1];
        let instants: Vec<Instant> =
            places(&longest, &self.angle, self.fastest).into_iter().map(|psi| self.instant(psi)).collect();
        let suffices = |order: usize| {
            let law = cut(order);
            instants.iter().all(|at| miss(tool, &law, omega, *at) <= self.tolerance * peak)
        };
        let orders: Vec<usize> = (1..=last).collect();
        let order = orders.partition_point(|order| !suffices(*order)) + 1;
        // Between the places the error may be a little larger.
        let laws = (order..=last).map(|order| {
            let law = cut(order);
            Law { truncation: self.error(tool, &law), law }
        });
        laws.into_iter().find(|law| law.truncation <= self.tolerance).ok_or(least)
    }

    /// The table with points as dense as the tolerance needs; the least error if they are too many.
    fn table(&self, tool: &Tool) -> Result<Law, f64> {
        let corners = self.solution.corners.as_deref();
        let omega = self.solution.mean_speed();
        let peak = tool.acceleration(omega)[1];
        let order = tool.motion.series().map_or(0, Fourier::order).max(tool.wanted.order()).max(4);
        let width = TAU / (FIRST_POINTS * order) as f64;
        let even = || (0..FIRST_POINTS * order).map(|i| width * i as f64).collect();
        let mut knots: Vec<f64> = corners.map_or_else(even, |corners| corners.parts(WIDEST));
        knots.push(TAU);
        let (mut least, mut stale) = (f64::INFINITY, 0);
        for _ in 0..TABLES {
            let open = &knots[..knots.len() - 1];
            let angle = |psi: &f64| corners.map_or_else(|| self.angle.at(*psi), |corners| corners.angle(*psi));
            let points = Points {
                angles: open.iter().map(angle).collect(),
                lifts: open.iter().map(|psi| tool.driven(*psi)[0]).collect(),
            };
            let bent = |corners: &dyn WantedTurn| open.iter().map(|psi| corners.bend(tool, *psi)).collect();
            let table = match corners {
                Some(corners) => Table::bent(points, bent(corners)),
                None => Table::new(points),
            };
            let Ok(table) = table else { break };
            let law = MotionLaw::Table(table);
            let in_piece = |pair: &[f64]| {
                // The first place is a millionth of the piece after its start, where a corner may be.
                let at = |j: usize| pair[0] + (pair[1] - pair[0]) * f64::max(j as f64 / PLACES as f64, 1e-6);
                (0..PLACES).map(|j| miss(tool, &law, omega, self.instant(at(j))) / peak).fold(0.0, f64::max)
            };
            let errors: Vec<f64> = knots.windows(2).map(in_piece).collect();
            let worst = errors.iter().copied().fold(0.0, f64::max);
            // Halved pieces are sixteen times better once they resolve the law: an error that stays over several tables is
            // rounding.
            stale = if worst < 0.7 * least { 0 } else { stale + 1 };
            least = least.min(worst);
            if stale > STALE {
                break;
            }
            if worst <= self.tolerance {
                let truncation = self.error(tool, &law);
                if truncation <= self.tolerance {
                    return Ok(Law { law, truncation });
                }
            }
            // U″ of the spline converges with the fourth power of the distance; half the tolerance leaves room for the errors
            // of neighbouring pieces.
            let parts =
                |i: usize| (errors[i] / (0.5 * self.tolerance)).powf(0.25).ceil().clamp(1.0, MOST_PARTS) as usize;
            knots = divided(&knots, parts);
            knots.push(TAU);
            if knots.len() > MOST_POINTS {
                break;
            }
        }
        Err(least)
    }
}

/// The laws of the cams, each as short as possible with an error of the tool's acceleration below `tolerance`, relative to the
/// largest acceleration.
///
/// # Errors
/// A series demanded for a motion that has none; harmonics or points that do not suffice, in the demanded form or in any.
pub fn of(solution: &Solution, tools: &[Tool], tolerance: f64, form: Form) -> Result<Vec<Law>, Fault> {
    let fastest = solution.range().map(|w| w / solution.mean_speed()).into_iter().fold(1.0, f64::max);
    let wanted = Wanted { solution, angle: solution.angle(), fastest, tolerance };
    let form = match (&solution.corners, form) {
        (Some(_), Form::Series) => {
            let what = "motions that cycles, plans or tables prescribe, and loads and motors that do not change smoothly, leave corners in the laws of all cams, which no series has";
            return Err(Fault::new(format!("{what}; choose --laws table")));
        }
        (Some(_), _) => Form::Table,
        (None, form) => form,
    };
    let series = |tool: &Tool| {
        wanted.series(tool).map_err(|least| {
            format!("a series of up to {HIGHEST_HARMONIC} harmonics has an error of at least {least:.1e}")
        })
    };
    let table = |tool: &Tool| {
        wanted
            .table(tool)
            .map_err(|least| format!("a table of up to {MOST_POINTS} points has an error of at least {least:.1e}"))
    };
    let law = |tool: &Tool| {
        match form {
            Form::Series => series(tool).map_err(|what| (what, "a larger tolerance or J0 helps, or --laws table")),
            Form::Table => table(tool).map_err(|what| (what, "a larger tolerance or J0 helps")),
            Form::Auto => series(tool).or_else(|first| {
                table(tool).map_err(|second| (format!("{first}, {second}"), "a larger tolerance or J0 helps"))
            }),
        }
        .map_err(|(what, help)| {
            Fault::new(format!(
                "tool {}: {what} of the acceleration, more than the tolerance {tolerance:e}; {help}",
                tool.number
            ))
        })
    };
    tools.iter().map(law).collect()
}
