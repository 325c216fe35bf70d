//! The drive with one of its features left out, to measure the change and the saving.
//!
//! A feature is left out by another scene of the same model or, in its rigid limit ([`super::rigid`]), by formulas: a stiffness
//! that is merely large would neither be rigid nor cheap.

use super::rigid::{self, Formula};
use super::run::Interface;
use crate::host::Fmu;
use crate::resource::{Resource, Scene};
use crate::text::counted;
use camdrive::drives::Fault;
use camdrive::drives::backlash;
use camdrive::drives::drive_train::{self, Follower, Joint, Machine, Shaft};
use camdrive::drives::elastic_output;
use camdrive::drives::follower::load::{Load, Spring};
use camdrive::drives::parametric::{self, law::CrankLaw, law::Law};
use camdrive::drives::rigid_machine::linkage::{Linkage, ParameterKind};
use camdrive::drives::rigid_machine::{self, Inertia, InertiaFunction, Motor, Place};
use camdrive::drives::shaft::cam_drive::{DriveMode, StartMode};
use camdrive::drives::shaft::cam_turn::turns;
use camdrive::drives::shaft::motor::Source;
use camdrive::motion::{Fourier, MotionLaw};
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
    /// The FMU of another scene of the same model with its interface, unless the drive refuses it.
    Scene(Result<(Fmu, Interface), Fault>),
    /// Formulas for the outputs.
    Formula(Formula),
}

/// A feature, its replacement, and the change of a scene that leaves it out; a scene without the feature stays unchanged.
type Neutral = (&'static str, &'static str, fn(&mut Scene));

/// Features that a changed value leaves out.
const NEUTRAL: [Neutral; 7] = [
    ("the clearance", "s = 0", |scene| {
        if let Scene::BacklashDrive(scene) = scene {
            scene.parameters.s = 0.0;
        }
    }),
    ("restitution", "e = 0", |scene| {
        if let Scene::BacklashDrive(scene) = scene {
            scene.parameters.e = 0.0;
        }
    }),
    ("the nonlinearity of the shaft", "linear in the twist", |scene| {
        if let Scene::ElasticShaft(scene) = scene {
            scene.linear = true;
        }
    }),
    ("the lag of the motor", "quasi-static torque", |scene| match scene {
        Scene::RigidMachine(rigid_machine::Scene { motor: Motor::Kloss(kloss), .. }) => kloss.dynamics = None,
        Scene::DriveTrain(drive_train::Scene { shaft: Shaft::Free(machine), .. }) => {
            if let Source::Kloss(kloss) = &mut machine.motor.source {
                kloss.dynamics = None;
            }
        }
        _ => {}
    }),
    ("damping", "b = 0", |scene| match scene {
        Scene::ElasticOutput(scene) => scene.parameters.b = 0.0,
        Scene::ElasticShaft(scene) => scene.parameters.b = 0.0,
        Scene::BacklashDrive(scene) => scene.parameters.b = 0.0,
        Scene::ParametricDrive(parametric::Scene { law: Law::Series(law), .. }) => {
            law.b = Fourier::new(vec![0.0], Vec::new());
        }
        _ => {}
    }),
    ("damping", "b_T = 0", |scene| {
        if let Scene::ParametricDrive(parametric::Scene { law: Law::Crank(law), .. }) = scene {
            law.damping = 0.0;
        }
    }),
    ("the loads", "none", |scene| match scene {
        Scene::ElasticOutput(scene) => scene.load = unloaded(&scene.load),
        Scene::ElasticShaft(scene) => scene.load = unloaded(&scene.load),
        Scene::ParametricDrive(scene) => scene.load = unloaded(&scene.load),
        _ => {}
    }),
];

/// The series of a scene, and the names of the quantities they describe.
fn series(scene: &mut Scene) -> Vec<(String, &mut Fourier)> {
    let of = |j: usize| format!(" of follower {}", j + 1);
    let cams: Vec<(String, &mut MotionLaw)> = match scene {
        Scene::ElasticOutput(scene) => vec![(String::new(), &mut scene.cam)],
        Scene::ElasticShaft(scene) => vec![(String::new(), &mut scene.cam)],
        Scene::BacklashDrive(scene) => vec![(String::new(), &mut scene.cam)],
        Scene::ParametricDrive(parametric::Scene { law: Law::Series(law), .. }) => {
            let all =
                [(" of the mass", &mut law.m), (" of the damping", &mut law.b), (" of the stiffness", &mut law.c)];
            return all.map(|(of, series)| (of.to_owned(), series)).into();
        }
        Scene::ParametricDrive(_) => Vec::new(),
        Scene::RigidMachine(scene) => {
            scene.followers.iter_mut().enumerate().map(|(j, follower)| (of(j), &mut follower.cam)).collect()
        }
        Scene::DriveTrain(scene) => {
            scene.followers.iter_mut().enumerate().map(|(j, follower)| (of(j), &mut follower.rigid.cam)).collect()
        }
    };
    cams.into_iter()
        .filter_map(|(of, cam)| if let MotionLaw::Fourier(series) = cam { Some((of, series)) } else { None })
        .collect()
}

