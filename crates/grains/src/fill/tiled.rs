//! Bodies of so many grains that these are never listed: tiles of the pack, of several variants, packed for light once.

use super::{Body, FillReport, FillSettings};
use crate::pack::PeriodicPack;
use crate::{GrainsError, ICE_DENSITY};
use snowgrain_accel::{Extent, GrainGrid, GridError, Packing, Surfaces, TiledGrains};
use snowgrain_geometry::{Quantisation, QuantisedGrain};
use snowgrain_math::sampler::{PathKey, numbers};
use snowgrain_math::{Aabb, DVec3};
use std::sync::{Mutex, PoisonError};

/// What tells the random numbers that choose variants from others.
const CHOICE: u64 = 0x711e_c401;

/// Bodies of one pack in tiles.
#[derive(Debug)]
pub struct TiledFill<'a> {
    bodies: &'a [&'a FillSettings],
    quantisation: Quantisation,
    pack: PeriodicPack,
    variants: Vec<Vec<QuantisedGrain>>,
    /// The low corner of tile (0, 0, 0), quanta.
    corner: [i64; 3],
    /// The box around all centres, ends included, quanta.
    bounds: [[i64; 2]; 3],
    /// Why a body cannot be asked, found while it was.
    fault: Mutex<Option<GrainsError>>,
}

impl<'a> TiledFill<'a> {
    /// Whether bodies can be made so: of one pack, without masks or maps of the density.
    #[must_use]
    pub fn fits(bodies: &[&FillSettings]) -> bool {
        let plain = |body: &&&FillSettings| body.mask.is_none() && body.density_map.is_none();
        let same = |body: &&&FillSettings| body.pack == bodies[0].pack;
        !bodies.is_empty() && bodies.iter().all(|body| plain(&body) && same(&body))
    }

    /// Makes the pack and its variants.
    ///
    /// # Errors
    /// As [`crate::PackSettings::make`]; a body beyond the lattice of quanta.
    ///
    /// # Panics
    /// If the bodies do not fit ([`Self::fits`]).
    pub fn new(
        bodies: &'a [&'a FillSettings],
        quantisation: Quantisation,
    ) -> Result<Self, GrainsError> {
        assert!(Self::fits(bodies), "bodies of one pack");
        let settings = &bodies[0].pack;
        let around = bodies.iter().fold(Aabb::EMPTY, |all, body| all.union(&body.body.bounds()));
        let (origin, quantum) = (quantisation.origin(), quantisation.quantum());
        let reach = f64::from(Quantisation::MAX_COORDINATE);
        let ends = [around.min, around.max].map(|end| (end - origin) / quantum);
        let is_near = |end: &DVec3| end.abs().cmple(DVec3::splat(reach)).all();
        if around.is_empty() || !ends.iter().all(is_near) {
            let reason =
                format!("is out of reach: snow of such grains reaches {} m", reach * quantum);
            return Err(GrainsError::setting("body", reason));
        }
        let pack = settings.make(quantum)?;
        let variants = pack.variants(settings.seed);
        let [low, high] = ends;
        Ok(Self {
            bodies,
            quantisation,
            corner: (-origin / quantum).round().to_array().map(|c| c as i64),
            bounds: std::array::from_fn(|axis| {
                [low[axis].floor() as i64, high[axis].ceil() as i64]
            }),
            pack,
            variants,
            fault: Mutex::new(None),
        })
    }

    /// Variants of the tile.
    #[must_use]
    pub fn variants(&self) -> &[Vec<QuantisedGrain>] {
        &self.variants
    }

    /// Packs all grains for light, beside `surfaces`, and tells what became of each body: the grains of a body
    /// among others are about those.
    ///
    /// # Errors
    /// As [`GrainGrid::build_tiled`].
    pub fn pack(
        &self,
        surfaces: &Surfaces,
        packing: Packing,
    ) -> Result<(GrainGrid, Vec<FillReport>), GridError> {
        let variants: Vec<&[QuantisedGrain]> = self.variants.iter().map(Vec::as_slice).collect();
        let tiled = TiledGrains {
            variants: &variants,
            period: self.pack.period,
            corner: self.corner,
            variant_of: &|tile| self.variant_of(tile),
            bounds: self.bounds,
            extent: &|centers| self.extent(centers),
            holds: &|center| self.holds(center),
        };
        let grid = GrainGrid::build_tiled(self.quantisation, &tiled, surfaces, packing)?;
        let report = |body: &&FillSettings| FillReport {
            grains: if self.bodies.len() == 1 {
                grid.grains()
            } else {
                body.expected_grains().round() as u64
            },
            asked: body.pack.density,
            density: ICE_DENSITY * self.pack.solid_fraction,
            method: self.pack.method,
        };
        let reports = self.bodies.iter().map(report).collect();
        Ok((grid, reports))
    }

    /// Why a body could not be asked while it was packed: a mesh that crosses itself.
    #[must_use]
    pub fn fault(&self) -> Option<GrainsError> {
        self.fault.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Of several faults the same one is kept whatever the order in which they are found.
    fn note(&self, fault: GrainsError) {
        let mut known = self.fault.lock().unwrap_or_else(PoisonError::into_inner);
        if known.as_ref().is_none_or(|known| fault.to_string() < known.to_string()) {
            *known = Some(fault);
        }
    }

    /// A function of the seed and the tile.
    fn variant_of(&self, tile: [i64; 3]) -> usize {
        let word = |at: i64| u64::from((at as i32).cast_unsigned());
        let [x, y, z] = tile.map(word);
        let key = PathKey::new(self.bodies[0].pack.seed ^ CHOICE, x | z << 32, y);
        let count = self.variants.len();
        ((f64::from(numbers(key, 0)[0]) * count as f64) as usize).min(count - 1)
    }

    fn metres(&self, center: [i64; 3]) -> DVec3 {
        let quanta = DVec3::from_array(center.map(|c| c as f64));
        self.quantisation.origin() + quanta * self.quantisation.quantum()
    }

    /// Whether a body holds a grain by its centre.
    fn holds(&self, center: [i64; 3]) -> bool {
        let at = self.metres(center);
        self.bodies.iter().any(|body| match body.body.holds(at) {
            Ok(holds) => holds,
            Err(fault) => {
                self.note(fault);
                false
            }
        })
    }

    fn extent(&self, centers: [[i64; 2]; 3]) -> Extent {
        let [low, high] = [0, 1].map(|end| self.metres(centers.map(|ends| ends[end])));
        let around = Aabb::new(low, high);
        let mut extent = Extent::Empty;
        for body in self.bodies {
            match body.body.extent(&around) {
                Extent::Whole => return Extent::Whole,
                Extent::Part => extent = Extent::Part,
                Extent::Empty => {}
            }
        }
        extent
    }
}

impl Body {
    /// What of a box, metres, lies inside: told only where it is sure.
    pub(super) fn extent(&self, around: &Aabb) -> Extent {
        let bounds = self.bounds();
        let apart = around.max.cmplt(bounds.min).any() || around.min.cmpgt(bounds.max).any();
        if apart {
            return Extent::Empty;
        }
        match self {
            Self::Box(bounds) => {
                let inside =
                    around.min.cmpge(bounds.min).all() && around.max.cmplt(bounds.max).all();
                if inside { Extent::Whole } else { Extent::Part }
            }
            Self::Solid(solid) => solid.extent(around),
            Self::Heights(heights) => heights.extent(around),
        }
    }
}
