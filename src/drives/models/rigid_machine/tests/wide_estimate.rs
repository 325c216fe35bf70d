//! The error estimate against the true error, over machines with every kind of law: Fourier series, cycles with dwells,
//! tables, mechanisms, a varying J0; forwards and backwards, through standstill, with torques of all kinds.
//!
//! The truth is the original equation of motion, with J′, integrated by extrapolation, with steps that end where the laws are not
//! smooth.

use super::estimate::{Random, Tally, polynomial, set_torques};
use super::*;
use crate::drives::rigid_machine::linkage::{Branch, FourBar, Kind, Link, Linkage, Mechanism, SliderCrank};

/// Substeps of the modified midpoint rule; the extrapolated value is of order twice their number.
const SUBSTEPS: [usize; 8] = [2, 4, 6, 8, 10, 12, 14, 16];

/// φ, φ̇, M_an.
type Unknowns = [f64; 3];

/// The change by the last extrapolation in a step that is known to rounding, relative to the scales.
const KNOWN: f64 = 1e-15;

struct Truth<'a> {
    machine: &'a RigidMachine,
    load: [f64; 3],
    driving: [f64; 3],
    interval: usize,
    y: Unknowns,
    /// The rounding of `y`.
    rest: Unknowns,
    /// The turns passed.
    turns: f64,
    time: f64,
    /// The angle passed there and back.
    travelled: f64,
    top_speed: f64,
    reversed: bool,
}

