//! Results of long computations, kept in a folder of the program so that they are shown again at once.
//!
//! The hash of a result's inputs is the name of its file. A result is read back to the last bit as this program wrote
//! it; that does not tell whether the result is right.

use std::fs;
use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use std::sync::OnceLock;
use std::time::SystemTime;

use flate2::Compression;
use flate2::read::DeflateDecoder;
use flate2::write::DeflateEncoder;
use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::document::sha256;
use crate::write_bytes;

/// Ending of the name of a result.
const ENDING: &str = "kept";
/// Version of the form of results.
const VERSION: u32 = 2;
/// Most bytes of an unpacked result.
const LARGEST_PLAIN: u64 = 4 << 30;
/// Bytes of the hash before a result, in hexadecimal.
const HASH: usize = 64;

/// Fingerprint of this build of the program: a build shows only its own results.
fn build() -> &'static str {
    static BUILD: OnceLock<String> = OnceLock::new();
    BUILD.get_or_init(|| {
        let program = std::env::current_exe().and_then(fs::metadata).ok();
        let made = program.as_ref().and_then(|data| data.modified().ok());
        let seconds = made.and_then(|made| made.duration_since(SystemTime::UNIX_EPOCH).ok()).unwrap_or_default();
        format!("{} {} {}", env!("CARGO_PKG_VERSION"), program.map_or(0, |data| data.len()), seconds.as_nanos())
    })
}

/// A folder of results. The oldest results are removed when the folder grows too large.
#[derive(Debug, Clone)]
pub struct ResultCache {
    folder: PathBuf,
    most: u64,
}

impl ResultCache {
    /// The results in `folder`, with at most `most` bytes.
    pub fn new(folder: &Path, most: u64) -> Self {
        Self { folder: folder.to_owned(), most }
    }

    fn file<K: Serialize>(&self, what: &str, key: &K) -> Option<PathBuf> {
        let mut name = format!("{VERSION} {} {what} ", build()).into_bytes();
        ciborium::into_writer(key, &mut name).ok()?;
        Some(self.folder.join(format!("{what}-{}.{ENDING}", sha256(&name))))
    }

    /// Whether there is a result `what` for `key`.
    pub fn has<K: Serialize>(&self, what: &str, key: &K) -> bool {
        self.file(what, key).is_some_and(|file| file.is_file())
    }

    /// The result `what` for `key`. A damaged result counts as none and is removed.
    pub fn get<K: Serialize, V: DeserializeOwned>(&self, what: &str, key: &K) -> Option<V> {
        let file = self.file(what, key)?;
        let mut bytes = Vec::new();
        fs::File::open(&file).ok()?.take(self.most).read_to_end(&mut bytes).ok()?;
        let read = |bytes: &[u8]| {
            let (hash, packed) = bytes.split_at_checked(HASH)?;
            if sha256(packed).as_bytes() != hash {
                return None;
            }
            let mut plain = Vec::new();
            DeflateDecoder::new(packed).take(LARGEST_PLAIN).read_to_end(&mut plain).ok()?;
            ciborium::from_reader(plain.as_slice()).ok()
        };
        let value = read(&bytes);
        if value.is_none() {
            let _ = fs::remove_file(&file);
        } else if let Ok(file) = fs::File::options().append(true).open(&file) {
            // What is looked at goes last.
            let _ = file.set_modified(SystemTime::now());
        }
        value
    }

    /// Keeps the result `what` for `key`. A result that cannot be kept is computed again another time.
    pub fn put<K: Serialize, V: Serialize>(&self, what: &str, key: &K, value: &V) {
        let pack = || {
            let mut plain = Vec::new();
            ciborium::into_writer(value, &mut plain).ok()?;
            let mut packed = DeflateEncoder::new(Vec::new(), Compression::fast());
            packed.write_all(&plain).ok()?;
            packed.finish().ok()
        };
        let (Some(file), Some(packed)) = (self.file(what, key), pack()) else { return };
        let whole = [sha256(&packed).as_bytes(), &packed].concat();
        if whole.len() as u64 > self.most || fs::create_dir_all(&self.folder).is_err() {
            return;
        }
        self.make_room(whole.len() as u64);
        let _ = write_bytes(&file, &whole);
    }

