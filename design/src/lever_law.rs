//! The law of the lever that makes a tool move as prescribed: the mechanisms between them backwards.
//!
//! χ(φ) = f⁻¹(y(φ)), χ′ = y′/f′, χ″ = (y″ − f″χ′²)/f′.
//!
//! If y is a finite Fourier series, χ is analytic and periodic, so its harmonics fall geometrically; the series ends at
//! rounding level. If y consists of pieces (standard laws, tables), χ consists of polynomials of degree 5 through χ, χ′, χ″ at
//! their ends, as many as the accuracy needs; dwells and jumps of the acceleration are kept. The remaining error of the tool's
//! acceleration is measured.

pub mod inverse;

use crate::harmonic_analysis::analyse;
use crate::table_error::told;
use crate::text::counted;
use camdrive::drives::rigid_machine::linkage::{Linkage, Mechanism, decimals, in_turn};
use camdrive::motion::fourier::HIGHEST_HARMONIC;
use camdrive::motion::table::{Bend, MOST_POINTS, Points, within};
use camdrive::motion::{Fourier, MotionLaw, Table};
use inverse::{Obstacle, inputs};
use std::f64::consts::TAU;

/// Positions at which the mechanisms are inverted: four for the shortest wave, so that its aliases are beyond
/// [`HIGHEST_HARMONIC`].
const POSITIONS: usize = 1024;

/// The wanted error of the tool's acceleration, relative to its largest value. Laws that need more harmonics or pieces than
/// allowed have a tool near a dead centre.
const FINE: f64 = 1e-9;

/// The admissible error of pieces, which is reported: roundings of the lever's angle determine it in short pieces.
const COARSEST: f64 = 1e-7;

/// The part of the largest acceleration that the omitted harmonics may have together.
const REST: f64 = 1e-13;

/// The least number of pieces over a turn. Longer ones are better than shorter ones as long as they suffice: the rounding of χ
/// counts in χ″ like 1/width².
const PIECES: f64 = 36.0;

/// The mechanisms are followed in steps of at most this angle (rad), so that they do not change to their other position.
const STEP: f64 = TAU / 720.0;

/// Places within a piece at which its error is measured, as part of its width: the maxima of the error of a quintic's
/// curvature, which follows the second derivative of x³(1 − x)³.
const WITHIN: [f64; 3] = [0.13, 0.5, 0.87];

/// The lever's law.
#[derive(Clone, Debug, PartialEq)]
pub struct LeverLaw {
    /// χ(φ) (rad).
    pub law: MotionLaw,
    /// max |y″ − y″_wanted| / max |y″_wanted| over the turn.
    pub error: f64,
}

impl LeverLaw {
    /// Its parts.
    pub fn parts(&self) -> String {
        match &self.law {
            MotionLaw::Fourier(series) => counted(series.order(), "harmonic"),
            law => format!("{} of degree 5", counted(law.breakpoints().len(), "piece")),
        }
    }
}

/// The law with which the tool of `linkage` moves as `tool`, beginning next to the lever's angle `near` (rad).
///
/// # Errors
/// A sentence that names the angle and the mechanism that prevents it.
pub fn lever_law(linkage: &Linkage, tool: &MotionLaw, near: f64) -> Result<LeverLaw, String> {
    let [at_near] = linkage.tool([near]);
    if !at_near.is_finite() {
        return Err(format!(
            "the mechanisms cannot be assembled at the lever's angle {} deg, near the start of its motion",
            decimals(near.to_degrees(), 4)
        ));
    }
    let way = Way { linkage, tool, near, at_near };
    let (law, most) = match tool {
        MotionLaw::Fourier(series) => (MotionLaw::Fourier(way.series(series)?), FINE),
        _ => (MotionLaw::Table(way.pieces()?), COARSEST),
    };
    let law = LeverLaw { error: way.error(&law), law };
    if law.error > most || law.error.is_nan() {
        return Err(format!(
            "a law of {} for the lever leaves an error of {:.1e} of the tool's acceleration, more than {most:e}: the motion comes too close to a dead centre",
            law.parts(),
            law.error
        ));
    }
    Ok(law)
}

