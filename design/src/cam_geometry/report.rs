//! The report of cams, and their files.

use super::files::{self, CamDrawing};
use super::{Carrier, Cut, Disc, Finding, Shape, degrees, figures};
use crate::plot::Diagram;
use crate::report::terminal::shown;
use crate::report::unit::{DEG, MM, ONE};
use crate::report::{Advice, Block, Claim, Level, Report, Setting, Table, Value, Verdict};
use camdrive::drives::Fault;
use serde::Serialize;

/// Significant digits of a limiting radius.
const FINE: usize = 4;

/// A file: its ending and its content.
pub type File = (String, Result<String, Fault>);

impl Shape {
    /// The kind and the size of the cam.
    fn about(&self) -> String {
        let cut = match self.plan.cut {
            _ if self.plan.carrier == Carrier::Flat => "disc cam of a flat face",
            Cut::Inner => "disc cam (inner contour)",
            Cut::Outer => "ring cam (outer contour)",
            Cut::Groove => "groove cam (inner and outer contour)",
            Cut::Conjugate(_) => "conjugate disc cams F and P",
        };
        let sense = if self.plan.sense > 0.0 { "counter-clockwise" } else { "clockwise" };
        format!("{cut}, turning {sense}")
    }

    /// "Follower 1" of a cam of a machine, with the name of the cam if it is one of a pair.
    fn part(&self, scene: &str, disc: &str) -> String {
        let follower = self.number(scene).map_or(self.name.clone(), |j| format!("Follower {j}"));
        format!("{follower} {disc}").trim_end().to_owned()
    }

    /// The number of its follower in the scene.
    fn number(&self, scene: &str) -> Option<usize> {
        self.name.strip_prefix(scene)?.strip_prefix(".follower")?.parse().ok()
    }

    /// The setting of the largest radius (m) of its rollers.
    fn roller(&self, scene: &str, most: f64) -> Setting {
        let key = |number| format!("follower[{number}].geometry.roller_radius");
        let key = self.number(scene).map_or("geometry.roller_radius".to_owned(), key);
        Setting::at_most(key, most, &MM, FINE)
    }

    /// The findings on its contours, in a table for each cam.
    fn tables(&self, scene: &str) -> impl Iterator<Item = Table> {
        let unit = if self.plan.angular { DEG } else { MM };
        let error = shown(self.table.error, &unit);
        let rows = self.table.rows.len();
        self.cams.iter().map(move |disc| {
            let contour =
                format!("{} points, chord error at most {}", disc.mesh.at.len(), shown(disc.mesh.chord_error, &MM));
            Table::of(format!("{}: {}", self.part(scene, disc.name), self.about()), &disc.findings)
                .column("what", "property", ONE, |f| &f.what)
                .column("value", "value", ONE, Finding::shown)
                .column("phi", "at φ", ONE, |f| f.value.is_finite().then(|| format!("{:.1}°", degrees(f.phi))))
                .column("verdict", "", ONE, |f| ["", "warning", "fault"][f.verdict as usize])
                .column("remark", "", ONE, |f| Value::Text(f.remark.clone()))
                .below([contour, format!("cam table of {rows} rows, straight interpolation within {error}")])
                .below(self.table.jumps_told())
                .into()
        })
    }

    /// Adds whether it can be cut and runs well, and the advised changes.
    fn judge(&self, scene: &str, verdict: &mut Verdict) {
        for (disc, finding) in self.cams.iter().flat_map(|disc| disc.findings.iter().map(move |f| (disc, f))) {
            if finding.verdict != Level::Good {
                let part = self.part(scene, disc.name);
                verdict.result(finding.verdict, format!("{part}: {}.", finding.placed()));
                let advice = Advice::new(format!("{part}: {}.", finding.remark));
                let smaller = finding.what.ends_with(ROLLER).then(|| self.roller(scene, finding.value));
                verdict.advice(advice.set(smaller, Claim::Cut { follower: self.number(scene) }));
            }
        }
        if self.verdict() != Level::Bad {
            let of = |disc: &Disc| {
                let told = disc.findings.iter().filter(|f| TOLD.iter().any(|what| f.what.starts_with(what)));
                let told: Vec<String> = told.map(Finding::placed).collect();
                format!("{} {}", disc.name, told.join("; ")).trim_start().to_owned()
            };
            let told: Vec<String> = self.cams.iter().map(of).collect();
            let what = self.part(scene, "");
            verdict.result(Level::Good, format!("{what} can be cut: {}.", told.join("; ")));
            let all = self.cams.iter().flat_map(|disc| &disc.findings).filter(|f| f.what.ends_with(ROLLER));
            let least = all.min_by(|a, b| a.value.total_cmp(&b.value));
            if let Some(least) = least.filter(|least| least.value < RESERVE * self.plan.roller) {
                let own = shown(self.plan.roller, &MM);
                let limit = self.roller(scene, least.value);
                let text = format!("{what}: keep the roller radius at {} or less (now {own}).", limit.value);
                verdict.advice(Advice::new(text).set([limit], Claim::Cut { follower: self.number(scene) }));
            }
        }
    }

