//! The forces over a turn: samples, largest values, changes of sign.

use super::{Drive, Forces, Loads};
use crate::periodic_turn::Turn;
use crate::resource::Scene;
pub use crate::search::Extreme;
use crate::search::{root, summit, zero};
use camdrive::drives::Fault;
use camdrive::drives::rigid_machine::Follower;
use camdrive::motion::MotionLaw;
use std::f64::consts::TAU;

/// Samples of a turn at least, and of the shortest wave of its laws; largest values and zeros are refined between them.
const SAMPLES: [f64; 2] = [1440.0, 24.0];

/// Values below this part of the largest one have the sign 0: they are roundings in a dwell.
pub(super) const ZERO: f64 = 1e-9;

/// A machine at constant speed.
#[derive(Clone, Debug, PartialEq)]
pub struct Machine {
    /// Its name.
    pub name: String,
    /// ω (rad/s).
    pub speed: f64,
    /// The varying part of the machine's own moment of inertia (kg·m²), which adds ½ J′ω² to the torque.
    pub inertia: Option<MotionLaw>,
    /// The drives that its cams move.
    pub drives: Vec<Drive>,
}

/// The forces at one angle.
#[derive(Clone, Debug, PartialEq)]
pub struct State {
    /// φ (rad).
    pub phi: f64,
    /// Forces of each drive.
    pub drives: Vec<Forces>,
    /// The total torque on the shaft (N·m).
    pub torque: f64,
}

/// A machine over a turn.
pub struct MachineTurn<'a> {
    /// The machine.
    pub machine: &'a Machine,
    /// States on each piece of the turn where all laws are smooth, at an even number of equal steps.
    pub pieces: Vec<Vec<State>>,
}

/// The least coordinate of a tool in a turn.
///
/// # Errors
/// The errors of [`super::Drive::at`].
pub fn least_place(follower: &Follower) -> Result<f64, Fault> {
    let drive = Drive::new("tool".to_owned(), follower.clone(), None, Loads::default())?;
    let machine = Machine { name: String::new(), speed: 0.0, inertia: None, drives: vec![drive] };
    Ok(-machine.turn()?.largest(|state| -state.drives[0].tool[0]).value)
}

impl Machine {
    /// Marks the drives whose contact opens in the periodic motion of a scene that a motor turns.
    pub fn mark(&mut self, scene: &Scene, turn: &Turn) {
        for j in turn.opened(scene) {
            self.drives.get_mut(j).into_iter().for_each(|drive| drive.loads.opens = true);
        }
    }

    /// The name of a follower within its machine, "follower1"; None for a drive of its own.
    pub(super) fn part<'a>(&self, drive: &'a Drive) -> Option<&'a str> {
        drive.name.strip_prefix(&self.name)?.strip_prefix('.')
    }

    /// The forces at φ on the piece with its middle at `within`.
    ///
    /// # Errors
    /// The errors of [`super::Drive::at`].
    pub fn at(&self, within: f64, phi: f64) -> Result<State, Fault> {
        let drives = self.drives.iter().map(|drive| drive.at(within, phi, self.speed));
        let drives = drives.collect::<Result<Vec<_>, _>>()?;
        let own = self.inertia.as_ref().map_or(0.0, |j| j.at_in(j.segment(within, true), phi).0[1]);
        let torque = drives.iter().map(|forces| forces.torque).sum::<f64>() + 0.5 * own * self.speed * self.speed;
        Ok(State { phi, drives, torque })
    }

    /// The ends of the pieces on which all laws are smooth, and the harmonic order that resolves them.
    fn pieces(&self) -> (Vec<f64>, f64) {
        let of_drives = self.drives.iter().flat_map(|d| [Some(&d.follower.cam), d.loads.load.process.as_ref()]);
        let laws: Vec<_> = of_drives.chain([self.inertia.as_ref()]).flatten().collect();
        let mut ends = vec![0.0, TAU];
        ends.extend(laws.iter().flat_map(|law| law.breakpoints()));
        ends.sort_by(f64::total_cmp);
        ends.dedup();
        (ends, laws.iter().map(|law| law.resolution()).fold(1.0, f64::max))
    }

    /// The forces over the turn.
    ///
    /// # Errors
    /// The errors of [`super::Drive::at`].
    pub fn turn(&self) -> Result<MachineTurn<'_>, Fault> {
        let (ends, resolution) = self.pieces();
        let density = f64::max(SAMPLES[0], SAMPLES[1] * resolution) / TAU;
        let piece = |ends: &[f64]| {
            let (from, width) = (ends[0], ends[1] - ends[0]);
            let steps = 2 * (0.5 * width * density).ceil().max(1.0) as usize;
            let phi = |i: usize| if i == steps { ends[1] } else { from + width * i as f64 / steps as f64 };
            (0..=steps).map(|i| self.at(from + 0.5 * width, phi(i))).collect::<Result<Vec<_>, _>>()
        };
        Ok(MachineTurn { machine: self, pieces: ends.windows(2).map(piece).collect::<Result<_, _>>()? })
    }
}

