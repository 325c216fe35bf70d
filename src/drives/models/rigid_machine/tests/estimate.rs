//! The error estimate against the true error, over random machines.
//!
//! The truth is the original equation of motion, with J′, integrated at the finest tolerance with φ, φ̇ and M_an as
//! unknowns.

use super::*;
use crate::numerics::collocation::{Collocation, System};

/// Numbers that look random and are the same in every run (an affine congruence modulo 2⁶⁴).
pub(super) struct Random(pub u64);

impl Random {
    /// From 0 to 1.
    pub(super) fn part(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    pub(super) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.part()
    }

    /// Evenly distributed orders of magnitude.
    pub(super) fn order(&mut self, low: f64, high: f64) -> f64 {
        low * (high / low).powf(self.part())
    }
}

/// J φ̈ = M_an − τ − ½ J′ φ̇², T_el Ṁ_an = M_Kloss − M_an, with torques that are polynomials of the time.
struct Original<'a> {
    machine: &'a RigidMachine,
    load: [f64; 3],
    driving: [f64; 3],
}

pub(super) fn polynomial([a, b, c]: [f64; 3], t: f64) -> f64 {
    a + t * (b + t * c)
}

impl Original<'_> {
    /// M_an and its derivatives with respect to φ̇ and to itself as unknown.
    fn torque(&self, t: Double, y: &[f64; 3]) -> [f64; 3] {
        match self.machine.shaft.motor {
            Motor::Input => [polynomial(self.driving, t.hi), 0.0, 0.0],
            motor if motor.lag().is_some() => [y[2], 0.0, 1.0],
            motor => [motor.characteristic(y[1])[0], motor.characteristic(y[1])[1], 0.0],
        }
    }
}

impl System<3> for Original<'_> {
    fn rhs(&self, t: Double, y: &[f64; 3]) -> [f64; 3] {
        let [j, slope, ..] = self.machine.shaft.inertia.at(self.machine.shaft.inertia.place(0), y[0]);
        let a = (self.torque(t, y)[0] - polynomial(self.load, t.hi) - 0.5 * slope * y[1] * y[1]) / j;
        let rate = self
            .machine
            .shaft
            .motor
            .lag()
            .map_or(0.0, |lag| (self.machine.shaft.motor.characteristic(y[1])[0] - y[2]) / lag);
        [y[1], a, rate]
    }

    fn jacobian(&self, t: Double, y: &[f64; 3]) -> [[f64; 3]; 3] {
        let [j, j1, j2, _] = self.machine.shaft.inertia.at(self.machine.shaft.inertia.place(0), y[0]);
        let a = self.rhs(t, y)[1];
        let [_, by_speed, by_torque] = self.torque(t, y);
        let lag = self.machine.shaft.motor.lag();
        let slope = self.machine.shaft.motor.characteristic(y[1])[1];
        [
            [0.0, 1.0, 0.0],
            [-(0.5 * j2 * y[1] * y[1] + a * j1) / j, (by_speed - j1 * y[1]) / j, by_torque / j],
            [0.0, lag.map_or(0.0, |lag| slope / lag), lag.map_or(0.0, |lag| -1.0 / lag)],
        ]
    }

    fn magnitude(&self, y: &[f64; 3]) -> [f64; 3] {
        [1.0, y[1].abs(), y[2].abs().max(1e-3)]
    }

    fn longest_step(&self, _: Double, y: &[f64; 3]) -> f64 {
        TAU / self.machine.shaft.inertia.resolution() / y[1].abs().max(1e-3)
    }
}

/// A machine, its load and its driving torque, and the duration of its run (s).
pub(super) fn random_machine(r: &mut Random, kind: usize) -> (Scene, [f64; 3], [f64; 3], f64) {
    let constant = r.order(0.05, 5.0);
    let followers = (0..(4.0 * r.part()) as usize)
        .map(|_| {
            let order = r.between(1.0, 6.9) as usize;
            let stroke = r.order(0.01, 0.3);
            let mut wave = |k: usize| if k == 0 { 0.0 } else { stroke * r.between(-1.0, 1.0) / (k * k) as f64 };
            let a = (0..=order).map(&mut wave).collect();
            let b = (0..=order).map(&mut wave).collect();
            // J varies by up to some times its constant part.
            let m = constant * r.order(0.1, 5.0) / (stroke * stroke);
            Follower::new(m, MotionLaw::Fourier(Fourier::new(a, b)))
        })
        .collect();
    let synchronous = r.order(5.0, 100.0);
    let breakdown_torque = constant * synchronous * synchronous * r.order(0.01, 1.0);
    let kloss = |dynamics| {
        Motor::Kloss(Kloss { breakdown_torque, breakdown_slip: 0.0, synchronous_speed: synchronous, dynamics })
    };
    let turn = TAU / synchronous;
    let mut motor = match kind % 4 {
        0 => kloss(None),
        1 => kloss(Some(turn * r.order(0.01, 2.0))),
        2 => Motor::Input,
        _ => Motor::None,
    };
    if let Motor::Kloss(Kloss { breakdown_slip, .. }) = &mut motor {
        *breakdown_slip = r.order(0.02, 0.5);
    }
    let duration = turn * r.order(1.0, 50.0);
    let torque = breakdown_torque * 0.2;
    // Every other machine has torques that depend on time.
    let varies = if kind % 8 < 4 { 0.0 } else { 1.0 };
    let mut signal = |size: f64| {
        let [a, b, c] = [0; 3].map(|_| size * r.between(-1.0, 1.0));
        [a, varies * b / duration, varies * c / (duration * duration)]
    };
    let (load, driving) = (signal(torque), signal(torque));
    let tolerance = 10f64.powf(-r.between(4.0, 11.0));
    let scene = Scene {
        inertia: InertiaFunction { constant, varying: None },
        followers,
        solver: Settings { tolerance, ..Settings::default() },
        ..loom(motor, r.between(-3.0, 3.0), synchronous * r.between(0.1, 1.2))
    };
    (scene, load, driving, duration)
}