/// Back from the tool to the lever.
struct Way<'a> {
    linkage: &'a Linkage,
    tool: &'a MotionLaw,
    /// The lever's approximate angle at the beginning of the motion, and the tool's place there.
    near: f64,
    at_near: f64,
}

impl Way<'_> {
    /// χ for the tool at `wanted`, at φ, next to the position with these `inputs`.
    fn lever_at(&self, phi: f64, wanted: f64, inputs: &mut [f64]) -> Result<f64, String> {
        inverse::lever_at(self.linkage, wanted, inputs).map_err(|obstacle| {
            let (mechanism, output, what) = match obstacle {
                Obstacle::OutOfReach { mechanism, output } => (mechanism, output, "cannot reach the output"),
                Obstacle::DeadCentre { mechanism, output } => (mechanism, output, "is at a dead centre at the output"),
            };
            // The tool's coordinate is the output of the last mechanism.
            let with_unit = |mechanism: &Mechanism, output: f64| match mechanism.output_turns() {
                true => format!("{} deg", decimals(output.to_degrees(), 4)),
                false => format!("{} m", decimals(output, 6)),
            };
            let tool = |position: f64| self.linkage.0.last().map_or(String::new(), |last| with_unit(last, position));
            format!(
                "at phi = {} deg the tool should be at {}, but mechanism {} {what} {} (the lever at {} deg puts the tool at {})",
                in_turn(phi, 4),
                tool(wanted),
                mechanism + 1,
                with_unit(&self.linkage.0[mechanism], output),
                decimals(self.near.to_degrees(), 4),
                tool(self.at_near)
            )
        })
    }

    /// Refuses a lever that has made a full turn and comes back to another angle.
    fn comes_back(&self, first: f64, last: f64) -> Result<(), String> {
        if (first - last).abs() <= 1e-9 * (1.0 + first.abs()) {
            return Ok(());
        }
        let away = decimals((last - first).to_degrees(), 4);
        Err(format!("the lever would not come back after a turn: it ends {away} deg away from where it began"))
    }

    /// The finite series of χ.
    fn series(&self, tool: &Fourier) -> Result<Fourier, String> {
        let mut inputs = inputs(self.linkage, self.near);
        let mut angles = Vec::with_capacity(POSITIONS);
        let mut lifts = Vec::with_capacity(POSITIONS);
        for i in 0..=POSITIONS {
            let phi = TAU * i as f64 / POSITIONS as f64;
            lifts.push(self.lever_at(phi, tool.at(phi).0[0], &mut inputs)?);
            angles.push(phi);
        }
        self.comes_back(lifts[0], lifts[POSITIONS])?;
        angles.pop();
        lifts.pop();
        let full = analyse(Points { angles, lifts }, HIGHEST_HARMONIC).map_err(|e| told(&e))?.series;
        let weight = |k: usize| (k * k) as f64 * (full.a[k].powi(2) + full.b[k].powi(2)).sqrt();
        let largest = (1..=HIGHEST_HARMONIC).map(weight).fold(f64::MIN_POSITIVE, f64::max);
        // Harmonics at rounding level are no motion, though their number enlarges them in the acceleration.
        let rounding = f64::EPSILON * full.a.iter().chain(&full.b).fold(0.0, |m: f64, c| m.max(c.abs()));
        let mut rest = 0.0;
        let order = (1..=HIGHEST_HARMONIC)
            .rev()
            .find(|k| {
                rest += weight(*k);
                rest > REST * largest && weight(*k) > rounding * (k * k) as f64
            })
            .unwrap_or(1);
        Ok(Fourier::new(full.a[..=order].to_vec(), full.b[..=order].to_vec()))
    }

    /// The pieces of χ: the segments of the tool's law, each in as many parts as the accuracy needs.
    fn pieces(&self) -> Result<Table, String> {
        let borders = self.tool.breakpoints();
        let first = *borders.first().ok_or("the law of the tool has no pieces")?;
        let peak = self.peak();
        let mut inputs = inputs(self.linkage, self.near);
        let mut points = Points { angles: Vec::new(), lifts: Vec::new() };
        let mut bends: Vec<Bend> = Vec::new();
        let mut end = Bend::default();
        for (i, low) in borders.iter().enumerate() {
            let high = borders.get(i + 1).copied().unwrap_or(first + TAU);
            let still = self.tool.bound_in(i, 1) == 0.0;
            let mut count = if still { 1 } else { ((high - low) * PIECES / TAU).ceil().max(1.0) as usize };
            let mut best: Option<(f64, Part)> = None;
            loop {
                let part = self.part(i, [*low, high], count, inputs.clone())?;
                let miss = self.miss(i, &part);
                // Finer pieces are worth their points as long as roundings do not dominate.
                let better = best.as_ref().is_none_or(|(least, _)| miss < 0.5 * least);
                if better {
                    best = Some((miss, part));
                }
                count *= 2;
                if !better || still || miss <= 0.2 * FINE * peak || points.angles.len() + count > MOST_POINTS {
                    break;
                }
            }
            let Some((_, part)) = best else { break };
            for (k, at) in part.ends.iter().enumerate().take(part.ends.len() - 1) {
                let before = if k == 0 { end.before } else { at.bend.before };
                points.angles.push(at.phi);
                points.lifts.push(at.lever);
                bends.push(Bend { before, ..at.bend });
            }
            (inputs, end) = (part.inputs, part.ends[part.ends.len() - 1].bend);
        }
        let first_bend = bends.first_mut().ok_or("the law of the tool has no pieces")?;
        first_bend.before = end.before;
        let last = inputs.first().copied().unwrap_or(points.lifts[0]);
        self.comes_back(points.lifts[0], last)?;
        points.angles.push(first + TAU);
        points.lifts.push(points.lifts[0]);
        Table::bent(points, bends).map_err(|e| told(&e))
    }

    /// The segment of the tool's law between these angles in `count` parts, from the position with these `inputs` on.
    fn part(&self, segment: usize, [low, high]: [f64; 2], count: usize, mut inputs: Vec<f64>) -> Result<Part, String> {
        let mut ends = Vec::with_capacity(count + 1);
        let width = (high - low) / count as f64;
        let steps = (width / STEP).ceil().max(1.0);
        for k in 0..=count {
            let phi = if k == count { high } else { low + width * k as f64 };
            for step in (1..steps as usize).take_while(|_| k > 0) {
                let between = phi - width * (1.0 - step as f64 / steps);
                self.lever_at(between, self.tool.at_in(segment, between).0[0], &mut inputs)?;
            }
            let [y, y1, y2, ..] = self.tool.at_in(segment, phi).0;
            let lever = self.lever_at(phi, y, &mut inputs)?;
            let [_, f1, f2] = self.linkage.tool([lever, 1.0, 0.0]);
            let slope = y1 / f1;
            let curvature = (y2 - f2 * slope * slope) / f1;
            ends.push(End { phi, lever, bend: Bend { slope, before: curvature, behind: curvature } });
        }
        Ok(Part { ends, inputs })
    }

    /// max |y″ − y″_wanted| between the ends of the parts.
    fn miss(&self, segment: usize, part: &Part) -> f64 {
        let mut missed = 0.0_f64;
        for pair in part.ends.windows(2) {
            let [start, end] = pair else { continue };
            let width = end.phi - start.phi;
            let [from, to] = [start, end].map(|end| [end.lever, end.bend.slope, end.bend.behind]);
            for x in WITHIN {
                let wanted = self.tool.at_in(segment, start.phi + x * width).0[2];
                let [.., actual] = self.linkage.tool(within(width, from, to, x));
                missed = worse(missed, (actual - wanted).abs());
            }
        }
        missed
    }

    /// max |y″_wanted|; the place for a tool that stands still.
    fn peak(&self) -> f64 {
        let at = |i: usize| self.tool.at(TAU * (i as f64 + 0.3) / (4 * POSITIONS) as f64).0;
        let [place, acceleration] = [0, 2].map(|n| (0..4 * POSITIONS).map(|i| at(i)[n].abs()).fold(0.0, f64::max));
        acceleration.max(1e-6 * place).max(f64::MIN_POSITIVE)
    }

    /// max |y″ − y″_wanted| / max |y″_wanted|, also between the positions of the analysis.
    fn error(&self, lever: &MotionLaw) -> f64 {
        let own: Vec<f64> = (0..4 * POSITIONS).map(|i| TAU * (i as f64 + 0.3) / (4 * POSITIONS) as f64).collect();
        let borders = lever.breakpoints();
        let inside = borders.iter().enumerate().flat_map(|(i, low)| {
            let high = borders.get(i + 1).copied().unwrap_or(borders[0] + TAU);
            WITHIN.map(|x| low + x * (high - low))
        });
        let miss = |phi: f64| {
            let phi = if phi > TAU { phi - TAU } else { phi };
            let [u, u1, u2, ..] = lever.at(phi).0;
            let [.., actual] = self.linkage.tool([u, u1, u2]);
            (actual - self.tool.at(phi).0[2]).abs()
        };
        own.into_iter().chain(inside).map(miss).fold(0.0, worse) / self.peak()
    }
}

