//! Light that is looked for ("sampled"): at every grain and surface, instead of waiting for a path to
//! meet it.
//!
//! A sun of half a degree is met by one path in 10^5. Here a path asks at each arrival at a grain how
//! much of a light the grain would send back along it. Where on its disc the path strikes a grain is
//! forgotten, so that the answer is the closed form of [`ScatterTable`] and a shadow ray among the real
//! grains, from where that way leaves the grain. What this forgets is measured and made up for
//! ([`calibrate`]). For suns the first grains count most, and their images of it can be seen:
//!
//! - the first grain that the camera sees is solved exactly, its ways to the sun in closed form and
//!   its visibility among the real grains (`first_grain`), or, where it is a crystal, by all that it makes of the
//!   ray (`first_shape`);
//! - so is the second, by Newton's steps through both (`second_grain`, `reflected`);
//! - where that is not known (crystals in one of the two, ways from grain to grain through ice, many reflections
//!   inside), and at the first two grains after a surface, the sun is met by chance, but it is [`WIDENED_DEGREES`]
//!   wide ([`WIDENED_IN_AIR_DEGREES`] after many reflections in spheres), which moves an image of it by less than a
//!   tenth of a grain's radius and leaves the mean of its light over all directions of the sun as it is.
//!
//! Lights that are met by chance as well share the light with it by the balance heuristic (Veach and
//! Guibas 1995, "Optimally Combining Sampling Techniques for Monte Carlo Rendering").

mod agreement;
pub mod calibrate;
mod chance;
mod deep;
mod first_grain;
mod first_shape;
mod gains;
mod grains;
mod pair_search;
mod reflected;
mod second_grain;
mod shadow;
mod surfaces;
mod window;

pub use agreement::{Agreement, Orders, Part};
pub(super) use chance::Met;
pub(super) use surfaces::Bounce;

use super::Contribution;
use super::ice::IceLength;
use crate::camera::{Bundle, Camera};
use crate::laboratory::scattered;
use crate::light::{LightRole, Lights};
use crate::surface::Scatterer;
use crate::world::World;
use core::f64::consts::TAU;
use gains::{Gains, Tally};
use second_grain::{FirstGrain, SecondGrain};
use shadow::{Origin, Wanted};
use snowgrain_accel::{ArrivalFrom, GrainVisit, Probe, Probes, SimdLevel};
use snowgrain_geometry::Shape;
use snowgrain_math::sampler::PathKey;
use snowgrain_math::{DVec3, trig};
use snowgrain_optics::{Connector, Dielectric, ScatterTable};

/// Angle across suns where their images after one or two grains are not solved but met by chance, degrees.
pub const WIDENED_DEGREES: f64 = 30.0;
/// The same after more reflections in spheres in air than are solved: so rare that the noise of a narrower sun does
/// not show, and so bright in narrow rainbows that lone grains show a wide one.
pub const WIDENED_IN_AIR_DEGREES: f64 = 15.0;

/// Orders of the first grain that are solved; higher ones (.3 % of its light) are met by chance.
const SOLVED_ORDERS: u32 = 3;
/// The same where other grains overlap it: further reflections inside may meet them.
const SOLVED_ORDERS_OF_OVERLAPPED: u32 = 1;

/// Times that light is looked for on the way through grains that overlap. Light that total reflection
/// holds for long would be looked for as often, in vain; what comes out later than this is made up for by the
/// factors.
const SEARCHES_IN_ICE: u32 = 4;

/// Orders of grains at which is asked where light came from ([`shadow`]): beyond, light is so even that
/// the answer changes neither its mean nor its noise, as measured.
const ORIGINS_ASKED: u32 = 5;

/// Grains at which suns are not looked for at random places.
const GRAINS_BEFORE_SUNS: u32 = 2;

/// Paths that are followed through a lone grain of each shape, and their seed.
const SHAPE_PATHS: u64 = 1 << 21;
const SHAPE_SEED: u64 = 0x5ea_2c4ed;

/// Less the cosine of an angle that light was not turned by.
const STRAIGHT: f64 = 1e-9;

