//! A run of a study: one variant of a drive over its window, measured between the communication points, too.
//!
//! Between two points an output is the quintic of its values and exact derivatives ([`super::piece`]). Steps go in pairs: the quintic
//! over both predicts value and slope in the middle; its errors, which grow with h⁶, tell that of the two quintics over one step
//! each, 1/64 of it, and the length of the next pair. A pair in which an event happens, or whose error is too large, is gone back over:
//! events become points of their own, so that no polynomial spans a jump.

use super::measure::{Gathered, Kind, Measure};
use super::piece::{Jet, Piece};
use camdrive::drives::variable::{Causality, Kind as Type, Variability};
use camdrive::drives::{About, AnyDrive, Description, Experiment, Fault, Snapshot};
use std::f64::consts::TAU;

/// How long something lasts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Span {
    /// A time (s).
    Time(f64),
    /// Turns of the shaft.
    Turns(f64),
}

impl Span {
    /// The instant (s) at which it is over at the latest, and its turns.
    fn end(self, begin: f64, experiment: &Experiment) -> (f64, f64) {
        match self {
            Span::Time(time) => (begin + time, f64::INFINITY),
            Span::Turns(turns) => (begin + SLOWEST * experiment.stop * turns, turns),
        }
    }
}

/// What is measured, and when.
#[derive(Clone, Debug, PartialEq)]
pub struct Window {
    /// How long the drive runs before measuring begins.
    pub settle: Span,
    /// How long it is measured.
    pub over: Span,
    /// The error of an output between points, relative to its largest magnitude so far.
    pub accuracy: f64,
}

/// The most pairs of steps between two saved states, which double each time that nothing was gone back over: to save costs as much
/// as a few steps.
const PAIRS: usize = 32;

/// The most steps of a run: some minutes of the slowest drives.
pub(super) const MOST_STEPS: u64 = 20_000_000;

/// The error over a pair is z³ (1 − z)³ (α + β (z − ½)): its value in the middle is α/64, its slope β/64. Over half of the pair the
/// first factor is 1/64 of that, and the second one, the sixth derivative up to a constant, α ± 7β/4.
const UNEVEN: f64 = 1.75;

/// A step is longer than the one before by this factor at most.
const GROWTH: f64 = 1.3;

/// A pair this part of the first one is not divided further: a jump that is no event lies in it, and its ends say all.
const LEAST: f64 = 1.0 / 65536.0;

/// Points of an event lie this part of a step before and behind it: instants of events are known better.
const BESIDE: f64 = 1e-9;

/// A drive with a way back to its latest points.
struct Rewound<'a> {
    drive: &'a mut AnyDrive,
    saved: Snapshot,
    /// The instants since the saved state, its own first (s).
    points: Vec<f64>,
    /// Pairs until the next one is saved.
    pairs: usize,
    steps: u64,
}

impl Rewound<'_> {
    fn time(&self) -> f64 {
        self.points[self.points.len() - 1]
    }

    /// Advances to an instant; the first event on the way.
    fn advance(&mut self, to: f64) -> Result<Option<f64>, Fault> {
        let from = self.time();
        self.steps += 1;
        if self.steps > MOST_STEPS {
            return Err(Fault::new(format!("the run needs more than {MOST_STEPS} steps; it came to t = {from:.6e} s")));
        }
        self.drive.events().clear();
        self.drive.advance(from, to - from)?;
        self.points.push(to);
        Ok(self.drive.events().iter().find(|event| event.about == About::Machine).map(|event| event.time))
    }

    /// Goes back over the last `count` points; the state there is the saved one from now on.
    fn back(&mut self, count: usize) -> Result<(), Fault> {
        let kept = self.points.len() - count;
        self.drive.restore(&self.saved);
        for pair in self.points[..kept].windows(2) {
            self.drive.advance(pair[0], pair[1] - pair[0])?;
        }
        self.steps += kept as u64;
        self.points.truncate(kept);
        if kept > 1 {
            self.save();
        }
        self.pairs = 1;
        Ok(())
    }

    /// Advances to an instant that nothing is read before, in calls of no more than `most` (s).
    fn run_to(&mut self, end: f64, most: f64) -> Result<(), Fault> {
        while self.time() < end {
            let next = (self.time() + most).min(end);
            self.advance(next)?;
            self.save();
        }
        Ok(())
    }

    /// Saves the state where it is time to; whether it was.
    fn keep(&mut self) -> bool {
        let due = self.points.len() > 2 * self.pairs;
        if due {
            self.save();
            self.pairs = PAIRS.min(2 * self.pairs);
        }
        due
    }

    fn save(&mut self) {
        self.saved = self.drive.save();
        self.points.drain(..self.points.len() - 1);
    }
}

