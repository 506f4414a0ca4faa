//! Files that appear whole or not at all (contract 7 of `ARCHITECTURE.md`).

use crate::FormatsError;
use crate::fault_injection::{self, Injection, Step};
use std::ffi::OsString;
use std::fs::{self, File};
use std::io::{self, BufWriter, IntoInnerError, Write};
use std::path::{Path, PathBuf};
use tempfile::NamedTempFile;

/// What temporary files are called: these around the number of the process and some letters.
const PREFIX: &str = ".snowgrain-";
const SUFFIX: &str = ".partial";
/// What the files are called that [`crate::Claim`] locks: the prefix and this around the name of the file.
const LOCK_SUFFIX: &str = ".lock";

/// Writes a file through a temporary one in the same folder: filled by `body`, flushed to the disk,
/// then renamed. On any error the file that was there before stays and the temporary one goes.
///
/// The permissions of a new file are those that the process gives to any new file. A link is
/// followed: the file it names is replaced, not the link.
///
/// # Errors
/// [`FormatsError::CannotCreate`] where no file can be made there, [`FormatsError::Write`] where
/// `body` or the disk fails, [`FormatsError::Unconfirmed`] where the disk fails after the file has its name.
pub fn write(
    path: &Path,
    body: impl FnOnce(&mut BufWriter<Content<'_>>) -> io::Result<()>,
) -> Result<(), FormatsError> {
    let target = target(path)?;
    let injection = Injection::of(path);
    let failed = |source| FormatsError::Write { path: path.to_path_buf(), source };
    let mut temporary = temporary_beside(path, &target)?;
    injection.reach(Step::Create).map_err(failed)?;
    fill(Content { file: temporary.as_file_mut(), written: 0, injection }, body).map_err(failed)?;
    injection.reach(Step::Rename).map_err(failed)?;
    temporary.persist(&target.file).map_err(|failure| cannot_create(path, &failure.error))?;
    let confirmed = injection.reach(Step::SyncFolder);
    let confirmed = confirmed.and_then(|()| sync_folder(&target.folder));
    confirmed
        .and_then(|()| injection.reach(Step::End))
        .map_err(|source| FormatsError::Unconfirmed { path: path.to_path_buf(), source })
}

/// The content of a file that is being written.
#[derive(Debug)]
pub struct Content<'a> {
    file: &'a mut File,
    written: u64,
    injection: Injection,
}

impl Write for Content<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.injection.reach(Step::Write { bytes: self.written })?;
        let room = self.injection.room(self.written).and_then(|room| usize::try_from(room).ok());
        let written = self.file.write(&bytes[..room.unwrap_or(usize::MAX).min(bytes.len())])?;
        self.written += written as u64;
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

/// Whether a file could be written there now, so that a long run does not end in a surprise. An
/// existing file is not touched. Temporary files that killed processes left in its folder are removed: they are
/// locked as long as someone writes to them.
///
/// # Errors
/// [`FormatsError::CannotCreate`]: the folder is missing or read-only, or the path is a folder or a
/// read-only file.
pub fn check_writable_target(path: &Path) -> Result<(), FormatsError> {
    let target = target(path)?;
    sweep(&target.folder);
    temporary_beside(path, &target).map(drop)
}

/// Where a file really goes.
struct Target {
    folder: PathBuf,
    file: PathBuf,
}

