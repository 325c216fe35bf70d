//! The report as tables and sentences for a terminal.

use super::borders::Sequel;
use super::by_model::ByModel;
use super::passage::{Clearance, Figures};
use super::tuning::{Intervals, SOURCE_BOUND, Tuning, nearest};
use super::{Parameters, Report, Study};
use crate::text::{NONE, counted, time};
pub use crate::text::{Table, number};
use std::f64::consts::TAU;

/// Intervals that a sentence lists; the others are in the JSON file.
const LISTED: usize = 6;
/// Intervals that a cell of a table lists.
const LISTED_IN_CELL: usize = 4;

/// The parameters, in sentences.
pub fn about(report: &Report) -> Vec<String> {
    let Parameters { m1, m2, c, b, s, e, speed, omega, mu, eta } = report.machine;
    let damping = if b > 0.0 {
        format!(", b = {} N·s/m (D = {})", number(b), number(0.5 * b / (m2 * omega)))
    } else {
        String::new()
    };
    vec![
        format!(
            "m1 = {} kg, m2 = {} kg, c = {} N/m{damping}, e = {}, s = {} mm, Ω = {} rad/s ({} rpm), ω = √(c/m2) = {} rad/s \
             ({} Hz).",
            number(m1),
            number(m2),
            number(c),
            number(e),
            number(1e3 * s),
            number(speed),
            number(speed * 60.0 / TAU),
            number(omega),
            number(omega / TAU)
        ),
        format!("μ = m1/m2 = {}, η = Ω/ω = {}.", number(mu), number(eta)),
    ]
}

fn or_none<T>(value: Option<T>, text: impl Fn(T) -> String) -> String {
    value.map_or(NONE.to_owned(), text)
}

fn sequel(figures: &Figures) -> String {
    match (figures.sequel, figures.release_after) {
        (Sequel::Elastic, Some(tau)) => format!("{} after τ* = {}", figures.sequel.name(), number(tau)),
        _ => figures.sequel.name().to_owned(),
    }
}

/// A figure of a passage: the factor from SI to the unit of its column, and the value.
type Figure = (f64, fn(&Figures) -> Option<f64>);

/// τ₁, time, angle, impulse, loss, vibration, largest |q| and |F|.
pub(super) const FIGURES: [Figure; 8] = [
    (1.0, |f| Some(f.tau)),
    (1e3, |f| Some(f.time)),
    (360.0 / TAU, |f| Some(f.angle)),
    (1.0, |f| Some(f.impulse)),
    (1.0, |f| Some(f.loss)),
    (1e3, |f| Some(f.vibration)),
    (1e3, |f| f.elongation),
    (1.0, |f| f.force),
];

fn row(figures: &Figures) -> Vec<String> {
    let numbers = FIGURES.map(|(unit, of)| or_none(of(figures), |value| number(unit * value)));
    [vec![format!("{:.3}", figures.release.to_degrees())], numbers.to_vec(), vec![sequel(figures)]].concat()
}

/// With its sign, which a rounded zero has not.
fn signed(value: f64, decimals: usize) -> String {
    let text = format!("{value:+.decimals$}");
    if text.contains(|c: char| ('1'..='9').contains(&c)) { text } else { text[1..].to_owned() }
}

/// formula/model − 1 in per cent, of the release the difference in degrees.
fn differences(formula: &Figures, model: &Figures) -> Vec<String> {
    let ratios = FIGURES.map(|(_, of)| {
        let both = of(formula).zip(of(model)).filter(|(_, model)| *model != 0.0);
        or_none(both, |(formula, model)| signed(100.0 * (formula / model - 1.0), 2) + " %")
    });
    let shift = (formula.release - model.release + 0.5 * TAU).rem_euclid(TAU) - 0.5 * TAU;
    let same = if formula.sequel == model.sequel { "same" } else { "differs" };
    [vec![signed(shift.to_degrees(), 3)], ratios.to_vec(), vec![same.to_owned()]].concat()
}

