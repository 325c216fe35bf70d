//! Scene files: TOML → validated SI parameters.
//!
//! A plain number is coherent SI; a string carries its unit: `speed = "1800 rpm"`, see [`units`]. All faults of a
//! file are collected in one run, see [`diagnostics`].
//!
//! # Keys of every scene
//!
//! | key | meaning | range | default |
//! |---|---|---|---|
//! | `name` | name of the FMU, its modelIdentifier | a C identifier of at most 24 characters | required |
//! | `description` | one sentence for the importer | | empty |
//! | `model` | `ElasticCamDrive`, `BacklashDrive` or `RigidMachine` | | required |
//! | `solver.tolerance` | relative tolerance [1]; 0 for the model's documented default | 0 … 1 | 0 |
//!
//! # `[cam]`: the motion law U(φ)
//!
//! | key | meaning | range | default |
//! |---|---|---|---|
//! | `law` | `fourier`, `cycle` or `table` | | required |
//!
//! `law = "fourier"`: U = a₀ + Σ aₖ cos kφ + bₖ sin kφ
//!
//! | key | meaning | range | default |
//! |---|---|---|---|
//! | `a` | the list [a₀, a₁, a₂ …], lengths [m] | at most 257 | required |
//! | `b` | the list [b₁, b₂ …], lengths [m]: there is no b₀ | at most 256 | empty |
//! | `scale` | a length [m] that multiplies all coefficients, which are then pure numbers | not 0 | none |
//!
//! `law = "cycle"`: rise, upper dwell, return, lower dwell, after VDI 2143
//!
//! | key | meaning | range | default |
//! |---|---|---|---|
//! | `stroke` | lift from the lower to the upper dwell [m] | −1e4 … 1e4 | required |
//! | `lower` | U in the lower dwell [m] | −1e4 … 1e4 | 0 |
//! | `rise_law`, `return_law` | `simple_sine` (= `harmonic`), `inclined_sine` (= `bestehorn`), `polynomial_345`, `polynomial_4567`, `modified_sine`, `modified_trapezoid` | | required; `return_law` as `rise_law` |
//! | `rise_start` | angle at which the rise starts [rad] | −2π … 2π | 0 |
//! | `rise`, `upper_dwell`, `return`, `lower_dwell` | their angles [rad], 2π together | rise, return ≥ 1e-3, dwells ≥ 0 | one of them may be left out: the rest of the turn |
//!
//! `law = "table"`: angles and lifts from a text file
//!
//! | key | meaning | range | default |
//! |---|---|---|---|
//! | `file` | path from the folder of the scene; columns separated by `;` `,` tab or blank | 4 … 20000 points over one turn, ascending, the last may repeat the first | required |
//! | `angle_unit`, `lift_unit` | units of the columns | | `rad`, `m` |
//! | `angle_column`, `lift_column` | number of the column from 1, or its heading | | 1, 2 |
//! | `scale` | a length [m] that multiplies the lifts, which are then pure numbers | not 0 | none |
//! | `interpolation` | `spline`: periodic, degree 5; `fourier`: the discrete Fourier series | | `spline` |
//! | `harmonics` | the highest harmonic, for `fourier` | 1 … 256 | required |
//!
//! # `[drive]`: the motion of the cam shaft (`ElasticCamDrive`, `BacklashDrive`)
//!
//! | key | meaning | range | default |
//! |---|---|---|---|
//! | `mode` | `constant` speed, or `input`: the FMU has the inputs phi, w, a | | `constant` |
//! | `speed` | angular velocity [rad/s], for `constant` | −1e6 … 1e6 | required |
//! | `phi_start` | angle at the start [rad], for `constant` | −1e15 … 1e15 | 0 |
//!
//! # `[elasticity]` of an `ElasticCamDrive`
//!
//! | key | meaning | range | default |
//! |---|---|---|---|
//! | `place` | `output`: between cam and follower mass; `shaft`: between drive and cam | | required |
//! | `m` | mass of the follower [kg] | > 0 | required |
//! | `J` | moment of inertia of the cam [kg·m²], for `shaft` | > 0 | required |
//! | `c` | stiffness [N/m], for `shaft` [N·m/rad] | > 0 | this or `natural_frequency` |
//! | `natural_frequency` | ω₀ = √(c/m) [rad/s], for `shaft` √(c/J̄) with J̄ = `J` + `m` · mean of U′² | > 0 | |
//! | `b` | damping [N·s/m], for `shaft` [N·m·s/rad] | ≥ 0 | 0 |
//! | `damping_ratio` | D = b / (2 m ω₀), for `shaft` b / (2 J̄ ω₀) [1], instead of `b` | ≥ 0 | |
//! | `linear` | for `shaft`: the equation linearised in the twist | | false |
//!
//! # `[backlash]` of a `BacklashDrive`
//!
//! | key | meaning | range | default |
//! |---|---|---|---|
//! | `m1` | mass in the clearance [kg] | > 0 | required |
//! | `m2` | working mass [kg] | > 0 | required |
//! | `c` | stiffness between them [N/m] | > 0 | this or `natural_frequency` |
//! | `natural_frequency` | ω = √(c/m2) [rad/s], of the working mass while m1 is in contact | > 0 | |
//! | `b` | damping between them [N·s/m] | ≥ 0 | 0 |
//! | `damping_ratio` | D = b / (2 m2 ω) [1], instead of `b` | ≥ 0 | |
//! | `s` | clearance [m] | ≥ 0 | required |
//! | `e` | coefficient of restitution [1] | 0 … 1 | 0 |
//!
//! # `[start]` (`ElasticCamDrive`, `BacklashDrive`)
//!
//! | key | meaning | range | default |
//! |---|---|---|---|
//! | `mode` | `at_rest` relative to the cam, `given`, or `steady_state` | | `at_rest` |
//! | `q` | q at the start, for `given` [m], for `shaft` [rad] | −1e6 … 1e6 | 0 |
//! | `q_dot` | q̇ at the start, for `given` [m/s], for `shaft` [rad/s] | −1e9 … 1e9 | 0 |
//!
//! # `RigidMachine`
//!
//! | key | meaning | range | default |
//! |---|---|---|---|
//! | `machine.J0` | constant part of the moment of inertia [kg·m²] | > 0 | required |
//! | `[machine.J]` | an addition that varies with φ: a law as in `[cam]`, with values in kg·m² | | none |
//! | `[[follower]]` | a mass on the machine: `m` [kg], > 0, and `[follower.cam]` | | none |
//! | `motor.kind` | `none`, `kloss` or `input` (the torque M_an is an input) | | `none` |
//! | `motor.M_k` | breakdown torque [N·m], for `kloss` | > 0 | required |
//! | `motor.s_k` | breakdown slip [1], for `kloss` | > 0 | required |
//! | `motor.w_s` | synchronous speed at the machine's shaft [rad/s], for `kloss` | not 0 | required |
//! | `motor.lag` | electrical time constant [s] of the torque, for `kloss` | > 0 | none: the torque follows at once |
//! | `start.mode` | `given` or `steady_state` | | `given` |
//! | `start.phi_start` | angle at the start [rad] | −1e9 … 1e9 | 0 |
//! | `start.w_start` | angular velocity at the start [rad/s] | −1e6 … 1e6 | 0 |

