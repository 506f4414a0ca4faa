//! `cargo xtask deep`: what light that ends deep in the snow is wrong by, and what it saves.

mod case;
pub(crate) mod measured;

use crate::program::Program;
use anyhow::{Context as _, Result};
use case::{Case, Handover};
use measured::{Comparison, Film};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// Options of the task.
#[derive(clap::Args)]
pub(crate) struct Options {
    /// Folder for deep.md
    #[arg(long, value_name = "DIR", default_value = "docs")]
    out: PathBuf,

    /// Fewer samples, densities and sizes of pixels: a look, not a measurement
    #[arg(long)]
    quick: bool,

    /// Measure speed alone, and keep the errors that deep.md tells
    #[arg(long)]
    speed_only: bool,
}

/// Heads of the two parts of the report.
const ERROR_SECTION: &str = "\n## Error\n\n";
const SPEED_SECTION: &str = "\n## Speed\n\n";

/// Greatest error of the mean, and of blocks of pixels, that passes at the default: relative.
const MEAN_ERROR: f64 = 0.01;
const BLOCK_ERROR: f64 = 0.015;
/// Error of a pixel at which speeds are compared, relative.
const EQUAL_ERROR: f64 = 0.02;
/// Pixels of the picture that is so compared.
const PICTURE: f64 = 512.0 * 512.0;

/// Writes the tables; false where the default is wrong by more than it should.
pub(crate) fn deep(options: &Options) -> Result<bool> {
    let program = Program::build()?;
    let file = options.out.join("deep.md");
    let (errors, passed) =
        if options.speed_only { (kept_errors(&file)?, true) } else { errors(&program, options)? };
    let mut report = format!("{INTRODUCTION}{errors}");
    write!(report, "{SPEED_SECTION}{SPEED}{SPEED_HEADS}")?;
    for case in Case::of_speed(options.quick) {
        let exact = case.render(&program, None, options.quick)?;
        let learnt = case.render(&program, Some(Handover::ALL[0]), options.quick)?;
        let row = speed_row(&case, &exact, &learnt)?;
        print!("{row}");
        report.push_str(&row);
    }
    std::fs::write(file, report)?;
    Ok(passed)
}

/// The part on errors of the report that was written last.
fn kept_errors(file: &Path) -> Result<String> {
    let last = std::fs::read_to_string(file)?;
    let between = last.find(ERROR_SECTION).zip(last.find(SPEED_SECTION));
    let (from, to) = between.context("deep.md has no table of errors: run without --speed-only")?;
    Ok(last[from..to].to_owned())
}

/// The part on errors, and whether the default is wrong by no more than it should.
fn errors(program: &Program, options: &Options) -> Result<(String, bool)> {
    let mut report = format!("{ERROR_SECTION}{ERRORS}{ERROR_HEADS}");
    let mut passed = true;
    for case in Case::of_errors(options.quick) {
        let exact = case.render(program, None, options.quick)?;
        for handover in Handover::ALL {
            let learnt = case.render(program, Some(handover), options.quick)?;
            let row = error_row(&case, handover, &exact, &learnt)?;
            print!("{}", row.0);
            passed &= row.1 || handover != Handover::ALL[0];
            report.push_str(&row.0);
        }
    }
    Ok((report, passed))
}

fn error_row(
    case: &Case,
    handover: Handover,
    exact: &Film,
    learnt: &Film,
) -> Result<(String, bool)> {
    let Comparison { mean, mean_error, blocks, pixels } = Comparison::of(exact, learnt)?;
    let settings = handover.settings()?;
    let row = format!(
        "| {} | {} | {} | {} | {} | {} | {:+.2} ({:.2}) | {:.2} | {:.2} |\n",
        case.light.name(),
        case.grains.name(),
        case.density,
        case.pixel_radii,
        case.grains(&settings),
        case.light.depth(&settings),
        100.0 * mean,
        100.0 * mean_error,
        100.0 * blocks,
        100.0 * pixels,
    );
    let fits = mean.abs() <= MEAN_ERROR + 3.0 * mean_error && blocks <= BLOCK_ERROR;
    Ok((row, fits))
}

fn speed_row(case: &Case, exact: &Film, learnt: &Film) -> Result<String> {
    let seconds = |film: &Film| {
        let samples = film.relative_variance() / (EQUAL_ERROR * EQUAL_ERROR);
        film.learning_seconds + samples * PICTURE * film.seconds_per_sample
    };
    let [slow, fast] = [seconds(exact), seconds(learnt)];
    let bias = Comparison::of(exact, learnt)?;
    Ok(format!(
        "| {} | {} | {:.2} | {:.2} | {:.3} | {:.3} | {:.1} | {:+.2} ({:.2}) | {:.0} | {:.0} | **{:.1}** |\n",
        case.light.name(),
        case.depth,
        1e6 * exact.seconds_per_sample,
        1e6 * learnt.seconds_per_sample,
        exact.relative_variance(),
        learnt.relative_variance(),
        learnt.learning_seconds,
        100.0 * bias.mean,
        100.0 * bias.mean_error,
        slow,
        fast,
        slow / fast,
    ))
}

