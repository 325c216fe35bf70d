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
    /// Properties of real drives that the model does not have.
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

impl Equation {
    /// Title and formula in one line.
    pub fn line(&self) -> String {
        format!("{}: {}", self.title, self.text)
    }
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
    /// If the file is no such text, or names a condition that the drive does not know.
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
                    chosen.push((spliced(&paragraph.title, text)?, spliced(&paragraph.text, text)?));
                }
            }
            Ok(chosen)
        };
        let sources =
            file.sources.iter().map(|source| spliced(source, text)).collect::<Result<Vec<String>, Fault>>()?;
        let texts = |paragraphs: Vec<(String, String)>| paragraphs.into_iter().map(|(_, text)| text);
        Ok(Documentation {
            summary: texts(chosen(file.summary)?).collect(),
            equations: chosen(file.equation)?.into_iter().map(|(title, text)| Equation { title, text }).collect(),
            left_out: texts(chosen(file.left_out)?).collect(),
            accuracy: chosen(file.accuracy)?,
            limits: texts(chosen(file.limit)?).collect(),
            sources: sources.into_iter().filter(|source| !source.is_empty()).collect(),
        })
    }
}

/// The text with what stands in {condition|…} where that holds. The first term of a sum is without its plus, a sum of nothing 0.
fn spliced(text: &str, drive: &Text) -> Result<String, Fault> {
    let (mut out, mut rest) = (String::new(), text);
    while let Some((before, (part, after))) =
        rest.split_once('{').and_then(|(b, tail)| Some((b, tail.split_once('}')?)))
    {
        let (condition, inside) = part.split_once('|').unwrap_or((part, ""));
        out += before;
        if drive.holds(condition)? {
            out += inside;
        }
        rest = after;
    }
    out += rest;
    if out.ends_with('=') {
        out += " 0";
    }
    Ok(out.replace("= + ", "= "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_text_has_the_parts_that_hold() {
        let drive = Text::new("", &[("spring", true), ("weight", false)]);
        let said = |text: &str| spliced(text, &drive).unwrap();
        assert_eq!(said("F ={weight| + m g}{spring| + c y} + b"), "F = c y + b");
        assert_eq!(said("F ={weight| + m g}"), "F = 0");
        assert_eq!(said("{not weight|No weight.}{not spring|No spring.}"), "No weight.");
        assert!(spliced("{wait|x}", &drive).unwrap_err().to_string().contains("`wait` is not a condition"));
    }
}
