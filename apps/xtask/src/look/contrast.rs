//! The contrast that grains give a flat patch of snow under an overcast sky.

use super::patch::Patch;
use super::stage::{Pack, RADIUS, Stage};
use crate::report::{Comparison, Section};
use anyhow::{Context as _, Result};

/// Widths of pixels in radii, and contrasts expected at solid fractions of .45 and .2.
const EXPECTED: [(f64, [f64; 2]); 3] =
    [(0.5, [0.11, 0.24]), (1.0, [0.07, 0.17]), (5.5, [0.017, 0.053])];
/// Tolerances as parts of what is expected: .02 of .07, .04 of .17.
const TOLERANCES: [f64; 2] = [0.02 / 0.07, 0.04 / 0.17];
/// Most that a Lambertian surface may show, a matter of noise alone.
const NONE: f64 = 0.006;
/// Structure wider than this many radii is not that of grains.
const WIDEST: f64 = 16.0;
/// How wide the snow is, and how deep where its contrast is compared, radii.
const ACROSS: f64 = 400.0;
const DEEP: f64 = 40.0;
/// Other rules, depths and albedos of the ground, to tell of.
const TOLD: [(&str, &str, f64, f64); 5] = [
    ("contrast-roll", "roll", DEEP, 0.0),
    ("contrast-stick", "stick", DEEP, 0.0),
    ("contrast-shallow", "ray", 0.5 * DEEP, 0.0),
    ("contrast-deep", "ray", 2.0 * DEEP, 0.0),
    ("contrast-white", "ray", DEEP, 1.0),
];

/// The snow of a scene.
struct Snow {
    name: &'static str,
    what: String,
    table: String,
    /// Where the middle of it is, along x and z, and its upper end, metres.
    middle: f64,
    top: f64,
    /// Albedo of the ground.
    ground: f64,
    /// Which of the expected contrasts it is compared with.
    expected: Option<usize>,
}

pub(super) fn section(stage: &Stage) -> Result<Section> {
    let mut section = Section::new("Contrast of grains");
    section.say(format!(
        "Flat snow under a CIE overcast sky, seen from above by parallel rays, {ACROSS} radii wide. Contrast: standard \
         deviation over mean of green; structure wider than {WIDEST} radii (9 pixels, if that is more) and the noise that \
         the variance layer tells are taken away."
    ));
    section.say(format!(
        "The figures expected name neither depth nor surface, and both matter: snow that absorbs nothing, over white \
         ground under one sky, is as bright as that sky wherever one looks, and has no contrast at all. What shows is where \
         light is lost, below, and the relief of what fell. They are therefore told, not judged: packs of about their \
         solid fractions, {DEEP} radii deep over black ground, the least depth of the transport that the figures come \
         from. The table tells how contrast falls with depth and with white ground. No rule gives .2: `stick` is the \
         nearest, and a pack at random places, whose surface is flat, has .200."
    ));
    let mut told = Vec::new();
    for snow in snows(stage, &mut section)? {
        told.push(measure(stage, &mut section, &snow)?);
    }
    told.push(lambert(stage, &mut section)?);
    section.table(&["surface", "pixel .5 r", "1 r", "5.5 r"], &told);
    Ok(section)
}

/// The packings, those that are compared first.
fn snows(stage: &Stage, section: &mut Section) -> Result<Vec<Snow>> {
    let side = ACROSS * RADIUS;
    let pack =
        Pack { file: "phi_0.20.ply", solid_fraction: 0.2, width: side, depth: DEEP * RADIUS };
    stage.write_pack(&pack)?;
    let mut snows = vec![Snow {
        name: "contrast-random",
        what: format!(
            "grains at random places, none touching, phi = .200, {DEEP} radii deep over black ground"
        ),
        table: format!("source = \"file\"\nfile = \"{}\"", pack.file),
        middle: 0.5 * side,
        top: pack.depth,
        ground: 0.0,
        expected: Some(1),
    }];
    snows.push(fallen(stage, section, ("contrast-ray", "ray", DEEP, 0.0), Some(0))?);
    for told in TOLD {
        snows.push(fallen(stage, section, told, None)?);
    }
    Ok(snows)
}

