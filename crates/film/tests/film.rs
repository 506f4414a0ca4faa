//! Films add exactly: any order, any split, the same bytes; and nothing out of range goes in.

#![allow(clippy::unwrap_used, reason = "a failing test may panic")]

use proptest::prelude::*;
use snowgrain_film::{
    Film, FilmError, FilmIdentity, FilmTile, Kept, Layer, LightLayerNames, Picture, PixelRect,
    PixelSums, Refusal, Sample, SampleFault,
};

const IDENTITY: FilmIdentity = FilmIdentity { scene_hash: [3; 32], seed: 11 };
const CROP: PixelRect = PixelRect::new(1, 2, 6, 5);

fn film() -> Film {
    Film::new(8, 6, CROP, IDENTITY).unwrap()
}

/// A film that keeps two layers of light.
fn layered() -> Film {
    let names = ["sun", "sky"].map(str::to_owned).to_vec();
    film().keeping_light_layers(LightLayerNames::new(names, vec![0]).unwrap()).unwrap()
}

fn layered_tile(rect: PixelRect) -> FilmTile {
    FilmTile::keeping(rect, Kept { light_layers: 2, ..Kept::default() }).unwrap()
}

/// The radiance of a sample in two layers whose sum rounds.
fn layers(sample: &Sample) -> [[f32; 3]; 2] {
    let sun = sample.radiance.map(|x| x / 3.0);
    [sun, std::array::from_fn(|c| sample.radiance[c] - sun[c])]
}

fn one_pixel() -> FilmTile {
    FilmTile::new(PixelRect::new(0, 0, 1, 1)).unwrap()
}

fn bright(radiance: f32) -> Sample {
    Sample { radiance: [radiance; 3], ..Sample::default() }
}

fn any_sample() -> impl Strategy<Value = Sample> {
    let radiance = prop_oneof![0.0..2.0f32, -2.0..0.0f32, 0.0..1e9f32, -1e-30..1e-30f32];
    (
        prop::array::uniform3(radiance),
        0.0..=1.0f32,
        prop::array::uniform3(0.0..=1.0f32),
        prop::array::uniform3(-1.0..=1.0f32),
        prop_oneof![Just(f32::INFINITY), 0.0..1e6f32],
    )
        .prop_map(|(radiance, alpha, albedo, normal, depth)| Sample {
            radiance,
            alpha,
            albedo,
            normal,
            depth,
        })
}

/// Values of every size that a film takes, the edges of its range, and some beyond.
fn extreme() -> impl Strategy<Value = f32> {
    let edges = [0.0, -0.0, 1.0, 256.0, 2.8e14, f32::INFINITY, f32::NAN, -1.0, f32::MIN_POSITIVE];
    let small = (0u32..0x5780_0000).prop_map(f32::from_bits);
    prop_oneof![4 => small, 2 => prop::sample::select(edges.to_vec()), 1 => any::<f32>(), 4 => 0.0..1.0f32]
}

fn extreme_sample() -> impl Strategy<Value = Sample> {
    let guide =
        || prop_oneof![8 => -1.0..=1.0f32, 3 => Just(0.0f32), 1 => -1e-6..1e-6f32, 1 => extreme()];
    let positive = || guide().prop_map(f32::abs);
    (
        prop_oneof![extreme().prop_map(|x| [x; 3]), prop::array::uniform3(extreme())],
        prop_oneof![4 => Just(1.0f32), 4 => Just(0.0f32), 1 => extreme()],
        prop_oneof![Just([0.0f32; 3]), prop::array::uniform3(positive())],
        prop_oneof![Just([0.0f32; 3]), prop::array::uniform3(guide())],
        prop_oneof![Just(f32::INFINITY), 0.0..1e6f32, extreme()],
    )
        .prop_map(|(radiance, alpha, albedo, normal, depth)| Sample {
            radiance,
            alpha,
            albedo,
            normal,
            depth,
        })
}

