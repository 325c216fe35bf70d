//! Study files of `camdrive study`: TOML → variants, window and measures. The keys are described below.
//!
#![doc = include_str!("../../../docs/study.md")]

use crate::document::keys::VARY;
use crate::document::source::is_fmu;
use crate::document::{self, Diagnostics, Document, Kind, Node, Section, Value, all, input, meant, units};
use crate::scene::{self, Resolved, variable};
use crate::system::{self, coupled::Coupled};
use camdrive::drives::unit;
use camdrive::drives::variable::{Causality, Kind as Type};
use camdrive::drives::{Description, Fault, Number};
use camdrive_design::overview;
use camdrive_design::study::coupled;
use camdrive_design::study::measure::{FORMS, Measure};
use camdrive_design::study::plan::{MOST_ROWS, Samples, Sampling, Spread, grid, places};
use camdrive_design::study::run::{Span, Window};
use camdrive_design::study::single::Runner;
use camdrive_design::text::{self, counted, sentence};
use std::fmt::Display;
use std::path::{Path, PathBuf};

/// A study.
pub struct Study {
    /// The text of the study and of its scene or system.
    pub texts: [String; 2],
    /// The file of the scene, the system or the FMU.
    pub place: PathBuf,
    /// The scene or the system of the variants, unchanged.
    pub subject: Subject,
    /// Scene or system, without a name, and the scenes of parts after it by their names: the files with keys that may vary.
    documents: Vec<(String, Document)>,
    /// Communication step of systems and FMUs, if the study sets it (s).
    pub step: Option<f64>,
    /// The quantities that vary, in the order of the columns.
    pub quantities: Vec<Quantity>,
    /// Lists of values, each for some quantities, in the order of their product.
    axes: Vec<Axis>,
    /// The sampled quantities, after the ones with lists.
    samples: Option<Samples>,
    /// The time window of the measurement.
    pub window: Window,
    /// The measures.
    pub measures: Vec<Measure>,
    /// Unit and meaning of each measure.
    pub measured: Vec<[String; 2]>,
    /// The tables of the study and its scene.
    pub tables: Vec<PathBuf>,
    /// Notes on numbers without a unit, and on implausible values.
    pub notes: Vec<String>,
}

/// The scene or the system of a study.
pub enum Subject {
    /// The drive of a scene.
    Scene(Box<Resolved>),
    /// A system of FMUs, or one of them.
    Coupled(Box<Coupled>),
}

/// A quantity that varies.
#[derive(Clone, Debug, PartialEq)]
pub struct Quantity {
    /// A variable of the FMU, or a key of the scene.
    pub name: String,
    /// The unit of its values in the store; empty without one.
    pub unit: String,
    /// Its description.
    pub meaning: String,
    /// The index among the variables; None for a key.
    pub variable: Option<usize>,
    /// True if some of its values are not numbers.
    pub is_text: bool,
}

/// A value of a quantity.
#[derive(Clone, Debug, PartialEq)]
pub enum Cell {
    /// In the unit of the quantity.
    Number(f64),
    /// A text, or true or false.
    Text(String),
}

/// The lists of an axis, each with a value for each of its quantities.
#[derive(Clone, Debug, PartialEq)]
struct Axis {
    rows: Vec<Vec<Cell>>,
    width: usize,
}

/// Reads and validates a study file with its scene.
pub fn read(path: &Path) -> Result<Study, Diagnostics> {
    let (file, document) = input::document(path, Kind::Study)?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let mut found = None;
    let study = input::read(&file, &document, Kind::Study, |root| {
        let scene = root.required_text("scene", "a scene file", "scene.toml").map(|name| folder.join(name));
        // The reader of the scene or the system reports its faults.
        match scene.as_ref().map(|scene| (Subject::read(scene), scene)) {
            Some((Err(faults), _)) => {
                found = Some(faults);
                None
            }
            Some((Ok(subject), scene)) => study(root, folder, scene, subject),
            None => study_without_scene(root),
        }
    });
    found.map_or(study, Err)
}

/// Reads the parts that need no scene, so that all faults are reported.
fn study_without_scene(root: &Section<'_>) -> Option<Study> {
    window(root);
    measures(root);
    None
}

impl Subject {
    /// Reads a file: a scene, a system, an SSP or an FMU.
    fn read(path: &Path) -> Result<Self, Diagnostics> {
        let coupled = if is_fmu(path) {
            Coupled::of_fmu(path)
        } else if input::is_system(path) {
            Coupled::new(system::read(path)?, None)
        } else {
            return scene::read(path).map(|scene| Subject::Scene(Box::new(scene)));
        };
        coupled.map(|coupled| Subject::Coupled(Box::new(coupled))).map_err(|fault| of_file(path, fault))
    }

    /// Its variables.
    fn variables(&self) -> Result<Vec<Description>, Fault> {
        Ok(match self {
            Subject::Scene(scene) => scene.resource().build()?.descriptions().to_vec(),
            Subject::Coupled(coupled) => coupled.variables.clone(),
        })
    }

