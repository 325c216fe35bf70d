//! Motion of the shaft, inputs and the variables of the law.

use super::*;
use crate::motion::CyclePlan;
use crate::motion::Fourier;

#[test]
fn the_motion_is_the_polynomial_of_its_inputs() {
    let mut cam = CamDrive::new(MotionLaw::Fourier(Fourier::new(vec![0.0], vec![])), DriveMode::Input);
    cam.input = [0.5, 2.0, -3.0];
    cam.set_input_derivative(2, 1, 6.0);
    let shaft = cam.motion(10.0).at(10.5);
    let t: f64 = 0.5;
    assert!((shaft.kinematics.0[0] - (0.5 + 2.0 * t - 1.5 * t * t + t.powi(3))).abs() < 1e-15);
    assert!((shaft.kinematics.0[1] - (2.0 - 3.0 * t + 3.0 * t * t)).abs() < 1e-15);
    assert!((shaft.kinematics.0[2] - (-3.0 + 6.0 * t)).abs() < 1e-15);
    assert_eq!(shaft.kinematics.0[3], 6.0);
}

#[test]
fn a_million_turns_at_constant_speed_keep_the_angle() {
    // 0.1 rad/s is not 1/10; the exact product of the two doubles decides.
    let motion = AngleMotion::uniform(0.0, 0.25, 0.1);
    let t = 6.0e7;
    let exact = two_product(0.1, t) + Double::from(0.25);
    assert_eq!(motion.at(t).reduced, angle::reduce(exact));
}

#[test]
fn the_enumeration_lists_the_standard_laws_in_their_order() {
    let names: Vec<&str> = STANDARD_LAW.items.iter().map(|(name, _)| *name).collect();
    assert_eq!(names, crate::motion::StandardLaw::ALL.map(|law| law.name()));
}

/// A drive that consists only of its cam.
struct Bare(CamDrive, Start);

impl HasCamDrive for Bare {
    type Law = MotionLaw;
    fn cam(&self) -> &CamDrive {
        &self.0
    }
    fn cam_mut(&mut self) -> &mut CamDrive {
        &mut self.0
    }
    fn start_values(&self) -> &Start {
        &self.1
    }
    fn start_values_mut(&mut self) -> &mut Start {
        &mut self.1
    }
}

#[test]
fn the_plan_of_a_cycle_is_set_through_its_variables() {
    use crate::motion::{Cycle, StandardLaw};
    let plan = CyclePlan {
        stroke: 0.04,
        lower: 0.0,
        rise_start: 0.0,
        rise_angle: 2.0,
        upper_dwell: 1.0,
        return_angle: 2.0,
        rise_law: StandardLaw::InclinedSine,
        return_law: StandardLaw::InclinedSine,
        inflections: [None; 2],
    };
    let cam = CamDrive::new(MotionLaw::Cycle(Cycle::new(plan)), DriveMode::Input);
    let mut bare = Bare(cam, Start { mode: StartMode::AtRest, q: 0.0, q_dot: 0.0 });
    let mut list = List::default();
    bare.declare_law(&mut list);
    let law = bare.cam().law.clone();
    let mut set = |name: &str, value: f64| {
        let v = &list.0[list.reference(name).unwrap()];
        assert!(v.description.name.len() <= 40);
        v.access.set(&mut bare, v.index, value);
        assert_eq!(v.access.get(&bare, v.index), Some(value), "{name}");
        bare.cam().law.clone()
    };
    set("cam.rise", 3.0);
    set("cam.return_law", 5.0);
    let changed = set("cam.stroke", 0.05);
    assert!(changed.at(3.5).0[0] == 0.05 && law.at(3.5).0[0] != 0.05 && changed.validate() == Ok(()));
    assert!(set("cam.upper_dwell", 2.0).validate().unwrap_err().contains("upper_dwell = 2 rad"));
}

/// A cam that integrates its speed, from φ = 0.25 at `time` (s).
fn integrating(time: f64) -> CamDrive {
    let law = MotionLaw::Fourier(Fourier::new(vec![0.0, 1.0], vec![]));
    let mut cam = CamDrive::new(law, DriveMode::Speed { phi_start: 0.25 });
    cam.start(time);
    cam
}

/// Steps to these instants with w and its derivatives as they are there, from the polynomial w = Σ cⱼ tʲ/j!.
fn speed_steps(cam: &mut CamDrive, c: &[f64], mut time: f64, ends: impl IntoIterator<Item = f64>) -> f64 {
    let derivative =
        |order: usize, t: f64| (order..c.len()).rev().fold(0.0, |sum, j| c[j] + sum * t / (j + 1 - order) as f64);
    for end in ends {
        cam.set_input(1, derivative(0, time));
        (1..c.len()).for_each(|order| cam.set_input_derivative(1, order, derivative(order, time)));
        let motion = cam.motion(time);
        cam.step_done(&motion, end);
        time = end;
    }
    cam.motion(time).at(time).kinematics.0[0]
}

#[test]
fn the_angle_is_the_integral_of_the_speed_however_the_steps_are() {
    // w = 3 + 2 t − 7 t²/2 + 5 t⁸/8!: up to the highest derivative that counts, and turning back on the way.
    let c = [3.0, 2.0, -7.0, 0.0, 0.0, 0.0, 0.0, 0.0, 5.0];
    let factorial: f64 = (1..=9).map(f64::from).product();
    let phi = |t: f64| 0.25 + 3.0 * t + t * t - 7.0 * t.powi(3) / 6.0 + 5.0 * t.powi(9) / factorial;
    for ends in [vec![2.5], (1..=1000).map(|n| 2.5e-3 * f64::from(n)).collect(), vec![1e-9, 0.3, 2.2, 2.5]] {
        let count = ends.len();
        let end = speed_steps(&mut integrating(0.0), &c, 0.0, ends);
        assert!((end - phi(2.5)).abs() < 4e-15, "{count} steps: {end} {}", phi(2.5));
    }
}

#[test]
fn a_million_steps_lose_no_angle() {
    // 16,000 turns at a speed that is no round number; rounded at each step φ would be off by some 1e-9.
    let (w, time) = (100.1, 1e6);
    let mut cam = integrating(time);
    let end = speed_steps(&mut cam, &[w], time, (1..=1_000_000).map(|n| time + 1e-3 * f64::from(n)));
    let exact = Double::from(0.25) + two_product(w, 1e3);
    assert_eq!(end, exact.hi);
    assert!((cam.below - exact.lo).abs() < 1e-15, "{} {}", cam.below, exact.lo);
}

#[test]
fn a_speed_without_derivatives_is_held() {
    let mut cam = integrating(0.0);
    cam.set_input(1, 4.0);
    cam.set_input_derivative(1, 1, 100.0);
    // The value that it belonged to is gone.
    cam.set_input(1, 2.0);
    assert_eq!((cam.motion(0.0).coefficients[..3].to_vec(), cam.angle(0.0, 0.5)), (vec![0.25, 2.0, 0.0], 1.25));
    cam.set_input_derivative(1, 1, 4.0);
    assert_eq!((cam.motion(0.0).degree, cam.angle(0.0, 0.5)), (2, 1.75));
    let motion = cam.motion(0.0);
    cam.step_done(&motion, 0.5);
    // The speed stays, with the derivative held for its step.
    assert_eq!(cam.motion(0.5).coefficients[..3], [1.75, 2.0, 0.0]);
    cam.start(0.0);
    assert_eq!(cam.motion(0.0).coefficients[..3], [0.25, 2.0, 0.0]);
}
