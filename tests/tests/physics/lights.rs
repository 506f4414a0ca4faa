//! Level ground under every light that paths meet, as closed forms say; lamps in snow.

use crate::assert_agrees;
use crate::cubes::picture;
use crate::deposits::{fall, pile};
use snowgrain_film::{Film, PixelRect};
use snowgrain_grains::DepositRule;
use snowgrain_math::{DAffine3, DVec3, trig};
use snowgrain_render::description::{
    CameraDescription, DirectView, FilmDescription, IceDescription, IntegratorKind,
    LightDescription, LightFinding, LightKind, ObjectDescription, ObjectShape, Projection,
    SceneDescription, SnowDescription, Surface,
};
use snowgrain_render::light::{EnvironmentMap, direction_of};
use snowgrain_render::measure::Estimate;
use snowgrain_render::{Scene, Strata};
use std::f64::consts::PI;
use std::sync::Arc;

/// Albedo of the ground.
const ALBEDO: f32 = 0.6;
const PIXELS: u32 = 16;

/// Grey ground, seen from straight above in a field of view of a tenth of a degree.
pub(crate) fn ground(lights: Vec<LightDescription>) -> SceneDescription {
    SceneDescription {
        film: FilmDescription::new(PIXELS, PIXELS, 1, 5),
        camera: CameraDescription {
            from: DVec3::Y * 0.3,
            at: DVec3::ZERO,
            up: DVec3::NEG_Z,
            projection: Projection::pinhole(0.1),
            backdrop: [0.0; 3],
        },
        ice: IceDescription::clear(1.31),
        lights,
        objects: vec![ObjectDescription {
            name: "ground".into(),
            shape: ObjectShape::Plane,
            surface: Surface::diffuse([ALBEDO; 3]),
            direct_view: DirectView::Seen,
            transform: DAffine3::IDENTITY,
        }],
        snow: Vec::new(),
        strata: Strata::default(),
        integrator: IntegratorKind::Grains,
        packing: None,
        tiled: None,
        shapes: Vec::new(),
        light_finding: LightFinding::Exact,
        deep: None,
    }
}

pub(crate) fn film(description: &SceneDescription, samples: u64) -> Film {
    let scene = Scene::build(description, &mut |_| ()).unwrap();
    let film = &description.film;
    picture(&scene, 0..samples, PixelRect::new(0, 0, film.width, film.height)).film
}

/// The mean of green over all pixels.
pub(crate) fn mean(film: &Film) -> Estimate {
    let count = film.pixels().len() as f64;
    let sum =
        |of: &dyn Fn(&snowgrain_film::PixelSums) -> f64| film.pixels().iter().map(of).sum::<f64>();
    let mean = sum(&|pixel| pixel.mean_radiance()[1]) / count;
    Estimate { mean, standard_error: sum(&|pixel| pixel.variance_of_mean()[1]).sqrt() / count }
}

/// Share of a Lambertian surface's hemisphere, by cosine, that a rectangle in a parallel plane at distance 1
/// fills, from above one of whose corners it is seen (Howell, "A catalog of radiation heat transfer
/// configuration factors", B-4).
fn corner_factor(a: f64, b: f64) -> f64 {
    let [u, v] = [(1.0 + a * a).sqrt(), (1.0 + b * b).sqrt()];
    (a / u * trig::atan2(b, u) + b / v * trig::atan2(a, v)) / (2.0 * PI)
}

/// A map that differs from pixel to pixel, and the irradiance of level ground under it over pi.
fn map() -> (Arc<EnvironmentMap>, f64) {
    let (width, height) = (64, 32);
    let value =
        |at: usize| 0.3 + 0.7 * ((at * 37 % 101) as f32 / 101.0) + f32::from(at == 600) * 30.0;
    let pixels = (0..width * height).map(|at| [value(at); 3]).collect();
    let map = EnvironmentMap::new(width, height, pixels).unwrap();
    let (rows, columns) = (400, 800);
    let mut sum = 0.0;
    for row in 0..rows {
        for column in 0..columns {
            let height = (f64::from(row) + 0.5) / f64::from(rows);
            let azimuth = 360.0 * (f64::from(column) + 0.5) / f64::from(columns);
            let direction = direction_of(trig::asin(height).to_degrees(), azimuth);
            sum += f64::from(map.radiance(direction)[1]) * direction.y;
        }
    }
    let irradiance = sum * 2.0 * PI / f64::from(rows * columns);
    (Arc::new(map), irradiance / PI)
}

