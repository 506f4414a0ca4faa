//! The scenes that are compared.

use super::measured::Film;
use crate::program::Program;
use anyhow::{Context as _, Result};
use snowgrain_render::transport::deep::DeepSettings;

/// Radius of the grains, metres.
const RADIUS: f64 = 0.5e-3;
/// Pixels along each edge.
const SIZE: u32 = 64;

/// Samples of a pixel where speed is measured.
const SPEED_SAMPLES: u32 = 1024;

/// What shines.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Light {
    Overcast,
    SunAndSky,
}

impl Light {
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Overcast => "overcast",
            Self::SunAndSky => "sun and sky",
        }
    }

    /// From which depth on light ends, transport lengths.
    pub(super) fn depth(self, settings: &DeepSettings) -> f64 {
        match self {
            Self::Overcast => settings.depth,
            Self::SunAndSky => settings.under_small_lights().depth,
        }
    }

    fn tables(self) -> &'static str {
        match self {
            Self::Overcast => "[[light]]\nkind = \"overcast\"\n",
            Self::SunAndSky => "[[light]]\nkind = \"sun-sky\"\nelevation = 40.0\nazimuth = 60.0\n",
        }
    }

    /// Samples of a pixel: exact and learnt.
    fn samples(self, quick: bool) -> [u32; 2] {
        match (self, quick) {
            (Self::Overcast, false) => [768, 384],
            (Self::Overcast, true) => [128, 128],
            (Self::SunAndSky, false) => [384, 256],
            (Self::SunAndSky, true) => [64, 64],
        }
    }
}

/// What the snow is made of.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Grains {
    Ice,
    Salt,
}

impl Grains {
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Ice => "ice",
            Self::Salt => "salt",
        }
    }

    /// A table of the scene.
    fn table(self) -> &'static str {
        match self {
            Self::Ice => "",
            Self::Salt => "[material]\nkind = \"salt\"\n",
        }
    }
}

/// When light ends: by the error that is asked for.
#[derive(Clone, Copy, PartialEq)]
pub(super) struct Handover {
    pub(super) error: f64,
}

impl Handover {
    /// The default first.
    pub(super) const ALL: [Self; 3] =
        [Self { error: 0.01 }, Self { error: 0.003 }, Self { error: 0.001 }];

    pub(super) fn settings(self) -> Result<DeepSettings> {
        DeepSettings::for_error(self.error).context("no settings are known for this error")
    }
}

/// A scene.
pub(super) struct Case {
    pub(super) light: Light,
    pub(super) grains: Grains,
    /// kg/m^3.
    pub(super) density: f64,
    /// Edge of a pixel, radii of the grains.
    pub(super) pixel_radii: f64,
    /// Of the snow, metres.
    pub(super) depth: f64,
    /// Along x and z, metres.
    width: f64,
    /// Whether both pictures have as many samples, so that rare bright ones weigh as much in both.
    alike: bool,
}

impl Case {
    pub(super) fn of_errors(quick: bool) -> Vec<Self> {
        let lights: &[Light] =
            if quick { &[Light::Overcast] } else { &[Light::Overcast, Light::SunAndSky] };
        let mut cases = Vec::new();
        for &light in lights {
            let densities: &[f64] = match (quick, light) {
                (true, _) | (_, Light::SunAndSky) => &[275.0],
                (false, Light::Overcast) => &[150.0, 275.0, 450.0],
            };
            let pixels: &[f64] = if quick { &[1.0] } else { &[0.5, 2.0, 8.0] };
            for &density in densities {
                cases.extend(pixels.iter().map(|&pixel_radii| Self {
                    light,
                    grains: Grains::Ice,
                    density,
                    pixel_radii,
                    depth: 0.05,
                    width: 0.12,
                    alike: false,
                }));
            }
        }
        if !quick {
            cases.push(Self {
                light: Light::Overcast,
                grains: Grains::Salt,
                density: 275.0,
                pixel_radii: 2.0,
                depth: 0.05,
                width: 0.12,
                alike: false,
            });
        }
        cases
    }

    /// Grains that a path meets before it may end.
    pub(super) fn grains(&self, settings: &DeepSettings) -> f64 {
        let [narrow, wide] = settings.after_grains.map(f64::from);
        narrow + (wide - narrow) * DeepSettings::width(self.pixel_radii).clamp(0.0, 1.0)
    }

    pub(super) fn of_speed(quick: bool) -> Vec<Self> {
        let case = |light, depth, width| Self {
            light,
            grains: Grains::Ice,
            density: 275.0,
            pixel_radii: 1.0,
            depth,
            width,
            alike: !quick,
        };
        let mut cases = vec![case(Light::Overcast, 0.1, 0.3)];
        if !quick {
            cases.push(case(Light::Overcast, 1.0, 0.2));
            cases.push(case(Light::SunAndSky, 0.1, 0.3));
        }
        cases
    }

    /// Renders it with light that is followed to its end, or ends as told.
    pub(super) fn render(
        &self,
        program: &Program,
        handover: Option<Handover>,
        quick: bool,
    ) -> Result<Film> {
        std::fs::write(program.folder().join("deep.toml"), self.scene())?;
        let [exact, learnt] = self.light.samples(quick);
        let [exact, learnt] = if self.alike { [SPEED_SAMPLES; 2] } else { [exact, learnt] };
        let (samples, error) = match handover {
            None => (exact, 0.0),
            Some(handover) => (learnt, handover.error),
        };
        program.print(
            &format!(
                "render deep.toml --quiet --spp {samples} --lod-error {error} --json-stats stats.json -o deep.film"
            ),
            None,
        )?;
        Film::read(program.folder())
    }

    fn scene(&self) -> String {
        let Self { density, pixel_radii, depth, width, .. } = self;
        let middle = 0.5 * width;
        let height = f64::from(SIZE) * pixel_radii * RADIUS;
        let lights = self.light.tables();
        let substance = self.grains.table();
        format!(
            "version = 1\n[film]\nwidth = {SIZE}\nheight = {SIZE}\n\
             [camera]\nkind = \"orthographic\"\nfrom = [{middle}, {}, {}]\nat = [{middle}, {depth}, {middle}]\n\
             height = {height}\n{lights}{substance}\
             [[object]]\nshape = \"plane\"\nalbedo = 0.2\n\
             [[snow]]\nsource = \"pack\"\nbox = [0, 0, 0, {width}, {depth}, {width}]\n\
             radius = {RADIUS}\ndensity = {density}\n",
            depth + 0.1,
            middle + 0.15,
        )
    }
}
