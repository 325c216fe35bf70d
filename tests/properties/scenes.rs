//! Random scenes over the admissible parameters, in logarithmic scale, and their images under the symmetries.

use camdrive::drives::rigid_machine::Follower;
use camdrive::motion::plan::SegmentLaw;
use camdrive::motion::{
    Cycle, CyclePlan, Fourier, MotionLaw, MotionPlan, PlanPoint, StandardLaw, Table, table::Points,
};
use proptest::prelude::*;
use serde_json::{Value, json};
use std::f64::consts::{PI, TAU};

/// The models with a driven cam.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Model {
    Output,
    LinearShaft,
    Shaft,
    Backlash,
}

/// How a drive starts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Start {
    /// At rest relative to the cam.
    AtRest,
    /// From q and q̇, a machine from its speed.
    Given,
    /// On the periodic motion.
    Steady,
}

impl Start {
    /// As a resolved scene has it, with `q` and `q_dot`.
    pub fn resolved(self, q: f64, q_dot: f64) -> Value {
        let mode = match self {
            Start::AtRest => "at_rest",
            Start::Given => "given",
            Start::Steady => "steady_state",
        };
        json!({"mode": mode, "q": q, "q_dot": q_dot})
    }
}

/// A cam drive at constant speed.
#[derive(Clone, Debug)]
pub struct CamScene {
    pub model: Model,
    pub start: Start,
    /// Mass of the follower (with backlash: m1) (kg).
    pub m: f64,
    /// J (kg·m²) of the shaft, m2 (kg) of the backlash.
    pub second: f64,
    pub c: f64,
    pub b: f64,
    /// Clearance (m) and restitution.
    pub s: f64,
    pub e: f64,
    pub law: MotionLaw,
    pub w: f64,
    pub phi_start: f64,
    pub q: f64,
    pub q_dot: f64,
    /// Length of the run (s).
    pub span: f64,
}

/// What drives a machine.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Torque {
    None,
    /// M_k (N·m), s_k, w_s (rad/s) and the lag (s), 0 for none.
    Kloss([f64; 4]),
    /// The input M_an, constant (N·m).
    Input(f64),
}

/// A rigid machine under a constant load.
#[derive(Clone, Debug)]
pub struct MachineScene {
    pub start: Start,
    pub j0: f64,
    pub varying: Option<MotionLaw>,
    pub followers: Vec<Follower>,
    pub torque: Torque,
    /// M_an at the start of a motor with a lag (N·m).
    pub torque_start: f64,
    pub load: f64,
    pub phi_start: f64,
    pub w_start: f64,
    pub span: f64,
}

pub fn solver() -> Value {
    json!({"tolerance": 0.0, "method": "adaptive", "step_size": 0.0})
}

impl CamScene {
    /// The name of the model and its resolved scene.
    pub fn resolved(&self) -> (&'static str, Value) {
        let mut scene = json!({
            "parameters": {"c": self.c, "b": self.b}, "cam": self.law, "solver": solver(),
            "drive": {"constant": {"w": self.w, "phi_start": self.phi_start}},
            "start": self.start.resolved(self.q, self.q_dot),
        });
        scene["linear"] = (self.model == Model::LinearShaft).into();
        let mut put = |name: &str, value: f64| scene["parameters"][name] = value.into();
        let model = match self.model {
            Model::Output => {
                put("m", self.m);
                "ElasticCamDrive.output"
            }
            Model::LinearShaft | Model::Shaft => {
                put("m", self.m);
                put("inertia", self.second);
                "ElasticCamDrive.shaft"
            }
            Model::Backlash => {
                put("m1", self.m);
                put("m2", self.second);
                put("s", self.s);
                put("e", self.e);
                "BacklashDrive"
            }
        };
        (model, scene)
    }

