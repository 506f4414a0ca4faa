//! Directions over a plane, seen from above: the vertical in the middle, the azimuth around it.

use super::Drawing;
use super::axis::{Axis, Scale};
use super::canvas::{Anchor, Canvas, Fault};
use plotters::prelude::{DrawingBackend, RGBColor};
use snowgrain_math::trig;

const FRAME: RGBColor = RGBColor(40, 40, 40);
const WHITE: RGBColor = RGBColor(255, 255, 255);
const RADIUS: f64 = 130.0;
/// Of the square that a hemisphere takes, with its words.
const SIDE: f64 = 340.0;
const TOP: f64 = 66.0;
/// Hemispheres in a row.
const IN_A_ROW: usize = 4;
/// Hemispheres on a sheet.
const MOST: usize = 12;
const TEXT: f64 = 12.0;
/// Parts into which a step of the azimuth is drawn.
const PARTS: u32 = 6;

/// Values in directions.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::command) struct Hemisphere {
    pub(in crate::command) label: String,
    /// Zenith angle of the light, degrees.
    pub(in crate::command) sun_degrees: f64,
    /// Zenith angle, azimuth, both in degrees, and value.
    pub(in crate::command) values: Vec<[f64; 3]>,
}

/// Several, under one scale of colours.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::command) struct Hemispheres {
    pub(in crate::command) title: String,
    pub(in crate::command) subtitle: String,
    /// What the colours are.
    pub(in crate::command) name: &'static str,
    pub(in crate::command) all: Vec<Hemisphere>,
}

impl Hemispheres {
    fn shown(&self) -> &[Hemisphere] {
        &self.all[..self.all.len().min(MOST)]
    }

    fn columns(&self) -> usize {
        self.shown().len().clamp(1, IN_A_ROW)
    }
}

impl Drawing for Hemispheres {
    fn size(&self) -> [f64; 2] {
        let rows = self.shown().len().div_ceil(self.columns()).max(1);
        let words = 8.0 * self.title.chars().count().max(self.subtitle.chars().count()) as f64;
        let width = self.columns() as f64 * SIDE + 90.0;
        [width.max(words + 40.0), TOP + rows as f64 * SIDE]
    }

    fn draw<B: DrawingBackend>(&self, canvas: &Canvas<B>) -> Result<(), Fault> {
        canvas.text(&self.title, [24.0, 20.0], 17.0, Anchor::Left)?;
        canvas.text(&self.subtitle, [24.0, 42.0], 13.0, Anchor::Left)?;
        let values = self.shown().iter().flat_map(|one| &one.values).map(|value| value[2]);
        let axis = Axis::holding(Scale::Linear, values);
        for (index, one) in self.shown().iter().enumerate() {
            let (column, row) = (index % self.columns(), index / self.columns());
            let x = (column as f64 + 0.5) * SIDE;
            let y = TOP + (row as f64 + 0.5) * SIDE;
            one.draw(canvas, [x, y], &axis)?;
        }
        if self.all.len() > MOST {
            let more = format!("and {} more", self.all.len() - MOST);
            canvas.text(&more, [24.0, 60.0], TEXT, Anchor::Left)?;
        }
        draw_scale(canvas, [self.columns() as f64 * SIDE + 10.0, TOP + 30.0], self.name, &axis)
    }
}

impl Hemisphere {
    fn draw<B: DrawingBackend>(
        &self,
        canvas: &Canvas<B>,
        [x, y]: [f64; 2],
        axis: &Axis,
    ) -> Result<(), Fault> {
        canvas.text(&self.label, [x, y - RADIUS - 22.0], TEXT, Anchor::Above)?;
        // Azimuth 0, away from the sun, is at the right.
        let at = |zenith: f64, azimuth: f64| {
            let (sin, cos) = trig::sin_cos(azimuth.to_radians());
            [x + RADIUS * zenith / 90.0 * cos, y - RADIUS * zenith / 90.0 * sin]
        };
        let ring = |zenith: f64| {
            (0..=72).map(|step| at(zenith, 5.0 * f64::from(step))).collect::<Vec<_>>()
        };
        for sector in sectors(&self.values) {
            let colour = colour(axis.place(sector.value).unwrap_or(0.0));
            canvas.area(&sector.outline(&at), colour)?;
        }
        for zenith in [30.0, 60.0] {
            canvas.line(&ring(zenith), WHITE, 0.5)?;
            let words = format!("{zenith}°");
            canvas.coloured_text(&words, at(zenith, 90.0), (10.0, WHITE), Anchor::Above)?;
        }
        canvas.line(&ring(90.0), FRAME, 1.0)?;
        for (azimuth, anchor) in
            [(0.0, Anchor::Left), (90.0, Anchor::Above), (180.0, Anchor::Right)]
        {
            canvas.text(&format!("{azimuth}°"), at(93.0, azimuth), TEXT, anchor)?;
        }
        // Where the light comes from.
        let sun = at(self.sun_degrees, 180.0);
        canvas.dot(sun, 6.0, FRAME)?;
        canvas.dot(sun, 4.5, RGBColor(255, 221, 51))
    }
}

