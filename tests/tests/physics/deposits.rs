//! Snow that fell: how much of space it fills, and what its overlaps do to light.

use crate::cubes::picture;
use crate::{SIGMAS, assert_agrees, samples};
use snowgrain_accel::SimdLevel;
use snowgrain_film::{Layer, Picture, PixelRect};
use snowgrain_geometry::Quantisation;
use snowgrain_grains::measures::{Slab, mean_surface_height, union_solid_fraction};
use snowgrain_grains::{Amount, DepositRule, DepositSettings, Radii, Snowfall};
use snowgrain_math::{DAffine3, DVec3};
use snowgrain_optics::Absorption;
use snowgrain_render::Scene;
use snowgrain_render::Strata;
use snowgrain_render::description::{
    CameraDescription, DirectView, FilmDescription, IceDescription, IntegratorKind,
    LightDescription, LightFinding, LightKind, ObjectDescription, ObjectShape, Projection,
    SceneDescription, SnowDescription, Surface,
};
use snowgrain_render::measure::{Estimate, Incidence, SlabMeasure, SlabSettings, measure_slab};
use snowgrain_render::surface::Reflectance;
use snowgrain_tests::{
    Oracle, OracleShape, OracleSurface, PinholeCamera, Search, picture::Picture as OraclePicture,
};

const R: f64 = 0.5e-3;

pub(crate) fn fall(rule: DepositRule, grains: u64, area: Option<[f64; 4]>) -> DepositSettings {
    DepositSettings {
        amount: Amount::Grains(grains),
        radii: Radii::Uniform { mean: R, variation: 0.0 },
        density: None,
        rule: Some(rule),
        max_slope_degrees: 90.0,
        direction: DepositSettings::DOWN,
        area,
        seed: 3,
    }
}

/// The deepest piles of the reference; `snowgrain-grains` tests the shallower ones. One pile of the
/// paper's rule differs from the next by .004 on a floor of 120 r (its voids are 30 r wide), so it
/// gets a floor of 240 r: a right program then misses .006 about once in 400 seeds.
#[test]
fn deep_piles_fill_as_much_as_independent_programs_found() {
    for (rule, width, grains, depth, expected) in [
        (DepositRule::Ray, 240.0, 1_870_000, 280.0, 0.414),
        (DepositRule::Stick, 120.0, 241_000, 460.0, 0.147),
    ] {
        let quantisation = Quantisation::for_grains(DVec3::ZERO, R);
        let mut snow = Snowfall::on_level_floor(quantisation, [width * R; 2]).unwrap();
        snow.deposit(&fall(rule, grains, None)).unwrap();
        let period = snow.period().unwrap();
        let field = snow.into_field();
        let deep = mean_surface_height(&field, period) / R;
        let slab = Slab::between_parts_of_depth(&field, Some(period), [0.2, 0.8]);
        let fraction = union_solid_fraction(&field, &slab, 300_000, 1).mean;
        println!("{rule:?}: {fraction:.4} at {deep:.1} r, reference {expected} at {depth} r");
        assert!((deep - depth).abs() < 0.04 * depth, "{deep} r deep");
        assert!((fraction - expected).abs() < 0.006, "{fraction} at {deep} r");
    }
}

/// A pile of the paper's rule on a floor with a box in it, seen from above at a slant.
pub(crate) fn pile(
    grains: u64,
    width: f64,
    albedo: [f32; 3],
    lights: Vec<LightDescription>,
) -> SceneDescription {
    let half = 0.5 * width;
    let object = |shape, transform| ObjectDescription {
        name: "object".into(),
        shape,
        surface: Surface::diffuse(albedo),
        direct_view: DirectView::Seen,
        transform,
    };
    let block = DAffine3::from_translation(DVec3::new(0.0, 0.15 * width, 0.0))
        * DAffine3::from_rotation_y(0.4)
        * DAffine3::from_scale(DVec3::splat(0.15 * width));
    SceneDescription {
        film: FilmDescription::new(48, 32, 1, 11),
        camera: CameraDescription {
            from: DVec3::new(0.2, 1.5, 1.6) * width,
            at: DVec3::new(0.0, 0.2, 0.0) * width,
            up: DVec3::Y,
            projection: Projection::pinhole(28.0),
            backdrop: [0.0; 3],
        },
        ice: IceDescription::clear(1.32),
        lights,
        objects: vec![
            object(ObjectShape::Plane, DAffine3::IDENTITY),
            object(ObjectShape::Box, block),
        ],
        snow: vec![SnowDescription::Deposit(fall(
            DepositRule::Ray,
            grains,
            Some([-half, -half, half, half]),
        ))],
        strata: Strata::default(),
        integrator: IntegratorKind::Grains,
        shapes: Vec::new(),
        light_finding: LightFinding::Exact,
        deep: None,
        packing: None,
        tiled: None,
    }
}

