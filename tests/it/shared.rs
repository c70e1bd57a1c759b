//! What several tests read and one of them makes.

use std::fs::File;
use std::path::{Path, PathBuf};
use std::time::UNIX_EPOCH;

/// Copies a folder with all that is in it; the folder of `to` is there.
pub fn copy_folder(from: &Path, to: &Path) {
    for entry in walkdir::WalkDir::new(from) {
        let entry = entry.expect("an entry");
        let to = to.join(entry.path().strip_prefix(from).expect("below"));
        match entry.file_type().is_dir() {
            true => std::fs::create_dir(to).expect("a folder"),
            false => _ = std::fs::copy(entry.path(), to).expect("copied"),
        }
    }
}

/// A folder that `make` fills, once for all tests and for this build of the program. Others wait until it is there; they
/// copy what they change.
pub fn folder_of(name: &str, make: impl FnOnce(&Path)) -> PathBuf {
    let program = assert_cmd::cargo::cargo_bin("roadbench");
    let built = std::fs::metadata(program).and_then(|data| data.modified()).expect("a program");
    let built = built.duration_since(UNIX_EPOCH).expect("after 1970").as_nanos();
    let root = Path::new(env!("CARGO_TARGET_TMPDIR"));
    let lock = File::create(root.join(format!("{name}.lock"))).expect("a lock");
    lock.lock().expect("locked"); // until it is dropped
    let folder = root.join(format!("{name}_{built}"));
    if folder.is_dir() {
        return folder;
    }
    for entry in std::fs::read_dir(root).expect("a folder").flatten() {
        if entry.file_name().to_string_lossy().starts_with(&format!("{name}_")) {
            std::fs::remove_dir_all(entry.path()).expect("an earlier build's");
        }
    }
    let new = tempfile::tempdir_in(root).expect("a folder");
    make(new.path());
    std::fs::rename(new.keep(), &folder).expect("renamed");
    folder
}
