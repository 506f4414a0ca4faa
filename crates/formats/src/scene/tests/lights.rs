//! What `[[light]]` and `emission` mean, and what is refused of them.

use super::{LEAST, lit_shot, read, refusal, shot};
use crate::scene::scene_for_shot;
use snowgrain_math::{DVec3, trig};
use snowgrain_optics::{Illuminant, SunZenith};
use snowgrain_render::description::{LightFinding, LightKind, SearchSettings, Sought};
use snowgrain_render::light::{direction_of, irradiance_of_disc};
use snowgrain_render::transport::deep::DeepSettings;
use std::f64::consts::PI;

/// The refusal of the least scene where `line` replaces `old`.
fn instead(old: &str, line: &str) -> String {
    refusal(&LEAST.replace(old, line), &[])
}

#[test]
fn the_sun_stands_where_place_and_time_say() {
    let light = "kind = \"sun\"\ntime = \"2003-10-17T12:30:30-07:00\"\nlatitude = 39.742476\n\
                 longitude = -105.1786";
    let scene = read(&under(light), &[]).unwrap();
    let LightKind::Sun { direction, .. } = scene.lights[0].kind else { panic!() };
    let expected = direction_of(39.888, 194.340);
    assert!(direction.angle_between(expected).to_degrees() < 0.05);
}

#[test]
fn lamps_have_their_places_and_objects_shine() {
    let sphere = "kind = \"sphere\"\ncenter = [0, 1, 0]\nradius = \"5 cm\"\nradiance = 3";
    let quad = "[[light]]\nkind = \"quad\"\ncorner = [0, 2, 0]\nedges = [[1, 0, 0], [0, 0, 1]]\n";
    let object = "[[object]]\nshape = \"box\"\nemission = [1, 2, 3]\nemission_spectrum = \"a\"\n\
                  instances = [{ translate = [5, 0, 0] }, { translate = [9, 0, 0] }]\n";
    let scene = read(&format!("{}{quad}{object}", under(sphere)), &[]).unwrap();
    assert_eq!(scene.objects.len(), 3);
    let kinds: Vec<_> = scene.lights.iter().map(|light| light.kind.clone()).collect();
    let expected = [
        LightKind::Sphere { center: DVec3::Y, radius: 0.05 },
        LightKind::Quad { corner: DVec3::Y * 2.0, edges: [DVec3::X, DVec3::Z] },
        LightKind::Object { object: 1 },
        LightKind::Object { object: 2 },
    ];
    assert_eq!(kinds, expected);
    assert_eq!(scene.lights[0].strength, [3.0; 3]);
    assert_eq!(scene.lights[2].strength, [1.0, 2.0, 3.0]);
    assert_eq!(scene.lights[2].spectrum, Illuminant::A);
    assert!(scene.lights.iter().all(|light| light.group == "lamps"));
    // A lamp alone is light enough.
    let dark = LEAST.replace("[[light]]\nkind = \"sky\"\n", "");
    assert_eq!(read(&format!("{dark}{object}"), &[]).unwrap().lights.len(), 2);
}

#[test]
fn maps_of_all_directions_are_read_and_turned() {
    let light = "kind = \"environment\"\nfile = \"sky.hdr\"\nrotation = -90\nstrength = 2";
    let scene = read(&under(light), &[]).unwrap();
    let LightKind::Environment { map, rotation_degrees } = &scene.lights[0].kind else {
        panic!("{:?}", scene.lights)
    };
    assert_eq!((map.width(), *rotation_degrees), (2, 270.0));
    assert_eq!((scene.lights[0].strength, &*scene.lights[0].group), ([2.0; 3], "environment"));
}

/// The least scene under another light.
fn under(light: &str) -> String {
    LEAST.replace("kind = \"sky\"", light)
}

#[test]
fn sun_and_clear_sky_light_white_ground_to_a_radiance_of_one() {
    for elevation in [90.0, 41.8, 20.0, 3.0] {
        let light = format!("kind = \"sun-sky\"\nelevation = {elevation}\nazimuth = 90");
        let scene = read(&under(&light), &[]).unwrap();
        let [sun, sky] = &scene.lights[..] else { panic!("{:?}", scene.lights) };
        let LightKind::Sun { direction, diameter_degrees } = sun.kind else { panic!("{sun:?}") };
        assert_eq!(sky.kind, LightKind::ClearSky { sun: direction });
        assert!((direction.y - trig::sin_cos(f64::to_radians(elevation)).0).abs() < 1e-12);
        assert!(direction.x >= 0.0 && direction.z.abs() < 1e-12);
        // The irradiance of a disc across its light, and of level ground by a sky of strength pi.
        let sine = trig::sin_cos((diameter_degrees * 0.5).to_radians()).0;
        let disc = PI * sine * sine;
        let ground =
            f64::from(sun.strength[1]) * disc * direction.y / PI + f64::from(sky.strength[1]);
        assert!((ground - 1.0).abs() < 1e-6, "{elevation}: {ground}");
        assert_eq!((&*sun.group, &*sky.group), ("sun", "sky"));
        let zenith = SunZenith::new(90.0 - elevation);
        assert_eq!(sun.spectrum, Illuminant::Sun(zenith));
        assert_eq!(sky.spectrum, Illuminant::ClearSky(zenith));
    }
}

