//! Spectral albedo against the project's reference tables (`data/`; the head of each names the
//! independent program that made it, mostly discrete ordinates).
//!
//! These test the program, not the physics: both sides know snow as grains that are met at random.
//! Every comparison allows the tables' tolerance or four standard errors; the seeds are fixed.
//! `SNOWGRAIN_FULL=1` compares whole tables (`tests/README.md`).

use snowgrain_math::trig;
use snowgrain_optics::colour::chromaticity;
use snowgrain_optics::{IceAbsorption, Illuminant, Impurity, ImpurityKind, Load};
use snowgrain_render::SimdLevel;
use snowgrain_render::laboratory::{
    Albedo, AlbedoSettings, GrainLayer, Incidence, Pack, Polarisation, Scatterers, SnowLayer,
    SnowStack, Theory, colour_wavelengths_nm, colours, flux_profile, grain_albedo,
    homogeneous_albedo, theoretical_albedo,
};

const DENSITY: f64 = 300.0;
const TOLERANCE: f64 = 0.002;

fn full() -> bool {
    std::env::var_os("SNOWGRAIN_FULL").is_some_and(|value| value == "1")
}

/// Rows of a table as the fields under the names asked for.
fn rows<'t>(table: &'t str, names: &[&str]) -> Vec<Vec<&'t str>> {
    let mut lines = table.lines().filter(|line| !line.starts_with('#'));
    let heads: Vec<&str> = lines.next().expect("a table has heads").split(',').collect();
    let at = |name: &&str| heads.iter().position(|head| head == name).expect("the column exists");
    let columns: Vec<usize> = names.iter().map(at).collect();
    let fields = |line: &'t str| {
        let fields: Vec<&str> = line.split(',').collect();
        columns.iter().map(|&column| fields[column]).collect()
    };
    lines.map(fields).collect()
}

fn number(text: &str) -> f64 {
    text.parse().expect("the field is a number")
}

fn incidence(zenith: &str) -> Incidence {
    match zenith {
        "diffuse" => Incidence::Diffuse,
        degrees => Incidence::Sun { zenith_degrees: number(degrees) },
    }
}

fn layer(radius_um: f64, depth: f64) -> SnowStack {
    let layer = SnowLayer {
        scatterers: Scatterers::Spheres,
        radius: radius_um * 1e-6,
        density: DENSITY,
        depth,
        impurities: Vec::new(),
    };
    SnowStack { layers: vec![layer], ground_albedo: 0.0, ice: IceAbsorption::Picard2016 }
}

fn settings(wavelengths_nm: Vec<f64>, incidence: Incidence) -> AlbedoSettings {
    AlbedoSettings {
        wavelengths_nm,
        incidence,
        polarisation: Polarisation::Redrawn,
        relative_error_of_transmittance: f64::INFINITY,
        standard_error: if full() { 0.0004 } else { 0.001 },
        most_paths: 4_000_000,
        seed: 1,
        level: SimdLevel::detect(),
    }
}

fn find(stack: &SnowStack, settings: &AlbedoSettings) -> Vec<Albedo> {
    homogeneous_albedo(stack, settings, &|_| ())
}

/// Compares a column of `albedo_semi_infinite.csv` for some radii and angles.
fn assert_deep_snow(column: &str, polarisation: Polarisation, radii: &[&str], angles: &[&str]) {
    let table = include_str!("../data/albedo_semi_infinite.csv");
    let rows = rows(table, &["r_um", "sza_deg", "wavelength_nm", column]);
    let (mut compared, mut worst) = (0, 0.0f64);
    for radius in radii {
        for angle in angles {
            let case: Vec<_> = rows.iter().filter(|row| row[..2] == [*radius, *angle]).collect();
            let wavelengths: Vec<f64> = case.iter().map(|row| number(row[2])).collect();
            let settings =
                AlbedoSettings { polarisation, ..settings(wavelengths, incidence(angle)) };
            let stack = layer(number(radius), f64::INFINITY);
            for (row, found) in case.iter().zip(find(&stack, &settings)) {
                let expected: f64 = number(row[3]);
                let found = found.reflectance;
                let error = (found.mean - expected).abs();
                worst = worst.max(error);
                compared += 1;
                assert!(error <= TOLERANCE.max(4.0 * found.standard_error), "{row:?}: {found:?}");
            }
        }
    }
    assert!(compared >= 18);
    println!("{column}: {compared} albedos of deep snow, at most {worst:.5} off");
}

