//! Values with units: "1800 rpm", "0.94 mm", "3.5 N/mm" → coherent SI, with the dimension checked.
//!
//! A unit is a product of factors joined by `.`, `·`, `*` or a blank; factors after a `/` divide, up to the next
//! `/`. A factor is a unit name with an optional prefix (n, u or µ, m, c, k, M, G) and an optional whole exponent
//! (`m2`, `m^2`, `m²`, `s^-1`). Known names: m, g, t, N, s, min, h, rad, deg or °, rev, J, W, Pa, Hz, rpm, %, in, lb, lbf.
//!
//! Angles are a dimension of their own, so that a torsional stiffness (N.m/rad) is not mistaken for a torque.
//! `rpm`, `1/min` and `U/min` are revolutions per minute, `Hz` is one revolution (cycle) per second, 2π rad/s.
//! `1/s` is refused for an angular velocity, since it is ambiguous.

use camdrive::drives::Fault;
use camdrive::drives::unit::{self, Quantity};
use std::f64::consts::{PI, TAU};

/// A unit: one of it is `numerator / denominator` of the coherent SI unit. Both are kept: 1/1000 is no binary fraction, and 0.94 /
/// 1000 rounds only once.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Unit {
    numerator: f64,
    denominator: f64,
    /// Exponents of kg, m, s, rad.
    base: [i8; 4],
}

/// Units that take prefixes.
const PREFIXED: &[(&str, Unit)] = &[
    ("m", one([0, 1, 0, 0])),
    ("g", Unit { numerator: 1.0, denominator: 1e3, base: [1, 0, 0, 0] }),
    ("N", one([1, 1, -2, 0])),
    ("s", one([0, 0, 1, 0])),
    ("rad", one([0, 0, 0, 1])),
    ("J", one([1, 2, -2, 0])),
    ("W", one([1, 2, -3, 0])),
    ("Pa", one([1, -1, -2, 0])),
    ("Hz", Unit { numerator: TAU, denominator: 1.0, base: [0, 0, -1, 1] }),
    // Products that people write without a sign.
    ("Nm", one([1, 2, -2, 0])),
    ("Ns", one([1, 1, -1, 0])),
    ("Nms", one([1, 2, -1, 0])),
];

/// Units without prefixes; they are looked up first, so that `min` is not a milli-inch.
const PLAIN: &[(&str, Unit)] = &[
    ("1", one([0, 0, 0, 0])),
    ("%", Unit { numerator: 1.0, denominator: 100.0, base: [0, 0, 0, 0] }),
    ("t", Unit { numerator: 1e3, denominator: 1.0, base: [1, 0, 0, 0] }),
    ("in", Unit { numerator: 254.0, denominator: 1e4, base: [0, 1, 0, 0] }),
    ("lb", Unit { numerator: 45_359_237.0, denominator: 1e8, base: [1, 0, 0, 0] }),
    // The weight of a pound at the standard gravity of 9.80665 m/s².
    ("lbf", Unit { numerator: 44_482_216_152_605.0, denominator: 1e13, base: [1, 1, -2, 0] }),
    ("min", Unit { numerator: 60.0, denominator: 1.0, base: [0, 0, 1, 0] }),
    ("h", Unit { numerator: 3600.0, denominator: 1.0, base: [0, 0, 1, 0] }),
    ("deg", Unit { numerator: PI, denominator: 180.0, base: [0, 0, 0, 1] }),
    ("°", Unit { numerator: PI, denominator: 180.0, base: [0, 0, 0, 1] }),
    ("rev", Unit { numerator: TAU, denominator: 1.0, base: [0, 0, 0, 1] }),
    ("rpm", Unit { numerator: TAU, denominator: 60.0, base: [0, 0, -1, 1] }),
];

/// Prefixes with their numerator and denominator.
const PREFIXES: &[(&str, f64, f64)] = &[
    ("n", 1.0, 1e9),
    ("u", 1.0, 1e6),
    ("µ", 1.0, 1e6),
    ("μ", 1.0, 1e6),
    ("m", 1.0, 1e3),
    ("c", 1.0, 1e2),
    ("k", 1e3, 1.0),
    ("M", 1e6, 1.0),
    ("G", 1e9, 1.0),
];

/// Complete units that engineers write for revolutions per minute.
const REVOLUTIONS_PER_MINUTE: &[&str] = &["1/min", "U/min", "min-1", "r/min", "/min"];

