//! Homogeneous layers against closed forms, identities and the project's reference tables.

use super::*;
use snowgrain_math::trig;

fn slab(depth: f32, illumination: Illumination) -> HomogeneousLayers {
    HomogeneousLayers {
        eta: 1.31,
        polarisation: Polarisation::Redrawn,
        bottoms: vec![depth],
        planes: Vec::new(),
        illumination,
        seed: 0,
        least_absorption: vec![0.0],
    }
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
