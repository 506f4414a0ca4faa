//! What good scenes mean.

use super::mesh_scenes::in_picture;
use super::{LEAST, meaning_of, read, triangle};
use crate::scene::{
    LoadError, Loader, SceneFile, builtin_scene, builtin_scenes, furnace, resolve, schema,
};
use snowgrain_grains::{Amount, DepositRule, DepositSettings, LatticeKind, Orientation, Radii};
use snowgrain_math::DVec3;
use snowgrain_optics::{
    Absorption, IceAbsorption, Illuminant, Impurity, ImpurityKind, Load, Metal, Primaries,
};
use snowgrain_render::description::{
    DirectView, Focus, IceDescription, Lens, LightDescription, LightFinding, LightKind,
    ObjectShape, Projection, Sampler, SceneDescription, SearchSettings, SnowDescription, Sought,
    Surface,
};
use snowgrain_render::surface::Reflectance;
use std::path::Path;
use std::sync::Arc;

fn builtin(name: &str) -> SceneDescription {
    let scene = builtin_scene(name).unwrap();
    meaning_of(&SceneFile::parse(scene.toml, Path::new(name), &[]).unwrap()).unwrap()
}

pub(super) fn deposit(scene: &SceneDescription) -> &DepositSettings {
    match &scene.snow[0] {
        SnowDescription::Deposit(settings) => settings,
        other => panic!("{other:?}"),
    }
}

#[test]
fn defaults_are_those_of_the_manual() {
    let scene = read(LEAST, &[]).unwrap();
    assert_eq!((scene.film.width, scene.film.height, scene.film.samples_per_pixel), (512, 512, 64));
    assert_eq!(scene.camera.projection, Projection::pinhole(40.0));
    assert_eq!(scene.camera.backdrop, [0.0; 3]);
    assert_eq!(scene.ice.ior, 1.31);
    assert_eq!(scene.ice.absorption, Absorption::Measured(IceAbsorption::Picard2016));
    assert!(scene.ice.impurities.is_empty());
    assert_eq!((scene.film.primaries, scene.film.keep_ice_paths), (Primaries::Srgb, false));
    assert_eq!(scene.film.sampler, Sampler::Independent);
    assert_eq!(scene.lights, [LightDescription::new(LightKind::Sky, [1.0; 3])]);
    assert_eq!(scene.objects[0].name, "object.0");
    assert_eq!(scene.objects[0].surface, Surface::diffuse([0.5; 3]));
    let expected = DepositSettings {
        amount: Amount::Grains(1000),
        radii: Radii::Uniform { mean: 0.0005, variation: 0.0 },
        density: None,
        rule: Some(DepositRule::Ray),
        max_slope_degrees: 80.0,
        direction: DepositSettings::DOWN,
        area: None,
        seed: 0,
    };
    assert_eq!(deposit(&scene), &expected);
}

#[test]
fn colours_of_ice_light_and_film_arrive() {
    let scene = read(
        LEAST,
        &[
            "ice.absorption=warren-brandt-2008",
            "ice.impurities={ black-carbon = \"200 ppb\", snow-algae = \"1e4 cells/mL\" }",
            "light.spectrum=equal-energy",
            "film.primaries=acescg",
            "film.sampler=sobol",
            "film.keep=[\"ice-paths\"]",
        ],
    )
    .unwrap();
    assert_eq!(scene.ice.absorption, Absorption::Measured(IceAbsorption::WarrenBrandt2008));
    let expected = [
        Impurity { kind: ImpurityKind::BlackCarbon, load: Load::MassFraction(200.0 * 1e-9) },
        Impurity { kind: ImpurityKind::SnowAlgae, load: Load::CellsPerKilogram(1e7) },
    ];
    assert_eq!(scene.ice.impurities, expected);
    assert_eq!(scene.lights[0].spectrum, Illuminant::EqualEnergy);
    assert_eq!((scene.film.primaries, scene.film.keep_ice_paths), (Primaries::AcesCg, true));
    assert_eq!(scene.film.sampler, Sampler::Sobol);
    assert_eq!(read(LEAST, &["ice.absorption=2"]).unwrap().ice.absorption, Absorption::Grey(2.0));
}

