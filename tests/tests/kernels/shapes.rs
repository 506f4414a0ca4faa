//! Light among grains of other shapes than spheres: the kernel against the oracle, and exact identities.

use super::ETA;
use super::paths::{self, on_sphere};
use snowgrain_accel::{GrainGrid, Packing, ShapedGrains, SimdLevel, SurfaceShape, Surfaces};
use snowgrain_geometry::{Grain, GrainShape, Quantisation, QuantisedGrain, Shape, ShapeKind};
use snowgrain_math::sampler::{PathKey, numbers};
use snowgrain_math::{Aabb, DAffine3, DVec3, Ray, frame};
use snowgrain_render::laboratory::scattering;
use snowgrain_render::transport::{self, NewPath, PathResult, PathSource};
use snowgrain_render::{Material, World};
use snowgrain_tests::statistics::{Estimate, estimate};
use snowgrain_tests::{OracleShape, OracleSurface, PathEnd, ShapeOracle, ShapedGrain, packs};

/// Every shape, sharp and rounded.
fn kinds() -> Vec<ShapeKind> {
    vec![
        ShapeKind::Sphere,
        ShapeKind::Spheroid { aspect: 0.5 },
        ShapeKind::Spheroid { aspect: 2.0 },
        ShapeKind::Cube { rounding: 0.0 },
        ShapeKind::Cube { rounding: 0.5 },
        ShapeKind::HexagonalPrism { aspect: 0.2, rounding: 0.0 },
        ShapeKind::HexagonalPrism { aspect: 0.2, rounding: 0.7 },
        ShapeKind::HexagonalPrism { aspect: 2.0, rounding: 0.0 },
        ShapeKind::TruncatedOctahedron { rounding: 0.2 },
        ShapeKind::RandomPolyhedron { faces: 20, seed: 5, rounding: 0.0 },
        ShapeKind::Rosette { arms: 4, aspect: 1.5, rounding: 0.0 },
    ]
}

/// Grains, their shapes, and what stands beside them.
struct Case {
    quantisation: Quantisation,
    grains: Vec<QuantisedGrain>,
    shapes: Vec<GrainShape>,
    prototypes: Vec<Shape>,
    objects: Vec<(SurfaceShape, OracleShape, [f32; 3])>,
    period: Option<[i64; 2]>,
    /// Paths come from a sphere around this point, aimed at one within.
    around: (DVec3, f64, f64),
    eta: f64,
}

impl Case {
    /// Grains at these places, turned at random, of all these kinds in turn.
    fn new(grains: &[Grain], kinds: &[ShapeKind], around: (DVec3, f64, f64)) -> Self {
        let prototypes: Vec<Shape> = kinds.iter().map(|&kind| Shape::new(kind).unwrap()).collect();
        let reach = prototypes.iter().map(Shape::bounding_radius).fold(0.0, f64::max);
        let largest = grains.iter().map(|grain| grain.radius).fold(0.0, f64::max);
        let quantisation = Quantisation::for_grains(DVec3::ZERO, largest * reach);
        let shape = |index: usize| {
            let [a, b, c] = numbers(PathKey::new(3, index as u64, 0), 0).map(f64::from);
            let quaternion = [a - 0.5, b - 0.5, c - 0.5, 0.4];
            GrainShape::new(index % prototypes.len(), quaternion)
        };
        Self {
            quantisation,
            shapes: (0..grains.len()).map(shape).collect(),
            grains: grains
                .iter()
                .map(|g| quantisation.round(g.center, g.radius).unwrap())
                .collect(),
            prototypes,
            objects: Vec::new(),
            period: None,
            around,
            eta: ETA,
        }
    }

    fn world(&self) -> World {
        let shapes: Vec<_> =
            self.objects.iter().map(|(s, _, _)| (s.clone(), DAffine3::IDENTITY)).collect();
        let surfaces = Surfaces::new(&shapes);
        let shaped = ShapedGrains { prototypes: &self.prototypes, of_grains: &self.shapes };
        let grid = GrainGrid::build_shaped(
            self.quantisation,
            (&self.grains, shaped),
            (&surfaces, &[]),
            self.period,
            Packing::Fast,
        );
        let materials = self.objects.iter().map(|o| Material::diffuse(o.2)).collect();
        World { grid: grid.unwrap(), surfaces, materials, emitters: Vec::new(), eta: self.eta }
    }

