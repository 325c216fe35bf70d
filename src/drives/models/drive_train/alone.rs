//! Outputs that are read alone: one that is made of a few states and the motion of its cam costs no more than these.
//!
//! How an output is made of them follows from its own equation, run on [`Form`]s. What is computed from a form has the digits of
//! the equation, since it is the same arithmetic.

use super::{DriveTrain, variables};
use crate::drives::follower::joint::{MOST, Motion};
use crate::drives::shaft::train::{Dynamics, Functions, InputValues, MOST_FOLLOWERS, MOST_STATES};
use crate::drives::solver::train::{Place, RECORDINGS};
use crate::numerics::taylor::{Arithmetic, Scalar};
use std::f64::consts::TAU;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// The most steps of a form: U + (home + z) + q.
const LONGEST: usize = 7;

/// What an equation computes: states, constants and motions of cams, added and multiplied in the order of these steps. Forms that
/// need more are not known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Form {
    /// States by their numbers, then the steps below.
    steps: [u8; LONGEST],
    /// How many there are; 0 if the form is not known.
    count: u8,
    /// The only constant.
    constant: f64,
}

/// U and U′ of each follower.
const CAM: u8 = MOST_STATES as u8;
const WHOLE: u8 = CAM + 2 * MOST_FOLLOWERS as u8;
const SPEED: u8 = WHOLE + 1;
const CONSTANT: u8 = WHOLE + 2;
const ADD: u8 = WHOLE + 3;
const MULTIPLY: u8 = WHOLE + 4;

/// The forms of all outputs for some contacts of the followers; None if they are not found yet.
#[derive(Clone, Debug, Default)]
struct Forms {
    contacts: Option<u64>,
    outputs: Vec<Form>,
}

/// The forms of late.
#[derive(Clone, Debug, Default)]
pub struct FormCache {
    forms: [Forms; RECORDINGS],
    present: usize,
    /// The followers with clearance.
    gaps: Vec<usize>,
    /// The place in the step at which states were last read, and its powers.
    place: Place,
}

impl Form {
    const UNKNOWN: Self = Form { steps: [0; LONGEST], count: 0, constant: 0.0 };

    fn of(step: u8) -> Self {
        let mut form = Form { count: 1, ..Form::UNKNOWN };
        form.steps[0] = step;
        form
    }

    fn steps(&self) -> &[u8] {
        &self.steps[..self.count.into()]
    }

    /// Whether it depends on the motion; mere constants are counts, which go on without the equations.
    fn moves(&self) -> bool {
        self.steps().iter().any(|step| *step < CONSTANT)
    }

    fn with(self, o: Self, step: u8) -> Self {
        let count = self.count + o.count + 1;
        let [own, other] = [self, o].map(|form| form.steps().contains(&CONSTANT));
        let clash = own && other && self.constant != o.constant;
        if self.count == 0 || o.count == 0 || usize::from(count) > LONGEST || clash {
            return Form::UNKNOWN;
        }
        let mut form = Form { count, constant: if own { self.constant } else { o.constant }, ..self };
        form.steps[usize::from(self.count)..][..o.count.into()].copy_from_slice(o.steps());
        form.steps[usize::from(count) - 1] = step;
        form
    }
}

impl From<f64> for Form {
    fn from(constant: f64) -> Self {
        Form { constant, ..Form::of(CONSTANT) }
    }
}

impl Arithmetic for Form {}

impl Scalar for Form {
    const ORDER: usize = 0;
    fn compose(self, _: [f64; 3]) -> Self {
        Form::UNKNOWN
    }
    fn value(self) -> f64 {
        f64::NAN
    }
}

impl Add for Form {
    type Output = Self;
    fn add(self, o: Self) -> Self {
        self.with(o, ADD)
    }
}

impl Mul for Form {
    type Output = Self;
    fn mul(self, o: Self) -> Self {
        self.with(o, MULTIPLY)
    }
}

impl Sub for Form {
    type Output = Self;
    fn sub(self, _: Self) -> Self {
        Form::UNKNOWN
    }
}

impl Div for Form {
    type Output = Self;
    fn div(self, _: Self) -> Self {
        Form::UNKNOWN
    }
}

impl Neg for Form {
    type Output = Self;
    fn neg(self) -> Self {
        Form::UNKNOWN
    }
}

impl Mul<f64> for Form {
    type Output = Self;
    fn mul(self, _: f64) -> Self {
        Form::UNKNOWN
    }
}

impl DriveTrain {
    /// Forgets all forms after a change of the equations, and finds the present ones.
    pub(super) fn find_all_forms(&mut self) {
        self.forms.gaps.clear();
        self.forms.gaps.extend(self.train.clearances().map(|(j, ..)| j));
        let count = if self.forms.gaps.is_empty() { 1 } else { RECORDINGS };
        self.forms.forms.iter_mut().for_each(|forms| forms.contacts = None);
        (0..count).for_each(|_| self.find_forms());
    }