    /// The start value of a variable (SI), if it is known.
    fn start(&self, name: &str) -> Option<f64> {
        match self {
            Subject::Scene(scene) => {
                let drive = scene.resource().build().ok()?;
                let place = drive.descriptions().iter().position(|d| d.name == name)?;
                drive.plan().instance().get(place).ok()
            }
            Subject::Coupled(coupled) => coupled.start(coupled.variables.iter().position(|d| d.name == name)?),
        }
    }

    /// The name of the scene, the system or the FMU.
    pub fn name(&self) -> &str {
        match self {
            Subject::Scene(scene) => &scene.name,
            Subject::Coupled(coupled) => &coupled.system.name,
        }
    }
}

/// The fault of a file as a whole.
fn of_file(path: &Path, fault: Fault) -> Diagnostics {
    let (place, message) = (format!("{}: ", path.display()), fault.sentence());
    let message = message.strip_prefix(&place).unwrap_or(&message).to_owned();
    Diagnostics::of_file(path, fault.with_message(message))
}

/// The communication step, if the study sets it.
fn step(root: &Section<'_>, subject: &Subject) -> Option<Option<f64>> {
    let step = if root.has("step") { root.real("step").map(Some) } else { Some(None) };
    let refused = |key, said: String| root.fault_of(key, said);
    match subject {
        Subject::Scene(_) if root.has("step") => {
            let fault = refused("step", " has no meaning here: the drive of a scene finds its own points".to_owned());
            root.refuse(fault.hint("remove it; `accuracy` sets the error of outputs between them"))
        }
        Subject::Scene(_) => step,
        Subject::Coupled(_) if root.has("accuracy") => {
            let fault = refused("accuracy", " has no meaning here: outputs are known once a step".to_owned());
            root.refuse(fault.hint("remove it; `step` sets their distance"))
        }
        Subject::Coupled(coupled) => match (step?, coupled.system.step) {
            (None, own) if own.is_nan() => {
                let fault = refused("step", " is missing: the FMU has no communication step".to_owned());
                root.refuse(fault.hint("add for example step = \"1 ms\""))
            }
            (Some(step), _) if coupled.system.repeats(&[], step).is_err() => {
                let message = coupled.system.repeats(&[], step).err().unwrap_or_default();
                root.refuse(refused("step", format!(": {message}")))
            }
            (step, _) => Some(step),
        },
    }
}

/// The files with keys that may vary; an archive has no keys.
fn documents(place: &Path, subject: &Subject) -> Vec<(String, Document)> {
    let coupled = match subject {
        Subject::Scene(scene) => return vec![(String::new(), scene.document.clone())],
        Subject::Coupled(coupled) => coupled,
    };
    let read = |name: &str, path: &Path| Some((name.to_owned(), input::document(path, Kind::Scene).ok()?.1));
    let of_part = |part: &system::Part| match &part.content {
        // As in its file, without the torques of this system.
        system::Content::Scene(scene) => read(&part.name, scene.files.last()?),
        system::Content::Fmu(_) => None,
    };
    read("", place).into_iter().chain(coupled.system.parts.iter().filter_map(of_part)).collect()
}

/// The file with a key, and the path in this file.
fn located<'a>(documents: &[(String, Document)], name: &'a str) -> Option<(usize, &'a str)> {
    let inside = |(i, (part, document)): (usize, &(String, Document))| {
        let path = if part.is_empty() { name } else { name.strip_prefix(part)?.strip_prefix('.')? };
        (path.contains('.') && document.place(path).is_some()).then_some((i, path))
    };
    documents.iter().enumerate().find_map(inside)
}

fn study(root: &Section<'_>, folder: &Path, place: &Path, subject: Subject) -> Option<Study> {
    let variables = subject.variables().map_err(|fault| root.fault_of("scene", format!(": {fault}")));
    let variables = root.taken(variables)?;
    let window = window(root);
    let step = step(root, &subject);
    let measures = measures(root);
    let documents = documents(place, &subject);
    let mut reader =
        Variation { subject: &subject, variables: &variables, documents: &documents, folder, tables: Vec::new() };
    let read = root.each("vary", |section| {
        let varied = reader.varied(section);
        section.finish();
        varied
    });
    let runs = if root.has("runs") { root.count("runs").map(Some) } else { Some(None) };
    let design = root.choice("design", &[("latin_hypercube", Sampling::LatinHypercube), ("random", Sampling::Random)]);
    let seed = root.count("seed");
    root.finish();
    let (window, step, measures, read, runs, design, seed) = (window?, step?, measures?, read?, runs?, design?, seed?);
    if let (Subject::Coupled(coupled), Span::Time(time)) = (&subject, &window.over)
        && let Some(step) = Some(step.unwrap_or(coupled.system.step)).filter(|step| step > time)
    {
        let fault = root.fault_of("step", format!(": {} s is longer than the window", Number(step)));
        return root.refuse(fault.admissible(format!("at most {} s", Number(*time))));
    }
    if read.is_empty() {
        return root
            .refuse(root.fault_of("vary", " is empty: nothing varies").hint("add [[vary]] with `name` and `values`"));
    }
    let Space { quantities, axes, spreads } = space(root, read.into_iter().flatten(), runs)?;
    let samples = runs.map(|runs| Samples::new(design, runs as u32, seed as u64, spreads));
    let mut tables = reader.tables;
    let files = match &subject {
        Subject::Scene(scene) => &scene.files,
        Subject::Coupled(coupled) => &coupled.system.files,
    };
    // Only the hash identifies a binary file.
    tables.extend(files.iter().filter(|file| *file != place || documents.is_empty()).cloned());
    let text = documents.first().map_or_else(String::new, |(_, document)| document.text.clone());
    let (place, texts) = (place.to_owned(), [root.faults.document.text.clone(), text]);
    let mut study = Study {
        texts,
        place,
        subject,
        documents,
        step,
        quantities,
        axes,
        samples,
        window,
        measures,
        measured: Vec::new(),
        tables,
        notes: root.faults.notes(),
    };
    let first = first_variant(root, &study)?;
    let built = first.as_ref().unwrap_or(&study.subject);
    let all = built.variables().unwrap_or(variables);
    check_measures(root, &study, built, &all)?;
    let about = |measure: &Measure| {
        let output = all.iter().find(|d| d.name == measure.output);
        let unit = match output.map(|d| &d.kind) {
            Some(Type::Real { quantity, .. }) => quantity.unit,
            _ => "1",
        };
        [unit.to_owned(), measure.meaning(output.map_or("", |d| &d.text))]
    };
    study.measured = study.measures.iter().map(about).collect();
    let implausible = study.implausible(&all);
    study.notes.extend(implausible);
    Some(study)
}

