//! The motion of permanent contact around the turn, and the exact instants at which its contact force changes sign.

use super::law::changes;
use super::machine::{Machine, Moment};
use crate::report::terminal::shown;
use crate::report::unit::HZ;
use crate::search;
use camdrive::drives::Fault;
use camdrive::drives::backlash::{Parameters, Scene};
use camdrive::motion::Fourier;

/// Samples per radian of the fastest vibration. Two zeros between neighbours are seen by the slopes at both.
const SAMPLES: f64 = 8.0;
/// More would take longer than a second.
const MOST_SAMPLES: f64 = 3e5;
/// Fewer would miss the lobes of a simple law.
const LEAST_SAMPLES: f64 = 256.0;
/// A force this small a part of the largest one is a rest: ten times the part that the drive treats as rounding of its terms.
const ROUNDING: f64 = 1e-11;

/// A sample of the periodic motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Time since φ = 0 (s).
    pub time: f64,
    /// F_K (N), its rate (N/s).
    pub force: [f64; 2],
    /// q (m), q̇ (m/s).
    pub q: [f64; 2],
}

impl From<Moment> for Sample {
    fn from(moment: Moment) -> Self {
        Sample { time: moment.time, force: moment.force, q: moment.q }
    }
}

/// A zero of the contact force with a change of sign.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Release {
    /// Time since φ = 0 (s).
    pub time: f64,
    /// φ (rad).
    pub phi: f64,
    /// True if F_K falls: a release from flank A.
    pub falling: bool,
    /// The largest contact force since the zero before: the passage is followed from there on.
    pub before: Sample,
}

/// The periodic motion of permanent contact.
pub struct ContactMotion {
    /// Around the turn, from φ = 0 on, the last one a turn after the first.
    pub samples: Vec<Sample>,
    /// The zeros of the force, by time.
    pub releases: Vec<Release>,
}

impl ContactMotion {
    /// The periodic motion of the machine on locked flanks. Lobes of F_K below the part `ignore` of the largest one are no
    /// passages.
    pub fn new(machine: &mut Machine, scene: &Scene, ignore: f64) -> Result<Self, Fault> {
        let count = count(scene, machine.w)?;
        let step = machine.turn() / count as f64;
        let start = match scene.cam.series() {
            Some(series) => Some(forced(series, scene, machine.w)?),
            None => None,
        };
        let first = machine.begin(0.0, start, true)?;
        let mut samples = vec![Sample::from(first)];
        for i in 1..=count {
            machine.go(i as f64 * step)?;
            samples.push(Sample::from(machine.moment()?));
        }
        let mut motion = ContactMotion { samples, releases: Vec::new() };
        motion.releases = motion.find(machine, &scene.parameters, ignore)?;
        Ok(motion)
    }

    /// The state `time` after φ = 0, a turn at most.
    pub fn at(&self, machine: &mut Machine, time: f64) -> Result<Sample, Fault> {
        let turn = machine.turn();
        let time = time - turn * (time / turn).floor();
        let after = self.samples.partition_point(|sample| sample.time <= time);
        from(machine, &self.samples[after.saturating_sub(1)], time)
    }

    /// The largest |F_K| (N), found between the samples where its rate vanishes.
    pub fn largest_force(&self, machine: &mut Machine) -> Result<f64, Fault> {
        let size = |sample: &Sample| sample.force[0].abs();
        let sampled = self.samples.iter().map(size).fold(0.0, f64::max);
        let mut largest = sampled;
        for pair in self.samples.windows(2) {
            // Between two samples the force grows by far less than a tenth of the largest one.
            if size(&pair[0]).max(size(&pair[1])) > 0.9 * sampled {
                largest = largest.max(size(&zero(machine, [pair[0], pair[1]], 1, 0.0)?));
            }
        }
        machine.begin(0.0, Some(self.samples[0].q), true)?;
        Ok(largest)
    }

