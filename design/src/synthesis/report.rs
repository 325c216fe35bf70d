//! The report of a synthesis: tables, files, JSON.

use super::clearance::Clearance;
use super::deviation::Extreme;
use super::elastic::Resonance;
use super::infeasible::degrees;
use super::laws::Rival;
use super::shaft::ShaftGoal;
use super::shaft_study::Nonlinear;
use super::study::{Method, Study, Widths};
use super::together::Together;
use super::{Bound, Norm, Objective, Range, Task};
use crate::report::rounding::Rounding;
use crate::report::terminal::shown;
use crate::report::unit::{DEG, MM, MM_PER_RAD, MM_PER_RAD2, MM_PER_RAD3, NM, ONE, RPM, Unit};
use crate::report::{Block, Report, Table, Value};
use crate::text::digits;
use serde_json::json;
use std::f64::consts::TAU;

/// Points of the profile in its CSV.
const POINTS: usize = 720;

/// Units of U and its derivatives.
pub(super) const ORDERS: [Unit; 4] = [MM, MM_PER_RAD, MM_PER_RAD2, MM_PER_RAD3];

/// U and its derivatives, as headings and in files.
const NAMES: [(&str, &str); 4] = [("U", "U"), ("U′", "dU"), ("U″", "ddU"), ("U‴", "dddU")];

/// U′U″.
pub(super) const TORQUE: Unit = Unit::new("mm²/rad³", 1e6);

/// The laws of the task and the standard laws for comparison, with their figures.
fn laws<'a>(studies: &'a [Study]) -> Table {
    let named = |study: &'a Study| {
        let name = |i: usize, rival: &Rival| match (study.law(), i) {
            ("", _) => rival.name.clone(),
            (law, 0) => law.to_owned(),
            (law, _) => format!("{law}, {}", rival.name),
        };
        study.rivals.iter().enumerate().map(move |(i, rival)| (name(i, rival), rival, i))
    };
    let rows: Vec<(String, &Rival, usize)> = studies.iter().flat_map(named).collect();
    let mut table = Table::of("Laws", &rows)
        .key("laws")
        .column("law", "law", ONE, |(name, ..)| name)
        .column("peak_dU", "largest |U′|", MM_PER_RAD, |(_, law, _)| law.peaks[0])
        .column("peak_ddU", "largest |U″|", MM_PER_RAD2, |(_, law, _)| law.peaks[1])
        .column("peak_torque", "largest |U′U″|", TORQUE, |(_, law, _)| law.torque)
        .column("harmonics", "harmonics", ONE, |(_, law, _)| law.harmonics);
    if let (Some(behind), Some(given)) = (&studies[0].elastic, &studies[0].assignment.elasticity) {
        let reached = |i: usize| behind.reaches[i].map(|eta| eta * given.w0);
        let note = "Without damping a law with dwells resonates at every speed: its harmonics do not end.";
        table = table
            .column("reached", "within tolerance up to", RPM, move |(.., i)| reached(*i))
            .rounded(Rounding::Inward)
            .below((given.damping == 0.0 && rows.iter().any(|(.., i)| *i > 0)).then(|| note.to_owned()));
    }
    if let Some(shaft) = &studies[0].shaft {
        let last = |i: usize, n: usize| shaft.laws[i].points.last().map(|point| point[n]);
        // The slowest speed may have it already.
        let first = |i: usize, limit: usize| {
            let w = shaft.laws[i].exceeded[limit]?;
            Some(if w <= shaft.goal.slowest { Value::AtMost(w) } else { w.into() })
        };
        let at = shown(shaft.goal.fastest, &RPM);
        table = table
            .column("shaft_torque", format!("shaft torque at {at}"), NM, move |(.., i)| last(*i, 1))
            .column("magnification", "over kinetostatic", ONE, move |(.., i)| last(*i, 2))
            .hidden("magnified_1_5", RPM, move |(.., i)| first(*i, 0))
            .column("magnified_2", "2 times from", RPM, move |(.., i)| first(*i, 1));
    }
    table.into()
}

/// The largest errors in each range, of what is delivered.
fn errors<'a>(studies: &'a [Study]) -> Table {
    let ranges =
        |study: &'a Study| study.assignment.task.ranges.iter().zip(0..).map(move |(range, i)| (study, range, i));
    let rows: Vec<(&Study, &Range, usize)> = studies.iter().flat_map(ranges).collect();
    let speeds = studies[0].speeds().map_or(String::new(), |speeds| format!(" of the output, {speeds}"));
    let table = Table::of(format!("Largest errors{speeds}"), &rows)
        .column("", "range", ONE, |(study, _, i)| study.range(*i))
        .column("", "angles", DEG, |(_, range, _)| [range.from, range.to]);
    let all = ORDERS.into_iter().zip(NAMES).take(3).enumerate();
    all.fold(table, |table, (order, (unit, (name, _)))| {
        table.column("", format!("of {name}"), unit, move |(study, _, i)| study.delivered()[*i][order])
    })
    .into()
}

