//! The scenes that are compared, and the roads through them.

use crate::deep::measured::Film;
use crate::program::Program;
use anyhow::Result;
use std::fmt::Write as _;

/// Pixels along each edge.
pub(super) const SIZE: u32 = 64;
/// Paths by which the search for the sun is measured.
const CALIBRATION_PATHS: u32 = 1 << 17;

/// How light goes through snow.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Road {
    Exact,
    Learnt,
    ProxyInDepth,
    Shells,
    Proxy,
    Volume,
    Dipole,
}

impl Road {
    pub(super) const ALL: [Self; 7] = [
        Self::Exact,
        Self::Learnt,
        Self::ProxyInDepth,
        Self::Shells,
        Self::Proxy,
        Self::Volume,
        Self::Dipole,
    ];

    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Exact => "exact",
            Self::Learnt => "learnt (L)",
            Self::ProxyInDepth => "proxy in depth (P)",
            Self::Shells => "shells in depth (S)",
            Self::Proxy => "proxy from the first grain",
            Self::Volume => "volume",
            Self::Dipole => "dipole",
        }
    }

    /// The lines of the scene.
    fn table(self) -> &'static str {
        match self {
            Self::Exact => "kind = \"grains\"\n",
            Self::Learnt => "deep = \"learnt\"\nlod_error = 0.01\n",
            Self::ProxyInDepth => "deep = \"proxy\"\n",
            Self::Shells => "deep = \"shells\"\n",
            Self::Proxy => "kind = \"proxy\"\n",
            Self::Volume => "kind = \"volume\"\n",
            Self::Dipole => "kind = \"dipole\"\n",
        }
    }

    /// Whether it is measured in a case: some know spheres alone, and where snow is deepest others than deep roads tell nothing new.
    pub(super) fn knows(self, Case { body, light }: Case) -> bool {
        let is_deep =
            matches!(self, Self::Exact | Self::Learnt | Self::ProxyInDepth | Self::Shells);
        match body {
            Body::Deepest => is_deep && light == Light::Overcast,
            Body::Crystals | Body::Level | Body::ExactlyLevel | Body::Layers => {
                !matches!(self, Self::Volume | Self::Dipole)
            }
            Body::Deep | Body::Fallen | Body::Thin | Body::Ball => true,
        }
    }
}

/// What shines.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Light {
    Overcast,
    SunAndSky,
}

impl Light {
    pub(super) const ALL: [Self; 2] = [Self::Overcast, Self::SunAndSky];

    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Overcast => "overcast",
            Self::SunAndSky => "sun and sky",
        }
    }

    fn table(self) -> &'static str {
        match self {
            Self::Overcast => "[[light]]\nkind = \"overcast\"\n",
            Self::SunAndSky => "[[light]]\nkind = \"sun-sky\"\nelevation = 40\nazimuth = 60\n",
        }
    }

    fn samples(self, quick: bool) -> u32 {
        match (self, quick) {
            (Self::Overcast, false) => 64,
            (Self::SunAndSky, false) => 48,
            (_, true) => 16,
        }
    }
}

/// A body of snow.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Body {
    Deep,
    Deepest,
    Fallen,
    Crystals,
    Level,
    ExactlyLevel,
    Layers,
    Thin,
    Ball,
}

