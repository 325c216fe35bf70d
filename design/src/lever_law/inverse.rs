//! From the tool back to the lever.

use camdrive::drives::rigid_machine::linkage::{FourBar, Kind, Linkage, Mechanism, SliderCrank, arccos};
use camdrive::numerics::taylor::Series;
use std::f64::consts::TAU;

/// A transmission below this part of the mechanism's usual one is a dead centre of the input: the inverse has no derivatives
/// there.
const DEAD: f64 = 1e-3;

/// The reason why no position of the lever yields a position of the tool.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Obstacle {
    /// No input of this mechanism, counted from 0, yields this output (rad or m).
    OutOfReach {
        /// The mechanism.
        mechanism: usize,
        /// Its output, from its offset on.
        output: f64,
    },
    /// The input of this mechanism is at a dead centre, from which it cannot drive on.
    DeadCentre {
        /// The mechanism.
        mechanism: usize,
        /// Its output, from its offset on.
        output: f64,
    },
}

/// The input of a mechanism that yields an output, the one closest to `near`, if any.
fn input_at(mechanism: &Mechanism, output: f64, near: f64) -> Option<f64> {
    let (output, near) = (output + mechanism.output_offset, near + mechanism.input_offset);
    let theta = match &mechanism.kind {
        Kind::FourBar(linkage) => of_four_bar(linkage, output, near),
        Kind::SliderCrank(linkage) => of_slider_crank(linkage, output, near),
        Kind::Gear(gear) => Some(output / gear.ratio),
    };
    theta.map(|theta| theta - mechanism.input_offset)
}

/// The θ that yields ψ on this branch, the one closest to `near`.
fn of_four_bar(linkage: &FourBar, psi: f64, near: f64) -> Option<f64> {
    let (g, a, b, c) = (linkage.ground, linkage.input.length, linkage.coupler.length, linkage.output.length);
    let (sin, cos) = psi.sin_cos();
    let (x, y) = (g + c * cos, c * sin);
    let reach = (x * x + y * y).sqrt();
    let side = arccos((a * a + reach * reach - b * b) / (2.0 * a * reach))?;
    let on_branch = |theta: f64| {
        let (angle, _) = linkage.diagonal(theta);
        ((psi - angle).sin() * linkage.branch.sign() >= 0.0).then_some(theta)
    };
    [side, -side]
        .into_iter()
        .filter_map(|side| {
            let theta = nearest(on_branch(y.atan2(x) + side)?, near);
            // An output that turns with the input determines the turn.
            let turns = if a < g { 0.0 } else { psi - linkage.position(theta).unwrap_or(psi) };
            Some(nearest(theta, theta + turns))
        })
        .min_by(|s, t| (s - near).abs().total_cmp(&(t - near).abs()))
}

/// The θ that yields s on this branch, the one closest to `near`.
fn of_slider_crank(linkage: &SliderCrank, s: f64, near: f64) -> Option<f64> {
    let (r, l, e) = (linkage.crank.length, linkage.rod.length, linkage.offset);
    // The triangle of pivot, crank pin and slider.
    let reach = (s * s + e * e).sqrt();
    let side = arccos((r * r + reach * reach - l * l) / (2.0 * r * reach))?;
    [side, -side]
        .into_iter()
        .map(|side| nearest(e.atan2(s) + side, near))
        .filter(|theta| (s - r * theta.cos()) * linkage.branch.sign() >= 0.0)
        .min_by(|a, b| (a - near).abs().total_cmp(&(b - near).abs()))
}

/// The angle within half a turn of `near` that differs by whole turns.
fn nearest(angle: f64, near: f64) -> f64 {
    angle + TAU * ((near - angle) / TAU).round()
}

/// The usual transmission for the lengths of a mechanism.
fn usual_slope(mechanism: &Mechanism) -> f64 {
    match &mechanism.kind {
        Kind::FourBar(linkage) => linkage.input.length / linkage.output.length,
        Kind::SliderCrank(linkage) => linkage.crank.length,
        Kind::Gear(gear) => gear.ratio.abs(),
    }
}