/// Sums that are empty, that may be near the edges of their ranges, or that are in between.
fn any_sums() -> impl Strategy<Value = PixelSums> {
    let byte = prop_oneof![4 => Just(0xffu8), 4 => Just(0u8), 1 => Just(0x7fu8), 1 => any::<u8>()];
    prop_oneof![
        Just(PixelSums::default()),
        prop::collection::vec(byte, PixelSums::BYTES)
            .prop_map(|bytes| PixelSums::from_le_bytes(&bytes.try_into().unwrap())),
        prop::collection::vec(any::<u64>(), PixelSums::BYTES / 8).prop_map(|words| {
            let bytes: Vec<u8> = words.iter().flat_map(|word| (word >> 1).to_le_bytes()).collect();
            PixelSums::from_le_bytes(&bytes.try_into().unwrap())
        }),
    ]
}

/// Samples 0..4 of every pixel of the crop.
fn any_samples() -> impl Strategy<Value = Vec<[Sample; 4]>> {
    prop::collection::vec(prop::array::uniform4(any_sample()), CROP.area() as usize)
}

/// A film of the samples with these indices, filled through tiles of this side.
fn rendered(samples: &[[Sample; 4]], indices: &[usize], side: u32, backwards: bool) -> Film {
    let mut film = layered();
    let mut rects: Vec<PixelRect> = CROP.tiles(side).collect();
    if backwards {
        rects.reverse();
    }
    for rect in rects {
        let mut tile = layered_tile(rect);
        for at in 0..rect.area() as usize {
            let (x, y) = rect.pixel(at);
            for &index in indices {
                let sample = &samples[CROP.index(x, y).unwrap()][index];
                tile.add(x, y, sample).unwrap();
                tile.add_light_layers(x, y, sample.radiance, &layers(sample)).unwrap();
            }
        }
        film.merge_tile(&tile).unwrap();
    }
    for &index in indices {
        film.record_samples(index as u64..index as u64 + 1).unwrap();
    }
    film
}

/// The film of all samples, filled in place; the last sample of every pixel through other tiles.
fn in_place(samples: &[[Sample; 4]], side: u32) -> Film {
    let mut film = layered();
    let rects: Vec<PixelRect> = CROP.tiles(side).collect();
    for (tile, rect) in film.tiles_mut(side).iter_mut().zip(rects) {
        assert_eq!(tile.rect(), rect);
        let mut last = layered_tile(rect);
        for at in 0..rect.area() as usize {
            let (x, y) = rect.pixel(at);
            let [first @ .., fourth] = &samples[CROP.index(x, y).unwrap()];
            for sample in first {
                tile.add(x, y, sample).unwrap();
                tile.add_light_layers(x, y, sample.radiance, &layers(sample)).unwrap();
            }
            last.add(x, y, fourth).unwrap();
            last.add_light_layers(x, y, fourth.radiance, &layers(fourth)).unwrap();
        }
        tile.merge(&last).unwrap();
        assert_eq!(tile.pixel(rect.x0, rect.y0).unwrap().samples(), 4);
        assert!(matches!(tile.add(9, 9, &samples[0][0]), Err(FilmError::OutsideTile { .. })));
    }
    film.record_samples(0..4).unwrap();
    film
}

