//! Which natural frequencies, speeds, clearances, masses m1 and damping ratios avoid further impacts by the event-driven model.
//!
//! The formulas give them at once ([`super::tuning`]), but assume a quasi-static release and a cubic U. Here the model follows
//! all passages of a turn at values around the scene's, and bisection finds the borders between calm and other values. A range
//! of values narrower than the distance of two samples may be missed.
//!
//! A passage that ends well from permanent contact may not do so with the vibration of earlier ones: the settled motion at a
//! value within each interval shows which [`Change`] makes the drive gentler.

use super::contact_motion::ContactMotion;
use super::law::Crossing;
use super::machine::Machine;
use super::passage::Clearance;
use super::settled::{self, SettledMotion};
use super::tuning::Intervals;
use super::{Parameters, passages};
use crate::clearance::borders::Sequel;
use crate::parallel;
use crate::report::Unit;
use crate::report::unit::{HZ, KG, MM, ONE, RPM};
use crate::text;
use camdrive::drives::backlash::Scene;
use serde::Serialize;

/// Values are searched between the part 1/`REACH` and `REACH` times the scene's value.
const REACH: f64 = 4.0;
/// Damping ratios are searched between these, whatever the scene's is: it may be 0.
const DAMPING: [f64; 2] = [0.0025, 1.0];
/// Quantities.
const COUNT: usize = 5;
/// Samples on either side of the scene's value, at most and at least: every 4 … 15 % of the value.
const SAMPLES: [usize; 2] = [10, 36];
/// Instants of the model that all samples of a law may take together: a second or two of computing.
const MOST_INSTANTS: usize = 10_000_000;
/// Instants of a passage: its flight and twice the natural period after it.
const INSTANTS_OF_A_PASSAGE: usize = 1000;
/// A change stays this far inside its interval: masses, stiffnesses and speeds of built machines scatter by some per cent.
const MARGIN: f64 = 1.05;
/// Relative accuracy of a border: the three digits that reports show.
const BORDER: f64 = 5e-4;
/// Internal steps of an evaluation; a drive that needs more vibrates too often to be followed.
const MOST_STEPS: f64 = 1e5;

/// Admissible values around the scene's, by the model.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ByModel {
    /// Natural frequencies ω (rad/s).
    pub frequency: Intervals,
    /// Speeds |Ω| (rad/s).
    pub speed: Intervals,
    /// Clearances (m).
    pub clearance: Intervals,
    /// Masses m1 (kg).
    pub mass: Intervals,
    /// Damping ratios D = b/(2 m2 ω).
    pub damping: Intervals,
    /// The values between which each was searched.
    pub searched: [[f64; 2]; COUNT],
    /// The ratio of neighbouring samples.
    pub ratio: f64,
    /// The ratio of neighbouring damping ratios.
    pub damping_ratio: f64,
    /// Samples at which the model could not be followed; they count as not admissible.
    pub unknown: usize,
    /// The settled motion at a value within each interval, the gentlest impacts first.
    pub changes: Vec<Change>,
}

/// Another value of one quantity, and the motion that the drive settles to there.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Change {
    /// The quantity.
    pub quantity: &'static str,
    /// Its value (SI).
    pub value: f64,
    /// The motion there.
    pub settled: SettledMotion,
    /// The largest impulse (N·s) after a start at rest on the cam: with little damping a motion remembers its start.
    #[serde(skip)]
    pub from_rest: f64,
}

/// The quantities, in the order of their intervals.
pub const QUANTITIES: [&str; COUNT] = ["natural frequency", "speed", "clearance", "mass m1", "damping ratio"];

/// Their units for people.
pub const UNITS: [Unit; COUNT] = [HZ, RPM, MM, KG, ONE];

/// Significant digits of a change: the model tries the value that the report shows.
pub const DIGITS: usize = 3;

impl ByModel {
    /// The intervals of a quantity, by its place in [`QUANTITIES`].
    pub fn intervals(&self, which: usize) -> &Intervals {
        [&self.frequency, &self.speed, &self.clearance, &self.mass, &self.damping][which]
    }
}

/// True if each passage ends with one impact on the other flank and lasting contact; None if the model has not followed all of
/// the `releases` and none of the followed ones is to the contrary.
pub fn is_calm(passages: &[Clearance], releases: Option<usize>) -> Option<bool> {
    let sequels: Vec<Sequel> = passages.iter().filter_map(|p| Some(p.model?.sequel)).collect();
    if sequels.iter().any(|sequel| *sequel != Sequel::None) {
        return Some(false);
    }
    (releases == Some(sequels.len())).then_some(true)
}

