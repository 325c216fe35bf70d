//! The study as a whole, on scenes whose answers are known. Errors and changes are checked, never times.

use super::*;
use crate::plot::Rule;
use crate::report::{Value, terminal};
use crate::resource::Scene;
use camdrive::drives::follower::load::Load;
use camdrive::drives::settings::Settings;
use camdrive::drives::shaft::cam_drive::{DriveMode, Start, StartMode};
use camdrive::drives::{elastic_output, elastic_shaft};
use camdrive::motion::{Fourier, MotionLaw};

const AT_REST: Start = Start { mode: StartMode::AtRest, q: 0.0, q_dot: 0.0 };

fn law() -> MotionLaw {
    MotionLaw::Fourier(Fourier::new(vec![0.0, 0.01, 0.0, 0.001], vec![]))
}

fn resource(scene: impl Into<Scene>) -> Resource {
    Resource { guid: "{1}".into(), ..Resource::new("study", scene) }
}

/// ω₀ = 100 rad/s, on the periodic motion, so that every change has a closed form.
fn output(drive: DriveMode) -> Resource {
    let start = match drive {
        DriveMode::Constant { .. } => Start { mode: StartMode::SteadyState, ..AT_REST },
        DriveMode::Input | DriveMode::Speed { .. } => AT_REST,
    };
    let settings = Settings::default();
    resource(elastic_output::Scene {
        coupling: false,
        parameters: elastic_output::Parameters { m: 2.0, c: 2e4, b: 0.0 },
        load: Load::default(),
        roller: (0.0, Load::default()),
        cam: law(),
        drive,
        start,
        solver: settings,
    })
}

fn quick() -> Options {
    Options { quick: true, turns: Some(2.0), ..Options::default() }
}

/// A drive that is integrated step by step.
fn shaft() -> elastic_shaft::Scene {
    elastic_shaft::Scene {
        load: Default::default(),
        parameters: elastic_shaft::Parameters { m: 20.0, inertia: 0.05, c: 2000.0, b: 1.0 },
        linear: false,
        cam: MotionLaw::Fourier(Fourier::new(vec![0.0, 0.05], vec![])),
        drive: DriveMode::Constant { w: 20.0, phi_start: 0.0 },
        start: AT_REST,
        solver: Settings::default(),
    }
}

fn feature<'a>(report: &'a Findings, start: &str) -> &'a Feature {
    report.features.iter().find(|f| f.feature.starts_with(start)).unwrap()
}

#[test]
fn changes_are_those_of_the_closed_form() {
    let w = 10.0;
    let report = study(&output(DriveMode::Constant { w, phi_start: 0.0 }), &quick(), &|_| ()).unwrap();
    // Periodic motion of harmonic k: y = U_k /(1 − η²k²), η = w/ω₀ = 0.1; all cosines, so largest at φ = 0.
    let gain = |k: f64| 1.0 / (1.0 - 0.01 * k * k);
    let largest = 0.01 * gain(1.0) + 0.001 * gain(3.0);
    let y = report.outputs.iter().find(|output| output.name == "y").unwrap();
    assert!((y.largest - largest).abs() < 1e-12, "{y:?}");
    assert_eq!(y.unit, "m");
    // Without harmonic 3 (share of U″ 9e-3 against 1e-2).
    let third = feature(&report, "harmonic k = 3");
    assert!((third.changes["y"] - 0.001 * gain(3.0) / largest).abs() < 1e-9, "{third:?}");
    // Rigid: y = U.
    let rigid = feature(&report, "the elasticity");
    assert!((rigid.changes["y"] - (largest - 0.011) / largest).abs() < 1e-9);
    assert_eq!(rigid.changes["q"], 1.0);
    assert!(rigid.worst.as_deref() != Some("q"), "q vanishes and says nothing of the rest");
    let first = feature(&report, "harmonic k = 1");
    assert!((first.changes["y"] - 0.01 * gain(1.0) / largest).abs() < 1e-9, "{first:?}");
    // No damping, no transient to be left out.
    assert_eq!(report.features.len(), 3);
    // The closed form is right at every setting.
    assert!(report.reference.floor < 1e-10 && report.reference.separation.is_none(), "{:?}", report.reference);
    assert!(report.settings.iter().all(|row| row.error.unwrap() <= 1e-10), "{:?}", report.settings);
    assert!(report.settings.iter().all(|row| row.fault.is_none() && row.cost.is_some()));
    assert_eq!(report.advice.len(), 4);
    let verdict = advice::verdict(&report);
    assert!(verdict.parts().iter().flat_map(|(_, texts)| texts).all(|text| text.ends_with('.')));
    nothing_is_told_below_the_floor(&report);
    assert!(report.advice[1].may_be_left_out.is_empty());
}

