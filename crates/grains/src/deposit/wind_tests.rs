//! Falls along a direction, and of very different sizes, against a search of everything.

use super::*;
use crate::{DepositRule, Radii};
use snowgrain_accel::SurfaceShape;
use snowgrain_geometry::QuantisedGrain;
use snowgrain_math::{DAffine3, DVec3};

const R: f64 = 0.5e-3;

/// Height at which a sphere of `radius` whose centre falls along `down` through `start` first
/// touches one of `grains`, or has its centre (a ray: its hit) `radius` over the plane y = 0.
fn first_touch(grains: &[QuantisedGrain], start: DVec3, down: DVec3, radius: f64) -> (f64, DVec3) {
    let floor = (start.y - radius) / -down.y;
    let mut first = (floor, DVec3::Y);
    for grain in grains {
        let [x, y, z] = grain.center.map(f64::from);
        let (center, reach) = (DVec3::new(x, y, z), f64::from(grain.radius) + radius);
        let along = (center - start).dot(down);
        let aside = (center - start - down * along).length_squared();
        if aside <= reach * reach {
            let t = along - (reach * reach - aside).sqrt();
            if t < first.0 {
                first = (t, (start + down * t - center) / reach);
            }
        }
    }
    first
}

/// Every grain of `later` lies where the search of all that came before puts one.
fn assert_at_rest(rule: DepositRule, direction: [f64; 3], radii: Radii, grains: u64) {
    let quantisation = Quantisation::for_grains(DVec3::ZERO, radii.largest());
    let plane = Surfaces::new(&[(SurfaceShape::Plane, DAffine3::IDENTITY)]);
    let mut snow = Snowfall::on_surfaces(quantisation, &plane);
    let down = DVec3::from_array(direction).normalize();
    let mut lying: Vec<QuantisedGrain> = Vec::new();
    for seed in 0..grains {
        let settings = DepositSettings {
            amount: Amount::Grains(1),
            radii: radii.clone(),
            density: None,
            rule: Some(rule),
            max_slope_degrees: 90.0,
            direction,
            area: Some([0.0, 0.0, 12.0 * R, 9.0 * R]),
            seed,
        };
        let report = snow.deposit(&settings).unwrap();
        let drop = Drop::new(
            &settings,
            Settling::of_rule(rule),
            &quantisation,
            &snow.ground,
            (snow.area(&settings).unwrap(), snow.lowest()),
            snow.snowfalls - 1,
        );
        let start = drop.start(report.discarded + report.missed);
        let radius = f64::from(start.radius);
        let above = DVec3::new(f64::from(start.x), 0.0, f64::from(start.z)) - down * 3e6;
        let reach = if rule == DepositRule::Ray { 0.0 } else { radius };
        let (t, normal) = first_touch(&lying, above, down, reach);
        let mut rest = above + down * t;
        if rule == DepositRule::Ray {
            rest += normal * radius;
        }
        let found = added(&snow, &lying);
        let at = DVec3::from_array(found.center.map(f64::from));
        // Half a quantum along each axis, and where the height of a contact is rounded up first, up
        // to one more along the line.
        let off = (at - rest).length();
        assert!(off <= 0.87 + 1.0 / -down.y, "{rule:?} {direction:?}: {off} quanta off");
        assert_eq!(found.radius, start.radius);
        lying.push(found);
    }
    assert!(lying.iter().any(|g| f64::from(g.center[1]) > 1.6 * f64::from(g.radius)));
}

/// The grain of the store that is not in `known`.
fn added(snow: &Snowfall<'_>, known: &[QuantisedGrain]) -> QuantisedGrain {
    let mut all: Vec<_> = snow.pile.all().flat_map(GrainStacks::iter).collect();
    for grain in known {
        let index = all.iter().position(|g| g == grain).unwrap();
        all.swap_remove(index);
    }
    assert_eq!(all.len(), 1);
    all[0]
}

