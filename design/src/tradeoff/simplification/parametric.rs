//! What the drive can be spared.

use super::{Shaft, Simplification, fewer_harmonics};
use camdrive::drives::cam_drive::{DriveMode, StartMode};
use camdrive::drives::cam_turn::turns;
use camdrive::drives::parametric::Scene;
use camdrive::drives::parametric::law::Law;
use camdrive::motion::{Fourier, MotionLaw};
use camdrive::numerics::angle;
use camdrive::numerics::double_double::Double;

/// The harmonics of c_T that a simpler crank keeps: its mean alone, the first one, the first two.
const HARMONICS: [(usize, &str); 3] =
    [(0, "its mean"), (2, "its mean and its harmonic 2"), (4, "its mean and its harmonics 2 and 4")];

pub fn of(scene: &Scene) -> Vec<Simplification<Scene>> {
    let mut list = Vec::new();
    let with = |change: &dyn Fn(&mut Scene)| {
        let mut simpler = scene.clone();
        change(&mut simpler);
        simpler
    };
    match &scene.law {
        Law::Crank(crank) => {
            list.push(rigid(scene));
            for (order, instead) in HARMONICS {
                if crank.harmonics.is_none_or(|own| order < own) {
                    let simpler = with(&|s| {
                        if let Law::Crank(crank) = &mut s.law {
                            crank.harmonics = Some(order);
                        }
                    });
                    let feature = if order == 0 {
                        "the variation of the stiffness".to_owned()
                    } else {
                        format!("harmonics of the stiffness above {order}")
                    };
                    list.push(Simplification::scene(&feature, instead, simpler));
                }
            }
            if crank.damping > 0.0 {
                let simpler = with(&|s| {
                    if let Law::Crank(crank) = &mut s.law {
                        crank.damping = 0.0;
                    }
                });
                list.push(Simplification::scene("damping", "b_T = 0", simpler));
            }
        }
        Law::Series(law) => {
            type Pick = fn(&mut Scene) -> Option<&mut Fourier>;
            let series: [(&str, &Fourier, Pick); 3] = [
                ("mass", &law.m, |s| if let Law::Series(law) = &mut s.law { Some(&mut law.m) } else { None }),
                ("damping", &law.b, |s| if let Law::Series(law) = &mut s.law { Some(&mut law.b) } else { None }),
                ("stiffness", &law.c, |s| if let Law::Series(law) = &mut s.law { Some(&mut law.c) } else { None }),
            ];
            for (name, own, pick) in series {
                let replaced = |by: Fourier| with(&|s| pick(s).into_iter().for_each(|series| *series = by.clone()));
                let mean = Fourier::new(vec![own.a[0]], Vec::new());
                if own.bound(1) > 0.0 {
                    let feature = format!("the variation of the {name}");
                    list.push(Simplification::scene(&feature, "its mean", replaced(mean)));
                }
                for fewer in fewer_harmonics(&MotionLaw::Fourier(own.clone())) {
                    let feature = format!("{} of the {name}", fewer.feature);
                    let rest = fewer.law.series().cloned().unwrap_or_else(|| own.clone());
                    list.push(Simplification::scene(&feature, &fewer.instead, replaced(rest)));
                }
            }
            if law.b.bound(0) > 0.0 {
                let none = Fourier::new(vec![0.0], Vec::new());
                let simpler = with(&|s| {
                    if let Law::Series(law) = &mut s.law {
                        law.b = none.clone();
                    }
                });
                list.push(Simplification::scene("damping", "b = 0", simpler));
            }
        }
    }
    if matches!(scene.drive, DriveMode::Constant { w, .. } if turns(w)) && scene.start.mode != StartMode::SteadyState {
        let steady = with(&|s| s.start.mode = StartMode::SteadyState);
        list.push(Simplification::scene("the transient", "start on the periodic motion", steady));
    }
    list
}

/// The crank drive without elasticity: ψ = φ, while tau = J α − f stays, as for c_T → ∞ in the equation of motion.
fn rigid(scene: &Scene) -> Simplification<Scene> {
    let coefficients = scene.law.coefficients();
    Simplification::formula(
        "the elasticity",
        "rigid: ψ = φ, tau = J α − f",
        &["phi", "w", "psi", "der(psi)", "der(psi,2)", "q", "der(q)", "tau", "tau_parametric", "stiffness"],
        move |&Shaft { phi, w, a }, out| {
            let values = coefficients.at(angle::reduce(Double::from(phi)));
            let tau = values.m[0] * a - values.f[0];
            out.copy_from_slice(&[phi, w, phi, w, a, 0.0, 0.0, tau, 0.0, values.c[0]]);
        },
    )
}
