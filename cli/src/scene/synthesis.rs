//! Task files of `camdrive synthesize`: TOML → a motion task in SI. The keys are described below.
//!
#![doc = include_str!("SYNTHESIS.md")]

use super::diagnostics::Diagnostics;
use super::input;
use super::models::{by_ratio, forbid};
use super::section::{ANY, Limits, NOT_NEGATIVE, POSITIVE, Section, within};
use super::units;
use camdrive::drives::elastic_shaft::Parameters;
use camdrive::drives::unit::{self, Quantity};
use camdrive_design::synthesis::Objective::{
    Chebyshev, ChebyshevSum, DiscreteChebyshev, DiscreteLeastSquares, LeastSquares, PeakAcceleration, PeakTorque,
    ShaftTorque,
};
use camdrive_design::synthesis::shaft::{Shaft, ShaftGoal};
use camdrive_design::synthesis::study::{Assignment, Elasticity, Method, Names};
use camdrive_design::synthesis::{Basis, Bound, Norm, Objective, Point, Polynomial, Range, Search, Symmetry, Task};
use std::f64::consts::TAU;
use std::path::Path;

/// The most harmonics of a profile: the source advises against more than nine, and cams of sixty-four can be made.
const MOST_HARMONICS: u32 = 64;

/// The most points in a range of the discrete objectives.
const MOST_POINTS: u32 = 10_000;

/// What people write for the keys.
const SYNONYMS: &[(&str, &str)] = &[
    ("title", "name"),
    ("stroke", "scale"),
    ("ranges", "range"),
    ("dwells", "dwell"),
    ("bounds", "bound"),
    ("point_condition", "point"),
    ("K", "harmonics"),
    ("goal", "objective"),
    ("criterion", "objective"),
    ("start", "from"),
    ("end", "to"),
    ("center", "centre"),
    ("u", "U"),
    ("U1", "dU"),
    ("U2", "ddU"),
    ("U3", "dddU"),
    ("tol", "tolerance"),
    ("D", "damping_ratio"),
    ("w0", "natural_frequency"),
    ("speed", "fastest"),
];

/// What is made small, before its points are known; None for the torque of a shaft, which has values of its own.
type Kind = Option<Objective>;

const OBJECTIVES: &[(&[&str], Kind)] = &[
    (&["least_squares", "S1"], Some(LeastSquares)),
    (&["discrete_least_squares", "S2"], Some(DiscreteLeastSquares { points: 0 })),
    (&["chebyshev", "S3", "minimax"], Some(Chebyshev)),
    (&["discrete_chebyshev", "S4"], Some(DiscreteChebyshev { points: 0 })),
    (&["chebyshev_sum", "S5"], Some(ChebyshevSum)),
    (&["peak_acceleration"], Some(PeakAcceleration)),
    (&["peak_torque", "torque"], Some(PeakTorque)),
    (&["shaft_torque"], None),
];

const SYMMETRIES: &[(&[&str], Symmetry)] = &[
    (&["none"], Symmetry { even: false, half_wave: false }),
    (&["even"], Symmetry { even: true, half_wave: false }),
    (&["half_wave"], Symmetry { even: false, half_wave: true }),
    (&["even_half_wave"], Symmetry { even: true, half_wave: true }),
];

const METHODS: &[(&[&str], Method)] =
    &[(&["robust"], Method::Robust), (&["recipe"], Method::Recipe), (&["none"], Method::None)];

/// The keys of U and its derivatives.
const ORDERS: [&str; 4] = ["U", "dU", "ddU", "dddU"];
const TOLERANCES: [&str; 3] = ["tolerance", "dU_tolerance", "ddU_tolerance"];

/// Reads and validates a task file; a scene that it names counts from the folder of the file.
pub fn read(path: &Path) -> Result<Assignment, Diagnostics> {
    let (file, text) = input::text(path, input::Kind::Task)?;
    super::with_document(&file, &text, input::Kind::Task, |root| {
        assignment(root, path.parent().unwrap_or(Path::new("")))
    })
}

/// Lengths of the task: with a scale pure numbers, which count in it.
struct Lengths {
    scale: f64,
    quantity: &'static Quantity,
}

