//! Grains whose arrangement is known.

use snowgrain_geometry::Grain;
use snowgrain_math::DVec3;
use snowgrain_math::sampler::{PathKey, numbers};

/// The simple cubic lattice of touching grains of radius `radius` that fills a box from the origin
/// with `counts` grains along x, y, z.
#[must_use]
pub fn simple_cubic(counts: [u32; 3], radius: f64) -> Vec<Grain> {
    let mut grains = Vec::new();
    for z in 0..counts[2] {
        for y in 0..counts[1] {
            for x in 0..counts[0] {
                let cell = DVec3::new(f64::from(x), f64::from(y), f64::from(z)) + 0.5;
                grains.push(Grain { center: cell * (2.0 * radius), radius });
            }
        }
    }
    grains
}

/// `layers` (001) layers of touching grains of the face-centred cubic lattice in one period: the
/// square of side 2 `radius`, every second layer shifted by half of it. The lowest touches y = 0.
#[must_use]
pub fn face_centred_cubic_layers(layers: u32, radius: f64) -> Vec<Grain> {
    (0..layers)
        .map(|layer| {
            let side = if layer % 2 == 0 { 0.5 } else { 1.0 } * 2.0 * radius;
            let height = radius + f64::from(layer) * core::f64::consts::SQRT_2 * radius;
            Grain { center: DVec3::new(side, height, side), radius }
        })
        .collect()
}

/// Grains strewn at random over the box from the origin to `size`, whether or not they overlap;
/// radii uniform between the two of `radii`.
#[must_use]
pub fn strewn(count: u64, size: DVec3, radii: [f64; 2], seed: u64) -> Vec<Grain> {
    (0..count)
        .map(|index| {
            let key = PathKey::new(seed, index, 0);
            let [x, y, z] = numbers(key, 0).map(f64::from);
            let radius = radii[0] + (radii[1] - radii[0]) * f64::from(numbers(key, 1)[0]);
            Grain { center: DVec3::new(x, y, z) * size, radius }
        })
        .collect()
}
