//! What is counted, against what is built.

use super::*;
use crate::description::{
    CameraDescription, FilmDescription, IceDescription, IntegratorKind, LightDescription,
    LightKind, Projection, SearchSettings, Sought, Surface,
};
use crate::{Scene, Strata};
use snowgrain_grains::{LatticeKind, Radii};
use snowgrain_math::DAffine3;
use snowgrain_optics::{Impurity, ImpurityKind, Load};

const CROP: PixelRect = PixelRect::new(0, 0, 64, 48);

fn scene(objects: Vec<ObjectDescription>, snow: Vec<SnowDescription>) -> SceneDescription {
    SceneDescription {
        film: FilmDescription::new(64, 48, 10, 0),
        camera: CameraDescription {
            from: DVec3::new(0.0, 0.2, 0.3),
            at: DVec3::ZERO,
            up: DVec3::Y,
            projection: Projection::pinhole(40.0),
            backdrop: [0.0; 3],
        },
        ice: IceDescription::clear(1.31),
        lights: vec![LightDescription::new(LightKind::Sky, [1.0; 3])],
        objects,
        snow,
        strata: Strata::default(),
        shapes: Vec::new(),
        integrator: IntegratorKind::Grains,
        light_finding: LightFinding::Exact,
        deep: None,
        packing: None,
        tiled: None,
    }
}

/// A box of .1 x .02 x .1 m.
fn table() -> ObjectDescription {
    ObjectDescription {
        name: "table".into(),
        shape: ObjectShape::Box,
        surface: Surface::diffuse([0.5; 3]),
        direct_view: DirectView::Seen,
        transform: DAffine3::from_scale(DVec3::new(0.05, 0.01, 0.05)),
    }
}

fn fall(amount: Amount, rule: DepositRule) -> SnowDescription {
    SnowDescription::Deposit(DepositSettings {
        amount,
        radii: Radii::Uniform { mean: 1e-3, variation: 0.3e-3 },
        density: None,
        rule: Some(rule),
        max_slope_degrees: 90.0,
        direction: DepositSettings::DOWN,
        area: Some([-0.05, -0.05, 0.05, 0.05]),
        seed: 0,
    })
}

fn lattice(counts: [u32; 3], density: Option<f64>) -> SnowDescription {
    let (kind, spacing) = (LatticeKind::Sc, density.map(|_| 2e-3));
    SnowDescription::Lattice(LatticeSettings { kind, counts, radius: 1e-3, spacing, density })
}

#[test]
fn snow_by_depth_is_counted_within_a_quarter_and_fits_into_the_estimate() {
    for rule in [DepositRule::Ray, DepositRule::Stick, DepositRule::Roll] {
        let scene = scene(vec![table()], vec![fall(Amount::Depth(0.03), rule)]);
        let cost = CostEstimate::of(&scene, CROP);
        let built = Scene::build(&scene, &mut |_| {}).unwrap().report;
        let ratio = cost.grains as f64 / built.grains as f64;
        assert!((0.8..1.25).contains(&ratio), "{rule:?}: {ratio}");
        let each = built.grain_bytes as f64 / built.grains as f64;
        assert!(each < 2.0 * FAST_BYTES_PER_GRAIN, "{rule:?}: {each} bytes a grain");
    }
}

#[test]
fn light_that_is_looked_for_is_measured_before_and_takes_longer() {
    let fallen = fall(Amount::Grains(1000), DepositRule::Ray);
    let mut snow = scene(vec![table()], vec![fallen]);
    let exact = CostEstimate::of(&snow, CROP);
    let settings = SearchSettings::of(Sought::NotSkies);
    snow.light_finding = LightFinding::Sampled(settings);
    let searched = CostEstimate::of(&snow, CROP);
    let seconds = searched.build_seconds - exact.build_seconds;
    assert!((4.0..30.0).contains(&seconds), "{seconds} s for the measurement");
    assert_eq!(searched.render_seconds, SEARCHED_OVER_EXACT * exact.render_seconds);
}

#[test]
fn memory_follows_the_grains_and_the_pixels() {
    let million = CostEstimate::of(
        &scene(vec![table()], vec![fall(Amount::Grains(1_000_000), DepositRule::Ray)]),
        CROP,
    );
    assert_eq!(million.grains, 1_000_000);
    assert!((110_000_000..115_000_000).contains(&million.grain_bytes));
    assert_eq!(million.building_bytes, CostEstimate::of_grains(1_000_000).building_bytes);
    assert!(million.build_seconds > 0.0 && million.render_seconds > 0.0);
    let half = PixelRect::new(0, 0, 32, 48);
    let cropped = CostEstimate::of(&scene(vec![table()], Vec::new()), half);
    assert_eq!(cropped.film_bytes * 2, million.film_bytes);
    assert_eq!(cropped.grain_bytes, 0);
}

#[test]
fn strata_ice_paths_and_layers_of_light_are_counted() {
    let soot = Impurity { kind: ImpurityKind::BlackCarbon, load: Load::MassFraction(1e-6) };
    let mut snow = scene(vec![table()], vec![lattice([9; 3], None)]);
    let plain = CostEstimate::of(&snow, CROP);
    snow.strata = Strata::of(&[vec![soot]]).unwrap();
    snow.film.keep_ice_paths = true;
    let more = CostEstimate::of(&snow, CROP);
    assert_eq!(more.building_bytes - plain.building_bytes, 729 * 45);
    assert_eq!(more.film_bytes - plain.film_bytes, CROP.area() * FILMS * 768);
    snow.film.keep_light_groups = true;
    let layers = CostEstimate::of(&snow, CROP);
    assert_eq!(layers.film_bytes - more.film_bytes, CROP.area() * FILMS * 48);
}

#[test]
fn a_whole_lattice_clear_of_objects_takes_no_memory() {
    let alone = CostEstimate::of(&scene(Vec::new(), vec![lattice([9; 3], None)]), CROP);
    assert_eq!((alone.grains, alone.grain_bytes), (729, 0));
    let crossed = CostEstimate::of(&scene(vec![table()], vec![lattice([9; 3], None)]), CROP);
    assert!(crossed.grain_bytes > 0);
    let thinned = scene(Vec::new(), vec![lattice([9; 3], Some(100.0))]);
    assert!(CostEstimate::of(&thinned, CROP).grain_bytes > 0);
}

#[test]
fn sizes_beyond_all_numbers_saturate() {
    let endless = scene(
        vec![table()],
        vec![
            lattice([u32::MAX; 3], Some(100.0)),
            fall(Amount::Grains(u64::MAX), DepositRule::Roll),
        ],
    );
    let cost = CostEstimate::of(&endless, PixelRect::new(0, 0, 65536, 65536));
    assert_eq!((cost.grains, cost.peak_bytes()), (u64::MAX, u64::MAX));
}
