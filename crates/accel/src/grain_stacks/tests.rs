use super::*;
use snowgrain_math::DVec3;
use snowgrain_math::sampler::{PathKey, pcg3d};

const R: i32 = 10_900;

fn words(seed: u64, index: u64) -> [u32; 3] {
    let key = PathKey::new(seed, index, 0);
    pcg3d(key.lo, key.hi, 0)
}

fn below(word: u32, bound: i32) -> i32 {
    ((u64::from(word) * bound as u64) >> 32) as i32
}

/// Grains of mixed radii scattered through a box of `width` x `height`, from `corner`.
fn scattered(n: u64, corner: [i32; 3], width: i32, height: i32) -> Vec<QuantisedGrain> {
    (0..n)
        .map(|i| {
            let [a, b, c] = words(1, i);
            let center = [
                corner[0] + below(a, width),
                corner[1] + below(b, height),
                corner[2] + below(c, width),
            ];
            QuantisedGrain { center, radius: (R / 4 + below(a.wrapping_mul(77), 3 * R / 4)) as u16 }
        })
        .collect()
}

fn images(grain: QuantisedGrain, period: Option<[i32; 2]>) -> Vec<QuantisedGrain> {
    let Some([px, pz]) = period else { return vec![grain] };
    let mut all = Vec::new();
    for i in -1..=1 {
        for j in -1..=1 {
            let [x, y, z] = grain.center;
            all.push(QuantisedGrain { center: [x + i * px, y, z + j * pz], ..grain });
        }
    }
    all
}

/// The contact of a falling sphere by asking every grain.
fn brute_contact(
    grains: &[QuantisedGrain],
    period: Option<[i32; 2]>,
    fall: &Fall<'_>,
) -> Option<f64> {
    grains
        .iter()
        .flat_map(|&g| images(g, period))
        .filter_map(|g| {
            let reach = f64::from(g.radius) + fall.radius;
            let (dx, dz) = (f64::from(g.center[0]) - fall.x, f64::from(g.center[2]) - fall.z);
            let square = reach * reach - dx * dx - dz * dz;
            (square >= 0.0).then(|| f64::from(g.center[1]) + square.sqrt())
        })
        .filter(|&h| h <= fall.from && h > fall.down_to)
        .max_by(f64::total_cmp)
}

fn compare_with_brute_force(
    stacks: &mut GrainStacks,
    grains: &[QuantisedGrain],
    corner: [i32; 3],
    width: i32,
) {
    for &grain in grains {
        stacks.push(grain).unwrap();
    }
    let period = stacks.period();
    for level in SimdLevel::available() {
        stacks.set_level(level);
        for i in 0..400 {
            let [a, b, c] = words(2, i);
            let x = f64::from(corner[0] + below(a, width)) + 0.37;
            let z = f64::from(corner[2] + below(b, width));
            for radius in [0.0, f64::from(below(c, R))] {
                let mut fall = Fall::from_above(x, z, radius);
                if i % 3 == 0 {
                    fall.from = f64::from(corner[1] + 3 * R);
                }
                let hit = stacks.first_contact(&fall);
                assert_eq!(hit.map(|h| h.height), brute_contact(grains, period, &fall));
                if let Some(hit) = hit.filter(|_| i % 7 == 0) {
                    fall.ignored = std::slice::from_ref(&hit.slot);
                    assert!(
                        stacks
                            .first_contact(&fall)
                            .is_none_or(|h| h.slot != hit.slot && h.height <= hit.height)
                    );
                }
            }
            let center = DVec3::new(x, f64::from(corner[1] + below(c, 4 * R)), z);
            let reach = f64::from(below(a ^ b, 3 * R));
            let mut found = Vec::new();
            stacks.near(center, reach, &mut found);
            let mut found: Vec<_> = found.into_iter().map(|(_, g)| g).collect();
            let mut expected: Vec<_> = grains
                .iter()
                .flat_map(|&g| images(g, period))
                .filter(|g| {
                    let [x, y, z] = g.center.map(f64::from);
                    let widest = reach + f64::from(g.radius);
                    (DVec3::new(x, y, z) - center).length_squared() <= widest * widest
                })
                .collect();
            found.sort_unstable();
            expected.sort_unstable();
            assert_eq!(found, expected);
        }
    }
}

