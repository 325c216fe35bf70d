//! The contact of a follower that force keeps on its cam, in the periodic motion at constant speed.
//!
//! A rigid follower bears Q. An elastic output deforms by q, m q̈ + (b + b_r) q̇ + (c + c_r) q = F_L(U, 0, φ) − Ω b_r U′ − Ω² m U″,
//! and its cam bears −(c q + b q̇) less the loads on the cam's side. Between three samples the right side is a parabola, for which q
//! is exact; the turn ends as it begins. The contact force behind an elastic shaft is that of its drive.
//! Symbols: b_r, c_r damper and spring of the load, F_L its force, U the law. Valid while the contact holds.

use super::turn::{Extreme, MachineTurn, State, ZERO};
use super::{Compliance, Drive, Machine};
use crate::periodic_turn;
use crate::resource::Scene;
use crate::search::{root, summit};
use camdrive::drives::elastic_shaft;
use camdrive::drives::follower::load::Spring;
use camdrive::drives::settings::Settings;
use camdrive::drives::shaft::cam_drive::{DriveMode, Start, StartMode};
use serde::Serialize;
use std::f64::consts::TAU;

/// Smaller damping ratios count as this one: without damping a vibration has no end.
const LEAST_DAMPING: f64 = 1e-3;

/// The natural frequency is at most this harmonic of the slowest speed of a search.
const SLOWEST: f64 = 256.0;

/// The part of the range of an elastic shaft's speeds of which a search takes one each: a resonance is wider.
const STEP_OF_SHAFT: f64 = 0.03;

/// The largest angle (rad) of the natural vibration between two places at which the contact is regarded.
const FINE: f64 = 0.3;

/// The relative change of a speed or a preload that is no matter.
const CLOSE: f64 = 1e-6;

/// How far force alone keeps a follower on its cam.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Held {
    /// The lowest speed (rad/s) at which contact is lost, with the place; 0 if it is lost at rest, None if it is never lost.
    pub lift_off_speed: Option<Extreme>,
    /// At a higher speed with contact: the speed (rad/s) up to which contact is lost below it.
    pub regained_speed: Option<f64>,
    /// True if contact is lost at the speed of the machine.
    #[serde(skip)]
    pub lost: bool,
}

/// A sample of the turn: forces on tool and cam's side at rest, by damping for each rad/s, by inertia for each (rad/s)².
struct Sample {
    tool: [f64; 3],
    side: [f64; 3],
    sense: f64,
}

/// A smooth piece of the turn from an angle on, in equal steps (rad).
struct Piece {
    from: f64,
    step: f64,
    samples: Vec<Sample>,
}

/// A tool of mass m on c and b, with spring and damper of its load.
struct Vibration {
    m: f64,
    own: [f64; 2],
    all: [f64; 2],
    pieces: Vec<Piece>,
    /// ±1: the sense of the shaft.
    way: f64,
}

/// The largest pull (N or N·m) on the contact over the turn at a speed w ≥ 0 (rad/s), negative while it is pressed; and its place.
enum Pull<'a> {
    Rigid(&'a dyn Fn(f64) -> Extreme),
    Output(Vibration),
    Shaft(Box<elastic_shaft::Scene>, f64),
}

/// The free motion of q and q̇ over a time.
fn free(m: f64, [c, b]: [f64; 2], time: f64) -> [[f64; 2]; 2] {
    let (decay, square) = (0.5 * b / m, c / m);
    let turning = square - decay * decay;
    let e = (-decay * time).exp();
    let (cosine, sine) = if turning > 0.0 {
        let w = turning.sqrt();
        (e * (w * time).cos(), e * (w * time).sin() / w)
    } else {
        // Both parts in one power, which does not overflow.
        let w = (-turning).sqrt();
        let [slow, fast] = [(w - decay) * time, -(w + decay) * time].map(f64::exp);
        (0.5 * (slow + fast), if w > 0.0 { 0.5 * (slow - fast) / w } else { e * time })
    };
    [[cosine + decay * sine, sine], [-square * sine, cosine - decay * sine]]
}

fn moved(map: &[[f64; 2]; 2], [q, v]: [f64; 2]) -> [f64; 2] {
    map.map(|[a, b]| a * q + b * v)
}

/// The parabola through three values at 0, h and 2h.
fn parabola([a, b, c]: [f64; 3], h: f64) -> [f64; 3] {
    [a, (4.0 * b - 3.0 * a - c) / (2.0 * h), (a - 2.0 * b + c) / (2.0 * h * h)]
}

