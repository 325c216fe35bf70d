//! The variables of the drive with backlash.

use super::{BacklashDrive, Now, Parameters};
use crate::drives::follower::contact::{Mode, State};
use crate::drives::settings::HasSolver;
use crate::drives::shaft::cam_drive::{A, CAM, HasCamDrive, PHI, W};
use crate::drives::shaft::free::coupled::COUPLING;
use crate::drives::{List, Seed, unit, variable};
use crate::motion::Kinematics;
use crate::numerics::taylor::{Scalar, Series};

/// x1, ẋ1, x2, ẋ2: they follow the parameters or inputs of the drive in the list.
const STATES: [&str; 4] = ["x1", "der(x1)", "y", "der(y)"];

/// Quantities from which the outputs are computed: numbers, or series.
struct Quantities<S> {
    /// x1 and ẋ1.
    place: [S; 2],
    /// q and q̇; never formed as differences.
    q: [S; 2],
    /// ü in contact.
    driven: S,
}

impl<S: Scalar> Quantities<S> {
    /// x2 and ẋ2.
    fn far_place(&self) -> [S; 2] {
        let ([x, x_dot], [q, q_dot]) = (self.place, self.q);
        [x + q, x_dot + q_dot]
    }

    /// c q + b q̇.
    fn link(&self, d: &BacklashDrive) -> S {
        self.q[0] * d.parameters.c + self.q[1] * d.parameters.b
    }

    /// F_K = m1 ü − c q − b q̇ in contact, 0 in flight.
    fn force(&self, d: &BacklashDrive) -> S {
        match d.now.mode {
            Mode::Contact(_) => self.driven * d.parameters.m1 - self.link(d),
            Mode::Free => S::from(0.0),
        }
    }

    /// ẍ1 = ü in contact, (c q + b q̇)/m1 in flight.
    fn acceleration(&self, d: &BacklashDrive) -> S {
        match d.now.mode {
            Mode::Contact(_) => self.driven,
            Mode::Free => self.link(d) * (1.0 / d.parameters.m1),
        }
    }
}

impl BacklashDrive {
    /// The numbers.
    fn values(&self) -> Quantities<f64> {
        let point = &self.now.point;
        Quantities { place: point.place(), q: point.state.q, driven: point.u[2] }
    }

    /// z and ż, with all digits also near flank B.
    fn gap(&self) -> [f64; 2] {
        let State { home, zeta, .. } = self.now.point.state;
        [home + zeta[0], zeta[1]]
    }

    /// U′.
    fn slope(&self) -> f64 {
        let w = self.motion.coefficients[1];
        if self.motion.is_uniform() && w != 0.0 {
            self.now.point.u[1] / w
        } else {
            self.cam.at(&self.motion, self.now.time).1.0[1]
        }
    }

    /// φ (order 0) or φ̇ (order 1).
    fn shaft_series(&self, seed: Seed, order: usize) -> Series {
        let d = self.motion.at(self.now.time).kinematics.0;
        match seed {
            Seed::Time => Series::from_derivatives(d[order], d[order + 1], d[order + 2]),
            known => Series([d[order], known.of(["phi", "w"][order]), 0.0]),
        }
    }

    /// u and its time derivatives: the shown values, the others from the law.
    fn flank_motion(&self) -> Kinematics {
        let (shaft, law) = self.cam.at(&self.motion, self.now.time);
        let mut u = law.along(&shaft.kinematics);
        let shown = if self.now.mode == Mode::Free { 2 } else { 3 };
        u.0[..shown].copy_from_slice(&self.now.point.u[..shown]);
        u
    }

    /// U′ (order 1) or U″ (order 2) as a series.
    fn transfer_series(&self, seed: Seed, order: usize) -> Series {
        let (shaft, law) = self.cam.at(&self.motion, self.now.time);
        let [_, w, a, ..] = shaft.kinematics.0;
        let value = if order == 1 { self.slope() } else { law.0[order] };
        let [u1, u2] = [law.0[order + 1], law.0[order + 2]];
        match seed {
            Seed::Time => Series::from_derivatives(value, u1 * w, u2 * w * w + u1 * a),
            known => Series([value, u1 * known.of("phi"), 0.0]),
        }
    }

    /// The quantities as series, and the series of z; x1 = u + z.
    fn series_and_gap(&self, seed: Seed) -> (Quantities<Series>, Series) {
        let x = self.flank_motion();
        let (u, z, q) = match seed {
            Seed::Time => self.time_series(&x),
            known => self.partial_series(known, &x),
        };
        (Quantities { place: [u[0] + z[0], u[1] + z[1]], q, driven: u[2] }, z[0])
    }

