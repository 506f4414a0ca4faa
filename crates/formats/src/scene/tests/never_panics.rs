//! Whatever bytes come in, the answer is a scene or a message.

use super::{meaning_of, read};
use crate::scene::{SceneFile, builtin_scenes};
use proptest::prelude::*;
use std::path::Path;

/// Reads bytes as a scene and checks that a refusal is one line.
fn survive(bytes: &[u8], overrides: &[String]) {
    let outcome = SceneFile::parse_bytes(bytes, Path::new("scene.toml"), overrides)
        .and_then(|file| meaning_of(&file));
    if let Err(error) = outcome {
        assert!(!error.to_string().contains('\n'), "{error}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..Default::default() })]

    #[test]
    fn on_arbitrary_bytes(bytes in proptest::collection::vec(any::<u8>(), 0..400)) {
        survive(&bytes, &[]);
    }

    #[test]
    fn on_builtin_scenes_with_a_damaged_stretch(
        which in 0..builtin_scenes().len(),
        at in any::<prop::sample::Index>(),
        length in 0usize..40,
        patch in prop_oneof![
            "[-0-9.e_naif]{0,12}",
            "[\\[\\]{}=\"'#,.\n ]{0,8}",
            "\\PC{0,8}",
        ],
    ) {
        let mut bytes = builtin_scenes()[which].toml.as_bytes().to_vec();
        let start = at.index(bytes.len());
        let end = (start + length).min(bytes.len());
        bytes.splice(start..end, patch.bytes());
        survive(&bytes, &[]);
    }

    #[test]
    fn on_numbers_of_any_size(
        value in prop_oneof![any::<f64>().prop_map(|v| format!("{v:?}")), any::<i64>().prop_map(|v| v.to_string())],
        key in prop::sample::select(vec![
            "film.width", "film.samples_per_pixel", "film.seed", "camera.from.0", "camera.at.1",
            "camera.up.2", "camera.vertical_fov", "camera.backdrop", "camera.aperture",
            "camera.f_number", "camera.blades", "ice.ior", "ice.absorption",
            "light.radiance", "object.scale", "object.rotate.0", "object.translate.2",
            "object.albedo", "object.roughness", "object.ior", "object.texture_scale", "snow.grains", "snow.radius", "snow.variation", "snow.density",
            "snow.max_slope", "snow.direction.0", "snow.area.0", "snow.seed", "version",
        ]),
    ) {
        survive(builtin_scenes()[0].toml.as_bytes(), &[format!("{key}={value}")]);
    }

    #[test]
    fn on_arbitrary_overrides(assignment in "[a-z0-9._ ]{0,20}\\+?=?\\PC{0,20}") {
        survive(builtin_scenes()[0].toml.as_bytes(), &[assignment]);
    }

    #[test]
    fn and_lengths_mean_the_same_in_every_unit(micrometres in 1u32..10_000) {
        let text = super::LEAST;
        let radii = [
            format!("{micrometres} um"),
            format!("{}.{:03} mm", micrometres / 1000, micrometres % 1000),
            format!("{:?}", f64::from(micrometres) / 1e6),
        ];
        let [a, b, c] = radii.map(|r| {
            format!("{:?}", read(text, &[&format!("snow.radius={r}")]).unwrap().snow)
        });
        prop_assert_eq!(&a, &b);
        prop_assert_eq!(&a, &c);
    }
}
