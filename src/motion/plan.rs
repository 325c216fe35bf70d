//! Motion plans after VDI 2143: points on the turn, and the laws that lead from one to the next.
//!
//! At a point the follower rests (R: U′ = U″ = 0), moves at constant velocity (G: U″ = 0), turns (U: U′ = 0) or moves in general
//! (B). Between two points, with the angle β and the lift h, z runs from 0 to 1:
//!
//! | law | U | ends |
//! |---|---|---|
//! | a standard law | v₀ z + (vₘ − v₀) λ H₀(z/λ) up to the inflection λ, mirrored beyond it | R, G, U |
//! | `polynomial_345`, `polynomial_4567` beside R–R | the polynomial of degree 5, 7 through the values at both ends | any |
//! | `polynomial_6` | 10z³ − 15z⁴ + 6z⁵ + k z³(1 − z)³, k = −10 (1 − 2λ)/(1 − 5λ + 5λ²) | R–R |
//! | `cosines` | a₁ (1 − cos πz) + a₂ (1 − cos 2πz) + a₃ (1 − cos 3πz): U″ as given at both ends, U‴ = 0 there | R, U |
//! | `sine` | U″ one hump of two quarter sines | R, G |
//! | `straight` | constant velocity | R, G |
//!
//! H(u) = 2 f(u/2)/C_v is half of the standard law f (of the simple sine if the follower turns), and vₘ = [1 − (1−σ₀) λ v₀ −
//! (1−σ₁)(1−λ) v₁]/[σ₀ λ + σ₁ (1−λ)], σ = 1/C_v, v₀ and v₁ being U′ β/h at the ends.
//!
//! Source: VDI 2143-1; Volmer (ed.), *Getriebetechnik – Kurvengetriebe*, 2nd ed.

use super::StandardLaw;
use super::parameter::{LawParameter, ParameterKind};
use super::pieces::{COEFFICIENTS, Form, Pieces, Shape};
use crate::numerics::number::Rounded;
use serde::{Deserialize, Serialize};
use std::f64::consts::{FRAC_2_PI, FRAC_PI_2, PI, TAU};

/// The range of an inflection, as part of the angle of its segment: outside of it accelerations are fifty times those of the
/// middle.
pub const INFLECTION: [f64; 2] = [0.01, 0.99];

/// With an inflection in this range the polynomial of degree 6 has no other one and does not overshoot.
const INFLECTION_OF_DEGREE_6: [f64; 2] = [0.4, 0.6];

/// With its peak in this range `sine` is the default; outside of it the jerk is ten times that of the middle.
const HUMP: [f64; 2] = [0.05, 0.95];

/// The most points of a plan.
pub const MOST_POINTS: usize = 100;

/// The greatest derivative of U (m/rad, m/rad², m/rad³): its powers do not overflow, and no cam comes near it.
pub const MOST_DERIVATIVE: f64 = 1e12;

/// Velocities with a smaller relative difference are the same, like a straight line's and a velocity written down for it.
const SAME: f64 = 1e-9;

/// The law of a segment.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum SegmentLaw {
    /// A standard law, whole or by halves; a polynomial through the values at the ends if these are no rests.
    Standard(StandardLaw),
    /// The polynomial of degree 6 with an inflection.
    Polynomial6,
    /// U″ of one sign, two quarter sines.
    Sine,
    /// Three cosines between standstills, which meet U″ at both ends with U‴ = 0.
    Cosines,
    /// Constant velocity.
    Straight,
}

use SegmentLaw::{Cosines, Polynomial6, Sine, Standard, Straight};
use StandardLaw::{InclinedSine, ModifiedSine, Polynomial345, Polynomial4567, SimpleSine};

