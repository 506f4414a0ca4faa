//! A slab of packed grains, to measure.

use super::{Incidence, SlabSettings};
use crate::World;
use core::f64::consts::PI;
use snowgrain_accel::{GrainGrid, Packing, SimdLevel, Surfaces};
use snowgrain_geometry::Quantisation;
use snowgrain_grains::{GrainsError, PackSettings};
use snowgrain_math::DVec3;

/// Whole periods of a pack on each other, repeated along x and z.
#[derive(Debug)]
pub struct PackedSlab {
    /// The grains.
    pub world: World,
    /// Faces that enclose them, diffuse light from above, the best instruction set of the machine.
    pub settings: SlabSettings,
    /// Area of their discs over that of a period.
    pub tau: f64,
    /// Solid fraction of the pack.
    pub solid_fraction: f64,
}

impl PackedSlab {
    /// As many periods of the pack as make `depth` metres, of grains with the relative index `eta`; `paths` of light from a
    /// `seed`.
    ///
    /// # Errors
    /// A pack that cannot be made.
    pub fn new(
        pack: &PackSettings,
        (depth, eta): (f64, f64),
        (paths, seed): (u64, u64),
    ) -> Result<Self, GrainsError> {
        let quantisation = Quantisation::for_grains(DVec3::ZERO, pack.radii.largest());
        let made = pack.make(quantisation.quantum())?;
        let [x, y, z] = made.period.map(|quanta| quanta as f64 * quantisation.quantum());
        let copies = (depth / y).ceil().max(1.0);
        let one = made.field.grains();
        let mut grains = Vec::with_capacity(one.len() * copies as usize);
        for copy in 0..copies as i32 {
            grains.extend(one.iter().map(|grain| {
                let mut grain = *grain;
                grain.center[1] += copy * made.period[1] as i32;
                grain
            }));
        }
        let radius = |grain: u16| f64::from(grain) * quantisation.quantum();
        let area: f64 = grains.iter().map(|g| PI * radius(g.radius) * radius(g.radius)).sum();
        let period = [made.period[0], made.period[2]];
        let grid = GrainGrid::build_periodic(quantisation, &grains[..], period, Packing::Fast)
            .map_err(|error| GrainsError::Setting { key: "density", reason: error.to_string() })?;
        let (surfaces, materials, emitters) = (Surfaces::default(), Vec::new(), Vec::new());
        let settings = SlabSettings {
            top: copies * y + pack.radii.largest(),
            bottom: -pack.radii.largest(),
            period: [x, z],
            incidence: Incidence::Lambertian,
            from_below: false,
            absorption_per_metre: 0.0,
            paths,
            seed,
            level: SimdLevel::detect(),
        };
        Ok(Self {
            world: World { grid, surfaces, materials, emitters, eta },
            settings,
            tau: area / (x * z),
            solid_fraction: made.solid_fraction,
        })
    }
}
