//! Guidance of the inputs by the coverage of the code: libFuzzer, which `scripts/fuzz` builds the tests with. The environment says
//! what it does: `FUZZ_TARGET` is the name of a test; with `FUZZ_WRITE` its ordinary inputs are written to that folder, and nothing
//! else is done. Without a name that is known the names are written to the standard output.

use std::sync::OnceLock;

use libfuzzer_sys::{fuzz_mutator, fuzz_target, fuzzer_mutate};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::{NAMED, limits, mutate, target::Target};

static TARGET: OnceLock<Target> = OnceLock::new();

fn target() -> &'static Target {
    TARGET.get_or_init(|| {
        let name = std::env::var("FUZZ_TARGET").unwrap_or_default();
        let Some((_, make)) = NAMED.iter().find(|(known, _)| *known == name) else {
            NAMED.iter().for_each(|(name, _)| println!("{name}"));
            std::process::exit(i32::from(!name.is_empty()));
        };
        let target = make();
        if let Some(folder) = std::env::var_os("FUZZ_WRITE") {
            for (n, input) in target.ordinary_inputs(&name).enumerate() {
                std::fs::write(std::path::Path::new(&folder).join(format!("{n:05}")), input)
                    .expect("a folder to write to");
            }
            std::process::exit(0);
        }
        target
    })
}

fuzz_target!(init: { target(); }, |bytes: &[u8]| {
    let tried = || {
        (target().check)(bytes);
    };
    if let Err(why) = limits::within(tried) {
        panic!("{why}");
    }
});

// Half of the changes are those of the ordinary tests, which know numbers and words; the others are those of libFuzzer, which knows
// what the code compares with.
fuzz_mutator!(|data: &mut [u8], size: usize, max_size: usize, seed: u32| {
    let mut random = ChaCha8Rng::seed_from_u64(seed.into());
    let seeds = &target().seeds;
    if seeds.is_empty() {
        let most = max_size.min(mutate::PART);
        return fuzzer_mutate(data, size.min(most), most);
    }
    if random.random_bool(0.5) {
        return fuzzer_mutate(data, size, max_size);
    }
    let mut bytes = data[..size].to_vec();
    mutate::change(&mut bytes, seeds, &mut random);
    let size = bytes.len().min(max_size);
    data[..size].copy_from_slice(&bytes[..size]);
    size
});
