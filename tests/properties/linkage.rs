//! What mechanisms between cam and tool owe, for random chains of them.

use super::run::Run;
use super::scenes::{decades, law, sign, solver, times};
use super::{admitted, config};
use camdrive::drives::rigid_machine::Follower;
use camdrive::drives::rigid_machine::linkage::{Branch, FourBar, Gear, Kind, Link, Linkage, Mechanism, SliderCrank};
use camdrive::motion::MotionLaw;
use camdrive_design::lever_law::{inverse, lever_law};
use proptest::prelude::*;
use serde_json::json;
use std::f64::consts::TAU;

/// A chain whose mechanisms are at a good position with the lever at 0, and a lever that swings about it.
#[derive(Clone, Debug)]
struct Chain {
    linkage: Linkage,
    /// The law of the lever (rad).
    lever: MotionLaw,
    /// Mass or moment of inertia of the tool.
    m: f64,
}

/// The bodies of a mechanism: mass, radius of gyration and centre of mass as parts of the length.
type Body = (f64, f64, f64, f64);

fn body() -> impl Strategy<Value = Body> {
    (prop_oneof![1 => Just(0.0), 3 => decades(-2.0, 1.0)], 0.0..0.6_f64, -0.5..1.5_f64, -0.3..0.3_f64)
}

fn link(length: f64, (mass, gyration, x, y): Body) -> Link {
    Link { length, mass, inertia: mass * (gyration * length).powi(2), centre: [x * length, y * length] }
}

/// A mechanism that is at the middle of its swing where its input is 0.
fn mechanism() -> impl Strategy<Value = Mechanism> {
    let branch = prop_oneof![Just(Branch::Plus), Just(Branch::Minus)];
    let size = decades(-3.0, 1.0);
    (0..3_usize, size, 0.2..2.0_f64, 0.3..0.9_f64, 0.7..2.4_f64, -3.0..3.0_f64, branch, [body(), body(), body()])
        .prop_map(|(kind, size, ratio, share, angle, theta, branch, [first, second, third])| {
            let kind = match kind {
                0 => Kind::Gear(Gear { ratio: ratio.copysign(theta), inertia: 0.1 * size, output_turns: true }),
                1 => {
                    // Coupler and output link meet at this transmission angle, the diagonal is the third side.
                    let (a, g) = (ratio * size, size);
                    let d = (g * g + a * a - 2.0 * a * g * theta.cos()).sqrt();
                    let b = share * d;
                    let c = b * angle.cos() + (d * d - (b * angle.sin()).powi(2)).sqrt();
                    let [input, coupler, output] = [link(a, first), link(b, second), link(c, third)];
                    Kind::FourBar(FourBar { ground: g, input, coupler, output, branch })
                }
                _ => {
                    // The rod leaves the slider's line at this angle.
                    let rod = (1.2 + 3.0 * share) * size;
                    let offset = size * theta.sin() - rod * angle.cos();
                    let [crank, rod] = [link(size, first), link(rod, second)];
                    Kind::SliderCrank(SliderCrank { crank, rod, offset, slider_mass: third.0, branch })
                }
            };
            Mechanism { kind, input_offset: theta, output_offset: 0.0 }
        })
}

/// A slider-crank of these two links.
pub fn slider_crank([crank, rod]: [Link; 2], offset: f64, slider_mass: f64) -> Mechanism {
    let kind = Kind::SliderCrank(SliderCrank { crank, rod, offset, slider_mass, branch: Branch::Plus });
    Mechanism { kind, input_offset: 0.0, output_offset: 0.0 }
}

/// The mechanisms up to the first whose output moves along a line, with all outputs 0 where the lever is at 0.
fn centred(list: impl Iterator<Item = Mechanism>) -> Linkage {
    let mut linkage = Linkage::default();
    for mechanism in list {
        linkage.0.push(mechanism);
        let [output] = linkage.tool([0.0]);
        if let Some(last) = linkage.0.last_mut() {
            last.output_offset = output;
        }
        if !mechanism.output_turns() {
            break;
        }
    }
    linkage
}

