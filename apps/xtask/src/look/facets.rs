//! Glints of faces, counted in a picture.

use super::stage::Stage;
use crate::report::{Comparison, Section};
use anyhow::{Context as _, Result};
use core::f64::consts::PI;
use snowgrain_film::{GLINTS, Picture};
use snowgrain_math::{DVec3, trig};
use snowgrain_optics::Dielectric;

/// Radius of the sphere of equal volume of the grains, and the distance between them, metres.
const RADIUS: f64 = 0.5e-3;
const SPACING: f64 = 8e-3;
/// Grains along each side of the sheet.
const SIDE: u32 = 110;
/// Height by width of the plates from corner to corner.
const ASPECT: f64 = 0.2;
/// The sun: degrees across, elevation and azimuth.
const DIAMETER: f64 = 16.0;
const SUN: [f64; 2] = [40.0, 60.0];
/// Towards the camera.
const EYE: DVec3 = DVec3::new(0.0, 0.98, 0.9);
/// Index of the ice, and its absorption, 1/m: what enters a grain is lost, and only faces shine.
const INDEX: f64 = 1.31;
const BLACK: f64 = 1e6;
/// Edge of a pixel, metres, and pixels.
const PIXEL: f64 = 0.75e-3;
const PIXELS: [u32; 2] = [1200, 900];
/// Samples a pixel of plates and of spheres: some twenty fall on the least of faces. The image of the sun in a sphere is a hundredth of a
/// pixel, and what a pixel shows of it must not come to a tenth by chance: by 64 samples a few of 12 100 did.
const SAMPLES: [u32; 2] = [64, 512];
/// Part of what a face shows above which a pixel belongs to a glint.
const THRESHOLD: f64 = 0.1;
/// How far the mean light of glints may be off.
const TOLERANCE: f64 = 0.1;

pub(super) fn section(stage: &Stage) -> Result<Section> {
    let mut section = Section::new("Glints of faces");
    let plates = f64::from(SIDE * SIDE);
    section.say(format!(
        "A sheet of {plates} plates of ice (aspect {ASPECT}, r = .5 mm, {} mm apart) in all orientations, and its twin of \
         spheres, in a sun {DIAMETER} degrees wide, so that there are many glints; the ice absorbs all that enters, so that \
         only what faces mirror is left. Glints are pixels of the layer `glints` that are brighter than a tenth of what a \
         face shows, those that touch as one. Expected are Omega / (16 pi cos theta_h) a face, theta_h half the angle \
         between sun and camera, and of each the light R(theta_h) L a: R by Fresnel, L the radiance of the sun (from a \
         white surface in the same sun), a the part of a pixel that the face covers, summed over its pixels.",
        1e3 * SPACING
    ));
    let sun = towards_sun();
    let half = 0.5 * (sun + EYE.normalize()).length();
    let solid_angle = 2.0 * PI * (1.0 - trig::sin_cos(0.5 * DIAMETER.to_radians()).1);
    let expected = 8.0 * plates * solid_angle / (16.0 * PI * half);
    let radiance = sun_radiance(stage, &mut section, sun)?;
    let face = Dielectric { eta: INDEX }.reflectance_from_outside(half) * radiance;
    let [glints, others] =
        [("facets", true), ("facets-spheres", false)].map(|(name, has_faces)| {
            let samples = SAMPLES[usize::from(!has_faces)];
            let picture = stage.render(
                &mut section,
                (name, &scene(has_faces)),
                &format!("--keep light-groups --spp {samples}"),
            )?;
            Layer::of(&picture).map(|layer| (layer.glints(THRESHOLD * face), layer.greatest()))
        });
    let ((glints, _), (others, greatest)) = (glints?, others?);
    let mut count = Comparison::new("glints of plates beside those of chance", "4 sigma (Poisson)");
    count.compare("number", glints.len() as f64, expected, 4.0 * expected.sqrt());
    section.add(count);
    let mut none = Comparison::new("glints of spheres", "none");
    none.compare("number", others.len() as f64, 0.0, 0.0);
    section.add(none);
    // Basal faces show more than six times as much as those of the prism.
    let corner = RADIUS * trig::cbrt(4.0 * PI / (9.0 * 3.0f64.sqrt() * ASPECT));
    let basal = 1.5 * 3.0f64.sqrt() * corner * corner;
    let prismatic = 2.0 * ASPECT * corner * corner;
    let covered = |area: f64| face * area * half / (PIXEL * PIXEL);
    let between = (covered(basal) * covered(prismatic)).sqrt();
    let (large, small): (Vec<f64>, Vec<f64>) = glints.iter().partition(|&&light| light > between);
    let mean = |of: &[f64]| of.iter().sum::<f64>() / of.len().max(1) as f64;
    let mut light = Comparison::new("mean light of a glint over R L a", "10 %");
    for (name, found, area) in
        [("basal faces", &large, basal), ("faces of the prism", &small, prismatic)]
    {
        light.compare(name, mean(found) / covered(area), 1.0, TOLERANCE);
    }
    section.add(light);
    section.say(format!(
        "{} glints where chance makes {expected:.1} +- {:.1}: {} of basal faces, {} of those of the prism; R = {:.4} at \
         {:.1} degrees. The brightest pixel of a sphere shows {:.4} of what a pixel full of a face does.",
        glints.len(),
        expected.sqrt(),
        large.len(),
        small.len(),
        face / radiance,
        trig::acos(half).to_degrees(),
        greatest / face
    ));
    Ok(section)
}