#[test]
fn queries_equal_a_search_of_all_grains() {
    let (width, corner) = (20 * R, [-3_000_123, -50_000, 7_000_000]);
    let grains = scattered(1500, corner, width, 8 * R);
    let plan =
        PlanRectangle { min: [corner[0], corner[2]], max: [corner[0] + width, corner[2] + width] };
    for side in [2 * R as u16, 50_000] {
        let mut stacks = GrainStacks::new(plan, side, [0.0; 2]).unwrap();
        compare_with_brute_force(&mut stacks, &grains, corner, width);
        assert_eq!(stacks.len(), 1500);
        let (mut kept, mut given): (Vec<_>, _) = (stacks.iter().collect(), grains.clone());
        kept.sort_unstable();
        given.sort_unstable();
        assert_eq!(kept, given);
    }
}

#[test]
fn queries_on_a_periodic_plan_see_every_image() {
    let side = 2 * R as u16 + 77;
    let width = 8 * i32::from(side);
    let corner = [-123_456, 1_000_000, 99];
    let grains = scattered(800, corner, width, 8 * R);
    let mut stacks = GrainStacks::periodic([corner[0], corner[2]], [8, 8], side, [0.0; 2]).unwrap();
    assert_eq!(stacks.period(), Some([width, width]));
    compare_with_brute_force(&mut stacks, &grains, corner, width);
}

#[test]
fn the_plan_grows_around_grains_that_stay() {
    let plan = PlanRectangle { min: [0, 0], max: [10 * R, 10 * R] };
    let mut stacks = GrainStacks::new(plan, 2 * R as u16, [0.0; 2]).unwrap();
    let near = QuantisedGrain { center: [R, 0, 5 * R], radius: R as u16 };
    let far = QuantisedGrain { center: [-40 * R, 3, 77 * R], radius: R as u16 };
    stacks.push(near).unwrap();
    assert_eq!(stacks.push(far), Err(GrainStacksError::OutsideArea));
    stacks.cover(PlanRectangle { min: [-40 * R, 0], max: [0, 77 * R] }).unwrap();
    stacks.push(far).unwrap();
    for grain in [near, far] {
        let hit = stacks.ray_down(grain.center[0].into(), grain.center[2].into()).unwrap();
        assert_eq!((hit.grain, hit.height), (grain, f64::from(grain.center[1] + R)));
    }
    let too_much = PlanRectangle { min: [-(1 << 30); 2], max: [1 << 30; 2] };
    assert!(matches!(stacks.cover(too_much), Err(GrainStacksError::AreaTooLarge { .. })));
    assert_eq!(stacks.len(), 2);
}

/// The contact of a sphere that falls along a leaning line, by asking every grain: the highest root
/// of the distance to the grain along the line.
fn brute_leaning_contact(
    grains: &[QuantisedGrain],
    period: Option<[i32; 2]>,
    drift: [f64; 2],
    fall: &Fall<'_>,
) -> Option<f64> {
    let line = DVec3::new(drift[0], 1.0, drift[1]);
    grains
        .iter()
        .flat_map(|&g| images(g, period))
        .filter_map(|g| {
            let reach = f64::from(g.radius) + fall.radius;
            let offset =
                DVec3::new(fall.x, 0.0, fall.z) - DVec3::from_array(g.center.map(f64::from));
            let (a, b) = (line.length_squared(), offset.dot(line));
            let nearest = (offset - line * (b / a)).length_squared();
            let square = (reach * reach - nearest) / a;
            (square >= 0.0).then(|| -b / a + square.sqrt())
        })
        .max_by(f64::total_cmp)
}

