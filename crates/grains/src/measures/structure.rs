//! The structure of a pack: what a laboratory measures of snow in a tomograph.

mod sizes;
mod surface;
#[cfg(test)]
mod tests;

pub use sizes::Sizes;
use surface::surface_per_volume;

use super::bodies::united;
use super::lines::{Chord, Lines};
use super::region::Region;
use super::{Connections, Extent, connections};
use crate::{GrainField, ICE_DENSITY};
use snowgrain_geometry::Grain;

/// Farthest distance of the two-point correlation, in mean radii, and its steps.
const CORRELATION_RADII: f64 = 8.0;
const CORRELATION_STEPS: usize = 32;
/// Classes of chords and depths.
const CHORD_CLASSES: usize = 30;
const DEPTH_CLASSES: usize = 10;
/// Longest chord of the distribution, in mean chords.
const LONGEST_CHORD: f64 = 6.0;

/// What is measured of a pack; lengths in metres.
#[derive(Clone, Debug, PartialEq)]
pub struct Structure {
    /// Number of grains.
    pub grains: u64,
    /// Volume that was looked at, cubic metres.
    pub volume: f64,
    /// Part of it in ice, union of the grains; the density by that of ice.
    pub solid_fraction: f64,
    /// The same with overlaps counted twice.
    pub nominal_solid_fraction: f64,
    /// Surface of the union by volume, 1/m: from points on all grains.
    pub surface_per_volume: f64,
    /// Mean length of the stretches of a straight line in air and in ice, by their number.
    pub mean_air_chord: f64,
    /// In ice.
    pub mean_ice_chord: f64,
    /// Mean chord in ice along y by that along x and z: above 1 where ice stands upright.
    pub anisotropy: f64,
    /// Along x, y and z.
    pub along: [Directed; 3],
    /// Solid fraction by depth: equal parts of the depth, from the surface down.
    pub profile: Vec<f64>,
    /// Radii.
    pub sizes: Sizes,
    /// What touches what.
    pub connections: Connections,
}

/// What is measured along an axis.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Directed {
    /// Mean chords, metres.
    pub mean_air_chord: f64,
    /// In ice.
    pub mean_ice_chord: f64,
    /// Distance, metres, and probability that two points so far apart are both in ice.
    pub correlation: Vec<(f64, f64)>,
    /// Length of chords in air (middle of a class, metres), and density of their distribution, 1/m.
    pub air_chords: Vec<(f64, f64)>,
    /// The same in ice.
    pub ice_chords: Vec<(f64, f64)>,
}

impl Structure {
    /// Measures `field`; `touches_ground` says which grains the ground carries.
    #[must_use]
    pub fn of(field: &GrainField, extent: Extent, touches_ground: &dyn Fn(&Grain) -> bool) -> Self {
        let period = match extent {
            Extent::Periodic(period) => Some(period),
            Extent::Block | Extent::Draped => None,
        };
        let vertical = Lines::along(1, field, period, 0);
        let region = Region::of(field, extent, &vertical);
        let sizes = Sizes::of(field);
        let lines =
            [Lines::along(0, field, period, 0), vertical, Lines::along(2, field, period, 0)];
        let found =
            [0, 1, 2].map(|axis| Found::along(axis, &lines[axis], field, &region, sizes.mean));
        let sum = |part: fn(&Found) -> f64| found.iter().map(part).sum::<f64>();
        let (all, ice, crossings) = (sum(|f| f.all), sum(|f| f.ice), sum(|f| f.crossings));
        let directed = [0, 1, 2].map(|axis| found[axis].directed());
        let [x, y, z] = [0, 1, 2].map(|axis| directed[axis].mean_ice_chord);
        Self {
            grains: field.len() as u64,
            volume: region.volume(),
            solid_fraction: ratio(ice, all),
            nominal_solid_fraction: ratio(sum(|f| f.nominal), all),
            surface_per_volume: surface_per_volume(field, period, &region),
            mean_air_chord: ratio(2.0 * (all - ice), crossings),
            mean_ice_chord: ratio(2.0 * ice, crossings),
            anisotropy: ratio(2.0 * y, x + z),
            along: directed,
            profile: profile(&lines[1], &region),
            sizes,
            connections: connections(field, period, touches_ground),
        }
    }

    /// Density of the union, kg/m^3.
    #[must_use]
    pub fn density(&self) -> f64 {
        ICE_DENSITY * self.solid_fraction
    }

    /// Surface of the union by mass of ice, m^2/kg.
    #[must_use]
    pub fn specific_surface(&self) -> f64 {
        ratio(self.surface_per_volume, self.density())
    }
}

fn ratio(a: f64, b: f64) -> f64 {
    if b > 0.0 { a / b } else { 0.0 }
}

/// Sums along the lines of an axis.
#[derive(Clone, Debug, Default)]
struct Found {
    /// Lengths: of all, in ice, in ice by grains.
    all: f64,
    ice: f64,
    nominal: f64,
    /// Surfaces that were crossed.
    crossings: f64,
    /// Length over which both ends of a shift could be seen, and lay in ice, by steps of the shift.
    seen: Vec<f64>,
    both: Vec<f64>,
    step: f64,
    /// Lengths of chords that start in the region.
    air_chords: Vec<f64>,
    ice_chords: Vec<f64>,
}