/// U = r sin φ under the constant force −F on a stiff shaft: contact_force is F and little beside it, tau = F r cos φ.
#[test]
fn loads_count_as_a_feature_and_on_the_rigid_drive() {
    let mut scene = shaft();
    scene.load = Load { constant: Some(-5000.0), ..Load::default() };
    (scene.parameters.m, scene.parameters.c, scene.linear) = (1e-3, 2e5, true);
    scene.start.mode = StartMode::SteadyState;
    let report = study(&resource(scene), &quick(), &|_| ()).unwrap();
    let largest = |name: &str| report.outputs.iter().find(|output| output.name == name).unwrap().largest;
    assert!((largest("contact_force") - 5000.0).abs() < 1.0 && (largest("tau") - 250.0).abs() < 0.1);
    let loads = feature(&report, "the loads");
    assert!((loads.changes["tau"] - 1.0).abs() < 1e-3 && (loads.changes["contact_force"] - 1.0).abs() < 1e-3);
    let rigid = feature(&report, "the elasticity");
    assert!(rigid.changes["tau"] < 5e-3 && rigid.changes["contact_force"] < 5e-3, "{rigid:?}");
}

#[test]
fn a_study_that_takes_too_much_work_ends_and_says_so() {
    let study = crate::work::within(1e6, "do less", &|_| (), |tell| study(&resource(shaft()), &quick(), tell).is_ok());
    let message = study.unwrap_err().to_string();
    assert!(message.contains("1.0e6 operations") && message.contains("reached: reference, 0 of 1"), "{message}");
}

/// Errors and changes that the reference does not tell are bounds, in every form of the report.
fn nothing_is_told_below_the_floor(report: &Findings) {
    let floor = report.reference.floor;
    let errors = report.settings.iter().flat_map(|row| row.errors.values().chain(&row.error));
    let changes = report.features.iter().flat_map(|f| f.changes.values().chain(&f.change));
    assert!(errors.chain(changes).all(|value| *value >= floor), "{report:?}");
    let below =
        report.settings.iter().find(|row| row.error == Some(floor)).expect("a setting as exact as the reference");
    assert_eq!(below.worst, None);
    let bound = format!("< {}", number(floor));
    let told = report.report();
    let settings = told.tables().find(|table| table.title == "Settings").unwrap();
    let column = settings.columns.iter().position(|column| column.key == "error").unwrap();
    assert!(settings.rows.iter().any(|row| row[column] == Value::AtMost(floor)), "{settings:?}");
    let known = |value: &Value| !matches!(value, Value::Number(error) if *error < floor);
    assert!(settings.rows.iter().all(|row| known(&row[column])), "{settings:?}");
    assert!(terminal::cells(settings).rows.concat().contains(&bound), "{settings:?}");
    for key in ["settings", "features"] {
        let text = written(report, key);
        let mut csv = csv::Reader::from_reader(text.as_bytes());
        let known = csv.headers().unwrap().iter().position(|head| head == "known_to").unwrap();
        assert!(csv.records().all(|record| record.unwrap()[known].parse() == Ok(floor)));
    }
    for diagram in [figures::work_precision(report), figures::communication_step(report)] {
        let axis = usize::from(diagram.title.starts_with("Error"));
        assert!(diagram.series.iter().flat_map(|s| &s.points).all(|point| point[axis] >= floor), "{}", diagram.title);
        // The curves run along the line of the uncertainty: a name along it would be crossed, so that the legend has it.
        let named =
            diagram.rules.iter().find(|rule| matches!(rule, Rule::Key(None, name) if name.contains("uncertainty")));
        let on_it = |name: &str| name != "one turn" && !name.is_empty();
        let words = diagram.rules.iter().filter(|rule| match rule {
            Rule::Vertical(_, name) | Rule::Horizontal(_, name) => on_it(name),
            _ => false,
        });
        assert!(named.is_some() && words.count() == 0, "{:?}", diagram.rules);
    }
}

