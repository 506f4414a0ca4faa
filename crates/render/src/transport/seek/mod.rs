//! Light that is looked for ("sampled"): at every grain and surface, instead of waiting for a path to
//! meet it.
//!
//! A sun of half a degree is met by one path in 10^5. Here a path asks at each arrival at a grain how
//! much of the sun's light the grain would send back along it. Where on its disc the path strikes a
//! grain is forgotten, so that the answer is the closed form of [`ScatterTable`] and a shadow ray among
//! the real grains, from where that way leaves the grain: from the third grain on that is right on
//! average, since by then the places are random. Before, they are not:
//!
//! - the first grain that the camera sees is solved exactly, its ways to the sun in closed form and
//!   its visibility among the real grains ([`first_grain`]);
//! - at the second, and at the first two after a diffuse surface, light is met by chance, but small
//!   lights are as wide as [`WIDENED_DEGREES`], which moves an image of the sun by a few hundredths of a
//!   grain's radius and leaves its light as it is.
//!
//! Lights that are large are also met by chance, and both ways share the light by the balance heuristic
//! (Veach and Guibas 1995, "Optimally Combining Sampling Techniques for Monte Carlo Rendering").

mod escape;
mod first_grain;
mod grains;
mod surfaces;

pub(super) use surfaces::Bounce;

use super::Contribution;
use crate::camera::{Bundle, Camera};
use crate::light::Lights;
use crate::world::World;
use snowgrain_accel::{ArrivalFrom, GrainVisit, Probe, ProbeAnswer, Probes, SimdLevel};
use snowgrain_math::sampler::PathKey;
use snowgrain_math::{DVec3, Ray};
use snowgrain_optics::{Connector, Dielectric, ScatterTable};

/// Angle across small lights where they are met by chance after one or two grains, degrees.
pub const WIDENED_DEGREES: f64 = 10.0;

/// Orders of the first grain that are solved; higher ones (.3 % of its light) are met by chance.
const SOLVED_ORDERS: u32 = 3;
/// The same where other grains overlap it: further reflections inside may meet them.
const SOLVED_ORDERS_OF_OVERLAPPED: u32 = 1;

/// Grains after which the places at which a path strikes them are taken to be random.
const GRAINS_BEFORE_RANDOM: u32 = 2;

/// What tells the random numbers of a search from those of its path.
const SEARCH: u32 = 0x5eed_1194;

/// What the search for light needs to know of a scene: built once.
#[derive(Debug)]
pub struct LightSearch {
    /// All lights.
    lights: Lights,
    /// Those of them that are looked for, with the same indices.
    sought: Lights,
    is_sought: Vec<bool>,
    is_small: Vec<bool>,
    /// Small lights as wide as [`WIDENED_DEGREES`].
    wide: Lights,
    from_air: ScatterTable,
    from_ice: ScatterTable,
    connector: Connector,
}

/// Which lights are looked for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Sought {
    /// Those that chance finds too rarely.
    #[default]
    Small,
    /// All.
    All,
}

impl LightSearch {
    /// A search for `lights` among grains of this relative index.
    #[must_use]
    pub fn new(lights: &Lights, eta: f64, sought: Sought) -> Self {
        let medium = Dielectric { eta };
        let is_small: Vec<_> = (0..lights.count()).map(|light| lights.is_small(light)).collect();
        let is_sought: Vec<_> = is_small.iter().map(|&s| s || sought == Sought::All).collect();
        Self {
            lights: lights.clone(),
            sought: lights.select(|light| is_sought[light]),
            is_sought,
            is_small,
            wide: lights.widened(WIDENED_DEGREES),
            from_air: ScatterTable::for_air(medium),
            from_ice: ScatterTable::for_ice(medium),
            connector: Connector::new(medium, SOLVED_ORDERS),
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
    /// On a diffuse surface in air, with this normal.
    Surface(DVec3),
    /// On a diffuse surface within a grain.
    SurfaceInIce,
}

/// What the search keeps of a path.
#[derive(Clone, Debug, Default)]
pub(super) struct Trail {
    view: Option<View>,
    vertex: Vertex,
    /// Arrivals at grains from air before the vertex.
    visits_before: u32,
    last: Option<LastArrival>,
    /// Of the first grain from the camera, the orders that were solved.
    solved_orders: Option<u32>,
    /// Whether the path went from grain to grain through ice since the vertex.
    through_ice: bool,
    /// The light found so far, in the order of the path.
    pub(super) contributions: Vec<Contribution>,
}

#[derive(Clone, Copy, Debug)]
struct LastArrival {
    from: ArrivalFrom,
    direction: DVec3,
}

impl Trail {
    /// For a new path.
    pub(super) fn begin(&mut self, view: Option<View>) {
        let mut contributions = std::mem::take(&mut self.contributions);
        contributions.clear();
        *self = Self { view, contributions, ..Self::default() };
    }

    /// How many grains the path has met since the vertex, of `grain_visits` in all.
    fn order(&self, grain_visits: u32) -> u32 {
        grain_visits - self.visits_before + u32::from(self.vertex == Vertex::SurfaceInIce)
    }
}

/// What the walk tells of a path when the search looks for light.
#[derive(Clone, Copy, Debug)]
pub(super) struct PathState {
    pub(super) key: PathKey,
    pub(super) throughput: [f32; 3],
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
    /// Shadow rays so far.
    pub(super) shadow_rays: u64,
}

/// What a shadow ray brings to the path of a lane if it is clear.
struct Wanted {
    lane: usize,
    contribution: Contribution,
    /// Where it starts, and how far surfaces may hide the light.
    ray: Ray,
    distance: f64,
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
            probes: Probes::new(&world.grid, &world.surfaces, level),
            rays: Vec::new(),
            wanted: Vec::new(),
            shadow_rays: 0,
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
            let direction = direction_of(visit);
            trail.last = Some(LastArrival { from: visit.from, direction });
            trail.through_ice |= visit.from == ArrivalFrom::Ice;
            if order > GRAINS_BEFORE_RANDOM {
                self.at_random_place(visit, direction, &state);
            } else if order == 1 && trail.vertex == Vertex::Camera && visit.from == ArrivalFrom::Air
            {
                self.at_first_grain(visit, trail, &state);
            }
        }
        self.follow_shadow_rays(trails);
    }

    /// Follows the shadow rays that wait, and books what those bring that are clear.
    fn follow_shadow_rays(&mut self, trails: &mut [Trail]) {
        let mut clear = vec![false; self.rays.len()];
        self.probes.follow(&self.rays, |index, answer| clear[index] = answer == ProbeAnswer::Clear);
        self.shadow_rays += self.rays.len() as u64;
        self.rays.clear();
        for (wanted, clear) in self.wanted.drain(..).zip(clear) {
            let surfaces = &self.world.surfaces;
            let hidden = !clear
                || !surfaces.is_empty()
                    && surfaces.intersect(&wanted.ray, wanted.distance, None).is_some();
            if !hidden {
                trails[wanted.lane].contributions.push(wanted.contribution);
            }
        }
    }

    /// How far a probe goes that looks at a light at this distance, quanta.
    fn quanta(&self, metres: f64) -> f32 {
        (metres / self.world.grid.quantum()).min(1e30) as f32
    }
}

fn direction_of(visit: &GrainVisit) -> DVec3 {
    DVec3::from_array(visit.direction.map(f64::from)).normalize()
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