/// A point of a motion plan, with the law that leads to it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PlanPoint {
    /// φ (rad).
    pub phi: f64,
    /// U (m).
    pub u: f64,
    /// U′ (m/rad); by default the velocity of an adjacent straight segment, else 0.
    pub velocity: Option<f64>,
    /// U″ (m/rad²); by default 0.
    pub acceleration: Option<f64>,
    /// Whether U″ follows from the laws on both sides instead.
    pub free: bool,
    /// U‴ (m/rad³), which a polynomial of degree 7 meets.
    pub jerk: Option<f64>,
    /// The law of the segment to this point; by default the standard one for its two ends.
    pub law: Option<SegmentLaw>,
    /// The inflection, as part of the angle; by default the middle, or the inflection that U″ at a turning point requires.
    pub inflection: Option<f64>,
}

/// The least angle of a rise or return (rad): cams are made to about 1e-3 rad, and |U⁗| grows as its fourth power.
pub const LEAST_MOTION: f64 = 1e-3;

/// Largest |U| and |stroke| (m); the range of every length of a cam.
pub const MAX_LENGTH: f64 = 1e4;

/// Largest |U| of a law of any quantity, such as a force (N); its powers with 1 over [`LEAST_MOTION`] do not overflow.
pub const LARGEST: f64 = 1e12;

/// Name, meaning and kind of the values of a point.
const NAMES: [(&str, &str, ParameterKind); 6] = [
    ("phi", "Angle of", ParameterKind::Angle { min: -2.0 * TAU, max: 2.0 * TAU }),
    ("U", "Position at", ParameterKind::Length),
    ("dU", "Velocity dU/dphi at", ParameterKind::Derivative(1)),
    ("ddU", "Acceleration d2U/dphi2 at", ParameterKind::Derivative(2)),
    ("dddU", "Jerk d3U/dphi3 at", ParameterKind::Derivative(3)),
    (
        "inflection",
        "Inflection, where the acceleration changes sign, as part of the angle to",
        ParameterKind::Inflection,
    ),
];

impl PlanPoint {
    /// The given values in the order of [`NAMES`].
    fn values(&mut self) -> [Option<&mut f64>; 6] {
        let PlanPoint { phi, u, velocity, acceleration, jerk, inflection, .. } = self;
        [Some(phi), Some(u), velocity.as_mut(), acceleration.as_mut(), jerk.as_mut(), inflection.as_mut()]
    }
}

/// The reason why points make no plan.
#[derive(Clone, Debug, PartialEq)]
pub struct PlanFault {
    /// The point at fault, from 0; or the one at which the segment at fault ends.
    pub point: usize,
    /// The value at fault: `phi`, `U`, `dU`, `ddU`, `dddU`, `law`, `inflection`.
    pub key: &'static str,
    /// The fault in words.
    pub text: String,
}

impl std::fmt::Display for PlanFault {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "point[{}].{}: {}", self.point + 1, self.key, self.text)
    }
}

/// A motion plan cut into analytic pieces.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(from = "Vec<PlanPoint>", into = "Vec<PlanPoint>")]
pub struct MotionPlan {
    points: Vec<PlanPoint>,
    pub(super) pieces: Pieces,
}

impl From<Vec<PlanPoint>> for MotionPlan {
    fn from(points: Vec<PlanPoint>) -> Self {
        MotionPlan::new(points)
    }
}

impl From<MotionPlan> for Vec<PlanPoint> {
    fn from(plan: MotionPlan) -> Self {
        plan.points
    }
}

impl MotionPlan {
    /// The plan through these points. Points that [`MotionPlan::validate`] refuses leave the follower at rest; such points arise
    /// while parameters are set one after the other.
    pub fn new(points: Vec<PlanPoint>) -> Self {
        let level = points.first().map_or(0.0, |point| point.u);
        let pieces = forms(&points).map_or_else(|_| Pieces::at_rest(level), Pieces::new);
        MotionPlan { points, pieces }
    }

    /// The points.
    pub fn points(&self) -> &[PlanPoint] {
        &self.points
    }

