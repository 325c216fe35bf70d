//! Vibration over a turn: the swing of a tool while its law rests, and the harmonics of the deformation.

use super::{POINTS, Range, Turn, part};
use crate::harmonic_analysis::discrete_series;
use crate::law_motions::motions;
use crate::report::{Unit, terminal::shown};
use crate::resource::Scene;
use crate::text;
use camdrive::motion::MotionLaw;
use serde::Serialize;
use std::f64::consts::TAU;

/// A dwell narrower than this (rad) is a passage between two motions.
const NARROW: f64 = TAU / 360.0;

/// The highest harmonic; machines run above a 48th of their natural frequency.
const HARMONICS: usize = 48;

/// A harmonic below this part of the strongest is ignored.
const OF_NO_ACCOUNT: f64 = 1e-3;

/// The most harmonics of an output.
const MOST: usize = 5;

/// A tool in a dwell of its law.
#[derive(Clone, Debug, Serialize)]
pub struct Dwell {
    /// The output, `y` or `follower[2].y`.
    pub output: String,
    /// Its unit.
    pub unit: &'static str,
    /// Begin of the dwell (rad).
    pub from: f64,
    /// Its end (rad), beyond a turn if the dwell goes on in the next.
    pub to: f64,
    /// The largest departure of the tool from its mean over the dwell.
    pub largest: f64,
    /// Its root mean square.
    pub rms: f64,
    /// The largest departure of the law from its own mean.
    pub law: f64,
    /// The largest size of the output.
    #[serde(skip)]
    pub size: f64,
}

impl Dwell {
    /// A departure without roundings.
    pub fn clean(&self, value: f64) -> f64 {
        text::clean(value, self.size)
    }

    /// A departure for people.
    pub fn shown(&self, value: f64) -> String {
        shown(self.clean(value), &Unit::of(self.unit))
    }
}

/// A harmonic of a deformation.
#[derive(Clone, Debug, Serialize)]
pub struct Harmonic {
    /// The output, `q` or `follower[2].q`.
    pub output: String,
    /// Its unit.
    pub unit: &'static str,
    /// k.
    pub harmonic: usize,
    /// k Ω (rad/s).
    pub frequency: f64,
    /// The amplitude of cos(kφ − ψ).
    pub amplitude: f64,
    /// The speed (rad/s) at which it meets the natural frequency; None where that is not known.
    #[serde(skip)]
    pub resonance: Option<f64>,
}

/// The dwells of the law with the angles (rad) of their ends, in the order of the turn.
fn rests(law: &MotionLaw) -> Vec<[f64; 2]> {
    let motions = motions("", law, "m");
    let next = |i: usize| motions[(i + 1) % motions.len()].from + if i + 1 == motions.len() { TAU } else { 0.0 };
    let rest = |i: usize| [motions[i].from + motions[i].angle, next(i)];
    (0..motions.len()).map(rest).filter(|[from, to]| to - from > NARROW).collect()
}

impl Turn {
    /// The tools of a scene in the dwells of their laws.
    pub fn dwells(&self, scene: &Scene) -> Vec<Dwell> {
        let mut dwells = Vec::new();
        for range in self.outputs.iter().filter(|range| range.part().0 == "y") {
            let j = range.part().1;
            // A rigid tool follows its law.
            let is_loose = |other: &&Range| other.part().1 == j && matches!(other.part().0, "q" | "gap");
            if self.outputs.iter().find(is_loose).is_none() {
                continue;
            }
            let follower = scene.follower(j.saturating_sub(1));
            let Some(law) = scene.cam().or(follower.map(|follower| &follower.cam)) else { continue };
            let tool = |u: f64| follower.map_or(u, |follower| follower.tool([u, 0.0, 0.0])[0]);
            for [from, to] in rests(law) {
                dwells.extend(self.dwell(range, [from, to], |phi| tool(law.at(phi.rem_euclid(TAU)).0[0])));
            }
        }
        dwells
    }

    /// The output between two angles with the law `law`; None without three points there.
    fn dwell(&self, range: &Range, [from, to]: [f64; 2], law: impl Fn(f64) -> f64) -> Option<Dwell> {
        let inside = |k: &usize| (self.angles[*k].rem_euclid(TAU) - from).rem_euclid(TAU) <= to - from;
        let mut of_law = Vec::new();
        let mut of_tool = Vec::new();
        for k in (0..self.angles.len() - 1).filter(inside) {
            of_tool.push(range.values[k]);
            of_law.push(law(self.angles[k]));
        }
        if of_tool.len() < 3 {
            return None;
        }
        let count = of_tool.len() as f64;
        let departures = |values: &[f64]| -> Vec<f64> {
            let mean = values.iter().sum::<f64>() / count;
            values.iter().map(|value| (value - mean).abs()).collect()
        };
        let (tool, law) = (departures(&of_tool), departures(&of_law));
        let largest = |values: &[f64]| values.iter().copied().fold(0.0, f64::max);
        let rms = (tool.iter().map(|v| v * v).sum::<f64>() / count).sqrt();
        let (output, unit) = (range.output.clone(), range.unit);
        Some(Dwell { output, unit, from, to, largest: largest(&tool), rms, law: largest(&law), size: range.size })
    }

    /// The harmonics of an output, in the order of their numbers.
    pub fn series(&self, range: &Range) -> Vec<Harmonic> {
        let step = self.period / POINTS as f64;
        // Only the points of equal times.
        let is_regular = |k: &usize| {
            let place = self.times[*k] / step;
            (place - place.round()).abs() < 1e-12 * POINTS as f64 && place.round() < POINTS as f64
        };
        let values: Vec<f64> = (0..self.times.len()).filter(is_regular).map(|k| range.values[k]).collect();
        let series = discrete_series(0.0, &values, HARMONICS);
        let harmonic = |k: usize| Harmonic {
            output: range.output.clone(),
            unit: range.unit,
            harmonic: k,
            frequency: k as f64 * self.mean_speed.abs(),
            amplitude: series.a[k].hypot(series.b[k]),
            resonance: None,
        };
        (1..=HARMONICS).map(harmonic).collect()
    }

    /// The strongest harmonic of an output with a frequency (rad/s) between these.
    pub fn strongest(&self, range: &Range, [low, high]: [f64; 2]) -> Option<Harmonic> {
        let near = self.series(range).into_iter().filter(|of| (low..=high).contains(&of.frequency));
        near.max_by(|a, b| a.amplitude.total_cmp(&b.amplitude))
    }

    /// The strongest harmonics of each deformation and those that are `named` by follower and number, in the order of their numbers.
    pub fn harmonics(&self, named: &[(usize, usize)]) -> Vec<Harmonic> {
        let mut all = Vec::new();
        for range in self.outputs.iter().filter(|range| part(&range.output).0 == "q") {
            let mut own = self.series(range);
            own.sort_by(|a, b| b.amplitude.total_cmp(&a.amplitude));
            let least = OF_NO_ACCOUNT * own[0].amplitude;
            let mut others = own.split_off(MOST.min(own.len()));
            own.retain(|of| of.amplitude > least);
            others.retain(|of| named.contains(&(part(&of.output).1, of.harmonic)));
            own.append(&mut others);
            own.sort_unstable_by_key(|of| of.harmonic);
            all.append(&mut own);
        }
        all
    }
}
