//! Equal grains at random places, none touching another: random sequential addition (Widom 1966,
//! "Random sequential addition of hard spheres to a volume", J. Chem. Phys. 44, 3888).
//!
//! The box repeats along x and z. Grains are put one after another at uniformly random places; one
//! that would overlap an earlier grain is drawn again. In three dimensions this jams at a solid
//! fraction of about .384.

use crate::{GrainField, GrainsError, ICE_DENSITY};
use snowgrain_geometry::{Quantisation, QuantisedGrain};
use snowgrain_math::DVec3;
use snowgrain_math::sampler::pcg3d;

/// Highest solid fraction that is reached in reasonable time.
const MOST_FILLED: f64 = 0.35;
/// Draws for one grain after which the pack counts as jammed.
const MOST_DRAWS: u64 = 50_000_000;
/// Most cells of two radii: a gigabyte of them.
const MOST_CELLS: f64 = 5e7;
/// Grains that a cell can hold at most: with edges below two diameters no more of that distance fit into
/// it.
const GRAINS_PER_CELL: usize = 27;
/// Least radius of grains beside larger ones, in quanta.
const LEAST_RADIUS_QUANTA: f64 = 32.0;

/// A pack to make.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RandomSettings {
    /// Radius of the grains, metres.
    pub radius: f64,
    /// Density, kg/m^3: that of the grains between the planes y = 0 and y = depth.
    pub density: f64,
    /// Depth, metres; grains lie wholly within it.
    pub depth: f64,
    /// Period along x and z, metres; rounded up to whole grains.
    pub width: f64,
    /// Seed.
    pub seed: u64,
}

/// A layer of a pack.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RandomLayer {
    /// Radius of its grains, metres.
    pub radius: f64,
    /// Density, kg/m^3: that of the grains between its faces.
    pub density: f64,
    /// Depth, metres; grains lie wholly within it.
    pub depth: f64,
}

/// The pack, and its periods along x and z in quanta.
///
/// # Errors
/// A density that is not reached so (with the highest that is), or a depth or width that holds no
/// grain.
pub fn random_pack(settings: &RandomSettings) -> Result<(GrainField, [i64; 2]), GrainsError> {
    let RandomSettings { radius, density, depth, width, seed } = *settings;
    let layer = RandomLayer { radius, density, depth };
    random_layers(&[layer], width, seed).map(|(field, period, _)| (field, period))
}

/// Layers from the top down, the last on y = 0, in a period of at least `width` metres along x and z: the
/// grains, the periods in quanta, and of each grain the number of its layer from the top, from 0.
///
/// # Errors
/// As [`random_pack`]; no layers; grains so much smaller than others that rounding would change them.
pub fn random_layers(
    layers: &[RandomLayer],
    width: f64,
    seed: u64,
) -> Result<(GrainField, [i64; 2], Vec<u8>), GrainsError> {
    let largest = layers.iter().map(|layer| layer.radius).fold(0.0, f64::max);
    if largest <= 0.0 {
        return Err(GrainsError::setting("radius", "there is no grain"));
    }
    let quantisation = Quantisation::for_grains(DVec3::ZERO, largest);
    let quantum = quantisation.quantum();
    let side = 2 * i64::from(Quantisation::MAX_RADIUS_QUANTA);
    let across = (width / quantum / side as f64).ceil().max(3.0);
    let width = (across * side as f64) as i64;
    let (mut grains, mut numbers) = (Vec::new(), Vec::new());
    let mut bottom = 0;
    for (number, layer) in layers.iter().enumerate().rev() {
        let radius = match quantisation.round(DVec3::ZERO, layer.radius) {
            Ok(grain) if f64::from(grain.radius) >= LEAST_RADIUS_QUANTA => grain.radius,
            _ => {
                let reason = format!("{} m is too small beside {largest} m", layer.radius);
                return Err(GrainsError::setting("radius", reason));
            }
        };
        let seed = seed as u32 ^ (number as u32).wrapping_mul(0x9E37_79B9);
        let centers = place(layer, (i64::from(radius), width, quantum), seed)?;
        numbers.resize(numbers.len() + centers.len(), number as u8);
        grains.extend(centers.into_iter().map(|[x, y, z]| QuantisedGrain {
            center: [x, y + bottom, z].map(|c| c as i32),
            radius,
        }));
        bottom += (layer.depth / quantum).round() as i64;
    }
    Ok((GrainField::new(quantisation, grains), [width; 2], numbers))
}