/// What a study takes of a drive.
pub struct Runner<'a> {
    window: &'a Window,
    measures: &'a [Measure],
    /// For each measure the reference of its output, and its place among those that are followed.
    outputs: Vec<(usize, Option<usize>)>,
    /// The outputs whose course matters, the angle first where it does.
    followed: Vec<Followed>,
    /// Whether the first of these is the angle.
    angle: bool,
    /// The reference of the speed of the shaft.
    speed: Option<usize>,
}

/// The outputs that measures need, by their places among all variables.
pub(super) struct Outputs {
    /// Of each measure, with its place among those that are followed.
    pub measured: Vec<(usize, Option<usize>)>,
    /// Those whose course matters, the angle first where it does.
    pub followed: Vec<usize>,
    /// Whether the first of these is the angle.
    pub angle: bool,
}

impl Outputs {
    /// Of these variables; `phi` is the angle of the shaft, and `is_followed` tells for which measures the course matters.
    pub fn new(
        all: &[Description],
        phi: impl FnOnce() -> Result<usize, Fault>,
        window: &Window,
        measures: &[Measure],
        is_followed: impl Fn(&Measure) -> bool,
    ) -> Result<Self, Fault> {
        let turns = [window.settle, window.over].iter().any(|span| matches!(span, Span::Turns(_)));
        let angle = turns || measures.iter().any(Measure::needs_angle);
        let mut followed = Vec::new();
        if angle {
            followed.push(phi()?);
        }
        let whole = matches!(window.over, Span::Turns(turns) if turns.fract() == 0.0);
        if let Some(measure) = measures.iter().find(|measure| matches!(measure.kind, Kind::Harmonic(_)) && !whole) {
            return Err(Fault::new(format!("`{measure}`: harmonics need a whole number of `turns`")));
        }
        let mut measured = Vec::new();
        for measure in measures {
            let reference = output(all, measure)?;
            let place = is_followed(measure).then(|| {
                followed.iter().position(|known| *known == reference).unwrap_or_else(|| {
                    followed.push(reference);
                    followed.len() - 1
                })
            });
            measured.push((reference, place));
        }
        Ok(Outputs { measured, followed, angle })
    }
}

/// The values of measures, after the shaft has turned so far (rad).
///
/// # Errors
/// What cannot be measured of the motion.
pub(super) fn values(gathered: &[Gathered], measures: &[Measure], turned: f64) -> Result<Vec<f64>, Fault> {
    let value = |(gathered, measure): (&Gathered, &Measure)| {
        gathered.value(turned).filter(|value| value.is_finite()).ok_or_else(|| {
            Fault::new(match measure.kind {
                Kind::At(_) => format!("`{measure}`: the shaft does not pass this angle in the window"),
                _ => format!("`{measure}` is not a finite number"),
            })
        })
    };
    gathered.iter().zip(measures).map(value).collect()
}

/// An output whose course matters.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Followed {
    reference: usize,
    slopes: Slopes,
}

/// Where the derivatives of an output come from.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Slopes {
    /// Other outputs, which cost less than a series.
    Outputs([usize; 2]),
    /// Its Taylor series.
    Series,
    /// Its series, whose value has no whole turns.
    Angle,
    /// It is constant between events.
    None,
}

