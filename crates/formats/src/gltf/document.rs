//! What Snowgrain reads of a glTF document, as the JSON has it; everything else is passed over.
//!
//! Names are those of the specification (Khronos Group, glTF 2.0, section 5). Indices are looked up by
//! [`named`], which refuses those that name nothing.

use super::texture_transform::TextureTransform;
use crate::error::Fault;
use serde::Deserialize;
use serde::de::IgnoredAny;

/// What to do about a document that contradicts itself.
pub(super) const MEND: &str = "export it again";

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Document {
    pub(super) asset: Asset,
    #[serde(default)]
    pub(super) extensions_required: Vec<String>,
    #[serde(default)]
    pub(super) extensions: DocumentExtensions,
    pub(super) scene: Option<usize>,
    #[serde(default)]
    pub(super) scenes: Vec<Scene>,
    #[serde(default)]
    pub(super) nodes: Vec<Node>,
    #[serde(default)]
    pub(super) meshes: Vec<Mesh>,
    #[serde(default)]
    pub(super) accessors: Vec<Accessor>,
    #[serde(default)]
    pub(super) buffer_views: Vec<BufferView>,
    #[serde(default)]
    pub(super) buffers: Vec<Buffer>,
    #[serde(default)]
    pub(super) materials: Vec<Material>,
    #[serde(default)]
    pub(super) textures: Vec<Texture>,
    #[serde(default)]
    pub(super) images: Vec<Image>,
    #[serde(default)]
    pub(super) cameras: Vec<Camera>,
    #[serde(default)]
    pub(super) animations: Vec<IgnoredAny>,
    #[serde(default)]
    pub(super) skins: Vec<IgnoredAny>,
}

#[derive(Debug, Deserialize)]
pub(super) struct Asset {
    pub(super) version: String,
}

#[derive(Debug, Default, Deserialize)]
pub(super) struct DocumentExtensions {
    #[serde(default, rename = "KHR_lights_punctual")]
    pub(super) lights: Lights,
}

#[derive(Debug, Default, Deserialize)]
pub(super) struct Lights {
    #[serde(default)]
    pub(super) lights: Vec<Light>,
}

