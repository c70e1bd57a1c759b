//! Files of this machine that are replaced whole: a temporary beside the old file, then renamed over it. And files at
//! names of our own that are opened to be locked or added to: never through a link that somebody has put there.

use std::fs::{File, Metadata, OpenOptions};
use std::io::{Error, ErrorKind, Result, Write as _};
use std::path::{Path, PathBuf};

/// How the name of a local file that is still being written starts and ends.
pub(crate) const TEMPORARY: (&str, &str) = (".roadbench-", ".tmp");

/// Writes a file, whole or not at all, making its folder. A link, device or pipe of that name is replaced, too
/// ([`tables::output`](crate::store::tables::output) has the rule for what a user names). A file that was there keeps
/// its rights.
pub(super) fn replace(path: &Path, bytes: &[u8]) -> Result<()> {
    let folder = folder_of(path);
    make_folder(folder)?;
    let (temporary, mut file) = begin(folder, path)?;
    let written = fill(&mut file, bytes)
        .and_then(|()| keep_rights(&file, path))
        .and_then(|()| std::fs::rename(&temporary, path));
    if let Err(e) = written {
        let _ = std::fs::remove_file(&temporary);
        return Err(e);
    }
    sync_folder(folder)
}

/// The folder that a file lies in.
pub(crate) fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if folder != Path::new("") => folder,
        _ => Path::new("."),
    }
}

fn fill(file: &mut File, bytes: &[u8]) -> Result<()> {
    file.set_len(0)?; // what a writer has left that was killed
    file.write_all(bytes)?;
    file.sync_all()
}

/// The file that takes what is written until it is whole, locked. Its name is that of the target, so that what a killed
/// writer leaves is gone with the next one.
fn begin(folder: &Path, path: &Path) -> Result<(PathBuf, File)> {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let name = match name.len() {
        0..=200 => name.into_owned(),
        _ => blake3::hash(name.as_bytes()).to_hex().to_string(),
    };
    let temporary = folder.join(format!("{}{name}{}", TEMPORARY.0, TEMPORARY.1));
    loop {
        if std::fs::symlink_metadata(&temporary).is_ok_and(|there| !is_only_ours(&there)) {
            std::fs::remove_file(&temporary)?; // a link or device: what it leads to stays
        }
        let file = open(&temporary, File::options().create(true).truncate(false).write(true))?;
        let _ = file.lock(); // some network file systems have none: there two writers of one file are not separated
        // another writer of the same target may have put it in place while this one waited
        let is_same = |there: &Metadata| file.metadata().map(|own| same_file(&own, there));
        match std::fs::symlink_metadata(&temporary) {
            Ok(there) if is_only_ours(&there) && is_same(&there)? => return Ok((temporary, file)),
            Err(e) if e.kind() != ErrorKind::NotFound => return Err(e),
            _ => {}
        }
    }
}

/// A regular file without a second name, under which somebody may keep it.
#[cfg(unix)]
fn is_only_ours(there: &Metadata) -> bool {
    use std::os::unix::fs::MetadataExt;
    there.is_file() && there.nlink() == 1
}

#[cfg(not(unix))]
fn is_only_ours(there: &Metadata) -> bool {
    there.is_file()
}

/// Opens a file without following a link, and without waiting for the other end of a pipe.
fn open(path: &Path, options: &mut OpenOptions) -> Result<File> {
    #[cfg(unix)]
    {
        use std::os::unix::fs::OpenOptionsExt;
        options.custom_flags(libc::O_NOFOLLOW | libc::O_NONBLOCK);
    }
    options.open(path)
}

/// Opens a file at a name of our own, to lock it or to add to it; makes it where there is none, with its folder.
///
/// # Errors
/// It cannot be opened, or is a link, a device or anything else but a file: it is not written through.
pub(crate) fn open_own(path: &Path, options: &mut OpenOptions) -> Result<File> {
    let strange = || {
        let what =
            "it is a link, folder, pipe or device where a file of roadbench's belongs; remove it";
        Error::new(ErrorKind::InvalidInput, what)
    };
    std::fs::create_dir_all(folder_of(path))?;
    if std::fs::symlink_metadata(path).is_ok_and(|there| !there.is_file()) {
        return Err(strange());
    }
    let file = open(path, options)?;
    if file.metadata()?.is_file() { Ok(file) } else { Err(strange()) }
}

/// Gives a file the owner and the rights of the one that it replaces; a new one has what the user's `umask` says.
#[cfg(unix)]
fn keep_rights(file: &File, path: &Path) -> Result<()> {
    use std::os::unix::fs::{MetadataExt, fchown};
    let Ok(there) = std::fs::symlink_metadata(path) else { return Ok(()) };
    if !there.is_file() {
        return Ok(());
    }
    let own = file.metadata()?;
    if (own.uid(), own.gid()) != (there.uid(), there.gid()) {
        let _ = fchown(file, Some(there.uid()), Some(there.gid())); // root may
    }
    file.set_permissions(there.permissions())
}

