//! The variables of loads: parameters by name, and the input F, declared alike for every drive.

use super::cam_drive::law_parameter_kind;
use super::free::signal::Signal;
use crate::drives::follower::load::Load;
use crate::drives::unit::{self, Quantity};
use crate::drives::variable::{Variability, real_within};
use crate::drives::{About, Event, EventLog, List, Variable};
use crate::motion::MotionLaw;
use crate::motion::parameter::ParameterKind;
use crate::motion::plan::{LARGEST, MAX_LENGTH, MOST_DERIVATIVE};

/// A drive with loads, numbered as it likes.
pub trait HasLoads {
    /// The load of this number.
    fn load(&self, which: usize) -> Option<&Load>;
    /// The same, to change it.
    fn load_mut(&mut self, which: usize) -> Option<&mut Load>;
    /// The input F of the load of this number.
    fn signal(&self, _which: usize) -> Option<&Signal> {
        None
    }
    /// The same, to change it.
    fn signal_mut(&mut self, _which: usize) -> Option<&mut Signal> {
        None
    }
}

/// Logs once that a follower pulls its cam at `time` (s): `forces` are the force of the loads that hold it there and the contact
/// force; the follower has a number in a train, else 0.
pub fn log_pull(logged: &mut bool, forces: [f64; 2], time: f64, follower: usize, log: &mut EventLog) {
    let [held, force] = forces;
    if *logged || !(held * force > 0.0) {
        return;
    }
    *logged = true;
    let kind = match follower {
        0 => {
            "the contact force changes its sign: a follower that only its loads hold on the cam lifts off; to simulate that \
             use a BacklashDrive with s = \"inf\""
        }
        _ => {
            "the contact force changes its sign: a follower that only its loads hold on the cam lifts off; to simulate that \
             use [follower.backlash] with s = \"inf\""
        }
    };
    log.push(Event { time, kind, quantity: "contact_force", value: force, unit: "N", follower, about: About::Loads });
}