/// The space of the variants: the quantities, first the ones with lists, and the spreads of the others.
struct Space {
    quantities: Vec<Quantity>,
    axes: Vec<Axis>,
    spreads: Vec<Spread>,
}

/// The space of all [[vary]], with this many runs of samples.
fn space(root: &Section<'_>, read: impl Iterator<Item = Varied>, runs: Option<usize>) -> Option<Space> {
    let (mut quantities, mut axes, mut sampled, mut spreads) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    for varied in read {
        match varied {
            Varied::Listed(list, rows) => {
                axes.push(Axis { rows, width: list.len() });
                quantities.extend(list);
            }
            Varied::Sampled(quantity, spread) => {
                sampled.push(quantity);
                spreads.push(spread);
            }
        }
    }
    quantities.extend(sampled);
    for (i, quantity) in quantities.iter().enumerate() {
        if quantities[..i].iter().any(|other| other.name == quantity.name) {
            return root.refuse(root.fault_of("vary", format!(": `{}` varies twice", quantity.name)));
        }
    }
    if runs.is_none() != spreads.is_empty() {
        let (message, hint) = if runs.is_none() {
            let name = &quantities[quantities.len() - spreads.len()].name;
            (format!(" is missing: `{name}` is sampled"), "add runs = 1000, or give [[vary]] a `count`")
        } else {
            (" has no meaning here: no quantity is sampled".to_owned(), "remove it, or leave `count` out of a [[vary]]")
        };
        return root.refuse(root.fault_of("runs", message).hint(hint));
    }
    let lengths = axes.iter().map(|axis| axis.rows.len() as f64).chain(runs.map(|runs| runs as f64));
    let total: f64 = lengths.product();
    if total > MOST_ROWS as f64 {
        let fault = root.fault_of("vary", format!(": {total:.3e} runs are too many"));
        return root.refuse(
            fault.admissible(format!("at most {MOST_ROWS}")).hint("take fewer values, or sample: runs = 1000"),
        );
    }
    Some(Space { quantities, axes, spreads })
}

/// The first run of a study whose keys vary; the inner None for a study without such keys, or if the scene does not admit the run.
fn first_variant(root: &Section<'_>, study: &Study) -> Option<Option<Subject>> {
    let first = study.is_keyed().then(|| study.variant(&study.cells(0)));
    // A key that no scene has is a fault of the study; a value that this scene does not admit is a fault of the run.
    if let Some(Err(Diagnostics(faults))) = &first {
        let is_varied =
            |key: &String| study.quantities.iter().any(|of| of.name == *key || of.name.ends_with(&format!(".{key}")));
        let unknown = faults.iter().find(|fault| fault.message.contains("is not known"));
        if let Some(fault) = unknown.filter(|fault| fault.key.as_ref().is_some_and(is_varied)) {
            return root.refuse(root.fault_of("vary", format!(": {}", fault.message)).remedy(fault.hint.clone()));
        }
    }
    let first = first.and_then(Result::ok);
    // All quantities with several values differ between the first and the last run.
    if let Some(first) = &first
        && let Ok(last) = study.variant(&study.cells(study.rows() - 1))
    {
        let twice = |quantity: &&Quantity| {
            quantity.variable.is_some() && first.start(&quantity.name) != last.start(&quantity.name)
        };
        if let Some(quantity) = study.quantities.iter().find(twice) {
            let fault =
                root.fault_of("vary", format!(": a key that varies sets the variable `{}`, too", quantity.name));
            return root.refuse(fault.hint("vary one of them"));
        }
    }
    Some(first)
}