/// What tells the random numbers of a search from those of its path.
const SEARCH: u32 = 0x5eed_1194;

/// What the search for light needs to know of a scene: built once.
#[derive(Clone, Debug)]
pub struct LightSearch {
    /// All lights.
    lights: Lights,
    roles: Vec<LightRole>,
    is_sought: Vec<bool>,
    suns: Vec<Sun>,
    /// Those that are looked for at the first grains, and those that are from then on and at surfaces;
    /// the indices are those of all lights.
    early: Lights,
    late: Lights,
    /// Suns as wide as [`WIDENED_DEGREES`], and as [`WIDENED_IN_AIR_DEGREES`].
    wide: Lights,
    wide_in_air: Lights,
    medium: Dielectric,
    from_air: ScatterTable,
    /// Of each prototype that grains have, in all orientations alike.
    of_shapes: Vec<ScatterTable>,
    from_ice: ScatterTable,
    connector: Connector,
    gains: Gains,
}

/// A light whose images in the first grains are solved.
#[derive(Clone, Copy, Debug)]
struct Sun {
    light: usize,
    /// Somewhere on it, as seen from the scene.
    towards: DVec3,
    /// Solid angle, sr, and angle across, radians.
    solid_angle: f64,
    width: f64,
}

impl Sun {
    fn new(lights: &Lights, light: usize) -> Option<Self> {
        let towards = lights.sample_light(light, DVec3::ZERO, [0.0; 3])?.direction;
        let solid_angle = lights.solid_angle(light);
        let width = 2.0 * trig::acos(1.0 - solid_angle / TAU);
        Some(Self { light, towards, solid_angle, width })
    }
}

/// Which lights are looked for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Sought {
    /// All but skies, which paths find by themselves.
    #[default]
    NotSkies,
    /// All.
    All,
}

impl LightSearch {
    /// A search for `lights` among grains of this relative index.
    #[must_use]
    pub fn new(lights: &Lights, eta: f64, sought: Sought) -> Self {
        let medium = Dielectric { eta };
        let roles: Vec<_> = (0..lights.count()).map(|light| lights.role(light)).collect();
        let is_sought: Vec<_> =
            roles.iter().map(|&role| role != LightRole::Sky || sought == Sought::All).collect();
        let suns = (0..lights.count())
            .filter(|&light| roles[light] == LightRole::Sun)
            .filter_map(|light| Sun::new(lights, light))
            .collect();
        Self {
            suns,
            early: lights.select(|light| is_sought[light] && roles[light] != LightRole::Sun),
            late: lights.select(|light| is_sought[light]),
            wide: lights.widened(WIDENED_DEGREES),
            wide_in_air: lights.widened(WIDENED_IN_AIR_DEGREES),
            lights: lights.clone(),
            roles,
            is_sought,
            medium,
            from_air: ScatterTable::for_air(medium),
            of_shapes: Vec::new(),
            from_ice: ScatterTable::for_ice(medium),
            connector: Connector::new(medium, SOLVED_ORDERS),
            gains: Gains::default(),
        }
    }

    /// The lights that are looked for at a grain of this order.
    fn sought_at(&self, order: u32) -> &Lights {
        if order > GRAINS_BEFORE_SUNS { &self.late } else { &self.early }
    }

    /// The same search among grains of these shapes too, of which light is followed through lone ones.
    #[must_use]
    pub fn among(self, prototypes: &[Shape], level: SimdLevel) -> Self {
        let table = |shape: &Shape| {
            let paths = (SHAPE_PATHS, SHAPE_SEED);
            ScatterTable::of_samples(&scattered(shape, self.medium.eta, paths, level))
        };
        Self { of_shapes: prototypes.iter().map(table).collect(), ..self }
    }

    /// The same search among grains of another index nearby, for light of one colour: what is in closed form
    /// follows that index, what was measured stays.
    #[must_use]
    pub(crate) fn refracting_by(&self, eta: f64) -> Self {
        let medium = Dielectric { eta };
        Self {
            medium,
            from_air: ScatterTable::for_air(medium),
            from_ice: ScatterTable::for_ice(medium),
            connector: Connector::new(medium, SOLVED_ORDERS),
            ..self.clone()
        }
    }

