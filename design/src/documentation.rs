//! The documentation of a drive: the paragraphs of its text file that hold for it.

use camdrive::drives::{Fault, Text};
use serde::Deserialize;

/// Text of the FMU's documentation and of `describe` beyond the variables of a drive.
#[derive(Clone, Debug, PartialEq)]
pub struct Documentation {
    /// The model in one or two sentences; names signs and validity.
    pub summary: String,
    /// The equations.
    pub equations: Vec<Equation>,
    /// What real drives have and the model does not.
    pub left_out: Vec<String>,
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
    summary: Vec<Paragraph>,
    equation: Vec<Paragraph>,
    left_out: Vec<Paragraph>,
    accuracy: Vec<Paragraph>,
    limit: Vec<Paragraph>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Paragraph {
    /// "inputs", "not inputs": all of them must hold.
    #[serde(default)]
    when: Vec<String>,
    #[serde(default, alias = "quantity")]
    title: String,
    text: String,
}

impl Documentation {
    /// The paragraphs of `text` that hold.
    ///
    /// # Errors
    /// Where the file is no such text, or names a condition that the drive does not know.
    pub fn of(text: &Text) -> Result<Self, Fault> {
        let file: File = toml::from_str(text.file).map_err(|e| Fault::new(format!("the text of the drive: {e}")))?;
        let chosen = |paragraphs: Vec<Paragraph>| -> Result<Vec<(String, String)>, Fault> {
            let mut chosen = Vec::new();
            for paragraph in paragraphs {
                let mut holds = true;
                for word in &paragraph.when {
                    holds &= text.holds(word)?;
                }
                if holds {
                    chosen.push((paragraph.title, paragraph.text));
                }
            }
            Ok(chosen)
        };
        let texts = |paragraphs: Vec<(String, String)>| paragraphs.into_iter().map(|(_, text)| text);
        Ok(Documentation {
            summary: texts(chosen(file.summary)?).collect(),
            equations: chosen(file.equation)?.into_iter().map(|(title, text)| Equation { title, text }).collect(),
            left_out: texts(chosen(file.left_out)?).collect(),
            accuracy: chosen(file.accuracy)?,
            limits: texts(chosen(file.limit)?).collect(),
            sources: file.sources,
        })
    }
}
