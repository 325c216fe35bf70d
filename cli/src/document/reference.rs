//! The tables of the scene and task reference, from the [declarations](super::keys) of the keys.

use super::input::Kind;
use super::keys::{Dimension, Key, KeyTable, Usual, Value};
use super::limits::Limits;
use super::units;
use camdrive::drives::unit::Quantity;

impl KeyTable {
    /// The rows of the reference in Markdown.
    pub fn markdown(&self) -> String {
        let rows = self.keys.iter().map(|key| {
            let [unit, range, usual] = [key.unit(), key.range(), key.default()];
            let meaning = key.meaning.trim_start().replace('|', "\\|");
            let models = if key.models.is_empty() { String::new() } else { format!(" ({})", key.models.join(", ")) };
            format!("| `{}` | {meaning}{models} | {unit} | {range} | {usual} |\n", key.key)
        });
        format!("| key | meaning | unit | range | default |\n|---|---|---|---|---|\n{}", rows.collect::<String>())
    }

    /// The rows of the reference for the terminal.
    pub fn text(&self) -> String {
        let keys = self.keys.iter().map(|key| format!("\n{}\n    {}\n", key.key, key.described()));
        format!("{}\n{}", self.title.replace('`', ""), keys.collect::<String>())
    }
}

/// The reference with new tables, each between a comment `<!-- keys: TITLE -->` and `<!-- end -->`; None for an unknown title.
pub fn renewed(page: &str) -> Option<String> {
    let all = [tables(Kind::Scene), tables(Kind::Task), tables(Kind::Study), tables(Kind::System)].concat();
    let mut parts = page.split("<!-- keys: ");
    let mut text = parts.next()?.to_owned();
    for part in parts {
        let (title, (_, rest)) =
            part.split_once(" -->").and_then(|(title, rest)| Some((title, rest.split_once("<!-- end -->")?)))?;
        let rows = all.iter().find(|table| table.title.replace('`', "") == title)?.markdown();
        text += &format!("<!-- keys: {title} -->\n{rows}<!-- end -->{rest}");
    }
    Some(text)
}

/// All tables of scenes or tasks, each once, the whole file first.
pub fn tables(kind: Kind) -> Vec<&'static KeyTable> {
    let mut found = vec![kind.keys()];
    let mut next = 0;
    while let Some(table) = found.get(next).copied() {
        let inside = table.keys.iter().flat_map(|key| key.values).filter_map(|value| match value {
            Value::Table(table) | Value::Tables(table) | Value::Named(table) => Some(table),
            _ => None,
        });
        for table in inside.chain(table.with) {
            if !found.iter().any(|known| std::ptr::eq(*known, table)) {
                found.push(table);
            }
        }
        next += 1;
    }
    found
}

impl Key {
    /// Meaning, unit, range and default in one sentence.
    pub fn described(&self) -> String {
        let models = if self.models.is_empty() { String::new() } else { format!("only {}", self.models.join(", ")) };
        // A rule for a missing key is no value.
        let default = if matches!(self.usual, Usual::Number(_) | Usual::Name(_)) { "default " } else { "" };
        let said = [("unit ", self.unit()), ("", self.range()), (default, self.default()), ("", models)];
        let said = said.into_iter().filter(|(_, text)| !text.is_empty());
        let said: Vec<String> = said.map(|(what, text)| format!("{what}{text}")).collect();
        let meaning = self.meaning.trim_start();
        if said.is_empty() { meaning.to_owned() } else { format!("{meaning} ({})", said.join("; ")) }
    }

    fn numbers(&self) -> impl Iterator<Item = (Dimension, Limits)> {
        self.values
            .into_iter()
            .filter_map(|value| if let Value::Real(of, limits) = value { Some((of, limits)) } else { None })
    }

    /// The unit, or the units along a line and about an axis.
    fn unit(&self) -> String {
        let of = |of: Dimension| match of {
            Dimension::Fixed(quantity) if quantity.unit == "1" => String::new(),
            Dimension::Fixed(quantity) => shown(quantity),
            Dimension::Motion(line, turn) => format!("{} or {}", shown(line), shown(turn)),
            Dimension::Other => String::new(),
            Dimension::Own(0) => "as U".to_owned(),
            Dimension::Own(1) => "U per rad".to_owned(),
            Dimension::Own(n) => format!("U per rad{}", if n == 2 { '²' } else { '³' }),
        };
        let listed =
            self.values.into_iter().filter_map(|value| if let Value::Reals(of) = value { Some(of) } else { None });
        let mut units: Vec<String> = self.numbers().map(|(of, _)| of).chain(listed).map(of).collect();
        units.retain(|unit| !unit.is_empty());
        units.dedup();
        units.join(" or ")
    }

    fn range(&self) -> String {
        let counts = self.values.into_iter().filter_map(|value| match value {
            Value::Count(min, max) => Some(format!("{min} to {max}")),
            Value::Real(_, limits) => Some(limits.range()),
            Value::Word(word) => Some(format!("`\"{word}\"`")),
            _ => None,
        });
        let names: Vec<String> = self.choices().iter().map(|names| format!("`{}`", names[0])).collect();
        let mut all: Vec<String> = counts.chain((!names.is_empty()).then(|| names.join(", "))).collect();
        all.retain(|range| !range.is_empty());
        all.dedup();
        all.join(" or ")
    }

    fn default(&self) -> String {
        match self.usual {
            Usual::Nothing if matches!(self.values[0], Value::Flag) => "`false`".to_owned(),
            Usual::Nothing => String::new(),
            Usual::Required => "required".to_owned(),
            Usual::Number(number) => units::short(number),
            Usual::Name(name) => format!("`{name}`"),
            Usual::Text(text) => text.to_owned(),
        }
    }

    /// The names of a choice.
    pub fn choices(&self) -> &'static [&'static [&'static str]] {
        match self.values[0] {
            Value::Choice(names) => names,
            _ => &[],
        }
    }
}

/// A unit in its written form.
fn shown(quantity: &Quantity) -> String {
    quantity.unit.replace('.', "·").replace('2', "²").replace('3', "³")
}