#[test]
fn a_real_sun_has_the_luminance_of_a_real_day_and_parts_are_those_of_the_whole() {
    let of = |kind: &str, more: &str| {
        let light = format!("kind = \"{kind}\"\nelevation = 60\n{more}");
        read(&under(&light), &[]).unwrap().lights
    };
    let both = of("sun-sky", "units = \"cd/m2\"");
    assert!((1.3e9..1.9e9).contains(&both[0].strength[0]), "{:?}", both[0]);
    assert!((2e3..1e4).contains(&both[1].strength[0]), "{:?}", both[1]);
    assert_eq!(of("sun", "units = \"cd/m2\""), both[..1]);
    assert_eq!(of("clear-sky", "units = \"cd/m2\""), both[1..]);
    // A wider sun is dimmer; a tint stays a tint.
    let wide = of("sun", "angular_diameter = 5.33\nstrength = [2, 1, 1]");
    let narrow = of("sun", "");
    assert!((narrow[0].strength[1] / wide[0].strength[1] - 99.93).abs() < 0.1);
    assert_eq!(wide[0].strength[0], 2.0 * wide[0].strength[1]);
    let white = of("sun", "spectrum = \"d65\"\ngroup = \"key\"");
    assert_eq!((white[0].spectrum, &*white[0].group), (Illuminant::D65, "key"));
}

#[test]
fn lights_that_cannot_shine_are_refused() {
    let light = |lines: &str| instead("kind = \"sky\"", lines);
    for elevation in ["0", "-3", "90.5", "nan"] {
        let message = light(&format!("kind = \"sun-sky\"\nelevation = {elevation}"));
        let expected =
            format!("folder/scene.toml:7: light.0.elevation = {elevation}: must be above 0");
        assert!(message.starts_with(&expected), "{message}");
    }
    for (lines, expected) in [
        ("kind = \"sun\"", "light.0.elevation is missing: say how high the sun stands"),
        (
            "kind = \"sky\"\nelevation = 3",
            "light.0.elevation = 3: not a key of kind = \"sky\" but of \"clear-sky\", \"sun\", \"sun-sky\"",
        ),
        ("kind = \"sun\"\nelevation = 3\nradiance = 1", "light.0.radiance = 1: not a key of kind"),
        ("kind = \"sun\"\nelevation = 3\nangular_diameter = 0", "must be 0.001 to 90 degrees"),
        ("kind = \"sun\"\nelevation = 3\nazimuth = inf", "light.0.azimuth = inf: must be finite"),
        (
            "kind = \"sun\"\nelevation = 3\nstrength = -1",
            "light.0.strength = -1: must be finite and not",
        ),
        ("kind = \"sky\"\ngroup = \"\"", "light.0.group = \"\": must be a name"),
        ("kind = \"environment\"", "light.0.file is missing: name the map, as file = \"sky.hdr\""),
        (
            "kind = \"environment\"\nfile = \"none.hdr\"",
            "light.0.file = \"none.hdr\": no such file",
        ),
        ("kind = \"environment\"\nfile = \"sky.hdr\"\nrotation = nan", "must be finite numbers"),
        (
            "kind = \"sun\"\ntime = \"2026-01-15T23:30:00+01:00\"\nlatitude = 47\nlongitude = 11",
            "light.0.time = \"2026-01-15T23:30:00+01:00\": the sun is then 6",
        ),
        (
            "kind = \"sun\"\ntime = \"2026-01-15T13:30:00\"\nlatitude = 47\nlongitude = 11",
            "with the offset from UTC",
        ),
        (
            "kind = \"sun\"\ntime = \"noon\"\nlatitude = 47\nlongitude = 11",
            "write it as \"2026-01-15T",
        ),
        (
            "kind = \"sun\"\ntime = \"2026-01-15T13:30:00Z\"",
            "light.0.latitude is missing: say where",
        ),
        (
            "kind = \"sun\"\ntime = \"2026-01-15T13:30:00Z\"\nlatitude = 95\nlongitude = 0",
            "light.0.latitude = 95: must be -90 to 90 degrees",
        ),
        (
            "kind = \"sun\"\ntime = \"2026-01-15T13:30:00Z\"\nelevation = 9",
            "light.0.elevation = 9: time says where the sun stands, too",
        ),
        (
            "kind = \"sun\"\nelevation = 9\nlatitude = 9",
            "a place says where the sun stands only with a time",
        ),
        ("kind = \"sphere\"\ncenter = [0, 1, 0]", "light.0.radius is missing: say how large"),
        (
            "kind = \"sphere\"\ncenter = [0, 1, 0]\nradius = 0",
            "light.0.radius = 0: must be a finite length above 0",
        ),
        ("kind = \"sphere\"\nradius = 1", "light.0.center is missing: say where"),
        (
            "kind = \"quad\"\ncorner = [0, 1, 0]\nedges = [[1, 1, 0], [2, 2, 0]]",
            "light.0.edges = [[1, 1, 0], [2, 2, 0]]: the edges are parallel or 0",
        ),
        ("kind = \"quad\"\ncorner = [0, 1, 0]\nedges = [[0, 0, 0], [1, 0, 0]]", "parallel or 0"),
        ("kind = \"spot\"\nposition = [0, 1, 0]\ndirection = [0, 0, 0]", "must not be zero"),
        (
            "kind = \"spot\"\nposition = [0, 1, 0]\ninner_angle = 40",
            "light.0.outer_angle = (default): must be above inner_angle, 40",
        ),
        (
            "kind = \"point\"\nvisible_to_camera = true",
            "light.0.visible_to_camera = true: not a key of kind = \"point\"",
        ),
        ("kind = \"moon\"", "light.0.kind = \"moon\""),
    ] {
        let message = light(lines);
        assert!(message.contains(expected), "{message}");
    }
}