impl Vibration {
    fn new(turn: &MachineTurn<'_>, j: usize, [c, b]: [f64; 2]) -> Self {
        let (drive, sense) = (&turn.machine.drives[j], turn.sense(j));
        let load = &drive.loads.load;
        let m = drive.follower.m - drive.loads.roller.0;
        let stiffness = c + load.stiffness();
        let damping = (b + load.damping.unwrap_or(0.0)).max(2.0 * LEAST_DAMPING * (m * stiffness).sqrt());
        let piece = |piece: &Vec<State>| {
            let (from, end) = (piece[0].phi, piece[piece.len() - 1].phi);
            let sample = |state: &State| {
                let [tool, side] = drive.sides(0.5 * (from + end), state.phi, m);
                Sample { tool, side, sense: sense(state) }
            };
            Piece { from, step: (end - from) / (piece.len() - 1) as f64, samples: piece.iter().map(sample).collect() }
        };
        let (pieces, way) = (turn.pieces.iter().map(piece).collect(), 1.0_f64.copysign(turn.machine.speed));
        Vibration { m, own: [c, b], all: [stiffness, damping], pieces, way }
    }

    /// The largest pull at the speed w, and its place.
    fn pull(&self, w: f64) -> Extreme {
        let whole = free(self.m, self.all, TAU / w);
        let [q, v] = self.round(w, [0.0; 2], &mut |_, _, _| {});
        // (1 − map) z = end.
        let [[a, b], [c, d]] = [[1.0 - whole[0][0], -whole[0][1]], [-whole[1][0], 1.0 - whole[1][1]]];
        let det = a * d - b * c;
        let begin = [(d * q - b * v) / det, (a * v - c * q) / det];
        let (mut most, mut size) = (Extreme { phi: 0.0, value: f64::NEG_INFINITY }, 0.0_f64);
        let mut last: Vec<Extreme> = Vec::new();
        self.round(w, begin, &mut |first, phi, force| {
            if first {
                last.clear();
            }
            let now = Extreme { phi, value: -force };
            (size, most) = (size.max(force.abs()), if now.value > most.value { now } else { most });
            if let [.., a, b] = last[..]
                && b.value >= a.value.max(now.value)
                && b.value > a.value.min(now.value)
            {
                let bend = a.value - 2.0 * b.value + now.value;
                let away = 0.5 * (a.value - now.value) / bend;
                let top = Extreme {
                    phi: b.phi + away * (now.phi - b.phi),
                    value: b.value - 0.25 * (a.value - now.value) * away,
                };
                most = if top.value > most.value { top } else { most };
            }
            last.push(now);
        });
        Extreme { phi: most.phi, value: most.value - ZERO * size }
    }

    /// Goes round once from this start and passes on the contact force in the sense in which it presses: whether a piece begins, its
    /// place and the force; returns the end.
    fn round(&self, w: f64, begin: [f64; 2], see: &mut dyn FnMut(bool, f64, f64)) -> [f64; 2] {
        let ([stiffness, damping], [c, b], signed) = (self.all, self.own, self.way * w);
        let at = |parts: &[f64; 3]| parts[0] + signed * (parts[1] + signed * parts[2]);
        let mut z = begin;
        let backwards = self.way < 0.0;
        for i in 0..self.pieces.len() {
            let piece = &self.pieces[if backwards { self.pieces.len() - 1 - i } else { i }];
            let h = piece.step / w;
            let parts = ((stiffness / self.m).sqrt() * h / FINE).ceil().clamp(1.0, 64.0) as usize;
            let (map, count) = (free(self.m, self.all, h / parts as f64), piece.samples.len() - 1);
            for k in (0..count).step_by(2) {
                let place = |k: usize| if backwards { count - k } else { k };
                let three = [k, k + 1, k + 2].map(|k| &piece.samples[place(k)]);
                let [g0, g1, g2] = parabola(three.map(|sample| at(&sample.tool)), h);
                let side = parabola(three.map(|sample| at(&sample.side)), h);
                let p2 = g2 / stiffness;
                let p1 = (g1 - 2.0 * damping * p2) / stiffness;
                let p0 = (g0 - damping * p1 - 2.0 * self.m * p2) / stiffness;
                let forced = |t: f64| [p0 + t * (p1 + t * p2), p1 + 2.0 * t * p2];
                let mut rest = [z[0] - p0, z[1] - p1];
                let last = k + 2 == count;
                for part in 0..=2 * parts {
                    let t = h * part as f64 / parts as f64;
                    z = [0, 1].map(|i| rest[i] + forced(t)[i]);
                    if part < 2 * parts || last {
                        let phi = piece.from + piece.step * (place(k) as f64 + self.way * part as f64 / parts as f64);
                        let force = side[0] + t * (side[1] + t * side[2]) - c * z[0] - b * z[1];
                        see(k == 0 && part == 0, phi, three[part / parts].sense * force);
                    }
                    rest = moved(&map, rest);
                }
            }
        }
        z
    }
}

