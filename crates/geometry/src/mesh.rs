//! Triangle meshes.

use crate::GeometryError;
use snowgrain_math::{Aabb, DAffine3, DVec3};

/// Triangles that share vertices. Positions in metres; a triangle's geometric normal is
/// `(b - a) x (c - a)`, both sides count as surface.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct TriangleMesh {
    /// Vertex positions, metres.
    pub positions: Vec<DVec3>,
    /// Vertex indices of each triangle.
    pub triangles: Vec<[u32; 3]>,
    /// Where in a picture the corners of each triangle lie, to the right and upwards, 0 to 1 across it;
    /// empty where there is no picture.
    pub coordinates: Vec<[[f32; 2]; 3]>,
}

impl TriangleMesh {
    /// The mesh, checked: every vertex finite, every index in range, at least one triangle with an
    /// area. Triangles without area are dropped.
    ///
    /// # Errors
    /// The first fault found, with its index.
    pub fn new(positions: Vec<DVec3>, triangles: Vec<[u32; 3]>) -> Result<Self, GeometryError> {
        Self::with_coordinates(positions, triangles, Vec::new())
    }

    /// The same with places in a picture for each corner of a triangle, or none at all.
    ///
    /// # Errors
    /// As [`Self::new`]; coordinates of another number than the triangles, or that are not finite.
    pub fn with_coordinates(
        positions: Vec<DVec3>,
        mut triangles: Vec<[u32; 3]>,
        mut coordinates: Vec<[[f32; 2]; 3]>,
    ) -> Result<Self, GeometryError> {
        if let Some(vertex) = positions.iter().position(|p| !p.is_finite()) {
            return Err(GeometryError::VertexNotFinite { vertex });
        }
        let vertices = positions.len();
        for (triangle, corners) in triangles.iter().enumerate() {
            if let Some(&vertex) = corners.iter().find(|&&v| v as usize >= vertices) {
                return Err(GeometryError::VertexOutOfRange { triangle, vertex, vertices });
            }
        }
        if !coordinates.is_empty() && coordinates.len() != triangles.len() {
            let (places, triangles) = (coordinates.len(), triangles.len());
            return Err(GeometryError::CoordinatesOfOthers { places, triangles });
        }
        let finite = |places: &[[f32; 2]; 3]| places.as_flattened().iter().all(|c| c.is_finite());
        if let Some(triangle) = coordinates.iter().position(|places| !finite(places)) {
            return Err(GeometryError::CoordinateNotFinite { triangle });
        }
        let has_area = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|v| positions[v as usize]);
            (b - a).cross(c - a).length_squared() > 0.0
        };
        let mut areas = triangles.iter().map(has_area);
        coordinates.retain(|_| areas.next() == Some(true));
        triangles.retain(has_area);
        if triangles.is_empty() {
            return Err(GeometryError::EmptyMesh);
        }
        Ok(Self { positions, triangles, coordinates })
    }

    /// Corners of triangle `index`.
    #[must_use]
    pub fn corners(&self, index: usize) -> [DVec3; 3] {
        self.triangles[index].map(|v| self.positions[v as usize])
    }

    /// The smallest box around the vertices that triangles use.
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        self.triangles
            .iter()
            .flatten()
            .fold(Aabb::EMPTY, |bounds, &v| bounds.including(self.positions[v as usize]))
    }

    /// The mesh moved by `transform`.
    #[must_use]
    pub fn transformed(&self, transform: &DAffine3) -> Self {
        Self {
            positions: self.positions.iter().map(|&p| transform.transform_point3(p)).collect(),
            triangles: self.triangles.clone(),
            coordinates: self.coordinates.clone(),
        }
    }
}
