//! Into which directions deep snow reflects, against the project's reference table
//! (`data/brf_semi_infinite.csv`, whose head names the independent program), identities and fluxes.
//!
//! As in `laboratory`, these test the program, not the physics. `SNOWGRAIN_FULL=1` compares the whole
//! table.

use snowgrain_math::trig;
use snowgrain_optics::IceAbsorption;
use snowgrain_render::SimdLevel;
use snowgrain_render::laboratory::{
    AlbedoSettings, BrdfSettings, Incidence, Polarisation, Scatterers, SnowLayer, SnowStack, View,
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
    let layer = SnowLayer {
        scatterers: Scatterers::Spheres,
        radius: radius_um * 1e-6,
        density: 300.0,
        depth,
        impurities: vec![],
    };
    SnowStack { layers: vec![layer], ground_albedo: 0.0, ice: IceAbsorption::Picard2016 }
}

fn settings(wavelengths_nm: &[f64], sun: f64, views: &[View]) -> BrdfSettings {
    BrdfSettings {
        wavelengths_nm: wavelengths_nm.to_vec(),
        sun_zenith_degrees: sun,
        views: views.to_vec(),
        polarisation: Polarisation::Redrawn,
        standard_error: if full() { 0.006 } else { 0.015 },
        most_paths: 1_000_000,
        seed: 1,
        level: SimdLevel::detect(),
    }
}

fn find(stack: &SnowStack, settings: &BrdfSettings) -> Vec<Vec<Estimate>> {
    homogeneous_brdf(stack, settings, &|_| ())
}

/// Cosine of the angle by which light is turned into a view.
fn scattering(sun: f64, view: View) -> f64 {
    let (sun_sin, sun_cos) = trig::sin_cos(sun.to_radians());
    let (sin, cos) = trig::sin_cos(view.zenith_degrees.to_radians());
    sun_sin * sin * trig::sin_cos(view.azimuth_degrees.to_radians()).1 - sun_cos * cos
}

/// Within 2 % and four standard errors, but for the rainbow: it is a caustic, which has no bound at its
/// angle, and which the table's 300 Legendre terms blur.
#[test]
fn deep_snow_reflects_into_directions_as_an_independent_program_says() {
    const RAINBOW_DEGREES: std::ops::Range<f64> = 129.0..143.0;
    let (table, quick) = (table(), !full());
    let (radii, suns): (&[f64], &[f64]) =
        if quick { (&[200.0], &[60.0]) } else { (&[200.0, 1000.0], &[0.0, 30.0, 60.0, 75.0]) };
    let cases = radii.iter().flat_map(|&radius| suns.iter().map(move |&sun| (radius, sun)));
    let (mut compared, mut worst, mut squares, mut beyond) = (0, [0.0f64; 2], 0.0, 0.0f64);
    for (radius_um, sun) in cases {
        // Where light goes far into the snow, paths take long.
        let of = |row: &&Row| {
            row.radius_um == radius_um && row.sun == sun && !(quick && row.wavelength_nm == 550.0)
        };
        let rows: Vec<&Row> = table.iter().filter(of).collect();
        let mut wavelengths: Vec<f64> = rows.iter().map(|row| row.wavelength_nm).collect();
        wavelengths.dedup();
        let first = rows.iter().filter(|row| row.wavelength_nm == wavelengths[0]);
        let views: Vec<View> = first.map(|row| row.view).collect();
        let found = find(&snow(radius_um, f64::INFINITY), &settings(&wavelengths, sun, &views));
        for row in rows {
            let at = wavelengths.iter().position(|&nm| nm == row.wavelength_nm).expect("known");
            let view = views.iter().position(|&view| view == row.view).expect("known");
            let (found, expected) = (found[at][view], row.factors[0]);
            let off = found.mean - expected;
            let degrees = trig::acos(scattering(sun, row.view)).to_degrees();
            let rainbow = RAINBOW_DEGREES.contains(&degrees);
            worst[usize::from(rainbow)] = worst[usize::from(rainbow)].max(off.abs() / expected);
            if !rainbow {
                squares += off * off / (expected * expected);
                beyond = beyond.max((off.abs() - 4.0 * found.standard_error) / expected);
                compared += 1;
            }
            let allowed = 0.02 * expected + 4.0 * found.standard_error;
            assert!(rainbow || off.abs() <= allowed, "{row:?}: {found:?}");
        }
    }
    assert!(compared >= 60);
    let (percent, rainbow) = (100.0 * worst[0], 100.0 * worst[1]);
    let rms = 100.0 * (squares / f64::from(compared)).sqrt();
    println!(
        "{compared} reflectance factors at most {percent:.2} % off, {rms:.2} % in the mean square, {:.2} % \
         beyond four standard errors; in the rainbow at most {rainbow:.2} %",
        100.0 * beyond
    );
}

