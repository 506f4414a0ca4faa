//! Which prototype a grain is and how it is turned, in one word.

use snowgrain_math::DMat3;

const STEPS: f64 = GrainShape::STEPS;
const COMPONENT_BITS: u32 = GrainShape::COMPONENT_BITS;
const COMPONENT: u64 = (1 << COMPONENT_BITS) - 1;
const LARGEST_SHIFT: u32 = GrainShape::LARGEST_SHIFT;
const PROTOTYPE_SHIFT: u32 = LARGEST_SHIFT + 2;

/// Prototype and orientation of a grain: 50 bits, that are the same wherever the grain is met.
///
/// The rotation is a unit quaternion of which the largest component is left out and the others are rounded
/// to 1/8191 of 1/sqrt(2), 1e-4 of a radian; like its position, a grain's orientation is rounded once, at birth.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct GrainShape(u64);

impl GrainShape {
    /// Prototypes that a scene can tell apart.
    pub const MOST_PROTOTYPES: usize = 64;
    /// Steps of a component of the quaternion from 0 to 1/sqrt(2).
    pub const STEPS: f64 = 8191.0;
    /// One such step.
    pub const STEP: f64 = core::f64::consts::FRAC_1_SQRT_2 / Self::STEPS;
    /// Bits of a component, from the lowest on; stored is the number of its step, plus [`Self::STEPS`].
    pub const COMPONENT_BITS: u32 = 14;
    /// Where two bits tell which component is the largest; the others are those that follow it in the ring x, y, z, w.
    pub const LARGEST_SHIFT: u32 = 3 * Self::COMPONENT_BITS;
    /// Bits used.
    pub const BITS: u32 = PROTOTYPE_SHIFT + 6;

    /// The prototype of this index, turned by the quaternion `[x, y, z, w]` of any length but 0.
    ///
    /// # Panics
    /// If the index is not below [`Self::MOST_PROTOTYPES`].
    #[must_use]
    pub fn new(prototype: usize, quaternion: [f64; 4]) -> Self {
        assert!(prototype < Self::MOST_PROTOTYPES, "prototypes are few");
        let mut largest = 0;
        for index in 1..4 {
            if quaternion[index].abs() > quaternion[largest].abs() {
                largest = index;
            }
        }
        let length = quaternion.iter().map(|c| c * c).sum::<f64>().sqrt();
        // A quaternion and its negative are one rotation.
        let scale = STEPS * core::f64::consts::SQRT_2 / length.copysign(quaternion[largest]);
        let mut word = (prototype as u64) << PROTOTYPE_SHIFT | (largest as u64) << LARGEST_SHIFT;
        for place in 0..3 {
            let component = quaternion[(largest + 1 + place) % 4];
            let steps = (component * scale).round().clamp(-STEPS, STEPS) + STEPS;
            word |= (steps as u64) << (COMPONENT_BITS * place as u32);
        }
        Self(word)
    }

    /// The prototype of this index as it is.
    #[must_use]
    pub fn upright(prototype: usize) -> Self {
        Self::new(prototype, [0.0, 0.0, 0.0, 1.0])
    }

    /// The word that [`Self::to_bits`] gave; `None` if it is no such word.
    #[must_use]
    pub fn from_bits(bits: u64) -> Option<Self> {
        let fits = bits >> Self::BITS == 0;
        let components_fit = (0..3)
            .all(|place| (bits >> (COMPONENT_BITS * place) & COMPONENT) as f64 <= 2.0 * STEPS);
        (fits && components_fit).then_some(Self(bits))
    }

    /// The word in the lower [`Self::BITS`] of `bits`, which [`Self::to_bits`] gave.
    #[inline(always)]
    #[must_use]
    pub fn from_low_bits(bits: u64) -> Self {
        Self(bits & ((1 << Self::BITS) - 1))
    }

    /// All of it in [`Self::BITS`] bits.
    #[inline(always)]
    #[must_use]
    pub fn to_bits(self) -> u64 {
        self.0
    }

    /// The orientation alone, 44 bits.
    #[must_use]
    pub fn orientation_bits(self) -> u64 {
        self.0 & ((1 << PROTOTYPE_SHIFT) - 1)
    }