impl Truth<'_> {
    fn rhs(&self, t: f64, [phi, w, torque]: Unknowns) -> Unknowns {
        let inertia = &self.machine.shaft.inertia;
        let [j, slope, ..] = inertia.at(inertia.place(self.interval), phi);
        let kloss = |w| self.machine.shaft.motor.characteristic(w)[0];
        let (torque, rate) = match (self.machine.shaft.motor.lag(), self.machine.shaft.motor) {
            (Some(lag), _) => (torque, (kloss(w) - torque) / lag),
            (None, Motor::Input) => (polynomial(self.driving, t), 0.0),
            (None, _) => (kloss(w), 0.0),
        };
        [w, (torque - polynomial(self.load, t) - 0.5 * slope * w * w) / j, rate]
    }

    /// Change of the state in `h`, and the part of it from the last extrapolation, relative to the scales.
    fn extrapolated(&self, h: f64) -> (Unknowns, f64) {
        let axpy = |y: Unknowns, a: f64, x: Unknowns| -> Unknowns { std::array::from_fn(|k| y[k] + a * x[k]) };
        let mut row: Vec<Unknowns> = Vec::new();
        let mut change = f64::INFINITY;
        for (k, n) in SUBSTEPS.into_iter().enumerate() {
            let step = h / n as f64;
            // Increments, so that their rounding is relative to the step.
            let from = self.y;
            let at =
                |i: usize, d: Unknowns| self.rhs(self.time + i as f64 * step, axpy(from, 1.0, axpy(d, 1.0, self.rest)));
            let mut before = [0.0; 3];
            let mut now = axpy([0.0; 3], step, at(0, before));
            for i in 1..n {
                (before, now) = (now, axpy(before, 2.0 * step, at(i, now)));
            }
            let end = at(n, now);
            let mut value: Unknowns = std::array::from_fn(|m| 0.5 * (now[m] + before[m] + step * end[m]));
            for j in (0..k).rev() {
                let ratio = (n as f64 / SUBSTEPS[j] as f64).powi(2);
                let finer: Unknowns = std::array::from_fn(|m| value[m] + (value[m] - row[j][m]) / (ratio - 1.0));
                row[j] = std::mem::replace(&mut value, finer);
            }
            // The first column is last in the order of the loop.
            if k > 0 {
                let scales = [1.0, self.top_speed.max(1e-6), self.y[2].abs().max(1.0)];
                let last = row[0];
                change = (0..3).map(|m| ((value[m] - last[m]) / scales[m]).abs()).fold(0.0, f64::max);
            }
            row.insert(0, value);
            if change <= KNOWN {
                break;
            }
        }
        (row[0], change)
    }

    /// The same angle so many turns less.
    fn turn_back(&mut self, turns: f64) {
        let whole = Double { hi: TAU, lo: 2.4492935982947064e-16 } * Double::from(turns);
        let phi = Double { hi: self.y[0], lo: self.rest[0] } - whole;
        (self.y[0], self.rest[0]) = (phi.hi, phi.lo);
        self.turns += turns;
    }

    fn advance(&mut self, target: f64) -> Option<()> {
        for _ in 0..200_000 {
            let left = target - self.time;
            if left <= 1e-15 * target {
                return Some(());
            }
            let (low, high) = self.machine.shaft.inertia.ends(self.interval);
            let wave = TAU / self.machine.shaft.inertia.resolution();
            let rate = self.rhs(self.time, self.y);
            let reach = 0.5 * wave.min(high - low);
            let mut h = left.min(reach / rate[0].abs().max(1e-9)).min((2.0 * reach / rate[1].abs().max(1e-9)).sqrt());
            let mut gone = loop {
                let (gone, change) = self.extrapolated(h);
                if change <= KNOWN || h < 1e-9 * left.max(1e-9) {
                    break gone;
                }
                h *= 0.5;
            };
            let phi = Double { hi: self.y[0], lo: self.rest[0] };
            let beyond = |border: f64, gone: Unknowns| ((phi - Double::from(border)) + Double::from(gone[0])).hi;
            let border = if beyond(high, gone) > 1e-14 {
                high
            } else if beyond(low, gone) < -1e-14 {
                low
            } else {
                f64::NAN
            };
            let crosses = border.is_finite();
            if crosses {
                // Newton's method between a place before and one after the border, halved if it leaves them.
                let (mut before, mut behind, mut miss) = (0.0, h, beyond(border, gone));
                let side = miss;
                if beyond(border, [0.0; 3]) * side >= 0.0 {
                    (h, gone) = (0.0, [0.0; 3]);
                } else {
                    for i in 1..80 {
                        let newton = h - miss / (self.y[1] + gone[1]);
                        if miss.abs() <= 1e-16 || (newton - h).abs() <= f64::EPSILON * h {
                            break;
                        }
                        let inside = before < newton && newton < behind && i % 8 != 0;
                        h = if inside { newton } else { 0.5 * (before + behind) };
                        (gone, _) = self.extrapolated(h);
                        miss = beyond(border, gone);
                        if miss * side > 0.0 { behind = h } else { before = h }
                    }
                }
            }
            self.time = if h == left { target } else { self.time + h };
            self.travelled += gone[0].abs();
            self.reversed |= self.y[1] * (self.y[1] + gone[1]) < 0.0;
            for k in 0..3 {
                let sum = Double { hi: self.y[k], lo: self.rest[k] } + Double::from(gone[k]);
                (self.y[k], self.rest[k]) = (sum.hi, sum.lo);
            }
            self.top_speed = self.top_speed.max(self.y[1].abs());
            let count = self.machine.shaft.inertia.borders().len();
            if crosses && border == high {
                self.interval = (self.interval + 1) % count;
                if self.interval == 0 {
                    self.turn_back(1.0);
                }
            } else if crosses {
                if self.interval == 0 {
                    self.turn_back(-1.0);
                }
                self.interval = (self.interval + count - 1) % count;
            }
        }
        None
    }
}

fn series(r: &mut Random, size: f64, order: usize) -> Fourier {
    let mut wave = |k: usize| if k == 0 { 0.0 } else { size * r.between(-1.0, 1.0) / (k * k) as f64 };
    let a = (0..=order).map(&mut wave).collect();
    let b = (0..=order).map(&mut wave).collect();
    Fourier::new(a, b)
}

fn cycle(r: &mut Random, stroke: f64) -> MotionLaw {
    let any = |r: &mut Random| StandardLaw::ALL[((6.0 * r.part()) as usize).min(5)];
    let (rise_law, return_law) = (any(r), any(r));
    MotionLaw::Cycle(Cycle::new(CyclePlan {
        stroke,
        lower: -0.5 * stroke,
        rise_start: r.between(0.0, 6.2),
        rise_angle: r.between(0.8, 2.2),
        upper_dwell: r.between(0.2, 1.2),
        return_angle: r.between(0.8, 2.2),
        rise_law,
        return_law,
        inflections: [None; 2],
    }))
}

