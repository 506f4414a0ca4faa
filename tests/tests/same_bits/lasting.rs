//! Films of parts, and films that are taken while a render goes on.

use super::{build, bytes, cut, description, part, shuffled, whole};
use snowgrain_accel::SimdLevel;
use snowgrain_film::Film;
use snowgrain_math::sampler::split_mix;
use snowgrain_render::{RenderControl, RenderSettings, render_with};
use std::collections::{BTreeMap, HashMap};
use std::ops::Range;
use std::sync::atomic::{AtomicBool, AtomicU64};

/// Fifty random partitions of the samples, each merged in a random order.
#[test]
fn any_partition_of_the_samples_merges_in_any_order_to_the_same_bytes() {
    const SAMPLES: u64 = 12;
    let scene = build(&description("lattice"));
    let level = SimdLevel::detect();
    let expected = bytes(&part(&scene, 0..SAMPLES, whole(&scene), level));
    let mut films: HashMap<Range<u64>, Film> = HashMap::new();
    for trial in 0..50u64 {
        let word = split_mix(trial);
        let mut ends: Vec<u64> = (1..SAMPLES).filter(|end| word >> end & 1 == 1).collect();
        ends.push(SAMPLES);
        let starts = [0].into_iter().chain(ends.iter().copied());
        let ranges: Vec<_> = starts.zip(ends.clone()).map(|(start, end)| start..end).collect();
        let mut merged: Option<Film> = None;
        for index in shuffled(ranges.len(), word) {
            let range = ranges[index].clone();
            let film = films
                .entry(range.clone())
                .or_insert_with(|| part(&scene, range, whole(&scene), level));
            match &mut merged {
                None => merged = Some(film.clone()),
                Some(merged) => merged.merge(film).unwrap(),
            }
        }
        assert!(bytes(&merged.unwrap()) == expected, "{ranges:?}");
    }
}

#[test]
fn crops_put_together_are_the_film_of_the_whole() {
    for name in ["sunlit", "layers"] {
        let scene = build(&description(name));
        let level = SimdLevel::detect();
        let mut crops = Vec::new();
        cut(whole(&scene), 23, &mut crops);
        let films: Vec<_> = shuffled(crops.len(), 5)
            .into_iter()
            .map(|index| part(&scene, 3..5, crops[index], level))
            .collect();
        let expected = part(&scene, 3..5, whole(&scene), level);
        assert!(bytes(&Film::assembled(&films).unwrap()) == bytes(&expected), "{name}");
        assert!(Film::assembled(&films[1..]).is_err(), "{name}: with a gap");
    }
}

/// Snapshots are taken as fast as one thread can, while others render.
#[test]
fn a_snapshot_is_the_film_of_the_samples_that_it_says() {
    for name in ["buried", "sunlit"] {
        let scene = build(&description(name));
        let level = SimdLevel::detect();
        let (stop, samples_done) = (AtomicBool::new(false), AtomicU64::new(0));
        let control =
            RenderControl { stop: &stop, samples_done: &samples_done, after_pass: &|_| () };
        let settings = RenderSettings { samples: 2..50, crop: whole(&scene), level };
        let (rendered, snapshots) = render_with(&scene, &settings, |rendering| {
            assert!(rendering.snapshot().unwrap().is_none(), "nothing is rendered yet");
            let mut snapshots: BTreeMap<u64, Film> = BTreeMap::new();
            std::thread::scope(|scope| {
                let running = scope.spawn(|| rendering.run(&control));
                while !running.is_finished() {
                    if let Some(film) = rendering.snapshot().unwrap() {
                        snapshots.insert(film.samples().total(), film);
                    }
                }
                running.join().unwrap().unwrap();
            });
            snapshots
        })
        .unwrap();
        println!("{name}: {} different snapshots", snapshots.len());
        for (held, film) in &snapshots {
            let expected = part(&scene, 2..2 + held, whole(&scene), level);
            assert!(bytes(film) == bytes(&expected), "{name}: a snapshot of {held} samples");
        }
        let expected = part(&scene, 2..50, whole(&scene), level);
        assert!(bytes(&rendered.film) == bytes(&expected), "{name}");
    }
}
