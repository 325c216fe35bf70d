//! Motion of the shaft, inputs and the variables of the law.

use super::*;
use crate::drives::variable::Access;
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

/// A drive that is nothing but its cam.
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
        let Access::Set { get, set } = v.access else { panic!("{name} is computed") };
        set(&mut bare, v.index, value);
        assert_eq!(get(&bare, v.index), value, "{name}");
        bare.cam().law.clone()
    };
    set("cam.rise", 3.0);
    set("cam.return_law", 5.0);
    let changed = set("cam.stroke", 0.05);
    assert!(changed.at(3.5).0[0] == 0.05 && law.at(3.5).0[0] != 0.05 && changed.validate() == Ok(()));
    assert!(set("cam.upper_dwell", 2.0).validate().unwrap_err().contains("upper_dwell = 2 rad"));
}
