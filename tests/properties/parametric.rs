//! What a parametric drive owes for any coefficients, and for any crank.

use super::relations::{self, Accuracy};
use super::run::Run;
use super::scenes::{Start, decades, geared_series, sign};
use super::{
    CAM_STATE, admitted, agree, config, equal, even, restoring, restoring_on_inputs, splits, trace, with_finer_panels,
    work,
};
use camdrive::drives::Fault;
use camdrive::motion::Fourier;
use proptest::prelude::*;
use serde_json::{Value, json};
use std::f64::consts::{PI, TAU};

/// m(φ), b(φ), c(φ), f(φ) as series, or a crank with J, b_T and a load.
#[derive(Clone, Debug)]
pub enum Law {
    Series([Fourier; 4]),
    Crank { inertia: f64, damping: f64, c_t1: f64, c_t2: f64, c_ab: f64, r: f64, second: Value, load: Fourier },
}

/// At constant speed.
#[derive(Clone, Debug)]
pub struct Scene {
    pub law: Law,
    start: Start,
    pub w: f64,
    pub phi_start: f64,
    q: f64,
    q_dot: f64,
    span: f64,
}

/// The series at −φ.
fn backwards(series: &Fourier) -> Fourier {
    Fourier::new(series.a.clone(), series.b.iter().map(|b| -b).collect())
}

impl Scene {
    fn resolved(&self) -> (&'static str, Value) {
        let law = match &self.law {
            Law::Series([m, b, c, f]) => {
                json!({"series": {"coordinate": "translation", "m": m, "b": b, "c": c, "f": f}})
            }
            Law::Crank { inertia, damping, c_t1, c_t2, c_ab, r, second, load } => json!({"crank": {
                "crank": {"c_t1": c_t1, "c_t2": c_t2, "c_ab": c_ab, "r": r, "second": second},
                "inertia": inertia, "damping": damping, "load": load, "harmonics": null,
            }}),
        };
        let scene = json!({
            "law": law,
            "drive": {"constant": {"w": self.w, "phi_start": self.phi_start}},
            "start": self.start.resolved(self.q, self.q_dot),
            "solver": {"tolerance": 0.0, "method": "adaptive", "step_size": 0.0},
        });
        ("ParametricDrive", scene)
    }

    fn run(&self) -> Result<Run, Fault> {
        Run::new(self.resolved(), &[])
    }

