//! Bodies that are not convex, from closed meshes: cut by the planes of their own faces into convex cells.
//!
//! A binary partition of space (Fuchs, Kedem and Naylor 1980, "On Visible Surface Generation by A Priori Tree
//! Structures") is built from the faces; its leaves are convex and lie inside or outside as a whole, which the winding
//! number of a point of them tells (Van Oosterom and Strackee 1983, "The Solid Angle of a Plane Triangle", IEEE Trans.
//! Biomed. Eng. 30, 125). Cells that meet share a plane whose numbers are exactly opposite, so that a line leaves
//! the one where it enters the other, to the last bit: their union has no seams.

use super::convex::{ConvexBody, Face};
use super::hull::check_closed;
use super::measure::{self, Measured};
use super::{Shape, build};
use crate::{GeometryError, TriangleMesh};
use core::f64::consts::TAU;
use snowgrain_math::{DMat3, DVec3, trig};

/// Convex cells that a grain may have, and distinct planes of a mesh.
const MOST_CELLS: usize = 64;
const MOST_PLANES: usize = 256;
/// How far, in sizes of the mesh, its vertices may lie off the planes that they should lie on.
const FLAT: f64 = 1e-5;
/// Cosine from which normals are those of one plane.
const SAME_NORMAL: f64 = 1.0 - 1e-7;
/// Cosine from which normals are parallel.
const SAME_DIRECTION: f64 = 1.0 - 1e-12;
/// Half the edge of the box in which the mesh, of size 1, is cut.
const BOX: f64 = 2.0;
/// Cells of less volume are none.
const NO_VOLUME: f64 = 1e-14;

impl Shape {
    /// The body of a closed mesh, convex or not, its centre of mass at the origin.
    ///
    /// # Errors
    /// As [`Self::of_convex_mesh`], but that it need not be convex; a mesh that crosses itself or is inside out, or that
    /// falls into more than 64 convex cells.
    pub fn of_mesh(mesh: &TriangleMesh) -> Result<Self, GeometryError> {
        match Self::of_convex_mesh(mesh) {
            Err(GeometryError::NotConvex) => Self::of_cells(cells_of(mesh)?),
            other => other,
        }
    }

    /// The union of convex cells that do not overlap, each behind its planes, moved so that its centre of mass is at the
    /// origin.
    ///
    /// # Errors
    /// No cells, or planes that do not close one.
    pub(super) fn of_cells(cells: Vec<Vec<Face>>) -> Result<Self, GeometryError> {
        let mut name = format!("cells {}", cells.len());
        for faces in &cells {
            name += &format!(" {}", faces.len());
            let numbers =
                faces.iter().flat_map(|Face { normal: n, distance }| [n.x, n.y, n.z, *distance]);
            name = numbers.fold(name, |name, number| format!("{name} {number:e}"));
        }
        let bodies: Vec<ConvexBody> =
            cells.into_iter().map(|faces| ConvexBody { faces, ellipsoid: None }).collect();
        let size = 4.0 * BOX;
        let (mut volume, mut moment) = (0.0, DVec3::ZERO);
        for body in &bodies {
            let measure = body.measure(size);
            if body.faces.len() < 4 || !(measure.volume > 0.0 && measure.volume < size) {
                let reason = "its faces do not close a cell".into();
                return Err(GeometryError::BadShape { key: "faces", reason });
            }
            volume += measure.volume;
            moment += measure.moment;
        }
        if bodies.is_empty() {
            return Err(GeometryError::BadShape { key: "faces", reason: "it has no cells".into() });
        }
        let center = moment / volume;
        let parts: Vec<ConvexBody> =
            bodies.iter().map(|body| body.placed(DMat3::IDENTITY, 1.0, -center)).collect();
        let by_lines = measure::of_union(&parts, size);
        let surface_area = measure::outer_area(&parts, size);
        Ok(build::scaled(name, parts, &Measured { volume, surface_area, ..by_lines }))
    }

