//! The kernels: next surface, next grain, scattering in it; and the store of falling grains.
//!
//! The only crate with SIMD. Each kernel is written once, generic over the SIMD level, and is
//! dispatched at run time; results are the same bits at every level.

pub mod grain_stacks;
pub mod surfaces;

pub use fearless_simd::Level as SimdLevel;
pub use grain_stacks::{Fall, FallHit, GrainSlot, GrainStacks, GrainStacksError, PlanRectangle};
pub use surfaces::{SphereContact, SurfaceHit, SurfaceId, SurfaceShape, Surfaces};