/// The CSV file of a table.
fn written(findings: &Findings, key: &str) -> String {
    let files = findings.report().files();
    files.into_iter().find(|(name, _)| *name == format!("{key}.csv")).unwrap().1.unwrap()
}

#[test]
fn a_tolerance_buys_accuracy_and_the_advice_knows() {
    let report = study(&resource(shaft()), &quick(), &|_| ()).unwrap();
    assert!(report.reference.floor < 1e-10, "{:?}", report.reference);
    let at = |tolerance: f64| {
        let usual = |row: &&Row| row.tolerance == Some(tolerance) && row.communication_step == report.experiment.step;
        report.settings.iter().find(usual).unwrap()
    };
    let (coarse, middle, fine) = (at(1e-3), at(1e-6), at(1e-9));
    assert!(coarse.error > middle.error && middle.error > fine.error, "{coarse:?} {middle:?} {fine:?}");
    let steps = |row: &Row| row.cost.unwrap().steps.unwrap();
    assert!(steps(coarse) < steps(middle) && steps(middle) < steps(fine));
    for advice in &report.advice {
        if let Some(row) = advice.setting.map(|i| &report.settings[i]) {
            assert!(row.error.unwrap() <= advice.target, "{advice:?}");
        }
    }
    assert!(report.advice[0].setting.is_some());
    assert!(feature(&report, "the nonlinearity").change.unwrap() > 1e-9);
    // The rows of one setting stand together, from short to long communication steps.
    let setting = |row: &Row| format!("{:?} {:?} {:?} {:?}", row.method, row.inputs, row.tolerance, row.step_size);
    let mut settings: Vec<String> = report.settings.iter().map(setting).collect();
    for (rows, names) in report.settings.windows(2).zip(settings.windows(2)) {
        assert!(names[0] != names[1] || rows[0].communication_step < rows[1].communication_step, "{names:?}");
    }
    settings.dedup();
    let distinct: std::collections::BTreeSet<&String> = settings.iter().collect();
    assert_eq!(distinct.len(), settings.len(), "{settings:?}");
    // Tables hold every row, and CSV and JSON every number.
    assert_eq!(written(&report, "settings").lines().count(), 1 + report.settings.len());
    assert_eq!(written(&report, "features").lines().count(), 1 + report.features.len());
    let json: serde_json::Value = serde_json::to_value(&report).unwrap();
    assert_eq!(json["settings"].as_array().unwrap().len(), report.settings.len());
    for diagram in [figures::work_precision(&report), figures::communication_step(&report)] {
        assert!(!diagram.series.is_empty());
        assert!(diagram.svg().starts_with("<svg"));
    }
}

