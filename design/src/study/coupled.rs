//! A run of a study over coupled FMUs, measured from one communication point to the next.
//!
//! Over a step h an output is a polynomial from the FMU's values at both ends: of degree five with two derivatives, cubic with
//! one, else the straight line, whose extremes are the points'. For smooth f its error is at most h⁶ max |f⁽⁶⁾| / 46080, h⁴ max
//! |f⁗| / 384 or h² max |f″| / 8. An event within a step, such as an impact, shows only by its effect at the end. An output
//! that is constant between events has the value at the end of the step.
//!
//! Steps keep their length, except the last one of a window in time if all FMUs take steps of any length.

use super::measure::{Gathered, Measure};
use super::piece::{Jet, Piece};
use super::run::{HARMONIC, Outputs, PHI, Window, highest_harmonic, values};
use crate::coupling::exchange::Coupling;
use crate::host::ModelDescription;
use crate::text::number;
use camdrive::drives::variable::{Causality, Kind as Type, Variability};
use camdrive::drives::{Description, Fault, Number};

/// The data that a study needs of coupled FMUs.
pub struct Runner<'a> {
    window: &'a Window,
    measures: &'a [Measure],
    /// The index of each measure's output among the followed ones.
    outputs: Vec<usize>,
    /// The angle first if it matters.
    followed: Vec<Followed>,
}

/// An output whose course matters.
struct Followed {
    part: usize,
    place: usize,
    reference: u32,
    /// The number of derivatives that its FMU provides, 2 at most.
    order: usize,
    /// True if it is constant between events.
    is_discrete: bool,
    /// Its unit in SI, and the SI value of zero.
    unit: [f64; 2],
}

/// This part of a step is rounding.
const ROUNDING: f64 = 1e-6;

/// Accuracy of the angles of passages (rad): far above rounding, far below the error of a step.
const REACH: f64 = 1e-9;

impl<'a> Runner<'a> {
    /// A runner for these measures of coupled FMUs with all these variables; `places` has the part of each and its index there.
    ///
    /// # Errors
    /// An output that does not exist or cannot be measured like this, or a missing angle.
    pub fn new(
        places: &[(usize, usize)],
        all: &[Description],
        description: impl Fn(usize) -> &'a ModelDescription,
        window: &'a Window,
        measures: &'a [Measure],
    ) -> Result<Self, Fault> {
        let own = |i: usize| &description(places[i].0).variables[places[i].1];
        let phi = || {
            let is_angle = |i: &usize| own(*i).about.name == PHI && all[*i].causality == Causality::Output;
            let angles: Vec<usize> = (0..all.len()).filter(is_angle).collect();
            match angles[..] {
                [phi] => Ok(phi),
                _ => Err(Fault::new(format!(
                    "turns and angles need exactly one output phi; this system has {}",
                    angles.len()
                ))
                .hint("give `time`")),
            }
        };
        let input = |i: &usize| own(*i).about.causality == Causality::Input && all[*i].causality != Causality::Input;
        let taken = |measure: &&Measure| (0..all.len()).filter(input).any(|i| all[i].name == measure.output);
        if let Some(measure) = measures.iter().find(taken) {
            let name = &measure.output;
            let hint = "measure the output that it is connected to";
            return Err(Fault::new(format!("`{measure}`: `{name}` is an input")).hint(hint));
        }
        let Outputs { measured, followed, .. } = Outputs::new(all, phi, window, measures, |_| true)?;
        let of = |i: usize| {
            let ((part, place), variable) = (places[i], own(i));
            let is_real = matches!(variable.about.kind, Type::Real { .. });
            let is_discrete = !is_real || variable.about.variability != Variability::Continuous;
            let is_told = !is_discrete && variable.about.causality == Causality::Output;
            let order = if is_told { description(part).capabilities.output_derivatives.min(2) } else { 0 };
            let unit = [variable.unit.factor, variable.unit.offset];
            Followed { part, place, reference: variable.reference, order, is_discrete, unit }
        };
        let outputs = measured.iter().filter_map(|(_, place)| *place).collect();
        Ok(Runner { window, measures, outputs, followed: followed.into_iter().map(of).collect() })
    }

