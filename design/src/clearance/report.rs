//! The findings as a report: where the contact opens, how hard it closes, whether further impacts follow, which change helps.

use super::borders::{Sequel, borders};
use super::by_model::{Change, DIGITS, QUANTITIES, UNITS};
use super::passage::{Clearance, Figures};
use super::settled::SettledMotion;
use super::tuning::Intervals;
use super::{ClearanceAnalysis, Parameters, Study, figures, printed};
use crate::report::rounding::admissible;
use crate::report::terminal::{range, shown};
use crate::report::unit::{DEG, HZ, J, KG, MM, MM_PER_RAD2, MS, N, NS, ONE, PERCENT, RPM, Unit};
use crate::report::{Advice, Claim, Level, Report, Setting, Table, Verdict, WrittenValue};
use crate::text::{counted, number};
use std::collections::BTreeSet;
use std::f64::consts::TAU;

/// Places and laws listed in a sentence, intervals listed in a cell; the others are in the files.
const LISTED: usize = 6;

/// A change is worth it if it reduces the hardest impact by this part: the sequences of impacts scatter by some per cent.
const GAIN: f64 = 0.1;

/// A quantity of the machine and its values that avoid further impacts after a single passage.
pub(super) struct Tunable<'a> {
    pub name: &'static str,
    pub unit: Unit,
    /// The scene's value (SI).
    pub value: f64,
    pub by_formulas: Option<&'a Intervals>,
    /// The intervals, and the values between which they were searched.
    pub by_model: Option<(&'a Intervals, [f64; 2])>,
}

/// "100°, 254°", or the first few of many.
fn places(angles: impl Iterator<Item = f64>) -> String {
    let mut texts: Vec<String> = angles.map(|phi| format!("{}°", number(phi.to_degrees()))).collect();
    let more = texts.len().saturating_sub(LISTED);
    texts.truncate(LISTED);
    if more > 0 { format!("{} and {more} more", texts.join(", ")) } else { texts.join(", ") }
}

/// The settings for another value (SI) of a quantity, by its place in [`QUANTITIES`].
fn settings(machine: &Parameters, which: usize, value: f64) -> Vec<Setting> {
    let Parameters { m2, b, omega, speed, .. } = *machine;
    let written = |value: f64| WrittenValue::nearest(value, &UNITS[which], DIGITS);
    let damping = 0.5 * b / (m2 * omega);
    match which {
        // The damping ratio stays, so b follows.
        0 => vec![
            Setting::new("backlash.natural_frequency", written(value)).or("backlash.c", m2 * value * value),
            Setting::new("backlash.damping_ratio", damping).or("backlash.b", b * value / omega),
        ],
        1 => vec![Setting::new("drive.speed", written(value.copysign(speed)))],
        2 => vec![Setting::new("backlash.s", written(value))],
        3 => vec![Setting::new("backlash.m1", written(value))],
        _ => vec![Setting::new("backlash.damping_ratio", written(value)).or("backlash.b", 2.0 * value * m2 * omega)],
    }
}

/// The sequel of an impact, in words.
fn sequel(figures: &Figures) -> &'static str {
    match figures.sequel {
        Sequel::None => "contact lasts",
        Sequel::Immediate => "opens at once",
        Sequel::Elastic => "opens again",
        Sequel::Rebound => "rebounds",
        Sequel::Return => "falls back",
    }
}

/// "2 impacts a turn, the hardest with 0.0289 N·s".
fn impacts(settled: &SettledMotion) -> String {
    match settled.impacts {
        0.0 => "no impact".to_owned(),
        impacts => {
            let count = counted(number(impacts), "impact");
            format!("{count} a turn, the hardest with {}", shown(settled.largest_impulse, &NS))
        }
    }
}

impl Study {
    /// The passages with figures, the model's if it has followed them.
    fn known(&self) -> Vec<(&Clearance, Figures)> {
        self.passages.iter().filter_map(|passage| Some((passage, passage.model.or(passage.formula)?))).collect()
    }

    fn hardest(&self) -> Option<Figures> {
        self.known().into_iter().map(|(_, figures)| figures).max_by(|a, b| a.impulse.total_cmp(&b.impulse))
    }

    /// True if the settled motion repeats with no more impacts than passages; if it is unknown, whether each passage ends with
    /// one.
    fn is_calm(&self) -> Option<bool> {
        match self.settled.zip(self.releases) {
            Some((settled, releases)) => Some(settled.repeats && settled.impacts <= releases as f64),
            None => self.calm.by_model.or(self.calm.by_formulas),
        }
    }

