//! Convex bodies from closed meshes.

use super::convex::{ConvexBody, Face};
use super::{Shape, build};
use crate::{GeometryError, TriangleMesh};
use snowgrain_math::DVec3;
use std::collections::HashMap;

/// Faces that a convex mesh may have.
const MOST_FACES: usize = 256;
/// How far, in sizes of the mesh, its vertices may lie off the planes that they should lie on: files hold
/// single precision.
const FLAT: f64 = 1e-5;
/// Cosine from which normals are those of one face.
const SAME_NORMAL: f64 = 1.0 - 1e-7;

impl Shape {
    /// The body of a closed convex mesh, its centre of mass at the origin.
    ///
    /// # Errors
    /// A mesh that is not closed, whose triangles do not all face outwards, that is not convex, or has too many
    /// faces.
    pub fn of_convex_mesh(mesh: &TriangleMesh) -> Result<Self, GeometryError> {
        check_closed(mesh)?;
        let corners = || mesh.triangles.iter().flatten().map(|&v| mesh.positions[v as usize]);
        let n = corners().count() as f64;
        let middle = corners().sum::<DVec3>() / n;
        let size = corners().map(|corner| (corner - middle).length()).fold(0.0, f64::max);
        let mut faces: Vec<Face> = Vec::new();
        for triangle in &mesh.triangles {
            let [a, b, c] = triangle.map(|v| (mesh.positions[v as usize] - middle) / size);
            let Some(normal) = (b - a).cross(c - a).try_normalize() else { continue };
            let face =
                Face { normal, distance: normal.dot(a).max(normal.dot(b)).max(normal.dot(c)) };
            let is_same = |known: &Face| {
                known.normal.dot(normal) > SAME_NORMAL
                    && (known.distance - face.distance).abs() < FLAT
            };
            if !faces.iter().any(is_same) {
                faces.push(face);
            }
        }
        let outside = |corner: DVec3| {
            let corner = (corner - middle) / size;
            faces.iter().any(|face| face.normal.dot(corner) > face.distance + FLAT)
        };
        if faces.iter().any(|face| face.distance <= 0.0) || corners().any(outside) {
            return Err(GeometryError::NotConvex);
        }
        if faces.len() > MOST_FACES {
            return Err(GeometryError::TooManyFaces { faces: faces.len(), most: MOST_FACES });
        }
        Self::of_faces(faces)
    }

    /// The convex body behind planes that close it around the origin, moved so that its centre of mass is there.
    ///
    /// # Errors
    /// Planes that do not close a body.
    pub fn of_faces(faces: Vec<Face>) -> Result<Self, GeometryError> {
        let numbers =
            faces.iter().flat_map(|Face { normal: n, distance }| [n.x, n.y, n.z, *distance]);
        let name =
            numbers.fold("polyhedron".to_owned(), |name, number| format!("{name} {number:e}"));
        build::centred(ConvexBody { faces, ellipsoid: None })
            .map(|body| build::normalised(name, vec![body]))
    }
}

/// Whether each edge belongs to two triangles that run along it in opposite directions.
pub(super) fn check_closed(mesh: &TriangleMesh) -> Result<(), GeometryError> {
    // Meshes often hold a vertex several times.
    let mut number = HashMap::new();
    let mut numbered = |vertex: u32| {
        let position = mesh.positions[vertex as usize].to_array().map(|x| (x + 0.0).to_bits());
        let next = number.len() as u32;
        *number.entry(position).or_insert(next)
    };
    let mut edges: HashMap<[u32; 2], i32> = HashMap::new();
    for triangle in &mesh.triangles {
        let [a, b, c] = triangle.map(&mut numbered);
        for [from, to] in [[a, b], [b, c], [c, a]] {
            if from != to {
                *edges.entry([from, to]).or_default() += 1;
                *edges.entry([to, from]).or_default() -= 1;
            }
        }
    }
    let open = edges.values().filter(|&&balance| balance > 0).count();
    if open > 0 { Err(GeometryError::OpenMesh { edges: open }) } else { Ok(()) }
}
