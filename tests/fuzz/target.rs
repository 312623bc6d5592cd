//! Readers and engines that are fuzzed, and the inputs of the ordinary tests.

use std::path::Path;

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::{limits, mutate};

/// Whether an input is answered, not refused; panics where something is wrong.
type Check = dyn Fn(&[u8]) -> bool + Send + Sync;

/// A reader or an engine, and how it is tried.
pub struct Target {
    /// Number of inputs of chance of the ordinary test.
    pub inputs: u64,
    /// Files to change; none where the bytes of an input are those that a part is made of.
    pub seeds: Vec<Vec<u8>>,
    /// Gives an input to the reader or the engine; returns whether it was answered.
    pub check: Box<Check>,
}

impl Target {
    /// Files to begin with, those that a campaign kept for the test `name`, and inputs of chance, which are the same in every run.
    pub fn ordinary_inputs(&self, name: &str) -> impl Iterator<Item = Vec<u8>> {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/fuzz").join(name);
        let mut kept: Vec<_> = folder.read_dir().into_iter().flatten().map(|file| file.unwrap().path()).collect();
        kept.sort();
        let kept = kept.into_iter().map(|file| std::fs::read(file).unwrap());
        let changed = (0..self.inputs).map(|n| mutate::input(&self.seeds, &mut ChaCha8Rng::seed_from_u64(n)));
        self.seeds.iter().cloned().chain(kept).chain(changed)
    }

    /// Tries every ordinary input.
    pub fn test(&self, name: &str) {
        let mut answered = 0;
        for (n, input) in self.ordinary_inputs(name).enumerate() {
            if let Err(why) = limits::within(|| answered += u32::from((self.check)(&input))) {
                let file = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{name}-{n}"));
                std::fs::write(&file, &input).unwrap();
                panic!("input {n}, which is written to {}: {why}", file.display());
            }
        }
        println!("{answered} inputs are answered");
        // Hardly a file can be read after its changes.
        assert!(answered > if self.seeds.is_empty() { 5 } else { 0 }, "{answered} inputs are answered");
    }
}