/// Checks that the measures exist for the first run, which has these variables.
fn check_measures(root: &Section<'_>, study: &Study, built: &Subject, all: &[Description]) -> Option<()> {
    let checked = match built {
        Subject::Scene(scene) => {
            scene.resource().build().and_then(|drive| Runner::new(&drive, &study.window, &study.measures).map(|_| ()))
        }
        Subject::Coupled(coupled) => study.runner(coupled).map(|_| ()),
    };
    if let Err(fault) = checked {
        let computed = all.iter().filter(|d| matches!(d.causality, Causality::Output | Causality::Local));
        let known: Vec<&str> = computed.map(|d| d.name.as_str()).collect();
        let absent = study.measures.iter().find(|measure| !known.contains(&&*measure.output));
        let lists = || {
            let (command, does) = match built {
                Subject::Scene(_) => ("describe", "lists"),
                Subject::Coupled(_) => ("run", "writes"),
            };
            format!("`camdrive {command} {}` {does} the outputs", study.place.display())
        };
        let hint = absent.map(|measure| meant(&measure.output, &known).unwrap_or_else(lists));
        let wrong = root.fault_of("measures", format!(": {}", fault.sentence()));
        return root.refuse(wrong.remedy(hint.or(fault.0.hint)));
    }
    Some(())
}

/// The window.
fn window(root: &Section<'_>) -> Option<Window> {
    let once = root.either("time", "turns");
    if !root.has("time") && !root.has("turns") {
        let fault = root.fault_of("time", " and `turns` are missing");
        return root.refuse(fault.hint("add turns = 10, or time = \"0.5 s\""));
    }
    let by_turns = root.has("turns");
    let over = if by_turns { root.real("turns").map(Span::Turns) } else { root.real("time").map(Span::Time) };
    let text = root.node("settle").and_then(|node| if let Value::Text(text) = node.value { Some(text) } else { None });
    if by_turns && text.is_some_and(|text| units::split(text).1.is_empty()) {
        let fault = root.fault_of("settle", ": a text without unit may be turns or seconds");
        return root.refuse(fault.hint("write 3 for turns, or \"3 s\""));
    }
    let is_text = text.is_some();
    let settle = if by_turns && !is_text {
        root.of(&unit::NUMBER, 0);
        root.real("settle").map(Span::Turns)
    } else {
        root.of(&unit::TIME, 0);
        root.real("settle").map(Span::Time)
    };
    let accuracy = root.real("accuracy");
    let (over, settle, accuracy) = (over?, settle?, accuracy?);
    once.then_some(Window { settle, over, accuracy })
}

/// The measures.
fn measures(root: &Section<'_>) -> Option<Vec<Measure>> {
    let texts = root.texts("measures")?;
    if texts.is_empty() {
        let fault =
            root.fault_of("measures", if root.has("measures") { ": nothing is measured" } else { " is missing" });
        return root.refuse(fault.admissible(FORMS).hint("add for example measures = [\"max |q|\"]"));
    }
    let read = |(text, node): (&str, Node<'_>)| {
        let measure = Measure::parse(text);
        root.taken(measure.map_err(|message| root.of_node(&node, format!(": {message}")).admissible(FORMS)))
    };
    let all = all(texts.into_iter().map(read))?;
    for (i, measure) in all.iter().enumerate() {
        // Each column has its own name.
        if all[..i].iter().any(|other| other.to_string() == measure.to_string()) {
            return root.refuse(root.fault_of("measures", format!(": `{measure}` occurs twice")));
        }
    }
    Some(all)
}

/// The content of one `[[vary]]`.
enum Varied {
    Listed(Vec<Quantity>, Vec<Vec<Cell>>),
    Sampled(Quantity, Spread),
}

/// Reads the varied quantities.
struct Variation<'a> {
    subject: &'a Subject,
    variables: &'a [Description],
    documents: &'a [(String, Document)],
    folder: &'a Path,
    tables: Vec<PathBuf>,
}

