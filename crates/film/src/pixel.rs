//! The exact sums of one pixel.

use crate::FilmError;
use crate::exact::{Wide, power_of_two, spread, to_fixed};
use crate::sample::{LARGEST_GUIDE, Sample, SampleFault};

/// Fractional bits of sums of radiance and depth.
const FRACTION_BITS: i32 = 64;
/// Fractional bits of sums of squared radiance.
const SQUARE_FRACTION_BITS: i32 = 96;
/// Fractional bits of sums of albedo, normal and alpha.
const GUIDE_FRACTION_BITS: i32 = 24;
/// Radiances and depths from here on do not fit: their squares reach 2^96.
const LIMIT: f32 = (1u64 << 48) as f32;

/// Exact sums over the samples of one pixel; 208 bytes.
///
/// | sum | quantum | largest sum | so that fit |
/// |---|---|---|---|
/// | radiance (either sign), depth | 2^-64 | 2^63 (9.2e18) | 9.2e9 samples of radiance 1e9 |
/// | squared radiance | 2^-96 | 2^96 (7.9e28) | 7.9e10 samples of radiance 1e9 |
/// | albedo, normal, alpha | 2^-24 | 2^39 | 2^31 samples of magnitude 256 |
///
/// A sample is rounded to the quantum once, when it enters; a radiance of magnitude 2^-40 and more is stored
/// without any rounding. Beyond the range additions fail; nothing ever wraps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PixelSums {
    radiance: [i128; 3],
    radiance_squared: [Wide; 3],
    depth: u128,
    albedo: [u64; 3],
    normal: [i64; 3],
    alpha: u64,
    hits: u64,
    samples: u64,
}

impl PixelSums {
    /// Length of [`PixelSums::to_le_bytes`].
    pub const BYTES: usize = 208;

    /// The sums over this one sample.
    ///
    /// # Errors
    /// A value outside the range that [`Sample`] documents.
    pub fn from_sample(sample: &Sample) -> Result<Self, SampleFault> {
        let mut sums = Self { samples: 1, ..Self::default() };
        for (channel, &x) in sample.radiance.iter().enumerate() {
            let fault = SampleFault::Radiance(x);
            let magnitude = bounded(x.abs()).ok_or(fault)?.cast_signed();
            sums.radiance[channel] = if x < 0.0 { -magnitude } else { magnitude };
            let square = f64::from(x) * f64::from(x);
            sums.radiance_squared[channel] =
                Wide::from_f64(square, SQUARE_FRACTION_BITS).ok_or(fault)?;
        }
        for (channel, &x) in sample.albedo.iter().enumerate() {
            let fits = x >= 0.0;
            sums.albedo[channel] = guide(x).filter(|_| fits).ok_or(SampleFault::Albedo(x))?;
        }
        for (axis, &x) in sample.normal.iter().enumerate() {
            let magnitude = guide(x.abs()).ok_or(SampleFault::Normal(x))?.cast_signed();
            sums.normal[axis] = if x < 0.0 { -magnitude } else { magnitude };
        }
        let alpha = sample.alpha;
        let fits = (0.0..=1.0).contains(&alpha);
        sums.alpha = guide(alpha).filter(|_| fits).ok_or(SampleFault::Alpha(alpha))?;
        if sample.depth != f32::INFINITY {
            sums.depth = bounded(sample.depth).ok_or(SampleFault::Depth(sample.depth))?;
            sums.hits = 1;
        }
        Ok(sums)
    }

    /// Adds one sample, as [`PixelSums::from_sample`] and [`PixelSums::checked_add`] would, but in a
    /// tenth of their time; on an error nothing is added.
    ///
    /// # Errors
    /// A value outside the range that [`Sample`] documents; sums that leave their range.
    #[inline]
    pub fn add_sample(&mut self, sample: &Sample) -> Result<(), Refusal> {
        if !is_in_range(sample) {
            return Err(Self::from_sample(sample).err().map_or(Refusal::Overflow, Refusal::Sample));
        }
        let [r, g, b] = sample.radiance;
        let mut overflow = false;
        if r.to_bits() | g.to_bits() | b.to_bits() != 0 {
            let red = Channel::of(r);
            let green = if g == r { red } else { Channel::of(g) };
            let blue = if b == g { green } else { Channel::of(b) };
            for (index, channel) in [red, green, blue].into_iter().enumerate() {
                let (sum, added) = (&mut self.radiance[index], channel.radiance);
                overflow |= add(sum, added, i128::overflowing_add);
                let squares = &mut self.radiance_squared[index];
                overflow |= add(squares, channel.square, Wide::overflowing_add);
            }
        }
        if !is_nothing_hit(sample) {
            overflow |= self.add_guides(sample);
        }
        overflow |= add(&mut self.samples, 1, u64::overflowing_add);
        if overflow {
            // All sums are modulo a power of two, so that what was added can be taken away again.
            if let Ok(added) = Self::from_sample(sample) {
                self.withdraw(&added);
            }
            return Err(Refusal::Overflow);
        }
        Ok(())
    }

