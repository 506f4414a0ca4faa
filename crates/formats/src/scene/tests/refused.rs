//! Each class of bad scene and the message that it gets.

mod snow;

use super::{LEAST, refusal};
use crate::scene::{MAX_SCENE_BYTES, SceneError, SceneFile};
use std::path::Path;

/// The refusal of the least scene where `line` replaces `old`.
fn instead(old: &str, line: &str) -> String {
    assert!(LEAST.contains(old));
    refusal(&LEAST.replace(old, line), &[])
}

/// The refusal of the least scene with lines added to its snow.
fn in_snow(lines: &str) -> String {
    refusal(&format!("{LEAST}{lines}\n"), &[])
}

#[test]
fn unknown_keys_suggest_the_nearest() {
    assert_eq!(
        instead("radius = \"0.5 mm\"", "radus = \"0.5 mm\""),
        "folder/scene.toml:12: snow.0.radus: unknown key; did you mean `snow.0.radius`?"
    );
    assert_eq!(
        instead("[camera]", "[camra]"),
        "folder/scene.toml:2: camra: unknown key; did you mean `camera`?"
    );
    assert_eq!(
        in_snow("temperature = -3"),
        "folder/scene.toml:13: snow.0.temperature: unknown key; known here: area, base, box, \
         counts, density, density_map, depth, direction, file, grains, height, impurities, kind, lattice, mask, \
         max_slope, radius, rotate, rule, scale, seed, shapes, sizes, source, spacing, spread, translate, \
         variation, wetness"
    );
    let long = instead("[camera]", &format!("[{}]", "x".repeat(10_000)));
    assert!(long.len() < 300, "{long}");
}

#[test]
fn text_that_is_not_toml_names_its_line() {
    let message = instead("kind = \"sky\"", "kind = \"sky");
    assert!(message.starts_with("folder/scene.toml:6: not TOML: "), "{message}");
    let twice = instead("grains = 1000", "grains = 1000\ngrains = 5");
    assert_eq!(twice, "folder/scene.toml:12: not TOML: duplicate key");
}

#[test]
fn bytes_that_are_not_text_are_refused() {
    let error = SceneFile::parse_bytes(b"version = 1\n\xff", Path::new("a.toml"), &[]);
    assert_eq!(
        error.unwrap_err().to_string(),
        "a.toml:1: byte 12 is not UTF-8 text; a scene is a TOML text file"
    );
}

#[test]
fn deep_nesting_and_long_files_are_refused() {
    for open in ["[", "{a=", "{a.a=", "[[{a.b.c="] {
        let deep = instead("grains = 1000", &format!("grains = {}", open.repeat(100_000)));
        assert!(deep.contains("nest deeper than in any scene"), "{deep}");
    }
    let dotted = instead("grains = 1000", &format!("{}a = 1", "a.".repeat(100_000)));
    assert!(dotted.contains("nest deeper than in any scene"), "{dotted}");
    let header = instead("[camera]", &format!("[{}a]", "a.".repeat(100_000)));
    assert!(header.contains("nest deeper than in any scene"), "{header}");
    let long = format!("{LEAST}#{}", " ".repeat(MAX_SCENE_BYTES));
    assert_eq!(
        refusal(&long, &[]),
        "folder/scene.toml: longer than 1048576 bytes; a scene file refers to large data by `file = ...`"
    );
}

#[test]
fn a_missing_file_can_be_told_from_a_bad_one() {
    let error = SceneFile::read(Path::new("no/such/scene.toml"), &[]).unwrap_err();
    assert!(error.to_string().starts_with("no/such/scene.toml: "), "{error}");
    let SceneError::Read { cause, .. } = error else { panic!("{error}") };
    assert_eq!(cause.kind(), std::io::ErrorKind::NotFound);
}

#[test]
fn versions_are_checked_before_keys() {
    assert_eq!(
        instead("version = 1", "version = 2\nfuture = true"),
        "folder/scene.toml:1: version = 2: this program reads version 1"
    );
    assert_eq!(
        instead("version = 1", ""),
        "folder/scene.toml: version is missing: write `version = 1` at the top"
    );
    assert!(instead("version = 1", "version = \"1\"").contains("version = \"1\": this program"));
}

