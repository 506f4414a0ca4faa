//! Meshes in PLY files, and the question whether a PLY file holds a mesh or grains.

use super::mesh;
use crate::error::{Fault, FormatsError, Place, room};
use crate::input;
use crate::ply::{Body, Element, Header, Row, Shape};
use snowgrain_geometry::TriangleMesh;
use snowgrain_math::DVec3;
use std::io::BufRead;
use std::path::Path;

const MEND: &str = "export the mesh again, with faces";

/// What a PLY file holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PlyContent {
    /// Vertices with a `radius` and no faces.
    Grains,
    /// Anything else.
    Mesh,
}

/// What a PLY file holds, judged by its header alone.
///
/// # Errors
/// A missing or unreadable file, or one whose header is not that of a PLY file.
pub fn ply_content(path: &Path) -> Result<PlyContent, FormatsError> {
    let (mut reader, length) = input::open(path)?;
    let header = Header::read(&mut reader, length).map_err(|fault| fault.of(path))?;
    Ok(content(&header))
}

pub(crate) fn content(header: &Header) -> PlyContent {
    let has_radius = header.element("vertex").is_some_and(|v| v.property("radius").is_some());
    let has_faces = header.element("face").is_some_and(|faces| faces.count > 0);
    if has_radius && !has_faces { PlyContent::Grains } else { PlyContent::Mesh }
}

/// The mesh of a PLY file of `length` bytes.
pub(super) fn read(mut reader: impl BufRead, length: u64) -> Result<TriangleMesh, Fault> {
    let header = Header::read(&mut reader, length)?;
    if content(&header) == PlyContent::Grains {
        let mend = "name it as the \"file\" of a [[snow]] table";
        return Err(Fault::whole("this file holds grains, not a mesh", mend));
    }
    let mut body = Body::new(reader, &header, length);
    let (mut vertices, mut triangles) = (None, None);
    for element in &header.elements {
        match element.name.as_str() {
            "vertex" => vertices = Some(read_vertices(&mut body, element)?),
            "face" => {
                let count = header.element("vertex").map_or(0, |vertex| vertex.count);
                triangles = Some(read_faces(&mut body, element, count)?);
            }
            _ => body.skip(element)?,
        }
        if vertices.is_some() && triangles.is_some() {
            break;
        }
    }
    let (positions, places) =
        vertices.ok_or_else(|| Fault::whole("the mesh has no vertices", MEND))?;
    let triangles = triangles.ok_or_else(|| Fault::whole("the mesh has no faces", MEND))?;
    let mut coordinates = room(if places.is_empty() { 0 } else { triangles.len() }, "corners")?;
    if !places.is_empty() {
        coordinates.extend(triangles.iter().map(|t| t.map(|vertex| places[vertex as usize])));
    }
    mesh(positions, triangles, coordinates)
}

/// Number of rows of an element, which [`Header::read`] has compared with the file's length.
fn rows(element: &Element) -> Result<usize, Fault> {
    usize::try_from(element.count)
        .map_err(|_| Fault::TooLarge(format!("a list of {} rows", element.count)))
}

/// Indices of the three coordinates of a vertex.
pub(crate) fn coordinates(vertex: &Element) -> Result<[usize; 3], Fault> {
    let mut axes = [0; 3];
    for (axis, name) in axes.iter_mut().zip(["x", "y", "z"]) {
        *axis = single_property(vertex, name)?;
    }
    Ok(axes)
}

/// Index of a property that must be a single number.
pub(crate) fn single_property(element: &Element, name: &str) -> Result<usize, Fault> {
    element
        .property(name)
        .filter(|&at| matches!(element.properties[at].shape, Shape::Single(_)))
        .ok_or_else(|| {
            let what = format!("\"{}\" has no number {name:?}", element.name);
            Fault::whole(what, format!("export the file with a property {name:?}"))
        })
}

/// Positions of vertices, and where they lie in a picture.
type Vertices = (Vec<DVec3>, Vec<[f32; 2]>);

/// Places in a picture are empty where the file has none under the names that programs use.
fn read_vertices(body: &mut Body<impl BufRead>, element: &Element) -> Result<Vertices, Fault> {
    let axes = coordinates(element)?;
    let names = [["s", "t"], ["u", "v"], ["texture_u", "texture_v"]];
    let place = names.iter().find_map(|[u, v]| {
        let [u, v] = [u, v].map(|name| single_property(element, name).ok());
        Some([u?, v?])
    });
    let mut positions = room(rows(element)?, "vertices")?;
    let mut places = room(place.map_or(0, |_| positions.capacity()), "places in a picture")?;
    let mut row = Row::default();
    for vertex in 0..element.count {
        body.read(element, &mut row)?;
        let position = DVec3::from_array(axes.map(|axis| row.numbers[axis]));
        if !position.is_finite() {
            let place = body.place(Place::Vertex(vertex));
            return Err(Fault::new(place, "a coordinate is not a finite number", MEND));
        }
        positions.push(position);
        if let Some(axes) = place {
            places.push(axes.map(|axis| row.numbers[axis] as f32));
        }
    }
    Ok((positions, places))
}

fn read_faces(
    body: &mut Body<impl BufRead>,
    element: &Element,
    vertices: u64,
) -> Result<Vec<[u32; 3]>, Fault> {
    let list = ["vertex_indices", "vertex_index"]
        .iter()
        .find_map(|name| element.property(name))
        .filter(|&at| match element.properties[at].shape {
            Shape::List { item, .. } => item.is_integer(),
            Shape::Single(_) => false,
        })
        .ok_or_else(|| {
            let what = "\"face\" has no list of integers \"vertex_indices\"";
            Fault::whole(what, "export the mesh with vertex indices")
        })?;
    let mut triangles = room(rows(element)?, "faces")?;
    let mut row = Row::default();
    for face in 0..element.count {
        body.read(element, &mut row)?;
        let place = || body.place(Place::Face(face));
        let corners = &row.lists[list];
        if corners.len() < 3 {
            let what = format!("the face has {} corners", corners.len());
            return Err(Fault::new(place(), what, MEND));
        }
        if let Some(bad) = corners.iter().find(|c| !(0.0..vertices as f64).contains(*c)) {
            let what =
                format!("the face names vertex {bad} (from 0), but there are only {vertices}");
            return Err(Fault::new(place(), what, MEND));
        }
        let vertex = |corner: usize| corners[corner] as u32;
        triangles.extend((2..corners.len()).map(|k| [vertex(0), vertex(k - 1), vertex(k)]));
    }
    Ok(triangles)
}