/// A quantity whose unit is this one times a power of rad.
macro_rules! times_rad {
    ($name:literal $words:literal, $unit:literal, $m:literal: $($power:literal $exponent:literal),*) => {
        [$(Quantity {
            name: concat!($name, $words, $power),
            unit: concat!($unit, $power),
            base: [0, $m, 0, $exponent],
            display: None,
        }),*]
    };
}

/// Derivatives of a length by an angle (m/radⁿ), n = 1 … 9.
static LENGTHS: [Quantity; 9] =
    times_rad!("Length" "PerRad", "m/rad", 1: "" -1, "2" -2, "3" -3, "4" -4, "5" -5, "6" -6, "7" -7, "8" -8, "9" -9);
/// Derivatives of a number by an angle (1/radⁿ), n = 1 … 9.
static NUMBERS: [Quantity; 9] =
    times_rad!("Number" "PerRad", "1/rad", 0: "" -1, "2" -2, "3" -3, "4" -4, "5" -5, "6" -6, "7" -7, "8" -8, "9" -9);
/// Weights of such derivatives (radⁿ), n = 1 … 4.
static WEIGHTS: [Quantity; 4] = times_rad!("Number" "TimesRad", "rad", 0: "" 1, "2" 2, "3" 3, "4" 4);

/// An area (m²), and an area times an angle, as of an integral of squares (m²·rad).
pub static AREA: Quantity = Quantity { name: "Area", unit: "m2", base: [0, 2, 0, 0], display: None };
static AREAS: [Quantity; 1] = times_rad!("Area" "TimesRad", "m2.rad", 2: "" 1);

/// A curvature (1/m).
pub static CURVATURE: Quantity = Quantity { name: "Curvature", unit: "1/m", base: [0, -1, 0, 0], display: None };

