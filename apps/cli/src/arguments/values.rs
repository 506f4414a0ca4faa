//! Values on the command line that have a form of their own.

use snowgrain_film::PixelRect;
use snowgrain_formats::scene::document::{ShapeName, SnowKindName};
use snowgrain_formats::scene::{Length, MeshUnits, UpAxis};
use snowgrain_grains::{DepositRule, LatticeKind};
use snowgrain_render::View;
use snowgrain_render::measure::Incidence;
use std::ops::{Range, RangeInclusive};
use std::path::PathBuf;
use std::str::FromStr;
use std::time::Duration;

/// Pixels across and down.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Size {
    pub(crate) width: u32,
    pub(crate) height: u32,
}

/// Most pixels along an edge.
const LARGEST_EDGE: u32 = 65_536;

impl FromStr for Size {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let edge = |text: &str| {
            text.parse().ok().filter(|edge| (1..=LARGEST_EDGE).contains(edge)).ok_or_else(|| {
                format!("write WIDTHxHEIGHT, as 1024x768, each 1 to {LARGEST_EDGE} pixels")
            })
        };
        let (width, height) = text.split_once(['x', 'X']).unwrap_or((text, ""));
        Ok(Self { width: edge(width)?, height: edge(height)? })
    }
}

/// A picture to be written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct PictureFile {
    pub(crate) path: PathBuf,
    pub(crate) format: PictureFormat,
}

/// Formats of pictures, by the extension of the file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum PictureFormat {
    Png,
    Exr,
    Film,
}

impl FromStr for PictureFile {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let path = PathBuf::from(text);
        let extension = path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase());
        let format = match extension.as_deref() {
            Some("png") => PictureFormat::Png,
            Some("exr") => PictureFormat::Exr,
            Some("film") => PictureFormat::Film,
            _ => return Err("the name must end in .png, .exr or .film".into()),
        };
        Ok(Self { path, format })
    }
}

/// A plot to be written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct PlotFile {
    pub(crate) path: PathBuf,
    pub(crate) format: PlotFormat,
}

/// Formats of plots, by the extension of the file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum PlotFormat {
    Svg,
    Png,
}

impl FromStr for PlotFile {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let path = PathBuf::from(text);
        let extension = path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase());
        let format = match extension.as_deref() {
            Some("svg") => PlotFormat::Svg,
            Some("png") => PlotFormat::Png,
            _ => return Err("the name must end in .svg or .png".into()),
        };
        Ok(Self { path, format })
    }
}

/// Pixels `x0,y0,x1,y1`, half-open.
pub(super) fn crop(text: &str) -> Result<PixelRect, String> {
    let mend = || "write x0,y0,x1,y1 in pixels, with x0 < x1 and y0 < y1".to_owned();
    let numbers: Result<Vec<u32>, _> = text.split(',').map(|n| n.trim().parse()).collect();
    match numbers.as_deref() {
        Ok(&[x0, y0, x1, y1]) if x0 < x1 && y0 < y1 => Ok(PixelRect::new(x0, y0, x1, y1)),
        _ => Err(mend()),
    }
}

/// Samples by their indices: `0..64` without the last, `0-63` with it.
pub(super) fn samples(text: &str) -> Result<Range<u64>, String> {
    /// Indices from here on belong to pilots.
    const LAST: u64 = 1 << 63;
    let number = |text: &str| text.trim().parse::<u64>().ok().filter(|&number| number <= LAST);
    let range = match (text.split_once(".."), text.split_once('-')) {
        (Some((start, end)), _) => number(start).zip(number(end)),
        (None, Some((start, last))) => number(start).zip(number(last).map(|last| last + 1)),
        (None, None) => None,
    };
    range
        .map(|(start, end)| start..end)
        .filter(|range| !range.is_empty() && range.end <= LAST)
        .ok_or_else(|| "write FIRST..END (END not included) or FIRST-LAST, as 0..64 or 0-63".into())
}

/// Frames, `1-48`.
pub(super) fn frames(text: &str) -> Result<RangeInclusive<u32>, String> {
    let number = |text: &str| text.trim().parse::<u32>().ok();
    let frames = text.split_once('-').and_then(|(first, last)| number(first).zip(number(last)));
    frames
        .filter(|(first, last)| first <= last)
        .map(|(first, last)| first..=last)
        .ok_or_else(|| "write FIRST-LAST, as 1-48".into())
}

/// A finite number.
pub(super) fn finite(text: &str) -> Result<f64, String> {
    let number: f64 = text.parse().map_err(|_| "write a number".to_owned())?;
    if number.is_finite() { Ok(number) } else { Err("write a finite number".into()) }
}

