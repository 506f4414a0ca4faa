//! Shade under a clear sky.

use super::field::{self, Field, PIXEL};
use super::stage::Stage;
use super::{lab, light};
use crate::report::{Comparison, Section};
use anyhow::Result;
use snowgrain_film::Picture;
use snowgrain_film::develop::{Curve, Development, Exposure, WhiteBalance, to_8_bit};
use snowgrain_math::{DVec3, trig};

/// Zenith angles of the sun, degrees, and by how many stops shade is darker than sunlit ground.
const STOPS: [(f64, f64); 4] = [(30.0, 2.7), (48.2, 2.5), (60.0, 2.3), (75.0, 1.7)];
const STOPS_TOLERANCE: f64 = 0.1;
/// Colour of the sky, and of sun and sky, at the zenith angle of 48.2 degrees.
const SKY: [f64; 2] = [0.255, 0.265];
const SUN_AND_SKY: [f64; 2] = [0.320, 0.332];
const CHROMATICITY_TOLERANCE: f64 = 0.003;
/// b* of shade on snow once the sunlit snow is white: below this, and how far below it may be.
const LEAST_BLUE: f64 = -10.0;
const MOST_BLUE: f64 = -60.0;
/// Most pixels of shade with a channel of 0 or 255.
const CUT_OFF: f64 = 0.005;
/// Distance of shade that is measured from the edge, transport lengths.
const FROM_EDGE: f64 = 4.0;
/// Zenith angle of the sun in the picture of a shadow, degrees.
const ZENITH: f64 = 48.2;

pub(super) fn section(stage: &Stage) -> Result<Section> {
    let mut section = Section::new("Shade under a clear sky");
    section.say(format!(
        "A Lambertian block under sun and clear sky, whose layers of light give how dark its shade is before light bleeds \
         into it, and the colours of sky and sun. Then a shadow on snow, at the zenith angle of {ZENITH} degrees: a board \
         a metre away hides the sun, and what lies {FROM_EDGE} transport lengths and more within its shadow is measured, \
         shown with the sunlit snow as white. {}",
        field::told()
    ));
    ground(stage, &mut section)?;
    shadow(stage, &mut section)?;
    Ok(section)
}

fn sun_and_sky(zenith: f64) -> String {
    format!("[[light]]\nkind = \"sun-sky\"\nelevation = {:.1}\nazimuth = 90\n\n", 90.0 - zenith)
}

/// How much darker shade is, and the colours of the light.
fn ground(stage: &Stage, section: &mut Section) -> Result<()> {
    let mut stops =
        Comparison::new("stops of shade under sunlit ground", format!("{STOPS_TOLERANCE}"));
    let mut colours =
        Comparison::new("x, y of sky and of both", format!("{CHROMATICITY_TOLERANCE}"));
    let mut rows = Vec::new();
    let scene = format!(
        "# Diffuse ground under a clear sky.\n{}{}{}",
        field::from_above(8, 8),
        sun_and_sky(ZENITH),
        Field::Lambertian.tables(stage)?
    );
    for (zenith, expected) in STOPS {
        let (samples, elevation) = (stage.choose(1024, 256), 90.0 - zenith);
        let options = format!("--spp {samples} --set light.elevation={elevation:.1}");
        let picture = stage.render(section, ("ground", &scene), &options)?;
        let both = light::mean(&light::of_all(&picture)?);
        let sky = both - light::mean(&light::of_sun(&picture)?);
        let darker =
            trig::ln(light::luminance(both) / light::luminance(sky)) * core::f64::consts::LOG2_E;
        stops.compare(&format!("sun at {zenith}"), darker, expected, STOPS_TOLERANCE);
        let found = [sky, both].map(light::chromaticity);
        if zenith == ZENITH {
            for (name, found, expected) in [("sky", found[0], SKY), ("both", found[1], SUN_AND_SKY)]
            {
                for (axis, name) in
                    [format!("x of {name}"), format!("y of {name}")].iter().enumerate()
                {
                    colours.compare(name, found[axis], expected[axis], CHROMATICITY_TOLERANCE);
                }
            }
        }
        let xy = |[x, y]: [f64; 2]| format!("{x:.3}, {y:.3}");
        rows.push(vec![
            format!("{zenith}"),
            format!("{darker:.2}"),
            format!("{expected}"),
            xy(found[0]),
            xy(found[1]),
        ]);
    }
    section.add(stops);
    section.add(colours);
    section.table(&["sun zenith", "stops", "expected", "sky x, y", "sun and sky x, y"], &rows);
    Ok(())
}

