//! The balance of energy at constant speed: d/dt [½ m ẏ² + ½ c q²] = tau ω − b q̇².

use super::*;
use crate::numerics::gauss::Gauss;

/// Error of E against ∫ (tau ω − b q̇²) dt over the next forty panels, as part of the energy that drive, damper and mass exchange.
/// A panel is at most 8 rad of the fastest wave and ends at the breakpoints of the law.
fn missed(drive: &mut ElasticOutput, w: f64) -> f64 {
    let (law, list) = (drive.cam().law.clone(), drive.variables());
    let get = |drive: &ElasticOutput, name: &str| named(&list, name).value(drive);
    let rate = drive.parameters.equation().oscillator.rates().1.max(law.resolution() * w.abs());
    let energy = |drive: &ElasticOutput| {
        0.5 * (drive.parameters.m * get(drive, "der(y)").powi(2) + drive.parameters.c * get(drive, "q").powi(2))
    };
    let before = energy(drive);
    let (mut work, mut exchanged) = (0.0, before);
    for _ in 0..40 {
        let start = drive.now.time;
        let ahead = law.breakpoints().iter().map(|b| ((b - (0.3 + w * start)) * w.signum()).rem_euclid(TAU));
        let length = ahead.filter(|angle| *angle > 1e-9).fold(8.0 / rate, |least, angle| least.min(angle / w.abs()));
        let [part, size] = Gauss::with(16).integrate(length, |s| {
            let mut there = drive.clone();
            there.advance(start, s).unwrap();
            let power = get(&there, "tau") * w - there.parameters.b * get(&there, "der(q)").powi(2);
            [power, power.abs()]
        });
        drive.advance(start, length).unwrap();
        (work, exchanged) = (work + part, exchanged + size);
    }
    (energy(drive) - before - work).abs() / exchanged
}

#[test]
fn the_balance_closes_in_closed_form_and_on_the_table() {
    let cycle = |law| {
        MotionLaw::Cycle(Cycle::new(CyclePlan {
            stroke: 0.1,
            lower: 0.0,
            rise_start: 0.4,
            rise_angle: 2.0,
            upper_dwell: 1.0,
            return_angle: 1.7,
            rise_law: law,
            return_law: law,
            inflections: [None; 2],
        }))
    };
    for cam in [MotionLaw::Fourier(series()), cycle(ModifiedSine), cycle(Polynomial345)] {
        for (mcb, w) in
            [([2.0, 1.3e5, 20.0], 50.0), ([2.0, 1.3e5, 0.0], -50.0), ([0.1, 1e3, 1e3], 30.0), ([2.0, 1.3e9, 1.0], 5.0)]
        {
            let drive = &mut drive(scene(mcb, cam.clone(), DriveMode::Constant { w, phi_start: 0.3 }, given()));
            for stop in [0.0, 0.0437, 0.29] {
                run(drive, drive.now.time + stop, 0.0437);
                let missing = missed(drive, w);
                assert!(missing < 1e-11, "{mcb:?} {w} from {stop} s: {missing:e}");
            }
        }
    }
}