#[cfg(not(unix))]
fn keep_rights(_: &File, _: &Path) -> Result<()> {
    Ok(())
}

/// Whether two names are of one file.
#[cfg(unix)]
pub(crate) fn same_file(a: &Metadata, b: &Metadata) -> bool {
    use std::os::unix::fs::MetadataExt;
    (a.dev(), a.ino()) == (b.dev(), b.ino())
}

/// Whether two names are of one file.
#[cfg(not(unix))]
pub fn same_file(_: &Metadata, _: &Metadata) -> bool {
    true // a file that is open is not replaced there
}

/// Makes a folder and those above it, and has each written down in the one above.
fn make_folder(folder: &Path) -> Result<()> {
    if folder.is_dir() {
        return Ok(());
    }
    std::fs::create_dir_all(folder)?;
    for above in folder.ancestors().skip(1).take(4).filter(|a| a.is_dir()) {
        sync_folder(above)?;
    }
    Ok(())
}

/// A name that was given in a folder survives a power cut only when the folder is written down too.
///
/// # Errors
/// It is not there, or the disk fails.
pub(crate) fn sync_folder(folder: &Path) -> Result<()> {
    if cfg!(unix) { File::open(folder)?.sync_all() } else { Ok(()) }
}

#[cfg(test)]
#[cfg(unix)]
mod tests {
    use std::os::unix::fs::{PermissionsExt, symlink};

    use super::*;

    /// Makes a second way to a file.
    type Plant = fn(&Path, &Path) -> Result<()>;

    fn text(path: &Path) -> String {
        std::fs::read_to_string(path).expect("readable")
    }

    #[test]
    fn a_replaced_file_keeps_its_rights_and_leaves_no_temporary() {
        let folder = tempfile::tempdir().expect("folder");
        let path = folder.path().join("a");
        for mode in [0o600, 0o664] {
            std::fs::write(&path, "before").expect("written");
            std::fs::set_permissions(&path, PermissionsExt::from_mode(mode)).expect("mode");
            replace(&path, b"now").expect("replaced");
            let kept = std::fs::metadata(&path).expect("there").permissions().mode();
            assert_eq!((kept & 0o7777, text(&path).as_str()), (mode, "now"));
        }
        replace(&folder.path().join("no/x"), b"").expect("made");
        replace(folder.path(), b"").expect_err("a folder");
        assert_eq!(std::fs::read_dir(folder.path()).expect("list").count(), 2);
    }

    /// Somebody has put links at the names of our temporaries: what they lead to is nobody's business.
    #[test]
    fn no_temporary_is_written_through_a_link() {
        let folder = tempfile::tempdir().expect("folder");
        let at = |name: &str| folder.path().join(name);
        std::fs::write(at("kept"), "kept").expect("written");
        let plant: [(&str, Plant); 2] =
            [("link", |a, b| symlink(a, b)), ("second name", |a, b| std::fs::hard_link(a, b))];
        for (how, plant) in plant {
            plant(&at("kept"), &at(".roadbench-t.tmp")).expect(how);
            replace(&at("t"), b"table").unwrap_or_else(|e| panic!("{how}: {e}"));
            assert_eq!(
                (text(&at("kept")), text(&at("t"))),
                ("kept".into(), "table".into()),
                "{how}"
            );
        }
        symlink(at("not there"), at(".roadbench-t.tmp")).expect("link");
        replace(&at("t"), b"again").expect("replaced");
        assert!(!at("not there").exists() && text(&at("t")) == "again");
    }

    #[test]
    fn no_file_of_ours_is_opened_through_a_link() {
        let folder = tempfile::tempdir().expect("folder");
        let at = |name: &str| folder.path().join(name);
        std::fs::write(at("kept"), "kept").expect("written");
        symlink(at("kept"), at("link")).expect("link");
        symlink(at("not there"), at("dangling")).expect("link");
        std::fs::create_dir(at("folder")).expect("folder");
        let open = |name: &str| open_own(&at(name), File::options().create(true).append(true));
        for name in ["link", "dangling", "folder"] {
            assert!(open(name).expect_err(name).to_string().contains("remove it"), "{name}");
        }
        assert!(!at("not there").exists());
        open("deep/new").expect("made").write_all(b"x").expect("written");
        open("deep/new").expect("there").write_all(b"y").expect("written");
        assert_eq!(text(&at("deep/new")), "xy");
    }
}
