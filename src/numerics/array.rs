//! Arrays in scenes and saved states, read and written by one loop for all lengths: serde unrolls them for each length.
//!
//! For `#[serde(with = "crate::numerics::array")]`. The format is that of serde's own arrays, a tuple.

use serde::de::{Deserialize, Deserializer, Error, SeqAccess, Visitor};
use serde::ser::{Serialize, SerializeTuple, Serializer};

/// Writes an array as a tuple.
///
/// # Errors
/// Those of the serializer.
pub fn serialize<S: Serializer, T: Serialize, const N: usize>(array: &[T; N], to: S) -> Result<S::Ok, S::Error> {
    elements(array, to)
}

fn elements<S: Serializer, T: Serialize>(array: &[T], to: S) -> Result<S::Ok, S::Error> {
    let mut tuple = to.serialize_tuple(array.len())?;
    array.iter().try_for_each(|element| tuple.serialize_element(element))?;
    tuple.end()
}

/// Reads an array from a tuple.
///
/// # Errors
/// Those of the deserializer; too few elements.
pub fn deserialize<'de, D: Deserializer<'de>, T, const N: usize>(from: D) -> Result<[T; N], D::Error>
where
    T: Deserialize<'de> + Copy + Default,
{
    let mut array = [T::default(); N];
    from.deserialize_tuple(N, Elements(&mut array))?;
    Ok(array)
}

/// Fills a slice.
struct Elements<'a, T>(&'a mut [T]);

impl<'de, T: Deserialize<'de>> Visitor<'de> for Elements<'_, T> {
    type Value = ();

    fn expecting(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        write!(f, "{} elements", self.0.len())
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut sequence: A) -> Result<(), A::Error> {
        for (i, element) in self.0.iter_mut().enumerate() {
            *element = sequence.next_element()?.ok_or_else(|| A::Error::invalid_length(i, &"more elements"))?;
        }
        Ok(())
    }
}
