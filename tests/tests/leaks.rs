//! Light must not slip past surfaces where two structures meet: each test is named after a leak that
//! there once was.

use snowgrain_accel::{GrainGrid, Packing, SimdLevel, SurfaceShape, Surfaces};
use snowgrain_geometry::{Quantisation, QuantisedGrain};
use snowgrain_math::sampler::{PathKey, numbers};
use snowgrain_math::{DAffine3, DVec3, Ray, frame};
use snowgrain_render::transport::{NewPath, PathEnd, PathResult, PathSource, trace};
use snowgrain_render::{Material, World};
use snowgrain_tests::packs;

/// Rays from one point into the half-space of `toward`.
struct Fan {
    origin: DVec3,
    toward: DVec3,
    next: u64,
    paths: u64,
    escaped: u64,
    grain_visits: u64,
}

impl PathSource for Fan {
    type Tag = ();

    fn next_path(&mut self) -> Option<NewPath<()>> {
        if self.next == self.paths {
            return None;
        }
        let key = PathKey::new(4, self.next, 0);
        self.next += 1;
        let [u, v, _] = numbers(key, 0).map(f64::from);
        let direction = frame::cosine_hemisphere(self.toward, [u, v]);
        Some(NewPath { tag: (), ray: Ray::new(self.origin, direction), key, event: 1 })
    }

    fn finish(&mut self, (): (), result: &PathResult) {
        self.escaped += u64::from(matches!(result.end, PathEnd::Escaped(_)));
        self.grain_visits += u64::from(result.grain_visits);
    }
}

fn quantised(centers: &[DVec3], radius: f64) -> (Quantisation, Vec<QuantisedGrain>) {
    let quantisation = Quantisation::for_grains(DVec3::ZERO, radius);
    let round = |&center| quantisation.round(center, radius).expect("the grain is small");
    (quantisation, centers.iter().map(round).collect())
}

fn world(
    (quantisation, grains): &(Quantisation, Vec<QuantisedGrain>),
    shape: SurfaceShape,
    transform: DAffine3,
    albedo: f32,
) -> World {
    let surfaces = Surfaces::new(&[(shape, transform)]);
    let grid =
        GrainGrid::build(*quantisation, grains, &surfaces, Packing::Fast).expect("few grains");
    World {
        grid,
        surfaces,
        materials: vec![Material::diffuse([albedo; 3])],
        emitters: Vec::new(),
        eta: 1.31,
    }
}

fn fan(world: &World, origin: DVec3, toward: DVec3, paths: u64) -> Fan {
    let mut fan = Fan { origin, toward, next: 0, paths, escaped: 0, grain_visits: 0 };
    trace(world, SimdLevel::detect(), &mut fan);
    fan
}

#[test]
fn a_wall_just_outside_the_grid_is_met_behind_empty_bricks() {
    let grains = quantised(&[DVec3::ZERO, DVec3::new(100.0, 100.0, 0.0), DVec3::X * 50.0], 0.5);
    for gap in 1..30 {
        let x = 100.5 + 0.25 * f64::from(gap);
        let wall = DAffine3::from_translation(DVec3::X * x)
            * DAffine3::from_rotation_z(-std::f64::consts::FRAC_PI_2);
        let world = world(&grains, SurfaceShape::Plane, wall, 0.0);
        let fan = fan(&world, DVec3::new(60.3, 50.0, 0.2), DVec3::X, 2000);
        // Only what grains turned back can get past an infinite wall.
        assert!(fan.escaped <= fan.grain_visits, "wall at {x}: {} escape", fan.escaped);
    }
}

#[test]
fn a_floor_at_the_faces_of_cells_is_met() {
    let centers = [DVec3::ZERO, DVec3::new(20.0, 12.0, 20.0), DVec3::new(-20.0, 0.0, -20.0)];
    let grains = quantised(&centers, 0.5);
    let empty = GrainGrid::build(grains.0, &grains.1, &Surfaces::default(), Packing::Fast).unwrap();
    for cells in 1..5 {
        let y = empty.bounds().min.y + f64::from(cells) * empty.cell_edges().y;
        let floor = DAffine3::from_translation(DVec3::Y * y);
        let world = world(&grains, SurfaceShape::Plane, floor, 0.0);
        let fan = fan(&world, DVec3::new(3.0, y + 3.0, 4.0), -DVec3::Y, 20_000);
        assert!(fan.escaped <= fan.grain_visits, "floor at {y}: {} escape", fan.escaped);
    }
}

#[test]
fn a_floor_at_the_face_of_the_grid_sends_light_back_into_the_snow() {
    let centers: Vec<_> =
        packs::simple_cubic([20, 1, 20], 0.5).iter().map(|grain| grain.center).collect();
    let grains = quantised(&centers, 0.5);
    let face = GrainGrid::build(grains.0, &grains.1, &Surfaces::default(), Packing::Fast)
        .unwrap()
        .bounds()
        .min
        .y;
    let visits = |y: f64| {
        let floor = DAffine3::from_translation(DVec3::Y * y);
        let world = world(&grains, SurfaceShape::Plane, floor, 0.9);
        let fan = fan(&world, DVec3::new(10.0, 3.0, 10.0), -DVec3::Y, 20_000);
        fan.grain_visits as f64 / fan.paths as f64
    };
    let (at, below) = (visits(face), visits(face - 1e-3));
    assert!((at / below - 1.0).abs() < 0.03, "{at} against {below} visits a path");
}

#[test]
fn light_stays_in_a_sphere_with_snow_in_it() {
    let grains = packs::simple_cubic([6, 6, 6], 0.05);
    let centers: Vec<_> = grains.iter().map(|grain| grain.center).collect();
    let world = world(&quantised(&centers, 0.05), SurfaceShape::Sphere, DAffine3::IDENTITY, 0.7);
    let fan = fan(&world, DVec3::new(-0.3, 0.2, 0.1), DVec3::Y, 20_000);
    assert!(fan.grain_visits > 0);
    assert_eq!(fan.escaped, 0);
}
