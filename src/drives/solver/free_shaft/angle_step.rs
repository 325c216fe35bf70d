//! The motion in the angle: the energy over a step of φ, and the duration of the step.
//!
//! With σ the sense of rotation, ψ = σφ and E = ½J φ̇² the equation of motion is
//!
//! dE/dψ = σ(M_an − τ),  φ̇ = σ√(2E/J),  dt/dψ = 1/|φ̇|
//!
//! as long as the shaft turns. J′ drops out, J enters only by its value at the angle, which a mesh tabulates once for all turns,
//! and there is one unknown. Without torques E is constant to the last digit.
//!
//! Method: Gauss collocation of order 16 for E. Sweeps Eᵢ ← E₀ + h Σ aᵢⱼ N(Eⱼ) contract by about h ∂N/∂E; a motor that
//! is too stiff for them gets Newton's method. The slowness 1/φ̇ at the nodes and at both ends gives t(ψ), of degree
//! 10; its ends have the order 16 too. A communication point lies somewhere in the step: Newton's method on that
//! polynomial finds the angle. Errors between the ends of steps do not add up.
//!
//! Source: E. Hairer, G. Wanner, *Solving Ordinary Differential Equations II*, 2nd ed., Springer 1996, section IV.5.

use crate::drives::shaft::free::torques::Torques;
use crate::numerics::double_double::Double;
use crate::numerics::gauss::{ABSCISSAE, MATRIX, NOISE_OF_MODES, STAGES, WEIGHTS};
use crate::numerics::interpolant::{
    COEFFICIENTS, INTEGRATION, Interpolant, columns, combine, decay, integrated, modes, neglected,
};
use crate::numerics::lu::Lu;
use serde::{Deserialize, Serialize};

/// The columns of the Gauss matrix, for sums of whole columns.
static MATRIX_COLUMNS: [[f64; STAGES]; STAGES] = columns(&MATRIX);

/// h |∂N/∂E| from which on Newton's method is taken: the k-th sweep contracts by about this over k.
const STIFF: f64 = 1.0;

/// Sweeps or Newton iterations; more mean that the step is too long.
const ITERATIONS: usize = 14;

/// Iterations for the angle at a time; a polynomial yields some digits to start with and Newton's method doubles them.
const INVERSION: usize = 8;

/// Tolerance of the angle at a time, as multiple of the remainder of the equations: this error does not add up.
const INSTANT: f64 = 30.0;

/// The degree of the polynomial of N that is continued into the next step as a first guess. The coefficients decay by a
/// tenth or so per degree; those of higher degrees grow as much beyond the step.
const CONTINUED: usize = 5;

/// The largest ratio of a step to the previous one from which its first guess is continued: step control makes them up to four
/// times as long. After a sliver the continued polynomial is mere rounding, so far off that a sweep back from it looks like
/// contraction.
const STRETCH: f64 = 8.0;

/// The number of steps whose errors of E add up before the motor has removed the first of them.
const ACCUMULATION: f64 = 10.0;

/// Factor of the estimate over the part of the first neglected coefficient: further coefficients decay slowly and may have the same
/// sign. 99 of 100 random machines then stay below it.
const CAUTION: f64 = 8.0;

/// Effect of the rounding of E on N at the nodes, however steep N(E) is: E₀ + h Σ aᵢⱼ Nⱼ = Eᵢ, rounded by ε E, moves N by at most
/// this times ε E/h, the largest row sum of the inverse of (aᵢⱼ).
const STIFFEST: f64 = 273.2;

/// Errors that grow by more than e⁵⁰ in a step are lost anyway.
const LARGEST_EXPONENT: f64 = 50.0;

/// Energies of nodes below this part of the first are not accepted: the machine is about to stop.
const LEAST_ENERGY: f64 = 1e-3;

