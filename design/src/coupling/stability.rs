//! The largest communication steps of a machine and the drives on its shaft, each an FMU of its own.
//!
//! A drive takes φ, φ̇, φ̈ and gives τ, the machine the other way round. Parts that follow the shaft without slip have τ =
//! J_load φ̈, an algebraic loop over the communication step: every step multiplies an error of φ̈ by −κ,
//!
//! κ = J_load/J; stable for κ < 1 at any step.
//!
//! Parts on a spring have τ = k (φ − x) + b (φ̇ − ẋ), k = c U′², delayed by a step H. The largest step is the one at which
//! errors grow by 1e-3 per step, by the spectral radius of the one-step map of the whole: a free shaft, and each drive at its
//! stiffest angle as an oscillator that takes the motion of the shaft from the exchange, in closed form. Motors damp and are
//! left out.
//!
//! A repeated step takes both courses from the round before: the torque is a cubic, so the factor of an error of φ̈ is another
//! polynomial in κ, below 1 up to κ = 0.41 (once), 0.83 (twice), 0.58 (three times), 0.90, 0.68, 0.93.
//!
//! At damping ratios of 0.02 and μ = m U′²/J = 0.05, 0.5, 5 this is H √(k/J) < 0.33, 0.21, 0.26 with held values and 0.56,
//! 0.77, 1.32 with interpolated ones. κ < 1 with interpolated values assumes φ̈ at the beginning of a step with the torque of
//! this step; with the torque of the step before, only κ < 0.13 is stable.
//!
//! Symbols: J least inertia of the machine over the turn (kg·m²), J_load largest inertia of parts without slip (kg·m²), U′
//! largest transfer function (m/rad), c, b, m spring, damper and mass on it (N/m, N·s/m, kg). The least J and the largest U′
//! need not be at one angle: the bounds are on the safe side. Several drives on a shaft add up, each with the square of its
//! ratio.

use crate::oscillator::{self, Terms};
use crate::overview::train::without_slip;
use crate::resource::Scene;
use crate::search::{greatest, segments};
use camdrive::drives::drive_train::{self, Names};
use camdrive::drives::parameter::Parameters;
use camdrive::drives::rigid_machine::{Follower, Inertia, InertiaFunction, linkage};
use camdrive::motion::MotionLaw;
use camdrive::numerics::angle::reduce;
use serde::Serialize;

/// The exchange between the parts of a system at a communication point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Exchange {
    /// All at once: inputs keep the values of the beginning of the step.
    Held,
    /// All at once: inputs go on with their first derivatives.
    Extrapolated,
    /// One after the other: drives first, then the machine with their torques at the end of the step.
    GaussSeidel,
    /// The machine first with extrapolated torques, then the drives, whose motion meets the machine's at both ends.
    Interpolated,
    /// As `Interpolated`, and the machine includes the inertia of rigid loads in its own.
    EffectiveInertia,
}

/// Growth of an error per step that counts as unstable.
const GROWTH: f64 = 1e-3;
/// H √(k/J) at the beginning and the end of the search for the largest step, and the ratio from one to the next.
const SEARCHED: [f64; 3] = [0.01, 10.0, 1.05];
/// Halvings of the last ratio: they give the largest step to five digits.
const HALVINGS: usize = 12;

/// The effect of one oscillator of a drive, or of the parts without slip, on its shaft.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Load {
    /// Largest inertia of parts without slip, m1 of a clearance included (kg·m²).
    pub inertia: f64,
    /// Largest stiffness of its spring (N·m/rad).
    pub stiffness: f64,
    /// Largest inertia on it (kg·m²).
    pub sprung: f64,
    /// Its damping (N·m·s/rad).
    pub damping: f64,
}

/// The limits of the exchange on a shaft.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Limit {
    /// Least inertia of the machine (kg·m²).
    pub inertia: f64,
    /// The largest κ of loads that the machine does not include in its own inertia.
    pub kappa: f64,
    /// √(k/J) (rad/s).
    pub frequency: f64,
    /// The largest stable communication step (s); None if none within the search grows, 0 if each does.
    pub stable: Option<f64>,
}

/// The inertia of this mass, or of any other factor of U′², over the turn.
fn turn(mass: f64, follower: &Follower) -> f64 {
    let part = Follower { m: mass, ..follower.clone() };
    Inertia::new(InertiaFunction::default(), vec![part]).range().1
}

