//! What was learnt as bytes, to be taken up again by another run.
//!
//! Little-endian: `SNOWLRNT`; the version, the number of slots and of levels, 4 bytes each; the corners of all places, six
//! doubles; of each level the number of its cells, 8 bytes, and three coordinates and the number of the outcome of each, 4 bytes
//! each; the number of outcomes, 8 bytes, and the numbers of each, floats; BLAKE3 of the key and of all bytes before, 32 bytes.

use super::levels::{Cell, Levels};
use super::outcome::{Outcome, PARTS};
use snowgrain_math::DVec3;

const MAGIC: &[u8; 8] = b"SNOWLRNT";
const VERSION: u32 = 1;
const HASH_BYTES: usize = 32;

/// Where learnt light is kept from one run to the next, by keys that tell the scene, its seed and how it is learnt.
pub struct LearntStore<'a> {
    /// What is kept under a key.
    pub load: &'a mut dyn FnMut(&[u8; 32]) -> Option<Vec<u8>>,
    /// Keeps it.
    pub save: &'a mut dyn FnMut(&[u8; 32], &[u8]),
}

impl core::fmt::Debug for LearntStore<'_> {
    fn fmt(&self, formatter: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        formatter.write_str("LearntStore")
    }
}

impl Levels {
    /// As bytes that are told from those of another key.
    pub(super) fn to_bytes(&self, key: &[u8; 32]) -> Vec<u8> {
        let mut bytes = MAGIC.to_vec();
        let mut put = |word: &[u8]| bytes.extend_from_slice(word);
        put(&VERSION.to_le_bytes());
        put(&(self.slots as u32).to_le_bytes());
        put(&(self.cells.len() as u32).to_le_bytes());
        let corners = [self.low, self.high].map(|corner| corner.to_array());
        corners.as_flattened().iter().for_each(|along| put(&along.to_le_bytes()));
        for cells in &self.cells {
            let mut cells: Vec<(u32, Cell)> =
                cells.iter().map(|(&cell, &number)| (number, cell)).collect();
            cells.sort_unstable();
            put(&(cells.len() as u64).to_le_bytes());
            for (number, cell) in cells {
                cell.iter().for_each(|along| put(&along.to_le_bytes()));
                put(&number.to_le_bytes());
            }
        }
        put(&(self.outcomes.len() as u64).to_le_bytes());
        for outcome in &self.outcomes {
            outcome.parts().iter().for_each(|part| put(&part.to_le_bytes()));
            put(&outcome.standard_error.to_le_bytes());
        }
        let hash = hash(key, &bytes);
        bytes.extend_from_slice(&hash);
        bytes
    }

    /// Of such bytes; `None` where they are damaged or of another key.
    pub(super) fn from_bytes(key: &[u8; 32], bytes: &[u8]) -> Option<Self> {
        let (content, told) = bytes.split_last_chunk::<HASH_BYTES>()?;
        if hash(key, content) != *told {
            return None;
        }
        let mut rest = Rest(content.strip_prefix(MAGIC)?);
        if rest.u32()? != VERSION {
            return None;
        }
        let (slots, levels) = (rest.u32()? as usize, rest.u32()?);
        let low = DVec3::new(rest.f64()?, rest.f64()?, rest.f64()?);
        let high = DVec3::new(rest.f64()?, rest.f64()?, rest.f64()?);
        let cells = (0..levels).map(|_| {
            let count = rest.u64()?;
            let cell = |rest: &mut Rest<'_>| {
                let along = [rest.u32()?, rest.u32()?, rest.u32()?];
                Some((along.map(u32::cast_signed), rest.u32()?))
            };
            (0..count).map(|_| cell(&mut rest)).collect::<Option<_>>()
        });
        let cells = cells.collect::<Option<_>>()?;
        let count = rest.u64()?;
        let outcome = |rest: &mut Rest<'_>| {
            let mut parts = [0.0; PARTS];
            for part in &mut parts {
                *part = rest.f32()?;
            }
            Some(Outcome::of_parts(parts, rest.f32()?))
        };
        let outcomes = (0..count).map(|_| outcome(&mut rest)).collect::<Option<_>>()?;
        Some(Self { low, high, cells, slots, outcomes })
    }
}

fn hash(key: &[u8; 32], content: &[u8]) -> [u8; HASH_BYTES] {
    let mut hasher = blake3::Hasher::new();
    hasher.update(key).update(content);
    *hasher.finalize().as_bytes()
}

/// Bytes that are still to be read.
struct Rest<'a>(&'a [u8]);

impl Rest<'_> {
    fn take<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (taken, rest) = self.0.split_first_chunk()?;
        self.0 = rest;
        Some(*taken)
    }

    fn u32(&mut self) -> Option<u32> {
        self.take().map(u32::from_le_bytes)
    }

    fn u64(&mut self) -> Option<u64> {
        self.take().map(u64::from_le_bytes)
    }

    fn f32(&mut self) -> Option<f32> {
        self.take().map(f32::from_le_bytes)
    }

    fn f64(&mut self) -> Option<f64> {
        self.take().map(f64::from_le_bytes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::transport::deep::samples::Samples;

    #[test]
    fn what_was_learnt_comes_back_and_damage_is_found() {
        let mut samples = Samples::new(1, 0);
        for path in 0..500 {
            let place = DVec3::new(f64::from(path % 10), f64::from(path % 3), f64::from(path % 7));
            let light = f64::from(path % 5);
            samples.push(place, [1.0; 3], std::iter::once([light; PARTS]));
        }
        let levels = Levels::of(&samples);
        let (key, other) = ([3; 32], [4; 32]);
        let bytes = levels.to_bytes(&key);
        assert_eq!(Levels::from_bytes(&key, &bytes), Some(levels));
        assert_eq!(Levels::from_bytes(&other, &bytes), None);
        for at in [0, 9, bytes.len() / 2, bytes.len() - 1] {
            let mut damaged = bytes.clone();
            damaged[at] ^= 1;
            assert_eq!(Levels::from_bytes(&key, &damaged), None);
        }
        assert_eq!(Levels::from_bytes(&key, &bytes[..bytes.len() - 1]), None);
    }
}
