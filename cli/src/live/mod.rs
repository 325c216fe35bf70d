//! A page that computes: its scene with other values, read and studied by the code of the commands.

mod dials;

#[cfg(not(target_arch = "wasm32"))]
pub mod page;

use crate::document::{Diagnostics, Document, Kind, input};
use crate::scene::{self, Resolved};
use camdrive::drives::variable::{Causality, Variability};
use camdrive_design::overview;
use camdrive_design::plot::{Axis, Diagram, Rule, Series};
use camdrive_design::report::{Figure, Level, Picture, Report, Verdict, html};
use camdrive_design::steady;
pub use dials::{Dial, dials};
use serde_json::{Value, json};
use std::cell::OnceCell;
use std::path::Path;

/// The points of a run in a diagram.
const POINTS: usize = 600;

/// Points after which a run says how far it is.
const TENTH: usize = POINTS / 10;

/// Outputs in the diagrams of a run, those of a turn.
const OF_RUN: [(&[&str], &str); 4] = [
    (&["x", "U", "y"], "Law and tool"),
    (&["q", "gap"], "Deformation and gap"),
    (&["force", "contact_force", "tau", "M_an"], "Force and torque"),
    (&["w"], "Speed"),
];

/// The sources of a module of pages: the tool packs none of others.
pub const BUILD: &str = concat!("camdrive page ", env!("CAMDRIVE_PAGE"));

/// A scene whose values may change.
pub struct Live {
    file: String,
    document: Document,
    folder: std::path::PathBuf,
    /// Its diagrams as the file has it in each depth, once they are asked for.
    own: [OnceCell<Vec<Figure>>; 3],
}

/// How much of an answer a page asks for.
#[derive(Clone, Copy, PartialEq)]
pub enum Depth {
    /// Verdict, diagrams and tables.
    Whole,
    /// The diagrams of the periodic motion, in the lines of a sketch.
    Sketch,
    /// Those of the default experiment, of a scene that is known to have no periodic motion.
    Run,
}

impl Depth {
    fn reports(self, scene: &Resolved, progress: fn(f64)) -> Vec<Report> {
        match self {
            Depth::Whole => reports(scene, progress),
            Depth::Sketch => vec![sketch(scene, progress)],
            Depth::Run => vec![run(scene, progress)],
        }
    }
}

/// New values of keys, written as in a scene.
pub type Values = Vec<(String, String)>;

impl Live {
    /// The scene in this file, as [`input::hold`] may hold it.
    ///
    /// # Errors
    /// The faults of the scene.
    pub fn open(path: &Path) -> Result<Self, Diagnostics> {
        let (file, document) = input::document(path, Kind::Scene)?;
        Live::new(&file, document, path.parent().unwrap_or(Path::new("")))
    }

    /// The same of a document.
    ///
    /// # Errors
    /// The faults of the scene.
    pub fn new(file: &str, document: Document, folder: &Path) -> Result<Self, Diagnostics> {
        let live = Live { file: file.to_owned(), document, folder: folder.to_owned(), own: Default::default() };
        live.with(&Values::new()).map(|_| live)
    }

    /// The scene with other values.
    ///
    /// # Errors
    /// The faults of these values.
    pub fn with(&self, values: &Values) -> Result<Resolved, Diagnostics> {
        scene::variant(&self.file, &self.changed(values), &self.folder)
    }

    fn changed(&self, values: &Values) -> Document {
        let mut document = self.document.clone();
        for (key, text) in values {
            match dials::element(key) {
                Some((list, at)) => document.set(list, dials::list_with(&document, list, at, text)),
                None => document.set(key, dials::written(text)),
            };
        }
        document
    }

    /// The scene of a sketch, of which nothing is tried out but the motion itself.
    fn drawn(&self, values: &Values, depth: Depth) -> Result<Resolved, Diagnostics> {
        match depth {
            Depth::Whole => self.with(values),
            _ => scene::as_written(&self.file, &self.changed(values), &self.folder),
        }
    }

    /// The answer for a page: its sections or, as a sketch, its diagrams alone; or the faults of the values.
    /// `progress` hears how much of a run is done (0 to 1).
    pub fn answer(&self, values: &Values, depth: Depth, progress: fn(f64)) -> Value {
        let scene = match self.drawn(values, depth) {
            Ok(scene) => scene,
            Err(Diagnostics(faults)) => {
                let fault = |of: &crate::document::Diagnostic| {
                    let more = [of.admissible.as_ref().map(|text| format!("admissible: {text}")), of.hint.clone()];
                    let text: String = more.into_iter().flatten().map(|text| format!("; {text}")).collect();
                    json!({ "key": of.key, "text": format!("{}{text}", of.message) })
                };
                return json!({ "faults": faults.iter().map(fault).collect::<Vec<_>>() });
            }
        };
        let own = self.own[depth as usize].get_or_init(|| match self.drawn(&Values::new(), depth) {
            Ok(scene) => depth.reports(&scene, progress).into_iter().flat_map(|report| report.figures).collect(),
            Err(_) => Vec::new(),
        });
        let behind = |figure: Figure| match own.iter().find(|own| own.key == figure.key) {
            Some(own) if !values.is_empty() => before(figure, own),
            _ => figure,
        };
        let of_these: Vec<Report> = (depth.reports(&scene, progress).into_iter())
            .map(|report| Report { figures: report.figures.into_iter().map(behind).collect(), ..report })
            .collect();
        json!({ "html": html::sections(&of_these) })
    }
}