fn table(r: &mut Random, size: f64) -> MotionLaw {
    let smooth = series(r, size, 3);
    let count = r.between(12.0, 48.0) as usize;
    let angles: Vec<f64> = (0..count).map(|i| TAU * i as f64 / count as f64).collect();
    let lifts = angles.iter().map(|phi| smooth.at(*phi).0[0]).collect();
    MotionLaw::Table(Table::new(Points { angles, lifts }).unwrap())
}

/// A lever, a four-bar linkage and, for every other one, a slider-crank on it.
fn linkage(r: &mut Random) -> Linkage {
    let mut bar = |length: f64| Link {
        length,
        mass: r.order(0.1, 2.0),
        inertia: r.order(1e-4, 1e-2),
        centre: [0.4 * length, 0.05 * length],
    };
    let four_bar =
        FourBar { ground: 0.3, input: bar(0.1), coupler: bar(0.29), output: bar(0.14), branch: Branch::Plus };
    let slider = SliderCrank { crank: bar(0.1), rod: bar(0.3), offset: 0.02, slider_mass: 0.4, branch: Branch::Plus };
    let mut parts = vec![Mechanism { kind: Kind::FourBar(four_bar), input_offset: 1.7, output_offset: 1.72 }];
    if r.part() < 0.5 {
        parts.push(Mechanism { kind: Kind::SliderCrank(slider), input_offset: 1.5, output_offset: 0.3 });
    }
    Linkage(parts)
}

/// A machine, its load and its driving torque, and the duration of its run (s).
pub(super) fn random_machine(r: &mut Random, number: usize) -> (Scene, [f64; 3], [f64; 3], f64) {
    let kind = number % 8;
    let constant = r.order(0.05, 2.0);
    let count = 1 + (2.0 * r.part()) as usize;
    let followers: Vec<Follower> = (0..count)
        .map(|_| {
            let stroke = r.order(0.02, 0.3);
            let m = constant * r.order(0.1, 3.0) / (stroke * stroke);
            match (number / 8) % 4 {
                0 => Follower::new(m, cycle(r, stroke)),
                1 => Follower::new(m, table(r, stroke)),
                2 => Follower::new(m, MotionLaw::Fourier(series(r, stroke, 4))),
                _ => {
                    let cam = if r.part() < 0.5 { MotionLaw::Fourier(series(r, 0.15, 2)) } else { cycle(r, 0.4) };
                    let linkage = linkage(r);
                    let turns = linkage.0.len() == 1;
                    Follower { m: r.order(0.1, 3.0), turns, cam, linkage }
                }
            }
        })
        .collect();
    let varying = (r.part() < 0.3).then(|| match r.part() < 0.5 {
        true => MotionLaw::Fourier(series(r, 0.3 * constant, 3)),
        false => table(r, 0.3 * constant),
    });
    let synchronous = r.order(5.0, 100.0) * if r.part() < 0.3 { -1.0 } else { 1.0 };
    let breakdown_torque = constant * synchronous * synchronous * r.order(0.02, 1.0);
    let breakdown_slip = r.order(0.05, 0.5);
    let turn = TAU / synchronous.abs();
    let kloss =
        |dynamics| Motor::Kloss(Kloss { breakdown_torque, breakdown_slip, synchronous_speed: synchronous, dynamics });
    let motor = match kind % 4 {
        0 => kloss(None),
        1 => kloss(Some(turn * r.order(0.02, 2.0))),
        2 => Motor::Input,
        _ => Motor::None,
    };
    // A start at rest, against the motor, and as usual; a brake that turns the shaft back.
    let start = match (3.0 * r.part()) as usize {
        0 if kind % 4 != 3 => 0.0,
        1 => -synchronous * r.between(0.1, 0.6),
        _ => synchronous * r.between(0.3, 1.2),
    };
    let duration = turn * r.order(1.0, 12.0);
    let varies = if kind < 4 { 0.0 } else { 1.0 };
    let mut signal = |size: f64| {
        let [a, b, c] = [0; 3].map(|_| size * r.between(-1.0, 1.0));
        [a, varies * 2.0 * b / duration, varies * 2.0 * c / (duration * duration)]
    };
    let (load, driving) = (signal(0.2 * breakdown_torque), signal(0.2 * breakdown_torque));
    let tolerance = 10f64.powf(-r.between(4.0, 11.0));
    let scene = Scene {
        loads: vec![Default::default()],
        inertia: InertiaFunction { constant, varying },
        followers,
        motor,
        phi_start: r.between(-3.0, 3.0),
        w_start: start,
        start: MachineStart::Given,
        solver: Settings { tolerance, ..Settings::default() },
    };
    (scene, load, driving, duration)
}

