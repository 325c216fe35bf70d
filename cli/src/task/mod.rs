//! Task files of `camdrive synthesize`: TOML → a motion task in SI. The keys are described below.
//!
#![doc = include_str!("../../../docs/task.md")]

use crate::document::{Diagnostics, Section, Value, input, units};
use crate::scene::{common::by_ratio, motion_law};
use camdrive::drives::elastic_shaft::Parameters;
use camdrive::drives::unit::{self, Quantity};
use camdrive::motion::MotionLaw;
use camdrive_design::synthesis::Objective::{
    Chebyshev, ChebyshevSum, FewestHarmonics, LeastSquares, LongestDwell, MeanSquareAcceleration, PeakAcceleration,
    PeakTorque, ShaftTorque,
};
use camdrive_design::synthesis::clearance::Clearance;
use camdrive_design::synthesis::shaft::{Shaft, ShaftGoal};
use camdrive_design::synthesis::study::{Assignment, Elasticity, Method, Names};
use camdrive_design::synthesis::{Basis, Bound, Curve, ExactPoint, Norm, Objective, Range, Search, Symmetry, Task};
use camdrive_design::text::counted;
use std::f64::consts::TAU;
use std::path::{Path, PathBuf};

/// The most laws of a task.
const MOST_LAWS: usize = 5;

/// The objective; None for the torque of a shaft, which has its own values.
pub type Kind = Option<Objective>;

/// The objectives.
pub const OBJECTIVES: &[(&str, Kind)] = &[
    ("least_squares", Some(LeastSquares)),
    ("chebyshev", Some(Chebyshev)),
    ("chebyshev_sum", Some(ChebyshevSum)),
    ("peak_acceleration", Some(PeakAcceleration)),
    ("mean_square_acceleration", Some(MeanSquareAcceleration)),
    ("longest_dwell", Some(LongestDwell { tolerance: 0.0, dwells: [0, 0] })),
    ("fewest_harmonics", Some(FewestHarmonics { tolerance: 0.0 })),
    ("peak_torque", Some(PeakTorque)),
    ("shaft_torque", None),
];

/// The symmetries.
pub const SYMMETRIES: &[(&str, Symmetry)] = &[
    ("none", Symmetry { even: false, half_wave: false }),
    ("even", Symmetry { even: true, half_wave: false }),
    ("half_wave", Symmetry { even: false, half_wave: true }),
    ("even_half_wave", Symmetry { even: true, half_wave: true }),
];

/// The treatments of an elastic output member.
pub const METHODS: &[(&str, Method)] =
    &[("robust", Method::Robust), ("recipe", Method::Recipe), ("none", Method::None)];

/// The quantity of a bound: U or a derivative.
pub const BOUNDED: &[(&str, usize)] = &[("U", 0), ("dU", 1), ("ddU", 2), ("dddU", 3)];

/// The norms of a minimised torque.
pub const NORMS: &[(&str, Norm)] = &[("peak", Norm::Peak), ("rms", Norm::Rms)];

/// True if a torque counts relative to the square of the speed.
pub const WEIGHTS: &[(&str, bool)] = &[("over_speed_squared", true), ("absolute", false)];

/// The keys of U and its derivatives.
const ORDERS: [&str; 4] = ["U", "dU", "ddU", "dddU"];
const TOLERANCES: [&str; 3] = ["tolerance", "dU_tolerance", "ddU_tolerance"];

/// Reads and validates a task file; the path of its scene starts at the folder of the file.
pub fn read(path: &Path) -> Result<Assignment, Diagnostics> {
    let (file, document) = input::document(path, input::Kind::Task)?;
    input::read(&file, &document, input::Kind::Task, |root| assignment(root, path.parent().unwrap_or(Path::new(""))))
}

/// Lengths of the task; with a scale, pure numbers that count in it.
struct Lengths {
    scale: f64,
    quantity: &'static Quantity,
    /// The folder with the files of tables.
    folder: PathBuf,
}

impl Lengths {
    /// The lengths of the task; reports a wrong scale, and reading continues.
    fn of(root: &Section<'_>, folder: &Path) -> Self {
        let quantity = if root.has("scale") { &unit::NUMBER } else { &unit::LENGTH };
        let scale = root.optional("scale").flatten();
        root.of(quantity, 0);
        Lengths { scale: scale.unwrap_or(1.0), quantity, folder: folder.to_owned() }
    }

