//! Kaltofen's closed formulas ([`crate::formulas::passage`]) compared with the model, for `--explain`.

use super::by_model::DIGITS;
use super::passage::{Clearance, Figures};
use super::tuning::SOURCE_BOUND;
use super::{ClearanceAnalysis, Study, WARN};
use crate::report::rounding::admissible;
use crate::report::terminal::shown;
use crate::report::unit::{DEG, HZ, J, KG, MM, MM_PER_RAD3, MS, N, NS, ONE, PERCENT, RPM, Unit};
use crate::report::{Report, Table, WrittenValue};
use crate::text::number;

/// A figure of a passage in files: its key, its heading, its unit.
type Figure = (&'static str, &'static str, Unit, fn(&Figures) -> Option<f64>);

const FIGURES: [Figure; 8] = [
    ("tau1", "τ₁", ONE, |f| Some(f.tau)),
    ("time", "time", MS, |f| Some(f.time)),
    ("angle", "angle", DEG, |f| Some(f.angle)),
    ("impulse", "impulse", NS, |f| Some(f.impulse)),
    ("loss", "loss", J, |f| Some(f.loss)),
    ("vibration", "vibration", MM, |f| Some(f.vibration)),
    ("max_q", "largest |q|", MM, |f| f.elongation),
    ("max_force", "largest force", N, |f| f.force),
];

/// A passage with its law and number, by the formulas or by the model.
type Row<'a> = (&'a Study, usize, &'a Clearance, &'static str, Option<Figures>);

/// The passages of all laws by the formulas and by the model.
fn passages(findings: &ClearanceAnalysis) -> Table {
    let numbered =
        findings.laws.iter().flat_map(|study| study.passages.iter().zip(1..).map(move |(p, i)| (study, i, p)));
    let rows: Vec<Row> = numbered
        .flat_map(|(study, i, p)| [("formula", p.formula), ("model", p.model)].map(|(by, f)| (study, i, p, by, f)))
        .collect();
    let mu = findings.machine.mu;
    let mut table = Table::of("Passages by Kaltofen's closed formulas and by the event-driven model", &rows)
        .key("passages")
        .column("law", "law", ONE, |row: &Row| &row.0.law)
        .column("passage", "passage", ONE, |row| row.1)
        .column("from", "from", ONE, |row| row.2.from.to_string())
        .column("by", "by", ONE, |row| row.3)
        .column("dddU", "U‴", MM_PER_RAD3, |row| row.2.crossing.map(|c| c.jerk))
        .column("K", "K", ONE, |row| row.2.k)
        .hidden("mu", ONE, move |_| mu)
        .column("release", "release", DEG, |row| row.4.map(|f| f.release))
        .digits(5);
    for (key, heading, unit, of) in FIGURES {
        table = table.column(key, heading, unit, move |row: &Row| row.4.as_ref().and_then(of));
    }
    table
        .column("then", "then", ONE, |row| row.4.map(|f| f.sequel.name()))
        .column("release_after_tau", "after τ*", ONE, |row| row.4.and_then(|f| f.release_after))
        .hidden("quasi_static_error", ONE, |row| row.2.quasi_static)
        .hidden("truncation_error", ONE, |row| row.2.truncation)
        .hidden("spacing", DEG, |row| row.2.spacing)
        .hidden("vibration_left", ONE, |row| row.2.left)
        .hidden("fault", ONE, |row| row.2.fault.clone())
        .into()
}

/// Compares formulas and model, the values that they admit, and the doubts about the formulas.
pub(super) fn explain(findings: &ClearanceAnalysis, report: &mut Report) {
    report.explain_table(passages(findings));
    let machine = &findings.machine;
    let Some(study) = findings.laws.first() else { return };
    let quantities = study.quantities(machine);
    report.explain_table(
        Table::of("Without further impacts by the closed formulas", &quantities)
            .column("", "quantity", ONE, |q| q.name)
            .column("", "now", ONE, |q| shown(q.value, &q.unit))
            .column("", "admissible", ONE, |q| q.by_formulas.map(|found| admissible(found, &q.unit))),
    );
    let mut lines = vec![
        "K. Kaltofen, Zur Dynamik spielbehafteter periodischer Antriebe, Liberec 1996: U a cubic about the release, no \
         damping, no rebound, no vibration left from earlier impacts. K = s/(|U‴| η³), μ = m1/m2, η = Ω/ω, ω² = c/m2; τ = ω t, τ₁ at \
         the impact, τ* after it. Printed wrong: U⁗ in (10), (16) and Ü in (13), (18), where the third derivative is meant."
            .to_owned(),
    ];
    if let Some(tuning) = &study.tuning {
        lines.push(format!(
            "Admissible K at μ = {}: {}{}. The source's bound K ≤ {SOURCE_BOUND}, natural frequencies up to {}, {}.",
            number(machine.mu),
            admissible(&tuning.k.intervals, &ONE),
            if tuning.k.cut {
                format!(", and narrower intervals up to {}", number(tuning.k.elastic))
            } else {
                String::new()
            },
            WrittenValue::rounded(tuning.source_frequency, &HZ, DIGITS, false),
            if tuning.k.intervals.len() > 1 { "ignores releases right after the impact" } else { "is sufficient" }
        ));
        if tuning.mass_cut {
            let first = tuning.mass.first().map_or(0.0, |ends| ends[0]);
            lines.push(format!("Below m1 = {} there are further, ever narrower intervals.", shown(first, &KG)));
        }
        if tuning.quasi_static_speed.is_finite() && tuning.quasi_static_frequency > 0.0 {
            lines.push(format!(
                "Their quasi-static release is accurate to 5 % from a natural frequency of {} on at this speed, up to {} at \
                 this natural frequency.",
                WrittenValue::rounded(tuning.quasi_static_frequency, &HZ, DIGITS, true),
                WrittenValue::rounded(tuning.quasi_static_speed, &RPM, DIGITS, false)
            ));
        }
    }
    let worst = |value: fn(&Clearance) -> Option<f64>| study.passages.iter().filter_map(value).fold(0.0, f64::max);
    let doubts = [
        ("The next term of the quasi-static deformation, η²|U⁽⁵⁾/U‴|", worst(|p| p.quasi_static)),
        ("The next term of U over the passage, Δφ|U⁗/4U‴|", worst(|p| p.truncation)),
    ];
    let doubts = doubts.into_iter().filter(|(_, share)| *share > WARN);
    lines.extend(
        doubts.map(|(what, share)| format!("{what}, is up to {} of it: trust the model.", shown(share, &PERCENT))),
    );
    let signs = study.releases.map_or(String::new(), |n| format!("; the contact force of the periodic motion has {n}"));
    let ignored = if study.ignored > 0 { format!(" ({} more are too small)", study.ignored) } else { String::new() };
    let differs = |study: &&Study| study.calm.by_formulas.zip(study.calm.by_model).is_some_and(|(a, b)| a != b);
    let differing: Vec<&str> = findings.laws.iter().filter(differs).map(|study| &*study.law).collect();
    if !differing.is_empty() {
        let laws = differing.join(", ");
        lines.push(format!(
            "The formulas and the model disagree on further impacts after a passage: {laws}. The model decides."
        ));
    }
    lines.push(format!("U″ has {} changes of sign in a turn{ignored}{signs}.", study.crossings));
    report.explain("Closed formulas", lines);
}