/// Centres of the grains of a layer on y = 0, in quanta.
fn place(
    layer: &RandomLayer,
    (radius, width, quantum): (i64, i64, f64),
    seed: u32,
) -> Result<Vec<[i64; 3]>, GrainsError> {
    let most = MOST_FILLED * ICE_DENSITY;
    if !(layer.density > 0.0 && layer.density <= most) {
        let reason = format!(
            "{} kg/m^3 is out of reach for grains at random places: ask for at most {most:.0}, or for \
             a lattice or a rule that packs more closely",
            layer.density
        );
        return Err(GrainsError::setting("density", reason));
    }
    let side = 2 * radius;
    let across = width / side;
    let up = (layer.depth / quantum / side as f64).ceil();
    let cells = across as f64 * across as f64 * up;
    if !(layer.depth / quantum >= side as f64 && cells < MOST_CELLS) {
        let reason = format!("{} m is less than a grain, or too much", layer.depth);
        return Err(GrainsError::setting("depth", reason));
    }
    let depth = (layer.depth / quantum).round() as i64;
    let volume = width as f64 * width as f64 * depth as f64;
    let ball =
        4.0 / 3.0 * core::f64::consts::PI * (radius as f64) * (radius as f64) * radius as f64;
    let count = (layer.density / ICE_DENSITY * volume / ball).round() as u64;
    let mut pack = Pack::new([across, up as i64], side, width);
    let mut draw = 0u64;
    for number in 0..count {
        let first = draw;
        loop {
            if draw - first > MOST_DRAWS {
                let reason =
                    format!("the pack jams after {number} of {count} grains; ask for less");
                return Err(GrainsError::setting("density", reason));
            }
            let [x, y, z] = pcg3d(draw as u32, (draw >> 32) as u32 ^ seed, 0x5EED);
            draw += 1;
            let below = |word: u32, range: i64| (i64::from(word) * range) >> 32;
            let center = [below(x, width), radius + below(y, depth - side + 1), below(z, width)];
            if pack.add(center) {
                break;
            }
        }
    }
    Ok(pack.cells.into_iter().flatten().collect())
}

/// Grains in cells whose edges are their diameter or, along x and z, a little more.
struct Pack {
    /// Cells along x and z, and along y.
    across: i64,
    up: i64,
    /// Diameter of the grains, and the period.
    side: i64,
    width: i64,
    cells: Vec<Vec<[i64; 3]>>,
}

impl Pack {
    fn new([across, up]: [i64; 2], side: i64, width: i64) -> Self {
        let cells = vec![Vec::new(); (across * across * up) as usize];
        Self { across, up, side, width, cells }
    }

    /// Adds a grain, unless it overlaps another.
    fn add(&mut self, center: [i64; 3]) -> bool {
        let width = self.width;
        let [x, z] = [center[0], center[2]].map(|c| c * self.across / width);
        let y = center[1] / self.side;
        for (dx, dy, dz) in NEIGHBOURS {
            let row = y + dy;
            if !(0..self.up).contains(&row) {
                continue;
            }
            let (column, slice) =
                ((x + dx).rem_euclid(self.across), (z + dz).rem_euclid(self.across));
            for other in &self.cells[self.index([column, row, slice])] {
                let apart = |axis: usize, period: Option<i64>| {
                    let d = (center[axis] - other[axis]).abs();
                    period.map_or(d, |period| d.min(period - d))
                };
                let (a, b, c) = (apart(0, Some(width)), apart(1, None), apart(2, Some(width)));
                if a * a + b * b + c * c < self.side * self.side {
                    return false;
                }
            }
        }
        let index = self.index([x, y, z]);
        debug_assert!(self.cells[index].len() < GRAINS_PER_CELL);
        self.cells[index].push(center);
        true
    }

    fn index(&self, [x, y, z]: [i64; 3]) -> usize {
        ((z * self.up + y) * self.across + x) as usize
    }
}

