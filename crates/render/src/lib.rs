//! Light transport through grains: scene, camera, lights, integrator, tiles and measures.
//!
//! Opens no file and owns no thread pool: both are handed in.

mod bodies;
pub mod camera;
mod catchers;
pub mod description;
mod dispersion;
mod error;
mod estimate;
pub mod laboratory;
pub mod light;
pub mod measure;
mod render;
mod scene;
mod scene_hash;
mod statistics;
mod strata;
pub mod surface;
pub mod transport;
mod view;
pub mod world;

pub use dispersion::BandOptics;
pub use error::RenderError;
pub use estimate::CostEstimate;
pub use render::{
    PILOT_SAMPLES, Pilot, RenderControl, RenderSettings, Rendered, Rendering, block_counts,
    empty_film, render, render_blocks_with, render_with,
};
pub use scene::{BuildReport, BuildStage, Scene, SnowReport, deposit, deposit_at, surfaces_of};
pub use scene_hash::recipe;
pub use snowgrain_accel::{STRATA, SimdLevel};
pub use statistics::Statistics;
pub use strata::Strata;
pub use surface::{Material, Surface};
pub use view::View;
pub use world::World;
