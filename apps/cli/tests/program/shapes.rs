//! Grains of other shapes than spheres.

use crate::Workplace;
use snowgrain_film::Layer;
use snowgrain_formats::image::read_picture;

const SCENE: &str = "version = 1
[film]
width = 24
height = 16
samples_per_pixel = 4
[camera]
from = [0, 0.01, 0.014]
at = [0, 0.002, 0]
vertical_fov = 30
[[light]]
kind = \"sky\"
[[object]]
shape = \"plane\"
albedo = 0.3
[[snow]]
source = \"deposit\"
rule = \"stick\"
radius = \"0.5 mm\"
grains = 300
area = [\"-3 mm\", \"-3 mm\", \"3 mm\", \"3 mm\"]
[[snow.shapes]]
shape = \"hexagonal-plate\"
[[snow.shapes]]
shape = \"mesh\"
file = \"tetrahedron.obj\"
";

const TETRAHEDRON: &str = "v 1 1 1\nv 1 -1 -1\nv -1 1 -1\nv -1 -1 1\n\
    f 1 2 3\nf 1 4 2\nf 1 3 4\nf 2 4 3\n";

fn place() -> Workplace {
    let place = Workplace::new();
    place.file("scene.toml", SCENE);
    place.file("tetrahedron.obj", TETRAHEDRON);
    place
}

#[test]
fn a_scene_of_plates_and_of_a_mesh_of_ones_own_is_white_in_the_furnace() {
    let place = place();
    place.succeed(&["render", "scene.toml", "--furnace", "-o", "white.exr", "--quiet"]);
    let picture = read_picture(&place.path("white.exr")).unwrap();
    for layer in Layer::COLOUR {
        assert!(picture.layer(layer).unwrap().iter().all(|&value| value == 1.0), "{layer:?}");
    }
}

#[test]
fn shaped_grains_come_back_from_their_file_and_give_the_same_picture() {
    let place = place();
    place.succeed(&["deposit", "scene.toml", "-o", "grains.ply", "--quiet"]);
    let snow = SCENE.find("[[snow]]").unwrap();
    let placed = format!("{}[[snow]]\nsource = \"file\"\nfile = \"grains.ply\"\n", &SCENE[..snow]);
    place.file("placed.toml", placed);
    for name in ["scene", "placed"] {
        let (scene, picture) = (format!("{name}.toml"), format!("{name}.exr"));
        place.succeed(&["render", &scene, "-o", &picture, "--quiet"]);
    }
    assert!(place.bytes("scene.exr") == place.bytes("placed.exr"));
}

#[test]
fn a_mesh_that_encloses_nothing_is_refused_with_its_key() {
    let place = place();
    place.file("tetrahedron.obj", &TETRAHEDRON[..TETRAHEDRON.rfind("f 2").unwrap()]);
    let ended = place.run(&["render", "scene.toml", "-o", "picture.png"]);
    assert_eq!(ended.code, Some(65), "{}", ended.stderr);
    assert!(ended.stderr.contains("snow.0.shapes.1.file"), "{}", ended.stderr);
    assert!(ended.stderr.contains("not closed"), "{}", ended.stderr);
    assert!(!place.names().contains(&"picture.png".to_owned()));
}

#[test]
fn the_phase_function_of_a_column_comes_with_its_errors() {
    let place = Workplace::new();
    let common = ["optics", "phase", "--ior", "1.31", "--bins", "18"];
    let column = ["--shape", "hexagonal-column", "--aspect", "2", "--paths", "20000"];
    let run = |threads: &str| {
        place.succeed(&[&common[..], &column, &["--threads", threads]].concat()).stdout
    };
    let text = run("1");
    assert_eq!(text, run("2"), "threads do not show");
    let figure = |name: &str| -> f64 {
        let line = text.lines().find(|line| line.starts_with(&format!("# {name} ")));
        line.unwrap().rsplit(' ').next().unwrap().parse().unwrap()
    };
    assert!((0.6..0.67).contains(&figure("g")) && figure("g_standard_error") < 0.01);
    assert!(figure("B") < 1.31 * 1.31 + 4.0 * figure("B_standard_error"));
    assert!(text.contains("from_deg,to_deg,energy,phase_function,standard_error"));
    let bad = place.run(&["optics", "phase", "--shape", "spheroid", "--aspect", "0"]);
    assert_eq!(bad.code, Some(2), "{}", bad.stderr);
    assert!(bad.stderr.contains("--aspect"), "{}", bad.stderr);
}
