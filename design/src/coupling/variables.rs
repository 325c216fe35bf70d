//! The variables of coupled FMUs under the names for people: each after the name of its part, if the part has one.

use crate::host::{ModelDescription, Variable};
use camdrive::drives::Description;
use camdrive::drives::variable::Causality;

/// The part, the index there and the description of each variable of these parts with their names; a connected input is no
/// input of the whole.
pub fn variables<'a>(
    parts: impl IntoIterator<Item = (&'a str, &'a ModelDescription)>,
    is_connected: impl Fn(usize, usize) -> bool,
) -> (Vec<(usize, usize)>, Vec<Description>) {
    let of_part = |(part, (name, description)): (usize, (&'a str, &'a ModelDescription))| {
        let of = |(place, Variable { about, .. }): (usize, &Variable)| {
            let causality = if is_connected(part, place) { Causality::Local } else { about.causality };
            let own = &about.name;
            let name = if name.is_empty() { own.clone() } else { format!("{name}.{own}") };
            ((part, place), Description { name, causality, ..about.clone() })
        };
        description.variables.iter().enumerate().map(of).collect::<Vec<_>>()
    };
    parts.into_iter().enumerate().flat_map(of_part).unzip()
}