    /// A value of U or a derivative.
    fn optional(&self, section: &Section<'_>, key: &'static str) -> Option<Option<f64>> {
        Some(section.optional(key)?.map(|value| value * self.scale))
    }

    /// A value of U⁽ⁿ⁾, or the list of the coefficients of a polynomial.
    fn curve(&self, section: &Section<'_>, key: &'static str) -> Option<Option<Curve>> {
        let Some(node) = section.node(key) else { return Some(None) };
        if !matches!(node.value, Value::Array(_)) {
            return Some(self.optional(section, key)?.map(|value| Curve::polynomial(vec![value])));
        }
        let list = section.polynomial(key)?;
        Some(Some(Curve::polynomial(list.into_iter().map(|c| c * self.scale).collect())))
    }

    /// The motion law under `target`, starting at the first of these angles, over the turn or over its own period; or a table from
    /// one angle to the other.
    fn target(&self, section: &Section<'_>, ends: Option<(f64, f64)>) -> Option<Option<Curve>> {
        section.read("target", |target| {
            let period = target.optional("period");
            let law = motion_law::read_part(target, self.quantity, &self.folder);
            let ((from, to), period) = (ends?, period?);
            let (phase, turn) = period.map_or((from, TAU), |period| (0.0, period));
            let si = |curve: Curve| Some(curve.over(1.0 / self.scale));
            // Only the points count in a table that does not close its turn.
            let points = match law? {
                Ok(MotionLaw::Table(table)) if !table.is_bent() && !Curve::closes(table.points()) => {
                    table.points().clone()
                }
                Ok(law) => return si(Curve::law(law, turn, phase)),
                Err(part) => part.points,
            };
            let angles: Vec<f64> = points.angles.iter().map(|a| from + (a - phase) * turn / TAU).collect();
            match Curve::table(&angles, &points.lifts, turn, [from, to]) {
                Ok(curve) => si(curve),
                Err(reason) => {
                    let message = ": the table does not cover the range";
                    target.refuse(target.fault_of("file", message).hint(reason + "; is `angle_unit` right?"))
                }
            }
        })
    }
}

fn assignment(root: &Section<'_>, folder: &Path) -> Option<Assignment> {
    let name = root.name();
    let description = root.text("description").map(|text| text.unwrap_or_default().trim().to_owned());
    let lengths = Lengths::of(root, folder);
    let kind = root.choice("objective", OBJECTIVES);
    // Sums of squares have squared weights.
    let power = if matches!(kind, Some(Some(LeastSquares))) { -2 } else { -1 };
    let weights = [("dU_weight", power), ("ddU_weight", 2 * power)].map(|(key, n)| {
        root.of(&unit::NUMBER, n);
        root.optional(key)
    });
    root.of(lengths.quantity, 0);
    let search = search(root, kind);
    let scene = root.text("scene").map(|path| path.map(|path| folder.join(path)));
    let weighted = [root.has("dU_weight"), root.has("ddU_weight")];
    let laws = laws(root, &lengths, weighted);
    let several = root.sections("law")?.len().max(1);
    let integral = integral(root, &lengths, kind);
    let longest = longest(root, kind, several);
    let (restrictions, clearances) = (restrictions(root, &lengths, several), clearances(root, &lengths, several));
    let elasticity = elasticity(root, &lengths, kind);
    let shaft = shaft(root, kind);
    root.finish();
    let (laws, kind, integral, restrictions) = (laws?, kind?, integral?, restrictions?);
    check_purpose(root, kind, integral, &laws)?;
    // A level refers to the tightest tolerance.
    let levelled = matches!(kind, Some(LongestDwell { .. } | FewestHarmonics { .. }));
    let all = || laws.iter().flat_map(|law| &law.ranges);
    let tightest = all().filter_map(|given| given.tolerances[0]).fold(f64::INFINITY, f64::min);
    let first_dwell = laws[0].first_dwell;
    let dwells = longest?.map_or([first_dwell, laws[0].end_of_dwells], |one| [one - 1, one].map(|i| first_dwell + i));
    let weights = if levelled { [0.0; 2] } else { [weights[0]?.unwrap_or(1.0), weights[1]?.unwrap_or(1.0)] };
    let mut task = Task {
        basis: Basis::joined(&laws.iter().map(|law| law.basis.clone()).collect::<Vec<_>>()),
        laws: laws.iter().map(|law| law.weight).collect(),
        ranges: Vec::new(),
        points: Vec::new(),
        bounds: Vec::new(),
        clearances: clearances?,
        integral,
        objective: match kind {
            None => ShaftTorque(shaft??),
            Some(LongestDwell { .. }) => LongestDwell { tolerance: tightest, dwells },
            Some(FewestHarmonics { .. }) => FewestHarmonics { tolerance: tightest },
            Some(other) => other,
        },
        weights,
        speeds: None,
        search: search?,
    };
    let mut names = Names { laws: laws.iter().filter_map(|law| law.name.clone()).collect(), ..Names::default() };
    let bounds = laws.iter().flat_map(|law| law.bounds.iter().cloned());
    (names.bounds, task.bounds) = bounds.chain(restrictions).unzip();
    (names.points, task.points) = laws.iter().flat_map(|law| law.points.iter().cloned()).unzip();
    for Prescription { path, range, tolerances, .. } in all() {
        for order in usize::from(levelled)..3 {
            let (Some(around), Some(limit)) = (range.prescribed[order].clone(), tolerances[order]) else { continue };
            let (of, from, to) = (vec![(range.law, 1.0)], range.from, range.to);
            task.bounds.push(Bound { of, from, to, order, around, min: -limit, max: limit });
            names.bounds.push(format!("{path}.{}", TOLERANCES[order]));
        }
        let law = if levelled { tightest / tolerances[0]? } else { laws[range.law].weight };
        task.ranges.push(Range { weight: law * range.weight, ..range.clone() });
        names.ranges.push(path.clone());
    }
    Some(Assignment {
        name: name?,
        description: description?,
        unit: lengths.scale,
        task,
        names,
        elasticity: elasticity?,
        shaft: shaft?,
        scene: scene?,
        files: root.faults.tables.borrow().iter().map(|table| table.path.clone()).collect(),
    })
}

