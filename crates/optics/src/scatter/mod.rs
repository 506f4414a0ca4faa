//! Ways of light through a sphere from one given direction into another.
//!
//! [`ScatterTable`] knows them for light whose place on the disc of the sphere is not known (a path
//! among grains, after the first few); [`Connector`] for light from one given point or direction, and
//! [`SpherePair`] where it goes through another sphere, too.

mod connect;
mod dual;
mod pair;
mod passages;
mod samples;

pub use connect::{Connection, Connector};
pub use pair::{Between, PairPath, Passed, Pencil, SpherePair, SphereVisit};
pub use passages::{PassageTable, SpherePassage};
pub use samples::Scattered;

use crate::sphere::Impact;
use crate::{Dielectric, fresnel};
use core::f64::consts::{PI, TAU};
use snowgrain_math::trig;

/// Parts of the disc over which a table is summed: rings of equal area.
const PARTS: u32 = 1 << 13;
/// Bins of a table, equal in the sine of half the scattering angle: they are narrow where light is
/// scattered forward, and finding one takes a square root.
const BINS: usize = 2048;
/// Orders end where less of a ray is left.
const LEAST_LIGHT: f64 = 1e-6;

/// How a sphere scatters a beam that falls evenly on its disc, and by which ways.
///
/// Angles are told in the plane of the direction of arrival and the wanted direction, from the former
/// towards the latter; lengths in radii.
#[derive(Clone, Debug, Default)]
pub struct ScatterTable {
    /// Of each bin, energy by solid angle, 1/sr; its integral over all directions is what leaves.
    densities: Vec<f32>,
    /// Of each bin, the energy of it and of all before.
    cumulative: Vec<f64>,
    /// Index of the first way of each bin, and one past the last.
    first: Vec<u32>,
    ways: Vec<Ways>,
}

/// Neighbouring ways of one order into one bin: from one end to the other.
#[derive(Clone, Copy, Debug)]
struct Ways {
    /// Part of the energy of the bin, with that of the ways before.
    cumulative: f32,
    /// Angles of the outward normal at the entry and at the exit.
    entry: [f32; 2],
    exit: [f32; 2],
    /// Length in the sphere from the plane through its centre across the direction of arrival (where
    /// light comes from ice), or from the entry, to the exit.
    length: [f32; 2],
}

/// One way through a sphere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Way {
    /// Angle of the outward normal at the entry, radians.
    pub entry: f64,
    /// Angle of the outward normal at the exit, radians.
    pub exit: f64,
    /// Length in the sphere, radii: from the entry where light arrives from air, else from the plane
    /// through the centre across the direction of arrival.
    pub length: f64,
}

/// One order of a ray at one place of the disc.
#[derive(Clone, Copy)]
struct Turn {
    /// Angle by which it is turned in all, away from the side of the disc on which it arrived.
    deflection: f64,
    /// Angles of the outward normal at the entry and at the exit from the direction of arrival, towards
    /// the side on which it arrived.
    entry: f64,
    exit: f64,
    length: f64,
}

impl ScatterTable {
    /// Light that arrives from air (or what surrounds the sphere): its mean over all directions,
    /// times 4 pi, is 1.
    #[must_use]
    pub fn for_air(medium: Dielectric) -> Self {
        let mut ways = Collected::default();
        let impact = |part: u32| {
            Impact::at_disc_fraction(medium, f64::from(part) / (2.0 * f64::from(PARTS)))
        };
        for part in 0..PARTS {
            let [from, middle, to] = [2 * part, 2 * part + 1, 2 * part + 2].map(impact);
            let mut left = 1.0;
            for order in 0.. {
                let energy = middle.energy(order);
                let [from, to] = [from, to].map(|impact| turn_from_air(&impact, order));
                ways.add(order, [from, to], energy / f64::from(PARTS));
                left -= energy;
                if left < LEAST_LIGHT {
                    break;
                }
            }
        }
        ways.into_table()
    }

