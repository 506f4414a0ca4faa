//! What can be wrong with a shape.

use thiserror::Error;

/// Why a shape is refused.
#[derive(Debug, Error, Clone, PartialEq)]
pub enum GeometryError {
    /// A position lies outside the range of the quantisation lattice.
    #[error(
        "a grain at ({x}, {y}, {z}) m lies more than {reach} m from the origin of the grain lattice; move the scene to the origin or use larger grains"
    )]
    OutOfLattice {
        /// Position, metres.
        x: f64,
        /// Position, metres.
        y: f64,
        /// Position, metres.
        z: f64,
        /// Farthest coordinate that can be stored, metres.
        reach: f64,
    },
    /// A radius is not a positive finite number, or outside what the lattice was made for.
    #[error(
        "a grain radius of {radius:.3e} m cannot be stored; radii of this snow go from {smallest:.3e} to {largest:.3e} m: grains of one scene may differ in size by less than 1 to 10 000"
    )]
    BadRadius {
        /// The radius, metres.
        radius: f64,
        /// Least radius that does not round to nothing, metres.
        smallest: f64,
        /// Largest radius of the lattice, metres.
        largest: f64,
    },
    /// A triangle names a vertex that does not exist.
    #[error("triangle {triangle} names vertex {vertex}, but there are only {vertices}")]
    VertexOutOfRange {
        /// Index of the triangle, from 0.
        triangle: usize,
        /// The vertex it names, from 0.
        vertex: u32,
        /// Number of vertices.
        vertices: usize,
    },
    /// A vertex is not finite.
    #[error("vertex {vertex} has a coordinate that is not a finite number")]
    VertexNotFinite {
        /// Index of the vertex, from 0.
        vertex: usize,
    },
    /// Places in a picture that are not one for each triangle.
    #[error("there are texture coordinates of {places} triangles, but {triangles} triangles")]
    CoordinatesOfOthers {
        /// Triangles that have places.
        places: usize,
        /// Triangles.
        triangles: usize,
    },
    /// A place in a picture that is not finite.
    #[error("triangle {triangle} has a texture coordinate that is not a finite number")]
    CoordinateNotFinite {
        /// Index of the triangle, from 0.
        triangle: usize,
    },
    /// A number of a shape is out of range.
    #[error("{key}: {reason}")]
    BadShape {
        /// Name of the number, as in a scene file.
        key: &'static str,
        /// What is wrong and how to mend it.
        reason: String,
    },
    /// A mesh that encloses nothing, or not all of it.
    #[error(
        "the mesh is not closed: {edges} edges have no triangle on their other side, or one that faces the other way; close it, and let all triangles face outwards"
    )]
    OpenMesh {
        /// Edges without a partner.
        edges: usize,
    },
    /// A mesh with a hollow, or turned inside out.
    #[error(
        "the mesh is not convex, or its triangles face inwards; a grain's mesh must be convex, and its triangles counter-clockwise seen from outside"
    )]
    NotConvex,
    /// A mesh whose triangles face inwards.
    #[error(
        "the triangles of the mesh face inwards; they must be counter-clockwise seen from outside: turn its normals"
    )]
    InsideOut,
    /// A mesh that crosses itself.
    #[error("the mesh crosses itself; unite its parts first")]
    CrossingMesh,
    /// A mesh with too many hollows.
    #[error(
        "the mesh falls into more than {most} convex cells by the planes of its faces; use a coarser mesh, or one with fewer hollows"
    )]
    TooManyCells {
        /// Most that a grain may have.
        most: usize,
    },
    /// A mesh that is nearly round.
    #[error("the mesh has {faces} faces; a grain has at most {most}: use a coarser mesh")]
    TooManyFaces {
        /// Faces of the mesh.
        faces: usize,
        /// Most that a grain may have.
        most: usize,
    },
    /// There is no triangle with an area.
    #[error("the mesh has no triangle with an area")]
    EmptyMesh,
}