/// One law of the task.
struct Law {
    /// None if there is only one law.
    name: Option<String>,
    basis: Basis,
    weight: f64,
    /// The [[range]], the [[dwell]] and the [[point]] with a weight.
    ranges: Vec<Prescription>,
    first_dwell: usize,
    end_of_dwells: usize,
    points: Vec<(String, ExactPoint)>,
    bounds: Vec<(String, Bound)>,
}

impl Law {
    /// True if a dwell at any level keeps all bounds.
    fn is_unmoved(&self) -> bool {
        let still = |bound: &Bound| bound.order > 0 && bound.around.is_zero() && bound.min <= 0.0 && bound.max >= 0.0;
        self.bounds.iter().all(|(_, bound)| still(bound))
    }
}

/// The [[law]]; without them the task itself is one law.
fn laws(root: &Section<'_>, lengths: &Lengths, weighted: [bool; 2]) -> Option<Vec<Law>> {
    let sections = root.sections("law")?;
    if sections.is_empty() {
        return Some(vec![law(root, 0, None, lengths, weighted)?]);
    }
    let inside = ["harmonics", "symmetry", "range", "dwell", "point", "bound", "elasticity", "shaft"];
    root.forbid(&inside, "the task has several laws", "its place in each [[law]]");
    if sections.len() > MOST_LAWS {
        let fault = root.fault_of("law", format!(": there are {} laws", sections.len()));
        return root.refuse(fault.admissible(format!("at most {MOST_LAWS}")));
    }
    let read = |(i, section): (usize, &Section<'_>)| {
        let name = section.name();
        let law = law(section, i, name, lengths, weighted);
        section.finish();
        law
    };
    let laws: Vec<Option<Law>> = sections.iter().enumerate().map(read).collect();
    let laws: Vec<Law> = laws.into_iter().collect::<Option<_>>()?;
    for (i, section) in sections.iter().enumerate() {
        if laws[..i].iter().any(|law| law.name == laws[i].name) {
            let fault = section.fault_of("name", ": another law has this name");
            return section.refuse(fault.hint("give each law a name of its own"));
        }
    }
    Some(laws)
}

fn law(
    section: &Section<'_>,
    index: usize,
    name: Option<String>,
    lengths: &Lengths,
    weighted: [bool; 2],
) -> Option<Law> {
    let harmonics = section.count("harmonics");
    let symmetry = section.choice("symmetry", SYMMETRIES);
    let weight = if index > 0 || name.is_some() { section.real("weight") } else { Some(1.0) };
    let ranges = ranges(section, lengths, weighted);
    let points = points(section, lengths);
    let bounds = bounds(section, lengths, index);
    let (mut ranges, (fitted, mut points)) = (ranges?, points?);
    let first_dwell = ranges.iter().filter(|given| !given.dwell).count();
    let end_of_dwells = ranges.len();
    ranges.extend(fitted);
    ranges.iter_mut().for_each(|given| given.range.law = index);
    points.iter_mut().for_each(|(_, point)| point.law = index);
    let (basis, weight, bounds) = (Basis::new(harmonics?, symmetry?), weight?, bounds?);
    Some(Law { name, basis, weight, ranges, first_dwell, end_of_dwells, points, bounds })
}

