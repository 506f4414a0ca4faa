//! Figures with lines of the program and points of others, as SVG.

use anyhow::Result;
use std::fmt::Write as _;
use std::path::Path;

/// Colours that can be told apart without red and green (Okabe and Ito).
const COLOURS: [&str; 6] = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#000000"];
const WIDTH: f64 = 800.0;
const HEIGHT: f64 = 460.0;
/// Edges of the field that the axes span.
const LEFT: f64 = 64.0;
const RIGHT: f64 = 570.0;
const TOP: f64 = 40.0;
const BOTTOM: f64 = 400.0;

/// A figure to draw.
pub(crate) struct Figure<'f> {
    pub(crate) title: &'f str,
    pub(crate) x: Axis<'f>,
    pub(crate) y: Axis<'f>,
    pub(crate) series: Vec<Series>,
    pub(crate) remark: &'f str,
}

/// From, to, and the distance of ticks.
#[derive(Clone, Copy)]
pub(crate) struct Axis<'f> {
    pub(crate) name: &'f str,
    pub(crate) from: f64,
    pub(crate) to: f64,
    pub(crate) step: f64,
}

/// A line, points that it should meet, and their name.
pub(crate) struct Series {
    pub(crate) name: String,
    pub(crate) line: Vec<[f64; 2]>,
    pub(crate) points: Vec<[f64; 2]>,
}

impl Axis<'_> {
    fn at(&self, value: f64, [low, high]: [f64; 2]) -> f64 {
        low + (value - self.from) / (self.to - self.from) * (high - low)
    }

    fn ticks(&self) -> impl Iterator<Item = f64> {
        let count = ((self.to - self.from) / self.step).round() as u32;
        (0..=count).map(|tick| self.from + f64::from(tick) * self.step)
    }

    fn label(&self, value: f64) -> String {
        let digits = if self.step < 0.01 {
            3
        } else if self.step < 0.1 {
            2
        } else {
            usize::from(self.step < 1.0)
        };
        format!("{value:.digits$}")
    }
}

impl Figure<'_> {
    pub(crate) fn write(&self, file: &Path) -> Result<()> {
        let mut svg = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {HEIGHT}\" \
             font-family=\"sans-serif\" font-size=\"12\">\n<rect width=\"100%\" height=\"100%\" \
             fill=\"white\"/>\n"
        );
        self.axes(&mut svg)?;
        for (index, series) in self.series.iter().enumerate() {
            self.series(&mut svg, series, index)?;
        }
        svg.push_str("</svg>\n");
        Ok(std::fs::write(file, svg)?)
    }

    fn axes(&self, svg: &mut String) -> Result<()> {
        let middle = 0.5 * (LEFT + RIGHT);
        writeln!(svg, "<text x=\"{LEFT}\" y=\"24\" font-size=\"15\">{}</text>", self.title)?;
        for tick in self.x.ticks() {
            let (x, label) = (self.x.at(tick, [LEFT, RIGHT]), self.x.label(tick));
            writeln!(svg, "<path d=\"M{x:.1} {TOP}V{BOTTOM}\" stroke=\"#ddd\"/>")?;
            let y = BOTTOM + 17.0;
            writeln!(svg, "<text x=\"{x:.1}\" y=\"{y}\" text-anchor=\"middle\">{label}</text>")?;
        }
        for tick in self.y.ticks() {
            let (y, label) = (self.y.at(tick, [BOTTOM, TOP]), self.y.label(tick));
            writeln!(svg, "<path d=\"M{LEFT} {y:.1}H{RIGHT}\" stroke=\"#ddd\"/>")?;
            let (x, y) = (LEFT - 7.0, y + 4.0);
            writeln!(svg, "<text x=\"{x}\" y=\"{y:.1}\" text-anchor=\"end\">{label}</text>")?;
        }
        writeln!(
            svg,
            "<path d=\"M{LEFT} {TOP}V{BOTTOM}H{RIGHT}\" fill=\"none\" stroke=\"black\"/>"
        )?;
        let (y, up) = (BOTTOM + 38.0, 0.5 * (TOP + BOTTOM));
        writeln!(
            svg,
            "<text x=\"{middle}\" y=\"{y}\" text-anchor=\"middle\">{}</text>",
            self.x.name
        )?;
        writeln!(
            svg,
            "<text transform=\"translate(18 {up}) rotate(-90)\" text-anchor=\"middle\">{}</text>",
            self.y.name
        )?;
        let y = TOP + 24.0 + 22.0 * self.series.len() as f64;
        writeln!(
            svg,
            "<text x=\"{}\" y=\"{y}\" fill=\"#555\">{}</text>",
            RIGHT + 14.0,
            self.remark
        )?;
        Ok(())
    }

    fn series(&self, svg: &mut String, series: &Series, index: usize) -> Result<()> {
        let colour = COLOURS[index % COLOURS.len()];
        let place = |&[x, y]: &[f64; 2]| (self.x.at(x, [LEFT, RIGHT]), self.y.at(y, [BOTTOM, TOP]));
        let mut path = String::new();
        for (x, y) in series.line.iter().map(place) {
            write!(path, "{}{x:.1} {y:.1}", if path.is_empty() { 'M' } else { 'L' })?;
        }
        writeln!(
            svg,
            "<path d=\"{path}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"1.6\"/>"
        )?;
        for (x, y) in series.points.iter().map(place) {
            writeln!(
                svg,
                "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"3.2\" fill=\"white\" stroke=\"{colour}\" \
                 stroke-width=\"1.4\"/>"
            )?;
        }
        let (x, y) = (RIGHT + 14.0, TOP + 12.0 + 22.0 * index as f64);
        writeln!(svg, "<path d=\"M{x} {y}h20\" stroke=\"{colour}\" stroke-width=\"2\"/>")?;
        writeln!(svg, "<text x=\"{}\" y=\"{}\">{}</text>", x + 26.0, y + 4.0, series.name)?;
        Ok(())
    }
}
