//! How far snow spreads a pencil of light, against the figures of the project's physics (section 7) and
//! exact tracing through grains.

use snowgrain_optics::IceAbsorption;
use snowgrain_render::SimdLevel;
use snowgrain_render::laboratory::{
    AlbedoSettings, FaceSpread, GrainLayer, Incidence, Pack, Polarisation, Scatterers, SnowLayer,
    SnowStack, Spread, SpreadSettings, grain_albedo, grain_spread, homogeneous_albedo,
    homogeneous_spread,
};

/// Grains of half a millimetre, in ice that is clear.
fn snow(density: f64, depth: f64) -> SnowStack {
    let layer = SnowLayer {
        scatterers: Scatterers::Spheres,
        radius: 5e-4,
        density,
        depth,
        impurities: vec![],
    };
    SnowStack { layers: vec![layer], ground_albedo: 0.0, ice: IceAbsorption::WarrenBrandt2008 }
}

fn sun(zenith_degrees: f64) -> Incidence {
    Incidence::Sun { zenith_degrees }
}

fn settings(wavelength_nm: f64, incidence: Incidence) -> SpreadSettings {
    SpreadSettings {
        wavelengths_nm: vec![wavelength_nm],
        incidence,
        polarisation: Polarisation::Redrawn,
        standard_error: 0.003,
        most_paths: 2_000_000,
        seed: 4,
        level: SimdLevel::detect(),
    }
}

fn fluxes(settings: &SpreadSettings) -> AlbedoSettings {
    AlbedoSettings {
        wavelengths_nm: settings.wavelengths_nm.clone(),
        incidence: settings.incidence,
        polarisation: settings.polarisation,
        standard_error: 0.001,
        relative_error_of_transmittance: f64::INFINITY,
        most_paths: 4_000_000,
        seed: 5,
        level: settings.level,
    }
}

fn only(found: Option<Vec<Spread>>) -> Spread {
    let [spread] = &found.expect("one layer over black")[..] else { panic!("one wavelength") };
    spread.clone()
}

/// Deep white snow under light from all around: half of the light leaves within 2.0 transport lengths,
/// 90 % within 11.8, each within 15 %. The length is that of packed grains, 11.6 mm at 275 kg/m^3. Light
/// from the vertical goes deeper and spreads further.
#[test]
fn light_spreads_in_deep_snow_as_far_as_it_is_known_to() {
    let radii = |incidence: Incidence| {
        let stack = snow(275.0, f64::INFINITY);
        let found = only(homogeneous_spread(&stack, &settings(400.0, incidence), &|_| ()));
        assert_eq!(found.transmitted.total.mean, 0.0);
        assert!(found.transmitted.median_radius.mean.is_nan());
        let radii = [found.reflected.median_radius, found.reflected.radius_of_90_percent];
        radii.map(|radius| radius.mean / 0.0116)
    };
    let ([median, most], [upright, upright_most]) = (radii(Incidence::Diffuse), radii(sun(0.0)));
    println!(
        "half of diffuse light within {median:.2} transport lengths, 90 % within {most:.2}; of light \
         from the vertical within {upright:.2} and {upright_most:.2}"
    );
    assert!((median / 2.0 - 1.0).abs() < 0.15 && (most / 11.8 - 1.0).abs() < 0.15);
    assert!(upright > 1.1 * median && upright_most > 1.1 * most);
}

/// All that leaves somewhere is what leaves.
fn assert_sums(face: &FaceSpread) {
    let area = |from: f64, to: f64| core::f64::consts::PI * (to * to - from * from);
    let near = |sum: f64| assert!((sum / face.total.mean - 1.0).abs() < 0.01, "{sum} {face:?}");
    let finite = |bins: &[snowgrain_render::laboratory::SpreadBin],
                  size: &dyn Fn(f64, f64) -> f64| {
        let inner = bins.iter().filter(|bin| bin.to.is_finite());
        inner.map(|bin| bin.value.mean * size(bin.from, bin.to)).sum::<f64>()
    };
    near(finite(&face.per_area, &area));
    near(finite(&face.per_width, &|from, to| 2.0 * (to - from)));
    near(finite(&face.per_path, &|from, to| to - from));
    near(face.within.last().expect("there are bins").value.mean);
}

/// Exactly traced, a pencil loses nothing that a wide beam does not, and grains met at random spread it
/// as far to 5 % where they are not points.
#[test]
fn grains_reflect_of_a_pencil_what_they_reflect_of_a_beam() {
    for (density, zenith) in [(275.0, 0.0), (120.0, 40.0)] {
        let stack = snow(density, 0.02);
        let settings = SpreadSettings { standard_error: 0.002, ..settings(800.0, sun(zenith)) };
        let mut grains = GrainLayer::new(&stack, Pack::Random, 3).expect("it packs");
        let exact = only(grain_spread(&stack, &mut grains, &settings, &|_| ()));
        let [albedo] = grain_albedo(&stack, &mut grains, &fluxes(&settings), &|_| ())[..] else {
            panic!("one wavelength")
        };
        for (face, flux) in
            [(&exact.reflected, albedo.reflectance), (&exact.transmitted, albedo.transmittance)]
        {
            let error = face.total.standard_error + flux.standard_error;
            assert!((face.total.mean - flux.mean).abs() < 3.0 * error, "{:?} {flux:?}", face.total);
            assert_sums(face);
        }
        let random = only(homogeneous_spread(&stack, &settings, &|_| ()));
        for (name, exact, random) in [
            ("reflected", &exact.reflected, &random.reflected),
            ("transmitted", &exact.transmitted, &random.transmitted),
        ] {
            assert_sums(random);
            let parts: [fn(&FaceSpread) -> f64; 4] = [
                |face| face.total.mean,
                |face| face.median_radius.mean,
                |face| face.radius_of_90_percent.mean,
                |face| face.mean_path.mean,
            ];
            let off = parts.map(|part| 100.0 * (part(random) / part(exact) - 1.0));
            println!(
                "{density} kg/m^3, {zenith} degrees, {name}: total {:+.1} %, median radius {:+.1} %, \
                 90 % radius {:+.1} %, mean path {:+.1} %",
                off[0], off[1], off[2], off[3]
            );
            assert!(off.iter().all(|off| off.abs() < 5.0), "{off:?}");
        }
    }
}

/// Where grains are far apart, they are points; what a ground reflects is not known here.
#[test]
fn thin_snow_reflects_of_a_pencil_what_it_reflects_of_a_beam() {
    let stack = snow(15.0, 0.2);
    let settings = settings(900.0, sun(50.0));
    let found = only(homogeneous_spread(&stack, &settings, &|_| ())).reflected.total;
    let albedo = homogeneous_albedo(&stack, &fluxes(&settings), &|_| ())[0].reflectance;
    let error = found.standard_error + albedo.standard_error;
    assert!((found.mean - albedo.mean).abs() < 3.0 * error + 0.002, "{found:?} {albedo:?}");
    let ground = SnowStack { ground_albedo: 0.5, ..stack };
    assert!(homogeneous_spread(&ground, &settings, &|_| ()).is_none());
}