    fn oracle(&self) -> ShapeOracle {
        let grain = |(&grain, shape): (&QuantisedGrain, &GrainShape)| {
            let Grain { center, radius } = self.quantisation.grain(grain);
            let prototype = self.prototypes[shape.prototype()].clone();
            ShapedGrain { center, radius, rotation: shape.rotation(), shape: prototype }
        };
        let surface = |(_, shape, albedo): &(SurfaceShape, OracleShape, [f32; 3])| OracleSurface {
            shape: shape.clone(),
            albedo: DVec3::from_array(albedo.map(f64::from)),
        };
        let surfaces: Vec<_> = self.objects.iter().map(surface).collect();
        ShapeOracle::new(
            self.grains.iter().zip(&self.shapes).map(grain).collect(),
            &surfaces,
            self.eta,
        )
    }

    /// The first ray of a path, which takes its events 0 and 1.
    fn start(&self, key: PathKey) -> Ray {
        let (center, outer, inner) = self.around;
        let origin = center + on_sphere(numbers(key, 0)) * outer;
        let target = center + on_sphere(numbers(key, 1)) * inner;
        Ray::new(origin, (target - origin).normalize())
    }

    fn trace(&self, level: SimdLevel, paths: u64) -> Vec<PathResult> {
        paths::trace(&self.world(), level, paths, |key| self.start(key))
    }

    /// An even field of light around the box of the grid: mean length in air within the box, arrivals at
    /// grains, length in ice, the sum of the first two, each a path; and the hull's surface and volume.
    fn in_even_light(&self, paths: u64) -> ([Estimate; 4], [f64; 2]) {
        let world = self.world();
        let hull = world.grid.bounds();
        let lines = |first: u64| {
            let end = paths.min(first + 4096);
            let (next, sums) = (first, vec![[0.0; 4]; (end - first) as usize]);
            let mut source = EvenLight { hull, first, next, end, sums };
            transport::trace(&world, SimdLevel::detect(), &mut source);
            source.sums
        };
        let rows: Vec<[f64; 4]> = (0..paths).step_by(4096).flat_map(lines).collect();
        let size = hull.size();
        let surface = 2.0 * (size.x * size.y + size.y * size.z + size.z * size.x);
        (estimate(paths, |index| rows[index as usize]), [surface, size.element_product()])
    }

    /// Compares every path that ends after a few interfaces number by number, and all in the mean.
    fn agrees_with_oracle(&self, paths: u64) {
        let oracle = self.oracle();
        let unit = self.quantisation.largest_radius();
        let (mut short, mut wrong) = (0u32, 0u32);
        let mut sums = [[0.0; 3]; 2];
        for (tag, fast) in self.trace(SimdLevel::detect(), paths).iter().enumerate() {
            let key = paths::key(tag as u64);
            let start = self.start(key);
            let exact = oracle.trace(start.origin, start.direction, key, 2);
            assert!(exact.end != PathEnd::Trapped && fast.releases == 0);
            let numbers = |ice: f64, events: u32, visits: u32| {
                [ice / unit, f64::from(events), f64::from(visits)]
            };
            let rows = [
                numbers(fast.ice_length, fast.interface_events, fast.grain_visits),
                numbers(exact.ice_length, exact.interface_events, exact.grain_visits),
            ];
            for (sum, row) in sums.iter_mut().zip(rows) {
                sum.iter_mut().zip(row).for_each(|(sum, x)| *sum += x);
            }
            if exact.interface_events + exact.diffuse_bounces > 8 {
                continue;
            }
            short += 1;
            let direction = match fast.end {
                transport::PathEnd::Escaped(ray) => Some(ray.direction),
                _ => None,
            };
            // The place where a path enters the grid is rounded to single precision, 1e-7 of a grain, and
            // that grows by up to six at each round interface.
            let same = fast.interface_events == exact.interface_events
                && fast.grain_visits == exact.grain_visits
                && fast.surface_bounces == exact.diffuse_bounces
                && (fast.ice_length - exact.ice_length).abs() < 5e-3 * unit
                && match (direction, exact.escaped_direction()) {
                    (Some(a), Some(b)) => (a - b).length() < 5e-3,
                    (a, b) => a.is_none() == b.is_none(),
                };
            if !same && wrong < 4 {
                println!("{tag} {fast:?}\n   {exact:?}");
            }
            wrong += u32::from(!same);
        }
        assert!(short > paths as u32 / 4, "{short} short paths");
        // A random number lies between two reflectances that differ by 1e-6 once in 10^6 events, and a path
        // meets an edge to 1e-6 of a grain as rarely.
        assert!(wrong <= 1, "{wrong} of {short} short paths differ");
        let [fast, exact] = sums;
        for (name, (fast, exact)) in ["ice", "events", "visits"].iter().zip(fast.iter().zip(exact))
        {
            let ratio = fast / exact;
            assert!((ratio - 1.0).abs() < 0.02, "{name}: ratio {ratio}");
        }
    }
}

