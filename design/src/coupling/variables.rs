//! The variables of coupled FMUs as people name them: each behind the name of its part, where that has one.

use crate::host::{ModelDescription, Variable};
use camdrive::drives::Description;
use camdrive::drives::variable::Causality;

/// The part and the place there of each variable of these parts with their names, and what it is; what is connected is no input of the
/// whole.
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
