//! The drive with one of its features left out: what does it change, and what does it save?
//!
//! Each model has a file here that lists the features of its scene. A feature is left out by another scene of the same
//! model or, in a rigid limit, by formulas: a stiffness that is merely large would neither be rigid nor cheap.

mod backlash;
mod elastic_output;
mod elastic_shaft;
mod parametric;
mod rigid_machine;

use crate::resource::Resource;
use camdrive::drives::backlash::BacklashDrive;
use camdrive::drives::cam_drive::{DriveMode, StartMode};
use camdrive::drives::cam_turn::turns;
use camdrive::drives::elastic_output::ElasticOutput;
use camdrive::drives::elastic_shaft::ElasticShaft;
use camdrive::drives::parametric::ParametricDrive;
use camdrive::drives::rigid_machine::RigidMachine;
use camdrive::drives::{Drive as _, Fault};
use camdrive::motion::{Fourier, MotionLaw};
use camdrive::numerics::angle;
use camdrive::numerics::double_double::Double;
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::Value;

/// A feature and the drive without it.
pub struct Simplification<S> {
    /// What is left out, to be read after "without": "damping".
    pub feature: String,
    /// What takes its place: "b = 0".
    pub instead: String,
    /// The simpler drive.
    pub model: Simplified<S>,
}

/// A drive without one of its features.
pub enum Simplified<S> {
    /// Another scene of the same model.
    Scene(S),
    /// Formulas for the outputs.
    Formula(Formula),
}

/// The scene with one of its features left out, for each feature that it has; the names of the outputs stay. A model that is
/// not known here has none.
pub fn of(resource: &Resource) -> Result<Vec<Simplification<Value>>, Fault> {
    match resource.model.as_str() {
        ElasticOutput::MODEL => erased(resource, elastic_output::of),
        ElasticShaft::MODEL => erased(resource, elastic_shaft::of),
        BacklashDrive::MODEL => erased(resource, backlash::of),
        RigidMachine::MODEL => erased(resource, rigid_machine::of),
        ParametricDrive::MODEL => erased(resource, parametric::of),
        _ => Ok(Vec::new()),
    }
}

fn erased<S: Serialize + DeserializeOwned>(
    resource: &Resource,
    of: fn(&S) -> Vec<Simplification<S>>,
) -> Result<Vec<Simplification<Value>>, Fault> {
    let erased = |Simplification { feature, instead, model }: Simplification<S>| {
        let model = match model {
            Simplified::Scene(scene) => {
                Simplified::Scene(serde_json::to_value(scene).map_err(|e| Fault(e.to_string()))?)
            }
            Simplified::Formula(formula) => Simplified::Formula(formula),
        };
        Ok(Simplification { feature, instead, model })
    };
    of(&resource.read()?).into_iter().map(erased).collect()
}

/// Values of outputs at an instant.
pub type Evaluation = dyn Fn(&Shaft, &mut [f64]);

/// Outputs that follow from the motion of the shaft alone.
pub struct Formula {
    /// The names of the outputs.
    pub outputs: Vec<String>,
    /// Their values, in the same order.
    pub evaluate: Box<Evaluation>,
}

/// The motion of the shaft at an instant.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Shaft {
    /// φ (rad).
    pub phi: f64,
    /// φ̇ (rad/s).
    pub w: f64,
    /// φ̈ (rad/s²).
    pub a: f64,
}

/// A follower without any elasticity: U, U′ and the derivatives of y = U(φ).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RigidFollower {
    /// y = U (m).
    pub y: f64,
    /// ẏ = U′ω (m/s).
    pub y_dot: f64,
    /// ÿ = U″ω² + U′α (m/s²).
    pub y_dot_dot: f64,
    /// U′ (m/rad).
    pub slope: f64,
}