/// True if the objective concerns only the accelerations.
fn of_accelerations(kind: Option<Kind>) -> bool {
    matches!(kind, Some(Some(PeakAcceleration | MeanSquareAcceleration)))
}

/// Upper bound of the integral of the squared errors.
fn integral(root: &Section<'_>, lengths: &Lengths, kind: Option<Kind>) -> Option<Option<f64>> {
    if !of_accelerations(kind) {
        root.forbid(
            &["integral_tolerance"],
            "the objective itself looks at errors",
            "objective = \"peak_acceleration\"",
        );
        return Some(None);
    }
    root.of(if root.has("scale") { &unit::NUMBER } else { &units::AREA }, -1);
    let given = root.optional("integral_tolerance");
    root.of(lengths.quantity, 0);
    let given = given?;
    Some(given.map(|limit| limit * lengths.scale * lengths.scale))
}

/// The only [[dwell]] that grows.
fn longest(root: &Section<'_>, kind: Option<Kind>, laws: usize) -> Option<Option<usize>> {
    let dwells = root.sections("dwell")?.len();
    if !matches!(kind, Some(Some(LongestDwell { .. }))) {
        root.forbid(&["longest"], "no dwell is made longest", "objective = \"longest_dwell\"");
        return Some(None);
    }
    if laws > 1 || dwells == 0 {
        let fault = root.fault_of("objective", ": the longest dwell needs one law with at least one [[dwell]]");
        return root.refuse(fault.hint("add a [[dwell]] with centre, width, U and tolerance"));
    }
    if root.has("longest") { root.count_to("longest", dwells as u32).map(Some) } else { Some(None) }
}

/// The [[restriction]]: bounds of Σ αⱼ Uⱼ⁽ⁿ⁾.
fn restrictions(root: &Section<'_>, lengths: &Lengths, laws: usize) -> Option<Vec<(String, Bound)>> {
    let of = |section: &Section<'_>| {
        several(section, laws, "a restriction is of several", "write a [[bound]], or add a [[law]] for each tool")?;
        let factors = section.reals("factors");
        let bounds = bounds_of(section, lengths, Vec::new());
        let factors = factors?;
        if factors.len() != laws || factors.iter().all(|factor| *factor == 0.0) {
            let message = format!(": {} for {laws} laws", counted(factors.len(), "number"));
            let fault = section.fault_of("factors", message).admissible("one number for each [[law]], not all 0");
            return section.refuse(
                fault.hint("write for example factors = [1, -1] for U of the first minus U of the second law"),
            );
        }
        let of: Vec<(usize, f64)> = factors.into_iter().enumerate().filter(|(_, factor)| *factor != 0.0).collect();
        Some(bounds?.into_iter().map(|(name, bound)| (name, Bound { of: of.clone(), ..bound })).collect::<Vec<_>>())
    };
    Some(root.each("restriction", of)?.concat())
}

/// Checks that the task has several laws.
fn several(section: &Section<'_>, laws: usize, what: &str, hint: &str) -> Option<()> {
    if laws < 2 {
        let fault = section.fault(format!(": there is one law, and {what}"));
        return section.refuse(fault.admissible("2 to 5 [[law]] in the task").hint(hint));
    }
    Some(())
}

/// The [[clearance]].
fn clearances(root: &Section<'_>, lengths: &Lengths, laws: usize) -> Option<Vec<Clearance>> {
    let of = |section: &Section<'_>| {
        several(section, laws, "a clearance is between two", "add a [[law]] for each tool")?;
        let which = ["a", "b"].map(|key| section.count_to(key, laws as u32));
        let offset = section.reals("offset");
        let directions = ["direction_a", "direction_b"].map(|key| section.real(key));
        let distance = section.real("distance");
        section.finish();
        let offset = offset?;
        let [x, y] = offset[..] else {
            let message = format!(": {}, which is no point in the plane", counted(offset.len(), "number"));
            let fault = section.fault_of("offset", message).admissible("two lengths, x and y");
            return section.refuse(fault.hint("give the vector from tool b to tool a with both U at 0"));
        };
        let [a, b] = [which[0]?, which[1]?];
        if a == b {
            let fault = section.fault_of("b", ": it is the same tool as `a`");
            return section.refuse(fault.admissible("another law, counted from 1"));
        }
        let offset = [x, y].map(|d| d * lengths.scale);
        let distance = distance? * lengths.scale;
        Some(Clearance { laws: [a - 1, b - 1], offset, directions: [directions[0]?, directions[1]?], distance })
    };
    root.each("clearance", of)
}