/// Grains strewn at random that overlap, all shapes among them.
fn heap() -> Case {
    let grains = packs::strewn(150, DVec3::splat(4.0), [0.15, 0.45], 3);
    Case::new(&grains, &kinds(), (DVec3::splat(2.0), 6.0, 2.0))
}

/// Plates that overlap and lie level, whose bases lie in a few planes.
fn level_plates() -> Case {
    let mut grains = packs::strewn(150, DVec3::splat(4.0), [0.45, 0.45], 3);
    grains.iter_mut().for_each(|grain| grain.center.y = (2.0 * grain.center.y).round() / 2.0);
    let plate = ShapeKind::HexagonalPrism { aspect: 0.3, rounding: 0.2 };
    let mut case = Case::new(&grains, &[plate], (DVec3::splat(2.0), 6.0, 2.0));
    for (index, shape) in case.shapes.iter_mut().enumerate() {
        let [a, b, _] = numbers(PathKey::new(4, index as u64, 0), 0).map(f64::from);
        *shape = GrainShape::new(0, [0.0, a - 0.5, 0.0, b]);
    }
    case
}

#[test]
fn separate_grains_of_each_shape_agree_with_the_oracle() {
    for kind in kinds() {
        let grains: Vec<Grain> = packs::simple_cubic([3, 3, 3], 1.0)
            .iter()
            .map(|grain| Grain { center: grain.center * 2.0, radius: 1.0 })
            .collect();
        Case::new(&grains, &[kind], (DVec3::splat(6.0), 14.0, 6.0)).agrees_with_oracle(1500);
    }
}

#[test]
fn overlapping_grains_of_all_shapes_agree_with_the_oracle() {
    heap().agrees_with_oracle(4000);
}

#[test]
fn grains_beside_surfaces_agree_with_the_oracle() {
    let mut case = heap();
    case.objects = vec![(
        SurfaceShape::Plane,
        OracleShape::Plane { point: DVec3::ZERO, normal: DVec3::Y },
        [0.8, 0.5, 0.2],
    )];
    case.agrees_with_oracle(3000);
}

#[test]
fn water_between_grains_agrees_with_the_oracle() {
    let mut case = heap();
    case.eta = 1.31 / 1.333;
    case.agrees_with_oracle(1500);
}

#[test]
fn nothing_is_lost_or_trapped_and_every_simd_level_gives_the_same_bits() {
    let case = heap();
    let best = case.trace(SimdLevel::detect(), 3000);
    for result in &best {
        assert!(matches!(result.end, transport::PathEnd::Escaped(_)), "{result:?}");
        assert_eq!((result.throughput, result.releases), ([1.0; 3], 0));
    }
    for level in SimdLevel::available() {
        let same = format!("{:?}", case.trace(level, 3000)) == format!("{best:?}");
        assert!(same, "{level}");
    }
}

/// Where the faces of two grains lie in one plane, rounding says which of them is left first. Light once went to and fro
/// between them for ever.
#[test]
fn light_leaves_grains_whose_faces_lie_in_one_plane() {
    let case = level_plates();
    case.agrees_with_oracle(4000);
    for result in case.trace(SimdLevel::detect(), 1 << 16) {
        assert!(matches!(result.end, transport::PathEnd::Escaped(_)), "{result:?}");
        assert!(result.grain_visits < 1000, "{result:?}");
    }
}

