//! Every failure is one line on standard error that says what and how to mend it, with the exit
//! code of its kind, and leaves no file behind.

use crate::Workplace;

const SCENE: &str = "version = 1\n[camera]\nfrom = [0, 0.1, 0.3]\nat = [0, 0, 0]\n\
    [[light]]\nkind = \"sky\"\n[[object]]\nshape = \"sphere\"\nscale = 0.05\n\
    [[snow]]\nsource = \"deposit\"\ngrains = 100\nradius = \"1 mm\"\n";

/// Runs the program, which must fail with this code and say all of `parts` in one line.
fn refuses(place: &Workplace, arguments: &[&str], code: i32, parts: &[&str]) {
    let before = place.names();
    let ended = place.run(arguments);
    let said = ended.stderr.trim_end();
    assert_eq!(ended.code, Some(code), "{arguments:?}: {said}");
    let errors: Vec<_> = said.lines().filter(|line| line.contains("error")).collect();
    let [error] = errors[..] else { panic!("{arguments:?}: not one line: {said}") };
    assert!(error.starts_with("snowgrain: error: "), "{error}");
    assert_eq!(said.lines().last(), Some(error), "{said}");
    for part in parts {
        assert!(error.contains(part), "{arguments:?}: {error}");
    }
    assert_eq!(place.names(), before, "{arguments:?}");
}

/// Refuses to render this scene file.
fn refuses_scene(scene: &str, code: i32, parts: &[&str]) {
    let place = Workplace::new();
    place.file("a.toml", scene);
    refuses(&place, &["render", "a.toml", "-o", "a.png"], code, parts);
}

#[test]
fn misuse_is_2() {
    let place = Workplace::new();
    for (arguments, parts) in [
        (vec!["render", "snowy-teapot"], vec!["--output"]),
        (vec!["render", "snowy-teapot", "-o", "a.jpg"], vec!["a.jpg", ".png, .exr or .film"]),
        (vec!["render", "snowy-teapot", "-o", "a.png", "--spp", "0"], vec!["--spp", "1.."]),
        (
            vec!["render", "snowy-teapot", "-o", "a.png", "--size", "0x5"],
            vec!["--size", "1024x768"],
        ),
        (vec!["render", "snowy-teapot", "-o", "a.png", "--crop", "5,5,5,9"], vec!["x0 < x1"]),
        (vec!["render", "snowy-teapot", "-o", "a.png", "--crop", "0,0,9999,9"], vec!["512x512"]),
        (vec!["render", "snowy-teapot", "-o", "a.png", "--simd", "mmx"], vec!["mmx", "avx2"]),
        (vec!["render", "snowy-teapot", "-o", "a.png", "--units", "mm"], vec!["--units", "mesh"]),
        (
            vec!["render", "snowy-teapot", "-o", "a.png", "--time-limit", "90"],
            vec!["--time-limit", "90s"],
        ),
        (
            vec!["render", "snowy-teapot", "-o", "a.png", "--display-server", "localhost"],
            vec!["--display-server", "localhost:14158"],
        ),
        (
            vec!["render", "snowy-teapot", "-o", "a.png", "--display-server", "localhost:99999"],
            vec!["--display-server", "65535"],
        ),
        (
            vec!["render", "snowy-teapot", "-o", "a.png", "--noise-target", "0"],
            vec!["--noise-target", "above 0"],
        ),
        (
            vec!["render", "snowy-teapot", "-o", "a.png", "--noise-target", "-0.1"],
            vec!["--noise-target"],
        ),
        (vec!["render", "snowy-teapot", "-o", "a.film", "--denoise"], vec!["--denoise", ".png"]),
        (
            vec!["render", "snowy-teapot", "-o", "a.png", "--denoise-library", "x"],
            vec!["--denoise"],
        ),
        (vec!["rendr"], vec!["rendr"]),
        (vec!["measure", "cube", "--lattice", "sc", "--counts", "2,2,2"], vec!["--lit-all-around"]),
    ] {
        refuses(&place, &arguments, 2, &parts);
    }
}

#[test]
fn missing_input_is_66() {
    let place = Workplace::new();
    refuses(&place, &["render", "nope", "-o", "a.png"], 66, &["nope", "snowy-teapot"]);
    refuses(&place, &["render", "nope.toml", "-o", "a.png"], 66, &["nope.toml"]);
    refuses(&place, &["render", "nope.obj", "-o", "a.png"], 66, &["nope.obj"]);
    refuses(&place, &["compare", "nope.png", "nope.exr"], 66, &["nope.png"]);
    refuses(&place, &["scenes", "nope", "--print"], 66, &["nope"]);
    let mesh = SCENE.replace("shape = \"sphere\"", "shape = \"mesh\"\nfile = \"none.obj\"");
    refuses_scene(&mesh, 66, &["a.toml:", "object.0.file", "none.obj"]);
}