/// As `[[light]]` has it: the azimuth counts from north, -z, by east, +x.
fn towards_sun() -> DVec3 {
    let [elevation, azimuth] = SUN.map(f64::to_radians);
    let ((up, level), (sin, cos)) = (trig::sin_cos(elevation), trig::sin_cos(azimuth));
    DVec3::new(level * sin, up, -level * cos)
}

fn head(pixels: [u32; 2], height: f64, [x, y, z]: [f64; 3]) -> String {
    let [width, rows] = pixels;
    let from = DVec3::new(x, y, z) + EYE;
    let [elevation, azimuth] = SUN;
    format!(
        "version = 1\n\n[film]\nwidth = {width}\nheight = {rows}\n\n[camera]\nkind = \"orthographic\"\n\
         from = [{}, {}, {}]\nat = [{x}, {y}, {z}]\nheight = {height}\n\n[ice]\nior = {INDEX}\n\
         absorption = {BLACK:?}\n\n[[light]]\nkind = \"sun\"\nelevation = {elevation}\nazimuth = {azimuth}\n\
         angular_diameter = {DIAMETER}\n\n",
        from.x, from.y, from.z
    )
}

fn scene(has_faces: bool) -> String {
    let middle = 0.5 * SPACING * f64::from(SIDE - 1) + RADIUS;
    let shapes = format!("\n[[snow.shapes]]\nshape = \"hexagonal-plate\"\naspect = {ASPECT}\n");
    format!(
        "# A sheet of {} in the sun.\n{}[[snow]]\nsource = \"lattice\"\nlattice = \"sc\"\nradius = {RADIUS:?}\n\
         spacing = {SPACING:?}\ncounts = [{SIDE}, 1, {SIDE}]\n{}",
        if has_faces { "plates" } else { "spheres" },
        head(PIXELS, f64::from(PIXELS[1]) * PIXEL, [middle, RADIUS, middle]),
        if has_faces { &shapes } else { "" }
    )
}

/// By a white surface in the sun, whose radiance is L sin^2(half its width) cos(its angle from the vertical).
fn sun_radiance(stage: &Stage, section: &mut Section, sun: DVec3) -> Result<f64> {
    let ground = "[[object]]\nshape = \"plane\"\nalbedo = 1\n";
    let scene = format!("# White ground in the sun.\n{}{ground}", head([8, 8], 0.01, [0.0; 3]));
    let picture = stage.render(section, ("facets-white", &scene), "--spp 256")?;
    let values = picture.layer(snowgrain_film::Layer::G).context("no light")?;
    let mean = values.iter().map(|&value| f64::from(value)).sum::<f64>() / values.len() as f64;
    let sin = trig::sin_cos(0.5 * DIAMETER.to_radians()).0;
    Ok(mean / (sin * sin * sun.y))
}

/// The layer of glints.
struct Layer {
    width: usize,
    green: Vec<f64>,
}

impl Layer {
    fn of(picture: &Picture) -> Result<Self> {
        let layer = picture.light_layers.iter().find(|layer| layer.name == GLINTS);
        let layer = layer.context("the picture has no layer of glints")?;
        let green = layer.values[1].iter().map(|&value| f64::from(value)).collect();
        Ok(Self { width: picture.window().width() as usize, green })
    }

    fn greatest(&self) -> f64 {
        self.green.iter().copied().fold(0.0, f64::max)
    }

    /// The light of each glint, in pixels: those over a threshold that touch, and what lies around them.
    fn glints(&self, threshold: f64) -> Vec<f64> {
        let (width, height) = (self.width, self.green.len() / self.width);
        let around = |at: usize| {
            let (x, y) = (at % width, at / width);
            let rows = y.saturating_sub(1)..(y + 2).min(height);
            rows.flat_map(move |y| {
                (x.saturating_sub(1)..(x + 2).min(width)).map(move |x| y * width + x)
            })
        };
        let mut seen = vec![false; self.green.len()];
        let mut glints = Vec::new();
        for start in 0..self.green.len() {
            if seen[start] || self.green[start] <= threshold {
                continue;
            }
            let (mut open, mut light) = (vec![start], 0.0);
            seen[start] = true;
            while let Some(at) = open.pop() {
                light += self.green[at];
                // What is darker than a glint belongs to it, but leads no farther.
                let bright = self.green[at] > threshold;
                for next in around(at).filter(|_| bright) {
                    if !seen[next] && self.green[next] > 0.0 {
                        seen[next] = true;
                        open.push(next);
                    }
                }
            }
            glints.push(light);
        }
        glints
    }
}