/// A length or a number per radⁿ; for n < 0 a number or an area times rad⁻ⁿ. The quantity itself for a power without a unit.
pub fn per_angle(quantity: &'static Quantity, n: i32) -> &'static Quantity {
    let list = match n {
        ..0 if quantity.base == AREA.base => &AREAS[..],
        ..0 => &WEIGHTS,
        _ if quantity.base == unit::LENGTH.base => &LENGTHS,
        _ => &NUMBERS,
    };
    (n.unsigned_abs() as usize).checked_sub(1).and_then(|i| list.get(i)).unwrap_or(quantity)
}

/// Pressure and modulus of elasticity (Pa).
pub static PRESSURE: Quantity =
    Quantity { name: "Pressure", unit: "Pa", base: [1, -1, -2, 0], display: Some(("MPa", 1e-6)) };

/// An example of each quantity, for hints.
const EXAMPLES: &[(&Quantity, &str)] = &[
    (&unit::NUMBER, "0.5"),
    (&unit::MASS, "\"12 kg\""),
    (&unit::INERTIA, "\"1.5 kg.m2\""),
    (&unit::STIFFNESS, "\"24 kN/m\""),
    (&unit::DAMPING, "\"50 N.s/m\""),
    (&unit::ROTATIONAL_STIFFNESS, "\"24 kN.m/rad\""),
    (&unit::ROTATIONAL_DAMPING, "\"18 N.m.s/rad\""),
    (&unit::LENGTH, "\"0.94 mm\""),
    (&unit::VELOCITY, "\"0.1 m/s\""),
    (&unit::ACCELERATION, "\"5 m/s2\""),
    (&unit::ANGLE, "\"32 deg\""),
    (&unit::ANGULAR_VELOCITY, "\"1800 rpm\""),
    (&unit::ANGULAR_ACCELERATION, "\"10 rad/s2\""),
    (&unit::FORCE, "\"80 N\""),
    (&unit::TORQUE, "\"220 N.m\""),
    (&unit::IMPULSE, "\"2 N.s\""),
    (&unit::ENERGY, "\"3 J\""),
    (&unit::TIME, "\"5 ms\""),
    (&PRESSURE, "\"210 GPa\""),
    (&unit::RATE, "\"15 1/s\""),
    (&LENGTHS[0], "\"25 mm/rad\" or \"25 mm\""),
    (&LENGTHS[1], "\"25 mm/rad2\" or \"25 mm\""),
    (&LENGTHS[2], "\"25 mm/rad3\" or \"25 mm\""),
    (&AREAS[0], "\"0.01 mm2.rad\" or \"0.01 mm2\""),
    (&NUMBERS[0], "\"0.5 1/rad\" or 0.5"),
    (&NUMBERS[1], "\"0.5 1/rad2\" or 0.5"),
    (&NUMBERS[2], "\"0.5 1/rad3\" or 0.5"),
];

const fn one(base: [i8; 4]) -> Unit {
    Unit { numerator: 1.0, denominator: 1.0, base }
}

/// The value of `text` ("1800 rpm") in the coherent SI unit of `quantity`; a text without a unit is in SI.
pub fn parse(text: &str, quantity: &'static Quantity) -> Result<f64, Fault> {
    let hint = || format!("write for example {}", example(quantity));
    let text = &*text.replace('\u{2212}', "-");
    if let Some(fault) = marked(text.trim()) {
        return Err(fault);
    }
    let (number, unit_text) = split(text.trim());
    let number: f64 = number
        .parse()
        .ok()
        .filter(|v: &f64| v.is_finite())
        .ok_or_else(|| Fault::new(format!("\"{text}\" does not start with a finite number")).hint(hint()))?;
    if unit_text.is_empty() {
        return Ok(number);
    }
    let unit = parse_unit(unit_text).map_err(|fault| {
        let meant = fault.meant(unit_text, quantity);
        let hint = meant.map_or_else(hint, |(unit, times)| format!("write \"{} {unit}\"", short(number * times)));
        Fault::new(format!("\"{text}\": {}", fault.message(unit_text, quantity))).hint(hint)
    })?;
    if unit.base == quantity.base {
        let value = number * unit.numerator / unit.denominator;
        let too_large = || Fault::new(format!("\"{text}\" is too large a number")).hint(hint());
        return if value.is_finite() { Ok(value) } else { Err(too_large()) };
    }
    let ambiguous = unit.base == [0, 0, -1, 0] && quantity.base == unit::ANGULAR_VELOCITY.base;
    Err(if ambiguous {
        Fault::new(format!("\"{text}\" may mean radians or revolutions per second"))
            .hint("write rad/s, Hz (revolutions per second) or rpm")
    } else {
        Fault::new(format!("\"{text}\" is {}; {} is expected", article(&dimension(unit.base)), name(quantity)))
            .hint(hint())
    })
}

/// The unit in a text with a value of the quantity, and its size in coherent units; None for a text without a unit.
pub fn written<'a>(text: &'a str, quantity: &Quantity) -> Option<(&'a str, f64)> {
    let (_, unit_text) = split(text.trim());
    let unit = parse_unit(unit_text).ok().filter(|unit| !unit_text.is_empty() && unit.base == quantity.base)?;
    Some((unit_text, unit.numerator / unit.denominator))
}

/// The factor from this unit to coherent SI: (numerator, denominator). An FMU may have units that are unknown here.
pub fn factor(text: &str, quantity: &'static Quantity) -> Result<(f64, f64), Fault> {
    let text = text.trim();
    let hint = || format!("write for example \"{}\"", quantity.display.map_or(quantity.unit, |(unit, _)| unit));
    let unit = parse_unit(text).map_err(|fault| Fault::new(fault.message(text, quantity)).hint(hint()));
    match (unit, quantity.display) {
        (Ok(unit), _) if unit.base == quantity.base => Ok((unit.numerator, unit.denominator)),
        _ if text == quantity.unit => Ok((1.0, 1.0)),
        (_, Some((name, count))) if text == name => Ok((1.0, count)),
        (Err(fault), _) => Err(fault),
        (Ok(unit), _) => Err(Fault::new(format!(
            "\"{text}\" is the unit of {}; {} is expected",
            dimension(unit.base),
            name(quantity)
        ))
        .hint(hint())),
    }
}

/// As [`factor`], for the derivative of this order with respect to an angle or another `by`; None if the text is no such unit.
pub fn per(text: &str, quantity: &Quantity, by: &Quantity, order: i8) -> Option<(f64, f64)> {
    let unit = parse_unit(text.trim()).ok()?;
    let base: [i8; 4] = std::array::from_fn(|i| quantity.base[i] - order * by.base[i]);
    (unit.base == base).then_some((unit.numerator, unit.denominator))
}