pub mod diagnostics;
mod models;
mod motion_law;
mod section;
mod table;
#[cfg(test)]
mod tests;
pub mod units;

pub use diagnostics::{Diagnostic, Diagnostics};

use crate::drives::resource::Resource;
use section::{Faults, Section};
use std::path::Path;
use toml::de::DeTable;

/// The longest name of a scene: importers use it as a file name and as a prefix of C functions.
const LONGEST_NAME: usize = 24;

/// A validated scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Resolved {
    /// A C identifier.
    pub name: String,
    /// One sentence of the user, or nothing.
    pub description: String,
    /// One of [`crate::drives::MODELS`].
    pub model: &'static str,
    /// The [`crate::drives::Drive::Scene`] of that model.
    pub scene: serde_json::Value,
    /// What the user should know though it is no fault.
    pub notes: Vec<String>,
}

impl Resolved {
    /// As an FMU carries it, with an empty guid.
    pub fn resource(&self) -> Resource {
        Resource {
            name: self.name.clone(),
            model: self.model.to_owned(),
            guid: String::new(),
            scene: self.scene.clone(),
        }
    }
}

/// Reads and validates a scene file: every value, and that the drive can be built and started with them.
pub fn read(path: &Path) -> Result<Resolved, Diagnostics> {
    let file = path.display().to_string();
    let whole = |message: String, hint: &str| Diagnostics(vec![Diagnostic::new(&file, message).hint(hint)]);
    let bytes = std::fs::read(path)
        .map_err(|e| whole(format!("the scene cannot be read: {e}"), "name a scene file, for example scene.toml"))?;
    let text = String::from_utf8(bytes).map_err(|e| {
        let good = e.utf8_error().valid_up_to();
        let text = String::from_utf8_lossy(e.as_bytes());
        let fault = Diagnostic::new(&file, "the scene is not UTF-8 text").at(&text, good..good + 1);
        Diagnostics(vec![fault.hint("save it with the encoding UTF-8")])
    })?;
    let folder = path.parent().unwrap_or(Path::new(""));
    resolve(&file, &text, folder)
}

