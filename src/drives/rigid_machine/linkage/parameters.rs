//! The dimensions and masses of a mechanism as a numbered list, which scenes and the FMU's parameters share.

use super::{Kind, Link, Mechanism};

/// What a parameter is and which values it may have.
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
    pub fn range(self) -> [f64; 2] {
        match self {
            ParameterKind::Length => [SHORTEST, LONGEST],
            ParameterKind::Coordinate | ParameterKind::Radius => [-LONGEST, LONGEST],
            ParameterKind::Angle | ParameterKind::Ratio => [-LARGEST, LARGEST],
            ParameterKind::Mass | ParameterKind::Inertia => [0.0, HEAVIEST],
        }
    }

    pub(super) fn admits(self, value: f64) -> bool {
        let [least, greatest] = self.range();
        let not_zero = matches!(self, ParameterKind::Ratio | ParameterKind::Radius);
        value >= least && value <= greatest && !(not_zero && value == 0.0)
    }

    pub(super) fn admissible(self) -> String {
        let [least, greatest] = self.range();
        let not_zero = if matches!(self, ParameterKind::Ratio | ParameterKind::Radius) { ", not 0" } else { "" };
        format!("{least:e} … {greatest:e}{not_zero}")
    }
}

/// A parameter of a mechanism.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameter {
    /// Its name, the same in scenes and in the FMU: `coupler.length`.
    pub name: String,
    /// What it is.
    pub text: String,
    /// Unit and range.
    pub kind: ParameterKind,
}

/// Parameters of a link.
const LINK: [(&str, &str, ParameterKind); 5] = [
    ("length", "Distance of the joints", ParameterKind::Length),
    ("m", "Mass", ParameterKind::Mass),
    ("J", "Moment of inertia about the centre of mass", ParameterKind::Inertia),
    ("x", "Centre of mass along the link, from its first joint", ParameterKind::Coordinate),
    ("y", "Centre of mass to the left of the link", ParameterKind::Coordinate),
];

/// Parameters of every mechanism: their number, before those of its kind.
const OFFSETS: usize = 2;

impl Link {
    fn parameter_mut(&mut self, index: usize) -> Option<&mut f64> {
        match index {
            0 => Some(&mut self.length),
            1 => Some(&mut self.mass),
            2 => Some(&mut self.inertia),
            3 | 4 => self.centre.get_mut(index - 3),
            _ => None,
        }
    }
}

impl Mechanism {
    /// The list of parameters.
    pub fn parameters(&self) -> Vec<Parameter> {
        let own = |name: &str, text: &str, kind| Parameter { name: name.to_owned(), text: text.to_owned(), kind };
        let output = if self.output_turns() { ParameterKind::Angle } else { ParameterKind::Coordinate };
        let mut list = vec![
            own("input_offset", "Input angle of the mechanism at the zero of what drives it", ParameterKind::Angle),
            own("output_offset", "Output of the mechanism at the zero of what it drives", output),
        ];
        let links = |names: &[&str]| {
            let of = |link: &str| {
                let (start, rest) = link.split_at(1);
                let described = format!("{}{rest} link: ", start.to_uppercase());
                LINK.map(|(name, text, kind)| own(&format!("{link}.{name}"), &(described.clone() + text), kind))
            };
            names.iter().flat_map(|link| of(link)).collect::<Vec<_>>()
        };
        match self.kind {
            Kind::FourBar(_) => {
                list.push(own("ground", "Distance of the pivots", ParameterKind::Length));
                list.extend(links(&["input", "coupler", "output"]));
            }
            Kind::SliderCrank(_) => {
                list.push(own("offset", "Offset of the slider's line", ParameterKind::Coordinate));
                list.push(own("slider_m", "Mass of the slider", ParameterKind::Mass));
                list.extend(links(&["crank", "rod"]));
            }
            Kind::Gear(gear) if gear.output_turns => {
                list.push(own("ratio", "Output angle per input angle", ParameterKind::Ratio));
                list.push(own("J", "Moment of inertia of what turns with the input", ParameterKind::Inertia));
            }
            Kind::Gear(_) => {
                list.push(own("radius", "Output per input angle", ParameterKind::Radius));
                list.push(own("J", "Moment of inertia of what turns with the input", ParameterKind::Inertia));
            }
        }
        list
    }

    /// The parameter with this index in [`Mechanism::parameters`].
    pub fn parameter_mut(&mut self, index: usize) -> Option<&mut f64> {
        match (index, &mut self.kind) {
            (0, _) => Some(&mut self.input_offset),
            (1, _) => Some(&mut self.output_offset),
            (_, Kind::FourBar(linkage)) => match index - OFFSETS {
                0 => Some(&mut linkage.ground),
                i => {
                    let links = [&mut linkage.input, &mut linkage.coupler, &mut linkage.output];
                    let mut links = links.into_iter();
                    links.nth((i - 1) / LINK.len())?.parameter_mut((i - 1) % LINK.len())
                }
            },
            (_, Kind::SliderCrank(linkage)) => match index - OFFSETS {
                0 => Some(&mut linkage.offset),
                1 => Some(&mut linkage.slider_mass),
                i => {
                    let mut links = [&mut linkage.crank, &mut linkage.rod].into_iter();
                    links.nth((i - 2) / LINK.len())?.parameter_mut((i - 2) % LINK.len())
                }
            },
            (_, Kind::Gear(gear)) => match index - OFFSETS {
                0 => Some(&mut gear.ratio),
                1 => Some(&mut gear.inertia),
                _ => None,
            },
        }
    }
}
