//! One passage of the clearance, by the closed formulas and by the event-driven model.
//!
//! The model is followed from the periodic motion of permanent contact. Release, passage and impact then belong to a machine in
//! which the vibration of earlier impacts has died out, as the formulas assume. The model also contains what the formulas leave
//! out: the higher derivatives of U, damping and restitution.

use super::borders::{self, Sequel};
use super::contact_motion::{ContactMotion, Release, Sample};
use super::law::Crossing;
use super::machine::{Machine, Moment};
use crate::formulas::passage::Passage;
use crate::search::greatest;
use camdrive::drives::Fault;
use camdrive::drives::backlash::{Parameters, Scene};
use serde::Serialize;
use std::f64::consts::TAU;

/// The figures of a passage, by the formulas or by the model.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Figures {
    /// φ of the release (rad).
    pub release: f64,
    /// Time of passage (s).
    pub time: f64,
    /// Dimensionless time of passage τ₁ = ω t₁.
    pub tau: f64,
    /// Angle of passage (rad).
    pub angle: f64,
    /// Impulse of the impact (N·s), without its sign.
    pub impulse: f64,
    /// Energy lost in it (J).
    pub loss: f64,
    /// Amplitude of the vibration about the motion of permanent contact after it (m).
    pub vibration: f64,
    /// Largest |q| in the first natural period after it, as long as contact lasts (m).
    pub elongation: Option<f64>,
    /// Largest pressing force there (N).
    pub force: Option<f64>,
    /// Sequel of the impact.
    pub sequel: Sequel,
    /// When contact ends again, τ* = ω (t − t₁).
    pub release_after: Option<f64>,
}

/// A passage.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Clearance {
    /// The zero of U″; None if only the exact contact force has one.
    pub crossing: Option<Crossing>,
    /// The flank that m1 leaves.
    pub from: char,
    /// K, (16).
    pub k: Option<f64>,
    /// By the closed formulas.
    pub formula: Option<Figures>,
    /// By the event-driven model.
    pub model: Option<Figures>,
    /// The reason why a part is missing.
    pub fault: Option<String>,
    /// Expected error of (3): η²|U⁽⁵⁾/U‴|.
    pub quasi_static: Option<f64>,
    /// Expected error of (13): Δφ |U⁗/(4U‴)|.
    pub truncation: Option<f64>,
    /// The angle from this release to the next one (rad).
    pub spacing: f64,
    /// Remainder of the vibration there: exp(−δ Δt).
    pub left: f64,
    /// The natural period after the impact.
    #[serde(skip)]
    pub course: Vec<VibrationPoint>,
}

/// A point of the period after the impact; q and the force are positive if the flank presses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VibrationPoint {
    /// τ*.
    pub tau: f64,
    /// q/s by the formula and by the model.
    pub q: [Option<f64>; 2],
    /// Force/(c s) by the formula and by the model.
    pub force: [Option<f64>; 2],
}

/// Points of the period after the impact: largest values of the model err by at most (π/400)²/2 = 3e-5 of the vibration.
const POINTS: usize = 400;

impl Figures {
    /// By (10)–(26), for the passage at `crossing`.
    pub fn by_formula(passage: &Passage, crossing: &Crossing, scene: &Scene, w: f64) -> Self {
        let omega = (scene.parameters.c / scene.parameters.m2).sqrt();
        let eta = w.abs() / omega;
        // Ω²η|U‴| Z ω⁻¹: (18).
        let jump = crossing.jerk.abs() * eta * eta * w.abs() * passage.jump();
        let sequel = borders::sequel(passage);
        let release_after = borders::release(passage);
        let until = release_after.unwrap_or(TAU);
        let largest = |value: &dyn Fn(f64) -> f64| {
            (until > 0.0).then(|| greatest(&[[0.0, until]], |_, tau| value(tau).abs()).value)
        };
        Figures {
            release: crossing.phi,
            time: passage.tau / omega,
            tau: passage.tau,
            angle: eta * passage.tau,
            impulse: scene.parameters.m1 * jump,
            loss: 0.5 * scene.parameters.m1 * jump * jump,
            vibration: scene.parameters.s * passage.vibration(),
            elongation: largest(&|tau| scene.parameters.s * passage.elongation(tau)),
            force: largest(&|tau| scene.parameters.c * scene.parameters.s / passage.k * passage.pressing(tau)),
            sequel,
            release_after,
        }
    }

    /// The period after the impact by (21) and (25).
    pub fn course(passage: &Passage) -> Vec<VibrationPoint> {
        let point = |tau: f64| VibrationPoint {
            tau,
            q: [Some(passage.elongation(tau)), None],
            force: [Some(passage.pressing(tau) / passage.k), None],
        };
        (0..=POINTS).map(|i| point(TAU * i as f64 / POINTS as f64)).collect()
    }
}

/// The machine to be followed, with its periodic motion.
pub struct Bench<'a> {
    /// The model.
    pub machine: &'a mut Machine,
    /// Permanent contact.
    pub motion: &'a ContactMotion,
    /// The parameters.
    pub scene: &'a Scene,
    /// U.
    pub slope: &'a dyn Fn(f64) -> f64,
}

/// The release and the impact that ends the passage.
struct Flight {
    release: f64,
    impact: f64,
    impulse: f64,
    returned: bool,
}

