//! The elastic member of a drive: natural frequency, damping ratio, deformation, resonances.

use super::{Overview, Resonance};
use crate::harmonic_analysis::Complex;
use crate::law_motions::stroke;
use crate::oscillator::{PeriodicOscillator, Terms, joined};
use crate::search::{greatest, segments};
use crate::stability::system::sample;
use camdrive::drives::elastic_output::Parameters;
use camdrive::drives::follower::load::Load;
use camdrive::drives::unit;
use camdrive::motion::MotionLaw;
use camdrive::numerics::angle::reduce;
use std::f64::consts::TAU;

/// Harmonics among which resonances are searched; the drives of machines run above ω₀/48.
const HARMONICS: usize = 48;

/// A harmonic that deforms by less than this part of the strongest at resonance is not listed.
const OF_NO_ACCOUNT: f64 = 1e-4;

/// Variation of a coefficient below this part is rounding.
const SAME: f64 = 1e-12;

/// An undamped harmonic meets the natural frequency if its stiffness and inertia cancel to this part.
const MET: f64 = 1e-12;

/// The number of listed resonances.
const TOLD: usize = 3;

/// A mass m on damper and spring b, c after a cam: m q̈ + b q̇ + c q = −Ω² m U″ + F_L(U + q, ΩU′ + q̇, φ) without an input.
pub fn behind_cam(law: &MotionLaw, own: Parameters, load: &Load, speed: Option<f64>) -> PeriodicOscillator {
    let Parameters { m, b, c } = own;
    let (cam, load) = (law.clone(), load.clone());
    let (breakpoints, segments) = joined(law.breakpoints(), load.process.as_ref());
    let (damping, stiffness) = (load.damping.unwrap_or(0.0), load.stiffness());
    let cost = law.cost() + load.process.as_ref().map_or(0.0, MotionLaw::cost);
    let process = load.process.clone();
    let reach = |[of_law, of_process]: &[usize; 2]| {
        let process = process.as_ref().map_or(1.0, |process| process.resolution_in(*of_process));
        1.0 / law.resolution_in(*of_law).max(process).max(1.0)
    };
    let reaches: Vec<f64> = segments.iter().map(reach).collect();
    let terms = move |segment: usize, phi: f64| {
        let [of_law, of_process] = segments[segment];
        let [u, u1, u2, ..] = cam.at_in(of_law, phi).0;
        let process = load.process.as_ref().map(|process| process.at_in(of_process, phi).0[0]);
        let f = load.force(m, [u, 0.0], process, None);
        Terms { m, b: b + damping, c: c + stiffness, f, f1: -damping * u1, f2: -m * u2, ..Terms::default() }
    };
    PeriodicOscillator {
        terms: Box::new(terms),
        breakpoints,
        reach: Box::new(move |segment| reaches[segment]),
        cost,
        inertia_turns: false,
        own: None,
        speed,
        start: 0.0,
        coordinate: &unit::LENGTH,
        load: &unit::FORCE,
        note: None,
    }
}