    /// Adds all but the radiance, and says whether that overflows.
    #[inline]
    fn add_guides(&mut self, sample: &Sample) -> bool {
        let mut overflow = false;
        for index in 0..3 {
            let albedo = small_quanta(sample.albedo[index]).cast_unsigned();
            overflow |= add(&mut self.albedo[index], albedo, u64::overflowing_add);
            let normal = signed_quanta(sample.normal[index]);
            overflow |= add(&mut self.normal[index], normal, i64::overflowing_add);
        }
        let alpha = small_quanta(sample.alpha).cast_unsigned();
        overflow |= add(&mut self.alpha, alpha, u64::overflowing_add);
        if sample.depth != f32::INFINITY {
            overflow |= add(&mut self.depth, large_quanta(sample.depth), u128::overflowing_add);
            overflow |= add(&mut self.hits, 1, u64::overflowing_add);
        }
        overflow
    }

    /// The sums over the samples of both; `None` where one does not fit.
    #[must_use]
    pub fn checked_add(&self, other: &Self) -> Option<Self> {
        let mut sums = *self;
        sums.add_sums(other).then_some(sums)
    }

    /// Adds the sums over other samples; `false`, and nothing is added, where one does not fit.
    #[inline]
    pub fn add_sums(&mut self, other: &Self) -> bool {
        // Sums everything and looks for overflow at the end: branches cost more than additions.
        let mut overflow = false;
        for i in 0..3 {
            overflow |= add(&mut self.radiance[i], other.radiance[i], i128::overflowing_add);
            let (wide, added) = (&mut self.radiance_squared[i], other.radiance_squared[i]);
            overflow |= add(wide, added, Wide::overflowing_add);
            overflow |= add(&mut self.albedo[i], other.albedo[i], u64::overflowing_add);
            overflow |= add(&mut self.normal[i], other.normal[i], i64::overflowing_add);
        }
        overflow |= add(&mut self.depth, other.depth, u128::overflowing_add);
        overflow |= add(&mut self.alpha, other.alpha, u64::overflowing_add);
        overflow |= add(&mut self.hits, other.hits, u64::overflowing_add);
        overflow |= add(&mut self.samples, other.samples, u64::overflowing_add);
        if overflow {
            self.withdraw(other);
        }
        !overflow
    }

    /// Takes away what was added modulo the ranges of the sums, whether or not that overflowed.
    #[cold]
    pub(crate) fn withdraw(&mut self, added: &Self) {
        for i in 0..3 {
            self.radiance[i] = self.radiance[i].wrapping_sub(added.radiance[i]);
            self.radiance_squared[i] =
                self.radiance_squared[i].wrapping_sub(added.radiance_squared[i]);
            self.albedo[i] = self.albedo[i].wrapping_sub(added.albedo[i]);
            self.normal[i] = self.normal[i].wrapping_sub(added.normal[i]);
        }
        self.depth = self.depth.wrapping_sub(added.depth);
        self.alpha = self.alpha.wrapping_sub(added.alpha);
        self.hits = self.hits.wrapping_sub(added.hits);
        self.samples = self.samples.wrapping_sub(added.samples);
    }

    /// Number of samples.
    #[must_use]
    pub fn samples(&self) -> u64 {
        self.samples
    }

    /// Mean radiance; 0 without samples.
    #[must_use]
    pub fn mean_radiance(&self) -> [f64; 3] {
        self.by_channel(|channel| self.mean(self.radiance[channel] as f64, FRACTION_BITS))
    }

    /// A function of the sums of each channel, which is asked once where they are equal: white snow
    /// under a white sky is the usual case.
    fn by_channel(&self, function: impl Fn(usize) -> f64) -> [f64; 3] {
        let same = |a: usize, b: usize| {
            self.radiance[a] == self.radiance[b]
                && self.radiance_squared[a] == self.radiance_squared[b]
        };
        let red = function(0);
        let green = if same(0, 1) { red } else { function(1) };
        let blue = if same(1, 2) { green } else { function(2) };
        [red, green, blue]
    }

    /// Unbiased estimate of the variance of [`PixelSums::mean_radiance`]; infinite with fewer than
    /// two samples, where nothing is known about it.
    #[must_use]
    pub fn variance_of_mean(&self) -> [f64; 3] {
        if self.samples < 2 {
            return [f64::INFINITY; 3];
        }
        let n = self.samples as f64;
        self.by_channel(|channel| {
            let sum = self.radiance[channel].unsigned_abs();
            let spread = spread(self.samples, self.radiance_squared[channel], sum);
            spread * power_of_two(-2 * FRACTION_BITS) / (n * n * (n - 1.0))
        })
    }