/// Snow that fell by a rule, and how dense it is.
fn fallen(
    stage: &Stage,
    section: &mut Section,
    (name, rule, deep, ground): (&'static str, &str, f64, f64),
    expected: Option<usize>,
) -> Result<Snow> {
    let (half, top) = (0.5 * ACROSS * RADIUS, deep * RADIUS);
    let table = format!(
        "source = \"deposit\"\nrule = \"{rule}\"\nradius = {RADIUS}\ndepth = {top}\n\
         area = [-{half}, -{half}, {half}, {half}]"
    );
    let mut snow = Snow { name, what: String::new(), table, middle: 0.0, top, ground, expected };
    stage.write_scene(name, &scene(&snow))?;
    let told = stage.deposit(section, name)?;
    let fraction = told["union_solid_fraction"].as_f64().context("no solid fraction")?;
    let ground = if ground > 0.0 { "white" } else { "black" };
    snow.what =
        format!("`rule = \"{rule}\"`, phi = {fraction:.3}, {deep} radii deep over {ground} ground");
    Ok(snow)
}

/// A scene whose picture is one metre high; the options of [`sampling`] say otherwise.
fn scene(snow: &Snow) -> String {
    let (middle, top) = (snow.middle, snow.top);
    format!(
        "# Flat snow from above.\nversion = 1\n\n[camera]\n\
         kind = \"orthographic\"\nfrom = [{middle}, {}, {middle}]\nat = [{middle}, {top}, {middle}]\n\
         up = [0, 0, -1]\nheight = 1\n\n[[light]]\nkind = \"overcast\"\n\n[[object]]\nshape = \"plane\"\n\
         albedo = {}\n\n[[snow]]\n{}\n",
        top + 0.1,
        snow.ground,
        snow.table
    )
}

/// The options for pixels of a width in radii, `more` times as many samples as grains need.
fn sampling(stage: &Stage, pixel: f64, more: u32) -> String {
    let (pixels, samples): (u32, u32) = if pixel > 2.0 {
        (stage.choose(60, 40), stage.choose(512, 256))
    } else {
        (stage.choose(96, 64), stage.choose(64, 32))
    };
    let height = f64::from(pixels) * pixel * RADIUS;
    format!("--size {pixels}x{pixels} --spp {} --set camera.height={height}", more * samples)
}

/// How many more samples the Lambertian block takes: it is quick, and all its contrast would be noise.
const LAMBERTIAN_SAMPLES: u32 = 8;

/// The side in pixels of what is taken for wider than grains; odd.
fn side(pixel: f64) -> usize {
    ((WIDEST / pixel).round() as usize | 1).max(9)
}

fn measure(stage: &Stage, section: &mut Section, snow: &Snow) -> Result<Vec<String>> {
    let mut row = vec![snow.what.clone()];
    let mut comparison = snow.expected.map(|fraction| {
        let percent = 100.0 * TOLERANCES[fraction];
        Comparison::reported(
            format!("contrast over that expected, {}", snow.what),
            format!("{percent:.0} %"),
        )
    });
    for (pixel, contrasts) in EXPECTED {
        let options = sampling(stage, pixel, 1);
        let picture = stage.render(section, (snow.name, &scene(snow)), &options)?;
        let contrast = Patch::of(&picture)?.contrast(side(pixel));
        row.push(format!("{contrast:.3}"));
        if let (Some(fraction), Some(comparison)) = (snow.expected, &mut comparison) {
            let name = format!("pixel {pixel} r: contrast {contrast:.4}");
            comparison.compare(&name, contrast / contrasts[fraction], 1.0, TOLERANCES[fraction]);
        }
    }
    if let Some(comparison) = comparison {
        section.add(comparison);
    }
    Ok(row)
}

fn lambert(stage: &Stage, section: &mut Section) -> Result<Vec<String>> {
    let snow = Snow {
        name: "contrast-lambert",
        what: String::new(),
        table: String::new(),
        middle: 0.0,
        top: DEEP * RADIUS,
        ground: 0.0,
        expected: None,
    };
    let half = 0.5 * ACROSS * RADIUS;
    let block = format!(
        "[[object]]\nshape = \"box\"\nalbedo = 0.95\nscale = [{half}, {}, {half}]\ntranslate = [0, {}, 0]\n",
        0.5 * snow.top,
        0.5 * snow.top
    );
    let scene = scene(&snow).replace("[[snow]]\n\n", &block);
    let mut comparison =
        Comparison::new("contrast of a Lambertian block of the same shape", format!("{NONE}"));
    let mut row = vec!["a Lambertian block".to_owned()];
    for (pixel, _) in EXPECTED {
        let options = sampling(stage, pixel, LAMBERTIAN_SAMPLES);
        let picture = stage.render(section, (snow.name, &scene), &options)?;
        let contrast = Patch::of(&picture)?.contrast(side(pixel));
        row.push(format!("{contrast:.3}"));
        comparison.compare(&format!("pixel {pixel} r"), contrast, 0.0, NONE);
    }
    section.add(comparison);
    Ok(row)
}