/// An example of the quantity in a scene.
pub fn example(quantity: &Quantity) -> &'static str {
    let is_it = |q: &Quantity| q.name == quantity.name || (quantity.name.is_empty() && q.base == quantity.base);
    EXAMPLES.iter().find(|(q, _)| is_it(q)).map_or("1", |(_, text)| text)
}

/// "an angular velocity"; "a value in rad/s" for a quantity without a name.
pub fn name(quantity: &Quantity) -> String {
    match (quantity.name, quantity.unit) {
        ("", "") => "a number without unit".to_owned(),
        ("", unit) => format!("a value in {unit}"),
        _ => article(&words(quantity)),
    }
}

/// The number with at most nine digits, without exponent if it is easy to read.
pub fn short(value: f64) -> String {
    // The sum turns −0 into 0.
    let rounded = format!("{value:.8e}").parse().unwrap_or(value) + 0.0;
    if rounded == 0.0 || (1e-4..1e6).contains(&rounded.abs()) { rounded.to_string() } else { format!("{rounded:e}") }
}

/// The number and the unit of "24 kN/m"; the blank before the unit is optional.
pub fn split(text: &str) -> (&str, &str) {
    let end = (0..=text.len())
        .rev()
        .filter(|&i| text.is_char_boundary(i))
        .find(|&i| text[..i].ends_with(|c: char| c.is_ascii_digit() || c == '.') && text[..i].parse::<f64>().is_ok())
        .unwrap_or(0);
    (&text[..end], text[end..].trim())
}

/// The fault of a number with thousands separators or a decimal comma.
fn marked(text: &str) -> Option<Fault> {
    let is_mark = |c: char| ".,'\u{2019}_".contains(c) || c.is_whitespace();
    let end = text.find(|c: char| !c.is_ascii_digit() && !is_mark(c) && !"+-".contains(c)).unwrap_or(text.len());
    let number = text[..end].trim_end_matches(is_mark);
    let marks: Vec<char> = number.chars().filter(|c| is_mark(*c)).collect();
    let (last, others) = marks.split_last()?;
    let unsigned = number.trim_start_matches(['+', '-']);
    let groups: Vec<&str> = unsigned.split(is_mark).collect();
    let of_three = |groups: &[&str]| groups.iter().all(|group| group.len() == 3);
    let without = |decimal: bool| {
        let kept = number.rfind(*last).filter(|_| decimal);
        let point = |(i, c): (usize, char)| if Some(i) == kept { Some('.') } else { Some(c).filter(|c| !is_mark(*c)) };
        format!("\"{}{}\"", number.char_indices().filter_map(point).collect::<String>(), &text[number.len()..])
    };
    let fault = |message: String, hint: String| Some(Fault::new(message).hint(hint));
    let of_thousands = format!("\"{text}\" has marks of thousands");
    match (others, *last) {
        (_, '.' | ',') if !others.is_empty() && !others.contains(last) && of_three(&groups[1..groups.len() - 1]) => {
            fault(of_thousands, format!("write {}", without(true)))
        }
        (_, '.') if others.is_empty() => None,
        (_, ',') if others.is_empty() && of_three(&groups[1..]) => fault(
            format!("the comma of \"{text}\" may be one of decimals or of thousands"),
            format!("write {} or {}", without(true), without(false)),
        ),
        (_, ',') if others.is_empty() => {
            fault(format!("\"{text}\" has a decimal comma"), format!("write the decimal point: {}", without(true)))
        }
        _ if others.iter().all(|mark| mark == last) && of_three(&groups[1..]) && groups[0].len() < 4 => {
            fault(of_thousands, format!("write {}", without(false)))
        }
        _ => None,
    }
}

/// The reason why a text is no unit.
enum NoUnit {
    /// It contains an unknown name.
    Unknown(String),
    Wrong(String),
}

