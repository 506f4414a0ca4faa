//! Homogeneous layers against closed forms, identities and the project's reference tables.

use super::*;
use snowgrain_math::sampler::{PathKey, numbers};
use snowgrain_math::trig;
use snowgrain_optics::Dielectric;
use snowgrain_optics::sphere::Impact;

fn slab(depth: f32, illumination: Illumination) -> HomogeneousLayers {
    HomogeneousLayers {
        eta: 1.31,
        polarisation: Polarisation::Redrawn,
        bottoms: vec![depth],
        scattering: vec![GrainScattering::Sphere],
        planes: Vec::new(),
        illumination,
        seed: 0,
        least_absorption: vec![0.0],
    }
}

/// Light that spheres turned, by their closed form.
fn sampled_spheres(count: u64) -> GrainScattering {
    let ice = Dielectric { eta: 1.31 };
    let sample = |index| {
        let [place, which, _] = numbers(PathKey::new(8, index, 0), 0).map(f64::from);
        let impact = Impact::at_disc_fraction(ice, place);
        let (mut order, mut sum) = (0, impact.energy(0));
        while which >= sum && order < 60 {
            order += 1;
            sum += impact.energy(order);
        }
        ScatteringSample {
            cosine: trig::sin_cos(impact.deflection(order)).1 as f32,
            length: (f64::from(order) * impact.chord()) as f32,
        }
    };
    GrainScattering::Sampled((0..count).map(sample).collect())
}

#[derive(Default)]
struct Sums {
    reflected: f64,
    transmitted: f64,
    visits: f64,
    ice: f64,
}

fn sums(layers: &HomogeneousLayers, paths: u64) -> Sums {
    let mut sums = Sums::default();
    trace_homogeneous(
        layers,
        SimdLevel::detect(),
        0..paths,
        &mut |path| {
            let weight = f64::from(path.weight);
            match path.end {
                HomogeneousEnd::Reflected => sums.reflected += weight,
                HomogeneousEnd::Transmitted => sums.transmitted += weight,
                HomogeneousEnd::GivenUp => (),
            }
            sums.visits += f64::from(path.grain_visits);
            sums.ice += path.ice_lengths.iter().sum::<f64>();
        },
        &mut |_| (),
    );
    let n = paths as f64;
    Sums {
        reflected: sums.reflected / n,
        transmitted: sums.transmitted / n,
        visits: sums.visits / n,
        ice: sums.ice / n,
    }
}

/// Section 2 of the project's physics: visits and ice of a slab under diffuse light do not depend on
/// its scattering; `packing_slab.csv`, row `hom`: transmittance. Standard errors below 2e-3 of each.
#[test]
fn slabs_transmit_what_an_independent_program_found() {
    for (depth, transmitted) in [(2.0, 0.7183), (5.0, 0.5284), (20.0, 0.2295), (100.0, 0.0574)] {
        let found = sums(&slab(depth, Illumination::Diffuse), 200_000);
        let error = 4.0 * (transmitted * (1.0 - transmitted) / 2e5f64).sqrt() + 0.0005;
        assert!((found.transmitted - transmitted).abs() < error, "{depth}: {}", found.transmitted);
        assert_eq!(found.reflected + found.transmitted, 1.0);
        let visits = 2.0 * f64::from(depth);
        assert!((found.visits / visits - 1.0).abs() < 0.02, "{depth}: {}", found.visits);
        let ice = visits * 4.0 / 3.0 * 1.2535;
        assert!((found.ice / ice - 1.0).abs() < 0.02, "{depth}: {}", found.ice);
    }
}

/// A layer of spheres is the same whether they are computed or drawn from samples: within 4 standard errors, and
/// what 2^18 samples may be off (.001 of 1 - g).
#[test]
fn sampled_spheres_scatter_as_spheres_do() {
    let spheres = slab(10.0, Illumination::Parallel(0.5));
    let sampled =
        HomogeneousLayers { scattering: vec![sampled_spheres(1 << 18)], ..spheres.clone() };
    let paths = 100_000;
    let (one, other) = (sums(&spheres, paths), sums(&sampled, paths));
    let error = (2.0 * one.reflected * one.transmitted / paths as f64).sqrt();
    assert!((one.reflected - other.reflected).abs() < 4.0 * error + 0.001, "{}", other.reflected);
    assert!((one.ice / other.ice - 1.0).abs() < 0.02, "{} {}", one.ice, other.ice);
    // In space as well.
    let mut reflected = 0.0;
    let space = SpaceLayers {
        scattering: sampled.scattering.clone(),
        illumination: Illumination::Parallel(0.5),
        ..in_space(GrainExtent::Points, 1.0, 10.0)
    };
    trace_in_space(&space, SimdLevel::detect(), 0..paths, &mut |_| (), &mut |end| {
        reflected += f64::from(u8::from(end.end == HomogeneousEnd::Reflected));
    });
    let reflected = reflected / paths as f64;
    assert!((one.reflected - reflected).abs() < 4.0 * error + 0.001, "{reflected}");
}

