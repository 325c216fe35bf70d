//! The study of speed against accuracy inside an FMU: a section of the documentation, and files in `extra/`.

use super::archive::File;
use super::xml::Xml;
use camdrive::drives::Fault;
use camdrive_design::report::{Block, Picture, terminal};
use camdrive_design::tradeoff::Findings;

/// The folder of the tables in `extra/`; the standard asks for a reverse domain name.
const FOLDER: &str = "extra/org.camdrive.tradeoff";

/// The tables for programs.
pub fn files(findings: &Findings) -> Result<Vec<File>, Fault> {
    let tables = findings.report().files().into_iter().filter(|(ending, _)| ending.ends_with(".csv"));
    let files = tables.chain([("tradeoff.json".to_owned(), findings.json())]);
    files.map(|(name, content)| Ok(File::new(format!("{FOLDER}/{name}"), content?))).collect()
}

/// Writes the section of the documentation.
pub fn write(findings: &Findings, xml: &mut Xml) {
    let report = findings.report();
    xml.text("h2", &[], "Speed against accuracy");
    for (_, sentences) in report.verdict.parts() {
        sentences.iter().for_each(|sentence| xml.text("p", &[], sentence));
    }
    for figure in &report.figures {
        if let Picture::Diagram(diagram) = &figure.picture {
            xml.element("figure", &[], |xml| xml.markup(&diagram.svg_for_page()));
        }
    }
    for block in report.body.iter().chain(&report.explained) {
        match block {
            Block::Table(table) if !table.rows.is_empty() => {
                xml.text("h3", &[], &table.title);
                xml.table(&terminal::cells(table));
            }
            Block::Lines(title, lines) if !lines.is_empty() => {
                xml.text("h3", &[], title);
                xml.element("ul", &[], |xml| lines.iter().for_each(|line| xml.text("li", &[], line)));
            }
            _ => (),
        }
    }
    xml.text("p", &[], &format!("All numbers are in {FOLDER} inside this FMU."));
}