/// Names of other kinds of units, with a replacement; of several replacements the one with the expected dimension.
const OTHER_NAMES: &[(&str, f64, &str)] = &[
    ("lbs", 1.0, "lb"),
    ("lbs", 1.0, "lbf"),
    ("pound", 1.0, "lb"),
    ("pounds", 1.0, "lb"),
    ("mil", 1e-3, "in"),
    ("mils", 1e-3, "in"),
    ("thou", 1e-3, "in"),
    ("inch", 1.0, "in"),
    ("inches", 1.0, "in"),
    ("\"", 1.0, "in"),
    ("ft", 12.0, "in"),
    ("kp", 9.80665, "N"),
    ("kgf", 9.80665, "N"),
    ("Nmm", 1.0, "N.mm"),
    ("sec", 1.0, "s"),
    ("hr", 1.0, "h"),
    ("degree", 1.0, "deg"),
    ("degrees", 1.0, "deg"),
    ("bar", 100.0, "kPa"),
];

impl NoUnit {
    /// The intended unit in `text` with this quantity, and how many of it equal one written unit.
    fn meant(&self, text: &str, quantity: &Quantity) -> Option<(String, f64)> {
        let NoUnit::Unknown(name) = self else { return None };
        let fitting = |times: f64, other: &str| {
            let unit = text.replacen(name.as_str(), other, 1);
            let fits = parse_unit(&unit).is_ok_and(|unit| unit.base == quantity.base);
            fits.then_some((unit, times))
        };
        let others = OTHER_NAMES.iter().filter(|(other, ..)| *other == name.to_lowercase() || other == name);
        // `KG` and `MM` have a prefix, which the names of the list lack. A slip in one letter of a short name would make another
        // unit, so only the case may differ there.
        let known = ["kg", "mm", "kN", "ms", "MPa", "GPa"].into_iter().chain(names());
        let distance = |unit: &str| strsim::osa_distance(&unit.to_lowercase(), &name.to_lowercase());
        let alike = known.filter(|unit| distance(unit) == 0 || distance(unit) == 1 && unit.len().min(name.len()) > 2);
        others
            .map(|(_, times, other)| (*times, *other))
            .chain(alike.map(|unit| (1.0, unit)))
            .find_map(|(times, other)| fitting(times, other))
    }

    fn message(&self, text: &str, quantity: &Quantity) -> String {
        let name = match self {
            NoUnit::Unknown(name) => name,
            NoUnit::Wrong(message) => return message.clone(),
        };
        match self.meant(text, quantity) {
            Some((meant, 1.0)) => format!("there is no unit `{name}`; did you mean `{meant}`?"),
            Some((meant, times)) => format!("there is no unit `{name}`; 1 {text} is {} {meant}", short(times)),
            None => format!(
                "there is no unit `{name}`; known units are {} and prefixes",
                names().collect::<Vec<_>>().join(", ")
            ),
        }
    }
}

/// The names of units without prefixes.
fn names() -> impl Iterator<Item = &'static str> {
    PLAIN.iter().chain(PREFIXED).map(|(name, _)| *name).filter(|name| *name != "1")
}

/// The unit as a factor, or its fault.
fn parse_unit(text: &str) -> Result<Unit, NoUnit> {
    let plain = normalise(text);
    if REVOLUTIONS_PER_MINUTE.contains(&plain.as_str()) {
        return atom("rpm").ok_or(NoUnit::Unknown(plain));
    }
    let mut product = one([0; 4]);
    for (i, group) in plain.split('/').enumerate() {
        for factor in group.split('.').filter(|f| !f.is_empty()) {
            let (name, exponent) = exponent(factor).map_err(NoUnit::Wrong)?;
            let unit = atom(name).ok_or_else(|| NoUnit::Unknown(name.to_owned()))?;
            let exponent = if i == 0 { exponent } else { -exponent };
            product = product.times(&unit, exponent);
        }
    }
    Ok(product)
}

/// The unit with `.` for every product sign and plain digits for exponents.
fn normalise(text: &str) -> String {
    let mut plain = String::new();
    for c in text.split_whitespace().collect::<Vec<_>>().join(".").chars() {
        match c {
            '·' | '⋅' | '*' | '×' => plain.push('.'),
            '²' => plain.push('2'),
            '³' => plain.push('3'),
            '¹' => plain.push('1'),
            '⁻' | '−' => plain.push('-'),
            '^' | '(' | ')' => {}
            c => plain.push(c),
        }
    }
    plain.replace("./", "/").replace("/.", "/")
}

