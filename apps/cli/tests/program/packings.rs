//! Snow of a density, packed and filled bodies, and `inspect`.

use crate::Workplace;
use serde_json::Value;

const HEAD: &str = "version = 1\n[camera]\nfrom = [0, 0.1, 0.2]\nat = [0, 0, 0]\n[[light]]\nkind = \
                    \"sky\"\n[[object]]\nshape = \"plane\"\n[[snow]]\nradius = \"1 mm\"\n";

/// A tetrahedron of 4 cm, closed.
const SOLID: &str =
    "v 0 0 0\nv 0.04 0 0\nv 0 0.04 0\nv 0 0 0.04\nf 1 2 3\nf 1 4 2\nf 1 3 4\nf 2 4 3\n";

fn number(figures: &Value, key: &str) -> f64 {
    figures[key].as_f64().unwrap_or_else(|| panic!("{key}: {figures}"))
}

#[test]
fn snow_of_a_density_is_made_inspected_and_read_back() {
    let place = Workplace::new();
    let snow = "source = \"deposit\"\ndensity = 200\ndepth = \"4 cm\"\narea = [-0.05, -0.05, 0.05, 0.05]\n";
    place.file("snow.toml", format!("{HEAD}{snow}"));
    let told = place.succeed(&["deposit", "snow.toml", "-o", "grains.ply"]).stderr;
    assert!(told.contains("density 200 kg/m3 asked for, ") && told.contains("roll on"), "{told}");
    let inspected = place.succeed(&["inspect", "snow.toml", "--json", "--quiet"]).stdout;
    let figures: Value = serde_json::from_str(&inspected).unwrap();
    assert!((number(&figures, "density") / 200.0 - 1.0).abs() < 0.03, "{figures}");
    assert!(number(&figures, "connected_fraction") > 0.99);
    let chords =
        [number(&figures, "mean_air_chord"), number(&figures, "mean_air_chord_by_theorem")];
    assert!((chords[0] / chords[1] - 1.0).abs() < 0.03, "{chords:?}");
    let table =
        place.succeed(&["inspect", "grains.ply", "--plot", "structure.svg", "--quiet"]).stdout;
    assert!(table.contains("specific surface") && table.contains("density by depth"), "{table}");
    let drawn = String::from_utf8(place.bytes("structure.svg")).unwrap();
    assert!(drawn.contains("both in ice"));
}

#[test]
fn bodies_are_filled_and_what_cannot_be_is_refused() {
    let place = Workplace::new();
    place.file("solid.obj", SOLID);
    let fill = "source = \"fill\"\nfile = \"solid.obj\"\ndensity = 300\n";
    place.file("fill.toml", format!("{HEAD}{fill}"));
    let told = place.succeed(&["deposit", "fill.toml", "-o", "fill.ply"]).stderr;
    assert!(told.contains("density 300 kg/m3 asked for, 300"), "{told}");
    let open = SOLID.replace("f 2 4 3\n", "");
    place.file("solid.obj", open);
    let refused = place.run(&["deposit", "fill.toml", "-o", "open.ply"]);
    assert_eq!(refused.code, Some(65));
    assert!(refused.stderr.contains("the mesh is not closed"), "{}", refused.stderr);
    assert!(!place.names().contains(&"open.ply".to_owned()));
    place.file("none.ply", "ply\nformat ascii 1.0\nelement vertex 0\nproperty float x\nproperty float y\nproperty float z\nproperty float radius\nend_header\n");
    assert_eq!(place.run(&["inspect", "none.ply"]).code, Some(65));
    assert_eq!(place.run(&["inspect", "fill.ply", "--period", "1mm,1mm"]).code, Some(2));
}