#[test]
fn a_drive_with_inputs_runs_up() {
    let options = Options { speed: Some(30.0), ..quick() };
    let report = study(&output(DriveMode::Input), &options, &|_| ()).unwrap();
    let [speed, ramp] = report.experiment.run_up.unwrap();
    assert_eq!(speed, 30.0);
    // Half of the ramp's time counts as turning at full speed: the run makes two turns.
    assert!(((report.experiment.stop - 0.5 * ramp) * speed / TAU - 2.0).abs() < 0.01);
    let error = |inputs: &str| {
        let usual = |row: &&Row| row.inputs == Some(inputs) && row.communication_step == report.experiment.step;
        report.settings.iter().find(usual).and_then(|row| row.error).unwrap()
    };
    assert!(error("derivatives") < 1e-9 && error("values") > 1e-6, "{} {}", error("derivatives"), error("values"));
}

#[test]
fn options_without_an_experiment_are_refused_by_name() {
    let still = output(DriveMode::Constant { w: 0.0, phi_start: 0.0 });
    let refusal = |resource: &Resource, options: Options| study(resource, &options, &|_| ()).unwrap_err().to_string();
    assert!(refusal(&output(DriveMode::Input), Options { speed: Some(0.0), ..quick() }).contains("--speed"));
    assert!(refusal(&output(DriveMode::Input), Options { ramp: Some(-1.0), ..quick() }).contains("--ramp"));
    let turning = output(DriveMode::Constant { w: 5.0, phi_start: 0.0 });
    assert!(refusal(&turning, Options { turns: Some(0.0), ..quick() }).contains("--turns"));
    assert!(refusal(&turning, Options { turns: Some(1e9), ..quick() }).contains("--turns"));
    assert!(refusal(&still, quick()).contains("stands still"));
}

#[test]
fn the_median_is_the_middle() {
    assert_eq!((median(&[3.0, 1.0, 2.0]), median(&[4.0, 1.0, 2.0, 3.0]), median(&[])), (Some(2.0), Some(2.5), None));
}

/// Costs and errors of any size about the same study; the default reaches every target.
#[test]
fn nothing_that_saves_less_than_five_per_cent_is_advised() {
    let mut report = study(&resource(shaft()), &quick(), &|_| ()).unwrap();
    let number = |i: usize| (i as f64 * 0.618_033_988_75).fract();
    let usual = |row: &Row| row.is_default() && row.communication_step == report.experiment.step;
    let default = report.settings.iter().position(usual).unwrap();
    let (mut advised, mut left_out) = (0, 0);
    for round in 0..200 {
        for (i, row) in report.settings.iter_mut().enumerate() {
            let ns_per_ms = if i == default { 1e3 } else { 900.0 + 150.0 * number(37 * round + i) };
            row.cost = Some(Cost { ns_per_ms, start_us: 1.0, steps: None, evaluations: None });
            row.error = Some(if i == default { 1e-14 } else { 10f64.powf(-14.0 * number(53 * round + 2 * i)) });
        }
        for (i, feature) in report.features.iter_mut().enumerate() {
            let ratio = 0.9 + 0.15 * number(41 * round + 3 * i);
            feature.cost = Some(Cost { ns_per_ms: 1e3 * ratio, start_us: 1.0, steps: None, evaluations: None });
            (feature.cost_ratio, feature.change) = (Some(ratio), Some(10f64.powf(-14.0 * number(59 * round + 5 * i))));
        }
        report.reference.floor = 1e-14;
        for sentence in advice::verdict(&report).advice.into_iter().map(|advice| advice.text) {
            for part in sentence.split(" ns per ms").filter(|part| part.ends_with(|c: char| c.is_ascii_digit())) {
                let told: f64 = part.rsplit(' ').next().unwrap().parse().unwrap();
                // Three digits are told.
                assert!(told <= 1e3 / 1.05 + 0.5, "{sentence}");
                advised += 1;
            }
        }
        for name in advice::of(&report).into_iter().flat_map(|advice| advice.may_be_left_out) {
            let feature = report.features.iter().find(|f| name == format!("{}: {}", f.feature, f.instead)).unwrap();
            assert!(feature.cost_ratio.unwrap() <= 1.0 / 1.05, "{name}");
            left_out += 1;
        }
    }
    assert!(advised > 100 && left_out > 100, "{advised} {left_out}");
}
