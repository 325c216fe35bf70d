//! The variables of the drive with backlash.

use super::BacklashDrive;
use super::contact::{Flank, Mode};
use crate::drives::cam_drive::HasCamDrive;
use crate::drives::solver::HasSolver;
use crate::drives::{List, Seed, unit, variable};
use crate::numerics::taylor::{Scalar, Series};

/// x1, ẋ1, x2, ẋ2: they follow the parameters or inputs of the drive in the list.
const STATES: [&str; 4] = ["x1", "der(x1)", "y", "der(y)"];

impl BacklashDrive {
    /// The series of a constant state: 1 in the direction of the state `which`.
    fn seed(&self, seed: Seed, which: usize) -> f64 {
        let first = if self.cam.is_input() { 3 } else { 2 };
        if seed == Seed::Known(first + which) { 1.0 } else { 0.0 }
    }

    /// φ (order 0) or φ̇ (order 1) at constant speed.
    fn shaft_series(&self, seed: Seed, order: usize) -> Series {
        let [phi, w, ..] = self.motion.at(self.now.time).kinematics.0;
        match (seed, order) {
            (Seed::Time, 0) => Series::from_derivatives(phi, w, 0.0),
            _ => Series::from([phi, w][order]),
        }
    }

    /// U′, u, u̇, ü.
    fn flank_series(&self, seed: Seed) -> [Series; 4] {
        let (shaft, u) = self.cam.at(&self.motion, self.now.time);
        let [_, w, a, ..] = shaft.kinematics.0;
        let [_, u1, u2, u3, _] = u.0;
        let x = self.now.u.0;
        let [slope, place, speed, acceleration] = match seed {
            Seed::Time => {
                return [
                    Series::from_derivatives(u1, u2 * w, u3 * w * w + u2 * a),
                    Series::from_derivatives(x[0], x[1], x[2]),
                    Series::from_derivatives(x[1], x[2], x[3]),
                    Series::from_derivatives(x[2], x[3], x[4]),
                ];
            }
            Seed::Known(0) if self.cam.is_input() => [u2, u1, u2 * w, u3 * w * w + u2 * a],
            Seed::Known(1) if self.cam.is_input() => [0.0, 0.0, u1, 2.0 * u2 * w],
            Seed::Known(2) if self.cam.is_input() => [0.0, 0.0, 0.0, u1],
            Seed::Known(_) => [0.0; 4],
        };
        [
            Series([u1, slope, 0.0]),
            Series([x[0], place, 0.0]),
            Series([x[1], speed, 0.0]),
            Series([x[2], acceleration, 0.0]),
        ]
    }

    /// x1 and ẋ1: on a flank those of the flank, else states.
    fn place_series(&self, seed: Seed) -> [Series; 2] {
        let [_, u, u_dot, _] = self.flank_series(seed);
        let state = &self.now.state;
        let (z, z_dot) = (state.home + state.zeta[0], state.zeta[1]);
        match (self.now.mode, seed) {
            (Mode::Contact(_), _) => [u + Series::from(z), u_dot],
            (Mode::Free, Seed::Time) => {
                let [q2, _, _] = self.bodies.free_derivatives(state.q);
                let acceleration = self.bodies.link(state.q[0], state.q[1]) / self.m1;
                let jerk = self.bodies.link(state.q[1], q2) / self.m1;
                let speed = u_dot.value() + z_dot;
                [
                    Series::from_derivatives(u.value() + z, speed, acceleration),
                    Series::from_derivatives(speed, acceleration, jerk),
                ]
            }
            (Mode::Free, _) => [
                Series([u.value() + z, self.seed(seed, 0), 0.0]),
                Series([u_dot.value() + z_dot, self.seed(seed, 1), 0.0]),
            ],
        }
    }

    /// q and q̇ = x2 − x1 and ẋ2 − ẋ1; the values are never formed as differences.
    fn spring_series(&self, seed: Seed) -> [Series; 2] {
        let q = self.now.state.q;
        if seed == Seed::Time {
            let [q2, q3, _] = match self.now.mode {
                Mode::Contact(_) => self.bodies.bound_derivatives(q, &self.now.u),
                Mode::Free => self.bodies.free_derivatives(q),
            };
            return [Series::from_derivatives(q[0], q[1], q2), Series::from_derivatives(q[1], q2, q3)];
        }
        let [x, x_dot] = self.place_series(seed);
        [Series([q[0], self.seed(seed, 2) - x.0[1], 0.0]), Series([q[1], self.seed(seed, 3) - x_dot.0[1], 0.0])]
    }

    /// c q + b q̇.
    fn link_series(&self, seed: Seed) -> Series {
        let [q, q_dot] = self.spring_series(seed);
        q * self.c + q_dot * self.b
    }

    /// F_K = m1 ü − c q − b q̇ in contact, 0 in flight.
    fn force_series(&self, seed: Seed) -> Series {
        match self.now.mode {
            Mode::Contact(_) => self.flank_series(seed)[3] * self.m1 - self.link_series(seed),
            Mode::Free => Series::default(),
        }
    }

