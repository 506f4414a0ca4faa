//! Colours of pictures: ice, impurities and grounds, and what a film tells of them afterwards.

use crate::cubes::picture;
use crate::samples;
use snowgrain_accel::SimdLevel;
use snowgrain_film::{Film, FilmError, Layer, Picture, PixelRect, spectral_layers};
use snowgrain_grains::{Amount, DepositRule, DepositSettings, LatticeKind, LatticeSettings, Radii};
use snowgrain_math::{DAffine3, DVec3, trig};
use snowgrain_optics::{
    Absorption, Grade, IceAbsorption, Illuminant, Impurity, ImpurityKind, Load, Primaries,
};
use snowgrain_render::Scene;
use snowgrain_render::Strata;
use snowgrain_render::description::{
    CameraDescription, DirectView, FilmDescription, IceDescription, IntegratorKind,
    LightDescription, LightFinding, LightKind, ObjectDescription, ObjectShape, Projection,
    SceneDescription, SnowDescription, Surface,
};
use snowgrain_render::measure::{Incidence, SlabSettings, measure_slab};

const RED: [f32; 3] = [0.8, 0.08, 0.04];
/// Of the grains, metres.
const RADIUS: f64 = 0.5e-3;

/// A layer of packed grains of so many cells over a red ground, from above, under a uniform sky.
fn layer(cells: [u32; 3], ground: Option<[f32; 3]>, pixels: u32) -> SceneDescription {
    let settings = LatticeSettings {
        kind: LatticeKind::Fcc,
        counts: cells,
        radius: RADIUS,
        spacing: None,
        density: None,
    };
    let side = RADIUS * 8f64.sqrt();
    let size = DVec3::from(cells.map(f64::from)) * side;
    let middle = DVec3::new(0.5 * size.x, size.y, 0.5 * size.z);
    let objects = ground.map(|albedo| ObjectDescription {
        name: "ground".into(),
        shape: ObjectShape::Plane,
        surface: Surface::diffuse(albedo),
        direct_view: DirectView::Seen,
        transform: DAffine3::from_translation(DVec3::Y * -0.01 * RADIUS),
    });
    SceneDescription {
        film: FilmDescription::new(pixels, pixels, 1, 3),
        camera: CameraDescription {
            from: middle + DVec3::new(0.0, 0.3, 0.1),
            at: middle,
            up: DVec3::Y,
            projection: Projection::pinhole(2.0),
            backdrop: [0.0; 3],
        },
        ice: IceDescription { absorption: Absorption::default(), ..IceDescription::clear(1.31) },
        lights: vec![LightDescription {
            visible_to_camera: false,
            ..LightDescription::new(LightKind::Sky, [1.0; 3])
        }],
        objects: objects.into_iter().collect(),
        snow: vec![SnowDescription::Lattice(settings)],
        strata: Strata::default(),
        integrator: IntegratorKind::Grains,
        shapes: Vec::new(),
        light_finding: LightFinding::Exact,
        deep: None,
        packing: None,
        tiled: None,
    }
}

fn rendered(description: &SceneDescription, samples: u64) -> Film {
    let scene = Scene::build(description, &mut |_| ()).unwrap();
    let whole = PixelRect::new(0, 0, description.film.width, description.film.height);
    picture(&scene, 0..samples, whole).film
}

fn load(kind: ImpurityKind, load: Load) -> Impurity {
    Impurity { kind, load }
}