    /// t → λt: speeds divided by λ, damping by λ, stiffness by λ²; q(t) becomes q(t/λ).
    pub fn slower(&self, factor: f64) -> Self {
        CamScene {
            c: self.c / (factor * factor),
            b: self.b / factor,
            w: self.w / factor,
            q_dot: self.q_dot / factor,
            span: self.span * factor,
            ..self.clone()
        }
    }

    /// The machine seen from behind its cam: φ → −φ with the speed reversed. U(φ) becomes U(−φ); q of a shaft changes
    /// its sign.
    pub fn reversed(&self) -> Self {
        let sign = if matches!(self.model, Model::Shaft | Model::LinearShaft) { -1.0 } else { 1.0 };
        CamScene {
            law: backwards(&self.law),
            w: -self.w,
            phi_start: -self.phi_start,
            q: sign * self.q,
            q_dot: sign * self.q_dot,
            ..self.clone()
        }
    }

    /// The machine upside down: U → −U. q changes its sign, except that of a shaft, which knows U′² only.
    pub fn mirrored(&self) -> Self {
        let sign = if matches!(self.model, Model::Shaft | Model::LinearShaft) { 1.0 } else { -1.0 };
        CamScene { law: times(&self.law, -1.0), q: sign * self.q, q_dot: sign * self.q_dot, ..self.clone() }
    }

    /// The same drive a little stiffer: how much it changes tells how far rounding may be magnified.
    pub fn perturbed(&self) -> Self {
        CamScene { c: self.c * (1.0 + 1e-10), ..self.clone() }
    }
}

impl MachineScene {
    pub fn resolved(&self) -> (&'static str, Value) {
        let motor = match self.torque {
            Torque::None => json!("none"),
            Torque::Kloss([m_k, s_k, w_s, lag]) => json!({"kloss": {
                "breakdown_torque": m_k, "breakdown_slip": s_k, "synchronous_speed": w_s,
                "dynamics": if lag > 0.0 { Some(lag) } else { None },
            }}),
            Torque::Input(_) => json!("input"),
        };
        let scene = json!({
            "inertia": {"constant": self.j0, "varying": self.varying}, "followers": self.followers, "motor": motor,
            "loads": [{"name": "", "inertia": false}],
            "start": self.start.resolved(0.0, 0.0)["mode"], "phi_start": self.phi_start, "w_start": self.w_start, "solver": solver(),
        });
        ("RigidMachine", scene)
    }

    /// The inputs, which stay as they are, and the torque of a motor with a lag.
    pub fn inputs(&self) -> Vec<(&'static str, f64)> {
        let torque = match self.torque {
            Torque::Input(m) => Some(("M_an", m)),
            Torque::Kloss([.., lag]) if lag > 0.0 => Some(("motor.M_start", self.torque_start)),
            _ => None,
        };
        [("tau", self.load)].into_iter().chain(torque).collect()
    }

    pub fn reversed(&self) -> Self {
        let torque = match self.torque {
            Torque::Kloss([m, s, w, lag]) => Torque::Kloss([m, s, -w, lag]),
            Torque::Input(m) => Torque::Input(-m),
            Torque::None => Torque::None,
        };
        let (phi_start, w_start) = (-self.phi_start, -self.w_start);
        let (load, torque_start) = (-self.load, -self.torque_start);
        let scene = MachineScene { torque, torque_start, phi_start, w_start, load, ..self.clone() };
        scene.with_laws(backwards)
    }

    /// With all laws changed, also that of the inertia.
    pub fn with_laws(mut self, change: impl Fn(&MotionLaw) -> MotionLaw) -> Self {
        self.varying.iter_mut().for_each(|law| *law = change(law));
        self.followers.iter_mut().for_each(|follower| follower.cam = change(&follower.cam));
        self
    }

    /// Upside down, U → −U, of cams that move their tools themselves.
    pub fn mirrored(&self) -> Self {
        let mut mirrored = self.clone();
        mirrored.followers.iter_mut().for_each(|follower| follower.cam = times(&follower.cam, -1.0));
        mirrored
    }