    /// The prototype whose name has these numbers after the word `cells`; `None` where they are none.
    pub(super) fn of_cell_numbers(numbers: &[f64]) -> Option<Result<Self, GeometryError>> {
        let (&count, mut rest) = numbers.split_first()?;
        let mut cells = Vec::new();
        for _ in 0..whole(count).filter(|&count| count <= MOST_CELLS)? {
            let (&faces, after) = rest.split_first()?;
            let faces = whole(faces).filter(|&faces| faces <= MOST_PLANES + 6)?;
            let (of_cell, after) = after.split_at_checked(4 * faces)?;
            let face = |n: &[f64; 4]| Face { normal: DVec3::new(n[0], n[1], n[2]), distance: n[3] };
            cells.push(of_cell.as_chunks::<4>().0.iter().map(face).collect());
            rest = after;
        }
        rest.is_empty().then(|| Self::of_cells(cells))
    }
}

/// A small whole number.
fn whole(number: f64) -> Option<usize> {
    ((0.0..1e6).contains(&number) && number == number.floor()).then_some(number as usize)
}

/// A piece of a face of the mesh.
#[derive(Clone)]
struct Piece {
    plane: usize,
    corners: Vec<DVec3>,
}

/// The faces of a mesh of size 1 around the origin, and the planes that they lie on.
struct Solid {
    planes: Vec<Face>,
    triangles: Vec<[DVec3; 3]>,
}

/// The convex cells of a closed mesh, made as large as 1.
///
/// # Errors
/// As of [`Shape::of_mesh`].
fn cells_of(mesh: &TriangleMesh) -> Result<Vec<Vec<Face>>, GeometryError> {
    check_closed(mesh)?;
    let corners = || mesh.triangles.iter().flatten().map(|&v| mesh.positions[v as usize]);
    let middle = corners().sum::<DVec3>() / corners().count() as f64;
    let size = corners().map(|corner| (corner - middle).length()).fold(0.0, f64::max);
    let mut solid = Solid { planes: Vec::new(), triangles: Vec::new() };
    let mut pieces = Vec::new();
    for triangle in &mesh.triangles {
        let triangle = triangle.map(|v| (mesh.positions[v as usize] - middle) / size);
        if let Some(plane) = solid.plane_of(triangle) {
            pieces.push(Piece { plane, corners: triangle.to_vec() });
            solid.triangles.push(triangle);
        }
    }
    if solid.planes.len() > MOST_PLANES {
        let (faces, most) = (solid.planes.len(), MOST_PLANES);
        return Err(GeometryError::TooManyFaces { faces, most });
    }
    let mut cells = Vec::new();
    solid.cut(&pieces, &mut around(), &mut cells)?;
    Ok(cells)
}

/// The box in which the mesh is cut.
fn around() -> Vec<Face> {
    [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z]
        .map(|normal| Face { normal, distance: BOX })
        .to_vec()
}

/// The planes of a region, of each direction the nearest.
fn nearest(region: &[Face]) -> Vec<Face> {
    let hides = |nearer: &Face, face: &Face| {
        nearer.normal.dot(face.normal) > SAME_DIRECTION && nearer.distance < face.distance
    };
    let shows = |face: &&Face| !region.iter().any(|other| hides(other, face));
    region.iter().filter(shows).copied().collect()
}

impl Solid {
    /// The plane of a triangle, which may be that of others that face the other way; `None` without area.
    fn plane_of(&mut self, [a, b, c]: [DVec3; 3]) -> Option<usize> {
        let normal = (b - a).cross(c - a).try_normalize()?;
        let distance = normal.dot((a + b + c) / 3.0);
        let is_same = |known: &Face| {
            let cosine = known.normal.dot(normal);
            cosine.abs() > SAME_NORMAL && (known.distance - distance * cosine.signum()).abs() < FLAT
        };
        let known = self.planes.iter().position(is_same);
        Some(known.unwrap_or_else(|| {
            self.planes.push(Face { normal, distance });
            self.planes.len() - 1
        }))
    }

