//! A log of any bytes through identification, reading and ingest, as a batch does it.

use std::io::Write;

use roadbench::ingest;
use roadbench::pipeline::Pipeline;

/// Reads bytes as a log whose name ends as given. Errors are right; panics and hangs are not.
pub fn read(bytes: &[u8], extension: &str) {
    let mut file = tempfile::Builder::new()
        .suffix(extension)
        .tempfile()
        .expect("the machine's temporary folder");
    file.write_all(bytes).expect("the machine's temporary folder");
    let _ = ingest::identify(file.path(), &[]);
    if let Ok(raw) = ingest::read(file.path(), &[]) {
        let _ = ingest::run(raw, &Pipeline::onroad().ingest);
    }
}
