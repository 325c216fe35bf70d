//! Variables of a drive by their names, and their values from texts.

use crate::document::{nearest, units};
use camdrive::drives::variable::Kind;
use camdrive::drives::{Description, Fault};
use camdrive_design::host::{ModelDescription, Unit, Variable};
use std::collections::HashMap;

/// Finds the index in the list, which is the value reference, of the variable with a name.
///
/// # Errors
/// An unknown name; the message names the most similar one.
pub fn finder(all: &[Description]) -> impl Fn(&str) -> Result<usize, Fault> {
    // From the end, since the first variable of a name counts.
    let places: HashMap<&str, usize> =
        all.iter().enumerate().rev().map(|(place, d)| (d.name.as_str(), place)).collect();
    move |name| places.get(name).copied().ok_or_else(|| unknown(name, all.iter().map(|d| d.name.as_str())))
}

/// The fault of a name that no variable in `all` has.
pub fn unknown<'a>(name: &str, all: impl Iterator<Item = &'a str>) -> Fault {
    match nearest(name, &all.collect::<Vec<_>>()) {
        Some(guess) => Fault::new(format!("there is no variable `{name}`; did you mean `{guess}`?")),
        None => {
            Fault::new(format!("there is no variable `{name}`")).hint("`camdrive describe SCENE` lists the variables")
        }
    }
}

/// The value of a variable from `text`: a number in SI, a text with a unit of its quantity ("2000 rpm"), true or false, or the name
/// of an item of an enumeration.
///
/// # Errors
/// Any other text, and values out of the range of the variable.
pub fn value(of: &Description, text: &str) -> Result<f64, Fault> {
    let value = parsed(of, text)?;
    of.check(value)?;
    Ok(value)
}

/// The same without the range of the variable.
///
/// # Errors
/// A text that is no value of this kind.
pub fn parsed(of: &Description, text: &str) -> Result<f64, Fault> {
    let (name, text) = (&of.name, text.trim());
    let number =
        |expected: &str| text.parse().map_err(|_| Fault::new(format!("`{name}`: \"{text}\" is not {expected}")));
    Ok(match (&of.kind, text) {
        (Kind::Real { quantity, .. }, _) => {
            units::parse(text, quantity).map_err(|fault| fault.within(format_args!("`{name}`")))?
        }
        (Kind::Integer { .. }, _) => number("a whole number")?,
        (Kind::Boolean, "true") => 1.0,
        (Kind::Boolean, "false") => 0.0,
        (Kind::Boolean, _) => number("true or false")?,
        (Kind::Enumeration(e), _) => {
            let items: Vec<&str> = e.items.iter().map(|(item, _)| *item).collect();
            match items.iter().position(|item| *item == text) {
                Some(place) => (place + 1) as f64,
                None => number(&format!("one of {}", items.join(", ")))?,
            }
        }
    })
}

/// The fault of a value for a connected input.
pub fn connected() -> Fault {
    Fault::new("the input is connected, so a value would have no effect")
        .hint("set a variable of the part that it is connected to")
}

/// Two values of a text that differ by less are equal: factors in model descriptions have few digits.
const SAME: f64 = 1e-6;

/// The fault of a number without a unit if the FMU's unit is not SI.
pub fn ambiguous(number: f64, unit: &Unit) -> Fault {
    let unit = &unit.name;
    Fault::new(format!("{number} may be in SI or in {unit}, the unit of the FMU"))
        .hint(format!("write the unit, \"{number} {unit}\""))
}

/// The same as [`parsed`] for a variable of an FMU, which may define its own units; the value is in SI.
///
/// # Errors
/// Errors of [`parsed`]; a number without a unit if the FMU's is not SI; a unit with another meaning in the FMU.
pub fn imported(description: &ModelDescription, variable: usize, text: &str) -> Result<f64, Fault> {
    let Variable { about, unit, items, .. } = &description.variables[variable];
    let (name, (number, word)) = (&about.name, units::split(text));
    if !items.is_empty() {
        let item = items.iter().find(|(item, value)| item == text || text.parse() == Ok(*value));
        let all = || items.iter().map(|(item, value)| format!("{value} ({item})")).collect::<Vec<_>>().join(", ");
        return item
            .map(|(_, value)| f64::from(*value))
            .ok_or_else(|| Fault::new(format!("`{name}`: \"{text}\" is not admissible; expected {}", all())));
    }
    let number: Option<f64> = number.parse().ok();
    let theirs = number.and_then(|number| Some(description.unit(variable, word)?.to_si(number)));
    match (number, theirs, parsed(about, text)) {
        (Some(number), ..) if word.is_empty() && unit.to_si(number) != number => {
            Err(ambiguous(number, unit).within(format_args!("`{name}`")))
        }
        (_, Some(theirs), Ok(ours)) if (theirs - ours).abs() > SAME * ours.abs() => {
            Err(Fault::new(format!("`{name}`: {word} has another meaning in the FMU"))
                .hint("give the value in another unit"))
        }
        (_, Some(theirs), Err(_)) => Ok(theirs),
        (_, _, ours) => ours,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    /// The variables of an example.
    fn variables(scene: &str) -> Vec<Description> {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples").join(scene);
        crate::scene::read(&path).unwrap().resource().build().unwrap().descriptions().to_vec()
    }

    #[test]
    fn texts_are_values_of_the_variable_or_refused() {
        let all = variables("guide_bar/scene.toml");
        let of = |name: &str, text: &str| value(&all[finder(&all)(name)?], text);
        for (name, text, expected) in [
            ("drive.w", "200", 200.0),
            ("drive.w", " 30 rpm ", std::f64::consts::PI),
            ("m", "12000 g", 12.0),
            ("start.mode", "steady_state", 3.0),
            ("start.mode", "1", 1.0),
        ] {
            let value = of(name, text).unwrap();
            assert!((value - expected).abs() < 1e-15 * expected, "{name} = {text}: {value}");
        }
        for (name, text, parts) in [
            ("drive.w", "30 mm", ["`drive.w`", "an angular velocity is expected"]),
            ("drive.w", "1e9 rpm", ["`drive.w`: 1.0471975511965977e8 rad/s", "expected -1000000 to 1000000 rad/s"]),
            ("drive.w", "fast", ["`drive.w`", "finite number"]),
            ("start.mode", "steady", ["\"steady\" is not one of at_rest, given", "steady_state"]),
            ("start.mode", "1.5", ["1.5 is not admissible", "3 (steady_state)"]),
            ("drive.v", "1", ["no variable `drive.v`", "did you mean `drive.w`?"]),
            ("zzz", "1", ["no variable `zzz`", "describe"]),
        ] {
            let message = of(name, text).unwrap_err().to_string();
            assert!(parts.iter().all(|part| message.contains(part)), "{name} = {text}: {message}");
        }
    }

    #[test]
    fn true_and_false_are_values_of_booleans_only() {
        let all = variables("guide_bar/scene.toml");
        let boolean = Description { kind: Kind::Boolean, ..all[0].clone() };
        assert_eq!(["true", "false", "1"].map(|text| value(&boolean, text).unwrap()), [1.0, 0.0, 1.0]);
        assert!(value(&boolean, "yes").unwrap_err().message.contains("\"yes\" is not true or false"));
        let integer = Description { kind: Kind::Integer { min: 0, max: 3 }, ..boolean };
        assert_eq!(value(&integer, "3"), Ok(3.0));
        for (text, part) in [("true", "not a whole number"), ("2.5", "expected 0 to 3"), ("nan", "NaN")] {
            assert!(value(&integer, text).unwrap_err().to_string().contains(part), "{text}");
        }
    }
}
