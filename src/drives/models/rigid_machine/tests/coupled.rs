//! Loads of other units whose inertia is known.

use super::*;
use crate::drives::AnyDrive;

/// A drive by the names of its variables.
struct Unit(AnyDrive, f64);

impl Unit {
    fn reference(&self, name: &str) -> usize {
        let all = self.0.descriptions();
        all.iter().position(|d| d.name == name).unwrap_or_else(|| panic!("no variable {name}"))
    }

    fn get(&mut self, name: &str) -> f64 {
        self.0.get(self.reference(name)).unwrap()
    }

    fn set(&mut self, name: &str, value: f64) {
        self.0.set(self.reference(name), value).unwrap();
    }

    fn rate(&mut self, name: &str, order: usize, value: f64) {
        self.0.set_input_derivative(self.reference(name), order, value).unwrap();
    }

    fn step(&mut self, h: f64) -> Result<(), Fault> {
        self.0.advance(self.1, h)?;
        self.1 += h;
        Ok(())
    }
}

fn begun(mut drive: AnyDrive) -> Unit {
    drive.set_up(0.0, None);
    drive.start().unwrap();
    Unit(drive, 0.0)
}

fn scene(inertia: InertiaFunction, motor: Motor, loads: Vec<NamedLoad>) -> Scene {
    let (start, solver) = (MachineStart::Given, Settings::default());
    Scene { inertia, followers: vec![], motor, loads, phi_start: 0.0, w_start: 8.0, start, solver }
}

fn only(inertia: bool) -> Vec<NamedLoad> {
    vec![NamedLoad { name: String::new(), inertia }]
}

/// M = 2 (10 − φ̇), Kloss' characteristic far from its breakdown, to within 2e-7 N·m.
fn nearly_linear() -> Motor {
    Motor::Kloss(Kloss { breakdown_torque: 1e4, breakdown_slip: 1e3, synchronous_speed: 10.0, dynamics: None })
}

/// A machine with J0 = 1 kg·m² and M = 2 (10 − φ̇).
fn flywheel(loads: &[NamedLoad]) -> Unit {
    let inertia = InertiaFunction { constant: 1.0, varying: None };
    begun(AnyDrive::new(RigidMachine::new(scene(inertia, nearly_linear(), loads.to_vec())).unwrap()))
}

/// The values that a master sets for the load.
#[derive(Clone, Copy, Debug)]
enum Scheme {
    /// J_load and ½ J_load′ held.
    Held,
    /// J_load′ at both ends of the step.
    Slopes,
    /// J_load at both ends and J_load′ at the first.
    Values,
}

/// J_load = K (1 + 0.6 cos 2φ) and its derivative.
fn load(k: f64, phi: f64) -> [f64; 2] {
    let (sin, cos) = (2.0 * phi).sin_cos();
    [k * (1.0 + 0.6 * cos), -1.2 * k * sin]
}

/// φ̇ after a second in `count` steps.
fn speed_by(machine: &mut Unit, k: f64, count: usize, scheme: Scheme) -> f64 {
    let h = 1.0 / count as f64;
    for _ in 0..count {
        let [phi, w] = ["phi", "w"].map(|name| machine.get(name));
        let [j, slope] = load(k, phi);
        for (name, value) in [("J_load", j), ("dJ_load", slope), ("tau_rest", 0.0)] {
            machine.set(name, value);
        }
        let a = machine.get("a");
        // The load goes first, with the acceleration held.
        let way = (w + 0.5 * a * h) * h;
        let [end, end_slope] = load(k, phi + way);
        match scheme {
            Scheme::Held => {
                machine.set("dJ_load", 0.0);
                machine.set("tau_rest", 0.5 * slope * w * w);
                machine.rate("tau_rest", 1, slope * w * a);
                machine.rate("tau_rest", 2, slope * a * a);
            }
            Scheme::Slopes => machine.rate("dJ_load", 1, (end_slope - slope) / way * w),
            Scheme::Values => machine.rate("dJ_load", 1, 2.0 * (end - j - slope * way) / (way * way) * w),
        }
        machine.step(h).unwrap();
    }
    machine.get("w")
}

/// The truth is one machine with the whole inertia, and the number that two programs of other methods give; the errors match a
/// table of the same schemes.
#[test]
fn a_load_with_inertia_converges_with_the_order_of_what_is_told() {
    let steps = [50, 100, 200, 400];
    for (k, known, held, slopes, values) in [
        (
            0.2,
            9.25346242,
            [4.5e-2, 2.2e-2, 1.1e-2, 5.2e-3],
            [4.6e-3, 1.2e-3, 3.0e-4, 7.6e-5],
            [2.7e-5, 3.5e-6, 4.3e-7, 5.3e-8],
        ),
        (
            0.9,
            8.45376588,
            [0.21, 0.10, 0.052, 0.026],
            [2.8e-3, 1.4e-3, 4.5e-4, 1.3e-4],
            [5.3e-6, 3.3e-6, 4.7e-7, 5.5e-8],
        ),
        (3.0, 8.19229995, [1.8, 0.75, 0.34, 0.16], [6.3e-2, 1.0e-2, 1.6e-3, 2.8e-4], [9.2e-4, 2.7e-5, 7.2e-7, 2.2e-8]),
    ] {
        let varying = Fourier::new(vec![k, 0.0, 0.6 * k], vec![]);
        let whole = InertiaFunction { constant: 1.0, varying: Some(MotionLaw::Fourier(varying)) };
        let mut whole = begun(AnyDrive::new(RigidMachine::new(scene(whole, nearly_linear(), only(false))).unwrap()));
        whole.step(1.0).unwrap();
        let one = whole.get("w");
        assert!((one - known).abs() < 1e-7, "{k}: {one}");
        for (scheme, expected, order) in
            [(Scheme::Held, held, 1.0), (Scheme::Slopes, slopes, 2.0), (Scheme::Values, values, 3.0)]
        {
            let error = |n: usize| (speed_by(&mut flywheel(&only(true)), k, n, scheme) - one).abs();
            let errors = steps.map(error);
            for (error, expected) in errors.iter().zip(expected) {
                assert!((0.5..2.0).contains(&(error / expected)), "{k} {scheme:?}: {error:e}, {expected:e}");
            }
            // The strongest load is not yet in the range of its order.
            for pair in errors.windows(2).filter(|_| k == 0.2) {
                let found = (pair[0] / pair[1]).log2();
                assert!((found - order).abs() < 0.2, "{scheme:?}: order {found}");
            }
        }
    }
}