#[test]
fn impurities_that_all_snow_has_are_those_of_the_ice() {
    let lone = read(LEAST, &["snow.impurities={ black-carbon = \"1 ppm\" }"]).unwrap();
    assert_eq!(lone.ice.impurities.len(), 1);
    assert!(lone.strata.loads.is_empty());
    let second = "[[snow]]\nsource = \"deposit\"\ngrains = 5\nradius = 0.001\n\
                  impurities = { volcanic-ash = \"9 ppm\" }\n";
    let two = read(&format!("{LEAST}{second}"), &[]).unwrap();
    assert!(two.ice.impurities.is_empty());
    assert_eq!(two.strata.loads.len(), 1);
}

#[test]
fn water_joins_the_grains_or_fills_the_pores() {
    let wet = read(LEAST, &["snow.wetness=0.331", "snow.variation=\"0.1 mm\""]).unwrap();
    let radii = &deposit(&wet).radii;
    let Radii::Uniform { mean, variation } = radii else { panic!("{radii:?}") };
    assert!((mean - 0.55e-3).abs() < 1e-9 && (variation - 0.11e-3).abs() < 1e-9);
    let saturated = read(LEAST, &["ice.pores=water"]).unwrap();
    assert!((saturated.ice.eta() - 1.31 / 1.333).abs() < 1e-12);
    assert_eq!(read(LEAST, &[]).unwrap().ice.eta(), 1.31);
}

#[test]
fn every_deposit_key_arrives_in_metres() {
    let text = LEAST.replace("grains = 1000", "depth = \"3 cm\"")
        + "variation = \"200 um\"\ndensity = 250\nrule = \"roll\"\nmax_slope = 60\n\
           area = [\"-1 m\", -2, \"50 cm\", 0.25]\nseed = 7\n";
    let expected = DepositSettings {
        amount: Amount::Depth(0.03),
        radii: Radii::Uniform { mean: 0.0005, variation: 0.0002 },
        density: Some(250.0),
        rule: Some(DepositRule::Roll),
        max_slope_degrees: 60.0,
        direction: DepositSettings::DOWN,
        area: Some([-1.0, -2.0, 0.5, 0.25]),
        seed: 7,
    };
    assert_eq!(deposit(&read(&text, &[]).unwrap()), &expected);
    let stick = read(LEAST, &["snow.rule=stick"]).unwrap();
    assert_eq!(deposit(&stick).max_slope_degrees, 90.0);
    let wind = read(LEAST, &["snow.direction=[0.5, -1, 0]"]).unwrap();
    assert_eq!(deposit(&wind).direction, [0.5, -1.0, 0.0]);
    let alias = read(LEAST, &["snow.rule=chrisman"]).unwrap();
    assert_eq!(deposit(&alias).rule, Some(DepositRule::Ray));
    let varied = read(LEAST, &["snow.variation=0.5mm"]).unwrap();
    let expected = Radii::Uniform { mean: 0.0005, variation: 0.0005 };
    assert_eq!(deposit(&varied).radii, expected);
}

#[test]
fn overrides_change_and_add_values() {
    let scene = read(
        LEAST,
        &[
            "snow.0.radius = 0.3 mm",
            "snow.seed=5",
            "film.width=64",
            "camera.at.1=0.25",
            "light.0={kind=\"uniform\", radiance=[1, 2, 3]}",
            "object.name=a ball",
            "film.width=65",
            "film.keep+=ice-paths",
            "film.keep += \"light-groups\"",
            "light+={kind=\"sky\"}",
        ],
    )
    .unwrap();
    assert!(scene.film.keep_ice_paths && scene.film.keep_light_groups);
    assert_eq!(deposit(&scene).radii.mean(), 0.0003);
    assert_eq!(deposit(&scene).seed, 5);
    assert_eq!(scene.film.width, 65);
    assert_eq!(scene.camera.at, DVec3::new(0.0, 0.25, 0.0));
    assert_eq!(scene.objects[0].name, "a ball");
    let uniform = LightDescription::new(LightKind::Uniform, [1.0, 2.0, 3.0]);
    assert_eq!(scene.lights, [uniform, LightDescription::new(LightKind::Sky, [1.0; 3])]);
}

