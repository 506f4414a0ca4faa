//! The second grain that a camera sees, in or through the first: its images of suns, solved exactly.
//!
//! Light comes to a place x of a pixel from a sun by way of grain B, which it passes by q chords, and then of grain A,
//! by p chords. All such light of the pixel is the integral over x of f(x) L(w(x)), with w the direction that the ray
//! of x takes behind both grains, L the sun's radiance there, and f the parts of the light that take the way
//! through each grain, where nothing else is in the way. For a direction w of density g on the sun's disc it is the
//! mean over w of the sum of
//!
//! f(x*) L / (g J(x*))
//!
//! over the places x* with w(x*) = w, J being the solid angle of w(x) by area of the image
//! ([`SpherePair`]).
//!
//! They are found by Newton's steps from where a path began that came to B by way of A after p chords. Its place x is
//! anywhere in a window W around it (as in `first_grain`), it took the p chords with the probability E_p(x), and it
//! is searched with a probability s(x) that falls where its own ray leaves far from the sun
//! ([`PairSearch::probability`]), and many times where it leaves close to it ([`super::pair_search`]). So a place
//! that the steps lead to is divided by the area of W, by which the chance goes that W holds it, and by P, the mean over W of E_p s where rays meet first A and then B and from where the steps
//! lead to the same place, else of 0: in the mean over paths, what stands for it is f L / (g J). The inverse of P is on
//! average the number of random places of W until one is kept, with the probability E_p s, and fulfils that (Zeltner,
//! Georgiev and Jakob 2020, section 4.2), or until k do, over k. To divide by E_p s where the path began instead would
//! let the few that find a place from afar weigh most.
//!
//! Where an image of the sun is large (near caustics J vanishes), more paths begin in it than find it from elsewhere.
//! So each path that came to B is asked besides, for every q, whether its own ray leaves into the sun; that brings
//! f L. Both share the light by the balance heuristic, with the number of either that would be found at x: g J by area
//! of the image for the search, less what it leaves out, and 1 for the ray itself ([`PairSearch::share`]). No
//! such light is left to be met by chance. Where the first grain reflects, other paths than those that it does look
//! for images ([`super::reflected`]).
//!
//! Nothing is known of ways in which grains overlap inside, so the orders are limited as at the first
//! grain; by what ways light comes else it is met by chance ([`super::chance`]): each is either here or there.

use super::pair_search::{Look, PairSearch};
use super::shadow::{Brings, Condition, Wanted};
use super::window::Window;
use super::{
    PathState, SOLVED_ORDERS, SOLVED_ORDERS_OF_OVERLAPPED, Seeker, Sun, Trail, View, product,
    scaled, search_key,
};
use crate::transport::Contribution;
use core::f64::consts::PI;
use snowgrain_accel::{GrainVisit, GridPosition, Probe, ProbeAnswer, STRATA};
use snowgrain_math::sampler::{PathKey, numbers};
use snowgrain_math::{DVec3, Ray};
use snowgrain_optics::{PairPath, Passed, SpherePair, SphereVisit};

/// What tells the random numbers of such a search, and of its trials, from others.
const PAIR: u32 = 0x2b0d_1e55;
const TRIAL: u32 = 0x5ec0_7214;
/// What tells those of one look close by from those of the next, and of a closer one.
const SALT: u32 = 0x9e37_79b9;
const CLOSER: u32 = 0x5bd1_e995;
/// Random events of the place on a sun, of whether what is found is kept, of how often is looked close by, and of the
/// window of such a look; those before are of the searches.
const SUN: u32 = SOLVED_ORDERS + 1;
const KEPT: u32 = SUN + 1;
const CLOSE_BY: u32 = KEPT + 1;
const CLOSE_WINDOW: u32 = CLOSE_BY + 1;
/// Edge of a window in radii of the first grain, where a pixel is not smaller: about as large as the part of the
/// grain behind which the second one is seen.
const WINDOW: f64 = 0.5;
/// Random places of a window that must lead to a solution: one of k adds 1/k to the variance, so k grows with the
/// brightness of an image, from one at this brightness in one search (that of white ground across the sun's
/// light is 1) to the most.
const BRIGHTNESS_PER_SUCCESS: f64 = 0.2;
const MOST_SUCCESSES: f64 = 8.0;
/// Places are the same that are no farther apart than this part of a window.
const SAME: f64 = 1e-5;

