//! The structure of a pack: what a laboratory measures of snow in a tomograph.

use super::buckets::Buckets;
use super::lines::{Chord, Lines};
use super::region::Region;
use super::{Connections, Extent, connections};
use crate::{GrainField, ICE_DENSITY};
use core::f64::consts::{PI, TAU};
use snowgrain_geometry::Grain;
use snowgrain_math::sampler::{PathKey, numbers};
use snowgrain_math::{DVec3, trig};

/// Points on the surface of each grain at which it is seen whether it is bare.
const POINTS_A_GRAIN: u32 = 16;
/// Grains at whose surfaces is looked.
const MOST_LOOKED_AT: f64 = 200_000.0;
/// Farthest distance of the two-point correlation, in mean radii, and its steps.
const CORRELATION_RADII: f64 = 8.0;
const CORRELATION_STEPS: usize = 32;
/// Classes of chords, sizes and depths.
const CHORD_CLASSES: usize = 30;
const SIZE_CLASSES: usize = 20;
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

/// Radii of the grains of a pack, metres.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sizes {
    /// By number.
    pub mean: f64,
    /// Standard deviation, by number.
    pub deviation: f64,
    /// Radius of equal grains of the same volume and surface, overlaps left aside.
    pub effective: f64,
    /// Least and greatest.
    pub range: [f64; 2],
    /// Radius (middle of a class), and part of all grains.
    pub classes: Vec<(f64, f64)>,
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
        let ice = united(chords);
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
fn united(chords: &[Chord]) -> Vec<[f64; 2]> {
    let mut ice: Vec<[f64; 2]> = Vec::with_capacity(chords.len());
    for chord in chords {
        match ice.last_mut() {
            Some(last) if chord.low <= last[1] => last[1] = last[1].max(chord.high),
            _ => ice.push([chord.low, chord.high]),
        }
    }
    ice
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

/// Surface of the union by volume of the region, 1/m.
fn surface_per_volume(field: &GrainField, period: Option<[f64; 2]>, region: &Region) -> f64 {
    let buckets = Buckets::new(field, period);
    let quantisation = field.quantisation;
    let every = (buckets.grains().len() as f64 / MOST_LOOKED_AT).ceil().max(1.0) as usize;
    let mut bare = 0.0;
    for (index, grain) in buckets.grains().iter().enumerate().step_by(every) {
        let [x, y, z] = grain.center.map(f64::from);
        let (center, radius) = (DVec3::new(x, y, z), f64::from(grain.radius));
        let directions: Vec<DVec3> =
            (0..POINTS_A_GRAIN).map(|point| direction(index as u64, point)).collect();
        let mut is_bare = [true; POINTS_A_GRAIN as usize];
        buckets.around(center, |other, at, reach| {
            if other == index && at == center {
                return;
            }
            for (direction, bare) in directions.iter().zip(&mut is_bare) {
                *bare &= (center + *direction * radius - at).length_squared() >= reach * reach;
            }
        });
        let metres = quantisation.grain(*grain);
        let holds = |direction: &DVec3| region.holds(metres.center + *direction * metres.radius);
        let points = directions.iter().zip(is_bare).filter(|(d, bare)| *bare && holds(d)).count();
        bare += points as f64 * metres.radius * metres.radius;
    }
    ratio(4.0 * PI * bare * every as f64 / f64::from(POINTS_A_GRAIN), region.volume())
}

/// One of the directions in which is looked, each in a part of the sphere of its own.
fn direction(grain: u64, point: u32) -> DVec3 {
    let [u, v, _] = numbers(PathKey::new(0, grain, 1), point).map(f64::from);
    let y = 1.0 - 2.0 * (f64::from(point) + u) / f64::from(POINTS_A_GRAIN);
    let across = (1.0 - y * y).max(0.0).sqrt();
    let (sin, cos) = trig::sin_cos(TAU * v);
    DVec3::new(across * cos, y, across * sin)
}

/// Solid fraction in equal parts of the depth, from the surface down, along vertical lines.
fn profile(vertical: &Lines, region: &Region) -> Vec<f64> {
    const STEPS: usize = 8;
    let mut sums = [[0.0f64; 2]; DEPTH_CLASSES];
    for (line, chords) in vertical.each() {
        let (place, ice) = (vertical.place(line), united(chords));
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

impl Sizes {
    fn of(field: &GrainField) -> Self {
        let radii: Vec<f64> = field.iter().map(|grain| grain.radius).collect();
        let count = radii.len() as f64;
        if radii.is_empty() {
            return Self::default();
        }
        let sum = |of: fn(f64) -> f64| radii.iter().map(|&radius| of(radius)).sum::<f64>();
        let mean = sum(|r| r) / count;
        let squares = sum(|r| r * r);
        let low = radii.iter().copied().fold(f64::INFINITY, f64::min);
        let high = radii.iter().copied().fold(0.0, f64::max);
        let width = (high - low) / SIZE_CLASSES as f64;
        let mut counts = vec![0u64; if width > 0.0 { SIZE_CLASSES } else { 1 }];
        for radius in &radii {
            let class = if width > 0.0 { ((radius - low) / width) as usize } else { 0 };
            counts[class.min(SIZE_CLASSES - 1)] += 1;
        }
        let class = |(index, &count_in): (usize, &u64)| {
            (low + (index as f64 + 0.5) * width, count_in as f64 / count)
        };
        Self {
            mean,
            deviation: (squares / count - mean * mean).max(0.0).sqrt(),
            effective: sum(|r| r * r * r) / squares,
            range: [low, high],
            classes: counts.iter().enumerate().map(class).collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measures::{Slab, nominal_solid_fraction};
    use crate::{
        Amount, DepositSettings, LatticeKind, LatticeSettings, PackSettings, Radii, Snowfall,
        lattice_grains,
    };
    use snowgrain_geometry::Quantisation;

    const R: f64 = 0.5e-3;

    fn fallen(density: f64, width: f64) -> (GrainField, [f64; 2]) {
        let quantisation = Quantisation::for_grains(DVec3::ZERO, R);
        let mut snow = Snowfall::on_level_floor(quantisation, [width * R; 2]).unwrap();
        snow.deposit(&DepositSettings {
            amount: Amount::Depth(60.0 * R),
            radii: Radii::equal(R),
            density: Some(density),
            rule: None,
            max_slope_degrees: 90.0,
            direction: DepositSettings::DOWN,
            area: None,
            seed: 1,
        })
        .unwrap();
        let period = snow.period().unwrap();
        (snow.into_field(), period)
    }

    #[test]
    fn mean_chords_in_air_are_those_of_the_theorem() {
        for (density, width) in [(150.0, 160.0), (350.0, 120.0), (600.0, 90.0)] {
            let (field, period) = fallen(density, width);
            let found = Structure::of(&field, Extent::Periodic(period), &|_| false);
            assert!((found.density() / density - 1.0).abs() < 0.02, "{}", found.density());
            // 4 (1 - phi) / S_v (Underwood 1970), with the surface found by points on grains.
            let theorem = 4.0 * (1.0 - found.solid_fraction) / found.surface_per_volume;
            let off = found.mean_air_chord / theorem - 1.0;
            assert!(off.abs() < 0.01, "{density}: {off}");
            if density < 500.0 {
                // No overlaps: the surface is that of all grains.
                let slab = Slab::between_parts_of_depth(&field, Some(period), [0.2, 0.8]);
                let surface = 3.0 * nominal_solid_fraction(&field, &slab) / R;
                assert!((found.surface_per_volume / surface - 1.0).abs() < 0.01, "{density}");
                let specific = found.specific_surface() * ICE_DENSITY * R / 3.0;
                assert!((specific - 1.0).abs() < 0.015, "{specific}");
            }
        }
    }

    #[test]
    fn correlation_goes_from_the_solid_fraction_to_its_square_as_the_surface_says() {
        let (field, period) = fallen(350.0, 120.0);
        let found = Structure::of(&field, Extent::Periodic(period), &|_| false);
        let phi = found.solid_fraction;
        for directed in &found.along {
            let at = |index: usize| directed.correlation[index].1;
            assert!((at(0) / phi - 1.0).abs() < 0.02, "{}", at(0));
            // Debye, Anderson and Brumberger 1957: the slope at 0 is -S_v / 4.
            let step = directed.correlation[1].0;
            let expected = at(0) - step * found.surface_per_volume / 4.0;
            assert!((at(1) / expected - 1.0).abs() < 0.03, "{} {expected}", at(1));
            let far = directed.correlation.last().unwrap().1;
            assert!((far / (phi * phi) - 1.0).abs() < 0.06, "{far} {}", phi * phi);
        }
        assert!((0.9..1.15).contains(&found.anisotropy), "{}", found.anisotropy);
    }

    #[test]
    fn draped_and_periodic_measures_of_the_same_snow_agree() {
        for density in [100.0, 350.0] {
            let (field, period) = fallen(density, 160.0);
            let periodic = Structure::of(&field, Extent::Periodic(period), &|_| false);
            let draped = Structure::of(&field, Extent::Draped, &|_| false);
            let off = draped.density() / periodic.density() - 1.0;
            assert!(off.abs() < 0.03, "{density}: {off}");
            let off = draped.surface_per_volume / periodic.surface_per_volume - 1.0;
            assert!(off.abs() < 0.03, "{density}: {off}");
            let middle: f64 = draped.profile[2..8].iter().sum::<f64>() / 6.0;
            assert!((middle / draped.solid_fraction - 1.0).abs() < 0.05, "{:?}", draped.profile);
        }
    }

    #[test]
    fn a_crystal_has_its_surface_and_its_neighbours() {
        let quantisation = Quantisation::for_grains(DVec3::ZERO, R);
        let (kind, counts) = (LatticeKind::Sc, [40; 3]);
        let settings = LatticeSettings { kind, counts, radius: R, spacing: None, density: None };
        let field = lattice_grains(&settings, &quantisation).unwrap();
        let found = Structure::of(&field, Extent::Block, &|_| false);
        // A sphere in each cube of two radii.
        assert!((found.surface_per_volume * R / (PI / 2.0) - 1.0).abs() < 0.01);
        assert!((found.solid_fraction / (PI / 6.0) - 1.0).abs() < 0.03, "{}", found.solid_fraction);
        assert_eq!(found.connections.connected_fraction, 1.0);
    }

    #[test]
    fn sizes_are_those_that_were_asked_for() {
        let radii = Radii::log_normal(R, 1.2).unwrap();
        let quantum = Quantisation::for_grains(DVec3::ZERO, radii.largest()).quantum();
        let settings = PackSettings { radii: radii.clone(), density: 250.0, seed: 0 };
        let sizes = Sizes::of(&settings.make(quantum).unwrap().field);
        assert!((sizes.mean / radii.mean() - 1.0).abs() < 0.01);
        assert!((sizes.classes.iter().map(|class| class.1).sum::<f64>() - 1.0).abs() < 1e-9);
        assert!(sizes.range[0] < 0.7 * R && sizes.range[1] > 1.5 * R, "{:?}", sizes.range);
    }

    #[test]
    fn nothing_is_measured_of_no_grains() {
        let quantisation = Quantisation::for_grains(DVec3::ZERO, R);
        let none = GrainField::new(quantisation, Vec::new());
        for extent in [Extent::Block, Extent::Draped, Extent::Periodic([1.0; 2])] {
            let found = Structure::of(&none, extent, &|_| false);
            assert_eq!((found.grains, found.solid_fraction), (0, 0.0));
        }
    }
}
