//! Grains of salt, sand and glass.

use super::{LEAST, read, refusal};
use snowgrain_optics::{Absorption, Substance};

const SALT: &str = "material.kind=salt";

#[test]
fn grains_are_of_ice_unless_another_substance_is_named() {
    assert_eq!(read(LEAST, &[]).unwrap().ice.absorption.substance(), Substance::Ice);
    let salt = read(LEAST, &[SALT]).unwrap().ice;
    assert_eq!(salt.absorption, Absorption::Of(Substance::Salt));
    assert!((salt.ior - 1.5441).abs() < 1e-3 && !salt.disperses, "{}", salt.ior);
    let glass = read(LEAST, &["material.kind=glass", "material.dispersion=true"]).unwrap().ice;
    assert_eq!(glass.absorption, Absorption::Of(Substance::SodaLimeGlass));
    assert!(glass.disperses && glass.eta_at(420.0) > glass.eta_at(680.0) + 0.01);
    let wet = read(LEAST, &["material.kind=quartz", "ice.pores=water"]).unwrap().ice;
    assert!((wet.eta() - wet.ior / 1.333).abs() < 1e-12 && wet.ior > 1.54);
    let topaz = ["material.kind=measured", "material.file=topaz.csv"];
    let topaz = read(LEAST, &topaz).unwrap().ice;
    assert!((topaz.ior - 1.6295).abs() < 1e-3 && topaz.absorption.per_metre(780.0) > 1.0);
}

#[test]
fn a_density_is_that_of_the_substance() {
    let pack = |density: &str, kind: &str| {
        let text = LEAST.replace(
            "source = \"deposit\"\ngrains = 1000",
            &format!("source = \"pack\"\nbox = [0, 0, 0, 1, 1, 1]\ndensity = {density}"),
        );
        (text, format!("material.kind={kind}"))
    };
    let solid_fraction = |(text, kind): (String, String)| {
        let scene = read(&text, &[&kind]).unwrap();
        let snowgrain_render::description::SnowDescription::Filled(fill) = &scene.snow[0] else {
            unreachable!("the snow is a pack")
        };
        fill.pack.density / 917.0
    };
    assert!((solid_fraction(pack("1299", "salt")) - 0.6).abs() < 1e-9);
    assert!((solid_fraction(pack("458.5", "ice")) - 0.5).abs() < 1e-12);
    let (text, kind) = pack("2200", "salt");
    assert!(refusal(&text, &[&kind]).contains("at most 2165 kg/m^3 (solid salt)"));
    let (text, kind) = pack("2100", "salt");
    let message = refusal(&text, &[&kind]);
    assert!(message.contains("out of reach") && message.contains("2.361 times"), "{message}");
    let (text, kind) = pack("1000", "measured");
    let message = refusal(&text, &[&kind, "material.file=topaz.csv"]);
    assert!(message.contains("material.density is missing"), "{message}");
}

#[test]
fn what_is_of_ice_alone_and_tables_that_are_not_there_are_refused() {
    for (changes, message) in [
        (&[SALT, "ice.ior=1.5"][..], "ice.ior = 1.5: this is of ice, but the grains are of"),
        (&[SALT, "ice.absorption=2"], "ice.absorption = 2: this is of ice"),
        (&[SALT, "ice.impurities={soot=\"1 ppm\"}"], "ice.impurities"),
        (&[SALT, "snow.0.wetness=0.1"], "snow.0.wetness = 0.1: this is of ice"),
        (&[SALT, "snow.0.kind=fresh"], "snow.0.kind = fresh: this is of ice"),
        (&[SALT, "material.file=topaz.csv"], "material.file = topaz.csv: this is known of salt"),
        (&[SALT, "material.density=2"], "material.density = 2"),
        (&["material.kind=measured"], "material.file is missing: name the table"),
        (&["material.kind=measured", "material.file=x.csv"], "no such file"),
        (&["material.kind=brick"], "material.kind = brick"),
        (&["material.kind=sugar", "material.dispersion=true"], "sugar has one index"),
        (&["material.dispersion=true", "ice.ior=1.32"], "each colour has its measured index"),
        (&["material.dispersion=true", "film.keep=[\"ice-paths\"]"], "keep no wavelengths"),
    ] {
        let refused = refusal(LEAST, changes);
        assert!(refused.contains(message), "{changes:?}: {refused}");
    }
    let measured = ["material.kind=measured", "material.file=topaz.csv", "material.density=-1"];
    assert!(refusal(LEAST, &measured).contains("must be above 0"));
}
