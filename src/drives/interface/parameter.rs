//! The numbers of a drive that are keys of its scene and parameters of its FMU. Each is declared once; the scene's reader, the
//! variables and their documentation follow from it.

use super::unit::Quantity;
use super::variable::{Get, Kind, Set, Variability};
use super::{List, Variable};

/// A number with its key in the scene and its name in the FMU.
pub struct Parameter<P: 'static> {
    /// The name in the FMU.
    pub name: &'static str,
    /// The key in its section of the scene.
    pub key: &'static str,
    /// One sentence.
    pub text: &'static str,
    /// Quantity and unit.
    pub quantity: &'static Quantity,
    /// The admissible range, borders included.
    pub range: [f64; 2],
    /// The value if the scene leaves it out; None if the scene must contain it.
    pub default: Option<f64>,
    /// Usual magnitude.
    pub nominal: Option<f64>,
    /// Fixed or tunable.
    pub variability: Variability,
    /// Reads the value.
    pub get: fn(&P) -> f64,
    /// Writes the value.
    pub set: fn(&mut P, f64),
}

/// A group of parameters.
pub trait Parameters: Sized + 'static {
    /// The section of the scene that holds them.
    const SECTION: &'static str;
    /// The parameters in the order of their value references.
    const TABLE: &'static [Parameter<Self>];
}

/// A drive with such a group.
pub trait Has<P> {
    /// The group; None if the scene has none.
    fn group(&self) -> Option<&P>;
    /// The group, to change it.
    fn group_mut(&mut self) -> Option<&mut P>;
}

/// The declaration of a number, whatever it belongs to.
pub struct Number {
    /// The name in the FMU.
    pub name: &'static str,
    /// Section and key.
    pub key: String,
    text: &'static str,
    kind: Kind,
    variability: Variability,
}

impl Number {
    /// The declaration of a parameter in this section.
    #[inline(never)]
    pub fn of<P>(section: &str, p: &Parameter<P>) -> Self {
        let Parameter { name, quantity, range: [min, max], nominal, variability, .. } = *p;
        let kind = Kind::Real { quantity, min, max, nominal };
        Number { name, key: format!("{section}.{}", p.key), text: p.text.trim_start(), kind, variability }
    }

    /// The declarations of a whole group.
    pub fn all<P: Parameters>(_: Option<&P>) -> Vec<Self> {
        P::TABLE.iter().map(|p| Number::of(P::SECTION, p)).collect()
    }
}

impl<D> List<D> {
    /// Declares a number by this name and key.
    #[inline(never)]
    pub fn number(
        &mut self,
        number: &Number,
        [name, key]: [&str; 2],
        (get, set): (Get<D>, Set<D>),
    ) -> &mut Variable<D> {
        let variable = self.parameter(name, number.text, number.kind.clone(), get, set).key(key);
        variable.description.variability = number.variability;
        variable
    }

    /// Declares a group of parameters.
    pub fn group<P: Parameters>(&mut self)
    where
        D: Has<P>,
    {
        for (i, number) in Number::all::<P>(None).into_iter().enumerate() {
            self.number(&number, [number.name, &number.key], (get::<D, P>, set::<D, P>)).at(i);
        }
    }
}

fn get<D: Has<P>, P: Parameters>(drive: &D, which: usize) -> f64 {
    drive.group().map_or(0.0, P::TABLE[which].get)
}

fn set<D: Has<P>, P: Parameters>(drive: &mut D, which: usize, value: f64) {
    if let Some(group) = drive.group_mut() {
        (P::TABLE[which].set)(group, value);
    }
}

/// Declares a group of parameters: a struct of numbers, which is a field `of` a drive, or fields of the struct named after `for`;
/// and the items of [`Parameters`]. The range follows `in`, the default `or`, the usual magnitude `about`.
#[macro_export]
macro_rules! parameters {
    ($(#[$doc:meta])* $struct:ident $(of $drive:ident . $($place:ident).+)?, $section:literal {
        $($(#[doc = $text:literal])+ $field:ident = $name:literal, $key:literal, $quantity:ident
            in [$min:expr, $max:expr] $(or $default:literal)? $(about $nominal:literal)?, $variability:ident;)*
    }) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
        pub struct $struct { $($(#[doc = $text])+ pub $field: f64,)* }

        $crate::drives::interface::parameter::parameters! { for $struct, $section {
            $($(#[doc = $text])+ $field = $name, $key, $quantity in [$min, $max] $(or $default)? $(about $nominal)?,
            $variability;)*
        } }

        $($crate::drives::interface::parameter::parameters! { $struct of $drive.$($place).+ })?
    };
    ($struct:ident of $drive:ident . $($place:ident).+) => {
        impl $crate::drives::interface::parameter::Has<$struct> for $drive {
            fn group(&self) -> Option<&$struct> {
                Some(&self.$($place).+)
            }
            fn group_mut(&mut self) -> Option<&mut $struct> {
                Some(&mut self.$($place).+)
            }
        }
    };
    (for $struct:ident, $section:literal {
        $($(#[doc = $text:literal])+ $($field:ident).+ = $name:literal, $key:literal, $quantity:ident
            in [$min:expr, $max:expr] $(or $default:literal)? $(about $nominal:literal)?, $variability:ident;)*
    }) => {
        impl $crate::drives::interface::parameter::Parameters for $struct {
            const SECTION: &'static str = $section;
            const TABLE: &'static [$crate::drives::interface::parameter::Parameter<Self>] = &[$($crate::drives::interface::parameter::Parameter {
                name: $name,
                key: $key,
                text: concat!($($text),+),
                quantity: &$crate::drives::interface::unit::$quantity,
                range: [$min, $max],
                default: $crate::drives::interface::parameter::parameters!(@optional $($default)?),
                nominal: $crate::drives::interface::parameter::parameters!(@optional $($nominal)?),
                variability: $crate::drives::interface::variable::Variability::$variability,
                get: |group| group.$($field).+,
                set: |group, value| group.$($field).+ = value,
            }),*];
        }
    };
    (@optional) => { None };
    (@optional $value:literal) => { Some($value) };
}
pub use parameters;

#[cfg(test)]
mod tests {
    use crate::drives::elastic_output::{ElasticOutput, Parameters, Scene};
    use crate::drives::follower::load::Load;
    use crate::drives::shaft::cam_drive::{DriveMode, Start, StartMode};
    use crate::drives::{AnyDrive, Drive, settings::Settings};
    use crate::motion::{Fourier, MotionLaw};

    #[test]
    fn a_scene_with_parameters_out_of_range_does_not_start() {
        for ([m, c, b], said) in [
            ([0.0, 1.0, 1.0], "`m`: 0 kg is not admissible; expected 1e-12 to 1e12 kg"),
            ([1.0, -1.0, 1.0], "`c`: -1 N/m is not admissible; expected 0 to 1e24 N/m"),
            ([1.0, 1.0, f64::NAN], "`b`: NaN N.s/m is not admissible; expected 0 to 1e24 N.s/m"),
        ] {
            let scene = Scene {
                coupling: false,
                parameters: Parameters { m, c, b },
                load: Load::default(),
                roller: (0.0, Load::default()),
                cam: MotionLaw::Fourier(Fourier::new(vec![0.0, 0.01], vec![])),
                drive: DriveMode::Constant { w: 20.0, phi_start: 0.0 },
                start: Start { mode: StartMode::AtRest, q: 0.0, q_dot: 0.0 },
                solver: Settings::default(),
            };
            let mut drive = AnyDrive::new(ElasticOutput::new(scene).unwrap());
            assert_eq!(drive.start().unwrap_err().to_string(), said);
        }
    }
}
