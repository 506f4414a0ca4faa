//! Sunlit snow on a screen.

use super::stage::{RADIUS, Stage};
use super::{lab, light};
use crate::report::{Comparison, Section};
use anyhow::Result;
use snowgrain_film::develop::{Curve, Development, Exposure, WhiteBalance, to_8_bit};
use snowgrain_film::{GLINTS, Picture};

/// Codes of the median of the sunlit body.
const MEDIAN: [f64; 2] = [205.0, 235.0];
/// Most pixels that are cut off, glints apart.
const CUT_OFF: f64 = 0.005;
const CUT_OFF_CODE: u8 = 254;
/// Least codes between 5 and 95 % of the body.
const RANGE: f64 = 30.0;
/// Most of a* and b* of the mean of the body.
const NEUTRAL: f64 = 3.0;
/// The curves, and that which keeps the contrast of snow (docs/develop.md).
const CURVES: [(Curve, &str); 4] = [
    (Curve::RollOff { shoulder: 0.7 }, JUDGED),
    (Curve::Plain, "--curve plain"),
    (Curve::Filmic, "--curve filmic"),
    (Curve::AgX, "--curve agx"),
];
const JUDGED: &str = "--roll-off 0.7";
/// The part of a pixel's light from which it is a glint.
const GLINT: f64 = 0.5;

pub(super) fn section(stage: &Stage) -> Result<Section> {
    let mut section = Section::new("Sunlit snow on a screen");
    section.say(
        "Snow on round stones under sun and clear sky, the sun 30 degrees high, developed with `--exposure auto \
         --white-balance sunlit` and each curve. The body are pixels within a stop of the 95th percentile of luminance \
         (docs/develop.md); codes are those of green. A pixel is a glint where the layer of glints has half of its light. \
         Wanted: a median of 205 to 235, less than .5 % of other pixels at 254 and more, 30 codes from 5 to 95 %, |a*| and \
         |b*| below 3. `--roll-off 0.7` is judged, the other curves are told: `plain` cuts off, and white lies in the \
         shoulders of the others, which take contrast. \
         The Lambertian twin is the bare stones, white: its range is that of their roundness.",
    );
    let mut rows = Vec::new();
    for (name, what, tables) in
        [("sunlit", "snow", snow()), ("sunlit-lambert", "Lambertian", String::new())]
    {
        let scene = scene(&tables);
        let (size, samples) = stage.choose(("128x96", 128), ("96x72", 96));
        let options = format!("--size {size} --spp {samples}");
        let picture = stage.render(&mut section, (name, &scene), &options)?;
        for (curve, option) in CURVES {
            let shown = Shown::of(&picture, curve)?;
            rows.push(shown.row(&format!("{what}, `{option}`")));
            if !tables.is_empty() && option == JUDGED {
                section.add(shown.compare(option));
            }
        }
    }
    let heads = ["surface, curve", "median", "5 to 95 %", "cut off", "a*, b*", "glints"];
    section.table(&heads, &rows);
    Ok(section)
}

fn snow() -> String {
    format!(
        "[[snow]]\nsource = \"deposit\"\nrule = \"ray\"\nradius = {RADIUS}\nvariation = {}\ndepth = \"12 mm\"\n\
         area = [-0.12, -0.14, 0.12, 0.11]\n",
        0.3 * RADIUS
    )
}

fn scene(tables: &str) -> String {
    format!(
        "# Snow on stones in the sun.\nversion = 1\n\n[camera]\nfrom = [0.06, 0.28, 0.30]\nat = [0, 0.01, 0]\n\
         vertical_fov = 20\n\n[[light]]\nkind = \"sun-sky\"\nelevation = 30\nazimuth = 300\n\n[[object]]\n\
         shape = \"plane\"\nalbedo = 0.9\n\n[[object]]\nshape = \"sphere\"\nalbedo = 0.9\nscale = [0.03, 0.014, 0.025]\n\
         translate = [-0.03, 0, -0.02]\ninstances = [{{}}, {{ translate = [0.06, 0, 0.02] }}, \
         {{ translate = [0.01, 0, 0.05] }}, {{ translate = [0.06, 0, -0.06] }}]\n\n{tables}"
    )
}

/// The body of sunlit snow on a screen.
struct Shown {
    median: f64,
    range: [f64; 2],
    cut_off: f64,
    neutral: [f64; 2],
    glints: f64,
}

impl Shown {
    fn of(picture: &Picture, curve: Curve) -> Result<Self> {
        let how = Development {
            exposure: Exposure::Auto,
            white_balance: WhiteBalance::Sunlit,
            curve,
            ..Development::default()
        };
        let shown = to_8_bit(picture, &how)?.values;
        let codes = |pixel: usize| [0, 1, 2].map(|channel| shown[3 * pixel + channel]);
        let levels: Vec<f64> = light::of_all(picture)?.into_iter().map(light::luminance).collect();
        let level = light::quantile(&levels, 0.95);
        let body = |pixel: &usize| (0.5 * level..=2.0 * level).contains(&levels[*pixel]);
        let body: Vec<usize> = (0..levels.len()).filter(body).collect();
        let greens: Vec<f64> = body.iter().map(|&pixel| f64::from(codes(pixel)[1])).collect();
        let labs: Vec<_> = body.iter().map(|&pixel| lab::of_codes(codes(pixel))).collect();
        let mean = |axis: usize| labs.iter().map(|lab| lab[axis]).sum::<f64>() / labs.len() as f64;
        let glints = light::of_group(picture, GLINTS);
        let is_glint = |pixel: &usize| {
            glints
                .as_ref()
                .is_some_and(|glints| light::luminance(glints[*pixel]) > GLINT * levels[*pixel])
        };
        let plain: Vec<usize> = (0..levels.len()).filter(|pixel| !is_glint(pixel)).collect();
        let cut_off = |pixel: &&usize| codes(**pixel).iter().any(|&code| code >= CUT_OFF_CODE);
        Ok(Self {
            median: light::quantile(&greens, 0.5),
            range: [0.05, 0.95].map(|part| light::quantile(&greens, part)),
            cut_off: plain.iter().filter(cut_off).count() as f64 / plain.len() as f64,
            neutral: [mean(1), mean(2)],
            glints: 1.0 - plain.len() as f64 / levels.len() as f64,
        })
    }

    fn row(&self, what: &str) -> Vec<String> {
        let [low, high] = self.range;
        vec![
            what.to_owned(),
            format!("{:.0}", self.median),
            format!("{low:.0} to {high:.0}"),
            format!("{:.2} %", 100.0 * self.cut_off),
            format!("{:.1}, {:.1}", self.neutral[0], self.neutral[1]),
            format!("{:.2} %", 100.0 * self.glints),
        ]
    }

    fn compare(&self, curve: &str) -> Comparison {
        let mut comparison = Comparison::new(format!("sunlit snow, {curve}"), "as named");
        comparison.within("median code of the body", self.median, MEDIAN);
        comparison.within(
            "part of pixels at 254 and more, but glints",
            self.cut_off,
            [0.0, CUT_OFF],
        );
        comparison.within("codes from 5 to 95 %", self.range[1] - self.range[0], [RANGE, 255.0]);
        for (axis, value) in ["a* of the body", "b* of the body"].iter().zip(self.neutral) {
            comparison.within(axis, value, [-NEUTRAL, NEUTRAL]);
        }
        comparison
    }
}