#[test]
fn a_search_is_calibrated_by_as_many_paths_as_are_asked_for() {
    let sun = under("kind = \"sun\"\nelevation = 30");
    let finding = |paths: &str| {
        let set = format!("integrator.calibration_paths={paths}");
        read(&sun, &[&set]).map(|scene| scene.light_finding)
    };
    let settings =
        SearchSettings { calibration_paths: 4096, ..SearchSettings::of(Sought::NotSkies) };
    assert_eq!(finding("4096").unwrap(), LightFinding::Sampled(settings));
    for paths in ["0", "1023", "2000000000"] {
        let set = format!("integrator.calibration_paths={paths}");
        assert!(refusal(&sun, &[&set]).contains("must be a whole number from 1024 to 1e9"));
    }
    let exact = ["integrator.light=exact", "integrator.calibration_paths=4096"];
    assert!(refusal(&sun, &exact).contains("no light is looked for in this scene; remove it"));
}

#[test]
fn light_deep_in_the_snow_is_learnt_as_an_error_asks() {
    let snow = under("kind = \"sky\"");
    let deep = |sets: &[&str]| read(&snow, sets).map(|scene| scene.deep).unwrap();
    assert_eq!(deep(&[]), None);
    let learnt = "integrator.deep=learnt";
    assert_eq!(deep(&[learnt]), DeepSettings::for_error(0.01));
    let own = deep(&[learnt, "integrator.lod_error=0.001", "integrator.deep_depth=0.25"]).unwrap();
    assert_eq!((own.after_grains, own.depth), ([8, 4], 0.25));
    for (sets, expected) in [
        (["integrator.lod_error=0.01", "film.seed=1"], "needs integrator.deep = \"learnt\""),
        ([learnt, "integrator.lod_error=0.0001"], "must be from 0.001 to 1"),
        ([learnt, "integrator.lod_error=2"], "must be from 0.001 to 1"),
        ([learnt, "integrator.deep_depth=-1"], "must be from 0 to 20"),
        ([learnt, "integrator.learning_paths=5"], "must be a whole number from 1024 to 1e9"),
    ] {
        let message = refusal(&snow, &sets);
        assert!(message.contains(expected), "{message}");
    }
}

/// A scene that has no light but those of its shot.
const SHOT: &str = "version = 1\n[import]\nfile = \"lit.glb\"\nscale = 2\nrotate = [0, 0, 90]\n";

