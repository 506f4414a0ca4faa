//! The snow that is measured.

use crate::failure::Failure;
use core::f64::consts::PI;
use snowgrain_accel::{GrainGrid, Packing, ShapedGrains, Surfaces};
use snowgrain_geometry::Quantisation;
use snowgrain_grains::{
    DepositSettings, FieldShapes, GrainField, LatticeCell, LatticeKind, LatticeSettings, Snowfall,
};
use snowgrain_math::{Aabb, DVec3};
use snowgrain_render::{RenderError, World};

/// Radius where none is given, metres.
pub(super) const USUAL_RADIUS: f64 = 0.5e-3;

/// Cells along a period: it is rounded to a multiple of so many quanta.
const LARGEST_RADII_PER_CELL: f64 = 2.5;

/// Sums over the grains of a body, or of one period.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct GrainSums {
    pub(super) grains: u64,
    /// Sum of the squares of the radii, or of those of spheres of the surface that shapes have, m^2.
    pub(super) squares: f64,
    /// Sum of their cubes, m^3.
    pub(super) cubes: f64,
}

impl GrainSums {
    fn of_field(field: &GrainField) -> Self {
        let Some(FieldShapes { prototypes, of_grains }) = field.shapes() else {
            return field.iter().fold(Self::default(), |sums, grain| sums.with(1, grain.radius));
        };
        let grains = field.iter().zip(of_grains);
        grains.fold(Self::default(), |sums, (grain, shape)| {
            let surface = prototypes[shape.prototype()].surface_area() / (4.0 * PI);
            let one = Self::default().with(1, grain.radius);
            Self {
                grains: sums.grains + 1,
                squares: sums.squares + surface * one.squares,
                cubes: sums.cubes + one.cubes,
            }
        })
    }

    fn with(self, grains: u64, radius: f64) -> Self {
        let (n, square) = (grains as f64, radius * radius);
        Self {
            grains: self.grains + grains,
            squares: self.squares + n * square,
            cubes: self.cubes + n * square * radius,
        }
    }

    /// Total surface, m^2.
    pub(super) fn surface(&self) -> f64 {
        4.0 * PI * self.squares
    }

    /// Total volume, overlaps counted twice, m^3.
    pub(super) fn volume(&self) -> f64 {
        4.0 / 3.0 * PI * self.cubes
    }

    /// Radius of equal grains with the same volume and the same surface, metres.
    pub(super) fn effective_radius(&self) -> f64 {
        self.cubes / self.squares
    }
}

/// Snow that light can travel through.
pub(super) struct MeasuredSnow {
    pub(super) world: World,
    pub(super) sums: GrainSums,
    /// The box that encloses all grains; along the axes that repeat, one period.
    pub(super) hull: Aabb,
}

fn world(grid: GrainGrid, ior: f64) -> World {
    World {
        grid,
        surfaces: Surfaces::default(),
        materials: Vec::new(),
        emitters: Vec::new(),
        eta: ior,
    }
}

/// A crystal of touching grains; periodic along x and z where it is a slab.
pub(super) fn crystal(
    kind: LatticeKind,
    counts: [u32; 3],
    radius: f64,
    periodic: bool,
    ior: f64,
) -> Result<MeasuredSnow, Failure> {
    let quantisation = Quantisation::for_grains(DVec3::ZERO, radius);
    let settings = LatticeSettings { kind, counts, radius, spacing: None, density: None };
    let cell = LatticeCell::new(&settings, &quantisation)?;
    let packed = snowgrain_accel::LatticeCell {
        side_quanta: cell.side_quanta,
        basis: cell.basis.clone(),
        radius_quanta: cell.radius,
    };
    let repeats = [periodic, false, periodic];
    let grid = GrainGrid::lattice(quantisation, &packed, counts, [0; 3], repeats)
        .map_err(RenderError::from)?;
    let quantum = quantisation.quantum();
    let quanta: [f64; 3] = std::array::from_fn(|axis| {
        let cells = f64::from(counts[axis]);
        let side = f64::from(cell.side_quanta[axis]);
        if repeats[axis] {
            return cells * side;
        }
        let highest = cell.basis.iter().map(|b| b[axis]).max().unwrap_or(0);
        let top = (cells - 1.0) * side + f64::from(highest) + f64::from(cell.radius);
        top.max(cells * side)
    });
    let hull = Aabb::new(DVec3::ZERO, DVec3::from_array(quanta) * quantum);
    let sums = GrainSums::default().with(settings.full_count(), f64::from(cell.radius) * quantum);
    Ok(MeasuredSnow { world: world(grid, ior), sums, hull })
}