    pub fn perturbed(&self) -> Self {
        MachineScene { j0: self.j0 * (1.0 + 1e-10), ..self.clone() }
    }
}

/// factor · U(φ).
pub fn times(law: &MotionLaw, factor: f64) -> MotionLaw {
    match law {
        MotionLaw::Fourier(series) => MotionLaw::Fourier(series.scaled(factor)),
        MotionLaw::Cycle(cycle) => {
            let plan = *cycle.plan();
            let (stroke, lower) = (plan.stroke * factor, plan.lower * factor);
            MotionLaw::Cycle(Cycle::new(CyclePlan { stroke, lower, ..plan }))
        }
        MotionLaw::Table(table) => {
            let mut table = table.clone();
            table.scale *= factor;
            MotionLaw::Table(table)
        }
        MotionLaw::Plan(plan) => {
            let scaled = plan.points().iter().map(|p| PlanPoint {
                u: factor * p.u,
                velocity: p.velocity.map(|v| factor * v),
                ..*p
            });
            MotionLaw::Plan(MotionPlan::new(scaled.collect()))
        }
        MotionLaw::Polyline(_) | MotionLaw::Crank(_) => {
            unreachable!("no cam is drawn with lines or turns with the shaft")
        }
    }
}

/// U(−φ): the return comes first. The laws of the cycles are symmetric, f(z) = 1 − f(1 − z), so a return run backwards
/// is a rise.
pub fn backwards(law: &MotionLaw) -> MotionLaw {
    match law {
        MotionLaw::Fourier(series) => {
            MotionLaw::Fourier(Fourier::new(series.a.clone(), series.b.iter().map(|b| -b).collect()))
        }
        MotionLaw::Cycle(cycle) => {
            let plan = *cycle.plan();
            let end = plan.rise_start + plan.rise_angle + plan.upper_dwell + plan.return_angle;
            MotionLaw::Cycle(Cycle::new(CyclePlan {
                rise_start: (-end).rem_euclid(TAU),
                rise_angle: plan.return_angle,
                return_angle: plan.rise_angle,
                rise_law: plan.return_law,
                return_law: plan.rise_law,
                inflections: [plan.inflections[1], plan.inflections[0]].map(|part| part.map(|part| 1.0 - part)),
                ..plan
            }))
        }
        MotionLaw::Table(table) => {
            let points = table.points();
            let mut pairs: Vec<(f64, f64)> =
                points.angles.iter().zip(&points.lifts).map(|(a, l)| ((-a).rem_euclid(TAU), *l)).collect();
            pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
            let (angles, lifts) = pairs.into_iter().unzip();
            let mut reversed = Table::new(Points { angles, lifts }).expect("the same points");
            reversed.scale = table.scale;
            MotionLaw::Table(reversed)
        }
        MotionLaw::Plan(plan) => {
            let points = plan.points();
            let reversed = |(i, p): (usize, &PlanPoint)| {
                let next = points[(i + 1) % points.len()];
                let inflection = next.inflection.map(|part| 1.0 - part);
                PlanPoint { phi: -p.phi, velocity: p.velocity.map(|v| -v), law: next.law, inflection, ..*p }
            };
            MotionLaw::Plan(MotionPlan::new(points.iter().enumerate().map(reversed).rev().collect()))
        }
        MotionLaw::Polyline(_) | MotionLaw::Crank(_) => {
            unreachable!("no cam is drawn with lines or turns with the shaft")
        }
    }
}

