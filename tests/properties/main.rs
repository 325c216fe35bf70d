//! What every drive owes for any scene: properties over random scenes with fixed seeds.
//!
//! A solution may be sensitive (resonances, impacts, parametric instability); then rounding grows with it. So two runs
//! that must agree may differ by 1e-8 of the size of the motion, and by 100 times what a change of the stiffness or the
//! inertia by 1e-10, the default tolerance, makes of it. Where that alone exceeds 1 % of the motion the scene is chaotic
//! and shows nothing; few may be.

mod coupling;
mod creep;
mod design;
mod every_fmu;
mod forged;
mod inputs;
mod limits;
mod linkage;
mod parametric;
mod relations;
mod run;
mod scenes;
mod systems;
mod train;
mod tuning;

use camdrive::drives::Fault;
use proptest::prelude::*;
use proptest::test_runner::{Config, RngSeed};
use run::Run;
use scenes::{CamScene, MachineScene, Model, Torque, backlash, machine, output, shaft};
use std::f64::consts::TAU;

/// Relative deviation of two runs of a drive that is not sensitive: its documented accuracy, 1e-9, with the digits that
/// a few turns may lose.
const AGREEMENT: f64 = 1e-8;

/// The solvers keep their tolerance of 1e-10 in every step, of which there are some hundred.
const SENSITIVITY: f64 = 100.0;

/// Which random scenes: 0 of `PROPERTIES_SEED` are those of the suite; and `PROPERTIES_TIMES` as many of them.
fn chosen() -> [u32; 2] {
    [("PROPERTIES_SEED", 0), ("PROPERTIES_TIMES", 1)].map(|(name, usual)| {
        std::env::var(name).map_or(usual, |text| text.parse().unwrap_or_else(|_| panic!("{name}={text} is no number")))
    })
}

fn config(cases: u32, rejects: u32, seed: u64) -> Config {
    let [other, times] = chosen();
    Config {
        cases: times * cases,
        rng_seed: RngSeed::Fixed(seed + 1000 * u64::from(other)),
        failure_persistence: None,
        // Scenes that show nothing: chaotic or refused ones.
        max_global_rejects: times.saturating_mul(rejects),
        max_shrink_iters: 200,
        ..Config::default()
    }
}

/// A refused scene shows nothing, but the refusal has to be a sentence about numbers.
fn admitted<T>(result: Result<T, Fault>) -> Result<T, TestCaseError> {
    result.map_err(|fault| {
        let text = fault.to_string();
        if text.len() > 20 && !text.contains("NaN") && !text.contains("inf") {
            TestCaseError::reject(text)
        } else {
            TestCaseError::fail(format!("no clear message: {text}"))
        }
    })
}

const CAM_STATE: [&str; 2] = ["q", "der(q)"];
const BACKLASH_STATE: [&str; 4] = ["q", "der(q)", "x1", "der(x1)"];
const MACHINE_STATE: [&str; 2] = ["phi", "w"];

fn names(scene: &CamScene) -> &'static [&'static str] {
    if scene.model == Model::Backlash { &BACKLASH_STATE } else { &CAM_STATE }
}

/// The states after the span, reached over `shares` of it, and the largest of each on the way.
fn states(scene: &CamScene, shares: &[f64]) -> Result<(Vec<f64>, Vec<f64>), Fault> {
    trace(Run::new(scene.resolved(), &[])?, names(scene), scene.span, shares)
}

fn machine_states(scene: &MachineScene, shares: &[f64]) -> Result<(Vec<f64>, Vec<f64>), Fault> {
    trace(Run::new(scene.resolved(), &scene.inputs())?, &MACHINE_STATE, scene.span, shares)
}

fn trace(mut run: Run, names: &[&str], span: f64, shares: &[f64]) -> Result<(Vec<f64>, Vec<f64>), Fault> {
    let mut largest: Vec<f64> = names.iter().map(|name| run.get(name).abs()).collect();
    for share in shares.iter().chain(&[1.0]) {
        run.to(span * share)?;
        for (l, name) in largest.iter_mut().zip(names) {
            *l = l.max(run.get(name).abs());
        }
    }
    Ok((names.iter().map(|name| run.get(name)).collect(), largest))
}