#[derive(Debug, Deserialize)]
pub(super) struct Light {
    pub(super) name: Option<String>,
    #[serde(rename = "type")]
    pub(super) kind: LightKind,
    #[serde(default = "white")]
    pub(super) color: [f32; 3],
    #[serde(default = "one")]
    pub(super) intensity: f64,
    #[serde(default)]
    pub(super) spot: Spot,
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum LightKind {
    Directional,
    Point,
    Spot,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Spot {
    #[serde(default)]
    pub(super) inner_cone_angle: f64,
    #[serde(default = "quarter")]
    pub(super) outer_cone_angle: f64,
}

impl Default for Spot {
    fn default() -> Self {
        Self { inner_cone_angle: 0.0, outer_cone_angle: quarter() }
    }
}

#[derive(Debug, Deserialize)]
pub(super) struct Scene {
    #[serde(default)]
    pub(super) nodes: Vec<usize>,
}

#[derive(Debug, Deserialize)]
pub(super) struct Node {
    pub(super) name: Option<String>,
    #[serde(default)]
    pub(super) children: Vec<usize>,
    pub(super) matrix: Option<[f64; 16]>,
    pub(super) translation: Option<[f64; 3]>,
    pub(super) rotation: Option<[f64; 4]>,
    pub(super) scale: Option<[f64; 3]>,
    pub(super) mesh: Option<usize>,
    pub(super) camera: Option<usize>,
    #[serde(default)]
    pub(super) extensions: NodeExtensions,
}

#[derive(Debug, Default, Deserialize)]
pub(super) struct NodeExtensions {
    #[serde(rename = "KHR_lights_punctual")]
    pub(super) light: Option<NodeLight>,
}

#[derive(Debug, Deserialize)]
pub(super) struct NodeLight {
    pub(super) light: usize,
}

#[derive(Debug, Deserialize)]
pub(super) struct Mesh {
    pub(super) name: Option<String>,
    pub(super) primitives: Vec<Primitive>,
}

#[derive(Debug, Deserialize)]
pub(super) struct Primitive {
    pub(super) attributes: Attributes,
    pub(super) indices: Option<usize>,
    pub(super) material: Option<usize>,
    #[serde(default = "triangles")]
    pub(super) mode: u32,
    #[serde(default)]
    pub(super) targets: Vec<IgnoredAny>,
}

#[derive(Debug, Deserialize)]
pub(super) struct Attributes {
    #[serde(rename = "POSITION")]
    pub(super) position: Option<usize>,
    #[serde(rename = "TEXCOORD_0")]
    pub(super) first_coordinates: Option<usize>,
    #[serde(rename = "TEXCOORD_1")]
    pub(super) second_coordinates: Option<usize>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Accessor {
    pub(super) buffer_view: Option<usize>,
    #[serde(default)]
    pub(super) byte_offset: u64,
    pub(super) count: u64,
    pub(super) component_type: u32,
    #[serde(rename = "type")]
    pub(super) kind: String,
    #[serde(default)]
    pub(super) normalized: bool,
    pub(super) sparse: Option<Sparse>,
}

#[derive(Debug, Deserialize)]
pub(super) struct Sparse {
    pub(super) count: u64,
    pub(super) indices: SparseIndices,
    pub(super) values: SparseValues,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct SparseIndices {
    pub(super) buffer_view: usize,
    #[serde(default)]
    pub(super) byte_offset: u64,
    pub(super) component_type: u32,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct SparseValues {
    pub(super) buffer_view: usize,
    #[serde(default)]
    pub(super) byte_offset: u64,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct BufferView {
    pub(super) buffer: usize,
    #[serde(default)]
    pub(super) byte_offset: u64,
    pub(super) byte_length: u64,
    pub(super) byte_stride: Option<u64>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Buffer {
    pub(super) byte_length: u64,
    pub(super) uri: Option<String>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Material {
    #[serde(default)]
    pub(super) pbr_metallic_roughness: MetallicRoughness,
    pub(super) normal_texture: Option<IgnoredAny>,
    pub(super) emissive_factor: Option<[f64; 3]>,
    pub(super) alpha_mode: Option<String>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(super) struct MetallicRoughness {
    pub(super) base_color_factor: [f32; 4],
    pub(super) base_color_texture: Option<TextureInfo>,
    pub(super) metallic_roughness_texture: Option<TextureInfo>,
    pub(super) metallic_factor: f32,
    pub(super) roughness_factor: f32,
}

impl Default for MetallicRoughness {
    fn default() -> Self {
        Self {
            base_color_factor: [1.0; 4],
            base_color_texture: None,
            metallic_roughness_texture: None,
            metallic_factor: 1.0,
            roughness_factor: 1.0,
        }
    }
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct TextureInfo {
    pub(super) index: usize,
    /// Which of the coordinates of a vertex place it.
    #[serde(default)]
    pub(super) tex_coord: usize,
    #[serde(default)]
    pub(super) extensions: TextureExtensions,
}

#[derive(Debug, Default, Deserialize)]
pub(super) struct TextureExtensions {
    #[serde(rename = "KHR_texture_transform", default)]
    pub(super) transform: TextureTransform,
}

#[derive(Debug, Deserialize)]
pub(super) struct Texture {
    pub(super) source: Option<usize>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Image {
    pub(super) buffer_view: Option<usize>,
    pub(super) uri: Option<String>,
}

#[derive(Debug, Deserialize)]
pub(super) struct Camera {
    pub(super) name: Option<String>,
    pub(super) perspective: Option<Perspective>,
    pub(super) orthographic: Option<Orthographic>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Perspective {
    pub(super) yfov: f64,
    pub(super) aspect_ratio: Option<f64>,
}

#[derive(Debug, Deserialize)]
pub(super) struct Orthographic {
    pub(super) xmag: f64,
    pub(super) ymag: f64,
}

fn white() -> [f32; 3] {
    [1.0; 3]
}

fn one() -> f64 {
    1.0
}

fn quarter() -> f64 {
    std::f64::consts::FRAC_PI_4
}

fn triangles() -> u32 {
    4
}

/// The item of a list that `owner` names, as "buffers" number 3.
pub(super) fn named<'a, T>(
    list: &'a [T],
    list_name: &str,
    index: usize,
    owner: &str,
) -> Result<&'a T, Fault> {
    list.get(index).ok_or_else(|| {
        let what = format!("{owner} names {list_name}[{index}], but there are {}", list.len());
        Fault::whole(what, MEND)
    })
}

impl Document {
    /// The document, if it is of a version and needs only extensions that can be read, or that show
    /// in nothing but looks.
    pub(super) fn parse(json: &[u8]) -> Result<Self, Fault> {
        let document: Self = serde_json::from_slice(json).map_err(|error| {
            Fault::whole(
                format!("this is not a glTF document: {error}"),
                "name a .gltf or .glb file",
            )
        })?;
        if document.asset.version != "2.0" && !document.asset.version.starts_with("2.") {
            let version: String = document.asset.version.chars().take(20).collect();
            let what = format!("glTF version {version:?} is not known (this reads 2.0)");
            return Err(Fault::whole(what, "export it as glTF 2.0"));
        }
        let readable = |name: &&String| {
            ["KHR_lights_punctual", "KHR_mesh_quantization", "KHR_texture_transform"]
                .contains(&name.as_str())
                || name.starts_with("KHR_materials_")
        };
        match document.extensions_required.iter().find(|name| !readable(name)) {
            None => Ok(document),
            Some(name) => {
                let name: String = name.chars().take(60).collect();
                let what = format!("it cannot be read without the extension {name:?}");
                Err(Fault::whole(what, "export it without compression and extensions"))
            }
        }
    }
}