    /// ẍ1 = ü in contact, (c q + b q̇)/m1 in flight.
    fn acceleration_series(&self, seed: Seed) -> Series {
        match self.now.mode {
            Mode::Contact(_) => self.flank_series(seed)[3],
            Mode::Free => self.link_series(seed) * (1.0 / self.m1),
        }
    }

    /// z = x1 − U.
    fn gap_series(&self, seed: Seed) -> Series {
        let state = &self.now.state;
        let z = state.home + state.zeta[0];
        match (self.now.mode, seed) {
            (Mode::Contact(_), _) => Series::from(z),
            (Mode::Free, Seed::Time) => {
                let [z2, _] = self.bodies.gap_derivatives(state.q, &self.now.u);
                Series::from_derivatives(z, state.zeta[1], z2)
            }
            (Mode::Free, _) => Series([z, self.seed(seed, 0) - self.flank_series(seed)[1].0[1], 0.0]),
        }
    }

    /// 1 on flank A, 0 in flight, −1 on flank B; without clearance the flank that presses.
    fn contact_number(&self) -> f64 {
        match self.now.mode {
            Mode::Free => 0.0,
            Mode::Contact(_) if self.s == 0.0 => {
                if self.bodies.force(self.now.state.q, &self.now.u)[0] < 0.0 {
                    -1.0
                } else {
                    1.0
                }
            }
            Mode::Contact(Flank::A) => 1.0,
            Mode::Contact(Flank::B) => -1.0,
        }
    }
}

/// The variables, in the order of their value references.
pub(super) fn list(drive: &BacklashDrive) -> List<BacklashDrive> {
    let mut list = List::default();
    drive.declare_drive(&mut list);
    states(drive, &mut list);
    parameters(&mut list);
    drive.declare_start(&mut list, &unit::LENGTH, &unit::VELOCITY);
    drive.declare_solver(&mut list);
    outputs(drive, &mut list);
    drive.declare_law(&mut list);
    list
}

/// Of the names, those that exist: inputs only where the drive has them.
fn known<'a>(drive: &BacklashDrive, names: &[&'a str]) -> Vec<&'a str> {
    let exists = |name: &&str| drive.cam.is_input() || !["phi", "w", "a"].contains(name);
    names.iter().copied().filter(exists).collect()
}

fn states(drive: &BacklashDrive, list: &mut List<BacklashDrive>) {
    let real = variable::real;
    list.output(
        "x1",
        "Displacement of m1",
        real(&unit::LENGTH),
        |d, _| d.place_series(Seed::Time)[0].value(),
        |d, s, _| d.place_series(s)[0],
    )
    .state()
    .depends(&known(drive, &["x1", "phi"]))
    .depends_initially(&known(drive, &["phi", "w", "a"]));
    list.output(
        "der(x1)",
        "Velocity of m1",
        real(&unit::VELOCITY),
        |d, _| d.place_series(Seed::Time)[1].value(),
        |d, s, _| d.place_series(s)[1],
    )
    .derivative_of("x1")
    .state()
    .depends(&known(drive, &["der(x1)", "phi", "w"]))
    .depends_initially(&known(drive, &["phi", "w"]));
    list.output(
        "y",
        "Displacement of m2, x2",
        real(&unit::LENGTH),
        |d, _| (d.place_series(Seed::Time)[0] + d.spring_series(Seed::Time)[0]).value(),
        |d, s, _| d.place_series(s)[0] + d.spring_series(s)[0],
    )
    .state()
    .depends(&["y"])
    .depends_initially(&known(drive, &["phi", "w", "a"]));
    list.output(
        "der(y)",
        "Velocity of m2",
        real(&unit::VELOCITY),
        |d, _| (d.place_series(Seed::Time)[1] + d.spring_series(Seed::Time)[1]).value(),
        |d, s, _| d.place_series(s)[1] + d.spring_series(s)[1],
    )
    .derivative_of("y")
    .state()
    .depends(&["der(y)"])
    .depends_initially(&known(drive, &["phi", "w"]));
}

fn parameters(list: &mut List<BacklashDrive>) {
    let within = variable::real_within;
    list.parameter("m1", "Mass at the clearance", within(&unit::MASS, 1e-9, 1e9), |d, _| d.m1, |d, _, v| d.m1 = v)
        .nominal(1.0);
    list.parameter("m2", "Mass behind the spring", within(&unit::MASS, 1e-9, 1e9), |d, _| d.m2, |d, _, v| d.m2 = v)
        .nominal(1.0);
    let stiffness = within(&unit::STIFFNESS, 1e-6, 1e15);
    list.parameter("c", "Stiffness of the spring between m1 and m2", stiffness, |d, _| d.c, |d, _, v| d.c = v)
        .nominal(1e6);
    let damping = within(&unit::DAMPING, 0.0, 1e12);
    list.parameter("b", "Damping between m1 and m2", damping, |d, _| d.b, |d, _, v| d.b = v).nominal(100.0);
    let clearance = within(&unit::LENGTH, 0.0, 1e3);
    list.parameter("s", "Clearance: flank B is at U + s", clearance, |d, _| d.s, |d, _, v| d.s = v).nominal(1e-4);
    let restitution = within(&unit::NUMBER, 0.0, 1.0);
    let text = "Coefficient of restitution, 0 plastic, 1 elastic";
    list.parameter("e", text, restitution, |d, _| d.e, |d, _, v| d.e = v);
}