/// Grains that let all light straight through leave its direction alone to the last bit, and only add length.
#[test]
fn light_that_goes_straight_through_keeps_its_direction() {
    let through = ScatteringSample { cosine: 1.0, length: 2.0 };
    let layers = SpaceLayers {
        scattering: vec![GrainScattering::Sampled([through].into())],
        shown_depth: 100.0,
        ..in_space(GrainExtent::Points, 1.0, 5.0)
    };
    let first = [(1.0f32 - 0.6 * 0.6).sqrt(), 0.0, 0.6];
    let mut visits = 0;
    trace_in_space(
        &layers,
        SimdLevel::detect(),
        0..1000,
        &mut |meeting| assert_eq!(meeting.direction, first),
        &mut |end| {
            assert_eq!(end.direction, first);
            assert_eq!(end.ice_lengths, [2.0 * f64::from(end.grain_visits)]);
            visits += end.grain_visits;
        },
    );
    // 5 / .6 a path; 4 sigma.
    assert!((f64::from(visits) / 1000.0 - 8.333).abs() < 0.37, "{visits}");
}

/// Light that a radius of ice absorbs .01 of, with roulette and without.
#[test]
fn roulette_changes_no_mean() {
    let absorption = 0.01f32;
    let all = slab(200.0, Illumination::Parallel(0.5));
    let thinned = HomogeneousLayers { least_absorption: vec![absorption], ..all.clone() };
    let light = |layers: &HomogeneousLayers| {
        let (mut sum, mut squares, mut visits, paths) = (0.0, 0.0, 0.0, 100_000);
        trace_homogeneous(
            layers,
            SimdLevel::detect(),
            0..paths,
            &mut |path| {
                visits += f64::from(path.grain_visits);
                if path.end != HomogeneousEnd::GivenUp {
                    let left = trig::exp(-f64::from(absorption) * path.ice_lengths[0]);
                    let light = f64::from(path.weight) * left;
                    sum += light;
                    squares += light * light;
                }
            },
            &mut |_| (),
        );
        let n = paths as f64;
        let mean = sum / n;
        (mean, ((squares / n - mean * mean) / n).sqrt(), visits / n)
    };
    let (exact, some) = (light(&all), light(&thinned));
    // The same paths until the first roulette, so that both errors go together.
    assert!((exact.0 - some.0).abs() < 4.0 * some.1, "{exact:?} {some:?}");
    assert!(some.2 < 0.25 * exact.2, "{exact:?} {some:?}");
}

#[test]
fn paths_are_the_same_at_every_simd_level_and_in_any_division() {
    let layers = HomogeneousLayers {
        bottoms: vec![3.0, 10.0, f32::INFINITY],
        scattering: vec![
            GrainScattering::Sphere,
            sampled_spheres(1 << 10),
            GrainScattering::Sphere,
        ],
        least_absorption: vec![1e-3, 0.0, 1e-2],
        polarisation: Polarisation::Tracked,
        ..slab(1.0, Illumination::Diffuse)
    };
    let ends = |level: SimdLevel, cuts: &[u64]| {
        let mut ends = Vec::new();
        for cut in cuts.windows(2) {
            trace_homogeneous(
                &layers,
                level,
                cut[0]..cut[1],
                &mut |path| {
                    let ice =
                        path.ice_lengths.iter().map(|length| length.to_bits()).collect::<Vec<_>>();
                    let cos_theta = path.cos_theta.to_bits();
                    ends.push((
                        path.end as u8,
                        path.weight.to_bits(),
                        cos_theta,
                        ice,
                        path.grain_visits,
                    ));
                },
                &mut |_| (),
            );
        }
        ends.sort();
        ends
    };
    let expected = ends(SimdLevel::detect(), &[0, 1000]);
    assert_eq!(expected.len(), 1000);
    for level in SimdLevel::available() {
        assert!(ends(level, &[0, 1000]) == expected, "{level}");
    }
    assert!(ends(SimdLevel::detect(), &[0, 7, 500, 1000]) == expected);
}

fn in_space(extent: GrainExtent, free_path: f32, depth: f32) -> SpaceLayers {
    SpaceLayers {
        eta: 1.31,
        polarisation: Polarisation::Redrawn,
        bottoms: vec![depth],
        scattering: vec![GrainScattering::Sphere],
        free_path,
        extent,
        illumination: Illumination::Parallel(0.6),
        shown_depth: -1.0,
        seed: 0,
        least_absorption: vec![0.0],
    }
}