#[test]
fn grains_in_the_wind_rest_where_a_search_of_all_grains_says() {
    for direction in [[0.0, -1.0, 0.0], [0.4, -1.0, 0.3], [-3.0, -1.0, 1.0], [0.0, -1.0, 2.0]] {
        for rule in [DepositRule::Ray, DepositRule::Stick] {
            assert_at_rest(rule, direction, Radii::Uniform { mean: R, variation: 0.2 * R }, 120);
        }
    }
}

#[test]
fn grains_with_radii_down_to_nothing_rest_where_a_search_of_all_grains_says() {
    for rule in [DepositRule::Ray, DepositRule::Stick] {
        assert_at_rest(rule, DepositSettings::DOWN, Radii::Uniform { mean: R, variation: R }, 150);
    }
}

#[test]
fn a_ball_shelters_what_lies_in_its_lee() {
    let mut place = DAffine3::from_scale(DVec3::splat(10.0 * R));
    place.translation = DVec3::Y * (10.0 * R);
    let surfaces =
        Surfaces::new(&[(SurfaceShape::Sphere, place), (SurfaceShape::Plane, DAffine3::IDENTITY)]);
    let quantisation = Quantisation::for_grains(DVec3::ZERO, R);
    for rule in [DepositRule::Ray, DepositRule::Stick] {
        let mut snow = Snowfall::on_surfaces(quantisation, &surfaces);
        let settings = DepositSettings {
            amount: Amount::Grains(3_000),
            radii: Radii::Uniform { mean: R, variation: 0.0 },
            density: None,
            rule: Some(rule),
            max_slope_degrees: 90.0,
            direction: [1.0, -1.0, 0.0],
            area: Some([-60.0 * R, -30.0 * R, 30.0 * R, 30.0 * R]),
            seed: 0,
        };
        snow.deposit(&settings).unwrap();
        let field = snow.into_field();
        // The ball's shadow on the plane reaches from its foot to x = 10 R (1 + 2^.5) at z = 0.
        let count = |low: f64, high: f64| {
            field
                .iter()
                .filter(|g| g.center.y < 1.5 * R && g.center.z.abs() < 4.0 * R)
                .filter(|g| (low * R..high * R).contains(&g.center.x))
                .count()
        };
        assert_eq!(count(6.0, 20.0), 0, "{rule:?}");
        assert!(count(-40.0, -26.0) > 3, "{rule:?}: {}", count(-40.0, -26.0));
        let on_ball = |g: &snowgrain_geometry::Grain| {
            let gap = (g.center - DVec3::Y * (10.0 * R)).length() - 11.0 * R;
            gap.abs() < 3.0 * quantisation.quantum()
        };
        let windward = field.iter().filter(|g| on_ball(g) && g.center.x < 0.0).count();
        let lee = field.iter().filter(|g| on_ball(g) && g.center.x > 8.0 * R).count();
        assert!(windward > 15 && lee == 0, "{rule:?}: {windward} {lee}");
    }
}

#[test]
fn a_direction_that_does_not_point_down_is_refused() {
    let quantisation = Quantisation::for_grains(DVec3::ZERO, R);
    let down = DepositSettings::DOWN;
    for (rule, direction) in [
        (DepositRule::Ray, [0.0, 1.0, 0.0]),
        (DepositRule::Ray, [1.0, 0.0, 0.0]),
        (DepositRule::Stick, [0.0, 0.0, 0.0]),
        (DepositRule::Stick, [f64::NAN, -1.0, 0.0]),
        (DepositRule::Ray, [20.0, -1.0, 0.0]),
        (DepositRule::Roll, [1.0, 0.1, 0.0]),
    ] {
        let mut snow = Snowfall::on_level_floor(quantisation, [20.0 * R; 2]).unwrap();
        let settings = DepositSettings {
            amount: Amount::Grains(1),
            radii: Radii::Uniform { mean: R, variation: 0.0 },
            density: None,
            rule: Some(rule),
            max_slope_degrees: 90.0,
            direction,
            area: None,
            seed: 0,
        };
        let error = snow.deposit(&settings).unwrap_err();
        assert!(
            matches!(error, GrainsError::Setting { key: "direction", .. }),
            "{rule:?} {direction:?}: {error}"
        );
        let turned = DepositSettings { direction: down.map(|x| 3.0 * x), ..settings };
        assert!(snow.deposit(&turned).is_ok());
    }
}