fn target(path: &Path) -> Result<Target, FormatsError> {
    let refuse = |reason: &str| {
        Err(FormatsError::CannotCreate { path: path.to_path_buf(), reason: reason.into() })
    };
    if let Err(reason) = fault_injection::check() {
        return refuse(reason);
    }
    if path.file_name().is_none() {
        return refuse("this does not name a file; add a file name");
    }
    let file = fs::canonicalize(path).unwrap_or_else(|_| path.to_path_buf());
    if let Ok(metadata) = fs::metadata(&file) {
        if metadata.is_dir() {
            return refuse("this is a folder; name a file in it");
        }
        if !metadata.is_file() {
            return refuse("this is not a regular file; name another");
        }
        if metadata.permissions().readonly() {
            return refuse("there is a read-only file; name another or make it writable");
        }
    }
    let folder = match file.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent.to_path_buf(),
        _ => PathBuf::from("."),
    };
    match fs::metadata(&folder) {
        Ok(metadata) if metadata.is_dir() => Ok(Target { folder, file }),
        Ok(_) => refuse(&format!("{} is not a folder; name another", folder.display())),
        Err(_) => refuse(&format!("there is no folder {}; make it first", folder.display())),
    }
}

fn temporary_beside(path: &Path, target: &Target) -> Result<NamedTempFile, FormatsError> {
    let prefix = format!("{PREFIX}{}-", std::process::id());
    let mut builder = tempfile::Builder::new();
    builder.prefix(&prefix).suffix(SUFFIX);
    #[cfg(unix)]
    let permissions = std::os::unix::fs::PermissionsExt::from_mode(0o666);
    #[cfg(unix)]
    builder.permissions(permissions);
    loop {
        let made = builder.tempfile_in(&target.folder);
        let temporary = made.map_err(|error| cannot_create(path, &error))?;
        match temporary.as_file().lock() {
            // Between its making and its lock another process may have swept it.
            Ok(()) if !is_there(temporary.as_file(), temporary.path()) => {}
            Ok(()) => return Ok(temporary),
            // Where files cannot be locked none is swept.
            Err(_) => return Ok(temporary),
        }
    }
}

/// The file that is locked as long as someone works on `path`.
pub(crate) fn lock_file(path: &Path) -> Result<PathBuf, FormatsError> {
    let Target { folder, file } = target(path)?;
    let mut name = OsString::from(PREFIX);
    name.push(file.file_name().unwrap_or_default());
    name.push(LOCK_SUFFIX);
    Ok(folder.join(name))
}

/// Whether an open file still stands where it was opened.
#[cfg(unix)]
pub(crate) fn is_there(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let identity = |metadata: fs::Metadata| (metadata.dev(), metadata.ino());
    let (own, found) = (file.metadata(), fs::symlink_metadata(path));
    own.is_ok_and(|own| found.is_ok_and(|found| identity(own) == identity(found)))
}

#[cfg(not(unix))]
pub(crate) fn is_there(_file: &File, path: &Path) -> bool {
    path.exists()
}

/// Removes temporary files and claims that nobody holds. What cannot be looked at is left.
fn sweep(folder: &Path) {
    let Ok(entries) = fs::read_dir(folder) else { return };
    for entry in entries.flatten() {
        let name = entry.file_name();
        let name = name.to_string_lossy();
        let is_file = entry.file_type().is_ok_and(|kind| kind.is_file());
        let is_ours = name.ends_with(SUFFIX) || name.ends_with(LOCK_SUFFIX);
        if !(is_file && name.starts_with(PREFIX) && is_ours) {
            continue;
        }
        if let Ok(file) = File::open(entry.path())
            && file.try_lock().is_ok()
            && is_there(&file, &entry.path())
        {
            // Whoever cannot remove it leaves it to others.
            let _ = fs::remove_file(entry.path());
        }
    }
}

pub(crate) fn cannot_create(path: &Path, error: &io::Error) -> FormatsError {
    // What the error says would name the temporary file, too.
    let reason = format!("{}; choose another folder or make this one writable", error.kind());
    FormatsError::CannotCreate { path: path.to_path_buf(), reason }
}

