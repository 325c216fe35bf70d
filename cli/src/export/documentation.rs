//! documentation/index.html: the report on an FMU for its users, in one file without network access or scripts to run.

use super::model_description::{LOG_CATEGORIES, causality, unit};
use super::results::Results;
use super::{picture, references};
use camdrive::drives::variable::{Causality, Kind, Variability};
use camdrive::drives::{AnyDrive, Description, Fault};
use camdrive_design::drawing::Drawing;
use camdrive_design::overview;
use camdrive_design::report::unit::ONE;
use camdrive_design::report::{Block, Report, Table, html};
use camdrive_design::resource::{Described, Resource};
use camdrive_design::steady;
use camdrive_design::text;

/// Parts of the page that do not follow from the drive itself.
#[derive(Clone, Copy, Default)]
pub struct Page<'a> {
    /// The description in the scene.
    pub description: &'a str,
    /// The folders in `binaries/`.
    pub platforms: &'a [&'a str],
    /// The outputs over the default experiment.
    pub results: Option<&'a Results>,
    /// Whether a page that computes is next to it.
    pub live: bool,
}

/// The text of index.html.
///
/// # Errors
/// Errors in the drive's text or its start values.
pub fn html(resource: &Resource, drive: &mut Described, page: &Page<'_>) -> Result<String, Fault> {
    let own = report(resource, drive, page)?;
    let overview = overview::of(resource);
    let motion = steady::of_overview(resource, &overview).map(|motion| motion.report());
    let mut values = overview.report("", "characteristic values");
    motion.iter().for_each(|motion| values.verdict.leave_out(&motion.verdict));
    let mut interface = Report::new("", "variables");
    interface.table(variables(drive)?);
    let parts: Vec<Report> = [own].into_iter().chain(motion).chain([values, interface]).collect();
    Ok(html::page_without_script(&resource.name, &parts))
}

/// The report on a drive as an FMU.
fn report(resource: &Resource, drive: &mut Described, page: &Page<'_>) -> Result<Report, Fault> {
    let (name, model) = (&resource.name, resource.model());
    let documentation = drive.documentation()?;
    let mut report = Report::new(name, format!("drive model {model}"));
    let about = format!("FMI 2.0 for Co-Simulation, written by {}.", super::TOOL);
    let lead = [page.description.to_owned(), documentation.summary, about];
    report.lines("", lead.into_iter().filter(|text| !text.is_empty()));
    if page.live {
        let link = "Move a slider: diagrams, figures and verdict follow";
        report.body.push(Block::File("Try it".to_owned(), link.to_owned(), super::LIVE.to_owned()));
    }
    let curves = drive.curves();
    if !curves.is_empty() {
        let titles: Vec<&str> = curves.iter().map(|curve| curve.title.as_str()).collect();
        figure(&mut report, picture::of_curves(name, model, &curves), &titles.join(", "));
    }
    if let Some(results) = page.results {
        experiment(&mut report, drive, results);
    }
    report.lines("Connect it", connections(drive)).lines("Signs and units", signs(drive.descriptions()));
    report.body.push(usage(name, drive));
    report.body.push(Block::Equations("Equations".to_owned(), documentation.equations));
    report.lines("Left out", documentation.left_out);
    let rows: Vec<_> = documentation.accuracy.into_iter().map(|(quantity, text)| vec![quantity, text]).collect();
    let mut accuracy = words("Solution and accuracy", &["Quantity", "Statement"], &rows);
    accuracy.below = solution(drive.input_derivative_order());
    report.table(accuracy).lines("Limits", documentation.limits);
    let rows = LOG_CATEGORIES.map(|(name, text)| vec![name.to_string_lossy().into_owned(), text.to_owned()]);
    report.table(words("Messages", &["Log category", "Content"], &rows));
    report.lines("Platforms", page.platforms.iter().map(|name| platform(name))).lines("Sources", documentation.sources);
    let [title, text, file] =
        ["Licence", "Licences of the library in this FMU", "licenses/license.txt"].map(str::to_owned);
    report.body.push(Block::File(title, text, file));
    Ok(report)
}

