//! The SIMD level, chosen at run time.

use fearless_simd::Level;
use std::fmt;
use std::str::FromStr;

/// Instruction set that the kernels run on. Results are the same bits at every level.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum SimdLevel {
    /// x86-64 baseline, 4 lanes.
    Sse2,
    /// x86-64-v2, 4 lanes.
    Sse42,
    /// x86-64-v3, 8 lanes.
    Avx2,
    /// Ice Lake and later, Zen 4 and later, 16 lanes.
    Avx512,
    /// AArch64, 4 lanes.
    Neon,
}

impl SimdLevel {
    /// Every level, best first.
    pub const ALL: [Self; 5] = [Self::Avx512, Self::Avx2, Self::Sse42, Self::Sse2, Self::Neon];

    /// The best level of this machine.
    ///
    /// # Panics
    /// On a machine with none of the levels (a target that this crate does not name).
    #[must_use]
    pub fn detect() -> Self {
        Self::ALL
            .into_iter()
            .find(|level| level.is_available())
            .expect("every supported target has a baseline SIMD level")
    }

    /// Whether this machine has it.
    #[must_use]
    pub fn is_available(self) -> bool {
        self.token().is_some()
    }

    /// The levels of this machine, best first.
    #[must_use]
    pub fn available() -> Vec<Self> {
        Self::ALL.into_iter().filter(|level| level.is_available()).collect()
    }

    /// Proof for the kernels that the level is there.
    pub(crate) fn token(self) -> Option<Level> {
        let level = Level::new();
        #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
        return match self {
            Self::Sse2 => level.as_sse2().map(Level::Sse2),
            Self::Sse42 => level.as_sse4_2().map(Level::Sse4_2),
            Self::Avx2 => level.as_avx2().map(Level::Avx2),
            Self::Avx512 => level.as_avx512().map(Level::Avx512),
            Self::Neon => None,
        };
        #[cfg(target_arch = "aarch64")]
        return match self {
            Self::Neon => level.as_neon().map(Level::Neon),
            _ => None,
        };
    }
}

impl fmt::Display for SimdLevel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Sse2 => "sse2",
            Self::Sse42 => "sse4.2",
            Self::Avx2 => "avx2",
            Self::Avx512 => "avx512",
            Self::Neon => "neon",
        })
    }
}

impl FromStr for SimdLevel {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        let level =
            Self::ALL.into_iter().find(|level| level.to_string() == name).ok_or_else(|| {
                format!("unknown SIMD level '{name}'; levels: sse2, sse4.2, avx2, avx512, neon")
            })?;
        if level.is_available() {
            Ok(level)
        } else {
            let here: Vec<_> = Self::available().iter().map(ToString::to_string).collect();
            Err(format!("this machine has no {name}; it has {}", here.join(", ")))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_round_trip_and_missing_levels_are_refused() {
        for level in SimdLevel::available() {
            assert_eq!(level.to_string().parse(), Ok(level));
        }
        assert!("mmx".parse::<SimdLevel>().is_err());
        #[cfg(target_arch = "x86_64")]
        assert!("neon".parse::<SimdLevel>().is_err());
    }
}
