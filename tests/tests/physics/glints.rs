//! Glints: how many there are, and how bright.

use crate::cubes::picture;
use crate::dispersion::description;
use crate::{SIGMAS, samples};
use snowgrain_accel::SimdLevel;
use snowgrain_film::PixelRect;
use snowgrain_math::DVec3;
use snowgrain_optics::Dielectric;
use snowgrain_render::camera::Camera;
use snowgrain_render::description::SceneDescription;
use snowgrain_render::light::direction_of;
use snowgrain_render::measure::{GlintKind, GlintMeasure, GlintSun, measure_glints};
use snowgrain_render::{Scene, World, deposit_at, surfaces_of};

/// A cloud of crystals far apart, so that hardly any hides another, in a sun 8 degrees wide.
const CLOUD: &str = r#"
version = 1
[film]
width = 64
height = 64
[camera]
kind = "orthographic"
from = [0.1, 1.0, 1.0]
at = [0.1, 0.02, 0.1]
height = 0.4
[ice]
absorption = 0.0
[[light]]
kind = "sun"
spectrum = "d65"
elevation = 40.0
azimuth = 60.0
angular_diameter = 8.0
[[snow]]
source = "lattice"
lattice = "sc"
radius = "0.1 mm"
spacing = "4 mm"
counts = [50, 10, 50]
[[snow.shapes]]
shape = "random-polyhedron"
faces = 20
"#;

fn measured(description: &SceneDescription, sun: GlintSun, rays: u32) -> GlintMeasure {
    let level = SimdLevel::detect();
    let (field, _) = deposit_at(description, level, &mut |_| ()).unwrap();
    let surfaces = surfaces_of(description);
    let grid = field.pack(&surfaces, description.packing.unwrap_or_default()).unwrap();
    let eta = description.ice.eta();
    let (materials, emitters) = (Vec::new(), Vec::new());
    let world = World { grid, surfaces, materials, emitters, eta };
    let camera = Camera::new(&description.camera, &description.film);
    measure_glints((&world, &field), &camera, sun, (rays, 1), level)
}

/// N Omega / (16 pi cos theta_h), and nothing is hidden but what the few shadows of a thin cloud hide.
#[test]
fn faces_that_mirror_the_sun_are_as_many_as_chance_makes() {
    let counts = samples(50, 200);
    let counts = format!("snow.counts=[{counts}, 10, {counts}]");
    let description = description(CLOUD, &[&counts]);
    let sun = GlintSun { direction: direction_of(40.0, 60.0), diameter_degrees: 8.0 };
    let found = measured(&description, sun, 4);
    let reflected = found.counts[GlintKind::Reflected as usize];
    println!("{found:?}");
    assert_eq!(found.passed_over, 0);
    assert!(found.crystals == 25_000 && found.faces > 16 * found.crystals);
    let off = (reflected.made as f64 - found.expected).abs();
    assert!(off <= SIGMAS * found.expected.sqrt(), "{reflected:?} {}", found.expected);
    // Of each ray's way through 10 layers a crystal hides (.1 mm / 4 mm)^2 pi a layer.
    assert!(reflected.seen <= reflected.made);
    assert!(reflected.seen as f64 > 0.93 * reflected.made as f64, "{reflected:?}");
    // By the reflectance at half the angle, of all of which the sun's disc is small.
    let half = 0.5 * (sun.direction + DVec3::new(0.0, 0.98, 0.9).normalize()).length();
    let reflectance = Dielectric { eta: 1.31 }.reflectance_from_outside(half);
    let mean = reflected.weight / reflected.made as f64;
    assert!((mean / reflectance - 1.0).abs() < 0.05, "{mean} {reflectance}");
    let within = found.counts[GlintKind::ReflectedWithin as usize];
    assert!(within.made > 0 && within.seen > within.made / 2, "{within:?}");
    // Against the light, 22 degrees beside it, crystals refract it.
    let against = DVec3::new(0.4, -0.7365, -0.6764).normalize();
    let found = measured(&description, GlintSun { direction: against, ..sun }, 4);
    let refracted = found.counts[GlintKind::Refracted as usize];
    assert!(refracted.made > 0 && refracted.seen > refracted.made / 2, "{refracted:?}");
    let off = (found.counts[0].made as f64 - found.expected).abs();
    assert!(off <= SIGMAS * found.expected.sqrt(), "{found:?}");
}

/// One level face that fills the pixels: R outside, and T^2 R, T^2 R^3, ... from the face below, together
/// 2 R / (1 + R) of the sun's radiance.
#[test]
fn a_face_that_fills_a_pixel_shows_the_sun_by_fresnel() {
    let towards = direction_of(40.0, 60.0);
    let eye = DVec3::new(0.0, 0.8, 0.6);
    let axis = (towards + eye).normalize();
    let middle = DVec3::splat(0.5e-3);
    let from = middle + eye;
    let text = CLOUD
        .replace("angular_diameter = 8.0\n", "")
        .replace("width = 64\nheight = 64", "width = 4\nheight = 4")
        .replace("from = [0.1, 1.0, 1.0]", &format!("from = [{}, {}, {}]", from.x, from.y, from.z))
        .replace("at = [0.1, 0.02, 0.1]\nheight = 0.4", "at = [0.0005, 0.0005, 0.0005]\nheight = 0.0001")
        .replace("radius = \"0.1 mm\"\nspacing = \"4 mm\"\ncounts = [50, 10, 50]", "radius = \"0.5 mm\"\ncounts = [1, 1, 1]")
        .replace(
            "shape = \"random-polyhedron\"\nfaces = 20",
            &format!(
                "shape = \"hexagonal-plate\"\naspect = 0.1\norientation = \"aligned\"\naxis = [{}, {}, {}]",
                axis.x, axis.y, axis.z
            ),
        );
    let description = description(&text, &["integrator.calibration_paths=16384"]);
    let sun = GlintSun { direction: towards, diameter_degrees: 0.53 };
    let found = measured(&description, sun, 4096);
    let [reflected, refracted, within] = found.counts;
    assert_eq!([reflected.made, reflected.seen, refracted.made], [1, 1, 0], "{found:?}");
    // Other ways go in by the sides of the plate, which the picture does not show.
    assert!(within.seen == 1 && within.made >= 1, "{found:?}");
    let scene = Scene::build(&description, &mut |_| ()).unwrap();
    let shown = picture(&scene, 0..4, PixelRect::new(0, 0, 4, 4)).film;
    let radiance = f64::from(scene.lights.radiance_at_infinity(0, towards)[1]);
    let r = Dielectric { eta: 1.31 }.reflectance_from_outside(axis.dot(eye));
    let expected = radiance * 2.0 * r / (1.0 + r);
    for pixel in shown.pixels() {
        let value = pixel.mean_radiance()[1];
        assert!((value / expected - 1.0).abs() < 1e-3, "{value} {expected}");
    }
}