/// The search for a nonconvex objective.
fn search(root: &Section<'_>, kind: Option<Kind>) -> Option<Search> {
    let usual = Search::default();
    if !matches!(kind, Some(Some(PeakTorque) | None)) {
        root.forbid(&["starts", "seed"], "this objective has one optimum", "objective = \"peak_torque\"");
        return Some(usual);
    }
    let [starts, seed] = ["starts", "seed"].map(|key| root.count(key));
    Some(Search { starts: starts?, seed: seed? as u64 })
}

/// First and last angle of a range.
fn angles(section: &Section<'_>) -> Option<(f64, f64)> {
    let [from, to] = ["from", "to"].map(|key| section.real(key));
    ordered(section, "to", from?, to?)
}

fn ordered(section: &Section<'_>, key: &'static str, from: f64, to: f64) -> Option<(f64, f64)> {
    // Degrees of a whole turn may exceed it by a rounding error.
    if from < to && to - from <= TAU * (1.0 + 1e-12) {
        return Some((from, to.min(from + TAU)));
    }
    let deg = |angle: f64| units::short(angle.to_degrees());
    let message = format!(": from {} deg to {} deg is not a range", deg(from), deg(to));
    let fault = section.fault_of(key, message).admissible("more than 0 deg, at most a turn of 360 deg");
    let way = Some((to - from).rem_euclid(TAU)).filter(|way| *way > 0.0).unwrap_or(TAU);
    let hint = format!("write for example to = \"{} deg\"; a single angle is a [[point]]", deg(from + way));
    section.refuse(fault.hint(hint))
}

/// A [[range]] or [[dwell]] of the file.
struct Prescription {
    /// "dwell[2]".
    path: String,
    dwell: bool,
    range: Range,
    tolerances: [Option<f64>; 3],
}

/// The [[range]] and [[dwell]], in the order of kinds.
fn ranges(root: &Section<'_>, lengths: &Lengths, weighted: [bool; 2]) -> Option<Vec<Prescription>> {
    let (given, dwells) = (root.sections("range"), root.sections("dwell"));
    let (given, dwells) = (given?, dwells?);
    let mut read: Vec<_> = given.iter().map(|section| range(section, lengths, weighted)).collect();
    read.extend(dwells.iter().map(|section| dwell(section, lengths, weighted)));
    let sections = || given.iter().chain(&dwells);
    let named = sections().zip(read).enumerate().map(|(i, (section, read))| {
        let (path, dwell) = (section.path.clone(), i >= given.len());
        read.map(|(range, tolerances)| Prescription { path, dwell, range, tolerances })
    });
    let all: Vec<Prescription> = named.collect::<Option<_>>()?;
    let mut agree = true;
    for (i, section) in sections().enumerate() {
        for other in &all[..i] {
            agree &= agrees(section, &all[i].range, other);
        }
    }
    agree.then_some(all)
}

