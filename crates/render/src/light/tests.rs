//! Lights against closed forms, and samplers against their densities.

use super::*;
use core::f64::consts::PI;
use snowgrain_math::sampler::{PathKey, numbers};
use std::sync::Arc;

fn lights(lights: &[LightDescription], backdrop: [f32; 3]) -> Lights {
    let surfaces = LitSurfaces::new(Vec::new(), lights);
    Lights::new(lights, &surfaces, backdrop, &Aabb::new(-DVec3::ONE, DVec3::ONE))
}

fn radiances(lights: &Lights, direction: DVec3) -> Vec<[f32; 3]> {
    let mut sums = vec![[0.0; 3]; lights.slots().len()];
    lights.add_radiances(direction, &mut sums);
    sums
}

fn seen(lights: &Lights, direction: DVec3) -> Vec<[f32; 3]> {
    let mut sums = vec![[0.0; 3]; lights.slots().len()];
    lights.add_seen_by_camera(direction, &mut sums);
    sums
}

fn sky(spectrum: Illuminant, visible_to_camera: bool) -> LightDescription {
    let light = LightDescription::new(LightKind::Sky, [2.0; 3]);
    LightDescription { spectrum, visible_to_camera, ..light }
}

#[test]
fn the_camera_sees_the_backdrop_only_where_no_light_is_visible() {
    let hidden = lights(&[sky(Illuminant::D65, false)], [0.1; 3]);
    assert_eq!(seen(&hidden, DVec3::Y), [[0.0; 3], [0.1; 3]]);
    assert_eq!(radiances(&hidden, DVec3::Y), [[2.0; 3], [0.0; 3]]);
    assert_eq!(radiances(&hidden, -DVec3::Y), [[0.0; 3]; 2]);
    let visible = lights(&[sky(Illuminant::D65, true)], [0.1; 3]);
    assert_eq!(seen(&visible, DVec3::Y), [[2.0; 3]]);
    assert_eq!(seen(&visible, -DVec3::Y), [[0.0; 3]]);
    assert_eq!(visible.greatest_radiance(), 2.0);
}

#[test]
fn lights_of_one_group_and_spectrum_add_and_others_stay_apart() {
    let uniform = LightDescription {
        spectrum: Illuminant::A,
        visible_to_camera: false,
        ..LightDescription::new(LightKind::Uniform, [1.0, 0.5, 0.0])
    };
    let apart = lights(&[sky(Illuminant::A, false), uniform.clone()], [0.0; 3]);
    assert_eq!(radiances(&apart, DVec3::Y), [[2.0; 3], [1.0, 0.5, 0.0]]);
    let together = LightDescription { group: "sky".into(), ..uniform };
    let together =
        lights(&[sky(Illuminant::A, false), together, sky(Illuminant::D65, false)], [0.0; 3]);
    let slot = |spectrum| LightSlot { group: "sky".into(), spectrum };
    assert_eq!(together.slots(), [slot(Illuminant::A), slot(Illuminant::D65)]);
    assert_eq!(radiances(&together, DVec3::Y), [[3.0, 2.5, 2.0], [2.0; 3]]);
    assert_eq!(radiances(&together, -DVec3::Y), [[1.0, 0.5, 0.0], [0.0; 3]]);
    assert_eq!(seen(&together, DVec3::Y), [[0.0; 3]; 2]);
}

/// A map without dark pixels, brighter to the east, with a bright spot.
fn smooth_map() -> Arc<EnvironmentMap> {
    let mut pixels: Vec<_> = (0..32 * 16).map(|at| [0.2 + (at % 32) as f32 * 0.03; 3]).collect();
    pixels[5 * 32 + 20] = [40.0; 3];
    Arc::new(EnvironmentMap::new(32, 16, pixels).unwrap())
}

/// One of each kind at infinity.
fn distant() -> Vec<LightDescription> {
    let sun = direction_of(25.0, 140.0);
    [
        LightKind::Sky,
        LightKind::Uniform,
        LightKind::Overcast,
        LightKind::ClearSky { sun },
        LightKind::Sun { direction: sun, diameter_degrees: 0.53 },
        LightKind::Sun { direction: direction_of(80.0, -10.0), diameter_degrees: 60.0 },
        LightKind::Environment { map: smooth_map(), rotation_degrees: 50.0 },
    ]
    .map(|kind| LightDescription::new(kind, [1.0; 3]))
    .to_vec()
}

/// Directions at the middles of cells of equal solid angle, and that solid angle.
fn directions(heights: usize, azimuths: usize) -> (impl Iterator<Item = DVec3>, f64) {
    let cells = (heights * azimuths) as f64;
    let all = (0..heights * azimuths).map(move |cell| {
        let height = 1.0 - 2.0 * ((cell / azimuths) as f64 + 0.5) / heights as f64;
        direction_table::direction_at(height, ((cell % azimuths) as f64 + 0.5) / azimuths as f64)
    });
    (all, 4.0 * PI / cells)
}