    fn table(&self, from: ArrivalFrom, prototype: Option<usize>) -> &ScatterTable {
        match (from, prototype) {
            (ArrivalFrom::Air, Some(prototype)) => &self.of_shapes[prototype],
            (ArrivalFrom::Air, None) => &self.from_air,
            (ArrivalFrom::Ice, _) => &self.from_ice,
        }
    }
}

/// How a camera saw the start of a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// All rays from its place of the lens.
    pub bundle: Bundle,
    /// That place.
    pub lens: [f64; 2],
    /// Place in the image, pixels.
    pub image: [f64; 2],
}

/// Where a path last was without the past showing in where it goes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
enum Vertex {
    /// At the camera.
    #[default]
    Camera,
    /// On a diffuse or rough surface in air: where, and how it scatters.
    Surface(DVec3, Scatterer),
    /// On a smooth surface in air, where no light was looked for.
    SmoothSurface,
    /// On a surface within a grain.
    SurfaceInIce,
    /// Deep in the snow, where grains were met at random; whether small lights were looked for there.
    Deep(bool),
}

/// What the search keeps of a path.
#[derive(Clone, Debug, Default)]
pub(super) struct Trail {
    view: Option<View>,
    /// Unit direction of its first ray.
    seen_along: DVec3,
    /// Grains that it went into from ice since it last met air.
    from_ice: u32,
    vertex: Vertex,
    /// Arrivals at grains from air before the vertex, and those of which the flight does not know any more.
    visits_before: u32,
    visits_forgotten: u32,
    /// The last arrival since the vertex, and the last one of a grain that turned the path.
    last: Option<LastArrival>,
    turned: Option<LastArrival>,
    /// Of the first grain from the camera, the orders that were solved.
    solved_orders: Option<u32>,
    /// The first and the second grain from the camera, where their images of suns are solved.
    first_grain: Option<FirstGrain>,
    second_grain: Option<SecondGrain>,
    /// Whether the path went from grain to grain through ice since the vertex.
    through_ice: bool,
    /// The light found so far, in the order of the path.
    pub(super) contributions: Vec<Contribution>,
}

#[derive(Clone, Copy, Debug)]
struct LastArrival {
    from: ArrivalFrom,
    /// Which grain since the vertex it is.
    order: u32,
    /// The prototype of the grain, where it has a shape.
    prototype: Option<usize>,
    direction: DVec3,
    /// Centre of the grain.
    center: DVec3,
    /// Where its light came from, where ways through the grain must begin at such a place.
    origin: Option<Origin>,
}

impl Trail {
    /// For a new path.
    pub(super) fn begin(&mut self, view: Option<View>, seen_along: DVec3) {
        let mut contributions = std::mem::take(&mut self.contributions);
        contributions.clear();
        *self = Self { view, seen_along, contributions, ..Self::default() };
    }

    /// The last grain that turned the path, which goes on along a direction: light goes straight through
    /// faces that are parallel, and shadow rays do so, too.
    fn turned_before(&self, direction: DVec3) -> Option<LastArrival> {
        let last = self.last?;
        let straight = last.prototype.is_some() && 1.0 - last.direction.dot(direction) < STRAIGHT;
        if straight { self.turned } else { Some(last) }
    }

    /// How many grains the path has met since the vertex, of `grain_visits` in all.
    fn order(&self, grain_visits: u32) -> u32 {
        let since = grain_visits + self.visits_forgotten - self.visits_before;
        since + u32::from(self.vertex == Vertex::SurfaceInIce)
    }

    /// For a path that has met so many grains, in the flight and then at random, and begins in the flight again, in air.
    pub(super) fn emerge(&mut self, grain_visits: u32, looked: bool) {
        self.visits_forgotten += grain_visits;
        (self.last, self.turned, self.from_ice) = (None, None, 0);
        (self.first_grain, self.second_grain) = (None, None);
        self.vertex = Vertex::Deep(looked);
    }
}

