//! The report of a cam: files, text.

use super::files::{self, Drawn};
use super::{Carrier, Cut, Disc, Finding, Shape, Verdict, degrees, figures};
use crate::plot::Diagram;
use crate::text::{Table, number};
use camdrive::drives::Fault;
use serde::Serialize;

/// A file: its ending and its content.
pub type File = (String, Result<String, Fault>);

impl Shape {
    /// The cam in a line.
    fn about(&self) -> String {
        let cut = match self.plan.cut {
            _ if self.plan.carrier == Carrier::Flat => "disc cam of a flat face",
            Cut::Inner => "disc cam (inner contour)",
            Cut::Outer => "ring cam (outer contour)",
            Cut::Groove => "groove cam (inner and outer contour)",
            Cut::Conjugate(_) => "conjugate disc cams F and P",
        };
        let sense = if self.plan.sense > 0.0 { "counter-clockwise" } else { "clockwise" };
        format!("{}: {cut}, turning {sense}", self.name)
    }

    /// The report; its tables for lines of `width` characters.
    pub fn text(&self, width: usize) -> String {
        let mut out = self.about() + "\n";
        for disc in &self.cams {
            let head = ["", "value", "at φ", "", ""].map(str::to_owned);
            let rows = disc.findings.iter().map(|f| {
                let verdict = match f.verdict {
                    Verdict::Good => "",
                    Verdict::Warning => "WARNING",
                    Verdict::Fault => "FAULT",
                };
                let phi = if f.value.is_infinite() { "–".to_owned() } else { format!("{:.3}°", degrees(f.phi)) };
                vec![f.what.clone(), f.shown(), phi, verdict.to_owned(), f.remark.clone()]
            });
            let mut head = Vec::from(head);
            if !disc.name.is_empty() {
                head[0] = format!("cam {}", disc.name);
            }
            let table = Table { head, rows: rows.collect() };
            out += &table.text(width);
            out += &format!(
                "  {} points, chord error at most {:.3} µm\n",
                disc.mesh.at.len(),
                1e6 * disc.mesh.chord_error
            );
        }
        let error = match self.plan.angular {
            true => format!("{} µrad", number(1e6 * self.table.error)),
            false => format!("{} µm", number(1e6 * self.table.error)),
        };
        out += &format!("  cam table of {} rows, straight interpolation within {error}\n", self.table.rows.len());
        out
    }

    /// The diagrams over the turn, with the endings of their files.
    pub fn diagrams(&self) -> [(&'static str, Diagram); 2] {
        let first = if self.plan.carrier == Carrier::Flat { "contact" } else { "pressure_angle" };
        [(first, figures::pressure(self)), ("curvature", figures::curvature(self))]
    }

    /// All other files; the endings tell them apart.
    pub fn files(&self) -> Vec<File> {
        let drawn: Vec<Drawn<'_>> = self
            .cams
            .iter()
            .map(|c| Drawn {
                name: c.name,
                cam: &c.cam,
                mesh: &c.mesh,
                sides: self.plan.cut.sides(),
                angular: self.plan.angular,
                hub: self.plan.limits.hub,
            })
            .collect();
        let ending = |name: &str, ending: &str| {
            if name.is_empty() { ending.to_owned() } else { format!("{name}.{ending}") }
        };
        let mut list: Vec<File> = drawn.iter().map(|d| (ending(d.name, "csv"), files::csv(d))).collect();
        list.push(("dxf".to_owned(), Ok(files::dxf(&self.name, &drawn))));
        list.push(("svg".to_owned(), Ok(files::svg(&self.name, &drawn))));
        list.push(("plcopen.csv".to_owned(), Ok(self.table.plcopen())));
        list.push(("plc.txt".to_owned(), Ok(self.table.two_columns())));
        list
    }

    /// The numbers of the report, for programs.
    pub fn summary(&self) -> Summary<'_> {
        let cam = |c: &Disc| CamSummary {
            cam: c.name,
            points: c.mesh.at.len(),
            chord_error: c.mesh.chord_error,
            findings: c.findings.clone(),
        };
        Summary {
            name: &self.name,
            cut: self.about(),
            cams: self.cams.iter().map(cam).collect(),
            cam_table_rows: self.table.rows.len(),
            cam_table_error: self.table.error,
        }
    }
}

/// Report of a cam or a pair of them, in SI units.
#[derive(Debug, Serialize)]
pub struct Summary<'a> {
    name: &'a str,
    cut: String,
    cams: Vec<CamSummary>,
    cam_table_rows: usize,
    cam_table_error: f64,
}

#[derive(Debug, Serialize)]
struct CamSummary {
    cam: &'static str,
    points: usize,
    chord_error: f64,
    findings: Vec<Finding>,
}