/// Name and exponent of the factor "m2".
fn exponent(factor: &str) -> Result<(&str, i32), String> {
    let digits = factor.trim_start_matches(|c: char| !c.is_ascii_digit() && c != '-');
    let name = &factor[..factor.len() - digits.len()];
    if digits.is_empty() {
        Ok((factor, 1))
    } else if name.is_empty() {
        // The factor "1" of "1/s".
        Ok((factor, 1))
    } else {
        let exponent = digits.parse().ok().filter(|e: &i32| (-9..=9).contains(e));
        exponent.map(|e| (name, e)).ok_or_else(|| format!("the exponent of `{factor}` is not a small whole number"))
    }
}

/// The unit of this name, with or without prefix.
fn atom(name: &str) -> Option<Unit> {
    let find = |list: &[(&str, Unit)], name: &str| list.iter().find(|(n, _)| *n == name).map(|(_, unit)| *unit);
    find(PLAIN, name).or_else(|| find(PREFIXED, name)).or_else(|| {
        PREFIXES.iter().find_map(|&(prefix, numerator, denominator)| {
            let unit = find(PREFIXED, name.strip_prefix(prefix)?)?;
            Some(Unit { numerator: unit.numerator * numerator, denominator: unit.denominator * denominator, ..unit })
        })
    })
}

impl Unit {
    fn times(&self, other: &Unit, exponent: i32) -> Unit {
        let (up, down) =
            if exponent < 0 { (other.denominator, other.numerator) } else { (other.numerator, other.denominator) };
        let (n, d) = (self.numerator * up.powi(exponent.abs()), self.denominator * down.powi(exponent.abs()));
        let base = std::array::from_fn(|i| self.base[i].saturating_add(other.base[i].saturating_mul(exponent as i8)));
        // Thousands on both sides cancel exactly; otherwise kN/mm would keep 1000·1000 over 1.
        if n % d == 0.0 && n < 1e15 {
            Unit { numerator: n / d, denominator: 1.0, base }
        } else {
            Unit { numerator: n, denominator: d, base }
        }
    }
}

/// "angular velocity"
fn words(quantity: &Quantity) -> String {
    let mut words = String::new();
    for c in quantity.name.chars() {
        if c.is_uppercase() && !words.is_empty() {
            words.push(' ');
        }
        words.push(c.to_ascii_lowercase());
    }
    words
        .replace("translational spring constant", "stiffness")
        .replace("translational damping constant", "damping constant")
        .replace("rotational spring constant", "torsional stiffness")
        .replace("rotational damping constant", "torsional damping constant")
}

/// The name of the quantities with these exponents, or the exponents themselves.
fn dimension(base: [i8; 4]) -> String {
    if let Some((quantity, _)) = EXAMPLES.iter().find(|(q, _)| q.base == base) {
        return words(quantity);
    }
    let factors = ["kg", "m", "s", "rad"].iter().zip(base).filter(|(_, e)| *e != 0);
    let product: Vec<String> = factors.map(|(n, e)| if e == 1 { (*n).to_owned() } else { format!("{n}{e}") }).collect();
    format!("quantity in {}", product.join("."))
}

