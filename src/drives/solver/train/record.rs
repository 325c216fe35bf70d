//! The equations of a train on a tape, and the known series that they need about an instant.

use super::Outside;
use crate::drives::follower::contact::Mode;
use crate::drives::follower::load::Load;
use crate::drives::follower::member::Joint;
use crate::drives::shaft::train::{Functions, Given, MOST_FOLLOWERS, MOST_STATES, Modes, Shaft, Train};
use crate::numerics::double_double::Double;
use crate::numerics::tape::{COEFFICIENTS, Row, Tape, Var};
use std::cell::RefCell;

/// Rows of the known series: functions of time …
const TAU: usize = 0;
const TORQUE: usize = 1;
const REFERENCE: usize = 2;
const LAG: usize = 3;
pub(super) const PHI: usize = 4;
const W: usize = 5;
const A: usize = 6;
const FORCES: usize = 7;
/// … and of angles.
const INERTIA: usize = FORCES + MOST_FOLLOWERS;
const HALF_SLOPE: usize = INERTIA + 1;
const STATIC: usize = INERTIA + 2;
const VISCOUS: usize = INERTIA + 3;
const CAMS: usize = INERTIA + 4;
const PROCESS: usize = CAMS + 3 * MOST_FOLLOWERS;
const ROWS: usize = PROCESS + MOST_FOLLOWERS;

/// The tape, and where on it things are.
#[derive(Clone, Debug, Default)]
pub struct Recorded {
    pub tape: Tape,
    /// For which modes it was recorded; None before.
    modes: Option<Modes>,
    /// u of a servo, else ω_m.
    pub demand: usize,
    /// N of followers with backlash in contact, and U′ N.
    pub normals: [usize; MOST_FOLLOWERS],
    pub torques: [usize; MOST_FOLLOWERS],
}

impl Recorded {
    /// The equations have changed.
    pub fn forget(&mut self) {
        if self.modes.is_some() {
            self.modes = Some(Modes { saturation: i8::MAX, ..Modes::default() });
        }
    }

    /// Records the equations unless it holds those of these modes.
    pub fn prepare(&mut self, train: &Train, modes: &Modes) {
        let plain = Modes { segments: Default::default(), zeros: Default::default(), ..*modes };
        if self.modes == Some(plain) {
            return;
        }
        let first = self.modes.is_none();
        self.modes = Some(plain);
        let mut tape = std::mem::take(&mut self.tape);
        tape.begin(train.layout.count, ROWS);
        if first {
            tape.reserve(64 + 64 * train.followers.len(), 1 + train.followers.len());
        }
        let tape = RefCell::new(tape);
        self.record(train, modes, &tape);
        self.tape = tape.into_inner();
    }

    fn record(&mut self, train: &Train, modes: &Modes, tape: &RefCell<Tape>) {
        let zero = Var::from(0.0);
        let mut y = [zero; MOST_STATES];
        y.iter_mut().enumerate().take(train.layout.count).for_each(|(k, y)| *y = Var::state(tape, k));
        let machine = train.machine();
        let given_if = |needed: bool, row: usize| if needed { Var::given(tape, row) } else { zero };
        let driven = machine.is_none();
        let phi = if driven { Var::given(tape, PHI) } else { y[0] };
        let accelerates = matches!(train.shaft, Shaft::Driven(crate::drives::shaft::cam_drive::DriveMode::Input));
        let mut given = Given {
            course: [given_if(driven, W), given_if(accelerates, A)],
            tau: given_if(machine.is_some_and(|m| m.input), TAU),
            torque: given_if(machine.is_some_and(|m| m.motor.takes_torque()), TORQUE),
            reference: given_if(machine.is_some_and(|m| m.motor.servo().is_some()), REFERENCE),
            lag: zero,
            forces: [zero; MOST_FOLLOWERS],
        };
        if let Some(machine) = machine.filter(|m| m.motor.takes_position()) {
            given.lag = Var::given(tape, LAG) - machine.motor.angle(&y, &train.layout);
        }
        for (j, follower) in train.followers.iter().enumerate() {
            given.forces[j] = given_if(follower.load.input, FORCES + j);
        }
        let varies = Varying::of(train, modes);
        let any_of_phi = varies.inertia || varies.torque || train.needs_cams_at_phi();
        let powers = if any_of_phi { phi.powers(tape) } else { 0 };
        let row =
            |powers: usize, wanted: bool, row: usize| if wanted { Var::function(tape, powers, row) } else { zero };
        let mut f = Functions {
            inertia: if varies.inertia { row(powers, true, INERTIA) } else { Var::from(train.constant_inertia()) },
            half_slope: row(powers, varies.inertia, HALF_SLOPE),
            torque: row(powers, varies.torque, STATIC),
            viscous: if varies.viscous { row(powers, true, VISCOUS) } else { Var::from(train.constant_friction()) },
            cams: [[zero; 3]; MOST_FOLLOWERS],
            process: [zero; MOST_FOLLOWERS],
        };
        for (j, follower) in train.followers.iter().enumerate() {
            let rigid = follower.joint == Joint::Rigid;
            if rigid && !follower.load.input {
                continue;
            }
            let own = if let Joint::Shaft(_) = follower.joint {
                (phi + y[train.layout.followers[j]]).powers(tape)
            } else {
                powers
            };
            let place = follower.load.spring.is_some() || follower.roller.spring.is_some();
            let wanted = [place && !rigid, true, !rigid];
            f.cams[j] = [0, 1, 2].map(|order| row(own, wanted[order], CAMS + 3 * j + order));
            f.process[j] = row(powers, follower.load.process.is_some() && !rigid, PROCESS + j);
        }
        let d = train.dynamics(modes, &y, &f, &given);
        d.rates[..train.layout.count].iter().for_each(|rate| rate.is_rate(tape));
        self.demand = d.demand.place(tape);
        for (j, follower) in train.followers.iter().enumerate() {
            if let (Joint::Backlash(_), Mode::Contact(_)) = (follower.joint, modes.contacts[j]) {
                self.normals[j] = d.normal[j].place(tape);
                self.torques[j] = (d.normal[j] * f.cams[j][1]).place(tape);
            }
        }
    }