/// Even shares, fine enough to see the size of the motion.
fn even() -> Vec<f64> {
    (1..64).map(|i| f64::from(i) / 64.0).collect()
}

fn splits() -> impl Strategy<Value = Vec<f64>> {
    // From a billionth of the span to all of it.
    prop::collection::vec(prop_oneof![0.0..1.0_f64, (-9.0..0.0_f64).prop_map(|x| 10_f64.powf(x))], 0..30).prop_map(
        |mut shares| {
            shares.sort_by(f64::total_cmp);
            shares
        },
    )
}

/// Whether `got` and `expected` agree as far as the sensitivity of the scene lets them.
fn agree(got: &[f64], expected: &[f64], largest: &[f64], perturbed: &[f64]) -> Result<(), TestCaseError> {
    for i in 0..got.len() {
        let scale = largest[i].max(expected[i].abs());
        let sensitivity = (perturbed[i] - expected[i]).abs();
        prop_assume!(SENSITIVITY * sensitivity <= 1e-2 * scale);
        let (difference, admissible) = ((got[i] - expected[i]).abs(), AGREEMENT * scale + SENSITIVITY * sensitivity);
        prop_assert!(
            difference <= admissible,
            "component {i}: {:e} instead of {:e}: {difference:e} > {admissible:e}",
            got[i],
            expected[i]
        );
    }
    Ok(())
}

fn refinement(scene: &CamScene, shares: &[f64]) -> Result<(), TestCaseError> {
    let (even, largest) = admitted(states(scene, &even()))?;
    let (perturbed, _) = admitted(states(&scene.perturbed(), &[]))?;
    agree(&admitted(states(scene, &[]))?.0, &even, &largest, &perturbed)?;
    agree(&admitted(states(scene, shares))?.0, &even, &largest, &perturbed)
}

/// How a cam drive is run: at constant speed, or on inputs.
type Motion<'a> = &'a dyn Fn(&CamScene, &[f64]) -> Result<(Vec<f64>, Vec<f64>), Fault>;

fn time_scaling_of(scene: &CamScene, factor: f64, states: Motion, perturbed: &[f64]) -> Result<(), TestCaseError> {
    let (expected, largest) = admitted(states(scene, &even()))?;
    let (mut slow, _) = admitted(states(&scene.slower(factor), &[]))?;
    // Every second state is a speed.
    slow.iter_mut().skip(1).step_by(2).for_each(|v| *v *= factor);
    agree(&slow, &expected, &largest, perturbed)
}

fn mirror(scene: &CamScene) -> Result<(), TestCaseError> {
    let (perturbed, _) = admitted(states(&scene.perturbed(), &[]))?;
    mirror_of(scene, &states, &perturbed)
}

fn mirror_of(scene: &CamScene, states: Motion, perturbed: &[f64]) -> Result<(), TestCaseError> {
    // Where no force presses mass 1 against either flank, as in a dwell at rest, it starts at flank A by convention.
    let pressed = scene.law.at(scene.phi_start).0[2] != 0.0 || [scene.q, scene.q_dot] != [0.0, 0.0];
    prop_assume!(scene.model != Model::Backlash || pressed);
    let (expected, largest) = admitted(states(scene, &even()))?;
    let sign = if matches!(scene.model, Model::Shaft | Model::LinearShaft) { -1.0 } else { 1.0 };
    let (mut reversed, _) = admitted(states(&scene.reversed(), &[]))?;
    reversed.iter_mut().for_each(|v| *v *= sign);
    agree(&reversed, &expected, &largest, perturbed)?;
    let (mut mirrored, _) = admitted(states(&scene.mirrored(), &[]))?;
    mirrored.iter_mut().for_each(|v| *v *= -sign);
    if scene.model == Model::Backlash {
        // Flanks U … U + s become −U … −U + s: the mirror image lies between −U − s and −U.
        mirrored[2] += scene.s;
    }
    agree(&mirrored, &expected, &largest, perturbed)
}

fn restoring(run: Run, other: Run, span: f64, shares: &[f64]) -> Result<(), TestCaseError> {
    restoring_on_inputs(run, other, span, shares, |_| Ok(()))
}

