//! Metal, glass, what is cut out and what catches shadows, under lights that are looked for and that are not.

use crate::assert_agrees;
use crate::lights::{film, ground, mean};
use snowgrain_film::{CaughtLight, Film, Layer, Picture};
use snowgrain_math::{DAffine3, DVec3};
use snowgrain_render::description::{
    DirectView, LightDescription, LightFinding, LightKind, ObjectDescription, ObjectShape,
    SceneDescription, SearchSettings, Sought, Surface,
};
use snowgrain_render::light::direction_of;
use snowgrain_render::surface::Reflectance;

fn metal(reflectance: f32, roughness: f64) -> Surface {
    let reflectance = Reflectance::Colour([reflectance; 3]);
    Surface::Conductor { reflectance, edge: [0.0; 3], roughness }
}

/// The sun so high, 20 degrees wide.
fn sun(elevation_degrees: f64) -> LightDescription {
    let direction = direction_of(elevation_degrees, 120.0);
    LightDescription::new(LightKind::Sun { direction, diameter_degrees: 20.0 }, [5.0; 3])
}

/// Ground of this surface under these lights.
fn ground_of(surface: Surface, lights: Vec<LightDescription>) -> SceneDescription {
    let mut description = ground(lights);
    description.objects[0].surface = surface;
    description
}

/// A ball over diffuse ground that the camera looks through.
fn ball(surface: Surface, lights: Vec<LightDescription>) -> SceneDescription {
    let mut description = ground(lights);
    description.objects.push(ObjectDescription {
        name: "ball".into(),
        shape: ObjectShape::Sphere,
        surface,
        direct_view: DirectView::Seen,
        transform: DAffine3::from_translation(DVec3::Y * 0.1)
            * DAffine3::from_scale(DVec3::splat(0.05)),
    });
    description
}

/// Light that is looked for and light that is met by chance are as bright. Four comparisons.
#[test]
fn light_is_as_bright_however_it_is_found() {
    let glass = |roughness| Surface::Dielectric { ior: 1.5, roughness };
    for (name, mut description) in [
        ("rough metal", ground_of(metal(0.8, 0.6), vec![sun(65.0)])),
        ("rough glass over ground", ball(glass(0.5), vec![sun(75.0)])),
        ("smooth glass over ground", ball(glass(0.0), vec![sun(75.0)])),
        ("metal in glass", {
            let mut inside = ball(glass(0.4), vec![sun(80.0)]);
            let mut core = inside.objects[1].clone();
            core.surface = metal(0.9, 0.7);
            core.transform *= DAffine3::from_scale(DVec3::splat(0.6));
            inside.objects.push(core);
            inside
        }),
    ] {
        let found =
            [LightFinding::Exact, LightFinding::Sampled(SearchSettings::of(Sought::NotSkies))].map(
                |finding| {
                    description.light_finding = finding;
                    mean(&film(&description, 512))
                },
            );
        let [exact, sampled] = found;
        println!("{name}: {exact:?} {sampled:?}");
        assert!(exact.mean > 0.0 && exact.standard_error < 0.05 * exact.mean, "{name}");
        let [a, b] = [exact.standard_error, sampled.standard_error];
        let error = (a * a + b * b).sqrt();
        assert!((exact.mean - sampled.mean).abs() < 4.0 * error, "{name}: {exact:?} {sampled:?}");
    }
}

#[test]
fn a_mirror_shows_the_sun_whether_or_not_it_is_looked_for() {
    let mut description = ground_of(metal(0.8, 0.0), vec![sun(90.0)]);
    for finding in
        [LightFinding::Exact, LightFinding::Sampled(SearchSettings::of(Sought::NotSkies))]
    {
        description.light_finding = finding;
        assert_agrees("mirror", mean(&film(&description, 4)), 4.0, 1e-4);
    }
}

