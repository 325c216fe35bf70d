//! The dimensions and masses of a mechanism as a numbered list, which scenes and the FMU's parameters share.

use super::{FourBar, Gear, Kind, Link, Mechanism, SliderCrank};
use crate::drives::unit::{self, Quantity};

/// Kind of a parameter, which determines its range.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ParameterKind {
    /// A length of a link (m).
    Length,
    /// A coordinate (m).
    Coordinate,
    /// An angle (rad).
    Angle,
    /// A mass (kg).
    Mass,
    /// A moment of inertia (kg·m²).
    Inertia,
    /// A ratio of angles.
    Ratio,
    /// The radius of a pinion (m).
    Radius,
}

/// The longest link and the greatest coordinate (m).
pub const LONGEST: f64 = 1e4;
/// The shortest link (m).
pub const SHORTEST: f64 = 1e-6;
/// The greatest angle (rad) and the greatest ratio.
pub const LARGEST: f64 = 1e4;
/// The greatest mass (kg) and moment of inertia (kg·m²).
pub const HEAVIEST: f64 = 1e9;

impl ParameterKind {
    /// The least and the greatest value.
    pub const fn range(self) -> [f64; 2] {
        match self {
            ParameterKind::Length => [SHORTEST, LONGEST],
            ParameterKind::Coordinate | ParameterKind::Radius => [-LONGEST, LONGEST],
            ParameterKind::Angle | ParameterKind::Ratio => [-LARGEST, LARGEST],
            ParameterKind::Mass | ParameterKind::Inertia => [0.0, HEAVIEST],
        }
    }

    /// Its quantity.
    pub const fn quantity(self) -> &'static Quantity {
        match self {
            ParameterKind::Angle => &unit::ANGLE,
            ParameterKind::Mass => &unit::MASS,
            ParameterKind::Inertia => &unit::INERTIA,
            ParameterKind::Ratio => &unit::NUMBER,
            ParameterKind::Length | ParameterKind::Coordinate | ParameterKind::Radius => &unit::LENGTH,
        }
    }

    /// Whether a scene must contain it; optional ones are zero or follow from the rest.
    pub fn is_required(self) -> bool {
        matches!(self, ParameterKind::Length | ParameterKind::Ratio | ParameterKind::Radius)
    }

    /// Whether zero is excluded from its range.
    pub fn is_ratio(self) -> bool {
        matches!(self, ParameterKind::Ratio | ParameterKind::Radius)
    }

    pub(super) fn admits(self, value: f64) -> bool {
        let [least, greatest] = self.range();
        value >= least && value <= greatest && !(self.is_ratio() && value == 0.0)
    }

    pub(super) fn admissible(self) -> String {
        let [least, greatest] = self.range();
        let not_zero = if self.is_ratio() { ", not 0" } else { "" };
        format!("{least:e} to {greatest:e}{not_zero}")
    }
}

/// A parameter of a mechanism.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameter {
    /// Its link, a table in scenes; None for a parameter of the mechanism itself.
    pub link: Option<&'static str>,
    /// Its key there.
    pub key: &'static str,
    /// Its meaning.
    text: &'static str,
    /// Unit and range.
    pub kind: ParameterKind,
}

impl Parameter {
    /// The mass of a follower's tool, or the moment of inertia of one that turns.
    pub fn mass(turns: bool) -> Self {
        let (key, text, kind) = match turns {
            true => ("J", "Moment of inertia", ParameterKind::Inertia),
            false => ("m", "Mass", ParameterKind::Mass),
        };
        Parameter { link: None, key, text, kind }
    }

    /// Its name, the same in scenes and in the FMU: `coupler.length`.
    pub fn name(&self) -> String {
        self.link.map_or(self.key.to_owned(), |link| format!("{link}.{}", self.key))
    }

    /// Its meaning.
    pub fn text(&self) -> String {
        let Some((first, rest)) = self.link.map(|link| link.split_at(1)) else { return self.text.to_owned() };
        format!("{}{rest} link: {}", first.to_uppercase(), self.text)
    }
}

/// A parameter and its value.
type Entry<'a> = (Parameter, &'a mut f64);

fn own<'a>(key: &'static str, text: &'static str, kind: ParameterKind, value: &'a mut f64) -> Entry<'a> {
    (Parameter { link: None, key, text, kind }, value)
}

impl Link {
    fn entries(&mut self, link: &'static str) -> [Entry<'_>; 5] {
        let [x, y] = &mut self.centre;
        [
            own("length", "Distance of the joints", ParameterKind::Length, &mut self.length),
            own("m", "Mass", ParameterKind::Mass, &mut self.mass),
            own("J", "Moment of inertia about the centre of mass", ParameterKind::Inertia, &mut self.inertia),
            own("x", "Centre of mass along the link, from its first joint", ParameterKind::Coordinate, x),
            own("y", "Centre of mass to the left of the link", ParameterKind::Coordinate, y),
        ]
        .map(|(parameter, value)| (Parameter { link: Some(link), ..parameter }, value))
    }
}

impl Mechanism {
    /// No list on the heap: importers read parameters between steps.
    fn entries(&mut self) -> impl Iterator<Item = Entry<'_>> {
        let output = if self.output_turns() { ParameterKind::Angle } else { ParameterKind::Coordinate };
        let Mechanism { kind, input_offset, output_offset } = self;
        let of_input = "Input angle of the mechanism at the zero of its driver";
        let of_output = "Output of the mechanism at the zero of the driven part";
        let offsets = [
            own("input_offset", of_input, ParameterKind::Angle, input_offset),
            own("output_offset", of_output, output, output_offset),
        ];
        let (others, links) = match kind {
            Kind::FourBar(FourBar { ground, input, coupler, output, .. }) => (
                [Some(own("ground", "Distance of the pivots", ParameterKind::Length, ground)), None],
                [Some(input.entries("input")), Some(coupler.entries("coupler")), Some(output.entries("output"))],
            ),
            Kind::SliderCrank(SliderCrank { crank, rod, offset, slider_mass, .. }) => (
                [
                    Some(own("offset", "Offset of the slider's line", ParameterKind::Coordinate, offset)),
                    Some(own("slider_m", "Mass of the slider", ParameterKind::Mass, slider_mass)),
                ],
                [Some(crank.entries("crank")), Some(rod.entries("rod")), None],
            ),
            Kind::Gear(Gear { ratio, inertia, output_turns }) => {
                let ratio = match output_turns {
                    true => own("ratio", "Output angle per input angle", ParameterKind::Ratio, ratio),
                    false => own("radius", "Output per input angle", ParameterKind::Radius, ratio),
                };
                let text = "Moment of inertia of all parts that turn with the input";
                ([Some(ratio), Some(own("J", text, ParameterKind::Inertia, inertia))], [None, None, None])
            }
        };
        offsets.into_iter().chain(others.into_iter().flatten()).chain(links.into_iter().flatten().flatten())
    }

    /// The list of parameters.
    pub fn parameters(mut self) -> Vec<Parameter> {
        self.entries().map(|(parameter, _)| parameter).collect()
    }

    /// The parameter with this index in [`Mechanism::parameters`].
    pub fn parameter_mut(&mut self, index: usize) -> Option<&mut f64> {
        self.entries().nth(index).map(|(_, value)| value)
    }
}