    /// Judges the passages and the settled motion.
    fn judge(&self, machine: &Parameters, verdict: &mut Verdict) {
        if self.passages.is_empty() {
            verdict.result(Level::Good, "The contact never opens: it stays on one flank.");
            return;
        }
        let level = if self.is_calm() == Some(true) { Level::Good } else { Level::Mind };
        let opened = places(self.known().iter().map(|(_, figures)| figures.release));
        let count = counted(self.releases.unwrap_or(self.crossings), "time");
        let told = match (&self.settled, level) {
            (Some(settled), _) if !settled.repeats => {
                format!("The motion does not repeat from turn to turn: {}", impacts(settled))
            }
            (Some(settled), Level::Good) => format!("The settled motion has {}", impacts(settled)),
            (Some(settled), _) => format!("The settled motion has further impacts: {}", impacts(settled)),
            (None, Level::Good) => "The contact lasts after a single passage; the settled motion is unknown".to_owned(),
            (None, _) => "Further impacts may follow: the settled motion is unknown".to_owned(),
        };
        verdict.result(level, format!("{told}."));
        verdict.result(level, format!("Without earlier vibration the contact opens {count} a turn, at {opened}."));
        if let Some(hardest) = self.hardest() {
            let at = places(
                [hardest.release + hardest.angle * machine.speed.signum()].map(|phi| phi.rem_euclid(TAU)).into_iter(),
            );
            let force = self.known().iter().filter_map(|(_, figures)| figures.force).reduce(f64::max);
            let force = force.map_or(String::new(), |force| {
                let times = self.contact_force.filter(|without| *without > 0.0).map_or(String::new(), |without| {
                    format!(", {} times the peak without clearance", number(force / without))
                });
                format!("; the contact force then reaches {}{times}", shown(force, &N))
            });
            let impulse = shown(hardest.impulse, &NS);
            verdict.result(level, format!("The hardest single passage closes at {at} with {impulse}{force}."));
        }
    }

    /// Advises the changes that make the settled motion gentler.
    fn advise(&self, machine: &Parameters, verdict: &mut Verdict) {
        if self.passages.is_empty() || self.is_calm() == Some(true) {
            return;
        }
        if machine.e > 0.0 {
            let e = number(machine.e);
            verdict.advice(format!("m1 rebounds after each impact (restitution {e}). Only softer flanks cure this."));
            return;
        }
        let (Some(model), Some(settled)) = (&self.by_model, &self.settled) else { return };
        let now = settled.largest_impulse;
        let quantities = self.quantities(machine);
        let mut cured: Vec<&str> = Vec::new();
        let is_gentler = |change: &&Change| change.settled.largest_impulse.max(change.from_rest) <= (1.0 - GAIN) * now;
        for change in model.changes.iter().filter(is_gentler) {
            let known = cured.contains(&change.quantity);
            if let Some(i) = quantities.iter().position(|of| of.name == change.quantity && !known) {
                let of = &quantities[i];
                let [value, before] =
                    [change.value, of.value].map(|value| WrittenValue::nearest(value, &of.unit, DIGITS));
                let settled = impacts(&change.settled);
                let text = format!("Change the {} from {before} to {value} for gentler impacts ({settled}).", of.name);
                let claim = Claim::Impulse { at_most: (1.0 - GAIN) * now };
                verdict.advice(Advice::new(text).set(settings(machine, i, change.value), claim));
                cured.push(of.name);
            }
        }
        if cured.is_empty() {
            verdict.advice("No single change makes the hardest impact 10 % gentler.");
        }
    }

    /// Adds how certain the verdict is.
    fn certify(&self, verdict: &mut Verdict) {
        if let Some(model) = &self.by_model {
            verdict.certainty(format!(
                "Figures come from the event-driven model. It tried values {} apart (damping {}), one in each interval.",
                shown(model.ratio - 1.0, &PERCENT),
                shown(model.damping_ratio - 1.0, &PERCENT)
            ));
        }
        if self.calm.by_model.is_none() && self.calm.by_formulas.is_some() {
            verdict.certainty("The model has not followed all passages. Closed formulas give the rest.");
        }
        let faults: BTreeSet<&String> = self.passages.iter().filter_map(|p| p.fault.as_ref()).collect();
        verdict.certainty.extend(faults.into_iter().map(|fault| format!("A passage was not followed: {fault}.")));
        verdict.certainty.extend(self.remarks.iter().cloned());
    }