fn chain() -> impl Strategy<Value = Chain> {
    (prop::collection::vec(mechanism(), 1..4), law(), 0.05..0.8_f64, decades(-2.0, 1.0)).prop_map(
        |(list, law, swing, m)| {
            let linkage = centred(list.into_iter());
            Chain { linkage, lever: times(&law, swing), m }
        },
    )
}

/// A follower behind mechanisms.
pub fn smooth() -> impl Strategy<Value = Follower> {
    chain().prop_filter("a smooth one", Chain::is_smooth).prop_map(|chain| chain.follower())
}

impl Chain {
    fn follower(&self) -> Follower {
        let turns = self.linkage.0.last().is_some_and(Mechanism::output_turns);
        Follower { m: self.m, turns, cam: self.lever.clone(), linkage: self.linkage.clone() }
    }

    /// Whether the mechanisms stay away from positions in which their output may go either way, so that values tell
    /// something.
    fn is_smooth(&self) -> bool {
        let follower = self.follower();
        let list = follower.transmission();
        list.len() == self.linkage.0.len() && list.iter().all(|extreme| extreme.transmission_angle() > 0.2)
    }

    /// The image in the x axis: all angles change their signs.
    fn mirrored(&self) -> Self {
        let link = |link: Link| Link { centre: [link.centre[0], -link.centre[1]], ..link };
        let other = |branch| if branch == Branch::Plus { Branch::Minus } else { Branch::Plus };
        let mirror = |mechanism: &Mechanism| {
            let kind = match mechanism.kind {
                Kind::Gear(gear) => Kind::Gear(gear),
                Kind::FourBar(FourBar { ground, input, coupler, output, branch }) => {
                    let [input, coupler, output] = [input, coupler, output].map(link);
                    Kind::FourBar(FourBar { ground, input, coupler, output, branch: other(branch) })
                }
                Kind::SliderCrank(SliderCrank { crank, rod, offset, slider_mass, branch }) => {
                    let [crank, rod] = [crank, rod].map(link);
                    Kind::SliderCrank(SliderCrank { crank, rod, offset: -offset, slider_mass, branch })
                }
            };
            Mechanism { kind, input_offset: -mechanism.input_offset, output_offset: 0.0 }
        };
        let linkage = centred(self.linkage.0.iter().map(mirror));
        Chain { linkage, lever: times(&self.lever, -1.0), m: self.m }
    }
}

/// The angles that are looked at, away from breakpoints of the laws.
fn angles() -> impl Iterator<Item = f64> {
    (0..29).map(|i| (0.123 + f64::from(i)) * TAU / 29.0)
}

/// The slope of `f` at 0 by central differences of order 6.
fn slope(f: impl Fn(f64) -> f64, h: f64) -> f64 {
    let d = |k: f64| f(k * h) - f(-k * h);
    (45.0 * d(1.0) - 9.0 * d(2.0) + d(3.0)) / (60.0 * h)
}