    /// The measures of FMUs that were started at `start` (s), in their order, with communication steps of `step` (s), and the
    /// reason if an FMU ends the simulation before the window does. Harmonics need whole turns and are then missing.
    ///
    /// # Errors
    /// The fault of a part, with its name and the time; measures that the motion does not have.
    pub fn run(&self, coupling: &mut Coupling, start: f64, step: f64) -> Result<(Vec<f64>, Option<String>), Fault> {
        let is_free = (0..coupling.count()).all(|part| coupling.description(part).capabilities.variable_steps);
        let before = self.followed.iter().map(|of| of.jet(coupling)).collect::<Result<Vec<_>, _>>()?;
        let first = [start, before[0][0]];
        let (gathered, rest) = (Vec::new(), None);
        let mut course =
            Course { runner: self, coupling, is_free, start, step, count: 0, time: start, before, rest, gathered };
        let begin = self.window.settle.follow(first, f64::INFINITY, &mut course)?;
        let reach = REACH + 64.0 * f64::EPSILON * first[1].abs();
        course.gathered = self.measures.iter().map(|measure| Gathered::new(measure.kind, reach)).collect();
        for (gathered, output) in course.gathered.iter_mut().zip(&self.outputs) {
            let value = course.rest.as_ref().map_or(course.before[*output][0], |(_, pieces)| pieces[*output].0[0]);
            gathered.end(value, value);
        }
        let done = self.window.over.follow(begin, f64::INFINITY, &mut course);
        let Course { coupling, time, before, gathered, .. } = course;
        let measured = |angle: f64| values(&gathered, self.measures, angle - begin[1]);
        match done {
            Ok([_, angle]) => measured(angle).map(|measured| (measured, None)),
            Err(fault) if time > begin[0] && coupling.has_ended() && highest_harmonic(self.measures) == 0 => {
                let until = format!("{}; measured up to t = {} s", fault.message, Number(time));
                measured(before[0][0]).map(|measured| (measured, Some(until))).map_err(|_| fault)
            }
            Err(fault) => Err(fault),
        }
    }
}

/// The course of coupled FMUs.
struct Course<'a> {
    runner: &'a Runner<'a>,
    coupling: &'a mut Coupling,
    /// True if all of them take steps of any length.
    is_free: bool,
    /// The start of the run, and its step (s).
    start: f64,
    step: f64,
    count: u64,
    /// The current time (s), and the outputs there.
    time: f64,
    before: Vec<Jet>,
    /// The rest of the last step after the end of a span (s).
    rest: Option<(f64, Vec<Piece>)>,
    /// The gathered data of each measure; empty before the window.
    gathered: Vec<Gathered>,
}

impl super::run::Course for Course<'_> {
    fn next(&mut self, stop: f64, pieces: &mut Vec<Piece>) -> Result<[f64; 2], Fault> {
        if let Some((from, rest)) = self.rest.take() {
            *pieces = rest;
            return Ok([from, self.time]);
        }
        let (time, step) = (self.time, self.step);
        self.count += 1;
        let mut next = self.start + self.count as f64 * step;
        let is_short = !self.gathered.is_empty() && self.is_free && stop < next;
        next = if is_short || (stop - next).abs() < ROUNDING * step { stop } else { next };
        let advanced = self.coupling.advance(time, next - time);
        advanced.map_err(|fault| fault.within(format_args!("from t = {} s to {} s", Number(time), Number(next))))?;
        pieces.clear();
        for (of, before) in self.runner.followed.iter().zip(&mut self.before) {
            let after = of.jet(self.coupling);
            let after = after.map_err(|fault| fault.within(format_args!("at t = {} s", Number(next))))?;
            pieces.push(of.piece([std::mem::replace(before, after), after], next - time));
        }
        self.time = next;
        Ok([time, next])
    }

    fn take(&mut self, pieces: &[Piece], time: f64) -> Result<(), Fault> {
        if self.gathered.is_empty() {
            return Ok(());
        }
        let harmonic = highest_harmonic(self.runner.measures);
        let turned = (pieces[0].0[5] - pieces[0].0[0]).abs();
        if f64::from(harmonic) * turned > HARMONIC {
            let [turned, most] = [turned, HARMONIC / f64::from(harmonic)].map(number);
            return Err(Fault::new(format!(
                "the shaft turns {turned} rad in a step; harmonic {harmonic} needs at most {most} rad"
            ))
            .hint("take a shorter `step`"));
        }
        let outputs = self.gathered.iter_mut().zip(&self.runner.outputs);
        outputs.for_each(|(of, output)| of.add(&pieces[*output], &pieces[0], time));
        Ok(())
    }

    fn part(&mut self, [_, at]: [f64; 2], rest: Vec<Piece>) -> Result<bool, Fault> {
        self.rest = Some((at, rest));
        Ok(false)
    }
}