/// What rolls off a ball that hangs over nothing, or over a floor, in the wind and without.
#[test]
fn grains_that_the_wind_brings_roll_to_rest_by_gravity_alone() {
    let quantisation = Quantisation::for_grains(DVec3::ZERO, R);
    let ball = (SurfaceShape::Sphere, DAffine3::from_scale(DVec3::splat(12.0 * R)));
    let floor = DAffine3::from_translation(DVec3::NEG_Y * (12.0 * R));
    let over_floor = Surfaces::new(&[ball.clone(), (SurfaceShape::Plane, floor)]);
    let over_nothing = Surfaces::new(&[ball]);
    for (surfaces, direction, grains) in [
        (&over_floor, [0.5, -1.0, 0.2], 2_000),
        (&over_nothing, [0.5, -1.0, 0.2], 250),
        (&over_nothing, DepositSettings::DOWN, 250),
    ] {
        let mut snow = Snowfall::on_surfaces(quantisation, surfaces);
        let settings = DepositSettings {
            amount: Amount::Grains(grains),
            radii: Radii::Uniform { mean: R, variation: 0.0 },
            density: None,
            rule: Some(DepositRule::Roll),
            max_slope_degrees: 90.0,
            direction,
            area: Some([-14.0 * R, -14.0 * R, 14.0 * R, 14.0 * R]),
            seed: 0,
        };
        let report = snow.deposit(&settings).unwrap();
        assert_eq!((report.accepted, report.unsettled), (grains, 0), "{direction:?}");
        assert_eq!(report.missed > 0, !surfaces.has_infinite(), "{direction:?}");
        let (field, quantum) = (snow.into_field(), quantisation.quantum());
        let rests_on_ground = |grain: &snowgrain_geometry::Grain| {
            let to_ball = grain.center.length() - 13.0 * R;
            to_ball < 2.0 * quantum || grain.center.y < -11.0 * R + 2.0 * quantum
        };
        let connections = crate::measures::connections(&field, None, &rests_on_ground);
        assert!(connections.greatest_overlap_depth < quantum, "{direction:?} {connections:?}");
        assert_eq!(connections.connected_fraction, 1.0, "{direction:?}");
        // Each rests on three others, or on the ground at first touch.
        assert!(connections.contacts_per_grain > 2.5, "{direction:?} {connections:?}");
    }
}

#[test]
fn fine_grains_fall_on_and_under_grains_a_hundred_times_larger() {
    let coarse = 100.0 * R;
    let quantisation = Quantisation::for_grains(DVec3::ZERO, coarse);
    let mut snow = Snowfall::on_level_floor(quantisation, [500.0 * R; 2]).unwrap();
    let settings = |mean: f64, grains: u64, rule: DepositRule| DepositSettings {
        amount: Amount::Grains(grains),
        radii: Radii::Uniform { mean, variation: 0.0 },
        density: None,
        rule: Some(rule),
        max_slope_degrees: 90.0,
        direction: DepositSettings::DOWN,
        area: None,
        seed: 0,
    };
    for (mean, grains) in [(coarse, 4), (R, 30_000), (coarse, 2)] {
        snow.deposit(&settings(mean, grains, DepositRule::Stick)).unwrap();
    }
    assert_eq!(snow.pile.all().count(), 2);
    let (period, field) = (snow.period(), snow.into_field());
    let connections = crate::measures::connections(&field, period, &|grain| {
        grain.center.y < 1.001 * grain.radius
    });
    let quantum = quantisation.quantum();
    assert!(connections.greatest_overlap_depth < quantum, "{connections:?}");
    assert_eq!(connections.connected_fraction, 1.0);
}
