//! Light whose colours are refracted each by its own index, and grains of other substances than ice.

use crate::cubes::picture;
use crate::samples;
use core::f64::consts::PI;
use snowgrain_film::{Film, PixelRect};
use snowgrain_formats::scene::{Loader, SceneFile, furnace, resolve};
use snowgrain_math::trig;
use snowgrain_optics::{BANDS, Substance};
use snowgrain_render::Scene;
use snowgrain_render::description::SceneDescription;

pub(crate) fn description(text: &str, changes: &[&str]) -> SceneDescription {
    let changes: Vec<String> = changes.iter().map(|&change| change.to_owned()).collect();
    let file = SceneFile::parse(text, "test.toml".as_ref(), &changes).unwrap();
    let loader = Loader {
        mesh: &mut |_| Err("no mesh".into()),
        grains: &mut |_| Err("no grains".into()),
        import: &mut |_| Err("no shot".into()),
        environment: &mut |_| Err("no map".into()),
        texture: &mut |_| Err("no texture".into()),
        sizes: &mut |_| Err("no sizes".into()),
        plan_image: &mut |_| Err("no pictures".into()),
        optical_constants: &mut |_| Err("no indices".into()),
    };
    resolve(&file, loader).unwrap()
}

fn film(scene: &Scene, samples: u64) -> Film {
    let whole = PixelRect::new(0, 0, scene.film.width, scene.film.height);
    picture(scene, 0..samples, whole).film
}

/// Crystals of half a millimetre, in sharp focus, on a plane.
const CUBES: &str = r#"
version = 1
[film]
width = 16
height = 16
[camera]
from = [0.0, 0.02, 0.02]
at = [0.0, 0.0, 0.0]
vertical_fov = 15.0
[[light]]
kind = "sky"
[[object]]
shape = "plane"
albedo = 0.5
[[snow]]
source = "deposit"
grains = 300
radius = "0.5 mm"
rule = "stick"
area = [-0.005, -0.005, 0.005, 0.005]
[[snow.shapes]]
shape = "cube"
"#;

/// No bit of the balance of white is lost by parting it: every pixel, after each of the bands once or twice.
#[test]
fn a_furnace_is_white_after_a_multiple_of_the_bands() {
    for kind in ["ice", "salt", "borosilicate-glass"] {
        let changes = [format!("material.kind=\"{kind}\""), "material.dispersion=true".to_owned()];
        let changes: Vec<&str> = changes.iter().map(String::as_str).collect();
        let white = furnace(description(CUBES, &changes));
        let scene = Scene::build(&white, &mut |_| ()).unwrap();
        assert_eq!(scene.bands.len(), BANDS);
        for runs in [1, 2] {
            let film = film(&scene, runs * BANDS as u64);
            for pixel in film.pixels() {
                let [r, g, b] = pixel.mean_radiance();
                for channel in [r, g, b] {
                    assert!((channel - 1.0).abs() < 1e-5, "{kind}: {r} {g} {b}");
                }
            }
        }
    }
}

/// Without dispersion salt, too, is exactly white in the furnace.
#[test]
fn grains_of_other_substances_lose_no_light() {
    for kind in ["salt", "sugar", "quartz", "fused-silica", "soda-lime-glass"] {
        let is_kind = format!("material.kind=\"{kind}\"");
        let scene = Scene::build(&furnace(description(CUBES, &[&is_kind])), &mut |_| ()).unwrap();
        assert!((1.4..1.6).contains(&scene.world.eta), "{kind}: {}", scene.world.eta);
        for pixel in film(&scene, 2).pixels() {
            assert_eq!(pixel.mean_radiance(), [1.0; 3], "{kind}");
        }
    }
}