impl Bench<'_> {
    /// Follows the passage that begins with `release`; `next`: the time until the release after it (s); `scale`: a guess
    /// of the time of passage (s).
    pub fn follow(
        &mut self,
        release: &Release,
        next: f64,
        scale: f64,
    ) -> Result<(Figures, Vec<VibrationPoint>), Fault> {
        let turn = self.machine.turn();
        let lead = (release.time - release.before.time).rem_euclid(turn);
        let flight = self.flight(release, lead, scale)?;
        let omega = (self.scene.parameters.c / self.scene.parameters.m2).sqrt();
        let Flight { release: released, impact, impulse, returned } = flight;
        // Right after the impact, before anything else has changed.
        self.machine.begin(self.start(release), Some(release.before.q), false)?;
        self.machine.go(impact * (1.0 - 1e-12))?;
        let before = self.machine.moment()?;
        let instant = impact + 1e-9 / self.fastest();
        self.machine.go(instant)?;
        let after = self.machine.moment()?;
        let contact = self.motion.at(self.machine, release.before.time + instant)?;
        let mut figures = Figures {
            release: self.angle(release, released),
            time: impact - released,
            tau: omega * (impact - released),
            angle: self.machine.w.abs() * (impact - released),
            impulse: impulse.abs(),
            loss: after.loss - before.loss,
            vibration: self.vibration(release, &after, instant, &contact),
            elongation: None,
            force: None,
            sequel: match after.contact {
                _ if returned => Sequel::Return,
                0 if self.scene.parameters.e > 0.0 => Sequel::Rebound,
                0 => Sequel::Immediate,
                _ => Sequel::None,
            },
            release_after: (after.contact == 0).then_some(0.0),
        };
        let window = (next - (impact - lead)).min(TAU / omega);
        let points = self.course(release, impact, window, &mut figures)?;
        Ok((figures, points))
    }

    fn start(&self, release: &Release) -> f64 {
        self.machine.w * release.before.time
    }

    fn angle(&self, release: &Release, time: f64) -> f64 {
        (self.start(release) + self.machine.w * time).rem_euclid(TAU)
    }

    /// The fastest rate at which anything changes (rad/s).
    fn fastest(&self) -> f64 {
        let Parameters { m1, m2, c, .. } = self.scene.parameters;
        (c * (1.0 / m1 + 1.0 / m2)).sqrt() + self.scene.cam.resolution() * self.machine.w.abs()
    }

    /// Follows the motion up to the first impact after the release, a turn at most.
    fn flight(&mut self, release: &Release, lead: f64, scale: f64) -> Result<Flight, Fault> {
        self.machine.begin(self.start(release), Some(release.before.q), false)?;
        let end = lead + self.machine.turn();
        let (mut time, mut step) = (lead * (1.0 - 1e-9), 0.125 * scale.min(self.machine.turn()));
        let mut left: Option<(f64, &str)> = None;
        while time < end {
            for event in self.machine.go(time)? {
                let flank = event.kind.rsplit(' ').next().unwrap_or_default();
                match left {
                    None if event.kind.starts_with("release") => left = Some((event.time, flank)),
                    Some((release, of)) if event.kind.starts_with("impact") => {
                        let (impact, impulse) = (event.time, event.value);
                        return Ok(Flight { release, impact, impulse, returned: of == flank });
                    }
                    _ => {}
                }
            }
            // Ever longer steps: a passage may last much longer than the formula says.
            time = (time + step).min(end);
            step *= 1.05;
            if time >= end {
                break;
            }
        }
        Err(Fault::new("m1 does not reach the other flank within a turn"))
    }

    /// The amplitude of q `time` (s) after a release, about the motion of permanent contact there. If m1 has left the flank
    /// again, q̇ is the velocity of m2 against the flank.
    fn vibration(&self, release: &Release, now: &Moment, time: f64, motion: &Sample) -> f64 {
        let Moment { q, contact, far_speed, .. } = *now;
        let omega = (self.scene.parameters.c / self.scene.parameters.m2).sqrt();
        let flank = (self.slope)(self.angle(release, time)) * self.machine.w;
        let rate = if contact == 0 { far_speed - flank } else { q[1] };
        let [place, speed] = [q[0] - motion.q[0], (rate - motion.q[1]) / omega];
        (place * place + speed * speed).sqrt()
    }

    /// The natural period after the impact; fills in the largest values and the end of contact within `window` (s).
    fn course(
        &mut self,
        release: &Release,
        impact: f64,
        window: f64,
        figures: &mut Figures,
    ) -> Result<Vec<VibrationPoint>, Fault> {
        let Parameters { c, s, m2, .. } = self.scene.parameters;
        let omega = (c / m2).sqrt();
        // Pressing is positive: against flank B after a release from A.
        let sign = if release.falling { 1.0 } else { -1.0 };
        self.machine.begin(self.start(release), Some(release.before.q), false)?;
        self.machine.go(impact)?;
        let mut points = Vec::with_capacity(POINTS + 1);
        let settled = figures.sequel == Sequel::None;
        let mut largest = [0.0f64; 2];
        for i in 0..=POINTS {
            let tau = TAU * i as f64 / POINTS as f64;
            // The first point lies right after the impact.
            let time = impact + (tau / omega).max(1e-9 / self.fastest());
            let events = self.machine.go(time)?;
            let moment = self.machine.moment()?;
            let within = time - impact <= window * (1.0 + 1e-9);
            if settled && within && figures.release_after.is_none() {
                if let Some(event) =
                    events.iter().find(|event| event.kind.starts_with("release") && event.time > impact)
                {
                    (figures.sequel, figures.release_after) = (Sequel::Elastic, Some(omega * (event.time - impact)));
                } else {
                    largest = [largest[0].max(moment.q[0].abs()), largest[1].max(moment.force[0].abs())];
                }
            }
            let scaled = [sign * moment.q[0] / s, -sign * moment.force[0] / (c * s)];
            points.push(VibrationPoint { tau, q: [None, Some(scaled[0])], force: [None, Some(scaled[1])] });
        }
        if settled && window > 0.0 {
            (figures.elongation, figures.force) = (Some(largest[0]), Some(largest[1]));
        }
        Ok(points)
    }
}
