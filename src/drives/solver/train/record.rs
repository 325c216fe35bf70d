//! The equations of a train on a tape, and the known series that they need about an instant.

use super::Excitation;
use crate::drives::follower::contact::{Flank, Mode};
use crate::drives::follower::joint::Follower;
use crate::drives::shaft::angle_series::AngleSeries;
use crate::drives::shaft::cam_drive::DriveMode;
use crate::drives::shaft::train::{Functions, InputValues, MOST_FOLLOWERS, MOST_STATES, Modes, Point, Shaft, Train};
use crate::numerics::double_double::Double;
use crate::numerics::program::{Expansion, Program, Sorter, resize};
use crate::numerics::tape::{NONE, Tape, Var};
use std::cell::RefCell;
use std::f64::consts::TAU;

/// The most coefficients of a known series: three more than the highest order, in whole packs, and two zeros for its derivatives.
const COEFFICIENTS: usize = (super::ORDERS[1] + 3).next_multiple_of(4) + 2;

/// So many recordings are kept: m1 on one flank or the other, and in flight from either.
pub const RECORDINGS: usize = 4;

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

impl SeriesKind {
    /// The class of its series: those of all followers are alike.
    fn class(self) -> usize {
        match self {
            SeriesKind::Tau => 0,
            SeriesKind::Torque => 1,
            SeriesKind::Reference => 2,
            SeriesKind::Lag => 3,
            SeriesKind::Phi => 4,
            SeriesKind::W => 5,
            SeriesKind::A => 6,
            SeriesKind::Force(_) => 7,
            SeriesKind::Inertia => 8,
            SeriesKind::HalfSlope => 9,
            SeriesKind::Static => 10,
            SeriesKind::Viscous => 11,
            SeriesKind::Process(_) => 12,
            SeriesKind::Cam(_, order) => 13 + order,
        }
    }

    /// Whether it is a function of the angle of one follower.
    fn is_of_follower(self) -> bool {
        matches!(self, SeriesKind::Cam(..) | SeriesKind::Process(_))
    }

    /// Whether it is an input, or the motion of a driven shaft itself.
    fn is_input(self) -> bool {
        self.class() <= SeriesKind::Phi.class() || self.class() == SeriesKind::Force(0).class()
    }
}

/// The contacts of the followers, the limit at which a servo is, the piece of a torque table.
type Key = (u64, i8, usize);

/// The equations in some modes.
#[derive(Clone, Debug, Default)]
struct Equations {
    /// Its modes; None before it is recorded.
    of: Option<Key>,
    program: Program,
    /// The kind of each known series, and for those of functions of the angle their rows: U, U′, U″, P of each follower; [`NONE`]
    /// if nothing needs them.
    known: Vec<SeriesKind>,
    of_followers: Vec<[usize; 4]>,
    /// Numbers of results: of u of a servo, else ω_m; φ of a driven shaft; N and U′ N of each follower with backlash in contact.
    kept: Vec<usize>,
}

/// The equations in the modes of late, and the series by those of the present ones.
#[derive(Clone, Debug, Default)]
pub struct Recording {
    equations: Vec<Equations>,
    /// The present ones.
    present: usize,
    expansion: Expansion,
    tape: Tape,
    sorter: Sorter,
    /// The force of each contact at the speed 1 rad/s, as far as the law may accelerate it.
    forces: Vec<f64>,
}

/// Contact forces below this part of the largest that the law may need are rounding errors: their terms cancel near a release.
const RESOLUTION: f64 = 1e-12;

impl Recording {
    /// Forgets the recordings after a change of the equations.
    pub fn forget(&mut self) {
        self.equations.iter_mut().for_each(|equations| equations.of = None);
    }

    /// A state as a series.
    pub fn series(&self, state: usize) -> &[f64] {
        self.expansion.series(state)
    }

    fn kept(&self, which: usize) -> usize {
        self.equations[self.present].kept[which]
    }

    /// u of a servo, else ω_m, as a series.
    pub fn demand(&self) -> &[f64] {
        self.series(self.kept(0))
    }

    /// φ as a series.
    pub fn phi(&self) -> &[f64] {
        let kept = self.kept(1);
        self.series(if kept == NONE { 0 } else { kept })
    }

    /// N of a follower with backlash in contact, and U′ N, as series.
    pub fn normal(&self, j: usize) -> [&[f64]; 2] {
        [2 + 2 * j, 3 + 2 * j].map(|which| self.series(self.kept(which)))
    }

    /// Computes the series from these states.
    pub fn expand(&mut self, states: impl Iterator<Item = f64>, order: usize, unit: f64) {
        let program = self.set(states);
        self.expansion.expand(&self.equations[program].program, order, unit);
    }

