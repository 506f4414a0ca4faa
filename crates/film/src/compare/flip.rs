//! LDR-FLIP: the error that a viewer sees when two pictures alternate in place.
//!
//! After Andersson, Nilsson, Akenine-Möller, Oskarsson, Åström and Fairchild, "FLIP: A Difference
//! Evaluator for Alternating Images", Proc. ACM Comput. Graph. Interact. Tech. 3 (2), 2020. A colour
//! pipeline (contrast sensitivity of the eye in YCxCz, Hunt effect, HyAB distance in L*a*b*) gives
//! an error that a feature pipeline (edges and points) amplifies. 0: no difference; 1: the largest.

use crate::FilmError;
use crate::develop::{Developed, linear_from_srgb};
use snowgrain_math::{DMat3, DVec3, trig};
use std::f64::consts::{FRAC_1_SQRT_2, PI};

/// Pixels per degree of visual angle of a 0.7 m wide 3840-pixel monitor seen from 0.7 m, the
/// paper's default.
pub const PIXELS_PER_DEGREE: f64 = 67.0;

/// The error of every pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct FlipMap {
    /// Error per pixel of the window, row-major, in [0, 1].
    pub errors: Vec<f64>,
    /// Mean error.
    pub mean: f64,
}

/// Compares two developed pictures.
///
/// # Errors
/// Pictures that do not cover the same pixels.
pub fn flip(
    reference: &Developed<u8>,
    test: &Developed<u8>,
    pixels_per_degree: f64,
) -> Result<FlipMap, FilmError> {
    if reference.window != test.window {
        let (ours, theirs) = (test.window, reference.window);
        return Err(FilmError::PicturesDiffer { ours, theirs });
    }
    let width = reference.window.width() as usize;
    let space = ColourSpace::srgb();
    let [a, b] = [reference, test].map(|picture| opponent_planes(&picture.values, width, &space));
    let colour = colour_errors(&a, &b, &space, pixels_per_degree);
    let features = feature_errors(&a[0], &b[0], pixels_per_degree);
    let errors: Vec<f64> =
        colour.iter().zip(&features).map(|(&c, &f)| trig::pow(c, 1.0 - f)).collect();
    let mean = errors.iter().sum::<f64>() / errors.len() as f64;
    Ok(FlipMap { errors, mean })
}

/// One value per pixel, row-major.
struct Plane {
    width: usize,
    values: Vec<f64>,
}

impl Plane {
    /// Convolved with the product of a kernel along x and one along y, both of odd length; pixels
    /// beyond the border repeat it.
    fn filtered(&self, along_x: &[f64], along_y: &[f64]) -> Self {
        self.convolved(along_x, 1).convolved(along_y, self.width)
    }

    /// Convolved along the axis whose neighbours are `stride` values apart.
    fn convolved(&self, kernel: &[f64], stride: usize) -> Self {
        let length = if stride == 1 { self.width } else { self.values.len() / self.width };
        let radius = kernel.len() / 2;
        let values = (0..self.values.len())
            .map(|index| {
                let at = if stride == 1 { index % self.width } else { index / self.width };
                let start = index - at * stride;
                let tap = |k: usize| (at + k).saturating_sub(radius).min(length - 1);
                let sum = |(k, w): (usize, &f64)| w * self.values[start + tap(k) * stride];
                kernel.iter().enumerate().map(sum).sum()
            })
            .collect();
        Self { width: self.width, values }
    }

    /// `a * self + b * other`.
    fn mixed(&self, a: f64, other: &Self, b: f64) -> Self {
        let values = self.values.iter().zip(&other.values).map(|(x, y)| a * x + b * y).collect();
        Self { width: self.width, values }
    }
}

/// The colour space of sRGB (IEC 61966-2-1) between linear RGB and XYZ relative to that of white,
/// in which white is (1, 1, 1).
struct ColourSpace {
    relative_xyz_from_rgb: DMat3,
    rgb_from_relative_xyz: DMat3,
}