impl Body {
    pub(super) const ALL: [Self; 9] = [
        Self::Deep,
        Self::Deepest,
        Self::Fallen,
        Self::Crystals,
        Self::Level,
        Self::ExactlyLevel,
        Self::Layers,
        Self::Thin,
        Self::Ball,
    ];

    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Deep => "5 cm deep",
            Self::Deepest => "20 cm deep",
            Self::Fallen => "5 cm that fell (`rule = \"ray\"`)",
            Self::Crystals => "5 cm of plates and columns",
            Self::Level => "5 cm of plates that lie level, within 10 degrees",
            Self::ExactlyLevel => "5 cm of plates that lie exactly level",
            Self::Layers => "2.5 cm of spheres (350 kg/m^3) under 2.5 cm of plates (200 kg/m^3)",
            Self::Thin => "5 mm on dark ground",
            Self::Ball => "ball 2 cm across",
        }
    }

    fn tables(self) -> String {
        let snow = "radius = 0.0005\ndensity = 275\n";
        let seen = |depth: f64, width: f64| {
            let middle = 0.5 * width;
            format!(
                "[camera]\nkind = \"orthographic\"\nfrom = [{middle}, {}, {}]\nat = [{middle}, {depth}, {middle}]\n\
                 height = 0.032\n[[object]]\nshape = \"plane\"\nalbedo = 0.03\n[[snow]]\nradius = 0.0005\n",
                depth + 0.08,
                middle + 0.1,
            )
        };
        let block = |depth: f64, width: f64| {
            let body = format!("box = [0, 0, 0, {width}, {depth}, {width}]");
            format!("{}source = \"pack\"\ndensity = 275\n{body}\n", seen(depth, width))
        };
        match self {
            Self::Deep => block(0.05, 0.08),
            Self::Deepest => block(0.2, 0.4),
            Self::Fallen => format!(
                "{}source = \"deposit\"\nrule = \"ray\"\ndepth = 0.05\narea = [0, 0, 0.08, 0.08]\n",
                seen(0.05, 0.08)
            ),
            Self::Crystals => format!(
                "{}[[snow.shapes]]\nshape = \"hexagonal-plate\"\naspect = 0.3\nrounding = 0.2\n\
                 [[snow.shapes]]\nshape = \"hexagonal-column\"\naspect = 2.5\n",
                block(0.05, 0.08)
            ),
            Self::Level | Self::ExactlyLevel => {
                let spread = if self == Self::Level { 10 } else { 0 };
                format!(
                    "{}[[snow.shapes]]\nshape = \"hexagonal-plate\"\naspect = 0.3\nrounding = 0.2\n\
                     orientation = \"horizontal\"\nspread = {spread}\n",
                    block(0.05, 0.08)
                )
            }
            Self::Layers => format!(
                "{}source = \"pack\"\ndensity = 350\nbox = [0, 0, 0, 0.08, 0.025, 0.08]\n\
                 [[snow]]\nradius = 0.0005\nsource = \"pack\"\ndensity = 200\n\
                 box = [0, 0.025, 0, 0.08, 0.05, 0.08]\n\
                 [[snow.shapes]]\nshape = \"hexagonal-plate\"\naspect = 0.3\nrounding = 0.2\n",
                seen(0.05, 0.08)
            ),
            Self::Thin => block(0.005, 0.08),
            Self::Ball => format!(
                "[camera]\nkind = \"orthographic\"\nfrom = [0, 0.05, 0.08]\nat = [0, 0.009, 0]\n\
                 height = 0.024\n[[object]]\nshape = \"plane\"\nalbedo = 0.2\n\
                 [[snow]]\nsource = \"fill\"\nfile = \"ball.obj\"\ntranslate = [0, 0.0105, 0]\n{snow}"
            ),
        }
    }
}

/// A body under a light.
#[derive(Clone, Copy, Debug)]
pub(super) struct Case {
    pub(super) body: Body,
    pub(super) light: Light,
}

impl Case {
    /// Renders it; the film stays in the folder until the next.
    pub(super) fn render(&self, program: &Program, road: Road, quick: bool) -> Result<Film> {
        let mut scene = format!(
            "version = 1\n[film]\nwidth = {SIZE}\nheight = {SIZE}\n{}{}[integrator]\n{}",
            self.body.tables(),
            self.light.table(),
            road.table(),
        );
        if self.light == Light::SunAndSky {
            writeln!(scene, "calibration_paths = {CALIBRATION_PATHS}")?;
        }
        std::fs::write(program.folder().join("ball.obj"), ball(0.01))?;
        std::fs::write(program.folder().join("roads.toml"), scene)?;
        let samples = self.light.samples(quick);
        program.print(
            &format!(
                "render roads.toml --quiet --spp {samples} --json-stats stats.json -o deep.film"
            ),
            None,
        )?;
        Film::read(program.folder())
    }
}

/// A sphere as a mesh: rings of latitude.
fn ball(radius: f64) -> String {
    let (rings, sides) = (24u32, 48u32);
    let mut text = String::new();
    let point = |ring: u32, side: u32| {
        let (sin, cos) = snowgrain_math::trig::sin_cos(
            core::f64::consts::PI * f64::from(ring) / f64::from(rings),
        );
        let turn = core::f64::consts::TAU * f64::from(side) / f64::from(sides);
        let (along, across) = snowgrain_math::trig::sin_cos(turn);
        [radius * sin * across, radius * cos, radius * sin * along]
    };
    let mut vertex = |[x, y, z]: [f64; 3]| text.push_str(&format!("v {x} {y} {z}\n"));
    vertex(point(0, 0));
    (1..rings).for_each(|ring| (0..sides).for_each(|side| vertex(point(ring, side))));
    vertex(point(rings, 0));
    let at = |ring: u32, side: u32| match ring {
        0 => 1,
        _ if ring == rings => 2 + (rings - 1) * sides,
        _ => 2 + (ring - 1) * sides + side % sides,
    };
    for ring in 0..rings {
        for side in 0..sides {
            let [a, b, c, d] =
                [at(ring, side), at(ring, side + 1), at(ring + 1, side + 1), at(ring + 1, side)];
            if ring > 0 {
                text.push_str(&format!("f {a} {b} {d}\n"));
            }
            if ring + 1 < rings {
                text.push_str(&format!("f {b} {c} {d}\n"));
            }
        }
    }
    text
}