impl Followed {
    fn new(all: &[Description], reference: usize) -> Self {
        let slope = |of: usize| all.iter().position(|d| d.derivative_of.as_ref() == Some(&all[of].name));
        let slopes = match slope(reference).and_then(|first| Some([first, slope(first)?])) {
            _ if all[reference].variability != Variability::Continuous => Slopes::None,
            _ if all[reference].name == PHI => Slopes::Angle,
            Some(outputs) => Slopes::Outputs(outputs),
            None => Slopes::Series,
        };
        Followed { reference, slopes }
    }

    fn jet(&self, drive: &mut AnyDrive) -> Result<Jet, Fault> {
        match self.slopes {
            Slopes::Outputs([first, second]) => Ok([drive.get(self.reference)?, drive.get(first)?, drive.get(second)?]),
            Slopes::Series => drive.jet(self.reference),
            Slopes::Angle => {
                let [_, speed, acceleration] = drive.jet(self.reference)?;
                Ok([drive.get(self.reference)?, speed, acceleration])
            }
            Slopes::None => Ok([drive.get(self.reference)?, 0.0, 0.0]),
        }
    }
}

/// Two steps of the outputs that are followed.
struct Pair<'f> {
    followed: &'f [Followed],
    /// Whether the first of them is the angle.
    angle: bool,
    /// The largest magnitude of each so far.
    scales: Vec<f64>,
    first: Vec<Jet>,
    middle: Vec<Jet>,
    last: Vec<Jet>,
    /// Over the first step and over the second one.
    pieces: [Vec<Piece>; 2],
}

impl<'f> Pair<'f> {
    /// One that begins where the drive is.
    fn new(followed: &'f [Followed], angle: bool, drive: &mut Rewound<'_>) -> Result<Self, Fault> {
        let mut scales = vec![0.0; followed.len()];
        if angle {
            scales[0] = ANGLE;
        }
        let pieces = [(); 2].map(|()| vec![Piece::constant(0.0); followed.len()]);
        let mut pair =
            Pair { followed, angle, scales, first: Vec::new(), middle: Vec::new(), last: Vec::new(), pieces };
        read(followed, drive, &mut pair.first)?;
        Ok(pair)
    }

    /// Advances to the middle and to the end; the first event on the way, behind which nothing is read.
    fn advance(&mut self, drive: &mut Rewound<'_>, [half, to]: [f64; 2]) -> Result<Option<f64>, Fault> {
        for (point, jets) in [(half, &mut self.middle), (to, &mut self.last)] {
            let event = drive.advance(point)?;
            if event.is_some() {
                return Ok(event);
            }
            read(self.followed, drive, jets)?;
        }
        Ok(None)
    }

    /// Advances over an event to where the next pair begins; the first piece leads there.
    fn pass_event(&mut self, drive: &mut Rewound<'_>, behind: f64) -> Result<(), Fault> {
        drive.advance(behind)?;
        read(self.followed, drive, &mut self.last)?;
        line(self.followed, [&self.first, &self.last], &mut self.pieces[0]);
        std::mem::swap(&mut self.first, &mut self.last);
        Ok(())
    }

    /// Joins the three points by lines: a jump that is no event lies between them.
    fn jump(&mut self) {
        line(self.followed, [&self.first, &self.middle], &mut self.pieces[0]);
        line(self.followed, [&self.middle, &self.last], &mut self.pieces[1]);
    }

    /// Fits the pieces between these instants (s); the largest error in parts of the accuracy.
    fn fit(&mut self, [from, half, to]: [f64; 3], accuracy: f64) -> f64 {
        let whole = to - from;
        let mut error: f64 = 0.0;
        for (k, scale) in self.scales.iter_mut().enumerate() {
            let [first, middle, last] = [&self.first, &self.middle, &self.last].map(|jets| jets[k]);
            if self.followed[k].slopes == Slopes::None {
                self.pieces[0][k] = Piece::constant(middle[0]);
                self.pieces[1][k] = Piece::constant(last[0]);
                continue;
            }
            if !(self.angle && k == 0) {
                *scale = [first, middle, last].iter().fold(*scale, |scale, jet| scale.max(jet[0].abs()));
            }
            let both = Piece::new(first, last, whole);
            let miss = (both.at(0.5) - middle[0]).abs() + UNEVEN * (both.slope(0.5) - whole * middle[1]).abs();
            if miss != 0.0 {
                error = error.max(miss / (64.0 * accuracy * *scale));
            }
            self.pieces[0][k] = Piece::new(first, middle, half - from);
            self.pieces[1][k] = Piece::new(middle, last, to - half);
        }
        error
    }