/// Sets the torques and their derivatives at `t`.
pub(super) fn set_torques(machine: &mut RigidMachine, load: [f64; 3], driving: [f64; 3], t: f64) {
    for (signal, [a, b, c]) in
        [(machine.shaft.loads.signal_mut(0).unwrap(), load), (&mut machine.shaft.driving, driving)]
    {
        signal.set(polynomial([a, b, c], t));
        signal.set_derivative(1, b + 2.0 * c * t);
        signal.set_derivative(2, 2.0 * c);
    }
}

/// The true error of the states and its estimate.
pub(super) fn errors(scene: Scene, load: [f64; 3], driving: [f64; 3], duration: f64) -> Option<[f64; 2]> {
    let mut machine = started(scene);
    let twin = machine.clone();
    let truth = Original { machine: &twin, load, driving };
    let start = [machine.start.phi, machine.start.w, 0.0];
    let mut c = Collocation::<3>::new(Double::from(0.0), start);
    // If torques do not change, internal steps do not end at communication points: errors between them count.
    let points = if load[1] == 0.0 && machine.shaft.motor.lag().is_none() { 400 } else { 20 };
    let mut differences = [0.0_f64; 3];
    let (mut top_speed, mut travelled) = (start[1].abs(), 1.0_f64);
    for i in 0..points {
        let (t, h) = (duration * f64::from(i) / f64::from(points), duration / f64::from(points));
        set_torques(&mut machine, load, driving, t);
        machine.advance(t, h).ok()?;
        c.advance(&truth, Double::from(t) + Double::from(h), 1e-14).ok()?;
        let y = c.state();
        let torque = if machine.shaft.motor.lag().is_some() { get(&machine, "M_an") - y[2] } else { 0.0 };
        let now = [get(&machine, "phi") - y[0], get(&machine, "w") - y[1], torque];
        differences = std::array::from_fn(|k| differences[k].max(now[k].abs()));
        top_speed = top_speed.max(y[1].abs());
        travelled = travelled.max((y[0] - start[0]).abs());
    }
    let breakdown =
        if let Motor::Kloss(Kloss { breakdown_torque, .. }) = machine.shaft.motor { breakdown_torque } else { 1.0 };
    let [phi, w, torque] = differences;
    let error = (phi / travelled).max(w / top_speed).max(torque / breakdown);
    Some([error, get(&machine, "solver.error_estimate")])
}

/// Estimates beside true errors, over many machines.
#[derive(Default)]
pub(super) struct Tally {
    pub(super) machines: usize,
    beyond: usize,
    /// Estimate over error, by kind of machine.
    ratios: [Vec<f64>; 8],
}

impl Tally {
    /// Counts a machine.
    pub(super) fn add(&mut self, number: usize, [error, estimate]: [f64; 2]) {
        let kind = number % 8;
        self.machines += 1;
        // The truth itself errs by about this.
        if error > estimate + 1e-13 {
            self.beyond += 1;
            println!("machine {number}, kind {kind}: error {error:e} > estimate {estimate:e}");
        }
        if error > 1e-13 {
            self.ratios[kind].push(estimate / error);
        }
    }

    /// The estimate covers 99 of 100 errors and is not a hundred times as large in the median.
    pub(super) fn assert_honest(&mut self) {
        let Tally { machines, beyond, ratios } = self;
        for (kind, ratios) in ratios.iter_mut().enumerate() {
            ratios.sort_by(f64::total_cmp);
            let at = |part: f64| ratios.get((part * ratios.len() as f64) as usize).copied().unwrap_or(f64::NAN);
            println!("kind {kind}: {} ratios {:.2e} {:.2e} {:.2e}", ratios.len(), at(0.0), at(0.5), at(0.95));
        }
        let mut all = ratios.concat();
        all.sort_by(f64::total_cmp);
        let median = all[all.len() / 2];
        println!("{machines} machines, {beyond} beyond, {} ratios, median {median:e}", all.len());
        assert!(100 * *beyond <= *machines, "{beyond} of {machines} errors exceed their estimates");
        assert!(
            median <= 100.0 && 5 * all.len() >= 2 * *machines,
            "the estimates are {median} times the errors in the median"
        );
    }
}

#[test]
fn the_estimate_is_honest() {
    let mut r = Random(20261121);
    let mut tally = Tally::default();
    for number in 0..144 {
        let (scene, load, driving, duration) = random_machine(&mut r, number);
        if let Some(found) = errors(scene, load, driving, duration) {
            tally.add(number, found);
        }
    }
    assert!(tally.machines >= 135, "{}", tally.machines);
    tally.assert_honest();
}