/// A step of the zenith angle and one of the azimuth, and the value in it.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Sector {
    zenith: [f64; 2],
    azimuth: [f64; 2],
    value: f64,
}

impl Sector {
    fn outline(&self, at: &impl Fn(f64, f64) -> [f64; 2]) -> Vec<[f64; 2]> {
        let ([low, high], [from, to]) = (self.zenith, self.azimuth);
        let along = |part: u32| from + (to - from) * f64::from(part) / f64::from(PARTS);
        let outer = (0..=PARTS).map(|part| at(high, along(part)));
        let inner = (0..=PARTS).rev().map(|part| at(low, along(part)));
        outer.chain(inner).collect()
    }
}

/// The sectors around the directions, halfway to their neighbours. Snow that is lit from one side is the
/// same on both sides of the light: azimuths that are 0 to 180 stand for the others.
fn sectors(values: &[[f64; 3]]) -> Vec<Sector> {
    let sorted = |axis: usize| {
        let mut all: Vec<f64> = values.iter().map(|value| value[axis]).collect();
        all.sort_by(f64::total_cmp);
        all.dedup();
        all
    };
    let (zeniths, azimuths) = (sorted(0), sorted(1));
    let mirrored = azimuths.iter().all(|azimuth| (0.0..=180.0).contains(azimuth));
    let mut sectors = Vec::new();
    for &[zenith, azimuth, value] in values {
        let [low, high] = around(&zeniths, zenith, [0.0, 90.0]);
        let limits = if mirrored { [0.0, 180.0] } else { [-360.0, 360.0] };
        let [from, to] = around(&azimuths, azimuth, limits);
        sectors.push(Sector { zenith: [low, high], azimuth: [from, to], value });
        if mirrored {
            sectors.push(Sector { zenith: [low, high], azimuth: [-to, -from], value });
        }
    }
    sectors
}

/// Halfway to the neighbours of a value, as far to the other side where there is none.
fn around(all: &[f64], value: f64, [least, greatest]: [f64; 2]) -> [f64; 2] {
    let below = all.iter().rev().find(|other| **other < value);
    let above = all.iter().find(|other| **other > value);
    let gaps = [below.map(|below| value - below), above.map(|above| above - value)];
    let half = |gap: Option<f64>, other: Option<f64>| 0.5 * gap.or(other).unwrap_or(20.0);
    let [low, high] = [half(gaps[0], gaps[1]), half(gaps[1], gaps[0])];
    [(value - low).max(least), (value + high).min(greatest)]
}

/// Dark blue through green to yellow, evenly brighter: about viridis (Smith and van der Walt 2015).
fn colour(part: f64) -> RGBColor {
    const STOPS: [[f64; 3]; 5] = [
        [68.0, 1.0, 84.0],
        [59.0, 82.0, 139.0],
        [33.0, 145.0, 140.0],
        [94.0, 201.0, 98.0],
        [253.0, 231.0, 37.0],
    ];
    let place = part.clamp(0.0, 1.0) * 4.0;
    let stop = (place as usize).min(3);
    let [r, g, b] = [0, 1, 2].map(|channel: usize| {
        let [low, high] = [STOPS[stop][channel], STOPS[stop + 1][channel]];
        (low + (high - low) * (place - stop as f64)).round() as u8
    });
    RGBColor(r, g, b)
}

/// The bar of colours.
fn draw_scale<B: DrawingBackend>(
    canvas: &Canvas<B>,
    [x, y]: [f64; 2],
    name: &str,
    axis: &Axis,
) -> Result<(), Fault> {
    const HEIGHT: f64 = 240.0;
    const WIDTH: f64 = 16.0;
    canvas.text(name, [x, y - 14.0], 13.0, Anchor::Left)?;
    for step in 0..60 {
        let [low, high] = [step, step + 1].map(|step| f64::from(step) / 60.0);
        let (bottom, top) = (y + HEIGHT * (1.0 - low), y + HEIGHT * (1.0 - high));
        let corners = [[x, top], [x + WIDTH, top], [x + WIDTH, bottom], [x, bottom]];
        canvas.area(&corners, colour(0.5 * (low + high)))?;
    }
    for (value, words) in axis.ticks() {
        if let Some(place) = axis.place(value) {
            let at = y + HEIGHT * (1.0 - place);
            canvas.line(&[[x + WIDTH, at], [x + WIDTH + 4.0, at]], FRAME, 1.0)?;
            canvas.text(&words, [x + WIDTH + 7.0, at], TEXT, Anchor::Left)?;
        }
    }
    Ok(())
}