/// A table of words under these headings.
fn words(title: &str, heads: &[impl AsRef<str>], rows: &[Vec<String>]) -> Table {
    let mut table = Table::of(title, rows);
    for (i, head) in heads.iter().enumerate() {
        table = table.column("", head.as_ref(), ONE, move |row: &Vec<String>| &row[i]);
    }
    table.into()
}

fn figure(report: &mut Report, drawing: Drawing, label: &str) {
    report.drawing("", drawing, label, picture::SCALE);
}

/// The outputs over the default experiment.
fn experiment(report: &mut Report, drive: &AnyDrive, results: &Results) {
    let e = drive.experiment();
    let until = match results.whole {
        true => String::new(),
        false => format!("; the results end at {} s, since the rest fails or takes too long", short(results.end())),
    };
    let mut lines = vec![format!("{} s in steps of {} s{until}.", short(e.stop), short(e.step))];
    let folder = references::FOLDER;
    if !results.motion().is_empty() {
        let (motion, input) = (results.motion(), references::INPUT);
        lines.push(format!("The inputs move: {motion} ({folder}/{input} inside this FMU). {}", references::CONVENTION));
    }
    lines.push(format!(
        "All outputs are in {folder}/{} inside this FMU; `camdrive verify {}.fmu` compares them with another run.",
        references::RESULT,
        report.name
    ));
    report.lines("Default experiment", lines);
    if let Some((drawing, label)) = results.diagram() {
        figure(report, drawing, &label);
    }
}

/// The platform of a folder in `binaries/`, and the tests on it.
fn platform(name: &str) -> String {
    let runs_on = match name {
        "linux64" | "aarch64-linux" => {
            "Linux with GLIBC 2.17 or newer; a library built on the exporting computer, without packaging/build, may need \
             the GLIBC of that computer."
        }
        "win64" => "Windows 10 or newer. Tested with Wine; the last digits of sin and cos come from its C library.",
        "darwin64" | "aarch64-darwin" => "macOS. Built, not run.",
        _ => "a library chosen at the export.",
    };
    let tested = match name {
        "linux64" => " Tested.",
        "aarch64-linux" => " Tested in emulation.",
        _ => "",
    };
    format!("{name}: {runs_on}{tested}")
}