/// χ and its derivatives at the end of a piece.
struct End {
    phi: f64,
    lever: f64,
    bend: Bend,
}

/// The ends of the pieces of a segment, and the inputs of the mechanisms at the last one.
struct Part {
    ends: Vec<End>,
    inputs: Vec<f64>,
}

/// Not the maximum of two numbers, which would drop NaN.
fn worse(missed: f64, miss: f64) -> f64 {
    if miss <= missed { missed } else { miss }
}

#[cfg(test)]
mod tests {
    use super::*;
    use camdrive::drives::rigid_machine::linkage::{Branch, FourBar, Gear, Kind, Link, SliderCrank};
    use camdrive::motion::{Cycle, CyclePlan, StandardLaw};

    fn bar(length: f64) -> Link {
        Link { length, ..Link::default() }
    }

    /// A gear, a four-bar linkage and a slider-crank in a row.
    pub fn chain() -> Linkage {
        let four_bar =
            FourBar { ground: 0.10, input: bar(0.03), coupler: bar(0.09), output: bar(0.06), branch: Branch::Plus };
        let slider =
            SliderCrank { crank: bar(0.05), rod: bar(0.16), offset: 0.02, slider_mass: 0.0, branch: Branch::Plus };
        let part = |kind, [input_offset, output_offset]: [f64; 2]| Mechanism { kind, input_offset, output_offset };
        Linkage(vec![
            part(Kind::Gear(Gear { ratio: -0.8, inertia: 0.0, output_turns: true }), [0.1, 0.0]),
            part(Kind::FourBar(four_bar), [1.9, 1.7]),
            part(Kind::SliderCrank(slider), [1.2, 0.05]),
        ])
    }

