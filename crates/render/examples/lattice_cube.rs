//! Mean radiance and rate of the simple cubic cube of a given edge: `lattice_cube EDGE SPP [LEVEL]`.
use snowgrain_accel::{GrainGrid, LatticeCell, SimdLevel, Surfaces};
use snowgrain_geometry::Quantisation;
use snowgrain_math::{
    Aabb, DVec3, Ray,
    sampler::{PathKey, numbers},
};
use snowgrain_render::{World, camera::Camera, description::*, transport::*};

struct Pixels<'a> {
    camera: &'a Camera,
    list: Vec<(u32, u32)>,
    spp: u64,
    next: u64,
    sum: f64,
    n: u64,
    visits: u64,
    events: u64,
    hits: u64,
    trapped: u64,
    ice: f64,
}
impl PathSource for Pixels<'_> {
    type Tag = ();
    fn next_path(&mut self) -> Option<NewPath<()>> {
        if self.next >= self.spp * self.list.len() as u64 {
            return None;
        }
        let (x, y) = self.list[(self.next / self.spp) as usize];
        let key = PathKey::new(0, u64::from(y) * 256 + u64::from(x), self.next % self.spp);
        self.next += 1;
        let [u, v, _] = numbers(key, 0);
        let ray: Ray = self.camera.ray(f64::from(x) + f64::from(u), f64::from(y) + f64::from(v));
        Some(NewPath { tag: (), ray, key, event: 1 })
    }
    fn finish(&mut self, (): (), r: &PathResult) {
        self.n += 1;
        self.visits += u64::from(r.grain_visits);
        self.events += u64::from(r.interface_events);
        self.hits += u64::from(r.grain_visits > 0);
        self.ice += r.ice_length;
        match r.end {
            PathEnd::Escaped(ray) if ray.direction.y > 0.0 => self.sum += 1.0,
            PathEnd::Trapped => self.trapped += 1,
            _ => {}
        }
    }
}
fn main() {
    let args: Vec<String> = std::env::args().collect();
    let n: u32 = args[1].parse().unwrap();
    let spp: u64 = args[2].parse().unwrap();
    let level = args.get(3).map_or(SimdLevel::detect(), |l| l.parse().unwrap());
    let q = Quantisation::for_grains(DVec3::ZERO, 0.5);
    let r = (0.5 / q.quantum()).round() as i32;
    let cell =
        LatticeCell { side_quanta: [2 * r; 3], basis: vec![[r; 3]], radius_quanta: r as u16 };
    let grid = GrainGrid::lattice(q, &cell, [n; 3], [0; 3], [false; 3]).unwrap();
    let world = World { grid, surfaces: Surfaces::default(), albedos: vec![], eta: 1.31 };
    let c = DVec3::splat(f64::from(n) / 2.0);
    let camera = Camera::new(
        &CameraDescription {
            from: c + DVec3::new(1.0, 0.9, 0.8).normalize() * (2.6 * f64::from(n)),
            at: c,
            up: DVec3::Y,
            vertical_fov_degrees: 40.0,
            backdrop: [0.0; 3],
        },
        &FilmDescription { width: 256, height: 256, samples_per_pixel: 1, seed: 0 },
    );
    let inner = Aabb::new(DVec3::ONE, DVec3::splat(f64::from(n) - 1.0));
    let hit = |x: u32, y: u32| inner.intersect(&camera.ray(f64::from(x), f64::from(y))).is_some();
    let list: Vec<_> = (0..256)
        .flat_map(|y| (0..256).map(move |x| (x, y)))
        .filter(|&(x, y)| hit(x, y) && hit(x + 1, y) && hit(x, y + 1) && hit(x + 1, y + 1))
        .collect();
    let mut source = Pixels {
        camera: &camera,
        list,
        spp,
        next: 0,
        sum: 0.0,
        n: 0,
        visits: 0,
        events: 0,
        hits: 0,
        trapped: 0,
        ice: 0.0,
    };
    let t = std::time::Instant::now();
    trace(&world, level, &mut source);
    let s = t.elapsed().as_secs_f64();
    let mean = source.sum / source.n as f64;
    println!(
        "{level}: mean {:.5} +- {:.5}  visits/path {:.3}  events/visit {:.4}  trapped {}  {:.2} M visits/s  {} samples {s:.2} s",
        mean,
        (mean * (1.0 - mean) / source.n as f64).sqrt(),
        source.visits as f64 / source.hits as f64,
        source.events as f64 / source.visits as f64,
        source.trapped,
        source.visits as f64 / s / 1e6,
        source.n
    );
}