impl Drive {
    /// The forces on the tool of mass m before its spring, and the contact force of the cam's side alone, at φ on the piece with its
    /// middle at `within`; each at rest, by damping for each rad/s and by inertia for each (rad/s)².
    fn sides(&self, within: f64, phi: f64, m: f64) -> [[f64; 3]; 2] {
        let law = &self.follower.cam;
        let [u, u1, u2, ..] = law.at_in(law.segment(within, true), phi).0;
        let (load, (m_side, on_side)) = (&self.loads.load, &self.loads.roller);
        let process = load.process.as_ref().map(|p| p.at_in(p.segment(within, true), phi).0[0]);
        let [b, b_side] = [load, on_side].map(|load| load.damping.unwrap_or(0.0));
        [
            [load.force(m, [u, 0.0], process, None), -b * u1, -m * u2],
            [-on_side.force(*m_side, [u, 0.0], None, None), b_side * u1, (m_side + self.reduced_inertia()) * u2],
        ]
    }

    /// The same drive with a preload that is larger by this; F₀ acts where it has a spring.
    fn pressed(&self, more: f64) -> Drive {
        let mut drive = self.clone();
        let on_tool = drive.loads.load.spring.is_some() || drive.loads.roller.1.spring.is_none();
        let load = if on_tool { &mut drive.loads.load } else { &mut drive.loads.roller.1 };
        load.spring.get_or_insert(Spring::default()).preload += more;
        drive
    }
}

impl<'a> Pull<'a> {
    fn of(turn: &MachineTurn<'_>, j: usize, rigid: &'a dyn Fn(f64) -> Extreme) -> Self {
        let drive = &turn.machine.drives[j];
        match drive.loads.compliance {
            Compliance::Output(spring) if drive.follower.m > drive.loads.roller.0 => {
                Pull::Output(Vibration::new(turn, j, spring))
            }
            Compliance::Shaft(parameters, linear) => {
                let sense = turn.pieces.first().and_then(|piece| piece.first()).map_or(1.0, turn.sense(j));
                let (load, cam) = (drive.loads.load.clone(), drive.follower.cam.clone());
                let start = Start { mode: StartMode::SteadyState, q: 0.0, q_dot: 0.0 };
                let mode = DriveMode::Constant { w: turn.machine.speed, phi_start: 0.0 };
                let solver = Settings::default();
                let scene = elastic_shaft::Scene { parameters, linear, load, cam, drive: mode, start, solver };
                Pull::Shaft(Box::new(scene), sense)
            }
            _ => Pull::Rigid(rigid),
        }
    }

    /// The largest pull at the speed w > 0; NaN without a periodic motion.
    fn at(&self, w: f64) -> Extreme {
        match self {
            Pull::Rigid(pull) => pull(w),
            Pull::Output(vibration) => vibration.pull(w),
            Pull::Shaft(scene, sense) => {
                let mut scene = scene.as_ref().clone();
                if let DriveMode::Constant { w: speed, .. } = &mut scene.drive {
                    *speed = w.copysign(*speed);
                }
                let none = Extreme { phi: 0.0, value: f64::NAN };
                let Ok(turn) = periodic_turn::sketch(&Scene::from(scene)) else { return none };
                let Some(force) = turn.output("contact_force") else { return none };
                let least = [[force.least_at, -force.least], [force.largest_at, force.largest]];
                let [phi, value] = least[usize::from(*sense < 0.0)];
                Extreme { phi, value: value - ZERO * force.size }
            }
        }
    }

    /// The speeds that a search regards, ascending: four between resonances, or a quarter of their width.
    fn speeds(&self, turn: &MachineTurn<'_>, rigid: Option<Extreme>) -> Vec<f64> {
        match self {
            Pull::Rigid(_) => Vec::new(),
            Pull::Output(Vibration { m, all: [c, b], .. }) => {
                let natural = (c / m).sqrt();
                let ratio = 0.5 * b / (m * natural);
                // A vibration without end has no width to look for.
                let part = if ratio > 1.01 * LEAST_DAMPING { (0.5 * ratio).min(0.05) } else { 0.01 };
                let (mut ratio, mut speeds) = (SLOWEST, Vec::new());
                while ratio > 0.2 {
                    speeds.push(natural / ratio);
                    // Below, whole numbers are among the quarters.
                    ratio = if part * ratio > 0.25 {
                        ratio * (1.0 - part)
                    } else if ratio > 1.0 {
                        ((4.0 * ratio - 1e-9).ceil() - 1.0) / 4.0
                    } else {
                        0.8 * ratio
                    };
                }
                speeds
            }
            Pull::Shaft(..) => {
                let speed = turn.machine.speed.abs();
                let top = rigid.map_or(speed, |at| at.value.max(speed));
                let low = 0.4 * rigid.map_or(speed, |at| if speed > 0.0 { at.value.min(speed) } else { at.value });
                if !(low > 0.0 && top.is_finite()) {
                    return Vec::new();
                }
                let count = ((1.2 * top / low).ln() / STEP_OF_SHAFT).ceil() as i32;
                (0..=count).map(|i| low * (STEP_OF_SHAFT * f64::from(i)).exp()).collect()
            }
        }
    }

