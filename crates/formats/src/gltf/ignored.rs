//! What of a document shows in no picture yet, counted for one line.

use super::document::{Document, Material};

#[derive(Default)]
pub(super) struct Ignored {
    animations: usize,
    skins: usize,
    /// Primitives with morph targets, of which the base is taken.
    pub(super) targets: usize,
    /// Points, lines, and triangles without area.
    pub(super) primitives: usize,
    /// Textures without coordinates on their mesh.
    pub(super) unplaced_textures: usize,
    /// Textures whose image is in a format that is not read.
    pub(super) unread_textures: usize,
    /// Materials that are smoother than matt, but no metal.
    pub(super) glossy: usize,
    normal_maps: usize,
    glowing: usize,
    transparent: usize,
}

impl Ignored {
    pub(super) fn of(document: &Document) -> Self {
        let (animations, skins) = (document.animations.len(), document.skins.len());
        Self { animations, skins, ..Self::default() }
    }

    pub(super) fn count_material(&mut self, material: &Material) {
        self.normal_maps += usize::from(material.normal_texture.is_some());
        self.glowing += usize::from(material.emissive_factor.is_some_and(|e| e != [0.0; 3]));
        let opaque = material.alpha_mode.as_ref().is_none_or(|mode| mode == "OPAQUE");
        self.transparent += usize::from(!opaque);
    }

    /// What was passed over, if anything.
    pub(super) fn line(&self) -> Option<String> {
        let counts = [
            (
                self.unplaced_textures,
                "textures of meshes without coordinates (their mean is taken)",
            ),
            (self.unread_textures, "textures in formats that are not read (half is taken)"),
            (self.glossy, "glossy materials that are no metal (taken as matt)"),
            (self.normal_maps, "normal maps"),
            (self.glowing, "glowing materials"),
            (self.transparent, "transparent materials (taken as opaque)"),
            (self.animations, "animations"),
            (self.skins, "skins"),
            (self.targets, "meshes with morph targets (their base is taken)"),
            (self.primitives, "sets of points, lines or triangles without area"),
        ];
        let said: Vec<_> = counts
            .iter()
            .filter(|(count, _)| *count > 0)
            .map(|(count, what)| format!("{count} {what}"))
            .collect();
        (!said.is_empty()).then(|| said.join(", "))
    }
}