/// The harmonics of c_T that a simpler crank keeps: its mean alone, the first one, the first two.
const HARMONICS: [(usize, &str, &str); 3] = [
    (0, "the variation of the stiffness", "its mean"),
    (2, "harmonics of the stiffness above 2", "its mean and its harmonic 2"),
    (4, "harmonics of the stiffness above 4", "its mean and its harmonics 2 and 4"),
];

/// The scene without each of its features; the names of the outputs stay.
pub fn of(resource: &Resource) -> Vec<Simplification> {
    let scene = &resource.scene;
    let rigid = rigid::of(scene).map(|(feature, instead, formula)| Simplification {
        feature: feature.to_owned(),
        instead: instead.to_owned(),
        model: Simplified::Formula(formula),
    });
    let mut list: Vec<Simplification> = rigid.into_iter().collect();
    let mut add = |feature: &str, instead: &str, simpler: Scene| {
        let left_out = feature.strip_prefix("follower ").and_then(|number| number.parse().ok());
        let resource = Resource { scene: simpler, ..resource.clone() };
        let interface = Interface::of(&resource).map(|interface| renumbered(interface, left_out));
        let model = Simplified::Scene(interface.and_then(|interface| Ok((Fmu::linked(&resource)?, interface))));
        list.push(Simplification { feature: feature.to_owned(), instead: instead.to_owned(), model });
    };
    for (feature, instead, leave_out) in NEUTRAL {
        let mut simpler = scene.clone();
        leave_out(&mut simpler);
        if simpler != *scene {
            add(feature, instead, simpler);
        }
    }
    if let Scene::ParametricDrive(own @ parametric::Scene { law: Law::Crank(law), .. }) = scene {
        for (order, feature, instead) in HARMONICS {
            if law.harmonics.is_none_or(|own| order < own) {
                let law = Law::Crank(CrankLaw { harmonics: Some(order), ..law.clone() });
                add(feature, instead, parametric::Scene { law, ..own.clone() }.into());
            }
        }
    }
    if let Some(steady) = steady(scene) {
        add("the transient", "start on the periodic motion", steady);
    }
    match scene {
        Scene::RigidMachine(scene) => of_machine(scene, &mut add),
        Scene::DriveTrain(scene) => of_train(scene, &mut add),
        _ => {}
    }
    for (i, (of, own)) in series(&mut scene.clone()).into_iter().enumerate() {
        let mut with = |feature: &str, instead: &str, other: Fourier| {
            let mut simpler = scene.clone();
            *series(&mut simpler)[i].1 = other;
            add(&format!("{feature}{of}"), instead, simpler);
        };
        if matches!(scene, Scene::ParametricDrive(_)) && own.bound(1) > 0.0 {
            with("the variation", "its mean", Fourier::new(vec![own.a[0]], Vec::new()));
        }
        for fewer in fewer_harmonics(own) {
            with(&fewer.feature, &fewer.instead, fewer.series);
        }
    }
    list
}

/// The scene on its periodic motion, if it has one and does not start there. A drive with backlash starts in permanent contact.
fn steady(scene: &Scene) -> Option<Scene> {
    let mut steady = scene.clone();
    let constant = |drive: &DriveMode| matches!(drive, DriveMode::Constant { w, .. } if turns(*w));
    match &mut steady {
        Scene::ElasticOutput(scene) if constant(&scene.drive) => scene.start.mode = StartMode::SteadyState,
        Scene::ElasticShaft(scene) if constant(&scene.drive) => scene.start.mode = StartMode::SteadyState,
        Scene::ParametricDrive(scene) if constant(&scene.drive) => scene.start.mode = StartMode::SteadyState,
        Scene::DriveTrain(scene) => scene.start = drive_train::Start::SteadyState,
        _ => {}
    }
    (steady != *scene).then_some(steady)
}

/// The same number of loads without effect, so that the outputs stay.
fn unloaded(load: &Load) -> Load {
    let [gravity, constant, damping] = [load.gravity, load.constant, load.damping].map(|part| part.map(|_| 0.0));
    let process = load.process.as_ref().map(|_| MotionLaw::Fourier(Fourier::new(vec![0.0], Vec::new())));
    let frames = vec![[0.0; 2]; load.frames.len()];
    Load { gravity, frames, constant, damping, process, spring: load.spring.map(|_| Spring::default()), ..load.clone() }
}