/// Glass takes no light: in uniform light a white world with glass in it cannot be seen.
#[test]
fn smooth_glass_is_not_to_be_seen_in_uniform_light() {
    for ior in [1.0, 1.33, 2.4] {
        let light = LightDescription::new(LightKind::Uniform, [1.0; 3]);
        let mut description = ball(Surface::Dielectric { ior, roughness: 0.0 }, vec![light]);
        description.objects[0].surface = Surface::diffuse([1.0; 3]);
        for pixel in film(&description, 8).pixels() {
            assert_eq!(pixel.mean_radiance(), [1.0; 3]);
        }
    }
}

#[test]
fn what_is_held_out_is_cut_out_but_throws_its_shadow() {
    let mut description =
        ball(Surface::diffuse([0.5; 3]), vec![LightDescription::new(LightKind::Sky, [1.0; 3])]);
    let shaded = {
        description.camera.from = DVec3::new(0.0, 0.02, 0.3);
        mean(&film(&description, 16)).mean
    };
    description.objects[1].direct_view = DirectView::Holdout;
    assert_eq!(mean(&film(&description, 16)).mean, shaded, "the ground is as it was");
    description.camera.from = DVec3::Y * 0.3;
    for pixel in film(&description, 4).pixels() {
        assert_eq!((pixel.mean_radiance(), pixel.mean_alpha()), ([0.0; 3], 0.0));
    }
}

/// What the shadow catchers of a film show, pixel by pixel.
fn caught(film: &Film) -> Vec<CaughtLight> {
    let sums = film.shadow_sums().expect("the film has shadow catchers");
    let pixels = film.pixels().iter().zip(sums);
    pixels.map(|(pixel, sums)| CaughtLight::of(sums, pixel.samples())).collect()
}

/// A ball over ground, both with lamps and in the sun, however light is found.
#[test]
fn a_shadow_catcher_knows_what_it_would_show_alone_to_the_last_bit() {
    let sampled = SearchSettings::of(Sought::NotSkies);
    let lamp = LightKind::Sphere { center: DVec3::new(0.1, 0.3, 0.0), radius: 0.05 };
    for (light, finding) in [
        (sun(60.0), LightFinding::Exact),
        (sun(60.0), LightFinding::Sampled(sampled)),
        (LightDescription::new(LightKind::Sky, [1.0, 0.5, 0.25]), LightFinding::Exact),
        (LightDescription::new(lamp, [4.0; 3]), LightFinding::Sampled(sampled)),
    ] {
        let mut description = ball(Surface::diffuse([0.2, 0.5, 0.8]), vec![light]);
        description.camera.from = DVec3::new(0.0, 0.4, 0.3);
        description.light_finding = finding;
        let seen = film(&description, 16);
        description.objects[0].direct_view = DirectView::ShadowCatcher;
        let catching = film(&description, 16);
        description.objects[1].direct_view = DirectView::Seen;
        description.objects.truncate(1);
        let empty = caught(&film(&description, 16));
        description.objects[0].direct_view = DirectView::Seen;
        let alone = film(&description, 16);
        let picture = Picture::from_film(&catching).expect("a picture");
        let alpha = picture.layer(Layer::A).expect("alpha");
        let (mut shaded, mut whole) = (0, 0);
        for (index, caught) in caught(&catching).iter().enumerate() {
            let (with_ball, ground) =
                (&seen.pixels()[index], alone.pixels()[index].mean_radiance());
            assert_eq!(catching.pixels()[index].mean_radiance(), with_ball.mean_radiance());
            assert_eq!((empty[index].lit, empty[index].unoccluded), (ground, ground));
            assert_eq!(empty[index].over_plate(ground, 0.0), ([0.0; 3], 0.0));
            if caught.coverage == 1.0 {
                whole += 1;
                assert_eq!(caught.unoccluded, ground, "{finding:?}");
                assert_eq!(caught.lit, with_ball.mean_radiance());
                shaded += usize::from(alpha[index] > 0.1);
            }
        }
        assert!(whole > 10 && shaded > 0, "{whole} pixels of ground, {shaded} in the shadow");
    }
}