impl Variation<'_> {
    fn varied(&mut self, section: &Section<'_>) -> Option<Vec<Varied>> {
        // The keys of another choice are known all the same.
        for key in VARY.all() {
            section.has(key.key);
        }
        let given: Vec<&'static str> = ["name", "names", "file"].into_iter().filter(|key| section.has(key)).collect();
        let [given] = given[..] else {
            let fault =
                section.fault(if given.is_empty() { " does not say what varies" } else { " says twice what varies" });
            return section.refuse(fault.hint("give one of `name`, `names` or `file`"));
        };
        let unused = |keys: &[&'static str]| section.forbid(keys, &format!("`{given}` is given"), "`name`");
        match given {
            "file" => {
                unused(&["values", "from", "to", "count", "scale", "mean", "deviation"]);
                self.file(section).map(|varied| vec![varied])
            }
            "names" => {
                let names: Vec<&str> = section.texts("names")?.into_iter().map(|(name, _)| name).collect();
                if names.is_empty() {
                    return section.refuse(section.fault_of("names", ": the list is empty"));
                }
                if !section.has("values") {
                    unused(&["count"]);
                    return all(names.iter().map(|name| self.single(section, name)));
                }
                unused(&["from", "to", "count", "scale", "mean", "deviation"]);
                let rows = section.items("values", "a list of lists")?;
                let row = |node: Node<'_>| match node.items(1) {
                    Some(list) if list.len() == names.len() => {
                        list.iter().map(|node| Placed::of(section, node)).collect()
                    }
                    _ => {
                        let message = format!(
                            ": a list of {} is expected, one for each of `names`",
                            counted(names.len(), "value")
                        );
                        section.refuse(section.faults.at(node.span, message).of(node.path))
                    }
                };
                self.listed(section, &names, all(rows.into_iter().map(row))?).map(|varied| vec![varied])
            }
            _ => self.single(section, section.text("name")??).map(|varied| vec![varied]),
        }
    }

    /// One quantity.
    fn single(&self, section: &Section<'_>, name: &str) -> Option<Varied> {
        let [values, ends, normal] = [
            section.has("values"),
            section.has("from") || section.has("to"),
            section.has("mean") || section.has("deviation"),
        ];
        match (values, ends, normal) {
            (true, false, false) => {
                section.forbid(&["count", "scale"], "`values` lists them", "`from` and `to`");
                let rows = match section.node("values") {
                    Some(node) if !matches!(node.value, Value::Array(_)) => vec![node],
                    _ => section.items("values", "a list of values")?,
                };
                let row = |node: &Node<'_>| Placed::of(section, node).map(|value| vec![value]);
                self.listed(section, &[name], all(rows.iter().map(row))?)
            }
            (false, true, false) => {
                let [from, to] = ["from", "to"].map(|key| self.required(section, key));
                let logarithmic = section.choice("scale", &[("linear", false), ("log", true)])?;
                let (from, to) = (from?, to?);
                let quantity = self.quantity(section, name, &[&from, &to])?;
                let ends = [self.number(section, &quantity, &from)?, self.number(section, &quantity, &to)?];
                if logarithmic && !ends.iter().all(|end| *end > 0.0) {
                    return section.refuse(section.fault_of("scale", ": `log` needs values above 0"));
                }
                if !section.has("count") {
                    if !(ends[0] < ends[1]) {
                        return section.refuse(section.fault_of("to", ": it must be above `from`"));
                    }
                    let spread = if logarithmic { Spread::Logarithmic(ends) } else { Spread::Uniform(ends) };
                    return Some(Varied::Sampled(quantity, spread));
                }
                let rows = grid(ends, section.count("count")?, logarithmic);
                Some(Varied::Listed(vec![quantity], rows.into_iter().map(|value| vec![Cell::Number(value)]).collect()))
            }
            (false, false, true) => {
                section.forbid(&["count", "scale"], "a normal distribution is sampled", "`from` and `to`");
                let deviation = self.required(section, "deviation");
                let mean =
                    if section.has("mean") { self.required(section, "mean") } else { self.present(section, name) };
                let (deviation, mean) = (deviation?, mean?);
                let quantity = self.quantity(section, name, &[&mean, &deviation])?;
                let mean = self.number(section, &quantity, &mean)?;
                // It is a difference of values, so their range does not apply.
                let text = &deviation.text;
                let value = match quantity.variable {
                    Some(reference) => {
                        // Also for units with an offset.
                        let zero = self.value(reference, &format!("0 {}", deviation.unit()));
                        self.value(reference, text).and_then(|value| Ok(value - zero?)).ok()
                    }
                    None => deviation.number(),
                };
                match value.filter(|value| *value > 0.0) {
                    Some(deviation) => Some(Varied::Sampled(quantity, Spread::Normal { mean, deviation })),
                    None => {
                        let fault = section.fault_of("deviation", format!(": \"{text}\" is no deviation of `{name}`"));
                        section.refuse(fault.admissible(format!("above 0 {}", quantity.unit)))
                    }
                }
            }
            _ => {
                let says = if values || ends || normal { "says twice" } else { "does not say" };
                let fault = section.fault(format!(" {says} how `{name}` varies"));
                section.refuse(fault.hint("give `values`, or `from` and `to`, or `mean` and `deviation`"))
            }
        }
    }

    /// A required value.
    fn required(&self, section: &Section<'_>, key: &'static str) -> Option<Placed> {
        match section.node(key) {
            Some(node) => Placed::of(section, &node),
            None => section.refuse(section.fault_of(key, " is missing")),
        }
    }

    /// The value of a variable in the scene.
    fn present(&self, section: &Section<'_>, name: &str) -> Option<Placed> {
        match self.subject.start(name) {
            Some(value) => Some(Placed {
                text: format!("{value} {}", self.si_unit(name)).trim_end().to_owned(),
                span: section.span.clone(),
                path: section.path.clone(),
            }),
            None => {
                let fault = section.fault_of("mean", " is missing");
                section.refuse(fault.hint(
                    "it may be left out only for a variable of the FMU, whose value in the scene is then the mean",
                ))
            }
        }
    }

    /// The SI unit of a variable.
    fn si_unit(&self, name: &str) -> String {
        let kind = self.variables.iter().find(|d| d.name == name).map(|d| &d.kind);
        if let Some(Type::Real { quantity, .. }) = kind { quantity.unit.to_owned() } else { String::new() }
    }

    /// Lists of values of these quantities.
    fn listed(&self, section: &Section<'_>, names: &[&str], rows: Vec<Vec<Placed>>) -> Option<Varied> {
        if rows.is_empty() || names.is_empty() {
            return section.refuse(section.fault(" has no values, so there would be no run"));
        }
        let column = |i: usize| rows.iter().map(|row| &row[i]).collect::<Vec<_>>();
        let quantities = all(names.iter().enumerate().map(|(i, name)| self.quantity(section, name, &column(i))))?;
        let cell = |(value, quantity)| self.cell(section, quantity, value);
        let rows = all(rows.iter().map(|row| all(row.iter().zip(&quantities).map(cell))))?;
        Some(Varied::Listed(quantities, rows))
    }

    /// The rows of a CSV file.
    fn file(&mut self, section: &Section<'_>) -> Option<Varied> {
        let path = self.folder.join(section.text("file")??);
        let refused = |why: &dyn Display| section.fault_of("file", format!(": {}: {why}", path.display()));
        let bytes = section.taken(input::bytes(&path).map_err(|error| refused(&error)))?;
        if let Some(what) = input::foreign(&bytes) {
            return section.refuse(refused(&format!("this is {what}")));
        }
        self.tables.push(path.clone());
        let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).comment(Some(b'#')).from_reader(&bytes[..]);
        let head = section.taken(reader.headers().map_err(|error| refused(&error)))?.clone();
        let split = |heading: &str| match heading.strip_suffix(']').and_then(|rest| rest.rsplit_once(" [")) {
            Some((name, unit)) => (name.trim().to_owned(), unit.to_owned()),
            None => (heading.to_owned(), String::new()),
        };
        let (names, units): (Vec<String>, Vec<String>) = head.iter().map(split).unzip();
        let mut rows = Vec::new();
        for record in reader.records() {
            let record = section.taken(record.map_err(|error| refused(&error)))?;
            let line = record.position().map_or(0, |position| position.line());
            let cell = |(i, text): (usize, &str)| {
                let text = if units[i].is_empty() { text.to_owned() } else { format!("{text} {}", units[i]) };
                let path = format!("{}, line {line}, {}", path.display(), names[i]);
                Placed { text: normal(&text), span: section.span.clone(), path }
            };
            rows.push(record.iter().enumerate().map(cell).collect());
        }
        self.listed(section, &names.iter().map(String::as_str).collect::<Vec<_>>(), rows)
    }

    /// The quantity with this name and these values.
    fn quantity(&self, section: &Section<'_>, name: &str, values: &[&Placed]) -> Option<Quantity> {
        let all = self.variables;
        let name = name.to_owned();
        // Keys of a scene have variables, too.
        if let Some(d) = all.iter().find(|d| d.name == name || d.key == name) {
            in_other_units(section, &name, d, values);
        }
        if let Some(reference) = all.iter().position(|d| d.name == name) {
            let d = &all[reference];
            let fixed = match self.subject {
                Subject::Coupled(coupled) => coupled.fixed(reference),
                _ if matches!(d.causality, Causality::Parameter | Causality::Input) => None,
                _ => Some(Fault::new("it is computed")),
            };
            if let Some(why) = fixed {
                let fault = section.fault(format!(": `{name}` cannot vary: {}", why.sentence()));
                return section.refuse(fault.remedy(why.0.hint));
            }
            let (unit, items) = match &d.kind {
                Type::Real { quantity, .. } => (quantity.unit, String::new()),
                Type::Enumeration(e) => {
                    let items = e.items.iter().enumerate().map(|(i, (item, _))| format!("{} {item}", i + 1));
                    ("", format!(": {}", items.collect::<Vec<_>>().join(", ")))
                }
                _ => ("", String::new()),
            };
            let meaning = format!("{}{items}", d.text);
            return Some(Quantity { name, unit: unit.to_owned(), meaning, variable: Some(reference), is_text: false });
        }
        if [".file", ".scene", ".fmu"].iter().any(|ending| name.ends_with(ending)) {
            let fault = section.fault(format!(": `{name}` cannot vary: a study has the files of its scene"));
            return section.refuse(fault.hint("make a scene and a study for each file"));
        }
        if located(self.documents, &name).is_none() {
            let known = all.iter().filter(|d| matches!(d.causality, Causality::Parameter | Causality::Input));
            let known: Vec<&str> = known.map(|d| d.name.as_str()).collect();
            let fault = section.fault(match self.subject {
                Subject::Scene(_) => format!(": the drive has no variable and the scene no place for a key `{name}`"),
                Subject::Coupled(_) => format!(": no part has a variable, and no scene a place for a key `{name}`"),
            });
            let lists = || "`camdrive describe SCENE` lists the variables, `camdrive help scene` the keys".to_owned();
            return section.refuse(fault.hint(meant(&name, &known).unwrap_or_else(lists)));
        }
        let is_text = values.iter().all(|value| value.number().is_none());
        if let Some(text) = values.iter().find(|value| !is_text && value.number().is_none()) {
            let message = format!(": \"{}\" is no number, but other values of `{name}` are", text.text);
            let fault = section.faults.at(text.span.clone(), message);
            return section.refuse(fault.of(&text.path).hint("a column of the store has numbers or texts"));
        }
        let units: Vec<&str> = values.iter().map(|value| value.unit()).collect();
        if let Some(at) = (1..units.len()).find(|i| !is_text && units[*i] != units[0]) {
            let fault = section
                .faults
                .at(values[at].span.clone(), format!(": it is not in the unit of the first value, \"{}\"", units[0]));
            return section.refuse(fault.of(&values[at].path).hint("write all values of a key in one unit"));
        }
        let unit = if is_text { "" } else { units.first().copied().unwrap_or_default() };
        Some(Quantity { name, unit: unit.to_owned(), meaning: "Key of the scene".to_owned(), variable: None, is_text })
    }

    /// A value of a quantity.
    fn cell(&self, section: &Section<'_>, quantity: &Quantity, placed: &Placed) -> Option<Cell> {
        let Some(reference) = quantity.variable else {
            return Some(match placed.number() {
                Some(number) if !quantity.is_text => Cell::Number(number),
                _ => Cell::Text(placed.text.clone()),
            });
        };
        // A value outside the range of the variable is a refused run.
        let value = self.value(reference, &placed.text).map_err(|fault| {
            let told = section.faults.at(placed.span.clone(), format!(": {}", fault.sentence()));
            told.of(&placed.path).remedy(fault.0.hint)
        });
        section.taken(value).map(Cell::Number)
    }

    /// The value of a variable from a text.
    fn value(&self, reference: usize, text: &str) -> Result<f64, Fault> {
        match self.subject {
            Subject::Scene(_) => variable::parsed(&self.variables[reference], text),
            Subject::Coupled(coupled) => coupled.value(reference, text),
        }
    }

    /// A numeric value.
    fn number(&self, section: &Section<'_>, quantity: &Quantity, placed: &Placed) -> Option<f64> {
        let kind = quantity.variable.map(|reference| &self.variables[reference].kind);
        if kind.is_some_and(|kind| !matches!(kind, Type::Real { .. })) {
            let fault = section.fault(format!(": `{}` is no real number", quantity.name));
            return section.refuse(fault.hint("list its `values`"));
        }
        match self.cell(section, quantity, placed)? {
            Cell::Number(number) => Some(number),
            Cell::Text(text) => {
                let fault = section.faults.at(placed.span.clone(), format!(": \"{text}\" is no number"));
                section.refuse(fault.of(&placed.path))
            }
        }
    }
}