proptest! {
    #[test]
    fn tiles_orders_and_splits_give_the_same_film(samples in any_samples(), side in 1u32..6) {
        let whole = rendered(&samples, &[0, 1, 2, 3], 64, false);
        prop_assert_eq!(&rendered(&samples, &[2, 0, 3, 1], side, true), &whole);
        prop_assert_eq!(&in_place(&samples, side), &whole);
        let light = whole.light_layers().unwrap().sums();
        for (sums, layers) in whole.pixels().iter().zip(light.chunks_exact(2)) {
            let total = [0, 1, 2].map(|c: usize| layers[0][c] + layers[1][c]);
            let radiance = total.iter().flat_map(|sum| sum.to_le_bytes()).collect::<Vec<u8>>();
            prop_assert_eq!(&sums.to_le_bytes()[..48], &radiance, "layers are the whole, exactly");
        }
        let parts = [vec![0], vec![3, 1], vec![2]].map(|i| rendered(&samples, &i, side, false));
        for order in [[0, 1, 2], [2, 1, 0], [1, 2, 0]] {
            let mut merged = layered();
            order.iter().for_each(|&part: &usize| merged.merge(&parts[part]).unwrap());
            prop_assert_eq!(&merged, &whole);
        }
    }

    #[test]
    fn a_sample_adds_what_its_own_sums_add(
        start in any_sums(),
        samples in prop::collection::vec(extreme_sample(), 1..8),
    ) {
        let mut sums = start;
        for sample in samples {
            let before = sums;
            let added = PixelSums::from_sample(&sample);
            match sums.add_sample(&sample) {
                Ok(()) => prop_assert_eq!(before.checked_add(&added.unwrap()), Some(sums)),
                Err(Refusal::Overflow) => {
                    prop_assert_eq!(before.checked_add(&added.unwrap()), None);
                    prop_assert_eq!(sums, before);
                }
                Err(Refusal::Sample(fault)) => {
                    // Compared as text, where not-a-number equals itself.
                    prop_assert_eq!(added.unwrap_err().to_string(), fault.to_string());
                    prop_assert_eq!(sums, before);
                }
            }
        }
    }

    #[test]
    fn a_merge_that_fails_changes_nothing(tops in prop::collection::vec(any::<bool>(), 15)) {
        let rect = CROP;
        let mut tile = FilmTile::new(rect).unwrap();
        for (index, &top) in tops.iter().enumerate() {
            let (x, y) = rect.pixel(index);
            tile.add(x, y, &bright(if top { 2.8e14 } else { 0.25 })).unwrap();
        }
        let mut film = film();
        film.merge_tile(&tile).unwrap();
        let kept = film.clone();
        match tops.iter().position(|&top| top) {
            None => prop_assert!(film.merge_tile(&tile).is_ok()),
            Some(index) => {
                let (x, y) = rect.pixel(index);
                prop_assert_eq!(film.merge_tile(&tile), Err(FilmError::Overflow { x, y }));
                prop_assert_eq!(&film, &kept);
                let mut whole = film.tiles_mut(64);
                prop_assert_eq!(whole[0].merge(&tile), Err(FilmError::Overflow { x, y }));
                drop(whole);
                prop_assert_eq!(&film, &kept);
            }
        }
    }

    #[test]
    fn sums_survive_the_trip_through_bytes(sample in any_sample(), other in any_sample()) {
        let sums = PixelSums::from_sample(&sample).unwrap();
        let sums = sums.checked_add(&PixelSums::from_sample(&other).unwrap()).unwrap();
        prop_assert_eq!(PixelSums::from_le_bytes(&sums.to_le_bytes()), sums);
    }

    #[test]
    fn variance_is_that_of_the_textbook(values in prop::collection::vec(0.0..100.0f32, 2..40)) {
        let mut tile = one_pixel();
        values.iter().for_each(|&v| tile.add(0, 0, &bright(v)).unwrap());
        let n = values.len() as f64;
        let mean = values.iter().map(|&v| f64::from(v)).sum::<f64>() / n;
        let squares: f64 = values.iter().map(|&v| (f64::from(v) - mean) * (f64::from(v) - mean)).sum();
        let expected = squares / (n * (n - 1.0));
        let [variance, ..] = tile.pixels()[0].variance_of_mean();
        prop_assert!((variance - expected).abs() <= 1e-12 * expected.max(1e-6));
        let [radiance, ..] = tile.pixels()[0].mean_radiance();
        prop_assert!((radiance - mean).abs() <= 1e-14 * mean);
    }

    #[test]
    fn any_bytes_are_sums_that_develop(bytes in prop::collection::vec(any::<u8>(), PixelSums::BYTES)) {
        let sums = PixelSums::from_le_bytes(&bytes.try_into().unwrap());
        let _ = (sums.mean_radiance(), sums.variance_of_mean(), sums.mean_depth());
        let _ = sums.checked_add(&sums);
    }
}