impl Lengths {
    /// Of the task; a scale that is wrong is told, and reading goes on.
    fn of(root: &Section<'_>) -> Self {
        let quantity = if root.has("scale") { &unit::NUMBER } else { &unit::LENGTH };
        let scale = root.optional("scale", &unit::LENGTH, POSITIVE).flatten();
        Lengths { scale: scale.unwrap_or(1.0), quantity }
    }

    /// A value of U⁽ⁿ⁾, n = `order`.
    fn optional(&self, section: &Section<'_>, key: &'static str, order: usize, limits: Limits) -> Option<Option<f64>> {
        Some(section.derivative(key, self.quantity, order as i32, limits)?.map(|value| value * self.scale))
    }

    /// The same, or the list of the coefficients of a polynomial.
    fn polynomial(&self, section: &Section<'_>, order: usize) -> Option<Option<Polynomial>> {
        let Some(node) = section.node(ORDERS[order]) else { return Some(None) };
        if !matches!(node.value, toml::de::DeValue::Array(_)) {
            return Some(self.optional(section, ORDERS[order], order, ANY)?.map(|value| Polynomial(vec![value])));
        }
        let list = section.polynomial(ORDERS[order], self.quantity, order as i32)?;
        Some(Some(Polynomial(list.into_iter().map(|c| c * self.scale).collect())))
    }
}

fn assignment(root: &Section<'_>, folder: &Path) -> Option<Assignment> {
    let name = super::name(root);
    let description = root.text("description").map(|text| text.unwrap_or_default().trim().to_owned());
    let lengths = Lengths::of(root);
    let harmonics = root.count("harmonics", 1, MOST_HARMONICS);
    let symmetry = root.choice_or("symmetry", SYMMETRIES, Symmetry::default());
    let kind = root.choice("objective", OBJECTIVES);
    // Sums of squares weigh squares.
    let power = if matches!(kind, Some(Some(LeastSquares | DiscreteLeastSquares { .. }))) { -2 } else { -1 };
    let weights = [("dU_weight", power), ("ddU_weight", 2 * power)]
        .map(|(key, n)| root.derivative(key, &unit::NUMBER, n, NOT_NEGATIVE));
    let points = discrete_points(root, kind);
    let search = search(root, kind);
    let scene = root.text("scene").map(|path| path.map(|path| folder.join(path)));
    let weighted = [root.has("dU_weight"), root.has("ddU_weight")];
    let ranges = ranges(root, &lengths, weighted);
    let exact = exact_points(root, &lengths);
    let bounds = bounds(root, &lengths);
    let elasticity = elasticity(root, &lengths, kind);
    let shaft = shaft(root, kind);
    root.finish(SYNONYMS);
    let (ranges, exact, bounds, kind) = (ranges?, exact?, bounds?, kind?);
    check_purpose(root, kind, &ranges, &exact, &bounds)?;
    let points = points?;
    let objective = match kind {
        None => ShaftTorque(shaft??),
        Some(DiscreteLeastSquares { .. }) => DiscreteLeastSquares { points },
        Some(DiscreteChebyshev { .. }) => DiscreteChebyshev { points },
        Some(other) => other,
    };
    let kept = ranges.iter().flat_map(|Given { path, range, tolerances }| {
        (0..3).filter_map(move |order| {
            let (around, limit) = (range.prescribed[order].clone()?, tolerances[order]?);
            let bound = Bound { from: range.from, to: range.to, order, around, min: -limit, max: limit };
            Some((format!("{path}.{}", TOLERANCES[order]), bound))
        })
    });
    let (bound_names, bounds): (Vec<String>, Vec<Bound>) = bounds.into_iter().chain(kept).unzip();
    let (range_names, ranges): (Vec<String>, Vec<Range>) =
        ranges.iter().map(|r| (r.path.clone(), r.range.clone())).unzip();
    let (point_names, points_of_u): (Vec<String>, Vec<Point>) = exact.into_iter().unzip();
    let names = Names { ranges: range_names, points: point_names, bounds: bound_names };
    let task = Task {
        basis: Basis::new(harmonics?, symmetry?),
        ranges,
        points: points_of_u,
        bounds,
        objective,
        weights: [weights[0]?.unwrap_or(1.0), weights[1]?.unwrap_or(1.0)],
        speeds: None,
        search: search?,
    };
    let (name, description, scene) = (name?, description?, scene?);
    Some(Assignment {
        name,
        description,
        unit: lengths.scale,
        task,
        names,
        elasticity: elasticity?,
        shaft: shaft?,
        scene,
    })
}