    /// Natural frequency, speed, clearance, mass and damping.
    pub(super) fn quantities(&self, machine: &Parameters) -> Vec<Tunable<'_>> {
        let Parameters { m1, m2, b, omega, speed, s, .. } = *machine;
        let Some(tuning) = &self.tuning else { return Vec::new() };
        let by_formulas = [&tuning.frequency, &tuning.speed, &tuning.clearance, &tuning.mass];
        let values = [omega, speed.abs(), s, m1, 0.5 * b / (m2 * omega)];
        let all = QUANTITIES.into_iter().zip(UNITS).zip(values).enumerate().map(|(i, ((name, unit), value))| Tunable {
            name,
            unit,
            value,
            by_formulas: by_formulas.get(i).copied(),
            by_model: self.by_model.as_ref().map(|model| (model.intervals(i), model.searched[i])),
        });
        all.collect()
    }

    /// The tables of the admissible intervals and of the tried motions.
    fn tables(&self, machine: &Parameters) -> Option<[Table; 2]> {
        let model = self.by_model.as_ref()?;
        let quantities = self.quantities(machine);
        let single = Table::of("A single passage without further impact", &quantities)
            .column("", "quantity", ONE, |q| q.name)
            .column("", "now", ONE, |q| shown(q.value, &q.unit))
            .column("", "searched", ONE, |q| q.by_model.map(|(_, searched)| range(searched, &q.unit)))
            .column("", "admissible", ONE, |q| q.by_model.map(|(found, _)| admissible(found, &q.unit)));
        let unit =
            |change: &Change| quantities.iter().find(|q| q.name == change.quantity).map_or(ONE, |q| q.unit.clone());
        let now =
            self.settled.map(|settled| Change { quantity: "as it is", value: f64::NAN, settled, from_rest: f64::NAN });
        let rows: Vec<&Change> = now.iter().chain(&model.changes).collect();
        let tried = Table::of("Settled motion", rows)
            .column("", "with", ONE, |change| change.quantity)
            .column("", "value", ONE, |change| (!change.value.is_nan()).then(|| shown(change.value, &unit(change))))
            .column("", "impacts a turn", ONE, |change| change.settled.impacts)
            .column("", "largest impulse", NS, |change| change.settled.largest_impulse)
            .column("", "loss a turn", J, |change| change.settled.loss)
            .column("", "repeats", ONE, |change| change.settled.repeats);
        Some([single.into(), tried.into()])
    }
}

impl ClearanceAnalysis {
    /// The verdict on the law of the scene.
    pub fn verdict(&self) -> Verdict {
        let mut verdict = Verdict::default();
        if let Some(study) = self.laws.first() {
            study.judge(&self.machine, &mut verdict);
            study.advise(&self.machine, &mut verdict);
            study.certify(&mut verdict);
        }
        if self.laws.len() > 1 {
            let calm = self.laws.iter().filter(|study| study.is_calm() == Some(true));
            let names: Vec<&str> = calm.map(|study| study.law.as_str()).collect();
            let names = if names.is_empty() { "none".to_owned() } else { names.join(", ") };
            verdict.result(Level::Good, format!("Laws without further impacts: {names}."));
        }
        verdict
    }

