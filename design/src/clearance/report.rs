//! The findings as a report: where the contact opens, how hard it closes, whether further impacts follow, which change cures.

use super::borders::{Sequel, borders};
use super::passage::{Clearance, Figures};
use super::tuning::{Intervals, nearest};
use super::{Findings, Parameters, Study, figures, printed};
use crate::report::terminal::{range, ranges, shown};
use crate::report::unit::{DEG, HZ, J, KG, MM, MM_PER_RAD2, MS, N, NS, ONE, PERCENT, RPM, Unit};
use crate::report::{Level, Report, Table, Verdict};
use crate::text::{counted, number};
use camdrive::drives::Fault;
use std::f64::consts::TAU;

/// Places and laws that a sentence lists, intervals that a cell lists; the others are in the files.
const LISTED: usize = 6;

/// A quantity of the machine, and where it avoids further impacts.
pub(super) struct Tunable<'a> {
    pub name: &'static str,
    pub unit: Unit,
    /// That of the scene (SI).
    pub value: f64,
    pub by_formulas: Option<&'a Intervals>,
    /// The intervals, and the values between which they were looked for.
    pub by_model: Option<(&'a Intervals, [f64; 2])>,
}

/// "100.3°, 254°", the first of them where there are many.
fn places(angles: impl Iterator<Item = f64>) -> String {
    let mut texts: Vec<String> = angles.map(|phi| format!("{:.1}°", phi.to_degrees())).collect();
    let more = texts.len().saturating_sub(LISTED);
    texts.truncate(LISTED);
    if more > 0 { format!("{} and {more} more", texts.join(", ")) } else { texts.join(", ") }
}

/// What follows an impact, in words.
fn sequel(figures: &Figures) -> &'static str {
    match figures.sequel {
        Sequel::None => "contact lasts",
        Sequel::Immediate => "opens at once",
        Sequel::Elastic => "opens again",
        Sequel::Rebound => "rebounds",
        Sequel::Return => "falls back",
    }
}

impl Study {
    /// The passages that are known, by the model where it has followed them.
    fn known(&self) -> Vec<(&Clearance, Figures)> {
        self.passages.iter().filter_map(|passage| Some((passage, passage.model.or(passage.formula)?))).collect()
    }

    fn hardest(&self) -> Option<Figures> {
        self.known().into_iter().map(|(_, figures)| figures).max_by(|a, b| a.impulse.total_cmp(&b.impulse))
    }

    /// What the passages are like.
    fn judge(&self, machine: &Parameters, verdict: &mut Verdict) {
        let known = self.known();
        let Some(hardest) = self.hardest() else {
            let word = if self.passages.is_empty() {
                "The contact never opens: it stays on one flank."
            } else {
                "The contact opens, but no passage could be followed."
            };
            verdict.result(if self.passages.is_empty() { Level::Good } else { Level::Mind }, word);
            return;
        };
        let closes = |f: &Figures| (f.release + f.angle * machine.speed.signum()).rem_euclid(TAU);
        let opened = places(known.iter().map(|(_, figures)| figures.release));
        let count = counted(self.releases.unwrap_or(self.crossings), "time");
        verdict.result(Level::Good, format!("The contact opens {count} a turn, at {opened}."));
        let force = known.iter().filter_map(|(_, figures)| figures.force).reduce(f64::max);
        let force = force.map_or(String::new(), |force| {
            let times = self.contact_force.filter(|without| *without > 0.0).map_or(String::new(), |without| {
                format!(", {} times the largest one without clearance", number(force / without))
            });
            format!("; the contact force after an impact reaches {}{times}", shown(force, &N))
        });
        verdict.result(
            Level::Good,
            format!(
                "It closes hardest at {} with {}{force}.",
                places([closes(&hardest)].into_iter()),
                shown(hardest.impulse, &NS)
            ),
        );
        let further = known.iter().filter(|(_, figures)| figures.sequel != Sequel::None);
        let further = places(further.map(|(_, figures)| figures.release));
        match self.calm.verdict() {
            Some(true) => {
                verdict.result(Level::Good, "After each passage the contact lasts: no further impact follows.")
            }
            Some(false) if further.is_empty() => verdict.result(Level::Mind, "Further impacts follow."),
            Some(false) => verdict.result(Level::Mind, format!("Further impacts follow the passages from {further}.")),
            None => verdict.result(Level::Mind, "Whether further impacts follow is not known."),
        };
        if let Some(settled) = &self.settled {
            let repeats = if settled.repeats { "" } else { "; no turn is like the one before" };
            verdict.result(
                Level::Good,
                format!(
                    "The settled motion has {} a turn, the hardest with {}{repeats}.",
                    counted(number(settled.impacts), "impact"),
                    shown(settled.largest_impulse, &NS)
                ),
            );
        }
    }