/// Followed in space, light comes to the same ends, and directions and weights stay what they are.
#[test]
fn paths_in_space_end_where_plane_ones_do() {
    for illumination in [Illumination::Parallel(0.6), Illumination::Diffuse] {
        assert_same_ends(illumination);
    }
}

fn assert_same_ends(illumination: Illumination) {
    let (depth, paths) = (5.0f32, 100_000);
    let plane = sums(&slab(depth, illumination), paths);
    let space = in_space(GrainExtent::Points, 1.0, depth);
    let layers = SpaceLayers { shown_depth: 1.0, illumination, ..space };
    let (mut reflected, mut visits, mut shown, mut aside) = (0.0, 0.0, 0.0, 0.0);
    trace_in_space(
        &layers,
        SimdLevel::detect(),
        0..paths,
        &mut |meeting| {
            assert!((0.0..=1.0).contains(&meeting.depth));
            let square: f32 = meeting.direction.iter().map(|part| part * part).sum();
            assert!((square - 1.0).abs() < 1e-5, "{meeting:?}");
            shown += f64::from(meeting.weight);
        },
        &mut |end| {
            reflected += f64::from(u8::from(end.end == HomogeneousEnd::Reflected));
            visits += f64::from(end.grain_visits);
            aside += end.place[1];
            assert_eq!(end.end == HomogeneousEnd::Reflected, end.direction[2] < 0.0);
            assert!(end.void_length > 0.0);
        },
    );
    let n = paths as f64;
    let (reflected, visits) = (reflected / n, visits / n);
    assert!((reflected - plane.reflected).abs() < 0.007, "{reflected} {}", plane.reflected);
    assert!((visits / plane.visits - 1.0).abs() < 0.02, "{visits} {}", plane.visits);
    assert!(shown > 0.2 * visits * n && shown < 0.4 * visits * n, "{shown}");
    assert!((aside / n).abs() < 0.1, "{}", aside / n);
}

/// A sphere moves light on by 1.486 radii in the mean (section 1 of the project's physics), and turns it
/// towards the side to which it moves it.
#[test]
fn spheres_move_light_on() {
    // Hardly any way between grains: the second meeting tells what the first grain did.
    let ends = |extent: GrainExtent, paths: u64| {
        let (mut first, mut second) = (0.0, 0.0);
        let layers = SpaceLayers {
            illumination: Illumination::Parallel(1.0),
            shown_depth: 1e9,
            ..in_space(extent, 1e-3, 8.0)
        };
        trace_in_space(
            &layers,
            SimdLevel::detect(),
            0..paths,
            &mut |meeting| match meeting.grain_visits {
                0 => first += f64::from(meeting.depth),
                1 => second += f64::from(meeting.depth),
                _ => (),
            },
            &mut |_| (),
        );
        (first / paths as f64, second / paths as f64)
    };
    let (first, second) = ends(GrainExtent::Spheres, 100_000);
    assert!((first - 1e-3).abs() < 2e-5, "{first}");
    // Those that meet a second grain at all: all but the ones that leave upwards.
    assert!((second - 1.486).abs() < 0.04, "{second}");
    let (_, points) = ends(GrainExtent::Points, 500);
    assert!(points < 0.01, "{points}");
}

#[test]
fn paths_in_space_are_the_same_at_every_simd_level_and_in_any_division() {
    let layers = SpaceLayers {
        shown_depth: 4.0,
        bottoms: vec![3.0, 50.0],
        scattering: vec![GrainScattering::Sphere; 2],
        least_absorption: vec![1e-3, 1e-2],
        polarisation: Polarisation::Tracked,
        ..in_space(GrainExtent::Spheres, 2.0, 1.0)
    };
    let all = |level: SimdLevel, cuts: &[u64]| {
        let (mut met, mut ended) = (Vec::new(), Vec::new());
        for cut in cuts.windows(2) {
            trace_in_space(
                &layers,
                level,
                cut[0]..cut[1],
                &mut |meeting| {
                    met.push((meeting.depth.to_bits(), meeting.direction.map(f32::to_bits)))
                },
                &mut |end| {
                    let places = end.place.map(f64::to_bits);
                    ended.push((places, end.void_length.to_bits(), end.weight.to_bits()));
                },
            );
        }
        met.sort_unstable();
        ended.sort_unstable();
        (met, ended)
    };
    let expected = all(SimdLevel::detect(), &[0, 500]);
    assert_eq!(expected.1.len(), 500);
    for level in SimdLevel::available() {
        assert!(all(level, &[0, 500]) == expected, "{level}");
    }
    assert!(all(SimdLevel::detect(), &[0, 7, 300, 500]) == expected);
}
