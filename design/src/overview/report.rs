//! The characteristic values as a report.

use super::{Jump, Motion, Overview, Resonance, shown};
use crate::report::unit::{ONE, RPM};
use crate::report::{Level, Report, Table, Verdict};

impl Overview {
    /// Whether the values are plausible.
    pub fn verdict(&self) -> Verdict {
        let mut verdict = Verdict::default();
        if self.warnings.is_empty() {
            verdict.result(Level::Good, "No fault, and no value is implausible.");
        }
        for warning in &self.warnings {
            verdict.result(Level::Mind, format!("{}.", warning.message)).advice(format!("{}.", warning.hint));
        }
        verdict
    }

    /// The report under a title "NAME: STUDY".
    pub fn report(&self, name: impl Into<String>, study: impl Into<String>) -> Report {
        let amplitude = |of: &Resonance, value: Option<f64>| value.map(|value| shown(value, of.unit));
        let resonances = Table::of("Resonances", &self.resonances)
            .column("harmonic", "harmonic", ONE, |of| of.harmonic)
            .column("speed", "speed", RPM, |of| of.speed)
            .digits(4)
            .column("amplitude", "deformation in it here", ONE, |of| amplitude(of, of.amplitude))
            .column("resonant_amplitude", "at that speed", ONE, |of| {
                amplitude(of, of.resonant_amplitude).unwrap_or_else(|| "without bound".to_owned())
            });
        let figures = Table::of("Characteristic values", &self.figures)
            .column("name", "quantity", ONE, |figure| figure.name.replace('_', " "))
            .column("value", "value", ONE, |figure| &figure.shown);
        let mut report = Report::new(name, study);
        report.verdict = self.verdict();
        report.table(figures).table(Motion::table(&self.motions));
        report.lines("Jumps", self.jumps.iter().map(|jump| format!("{}: {}", jump.law, Jump::text(jump))));
        report.table(resonances);
        if !self.motions.is_empty() {
            report.explain("Characteristic values of motions", [Motion::SYMBOLS.to_owned()]);
        }
        report
    }
}
