//! Counts of what light did.

use crate::transport::PathResult;

/// Counts over many paths; adding is exact, so they do not depend on threads.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Statistics {
    /// Paths traced.
    pub paths: u64,
    /// Paths that met at least one grain.
    pub paths_in_snow: u64,
    /// Fresnel decisions between air and ice.
    pub interface_events: u64,
    /// Arrivals at grains from air.
    pub grain_visits: u64,
    /// Diffuse bounces off objects.
    pub surface_bounces: u64,
    /// Paths that the guard against endless circling in ice let out.
    pub trapped_paths: u64,
    /// Straight stretches: one from the start, one after every interface and bounce.
    pub rays: u64,
}

impl Statistics {
    /// Counts one path.
    pub fn count(&mut self, path: &PathResult) {
        self.paths += 1;
        self.paths_in_snow += u64::from(path.grain_visits > 0);
        self.interface_events += u64::from(path.interface_events);
        self.grain_visits += u64::from(path.grain_visits);
        self.surface_bounces += u64::from(path.surface_bounces);
        self.trapped_paths += u64::from(path.releases > 0);
        self.rays += 1 + u64::from(path.interface_events) + u64::from(path.surface_bounces);
    }

    /// Adds the counts of other paths.
    pub fn add(&mut self, other: &Self) {
        self.paths += other.paths;
        self.paths_in_snow += other.paths_in_snow;
        self.interface_events += other.interface_events;
        self.grain_visits += other.grain_visits;
        self.surface_bounces += other.surface_bounces;
        self.trapped_paths += other.trapped_paths;
        self.rays += other.rays;
    }
}
