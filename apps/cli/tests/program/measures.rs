//! `compare` and `measure`.

use crate::{Ended, Workplace};
use serde_json::Value;

fn json(ended: &Ended) -> Value {
    serde_json::from_str(&ended.stdout).unwrap()
}

/// A measured mean lies within 5 standard errors and `slack` of what it should be: false alarms of
/// a right program less than 1 in a million, and the seeds are fixed.
fn assert_expected(figures: &Value, key: &str, slack: f64) {
    let part = |name: &str| figures[key][name].as_f64().unwrap_or_else(|| panic!("{key} {name}"));
    let (mean, error, expected) = (part("mean"), part("standard_error"), part("expected"));
    assert!((mean - expected).abs() < 5.0 * error + slack * expected, "{key}: {figures}");
}

#[test]
fn pictures_are_compared() {
    let place = Workplace::new();
    place.tiny(&["-o", "a.exr", "-o", "a.png", "--spp", "16"]);
    place.tiny(&["-o", "b.exr", "--spp", "16", "--seed", "1"]);
    place.tiny(&["-o", "c.exr", "--spp", "16", "--seed", "1", "--set", "light.radiance=1.5"]);
    let same = json(&place.succeed(&["compare", "a.exr", "a.exr", "--json"]));
    assert_eq!(same["rmse"], 0.0);
    assert_eq!(same["flip"], 0.0);
    assert_eq!(same["z_test"]["largest_z"], 0.0);
    let seeds = place.succeed(&["compare", "a.exr", "b.exr"]).stdout;
    assert!(seeds.contains("relative RMSE") && seeds.contains("chi-square"), "{seeds}");
    let seeds = json(&place.succeed(&["compare", "a.exr", "b.exr", "--json"]));
    assert!(seeds["rmse"].as_f64().unwrap() > 0.0);
    let bright = json(&place.succeed(&["compare", "a.exr", "c.exr", "--json"]));
    assert!(bright["z_test"]["mean_probability"].as_f64().unwrap() < 1e-6, "{bright}");
    let png = place.succeed(&["compare", "a.png", "a.exr"]).stdout;
    assert!(png.contains("variance"), "{png}");

    let code = |arguments: &[&str]| place.run(&[&["compare"], arguments].concat()).code;
    assert_eq!(code(&["a.exr", "b.exr", "--max-rmse", "0"]), Some(1));
    assert_eq!(code(&["a.exr", "b.exr", "--max-rmse", "10", "--max-flip", "1"]), Some(0));
    assert_eq!(code(&["a.exr", "b.exr", "--max-flip", "0"]), Some(1));
    assert_eq!(code(&["a.exr", "c.exr", "--significance", "1e-6"]), Some(1));
    assert_eq!(code(&["a.exr", "a.exr", "--significance", "0.01"]), Some(0));
    assert_eq!(code(&["a.png", "a.exr", "--significance", "0.01"]), Some(65));
}

#[test]
fn a_crystal_slab_obeys_the_identities() {
    let place = Workplace::new();
    let slab = ["measure", "slab", "--lattice", "sc", "--layers", "4", "--paths", "60000"];
    let figures = json(&place.succeed(&[&slab[..], &["--json"]].concat()));
    assert!((figures["tau"].as_f64().unwrap() - core::f64::consts::PI).abs() < 1e-3);
    for key in ["grain_visits", "interface_events", "ice_path", "void_chord"] {
        assert_expected(&figures, key, 2e-4); // grains are rounded to quanta
    }
    let part = |key: &str| figures[key]["mean"].as_f64().unwrap();
    assert!((part("reflectance") + part("transmittance") - 1.0).abs() < 1e-12);
    assert_eq!(figures["trapped_paths"], 0);
    let histogram = figures["visits_histogram"].as_array().unwrap();
    let sum: f64 = histogram.iter().map(|bin| bin.as_f64().unwrap()).sum();
    assert!((sum - 1.0).abs() < 1e-9);
    let threads = |n| place.succeed(&[&slab[..], &["--threads", n, "--quiet"]].concat()).stdout;
    assert_eq!(threads("1"), threads("3"));
    assert!(threads("1").contains("2 tau = 6.28"));
}