impl RigidFollower {
    /// The follower of `law` on this shaft.
    pub fn of(law: &MotionLaw, shaft: &Shaft) -> Self {
        let &Shaft { phi, w, a } = shaft;
        let [y, u1, u2, ..] = law.at(angle::reduce(Double::from(phi))).0;
        RigidFollower { y, y_dot: u1 * w, y_dot_dot: u2 * w * w + u1 * a, slope: u1 }
    }
}

impl<S> Simplification<S> {
    /// The feature is left out by this scene.
    pub fn scene(feature: &str, instead: &str, scene: S) -> Self {
        let (feature, instead) = (feature.to_owned(), instead.to_owned());
        Simplification { feature, instead, model: Simplified::Scene(scene) }
    }

    /// The feature is left out by these formulas.
    pub fn formula(
        feature: &str,
        instead: &str,
        outputs: &[&str],
        evaluate: impl Fn(&Shaft, &mut [f64]) + 'static,
    ) -> Self {
        let outputs = outputs.iter().map(|name| (*name).to_owned()).collect();
        let model = Simplified::Formula(Formula { outputs, evaluate: Box::new(evaluate) });
        Simplification { feature: feature.to_owned(), instead: instead.to_owned(), model }
    }
}

/// What the scenes of the cam drives have in common and can be spared.
pub struct CamDriveParts<'a> {
    /// b.
    pub damping: &'a mut f64,
    /// How the cam is driven.
    pub drive: &'a DriveMode,
    /// How the motion begins.
    pub start: &'a mut StartMode,
    /// The law of the cam.
    pub law: &'a mut MotionLaw,
}

/// The cam drive without damping, without the transient, with fewer harmonics, as far as the scene has them.
pub fn of_cam_drive<S: Clone>(scene: &S, parts: fn(&mut S) -> CamDriveParts<'_>) -> Vec<Simplification<S>> {
    let mut whole = scene.clone();
    let CamDriveParts { damping, drive, start, law } = parts(&mut whole);
    let with = |change: &dyn Fn(CamDriveParts)| {
        let mut simpler = scene.clone();
        change(parts(&mut simpler));
        simpler
    };
    let mut list = Vec::new();
    if *damping > 0.0 {
        list.push(Simplification::scene("damping", "b = 0", with(&|p| *p.damping = 0.0)));
    }
    if matches!(drive, DriveMode::Constant { w, .. } if turns(*w)) && *start != StartMode::SteadyState {
        let steady = with(&|p| *p.start = StartMode::SteadyState);
        list.push(Simplification::scene("the transient", "start on the periodic motion", steady));
    }
    for fewer in fewer_harmonics(law) {
        let rest = with(&|p| *p.law = fewer.law.clone());
        list.push(Simplification::scene(&fewer.feature, &fewer.instead, rest));
    }
    list
}

/// A law without some of its harmonics.
#[derive(Clone, Debug, PartialEq)]
pub struct FewerHarmonics {
    /// What is left out: "harmonic k = 5".
    pub feature: String,
    /// What is left: "4 of 5 harmonics".
    pub instead: String,
    /// The law of the rest.
    pub law: MotionLaw,
}

/// So many harmonics, the smallest ones, are left out one by one: the larger ones are what the law is made of.
const MOST_SINGLE: usize = 4;

