//! A wide and deep field of snow for light to spread in, and its Lambertian twin.

use super::stage::{Pack, RADIUS, Stage};
use anyhow::Result;

/// Transport length of packed grains of half a millimetre at 275 kg/m^3, metres (section 7 of the
/// project's physics).
pub(super) const TRANSPORT_LENGTH: f64 = 0.0116;

/// The pack of 275 kg/m^3: 20 transport lengths wide and 6 deep, over white ground.
const PACK: Pack = Pack {
    file: "275_kg_m3.ply",
    solid_fraction: 0.3,
    width: 20.0 * TRANSPORT_LENGTH,
    depth: 6.0 * TRANSPORT_LENGTH,
};
/// Distance between columns of pixels, transport lengths.
pub(super) const PIXEL: f64 = 0.25;

/// What a field is made of.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Field {
    Grains,
    /// A diffuse block of the same shape.
    Lambertian,
}

impl Field {
    /// Where along x and z the middle of the field is, and its upper end, metres.
    pub(super) const MIDDLE: f64 = 0.5 * PACK.width;
    pub(super) const TOP: f64 = PACK.depth;

    /// The end of a scene, behind camera, lights and other objects.
    pub(super) fn tables(self, stage: &Stage) -> Result<String> {
        match self {
            Self::Grains => {
                stage.write_pack(&PACK)?;
                Ok(format!(
                    "[[object]]\nshape = \"plane\"\nalbedo = 1\n\n[[snow]]\nsource = \"file\"\nfile = \"{}\"\n",
                    PACK.file
                ))
            }
            Self::Lambertian => {
                let (middle, half) = (Self::MIDDLE, 0.5 * Self::TOP);
                Ok(format!(
                    "[[object]]\nshape = \"box\"\nalbedo = 0.95\nscale = [{middle}, {half}, {middle}]\n\
                     translate = [{middle}, {half}, {middle}]\n"
                ))
            }
        }
    }
}

/// The head of a scene that shows `columns` by `rows` pixels of the middle of a field from above, x to the
/// right.
pub(super) fn from_above(columns: u32, rows: u32) -> String {
    let (middle, top) = (Field::MIDDLE, Field::TOP);
    camera(columns, rows, [middle, top + 0.01, middle])
}

/// The same from another place, by parallel rays.
pub(super) fn camera(columns: u32, rows: u32, from: [f64; 3]) -> String {
    let height = f64::from(rows) * PIXEL * TRANSPORT_LENGTH;
    let (middle, top) = (Field::MIDDLE, Field::TOP);
    format!(
        "version = 1\n\n[film]\nwidth = {columns}\nheight = {rows}\n\n[camera]\nkind = \"orthographic\"\n\
         from = {from:?}\nat = [{middle}, {top}, {middle}]\nup = [0, 0, -1]\nheight = {height}\n\n"
    )
}

/// Grains across a field, to tell of it.
pub(super) fn told() -> String {
    format!(
        "The field is a pack of separate grains at random places, 275 kg/m^3, r = .5 mm, {:.0} by {:.0} by {:.0} mm \
         over white ground ({:.0} radii wide); a transport length l* is {:.1} mm.",
        1e3 * PACK.width,
        1e3 * PACK.width,
        1e3 * PACK.depth,
        PACK.width / RADIUS,
        1e3 * TRANSPORT_LENGTH
    )
}