#[test]
fn objects_are_scaled_then_rotated_then_translated() {
    let scene = read(
        LEAST,
        &[
            "object.scale=[2, 3, 4]",
            "object.rotate=[0, 0, 90]",
            "object.translate=[10, \"5 cm\", 0]",
        ],
    )
    .unwrap();
    let transform = scene.objects[0].transform;
    assert_eq!(transform.transform_point3(DVec3::X), DVec3::new(10.0, 2.05, 0.0));
    assert_eq!(transform.transform_point3(DVec3::Z), DVec3::new(10.0, 0.05, 4.0));
}

#[test]
fn meshes_are_read_once_relative_to_the_scene() {
    let text = LEAST.replace("shape = \"sphere\"", "shape = \"mesh\"\nfile = \"model.obj\"")
        + "[[object]]\nshape = \"mesh\"\nfile = \"model.obj\"\nname = \"again\"\n";
    let file = SceneFile::parse(&text, Path::new("folder/scene.toml"), &[]).unwrap();
    let mut asked = Vec::new();
    let mut read_mesh = |path: &Path| {
        asked.push(path.to_owned());
        Ok(triangle())
    };
    let mut no_grains = |_: &Path| Err(LoadError::from("none"));
    let loader = Loader {
        mesh: &mut read_mesh,
        grains: &mut no_grains,
        environment: &mut |_| Err("nor a map".into()),
        import: &mut |_| Err("nor a shot".into()),
        texture: &mut |_| Err("nor a picture".into()),
        sizes: &mut |_| Err("nor a picture".into()),
        plan_image: &mut |_| Err("nor a picture".into()),
        optical_constants: &mut |_| Err("no indices".into()),
    };
    let scene = resolve(&file, loader).unwrap();
    assert_eq!(asked, [Path::new("folder/model.obj")]);
    assert_eq!(scene.objects[0].name, "model.obj");
    assert_eq!(scene.objects[1].name, "again");
}

#[test]
fn an_object_stands_where_its_instances_say() {
    let text = LEAST.replace(
        "shape = \"sphere\"",
        "shape = \"mesh\"\nfile = \"model.obj\"\nscale = 2\nalbedo = 0.25\ninstances = [\n\
         { translate = [1, 0, \"10 cm\"] },\n\
         { rotate = [0, 90, 0], scale = [1, 3, 1], albedo = [1, 0, 0] },\n]",
    );
    let scene = read(&text, &[]).unwrap();
    let [first, second] = scene.objects.as_slice() else { panic!("{:?}", scene.objects) };
    assert_eq!([&first.name, &second.name], ["model.obj.0", "model.obj.1"]);
    let expected = [[0.25; 3], [1.0, 0.0, 0.0]].map(Surface::diffuse);
    assert_eq!([&first.surface, &second.surface], expected.each_ref());
    assert_eq!(first.transform.transform_point3(DVec3::Y), DVec3::new(1.0, 2.0, 0.1));
    assert_eq!(second.transform.transform_point3(DVec3::ONE), DVec3::new(2.0, 6.0, -2.0));
    let (ObjectShape::Mesh(a), ObjectShape::Mesh(b)) = (&first.shape, &second.shape) else {
        panic!("{scene:?}")
    };
    assert!(Arc::ptr_eq(a, b));
    let moved = read(&text, &["object.instances.1.translate=[0, 5, 0]"]).unwrap();
    assert_eq!(moved.objects[1].transform.translation, DVec3::Y * 5.0);
}

