//! `cargo xtask roads`: other ways of light through snow, and what they are wrong by.

mod calibrate;
mod case;
mod sheet;

use crate::deep::measured::{Comparison, Film};
use crate::program::Program;
use anyhow::Result;
use calibrate::Slab;
use case::{Body, Case, Light, Road};
use sheet::Sheet;
use std::fmt::Write as _;
use std::path::PathBuf;

/// Options of the task.
#[derive(clap::Args)]
pub(crate) struct Options {
    /// Folder for roads.md and roads.png
    #[arg(long, value_name = "DIR", default_value = "docs")]
    out: PathBuf,

    /// Prints what the proxy's grains differ by from real ones, as the code holds it, and nothing else
    #[arg(long)]
    calibrate: bool,

    /// Measures slabs alone, and writes nothing
    #[arg(long)]
    slabs: bool,

    /// Fewer samples: a look, not a measurement
    #[arg(long)]
    quick: bool,
}

/// Error of a pixel at which speeds are compared, relative.
const EQUAL_ERROR: f64 = 0.02;
/// Pixels of the picture that is so compared.
const PICTURE: f64 = 512.0 * 512.0;
/// Greatest part by which visits and ice may differ beyond three standard errors.
const VISITS: f64 = 0.01;

/// Writes the tables; false where the proxy is wrong by more than it should.
pub(crate) fn roads(options: &Options) -> Result<bool> {
    let paths = if options.quick { 1 << 14 } else { 1 << 17 };
    if options.calibrate {
        calibrate::print(4 * paths)?;
        return Ok(true);
    }
    let program = Program::build()?;
    let mut report = String::from(INTRODUCTION);
    let mut passed = true;
    write!(report, "\n## Slabs\n\n{SLABS}")?;
    for (of_others, heads) in [(false, SLAB_HEADS), (true, OTHER_HEADS)] {
        report.push_str(heads);
        for slab in Slab::judging(paths, of_others) {
            let (row, keeps) = slab?.row(VISITS, !of_others)?;
            print!("{row}");
            report.push_str(&row);
            passed &= keeps;
        }
    }
    if options.slabs {
        print!("{report}");
        return Ok(passed);
    }
    write!(report, "\n## Pictures\n\n{PICTURES}{PICTURE_HEADS}")?;
    let mut sheet = Sheet::default();
    for body in Body::ALL {
        for light in Light::ALL {
            let case = Case { body, light };
            if !Road::Exact.knows(case) {
                continue;
            }
            sheet.begin_row();
            let rows = compare(&program, case, options.quick, &mut sheet)?;
            print!("{rows}");
            report.push_str(&rows);
        }
    }
    report.push_str(FAILURES);
    sheet.write(&options.out.join("roads.png"))?;
    std::fs::write(options.out.join("roads.md"), report)?;
    Ok(passed)
}

/// All roads through one scene.
fn compare(program: &Program, case: Case, quick: bool, sheet: &mut Sheet) -> Result<String> {
    let mut rows = String::new();
    let exact = case.render(program, Road::Exact, quick)?;
    for road in Road::ALL {
        if !road.knows(case) {
            sheet.add(None);
            continue;
        }
        let film = match road {
            Road::Exact => &exact,
            _ => &case.render(program, road, quick)?,
        };
        let colours = snowgrain_formats::read_film(&program.folder().join("deep.film"))?;
        sheet.add(Some(&colours));
        rows.push_str(&row(case, road, &exact, film)?);
    }
    Ok(rows)
}

fn row(case: Case, road: Road, exact: &Film, film: &Film) -> Result<String> {
    let samples = film.relative_variance() / (EQUAL_ERROR * EQUAL_ERROR);
    let before = film.build_seconds + film.learning_seconds;
    let seconds = before + samples * PICTURE * film.seconds_per_sample;
    let error = match road {
        Road::Exact => "- | -".to_owned(),
        _ => {
            let Comparison { mean, mean_error, blocks, .. } = Comparison::of(exact, film)?;
            format!("{:+.2} ({:.2}) | {:.2}", 100.0 * mean, 100.0 * mean_error, 100.0 * blocks)
        }
    };
    Ok(format!(
        "| {} | {} | {} | {:.2} | {:.3} | {:.1} | {:.0} | {error} |\n",
        case.body.name(),
        case.light.name(),
        road.name(),
        1e6 * film.seconds_per_sample,
        film.relative_variance(),
        before,
        seconds,
    ))
}