/// The cells around one, itself first: it is the most likely to hold a grain too near.
const NEIGHBOURS: [(i64, i64, i64); 27] = neighbours();

const fn neighbours() -> [(i64, i64, i64); 27] {
    let mut all = [(0, 0, 0); 27];
    let (mut next, mut index) = (1, 0);
    while index < 27 {
        let step = (index % 3 - 1, index / 3 % 3 - 1, index / 9 - 1);
        if !(step.0 == 0 && step.1 == 0 && step.2 == 0) {
            all[next] = step;
            next += 1;
        }
        index += 1;
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measures::connections;

    const R: f64 = 0.1e-3;

    fn settings(density: f64) -> RandomSettings {
        RandomSettings { radius: R, density, depth: 20.0 * R, width: 30.0 * R, seed: 3 }
    }

    #[test]
    fn packs_have_the_density_asked_for_and_no_overlap() {
        for density in [30.0, 150.0, 300.0] {
            let (field, [width, _]) = random_pack(&settings(density)).unwrap();
            let width = width as f64 * field.quantisation.quantum();
            assert!((width - 30.0 * R).abs() < 2.0 * R);
            let volume = width * width * 20.0 * R;
            let ball = 4.0 / 3.0 * core::f64::consts::PI * R * R * R;
            let reached = field.len() as f64 * ball * ICE_DENSITY / volume;
            assert!((reached / density - 1.0).abs() < 0.01, "{reached}");
            for grain in field.iter() {
                let within = R * (1.0 - 1e-3)..=R * 19.001;
                assert!(within.contains(&grain.center.y), "{grain:?}");
            }
            let found = connections(&field, Some([width; 2]), &|_| true);
            assert_eq!((found.overlaps_per_grain, found.greatest_overlap_depth), (0.0, 0.0));
        }
    }

    #[test]
    fn layers_lie_on_each_other_and_are_told_apart() {
        let layers = [
            RandomLayer { radius: 0.37 * R, density: 150.0, depth: 5.0 * R },
            RandomLayer { radius: R, density: 280.0, depth: 8.0 * R },
        ];
        let (field, [width, _], numbers) = random_layers(&layers, 30.0 * R, 3).unwrap();
        let width = width as f64 * field.quantisation.quantum();
        assert_eq!(field.len(), numbers.len());
        for (number, (layer, floor)) in layers.iter().zip([8.0 * R, 0.0]).enumerate() {
            let grains = field.iter().zip(&numbers).filter(|(_, n)| usize::from(**n) == number);
            let mut volume = 0.0;
            for (grain, _) in grains {
                let off = (grain.radius / layer.radius - 1.0).abs();
                let reach = layer.radius * (1.0 - 2e-3);
                assert!(off < 1e-3 && grain.center.y >= floor + reach, "{grain:?}");
                assert!(grain.center.y <= floor + layer.depth - reach, "{grain:?}");
                volume +=
                    4.0 / 3.0 * core::f64::consts::PI * grain.radius * grain.radius * grain.radius;
            }
            let reached = volume * ICE_DENSITY / (width * width * layer.depth);
            assert!((reached / layer.density - 1.0).abs() < 0.01, "{reached}");
        }
        let found = connections(&field, Some([width; 2]), &|_| true);
        assert_eq!(found.overlaps_per_grain, 0.0);
        assert!(random_layers(&[], 30.0 * R, 3).is_err());
        let dust = RandomLayer { radius: 1e-4 * R, ..layers[0] };
        assert!(random_layers(&[layers[1], dust], 30.0 * R, 3).is_err());
    }

    #[test]
    fn the_same_seed_gives_the_same_pack_and_what_jams_is_refused() {
        let pack = || random_pack(&settings(200.0)).unwrap().0;
        assert_eq!(pack(), pack());
        let other = random_pack(&RandomSettings { seed: 4, ..settings(200.0) }).unwrap().0;
        assert_ne!(other, pack());
        let error = random_pack(&settings(400.0)).unwrap_err().to_string();
        assert!(error.contains("at most 321"), "{error}");
        assert!(random_pack(&RandomSettings { depth: R, ..settings(100.0) }).is_err());
    }
}
