//! The experiment that shows a drive.

use std::f64::consts::TAU;

/// The experiment that shows a drive: whole revolutions, at most 1000 communication steps. The quotient of stop time and step is a
/// whole number to the last bit, since some importers refuse other values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Experiment {
    /// Stop time (s), a whole number of steps.
    pub stop: f64,
    /// Communication step (s), a whole number of nanoseconds with few digits.
    pub step: f64,
    /// Relative tolerance (1).
    pub tolerance: f64,
}

/// The most communication steps: importers thin out or double the steps of longer runs.
const MOST_STEPS: f64 = 1000.0;

/// Leading digits of steps below the next power of ten, close enough that at least three quarters of the most steps are used.
const ROUND: [f64; 10] = [1.0, 1.2, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0];

/// A span this part of a step beyond a whole number of steps is a rounding error.
const SLACK: f64 = 1e-9;

/// A turn longer than this (s) is too long for an experiment.
const LONGEST_TURN: f64 = 1e6;

impl Experiment {
    /// So many turns at the angular velocity `w` (rad/s), rounded up to the next whole steps whose quotient is whole; one second if
    /// the turns take too long.
    pub fn of_turns(turns: f64, w: f64) -> Self {
        let turn = TAU / w.abs();
        let span = if turn <= LONGEST_TURN { turns * turn } else { 1.0 };
        // In whole nanoseconds the quotients below are exact to the last bit.
        let least = (1e9 * span / MOST_STEPS * (1.0 - SLACK)).max(1.0);
        let power = 10.0_f64.powi(least.log10().floor() as i32);
        let steps = [power, 10.0 * power].into_iter().flat_map(|power| ROUND.map(|digits| (digits * power).ceil()));
        let experiments = steps.filter(|step| least <= *step).flat_map(|step| {
            let first = (1e9 * span / step - SLACK).ceil() as u32;
            (first..=MOST_STEPS as u32).map(move |count| [f64::from(count), step])
        });
        // Three of four quotients are whole, so that the search is short.
        let mut whole = experiments.map(|[count, step]| [count, count * step / 1e9, step / 1e9]);
        let found = whole.find(|[count, stop, step]| stop / step == *count);
        let [_, stop, step] = found.unwrap_or([1.0, span, span]);
        Experiment { stop, step, tolerance: 1e-6 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn default_experiments_are_whole_turns_in_round_steps() {
        let rpm = |n: f64| n * TAU / 60.0;
        // Turns, speed, step and stop as a person would choose them.
        for (turns, w, step, stop) in [
            (5.0, rpm(1800.0), 2e-4, 0.1668),
            (5.0, rpm(600.0), 5e-4, 0.5),
            (20.0, rpm(500.0), 2.5e-3, 2.4),
            (4.0, rpm(-46.0), 6e-3, 5.226),
            // 786 to 788 steps have quotients that are not whole.
            (5.0, 1e6, 4e-8, 3.156e-5),
            (5.0, 0.0, 1e-3, 1.0),
            (5.0, 1e-308, 1e-3, 1.0),
        ] {
            assert_eq!(Experiment::of_turns(turns, w), Experiment { stop, step, tolerance: 1e-6 }, "{turns} at {w}");
        }
        for i in 0..10_000 {
            let w = 10.0_f64.powf(f64::from(i) / 1000.0 - 4.0);
            let Experiment { stop, step, .. } = Experiment::of_turns(5.0, w);
            let (span, nanoseconds) = (5.0 * TAU / w, step * 1e9);
            assert!(span <= stop * (1.0 + 1e-11) && stop < 1.03 * span, "{w}");
            let count = stop / step;
            assert!((700.0..=1000.0).contains(&count) && count.fract() == 0.0, "{w}: {count} steps");
            assert!((nanoseconds - nanoseconds.round()).abs() < 1e-6, "{w}");
        }
    }
}