#[test]
fn level_ground_receives_what_closed_forms_say() {
    let irradiance = |kind: LightKind| {
        let light = Distant::new(&kind).unwrap();
        let (all, solid_angle) = directions(1000, 1000);
        let downward = all.filter(|d| d.y > 0.0);
        downward.map(|d| f64::from(light.radiance(d)[1]) * d.y).sum::<f64>() * solid_angle
    };
    let sun = direction_of(35.0, 100.0);
    for (kind, expected) in [
        (LightKind::Sky, PI),
        (LightKind::Uniform, PI),
        (LightKind::Overcast, 7.0 * PI / 9.0),
        (LightKind::ClearSky { sun }, PI),
        (LightKind::ClearSky { sun: direction_of(1.0, 0.0) }, PI),
        (
            LightKind::Sun { direction: sun, diameter_degrees: 20.0 },
            irradiance_of_disc(20.0) * sun.y,
        ),
    ] {
        let found = irradiance(kind.clone());
        assert!((found / expected - 1.0).abs() < 2e-3, "{kind:?}: {found} {expected}");
    }
}

#[test]
fn densities_sum_to_one_and_totals_are_those_of_the_radiance() {
    for light in distant() {
        let source = Distant::new(&light.kind).unwrap();
        if source.solid_angle() < 0.01 {
            continue; // too small for the sum
        }
        let (all, solid_angle) = directions(1024, 1024);
        let (density, total) = all.fold((0.0, 0.0), |(density, total), direction| {
            (density + source.density(direction), total + luminance(source.radiance(direction)))
        });
        assert!((density * solid_angle - 1.0).abs() < 2e-3, "{:?}: {density}", light.kind);
        let total = total * solid_angle / source.total();
        assert!((total - 1.0).abs() < 2e-3, "{:?}: {total}", light.kind);
    }
}

/// Three numbers of a sequence.
fn uniform(stream: u64, index: u32) -> [f64; 3] {
    numbers(PathKey::new(7, stream, u64::from(index)), 0).map(f64::from)
}

#[test]
fn samples_follow_their_density_by_chi_square() {
    // 20 x 20 cells of equal solid angle around the light. With k cells in which at least 10 samples are expected, chi-square
    // exceeds k + 5 sqrt(2 k) + 17 by chance less than once in 10^6; six lights are tried.
    for (stream, light) in distant().into_iter().enumerate() {
        let source = Distant::new(&light.kind).unwrap();
        let narrow = source.solid_angle() < 0.01;
        const CELLS: usize = 20;
        const FINE: usize = 16;
        let (samples, cells) = (100_000u32, CELLS * CELLS);
        let cell_of = |direction: DVec3| -> usize {
            let (height, turn) = if narrow {
                let LightKind::Sun { direction: middle, .. } = light.kind else { unreachable!() };
                let (s, t) = snowgrain_math::frame::tangents(middle);
                let angle = snowgrain_math::trig::atan2(direction.dot(t), direction.dot(s));
                let share =
                    (direction - middle).length_squared() * 0.5 * 2.0 * PI / source.solid_angle();
                (1.0 - 2.0 * share.min(1.0 - 1e-9), angle / (2.0 * PI) + 0.5)
            } else {
                (direction.y, direction_table::turn_of(direction))
            };
            let row = ((1.0 - height) * 0.5 * CELLS as f64) as usize;
            row.min(CELLS - 1) * CELLS + ((turn * CELLS as f64) as usize).min(CELLS - 1)
        };
        let mut expected = vec![0.0; cells];
        if narrow {
            expected.fill(f64::from(samples) / cells as f64);
        } else {
            let (all, solid_angle) = directions(CELLS * FINE, CELLS * FINE);
            for direction in all {
                expected[cell_of(direction)] +=
                    source.density(direction) * solid_angle * f64::from(samples);
            }
        }
        let mut found = vec![0.0; cells];
        for index in 0..samples {
            let [_, u, v] = uniform(stream as u64, index);
            let direction = source.sample([u, v]).unwrap();
            assert!((direction.length() - 1.0).abs() < 1e-12);
            assert!(source.density(direction) > 0.0 && source.radiance(direction)[1] > 0.0);
            found[cell_of(direction)] += 1.0;
        }
        let pairs: Vec<_> = expected.iter().zip(&found).filter(|(e, _)| **e >= 10.0).collect();
        let chi_square = pairs.iter().map(|(e, f)| (*f - *e) * (*f - *e) / *e).sum::<f64>();
        let k = pairs.len() as f64;
        assert!(
            chi_square < k + 5.0 * (2.0 * k).sqrt() + 17.0,
            "{:?}: {chi_square} of {k}",
            light.kind
        );
    }
}