    /// The given values of the points: name, meaning, kind.
    pub fn parameters(&self) -> Vec<LawParameter> {
        let mut points = self.points.clone();
        let values = points.iter_mut().map(|point| NAMES.into_iter().zip(point.values()));
        let given = (1..).zip(values).flat_map(|(i, values)| {
            let given = values.filter(|(_, value)| value.is_some());
            given.map(move |((name, text, kind), _)| LawParameter {
                name: format!("point[{i}].{name}"),
                text: format!("{text} point {i}"),
                kind,
            })
        });
        given.collect()
    }

    /// The value of parameter `index` of [`MotionPlan::parameters`]; 0 beyond the list.
    pub fn parameter(&self, index: usize) -> f64 {
        let values = self.points.iter().flat_map(|&(mut point)| point.values().map(|value| value.map(|value| *value)));
        values.flatten().nth(index).unwrap_or(0.0)
    }

    /// Sets parameter `index`.
    pub fn set_parameter(&mut self, index: usize, value: f64) {
        let mut points = std::mem::take(&mut self.points);
        if let Some(place) = points.iter_mut().flat_map(PlanPoint::values).flatten().nth(index) {
            *place = value;
        }
        *self = MotionPlan::new(points);
    }

    /// Whether the points make a plan.
    pub fn validate(&self) -> Result<(), PlanFault> {
        forms(&self.points).map(|_| ())
    }
}

/// Motion at the beginning and the end of a segment.
#[derive(Clone, Copy, Debug)]
pub struct End {
    /// φ (rad).
    pub phi: f64,
    /// U (m).
    pub u: f64,
    /// U′ (m/rad).
    pub v: f64,
    /// Whether the follower turns there, so that U″ is not 0.
    pub turns: bool,
}

/// A segment by a standard law.
#[derive(Clone, Copy, Debug)]
pub struct Segment {
    /// Its ends.
    pub ends: [End; 2],
    /// β (rad).
    pub angle: f64,
    /// Its law.
    pub law: StandardLaw,
}

impl Segment {
    /// h/β (m/rad).
    fn mean_velocity(&self) -> f64 {
        (self.ends[1].u - self.ends[0].u) / self.angle
    }

    fn halves(&self) -> [StandardLaw; 2] {
        self.ends.map(|end| if end.turns { SimpleSine } else { self.law })
    }

    /// vₘ, U′ at the inflection (m/rad).
    fn velocity_at(&self, inflection: f64) -> f64 {
        let ([s0, s1], [v0, v1]) = (self.halves().map(|law| 1.0 / law.peak(1)), self.ends.map(|end| end.v));
        let (l0, l1) = (inflection, 1.0 - inflection);
        (self.mean_velocity() - (1.0 - s0) * l0 * v0 - (1.0 - s1) * l1 * v1) / (s0 * l0 + s1 * l1)
    }

    /// U″ at an end at which the follower turns (m/rad²).
    fn acceleration_at(&self, end: usize, inflection: f64) -> f64 {
        let part = [inflection, inflection - 1.0][end];
        self.velocity_at(inflection) * FRAC_PI_2 / (part * self.angle)
    }

    /// The inflection that gives U″ = `acceleration` at a turning end; None if no inflection does.
    fn inflection_for(&self, end: usize, acceleration: f64) -> Option<f64> {
        let missing = |inflection: f64| self.acceleration_at(end, inflection) - acceleration;
        let [mut low, mut high] = INFLECTION;
        if missing(low) * missing(high) > 0.0 {
            return None;
        }
        // Bisection down to neighbouring numbers.
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if missing(low) * missing(middle) <= 0.0 { high = middle } else { low = middle }
        }
        Some(0.5 * (low + high))
    }

    /// The pieces with this inflection.
    pub fn forms(&self, inflection: f64) -> Vec<([f64; 2], Form)> {
        let ([from, to], angle, laws) = (self.ends, self.angle, self.halves());
        if laws[0] == laws[1] && from.v == to.v && inflection == 0.5 {
            let form = Form { width: angle, height: to.u - from.u - from.v * angle, ..straight(&from) };
            // From the end with the smaller U, which has the smaller roundings.
            let ends_low = from.v == 0.0 && to.u.abs() < from.u.abs();
            return parts(laws[0], 1.0, if ends_low { Form { base: to.u, level: 1.0, ..form } } else { form });
        }
        let middle = self.velocity_at(inflection);
        let half = |end: End, law: StandardLaw, part: f64| {
            let width = 2.0 * part * angle;
            parts(law, 0.5, Form { width, height: (middle - end.v) * width / law.peak(1), ..straight(&end) })
        };
        let mut forms = half(from, laws[0], inflection);
        forms.extend(half(to, laws[1], inflection - 1.0));
        forms
    }
}