    /// Removes the oldest results until there is room for so many bytes.
    fn make_room(&self, bytes: u64) {
        let Ok(entries) = fs::read_dir(&self.folder) else { return };
        let of = |path: PathBuf| {
            let data = fs::metadata(&path).ok()?;
            Some((data.modified().ok()?, path, data.len()))
        };
        let kept =
            entries.flatten().map(|entry| entry.path()).filter(|path| path.extension().is_some_and(|e| e == ENDING));
        let mut kept: Vec<(SystemTime, PathBuf, u64)> = kept.filter_map(of).collect();
        kept.sort();
        let mut all: u64 = kept.iter().map(|(.., size)| size).sum();
        for (_, path, size) in kept {
            if all + bytes <= self.most {
                return;
            }
            if fs::remove_file(path).is_ok() {
                all -= size;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_result_is_found_by_its_key_to_the_last_bit() {
        let folder = tempfile::tempdir().unwrap();
        let cache = ResultCache::new(&folder.path().join("results"), 1 << 20);
        let value = vec![0.1 + 0.2, f64::INFINITY, -0.0, 1e-300];
        cache.put("uncut", &("part", 0.02), &value);
        assert!(cache.has("uncut", &("part", 0.02)) && !cache.has("uncut", &("part", 0.03)));
        let read: Vec<f64> = cache.get("uncut", &("part", 0.02)).unwrap();
        assert_eq!(
            read.iter().map(|x| x.to_bits()).collect::<Vec<_>>(),
            value.iter().map(|x| x.to_bits()).collect::<Vec<_>>()
        );
        assert_eq!(cache.get::<_, Vec<f64>>("electrodes", &("part", 0.02)), None);
        assert_eq!(cache.get::<_, String>("uncut", &("part", 0.02)), None, "of another form it is none");
    }

    #[test]
    fn what_is_damaged_is_none() {
        let folder = tempfile::tempdir().unwrap();
        let cache = ResultCache::new(folder.path(), 1 << 20);
        for damage in [|bytes: &mut Vec<u8>| bytes.truncate(20), |bytes: &mut Vec<u8>| bytes[70] ^= 1] {
            cache.put("uncut", &1, &"0123456789".repeat(20));
            let file = fs::read_dir(folder.path()).unwrap().next().unwrap().unwrap().path();
            let mut bytes = fs::read(&file).unwrap();
            damage(&mut bytes);
            fs::write(&file, bytes).unwrap();
            assert_eq!(cache.get::<_, String>("uncut", &1), None);
            assert!(!cache.has("uncut", &1));
        }
    }

    #[test]
    fn the_oldest_go_when_there_is_no_room() {
        let folder = tempfile::tempdir().unwrap();
        // Bytes that cannot be packed.
        let value = |n: u64| (0..500).map(|i| sha256(&(n * 1000 + i).to_le_bytes())).collect::<Vec<_>>();
        let cache = ResultCache::new(folder.path(), 60_000);
        for n in 0..6 {
            cache.put("uncut", &n, &value(n));
            let file = cache.file("uncut", &n).unwrap();
            let written = SystemTime::UNIX_EPOCH + std::time::Duration::from_secs(n);
            fs::File::options().append(true).open(file).unwrap().set_modified(written).unwrap();
        }
        let kept: Vec<u64> = (0..6).filter(|n| cache.has("uncut", n)).collect();
        assert!(kept.len() > 1 && kept.len() < 6 && kept.ends_with(&[4, 5]), "{kept:?}");
        cache.put("uncut", &9, &(0..10).map(value).collect::<Vec<_>>());
        assert!(!cache.has("uncut", &9) && cache.has("uncut", &5), "what is too large takes no other's place");
    }
}