/// The loads of a scene's drive on its shaft: first the parts without slip, then each oscillator.
pub fn loads(scene: &Scene) -> Vec<Load> {
    let bare = |cam: &MotionLaw| Follower::new(0.0, cam.clone());
    match scene {
        Scene::ElasticOutput(scene) => {
            let (p, cam) = (scene.parameters, bare(&scene.cam));
            vec![rigid(turn(scene.roller.0, &cam)), spring([p.m, p.b, p.c], &cam)]
        }
        Scene::BacklashDrive(scene) => {
            let (p, cam) = (scene.parameters, bare(&scene.cam));
            vec![rigid(turn(p.m1, &cam)), spring([p.m2, p.b, p.c], &cam)]
        }
        Scene::ElasticShaft(_) | Scene::ParametricDrive(_) => {
            let Ok(oscillator) = oscillator::of(scene) else { return vec![rigid(0.0)] };
            let segments = segments(&oscillator.breakpoints);
            let most = |term: fn(&Terms) -> f64| {
                greatest(&segments, |i, phi| term(&(oscillator.terms)(i, reduce(phi.into())))).value
            };
            vec![rigid(0.0), twist([most(|t| t.m), most(|t| t.b), most(|t| t.c)])]
        }
        Scene::DriveTrain(scene) => {
            let of = |drive_train::Follower { joint, rigid, .. }: &drive_train::Follower| match (
                joint.shaft(),
                joint.sprung(),
            ) {
                (Some(p), _) => Some(twist([p.inertia + turn(p.m, rigid), p.b, p.c])),
                (_, Some((_, [m, c, b]))) => Some(spring([m, b, c], rigid)),
                _ => joint.clearance().map(|_| Load::default()),
            };
            let rigid = rigid(without_slip(scene).range().1);
            [rigid].into_iter().chain(scene.followers.iter().filter_map(of)).collect()
        }
        Scene::RigidMachine(_) => vec![rigid(0.0)],
    }
}

fn rigid(inertia: f64) -> Load {
    Load { inertia, ..Load::default() }
}

/// A mass m on spring c and damper b after a cam.
fn spring([m, b, c]: [f64; 3], cam: &Follower) -> Load {
    let square = turn(1.0, cam);
    twist([m, b, c].map(|factor| factor * square))
}

/// An inertia on a torsional spring and damper.
fn twist([sprung, damping, stiffness]: [f64; 3]) -> Load {
    let is_one = sprung > 0.0 && stiffness > 0.0;
    if is_one { Load { inertia: 0.0, stiffness, sprung, damping } } else { Load::default() }
}

/// Sets the parameter of this name in the FMU of a scene; false if limits may depend on it but it is unknown here.
pub fn set(scene: &mut Scene, name: &str, value: f64) -> bool {
    let beside = ["start.", "solver.", "motor.", "drive.", "load."].iter().any(|group| name.starts_with(group));
    let beside = beside || name.ends_with("_start") || name.contains("].load.");
    let cam = |law: &mut MotionLaw| name.strip_prefix("cam.").is_some_and(|name| of_law(law, name, value));
    let machine = |function: &mut InertiaFunction| {
        of_group(function, name, value)
            || (name.strip_prefix("inertia.").zip(function.varying.as_mut()))
                .is_some_and(|(name, law)| of_law(law, name, value))
    };
    let follower = match scene {
        Scene::DriveTrain(drive_train::Scene { names: Names::Backlash(_), .. }) => Some((0, name)),
        _ => name.strip_prefix("follower").and_then(numbered),
    };
    match (scene, follower) {
        (Scene::ElasticOutput(s), _) if name == "m_roller" => assign(&mut s.roller.0, value),
        (Scene::ElasticOutput(s), _) => of_group(&mut s.parameters, name, value) || cam(&mut s.cam) || beside,
        (Scene::ElasticShaft(s), _) => of_group(&mut s.parameters, name, value) || cam(&mut s.cam) || beside,
        (Scene::BacklashDrive(s), _) => of_group(&mut s.parameters, name, value) || cam(&mut s.cam) || beside,
        (Scene::RigidMachine(s), None) => machine(&mut s.inertia) || beside,
        (Scene::RigidMachine(s), Some((j, name))) => {
            s.followers.get_mut(j).is_some_and(|f| of_follower(f, name, value))
        }
        (Scene::DriveTrain(s), Some((j, name))) => s.followers.get_mut(j).is_some_and(|follower| {
            let number = follower.joint.numbers().iter().position(|number| number.name == name);
            number.iter().for_each(|i| follower.joint.set_number(*i, value));
            let roller = name == "m_roller" && follower.joint.roller().is_some();
            if roller {
                follower.joint.set_roller(value);
            }
            number.is_some() || roller || of_follower(&mut follower.rigid, name, value) || beside
        }),
        (Scene::DriveTrain(drive_train::Scene { shaft: drive_train::Shaft::Free(free), .. }), None) => match name {
            "motor.i" => assign(&mut free.motor.transmission.ratio, value),
            "motor.J" => assign(&mut free.motor.transmission.rotor, value),
            _ => machine(&mut free.inertia) || beside,
        },
        _ => beside,
    }
}