/// True if a range agrees with another one where they overlap.
fn agrees(section: &Section<'_>, range: &Range, other: &Prescription) -> bool {
    for turns in -4..=4 {
        // The other range is counted from the turn of this one.
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
                let key = ORDERS[order];
                let message = format!(
                    " and `{}` overlap from {} deg to {} deg with different `{key}`",
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
    let [a, b, c] = [0, 1, 2].map(|order| lengths.optional(section, TOLERANCES[order]));
    Some([a?, b?, c?])
}

fn range(section: &Section<'_>, lengths: &Lengths, weighted: [bool; 2]) -> Option<(Range, [Option<f64>; 3])> {
    let ends = angles(section);
    let targets = [0, 1, 2].map(|order| lengths.curve(section, ORDERS[order]));
    let curve = lengths.target(section, ends);
    if section.has("target") {
        section.forbid(&["U"], "`target` is U", "either of them");
    }
    let weight = section.real("weight");
    let tolerances = tolerances(section, lengths);
    section.finish();
    let [u, first, second] = targets;
    let (mut prescribed, tolerances) = ([curve?.or(u?), first?, second?], tolerances?);
    if prescribed.iter().all(Option::is_none) {
        let fault = section.fault(" prescribes nothing");
        return section.refuse(fault.admissible("U, dU, ddU, target").hint("add for example U = 0.5"));
    }
    for order in 1..3 {
        if weighted[order - 1] && prescribed[order].is_none() {
            prescribed[order] = prescribed[order - 1].as_ref().map(Curve::derivative);
        }
    }
    for order in 0..3 {
        if tolerances[order].is_some() && prescribed[order].is_none() {
            let (key, target) = (TOLERANCES[order], ORDERS[order]);
            let message = format!(": there is no `{target}` here to deviate from");
            return section.refuse(section.fault_of(key, message).hint(format!("add `{target}` or remove `{key}`")));
        }
    }
    let ((from, to), weight) = (ends?, weight?);
    Some((Range { law: 0, from, to, prescribed, weight }, tolerances))
}

fn dwell(section: &Section<'_>, lengths: &Lengths, weighted: [bool; 2]) -> Option<(Range, [Option<f64>; 3])> {
    let ends = if section.has("centre") || section.has("width") {
        let because = "centre and width determine it already";
        section.forbid(&["from", "to"], because, "`from` and `to` without `centre` and `width`");
        let centre = section.real("centre");
        let width = section.real("width");
        centre.zip(width).map(|(centre, width)| (centre - 0.5 * width, centre + 0.5 * width))
    } else {
        angles(section)
    };
    let u = section.real("U").map(|u| Curve::polynomial(vec![u * lengths.scale]));
    let weight = section.real("weight");
    let tolerances = tolerances(section, lengths);
    section.finish();
    let tolerances = tolerances?;
    // A dwell has U′ = U″ = 0; they count if they have a weight or a tolerance.
    let still = |order: usize| (weighted[order - 1] || tolerances[order].is_some()).then(Curve::default);
    let ((from, to), prescribed) = (ends?, [Some(u?), still(1), still(2)]);
    Some((Range { law: 0, from, to, prescribed, weight: weight? }, tolerances))
}

/// Points with a weight, which are approximated, and points that hold exactly.
type Points = (Vec<Prescription>, Vec<(String, ExactPoint)>);

/// The [[point]]: each value is a condition, or a range of zero width.
fn points(root: &Section<'_>, lengths: &Lengths) -> Option<Points> {
    let of = |section: &Section<'_>| {
        let phi = section.real("phi");
        let values = [0, 1, 2, 3].map(|order| lengths.optional(section, ORDERS[order]));
        let weight = section.optional("weight");
        section.finish();
        let [u, first, second, third] = [values[0]?, values[1]?, values[2]?, values[3]?];
        let (phi, weight, values) = (phi?, weight?, [u, first, second, third]);
        if values.iter().all(Option::is_none) {
            let fault = section.fault(" has no U");
            return section.refuse(fault.admissible(ORDERS.join(", ")).hint("add for example U = 0.5"));
        }
        let Some(weight) = weight else {
            let exact = |order: usize| {
                Some((section.path_of(ORDERS[order]), ExactPoint { law: 0, phi, order, value: values[order]? }))
            };
            return Some((None, (0..4).filter_map(exact).collect()));
        };
        if third.is_some() {
            let because = "a point with `weight` is met as well as possible in U, U′ and U″";
            section.forbid(&["dddU"], because, "a point without `weight`");
            return None;
        }
        let prescribed = [u, first, second].map(|value| value.map(|value| Curve::polynomial(vec![value])));
        let range = Range { law: 0, from: phi, to: phi, prescribed, weight };
        Some((
            Some(Prescription { path: section.path.clone(), dwell: false, range, tolerances: [None; 3] }),
            Vec::new(),
        ))
    };
    let (fitted, exact): (Vec<Option<Prescription>>, Vec<Vec<_>>) = root.each("point", of)?.into_iter().unzip();
    Some((fitted.into_iter().flatten().collect(), exact.concat()))
}

/// The [[bound]] of a law.
fn bounds(root: &Section<'_>, lengths: &Lengths, law: usize) -> Option<Vec<(String, Bound)>> {
    Some(root.each("bound", |section| bounds_of(section, lengths, vec![(law, 1.0)]))?.concat())
}

/// One bound for constants, or one for each side if they vary with the angle.
fn bounds_of(section: &Section<'_>, lengths: &Lengths, of: Vec<(usize, f64)>) -> Option<Vec<(String, Bound)>> {
    let ends = if section.has("from") || section.has("to") { angles(section) } else { Some((0.0, TAU)) };
    let order = section.choice("of", BOUNDED);
    section.of(lengths.quantity, order.unwrap_or(0) as i32);
    let sides = ["min", "max"].map(|key| lengths.curve(section, key));
    let limit = lengths.optional(section, "limit");
    let target = lengths.target(section, ends);
    section.finish();
    let [min, max] = sides;
    let (min, max, limit, target) = (min?, max?, limit?, target?);
    if limit.is_some() {
        section.forbid(&["min", "max"], "`limit` bounds both sides", "`min` and `max` without `limit`");
    }
    if min.is_none() && max.is_none() && limit.is_none() {
        let fault = section.fault(" bounds nothing");
        return section.refuse(fault.admissible("min, max, limit").hint("add for example limit = 2.5"));
    }
    let ((from, to), order) = (ends?, order?);
    let around = (0..order).fold(target.unwrap_or_default(), |target, _| target.derivative());
    let constant = |side: &Option<Curve>| side.as_ref().map(Curve::constant);
    let (low, high) = match (constant(&min), constant(&max)) {
        (None | Some(Some(_)), None | Some(Some(_))) => {
            let limited = |side: &Option<Curve>, sign: f64| constant(side).flatten().or(limit.map(|l| sign * l));
            let low = limited(&min, -1.0).unwrap_or(f64::NEG_INFINITY);
            (low, limited(&max, 1.0).unwrap_or(f64::INFINITY))
        }
        _ => {
            let worst = (0..=64).map(|i| (to - from) * f64::from(i) / 64.0);
            let sides = worst.filter_map(|x| Some((min.as_ref()?.at(x), max.as_ref()?.at(x))));
            if let Some((low, high)) = sides.into_iter().find(|(low, high)| low > high) {
                return crossed(section, low, high);
            }
            let side = |key: &'static str, curve: Option<Curve>, [min, max]: [f64; 2]| {
                let mut sum = around.clone();
                sum.add(1.0, &curve?);
                Some((section.path_of(key), Bound { of: of.clone(), from, to, order, around: sum, min, max }))
            };
            let sides = [side("min", min, [0.0, f64::INFINITY]), side("max", max, [f64::NEG_INFINITY, 0.0])];
            return Some(sides.into_iter().flatten().collect());
        }
    };
    if low > high {
        return crossed(section, low, high);
    }
    Some(vec![(section.path.clone(), Bound { of, from, to, order, around, min: low, max: high })])
}

