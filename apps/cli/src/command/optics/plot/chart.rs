//! Lines on two axes.

use super::axis::{Axis, Scale};
use super::canvas::{Anchor, Canvas, Fault};
use super::{Drawing, Line};
use plotters::prelude::{DrawingBackend, RGBColor};

/// Colours that can be told apart by most eyes: Okabe and Ito 2008.
const COLOURS: [RGBColor; 7] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
    RGBColor(60, 60, 60),
];
const FRAME: RGBColor = RGBColor(40, 40, 40);
const GRID: RGBColor = RGBColor(225, 225, 225);
/// Most lines that the legend names.
const MOST_NAMED: usize = 22;
/// Around the plane of the axes, points.
const LEFT: f64 = 78.0;
const RIGHT: f64 = 18.0;
const TOP: f64 = 58.0;
const BOTTOM: f64 = 58.0;
const LEGEND_LINE: f64 = 19.0;
const TEXT: f64 = 13.0;

/// One pair of axes.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::command) struct Chart {
    /// What x and y are, with their units.
    pub(in crate::command) names: [&'static str; 2],
    pub(in crate::command) scales: [Scale; 2],
    /// Where y goes from and to, if that is known before.
    pub(in crate::command) y_range: Option<[f64; 2]>,
    pub(in crate::command) lines: Vec<Line>,
}

/// Charts side by side, whose lines are named once.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::command) struct Charts {
    pub(in crate::command) title: String,
    /// What is alike in all lines.
    pub(in crate::command) subtitle: String,
    pub(in crate::command) charts: Vec<Chart>,
}

/// The rectangle of the axes: left, top, width, height.
type Plane = [f64; 4];

impl Charts {
    fn labels(&self) -> Vec<&Line> {
        let lines = self.charts.first().map_or(&[][..], |chart| &chart.lines);
        lines.iter().filter(|line| !line.label.is_empty()).collect()
    }

    /// Width of the legend, by its longest label.
    fn legend(&self) -> f64 {
        let longest = self.labels().iter().map(|line| line.label.chars().count()).max();
        longest.map_or(0.0, |letters| 56.0 + 7.2 * letters as f64)
    }

    fn chart_width(&self) -> f64 {
        if self.charts.len() == 1 { 640.0 } else { 520.0 }
    }
}

impl Drawing for Charts {
    fn size(&self) -> [f64; 2] {
        let charts = self.charts.len() as f64 * self.chart_width();
        let words = 8.5 * self.title.chars().count().max(self.subtitle.chars().count()) as f64;
        [(charts + self.legend()).max(words + LEFT), 480.0]
    }

    fn draw<B: DrawingBackend>(&self, canvas: &Canvas<B>) -> Result<(), Fault> {
        canvas.text(&self.title, [LEFT, 20.0], 17.0, Anchor::Left)?;
        canvas.text(&self.subtitle, [LEFT, 42.0], TEXT, Anchor::Left)?;
        let (width, [_, height]) = (self.chart_width(), self.size());
        for (index, chart) in self.charts.iter().enumerate() {
            let left = index as f64 * width + LEFT;
            let plane = [left, TOP, width - LEFT - RIGHT, height - TOP - BOTTOM];
            chart.draw(canvas, plane)?;
        }
        self.draw_legend(canvas, self.charts.len() as f64 * width)
    }
}

impl Charts {
    fn draw_legend<B: DrawingBackend>(&self, canvas: &Canvas<B>, left: f64) -> Result<(), Fault> {
        let lines = self.charts.first().map_or(&[][..], |chart| &chart.lines);
        let named = lines.iter().filter(|line| !line.label.is_empty());
        for (line, row) in named.zip(0..) {
            let y = TOP + 8.0 + LEGEND_LINE * f64::from(row);
            if row as usize == MOST_NAMED {
                let more = format!("and {} more", self.labels().len() - MOST_NAMED);
                return canvas.text(&more, [left + 36.0, y], TEXT, Anchor::Left);
            }
            stroke(canvas, &[[left, y], [left + 28.0, y]], line)?;
            canvas.text(&line.label, [left + 36.0, y], TEXT, Anchor::Left)?;
        }
        Ok(())
    }
}