    /// The same from states close by.
    pub fn expand_close_by(&mut self, states: impl Iterator<Item = f64>, order: usize, unit: f64) {
        let program = self.set(states);
        self.expansion.expand_close_by(&self.equations[program].program, order, unit);
    }

    /// Sets the states; returns the number of the program.
    fn set(&mut self, states: impl Iterator<Item = f64>) -> usize {
        let program = &self.equations[self.present].program;
        states.enumerate().for_each(|(k, state)| self.expansion.set(program, k, state));
        self.present
    }

    /// The force below which N of a follower counts as zero (N), at the speed `w`; before a recording 0.
    pub fn resolution(&self, j: usize, w: f64) -> f64 {
        RESOLUTION * self.forces.get(j).map_or(0.0, |force| force * w * w)
    }

    /// Whether the present equations are those of these modes.
    pub fn holds(&self, modes: &Modes) -> bool {
        self.equations.get(self.present).is_some_and(|equations| equations.of == Some(self.key(modes)))
    }

    /// What the equations in these modes depend on.
    fn key(&self, modes: &Modes) -> Key {
        (modes.contacts(0..self.forces.len()), modes.saturation, modes.piece)
    }

    /// Makes the equations of these modes the present ones, for series up to this order.
    pub fn prepare(&mut self, train: &Train, modes: &Modes, order: usize) {
        if self.holds(modes) {
            return;
        }
        if self.equations.is_empty() {
            self.make_room(train, modes, order);
        }
        if let Some(known) = self.equations.iter().position(|equations| equations.of == Some(self.key(modes))) {
            self.present = known;
            return;
        }
        self.present = (self.present + 1) % self.equations.len();
        self.record(train, modes, order);
        self.equations[self.present].of = Some(self.key(modes));
    }

    /// A step must not allocate: recording both cases of each contact shows the largest size.
    fn make_room(&mut self, train: &Train, modes: &Modes, order: usize) {
        let force = |Follower { joint, rigid, .. }: &Follower| {
            joint.clearance().map_or(0.0, |p| (p.m1 + p.m2) * rigid.cam.bound(2))
        };
        self.forces = train.followers.iter().map(force).collect();
        self.equations = vec![Equations::default()];
        if !train.switches() {
            return;
        }
        let mut other = *modes;
        for stand in &mut other.stands {
            stand.contact = if stand.is_held() { Mode::Free } else { Mode::Contact(Flank::A) };
        }
        self.equations = vec![Equations::default(); 2];
        for (which, modes) in [&other, modes].into_iter().enumerate() {
            self.present = which;
            self.record(train, modes, order);
            self.equations[which].of = Some(self.key(modes));
        }
        // Several contacts, or a motor with modes, have more cases than these two.
        let motor = train.machine().map(|machine| &machine.motor);
        let modes = motor.is_some_and(|motor| motor.servo().is_some() || motor.table().is_some());
        let times = if modes || train.clearances().count() > 1 { 2 } else { 1 };
        self.tape.make_room(times);
        self.sorter.make_room(times);
        let [first, second] = [0, 1].map(|which: usize| self.equations[which].sizes());
        let most = |i: usize| times * first.0[i].max(second.0[i]);
        let own = |i: usize| times * first.1[i].max(second.1[i]);
        let sizes = (std::array::from_fn(most), std::array::from_fn(own));
        self.equations.resize(RECORDINGS, Equations::default());
        self.equations.iter_mut().for_each(|equations| equations.make_room(sizes));
    }

    fn record(&mut self, train: &Train, modes: &Modes, order: usize) {
        let Recording { equations, present, expansion, tape, sorter, .. } = self;
        let equations = &mut equations[*present];
        // States of one kind have one class: those of the shaft are alone, those of followers count from the last one.
        let of_followers = train.layout.followers.first().copied().unwrap_or(train.layout.count);
        let followers = train.followers.iter().flat_map(|follower| (0..follower.joint.states()).rev());
        tape.begin((MOST_STATES..).take(of_followers).chain(followers));
        let shared = RefCell::new(std::mem::take(tape));
        equations.write(train, modes, &shared);
        *tape = shared.into_inner();
        equations.compile(train, order, tape, sorter);
        expansion.make_room(&equations.program);
    }

    /// Fills the known series about an instant.
    pub fn fill(&mut self, train: &Train, modes: &Modes, excitation: &Excitation, about: &About) {
        self.equations[self.present].fill(train, modes, excitation, about, &mut self.expansion);
    }
}

impl Equations {
    /// How many elements its lists have: first those of the program.
    fn sizes(&self) -> ([usize; 7], [usize; 3]) {
        (self.program.sizes(), [self.known.len(), self.kept.len(), self.of_followers.len()])
    }

    /// Makes room for lists of so many elements.
    fn make_room(&mut self, (program, own): ([usize; 7], [usize; 3])) {
        self.program.make_room(program);
        resize(&mut self.known, own[0]);
        resize(&mut self.kept, own[1]);
        resize(&mut self.of_followers, own[2]);
    }

