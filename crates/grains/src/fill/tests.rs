use super::*;
use crate::Radii;
use crate::measures::{Slab, union_solid_fraction};
use snowgrain_accel::{Extent, Surfaces};
use snowgrain_geometry::TriangleMesh;
use snowgrain_geometry::teapot::teapot;
use snowgrain_math::sampler::pcg3d;
use std::sync::LazyLock;

const R: f64 = 0.5e-3;

/// A box as a mesh, facing outwards.
fn block(min: DVec3, max: DVec3) -> TriangleMesh {
    let corner = |index: u32| {
        let of = |axis: usize| if index >> axis & 1 == 0 { min[axis] } else { max[axis] };
        DVec3::new(of(0), of(1), of(2))
    };
    let quads =
        [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let triangles = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    TriangleMesh::new((0..8).map(corner).collect(), triangles).unwrap()
}

/// A ball of radius 1 about 0 of about `8 steps^2` triangles.
fn ball(steps: u32) -> TriangleMesh {
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for octant in 0..8 {
        let sign = |axis: u32| if octant >> axis & 1 == 0 { 1.0 } else { -1.0 };
        let (x, y, z) = (sign(0), sign(1), sign(2));
        // Whole numbers, so that octants share their edges to the last bit.
        let at = |i: u32, j: u32| {
            let [a, b, c] = [steps - i - j, i, j].map(f64::from);
            DVec3::new(x * a, y * b, z * c).normalize()
        };
        let mut push = |mut corners: [DVec3; 3]| {
            if x * y * z < 0.0 {
                corners.swap(1, 2);
            }
            let first = positions.len() as u32;
            positions.extend(corners);
            triangles.push([first, first + 1, first + 2]);
        };
        for i in 0..steps {
            for j in 0..steps - i {
                push([at(i, j), at(i + 1, j), at(i, j + 1)]);
                if i + j + 1 < steps {
                    push([at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]);
                }
            }
        }
    }
    TriangleMesh::new(positions, triangles).unwrap()
}

fn unit(word: u32) -> f64 {
    f64::from(word) / 4_294_967_296.0
}

/// The pack of all tests, made once.
static PACK: LazyLock<PeriodicPack> = LazyLock::new(|| {
    let quantum = Quantisation::for_grains(DVec3::ZERO, R).quantum();
    settings(Body::Box(Aabb::EMPTY)).pack.make(quantum).unwrap()
});

/// The grains of a body.
fn filled(settings: &FillSettings) -> GrainField {
    let quantisation = Quantisation::for_grains(DVec3::ZERO, R);
    GrainField::new(quantisation, PACK.within(&quantisation, settings).unwrap())
}

fn settings(body: Body) -> FillSettings {
    let pack = PackSettings { radii: Radii::equal(R), density: 250.0, seed: 1 };
    FillSettings { pack, body, mask: None, density_map: None }
}

#[test]
fn a_box_holds_what_lies_between_its_faces_whichever_way_it_is_turned() {
    let mesh = block(DVec3::new(-1.0, 0.0, 2.0), DVec3::new(1.0, 3.0, 2.5));
    let inside_out = TriangleMesh {
        triangles: mesh.triangles.iter().map(|&[a, b, c]| [a, c, b]).collect(),
        ..mesh.clone()
    };
    for mesh in [mesh, inside_out] {
        let solid = Solid::new(&mesh).unwrap();
        for i in 0..2000 {
            let [x, y, z] = pcg3d(i, 0, 0).map(unit);
            let point = DVec3::new(3.0 * x - 1.5, 4.0 * y - 0.5, z + 1.75);
            let within = point.x.abs() < 1.0
                && (0.0..3.0).contains(&point.y)
                && (2.0..2.5).contains(&point.z);
            assert_eq!(solid.holds(point).unwrap(), within, "{point}");
        }
        // Under edges and diagonals of the faces.
        for point in [DVec3::new(0.0, 1.0, 2.25), DVec3::new(0.5, 1.0, 2.125)] {
            assert!(solid.holds(point).unwrap());
        }
    }
}

#[test]
fn a_ball_of_triangles_holds_what_is_near_its_middle() {
    let solid = Solid::new(&ball(16)).unwrap();
    for i in 0..20_000 {
        let point = DVec3::from(pcg3d(i, 1, 0).map(unit)) * 2.0 - 1.0;
        let held = solid.holds(point).unwrap();
        assert!(held == (point.length() < 1.0) || (point.length() - 1.0).abs() < 0.01, "{point}");
    }
    for point in [DVec3::ZERO, DVec3::X * 0.5, DVec3::Z * 0.5, DVec3::new(0.25, 0.1, -0.25)] {
        assert!(solid.holds(point).unwrap(), "{point}");
    }
}

#[test]
fn meshes_that_are_open_or_cross_themselves_are_refused() {
    let mut open = block(DVec3::ZERO, DVec3::ONE);
    open.triangles.pop();
    let message = Solid::new(&open).unwrap_err().to_string();
    assert!(message.contains("not closed") && message.contains("the edge from"), "{message}");
    assert!(Solid::new(&teapot(4)).is_err());
    let mut turned = block(DVec3::ZERO, DVec3::ONE);
    turned.triangles[0].swap(0, 1);
    assert!(Solid::new(&turned).is_err());
    let (a, b) = (block(DVec3::ZERO, DVec3::ONE), block(DVec3::splat(0.5), DVec3::splat(1.5)));
    let positions = [a.positions.clone(), b.positions].concat();
    let others = b.triangles.iter().map(|t| t.map(|v| v + 8));
    let triangles = a.triangles.iter().copied().chain(others).collect();
    let both = Solid::new(&TriangleMesh::new(positions, triangles).unwrap()).unwrap();
    assert!(both.holds(DVec3::splat(0.25)).unwrap());
    let message = both.holds(DVec3::splat(0.75)).unwrap_err().to_string();
    assert!(message.contains("crosses itself"), "{message}");
}

#[test]
fn pieces_of_a_body_are_together_what_the_whole_is() {
    let grains = |bodies: &[(DVec3, DVec3)]| {
        let of = |&(min, max): &(DVec3, DVec3)| {
            filled(&settings(Body::Box(Aabb::new(min, max)))).into_grains()
        };
        let mut all: Vec<QuantisedGrain> = bodies.iter().flat_map(of).collect();
        all.sort_unstable();
        all
    };
    let (low, high) = (DVec3::new(-0.02, 0.0, -0.015), DVec3::new(0.03, 0.02, 0.015));
    let middle = 0.0042;
    let whole = grains(&[(low, high)]);
    let cut = [(low, DVec3::new(middle, high.y, high.z)), (DVec3::new(middle, low.y, low.z), high)];
    assert_eq!(grains(&cut), whole);
    let volume = 0.05 * 0.02 * 0.03;
    let ball = 4.0 / 3.0 * core::f64::consts::PI * R * R * R;
    let density = ICE_DENSITY * whole.len() as f64 * ball / volume;
    assert!((density / 250.0 - 1.0).abs() < 0.02, "{density}");
}

#[test]
fn a_mesh_and_a_box_hold_the_same_grains_and_heights_are_filled_up_where_the_mask_lets() {
    let fill =
        |body: Body, mask: Option<Arc<PlanImage>>| filled(&FillSettings { mask, ..settings(body) });
    let (low, high) = (DVec3::new(-0.011, 0.001, -0.012), DVec3::new(0.013, 0.02, 0.014));
    let boxed = fill(Body::Box(Aabb::new(low, high)), None);
    let meshed = fill(Body::Solid(Arc::new(Solid::new(&block(low, high)).unwrap())), None);
    assert_eq!(boxed, meshed);
    let nothing = Surfaces::default();
    let mut snow = Snowfall::on_surfaces(boxed.quantisation, &nothing);
    let report = snow.fill(&settings(Body::Box(Aabb::new(low, high)))).unwrap();
    assert!((report.density / 250.0 - 1.0).abs() < 0.01, "{report:?}");
    assert_eq!(snow.into_field(), boxed);
    // A ramp along x from 0 to 20 mm.
    let area = [-0.02, -0.02, 0.02, 0.02];
    let ramp = PlanImage::new([2, 1], vec![0.0, 1.0], area).unwrap();
    let heights = HeightField { image: ramp, height: 0.02, base: 0.0 };
    let mask = PlanImage::new([1, 2], vec![0.0, 1.0], area).unwrap();
    let field = fill(Body::Heights(Arc::new(heights)), Some(Arc::new(mask)));
    for grain in field.iter() {
        let surface = (0.02 * (grain.center.x + 0.01) / 0.02).clamp(0.0, 0.02);
        assert!(grain.center.y < surface + 1e-9 && grain.center.z > -1e-9, "{grain:?}");
    }
    let slab = Slab {
        min: DVec3::new(0.012, 0.002, 0.002),
        max: DVec3::new(0.018, 0.018, 0.018),
        period: None,
    };
    let density = ICE_DENSITY * union_solid_fraction(&field, &slab, 100_000, 0).mean;
    assert!((density / 250.0 - 1.0).abs() < 0.1, "{density}");
}

/// Two squares of heights over the plan from 0 to 2 and 0 to 1, level at .5 and rising to 1.
fn slope() -> TriangleMesh {
    let at = |x: f64, y: f64, z: f64| DVec3::new(x, y, z);
    let positions = vec![
        at(0.0, 0.5, 0.0),
        at(1.0, 0.5, 0.0),
        at(2.0, 1.0, 0.0),
        at(0.0, 0.5, 1.0),
        at(1.0, 0.5, 1.0),
        at(2.0, 1.0, 1.0),
    ];
    TriangleMesh::new(positions, vec![[0, 3, 1], [1, 3, 4], [1, 4, 2], [2, 4, 5]]).unwrap()
}

#[test]
fn an_open_mesh_is_draped_down_to_its_base() {
    let solid = Solid::under(&slope(), -0.5).unwrap();
    // 1 and 1.25 cubic metres.
    assert!((solid.volume() - 2.25).abs() < 1e-12, "{}", solid.volume());
    for (point, within) in [
        ([0.5, 0.49, 0.5], true),
        ([0.5, 0.51, 0.5], false),
        ([1.5, 0.74, 0.25], true),
        ([1.5, 0.76, 0.25], false),
        ([1.0, -0.49, 0.999], true),
        ([1.0, -0.51, 0.5], false),
        ([2.01, 0.0, 0.5], false),
    ] {
        assert_eq!(solid.holds(DVec3::from_array(point)).unwrap(), within, "{point:?}");
    }
    let mut upside_down = slope();
    upside_down.triangles.iter_mut().for_each(|corners| corners.swap(0, 1));
    assert!((Solid::under(&upside_down, -0.5).unwrap().volume() - 2.25).abs() < 1e-12);
    // Where it touches its base there is no wall.
    assert!((Solid::under(&slope(), 0.5).unwrap().volume() - 0.25).abs() < 1e-12);
}

#[test]
fn meshes_that_are_no_heights_are_not_draped() {
    let message =
        |mesh: &TriangleMesh, base: f64| Solid::under(mesh, base).unwrap_err().to_string();
    assert!(
        message(&slope(), 0.6).contains("below the base of 0.6 m"),
        "{}",
        message(&slope(), 0.6)
    );
    let closed = block(DVec3::ZERO, DVec3::ONE);
    let said = message(&closed, -1.0);
    assert!(said.contains("hangs over") || said.contains("is closed"), "{said}");
    let mut folded = slope();
    folded.positions[2] = DVec3::new(0.5, 1.0, 0.0);
    folded.positions[5] = DVec3::new(0.5, 1.0, 1.0);
    assert!(message(&folded, 0.0).contains("hangs over"), "{}", message(&folded, 0.0));
}

#[test]
fn a_density_map_leaves_its_part_of_the_grains_and_none_where_it_is_black() {
    let cube = Body::Box(Aabb::new(DVec3::ZERO, DVec3::splat(0.04)));
    let area = [0.0, 0.0, 0.04, 0.04];
    let map = |values: Vec<f32>| PlanImage::new([values.len(), 1], values, area).unwrap();
    let whole = filled(&settings(cube.clone()));
    let thinned = |values: Vec<f32>| {
        let density_map = Some(Arc::new(map(values).check_parts().unwrap()));
        filled(&FillSettings { density_map, ..settings(cube.clone()) })
    };
    assert_eq!(thinned(vec![1.0]), whole);
    // Four standard deviations of a binomial number: once in 16 000 seeds.
    for part in [0.25f32, 0.7] {
        let (kept, all) = (thinned(vec![part]).len() as f64, whole.len() as f64);
        let expected = f64::from(part) * all;
        let sigma = (expected * (1.0 - f64::from(part))).sqrt();
        assert!((kept - expected).abs() < 4.0 * sigma, "{part}: {kept} of {all}");
    }
    let half = thinned(vec![0.0, 0.0, 1.0, 1.0]);
    assert!(half.iter().all(|grain| grain.center.x > 0.0149), "snow where the map is black");
    let message = map(vec![0.5, 1.5]).check_parts().unwrap_err().to_string();
    assert!(message.contains("column 1, row 0") && message.contains("is 1.5"), "{message}");
}

/// What is told of boxes is true of their points, for bodies of every kind.
#[test]
fn extents_of_boxes_hold_for_all_their_points() {
    let steps = (0..40).map(|i| unit(pcg3d(i, 3, 1)[0]) as f32).collect();
    let image = PlanImage::new([8, 5], steps, [-1.0, -1.0, 1.0, 0.8]).unwrap();
    let heights = HeightField { image, height: 1.5, base: -0.7 };
    let bodies = [
        Body::Box(Aabb::new(DVec3::new(-0.8, -0.5, -0.9), DVec3::new(0.4, 0.9, 0.7))),
        Body::Solid(Arc::new(Solid::new(&ball(12)).unwrap())),
        Body::Heights(Arc::new(heights)),
    ];
    for body in &bodies {
        let mut told = [0; 3];
        for i in 0..3000 {
            let corner = DVec3::from(pcg3d(i, 5, 0).map(unit)) * 2.6 - 1.3;
            let around = Aabb::new(corner, corner + 0.3 * unit(pcg3d(i, 6, 0)[1]));
            let extent = body.extent(&around);
            told[extent as usize] += 1;
            for j in 0..8 {
                let part = DVec3::from(pcg3d(i, j, 7).map(unit));
                let held = body.holds(around.min + part * around.size()).unwrap();
                assert!(extent != Extent::Whole || held, "{body:?} {around:?}");
                assert!(extent != Extent::Empty || !held, "{body:?} {around:?}");
            }
        }
        assert!(told.iter().all(|&count| count > 5), "all three are told: {told:?}");
    }
}
