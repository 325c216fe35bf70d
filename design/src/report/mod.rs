//! One report for all studies: a [`Verdict`], then typed tables and sentences, diagrams, and what only `--explain` tells. A study
//! fills it; [`terminal`], [`csv`], [`html`], and [`json()`] write it.

mod advice;
pub mod csv;
mod formula;
pub mod html;
pub mod rounding;
pub mod table;
pub mod terminal;
pub mod unit;

use crate::documentation::Equation;
use crate::drawing::Drawing;
use crate::plot::Diagram;
use crate::text;
pub use advice::{Advice, Claim, Reach, Setting, WrittenValue};
use camdrive::drives::Fault;
use serde::Serialize;
pub use table::{Column, Rows, Table, Value};
pub use unit::Unit;

/// The answer of a study, before any number of it.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Verdict {
    /// The judgement on the machine of the scene.
    pub level: Level,
    /// The results.
    pub result: Vec<String>,
    /// The judgement of each of them.
    #[serde(skip)]
    levels: Vec<Level>,
    /// The advice.
    pub advice: Vec<Advice>,
    /// The certainty of the results.
    pub certainty: Vec<String>,
}

/// The judgement of a study on a machine.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Level {
    /// Nothing speaks against it.
    #[default]
    Good,
    /// It works, with something to be minded.
    Mind,
    /// It fails.
    Bad,
}

/// A part of the body of a report.
#[derive(Clone, Debug, PartialEq)]
pub enum Block {
    /// Sentences under a title, or below what is there already where the title is empty.
    Lines(String, Vec<String>),
    /// A table.
    Table(Table),
    /// Equations under a title.
    Equations(String, Vec<Equation>),
    /// Under a title a sentence, and lines for a computer.
    Code(String, String, String),
    /// Under a title the name of a file, and where it lies.
    File(String, String, String),
}

/// The content of a figure.
#[derive(Clone, Debug)]
pub enum Picture {
    /// Curves over axes.
    Diagram(Diagram),
    /// A drawing with its label for screen readers, shown so many times as large.
    Drawing(Drawing, String, f64),
}

/// A diagram or a drawing under the ending of its file, "load" of NAME.load.svg.
#[derive(Clone, Debug)]
pub struct Figure {
    /// The ending.
    pub key: String,
    /// Its content.
    pub picture: Picture,
}

/// The report of a study.
#[derive(Clone, Debug, Default)]
pub struct Report {
    /// Name of the scene, the task or the system.
    pub name: String,
    /// The study, as the title goes on: "stability".
    pub study: String,
    /// The answer.
    pub verdict: Verdict,
    /// Tables and sentences.
    pub body: Vec<Block>,
    /// Formulas, sources, what is printed wrong in them, how it was computed.
    pub explained: Vec<Block>,
    /// Diagrams and drawings.
    pub figures: Vec<Figure>,
}

impl Verdict {
    /// Adds to what holds; the worst level counts.
    pub fn result(&mut self, level: Level, sentence: impl Into<String>) -> &mut Self {
        self.level = self.level.max(level);
        self.result.push(sentence.into());
        self.levels.push(level);
        self
    }

    /// Adds another verdict to this one.
    pub fn join(&mut self, other: Verdict) -> &mut Self {
        for (level, sentence) in other.levels.into_iter().zip(other.result) {
            self.result(level, sentence);
        }
        self.advice.extend(other.advice);
        self.certainty.extend(other.certainty);
        self
    }

