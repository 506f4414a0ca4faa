//! Bad snow and the message that it gets.

use super::{LEAST, in_snow, instead, refusal};

#[test]
fn shapes_that_mean_nothing_are_refused_by_their_key() {
    let shape = |lines: &str| in_snow(&format!("[[snow.shapes]]\n{lines}"));
    assert_eq!(
        shape("shape = \"cube\"\nroundng = 0.5"),
        "folder/scene.toml:15: snow.0.shapes.0.roundng: unknown key; did you mean \
         `snow.0.shapes.0.rounding`?"
    );
    for (lines, key) in [
        ("shape = \"hexagon\"", "snow.0.shapes.0.shape"),
        ("shape = \"cube\"\naspect = 2", "snow.0.shapes.0.aspect"),
        ("shape = \"cube\"\nspread = 2", "snow.0.shapes.0.spread"),
        ("shape = \"cube\"\nrounding = 2", "snow.0.shapes.0.rounding"),
        ("shape = \"spheroid\"\naspect = 0", "snow.0.shapes.0.aspect"),
        ("shape = \"hexagonal-plate\"\naspect = 2", "snow.0.shapes.0.aspect"),
        ("shape = \"hexagonal-column\"\naspect = 0.5", "snow.0.shapes.0.aspect"),
        ("shape = \"random-polyhedron\"\nfaces = 5", "snow.0.shapes.0.faces"),
        ("shape = \"rosette\"\narms = 1", "snow.0.shapes.0.arms"),
        ("shape = \"sphere\"\nfraction = -1", "snow.0.shapes.0.fraction"),
        ("shape = \"cube\"\norientation = \"aligned\"\naxis = [0, 0, 0]", "snow.0.shapes.0.axis"),
        ("shape = \"cube\"\norientation = \"horizontal\"\nspread = 91", "snow.0.shapes.0.spread"),
        ("shape = \"mesh\"", "snow.0.shapes.0.file"),
        // The mesh that tests read is one triangle.
        ("shape = \"mesh\"\nfile = \"crystal.obj\"", "snow.0.shapes.0.file"),
    ] {
        let message = shape(lines);
        assert!(message.starts_with("folder/scene.toml:1"), "{message}");
        assert!(message.contains(key), "{key}: {message}");
    }
}

#[test]
fn radii_are_checked() {
    for radius in ["0", "-0.001", "\"-1 mm\"", "nan", "inf", "1e300", "1e-300"] {
        assert_eq!(
            instead("\"0.5 mm\"", radius),
            format!(
                "folder/scene.toml:12: snow.0.radius = {radius}: must be a finite length above 0, \
                 as \"0.5 mm\""
            )
        );
    }
    for variation in ["\"0.6 mm\"", "-1e-9", "nan"] {
        assert_eq!(
            in_snow(&format!("variation = {variation}")),
            format!(
                "folder/scene.toml:13: snow.0.variation = {variation}: must be 0 to the radius, \
                 0.0005 m"
            )
        );
    }
}

#[test]
fn amounts_of_snow_are_checked() {
    assert_eq!(
        in_snow("depth = 0.1"),
        "folder/scene.toml:13: snow.0.depth = 0.1: both grains and depth say how much snow; keep \
         one of them"
    );
    assert!(instead("grains = 1000\n", "").contains("snow.0.grains is missing: say how much"));
    assert!(instead("= 1000", "= 0").contains("snow.0.grains = 0: must be at least 1"));
    assert!(instead("= 1000", "= 9_000_000_000_000_000_000").contains("more than any machine"));
    assert!(instead("grains = 1000", "depth = nan").contains("snow.0.depth = nan: must be"));
    for density in ["0", "917.5", "-1", "nan", "inf"] {
        assert_eq!(
            in_snow(&format!("density = {density}")),
            format!(
                "folder/scene.toml:13: snow.0.density = {density}: must be above 0 and at most \
                 917 kg/m^3 (solid ice)"
            )
        );
    }
    for slope in ["-1", "90.5", "nan"] {
        assert!(in_snow(&format!("max_slope = {slope}")).contains("must be 0 to 90 degrees"));
    }
    for direction in ["[0, 1, 0]", "[0, 0, 0]", "[1, 0, 0]", "[20, -1, 0]", "[nan, -1, 0]"] {
        let message = in_snow(&format!("direction = {direction}"));
        assert!(message.contains("snow.0.direction = [") && message.contains("downwards"));
    }
    for area in ["[0, 0, 0, 1]", "[0, 1, 1, 0]", "[nan, 0, 1, 1]", "[0, 0, inf, 1]"] {
        assert!(in_snow(&format!("area = {area}")).contains("snow.0.area = ["));
    }
    assert!(
        instead("\"sphere\"", "\"plane\"")
            .contains("snow.0.area is missing: no finite object says where snow falls")
    );
}

#[test]
fn keys_of_one_source_are_refused_on_another() {
    assert_eq!(
        in_snow("lattice = \"fcc\""),
        "folder/scene.toml:13: snow.0.lattice = \"fcc\": not a key of source = \"deposit\" but of \
         \"lattice\"; remove it or change the source (deposit takes: kind, grains, depth, radius, \
         shapes, variation, spread, sizes, wetness, impurities, density, rule, max_slope, direction, area, \
         seed)"
    );
    assert!(
        instead("\"deposit\"", "\"lattice\"")
            .contains("snow.0.grains = 1000: not a key of source = \"lattice\" but of \"deposit\"")
    );
    assert!(instead("\"deposit\"", "\"file\"").contains("not a key of source = \"file\""));
    assert!(
        instead("\"deposit\"", "\"pack\"")
            .contains("snow.0.grains = 1000: not a key of source = \"pack\" but of \"deposit\"")
    );
    assert!(
        instead("\"sphere\"", "\"sphere\"\nfile = \"a.obj\"")
            .contains("object.0.file = \"a.obj\": only a mesh has a file")
    );
}

#[test]
fn lattices_are_checked() {
    let lattice = |lines: &str| {
        let head = &LEAST[..LEAST.find("source").unwrap()];
        refusal(&format!("{head}source = \"lattice\"\nradius = 0.5\n{lines}\n"), &[])
    };
    assert!(lattice("counts = [1, 1, 1]").contains("snow.0.lattice is missing"));
    assert!(lattice("lattice = \"sc\"").contains("snow.0.counts is missing"));
    assert!(lattice("lattice = \"sc\"\ncounts = [0, 1, 1]").contains("each must be at least 1"));
    let most = "lattice = \"fcc\"\ncounts = [4294967295, 4294967295, 4294967295]";
    assert!(lattice(most).contains("at most 1099511627776 are possible"), "{}", lattice(most));
    let both = "lattice = \"sc\"\ncounts = [1, 1, 1]\nspacing = 2\ndensity = 100";
    assert!(lattice(both).contains("snow.0.density = 100: both spacing and density"));
    let spacing = "lattice = \"sc\"\ncounts = [1, 1, 1]\nspacing = 0";
    assert!(lattice(spacing).contains("snow.0.spacing = 0: must be a finite length above 0"));
}