/// Loads from slight to more than any snow has, other ice, other primaries, other lights.
#[test]
fn a_film_that_is_graded_anew_is_a_fresh_render() {
    let mut description = layer([60, 30, 60], Some(RED), 12);
    description.film.keep_ice_paths = true;
    description.lights.push(LightDescription {
        spectrum: Illuminant::A,
        visible_to_camera: false,
        ..LightDescription::new(LightKind::Uniform, [0.3, 0.2, 0.1])
    });
    let spp = samples(64, 512);
    let film = rendered(&description, spp);
    assert_eq!(
        Picture::graded(&film, &film.grade).unwrap(),
        Picture::from_film(&film).unwrap(),
        "the grade of the film changes nothing"
    );
    let warren = Absorption::Measured(IceAbsorption::WarrenBrandt2008);
    let soot = |ppb: f64| load(ImpurityKind::BlackCarbon, Load::MassFraction(ppb * 1e-9));
    let dust = load(ImpurityKind::DustSahara, Load::MassFraction(300e-6));
    let algae = load(ImpurityKind::SnowAlgae, Load::CellsPerKilogram(5e7));
    let mut worst = 0.0f64;
    for (absorption, impurities) in [
        (Absorption::default(), vec![soot(20.0)]),
        (Absorption::default(), vec![soot(1000.0)]),
        (Absorption::default(), vec![soot(50_000.0)]),
        (warren.clone(), vec![]),
        (warren, vec![dust]),
        (Absorption::Grey(0.0), vec![algae]),
        (Absorption::Grey(30.0), vec![]),
    ] {
        for primaries in Primaries::ALL {
            let mut other = description.clone();
            other.ice.absorption = absorption.clone();
            other.ice.impurities.clone_from(&impurities);
            other.film.primaries = primaries;
            let fresh = rendered(&other, spp);
            let fresh_picture = Picture::from_film(&fresh).unwrap();
            let graded = Picture::graded(&film, &fresh.grade).unwrap();
            assert_eq!(graded.primaries, primaries);
            for (a, b) in graded.colour().unwrap().into_iter().zip(fresh_picture.colour().unwrap())
            {
                for (a, b) in a.iter().zip(b) {
                    worst = worst.max(f64::from((a - b).abs()));
                }
            }
        }
    }
    println!("regraded against rendered afresh: at most {worst:.1e} off");
    assert!(worst < 5e-4, "{worst}");
}

#[test]
fn ice_cannot_be_changed_in_a_film_that_keeps_no_ice_paths_but_primaries_can() {
    let film = rendered(&layer([8, 4, 8], None, 4), 2);
    let clear = Grade { absorption: Absorption::Grey(0.0), ..film.grade.clone() };
    assert_eq!(Picture::graded(&film, &clear), Err(FilmError::NoIcePaths));
    let aces = Grade { primaries: Primaries::AcesCg, ..film.grade.clone() };
    let picture = Picture::graded(&film, &aces).unwrap();
    assert!(picture.layer(Layer::VarianceR).is_none());
    assert_eq!(picture.primaries, Primaries::AcesCg);
    assert_eq!(spectral_layers(&film, &clear, None, &[550.0]), Err(FilmError::NoIcePaths));
}

/// A spectral layer is the picture that ice of that wavelength's absorption gives.
#[test]
fn spectral_layers_are_pictures_of_single_wavelengths() {
    let mut description = layer([60, 30, 60], None, 10);
    description.film.keep_ice_paths = true;
    let spp = samples(64, 512);
    let film = rendered(&description, spp);
    let wavelengths = [400.0, 550.0, 700.0];
    let layers = spectral_layers(&film, &film.grade, None, &wavelengths).unwrap();
    for (layer, wavelength) in layers.iter().zip(wavelengths) {
        let mut single = description.clone();
        single.ice.absorption = Absorption::Grey(IceAbsorption::default().per_metre(wavelength));
        let single = Picture::from_film(&rendered(&single, spp)).unwrap();
        let power = Illuminant::D65.power(wavelength) / Illuminant::D65.luminous_mean();
        for (spectral, grey) in layer.values.iter().zip(single.layer(Layer::G).unwrap()) {
            let expected = f64::from(*grey) * power;
            let off = f64::from(*spectral) - expected;
            assert!(off.abs() < 5e-4, "{wavelength} nm: {spectral} instead of {expected}");
        }
    }
}

/// A red sphere under two snowfalls.
fn snowfalls(strata: Strata, everywhere: Vec<Impurity>) -> SceneDescription {
    let mut description = layer([1, 1, 1], Some(RED), 16);
    description.objects.push(ObjectDescription {
        name: "ball".into(),
        shape: ObjectShape::Sphere,
        surface: Surface::diffuse(RED),
        direct_view: DirectView::Seen,
        transform: DAffine3::from_scale(DVec3::splat(0.01)),
    });
    description.camera.from = DVec3::new(0.0, 0.06, 0.06);
    description.camera.at = DVec3::Y * 0.01;
    description.camera.projection = Projection::pinhole(20.0);
    let fall = |grains, mean, seed| {
        SnowDescription::Deposit(DepositSettings {
            amount: Amount::Grains(grains),
            radii: Radii::Uniform { mean, variation: 0.2 * mean },
            density: None,
            rule: Some(DepositRule::Ray),
            max_slope_degrees: 80.0,
            direction: DepositSettings::DOWN,
            area: None,
            seed,
        })
    };
    description.snow = vec![fall(5000, 0.4e-3, 1), fall(3000, 0.3e-3, 2), fall(2000, 0.1e-3, 3)];
    description.strata = strata;
    description.ice.impurities = everywhere;
    description
}