#[test]
fn builtin_scenes_are_what_they_say() {
    assert_eq!(builtin_scenes().len(), 6);
    for scene in builtin_scenes() {
        let described = builtin(scene.name);
        assert!(scene.toml.starts_with("# "), "{} has no introduction", scene.name);
        assert_eq!((described.film.width, described.film.height), (512, 512));
    }
    for (thin, thick) in
        [("snowy-sphere-thin", "snowy-sphere-thick"), ("snowy-teapot-thin", "snowy-teapot")]
    {
        let (thin, thick) = (builtin(thin), builtin(thick));
        assert_eq!(deposit(&thin).amount, deposit(&thick).amount);
        assert!(deposit(&thin).radii.mean() < deposit(&thick).radii.mean());
        assert_eq!(thin.camera, thick.camera);
        assert_eq!(thin.ice.ior, 1.32);
    }
}

/// The camera of the benchmark: the centre seen from 2.6 sides away along (1, .9, .8), 40 degrees.
#[test]
fn cubes_are_seen_by_the_camera_of_the_benchmark() {
    for (name, kind, counts, side) in [
        ("snow-cube-sc", LatticeKind::Sc, 120, 120.0),
        ("snow-cube", LatticeKind::Fcc, 76, 76.0 * 2f64.sqrt() * 0.001),
    ] {
        let scene = builtin(name);
        let SnowDescription::Lattice(lattice) = &scene.snow[0] else { panic!("{name}") };
        assert_eq!((lattice.kind, lattice.counts), (kind, [counts; 3]));
        assert_eq!((lattice.spacing, lattice.density), (None, None));
        let center = DVec3::splat(side / 2.0);
        let from = center + DVec3::new(1.0, 0.9, 0.8).normalize() * (2.6 * side);
        assert!((scene.camera.at - center).length() < 1e-12 * side);
        assert!((scene.camera.from - from).length() < 1e-12 * side);
        assert_eq!(scene.camera.projection, Projection::pinhole(40.0));
    }
}

#[test]
fn a_shot_gives_its_objects_and_its_camera() {
    let text = "version = 1\n[import]\nfile = \"shot.glb\"\nscale = 2\ntranslate = [1, 0, 0]\n\
                [[light]]\nkind = \"sky\"\n";
    let scene = read(text, &[]).unwrap();
    let [low, high] = &scene.objects[..] else { panic!("{:?}", scene.objects) };
    let (ObjectShape::Mesh(a), ObjectShape::Mesh(b)) = (&low.shape, &high.shape) else { panic!() };
    assert!(Arc::ptr_eq(a, b), "a mesh is held once");
    assert_eq!(high.name, "at 0.5");
    assert_eq!(high.surface, Surface::diffuse([0.2, 0.3, 0.4]));
    assert_eq!(high.transform.transform_point3(DVec3::X), DVec3::new(3.0, 1.0, 0.0));
    assert_eq!(scene.camera.from, DVec3::new(1.0, 0.0, 4.0));
    assert_eq!(scene.camera.at - scene.camera.from, DVec3::Z * -2.0);
    assert_eq!(scene.camera.projection, Projection::pinhole(30.0));
    let plan = read(text, &["import.camera=plan"]).unwrap();
    assert_eq!(plan.camera.projection, Projection::Orthographic { height: 6.0 });
    let both = read(&LEAST.replace("[[light]]", "[import]\nfile=\"shot.glb\"\n[[light]]"), &[]);
    let both = both.unwrap();
    assert_eq!(both.objects.len(), 3, "the shot's and those of the scene");
    assert_eq!(both.camera.from, DVec3::new(0.0, 1.0, 3.0), "[camera] goes first");
}