    /// Not inlined, so that it takes no room in the stack frame of a recording.
    #[inline(never)]
    fn compile(&mut self, train: &Train, order: usize, tape: &Tape, sorter: &mut Sorter) {
        self.program.compile(tape, order, &mut self.kept, sorter);
        self.of_followers.clear();
        self.of_followers.resize(train.followers.len(), [NONE; 4]);
        for (row, what) in self.known.iter().enumerate().filter(|(row, _)| self.program.reads(*row)) {
            match *what {
                SeriesKind::Cam(j, order) => self.of_followers[j][order] = row,
                SeriesKind::Process(j) => self.of_followers[j][3] = row,
                _ => {}
            }
        }
    }

    // Out of line: its many numbers need not stay on the stack after a recording.
    #[inline(never)]
    fn write(&mut self, train: &Train, modes: &Modes, tape: &RefCell<Tape>) {
        self.known.clear();
        let zero = Var::from(0.0);
        let mut y = [zero; MOST_STATES];
        y.iter_mut().enumerate().take(train.layout.count).for_each(|(k, y)| *y = Var::state(tape, k));
        let machine = train.machine();
        let mut row = |what: SeriesKind| {
            self.known.push(what);
            tape.borrow_mut().new_row(what.class())
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
    fn fill(&self, train: &Train, modes: &Modes, excitation: &Excitation, about: &About, into: &mut Expansion) {
        let About { time, angles, turns, order, unit } = *about;
        let Equations { program, known, .. } = self;
        let (count, whole) = (order + 3, (order + 3).next_multiple_of(4));
        let sums = train.functions::<COEFFICIENTS>(modes, angles, count, |j, cam, process| {
            let [u, first, second, force] = self.of_followers[j];
            into.set_row(program, u, cam[..whole].iter().copied());
            into.set_row(program, first, slope(&cam[..=whole], 1.0));
            into.set_row(program, second, bend(&cam[..whole + 2], 1.0));
            into.set_row(program, force, process[..whole].iter().copied());
        });
        let since = (time - Double::from(excitation.time)).hi;
        let mut angle = [0.0; COEFFICIENTS];
        if let Some(motion) = excitation.motion {
            let series = AngleSeries::of(motion, time).scaled(unit);
            angle[..series.len()].copy_from_slice(&series);
        }
        let motor = train.machine().map(|machine| &machine.motor);
        for (row, what) in known.iter().enumerate().filter(|(_, what)| !what.is_of_follower()) {
            let mut of_time = [0.0; COEFFICIENTS];
            let own = &mut of_time[..count];
            match *what {
                SeriesKind::Inertia => into.set_row(program, row, sums.inertia[..whole].iter().copied()),
                SeriesKind::HalfSlope => into.set_row(program, row, slope(&sums.inertia[..=whole], 0.5)),
                SeriesKind::Static => into.set_row(program, row, sums.torque[..whole].iter().copied()),
                SeriesKind::Viscous => into.set_row(program, row, sums.viscous[..whole].iter().copied()),
                SeriesKind::Tau => excitation.inputs.loads.expand(since, unit, own),
                SeriesKind::Torque => excitation.inputs.torque.expand(since, unit, own),
                SeriesKind::Force(j) => excitation.inputs.forces[j].expand(since, unit, own),
                SeriesKind::Reference => {
                    if let Some(servo) = motor.and_then(|motor| motor.servo()) {
                        servo.expand_reference(time.hi, unit, (&excitation.inputs.reference, since), own);
                    }
                }
                SeriesKind::Lag => {
                    excitation.inputs.position.expand(since, unit, own);
                    own[0] -= motor.map_or(0.0, |motor| motor.transmission.ratio) * turns * TAU;
                }
                SeriesKind::Phi => own.copy_from_slice(&angle[..count]),
                SeriesKind::W => into.set_row(program, row, slope(&angle[..=whole], 1.0 / unit)),
                SeriesKind::A => into.set_row(program, row, bend(&angle[..whole + 2], 1.0 / (unit * unit))),
                SeriesKind::Cam(..) | SeriesKind::Process(_) => {}
            }
            if what.is_input() {
                into.set_row(program, row, of_time[..whole].iter().copied());
            }
        }
    }
}

/// A multiple of the derivative of a series.
fn slope(c: &[f64], factor: f64) -> impl Iterator<Item = f64> {
    (1..).zip(&c[1..]).map(move |(n, c)| factor * f64::from(n) * c)
}

/// A multiple of the second derivative of a series.
fn bend(c: &[f64], factor: f64) -> impl Iterator<Item = f64> {
    (2..).zip(&c[2..]).map(move |(n, c)| factor * f64::from(n * (n - 1)) * c)
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