    /// What is to be minded in all of these reports, the worst first and each sentence once, with the advice on it; where nothing is,
    /// the first result of each.
    pub fn over_all<'a>(reports: impl IntoIterator<Item = &'a Report>) -> Verdict {
        let (mut minded, mut calm, mut advice) = (Vec::new(), Vec::new(), Vec::new());
        for Report { verdict, .. } in reports {
            let own = verdict.levels.iter().copied().zip(&verdict.result);
            minded.extend(own.filter(|(level, _)| *level > Level::Good));
            calm.extend(verdict.result.first());
            if verdict.level > Level::Good {
                advice.extend(&verdict.advice);
            }
        }
        minded.sort_by_key(|(level, _)| std::cmp::Reverse(*level));
        // Several studies find that a follower lifts off, or that no motion repeats.
        let mut found = Vec::new();
        minded.retain(|(_, sentence)| {
            let fact = [" lifts off its cam", " does not repeat"].iter().find_map(|fact| sentence.find(fact));
            let fact = fact.map(|end| &sentence[..end]);
            let is_new = fact.is_none_or(|fact| !found.contains(&fact));
            found.extend(fact);
            is_new
        });
        let mut all = Verdict::default();
        let fine: Vec<(Level, &String)> = calm.into_iter().map(|sentence| (Level::Good, sentence)).collect();
        for (level, sentence) in if minded.is_empty() { fine } else { minded } {
            if !all.result.contains(sentence) {
                all.result(level, sentence.clone());
            }
        }
        for own in advice {
            if !all.advice.contains(own) {
                all.advice(own.clone());
            }
        }
        all
    }

    /// Leaves out the results and the advice that another verdict has.
    pub fn leave_out(&mut self, other: &Verdict) {
        let all = std::mem::take(&mut self.levels).into_iter().zip(std::mem::take(&mut self.result));
        self.level = Level::default();
        for (level, sentence) in all {
            if !other.result.contains(&sentence) {
                self.result(level, sentence);
            }
        }
        self.advice.retain(|advice| !other.advice.contains(advice));
    }

    /// Adds to what is to be done.
    pub fn advice(&mut self, advice: impl Into<Advice>) -> &mut Self {
        self.advice.push(advice.into());
        self
    }

    /// Adds to how sure it is.
    pub fn certainty(&mut self, sentence: impl Into<String>) -> &mut Self {
        self.certainty.push(sentence.into());
        self
    }

    /// The sentences of its parts with their headings.
    pub fn parts(&self) -> [(&'static str, Vec<&str>); 3] {
        let [result, certainty] = [&self.result, &self.certainty].map(|list| list.iter().map(String::as_str).collect());
        let advice = self.advice.iter().map(|advice| advice.text.as_str()).collect();
        [("Result", result), ("Advice", advice), ("Certainty", certainty)]
    }
}

impl Report {
    /// A report without content.
    pub fn new(name: impl Into<String>, study: impl Into<String>) -> Self {
        Report { name: name.into(), study: study.into(), ..Self::default() }
    }

    /// Adds a table to the body.
    pub fn table(&mut self, table: impl Into<Table>) -> &mut Self {
        self.body.push(Block::Table(table.into()));
        self
    }

    /// Adds sentences to the body.
    pub fn lines(&mut self, title: &str, lines: impl IntoIterator<Item = String>) -> &mut Self {
        self.body.push(Block::Lines(title.to_owned(), lines.into_iter().collect()));
        self
    }

    /// Adds sentences that explain.
    pub fn explain(&mut self, title: &str, lines: impl IntoIterator<Item = String>) -> &mut Self {
        self.explained.push(Block::Lines(title.to_owned(), lines.into_iter().collect()));
        self
    }

    /// Adds a table that explains.
    pub fn explain_table(&mut self, table: impl Into<Table>) -> &mut Self {
        self.explained.push(Block::Table(table.into()));
        self
    }

    /// Adds a diagram.
    pub fn diagram(&mut self, key: &str, diagram: Diagram) -> &mut Self {
        self.figures.push(Figure { key: key.to_owned(), picture: Picture::Diagram(diagram) });
        self
    }

    /// Adds a drawing.
    pub fn drawing(&mut self, key: &str, drawing: Drawing, label: &str, scale: f64) -> &mut Self {
        self.figures.push(Figure { key: key.to_owned(), picture: Picture::Drawing(drawing, label.to_owned(), scale) });
        self
    }

    /// All tables, of the body and of what explains.
    pub fn tables(&self) -> impl Iterator<Item = &Table> {
        self.body.iter().chain(&self.explained).filter_map(|block| match block {
            Block::Table(table) => Some(table),
            _ => None,
        })
    }

    /// The files of the report by their endings: a table that has a key as KEY.csv, a figure as KEY.svg; an empty key leaves the
    /// ending alone.
    pub fn files(&self) -> Vec<(String, Result<String, Fault>)> {
        let named = |key: &str, ending: &str| if key.is_empty() { ending.into() } else { format!("{key}.{ending}") };
        let tables = self.tables().filter_map(|table| Some((named(table.key.as_deref()?, "csv"), csv::write(table))));
        let figures = self.figures.iter().map(|figure| (named(&figure.key, "svg"), Ok(figure.picture.svg())));
        tables.chain(figures).collect()
    }
}

impl Picture {
    /// The picture as a file.
    pub fn svg(&self) -> String {
        match self {
            Picture::Diagram(diagram) => diagram.svg(),
            Picture::Drawing(drawing, label, scale) => drawing.svg(label, *scale),
        }
    }
}

/// The findings of a study with the verdict on them, in coherent SI units; what is infinite becomes null.
///
/// # Errors
/// None in practice: no finding holds anything that JSON has no form for.
pub fn json(verdict: &Verdict, findings: &impl Serialize) -> Result<String, Fault> {
    #[derive(Serialize)]
    struct Whole<'a, F> {
        verdict: &'a Verdict,
        #[serde(flatten)]
        findings: &'a F,
    }
    text::json(&Whole { verdict, findings })
}
