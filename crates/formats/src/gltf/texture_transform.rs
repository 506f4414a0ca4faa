//! `KHR_texture_transform`: where a texture lies by the coordinates of a mesh.

use serde::Deserialize;
use snowgrain_math::trig;

/// What is done to the coordinates of a vertex: they are scaled, turned, moved.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq)]
#[serde(rename_all = "camelCase", default)]
pub(super) struct TextureTransform {
    offset: [f64; 2],
    /// Radians, counter-clockwise in a picture whose second coordinate goes down.
    rotation: f64,
    scale: [f64; 2],
    /// Which of the coordinates of a vertex place the texture, instead of those that it names itself.
    pub(super) tex_coord: Option<usize>,
}

impl Default for TextureTransform {
    fn default() -> Self {
        Self { offset: [0.0; 2], rotation: 0.0, scale: [1.0; 2], tex_coord: None }
    }
}

impl TextureTransform {
    /// The place in the texture of a vertex with these coordinates, both to the right and downwards.
    pub(super) fn apply(&self, [u, v]: [f64; 2]) -> [f64; 2] {
        let [u, v] = [u * self.scale[0], v * self.scale[1]];
        let (sin, cos) = trig::sin_cos(self.rotation);
        [cos * u + sin * v + self.offset[0], cos * v - sin * u + self.offset[1]]
    }
}