/// Advice on connections and steps.
fn connections(drive: &AnyDrive) -> Vec<String> {
    let of = |wanted: Causality| drive.descriptions().iter().filter(move |d| d.causality == wanted);
    let names = |wanted: Causality, last: &[&str]| -> Vec<&str> {
        let is = |d: &&Description| last.contains(&d.name.rsplit('.').next().unwrap_or_default());
        of(wanted).filter(is).map(|d| d.name.as_str()).collect()
    };
    let has = |name: &str| of(Causality::Output).any(|d| d.name == name);
    let code = |names: &[&str]| names.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ");
    let shaft = ["phi", "w", "a"];
    let (moved, loads) = (names(Causality::Input, &shaft), ["tau", "tau_rest", "J_load", "dJ_load"]);
    let mut lines = Vec::new();
    let step = text::time(drive.experiment().step);
    if of(Causality::Input).next().is_none() {
        lines.push("It has no inputs and runs by itself. Read any of its outputs.".to_owned());
        lines.push(format!("The communication step does not change the motion; steps of {step} show all of it."));
        return lines;
    }
    let mean = |tau: &&str| of(Causality::Output).find(|d| d.name == format!("{tau}_mean")).map(|d| d.name.as_str());
    let taus = names(Causality::Output, &["tau"]);
    let torques: Vec<&str> = taus.iter().map(|tau| mean(tau).unwrap_or(tau)).collect();
    let why = match torques == taus {
        true => "",
        false => " The torque without `_mean` has no impulses: the machine would not feel the impacts.",
    };
    match &moved[..] {
        [] => {}
        ["w"] => lines.push("Connect the speed of the machine to `w`.".to_owned()),
        _ => lines.push(format!("Connect `phi`, `w`, `a` of the machine to {}, all three of them.", code(&moved))),
    }
    if !moved.is_empty() && !torques.is_empty() {
        let sum = if torques.len() > 1 { "the sum of " } else { "" };
        lines.push(format!("Connect {sum}{} back to the load torque of the machine.{why}", code(&torques)));
        lines.push(format!("Through a gear {} and the torque each take its ratio.", code(&moved)));
        if has("tau_rest") {
            let instead = "Instead of `tau` connect `J_load`, `dJ_load`, `tau_rest` to a machine that has inputs of these names: \
                           steps are then stable for a load of any inertia.";
            lines.push(instead.to_owned());
        }
    }
    let taken = names(Causality::Input, &loads);
    if !taken.is_empty() {
        let motion: Vec<&str> = shaft.into_iter().filter(|name| has(name)).collect();
        lines.push(format!("Connect {} to the inputs of these names of each drive on the shaft.", code(&motion)));
        lines.push(format!(
            "Connect the torque of each drive to {}. If a drive has impacts, connect its `tau_mean`.",
            code(&taken)
        ));
    }
    let others = of(Causality::Input).filter(|d| !moved.contains(&&*d.name) && !taken.contains(&&*d.name));
    lines.extend(others.map(|d| format!("`{}` [{}]: {}.", d.name, unit(&d.kind), d.text.trim_end_matches('.'))));
    lines.push(format!(
        "Begin with a communication step of {step}. Halve it until the results no longer change: with inputs held over a step, \
         the error falls with the step. `camdrive check SYSTEM` computes the largest stable one."
    ));
    lines
}

fn signs(descriptions: &[Description]) -> Vec<String> {
    let mut sentences = vec![
        "All values are in coherent SI units, angles in rad. Angle, angular velocity and torque of a shaft are positive \
         in the same sense."
            .to_owned(),
    ];
    let has = |name: &str| descriptions.iter().any(|d| d.name == name);
    let torques = |causality: Causality, last: &str| -> Vec<&str> {
        let is = |d: &&Description| d.causality == causality && d.name.rsplit('.').next() == Some(last);
        descriptions.iter().filter(is).map(|d| d.name.as_str()).collect()
    };
    let [told, taken] = [Causality::Output, Causality::Input].map(|causality| torques(causality, "tau"));
    let are = |names: &[&str]| match names {
        [one] => format!("{one} is the torque"),
        _ => format!("{} are torques", names.join(", ")),
    };
    if has("tau_parametric") {
        sentences.push(match has("psi") {
            true => {
                "tau is the torque transmitted from the drive into the driven side: a positive tau loads the drive, and \
                 (tau + tau_parametric)·w is the power that flows into the driven side."
                    .to_owned()
            }
            false => "tau_parametric·w is the power that flows from the drive into the vibration.".to_owned(),
        });
    } else if !told.is_empty() {
        sentences.push(format!(
            "{} transmitted from the shaft into what it drives: positive values load the drive, and times w they are the \
             power that flows there.",
            are(&told)
        ));
    }
    if !taken.is_empty() {
        sentences.push(format!(
            "{} transmitted from the machine to its loads: positive values brake it, and times w they are the power that \
             leaves it.",
            are(&taken)
        ));
    }
    let rests = [Causality::Output, Causality::Input].map(|causality| torques(causality, "tau_rest")).concat();
    if let Some(rest) = rests.first() {
        let [whole, inertia, slope] = ["tau", "J_load", "dJ_load"].map(|name| rest.replace("tau_rest", name));
        let whole = if has(&whole) { format!("{whole} = ") } else { "The torque of a load is ".to_owned() };
        sentences.push(format!("{whole}{inertia}·a + ½ {slope}·w² + {rest}."));
    }
    sentences
}