    /// Light that is already in the ice: what is not reflected for ever.
    #[must_use]
    pub fn for_ice(medium: Dielectric) -> Self {
        let mut ways = Collected::default();
        // Rings of the disc beyond the critical angle let nothing out (none where the medium is the
        // denser surroundings').
        let within = (1.0 / (medium.eta * medium.eta)).min(1.0);
        let sine = |part: u32| (within * f64::from(part) / (2.0 * f64::from(PARTS))).sqrt();
        for part in 0..PARTS {
            let [from, middle, to] = [2 * part, 2 * part + 1, 2 * part + 2].map(sine);
            let cosine = (1.0 - middle * middle).max(0.0).sqrt();
            let reflectance = fresnel::reflectance(cosine, 1.0 / medium.eta);
            let mut left = within;
            for order in 1.. {
                let energy = left * (1.0 - reflectance);
                let [from, to] = [from, to].map(|sine| turn_from_ice(medium, sine, order));
                ways.add(order, [from, to], energy / f64::from(PARTS));
                left -= energy;
                if left < LEAST_LIGHT || reflectance == 1.0 {
                    break;
                }
            }
        }
        ways.into_table()
    }

    /// Energy scattered into a unit of solid angle, 1/sr, at a cosine of the scattering angle.
    #[inline]
    #[must_use]
    pub fn density(&self, cosine: f64) -> f64 {
        f64::from(self.densities[bin_of(cosine)])
    }

    /// Sums up the energies of the bins.
    fn accumulate(&mut self) {
        let energy = |(bin, &density): (usize, &f32)| f64::from(density) * solid_angle_of_bin(bin);
        let sums = self.densities.iter().enumerate().map(energy).scan(0.0, |sum, energy| {
            *sum += energy;
            Some(*sum)
        });
        self.cumulative = sums.collect();
    }

    /// A cosine of the scattering angle, as likely as its part of the light, and one of the ways to it; three
    /// uniform numbers. `None` for light that does not leave, or goes straight on.
    #[must_use]
    pub fn sample(&self, random: [f64; 3]) -> Option<(f64, Way)> {
        let bin = self.cumulative.partition_point(|&sum| sum <= random[0]);
        let first = bin.checked_sub(1).map_or(0.0, |before| self.cumulative[before]);
        let part = (random[0] - first) / (self.cumulative.get(bin)? - first);
        // Evenly over the solid angle of the bin.
        let [low, high] = [bin, bin + 1].map(|edge| edge as f64 / BINS as f64);
        let half_sine2 = low * low + part * (high * high - low * low);
        let cosine = 1.0 - 2.0 * half_sine2;
        let way = self.way(
            1.0 - 2.0 * (bin as f64 + 0.5) * (bin as f64 + 0.5) / (BINS * BINS) as f64,
            [random[1], random[2]],
        )?;
        Some((cosine, way))
    }

    /// One of the ways that make up the density at a cosine of the scattering angle, as likely as its
    /// part of it; two uniform numbers. `None` where there is none.
    #[must_use]
    pub fn way(&self, cosine: f64, random: [f64; 2]) -> Option<Way> {
        let bin = bin_of(cosine);
        let ways = &self.ways[self.first[bin] as usize..self.first[bin + 1] as usize];
        let ways = ways.iter().find(|ways| random[0] < f64::from(ways.cumulative));
        let at = |[from, to]: [f32; 2]| f64::from(from) + random[1] * f64::from(to - from);
        ways.map(|ways| Way { entry: at(ways.entry), exit: at(ways.exit), length: at(ways.length) })
    }
}

/// Solid angle of a bin, sr.
fn solid_angle_of_bin(bin: usize) -> f64 {
    let edge = |bin: usize| bin as f64 / BINS as f64;
    4.0 * PI * (edge(bin + 1) * edge(bin + 1) - edge(bin) * edge(bin))
}

/// The bin of a cosine of the scattering angle.
#[inline]
fn bin_of(cosine: f64) -> usize {
    let half_sine = (0.5 - 0.5 * cosine).max(0.0).sqrt();
    ((half_sine * BINS as f64) as usize).min(BINS - 1)
}

fn turn_from_air(impact: &Impact, order: u32) -> Turn {
    Turn {
        deflection: match order {
            // Light that is reflected is turned towards the side on which it arrived.
            0 => -impact.deflection(0),
            _ => impact.deflection(order),
        },
        entry: PI - impact.theta_i,
        exit: PI - impact.theta_i - f64::from(order) * (PI - 2.0 * impact.theta_t),
        length: f64::from(order) * impact.chord(),
    }
}

