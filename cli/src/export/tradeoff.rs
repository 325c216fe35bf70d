//! The study of speed against accuracy inside an FMU: a section of the documentation, and files in `extra/`.

use super::archive::File;
use super::xml::Xml;
use camdrive::drives::Fault;
use camdrive_design::text::{self, Table};
use camdrive_design::tradeoff::table;
use camdrive_design::tradeoff::{Report, figures};

/// The folder of the tables in `extra/`; the standard asks for a reverse domain name.
const FOLDER: &str = "extra/org.camdrive.tradeoff";

/// The tables for programs.
pub fn files(report: &Report) -> Result<Vec<File>, Fault> {
    Ok(vec![
        File::new(format!("{FOLDER}/tradeoff.json"), text::json(report)?),
        File::new(format!("{FOLDER}/tradeoff.csv"), table::csv(report)?),
    ])
}

/// The section of the documentation, ready to be written.
pub struct Section<'a> {
    report: &'a Report,
    pictures: [String; 2],
}

impl<'a> Section<'a> {
    /// Draws the diagrams of a report.
    pub fn of(report: &'a Report) -> Result<Self, Fault> {
        let pictures =
            [figures::work_precision(report).svg_for_page(), figures::communication_step(report).svg_for_page()];
        Ok(Section { report, pictures })
    }

    /// Writes the section.
    pub fn write(&self, xml: &mut Xml) {
        xml.text("h2", &[], "Speed against accuracy");
        for line in table::about(self.report) {
            xml.text("p", &[], &line);
        }
        xml.element("ul", &[], |xml| {
            for advice in &self.report.advice {
                xml.text("li", &[], &advice.sentence);
            }
        });
        for picture in &self.pictures {
            xml.element("figure", &[], |xml| xml.markup(picture));
        }
        write_table(xml, "Settings", &table::of_settings(self.report));
        if !self.report.features.is_empty() {
            write_table(xml, "Features that could be left out", &table::of_features(self.report));
            let changes = table::of_changes(self.report);
            write_table(xml, "Changes of the outputs, relative to their largest values", &changes);
        }
        let faults = table::faults(self.report);
        if !faults.is_empty() {
            xml.text("h3", &[], "Without result");
            xml.element("ul", &[], |xml| faults.iter().for_each(|fault| xml.text("li", &[], fault)));
        }
        let text = format!("All numbers are in {FOLDER}/tradeoff.json and tradeoff.csv inside this FMU.");
        xml.text("p", &[], &text);
    }
}

fn write_table(xml: &mut Xml, title: &str, table: &Table) {
    xml.text("h3", &[], title);
    xml.table(table);
}
