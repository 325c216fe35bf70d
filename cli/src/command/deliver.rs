//! Reports of all studies: prints them as text or JSON and writes their tables and pictures into a folder.

use super::measured::Measured;
use super::output::{print, show, width};
use super::{Failure, failure, files};
use crate::document::Document;
use crate::study::has_place;
use camdrive_design::report::{self, Picture, Report, html};
use serde::Serialize;
use std::path::{Path, PathBuf};

/// The form of a printed report.
#[derive(Clone, Copy, Debug, Default, clap::Args)]
pub struct ReportFormat {
    /// Print the result as one JSON document; docs/json.md explains its fields
    #[arg(long, conflicts_with = "explain")]
    pub json: bool,
    /// Add formulas, sources (with known misprints) and method
    #[arg(long)]
    pub explain: bool,
}

/// The files of a report and the files next to it.
#[derive(Default)]
pub struct ReportFiles<'a> {
    /// The folder for tables and pictures; None writes no files.
    pub folder: Option<&'a Path>,
    /// The scene whose keys advice sets.
    pub scene: Option<&'a Document>,
    /// Files outside the report.
    pub more: Vec<(PathBuf, Vec<u8>)>,
    /// Input files, which no result replaces.
    pub inputs: Vec<PathBuf>,
    /// True if files that no command wrote are replaced.
    pub force: bool,
    /// Measured curves over the diagrams.
    pub measured: Option<&'a Measured>,
}

impl ReportFormat {
    /// Writes the files of a report on these findings, all or none, and prints the report.
    pub fn deliver(self, mut report: Report, findings: &impl Serialize, place: ReportFiles) -> Result<(), Failure> {
        let ReportFiles { folder, scene, more: mut results, mut inputs, force, measured } = place;
        if let Some(scene) = scene {
            report.verdict.advice.iter_mut().for_each(|advice| advice.spell(&|key| has_place(scene, key)));
        }
        let json = report::json(&report.verdict, findings).map_err(failure)?;
        if let Some(folder) = folder {
            let diagrams = report.figures.iter_mut().filter_map(|figure| match &mut figure.picture {
                Picture::Diagram(diagram) => Some((figure.key.as_str(), diagram)),
                Picture::Drawing(..) => None,
            });
            inputs.extend(measured.map_or(Ok(Vec::new()), |measured| measured.lay_over(diagrams))?);
            let page = html::page(&report.name, std::slice::from_ref(&report));
            let own =
                [("json", json.clone()), ("html", page)].map(|(ending, content)| (ending.to_owned(), Ok(content)));
            let parts = report.files().into_iter().chain(own);
            let parts = files::report(folder, &report.name, parts)?;
            files::keep(&parts, &inputs, force)?;
            results.extend(parts);
        }
        let written = files::write(&results, &inputs)?;
        if self.json {
            return print(&json);
        }
        let gap = if written.is_empty() { "" } else { "\n" };
        show(&(report.text(width(), self.explain) + gap + &written))
    }
}