    /// u, u̇, ü; z, ż; q, q̇.
    fn time_series(&self, x: &Kinematics) -> ([Series; 3], [Series; 2], [Series; 2]) {
        let ([z, z_dot], [q, q_dot]) = (self.gap(), self.now.point.state.q);
        let motion = |n: usize| Series::from_derivatives(x.0[n], x.0[n + 1], x.0[n + 2]);
        let state = [q, q_dot];
        let ([q2, q3, _], gap) = match self.now.mode {
            Mode::Contact(_) => (self.bodies.bound_derivatives(state, x), [z_dot, 0.0, 0.0]),
            Mode::Free => {
                let [z2, z3] = self.bodies.gap_derivatives(state, x);
                (self.bodies.free_derivatives(state), [z_dot, z2, z3])
            }
        };
        (
            [motion(0), motion(1), motion(2)],
            [Series::from_derivatives(z, gap[0], gap[1]), Series::from_derivatives(gap[0], gap[1], gap[2])],
            [Series::from_derivatives(q, q_dot, q2), Series::from_derivatives(q_dot, q2, q3)],
        )
    }

    /// The partial derivatives with respect to the input or the state `known`.
    fn partial_series(&self, known: Seed, x: &Kinematics) -> ([Series; 3], [Series; 2], [Series; 2]) {
        let (shaft, law) = self.cam.at(&self.motion, self.now.time);
        let [_, w, a, ..] = shaft.kinematics.0;
        let [_, u1, u2, u3, _] = law.0;
        let rates = match known {
            Seed::Known("phi") => [u1, u2 * w, u3 * w * w + u2 * a],
            Seed::Known("w") => [0.0, u1, 2.0 * u2 * w],
            Seed::Known("a") => [0.0, 0.0, u1],
            _ => [0.0; 3],
        };
        // On a flank x1 follows it; in flight it is a state.
        let (place, speed) = match self.now.mode {
            Mode::Contact(_) => (rates[0], rates[1]),
            Mode::Free => (known.of("x1"), known.of("der(x1)")),
        };
        let ([z, z_dot], [q, q_dot]) = (self.gap(), self.now.point.state.q);
        (
            std::array::from_fn(|n| Series([x.0[n], rates[n], 0.0])),
            [Series([z, place - rates[0], 0.0]), Series([z_dot, speed - rates[1], 0.0])],
            [Series([q, known.of("y") - place, 0.0]), Series([q_dot, known.of("der(y)") - speed, 0.0])],
        )
    }

    /// ΣP and the losses: they stand still between events, but a jump of the inputs strikes the masses.
    fn struck_series(&self, seed: Seed) -> [Series; 2] {
        let now = [self.now.tally.impulse, self.now.tally.energy_loss];
        let (Seed::Known(_), Some(run)) = (seed, &self.run) else { return now.map(Series::from) };
        let rate = self.partial_series(seed, &self.flank_motion()).0[1].0[1];
        let [impulse, loss] = [now[0] - run.tally.impulse, now[1] - run.tally.energy_loss];
        let Now { mode, point: end, .. } = &self.end;
        let slopes = match mode {
            // m1 Δu̇, the impulse with which m1 follows.
            Mode::Contact(_) => [self.parameters.m1 * rate, 0.0],
            // An impact: P ∝ ż⁻, the loss ∝ (ż⁻)².
            Mode::Free if impulse != 0.0 => {
                let approach = end.state.zeta[1] - (self.now.point.u[1] - end.u[1]);
                [-rate * impulse / approach, -2.0 * rate * loss / approach]
            }
            Mode::Free => [0.0; 2],
        };
        [0, 1].map(|i| Series([now[i], slopes[i], 0.0]))
    }

    /// 1 on flank A, 0 in flight, −1 on flank B; without clearance the flank that exerts this force.
    fn contact_number(&self, force: f64) -> f64 {
        match self.now.mode {
            Mode::Free => 0.0,
            Mode::Contact(_) if self.parameters.s == 0.0 => {
                if force < 0.0 {
                    -1.0
                } else {
                    1.0
                }
            }
            Mode::Contact(flank) => flank.sign(),
        }
    }
}

/// The variables, in the order of their value references.
pub(super) fn list(drive: &BacklashDrive) -> List<BacklashDrive> {
    let mut list = List::default();
    drive.declare_drive(&mut list);
    states(drive, &mut list);
    list.group::<Parameters>();
    drive.declare_start(&mut list, &unit::LENGTH, &unit::VELOCITY);
    drive.declare_solver(&mut list, STATISTICS);
    outputs(drive, &mut list);
    drive.declare_law(&mut list);
    list
}