/// Lines of an even field that enter a box.
struct EvenLight {
    hull: Aabb,
    first: u64,
    next: u64,
    end: u64,
    sums: Vec<[f64; 4]>,
}

impl PathSource for EvenLight {
    type Tag = u64;

    fn next_path(&mut self) -> Option<NewPath<u64>> {
        if self.next == self.end {
            return None;
        }
        let tag = self.next;
        self.next += 1;
        let key = PathKey::new(17, tag, 0);
        let [pick, u, v] = numbers(key, 0).map(f64::from);
        let [_, a, b] = numbers(key, 1).map(f64::from);
        let size = self.hull.size();
        let areas = [size.y * size.z, size.z * size.x, size.x * size.y];
        let mut left = pick * (areas[0] + areas[1] + areas[2]);
        let mut axis = 0;
        while axis < 2 && left >= areas[axis] {
            left -= areas[axis];
            axis += 1;
        }
        let upper = left > 0.5 * areas[axis];
        let mut point = self.hull.min;
        point[(axis + 1) % 3] += size[(axis + 1) % 3] * u;
        point[(axis + 2) % 3] += size[(axis + 2) % 3] * v;
        point[axis] = if upper { self.hull.max[axis] } else { self.hull.min[axis] };
        let mut inward = DVec3::ZERO;
        inward[axis] = if upper { -1.0 } else { 1.0 };
        let direction = frame::cosine_hemisphere(inward, [a, b]);
        Some(NewPath { tag, ray: Ray::new(point, direction), key, event: 2 })
    }

    fn finish(&mut self, tag: u64, path: &PathResult) {
        let (air, visits) = (path.air_length, f64::from(path.grain_visits));
        let row = [air, visits, path.ice_length, air + visits];
        self.sums[(tag - self.first) as usize] = row;
    }
}

/// In an even field the mean chord of air is 4 V_air / S and the mean length in ice at most n^2 times that of
/// straight lines, whatever the grains are like: identities of equilibrium. 4 sigma: 1 in 16 000 seeds each.
#[test]
fn chords_between_grains_of_each_shape_are_those_of_the_chord_theorem() {
    for kind in kinds() {
        let places: Vec<Grain> = packs::simple_cubic([3, 3, 3], 1.0)
            .iter()
            .map(|grain| Grain { center: grain.center * 2.0, radius: 1.0 })
            .collect();
        let case = Case::new(&places, &[kind], (DVec3::ZERO, 1.0, 1.0));
        let ([air, visits, ice, sum], [surface, volume]) = case.in_even_light(40_000);
        let radius = case.quantisation.grain(case.grains[0]).radius;
        let grain = &case.prototypes[0];
        let ice_volume = 27.0 * Shape::VOLUME * radius * radius * radius;
        let ice_surface = 27.0 * grain.surface_area() * radius * radius;
        let is_union = grain.parts().len() > 1;
        let slack = if is_union { 0.01 } else { 0.001 };
        let expected = 4.0 * (volume - ice_volume) / surface;
        assert!(air.agrees_with(expected, slack * expected, 4.0), "{kind:?} {air:?} {expected}");
        let expected = ice_surface / surface;
        assert!(
            visits.agrees_with(expected, slack * expected, 4.0),
            "{kind:?} {visits:?} {expected}"
        );
        let chord = Estimate::ratio(air, visits, sum);
        let theorem = 4.0 * (volume - ice_volume) / ice_surface;
        assert!(chord.agrees_with(theorem, slack * theorem, 4.0), "{kind:?} {chord:?} {theorem}");
        let most = ETA * ETA * 4.0 * ice_volume / surface;
        assert!(ice.mean < most + 4.0 * ice.standard_error, "{kind:?} {ice:?} {most}");
    }
}