/// The points in a range of the discrete objectives; 0 for the default.
fn discrete_points(root: &Section<'_>, kind: Option<Kind>) -> Option<usize> {
    if matches!(kind, Some(Some(DiscreteLeastSquares { .. } | DiscreteChebyshev { .. }))) && root.has("points") {
        return root.count("points", 2, MOST_POINTS);
    }
    forbid(root, &["points"], "the objective looks at all angles", "objective = \"discrete_chebyshev\"");
    Some(0)
}

/// How an objective that is not convex is searched.
fn search(root: &Section<'_>, kind: Option<Kind>) -> Option<Search> {
    let usual = Search::default();
    if !matches!(kind, Some(Some(PeakTorque) | None)) {
        forbid(root, &["starts", "seed"], "this objective has one optimum", "objective = \"peak_torque\"");
        return Some(usual);
    }
    let starts = if root.has("starts") { root.count("starts", 1, 1000)? } else { usual.starts };
    let seed = if root.has("seed") { root.count("seed", 0, u32::MAX)? as u64 } else { usual.seed };
    Some(Search { starts, seed })
}

/// First and last angle of a range.
fn angles(section: &Section<'_>) -> Option<(f64, f64)> {
    let from = section.real("from", &unit::ANGLE, within(-2.0 * TAU, 2.0 * TAU));
    let to = section.real("to", &unit::ANGLE, within(-2.0 * TAU, 2.0 * TAU));
    ordered(section, "to", from?, to?)
}

fn ordered(section: &Section<'_>, key: &'static str, from: f64, to: f64) -> Option<(f64, f64)> {
    // Degrees of a whole turn may exceed it by a rounding.
    if from < to && to - from <= TAU * (1.0 + 1e-12) {
        return Some((from, to.min(from + TAU)));
    }
    let deg = |angle: f64| units::short(angle.to_degrees());
    let message = format!("`{}`: from {} deg to {} deg is no range", section.path_of(key), deg(from), deg(to));
    let fault = section.fault_of(key, message).admissible("more than 0 deg, at most a turn of 360 deg");
    let way = Some((to - from).rem_euclid(TAU)).filter(|way| *way > 0.0).unwrap_or(TAU);
    let hint = format!("write for example to = \"{} deg\"; a single angle is a [[point]]", deg(from + way));
    section.faults.report(fault.hint(hint));
    None
}

/// A [[range]] or [[dwell]] as it stands in the file.
struct Given {
    /// "dwell[2]".
    path: String,
    range: Range,
    tolerances: [Option<f64>; 3],
}

/// The [[range]] and [[dwell]], in the order of kinds.
fn ranges(root: &Section<'_>, lengths: &Lengths, weighted: [bool; 2]) -> Option<Vec<Given>> {
    let (given, dwells) = (root.sections("range"), root.sections("dwell"));
    let (given, dwells) = (given?, dwells?);
    let mut read: Vec<_> = given.iter().map(|section| range(section, lengths, weighted)).collect();
    read.extend(dwells.iter().map(|section| dwell(section, lengths, weighted)));
    let sections = || given.iter().chain(&dwells);
    let named = sections()
        .zip(read)
        .map(|(section, read)| read.map(|(range, tolerances)| Given { path: section.path.clone(), range, tolerances }));
    let all: Vec<Given> = named.collect::<Option<_>>()?;
    let mut agree = true;
    for (i, section) in sections().enumerate() {
        for other in &all[..i] {
            agree &= agrees(section, &all[i].range, other);
        }
    }
    agree.then_some(all)
}

