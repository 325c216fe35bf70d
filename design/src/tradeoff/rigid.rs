//! The drive in its rigid limit, c → ∞, by formulas for its outputs; for a machine, the limit without fluctuation of the speed.

use crate::resource::Scene;
use camdrive::drives::backlash;
use camdrive::drives::elastic_output;
use camdrive::drives::elastic_shaft::{self, Parameters};
use camdrive::drives::follower::load::Load;
use camdrive::drives::parametric::law::Law;
use camdrive::drives::rigid_machine::{self, Inertia, Motor, Place};
use camdrive::motion::MotionLaw;
use camdrive::numerics::angle;
use camdrive::numerics::double_double::Double;

/// Outputs that follow from the motion of the shaft alone.
pub struct Formula {
    /// The names of the outputs.
    pub outputs: Vec<String>,
    /// Appends their values, in the same order.
    pub evaluate: Evaluation,
}

type Evaluation = Box<dyn Fn(&Shaft, &mut Vec<f64>)>;

/// The motion of the shaft at an instant.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Shaft {
    /// φ (rad).
    pub phi: f64,
    /// φ̇ (rad/s).
    pub w: f64,
    /// φ̈ (rad/s²).
    pub a: f64,
}

/// A follower without any elasticity: U, U′ and the derivatives of y = U(φ).
struct RigidFollower {
    /// y = U (m).
    y: f64,
    /// ẏ = U′ω (m/s).
    y_dot: f64,
    /// ÿ = U″ω² + U′α (m/s²).
    y_dot_dot: f64,
    /// U′ (m/rad).
    slope: f64,
}

impl RigidFollower {
    /// The follower of `law` on this shaft.
    fn of(law: &MotionLaw, shaft: &Shaft) -> Self {
        let &Shaft { phi, w, a } = shaft;
        let [y, u1, u2, ..] = law.at(reduced(phi)).0;
        RigidFollower { y, y_dot: u1 * w, y_dot_dot: u2 * w * w + u1 * a, slope: u1 }
    }
}

fn reduced(phi: f64) -> f64 {
    angle::reduce(Double::from(phi))
}

/// The rigid drive, or the machine at its mean speed, with the feature left out and its replacement; None for coefficients that
/// are series and for a motor whose torque is an input.
pub fn of(scene: &Scene) -> Option<(&'static str, &'static str, Formula)> {
    let of = |feature: &'static str, instead: &'static str, outputs: &str, evaluate: Evaluation| {
        let outputs = outputs.split(' ').map(str::to_owned).collect();
        Some((feature, instead, Formula { outputs, evaluate }))
    };
    match scene.clone() {
        Scene::ElasticOutput(scene) => {
            let (feature, instead) = ("the elasticity of the output member", "rigid: y = U(φ), force = m ÿ");
            let outputs = "phi w x y der(y) der(y,2) q der(q) der(q,2) force tau";
            of(feature, instead, outputs, elastic_output(scene))
        }
        Scene::ElasticShaft(scene) => {
            let (instead, more) = match scene.load.is_none() {
                true => ("rigid: ψ = φ, y = U(φ), tau = J φ̈ + U′ m ÿ", ""),
                false => ("rigid: ψ = φ, y = U(φ), tau = J φ̈ + U′ (m ÿ − F_L)", " contact_force"),
            };
            let outputs = format!("phi w psi der(psi) der(psi,2) q der(q) y der(y) tau{more}");
            of("the elasticity of the shaft", instead, &outputs, elastic_shaft(scene))
        }
        Scene::BacklashDrive(scene) => {
            let (feature, instead) = ("clearance and elasticity", "rigid: x1 = y = U(φ), force = (m1 + m2) ÿ");
            let outputs = "phi w x1 der(x1) der(x1,2) y der(y) der(y,2) q der(q) gap force tau";
            of(feature, instead, outputs, backlash(scene))
        }
        Scene::ParametricDrive(scene) => {
            let outputs = "phi w psi der(psi) der(psi,2) q der(q) tau tau_parametric stiffness";
            let instead = if scene.load.is_none() {
                "rigid: ψ = φ, tau = J α − f"
            } else {
                "rigid: ψ = φ, tau = J α − f − F_L"
            };
            let rigid = matches!(scene.law, Law::Crank(_)).then(|| crank(&scene.law, scene.load.clone()));
            rigid.and_then(|rigid| of("the elasticity", instead, outputs, rigid))
        }
        Scene::RigidMachine(scene) if scene.motor == Motor::Input => None,
        Scene::RigidMachine(scene) => {
            let mut outputs = "phi w a J E".to_owned();
            if scene.motor != Motor::None {
                outputs += " M_an";
            }
            for j in 1..=scene.followers.len() {
                outputs += &format!(" U[{j}] der(U[{j}]) der(U[{j}],2)");
            }
            of("the speed fluctuation", "constant mean speed", &outputs, machine(scene))
        }
        Scene::DriveTrain(_) => None,
    }
}

/// q → 0 while force = −(c q + b q̇) = m ÿ stays, as for c → ∞ in the equation of motion.
fn elastic_output(scene: elastic_output::Scene) -> Evaluation {
    Box::new(move |shaft, out| {
        let RigidFollower { y, y_dot, y_dot_dot, slope } = RigidFollower::of(&scene.cam, shaft);
        let force = scene.parameters.m * y_dot_dot;
        out.extend([shaft.phi, shaft.w, y, y, y_dot, y_dot_dot, 0.0, 0.0, 0.0, force, slope * force]);
    })
}