/// The start of a step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Position {
    /// Time (s).
    pub time: Double,
    /// φ within the turn (rad).
    pub angle: Double,
    /// Whole turns.
    pub turns: f64,
    /// The cell of the mesh.
    pub cell: usize,
    /// E (J).
    pub energy: Double,
}

/// 2/J over a step, in ascending order of the angle.
#[derive(Clone, Copy)]
pub struct ReciprocalInertia {
    /// At the ends.
    pub ends: [f64; 2],
    /// At the Gauss nodes.
    pub nodes: [f64; STAGES],
}

impl ReciprocalInertia {
    /// Reverses the order.
    pub fn reverse(&mut self) {
        self.ends.reverse();
        self.nodes.reverse();
    }
}

/// Errors known so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Errors {
    /// Bound of the relative error of E.
    pub energy: f64,
    /// Bound of the error of the time at which an angle is reached (s).
    pub time: f64,
}

/// The errors of a step of length h from E₀ to E₁.
///
/// The polynomials neglect coefficients between the ends of the step. The first neglected ones are ν of N and σ of 1/φ̇ (as part of
/// its mean m). E errs by e and the angle at a given time by δ,
///
/// e = h ν/(17 E_min),  δ = h (σ m max|φ̇|/I + e/16),
///
/// since the integration divides by 2s + 1 = 17 and by I. If coefficients decay by r per order, r⁸ or r¹⁰ remains for the
/// polynomials and r¹⁶ for the sums at the end: there ln E errs by g = h ν/E_min · min(1, ν/max|N|), and the time by t = σ^(3/2).
/// These are the least errors. If waves of different lengths meet, the last coefficients decay only by d < 1, and the sums contain
/// terms three orders beyond, h ν/E_min · d³ and σ d³. The rounding of E changes N by ε (max|N| + E |∂N/∂E|), which is no error of
/// the polynomial and which no shorter step removes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Estimate {
    /// The error that decides whether the step is short enough, max(δ, e, 10 g, t).
    pub error: f64,
    /// δ (rad) and e, with caution.
    angle: f64,
    energy: f64,
    /// Growth factor of an error of ln E over the step, E₀/E₁ exp ∫ ∂N/∂E dψ.
    growth: f64,
    /// The error of ln E at the end that the step itself adds.
    added: f64,
    /// The relative error of the time that the step takes.
    time: f64,
}

/// The machine at an end of a step: E (J), |φ̇| (rad/s), N (N·m) and ∂N/∂E.
struct End {
    energy: f64,
    speed: f64,
    net: f64,
    slope: f64,
}

impl End {
    fn new(energy: f64, reciprocal: f64, torques: &Torques) -> Self {
        let speed = (energy * reciprocal).sqrt();
        let [net, slope] = torques.with_slope(speed, energy);
        End { energy, speed, net, slope }
    }
}

/// N over a step.
struct Net<'a> {
    /// At the nodes.
    nodes: &'a [f64; STAGES],
    /// Its coefficients.
    modes: &'a [f64],
    /// The residual of the collocation equations as part of E.
    left: f64,
}

impl Estimate {
    /// `slow` are the coefficients of 1/φ̇.
    fn new(length: f64, ends: [&End; 2], slow: &[f64], net: &Net) -> Self {
        let ([first, last], &Net { nodes, modes, left }) = (ends, net);
        let least = first.energy.min(last.energy);
        let largest = nodes.iter().fold(1e-300_f64, |largest, n| largest.max(n.abs()));
        let steep = 2.0 * first.energy * first.slope.abs().max(last.slope.abs());
        let noise = f64::EPSILON * (largest + steep.min(STIFFEST * first.energy / length));
        let nu = (neglected(modes) - NOISE_OF_MODES * noise).max(0.0);
        let sigma = neglected(slow) / slow[0];

        let energy = length * nu / ((2 * STAGES + 1) as f64 * least);
        let speeding = slow[0] * last.speed.max(first.speed);
        let angle = length * (sigma / INTEGRATION * speeding + 0.5 * energy / STAGES as f64);
        let rise = length * nu / least;
        let (quadrature, time) = (rise * (nu / largest).min(1.0), sigma * sigma.sqrt());
        let exponent = (0.5 * length * (first.slope + last.slope)).min(LARGEST_EXPONENT);
        Estimate {
            error: angle.max(energy).max(ACCUMULATION * quadrature).max(time),
            angle: CAUTION * angle + 0.5 * length * left,
            energy: CAUTION * energy + left,
            growth: first.energy / last.energy * exponent.exp(),
            added: quadrature.max(CAUTION * (rise * decay(modes).powi(3))) + length * noise / least + left,
            time: time.max(CAUTION * (sigma * decay(slow).powi(3))) + 2.0 * f64::EPSILON,
        }
    }
}