#[test]
fn leaning_falls_equal_a_search_of_all_grains() {
    let (width, corner) = (20 * R, [-300_123, -50_000, 700_000]);
    let grains = scattered(1500, corner, width, 8 * R);
    for drift in [[0.3, 0.0], [0.0, -2.0], [-3.0, 1.0]] {
        for periodic in [false, true] {
            let side = 2 * R as u16 + 200;
            let mut stacks = if periodic {
                let corner = [corner[0], corner[2]];
                GrainStacks::periodic(corner, [10, 10], side, drift).unwrap()
            } else {
                let plan = PlanRectangle { min: [-60 * R; 2], max: [60 * R; 2] };
                GrainStacks::new(plan, side, drift).unwrap()
            };
            for &grain in &grains {
                stacks.cover_grain(grain, 0).unwrap();
                stacks.push(grain).unwrap();
            }
            let period = stacks.period();
            let mut met = 0;
            for level in SimdLevel::available() {
                stacks.set_level(level);
                for i in 0..100 {
                    let [a, b, c] = words(4, i);
                    // Through a point among the grains.
                    let y = f64::from(corner[1] + below(c, 8 * R));
                    let x = f64::from(corner[0] + below(a, width)) - y * drift[0];
                    let z = f64::from(corner[2] + below(b, width)) - y * drift[1];
                    for radius in [0.0, f64::from(below(c, R))] {
                        let fall = Fall::from_above(x, z, radius);
                        let found = stacks.first_contact(&fall).map(|hit| hit.height);
                        let expected = brute_leaning_contact(&grains, period, drift, &fall);
                        // A period of ten cells has images beyond the nine that are asked.
                        let near = |(f, e): (f64, f64)| (f - e).abs() < 1e-3 || periodic && f > e;
                        assert!(
                            found
                                .zip(expected)
                                .map_or(found.is_none() == expected.is_none() || periodic, near),
                            "{found:?} {expected:?} {drift:?}"
                        );
                        met += usize::from(found.is_some());
                    }
                    let center = stacks.point(x, z, y);
                    let reach = f64::from(below(a ^ b, 2 * R));
                    let mut found = Vec::new();
                    stacks.near(center, reach, &mut found);
                    let expected = grains.iter().flat_map(|&g| images(g, period)).filter(|g| {
                        let offset = DVec3::from_array(g.center.map(f64::from)) - center;
                        let widest = reach + f64::from(g.radius);
                        offset.length_squared() <= widest * widest
                    });
                    assert_eq!(found.len(), expected.count());
                }
            }
            assert!(met > 100);
            let (mut kept, mut given): (Vec<_>, _) = (stacks.iter().collect(), grains.clone());
            if !periodic {
                kept.sort_unstable();
                given.sort_unstable();
                assert_eq!(kept, given);
            }
        }
    }
}

#[test]
fn regions_own_every_grain_once_and_pops_take_the_newest() {
    let plan = PlanRectangle { min: [0, 0], max: [100 * 2 * R, 70 * 2 * R] };
    let mut stacks = GrainStacks::new(plan, 2 * R as u16, [0.0; 2]).unwrap();
    let grains = scattered(5000, [0; 3], 140 * R, 4 * R);
    stacks.expect_radius(R as u16);
    for shifted in [false, true] {
        for edge in [RegionEdge::Short, RegionEdge::Long] {
            let layout = stacks.layout(edge, shifted);
            let mut regions = stacks.regions(&layout);
            assert_eq!(regions.len(), layout.len());
            let before = grains.len();
            for grain in &grains {
                let [x, _, z] = grain.center.map(f64::from);
                let home = layout.home(x, z).unwrap();
                regions[home].push(*grain).unwrap();
                let owners =
                    regions.iter_mut().map(|r| usize::from(r.push(*grain).is_ok())).sum::<usize>();
                assert_eq!(owners, 1);
            }
            drop(regions);
            assert_eq!(stacks.len(), 2 * before as u64);
            for grain in grains.iter().chain(&grains) {
                stacks.pop(*grain);
            }
            assert!(stacks.is_empty() && stacks.ray_down(1e5, 1e5).is_none());
        }
    }
}

#[test]
fn a_grain_that_is_nearly_met_does_not_hide_one_that_is() {
    // The highest of these is missed by less than single precision can tell.
    let plan = PlanRectangle { min: [-174_400; 2], max: [305_000; 2] };
    let mut stacks = GrainStacks::new(plan, 52_320, [0.0, -2.0]).unwrap();
    stacks.expect_radius(10_900);
    let grains = [
        ([102_904, 28_565, 31_958], 10_312),
        ([57_585, 52_641, -15_180], 10_055),
        ([100_074, 28_858, 17_731], 8_463),
        ([85_363, 28_393, 5_086], 9_281),
        ([93_837, 42_547, -6_422], 10_833),
    ];
    for (center, radius) in grains {
        stacks.push(QuantisedGrain { center, radius }).unwrap();
    }
    let hit = stacks.ray_down(103_020.0, 65_809.0).unwrap();
    assert_eq!(hit.grain.center, [100_074, 28_858, 17_731]);
}
