//! What takes long is made once for all tests that read it.

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::time::UNIX_EPOCH;

/// The folder `name` of what takes long and many tests read, which `make` fills: whoever comes first makes it, others wait
/// for that. Tests run in processes of their own, and a program that was built anew may make something else.
pub fn made_once(name: &str, make: impl FnOnce(&Path)) -> PathBuf {
    let all = Path::new(env!("CARGO_TARGET_TMPDIR")).join("made_once").join(name);
    fs::create_dir_all(&all).unwrap();
    let lock = File::create(all.join("lock")).unwrap();
    lock.lock().unwrap();
    let built = |program: &Path| {
        let file = fs::metadata(program).unwrap();
        format!("{}_{}", file.modified().unwrap().duration_since(UNIX_EPOCH).unwrap().as_nanos(), file.len())
    };
    let programs = [std::env::current_exe().unwrap(), env!("CARGO_BIN_EXE_sparkpath").into()];
    let folder = all.join(programs.map(|program| built(&program)).join("_"));
    let whole = folder.join("whole");
    if !whole.exists() {
        // What earlier programs made, and what was begun and not ended.
        let old = fs::read_dir(&all).unwrap().map(|entry| entry.unwrap().path());
        old.filter(|path| path.is_dir()).for_each(|path| fs::remove_dir_all(path).unwrap());
        fs::create_dir(&folder).unwrap();
        make(&folder);
        File::create(whole).unwrap();
    }
    folder
}
