//! The meaning of the angles of a table: `turn`, `period` and `outside`.

use crate::document::{Node, Section, Value, units};
use camdrive::drives::unit::{self, Quantity};
use camdrive::motion::table::CLOSING;
use std::f64::consts::TAU;

/// Quantities of a column over which the cam turns evenly.
const QUANTITIES: [&Quantity; 3] = [&unit::ANGLE, &unit::TIME, &unit::LENGTH];

/// The turn in the column of the angles.
pub struct TurnScale<'a> {
    /// The quantity of the column; numbers are steps of an encoder.
    pub quantity: &'static Quantity,
    /// Its unit if `angle_unit` does not determine it.
    pub unit: Option<&'a str>,
    /// SI units of the column per radian of the cam.
    pub per_rad: f64,
    /// The equal lobes of the turn; the table has one of them.
    pub lobes: usize,
    /// True if the cam is at rest outside of the table.
    pub rests: bool,
    /// The distance of the angles, in SI units of the column, if the file has no angles.
    pub step: Option<f64>,
    /// The unit of messages, and its number per radian of the cam.
    shown: (f64, &'a str),
}

impl<'a> TurnScale<'a> {
    /// The turn of the cam itself.
    pub fn plain() -> Self {
        let shown = (1_f64.to_degrees(), "deg");
        TurnScale { quantity: &unit::ANGLE, unit: None, per_rad: 1.0, lobes: 1, rests: false, step: None, shown }
    }

    /// The keys of a section with `law = "table"`.
    pub fn read(section: &Section<'a>) -> Option<Self> {
        let text = section.node("turn").map(|node| match node.value {
            Value::Text(text) => Some(&**text),
            _ => None,
        });
        let (quantity, own) = match text {
            None => (&unit::ANGLE, None),
            Some(None) => (&unit::NUMBER, None),
            Some(Some(text)) => {
                let fits = |of: &&'static Quantity| units::parse(text, of).is_ok();
                (QUANTITIES.into_iter().find(fits).unwrap_or(&unit::ANGLE), Some(units::split(text.trim()).1))
            }
        };
        let unit = own.filter(|unit| !unit.is_empty());
        let (of, order) = section.of(quantity, 0);
        let turn = section.real_or("turn", TAU);
        // The period of a prescribed motion belongs to the task.
        let period = if section.path.ends_with("target") { Some(None) } else { section.optional("period") };
        let step = section.optional("angle_step");
        section.of(of, order);
        let named = section.text("angle_unit").flatten().and_then(|unit| units::factor(unit, &unit::ANGLE).ok());
        let is_plain = |node: &Node<'_>| !matches!(node.value, Value::Text(_));
        // A plain number counts like the angles.
        let counted = |key: &'static str, value: Option<Option<f64>>| match (named, section.node(key).filter(is_plain))
        {
            (Some((numerator, denominator)), Some(_)) if *quantity == unit::ANGLE => {
                value.map(|value| value.map(|value| value * numerator / denominator))
            }
            _ => value,
        };
        let (period, step) = (counted("period", period), counted("angle_step", step));
        let rests = section.choice_or("outside", &[("rest", true)], false);
        let (turn, period, step) = (turn?, period?.unwrap_or(turn?), step?);
        let lobes = (turn / period).round();
        // An angle such as a seventh of the turn has some five digits.
        if !(lobes >= 1.0 && (lobes * period / turn - 1.0).abs() <= CLOSING / TAU) {
            let fault = section.fault_of("period", format!(": the turn is {} periods", units::short(turn / period)));
            let unit = section.text("period").flatten().and_then(|text| units::written(text, quantity));
            let (unit, factor) = unit.unwrap_or((quantity.unit, 1.0));
            let nearest = units::short(turn / lobes.max(1.0) / factor);
            return section.refuse(
                fault
                    .admissible(format!("a whole fraction of the turn, for example {nearest} {unit}"))
                    .hint("a table of the whole turn needs no `period`"),
            );
        }
        let per_rad = turn / TAU;
        let known = |unit: Option<&'a str>, of| unit.and_then(|unit| Some((unit, units::factor(unit, of).ok()?)));
        let named = known(section.text("angle_unit").flatten(), &unit::ANGLE);
        let shown = match known(unit, quantity) {
            Some((unit, (numerator, denominator))) => (per_rad * denominator / numerator, unit),
            // Steps may be called degrees.
            None if text == Some(None) => (per_rad, named.map_or("counts", |(unit, _)| unit)),
            None if let Some((unit, (numerator, denominator))) = named => (per_rad * denominator / numerator, unit),
            None => (per_rad.to_degrees(), "deg"),
        };
        Some(TurnScale { quantity, unit, per_rad, lobes: lobes as usize, rests: rests?, step, shown })
    }

    /// True if the column has the angles of the whole turn.
    pub fn is_plain(&self) -> bool {
        self.per_rad == 1.0 && self.lobes == 1
    }

    /// An angle of the cam (rad) in the unit of the column.
    pub fn shown(&self, angle: f64) -> String {
        format!("{} {}", units::short(self.shown.0 * angle), self.shown.1)
    }
}