impl Followed {
    /// Value and known derivatives in SI.
    fn jet(&self, coupling: &mut Coupling) -> Result<Jet, Fault> {
        let host = &mut coupling.parts()[self.part];
        let [factor, offset] = self.unit;
        let value = host.get(self.place)?;
        if !value.is_finite() {
            let name = &host.description().variables[self.place].about.name;
            return Err(Fault::named(name, format!(" is {value}, which is no result")));
        }
        let mut derivatives = [0.0; 2];
        if self.order > 0 {
            let known = ..self.order;
            let references = [self.reference; 2];
            host.get_output_derivatives(&references[known], &[1, 2][known], &mut derivatives[known])?;
        }
        // Bitwise equal if the unit is SI.
        let value = if self.unit == [1.0, 0.0] { value } else { factor * value + offset };
        Ok([value, factor * derivatives[0], factor * derivatives[1]])
    }

    /// The course over a step (s) from the data at its ends.
    fn piece(&self, [mut first, mut last]: [Jet; 2], step: f64) -> Piece {
        // A derivative that is not finite is ignored.
        let known = |jet: &Jet| jet[1..].iter().take_while(|derivative| derivative.is_finite()).count();
        match self.order.min(known(&first)).min(known(&last)) {
            _ if self.is_discrete => Piece::constant(last[0]),
            0 => Piece::line(first[0], last[0]),
            1 => {
                // The second derivatives of the cubic.
                let (mean, [from, to]) = ((last[0] - first[0]) / step, [first[1], last[1]]);
                first[2] = (6.0 * mean - 4.0 * from - 2.0 * to) / step;
                last[2] = (2.0 * from + 4.0 * to - 6.0 * mean) / step;
                Piece::new(first, last, step)
            }
            _ => Piece::new(first, last, step),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::coupling::variables::variables;
    use crate::host::Fmu;
    use crate::resource::Resource;
    use crate::study::run::Span;
    use camdrive::drives::rigid_machine::{InertiaFunction, MachineStart, Motor, Scene};
    use camdrive::drives::settings::Settings;
    use std::f64::consts::PI;

    /// J = 2 kg·m² at 3 rad/s under the torque M (N·m).
    fn flywheel(torque: f64, step: f64, window: &Window, texts: &[&str]) -> Result<Vec<f64>, String> {
        let scene = Scene {
            loads: vec![Default::default()],
            inertia: InertiaFunction { constant: 2.0, varying: None },
            followers: Vec::new(),
            motor: Motor::Input,
            phi_start: 0.0,
            w_start: 3.0,
            start: MachineStart::Given,
            solver: Settings::default(),
        };
        let fmu = Fmu::linked(&Resource { guid: "{1}".into(), ..Resource::new("flywheel", scene) }).unwrap();
        let (places, all) = variables([("shaft", fmu.description())], |_, _| false);
        let measures: Vec<Measure> = texts.iter().map(|text| Measure::parse(text).unwrap()).collect();
        let runner = Runner::new(&places, &all, |_| fmu.description(), window, &measures);
        let runner = runner.map_err(|fault| fault.to_string())?;
        let mut host = fmu.instantiate("flywheel").unwrap();
        host.set(fmu.description().find("M_an").unwrap(), torque).unwrap();
        let mut coupling = Coupling::alone("shaft", host).unwrap();
        coupling.begin(0.0, None).and_then(|()| coupling.start()).unwrap();
        runner.run(&mut coupling, 0.0, step).map(|(measured, _)| measured).map_err(|fault| fault.to_string())
    }

    /// φ = 3 t + M t²/4 at a time, and ω.
    fn motion(torque: f64, time: f64) -> [f64; 2] {
        [3.0 * time + torque * time * time / 4.0, 3.0 + torque * time / 2.0]
    }

    /// When φ is so large.
    fn when(torque: f64, phi: f64) -> f64 {
        2.0 / torque * ((9.0 + torque * phi).sqrt() - 3.0)
    }

    fn assert_near(found: &[f64], expected: &[f64]) {
        let near = |(a, b): (&f64, &f64)| (a - b).abs() < 1e-9 * b.abs().max(1.0);
        assert!(found.len() == expected.len() && found.iter().zip(expected).all(near), "{found:?} {expected:?}");
    }

    #[test]
    fn windows_of_turns_begin_and_end_within_steps() {
        let torque = 4.0;
        let window = Window { settle: Span::Turns(0.25), over: Span::Turns(2.0), accuracy: 1e-6 };
        let texts =
            ["last shaft.phi", "min shaft.w", "max shaft.w", "mean shaft.w", "shaft.w at 90 deg", "range shaft.phi"];
        let [begin, end] = [when(torque, PI / 2.0), when(torque, 4.5 * PI)];
        let speeds = [motion(torque, begin)[1], motion(torque, end)[1]];
        // The end of the window passes 90 degrees, its beginning does not count.
        let expected = [4.5 * PI, speeds[0], speeds[1], 4.0 * PI / (end - begin), speeds[1], 4.0 * PI];
        for step in [0.01, 0.137, 0.5] {
            assert_near(&flywheel(torque, step, &window, &texts).unwrap(), &expected);
        }
    }

    #[test]
    fn windows_of_time_end_at_points_or_within_steps() {
        for (settle, over, step) in [(0.0, 0.3, 0.1), (0.25, 0.35, 0.1), (0.01, 0.02, 0.5)] {
            let window = Window { settle: Span::Time(settle), over: Span::Time(over), accuracy: 1e-6 };
            let [begin, end] = [settle, settle + over].map(|time| motion(-4.0, time));
            let expected = [end[1], begin[1], (end[0] - begin[0]) / over];
            let found = flywheel(-4.0, step, &window, &["last shaft.w", "max |shaft.w|", "mean shaft.w"]);
            assert_near(&found.unwrap(), &expected);
        }
    }

    #[test]
    fn a_step_with_much_of_a_harmonic_is_told() {
        let turns = |turns| Window { settle: Span::Time(0.0), over: Span::Turns(turns), accuracy: 1e-6 };
        let fault = flywheel(0.0, 0.5, &turns(1.0), &["harmonic 2 of shaft.w"]).unwrap_err();
        assert!(fault.contains("turns 1.5 rad in a step; harmonic 2 needs at most 0.75 rad"), "{fault}");
        let fault = flywheel(0.0, 0.5, &turns(0.5), &["harmonic 2 of shaft.w"]).unwrap_err();
        assert!(fault.contains("whole number of `turns`"), "{fault}");
    }

    #[test]
    fn the_order_of_a_piece_is_that_of_what_its_ends_tell() {
        let jet = |t: f64| [t.cos(), -t.sin(), -t.cos()];
        for (order, exponent) in [(0, 2), (1, 4), (2, 6)] {
            let of = Followed { part: 0, place: 0, reference: 0, order, is_discrete: false, unit: [1.0, 0.0] };
            let error =
                |step: f64| (of.piece([jet(1.0), jet(1.0 + step)], step).at(0.5) - (1.0 + step / 2.0).cos()).abs();
            let found = (error(0.2) / error(0.1)).log2();
            assert!((found - f64::from(exponent)).abs() < 0.2, "{order}: {found}");
            let bound = 0.2_f64.powi(exponent) / [8.0, 384.0, 46080.0][order];
            assert!(error(0.2) <= bound, "{order}: {} {bound}", error(0.2));
        }
    }
}