const INTRODUCTION: &str = "# Light deep in the snow

Written by `cargo xtask deep`. Light that is followed to its end meets hundreds of grains, thousands in deep snow. Yet once it \
is deep it has forgotten whence it came, and what it brings back depends on its place alone. So it may end there with the mean of what \
other light brought:

```sh
snowgrain render scene.toml --lod-error 0.01 -o out.png
```

or, in the scene, `integrator.deep = \"learnt\"` and `integrator.lod_error = 0.01` (the default). What light brings is learnt before the \
picture by paths of the camera that are followed to their end (`integrator.learning_paths`), from where each first arrives deep in the snow; a table of the light of each group with two lengths in ice, so that colours, impurities, layers and regrading go on as \
ever. It is a function of the scene and the seed: the same bits on any machine. Snow that is nowhere deep (a dusting) is \
rendered exactly, and so is all light that comes back before it has met a few grains and is a quarter of a transport length from open air and from \
surfaces (`deep_after_grains`, `deep_depth`).

How many grains that are depends on how wide a pixel is where light ends: single grains show in pixels of up to half a radius of them, where it is four by \
default, and no more in pixels of one and a half, where it is two. In between each path takes a number in between by chance, so that \
a field which reaches from a hand to the horizon has no seam.

Light that is deep may also go on among grains that are met at random, or jump over spheres of snow (`integrator.deep = \"proxy\"`, \
`\"shells\"`): that needs no learning, but nowhere is it as fast ([roads.md](roads.md)).

Where suns or small lamps shine, light ends at half a transport length at least: their light is patchy farther down than that of a sky, and \
blocks of a close picture were off by 2 % at a quarter. And twice as many paths are learnt from, as such light comes to few of them.

A transport length is the way on which light forgets its direction: for spheres of ice 5.2 mean distances between grains, 11.6 mm for grains of .5 mm at \
275 kg/m^3, 1/density and proportional to the radius. Of other substances and shapes it follows from the shadow and the asymmetry of one of their grains.

The learning paths are such as the picture is made of, and each counts where one of the picture would end, with what it then brought. So the mean \
of the whole picture is off by no more than the chance of those paths, whatever the grains, the lights and the snow: `learnt_relative_error` of `--json-stats` tells it. What a place brings is told from cells of all sizes, the smallest a quarter of a transport length: a small cell \
is taken to bring what the wider one around it does, and the more of its own, the more paths of its own it has, beside what cells of its size differ by beyond chance. \
`.exr` pictures have two channels of it, `Learnt.light`, how much of the radiance was learnt (mean of the channels), and `Learnt.error`, the standard error of that which \
this estimate gives, cells and chance together. The samples of a pixel share cells, so more of them do not make it less; more \
`learning_paths` do.

| `lod_error` | grains | depth, transport lengths | learning paths |
|---:|---:|---:|---:|
| .01 | 4 to 2 | .25 | 786 432 |
| .003 | 4 to 2 | .5 | 1 572 864 |
| .001 | 8 to 4 | 1 | 3 145 728 |
";

const ERRORS: &str = "Blocks of snow 5 cm deep and 12 cm wide on grey ground, r = .5 mm, seen from the side, 64 x 64 pixels. *Mean* is the \
difference of the mean of the picture from that of exact light, with its standard error; *blocks* and *pixels* are root mean squares of the \
differences of 16 x 16 pixels and of single ones, with the noise of both pictures taken out (0 where it is all \
noise). Percent.

";
const ERROR_HEADS: &str =
    "| light | grains of | kg/m^3 | pixel, r | grains | depth | mean | blocks | pixels |
|---|---|---:|---:|---:|---:|---:|---:|---:|
";

const SPEED: &str = "Seconds of one processor until the pixels of a picture of 512 x 512 have a standard error of 2 %, learning \
included; the close-up of the first table, grains of .5 mm at 275 kg/m^3. *Variance* is that of one sample of a pixel over the square of the mean, by 1024 samples a pixel of both. The seconds \
of learning hold, under the sun, the measuring of the search for it, which exact light needs, too (and is charged for); the making of the snow \
and its packing, the same for both, are left out of both.

";
const SPEED_HEADS: &str = "| light | depth, m | exact, us a sample | learnt | exact, variance | learnt | learning, s | bias, % | exact, s | learnt, s | times faster |
|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|
";