/// The inputs of all mechanisms for this angle of the lever (rad); NaN after one that cannot be assembled.
pub fn inputs(linkage: &Linkage, lever: f64) -> Vec<f64> {
    let mut input = Series([lever]);
    let mut inputs = Vec::with_capacity(linkage.0.len());
    for mechanism in &linkage.0 {
        inputs.push(input.value());
        input = mechanism.moved(input).0;
    }
    inputs
}

/// The lever's angle that yields the tool's coordinate, in the position next to the one with these `inputs`, which are updated.
///
/// # Errors
/// Without such an angle, or with a mechanism at a dead centre.
pub fn lever_at(linkage: &Linkage, tool: f64, inputs: &mut [f64]) -> Result<f64, Obstacle> {
    let mut output = tool;
    for (i, (mechanism, near)) in linkage.0.iter().zip(inputs).enumerate().rev() {
        let out_of_reach = Obstacle::OutOfReach { mechanism: i, output };
        let input = input_at(mechanism, output, *near).ok_or(out_of_reach)?;
        let [found, slope] = mechanism.moved(Series([input, 1.0])).0.derivatives();
        // A slope of NaN counts as none, too.
        if !(slope.abs() >= DEAD * usual_slope(mechanism)) {
            return Err(Obstacle::DeadCentre { mechanism: i, output });
        }
        // The same angle, but whole turns away from the mechanism's motion on this branch.
        let correction = (output - found) / slope;
        if !(correction.abs() <= 1.0) {
            return Err(out_of_reach);
        }
        // Restores the digits that the closed form loses at a steep arccos.
        output = input + correction;
        *near = output;
    }
    Ok(output)
}

#[cfg(test)]
mod tests {
    use super::super::tests::chain;
    use super::*;
    use camdrive::drives::rigid_machine::linkage::Branch;

    fn moved(linkage: &Linkage, lever: f64) -> f64 {
        linkage.tool([lever])[0]
    }

    #[test]
    fn the_way_back_of_a_mechanism_is_the_one_nearby() {
        let [Kind::FourBar(rocker), Kind::SliderCrank(slider)] = [1, 2].map(|i| chain().0[i].kind) else { panic!() };
        let mut turning = rocker;
        // The input link is longer than the distance of the pivots: both links turn right round.
        for (length, link) in [0.03, 0.09, 0.08, 0.07].into_iter().zip([
            &mut turning.ground,
            &mut turning.input.length,
            &mut turning.coupler.length,
            &mut turning.output.length,
        ]) {
            *link = length;
        }
        for branch in [Branch::Plus, Branch::Minus] {
            let kinds = [
                Kind::FourBar(FourBar { branch, ..rocker }),
                Kind::FourBar(FourBar { branch, ..turning }),
                Kind::SliderCrank(SliderCrank { branch, ..slider }),
            ];
            for kind in kinds {
                let one = Mechanism { kind, input_offset: 0.0, output_offset: 0.0 };
                // Three turns.
                for i in 0..300 {
                    let theta = TAU * f64::from(i) / 100.0;
                    let f = moved(&Linkage(vec![one]), theta);
                    let back = input_at(&one, f, theta + 0.1).unwrap();
                    let again = moved(&Linkage(vec![one]), back);
                    assert!((again - f).abs() < 1e-14 * (1.0 + f.abs()), "{kind:?} {theta} {back} {f} {again}");
                }
            }
        }
    }

    #[test]
    fn a_chain_backwards() {
        let chain = chain();
        let mut there = inputs(&chain, -0.6);
        for i in 0..=60 {
            let lever = -0.6 + 0.02 * f64::from(i);
            let back = lever_at(&chain, moved(&chain, lever), &mut there).unwrap();
            assert!((back - lever).abs() < 1e-14, "{lever}: {back}");
            assert_eq!(there[0], back);
        }
        assert!(matches!(lever_at(&chain, 5.0, &mut there), Err(Obstacle::OutOfReach { mechanism: 2, .. })));
        // The dead centre of a centric slider-crank.
        let Kind::SliderCrank(slider) = chain.0[2].kind else { panic!() };
        let kind = Kind::SliderCrank(SliderCrank { offset: 0.0, ..slider });
        let centric = Linkage(vec![Mechanism { kind, input_offset: 0.0, output_offset: 0.0 }]);
        assert!(matches!(lever_at(&centric, 0.21, &mut [0.1]), Err(Obstacle::DeadCentre { mechanism: 0, .. })));
    }
}