/// Saved at one instant, serialised, taken up by an instance that has been elsewhere: the same bits from there on.
/// `set` sets the inputs for the step ahead.
fn restoring_on_inputs(
    mut run: Run,
    mut other: Run,
    span: f64,
    shares: &[f64],
    set: impl Fn(&mut Run) -> Result<(), Fault>,
) -> Result<(), TestCaseError> {
    let (before, after) = shares.split_at(shares.len() / 2);
    let step = |run: &mut Run, share: f64| set(run).and_then(|()| run.to(span * share));
    admitted(before.iter().try_for_each(|share| step(&mut run, *share)))?;
    let (state, time) = (run.drive.save(), run.time);
    let bytes = state.serialize().expect("a state of this model");
    let continued = |run: &mut Run| -> Result<Vec<Vec<u64>>, Fault> {
        let mut all = vec![run.bits()];
        for share in after.iter().chain(&[1.0]) {
            step(run, *share)?;
            all.push(run.bits());
        }
        Ok(all)
    };
    let expected = admitted(continued(&mut run))?;
    run.drive.restore(&state);
    run.time = time;
    prop_assert_eq!(&admitted(continued(&mut run))?, &expected, "restored from memory");
    admitted(step(&mut other, 0.3))?;
    let copy = admitted(other.drive.deserialize(&bytes))?;
    other.drive.restore(&copy);
    other.time = time;
    prop_assert_eq!(&admitted(continued(&mut other))?, &expected, "restored from bytes");
    Ok(())
}

fn cam_restoring(scene: &CamScene, shares: &[f64]) -> Result<(), TestCaseError> {
    let run = || admitted(Run::new(scene.resolved(), &[]));
    restoring(run()?, run()?, scene.span, shares)
}

/// Abscissae and weights of Gauss–Legendre quadrature of order 16 on [−1, 1].
fn quadrature() -> impl Iterator<Item = (f64, f64)> {
    const NODES: [f64; 4] = [0.1834346424956498, 0.525532409916329, 0.7966664774136267, 0.9602898564975363];
    const WEIGHTS: [f64; 4] = [0.3626837833783620, 0.3137066458778873, 0.2223810344533745, 0.1012285362903763];
    (0..4).rev().map(|i| (-NODES[i], WEIGHTS[i])).chain((0..4).map(|i| (NODES[i], WEIGHTS[i])))
}

/// ∫ of a power over the run by Gauss–Legendre quadrature of order 16 on panels that end at `borders`; also ∫ of its
/// absolute value.
fn work(run: &mut Run, borders: &[f64], power: impl Fn(&mut Run) -> f64) -> Result<[f64; 2], Fault> {
    let mut sums = [0.0; 2];
    for pair in borders.windows(2) {
        let (middle, half) = ((pair[0] + pair[1]) / 2.0, (pair[1] - pair[0]) / 2.0);
        for n in quadrature() {
            run.to(middle + half * n.0)?;
            let p = half * n.1 * power(run);
            sums[0] += p;
            sums[1] += p.abs();
        }
    }
    run.to(borders[borders.len() - 1])?;
    Ok(sums)
}

/// The ends of panels: `count` equal ones, and the instants at which the cam passes a breakpoint of its law.
fn borders(scene: &CamScene, count: usize) -> Vec<f64> {
    let mut all: Vec<f64> = (0..=count).map(|i| scene.span * i as f64 / count as f64).collect();
    for angle in scene.law.breakpoints() {
        let first = ((scene.phi_start - angle) / TAU).floor() as i64 - 5;
        for turn in first..first + 12 {
            let t = (angle + TAU * turn as f64 - scene.phi_start) / scene.w;
            if 0.0 < t && t < scene.span {
                all.push(t);
            }
        }
    }
    all.sort_by(f64::total_cmp);
    all
}

/// `count` equal panels.
fn equal(span: f64, count: usize) -> Vec<f64> {
    (0..=count).map(|i| span * i as f64 / count as f64).collect()
}

/// The balance with `count` panels or, where these are too few for the quadrature, with eight times as many and again so: an
/// error of the drive remains.
fn with_finer_panels(count: usize, balance: impl Fn(usize) -> Result<(), TestCaseError>) -> Result<(), TestCaseError> {
    let finer = |factor: usize| {
        let balance = &balance;
        move |error| match error {
            TestCaseError::Fail(_) => balance(factor * count),
            rejected => Err(rejected),
        }
    };
    balance(count).or_else(finer(8)).or_else(finer(64))
}