/// Without torques ½ (J + J_load) φ̇² stays, whatever the step, as J_load is the polynomial of the angle.
#[test]
fn the_energy_of_shaft_and_load_is_constant_without_torques() {
    let inertia = InertiaFunction { constant: 1.0, varying: None };
    for (sense, h) in [(1.0, 0.1), (-1.0, 0.02), (1.0, 1e-3)] {
        let machine = Scene { w_start: sense * 3.0, ..scene(inertia.clone(), Motor::None, only(true)) };
        let mut machine = begun(AnyDrive::new(RigidMachine::new(machine).unwrap()));
        for _ in 0..20 {
            let [phi, w] = ["phi", "w"].map(|name| machine.get(name));
            let ([j, slope], curvature) = (load(0.9, phi), 0.7);
            machine.set("J_load", j);
            machine.set("dJ_load", slope);
            machine.rate("dJ_load", 1, curvature * w);
            machine.step(h).unwrap();
            let way = machine.get("phi") - phi;
            let of_load = j + (slope + 0.5 * curvature * way) * way;
            let speed = machine.get("w");
            let ratio = (1.0 + of_load) * speed * speed / ((1.0 + j) * w * w);
            assert!((ratio - 1.0).abs() < 1e-12, "{ratio}");
            // J and E belong to the machine itself, the acceleration to the whole.
            assert_eq!((machine.get("J"), machine.get("E")), (1.0, 0.5 * speed * speed));
            let a = -0.5 * (slope + curvature * way) * speed * speed / (1.0 + of_load);
            assert!((machine.get("a") - a).abs() < 1e-12 * (1.0 + a.abs()), "{} {a}", machine.get("a"));
        }
    }
}

#[test]
fn an_inertia_that_is_not_positive_is_refused() {
    let refused = |of: &dyn Fn(&mut Unit)| {
        let mut machine = flywheel(&only(true));
        of(&mut machine);
        let fault = machine.step(0.1).unwrap_err().to_string();
        assert!(fault.contains("inertia of shaft and loads must be positive"), "{fault}");
        fault
    };
    let fault = refused(&|machine| machine.set("J_load", -1.0));
    assert!(fault.contains("J = 1 kg.m2 and J_load = -1 kg.m2"), "{fault}");
    // It vanishes beyond 0.4 rad, within the step.
    refused(&|machine| machine.set("dJ_load", -2.5));
    refused(&|machine| {
        machine.set("J_load", 0.5);
        machine.rate("dJ_load", 1, -400.0);
    });
}

/// The derivatives of the outputs, against differences of the drive and of its motion.
#[test]
fn derivatives_know_the_loads() {
    let loads =
        [("pusher", true), ("gripper", false)].map(|(name, inertia)| NamedLoad { name: name.to_owned(), inertia });
    let inputs = ["pusher.J_load", "pusher.dJ_load", "pusher.tau_rest", "gripper.tau"];
    for name in inputs {
        let prepared = |moved: f64, h: f64| {
            let mut machine = flywheel(&loads);
            for (input, value) in inputs.into_iter().zip([0.7, 0.4, 1.5, -2.0]) {
                machine.set(input, value + if input == name { moved } else { 0.0 });
            }
            machine.rate("pusher.dJ_load", 1, 3.0);
            machine.rate("pusher.tau_rest", 1, 20.0);
            machine.rate("gripper.tau", 2, -300.0);
            if h > 0.0 {
                machine.step(h).unwrap();
            }
            machine
        };
        let mut machine = prepared(0.0, 0.0);
        let (a, known) = (machine.reference("a"), machine.reference(name));
        let slope = machine.0.directional_derivatives(&[a], &[(known, 1.0)]).unwrap()[0];
        let of = |moved: f64, h: f64| prepared(moved, h).get("a");
        let difference = (of(1e-4, 0.0) - of(-1e-4, 0.0)) / 2e-4;
        assert!((slope - difference).abs() < 1e-6 * difference.abs(), "{name}: {slope} {difference}");
        for h in [0.0, 0.01] {
            let rates = [1, 2].map(|order| prepared(0.0, h).0.output_derivative(a, order).unwrap());
            // One-sided at the start of the step, for which the derivatives hold.
            let step = 1e-4;
            let [a0, a1, a2, a3] = [0.0, 1.0, 2.0, 3.0].map(|n| of(0.0, h + n * step));
            let first = (-11.0 * a0 + 18.0 * a1 - 9.0 * a2 + 2.0 * a3) / (6.0 * step);
            let second = (2.0 * a0 - 5.0 * a1 + 4.0 * a2 - a3) / (step * step);
            assert!((rates[0] - first).abs() < 1e-5 * (1.0 + first.abs()), "{h}: {} {first}", rates[0]);
            assert!((rates[1] - second).abs() < 1e-2 * (1.0 + second.abs()), "{h}: {} {second}", rates[1]);
        }
    }
}