/// The passages by formula and model, with differences.
pub fn of_passages(study: &Study) -> Table {
    let head = "passage  from  U‴ [m]  K  by  release [°]  τ₁  time [ms]  angle [°]  impulse [N·s]  loss [J]  \
                vibration [mm]  max |q| [mm]  max |F| [N]  then";
    let mut rows = Vec::new();
    for (i, passage) in study.passages.iter().enumerate() {
        let mut lead = vec![
            (i + 1).to_string(),
            passage.from.to_string(),
            or_none(passage.crossing.map(|c| c.jerk), number),
            or_none(passage.k, number),
        ];
        let mut add = |by: &str, cells: Vec<String>| {
            let lead = std::mem::replace(&mut lead, vec![String::new(); 4]);
            rows.push([lead, vec![by.to_owned()], cells].concat());
        };
        // Where only the exact contact force has it, and the model has not followed it, CSV and JSON list it.
        let (formula, model) = (passage.formula.as_ref(), passage.model.as_ref());
        formula.into_iter().for_each(|figures| add("formula", row(figures)));
        model.into_iter().for_each(|figures| add("model", row(figures)));
        formula.zip(model).into_iter().for_each(|(formula, model)| add("difference", differences(formula, model)));
    }
    Table::new(head, rows)
}

/// "2 none, 8 elastic".
fn counts(sequels: &[Sequel]) -> String {
    let all = [Sequel::None, Sequel::Immediate, Sequel::Elastic, Sequel::Rebound, Sequel::Return];
    let count = |sequel: &Sequel| sequels.iter().filter(|other| *other == sequel).count();
    let told = all.iter().map(|sequel| (count(sequel), sequel.name())).filter(|(n, _)| *n > 0);
    let texts: Vec<String> = told.map(|(n, name)| format!("{n} {name}")).collect();
    if texts.is_empty() { NONE.to_owned() } else { texts.join(", ") }
}

/// The figures of all passages by the formulas, or by the model.
fn figures_by(study: &Study, model: bool) -> Vec<Figures> {
    study.passages.iter().filter_map(|passage| if model { passage.model } else { passage.formula }).collect()
}

fn sequels_by(study: &Study, model: bool) -> Vec<Sequel> {
    figures_by(study, model).iter().map(|figures| figures.sequel).collect()
}

/// How resistant the laws are to clearance, by formula and model.
pub fn of_laws(report: &Report) -> Table {
    let head = "law  stroke [mm]  max |U″| [m]  least spacing [°]  |U‴| [m]  K  by  passages  then  \
                largest impulse [N·s]  loss per turn [J]  largest vibration [mm]  ω without further impacts [rad/s]  \
                impacts per turn  largest impulse, settled [N·s]";
    let mut rows = Vec::new();
    for study in &report.laws {
        let values =
            |value: &dyn Fn(&Clearance) -> Option<f64>| study.passages.iter().filter_map(value).collect::<Vec<f64>>();
        let most = |values: Vec<f64>| values.into_iter().reduce(f64::max);
        let range = |values: Vec<f64>| {
            let low = values.iter().copied().reduce(f64::min);
            or_none(low.zip(most(values)), |(low, high)| {
                if low == high { number(low) } else { format!("{} to {}", number(low), number(high)) }
            })
        };
        let calm = |intervals: Option<&Intervals>| or_none(intervals, |intervals| some(intervals, 1.0, LISTED_IN_CELL));
        let by_formulas = calm(study.tuning.as_ref().map(|tuning| &tuning.frequency));
        let by_model = calm(study.by_model.as_ref().map(|model| &model.frequency));
        let of_passages = |model: bool| {
            let figures = figures_by(study, model);
            let most = |value: fn(&Figures) -> f64| figures.iter().map(value).reduce(f64::max);
            vec![
                if model { "model" } else { "formula" }.to_owned(),
                if model { or_none(study.releases, |n| n.to_string()) } else { study.crossings.to_string() },
                counts(&sequels_by(study, model)),
                or_none(most(|f| f.impulse), number),
                or_none((!figures.is_empty()).then(|| figures.iter().map(|f| f.loss).sum()), number),
                or_none(most(|f| f.vibration), |q| number(1e3 * q)),
            ]
        };
        let of_law = vec![
            study.law.clone(),
            number(1e3 * study.stroke),
            number(study.acceleration),
            or_none(study.least_spacing, |angle| number(angle.to_degrees())),
            range(values(&|p| p.crossing.map(|c| c.jerk.abs()))),
            range(values(&|p| p.k)),
        ];
        let none = NONE.to_owned();
        let [impacts, impulse] = [
            or_none(study.settled.map(|settled| settled.impacts), number),
            or_none(study.settled.map(|settled| settled.largest_impulse), number),
        ];
        rows.push([of_law, of_passages(false), vec![by_formulas, none.clone(), none]].concat());
        rows.push([vec![String::new(); 6], of_passages(true), vec![by_model, impacts, impulse]].concat());
    }
    Table::new(head, rows)
}