#[test]
fn a_sphere_that_is_traced_as_a_shape_scatters_as_its_closed_form_says() {
    let sphere = Shape::new(ShapeKind::Spheroid { aspect: 1.0 }).unwrap();
    let found = scattering(&sphere, 1.31, 6, (200_000, 1), SimdLevel::detect());
    let near = |found: snowgrain_render::measure::Estimate, expected: f64| {
        let error = (found.mean - expected).abs();
        assert!(error < 4.0 * found.standard_error + 2e-4, "{found:?} {expected}");
    };
    near(found.asymmetry, 0.78166);
    near(found.enhancement, 1.2535);
    near(found.projected_area, core::f64::consts::PI);
    near(found.interface_events, 2.0);
    let medium = snowgrain_optics::Dielectric { eta: 1.31 };
    let polarisation = snowgrain_optics::sphere::Polarisation::Redrawn;
    let energies = snowgrain_optics::sphere::energy_by_angle(medium, polarisation, 6);
    for (found, expected) in found.energy_by_angle.iter().zip(energies) {
        near(*found, expected);
    }
}

#[test]
fn convex_shapes_absorb_at_most_n_squared_and_cast_a_quarter_of_their_surface() {
    for kind in kinds() {
        let shape = Shape::new(kind).unwrap();
        let found = scattering(&shape, 1.31, 1, (40_000, 2), SimdLevel::detect());
        let shadow = found.projected_area;
        let error = (shadow.mean - shape.mean_projected_area()).abs();
        assert!(error < 4.0 * shadow.standard_error + 2e-3, "{kind:?} {shadow:?}");
        if let [_] = shape.parts() {
            assert!((shape.surface_area() / 4.0 - shape.mean_projected_area()).abs() < 1e-12);
            let most = 1.31 * 1.31 + 4.0 * found.enhancement.standard_error;
            assert!(found.enhancement.mean < most, "{kind:?} {:?}", found.enhancement);
        }
    }
}

/// Every direction in a prism of ice meets some pair of faces at less than the critical angle, so light fills it
/// evenly: B = n^2. In a cube some directions are shut off. 4 sigma: 1 in 16 000 seeds.
#[test]
fn prisms_absorb_n_squared_times_as_much_as_the_mean_chord_and_cubes_less() {
    let enhancement = |kind| {
        let shape = Shape::new(kind).unwrap();
        scattering(&shape, 1.31, 1, (150_000, 4), SimdLevel::detect()).enhancement
    };
    let square = 1.31 * 1.31;
    for aspect in [0.3, 1.0, 3.0] {
        let found = enhancement(ShapeKind::HexagonalPrism { aspect, rounding: 0.0 });
        assert!((found.mean - square).abs() < 4.0 * found.standard_error, "{aspect} {found:?}");
        assert!(found.standard_error < 0.02);
    }
    // The directions all of whose cosines are below that of the critical angle.
    let critical = (1.0f64 - 1.0 / square).sqrt();
    let [shut] = estimate(200_000, |index| {
        let [a, b, _] = numbers(PathKey::new(6, index, 0), 0).map(f64::from);
        let ring = (1.0 - a * a).sqrt();
        let (sin, cos) = snowgrain_math::trig::sin_cos(core::f64::consts::TAU * b);
        let most = a.max((ring * sin).abs()).max((ring * cos).abs());
        [f64::from(u8::from(most < critical))]
    });
    let found = enhancement(ShapeKind::Cube { rounding: 0.0 });
    let expected = square * (1.0 - shut.mean);
    let sigma = found.standard_error + square * shut.standard_error;
    assert!((found.mean - expected).abs() < 4.0 * sigma, "{found:?} {expected}");
}