fn derivatives_are_those_of_the_values(chain: &Chain) -> Result<(), TestCaseError> {
    let follower = chain.follower();
    let last = chain.linkage.0[chain.linkage.0.len() - 1];
    for phi in angles() {
        // About φ the lever's law is its Taylor polynomial, whose own derivatives have no error.
        let [u, u1, u2, u3, u4] = follower.cam.at(phi).0;
        let lever = |x: f64| {
            let value = u + x * (u1 + x * (0.5 * u2 + x * (u3 / 6.0 + x * u4 / 24.0)));
            let slope = u1 + x * (u2 + x * (0.5 * u3 + x * u4 / 6.0));
            [value, slope, u2 + x * (u3 + 0.5 * x * u4), u3 + x * u4, u4]
        };
        // A step over which the lever turns by some hundredths of a radian.
        let fastest = [u1.abs(), u2.abs().sqrt(), u3.abs().cbrt(), u4.abs().sqrt().sqrt(), 1.0];
        let h = 2e-3 / fastest.into_iter().fold(0.0, f64::max);
        let tool = |x: f64| follower.tool(lever(x));
        let inertia = |x: f64| follower.inertia(lever(x));
        let largest = |f: &dyn Fn(f64) -> f64| (-3..=3).map(|k| f(f64::from(k) * h).abs()).fold(0.0, f64::max);
        for n in 0..3 {
            for (f, name) in [(&tool as &dyn Fn(f64) -> [f64; 5], "y"), (&inertia, "J")] {
                let (got, expected) = (f(0.0)[n + 1], slope(|x| f(x)[n], h));
                // Positions count from the offset, which has roundings of its own.
                let offset = if n == 0 { 1e-4 * last.output_offset.abs() } else { 0.0 };
                let scale = (largest(&|x| f(x)[n]) + offset) / h + largest(&|x| f(x)[n + 1]);
                prop_assert!((got - expected).abs() <= 1e-9 * scale, "{name}, order {n}, at {phi}: {got} {expected}");
            }
        }
    }
    Ok(())
}

fn there_and_back(chain: &Chain) -> Result<(), TestCaseError> {
    let mut inputs = inverse::inputs(&chain.linkage, chain.lever.at(0.0).0[0]);
    for i in 0..=1440 {
        let [lever, ..] = chain.lever.at(TAU * f64::from(i) / 1440.0).0;
        let [y, transmission] = chain.linkage.tool([lever, 1.0]);
        // Past a dead centre of the input two positions of the lever lead to one of the tool.
        let (bend, size) = (chain.linkage.tool([lever, 1.0, 0.0])[2], chain.linkage.tool([0.0, 1.0])[1].abs());
        prop_assume!(transmission.abs() > 0.2 * size && transmission.abs() > 0.1 * bend.abs());
        let back = inverse::lever_at(&chain.linkage, y, &mut inputs);
        prop_assert!(back.is_ok_and(|back| (back - lever).abs() < 1e-11), "at {i}: {back:?} instead of {lever}");
    }
    Ok(())
}

fn mirror_image(chain: &Chain) -> Result<(), TestCaseError> {
    let (one, other) = (chain.follower(), chain.mirrored().follower());
    let sign = if one.turns { -1.0 } else { 1.0 };
    for phi in angles() {
        let [y, z] = [&one, &other].map(|follower| follower.tool(follower.cam.at(phi).0));
        let [j, k] = [&one, &other].map(|follower| follower.inertia(follower.cam.at(phi).0));
        for n in 0..5 {
            let scale = y[n].abs() + y[0].abs().max(1e-3);
            prop_assert!((sign * z[n] - y[n]).abs() <= 1e-10 * scale, "order {n} at {phi}: {} {}", y[n], z[n]);
            prop_assert!(
                (j[n] - k[n]).abs() <= 1e-10 * (j[n].abs() + j[0]),
                "J, order {n} at {phi}: {} {}",
                j[n],
                k[n]
            );
        }
    }
    Ok(())
}