#[test]
fn a_pixel_takes_the_memory_that_is_stated() {
    assert_eq!((size_of::<PixelSums>(), PixelSums::BYTES), (208, 208));
}

#[test]
fn a_million_samples_of_the_sun_fit() {
    let mut sums = PixelSums::from_sample(&bright(1e9)).unwrap();
    for _ in 0..20 {
        sums = sums.checked_add(&sums).unwrap(); // 2^20 samples
    }
    assert_eq!(sums.mean_radiance(), [1e9; 3]);
    assert_eq!(sums.variance_of_mean(), [0.0; 3]);
}

#[test]
fn beyond_the_range_is_an_error_and_the_tile_keeps_its_samples() {
    let mut tile = one_pixel();
    let largest = bright(2.8e14);
    tile.add(0, 0, &largest).unwrap();
    let before = tile.clone();
    assert_eq!(tile.add(0, 0, &largest), Err(FilmError::Overflow { x: 0, y: 0 }));
    assert_eq!(tile, before);
    let mut film = Film::new(1, 1, PixelRect::new(0, 0, 1, 1), IDENTITY).unwrap();
    film.merge_tile(&tile).unwrap();
    let kept = film.clone();
    assert_eq!(film.merge_tile(&tile), Err(FilmError::Overflow { x: 0, y: 0 }));
    assert_eq!(film, kept);
}

#[test]
fn samples_that_no_light_has_are_refused() {
    for radiance in [f32::NAN, f32::INFINITY, -3e14, 3e14, f32::MAX] {
        let error = one_pixel().add(0, 0, &bright(radiance)).unwrap_err();
        let FilmError::BadSample { fault: SampleFault::Radiance(value), .. } = error else {
            panic!("{error}");
        };
        assert_eq!(value.to_bits(), radiance.to_bits());
    }
    let fine = Sample::default();
    let faulty = [
        Sample { alpha: 1.5, ..fine },
        Sample { alpha: f32::NAN, ..fine },
        Sample { albedo: [0.0, -0.1, 0.0], ..fine },
        Sample { normal: [f32::NAN, 0.0, 0.0], ..fine },
        Sample { normal: [0.0, 0.0, f32::NEG_INFINITY], ..fine },
        Sample { depth: -1.0, ..fine },
        Sample { depth: f32::NAN, ..fine },
        Sample { depth: f32::NEG_INFINITY, ..fine },
    ];
    for sample in faulty {
        assert!(one_pixel().add(0, 0, &sample).is_err(), "{sample:?}");
    }
    assert!(one_pixel().add(0, 0, &Sample { radiance: [-0.0; 3], ..fine }).is_ok());
    assert!(matches!(one_pixel().add(1, 0, &fine), Err(FilmError::OutsideTile { .. })));
}

#[test]
fn only_films_of_one_picture_and_of_different_samples_merge() {
    let mut ours = film();
    ours.record_samples(0..4).unwrap();
    let mut twice = film();
    twice.record_samples(3..5).unwrap();
    let twice = ours.merge(&twice);
    assert_eq!(twice, Err(FilmError::SamplesTwice { start: 3, end: 4 }));
    let identities =
        [FilmIdentity { seed: 12, ..IDENTITY }, FilmIdentity { scene_hash: [4; 32], ..IDENTITY }];
    for identity in identities {
        let error = ours.merge(&Film::new(8, 6, CROP, identity).unwrap());
        assert!(matches!(error, Err(FilmError::FilmsDiffer { .. })));
    }
    let wider = Film::new(9, 6, CROP, IDENTITY).unwrap();
    assert!(matches!(ours.merge(&wider), Err(FilmError::FilmsDiffer { what: "size", .. })));
    let cropped = Film::new(8, 6, PixelRect::new(0, 0, 8, 6), IDENTITY).unwrap();
    assert!(matches!(ours.merge(&cropped), Err(FilmError::FilmsDiffer { what: "crop", .. })));
}

