//! The motion law of a cam: `[cam]` and `[follower.cam]`.

use super::section::{ANY, Section};
use crate::drives::unit::{self, Quantity};
use crate::motion::{Fourier, MotionLaw};
use std::path::Path;

/// The highest harmonic of a series: beyond it the FMU would have more than 500 variables for the cam alone.
const HIGHEST_HARMONIC: usize = 256;

/// The kinds of law.
#[derive(Clone, Copy)]
enum Law {
    Fourier,
}

const LAWS: &[(&[&str], Law)] = &[(&["fourier", "hs", "harmonic_series"], Law::Fourier)];

/// What people write for the keys.
const SYNONYMS: &[(&str, &str)] = &[("cos", "a"), ("sin", "b"), ("type", "law"), ("kind", "law"), ("lift", "stroke")];

/// The law of this section; `quantity` is that of U, a length where a cam moves a follower.
pub fn read(section: &Section<'_>, quantity: &'static Quantity, _folder: &Path) -> Option<MotionLaw> {
    let law = section.choice("law", LAWS).map(|law| match law {
        Law::Fourier => fourier(section, quantity).map(MotionLaw::Fourier),
    });
    // Which keys belong here is not known before the kind of law is.
    if law.is_some() {
        section.finish(SYNONYMS);
    }
    law?
}

/// U = a₀ + Σ aₖ cos kφ + bₖ sin kφ.
fn fourier(section: &Section<'_>, quantity: &'static Quantity) -> Option<Fourier> {
    let scale = section.optional("scale", quantity, ANY);
    let scaled = section.has("scale");
    let coefficients = if scaled { &unit::NUMBER } else { quantity };
    let (a, b) = (section.reals("a", coefficients), section.reals("b", coefficients));
    if !section.has("a") {
        let fault = section.fault(format!("`{}` is missing", section.path_of("a")));
        section
            .faults
            .report(fault.admissible("a list of numbers").hint("add the cosine coefficients a = [a0, a1, …]"));
        return None;
    }
    if scale == Some(Some(0.0)) {
        let fault = section.fault_of("scale", format!("`{}`: the cam would not move", section.path_of("scale")));
        section.faults.report(fault.admissible("a length other than 0"));
    }
    let (a, b, scale) = (a?, b?, scale?.unwrap_or(1.0));
    for (key, count, most) in [("a", a.len(), HIGHEST_HARMONIC + 1), ("b", b.len(), HIGHEST_HARMONIC)] {
        if count > most {
            let fault = section.fault_of(key, format!("`{}` has {count} coefficients", section.path_of(key)));
            section.faults.report(fault.admissible(format!("at most {most}")));
        }
    }
    let scaled = |list: Vec<f64>| list.into_iter().map(|x| x * scale);
    Some(Fourier::new(scaled(a).collect(), std::iter::once(0.0).chain(scaled(b)).collect()))
}

/// The mean of U′² over the turn [m²/rad²].
pub fn mean_square_slope(law: &MotionLaw) -> f64 {
    // The midpoint rule is exact for a series of up to 2048 harmonics and of error 1e-7 for a law with corners in U″.
    const COUNT: usize = 4096;
    let step = std::f64::consts::TAU / COUNT as f64;
    (0..COUNT).map(|i| law.at((i as f64 + 0.5) * step).0[1].powi(2)).sum::<f64>() / COUNT as f64
}