/// A sheet of upright columns, turned at random, in a sun at the horizon: its mock sun. The camera looks past the
/// sun at the angles where it stands.
const MOCK_SUN: &str = r#"
version = 1
[film]
width = 96
height = 2
seed = 5
[camera]
from = [-1.0, 0.00087, 0.039]
at = [0.0, 0.00087, 0.039]
vertical_fov = 0.1
[material]
dispersion = true
[[light]]
kind = "sun"
elevation = 0.001
spectrum = "d65"
azimuth = 112.4
angular_diameter = 0.1
[[snow]]
source = "lattice"
lattice = "sc"
radius = "10 um"
spacing = "30 um"
counts = [1, 58, 2600]
[[snow.shapes]]
shape = "hexagonal-column"
aspect = 2.0
orientation = "horizontal"
[integrator]
calibration_paths = 16384
"#;

/// The angle by which a prism of 60 degrees turns light least, degrees.
fn least_deviation(index: f64) -> f64 {
    2.0 * trig::asin(0.5 * index).to_degrees() - 60.0
}

/// Angle at which a profile over rising angles first comes to half of its maximum, from straight lines between.
fn inner_edge(profile: &[(f64, f64)]) -> f64 {
    let half = 0.5 * profile.iter().map(|(_, value)| *value).fold(0.0, f64::max);
    let after = profile.iter().position(|(_, value)| *value >= half).unwrap();
    let ((a, low), (b, high)) = (profile[after - 1], profile[after]);
    a + (b - a) * (half - low) / (high - low)
}

/// Light of each band that the least deviation piles up, in a sun of .1 degree and pixels of .05: as the inverse
/// root of the angle beyond it, averaged over the sun.
fn expected_profile(scene: &Scene, angles: &[f64], channel: usize) -> Vec<(f64, f64)> {
    const WIDTH: f64 = 0.11;
    let root = |angle: f64| angle.max(0.0).sqrt();
    let light = |angle: f64| {
        let of_band = |band: &snowgrain_render::BandOptics| {
            let beyond = angle - least_deviation(band.eta);
            let piled = (root(beyond + 0.5 * WIDTH) - root(beyond - 0.5 * WIDTH)) / WIDTH;
            f64::from(band.colours[0].apply([1.0; 3], 0.0)[channel]) * piled
        };
        (angle, scene.bands.iter().map(of_band).sum::<f64>())
    };
    angles.iter().map(|&angle| light(angle)).collect()
}

#[test]
fn a_mock_sun_is_red_inside_and_blue_outside_at_the_angles_of_least_deviation() {
    let scene = Scene::build(&description(MOCK_SUN, &[]), &mut |_| ()).unwrap();
    for band in &scene.bands {
        let index = Substance::Ice.refractive_index(band.band.middle_nm);
        assert!((band.eta - index).abs() < 1e-12);
    }
    let sun = snowgrain_render::light::direction_of(0.001, 112.4);
    let film = film(&scene, samples(6400, 1 << 16));
    let angle = |x: u32| {
        let ray = scene.camera.ray(f64::from(x) + 0.5, 1.0, [0.5; 2]);
        trig::acos(ray.direction.dot(sun)) * 180.0 / PI
    };
    let mut columns: Vec<(f64, u32)> = (0..96).map(|x| (angle(x), x)).collect();
    columns.sort_by(|a, b| a.0.total_cmp(&b.0));
    let angles: Vec<f64> = columns.iter().map(|column| column.0).collect();
    let edges = [0, 1, 2].map(|channel: usize| {
        let seen = |x: u32| {
            (0..2).map(|y| film.pixels()[(y * 96 + x) as usize].mean_radiance()[channel]).sum()
        };
        let profile: Vec<(f64, f64)> = columns.iter().map(|&(angle, x)| (angle, seen(x))).collect();
        let expected = inner_edge(&expected_profile(&scene, &angles, channel));
        let found = inner_edge(&profile);
        println!("channel {channel}: edge at {found:.3} degrees, expected {expected:.3}");
        assert!((found - expected).abs() < 0.1, "{channel}: {found} {expected}");
        found
    });
    assert!(edges[0] + 0.1 < edges[1] && edges[1] + 0.1 < edges[2], "{edges:?}");
}