impl MachineTurn<'_> {
    /// All samples, those at the ends of pieces twice.
    pub fn states(&self) -> impl Iterator<Item = &State> {
        self.pieces.iter().flatten()
    }

    /// A function of the state at φ on a piece; NaN if it cannot be evaluated there, even if it could be nearby.
    fn on<'a>(&'a self, piece: &'a [State], f: &'a impl Fn(&State) -> f64) -> impl FnMut(f64) -> f64 + 'a {
        let within = 0.5 * (piece[0].phi + piece[piece.len() - 1].phi);
        move |phi| self.machine.at(within, phi).map_or(f64::NAN, |state| f(&state))
    }

    /// The maximum of f and its place.
    pub fn largest(&self, f: impl Fn(&State) -> f64) -> Extreme {
        let sampled = self.states().map(&f).fold(f64::NEG_INFINITY, f64::max);
        let mut tops = Vec::new();
        for piece in &self.pieces {
            let values: Vec<f64> = piece.iter().map(&f).collect();
            for peak in 0..values.len() {
                let beside = [peak.saturating_sub(1), (peak + 1).min(piece.len() - 1)];
                let [low, high] =
                    [f64::min, f64::max].map(|of| beside.map(|i| values[i]).into_iter().fold(values[peak], of));
                let rise = values[peak] - low;
                // Between samples f rises by less than these differ; what differs by roundings alone has no maximum.
                if values[peak] < high || values[peak] + rise < sampled || rise <= ZERO * sampled.abs() {
                    continue;
                }
                let ends = beside.map(|i| piece[i].phi);
                // At a maximum roundings decide from there on.
                let top = (piece[peak].phi, values[peak]);
                let (phi, value) = summit(&mut self.on(piece, &f), ends, top, 1e-9 * (ends[1] - ends[0]));
                tops.push(Extreme { phi, value });
            }
        }
        if tops.iter().all(|top| top.value < sampled) {
            let first = self.states().find(|state| f(state) >= sampled - 1e-12 * sampled.abs());
            tops.extend(first.map(|state| Extreme { phi: state.phi, value: sampled }));
        }
        Extreme::greatest(tops, |value| value).unwrap_or(Extreme { phi: 0.0, value: sampled })
    }

    /// ±1: the sense in which Q presses drive j on its cam; without a known contact the return spring's.
    pub fn sense(&self, j: usize) -> impl Fn(&State) -> f64 {
        let travel = self.mean(|state| state.drives[j].travel);
        move |state| state.drives[j].contacts.first().map_or(travel, |contact| contact.gain).signum()
    }

    /// What the cam of drive j bears in the sense of its contact: Q_rest, Q_damping and Q_inertia times these.
    fn borne(&self, j: usize) -> impl Fn(&State, [f64; 3]) -> f64 {
        let sense = self.sense(j);
        move |state, powers| {
            let parts = state.drives[j].parts.iter().zip(powers);
            sense(state) * parts.map(|(part, power)| part * power).sum::<f64>()
        }
    }

    /// The largest pull on drive j at a speed w ≥ 0 (rad/s) where it is rigid, and its place.
    pub(super) fn lacking(&self, j: usize) -> impl Fn(f64) -> Extreme {
        let (borne, way) = (self.borne(j), 1.0_f64.copysign(self.machine.speed));
        move |w| self.largest(|state| -borne(state, [1.0, way * w, w * w]))
    }

    /// The speed (rad/s) from which on force no longer keeps drive j, if it is rigid, on its cam, and the place of the first
    /// failure; 0 if it fails at rest, None if it never fails.
    ///
    /// The cam bears Q_rest + ω Q_damping + ω² Q_inertia; at that speed the least value of the turn is 0.
    pub(super) fn rigid_lift_off(&self, j: usize) -> Option<Extreme> {
        let (borne, lacking, way) = (self.borne(j), self.lacking(j), 1.0_f64.copysign(self.machine.speed));
        let (at_rest, inertia) = (lacking(0.0), self.largest(|state| -borne(state, [0.0, 0.0, 1.0])));
        // At the place of the strongest pull of inertia, it then pulls twice as much as anything presses anywhere.
        let most = |powers: [f64; 3]| self.largest(|state| borne(state, powers)).value.max(0.0);
        let (presses, damps) = (most([1.0, 0.0, 0.0]), most([0.0, way, 0.0]));
        let end = (damps + (damps * damps + 2.0 * presses * inertia.value).sqrt()) / inertia.value;
        let pulls = inertia.value > 0.0 && end.is_finite();
        // A spring without preload does not press at its longest; inertia decides there.
        let slowest = if at_rest.value < 0.0 { 0.0 } else { ZERO.sqrt() * end };
        if at_rest.value >= 0.0 && (!pulls || lacking(slowest).value >= 0.0) {
            return Some(Extreme { value: 0.0, ..at_rest });
        }
        pulls.then(|| {
            let speed = root(|w| lacking(w).value, [slowest, end]);
            Extreme { value: speed, ..lacking(speed) }
        })
    }

    /// The least F₀ (N or N·m) that keeps drive j, if it is rigid, on its cam, and the place that needs it; None if none does.
    ///
    /// From F₀ ≥ −(Q − F₀ Q₁)/Q₁ with Q₁ = dy/dU all over the turn and on the way from rest to the speed.
    pub(super) fn rigid_preload(&self, j: usize) -> Option<Extreme> {
        let (preload, sense, w) = (self.machine.drives[j].preload(), self.sense(j), self.machine.speed);
        let helps = self.largest(|state| -sense(state) * state.drives[j].travel).value < 0.0;
        let needed = |state: &State| {
            let Forces { parts: [rest, damping, inertia], travel, .. } = &state.drives[j];
            // At the part s of the speed F₀ must exceed −(Q_rest + s ω Q_damping + s² ω² Q_inertia)/Q₁.
            let at = |s: f64| preload - (rest + s * w * (damping + s * w * inertia)) / travel;
            let summit = -0.5 * damping / (w * inertia);
            [0.0, summit.clamp(0.0, 1.0), 1.0].into_iter().map(at).fold(f64::NEG_INFINITY, f64::max)
        };
        helps.then(|| self.largest(needed))
    }

    /// The angles at which f changes sign, also from one turn to the next; the beginning of an interval in which it is zero.
    pub fn sign_changes(&self, f: impl Fn(&State) -> f64) -> Vec<f64> {
        let size = self.states().map(|state| f(state).abs()).fold(0.0, f64::max);
        let sign = |value: f64| if value.abs() <= ZERO * size { 0.0 } else { value.signum() };
        let signs: Vec<(f64, f64)> = self.states().map(|state| (state.phi, sign(f(state)))).collect();
        let is_zero = |(_, sign): &&(f64, f64)| *sign == 0.0;
        let mut before = signs.iter().rev().find(|at| !is_zero(at)).map_or(0.0, |(_, sign)| *sign);
        let mut zero_since = signs.iter().rev().take_while(is_zero).last().map(|(phi, _)| *phi);
        let mut changes = Vec::new();
        for piece in &self.pieces {
            let values: Vec<f64> = piece.iter().map(&f).collect();
            for (i, value) in values.iter().enumerate() {
                let now = sign(*value);
                if now == 0.0 {
                    zero_since = zero_since.or(Some(piece[i].phi));
                    continue;
                }
                if now != before {
                    changes.push(match zero_since {
                        Some(phi) => phi,
                        // It jumps from one piece to the next.
                        None if i == 0 => piece[0].phi,
                        None => {
                            let ends = [piece[i - 1].phi, piece[i].phi];
                            zero(&mut self.on(piece, &f), ends, [values[i - 1], *value], 0.0)
                        }
                    });
                }
                (before, zero_since) = (now, None);
            }
        }
        changes.iter_mut().for_each(|phi| *phi = phi.rem_euclid(TAU));
        changes
    }

    /// The mean of f over the turn, by Simpson's rule on each piece.
    pub fn mean(&self, f: impl Fn(&State) -> f64) -> f64 {
        let on = |piece: &Vec<State>| {
            let last = piece.len() - 1;
            let weight = |i: usize| if i == 0 || i == last { 1.0 } else { 2.0 + 2.0 * (i % 2) as f64 };
            let sum: f64 = piece.iter().enumerate().map(|(i, state)| weight(i) * f(state)).sum();
            sum * (piece[last].phi - piece[0].phi) / (3.0 * last as f64)
        };
        self.pieces.iter().map(on).sum::<f64>() / TAU
    }
}