/// What the walk tells of a path when the search looks for light.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PathState {
    pub(super) key: PathKey,
    pub(super) throughput: [f32; 3],
    /// Length in ice before the flight began to count.
    pub(super) ice_before: IceLength,
}

/// Looks for light for the paths of one thread.
pub(crate) struct Seeker<'a> {
    world: &'a World,
    camera: &'a Camera,
    search: &'a LightSearch,
    probes: Probes<'a>,
    /// Shadow rays that wait, and what each would bring.
    rays: Vec<Probe>,
    wanted: Vec<Wanted>,
    /// Where light is not looked for, but what that would find is compared with what paths do.
    tally: Option<Tally>,
}

impl<'a> Seeker<'a> {
    pub(crate) fn new(
        world: &'a World,
        camera: &'a Camera,
        search: &'a LightSearch,
        level: SimdLevel,
    ) -> Self {
        Self {
            world,
            camera,
            search,
            probes: Probes::new(&world.grid, &world.surfaces, search.medium.eta, level),
            rays: Vec::new(),
            wanted: Vec::new(),
            tally: None,
        }
    }

    /// Looks for light at arrivals at grains, in their order.
    pub(super) fn at_grains(
        &mut self,
        visits: &[GrainVisit],
        trails: &mut [Trail],
        state: impl Fn(usize) -> PathState,
    ) {
        for visit in visits {
            let (trail, state) = (&mut trails[visit.lane], state(visit.lane));
            let order = trail.order(visit.grain_visits);
            let last = LastArrival {
                from: visit.from,
                order,
                prototype: visit.shaped.map(|shaped| shaped.shape.prototype()),
                direction: DVec3::from_array(visit.direction.map(f64::from)).normalize(),
                center: self.world.grid.world(visit.center),
                origin: match visit.from {
                    ArrivalFrom::Ice => None,
                    ArrivalFrom::Air if visit.shaped.is_some() => None,
                    ArrivalFrom::Air if order == 1 && trail.vertex == Vertex::Camera => {
                        Some(Origin::Open)
                    }
                    ArrivalFrom::Air if order > ORIGINS_ASKED => None,
                    ArrivalFrom::Air => Some(Origin::Matter),
                },
            };
            trail.turned = trail.turned_before(last.direction);
            trail.last = Some(last);
            trail.from_ice = match visit.from {
                ArrivalFrom::Air => 0,
                ArrivalFrom::Ice => trail.from_ice + 1,
            };
            trail.through_ice |= visit.from == ArrivalFrom::Ice;
            if trail.from_ice > SEARCHES_IN_ICE {
                continue;
            }
            if self.tally.is_some() {
                self.try_a_way(visit, &last, (order, trail.seen_along), &state);
                continue;
            }
            self.at_random_place(visit, &last, (order, trail.seen_along), &state);
            if trail.vertex != Vertex::Camera || visit.from != ArrivalFrom::Air {
                continue;
            }
            match (order, &visit.shaped) {
                (1, Some(shaped)) => self.at_first_shape((visit, shaped), trail, &state),
                (1, None) => self.at_first_grain(visit, trail, &state),
                (2, None) => self.at_second_grain(visit, trail, &state),
                _ => {}
            }
        }
        self.follow_shadow_rays(trails);
    }

    /// How far a probe goes that looks at a light at this distance, quanta.
    fn quanta(&self, metres: f64) -> f32 {
        (metres / self.world.grid.quantum()).min(1e30) as f32
    }
}

/// The key of the random numbers of a search.
fn search_key(key: PathKey) -> PathKey {
    PathKey { lo: key.lo ^ SEARCH, hi: key.hi }
}

/// A colour times a number.
fn scaled(colour: [f32; 3], factor: f64) -> [f32; 3] {
    colour.map(|c| (f64::from(c) * factor) as f32)
}

/// Two colours, channel by channel.
fn product(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [a[0] * b[0], a[1] * b[1], a[2] * b[2]]
}