fn outputs(drive: &BacklashDrive, list: &mut List<BacklashDrive>) {
    let real = variable::real;
    let dynamic = known(drive, &["x1", "der(x1)", "y", "der(y)", "phi", "w", "a"]);
    let spring = known(drive, &["x1", "der(x1)", "y", "der(y)", "phi", "w"]);
    let pressed = known(drive, &["y", "der(y)", "phi", "w", "a"]);
    let inputs = known(drive, &["phi", "w", "a"]);
    list.output(
        "der(x1,2)",
        "Acceleration of m1",
        real(&unit::ACCELERATION),
        |d, _| d.acceleration_series(Seed::Time).value(),
        |d, s, _| d.acceleration_series(s),
    )
    .derivative_of(STATES[1])
    .depends(&dynamic)
    .depends_initially(&inputs);
    list.output(
        "der(y,2)",
        "Acceleration of m2",
        real(&unit::ACCELERATION),
        |d, _| -d.link_series(Seed::Time).value() / d.m2,
        |d, s, _| d.link_series(s) * (-1.0 / d.m2),
    )
    .derivative_of(STATES[3])
    .depends(&spring);
    list.output(
        "q",
        "Elongation of the spring, x2 - x1",
        real(&unit::LENGTH),
        |d, _| d.now.state.q[0],
        |d, s, _| d.spring_series(s)[0],
    )
    .depends(&known(drive, &["x1", "y", "phi"]));
    list.output(
        "der(q)",
        "Rate of elongation of the spring",
        real(&unit::VELOCITY),
        |d, _| d.now.state.q[1],
        |d, s, _| d.spring_series(s)[1],
    )
    .derivative_of("q")
    .depends(&known(drive, &["der(x1)", "der(y)", "phi", "w"]));
    list.output(
        "gap",
        "Distance of m1 from flank A, x1 - U, between 0 and s",
        real(&unit::LENGTH),
        |d, _| d.gap_series(Seed::Time).value(),
        |d, s, _| d.gap_series(s),
    )
    .depends(&known(drive, &["x1", "phi"]))
    .depends_initially(&inputs);
    list.discrete_output(
        "contact",
        "1 on flank A, 0 between the flanks, -1 on flank B",
        variable::Kind::Integer { min: -1, max: 1 },
        |d, _| d.contact_number(),
    )
    .depends(&dynamic)
    .depends_initially(&inputs);
    list.output(
        "force",
        "Contact force F_K of the drive on m1, positive in +x",
        real(&unit::FORCE),
        |d, _| d.force_series(Seed::Time).value(),
        |d, s, _| d.force_series(s),
    )
    .depends(&pressed)
    .depends_initially(&inputs);
    if !drive.cam.is_input() {
        list.output(
            "phi",
            "Drive angle",
            real(&unit::ANGLE),
            |d, _| d.shaft_series(Seed::Time, 0).value(),
            |d, s, _| d.shaft_series(s, 0),
        );
        list.output(
            "w",
            "Angular velocity of the drive",
            real(&unit::ANGULAR_VELOCITY),
            |d, _| d.shaft_series(Seed::Time, 1).value(),
            |d, s, _| d.shaft_series(s, 1),
        );
    }
    list.output(
        "tau",
        "Torque of the contact force on the drive, U' force; positive loads the drive",
        real(&unit::TORQUE),
        |d, _| (d.flank_series(Seed::Time)[0] * d.force_series(Seed::Time)).value(),
        |d, s, _| d.flank_series(s)[0] * d.force_series(s),
    )
    .depends(&pressed)
    .depends_initially(&inputs);
    list.discrete_output(
        "force_mean",
        "Mean force of the drive on m1 over the last communication step, impulses included",
        real(&unit::FORCE),
        |d, _| d.mean[0],
    );
    list.discrete_output(
        "tau_mean",
        "Mean torque on the drive over the last communication step, impulses included",
        real(&unit::TORQUE),
        |d, _| d.mean[1],
    );
    list.discrete_output("impulse", "Sum of the impulses of the drive on m1", real(&unit::IMPULSE), |d, _| {
        d.now.tally.impulse
    })
    .depends(&known(drive, &["x1", "der(x1)", "phi", "w", "a"]));
    let count = variable::Kind::Integer { min: 0, max: i32::MAX };
    // The count saturates at the largest Integer.
    list.discrete_output("impacts", "Number of impacts", count, |d, _| d.now.tally.impacts.min(f64::from(i32::MAX)))
        .depends(&known(drive, &["x1", "der(x1)", "phi", "w", "a"]));
    list.discrete_output("energy_loss", "Energy lost in impacts", real(&unit::ENERGY), |d, _| d.now.tally.energy_loss)
        .depends(&known(drive, &["x1", "der(x1)", "phi", "w", "a"]));
    list.local("damping_loss", "Energy dissipated by the damper", real(&unit::ENERGY), |d, _| d.now.tally.damping_loss);
}