/// The first grain that a path met, a sphere of which some orders are solved.
#[derive(Clone, Copy, Debug)]
pub(super) struct FirstGrain {
    pub(super) center: GridPosition,
    pub(super) radius: f32,
    stratum: u8,
    /// Random event of the path before it.
    pub(super) event: u32,
    /// Orders up to which it is solved.
    most: u32,
}

/// The second one, after the first had been passed by a way that can be solved.
#[derive(Clone, Copy, Debug)]
pub(super) struct SecondGrain {
    /// Chords in the first grain.
    pub(super) chords_before: u32,
    /// Orders up to which it is solved.
    pub(super) most: u32,
}

/// Where a search begins.
struct Begins {
    image: [f64; 2],
    window: Window,
    look: Look,
    sun: Sun,
    key: PathKey,
}

/// A way through two grains into a direction, not yet known to be open.
pub(super) struct PairSolution {
    search: PairSearch,
    /// The first grain as it is stored.
    first: (GridPosition, f32),
    window: Window,
    look: Look,
    sun: Sun,
    /// The place on it.
    towards: DVec3,
    path: PairPath,
    /// Random places that must lead to it.
    successes: u32,
    key: PathKey,
}

/// Trials of how often a path finds a solution.
struct Trials<'a> {
    /// Which of the shadow rays it is.
    index: usize,
    solution: &'a PairSolution,
    count: u32,
    successes: u32,
}

impl FirstGrain {
    pub(super) fn new(visit: &GrainVisit) -> Self {
        let &GrainVisit { center, radius, stratum, event, .. } = visit;
        Self { center, radius, stratum, event, most: solved_orders(visit) }
    }
}

/// Lengths in the ice of two grains by the strata that these are of.
fn in_strata(lengths: [(u8, f64); 2]) -> [f64; STRATA] {
    let mut ice_in_strata = [0.0; STRATA];
    for (stratum, length) in lengths {
        if let Some(stratum) = usize::from(stratum).checked_sub(1) {
            ice_in_strata[stratum] += length;
        }
    }
    ice_in_strata
}

/// Orders of a sphere that are solved.
pub(super) fn solved_orders(visit: &GrainVisit) -> u32 {
    if visit.overlaps { SOLVED_ORDERS_OF_OVERLAPPED } else { SOLVED_ORDERS }
}