/// A parameter: key, text, quantity for a translating and for a rotating follower, range.
type Number = (&'static str, &'static str, [&'static Quantity; 2], [f64; 2]);

// A force is a value of a law. The ranges of spring and damper are those of a drive, of a place those of a lift; gravity reaches
// the fastest centrifuges.
const FORCE: [&Quantity; 2] = [&unit::FORCE, &unit::TORQUE];
const NUMBERS: [Number; 6] = [
    ("g", "Gravity along y", [&unit::ACCELERATION, &unit::ANGULAR_ACCELERATION], [-1e7, 1e7]),
    ("F0", "Constant force, positive in the sense of y", FORCE, [-LARGEST, LARGEST]),
    ("preload", "Force of the return spring at `at`, positive against y", FORCE, [-LARGEST, LARGEST]),
    ("c", "Stiffness of the return spring", [&unit::STIFFNESS, &unit::ROTATIONAL_STIFFNESS], [0.0, 1e24]),
    (
        "at",
        "Position in which the return spring has its preload",
        [&unit::LENGTH, &unit::ANGLE],
        [-MAX_LENGTH, MAX_LENGTH],
    ),
    ("b", "Damping to the ground", [&unit::DAMPING, &unit::ROTATIONAL_DAMPING], [0.0, 1e24]),
];

/// The value of this one of [`NUMBERS`], if the scene contains it.
fn number(load: &mut Load, which: usize) -> Option<&mut f64> {
    match which {
        0 => load.gravity.as_mut(),
        1 => load.constant.as_mut(),
        2 => load.spring.as_mut().map(|spring| &mut spring.preload),
        3 => load.spring.as_mut().map(|spring| &mut spring.c),
        4 => load.spring.as_mut().map(|spring| &mut spring.at),
        _ => load.damping.as_mut(),
    }
}

/// The number of the first parameter of the process force among those of a load.
const PROCESS: usize = NUMBERS.len();

fn get<D: HasLoads>(drive: &D, index: usize) -> f64 {
    let (which, parameter) = (index & 0xff, index >> 8);
    let Some(load) = drive.load(which) else { return 0.0 };
    let Load { gravity, constant, spring, damping, process, .. } = load;
    let spring = spring.unwrap_or_default();
    let numbers = [*gravity, *constant, Some(spring.preload), Some(spring.c), Some(spring.at), *damping];
    match numbers.get(parameter) {
        Some(number) => number.unwrap_or(0.0),
        None => process.as_ref().map_or(0.0, |law| law.parameter(parameter - PROCESS)),
    }
}

fn set<D: HasLoads>(drive: &mut D, index: usize, value: f64) {
    let (which, parameter) = (index & 0xff, index >> 8);
    let Some(load) = drive.load_mut(which) else { return };
    if parameter >= PROCESS {
        load.process.iter_mut().for_each(|law| law.set_parameter(parameter - PROCESS, value));
    } else if let Some(number) = number(load, parameter) {
        *number = value;
    }
}

/// Declares the parameters of the load `which` < 256 as `name.g` …, each if the scene contains it, and its process force's as
/// `name.process.a[0]` …; `turns` if its mass turns.
pub fn declare_load<D: HasLoads>(list: &mut List<D>, drive: &D, which: usize, name: &str, turns: bool) {
    let Some(mut load) = drive.load(which).cloned() else { return };
    let mut declare = |name: &str, text: &str, kind, parameter: usize| {
        let declared = list.parameter(name, text, kind, get::<D>, set::<D>).at(parameter << 8 | which);
        declared.description.variability = Variability::Tunable;
    };
    for (i, (key, text, quantities, [least, greatest])) in NUMBERS.into_iter().enumerate() {
        if number(&mut load, i).is_some() {
            let kind = real_within(quantities[usize::from(turns)], least, greatest);
            declare(&format!("{name}.{key}"), text, kind, i);
        }
    }
    for (k, parameter) in load.process.iter().flat_map(MotionLaw::parameters).enumerate() {
        let kind = match parameter.kind {
            ParameterKind::Length => real_within(FORCE[usize::from(turns)], -LARGEST, LARGEST),
            // By the angle, which is a pure number.
            ParameterKind::Derivative(_) => real_within(&unit::NUMBER, -MOST_DERIVATIVE, MOST_DERIVATIVE),
            kind => law_parameter_kind(kind),
        };
        let text = parameter.text.replace("position function", "process force");
        declare(&format!("{name}.process.{}", parameter.name), &text, kind, PROCESS + k);
    }
}

/// Declares the input of the load `which`, if it has one.
pub fn declare_force<'a, D: HasLoads>(
    list: &'a mut List<D>,
    drive: &D,
    which: usize,
    name: &str,
    turns: bool,
) -> Option<&'a mut Variable<D>> {
    drive.load(which).filter(|load| load.input)?;
    let text = "Load on the follower, positive in the sense of y";
    let kind = real_within(FORCE[usize::from(turns)], -LARGEST, LARGEST);
    let input = list.input(
        name,
        text,
        kind,
        |drive, which| drive.signal(which).map_or(0.0, Signal::set_value),
        |drive, which, order, value| drive.signal_mut(which).into_iter().for_each(|s| s.set_derivative(order, value)),
    );
    Some(input.at(which))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::drives::follower::load::Spring;
    use crate::drives::variable::Kind;
    use crate::motion::{Cycle, CyclePlan, Fourier, StandardLaw};

    struct Two([Load; 2], Signal);

    impl HasLoads for Two {
        fn load(&self, which: usize) -> Option<&Load> {
            self.0.get(which)
        }
        fn load_mut(&mut self, which: usize) -> Option<&mut Load> {
            self.0.get_mut(which)
        }
        fn signal(&self, which: usize) -> Option<&Signal> {
            (which == 1).then_some(&self.1)
        }
        fn signal_mut(&mut self, which: usize) -> Option<&mut Signal> {
            (which == 1).then_some(&mut self.1)
        }
    }

    #[test]
    fn each_parameter_that_the_scene_names_is_a_variable_of_its_own() {
        let plan = CyclePlan {
            stroke: 90e3,
            lower: 0.0,
            rise_start: 0.0,
            rise_angle: 1.0,
            upper_dwell: 1.0,
            return_angle: 1.0,
            rise_law: StandardLaw::Polynomial345,
            return_law: StandardLaw::Polynomial345,
            inflections: [None; 2],
        };
        let light = Load { gravity: Some(-9.81), process: Some(MotionLaw::Cycle(Cycle::new(plan))), ..Load::default() };
        let full = Load {
            constant: Some(3.0),
            spring: Some(Spring { preload: 40.0, c: 3e3, at: 0.01 }),
            damping: Some(15.0),
            process: Some(MotionLaw::Fourier(Fourier::new(vec![0.0, 20.0], vec![0.0, 7.0]))),
            input: true,
            ..Load::default()
        };
        let mut drive = Two([light, full], Signal::default());
        let mut list = List::default();
        assert!(declare_force(&mut list, &drive, 0, "follower[1].F", false).is_none());
        declare_force(&mut list, &drive, 1, "follower[2].F", true).unwrap();
        declare_load(&mut list, &drive, 0, "follower[1].load", false);
        declare_load(&mut list, &drive, 1, "follower[2].load.roller", true);
        declare_load(&mut list, &drive, 2, "follower[3].load", true);
        let names: Vec<&str> = list.0.iter().map(|v| v.description.name.as_str()).collect();
        let roller = ["F0", "preload", "c", "at", "b", "process.a[0]", "process.a[1]", "process.b[1]"];
        let roller = roller.map(|name| format!("follower[2].load.roller.{name}"));
        assert_eq!(
            names[..4],
            [
                "follower[2].F",
                "follower[1].load.g",
                "follower[1].load.process.stroke",
                "follower[1].load.process.lower"
            ]
        );
        assert_eq!(names[names.len() - 8..], roller);
        for (i, variable) in list.0.iter().enumerate() {
            let before: Vec<f64> =
                list.0.iter().map(|v| v.access.get(&drive, v.index).expect("all can be set")).collect();
            // Angles of the cycle can change by this; laws by their number cannot.
            let value = if variable.description.kind == law_parameter_kind(ParameterKind::Law) {
                2.0
            } else {
                0.75 + 1e-3 * i as f64
            };
            variable.access.set(&mut drive, variable.index, value);
            assert_eq!(variable.access.get(&drive, variable.index), Some(value), "{}", names[i]);
            for (j, other) in list.0.iter().enumerate().filter(|(j, _)| *j != i) {
                let after = other.access.get(&drive, other.index);
                assert_eq!(after, Some(before[j]), "{} changes {}", names[i], names[j]);
            }
        }
        let quantity = |name: &str| match list.0[list.reference(name).unwrap()].description.kind {
            Kind::Real { quantity, max, .. } => (quantity.unit, max),
            _ => unreachable!("a Real"),
        };
        assert_eq!(quantity("follower[1].load.process.stroke"), ("N", 1e12));
        assert_eq!(quantity("follower[2].load.roller.process.b[1]"), ("N.m", 1e12));
        assert_eq!([quantity("follower[2].load.roller.at").0, quantity("follower[2].F").0], ["rad", "N.m"]);
        let tunable = |v: &Variable<Two>| v.description.variability == Variability::Tunable;
        assert!(list.0[1..].iter().all(tunable));
    }
}