impl Chart {
    fn draw<B: DrawingBackend>(&self, canvas: &Canvas<B>, plane: Plane) -> Result<(), Fault> {
        let points = || self.lines.iter().flat_map(|line| &line.points);
        let x = Axis::between(self.scales[0], points().map(|point| point[0]));
        let y = self.y_range.map_or_else(
            || Axis::holding(self.scales[1], points().map(|point| point[1])),
            |[from, to]| Axis::of(from, to),
        );
        self.draw_axes(canvas, plane, [&x, &y])?;
        for line in &self.lines {
            draw_line(canvas, plane, [&x, &y], line)?;
        }
        let [left, top, width, height] = plane;
        let corners = [[left, top], [left + width, top], [left + width, top + height]];
        let frame = [&corners[..], &[[left, top + height], [left, top]]].concat();
        canvas.line(&frame, FRAME, 1.0)
    }

    fn draw_axes<B: DrawingBackend>(
        &self,
        canvas: &Canvas<B>,
        [left, top, width, height]: Plane,
        [x, y]: [&Axis; 2],
    ) -> Result<(), Fault> {
        let (right, bottom) = (left + width, top + height);
        for (value, words) in x.ticks() {
            let Some(place) = x.place(value) else { continue };
            let at = left + width * place;
            canvas.line(&[[at, top], [at, bottom]], GRID, 1.0)?;
            canvas.text(&words, [at, bottom + 7.0], TEXT, Anchor::Below)?;
        }
        for (value, words) in y.ticks() {
            let Some(place) = y.place(value) else { continue };
            let at = bottom - height * place;
            canvas.line(&[[left, at], [right, at]], GRID, 1.0)?;
            canvas.text(&words, [left - 7.0, at], TEXT, Anchor::Right)?;
        }
        let [name_x, name_y] = self.names;
        canvas.text(name_x, [left + 0.5 * width, bottom + 30.0], 14.0, Anchor::Below)?;
        canvas.text(name_y, [left - 52.0, top + 0.5 * height], 14.0, Anchor::Upwards)
    }
}

/// A line, broken where it leaves the plane, with bars of one standard error.
fn draw_line<B: DrawingBackend>(
    canvas: &Canvas<B>,
    [left, top, width, height]: Plane,
    [x, y]: [&Axis; 2],
    line: &Line,
) -> Result<(), Fault> {
    let colour = COLOURS[line.case % COLOURS.len()];
    let within = |place: f64| (-1e-6..=1.0 + 1e-6).contains(&place);
    let at = |x_value: f64, y_value: f64| {
        let (x, y) = (x.place(x_value)?, y.place(y_value)?);
        (within(x) && within(y)).then_some([left + width * x, top + height * (1.0 - y)])
    };
    let mut drawn: Vec<[f64; 2]> = Vec::new();
    for &[x_value, y_value, error] in &line.points {
        let Some(point) = at(x_value, y_value) else {
            stroke(canvas, &drawn, line)?;
            drawn.clear();
            continue;
        };
        drawn.push(point);
        let (low, high) = (at(x_value, y_value - error), at(x_value, y_value + error));
        if let (Some(low), Some(high)) = (low, high)
            && low[1] - high[1] > 3.0
        {
            canvas.line(&[low, high], colour, 1.0)?;
            for [x, y] in [low, high] {
                canvas.line(&[[x - 2.5, y], [x + 2.5, y]], colour, 1.0)?;
            }
        }
    }
    // Few points are seen as such.
    if line.points.len() <= 30 {
        for &[x, y, _] in &line.points {
            if let Some(point) = at(x, y) {
                canvas.dot(point, 2.6, colour)?;
            }
        }
    }
    stroke(canvas, &drawn, line)
}

/// Cases beyond those that have a colour of their own have long dashes.
fn stroke<B: DrawingBackend>(
    canvas: &Canvas<B>,
    points: &[[f64; 2]],
    line: &Line,
) -> Result<(), Fault> {
    const WIDTH: f64 = 1.6;
    let colour = COLOURS[line.case % COLOURS.len()];
    let round = (line.case / COLOURS.len()) as f64;
    if points.len() < 2 {
        return Ok(());
    }
    match (line.dashed, round > 0.0) {
        (false, false) => canvas.line(points, colour, WIDTH),
        (false, true) => canvas.dashes(points, colour, (WIDTH, 8.0 * round)),
        (true, _) => canvas.dashes(points, colour, (WIDTH, 3.0 + 1.5 * round)),
    }
}
