//! Units in which people read quantities: one for each quantity.

use std::borrow::Cow;
use std::f64::consts::TAU;

/// In three digits this is 10 000.
const LARGE: f64 = 9995.0;

/// A unit and its factor from the coherent SI unit.
#[derive(Clone, Debug, PartialEq)]
pub struct Unit {
    /// As people write it, "mm/rad²"; empty for a plain number.
    pub name: Cow<'static, str>,
    /// The number in this unit of 1 SI.
    pub factor: f64,
}

impl Unit {
    /// A unit and the number in it of 1 SI.
    pub const fn new(name: &'static str, factor: f64) -> Self {
        Unit { name: Cow::Borrowed(name), factor }
    }

    /// The unit in which people read a quantity of this unit of FMI: lengths in mm, angles in °, angular velocities in rpm, stress
    /// in N/mm²; others as they are.
    pub fn of(unit: &str) -> Self {
        let name = match unit {
            "" | "1" => return ONE,
            "m" => return MM,
            "rad" => return DEG,
            "rad/s" => return RPM,
            "Pa" | "N/m2" => return PRESSURE,
            _ => unit.replace('.', "·").replace('2', "²").replace('3', "³"),
        };
        // Lifts over the angle: the angle stays in rad, as laws have it.
        match name.strip_prefix("m/rad") {
            Some(power) => Unit { name: format!("mm/rad{power}").into(), factor: 1e3 },
            None => Unit { name: name.into(), factor: 1.0 },
        }
    }

    /// The unit in which people read values of up to this size (SI): kN, kW, kJ and kN·m from 10 000 on.
    pub fn sized(&self, size: f64) -> Unit {
        let large = ["N", "N·m", "W", "J"].contains(&&*self.name) && (size * self.factor).abs() >= LARGE;
        if large { Unit { name: format!("k{}", self.name).into(), factor: 1e-3 * self.factor } } else { self.clone() }
    }

    /// A number, written out, with this unit.
    pub fn after(&self, text: String) -> String {
        match &*self.name {
            "" => text,
            "°" => text + "°",
            name => format!("{text} {name}"),
        }
    }

    /// As it stands in the headings of a CSV: "mm_per_rad2"; empty for a plain number.
    pub fn key(&self) -> String {
        let words = [("²", "2"), ("³", "3"), ("°", "deg"), ("%", "percent"), ("µ", "u"), ("·", ""), ("/", "_per_")];
        words.iter().fold(self.name.to_string(), |key, (sign, word)| key.replace(sign, word))
    }
}

/// A plain number.
pub const ONE: Unit = Unit::new("", 1.0);
/// A part of a whole.
pub const PERCENT: Unit = Unit::new("%", 100.0);
/// An angular velocity.
pub const RPM: Unit = Unit::new("rpm", 60.0 / TAU);
/// An angle.
pub const DEG: Unit = Unit::new("°", 360.0 / TAU);
/// A time.
pub const MS: Unit = Unit::new("ms", 1e3);
/// A time of computing.
pub const US: Unit = Unit::new("µs", 1e6);
/// A length.
pub const MM: Unit = Unit::new("mm", 1e3);
/// U′, where U is a length.
pub const MM_PER_RAD: Unit = Unit::new("mm/rad", 1e3);
/// U″.
pub const MM_PER_RAD2: Unit = Unit::new("mm/rad²", 1e3);
/// U‴.
pub const MM_PER_RAD3: Unit = Unit::new("mm/rad³", 1e3);
/// A frequency, from an angular one.
pub const HZ: Unit = Unit::new("Hz", 1.0 / TAU);
/// A mass.
pub const KG: Unit = Unit::new("kg", 1.0);
/// An inertia.
pub const KGM2: Unit = Unit::new("kg·m²", 1.0);
/// A force.
pub const N: Unit = Unit::new("N", 1.0);
/// A torque.
pub const NM: Unit = Unit::new("N·m", 1.0);
/// An impulse.
pub const NS: Unit = Unit::new("N·s", 1.0);
/// An energy.
pub const J: Unit = Unit::new("J", 1.0);
/// A power.
pub const W: Unit = Unit::new("W", 1.0);
/// A pressure.
pub const PRESSURE: Unit = Unit::new("N/mm²", 1e-6);
