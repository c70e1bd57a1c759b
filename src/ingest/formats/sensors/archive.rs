//! The texts in a ZIP archive, unpacked in memory within limits: an archive may claim to hold anything.

use std::io::Read;

use rawzip::{CompressionMethod, ZipArchive};

/// Files of an archive that are looked at.
const MOST_FILES: usize = 2000;
/// Largest text after unpacking, bytes: six hours of 400 Hz.
const LARGEST: u64 = 1 << 29;
/// All texts together, bytes: they are in memory at once.
const LARGEST_SUM: u64 = 1 << 30;
/// Largest ratio of packing, on average over a file: samples are not so alike.
const MOST_RATIO: u64 = 2000;

/// A file of an archive.
#[derive(Debug)]
pub(super) struct Entry {
    /// Its path in the archive.
    pub path: String,
    /// Its bytes; none of a file that was not asked for.
    pub bytes: Vec<u8>,
    /// Why it could not be unpacked whole.
    pub broken: Option<String>,
}

impl Entry {
    /// Its name without folders.
    pub(super) fn name(&self) -> &str {
        self.path.rsplit('/').next().unwrap_or(&self.path)
    }

    /// Its name without folders and ending.
    pub(super) fn stem(&self) -> &str {
        self.name().rsplit_once('.').map_or(self.name(), |n| n.0)
    }
}

/// The files of an archive; those that `wanted` (of the path) says are unpacked. Files that systems add (`__MACOSX`, hidden
/// ones) and folders are passed by.
///
/// # Errors
/// It is no archive, is cut off, or would unpack to more than can be read.
pub(super) fn entries(bytes: &[u8], wanted: impl Fn(&str) -> bool) -> Result<Vec<Entry>, String> {
    let archive = ZipArchive::from_slice(bytes)
        .map_err(|e| format!("the archive is damaged or cut off ({e}); export it again"))?;
    let mut out = Vec::new();
    let mut sum = 0_u64;
    for (count, entry) in archive.entries().enumerate() {
        let entry = entry.map_err(|e| format!("the archive's list of files is damaged ({e})"))?;
        if count == MOST_FILES {
            return Err(format!("the archive has more than {MOST_FILES} files"));
        }
        let path = String::from_utf8_lossy(entry.file_path().as_ref()).replace('\\', "/");
        let hidden = path.split('/').any(|part| part.starts_with('.') || part == "__MACOSX");
        if entry.is_dir() || hidden {
            continue;
        }
        let mut unpacked = Entry { path, bytes: Vec::new(), broken: None };
        if wanted(&unpacked.path) {
            let most = LARGEST.min(LARGEST_SUM - sum);
            match archive.get_entry(entry.wayfinder()) {
                Err(e) => unpacked.broken = Some(e.to_string()),
                Ok(packed) => {
                    let data = packed.data();
                    let most = most.min(MOST_RATIO.saturating_mul(data.len() as u64 + 64));
                    let read = match entry.compression_method() {
                        CompressionMethod::STORE => read(packed.verifying_reader(data), most),
                        CompressionMethod::DEFLATE => read(
                            packed.verifying_reader(flate2::read::DeflateDecoder::new(data)),
                            most,
                        ),
                        other => {
                            let name = other.name().unwrap_or("another way");
                            (
                                Vec::new(),
                                Some(format!("it is packed by {name}; pack it by Deflate")),
                            )
                        }
                    };
                    (unpacked.bytes, unpacked.broken) = read;
                    if unpacked.bytes.len() as u64 > most {
                        let (name, most) = (unpacked.name(), most >> 20);
                        return Err(format!("`{name}` in it unpacks to more than {most} MB"));
                    }
                }
            }
            sum += unpacked.bytes.len() as u64;
        }
        out.push(unpacked);
    }
    Ok(out)
}

/// At most one byte more than `most`, and why the rest could not be read.
fn read(from: impl Read, most: u64) -> (Vec<u8>, Option<String>) {
    let mut bytes = Vec::new();
    let end = from.take(most + 1).read_to_end(&mut bytes);
    (bytes, end.err().map(|e| e.to_string()))
}

/// An archive of texts, packed by Deflate: for tests.
#[cfg(test)]
pub(super) fn packed(files: &[(&str, &str)]) -> Vec<u8> {
    use std::io::Write as _;
    let mut out = Vec::new();
    let mut archive = rawzip::ZipArchiveWriter::new(&mut out);
    for (name, text) in files {
        let builder = archive.new_file(name).compression_method(CompressionMethod::DEFLATE);
        let (mut entry, config) = builder.start().expect("in memory");
        let packing =
            flate2::write::DeflateEncoder::new(&mut entry, flate2::Compression::default());
        let mut writer = config.wrap(packing);
        writer.write_all(text.as_bytes()).expect("in memory");
        let (packing, descriptor) = writer.finish().expect("in memory");
        packing.finish().expect("in memory");
        entry.finish(descriptor).expect("in memory");
    }
    archive.finish().expect("in memory");
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_are_unpacked_and_what_systems_add_is_passed_by() {
        let bytes = packed(&[
            ("run/Location.csv", "time,latitude\n1,2\n"),
            ("run/photo.jpg", "x"),
            ("__MACOSX/run/._Location.csv", "x"),
        ]);
        let all = entries(&bytes, |path| path.ends_with(".csv")).expect("an archive");
        let names: Vec<(&str, usize)> = all.iter().map(|e| (e.name(), e.bytes.len())).collect();
        assert_eq!(names, [("Location.csv", 18), ("photo.jpg", 0)]);
        assert_eq!(all[0].stem(), "Location");
        assert!(entries(&bytes[..bytes.len() / 2], |_| true).expect_err("cut").contains("cut off"));
    }

    #[test]
    fn what_unpacks_to_too_much_is_refused() {
        let bytes = packed(&[("a.csv", &"0".repeat(8 << 20))]);
        // 8 MB of one letter pack to 8 kB: a thousandth, which is let in
        assert!(entries(&bytes, |_| true).is_ok());
        let (text, broken) = read(std::io::repeat(0), 100);
        assert_eq!((text.len(), broken), (101, None));
    }
}
