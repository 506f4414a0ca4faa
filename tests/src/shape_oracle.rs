//! The oracle for grains of any shape: light through the union of convex bodies and diffuse surfaces, one
//! interface at a time, every body tested every time.
//!
//! Events and random numbers are those of [`crate::Oracle`].

use crate::account::Account;
use crate::interface::Interface;
use crate::oracle::{OraclePath, PathEnd};
use crate::surfaces::{Hit, OracleSurface, Piece, SurfaceSearch};
use snowgrain_geometry::Shape;
use snowgrain_geometry::shape::{ConvexBody, Interval, SurfacePart};
use snowgrain_math::sampler::PathKey;
use snowgrain_math::{DMat3, DVec3};

/// A grain: a prototype, turned, made as large as the radius of its sphere of equal volume, and moved.
#[derive(Clone, Debug)]
pub struct ShapedGrain {
    /// Where the prototype's origin is.
    pub center: DVec3,
    /// Radius of the sphere of equal volume.
    pub radius: f64,
    /// From the prototype's space.
    pub rotation: DMat3,
    /// The prototype.
    pub shape: Shape,
}

/// A convex part of a grain.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Part {
    grain: usize,
    part: usize,
}

/// The scene.
pub struct ShapeOracle {
    grains: Vec<ShapedGrain>,
    surfaces: SurfaceSearch,
    eta: f64,
}

struct Walk<'a> {
    oracle: &'a ShapeOracle,
    account: Account,
    position: DVec3,
    direction: DVec3,
    /// The ice that the path is in, and how far its end is.
    ice: Option<(Part, f64)>,
    /// The convex part that a stretch in air leaves.
    leaving: Option<Part>,
    leaving_surface: Option<Piece>,
}

impl ShapeOracle {
    /// Grains of index `eta` and surfaces.
    #[must_use]
    pub fn new(grains: Vec<ShapedGrain>, surfaces: &[OracleSurface], eta: f64) -> Self {
        Self { grains, surfaces: SurfaceSearch::new(surfaces), eta }
    }

    /// As [`crate::Oracle::trace`], from a point in air.
    #[must_use]
    pub fn trace(
        &self,
        origin: DVec3,
        direction: DVec3,
        key: PathKey,
        first_event: u32,
    ) -> OraclePath {
        let mut walk = Walk {
            oracle: self,
            account: Account::new(origin, key, first_event),
            position: origin,
            direction,
            ice: None,
            leaving: None,
            leaving_surface: None,
        };
        loop {
            if let Err(end) = walk.step() {
                return OraclePath { end, last_position: walk.position, ..walk.account.path };
            }
        }
    }

    /// Whether a point lies in ice.
    #[must_use]
    pub fn is_ice(&self, point: DVec3) -> bool {
        self.grains.iter().any(|grain| {
            let local = grain.rotation.transpose() * (point - grain.center) / grain.radius;
            grain.shape.contains(local)
        })
    }

    fn body(&self, part: Part) -> (&ShapedGrain, &ConvexBody) {
        let grain = &self.grains[part.grain];
        (grain, &grain.shape.parts()[part.part])
    }

    fn interval(&self, part: Part, origin: DVec3, direction: DVec3) -> Option<Interval> {
        let (grain, body) = self.body(part);
        let back = grain.rotation.transpose();
        let origin = back * (origin - grain.center) / grain.radius;
        let found = body.interval(origin, back * direction)?;
        Some(Interval {
            enter: found.enter * grain.radius,
            leave: found.leave * grain.radius,
            ..found
        })
    }

    fn normal(&self, part: Part, on: SurfacePart, point: DVec3) -> DVec3 {
        let (grain, body) = self.body(part);
        let local = grain.rotation.transpose() * (point - grain.center) / grain.radius;
        grain.rotation * body.normal(on, local)
    }

    /// All parts with the line's intervals in them.
    fn met(&self, origin: DVec3, direction: DVec3) -> impl Iterator<Item = (Part, Interval)> + '_ {
        self.grains.iter().enumerate().flat_map(move |(index, grain)| {
            (0..grain.shape.parts().len()).filter_map(move |number| {
                let part = Part { grain: index, part: number };
                self.interval(part, origin, direction).map(|interval| (part, interval))
            })
        })
    }
}