/// The resonances that the cam excites.
fn resonances(study: &Study) -> Option<Table> {
    let given = study.assignment.elasticity.as_ref()?;
    let table = Table::of("Resonances of the cam", &study.elastic.as_ref()?.resonances)
        .column("", "harmonic", ONE, |r: &Resonance| r.harmonic)
        .column("", "speed", RPM, |r| r.eta * given.w0)
        .column("", "amplitude", MM, |r| r.amplitude)
        .column("", "admissible", ONE, |r| given.amplitude.map(|limit| r.amplitude <= limit));
    Some(table.into())
}

/// The law over the turn, which a scene reads again.
fn profile(study: &Study) -> Table {
    let angles: Vec<f64> = (0..POINTS).map(|i| TAU * i as f64 / POINTS as f64).collect();
    let mut table = Table::file("profile", &angles).hidden("phi", DEG, |phi| *phi);
    for (order, unit) in ORDERS.into_iter().enumerate() {
        table = table.hidden(NAMES[order].1, unit, move |phi| study.cam.at(*phi).0[order]);
    }
    table = table.hidden("deviation", MM, |phi| Some(study.cam.at(*phi).0[0] - study.prescribed_at(*phi)?));
    if let Some(behind) = &study.elastic {
        table = table.hidden("output_deviation", MM, |phi| {
            let prescribed = study.prescribed_at(*phi)?;
            Some(behind.envelope(*phi).map(|y| y - prescribed))
        });
    }
    table.into()
}

/// The curves of a law for its diagrams.
fn curves<'a>(study: &'a Study) -> Vec<Table> {
    let mut tables = vec![profile(study)];
    if let Some(behind) = &study.elastic {
        let curves = study.rivals.iter().zip(&behind.curves);
        let points: Vec<_> = curves.flat_map(|(law, curve)| curve.iter().map(move |point| (law, point))).collect();
        let table = Table::file("speed", &points).hidden("law", ONE, |(law, _)| &law.name);
        tables.push(table.hidden("eta", ONE, |(_, p)| p[0]).hidden("deviation", MM, |(_, p)| p[1]).into());
    }
    if let Some(shaft) = &study.shaft {
        let laws = study.rivals.iter().zip(&shaft.laws);
        let mut points: Vec<_> =
            laws.flat_map(|(rival, law)| law.points.iter().map(|point| (rival.name.as_str(), *point))).collect();
        let rigid = shaft.goal.shaft.m * study.rivals[0].torque;
        points.extend(shaft.nonlinear.iter().filter_map(|at| {
            let torque = *at.torque.as_ref().ok()?;
            Some(("harmonic synthesis, nonlinear drive", [at.w, torque, torque / (rigid * at.w * at.w)]))
        }));
        let table = Table::file("shaft", &points).hidden("law", ONE, |(law, _)| *law);
        let table = table.hidden("speed", RPM, |(_, p)| p[0]).hidden("peak_torque", NM, |(_, p)| p[1]);
        tables.push(table.hidden("over_kinetostatic", ONE, |(_, p)| p[2]).into());
    }
    if !study.widths.is_empty() {
        let of = |curve: &'a Widths| curve.points.iter().map(move |point| (curve, point));
        let points: Vec<_> = study.widths.iter().flat_map(of).collect();
        let table = Table::file("dwell_width", &points).hidden("harmonics", ONE, |(curve, _)| curve.order);
        let table = table.hidden("dwell_width", DEG, |(_, p)| p[0]).hidden("chebyshev", ONE, |(_, p)| p[1]);
        tables.push(table.hidden("least_squares", ONE, |(_, p)| p[2]).into());
    }
    tables
}

impl Study {
    /// Its name among several laws; empty of one.
    pub(super) fn law(&self) -> &str {
        self.assignment.names.laws.first().map_or("", String::as_str)
    }

    /// " (gripper)"; empty of one.
    pub(super) fn of_law(&self) -> String {
        if self.law().is_empty() { String::new() } else { format!(" ({})", self.law()) }
    }

    /// The name of a range.
    pub(super) fn range(&self, i: usize) -> String {
        self.assignment.names.ranges.get(i).cloned().unwrap_or_else(|| format!("range {}", i + 1))
    }