/// Whether a range prescribes what another one does where they overlap.
fn agrees(section: &Section<'_>, range: &Range, other: &Given) -> bool {
    for turns in -4..=4 {
        // The other range is counted from the turn in which this one lies.
        let shift = f64::from(turns) * TAU;
        let [from, to] = [range.from.max(other.range.from + shift), range.to.min(other.range.to + shift)];
        // Neighbours may share an end.
        if to - from < 1e-9 {
            continue;
        }
        for order in 0..3 {
            let (Some(a), Some(b)) = (&range.prescribed[order], &other.range.prescribed[order]) else { continue };
            let difference = |phi: f64| {
                let (a, b) = (a.at(phi - range.from), b.at(phi - shift - other.range.from));
                (a - b).abs() > 1e-9 * (a.abs() + b.abs())
            };
            if [from, 0.5 * (from + to), to].into_iter().any(difference) {
                let deg = |phi: f64| units::short(phi.to_degrees());
                let (this, key) = (&section.path, ORDERS[order]);
                let message = format!(
                    "`{this}` and `{}` overlap from {} deg to {} deg with different `{key}`",
                    other.path,
                    deg(from),
                    deg(to)
                );
                section.faults.report(section.fault(message).hint("make them end where the next one begins"));
                return false;
            }
        }
    }
    true
}

fn tolerances(section: &Section<'_>, lengths: &Lengths) -> Option<[Option<f64>; 3]> {
    let [a, b, c] = [0, 1, 2].map(|order| lengths.optional(section, TOLERANCES[order], order, POSITIVE));
    Some([a?, b?, c?])
}

fn range(section: &Section<'_>, lengths: &Lengths, weighted: [bool; 2]) -> Option<(Range, [Option<f64>; 3])> {
    let ends = angles(section);
    let targets = [0, 1, 2].map(|order| lengths.polynomial(section, order));
    let weight = section.real_or("weight", &unit::NUMBER, POSITIVE, 1.0);
    let tolerances = tolerances(section, lengths);
    section.finish(SYNONYMS);
    let [u, first, second] = targets;
    let (mut prescribed, tolerances) = ([u?, first?, second?], tolerances?);
    if prescribed.iter().all(Option::is_none) {
        let fault = section.fault(format!("`{}` prescribes nothing", section.path));
        section.faults.report(fault.admissible("U, dU, ddU").hint("add for example U = 0.5"));
        return None;
    }
    for order in 1..3 {
        if weighted[order - 1] && prescribed[order].is_none() {
            prescribed[order] = prescribed[order - 1].as_ref().map(Polynomial::derivative);
        }
    }
    for order in 0..3 {
        if tolerances[order].is_some() && prescribed[order].is_none() {
            let (key, target) = (TOLERANCES[order], ORDERS[order]);
            let message = format!("`{}`: there is no `{target}` here to keep it from", section.path_of(key));
            section.faults.report(section.fault_of(key, message).hint(format!("add `{target}` or remove `{key}`")));
            return None;
        }
    }
    let ((from, to), weight) = (ends?, weight?);
    Some((Range { from, to, prescribed, weight }, tolerances))
}

fn dwell(section: &Section<'_>, lengths: &Lengths, weighted: [bool; 2]) -> Option<(Range, [Option<f64>; 3])> {
    let ends = if section.has("centre") || section.has("width") {
        let because = "centre and width say it already";
        forbid(section, &["from", "to"], because, "`from` and `to` without `centre` and `width`");
        let centre = section.real("centre", &unit::ANGLE, within(-2.0 * TAU, 2.0 * TAU));
        let width = section.real("width", &unit::ANGLE, within(1e-6, TAU));
        centre.zip(width).map(|(centre, width)| (centre - 0.5 * width, centre + 0.5 * width))
    } else {
        angles(section)
    };
    let quantity = lengths.quantity;
    let u = section.real("U", quantity, ANY).map(|u| Polynomial(vec![u * lengths.scale]));
    let weight = section.real_or("weight", &unit::NUMBER, POSITIVE, 1.0);
    let tolerances = tolerances(section, lengths);
    section.finish(SYNONYMS);
    let tolerances = tolerances?;
    // A dwell has U′ = U″ = 0; they count where they have a weight or a tolerance.
    let still = |order: usize| (weighted[order - 1] || tolerances[order].is_some()).then(Polynomial::default);
    let ((from, to), prescribed) = (ends?, [Some(u?), still(1), still(2)]);
    Some((Range { from, to, prescribed, weight: weight? }, tolerances))
}