    /// The diagrams over the turn, with the endings of their files.
    pub fn diagrams(&self) -> [(&'static str, Diagram); 2] {
        let first = if self.plan.carrier == Carrier::Flat { "contact" } else { "pressure_angle" };
        [(first, figures::pressure(self)), ("curvature", figures::curvature(self))]
    }

    fn drawn(&self) -> Vec<CamDrawing<'_>> {
        let (sides, angular) = (self.plan.cut.sides(), self.plan.angular);
        let hub = self.plan.limits.hub;
        self.cams.iter().map(|c| CamDrawing { name: c.name, cam: &c.cam, mesh: &c.mesh, sides, angular, hub }).collect()
    }

    /// The files for workshop and controller, which differ in their endings.
    pub fn files(&self) -> Vec<File> {
        let drawn = self.drawn();
        let ending = |name: &str, ending: &str| {
            if name.is_empty() { ending.to_owned() } else { format!("{name}.{ending}") }
        };
        let mut list: Vec<File> = drawn.iter().map(|d| (ending(d.name, "csv"), files::csv(d))).collect();
        list.push(("dxf".to_owned(), Ok(files::dxf(&self.name, &drawn))));
        list.push(("plcopen.csv".to_owned(), Ok(self.table.plcopen())));
        list.push(("plc.txt".to_owned(), Ok(self.table.two_columns())));
        list
    }

    /// Its numbers.
    fn summary(&self) -> Summary<'_> {
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

/// Findings that the verdict names for a cam that can be cut.
const TOLD: [&str; 4] =
    ["largest pressure angle", "least width of the face", "undercut of the inner contour: smallest", "smallest con"];

/// A roller whose radius is below its limit by this factor needs no warning.
const RESERVE: f64 = 2.0;

/// The equations, of rollers and of flat faces.
const EQUATIONS: [&str; 3] = [
    "z = e^(−iσφ) p is the path of the roller's centre seen from the cam; its curvature is κ = Im(z̄′z″)/|z′|³, that of a contour \
     at the distance ϱ is κ/(1 ∓ ϱκ). Undercut begins at ϱ = 1/κ.",
    "The pressure angle lies between the common normal and the direction in which the roller's centre moves. A flat face touches \
     at x = U′; there the radius of curvature is h + U″.",
    "Sources: VDI 2142 and VDI 2143; Norton, Cam Design and Manufacturing Handbook, section 7.4 (flat face).",
];

/// The finding that limits the roller.
const ROLLER: &str = "largest admissible roller radius";

/// The cams of a scene, in SI units.
#[derive(Serialize)]
pub struct CamSet<'a> {
    scene: &'a str,
    followers: Vec<Summary<'a>>,
    #[serde(skip)]
    shapes: &'a [Shape],
}

/// A cam or a pair of them.
#[derive(Serialize)]
struct Summary<'a> {
    name: &'a str,
    cut: String,
    cams: Vec<CamSummary>,
    cam_table_rows: usize,
    cam_table_error: f64,
}

#[derive(Serialize)]
struct CamSummary {
    cam: &'static str,
    points: usize,
    chord_error: f64,
    findings: Vec<Finding>,
}

impl<'a> CamSet<'a> {
    /// The findings on the cams of a scene.
    pub fn new(scene: &'a str, shapes: &'a [Shape]) -> Self {
        CamSet { scene, followers: shapes.iter().map(Shape::summary).collect(), shapes }
    }

    /// The report.
    pub fn report(&self) -> Report {
        let mut report = Report::new(self.scene, "cams");
        report.explain("Geometry of cams", EQUATIONS.map(str::to_owned));
        for shape in self.shapes {
            shape.judge(self.scene, &mut report.verdict);
            shape.tables(self.scene).for_each(|table| report.body.push(Block::Table(table)));
            let of = shape.name.strip_prefix(self.scene).unwrap_or_default().trim_start_matches('.');
            report.drawing(of, files::drawing(&shape.name, &shape.drawn()), &format!("Cam of {}", shape.name), 1.0);
            for (key, diagram) in shape.diagrams() {
                report.diagram(&if of.is_empty() { key.to_owned() } else { format!("{of}.{key}") }, diagram);
            }
        }
        report
            .verdict
            .certainty("The values are extremes over the whole turn; the contours are exact to their chord errors.");
        report
    }
}