    /// Mean alpha; 0 without samples.
    #[must_use]
    pub fn mean_alpha(&self) -> f64 {
        self.mean(self.alpha as f64, GUIDE_FRACTION_BITS)
    }

    /// Mean albedo over all samples; 0 without samples.
    #[must_use]
    pub fn mean_albedo(&self) -> [f64; 3] {
        self.albedo.map(|sum| self.mean(sum as f64, GUIDE_FRACTION_BITS))
    }

    /// Mean normal over all samples, not renormalised; 0 without samples.
    #[must_use]
    pub fn mean_normal(&self) -> [f64; 3] {
        self.normal.map(|sum| self.mean(sum as f64, GUIDE_FRACTION_BITS))
    }

    /// Mean depth in metres over the samples that hit something; infinite where none did.
    #[must_use]
    pub fn mean_depth(&self) -> f64 {
        match self.hits {
            0 => f64::INFINITY,
            hits => self.depth as f64 * power_of_two(-FRACTION_BITS) / hits as f64,
        }
    }

    fn mean(&self, sum: f64, fraction_bits: i32) -> f64 {
        match self.samples {
            0 => 0.0,
            samples => sum * power_of_two(-fraction_bits) / samples as f64,
        }
    }

    /// The sums as bytes, little-endian, in the order: radiance, squared radiance, depth, albedo,
    /// normal, alpha, hits, samples.
    #[must_use]
    pub fn to_le_bytes(&self) -> [u8; Self::BYTES] {
        let mut bytes = [0; Self::BYTES];
        let mut rest = &mut bytes[..];
        let mut put = |field: &[u8]| {
            let (head, tail) = std::mem::take(&mut rest).split_at_mut(field.len());
            head.copy_from_slice(field);
            rest = tail;
        };
        self.radiance.iter().for_each(|sum| put(&sum.to_le_bytes()));
        self.radiance_squared.iter().flat_map(|w| w.0).for_each(|limb| put(&limb.to_le_bytes()));
        put(&self.depth.to_le_bytes());
        self.albedo.iter().for_each(|sum| put(&sum.to_le_bytes()));
        self.normal.iter().for_each(|sum| put(&sum.to_le_bytes()));
        [self.alpha, self.hits, self.samples].iter().for_each(|sum| put(&sum.to_le_bytes()));
        bytes
    }

    /// The inverse of [`PixelSums::to_le_bytes`]; any bytes are some sums.
    #[must_use]
    pub fn from_le_bytes(bytes: &[u8; Self::BYTES]) -> Self {
        let mut rest = &bytes[..];
        // Fields are read in the order in which they are written here.
        Self {
            radiance: std::array::from_fn(|_| i128::from_le_bytes(take(&mut rest))),
            radiance_squared: std::array::from_fn(|_| {
                Wide(std::array::from_fn(|_| u64::from_le_bytes(take(&mut rest))))
            }),
            depth: u128::from_le_bytes(take(&mut rest)),
            albedo: std::array::from_fn(|_| u64::from_le_bytes(take(&mut rest))),
            normal: std::array::from_fn(|_| i64::from_le_bytes(take(&mut rest))),
            alpha: u64::from_le_bytes(take(&mut rest)),
            hits: u64::from_le_bytes(take(&mut rest)),
            samples: u64::from_le_bytes(take(&mut rest)),
        }
    }
}

/// Adds sums pixel by pixel, or nothing where one does not fit; then says at which index.
pub(crate) fn add_all(sums: &mut [PixelSums], added: &[PixelSums]) -> Result<(), usize> {
    let pairs = sums.iter_mut().zip(added);
    let failed = pairs.map(|(sum, added)| sum.add_sums(added)).position(|fits| !fits);
    let Some(index) = failed else { return Ok(()) };
    sums.iter_mut().zip(added).take(index).for_each(|(sum, added)| sum.withdraw(added));
    Err(index)
}

/// Why [`PixelSums::add_sample`] adds nothing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Refusal {
    /// The sample holds a value that no light has.
    Sample(SampleFault),
    /// A sum would leave its range.
    Overflow,
}

impl Refusal {
    /// The same, said of a pixel.
    pub(crate) fn of(self, x: u32, y: u32) -> FilmError {
        match self {
            Self::Sample(fault) => FilmError::BadSample { x, y, fault },
            Self::Overflow => FilmError::Overflow { x, y },
        }
    }
}

/// Whether [`PixelSums::from_sample`] takes the sample. No branches: nearly all samples are taken.
#[inline]
fn is_in_range(sample: &Sample) -> bool {
    let mut fits = (0.0..=1.0).contains(&sample.alpha);
    for index in 0..3 {
        fits &= sample.radiance[index].abs() < LIMIT;
        fits &= (sample.albedo[index] >= 0.0) & (sample.albedo[index] <= LARGEST_GUIDE);
        fits &= sample.normal[index].abs() <= LARGEST_GUIDE;
    }
    fits & (sample.depth >= 0.0) & ((sample.depth < LIMIT) | (sample.depth == f32::INFINITY))
}

