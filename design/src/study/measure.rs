//! The measures of a study: functions of an output over its window, gathered piece by piece.

use super::piece::Piece;
use num_complex::Complex64;
use std::f64::consts::TAU;
use std::fmt;

/// The highest measured harmonic.
pub const HIGHEST_HARMONIC: u32 = 256;

/// The kind of a measure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    /// `max q`: the greatest value.
    Max,
    /// `min q`: the least value.
    Min,
    /// `max |q|`: the greatest magnitude.
    Magnitude,
    /// `range q`: greatest minus least value.
    Range,
    /// `mean q`: the mean over time.
    Mean,
    /// `rms q`: the root mean square over time.
    Rms,
    /// `last q`: the value at the end.
    Last,
    /// `count impacts`: its growth.
    Count,
    /// `q at 90 deg`: the value at the shaft's last passage of this angle of its turn (rad).
    At(f64),
    /// `harmonic 3 of q`: the amplitude of cos(3φ − ψ) over whole turns of the shaft.
    Harmonic(u32),
}

/// A measure of an output.
#[derive(Clone, Debug, PartialEq)]
pub struct Measure {
    /// The kind.
    pub kind: Kind,
    /// The name of the output.
    pub output: String,
}

/// The forms of measures.
pub const FORMS: &str =
    "max |q|, max q, min q, range q, mean q, rms q, last q, count impacts, q at 90 deg, harmonic 3 of q";

impl Measure {
    /// The measure of a text.
    ///
    /// # Errors
    /// A fault in the text, without the list of forms.
    pub fn parse(text: &str) -> Result<Self, String> {
        let words: Vec<&str> = text.split_whitespace().collect();
        let of = |kind: Kind, output: &str| Ok(Measure { kind, output: output.to_owned() });
        match words[..] {
            ["max", output] => match output.strip_prefix('|').and_then(|rest| rest.strip_suffix('|')) {
                Some(output) => of(Kind::Magnitude, output),
                None => of(Kind::Max, output),
            },
            ["min", output] => of(Kind::Min, output),
            ["range", output] => of(Kind::Range, output),
            ["mean", output] => of(Kind::Mean, output),
            ["rms", output] => of(Kind::Rms, output),
            ["last", output] => of(Kind::Last, output),
            ["count", output] => of(Kind::Count, output),
            [output, "at", angle, unit @ ("deg" | "°" | "rad")] => {
                let number: f64 = angle.parse().map_err(|_| format!("\"{angle}\" is not a number"))?;
                let angle = if unit == "rad" { number } else { number.to_radians() };
                match angle.is_finite() {
                    true => of(Kind::At(angle.rem_euclid(TAU)), output),
                    false => Err(format!("\"{number}\" is not an angle")),
                }
            }
            ["harmonic", number, "of", output] => match number.parse() {
                Ok(harmonic @ 1..=HIGHEST_HARMONIC) => of(Kind::Harmonic(harmonic), output),
                _ => Err(format!("\"{number}\" is not a harmonic from 1 to {HIGHEST_HARMONIC}")),
            },
            _ => Err(format!("\"{text}\" is not a measure")),
        }
    }

    /// True if the motion between the ends of the window matters.
    pub fn needs_course(&self) -> bool {
        !matches!(self.kind, Kind::Last | Kind::Count)
    }

    /// True if the angle of the shaft matters.
    pub fn needs_angle(&self) -> bool {
        matches!(self.kind, Kind::At(_) | Kind::Harmonic(_))
    }

    /// Its meaning in words.
    pub fn meaning(&self, output: &str) -> String {
        match self.kind {
            Kind::Max => format!("Greatest value: {output}"),
            Kind::Min => format!("Least value: {output}"),
            Kind::Magnitude => format!("Greatest magnitude: {output}"),
            Kind::Range => format!("Greatest less least value: {output}"),
            Kind::Mean => format!("Mean over time: {output}"),
            Kind::Rms => format!("Root of the mean square over time: {output}"),
            Kind::Last => format!("Value at the end: {output}"),
            Kind::Count => format!("Growth over the window: {output}"),
            Kind::At(angle) => {
                format!(
                    "Value where the shaft last passes {} degrees: {output}",
                    crate::text::digits(angle.to_degrees(), 12, -4)
                )
            }
            Kind::Harmonic(k) => format!("Amplitude of harmonic {k} of the turn: {output}"),
        }
    }
}