impl ColourSpace {
    /// From the chromaticities of the primaries and of white (D65): the columns are the XYZ of the
    /// primaries, scaled so that they sum to the XYZ of white.
    fn srgb() -> Self {
        let xyz = |x: f64, y: f64| DVec3::new(x / y, 1.0, (1.0 - x - y) / y);
        let primaries = DMat3::from_cols(xyz(0.64, 0.33), xyz(0.30, 0.60), xyz(0.15, 0.06));
        let white = xyz(0.3127, 0.3290);
        let xyz_from_rgb = primaries * DMat3::from_diagonal(primaries.inverse() * white);
        let relative_xyz_from_rgb = DMat3::from_diagonal(white.recip()) * xyz_from_rgb;
        Self { relative_xyz_from_rgb, rgb_from_relative_xyz: relative_xyz_from_rgb.inverse() }
    }

    /// Y, Cx, Cz (linearised CIELAB, section 4.1 of the paper) of linear RGB.
    fn opponent(&self, rgb: DVec3) -> [f64; 3] {
        let [x, y, z] = (self.relative_xyz_from_rgb * rgb).to_array();
        [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
    }

    /// Linear RGB, clamped to [0, 1], of Y, Cx, Cz.
    fn rgb_from_opponent(&self, [luminance, cx, cz]: [f64; 3]) -> DVec3 {
        let y = (luminance + 16.0) / 116.0;
        let relative = DVec3::new(y + cx / 500.0, y, y - cz / 200.0);
        (self.rgb_from_relative_xyz * relative).clamp(DVec3::ZERO, DVec3::ONE)
    }

    /// L*, a*, b* with chroma scaled by lightness (Hunt effect, eq. 5 of the paper).
    fn hunt_lab(&self, rgb: DVec3) -> [f64; 3] {
        const DELTA: f64 = 6.0 / 29.0;
        let [x, y, z] = (self.relative_xyz_from_rgb * rgb).to_array().map(|t| {
            if t > DELTA * DELTA * DELTA {
                trig::pow(t, 1.0 / 3.0)
            } else {
                t / (3.0 * DELTA * DELTA) + 4.0 / 29.0
            }
        });
        let lightness = 116.0 * y - 16.0;
        [lightness, 0.01 * lightness * 500.0 * (x - y), 0.01 * lightness * 200.0 * (y - z)]
    }
}

/// The planes Y, Cx, Cz of an sRGB-encoded picture.
fn opponent_planes(srgb: &[u8], width: usize, space: &ColourSpace) -> [Plane; 3] {
    let mut planes = [(); 3].map(|()| Plane { width, values: Vec::with_capacity(srgb.len() / 3) });
    for rgb in srgb.chunks_exact(3) {
        let linear = |x: u8| linear_from_srgb(f64::from(x) / 255.0);
        let rgb = DVec3::new(linear(rgb[0]), linear(rgb[1]), linear(rgb[2]));
        let opponent = space.opponent(rgb);
        planes.iter_mut().zip(opponent).for_each(|(plane, value)| plane.values.push(value));
    }
    planes
}

/// HyAB distance: city block in lightness, Euclidean in chroma.
fn hyab(p: [f64; 3], q: [f64; 3]) -> f64 {
    let [l, a, b] = std::array::from_fn(|i| p[i] - q[i]);
    l.abs() + (a * a + b * b).sqrt()
}

/// Contrast sensitivity of one opponent channel: `sum of a sqrt(pi/b) exp(-pi^2 d^2 / b)` at the
/// distance d in degrees (table 1 of the paper).
type Sensitivity = [(f64, f64); 2];
const SENSITIVITIES: [Sensitivity; 3] =
    [[(1.0, 0.0047), (0.0, 1e-5)], [(1.0, 0.0053), (0.0, 1e-5)], [(34.1, 0.04), (13.5, 0.025)]];

/// What the eye's contrast sensitivity leaves of one opponent channel. The kernel is a sum of two
/// Gaussians, each a product of one along x and one along y; together they sum to 1.
fn filtered_by_sensitivity(plane: &Plane, terms: &Sensitivity, pixels_per_degree: f64) -> Plane {
    let radius = (3.0 * (0.04 / (2.0 * PI * PI)).sqrt() * pixels_per_degree).ceil() as i32;
    let kernels = terms.map(|(a, b)| {
        let kernel: Vec<f64> = (-radius..=radius)
            .map(|i| {
                let d = f64::from(i) / pixels_per_degree;
                trig::exp(-PI * PI * d * d / b)
            })
            .collect();
        let sum: f64 = kernel.iter().sum();
        (a * (PI / b).sqrt() * sum * sum, kernel.iter().map(|w| w / sum).collect::<Vec<_>>())
    });
    let total = kernels[0].0 + kernels[1].0;
    let [first, second] = &kernels;
    let main = plane.filtered(&first.1, &first.1);
    if second.0 == 0.0 {
        return main;
    }
    main.mixed(first.0 / total, &plane.filtered(&second.1, &second.1), second.0 / total)
}

/// The colour pipeline: error per pixel in [0, 1].
fn colour_errors(
    reference: &[Plane; 3],
    test: &[Plane; 3],
    space: &ColourSpace,
    pixels_per_degree: f64,
) -> Vec<f64> {
    let perceived = |planes: &[Plane; 3]| -> [Plane; 3] {
        std::array::from_fn(|i| {
            filtered_by_sensitivity(&planes[i], &SENSITIVITIES[i], pixels_per_degree)
        })
    };
    let (reference, test) = (perceived(reference), perceived(test));
    let lab = |planes: &[Plane; 3], index: usize| {
        let opponent = std::array::from_fn(|i| planes[i].values[index]);
        space.hunt_lab(space.rgb_from_opponent(opponent))
    };
    let (green, blue) = (space.hunt_lab(DVec3::Y), space.hunt_lab(DVec3::Z));
    let largest = trig::pow(hyab(green, blue), COLOUR_EXPONENT);
    (0..reference[0].values.len())
        .map(|i| {
            let distance = hyab(lab(&reference, i), lab(&test, i));
            redistributed(trig::pow(distance, COLOUR_EXPONENT), largest)
        })
        .collect()
}

/// The paper's q_c.
const COLOUR_EXPONENT: f64 = 0.7;

/// Maps [0, `largest`] to [0, 1] so that the first 40 % (p_c) take 95 % (p_t) of it (eq. 8 of the
/// paper).
fn redistributed(error: f64, largest: f64) -> f64 {
    const KNEE: f64 = 0.4;
    const KNEE_VALUE: f64 = 0.95;
    let knee = KNEE * largest;
    if error < knee {
        KNEE_VALUE / knee * error
    } else {
        let beyond = (error - knee) / (largest - knee) * (1.0 - KNEE_VALUE);
        (KNEE_VALUE + beyond).min(1.0)
    }
}

/// The feature pipeline: how much edges and points differ per pixel, in [0, 1].
fn feature_errors(reference: &Plane, test: &Plane, pixels_per_degree: f64) -> Vec<f64> {
    const WIDTH_DEGREES: f64 = 0.082;
    let deviation = 0.5 * WIDTH_DEGREES * pixels_per_degree;
    let radius = (3.0 * deviation).ceil() as i32;
    let sampled = |shape: &dyn Fn(f64) -> f64| -> Vec<f64> {
        (-radius..=radius)
            .map(|i| {
                let x = f64::from(i);
                shape(x) * trig::exp(-x * x / (2.0 * deviation * deviation))
            })
            .collect()
    };
    let smooth = balanced(&sampled(&|_| 1.0));
    let edge = balanced(&sampled(&|x| -x));
    let point = balanced(&sampled(&|x| x * x / (deviation * deviation) - 1.0));
    let strengths = |luminance: &Plane, across: &[f64]| -> Vec<f64> {
        let values = luminance.values.iter().map(|y| (y + 16.0) / 116.0).collect();
        let plane = Plane { width: luminance.width, values };
        let (x, y) = (plane.filtered(across, &smooth), plane.filtered(&smooth, across));
        x.values.iter().zip(&y.values).map(|(x, y)| (x * x + y * y).sqrt()).collect()
    };
    let differences = |across: &[f64]| -> Vec<f64> {
        let (a, b) = (strengths(reference, across), strengths(test, across));
        a.iter().zip(&b).map(|(a, b)| (a - b).abs()).collect()
    };
    let (edges, points) = (differences(&edge), differences(&point));
    let error = |(&e, &p): (&f64, &f64)| (FRAC_1_SQRT_2 * e.max(p)).sqrt().min(1.0);
    edges.iter().zip(&points).map(error).collect()
}

/// The kernel with its positive weights scaled to sum to 1 and its negative ones to -1.
fn balanced(kernel: &[f64]) -> Vec<f64> {
    let positive: f64 = kernel.iter().filter(|w| **w > 0.0).sum();
    let negative: f64 = -kernel.iter().filter(|w| **w < 0.0).sum::<f64>();
    kernel.iter().map(|&w| if w > 0.0 { w / positive } else { w / negative.max(1e-300) }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::PixelRect;

    fn picture(side: u32, at: impl Fn(u32, u32) -> [u8; 3]) -> Developed<u8> {
        let window = PixelRect::new(0, 0, side, side);
        let values = (0..window.area() as usize)
            .flat_map(|i| {
                let (x, y) = window.pixel(i);
                at(x, y)
            })
            .collect();
        Developed { window, values }
    }

    fn mean(a: &Developed<u8>, b: &Developed<u8>) -> f64 {
        flip(a, b, PIXELS_PER_DEGREE).unwrap().mean
    }

    #[test]
    fn colours_survive_the_opponent_space_and_green_has_its_known_lab() {
        let space = ColourSpace::srgb();
        for rgb in [[1.0, 0.0, 0.0], [0.2, 0.7, 0.1], [1.0, 1.0, 1.0]].map(DVec3::from_array) {
            let back = space.rgb_from_opponent(space.opponent(rgb));
            assert!((back - rgb).length() < 1e-13, "{back:?}");
        }
        let [l, a, b] = space.hunt_lab(DVec3::Y);
        let known = [87.73, -86.18 * 0.8773, 83.18 * 0.8773];
        assert!([l, a, b].iter().zip(known).all(|(x, y)| (x - y).abs() < 0.02), "{l} {a} {b}");
    }

    #[test]
    fn a_picture_does_not_differ_from_itself() {
        let noise = picture(32, |x, y| [(x * 37 + y * 91) as u8, (x * y) as u8, (x ^ y) as u8]);
        assert_eq!(mean(&noise, &noise), 0.0);
    }

    // Closed form: no features, HyAB = 100; green-blue HyAB after Hunt is 203.3 (from their L*a*b*
    // 87.73, -86.18, 83.18 and 32.30, 79.19, -107.86), so .95 + .05 (100^.7 - .4 m)/(.6 m) with
    // m = 203.3^.7 = 41.27.
    #[test]
    fn black_and_white_differ_by_the_closed_form() {
        let (black, white) = (picture(24, |_, _| [0; 3]), picture(24, |_, _| [255; 3]));
        assert!((mean(&black, &white) - 0.9674).abs() < 2e-4, "{}", mean(&black, &white));
    }

    #[test]
    fn green_and_blue_differ_most() {
        let (green, blue) = (picture(16, |_, _| [0, 255, 0]), picture(16, |_, _| [0, 0, 255]));
        assert!((mean(&green, &blue) - 1.0).abs() < 1e-9);
    }

    #[test]
    fn the_error_grows_with_the_difference_and_does_not_depend_on_the_order() {
        let reference = picture(16, |x, _| [100 + x as u8, 100, 90]);
        let mut last = 0.0;
        for step in [1, 2, 5, 10, 20, 40, 80] {
            let test = picture(16, |x, _| [100 + x as u8 + step, 100 + step, 90 + step]);
            let error = mean(&reference, &test);
            assert!(error > last && error < 1.0);
            assert_eq!(error, mean(&test, &reference));
            last = error;
        }
    }

    #[test]
    fn a_lone_pixel_is_seen_and_the_far_surroundings_are_not_touched() {
        let reference = picture(64, |_, _| [128; 3]);
        let test = picture(64, |x, y| if (x, y) == (32, 32) { [255; 3] } else { [128; 3] });
        let map = flip(&reference, &test, PIXELS_PER_DEGREE).unwrap();
        assert!(map.errors[32 * 64 + 32] > 0.1);
        assert_eq!(map.errors[0], 0.0);
    }
}
