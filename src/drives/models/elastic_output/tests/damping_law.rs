//! A damping law is one line: m q̈ + b(q̇) q̇ + c q = −m ẍ with b(q̇) = b₁ + b₂ |q̇|, at constant speed and on inputs, solved by
//! collocation and compared with an independent integration.

use super::*;
use crate::drives::follower::elastic_output::Equation;
use crate::drives::shaft::cam_drive::AngleMotion;
use crate::drives::shaft::passage::first_passage;
use crate::drives::solver::step_control::{FAR, StepControl};
use crate::motion::derivatives::lift;
use crate::numerics::collocation::{Collocation, Failure, System};
use crate::numerics::first_root::first_root;
use crate::numerics::taylor::{Scalar, Series};

/// Rounding error of the coefficients of a polynomial, relative to the largest one.
const ROUNDING: f64 = 1e-10;

/// An equation of motion of the output, smooth as long as its guard is positive.
trait Law: Copy {
    /// q̈ at q, q̇ for the cam's x, ẋ, ẍ.
    fn acceleration<S: Scalar>(&self, state: [S; 2], x: [S; 3]) -> S;
    /// The guard's coefficients of q and q̇.
    fn guard(&self) -> [f64; 2];
    /// The equation on the other side of the guard.
    fn crossed(self) -> Self;
}

/// b(q̇) = b₁ + b₂ |q̇|; the equation has b₁, `sense` is the sign of q̇.
#[derive(Clone, Copy)]
struct Progressive {
    equation: Equation,
    b2: f64,
    sense: f64,
}

impl Law for Progressive {
    fn acceleration<S: Scalar>(&self, [q, v]: [S; 2], x: [S; 3]) -> S {
        let [m, ..] = self.equation.parameters;
        self.equation.acceleration([q, v], x) - v * v * (self.sense * self.b2 / m)
    }

    fn guard(&self) -> [f64; 2] {
        [0.0, self.sense]
    }

    fn crossed(self) -> Self {
        Progressive { sense: -self.sense, ..self }
    }
}

/// A law on a prescribed shaft, between two breakpoints of the cam and two changes of the law.
struct Piece<'a, L> {
    law: L,
    cam: &'a MotionLaw,
    motion: AngleMotion,
    segment: usize,
    /// Whether the guard is zero at the start of the next step.
    on_guard: bool,
    crossings: usize,
}

impl<L: Law> Piece<'_, L> {
    fn lift(&self, t: Double) -> [f64; 3] {
        let shaft = self.motion.at_instant(t);
        let ([u, slope, curvature, ..], [_, w, a, ..]) =
            (self.cam.at_in(self.segment, shaft.reduced).0, shaft.kinematics.0);
        lift([u, slope, curvature], [w, a])
    }

    /// One step, at most to `limit`, and shortened to a change of the cam or the law.
    fn step(&mut self, integrator: &mut Collocation<2>, limit: Double, control: StepControl) -> Result<(), Failure> {
        let (before, start) = (integrator.clone(), integrator.end());
        control.step(integrator, self, limit, 4)?;
        let length = (integrator.end() - start).hi;
        // The way of the shaft and the guard over the step, as polynomials.
        let mut way: [f64; 11] = self.motion.derivatives((start - Double::from(self.motion.origin)).hi);
        let mut power = 1.0;
        for (j, way) in way.iter_mut().enumerate().skip(1) {
            power *= length / j as f64;
            *way *= power;
        }
        let phi = self.motion.at_instant(start).reduced;
        let passage = first_passage(self.cam.breakpoints(), self.segment, phi, &way, 0.0);
        let ([of_q, of_v], [q, v]) = (self.law.guard(), before.state());
        let (growth, mut guard) = ([0, 1].map(|c| integrator.growth(c)), [0.0; 9]);
        for (j, guard) in guard.iter_mut().enumerate() {
            *guard = of_q * growth[0][j] + of_v * growth[1][j];
        }
        guard[0] = of_q * q + of_v * v;
        if self.on_guard || guard[0] == 0.0 {
            // If the guard begins with a zero, which has any order for a mass at rest, roundings do not show its sign.
            let least = ROUNDING * guard.iter().fold(0.0, |largest: f64, c| largest.max(c.abs()));
            guard[0] = 0.0;
            guard.iter_mut().take_while(|c| c.abs() <= least).for_each(|c| *c = 0.0);
        }
        let crossing = if guard == [0.0; 9] { None } else { first_root(&guard, 1.0) };
        let passed = passage.filter(|passage| crossing.is_none_or(|at| passage.at < at));
        let Some(at) = passed.map(|passage| passage.at).or(crossing) else {
            self.on_guard = false;
            return Ok(());
        };
        integrator.return_to(&before);
        let there = start + Double::from(at * length);
        if (there - start).hi > 0.0 {
            self.on_guard = false;
            control.step(integrator, self, there, 4)?;
            if (there - integrator.end()).hi > 0.0 {
                // The tolerance needs a shorter step, so the rest is left to the next one.
                return Ok(());
            }
        }
        if let Some(passage) = passed {
            self.segment = passage.segment;
        } else {
            (self.law, self.on_guard) = (self.law.crossed(), true);
            self.crossings += 1;
        }
        Ok(())
    }
}

