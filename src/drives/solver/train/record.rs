//! The equations of a train on a tape, and the known series that they need about an instant.

use super::Excitation;
use crate::drives::follower::contact::{Flank, Mode};
use crate::drives::follower::joint::{Follower, Stand};
use crate::drives::shaft::angle_series::AngleSeries;
use crate::drives::shaft::cam_drive::DriveMode;
use crate::drives::shaft::train::{Functions, InputValues, MOST_FOLLOWERS, MOST_STATES, Modes, Point, Shaft, Train};
use crate::numerics::double_double::Double;
use crate::numerics::tape::{NONE, Tape, Var};
use std::cell::RefCell;
use std::f64::consts::TAU;

/// The most coefficients of a known series: three more than the highest order.
const COEFFICIENTS: usize = super::ORDERS[1] + 3;

/// The kinds of known series: functions of time …
#[derive(Clone, Copy, Debug, PartialEq)]
enum SeriesKind {
    Tau,
    Torque,
    Reference,
    Lag,
    Phi,
    W,
    A,
    Force(usize),
    /// … or of an angle.
    Inertia,
    HalfSlope,
    Static,
    Viscous,
    /// A derivative of U.
    Cam(usize, usize),
    Process(usize),
}

/// The tape, and the places of results on it.
#[derive(Clone, Debug, Default)]
pub struct Recording {
    pub tape: Tape,
    /// The kind of each of its known series.
    known: Vec<SeriesKind>,
    /// The modes of the recording; None before the first.
    modes: Option<Modes>,
    /// Places of results: of u of a servo, else ω_m; φ of a driven shaft; N and U′ N of each follower with backlash in contact.
    kept: Vec<usize>,
    /// The force of each contact at the speed 1 rad/s, as far as the law may accelerate it.
    forces: Vec<f64>,
}

/// Contact forces below this part of the largest that the law may need are rounding errors: their terms cancel near a release.
const RESOLUTION: f64 = 1e-12;

impl Recording {
    /// Forgets the recording after a change of the equations.
    pub fn forget(&mut self) {
        if self.modes.is_some() {
            self.modes = Some(Modes { saturation: i8::MAX, ..Modes::default() });
        }
    }

    /// u of a servo, else ω_m, as a series.
    pub fn demand(&self) -> &[f64] {
        self.tape.series(self.kept[0])
    }

    /// φ as a series.
    pub fn phi(&self) -> &[f64] {
        self.tape.series(if self.kept[1] == NONE { 0 } else { self.kept[1] })
    }

    /// N of a follower with backlash in contact, and U′ N, as series.
    pub fn normal(&self, j: usize) -> [&[f64]; 2] {
        [2 + 2 * j, 3 + 2 * j].map(|place| self.tape.series(self.kept[place]))
    }

    /// The force below which N of a follower counts as zero (N), at the speed `w`; before a recording 0.
    pub fn resolution(&self, j: usize, w: f64) -> f64 {
        RESOLUTION * self.forces.get(j).map_or(0.0, |force| force * w * w)
    }

    /// Whether it holds the equations of these modes.
    pub fn holds(&self, modes: &Modes) -> bool {
        self.modes.as_ref().is_some_and(|own| {
            let same = |(own, stand): (&Stand, &Stand)| own.contact == stand.contact && own.beyond == stand.beyond;
            let stands = own.stands.iter().zip(&modes.stands).take(self.forces.len());
            own.saturation == modes.saturation && own.piece == modes.piece && stands.into_iter().all(same)
        })
    }

    /// Records the equations for series up to this order, unless it already holds those of these modes.
    pub fn prepare(&mut self, train: &Train, modes: &Modes, order: usize) {
        if self.holds(modes) {
            return;
        }
        if self.modes.is_none() {
            let force = |Follower { joint, rigid, .. }: &Follower| {
                joint.clearance().map_or(0.0, |p| (p.m1 + p.m2) * rigid.cam.bound(2))
            };
            self.forces = train.followers.iter().map(force).collect();
        }
        // A step must not allocate: recording both cases of each contact shows the largest size.
        if self.modes.is_none() && train.switches() {
            let mut other = *modes;
            for stand in &mut other.stands {
                stand.contact = if stand.is_held() { Mode::Free } else { Mode::Contact(Flank::A) };
            }
            self.record(train, &other, order);
            self.record(train, modes, order);
            self.tape.make_room();
            self.known.reserve_exact(self.known.capacity());
        }
        self.record(train, modes, order);
        self.modes = Some(*modes);
    }