/// Meaning of the column of ω, and laws that formulas and model judge differently, in sentences.
pub fn below_laws(report: &Report) -> Vec<String> {
    let mut lines = Vec::new();
    if let Some(model) = report.laws.iter().find_map(|study| study.by_model.as_ref()) {
        let [low, high] = model.searched[0].map(number);
        lines.push(format!(
            "ω without further impacts: all intervals at this speed; by the model only from {low} to {high} rad/s."
        ));
    }
    let missing = report.laws.iter().filter(|study| study.by_model.is_none() && !study.passages.is_empty());
    let names: Vec<&str> = missing.map(|study| study.law.as_str()).collect();
    if !names.is_empty() {
        let why = match report.machine.e {
            e if e > 0.0 => format!("with e = {} m1 rebounds after each impact, at any ω", number(e)),
            _ => "it has not been followed at other ω, which would take too long or cannot be done".to_owned(),
        };
        lines.push(format!("{}: no ω by the model; {why}.", names.join(", ")));
    }
    let differing = report.laws.iter().filter(|study| study.calm.differs());
    let names: Vec<&str> = differing.map(|study| study.law.as_str()).collect();
    if !names.is_empty() {
        let whether = "formula and model differ in whether further impacts follow; take the model";
        lines.push(format!("{}: {whether}.", names.join(", ")));
    }
    lines
}

/// "0 … 3, 5 … 8", the first of them where there are many.
fn list(intervals: &[[f64; 2]], scale: f64) -> String {
    some(intervals, scale, LISTED)
}

/// The first intervals, and how many more there are up to the last one.
fn some(intervals: &[[f64; 2]], scale: f64, most: usize) -> String {
    let shown = |end: f64| number(scale * end);
    let mut merged = Intervals::new();
    for ends in intervals {
        match merged.last_mut() {
            // Nobody sees what is between them.
            Some([_, end]) if shown(*end) == shown(ends[0]) => *end = ends[1],
            _ => merged.push(*ends),
        }
    }
    let one = |[low, high]: &[f64; 2]| match [shown(*low), shown(*high)] {
        [low, _] if high.is_infinite() => format!("from {low} on"),
        [low, high] if low == high => low,
        [low, high] => format!("{low} to {high}"),
    };
    let mut texts: Vec<String> = merged.iter().take(most).map(one).collect();
    if let Some(last) = merged.last().filter(|_| merged.len() > most) {
        texts.push(format!("{} more, the last {}", merged.len() - most, one(last)));
    }
    if texts.is_empty() { "none".to_owned() } else { texts.join(", ") }
}

/// The verdicts of formulas and model at the values of the scene, and the one that holds.
fn verdict(study: &Study) -> String {
    let calm = &study.calm;
    let word = |calm: bool| if calm { "no further impact follows" } else { "further impacts follow" };
    let of = |model: bool, count: usize| match counts(&sequels_by(study, model)) {
        _ if count == 0 => "no passage".to_owned(),
        counts => format!("{} ({counts})", counted(count, "passage")),
    };
    let formulas = of(false, study.crossings);
    let Some((model, count)) = calm.by_model.zip(study.releases) else {
        let word = calm.by_formulas.map_or("not known whether further impacts follow", word);
        return format!("By the formulas {formulas}, {word}; the model gives no answer.");
    };
    let model_says = format!("By the model {}, {}", of(true, count), word(model));
    match calm.by_formulas {
        Some(other) if other != model => {
            format!("{model_says}. By the formulas {formulas}, {}: they do not hold here, take the model.", word(other))
        }
        Some(_) => format!("{model_says}; so by the formulas, {formulas}."),
        None => format!("{model_says}; the formulas give no answer."),
    }
}

/// A quantity of the machine, and where it avoids further impacts.
struct Tunable<'a> {
    name: String,
    /// The unit, and the factor from SI to it.
    unit: &'static str,
    scale: f64,
    /// That of the scene (SI).
    value: f64,
    by_formulas: Option<&'a Intervals>,
    /// The intervals, and the values between which they were looked for.
    by_model: Option<(&'a Intervals, [f64; 2])>,
}

