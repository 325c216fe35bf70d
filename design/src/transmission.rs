//! The least transmission angles of the mechanisms between cam and tool.
//!
//! μ is the angle between coupler and output link of a four-bar linkage, or between rod and the normal of the slider's line. At
//! 90° the whole force of the coupler moves the output; towards 0 forces in the joints and the effect of play grow like 1/sin
//! μ.
//!
//! Source: VDI 2130 (four-bar linkages), which takes the least transmission angle as the measure of quality; J. Volmer (ed.),
//! *Getriebetechnik*: at least 40°, with high speeds 50°.

use camdrive::drives::rigid_machine::Follower;
use camdrive::drives::rigid_machine::linkage::{decimals, in_turn};
use serde::Serialize;
use std::f64::consts::PI;

/// The usual least transmission angle (rad).
pub const USUAL: f64 = 40.0 * PI / 180.0;

/// A mechanism at its least transmission angle over the turn.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Transmission {
    /// The number of the follower, from 1.
    pub follower: usize,
    /// The number of the mechanism, from 1.
    pub mechanism: usize,
    /// Its kind.
    pub kind: &'static str,
    /// μ (rad).
    pub least_angle: f64,
    /// φ (rad).
    pub phi: f64,
}

impl Transmission {
    /// True if the angle is as large as usual.
    pub fn is_usual(&self) -> bool {
        self.least_angle >= USUAL
    }

    /// The name of the measured angle.
    pub fn what(&self) -> String {
        format!("least transmission angle of linkage[{}] ({})", self.mechanism, self.kind)
    }

    /// Its assessment.
    pub fn remark(&self) -> String {
        let usual = USUAL.to_degrees();
        if self.is_usual() {
            return format!("at least {usual:.0}° is usual");
        }
        format!(
            "below the usual {usual:.0}°: forces in the joints and the effect of play are large; choose other lengths or offsets"
        )
    }

    /// The finding as a sentence.
    pub fn sentence(&self) -> String {
        let (mind, decimals) = if self.is_usual() { ("", 1) } else { ("Note: ", 2) };
        let (degrees, phi) = (self.least_angle.to_degrees(), in_turn(self.phi, 1));
        format!(
            "{mind}Follower {}: {} {degrees:.decimals$}° at φ = {phi}° ({}).",
            self.follower,
            self.what(),
            self.remark()
        )
    }
}

/// The least transmission angles of the mechanisms of a follower; gears have none.
pub fn of(number: usize, follower: &Follower) -> Vec<Transmission> {
    let mechanisms = follower.linkage.0.iter().zip(follower.transmission()).enumerate();
    mechanisms
        .filter(|(_, (mechanism, _))| mechanism.has_transmission_angle())
        .map(|(i, (mechanism, extreme))| Transmission {
            follower: number,
            mechanism: i + 1,
            kind: mechanism.name(),
            least_angle: extreme.transmission_angle(),
            phi: extreme.phi,
        })
        .collect()
}

/// The limits that they set to a machine with these followers, for its documentation.
pub fn limits(followers: &[Follower]) -> Vec<String> {
    let all = followers.iter().enumerate().flat_map(|(j, follower)| of(j + 1, follower));
    let limit = |least: Transmission| {
        let (phi, angle) = (in_turn(least.phi, 1), decimals(least.least_angle.to_degrees(), 2));
        format!(
            "follower[{}].linkage[{}] ({}): with the values of the scene the transmission angle is least at φ = {phi}°, \
             {angle}°; at least 40° is usual.",
            least.follower, least.mechanism, least.kind
        )
    };
    all.map(limit).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use camdrive::drives::rigid_machine::linkage::{Branch, FourBar, Gear, Kind, Link, Linkage, Mechanism};
    use camdrive::motion::{Fourier, MotionLaw};

    #[test]
    fn the_least_transmission_angle_of_a_crank_rocker() {
        // A lever that swings by ±1 rad about 0: cos μ = (b² + c² − |g − a e^{iθ}|²)/(2bc) is extreme at θ = 0 and ±1.
        let bar = |length| Link { length, ..Link::default() };
        let [g, a, b, c] = [0.1_f64, 0.03, 0.08, 0.06];
        let kind =
            Kind::FourBar(FourBar { ground: g, input: bar(a), coupler: bar(b), output: bar(c), branch: Branch::Plus });
        let gear = Kind::Gear(Gear { ratio: 1.0, inertia: 0.0, output_turns: true });
        let part = |kind| Mechanism { kind, input_offset: 0.0, output_offset: 0.0 };
        let cam = MotionLaw::Fourier(Fourier::new(vec![0.0], vec![0.0, 1.0]));
        let follower = Follower { m: 1.0, turns: true, cam, linkage: Linkage(vec![part(gear), part(kind)]) };
        let cosine = |theta: f64| (b * b + c * c - g * g - a * a + 2.0 * g * a * theta.cos()) / (2.0 * b * c);
        let list = of(3, &follower);
        assert_eq!((list.len(), list[0].follower, list[0].mechanism), (1, 3, 2));
        let (folded, swung) = (cosine(0.0).acos(), cosine(1.0).acos());
        let least = folded.min(PI - folded).min(swung).min(PI - swung);
        assert!((list[0].least_angle - least).abs() < 1e-12 && list[0].is_usual());
        let at = list[0].phi.sin();
        assert!(((cosine(at).acos()) - folded).abs() < 1e-9, "{at}");
        let expected = format!("least transmission angle of linkage[2] (four-bar linkage) {:.1}°", least.to_degrees());
        assert!(list[0].sentence().contains(&expected), "{}", list[0].sentence());
        let poor = Transmission { least_angle: 0.5, phi: -1e-9, ..list[0].clone() };
        assert!(poor.sentence().starts_with("Note: Follower 3: ") && poor.sentence().contains("28.65° at φ = 0.0°"));
    }
}