/// d/dt (m ẏ²/2 + c q²/2) = tau ω − b q̇², d/dt (m ẏ) = force.
fn balance_of_output(scene: &CamScene) -> Result<(), TestCaseError> {
    // Strong damping decays within a short time that would ask for as short panels.
    let rate = (scene.c / scene.m).sqrt().max(scene.b / scene.m);
    let harmonics = scene.law.series().map_or(12.0, |s| s.order() as f64) * scene.w.abs();
    let count = ((rate + 2.0 * harmonics) * scene.span / 2.0).ceil();
    prop_assume!(count < 2000.0);
    with_finer_panels(count as usize + 1, |count| energy_and_momentum_of_output(scene, count))
}

fn energy_and_momentum_of_output(scene: &CamScene, count: usize) -> Result<(), TestCaseError> {
    let borders = borders(scene, count);
    let mut run = admitted(Run::new(scene.resolved(), &[]))?;
    let state = |run: &mut Run| {
        let [v, q] = run.all(["der(y)", "q"]);
        [scene.m * v * v / 2.0 + scene.c * q * q / 2.0, scene.m * v]
    };
    let start = state(&mut run);
    let [power, total] = admitted(work(&mut run, &borders, |run| {
        let [tau, v] = run.all(["tau", "der(q)"]);
        tau * scene.w - scene.b * v * v
    }))?;
    let end = state(&mut run);
    let scale = total + start[0] + end[0];
    prop_assert!(
        (end[0] - start[0] - power).abs() <= 1e-8 * scale,
        "energy {:e} of {scale:e}",
        end[0] - start[0] - power
    );
    let mut run = admitted(Run::new(scene.resolved(), &[]))?;
    let [impulse, total] = admitted(work(&mut run, &borders, |run| run.get("force")))?;
    prop_assert!((end[1] - start[1] - impulse).abs() <= 1e-8 * (total + start[1].abs()));
    Ok(())
}

/// d/dt ((J + m U′²) ψ̇²/2 + c q²/2) = tau ω − b q̇²; (J + m U′²) ψ̇² = J ψ̇² + m ẏ². For series: where a nonlinear shaft passes
/// breakpoints depends on its motion.
fn balance_of_shaft(scene: &CamScene) -> Result<(), TestCaseError> {
    let count = panels_of_shaft(scene);
    prop_assume!(count < 3000.0);
    with_finer_panels(count as usize + 1, |count| energy_of_shaft(scene, count))
}

fn energy_of_shaft(scene: &CamScene, count: usize) -> Result<(), TestCaseError> {
    let borders = equal(scene.span, count);
    let mut run = admitted(Run::new(scene.resolved(), &[]))?;
    let energy = |run: &mut Run| {
        let [v, q, y] = run.all(["der(q)", "q", "der(y)"]);
        (scene.second * (scene.w + v).powi(2) + scene.m * y * y + scene.c * q * q) / 2.0
    };
    let start = energy(&mut run);
    let [power, total] = admitted(work(&mut run, &borders, |run| {
        let [tau, v] = run.all(["tau", "der(q)"]);
        tau * scene.w - scene.b * v * v
    }))?;
    let end = energy(&mut run);
    let scale = total + start.max(end);
    prop_assert!((end - start - power).abs() <= 1e-8 * scale, "energy {:e} of {scale:e}", end - start - power);
    Ok(())
}

