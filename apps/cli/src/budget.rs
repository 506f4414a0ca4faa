//! Whether there is room for what was asked, said before anything is made.

use crate::failure::Failure;
use crate::process;
use snowgrain_render::{CostEstimate, RenderError};

/// How much memory may be used, and who says so.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Budget {
    bytes: u64,
    limit: &'static str,
}

impl Budget {
    /// The least of `--max-memory`, what is free on this machine, the limit of the control group, and
    /// that of the address space.
    /// `None` where nothing limits or says.
    pub(crate) fn of_this_machine(max_memory: Option<u64>) -> Option<Self> {
        [
            (max_memory, "--max-memory"),
            (process::available_memory(), "free on this machine"),
            (process::control_group_memory(), "the limit of the control group"),
            (process::address_space_limit(), "the limit of the address space"),
        ]
        .into_iter()
        .filter_map(|(bytes, limit)| Some(Self { bytes: bytes?, limit }))
        .min_by_key(|budget| budget.bytes)
    }

    /// # Errors
    /// A need that exceeds the budget.
    pub(crate) fn check(self, cost: &CostEstimate) -> Result<(), Failure> {
        let needed = cost.peak_bytes();
        if needed <= self.bytes {
            return Ok(());
        }
        Err(RenderError::Memory {
            needed: format!("{} ({} grains)", readable_bytes(needed), cost.grains),
            available: readable_bytes(self.bytes),
            limit: self.limit.into(),
        }
        .into())
    }
}

/// Bytes for people: `1.5 GiB`.
pub(crate) fn readable_bytes(bytes: u64) -> String {
    const UNITS: [&str; 5] = ["KiB", "MiB", "GiB", "TiB", "PiB"];
    if bytes < 1024 {
        return format!("{bytes} B");
    }
    let mut amount = bytes as f64 / 1024.0;
    let mut unit = 0;
    while amount >= 1024.0 && unit + 1 < UNITS.len() {
        amount /= 1024.0;
        unit += 1;
    }
    format!("{amount:.1} {}", UNITS[unit])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_least_limit_counts_and_refusal_names_the_figures() {
        let budget = Budget::of_this_machine(Some(1 << 20)).unwrap();
        assert_eq!(budget, Budget { bytes: 1 << 20, limit: "--max-memory" });
        let cost = CostEstimate { grains: 7, grain_bytes: 3 << 20, ..CostEstimate::default() };
        let failure = budget.check(&cost).unwrap_err();
        assert_eq!(failure.code, 69);
        for part in ["3.0 MiB (7 grains)", "1.0 MiB", "--max-memory"] {
            assert!(failure.message.contains(part), "{failure}");
        }
        assert!(budget.check(&CostEstimate::default()).is_ok());
    }

    #[test]
    fn bytes_are_readable() {
        assert_eq!(readable_bytes(1023), "1023 B");
        assert_eq!(readable_bytes(1536), "1.5 KiB");
        assert_eq!(readable_bytes(u64::MAX), "16384.0 PiB");
    }
}
