//! The documentation of a drive: the passages of its text file that hold for it.

use camdrive::drives::{Fault, Text};
use serde::Deserialize;

/// Text of the FMU's documentation and of `describe` beyond the variables of a drive.
#[derive(Clone, Debug, PartialEq)]
pub struct Documentation {
    /// The model in one or two sentences; names signs and validity.
    pub summary: String,
    /// The equations.
    pub equations: Vec<Equation>,
    /// The solution method and its accuracy: (quantity, statement).
    pub accuracy: Vec<(String, String)>,
    /// Limits of the model.
    pub limits: Vec<String>,
    /// The literature.
    pub sources: Vec<String>,
}

/// One equation.
#[derive(Clone, Debug, PartialEq)]
pub struct Equation {
    /// Title of the equation.
    pub title: String,
    /// The formula in Unicode.
    pub text: String,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    sources: Vec<String>,
    summary: Vec<Passage>,
    equation: Vec<Passage>,
    accuracy: Vec<Passage>,
    limit: Vec<Passage>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Passage {
    /// "inputs", "not inputs": all of them must hold.
    #[serde(default)]
    when: Vec<String>,
    #[serde(default, alias = "quantity")]
    title: String,
    text: String,
}

impl Documentation {
    /// The passages of `text` that hold.
    ///
    /// # Errors
    /// Where the file is no such text, or names a condition that the drive does not know.
    pub fn of(text: &Text) -> Result<Self, Fault> {
        let file: File = toml::from_str(text.file).map_err(|e| Fault::new(format!("the text of the drive: {e}")))?;
        let chosen = |passages: Vec<Passage>| -> Result<Vec<(String, String)>, Fault> {
            let mut chosen = Vec::new();
            for passage in passages {
                let mut holds = true;
                for word in &passage.when {
                    holds &= text.holds(word)?;
                }
                if holds {
                    chosen.push((passage.title, passage.text));
                }
            }
            Ok(chosen)
        };
        let texts = |passages: Vec<(String, String)>| passages.into_iter().map(|(_, text)| text);
        Ok(Documentation {
            summary: texts(chosen(file.summary)?).collect(),
            equations: chosen(file.equation)?.into_iter().map(|(title, text)| Equation { title, text }).collect(),
            accuracy: chosen(file.accuracy)?,
            limits: texts(chosen(file.limit)?).chain(text.limits.iter().cloned()).collect(),
            sources: file.sources,
        })
    }
}
