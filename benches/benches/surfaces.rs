//! `cargo bench -p snowgrain-benches --bench surfaces`: how fast surfaces are built and searched, per
//! CPU second of one core, and their memory: the teapot in several resolutions, and 10 000 of them.

use snowgrain_accel::{SurfaceShape, Surfaces};
use snowgrain_benches::{best_of, cpu_seconds};
use snowgrain_geometry::{TriangleMesh, teapot};
use snowgrain_math::sampler::{PathKey, numbers};
use snowgrain_math::{Aabb, DAffine3, DMat3, DVec3, Ray};
use std::sync::Arc;
use std::time::Instant;

const QUERIES: u64 = 500_000;

/// Reach of short rays, radius of falling spheres and half the edge of boxes.
const SMALL: f64 = 0.01;

fn main() {
    for divisions in [32, 128, 256] {
        let mut mesh = teapot(divisions);
        mesh.positions.shrink_to_fit();
        mesh.triangles.shrink_to_fit();
        let objects = [(SurfaceShape::Mesh(Arc::new(mesh)), DAffine3::IDENTITY)];
        measure(&objects);
    }
    measure(&forest(Arc::new(teapot(32))));
}

/// The mesh in 10 000 places, turned and stretched, on a square.
fn forest(mesh: Arc<TriangleMesh>) -> Vec<(SurfaceShape, DAffine3)> {
    let place = |i: u32| {
        let [x, y, z] = numbers(PathKey::new(1, u64::from(i), 0), 0).map(f64::from);
        let axis = DVec3::new(x - 0.5, y + 0.5, z - 0.5).normalize();
        let side = axis.cross(DVec3::X).normalize();
        let turn = DMat3::from_cols(side, axis, side.cross(axis));
        let translation = DVec3::new(f64::from(i % 100), 0.0, f64::from(i / 100)) * 4.0;
        DAffine3 {
            matrix3: turn * DMat3::from_diagonal(DVec3::new(1.0, 1.0 + y, 1.0)),
            translation,
        }
    };
    (0..10_000).map(|i| (SurfaceShape::Mesh(Arc::clone(&mesh)), place(i))).collect()
}

fn triangles(objects: &[(SurfaceShape, DAffine3)]) -> usize {
    let of = |shape: &SurfaceShape| match shape {
        SurfaceShape::Mesh(mesh) => mesh.triangles.len(),
        SurfaceShape::Sphere | SurfaceShape::Box | SurfaceShape::Plane => 0,
    };
    objects.iter().map(|(shape, _)| of(shape)).sum()
}

/// Wall and CPU seconds of a build on so many threads.
fn build(objects: &[(SurfaceShape, DAffine3)], threads: usize) -> (f64, f64, Surfaces) {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a small pool");
    let start = Instant::now();
    let (cpu, surfaces) = cpu_seconds(|| pool.install(|| Surfaces::new(objects)));
    (start.elapsed().as_secs_f64(), cpu, surfaces)
}

fn measure(objects: &[(SurfaceShape, DAffine3)]) {
    let (wall_two, cpu_two, _) = build(objects, 2);
    let (wall, cpu, surfaces) = build(objects, 1);
    let (count, bytes) = (triangles(objects), surfaces.memory_bytes());
    println!(
        "{} objects, {count} triangles, {bytes} bytes ({:.1} a triangle)\n  \
         built in {wall:.3} s ({cpu:.3} CPU-s), with two threads {wall_two:.3} s ({cpu_two:.3} CPU-s)",
        objects.len(),
        bytes as f64 / count as f64,
    );
    let bounds = surfaces.bounds();
    let point = |index: u64, event: u32| {
        let u = numbers(PathKey::new(0, index, 0), event).map(f64::from);
        bounds.min + DVec3::from_array(u) * bounds.size()
    };
    let rays: Vec<Ray> = (0..QUERIES)
        .map(|i| Ray::new(point(i, 0), (point(i, 1) - point(i, 0)).normalize()))
        .collect();
    let rate = |name: &str, query: &dyn Fn(&Ray) -> bool| {
        let (seconds, yes) = best_of(3, || rays.iter().filter(|ray| query(ray)).count());
        println!("  {:6.2} M {name}/s ({yes} of {QUERIES} yes)", QUERIES as f64 / seconds / 1e6);
    };
    rate("rays", &|ray| surfaces.intersect(ray, f64::INFINITY, None).is_some());
    // From where a ray meets a surface: what light does in the cells along surfaces.
    let starts: Vec<Ray> = rays
        .iter()
        .map(|ray| {
            let t = surfaces.intersect(ray, f64::INFINITY, None).map_or(0.0, |hit| hit.t);
            Ray::new(ray.at(t - SMALL * 0.5), ray.direction)
        })
        .collect();
    let (seconds, yes) = best_of(3, || {
        starts.iter().filter(|ray| surfaces.intersect(ray, SMALL, None).is_some()).count()
    });
    println!("  {:6.2} M short rays/s ({yes} yes)", QUERIES as f64 / seconds / 1e6);
    rate("boxes", &|ray| surfaces.may_cross(&Aabb::new(ray.origin - SMALL, ray.origin + SMALL)));
    let top = bounds.max.y + 1.0;
    rate("drops", &|ray| {
        surfaces.drop_sphere(ray.origin.x, ray.origin.z, SMALL, [top, f64::NEG_INFINITY]).is_some()
    });
}
