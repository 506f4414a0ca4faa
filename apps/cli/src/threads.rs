//! The threads that the work runs on.

use crate::arguments::MachineArguments;
use crate::failure::Failure;
use rayon::{ThreadPool, ThreadPoolBuilder};

/// Threads that were asked for, else one for each processor.
pub(crate) fn threads(machine: &MachineArguments) -> usize {
    machine.threads.map_or_else(
        || std::thread::available_parallelism().map_or(1, std::num::NonZero::get),
        usize::from,
    )
}

/// # Errors
/// More threads than the system starts.
pub(crate) fn pool(machine: &MachineArguments) -> Result<ThreadPool, Failure> {
    let threads = threads(machine);
    ThreadPoolBuilder::new().num_threads(threads).build().map_err(|error| {
        Failure::refused(format!("{threads} threads cannot be started ({error}); use fewer"))
    })
}