    /// The inputs at `t` of a drive that changes its speed by this part over the span.
    fn turning(&self, change: f64, t: f64) -> [(&'static str, f64); 3] {
        let a = change * self.w / self.span;
        [("phi", self.phi_start + (self.w + a * t / 2.0) * t), ("w", self.w + a * t), ("a", a)]
    }

    /// On such inputs.
    fn run_on_inputs(&self, change: f64) -> Result<Run, Fault> {
        let (model, mut resolved) = self.resolved();
        resolved["drive"] = json!("input");
        Run::new((model, resolved), &self.turning(change, 0.0))
    }

    /// The states after the span on inputs, reached over `shares` of it, and the largest of each on the way.
    fn states_on_inputs(&self, change: f64, shares: &[f64]) -> Result<(Vec<f64>, Vec<f64>), Fault> {
        let mut run = self.run_on_inputs(change)?;
        let mut largest = run.all(CAM_STATE).map(f64::abs);
        for share in shares.iter().chain(&[1.0]) {
            run.set(&self.turning(change, run.time))?;
            run.to(self.span * share)?;
            let now = run.all(CAM_STATE);
            largest = [0, 1].map(|i| largest[i].max(now[i].abs()));
        }
        Ok((run.all(CAM_STATE).to_vec(), largest.to_vec()))
    }

    fn states(&self, shares: &[f64]) -> Result<(Vec<f64>, Vec<f64>), Fault> {
        trace(self.run()?, &CAM_STATE, self.span, shares)
    }

    /// A change that shows how sensitive the scene is.
    fn perturbed(&self) -> Scene {
        self.with(|law| match law {
            Law::Series([_, _, c, _]) => *c = c.scaled(1.0 + 1e-10),
            Law::Crank { inertia, .. } => *inertia *= 1.0 - 1e-10,
        })
    }

    fn with(&self, change: impl FnOnce(&mut Law)) -> Scene {
        let mut other = self.clone();
        change(&mut other.law);
        other
    }

    /// t → λt: speeds divided by λ, damping by λ, stiffness and load by λ².
    fn slower(&self, factor: f64) -> Scene {
        let square = factor * factor;
        let law = self.with(|law| match law {
            Law::Series([_, b, c, f]) => {
                (*b, *c, *f) = (b.scaled(1.0 / factor), c.scaled(1.0 / square), f.scaled(1.0 / square));
            }
            Law::Crank { damping, c_t1, c_t2, c_ab, load, .. } => {
                *damping /= factor;
                (*c_t1, *c_t2, *c_ab, *load) =
                    (*c_t1 / square, *c_t2 / square, *c_ab / square, load.scaled(1.0 / square));
            }
        });
        Scene { w: self.w / factor, q_dot: self.q_dot / factor, span: self.span * factor, ..law }
    }

    /// φ → −φ: the coefficients read backwards at the reversed speed; the load of a crank, whose q turns with φ, changes
    /// its sign with q.
    pub fn reversed(&self) -> Scene {
        let mut sign = 1.0;
        let law = self.with(|law| match law {
            Law::Series(list) => list.iter_mut().for_each(|series| *series = backwards(series)),
            Law::Crank { second, load, .. } => {
                sign = -1.0;
                *load = backwards(load).scaled(-1.0);
                for kind in ["own_shafts", "shared_shafts"] {
                    if let Some(angle) = second.get(kind).and_then(Value::as_f64) {
                        // The crank that ran ahead follows.
                        *second = json!({kind: -angle});
                    }
                }
            }
        });
        Scene { w: -self.w, phi_start: -self.phi_start, q: sign * self.q, q_dot: sign * self.q_dot, ..law }
    }

    /// The load and the start with the other sign.
    fn mirrored(&self) -> Scene {
        let law = self.with(|law| match law {
            Law::Series([_, _, _, f]) => *f = f.scaled(-1.0),
            Law::Crank { load, .. } => *load = load.scaled(-1.0),
        });
        Scene { q: -self.q, q_dot: -self.q_dot, ..law }
    }

    fn sign_of_reversal(&self) -> f64 {
        if matches!(self.law, Law::Crank { .. }) { -1.0 } else { 1.0 }
    }
}

impl relations::Scene for Scene {
    fn resolved(&self) -> (&'static str, Value) {
        self.resolved()
    }

    fn span(&self) -> f64 {
        self.span
    }

    fn accuracy(&self) -> Accuracy {
        Accuracy::INTEGRATED
    }

    fn start(&mut self) -> &mut Start {
        &mut self.start
    }

    fn phi_start(&mut self) -> &mut f64 {
        &mut self.phi_start
    }

    fn perturbed(&self) -> Self {
        self.perturbed()
    }

    /// The dead centres of a crank are where they are, half a turn apart; a second one may become the first.
    fn turned(&self, angle: f64) -> (Self, f64) {
        let mut by = angle;
        let law = self.with(|law| match law {
            Law::Series(list) => list.iter_mut().for_each(|series| *series = series.delayed(by)),
            Law::Crank { second, load, .. } => {
                by = PI * (angle / PI).round();
                for kind in ["own_shafts", "shared_shafts"] {
                    if let Some(ahead) = second.get(kind).and_then(Value::as_f64) {
                        by += ahead;
                        *second = json!({kind: -ahead});
                    }
                }
                *load = load.delayed(by);
            }
        });
        (Scene { phi_start: self.phi_start + by, ..law }, by)
    }

    fn reversed(&self) -> Self {
        self.reversed()
    }