/// Notes numbers without a unit in the unit that people use: 900 rad/s, meant as rpm.
fn in_other_units(section: &Section<'_>, name: &str, of: &Description, values: &[&Placed]) {
    let Type::Real { quantity: unit::Quantity { unit, display: Some((usual, factor)), .. }, .. } = of.kind else {
        return;
    };
    let plain = values.iter().filter(|placed| placed.unit().is_empty()).filter_map(|placed| placed.number());
    let plain: Vec<f64> = plain.filter(|value| *value != 0.0).collect();
    let (least, most) = plain.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(*x), b.max(*x)));
    let range = |factor: f64| match least == most {
        true => text::number(factor * least),
        false => format!("{} to {}", text::number(factor * least), text::number(factor * most)),
    };
    if !plain.is_empty() {
        section.faults.note(format!(
            "`{name}` without a unit is in {unit}: {} {unit}, which is {} {usual}",
            range(1.0),
            range(*factor)
        ));
    }
}

/// A value from the study, with its place.
struct Placed {
    text: String,
    span: document::Span,
    path: String,
}

impl Placed {
    /// A value other than a list or a table.
    fn of(section: &Section<'_>, node: &Node<'_>) -> Option<Self> {
        let text = match node.value {
            Value::Float(number) if number.is_finite() => number.to_string(),
            Value::Integer(Some(number)) => (*number as f64).to_string(),
            Value::Boolean(value) => value.to_string(),
            Value::Text(text) => normal(text.trim()),
            _ => {
                let said = ": a number, a text, true or false is expected";
                return section.refuse(section.faults.at(node.span.clone(), said).of(&node.path));
            }
        };
        Some(Placed { text, span: node.span.clone(), path: node.path.clone() })
    }

