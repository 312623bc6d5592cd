//! Inputs of chance: changes of files (of bits and bytes, of numbers in text, of whole stretches), and bytes for parts.

use std::convert::Infallible;

use rand::{Rng, RngExt, TryRng, seq::IndexedRandom};
use rand_chacha::ChaCha8Rng;

/// Numbers that readers stumble over.
const NUMBERS: [&str; 22] = [
    "0",
    "-0",
    "-1",
    "1",
    "2",
    "1e-9",
    "1e-320",
    "1e308",
    "1e309",
    "-1e300",
    "NaN",
    "inf",
    "-inf",
    "4294967295",
    "4294967296",
    "18446744073709551615",
    "9223372036854775808",
    "99999999999999999999999",
    "1,5",
    "0x7f",
    ".",
    "",
];
/// Words that mean something in one format or another.
const WORDS: [&str; 20] = [
    "\n", "\"", "'", "[[", "]]", "{", "}", "#", "=", ";", ",", "\t", "\u{feff}", "\u{202e}", "é", "\0", "true", "{{",
    "%}", "<!--",
];
/// Most bytes of an input.
const LONGEST: usize = 64 << 10;

/// Most bytes that a part is made of.
pub const PART: usize = 1024;

/// Any of `seeds` after one to eight changes; without seeds, bytes for a part.
pub fn input(seeds: &[Vec<u8>], random: &mut ChaCha8Rng) -> Vec<u8> {
    let Some(mut bytes) = seeds.choose(random).cloned() else {
        let mut bytes = vec![0; PART];
        random.fill_bytes(&mut bytes);
        return bytes;
    };
    for _ in 0..random.random_range(1..=8) {
        change(&mut bytes, seeds, random);
        bytes.truncate(LONGEST);
    }
    bytes
}

/// Bytes as numbers of chance; zeros follow the last of them. So a change of a byte changes one number of a part.
pub struct Bytes<'a>(pub &'a [u8]);

impl TryRng for Bytes<'_> {
    type Error = Infallible;

    fn try_next_u32(&mut self) -> Result<u32, Infallible> {
        let mut bytes = [0; 4];
        self.try_fill_bytes(&mut bytes).map(|()| u32::from_le_bytes(bytes))
    }

    fn try_next_u64(&mut self) -> Result<u64, Infallible> {
        let mut bytes = [0; 8];
        self.try_fill_bytes(&mut bytes).map(|()| u64::from_le_bytes(bytes))
    }

    fn try_fill_bytes(&mut self, to: &mut [u8]) -> Result<(), Infallible> {
        let (taken, left) = self.0.split_at(to.len().min(self.0.len()));
        to[..taken.len()].copy_from_slice(taken);
        to[taken.len()..].fill(0);
        self.0 = left;
        Ok(())
    }
}

/// A stretch of `bytes`, short for the most part.
fn stretch(bytes: &[u8], random: &mut ChaCha8Rng) -> std::ops::Range<usize> {
    let from = random.random_range(0..=bytes.len());
    let most = if random.random_bool(0.8) { 16 } else { bytes.len() };
    from..(from + random.random_range(0..=most)).min(bytes.len())
}

/// Changes `bytes` in one place.
pub fn change(bytes: &mut Vec<u8>, seeds: &[Vec<u8>], random: &mut ChaCha8Rng) {
    let at = random.random_range(0..=bytes.len());
    match random.random_range(0..12) {
        0 if at < bytes.len() => bytes[at] ^= 1 << random.random_range(0..8),
        1 if at < bytes.len() => bytes[at] = random.random(),
        2 => bytes.truncate(at),
        3 => drop(bytes.drain(stretch(bytes, random))),
        4 => {
            let again = bytes[stretch(bytes, random)].to_vec();
            drop(bytes.splice(at..at, again));
        }
        5 => {
            if let Some(other) = seeds.choose(random) {
                let piece = other[stretch(other, random)].to_vec();
                drop(bytes.splice(at..at, piece));
            }
        }
        6 => {
            let word: &str = WORDS.choose(random).copied().unwrap_or_default();
            drop(bytes.splice(at..at, word.bytes()));
        }
        // Counts and lengths of binary files.
        7 if at + 4 <= bytes.len() => {
            let value = *[0u32, 1, 2, 0x7fff_ffff, 0x8000_0000, u32::MAX, 0x7fc0_0000, 0x7f80_0000]
                .choose(random)
                .unwrap_or(&0);
            bytes[at..at + 4].copy_from_slice(&value.to_le_bytes());
        }
        _ => replace_number(bytes, random),
    }
}

/// Puts another number in the place of one that is written out, if there is any.
fn replace_number(bytes: &mut Vec<u8>, random: &mut ChaCha8Rng) {
    let is_of_number = |byte: u8| byte.is_ascii_digit() || b"+-.eE".contains(&byte);
    let start = random.random_range(0..=bytes.len());
    let Some(from) = (start..bytes.len()).find(|&i| bytes[i].is_ascii_digit()) else { return };
    let to = (from..bytes.len()).find(|&i| !is_of_number(bytes[i])).unwrap_or(bytes.len());
    let number: &str = NUMBERS.choose(random).copied().unwrap_or_default();
    drop(bytes.splice(from..to, number.bytes()));
}