/// Index, counted from 0, and rest of "[1].rest".
fn numbered(text: &str) -> Option<(usize, &str)> {
    let (number, rest) = text.strip_prefix('[')?.split_once("].")?;
    Some((number.parse::<usize>().ok()?.checked_sub(1)?, rest))
}

fn assign(to: &mut f64, value: f64) -> bool {
    *to = value;
    true
}

fn of_group<P: Parameters>(group: &mut P, name: &str, value: f64) -> bool {
    let found = P::TABLE.iter().find(|parameter| parameter.name == name);
    found.map(|parameter| (parameter.set)(group, value)).is_some()
}

fn of_law(law: &mut MotionLaw, name: &str, value: f64) -> bool {
    let place = law.parameters().iter().position(|parameter| parameter.name == name);
    place.map(|place| law.set_parameter(place, value)).is_some()
}

fn of_follower(follower: &mut Follower, name: &str, value: f64) -> bool {
    if name == linkage::Parameter::mass(follower.turns).key {
        return assign(&mut follower.m, value);
    }
    if let Some(name) = name.strip_prefix(follower.mover()) {
        return name.strip_prefix('.').is_some_and(|name| of_law(&mut follower.cam, name, value));
    }
    let found = name.strip_prefix("linkage").and_then(numbered).and_then(|(i, name)| {
        let mechanism = follower.linkage.0.get_mut(i)?;
        let place = mechanism.parameters().iter().position(|parameter| parameter.name() == name)?;
        mechanism.parameter_mut(place)
    });
    found.is_some_and(|place| assign(place, value))
}

/// The least inertia of a machine over the turn (kg·m²); None for other scenes.
pub fn least_inertia(scene: &Scene) -> Option<f64> {
    match scene {
        Scene::RigidMachine(scene) => Some(Inertia::new(scene.inertia.clone(), scene.followers.clone()).range().0),
        Scene::DriveTrain(train @ drive_train::Scene { shaft: drive_train::Shaft::Free(_), .. }) => {
            Some(without_slip(train).range().0)
        }
        _ => None,
    }
}

impl Exchange {
    /// True if the drives take the motion of the machine over the step.
    pub fn interpolates(self) -> bool {
        matches!(self, Exchange::Interpolated | Exchange::EffectiveInertia)
    }
}

/// A machine with this least inertia (kg·m²) under [`loads`], each with the ratio of its speed and whether the machine includes
/// its inertia in its own.
#[derive(Clone, Debug)]
pub struct Loaded {
    inertia: f64,
    /// In units of J.
    loads: Vec<Load>,
}

impl Loaded {
    /// The system of these loads.
    pub fn new(inertia: f64, loads: &[(f64, Load, bool)]) -> Self {
        let of = |(ratio, load, own): &(f64, Load, bool)| {
            let square = ratio * ratio / inertia;
            Load {
                inertia: if *own { 0.0 } else { square * load.inertia },
                stiffness: square * load.stiffness,
                sprung: square * load.sprung,
                damping: square * load.damping,
            }
        };
        Loaded { inertia, loads: loads.iter().map(of).collect() }
    }

    /// κ of the loads that the machine does not include in its own inertia.
    pub fn kappa(&self) -> f64 {
        self.loads.iter().map(|load| load.inertia).sum()
    }

    /// √(k/J) (rad/s).
    fn frequency(&self) -> f64 {
        self.loads.iter().map(|load| load.stiffness).sum::<f64>().sqrt()
    }

    fn grows_at(&self, exchange: Exchange, repeats: u32, step: f64) -> bool {
        growth(exchange, repeats, step, &self.loads) > 1.0 + GROWTH
    }

