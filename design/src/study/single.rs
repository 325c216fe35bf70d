//! A run of a study over one drive, also measured between its communication points.
//!
//! Between two points an output is the quintic of its values and exact derivatives ([`super::piece`]). Steps go in pairs: the
//! quintic over both predicts value and slope in the middle. Its errors, which grow with h⁶, give the error of the two quintics
//! over one step each, 1/64 of it, and the length of the next pair. A pair with too large an error is repeated: the drive
//! itself goes back within an internal step that holds the motion ([`AnyDrive::held`]), else from a saved state.
//!
//! No polynomial spans an event: a pair ends before an event that ends an internal step, and is repeated if one happens
//! unforeseen.

use super::measure::{Gathered, Measure};
use super::piece::{Jet, Piece};
use super::run::{HARMONIC, Outputs, PHI, Span, Window, highest_harmonic, values};
use camdrive::drives::variable::{Causality, Variability};
use camdrive::drives::{About, AnyDrive, Experiment, Fault, Snapshot};
use std::f64::consts::TAU;

/// Steps of a pair shorter than this part of it show little of its error.
const UNEQUAL: f64 = 0.05;

/// A step is longer than the one before by this factor at most.
const GROWTH: f64 = 1.3;

/// A pair this part of the first one is not divided further: it contains a jump that is no event, and its ends suffice.
const LEAST: f64 = 1.0 / 65536.0;

/// Points of an event lie this part of a step before and after it: instants of events are known better.
const BESIDE: f64 = 1e-9;

/// The angle is followed to this part of the accuracy (rad): windows end by it, and harmonics use it.
const ANGLE: f64 = 0.1;

/// A shaft that is slower by this factor than in the default experiment, which has several turns, stands still.
const SLOWEST: f64 = 1e4;

/// Least points of a turn: motions between two rests are wider than twenty degrees, and none may hide between two points.
const POINTS: f64 = 18.0;

/// The longest pair in communication steps of the default experiment, if the shaft stands still.
const LONGEST: f64 = 16.0;

/// The speed of the shaft is read again after this many of the longest pairs.
const LASTING: f64 = 8.0;

/// The data that a study needs of a drive.
pub struct Runner<'a> {
    window: &'a Window,
    measures: &'a [Measure],
    /// For each measure the reference of its output, and its index among the followed ones.
    outputs: Vec<(usize, Option<usize>)>,
    /// The outputs whose course matters, the angle first if it matters.
    followed: Vec<Followed>,
    /// True if the first of these is the angle.
    angle: bool,
    /// The reference of the speed of the shaft.
    speed: Option<usize>,
    /// True if a mean over steps is measured; its steps are then the pieces.
    means: bool,
}

/// An output whose course matters.
struct Followed {
    reference: usize,
    /// True if it is constant between events.
    is_discrete: bool,
    /// True if it is the angle, whose series has no whole turns.
    is_angle: bool,
}

impl Followed {
    fn jet(&self, drive: &mut AnyDrive) -> Result<Jet, Fault> {
        let [value, slope, bend] = if self.is_discrete { [0.0; 3] } else { drive.jet(self.reference)? };
        let value = if self.is_discrete || self.is_angle { drive.get(self.reference)? } else { value };
        Ok([value, slope, bend])
    }
}

impl<'a> Runner<'a> {
    /// A runner for these measures of this drive.
    ///
    /// # Errors
    /// An output that the drive does not have or that cannot be measured like this.
    pub fn new(drive: &AnyDrive, window: &'a Window, measures: &'a [Measure]) -> Result<Self, Fault> {
        let all = drive.descriptions();
        let phi = || {
            let phi = all.iter().position(|d| d.name == PHI && d.causality == Causality::Output);
            phi.ok_or_else(|| Fault::new("the drive has no output phi, which turns and angles need"))
        };
        let Outputs { measured, followed, angle } = Outputs::new(all, phi, window, measures, Measure::needs_course)?;
        let of = |reference: usize| {
            let is_discrete = all[reference].variability != Variability::Continuous;
            Followed { reference, is_discrete, is_angle: all[reference].name == PHI }
        };
        let followed = followed.into_iter().map(of).collect();
        let speed = all.iter().position(|d| d.name == "w" || d.name == "der(phi)");
        let means = measures.iter().any(|measure| measure.output.ends_with("_mean"));
        Ok(Runner { window, measures, outputs: measured, followed, angle, speed, means })
    }

