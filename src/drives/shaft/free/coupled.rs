//! The loads that other units put on the shaft: their torques or, for loads of known inertia, the rest of their torques.
//!
//! τ = Σ τ_k + Σ (J_k φ̈ + ½ J_k′ φ̇² + τ_rest,k),  J_k(φ) = J_load + dJ_load Δ + ½ J″ Δ²,  Δ = φ − φ_n
//!
//! Symbols: τ_k torque of a load (N·m), positive brakes; J_k inertia that follows the shaft without slip in a load (kg·m²),
//! τ_rest,k the rest of its torque; φ_n and φ̇_n the shaft at the beginning of the communication step (rad), (rad/s). J″ is the
//! first time derivative of the input dJ_load over φ̇_n where φ̇_n ≠ 0, else 0. dJ_load + J″ Δ is the derivative of J_k itself, so
//! that the energy ½ (J + Σ J_k) φ̇² changes by the work of the torques alone.
//!
//! Valid while J + Σ J_k > 0.

use super::State;
use super::signal::Signal;
use crate::drives::unit::Quantity;
use crate::drives::variable::{Get, SetInput, real_within};
use crate::drives::{Fault, List, Number, Seed, unit};
use crate::numerics::angle::WHOLE_TURN;
use crate::numerics::double_double::{Double, two_product};
use crate::numerics::taylor::Series;
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// The inputs of a load: a torque, or with its inertia three of them, in the order of their value references.
pub const INPUTS: [&str; 4] = ["tau", "J_load", "dJ_load", "tau_rest"];

/// The outputs of a drive with the inertia that follows its shaft without slip, for the machine that turns it: tau = J_load φ̈ + ½
/// dJ_load φ̇² + tau_rest.
pub const COUPLING: [(&str, &str, &Quantity); 3] = [
    ("J_load", "Moment of inertia that follows the shaft without slip", &unit::INERTIA),
    ("dJ_load", "Its derivative by phi", &unit::INERTIA_PER_ANGLE),
    (
        "tau_rest",
        "Torque from the drive without the torque of this inertia, tau - J_load a - dJ_load w^2/2",
        &unit::TORQUE,
    ),
];

/// The number of places at which a failed step is searched for its cause.
const PLACES: u32 = 256;

/// A load with its name from the scene.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct NamedLoad {
    /// The first part of the names of its inputs; empty for the only load.
    pub name: String,
    /// Whether its inertia is known.
    pub inertia: bool,
}

impl NamedLoad {
    /// The numbers of its inputs in [`INPUTS`].
    fn inputs(&self) -> Range<usize> {
        if self.inertia { 1..4 } else { 0..1 }
    }
}

/// A load.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
struct CoupledLoad {
    named: NamedLoad,
    /// τ or τ_rest.
    torque: Signal,
    /// J_load, dJ_load.
    inertia: [Signal; 2],
}

/// The shaft at the start of a step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Beginning {
    angle: Double,
    turns: f64,
    w: f64,
}

/// The loads on a shaft.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Loads {
    each: Vec<CoupledLoad>,
    begin: Beginning,
    /// Σ J_load, Σ dJ_load, Σ J″ in the present step; None without a known inertia.
    sum: Option<[f64; 3]>,
}

impl Loads {
    /// These loads, all without torque.
    pub fn new(named: &[NamedLoad]) -> Self {
        let each = named.iter().map(|named| CoupledLoad { named: named.clone(), ..CoupledLoad::default() }).collect();
        Loads { each, ..Loads::default() }
    }

    /// The loads with their names from the scene.
    pub fn named(&self) -> impl Iterator<Item = &NamedLoad> {
        self.each.iter().map(|load| &load.named)
    }

    /// Whether these may be the same loads at another time.
    pub fn fit(&self, other: &Self) -> bool {
        self.named().eq(other.named())
    }

