//! Snow of a kind for a mesh or shot that comes alone.

use super::document::SnowKindName;
use super::mesh_scene::rounded;
use snowgrain_grains::{ICE_DENSITY, Radii};

/// Most grains of the quick look: beyond, the snow is less deep than it would be else.
const MOST_GRAINS: f64 = 4e6;

/// As much snow of a kind as suits a picture.
pub(super) struct KindSnow {
    kind: SnowKindName,
    grains: u64,
    /// Part of the depth asked for that these grains fill.
    part: f64,
}

impl KindSnow {
    /// Of this volume, cubic metres, if that takes no more than [`MOST_GRAINS`].
    pub(super) fn new(kind: SnowKindName, volume: f64) -> Self {
        let radii = Radii::log_normal(kind.radius_metres(), kind.spread())
            .expect("the sizes of a kind are in range");
        let ball = 4.0 / 3.0 * std::f64::consts::PI * radii.mean_cube();
        let wanted = volume * kind.density() / ICE_DENSITY / ball;
        let grains = wanted.clamp(1.0, MOST_GRAINS).ceil();
        Self { kind, grains: grains as u64, part: (grains / wanted).min(1.0) }
    }

    /// Keys of the snow.
    pub(super) fn keys(&self) -> String {
        format!("kind = \"{}\"\ngrains = {}\n", self.kind.name(), self.grains)
    }

    /// What to tell the user of it; `depth` as asked for, metres.
    pub(super) fn told(&self, depth: f64) -> String {
        let millimetres = rounded(depth * self.part * 1e3);
        format!("{} grains of {}, about {millimetres:.1} mm deep", self.grains, self.kind.name())
    }
}
