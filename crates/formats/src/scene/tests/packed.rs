//! Snow of a density, of measured sizes, and packed in bodies.

use super::{LEAST, read, refusal};
use crate::scene::document::SnowKindName;
use snowgrain_grains::{Body, FillSettings, Radii};
use snowgrain_render::description::{SceneDescription, SnowDescription};

/// A scene whose only snow has these keys.
fn with(snow: &str) -> String {
    let start = LEAST.find("[[snow]]").expect("it has snow");
    format!("{}[[snow]]\n{snow}\n", &LEAST[..start])
}

fn filled(scene: &SceneDescription) -> &FillSettings {
    match &scene.snow[0] {
        SnowDescription::Filled(settings) => settings,
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_density_leaves_the_rule_open_and_radii_may_be_log_normal_or_measured() {
    let snow = "source = \"deposit\"\ndepth = \"2 cm\"\ndensity = 120\nradius = \"0.4 mm\"\n";
    let scene = read(&with(&format!("{snow}spread = 1.3")), &[]).unwrap();
    let SnowDescription::Deposit(settings) = &scene.snow[0] else { panic!("{:?}", scene.snow) };
    assert_eq!((settings.rule, settings.density), (None, Some(120.0)));
    assert_eq!(settings.max_slope_degrees, 90.0);
    assert_eq!(settings.radii, Radii::log_normal(0.4e-3, 1.3).unwrap());
    let measured = "source = \"deposit\"\ngrains = 10\nsizes = \"sizes.txt\"";
    let scene = read(&with(measured), &[]).unwrap();
    let SnowDescription::Deposit(settings) = &scene.snow[0] else { panic!("{:?}", scene.snow) };
    let expected = Radii::measured(&[(0.2e-3, 1.0), (0.4e-3, 3.0)]).unwrap();
    assert_eq!(settings.radii, expected.in_units_of(1.0));
    for (keys, said) in [
        ("radius = 1\nspread = 0.9", "snow.0.spread = 0.9: must be above 1"),
        ("radius = 1\nspread = 1.2\nvariation = 0.1", "snow.0.spread = 1.2: `variation`, `spread`"),
        ("radius = 1\nsizes = \"sizes.txt\"", "snow.0.radius = 1: `sizes` says all radii"),
        ("sizes = \"none.txt\"", "snow.0.sizes = \"none.txt\": no such file"),
    ] {
        let message = refusal(&with(&format!("source = \"deposit\"\ngrains = 1\n{keys}")), &[]);
        assert!(message.contains(said), "{message}");
    }
}

#[test]
fn boxes_and_heights_are_filled() {
    let snow = "radius = \"0.5 mm\"\ndensity = 300\n";
    let block = "source = \"pack\"\nbox = [0, 0, 0, \"10 cm\", 0.05, 0.1]\n";
    let scene = read(&with(&format!("{block}{snow}")), &[]).unwrap();
    let settings = filled(&scene);
    assert!((settings.body.volume() - 5e-4).abs() < 1e-12);
    assert_eq!((settings.pack.density, settings.pack.seed), (300.0, 0));
    let heights = "source = \"fill\"\nfile = \"drift.png\"\nheight = \"4 cm\"\n\
                   area = [0, 0, 0.1, 0.1]\nmask = \"drift.png\"\n";
    let scene = read(&with(&format!("{heights}{snow}")), &[]).unwrap();
    let settings = filled(&scene);
    assert!(matches!(settings.body, Body::Heights(_)) && settings.mask.is_some());
    assert!((settings.body.volume() - 0.5 * 0.04 * 0.01).abs() < 1e-12);
    for (from, to, said) in [
        ("density = 300\n", "", "snow.0.density is missing: say how dense"),
        ("density = 300", "density = 900", "packs have 20 to 750 kg/m3"),
        ("height = \"4 cm\"\n", "", "snow.0.height is missing"),
        ("area = [0, 0, 0.1, 0.1]\n", "", "snow.0.area is missing: say over what the picture"),
        (
            "height",
            "scale = 2\nheight",
            "snow.0.scale = 2: the file is a picture, but this is a key",
        ),
        ("drift.png\"\nheight", "none.png\"\nheight", "snow.0.file = \"none.png\": no such file"),
        ("height = \"4 cm\"", "height = 0", "snow.0.height = 0: must be a finite length"),
    ] {
        let message = refusal(&with(&format!("{heights}{snow}").replace(from, to)), &[]);
        assert!(message.contains(said), "{from}: {message}");
    }
    let mapped = format!("{heights}density_map = \"drift.png\"\n{snow}");
    assert!(filled(&read(&with(&mapped), &[]).unwrap()).density_map.is_some());
    let message =
        refusal(&with(&mapped.replace("density_map = \"drift", "density_map = \"no")), &[]);
    assert!(message.contains("snow.0.density_map = \"no.png\": no such file"), "{message}");
    let flat = block.replace("0.05", "0");
    let message = refusal(&with(&format!("{flat}{snow}")), &[]);
    assert!(message.contains("snow.0.box") && message.contains("y0 < y1"), "{message}");
}

#[test]
fn a_kind_says_what_is_not_written_and_every_key_overrides_it() {
    let deposit = "source = \"deposit\"\ndepth = \"2 cm\"\n";
    let block = "source = \"pack\"\nbox = [0, 0, 0, 0.1, 0.05, 0.1]\n";
    let fill =
        "source = \"fill\"\nfile = \"drift.png\"\nheight = \"4 cm\"\narea = [0, 0, 0.1, 0.1]\n";
    for kind in SnowKindName::ALL {
        let radii = Radii::log_normal(kind.radius_metres(), kind.spread()).unwrap();
        for source in [deposit, block, fill] {
            let snow = format!("{source}kind = \"{}\"", kind.name());
            let scene = read(&with(&snow), &[]).unwrap();
            let said = match &scene.snow[0] {
                SnowDescription::Deposit(settings) => (&settings.radii, settings.density),
                SnowDescription::Filled(fill) => (&fill.pack.radii, Some(fill.pack.density)),
                other => panic!("{other:?}"),
            };
            assert_eq!(said, (&radii, Some(kind.density())), "{kind:?}");
            assert!(scene.shapes[0].is_some(), "{kind:?}");
        }
    }
    let own = "kind = \"fresh\"\nradius = 0.001\nvariation = 0.0005\nrule = \"stick\"\n\
               [[snow.shapes]]\nshape = \"cube\"";
    let scene = read(&with(&format!("{deposit}{own}")), &[]).unwrap();
    let plain = own.replace("kind = \"fresh\"\n", "");
    let without = read(&with(&format!("{deposit}{plain}")), &[]).unwrap();
    let said = |scene: &SceneDescription| format!("{:?} {:?}", scene.snow, scene.shapes);
    assert_eq!(said(&scene), said(&without));
    let sizes = format!("{deposit}kind = \"firn\"\nsizes = \"sizes.txt\"\ndensity = 500");
    let scene = read(&with(&sizes), &[]).unwrap();
    let SnowDescription::Deposit(settings) = &scene.snow[0] else { panic!("{:?}", scene.snow) };
    assert_eq!(settings.density, Some(500.0));
}

#[test]
fn kinds_that_do_not_exist_or_have_no_place_are_refused() {
    let message = refusal(&with("source = \"deposit\"\ngrains = 1\nkind = \"powder\""), &[]);
    assert!(message.contains("snow.0.kind") && message.contains("depth-hoar"), "{message}");
    let lattice = "source = \"lattice\"\nlattice = \"fcc\"\ncounts = [1, 1, 1]\nradius = 1\n";
    let message = refusal(&with(&format!("{lattice}kind = \"firn\"")), &[]);
    assert!(message.contains("snow.0.kind") && message.contains("\"pack\""), "{message}");
    let message =
        refusal(&with("source = \"deposit\"\ngrains = 1\nkind = \"firn\"\nspread = 9"), &[]);
    assert!(message.contains("snow.0.spread = 9: must be above 1"), "{message}");
}

#[test]
fn a_mesh_that_is_not_closed_is_refused_by_its_edge() {
    let snow = "source = \"fill\"\nfile = \"model.obj\"\nradius = \"0.5 mm\"\ndensity = 300";
    let message = refusal(&with(snow), &[]);
    assert!(
        message.contains("snow.0.file = \"model.obj\"") && message.contains("not closed"),
        "{message}"
    );
    let message = refusal(&with(&format!("{snow}\nheight = 1")), &[]);
    assert!(message.contains("the file is a mesh, but this is a key of a picture"), "{message}");
}