fn fill(
    content: Content<'_>,
    body: impl FnOnce(&mut BufWriter<Content<'_>>) -> io::Result<()>,
) -> io::Result<()> {
    let mut writer = BufWriter::with_capacity(1 << 20, content);
    body(&mut writer)?;
    let content = writer.into_inner().map_err(IntoInnerError::into_error)?;
    content.injection.reach(Step::Sync)?;
    content.file.sync_all()
}

/// Makes the new name durable, where the system can do that for folders.
#[cfg(unix)]
fn sync_folder(folder: &Path) -> io::Result<()> {
    match File::open(folder).and_then(|folder| folder.sync_all()) {
        Err(error)
            if matches!(
                error.kind(),
                io::ErrorKind::InvalidInput
                    | io::ErrorKind::Unsupported
                    | io::ErrorKind::PermissionDenied
            ) =>
        {
            Ok(()) // some file systems cannot, and a folder may be writable but not readable
        }
        result => result,
    }
}

#[cfg(not(unix))]
fn sync_folder(_folder: &Path) -> io::Result<()> {
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).unwrap();
        entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect()
    }

    #[test]
    fn a_file_appears_whole_and_replaces_the_old_one() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("out.bin");
        for content in ["first", "second"] {
            write(&path, |w| w.write_all(content.as_bytes())).unwrap();
            assert_eq!(fs::read_to_string(&path).unwrap(), content);
        }
        assert_eq!(names(folder.path()), ["out.bin"]);
    }

    #[test]
    fn a_failure_leaves_the_old_file_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("out.bin");
        fs::write(&path, "old").unwrap();
        let error = write(&path, |w| {
            w.write_all(&[0; 3 << 20])?;
            Err(io::Error::from(io::ErrorKind::StorageFull))
        })
        .unwrap_err();
        assert_eq!(error.exit_code(), 74);
        assert_eq!(fs::read_to_string(&path).unwrap(), "old");
        assert_eq!(names(folder.path()), ["out.bin"]);
    }

    #[test]
    fn what_killed_writers_left_is_swept_and_what_others_write_is_not() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("out.bin");
        fs::write(folder.path().join(".snowgrain-77-abc.partial"), "stale").unwrap();
        fs::write(folder.path().join(".other-77.partial"), "not ours").unwrap();
        let held = temporary_beside(&path, &target(&path).unwrap()).unwrap();
        check_writable_target(&path).unwrap();
        let mut left = names(folder.path());
        left.sort();
        let held = held.path().file_name().unwrap().to_string_lossy().into_owned();
        assert_eq!(left, [".other-77.partial", &held]);
    }

    #[test]
    fn what_cannot_be_created_is_said_before_any_work() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("file");
        fs::write(&file, "").unwrap();
        let read_only = folder.path().join("read-only");
        fs::write(&read_only, "").unwrap();
        let mut permissions = fs::metadata(&read_only).unwrap().permissions();
        permissions.set_readonly(true);
        fs::set_permissions(&read_only, permissions).unwrap();
        for path in [
            folder.path().to_path_buf(),
            folder.path().join("missing/out.png"),
            file.join("out.png"),
            PathBuf::from("/"),
            read_only,
        ] {
            let error = check_writable_target(&path).unwrap_err();
            assert_eq!(error.exit_code(), 73, "{error}");
            assert!(error.to_string().starts_with(&path.display().to_string()), "{error}");
        }
        check_writable_target(&folder.path().join("out.png")).unwrap();
        check_writable_target(&file).unwrap();
        assert_eq!(names(folder.path()).len(), 2);
    }

    #[cfg(unix)]
    #[test]
    fn a_link_is_followed_and_permissions_are_those_of_any_new_file() {
        use std::os::unix::fs::{PermissionsExt, symlink};
        let folder = tempfile::tempdir().unwrap();
        let (real, link) = (folder.path().join("real"), folder.path().join("link"));
        fs::write(&real, "old").unwrap();
        symlink(&real, &link).unwrap();
        let usual = fs::metadata(&real).unwrap().permissions().mode();
        write(&link, |w| w.write_all(b"new")).unwrap();
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(fs::read_to_string(&real).unwrap(), "new");
        assert_eq!(fs::metadata(&real).unwrap().permissions().mode(), usual);
    }
}
