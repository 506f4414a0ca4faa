//! Prints mean radiance and rate of the benchmark: the simple cubic cube of `side`^3 grains.
//!
//! `cargo run --release -p snowgrain-render --example lattice_cube -- [side] [samples] [simd level]`
//! (interior pixels of 256 x 256, one thread; the means are .4063, .4947, .5571 at 32, 64, 120).

use snowgrain_accel::{GrainGrid, LatticeCell, SimdLevel, Surfaces};
use snowgrain_geometry::Quantisation;
use snowgrain_math::sampler::{PathKey, numbers};
use snowgrain_math::{Aabb, DVec3};
use snowgrain_render::camera::Camera;
use snowgrain_render::description::{CameraDescription, FilmDescription};
use snowgrain_render::transport::{NewPath, PathEnd, PathResult, PathSource, trace};
use snowgrain_render::{Statistics, World};
use std::time::Instant;

const PIXELS: u32 = 256;

/// The samples of some pixels, one after another.
struct Pixels {
    camera: Camera,
    pixels: Vec<(u32, u32)>,
    samples: u64,
    next: u64,
    lit: u64,
    statistics: Statistics,
}

impl PathSource for Pixels {
    type Tag = ();

    fn next_path(&mut self) -> Option<NewPath<()>> {
        let &(x, y) = self.pixels.get((self.next / self.samples) as usize)?;
        let stream = u64::from(y) * u64::from(PIXELS) + u64::from(x);
        let key = PathKey::new(0, stream, self.next % self.samples);
        self.next += 1;
        let [u, v, _] = numbers(key, 0).map(f64::from);
        let ray = self.camera.ray(f64::from(x) + u, f64::from(y) + v);
        Some(NewPath { tag: (), ray, key, event: 1 })
    }

    fn finish(&mut self, (): (), path: &PathResult) {
        self.statistics.count(path);
        let lit = matches!(path.end, PathEnd::Escaped(ray) if ray.direction.y > 0.0);
        self.lit += u64::from(lit);
    }
}

fn world(side: u32) -> Result<World, snowgrain_accel::GridError> {
    let quantisation = Quantisation::for_grains(DVec3::ZERO, 0.5);
    let radius = (0.5 / quantisation.quantum()).round() as i32;
    let cell = LatticeCell {
        side_quanta: [2 * radius; 3],
        basis: vec![[radius; 3]],
        radius_quanta: radius as u16,
    };
    let grid = GrainGrid::lattice(quantisation, &cell, [side; 3], [0; 3], [false; 3])?;
    Ok(World { grid, surfaces: Surfaces::default(), albedos: Vec::new(), eta: 1.31 })
}

fn camera(side: f64) -> Camera {
    let at = DVec3::splat(0.5 * side);
    Camera::new(
        &CameraDescription {
            from: at + DVec3::new(1.0, 0.9, 0.8).normalize() * (2.6 * side),
            at,
            up: DVec3::Y,
            vertical_fov_degrees: 40.0,
            backdrop: [0.0; 3],
        },
        &FilmDescription { width: PIXELS, height: PIXELS, samples_per_pixel: 1, seed: 0 },
    )
}

/// The pixels whose four corner rays all meet the cube less one grain on every side.
fn interior(camera: &Camera, side: f64) -> Vec<(u32, u32)> {
    let core = Aabb::new(DVec3::ONE, DVec3::splat(side - 1.0));
    let meets = |x: u32, y: u32| core.intersect(&camera.ray(f64::from(x), f64::from(y))).is_some();
    (0..PIXELS)
        .flat_map(|y| (0..PIXELS).map(move |x| (x, y)))
        .filter(|&(x, y)| meets(x, y) && meets(x + 1, y) && meets(x, y + 1) && meets(x + 1, y + 1))
        .collect()
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let number =
        |index: usize, default: u32| arguments.get(index).map_or(Ok(default), |text| text.parse());
    let (side, samples) = (number(0, 120)?, u64::from(number(1, 4)?.max(1)));
    let level = arguments.get(2).map_or(Ok(SimdLevel::detect()), |level| level.parse())?;

    let world = world(side)?;
    let camera = camera(f64::from(side));
    let pixels = interior(&camera, f64::from(side));
    let statistics = Statistics::default();
    let mut source = Pixels { camera, pixels, samples, next: 0, lit: 0, statistics };
    let start = Instant::now();
    trace(&world, level, &mut source);
    let seconds = start.elapsed().as_secs_f64();

    let counts = source.statistics;
    let mean = source.lit as f64 / counts.paths as f64;
    let error = (mean * (1.0 - mean) / counts.paths as f64).sqrt();
    println!(
        "{level}: mean {mean:.5} +- {error:.5}, {:.2} visits a path, {:.4} events a visit, {} trapped",
        counts.grain_visits as f64 / counts.paths_in_snow as f64,
        counts.interface_events as f64 / counts.grain_visits as f64,
        counts.trapped_paths,
    );
    println!(
        "{} paths in {seconds:.2} s: {:.2} M visits/s, {:.2} M events/s",
        counts.paths,
        counts.grain_visits as f64 / seconds / 1e6,
        counts.interface_events as f64 / seconds / 1e6,
    );
    Ok(())
}