#[test]
fn missing_keys_are_named_with_their_meaning() {
    assert_eq!(
        instead("at = [0, 0, 0]\n", ""),
        "folder/scene.toml:2: camera.at is missing: The point in the middle of the picture: \
         [x, y, z], lengths."
    );
    assert_eq!(
        instead("radius = \"0.5 mm\"\n", ""),
        "folder/scene.toml:9: snow.0.radius is missing: write radius = \"0.5 mm\""
    );
    assert_eq!(
        instead("[[light]]\nkind = \"sky\"\n", ""),
        "folder/scene.toml: light is missing: the picture would be black; add [[light]] with \
         kind = \"sky\""
    );
    let empty = &LEAST[..LEAST.find("[[object]]").unwrap()];
    assert!(refusal(empty, &[]).contains("the scene is empty"));
}

#[test]
fn tables_and_lists_of_tables_are_told_apart() {
    assert_eq!(
        instead("[[light]]", "[light]"),
        "folder/scene.toml:5: light = [light]: there may be several; write [[light]]"
    );
    assert_eq!(
        instead("[camera]", "[[camera]]"),
        "folder/scene.toml:2: camera = [[camera]]: there is only one; write [camera]"
    );
    assert_eq!(
        instead("version = 1", "version = 1\nfilm = 3"),
        "folder/scene.toml:2: film = 3: write a table, [film]"
    );
}

#[test]
fn values_of_a_wrong_type_say_what_is_expected() {
    assert_eq!(
        instead("grains = 1000", "grains = \"many\""),
        "folder/scene.toml:11: snow.0.grains = \"many\": expected a whole number that is not \
         negative. How many grains lie in the end: a whole number, at least 1, as 1_000_000; \
         deposit (this or `depth`)."
    );
    assert!(
        instead("grains = 1000", "grains = -5")
            .contains("snow.0.grains = -5: expected a whole number that is not negative")
    );
    assert!(instead("\"0.5 mm\"", "\"0.5 parsec\"").contains(
        "folder/scene.toml:12: snow.0.radius = \"0.5 parsec\": unknown unit of length `parsec`; \
         use um, mm, cm, m, km or in"
    ));
    assert!(instead("\"0.5 mm\"", "true").contains("snow.0.radius = true: expected a length"));
    assert!(
        instead("[0, 0, 0]", "[0, 0]")
            .contains("camera.at = [0, 0]: expected an array of length 3")
    );
    assert!(
        instead("\"deposit\"", "\"deposi\"")
            .contains("snow.0.source = \"deposi\": unknown variant")
    );
    let long = instead("\"deposit\"", &format!("\"\\u001b\\n{}\"", "x".repeat(100_000)));
    assert!(long.len() < 1000 && !long.contains(['\u{1b}', '\n']), "{long}");
    assert!(in_snow("seed = 99999999999999999999999").contains("snow.0.seed"));
    assert!(
        in_snow("density = 1979-05-27").contains("snow.0.density = 1979-05-27: expected a number")
    );
}

