//! Readers and engines on input that nobody would make on purpose: files that were cut, mixed and overwritten, and parts that are
//! valid but nasty. Whatever they are given, they answer, soon, and within their memory.
//!
//! `INPUTS` in the environment is the number of inputs of each test in place of its own, `SEED` another seed for them;
//! `scripts/fuzz HOURS` runs all tests so for hours.

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

#[global_allocator]
static MEMORY: limits::Memory = limits::Memory;

/// Number in the environment variable `name`, or `otherwise`.
fn number(name: &str, otherwise: u64) -> u64 {
    std::env::var(name).map_or(otherwise, |text| text.parse().unwrap_or_else(|_| panic!("{name} is {text}: no number")))
}

/// Runs `test` on `own` inputs of `make`, or as many as the environment asks for. Input number n is the same in every run.
fn campaign<T>(
    own: u64,
    make: impl Fn(&mut rand_chacha::ChaCha8Rng) -> T,
    test: impl Fn(&T),
    show: impl Fn(&T) -> String,
) {
    use rand::SeedableRng;
    let (inputs, seed) = (number("INPUTS", own), number("SEED", 0));
    for n in 0..inputs {
        let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(seed.wrapping_mul(1 << 32).wrapping_add(n));
        let input = make(&mut random);
        if let Err(why) = limits::within(|| test(&input)) {
            panic!("SEED={seed}, input {n}: {why}\n{}", show(&input));
        }
    }
    println!("{inputs} inputs from seed {seed}");
}