    /// Conditions of the text.
    pub fn conditions(&self) -> [(&'static str, bool); 2] {
        [("torques", self.named().any(|named| !named.name.is_empty())), ("coupled", self.have_inertia())]
    }

    /// Whether the inertia of one of them is known.
    pub fn have_inertia(&self) -> bool {
        self.named().any(|named| named.inertia)
    }

    /// The input of the load `at` / 4 with the number `at` % 4 in [`INPUTS`].
    pub fn signal(&self, at: usize) -> Option<&Signal> {
        let load = self.each.get(at / 4)?;
        Some(if let number @ 1..3 = at % 4 { &load.inertia[number - 1] } else { &load.torque })
    }

    /// The same, to change it.
    pub fn signal_mut(&mut self, at: usize) -> Option<&mut Signal> {
        let load = self.each.get_mut(at / 4)?;
        Some(if let number @ 1..3 = at % 4 { &mut load.inertia[number - 1] } else { &mut load.torque })
    }

    /// The numbers of all inputs for [`Loads::signal`], in the order of their value references.
    pub fn inputs(&self) -> impl Iterator<Item = usize> {
        self.named().enumerate().flat_map(|(k, named)| named.inputs().map(move |i| 4 * k + i))
    }

    /// The name of an input.
    pub fn name(&self, at: usize) -> String {
        let (name, input) = (&self.each[at / 4].named.name, INPUTS[at % 4]);
        if name.is_empty() { input.to_owned() } else { format!("{name}.{input}") }
    }

    /// The names of all inputs.
    pub fn names(&self) -> Vec<String> {
        self.inputs().map(|at| self.name(at)).collect()
    }

    /// ∂/∂seed of Σ τ_k + Σ τ_rest,k, Σ J_load and Σ dJ_load.
    pub fn seeded(&self, seed: Seed) -> [f64; 3] {
        let mut slopes = [0.0; 3];
        for at in self.inputs() {
            slopes[at % 4 % 3] += seed.of(&self.name(at));
        }
        slopes
    }

    /// All inputs.
    pub fn each(&self) -> impl Iterator<Item = &Signal> {
        self.each.iter().flat_map(|load| [&load.torque].into_iter().chain(&load.inertia))
    }

    /// The same, to change them.
    pub fn all(&mut self) -> impl Iterator<Item = &mut Signal> {
        self.each.iter_mut().flat_map(|load| [&mut load.torque].into_iter().chain(&mut load.inertia))
    }

    /// The torques.
    pub fn torques(&self) -> impl Iterator<Item = &Signal> {
        self.each.iter().map(|load| &load.torque)
    }

    /// Starts the simulation.
    pub fn start(&mut self) {
        (self.begin, self.sum) = Default::default();
    }

    /// Begins a communication step with the shaft in this state.
    pub fn step_begins(&mut self, state: &State) {
        self.all().for_each(Signal::step_begins);
        if self.have_inertia() {
            self.begin = Beginning { angle: state.angle, turns: state.turns, w: state.w };
            let [j, slope, curvature] = self.now(state);
            self.sum = Some([j, slope, curvature]);
        }
    }

    /// Ends a step of `step` (s).
    pub fn step_ends(&mut self, step: f64) {
        self.all().for_each(|signal| signal.step_ends(step));
    }

    /// Whether the torques depend at most on the speed.
    pub fn are_constant(&self) -> bool {
        self.torques().all(Signal::is_constant) && !self.have_inertia()
    }

    /// The series of Σ τ_k + Σ τ_rest,k in time, now.
    pub fn series(&self) -> Series {
        self.torques().fold(Series::from(0.0), |sum, torque| sum + torque.series())
    }

    /// The value so long after the start of the step (s).
    pub fn at(&self, t: f64) -> f64 {
        self.torques().map(|torque| torque.at(t)).sum()
    }

    /// Its coefficients about that instant in this `unit` of time.
    pub fn expand(&self, t: f64, unit: f64, row: &mut [f64]) {
        row.fill(0.0);
        self.torques().for_each(|torque| torque.add_expanded(t, unit, row));
    }

    /// Its value as set.
    pub fn set_value(&self) -> f64 {
        self.torques().map(Signal::set_value).sum()
    }

    /// Its present value.
    pub fn torque_now(&self) -> f64 {
        self.torques().map(Signal::now).sum()
    }

    /// φ − φ_n (rad).
    fn way(&self, state: &State) -> f64 {
        let turns = state.turns - self.begin.turns;
        let whole = two_product(turns, WHOLE_TURN.hi) + Double::from(turns * WHOLE_TURN.lo);
        (state.angle - self.begin.angle + whole).hi
    }

    /// Σ J_k and its derivatives by φ at the communication point: of the values set there, else of the polynomials of the previous
    /// step.
    pub fn now(&self, state: &State) -> [f64; 3] {
        if !self.have_inertia() {
            return [0.0; 3];
        }
        let way = self.way(state);
        self.each.iter().filter(|load| load.named.inertia).fold([0.0; 3], |[sum, sum1, sum2], load| {
            let [j, slope] = &load.inertia;
            let [since_j, since_slope] = [j, slope].map(|set| if set.elapsed() > 0.0 { way } else { 0.0 });
            let w = if since_slope == 0.0 { state.w } else { self.begin.w };
            let curvature = Some(slope.set_rate() / w).filter(|curvature| curvature.is_finite()).unwrap_or(0.0);
            let j = j.set_value() + (slope.set_value() + 0.5 * curvature * since_j) * since_j;
            [sum + j, sum1 + slope.set_value() + curvature * since_slope, sum2 + curvature]
        })
    }

    /// The cause of a failed step in which the shaft would turn by `way` (rad) from this state on. It is the inertia if it vanishes
    /// on the way (`own` is the shaft's over the angle), else `fault`.
    pub fn why(&self, fault: Fault, state: &State, way: f64, own: impl Fn(f64) -> f64) -> Fault {
        let Some(loads) = self.from(state) else { return fault };
        let places = (0..=PLACES).map(|i| way * f64::from(i) / f64::from(PLACES));
        let inertia = |way: f64| ([own(state.angle.hi + way), loads.at(way)[0]], state.angle.hi + way);
        // Comparisons with NaN are false.
        let lost = places.map(inertia).find(|([own, loads], _)| own + loads <= 0.0);
        lost.map_or(fault, |(inertia, phi)| not_positive(inertia, phi))
    }

    /// Σ J_k of the step over the increment of φ from this state.
    pub fn from(&self, state: &State) -> Option<Polynomial> {
        self.sum.map(|coefficients| Polynomial { coefficients, from: self.way(state) })
    }
}

/// Refuses an inertia of shaft and loads (kg·m²) that is not positive at `phi` (rad).
pub fn check_positive([own, loads]: [f64; 2], phi: f64) -> Result<(), Fault> {
    if own + loads > 0.0 { Ok(()) } else { Err(not_positive([own, loads], phi)) }
}

#[cold]
fn not_positive([own, loads]: [f64; 2], phi: f64) -> Fault {
    Fault::new(format!(
        "the inertia of shaft and loads must be positive, but J = {} kg.m2 and J_load = {} kg.m2 at phi = {} rad of the turn; take \
         J_load and dJ_load from the masses that follow the shaft without slip, and shorten the communication step",
        Number(own),
        Number(loads),
        Number(phi)
    ))
}

/// Σ J_k over the way from a state on.
#[derive(Clone, Copy)]
pub struct Polynomial {
    coefficients: [f64; 3],
    from: f64,
}

impl Polynomial {
    /// Value and slope at `way` (rad).
    pub fn at(&self, way: f64) -> [f64; 2] {
        let ([j, slope, curvature], way) = (self.coefficients, self.from + way);
        [j + (slope + 0.5 * curvature * way) * way, slope + curvature * way]
    }
}

/// Declares the inputs of the loads.
pub fn declare_loads<D>(list: &mut List<D>, loads: &Loads, get: Get<D>, set: SetInput<D>) {
    for at in loads.inputs() {
        let (text, quantity) = match at % 4 {
            0 => (
                "Load torque on the shaft; positive brakes. From a drive with impacts take its tau_mean",
                &unit::TORQUE,
            ),
            1 => ("Moment of inertia in the load that follows the shaft without slip, at phi", &unit::INERTIA),
            2 => {
                ("Its derivative by phi; its input derivative, if set, gives the second one", &unit::INERTIA_PER_ANGLE)
            }
            _ => ("Load torque on the shaft without the torque of this inertia; positive brakes", &unit::TORQUE),
        };
        // Sums and products of the inertia keep to the range of numbers.
        let most = if matches!(at % 4, 1 | 2) { 1e12 } else { f64::INFINITY };
        list.input(&loads.name(at), text, real_within(quantity, -most, most), get, set).at(at);
    }
}
