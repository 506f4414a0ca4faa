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
#[cfg(test)]
mod tests;
mod texture;
mod uri;

use crate::error::{Fault, FormatsError, room};
use crate::input;
use container::Container;
use document::{LightKind, MEND, Material, named};
use graph::Placed;
use ignored::Ignored;
use snowgrain_geometry::TriangleMesh;
use snowgrain_math::{Aabb, DAffine3, DVec3};
use std::collections::HashMap;
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
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImportedMaterial {
    /// Base colour, linear sRGB, each 0 to 1: the factor times the mean of the texture.
    pub base_colour: [f32; 3],
    /// Metalness, 0 to 1.
    pub metallic: f32,
    /// Roughness, 0 to 1.
    pub roughness: f32,
}

impl ImportedMaterial {
    /// Of an object that names no material: half of the light, as of objects in scene files.
    const NONE: Self = Self { base_colour: [0.5; 3], metallic: 0.0, roughness: 1.0 };
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
    crate::mesh::mesh(positions, triangles)
}

fn import(bytes: &[u8], folder: &Path) -> Result<ImportedScene, Fault> {
    let container = Container::read(bytes, folder)?;
    let mut reader = Reader {
        container: &container,
        folder,
        meshes: HashMap::new(),
        materials: HashMap::new(),
        ignored: Ignored::of(&container.document),
        scene: ImportedScene::default(),
    };
    for placed in graph::nodes(&container.document)? {
        reader.node(&placed)?;
    }
    let Reader { mut scene, ignored, .. } = reader;
    if scene.objects.is_empty() {
        let what = "its scene has no triangle with an area";
        return Err(Fault::whole(what, "export it with its meshes"));
    }
    scene.ignored = ignored.line();
    Ok(scene)
}

/// A document on its way into a scene.
struct Reader<'a> {
    container: &'a Container,
    folder: &'a Path,
    /// The primitives of each mesh that is used, with their materials.
    meshes: HashMap<usize, Primitives>,
    materials: HashMap<usize, ImportedMaterial>,
    ignored: Ignored,
    scene: ImportedScene,
}

/// The primitives of a mesh that have triangles.
type Primitives = Arc<[(Arc<TriangleMesh>, ImportedMaterial)]>;