/// Hexagonal prisms by the kernel and by the oracle, on independent lines: 4 sigma of the difference.
#[test]
fn prisms_scatter_as_an_independent_tracer_says() {
    for aspect in [0.2, 2.0] {
        let shape = Shape::new(ShapeKind::HexagonalPrism { aspect, rounding: 0.0 }).unwrap();
        let found = scattering(&shape, 1.31, 1, (120_000, 3), SimdLevel::detect());
        let reach = shape.bounding_radius();
        let grain = ShapedGrain {
            center: DVec3::ZERO,
            radius: 1.0,
            rotation: GrainShape::upright(0).rotation(),
            shape,
        };
        let oracle = ShapeOracle::new(vec![grain], &[], 1.31);
        let lines = estimate(40_000, |index| {
            let key = PathKey::new(77, index, 0);
            let [a, b, _] = numbers(key, 0).map(f64::from);
            let y = 1.0 - 2.0 * a;
            let (sin, cos) = snowgrain_math::trig::sin_cos(core::f64::consts::TAU * b);
            let ring = (1.0 - y * y).max(0.0).sqrt();
            let direction = DVec3::new(ring * cos, y, ring * sin).normalize();
            let (s, t) = frame::tangents(direction);
            let [u, v, _] = numbers(key, 1).map(f64::from);
            // Uniform over the disc: the projection of a cosine-distributed direction.
            let aside = frame::cosine_hemisphere(DVec3::Z, [u, v]);
            let origin = (s * aside.x + t * aside.y) * reach - direction * (3.0 * reach);
            let path = oracle.trace(origin, direction, key, 2);
            let met = f64::from(u8::from(path.grain_visits > 0));
            let cosine = path.escaped_direction().map_or(0.0, |out| out.dot(direction));
            [met * cosine, met, met * (cosine + 1.0)]
        });
        let expected = Estimate::ratio(lines[0], lines[1], lines[2]);
        let error = (found.asymmetry.mean - expected.mean).abs();
        let sigma = found.asymmetry.standard_error + expected.standard_error;
        assert!(error < 4.0 * sigma, "{aspect} {:?} {expected:?}", found.asymmetry);
    }
}

#[test]
fn light_is_not_lost_around_objects_that_stand_in_shaped_grains() {
    let mut case = heap();
    let mesh = OracleShape::Plane { point: DVec3::ZERO, normal: DVec3::Y };
    case.objects = vec![
        (SurfaceShape::Plane, mesh.clone(), [1.0; 3]),
        (SurfaceShape::Sphere, mesh.clone(), [1.0; 3]),
        (SurfaceShape::Box, mesh, [1.0; 3]),
    ];
    case.around = (DVec3::new(2.0, 4.0, 2.0), 2.9, 2.0);
    for result in case.trace(SimdLevel::detect(), 4000) {
        assert!(matches!(result.end, transport::PathEnd::Escaped(_)), "{result:?}");
        assert_eq!((result.throughput, result.releases), ([1.0; 3], 0));
    }
}

/// A cube that is cut into two and three cells, among other cubes: light goes from cell to cell as through one body, with
/// the same random numbers to the same ends.
#[test]
fn a_cube_in_cells_sends_light_where_the_whole_one_does() {
    let cube = ShapeKind::Cube { rounding: 0.0 };
    let axes = [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z];
    let faces: String =
        axes.iter().map(|n| format!(" {:e} {:e} {:e} 1e0", n.x, n.y, n.z)).collect();
    let [lower, upper] = [" 6e-1 8e-1 0e0 2e-1", " -6e-1 -8e-1 0e0 -2e-1"];
    let [left, right] = [" 0e0 6e-1 -8e-1 1e-1", " 0e0 -6e-1 8e-1 -1e-1"];
    let two = format!("cells 2 7{faces}{lower} 7{faces}{upper}");
    let three = format!("cells 3 7{faces}{lower} 8{faces}{upper}{left} 8{faces}{upper}{right}");
    let grains = packs::strewn(60, DVec3::splat(3.0), [0.15, 0.45], 5);
    let mut case = Case::new(&grains, &[cube], (DVec3::splat(1.5), 5.0, 1.5));
    let whole = case.trace(SimdLevel::detect(), 4000);
    for name in [two, three] {
        let cut = Shape::of_name(&name).unwrap();
        assert!((cut.surface_area() / case.prototypes[0].surface_area() - 1.0).abs() < 1e-9);
        case.prototypes = vec![cut];
        let parted = case.trace(SimdLevel::detect(), 4000);
        let mut differ = 0u32;
        for (a, b) in whole.iter().zip(&parted) {
            let (transport::PathEnd::Escaped(from), transport::PathEnd::Escaped(to)) =
                (a.end, b.end)
            else {
                unreachable!("light escapes from clear grains")
            };
            let same = (a.interface_events, a.grain_visits) == (b.interface_events, b.grain_visits)
                && (a.ice_length - b.ice_length).abs() < 1e-6
                && (from.direction - to.direction).length() < 1e-6;
            differ += u32::from(!same);
        }
        // The last bits of sizes and places differ, which long paths make larger.
        assert!(differ <= 4, "{differ} of 4000 paths differ");
    }
}