/// What is reflected into all directions is the albedo: Gauss-Legendre rules of eight cosines and
/// sixteen azimuths; and the same as light comes the other way (reciprocity), over a ground that
/// reflects, too.
#[test]
fn reflectance_factors_add_up_to_the_albedo_and_are_reciprocal() {
    // Nodes and weights on [0, 1] (Abramowitz and Stegun, table 25.4, n = 8).
    const RULE: [(f64, f64); 8] = [
        (0.019_855_071_751_232, 0.050_614_268_145_188),
        (0.101_666_761_293_187, 0.111_190_517_226_687),
        (0.237_233_795_041_836, 0.156_853_322_938_944),
        (0.408_282_678_752_175, 0.181_341_891_689_181),
        (0.591_717_321_247_825, 0.181_341_891_689_181),
        (0.762_766_204_958_164, 0.156_853_322_938_944),
        (0.898_333_238_706_813, 0.111_190_517_226_687),
        (0.980_144_928_248_768, 0.050_614_268_145_188),
    ];
    let mut stack = snow(300.0, 0.01);
    stack.layers.push(SnowLayer { radius: 100e-6, depth: 0.004, ..stack.layers[0].clone() });
    stack.ground_albedo = 0.4;
    let mut views = Vec::new();
    for (cosine, _) in RULE {
        for azimuth in 0..16 {
            let zenith_degrees = trig::acos(cosine).to_degrees();
            let azimuth_degrees = 11.25 * (f64::from(azimuth) + 0.5);
            views.push(View { zenith_degrees, azimuth_degrees });
        }
    }
    let search = BrdfSettings { standard_error: 0.05, ..settings(&[900.0, 1030.0], 50.0, &views) };
    let found = find(&stack, &search);
    let fluxes = AlbedoSettings {
        wavelengths_nm: search.wavelengths_nm.clone(),
        incidence: Incidence::Sun { zenith_degrees: 50.0 },
        polarisation: search.polarisation,
        standard_error: 0.001,
        relative_error_of_transmittance: f64::INFINITY,
        most_paths: 4_000_000,
        seed: 2,
        level: search.level,
    };
    for (factors, albedo) in found.iter().zip(homogeneous_albedo(&stack, &fluxes, &|_| ())) {
        let rings = RULE.iter().zip(factors.chunks_exact(16));
        let sum: f64 = rings
            .map(|((cosine, weight), ring)| {
                2.0 * cosine * weight * ring.iter().map(|factor| factor.mean).sum::<f64>() / 16.0
            })
            .sum();
        assert!((sum / albedo.reflectance.mean - 1.0).abs() < 0.015, "{sum} {albedo:?}");
    }
    let one = |sun: f64, zenith_degrees: f64, azimuth_degrees: f64| {
        let views = [View { zenith_degrees, azimuth_degrees }];
        find(&stack, &BrdfSettings { seed: 3, ..settings(&[900.0], sun, &views) })[0][0]
    };
    for azimuth in [0.0, 100.0] {
        let (there, back) = (one(20.0, 65.0, azimuth), one(65.0, 20.0, azimuth));
        let error = there.standard_error + back.standard_error;
        assert!((there.mean - back.mean).abs() < 3.0 * error, "{azimuth}: {there:?} {back:?}");
    }
}