impl Reader<'_> {
    fn node(&mut self, placed: &Placed<'_>) -> Result<(), Fault> {
        if let Some(mesh) = placed.node.mesh {
            self.objects(placed, mesh)?;
        }
        if let Some(camera) = placed.node.camera {
            let camera = self.camera(placed, camera)?;
            self.scene.cameras.push(camera);
        }
        if let Some(light) = &placed.node.extensions.light {
            let light = self.light(placed, light.light)?;
            self.scene.lights.push(light);
        }
        Ok(())
    }

    fn objects(&mut self, placed: &Placed<'_>, mesh: usize) -> Result<(), Fault> {
        let primitives = self.primitives(mesh, &placed.name)?;
        if primitives.is_empty() {
            return Ok(());
        }
        let determinant = placed.transform.matrix3.determinant();
        if !(determinant.abs() > 1e-36 && determinant.is_finite()) {
            let what = format!("{} flattens its mesh (a scale of 0)", placed.name);
            return Err(Fault::whole(what, MEND));
        }
        let own = self.container.document.meshes[mesh].name.as_ref();
        let name = placed.node.name.as_ref().or(own).unwrap_or(&placed.name);
        for (mesh, material) in primitives.iter() {
            self.scene.objects.push(ImportedObject {
                name: name.clone(),
                mesh: Arc::clone(mesh),
                transform: placed.transform,
                material: *material,
            });
        }
        Ok(())
    }

    fn primitives(&mut self, index: usize, owner: &str) -> Result<Primitives, Fault> {
        if let Some(known) = self.meshes.get(&index) {
            return Ok(Arc::clone(known));
        }
        let mesh = named(&self.container.document.meshes, "meshes", index, owner)?;
        let mut primitives = Vec::new();
        for (i, primitive) in mesh.primitives.iter().enumerate() {
            let own = format!("meshes[{index}].primitives[{i}]");
            match primitive::mesh(self.container, primitive, &own)? {
                Some(mesh) => {
                    let material = self.material(primitive.material, &own)?;
                    self.ignored.targets += usize::from(!primitive.targets.is_empty());
                    primitives.push((Arc::new(mesh), material));
                }
                None => self.ignored.primitives += 1,
            }
        }
        let primitives = Primitives::from(primitives);
        self.meshes.insert(index, Arc::clone(&primitives));
        Ok(primitives)
    }

    fn material(&mut self, index: Option<usize>, owner: &str) -> Result<ImportedMaterial, Fault> {
        let Some(index) = index else { return Ok(ImportedMaterial::NONE) };
        if let Some(&known) = self.materials.get(&index) {
            return Ok(known);
        }
        let material = named(&self.container.document.materials, "materials", index, owner)?;
        let own = format!("materials[{index}]");
        let factors = check_factors(material, &own)?;
        self.ignored.count_material(material);
        let base_colour = match &material.pbr_metallic_roughness.base_color_texture {
            None => factors.base_colour,
            Some(texture) => match self.mean_colour(texture.index, &own)? {
                Some(mean) => std::array::from_fn(|i| factors.base_colour[i] * mean[i]),
                None => {
                    self.ignored.unread_textures += 1;
                    factors.base_colour.map(|factor| 0.5 * factor)
                }
            },
        };
        let material = ImportedMaterial { base_colour, ..factors };
        self.materials.insert(index, material);
        Ok(material)
    }

    /// The mean colour of a texture, linear sRGB; `None` for an image that cannot be read.
    fn mean_colour(&mut self, texture: usize, owner: &str) -> Result<Option<[f32; 3]>, Fault> {
        let document = &self.container.document;
        let own = format!("textures[{texture}]");
        let texture = named(&document.textures, "textures", texture, owner)?;
        let Some(source) = texture.source else { return Ok(None) };
        let image = named(&document.images, "images", source, &own)?;
        let own = format!("images[{source}]");
        let mean = match (image.buffer_view, &image.uri) {
            (Some(view), _) => texture::mean_colour(self.container.view(view, &own)?.1),
            (None, Some(uri)) => texture::mean_colour(&uri::read(uri, &own, self.folder)?),
            (None, None) => return Err(Fault::whole(format!("{own} has no data"), MEND)),
        };
        Ok(mean)
    }

    fn camera(&self, placed: &Placed<'_>, index: usize) -> Result<ImportedCamera, Fault> {
        let document = &self.container.document;
        let camera = named(&document.cameras, "cameras", index, &placed.name)?;
        let own = format!("cameras[{index}]");
        let bad = |what: &str| Fault::whole(format!("{own} {what}"), MEND);
        // The magnification of parallel rays follows the scale of the node, angles do not.
        let up = placed.transform.transform_vector3(DVec3::Y);
        let (projection, aspect) = match (&camera.perspective, &camera.orthographic) {
            (Some(perspective), _) => {
                let vertical_fov_degrees = perspective.yfov.to_degrees();
                if !(vertical_fov_degrees > 0.0 && vertical_fov_degrees < 180.0) {
                    return Err(bad("has a field of view that is not between 0 and pi"));
                }
                let projection = ImportedProjection::Perspective { vertical_fov_degrees };
                (projection, perspective.aspect_ratio)
            }
            (None, Some(parallel)) => {
                let height = 2.0 * parallel.ymag.abs() * up.length();
                if !(height > 0.0 && height.is_finite()) {
                    return Err(bad("shows a height of nothing"));
                }
                let aspect = (parallel.xmag / parallel.ymag).abs();
                (ImportedProjection::Orthographic { height }, Some(aspect))
            }
            (None, None) => return Err(bad("is neither perspective nor orthographic")),
        };
        let direction = |vector: DVec3| {
            let along = placed.transform.transform_vector3(vector).try_normalize();
            along.ok_or_else(|| bad("is scaled to nothing"))
        };
        let name = placed.node.name.as_ref().or(camera.name.as_ref()).unwrap_or(&own);
        let (gaze, up) = (direction(DVec3::NEG_Z)?, direction(DVec3::Y)?);
        if gaze.cross(up).length() < 1e-6 {
            return Err(bad("is scaled to nothing"));
        }
        Ok(ImportedCamera {
            name: name.clone(),
            from: placed.transform.translation,
            gaze,
            up,
            projection,
            aspect: aspect.filter(|aspect| (1e-3..=1e3).contains(aspect)),
        })
    }

    fn light(&self, placed: &Placed<'_>, index: usize) -> Result<ImportedLight, Fault> {
        let lights = &self.container.document.extensions.lights.lights;
        let light = named(lights, "lights", index, &placed.name)?;
        let own = format!("lights[{index}]");
        let bad = |what: &str| Fault::whole(format!("{own} {what}"), MEND);
        let positive = |x: f64| x >= 0.0 && x.is_finite();
        if !positive(light.intensity) || !light.color.iter().all(|&c| positive(f64::from(c))) {
            return Err(bad("has a brightness below 0"));
        }
        let position = placed.transform.translation;
        let along = placed.transform.transform_vector3(DVec3::NEG_Z).try_normalize();
        let along = along.ok_or_else(|| bad("is scaled to nothing"));
        let kind = match light.kind {
            LightKind::Directional => {
                ImportedLightKind::Directional { direction: along?, lux: light.intensity }
            }
            LightKind::Point => ImportedLightKind::Point { position, candela: light.intensity },
            LightKind::Spot => {
                let (inner, outer) = (light.spot.inner_cone_angle, light.spot.outer_cone_angle);
                if !(0.0 <= inner && inner < outer && outer <= std::f64::consts::FRAC_PI_2) {
                    return Err(bad("has a cone that is not 0 <= inner < outer <= pi / 2"));
                }
                ImportedLightKind::Spot {
                    position,
                    direction: along?,
                    candela: light.intensity,
                    inner_radians: inner,
                    outer_radians: outer,
                }
            }
        };
        let name = placed.node.name.as_ref().or(light.name.as_ref()).unwrap_or(&own);
        Ok(ImportedLight { name: name.clone(), colour: light.color, kind })
    }
}

/// The factors of a material.
fn check_factors(material: &Material, own: &str) -> Result<ImportedMaterial, Fault> {
    let pbr = &material.pbr_metallic_roughness;
    let [red, green, blue, _] = pbr.base_color_factor;
    let all = [red, green, blue, pbr.metallic_factor, pbr.roughness_factor];
    if !all.iter().all(|factor| (0.0..=1.0).contains(factor)) {
        return Err(Fault::whole(format!("{own} has a factor that is not 0 to 1"), MEND));
    }
    Ok(ImportedMaterial {
        base_colour: [red, green, blue],
        metallic: pbr.metallic_factor,
        roughness: pbr.roughness_factor,
    })
}
