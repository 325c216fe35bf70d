//! The drive with one of its features left out: what does it change, and what does it save?
//!
//! A feature is left out by another scene of the same model or, in its rigid limit ([`super::rigid`]), by formulas: a stiffness that
//! is merely large would neither be rigid nor cheap.

use super::rigid::{self, Formula};
use super::run::Interface;
use crate::resource::Resource;
use crate::text::counted;
use camdrive::drives::backlash::{self, BacklashDrive};
use camdrive::drives::drive_train::{self, DriveTrain, Follower, Joint, Machine, Shaft};
use camdrive::drives::elastic_output;
use camdrive::drives::follower::load::{Load, Spring};
use camdrive::drives::rigid_machine::linkage::{Linkage, ParameterKind};
use camdrive::drives::rigid_machine::{self, Inertia, InertiaFunction, Place, RigidMachine};
use camdrive::drives::shaft::cam_turn::turns;
use camdrive::drives::{Drive as _, Fault};
use camdrive::motion::{Fourier, MotionLaw};
use serde_json::{Value, json};
use std::f64::consts::TAU;

/// A feature and the drive without it.
pub struct Simplification {
    /// To be read after "without": "damping".
    pub feature: String,
    /// Its replacement: "b = 0".
    pub instead: String,
    /// The simpler drive.
    pub model: Simplified,
}

/// A drive without one of its features.
pub enum Simplified {
    /// Another scene of the same model, with its interface unless the drive refuses it.
    Scene(Box<Resource>, Result<Interface, Fault>),
    /// Formulas for the outputs.
    Formula(Formula),
}