/// The [[point]]: each value is a condition.
fn exact_points(root: &Section<'_>, lengths: &Lengths) -> Option<Vec<(String, Point)>> {
    let sections = root.sections("point")?;
    let of = |section: &Section<'_>| {
        let phi = section.real("phi", &unit::ANGLE, within(-2.0 * TAU, 2.0 * TAU));
        let values = [0, 1, 2, 3].map(|order| lengths.optional(section, ORDERS[order], order, ANY));
        section.finish(SYNONYMS);
        let mut points = Vec::new();
        let phi = phi?;
        for (order, value) in values.into_iter().enumerate() {
            if let Some(value) = value? {
                points.push((section.path_of(ORDERS[order]), Point { phi, order, value }));
            }
        }
        if points.is_empty() {
            let fault = section.fault(format!("`{}` says nothing of U", section.path));
            section.faults.report(fault.admissible(ORDERS.join(", ")).hint("add for example U = 0.5"));
            return None;
        }
        Some(points)
    };
    let points: Vec<Option<Vec<_>>> = sections.iter().map(of).collect();
    Some(points.into_iter().collect::<Option<Vec<_>>>()?.concat())
}

fn bounds(root: &Section<'_>, lengths: &Lengths) -> Option<Vec<(String, Bound)>> {
    let sections = root.sections("bound")?;
    let orders: Vec<(&[&str], usize)> = vec![(&["U"], 0), (&["dU"], 1), (&["ddU"], 2), (&["dddU"], 3)];
    let of = |section: &Section<'_>| {
        let ends = if section.has("from") || section.has("to") { angles(section) } else { Some((0.0, TAU)) };
        let order = section.choice("of", &orders);
        let values = [("min", ANY), ("max", ANY), ("limit", POSITIVE)]
            .map(|(key, limits)| lengths.optional(section, key, order.unwrap_or(0), limits));
        section.finish(SYNONYMS);
        let [min, max, limit] = [values[0]?, values[1]?, values[2]?];
        if limit.is_some() {
            forbid(section, &["min", "max"], "`limit` bounds both sides", "`min` and `max` without `limit`");
        }
        if min.is_none() && max.is_none() && limit.is_none() {
            let fault = section.fault(format!("`{}` bounds nothing", section.path));
            section.faults.report(fault.admissible("min, max, limit").hint("add for example limit = 2.5"));
            return None;
        }
        let (min, max) = (min.or(limit.map(|l| -l)), max.or(limit));
        let (min, max) = (min.unwrap_or(f64::NEG_INFINITY), max.unwrap_or(f64::INFINITY));
        if min > max {
            let (low, high) = (units::short(min), units::short(max));
            let fault = section.fault_of("max", format!("`{}`: min {low} exceeds max {high}", section.path));
            section.faults.report(fault.hint("exchange them"));
            return None;
        }
        let ((from, to), order) = (ends?, order?);
        Some((section.path.clone(), Bound { from, to, order, around: Polynomial::default(), min, max }))
    };
    sections.iter().map(of).collect::<Vec<_>>().into_iter().collect()
}

/// Whether the objective has something to work on.
fn check_purpose(
    root: &Section<'_>,
    kind: Kind,
    ranges: &[Given],
    points: &[(String, Point)],
    bounds: &[(String, Bound)],
) -> Option<()> {
    let peak = matches!(kind, Some(PeakAcceleration | PeakTorque) | None);
    if !peak && ranges.is_empty() {
        let fault = root.fault_of("objective", "the task prescribes no motion: there is no [[range]] and no [[dwell]]");
        root.faults.report(fault.hint("add a [[dwell]] with centre, width and U"));
        return None;
    }
    if peak && let Some(given) = ranges.iter().find(|given| given.tolerances.iter().all(Option::is_none)) {
        let message = format!("`objective` does not look at errors, and `{}` has no tolerance", given.path);
        let fault = root.fault_of("objective", message);
        root.faults.report(fault.hint("give every [[range]] and [[dwell]] a `tolerance`"));
        return None;
    }
    if peak && ranges.is_empty() && points.is_empty() && bounds.iter().all(|(_, b)| b.order > 0) {
        let fault = root.fault_of("objective", "`objective`: nothing makes the follower move");
        root.faults.report(fault.hint("add [[dwell]] with tolerances, or [[point]]"));
        return None;
    }
    Some(())
}