impl Tunable<'_> {
    /// The intervals of the formulas where the model was looked at, if it was.
    fn looked_at(&self) -> Intervals {
        let [least, most] = self.by_model.map_or([0.0, f64::INFINITY], |(_, searched)| searched);
        let all = self.by_formulas.into_iter().flatten().copied();
        all.filter(|[low, high]| *low < most && least < *high).collect()
    }

    fn with_unit(&self, value: f64) -> String {
        let value = number(self.scale * value);
        if self.unit == "1" { value } else { format!("{value} {}", self.unit) }
    }

    /// Whether the value of the scene is calm, and which one is instead.
    fn verdict(&self, intervals: &[[f64; 2]], calm: bool) -> String {
        let own = self.with_unit(self.value);
        match nearest(intervals, self.value) {
            _ if calm => format!("{own} is admissible"),
            Err(Some(end)) => format!("{own} is not, nearest is {}", self.with_unit(end)),
            Ok(_) => format!("{own} is not"),
            Err(None) => format!("{own} is not, and nothing is"),
        }
    }

    /// The sentence; `calm` is what the model says of the scene.
    fn sentence(&self, e: f64, calm: Option<bool>) -> String {
        let (all, there) = (self.by_formulas.map_or(&[][..], Vec::as_slice), self.looked_at());
        let only = if there.is_empty() && !all.is_empty() { " there" } else { "" };
        let formulas = match self.by_formulas {
            Some(_) => format!("by the formulas {}{only}", list(&there, self.scale)),
            None => "the formulas know no damping".to_owned(),
        };
        let told = match (self.by_model, calm) {
            _ if e > 0.0 => format!("if e were 0, {formulas}"),
            (Some((intervals, searched)), Some(calm)) => {
                let [low, high] = searched.map(|end| number(self.scale * end));
                let (intervals, verdict) = (list(intervals, self.scale), self.verdict(intervals, calm));
                format!("by the model, from {low} to {high}: {intervals}; {verdict}; {formulas}")
            }
            (_, Some(calm)) if calm != nearest(all, self.value).is_ok() => {
                let word = if calm { "is admissible" } else { "is not admissible" };
                format!("{formulas}, but by the model {} {word}", self.with_unit(self.value))
            }
            _ => format!("{formulas}; {}", self.verdict(all, nearest(all, self.value).is_ok())),
        };
        format!("{} [{}]: {told}.", self.name, self.unit)
    }
}

/// ω, Ω, s, m1 and D.
fn quantities<'a>(machine: &Parameters, tuning: &'a Tuning, model: Option<&'a ByModel>) -> [Tunable<'a>; 5] {
    let Parameters { m1, m2, b, omega, speed, s, .. } = *machine;
    let quantity = |which: usize, name: String, unit: &'static str, scale: f64, value: f64| Tunable {
        name,
        unit,
        scale,
        value,
        by_formulas: [&tuning.frequency, &tuning.speed, &tuning.clearance, &tuning.mass].get(which).copied(),
        by_model: model
            .map(|m| ([&m.frequency, &m.speed, &m.clearance, &m.mass, &m.damping][which], m.searched[which])),
    };
    [
        quantity(0, format!("ω at Ω = {} rpm", number(speed * 60.0 / TAU)), "rad/s", 1.0, omega),
        quantity(1, format!("Ω at ω = {} rad/s", number(omega)), "rpm", 60.0 / TAU, speed.abs()),
        quantity(2, "s at both".to_owned(), "mm", 1e3, s),
        quantity(3, "m1 at these".to_owned(), "kg", 1.0, m1),
        quantity(4, "D = b/(2 m2 ω)".to_owned(), "1", 1.0, 0.5 * b / (m2 * omega)),
    ]
}