impl Overview {
    /// Adds the figures of an elastic member; with the law that it moves, and whether it twists the shaft of its cam.
    pub(super) fn elastic(&mut self, oscillator: &PeriodicOscillator, moved: Option<(&MotionLaw, bool)>) {
        let turn = sample(oscillator, HARMONICS);
        let mean = |term: fn(&Terms) -> f64| turn.iter().map(|(_, weight, t)| weight * term(t)).sum::<f64>();
        let own = Terms { m: mean(|t| t.m), b: mean(|t| t.b), c: mean(|t| t.c), ..Terms::default() };
        let Terms { m, b, c, .. } = own;
        // A drive with a negative mean stiffness has no natural frequency.
        if !(m > 0.0 && c > 0.0) {
            return;
        }
        let w0 = (c / m).sqrt();
        self.speed("natural_frequency", w0);
        self.figure("damping_ratio", b / (2.0 * m * w0), "1");
        let (length, load) = (oscillator.coordinate.unit, oscillator.load.unit);
        if let Some(speed) = oscillator.speed {
            self.figure("frequency_ratio", speed.abs() / w0, "1");
            let segments = segments(&oscillator.breakpoints);
            let signed = |segment: usize, phi: f64| {
                let t = (oscillator.terms)(segment, reduce(phi.into()));
                t.f + speed * t.f1 + speed * speed * t.f2
            };
            let load_at = |segment: usize, phi: f64| signed(segment, phi).abs();
            let [high, low] = [1.0, -1.0].map(|sign| sign * greatest(&segments, |i, phi| sign * signed(i, phi)).value);
            let largest = high.max(-low);
            self.swings.push(0.5 * (high - low) / c);
            if moved.is_none_or(|(_, twists)| twists) {
                self.figure(
                    if load == "N" { "largest_kinetostatic_force" } else { "largest_kinetostatic_torque" },
                    largest,
                    load,
                );
            }
            self.figure("largest_kinetostatic_deformation", largest / c, length);
            if let Some((law, twists)) = moved {
                let middles = segments.iter().map(|[low, high]| (0.5 * (low + high)).rem_euclid(TAU));
                let of_law: Vec<usize> = middles.map(|middle| law.segment(middle, true)).collect();
                let slope = |i: usize, phi: f64| law.at_in(of_law[i], reduce(phi.into())).0[1].abs();
                let missed = |i: usize, phi: f64| load_at(i, phi) * slope(i, phi);
                let missed = if twists { greatest(&segments, missed).value } else { largest };
                let share = missed / c / stroke(law, |u| u[0]);
                if share.is_finite() {
                    self.share("kinetostatic_deformation_of_stroke", share);
                }
            }
        }
        let departs = |value: f64, mean: f64| (value - mean).abs() > SAME * mean.abs();
        self.varies = turn.iter().any(|(.., t)| departs(t.m, m) || departs(t.b, b) || departs(t.c, c));
        if !self.varies {
            (self.resonances, self.every) = resonances(&turn, &own, oscillator.speed, length);
        }
    }
}

/// The listed resonances, and those of all harmonics.
fn resonances(
    turn: &[(f64, f64, Terms)],
    own: &Terms,
    speed: Option<f64>,
    unit: &'static str,
) -> (Vec<Resonance>, Vec<Resonance>) {
    let Terms { m, b, c, .. } = *own;
    let w0 = (c / m).sqrt();
    let mut waves = [[Complex::default(); 3]; HARMONICS + 1];
    for (phi, weight, t) in turn {
        let (step, mut wave) = (Complex::cis(-phi), Complex::from(2.0 * weight));
        for sums in &mut waves {
            *sums = [sums[0] + wave * t.f, sums[1] + wave * t.f1, sums[2] + wave * t.f2];
            wave *= step;
        }
    }
    // The amplitude of harmonic k of the load at the speed w.
    let load = |k: usize, w: f64| (waves[k][0] + waves[k][1] * w + waves[k][2] * (w * w)).norm();
    let at_resonance: Vec<f64> = (1..=HARMONICS).map(|k| load(k, w0 / k as f64)).collect();
    let least = OF_NO_ACCOUNT * at_resonance.iter().copied().fold(0.0, f64::max);
    let mut told: Vec<usize> = (1..=HARMONICS).filter(|k| at_resonance[k - 1] > least).collect();
    match speed {
        Some(speed) if speed != 0.0 => {
            let distance = |k: &usize| (*k as f64 * speed.abs() / w0).ln().abs();
            told.sort_by(|i, k| distance(i).total_cmp(&distance(k)));
        }
        _ => told.sort_by(|i, k| at_resonance[k - 1].total_cmp(&at_resonance[i - 1])),
    }
    told.truncate(TOLD);
    told.sort_unstable();
    let resonance = |harmonic: usize| {
        let amplitude = |speed: f64| {
            let w = harmonic as f64 * speed;
            let far = (c - m * w * w).hypot(b * w);
            // Without damping roundings would decide on the amplitude in resonance.
            if far <= MET * c { f64::INFINITY } else { load(harmonic, speed) / far }
        };
        let resonant = at_resonance[harmonic - 1] / (b * w0);
        Resonance {
            harmonic,
            speed: w0 / harmonic as f64,
            amplitude: speed.map(amplitude).filter(|q| !q.is_nan()),
            resonant_amplitude: (b > 0.0).then_some(resonant),
            unit,
        }
    };
    (told.into_iter().map(resonance).collect(), (1..=HARMONICS).map(resonance).collect())
}