    /// True if errors grow in steps of this length (s), repeated this often, or in shorter ones: a step in which an oscillation
    /// dies away may be stable beyond.
    pub fn grows(&self, exchange: Exchange, repeats: u32, step: f64) -> bool {
        let ([least, _, ratio], frequency) = (SEARCHED, self.frequency());
        let shorter = std::iter::successors(Some(least), |z| Some(z * ratio)).take_while(|z| *z < step * frequency);
        let shorter = shorter.map(|z| z / frequency).chain([step]);
        shorter.into_iter().any(|step| self.grows_at(exchange, repeats, step))
    }

    /// Limits of steps that are repeated this often.
    pub fn limit(&self, exchange: Exchange, repeats: u32) -> Limit {
        let (inertia, kappa) = (self.inertia, self.kappa());
        let frequency = self.frequency();
        let elastic = frequency > 0.0;
        let stable = match kappa < 1.0 {
            true if !elastic => None,
            true => {
                let [least, greatest, ratio] = SEARCHED;
                let mut steps = std::iter::successors(Some(least), |z| Some(z * ratio)).take_while(|z| *z < greatest);
                let grows = |z: &f64| self.grows_at(exchange, repeats, z / frequency);
                steps.find(grows).map(|unstable| {
                    let (mut low, mut high) = (if unstable > least { unstable / ratio } else { 0.0 }, unstable);
                    for _ in 0..HALVINGS {
                        let middle = 0.5 * (low + high);
                        *if grows(&middle) { &mut high } else { &mut low } = middle;
                    }
                    low / frequency
                })
            }
            false => Some(0.0),
        };
        Limit { inertia, kappa, frequency, stable }
    }
}

/// States of the shaft: φ, φ̇, φ̈ and its rate as the drives know them; for each drive x, ẋ, τ and its rate.
const SHAFT: usize = 4;
const DRIVE: usize = 4;

/// The factor by which an error grows in a step, of a shaft with J = 1.
fn growth(exchange: Exchange, repeats: u32, step: f64, loads: &[Load]) -> f64 {
    /// The measured power of the map is 2 to this power.
    const SQUARINGS: i32 = 16;
    let count = SHAFT + DRIVE * loads.len();
    let columns: Vec<Vec<f64>> = (0..count)
        .map(|i| {
            let mut state = vec![0.0; count];
            state[i] = 1.0;
            one_step(exchange, repeats, step, loads, &state)
        })
        .collect();
    let (mut power, mut logarithm) = (columns, 0.0);
    for _ in 0..SQUARINGS {
        let size = power.iter().flatten().fold(f64::MIN_POSITIVE, |most: f64, x| most.max(x.abs()));
        power.iter_mut().flatten().for_each(|x| *x /= size);
        logarithm = 2.0 * (logarithm + size.ln());
        let times = |column: &Vec<f64>| -> Vec<f64> {
            (0..count).map(|row| (0..count).map(|k| power[k][row] * column[k]).sum()).collect()
        };
        power = power.iter().map(times).collect();
    }
    let size = power.iter().flatten().fold(f64::MIN_POSITIVE, |most: f64, x| most.max(x.abs()));
    ((logarithm + size.ln()) / 2f64.powi(SQUARINGS)).exp()
}