    /// A number, with its unit if it has one.
    fn number(&self) -> Option<f64> {
        number(&self.text).map(|(number, _)| number)
    }

    fn unit(&self) -> &str {
        number(&self.text).map_or("", |(_, unit)| unit)
    }
}

fn number(text: &str) -> Option<(f64, &str)> {
    let (number, unit) = units::split(text);
    number.parse().ok().filter(|number: &f64| number.is_finite()).map(|number| (number, unit))
}

/// The text with its number in the shortest form.
fn normal(text: &str) -> String {
    number(text).map_or(text.to_owned(), |(number, unit)| format!("{number} {unit}").trim_end().to_owned())
}

/// Tables that every scene may have; their keys are variables of its FMU as well.
const ALWAYS: [&str; 2] = ["solver.", "start."];

/// True if a scene has a key, false if it may have it; None if it cannot have it. The speed is no key of a drive on inputs.
pub fn has_place(scene: &Document, key: &str) -> Option<bool> {
    match scene.place(key) {
        Some(Some(_)) => Some(true),
        Some(None) => (key != "drive.speed").then_some(false),
        None => ALWAYS.iter().any(|table| key.starts_with(table)).then_some(false),
    }
}

impl Study {
    /// The number of runs.
    pub fn rows(&self) -> u64 {
        self.lengths().iter().product()
    }