/// Bytes: `4GiB`, `500 MB`, `1048576`.
pub(super) fn bytes(text: &str) -> Result<u64, String> {
    const UNITS: [(&str, f64); 9] = [
        ("KiB", 1024.0),
        ("MiB", 1_048_576.0),
        ("GiB", 1_073_741_824.0),
        ("TiB", 1_099_511_627_776.0),
        ("kB", 1e3),
        ("MB", 1e6),
        ("GB", 1e9),
        ("TB", 1e12),
        ("B", 1.0),
    ];
    let with_unit = UNITS.iter().find_map(|(unit, scale)| Some((text.strip_suffix(unit)?, scale)));
    let (number, scale) = with_unit.unwrap_or((text, &1.0));
    match number.trim().parse::<f64>() {
        Ok(number) if number * scale >= 1.0 && number * scale < 1e18 => Ok((number * scale) as u64),
        _ => Err("write a size, as 4GiB or 500MB".into()),
    }
}

/// A name or address of a machine and a port on it: `localhost:14158`, `[::1]:14158`.
pub(super) fn host_and_port(text: &str) -> Result<String, String> {
    let known = text.rsplit_once(':').filter(|(host, port)| {
        let bare_version_6 = host.contains(':') && !(host.starts_with('[') && host.ends_with(']'));
        !host.is_empty() && !bare_version_6 && port.parse().is_ok_and(|port: u16| port > 0)
    });
    known.map(|_| text.to_owned()).ok_or_else(|| {
        "write HOST:PORT, as localhost:14158, with a port from 1 to 65535".to_owned()
    })
}

/// A time: `90s`, `10m` or `10min`, `1.5h`, `500ms`.
pub(super) fn duration(text: &str) -> Result<Duration, String> {
    const UNITS: [(&str, f64); 5] =
        [("ms", 1e-3), ("min", 60.0), ("h", 3600.0), ("m", 60.0), ("s", 1.0)];
    let with_unit = UNITS.iter().find_map(|(unit, scale)| Some((text.strip_suffix(unit)?, scale)));
    match with_unit.map(|(number, scale)| (number.trim().parse::<f64>(), scale)) {
        Some((Ok(number), scale)) if number * scale > 0.0 && number * scale < 1e9 => {
            Ok(Duration::from_secs_f64(number * scale))
        }
        _ => Err("write a time above 0 with its unit, as 90s, 10m or 1.5h".into()),
    }
}

/// A length above 0 in metres: `20cm`, `0.2`.
pub(super) fn length(text: &str) -> Result<f64, String> {
    let metres = match text.trim().parse::<f64>() {
        Ok(metres) => metres,
        Err(_) => Length::parse(text)?.metres,
    };
    if metres > 0.0 && metres.is_finite() {
        Ok(metres)
    } else {
        Err("write a length above 0, as 20cm".into())
    }
}

/// A kind of snow.
pub(super) fn kind(name: &str) -> Result<SnowKindName, String> {
    SnowKindName::from_name(name).ok_or_else(|| {
        let names = SnowKindName::ALL.map(SnowKindName::name);
        format!("write one of {}", names.join(", "))
    })
}

/// A shape of grains that needs no file.
pub(super) fn shape(name: &str) -> Result<ShapeName, String> {
    let mut shapes = ShapeName::OF_NUMBERS.into_iter();
    shapes.find(|shape| shape.name() == name).ok_or_else(|| {
        let names = ShapeName::OF_NUMBERS.map(ShapeName::name);
        format!("write one of {}", names.join(", "))
    })
}

/// A unit of length of mesh files.
pub(super) fn units(name: &str) -> Result<MeshUnits, String> {
    MeshUnits::from_name(name).ok_or_else(|| "write mm, cm, m or in".into())
}

/// A quick look.
pub(super) fn view(name: &str) -> Result<View, String> {
    View::ALL
        .into_iter()
        .find(|view| view.name() == name)
        .ok_or_else(|| format!("write {}", View::ALL.map(View::name).join(", ")))
}

/// An up axis of mesh files.
pub(super) fn up_axis(name: &str) -> Result<UpAxis, String> {
    UpAxis::from_name(name).ok_or_else(|| "write y or z".into())
}

/// A grain file to be written.
pub(super) fn grain_file(text: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    match path.extension() {
        Some(extension) if extension.eq_ignore_ascii_case("ply") => Ok(path),
        _ => Err("the name must end in .ply".into()),
    }
}

/// A finite number, at least 0.
pub(super) fn not_negative(text: &str) -> Result<f64, String> {
    finite(text).and_then(|n| if n >= 0.0 { Ok(n) } else { Err("write a number from 0 up".into()) })
}

/// A finite number above 0.
pub(super) fn positive(text: &str) -> Result<f64, String> {
    finite(text).and_then(|n| if n > 0.0 { Ok(n) } else { Err("write a number above 0".into()) })
}

/// A number between 0 and 1.
pub(super) fn probability(text: &str) -> Result<f64, String> {
    match finite(text)? {
        p if (0.0..=1.0).contains(&p) => Ok(p),
        _ => Err("write a probability, 0 to 1".into()),
    }
}

/// Pixels a degree that FLIP can look at.
pub(super) fn pixels_per_degree(text: &str) -> Result<f64, String> {
    match finite(text)? {
        n if (1.0..=1000.0).contains(&n) => Ok(n),
        _ => Err("write 1 to 1000; 67 is usual".into()),
    }
}