impl<L: Law> System<2> for Piece<'_, L> {
    fn rhs(&self, t: Double, y: &[f64; 2]) -> [f64; 2] {
        [y[1], self.law.acceleration(*y, self.lift(t))]
    }

    fn jacobian(&self, t: Double, &[q, v]: &[f64; 2]) -> [[f64; 2]; 2] {
        let x = self.lift(t).map(Series::from);
        let slopes = [[1.0, 0.0], [0.0, 1.0]].map(|[of_q, of_v]| {
            self.law.acceleration([Series([q, of_q, 0.0]), Series([v, of_v, 0.0])], x).derivative(1)
        });
        [[0.0, 1.0], slopes]
    }

    fn longest_step(&self, t: Double, _: &[f64; 2]) -> f64 {
        let [_, w, a, ..] = self.motion.at_instant(t).kinematics.0;
        let reach = 2.0 / self.cam.resolution_in(self.segment);
        (reach / w.abs()).min((2.0 * reach / a.abs()).sqrt())
    }
}

/// The end of the motions (s).
const STOP: f64 = 1.0;

/// q, q̇ at the ends of so many equal steps, from rest at φ, ω, α on inputs or at constant speed; and how often the
/// law changed.
fn trajectory<L: Law>(law: L, cam: &MotionLaw, shaft: [f64; 3], input: bool, steps: u32) -> (Vec<[f64; 2]>, usize) {
    let [phi, w, a] = shaft;
    let mode = if input { DriveMode::Input } else { DriveMode::Constant { w, phi_start: phi } };
    let mut drive = CamDrive::new(cam.clone(), mode);
    drive.set_inputs(shaft);
    let motion = drive.motion(0.0);
    let mut piece = Piece { law, cam, motion, segment: 0, on_guard: true, crossings: 0 };
    piece.segment = cam.segment(motion.at(0.0).reduced, w >= 0.0);
    let mut integrator = Collocation::new(Double::default(), [0.0; 2]);
    let (control, mut trajectory) = (StepControl::Tolerance(1e-12), Vec::new());
    for n in 0..steps {
        let [time, end] = [n, n + 1].map(|n| STOP * f64::from(n) / f64::from(steps));
        if input {
            drive.set_inputs([phi + (w + 0.5 * a * time) * time, w + a * time, a]);
            piece.motion = drive.motion(time);
        }
        let target = Double::from(end);
        let limit = if input { target } else { FAR };
        while (target - integrator.end()).hi > 0.0 {
            piece.step(&mut integrator, limit, control).unwrap();
        }
        trajectory.push(integrator.at(target));
    }
    (trajectory, piece.crossings)
}

