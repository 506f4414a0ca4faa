//! What the paper says of its pictures, in numbers.

use crate::cubes::{BENCHMARK_VIEW, cube, picture};
use crate::samples;
use rayon::prelude::*;
use snowgrain_accel::SimdLevel;
use snowgrain_film::{Layer, Picture, PixelRect};
use snowgrain_math::sampler::{PathKey, numbers};
use snowgrain_math::{DVec3, Ray, trig};
use snowgrain_render::Scene;
use snowgrain_render::measure::Estimate;
use snowgrain_render::transport::{NewPath, PathEnd, PathResult, PathSource, trace};

const SIDE: f64 = 120.0;

/// Camera rays to points uniform over a rectangle, by its corner and edges.
struct Look {
    from: DVec3,
    rectangle: [DVec3; 3],
    next: u64,
    end: u64,
    lit: u64,
}

impl PathSource for Look {
    type Tag = ();

    fn next_path(&mut self) -> Option<NewPath<()>> {
        if self.next == self.end {
            return None;
        }
        let key = PathKey::new(12, self.next, 0);
        self.next += 1;
        let [u, v, _] = numbers(key, 0).map(f64::from);
        let [corner, along, across] = self.rectangle;
        let point = corner + along * u + across * v;
        let ray = Ray::new(self.from, (point - self.from).normalize());
        Some(NewPath { tag: (), ray, key, event: 1 })
    }

    fn finish(&mut self, (): (), path: &PathResult) {
        let up = matches!(path.end, PathEnd::Escaped(ray) if ray.direction.y > 0.0);
        self.lit += u64::from(up);
    }
}

/// Mean radiances, under a sky of radiance 1, of parts of the cube: on the top face the 3 % bands
/// along the middle eight tenths of the edges that face the camera, and the middle hundredth; the
/// middles of the side faces.
struct Regions {
    bands: [Estimate; 2],
    top: Estimate,
    sides: [Estimate; 2],
}

fn look(direction: DVec3) -> Regions {
    let scene = Scene::build(&cube(SIDE as u32, direction, 2.6, 256), &mut |_| ()).unwrap();
    let from = DVec3::splat(0.5 * SIDE) + direction.normalize() * (2.6 * SIDE);
    let (x, y, z) = (DVec3::X * SIDE, DVec3::Y * SIDE, DVec3::Z * SIDE);
    let rectangles = [
        [x * 0.97 + y + z * 0.1, x * 0.03, z * 0.8],
        [z * 0.97 + y + x * 0.1, z * 0.03, x * 0.8],
        [x * 0.45 + y + z * 0.45, x * 0.1, z * 0.1],
        [x + y * 0.45 + z * 0.45, y * 0.1, z * 0.1],
        [x * 0.45 + y * 0.45 + z, x * 0.1, y * 0.1],
    ];
    let estimates: Vec<Estimate> = rectangles
        .into_par_iter()
        .map(|rectangle| {
            let paths = samples(20_000, 500_000);
            let mut look = Look { from, rectangle, next: 0, end: paths, lit: 0 };
            trace(&scene.world, SimdLevel::detect(), &mut look);
            let mean = look.lit as f64 / paths as f64;
            Estimate { mean, standard_error: (mean * (1.0 - mean) / paths as f64).sqrt() }
        })
        .collect();
    let &[nearest_x, nearest_z, top, side_x, side_z] = estimates.as_slice() else {
        unreachable!("one estimate a rectangle")
    };
    Regions { bands: [nearest_x, nearest_z], top, sides: [side_x, side_z] }
}

/// Asserts that one part is brighter than another by more than three standard errors.
fn assert_brighter(what: &str, bright: Estimate, dark: Estimate) {
    let sigma = bright.standard_error.max(dark.standard_error) * 2f64.sqrt();
    let by = bright.mean - dark.mean;
    println!("{what}: {:.4} against {:.4}, {:.1} sigma", bright.mean, dark.mean, by / sigma);
    assert!(by > 3.0 * sigma, "{what}: {bright:?} is not brighter than {dark:?}");
}

/// The paper's Figure 3: edges glow where the view grazes the face, nine degrees above the horizon.
#[test]
fn edges_are_brighter_than_the_middle_of_the_top_in_a_grazing_view() {
    let view = look(DVec3::new(1.0, 0.2, 0.8));
    for band in view.bands {
        assert_brighter("grazing, band over middle of the top", band, view.top);
    }
}

/// From 35 degrees the order is the other way round.
#[test]
fn the_middle_of_the_top_is_brightest_seen_from_higher_up() {
    let view = look(BENCHMARK_VIEW);
    for (band, expected) in view.bands.into_iter().zip([0.67, 0.65]) {
        assert_brighter("35 degrees, middle of the top over band", view.top, band);
        for side in view.sides {
            assert_brighter("35 degrees, band over side", band, side);
        }
        assert!((band.mean - expected).abs() < 0.02, "{band:?}");
    }
    assert!((view.top.mean - 0.83).abs() < 0.02, "{:?}", view.top);
    for side in view.sides {
        assert!((side.mean - 0.47).abs() < 0.02, "{side:?}");
    }
}

/// Errors fall as the square root of the samples, fireflies and all.
#[test]
fn the_error_against_a_long_render_falls_as_the_square_root_of_the_samples() {
    let scene = Scene::build(&cube(32, BENCHMARK_VIEW, 2.6, 48), &mut |_| ()).unwrap();
    let whole = PixelRect::new(0, 0, 48, 48);
    let render = |range| {
        let film = picture(&scene, range, whole).film;
        Picture::from_film(&film).unwrap().layer(Layer::R).unwrap().to_vec()
    };
    let most = samples(100, 1000);
    let reference = render(10_000..10_000 + 20 * most);
    let mut points = Vec::new();
    let mut spp = 1;
    while spp <= most {
        let squares: f64 = render(0..spp)
            .iter()
            .zip(&reference)
            .map(|(&a, &b)| (f64::from(a) - f64::from(b)) * (f64::from(a) - f64::from(b)))
            .sum();
        let rmse = (squares / reference.len() as f64).sqrt();
        println!("{spp} samples: RMSE {rmse:.5}");
        points.push((trig::ln(spp as f64), trig::ln(rmse)));
        spp *= 10;
    }
    let n = points.len() as f64;
    let (x, y) = points.iter().fold((0.0, 0.0), |(x, y), p| (x + p.0 / n, y + p.1 / n));
    let slope = points.iter().map(|p| (p.0 - x) * (p.1 - y)).sum::<f64>()
        / points.iter().map(|p| (p.0 - x) * (p.0 - x)).sum::<f64>();
    println!("slope {slope:.3}");
    assert!((slope + 0.5).abs() < 0.05, "{slope}");
}