/// E + τ φ stays without a motor; tool, lever and J are those of the mechanisms at the angle reached.
fn energy_of_the_machine(chain: &Chain, ratio: f64, load: f64, w: f64) -> Result<(), TestCaseError> {
    let follower = chain.follower();
    let mean = angles().map(|phi| follower.inertia(follower.cam.at(phi).0)[0]).sum::<f64>() / 29.0;
    prop_assume!(mean > 1e-12);
    let (j0, tau) = (ratio * mean, 0.01 * load * (1.0 + ratio) * mean * w * w);
    let scene = json!({
        "inertia": {"constant": j0, "varying": null}, "followers": [follower], "motor": "none", "start": "given",
        "phi_start": 0.3, "w_start": w, "solver": solver(), "loads": [{"name": "", "inertia": false}],
    });
    let mut run = admitted(Run::new(("RigidMachine", scene), &[("tau", tau)]))?;
    let [energy, start] = run.all(["E", "phi"]);
    for i in 1..=20 {
        admitted(run.to(f64::from(i) * 0.1 * TAU / w.abs()))?;
        let [now, phi, speed, j] = run.all(["E", "phi", "w", "J"]);
        let scale = energy.abs() + (tau * (phi - start)).abs();
        prop_assert!((now - energy + tau * (phi - start)).abs() <= 1e-9 * scale, "{now} {energy} at {phi}");
        prop_assert!((0.5 * j * speed * speed - now).abs() <= 1e-9 * scale);
        let lever = follower.cam.at(phi.rem_euclid(TAU)).0;
        let own = j0 + follower.inertia(lever)[0];
        prop_assert!((j - own).abs() <= 1e-8 * own, "J = {j} instead of {own} at {phi}");
        let tool = follower.tool(lever);
        let size = tool[0].abs() + tool[1].abs() + 1e-9;
        prop_assert!((run.get("U[1]") - tool[0]).abs() <= 1e-8 * size, "U at {phi}");
        prop_assert!((run.get("lever[1]") - lever[0]).abs() <= 1e-8 * (1.0 + lever[1].abs()));
    }
    Ok(())
}

/// The law of the lever that makes the tool move as it does with another one.
fn law_of_the_lever(chain: &Chain) -> Result<(), TestCaseError> {
    let [low, high] = [-0.4, 0.4].map(|lever| chain.linkage.tool([lever])[0]);
    prop_assume!(low.is_finite() && high.is_finite());
    let wanted = times(&chain.lever, 0.4 * (high - low) / chain.lever.bound(0));
    match lever_law(&chain.linkage, &wanted, 0.0) {
        Ok(found) => {
            // Of short pieces roundings decide, and the error is told.
            let admitted = if matches!(found.law, MotionLaw::Fourier(_)) { 1e-9 } else { 1e-7 };
            prop_assert!(found.error <= admitted);
            let most = found.error.max(1e-9);
            let peak = (0..2000).map(|i| wanted.at(TAU * f64::from(i) / 2000.0).0[2].abs()).fold(0.0, f64::max);
            for phi in angles() {
                let [u, u1, u2, ..] = found.law.at(phi).0;
                let [y, _, y2] = chain.linkage.tool([u, u1, u2]);
                let [z, _, z2, ..] = wanted.at(phi).0;
                prop_assert!(
                    (y - z).abs() <= most * peak && (y2 - z2).abs() <= 2.0 * most * peak,
                    "{y2} {z2} at {phi}"
                );
            }
            Ok(())
        }
        Err(reason) => {
            let clear =
                ["cannot reach", "dead centre", "come back", "assembled"].iter().any(|word| reason.contains(word));
            if clear { Err(TestCaseError::reject(reason)) } else { Err(TestCaseError::fail(reason)) }
        }
    }
}

proptest! {
    #![proptest_config(config(80, 800, 21))]

    #[test]
    fn derivatives(chain in chain()) {
        prop_assume!(chain.is_smooth());
        derivatives_are_those_of_the_values(&chain)?;
    }

    #[test]
    fn the_inverse(chain in chain()) {
        prop_assume!(chain.is_smooth());
        there_and_back(&chain)?;
    }

    #[test]
    fn mirror_images_of_mechanisms(chain in chain()) {
        prop_assume!(chain.is_smooth());
        mirror_image(&chain)?;
    }

    #[test]
    fn machine_with_mechanisms_balances(
        chain in chain(), ratio in decades(-2.0, 2.0), load in -1.0..1.0_f64, w in decades(-1.0, 2.0), sign in sign()
    ) {
        prop_assume!(chain.is_smooth());
        energy_of_the_machine(&chain, ratio, load, sign * w)?;
    }

    #[test]
    fn laws_of_levers(chain in chain()) {
        prop_assume!(chain.is_smooth());
        law_of_the_lever(&chain)?;
    }
}
