//! Published or precomputed figures that several tests compare with, each with its source.

/// One row of the project's reference table `packing_slab.csv`: a non-absorbing slab of touching
/// spheres of index 1.31 over black, traced by an independent Monte Carlo program (geometric
/// optics, mean Fresnel reflectance redrawn at each interface), axis-aligned (001) lattices.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlabRow {
    /// Layers of grains; each adds pi/4 to tau.
    pub layers: u32,
    /// Fraction reflected; the rest is transmitted.
    pub reflectance: f64,
    /// Standard error of it.
    pub standard_error: f64,
    /// Mean grain visits.
    pub visits: f64,
    /// Mean interface events per visit.
    pub events_per_visit: f64,
}

const fn row(
    layers: u32,
    reflectance: f64,
    standard_error: f64,
    visits: f64,
    events_per_visit: f64,
) -> SlabRow {
    SlabRow { layers, reflectance, standard_error, visits, events_per_visit }
}

/// Simple cubic, Lambertian light.
pub const SIMPLE_CUBIC_LAMBERTIAN: [SlabRow; 4] = [
    row(3, 0.20997, 0.00064, 4.7080, 1.99966),
    row(7, 0.35945, 0.00076, 10.9805, 1.99997),
    row(26, 0.64856, 0.00107, 40.6297, 2.00000),
    row(128, 0.89568, 0.00125, 200.9944, 1.99995),
];

/// Face-centred cubic, Lambertian light.
pub const FACE_CENTRED_CUBIC_LAMBERTIAN: [SlabRow; 4] = [
    row(3, 0.19178, 0.00062, 4.7219, 1.99966),
    row(7, 0.33243, 0.00074, 10.9678, 2.00032),
    row(26, 0.61479, 0.00109, 40.8621, 2.00027),
    row(128, 0.87950, 0.00133, 200.6948, 2.00014),
];

/// Simple cubic, light straight down.
pub const SIMPLE_CUBIC_NORMAL: [SlabRow; 3] = [
    row(3, 0.10677, 0.00049, 2.7018, 2.00026),
    row(7, 0.21671, 0.00065, 7.0998, 2.00034),
    row(26, 0.44454, 0.00111, 29.7378, 2.00051),
];

/// Face-centred cubic, light straight down.
pub const FACE_CENTRED_CUBIC_NORMAL: [SlabRow; 3] = [
    row(3, 0.11352, 0.00050, 2.6018, 2.00054),
    row(7, 0.22930, 0.00066, 7.1611, 1.99993),
    row(26, 0.49537, 0.00112, 32.2081, 2.00000),
];

/// Side N and mean radiance of the interior pixels of the benchmark cube ([`crate::cube`]), index
/// 1.31: a double-precision walker of the lattice's cells, given to four decimals.
pub const CUBE_RADIANCE: [(u32, f64); 3] = [(32, 0.4063), (64, 0.4947), (120, 0.5571)];
