//! The snow of a scene: how it comes to lie, and is packed for light.

use super::quantisation::{check_sizes, quantisation_of};
use super::tiled::{tiled_bodies, tiled_grid};
use super::{BuildReport, BuildStage, SnowReport};
use crate::RenderError;
use crate::bodies::KnownGrains;
use crate::description::{SceneDescription, SnowDescription};
use crate::light::LitSurfaces;
use crate::scene_hash::GrainDigest;
use snowgrain_accel::{GrainGrid, SimdLevel, Surfaces};
use snowgrain_geometry::{Quantisation, Shape};
use snowgrain_grains::{GrainField, LatticeCell, LatticeSettings, Snowfall};
use std::sync::Arc;

/// Grains that are packed for light, and what else light meets.
pub(super) struct Packed {
    pub(super) grid: GrainGrid,
    pub(super) surfaces: Surfaces,
    pub(super) digest: GrainDigest,
    /// Of the shapes of grains, where these have any.
    pub(super) prototypes: Arc<[Shape]>,
}

/// One lattice alone needs no memory; everything else is packed grain by grain.
pub(super) fn build_grid(
    description: &SceneDescription,
    (objects, lit, level): (Surfaces, &LitSurfaces, SimdLevel),
    report: &mut BuildReport,
    stage: &mut dyn FnMut(BuildStage),
) -> Result<Packed, RenderError> {
    let has_lamps = lit.shapes.len() > description.objects.len();
    if let [SnowDescription::Lattice(settings)] = description.snow.as_slice()
        && description.strata.loads.is_empty()
        && !description.has_shapes()
    {
        let quantisation = quantisation_of(description, &objects);
        let with_lamps = has_lamps.then(|| Surfaces::new(&lit.shapes).with_level(level));
        let surfaces = with_lamps.as_ref().unwrap_or(&objects);
        let searched = description.notes_visits();
        let lattice = implicit_lattice(settings, quantisation, surfaces, searched)?;
        if let Some((grid, digest)) = lattice {
            stage(BuildStage::Packing);
            report.snow.push(SnowReport::Placed);
            let surfaces = with_lamps.unwrap_or(objects);
            return Ok(Packed { grid, surfaces, digest, prototypes: Arc::new([]) });
        }
    }
    if let Some(bodies) = tiled_bodies(description) {
        let quantisation = quantisation_of(description, &objects);
        check_sizes(description, quantisation)?;
        let surfaces =
            if has_lamps { Surfaces::new(&lit.shapes).with_level(level) } else { objects };
        let world = (quantisation, &surfaces);
        let (grid, digest) = tiled_grid(description, &bodies, world, report, stage)?;
        return Ok(Packed { grid, surfaces, digest, prototypes: Arc::new([]) });
    }
    let mut known = KnownGrains::of_scene(description);
    let field = fall(description, (&objects, level), &mut known, report, stage)?;
    stage(BuildStage::Packing);
    // Snow falls through lamps.
    let surfaces = if has_lamps {
        drop(objects);
        Surfaces::new(&lit.shapes).with_level(level)
    } else {
        objects
    };
    let quantisation = field.quantisation;
    let packing = description.packing.unwrap_or_default();
    let grid = field.pack_in_strata(&surfaces, packing, &known.strata(&field))?;
    let digest = GrainDigest::new(quantisation, packing, &field);
    let prototypes =
        field.shapes().map_or_else(|| Arc::new([]) as Arc<[Shape]>, |s| Arc::clone(&s.prototypes));
    Ok(Packed { grid, surfaces, digest, prototypes })
}

/// The lattice without memory, where it is whole and has such a form, and no surface crosses it; as
/// light that is `searched` for needs it.
fn implicit_lattice(
    settings: &LatticeSettings,
    quantisation: Quantisation,
    surfaces: &Surfaces,
    searched: bool,
) -> Result<Option<(GrainGrid, GrainDigest)>, RenderError> {
    let cell = LatticeCell::new(settings, &quantisation)
        .map_err(|source| RenderError::Snow { index: 0, source })?;
    let whole = cell.kept == settings.full_count();
    let packed = snowgrain_accel::LatticeCell {
        side_quanta: cell.side_quanta,
        basis: cell.basis.clone(),
        radius_quanta: cell.radius,
    };
    if !whole {
        return Ok(None);
    }
    let build = if searched { GrainGrid::lattice_in_cells } else { GrainGrid::lattice };
    let grid = build(quantisation, &packed, cell.counts, [0; 3], [false; 3]);
    let Some(grid) =
        grid.ok().filter(|grid| surfaces.is_empty() || !surfaces.may_cross(&grid.bounds()))
    else {
        return Ok(None);
    };
    let digest = GrainDigest::of_lattice(quantisation, &cell);
    Ok(Some((grid, digest)))
}

/// Lets the snow of the scene fall, in order.
pub(super) fn fall(
    description: &SceneDescription,
    (surfaces, level): (&Surfaces, SimdLevel),
    known: &mut KnownGrains<'_>,
    report: &mut BuildReport,
    stage: &mut dyn FnMut(BuildStage),
) -> Result<GrainField, RenderError> {
    let quantisation = quantisation_of(description, surfaces);
    check_sizes(description, quantisation)?;
    let mut snowfall = Snowfall::on_surfaces(quantisation, surfaces).with_simd_level(level);
    for (index, snow) in description.snow.iter().enumerate() {
        stage(BuildStage::Snow { index });
        snowfall.set_shapes(description.shapes_of(index).cloned());
        let result = match snow {
            SnowDescription::Deposit(settings) => {
                let mut fallen = |grains| stage(BuildStage::Fallen { index, grains });
                snowfall.deposit_telling(settings, &mut fallen).map(SnowReport::Fell)
            }
            SnowDescription::Filled(settings) => snowfall.fill(settings).map(SnowReport::Filled),
            SnowDescription::Lattice(settings) => {
                snowfall.lattice(settings).map(|()| SnowReport::Placed)
            }
            SnowDescription::Grains(field) => snowfall.place(field).map(|()| SnowReport::Placed),
        };
        report.snow.push(result.map_err(|source| RenderError::Snow { index, source })?);
        known.learn(index, &snowfall);
    }
    known.shaped(snowfall.into_field())
}