impl fmt::Display for Measure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let output = &self.output;
        match self.kind {
            Kind::Max => write!(f, "max {output}"),
            Kind::Min => write!(f, "min {output}"),
            Kind::Magnitude => write!(f, "max |{output}|"),
            Kind::Range => write!(f, "range {output}"),
            Kind::Mean => write!(f, "mean {output}"),
            Kind::Rms => write!(f, "rms {output}"),
            Kind::Last => write!(f, "last {output}"),
            Kind::Count => write!(f, "count {output}"),
            Kind::At(angle) => write!(f, "{output} at {} deg", crate::text::digits(angle.to_degrees(), 12, -4)),
            Kind::Harmonic(k) => write!(f, "harmonic {k} of {output}"),
        }
    }
}

/// The data gathered so far for a measure.
#[derive(Clone, Copy, Debug)]
pub struct Gathered {
    kind: Kind,
    /// Greatest value of f and of −f.
    extremes: [f64; 2],
    /// ∫ f dt or ∫ f² dt.
    sum: f64,
    line: Complex64,
    /// The first and the last value.
    ends: [f64; 2],
    at: Option<f64>,
    time: f64,
    /// Accuracy of the angle (rad).
    reach: f64,
}

impl Gathered {
    /// No data yet, with an angle accurate to `reach` (rad).
    pub fn new(kind: Kind, reach: f64) -> Self {
        let extremes = [f64::NEG_INFINITY; 2];
        let ends = [f64::NAN; 2];
        Gathered { kind, extremes, sum: 0.0, line: Complex64::ZERO, ends, at: None, time: 0.0, reach }
    }

    /// Adds a piece of the output over `step` (s), with the shaft's angle.
    pub fn add(&mut self, output: &Piece, angle: &Piece, step: f64) {
        let [greatest, least] = &mut self.extremes;
        match self.kind {
            Kind::Max => *greatest = output.above(1.0, *greatest),
            Kind::Min => *least = output.above(-1.0, *least),
            Kind::Magnitude => *greatest = output.above(-1.0, output.above(1.0, *greatest)),
            Kind::Range => (*greatest, *least) = (output.above(1.0, *greatest), output.above(-1.0, *least)),
            Kind::Mean => self.sum += output.mean() * step,
            Kind::Rms => self.sum += output.mean_square() * step,
            Kind::At(phi) => {
                // The last passage in (from, to], both moved by the accuracy of the angle: in a window over whole turns the end
                // counts, not the beginning.
                let sense = (angle.0[5] - angle.0[0]).signum();
                let [from, to] = [angle.0[0], angle.0[5]].map(|end| sense * (end - phi) + self.reach);
                let last = (to / TAU).floor() * TAU;
                if last > from {
                    self.at = Some(output.at(angle.crossing(phi + sense * last).unwrap_or(1.0)));
                }
            }
            Kind::Harmonic(k) => {
                let part =
                    |of: fn(f64) -> f64| output.mean_of(|z, f| f * of(f64::from(k) * angle.at(z)) * angle.slope(z));
                self.line += Complex64::new(part(f64::cos), -part(f64::sin));
            }
            Kind::Last | Kind::Count => (),
        }
        self.time += step;
        self.end(output.0[0], output.0[5]);
    }

    /// Adds the values at the ends of a span.
    pub fn end(&mut self, first: f64, last: f64) {
        if self.ends[0].is_nan() {
            self.ends[0] = first;
        }
        self.ends[1] = last;
    }

    /// The measure, after this turn of the shaft (rad); None if the shaft never passed the angle.
    pub fn value(&self, turned: f64) -> Option<f64> {
        let [greatest, least] = self.extremes;
        match self.kind {
            Kind::Max | Kind::Magnitude => Some(greatest),
            Kind::Min => Some(-least),
            Kind::Range => Some(greatest + least),
            Kind::Mean => Some(self.sum / self.time),
            Kind::Rms => Some((self.sum / self.time).sqrt()),
            Kind::Last => Some(self.ends[1]),
            Kind::Count => Some(self.ends[1] - self.ends[0]),
            Kind::At(_) => self.at,
            Kind::Harmonic(_) => Some(2.0 * self.line.norm() / turned.abs()),
        }
    }
}
