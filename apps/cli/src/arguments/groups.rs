//! How groups of lights are mixed, as typed.

use super::display::kelvin;
use super::values::{finite, not_negative};
use snowgrain_film::develop::linear_from_srgb;
use snowgrain_optics::colour_temperature::srgb_of;
use std::str::FromStr;

/// A group of lights and its factor.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct GroupFactor {
    pub(crate) name: String,
    /// Linear sRGB.
    pub(crate) factor: [f64; 3],
}

impl FromStr for GroupFactor {
    type Err = String;

    /// `NAME=STRENGTH` or `NAME=STRENGTH,COLOUR`.
    fn from_str(text: &str) -> Result<Self, String> {
        let mend = "write NAME=STRENGTH or NAME=STRENGTH,COLOUR, as sun=0.5 or sky=2,#ffd0a0";
        let (name, value) = text.split_once('=').ok_or(mend)?;
        let (strength, colour) = match value.split_once(',') {
            Some((strength, rest)) => (strength, colour(rest.trim())?),
            None => (value, [1.0; 3]),
        };
        let strength = not_negative(strength.trim()).map_err(|_| mend)?;
        let factor = colour.map(|c| c * strength);
        if name.trim().is_empty() || factor.iter().any(|&x| x > 1e9) {
            return Err(mend.into());
        }
        Ok(Self { name: name.trim().to_owned(), factor })
    }
}

/// Linear sRGB of `r,g,b` (linear), `#rrggbb` (as on a screen) or `3200K` (of luminance 1).
fn colour(text: &str) -> Result<[f64; 3], String> {
    let mend = "write a colour as r,g,b (linear, at least 0), #ffd0a0 or 3200K";
    if let Some(digits) = text.strip_prefix('#') {
        let plain = digits.len() == 6 && digits.bytes().all(|b| b.is_ascii_hexdigit());
        let code = u32::from_str_radix(digits, 16).ok().filter(|_| plain).ok_or(mend)?;
        let [_, bytes @ ..] = code.to_be_bytes();
        return Ok(bytes.map(|byte| linear_from_srgb(f64::from(byte) / 255.0)));
    }
    if text.ends_with(['K', 'k']) {
        return kelvin(text).map(srgb_of);
    }
    let numbers: Result<Vec<f64>, _> = text.split(',').map(|n| finite(n.trim())).collect();
    match numbers.as_deref() {
        Ok(&[r, g, b]) if r >= 0.0 && g >= 0.0 && b >= 0.0 => Ok([r, g, b]),
        _ => Err(mend.into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn factors_are_read_with_their_colours() {
        let of = |text: &str| text.parse::<GroupFactor>().unwrap();
        assert_eq!(of("sun=0.5"), GroupFactor { name: "sun".into(), factor: [0.5; 3] });
        assert_eq!(of("sky=2, 1,0.5,0").factor, [2.0, 1.0, 0.0]);
        assert_eq!(of("sky=2,#ff0000").factor, [2.0, 0.0, 0.0]);
        let [red, green, blue] = of("lamp=1,3200K").factor;
        assert!(red > green && green > blue, "{red} {green} {blue}");
        assert!((0.2126 * red + 0.7152 * green + 0.0722 * blue - 1.0).abs() < 1e-3);
        for bad in [
            "sun",
            "sun=",
            "=1",
            "sun=-1",
            "sun=1,#ff",
            "sun=1,red",
            "sun=1,1,2",
            "sun=1,#+fffff",
            "s=1,9K",
        ] {
            assert!(bad.parse::<GroupFactor>().is_err(), "{bad}");
        }
    }
}