    /// When the angle passes a level (s).
    fn crossing(&self, level: f64, [from, half, to]: [f64; 3]) -> Option<f64> {
        let [first, second] = &self.pieces;
        let found = first[0].crossing(level).map(|z| from + z * (half - from));
        found.or_else(|| second[0].crossing(level).map(|z| half + z * (to - half)))
    }
}

/// By which factor the next pair is longer than one with this error. A small error may be a zero of the sixth derivative, so that
/// pairs grow slowly.
fn growth(error: f64) -> f64 {
    if error > 0.04 { (0.85 / error.sqrt().cbrt()).clamp(0.3, GROWTH) } else { GROWTH }
}

/// What is followed, where the drive is.
fn read(followed: &[Followed], drive: &mut Rewound<'_>, jets: &mut Vec<Jet>) -> Result<(), Fault> {
    jets.clear();
    for output in followed {
        jets.push(output.jet(drive.drive)?);
    }
    Ok(())
}

/// Lines between two points; what is constant between events may be a mean over the last step.
fn line(followed: &[Followed], jets: [&[Jet]; 2], pieces: &mut [Piece]) {
    for (k, piece) in pieces.iter_mut().enumerate() {
        let [from, to] = jets.map(|jets| jets[k][0]);
        *piece = if followed[k].slopes == Slopes::None { Piece::constant(to) } else { Piece::line(from, to) };
    }
}

/// An instant at which a pair has to end.
#[derive(Clone, Copy, PartialEq)]
enum Limit {
    None,
    /// Before an event.
    Event(f64),
    /// The end of the span.
    End(f64),
}

impl Limit {
    fn event(self) -> Option<f64> {
        if let Limit::Event(time) = self { Some(time) } else { None }
    }

    /// Where a pair has to end that may come to `end` (s).
    fn before(self, end: f64) -> f64 {
        match self {
            Limit::Event(time) | Limit::End(time) => time.min(end),
            Limit::None => end,
        }
    }
}

/// The output that is the angle of the shaft.
pub(super) const PHI: &str = "phi";

/// The angle is followed to this part of the accuracy (rad): windows end by it, and harmonics repeat it.
const ANGLE: f64 = 0.1;

/// A shaft that is slower than in the default experiment, which has several turns, by this factor stands.
const SLOWEST: f64 = 1e4;

/// Points of a turn at least: motions between two rests are wider than twenty degrees, and none may hide between two points.
const POINTS: f64 = 18.0;

/// Radians of the highest harmonic that Gauss's rule of six points integrates to ten digits over a step.
pub(super) const HARMONIC: f64 = 1.5;

impl<'a> Runner<'a> {
    /// Of these measures of this drive.
    ///
    /// # Errors
    /// Where the drive has no such output, or it cannot be measured so.
    pub fn new(drive: &AnyDrive, window: &'a Window, measures: &'a [Measure]) -> Result<Self, Fault> {
        let all = drive.descriptions();
        let phi = || {
            let phi = all.iter().position(|d| d.name == PHI && d.causality == Causality::Output);
            phi.ok_or_else(|| Fault::new("the drive has no output phi, by which turns and angles are known"))
        };
        let Outputs { measured, followed, angle } = Outputs::new(all, phi, window, measures, Measure::needs_course)?;
        let followed = followed.into_iter().map(|reference| Followed::new(all, reference)).collect();
        let speed = all.iter().position(|d| d.name == "w" || d.name == "der(phi)");
        Ok(Runner { window, measures, outputs: measured, followed, angle, speed })
    }

