//! A slab of packed grains, to measure.

use super::{Incidence, SlabSettings};
use crate::World;
use core::f64::consts::PI;
use snowgrain_accel::{GrainGrid, Packing, ShapedGrains, SimdLevel, Surfaces};
use snowgrain_geometry::{GrainShape, Quantisation, QuantisedGrain, Shape};
use snowgrain_grains::{Amount, DepositSettings, GrainsError, PackSettings, ShapeMix, Snowfall};
use snowgrain_math::DVec3;

/// Whole periods of a pack on each other, repeated along x and z.
#[derive(Debug)]
pub struct PackedSlab {
    /// The grains.
    pub world: World,
    /// Their shapes, if they have any.
    pub prototypes: Vec<Shape>,
    /// Faces that enclose them, diffuse light from above, the best instruction set of the machine.
    pub settings: SlabSettings,
    /// Area of their shadows, mean over all directions, over that of a period.
    pub tau: f64,
    /// Volumes of the grains, each counted whole, by volume.
    pub solid_fraction: f64,
}

/// Grains of a slab, as they lie.
struct Laid {
    quantisation: Quantisation,
    grains: Vec<QuantisedGrain>,
    /// Periods along x and z, quanta.
    period: [i64; 2],
    /// Between which heights their centres lie, metres.
    heights: [f64; 2],
    largest: f64,
}

/// What lies above and below a slab of a snowfall, mean radii: neither floor nor surface show beyond.
const MARGIN: f64 = 24.0;
/// Width of such a slab, mean radii.
const WIDTH: f64 = 60.0;

impl PackedSlab {
    /// As many periods of the pack as make `depth` metres, of grains with the relative index `eta`, which are given the shapes of a
    /// mix, if there is one; `paths` of light from a `seed`.
    ///
    /// # Errors
    /// A pack that cannot be made.
    pub fn new(
        (pack, mix): (&PackSettings, Option<&ShapeMix>),
        (depth, eta): (f64, f64),
        light: (u64, u64),
    ) -> Result<Self, GrainsError> {
        let quantisation = Quantisation::for_grains(DVec3::ZERO, pack.radii.largest());
        let made = pack.make(quantisation.quantum())?;
        let [_, y, _] = made.period.map(|quanta| quanta as f64 * quantisation.quantum());
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
        let laid = Laid {
            quantisation,
            grains,
            period: [made.period[0], made.period[2]],
            heights: [0.0, copies * y],
            largest: pack.radii.largest(),
        };
        Self::of(laid, mix, eta, light)
    }

    /// The same of snow that fell so on a level floor, from its middle; as much of it as makes `depth` metres, whatever amount is told.
    ///
    /// # Errors
    /// A snowfall that cannot be.
    pub fn fallen(
        (snowfall, mix): (&DepositSettings, Option<&ShapeMix>),
        (depth, eta): (f64, f64),
        light: (u64, u64),
    ) -> Result<Self, GrainsError> {
        let radii = &snowfall.radii;
        let quantisation = Quantisation::for_grains(DVec3::ZERO, radii.largest());
        let width = (WIDTH * radii.mean()).max(8.0 * radii.largest());
        let margin = MARGIN * radii.mean();
        let mut snow = Snowfall::on_level_floor(quantisation, [width; 2])?;
        let amount = Amount::Depth(depth + 2.0 * margin);
        snow.deposit(&DepositSettings { amount, area: None, ..snowfall.clone() })?;
        let quanta = |length: f64| (length / quantisation.quantum()).round();
        let period = snow.period().unwrap_or([width; 2]).map(|length| quanta(length) as i64);
        let heights = [margin, margin + depth];
        let is_within = |grain: &QuantisedGrain| {
            let height = f64::from(grain.center[1]) * quantisation.quantum();
            (heights[0]..heights[1]).contains(&height)
        };
        let grains: Vec<_> = snow.into_field().quantised().filter(is_within).collect();
        let laid = Laid { quantisation, grains, period, heights, largest: radii.largest() };
        Self::of(laid, mix, eta, light)
    }

    fn of(
        laid: Laid,
        mix: Option<&ShapeMix>,
        eta: f64,
        (paths, seed): (u64, u64),
    ) -> Result<Self, GrainsError> {
        let Laid { quantisation, grains, period, heights: [low, high], largest } = laid;
        let drawn = |grain: &QuantisedGrain| {
            mix.map(|mix| {
                let (prototype, quaternion) = mix.draw(*grain);
                GrainShape::new(prototype, quaternion)
            })
        };
        let of_grains: Vec<GrainShape> = grains.iter().filter_map(drawn).collect();
        let shapes = mix.map_or(&[][..], ShapeMix::shapes);
        let prototypes: Vec<Shape> = shapes.iter().map(|m| Shape::clone(&m.shape)).collect();
        let radius = |grain: &QuantisedGrain| f64::from(grain.radius) * quantisation.quantum();
        let shadows = grains.iter().enumerate().map(|(index, grain)| {
            let shape = of_grains.get(index).map(|shape| &prototypes[shape.prototype()]);
            shape.map_or(PI, Shape::mean_projected_area) * radius(grain) * radius(grain)
        });
        let area: f64 = shadows.sum();
        let cubes = grains.iter().map(|grain| radius(grain) * radius(grain) * radius(grain));
        let volume = 4.0 / 3.0 * PI * cubes.sum::<f64>();
        let grid = if prototypes.is_empty() {
            GrainGrid::build_periodic(quantisation, &grains[..], period, Packing::Fast)
        } else {
            let shapes = ShapedGrains { prototypes: &prototypes, of_grains: &of_grains };
            let nothing = (&Surfaces::default(), &[][..]);
            let shaped = (&grains[..], shapes);
            GrainGrid::build_shaped(quantisation, shaped, nothing, Some(period), Packing::Fast)
        };
        let grid = grid
            .map_err(|error| GrainsError::Setting { key: "density", reason: error.to_string() })?;
        let reach = mix.map_or(1.0, ShapeMix::largest_reach) * largest;
        let period = period.map(|quanta| quanta as f64 * quantisation.quantum());
        let (surfaces, materials, emitters) = (Surfaces::default(), Vec::new(), Vec::new());
        let settings = SlabSettings {
            top: high + reach,
            bottom: low - reach,
            period,
            incidence: Incidence::Lambertian,
            from_below: false,
            absorption_per_metre: 0.0,
            paths,
            seed,
            level: SimdLevel::detect(),
        };
        Ok(Self {
            world: World { grid, surfaces, materials, emitters, eta },
            prototypes,
            settings,
            tau: area / (period[0] * period[1]),
            solid_fraction: volume / (period[0] * period[1] * (high - low)),
        })
    }
}