/// The machine with its mean inertia, and with massless links.
fn of_machine(scene: &rigid_machine::Scene, add: &mut impl FnMut(&str, &str, Scene)) {
    let inertia = Inertia::new(scene.inertia.clone(), scene.followers.clone());
    if inertia.varies() {
        let constant = InertiaFunction { constant: mean(&inertia), varying: None };
        let scene = rigid_machine::Scene { inertia: constant, followers: Vec::new(), ..scene.clone() };
        add("the variation of the inertia", "constant mean J, no followers", scene.into());
    }
    let mut followers = scene.followers.clone();
    for follower in &mut followers {
        follower.linkage = massless(&follower.linkage);
    }
    if followers != scene.followers {
        add("the inertia of the links", "massless links", rigid_machine::Scene { followers, ..scene.clone() }.into());
    }
}

/// The arrays of a train over its followers; only trains named as a RigidMachine have the last two.
const ARRAYS: [&str; 3] = ["follower[", "U[", "lever["];

/// The followers after follower `left_out` keep their numbers.
fn renumbered(mut interface: Interface, left_out: Option<usize>) -> Interface {
    for variable in interface.variables.iter_mut().filter(|_| left_out.is_some()) {
        let parted = |array: &&'static str| Some((*array, variable.name.split_once(*array)?));
        let Some((array, (before, rest))) = ARRAYS.iter().find_map(parted) else { continue };
        let Some((number, rest)) = rest.split_once(']') else { continue };
        let number = number.parse().map_or(0, |number: usize| number + usize::from(Some(number) >= left_out));
        variable.name = format!("{before}{array}{number}]{rest}");
    }
    interface
}

/// The follower without spring and clearance, with one mass; the loads on both act on it.
fn rigid_follower(follower: &Follower) -> Follower {
    let Follower { rigid, load, roller, .. } = follower;
    let [m, m_x] = follower.masses();
    // Without a second mass both loads act on the only one.
    let tool = if m > 0.0 { m } else { m_x };
    let known = |value: f64| (value != 0.0).then_some(value);
    let sum = |of: fn(&Load) -> f64| of(load) + of(roller);
    let load = Load {
        gravity: None,
        constant: known(load.constant_part(tool) + roller.constant_part(m_x)),
        spring: known(sum(Load::stiffness)).map(|c| Spring { c, ..Spring::default() }),
        damping: known(sum(|load| load.damping.unwrap_or(0.0))),
        ..load.clone()
    };
    let rigid = rigid_machine::Follower { m: m + m_x, ..rigid.clone() };
    Follower { rigid, joint: Joint::Rigid, load, roller: Load::default() }
}

/// The train without each follower, its elasticity, its clearance, its loads; without loads and coupling of its shaft.
fn of_train(scene: &drive_train::Scene, add: &mut impl FnMut(&str, &str, Scene)) {
    for (j, follower) in scene.followers.iter().enumerate() {
        let of = format!(" of follower {}", j + 1);
        let mut fewer = scene.followers.clone();
        fewer.remove(j);
        // On a driven shaft the others would not notice.
        if matches!(scene.shaft, Shaft::Free(_)) {
            add(
                &format!("follower {}", j + 1),
                "none",
                drive_train::Scene { followers: fewer, ..scene.clone() }.into(),
            );
        }
        let mut instead = |feature: &str, instead: &str, other: Follower| {
            let mut simpler = scene.clone();
            // A rigid shaft takes its cam along.
            if let (Joint::Shaft(p), Joint::Rigid, Shaft::Free(machine)) =
                (follower.joint, other.joint, &mut simpler.shaft)
            {
                machine.inertia.constant += p.inertia;
            }
            simpler.followers[j] = other;
            add(&format!("{feature}{of}"), instead, simpler.into());
        };
        let stiff = rigid_follower(follower);
        let clearance = follower.joint.clearance();
        if let Some(p) = clearance {
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
        } else if follower.joint.states() > 0 {
            instead("the elasticity", "rigid", stiff);
        }
        let returns = clearance.is_some_and(|p| p.s.is_infinite());
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
    let mut shaft = |feature: &str, instead: &str, other: Machine| {
        add(feature, instead, drive_train::Scene { shaft: Shaft::Free(other), ..scene.clone() }.into());
    };
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
    /// The remainder.
    pub series: Fourier,
}

/// This many harmonics, the smallest ones, are left out one by one: the larger ones make up the law.
const MOST_SINGLE: usize = 4;

/// A series without each of its smallest harmonics and without the smaller half of them; empty if it has less than two. A
/// harmonic counts by its share of U″, k²√(aₖ² + bₖ²), which moves masses.
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

/// Ascending numbers, three and more in a row as "4 to 9".
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
