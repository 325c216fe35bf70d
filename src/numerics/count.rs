//! Counts read from bytes: the length of a list or a loop is checked before it is used.

use serde::de::{Deserialize, Deserializer, Error};

/// A number that is at most `MOST`.
pub fn at_most<'de, D: Deserializer<'de>, const MOST: usize>(deserializer: D) -> Result<usize, D::Error> {
    let count = usize::deserialize(deserializer)?;
    if count <= MOST { Ok(count) } else { Err(D::Error::custom(format_args!("{count} is more than {MOST}"))) }
}
