//! How far light bleeds in deep white snow.

use super::field::{self, Field, PIXEL, TRANSPORT_LENGTH};
use super::patch::{Patch, edge_width};
use super::stage::Stage;
use crate::report::{Comparison, Section};
use crate::table::Table;
use anyhow::{Context as _, Result};

/// Width of a shadow's edge from 25 to 75 %, and radii within which half and 90 % of the light leaves, in
/// transport lengths.
const EDGE: f64 = 2.1;
const RADII: [(&str, f64); 2] = [("R_median_radius_m", 2.0), ("R_radius_90_m", 11.8)];
const TOLERANCE: f64 = 0.15;
/// Levels of an edge.
const LEVELS: [f64; 2] = [0.25, 0.75];
/// Most that the edge on a Lambertian surface may be wide, transport lengths: its penumbra and a pixel.
const SHARP: f64 = 0.3;

pub(super) fn section(stage: &Stage) -> Result<Section> {
    let mut section = Section::new("Bleeding of light");
    section.say(format!(
        "How far light spreads in deep white snow before it leaves, by the laboratory (grains met at random that take \
         room), and in pictures: the sun from the zenith on a field, one half of which lies under a black roof; the light \
         of each column of pixels is divided by that without the roof. What is expected is for diffuse light; a beam from \
         the zenith enters deeper, so the picture is compared with the laboratory's edge for such a beam. {}",
        field::told()
    ));
    let beam = laboratory(stage, &mut section)?;
    pictures(stage, &mut section, beam)?;
    Ok(section)
}

/// The width of an edge by a beam from the zenith, transport lengths.
fn laboratory(stage: &Stage, section: &mut Section) -> Result<f64> {
    let command = format!(
        "optics spread --radius 500um --density 275 --diffuse --sza 0 --wavelengths 400 --ice-k warren-brandt-2008 \
         --stderr {} --max-paths 300000",
        stage.choose(0.01, 0.02)
    );
    let found = stage.table(section, &command)?;
    let mut comparison = Comparison::new("spread by the laboratory, over that expected", "15 %");
    for (quantity, expected) in RADII {
        let lengths =
            found.find(&[("quantity", quantity), ("sza_deg", "diffuse")])?.number("value")?
                / TRANSPORT_LENGTH;
        let name = format!("{quantity}: {lengths:.2} l*");
        comparison.compare(&name, lengths / expected, 1.0, TOLERANCE);
    }
    let lengths = laboratory_edge(&found, "diffuse")?;
    let name = format!("width of an edge: {lengths:.2} l*");
    comparison.compare(&name, lengths / EDGE, 1.0, TOLERANCE);
    section.add(comparison);
    laboratory_edge(&found, "0")
}

/// The width of an edge from 25 to 75 %, transport lengths: on either side of it twice the distance within which half of
/// the light of a line stays.
fn laboratory_edge(found: &Table, light: &str) -> Result<f64> {
    let (mut sums, mut sum) = (vec![(0.0, 0.0)], 0.0);
    let of_line = [("quantity", "R_per_width"), ("sza_deg", light)];
    for row in found.rows().filter(|row| row.has(&of_line)) {
        let (from, to) = (row.number("from")?, row.number("to")?);
        sum += row.number("value")? * (to - from);
        sums.push((to, sum));
    }
    let half = 0.5 * sum;
    let at = sums.windows(2).position(|pair| pair[1].1 >= half).context("no light of a line")?;
    let ((from, below), (to, above)) = (sums[at], sums[at + 1]);
    let distance = from + (to - from) * (half - below) / (above - below);
    Ok(2.0 * distance / TRANSPORT_LENGTH)
}

fn pictures(stage: &Stage, section: &mut Section, expected: f64) -> Result<()> {
    let what = format!("edge of a shadow on grains, over the laboratory's {expected:.2} l*");
    let mut comparison = Comparison::new(what, "15 %");
    let lengths = edge(stage, section, Field::Grains)?;
    let name = format!("{lengths:.2} l*");
    comparison.compare(&name, lengths / expected, 1.0, TOLERANCE);
    section.add(comparison);
    let what = "edge of a shadow on a Lambertian block, l*";
    let mut comparison = Comparison::new(what, format!("{SHARP}"));
    comparison.compare("width", edge(stage, section, Field::Lambertian)?, 0.0, SHARP);
    section.add(comparison);
    Ok(())
}

/// The width of the edge of a shadow, transport lengths.
fn edge(stage: &Stage, section: &mut Section, field: Field) -> Result<f64> {
    let name = match field {
        Field::Grains => "edge",
        Field::Lambertian => "edge-lambert",
    };
    let light = "[[light]]\nkind = \"sun\"\nelevation = 90\n\n";
    let (x, y) = (Field::MIDDLE + 0.5, Field::TOP + 0.04);
    let roof = format!(
        "[[object]]\nname = \"roof\"\nshape = \"box\"\nalbedo = 0\nscale = [0.5, 0.001, 0.5]\n\
         translate = [{x}, {y}, {}]\n\n",
        Field::MIDDLE
    );
    let (head, tables) = (field::from_above(64, 24), field.tables(stage)?);
    let options = format!("--spp {}", stage.choose(128, 64));
    let mut columns = Vec::new();
    for (suffix, roof) in [("-open", ""), ("-roof", roof.as_str())] {
        let scene = format!("# The edge of a shadow.\n{head}{light}{roof}{tables}");
        let name = format!("{name}{suffix}");
        let picture = stage.render(section, (&name, &scene), &options)?;
        columns.push(Patch::of(&picture)?.columns());
    }
    let parts: Vec<f64> =
        columns[1].iter().zip(&columns[0]).map(|(roof, open)| roof / open).collect();
    Ok(edge_width(&parts, LEVELS).context("the shadow has no edge")? * PIXEL)
}