/// q → 0 while tau = −(c q + b q̇) = (J + m U′²) α + m U′U″ ω² − U′F_L stays; the mass takes U′ times its force m ÿ − F_L from
/// it, with F_L without an input.
fn elastic_shaft(scene: elastic_shaft::Scene) -> Evaluation {
    Box::new(move |shaft, out| {
        let RigidFollower { y, y_dot, y_dot_dot, slope } = RigidFollower::of(&scene.cam, shaft);
        let Parameters { m, inertia, .. } = scene.parameters;
        let process = scene.load.process.as_ref().map(|process| process.at(reduced(shaft.phi)).0[0]);
        let force = m * y_dot_dot - scene.load.force(m, [y, y_dot], process, None);
        let tau = inertia * shaft.a + slope * force;
        out.extend([shaft.phi, shaft.w, shaft.phi, shaft.w, shaft.a, 0.0, 0.0, y, y_dot, tau]);
        out.extend((!scene.load.is_none()).then_some(force));
    })
}

/// Both masses ride on flank A as one: F_K = (m1 + m2) Ü.
fn backlash(scene: backlash::Scene) -> Evaluation {
    let m = scene.parameters.m1 + scene.parameters.m2;
    Box::new(move |shaft, out| {
        let RigidFollower { y, y_dot, y_dot_dot, slope } = RigidFollower::of(&scene.cam, shaft);
        let force = m * y_dot_dot;
        out.extend([shaft.phi, shaft.w, y, y_dot, y_dot_dot, y, y_dot, y_dot_dot, 0.0, 0.0, 0.0, force, slope * force]);
    })
}

/// ψ = φ, while tau = J α − f − F_L stays, as for c_T → ∞ in the equation of motion; F_L without an input.
fn crank(law: &Law, load: Load) -> Evaluation {
    let coefficients = law.coefficients();
    Box::new(move |&Shaft { phi, w, a }, out| {
        let values = coefficients.at(reduced(phi));
        let process = load.process.as_ref().map(|process| process.at(reduced(phi)).0[0]);
        let tau = values.m[0] * a - values.f[0] - load.force(values.m[0], [phi, w], process, None);
        out.extend([phi, w, phi, w, a, 0.0, 0.0, tau, 0.0, values.c[0]]);
    })
}

/// φ̈ = 0, and the torque that this takes, M_an = ½ J′ω².
fn machine(scene: rigid_machine::Scene) -> Evaluation {
    let inertia = Inertia::new(scene.inertia, scene.followers.clone());
    Box::new(move |&Shaft { phi, w, a }, out| {
        let within = phi.rem_euclid(std::f64::consts::TAU);
        let [j, slope, ..] = inertia.at(Place::at(within), within);
        let torque = (scene.motor != Motor::None).then_some(0.5 * slope * w * w + j * a);
        out.extend([phi, w, a, j, 0.5 * j * w * w]);
        out.extend(torque);
        for follower in &scene.followers {
            let [y, y1, y2, ..] = follower.tool(follower.cam.at(reduced(phi)).0);
            out.extend([y, y1 * w, y2 * w * w + y1 * a]);
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use camdrive::drives::parametric::law::CrankLaw;
    use camdrive::motion::Fourier;
    use std::f64::consts::TAU;

    #[test]
    fn a_rigid_follower_moves_with_its_law() {
        let law = MotionLaw::Fourier(Fourier::new(vec![0.0, 0.0], vec![0.0, 2.0]));
        let shaft = Shaft { phi: 1.0 + 20.0 * std::f64::consts::TAU, w: 3.0, a: 5.0 };
        let rigid = RigidFollower::of(&law, &shaft);
        let (s, c) = 1.0_f64.sin_cos();
        assert!((rigid.y - 2.0 * s).abs() < 1e-13 && (rigid.y_dot - 6.0 * c).abs() < 1e-13);
        assert!((rigid.y_dot_dot - (-18.0 * s + 10.0 * c)).abs() < 1e-12 && (rigid.slope - 2.0 * c).abs() < 1e-13);
    }

    #[test]
    fn a_rigid_crank_bears_its_loads() {
        let series = |a: &[f64]| Fourier::new(a.to_vec(), Vec::new());
        let law = CrankLaw { inertia: 3.0, load: Some(series(&[5.0, 1.0])), ..CrankLaw::default() };
        let process = Some(MotionLaw::Fourier(series(&[0.0, 0.0, 40.0])));
        let load = Load { constant: Some(-7.0), damping: Some(0.5), process, ..Load::default() };
        let mut values = Vec::new();
        crank(&Law::Crank(law), load)(&Shaft { phi: 1.0 - TAU, w: 4.0, a: 6.0 }, &mut values);
        let expected = 3.0 * 6.0 - (5.0 + 1.0_f64.cos()) - (-7.0 - 0.5 * 4.0 + 40.0 * 2.0_f64.cos());
        assert!((values[7] - expected).abs() < 1e-12, "{values:?} {expected}");
    }
}
