//! Plane mechanisms in series between the lever that a cam moves and the tool.
//!
//! θ₁ = χ + offset → f₁ → θ₂ → f₂ → … → y, and the moment of inertia of tool and links with respect to the variable of χ,
//!
//! J = m y′² + Σ (m_i |r_i′|² + J_i β_i′²).
//!
//! Symbols: χ angle of the lever (rad); θ input angle of a mechanism (rad); y coordinate of the tool (m or rad); m mass of the tool
//! (kg), or its moment of inertia (kg·m²) if it turns; m_i, J_i, r_i, β_i mass, moment of inertia about the centre of mass, centre
//! of mass and angle of link i.
//!
//! Each mechanism is evaluated in closed form for power series ([`Series`]), so that derivatives with respect to the angle of
//! the main shaft, to time or to the lever's angle are exact to any order. Angles are continuous: an output that turns right
//! round with its input goes on beyond 180°. Valid for rigid links away from positions where the output may go either way
//! ([`Linkage::check`]).
//!
//! Source: VDI 2143 (transfer functions); Dresig, Holzweißig, *Maschinendynamik*, section 2.2 (reduced moment of inertia);
//! the closed forms are derived here.

mod check;
mod four_bar;
mod gear;
mod parameters;
mod slider_crank;
#[cfg(test)]
mod tests;

pub use check::{Extreme, in_turn};
pub use four_bar::FourBar;
pub use gear::Gear;
pub use parameters::{Parameter, ParameterKind};
pub use slider_crank::SliderCrank;

use crate::numerics::taylor::Series;
use serde::{Deserialize, Serialize};

/// A rigid link that moves in the plane.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Link {
    /// The distance of its joints (m).
    pub length: f64,
    /// m (kg).
    pub mass: f64,
    /// J about the centre of mass (kg·m²).
    pub inertia: f64,
    /// The centre of mass (m): from the first joint along the line to the second one, and to the left of it.
    pub centre: [f64; 2],
}

/// Sums over the links of a mechanism.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Links<const N: usize> {
    /// Σ m |r′|² + J β′² (kg·m²).
    pub inertia: Series<N>,
    /// Σ m r (kg·m).
    pub moment: [Series<N>; 2],
}

impl<const N: usize> Links<N> {
    fn none() -> Self {
        Links { inertia: Series::from(0.0), moment: [Series::from(0.0); 2] }
    }

    /// Adds a link whose first joint is at `joint`, with the line to its second one in the direction (cos β, sin β).
    fn with(mut self, link: &Link, [x, y]: [Series<N>; 2], [cos, sin]: [Series<N>; 2]) -> Self {
        if link.mass == 0.0 && link.inertia == 0.0 {
            return self;
        }
        let [xi, eta] = link.centre;
        let centre = [x + cos * xi - sin * eta, y + sin * xi + cos * eta];
        let [vx, vy] = centre.map(Series::slope);
        let turn = cos * sin.slope() - sin * cos.slope();
        self.inertia = self.inertia + ((vx * vx + vy * vy) * link.mass + turn * turn * link.inertia);
        self.moment = [0, 1].map(|i| self.moment[i] + centre[i] * link.mass);
        self
    }
}

/// Selects one of the two positions of a mechanism.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Branch {
    /// The sign + before the root.
    #[default]
    Plus,
    /// The sign −.
    Minus,
}

impl Branch {
    /// ±1.
    pub fn sign(self) -> f64 {
        match self {
            Branch::Plus => 1.0,
            Branch::Minus => -1.0,
        }
    }
}

/// One mechanism: output + output offset = f(input + input offset).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Mechanism {
    /// f.
    pub kind: Kind,
    /// The input angle θ (rad) of the mechanism at input zero.
    pub input_offset: f64,
    /// The output (rad or m) of the mechanism at output zero.
    pub output_offset: f64,
}

/// The kinds of mechanisms.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Kind {
    /// A four-bar linkage.
    FourBar(FourBar),
    /// A slider-crank.
    SliderCrank(SliderCrank),
    /// A gear pair, a belt, or rack and pinion.
    Gear(Gear),
}