const INTRODUCTION: &str = "# Roads of light through snow

Written by `cargo xtask roads`. The program follows light from grain to grain (`integrator.kind = \"grains\"`). Other programs do not: they \
take snow for a medium, or for a surface below which light diffuses. Here are three such ways, on the same grains, to be compared with:

| `integrator.kind` | what light meets |
|---|---|
| `grains` | every grain: exact |
| `proxy` | grains at random places of a smoothed density, after exponential lengths of the mean chord of the void; a path goes on from where a lone \
grain lets it out, by the closed form of the sphere or by one of 131 072 ways through a shape, or straight on |
| `volume` | points of that density, after exponential lengths, that refract light by the phase function of Bohren and Barkstrom (1974, its slip \
mended); any number of times. Volume path tracing as Nishita et al. (1997) light their metaballs, but without an end |
| `dipole` | the surface of that density, from where light diffuses: the dipole of Jensen et al. (2001) with sigma_s' and sigma_a of the grains and \
no step of the index, summed over points by the hierarchy of Jensen and Buhler (2002) |

`integrator.deep = \"proxy\"` follows light exactly until it is deep in the snow, as `\"learnt\"` does, lets it go on as `proxy` there, \
and exactly again when it comes out: it loses and makes no light, and learns nothing of the lights. \
`integrator.deep = \"shells\"` is the same, but where there is room in snow that is everywhere the same it jumps from the centre of a sphere of \
4, 8, ... 128 mean free paths to where one of 32 768 ways through it ended, which the proxy found grain by grain before the picture, each with its own length in ice. \
Where small lights are looked for eight mean free paths beyond the sphere must be room, too.

The smoothed density has nodes four mean radii apart; each grain adds to the eight around its centre, and between nodes it is trilinear. What a grain's ball \
would put into a solid object is given back to the snow before it. `proxy`, `deep = \"proxy\"` and `deep = \"shells\"` know grains of all shapes, sizes and \
substances, but no lattices, and those that lie level or along an axis meet light of each direction as they do (there `deep = \"shells\"` is `deep = \"proxy\"`: a jump knows no \
directions); `volume` and `dipole` know spheres, and one load of impurities for all snow. Media show no dispersion \
(the deep roads do, but refract by one index deep down); `dipole` has no lengths in ice to be graded again. \
Suns and small lamps are looked for at every grain and rough surface; the dipole gathers them where they fall on the snow.

In the proxy a grain is met by the density at its centre, which lies ahead of the path, and as often as there is void around the path to be in. So uniform \
light stays uniform however the density varies, and light visits 2 tau grains with nothing to be calibrated, at a solid fraction of .545 as well. Where grains reach into each \
other (lines through some of them tell how far) light meets what is bare of them, and goes as much farther in each. What is calibrated is that \
light among real grains goes farther than among grains that are met at random: one number for each solid fraction, the part of the grains that light passes straight \
through (with the ice that it else would have met), so that as much comes through a slab of 60 radii. Grains that have grown together turn light more than lone \
ones: there it is negative, the part that turns light twice; and what has grown together holds light longer, which a second number tells where a fiftieth of the surface is \
hidden. Of equal spheres of ice as in packs both are known (`cargo xtask roads --calibrate` prints them: 5 to 11 %). Of all others they are measured before the \
picture, on a slab of a pack of their sizes, shapes, index and solid fraction, or of a snowfall by their rule, by 2^17 paths: some seconds of one processor, \
which `--learnt-cache DIR` saves the next time.
";
const SLABS: &str = "Packs of other seeds than those by which the proxy is calibrated, about 35 radii deep (whole periods of a pack), diffuse light from above, \
black below. *T* is the part that comes through, *visits* and *ice* are grains visited and length in ice over those of exact light (tau: area of the discs over \
that of the slab). Standard errors in brackets.