/// The figure before the curves of the scene as the file has it, which it shows as thin lines.
fn before(figure: Figure, own: &Figure) -> Figure {
    let (Picture::Diagram(mut diagram), Picture::Diagram(own)) = (figure.picture.clone(), &own.picture) else {
        return figure;
    };
    diagram.rules.extend(own.series.iter().map(|series| Rule::Border(series.points.clone(), THIN)));
    Figure { picture: Picture::Diagram(diagram), ..figure }
}

/// Of the lines behind (pixels).
const THIN: f64 = 0.5;

/// The reports that follow the values: one verdict over all, the motion, and the characteristic values.
pub fn reports(scene: &Resolved, progress: fn(f64)) -> Vec<Report> {
    let resource = scene.resource();
    let mut found = overview::of(&resource);
    found.warnings.extend(scene.smoothed.iter().filter_map(|table| table.warning.clone()));
    let motion = match steady::of_overview(&resource, &found) {
        Some(motions) => {
            let mut report = motions.report();
            let spectra = motions.turn.as_ref().map_or(Vec::new(), |turn| steady::spectra(&scene.name, turn));
            spectra.into_iter().for_each(|(key, diagram)| {
                report.diagram(&key, diagram);
            });
            report
        }
        None => run(scene, progress),
    };
    let values = found.report(&scene.name, "characteristic values");
    let mut glance = Report::new(&scene.name, "the design at a glance");
    glance.verdict = Verdict::over_all([&motion, &values]);
    found.note(&mut glance.verdict);
    vec![glance, motion, values]
}

/// The diagrams of the motion, in the lines of a sketch.
fn sketch(scene: &Resolved, progress: fn(f64)) -> Report {
    let mut report = Report::new(&scene.name, "periodic motion");
    for (key, diagram) in steady::sketch(&scene.resource()) {
        report.diagram(&key, diagram);
    }
    if report.figures.is_empty() { run(scene, progress) } else { report }
}

/// The default experiment, of a scene without a periodic motion.
fn run(scene: &Resolved, progress: fn(f64)) -> Report {
    let mut report = Report::new(&scene.name, "run");
    match record(scene, progress) {
        Ok(diagrams) => diagrams.into_iter().for_each(|(key, diagram)| {
            report.diagram(&key, diagram);
        }),
        Err(fault) => {
            report.verdict.result(Level::Bad, camdrive_design::text::sentence(&fault.sentence()));
        }
    }
    report
}

/// Its outputs over time.
fn record(scene: &Resolved, progress: fn(f64)) -> Result<Vec<(String, Diagram)>, camdrive::drives::Fault> {
    let mut drive = scene.resource().build()?;
    drive.set_up(0.0, None);
    drive.start()?;
    let stop = drive.experiment().stop;
    let all = drive.descriptions().to_vec();
    let is_shown = |parts: &[&str], name: &str| {
        parts.contains(&name.rsplit('.').next().unwrap_or(name).split('[').next().unwrap_or(""))
    };
    let wanted = |i: &usize| {
        let of = &all[*i];
        of.causality == Causality::Output
            && of.variability == Variability::Continuous
            && OF_RUN.iter().any(|(parts, _)| is_shown(parts, &of.name))
    };
    let shown: Vec<usize> = (0..all.len()).filter(wanted).collect();
    let mut columns = vec![Vec::new(); shown.len()];
    let step = stop / POINTS as f64;
    for k in 0..=POINTS {
        let time = k as f64 * step;
        for (column, i) in columns.iter_mut().zip(&shown) {
            column.push([time, drive.get(*i)?]);
        }
        if k % TENTH == 0 {
            progress(k as f64 / POINTS as f64);
        }
        if k < POINTS {
            drive.advance(time, step)?;
        }
    }
    let mut left: Vec<(usize, Vec<[f64; 2]>)> = shown.into_iter().zip(columns).collect();
    let mut diagrams = Vec::new();
    while let Some((first, _)) = left.first() {
        let unit = unit_of(&all[*first]);
        let title = OF_RUN.iter().find(|(parts, _)| is_shown(parts, &all[*first].name)).map_or("", |(_, title)| title);
        let (own, others) = left.into_iter().partition(|(i, _)| {
            unit_of(&all[*i]) == unit && OF_RUN.iter().any(|(parts, of)| *of == title && is_shown(parts, &all[*i].name))
        });
        left = others;
        let own: Vec<(usize, Vec<[f64; 2]>)> = own;
        let series = own.into_iter().map(|(i, points)| Series::line(all[i].name.clone(), points)).collect();
        let axes = [Axis::linear("Time [s]"), Axis::linear(&format!("{title} [{unit}]"))];
        diagrams.push((
            format!("run{}", diagrams.len()),
            Diagram::new(format!("{title} of {}", scene.name), axes, series, Vec::new()),
        ));
    }
    Ok(diagrams)
}

fn unit_of(of: &camdrive::drives::Description) -> &'static str {
    match of.kind {
        camdrive::drives::variable::Kind::Real { quantity, .. } => quantity.unit,
        _ => "1",
    }
}
