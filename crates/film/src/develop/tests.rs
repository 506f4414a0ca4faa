use super::*;

fn strip(values: &[f32]) -> Picture {
    coloured(&values.iter().map(|&x| [x; 3]).collect::<Vec<_>>())
}

fn coloured(colours: &[[f32; 3]]) -> Picture {
    let width = colours.len() as u32;
    let mut picture = Picture::new(width, 1, PixelRect::new(0, 0, width, 1)).unwrap();
    for (c, layer) in Layer::COLOUR.into_iter().enumerate() {
        picture.set_layer(layer, colours.iter().map(|colour| colour[c]).collect()).unwrap();
    }
    picture
}

fn codes(picture: &Picture, how: &Development) -> Vec<[u8; 3]> {
    let values = to_8_bit(picture, how).unwrap().values;
    values.as_chunks().0.to_vec()
}

#[test]
fn known_values_clamp_and_encode() {
    let picture = strip(&[0.0, 1.0, 2.0, -1.0, f32::NAN, 0.214_041_14, f32::INFINITY]);
    let plain = Development::default();
    let first: Vec<u8> = codes(&picture, &plain).iter().map(|rgb| rgb[0]).collect();
    assert_eq!(first, [0, 255, 255, 0, 0, 128, 255]); // sRGB .5 is linear .21404
    assert_eq!(to_16_bit(&picture, &plain).unwrap().values[15], 32768);
}

#[test]
fn a_stop_doubles() {
    let stop = to_16_bit(&strip(&[0.1, 0.4]), &Development::plain(1.0)).unwrap();
    assert_eq!(stop, to_16_bit(&strip(&[0.2, 0.8]), &Development::plain(0.0)).unwrap());
    let mut own = strip(&[0.1, 0.4]);
    own.exposure_stops = 3.0;
    let both = Development::plain(-2.0);
    assert_eq!(to_16_bit(&own, &both).unwrap(), stop, "its own exposure, and more");
    assert_eq!(both.stops(&own), Ok(1.0));
}

#[test]
fn other_primaries_show_the_same_colours() {
    let plain = Development::default();
    let mut picture = strip(&[0.4]);
    picture.primaries = Primaries::AcesCg;
    assert_eq!(codes(&picture, &plain), codes(&strip(&[0.4]), &plain));
    // Red of sRGB in ACEScg.
    let mut picture = coloured(&[[0.6131, 0.0702, 0.0206]]);
    picture.primaries = Primaries::AcesCg;
    let [[red, green, blue]] = codes(&picture, &plain)[..] else { panic!() };
    assert!(red >= 254 && green <= 5 && blue <= 5, "{red} {green} {blue}");
}

/// Sunlit snow with grain contrast, shade two stops under it, glints, and a bright backdrop.
fn snow(level: f32) -> Picture {
    let mut colours = Vec::new();
    let mut alpha = Vec::new();
    for i in 0..2000u32 {
        let noise = 0.8 + 0.4 * ((i * 7919) % 1000) as f32 / 1000.0;
        let (light, hit) = match i % 20 {
            0 => ([50.0 * level; 3], 0.0),
            1..6 => ([level * noise, 0.9 * level * noise, 0.7 * level * noise], 1.0),
            _ => ([0.15 * level * noise, 0.2 * level * noise, 0.3 * level * noise], 1.0),
        };
        let glint = i % 101 == 0 && hit == 1.0;
        colours.push(if glint { [3000.0 * level; 3] } else { light });
        alpha.push(hit);
    }
    let mut picture = coloured(&colours);
    picture.set_layer(Layer::A, alpha).unwrap();
    picture
}

#[test]
fn automatic_exposure_puts_the_sunlit_body_where_it_belongs_under_any_curve() {
    for curve in [Curve::Plain, Curve::RollOff { shoulder: 0.7 }, Curve::Filmic, Curve::AgX] {
        for level in [1e-3, 0.9, 4e5] {
            let how = Development { exposure: Exposure::Auto, curve, ..Development::default() };
            let codes = codes(&snow(level), &how);
            let mut sunlit: Vec<u8> =
                (0..2000).filter(|i| (1..6).contains(&(i % 20))).map(|i| codes[i][1]).collect();
            sunlit.sort_unstable();
            let median = sunlit[sunlit.len() / 2];
            assert!((205..=235).contains(&median), "{curve:?} {level}: {median}");
            assert_eq!(codes[2020 % 2000], codes[20], "deterministic");
        }
    }
}

