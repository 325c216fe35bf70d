//! The scene of a `ParametricDrive`: `[crank]` with `[load]`, or `[coefficients]`.

use super::load::{self, Carrier};
use super::motion_law;
use super::{common, coupling};
use crate::document::{Node, Section, Value, keys::PARAMETRIC_LOAD};
use camdrive::drives::follower::load::Load;
use camdrive::drives::parametric::Scene;
use camdrive::drives::parametric::coefficients::Stiffness;
use camdrive::drives::parametric::crank::{ParallelCrank, SecondCrank};
use camdrive::drives::parametric::law::{Coordinate, CrankLaw, Law, SeriesLaw};
use camdrive::drives::unit::{self, Quantity};
use camdrive::motion::Fourier;
use camdrive::motion::fourier::HIGHEST_HARMONIC;
use camdrive_design::harmonic_analysis::discrete_series;
use camdrive_design::text::{self, counted};
use std::f64::consts::TAU;
use std::path::Path;

/// The admissible error of a series for a law, as a fraction of its range; measured coefficients are accurate to some thousandths.
const MET: f64 = 1e-3;

/// Angles of the turn at which a law is sampled for its series, sixteen in the shortest wave.
const SAMPLES: usize = 4096;

/// The scene.
pub fn read(root: &Section<'_>, folder: &Path) -> Option<Scene> {
    let section = root.section_of(load::KEY, &PARAMETRIC_LOAD);
    let table = section.as_ref().and_then(Option::as_ref);
    let law = law(root, table, folder);
    let load = match table {
        Some(section) => loads(root, section, law.as_ref(), folder),
        None => section.as_ref().map(|_| Load::default()),
    };
    let coordinate = law.as_ref().map_or(Coordinate::Rotation, Law::coordinate);
    let drive = root.required_section("drive").and_then(|s| common::drive_mode(&s));
    let start = common::start(root, coordinate == Coordinate::Rotation);
    coupling::of_drive(root, Err("remove it and connect tau: the mass vibrates on a spring"))?;
    let solver = common::solver(root);
    Some(Scene { law: law?, drive: drive?, load: load?, start: start?, solver: solver? })
}

/// The loads on the mass.
fn loads(root: &Section<'_>, section: &Section<'_>, law: Option<&Law>, folder: &Path) -> Option<Load> {
    let coordinate = root.section("coefficients")?.and_then(|section| coordinate(&section));
    if root.has("crank") {
        let because = "the driven side turns with the drive and would wind up a spring to the ground";
        section.forbid(&["spring"], because, "`crank.c_T1` and `crank.c_T2` for a spring between both sides");
    }
    if matches!(law, Some(Law::Series(series)) if series.m.order() > 0) {
        let because = "m varies, so that the weight need not be m g";
        section.forbid(&["gravity", "gravity_angle"], because, "`process` for the force of the weight");
    }
    let turns = coordinate != Some(Coordinate::Translation);
    load::of(section, Carrier { turns, mechanisms: 0, follower: None, roller: false }, folder).map(|[load, _]| load)
}

fn law(root: &Section<'_>, load: Option<&Section<'_>>, folder: &Path) -> Option<Law> {
    let (crank, series) = (root.section("crank"), root.section("coefficients"));
    match (crank?, series?) {
        (Some(section), None) => crank_law(&section, load).map(Law::Crank),
        (None, Some(section)) => {
            if let Some(load) = load {
                load.forbid(
                    &["scale", "a"],
                    "the coefficients have their own load",
                    "f in [coefficients], or `process`",
                );
            }
            series_law(&section, folder).map(Law::Series)
        }
        (Some(crank), Some(series)) => {
            // Reads them only to report their faults.
            let _ = (crank_law(&crank, load), series_law(&series, folder));
            let fault = root.fault_of("coefficients", ": the crank has its own");
            root.refuse(fault.hint("give [crank] or [coefficients], not both"))
        }
        (None, None) => {
            if !root.faults.broken() {
                let fault = root.fault_at("model", " or `coefficients` is missing").of("crank");
                let hint = "add a section [crank], for a parallel-crank drive, or [coefficients], for series";
                root.faults.report(fault.hint(hint));
            }
            None
        }
    }
}

fn crank_law(section: &Section<'_>, load: Option<&Section<'_>>) -> Option<CrankLaw> {
    // The damping ratio needs the stiffness.
    let law: Option<CrankLaw> = section.parameters(|parameter, _| (parameter.key == "b_T").then_some(Some(0.0)));
    let second = second_crank(section);
    let harmonics = if section.has("harmonics") { section.count("harmonics").map(Some) } else { Some(None) };
    // The other keys of the table are reported with the loads.
    let given = load.filter(|load| ["scale", "a", "b"].map(|key| load.has(key)).contains(&true));
    let load = given.map_or(Some(None), |load| motion_law::fourier(load, &unit::TORQUE).map(Some));
    let damping = damping(section, "b_T", Path::new(""), || {
        let CrankLaw { crank, inertia, .. } = law.as_ref()?;
        // The means of both, with the second crank.
        Some((*inertia, Stiffness::of_crank(&ParallelCrank { second: second?, ..*crank }).mean()))
    });
    section.finish();
    let law = law?;
    let crank = ParallelCrank { second: second?, ..law.crank };
    Some(CrankLaw { crank, damping: damping?.a[0], load: load?, harmonics: harmonics?, ..law })
}