/// The places of the computed values.
const X1: usize = 0;
const X1_DOT: usize = 1;
const Y: usize = 2;
const Y_DOT: usize = 3;
const X1_DOT_DOT: usize = 4;
const Y_DOT_DOT: usize = 5;
const Q: usize = 6;
const Q_DOT: usize = 7;
const GAP: usize = 8;
const FORCE: usize = 9;
const SHAFT: usize = 10;
const SHAFT_SPEED: usize = 11;
const TAU: usize = 12;
const CONTACT: usize = 13;
const MEANS: usize = 14;
const IMPULSE: usize = 16;
const IMPACTS: usize = 17;
const LOSS: usize = 18;
const DAMPING_LOSS: usize = 19;
const STATISTICS: usize = 20;
const COUPLED: usize = STATISTICS + 3;

/// The continuous outputs, of numbers or of series, in the order of their places; gap, shaft and U′ are passed through.
fn continuous<S: Scalar>(d: &BacklashDrive, known: &Quantities<S>, gap: S, shaft: [S; 2], slope: S) -> [S; TAU + 1] {
    let ([x, x_dot], [y, y_dot], [q, q_dot]) = (known.place, known.far_place(), known.q);
    let force = known.force(d);
    let (x2, y2, [phi, w]) = (known.acceleration(d), known.link(d) * (-1.0 / d.parameters.m2), shaft);
    [x, x_dot, y, y_dot, x2, y2, q, q_dot, gap, force, phi, w, slope * force]
}

pub(super) fn evaluate(d: &BacklashDrive, values: &mut [f64]) {
    let [phi, w, ..] = d.motion.kinematics(d.now.time);
    let known = d.values();
    let outputs = continuous(d, &known, d.gap()[0], [phi, w], d.slope());
    values[..=TAU].copy_from_slice(&outputs);
    values[CONTACT] = d.contact_number(outputs[FORCE]);
    values[MEANS..IMPULSE].copy_from_slice(&d.mean());
    let tally = &d.now.tally;
    // The count saturates at the largest Integer.
    (values[IMPULSE], values[IMPACTS]) = (tally.impulse, tally.impacts.min(f64::from(i32::MAX)));
    (values[LOSS], values[DAMPING_LOSS]) = (tally.energy_loss, d.damping_loss());
    values[STATISTICS..COUPLED].copy_from_slice(&d.statistics());
    if d.coupling {
        let curvature = d.cam.at(&d.motion, d.now.time).1.0[2];
        values[COUPLED..].copy_from_slice(&coupled(d, &known, [d.slope(), curvature]));
    }
}

/// The inertia of m1 in contact on the shaft, its derivative by φ, and the rest of the torque.
fn coupled<S: Scalar>(d: &BacklashDrive, known: &Quantities<S>, [slope, curvature]: [S; 2]) -> [S; 3] {
    match d.now.mode {
        Mode::Contact(_) => {
            let m1 = d.parameters.m1;
            [slope * slope * m1, slope * curvature * (2.0 * m1), -(slope * known.link(d))]
        }
        Mode::Free => [S::from(0.0); 3],
    }
}

fn series(d: &BacklashDrive, seed: Seed, which: usize) -> Series {
    let (known, gap) = d.series_and_gap(seed);
    let shaft = [0, 1].map(|order| d.shaft_series(seed, order));
    if which >= COUPLED {
        return coupled(d, &known, [1, 2].map(|order| d.transfer_series(seed, order)))[which - COUPLED];
    }
    continuous(d, &known, gap, shaft, d.transfer_series(seed, 1))[which]
}

/// Initial dependencies of q, q̇, the touched flank, and the further ones of a periodic start.
struct Beginning {
    q: Vec<&'static str>,
    q_dot: Vec<&'static str>,
    contact: Vec<&'static str>,
    periodic: Vec<&'static str>,
}

impl Beginning {
    fn of(drive: &BacklashDrive) -> Self {
        let periodic = drive.periodic_start(&["m1", "m2", "c", "b", "s", "e", "cam"]);
        let q = [&periodic[..], &["start.mode", "start.q"]].concat();
        let q_dot = [&periodic[..], &["start.mode", "start.q_dot"]].concat();
        // The flank is the one on which the force presses, or its rate if the force is zero.
        let contact = [&q[..], &q_dot, PHI, W, A, CAM, &["m1", "m2", "c", "b", "s"]].concat();
        Beginning { q, q_dot, contact, periodic }
    }
}

fn states(drive: &BacklashDrive, list: &mut List<BacklashDrive>) {
    let mut outputs = drive.outputs(list, &STATES, series);
    let mut output = |place, name, text, quantity, known: &[&str], initial: &[&[&str]]| {
        outputs.add(place, name, text, quantity, known).depends_initially(initial);
    };
    let start = Beginning::of(drive);
    output(X1, "x1", "Displacement of m1", &unit::LENGTH, &["x1", "phi"], &[&start.contact]);
    output(
        X1_DOT,
        "der(x1)",
        "Velocity of m1",
        &unit::VELOCITY,
        &["der(x1)", "phi", "w"],
        &[PHI, W, CAM, &start.periodic],
    );
    output(Y, "y", "Displacement of m2, x2", &unit::LENGTH, &["y"], &[&start.contact]);
    output(Y_DOT, "der(y)", "Velocity of m2", &unit::VELOCITY, &["der(y)"], &[PHI, W, CAM, &start.q_dot]);
}

