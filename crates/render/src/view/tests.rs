//! What looks show.

use super::*;
use crate::Strata;
use crate::camera::Camera;
use crate::description::{
    DirectView, FilmDescription, IceDescription, IntegratorKind, LightDescription, LightFinding,
    LightKind, ObjectDescription, ObjectShape, Surface,
};
use crate::{Scene, transport::FirstHit};
use snowgrain_grains::{DepositRule, DepositSettings, Radii};
use snowgrain_math::{DAffine3, Ray};

/// A ball of 5 cm on a slab, under a centimetre of snow.
fn scene(width: u32, height: u32) -> SceneDescription {
    let object = |shape, transform| ObjectDescription {
        name: "object".into(),
        shape,
        surface: Surface::diffuse([0.5; 3]),
        direct_view: DirectView::Seen,
        transform,
    };
    let ball = DAffine3::from_translation(DVec3::new(0.3, 0.05, 0.0))
        * DAffine3::from_scale(DVec3::splat(0.05));
    let slab = DAffine3::from_translation(DVec3::new(0.3, -0.02, 0.0))
        * DAffine3::from_scale(DVec3::new(0.08, 0.02, 0.08));
    SceneDescription {
        film: FilmDescription::new(width, height, 1, 0),
        camera: CameraDescription {
            from: DVec3::Z,
            at: DVec3::ZERO,
            up: DVec3::Y,
            projection: Projection::pinhole(40.0),
            backdrop: [0.25; 3],
        },
        ice: IceDescription::clear(1.31),
        lights: vec![LightDescription::new(LightKind::Sky, [1.0; 3])],
        objects: vec![object(ObjectShape::Sphere, ball), object(ObjectShape::Box, slab)],
        snow: vec![SnowDescription::Deposit(DepositSettings {
            amount: Amount::Depth(0.01),
            radii: Radii::Uniform { mean: 1e-3, variation: 0.0 },
            density: None,
            rule: Some(DepositRule::Ray),
            max_slope_degrees: 80.0,
            direction: DepositSettings::DOWN,
            area: None,
            seed: 0,
        })],
        strata: Strata::default(),
        integrator: IntegratorKind::Grains,
        shapes: Vec::new(),
        light_finding: LightFinding::Exact,
        deep: None,
        packing: None,
        tiled: None,
    }
}

#[test]
fn looks_hold_what_stands_on_the_ground_and_leave_out_the_ground() {
    for (width, height) in [(200, 100), (100, 200)] {
        let scene = scene(width, height);
        for view in [View::Front, View::ThreeQuarter, View::Top] {
            let description = view.camera(&scene).unwrap();
            assert_eq!(description.backdrop, [0.25; 3]);
            let camera = Camera::new(&description, &scene.film);
            let (mut lowest, mut highest) = (f64::INFINITY, 0f64);
            for corner in 0..8 {
                let side = |bit: i32| if corner >> bit & 1 == 0 { -0.05 } else { 0.05 };
                let y = if side(1) < 0.0 { 0.0 } else { 0.11 };
                let point = DVec3::new(0.3 + side(0), y, side(2));
                let (x, y) = camera.project(point, [0.5; 2]).unwrap();
                assert!((0.0..f64::from(width)).contains(&x), "{view:?}: {x}");
                assert!((0.0..f64::from(height)).contains(&y), "{view:?}: {y}");
                (lowest, highest) = (lowest.min(y), highest.max(y));
            }
            let filled = (highest - lowest) / f64::from(height.min(width));
            assert!(filled > 0.4, "{view:?} fills {filled}");
        }
    }
}

/// The snow in the middle of a close look is sharp, and grains are as large as promised.
#[test]
fn a_close_look_is_focused_on_the_snow() {
    let mut scene = scene(64, 64);
    scene.camera = View::Close.camera(&scene).unwrap();
    let aim = (scene.camera.at - scene.camera.from).length();
    let aimed = (scene.camera.at - DVec3::new(0.3, 0.11, 0.0)).abs();
    assert!(aimed.cmplt(DVec3::new(0.05, 0.04, 0.05)).all(), "on the ball: {aimed}");
    let built = Scene::build(&scene, &mut |_| {}).unwrap();
    // Rays from all over the lens meet in the plane in focus: where two of them cross.
    let (a, b) =
        (built.camera.ray(32.0, 32.0, [0.01, 0.5]), built.camera.ray(32.0, 32.0, [0.99, 0.5]));
    let apart = (a.origin - b.origin).length();
    let closing = (a.direction - b.direction).length();
    let focus = apart / closing;
    assert!((focus - aim).abs() < 0.02, "{focus} m, aimed at {aim} m");
    let found = probe(&built);
    assert!((focus - built.camera.depth(found.position)).abs() < 0.004, "{focus}: {found:?}");
    let grain = 2e-3 / built.camera.pixel_footprint(focus);
    assert!((grain / (64.0 / super::close::GRAINS) - 1.0).abs() < 0.2, "{grain} pixels");
}

/// What the middle of the picture shows.
fn probe(scene: &Scene) -> FirstHit {
    use crate::transport::{NewPath, PathResult, PathSource, trace};
    use snowgrain_math::sampler::PathKey;
    struct One(Option<Ray>, Option<FirstHit>);
    impl PathSource for One {
        type Tag = ();
        fn next_path(&mut self) -> Option<NewPath<()>> {
            let key = PathKey::new(0, 0, 0);
            self.0.take().map(|ray| NewPath { tag: (), ray, key, event: 1 })
        }
        fn finish(&mut self, (): (), result: &PathResult) {
            self.1 = result.first_hit;
        }
    }
    let mut one = One(Some(scene.camera.ray(32.0, 32.0, [0.5; 2])), None);
    trace(&scene.world, crate::SimdLevel::detect(), &mut one);
    one.1.unwrap()
}

#[test]
fn there_must_be_something_to_look_at() {
    let mut scene = scene(64, 64);
    scene.objects.clear();
    assert!(View::Front.camera(&scene).is_some(), "the snow alone");
    scene.snow.clear();
    for view in View::ALL {
        assert_eq!(view.camera(&scene), None);
    }
}
