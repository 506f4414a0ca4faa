//! The kernels: next surface, next grain, scattering in it; and the store of falling grains.
//!
//! The only crate with SIMD. Each kernel is written once, generic over the SIMD level, and is
//! dispatched at run time; results are the same bits at every level.

pub mod flight;
pub mod grain_grid;
pub mod grain_stacks;
pub mod homogeneous;
mod pages;
mod prefetch;
pub mod simd;
mod strata;
pub mod surfaces;
mod words;

pub use flight::{
    ArrivalFrom, DeepAnswer, DeepWatch, Flight, FlightEvent, GrainVisit, GrainsBefore, MetGrain,
    Outgoing, Passage, Probe, ProbeAnswer, Probes, ShapedArrival,
};
pub use grain_grid::{
    Extent, GrainGrid, GrainParts, GridError, GridGrain, GridPosition, Interior, LatticeCell,
    Packing, ShapedGrains, SizesPerVolume, TiledGrains, tile_divisor,
};
pub use grain_stacks::{
    Fall, FallHit, GrainSlot, GrainStacks, GrainStacksError, PlanRectangle, Quad, RegionEdge,
    RegionLayout, StackRegion,
};
pub use simd::SimdLevel;
pub use strata::STRATA;
pub use surfaces::{SphereContact, SurfaceHit, SurfaceId, SurfaceShape, Surfaces};