/// A script that runs unchanged next to the FMU.
fn usage(name: &str, drive: &AnyDrive) -> Block {
    let e = drive.experiment();
    let (stop, step) = (digits(e.stop), digits(e.step));
    let descriptions = drive.descriptions();
    let names = |wanted: Causality| -> Vec<&str> {
        descriptions.iter().filter(|d| d.causality == wanted).map(|d| d.name.as_str()).collect()
    };
    let outputs: Vec<String> = names(Causality::Output).iter().take(4).map(|name| format!("'{name}'")).collect();
    let inputs = names(Causality::Input);
    let mut code = String::from("import fmpy\n");
    let mut argument = String::new();
    if !inputs.is_empty() {
        let columns: Vec<String> = inputs.iter().map(|name| format!("('{name}', float)")).collect();
        let rest: Vec<&str> = inputs.iter().map(|name| if *name == "w" { "10.0" } else { "0.0" }).collect();
        let end: Vec<String> = inputs
            .iter()
            .zip(&rest)
            .map(|(name, value)| if *name == "phi" { format!("10.0 * {stop}") } else { (*value).to_owned() })
            .collect();
        code += &format!(
            "import numpy\n\n\
             # The inputs at the first and the last instant; in between they are interpolated.\n\
             signals = numpy.array([(0.0, {}), ({}, {})],\n    dtype=[('time', float), {}])\n",
            rest.join(", "),
            stop,
            end.join(", "),
            columns.join(", ")
        );
        argument = ", input=signals".to_owned();
    }
    code += &format!(
        "\nresult = fmpy.simulate_fmu('{name}.fmu', stop_time={stop}, output_interval={step}{argument},\n    output=[{}])\n\
         print(result[-1])\n",
        outputs.join(", ")
    );
    let [title, sentence] = ["Use in Python", "With the package FMPy, in the folder of the FMU:"].map(str::to_owned);
    Block::Code(title, sentence, code)
}

/// Properties of the solution in all drives.
fn solution(input_derivatives: usize) -> Vec<String> {
    let mut lines = vec![
        "Communication steps may have any length and may vary. The state can be saved, restored and serialised. \
         A call takes at most 32 kB of the stack of its thread."
            .to_owned(),
        "At communication points output derivatives up to order 2 and directional derivatives are analytic."
            .to_owned(),
        "Before the start directional derivatives are extrapolated differences of the start values, also for parameters. \
         About ten digits are correct if the start values depend smoothly on the parameter."
            .to_owned(),
    ];
    if input_derivatives > 0 {
        lines.push(format!("Input derivatives up to order {input_derivatives} are used; higher orders are refused."));
    }
    lines
}

fn variables(drive: &mut AnyDrive) -> Result<Table, Fault> {
    let descriptions = drive.descriptions().to_vec();
    let row = |(reference, d): (usize, &Description)| {
        let start = match d.causality {
            Causality::Parameter | Causality::Input => value_with_unit(&d.kind, drive.get(reference)?),
            Causality::Output | Causality::Local => String::new(),
        };
        Ok(vec![d.name.clone(), kind_of(d), unit(&d.kind).to_owned(), start, range(&d.kind), d.text.clone()])
    };
    let rows: Result<Vec<Vec<String>>, Fault> = descriptions.iter().enumerate().map(row).collect();
    Ok(words("Variables of the FMU", &["Name", "Kind", "Unit", "Start", "Range", "Description"], &rows?))
}

/// "parameter", "tunable parameter", "input" …, with a mark for a state.
pub fn kind_of(d: &Description) -> String {
    let tunable = if d.variability == Variability::Tunable { "tunable " } else { "" };
    let state = if d.state { ", state" } else { "" };
    format!("{tunable}{}{state}", causality(d.causality))
}