/// U(φ − angle).
pub fn turned(law: &MotionLaw, angle: f64) -> MotionLaw {
    match law {
        MotionLaw::Fourier(series) => MotionLaw::Fourier(series.delayed(angle)),
        MotionLaw::Cycle(cycle) => {
            let plan = *cycle.plan();
            let rise_start = reduced(plan.rise_start + angle);
            MotionLaw::Cycle(Cycle::new(CyclePlan { rise_start, ..plan }))
        }
        MotionLaw::Table(table) => {
            let Points { angles, lifts } = table.points().clone();
            let points = Points { angles: angles.iter().map(|phi| phi + angle).collect(), lifts };
            let mut turned = Table::new(points).expect("the same points");
            turned.scale = table.scale;
            MotionLaw::Table(turned)
        }
        MotionLaw::Plan(plan) => {
            let angle = reduced(angle);
            let turned = plan.points().iter().map(|p| PlanPoint { phi: p.phi + angle, ..*p });
            MotionLaw::Plan(MotionPlan::new(turned.collect()))
        }
        MotionLaw::Polyline(_) | MotionLaw::Crank(_) => {
            unreachable!("no cam is drawn with lines or turns with the shaft")
        }
    }
}

/// The angle within half a turn of 0.
pub fn reduced(angle: f64) -> f64 {
    angle - TAU * (angle / TAU).round()
}

/// U(kφ).
pub fn geared(law: &MotionLaw, k: usize) -> MotionLaw {
    let times = k as f64;
    // The angles of all k passages.
    let within = |turn: usize, phi: f64| (phi + TAU * turn as f64) / times;
    match law {
        MotionLaw::Fourier(series) => MotionLaw::Fourier(geared_series(series, k)),
        MotionLaw::Cycle(cycle) => geared(&as_plan(cycle), k),
        MotionLaw::Table(table) => {
            let points = table.points();
            let angles = (0..k).flat_map(|turn| points.angles.iter().map(move |phi| within(turn, *phi))).collect();
            let lifts = (0..k).flat_map(|_| points.lifts.iter().copied()).collect();
            let mut geared = Table::new(Points { angles, lifts }).expect("ascending points");
            geared.scale = table.scale;
            MotionLaw::Table(geared)
        }
        MotionLaw::Plan(plan) => {
            let faster = |turn: usize, p: &PlanPoint| PlanPoint {
                phi: within(turn, p.phi),
                velocity: p.velocity.map(|v| times * v),
                acceleration: p.acceleration.map(|a| times.powi(2) * a),
                jerk: p.jerk.map(|j| times.powi(3) * j),
                ..*p
            };
            let points = (0..k).flat_map(|turn| plan.points().iter().map(move |p| faster(turn, p)));
            MotionLaw::Plan(MotionPlan::new(points.collect()))
        }
        MotionLaw::Polyline(_) | MotionLaw::Crank(_) => {
            unreachable!("no cam is drawn with lines or turns with the shaft")
        }
    }
}

pub fn geared_series(series: &Fourier, k: usize) -> Fourier {
    let spread = |list: &[f64]| {
        let mut spread = vec![0.0; k * series.order() + 1];
        list.iter().enumerate().for_each(|(n, value)| spread[k * n] = *value);
        spread
    };
    Fourier::new(spread(&series.a), spread(&series.b))
}

/// The cycle by the points between which it moves.
pub fn as_plan(cycle: &Cycle) -> MotionLaw {
    let CyclePlan { stroke, lower, rise_start, rise_angle, upper_dwell, return_angle, .. } = *cycle.plan();
    let CyclePlan { rise_law, return_law, inflections, .. } = *cycle.plan();
    let rest = |phi, u, law: Option<StandardLaw>, inflection| PlanPoint {
        phi,
        u,
        velocity: None,
        acceleration: None,
        free: false,
        jerk: None,
        law: law.map(SegmentLaw::Standard),
        inflection,
    };
    let (top, upper) = (rise_start + rise_angle, lower + stroke);
    let mut points = vec![rest(rise_start, lower, None, None), rest(top, upper, Some(rise_law), inflections[0])];
    if upper_dwell > 0.0 {
        points.push(rest(top + upper_dwell, upper, None, None));
    }
    points.push(rest(top + upper_dwell + return_angle, lower, Some(return_law), inflections[1]));
    if cycle.plan().lower_dwell() <= 1e-9 {
        // The return ends where the rise begins.
        let end = points.pop().expect("a return");
        points[0] = PlanPoint { law: end.law, inflection: end.inflection, ..points[0] };
    }
    MotionLaw::Plan(MotionPlan::new(points))
}