    /// Ũ where U is prescribed.
    fn prescribed_at(&self, phi: f64) -> Option<f64> {
        self.assignment.task.ranges.iter().find_map(|range| {
            let target = range.prescribed[0].as_ref()?;
            let phi = range.from + (phi - range.from).rem_euclid(TAU);
            (phi <= range.to).then(|| target.at(phi - range.from))
        })
    }

    /// Sentences on the method, and on the formulas of the source.
    fn explained(&self) -> Vec<String> {
        let [uncertainty, resolution] = [self.motion.uncertainty, self.motion.resolution].map(|x| shown(x, &MM));
        let mut lines = vec![format!(
            "The coefficients are known to {uncertainty}; such changes alter the error by less than {resolution}, the \
             rounding of numbers of thirty digits."
        )];
        if let (Some(behind), Some(given)) = (&self.elastic, &self.assignment.elasticity) {
            let at = |eta: f64| format!("η = Ω/ω₀ = {eta:.4} ({})", shown(eta * given.w0, &RPM));
            lines.push(match given.method {
                Method::Robust => {
                    "The cam is robust: its largest error over all angles and speeds is minimal.".to_owned()
                }
                Method::Recipe => {
                    format!(
                        "The cam is the motion inverted with damping, 4.6.2 (5), at {}.",
                        at(behind.optimum.unwrap_or(0.0))
                    )
                }
                Method::None => "The cam is the motion itself.".to_owned(),
            });
            let [slowest, fastest] = behind.looked_at.map(at);
            lines.push(format!("Speeds from {slowest} to {fastest}; harmonic k is in resonance at kη = 1."));
            let motion = shown(self.assignment.task.largest_error(&self.motion.series), &MM);
            lines.push(format!("Without elasticity the least largest error would be {motion}."));
        }
        let level = |[x, level]: &[f64; 2]| format!("{} ({})", digits(*x, 6, -4), shown(*level, &MM));
        if !self.tried.is_empty() {
            let tried: Vec<String> = self.tried.iter().map(level).collect();
            lines.push(format!("Tried harmonics or factors of the widths, with largest errors: {}.", tried.join(", ")));
        }
        lines.extend(self.cubics.map(|cubics| cubics.line()));
        lines
    }

    /// The result as JSON, in SI; null for infinite or unknown values.
    fn value(&self) -> serde_json::Value {
        let motion = &self.motion;
        let behind = self.elastic.as_ref().map(|behind| {
            json!({
                "eta_opt": behind.optimum, "eta_reached": behind.reached,
                "largest_deviation": behind.worst, "objective": behind.objective, "speeds_looked_at": behind.looked_at,
                "output_deviations": behind.over_speeds, "deviations_at_rest": behind.at_rest,
                "resonances": behind.resonances,
            })
        });
        let nonlinear = |at: &Nonlinear| {
            let torque = at.torque.as_ref().ok();
            json!({ "speed": at.w, "linear_torque": at.linear, "nonlinear_torque": torque })
        };
        let shaft = self.shaft.as_ref().map(|shaft| {
            json!({
                "speed_of_magnification_1.5": shaft.laws[0].exceeded[0],
                "speed_of_magnification_2": shaft.laws[0].exceeded[1],
                "unstable_at": shaft.faults.iter().map(|(w, _)| w).collect::<Vec<_>>(),
                "nonlinear": shaft.nonlinear.iter().map(nonlinear).collect::<Vec<_>>(),
            })
        });
        json!({
            "name": self.assignment.name,
            "objective": {
                "kind": words(&self.assignment.task), "value": motion.objective, "resolution": motion.resolution,
            },
            "uncertainty_of_coefficients": motion.uncertainty, "undetermined_coefficients": motion.undetermined,
            "cam": { "a": self.cam.a, "b": &self.cam.b[1..] },
            "motion": { "A": motion.series.a, "B": &motion.series.b[1..] },
            "excess_of_conditions": motion.excess, "deviations_of_the_motion": motion.errors,
            "peaks": self.peaks.map(|peak| peak.value.abs()),
            "local_optima": motion.optima, "tried": self.tried,
            "error_of_the_cubics": self.cubics.map(|cubics| cubics.error),
            "elastic_output": behind, "shaft": shaft,
        })
    }
}

