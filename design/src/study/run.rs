//! A run of a study: its window, and the way through it from piece to piece of the outputs.
//!
//! A piece is the polynomial of an output between two instants ([`super::piece`]); a window that begins or ends within one cuts
//! it there.

use super::measure::{Gathered, Kind, Measure};
use super::piece::Piece;
use camdrive::drives::variable::{Causality, Kind as Type};
use camdrive::drives::{Description, Fault};
use std::f64::consts::TAU;

/// A duration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Span {
    /// A time (s).
    Time(f64),
    /// Turns of the shaft.
    Turns(f64),
}

/// The span of a measurement.
#[derive(Clone, Debug, PartialEq)]
pub struct Window {
    /// The time that the drive runs before measuring begins.
    pub settle: Span,
    /// The measured span.
    pub over: Span,
    /// The error of an output between points, relative to its largest magnitude so far.
    pub accuracy: f64,
}

/// The most pieces of a span: some minutes of the slowest drives.
const MOST_STEPS: u64 = 20_000_000;

/// The output that is the angle of the shaft.
pub(super) const PHI: &str = "phi";

/// Radians of the highest harmonic that Gauss's rule of six points integrates to ten digits over a step.
pub(super) const HARMONIC: f64 = 1.5;

/// The course of outputs, piece by piece.
pub(super) trait Course {
    /// The next pieces, at least one, with the angle first if it is followed; returns their beginning and end (s). They begin
    /// at the end of the last ones, and need not go beyond `stop` (s).
    fn next(&mut self, stop: f64, pieces: &mut Vec<Piece>) -> Result<[f64; 2], Fault>;
    /// Takes the outputs over a time (s).
    fn take(&mut self, pieces: &[Piece], time: f64) -> Result<(), Fault>;
    /// A span ends at the time `at` (s) within the last pieces, which began at `from`. Goes back there, so that pieces may end
    /// with the span, or takes `rest`, their remainder; returns true if it went back.
    fn part(&mut self, way: [f64; 2], rest: Vec<Piece>) -> Result<bool, Fault>;
}

impl Span {
    /// Passes it from this time (s) and angle on, each turn in `slowest` (s) at most; returns time and angle at its end.
    pub(super) fn follow(self, begin: [f64; 2], slowest: f64, course: &mut impl Course) -> Result<[f64; 2], Fault> {
        let mut stop = match self {
            Span::Time(0.0) | Span::Turns(0.0) => return Ok(begin),
            Span::Time(time) => begin[0] + time,
            Span::Turns(turns) => begin[0] + slowest * turns,
        };
        let (mut pieces, mut is_near, mut to) = (Vec::new(), false, begin[0]);
        for _ in 0..MOST_STEPS {
            let from;
            [from, to] = course.next(stop, &mut pieces)?;
            let end = if is_near { (to >= stop).then_some(1.0) } else { self.end(begin, [from, to], &pieces[0]) };
            let Some(z) = end else {
                course.take(&pieces, to - from)?;
                if let (Span::Turns(turns), true) = (self, to >= stop) {
                    return Err(Fault::new(format!("the shaft has not made its turns ({turns}) by t = {stop:.3e} s")));
                }
                continue;
            };
            let at = if z < 1.0 { from + z * (to - from) } else { to };
            // Bitwise equal to the end of a piece.
            let parted = |piece: &Piece| if z < 1.0 { piece.split(z) } else { [*piece, Piece::constant(piece.0[5])] };
            let (low, high): (Vec<Piece>, Vec<Piece>) = pieces.iter().map(|piece| parted(piece).into()).unzip();
            if course.part([from, at], high)? {
                (stop, is_near) = (at, true);
                continue;
            }
            course.take(&low, at - from)?;
            return Ok([at, low[0].0[5]]);
        }
        Err(Fault::new(format!("the run needs more than {MOST_STEPS} steps; it came to t = {to:.6e} s")))
    }

    /// The part of a piece of φ over these times (s) at which a span ends that began at this time and angle; None if it goes
    /// on.
    fn end(self, [begin, angle]: [f64; 2], [from, to]: [f64; 2], phi: &Piece) -> Option<f64> {
        match self {
            Span::Time(time) => {
                let end = begin + time;
                (end <= to).then(|| if to > from { (end - from) / (to - from) } else { 1.0 })
            }
            Span::Turns(turns) => {
                let turned = phi.0[5] - angle;
                let level = angle + (TAU * turns).copysign(turned);
                (turned.abs() >= TAU * turns).then(|| phi.crossing(level).unwrap_or(1.0))
            }
        }
    }
}

/// The outputs that measures need, by their indices among all variables.
pub(super) struct Outputs {
    /// The measures, each with its index among the followed outputs.
    pub measured: Vec<(usize, Option<usize>)>,
    /// The outputs whose course matters, the angle first if it matters.
    pub followed: Vec<usize>,
    /// True if the first of these is the angle.
    pub angle: bool,
}

impl Outputs {
    /// The outputs of these variables; `phi` is the angle of the shaft, and `is_followed` is true for measures whose course
    /// matters.
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

/// The values of measures, after this turn of the shaft (rad).
///
/// # Errors
/// Measures that the motion does not have.
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

/// The highest harmonic of these measures, 0 without any.
pub(super) fn highest_harmonic(measures: &[Measure]) -> u32 {
    let of = |measure: &Measure| if let Kind::Harmonic(k) = measure.kind { k } else { 0 };
    measures.iter().map(of).max().unwrap_or(0)
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
        return refused(&format!("`{name}` is a mean over steps; use `mean {name}`, which does not depend on them"));
    }
    let is_statistic = name.starts_with("solver.") || name.contains(".solver.");
    if is_statistic && measure.needs_course() {
        return refused("a statistic of the solver has no course; use `last` for its value at the end");
    }
    match d.kind {
        Type::Boolean | Type::Enumeration(_) if matches!(measure.kind, Kind::Count | Kind::Harmonic(_)) => {
            refused("it is not a number")
        }
        _ => Ok(reference),
    }
}
