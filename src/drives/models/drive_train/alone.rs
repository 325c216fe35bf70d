//! Outputs that are read alone: one that is a sum of states and of the motion of its cam costs no more than these.
//!
//! Which outputs are such sums is found by their own equations: in random states, in all ways of contact and at both limits of a
//! servo, the sum has the same digits.

use super::dependencies::{Random, STATES};
use super::{DriveTrain, variables};
use crate::drives::shaft::train::Modes;
use crate::numerics::angle;
use crate::numerics::double_double::Double;
use std::f64::consts::TAU;

/// base + (home + y) + y: the base U or U′φ̇ of a follower, φ with its turns or φ̇ of the shaft; home is where a gap is counted from.
#[derive(Clone, Copy)]
pub struct Form {
    follower: Option<u8>,
    base: Option<u8>,
    states: [Option<u8>; 2],
}

impl Form {
    fn value(&self, base: impl Fn(usize) -> f64, home: f64, y: impl Fn(usize) -> f64) -> f64 {
        let sum = self.base.map_or(0.0, |order| base(order.into()));
        let sum = self.states[0].map_or(sum, |k| sum + (home + y(k.into())));
        self.states[1].map_or(sum, |k| sum + y(k.into()))
    }
}

impl DriveTrain {
    /// Finds the forms of all outputs.
    pub(super) fn find_forms(&mut self) {
        let (mut random, mut samples) = (Random(1), Vec::new());
        for sample in 0..STATES {
            let mut probe = self.copied();
            probe.disturb(sample, &mut random);
            let mut point = Box::new(probe.point());
            let cams = point.f.cams.as_flattened_mut().iter_mut();
            cams.chain([&mut point.whole]).for_each(|value| *value = random.next());
            point.w = if self.machine().is_some() { point.w } else { random.next() };
            let mut outputs = Vec::new();
            variables::outputs(&probe, &point, &mut |seat, _, value| outputs.push((seat.follower, value)));
            samples.push((point, probe.run.modes, outputs));
        }
        let fits = |form: &Form, i: usize| {
            samples.iter().all(|(p, modes, outputs)| {
                let follower = outputs[i].0;
                let bases = follower.map_or([p.whole, p.w], |j| [p.f.cams[j][0], p.f.cams[j][1] * p.w]);
                form.value(|order| bases[order], self.home(modes, follower), |k| p.y[k]) == outputs[i].1
            })
        };
        let find = |(i, (follower, _)): (usize, &(Option<usize>, f64))| {
            let of_shaft = (0, if self.machine().is_some() { 2 } else { 0 });
            let (begin, count) =
                follower.map_or(of_shaft, |j| (self.train.layout.followers[j], self.train.followers[j].joint.states()));
            let own = || std::iter::once(None).chain((begin..begin + count).map(|k| Some(k as u8)));
            let states = || own().flat_map(|second| own().map(move |first| [first, second]));
            let follower = follower.map(|j| j as u8);
            let mut all =
                states().flat_map(|states| [None, Some(0), Some(1)].map(|base| Form { follower, base, states }));
            // Counts are zero in all samples.
            all.find(|form| (form.base.is_some() || form.states != [None; 2]) && fits(form, i))
        };
        self.forms = samples[0].2.iter().enumerate().map(find).collect();
    }

    /// Where the gap of a follower is counted from.
    fn home(&self, modes: &Modes, follower: Option<usize>) -> f64 {
        follower.and_then(|j| Some(modes.stands[j].home(self.train.clearance(j)?.s))).unwrap_or(0.0)
    }

    /// The output in this place, where it is such a sum.
    pub(super) fn alone(&self, place: usize) -> Option<f64> {
        let form = (*self.forms.get(place.checked_sub(variables::FIRST)?)?)?;
        let follower = form.follower.map(usize::from);
        let theta = self.run.theta_at(self.time);
        let y = |k: usize| self.run.state(k, theta);
        let motion = self.motion.as_ref().filter(|_| form.base.is_some()).map(|motion| (motion, motion.at(self.time)));
        let w = || motion.as_ref().map_or_else(|| y(1), |(_, at)| at.kinematics.0[1]);
        let base = |order: usize| match (follower, order) {
            (None, 0) => {
                motion.as_ref().map_or_else(|| y(0) + self.run.turns * TAU, |(motion, _)| motion.angle(self.time))
            }
            (None, _) => w(),
            (Some(j), _) => {
                let (follower, phi) =
                    (&self.train.followers[j], motion.as_ref().map_or_else(|| y(0), |(_, at)| at.reduced));
                let twist = if follower.joint.carries_cam() { y(self.train.layout.followers[j]) } else { 0.0 };
                let psi = angle::reduce(Double::from(phi) + Double::from(twist));
                follower.rigid.cam.at_in(self.run.modes.segments[1 + j][0], psi).0[order]
                    * if order > 0 { w() } else { 1.0 }
            }
        };
        let bare = follower.is_none_or(|j| form.base.is_none() || self.train.followers[j].rigid.linkage.is_empty());
        bare.then(|| form.value(base, self.home(&self.run.modes, follower), y))
    }
}