/// A second crank at an angle.
type SecondAt = Option<fn(f64) -> SecondCrank>;

/// The shafts of a second crank.
pub const SECOND_CRANKS: &[(&str, SecondAt)] =
    &[("none", None), ("own_shafts", Some(SecondCrank::OwnShafts)), ("shared_shafts", Some(SecondCrank::SharedShafts))];

/// The meanings of q.
pub const COORDINATES: &[(&str, Coordinate)] =
    &[("rotation", Coordinate::Rotation), ("translation", Coordinate::Translation)];

fn second_crank(section: &Section<'_>) -> Option<SecondCrank> {
    let Some(at) = section.choice("second", SECOND_CRANKS)? else {
        let needed = "second = \"own_shafts\" or second = \"shared_shafts\"";
        section.forbid(&["angle"], "there is no second crank", needed);
        return Some(SecondCrank::None);
    };
    section.real("angle").map(at)
}

fn coordinate(section: &Section<'_>) -> Option<Coordinate> {
    section.choice("coordinate", COORDINATES)
}

fn series_law(section: &Section<'_>, folder: &Path) -> Option<SeriesLaw> {
    let coordinate = coordinate(section);
    section.turning(coordinate != Some(Coordinate::Translation));
    let [m, c] = ["m", "c"].map(|key| coefficient(section, key, folder));
    let b = damping(section, "b", folder, || Some((m.as_ref()?.a[0], c.as_ref()?.a[0])));
    let f = if section.has("f") { coefficient(section, "f", folder).map(Some) } else { Some(None) };
    section.finish();
    Some(SeriesLaw { coordinate: coordinate?, m: m?, b: b?, c: c?, f: f? })
}

/// The damping `key`, a value, a series or missing, or `damping_ratio` D: b = 2 D √(m c) with the means of m and c.
fn damping(
    section: &Section<'_>,
    key: &'static str,
    folder: &Path,
    means: impl FnOnce() -> Option<(f64, f64)>,
) -> Option<Fourier> {
    let constant = |value: f64| Fourier::new(vec![value], Vec::new());
    if !section.either(key, "damping_ratio") {
        return None;
    }
    if section.has("damping_ratio") {
        let ratio = section.real("damping_ratio")?;
        let (m, c) = means()?;
        if m * c < 0.0 {
            let fault = section.fault_of("damping_ratio", ": the mean stiffness is below 0");
            return section.refuse(fault.hint(format!("give the damping as {key}")));
        }
        return Some(constant(2.0 * ratio * (m * c).sqrt()));
    }
    if !section.has(key) {
        return Some(constant(0.0));
    }
    coefficient(section, key, folder)
}

/// A constant, or a table with the coefficients of a series.
fn coefficient(section: &Section<'_>, key: &'static str, folder: &Path) -> Option<Fourier> {
    if let Some(Node { value: Value::Table(_), .. }) = section.node(key) {
        return series_of(&section.section(key)??, section.quantity_of(key), folder);
    }
    section.real(key).map(|value| Fourier::new(vec![value], Vec::new()))
}

/// A series, or the series of a law over the turn, with as many harmonics as [`MET`] needs.
fn series_of(section: &Section<'_>, quantity: &'static Quantity, folder: &Path) -> Option<Fourier> {
    if ["law", "file", "points"].into_iter().any(|key| section.has(key)) {
        let law = motion_law::read(section, quantity, folder)?;
        if let Some(series) = law.series() {
            return Some(series.clone());
        }
        let values: Vec<f64> = (0..SAMPLES).map(|i| law.at(TAU * i as f64 / SAMPLES as f64).0[0]).collect();
        let range = values.iter().fold(0.0_f64, |range, value| range.max((value - values[0]).abs()));
        let whole = discrete_series(0.0, &values, HIGHEST_HARMONIC);
        let first = |count: usize| Fourier::new(whole.a[..=count].to_vec(), whole.b[..=count].to_vec());
        let missed = |series: &Fourier| {
            let at = |i: usize| series.at(TAU * i as f64 / SAMPLES as f64).0[0];
            values.iter().enumerate().fold(0.0_f64, |most, (i, value)| most.max((at(i) - value).abs()))
        };
        let counts = (2..).map(|power| 1_usize << power).take_while(|count| *count <= HIGHEST_HARMONIC);
        let tried = counts.map(first).map(|series| (missed(&series), series));
        let (error, series) = tried.fold(None, |best: Option<(f64, Fourier)>, next| {
            best.filter(|best| best.0 <= MET * range).or(Some(next))
        })?;
        section.faults.note(format!(
            "`{}`: {} meet the law to {} {}",
            section.path,
            counted(series.order(), "harmonic"),
            text::number(error),
            quantity.unit
        ));
        return Some(series);
    }
    let series = motion_law::fourier(section, quantity);
    section.finish();
    series
}