    /// A prototype in the orientation that [`Self::orientation_bits`] gave; `None` if these are no such bits.
    #[must_use]
    pub fn of_orientation(prototype: usize, bits: u64) -> Option<Self> {
        if bits >> PROTOTYPE_SHIFT != 0 || prototype >= Self::MOST_PROTOTYPES {
            return None;
        }
        Self::from_bits(bits | (prototype as u64) << PROTOTYPE_SHIFT)
    }

    /// Index of the prototype.
    #[inline(always)]
    #[must_use]
    pub fn prototype(self) -> usize {
        (self.0 >> PROTOTYPE_SHIFT) as usize & (Self::MOST_PROTOTYPES - 1)
    }

    /// The same rotation of another prototype.
    ///
    /// # Panics
    /// As [`Self::new`].
    #[must_use]
    pub fn with_prototype(self, prototype: usize) -> Self {
        assert!(prototype < Self::MOST_PROTOTYPES, "prototypes are few");
        Self(self.0 & ((1 << PROTOTYPE_SHIFT) - 1) | (prototype as u64) << PROTOTYPE_SHIFT)
    }

    /// The unit quaternion `[x, y, z, w]`.
    #[inline(always)]
    #[must_use]
    pub fn quaternion(self) -> [f64; 4] {
        let largest = (self.0 >> LARGEST_SHIFT) as usize & 3;
        let component = |place: u32| {
            let steps = (self.0 >> (COMPONENT_BITS * place) & COMPONENT) as i32;
            f64::from(steps - STEPS as i32) * Self::STEP
        };
        let [a, b, c] = [component(0), component(1), component(2)];
        let rest = (1.0 - (a * a + b * b + c * c)).max(0.0).sqrt();
        // The others follow it in a ring. Looked up, as processors guess none of four ways.
        let ring = [rest, a, b, c];
        std::array::from_fn(|index| ring[index.wrapping_sub(largest) & 3])
    }

    /// From the prototype's own space to the world. The one decoding: all that meets a grain uses it.
    #[inline(always)]
    #[must_use]
    pub fn rotation(self) -> DMat3 {
        let [x, y, z, w] = self.quaternion();
        let (x2, y2, z2) = (x + x, y + y, z + z);
        let (xx, yy, zz) = (x * x2, y * y2, z * z2);
        let (xy, xz, yz) = (x * y2, x * z2, y * z2);
        let (wx, wy, wz) = (w * x2, w * y2, w * z2);
        DMat3::from_cols_array(&[
            1.0 - (yy + zz),
            xy + wz,
            xz - wy,
            xy - wz,
            1.0 - (xx + zz),
            yz + wx,
            xz + wy,
            yz - wx,
            1.0 - (xx + yy),
        ])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use snowgrain_math::sampler::{PathKey, numbers};

    #[test]
    fn rotations_are_kept_to_their_rounding_and_are_rotations() {
        for index in 0..2000 {
            let key = PathKey::new(4, index, 0);
            let [a, b, c] = numbers(key, 0).map(|u| 2.0 * f64::from(u) - 1.0);
            let d = 2.0 * f64::from(numbers(key, 1)[0]) - 1.0;
            let shape = GrainShape::new(index as usize % 64, [a, b, c, d]);
            assert_eq!(GrainShape::from_bits(shape.to_bits()), Some(shape));
            assert_eq!(shape.prototype(), index as usize % 64);
            let q = shape.quaternion();
            let length = (a * a + b * b + c * c + d * d).sqrt();
            let cosine = (q[0] * a + q[1] * b + q[2] * c + q[3] * d).abs() / length;
            assert!(cosine > 1.0 - 1e-8, "{cosine}");
            let off = shape.rotation() * shape.rotation().transpose() - DMat3::IDENTITY;
            assert!(off.to_cols_array().iter().all(|x| x.abs() < 1e-14));
            assert!(shape.rotation().determinant() > 0.0);
        }
        assert_eq!(GrainShape::upright(3).rotation(), DMat3::IDENTITY);
        assert_eq!(GrainShape::from_bits(u64::MAX), None);
    }

    #[test]
    fn a_rounded_orientation_rounds_to_itself() {
        for index in 0..500 {
            let [a, b, c] = numbers(PathKey::new(5, index, 0), 0).map(|u| f64::from(u) - 0.4);
            let shape = GrainShape::new(7, [a, b, c, 0.3]);
            assert_eq!(GrainShape::new(7, shape.quaternion()), shape);
        }
    }
}