/// The value in SI and, if engineers use another unit, also in that unit.
fn value_with_unit(kind: &Kind, value: f64) -> String {
    match kind {
        Kind::Real { quantity, .. } => match quantity.display {
            Some((unit, factor)) if value != 0.0 => format!("{} ({} {unit})", short(value), short(factor * value)),
            _ => short(value),
        },
        Kind::Integer { .. } => short(value),
        Kind::Boolean => (value != 0.0).to_string(),
        // Enumerations count from 1.
        Kind::Enumeration(e) => e.items.get(value as usize - 1).map_or(String::new(), |(name, _)| (*name).to_owned()),
    }
}

fn range(kind: &Kind) -> String {
    match kind {
        Kind::Real { min, max, .. } => match (min.is_finite(), max.is_finite()) {
            (false, false) => String::new(),
            (true, false) => format!("≥ {}", short(*min)),
            (false, true) => format!("≤ {}", short(*max)),
            (true, true) => format!("{} to {}", short(*min), short(*max)),
        },
        Kind::Integer { min: i32::MIN, max: i32::MAX } | Kind::Boolean => String::new(),
        Kind::Integer { min, max: i32::MAX } => format!("≥ {min}"),
        Kind::Integer { min, max } => format!("{min} to {max}").replace('-', "−"),
        Kind::Enumeration(e) => {
            let items: Vec<String> = e.items.iter().enumerate().map(|(i, (n, _))| format!("{} {n}", i + 1)).collect();
            items.join(", ")
        }
    }
}

/// A time with its significant digits, in a form that Python reads.
fn digits(seconds: f64) -> String {
    let rounded: f64 = format!("{seconds:.8e}").parse().unwrap_or(seconds);
    rounded.to_string()
}

/// Six significant digits, without needless zeros.
fn short(value: f64) -> String {
    text::digits(value, 6, -3).replace('-', "−")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::export::test_drive::{lag, resource};
    use quick_xml::events::Event;

    fn page() -> String {
        let results = Results::of(&mut lag()).unwrap();
        let page = Page { description: "a < b & c", platforms: &["linux64"], results: Some(&results), live: true };
        html(&resource("Lag"), &mut lag(), &page).unwrap()
    }

    #[test]
    fn the_page_is_well_formed() {
        let page = page();
        let mut reader = quick_xml::Reader::from_str(&page);
        let mut open = Vec::new();
        loop {
            match reader.read_event().unwrap() {
                Event::Start(tag) => open.push(tag.name().as_ref().to_owned()),
                Event::End(tag) => assert_eq!(open.pop().unwrap(), tag.name().as_ref()),
                Event::Eof => break,
                _ => {}
            }
        }
        assert!(open.is_empty());
    }

    #[test]
    fn the_page_says_it_all_and_asks_nobody() {
        let page = page();
        for part in ["a &lt; b &amp; c", "Demand &lt;u&gt;", "<svg", "Any book on control", "simulate_fmu"] {
            assert!(page.contains(part), "{part}");
        }
        assert_eq!(page.matches("<i>T</i> <i>ẋ</i> = <i>u</i> − <i>x</i>").count(), 1);
        assert!(page.contains("Default experiment") && page.contains("linux64: Linux") && !page.contains("macOS"));
        for outside in ["src=", "@import", "url(", "<script"] {
            assert!(!page.contains(outside), "{outside}");
        }
    }

    #[test]
    fn numbers_are_short() {
        assert_eq!(short(188.49555921538757), "188.496");
        assert_eq!(short(-1e-7), "−1e−7");
        assert_eq!(short(0.1 + 0.2), "0.3");
        assert_eq!(
            value_with_unit(&camdrive::drives::variable::real(&camdrive::drives::unit::LENGTH), 0.00094),
            "9.4e−4 (0.94 mm)"
        );
    }
}