#[test]
fn deep_snow_reflects_what_discrete_ordinates_say() {
    let radii = ["50", "100", "200", "500", "1000"];
    let angles = ["diffuse", "0", "30", "45", "60", "75", "85"];
    if full() {
        assert_deep_snow("disort_go_unpol", Polarisation::Redrawn, &radii, &angles);
        assert_deep_snow("disort_go_pol", Polarisation::Tracked, &radii, &angles);
    } else {
        assert_deep_snow(
            "disort_go_unpol",
            Polarisation::Redrawn,
            &["50", "1000"],
            &["diffuse", "60"],
        );
        assert_deep_snow("disort_go_pol", Polarisation::Tracked, &["200"], &["diffuse"]);
    }
}

#[test]
fn layers_over_black_reflect_and_transmit_what_discrete_ordinates_say() {
    let table = include_str!("../data/albedo_vs_depth_black_ground.csv");
    let rows = rows(
        table,
        &["r_um", "depth_mm", "sza_deg", "wavelength_nm", "R_disort", "T_disort", "tau_go"],
    );
    let mut cases: Vec<[&str; 3]> = rows.iter().map(|row| [row[0], row[1], row[2]]).collect();
    cases.dedup();
    cases.sort_unstable();
    cases.dedup();
    let step = if full() { 1 } else { 13 };
    let (mut compared, mut worst) = (0, 0.0f64);
    for [radius, depth, angle] in cases.into_iter().step_by(step) {
        let case: Vec<_> = rows.iter().filter(|row| row[..3] == [radius, depth, angle]).collect();
        let wavelengths: Vec<f64> = case.iter().map(|row| number(row[3])).collect();
        let stack = layer(number(radius), 1e-3 * number(depth));
        let tau: f64 = number(case[0][6]);
        assert!((stack.layers[0].optical_depth() / tau - 1.0).abs() < 1e-4);
        let found = find(&stack, &settings(wavelengths, incidence(angle)));
        for (row, found) in case.iter().zip(found) {
            for (column, estimate) in [(4, found.reflectance), (5, found.transmittance)] {
                let expected: f64 = number(row[column]);
                let error = (estimate.mean - expected).abs();
                worst = worst.max(error);
                compared += 1;
                let allowed = TOLERANCE.max(4.0 * estimate.standard_error);
                assert!(error <= allowed, "{row:?}: {estimate:?}");
            }
        }
    }
    assert!(compared >= 60);
    println!("{compared} fluxes of layers, at most {worst:.5} off");
}

#[test]
fn soot_darkens_as_much_as_its_absorption_says() {
    let table = include_str!("../data/albedo_soot.csv");
    let names = ["r_um", "soot_ng_per_g", "wavelength_nm", "R_diffuse_disort", "R_sza60_disort"];
    let rows = rows(table, &names);
    let cases: &[[&str; 2]] = if full() {
        &[["100", "10"], ["100", "100"], ["500", "10"], ["500", "1000"], ["1000", "10000"]]
    } else {
        &[["500", "100"]]
    };
    for [radius, soot] in cases {
        let case: Vec<_> = rows.iter().filter(|row| row[..2] == [*radius, *soot]).collect();
        let wavelengths: Vec<f64> = case.iter().map(|row| number(row[2])).collect();
        assert!(!wavelengths.is_empty());
        let mut stack = layer(number(radius), f64::INFINITY);
        stack.layers[0].impurities = vec![Impurity {
            kind: ImpurityKind::BlackCarbonBond2006,
            load: Load::MassFraction(1e-9 * number(soot)),
        }];
        for (column, angle) in [(3, "diffuse"), (4, "60")] {
            let found = find(&stack, &settings(wavelengths.clone(), incidence(angle)));
            for (row, found) in case.iter().zip(found) {
                let expected: f64 = number(row[column]);
                let error = (found.reflectance.mean - expected).abs();
                assert!(error <= 0.005, "{row:?}: {found:?}");
            }
        }
    }
}

