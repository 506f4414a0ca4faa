//! Hashes of grains and pixels that were committed: a change of them is a change of every picture.
//!
//! Where such a change is meant, `SNOWGRAIN_RENEW_GOLDEN=1 cargo test --release -p snowgrain-tests
//! --test same_bits golden` writes `data/golden/hashes.txt` anew; say in the commit why.

use super::{SCENES, build, data, description, film};
use snowgrain_film::Film;
use snowgrain_grains::GrainField;
use std::fmt::Write as _;

const HASHES: &str = "hashes.txt";

/// The grains in the order in which they are stored.
fn grain_hash(field: &GrainField) -> String {
    let mut hasher = blake3::Hasher::new();
    for grain in field.quantised() {
        for coordinate in grain.center {
            hasher.update(&coordinate.to_le_bytes());
        }
        hasher.update(&grain.radius.to_le_bytes());
    }
    short(&hasher)
}

/// The sums of all pixels, whatever the scene and its file are called.
fn pixel_hash(film: &Film) -> String {
    let mut hasher = blake3::Hasher::new();
    for pixel in film.pixels() {
        hasher.update(&pixel.to_le_bytes());
    }
    short(&hasher)
}

/// The first 128 bits.
fn short(hasher: &blake3::Hasher) -> String {
    hasher.finalize().to_hex()[..32].to_string()
}

#[test]
fn golden_scenes_keep_their_grains_and_pixels() {
    let mut now = String::from("# scene, grains, pixels: see tests/README.md\n");
    for name in SCENES {
        let description = description(name);
        let (field, _) = snowgrain_render::deposit(&description, &mut |_| ()).unwrap();
        let pixels = pixel_hash(&film(&build(&description)));
        writeln!(now, "{name} {} {pixels}", grain_hash(&field)).unwrap();
    }
    let path = data(HASHES);
    if std::env::var_os("SNOWGRAIN_RENEW_GOLDEN").is_some_and(|value| value == "1") {
        std::fs::write(&path, &now).unwrap();
        return;
    }
    let committed = std::fs::read_to_string(&path).unwrap();
    let changed: Vec<_> =
        committed.lines().zip(now.lines()).filter(|(old, new)| old != new).collect();
    for (old, new) in &changed {
        println!("changed (scene, grains, pixels):\n  {old}\n  {new}");
    }
    assert!(committed == now, "{} scenes changed, see above", changed.len());
}