/// The values of a scene with the part `factor` of one of them: ω with the same damping ratio, Ω, s or m1; or with `factor`
/// times the middle one of the damping ratios.
fn changed(scene: &Scene, machine: &Parameters, which: usize, factor: f64) -> (Scene, Parameters) {
    let (mut scene, mut machine) = (scene.clone(), *machine);
    match which {
        0 => {
            (scene.parameters.c, scene.parameters.b, machine.omega) =
                (scene.parameters.c * factor * factor, scene.parameters.b * factor, machine.omega * factor)
        }
        1 => machine.speed *= factor,
        2 => scene.parameters.s *= factor,
        3 => scene.parameters.m1 *= factor,
        _ => scene.parameters.b = 2.0 * middle(DAMPING) * factor * machine.m2 * machine.omega,
    }
    (machine.m1, machine.mu) = (scene.parameters.m1, scene.parameters.m1 / machine.m2);
    (machine.c, machine.b, machine.s) = (scene.parameters.c, scene.parameters.b, scene.parameters.s);
    machine.eta = machine.speed.abs() / machine.omega;
    (scene, machine)
}

/// The geometric mean.
fn middle([low, high]: [f64; 2]) -> f64 {
    (low * high).sqrt()
}

/// The value in an interval next to `own`, with its margin; the middle of an interval that is too narrow or contains `own`.
fn within([low, high]: [f64; 2], own: f64) -> f64 {
    let [inner, outer] = [low * MARGIN, high / MARGIN];
    if inner < outer && !(low..=high).contains(&own) { own.clamp(inner, outer) } else { middle([low, high]) }
}

/// The model of a scene and its motion of permanent contact; None if it cannot be followed.
fn model(scene: &Scene, machine: &Parameters, ignore: f64) -> Option<(Machine, ContactMotion)> {
    let mut model = Machine::new(scene, machine.speed).ok()?;
    model.allow(MOST_STEPS);
    let motion = ContactMotion::new(&mut model, scene, ignore).ok()?;
    Some((model, motion))
}

/// A scene whose values are changed one at a time.
pub struct Variation<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// Its parameters.
    pub machine: &'a Parameters,
    /// Angles at which its contact force changes sign by the formulas.
    pub crossings: &'a [Crossing],
    /// The part of the largest force up to which a change of sign is ignored.
    pub ignore: f64,
}