/// Chromaticities of daylight on layers of snow and through them: within .01, as the project asks.
#[test]
fn light_through_snow_turns_as_blue_as_discrete_ordinates_say() {
    let table = include_str!("../data/colour_reflect_transmit.csv");
    let rows = rows(table, &["k_set", "r_um", "depth_mm", "quantity", "x", "y"]);
    let (mut compared, mut worst) = (0, 0.0f64);
    for row in &rows {
        let few = row[1] == "500" && ["100", "200"].contains(&row[2]);
        if !(few || full() && row[1] != "1000") {
            continue;
        }
        let mut stack = layer(number(row[1]), 1e-3 * number(row[2]));
        if row[0] == "k_wb2008" {
            stack.ice = IceAbsorption::WarrenBrandt2008;
        }
        let settings = AlbedoSettings {
            relative_error_of_transmittance: 0.02,
            ..settings(colour_wavelengths_nm(), Incidence::Diffuse)
        };
        let colours = colours(&find(&stack, &settings), Illuminant::D65).expect("they are sorted");
        let [x, y] = chromaticity(colours[usize::from(row[3] == "T")]);
        let off = (x - number(row[4])).abs().max((y - number(row[5])).abs());
        worst = worst.max(off);
        compared += 1;
        assert!(off < 0.01, "{row:?}: {x} {y}");
    }
    assert!(compared >= 8);
    println!("{compared} colours, at most {worst:.5} off in x or y");
}

/// Random packs of solid fraction .15 and .30 against what an independent program found for its own
/// (section 3 of the project's physics), where ice is clear and its index near 1.31: within .004 or four standard
/// errors. One pack differs from the next by less than .002.
#[test]
fn grains_at_random_places_transmit_what_an_independent_program_found() {
    let radius_um = 50.0;
    for (solid_fraction, tau, transmitted) in
        [(0.15, 5.0, 0.5442), (0.30, 20.0, 0.2511), (0.30, 100.0, 0.0617)]
    {
        let depth = tau * 4.0 * radius_um * 1e-6 / (3.0 * solid_fraction);
        let mut stack = layer(radius_um, depth);
        stack.layers[0].density = 917.0 * solid_fraction;
        let settings = settings(vec![560.0], Incidence::Diffuse);
        let mut grains = GrainLayer::new(&stack, Pack::Random, 5).expect("it packs");
        let [exact] = grain_albedo(&stack, &mut grains, &settings, &|_| ())[..] else {
            panic!("one wavelength has one albedo");
        };
        let allowed = 0.004f64.max(4.0 * exact.transmittance.standard_error);
        assert!((exact.transmittance.mean - transmitted).abs() < allowed, "{tau}: {exact:?}");
        assert!(exact.absorptance > 0.0 && exact.absorptance < 0.01);
        // Packed grains let more light through than those that are met at random.
        let homogeneous = find(&stack, &settings)[0].transmittance;
        assert!(homogeneous.mean + 3.0 * homogeneous.standard_error < exact.transmittance.mean);
    }
}

/// Slabs of touching grains in lattices against `packing_slab.csv`, where ice is clear and its index near
/// 1.31: within .004 or four standard errors of both.
#[test]
fn lattices_reflect_and_transmit_what_an_independent_program_found() {
    let table = include_str!("../data/packing_slab.csv");
    let names = ["packing", "tau", "mu0", "reflectance", "transmittance", "standard_error"];
    let (mut compared, mut worst) = (0, 0.0f64);
    for row in rows(table, &names) {
        let (pack, most) = match row[0] {
            "sc" => (Pack::SimpleCubic, 917.0 * core::f64::consts::PI / 6.0),
            "fcc" => (Pack::FaceCentredCubic, 917.0 * core::f64::consts::PI * 2f64.sqrt() / 6.0),
            _ => continue,
        };
        // Other parallel light depends on where it comes from about the vertical.
        let incidence = match row[2] {
            "-1" => Incidence::Diffuse,
            "1" => Incidence::Sun { zenith_degrees: 0.0 },
            _ => continue,
        };
        let (tau, radius_um) = (number(row[1]), 50.0);
        let mut stack = layer(radius_um, tau * 4.0 * radius_um * 1e-6 * 917.0 / (3.0 * most));
        stack.layers[0].density = most;
        let stack = GrainLayer::packed(&stack, pack).expect("it packs");
        assert!((stack.layers[0].optical_depth() / tau - 1.0).abs() < 1e-3, "{row:?}");
        let mut grains = GrainLayer::new(&stack, pack, 0).expect("it packs");
        let settings = settings(vec![560.0], incidence);
        let [found] = grain_albedo(&stack, &mut grains, &settings, &|_| ())[..] else {
            panic!("one wavelength has one albedo");
        };
        let fluxes = [(found.reflectance, row[3]), (found.transmittance, row[4])];
        for (found, expected) in fluxes {
            let off = (found.mean - number(expected)).abs();
            worst = worst.max(off);
            compared += 1;
            let errors = 4.0 * (found.standard_error + number(row[5]));
            assert!(off <= 0.004f64.max(errors), "{row:?}: {found:?}");
        }
    }
    assert_eq!(compared, 32);
    println!("{compared} fluxes of lattices, at most {worst:.5} off");
}

