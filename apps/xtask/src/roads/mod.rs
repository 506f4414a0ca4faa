//! `cargo xtask roads`: other ways of light through snow, and what they are wrong by.

mod calibrate;
mod case;
mod sheet;

use crate::deep::measured::{Comparison, Film};
use crate::program::Program;
use anyhow::Result;
use calibrate::Calibrated;
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
        calibrate::print(paths)?;
        return Ok(true);
    }
    let program = Program::build()?;
    let mut report = String::from(INTRODUCTION);
    let mut passed = true;
    write!(report, "\n## Slabs\n\n{SLABS}{SLAB_HEADS}")?;
    for slab in Calibrated::all(paths, calibrate::JUDGING)? {
        let row = slab.row()?;
        print!("{row}");
        report.push_str(&row);
        passed &= slab.keeps_visits(VISITS)?;
    }
    write!(report, "\n## Pictures\n\n{PICTURES}{PICTURE_HEADS}")?;
    let mut sheet = Sheet::default();
    for body in Body::ALL {
        for light in Light::ALL {
            sheet.begin_row();
            let rows = compare(&program, Case { body, light }, options.quick, &mut sheet)?;
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
        if !road.knows(case.light) {
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
    let seconds = film.learning_seconds + samples * PICTURE * film.seconds_per_sample;
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
        film.learning_seconds,
        seconds,
    ))
}

const INTRODUCTION: &str = "# Roads of light through snow

Written by `cargo xtask roads`. The program follows light from grain to grain (`integrator.kind = \"grains\"`). Other programs do not: they \
take snow for a medium, or for a surface below which light diffuses. Here are three such ways, on the same grains, to be compared with:

| `integrator.kind` | what light meets |
|---|---|
| `grains` | every grain: exact |
| `proxy` | spheres at random places of a smoothed density, after exponential lengths of the mean chord of the void; a path goes on from where the \
closed form of the sphere lets it out |
| `volume` | points of that density, after exponential lengths, that refract light by the phase function of Bohren and Barkstrom (1974, its slip \
mended); any number of times. Volume path tracing as Nishita et al. (1997) light their metaballs, but without an end |
| `dipole` | the surface of that density, from where light diffuses: the dipole of Jensen et al. (2001) with sigma_s' and sigma_a of the grains and \
no step of the index, summed over points by the hierarchy of Jensen and Buhler (2002) |

`integrator.deep = \"proxy\"` follows light exactly until it is deep in the snow, as `\"learnt\"` does, lets it go on as `proxy` there, \
and exactly again when it comes out: it loses and makes no light, and needs no learning, but light must be found by paths (skies alone).

The smoothed density has nodes four mean radii apart; each grain adds to the eight around its centre, and between nodes it is trilinear. What a grain's ball \
would put into a solid object is given back to the snow before it. `proxy` and `deep = \"proxy\"` are for spheres of ice in air, `volume` and \
`dipole` for spheres; one load of impurities for all snow; no dispersion, no shadow catchers; `dipole` has no lengths in ice to be graded again. \
Suns and small lamps are looked for at every grain and rough surface; the dipole gathers them where they fall on the snow.

Light among real grains goes farther than among spheres that are met at random, since the next grain does not lie anywhere. Two numbers for each \
solid fraction make up for that: the way from grain to grain over the mean chord of the void, so that as much light comes through a slab of 60 \
radii, and grains that each meeting stands for, so that light visits 2 tau of them (`cargo xtask roads --calibrate` prints them). By the chords of \
the void alone light visits as many grains, but a tenth less comes through.

Spheres over which one jumps (shells) are not here: they were not measured.
";
const SLABS: &str = "Packs of other seeds than those by which the proxy is calibrated, about 35 radii deep (whole periods of a pack), diffuse light from above, \
black below. *T* is the part that comes through; grains visited by 2 tau, which is exact for any packing (tau: area of the discs over that of the slab); \
*ice* is the length in ice over that of exact light. Standard errors in brackets.

";
const SLAB_HEADS: &str = "| solid fraction | tau | exact: T | visits / 2 tau | ice | proxy: T | visits / 2 tau | ice | volume: T | visits / 2 tau | ice |
|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|
";
const PICTURES: &str = "Grains of .5 mm, 275 kg/m^3, 64 x 64 pixels of .5 mm (ball: .375 mm). *Mean* is the difference of the mean of the picture from that of \
exact light, with its standard error; *blocks* the root mean square of the differences of 16 x 16 pixels with the noise of both pictures taken \
out. *Before* are seconds of one processor before the picture, but for the making of the snow; *s to 2 %* those until the pixels of a picture of 512 x 512 \
have a standard error of 2 %, with them. *Variance* is that of one sample of a pixel over the square of the mean. Where snow is nowhere deep, L and P are exact.

![all roads](roads.png)

Rows of the picture are the scenes of the table in turn, columns the roads; each row has one exposure.

";
const PICTURE_HEADS: &str =
    "| snow | light | road | us a sample | variance | before, s | s to 2 % | mean, % | blocks, % |
|---|---|---|---:|---:|---:|---:|---:|---:|
";
const FAILURES: &str = "
## Where each fails

- *Learnt* is the road to take where snow is deep: it is the only one that ends paths early, so the only one with less noise.
- *Proxy* has no grains to be seen: no grain contrast, and no holes between grains at the edge of the snow, where its density falls off over \
four radii. It was measured on packs of equal spheres, not on lattices (which let more light through) or where grains overlap.
- *Volume* lets too much light through: what grains reflect, outside and inside, is left out of its phase function, which is turned forward too much, and grains \
take no room. It is too dark where snow should be white by its own depth, above all where what is below is dark.
- *Dipole* takes snow for a half space: it does not know that a thin cover lets light out below, or that a ball has another side. Where the ground shows \
through it is far too bright; where snow is small and curved, light that should come from around the edge is missing or comes at the wrong distance. It has no grains, and its \
light is even over all directions.
";
