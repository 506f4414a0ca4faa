//! Signals that ask the program to stop: the first lets it keep what it has, the second does not.

use std::sync::atomic::{AtomicBool, AtomicU8, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

/// What the thread that waits for signals and the rest of the program share.
#[derive(Debug, Default)]
struct Shared {
    /// Set by the first signal once there is something to keep.
    stop: AtomicBool,
    /// Number of the first signal; 0 where there was none.
    signal: AtomicU8,
    /// Whether there is something to keep, so that the first signal must not end the program.
    keeps: AtomicBool,
    /// Held while a file is written, so that none is left behind half-written.
    writing: Mutex<()>,
}

/// From now on a file that grows beyond the limit of the process fails to be written, and does not end it.
pub(crate) fn survive_file_size_limit() {
    platform::survive_file_size_limit();
}

/// Signals that ask the program to stop.
#[derive(Clone, Debug)]
pub(crate) struct Interrupts(Arc<Shared>);

impl Interrupts {
    /// From now on a signal ends the program, but not while it writes a file.
    pub(crate) fn watch() -> Self {
        let shared = Arc::new(Shared::default());
        platform::watch(Arc::clone(&shared));
        Self(shared)
    }

    /// From now on the first signal only sets [`Self::stop`].
    pub(crate) fn keep_what_there_is(&self) {
        self.0.keeps.store(true, Ordering::SeqCst);
    }

    /// Set when the work shall stop.
    pub(crate) fn stop(&self) -> &AtomicBool {
        &self.0.stop
    }

    /// The signal that came, if one came, as an exit code (130 for Ctrl-C, 143 for SIGTERM).
    pub(crate) fn exit_code(&self) -> Option<u8> {
        match self.0.signal.load(Ordering::SeqCst) {
            0 => None,
            signal => Some(128 + signal),
        }
    }

    /// Writes files; the program is not ended by a signal meanwhile.
    pub(crate) fn while_writing<T>(&self, write: impl FnOnce() -> T) -> T {
        let _guard = self.0.writing.lock().unwrap_or_else(PoisonError::into_inner);
        write()
    }
}

impl Shared {
    /// Called for every signal, by number.
    #[cfg(unix)]
    fn arrived(&self, signal: u8) {
        let first =
            self.signal.compare_exchange(0, signal, Ordering::SeqCst, Ordering::SeqCst).is_ok();
        if first && self.keeps.load(Ordering::SeqCst) {
            self.stop.store(true, Ordering::SeqCst);
            return;
        }
        let _guard = self.writing.lock().unwrap_or_else(PoisonError::into_inner);
        crate::output::tell("snowgrain: stopped by a signal; nothing more was written");
        std::process::exit(i32::from(128 + signal));
    }
}

#[cfg(unix)]
mod platform {
    use super::Shared;
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM, SIGXFSZ};
    use signal_hook::iterator::Signals;
    use std::sync::Arc;

    /// A limit on the size of files is then an error of who writes, and no end of the program.
    pub(super) fn survive_file_size_limit() {
        // Where that cannot be had the program ends there, and leaves the old file.
        let _ = signal_hook::flag::register(SIGXFSZ, Arc::default());
    }

    /// Without a thread for them, signals simply end the program, as they would anyway.
    pub(super) fn watch(shared: Arc<Shared>) {
        let wanted = [SIGINT, SIGTERM, SIGHUP];
        let heeded = wanted.into_iter().filter(|&signal| !is_ignored(signal));
        let Ok(mut signals) = Signals::new(heeded) else { return };
        std::thread::spawn(move || {
            for signal in signals.forever() {
                shared.arrived(signal.unsigned_abs() as u8);
            }
        });
    }

    /// Whether whoever started the program wants the signal ignored, as `nohup` does.
    fn is_ignored(signal: i32) -> bool {
        let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
        let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
        let mask = mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).unwrap_or(0);
        mask >> (signal - 1) & 1 == 1
    }
}

#[cfg(not(unix))]
mod platform {
    pub(super) fn survive_file_size_limit() {}

    /// Signals end the program.
    pub(super) fn watch(_shared: std::sync::Arc<super::Shared>) {}
}