/// `efolding_depth.csv`, column efold_mm_p2016 (r = 500 um): within 3 %, from the first depth where light
/// is diffuse.
#[test]
fn light_in_snow_falls_off_as_fast_as_discrete_ordinates_say() {
    let cases = [(600.0, 251.7), (700.0, 121.413), (800.0, 60.5905), (900.0, 36.3846)];
    let stack = layer(500.0, f64::INFINITY);
    let depths = [0.0, 0.02, 0.08];
    let settings = AlbedoSettings {
        standard_error: 0.01,
        relative_error_of_transmittance: 0.005,
        most_paths: 1_000_000,
        ..settings(cases.iter().map(|case| case.0).collect(), Incidence::Diffuse)
    };
    let profiles = flux_profile(&stack, &depths, &settings, &|_| ()).expect("one layer");
    let albedos = find(&stack, &AlbedoSettings { standard_error: 0.002, ..settings });
    for (((wavelength, expected), fluxes), albedo) in cases.iter().zip(&profiles).zip(&albedos) {
        let fold = 60.0 / trig::ln(fluxes[1].down.mean / fluxes[2].down.mean);
        assert!((fold / expected - 1.0).abs() < 0.03, "{wavelength} nm: {fold} mm");
        assert_eq!(fluxes[0].down.mean, 1.0);
        let errors = fluxes[0].up.standard_error + albedo.reflectance.standard_error;
        let off = fluxes[0].up.mean - albedo.reflectance.mean;
        assert!(off.abs() < 4.0 * errors, "{wavelength} nm: {off} {errors}");
    }
    let ground = SnowStack { ground_albedo: 0.5, ..stack };
    let none = AlbedoSettings {
        wavelengths_nm: vec![600.0],
        ..self::settings(vec![], Incidence::Diffuse)
    };
    assert!(flux_profile(&ground, &depths, &none, &|_| ()).is_none());
}

/// Layers of the same snow are one layer; a clean layer over a sooty one lies between both; a ground
/// adds what it reflects.
#[test]
fn layers_and_grounds_add_up() {
    let whole = layer(200.0, 0.02);
    let mut halves = whole.clone();
    halves.layers[0].depth = 0.005;
    halves.layers.push(SnowLayer { depth: 0.015, ..halves.layers[0].clone() });
    let wavelengths = vec![450.0, 800.0, 1030.0];
    for incidence in [Incidence::Diffuse, Incidence::Sun { zenith_degrees: 50.0 }] {
        let settings = settings(wavelengths.clone(), incidence);
        let (one, two) = (find(&whole, &settings), find(&halves, &settings));
        for (one, two) in one.iter().zip(&two) {
            assert!((one.reflectance.mean - two.reflectance.mean).abs() < 1e-4, "{one:?} {two:?}");
            assert!((one.transmittance.mean - two.transmittance.mean).abs() < 1e-4);
        }
        for stack in [&whole, &halves] {
            let grey = SnowStack { ground_albedo: 0.6, ..stack.clone() };
            let white = SnowStack { ground_albedo: 1.0, ..stack.clone() };
            for ((black, grey), white) in find(stack, &settings)
                .iter()
                .zip(find(&grey, &settings))
                .zip(find(&white, &settings))
            {
                assert!(black.reflectance.mean < grey.reflectance.mean);
                assert!(grey.reflectance.mean < white.reflectance.mean);
                let all = grey.reflectance.mean + 0.4 * grey.transmittance.mean + grey.absorptance;
                assert!((all - 1.0).abs() < 1e-9);
                assert!((white.reflectance.mean + white.absorptance - 1.0).abs() < 1e-9);
            }
        }
    }
    let mut sooty = layer(200.0, f64::INFINITY);
    sooty.layers[0].impurities =
        vec![Impurity { kind: ImpurityKind::BlackCarbon, load: Load::MassFraction(1e-6) }];
    let mut covered = sooty.clone();
    covered.layers.insert(0, SnowLayer { depth: 0.01, ..layer(200.0, 0.01).layers[0].clone() });
    let settings = settings(vec![500.0], Incidence::Diffuse);
    let albedo = |stack: &SnowStack| find(stack, &settings)[0].reflectance.mean;
    let (clean, covered, sooty) =
        (albedo(&layer(200.0, f64::INFINITY)), albedo(&covered), albedo(&sooty));
    assert!(sooty + 0.02 < covered && covered + 0.02 < clean, "{sooty} {covered} {clean}");
}