    /// The measures of a drive that was started at 0 s, in their order.
    ///
    /// # Errors
    /// What the drive says where it cannot go on, and what cannot be measured of its motion.
    pub fn run(&self, drive: &mut AnyDrive) -> Result<Vec<f64>, Fault> {
        drive.events().keep(true);
        let saved = drive.save();
        let mut drive = Rewound { drive, saved, points: vec![0.0], pairs: 1, steps: 0 };
        let only_angle = if let Span::Turns(_) = self.window.settle { &self.followed[..1] } else { &[] };
        self.follow(&mut drive, only_angle, self.window.settle, |_, _| ())?;
        let begin =
            self.angle.then(|| self.followed[0].jet(drive.drive)).transpose()?.map_or(0.0, |[phi, ..]| phi.abs());
        let reach = 2.0 * ANGLE * self.window.accuracy + 16.0 * f64::EPSILON * begin;
        let gathered = self.measures.iter().map(|measure| Gathered::new(measure.kind, reach));
        let mut gathered: Vec<Gathered> = gathered.collect();
        let ends = |drive: &mut Rewound<'_>, gathered: &mut [Gathered]| -> Result<(), Fault> {
            for (gathered, (reference, _)) in gathered.iter_mut().zip(&self.outputs) {
                let value = drive.drive.get(*reference)?;
                gathered.end(value, value);
            }
            Ok(())
        };
        ends(&mut drive, &mut gathered)?;
        let places: Vec<(usize, usize)> =
            self.outputs.iter().enumerate().filter_map(|(i, (_, place))| Some((i, (*place)?))).collect();
        let turned = self.follow(&mut drive, &self.followed, self.window.over, |pieces, step| {
            for (i, place) in &places {
                gathered[*i].add(&pieces[*place], &pieces[0], step);
            }
        })?;
        ends(&mut drive, &mut gathered)?;
        values(&gathered, self.measures, turned)
    }

    /// Runs over a span and gives every piece of the outputs that are `followed` to `take`; how far the angle turned, where it is
    /// the first of these.
    fn follow(
        &self,
        drive: &mut Rewound<'_>,
        followed: &[Followed],
        span: Span,
        mut take: impl FnMut(&[Piece], f64),
    ) -> Result<f64, Fault> {
        if matches!(span, Span::Time(0.0) | Span::Turns(0.0)) {
            return Ok(0.0);
        }
        let experiment = drive.drive.experiment();
        let (end, turns) = span.end(drive.time(), &experiment);
        if followed.is_empty() {
            return drive.run_to(end, experiment.stop).map(|()| 0.0);
        }
        let angle = self.angle && followed.first() == self.followed.first();
        // Of the angle alone only harmonics have a scale of their own.
        let others = followed.len() > usize::from(angle) || (self.followed.len() == 1 && self.harmonic() > 0);
        let mut pair = Pair::new(followed, angle, drive)?;
        let start = pair.first[0][0];
        let has_turned = |jet: &Jet| angle && (jet[0] - start).abs() >= TAU * turns;
        let mut longest = self.longest(drive, &experiment, others)?;
        let mut length = longest.min(2.0 * experiment.step);
        let mut limit = Limit::None;
        loop {
            let from = drive.time();
            let stop = limit.before(end);
            if stop <= from {
                let Some(time) = limit.event().filter(|_| end > from) else { break };
                pair.pass_event(drive, (time + 2.0 * beside(time, experiment.step)).min(end))?;
                take(&pair.pieces[0], drive.time() - from);
                drive.save();
                limit = if has_turned(&pair.first[0]) { Limit::End(drive.time()) } else { Limit::None };
                continue;
            }
            // No short rest is left before the stop.
            let whole = stop - from <= 1.01 * length;
            let to = if whole { stop } else { from + length };
            let half = from + 0.5 * (to - from);
            let least = to - from <= 2.0 * LEAST * experiment.step || half <= from || half >= to;
            if let Some(event) = pair.advance(drive, [half, to])? {
                drive.back(if drive.time() == to { 2 } else { 1 })?;
                limit = Limit::Event((event - beside(event, experiment.step)).min(to).max(from));
                continue;
            }
            let instants = [from, half, to];
            let error = pair.fit(instants, self.window.accuracy);
            let error = if angle && others { error.max(self.error_of_harmonics(&pair)) } else { error };
            let next = (to - from) * growth(error);
            length = if whole && error <= 1.0 { length.max(next) } else { next };
            if error > 1.0 {
                if !least {
                    drive.back(2)?;
                    continue;
                }
                pair.jump();
            }
            length = length.min(longest);
            if !matches!(limit, Limit::End(_)) && has_turned(&pair.last[0]) {
                let level = start + (TAU * turns).copysign(pair.last[0][0] - start);
                limit = Limit::End(pair.crossing(level, instants).unwrap_or(to).min(to));
                if limit != Limit::End(to) {
                    drive.back(2)?;
                    continue;
                }
            }
            take(&pair.pieces[0], half - from);
            take(&pair.pieces[1], to - half);
            std::mem::swap(&mut pair.first, &mut pair.last);
            if drive.keep() {
                longest = self.longest(drive, &experiment, others)?;
            }
        }
        if angle && turns.is_finite() && !matches!(limit, Limit::End(_)) {
            return Err(Fault::new(format!("the shaft has not made its turns ({turns}) by t = {end:.3e} s")));
        }
        Ok(pair.first[0][0] - start)
    }

    /// The longest pair of steps (s).
    fn longest(&self, drive: &mut Rewound<'_>, experiment: &Experiment, others: bool) -> Result<f64, Fault> {
        if !others {
            return Ok(experiment.stop);
        }
        let speed = self.speed.map_or(Ok(0.0), |reference| drive.drive.get(reference))?;
        Ok((2.0 * TAU / (POINTS * speed.abs())).min(8.0 * experiment.step))
    }

    /// The error of Gauss's rule for the highest harmonic over a pair, in parts of what it may have.
    fn error_of_harmonics(&self, pair: &Pair<'_>) -> f64 {
        let turned = (pair.last[0][0] - pair.first[0][0]).abs() / 2.0;
        (f64::from(self.harmonic()) * turned / HARMONIC).powi(6)
    }

    /// The highest harmonic that is measured.
    fn harmonic(&self) -> u32 {
        highest_harmonic(self.measures)
    }
}