";
const SLAB_HEADS: &str =
    "| solid fraction | tau | exact: T | proxy: T | visits | ice | volume: T | visits | ice |
|---:|---:|---:|---:|---:|---:|---:|---:|---:|
";
const OTHER_HEADS: &str = "
Other grains, by the calibration that is measured before a picture. *Straight* is the part that passes straight, below 0 that which turns light twice; solid fractions \
count each grain whole. A visit of exact light is an arrival at a grain: where grains are hollow, as rosettes, light that comes back to the same one counts again, \
and the proxy's does not.

| grains | solid fraction, each grain | straight | exact: T | proxy: T | visits | ice |
|---|---:|---:|---:|---:|---:|---:|
";
const PICTURES: &str = "Grains of .5 mm, 275 kg/m^3, 64 x 64 pixels of .5 mm (ball: .375 mm). *Mean* is the difference of the mean of the picture from that of \
exact light, with its standard error; *blocks* the root mean square of the differences of 16 x 16 pixels with the noise of both pictures taken \
out. *Before* are seconds of one processor before the picture, but for the making of the snow: its cells, what is learnt, a medium, ways through spheres; *s to 2 %* those until the \
pixels of a picture of 512 x 512 have a standard error of 2 %, with them. *Variance* is that of one sample of a pixel over the square of the mean. Where snow is nowhere deep, L, P \
and S are exact. The block that is 20 cm deep is 40 cm wide; on it deep roads alone are measured.

![all roads](roads.png)

Rows of the picture are the scenes of the table in turn, columns the roads; each row has one exposure.

";
const PICTURE_HEADS: &str =
    "| snow | light | road | us a sample | variance | before, s | s to 2 % | mean, % | blocks, % |
|---|---|---|---:|---:|---:|---:|---:|---:|
";
const FAILURES: &str = "
## Where each fails

- *Learnt* is the road to take where snow is deep: it is the only one that ends paths early, and so the only one that has less noise and is faster \
at the same error.
- *Proxy* keeps the light of deep snow, and visits and ice within 1 % at all solid fractions. It saves nothing: exact light is followed \
sixteen paths at once, the proxy one path after another, at two to three times the cost of a grain, and both take as many samples. It has no \
grains to be seen, and its snow falls off over four radii at the edge: thin snow and a ball are blurred. It does not know lattices, which \
let more light through. Snow of several kinds is calibrated by that of most grains alone. Crystals in the sun are 11 to 13 % too bright as the proxy from the first \
grain, those that lie exactly level 18 % too dark, and right where they are it in depth. Plates that lie level hide light from above more than from the side, and \
mirror it up and down: ways through them are kept for each direction (64 classes of its height; where grains are not turned about the vertical alike, 32 by 32 \
of its azimuth).
- *Shells* save little while spheres are small: light is scattered forward, so that at 275 kg/m^3 one of 4 mean free paths stands for 3 \
grains, of 8 for 7, of 16 for 20, of 32 for 63. On snow 5 cm deep they are slower than the proxy, on 20 cm faster than exact light. Nowhere \
are they faster than *learnt*, which ends paths and so has less noise, too: they are kept to be compared with.
- *Volume* lets too much light through: what grains reflect, outside and inside, is left out of its phase function, which is turned forward too \
much, and grains take no room. Under an overcast sky all snow is too dark. Under the sun that may be made up for, as in the deep block, \
or more than that, by what is turned forward into the camera.
- *Dipole* takes snow for a half space. It does not know that a thin cover lets light out below: over dark ground, and on a deep block too, it is too \
bright, thin snow twice. It does not know that a ball has other sides, from which light comes at other distances, and leaves out what falls on \
one part of the snow from another: there it is too dark by half. It has no grains, and its light is even over all directions. It has no noise but that of \
its points, so it is done in no time where that is all that one asks for.
";