/// The change of a step that begins at another place and energy.
#[derive(Clone, Copy)]
pub struct Shift {
    /// Its new start.
    pub from: Position,
    /// The growth of E over the step (J), and its change.
    pub gain: Double,
    pub more: f64,
    /// The duration of the step (s), and its change.
    pub duration: Double,
    pub longer: f64,
    /// The change as a part of the duration.
    pub slower: f64,
    /// The resulting relative errors of E at the end and, in addition, between the ends.
    pub ends: f64,
    pub between: f64,
}

/// A step in the angle: the motion between its ends.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct AngleStep {
    /// Its start.
    pub from: Position,
    /// Its length (rad), positive.
    pub length: f64,
    /// Whether it ends with its cell.
    pub to_edge: bool,
    /// |φ̇| and N at the end (rad/s, N·m).
    pub end_speed: f64,
    pub end_net: f64,
    /// The time of its end (s).
    pub end: Double,
    /// E at the end (J).
    pub energy: Double,
    /// 1/|φ̇| over x ∈ [−1, 1] (s/rad).
    slowness: Interpolant,
    /// Its integral from 0 to −1.
    slowness_before: f64,
    /// Growth per second of the integral of 1/|φ̇| over x: 2/length unless the step is shifted.
    rate: f64,
    /// One over the duration (1/s).
    inverse_duration: f64,
    /// Rise of E with x beyond `work`, if the step is shifted (J).
    tilt: f64,
    /// x as a polynomial of the part s of the duration that has passed: −1 + Σ gⱼ sʲ⁺¹ (j < 5) + g₅ s³ (1 − s)³.
    guess: [f64; 6],
    /// A correction of x whose square is at most this has converged to a part of the tolerance.
    converged: f64,
    /// Legendre coefficients of N (N·m).
    net: [f64; STAGES],
    /// Work done since the beginning over x, E(x) − E(−1) (J).
    work: Interpolant,
    /// Estimated errors of the step.
    pub estimate: Estimate,
    /// A bound of |d ln φ̇/dφ| (1/rad).
    bend: f64,
}

/// The part of a cell that a step is to pass.
pub struct Part<'a> {
    /// Its start.
    pub from: Position,
    /// Its length (rad).
    pub length: f64,
    /// Whether it ends with its cell.
    pub to_edge: bool,
    /// 2/J at its ends and nodes in the order of passage.
    pub reciprocal: &'a ReciprocalInertia,
}

