//! The drive with backlash against closed formulas, balances and symmetries.

use super::{BacklashDrive, Parameters, Scene};
use crate::drives::follower::contact::{Beginning, Bodies, Flank, Mode, Phase, State};
use crate::drives::follower::flank::FlankMotion;
use crate::drives::settings::Settings;
use crate::drives::shaft::cam_drive::{DriveMode, Start, StartMode};
use crate::drives::solver::contact::series::MOST_TERMS;
use crate::drives::solver::contact::{Run, Stretch};
use crate::drives::{About, Drive, Event, EventLog};
use crate::motion::{Fourier, Kinematics, MotionLaw};
use crate::numerics::double_double::Double;
use crate::numerics::work::Work;

/// Passages of the cubic model, as (μ, K, τ₁, τ*): τ₁ = ω times the time of passage, the root of (15), τ₁³ + 6/(μ+1) (τ₁ − a sin θ)
/// = 6K with a² = μ/(μ+1), θ = τ₁/a; and τ* after the impact, when the contact ends again: the first zero of f (25), if any.
/// Computed with forty digits.
const PASSAGES: [(f64, f64, f64, Option<f64>); 36] = [
    (0.02, 0.01, 0.10657099344055047, None),
    (0.02, 0.3, 0.3671329917156978, None),
    (0.02, 1.0, 0.9346226281613457, None),
    (0.02, 3.4, 2.0705252963430465, None),
    (0.02, 15.0, 4.0374348756521385, None),
    (0.02, 106.0, 8.371440685731214, Some(3.726670646515667)),
    (0.02, 1060.0, 18.42145838669667, Some(3.3807162778371103)),
    (0.149, 0.01, 0.1990348165903831, None),
    (0.149, 0.3, 0.6448053278166133, None),
    (0.149, 1.0, 1.0337784157497987, None),
    (0.149, 3.4, 2.0524443334498326, None),
    (0.149, 15.0, 4.061271476809319, None),
    (0.149, 106.0, 8.389001858080462, Some(3.78393705360152)),
    (0.149, 1060.0, 18.43511526905252, Some(3.395368785850852)),
    (0.3, 0.01, 0.24090268843272253, None),
    (0.3, 0.3, 0.7708610918929906, None),
    (0.3, 1.0, 1.2050550437708225, None),
    (0.3, 2.0, 1.606092567366701, None),
    (0.3, 3.4, 2.066740338398994, None),
    (0.3, 15.0, 4.165741981950248, None),
    (0.3, 106.0, 8.410934028045105, Some(3.843081264113874)),
    (0.3, 1060.0, 18.445950657049014, Some(3.414763697993852)),
    (1.0, 0.01, 0.3112241672903191, None),
    (1.0, 0.3, 0.98074670035259, None),
    (1.0, 1.0, 1.4940520958245347, None),
    (1.0, 3.4, 2.3494923586920904, None),
    (1.0, 15.0, 4.248394873218266, None),
    (1.0, 106.0, 8.478187641973644, Some(4.13573973242022)),
    (1.0, 1060.0, 18.475354202580355, Some(3.5055478717072472)),
    (3.0, 0.01, 0.355939027194419, None),
    (3.0, 0.3, 1.1126165428522132, None),
    (3.0, 1.0, 1.6752214575694233, None),
    (3.0, 3.4, 2.5609915566096815, None),
    (3.0, 15.0, 4.348706231772144, None),
    (3.0, 106.0, 8.539120617726361, None),
    (3.0, 1060.0, 18.501349604472043, Some(3.796804523247572)),
];

/// A passage of [`PASSAGES`].
struct Passage {
    mu: f64,
    tau: f64,
    a: f64,
    theta: f64,
}

impl Passage {
    fn new(mu: f64, tau: f64) -> Self {
        let a = (mu / (mu + 1.0)).sqrt();
        Passage { mu, tau, a, theta: tau / a }
    }
    /// Z = ½τ₁² + (1 − cos θ)/(μ+1) (18).
    fn jump(&self) -> f64 {
        0.5 * self.tau * self.tau + (1.0 - self.theta.cos()) / (self.mu + 1.0)
    }
    /// A sin τ* + B cos τ* (22), (23).
    fn vibrating(&self, tau: f64) -> f64 {
        let [sin, cos] = [self.theta.sin(), self.theta.cos()];
        (0.5 * self.tau * self.tau - self.a * self.a * (1.0 - cos)) * tau.sin() - (self.tau - self.a * sin) * tau.cos()
    }
    /// K q₂/s (21).
    fn elongation(&self, tau: f64) -> f64 {
        tau + self.tau + self.vibrating(tau)
    }
    /// f (25), (26).
    fn pressing(&self, tau: f64) -> f64 {
        (self.mu + 1.0) * (self.tau + tau) + self.vibrating(tau)
    }
}

/// u(t) = U̇₀ t + Ü₀ t²/2 + U⃛ t³/6, the cubic of the source around a zero of Ü.
struct CubicFlank {
    speed: f64,
    start: f64,
    jerk: f64,
}

