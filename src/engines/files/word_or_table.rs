//! Values that files have as a word or as a table.

use std::fmt;
use std::marker::PhantomData;
use std::str::FromStr;

use serde::de::value::MapAccessDeserializer;
use serde::de::{DeserializeOwned, Deserializer, Error, MapAccess, Visitor};

/// Reads a value from its word, which [`FromStr`] understands, or from the table `T`; `expected` says what it may be.
///
/// # Errors
/// What [`FromStr`] or the table finds wrong, or that it is neither.
pub fn word_or_table<'de, V, T, D>(deserializer: D, expected: &'static str) -> Result<V, D::Error>
where
    V: FromStr<Err = String> + From<T>,
    T: DeserializeOwned,
    D: Deserializer<'de>,
{
    deserializer.deserialize_any(WordOrTable { expected, of: PhantomData::<(V, T)> })
}

struct WordOrTable<V, T> {
    expected: &'static str,
    of: PhantomData<(V, T)>,
}

impl<'de, V: FromStr<Err = String> + From<T>, T: DeserializeOwned> Visitor<'de> for WordOrTable<V, T> {
    type Value = V;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(self.expected)
    }

    fn visit_str<E: Error>(self, word: &str) -> Result<V, E> {
        word.parse().map_err(E::custom)
    }

    fn visit_map<A: MapAccess<'de>>(self, table: A) -> Result<V, A::Error> {
        T::deserialize(MapAccessDeserializer::new(table)).map(V::from)
    }
}