#[test]
fn materials_are_checked() {
    let with = |keys: &str| {
        let keys = format!("shape = \"sphere\"\n{keys}");
        refusal(&LEAST.replace("shape = \"sphere\"", &keys), &[])
    };
    assert!(with("material = \"wood\"").contains("object.0.material = \"wood\""));
    for (keys, said) in [
        ("roughness = 0.2", "object.0.roughness = 0.2: only material = \"conductor\" or"),
        ("metal = \"gold\"", "object.0.metal = \"gold\": only material = \"conductor\" takes it"),
        ("texture_scale = 2", "object.0.texture_scale = 2: there is no albedo_texture"),
        ("albedo_texture = \"none.png\"", "object.0.albedo_texture = \"none.png\": no such file"),
        ("albedo_texture = \"\"", "must name a file"),
        ("albedo_texture = \"bark.png\"\nalbedo = 1", "object.0.albedo = 1: the picture of"),
        ("albedo_texture = \"bark.png\"\ntexture_scale = 2", "only a plane takes it"),
        (
            "albedo_texture = \"bark.png\"\ninstances = [{ albedo = 1 }]",
            "object.0.instances.0.albedo = 1: the picture of albedo_texture",
        ),
        ("holdout = true\nemission = 1", "an object with emission is black"),
    ] {
        let refused = with(keys);
        assert!(refused.contains(said), "{keys}: {refused}");
    }
    let metal = |keys: &str| with(&format!("material = \"conductor\"\n{keys}"));
    for (keys, said) in [
        ("", "object.0.metal is missing: name the metal"),
        ("metal = \"unobtainium\"", "object.0.metal"),
        ("metal = \"iron\"\nreflectance = 1", "object.0.reflectance = 1: the metal has one"),
        ("reflectance = 1.5", "object.0.reflectance = 1.5: each must be 0 to 1"),
        ("metal = \"iron\"\nroughness = -1", "object.0.roughness = -1: must be 0 (smooth) to 1"),
        ("metal = \"iron\"\nalbedo = 1", "object.0.albedo = 1: only material = \"diffuse\""),
        ("metal = \"iron\"\nior = 2", "object.0.ior = 2: only material = \"dielectric\""),
        ("metal = \"iron\"\nemission = 1", "object.0.material"),
        ("metal = \"iron\"\ninstances = [{ albedo = 1 }]", "only diffuse objects have an albedo"),
    ] {
        let refused = metal(keys);
        assert!(refused.contains(said), "{keys}: {refused}");
    }
    let glass = with("material = \"dielectric\"\nior = 0.5");
    assert!(glass.contains("object.0.ior = 0.5: must be 1 to 4"), "{glass}");
    let bare = refusal(
        &LEAST.replace(
            "shape = \"sphere\"",
            "shape = \"mesh\"\nfile = \"model.obj\"\nalbedo_texture = \"bark.png\"",
        ),
        &[],
    );
    assert!(bare.contains("the mesh has no texture coordinates"), "{bare}");
}

#[test]
fn instances_are_checked() {
    let with = |instances: &str| {
        let keys = format!("shape = \"sphere\"\ninstances = {instances}");
        refusal(&LEAST.replace("shape = \"sphere\"", &keys), &[])
    };
    assert!(with("[]").contains("object.0.instances = []: must hold a place"));
    assert!(with("{}").contains("object.0.instances"));
    assert!(with("[1]").contains("object.0.instances"));
    assert!(with("[{ scale = 0 }]").contains("object.0.instances.0.scale = 0: must be finite"));
    assert!(
        with("[{}, { albedo = 2 }]").contains("object.0.instances.1.albedo = 2: each must be 0")
    );
    assert!(
        with("[{ rotat = [0, 0, 0] }]").contains("did you mean `object.0.instances.0.rotate`?")
    );
    assert!(with("[{ scale = 1e12, translate = [1, 2] }]").contains("object.0.instances.0"));
    let far = "[{ scale = 1e12 }]\nscale = 1e3";
    assert!(with(far).contains("object.0.instances.0.scale = 1e12: the object reaches"));
}

#[test]
fn films_and_cameras_are_checked() {
    let set = |assignment: &str| refusal(LEAST, &[assignment]);
    assert_eq!(
        set("film.width=0"),
        "--set film.width=0: film.width = 0: must be 1 to 65536 pixels"
    );
    assert!(set("film.height=65537").contains("must be 1 to 65536 pixels"));
    assert!(set("film.width=5000000000").contains("expected a whole number"));
    assert!(set("film.samples_per_pixel=0").contains("must be at least 1"));
    assert!(set("camera.vertical_fov=180").contains("above 0 and below 180 degrees"));
    assert!(set("camera.vertical_fov=nan").contains("above 0 and below 180 degrees"));
    assert!(set("camera.from=[0,0,0]").contains("camera.at = [0, 0, 0]: must differ"));
    assert!(set("camera.from=[0,inf,0]").contains("must be finite lengths"));
    assert!(set("camera.up=[0,0,0]").contains("must not be zero"));
    assert!(set("camera.up=[0,-1,-3]").contains("must not point along the line of sight"));
    assert!(set("camera.up=[0,nan,0]").contains("must be finite numbers"));
    assert!(set("camera.ev100=nan").contains("must be -30 to 50"));
    assert!(set("camera.backdrop=-1").contains("must be finite and not negative"));
}

