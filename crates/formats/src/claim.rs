//! The claim of a run on a file that it will work on for long.
//!
//! Two runs that go on with the same film would overwrite each other's samples. So a run holds a locked file beside
//! the film, `.snowgrain-NAME.lock`; a run that was killed holds none, whatever it left.

use crate::FormatsError;
use crate::atomic::{self, is_there};
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{Read as _, Write as _};
use std::path::{Path, PathBuf};
use std::time::Duration;

/// How often a lock is tried: whoever sweeps the folder holds it for a moment.
const TRIES: u32 = 20;
const BETWEEN_TRIES: Duration = Duration::from_millis(10);

/// A claim on a file; it ends when this is dropped, and with the process in any case.
#[derive(Debug)]
pub struct Claim {
    path: PathBuf,
    file: File,
}

impl Claim {
    /// Claims the file `path`, which need not be there. On file systems without locks nobody is kept out.
    ///
    /// # Errors
    /// [`FormatsError::Busy`] where another run holds it, [`FormatsError::CannotCreate`] where no file can be made
    /// in its folder.
    pub fn take(path: &Path) -> Result<Self, FormatsError> {
        let lock = atomic::lock_file(path)?;
        for _ in 0..TRIES {
            let mut options = OpenOptions::new();
            options.read(true).write(true).create(true).truncate(false);
            let file = options.open(&lock).map_err(|error| atomic::cannot_create(path, &error))?;
            match file.try_lock() {
                // Between its opening and its lock another process may have removed it.
                Ok(()) if !is_there(&file, &lock) => {}
                Ok(()) | Err(TryLockError::Error(_)) => {
                    let mut claim = Self { path: lock, file };
                    claim.sign();
                    return Ok(claim);
                }
                Err(TryLockError::WouldBlock) => std::thread::sleep(BETWEEN_TRIES),
            }
        }
        let path = path.to_path_buf();
        Err(FormatsError::Busy { path, process: signature(&lock) })
    }

    /// Writes the number of this process into the file. Whoever cannot stays unnamed.
    fn sign(&mut self) {
        let _ = self.file.set_len(0);
        let _ = write!(self.file, "{}", std::process::id());
    }
}

/// The number of the process that holds a lock, as it wrote it.
fn signature(lock: &Path) -> Option<u32> {
    let mut text = String::new();
    File::open(lock).ok()?.take(20).read_to_string(&mut text).ok()?;
    text.parse().ok()
}

impl Drop for Claim {
    fn drop(&mut self) {
        // While it is locked, so that nobody else's goes. What stays is swept by others.
        let _ = std::fs::remove_file(&self.path);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_claimed_by_one_at_a_time() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.film");
        let lock = folder.path().join(".snowgrain-a.film.lock");
        std::fs::write(&lock, "999999999 left by a killed run").unwrap();
        let claim = Claim::take(&path).unwrap();
        let error = Claim::take(&path).unwrap_err();
        assert_eq!(error.exit_code(), 75);
        let own = format!("process {}", std::process::id());
        assert!(error.to_string().contains(&own), "{error}");
        Claim::take(&folder.path().join("b.film")).unwrap();
        atomic::check_writable_target(&path).unwrap();
        assert!(lock.exists(), "a claim that is held is not swept");
        drop(claim);
        assert!(!lock.exists());
        drop(Claim::take(&path).unwrap());
        std::fs::write(&lock, "").unwrap();
        atomic::check_writable_target(&path).unwrap();
        assert!(!lock.exists(), "a claim that nobody holds is swept");
    }
}