/// The law without each of its smallest harmonics and without the smaller half of them; empty where the law is no series of at
/// least two harmonics. A harmonic counts by its share of U″, k²√(aₖ² + bₖ²), which is what moves masses.
pub fn fewer_harmonics(law: &MotionLaw) -> Vec<FewerHarmonics> {
    let Some(series) = law.series() else { return Vec::new() };
    let share = |k: usize| (k * k) as f64 * (series.a[k].powi(2) + series.b[k].powi(2)).sqrt();
    let mut harmonics: Vec<usize> = (1..series.a.len()).filter(|k| share(*k) > 0.0).collect();
    harmonics.sort_by(|j, k| share(*j).total_cmp(&share(*k)));
    let (half, single) = (harmonics.len() / 2, harmonics.len().min(MOST_SINGLE));
    if harmonics.len() < 2 {
        return Vec::new();
    }
    let without = |dropped: &[usize]| {
        let mut dropped = dropped.to_vec();
        dropped.sort_unstable();
        let mut rest = series.clone();
        for &k in &dropped {
            (rest.a[k], rest.b[k]) = (0.0, 0.0);
        }
        let order = (1..rest.a.len()).rev().find(|k| rest.a[*k] != 0.0 || rest.b[*k] != 0.0).unwrap_or(0);
        rest.a.truncate(order + 1);
        rest.b.truncate(order + 1);
        let plural = if dropped.len() == 1 { "" } else { "s" };
        FewerHarmonics {
            feature: format!("harmonic{plural} k = {}", listed(&dropped)),
            instead: format!("{} of {} harmonics", harmonics.len() - dropped.len(), harmonics.len()),
            law: MotionLaw::Fourier(Fourier::new(rest.a, rest.b)),
        }
    };
    let singles = harmonics[..single].chunks(1);
    singles.chain((half > 1).then_some(&harmonics[..half])).map(without).collect()
}

/// Ascending numbers, three and more in a row as "4 … 9".
fn listed(numbers: &[usize]) -> String {
    let runs = numbers.chunk_by(|a, b| a + 1 == *b);
    let parts = runs.flat_map(|run| match run {
        [first, _, .., last] => vec![format!("{first} … {last}")],
        short => short.iter().map(usize::to_string).collect(),
    });
    parts.collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_smallest_accelerations_go_first() {
        // Shares of U″: k = 1: 1, k = 2: 0.4, k = 3: 0.9, k = 4: 0.8.
        let law = MotionLaw::Fourier(Fourier::new(vec![5.0, 1.0, 0.0, 0.1, 0.05], vec![0.0, 0.0, 0.1]));
        let fewer = fewer_harmonics(&law);
        assert_eq!((fewer[0].feature.as_str(), fewer[0].instead.as_str()), ("harmonic k = 2", "3 of 4 harmonics"));
        let singles: Vec<&str> = fewer[..4].iter().map(|f| f.feature.as_str()).collect();
        assert_eq!(singles, ["harmonic k = 2", "harmonic k = 4", "harmonic k = 3", "harmonic k = 1"]);
        assert_eq!((fewer[4].feature.as_str(), fewer[4].instead.as_str()), ("harmonics k = 2, 4", "2 of 4 harmonics"));
        assert_eq!(fewer.len(), 5);
        let rest = fewer[4].law.series().unwrap();
        assert_eq!((rest.a.as_slice(), rest.b.as_slice()), (&[5.0, 1.0, 0.0, 0.1][..], &[0.0; 4][..]));
        for single in [vec![1.0, 2.0], vec![1.0]] {
            assert!(fewer_harmonics(&MotionLaw::Fourier(Fourier::new(single, vec![]))).is_empty());
        }
    }

    #[test]
    fn numbers_in_a_row_are_told_by_their_ends() {
        assert_eq!(listed(&[1, 4, 5, 6, 8, 9]), "1, 4 … 6, 8, 9");
        assert_eq!((listed(&[7]).as_str(), listed(&[2, 3, 4, 5]).as_str()), ("7", "2 … 5"));
    }

    #[test]
    fn a_rigid_follower_moves_with_its_law() {
        let law = MotionLaw::Fourier(Fourier::new(vec![0.0, 0.0], vec![0.0, 2.0]));
        let shaft = Shaft { phi: 1.0 + 20.0 * std::f64::consts::TAU, w: 3.0, a: 5.0 };
        let rigid = RigidFollower::of(&law, &shaft);
        let (s, c) = 1.0_f64.sin_cos();
        assert!((rigid.y - 2.0 * s).abs() < 1e-13 && (rigid.y_dot - 6.0 * c).abs() < 1e-13);
        assert!((rigid.y_dot_dot - (-18.0 * s + 10.0 * c)).abs() < 1e-12 && (rigid.slope - 2.0 * c).abs() < 1e-13);
    }
}