#[test]
fn lights_of_a_shot_shine_in_lux_and_candela() {
    let scene = read(SHOT, &["light+={kind=\"sky\"}"]).unwrap();
    assert_eq!(scene.light_finding, LightFinding::Sampled(SearchSettings::of(Sought::NotSkies)));
    let [sky, sun, bulb, torch] = &scene.lights[..] else { panic!("{:?}", scene.lights) };
    assert_eq!(sky.kind, LightKind::Sky, "those of the scene come first");
    let LightKind::Sun { direction, diameter_degrees } = sun.kind else { panic!("{sun:?}") };
    // It came from above, and all was turned about z by a quarter.
    assert!((direction - DVec3::NEG_X).length() < 1e-12 && diameter_degrees == 0.533);
    let lux = sun.strength.map(|x| f64::from(x) * irradiance_of_disc(diameter_degrees));
    assert!((0..3).all(|c| (lux[c] / [1e5, 0.9e5, 0.8e5][c] - 1.0).abs() < 1e-6), "{lux:?}");
    assert!(!sun.visible_to_camera);
    let LightKind::Point { position } = bulb.kind else { panic!("{bulb:?}") };
    let moved = DVec3::new(-6.0, 0.0, 1.0);
    assert!((position - moved).length() < 1e-12, "{position}");
    assert_eq!(bulb.strength, [100.0; 3]);
    let LightKind::Spot { position, direction, inner_degrees, outer_degrees } = torch.kind else {
        panic!("{torch:?}")
    };
    assert!((position - moved).length() < 1e-12 && (direction - DVec3::X).length() < 1e-12);
    assert_eq!((inner_degrees, outer_degrees), (0.0, 0.5f64.to_degrees()));
    assert_eq!(torch.strength, [25.0; 3]);
    let groups = scene.lights.iter().map(|light| &*light.group);
    assert!(groups.eq(["sky", "sun", "lamps", "lamps"]));
    let dim = read(SHOT, &["import.light_strength=[1, 0.5, 0]"]).unwrap();
    assert_eq!(dim.lights[1].strength, [100.0, 50.0, 0.0], "the shot's lights are light enough");
    assert!(refusal(SHOT, &["import.file=shot.glb"]).contains("light is missing"));
    assert!(refusal(SHOT, &["import.light_strength=-1"]).contains("must be finite and not neg"));
    let bright = refusal(SHOT, &["import.light_strength=1e38"]);
    assert!(bright.contains("the light \"sun\" is too far or too bright"), "{bright}");
}

#[test]
fn points_are_refused_only_where_light_is_not_looked_for() {
    let point = under("kind = \"point\"\nposition = [0, 1, 0]");
    let expected = "integrator.light = exact: no path meets a light of kind \"point\" or \"spot\"";
    for text in [&*point, SHOT] {
        for finding in ["auto", "sampled", "all-sampled"] {
            let set = format!("integrator.light={finding}");
            assert_ne!(read(text, &[&set]).unwrap().light_finding, LightFinding::Exact);
        }
        let refused = refusal(text, &["integrator.light=exact"]);
        assert!(refused.contains(expected), "{refused}");
    }
}

#[test]
fn a_shot_alone_is_lit_by_its_own_lights_or_the_sky() {
    let made = scene_for_shot("lit.glb", &lit_shot(), None).unwrap();
    let scene = read(&made.toml, &[]).unwrap();
    let kinds: Vec<_> = scene.lights.iter().map(|light| &*light.group).collect();
    assert_eq!(kinds, ["sun", "lamps", "lamps"]);
    // White that faces the lights in the middle of the objects, at (.5, .25, .5).
    let sun = f64::from(scene.lights[0].strength[0]) * irradiance_of_disc(0.533);
    let lamps = f64::from(scene.lights[1].strength[0] + scene.lights[2].strength[0]);
    let radiance = (sun + lamps / (0.25 + 2.75 * 2.75)) / PI;
    assert!((radiance - 1.0).abs() < 1e-6, "{radiance}");
    assert!(made.assumptions.iter().any(|line| line.contains("3 lights of the file")));
    let made = scene_for_shot("shot.glb", &shot(), None).unwrap();
    assert_eq!(read(&made.toml, &[]).unwrap().lights[0].kind, LightKind::Sky);
}

#[test]
fn objects_that_cannot_shine_are_refused() {
    let object = |lines: &str| instead("shape = \"sphere\"", lines);
    for (lines, expected) in [
        ("shape = \"plane\"\nemission = 1", "object.0.emission = 1: a plane has no end"),
        (
            "shape = \"box\"\nemission = 1\nalbedo = 0.5",
            "object.0.albedo = 0.5: an object with emission is black",
        ),
        (
            "shape = \"box\"\nemission = 1\ninstances = [{ albedo = 0.5 }]",
            "object.0.instances.0.albedo = 0.5: an object with emission is black",
        ),
        ("shape = \"box\"\nemission = -1", "object.0.emission = -1: must be finite"),
        (
            "shape = \"box\"\nemission_group = \"a\"",
            "object.0.emission_group = \"a\": the object has no emission",
        ),
    ] {
        let message = object(lines);
        assert!(message.contains(expected), "{message}");
    }
}