    fn find(&self, machine: &mut Machine, parameters: &Parameters, ignore: f64) -> Result<Vec<Release>, Fault> {
        let largest = self.samples.iter().fold(0.0f64, |largest, sample| largest.max(sample.force[0].abs()));
        let rounding = ROUNDING * largest;
        // The sign of the force, or of the one to come; 0 in a rest.
        let sign = |sample: &Sample| {
            let to_come = SAMPLES * self.samples[1].time * sample.force[1];
            [sample.force[0], to_come].into_iter().find(|force| force.abs() > rounding).map_or(0.0, f64::signum)
        };
        let mut zeros = Vec::new();
        for (sample, pair) in self.samples.windows(2).enumerate() {
            let [a, b] = [pair[0], pair[1]];
            let signs = [sign(&a), sign(&b)];
            if signs[0] != signs[1] {
                // A rest begins and ends at a force of rounding size.
                let of = if signs.contains(&0.0) { rounding * (signs[0] + signs[1]) } else { 0.0 };
                zeros.push(Zero { sample, at: zero(machine, [a, b], 0, of)?, beyond: b });
            } else if turns_back(signs[0], &a, &b) {
                let extreme = zero(machine, [a, b], 1, 0.0)?;
                if signs[0] * extreme.force[0] < -rounding {
                    zeros.push(Zero { sample, at: zero(machine, [a, extreme], 0, 0.0)?, beyond: extreme });
                    zeros.push(Zero { sample, at: zero(machine, [extreme, b], 0, 0.0)?, beyond: b });
                }
            }
        }
        let peaks: Vec<Sample> = (0..zeros.len()).map(|lobe| self.peak(&zeros, lobe)).collect();
        let heights: Vec<f64> = peaks.iter().map(|peak| peak.force[0]).collect();
        // Angles count from φ = 0 again.
        machine.begin(0.0, Some(self.samples[0].q), true)?;
        let release = |lobe: usize| {
            let (time, falling) = (zeros[lobe].at.time, heights[lobe] < 0.0);
            let mut before = peaks[(lobe + peaks.len() - 1) % peaks.len()];
            if before.force[0].abs() <= rounding {
                // Nothing presses in a rest. F_K = 0 and a rate of this sign put m1 on the flank that it will leave; the effect
                // stays a rounding.
                let Parameters { c, b, m2, .. } = *parameters;
                let rate = if falling { -0.01 } else { 0.01 } * rounding / ((c * m2).sqrt() + b);
                before.q = [-b * rate / c, rate];
            }
            Release { time, phi: machine.angle(time), falling, before }
        };
        Ok(changes(&heights, rounding.max(ignore * largest)).into_iter().map(release).collect())
    }

    /// The sample with the largest |F_K| from zero `lobe` to the next one.
    fn peak(&self, zeros: &[Zero], lobe: usize) -> Sample {
        let (from, to) = (&zeros[lobe], &zeros[(lobe + 1) % zeros.len()]);
        // The last sample is the first one, a turn later.
        let last = self.samples.len() - 1;
        let inner = |from: usize, to: usize| self.samples.get(from..to).unwrap_or_default().iter();
        let parts = if lobe + 1 == zeros.len() {
            [inner(from.sample + 1, last), inner(0, to.sample + 1)]
        } else {
            [inner(from.sample + 1, to.sample + 1), inner(0, 0)]
        };
        let larger =
            |best: Sample, sample: &Sample| if sample.force[0].abs() > best.force[0].abs() { *sample } else { best };
        parts.into_iter().flatten().fold(from.beyond, larger)
    }
}

/// A zero of the force.
struct Zero {
    /// The sample before it.
    sample: usize,
    at: Sample,
    /// A place between it and the next zero.
    beyond: Sample,
}

