//! Other ways of light through snow: media and the dipole.

use crate::Workplace;
use snowgrain_film::Layer;
use snowgrain_formats::image::read_picture;

const SCENE: &str = "\
version = 1
[film]
width = 24
height = 16
samples_per_pixel = 4
[camera]
from = [0.02, 0.1, 0.06]
at = [0.02, 0.005, 0.02]
vertical_fov = 10
[[light]]
kind = \"overcast\"
[[object]]
shape = \"plane\"
albedo = 0.5
[[snow]]
source = \"deposit\"
rule = \"stick\"
radius = \"0.5 mm\"
grains = 12000
area = [0, 0, 0.04, 0.04]
[integrator]
deep_depth = 0.1
deep = \"proxy\"
";

/// The options of each road.
const ROADS: [[&str; 4]; 5] = [
    ["--set", "integrator.deep=\"proxy\"", "--set", "integrator.deep_after_grains=2"],
    ["--set", "integrator.deep=\"shells\"", "--set", "integrator.deep_after_grains=2"],
    ["--set", "integrator={ kind = \"proxy\" }", "--set", "film.seed=0"],
    ["--set", "integrator={ kind = \"volume\" }", "--set", "film.seed=0"],
    ["--set", "integrator={ kind = \"dipole\" }", "--set", "film.seed=0"],
];

/// Snow that is a lattice.
const LATTICE: &str = "snow=[{ source = \"lattice\", lattice = \"fcc\", radius = 0.0005, \
                       counts = [20, 20, 20], density = 300 }]";

fn place() -> Workplace {
    let place = Workplace::new();
    place.file("scene.toml", SCENE);
    place
}

/// Whatever scatters light loses none and makes none: every pixel of a furnace is 1. The dipole is left out: it
/// takes snow for a half space, and is dark where that is small.
#[test]
fn media_are_white_in_the_furnace() {
    let place = place();
    for road in &ROADS[..4] {
        let render = ["render", "scene.toml", "--furnace", "-o", "white.exr", "--quiet"];
        place.succeed(&[&render[..], road].concat());
        let picture = read_picture(&place.path("white.exr")).unwrap();
        for layer in Layer::COLOUR {
            let values = picture.layer(layer).unwrap();
            let off = values.iter().map(|value| (value - 1.0).abs()).fold(0.0, f32::max);
            assert!(off < 1e-6, "{road:?}: {off}");
        }
    }
}

/// Grains of other shapes, sizes and stuff are measured before the picture, once where that is kept; none of their light is lost.
#[test]
fn other_grains_are_white_in_the_furnace_and_measured_once() {
    let place = place();
    let cubes = ["--set", "snow.shapes=[{ shape = \"cube\", rounding = 0.2 }]"];
    let salt = ["--set", "material.kind=\"salt\"", "--set", "snow.variation=\"0.2 mm\""];
    let kept = ["--learnt-cache", "kept"];
    let white = ["render", "scene.toml", "--furnace", "-o", "white.exr", "--quiet", "--spp", "1"];
    for road in &ROADS[..3] {
        place.succeed(&[&white[..], &cubes, &salt, &kept, road].concat());
        let picture = read_picture(&place.path("white.exr")).unwrap();
        let values = picture.layer(Layer::G).unwrap();
        let off = values.iter().map(|value| (value - 1.0).abs()).fold(0.0, f32::max);
        assert!(off < 1e-6, "{road:?}: {off}");
        assert_eq!(std::fs::read_dir(place.path("kept")).unwrap().count(), 1, "{road:?}");
    }
}

/// Among plates that lie exactly level light once went to and fro for ever in what is measured for the proxy.
#[test]
fn plates_that_lie_exactly_level_are_measured() {
    let place = place();
    let plate =
        "snow.shapes=[{ shape = \"hexagonal-plate\", aspect = 0.3, orientation = \"horizontal\" }]";
    let white = ["render", "scene.toml", "--furnace", "-o", "white.exr", "--quiet", "--spp", "1"];
    for road in [&ROADS[0], &ROADS[2]] {
        place.succeed(&[&white[..], &["--set", plate], road].concat());
        let picture = read_picture(&place.path("white.exr")).unwrap();
        let values = picture.layer(Layer::G).unwrap();
        let off = values.iter().map(|value| (value - 1.0).abs()).fold(0.0, f32::max);
        assert!(off < 1e-6, "{road:?}: {off}");
    }
}

#[test]
fn threads_do_not_show_in_any_road() {
    let place = place();
    for road in ROADS {
        for threads in ["1", "3"] {
            let name = format!("{threads}.film");
            let render = ["render", "scene.toml", "-o", &name, "--quiet", "--threads", threads];
            place.succeed(&[&render[..], &road].concat());
        }
        assert_eq!(place.bytes("1.film"), place.bytes("3.film"), "{road:?}");
    }
}