#[test]
fn shots_are_checked() {
    let least = LEAST.replace("[[light]]", "[import]\nfile=\"shot.glb\"\n[[light]]");
    let shot = |assignments: &[&str]| refusal(&least, assignments);
    assert!(shot(&["import.file=other.glb"]).contains("import.file = other.glb: no such file"));
    assert!(shot(&["import.scale=0"]).contains("import.scale = 0: must be finite and not 0"));
    assert!(shot(&["import.camera=eye"]).contains("[camera] is there already"));
    assert!(shot(&["import.scale=1e12"]).contains("the object reaches"));
    let alone = "version = 1\n[import]\nfile = \"shot.glb\"\n[[light]]\nkind = \"sky\"\n";
    let wrong = refusal(alone, &["import.camera=lens"]);
    assert!(wrong.contains("the cameras of the file are \"eye\", \"plan\""), "{wrong}");
    let blind =
        refusal("version = 1\n[[light]]\nkind = \"sky\"\n[[object]]\nshape = \"box\"\n", &[]);
    assert_eq!(
        blind,
        "folder/scene.toml: camera is missing: add [camera] with from = [0, 1, 3], at = [0, 0, 0]"
    );
}

#[test]
fn lenses_and_parallel_rays_are_checked() {
    let all = |assignments: &[&str]| refusal(LEAST, assignments);
    let lens = |assignment: &str| all(&["camera.aperture=2mm", assignment]);
    assert!(all(&["camera.aperture=0"]).contains("must be a finite length above 0"));
    assert!(all(&["camera.f_number=0"]).contains("must be above 0, as 2.8"));
    assert!(lens("camera.f_number=2").contains("camera.aperture says how wide"));
    assert!(lens("camera.sensor_height=24mm").contains("only an f-number needs the sensor"));
    assert!(lens("camera.focus=0").contains("must be a finite length above 0"));
    assert!(lens("camera.focus=[0,1,4]").contains("must lie before the camera"));
    assert!(lens("camera.focus=[0,1]").contains("a point [x, y, z]"));
    assert!(lens("camera.focus=near").contains("unknown unit of length `near`"));
    assert!(lens("camera.blades=2").contains("must be 0 (round) or 3 to 64"));
    assert!(lens("camera.blade_rotation=3").contains("a round opening looks the same"));
    assert!(all(&["camera.focus=1"]).contains("a pinhole has no lens"));
    assert!(all(&["camera.blades=5"]).contains("a pinhole has no lens"));
    assert!(all(&["camera.height=1"]).contains("is for kind = \"orthographic\""));
    let parallel = |assignment: &str| all(&["camera.kind=orthographic", assignment]);
    assert!(all(&["camera.kind=orthographic"]).contains("camera.height is missing: say how much"));
    assert!(parallel("camera.height=-1").contains("must be a finite length above 0"));
    assert!(parallel("camera.vertical_fov=40").contains("neither angle nor lens"));
    assert!(parallel("camera.f_number=2").contains("neither angle nor lens"));
    assert!(all(&["camera.kind=fisheye"]).contains("perspective"));
}

#[test]
fn ice_lights_and_objects_are_checked() {
    let set = |assignment: &str| refusal(LEAST, &[assignment]);
    assert!(set("ice.ior=0.9").contains("ice.ior = 0.9: must be 1 to 4"));
    assert!(set("ice.ior=nan").contains("must be 1 to 4"));
    assert!(set("ice.absorption=-1").contains("must be a finite number of 1/m"));
    assert!(set("ice.absorption=inf").contains("must be a finite number of 1/m"));
    let unknown = set("ice.absorption=picard");
    assert!(unknown.contains("\"picard-2016\", \"warren-brandt-2008\" or a number"), "{unknown}");
    let named = set("ice.impurities={ sot = \"1ppb\" }");
    assert!(named.contains("no impurity is called 'sot'") && named.contains("black-carbon"));
    let negative = set("ice.impurities={ black-carbon = \"-1 ppb\" }");
    assert!(negative.contains("a load of -1 ppb of black-carbon is negative"), "{negative}");
    let counted = set("ice.impurities={ snow-algae = \"5 ppb\" }");
    assert!(counted.contains("cells in a millilitre"), "{counted}");
    let two = format!("{LEAST}[[snow]]\nsource = \"deposit\"\ngrains = 5\nradius = 0.001\n");
    let both = refusal(
        &two,
        &["film.keep=[\"ice-paths\"]", "snow.0.impurities={ black-carbon = \"1ppm\" }"],
    );
    assert!(both.contains("film.keep") && both.contains("ice.impurities"), "{both}");
    assert!(set("snow.impurities={ coal = \"1ppm\" }").contains("snow.0.impurities"));
    assert!(set("snow.wetness=-0.1").contains("must be 0 to 1"));
    assert!(set("ice.pores=oil").contains("water"));
    assert!(set("light.spectrum=c").contains("\"d65\""));
    assert!(set("film.keep=[\"ice\"]").contains("ice-paths"));
    assert!(set("light.radiance=1e40").contains("must be finite and not negative"));
    assert!(set("light.radiance=[1,2]").contains("light.0.radiance = [1,2]: expected a number or"));
    assert!(set("light.radiance=[1,2,3,4]").contains("expected three numbers, found more"));
    assert!(set("object.albedo=[0,0,1.5]").contains("each must be 0 to 1"));
    assert!(set("object.albedo=nan").contains("each must be 0 to 1"));
    assert!(set("object.scale=0").contains("must be finite and not 0"));
    assert!(set("object.scale=[1,1,inf]").contains("must be finite and not 0"));
    assert!(set("object.rotate=[nan,0,0]").contains("must be finite numbers"));
    assert!(set("object.translate=[1e200,0,0]").contains("must be finite lengths"));
}

