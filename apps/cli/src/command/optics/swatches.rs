//! Colours as a picture.

use snowgrain_math::{DVec3, trig};
use snowgrain_optics::Primaries;

/// Edge of a patch, and width of the words beside it, pixels.
const PATCH: u32 = 64;
const WORDS: u32 = 420;

/// The two colours of a case: seen from above, and from below at its full brightness.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Swatch {
    label: String,
    colours: [String; 2],
}

impl Swatch {
    /// `white` are the tristimulus values of all of the light, which the picture shows as white.
    pub(super) fn new(label: &str, white: DVec3, [above, below]: [DVec3; 2]) -> Self {
        let white = Primaries::Srgb.from_xyz(white);
        let above = Primaries::Srgb.from_xyz(above) / white;
        let below = Primaries::Srgb.from_xyz(below) / white;
        let brightest = below.max_element();
        let below = if brightest > 0.0 { below / brightest } else { DVec3::ZERO };
        Self { label: label.into(), colours: [above, below].map(code) }
    }
}

/// The colour as #rrggbb of sRGB (IEC 61966-2-1); what is out of its gamut is cut off at its border.
fn code(linear: DVec3) -> String {
    let byte = |value: f64| {
        let value = value.clamp(0.0, 1.0);
        let encoded = if value <= 0.003_130_8 {
            12.92 * value
        } else {
            1.055 * trig::pow(value, 1.0 / 2.4) - 0.055
        };
        (255.0 * encoded + 0.5) as u8
    };
    format!("#{:02x}{:02x}{:02x}", byte(linear.x), byte(linear.y), byte(linear.z))
}

/// A line for each case: its two colours and its label.
pub(super) fn svg(swatches: &[Swatch]) -> String {
    let (width, height) = (2 * PATCH + WORDS, PATCH * (1 + swatches.len() as u32));
    let mut text = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
         font-family=\"sans-serif\" font-size=\"14\">\n\
         <rect width=\"{width}\" height=\"{height}\" fill=\"#808080\"/>\n\
         <text x=\"8\" y=\"{line}\">above</text><text x=\"{second}\" y=\"{line}\">below</text>\n",
        line = PATCH / 2,
        second = PATCH + 8,
    );
    for (swatch, top) in swatches.iter().zip((1..).map(|row| row * PATCH)) {
        for (colour, left) in swatch.colours.iter().zip([0, PATCH]) {
            text += &format!(
                "<rect x=\"{left}\" y=\"{top}\" width=\"{PATCH}\" height=\"{PATCH}\" \
                 fill=\"{colour}\"/>\n"
            );
        }
        text += &format!(
            "<text x=\"{}\" y=\"{}\">{}</text>\n",
            2 * PATCH + 8,
            top + PATCH / 2,
            swatch.label
        );
    }
    text + "</svg>\n"
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn white_is_white_and_what_comes_through_is_shown_at_its_brightest() {
        let white = Primaries::Srgb.to_xyz() * DVec3::ONE;
        let swatch = Swatch::new("a", white, [white * 0.5, white * 0.001]);
        assert_eq!(swatch.colours, ["#bcbcbc", "#ffffff"]);
        let dark = Swatch::new("b", white, [DVec3::ZERO; 2]);
        assert_eq!(dark.colours, ["#000000", "#000000"]);
        let text = svg(&[swatch, dark]);
        assert!(text.starts_with("<svg") && text.ends_with("</svg>\n"));
        assert_eq!(text.matches("<rect").count(), 5);
    }
}