    fn cycle(law: StandardLaw, lower: f64, stroke: f64) -> MotionLaw {
        MotionLaw::Cycle(Cycle::new(CyclePlan {
            stroke,
            lower,
            rise_start: 0.4,
            rise_angle: 1.3,
            upper_dwell: 0.9,
            return_angle: 1.8,
            rise_law: law,
            return_law: StandardLaw::ModifiedSine,
            inflections: [None; 2],
        }))
    }

    /// Where the tool is with the lever at −0.6 and at 0.4.
    fn places(chain: &Linkage) -> [f64; 2] {
        [-0.6, 0.4].map(|lever| chain.tool([lever])[0])
    }

    #[test]
    fn the_tool_moves_by_any_law_as_prescribed() {
        let chain = chain();
        let [low, high] = places(&chain);
        let smooth: Vec<f64> = (0..90).map(|i| TAU * f64::from(i) / 90.0).collect();
        let lifts =
            smooth.iter().map(|phi| low + 0.5 * (high - low) * (1.0 - phi.cos()) * (0.8 + 0.2 * phi.sin())).collect();
        let table = MotionLaw::Table(Table::new(Points { angles: smooth, lifts }).unwrap());
        let laws = [
            cycle(StandardLaw::InclinedSine, low, high - low),
            cycle(StandardLaw::Polynomial345, low, high - low),
            // Its acceleration jumps at the ends of the rise.
            cycle(StandardLaw::SimpleSine, low, high - low),
            cycle(StandardLaw::ModifiedTrapezoid, high, low - high),
            table,
        ];
        for tool in laws {
            let found = lever_law(&chain, &tool, -0.6).unwrap();
            assert!(found.error <= 1e-9, "{:e}", found.error);
            let pieces = found.law.breakpoints().len();
            assert!((100..3000).contains(&pieces), "{pieces}");
            let peak = (0..3600).map(|i| tool.at(TAU * f64::from(i) / 3600.0).0[2].abs()).fold(0.0, f64::max);
            let place = (high - low).abs();
            for i in 0..3571 {
                // One-sided values too, at the breakpoints of the tool's law.
                let phi = TAU * f64::from(i) / 3571.0;
                for forward in [true, false] {
                    let [u, u1, u2, ..] = found.law.at_in(found.law.segment(phi, forward), phi).0;
                    let got = chain.tool([u, u1, u2]);
                    let wanted = tool.at_in(tool.segment(phi, forward), phi).0;
                    assert!((got[0] - wanted[0]).abs() < 1e-11 * place && (got[1] - wanted[1]).abs() < 1e-10 * place);
                    assert!((got[2] - wanted[2]).abs() < 1.5e-9 * peak, "{phi}: {} {}", got[2], wanted[2]);
                }
            }
        }
    }

