//! The second grain behind a first one that reflects: few paths are reflected, but what they meet can be bright.
//!
//! One path in twenty or so is reflected by the first grain that it meets. If only those looked for the images of suns
//! that a second grain makes of such light, the few that are found would weigh so much the more. So of all paths that
//! meet a grain one in [`PATHS_PER_LOOK`] looks along the ray that the grain would reflect, and where that meets
//! another one, for images in both, wherever the path itself goes on.

use super::pair_search::PATHS_PER_LOOK;
use super::second_grain::{FirstGrain, solved_orders};
use super::{PathState, Seeker, View, search_key};
use core::slice;
use snowgrain_accel::{GrainVisit, MetGrain, Probe, ProbeAnswer};
use snowgrain_math::sampler::{PathKey, numbers};
use snowgrain_math::{DVec3, Ray};
use snowgrain_optics::Passed;

/// What tells the random number of such a look from others of a search.
const LOOK: u32 = 0x3177_0b5e;

impl Seeker<'_> {
    /// Lets some of the paths that meet a first grain look along the ray that it would reflect, for the images of all
    /// suns in the two grains.
    ///
    /// At once, not with the other paths' looks: what a path finds is added up in the order in which it looks.
    pub(super) fn behind_reflection(&mut self, visit: &GrainVisit, view: &View, state: &PathState) {
        let key = search_key(state.key);
        let key = PathKey { lo: key.lo ^ LOOK, ..key };
        let chosen = f64::from(numbers(key, visit.event)[0]) * PATHS_PER_LOOK < 1.0;
        if !chosen || self.search.suns.is_empty() {
            return;
        }
        let grain = (visit.center, visit.radius);
        let search = self.pair_search(view, (&FirstGrain::new(visit), 0), grain);
        let Some(between) = search.pair.pass_first(&search.pencil, view.image) else { return };
        let Passed { exit, direction, .. } = between.passed;
        let probe = Probe::leaving(&self.world.grid, grain, exit, direction, f32::MAX);
        if let Some(met) = probe.and_then(|probe| self.met_by(&probe)) {
            self.look_for_reflected((visit, view), &met, state);
        }
    }

    /// The grain that a probe meets, where no surface is in the way or crosses it.
    fn met_by(&mut self, probe: &Probe) -> Option<MetGrain> {
        let mut met = None;
        self.probes.follow(slice::from_ref(probe), |_, answer| met = Some(answer));
        let ProbeAnswer::Met { distance, grain } = met? else { return None };
        let (grid, surfaces) = (&self.world.grid, &self.world.surfaces);
        let direction = DVec3::from_array(probe.direction.map(f64::from));
        let ray = Ray::new(grid.world(probe.start), direction);
        let reach = f64::from(distance) * grid.quantum();
        let is_clear = surfaces.is_empty() || surfaces.intersect(&ray, reach, None).is_none();
        (is_clear && !grain.meets_surface).then_some(grain)
    }

    /// Looks for images in the grain that is met behind the reflection in the first one.
    fn look_for_reflected(
        &mut self,
        (at_first, view): (&GrainVisit, &View),
        met: &MetGrain,
        state: &PathState,
    ) {
        let MetGrain { center, radius, stratum, overlaps, meets_surface } = *met;
        let event = at_first.event + 1;
        // As if the path had been reflected.
        let visit =
            GrainVisit { center, radius, stratum, overlaps, meets_surface, event, ..*at_first };
        let first = FirstGrain::new(at_first);
        let search = self.pair_search(view, (&first, 0), (center, radius));
        let Some(between) = search.pair.pass_first(&search.pencil, view.image) else { return };
        for order in 0..=solved_orders(&visit) {
            let search = search.by_chords(order);
            if let Some(began) = search.pair.pass_second(&between) {
                self.look_for_images((&visit, &first), (&search, view), &began, state);
            }
        }
    }
}