/// The values of scenes that make a feature vanish: where a scene has the value, the neutral one, the feature and what takes its
/// place.
fn neutral_values() -> [(&'static str, Value, &'static str, &'static str); 8] {
    let no_damping = json!(Fourier::new(vec![0.0], Vec::new()));
    [
        ("/parameters/s", json!(0.0), "the clearance", "s = 0"),
        ("/parameters/e", json!(0.0), "restitution", "e = 0"),
        ("/linear", json!(true), "the nonlinearity of the shaft", "linear in the twist"),
        ("/motor/kloss/dynamics", Value::Null, "the lag of the motor", "quasi-static torque"),
        ("/shaft/free/motor/source/kloss/dynamics", Value::Null, "the lag of the motor", "quasi-static torque"),
        ("/parameters/b", json!(0.0), "damping", "b = 0"),
        ("/law/crank/damping", json!(0.0), "damping", "b_T = 0"),
        ("/law/series/b", no_damping, "damping", "b = 0"),
    ]
}

/// Where scenes have series, and what the harmonics are of.
const SERIES: [(&str, &str); 4] = [
    ("/cam/fourier", ""),
    ("/law/series/m", " of the mass"),
    ("/law/series/b", " of the damping"),
    ("/law/series/c", " of the stiffness"),
];

/// The harmonics of c_T that a simpler crank keeps: its mean alone, the first one, the first two.
const HARMONICS: [(usize, &str, &str); 3] = [
    (0, "the variation of the stiffness", "its mean"),
    (2, "harmonics of the stiffness above 2", "its mean and its harmonic 2"),
    (4, "harmonics of the stiffness above 4", "its mean and its harmonics 2 and 4"),
];

/// The scene without each of its features; the names of the outputs stay.
///
/// # Errors
/// A scene that is none of its model.
pub fn of(resource: &Resource) -> Result<Vec<Simplification>, Fault> {
    let scene = &resource.scene;
    let rigid = rigid::of(resource)?.map(|(feature, instead, formula)| Simplification {
        feature: feature.to_owned(),
        instead: instead.to_owned(),
        model: Simplified::Formula(formula),
    });
    let mut list: Vec<Simplification> = rigid.into_iter().collect();
    let mut add = |feature: &str, instead: &str, place: &str, value: Value| {
        let left_out = feature.strip_prefix("follower ").and_then(|number| number.parse().ok());
        let resource = Resource { scene: with(scene, place, value), ..resource.clone() };
        let interface = Interface::of(&resource).map(|interface| renumbered(interface, left_out));
        let model = Simplified::Scene(Box::new(resource), interface);
        list.push(Simplification { feature: feature.to_owned(), instead: instead.to_owned(), model });
    };
    for (place, neutral, feature, instead) in neutral_values() {
        if scene.pointer(place).is_some_and(|value| *value != neutral) {
            add(feature, instead, place, neutral);
        }
    }
    let load = scene.get("load").and_then(|load| serde_json::from_value::<Load>(load.clone()).ok());
    if let Some(load) = load.filter(|load| !load.is_none()) {
        add("the loads", "none", "/load", json!(unloaded(&load)));
    }
    if let Some(own) = scene.pointer("/law/crank/harmonics") {
        for (order, feature, instead) in HARMONICS {
            if own.as_u64().is_none_or(|own| (order as u64) < own) {
                add(feature, instead, "/law/crank/harmonics", json!(order));
            }
        }
    }
    // The periodic motion of a drive with backlash is one of permanent contact.
    let constant = scene.pointer("/drive/constant/w").and_then(Value::as_f64).is_some_and(turns);
    let steady = json!("steady_state");
    if resource.model == DriveTrain::MODEL && scene["start"] != steady {
        add("the transient", "start on the periodic motion", "/start", steady.clone());
    }
    if constant && scene.pointer("/start/mode") != Some(&steady) && resource.model != BacklashDrive::MODEL {
        add("the transient", "start on the periodic motion", "/start/mode", steady);
    }
    if resource.model == RigidMachine::MODEL {
        of_machine(&resource.read()?, &mut add);
    }
    if resource.model == DriveTrain::MODEL {
        of_train(&resource.read()?, &mut add);
    }
    let followers = scene["followers"].as_array().map_or(0, Vec::len);
    let cam = if resource.model == DriveTrain::MODEL { "rigid/cam" } else { "cam" };
    let of_followers =
        (0..followers).map(|j| (format!("/followers/{j}/{cam}/fourier"), format!(" of follower {}", j + 1)));
    for (place, of) in SERIES.map(|(place, of)| (place.to_owned(), of.to_owned())).into_iter().chain(of_followers) {
        let Some(value) = scene.pointer(&place) else { continue };
        let series: Fourier = serde_json::from_value(value.clone()).map_err(|e| Fault::new(e.to_string()))?;
        if place.starts_with("/law") && series.bound(1) > 0.0 {
            let mean = Fourier::new(vec![series.a[0]], Vec::new());
            add(&format!("the variation{of}"), "its mean", &place, json!(mean));
        }
        for fewer in fewer_harmonics(&series) {
            add(&(fewer.feature + &of), &fewer.instead, &place, json!(fewer.series));
        }
    }
    Ok(list)
}

/// As many loads of nothing, so that the outputs stay.
fn unloaded(load: &Load) -> Load {
    let [gravity, constant, damping] = [load.gravity, load.constant, load.damping].map(|part| part.map(|_| 0.0));
    let process = load.process.as_ref().map(|_| MotionLaw::Fourier(Fourier::new(vec![0.0], Vec::new())));
    let frames = vec![[0.0; 2]; load.frames.len()];
    Load { gravity, frames, constant, damping, process, spring: load.spring.map(|_| Spring::default()), ..load.clone() }
}

/// The scene with another value in this place.
fn with(scene: &Value, place: &str, value: Value) -> Value {
    let mut scene = scene.clone();
    if let Some(own) = scene.pointer_mut(place) {
        *own = value;
    }
    scene
}

/// The machine with its mean inertia, and with massless links.
fn of_machine(scene: &rigid_machine::Scene, add: &mut impl FnMut(&str, &str, &str, Value)) {
    let inertia = Inertia::new(scene.inertia.clone(), scene.followers.clone());
    if inertia.varies() {
        let constant = InertiaFunction { constant: mean(&inertia), varying: None };
        let scene = rigid_machine::Scene { inertia: constant, followers: Vec::new(), ..scene.clone() };
        add("the variation of the inertia", "constant mean J, no followers", "", json!(scene));
    }
    let mut followers = scene.followers.clone();
    for follower in &mut followers {
        follower.linkage = massless(&follower.linkage);
    }
    if followers != scene.followers {
        add("the inertia of the links", "massless links", "/followers", json!(followers));
    }
}

/// Without follower `left_out` the ones behind it keep their numbers.
fn renumbered(mut interface: Interface, left_out: Option<usize>) -> Interface {
    for variable in interface.variables.iter_mut().filter(|_| left_out.is_some()) {
        let Some((before, rest)) = variable.name.split_once("follower[") else { continue };
        let Some((number, rest)) = rest.split_once(']') else { continue };
        let number = number.parse().map_or(0, |number: usize| number + usize::from(Some(number) >= left_out));
        variable.name = format!("{before}follower[{number}]{rest}");
    }
    interface
}

/// The follower without spring and clearance, its masses in one; the loads on both act on that.
fn rigid_follower(follower: &Follower) -> Follower {
    let Follower { rigid, joint, load, roller } = follower;
    let [m, m_x] = match *joint {
        Joint::Rigid => [rigid.m, 0.0],
        Joint::Output(p, m_x) => [p.m, m_x],
        Joint::Shaft(p) => [p.m, 0.0],
        Joint::Backlash(p) => [p.m2, p.m1],
    };
    let known = |value: f64| (value != 0.0).then_some(value);
    let sum = |of: fn(&Load) -> f64| of(load) + of(roller);
    let load = Load {
        gravity: None,
        constant: known(load.constant_part(m) + roller.constant_part(m_x)),
        spring: known(sum(Load::stiffness)).map(|c| Spring { c, ..Spring::default() }),
        damping: known(sum(|load| load.damping.unwrap_or(0.0))),
        ..load.clone()
    };
    let rigid = rigid_machine::Follower { m: m + m_x, ..rigid.clone() };
    Follower { rigid, joint: Joint::Rigid, load, roller: Load::default() }
}

/// The train without each follower, its elasticity, its clearance, its loads; without loads and coupling of its shaft.
fn of_train(scene: &drive_train::Scene, add: &mut impl FnMut(&str, &str, &str, Value)) {
    for (j, follower) in scene.followers.iter().enumerate() {
        let of = format!(" of follower {}", j + 1);
        let mut fewer = scene.followers.clone();
        fewer.remove(j);
        add(&format!("follower {}", j + 1), "none", "/followers", json!(fewer));
        let mut instead = |feature: &str, instead: &str, other: Follower| {
            let mut simpler = scene.clone();
            // A rigid shaft takes its cam along.
            if let (Joint::Shaft(p), Joint::Rigid, Shaft::Free(machine)) =
                (follower.joint, other.joint, &mut simpler.shaft)
            {
                machine.inertia.constant += p.inertia;
            }
            simpler.followers[j] = other;
            add(&format!("{feature}{of}"), instead, "", json!(simpler));
        };
        let stiff = rigid_follower(follower);
        match follower.joint {
            Joint::Rigid => {}
            Joint::Output(..) | Joint::Shaft(_) => instead("the elasticity", "rigid", stiff),
            Joint::Backlash(p) => {
                if p.m2 > 0.0 {
                    let spring = elastic_output::Parameters { m: p.m2, c: p.c, b: p.b };
                    let held = Follower { joint: Joint::Output(spring, p.m1), ..follower.clone() };
                    instead("the clearance", "an elastic output that stays on its cam", held);
                }
                instead("clearance and elasticity", "rigid", stiff);
                if p.e > 0.0 {
                    let plastic = Joint::Backlash(backlash::Parameters { e: 0.0, ..p });
                    instead("the restitution", "e = 0", Follower { joint: plastic, ..follower.clone() });
                }
            }
        }
        let returns = matches!(follower.joint, Joint::Backlash(p) if p.s.is_infinite());
        let [load, roller] = [&follower.load, &follower.roller].map(unloaded);
        if !(returns || follower.load.is_none() && follower.roller.is_none()) {
            instead("the loads", "none", Follower { load, roller, ..follower.clone() });
        }
        let linkage = massless(&follower.rigid.linkage);
        if linkage != follower.rigid.linkage {
            let rigid = rigid_machine::Follower { linkage, ..follower.rigid.clone() };
            instead("the inertia of the links", "massless links", Follower { rigid, ..follower.clone() });
        }
    }
    let Shaft::Free(machine) = &scene.shaft else { return };
    let mut shaft =
        |feature: &str, instead: &str, other: Machine| add(feature, instead, "/shaft", json!(Shaft::Free(other)));
    if machine.load.is_some() {
        shaft("the load of the shaft", "none", Machine { load: None, ..machine.clone() });
    }
    if machine.friction.is_some() {
        shaft("the friction of the shaft", "none", Machine { friction: Some(0.0), ..machine.clone() });
    }
    let mut motor = machine.motor.clone();
    if motor.transmission.coupling.take().is_some() {
        shaft("the elasticity before the shaft", "a stiff transmission", Machine { motor, ..machine.clone() });
    }
}

/// A copy whose links have no mass.
pub fn massless(linkage: &Linkage) -> Linkage {
    let mut copy = linkage.clone();
    for mechanism in &mut copy.0 {
        for (i, parameter) in mechanism.parameters().into_iter().enumerate() {
            let is_mass = matches!(parameter.kind, ParameterKind::Mass | ParameterKind::Inertia);
            if let Some(value) = mechanism.parameter_mut(i).filter(|_| is_mass) {
                *value = 0.0;
            }
        }
    }
    copy
}

/// The mean of J over a turn.
fn mean(inertia: &Inertia) -> f64 {
    // The trapezoidal rule is exact for the harmonics below the number of points.
    let points = (8.0 * inertia.resolution()).clamp(256.0, 65536.0) as usize;
    let at = |i: usize| {
        let phi = (i as f64 + 0.5) * TAU / points as f64;
        inertia.at(Place::at(phi), phi)[0]
    };
    (0..points).map(at).sum::<f64>() / points as f64
}

/// A series without some of its harmonics.
#[derive(Clone, Debug, PartialEq)]
pub struct FewerHarmonics {
    /// The harmonics left out: "harmonic k = 5".
    pub feature: String,
    /// The remainder: "4 of 5 harmonics".
    pub instead: String,
    /// The rest.
    pub series: Fourier,
}

/// So many harmonics, the smallest ones, are left out one by one: the larger ones are what the law is made of.
const MOST_SINGLE: usize = 4;

/// A series without each of its smallest harmonics and without the smaller half of them; empty where it has less than two. A
/// harmonic counts by its share of U″, k²√(aₖ² + bₖ²), which is what moves masses.
pub fn fewer_harmonics(series: &Fourier) -> Vec<FewerHarmonics> {
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
        FewerHarmonics {
            feature: format!("{} k = {}", if dropped.len() == 1 { "harmonic" } else { "harmonics" }, listed(&dropped)),
            instead: format!("{} of {}", harmonics.len() - dropped.len(), counted(harmonics.len(), "harmonic")),
            series: Fourier::new(rest.a, rest.b),
        }
    };
    let singles = harmonics[..single].chunks(1);
    singles.chain((half > 1).then_some(&harmonics[..half])).map(without).collect()
}