/// Every path of a scene that loses nothing escapes with its throughput whole, overlaps, floor and
/// box notwithstanding.
#[test]
fn a_deep_deposit_in_a_furnace_is_exactly_one_everywhere() {
    let light = LightDescription::new(LightKind::Uniform, [1.0; 3]);
    let grains = samples(200_000, 1_000_000);
    let description = pile(grains, 0.1, [1.0; 3], vec![light]);
    let scene = Scene::build(&description, &mut |_| ()).unwrap();
    assert_eq!(scene.report.grains, grains);
    let whole = PixelRect::new(0, 0, 48, 32);
    let rendered = picture(&scene, 0..samples(16, 100), whole);
    let developed = Picture::from_film(&rendered.film).unwrap();
    for layer in [Layer::R, Layer::G, Layer::B] {
        assert!(developed.layer(layer).unwrap().iter().all(|&value| value == 1.0));
    }
    let counts = rendered.statistics;
    println!("furnace: {counts:?}");
    assert_eq!(counts.trapped_paths, 0);
    assert!(counts.interface_events > 2 * counts.grain_visits && counts.surface_bounces > 1000);
}

/// Light in a periodic pile of the paper's rule fills its air evenly, whatever its overlaps scatter:
/// the void path is twice the void between the faces. As one solid its ice scatters like no sphere:
/// 1.61 times the straight path (1.25 for spheres), 2.5 events a visit.
#[test]
fn a_pile_with_overlaps_shows_its_void_and_traps_nothing() {
    let quantisation = Quantisation::for_grains(DVec3::ZERO, R);
    let mut snow = Snowfall::on_level_floor(quantisation, [100.0 * R; 2]).unwrap();
    snow.deposit(&fall(DepositRule::Ray, 50_000, None)).unwrap();
    let period = snow.period().unwrap();
    let field = snow.into_field();
    let mut space = Slab::between_parts_of_depth(&field, Some(period), [0.0, 1.0]);
    (space.min.y, space.max.y) = (0.0, field.bounds().max.y);
    let ice = union_solid_fraction(&field, &space, 2_000_000, 2);
    let settings = SlabSettings {
        top: space.max.y,
        bottom: 0.0,
        period,
        incidence: Incidence::Lambertian,
        from_below: false,
        absorption_per_metre: 0.0,
        paths: samples(50_000, 1_000_000),
        seed: 9,
        level: SimdLevel::detect(),
    };
    let world = crate::periodic(&field, period);
    let above = measure_slab(&world, &settings);
    let below = measure_slab(&world, &SlabSettings { from_below: true, ..settings });
    for measure in [&above, &below] {
        let sum = measure.reflectance.mean + measure.transmittance.mean;
        assert!((sum - 1.0).abs() < 1e-12, "{sum}");
        assert_eq!(measure.trapped_paths, 0);
    }
    let mean = |part: fn(&SlabMeasure) -> Estimate| {
        let (a, b) = (part(&above), part(&below));
        let mean = 0.5 * (a.mean + b.mean);
        Estimate { mean, standard_error: 0.5 * (a.standard_error + b.standard_error) }
    };
    let height = space.max.y;
    let void = 2.0 * (1.0 - ice.mean) * height;
    let known = 2.0 * ice.standard_error * height;
    assert_agrees("void path", mean(|m| m.void_path), void, SIGMAS * known);
    let enhancement = mean(|m| m.ice_path).mean / (2.0 * ice.mean * height);
    let events = mean(|m| m.interface_events).mean / mean(|m| m.grain_visits).mean;
    println!("B = {enhancement:.3}, {events:.3} events a visit, fill {:.4}", ice.mean);
    assert!((enhancement - 1.61).abs() < 0.02, "{enhancement}");
    assert!((events - 2.5).abs() < 0.05, "{events}");
}