impl Part<'_> {
    /// E at the nodes if N there is `net`.
    #[inline(always)]
    fn energies(&self, net: &[f64; STAGES]) -> [f64; STAGES] {
        let (from, length) = (self.from.energy, self.length);
        combine(&MATRIX_COLUMNS, net).map(|sum| from.hi + (from.lo + length * sum))
    }

    /// Solves Nᵢ = N(Eᵢ(N)) from the guess `net` on, to an error of `remainder` relative to E; returns a bound of the remaining
    /// error.
    fn solve(
        &self,
        net: &mut [f64; STAGES],
        torques: &Torques,
        stiff: bool,
        remainder: f64,
        evaluations: &mut f64,
    ) -> Option<f64> {
        let (from, length, reciprocal) = (self.from.energy, self.length, &self.reciprocal.nodes);
        let mut newton: Option<Lu<STAGES>> = None;
        // Unknown before the first correction; comparisons with NaN are false.
        let mut last = f64::NAN;
        for _ in 0..ITERATIONS {
            let e = self.energies(net);
            // Comparisons with NaN are false here, too.
            if !e.iter().all(|e| *e > LEAST_ENERGY * from.hi) {
                return None;
            }
            let mut correction = [0.0; STAGES];
            for i in 0..STAGES {
                correction[i] = torques.net((e[i] * reciprocal[i]).sqrt()) - net[i];
            }
            *evaluations += STAGES as f64;
            if stiff {
                if newton.is_none() {
                    newton = Some(factorise(length, torques, &e, reciprocal)?);
                }
                newton.as_ref()?.solve(&mut correction);
            }
            let mut size = 0.0;
            for i in 0..STAGES {
                net[i] += correction[i];
                size = f64::max(size, correction[i].abs());
            }
            size *= length / from.hi;
            let rate = size / last;
            // Later sweeps contract faster than earlier ones, so this overestimates the remainder.
            let left = if rate < 1.0 { size * rate / (1.0 - rate) } else { size };
            let rounding = rate > 0.3 && size <= 1e-13;
            if left <= remainder || rounding {
                return Some(left);
            }
            if rate > 0.05 {
                newton = None;
            }
            last = size;
        }
        None
    }
}

/// The matrix δᵢⱼ − h ∂N/∂E aᵢⱼ of Newton's method for the Nᵢ, factorised.
fn factorise(length: f64, torques: &Torques, e: &[f64; STAGES], reciprocal: &[f64; STAGES]) -> Option<Lu<STAGES>> {
    let mut matrix = [[0.0; STAGES]; STAGES];
    for i in 0..STAGES {
        let [_, slope] = torques.with_slope((e[i] * reciprocal[i]).sqrt(), e[i]);
        for j in 0..STAGES {
            matrix[i][j] = -length * slope * MATRIX[i][j];
        }
        matrix[i][i] += 1.0;
    }
    Lu::new(matrix, STAGES)
}

/// The polynomial [`AngleStep::guess`] with the values, slopes and curvatures of x at the ends, and x = 0 at the part
/// `middle`: dx/ds = `slopes` there, d²x/ds² = −(dx/ds)² d ln(1/φ̇)/dx · dx/ds.
fn guess(slowness: &[f64; COEFFICIENTS], slopes: [f64; 2], middle: f64) -> [f64; 6] {
    // Pₖ′(±1) = (±1)ᵏ⁺¹ k (k + 1)/2.
    let (mut odd, mut even) = (0.0, 0.0);
    for k in (1..COEFFICIENTS).step_by(2) {
        odd += 0.5 * (k * (k + 1)) as f64 * slowness[k];
    }
    for k in (2..COEFFICIENTS).step_by(2) {
        even += 0.5 * (k * (k + 1)) as f64 * slowness[k];
    }
    // dx/ds is half the mean of 1/φ̇ over 1/φ̇ itself.
    let curvature = |slope: f64, change: f64| -0.5 * slope * slope * slope * change / slowness[0];
    let [first, last] = [curvature(slopes[0], odd - even), curvature(slopes[1], odd + even)];
    let (a, b) = (slopes[0], 0.5 * first);
    let (value, slope, bent) = (2.0 - a - b, slopes[1] - a - 2.0 * b, 0.5 * last - b);
    let mut guess = [
        a,
        b,
        10.0 * value - 4.0 * slope + bent,
        -15.0 * value + 7.0 * slope - 2.0 * bent,
        6.0 * value - 3.0 * slope + bent,
        0.0,
    ];
    guess[5] = -guessed(&guess, middle) / (middle * (1.0 - middle)).powi(3);
    guess
}