impl Mechanism {
    /// Output and links for this input.
    pub fn moved<const N: usize>(&self, input: Series<N>) -> (Series<N>, Links<N>) {
        let theta = input + self.input_offset;
        let (output, links) = match &self.kind {
            Kind::FourBar(linkage) => linkage.moved(theta),
            Kind::SliderCrank(linkage) => linkage.moved(theta),
            Kind::Gear(gear) => gear.moved(theta),
        };
        (output + -self.output_offset, links)
    }

    /// The name of its kind.
    pub fn name(&self) -> &'static str {
        match self.kind {
            Kind::FourBar(_) => "four-bar linkage",
            Kind::SliderCrank(_) => "slider-crank",
            Kind::Gear(_) => "gear",
        }
    }

    /// Nominal work (µs), see [`crate::numerics::work`], for output and links to the fourth derivative, and to the highest order of
    /// a train. These are processor times of an optimised build: a four-bar linkage took 0.35 and 38 µs on a computer where a
    /// nominal microsecond takes 2.5. The series of ψ takes a pass for each order.
    pub fn cost(&self) -> [f64; 2] {
        match self.kind {
            Kind::FourBar(_) => [0.15, 15.0],
            Kind::SliderCrank(_) => [0.05, 1.5],
            Kind::Gear(_) => [0.005, 0.1],
        }
    }

    /// Whether the output is an angle.
    pub fn output_turns(&self) -> bool {
        match self.kind {
            Kind::FourBar(_) => true,
            Kind::SliderCrank(_) => false,
            Kind::Gear(gear) => gear.output_turns,
        }
    }
}

/// The mechanisms between lever and tool, from the cam to the tool; empty if the cam moves the tool itself.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Linkage(pub Vec<Mechanism>);

/// The tool's motion and inertia.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ToolMotion<const N: usize> {
    /// y.
    pub tool: Series<N>,
    /// J, known to one order less than y.
    pub inertia: Series<N>,
    /// Σ m g·r of the links (J), g in the frame of each mechanism.
    pub weight: Series<N>,
}

impl Linkage {
    /// Whether the cam moves the tool itself.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Nominal work of all mechanisms, see [`Mechanism::cost`].
    pub fn cost(&self) -> [f64; 2] {
        self.0.iter().map(Mechanism::cost).fold([0.0; 2], |sum, own| [sum[0] + own[0], sum[1] + own[1]])
    }

    /// Tool and inertia moved by the lever's angle χ (or by the tool itself without mechanisms) for a tool of mass `m`, and the
    /// links' weight with g (m/s²) in these `frames`. The values are NaN if a mechanism cannot be assembled.
    pub fn moved<const N: usize>(&self, m: f64, lever: Series<N>, frames: &[[f64; 2]]) -> ToolMotion<N> {
        let (mut y, mut inertia, mut weight) = (lever, Series::from(0.0), Series::from(0.0));
        for (i, mechanism) in self.0.iter().enumerate() {
            let (output, own) = mechanism.moved(y);
            (y, inertia) = (output, inertia + own.inertia);
            if let Some([gx, gy]) = frames.get(i) {
                weight = weight + own.moment[0] * *gx + own.moment[1] * *gy;
            }
        }
        let slope = y.slope();
        ToolMotion { tool: y, inertia: inertia + slope * slope * m, weight }
    }

    /// The tool's coordinate alone and its derivatives.
    pub fn tool<const N: usize>(&self, lever: [f64; N]) -> [f64; N] {
        if self.is_empty() { lever } else { self.moved(0.0, Series::of_derivatives(lever), &[]).tool.derivatives() }
    }
}

/// A number with so many decimals; zero has no sign.
pub fn decimals(value: f64, digits: usize) -> String {
    let text = format!("{value:.digits$}");
    match text.strip_prefix('-') {
        Some(size) if size.bytes().all(|c| matches!(c, b'0' | b'.')) => size.to_owned(),
        _ => text,
    }
}

/// arccos without its loss of half of the digits near ±1; None beyond.
pub fn arccos(x: f64) -> Option<f64> {
    (x.abs() <= 1.0).then(|| ((1.0 - x) * (1.0 + x)).sqrt().atan2(x))
}