/// d/dt (j ψ̇) = j′ψ̇²/2 − c q − b q̇ with j = J + m U′²(ψ), ψ = φ + q; of the linearised shaft the terms of first order.
fn momentum_of_shaft(scene: &CamScene) -> Result<(), TestCaseError> {
    let linear = scene.model == Model::LinearShaft;
    let count = panels_of_shaft(scene);
    prop_assume!(count < 3000.0);
    // Momentum and its rate at the instant of the run.
    let at = |run: &mut Run| {
        let [q, v] = run.all(CAM_STATE);
        let phi = scene.phi_start + scene.w * run.time;
        let [_, u1, u2, u3, _] = scene.law.at(if linear { phi } else { phi + q }).0;
        let [j, j1, j2] =
            [scene.second + scene.m * u1 * u1, 2.0 * scene.m * u1 * u2, 2.0 * scene.m * (u2 * u2 + u1 * u3)];
        let torque = -scene.c * q - scene.b * v;
        let w = scene.w;
        if linear {
            [j * (w + v) + j1 * q * w, j1 * w * (w / 2.0 + v) + j2 * q * w * w / 2.0 + torque]
        } else {
            [j * (w + v), j1 * (w + v).powi(2) / 2.0 + torque]
        }
    };
    with_finer_panels(count as usize + 1, |count| {
        let mut run = admitted(Run::new(scene.resolved(), &[]))?;
        let start = at(&mut run)[0];
        let [impulse, total] = admitted(work(&mut run, &borders(scene, count), |run| at(run)[1]))?;
        let end = at(&mut run)[0];
        let error = (end - start - impulse).abs();
        prop_assert!(error <= 1e-8 * (total + start.abs()), "momentum {error:e} of {:e}", total + start.abs());
        Ok(())
    })
}

/// Panels in which neither the vibration nor the cam turns far.
fn panels_of_shaft(scene: &CamScene) -> f64 {
    let rate = (scene.c / scene.second).sqrt().max(scene.b / scene.second);
    let harmonics = scene.law.series().map_or(12.0, |s| s.order() as f64) * scene.w.abs();
    ((rate + 2.0 * harmonics) * scene.span).ceil()
}

/// Momentum changes by Σ force_mean h, energy by Σ tau_mean ω h less the losses, whatever happens inside the steps.
fn balance_of_backlash(scene: &CamScene, shares: &[f64]) -> Result<(), TestCaseError> {
    let mut run = admitted(Run::new(scene.resolved(), &[]))?;
    let state = |run: &mut Run| {
        let [v1, v2, q] = run.all(["der(x1)", "der(y)", "q"]);
        let kinetic = scene.m * v1 * v1 + scene.second * v2 * v2;
        [scene.m * v1 + scene.second * v2, (kinetic + scene.c * q * q) / 2.0]
    };
    let start = state(&mut run);
    let (mut sums, mut sizes) = ([0.0; 2], start.map(f64::abs));
    for share in shares.iter().chain(&[1.0]) {
        let before = run.time;
        admitted(run.to(scene.span * share))?;
        let h = run.time - before;
        if h > 0.0 {
            let [force, torque, gap] = run.all(["force_mean", "tau_mean", "gap"]);
            let rounding = 1e-14 * scene.law.bound(0);
            prop_assert!(-rounding <= gap && gap <= scene.s + rounding, "gap {gap:e}");
            let (impulse, work) = (h * force, h * torque * scene.w);
            sums = [sums[0] + impulse, sums[1] + work];
            let now = state(&mut run);
            sizes = [sizes[0].max(now[0].abs()) + impulse.abs(), sizes[1].max(now[1]) + work.abs()];
        }
    }
    let end = state(&mut run);
    let losses: f64 = run.all(["energy_loss", "damping_loss"]).iter().sum();
    let errors = [end[0] - start[0] - sums[0], end[1] - start[1] - sums[1] + losses];
    prop_assert!(errors[0].abs() <= 1e-10 * sizes[0], "momentum {:e} of {:e}", errors[0], sizes[0]);
    prop_assert!(errors[1].abs() <= 1e-9 * (sizes[1] + losses), "energy {:e} of {:e}", errors[1], sizes[1] + losses);
    Ok(())
}

/// ½Jφ̇² changes by the work of the motor less that of the constant load, τ Δφ.
fn balance_of_machine(scene: &MachineScene) -> Result<(), TestCaseError> {
    let smooth = scene.followers.iter().all(|follower| follower.cam.series().is_some());
    prop_assume!(smooth || !matches!(scene.torque, Torque::Kloss(_)));
    // With σ the slip by the breakdown slip, a small one decays at the rate κ; with a lag it oscillates.
    let rate = match scene.torque {
        Torque::None | Torque::Input(_) => 0.0,
        Torque::Kloss([m, slip, speed, lag]) => {
            let kappa = 2.0 * m / (scene.j0 * slip * speed.abs());
            if lag > 0.0 { (kappa / lag).sqrt().max(1.0 / lag).min(kappa) } else { kappa }
        }
    };
    let count = 400.0 + rate * scene.span / 4.0;
    prop_assume!(count < 5000.0);
    with_finer_panels(count as usize, |count| energy_of_machine(scene, count))
}