/// An index of refraction.
pub(super) fn ior(text: &str) -> Result<f64, String> {
    match finite(text)? {
        n if (1.0..=4.0).contains(&n) => Ok(n),
        _ => Err("write 1 to 4; ice has 1.31".into()),
    }
}

/// A crystal lattice.
pub(super) fn lattice(name: &str) -> Result<LatticeKind, String> {
    Ok(match name {
        "sc" => LatticeKind::Sc,
        "bcc" => LatticeKind::Bcc,
        "fcc" => LatticeKind::Fcc,
        "hcp" => LatticeKind::Hcp,
        _ => return Err("write sc, bcc, fcc or hcp".into()),
    })
}

/// A rule by which falling grains stop.
pub(super) fn rule(name: &str) -> Result<DepositRule, String> {
    Ok(match name {
        "ray" | "chrisman" => DepositRule::Ray,
        "stick" => DepositRule::Stick,
        "roll" => DepositRule::Roll,
        _ => return Err("write ray, stick or roll".into()),
    })
}

/// Two lengths.
pub(super) fn period(text: &str) -> Result<[f64; 2], String> {
    let (x, z) = text.split_once(',').ok_or("write two lengths, as 60mm,60mm")?;
    Ok([length(x)?, length(z)?])
}

/// Three whole numbers, each at least 1.
pub(super) fn counts(text: &str) -> Result<[u32; 3], String> {
    let numbers: Result<Vec<u32>, _> = text.split(',').map(|n| n.trim().parse()).collect();
    match numbers.as_deref() {
        Ok(&[x, y, z]) if x > 0 && y > 0 && z > 0 => Ok([x, y, z]),
        _ => Err("write three whole numbers from 1 up, as 32,32,32".into()),
    }
}

/// `lambertian`, or an angle from the normal in degrees.
pub(super) fn incidence(text: &str) -> Result<Incidence, String> {
    if text == "lambertian" {
        return Ok(Incidence::Lambertian);
    }
    match text.parse() {
        Ok(zenith_degrees) if (0.0..90.0).contains(&zenith_degrees) => {
            Ok(Incidence::Collimated { zenith_degrees })
        }
        _ => Err("write lambertian, or degrees from the normal, 0 to below 90".into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_crops_and_files_are_read() {
        assert_eq!("640x480".parse(), Ok(Size { width: 640, height: 480 }));
        for bad in ["640", "0x4", "4x", "-1x4", "4x65537", "4x4x4"] {
            assert!(bad.parse::<Size>().is_err(), "{bad}");
        }
        assert_eq!(crop("1,2,3,4"), Ok(PixelRect::new(1, 2, 3, 4)));
        for bad in ["1,2,3", "3,2,1,4", "1,2,3,4,5", "a,2,3,4", "1,2,1,4"] {
            assert!(crop(bad).is_err(), "{bad}");
        }
        assert_eq!((samples("0..64"), samples("16-31")), (Ok(0..64), Ok(16..32)));
        for bad in ["64", "4..4", "5..4", "-3", "1..2..3", "0..99999999999999999999", "5-4", "a..b"]
        {
            assert!(samples(bad).is_err(), "{bad}");
        }
        let file: PictureFile = "a.b/c.EXR".parse().unwrap();
        assert_eq!(file.format, PictureFormat::Exr);
        assert!("a.jpg".parse::<PictureFile>().is_err() && "png".parse::<PictureFile>().is_err());
    }

    #[test]
    fn amounts_are_read_with_their_units() {
        assert_eq!(bytes("4GiB"), Ok(4 << 30));
        assert_eq!(bytes("1.5 kB"), Ok(1500));
        assert_eq!(bytes("77"), Ok(77));
        for bad in ["", "GiB", "-1GB", "nan", "0", "1e30GiB", "4 gigs"] {
            assert!(bytes(bad).is_err(), "{bad}");
        }
        assert_eq!(duration("90s"), Ok(Duration::from_secs(90)));
        assert_eq!(duration("1.5h"), Ok(Duration::from_secs(5400)));
        assert_eq!(duration("2min"), Ok(Duration::from_secs(120)));
        assert_eq!(duration("10m"), Ok(Duration::from_secs(600)));
        assert_eq!(duration("250 ms"), Ok(Duration::from_millis(250)));
        for bad in ["90", "s", "0s", "-1s", "infs", "nan s", "1e99h"] {
            assert!(duration(bad).is_err(), "{bad}");
        }
        assert_eq!(host_and_port("localhost:14158"), Ok("localhost:14158".into()));
        assert!(host_and_port("[::1]:1").is_ok());
        for bad in ["localhost", ":14158", "a:0", "a:65536", "a:b", "::1:5", ""] {
            assert!(host_and_port(bad).is_err(), "{bad}");
        }
        assert_eq!(length("20cm"), Ok(0.2));
        assert_eq!(length("0.2"), Ok(0.2));
        assert!(length("0").is_err() && length("-3 mm").is_err() && length("inf").is_err());
    }
}