/// The theory is of natural shapes: where hardly anything is absorbed it gives what the program of its
/// authors gives to 1 %, whatever the grain.
#[test]
fn the_theory_of_natural_snow_is_that_of_its_authors() {
    let rows = table().into_iter().filter(|row| row.wavelength_nm == 550.0);
    let (mut compared, mut worst) = (0, 0.0f64);
    for row in rows.filter(|row| row.radius_um == 200.0) {
        let search = settings(&[550.0], row.sun, &[row.view]);
        let stack = snow(200.0, f64::INFINITY);
        let found = kokhanovsky_breon_brdf(&stack, &search).expect("it is deep")[0][0];
        let off = (found.mean / row.factors[1] - 1.0).abs();
        (compared, worst) = (compared + 1, worst.max(off));
        assert!(off < 0.01, "{row:?}: {found:?}");
        assert_eq!(found.standard_error, 0.0);
    }
    assert_eq!(compared, 180);
    println!("{compared} factors of the theory, at most {:.2} % off", 100.0 * worst);
    assert!(kokhanovsky_breon_brdf(&snow(200.0, 0.1), &settings(&[550.0], 0.0, &[])).is_none());
}

/// Sixteen nodes and weights of Gauss and Legendre on (0, 1), by Newton's steps.
fn gauss_legendre() -> Vec<[f64; 2]> {
    const NODES: u32 = 16;
    let n = f64::from(NODES);
    let legendre = |x: f64| {
        let (mut last, mut this) = (1.0, x);
        for k in 2..=NODES {
            let k = f64::from(k);
            (last, this) = (this, ((2.0 * k - 1.0) * x * this - (k - 1.0) * last) / k);
        }
        [this, n * (x * this - last) / (x * x - 1.0)]
    };
    let node = |i: u32| {
        let mut x = trig::sin_cos(core::f64::consts::PI * (f64::from(i) + 0.75) / (n + 0.5)).1;
        for _ in 0..8 {
            let [value, slope] = legendre(x);
            x -= value / slope;
        }
        let slope = legendre(x)[1];
        [0.5 * (1.0 + x), 1.0 / ((1.0 - x * x) * slope * slope)]
    };
    (0..NODES).map(node).collect()
}

/// Plates let a third of the light on them straight through, which no table of directions holds: what is
/// reflected into all directions is the albedo all the same. Light from above, 1300 nm; quadrature within .5 %.
#[test]
fn factors_of_plates_add_up_to_their_albedo() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("plates.toml");
    std::fs::write(&file, "[[shapes]]\nshape = \"hexagonal-plate\"\naspect = 0.1\n")
        .expect("written");
    let name = file.to_str().expect("a name");
    let mut stack = snow(200.0, 0.01);
    stack.layers[0].scatterers =
        snowgrain_formats::laboratory::read_scatterers(name, 0).expect("shapes");
    let nodes = gauss_legendre();
    let view = |node: &[f64; 2]| View {
        zenith_degrees: trig::acos(node[0]).to_degrees(),
        azimuth_degrees: 0.0,
    };
    let views: Vec<View> = nodes.iter().map(view).collect();
    let (wavelength, sun) = ([1300.0], 0.0);
    let factors = &find(&stack, &settings(&wavelength, sun, &views))[0];
    let (mut all, mut variance) = (0.0, 0.0);
    for ([cosine, weight], factor) in nodes.iter().zip(factors) {
        let part = 2.0 * cosine * weight;
        all += part * factor.mean;
        variance += part * factor.standard_error;
    }
    let albedo = AlbedoSettings {
        wavelengths_nm: wavelength.to_vec(),
        incidence: Incidence::Sun { zenith_degrees: sun },
        polarisation: Polarisation::Redrawn,
        standard_error: 0.001,
        relative_error_of_transmittance: f64::INFINITY,
        most_paths: 1_000_000,
        seed: 2,
        level: SimdLevel::detect(),
    };
    let found = homogeneous_albedo(&stack, &albedo, &|_| ())[0].reflectance;
    println!("plates: {all} +- {variance}, albedo {found:?}");
    let allowed = 0.005 * found.mean + 4.0 * (variance + found.standard_error);
    assert!((all - found.mean).abs() < allowed, "{all} {found:?}");
}