/// The state after a step of the exchange.
fn one_step(exchange: Exchange, repeats: u32, h: f64, loads: &[Load], state: &[f64]) -> Vec<f64> {
    let (&[phi, w, known, known_rate], drives) = state.split_first_chunk().expect("a shaft");
    let sum = |drives: &[f64], place: usize| drives.chunks(DRIVE).map(|drive| drive[place]).sum::<f64>();
    let extrapolates = !matches!(exchange, Exchange::Held | Exchange::GaussSeidel);
    let a = -sum(drives, 2);
    let rate = if extrapolates { -sum(drives, 3) } else { 0.0 };
    // The shaft under a torque that is a cubic.
    let shaft = |[a1, a2, a3]: [f64; 3]| {
        let w_end = w + h * (a + h / 2.0 * (a1 + h / 3.0 * (a2 + h / 4.0 * a3)));
        let phi_end = phi + h * (w + h / 2.0 * (a + h / 3.0 * (a1 + h / 4.0 * (a2 + h / 5.0 * a3))));
        [phi_end, w_end, a + h * (a1 + h / 2.0 * (a2 + h / 3.0 * a3)), a1 + h * (a2 + h / 2.0 * a3)]
    };
    let driven = |course: [f64; 5]| -> Vec<f64> {
        let each = loads.iter().zip(drives.chunks(DRIVE));
        each.flat_map(|(load, drive)| driven(load, [drive[0], drive[1]], course, h)).collect()
    };
    let mut end = shaft([rate, 0.0, 0.0]);
    let course = match exchange {
        Exchange::Held => [phi, w, known, 0.0, 0.0],
        // The machine gives φ̈ and its rate with the torque of the step before.
        Exchange::Extrapolated => [phi, w, known, known_rate, 0.0],
        Exchange::GaussSeidel => [end[0], end[1], end[2], 0.0, 0.0],
        // The motion of the shaft itself.
        Exchange::Interpolated | Exchange::EffectiveInertia => [phi, w, a, rate, 0.0],
    };
    let mut next = driven(course);
    for _ in 0..repeats {
        let [last, last_rate] = [-sum(&next, 2), -sum(&next, 3)];
        let mean = (last - a) / h;
        end = shaft([
            rate,
            (6.0 * mean - 4.0 * rate - 2.0 * last_rate) / h,
            6.0 * (rate + last_rate - 2.0 * mean) / (h * h),
        ]);
        let angle = (end[0] - phi - h * (w + h / 2.0 * a)) / (h * h);
        let speed = (end[1] - w - h * a) / h;
        next = driven([phi, w, a, (24.0 * angle - 6.0 * speed) / h, (24.0 * speed - 72.0 * angle) / (h * h)]);
    }
    [&end[..], &next].concat()
}

/// x, ẋ, τ and its rate of a drive that takes the motion φ, φ̇, φ̈ with its next two derivatives over the time h.
fn driven(load: &Load, mut at: [f64; 2], mut course: [f64; 5], h: f64) -> [f64; DRIVE] {
    /// Terms of the power series of a piece in which the oscillator turns by a radian at most.
    const TERMS: usize = 24;
    let &Load { inertia, stiffness: k, sprung, damping: b } = load;
    if sprung > 0.0 {
        let pieces = (h * ((k / sprung).sqrt() + b / sprung)).ceil().max(1.0);
        let h = h / pieces;
        for _ in 0..pieces as usize {
            let [phi, w, a, a1, a2] = course;
            let forced = [phi, w, a / 2.0, a1 / 6.0, a2 / 24.0];
            let forced = |j: usize| forced.get(j).copied().unwrap_or(0.0);
            let mut x = [0.0; TERMS];
            (x[0], x[1]) = (at[0], at[1]);
            for j in 0..TERMS - 2 {
                let n = j as f64;
                let force = k * (forced(j) - x[j]) + b * (n + 1.0) * (forced(j + 1) - x[j + 1]);
                x[j + 2] = force / (sprung * (n + 1.0) * (n + 2.0));
            }
            let sum = |f: fn(f64) -> f64| (0..TERMS).rev().fold(0.0, |sum, j| sum * h + f(j as f64) * x[j]);
            at = [sum(|_| 1.0), sum(|j| j) / h];
            course = moved(course, h);
        }
    } else {
        course = moved(course, h);
    }
    let ([x, v], [phi, w, a, a1, _]) = (at, course);
    let torque = k * (phi - x) + b * (w - v);
    let a_x = if sprung > 0.0 { torque / sprung } else { 0.0 };
    [x, v, torque + inertia * a, k * (w - v) + b * (a - a_x) + inertia * a1]
}

/// A motion with its derivatives after the time h.
fn moved(course: [f64; 5], h: f64) -> [f64; 5] {
    std::array::from_fn(|i| (i..5).rev().fold(0.0, |sum, j| course[j] + sum * h / (j - i + 1) as f64))
}

#[cfg(test)]
mod tests {
    use super::Exchange::Interpolated;
    use super::*;

    const LOAD: Load = Load { inertia: 0.1, stiffness: 50.0, sprung: 0.05, damping: 0.05 };

    fn limit(exchange: Exchange, repeats: u32, inertia: f64, loads: &[(f64, Load, bool)]) -> Limit {
        Loaded::new(inertia, loads).limit(exchange, repeats)
    }

    /// A drive on a shaft of J = 1 with k = 1.
    fn unit(mu: f64, zeta: f64) -> Load {
        Load { inertia: 0.0, stiffness: 1.0, sprung: mu, damping: 2.0 * zeta * mu.sqrt() }
    }