/// The camera of [`LEAST`] stands sqrt(10) m from where it looks.
#[test]
fn lenses_and_parallel_rays_are_what_the_manual_says() {
    let projection = |changes: &[&str]| read(LEAST, changes).unwrap().camera.projection;
    let lens = |changes: &[&str]| match projection(changes) {
        Projection::Perspective { lens: Some(lens), .. } => lens,
        other => panic!("{other:?}"),
    };
    let round = lens(&["camera.aperture=2mm"]);
    let Focus::Distance(distance) = round.focus else { panic!("{round:?}") };
    assert!((distance - 10f64.sqrt()).abs() < 1e-15);
    let focus = Focus::Distance(distance);
    let expected = Lens { diameter: 0.002, focus, blades: 0, blade_rotation_degrees: 0.0 };
    assert_eq!(round, expected);
    let bladed = [
        "camera.aperture=2mm",
        "camera.focus=30cm",
        "camera.blades=7",
        "camera.blade_rotation=-12.5",
    ];
    let expected = Lens {
        diameter: 0.002,
        focus: Focus::Distance(0.3),
        blades: 7,
        blade_rotation_degrees: -12.5,
    };
    assert_eq!(lens(&bladed), expected);
    // Half way: the plane through a point, wherever in it the point lies.
    let beside = lens(&["camera.aperture=2mm", "camera.focus=[5, 0.5, 1.5]"]);
    assert!(matches!(beside.focus, Focus::Distance(distance)
        if (distance - 10f64.sqrt() / 2.0).abs() < 1e-12));
    assert_eq!(lens(&["camera.aperture=2mm", "camera.focus=surface"]).focus, Focus::Surface);
    // 53.13 degrees: the sensor is as high as the lens is long.
    let normal = ["camera.vertical_fov=53.13010235415598", "camera.f_number=2.4"];
    assert!((lens(&normal).diameter - 0.01).abs() < 1e-15);
    let small = [normal[0], normal[1], "camera.sensor_height=\"12 mm\""];
    assert!((lens(&small).diameter - 0.005).abs() < 1e-15);
    let parallel = projection(&["camera.kind=orthographic", "camera.height=10cm"]);
    assert_eq!(parallel, Projection::Orthographic { height: 0.1 });
}

#[test]
fn an_exposure_value_shows_the_luminance_that_saturates_as_white() {
    let stops = |ev100: &str| read(LEAST, &[ev100]).unwrap().film.exposure_stops;
    assert_eq!(read(LEAST, &[]).unwrap().film.exposure_stops, 0.0);
    let gain = |ev100| snowgrain_math::trig::pow(2.0, stops(ev100));
    assert!((1.2 * 32_768.0 * gain("camera.ev100=15") - 1.0).abs() < 1e-12);
    assert!((1.2 / 8.0 * gain("camera.ev100=-3.0") - 1.0).abs() < 1e-12);
}

/// The object's extremes and 3 cm of snow on its top lie in the picture.
#[test]
fn snowy_objects_fit_into_their_pictures() {
    let fits = |name: &str, point: DVec3| {
        let [across, up] = in_picture(&builtin(name), point);
        assert!(across.abs() < 1.0 && up.abs() < 1.0, "{name} {point} {across} {up}");
    };
    for name in ["snowy-sphere-thick", "snowy-sphere-thin"] {
        for axis in DVec3::AXES {
            fits(name, axis * 0.075);
            fits(name, axis * -0.075);
        }
        fits(name, DVec3::Y * 0.105);
    }
    for name in ["snowy-teapot", "snowy-teapot-thin"] {
        let [x0, z0, x1, z1] = deposit(&builtin(name)).area.unwrap();
        for (x, z) in [(x0, z0), (x0, z1), (x1, z0), (x1, z1)] {
            fits(name, DVec3::new(x, 0.0, z));
        }
        fits(name, DVec3::Y * 0.128);
    }
}