impl Seeker<'_> {
    /// Looks for the images of all suns that the second grain of a path makes in the first.
    pub(super) fn at_second_grain(
        &mut self,
        visit: &GrainVisit,
        trail: &mut Trail,
        state: &PathState,
    ) {
        let (Some(view), Some(first)) = (trail.view, trail.first_grain) else { return };
        // A reflection outside is one interface, p chords are p + 1.
        let chords_before = visit.event - first.event - 1;
        if trail.through_ice || visit.meets_surface || chords_before > first.most {
            return;
        }
        let &GrainVisit { center, radius, .. } = visit;
        let most = solved_orders(visit);
        trail.second_grain = Some(SecondGrain { chords_before, most });
        let search = self.pair_search(&view, (&first, chords_before), (center, radius));
        let Some(between) = search.pair.pass_first(&search.pencil, view.image) else { return };
        for order in 0..=most {
            let search = search.by_chords(order);
            let Some(began) = search.pair.pass_second(&between) else { continue };
            self.along_own_ray((visit, &first), (&search, &view), began[1].direction, state);
            if chords_before > 0 {
                self.look_for_images((visit, &first), (&search, &view), &began, state);
            }
        }
    }

    /// Looks for the images of all suns by one way through both grains, of which some paths do.
    pub(super) fn look_for_images(
        &mut self,
        grains: (&GrainVisit, &FirstGrain),
        (search, view): (&PairSearch, &View),
        began: &[Passed; 2],
        state: &PathState,
    ) {
        let order = search.pair.visits[1].order;
        let key = search_key(state.key);
        let key = PathKey { lo: key.lo ^ PAIR, ..key };
        let [x, y, chosen] = numbers(key, order).map(f64::from);
        let chosen = chosen * search.paths();
        let image = view.image;
        for &sun in &self.search.suns {
            // Each light and order has random numbers of its own.
            let salt = (sun.light as u32).wrapping_mul(SOLVED_ORDERS + 1) + order;
            let key = PathKey { lo: key.lo.wrapping_add(salt), ..key };
            if chosen < search.probability(began, &sun, Look::Wide) {
                let window = Window::around(image, search.edge, [x, y]);
                let begins = Begins { image, window, look: Look::Wide, sun, key };
                self.towards_sun_by_pair(grains, (search, &begins), state);
            }
            for (how, look) in Look::CLOSE.into_iter().enumerate() {
                let key =
                    PathKey { hi: key.hi.wrapping_add(CLOSER.wrapping_mul(how as u32 + 1)), ..key };
                self.look_close_by(grains, (search, image, look), (began, sun), (key, state));
            }
        }
    }

    /// Lets a path whose ray leaves close to a sun look as often again.
    fn look_close_by(
        &mut self,
        grains: (&GrainVisit, &FirstGrain),
        (search, image, look): (&PairSearch, [f64; 2], Look),
        (began, sun): (&[Passed; 2], Sun),
        (key, state): (PathKey, &PathState),
    ) {
        let looks = search.looks(began, &sun, look);
        if looks == 0.0 {
            return;
        }
        let looks = (looks + f64::from(numbers(key, CLOSE_BY)[0])) as u32;
        for number in 1..=looks {
            let key = PathKey { hi: key.hi.wrapping_add(number.wrapping_mul(SALT)), ..key };
            let [x, y, _] = numbers(key, CLOSE_WINDOW).map(f64::from);
            let window = Window::around(image, search.edge, [x, y]);
            let begins = Begins { image, window, look, sun, key };
            self.towards_sun_by_pair(grains, (search, &begins), state);
        }
    }

    /// What is looked for in a first grain, passed by so many chords, and a second one, by none.
    pub(super) fn pair_search(
        &self,
        view: &View,
        (first, chords): (&FirstGrain, u32),
        second: (GridPosition, f32),
    ) -> PairSearch {
        let grid = &self.world.grid;
        let sphere = |center: GridPosition, radius: f32, order: u32| SphereVisit {
            center: grid.world(center),
            radius: f64::from(radius) * grid.quantum(),
            order,
        };
        let near = sphere(first.center, first.radius, chords);
        let far = sphere(second.0, second.1, 0);
        let radius = near.radius / self.camera.pixel_footprint(self.camera.depth(near.center));
        let edge = self.window_edge(near.center, WINDOW * near.radius);
        PairSearch {
            pencil: self.camera.pencil(view.lens),
            pair: SpherePair { medium: self.search.medium, visits: [near, far] },
            edge,
            edge_radii: edge / radius,
        }
    }

    /// Books the suns into which the ray of a path leaves by one way through both grains, as what is beside the search.
    fn along_own_ray(
        &mut self,
        (visit, first): (&GrainVisit, &FirstGrain),
        (search, view): (&PairSearch, &View),
        direction: DVec3,
        state: &PathState,
    ) {
        let lights = &self.search.lights;
        for sun in &self.search.suns {
            let light = sun.light;
            let radiance = lights.radiance_at_infinity(light, direction);
            if radiance == [0.0; 3] {
                continue;
            }
            let Some(path) = search.pair.follow(&search.pencil, view.image) else { continue };
            let [(_, length_near), (energy, length_far)] =
                [0, 1].map(|sphere: usize| search.pair.part(sphere, &path.passed[sphere]));
            let part = energy * search.share_of_rays(&path, sun);
            let brings = Brings::Light(Contribution {
                slot: lights.slot_of(light),
                glint: true,
                event: visit.event,
                weight: scaled(product(state.throughput, radiance), part),
                ice_length: length_near + length_far,
                ice_in_strata: in_strata([
                    (first.stratum, length_near),
                    (visit.stratum, length_far),
                ]),
            });
            let exit = (path.passed[1].exit, visit.radius);
            self.want(visit, exit, (direction, f64::INFINITY, None), brings, Condition::Nothing);
        }
    }

    /// Looks for an image of one sun by one way through both grains.
    fn towards_sun_by_pair(
        &mut self,
        (visit, first): (&GrainVisit, &FirstGrain),
        (search, begins): (&PairSearch, &Begins),
        state: &PathState,
    ) {
        let (lights, light) = (&self.search.lights, begins.sun.light);
        let random = numbers(begins.key, SUN).map(f64::from);
        let from = search.pair.visits[1].center;
        let Some(sample) = lights.sample_light(light, from, random) else { return };
        let Some(path) = search.solve(begins.image, sample.direction) else { return };
        if !begins.window.contains(path.at) {
            return;
        }
        let [(energy_near, length_near), (energy_far, length_far)] =
            [0, 1].map(|sphere: usize| search.pair.part(sphere, &path.passed[sphere]));
        let share = search.share(&path, &begins.sun, begins.look);
        let shared = energy_near * energy_far * share;
        let density = path.solid_angle() * search.edge * search.edge * sample.pdf;
        let kept = search.kept(&path, &begins.sun, begins.look);
        if f64::from(numbers(begins.key, KEPT)[0]) >= kept {
            return;
        }
        let weight = shared * search.paths() / (kept * density);
        // White ground would send back 1/pi of the light of a sun of 1/pdf sr.
        let brightness = PI * weight * sample.pdf;
        let brings = Brings::Light(Contribution {
            slot: sample.slot,
            glint: true,
            event: visit.event,
            weight: scaled(product(state.throughput, sample.radiance), weight),
            ice_length: length_near + length_far,
            ice_in_strata: in_strata([(first.stratum, length_near), (visit.stratum, length_far)]),
        });
        let solution = PairSolution {
            search: *search,
            first: (first.center, first.radius),
            window: begins.window,
            look: begins.look,
            sun: begins.sun,
            towards: sample.direction,
            path,
            successes: (brightness / BRIGHTNESS_PER_SUCCESS).clamp(1.0, MOST_SUCCESSES) as u32,
            key: PathKey { lo: begins.key.lo ^ TRIAL, ..begins.key },
        };
        let towards = (sample.direction, sample.distance, None);
        let exit = (path.passed[1].exit, visit.radius);
        self.want(visit, exit, towards, brings, Condition::Connects(Box::new(solution)));
    }

    /// Sets the weights of those to 0 whose way through two grains is not open, and divides the others by the
    /// probability with which a path finds them.
    pub(super) fn weigh_pairs(&mut self, wanted: &[Wanted], weights: &mut [f32]) {
        let mut open: Vec<(usize, &PairSolution)> = Vec::new();
        for (index, (wanted, weight)) in wanted.iter().zip(weights.iter()).enumerate() {
            match &wanted.condition {
                Condition::Connects(solution) if *weight > 0.0 => open.push((index, solution)),
                _ => {}
            }
        }
        if open.is_empty() {
            return;
        }
        let ways: Vec<_> = open
            .iter()
            .map(|&(_, solution)| (solution, (solution.path.at, solution.path.passed[0])))
            .collect();
        let mut is_open = self.are_open(&ways).into_iter();
        open.retain(|&(index, _)| {
            let is_open = is_open.next() == Some(true);
            if !is_open {
                weights[index] = 0.0;
            }
            is_open
        });
        let mut open: Vec<_> = open
            .into_iter()
            .map(|(index, solution)| Trials { index, solution, count: 0, successes: 0 })
            .collect();
        while !open.is_empty() {
            let mut ways = Vec::new();
            for trials in &mut open {
                for _ in trials.successes..trials.solution.successes {
                    ways.push((trials.solution, trials.next_start()));
                }
            }
            let mut is_open = self.are_open(&ways).into_iter();
            open.retain_mut(|trials| {
                let wanted = trials.solution.successes;
                let tried = (trials.successes..wanted).len();
                trials.successes += is_open.by_ref().take(tried).map(u32::from).sum::<u32>();
                if trials.successes == wanted {
                    weights[trials.index] = trials.count as f32 / wanted as f32;
                }
                trials.successes < wanted
            });
        }
    }

    /// Whether such rays meet the first grain first, and then the second.
    fn are_open(&mut self, ways: &[(&PairSolution, ([f64; 2], Passed))]) -> Vec<bool> {
        let grid = &self.world.grid;
        let quantum = grid.quantum();
        let mut met = vec![0; ways.len()];
        let (mut probes, mut of_probe) = (Vec::new(), Vec::new());
        for (index, &(solution, (at, passed))) in ways.iter().enumerate() {
            let (origin, direction) = solution.search.pencil.ray(at);
            let ray = Ray::new(origin, direction);
            let Some((t, start)) = grid.enter(&ray) else { continue };
            let leaving =
                Probe::leaving(grid, solution.first, passed.exit, passed.direction, f32::MAX);
            let Some(leaving) = leaving else { continue };
            let [near, far] = solution.search.pair.visits.map(|visit| visit.center);
            probes.extend([Probe::through_air(start, direction, f32::MAX), leaving]);
            let between = Ray::new(grid.world(leaving.start), passed.direction);
            of_probe.extend([(index, near, ray, t), (index, far, between, 0.0)]);
        }
        let surfaces = &self.world.surfaces;
        self.probes.follow(&probes, |probe, answer| {
            let ProbeAnswer::Met { distance, grain: found } = answer else { return };
            let (index, wanted, ray, t) = of_probe[probe];
            let is_it = (grid.world(found.center) - wanted).length_squared() < quantum * quantum;
            let reach = t + f64::from(distance) * quantum;
            if is_it && (surfaces.is_empty() || surfaces.intersect(&ray, reach, None).is_none()) {
                met[index] += 1;
            }
        });
        met.into_iter().map(|met| met == 2).collect()
    }
}

impl Trials<'_> {
    /// The next random place of the window that is kept and from which the search leads to the solution, and how its
    /// ray passes the first grain.
    fn next_start(&mut self) -> ([f64; 2], Passed) {
        let PairSolution { search, window, look, towards, sun, path, key, .. } = self.solution;
        loop {
            let [x, y, chosen] = numbers(*key, self.count).map(f64::from);
            self.count += 1;
            let start = window.at([x, y]);
            let Some(between) = search.pair.pass_first(&search.pencil, start) else { continue };
            let comes = search.comes(&between.passed);
            if chosen >= comes {
                continue;
            }
            let Some(began) = search.pair.pass_second(&between) else { continue };
            if chosen >= comes * search.probability(&began, sun, *look) {
                continue;
            }
            let is_it = search.solve(start, *towards).is_some_and(|found| {
                let apart = [0, 1].map(|axis: usize| (found.at[axis] - path.at[axis]).abs());
                apart[0].max(apart[1]) < SAME * search.edge
            });
            if is_it {
                return (start, between.passed);
            }
        }
    }
}