    /// Which change avoids further impacts.
    fn advise(&self, machine: &Parameters, verdict: &mut Verdict) {
        if self.passages.is_empty() || self.calm.verdict() == Some(true) {
            return;
        }
        if machine.e > 0.0 {
            let e = number(machine.e);
            verdict.advice(format!(
                "With a restitution of {e} m1 rebounds after each impact; only softer flanks cure this."
            ));
            return;
        }
        let (mut cures, mut none) = (Vec::new(), Vec::new());
        for quantity in self.quantities(machine) {
            let Some(intervals) = quantity.by_model.map(|(intervals, _)| intervals).or(quantity.by_formulas) else {
                continue;
            };
            match nearest(intervals, quantity.value) {
                Err(Some(end)) => cures.push(format!(
                    "{} {} instead of {}",
                    quantity.name,
                    shown(end, &quantity.unit),
                    shown(quantity.value, &quantity.unit)
                )),
                Err(None) => none.push(quantity.name),
                // The formulas admit what the model does not.
                Ok(_) => {}
            }
        }
        if !cures.is_empty() {
            verdict.advice(format!(
                "At the border of one of these no further impact follows a single passage: {}. Go beyond it, and look at the \
                 settled motion there: vibration left of earlier passages may bring impacts back.",
                cures.join(", ")
            ));
        }
        if !none.is_empty() {
            verdict.advice(format!("No other {} alone does so.", none.join(", ")));
        }
    }

    /// How sure this is.
    fn certify(&self, machine: &Parameters, verdict: &mut Verdict) {
        if let Some(model) = &self.by_model {
            let unknown = match model.unknown {
                0 => String::new(),
                count => format!("; {count} of them could not be followed and count as not admissible"),
            };
            verdict.certainty(format!(
                "By the event-driven model, at values {} apart (damping {}); narrower intervals may be missing{unknown}.",
                shown(model.ratio - 1.0, &PERCENT),
                shown(model.damping_ratio - 1.0, &PERCENT)
            ));
        } else if machine.e == 0.0 && self.calm.verdict() == Some(false) {
            verdict.certainty(
                "The model has not been followed at other values: changes are those of the closed formulas.",
            );
        }
        if self.calm.by_model.is_none() && self.calm.by_formulas.is_some() {
            verdict.certainty("The model gives no answer: this is by the closed formulas.");
        } else if self.calm.differs() {
            verdict.certainty("The closed formulas say otherwise; they do not hold here.");
        }
        let mut faults: Vec<(&String, Vec<String>)> = Vec::new();
        for (i, fault) in self.passages.iter().enumerate().filter_map(|(i, p)| Some((i, p.fault.as_ref()?))) {
            match faults.iter_mut().find(|(known, _)| *known == fault) {
                Some((_, list)) => list.push((i + 1).to_string()),
                None => faults.push((fault, vec![(i + 1).to_string()])),
            }
        }
        for (fault, list) in faults {
            verdict.certainty(format!("Passage {}: {fault}.", list.join(", ")));
        }
        verdict.certainty.extend(self.remarks.iter().cloned());
    }