#[test]
fn objects_are_of_metal_glass_or_pictures() {
    let of = |keys: &str| {
        let keys = format!("shape = \"plane\"\n{keys}");
        let scene = read(&LEAST.replace("shape = \"sphere\"", &keys), &["snow=[]"]).unwrap();
        (scene.objects[0].surface.clone(), scene)
    };
    let (gold, _) = of("material = \"conductor\"\nmetal = \"gold\"");
    let reflectance = Reflectance::Colour(Metal::Gold.reflectance());
    assert_eq!(gold, Surface::Conductor { reflectance, edge: Metal::Gold.edge(), roughness: 0.3 });
    let (own, _) =
        of("material = \"conductor\"\nreflectance = [1, 0.5, 0]\nroughness = 0\nholdout = true");
    let reflectance = Reflectance::Colour([1.0, 0.5, 0.0]);
    assert_eq!(own, Surface::Conductor { reflectance, edge: [0.0; 3], roughness: 0.0 });
    let (glass, _) = of("material = \"dielectric\"");
    assert_eq!(glass, Surface::Dielectric { ior: 1.5, roughness: 0.0 });
    let (bark, scene) = of("albedo_texture = \"bark.png\"\ntexture_scale = \"20 cm\"");
    let map = bark.texture().unwrap();
    assert_eq!((map.texture.size(), map.metres, map.factor), ([2, 1], 0.2, [1.0; 3]));
    assert_eq!(scene.objects[0].direct_view, DirectView::Seen);
    for (key, view) in
        [("holdout", DirectView::Holdout), ("shadow_catcher", DirectView::ShadowCatcher)]
    {
        let scene = of(&format!("{key} = true")).1;
        assert_eq!(scene.objects[0].direct_view, view);
        assert_eq!(furnace(scene).objects[0].direct_view, DirectView::Seen);
    }
}

#[test]
fn a_furnace_has_white_walls_and_one_uniform_light() {
    let mut scene = builtin("snowy-teapot");
    scene.light_finding = LightFinding::Sampled(SearchSettings::of(Sought::All));
    let scene = furnace(scene);
    assert_eq!(scene.light_finding, LightFinding::Exact);
    assert_eq!(scene.lights, [LightDescription::new(LightKind::Uniform, [1.0; 3])]);
    assert_eq!(scene.objects[0].surface, Surface::diffuse([1.0; 3]));
    assert_eq!(scene.camera.backdrop, [1.0; 3]);
    assert_eq!(scene.ice, IceDescription::clear(scene.ice.ior));
}

#[test]
fn the_committed_schema_is_current() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/scene.schema.json");
    let committed = std::fs::read_to_string(path).unwrap_or_default();
    assert!(
        committed == schema(),
        "docs/scene.schema.json is stale; write it anew with \
         `cargo run --release -- schema > docs/scene.schema.json`"
    );
}

#[test]
fn shapes_of_grains_mean_what_they_say() {
    let text = format!(
        "{LEAST}[[snow.shapes]]\nshape = \"hexagonal-plate\"\nfraction = 3\n\
         orientation = \"horizontal\"\nspread = 5\n\
         [[snow.shapes]]\nshape = \"rosette\"\narms = 4\naspect = 3\nrounding = 0.5\n\
         [[light]]\nkind = \"sun\"\nelevation = 30\nazimuth = 0\n"
    );
    let scene = read(&text, &[]).unwrap();
    assert!(matches!(scene.light_finding, LightFinding::Sampled(_)));
    let shapes = scene.shapes_of(0).unwrap().shapes();
    assert_eq!(shapes[0].shape.name(), "hexagonal-prism aspect 0.2 rounding 0");
    assert_eq!(shapes[0].fraction, 3.0);
    assert_eq!(shapes[0].orientation, Orientation::Horizontal { spread_degrees: 5.0 });
    assert_eq!(shapes[1].shape.name(), "rosette arms 4 aspect 3 rounding 0.5");
    assert_eq!((shapes[1].fraction, shapes[1].orientation), (1.0, Orientation::Random));
    let spheres = format!(
        "{LEAST}[[snow.shapes]]\nshape = \"sphere\"\n[[light]]\nkind = \"sun\"\nelevation = 30\nazimuth = 0\n"
    );
    let scene = read(&spheres, &[]).unwrap();
    assert!(scene.shapes_of(0).is_none() && !scene.has_shapes());
    assert!(matches!(scene.light_finding, LightFinding::Sampled(_)));
}