    #[test]
    fn several_drives_add_up_with_the_squares_of_their_ratios() {
        let two = limit(Exchange::Held, 0, 2.0, &[(2.0, LOAD, false), (1.0, LOAD, false)]);
        assert!((two.kappa - 0.25).abs() < 1e-15 && (two.frequency - 125f64.sqrt()).abs() < 1e-12);
        // Two halves are one whole.
        let half = Load { inertia: 0.05, stiffness: 25.0, sprung: 0.025, damping: 0.025 };
        for exchange in [Exchange::Held, Exchange::GaussSeidel, Exchange::Interpolated] {
            let [one, two] = [&[(1.0, LOAD, false)][..], &[(1.0, half, false), (1.0, half, false)]]
                .map(|loads| limit(exchange, 0, 1.0, loads).stable.unwrap());
            assert!((one / two - 1.0).abs() < 1e-3, "{exchange:?}: {one} {two}");
        }
        // What the machine takes for its own is no part of the loop.
        let shared = limit(Exchange::EffectiveInertia, 0, 2.0, &[(2.0, LOAD, true), (1.0, LOAD, false)]);
        assert!((shared.kappa - 0.05).abs() < 1e-15);
    }

    #[test]
    fn a_rigid_load_is_stable_below_the_inertia_of_the_machine() {
        let rigid = |inertia: f64| [rigid(inertia)];
        for exchange in [Exchange::Held, Exchange::GaussSeidel, Exchange::Interpolated] {
            // The factor of an error is −κ, with held values in two steps.
            for kappa in [0.5, 0.99, 1.01, 2.0f64] {
                let growth = growth(exchange, 0, 0.1, &rigid(kappa));
                let expected = if exchange == Exchange::Held { kappa.sqrt() } else { kappa }.max(1.0);
                assert!((growth - expected).abs() < 1e-3, "{exchange:?} {kappa}: {growth}");
            }
            let of = |inertia| limit(exchange, 0, 1.0, &[(1.0, rigid(inertia)[0], false)]);
            assert_eq!([of(0.9).stable, of(1.1).stable], [None, Some(0.0)]);
        }
    }

    #[test]
    fn springs_are_stable_up_to_the_steps_of_the_exact_one_step_maps() {
        // From matrix exponentials and eigenvalues; with the latest values as the literature of such couplings has them.
        for (exchange, zeta, limits) in [
            (Exchange::Held, 0.02, [0.33, 0.21, 0.26]),
            (Exchange::Held, 0.0, [0.06, 0.06, 0.06]),
            (Exchange::Extrapolated, 0.02, [0.417, 0.595, 0.584]),
            (Exchange::GaussSeidel, 0.02, [0.65, 0.94, 0.93]),
            (Exchange::GaussSeidel, 0.0, [0.63, 0.96, 1.00]),
            (Exchange::Interpolated, 0.02, [0.56, 0.77, 1.32]),
            (Exchange::Interpolated, 0.0, [0.19, 0.30, 0.38]),
        ] {
            for (mu, expected) in [0.05, 0.5, 5.0].into_iter().zip(limits) {
                let z = limit(exchange, 0, 1.0, &[(1.0, unit(mu, zeta), false)]).stable.unwrap();
                assert!((z - expected).abs() < 0.0055, "{exchange:?} {zeta} {mu}: {z} for {expected}");
            }
        }
    }

    #[test]
    fn repeated_steps_are_stable_up_to_other_inertias_and_steps() {
        for (repeats, most) in (1..).zip([0.41, 0.83, 0.58, 0.90, 0.68, 0.93]) {
            let rigid = |inertia: f64| [rigid(inertia)];
            let [below, above] =
                [most - 0.01, most + 0.01].map(|kappa| growth(Interpolated, repeats, 0.1, &rigid(kappa)));
            assert!(below <= 1.0 + GROWTH && above > 1.0 + GROWTH, "{repeats}: {below} {above}");
        }
        // A spring admits longer steps, once repeated most; at their limit the series of the rounds diverges.
        for (repeats, expected) in (0..).zip([0.78, 2.76, 2.30]) {
            let z = limit(Interpolated, repeats, 1.0, &[(1.0, unit(0.5, 0.02), false)]).stable.unwrap();
            assert!((z / expected - 1.0).abs() < 0.02, "{repeats}: {z} for {expected}");
        }
    }
}
