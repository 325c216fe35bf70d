//! A cam of a law with its geometry, and the findings on it.

use super::cam_table::CamTable;
use super::contour::NoMesh;
use super::{Cam, Carrier, Finding, Mesh, Outline, Plan, checks};
use crate::report::Level;
use camdrive::drives::Fault;
use camdrive::motion::MotionLaw;

/// The accuracy of the files.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerances {
    /// The largest distance between contour and chord (m).
    pub chord: f64,
    /// The largest error of a motion controller's straight interpolation (m); the error of an angle counts on the roller's arm.
    pub table: f64,
}

impl Default for Tolerances {
    /// A micrometre each, which no machine can cut.
    fn default() -> Self {
        Tolerances { chord: 1e-6, table: 1e-6 }
    }
}

/// A cam, or the two of a conjugate pair.
pub struct Shape {
    /// Its name in titles and file names.
    pub name: String,
    /// The geometry.
    pub plan: Plan,
    /// The cams.
    pub cams: Vec<Disc>,
    /// The law as a table for a controller.
    pub table: CamTable,
}

/// One cam.
pub struct Disc {
    /// "F" and "P" of a pair, else empty.
    pub name: &'static str,
    /// The cam.
    pub cam: Cam,
    /// Its angles.
    pub mesh: Mesh,
    /// Findings on it.
    pub findings: Vec<Finding>,
}

impl Shape {
    /// The cam of `law`.
    ///
    /// # Errors
    /// A circle that no follower has, a roller's centre that stands still on the cam, and a chord error that needs too many
    /// points.
    pub fn new(name: &str, law: &MotionLaw, plan: Plan, tolerances: Tolerances) -> Result<Shape, Fault> {
        let sides = plan.cut.sides();
        let disc = |(name, cam): (&'static str, Cam)| -> Result<Disc, NoMesh> {
            let mesh = Mesh::new(&cam, sides, tolerances.chord)?;
            let outlines: Vec<Outline> = sides.iter().map(|side| mesh.outline(&cam, *side)).collect();
            let findings = checks::findings(&cam, &plan, &outlines)?;
            Ok(Disc { name, cam, mesh, findings })
        };
        let cams: Result<Vec<Disc>, NoMesh> = plan.cams(law)?.into_iter().map(disc).collect();
        // The error of an angle counts on the roller's arm.
        let arm = match plan.carrier {
            Carrier::Lever { length, transmission, .. } if plan.angular => length / transmission.abs(),
            _ => 1.0,
        };
        let table = CamTable::new(law, plan.angular, tolerances.table / arm);
        Ok(Shape { name: name.to_owned(), plan, cams: cams?, table })
    }

    /// The shape with further findings on the parts that the cam moves.
    pub fn with(mut self, findings: impl IntoIterator<Item = Finding>) -> Self {
        if let Some(first) = self.cams.first_mut() {
            first.findings.extend(findings);
        }
        self
    }

    /// The worst of all findings.
    pub fn verdict(&self) -> Level {
        self.cams.iter().flat_map(|c| c.findings.iter().map(|f| f.verdict)).max().unwrap_or(Level::Good)
    }

    /// The findings that are not good, each in a sentence with its angle.
    pub fn complaints(&self, verdict: Level) -> Vec<String> {
        let all = self.cams.iter().flat_map(|c| c.findings.iter().map(move |f| (c.name, f)));
        let bad = all.filter(|(_, f)| f.verdict == verdict);
        let sentence = |(cam, f): (&str, &Finding)| {
            let cam = if cam.is_empty() { String::new() } else { format!(" {cam}") };
            format!("{}{cam}: {}: {}", self.name, f.placed(), f.remark)
        };
        bad.map(sentence).collect()
    }
}
