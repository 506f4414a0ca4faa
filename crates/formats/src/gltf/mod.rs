//! glTF 2.0 (`.gltf`, `.glb`): objects, cameras and lights of a shot. Metres, y up, as the format has
//! it.
//!
//! Read here from the JSON on, since files come from anywhere: the usual crate panics on indices that
//! name nothing, and Snowgrain needs only what [`document`] lists. Sizes are compared with the bytes
//! there are before memory is taken, and no file outside the document's folder is opened ([`uri`]).

mod accessor;
mod container;
mod document;
mod graph;
mod ignored;
mod primitive;
mod reader;
#[cfg(test)]
mod tests;
mod texture_transform;
mod uri;

use crate::error::{Fault, FormatsError, room};
use crate::input;
use reader::import;
use snowgrain_geometry::TriangleMesh;
use snowgrain_math::{Aabb, DAffine3, DVec3};
use snowgrain_render::surface::Texture;
use std::path::Path;
use std::sync::Arc;

/// What a glTF file holds, in metres, y up.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ImportedScene {
    /// Objects, those of the same mesh sharing it.
    pub objects: Vec<ImportedObject>,
    /// Cameras of the scene.
    pub cameras: Vec<ImportedCamera>,
    /// Lights of the scene (KHR_lights_punctual).
    pub lights: Vec<ImportedLight>,
    /// What was passed over, in one line; `None` where nothing was.
    pub ignored: Option<String>,
}

impl ImportedScene {
    /// The smallest box around all triangles, metres.
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        let mut bounds = Aabb::EMPTY;
        for object in &self.objects {
            let corners = object.mesh.triangles.iter().flatten();
            for &vertex in corners {
                let position = object.mesh.positions[vertex as usize];
                bounds = bounds.including(object.transform.transform_point3(position));
            }
        }
        bounds
    }
}

/// A mesh in one place.
#[derive(Clone, Debug, PartialEq)]
pub struct ImportedObject {
    /// Name of its node, else of its mesh, else its number.
    pub name: String,
    /// Triangles in their own space.
    pub mesh: Arc<TriangleMesh>,
    /// Own space to world.
    pub transform: DAffine3,
    /// What it is made of.
    pub material: ImportedMaterial,
}

/// The metallic-roughness material of an object.
#[derive(Clone, Debug, PartialEq)]
pub struct ImportedMaterial {
    /// Factor of the base colour, linear sRGB, each 0 to 1.
    pub base_colour: [f32; 3],
    /// Picture of the base colour, by which the factor is multiplied; there only if the mesh has places
    /// for it.
    pub texture: Option<Arc<Texture>>,
    /// Metalness, 0 to 1.
    pub metallic: f32,
    /// Roughness, 0 to 1.
    pub roughness: f32,
}

impl ImportedMaterial {
    /// Of an object that names no material: half of the light, as of objects in scene files.
    const NONE: Self = Self { base_colour: [0.5; 3], texture: None, metallic: 0.0, roughness: 1.0 };

    /// Whether it is more metal than not.
    pub(crate) fn is_metal(&self) -> bool {
        self.metallic >= 0.5
    }
}

/// A camera.
#[derive(Clone, Debug, PartialEq)]
pub struct ImportedCamera {
    /// Name of its node, else its own, else its number.
    pub name: String,
    /// Where it is, metres.
    pub from: DVec3,
    /// Unit vector along which it looks.
    pub gaze: DVec3,
    /// Unit vector that is up in the picture.
    pub up: DVec3,
    /// How points come to the picture.
    pub projection: ImportedProjection,
    /// Width of the picture over its height, where the file says it.
    pub aspect: Option<f64>,
}

/// Projections of cameras.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ImportedProjection {
    /// Vertical field of view, degrees, in (0, 180).
    Perspective {
        /// Degrees.
        vertical_fov_degrees: f64,
    },
    /// Parallel rays.
    Orthographic {
        /// How much of the world the picture is high, metres.
        height: f64,
    },
}

/// A light of KHR_lights_punctual. Colours are linear sRGB that tint the intensity.
#[derive(Clone, Debug, PartialEq)]
pub struct ImportedLight {
    /// Name of its node, else its own, else its number.
    pub name: String,
    /// Colour, linear sRGB, at least 0.
    pub colour: [f32; 3],
    /// What it is, and how bright.
    pub kind: ImportedLightKind,
}

/// Kinds of lights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ImportedLightKind {
    /// Parallel light.
    Directional {
        /// Unit vector along which the light travels.
        direction: DVec3,
        /// Illuminance across the light, lux.
        lux: f64,
    },
    /// A point that shines evenly.
    Point {
        /// Metres.
        position: DVec3,
        /// Intensity, candela.
        candela: f64,
    },
    /// A point that shines into a cone.
    Spot {
        /// Metres.
        position: DVec3,
        /// Unit vector along its axis.
        direction: DVec3,
        /// Intensity on the axis, candela.
        candela: f64,
        /// Where it begins to fall off, radians from the axis.
        inner_radians: f64,
        /// Where it ends, radians from the axis.
        outer_radians: f64,
    },
}

/// Reads a `.gltf` or `.glb` file.
///
/// # Errors
/// A missing or unreadable file; content that is not glTF 2.0, with the element at fault; a name of a
/// file that is missing or outside the folder of the document; a scene without a triangle.
pub fn read_gltf(path: &Path) -> Result<ImportedScene, FormatsError> {
    let bytes = input::read_whole(path)?;
    let folder = path.parent().unwrap_or(Path::new(""));
    import(&bytes, folder).map_err(|fault| fault.of(path))
}

/// All triangles of a `.gltf` or `.glb` file as one mesh, each where its node puts it.
pub(crate) fn joined_mesh(bytes: &[u8], path: &Path) -> Result<TriangleMesh, Fault> {
    let scene = import(bytes, path.parent().unwrap_or(Path::new("")))?;
    let count = |of: fn(&TriangleMesh) -> usize| {
        scene.objects.iter().fold(0usize, |sum, object| sum.saturating_add(of(&object.mesh)))
    };
    let mut positions = room(count(|mesh| mesh.positions.len()), "vertices")?;
    let mut triangles = room(count(|mesh| mesh.triangles.len()), "triangles")?;
    for object in &scene.objects {
        let first = positions.len();
        let end = first + object.mesh.positions.len();
        u32::try_from(end).map_err(|_| Fault::TooLarge("a mesh of 2^32 vertices".into()))?;
        let moved = |&p: &DVec3| object.transform.transform_point3(p);
        positions.extend(object.mesh.positions.iter().map(moved));
        let from_first = |t: &[u32; 3]| t.map(|vertex| first as u32 + vertex);
        triangles.extend(object.mesh.triangles.iter().map(from_first));
    }
    crate::mesh::mesh(positions, triangles, Vec::new())
}
