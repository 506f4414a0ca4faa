//! Snow as matter: size distributions, lattices, deposition and measures of what came out.
//!
//! It knows nothing of light, opens no file and starts no thread.
//!
//! ```
//! use snowgrain_geometry::Quantisation;
//! use snowgrain_grains::{Amount, DepositRule, DepositSettings, Radii, Snowfall};
//! use snowgrain_math::DVec3;
//! let radii = Radii::Uniform { mean: 0.5e-3, variation: 0.1e-3 };
//! let lattice = Quantisation::for_grains(DVec3::ZERO, radii.largest());
//! let mut snow = Snowfall::on_level_floor(lattice, [0.02, 0.02])?;
//! let report = snow.deposit(&DepositSettings {
//!     amount: Amount::Depth(0.005),
//!     radii,
//!     density: None,
//!     rule: Some(DepositRule::Ray),
//!     max_slope_degrees: 80.0,
//!     direction: DepositSettings::DOWN,
//!     area: None,
//!     seed: 1,
//! })?;
//! assert_eq!(snow.into_field().len() as u64, report.accepted);
//! # Ok::<(), snowgrain_grains::GrainsError>(())
//! ```

pub mod deposit;
mod error;
pub mod field;
pub mod fill;
mod hold;
pub mod lattice;
pub mod layers;
pub mod measures;
pub mod pack;
pub mod radii;
pub mod random;
pub mod settings;
pub mod settling;
pub mod shapes;

pub use deposit::{DepositReport, Reached, Snowfall, reached_solid_fraction};
pub use error::GrainsError;
pub use field::GrainField;
pub use fill::{Body, FillReport, FillSettings, HeightField, PlanImage, Solid, TiledFill};
pub use hold::turned_to_touch;
pub use lattice::{LatticeCell, lattice_grains};
pub use layers::{LayerSettings, Layers, Stacking};
pub use measures::{Extent, PackReport, Slab};
pub use pack::{PACK_DENSITIES, PackMethod, PackSettings, PeriodicPack, VARIANTS};
pub use radii::{Radii, RadiusCurve};
pub use random::{RandomLayer, RandomSettings, random_layers, random_pack};
pub use settings::{
    Amount, DepositRule, DepositSettings, ICE_DENSITY, LatticeKind, LatticeSettings,
};
pub use settling::Settling;
pub use shapes::{FieldShapes, MixedShape, Orientation, ShapeMix};