/// Grains that fall on a level floor that repeats with a period near to `width`, metres.
pub(super) fn fallen(
    settings: &DepositSettings,
    width: f64,
    ior: f64,
) -> Result<MeasuredSnow, Failure> {
    let quantisation = Quantisation::for_grains(DVec3::ZERO, settings.radii.largest());
    let mut snow = Snowfall::on_level_floor(quantisation, [width; 2])?;
    let period = snow.period().unwrap_or([width; 2]);
    snow.deposit(settings)?;
    let quanta = period.map(|length| (length / quantisation.quantum()).round() as i64);
    periodic(&snow.into_field(), quanta, ior)
}

/// The grains of a file, which repeat with a period near to `period`, metres.
pub(super) fn repeated(
    field: GrainField,
    period: [f64; 2],
    ior: f64,
) -> Result<MeasuredSnow, Failure> {
    if field.is_empty() {
        return Err(Failure::bad_input("it holds no grains"));
    }
    let quantum = field.quantisation.quantum();
    // Cells hold bounding spheres.
    let reach = match field.shapes() {
        None => f64::from(field.largest_radius_quanta()),
        Some(_) => (field.largest_reach() / quantum).ceil(),
    };
    let cell = LARGEST_RADII_PER_CELL * reach;
    let mut quanta = [0i64; 2];
    for (length, metres) in quanta.iter_mut().zip(period) {
        let wanted = metres / quantum;
        if !(wanted >= cell && wanted < f64::from(i32::MAX)) {
            return Err(Failure::usage(format!(
                "--period: {metres} m is no period for grains of up to {} m radius; it must be at \
                 least {} m and below {} m",
                f64::from(field.largest_radius_quanta()) * quantum,
                cell * quantum,
                f64::from(i32::MAX) * quantum
            )));
        }
        let cells = (wanted / cell).floor();
        *length = ((wanted / cells).round() * cells) as i64;
    }
    let [x, z] = quanta;
    let quantisation = field.quantisation;
    let shapes = field.shapes().cloned();
    let mut grains = field.into_grains();
    for grain in &mut grains {
        grain.center[0] = i64::from(grain.center[0]).rem_euclid(x) as i32;
        grain.center[2] = i64::from(grain.center[2]).rem_euclid(z) as i32;
    }
    let field = GrainField::new(quantisation, grains);
    let field = match shapes {
        Some(shapes) => field.with_shapes(shapes),
        None => field,
    };
    periodic(&field, quanta, ior)
}

fn periodic(field: &GrainField, quanta: [i64; 2], ior: f64) -> Result<MeasuredSnow, Failure> {
    let grains = field.grains();
    let grid = match field.shapes() {
        None => GrainGrid::build_periodic(field.quantisation, &*grains, quanta, Packing::Fast),
        Some(FieldShapes { prototypes, of_grains }) => GrainGrid::build_shaped(
            field.quantisation,
            (&grains, ShapedGrains { prototypes, of_grains }),
            (&Surfaces::default(), &[]),
            Some(quanta),
            Packing::Fast,
        ),
    };
    let grid = grid.map_err(RenderError::from)?;
    let bounds = reach_of(field);
    let [x, z] = quanta.map(|length| length as f64 * field.quantisation.quantum());
    let hull = Aabb::new(DVec3::new(0.0, bounds.min.y, 0.0), DVec3::new(x, bounds.max.y, z));
    Ok(MeasuredSnow { world: world(grid, ior), sums: GrainSums::of_field(field), hull })
}

/// The grains of a file as they are.
pub(super) fn body(field: &GrainField, ior: f64) -> Result<MeasuredSnow, Failure> {
    if field.is_empty() {
        return Err(Failure::bad_input("it holds no grains"));
    }
    let grid = field.pack(&Surfaces::default(), Packing::Fast).map_err(RenderError::from)?;
    let sums = GrainSums::of_field(field);
    Ok(MeasuredSnow { world: world(grid, ior), sums, hull: reach_of(field) })
}

/// A box around all of the grains as they are.
fn reach_of(field: &GrainField) -> Aabb {
    let largest = f64::from(field.largest_radius_quanta()) * field.quantisation.quantum();
    let beyond = DVec3::splat(field.largest_reach() - largest);
    let bounds = field.bounds();
    Aabb::new(bounds.min - beyond, bounds.max + beyond)
}