/// Whether the speeds of a section make a range.
fn rising(section: &Section<'_>, slowest: f64, fastest: f64) -> Option<()> {
    if fastest > slowest {
        return Some(());
    }
    let (low, high) = (units::short(slowest), units::short(fastest));
    let message = format!("`{}`: {high} rad/s is not above `slowest`, {low} rad/s", section.path_of("fastest"));
    section.faults.report(section.fault_of("fastest", message).hint("give a range of speeds"));
    None
}

fn elasticity(root: &Section<'_>, lengths: &Lengths, kind: Option<Kind>) -> Option<Option<Elasticity>> {
    let Some(section) = root.section("elasticity")? else { return Some(None) };
    let w0 = section.real("natural_frequency", &unit::ANGULAR_VELOCITY, POSITIVE);
    let damping = section.real_or("damping_ratio", &unit::NUMBER, within(0.0, 10.0), 0.0);
    let slowest = section.real_or("slowest", &unit::ANGULAR_VELOCITY, NOT_NEGATIVE, 0.0);
    let fastest = section.optional("fastest", &unit::ANGULAR_VELOCITY, POSITIVE);
    let tolerance = lengths.optional(&section, "tolerance", 0, POSITIVE);
    let amplitude = lengths.optional(&section, "admissible_amplitude", 0, POSITIVE);
    let method = section.choice_or("method", METHODS, Method::Robust);
    section.finish(SYNONYMS);
    let (slowest, fastest, tolerance) = (slowest?, fastest?, tolerance?);
    if fastest.is_none() && tolerance.is_none() {
        let fault = section.fault(format!("`{}`: neither `fastest` nor `tolerance` is given", section.path));
        section.faults.report(fault.hint("add the speed to be reached, or the deviation to be kept as far as it goes"));
        return None;
    }
    rising(&section, slowest, fastest.unwrap_or(f64::INFINITY))?;
    let chebyshev = matches!(kind, Some(Some(Chebyshev | DiscreteChebyshev { .. } | ChebyshevSum)));
    if method == Some(Method::Robust) && kind.is_some() && !chebyshev {
        let message = "`elasticity.method`: the robust profile is that of a largest error over angles and speeds";
        let hint = "choose objective = \"chebyshev\", or method = \"recipe\"";
        section.faults.report(section.fault_of("method", message).hint(hint));
        return None;
    }
    let elasticity =
        Elasticity { w0: w0?, damping: damping?, slowest, fastest, tolerance, method: method?, amplitude: amplitude? };
    Some(Some(elasticity))
}

fn shaft(root: &Section<'_>, kind: Option<Kind>) -> Option<Option<ShaftGoal>> {
    let wanted = if kind == Some(None) { root.required_section("shaft").map(Some) } else { root.section("shaft") };
    let Some(section) = wanted? else { return Some(None) };
    let parameters = section.parameters(|parameter, read: Option<&Parameters>| match parameter.key {
        "m" => Some(section.real("m", &unit::MASS, POSITIVE)),
        // The profile is not known yet; where the follower rests, the cam alone vibrates.
        key => by_ratio(&section, key, read.map(|read| (read.inertia, read.c))),
    });
    if parameters.is_some_and(|parameters| parameters.b == 0.0) {
        // No vibration dies out.
        match section.has("damping_ratio") {
            true => section.real("damping_ratio", &unit::NUMBER, POSITIVE),
            false => section.real("b", &unit::ROTATIONAL_DAMPING, POSITIVE),
        };
    }
    let slowest = section.real("slowest", &unit::ANGULAR_VELOCITY, POSITIVE);
    let fastest = section.real("fastest", &unit::ANGULAR_VELOCITY, POSITIVE);
    let norm = section.choice_or("norm", &[(&["peak"], Norm::Peak), (&["rms"], Norm::Rms)], Norm::Peak);
    let relative = section.choice_or("torque", &[(&["over_speed_squared"], true), (&["absolute"], false)], true);
    section.finish(SYNONYMS);
    let (slowest, fastest) = (slowest?, fastest?);
    rising(&section, slowest, fastest)?;
    let Parameters { m, inertia, c, b } = parameters?;
    let shaft = Shaft { m, inertia, c, b };
    Some(Some(ShaftGoal { shaft, slowest, fastest, norm: norm?, relative: relative? }))
}
