//! The nearest of what a ray meets.

use super::triangle::Triangle;
use super::{SurfaceHit, SurfaceId};
use snowgrain_math::Ray;

/// The nearest surface so far.
pub(super) struct Nearest {
    /// Distance of what is held, else the farthest that is asked for.
    limit: f64,
    held: Held,
}

enum Held {
    Nothing,
    Solid(SurfaceHit),
    Triangle(Triangle),
}

impl Nearest {
    /// Nothing yet, and nothing wanted beyond `t_max`.
    #[inline(always)]
    pub(super) fn new(t_max: f64) -> Self {
        Self { limit: t_max, held: Held::Nothing }
    }

    #[inline(always)]
    pub(super) fn limit(&self) -> f64 {
        self.limit
    }

    /// Whether something at this distance comes before what is held: of several at the same
    /// distance the one with the lowest id.
    #[inline(always)]
    pub(super) fn is_met_before(&self, t: f64, id: SurfaceId) -> bool {
        match &self.held {
            Held::Nothing => t <= self.limit,
            Held::Solid(hit) => (t, id) < (self.limit, hit.id),
            Held::Triangle(triangle) => (t, id) < (self.limit, triangle.id),
        }
    }

    #[inline(always)]
    pub(super) fn keep_solid(&mut self, hit: SurfaceHit) {
        self.limit = hit.t;
        self.held = Held::Solid(hit);
    }

    #[inline(always)]
    pub(super) fn keep_triangle(&mut self, t: f64, triangle: &Triangle) {
        self.limit = t;
        self.held = Held::Triangle(*triangle);
    }

    /// What the ray meets first.
    #[inline(always)]
    pub(super) fn hit(self, ray: &Ray) -> Option<SurfaceHit> {
        match self.held {
            Held::Nothing => None,
            Held::Solid(hit) => Some(hit),
            Held::Triangle(triangle) => {
                let normal = triangle.normal();
                let normal = if normal.dot(ray.direction) > 0.0 { -normal } else { normal };
                Some(SurfaceHit { t: self.limit, normal, id: triangle.id })
            }
        }
    }
}
