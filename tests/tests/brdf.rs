//! Into which directions deep snow reflects, against the project's reference table
//! (`data/brf_semi_infinite.csv`, whose head names the independent program), identities and fluxes.
//!
//! As in `laboratory`, these test the program, not the physics. `SNOWGRAIN_FULL=1` compares the whole
//! table.

use snowgrain_math::trig;
use snowgrain_optics::IceAbsorption;
use snowgrain_render::SimdLevel;
use snowgrain_render::laboratory::{
    AlbedoSettings, BrdfSettings, Incidence, Polarisation, SnowLayer, SnowStack, View,
    homogeneous_albedo, homogeneous_brdf, kokhanovsky_breon_brdf,
};
use snowgrain_render::measure::Estimate;

/// A row of the table.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Row {
    wavelength_nm: f64,
    radius_um: f64,
    sun: f64,
    view: View,
    /// By Mishchenko's program, and by that of Kokhanovsky and Breon.
    factors: [f64; 2],
}

fn table() -> Vec<Row> {
    let lines = include_str!("../data/brf_semi_infinite.csv").lines();
    let row = |line: &str| {
        let numbers: Vec<f64> =
            line.split(',').map(|field| field.parse().expect("a number")).collect();
        Row {
            wavelength_nm: numbers[0],
            radius_um: numbers[1],
            sun: numbers[2],
            view: View { zenith_degrees: numbers[3], azimuth_degrees: numbers[4] },
            factors: [numbers[5], numbers[6]],
        }
    };
    lines.filter(|line| !line.starts_with('#')).skip(1).map(row).collect()
}

fn full() -> bool {
    std::env::var_os("SNOWGRAIN_FULL").is_some_and(|value| value == "1")
}

fn snow(radius_um: f64, depth: f64) -> SnowStack {
    let layer = SnowLayer { radius: radius_um * 1e-6, density: 300.0, depth, impurities: vec![] };
    SnowStack { layers: vec![layer], ground_albedo: 0.0, ice: IceAbsorption::Picard2016 }
}

fn settings(wavelengths_nm: &[f64], sun: f64, views: &[View]) -> BrdfSettings {
    BrdfSettings {
        wavelengths_nm: wavelengths_nm.to_vec(),
        sun_zenith_degrees: sun,
        views: views.to_vec(),
        polarisation: Polarisation::Redrawn,
        standard_error: if full() { 0.003 } else { 0.01 },
        most_paths: 1_000_000,
        seed: 1,
        level: SimdLevel::detect(),
    }
}

fn find(stack: &SnowStack, settings: &BrdfSettings) -> Vec<Vec<Estimate>> {
    homogeneous_brdf(stack, settings, &mut |_, _| ())
}

#[test]
fn deep_snow_reflects_into_directions_as_an_independent_program_says() {
    let table = table();
    let wavelengths = [550.0, 900.0, 1300.0];
    let cases: &[(f64, f64)] =
        &[(200.0, 0.0), (200.0, 30.0), (200.0, 60.0), (200.0, 75.0), (1000.0, 0.0), (1000.0, 30.0), (1000.0, 60.0), (1000.0, 75.0)];
    for &(radius_um, sun) in if full() { cases } else { &cases[2..3] } {
        let of = |row: &&Row| row.radius_um == radius_um && row.sun == sun;
        let rows: Vec<&Row> = table.iter().filter(of).collect();
        let views: Vec<View> =
            rows.iter().filter(|row| row.wavelength_nm == 550.0).map(|row| row.view).collect();
        let clock = std::time::Instant::now();
        let found = find(&snow(radius_um, f64::INFINITY), &settings(&wavelengths, sun, &views));
        println!("{radius_um} {sun}: {:?}", clock.elapsed());
        for row in rows {
            let at = wavelengths.iter().position(|&nm| nm == row.wavelength_nm).expect("known");
            let view = views.iter().position(|&view| view == row.view).expect("known");
            let found = found[at][view];
            println!(
                "{} {} {} {:?} {} {:.4} {:.4} {:+.2}% {:+.1}s",
                row.wavelength_nm, radius_um, sun, row.view, row.factors[0], found.mean, found.standard_error,
                100.0 * (found.mean / row.factors[0] - 1.0),
                (found.mean - row.factors[0]) / found.standard_error
            );
        }
    }
}