    /// The number of values of each dimension of the product.
    pub fn lengths(&self) -> Vec<u64> {
        let lists = self.axes.iter().map(|axis| axis.rows.len() as u64);
        lists.chain(self.samples.iter().map(|samples| samples.runs().into())).collect()
    }

    /// The values of a run, in the order of the quantities.
    pub fn cells(&self, row: u64) -> Vec<Cell> {
        let places = places(&self.lengths(), row);
        let mut cells: Vec<Cell> = self
            .axes
            .iter()
            .zip(&places)
            .flat_map(|(axis, place)| axis.rows[*place as usize].iter().cloned())
            .collect();
        if let (Some(samples), Some(run)) = (&self.samples, places.last()) {
            let count = self.quantities.len() - cells.len();
            cells.extend((0..count).map(|i| Cell::Number(samples.value(i, *run as u32))));
        }
        cells
    }

    /// The quantities of each dimension of the product.
    pub fn dimensions(&self) -> Vec<Vec<&str>> {
        let mut names = self.quantities.iter().map(|quantity| quantity.name.as_str());
        let mut all: Vec<Vec<&str>> = self.axes.iter().map(|axis| names.by_ref().take(axis.width).collect()).collect();
        let sampled: Vec<&str> = names.collect();
        if !sampled.is_empty() {
            all.push(sampled);
        }
        all
    }

    /// True if the last dimension contains samples.
    pub fn is_sampled(&self) -> bool {
        self.samples.is_some()
    }

    /// True if keys of the scene vary, so that each run needs its own scene.
    pub fn is_keyed(&self) -> bool {
        self.quantities.iter().any(|quantity| quantity.variable.is_none())
    }

    /// The runner of a system.
    ///
    /// # Errors
    /// Unknown outputs, or outputs that cannot be measured so.
    pub fn runner<'a>(&'a self, coupled: &'a Coupled) -> Result<coupled::Runner<'a>, Fault> {
        let description = |part| coupled.description(part);
        coupled::Runner::new(&coupled.places, &coupled.variables, description, &self.window, &self.measures)
    }

    /// Warnings on the first and the last run that the scene itself does not cause.
    fn implausible(&self, all: &[Description]) -> Vec<String> {
        let Subject::Scene(scene) = &self.subject else { return Vec::new() };
        let warnings = |scene: &Resolved| overview::of(&scene.resource()).warnings;
        let own = warnings(scene);
        let of_run = |row: u64| {
            let cells = self.cells(row);
            let (_, document) = &mut self.changed(&cells)[0];
            for (quantity, cell) in self.quantities.iter().zip(cells) {
                let key = quantity.variable.and_then(|place| Some(&all.get(place)?.key));
                if let (Some(key), Cell::Number(value)) = (key.filter(|key| document.place(key).is_some()), cell) {
                    document.set(key, value);
                }
            }
            let found = scene::variant(&self.place.display().to_string(), document, &scene.folder);
            let found = found.map(|scene| warnings(&scene)).unwrap_or_default();
            let new = found.into_iter().filter(|warning| !own.contains(warning));
            let only = if self.rows() > 2 { " (checked: the first and the last)" } else { "" };
            new.map(move |warning| {
                format!("run {row}{only}: {} {}", sentence(&warning.message), sentence(&warning.hint))
            })
            .collect::<Vec<_>>()
        };
        [0, self.rows() - 1].into_iter().take(self.rows().min(2) as usize).flat_map(of_run).collect()
    }

    /// The files with the values of a run.
    fn changed(&self, cells: &[Cell]) -> Vec<(String, Document)> {
        let mut documents = self.documents.clone();
        for (quantity, cell) in self.quantities.iter().zip(cells).filter(|(quantity, _)| quantity.variable.is_none()) {
            if let Some((i, path)) = located(&self.documents, &quantity.name) {
                documents[i].1.set(path, quantity.written(cell));
            }
        }
        documents
    }

    /// The scene or the system of a run in which keys vary.
    ///
    /// # Errors
    /// The faults of the scene or the system.
    pub fn variant(&self, cells: &[Cell]) -> Result<Subject, Diagnostics> {
        let documents = self.changed(cells);
        let whole = &documents[0].1;
        match &self.subject {
            Subject::Scene(scene) => {
                let scene = scene::variant(&self.place.display().to_string(), whole, &scene.folder)?;
                Ok(Subject::Scene(Box::new(scene)))
            }
            Subject::Coupled(base) => {
                let system = system::resolve(&self.place, whole, &documents[1..])?;
                let coupled = Coupled::new(system, Some(base)).map_err(|fault| of_file(&self.place, fault))?;
                Ok(Subject::Coupled(Box::new(coupled)))
            }
        }
    }
}

impl Quantity {
    /// A value of the key, written as in a scene.
    fn written(&self, cell: &Cell) -> toml_edit::Value {
        match cell {
            // Whole numbers are counts, too.
            Cell::Number(number) if self.unit.is_empty() => {
                number.to_string().parse().unwrap_or_else(|_| (*number).into())
            }
            Cell::Number(number) => format!("{number} {}", self.unit).into(),
            Cell::Text(text) => text.parse::<bool>().map_or_else(|_| text.as_str().into(), Into::into),
        }
    }
}