/// A lower bound above the upper one.
fn crossed<T>(section: &Section<'_>, low: f64, high: f64) -> Option<T> {
    let (low, high) = (units::short(low), units::short(high));
    let fault = section.fault_at("max", format!(": min {low} exceeds max {high}")).of(&section.path);
    section.refuse(fault.hint("exchange them"))
}

/// Checks that the objective has something to optimise.
fn check_purpose(root: &Section<'_>, kind: Kind, integral: Option<f64>, laws: &[Law]) -> Option<()> {
    let ranges = || laws.iter().flat_map(|law| &law.ranges);
    let refused = |said: &str, hint: &str| root.refuse(root.fault_of("objective", said).hint(hint));
    let alone = of_accelerations(Some(kind)) || matches!(kind, Some(PeakTorque) | None);
    if !alone && ranges().next().is_none() {
        let message = "the task prescribes no motion: there is no [[range]] and no [[dwell]]";
        return root.refuse(root.fault_at("objective", message).hint("add a [[dwell]] with centre, width and U"));
    }
    if laws.len() > 1 && matches!(kind, Some(PeakTorque) | None) {
        return refused(" is for one law", "choose objective = \"peak_acceleration\"");
    }
    let give = "give every [[range]] and [[dwell]] a `tolerance`";
    if let Some(Prescription { path, .. }) =
        ranges().find(|given| alone && given.tolerances.iter().all(Option::is_none))
        && integral.is_none()
    {
        return refused(&format!(" does not look at errors, and `{path}` has no tolerance"), give);
    }
    if alone && laws.iter().all(|law| law.ranges.is_empty() && law.points.is_empty() && law.is_unmoved()) {
        return refused(": nothing makes the follower move", "add [[dwell]] with tolerances, or [[point]]");
    }
    if integral.is_some() && (root.has("clearance") || ranges().next().is_none()) {
        let message = " needs a [[range]] or [[dwell]], and no [[clearance]]";
        let fault = root.fault_at("objective", message).of("integral_tolerance");
        return root.refuse(fault.hint("give every [[dwell]] a `tolerance` instead"));
    }
    if matches!(kind, Some(LongestDwell { .. } | FewestHarmonics { .. })) {
        root.forbid(&["dU_weight", "ddU_weight"], "the objective looks at errors of U", "objective = \"chebyshev\"");
        if let Some(Prescription { path, .. }) = ranges().find(|given| given.tolerances[0].is_none()) {
            return refused(&format!(": `{path}` has no `tolerance` of U"), give);
        }
        let grows = |given: &&Prescription| given.dwell && given.tolerances[1..].iter().any(Option::is_some);
        if let Some(Prescription { path, .. }) =
            ranges().find(grows).filter(|_| matches!(kind, Some(LongestDwell { .. })))
        {
            let message = format!(": `{path}` grows, and tolerances of U′ and U″ would not");
            return refused(&message, "remove `dU_tolerance` and `ddU_tolerance`");
        }
    }
    Some(())
}