impl FlankMotion for CubicFlank {
    fn at(&self, _: usize, time: Double) -> Kinematics {
        let t = time.hi;
        let (v, a, j) = (self.speed, self.start, self.jerk);
        Kinematics([v * t + a * t * t / 2.0 + j * t.powi(3) / 6.0, v + a * t + j * t * t / 2.0, a + j * t, j, 0.0])
    }
    fn slope(&self, segment: usize, time: Double) -> f64 {
        self.at(segment, time).0[1]
    }
    fn expand(&self, segment: usize, time: Double, span: f64, coefficients: &mut [f64]) {
        coefficients.fill(0.0);
        let mut factor = 1.0;
        for (n, (c, u)) in coefficients.iter_mut().zip(self.at(segment, time).0).enumerate() {
            *c = u * factor;
            factor *= span / (n + 1) as f64;
        }
    }
    fn describe(&self, _: [f64; 2]) -> String {
        String::new()
    }
    fn is_uniform(&self) -> bool {
        true
    }
    fn speed(&self) -> f64 {
        1.0
    }
    fn sizes(&self, _: f64) -> [f64; 2] {
        [1.0; 2]
    }
    fn acceleration(&self, _: usize, time: Double) -> f64 {
        self.start.abs() + self.jerk.abs() * time.hi.abs().max(1.0)
    }
    fn rate(&self, _: usize, _: Double) -> f64 {
        0.0
    }
    fn segment(&self, _: Double) -> usize {
        0
    }
    fn stay(&self, _: usize, _: Double, longest: f64) -> (f64, usize) {
        (longest, 0)
    }
}

/// Runs from `state` at t = 0 to `end` on a flank without segments; returns the events, too.
fn ran(bodies: &Bodies, flank: &CubicFlank, (state, zeros): (State, usize), end: f64) -> (Run, Vec<Event>) {
    let phase = Phase { mode: Mode::Free, state, zeros };
    let from = Beginning { start: Double::from(0.0), segment: 0, phase, longest: f64::INFINITY };
    let mut run = Run::new(bodies, flank, from, MOST_TERMS);
    let (mut log, mut work) = (EventLog::default(), Work::default());
    let mut stretch = Stretch { end, horizon: f64::INFINITY, log: &mut log, work: &mut work };
    run.advance(bodies, flank, &mut stretch).unwrap();
    (run, log.iter().copied().collect())
}

/// A passage of the cubic model with ω = 1 and m2 = 1, from the release at t = 0 with q₂ = 0, q̇₂ = −U⃛ (9), to `end`.
fn pass(mu: f64, k: f64, flank: Flank, end: f64) -> (Run, State, Bodies, Vec<Event>) {
    // K = |s| ω³/|U⃛|; on flank A the release has U⃛ < 0.
    let jerk = -flank.sign();
    let bodies = Bodies::new(&Parameters { m1: mu, m2: 1.0, c: 1.0, b: 0.0, s: k, e: 0.0 });
    let motion = CubicFlank { speed: 0.3, start: 0.0, jerk };
    let state = State { q: [0.0, -jerk], home: bodies.place(flank), zeta: [0.0; 2] };
    let (run, events) = ran(&bodies, &motion, (state, 3), end);
    let point = run.panel.at(&bodies, run.theta(end));
    (run, point.state, bodies, events)
}

#[test]
fn the_passage_of_the_cubic_model() {
    for (mu, k, tau, release) in PASSAGES {
        for flank in [Flank::A, Flank::B] {
            let exact = Passage::new(mu, tau);
            let (_, _, bodies, events) = pass(mu, k, flank, 7.0 + k.cbrt() * 2.0);
            let first = events[0];
            // (15) the time of passage, (18) the impulse −σ m1 |U⃛|/ω² Z.
            assert!((first.time - tau).abs() < 2e-14 * tau.max(1.0), "{mu} {k}: {first:?} {tau}");
            let impulse = -flank.sign() * bodies.m1 * exact.jump();
            assert!((first.value - impulse).abs() < 4e-14 * impulse.abs().max(0.1), "{mu} {k}: {first:?} {impulse}");
            assert_eq!(first.kind, if flank == Flank::A { "impact on flank B" } else { "impact on flank A" });
            let release_after = events.get(1).map(|e| e.time - first.time);
            match release {
                None => assert_eq!(release_after, None, "{mu} {k}"),
                Some(expected) => {
                    let tau = release_after.unwrap();
                    assert!(exact.pressing(tau).abs() < 1e-11 * k.max(1.0), "{mu} {k}: {tau}");
                    assert!(events[1].kind.starts_with("release") && (tau - expected).abs() < 1e-9, "{mu} {k}: {tau}");
                }
            }
        }
    }
}

