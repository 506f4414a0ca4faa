use super::*;
use crate::PixelRect;

const BOTH: [Glare; 2] = [Glare::Eye { strength: 1.0 }, Glare::Lens { strength: 1.0 }];

fn picture(width: u32, height: u32) -> Picture {
    let mut picture = Picture::new(width, height, PixelRect::new(0, 0, width, height)).unwrap();
    picture.vertical_fov_degrees = Some(30.0);
    picture
}

fn spread(glare: Glare, width: u32, height: u32, light: impl Fn(usize) -> [f64; 3]) -> Planes {
    glare.spread(&picture(width, height), Curve::Plain, light).unwrap().unwrap()
}

#[test]
fn a_glint_spreads_and_keeps_its_energy_wherever_it_is() {
    for glare in BOTH {
        for (width, height) in [(64, 64), (60, 90), (74, 38)] {
            for at in [0, 5, width as usize - 1, (width * height / 2 + width / 3) as usize] {
                let light = |pixel| if pixel == at { [1e4, 5e3, 0.0] } else { [0.25; 3] };
                let planes = spread(glare, width, height, light);
                let rest = 0.25 * (f64::from(width * height) - 1.0);
                for (plane, glint) in planes.iter().zip([1e4, 5e3, 0.0]) {
                    let energy: f64 = plane.iter().sum();
                    assert!((energy / (glint + rest) - 1.0).abs() < 1e-9, "{glare:?}: {energy}");
                }
                let (left, right) = (planes[0][at], planes[0][at ^ 1]);
                assert!(left < 1e4 && right > 1.0, "{glare:?}: {left} {right}");
                let darkest = planes[0].iter().copied().fold(f64::INFINITY, f64::min);
                assert!(darkest > 0.249, "{glare:?}: {darkest}");
            }
        }
    }
}

#[test]
fn a_constant_picture_stays_constant() {
    for glare in BOTH {
        for level in [0.3, 7.0] {
            let changed = glare.spread(&picture(50, 31), Curve::Plain, |_| [level; 3]).unwrap();
            let planes = changed.unwrap_or([const { Vec::new() }; 3]);
            for value in planes.iter().flatten() {
                assert!((value / level - 1.0).abs() < 1e-12, "{glare:?}: {value}");
            }
        }
    }
}

#[test]
fn what_a_screen_shows_is_left_to_the_eye_that_sees_it() {
    let light = |pixel: usize| [0.9 * (pixel % 2) as f64; 3];
    let unchanged = BOTH[0].spread(&picture(8, 8), Curve::Plain, light).unwrap();
    assert_eq!(unchanged, None);
}

#[test]
fn strength_is_a_factor_and_at_most_all_light_spreads() {
    let light = |pixel| if pixel == 40 * 81 { [1e3; 3] } else { [0.0; 3] };
    let of = |strength| spread(Glare::Lens { strength }, 81, 81, light);
    let (once, twice) = (of(1.0), of(2.0));
    assert!((twice[0][40 * 81 + 9] / once[0][40 * 81 + 9] - 2.0).abs() < 1e-9);
    assert_eq!(of(0.0)[0].iter().filter(|x| x.abs() > 1e-9).count(), 1);
    let all = of(1e6);
    assert!((all[0].iter().sum::<f64>() - 1e3).abs() < 1e-6);
}

#[test]
fn the_eye_needs_angles() {
    let mut picture = picture(4, 4);
    picture.vertical_fov_degrees = None;
    let spread = BOTH[0].spread(&picture, Curve::Plain, |_| [2.0; 3]);
    assert_eq!(spread, Err(FilmError::NoFieldOfView));
}