    /// Finds the forms of all outputs. Not inlined, so that it takes no room in the stack frame of a reading.
    #[inline(never)]
    fn find_forms(&mut self) {
        let unknown = Form::UNKNOWN;
        let free = self.machine().is_some();
        let mut y = [unknown; MOST_STATES];
        y.iter_mut().enumerate().take(self.train.layout.count).for_each(|(k, y)| *y = Form::of(k as u8));
        let mut f = Functions {
            inertia: unknown,
            half_slope: unknown,
            torque: unknown,
            viscous: unknown,
            cams: [[unknown; 3]; MOST_FOLLOWERS],
            process: [unknown; MOST_FOLLOWERS],
        };
        for (j, _) in self.train.followers.iter().enumerate().filter(|(_, f)| f.rigid.linkage.is_empty()) {
            f.cams[j] = [Form::of(CAM + 2 * j as u8), Form::of(CAM + 2 * j as u8 + 1), unknown];
        }
        let input_values = InputValues {
            shaft: [unknown; 2],
            tau: unknown,
            torque: unknown,
            reference: unknown,
            lag: unknown,
            forces: [unknown; MOST_FOLLOWERS],
        };
        let w = if free { y[1] } else { Form::of(SPEED) };
        let phi = if free { y[0] } else { unknown };
        let point =
            variables::Point { phi, w, y, input_values, f, whole: Form::of(WHOLE), turns: f64::NAN, counted: false };
        self.forms.present = (self.forms.present + 1) % RECORDINGS;
        let mut outputs = std::mem::take(&mut self.forms.forms[self.forms.present].outputs);
        outputs.clear();
        // What follows from accelerations is not read alone.
        let motion = Motion { rates: [unknown; MOST], accelerations: [unknown; 2], normal: unknown };
        let motion = Dynamics {
            a: unknown,
            torque: unknown,
            demand: unknown,
            rates: [unknown; MOST_STATES],
            spring: [unknown; MOST_FOLLOWERS],
            followers: [motion; MOST_FOLLOWERS],
            rotor: unknown,
        };
        variables::outputs_of(self, &point, &motion, &mut |_, _, form| outputs.push(form));
        // A constant that changes by itself is not part of a form.
        let known = |form: &&mut Form| !form.moves() || form.constant.is_nan();
        outputs.iter_mut().filter(known).for_each(|form| *form = unknown);
        let contacts = Some(self.run.modes.contacts(self.forms.gaps.iter().copied()));
        self.forms.forms[self.forms.present] = Forms { contacts, outputs };
    }

    /// The output in this place, if its form is known.
    pub(super) fn alone(&mut self, output: usize) -> Option<f64> {
        let FormCache { forms, present, gaps, .. } = &mut self.forms;
        let contacts = Some(self.run.modes.contacts(gaps.iter().copied()));
        if forms[*present].contacts != contacts {
            match forms.iter().position(|forms| forms.contacts == contacts) {
                Some(found) => *present = found,
                None => self.find_forms(),
            }
        }
        let form = *self.forms.forms[self.forms.present].outputs.get(output.checked_sub(variables::FIRST)?)?;
        self.forms.place.move_to(self.run.theta_at(self.time));
        let state = |k: usize| self.run.state(k, &self.forms.place);
        // No form has more than four numbers at a time.
        let (mut stack, mut top) = ([0.0; LONGEST], 0);
        for step in form.steps() {
            match *step {
                ADD | MULTIPLY => {
                    let [a, b] = [stack[top - 2], stack[top - 1]];
                    top -= 1;
                    stack[top - 1] = if *step == ADD { a + b } else { a * b };
                    continue;
                }
                CONSTANT => stack[top] = form.constant,
                SPEED => stack[top] = self.motion.map_or(f64::NAN, |motion| motion.at(self.time).kinematics.0[1]),
                WHOLE => {
                    let free = || state(0) + self.run.turns * TAU;
                    stack[top] = self.motion.map_or_else(free, |motion| motion.angle(self.time));
                }
                number if number < CAM => stack[top] = state(number.into()),
                cam => {
                    let [j, order] = [(cam - CAM) / 2, (cam - CAM) % 2].map(usize::from);
                    let phi = self.motion.map_or_else(|| state(0), |motion| motion.at(self.time).reduced);
                    stack[top] = self.train.cam(&self.run.modes, j, phi, state)[order];
                }
            }
            top += 1;
        }
        (top == 1).then_some(stack[0])
    }
}