    /// The speeds with the pulls at them, and summits between them that may pull; up to the first pull at or above `enough`.
    fn sampled(&self, speeds: impl IntoIterator<Item = f64>, enough: f64) -> Vec<[f64; 2]> {
        let mut list: Vec<[f64; 2]> = Vec::new();
        for w in speeds {
            let value = self.at(w).value;
            if value.is_nan() {
                continue;
            }
            if let [.., [a, at_a], [b, at_b]] = list[..]
                && at_b <= 0.0
                && at_b >= at_a.max(value)
                && 2.0 * at_b - at_a.min(value) > 0.0
            {
                let top = summit(&mut |w| self.at(w).value, [a, w], (b, at_b), CLOSE * w);
                let place = list.len() - usize::from(top.0 < b);
                list.insert(place, [top.0, top.1]);
            }
            list.push([w, value]);
            if w >= enough && list.iter().any(|[_, pull]| *pull > 0.0) {
                break;
            }
        }
        list
    }
}

impl MachineTurn<'_> {
    /// How far force keeps drive j on its cam.
    pub fn held(&self, j: usize) -> Held {
        let (rigid, w) = (self.rigid_lift_off(j), self.machine.speed.abs());
        let opens = self.machine.drives[j].loads.opens;
        let lost_below = |from: Option<Extreme>| opens || from.is_some_and(|from| from.value == 0.0 || from.value < w);
        let (lacking, none) =
            (self.lacking(j), Held { lift_off_speed: rigid, regained_speed: None, lost: lost_below(rigid) });
        let pull = Pull::of(self, j, &lacking);
        if rigid.is_some_and(|from| from.value == 0.0) || matches!(pull, Pull::Rigid(_)) {
            return none;
        }
        let mut speeds = pull.speeds(self, rigid);
        speeds.extend((w > 0.0).then_some(w));
        speeds.sort_by(f64::total_cmp);
        let list = pull.sampled(speeds, w);
        if list.is_empty() {
            return none;
        }
        let value = |w: f64| pull.at(w).value;
        let change = |ends: &[[f64; 2]]| root(value, [ends[0][0], ends[1][0]]);
        let first = match list[0][1] > 0.0 {
            true => Some(list[0][0]),
            false => list.windows(2).find(|pair| pair[1][1] > 0.0).map(change),
        };
        let place = |w: f64| Extreme { value: w, phi: pull.at(w).phi };
        let lost = opens || w > 0.0 && list.iter().any(|[at, pull]| *at == w && *pull > 0.0);
        let below: Vec<[f64; 2]> = list.into_iter().filter(|[at, _]| *at <= w).collect();
        let regained = below.windows(2).rev().find(|pair| pair[0][1] > 0.0 && pair[1][1] <= 0.0).filter(|_| !lost);
        Held { lift_off_speed: first.map(place), regained_speed: regained.map(change), lost }
    }

    /// The least preload (N or N·m) with which contact holds at all speeds from rest to that of the machine, and the place that needs
    /// it; None if no preload helps.
    pub fn least_preload(&self, j: usize) -> Option<Extreme> {
        let rigid = self.rigid_preload(j)?;
        let (drive, w) = (&self.machine.drives[j], self.machine.speed.abs());
        let elastic = match drive.loads.compliance {
            Compliance::Rigid => return Some(rigid),
            Compliance::Output([c, _]) => c / (c + drive.loads.load.stiffness()),
            Compliance::Shaft(..) => 1.0,
        };
        let at_side = drive.loads.load.spring.is_none() && drive.loads.roller.1.spring.is_some();
        let (gain, mut more, mut phi) = (if at_side { 1.0 } else { elastic }, 0.0, rigid.phi);
        // Linear but for a shaft.
        for _ in 0..4 {
            let mut machine = Machine { drives: vec![drive.pressed(more)], ..self.machine.clone() };
            machine.drives[0].loads.material = None;
            let turn = machine.turn().ok()?;
            let lacking = turn.lacking(0);
            let pull = Pull::of(&turn, 0, &lacking);
            let speeds = pull.speeds(self, self.rigid_lift_off(j)).into_iter().filter(|speed| *speed < w).chain([w]);
            let list = pull.sampled(speeds, f64::INFINITY);
            let [speed, worst] = *list.iter().max_by(|a, b| a[1].total_cmp(&b[1]))?;
            if more != 0.0 && worst <= 0.0 {
                break;
            }
            (more, phi) = (more + worst / gain, pull.at(speed).phi);
        }
        Some(Extreme { value: drive.preload() + more, phi })
    }
}
