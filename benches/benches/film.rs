//! `cargo bench -p snowgrain-benches --bench film [-- FILTER]`: what a sample and a merge cost the
//! film, CPU nanoseconds of one core.

use snowgrain_benches::best_of;
use snowgrain_film::develop::Development;
use snowgrain_film::{Film, FilmIdentity, FilmTile, Picture, PixelRect, Sample, develop};
use std::hint::black_box;

const TILE: u32 = 16;
const SIDE: u32 = 512;
const ROUNDS: u32 = 2000;

fn main() {
    let filter = std::env::args().skip(1).find(|argument| !argument.starts_with('-'));
    let wanted = |name: &str| filter.as_ref().is_none_or(|filter| name.contains(filter.as_str()));
    for (name, of) in SAMPLES {
        if wanted(name) {
            add(name, of);
        }
    }
    if wanted("picture") {
        picture();
    }
}

/// A kind of samples: its name, and the sample with this index.
type Kind = (&'static str, fn(u32) -> Sample);

const SAMPLES: [Kind; 5] = [
    ("missed, black", |_| Sample::default()),
    ("white snow, dark", |_| hit([0.0; 3])),
    ("white snow, lit", |_| hit([1.0; 3])),
    ("white snow, either", |i| hit([(i.wrapping_mul(0x9E37_79B9) >> 31) as f32; 3])),
    ("coloured", |i| hit([0.7, 0.4, 0.01].map(|x: f32| x * (1.0 + i as f32 * 1e-3)))),
];

fn hit(radiance: [f32; 3]) -> Sample {
    let normal = [0.36, 0.48, -0.8];
    Sample { radiance, alpha: 1.0, albedo: [1.0; 3], normal, depth: 203.7 }
}

fn add(name: &str, of: fn(u32) -> Sample) {
    let rect = PixelRect::new(0, 0, TILE, TILE);
    let mut tile = FilmTile::new(rect).expect("a tile fits");
    let samples: Vec<Sample> = (0..1024).map(of).collect();
    let (seconds, ()) = best_of(5, || {
        for round in 0..ROUNDS {
            for index in 0..TILE * TILE {
                let sample = &samples[((round + index) & 1023) as usize];
                tile.add(index % TILE, index / TILE, black_box(sample)).expect("legal samples");
            }
        }
    });
    let adds = f64::from(ROUNDS * TILE * TILE);
    println!("add, {name:<20} {:8.1} ns a sample", seconds / adds * 1e9);
}

/// Merging, reading off and developing a picture of 512 x 512 pixels.
fn picture() {
    let whole = PixelRect::new(0, 0, SIDE, SIDE);
    let identity = FilmIdentity { scene_hash: [0; 32], seed: 0 };
    let tiles: Vec<FilmTile> = whole
        .tiles(TILE)
        .map(|rect| {
            let mut tile = FilmTile::new(rect).expect("a tile fits");
            for index in 0..rect.area() as usize {
                let (x, y) = rect.pixel(index);
                tile.add(x, y, &hit([(index & 1) as f32; 3])).expect("legal samples");
                tile.add(x, y, &hit([1.0; 3])).expect("legal samples");
            }
            tile
        })
        .collect();
    let pixels = f64::from(SIDE * SIDE);
    let mut film = Film::new(SIDE, SIDE, whole, identity).expect("a film fits");
    let (seconds, ()) = best_of(5, || {
        for tile in &tiles {
            film.merge_tile(tile).expect("few samples");
        }
    });
    println!("merge of tiles            {:8.1} ns a pixel", seconds / pixels * 1e9);
    let (seconds, picture) = best_of(3, || Picture::from_film(&film).expect("it fits"));
    println!("all layers                {:8.1} ns a pixel", seconds / pixels * 1e9);
    let (seconds, _) =
        best_of(3, || develop::to_8_bit(&picture, &Development::default()).expect("it has colour"));
    println!("8 bits                    {:8.1} ns a pixel", seconds / pixels * 1e9);
}