/// The series as a table of `count` points.
pub fn as_table(series: &Fourier, count: usize) -> MotionLaw {
    let angles: Vec<f64> = (0..count).map(|i| TAU * i as f64 / count as f64).collect();
    let lifts = angles.iter().map(|phi| series.at(*phi).0[0]).collect();
    MotionLaw::Table(Table::new(Points { angles, lifts }).expect("ascending points"))
}

/// 10^x for x in the range.
pub fn decades(low: f64, high: f64) -> impl Strategy<Value = f64> {
    (low..high).prop_map(|x| 10_f64.powf(x))
}

/// 1 or −1.
pub fn sign() -> impl Strategy<Value = f64> {
    prop_oneof![Just(1.0), Just(-1.0)]
}

pub fn fourier() -> impl Strategy<Value = MotionLaw> {
    (prop::collection::vec((-1.0..1.0_f64, -1.0..1.0_f64), 1..12), 1.0..3.0_f64).prop_map(|(pairs, decay)| {
        let size = |k: usize| 0.5 * ((k + 1) as f64).powf(-decay);
        let of = |pick: fn(&(f64, f64)) -> f64| {
            std::iter::once(0.0).chain(pairs.iter().enumerate().map(move |(k, p)| pick(p) * size(k))).collect()
        };
        // A cam that hardly moves makes every relative error one of nothing.
        let mut series = Fourier::new(of(|p| p.0), of(|p| p.1));
        series.a[1] += 0.3_f64.copysign(series.a[1]);
        MotionLaw::Fourier(series)
    })
}

pub fn cycle() -> impl Strategy<Value = MotionLaw> {
    let law = || (0..StandardLaw::ALL.len()).prop_map(|i| StandardLaw::ALL[i]);
    // Shares of the turn that rise, dwell, return and dwell take.
    let shares = (0.2..1.0_f64, 0.0..0.5_f64, 0.2..1.0_f64, 0.0..0.5_f64);
    let inflection = || prop_oneof![Just(None), (0.3..0.7_f64).prop_map(Some)];
    let laws = (law(), law(), inflection(), inflection());
    (shares, -6.0..6.0_f64, laws).prop_map(|((rise, upper, back, lower), rise_start, laws)| {
        let (rise_law, return_law, rise_inflection, return_inflection) = laws;
        let unit = TAU / (rise + upper + back + lower);
        MotionLaw::Cycle(Cycle::new(CyclePlan {
            stroke: 1.0,
            lower: 0.0,
            rise_start,
            rise_angle: rise * unit,
            upper_dwell: upper * unit,
            return_angle: back * unit,
            rise_law,
            return_law,
            inflections: [rise_inflection, return_inflection],
        }))
    })
}

/// Rests and points of constant velocity, with the standard laws between them.
fn plan() -> impl Strategy<Value = MotionLaw> {
    let point = (0.4..1.0_f64, -0.5..0.5_f64, prop_oneof![Just(None), (-0.5..0.5_f64).prop_map(Some)]);
    prop::collection::vec(point, 3..7).prop_map(|points| {
        let unit = TAU / points.iter().map(|(share, ..)| share).sum::<f64>();
        let mut phi = -3.0;
        let points = points.iter().map(|&(share, u, velocity)| {
            phi += share * unit;
            let rest = PlanPoint {
                phi,
                u,
                velocity,
                acceleration: None,
                free: false,
                jerk: None,
                law: None,
                inflection: None,
            };
            // A follower that never moves makes every relative error one of nothing.
            PlanPoint { u: if u.abs() < 0.1 { 0.3_f64.copysign(u) } else { u }, ..rest }
        });
        MotionLaw::Plan(MotionPlan::new(points.collect()))
    })
}