    #[test]
    fn dwells_stay_dwells_and_jumps_stay_jumps() {
        let chain = chain();
        let [low, high] = places(&chain);
        let tool = cycle(StandardLaw::SimpleSine, low, high - low);
        let law = lever_law(&chain, &tool, -0.6).unwrap().law;
        // The upper dwell from 1.7 to 2.6 is one piece.
        let dwell = law.segment(2.0, true);
        assert_eq!(dwell, law.segment(1.7 + 1e-9, true));
        assert_eq!(dwell, law.segment(2.6 - 1e-9, true));
        assert!((1..5).all(|n| law.at(2.0).0[n].abs() < 1e-12));
        // At the start of the rise the tool's acceleration jumps by (π/β)² h/2.
        let of = |forward: bool| {
            let [u, u1, u2, ..] = law.at_in(law.segment(0.4, forward), 0.4).0;
            chain.tool([u, u1, u2])[2]
        };
        let jump = 0.5 * (high - low) * (0.5 * TAU / 1.3).powi(2);
        assert!((of(true) - of(false) - jump).abs() < 1e-10 * jump.abs());
    }

    #[test]
    fn a_tool_beyond_its_mechanisms_is_refused_with_the_angle() {
        let chain = chain();
        let [low, high] = places(&chain);
        let refusal =
            |stroke: f64| lever_law(&chain, &cycle(StandardLaw::InclinedSine, low, stroke), -0.6).unwrap_err();
        let far = refusal(20.0 * (high - low));
        assert!(far.starts_with("at phi = ") && far.contains("cannot reach the output"), "{far}");
        assert!(!far.contains("-0.0000 deg"));
    }
}