    /// Fills the known series about the instant `time`, at which the angles are these, with `order` + 3 coefficients.
    pub fn fill(
        &mut self,
        train: &Train,
        modes: &Modes,
        (time, angles, turns): (Double, &[f64], f64),
        outside: &Outside,
        (order, unit): (usize, f64),
    ) {
        let rows = &mut self.tape.rows;
        let count = (order + 3).min(COEFFICIENTS);
        let local = train.local::<COEFFICIENTS>(modes, angles, count);
        let slope = |from: &Row, into: &mut Row, factor: f64| {
            (1..count).for_each(|n| into[n - 1] = factor * n as f64 * from[n]);
        };
        (rows[INERTIA], rows[STATIC], rows[VISCOUS]) = (local.inertia, local.torque, local.viscous);
        slope(&local.inertia, &mut rows[HALF_SLOPE], 0.5);
        for j in 0..train.followers.len() {
            rows[CAMS + 3 * j] = local.cams[j];
            let (first, rest) = rows[CAMS + 3 * j + 1..].split_at_mut(1);
            slope(&local.cams[j], &mut first[0], 1.0);
            slope(&first[0], &mut rest[0], 1.0);
            rows[PROCESS + j] = local.process[j];
        }
        let since = (time - Double::from(outside.time)).hi;
        let mut put = |row: usize, signal: &crate::drives::shaft::free::signal::Signal| {
            signal.expand(since, unit, &mut rows[row]);
        };
        put(TAU, &outside.inputs.tau);
        put(TORQUE, &outside.inputs.torque);
        for (j, _) in train.followers.iter().enumerate().filter(|(_, f)| f.load.input) {
            put(FORCES + j, &outside.inputs.forces[j]);
        }
        if let Some(machine) = train.machine() {
            if let Some(servo) = machine.motor.servo() {
                servo.expand_reference(
                    time.hi,
                    unit,
                    (&outside.inputs.reference, since),
                    &mut rows[REFERENCE][..count],
                );
                if machine.motor.takes_position() {
                    outside.inputs.position.expand(since, unit, &mut rows[LAG]);
                    rows[LAG][0] -= machine.motor.transmission.ratio * turns * std::f64::consts::TAU;
                }
            }
        } else if let Some(motion) = outside.motion {
            let course = crate::drives::shaft::course::Course::of(motion, time).scaled(unit);
            rows[PHI][..course.len()].copy_from_slice(&course);
            let (mut w, mut a) = ([0.0; COEFFICIENTS], [0.0; COEFFICIENTS]);
            slope(&rows[PHI], &mut w, 1.0 / unit);
            slope(&w, &mut a, 1.0 / unit);
            (rows[W], rows[A]) = (w, a);
        }
    }
}

/// Which sums over the followers depend on the angle.
struct Varying {
    inertia: bool,
    torque: bool,
    viscous: bool,
}

impl Varying {
    fn of(train: &Train, modes: &Modes) -> Self {
        let mut varies = Varying { inertia: false, torque: false, viscous: false };
        if let Some(machine) = train.machine() {
            (varies.inertia, varies.torque) = (machine.inertia.varying.is_some(), machine.load.is_some());
        }
        for (follower, contact) in train.followers.iter().zip(&modes.contacts) {
            let held = *contact != Mode::Free;
            let (mass, loads): (f64, [Option<&Load>; 2]) = match follower.joint {
                Joint::Rigid => (follower.rigid.m, [Some(&follower.load), None]),
                Joint::Output(_, m_x) => (m_x, [Some(&follower.roller), None]),
                Joint::Backlash(p) if held => (p.m1, [Some(&follower.roller), (p.m2 == 0.0).then_some(&follower.load)]),
                _ => (0.0, [None; 2]),
            };
            varies.inertia |= mass != 0.0 || !follower.rigid.linkage.is_empty();
            for load in loads.into_iter().flatten().filter(|load| !load.is_none()) {
                varies.torque = true;
                varies.viscous |= load.damping.is_some();
            }
        }
        varies
    }
}