/// Nothing seen is not known to be nothing; below deep snow it is.
#[test]
fn darkness_has_an_error_too() {
    let settings = settings(vec![1290.0], Incidence::Diffuse);
    let below = |depth: f64| find(&layer(1000.0, depth), &settings)[0].transmittance;
    let (deep, thick) = (below(f64::INFINITY), below(1.0));
    assert_eq!((deep.mean, deep.standard_error, thick.mean), (0.0, 0.0, 0.0));
    assert!(thick.standard_error > 0.0 && thick.standard_error < 1e-3);
}

/// How far the theories are from the exact solution: known, and not more.
#[test]
fn theories_come_as_near_as_they_are_known_to() {
    let stack = layer(200.0, f64::INFINITY);
    let wavelengths = vec![500.0, 700.0, 900.0];
    let exact = find(&stack, &settings(wavelengths.clone(), Incidence::Diffuse));
    for (theory, near) in [
        (Theory::WiscombeWarren, 0.02),
        (Theory::TwoStream, 0.02),
        (Theory::KokhanovskyZege, 0.01),
        // Its grains only refract: g is .874, and 1 - y stands for exp(-y).
        (Theory::BohrenBarkstrom, 0.1),
    ] {
        for exact in &exact {
            let wavelength = exact.wavelength_nm;
            let (incidence, polarisation) = (Incidence::Diffuse, Polarisation::Redrawn);
            let theory = theoretical_albedo(theory, &stack, incidence, polarisation, wavelength)
                .expect("it is one layer");
            let off = theory.reflectance.mean - exact.reflectance.mean;
            assert!(off.abs() < near, "{theory:?} {exact:?}");
        }
    }
    let sun = Incidence::Sun { zenith_degrees: 30.0 };
    let none =
        theoretical_albedo(Theory::BohrenBarkstrom, &stack, sun, Polarisation::Redrawn, 500.0);
    assert!(none.is_none());
}