/// The scene `text` of the file `file`; tables are looked for in `folder`.
fn resolve(file: &str, text: &str, folder: &Path) -> Result<Resolved, Diagnostics> {
    let mut faults = Faults::new(file, text);
    let (document, mut errors) = DeTable::parse_recoverable(text);
    errors.sort_by_key(|error| error.span().map_or(text.len(), |span| span.start));
    for error in &errors {
        let span = error.span().unwrap_or(text.len()..text.len());
        faults.report(faults.at(span, format!("no valid TOML: {}", error.message())));
        if error.message().contains("array") {
            // A list that is not closed takes the rest of the file for its elements; one message is enough.
            break;
        }
    }
    faults.broken = !errors.is_empty();
    let resolved = whole_scene(&Section::root(&faults, document.get_ref()), folder);
    match resolved {
        Some((resolved, names)) if faults.is_empty() => {
            models::try_out(&resolved, &names, &faults);
            if faults.is_empty() { Ok(resolved) } else { Err(faults.into_diagnostics()) }
        }
        _ => Err(faults.into_diagnostics()),
    }
}

/// The scene with the places of its values; None where a fault was reported.
fn whole_scene(root: &Section<'_>, folder: &Path) -> Option<(Resolved, models::Names)> {
    let name = name(root);
    let description = root.text("description").map(|text| text.unwrap_or_default().trim().to_owned());
    let drive = models::drive(root, folder);
    let (model, scene, names) = drive?;
    Some((Resolved { name: name?, description: description?, model, scene, notes: root.faults.notes() }, names))
}

/// The name of the scene.
fn name(root: &Section<'_>) -> Option<String> {
    let admissible = format!("letters, digits and _, no digit first, at most {LONGEST_NAME} characters");
    let name = root.required_text("name", &admissible, "guide_bar")?;
    let identifier = name.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_')
        && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_');
    if identifier && name.len() <= LONGEST_NAME {
        return Some(name.to_owned());
    }
    let mut better: String = name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
    if !better.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_') {
        better.insert(0, '_');
    }
    better.truncate(LONGEST_NAME);
    let fault = root.fault_of("name", format!("`name`: \"{name}\" cannot name an FMU"));
    root.faults.report(fault.admissible(admissible).hint(format!("write for example \"{better}\"")));
    None
}
