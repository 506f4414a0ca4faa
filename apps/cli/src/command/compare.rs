//! `snowgrain compare`.

use crate::arguments::CompareArguments;
use crate::failure::Failure;
use crate::output;
use serde::Serialize;
use snowgrain_film::compare::{Comparison, ZTest, compare};
use snowgrain_formats::image::read_picture;
use std::fmt::Write;

/// Exit code where a threshold is exceeded.
const EXCEEDED: u8 = 1;

pub(super) fn run(arguments: &CompareArguments) -> Result<u8, Failure> {
    let picture = read_picture(&arguments.picture)?;
    let reference = read_picture(&arguments.reference)?;
    for (picture, path) in [(&picture, &arguments.picture), (&reference, &arguments.reference)] {
        if picture.denoised {
            output::tell(&format!(
                "snowgrain: {}: these colours are a denoiser's guess; they say nothing of how right \
                 the render is",
                path.display()
            ));
        }
    }
    let comparison = compare(&picture, &reference, arguments.exposure, arguments.pixels_per_degree)
        .map_err(|error| {
            let names = [&arguments.picture, &arguments.reference].map(|p| p.display());
            Failure::from(error).of(&format!("{} and {}", names[0], names[1]))
        })?;
    if arguments.significance.is_some() && comparison.z_test.is_none() {
        return Err(Failure::bad_input(
            "--significance needs variance layers in both pictures; give .exr or .film files",
        ));
    }
    if arguments.json {
        output::print(&output::json(&Figures::from(&comparison))?)?;
    } else {
        output::print(&text(&comparison))?;
    }
    Ok(if exceeds(arguments, &comparison) { EXCEEDED } else { 0 })
}

fn exceeds(arguments: &CompareArguments, comparison: &Comparison) -> bool {
    let above =
        |value: f64, most: Option<f64>| most.is_some_and(|most| value > most || value.is_nan());
    let inconsistent = |significance| {
        comparison.z_test.as_ref().is_some_and(|test| !test.consistent(significance))
    };
    above(comparison.rmse, arguments.max_rmse)
        || above(comparison.flip, arguments.max_flip)
        || arguments.significance.is_some_and(inconsistent)
}

fn text(comparison: &Comparison) -> String {
    let mut text = String::new();
    let triple = |[r, g, b]: [f64; 3]| format!("{r:.6} {g:.6} {b:.6}");
    let mut line = |name: &str, value: String| {
        let _ = writeln!(text, "{name:15}{value}"); // writing to a string does not fail
    };
    line("RMSE", format!("{:.6}", comparison.rmse));
    line("relative RMSE", format!("{:.6}", comparison.relative_rmse));
    line("FLIP", format!("{:.6}", comparison.flip));
    line("mean", triple(comparison.mean));
    line("reference mean", triple(comparison.reference_mean));
    match &comparison.z_test {
        None => line("z-test", "none: both pictures must have variance layers".into()),
        Some(test) => {
            let (x, y) = test.largest_at;
            line(
                "z of pixels",
                format!(
                    "largest {:.3} at ({x}, {y}); noise alone reaches it with probability {:.3e}",
                    test.largest_z, test.pixel_probability
                ),
            );
            line(
                "z of mean",
                format!(
                    "{}; chi-square {:.3}; noise alone reaches it with probability {:.3e}",
                    triple(test.mean_z),
                    test.mean_chi_square,
                    test.mean_probability
                ),
            );
            line("chi2 a pixel", triple(test.chi_square_per_pixel));
        }
    }
    text
}

/// What `--json` prints.
#[derive(Serialize)]
struct Figures {
    rmse: f64,
    relative_rmse: f64,
    flip: f64,
    mean: [f64; 3],
    reference_mean: [f64; 3],
    z_test: Option<ZFigures>,
}

#[derive(Serialize)]
struct ZFigures {
    tests: u64,
    largest_z: f64,
    largest_at: (u32, u32),
    pixel_probability: f64,
    mean_z: [f64; 3],
    mean_chi_square: f64,
    mean_probability: f64,
    chi_square_per_pixel: [f64; 3],
}

impl From<&Comparison> for Figures {
    fn from(comparison: &Comparison) -> Self {
        let &Comparison { rmse, relative_rmse, mean, reference_mean, flip, .. } = comparison;
        let z_test = comparison.z_test.as_ref().map(ZFigures::from);
        Self { rmse, relative_rmse, flip, mean, reference_mean, z_test }
    }
}

impl From<&ZTest> for ZFigures {
    fn from(test: &ZTest) -> Self {
        Self {
            tests: test.tests,
            largest_z: test.largest_z,
            largest_at: test.largest_at,
            pixel_probability: test.pixel_probability,
            mean_z: test.mean_z,
            mean_chi_square: test.mean_chi_square,
            mean_probability: test.mean_probability,
            chi_square_per_pixel: test.chi_square_per_pixel,
        }
    }
}