    /// The measures of a drive that was started at 0 s, in their order.
    ///
    /// # Errors
    /// The fault of a drive that cannot go on, and measures that its motion does not have.
    pub fn run(&self, drive: &mut AnyDrive) -> Result<Vec<f64>, Fault> {
        drive.events().keep(true);
        let angle = &self.followed[..usize::from(self.angle && matches!(self.window.settle, Span::Turns(_)))];
        let (experiment, gathered, pair) = (drive.experiment(), Vec::new(), Pair::default());
        let mut course = Course { runner: self, drive, experiment, followed: &[], gathered, time: 0.0, pair };
        let begin = course.follow(self.window.settle, angle)?;
        let phi = self.angle.then(|| self.followed[0].jet(course.drive)).transpose()?.map_or(0.0, |[phi, ..]| phi);
        let reach = 2.0 * ANGLE * self.window.accuracy + 16.0 * f64::EPSILON * phi.abs();
        course.gathered = self.measures.iter().map(|measure| Gathered::new(measure.kind, reach)).collect();
        course.ends()?;
        let end = course.follow(self.window.over, &self.followed)?;
        course.ends()?;
        values(&course.gathered, self.measures, end[1] - begin[1])
    }
}

/// The course of a drive.
struct Course<'a> {
    runner: &'a Runner<'a>,
    drive: &'a mut AnyDrive,
    experiment: Experiment,
    /// The followed outputs.
    followed: &'a [Followed],
    /// The gathered data of each measure; empty before the window.
    gathered: Vec<Gathered>,
    /// The current time of the drive (s).
    time: f64,
    pair: Pair,
}

/// Two steps of the followed outputs.
#[derive(Default)]
struct Pair {
    /// True if the first of them is the angle, and others matter.
    angle: bool,
    others: bool,
    /// The beginning of the pair (s), with the state there if it was saved.
    from: f64,
    saved: Option<Snapshot>,
    /// The beginning of its second step (s), until the piece over it is handed out.
    half: Option<f64>,
    /// Its length, the longest one, and the end of its validity (s).
    length: f64,
    longest: f64,
    due: f64,
    /// The next known event (s), and whether there have been any.
    event: Option<f64>,
    scouts: bool,
    /// The largest magnitude of each output so far.
    scales: Vec<f64>,
    /// At its begin, in the middle and at its end.
    jets: [Vec<Jet>; 3],
    /// Over the first step and over the second one.
    pieces: [Vec<Piece>; 2],
}

impl<'a> Course<'a> {
    /// Follows these outputs over a span; returns time and angle at its end.
    fn follow(&mut self, span: Span, followed: &'a [Followed]) -> Result<[f64; 2], Fault> {
        let (own, angle) = (self.runner, self.runner.angle && !followed.is_empty());
        // If only the angle is followed, only harmonics have a scale of their own.
        let others =
            followed.len() > usize::from(angle) || (own.followed.len() == 1 && highest_harmonic(own.measures) > 0);
        let pieces = [(); 2].map(|()| vec![Piece::constant(0.0); followed.len().max(1)]);
        let (length, due) = (2.0 * self.experiment.step, f64::NEG_INFINITY);
        let scales = (0..followed.len()).map(|k| if angle && k == 0 { ANGLE } else { 0.0 }).collect();
        self.pair = Pair { angle, others, length, due, scales, pieces, ..Pair::default() };
        self.followed = followed;
        self.read(0)?;
        let angle = self.pair.jets[0].first().map_or(0.0, |jet| jet[0]);
        span.follow([self.time, angle], SLOWEST * self.experiment.stop, self)
    }

    /// Takes the values at the drive's current time.
    fn ends(&mut self) -> Result<(), Fault> {
        for (gathered, (reference, _)) in self.gathered.iter_mut().zip(&self.runner.outputs) {
            let value = self.drive.get(*reference)?;
            gathered.end(value, value);
        }
        Ok(())
    }

    /// Reads the followed outputs at the current time, as one of the points of the pair.
    fn read(&mut self, point: usize) -> Result<(), Fault> {
        let jets = &mut self.pair.jets[point];
        jets.clear();
        for output in self.followed {
            jets.push(output.jet(self.drive)?);
        }
        Ok(())
    }

