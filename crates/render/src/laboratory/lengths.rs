//! Lengths in ice of the paths that ended alike, kept so that any absorption can be applied.

use snowgrain_math::trig;

/// Bins of a length for each doubling of it, and the shortest length that has a bin, in radii.
const BINS_PER_DOUBLING: f64 = 32.0;
const SHORTEST: f64 = 1.0 / 16.0;
/// As many as reach 2^44 radii; the first is that of paths without ice.
const BINS: usize = 1 + 48 * 32;

/// Lengths in one layer, in bins 2 % wide: of each the sums that give the mean light of its paths and
/// the mean of its square. Within a bin the mean length stands for all, which changes the light by
/// less than 2e-5 of it.
#[derive(Clone, Debug)]
pub(super) struct LengthHistogram {
    bins: Vec<Bin>,
}

#[derive(Clone, Copy, Debug, Default)]
struct Bin {
    weight: f64,
    length: f64,
    square: f64,
    square_length: f64,
}

/// Light of paths: means over all that were traced.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Light {
    pub(super) mean: f64,
    /// Of its square.
    pub(super) mean_of_squares: f64,
}

impl Default for LengthHistogram {
    fn default() -> Self {
        Self { bins: vec![Bin::default(); BINS] }
    }
}

impl LengthHistogram {
    pub(super) fn add(&mut self, weight: f64, length: f64) {
        let bin = if length < SHORTEST {
            0
        } else {
            let doublings = trig::ln(length / SHORTEST) * core::f64::consts::LOG2_E;
            (1 + (doublings * BINS_PER_DOUBLING) as usize).min(BINS - 1)
        };
        let bin = &mut self.bins[bin];
        bin.weight += weight;
        bin.length += weight * length;
        bin.square += weight * weight;
        bin.square_length += weight * weight * length;
    }

    pub(super) fn merge(&mut self, other: &Self) {
        for (mine, theirs) in self.bins.iter_mut().zip(&other.bins) {
            mine.weight += theirs.weight;
            mine.length += theirs.length;
            mine.square += theirs.square;
            mine.square_length += theirs.square_length;
        }
    }

    /// The light that is left where a radius of ice absorbs `absorption`, of `paths` paths in all.
    pub(super) fn light(&self, absorption: f64, paths: u64) -> Light {
        let exp = trig::exp;
        let mut light = Light::default();
        for bin in self.bins.iter().filter(|bin| bin.weight > 0.0) {
            let squared_length = bin.square_length / bin.square;
            let left = exp(-absorption * squared_length);
            light.mean += bin.weight * exp(-absorption * bin.length / bin.weight);
            light.mean_of_squares += bin.square * left * left;
        }
        light.divided_by(paths as f64)
    }
}

/// The ends of paths through layers.
#[derive(Clone, Debug)]
pub(super) enum Ends {
    /// Through one layer: out of the top, out of the bottom.
    OneLayer([LengthHistogram; 2]),
    /// Through several: every path, its weight, whether it left by the bottom, and its lengths one
    /// after another.
    Layers { count: usize, paths: Vec<(f32, bool)>, lengths: Vec<f64> },
}

impl Ends {
    pub(super) fn of(layers: usize) -> Self {
        match layers {
            1 => Self::OneLayer(Default::default()),
            count => Self::Layers { count, paths: Vec::new(), lengths: Vec::new() },
        }
    }

    pub(super) fn add(&mut self, weight: f32, below: bool, ice_lengths: &[f64]) {
        match self {
            Self::OneLayer(ends) => {
                ends[usize::from(below)].add(weight.into(), ice_lengths[0]);
            }
            Self::Layers { paths, lengths, .. } => {
                paths.push((weight, below));
                lengths.extend_from_slice(ice_lengths);
            }
        }
    }

    pub(super) fn merge(&mut self, other: &Self) {
        match (self, other) {
            (Self::OneLayer(mine), Self::OneLayer(theirs)) => {
                mine.iter_mut().zip(theirs).for_each(|(mine, theirs)| mine.merge(theirs));
            }
            (
                Self::Layers { paths, lengths, .. },
                Self::Layers { paths: more_paths, lengths: more_lengths, .. },
            ) => {
                paths.extend_from_slice(more_paths);
                lengths.extend_from_slice(more_lengths);
            }
            _ => unreachable!("ends of one number of layers are merged"),
        }
    }

    /// The light out of the top and out of the bottom, where a radius of ice of each layer absorbs
    /// `absorption`.
    pub(super) fn light(&self, absorption: &[f64], all: u64) -> [Light; 2] {
        match self {
            Self::OneLayer(ends) => [0, 1].map(|end: usize| ends[end].light(absorption[0], all)),
            Self::Layers { count, paths, lengths } => {
                let mut light = [Light::default(); 2];
                for ((weight, below), lengths) in paths.iter().zip(lengths.chunks(*count)) {
                    let depth: f64 = lengths.iter().zip(absorption).map(|(l, a)| l * a).sum();
                    let (weight, left) = (f64::from(*weight), trig::exp(-depth));
                    let light = &mut light[usize::from(*below)];
                    light.mean += weight * left;
                    light.mean_of_squares += weight * weight * left * left;
                }
                light.map(|light| light.divided_by(all as f64))
            }
        }
    }
}

impl Light {
    fn divided_by(self, n: f64) -> Self {
        Self { mean: self.mean / n, mean_of_squares: self.mean_of_squares / n }
    }
}