    fn passages<'a>(&self, study: &'a Study, known: &'a [(&'a Clearance, Figures)]) -> Table {
        let turns = self.machine.speed.signum();
        Table::of("Passages of the clearance", known)
            .column("from", "from flank", ONE, |(passage, _)| passage.from.to_string())
            .column("", "opens at", DEG, |(_, f)| f.release)
            .digits(4)
            .column("", "closes at", DEG, move |(_, f)| (f.release + turns * f.angle).rem_euclid(TAU))
            .digits(4)
            .column("", "after", MS, |(_, f)| f.time)
            .column("", "impulse", NS, |(_, f)| f.impulse)
            .column("", "loss", J, |(_, f)| f.loss)
            .column("", "largest force", N, |(_, f)| f.force)
            .column("", "times peak without clearance", ONE, move |(_, f)| Some(f.force? / study.contact_force?))
            .column("", "then", ONE, |(_, f)| sequel(f))
            .into()
    }

    fn laws(&self) -> Table {
        let known = |of: fn(&Figures) -> f64| move |study: &Study| study.hardest().map(|figures| of(&figures));
        Table::of("Laws", &self.laws)
            .column("", "law", ONE, |study| &study.law)
            .column("", "stroke", MM, |study| study.stroke)
            .column("", "largest U″", MM_PER_RAD2, |study| study.acceleration)
            .column("", "passages", ONE, |study| study.releases.unwrap_or(study.crossings))
            .column("", "further impacts", ONE, |study| study.is_calm().map(|calm| !calm))
            .column("", "largest impulse", NS, known(|f| f.impulse))
            .column("", "loss a turn", J, |study| study.known().iter().map(|(_, f)| f.loss).sum::<f64>())
            .column("", "impacts a turn, settled", ONE, |study| study.settled.map(|settled| settled.impacts))
            .column("", "largest impulse, settled", NS, |study| study.settled.map(|settled| settled.largest_impulse))
            .column("", "admissible natural frequencies", ONE, |study| {
                study.by_model.as_ref().map(|model| admissible(&model.frequency, &HZ))
            })
            .into()
    }

    /// Adds the tables of the files: after each impact, time of passage, map.
    fn add_files(&self, report: &mut Report) {
        let passages =
            self.laws.iter().flat_map(|study| study.passages.iter().zip(1..).map(move |(p, i)| (study, i, p)));
        let after: Vec<_> =
            passages.flat_map(|(study, i, p)| p.course.iter().map(move |point| (&study.law, i, point))).collect();
        report.table(
            Table::file("after_impact", &after)
                .column("law", "", ONE, |row| row.0)
                .column("passage", "", ONE, |row| row.1 as usize)
                .column("tau", "", ONE, |row| row.2.tau)
                .column("q_over_s_formula", "", ONE, |row| row.2.q[0])
                .column("q_over_s_model", "", ONE, |row| row.2.q[1])
                .column("force_over_cs_formula", "", ONE, |row| row.2.force[0])
                .column("force_over_cs_model", "", ONE, |row| row.2.force[1]),
        );
        let times = figures::passage_times(self);
        let times: Vec<_> = times.iter().flat_map(|(mu, points)| points.iter().map(move |point| (mu, point))).collect();
        report.table(
            Table::file("passage_time", &times)
                .column("mu", "", ONE, |row| row.0)
                .column("K", "", ONE, |row| row.1[0])
                .column("tau1", "", ONE, |row| row.1[1]),
        );
        let (mu, k) = figures::extent(self);
        let borders = borders(mu, k[1]);
        let name = |band: Option<u32>| band.map_or("elastic".to_owned(), |n| format!("immediate {n}"));
        let points: Vec<_> =
            borders.iter().flat_map(|b| b.points.iter().map(move |point| (name(b.band), point))).collect();
        report.table(
            Table::file("map", &points)
                .column("border", "", ONE, |row| &row.0)
                .column("mu", "", ONE, |row| row.1.mu)
                .column("K", "", ONE, |row| row.1.k)
                .column("tau1", "", ONE, |row| row.1.tau),
        );
        report
            .diagram("passage_time", figures::passage_time(self))
            .diagram("multiple_impacts", figures::multiple_impacts(self))
            .diagram("deformation", figures::deformation(self))
            .diagram("force", figures::force(self))
            .diagram("acceleration", figures::acceleration(self));
    }

    /// The report: the law of the scene in full, the others in the comparison.
    pub fn report(&self) -> Report {
        let Parameters { m1, m2, c, b, s, e, speed, omega, .. } = self.machine;
        let mut report = Report::new(&self.scene, "passage of the clearance");
        report.verdict = self.verdict();
        if let Some(study) = self.laws.first() {
            report.table(self.passages(study, &study.known()));
            study.tables(&self.machine).into_iter().flatten().for_each(|table| {
                report.table(table);
            });
        }
        if self.laws.len() > 1 {
            report.table(self.laws());
        }
        report.lines("Drive", [format!(
            "m1 {}, m2 {}, natural frequency {} (stiffness {}), damping ratio {}, clearance {}, restitution {}; {}.",
            shown(m1, &KG),
            shown(m2, &KG),
            shown(omega, &HZ),
            shown(c, &Unit::of("N/m")),
            number(0.5 * b / (m2 * omega)),
            shown(s, &MM),
            number(e),
            shown(speed, &RPM)
        )]);
        self.add_files(&mut report);
        printed::explain(self, &mut report);
        report
    }
}