#[test]
fn a_deposit_and_its_file_are_measured() {
    let place = Workplace::new();
    let light = ["--paths", "30000", "--json", "--quiet"];
    let fall = ["measure", "slab", "--rule", "stick", "--width", "20mm", "--grains", "1000"];
    let both = ["--from", "both"];
    let figures = json(&place.succeed(&[&fall[..], &light, &both].concat()));
    for key in ["grain_visits", "interface_events", "ice_path", "void_chord"] {
        assert_expected(&figures, key, 2e-4);
    }
    assert_eq!(figures["grains"], 1000);
    let steep = json(&place.succeed(&[&fall[..], &light, &["--incidence", "60"]].concat()));
    assert!(steep["grain_visits"]["expected"].is_null());
    let grains = "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\n\
        property float z\nproperty float radius\nend_header\n-1 0 0 0.5\n0.2 3 4 0.25\n";
    place.file("two.ply", grains);
    let file = ["measure", "slab", "--file", "two.ply", "--period", "2,3"];
    let figures = json(&place.succeed(&[&file[..], &light].concat()));
    let tau = core::f64::consts::PI * (0.25 + 0.0625) / 6.0;
    assert!((figures["tau"].as_f64().unwrap() / tau - 1.0).abs() < 1e-3, "{figures}");
    assert_expected(&figures, "grain_visits", 1e-3);
    let thin = ["measure", "slab", "--file", "two.ply", "--period", "0.1,3"];
    let ended = place.run(&thin);
    assert_eq!(ended.code, Some(2));
    assert!(ended.stderr.contains("--period"), "{}", ended.stderr);
}

#[test]
fn a_cube_lit_all_around_obeys_the_mean_chord_theorem() {
    let place = Workplace::new();
    let cube = ["measure", "cube", "--lit-all-around", "--paths", "60000", "--json"];
    let crystal = ["--lattice", "sc", "--counts", "6,5,4"];
    let figures = json(&place.succeed(&[&cube[..], &crystal].concat()));
    assert_expected(&figures, "grain_visits", 2e-4);
    assert_eq!(figures["grains"], 120);
    assert!(figures["missed_paths"].as_u64().unwrap() > 0);
    let grains = "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\n\
        property float z\nproperty float radius\nend_header\n-1 0 0 0.5\n0.2 3 4 0.25\n";
    place.file("two.ply", grains);
    let figures = json(&place.succeed(&[&cube[..], &["--file", "two.ply"]].concat()));
    assert_expected(&figures, "grain_visits", 1e-3);
}

#[test]
fn a_search_for_light_agrees_with_what_paths_meet() {
    let place = Workplace::new();
    let snow = "version = 1\n[camera]\nfrom = [0.0, 0.3, 0.3]\nat = [0.0, 0.0, 0.0]\nvertical_fov = 4.0\n\
        [[light]]\nkind = \"sun\"\nelevation = 30\n[[object]]\nshape = \"plane\"\n\
        [[snow]]\nsource = \"deposit\"\nradius = \"0.5 mm\"\ndepth = \"4 mm\"\n\
        area = [-0.02, -0.02, 0.02, 0.02]\n[integrator]\ncalibration_paths = 65536\n";
    place.file("snow.toml", snow);
    let measure = ["measure", "search", "snow.toml", "--paths", "65536"];
    let rows = json(&place.succeed(&[&measure[..], &["--json", "--quiet"]].concat()));
    let row = |name: &str| {
        let rows = rows.as_array().unwrap();
        rows.iter().find(|row| row["part"] == name).unwrap_or_else(|| panic!("{name}: {rows:?}"))
    };
    for name in ["all light", "3 grains", "10 grains or more"] {
        let [bias, error] = ["bias", "standard_error"].map(|key| row(name)[key].as_f64().unwrap());
        // The factors are as uncertain as what they are compared with.
        assert!(bias.abs() < 5.0 * 2.0f64.sqrt() * error, "{name}: {bias} {error}");
    }
    assert_eq!(row("all light")["share"], 1.0);
    let threads = |n| place.succeed(&[&measure[..], &["--threads", n, "--quiet"]].concat()).stdout;
    assert_eq!(threads("1"), threads("3"));
    let dark = ["measure", "search", "snowy-teapot", "--set", "snow.grains=100"];
    let refused = place.run(&dark);
    assert_eq!(refused.code, Some(65));
    assert!(refused.stderr.contains("no light is looked for in this scene"), "{}", refused.stderr);
}