#[test]
fn references_that_cannot_be_used_say_why() {
    let mesh = |lines: &str| instead("shape = \"sphere\"", &format!("shape = \"mesh\"\n{lines}"));
    assert!(mesh("").contains("object.0.file is missing: name the mesh"));
    assert_eq!(
        mesh("file = \"other.obj\""),
        "folder/scene.toml:9: object.0.file = \"other.obj\": no such file"
    );
    assert!(mesh("file = \"\"").contains("must name a file"));
    assert!(mesh("file = \"a\\u0000b\"").contains("must name a file"));
    assert!(mesh("file = \"model.obj\"\nscale = 1e11").starts_with("accepted"));
    assert!(mesh("file = \"model.obj\"\nscale = 1e12").contains("use a smaller scale"));
    let head = &LEAST[..LEAST.find("source").unwrap()];
    assert_eq!(
        refusal(&format!("{head}source = \"file\"\nfile = \"g.ply\"\n"), &[]),
        "folder/scene.toml:11: snow.0.file = \"g.ply\": a header without end"
    );
}

#[test]
fn overrides_that_fit_nowhere_are_refused() {
    let set = |assignment: &str| refusal(LEAST, &[assignment]);
    assert_eq!(
        set("snow.radus=1"),
        "--set snow.radus=1: unknown key snow.0.radus; did you mean `snow.0.radius`?"
    );
    assert_eq!(
        set("snow.1.radius=1"),
        "--set snow.1.radius=1: the scene has snow.0 to snow.0 only"
    );
    assert_eq!(set("film"), "--set film: write path=value, as snow.0.radius=0.3mm");
    assert_eq!(
        set("film.width.x=1"),
        "--set film.width.x=1: film.width is not written; give the whole of it"
    );
    assert_eq!(set("camera.at.3=1"), "--set camera.at.3=1: camera.at has no item 3");
    assert!(set("=1").contains("unknown key ;"), "{}", set("=1"));
    assert_eq!(set("version+=1"), "--set version+=1: version is not a list; write version=value");
    assert!(set("camera.at.1+=1").ends_with("+= adds to a list; write camera.at+=value"));
    assert!(set("film.keep+=fog").contains("film.keep"), "{}", set("film.keep+=fog"));
    assert!(set("..=1").contains("unknown key"));
    assert!(set("a\nb=1").contains("write it on one line"));
    let two = format!("{LEAST}[[snow]]\nsource = \"deposit\"\n");
    assert_eq!(
        refusal(&two, &["snow.radius=1"]),
        "--set snow.radius=1: the scene has 2 of snow; say which, as snow.0.radius"
    );
    let none = &LEAST[..LEAST.find("[[snow]]").unwrap()];
    assert_eq!(
        refusal(none, &["snow.radius=1"]),
        "--set snow.radius=1: the scene has no [[snow]]; add it to the file"
    );
    assert!(set("snow.0={source=\"deposit\", radus=1}").starts_with("--set snow.0={"));
}