    /// Cuts the region behind `region` by the planes of the pieces in it, and adds the cells of the solid.
    fn cut(
        &self,
        pieces: &[Piece],
        region: &mut Vec<Face>,
        cells: &mut Vec<Vec<Face>>,
    ) -> Result<(), GeometryError> {
        let Some(plane) = self.best_plane(pieces) else { return self.add(region, cells) };
        let face = self.planes[plane];
        let opposite = Face { normal: -face.normal, distance: -face.distance };
        let [above, below] = self.split(pieces, plane);
        for (side, pieces) in [(opposite, above), (face, below)] {
            region.push(side);
            self.cut(&pieces, region, cells)?;
            region.pop();
        }
        Ok(())
    }

    /// The plane that cuts fewest pieces.
    fn best_plane(&self, pieces: &[Piece]) -> Option<usize> {
        let mut candidates: Vec<usize> = pieces.iter().map(|piece| piece.plane).collect();
        candidates.sort_unstable();
        candidates.dedup();
        let cuts = |plane: usize| {
            let is_cut = |piece: &&Piece| {
                let [low, high] = self.heights(piece, plane);
                low < -FLAT && high > FLAT
            };
            pieces.iter().filter(is_cut).count()
        };
        candidates.into_iter().min_by_key(|&plane| cuts(plane))
    }

    /// The least and the greatest height of a piece's corners above a plane; 0 of a piece of that plane.
    fn heights(&self, piece: &Piece, plane: usize) -> [f64; 2] {
        if piece.plane == plane {
            return [0.0; 2];
        }
        let Face { normal, distance } = self.planes[plane];
        let heights = piece.corners.iter().map(|corner| normal.dot(*corner) - distance);
        heights.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], h| [low.min(h), high.max(h)])
    }

    /// The pieces above a plane and below it, without those in it.
    fn split(&self, pieces: &[Piece], plane: usize) -> [Vec<Piece>; 2] {
        let face = self.planes[plane];
        let opposite = Face { normal: -face.normal, distance: -face.distance };
        let (mut above, mut below) = (Vec::new(), Vec::new());
        for piece in pieces {
            let [low, high] = self.heights(piece, plane);
            for (reaches, behind, side) in
                [(high > FLAT, &opposite, &mut above), (low < -FLAT, &face, &mut below)]
            {
                if reaches {
                    let corners = super::convex::clipped(&piece.corners, behind);
                    side.push(Piece { plane: piece.plane, corners });
                }
            }
        }
        [above, below]
    }

    /// Adds a region that no face cuts, if it lies inside.
    fn add(&self, region: &[Face], cells: &mut Vec<Vec<Face>>) -> Result<(), GeometryError> {
        let body = ConvexBody { faces: nearest(region), ellipsoid: None };
        let measure = body.measure(4.0 * BOX);
        if measure.volume < NO_VOLUME {
            return Ok(());
        }
        match self.winding(measure.moment / measure.volume) {
            0 => return Ok(()),
            1 => {}
            -1 => return Err(GeometryError::InsideOut),
            _ => return Err(GeometryError::CrossingMesh),
        }
        if cells.len() == MOST_CELLS {
            return Err(GeometryError::TooManyCells { most: MOST_CELLS });
        }
        let shows = body.polygons(4.0 * BOX);
        let faces = body.faces.iter().zip(&shows).filter(|(_, corners)| !corners.is_empty());
        let faces: Vec<Face> = faces.map(|(face, _)| *face).collect();
        // What is as thin as rounding keeps all its planes.
        let trimmed = ConvexBody { faces, ellipsoid: None };
        let is_closed = (trimmed.measure(4.0 * BOX).volume / measure.volume - 1.0).abs() < 1e-6;
        cells.push(if is_closed { trimmed.faces } else { body.faces });
        Ok(())
    }

    /// How often the mesh goes around a point that does not lie on it.
    fn winding(&self, point: DVec3) -> i32 {
        let solid_angle = |corners: &[DVec3; 3]| {
            let [a, b, c] = corners.map(|corner| corner - point);
            let (la, lb, lc) = (a.length(), b.length(), c.length());
            let volume = a.dot(b.cross(c));
            let rest = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
            2.0 * trig::atan2(volume, rest)
        };
        let whole: f64 = self.triangles.iter().map(solid_angle).sum();
        (whole / (2.0 * TAU)).round() as i32
    }
}
