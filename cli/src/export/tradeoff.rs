//! The study of speed against accuracy inside an FMU: a section of the documentation, and files in `extra/`.

use super::archive::File;
use camdrive::drives::Fault;
use camdrive_design::report::{self, Report};
use camdrive_design::tradeoff::Findings;

/// The folder of the tables in `extra/`; the standard asks for a reverse domain name.
const FOLDER: &str = "extra/org.camdrive.tradeoff";

/// The tables for programs.
pub fn files(findings: &Findings) -> Result<Vec<File>, Fault> {
    let report = findings.report();
    let tables = report.files().into_iter().filter(|(ending, _)| ending.ends_with(".csv"));
    let files = tables.chain([("tradeoff.json".to_owned(), report::json(&report.verdict, findings))]);
    files.map(|(name, content)| Ok(File::new(format!("{FOLDER}/{name}"), content?))).collect()
}

/// The report for the documentation.
pub fn report(findings: &Findings) -> Report {
    let mut report = findings.report();
    report.lines("Files", [format!("All numbers are in {FOLDER} inside this FMU.")]);
    report
}