    /// Advances to an instant; returns the first event on the way.
    fn advance(&mut self, to: f64) -> Result<Option<f64>, Fault> {
        self.drive.events().clear();
        self.drive.advance(self.time, to - self.time)?;
        self.time = to;
        Ok(self.drive.events().iter().find(|event| event.about == About::Machine).map(|event| event.time))
    }

    /// Goes back to the beginning of the pair.
    fn back(&mut self) -> Result<(), Fault> {
        if let Some(saved) = &self.pair.saved {
            self.drive.restore(saved);
        } else if self.time > self.pair.from {
            self.drive.advance(self.time, self.pair.from - self.time)?;
        }
        self.time = self.pair.from;
        Ok(())
    }

    /// Goes from internal step to internal step up to the one that holds an instant (s), if events are expected; returns the
    /// event before that instant.
    fn scout(&mut self, to: f64) -> Result<Option<f64>, Fault> {
        while let (true, Some((held, happens))) = (self.pair.scouts, self.drive.held()) {
            let beside = self.beside(held);
            if happens && held - beside < to {
                return Ok(Some(held));
            }
            if held + beside >= to || held <= self.time - beside {
                break;
            }
            if let Some(event) = self.advance(held + beside)? {
                return Ok(Some(event));
            }
        }
        Ok(None)
    }

    /// The middle of a pair that ends before the stop (s) and before the next event; None if it must be shorter.
    fn step(&mut self, stop: f64) -> Result<Option<f64>, Fault> {
        let from = self.pair.from;
        // No short rest is left before the stop.
        let mut whole = stop - from <= 1.01 * self.pair.length;
        let mut to = if whole { stop } else { from + self.pair.length };
        let mut half = from + 0.5 * (to - from);
        let least = to - from <= 2.0 * LEAST * self.experiment.step || half <= from || half >= to;
        if self.pair.saved.is_none() && self.drive.held().is_none_or(|(held, _)| held <= to) {
            self.pair.saved = Some(self.drive.save());
        }
        for point in [1, 2] {
            let mut event = self.scout(if point == 1 { half } else { to })?;
            if let Some(event) = event {
                (to, whole) = (event - self.beside(event), true);
                half = if point == 1 { self.time.max(from + 0.5 * (to - from)) } else { half };
            }
            // Unequal steps show little.
            if event.is_none() || (half - from).min(to - half) > UNEQUAL * (to - from) {
                event = self.advance(if point == 1 { half } else { to })?;
            }
            if event.is_some() {
                self.pair.event = event;
                return self.back().map(|()| None);
            }
            self.read(point)?;
        }
        let error = self.fit([from, half, to]);
        let next = (to - from) * growth(error);
        self.pair.length = if whole && error <= 1.0 { self.pair.length.max(next) } else { next };
        if error > 1.0 && !least {
            return self.back().map(|()| None);
        }
        if error > 1.0 {
            // A jump that is no event lies between the three points.
            (0..2).for_each(|step| self.line(step, step + 1));
        }
        Ok(Some(half))
    }

    /// The pieces over a step are lines to this point; an output that is constant between events may be a mean over the last
    /// step.
    fn line(&mut self, step: usize, to: usize) {
        let Pair { jets, pieces, .. } = &mut self.pair;
        for (k, piece) in pieces[step].iter_mut().enumerate() {
            let [from, to] = [step, to].map(|point| jets[point][k][0]);
            *piece = if self.followed[k].is_discrete { Piece::constant(to) } else { Piece::line(from, to) };
        }
    }

