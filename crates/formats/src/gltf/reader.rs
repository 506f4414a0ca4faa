//! From a document to what it holds.

use super::container::Container;
use super::document::{LightKind, MEND, Material, Primitive, named};
use super::graph::{self, Placed};
use super::ignored::Ignored;
use super::primitive::Coordinates;
use super::{
    ImportedCamera, ImportedLight, ImportedLightKind, ImportedMaterial, ImportedObject,
    ImportedProjection, ImportedScene, primitive, uri,
};
use crate::error::Fault;
use crate::texture;
use snowgrain_geometry::TriangleMesh;
use snowgrain_math::DVec3;
use snowgrain_render::surface::Texture;
use std::borrow::Cow;
use std::collections::HashMap;
use std::path::Path;
use std::sync::Arc;

/// The content of a file in `folder`.
pub(super) fn import(bytes: &[u8], folder: &Path) -> Result<ImportedScene, Fault> {
    let container = Container::read(bytes, folder)?;
    let mut reader = Reader {
        container: &container,
        folder,
        meshes: HashMap::new(),
        materials: HashMap::new(),
        textures: HashMap::new(),
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
    /// By image; `None` for those that cannot be read.
    textures: HashMap<usize, Option<Arc<Texture>>>,
    ignored: Ignored,
    scene: ImportedScene,
}

/// Number and bytes of an image.
type Image<'a> = (usize, Cow<'a, [u8]>);

/// The primitives of a mesh that have triangles.
type Primitives = Arc<[(Arc<TriangleMesh>, ImportedMaterial)]>;

impl<'a> Reader<'a> {
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
                material: material.clone(),
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
            let mut material = self.material(primitive.material, &own)?;
            let coordinates = self.coordinates(primitive, &material);
            match primitive::mesh(self.container, primitive, coordinates, &own)? {
                Some(mesh) => {
                    if coordinates.is_none() {
                        self.take_mean(&mut material);
                    }
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
        if let Some(known) = self.materials.get(&index) {
            return Ok(known.clone());
        }
        let material = named(&self.container.document.materials, "materials", index, owner)?;
        let own = format!("materials[{index}]");
        let mut made = check_factors(material, &own)?;
        self.ignored.count_material(material);
        let pbr = &material.pbr_metallic_roughness;
        if let Some(info) = &pbr.metallic_roughness_texture
            && let Some(image) = self.image(info.index, &own)?
            && let Some([_, roughness, metallic]) = texture::mean_of_numbers(&image.1)
        {
            made.roughness *= roughness;
            made.metallic *= metallic;
        }
        if let Some(info) = &pbr.base_color_texture {
            made.texture = self.texture(info.index, &own)?;
            if made.texture.is_none() {
                self.ignored.unread_textures += 1;
                made.base_colour = made.base_colour.map(|factor| 0.5 * factor);
            }
        }
        self.ignored.glossy += usize::from(!made.is_metal() && made.roughness < 1.0);
        self.materials.insert(index, made.clone());
        Ok(made)
    }

    /// The places of a picture on a primitive, where both are there.
    fn coordinates(
        &self,
        primitive: &Primitive,
        material: &ImportedMaterial,
    ) -> Option<Coordinates> {
        material.texture.as_ref()?;
        let material = self.container.document.materials.get(primitive.material?)?;
        let info = material.pbr_metallic_roughness.base_color_texture.as_ref()?;
        let transform = info.extensions.transform;
        let accessor = match transform.tex_coord.unwrap_or(info.tex_coord) {
            0 => primitive.attributes.first_coordinates,
            1 => primitive.attributes.second_coordinates,
            _ => None,
        };
        accessor.map(|accessor| Coordinates { accessor, transform })
    }

    /// Where a picture has no place on a mesh: its mean colour.
    fn take_mean(&mut self, material: &mut ImportedMaterial) {
        if let Some(texture) = material.texture.take() {
            self.ignored.unplaced_textures += 1;
            let mean = texture.mean();
            material.base_colour = std::array::from_fn(|i| material.base_colour[i] * mean[i]);
        }
    }

    /// A texture; `None` for an image that cannot be read.
    fn texture(&mut self, index: usize, owner: &str) -> Result<Option<Arc<Texture>>, Fault> {
        let Some((image, bytes)) = self.image(index, owner)? else { return Ok(None) };
        if let Some(known) = self.textures.get(&image) {
            return Ok(known.clone());
        }
        let texture = texture::decode(&bytes).ok().map(Arc::new);
        self.textures.insert(image, texture.clone());
        Ok(texture)
    }

    /// Number and bytes of the image of a texture; `None` where it is in none that is known.
    fn image(&self, texture: usize, owner: &str) -> Result<Option<Image<'a>>, Fault> {
        let container = self.container;
        let document = &container.document;
        let own = format!("textures[{texture}]");
        let texture = named(&document.textures, "textures", texture, owner)?;
        let Some(source) = texture.source else { return Ok(None) };
        let image = named(&document.images, "images", source, &own)?;
        let own = format!("images[{source}]");
        let bytes = match (image.buffer_view, &image.uri) {
            (Some(view), _) => Cow::Borrowed(container.view(view, &own)?.1),
            (None, Some(uri)) => uri::read(uri, &own, self.folder)?.into(),
            (None, None) => return Err(Fault::whole(format!("{own} has no data"), MEND)),
        };
        Ok(Some((source, bytes)))
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
        texture: None,
        metallic: pbr.metallic_factor,
        roughness: pbr.roughness_factor,
    })
}
