//! What is asked for and what is found.

use crate::laboratory::Incidence;
use crate::measure::Estimate;
use snowgrain_accel::SimdLevel;
use snowgrain_optics::sphere::Polarisation;

/// What to find, and how exactly.
#[derive(Clone, Debug, PartialEq)]
pub struct SpreadSettings {
    /// Wavelengths, nm, 300 to 2500; each is traced for itself.
    pub wavelengths_nm: Vec<f64>,
    /// How light arrives at the point.
    pub incidence: Incidence,
    /// Polarisation within a grain.
    pub polarisation: Polarisation,
    /// Standard error to reach of the parts of the light that leave within each radius.
    pub standard_error: f64,
    /// Paths for each wavelength at which the search for it ends.
    pub most_paths: u64,
    /// Seed.
    pub seed: u64,
    /// Instruction set of the kernels.
    pub level: SimdLevel,
}

/// What becomes of a pencil of light at one wavelength.
#[derive(Clone, Debug, PartialEq)]
pub struct Spread {
    /// Wavelength, nm.
    pub wavelength_nm: f64,
    /// Length over which light forgets its direction where grains are met at random, 4 r / (3 phi (1 - g)),
    /// metres.
    pub transport_length: f64,
    /// Light that leaves where the beam comes from.
    pub reflected: FaceSpread,
    /// Light that leaves by the other face.
    pub transmitted: FaceSpread,
}

/// Light that leaves by one face, in parts of that of the beam. Distances in metres, from where the beam
/// enters; those on the other face from the point below.
#[derive(Clone, Debug, PartialEq)]
pub struct FaceSpread {
    /// All of it.
    pub total: Estimate,
    /// Per area, 1/m^2, in rings.
    pub per_area: Vec<SpreadBin>,
    /// Within the radius `to`.
    pub within: Vec<SpreadBin>,
    /// Of a beam that is a line instead, along which parallel light goes: per width, 1/m, by the distance across
    /// it, on either side.
    pub per_width: Vec<SpreadBin>,
    /// Per optical path, 1/m: refractive index times the length in ice, and the length in air.
    pub per_path: Vec<SpreadBin>,
    /// Mean optical path of what leaves, metres.
    pub mean_path: Estimate,
    /// Radius within which half of what leaves does, metres; not a number where nothing does.
    pub median_radius: Estimate,
    /// The same for 90 %.
    pub radius_of_90_percent: Estimate,
}

/// A value between two distances or paths, metres; the last reaches to infinity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpreadBin {
    /// From here.
    pub from: f64,
    /// To here.
    pub to: f64,
    /// The value.
    pub value: Estimate,
}