/// q and q̇ of the forced vibration at φ = 0: each harmonic of U answers by itself, q̈ + (b/m2) q̇ + ω² q = −Ü. Without damping
/// it is the periodic motion without free vibration: one of many if a multiple of the speed that U does not contain is the
/// natural frequency.
fn forced(series: &Fourier, scene: &Scene, w: f64) -> Result<[f64; 2], Fault> {
    let (square, damping) = (scene.parameters.c / scene.parameters.m2, scene.parameters.b / scene.parameters.m2);
    let mut state = [0.0; 2];
    for (k, (a, b)) in series.a.iter().zip(&series.b).enumerate().skip(1) {
        if *a == 0.0 && *b == 0.0 {
            continue;
        }
        let rate = k as f64 * w;
        let [real, imaginary] = [square - rate * rate, damping * rate];
        let size = real * real + imaginary * imaginary;
        if size <= (RESONANCE * square) * (RESONANCE * square) {
            return Err(Fault::new(format!(
                "harmonic {k} of U is in resonance: {k} times the speed is the natural frequency ({}), and nothing damps it",
                shown(square.sqrt(), &HZ)
            )));
        }
        // (a − ib)/(real + i imaginary) times (kw)².
        let [re, im] = [a * real - b * imaginary, -b * real - a * imaginary].map(|part| rate * rate * part / size);
        state = [state[0] + re, state[1] - rate * im];
    }
    Ok(state)
}

/// An undamped harmonic as close to the natural frequency has an amplitude without a correct digit.
const RESONANCE: f64 = 1e-12;

/// The number of samples of the turn that shows every vibration.
fn count(scene: &Scene, w: f64) -> Result<usize, Fault> {
    let natural = (scene.parameters.c / scene.parameters.m2).sqrt() / w.abs();
    // Only the harmonics of a Fourier law stay in the periodic motion; other laws excite the natural frequency.
    let fastest =
        if scene.cam.series().is_some() { scene.cam.resolution() } else { scene.cam.resolution().max(natural) };
    let count = (SAMPLES * std::f64::consts::TAU * fastest).ceil().max(LEAST_SAMPLES);
    if count > MOST_SAMPLES {
        return Err(Fault::new(format!(
            "the contact force over a turn needs {count:.0e} samples, more than {MOST_SAMPLES:.0e}: U changes as fast as a \
             harmonic of the order {:.0}, and the natural frequency is {natural:.3e} times the speed; the formulas remain",
            scene.cam.resolution()
        )));
    }
    Ok(count as usize)
}

/// The motion at `time` from a sample before it.
fn from(machine: &mut Machine, sample: &Sample, time: f64) -> Result<Sample, Fault> {
    machine.begin(machine.w * sample.time, Some(sample.q), true)?;
    machine.go(time - sample.time)?;
    Ok(Sample { time, ..Sample::from(machine.moment()?) })
}

/// True if the force comes so near to zero between two samples of one sign that it may cross it: its slopes point to
/// zero at the first and away from it at the second, and are steep enough.
fn turns_back(sign: f64, a: &Sample, b: &Sample) -> bool {
    let h = b.time - a.time;
    let [low, high] = [sign * a.force[1] * h, sign * b.force[1] * h];
    // A force that starts with these slopes changes by less than either of them over the interval.
    low < 0.0 && high > 0.0 && a.force[0].abs().min(b.force[0].abs()) < low.abs().max(high)
}

/// The place between two samples at which the force (`order` 0) or its rate (1) has this value; the second sample if neither
/// has it on the other side.
fn zero(machine: &mut Machine, [a, b]: [Sample; 2], order: usize, of: f64) -> Result<Sample, Fault> {
    let ends = [a, b].map(|sample| sample.force[order] - of);
    if ends[0] * ends[1] > 0.0 {
        return Ok(b);
    }
    let mut value = |time: f64| from(machine, &a, time).map_or(f64::NAN, |sample| sample.force[order] - of);
    let time = search::zero(&mut value, [a.time, b.time], ends, 0.0);
    from(machine, &a, time)
}