    fn record(&mut self, train: &Train, modes: &Modes, order: usize) {
        let mut tape = std::mem::take(&mut self.tape);
        tape.begin(train.layout.count, order);
        self.known.clear();
        let tape = RefCell::new(tape);
        self.write(train, modes, &tape);
        self.tape = tape.into_inner();
        self.tape.finish(&mut self.kept);
    }

    // Out of line: its many numbers need not stay on the stack after a recording.
    #[inline(never)]
    fn write(&mut self, train: &Train, modes: &Modes, tape: &RefCell<Tape>) {
        let zero = Var::from(0.0);
        let mut y = [zero; MOST_STATES];
        y.iter_mut().enumerate().take(train.layout.count).for_each(|(k, y)| *y = Var::state(tape, k));
        let machine = train.machine();
        let mut row = |what: SeriesKind| {
            self.known.push(what);
            tape.borrow_mut().new_row()
        };
        let mut input_if = |needed: bool, what: SeriesKind| if needed { Var::signal(tape, row(what)) } else { zero };
        let driven = machine.is_none();
        let phi = if driven { input_if(true, SeriesKind::Phi) } else { y[0] };
        let accelerates = matches!(train.shaft, Shaft::Driven(DriveMode::Input | DriveMode::Speed { .. }));
        let mut input_values = InputValues {
            shaft: [input_if(driven, SeriesKind::W), input_if(accelerates, SeriesKind::A)],
            tau: input_if(machine.is_some_and(|m| !m.loads.is_empty()), SeriesKind::Tau),
            torque: input_if(machine.is_some_and(|m| m.motor.takes_torque()), SeriesKind::Torque),
            reference: input_if(machine.is_some_and(|m| m.motor.servo().is_some()), SeriesKind::Reference),
            lag: zero,
            forces: [zero; MOST_FOLLOWERS],
        };
        if let Some(machine) = machine.filter(|m| m.motor.takes_position()) {
            input_values.lag = input_if(true, SeriesKind::Lag) - machine.motor.angle(phi, &y, &train.layout);
        }
        for (j, follower) in train.followers.iter().enumerate() {
            input_values.forces[j] = input_if(follower.load.input, SeriesKind::Force(j));
        }
        let varies = Varying::of(train, modes);
        let any_of_phi = varies.inertia || varies.torque || train.needs_cams_at_phi();
        let powers = if any_of_phi { phi.powers(tape) } else { 0 };
        let mut function = |powers: usize, wanted: bool, what: SeriesKind, otherwise: f64| {
            if wanted { Var::function(tape, powers, row(what)) } else { Var::from(otherwise) }
        };
        let mut f = Functions {
            inertia: function(powers, varies.inertia, SeriesKind::Inertia, train.constant_inertia()),
            half_slope: function(powers, varies.inertia, SeriesKind::HalfSlope, 0.0),
            torque: function(powers, varies.torque, SeriesKind::Static, 0.0),
            viscous: function(powers, varies.viscous, SeriesKind::Viscous, train.constant_friction()),
            cams: [[zero; 3]; MOST_FOLLOWERS],
            process: [zero; MOST_FOLLOWERS],
        };
        for (j, follower) in train.followers.iter().enumerate() {
            let rigid = follower.joint.states() == 0;
            if rigid && !follower.load.input {
                continue;
            }
            let own =
                if follower.joint.carries_cam() { (phi + y[train.layout.followers[j]]).powers(tape) } else { powers };
            let wanted = [!rigid, true, !rigid];
            f.cams[j] = [0, 1, 2].map(|order| function(own, wanted[order], SeriesKind::Cam(j, order), 0.0));
            f.process[j] = function(powers, follower.load.process.is_some() && !rigid, SeriesKind::Process(j), 0.0);
        }
        let d = train.dynamics(&Point { modes, y: &y, f: &f, input_values: &input_values });
        d.rates[..train.layout.count].iter().for_each(|rate| rate.is_rate(tape));
        self.kept.clear();
        self.kept.resize(2 + 2 * train.followers.len(), NONE);
        let events = machine.is_some_and(|m| m.motor.servo().is_some() || m.motor.table().is_some());
        self.kept[0] = if events { d.demand.place(tape) } else { NONE };
        self.kept[1] = if driven { phi.place(tape) } else { NONE };
        for (j, ..) in train.clearances().filter(|(j, ..)| modes.stands[*j].is_held()) {
            let normal = d.followers[j].normal;
            self.kept[2 + 2 * j] = normal.place(tape);
            self.kept[3 + 2 * j] = (normal * f.cams[j][1]).place(tape);
        }
    }