impl Walk<'_> {
    fn step(&mut self) -> Result<(), PathEnd> {
        match self.ice {
            None => self.step_in_air(),
            Some((part, exit)) => self.step_in_ice(part, exit),
        }
    }

    fn step_in_air(&mut self) -> Result<(), PathEnd> {
        let (o, d) = (self.position, self.direction);
        let surface = self.oracle.surfaces.nearest(o, d, f64::INFINITY, self.leaving_surface);
        let limit = surface.map_or(f64::INFINITY, |hit| hit.t);
        let mut first: Option<(Part, Interval)> = None;
        for (part, interval) in self.oracle.met(o, d) {
            let nearest = first.map_or(limit, |(_, first)| first.enter);
            // What stands on ice lies in other ice by rounding alone, near where it enters or has just left that too.
            let last = match self.leaving {
                Some(_) => 0.5 * (interval.enter + interval.leave),
                None => interval.leave,
            };
            if Some(part) != self.leaving && last > 0.0 && interval.enter < nearest {
                first = Some((part, interval));
            }
        }
        if let Some((part, interval)) = first {
            let t = interval.enter.max(0.0);
            self.account.path.void_length += t;
            self.account.path.grain_visits += 1;
            let point = o + d * t;
            let normal = self.oracle.normal(part, interval.enter_part, point);
            let interface = Interface::new(d, normal, 1.0, self.oracle.eta);
            let passes = self.account.transmits(&interface);
            self.leave(point, if passes { interface.refracted } else { interface.reflected });
            if passes {
                self.account.enter_ice();
                self.enter(part);
            } else {
                self.leaving = Some(part);
            }
            return Ok(());
        }
        let Some(hit) = surface else { return Err(PathEnd::Escaped(d)) };
        self.account.path.void_length += hit.t;
        self.bounce(&hit)
    }

    fn step_in_ice(&mut self, part: Part, exit: f64) -> Result<(), PathEnd> {
        let (o, d) = (self.position, self.direction);
        let mut chain = vec![(part, exit)];
        loop {
            let (current, end) = chain[chain.len() - 1];
            let covers = self.oracle.met(o, d).filter(|(part, interval)| {
                *part != current && interval.enter <= end && end < interval.leave
            });
            match covers.max_by(|a, b| a.1.leave.total_cmp(&b.1.leave)) {
                Some((next, interval)) => chain.push((next, interval.leave)),
                None => break,
            }
        }
        let (last, end) = chain[chain.len() - 1];
        if let Some(hit) = self.oracle.surfaces.nearest(o, d, end, self.leaving_surface) {
            self.account.path.ice_length += hit.t;
            let around =
                chain.into_iter().find(|&(_, t)| hit.t <= t).map_or(last, |(part, _)| part);
            self.bounce(&hit)?;
            self.account.count_turn()?;
            self.enter(around);
            return Ok(());
        }
        self.account.path.ice_length += end;
        let point = o + d * end;
        let on = self.oracle.interval(last, o, d).map_or(SurfacePart::Ellipsoid, |i| i.leave_part);
        let normal = self.oracle.normal(last, on, point);
        let interface = Interface::new(d, -normal, self.oracle.eta, 1.0);
        let passes = self.account.transmits(&interface);
        self.leave(point, if passes { interface.refracted } else { interface.reflected });
        if passes {
            self.ice = None;
            self.leaving = Some(last);
        } else {
            self.account.count_turn()?;
            self.enter(last);
        }
        Ok(())
    }

    /// A stretch in ice of this part begins.
    fn enter(&mut self, part: Part) {
        let interval = self.oracle.interval(part, self.position, self.direction);
        self.ice = Some((part, interval.map_or(0.0, |i| i.leave.max(0.0))));
    }

    fn leave(&mut self, point: DVec3, direction: DVec3) {
        (self.position, self.direction) = (point, direction);
        self.leaving = None;
        self.leaving_surface = None;
    }

    fn bounce(&mut self, hit: &Hit) -> Result<(), PathEnd> {
        let albedo = self.oracle.surfaces.albedo(hit.piece);
        let direction = self.account.reflect_diffusely(albedo, hit.normal)?;
        let point = self.position + self.direction * hit.t;
        self.leave(point, direction);
        self.leaving_surface = Some(hit.piece);
        Ok(())
    }
}