/// Two layers of the same grains are one layer of twice the depth; impurities of one of them absorb there
/// alone, as they do among grains that are met at random.
#[test]
fn grains_of_several_layers_are_traced_as_one_pack() {
    let layer = |radius: f64, depth: f64, soot: f64| SnowLayer {
        scatterers: Scatterers::Spheres,
        radius,
        density: 200.0,
        depth,
        impurities: vec![Impurity {
            kind: ImpurityKind::BlackCarbon,
            load: Load::MassFraction(soot),
        }],
    };
    let find = |layers: Vec<SnowLayer>| {
        let stack = SnowStack { layers, ground_albedo: 0.4, ice: IceAbsorption::default() };
        let settings = AlbedoSettings {
            wavelengths_nm: vec![450.0, 900.0],
            incidence: Incidence::Diffuse,
            polarisation: Polarisation::Redrawn,
            standard_error: 0.003,
            relative_error_of_transmittance: f64::INFINITY,
            most_paths: 1_000_000,
            seed: 5,
            level: SimdLevel::detect(),
        };
        let mut packed = GrainLayer::new(&stack, Pack::Random, 2).unwrap();
        let exact = grain_albedo(&stack, &mut packed, &settings, &|_| ());
        (exact, homogeneous_albedo(&stack, &settings, &|_| ()))
    };
    let (r, depth) = (0.2e-3, 6e-3);
    let (whole, _) = find(vec![layer(r, 2.0 * depth, 0.0)]);
    let (cut, _) = find(vec![layer(r, depth, 0.0), layer(r, depth, 0.0)]);
    for (whole, cut) in whole.iter().zip(&cut) {
        // Grains of a cut layer do not cross the cut, which changes it by a little.
        let off = (whole.reflectance.mean - cut.reflectance.mean).abs();
        assert!(off < 0.01 + 4.0 * 0.003 * 1.5, "{whole:?} {cut:?}");
    }
    let on_top = vec![layer(0.1e-3, 2e-3, 3e-6), layer(0.3e-3, depth, 0.0)];
    let below: Vec<SnowLayer> = vec![layer(0.1e-3, 2e-3, 0.0), layer(0.3e-3, depth, 3e-6)];
    let absorbed = [on_top, below].map(|layers| {
        let (exact, random) = find(layers);
        // Packed grains let more through than grains that are met at random, by some per cent.
        for (exact, random) in exact.iter().zip(&random) {
            let off = (exact.reflectance.mean - random.reflectance.mean).abs();
            assert!(off < 0.03, "{exact:?} {random:?}");
            assert!((exact.absorptance / random.absorptance - 1.0).abs() < 0.06);
        }
        exact[0].absorptance
    });
    // Most of the ice lies below.
    assert!(absorbed[1] > 1.5 * absorbed[0], "{absorbed:?}");
}

/// Spheroids that are spheres are sampled as any shape is, and have the albedo of spheres; impurities make both as dark.
#[test]
fn sampled_grains_reflect_as_those_of_the_closed_form() {
    use snowgrain_geometry::{Shape, ShapeKind};
    use snowgrain_grains::{MixedShape, Orientation, ShapeMix};
    use snowgrain_render::laboratory::ScatteringMix;
    use std::sync::Arc;
    let shape = Arc::new(Shape::new(ShapeKind::Spheroid { aspect: 1.0 }).expect("a sphere"));
    let mixed = MixedShape { shape, orientation: Orientation::Random, fraction: 1.0 };
    let mix = ShapeMix::new(vec![mixed], 0).expect("one shape");
    let scatterers = Scatterers::Shapes(Arc::new(ScatteringMix::new("round", mix, 3)));
    assert!((scatterers.shadow() - 1.0).abs() < 1e-3 && (scatterers.surface() - 1.0).abs() < 1e-3);
    let kind = ImpurityKind::BlackCarbon;
    let soot = Impurity { kind, load: Load::MassFraction(2e-6) };
    let mut spheres = layer(200.0, 0.02);
    spheres.layers[0].impurities = vec![soot];
    let mut sampled = spheres.clone();
    sampled.layers[0].scatterers = scatterers;
    // One refractive index: samples are made once.
    let settings = settings(vec![700.0], Incidence::Sun { zenith_degrees: 50.0 });
    let [one, other] = [&spheres, &sampled].map(|stack| find(stack, &settings)[0]);
    println!("{one:?} {other:?}");
    for (a, b) in [(one.reflectance, other.reflectance), (one.transmittance, other.transmittance)] {
        // What 2^21 samples may be off beside.
        let allowed = 4.0 * (a.standard_error + b.standard_error) + 0.001;
        assert!((a.mean - b.mean).abs() < allowed, "{a:?} {b:?}");
    }
    let theory = |stack: &SnowStack| {
        theoretical_albedo(
            Theory::WiscombeWarren,
            stack,
            Incidence::Diffuse,
            Polarisation::Redrawn,
            700.0,
        )
    };
    let [one, other] =
        [&spheres, &sampled].map(|of| theory(of).expect("one layer").reflectance.mean);
    assert!((one - other).abs() < 0.002, "{one} {other}");
    assert!(
        theoretical_albedo(
            Theory::BohrenBarkstrom,
            &sampled,
            Incidence::Diffuse,
            Polarisation::Redrawn,
            700.0
        )
        .is_none()
    );
}