/// Ascending numbers, three and more in a row as "4 … 9".
fn listed(numbers: &[usize]) -> String {
    let runs = numbers.chunk_by(|a, b| a + 1 == *b);
    let parts = runs.flat_map(|run| match run {
        [first, _, .., last] => vec![format!("{first} to {last}")],
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
        let series = Fourier::new(vec![5.0, 1.0, 0.0, 0.1, 0.05], vec![0.0, 0.0, 0.1]);
        let fewer = fewer_harmonics(&series);
        assert_eq!((fewer[0].feature.as_str(), fewer[0].instead.as_str()), ("harmonic k = 2", "3 of 4 harmonics"));
        let singles: Vec<&str> = fewer[..4].iter().map(|f| f.feature.as_str()).collect();
        assert_eq!(singles, ["harmonic k = 2", "harmonic k = 4", "harmonic k = 3", "harmonic k = 1"]);
        assert_eq!((fewer[4].feature.as_str(), fewer[4].instead.as_str()), ("harmonics k = 2, 4", "2 of 4 harmonics"));
        assert_eq!(fewer.len(), 5);
        let rest = &fewer[4].series;
        assert_eq!((rest.a.as_slice(), rest.b.as_slice()), (&[5.0, 1.0, 0.0, 0.1][..], &[0.0; 4][..]));
        for single in [vec![1.0, 2.0], vec![1.0]] {
            assert!(fewer_harmonics(&Fourier::new(single, vec![])).is_empty());
        }
    }

    #[test]
    fn numbers_in_a_row_are_told_by_their_ends() {
        assert_eq!(listed(&[1, 4, 5, 6, 8, 9]), "1, 4 to 6, 8, 9");
        assert_eq!((listed(&[7]).as_str(), listed(&[2, 3, 4, 5]).as_str()), ("7", "2 to 5"));
    }
}
