//! Light and ice without scenes: Fresnel's equations, the ice that a path has crossed, the closed form
//! of a grain that touches nothing; what ice and impurities absorb at each wavelength; and the
//! theories of how much light snow reflects.
//!
//! Geometric optics throughout: no diffraction, `f64`. Nothing here knows where a grain lies or what
//! surrounds it. Wavelengths are in nanometres, everything else in SI units.
//!
//! ```
//! use snowgrain_optics::{Dielectric, sphere};
//! let ice = Dielectric { eta: 1.31 };
//! assert!((ice.reflectance_from_outside(1.0) - (0.31f64 / 2.31) * (0.31 / 2.31)).abs() < 1e-15);
//! assert!((sphere::asymmetry(ice) - 0.78166).abs() < 1e-5);
//! ```

pub mod band;
pub mod bohren_barkstrom;
pub mod clear_sky;
pub mod colour;
pub mod colour_temperature;
pub mod dielectric;
pub mod fresnel;
pub mod grade;
pub mod ice;
pub mod ice_colour;
pub mod ice_path;
pub mod impurity;
pub mod metal;
pub mod phase;
mod quadrature;
pub mod scatter;
pub mod spectrum;
pub mod sphere;
pub mod strata_colour;
pub mod substance;
pub mod sun_position;
mod table;
pub mod theory;
pub mod uplift;
pub mod water;

pub use band::{BANDS, Band};
pub use bohren_barkstrom::BohrenBarkstrom;
pub use clear_sky::SunZenith;
pub use colour::{Illuminant, Primaries};
pub use dielectric::Dielectric;
pub use grade::Grade;
pub use ice::{Absorption, IceAbsorption};
pub use ice_colour::IceColour;
pub use ice_path::IcePath;
pub use impurity::{Impurity, ImpurityKind, Load};
pub use metal::Metal;
pub use phase::PhaseTable;
pub use scatter::{
    Between, Connection, Connector, PairPath, Passed, Pencil, ScatterTable, SpherePair, SphereVisit,
};
pub use spectrum::Spectrum;
pub use strata_colour::StrataColour;
pub use substance::{MeasuredSubstance, Substance};