    /// Fills the known series about an instant.
    pub fn fill(&mut self, train: &Train, modes: &Modes, excitation: &Excitation, about: &About) {
        let About { time, angles, turns, order, unit } = *about;
        let Recording { tape, known, .. } = self;
        let count = order + 3;
        let slope = |from: &[f64], into: &mut [f64], factor: f64| {
            (1..count).for_each(|n| into[n - 1] = factor * n as f64 * from[n]);
            into[count - 1] = 0.0;
        };
        let bend = |from: &[f64], into: &mut [f64], factor: f64| {
            (2..count).for_each(|n| into[n - 2] = factor * (n * (n - 1)) as f64 * from[n]);
            into[count - 2..].fill(0.0);
        };
        let sums = train.functions::<COEFFICIENTS>(modes, angles, count, |j, cam, process| {
            for (row, what) in known.iter().enumerate() {
                match *what {
                    SeriesKind::Cam(of, 0) if of == j => tape.row(row, count).copy_from_slice(&cam[..count]),
                    SeriesKind::Cam(of, 1) if of == j => slope(cam, tape.row(row, count), 1.0),
                    SeriesKind::Cam(of, _) if of == j => bend(cam, tape.row(row, count), 1.0),
                    SeriesKind::Process(of) if of == j => tape.row(row, count).copy_from_slice(&process[..count]),
                    _ => {}
                }
            }
        });
        let since = (time - Double::from(excitation.time)).hi;
        let mut angle = [0.0; COEFFICIENTS];
        if let Some(motion) = excitation.motion {
            let series = AngleSeries::of(motion, time).scaled(unit);
            angle[..series.len()].copy_from_slice(&series);
        }
        let motor = train.machine().map(|machine| &machine.motor);
        for (row, what) in known.iter().enumerate() {
            let row = tape.row(row, count);
            match *what {
                SeriesKind::Inertia => row.copy_from_slice(&sums.inertia[..count]),
                SeriesKind::HalfSlope => slope(&sums.inertia, row, 0.5),
                SeriesKind::Static => row.copy_from_slice(&sums.torque[..count]),
                SeriesKind::Viscous => row.copy_from_slice(&sums.viscous[..count]),
                SeriesKind::Tau => excitation.inputs.loads.expand(since, unit, row),
                SeriesKind::Torque => excitation.inputs.torque.expand(since, unit, row),
                SeriesKind::Force(j) => excitation.inputs.forces[j].expand(since, unit, row),
                SeriesKind::Reference => {
                    if let Some(servo) = motor.and_then(|motor| motor.servo()) {
                        servo.expand_reference(time.hi, unit, (&excitation.inputs.reference, since), row);
                    }
                }
                SeriesKind::Lag => {
                    excitation.inputs.position.expand(since, unit, row);
                    row[0] -= motor.map_or(0.0, |motor| motor.transmission.ratio) * turns * TAU;
                }
                SeriesKind::Phi => row.copy_from_slice(&angle[..count]),
                SeriesKind::W => slope(&angle, row, 1.0 / unit),
                SeriesKind::A => bend(&angle, row, 1.0 / (unit * unit)),
                SeriesKind::Cam(..) | SeriesKind::Process(_) => {}
            }
        }
    }
}

/// The instant about which series are taken.
pub struct About<'a> {
    /// The instant.
    pub time: Double,
    /// The angles there, reduced to one turn.
    pub angles: &'a [f64],
    /// The whole turns of φ.
    pub turns: f64,
    /// The order of the series.
    pub order: usize,
    /// The unit of time (s).
    pub unit: f64,
}

/// The sums over the followers that depend on the angle.
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
        for (follower, stand) in train.followers.iter().zip(&modes.stands) {
            varies.inertia |= !follower.rigid.linkage.is_empty();
            for mass in follower.carried(stand) {
                varies.inertia |= mass.m != 0.0;
                varies.torque |= !mass.load.is_none();
                varies.viscous |= mass.load.damping.is_some();
            }
        }
        varies
    }
}
