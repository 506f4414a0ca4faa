//! `snowgrain render` as typed.

use super::{
    DenoiseArguments, DisplayArguments, MachineArguments, PictureFile, ReportArguments,
    SceneArguments, Size,
};
use super::{Series, laboratory_values, values};
use clap::Args;
use snowgrain_film::PixelRect;
use snowgrain_render::View;
use std::time::Duration;

/// Renders a scene.
///
/// SCENE is the name of a built-in scene (`snowgrain scenes` lists them), a scene file (.toml), or a
/// mesh (.obj, .ply) or model (.gltf, .glb), for which camera, light, ground and snow are chosen; a shot
/// (.gltf, .glb with a camera) keeps its camera and objects, and snow falls on them.
#[derive(Debug, Args)]
#[command(args_override_self = true)]
#[command(after_help = "Examples:\n  \
    snowgrain render snowy-teapot -o teapot.png\n  \
    snowgrain render snow-cube --spp 100 --size 1024x1024 -o cube.png -o cube.exr\n  \
    snowgrain render scene.toml --set snow.radius=0.3mm --set camera.vertical_fov=25 -o out.png\n  \
    snowgrain render snowy-teapot --view close -o close.png\n  \
    snowgrain render bunny.ply --up z --object-size 20cm -o bunny.png\n  \
    snowgrain render scene.toml --spp 100000 --time-limit 10m --display-server localhost:14158 -o out.exr\n  \
    snowgrain render scene.toml --dry-run\n\n\
    The first Ctrl-C stops after the running tiles and writes what there is; the second aborts.")]
pub(crate) struct RenderArguments {
    #[command(flatten)]
    pub(crate) scene: SceneArguments,

    /// Where the picture goes, several times if wanted: .png (sRGB; refreshed while it
    /// renders), .exr (scene-linear, all layers) or .film (the exact sums)
    #[arg(short, long, value_name = "FILE", required_unless_present = "dry_run")]
    pub(crate) output: Vec<PictureFile>,

    /// Samples per pixel, instead of the scene's
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) spp: Option<u32>,

    /// Seed of the random numbers of light, instead of the scene's
    #[arg(long, value_name = "N")]
    pub(crate) seed: Option<u64>,

    /// Size of the picture in pixels, instead of the scene's
    #[arg(long, value_name = "WxH")]
    pub(crate) size: Option<Size>,

    /// Renders only these pixels: columns x0 to x1 - 1, rows y0 to y1 - 1
    #[arg(long, value_name = "x0,y0,x1,y1", value_parser = values::crop)]
    pub(crate) crop: Option<PixelRect>,

    /// Looks from another side than the scene's camera: front, three-quarter, top, or close (a macro view
    /// of the snow, shallow in focus)
    #[arg(long, value_name = "VIEW", value_parser = values::view)]
    pub(crate) view: Option<View>,

    /// Ends with fewer samples after the pass over the picture that exceeds this time (90s, 10m, 1.5h),
    /// counted from the start of the program; what every pixel has is the picture
    #[arg(long, value_name = "TIME", value_parser = values::duration)]
    pub(crate) time_limit: Option<Duration>,

    /// Gives each block of 16x16 pixels only as many samples as it needs for this relative error, as
    /// 0.05: the standard error of its pixels (root mean square) over their mean + 0.01. A pilot of 16
    /// samples, which the picture does not hold, finds how many; --spp (or the scene) says how many at
    /// most
    #[arg(long, value_name = "ERROR", allow_negative_numbers = true, value_parser = values::positive)]
    pub(crate) noise_target: Option<f64>,

    /// Shows the picture while it grows in the image viewer tev, which listens there (tev's own
    /// default is localhost:14158); a viewer that is absent or goes away changes nothing
    #[arg(long, value_name = "HOST:PORT", value_parser = values::host_and_port)]
    pub(crate) display_server: Option<String>,

    /// Albedos 1, no absorption, uniform light of radiance 1: every pixel must be exactly 1
    #[arg(long)]
    pub(crate) furnace: bool,

    /// What .film files keep beside the picture and what the scene says: ice-paths (each pixel's light by length in ice, with
    /// which develop can change ice and impurities; 768 bytes a pixel) or light-groups (the light of each
    /// group of lights, which develop can mix; 48 bytes a pixel for each); repeatable
    #[arg(long, value_name = "WHAT", value_parser = ["ice-paths", "light-groups"])]
    pub(crate) keep: Vec<String>,

    /// Adds spectral layers to .exr files, in the layout of Fichet et al. 2021: radiance at
    /// wavelengths in nm, 380 to 780, as 450,550,650 or 400:700:20; keeps ice paths
    #[arg(long, value_name = "NM,...|FROM:TO:STEP",
          value_parser = laboratory_values::visible_wavelengths)]
    pub(crate) wavelengths: Option<Series>,

    /// How grains are packed for light, instead of the scene's: fast, or compact (less memory)
    /// [default: fast; compact where only that fits into --max-memory]
    #[arg(long, value_name = "PACKING", value_parser = ["fast", "compact"])]
    pub(crate) packing: Option<String>,

    /// Estimates grains, memory and time; nothing is made or traced
    #[arg(long, conflicts_with = "json_stats")]
    pub(crate) dry_run: bool,

    #[command(flatten)]
    pub(crate) display: DisplayArguments,

    #[command(flatten)]
    pub(crate) denoise: DenoiseArguments,

    #[command(flatten)]
    pub(crate) machine: MachineArguments,

    #[command(flatten)]
    pub(crate) report: ReportArguments,
}
