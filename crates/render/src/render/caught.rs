//! Samples that met a shadow catcher first, and what it would show alone.

use super::batch::Batch;
use super::camera_path::CameraPath;
use crate::transport::seek::Seeker;
use crate::transport::{Contribution, NewPath, PathEnd, PathResult, PathSource, trace_with};
use crate::{RenderError, Scene};
use snowgrain_accel::SimdLevel;

/// A sample that met a shadow catcher first.
#[derive(Clone, Copy)]
pub(super) struct Caught {
    pub(super) pixel: (u32, u32),
    pub(super) sample: u64,
    /// Radiance that the catcher shows, and that it would show alone.
    pub(super) lit: [f32; 3],
    pub(super) unoccluded: [f32; 3],
}

/// Finds what the catchers would show alone to a band of wavelengths, by paths of the same random numbers as those that met them.
///
/// # Errors
/// Light that is enclosed.
pub(super) fn find_unoccluded(
    scene: &Scene,
    (band, level): (usize, SimdLevel),
    caught: &mut [Caught],
) -> Result<(), RenderError> {
    let Some(alone) = scene.catchers_alone.as_deref() else { return Ok(()) };
    let mut paths =
        Paths { alone, band, caught, next: 0, scratch: Batch::default(), enclosed: None };
    let (eta, search) = alone.optics_of(band);
    let seeker = search.map(|search| Seeker::new(&alone.world, &alone.camera, search, level));
    trace_with((&alone.world, eta), level, (seeker, None), &mut paths);
    match paths.enclosed {
        Some((x, y)) => Err(RenderError::Enclosed { x, y }),
        None => Ok(()),
    }
}

struct Paths<'a> {
    alone: &'a Scene,
    band: usize,
    caught: &'a mut [Caught],
    next: usize,
    scratch: Batch,
    enclosed: Option<(u32, u32)>,
}

impl PathSource for Paths<'_> {
    type Tag = usize;

    fn next_path(&mut self) -> Option<NewPath<usize>> {
        let tag = self.next;
        let Caught { pixel, sample, .. } = *self.caught.get(tag)?;
        self.next += 1;
        let CameraPath { ray, key, event, .. } = CameraPath::of(self.alone, pixel, sample);
        Some(NewPath { tag, ray, key, event })
    }

    fn finish(&mut self, tag: usize, path: &PathResult) {
        self.finish_with_light(tag, path, &[]);
    }

    fn finish_with_light(&mut self, tag: usize, path: &PathResult, found: &[Contribution]) {
        let caught = &mut self.caught[tag];
        if path.end == PathEnd::Enclosed {
            self.enclosed.get_or_insert(caught.pixel);
        }
        caught.unoccluded =
            self.scratch.add_light((self.alone, self.band), caught.pixel, path, found);
    }
}