/// The same for m, c and b = b₁ + b₂ |q̇| by the classical Runge–Kutta method in steps of 1e-5 s at most, which end when the cam
/// passes a breakpoint.
fn reference(body: [f64; 4], cam: &MotionLaw, shaft: [f64; 3], steps: u32) -> Vec<[f64; 2]> {
    let ([m, c, b1, b2], [phi, w, a]) = (body, shaft);
    let angle = |t: f64| phi + (w + 0.5 * a * t) * t;
    let mut ends: Vec<(f64, bool)> = (1..=steps).map(|n| (STOP * f64::from(n) / f64::from(steps), true)).collect();
    for breakpoint in cam.breakpoints() {
        for turn in -50..50 {
            // ½ a t² + w t = way.
            let way = breakpoint + TAU * f64::from(turn) - phi;
            let root = (w * w + 2.0 * a * way).sqrt();
            let times = if a == 0.0 { [way / w, f64::NAN] } else { [(root - w) / a, (-root - w) / a] };
            ends.extend(times.into_iter().filter(|t| 0.0 < *t && *t < STOP).map(|t| (t, false)));
        }
    }
    ends.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (mut y, mut start, mut trajectory) = ([0.0f64; 2], 0.0, Vec::new());
    for (end, is_read) in ends {
        let middle = angle::reduce(Double::from(angle(0.5 * (start + end))));
        let segment = cam.segment(middle, true);
        let rate = |t: f64, [q, v]: [f64; 2]| {
            let speed = w + a * t;
            let [_, slope, curvature, ..] = cam.at_in(segment, angle::reduce(Double::from(angle(t)))).0;
            [v, -((b1 + b2 * v.abs()) * v + c * q) / m - curvature * speed * speed - slope * a]
        };
        let count = ((end - start) / 1e-5).ceil();
        let h = (end - start) / count;
        let on = |y: [f64; 2], k: [f64; 2], h: f64| [y[0] + h * k[0], y[1] + h * k[1]];
        for n in 0..count as u32 {
            let t = start + f64::from(n) * h;
            let k1 = rate(t, y);
            let k2 = rate(t + 0.5 * h, on(y, k1, 0.5 * h));
            let k3 = rate(t + 0.5 * h, on(y, k2, 0.5 * h));
            let k4 = rate(t + h, on(y, k3, h));
            y = std::array::from_fn(|i| y[i] + h / 6.0 * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]));
        }
        start = end;
        if is_read {
            trajectory.push(y);
        }
    }
    trajectory
}

/// The largest error of q relative to the largest |q|.
fn error(found: &[[f64; 2]], expected: &[[f64; 2]]) -> f64 {
    assert_eq!(found.len(), expected.len());
    let largest = expected.iter().fold(0.0, |largest: f64, [q, _]| largest.max(q.abs()));
    found.iter().zip(expected).fold(0.0, |error: f64, (a, b)| error.max((a[0] - b[0]).abs())) / largest
}

#[test]
fn a_progressive_damper_is_right_at_constant_speed_and_on_inputs() {
    let [m, c, b1] = [1.5, 8e3, 7.0];
    let cams = [MotionLaw::Fourier(series()), cycle(SimpleSine, Polynomial345)];
    for (cam, b2) in cams.iter().flat_map(|cam| [(cam, 0.0), (cam, 40.0), (cam, 2e3)]) {
        let law = Progressive { equation: Equation::new([m, c, b1]), b2, sense: 1.0 };
        // At constant speed, backwards, and on a ramp that stops and turns back.
        for (shaft, input) in [
            ([0.3, 20.0, 0.0], false),
            ([0.3, -20.0, 0.0], false),
            ([0.3, 20.0, 0.0], true),
            ([0.3, 12.0, -24.0], true),
        ] {
            let expected = reference([m, c, b1, b2], cam, shaft, 40);
            for every in [1, 4] {
                let (found, crossings) = trajectory(law, cam, shaft, input, 40 / every);
                let expected: Vec<_> =
                    expected.iter().copied().skip(every as usize - 1).step_by(every as usize).collect();
                let error = error(&found, &expected);
                assert!(error <= 1e-9, "b2 = {b2}, {shaft:?}, input: {input}, every {every}: {error:e}");
                assert!(crossings > 10, "{crossings}");
            }
        }
    }
}

#[test]
fn without_its_second_part_it_is_the_drive() {
    let ([m, c, b1], w) = ([1.5, 8e3, 7.0], 20.0);
    for cam in [MotionLaw::Fourier(series()), cycle(SimpleSine, Polynomial345)] {
        let law = Progressive { equation: Equation::new([m, c, b1]), b2: 0.0, sense: 1.0 };
        let (found, _) = trajectory(law, &cam, [0.3, w, 0.0], false, 20);
        let mut drive = drive(scene([m, c, b1], cam, DriveMode::Constant { w, phi_start: 0.3 }, at_rest()));
        let expected: Vec<_> = (1..=20).map(|n| run(&mut drive, f64::from(n) / 20.0, 0.05)).collect();
        assert!(error(&found, &expected) <= 1e-10);
    }
}