    fn geared(&self, k: usize) -> Self {
        let law = self.with(|law| match law {
            Law::Series(list) => list.iter_mut().for_each(|series| *series = geared_series(series, k)),
            Law::Crank { .. } => unreachable!("c_T of a crank has two dips in a turn"),
        });
        let times = k as f64;
        Scene { w: self.w / times, phi_start: self.phi_start / times, ..law }
    }

    fn continued(&self, run: &mut Run) -> Option<Self> {
        let [phi_start, q, q_dot] = run.all(["phi", "q", "der(q)"]);
        Some(Scene { start: Start::Given, phi_start, q, q_dot, ..self.clone() })
    }

    fn period(&self, _: &mut Run) -> f64 {
        TAU / self.w.abs()
    }

    fn terms(&self, of: &dyn Fn(&str) -> f64) -> Vec<(String, f64)> {
        let (q, v) = (of("q"), of("der(q)"));
        let [m, b, c, f] = match &self.law {
            Law::Series(list) => [list[0].a[0], list[1].bound(0), list[2].bound(0), list[3].bound(0)],
            Law::Crank { inertia, damping, c_t1, load, .. } => [*inertia, *damping, 2.0 * c_t1, load.bound(0)],
        };
        let force = c * q + b * v;
        // m may be a tenth of its mean.
        let acceleration = (force + f) * 10.0 / m;
        let terms = [
            ("tau", force),
            ("force", force),
            ("der(q,2)", acceleration),
            ("der(psi,2)", acceleration),
            ("tau_parametric", c * q * q + m * v * v),
        ];
        terms.map(|(name, size)| (name.to_owned(), size)).into()
    }
}

/// A series with this mean whose harmonics have at most the part `most` of it together.
fn series(mean: f64, most: f64) -> impl Strategy<Value = Fourier> {
    prop::collection::vec((-1.0..1.0_f64, -1.0..1.0_f64), 0..6).prop_map(move |pairs| {
        let size = |k: usize| 0.3 * most * mean / ((k + 1) * (k + 1)) as f64;
        let of = |first: f64, pick: fn(&(f64, f64)) -> f64| {
            std::iter::once(first).chain(pairs.iter().enumerate().map(move |(k, p)| pick(p) * size(k))).collect()
        };
        Fourier::new(of(mean, |p| p.0), of(0.0, |p| p.1))
    })
}

/// How a drive is moved.
#[derive(Clone, Copy, Debug)]
struct Course {
    /// w/ω₀.
    eta: f64,
    sign: f64,
    phi_start: f64,
    start: [f64; 2],
    /// The share of the span.
    share: f64,
}

fn common() -> impl Strategy<Value = Course> {
    (decades(-1.5, 1.0), sign(), -1e3..1e3_f64, [-1.0..1.0_f64, -1.0..1.0_f64], 0.1..1.0_f64)
        .prop_map(|(eta, sign, phi_start, start, share)| Course { eta, sign, phi_start, start, share })
}

fn damping_ratio() -> impl Strategy<Value = f64> {
    prop_oneof![1 => Just(0.0), 4 => decades(-4.0, 1.0)]
}

fn finish(law: Law, natural: f64, course: Course) -> Scene {
    let Course { eta, sign, phi_start, start, share } = course;
    let w = sign * eta * natural;
    let span = share * (10.0 * TAU / w.abs()).min(60.0 * TAU / natural);
    Scene { law, start: Start::Given, w, phi_start, q: 0.1 * start[0], q_dot: 0.1 * start[1] * natural, span }
}

pub fn of_series() -> impl Strategy<Value = Scene> {
    (decades(-3.0, 3.0), decades(-1.0, 3.0), damping_ratio(), common()).prop_flat_map(|(m, natural, ratio, common)| {
        let (b, c) = (2.0 * ratio * m * natural, m * natural * natural);
        let load = prop_oneof![Just(constant(0.0)), series(0.05 * c, 2.0)];
        (series(m, 0.9), series(b, 1.0), series(c, 3.0), load)
            .prop_map(move |(m, b, c, f)| finish(Law::Series([m, b, c, f]), natural, common))
    })
}

fn constant(value: f64) -> Fourier {
    Fourier::new(vec![value], Vec::new())
}

pub fn of_crank() -> impl Strategy<Value = Scene> {
    let second = prop_oneof![
        2 => Just(json!("none")),
        1 => (-3.0..3.0_f64).prop_map(|angle| json!({"own_shafts": angle})),
        1 => (-3.0..3.0_f64).prop_map(|angle| json!({"shared_shafts": angle})),
    ];
    (decades(-3.0, 3.0), decades(-1.0, 3.0), damping_ratio(), decades(-4.0, 2.0), decades(-1.0, 1.0), second, common())
        .prop_flat_map(|(inertia, natural, ratio, sigma, share, second, common)| {
            let shafts = inertia * natural * natural;
            let law = Law::Crank {
                inertia,
                damping: 2.0 * ratio * inertia * natural,
                c_t1: shafts * (1.0 + share),
                c_t2: shafts * (1.0 + 1.0 / share),
                c_ab: shafts / (sigma * 0.09),
                r: 0.3,
                second,
                load: constant(0.0),
            };
            prop_oneof![Just(constant(0.0)), series(0.05 * shafts, 2.0)].prop_map(move |f| {
                let scene = finish(law.clone(), natural, common);
                scene.with(|law| {
                    if let Law::Crank { load, .. } = law {
                        *load = f;
                    }
                })
            })
        })
}

pub fn drive() -> impl Strategy<Value = Scene> {
    prop_oneof![of_series(), of_crank()]
}

/// d/dt (m q̇²/2 + c q²/2) = f q̇ − b q̇² + ω tau_parametric of series; of the crank, with ψ̇ for q̇ on the left and at f,
/// also + ω tau.
fn balance(scene: &Scene, count: usize) -> Result<(), TestCaseError> {
    let mut run = admitted(scene.run())?;
    let (w, phi_start) = (scene.w, scene.phi_start);
    let at = |series: &Fourier, time: f64| series.at((phi_start + w * time) % TAU).0[0];
    let energy = |run: &mut Run| {
        let [q, v, c] = run.all(["q", "der(q)", "stiffness"]);
        let (m, speed) = match &scene.law {
            Law::Series([m, ..]) => (at(m, run.time), v),
            Law::Crank { inertia, .. } => (*inertia, run.get("der(psi)")),
        };
        (m * speed * speed + c * q * q) / 2.0
    };
    let start = energy(&mut run);
    let [given, total] = admitted(work(&mut run, &equal(scene.span, count), |run| {
        let [v, second] = run.all(["der(q)", "tau_parametric"]);
        match &scene.law {
            Law::Series([_, b, _, f]) => at(f, run.time) * v - at(b, run.time) * v * v + second * w,
            Law::Crank { damping, load, .. } => {
                let [tau, speed] = run.all(["tau", "der(psi)"]);
                at(load, run.time) * speed - damping * v * v + (tau + second) * w
            }
        }
    }))?;
    let end = energy(&mut run);
    let scale = total + start.abs() + end.abs();
    prop_assert!((end - start - given).abs() <= 1e-7 * scale, "energy {:e} of {scale:e}", end - start - given);
    Ok(())
}

proptest! {
    #![proptest_config(config(80, 40, 11))]

    #[test]
    fn one_step_or_many(scene in drive(), shares in splits()) {
        let (even, largest) = admitted(scene.states(&even()))?;
        let (perturbed, _) = admitted(scene.perturbed().states(&[]))?;
        agree(&admitted(scene.states(&[]))?.0, &even, &largest, &perturbed)?;
        agree(&admitted(scene.states(&shares))?.0, &even, &largest, &perturbed)?;
    }

    #[test]
    fn mirror_images(scene in drive()) {
        let (expected, largest) = admitted(scene.states(&even()))?;
        let (perturbed, _) = admitted(scene.perturbed().states(&[]))?;
        let (mut mirrored, _) = admitted(scene.mirrored().states(&[]))?;
        mirrored.iter_mut().for_each(|v| *v *= -1.0);
        agree(&mirrored, &expected, &largest, &perturbed)?;
        // Growth knows neither sense nor sign.
        let growth = |scene: &Scene| admitted(scene.run()).map(|mut run| run.get("growth"));
        let (own, other) = (growth(&scene)?, growth(&scene.reversed())?);
        prop_assert!((own - other).abs() <= 1e-6 * (1.0 + own.abs()), "{own} {other}");
    }

    #[test]
    fn restored_at_any_instant(scene in drive(), shares in splits()) {
        restoring(admitted(scene.run())?, admitted(scene.run())?, scene.span, &shares)?;
    }

    #[test]
    fn on_inputs_in_one_step_or_many(scene in drive(), change in -3.0..3.0_f64, shares in splits()) {
        let (even, largest) = admitted(scene.states_on_inputs(change, &even()))?;
        let (perturbed, _) = admitted(scene.perturbed().states_on_inputs(change, &[]))?;
        agree(&admitted(scene.states_on_inputs(change, &[]))?.0, &even, &largest, &perturbed)?;
        agree(&admitted(scene.states_on_inputs(change, &shares))?.0, &even, &largest, &perturbed)?;
    }

    #[test]
    fn on_inputs_slower_and_mirrored(
        scene in drive(), change in -3.0..3.0_f64, factor in (-3.0..3.0_f64).prop_map(f64::exp)
    ) {
        let (expected, largest) = admitted(scene.states_on_inputs(change, &even()))?;
        let (perturbed, _) = admitted(scene.perturbed().states_on_inputs(change, &[]))?;
        let (mut slow, _) = admitted(scene.slower(factor).states_on_inputs(change, &[]))?;
        slow[1] *= factor;
        agree(&slow, &expected, &largest, &perturbed)?;
        let (mut reversed, _) = admitted(scene.reversed().states_on_inputs(change, &[]))?;
        reversed.iter_mut().for_each(|v| *v *= scene.sign_of_reversal());
        agree(&reversed, &expected, &largest, &perturbed)?;
    }

    #[test]
    fn on_inputs_without_acceleration(scene in drive(), shares in splits()) {
        let (expected, largest) = admitted(scene.states(&even()))?;
        let (perturbed, _) = admitted(scene.perturbed().states(&[]))?;
        agree(&admitted(scene.states_on_inputs(0.0, &shares))?.0, &expected, &largest, &perturbed)?;
    }

    #[test]
    fn on_inputs_restored_at_any_instant(scene in drive(), change in -3.0..3.0_f64, shares in splits()) {
        let run = || admitted(scene.run_on_inputs(change));
        let set = |run: &mut Run| run.set(&scene.turning(change, run.time));
        restoring_on_inputs(run()?, run()?, scene.span, &shares, set)?;
    }

    #[test]
    fn energy_balances(scene in drive()) {
        // Strong damping decays within a short time, and a stiff rod makes narrow dips.
        let rate = scene.q_dot.abs() / scene.q.abs().max(1e-3);
        let fastest = match &scene.law {
            Law::Series([m, b, c, _]) => (c.bound(0) / m.a[0] * 10.0).sqrt() + 10.0 * b.bound(0) / m.a[0],
            Law::Crank { inertia, damping, c_t1, c_ab, r, .. } => {
                (c_t1 / inertia).sqrt() + damping / inertia + 10.0 * scene.w.abs() * (c_ab * r * r / c_t1).sqrt()
            }
        };
        let count = ((fastest + 12.0 * scene.w.abs() + rate.min(1e3)) * scene.span / 2.0).ceil();
        prop_assume!(count < 3000.0);
        with_finer_panels(count as usize + 1, |count| balance(&scene, count))?;
    }
}