#[test]
fn samples_of_all_lights_sum_to_their_irradiance() {
    // The mean of radiance times cosine over pdf is the irradiance of level ground. 4 standard errors: one
    // false alarm in 16 000 seeds.
    let all = lights(&distant(), [0.0; 3]);
    let expected: f64 = {
        let (directions, solid_angle) = directions(1024, 1024);
        let sum = |d: DVec3| radiances(&all, d).iter().map(|r| f64::from(r[1])).sum::<f64>() * d.y;
        let broad = directions.filter(|d| d.y > 0.0).map(sum).sum::<f64>() * solid_angle;
        // The narrow sun falls between the directions or on one.
        let sun = all.select(|light| light == 4);
        let (directions, _) = self::directions(1024, 1024);
        let narrow = directions.map(|d| f64::from(radiances(&sun, d)[1][1]) * d.y).sum::<f64>()
            * solid_angle;
        broad - narrow + irradiance_of_disc(0.53) * direction_of(25.0, 140.0).y
    };
    let (mut sum, mut square) = (0.0, 0.0);
    let samples = 100_000u32;
    for index in 0..samples {
        let sample = all.sample(DVec3::ZERO, uniform(99, index)).unwrap();
        assert_eq!(sample.pdf, all.pdf_at_infinity(sample.light, sample.direction));
        let value = f64::from(sample.radiance[1]) * sample.direction.y.max(0.0) / sample.pdf;
        sum += value;
        square += value * value;
    }
    let count = f64::from(samples);
    let mean = sum / count;
    let error = ((square / count - mean * mean) / count).sqrt();
    assert!((mean - expected).abs() < 4.0 * error + 2e-3 * expected, "{mean} {expected} {error}");
}

#[test]
fn a_selection_is_dark_but_for_what_it_keeps_and_parts_add_to_the_whole() {
    let all = lights(&distant(), [0.0; 3]);
    let small = all.select(|light| all.is_small(light));
    let broad = all.select(|light| !all.is_small(light));
    assert_eq!((0..7).filter(|&light| all.is_small(light)).collect::<Vec<_>>(), [4]);
    for direction in [DVec3::Y, direction_of(25.0, 140.0), direction_of(30.0, 10.0), -DVec3::X] {
        let mut sums = radiances(&small, direction);
        broad.add_radiances(direction, &mut sums);
        assert_eq!(sums, radiances(&all, direction));
    }
    for index in 0..100 {
        assert_eq!(small.sample(DVec3::ZERO, uniform(3, index)).unwrap().light, 4);
    }
    assert_eq!(all.select(|_| false).sample(DVec3::ZERO, [0.5; 3]), None);
}

/// A sphere, a quad and a point over the origin, and the irradiance of level ground there by each.
fn lamps() -> ([LightDescription; 3], [f64; 3]) {
    let center = DVec3::new(0.4, 0.9, -0.2);
    let position = DVec3::new(-0.5, 1.5, 0.0);
    let lamps = [
        LightKind::Sphere { center, radius: 0.3 },
        // Small, so that it is nearly a point; it shines downwards.
        LightKind::Quad {
            corner: DVec3::new(-0.005, 2.0, -0.005),
            edges: [DVec3::X * 0.01, DVec3::Z * 0.01],
        },
        LightKind::Point { position },
    ]
    .map(|kind| LightDescription::new(kind, [2.0; 3]));
    let to_sphere = center.length_squared();
    let to_point = position.length_squared();
    let irradiances = [
        2.0 * PI * 0.09 / to_sphere * center.y / to_sphere.sqrt(),
        2.0 * 1e-4 / 4.0,
        2.0 / to_point * position.y / to_point.sqrt(),
    ];
    (lamps, irradiances)
}

#[test]
fn samples_of_lamps_sum_to_their_irradiance_and_have_the_density_of_their_points() {
    // 4.5 standard errors: a false alarm in 10^5.
    let (descriptions, irradiances) = lamps();
    let all = lights(&descriptions, [0.0; 3]);
    for (light, expected) in irradiances.into_iter().enumerate() {
        let lamp = all.select(|other| other == light);
        let (mut sum, mut square) = (0.0, 0.0);
        let samples = 20_000u32;
        for index in 0..samples {
            let Some(sample) = lamp.sample(DVec3::ZERO, uniform(50 + light as u64, index)) else {
                continue;
            };
            assert_eq!((sample.light, sample.is_point), (light, light == 2));
            let value = f64::from(sample.radiance[1]) * sample.direction.y / sample.pdf;
            sum += value;
            square += value * value;
        }
        let count = f64::from(samples);
        let mean = sum / count;
        let error = ((square / count - mean * mean).max(0.0) / count).sqrt();
        assert!(
            (mean - expected).abs() < 4.5 * error + 1e-4 * expected,
            "{mean} {expected} {error}"
        );
    }
    assert!(all.is_small(1) && all.is_small(2));
    // Nearer than the scene is large: seen from the radius of the scene.
    assert!((all.solid_angle(0) - PI * 0.09 / 3.0).abs() < 1e-12);
    let ball = all.select(|light| light == 0);
    let sample = ball.sample(DVec3::ZERO, [0.3, 0.6, 0.2]).unwrap();
    let point = sample.direction * sample.distance;
    let normal = (point - DVec3::new(0.4, 0.9, -0.2)).normalize();
    let density = ball.pdf_on_surface(0, DVec3::ZERO, point, normal);
    assert!((density / sample.pdf - 1.0).abs() < 1e-9);
    assert_eq!(ball.pdf_at_infinity(0, sample.direction), 0.0);
    assert_eq!(all.pdf_on_surface(1, DVec3::Y * 3.0, DVec3::Y * 2.0, DVec3::Y), 0.0);
}