impl Found {
    fn along(axis: usize, lines: &Lines, field: &GrainField, region: &Region, mean: f64) -> Self {
        let steps = CORRELATION_STEPS + 1;
        let step = CORRELATION_RADII * mean / CORRELATION_STEPS as f64;
        let (seen, both) = (vec![0.0; steps], vec![0.0; steps]);
        let mut found = Self { seen, both, step, ..Self::default() };
        let bounds = field.bounds();
        let range = [bounds.min[axis], bounds.max[axis]];
        let mut last = None;
        for (line, own) in lines.each() {
            // Lines that meet no grain are air where they pass the region.
            let first = last.map_or(0, |last: u32| last + 1);
            for empty in first..line {
                found.add(&[], region.stretches(axis, lines.place(empty), range));
            }
            last = Some(line);
            found.add(own, region.stretches(axis, lines.place(line), range));
        }
        found
    }

    fn add(&mut self, chords: &[Chord], stretches: Vec<[f64; 2]>) {
        let ice = in_ice(chords);
        for [low, high] in stretches {
            self.all += high - low;
            let part = |a: f64, b: f64| (b.min(high) - a.max(low)).max(0.0);
            self.nominal += chords.iter().map(|chord| part(chord.low, chord.high)).sum::<f64>();
            let within = |at: f64| (low..high).contains(&at);
            for (index, &[from, to]) in ice.iter().enumerate() {
                self.ice += part(from, to);
                self.crossings += f64::from(u8::from(within(from)) + u8::from(within(to)));
                if within(from) {
                    self.ice_chords.push(to - from);
                }
                if within(to)
                    && let Some(next) = ice.get(index + 1)
                {
                    self.air_chords.push(next[0] - to);
                }
            }
            self.correlate(&ice, [low, high]);
        }
    }

    /// Adds the lengths over which a point and one farther up are both within a stretch, and in ice.
    fn correlate(&mut self, ice: &[[f64; 2]], [low, high]: [f64; 2]) {
        let first = ice.partition_point(|piece| piece[1] < low);
        let last = ice.partition_point(|piece| piece[0] < high);
        let pieces = &ice[first.min(last)..last];
        for (index, (seen, both)) in self.seen.iter_mut().zip(&mut self.both).enumerate() {
            let shift = self.step * index as f64;
            let end = high - shift;
            if end <= low {
                break;
            }
            *seen += end - low;
            let mut ahead = 0;
            for piece in pieces {
                let (from, to) = (piece[0].max(low), piece[1].min(end));
                while ahead < pieces.len() && pieces[ahead][1] - shift < from {
                    ahead += 1;
                }
                for other in &pieces[ahead..] {
                    if other[0] - shift >= to {
                        break;
                    }
                    *both += (to.min(other[1] - shift) - from.max(other[0] - shift)).max(0.0);
                }
            }
        }
    }

    fn directed(&self) -> Directed {
        let correlation = self.seen.iter().zip(&self.both).enumerate();
        let (mean_air_chord, mean_ice_chord) = (
            ratio(2.0 * (self.all - self.ice), self.crossings),
            ratio(2.0 * self.ice, self.crossings),
        );
        Directed {
            mean_air_chord,
            mean_ice_chord,
            correlation: correlation
                .filter(|(_, (seen, _))| **seen > 0.0)
                .map(|(index, (seen, both))| (self.step * index as f64, both / seen))
                .collect(),
            air_chords: distribution(&self.air_chords, mean_air_chord),
            ice_chords: distribution(&self.ice_chords, mean_ice_chord),
        }
    }
}

/// The stretches in at least one grain.
fn in_ice(chords: &[Chord]) -> Vec<[f64; 2]> {
    united(chords.iter().map(|chord| [chord.low, chord.high]))
}

fn distribution(chords: &[f64], mean: f64) -> Vec<(f64, f64)> {
    if chords.is_empty() || mean <= 0.0 {
        return Vec::new();
    }
    let width = LONGEST_CHORD * mean / CHORD_CLASSES as f64;
    let mut counts = [0u64; CHORD_CLASSES];
    for chord in chords {
        if let Some(count) = counts.get_mut((chord / width) as usize) {
            *count += 1;
        }
    }
    let density = |count: u64| count as f64 / (chords.len() as f64 * width);
    let middle = |index: usize| (index as f64 + 0.5) * width;
    counts.iter().enumerate().map(|(index, &count)| (middle(index), density(count))).collect()
}

/// Solid fraction in equal parts of the depth, from the surface down, along vertical lines.
fn profile(vertical: &Lines, region: &Region) -> Vec<f64> {
    const STEPS: usize = 8;
    let mut sums = [[0.0f64; 2]; DEPTH_CLASSES];
    for (line, chords) in vertical.each() {
        let (place, ice) = (vertical.place(line), in_ice(chords));
        for [bottom, top] in region.whole(place) {
            let step = (top - bottom) / (DEPTH_CLASSES * STEPS) as f64;
            for index in 0..DEPTH_CLASSES * STEPS {
                let height = top - (index as f64 + 0.5) * step;
                let piece = ice.partition_point(|piece| piece[1] < height);
                let solid = ice.get(piece).is_some_and(|piece| piece[0] <= height);
                let sum = &mut sums[index / STEPS];
                sum[0] += step;
                sum[1] += if solid { step } else { 0.0 };
            }
        }
    }
    sums.iter().map(|sum| ratio(sum[1], sum[0])).collect()
}