/// The true error of the states and its estimate, and whether the shaft turned back.
fn errors(scene: Scene, load: [f64; 3], driving: [f64; 3], duration: f64) -> Option<([f64; 2], bool)> {
    let mut machine = RigidMachine::new(scene).ok()?;
    machine.shaft.loads.signal_mut(0).unwrap().set(load[0]);
    machine.shaft.driving.set(driving[0]);
    machine.start(0.0).ok()?;
    let twin = machine.clone();
    let State { angle, interval, turns, .. } = machine.state;
    let start = [angle.hi, machine.start.w, machine.state.torque];
    let mut truth = Truth {
        machine: &twin,
        load,
        driving,
        interval,
        y: start,
        rest: [angle.lo, 0.0, 0.0],
        turns,
        time: 0.0,
        travelled: 0.0,
        top_speed: start[1].abs(),
        reversed: false,
    };
    let points = if load[1] == 0.0 && machine.shaft.motor.lag().is_none() { 200 } else { 20 };
    let mut differences = [0.0_f64; 3];
    for i in 0..points {
        let (t, h) = (duration * f64::from(i) / f64::from(points), duration / f64::from(points));
        set_torques(&mut machine, load, driving, t);
        machine.advance(t, h).ok()?;
        truth.advance(t + h)?;
        let torque = if machine.shaft.motor.lag().is_some() { get(&machine, "M_an") - truth.y[2] } else { 0.0 };
        let State { angle, turns, w, .. } = machine.state;
        let phi = (angle.hi - truth.y[0]) + (angle.lo - truth.rest[0]) + (turns - truth.turns) * TAU;
        let now = [phi, w - truth.y[1], torque];
        differences = std::array::from_fn(|k| differences[k].max(now[k].abs()));
    }
    let breakdown =
        if let Motor::Kloss(Kloss { breakdown_torque, .. }) = machine.shaft.motor { breakdown_torque } else { 1.0 };
    let [phi, w, torque] = differences;
    let error = (phi / truth.travelled.max(1.0)).max(w / truth.top_speed).max(torque / breakdown);
    Some(([error, get(&machine, "solver.error_estimate")], truth.reversed))
}

fn family(seed: u64, count: usize, solver: impl Fn(&mut Random, &Scene) -> Settings) -> Tally {
    let mut r = Random(seed);
    let (mut tally, mut reversals) = (Tally::default(), 0);
    for number in 0..count {
        let (mut scene, load, driving, duration) = random_machine(&mut r, number);
        scene.solver = solver(&mut r, &scene);
        match errors(scene, load, driving, duration) {
            Some((found, reversed)) => {
                tally.add(number, found);
                reversals += usize::from(reversed);
            }
            None => println!("machine {number} is refused"),
        }
    }
    println!("{reversals} shafts turn back");
    assert!(reversals >= 40, "{reversals}");
    tally
}

#[test]
fn the_estimate_is_honest_for_every_kind_of_law() {
    let mut tally = family(20261122, 320, |_, scene| scene.solver);
    assert!(tally.machines >= 300, "{}", tally.machines);
    tally.assert_honest();
}

#[test]
fn the_estimate_is_honest_for_every_kind_of_law_at_fixed_cost() {
    let fixed = |step_size| Settings { method: Method::FixedCost, step_size, ..Settings::default() };
    let mut tally = family(7, 520, |r, scene| {
        // With the usual step most errors are below those of the truth.
        let (own, factor) = (r.part() < 0.2, r.order(0.7, 5.0));
        let usual = RigidMachine::new(Scene { solver: fixed(0.0), ..scene.clone() });
        let size = usual.map(|mut machine| machine.start(0.0).map(|()| machine.in_time.grid.size));
        fixed(if own { 0.0 } else { size.map_or(0.0, |size| size.map_or(0.0, |size| size * factor)) })
    });
    assert!(tally.machines >= 440, "{}", tally.machines);
    tally.assert_honest();
}