/// The highest harmonic of these measures, 0 where there is none.
pub(super) fn highest_harmonic(measures: &[Measure]) -> u32 {
    let of = |measure: &Measure| if let Kind::Harmonic(k) = measure.kind { k } else { 0 };
    measures.iter().map(of).max().unwrap_or(0)
}

/// How far before and behind an event its points are (s): instants of events are known better, but not below rounding.
fn beside(event: f64, step: f64) -> f64 {
    (BESIDE * step).max(16.0 * f64::EPSILON * event.abs())
}

/// The reference of the output of a measure.
fn output(all: &[Description], measure: &Measure) -> Result<usize, Fault> {
    let name = &measure.output;
    let found = all.iter().position(|d| d.name == *name);
    let reference = found.ok_or_else(|| Fault::new(format!("`{measure}`: there is no output `{name}`")))?;
    let d = &all[reference];
    let refused = |reason: &str| Err(Fault::new(format!("`{measure}`: {reason}")));
    if matches!(d.causality, Causality::Parameter | Causality::Input) {
        return refused(&format!("`{name}` is set, not computed"));
    }
    // Its value depends on the length of the last step, but its mean does not.
    if name.ends_with("_mean") && measure.kind != Kind::Mean {
        return refused(&format!("`{name}` is a mean over steps; only `mean {name}` does not depend on them"));
    }
    let is_statistic = name.starts_with("solver.") || name.contains(".solver.");
    if is_statistic && measure.needs_course() {
        return refused("a statistic of the solver has no course; `last` is its value at the end");
    }
    match d.kind {
        Type::Boolean | Type::Enumeration(_) if matches!(measure.kind, Kind::Count | Kind::Harmonic(_)) => {
            refused("it is no number")
        }
        _ => Ok(reference),
    }
}
