//! Paths that arrive deep in the snow.

use super::{Search, Walk};
use crate::transport::deep::Deep;
use crate::transport::ice::IceLength;
use crate::transport::medium::{Looking, ProxyInDepth};
use crate::transport::{Learnt, PathEnd, PathSource};
use snowgrain_accel::GrainVisit;
use snowgrain_accel::flight::Travelled;
use snowgrain_math::Ray;

impl<Tag: Copy> Walk<'_, Tag> {
    /// Lets a path that arrives deep in the snow go on among grains that are met at random, until it comes back to the
    /// real ones.
    pub(super) fn go_deep(&mut self, proxy: &ProxyInDepth, visit: &GrainVisit) {
        let (lane, grid) = (visit.lane, &self.world.grid);
        let travelled = self.flight.travelled(lane);
        let first_hit = self.first_hit(lane);
        let walker = self.walkers[lane].as_mut().expect("a lane with an event has a walker");
        let in_strata = visit.ice_in_strata.map(|length| f64::from(length) * grid.quantum());
        let ice = IceLength { all: f64::from(visit.ice_length) * grid.quantum(), in_strata };
        let mut found = Vec::new();
        let looking = self.search.is_some().then_some(Looking {
            throughput: walker.throughput,
            ice_before: walker.before.ice + ice,
            found: &mut found,
        });
        let emerged = proxy.follow(self.world, walker.key, visit, looking);
        walker.first_hit = first_hit;
        let grain_visits = visit.grain_visits + emerged.grain_visits;
        let events = visit.event - walker.start_event;
        let before = &mut walker.before;
        before.ice += ice + emerged.ice;
        before.air_length += travelled.air_length;
        before.grain_visits += grain_visits;
        before.interface_events += events + 2 * (emerged.grain_visits + 1);
        if let Some(Search { seeker, trails }) = &mut self.search {
            seeker.above_deep(lane, found, trails);
            trails[lane].emerge(grain_visits, emerged.looked);
        }
        walker.start_event = emerged.event;
        self.flight.launch(lane, walker.key, emerged.event);
        let Ray { origin, direction } = emerged.ray;
        self.flight.enter(lane, grid.locate(origin), direction, None);
    }

    /// Ends a path that arrives deep in the snow with what others brought from there.
    pub(super) fn finish_deep<Source: PathSource<Tag = Tag>>(
        &mut self,
        visit: &GrainVisit,
        source: &mut Source,
    ) {
        let quantum = self.world.grid.quantum();
        let travelled = Travelled {
            ice_length: f64::from(visit.ice_length) * quantum,
            grain_visits: visit.grain_visits,
            event: visit.event,
            ..self.flight.travelled(visit.lane)
        };
        let in_strata = visit.ice_in_strata.map(|length| f64::from(length) * quantum);
        let end = PathEnd::Deep(Learnt::default());
        let (walker, mut result) = self.result(visit.lane, end, travelled, in_strata);
        let Some(Deep::HandOver(field)) = &self.deep else { return };
        let found = match &mut self.search {
            Some(search) => &mut search.trails[visit.lane].contributions,
            None => {
                self.found.clear();
                &mut self.found
            }
        };
        let first = found.len();
        let relative_error = field.outcome(visit, walker.throughput, quantum, found);
        result.end = PathEnd::Deep(Learnt { first, relative_error });
        source.finish_with_light(walker.tag, &result, found);
    }
}