/// The points of a smooth profile, slightly beside an even division.
fn table() -> impl Strategy<Value = MotionLaw> {
    (12..40_usize, 0.0..0.3_f64, -0.3..0.3_f64, -PI..PI).prop_map(|(n, shift, second, phase)| {
        let angles: Vec<f64> =
            (0..n).map(|i| TAU * (i as f64 + shift * (2.7 * i as f64).sin().abs()) / n as f64).collect();
        let lifts = angles.iter().map(|x| 0.5 * x.cos() + second * (2.0 * x + phase).sin()).collect();
        MotionLaw::Table(Table::new(Points { angles, lifts }).expect("ascending points"))
    })
}

/// A law of unit stroke, more or less.
pub fn law() -> impl Strategy<Value = MotionLaw> {
    prop_oneof![3 => fourier(), 2 => cycle(), 1 => table(), 1 => plan()]
}

/// None, or a share of the critical one from 1e-4 to 1e3.
fn damping_ratio() -> impl Strategy<Value = f64> {
    prop_oneof![1 => Just(0.0), 4 => decades(-4.0, 3.0)]
}

/// Laws, speeds and start common to the cam drives: law, stroke (m), w, phi_start, q, q̇ (as shares).
fn common() -> impl Strategy<Value = (MotionLaw, f64, f64, f64, [f64; 2])> {
    (
        law(),
        decades(-6.0, 1.0),
        decades(-4.0, 4.0),
        sign(),
        -1e3..1e3_f64,
        prop_oneof![Just([0.0, 0.0]), [-1.0..1.0_f64, -1.0..1.0_f64]],
    )
        .prop_map(|(law, stroke, w, sign, phi, start)| (times(&law, stroke), stroke, sign * w, phi, start))
}

/// Up to three turns, at most `periods` natural periods.
fn span(share: f64, w: f64, natural: f64, periods: f64) -> f64 {
    share * (3.0 * TAU / w.abs()).min(periods * TAU / natural)
}

pub fn output() -> impl Strategy<Value = CamScene> {
    (common(), decades(-3.0, 3.0), decades(-3.0, 2.0), damping_ratio(), 0.1..1.0_f64).prop_map(
        |((law, stroke, w, phi_start, start), m, eta, ratio, share)| {
            let natural = w.abs() / eta;
            CamScene {
                model: Model::Output,
                start: Start::Given,
                m,
                second: 0.0,
                c: m * natural * natural,
                b: 2.0 * ratio * m * natural,
                s: 0.0,
                e: 0.0,
                law,
                w,
                phi_start,
                q: 0.1 * start[0] * stroke,
                q_dot: 0.1 * start[1] * stroke * natural,
                span: span(share, w, natural, 300.0),
            }
        },
    )
}

/// `highest`: the largest η = w/√(c/J̄).
pub fn shaft(model: Model, highest: f64) -> impl Strategy<Value = CamScene> {
    (common(), decades(-3.0, 3.0), decades(-3.0, 3.0), decades(-3.0, highest.log10()), damping_ratio(), 0.1..1.0_f64)
        .prop_map(move |((law, stroke, w, phi_start, start), m, share_of_mass, eta, ratio, share)| {
            // J from a thousandth to a thousand times that of the mass.
            let of_mass = m * (law.bound(1) / 2.0).powi(2);
            let inertia = (of_mass * share_of_mass).max(1e-11);
            let natural = w.abs() / eta;
            let c = (inertia + of_mass) * natural * natural;
            let _ = stroke;
            CamScene {
                model,
                start: Start::Given,
                m,
                second: inertia,
                c,
                b: 2.0 * ratio * (inertia + of_mass) * natural,
                s: 0.0,
                e: 0.0,
                law,
                w,
                phi_start,
                q: 0.05 * start[0],
                q_dot: 0.05 * start[1] * natural,
                span: span(share, w, (c / inertia).sqrt(), 150.0),
            }
        })
}

