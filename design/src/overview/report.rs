//! The characteristic values as a report.

use super::{Jump, Overview, Warning};
use crate::forces::report::LiftOff;
use crate::law_motions::Motion;
use crate::report::unit::{ONE, RPM, Unit};
use crate::report::{Advice, Claim, Level, Report, Table, Verdict};
use crate::text::sentence;

impl Overview {
    /// The verdict on the plausibility of the values.
    pub fn verdict(&self) -> Verdict {
        let mut verdict = Verdict::default();
        match (self.warnings.is_empty(), self.notes.is_empty()) {
            (true, true) => drop(verdict.result(Level::Good, "No errors. All values are plausible.")),
            (true, false) => drop(verdict.result(Level::Good, "No errors.")),
            _ => {}
        }
        let is_still = |i: &usize| self.of_motion.iter().all(|(of, _)| of != i);
        (0..self.warnings.len()).filter(is_still).for_each(|i| self.warn(i, &mut verdict));
        verdict.join(self.judgement());
        verdict
    }

    /// The part of the verdict that is on the motion.
    pub fn judgement(&self) -> Verdict {
        let mut verdict = Verdict::default();
        self.of_motion.iter().for_each(|(i, _)| self.warn(*i, &mut verdict));
        self.note(&mut verdict);
        verdict
    }

    /// Adds the notes, where they are not there yet.
    pub fn note(&self, verdict: &mut Verdict) {
        for note in self.notes.iter().map(|note| sentence(note)) {
            if !verdict.result.contains(&note) {
                verdict.result(Level::Good, note);
            }
        }
    }

    /// Adds warning i.
    fn warn(&self, i: usize, verdict: &mut Verdict) {
        let Warning { message, hint } = &self.warnings[i];
        let set = self.cures.iter().filter(|(of, _)| *of == i).map(|(_, setting)| setting.clone());
        let level = self.of_motion.iter().find(|(of, _)| *of == i).map_or(Level::Mind, |(_, level)| *level);
        let advice = Advice::new(sentence(hint)).set(set, Claim::Plausible);
        verdict.result(level, sentence(message));
        if !verdict.advice.contains(&advice) {
            verdict.advice(advice);
        }
    }

    /// The report under a title "NAME: STUDY".
    pub fn report(&self, name: impl Into<String>, study: impl Into<String>) -> Report {
        let q = Unit::of(self.resonances.first().map_or("", |resonance| resonance.unit));
        let resonances = Table::of("Resonances", &self.resonances)
            .column("harmonic", "harmonic", ONE, |of| of.harmonic)
            .column("speed", "speed", RPM, |of| of.speed)
            .column("amplitude", "amplitude at the present speed", q.clone(), |of| of.amplitude)
            .column("resonant_amplitude", "amplitude in resonance", q, |of| {
                of.resonant_amplitude.unwrap_or(f64::INFINITY)
            });
        let figures = Table::of("Characteristic values", &self.figures)
            .column("name", "quantity", ONE, |figure| figure.name.replace('_', " "))
            .column("value", "value", ONE, |figure| &figure.shown);
        let mut report = Report::new(name, study);
        report.verdict = self.verdict();
        report.table(figures).table(Motion::table(&self.motions));
        report.lines("Jumps", self.jumps.iter().map(|jump| format!("{}: {}", jump.law, Jump::text(jump))));
        report.table(resonances);
        let varying = "The coefficients vary over the turn: `camdrive stability` finds resonances and unstable speeds.";
        report.lines("Resonances", self.varies.then(|| varying.to_owned()));
        // A note has the speeds of all others.
        report.lines(
            "Contact",
            self.lift_offs.iter().filter(|of| of.may_leave && of.judged().0 == Level::Good).map(LiftOff::text),
        );
        if !self.motions.is_empty() {
            report.explain("Characteristic values of motions", [Motion::SYMBOLS.to_owned()]);
        }
        report
    }
}