/// x at the part `s`.
#[inline(always)]
fn guessed(guess: &[f64; 6], s: f64) -> f64 {
    let [a, b, c, d, e, f] = guess;
    let bump = s * (1.0 - s);
    s * (a + s * (b + s * (c + s * (d + s * e)))) + f * bump * bump * bump - 1.0
}

impl AngleStep {
    /// Makes the step over a part of a cell. N of the step `before`, which ends at its start, continues as a first guess. Adds to
    /// the number of evaluations. None if the equations cannot be solved to an error of `remainder`, relative to E.
    pub fn new(
        part: &Part,
        torques: &Torques,
        before: Option<&AngleStep>,
        remainder: f64,
        evaluations: &mut f64,
    ) -> Option<Self> {
        let Part { from, length, to_edge, reciprocal } = *part;
        let first = End::new(from.energy.hi, reciprocal.ends[0], torques);
        let before = before.filter(|step| length <= STRETCH * step.length);
        let mut net = before.map_or([first.net; STAGES], |step| step.continued(length));
        let stiff = length * first.slope.abs() > STIFF;
        let left = part.solve(&mut net, torques, stiff, remainder, evaluations)?;

        let work: f64 = (0..STAGES).map(|i| WEIGHTS[i] * net[i]).sum();
        let energy = from.energy + Double::from(length * work);
        if !(energy.hi > LEAST_ENERGY * first.energy) {
            return None;
        }
        let last = End::new(energy.hi, reciprocal.ends[1], torques);
        let e = part.energies(&net);
        let slow: [f64; STAGES] = std::array::from_fn(|i| 1.0 / (e[i] * reciprocal.nodes[i]).sqrt());
        let slow_modes = Interpolant::modes_through(&slow, [1.0 / first.speed, 1.0 / last.speed]);
        let net_modes = modes(&net);

        let end = from.time + Double::from(length * slow_modes[0]);
        let slowness = Interpolant::new(&slow_modes);
        let whole = (end - from.time).hi;
        let slowness_before = slowness.with_integral(-1.0)[1];
        let middle = -0.5 * slowness_before / slow_modes[0];
        let slopes = [&first, &last].map(|end| 2.0 * whole / length * end.speed);
        // |Pₖ′| ≤ k (k + 1)/2. Newton's method leaves ½ |d ln(1/φ̇)/dx| times the square of a correction.
        let steepest: f64 = (1..COEFFICIENTS).map(|k| 0.5 * (k * (k + 1)) as f64 * slow_modes[k].abs()).sum();
        let fastest = last.speed.max(first.speed);
        Some(AngleStep {
            from,
            length,
            to_edge,
            end_speed: last.speed,
            end_net: last.net,
            end,
            energy,
            slowness,
            slowness_before,
            rate: 2.0 / length,
            inverse_duration: 1.0 / whole,
            tilt: 0.0,
            guess: guess(&slow_modes, slopes, middle),
            converged: 4.0 * INSTANT * remainder / (length * steepest * fastest),
            net: net_modes,
            work: Interpolant::new(&integrated(&net_modes.map(|mode| 0.5 * length * mode))),
            estimate: Estimate::new(
                length,
                [&first, &last],
                &slow_modes,
                &Net { nodes: &net, modes: &net_modes, left },
            ),
            bend: 2.0 * steepest * fastest / length,
        })
    }

    /// Moves this step to another place and energy.
    #[inline(always)]
    pub fn shift(&mut self, shift: Shift) {
        let Shift { from, gain, more, duration, longer, slower, ends, between } = shift;
        let error = ends + between;
        self.from = from;
        self.end = from.time + duration + Double::from(longer);
        self.energy = from.energy + gain + Double::from(more);
        self.rate -= self.rate * slower;
        self.inverse_duration -= self.inverse_duration * slower;
        self.tilt = 0.5 * more;
        self.estimate.angle += self.length * error;
        self.estimate.energy += error;
        self.estimate.added += ends;
        self.estimate.time += ends;
    }

