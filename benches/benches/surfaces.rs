//! `cargo bench -p snowgrain-benches --bench surfaces`: rays, boxes and falling spheres against the
//! teapot, per CPU second of one core.

use snowgrain_accel::{SurfaceShape, Surfaces};
use snowgrain_benches::cpu_seconds;
use snowgrain_geometry::teapot;
use snowgrain_math::sampler::{PathKey, numbers};
use snowgrain_math::{Aabb, DAffine3, DVec3, Ray};
use std::sync::Arc;

const QUERIES: u64 = 500_000;

fn main() {
    for divisions in [32, 128] {
        let mesh = Arc::new(teapot(divisions));
        let triangles = mesh.triangles.len();
        let (build, surfaces) =
            cpu_seconds(|| Surfaces::new(&[(SurfaceShape::Mesh(mesh), DAffine3::IDENTITY)]));
        let bounds = surfaces.bounds();
        let point = |index: u64, event: u32| {
            let u = numbers(PathKey::new(0, index, 0), event).map(f64::from);
            bounds.min + DVec3::from_array(u) * bounds.size()
        };
        let rays: Vec<Ray> = (0..QUERIES)
            .map(|i| Ray::new(point(i, 0), (point(i, 1) - point(i, 0)).normalize()))
            .collect();
        let rate = |query: &dyn Fn(&Ray) -> bool| {
            let (seconds, hits) = cpu_seconds(|| rays.iter().filter(|ray| query(ray)).count());
            (QUERIES as f64 / seconds / 1e6, hits)
        };
        let (hit_rate, hits) = rate(&|ray| surfaces.intersect(ray, f64::INFINITY, None).is_some());
        let (box_rate, crossed) =
            rate(&|ray| surfaces.may_cross(&Aabb::new(ray.origin - 0.01, ray.origin + 0.01)));
        let (drop_rate, landed) =
            rate(&|ray| surfaces.drop_sphere(ray.origin.x, ray.origin.z, 0.01, 4.0).is_some());
        println!(
            "{triangles} triangles, {} bytes, built in {build:.3} CPU-s: {hit_rate:.2} M rays/s \
             ({hits} hit), {box_rate:.2} M boxes/s ({crossed} crossed), {drop_rate:.2} M drops/s \
             ({landed} land)",
            surfaces.memory_bytes(),
        );
    }
}