/// Checks that the speeds of a section form a range.
fn rising(section: &Section<'_>, slowest: f64, fastest: f64) -> Option<()> {
    if fastest > slowest {
        return Some(());
    }
    let [low, high] = [slowest, fastest].map(|w| units::short(w * 60.0 / TAU));
    let message = format!(": {high} rpm is not above `slowest`, {low} rpm");
    section.refuse(section.fault_of("fastest", message).hint("give a range of speeds"))
}

fn elasticity(root: &Section<'_>, lengths: &Lengths, kind: Option<Kind>) -> Option<Option<Elasticity>> {
    let Some(section) = root.section("elasticity")? else { return Some(None) };
    let w0 = section.real("natural_frequency");
    let damping = section.real("damping_ratio");
    let slowest = section.real("slowest");
    let fastest = section.optional("fastest");
    let tolerance = lengths.optional(&section, "tolerance");
    let amplitude = lengths.optional(&section, "admissible_amplitude");
    let method = section.choice("method", METHODS);
    section.finish();
    let (slowest, fastest, tolerance) = (slowest?, fastest?, tolerance?);
    if fastest.is_none() && tolerance.is_none() {
        let fault = section.fault(": neither `fastest` nor `tolerance` is given");
        return section
            .refuse(fault.hint("give the speed to reach, or the deviation to keep up to the highest possible speed"));
    }
    rising(&section, slowest, fastest.unwrap_or(f64::INFINITY))?;
    let chebyshev = matches!(kind, Some(Some(Chebyshev | ChebyshevSum)));
    if method == Some(Method::Robust) && kind.is_some() && !chebyshev {
        let message = ": the robust profile minimises a largest error over angles and speeds";
        let hint = "choose objective = \"chebyshev\", or method = \"recipe\"";
        return section.refuse(section.fault_of("method", message).hint(hint));
    }
    let elasticity =
        Elasticity { w0: w0?, damping: damping?, slowest, fastest, tolerance, method: method?, amplitude: amplitude? };
    Some(Some(elasticity))
}

fn shaft(root: &Section<'_>, kind: Option<Kind>) -> Option<Option<ShaftGoal>> {
    let wanted = if kind == Some(None) { root.required_section("shaft").map(Some) } else { root.section("shaft") };
    let Some(section) = wanted? else { return Some(None) };
    let parameters = section.parameters(|parameter, read: Option<&Parameters>| match parameter.key {
        "m" => Some(section.real("m")),
        // The profile is unknown yet; while the follower is at rest, only the cam vibrates.
        key => by_ratio(&section, key, read.map(|read| (read.inertia, read.c))),
    });
    if parameters.is_some_and(|parameters| parameters.b == 0.0) {
        // Undamped vibration never decays.
        match section.has("damping_ratio") {
            true => section.real("damping_ratio"),
            false => section.real("b"),
        };
    }
    let [slowest, fastest] = ["slowest", "fastest"].map(|key| section.real(key));
    let norm = section.choice("norm", NORMS);
    let relative = section.choice("torque", WEIGHTS);
    section.finish();
    let (slowest, fastest) = (slowest?, fastest?);
    rising(&section, slowest, fastest)?;
    let Parameters { m, inertia, c, b } = parameters?;
    let shaft = Shaft { m, inertia, c, b };
    Some(Some(ShaftGoal { shaft, slowest, fastest, norm: norm?, relative: relative? }))
}