/// Which frequencies, speeds and clearances avoid multiple impacts, in sentences.
pub fn of_tuning(report: &Report, study: &Study) -> Vec<String> {
    let Some(tuning) = &study.tuning else { return Vec::new() };
    let Parameters { m1, m2, omega, mu, e, .. } = report.machine;
    let mut lines = vec![verdict(study)];
    if e > 0.0 {
        lines.push(format!("With e = {} m1 rebounds after each impact; no value of these prevents it.", number(e)));
    }
    let quantities = quantities(&report.machine, tuning, study.by_model.as_ref());
    let [.., mass, damping] = &quantities;
    let sentence = |quantity: &Tunable| quantity.sentence(e, study.calm.by_model);
    lines.extend(quantities[..4].iter().map(sentence));
    let nearest_mass = nearest(mass.by_model.map_or(&tuning.mass, |(intervals, _)| intervals), m1).err().flatten();
    if let Some(mass) = nearest_mass.filter(|_| e == 0.0 && study.calm.verdict() != Some(true)) {
        let free = |m1: f64| number(omega * ((m1 + m2) / m1).sqrt());
        lines.push(format!(
            "m1 = {} kg is μ = {}, ω₂ = ω √((μ+1)/μ) = {} rad/s instead of {} rad/s.",
            number(mass),
            number(mass / m2),
            free(mass),
            free(m1)
        ));
    }
    if damping.by_model.is_some() && study.calm.by_model.is_some() {
        lines.push(sentence(damping));
    }
    if let Some(model) = &study.by_model {
        let unknown = if model.unknown > 0 {
            format!(" At {} of the values it could not be followed; they count as not admissible.", model.unknown)
        } else {
            String::new()
        };
        lines.push(format!(
            "The model was followed at values {} % apart, of D {} %, and its borders bisected; narrower intervals may \
             be missing.{unknown}",
            number(100.0 * (model.ratio - 1.0)),
            number(100.0 * (model.damping_ratio - 1.0))
        ));
    } else if study.releases.is_some() && e == 0.0 {
        lines.push("The model has not been followed at other values: it takes too long, or cannot be.".to_owned());
    }
    lines.push(format!(
        "By the formulas, K at μ = {}: {}{}. {} By it ω would be up to {} rad/s.",
        number(mu),
        list(&tuning.k.intervals, 1.0),
        if tuning.k.cut { format!(", and narrower ones up to {}", number(tuning.k.elastic)) } else { String::new() },
        if tuning.k.intervals.len() > 1 {
            format!("The source's K ≤ {SOURCE_BOUND} leaves out the releases right after the impact.")
        } else {
            format!("The source's K ≤ {SOURCE_BOUND} is sufficient.")
        },
        number(tuning.source_frequency)
    ));
    if tuning.mass_cut {
        let first = mass.looked_at().first().or(tuning.mass.first()).map_or(0.0, |ends| ends[0]);
        lines.push(format!("Below m1 = {} kg the formulas admit further, ever narrower intervals.", number(first)));
    }
    if tuning.quasi_static_speed.is_finite() && tuning.quasi_static_frequency > 0.0 {
        lines.push(format!(
            "The quasi-static release of the formulas is right to 5 % from ω = {} rad/s on at this speed, up to Ω = {} \
             rpm at this natural frequency.",
            number(tuning.quasi_static_frequency),
            number(tuning.quasi_static_speed * 60.0 / TAU)
        ));
    }
    lines
}

/// The settled motion and the number of passages, in sentences.
pub fn of_motion(study: &Study) -> Vec<String> {
    let mut lines = Vec::new();
    let ignored =
        if study.ignored > 0 { format!(" ({} more are too small to count)", study.ignored) } else { String::new() };
    let exact = study.releases.map_or(String::new(), |n| {
        let more = if n > study.crossings {
            ", since the working mass vibrates between them; a larger --ignore leaves out the lower ones"
        } else {
            ""
        };
        format!("; the contact force of the periodic motion has {n}{more}")
    });
    lines.push(format!("U″ has {} changes of sign in a turn{ignored}{exact}.", study.crossings));
    if let Some(settled) = &study.settled {
        let repeats = if settled.repeats { "each turn like the one before" } else { "not repeating from turn to turn" };
        lines.push(format!(
            "Settled motion, {}, {repeats}: {} and {} J lost in a turn; the largest impulse is {} N·s.",
            counted(settled.turns, "turn"),
            counted(number(settled.impacts), "impact"),
            number(settled.loss),
            number(settled.largest_impulse)
        ));
    }
    let times = study.passages.iter().filter_map(|p| Some(p.formula.or(p.model)?.time));
    lines.extend(times.reduce(f64::max).map(|longest| format!("The longest passage takes {}.", time(longest))));
    let mut faults: Vec<(&String, Vec<String>)> = Vec::new();
    for (i, fault) in study.passages.iter().enumerate().filter_map(|(i, p)| Some((i, p.fault.as_ref()?))) {
        match faults.iter_mut().find(|(known, _)| *known == fault) {
            Some((_, list)) => list.push((i + 1).to_string()),
            None => faults.push((fault, vec![(i + 1).to_string()])),
        }
    }
    lines.extend(faults.into_iter().map(|(fault, list)| format!("Passage {}: {fault}.", list.join(", "))));
    lines.extend(study.remarks.iter().cloned());
    lines
}
