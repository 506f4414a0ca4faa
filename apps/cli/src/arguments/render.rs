//! `snowgrain render` as typed.

use super::{
    DenoiseArguments, DisplayArguments, MachineArguments, PictureFile, ReportArguments,
    SceneArguments, Size,
};
use super::{Series, laboratory_values, values};
use crate::failure::Failure;
use clap::Args;
use snowgrain_film::PixelRect;
use snowgrain_render::View;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Renders a scene.
///
/// SCENE is the name of a built-in scene (`snowgrain scenes` lists them), a scene file (.toml), or a
/// mesh (.obj, .ply) or model (.gltf, .glb), for which camera, light, ground and snow are chosen; a shot
/// (.gltf, .glb with a camera) keeps its camera and objects, and snow falls on them.
#[derive(Clone, Debug, Args)]
#[command(args_override_self = true)]
#[command(after_help = "Examples:\n  \
    snowgrain render snowy-teapot -o teapot.png\n  \
    snowgrain render snow-cube --spp 100 --size 1024x1024 -o cube.png -o cube.exr\n  \
    snowgrain render scene.toml --set snow.radius=0.3mm --set camera.vertical_fov=25 -o out.png\n  \
    snowgrain render snowy-teapot --view close -o close.png\n  \
    snowgrain render bunny.ply --up z --object-size 20cm -o bunny.png\n  \
    snowgrain render scene.toml --spp 100000 --time-limit 10m --display-server localhost:14158 -o out.exr\n  \
    snowgrain render scene.toml --spp 100000 --resume -o out.film -o out.exr\n  \
    snowgrain render scene.toml --samples 0..64 -o part0.film\n  \
    snowgrain render scene.toml --dry-run\n\n\
    The first Ctrl-C stops after the running tiles and writes what there is; the second aborts.\n\
    A film that already holds all that is asked for ends the run at once, with exit code 0; one of the same render\n\
    whose samples would be lost is refused (2, or 65 with --resume), and so is one that another run is at work on (75).")]
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

    /// Renders only these samples of each pixel, by index: 0..64, or 0-63 with the last; films of other
    /// samples are added by `snowgrain merge`
    #[arg(long, value_name = "A..B", value_parser = values::samples,
          conflicts_with_all = ["spp", "noise_target"])]
    pub(crate) samples: Option<Range<u64>>,

    /// Goes on with the film that is there (-o FILE.film), of a run that was stopped or killed: to the same
    /// bytes as without a break. A film of another render is refused
    #[arg(long)]
    pub(crate) resume: bool,

    /// Saves the film (-o FILE.film) so far every so often (90s, 10m) [default: 10m]
    #[arg(long, value_name = "TIME", value_parser = values::duration)]
    pub(crate) checkpoint_every: Option<Duration>,

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

    /// Ends light that is deep in the snow with what other light brought from there, learnt before the picture:
    /// much faster, and wrong by no more than this part on average over 16x16 pixels, as 0.01 (at least
    /// 0.001); 0 follows all light to its end. Instead of the scene's integrator.deep
    #[arg(long, value_name = "ERROR", allow_negative_numbers = true)]
    pub(crate) lod_error: Option<f64>,

    /// Keeps what is learnt of light deep in the snow in this folder, and takes it from there when the same scene is
    /// rendered again with the same seed: another part of it, more samples
    #[arg(long, value_name = "DIR")]
    pub(crate) learnt_cache: Option<PathBuf>,

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

impl RenderArguments {
    /// The same with the number of the frame in the names of its files.
    ///
    /// # Errors
    /// A name that has a place for a frame, without a frame.
    pub(crate) fn with_names_of_frame(&self) -> Result<Self, Failure> {
        let mut arguments = self.clone();
        for file in &mut arguments.output {
            file.path = of_frame(&file.path, self.scene.frame)?;
        }
        Ok(arguments)
    }
}

/// A path whose run of `#` in its file name is the frame, as wide as the run at least.
fn of_frame(path: &Path, frame: Option<u32>) -> Result<PathBuf, Failure> {
    let Some(name) = path.file_name().and_then(|name| name.to_str()) else {
        return Ok(path.to_path_buf());
    };
    let Some(start) = name.find("##") else { return Ok(path.to_path_buf()) };
    let width = name[start..].bytes().take_while(|&byte| byte == b'#').count();
    let Some(frame) = frame else {
        let mend = "the name has a place for the number of a frame; give --frame";
        return Err(Failure::usage(mend).of(&path.display().to_string()));
    };
    Ok(path.with_file_name(format!("{}{frame:0width$}{}", &name[..start], &name[start + width..])))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_numbered_in_names_of_files() {
        let of = |path: &str, frame| of_frame(Path::new(path), frame).map_err(|error| error.code);
        assert_eq!(of("a/b.####.exr", Some(7)), Ok("a/b.0007.exr".into()));
        assert_eq!(of("b##", Some(123)), Ok("b123".into()));
        assert_eq!(of("b#.png", None), Ok("b#.png".into()));
        assert_eq!(of("b.####.png", None), Err(2));
    }
}
