//! How PNG files show a picture, as typed.

use super::values::{finite, not_negative};
use crate::failure::Failure;
use clap::{Args, ValueEnum};
use snowgrain_film::develop::{Curve, Development, Exposure, Gamut, Glare, WhiteBalance};
use snowgrain_optics::colour_temperature::KELVIN;

/// How PNG files show a picture.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Display (.png files)")]
pub(crate) struct DisplayArguments {
    /// Brightness in stops (+1 doubles it), or auto: the median of sunlit snow becomes 212 of 255
    #[arg(long, value_name = "STOPS|auto", default_value = "0", allow_negative_numbers = true,
          value_parser = exposure)]
    pub(crate) exposure: Exposure,

    /// Tone curve: plain (as it is), filmic (the fit of ACES by Hill: contrast, long shoulder) or agx
    /// (softer; bright colours turn pale)
    #[arg(long, value_name = "NAME", default_value = "plain")]
    pub(crate) curve: CurveName,

    /// Where highlights of the plain curve begin to roll off instead of being cut off, 0 to below 1 of white
    #[arg(long, value_name = "SHOULDER", value_parser = shoulder)]
    pub(crate) roll_off: Option<f64>,

    /// What is white: none (light of 6504 K), sunlit or auto (the sunlit snow), or a temperature, as 3200K
    #[arg(long, value_name = "WHITE", default_value = "none", value_parser = white_balance)]
    pub(crate) white_balance: WhiteBalance,

    /// Colours that a screen cannot show: clip (each channel is cut off) or compress (drawn in at constant hue
    /// and lightness)
    #[arg(long, value_name = "HOW", default_value = "clip")]
    pub(crate) gamut: GamutName,

    /// Light spreads before the curve: none, eye (what is over white, as in the eye) or lens (all, as in a
    /// lens), with a factor if wanted, as eye,0.5
    #[arg(long, value_name = "MODEL[,STRENGTH]", default_value = "none", value_parser = glare)]
    pub(crate) glare: Glare,

    /// Bits per channel: 8 or 16
    #[arg(long, value_name = "N", default_value = "8")]
    pub(crate) bits: Bits,
}

/// Names of tone curves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum CurveName {
    Plain,
    Filmic,
    Agx,
}

/// Names of what becomes of colours out of gamut.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum GamutName {
    Clip,
    Compress,
}

/// Bits per channel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Bits {
    #[value(name = "8")]
    Eight,
    #[value(name = "16")]
    Sixteen,
}

impl DisplayArguments {
    /// The development that is asked for.
    pub(crate) fn development(&self) -> Result<Development, Failure> {
        let curve = match (self.curve, self.roll_off) {
            (CurveName::Plain, None) => Curve::Plain,
            (CurveName::Plain, Some(shoulder)) => Curve::RollOff { shoulder },
            (CurveName::Filmic, None) => Curve::Filmic,
            (CurveName::Agx, None) => Curve::AgX,
            (CurveName::Filmic | CurveName::Agx, Some(_)) => {
                let message =
                    "--roll-off is for --curve plain; the others have a shoulder of their own";
                return Err(Failure::usage(message));
            }
        };
        Ok(Development {
            exposure: self.exposure,
            white_balance: self.white_balance,
            glare: self.glare,
            curve,
            gamut: match self.gamut {
                GamutName::Clip => Gamut::Clip,
                GamutName::Compress => Gamut::Compress,
            },
        })
    }
}

fn exposure(text: &str) -> Result<Exposure, String> {
    match text {
        "auto" => Ok(Exposure::Auto),
        text => match finite(text) {
            Ok(stops) if stops.abs() <= 200.0 => Ok(Exposure::Stops(stops)),
            _ => Err("write stops from -200 to 200, as -1.5, or auto".into()),
        },
    }
}

fn shoulder(text: &str) -> Result<f64, String> {
    match finite(text)? {
        x if (0.0..1.0).contains(&x) => Ok(x),
        _ => Err("write 0 to below 1; 0.8 is usual".into()),
    }
}

/// A temperature with its unit.
pub(super) fn kelvin(text: &str) -> Result<f64, String> {
    let [least, greatest] = KELVIN;
    let kelvin = text.strip_suffix(['K', 'k']).and_then(|digits| finite(digits.trim()).ok());
    match kelvin {
        Some(kelvin) if (least..=greatest).contains(&kelvin) => Ok(kelvin),
        _ => Err(format!("write a temperature as 3200K, from {least}K to {greatest}K")),
    }
}

fn white_balance(text: &str) -> Result<WhiteBalance, String> {
    match text {
        "none" => Ok(WhiteBalance::None),
        "sunlit" | "auto" => Ok(WhiteBalance::Sunlit),
        text => kelvin(text)
            .map(WhiteBalance::Kelvin)
            .map_err(|mend| format!("{mend}, or none, sunlit or auto")),
    }
}

fn glare(text: &str) -> Result<Glare, String> {
    let (model, strength) = match text.split_once(',') {
        Some((model, strength)) => (model, not_negative(strength.trim())?),
        None => (text, 1.0),
    };
    match model.trim() {
        "none" => Ok(Glare::None),
        "eye" => Ok(Glare::Eye { strength }),
        "lens" => Ok(Glare::Lens { strength }),
        _ => Err("write none, eye or lens, with a factor if wanted, as eye,0.5".into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_of_the_display_are_read() {
        assert_eq!(exposure("-1.5"), Ok(Exposure::Stops(-1.5)));
        assert_eq!(exposure("auto"), Ok(Exposure::Auto));
        assert_eq!(white_balance("3200K"), Ok(WhiteBalance::Kelvin(3200.0)));
        assert_eq!(white_balance("auto"), Ok(WhiteBalance::Sunlit));
        assert_eq!(glare("eye"), Ok(Glare::Eye { strength: 1.0 }));
        assert_eq!(glare("lens,0.25"), Ok(Glare::Lens { strength: 0.25 }));
        assert_eq!(shoulder("0.8"), Ok(0.8));
        for bad in ["", "1e9", "nan", "much"] {
            assert!(exposure(bad).is_err(), "{bad}");
        }
        for bad in ["3200", "K", "100K", "warm", "nanK"] {
            assert!(white_balance(bad).is_err(), "{bad}");
        }
        for bad in ["star", "eye,-1", "lens,x"] {
            assert!(glare(bad).is_err(), "{bad}");
        }
        assert!(shoulder("1").is_err() && shoulder("-0.1").is_err());
    }
}