/// Constant velocity through this end.
fn straight(end: &End) -> Form {
    Form::straight(end.phi, end.u, end.v)
}

/// The analytic parts of a law from z = 0 to `end`.
fn parts(law: StandardLaw, end: f64, form: Form) -> Vec<([f64; 2], Form)> {
    let joints = law.joints().iter().filter(|joint| **joint < end);
    let cuts: Vec<f64> =
        std::iter::once(&0.0).chain(joints).chain([&end]).map(|z| form.origin + form.width * z).collect();
    let part = |(part, ends): (usize, &[f64])| {
        let ends = [ends[0].min(ends[1]), ends[0].max(ends[1])];
        (ends, Form { shape: Shape::Law(law, part), ..form })
    };
    cuts.windows(2).enumerate().map(part).collect()
}

/// Velocities, accelerations and inflections of the points.
struct Draft<'a> {
    points: &'a [PlanPoint],
    /// U′ (m/rad).
    velocities: Vec<f64>,
    /// U″ (m/rad²), if known.
    accelerations: Vec<Option<f64>>,
    /// The inflections, if decided.
    inflections: Vec<Option<f64>>,
}

/// Composition of a segment.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    Straight,
    Halves(StandardLaw),
    Polynomial,
    Polynomial6,
    Cosines,
    /// The peak of U″ is at this part of the angle.
    Sine(f64),
}

/// The segment's point, its end (0 or 1) and its law, which consists of halves.
type Side = (usize, usize, StandardLaw);

/// The pieces of the plan.
fn forms(points: &[PlanPoint]) -> Result<Vec<([f64; 2], Form)>, PlanFault> {
    check(points)?;
    let mut draft = Draft {
        points,
        velocities: Vec::new(),
        accelerations: points.iter().map(|p| if p.free { None } else { Some(p.acceleration.unwrap_or(0.0)) }).collect(),
        inflections: points.iter().map(|p| p.inflection).collect(),
    };
    draft.velocities = (0..points.len()).map(|i| draft.velocity(i)).collect::<Result<_, _>>()?;
    let kinds = (0..points.len()).map(|i| draft.kind(i)).collect::<Result<Vec<_>, _>>()?;
    for i in 0..points.len() {
        draft.turn(i, &kinds)?;
    }
    Ok((0..points.len()).flat_map(|i| draft.forms(i, kinds[i])).collect())
}

fn fault<T>(point: usize, key: &'static str, text: impl Into<String>) -> Result<T, PlanFault> {
    Err(PlanFault { point, key, text: text.into() })
}