fn energy_of_machine(scene: &MachineScene, count: usize) -> Result<(), TestCaseError> {
    let borders = equal(scene.span, count);
    let mut run = admitted(Run::new(scene.resolved(), &scene.inputs()))?;
    let [energy, phi] = run.all(["E", "phi"]);
    let sums = match scene.torque {
        Torque::None => admitted(run.to(scene.span)).map(|()| [0.0; 2])?,
        Torque::Input(m) => {
            admitted(run.to(scene.span))?;
            let given = m * (run.get("phi") - phi);
            [given, given.abs()]
        }
        Torque::Kloss(_) => admitted(work(&mut run, &borders, |run| run.get("M_an") * run.get("w")))?,
    };
    let [end, angle] = run.all(["E", "phi"]);
    let braked = scene.load * (angle - phi);
    let scale = sums[1] + braked.abs() + energy.max(end);
    let difference = end - energy - sums[0] + braked;
    prop_assert!(difference.abs() <= 1e-7 * scale, "energy {difference:e} of {scale:e}");
    Ok(())
}

macro_rules! of_cam_drives {
    ($($name:ident: $scene:expr, $cases:expr, $seed:expr;)*) => {$(
        mod $name {
            use super::*;

            proptest! {
                #![proptest_config(config($cases, $cases / 4, $seed))]

                #[test]
                fn one_step_or_many(scene in $scene, shares in splits()) { refinement(&scene, &shares)?; }

                #[test]
                fn mirror_images(scene in $scene) { mirror(&scene)?; }

                #[test]
                fn restored_at_any_instant(scene in $scene, shares in splits()) { cam_restoring(&scene, &shares)?; }
            }
        }
    )*};
}

of_cam_drives! {
    elastic_output: output(), 100, 1;
    linear_shaft: shaft(Model::LinearShaft, 10.0), 50, 2;
    nonlinear_shaft: shaft(Model::Shaft, 10.0), 50, 3;
    backlash_drive: backlash(), 100, 4;
}

proptest! {
    // A quadrature that would need too many panels shows nothing either.
    #![proptest_config(config(60, 120, 5))]

    #[test]
    fn elastic_output_balances(scene in output()) { balance_of_output(&scene)?; }

    #[test]
    fn nonlinear_shaft_balances(
        scene in shaft(Model::Shaft, 10.0).prop_filter("a series", |scene| scene.law.series().is_some())
    ) {
        balance_of_shaft(&scene)?;
        momentum_of_shaft(&scene)?;
    }

    #[test]
    fn linear_shaft_balances(scene in shaft(Model::LinearShaft, 10.0)) { momentum_of_shaft(&scene)?; }

    #[test]
    fn backlash_balances(scene in backlash(), shares in splits()) { balance_of_backlash(&scene, &shares)?; }

    #[test]
    fn machine_balances(scene in machine()) { balance_of_machine(&scene)?; }
}

proptest! {
    #![proptest_config(config(60, 15, 6))]

    #[test]
    fn machine_in_one_step_or_many(scene in machine(), shares in splits()) {
        let (even, largest) = admitted(machine_states(&scene, &even()))?;
        let (perturbed, _) = admitted(machine_states(&scene.perturbed(), &[]))?;
        agree(&admitted(machine_states(&scene, &[]))?.0, &even, &largest, &perturbed)?;
        agree(&admitted(machine_states(&scene, &shares))?.0, &even, &largest, &perturbed)?;
    }

    #[test]
    fn machine_upside_down(scene in machine()) {
        let (expected, largest) = admitted(machine_states(&scene, &even()))?;
        let (perturbed, _) = admitted(machine_states(&scene.perturbed(), &[]))?;
        // Upside down, U → −U, the machine has the same J.
        let (mirrored, _) = admitted(machine_states(&scene.mirrored(), &[]))?;
        agree(&mirrored, &expected, &largest, &perturbed)?;
    }

    #[test]
    fn machine_restored_at_any_instant(scene in machine(), shares in splits()) {
        let run = || admitted(Run::new(scene.resolved(), &scene.inputs()));
        restoring(run()?, run()?, scene.span, &shares)?;
    }
}
