//! The parameters of laws and mechanisms as variables, declared alike for every machine.

use super::cam_drive::law_parameter_kind;
use crate::drives::List;
use crate::drives::follower::rigid::Follower;
use crate::drives::unit;
use crate::drives::variable::real_within;
use crate::motion::MotionLaw;
use crate::motion::parameter::ParameterKind;
use crate::motion::plan::MOST_DERIVATIVE;

/// The number of J_v among the laws; the followers' laws come before.
pub const INERTIA_LAW: usize = 0xffff;
/// The number of M_L.
pub const LOAD_LAW: usize = 0xfffe;

/// A machine with laws and followers, numbered from 0.
pub trait HasLaws {
    /// The law of this number.
    fn law(&self, number: usize) -> Option<&MotionLaw>;
    /// Changes the law of this number.
    fn change_law(&mut self, number: usize, change: impl FnMut(&mut MotionLaw));
    /// The follower of this number.
    fn follower(&self, number: usize) -> Option<&Follower>;
    /// Changes the follower of this number.
    fn change_follower(&mut self, number: usize, change: impl FnMut(&mut Follower));
}

/// Declares the parameters of the law of this number as `prefix.a[k]` …; the index holds the number of the parameter and, in its
/// lower bits, the number of the law.
pub fn declare_law<D: HasLaws>(list: &mut List<D>, drive: &D, number: usize, prefix: &str) {
    let angular = drive.follower(number).is_some_and(Follower::cam_turns);
    for (k, parameter) in drive.law(number).into_iter().flat_map(MotionLaw::parameters).enumerate() {
        let kind = match parameter.kind {
            // Values of the machine's own laws are inertias and torques; of a cam that moves a lever they are angles.
            ParameterKind::Length if number == INERTIA_LAW => real_within(&unit::INERTIA, -1e12, 1e12),
            ParameterKind::Length if number == LOAD_LAW => real_within(&unit::TORQUE, -1e12, 1e12),
            ParameterKind::Length if angular => real_within(&unit::ANGLE, -1e4, 1e4),
            ParameterKind::Derivative(_) if angular || number >= LOAD_LAW => {
                real_within(&unit::NUMBER, -MOST_DERIVATIVE, MOST_DERIVATIVE)
            }
            kind => law_parameter_kind(kind),
        };
        list.parameter(
            &format!("{prefix}.{}", parameter.name),
            &parameter.text,
            kind,
            |d, index| d.law(index & 0xffff).map_or(0.0, |law| law.parameter(index >> 16)),
            |d, index, value| d.change_law(index & 0xffff, |law| law.set_parameter(index >> 16, value)),
        )
        .at(k << 16 | number);
    }
}

/// Declares the parameters of the mechanisms of follower j; the index holds the number of the parameter and, in its lower bits, the
/// numbers of the mechanism and of the follower.
pub fn declare_mechanisms<D: HasLaws>(list: &mut List<D>, drive: &D, j: usize) {
    let mechanisms = drive.follower(j).map_or(&[][..], |follower| &follower.linkage.0);
    for (i, mechanism) in mechanisms.iter().enumerate() {
        for (k, parameter) in mechanism.parameters().into_iter().enumerate() {
            let [least, greatest] = parameter.kind.range();
            list.parameter(
                &format!("follower[{}].linkage[{}].{}", j + 1, i + 1, parameter.name()),
                &parameter.text(),
                real_within(parameter.kind.quantity(), least, greatest),
                |d, index| {
                    let mechanism =
                        d.follower(index & 0xffff).and_then(|f| f.linkage.0.get(index >> 16 & 0xff).copied());
                    mechanism.and_then(|mut m| m.parameter_mut(index >> 24).copied()).unwrap_or(0.0)
                },
                |d, index, value| {
                    d.change_follower(index & 0xffff, |follower| {
                        let mechanism = follower.linkage.0.get_mut(index >> 16 & 0xff);
                        if let Some(parameter) = mechanism.and_then(|m| m.parameter_mut(index >> 24)) {
                            *parameter = value;
                        }
                    });
                },
            )
            .at(k << 24 | i << 16 | j);
        }
    }
}