/// At a place of the disc told by the sine of the angle inside.
fn turn_from_ice(medium: Dielectric, sine: f64, order: u32) -> Turn {
    let inside = trig::asin(sine.min(1.0));
    let outside = trig::asin((medium.eta * sine).min(1.0));
    let cosine = (1.0 - sine * sine).max(0.0).sqrt();
    let turns = f64::from(order - 1);
    Turn {
        deflection: outside - inside + turns * (PI - 2.0 * inside),
        entry: PI - inside,
        exit: inside - turns * (PI - 2.0 * inside),
        length: cosine * (1.0 + 2.0 * turns),
    }
}

/// An angle between -pi and pi.
fn wrapped(angle: f64) -> f64 {
    angle - TAU * ((angle + PI) / TAU).floor()
}

/// Ways as they are found: of each bin.
struct Collected {
    bins: Vec<Vec<Found>>,
}

#[derive(Clone, Copy)]
struct Found {
    order: u32,
    energy: f64,
    entry: [f64; 2],
    exit: [f64; 2],
    length: [f64; 2],
}

impl Default for Collected {
    fn default() -> Self {
        Self { bins: vec![Vec::new(); BINS] }
    }
}

impl Collected {
    /// Adds what a ring of the disc sends out by one order: spread evenly from one end to the other.
    fn add(&mut self, order: u32, [from, to]: [Turn; 2], energy: f64) {
        let middle = wrapped(0.5 * (from.deflection + to.deflection));
        // The wanted direction lies on the side to which light is turned.
        let side = if middle > 0.0 { -1.0 } else { 1.0 };
        let place =
            |turn: Turn| BINS as f64 * trig::sin_cos(0.5 * wrapped(turn.deflection)).0.abs();
        let [a, b] = [place(from), place(to)];
        let [low, high] = [a.min(b), a.max(b)];
        let (first, last) = ((low as usize).min(BINS - 1), (high as usize).min(BINS - 1));
        for bin in first..=last {
            let ends = [low.max(bin as f64), high.min((bin + 1) as f64)];
            let part = if high > low { (ends[1] - ends[0]) / (high - low) } else { 1.0 };
            let along = |end: f64| if b == a { 0.0 } else { (end - a) / (b - a) };
            let at = |[x, y]: [f64; 2]| ends.map(|end| x + along(end) * (y - x));
            let entry = at([side * from.entry, side * to.entry]);
            let exit = at([side * from.exit, side * to.exit]);
            let length = at([from.length, to.length]);
            self.join(bin, Found { order, energy: energy * part, entry, exit, length });
        }
    }

    /// Adds ways to a bin, to those of the same order beside them where there are any.
    fn join(&mut self, bin: usize, found: Found) {
        let near = |a: f64, b: f64| (a - b).abs() < 1e-9;
        let beside = self.bins[bin].iter_mut().find_map(|known| {
            if known.order != found.order {
                return None;
            }
            let ends = [(0, 1), (1, 0), (0, 0), (1, 1)];
            let met = ends.into_iter().find(|&(i, j)| {
                near(known.exit[i], found.exit[j]) && near(known.length[i], found.length[j])
            });
            met.map(|met| (known, met))
        });
        match beside {
            Some((known, (i, j))) => {
                known.entry[i] = found.entry[1 - j];
                known.exit[i] = found.exit[1 - j];
                known.length[i] = found.length[1 - j];
                known.energy += found.energy;
            }
            None => self.bins[bin].push(found),
        }
    }

    fn into_table(self) -> ScatterTable {
        let mut table = ScatterTable::default();
        table.first.push(0);
        for (bin, found) in self.bins.iter().enumerate() {
            let total: f64 = found.iter().map(|ways| ways.energy).sum();
            let mut sum = 0.0;
            for ways in found {
                sum += ways.energy;
                table.ways.push(Ways {
                    cumulative: (sum / total) as f32,
                    entry: ways.entry.map(|angle| angle as f32),
                    exit: ways.exit.map(|angle| angle as f32),
                    length: ways.length.map(|length| length as f32),
                });
            }
            // Uniform numbers reach up to just below 1.
            if let Some(last) = table.ways[table.first[bin] as usize..].last_mut() {
                last.cumulative = 1.0;
            }
            table.first.push(table.ways.len() as u32);
            table.densities.push((total / solid_angle_of_bin(bin)) as f32);
        }
        table.accumulate();
        table
    }
}

#[cfg(test)]
mod tests;