#[test]
fn automatic_exposure_of_darkness_is_none() {
    let how = Development { exposure: Exposure::Auto, ..Development::default() };
    assert_eq!(how.stops(&strip(&[0.0, -0.5])), Ok(0.0));
    assert_eq!(codes(&strip(&[0.0; 3]), &how), [[0; 3]; 3]);
}

#[test]
fn a_grey_under_a_lamp_becomes_neutral() {
    let lamp = colour_temperature::srgb_of(3200.0).map(|x| 0.3 * x as f32);
    let picture = coloured(&[lamp; 4]);
    for white_balance in [WhiteBalance::Kelvin(3200.0), WhiteBalance::Sunlit] {
        let mut scene = Scene::new(&picture).unwrap();
        scene.balance(white_balance);
        let [red, green, blue] = scene.colour(0);
        assert!((red / green - 1.0).abs() < 1e-3 && (blue / green - 1.0).abs() < 1e-3);
        assert!((green - 0.3).abs() < 1e-3, "{green}"); // luminance stays
    }
}

#[test]
fn white_is_that_of_the_sunlit_body_alone() {
    let how = Development {
        exposure: Exposure::Auto,
        white_balance: WhiteBalance::Sunlit,
        ..Development::default()
    };
    let codes = codes(&snow(1.0), &how);
    for (i, [red, green, blue]) in codes.into_iter().enumerate() {
        if (1..6).contains(&(i % 20)) && i % 101 != 0 {
            assert!(red.abs_diff(green) <= 1 && blue.abs_diff(green) <= 1, "{red} {green} {blue}");
        } else if (6..20).contains(&(i % 20)) && i % 101 != 0 {
            assert!(blue > red + 20, "shade stays blue: {red} {green} {blue}");
        }
    }
}

#[test]
fn a_glint_is_brighter_than_white_by_the_light_around_it() {
    let mut light = vec![0.2f32; 41 * 41];
    light[20 * 41 + 20] = 1e4;
    let mut picture = Picture::new(41, 41, PixelRect::new(0, 0, 41, 41)).unwrap();
    for layer in Layer::COLOUR {
        picture.set_layer(layer, light.clone()).unwrap();
    }
    picture.vertical_fov_degrees = Some(2.0);
    let plain = codes(&picture, &Development::default());
    for glare in [Glare::Eye { strength: 1.0 }, Glare::Lens { strength: 1.0 }] {
        let codes = codes(&picture, &Development { glare, ..Development::default() });
        assert_eq!(codes[20 * 41 + 20], [255; 3]);
        assert!(codes[20 * 41 + 22][0] > plain[20 * 41 + 22][0] + 20, "{glare:?}");
    }
}

#[test]
fn every_machine_shows_the_same_bits() {
    let light = |i: usize| {
        0.01 * ((i * 7919) % 97) as f32 + if i.is_multiple_of(301) { 400.0 } else { 0.0 }
    };
    let mut picture = Picture::new(37, 30, PixelRect::new(0, 0, 37, 30)).unwrap();
    for (layer, tint) in Layer::COLOUR.into_iter().zip([0.7, 0.9, 1.2]) {
        picture.set_layer(layer, (0..37 * 30).map(|i| tint * light(i)).collect()).unwrap();
    }
    picture.vertical_fov_degrees = Some(5.0);
    let hash = |curve, glare| {
        let how = Development {
            exposure: Exposure::Auto,
            white_balance: WhiteBalance::Kelvin(7500.0),
            glare,
            curve,
            gamut: Gamut::Compress,
        };
        // FNV-1a.
        let values = to_16_bit(&picture, &how).unwrap().values;
        values
            .iter()
            .flat_map(|value| value.to_le_bytes())
            .fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
                (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
            })
    };
    let found = [
        hash(Curve::AgX, Glare::Eye { strength: 1.0 }),
        hash(Curve::Filmic, Glare::Lens { strength: 2.0 }),
        hash(Curve::RollOff { shoulder: 0.7 }, Glare::None),
    ];
    let golden: [u64; 3] =
        [11_888_692_348_508_427_183, 12_610_033_825_833_847_911, 16_680_270_036_314_732_665];
    assert_eq!(found, golden);
}