fn article(words: &str) -> String {
    let article = if words.starts_with(['a', 'e', 'i', 'o', 'u']) { "an" } else { "a" };
    format!("{article} {words}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_become_coherent_si() {
        let cases: &[(&str, &'static Quantity, f64)] = &[
            ("1800 rpm", &unit::ANGULAR_VELOCITY, 60.0 * PI),
            ("45 1/min", &unit::ANGULAR_VELOCITY, 1.5 * PI),
            ("45 U/min", &unit::ANGULAR_VELOCITY, 1.5 * PI),
            ("45 min^-1", &unit::ANGULAR_VELOCITY, 1.5 * PI),
            ("45 rev/min", &unit::ANGULAR_VELOCITY, 1.5 * PI),
            ("25 Hz", &unit::ANGULAR_VELOCITY, 50.0 * PI),
            ("0.94 mm", &unit::LENGTH, 0.00094),
            ("32 deg", &unit::ANGLE, 32.0 * PI / 180.0),
            ("360°", &unit::ANGLE, TAU),
            ("12 kg", &unit::MASS, 12.0),
            ("12", &unit::MASS, 12.0),
            ("1.2 t", &unit::MASS, 1200.0),
            ("3.5 N/mm", &unit::STIFFNESS, 3500.0),
            ("24kN/m", &unit::STIFFNESS, 24000.0),
            ("2 kN/mm", &unit::STIFFNESS, 2e6),
            ("0.05 N.s/m", &unit::DAMPING, 0.05),
            ("0.05 N s / m", &unit::DAMPING, 0.05),
            ("0.05 kg/s", &unit::DAMPING, 0.05),
            ("220 N·m", &unit::TORQUE, 220.0),
            ("24 kNm/rad", &unit::ROTATIONAL_STIFFNESS, 24e3),
            ("18 Nms/rad", &unit::ROTATIONAL_DAMPING, 18.0),
            ("50 Ns/m", &unit::DAMPING, 50.0),
            ("1e-3 kg m²", &unit::INERTIA, 1e-3),
            ("15 kg.cm^2", &unit::INERTIA, 15e-4),
            ("3 N.m.s/rad", &unit::ROTATIONAL_DAMPING, 3.0),
            ("90 N.m/deg", &unit::ROTATIONAL_STIFFNESS, 90.0 * 180.0 / PI),
            ("3 %", &unit::NUMBER, 0.03),
            ("250 µm", &unit::LENGTH, 250e-6),
            ("10 m.s^-2", &unit::ACCELERATION, 10.0),
            ("2 ms", &unit::TIME, 2e-3),
            ("3 in", &unit::LENGTH, 0.0762),
            ("2 lb", &unit::MASS, 0.90718474),
            ("10 lbf/in", &unit::STIFFNESS, 1751.2683524647636),
            ("40 lbf.in", &unit::TORQUE, 4.519393161104668),
            ("1 min", &unit::TIME, 60.0),
        ];
        for (text, quantity, si) in cases {
            let value = parse(text, quantity).unwrap_or_else(|e| panic!("{text}: {}", e.message));
            // At most two roundings lie between the text and the value.
            assert!((value - si).abs() <= 2.0 * f64::EPSILON * si.abs(), "{text}: {value} for {si}");
        }
        // Decimal prefixes round once: the value equals the value of plain SI text.
        assert_eq!(parse("0.94 mm", &unit::LENGTH), Ok(0.00094));
        assert_eq!(parse("3.5 N/mm", &unit::STIFFNESS), Ok(3500.0));
    }

    #[test]
    fn derivatives_by_an_angle_have_units() {
        let length = |n: i32| per_angle(&unit::LENGTH, n);
        for (text, quantity, si) in [
            ("25 mm/rad", length(1), 0.025),
            ("0 mm/rad2", length(2), 0.0),
            ("400 mm/rad²", length(2), 0.4),
            ("-3 mm/rad^3", length(3), -0.003),
            ("1 mm/deg", length(1), 0.18 / PI),
            ("1 mm/deg2", length(2), 1e-3 * (180.0 / PI) * (180.0 / PI)),
            ("2 m/rev", length(1), 2.0 / TAU),
            ("7 m/rad7", length(7), 7.0),
            ("25", length(1), 25.0),
            ("0.5 1/rad", per_angle(&unit::NUMBER, 1), 0.5),
            ("0.5/rad2", per_angle(&unit::NUMBER, 2), 0.5),
            ("180 deg", per_angle(&unit::NUMBER, -1), PI),
            ("0.1 rad4", per_angle(&unit::NUMBER, -4), 0.1),
        ] {
            let value = parse(text, quantity).unwrap_or_else(|e| panic!("{text}: {}", e.message));
            // Conversions of degrees round a few times.
            assert!((value - si).abs() <= 4.0 * f64::EPSILON * si.abs(), "{text}: {value} for {si}");
        }
        let fault = parse("25 mm/rad2", length(1)).expect_err("another derivative");
        assert_eq!(fault.message, "\"25 mm/rad2\" is a length per rad2; a length per rad is expected");
        assert_eq!(fault.hint.as_deref(), Some("write for example \"25 mm/rad\" or \"25 mm\""));
        assert_eq!(per_angle(&unit::LENGTH, 0), &unit::LENGTH);
    }

    #[test]
    fn wrong_units_are_refused() {
        let cases: &[(&str, &'static Quantity, &str)] = &[
            ("1800 mm", &unit::ANGULAR_VELOCITY, "\"1800 mm\" is a length; an angular velocity is expected"),
            ("30 1/s", &unit::ANGULAR_VELOCITY, "\"30 1/s\" may mean radians or revolutions per second"),
            ("24 N.m", &unit::ROTATIONAL_STIFFNESS, "\"24 N.m\" is a torque; a torsional stiffness is expected"),
            ("0,94 mm", &unit::LENGTH, "\"0,94 mm\" has a decimal comma"),
            ("mm", &unit::LENGTH, "\"mm\" does not start with a finite number"),
            ("", &unit::LENGTH, "\"\" does not start with a finite number"),
            ("1e999 mm", &unit::LENGTH, "\"1e999 mm\" does not start with a finite number"),
            ("5 kg.m3", &unit::LENGTH, "\"5 kg.m3\" is a quantity in kg.m3; a length is expected"),
        ];
        for (text, quantity, message) in cases {
            assert_eq!(parse(text, quantity).map_err(|e| e.message.clone()), Err((*message).to_owned()));
        }
        let unknown = parse("5 furlong", &unit::LENGTH).expect_err("no such unit").0.message;
        assert!(unknown.contains("there is no unit `furlong`"), "{unknown}");
        // The suggestion has the expected dimension.
        for (text, quantity, meant, hint) in [
            ("1800 rmp", &unit::ANGULAR_VELOCITY, "`rpm`", "write \"1800 rpm\""),
            ("1800 RPM", &unit::ANGULAR_VELOCITY, "`rpm`", "write \"1800 rpm\""),
            ("1800 RPM", &unit::MASS, "known units are", "write for example \"12 kg\""),
            ("12 KG", &unit::MASS, "`kg`", "write \"12 kg\""),
            ("3 wibble", &unit::MASS, "known units are", "write for example \"12 kg\""),
            ("26 lbs", &unit::MASS, "`lb`", "write \"26 lb\""),
            ("26 lbs", &unit::FORCE, "`lbf`", "write \"26 lbf\""),
            ("26 lbs/in", &unit::STIFFNESS, "`lbf/in`", "write \"26 lbf/in\""),
            ("37 mil", &unit::LENGTH, "1 mil is 0.001 in", "write \"0.037 in\""),
            ("37 mil", &unit::FORCE, "known units are", "write for example \"80 N\""),
            ("3 inch", &unit::LENGTH, "`in`", "write \"3 in\""),
            ("3 sec", &unit::TIME, "`s`", "write \"3 s\""),
            ("5 Nmm", &unit::TORQUE, "`N.mm`", "write \"5 N.mm\""),
            ("2 kp", &unit::FORCE, "1 kp is 9.80665 N", "write \"19.6133 N\""),
        ] {
            let fault = parse(text, quantity).expect_err("no such unit");
            assert!(fault.message.contains(meant), "{text}: {}", fault.message);
            assert_eq!(fault.hint.as_deref(), Some(hint), "{text}");
        }
        // Thousands separators.
        for (text, message, hint) in [
            ("1.800,0 rpm", "marks of thousands", "write \"1800.0 rpm\""),
            ("1,800.0 rpm", "marks of thousands", "write \"1800.0 rpm\""),
            ("1.234.567,5 rpm", "marks of thousands", "write \"1234567.5 rpm\""),
            ("-1.800.000 rpm", "marks of thousands", "write \"-1800000 rpm\""),
            ("1 800,5 rpm", "marks of thousands", "write \"1800.5 rpm\""),
            ("1'800 rpm", "marks of thousands", "write \"1800 rpm\""),
            ("1 800 rpm", "marks of thousands", "write \"1800 rpm\""),
            ("1,800 rpm", "may be one of decimals or of thousands", "write \"1.800 rpm\" or \"1800 rpm\""),
            ("1,8 rpm", "decimal comma", "write the decimal point: \"1.8 rpm\""),
        ] {
            let fault = parse(text, &unit::ANGULAR_VELOCITY).expect_err("marks");
            assert!(fault.message.contains(message) && fault.hint.as_deref() == Some(hint), "{text}: {fault:?}");
        }
        assert!(
            parse("1.800 rpm", &unit::ANGULAR_VELOCITY).is_ok() && parse("45 1/min", &unit::ANGULAR_VELOCITY).is_ok()
        );
        // Absurd exponents must not overflow.
        for text in ["1 m99", "1 m9.m9.m9.m9.m9.m9.m9.m9.m9.m9.m9.m9.m9.m9.m9", "1 /", "1 //", "1 m-", "1 ^"] {
            let _ = parse(text, &unit::LENGTH);
        }
    }
}