#[test]
fn lights_that_cannot_be_are_65_and_missing_maps_66() {
    let under = |light: &str| SCENE.replace("kind = \"sky\"", light);
    let map = under("kind = \"environment\"\nfile = \"sky.hdr\"");
    refuses_scene(&map, 66, &["a.toml:", "light.0.file", "sky.hdr"]);
    let night = under("kind = \"sun-sky\"\nelevation = -4");
    refuses_scene(&night, 65, &["a.toml:", "light.0.elevation = -4", "above 0"]);
    let flat = under("kind = \"quad\"\ncorner = [0, 1, 0]\nedges = [[1, 0, 0], [2, 0, 0]]");
    refuses_scene(&flat, 65, &["a.toml:", "light.0.edges", "parallel"]);
    let place = Workplace::new();
    place.file("a.toml", &map);
    for (content, parts) in [
        ("#?RADIANCE\n\n-Y 60000 +X 60000\n", vec!["sky.hdr", "60000x60000"]),
        ("#?RADIANCE\n\n-Y 8192 +X 16384\n", vec!["sky.hdr", "does not hold"]),
        ("not a picture", vec!["sky.hdr", "Radiance"]),
    ] {
        place.file("sky.hdr", content);
        refuses(&place, &["render", "a.toml", "-o", "a.png"], 65, &parts);
    }
}

#[test]
fn bad_meshes_are_65() {
    let place = Workplace::new();
    for (name, content, parts) in [
        ("text.obj", "solid cube\nfacet\n", vec!["line 1", "not an OBJ"]),
        ("nan.obj", "v 0 0 0\nv 1 nan 0\nf 1 1 1\n", vec!["line 2", "nan"]),
        ("inf.obj", "v 0 0 inf\nf 1 1 1\n", vec!["line 1", "inf"]),
        ("range.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n", vec!["line 4", "9"]),
        ("empty.obj", "", vec!["no vertex"]),
        ("faceless.obj", "v 0 0 0\n", vec!["no face"]),
        (
            "claim.ply",
            "ply\nformat binary_little_endian 1.0\nelement vertex 4294967295\n\
             property float x\nproperty float y\nproperty float z\nproperty float radius\n\
             end_header\n",
            vec!["claims 4294967295"],
        ),
        (
            "grains.ply",
            "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n\
             property float z\nproperty float radius\nend_header\n0 0 0 1\n",
            vec!["holds grains", "source = \"file\""],
        ),
        ("a.stl", "solid", vec!["not a scene", ".toml"]),
    ] {
        place.file(name, content);
        let parts: Vec<_> = [&[name][..], &parts].concat();
        refuses(&place, &["render", name, "-o", "a.png"], 65, &parts);
    }
    let grains = SCENE.replace(
        "source = \"deposit\"\ngrains = 100\nradius = \"1 mm\"",
        "source = \"file\"\nfile = \"claim.ply\"",
    );
    place.file("a.toml", grains);
    let parts = ["snow.0.file", "claims 4294967295"];
    refuses(&place, &["render", "a.toml", "-o", "a.png"], 65, &parts);
}

#[test]
fn bad_scenes_are_65_with_line_and_key() {
    for (old, new, parts) in [
        ("radius = \"1 mm\"", "radius = 0", vec!["a.toml:13", "snow.0.radius"]),
        ("radius = \"1 mm\"", "radius = -1", vec!["a.toml:13", "snow.0.radius"]),
        ("radius = \"1 mm\"", "radius = nan", vec!["a.toml:13", "snow.0.radius"]),
        (
            "radius = \"1 mm\"",
            "radius = \"1 mm\"\nvariation = \"2 mm\"",
            vec!["a.toml:14", "variation"],
        ),
        ("grains = 100", "grains = 0", vec!["a.toml:12", "snow.0.grains"]),
        ("grains = 100", "grian = 100", vec!["a.toml:12", "grian", "grains"]),
        ("version = 1", "version = ", vec!["a.toml:1"]),
        (
            "version = 1",
            "version = 1\nfilm = { samples_per_pixel = 0 }",
            vec!["a.toml:2", "film.samples_per_pixel"],
        ),
        (
            "version = 1",
            "version = 1\nfilm = { width = 99999999999 }",
            vec!["a.toml:2", "film.width"],
        ),
    ] {
        assert!(SCENE.contains(old));
        refuses_scene(&SCENE.replace(old, new), 65, &parts);
    }
    let deep = format!("{SCENE}x = {}1{}\n", "[".repeat(10_000), "]".repeat(10_000));
    refuses_scene(&deep, 65, &["a.toml:"]);
    refuses_scene("\u{0}", 65, &["a.toml:1"]);
    let place = Workplace::new();
    let set = ["render", "snowy-teapot", "-o", "a.png", "--set"];
    refuses(&place, &[&set[..], &["snow.radus=1mm"]].concat(), 65, &["--set", "radius"]);
    refuses(&place, &[&set[..], &["snow.radius=-1mm"]].concat(), 65, &["snow.0.radius"]);
    let inside = ["render", "snow-cube-sc", "-o", "a.png", "--set", "camera.from=[0.5,0.5,0.5]"];
    refuses(&place, &inside, 65, &["camera.from", "inside a grain"]);
    let density = [&set[..], &["snow.density=900", "--set", "snow.grains=1000"]].concat();
    refuses(&place, &density, 65, &["snowy-teapot", "density"]);
}