/// The same samples of the same pixels, with grey absorption and coloured objects, in the fast
/// kernels and in the oracle.
#[test]
fn a_picture_of_a_deposit_agrees_with_the_oracle_in_the_mean() {
    let light = LightDescription::new(LightKind::Sky, [1.0; 3]);
    let mut description = pile(20_000, 0.03, [0.8, 0.4, 0.1], vec![light]);
    description.ice.absorption = Absorption::Grey(3.0);
    let scene = Scene::build(&description, &mut |_| ()).unwrap();
    let whole = PixelRect::new(0, 0, 48, 32);
    let spp = samples(16, 300);

    let mut build = |_| ();
    let (field, _) = snowgrain_render::deposit(&description, &mut build).unwrap();
    let grains: Vec<_> = field.iter().collect();
    let corner = |index: usize| {
        let side = |bit: usize| if index & bit == 0 { -1.0 } else { 1.0 };
        description.objects[1].transform.transform_point3(DVec3::new(side(1), side(2), side(4)))
    };
    const QUADS: [[usize; 4]; 6] =
        [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let block = QUADS.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]);
    let Surface::Diffuse { albedo: Reflectance::Colour(albedo) } = description.objects[0].surface
    else {
        panic!()
    };
    let albedo = DVec3::from_array(albedo.map(f64::from));
    let surfaces = [
        OracleShape::Plane { point: DVec3::ZERO, normal: DVec3::Y },
        OracleShape::Triangles(block.map(|corners| corners.map(corner)).collect()),
    ]
    .map(|shape| OracleSurface { shape, albedo });
    let tracer = Oracle::new(&grains, &surfaces, description.ice.ior, Search::Cells);
    let camera = &description.camera;
    let sky = |direction: DVec3| if direction.y > 0.0 { DVec3::ONE } else { DVec3::ZERO };
    let exact = OraclePicture {
        oracle: &tracer,
        camera: PinholeCamera::new(camera.from, camera.at, camera.up, 28f64.to_radians(), [48, 32]),
        width: 48,
        seed: description.film.seed,
        absorption: 3.0,
        light: sky,
        backdrop: sky,
    };

    // One sample at a time, so that the difference of every single pair is known.
    let pixels: Vec<u32> = (0..48 * 32).collect();
    let mut sums = [[0.0; 2]; 3];
    let mut means = [[0.0; 3]; 2];
    for sample in 0..spp {
        let film = picture(&scene, sample..sample + 1, whole).film;
        let fast = Picture::from_film(&film).unwrap();
        let fast = fast.colour().unwrap();
        let slow = exact.samples(&pixels, sample);
        for (pixel, exact) in slow.into_iter().enumerate() {
            for (channel, exact) in exact.to_array().into_iter().enumerate() {
                let value = f64::from(fast[channel][pixel]);
                let difference = value - exact;
                sums[channel][0] += difference;
                sums[channel][1] += difference * difference;
                means[0][channel] += value;
                means[1][channel] += exact;
            }
        }
    }
    let count = (spp * 48 * 32) as f64;
    for (channel, [sum, squares]) in sums.into_iter().enumerate() {
        let (bias, sigma) = (sum / count, squares.sqrt() / count);
        let [fast, slow] = means.map(|mean| mean[channel] / count);
        println!("channel {channel}: {fast:.5} and {slow:.5}, difference {bias:.5} +- {sigma:.5}");
        // 3 standard errors on top of the tolerance: by chance less than once in 400 seeds.
        assert!(bias.abs() < 0.0005 + 3.0 * sigma, "channel {channel}: {bias} +- {sigma}");
    }
}