pub fn backlash() -> impl Strategy<Value = CamScene> {
    let restitution = prop_oneof![2 => Just(0.0), 1 => Just(1.0), 3 => 0.0..1.0_f64];
    let clearance = prop_oneof![1 => Just(0.0), 6 => decades(-6.0, 0.0)];
    (
        common(),
        decades(-2.0, 2.0),
        decades(-2.0, 2.0),
        decades(-2.0, 1.0),
        damping_ratio(),
        clearance,
        restitution,
        0.1..1.0_f64,
    )
        .prop_map(|((law, stroke, w, phi_start, start), m2, mu, eta, ratio, s, e, share)| {
            // The least stiffness of the FMU is 1e-6 N/m; a drive that is slower by e³ has 1/400 of its stiffness.
            let natural = (w.abs() / eta).max((1e-3 / m2).sqrt());
            CamScene {
                model: Model::Backlash,
                start: Start::Given,
                m: mu * m2,
                second: m2,
                c: m2 * natural * natural,
                // Elastic impacts against a strong damper have no end.
                b: if e > 0.5 { 0.0 } else { 2.0 * ratio * m2 * natural },
                s: s * stroke,
                e,
                law,
                w,
                phi_start,
                q: 0.01 * start[0] * stroke,
                q_dot: 0.01 * start[1] * stroke * natural,
                span: span(share, w, natural * (1.0 + 1.0 / mu).sqrt(), 20.0),
            }
        })
}

pub fn machine() -> impl Strategy<Value = MachineScene> {
    let followers = prop::collection::vec((decades(-3.0, 3.0), law(), decades(-4.0, 0.0)), 1..3);
    let kloss = (
        decades(-2.0, 2.0),
        decades(-3.0, 1.0),
        sign(),
        decades(-1.0, 1.0),
        prop_oneof![
            2 => Just(0.0),
            1 => decades(-4.0, 0.0)
        ],
    );
    // Relative to the machine.
    let torque = prop_oneof![
        1 => Just(Torque::None),
        1 => (-1.0..1.0_f64).prop_map(Torque::Input),
        3 => kloss.prop_map(|(m, slip, direction, speed, lag)| Torque::Kloss([m, slip, direction * speed, lag])),
    ];
    (
        followers,
        decades(-3.0, 3.0),
        torque,
        prop_oneof![Just(0.0), -1.0..1.0_f64],
        -1e3..1e3_f64,
        decades(-4.0, 3.0),
        sign(),
        0.1..1.0_f64,
    )
        .prop_map(|(followers, ratio, torque, load, phi_start, w, sign, share)| {
            let followers: Vec<Follower> =
                followers.into_iter().map(|(m, law, stroke)| Follower::new(m, times(&law, stroke))).collect();
            let of_masses: f64 = followers.iter().map(|f| f.m * (f.cam.bound(1) / 2.0).powi(2)).sum();
            let j0 = of_masses * ratio;
            // Torques by what they do to the machine in a turn.
            let scale = (j0 + of_masses) * w * w;
            let torque = match torque {
                Torque::Kloss([m, slip, speed, lag]) => Torque::Kloss([m * scale, slip, speed * w, lag / w]),
                Torque::Input(m) => Torque::Input(0.1 * m * scale),
                Torque::None => Torque::None,
            };
            MachineScene {
                start: Start::Given,
                j0,
                varying: None,
                followers,
                torque,
                torque_start: 0.0,
                load: 0.1 * load * scale,
                phi_start,
                w_start: sign * w,
                span: share * 3.0 * TAU / w,
            }
        })
}