/// Whether all guides of a sample are 0, as they are where a path saw only the backdrop.
#[inline]
fn is_nothing_hit(sample: &Sample) -> bool {
    let guides = sample.albedo.into_iter().chain(sample.normal).chain([sample.alpha]);
    guides.fold(0, |bits, guide| bits | guide.to_bits()) == 0 && sample.depth == f32::INFINITY
}

/// What a channel's radiance adds to its sums.
#[derive(Clone, Copy)]
struct Channel {
    radiance: i128,
    square: Wide,
}

impl Channel {
    /// Of a radiance in `(-LIMIT, LIMIT)`.
    #[inline]
    fn of(x: f32) -> Self {
        let magnitude = large_quanta(x.abs()).cast_signed();
        let radiance = if x < 0.0 { -magnitude } else { magnitude };
        Self { radiance, square: square_quanta(x.abs()) }
    }
}

/// The significand, an integer of 24 bits, and the biased exponent of a normal number `x >= 0`:
/// `x = significand * 2^(exponent - 150)`.
#[inline]
fn significand_and_exponent(x: f32) -> (u32, u32) {
    let bits = x.to_bits();
    (bits & 0x7f_ffff | 0x80_0000, bits >> 23 & 0xff)
}

/// A radiance or depth in `[0, LIMIT)` in quanta of `2^-64`, as [`to_fixed`] rounds it: from `2^-40`
/// on all bits are kept, so that a shift is all there is to do.
#[inline]
fn large_quanta(x: f32) -> u128 {
    const EXACT: u32 = 150 - FRACTION_BITS.unsigned_abs();
    let (significand, exponent) = significand_and_exponent(x);
    if exponent >= EXACT {
        u128::from(significand) << (exponent - EXACT)
    } else {
        to_fixed(f64::from(x), FRACTION_BITS).unwrap_or(0)
    }
}

/// The square of a radiance in `[0, LIMIT)` in quanta of `2^-96`, as [`Wide::from_f64`] rounds it:
/// from `2^-24` on all bits are kept.
#[inline]
fn square_quanta(x: f32) -> Wide {
    const EXACT: u32 = 150 - SQUARE_FRACTION_BITS.unsigned_abs() / 2;
    let (significand, exponent) = significand_and_exponent(x);
    if exponent >= EXACT {
        let square = u64::from(significand) * u64::from(significand);
        Wide::shifted(square, 2 * (exponent - EXACT))
    } else {
        let square = f64::from(x) * f64::from(x);
        Wide::from_f64(square, SQUARE_FRACTION_BITS).unwrap_or_default()
    }
}

/// A guide value in `[0, LARGEST_GUIDE]` in its quanta, as [`to_fixed`] rounds it. Scaling by a power
/// of two is exact, and so is adding a half, for a number of 24 bits.
#[inline]
fn small_quanta(x: f32) -> i64 {
    const QUANTA: f64 = (1u64 << GUIDE_FRACTION_BITS) as f64;
    (f64::from(x) * QUANTA + 0.5) as i64
}

/// The same for both signs: magnitudes are rounded.
#[inline]
fn signed_quanta(x: f32) -> i64 {
    let magnitude = small_quanta(x.abs());
    if x < 0.0 { -magnitude } else { magnitude }
}

/// Adds to a sum and says whether that overflows.
#[inline]
fn add<T: Copy>(sum: &mut T, added: T, overflowing_add: impl Fn(T, T) -> (T, bool)) -> bool {
    let (total, overflow) = overflowing_add(*sum, added);
    *sum = total;
    overflow
}

/// Takes the first `N` bytes, which are there by [`PixelSums::BYTES`].
fn take<const N: usize>(rest: &mut &[u8]) -> [u8; N] {
    let mut field = [0; N];
    let (head, tail) = rest.split_at(N);
    field.copy_from_slice(head);
    *rest = tail;
    field
}

/// A radiance or depth as fixed point, where it is in range.
fn bounded(x: f32) -> Option<u128> {
    (0.0..LIMIT).contains(&x).then(|| to_fixed(f64::from(x), FRACTION_BITS)).flatten()
}

/// A guide value of magnitude `x` as fixed point, where it is in range.
fn guide(x: f32) -> Option<u64> {
    (0.0..=LARGEST_GUIDE)
        .contains(&x)
        .then(|| to_fixed(f64::from(x), GUIDE_FRACTION_BITS))
        .flatten()
        .and_then(|fixed| u64::try_from(fixed).ok())
}