    /// Fits the pieces between these instants (s); returns the largest error in parts of the admissible one.
    fn fit(&mut self, [from, half, to]: [f64; 3]) -> f64 {
        let (accuracy, harmonic) = (self.runner.window.accuracy, highest_harmonic(self.runner.measures));
        let Pair { angle, others, scales, jets, pieces, .. } = &mut self.pair;
        let mut error: f64 = 0.0;
        for (k, of) in self.followed.iter().enumerate() {
            let [first, middle, last] = [0, 1, 2].map(|point| jets[point][k]);
            if of.is_discrete {
                [pieces[0][k], pieces[1][k]] = [middle, last].map(|jet| Piece::constant(jet[0]));
                continue;
            }
            pieces[0][k] = Piece::new(first, middle, half - from);
            pieces[1][k] = Piece::new(middle, last, to - half);
            if !(*angle && k == 0) {
                scales[k] = [first, middle, last].iter().fold(scales[k], |scale, jet| scale.max(jet[0].abs()));
            }
            let whole = Piece::new(first, last, to - from);
            let miss = whole.error_of_parts((half - from) / (to - from), [middle[0], (to - from) * middle[1]]);
            if miss != 0.0 {
                error = error.max(miss / (accuracy * scales[k]));
            }
        }
        if *angle && *others {
            // The error of Gauss's rule for the highest harmonic.
            let turned = (jets[2][0][0] - jets[0][0][0]).abs() / 2.0;
            error = error.max((f64::from(harmonic) * turned / HARMONIC).powi(6));
        }
        error
    }

    /// The distance of an event's points before and after it (s): instants of events are known better, but not below rounding.
    fn beside(&self, event: f64) -> f64 {
        (BESIDE * self.experiment.step).max(16.0 * f64::EPSILON * event.abs())
    }
}

impl super::run::Course for Course<'_> {
    fn next(&mut self, stop: f64, pieces: &mut Vec<Piece>) -> Result<[f64; 2], Fault> {
        if let Some(half) = self.pair.half.take() {
            pieces.clone_from(&self.pair.pieces[1]);
            self.pair.jets.swap(0, 2);
            return Ok([half, self.time]);
        }
        let from = self.time;
        (self.pair.from, self.pair.saved) = (from, None);
        if self.followed.is_empty() {
            self.advance((from + self.experiment.stop).min(stop))?;
            pieces.clone_from(&self.pair.pieces[0]);
            return Ok([from, self.time]);
        }
        if from >= self.pair.due {
            let speed = self.runner.speed.map_or(Ok(0.0), |reference| self.drive.get(reference))?;
            let longest = (2.0 * TAU / (POINTS * speed.abs())).min(LONGEST * self.experiment.step);
            self.pair.longest = if self.pair.others { longest } else { self.experiment.stop };
            self.pair.due = from + LASTING * self.pair.longest;
        }
        self.pair.length = self.pair.length.min(self.pair.longest);
        loop {
            let held = self.drive.held().and_then(|(held, happens)| happens.then_some(held));
            let event = self.pair.event.or(held).map(|event| (event, self.beside(event)));
            if let Some((event, beside)) = event.filter(|(event, beside)| event - 1.5 * beside <= from) {
                // Over the event to the beginning of the next pair.
                self.advance((event.max(from) + beside).min(stop))?;
                self.read(2)?;
                self.line(0, 2);
                self.pair.jets.swap(0, 2);
                (self.pair.event, self.pair.from, self.pair.saved) = (None, self.time, None);
                self.pair.scouts = !self.runner.means;
                pieces.clone_from(&self.pair.pieces[0]);
                return Ok([from, self.time]);
            }
            let before = event.map_or(stop, |(event, beside)| stop.min(event - beside));
            self.pair.half = self.step(before)?;
            if let Some(half) = self.pair.half {
                pieces.clone_from(&self.pair.pieces[0]);
                return Ok([from, half]);
            }
        }
    }

    fn take(&mut self, pieces: &[Piece], time: f64) -> Result<(), Fault> {
        for (gathered, (_, place)) in self.gathered.iter_mut().zip(&self.runner.outputs) {
            if let Some(place) = place {
                gathered.add(&pieces[*place], &pieces[0], time);
            }
        }
        Ok(())
    }

    fn part(&mut self, [from, at]: [f64; 2], _: Vec<Piece>) -> Result<bool, Fault> {
        // Over an event there is no way back.
        if at >= self.time || self.pair.from >= self.time {
            return Ok(false);
        }
        self.back()?;
        if from > self.time {
            self.advance(from)?;
        }
        self.pair.half = None;
        self.read(0).map(|()| true)
    }
}

/// The factor by which the next pair is longer than one with this error. A small error may be a zero of the sixth derivative,
/// so pairs grow slowly.
fn growth(error: f64) -> f64 {
    if error > 0.04 { (0.85 / error.sqrt().cbrt()).clamp(0.3, GROWTH) } else { GROWTH }
}