#[test]
fn the_contact_after_the_passage_of_the_cubic_model() {
    for case in [(0.3, 2.0), (1.0, 15.0), (3.0, 106.0)] {
        let &(mu, k, tau, _) = PASSAGES.iter().find(|(mu, k, ..)| (*mu, *k) == case).unwrap();
        let exact = Passage::new(mu, tau);
        let (.., events) = pass(mu, k, Flank::A, 7.0 + k.cbrt() * 2.0);
        let impact = events[0].time;
        let (run, ..) = pass(mu, k, Flank::A, impact * (1.0 + 1e-15));
        assert_eq!(run.panel.mode(), Mode::Contact(Flank::B));
        // (20) at the impact, which lowers ẋ1 by Z.
        let [q, q_dot] = [exact.a * exact.theta.sin(), exact.theta.cos()];
        let begin = run.panel.from.phase.state.q;
        assert!((begin[0] - q).abs() < 1e-13 && (begin[1] - q_dot - exact.jump()).abs() < 1e-13 * exact.jump());
        let (_, state, bodies, _) = pass(mu, k, Flank::A, impact + 1.0);
        let time = Double::from(impact + 1.0);
        let motion = CubicFlank { speed: 0.3, start: 0.0, jerk: -1.0 };
        let tau = time.hi - events[0].time;
        // (21) and (25), (26) with c = ω = 1, s = K.
        assert!((state.q[0] / k - exact.elongation(tau) / k).abs() < 1e-13);
        let [force, ..] = bodies.force(state.q, &motion.at(0, time));
        assert!((force / k + exact.pressing(tau) / k).abs() < 1e-13);
    }
}

/// The profile of section 1.5 of the comparison: five harmonics, 20 mm.
fn profile() -> MotionLaw {
    MotionLaw::Fourier(Fourier::new(
        vec![0.0, -0.010, 0.0012, 0.0005, -0.0002],
        vec![0.0, 0.0, 0.0008, -0.0003, 0.0, 0.0001],
    ))
}

fn scene(w: f64, s: f64, b: f64, e: f64) -> Scene {
    // ω = 500 rad/s, μ = 0.25.
    Scene {
        coupling: false,
        parameters: Parameters { m1: 0.5, m2: 2.0, c: 5e5, b, s, e },
        cam: profile(),
        drive: DriveMode::Constant { w, phi_start: 0.0 },
        start: Start { mode: StartMode::AtRest, q: 0.0, q_dot: 0.0 },
        solver: Settings::default(),
    }
}

fn started(scene: Scene) -> BacklashDrive {
    let mut drive = BacklashDrive::new(scene).unwrap();
    drive.start(0.0).unwrap();
    drive
}

fn energy(d: &BacklashDrive) -> f64 {
    let ([_, x], v) = (d.now.point.place(), d.now.point.state.q);
    0.5 * d.parameters.m1 * x * x + 0.5 * d.parameters.m2 * (x + v[1]).powi(2) + 0.5 * d.parameters.c * v[0] * v[0]
}

fn momentum(d: &BacklashDrive) -> f64 {
    let ([_, x], q) = (d.now.point.place(), d.now.point.state.q);
    d.parameters.m1 * x + d.parameters.m2 * (x + q[1])
}

#[test]
fn momentum_and_energy_balance_over_many_turns() {
    for e in [0.0, 0.5, 0.9, 1.0] {
        for b in [0.0, 60.0, 1e6, 1e9] {
            let w = 50.0;
            let mut drive = started(scene(w, 3e-4, b, e));
            let (p0, e0) = (momentum(&drive), energy(&drive));
            let (mut impulse, mut work) = (0.0, 0.0);
            let (mut largest_momentum, mut largest_energy) = (0.0f64, e0.abs());
            let h = 1.3e-3;
            for step in 0..2000 {
                drive.advance(f64::from(step) * h, h).unwrap();
                impulse += drive.mean()[0] * h;
                // U̇ = U′w.
                work += drive.mean()[1] * w * h;
                largest_momentum = largest_momentum.max(momentum(&drive).abs());
                largest_energy = largest_energy.max(energy(&drive));
                let State { home, zeta, .. } = drive.now.point.state;
                let z = home + zeta[0];
                assert!((0.0..=drive.parameters.s).contains(&z), "z = {z}");
            }
            let momentum_error = (momentum(&drive) - p0 - impulse).abs() / largest_momentum;
            let losses = drive.now.tally.energy_loss + drive.damping_loss();
            let energy_error = (energy(&drive) - e0 - work + losses).abs() / largest_energy.max(losses);
            assert!(momentum_error < 1e-10, "e = {e}, b = {b}: momentum {momentum_error:e}");
            assert!(energy_error < 1e-10, "e = {e}, b = {b}: energy {energy_error:e}");
            assert!(drive.now.tally.impacts > 30.0, "{}", drive.now.tally.impacts);
            assert!(e < 1.0 || drive.now.tally.energy_loss == 0.0);
        }
    }
}

mod estimate;
mod interface;
mod jump;
mod reference;
mod switching;