#[test]
fn too_much_memory_is_69_before_anything_is_made() {
    let place = Workplace::new();
    let teapot = ["render", "snowy-teapot", "-o", "a.png"];
    let many = [&teapot[..], &["--set", "snow.grains=1000000000000"]].concat();
    refuses(&place, &many, 69, &["TiB", "1000000000000 grains"]);
    let little = [&teapot[..], &["--max-memory", "10MiB"]].concat();
    refuses(&place, &little, 69, &["10.0 MiB", "--max-memory"]);
    let wide = [&teapot[..], &["--size", "65536x65536"]].concat();
    refuses(&place, &wide, 69, &["TiB"]);
    let cells = ["render", "snow-cube", "-o", "a.png", "--set", "snow.counts=[4000000000,4,4]"];
    let ended = place.run(&cells);
    assert!(matches!(ended.code, Some(65 | 69)), "{}", ended.stderr);
    let fall = ["measure", "slab", "--rule", "ray", "--width", "1m", "--grains", "1000000000000"];
    refuses(&place, &fall, 69, &["TiB"]);
}

#[test]
fn outputs_that_cannot_be_made_are_73_before_any_work() {
    let place = Workplace::new();
    let missing = ["render", "snowy-teapot", "-o", "no/where.png"];
    refuses(&place, &missing, 73, &["no/where.png", "no folder"]);
    let stats = ["render", "snowy-teapot", "-o", "a.png", "--json-stats", "no/where.json"];
    refuses(&place, &stats, 73, &["no/where.json"]);
    refuses(&place, &["deposit", "snowy-teapot", "-o", "no/where.ply"], 73, &["no/where.ply"]);
    std::fs::create_dir(place.path("folder.png")).unwrap();
    refuses(&place, &["render", "snowy-teapot", "-o", "folder.png"], 73, &["is a folder"]);
}

/// A folder in which nobody may write stops everyone but the superuser.
#[cfg(unix)]
#[test]
fn a_read_only_folder_is_73() {
    use std::os::unix::fs::PermissionsExt;
    let place = Workplace::new();
    let folder = place.path("folder");
    std::fs::create_dir(&folder).unwrap();
    std::fs::set_permissions(&folder, PermissionsExt::from_mode(0o555)).unwrap();
    if std::fs::write(folder.join("probe"), "").is_ok() {
        return;
    }
    refuses(&place, &["render", "snowy-teapot", "-o", "folder/a.png"], 73, &["folder/a.png"]);
}

/// A limit on the size of files stands for a full disk: the old file stays.
#[cfg(unix)]
#[test]
fn a_full_disk_is_74_and_leaves_the_old_file() {
    let place = Workplace::new();
    place.file("a.exr", "old");
    let script = format!(
        "ulimit -f 1; trap '' XFSZ; exec '{}' render snowy-teapot --quiet {} -o a.exr",
        crate::program().display(),
        crate::TINY.join(" ")
    );
    let output = std::process::Command::new("sh")
        .args(["-c", &script])
        .current_dir(place.path("."))
        .output()
        .unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(74), "{said}");
    assert!(said.starts_with("snowgrain: error: a.exr: writing failed"), "{said}");
    assert_eq!(said.lines().count(), 1, "{said}");
    assert_eq!(place.bytes("a.exr"), b"old");
    assert_eq!(place.names(), ["a.exr"]);
}

#[test]
fn a_closed_white_room_is_69() {
    let scene = "version = 1\n[film]\nwidth = 8\nheight = 8\nsamples_per_pixel = 1\n\
        [camera]\nfrom = [0, 0, 0.5]\nat = [0, 0, -1]\n[[light]]\nkind = \"sky\"\n\
        [[object]]\nshape = \"box\"\nalbedo = 1.0\n";
    refuses_scene(scene, 69, &["enclosed", "albedo"]);
}