    /// Natural frequency, speed, clearance, mass and damping.
    pub(super) fn quantities(&self, machine: &Parameters) -> Vec<Tunable<'_>> {
        let Parameters { m1, m2, b, omega, speed, s, .. } = *machine;
        let Some(tuning) = &self.tuning else { return Vec::new() };
        let model = self.by_model.as_ref();
        let of_model = |which: usize| {
            model.map(|m| ([&m.frequency, &m.speed, &m.clearance, &m.mass, &m.damping][which], m.searched[which]))
        };
        let by_formulas = [&tuning.frequency, &tuning.speed, &tuning.clearance, &tuning.mass];
        let quantities = [
            ("natural frequency", HZ, omega),
            ("speed", RPM, speed.abs()),
            ("clearance", MM, s),
            ("mass m1", KG, m1),
            ("damping ratio", ONE, 0.5 * b / (m2 * omega)),
        ];
        let all = quantities.into_iter().enumerate().map(|(i, (name, unit, value))| Tunable {
            name,
            unit,
            value,
            by_formulas: by_formulas.get(i).copied(),
            by_model: of_model(i),
        });
        all.collect()
    }
}

impl Findings {
    /// The answer, on the law of the scene.
    pub fn verdict(&self) -> Verdict {
        let mut verdict = Verdict::default();
        if let Some(study) = self.laws.first() {
            study.judge(&self.machine, &mut verdict);
            study.advise(&self.machine, &mut verdict);
            study.certify(&self.machine, &mut verdict);
        }
        if self.laws.len() > 1 {
            let calm = self.laws.iter().filter(|study| study.calm.verdict() == Some(true));
            let names: Vec<&str> = calm.map(|study| study.law.as_str()).collect();
            let names = if names.is_empty() { "none".to_owned() } else { names.join(", ") };
            verdict.advice(format!("Laws without further impacts: {names}."));
            let others = self.laws.iter().skip(1).filter(|study| study.calm.differs());
            for study in others {
                verdict.certainty(format!("{}: the closed formulas say otherwise; they do not hold.", study.law));
            }
        }
        verdict
    }

    fn passages<'a>(&self, study: &'a Study, known: &'a [(&'a Clearance, Figures)]) -> Table {
        let turns = self.machine.speed.signum();
        Table::of("Passages of the clearance", known)
            .column("from", "from flank", ONE, |(passage, _)| passage.from.to_string())
            .column("", "opens at", DEG, |(_, f)| f.release)
            .digits(6)
            .column("", "closes at", DEG, move |(_, f)| (f.release + turns * f.angle).rem_euclid(TAU))
            .digits(6)
            .column("", "after", MS, |(_, f)| f.time)
            .column("", "impulse", NS, |(_, f)| f.impulse)
            .column("", "loss", J, |(_, f)| f.loss)
            .column("", "largest force", N, |(_, f)| f.force)
            .column("", "over that without clearance", ONE, move |(_, f)| Some(f.force? / study.contact_force?))
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
            .column("", "further impacts", ONE, |study| study.calm.verdict().map(|calm| !calm))
            .column("", "largest impulse", NS, known(|f| f.impulse))
            .column("", "loss a turn", J, |study| study.known().iter().map(|(_, f)| f.loss).sum::<f64>())
            .column("", "impacts a turn, settled", ONE, |study| study.settled.map(|settled| settled.impacts))
            .column("", "largest impulse, settled", NS, |study| study.settled.map(|settled| settled.largest_impulse))
            .column("", "admissible natural frequencies", ONE, |study| {
                study.by_model.as_ref().map(|model| ranges(&model.frequency, &HZ))
            })
            .into()
    }

    /// Tables that stand in files alone: after each impact, time of passage, map.
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
            if study.by_model.is_some() {
                report.table(
                    Table::of("Without further impacts", &study.quantities(&self.machine))
                        .column("", "quantity", ONE, |q| q.name)
                        .column("", "now", ONE, |q| shown(q.value, &q.unit))
                        .column("", "looked for", ONE, |q| q.by_model.map(|(_, searched)| range(searched, &q.unit)))
                        .column("", "admissible", ONE, |q| q.by_model.map(|(found, _)| ranges(found, &q.unit))),
                );
            }
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

    /// The findings with the verdict as JSON.
    ///
    /// # Errors
    /// None in practice.
    pub fn json(&self) -> Result<String, Fault> {
        crate::report::json(&self.verdict(), self)
    }
}