/// Impurities of single snowfalls: of all of them they are those of the ice, and of the last one they
/// darken less, but more than none.
#[test]
fn impurities_of_each_snowfall_are_those_of_its_grains() {
    let soot = load(ImpurityKind::BlackCarbon, Load::MassFraction(20e-6));
    let dust = load(ImpurityKind::DustSahara, Load::MassFraction(500e-6));
    let strata = |bodies: [Vec<Impurity>; 3]| Strata::of(&bodies).unwrap();
    let picture = |description: &SceneDescription| {
        let film = rendered(description, samples(16, 64));
        let picture = Picture::from_film(&film).unwrap();
        picture.colour().unwrap().map(<[f32]>::to_vec)
    };
    let each = strata([vec![soot, dust], vec![soot, dust], vec![soot, dust]]);
    let by_body = picture(&snowfalls(each, vec![]));
    let everywhere = picture(&snowfalls(Strata::default(), vec![soot, dust]));
    for (a, b) in by_body.iter().flatten().zip(everywhere.iter().flatten()) {
        assert!((a - b).abs() < 2e-4, "{a} {b}");
    }
    let sum = |picture: &[Vec<f32>; 3]| picture.iter().flatten().sum::<f32>();
    let clean = picture(&snowfalls(Strata::default(), vec![]));
    let on_top = picture(&snowfalls(strata([vec![], vec![], vec![soot, dust]]), vec![]));
    let below = picture(&snowfalls(strata([vec![soot, dust], vec![], vec![]]), vec![]));
    let [clean, on_top, below, all] = [clean, on_top, below, everywhere].map(|p| sum(&p));
    assert!(all < on_top && on_top < clean && all < below && below < clean);
}

/// The means of the channels over a picture and their standard errors.
fn mean(film: &Film) -> [[f64; 2]; 3] {
    let picture = Picture::from_film(film).unwrap();
    let variance = picture.variance().unwrap();
    let count = variance[0].len() as f64;
    [0, 1, 2].map(|c: usize| {
        let sum: f64 = variance[c].iter().map(|&v| f64::from(v)).sum();
        [picture.mean_radiance().unwrap()[c], sum.sqrt() / count]
    })
}

/// Over a ground of albedo a, by reciprocity, what is seen along a direction is R(direction) +
/// T(direction) a T / (1 - a R), with R and T of diffuse light.
#[test]
fn a_thin_cover_takes_the_colour_of_its_ground() {
    let cells = [250, 4, 250];
    let mut description = layer(cells, Some(RED), 16);
    description.ice.absorption = Absorption::Grey(0.0);
    let seen = mean(&rendered(&description, samples(40, 400)));
    let world = crate::lattice(LatticeKind::Fcc, [8, 4, 8], [true, false, true]);
    // Of grains of radius 1/2; without absorption sizes do not matter.
    let side = 2f64.sqrt();
    let measure = |incidence| {
        let settings = SlabSettings {
            top: 4.0 * side,
            bottom: 0.0,
            period: [8.0 * side; 2],
            incidence,
            from_below: false,
            absorption_per_metre: 0.0,
            paths: samples(200_000, 2_000_000),
            seed: 9,
            level: SimdLevel::detect(),
        };
        let slab = measure_slab(&world, &settings);
        [slab.reflectance.mean, slab.transmittance.mean]
    };
    let zenith_degrees = trig::atan2(0.1, 0.3).to_degrees();
    let [reflected, transmitted] = measure(Incidence::Collimated { zenith_degrees });
    let [diffuse_reflected, diffuse_transmitted] = measure(Incidence::Lambertian);
    for (channel, [mean, standard_error]) in seen.into_iter().enumerate() {
        let albedo = f64::from(RED[channel]);
        let through = albedo * diffuse_transmitted / (1.0 - albedo * diffuse_reflected);
        let expected = reflected + transmitted * through;
        let by_diffuse_light = diffuse_reflected + diffuse_transmitted * through;
        println!("{mean:.4} +- {standard_error:.4}; {expected:.4}, diffuse {by_diffuse_light:.4}");
        assert!((mean / expected - 1.0).abs() < 0.03, "{channel}: {mean} {expected}");
    }
}