#[test]
fn ground_under_each_light_has_the_radiance_of_its_closed_form() {
    let (map, under_map) = map();
    let sun = direction_of(40.0, 120.0);
    let sphere = DVec3::new(0.5, 0.8, 0.1);
    let to_sphere = sphere.length_squared();
    let rectangle = 2.0 * (corner_factor(0.6, 0.4) + corner_factor(0.6, 0.9));
    let half = trig::sin_cos(15f64.to_radians()).0;
    for (kind, strength, expected) in [
        (LightKind::Sky, 1.0, 1.0),
        (LightKind::Overcast, 1.0, 7.0 / 9.0),
        (LightKind::ClearSky { sun }, 1.0, 1.0),
        (LightKind::Sun { direction: sun, diameter_degrees: 30.0 }, 5.0, 5.0 * half * half * sun.y),
        (LightKind::Environment { map, rotation_degrees: 77.0 }, 1.0, under_map),
        (
            LightKind::Sphere { center: sphere, radius: 0.3 },
            2.0,
            2.0 * 0.09 / to_sphere * sphere.y / to_sphere.sqrt(),
        ),
        (
            LightKind::Quad {
                corner: DVec3::new(-0.6, 1.0, -0.4),
                edges: [DVec3::X * 1.2, DVec3::Z * 1.3],
            },
            3.0,
            3.0 * rectangle,
        ),
        // Seen from behind it is black.
        (
            LightKind::Quad {
                corner: DVec3::new(-0.6, 1.0, -0.4),
                edges: [DVec3::Z * 1.3, DVec3::X * 1.2],
            },
            3.0,
            0.0,
        ),
    ] {
        let name = format!("{kind:?}");
        let light = LightDescription::new(kind, [strength as f32; 3]);
        let found = mean(&film(&ground(vec![light]), 512));
        let expected = f64::from(ALBEDO) * expected;
        println!("{}: {found:?}, {expected}", &name[..name.len().min(40)]);
        assert_agrees(&name[..name.len().min(40)], found, expected, 1e-3 * expected);
    }
}

#[test]
fn an_object_shines_as_the_quad_that_is_its_lower_face() {
    let mut description =
        ground(vec![LightDescription::new(LightKind::Object { object: 1 }, [2.0; 3])]);
    let place = DAffine3::from_translation(DVec3::Y * 1.1)
        * DAffine3::from_scale(DVec3::new(0.6, 0.1, 0.6));
    description.objects.push(ObjectDescription {
        name: "lamp".into(),
        shape: ObjectShape::Box,
        surface: Surface::diffuse([0.5; 3]),
        direct_view: DirectView::Seen,
        transform: place,
    });
    let expected = f64::from(ALBEDO) * 2.0 * 4.0 * corner_factor(0.6, 0.6);
    assert_agrees("lamp", mean(&film(&description, 512)), expected, 1e-9);
}

