//! Wavefront OBJ.

use super::mesh;
use crate::error::{Fault, Place, abridged, room};
use snowgrain_geometry::TriangleMesh;
use snowgrain_math::DVec3;

const MEND: &str = "mend the line or export the mesh again";

/// The mesh of an OBJ file; all objects and groups together.
pub(super) fn parse(bytes: &[u8]) -> Result<TriangleMesh, Fault> {
    let text = String::from_utf8_lossy(bytes);
    Scan::default().whole(&text)?;
    let options = tobj::LoadOptions {
        triangulate: true,
        ignore_points: true,
        ignore_lines: true,
        ..tobj::LoadOptions::default()
    };
    let no_materials = |_: &std::path::Path| tobj::MTLLoadResult::Ok(Default::default());
    let (models, _) = tobj::load_obj_buf(&mut text.as_bytes(), &options, no_materials)
        .map_err(|error| Fault::whole(format!("not a valid OBJ file: {error}"), MEND))?;
    let corners = models.iter().map(|model| model.mesh.indices.len()).sum::<usize>();
    let values = models.iter().map(|model| model.mesh.positions.len()).sum::<usize>();
    let mut positions: Vec<DVec3> = room(values / 3, "vertices")?;
    let mut triangles = room(corners / 3, "triangles")?;
    // The reader gives a corner without coordinates those of the one before.
    let textured = models.iter().all(|model| {
        let mesh = &model.mesh;
        let all = mesh.texcoord_indices.len() == mesh.indices.len();
        all && (!mesh.texcoords.is_empty() || mesh.indices.is_empty())
    });
    let mut coordinates = room(if textured { corners / 3 } else { 0 }, "texture coordinates")?;
    for model in &models {
        let first = u32::try_from(positions.len())
            .map_err(|_| Fault::TooLarge("a mesh of 2^32 vertices".into()))?;
        let (vertices, faces) = (&model.mesh.positions, &model.mesh.indices);
        positions.extend(vertices.chunks_exact(3).map(|p| DVec3::new(p[0], p[1], p[2])));
        let moved = |t: &[u32]| [t[0], t[1], t[2]].map(|vertex| first.saturating_add(vertex));
        triangles.extend(faces.chunks_exact(3).map(moved));
        if textured {
            coordinates.extend(places(&model.mesh));
        }
    }
    mesh(positions, triangles, coordinates)
}

/// Where the corners of each triangle lie in a picture.
fn places(mesh: &tobj::Mesh) -> impl Iterator<Item = [[f32; 2]; 3]> {
    let place = |corner: u32| {
        let at = |axis: usize| {
            let value = mesh.texcoords.get(2 * corner as usize + axis);
            value.map_or(f32::NAN, |&value| value as f32)
        };
        [at(0), at(1)]
    };
    mesh.texcoord_indices.chunks_exact(3).map(move |c| [c[0], c[1], c[2]].map(place))
}

/// A first look at the lines: finds the faults that `tobj` accepts, or reports without their line.
#[derive(Default)]
struct Scan {
    vertices: u64,
    faces: u64,
    /// Largest vertex number of a face, from 1, and its line.
    farthest: (u64, u64),
    /// First line that begins with no keyword of OBJ.
    foreign: Option<(u64, String)>,
}

impl Scan {
    fn whole(mut self, text: &str) -> Result<(), Fault> {
        for (number, line) in (1..).zip(text.lines()) {
            self.line(number, line)?;
        }
        if self.vertices == 0 || self.faces == 0 {
            return Err(self.empty());
        }
        let (vertex, line) = self.farthest;
        if vertex > self.vertices {
            let what = format!(
                "the face names vertex {vertex}, but there are only {} vertices",
                self.vertices
            );
            return Err(Fault::new(Place::Line(line), what, MEND));
        }
        Ok(())
    }

    fn empty(self) -> Fault {
        match self.foreign {
            Some((line, word)) if self.vertices == 0 => {
                let what = format!("this is not an OBJ file: a line begins with {word:?}");
                Fault::new(Place::Line(line), what, "name an OBJ file")
            }
            _ => {
                let missing = if self.vertices == 0 { "vertex (\"v\")" } else { "face (\"f\")" };
                Fault::whole(format!("the mesh has no {missing}"), "export the mesh with faces")
            }
        }
    }

    fn line(&mut self, number: u64, line: &str) -> Result<(), Fault> {
        let mut words = line.split_whitespace();
        let Some(keyword) = words.next() else { return Ok(()) };
        match keyword {
            "v" => self.vertex(number, words),
            "f" => self.face(number, words),
            _ => {
                if self.foreign.is_none() && !is_keyword(keyword) {
                    self.foreign = Some((number, keyword.chars().take(20).collect()));
                }
                Ok(())
            }
        }
    }

    fn vertex<'a>(
        &mut self,
        number: u64,
        mut words: impl Iterator<Item = &'a str>,
    ) -> Result<(), Fault> {
        let fault = |what: String| Err(Fault::new(Place::Line(number), what, MEND));
        for _ in 0..3 {
            let Some(word) = words.next() else {
                return fault("a vertex needs three coordinates".into());
            };
            match word.parse::<f64>() {
                Ok(x) if x.is_finite() => {}
                _ => {
                    let word = abridged(word);
                    return fault(format!("the coordinate {word:?} is not a finite number"));
                }
            }
        }
        self.vertices += 1;
        Ok(())
    }

    fn face<'a>(&mut self, number: u64, words: impl Iterator<Item = &'a str>) -> Result<(), Fault> {
        let fault = |what: String| Err(Fault::new(Place::Line(number), what, MEND));
        let mut corners = 0;
        for word in words {
            let first = word.split('/').next().unwrap_or_default();
            let vertex = match first.parse::<i64>() {
                Ok(vertex) if vertex > 0 => vertex.unsigned_abs(),
                Ok(vertex) if vertex < 0 && vertex.unsigned_abs() <= self.vertices => {
                    self.vertices + 1 - vertex.unsigned_abs()
                }
                Ok(vertex) => {
                    let there = self.vertices;
                    return fault(format!(
                        "the face names vertex {vertex}, but there are {there} vertices before it"
                    ));
                }
                Err(_) => {
                    return fault(format!("{:?} does not name a vertex", abridged(word)));
                }
            };
            corners += 1;
            if vertex > self.farthest.0 {
                self.farthest = (vertex, number);
            }
        }
        if corners == 0 {
            return fault("the face has no corner".into());
        }
        self.faces += 1;
        Ok(())
    }
}

/// Whether a line of an OBJ file may begin with this word.
fn is_keyword(word: &str) -> bool {
    const KEYWORDS: [&str; 35] = [
        "v",
        "vt",
        "vn",
        "vp",
        "f",
        "l",
        "p",
        "o",
        "g",
        "s",
        "mg",
        "usemtl",
        "mtllib",
        "usemap",
        "maplib",
        "cstype",
        "deg",
        "bmat",
        "step",
        "curv",
        "curv2",
        "surf",
        "parm",
        "trim",
        "hole",
        "scrv",
        "sp",
        "end",
        "con",
        "bevel",
        "lod",
        "d_interp",
        "c_interp",
        "shadow_obj",
        "trace_obj",
    ];
    word.starts_with('#') || KEYWORDS.contains(&word)
}