fn outputs(drive: &BacklashDrive, list: &mut List<BacklashDrive>) {
    let mut outputs = drive.outputs(list, &STATES, series);
    let mut output = |place, name, text, quantity, known: &[&str], initial: &[&[&str]]| {
        outputs.add(place, name, text, quantity, known).depends_initially(initial);
    };
    let start = Beginning::of(drive);
    let spring: &[&str] = &["x1", "der(x1)", "y", "der(y)", "phi", "w"];
    let dynamic = [spring, &["a"]].concat();
    let pressed: &[&str] = &["y", "der(y)", "phi", "w", "a"];
    let force: &[&[&str]] = &[PHI, W, A, CAM, &start.q, &start.q_dot, &["m1", "c", "b"]];
    let initial: &[&[&str]] = &[PHI, W, A, CAM, &start.periodic];
    output(X1_DOT_DOT, "der(x1,2)", "Acceleration of m1", &unit::ACCELERATION, &dynamic, initial);
    let initial: &[&[&str]] = &[&start.q, &start.q_dot, &["m2", "c", "b"]];
    output(Y_DOT_DOT, "der(y,2)", "Acceleration of m2", &unit::ACCELERATION, spring, initial);
    output(Q, "q", "Elongation of the spring, x2 - x1", &unit::LENGTH, &["x1", "y", "phi"], &[&start.q]);
    let (text, known) = ("Rate of elongation of the spring", ["der(x1)", "der(y)", "phi", "w"]);
    output(Q_DOT, "der(q)", text, &unit::VELOCITY, &known, &[&start.q_dot]);
    let text = "Distance of m1 from flank A, x1 - U, between 0 and s";
    output(GAP, "gap", text, &unit::LENGTH, &["x1", "phi"], &[&start.contact]);
    let (text, kind) =
        ("1 on flank A, 0 between the flanks, -1 on flank B", variable::Kind::Integer { min: -1, max: 1 });
    outputs.add_discrete(CONTACT, "contact", text, kind, &dynamic).depends_initially(&[&start.contact]);
    let text = "Contact force F_K of the drive on m1, positive in +x";
    outputs.add(FORCE, "force", text, &unit::FORCE, pressed).depends_initially(force);
    outputs.add_shaft([SHAFT, SHAFT_SPEED]);
    let text = "Torque of the contact force on the drive, U' force; positive loads the drive. Without impulses: connect tau_mean";
    outputs.add(TAU, "tau", text, &unit::TORQUE, pressed).depends_initially(force);
    for (i, (name, text, quantity)) in COUPLING.into_iter().enumerate().filter(|_| drive.coupling) {
        let (known, of_m1) = (if i < 2 { &["phi"][..] } else { &pressed[..4] }, [PHI, CAM, &["m1"], &start.periodic]);
        let of_rest: [&[&str]; 5] = [PHI, CAM, &start.q, &start.q_dot, &["c", "b"]];
        let initial: &[&[&str]] = if i < 2 { &of_m1 } else { &of_rest };
        outputs.add(COUPLED + i, name, text, quantity, known).depends_initially(initial);
    }
    // Sums over a communication step and since the start.
    let real = variable::real;
    let text = "Mean force of the drive on m1 over the last communication step, impulses included";
    outputs.add_discrete(MEANS, "force_mean", text, real(&unit::FORCE), &[]);
    let text =
        "Mean torque on the drive over the last communication step, impulses included; a positive one loads the drive";
    outputs.add_discrete(MEANS + 1, "tau_mean", text, real(&unit::TORQUE), &[]);
    let struck: &[&str] = &["x1", "der(x1)", "phi", "w", "a"];
    let text = "Sum of the impulses of the drive on m1";
    outputs
        .add_discrete(IMPULSE, "impulse", text, real(&unit::IMPULSE), struck)
        .slopes(|d, s, _| d.struck_series(s)[0]);
    let count = variable::Kind::Integer { min: 0, max: i32::MAX };
    outputs.add_discrete(IMPACTS, "impacts", "Number of impacts", count, struck);
    let text = "Energy lost in impacts";
    outputs
        .add_discrete(LOSS, "energy_loss", text, real(&unit::ENERGY), struck)
        .slopes(|d, s, _| d.struck_series(s)[1]);
    list.local("damping_loss", "Energy dissipated by the damper", real(&unit::ENERGY)).at(DAMPING_LOSS);
}