impl Together {
    /// The report.
    pub fn report(&self) -> Report {
        let mut report = Report::new(&self.assignment.name, "cam profile of few harmonics");
        report.verdict = self.verdict();
        let [first, others @ ..] = &self.studies[..] else { return report };
        let bounds = self.bounds();
        let room = |(_, bound, least): &(&str, &Bound, Extreme)| shown(least.value, &ORDERS[bound.order.min(3)]);
        let restrictions = Table::of("Bounds", &bounds)
            .column("", "bound", ONE, |(name, ..)| *name)
            .column("", "angles", DEG, |(_, bound, _)| [bound.from, bound.to])
            .column("", "least reserve", ONE, room)
            .column("", "at", DEG, |(.., least)| degrees(least.phi));
        let clearances: Vec<_> = self.clearances().collect();
        let name = |i: usize| move |(clearance, _): &(&Clearance, Extreme)| self.name_of(clearance.laws[i]);
        let distances = Table::of("Distances of tools", &clearances)
            .column("", "tool", ONE, name(0))
            .column("", "and tool", ONE, name(1))
            .column("", "asked for", MM, |(clearance, _)| clearance.distance)
            .column("", "least distance", MM, |(_, least)| Value::At(least.value, least.phi));
        report.table(restrictions).table(distances).table(errors(&self.studies)).table(laws(&self.studies));
        report.body.extend(resonances(first).map(Block::Table));
        report.body.retain(|block| matches!(block, Block::Table(table) if !table.rows.is_empty()));
        if let Some(shaft) = &first.shaft {
            let nonlinear = shaft.nonlinear.iter().filter_map(|at| Some((at.w, at.torque.as_ref().err()?)));
            let linear = shaft.faults.iter().map(|(w, fault)| (*w, fault));
            let line = |(w, fault)| format!("at {}: {fault}", shown(w, &RPM));
            report.lines("Speeds without stable periodic motion", linear.chain(nonlinear).map(line));
        }
        let (kind, value) = (words(&self.assignment.task), first.motion.objective);
        report.explain("Computation", [format!("The objective is {kind}; its value is {value:e} in SI.")]);
        if let Some(figure) = self.figure() {
            report.diagram("distance", figure);
        }
        for study in &self.studies {
            report.explain("", study.explained().into_iter().map(|line| line + &study.of_law()));
            let of = |key: &str| if others.is_empty() { key.to_owned() } else { format!("{}.{key}", study.law()) };
            for table in curves(study) {
                report.table(Table { key: table.key.as_deref().map(of), ..table });
            }
            for (key, diagram) in study.figures() {
                report.diagram(&of(&key), diagram);
            }
        }
        report
    }

    /// The result in SI, as JSON has it.
    pub fn findings(&self) -> serde_json::Value {
        let kept = |(name, bound, reserve): (&str, &Bound, Extreme)| {
            (bound.of.len() > 1).then(|| json!({ "name": name, "reserve": reserve.value, "phi": reserve.phi }))
        };
        let clear = |(clearance, least): (&Clearance, Extreme)| {
            let laws = clearance.laws.map(|law| self.name_of(law));
            json!({ "laws": laws, "distance": clearance.distance, "least_distance": least.value, "phi": least.phi })
        };
        match &self.studies[..] {
            [only] => only.value(),
            all => json!({
                "name": self.assignment.name,
                "objective": { "kind": words(&self.assignment.task), "value": all.first().map(|one| one.motion.objective) },
                "restrictions": self.bounds().into_iter().filter_map(kept).collect::<Vec<_>>(),
                "clearances": self.clearances().map(clear).collect::<Vec<_>>(),
                "laws": all.iter().map(Study::value).collect::<Vec<_>>(),
            }),
        }
    }
}

/// The objective as the source calls it.
fn words(task: &Task) -> &'static str {
    let at_points = task.ranges.iter().all(|range| range.from == range.to);
    match task.objective {
        Objective::LeastSquares if !at_points => "S1 (integral of the squared errors)",
        Objective::LeastSquares => "S2 (sum of the squared errors at points)",
        Objective::Chebyshev if !at_points => "S3 (largest error)",
        Objective::Chebyshev => "S4 (largest error at points)",
        Objective::ChebyshevSum => "S5 (largest sum of the errors)",
        Objective::PeakAcceleration => "peak of |U″|",
        Objective::MeanSquareAcceleration => "∫U″² dφ over the turn",
        Objective::LongestDwell { .. } => "longest dwell",
        Objective::FewestHarmonics { .. } => "fewest harmonics",
        Objective::PeakTorque => "peak of |U′U″|",
        Objective::ShaftTorque(ShaftGoal { norm: Norm::Peak, relative: true, .. }) => "largest shaft torque over m Ω²",
        Objective::ShaftTorque(ShaftGoal { norm: Norm::Rms, relative: true, .. }) => "mean shaft torque over m Ω²",
        Objective::ShaftTorque(ShaftGoal { norm: Norm::Peak, .. }) => "largest shaft torque",
        Objective::ShaftTorque(ShaftGoal { norm: Norm::Rms, .. }) => "root mean square of the shaft torque",
    }
}
