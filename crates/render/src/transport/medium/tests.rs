//! What light does in a medium, against what it must do.

use super::*;
use crate::measure::{Incidence, SlabMeasure, SlabSettings, measure_slab, measure_slab_in_medium};
use snowgrain_accel::{GrainGrid, Packing, SimdLevel, Surfaces};
use snowgrain_geometry::Quantisation;
use snowgrain_grains::{PackSettings, Radii};

/// Radius of the grains, metres.
const RADIUS: f64 = 0.5e-3;

/// A slab of grains that do not overlap, repeated along x and z.
struct Slab {
    world: World,
    settings: SlabSettings,
    /// N pi r^2 / A.
    tau: f64,
}

impl Slab {
    /// As many periods of a pack on each other as make so many radii.
    fn new(density: f64, depth_radii: f64, paths: u64) -> Self {
        let radii = Radii::Uniform { mean: RADIUS, variation: 0.0 };
        let quantisation = Quantisation::for_grains(DVec3::ZERO, RADIUS);
        let pack = PackSettings { radii, density, seed: 3 }.make(quantisation.quantum()).unwrap();
        let [x, y, z] = pack.period.map(|quanta| quanta as f64 * quantisation.quantum());
        let copies = (depth_radii * RADIUS / y).ceil().max(1.0) as i32;
        let mut grains = Vec::new();
        for copy in 0..copies {
            grains.extend(pack.field.grains().iter().map(|grain| {
                let mut grain = *grain;
                grain.center[1] += copy * pack.period[1] as i32;
                grain
            }));
        }
        let tau = grains.len() as f64 * core::f64::consts::PI * RADIUS * RADIUS / (x * z);
        let period = [pack.period[0], pack.period[2]];
        let grid =
            GrainGrid::build_periodic(quantisation, &grains[..], period, Packing::Fast).unwrap();
        let world = World {
            grid,
            surfaces: Surfaces::default(),
            materials: Vec::new(),
            emitters: Vec::new(),
            eta: 1.31,
        };
        let settings = SlabSettings {
            top: f64::from(copies) * y + RADIUS,
            bottom: -RADIUS,
            period: [x, z],
            incidence: Incidence::Lambertian,
            from_below: false,
            absorption_per_metre: 0.0,
            paths,
            seed: 5,
            level: SimdLevel::detect(),
        };
        Self { world, settings, tau }
    }

    fn medium(&self, kind: MediumKind) -> Medium {
        let lights = Lights::new(
            &[],
            &crate::light::LitSurfaces::new(Vec::new(), &[]),
            [0.0; 3],
            &snowgrain_math::Aabb::EMPTY,
        );
        Medium::new(kind, (&self.world, &[]), (&lights, false)).unwrap()
    }
}

#[test]
#[ignore]
fn look() {
    for fraction in [150.0, 275.0, 400.0, 500.0] {
        for depth in [8.0, 80.0] {
            let slab = Slab::new(fraction, depth, 1 << 16);
            let exact = measure_slab(&slab.world, &slab.settings);
            let show = |name: &str, m: &SlabMeasure| {
                println!(
                    "{fraction} {depth} tau {:.3} {name}: visits/2tau {:.4} +- {:.4}, T {:.4} +- {:.4}, ice {:.4}",
                    slab.tau,
                    m.grain_visits.mean / (2.0 * slab.tau),
                    m.grain_visits.standard_error / (2.0 * slab.tau),
                    m.transmittance.mean,
                    m.transmittance.standard_error,
                    m.ice_path.mean / RADIUS / m.grain_visits.mean,
                );
            };
            show("exact", &exact);
            for kind in [MediumKind::Proxy, MediumKind::Volume] {
                let medium = slab.medium(kind);
                let start = std::time::Instant::now();
                let m = measure_slab_in_medium(&slab.world, &medium, &slab.settings);
                show(&format!("{kind:?}"), &m);
                println!("   {:?}", start.elapsed());
            }
        }
    }
}