/// Whether the values are in their ranges and the angles ascend within a turn.
fn check(points: &[PlanPoint]) -> Result<(), PlanFault> {
    if !(2..=MOST_POINTS).contains(&points.len()) {
        return fault(0, "phi", format!("a plan has 2 to {MOST_POINTS} points within the turn, not {}", points.len()));
    }
    for (i, point) in points.iter().enumerate() {
        let [least, greatest] = INFLECTION;
        let number = |value: f64, most: f64| value.abs() <= most;
        let derivative = |value: Option<f64>| value.is_none_or(|value| number(value, MOST_DERIVATIVE));
        let within = [
            ("phi", number(point.phi, 2.0 * TAU), "-4π to 4π rad".to_owned()),
            ("U", number(point.u, LARGEST), format!("{:e} to {LARGEST:e}", -LARGEST)),
            ("dU", derivative(point.velocity), format!("at most {MOST_DERIVATIVE:e}")),
            ("ddU", derivative(point.acceleration), format!("at most {MOST_DERIVATIVE:e}")),
            ("dddU", derivative(point.jerk), format!("at most {MOST_DERIVATIVE:e}")),
            (
                "inflection",
                point.inflection.is_none_or(|part| least <= part && part <= greatest),
                format!("{least} to {greatest} of the angle"),
            ),
        ];
        if let Some((key, _, range)) = within.into_iter().find(|(_, good, _)| !good) {
            return fault(i, key, format!("out of range; expected {range}"));
        }
        // If the last and the first point collide, the last one is at fault: it is beyond the turn.
        let Some(before) = i.checked_sub(1).map(|before| points[before].phi) else { continue };
        let end = points[0].phi + TAU;
        let (text, other) = match point.phi {
            phi if phi - before < LEAST_MOTION => ("beyond the angle of the point before", before),
            phi if end - phi < LEAST_MOTION => ("before the first point one turn later", end),
            _ => continue,
        };
        let [phi, other] = [point.phi, other].map(|phi| Rounded(phi.to_degrees()));
        let text =
            format!("{phi} deg is not {text}, {other} deg, by {LEAST_MOTION} rad; the points ascend within one turn");
        return fault(i, "phi", text);
    }
    Ok(())
}