/// A shadow on snow and on a Lambertian block, as it is shown.
fn shadow(stage: &Stage, section: &mut Section) -> Result<()> {
    let mut rows = Vec::new();
    for (field, name) in [(Field::Grains, "shadow"), (Field::Lambertian, "shadow-lambert")] {
        let scene = format!(
            "# A shadow under a clear sky.\n{}{}{}{}",
            field::from_above(64, 12),
            sun_and_sky(ZENITH),
            board(),
            field.tables(stage)?
        );
        let options = format!("--spp {}", stage.choose(128, 64));
        let picture = stage.render(section, (name, &scene), &options)?;
        let shade = Shade::of(&picture)?;
        let what = if field == Field::Grains { "snow" } else { "Lambertian block" };
        rows.push(vec![
            what.to_owned(),
            format!("{:.2}", shade.stops),
            format!("{:.1}, {:.1}, {:.1}", shade.lab[0], shade.lab[1], shade.lab[2]),
            format!("{:.1} %", 100.0 * shade.cut_off),
        ]);
        if field == Field::Grains {
            let mut comparison = Comparison::new("shade on snow", "as named");
            comparison.within("b*", shade.lab[2], [MOST_BLUE, LEAST_BLUE]);
            comparison.within(
                "part that is black or cut off in a channel",
                shade.cut_off,
                [0.0, CUT_OFF],
            );
            section.add(comparison);
        }
    }
    section.table(
        &["surface", "stops under sunlit", "L*, a*, b* of shade", "black or cut off"],
        &rows,
    );
    Ok(())
}

/// A board that hides the sun from the right half of the field, a metre away.
fn board() -> String {
    let (sin, cos) = trig::sin_cos(ZENITH.to_radians());
    let half_height = 0.15;
    // From its lower edge, which casts the edge of the shadow, along the light.
    let (x, y) = (Field::MIDDLE + sin, Field::TOP + cos + half_height);
    format!(
        "[[object]]\nname = \"board\"\nshape = \"box\"\nalbedo = 0\nscale = [0.001, {half_height}, 0.3]\n\
         translate = [{x}, {y}, {}]\n\n",
        Field::MIDDLE
    )
}

/// What shade looks like.
struct Shade {
    /// Under the sunlit half.
    stops: f64,
    /// L*, a*, b* of its mean colour.
    lab: [f64; 3],
    /// The part of its pixels with a channel of 0 or 255.
    cut_off: f64,
}

impl Shade {
    fn of(picture: &Picture) -> Result<Self> {
        let width = picture.window().width() as usize;
        let from_edge = (FROM_EDGE / PIXEL) as usize;
        let colours = light::of_all(picture)?;
        let columns = |range: std::ops::Range<usize>| {
            (0..colours.len()).filter(move |pixel| range.contains(&(pixel % width)))
        };
        // The board rises from the edge, so its shadow falls to the left of it.
        let (shaded, lit) =
            (columns(0..width / 2 - from_edge), columns(width / 2 + from_edge..width));
        let level = |pixels: &mut dyn Iterator<Item = usize>| {
            light::luminance(light::mean(&pixels.map(|pixel| colours[pixel]).collect::<Vec<_>>()))
        };
        let stops = trig::ln(level(&mut lit.clone()) / level(&mut shaded.clone()))
            * core::f64::consts::LOG2_E;
        let how = Development {
            exposure: Exposure::Auto,
            white_balance: WhiteBalance::Sunlit,
            curve: Curve::RollOff { shoulder: 0.7 },
            ..Development::default()
        };
        let shown = to_8_bit(picture, &how)?;
        let (mut sum, mut count, mut cut_off) = (DVec3::ZERO, 0.0, 0.0);
        for pixel in shaded {
            let codes = [0, 1, 2].map(|channel| shown.values[3 * pixel + channel]);
            sum += DVec3::from(lab::of_codes(codes));
            count += 1.0;
            cut_off += f64::from(u8::from(codes.iter().any(|&code| code == 0 || code == 255)));
        }
        Ok(Self { stops, lab: (sum / count).to_array(), cut_off: cut_off / count })
    }
}