    /// dE₁/dE₀, approximately.
    pub fn slope(&self) -> f64 {
        self.estimate.growth * self.energy.hi / self.from.energy.hi
    }

    /// ∫ ∂N/∂E dψ over the step: ln of the factor by which a disturbance of E grows.
    pub fn log_growth(&self, torques: &Torques) -> f64 {
        let slope = |x: f64| torques.with_slope(self.speed_at(x), self.energy_at(x).hi)[1];
        self.length * (0..STAGES).map(|i| WEIGHTS[i] * slope(ABSCISSAE[i])).sum::<f64>()
    }

    /// The time from its start to the instant `time`, and from there to its end (s).
    #[inline(always)]
    pub fn around(&self, time: Double) -> [f64; 2] {
        // The first differences are exact if they are small.
        let [from, end] = [self.from.time, self.end];
        [(time.hi - from.hi) + (time.lo - from.lo), (end.hi - time.hi) + (end.lo - time.lo)]
    }

    /// The position in the step at the time `elapsed` (s) after its start, as abscissa x ∈ [−1, 1].
    ///
    /// The time is a smooth increasing function of x, so Newton's method needs no safeguard except the ends.
    pub fn place_at(&self, elapsed: f64) -> f64 {
        let mut x = guessed(&self.guess, elapsed * self.inverse_duration).clamp(-1.0, 1.0);
        let wanted = elapsed * self.rate + self.slowness_before;
        for _ in 0..INVERSION {
            let [slowness, integral] = self.slowness.with_integral(x);
            let change = (integral - wanted) / slowness;
            x = (x - change).clamp(-1.0, 1.0);
            if change * change <= self.converged {
                break;
            }
        }
        x
    }

    /// The angle from the beginning to the abscissa `x` (rad).
    pub fn advance(&self, x: f64) -> f64 {
        0.5 * self.length * (1.0 + x)
    }

    /// E at the abscissa `x` less E at the start (J).
    #[inline(always)]
    pub fn work_to(&self, x: f64) -> f64 {
        self.work.value(x) + self.tilt * (1.0 + x)
    }

    /// E at the abscissa `x` (J).
    pub fn energy_at(&self, x: f64) -> Double {
        self.from.energy + Double::from(self.work_to(x))
    }

    /// |φ̇| at the abscissa `x` (rad/s).
    pub fn speed_at(&self, x: f64) -> f64 {
        1.0 / self.slowness.value(x)
    }

    /// N at the nodes of a following step of this `length`.
    fn continued(&self, length: f64) -> [f64; STAGES] {
        let mut trend = [0.0; COEFFICIENTS];
        trend[..=CONTINUED].copy_from_slice(&self.net[..=CONTINUED]);
        let trend = Interpolant::new(&trend);
        let stretch = length / self.length;
        ABSCISSAE.map(|x| trend.value(1.0 + (1.0 + x) * stretch))
    }

    /// The errors at the end, from those at the beginning.
    pub fn pass_on(&self, errors: Errors) -> Errors {
        let duration = (self.end - self.from.time).hi;
        let energy = self.estimate.growth * errors.energy + self.estimate.added;
        Errors { energy, time: errors.time + duration * (0.5 * errors.energy.max(energy) + self.estimate.time) }
    }

    /// The approximate errors at the abscissa `x`.
    pub fn errors_at(&self, errors: Errors, x: f64) -> Errors {
        let (part, end) = (0.5 * (1.0 + x), self.pass_on(errors));
        Errors {
            energy: errors.energy + part * (end.energy - errors.energy) + self.estimate.energy,
            time: errors.time + part * (end.time - errors.time),
        }
    }

    /// The relative error of the speed and the error of the angle (rad) within the step.
    pub fn error_within(&self, errors: Errors) -> [f64; 2] {
        let angle = self.end_speed * errors.time + self.estimate.angle;
        [0.5 * (errors.energy + self.estimate.energy) + self.bend * angle, angle]
    }
}