impl Variation<'_> {
    /// The values around the scene's, whose periodic motion is `motion`, with changes that settle for `turns`; None if that
    /// would take long or the model cannot be followed.
    pub fn around(&self, motion: &ContactMotion, turns: Option<usize>) -> Option<ByModel> {
        // Borders take about as many evaluations again.
        let instants = motion.samples.len() + INSTANTS_OF_A_PASSAGE * motion.releases.len().max(1);
        let count = (MOST_INSTANTS / (2 * COUNT * 2 * instants)).min(SAMPLES[1]);
        if count < SAMPLES[0] {
            return None;
        }
        // If so few steps do not suffice here, they do not nearby.
        self.is_calm(self.scene, self.machine)?;
        let (intervals, unknown) = self.admissible(count);
        let changes = self.changes(&intervals, turns);
        let own = self.own();
        let [frequency, speed, clearance, mass, damping] = intervals;
        Some(ByModel {
            frequency,
            speed,
            clearance,
            mass,
            damping,
            searched: std::array::from_fn(|which| [own[which] / reach(which), own[which] * reach(which)]),
            ratio: ratio(0, count),
            damping_ratio: ratio(COUNT - 1, count),
            unknown,
            changes,
        })
    }

    /// The values that are multiplied: the scene's, and the middle one of the damping ratios.
    fn own(&self) -> [f64; COUNT] {
        let Parameters { omega, speed, s, m1, .. } = *self.machine;
        [omega, speed.abs(), s, m1, middle(DAMPING)]
    }

    /// True if these values are calm; None if the model cannot be followed.
    fn is_calm(&self, scene: &Scene, machine: &Parameters) -> Option<bool> {
        let (mut model, motion) = model(scene, machine, self.ignore)?;
        let passages = passages(scene, machine, self.crossings, Some((&mut model, &motion)));
        is_calm(&passages, Some(motion.releases.len()))
    }

    /// The admissible values of each quantity by `count` samples on either side, and how many samples could not be followed.
    fn admissible(&self, count: usize) -> ([Intervals; COUNT], usize) {
        let calm = |which: usize, factor: f64| {
            let (scene, machine) = changed(self.scene, self.machine, which, factor);
            self.is_calm(&scene, &machine)
        };
        let exponents: Vec<i32> = (-(count as i32)..=count as i32).collect();
        let places: Vec<(usize, f64)> =
            (0..COUNT).flat_map(|which| exponents.iter().map(move |i| (which, ratio(which, count).powi(*i)))).collect();
        let found = parallel::map(&places, |(which, factor)| calm(*which, *factor), &|| ());
        let unknown = found.iter().filter(|calm| calm.is_none()).count();
        let found: Vec<bool> = found.into_iter().map(|calm| calm == Some(true)).collect();
        // A border lies between neighbours that differ.
        let neighbours: Vec<usize> =
            (1..places.len()).filter(|i| places[*i].0 == places[i - 1].0 && found[*i] != found[i - 1]).collect();
        let border = |i: &usize| {
            let (which, mut low, mut high) = (places[*i].0, places[i - 1].1, places[*i].1);
            while high / low > 1.0 + BORDER {
                let middle = (low * high).sqrt();
                if (calm(which, middle) == Some(true)) == found[i - 1] { low = middle } else { high = middle }
            }
            // The end that is calm.
            if found[*i] { high } else { low }
        };
        let borders = parallel::map(&neighbours, border, &|| ());
        let own = self.own();
        let intervals = |which: usize| {
            let of = |i: usize| places[i].0 == which;
            let mut ends: Vec<f64> = Vec::new();
            let first = which * exponents.len();
            ends.extend(found[first].then_some(places[first].1));
            ends.extend(neighbours.iter().zip(&borders).filter(|(i, _)| of(**i)).map(|(_, border)| *border));
            let last = first + exponents.len() - 1;
            ends.extend(found[last].then_some(places[last].1));
            ends.chunks_exact(2).map(|pair| [own[which] * pair[0], own[which] * pair[1]]).collect::<Intervals>()
        };
        (std::array::from_fn(intervals), unknown)
    }

    /// The motion after `turns` at a value within each interval, the gentlest impacts first.
    fn changes(&self, intervals: &[Intervals; COUNT], turns: Option<usize>) -> Vec<Change> {
        let (own, machine) = (self.own(), self.machine);
        let now = [own[0], own[1], own[2], own[3], 0.5 * machine.b / (machine.m2 * machine.omega)];
        let tried = |which: usize, ends: [f64; 2]| {
            let factor = UNITS[which].factor;
            (which, text::rounded(within(ends, now[which]) * factor, DIGITS) / factor)
        };
        let trials: Vec<(usize, f64)> =
            (0..COUNT).flat_map(|which| intervals[which].iter().map(move |ends| tried(which, *ends))).collect();
        let settle = |(which, value): &(usize, f64)| {
            let (scene, machine) = changed(self.scene, self.machine, *which, value / own[*which]);
            let (mut model, motion) = model(&scene, &machine, self.ignore)?;
            model.allow(super::MOST_STEPS);
            let settled = settled::run(&mut model, motion.samples[0].q, turns).ok()?;
            model.allow(super::MOST_STEPS);
            let from_rest = settled::run(&mut model, [0.0; 2], turns).map_or(f64::INFINITY, |it| it.largest_impulse);
            Some(Change { quantity: QUANTITIES[*which], value: *value, settled, from_rest })
        };
        let mut changes: Vec<Change> = parallel::map(&trials, settle, &|| ()).into_iter().flatten().collect();
        changes.sort_by(|a, b| a.settled.largest_impulse.total_cmp(&b.settled.largest_impulse));
        changes
    }
}

/// Values are searched between the part 1/reach and reach times the scene's value.
fn reach(which: usize) -> f64 {
    if which < COUNT - 1 { REACH } else { DAMPING[1] / middle(DAMPING) }
}

/// The ratio of neighbours among `count` samples on either side.
fn ratio(which: usize, count: usize) -> f64 {
    reach(which).powf(1.0 / count as f64)
}
