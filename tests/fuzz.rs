//! Readers and engines on input that nobody would make on purpose: files that were cut, mixed and overwritten, and parts that are
//! valid but nasty. Whatever they are given, they answer, soon, and within their memory.
//!
//! With `FUZZ_SECONDS` in the environment every test takes inputs for so long instead of a number of its own, with `FUZZ_SEED` other
//! inputs: `scripts/fuzz HOURS`. `FUZZ_INPUT` is the number of a single input, which is shown as a whole.

#[path = "fuzz/limits.rs"]
mod limits;
#[path = "common/mesh_files.rs"]
mod mesh_files;
#[path = "fuzz/mutate.rs"]
mod mutate;
#[path = "fuzz/parts.rs"]
mod parts;
#[path = "fuzz/readers.rs"]
mod readers;

use std::time::{Duration, Instant};

#[global_allocator]
static MEMORY: limits::Memory = limits::Memory;

/// Number in the environment variable `name`.
fn number(name: &str) -> Option<u64> {
    let text = std::env::var(name).ok()?;
    Some(text.parse().unwrap_or_else(|_| panic!("{name} is {text}: no number")))
}

/// Runs `test` on `own` inputs of `make`, or on as many as there is time for. Input number n of a seed is the same in every run.
fn campaign<T>(
    own: u64,
    make: impl Fn(&mut rand_chacha::ChaCha8Rng) -> T,
    test: impl Fn(&T),
    show: impl Fn(&T) -> String,
) {
    use rand::SeedableRng;
    let seed = number("FUZZ_SEED").unwrap_or(0);
    let until = number("FUZZ_SECONDS").map(|seconds| Instant::now() + Duration::from_secs(seconds));
    let only = number("FUZZ_INPUT");
    let goes_on = |n: u64| match (only, until) {
        (Some(only), _) => n == only,
        (None, Some(until)) => Instant::now() < until,
        (None, None) => n < own,
    };
    let mut n = only.unwrap_or(0);
    while goes_on(n) {
        let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(seed.wrapping_mul(1 << 32).wrapping_add(n));
        let input = make(&mut random);
        if only.is_some() {
            println!("{}", show(&input));
        }
        if let Err(why) = limits::within(until.is_some(), || test(&input)) {
            panic!("seed {seed}, input {n}: {why}\n{}", show(&input));
        }
        n += 1;
    }
    println!("{n} inputs of seed {seed}");
}