#[test]
fn layers_that_leave_their_range_or_are_others_change_nothing() {
    let mut film = layered();
    let mut tile = layered_tile(CROP);
    let bright = bright(2.8e14);
    for _ in 0..2 {
        // The layers alone: their sum stays small while each grows.
        tile.add_light_layers(2, 3, [0.0; 3], &[bright.radiance, [-2.8e14; 3]]).unwrap();
    }
    for _ in 0..14 {
        film.merge_tile(&tile).unwrap();
        let mut copy = layered();
        copy.merge(&film).unwrap();
        assert_eq!(copy, film);
        let doubled = film.clone();
        if film.merge(&doubled).is_err() {
            assert_eq!(film.merge(&doubled), Err(FilmError::Overflow { x: 2, y: 3 }));
            assert_eq!(film, doubled);
            let error = self::film().merge(&film).unwrap_err().to_string();
            assert!(error.contains("layers of light (not kept and sun, sky"), "{error}");
            return;
        }
    }
    panic!("the sums never left their range");
}

#[test]
fn crops_and_sizes_are_checked_before_memory_is_taken() {
    for crop in [PixelRect::new(0, 0, 0, 6), PixelRect::new(0, 0, 9, 6), PixelRect::new(5, 5, 1, 6)]
    {
        assert!(matches!(Film::new(8, 6, crop, IDENTITY), Err(FilmError::BadCrop { .. })));
    }
    let huge = PixelRect::new(0, 0, u32::MAX, u32::MAX);
    let error = Film::new(u32::MAX, u32::MAX, huge, IDENTITY);
    assert!(matches!(error, Err(FilmError::TooLarge { .. })));
    let outside = FilmTile::new(PixelRect::new(0, 0, 2, 2)).unwrap();
    assert!(matches!(film().merge_tile(&outside), Err(FilmError::TileOutsideFilm { .. })));
}

#[test]
fn layers_are_the_means_of_the_samples() {
    let whole = PixelRect::new(0, 0, 2, 1);
    let mut film = Film::new(2, 1, whole, IDENTITY).unwrap();
    let mut tile = FilmTile::new(whole).unwrap();
    let hit = Sample {
        radiance: [1.0, 0.7, 0.0],
        alpha: 1.0,
        albedo: [0.5, 0.25, 1.0],
        normal: [0.0, 1.0, -0.5],
        depth: 3.0,
    };
    tile.add(0, 0, &hit).unwrap();
    tile.add(0, 0, &Sample { radiance: [0.0, 0.7, 0.0], ..Sample::default() }).unwrap();
    film.merge_tile(&tile).unwrap();
    film.record_samples(0..2).unwrap();
    film.vertical_fov_degrees = Some(35.0);
    let picture = Picture::from_film(&film).unwrap();
    assert_eq!((picture.vertical_fov_degrees, picture.light_layers.len()), (Some(35.0), 0));
    let first = |layer| picture.layer(layer).unwrap()[0];
    assert_eq!(Layer::COLOUR.map(first), [0.5, 0.7, 0.0]);
    assert_eq!(Layer::VARIANCE.map(first), [0.25, 0.0, 0.0]);
    assert_eq!([Layer::AlbedoR, Layer::AlbedoG, Layer::AlbedoB].map(first), [0.25, 0.125, 0.5]);
    assert_eq!([Layer::NormalX, Layer::NormalY, Layer::NormalZ].map(first), [0.0, 0.5, -0.25]);
    assert_eq!([Layer::A, Layer::Depth, Layer::SampleCount].map(first), [0.5, 3.0, 2.0]);
    let empty = |layer| picture.layer(layer).unwrap()[1];
    assert_eq!([Layer::R, Layer::A, Layer::SampleCount].map(empty), [0.0; 3]);
    assert_eq!([Layer::Depth, Layer::VarianceR].map(empty), [f32::INFINITY; 2]);
    assert_eq!(picture.provenance.unwrap().samples_per_pixel, 2);
}