#[test]
fn the_camera_sees_lamps_or_passes_through_them() {
    for visible_to_camera in [true, false] {
        let kind = LightKind::Sphere { center: DVec3::Y * 0.1, radius: 0.05 };
        let lamp = LightDescription { visible_to_camera, ..LightDescription::new(kind, [7.0; 3]) };
        let mut description = ground(vec![lamp]);
        let seen = film(&description, 4);
        if visible_to_camera {
            assert!(seen.pixels().iter().all(|pixel| pixel.mean_radiance() == [7.0; 3]));
        } else {
            // Right below a sphere: L (r / d)^2 of the hemisphere.
            let expected = f64::from(ALBEDO) * 7.0 * 0.25;
            assert_agrees("through", mean(&film(&description, 256)), expected, 1e-5);
        }
        // Without ground there is nothing behind it.
        description.objects[0].transform =
            DAffine3::from_translation(DVec3::Y * -9.0) * DAffine3::from_scale(DVec3::splat(1e-3));
        description.objects[0].shape = ObjectShape::Sphere;
        description.camera.at = DVec3::Y * 0.1001;
        description.camera.backdrop = [0.25; 3];
        let seen = film(&description, 2);
        let (radiance, alpha) = if visible_to_camera { (7.0, 1.0) } else { (0.25, 0.0) };
        assert!(visible_to_camera || seen.pixels().iter().all(|p| p.mean_radiance()[0] <= 0.25));
        let corner = seen.pixels()[0];
        assert_eq!((corner.mean_radiance()[0], corner.mean_alpha()), (radiance, alpha));
    }
}

/// Where nothing absorbs and all that shines has radiance 1, every path brings 1: lamps in and under
/// overlapping grains too.
#[test]
fn a_furnace_with_lamps_in_the_snow_is_exactly_one_everywhere() {
    let light = |kind| LightDescription::new(kind, [1.0; 3]);
    let sphere = LightKind::Sphere { center: DVec3::new(0.01, 0.02, 0.01), radius: 0.006 };
    let lights =
        vec![light(LightKind::Uniform), light(LightKind::Object { object: 1 }), light(sphere)];
    let description = pile(20_000, 0.06, [1.0; 3], lights);
    let film = film(&description, 16);
    assert!(film.pixels().iter().all(|pixel| pixel.mean_radiance() == [1.0; 3]));
}

#[test]
fn snow_falls_through_lamps() {
    let uniform = LightDescription::new(LightKind::Uniform, [1.0; 3]);
    let kind = LightKind::Sphere { center: DVec3::Y * 0.05, radius: 0.02 };
    let lamp = LightDescription::new(kind, [1.0; 3]);
    let grains = |lights| {
        let mut description = pile(5_000, 0.06, [0.5; 3], lights);
        description.snow = vec![SnowDescription::Deposit(fall(
            DepositRule::Stick,
            5_000,
            Some([-0.03, -0.03, 0.03, 0.03]),
        ))];
        let (field, _) = snowgrain_render::deposit(&description, &mut |_| ()).unwrap();
        let built = Scene::build(&description, &mut |_| ()).unwrap();
        assert_eq!(built.report.grains, 5_000);
        field.quantised().collect::<Vec<_>>()
    };
    assert!(grains(vec![uniform.clone()]) == grains(vec![uniform, lamp]));
}

/// One light after the other adds up to both at once: the paths are the same.
#[test]
fn lights_apart_add_up_to_the_whole() {
    let sun = direction_of(30.0, 0.0);
    let kinds = [
        LightKind::Overcast,
        LightKind::Sun { direction: sun, diameter_degrees: 20.0 },
        LightKind::Sphere { center: DVec3::new(0.02, 0.03, 0.0), radius: 0.005 },
    ];
    let lit = |on: [f32; 3]| {
        let light = |(kind, on): (&LightKind, f32)| LightDescription::new(kind.clone(), [on; 3]);
        let lights = kinds.iter().zip(on).map(light).collect();
        film(&pile(5_000, 0.06, [0.5; 3], lights), 16)
    };
    let all = lit([1.0, 2.0, 3.0]);
    let parts = [lit([1.0, 0.0, 0.0]), lit([0.0, 2.0, 0.0]), lit([0.0, 0.0, 3.0])];
    for (at, whole) in all.pixels().iter().enumerate() {
        let sum: f64 = parts.iter().map(|part| part.pixels()[at].mean_radiance()[0]).sum();
        assert!((whole.mean_radiance()[0] - sum).abs() < 1e-6);
    }
}
