//! How much more light snow sends forward than up.

use super::field::{self, Field};
use super::patch::Patch;
use super::stage::Stage;
use crate::report::{Comparison, Section};
use anyhow::Result;
use snowgrain_math::trig;

/// Bidirectional reflectance factor at 60 degrees forward over that at the nadir, of smooth spheres under a
/// sun at the zenith angle of 60 degrees, 550 nm; of natural snow it is 1.11.
const FORWARD_OVER_NADIR: f64 = 1.74;
const TOLERANCE: f64 = 0.03;
/// What grains that are packed may differ by from grains that are met at random.
const PACKED_TOLERANCE: f64 = 0.15;

pub(super) fn section(stage: &Stage) -> Result<Section> {
    let mut section = Section::new("Directions");
    section.say(format!(
        "Deep snow under a sun at the zenith angle of 60 degrees: reflectance into 60 degrees forward over that into the \
         zenith, by the laboratory (grains met at random), and in pictures of packed grains, which hide each other at \
         grazing angles; these are told, not judged. A Lambertian surface has 1, natural snow 1.11: spheres send too much \
         forward. {}",
        field::told()
    ));
    let command = format!(
        "optics brdf --radius 250um --sza 60 --vza 0,60 --azimuth 0 --wavelengths 550 --stderr {}",
        stage.choose(0.005, 0.01)
    );
    let found = stage.table(&mut section, &command)?;
    let factor = |view: &str| found.find(&[("vza_deg", view), ("azimuth_deg", "0")])?.number("BRF");
    let mut comparison = Comparison::new("forward over nadir, by the laboratory, over 1.74", "3 %");
    let ratio = factor("60")? / factor("0")?;
    comparison.compare(&format!("{ratio:.3}"), ratio / FORWARD_OVER_NADIR, 1.0, TOLERANCE);
    section.add(comparison);
    for (field, name, what, expected) in [
        (Field::Grains, "directions", "packed grains", FORWARD_OVER_NADIR),
        (Field::Lambertian, "directions-lambert", "Lambertian block", 1.0),
    ] {
        let what = format!("forward over nadir in pictures, {what}, over {expected}");
        let mut comparison = match field {
            Field::Grains => Comparison::reported(what, "15 %"),
            Field::Lambertian => Comparison::new(what, "3 %"),
        };
        let ratio = pictured(stage, &mut section, (field, name))?;
        let allowed = if field == Field::Grains { PACKED_TOLERANCE } else { TOLERANCE };
        comparison.compare(&format!("{ratio:.3}"), ratio / expected, 1.0, allowed);
        section.add(comparison);
    }
    Ok(section)
}

/// Mean radiance as seen from 60 degrees against the sun over that from above.
fn pictured(stage: &Stage, section: &mut Section, (field, name): (Field, &str)) -> Result<f64> {
    let light = "[[light]]\nkind = \"sun\"\nelevation = 30\nazimuth = 90\n\n";
    let tables = field.tables(stage)?;
    let (middle, top) = (Field::MIDDLE, Field::TOP);
    // The sun is at +x, so the camera looks towards it from -x.
    let (sin, cos) = trig::sin_cos(60f64.to_radians());
    let mut means = Vec::new();
    for (view, from) in [
        ("above", [middle, top + 0.2, middle]),
        ("forward", [middle - 0.2 * sin, top + 0.2 * cos, middle]),
    ] {
        let scene =
            format!("# Deep snow against the sun.\n{}{light}{tables}", field::camera(16, 16, from));
        let name = format!("{name}-{view}");
        let options = format!("--spp {}", stage.choose(256, 128));
        means.push(Patch::of(&stage.render(section, (&name, &scene), &options)?)?.mean());
    }
    Ok(means[1] / means[0])
}
