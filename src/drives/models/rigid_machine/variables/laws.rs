//! The parameters of laws and mechanisms as variables of the machine.

use super::super::RigidMachine;
use super::super::linkage::Mechanism;
use crate::drives::List;
use crate::drives::shaft::cam_drive::law_parameter_kind;
use crate::drives::unit;
use crate::drives::variable::real_within;
use crate::motion::MotionLaw;
use crate::motion::parameter::ParameterKind;
use crate::motion::plan::MOST_DERIVATIVE;
use std::sync::Arc;

/// The number of J_v among the laws; the followers' laws have their own.
pub(super) const INERTIA_LAW: usize = 0xffff;

fn law(d: &RigidMachine, number: usize) -> Option<&MotionLaw> {
    match number {
        INERTIA_LAW => d.shaft.inertia.function.varying.as_ref(),
        j => d.shaft.inertia.followers.get(j).map(|f| &f.cam),
    }
}

/// Declares the parameters of a law as `prefix.a[k]` …; the index holds the number of the parameter and, below, that of
/// the law.
pub(super) fn declare_law(
    list: &mut List<RigidMachine>,
    declared: &MotionLaw,
    number: usize,
    prefix: &str,
    moves_angle: bool,
) {
    for (k, parameter) in declared.parameters().into_iter().enumerate() {
        let kind = match parameter.kind {
            // The values of the inertia's own law are inertias, those of a cam that moves a lever angles.
            ParameterKind::Length if number == INERTIA_LAW => real_within(&unit::INERTIA, -1e12, 1e12),
            ParameterKind::Length if moves_angle => real_within(&unit::ANGLE, -1e4, 1e4),
            ParameterKind::Derivative(_) if number == INERTIA_LAW || moves_angle => {
                real_within(&unit::NUMBER, -MOST_DERIVATIVE, MOST_DERIVATIVE)
            }
            kind => law_parameter_kind(kind),
        };
        list.parameter(
            &format!("{prefix}.{}", parameter.name),
            &parameter.text,
            kind,
            |d, index| law(d, index & 0xffff).map_or(0.0, |law| law.parameter(index >> 16)),
            |d, index, value| {
                Arc::make_mut(&mut d.shaft.inertia).change(|function, followers| {
                    let law = match index & 0xffff {
                        INERTIA_LAW => function.varying.as_mut(),
                        j => followers.get_mut(j).map(|f| &mut f.cam),
                    };
                    if let Some(law) = law {
                        law.set_parameter(index >> 16, value);
                    }
                });
            },
        )
        .at(k << 16 | number);
    }
}

/// Declares the parameters of mechanism i of follower j; the index holds the number of the parameter and, below, i and j.
pub(super) fn declare_mechanism(list: &mut List<RigidMachine>, declared: &Mechanism, [j, i]: [usize; 2]) {
    for (k, parameter) in declared.parameters().into_iter().enumerate() {
        let [least, greatest] = parameter.kind.range();
        list.parameter(
            &format!("follower[{}].linkage[{}].{}", j + 1, i + 1, parameter.name()),
            &parameter.text(),
            real_within(parameter.kind.quantity(), least, greatest),
            |d, index| {
                let follower = d.shaft.inertia.followers.get(index & 0xffff);
                let mechanism = follower.and_then(|f| f.linkage.0.get(index >> 16 & 0xff).copied());
                mechanism.and_then(|mut m| m.parameter_mut(index >> 24).copied()).unwrap_or(0.0)
            },
            |d, index, value| {
                Arc::make_mut(&mut d.shaft.inertia).change(|_, followers| {
                    let mechanisms = followers.get_mut(index & 0xffff).map(|f| &mut f.linkage.0);
                    let mechanism = mechanisms.and_then(|list| list.get_mut(index >> 16 & 0xff));
                    if let Some(parameter) = mechanism.and_then(|m| m.parameter_mut(index >> 24)) {
                        *parameter = value;
                    }
                });
            },
        )
        .at(k << 24 | i << 16 | j);
    }
}