impl Draft<'_> {
    /// The previous point.
    fn before(&self, i: usize) -> usize {
        (i + self.points.len() - 1) % self.points.len()
    }

    /// The ends of the segment that leads to point `i`.
    fn ends(&self, i: usize) -> [End; 2] {
        let from = self.before(i);
        let end = |i: usize| End {
            phi: self.points[i].phi,
            u: self.points[i].u,
            v: self.velocities[i],
            turns: self.turns(i),
        };
        let turn = if i == 0 { TAU } else { 0.0 };
        [End { phi: self.points[from].phi - turn, ..end(from) }, end(i)]
    }

    fn segment(&self, i: usize, law: StandardLaw) -> Segment {
        let ends = self.ends(i);
        Segment { ends, angle: ends[1].phi - ends[0].phi, law }
    }

    /// Whether the follower turns at point `i`.
    fn turns(&self, i: usize) -> bool {
        self.velocities[i] == 0.0 && self.accelerations[i] != Some(0.0)
    }

    /// U′ at point `i`.
    fn velocity(&self, i: usize) -> Result<f64, PlanFault> {
        let slope = |to: usize| {
            let from = self.before(to);
            let turn = if to == 0 { TAU } else { 0.0 };
            (self.points[to].u - self.points[from].u) / (self.points[to].phi + turn - self.points[from].phi)
        };
        let next = (i + 1) % self.points.len();
        let lines = [i, next].into_iter().filter(|&to| self.points[to].law == Some(Straight)).map(slope);
        let mut velocity = self.points[i].velocity;
        for slope in lines {
            let given = *velocity.get_or_insert(slope);
            if (given - slope).abs() > SAME * slope.abs().max(given.abs()) {
                let [given, slope] = [given, slope].map(Rounded);
                return fault(i, "dU", format!("{given} m/rad, but a straight segment next to it has {slope} m/rad"));
            }
        }
        Ok(velocity.unwrap_or(0.0))
    }

    /// The kind of segment that leads to point `i`.
    fn kind(&self, i: usize) -> Result<Kind, PlanFault> {
        let (ends, PlanPoint { law, inflection, u, .. }) = ([self.before(i), i], self.points[i]);
        let any = |test: &dyn Fn(usize) -> bool| ends.into_iter().any(test);
        let peak = |k: usize| {
            let [before, next] =
                [self.before(k), (k + 1) % self.points.len()].map(|j| self.points[j].u - self.points[k].u);
            self.velocities[k] == 0.0 && before * next > 0.0
        };
        if let Some(k) = ends.into_iter().find(|&k| self.points[k].free && !peak(k)) {
            return fault(k, "ddU", "only at a turning point, an extreme of U with dU = 0, do the laws decide ddU");
        }
        let rests = !any(&|k| self.velocities[k] != 0.0 || self.turns(k));
        let moves = any(&|k| self.velocities[k] != 0.0 && self.accelerations[k] != Some(0.0));
        // One inflection cannot give two accelerations.
        let both = !any(&|k| !self.turns(k) || self.points[k].free);
        let jerk = any(&|k| self.points[k].jerk.is_some());
        let [low, high] = INFLECTION_OF_DEGREE_6;
        let polynomial = match law {
            Some(Standard(Polynomial345)) => !rests && inflection.is_none(),
            Some(Standard(Polynomial4567)) => jerk || !rests && inflection.is_none(),
            Some(_) => false,
            None => moves || both || jerk,
        };
        match law {
            _ if polynomial && inflection.is_some() => {
                fault(i, "inflection", "a general polynomial has no such parameter")
            }
            _ if polynomial => Ok(Kind::Polynomial),
            _ if moves => {
                let text = "if dU and ddU are not 0 only polynomial_345 and polynomial_4567 are possible";
                fault(i, "law", text)
            }
            Some(Straight | Sine) if inflection.is_some() => {
                fault(i, "inflection", "the law of this segment has no such parameter")
            }
            Some(Straight) if any(&|k| self.accelerations[k] != Some(0.0)) => {
                fault(i, "law", "a straight segment has ddU = 0 at both ends")
            }
            Some(Polynomial6) if !rests => fault(i, "law", "polynomial_6 is for motions from rest to rest only"),
            Some(Polynomial6) if !(low..=high).contains(&inflection.unwrap_or(0.5)) => fault(
                i,
                "inflection",
                format!("polynomial_6 has one inflection and no overshoot from {low} to {high} only"),
            ),
            Some(Cosines) if any(&|k| self.velocities[k] != 0.0) => {
                fault(i, "law", "cosines are for motions from standstill to standstill only, dU = 0 at both ends")
            }
            Some(Cosines) if inflection.is_some() => {
                fault(i, "inflection", "the inflection of cosines follows from ddU at both ends")
            }
            Some(Straight) => Ok(Kind::Straight),
            Some(Cosines) => Ok(Kind::Cosines),
            Some(Polynomial6) => Ok(Kind::Polynomial6),
            Some(Sine) => self.hump(i, INFLECTION).map(Kind::Sine),
            Some(Standard(law)) => Ok(Kind::Halves(law)),
            None if rests && self.points[ends[0]].u == u => Ok(Kind::Straight),
            None if inflection.is_none() && any(&|k| self.velocities[k] == 0.0) && !any(&|k| self.turns(k)) => {
                Ok(self.hump(i, HUMP).map_or(Kind::Halves(ModifiedSine), Kind::Sine))
            }
            None => Ok(Kind::Halves(ModifiedSine)),
        }
    }

    /// The peak of U″ of the law `sine` to point `i`, as part of the angle; refused outside `ends`.
    fn hump(&self, i: usize, ends: [f64; 2]) -> Result<f64, PlanFault> {
        let segment = self.segment(i, InclinedSine);
        let ([v0, v1], mean) = (segment.ends.map(|end| end.v), segment.mean_velocity());
        let peak = ((mean - v0) / (v1 - v0) - FRAC_2_PI) / (1.0 - 2.0 * FRAC_2_PI);
        if segment.ends.iter().any(|end| end.turns) || !(ends[0]..=ends[1]).contains(&peak) {
            let [v0, v1, mean] = [v0, v1, mean].map(Rounded);
            return fault(
                i,
                "law",
                format!(
                    "`sine` cannot lead from {v0} to {v1} m/rad with {mean} m/rad on average: (average − first)/(last − first) \
                 must lie between 0.366112 and 0.633888, and ddU be 0 at both ends"
                ),
            );
        }
        Ok(peak)
    }

    /// Decides U″ at a turning point `i` by the laws next to it; a given U″ decides their inflections.
    fn turn(&mut self, i: usize, kinds: &[Kind]) -> Result<(), PlanFault> {
        if let (Some(_), false) =
            (self.points[i].jerk, [i, (i + 1) % kinds.len()].iter().any(|&k| kinds[k] == Kind::Polynomial))
        {
            return fault(i, "dddU", "no polynomial next to the point meets it");
        }
        if !self.turns(i) {
            return Ok(());
        }
        let next = (i + 1) % self.points.len();
        let halves = |to: usize, end: usize| match kinds[to] {
            Kind::Halves(law) => Some((to, end, law)),
            _ => None,
        };
        let sides: Vec<Side> = [halves(i, 1), halves(next, 0)].into_iter().flatten().collect();
        let own = |draft: &Self, (to, end, law): Side| {
            draft.segment(to, law).acceleration_at(end, draft.inflections[to].unwrap_or(0.5))
        };
        let fitting = |draft: &Self, (to, end, law): Side, acceleration: f64| {
            draft.segment(to, law).inflection_for(end, acceleration)
        };
        if self.accelerations[i].is_none() {
            // The first side that the other one can follow decides, else the first one with a given inflection.
            let open = |side: &Side| self.inflections[side.0].is_none();
            let follows = |side: &Side| {
                let mut others = sides.iter().filter(|other| other.0 != side.0 && open(other));
                others.all(|&other| fitting(self, other, own(self, *side)).is_some())
            };
            let decided = sides.iter().find(|side| !open(side) && follows(side));
            let Some(&side) = decided.or_else(|| sides.iter().find(|side| follows(side))).or(sides.first()) else {
                return fault(i, "ddU", "the laws to and from the point do not determine it; give its value");
            };
            self.accelerations[i] = Some(own(self, side));
            self.inflections[side.0].get_or_insert(0.5);
        }
        let acceleration = self.accelerations[i].unwrap_or(0.0);
        for side in sides {
            if self.inflections[side.0].is_none() {
                let Some(inflection) = fitting(self, side, acceleration) else {
                    return fault(
                        i,
                        "ddU",
                        format!(
                            "{} m/rad² needs an inflection that the segment to point[{}] cannot have: in its middle the law has {} m/rad²",
                            Rounded(acceleration),
                            side.0 + 1,
                            Rounded(own(self, side))
                        ),
                    );
                };
                self.inflections[side.0] = Some(inflection);
            }
            let found = own(self, side);
            if (found - acceleration).abs() <= SAME * acceleration.abs() {
                continue;
            }
            // A given inflection is binding, even if the laws then have no common U″.
            if self.points[side.0].inflection.is_none() {
                let text = "the laws next to the point have no common ddU, since one inflection cannot give ddU at both ends of a \
                            segment; give ddU and leave the laws to polynomials, or give inflections";
                return fault(i, "ddU", text);
            }
            if self.points[i].acceleration.is_some() {
                let (given, found, to) = (Rounded(acceleration), Rounded(found), side.0 + 1);
                let text = format!(
                    "{given} m/rad² and the inflection of the segment to point[{to}] contradict each other: with this inflection the law has \
                     {found} m/rad² here; leave one of them out"
                );
                return fault(i, "ddU", text);
            }
        }
        Ok(())
    }

    /// The pieces of the segment that leads to point `i`.
    fn forms(&self, i: usize, kind: Kind) -> Vec<([f64; 2], Form)> {
        let segment = self.segment(i, ModifiedSine);
        let ([from, to], angle) = (segment.ends, segment.angle);
        let whole = |c| vec![([from.phi, to.phi], Form::polynomial(from.phi, angle, &c))];
        match kind {
            Kind::Straight => vec![([from.phi, to.phi], straight(&from))],
            Kind::Halves(law) => Segment { law, ..segment }.forms(self.inflections[i].unwrap_or(0.5)),
            Kind::Polynomial => whole(self.polynomial(i)),
            Kind::Polynomial6 => {
                let (h, l) = (to.u - from.u, self.inflections[i].unwrap_or(0.5));
                let k = -10.0 * (1.0 - 2.0 * l) / (1.0 - 5.0 * l * (1.0 - l));
                whole([from.u, 0.0, 0.0, h * (10.0 + k), -h * (15.0 + 3.0 * k), h * (6.0 + 3.0 * k), -h * k, 0.0])
            }
            Kind::Cosines => {
                let unit = (angle / PI).powi(2);
                let [first, last] = [self.before(i), i].map(|k| unit * self.accelerations[k].unwrap_or(0.0));
                let h = to.u - from.u;
                let third = (first - last - h) / 16.0;
                let shape = Shape::Cosines([0.5 * h - third, 0.125 * (first + last), third]);
                vec![([from.phi, to.phi], Form { width: angle, height: 1.0, shape, ..straight(&from) })]
            }
            Kind::Sine(peak) => {
                // Each quarter sine is the first quarter of an inclined sine that begins at its end.
                let quarter = |end: End, part: f64| {
                    let (width, height) = (4.0 * part * angle, 4.0 * part * part * (to.v - from.v) * angle);
                    Form { width, height, shape: Shape::Law(InclinedSine, 0), ..straight(&end) }
                };
                let middle = from.phi + peak * angle;
                vec![([from.phi, middle], quarter(from, peak)), ([middle, to.phi], quarter(to, peak - 1.0))]
            }
        }
    }

    /// The coefficients of the polynomial of degree 5, or of degree 7 if the law or a jerk needs it, to point `i`.
    fn polynomial(&self, i: usize) -> [f64; COEFFICIENTS] {
        let segment = self.segment(i, Polynomial345);
        let (points, b) = ([self.before(i), i], segment.angle);
        let value = |end: usize, order: i32| {
            let k = points[end];
            let derivative = match order {
                0 => segment.ends[end].u,
                1 => segment.ends[end].v,
                2 => self.accelerations[k].unwrap_or(0.0),
                _ => self.points[k].jerk.unwrap_or(0.0),
            };
            derivative * b.powi(order)
        };
        let [c0, c1, c2, c3] = [value(0, 0), value(0, 1), 0.5 * value(0, 2), value(0, 3) / 6.0];
        let jerk = points.iter().any(|&k| self.points[k].jerk.is_some());
        if jerk || self.points[i].law == Some(Standard(Polynomial4567)) {
            let r = [c0 + c1 + c2 + c3, c1 + 2.0 * c2 + 3.0 * c3, 2.0 * c2 + 6.0 * c3, 6.0 * c3];
            let [r0, r1, r2, r3] = std::array::from_fn(|order| value(1, order as i32) - r[order]);
            return [
                c0,
                c1,
                c2,
                c3,
                35.0 * r0 - 15.0 * r1 + 2.5 * r2 - r3 / 6.0,
                -84.0 * r0 + 39.0 * r1 - 7.0 * r2 + 0.5 * r3,
                70.0 * r0 - 34.0 * r1 + 6.5 * r2 - 0.5 * r3,
                -20.0 * r0 + 10.0 * r1 - 2.0 * r2 + r3 / 6.0,
            ];
        }
        let r = [c0 + c1 + c2, c1 + 2.0 * c2, 2.0 * c2];
        let [r0, r1, r2] = std::array::from_fn(|order| value(1, order as i32) - r[order]);
        let (c3, c4) = (10.0 * r0 - 4.0 * r1 + 0.5 * r2, -15.0 * r0 + 7.0 * r1 - r2);
        [c0, c1, c2, c3, c4, 6.0 * r0 - 3.0 * r1 + 0.5 * r2, 0.0, 0.0]
    }
}

#[cfg(test)]
pub(super) mod tests;