/// A sun is looked for on each road, and brings about what it brings to real grains: the tolerances of media are what they are wrong
/// by on so small a body, those of the deep roads four standard errors.
#[test]
fn roads_know_the_sun() {
    let place = place();
    let mean = |road: &[&str]| {
        let sun = ["--set", "light=[{ kind = \"sun\", elevation = 50 }]", "--spp", "64"];
        let render = ["render", "scene.toml", "-o", "a.exr", "--quiet"];
        place.succeed(&[&render[..], &sun, road].concat());
        let picture = read_picture(&place.path("a.exr")).unwrap();
        let green = picture.layer(Layer::G).unwrap();
        green.iter().map(|&value| f64::from(value)).sum::<f64>() / green.len() as f64
    };
    let exact = mean(&["--set", "integrator={ calibration_paths = 16384 }"]);
    for (road, allowed) in ROADS.iter().zip([0.08, 0.08, 0.15, 0.4, 0.6]) {
        let found = mean(road);
        assert!((found / exact - 1.0).abs() < allowed, "{road:?}: {found} instead of {exact}");
    }
}

/// Clean snow on dirty, all colours parted: what the proxy meets deep in either absorbs as its own grains do. Four standard errors
/// of the darkest channel, about 5 %; without its impurities the snow is twice as bright, with those of the dirty snow above a quarter.
#[test]
fn deep_roads_tell_the_impurities_of_one_snow_from_anothers() {
    let place = place();
    let snow = "snow=[{ source = \"pack\", box = [0, 0, 0, 0.04, 0.012, 0.04], radius = 0.0005, density = 300, \
                impurities = { black-carbon = \"20 ppm\" } }, \
                { source = \"pack\", box = [0, 0.012, 0, 0.04, 0.02, 0.04], radius = 0.0005, density = 300 }]";
    let mean = |road: &str| {
        let what = ["--set", snow, "--set", "material.dispersion=true", "--set", road];
        let render = ["render", "scene.toml", "-o", "a.exr", "--quiet", "--spp", "32"];
        place.succeed(&[&render[..], &what].concat());
        let picture = read_picture(&place.path("a.exr")).unwrap();
        let green = picture.layer(Layer::G).unwrap();
        green.iter().map(|&value| f64::from(value)).sum::<f64>() / green.len() as f64
    };
    let exact = mean("integrator={}");
    for road in ["integrator={ deep = \"proxy\" }", "integrator={ deep = \"shells\" }"] {
        let found = mean(road);
        assert!((found / exact - 1.0).abs() < 0.05, "{road:?}: {found} instead of {exact}");
    }
}

/// A plane that catches the shadow of snow: as much of it in media as among grains, and none far from the snow. The dipole lets nothing
/// through, and its snow is as wide as its density.
#[test]
fn media_throw_shadows_on_what_catches_them() {
    let place = place();
    let caught = |road: &[&str]| {
        let catching = ["--set", "object.0.shadow_catcher=true", "--set", "camera.vertical_fov=60"];
        let render = ["render", "scene.toml", "-o", "caught.exr", "--quiet", "--spp", "64"];
        place.succeed(&[&render[..], &catching, road].concat());
        let picture = read_picture(&place.path("caught.exr")).unwrap();
        let alpha = picture.layer(Layer::A).unwrap();
        let edge: f32 = alpha[..24].iter().sum();
        (alpha.iter().sum::<f32>() / alpha.len() as f32, edge / 24.0)
    };
    let (exact, _) = caught(&["--set", "integrator={ kind = \"grains\" }"]);
    for (road, allowed) in ROADS.iter().zip([0.1, 0.1, 0.1, 0.1, 0.4]) {
        let (found, edge) = caught(road);
        assert!((found / exact - 1.0).abs() < allowed, "{road:?}: {found} {exact}");
        assert!(edge < 0.1 * found, "{road:?}: {edge} of {found}");
    }
}

#[test]
fn what_a_road_cannot_do_is_refused_with_a_mend() {
    let place = place();
    let cases = [
        (
            &["integrator.kind=\"volume\""][..],
            "follows all light to its end; leave integrator.deep out",
        ),
        (
            &["integrator={ kind = \"volume\" }", "snow.shapes=[{ shape = \"cube\" }]"],
            "\"volume\" knows spheres alone",
        ),
        (
            &["integrator={ kind = \"dipole\" }", "film.keep=[\"ice-paths\"]"],
            "\"dipole\" knows no lengths in ice",
        ),
        (
            &["integrator={ kind = \"volume\" }", "material.dispersion=true"],
            "\"volume\" knows no dispersion",
        ),
        (&["integrator.deep=\"shells\"", LATTICE], "\"shells\" takes grains to lie at random"),
        (&["integrator={ kind = \"proxy\" }", LATTICE], "\"proxy\" takes grains to lie at random"),
        (&["integrator.learning_paths=2048"], "needs integrator.deep = \"learnt\""),
    ];
    for (changes, mend) in cases {
        let mut arguments = vec!["render", "scene.toml", "-o", "a.exr", "--quiet"];
        changes.iter().for_each(|change| arguments.extend(["--set", change]));
        let ended = place.run(&arguments);
        assert_ne!(ended.code, Some(0), "{changes:?}");
        assert!(ended.stderr.contains(mend), "{changes:?}: {}", ended.stderr);
        assert_eq!(ended.stderr.trim_end().lines().count(), 1, "{}", ended.stderr);
    }
    assert!(!place.names().contains(&"a.exr".to_owned()));
}
