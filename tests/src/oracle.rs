//! Light through the union of balls of ice and diffuse surfaces, one interface at a time.

use crate::account::Account;
use crate::ball::Ball;
use crate::interface::Interface;
use crate::search::{GrainSearch, Search};
use crate::surfaces::{Hit, OracleSurface, Piece, SurfaceSearch};
use snowgrain_geometry::Grain;
use snowgrain_math::DVec3;
use snowgrain_math::sampler::PathKey;

/// The scene: the ice is the union of all balls, surfaces are met in air and in ice alike.
pub struct Oracle {
    grains: GrainSearch,
    surfaces: SurfaceSearch,
    eta: f64,
}

/// What became of a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PathEnd {
    /// It left along this unit direction.
    Escaped(DVec3),
    /// A surface took the rest: albedo zero, or roulette.
    Absorbed,
    /// It made [`Oracle::TURNS_BEFORE_TRAPPED`] turns in one stretch of ice.
    Trapped,
}

/// A finished path. Lengths in the unit of the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OraclePath {
    /// How it ended.
    pub end: PathEnd,
    /// Where its last stretch began (where it escaped from).
    pub last_position: DVec3,
    /// Product of albedos and roulette weights; 1 where no surface was met.
    pub throughput: DVec3,
    /// Length in ice.
    pub ice_length: f64,
    /// Length in air up to the last event (the stretch of an escape is endless).
    pub void_length: f64,
    /// Fresnel decisions, total internal reflections included.
    pub interface_events: u32,
    /// Arrivals at ice from air.
    pub grain_visits: u32,
    /// Hits of diffuse surfaces.
    pub diffuse_bounces: u32,
}

impl OraclePath {
    /// The unit direction of escape, `None` where the path was absorbed or trapped.
    #[must_use]
    pub fn escaped_direction(&self) -> Option<DVec3> {
        match self.end {
            PathEnd::Escaped(direction) => Some(direction),
            PathEnd::Absorbed | PathEnd::Trapped => None,
        }
    }
}

/// The closed set of things that turn a path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EventKind {
    /// From air into ice.
    Enter,
    /// Off ice, back into air.
    ReflectOutside,
    /// Off the surface of ice, back into ice.
    ReflectInside,
    /// From ice into air.
    Leave,
    /// Off a diffuse surface in air.
    DiffuseInAir,
    /// Off a diffuse surface inside ice.
    DiffuseInIce,
}

/// One event of a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Event {
    /// What happened.
    pub kind: EventKind,
    /// Where.
    pub position: DVec3,
    /// Unit direction afterwards.
    pub direction: DVec3,
    /// Index of the grain, or of the diffuse object.
    pub body: usize,
}

/// Where the light is; in ice, in which ball and how far from its exit.
#[derive(Clone, Copy, Debug)]
enum Medium {
    Air,
    Ice { ball: Ball, exit: f64 },
}

/// A path on its way.
struct Walk<'a> {
    oracle: &'a Oracle,
    account: Account,
    position: DVec3,
    direction: DVec3,
    medium: Medium,
    /// The surface piece that the ray starts on.
    leaving: Option<Piece>,
}

impl Oracle {
    /// Turns within one stretch of ice after which a path counts as trapped: a guard against
    /// errors, far above what light needs, not a cap on bounces.
    pub const TURNS_BEFORE_TRAPPED: u32 = 100_000;

    /// Roulette begins where the largest component of the throughput falls below this.
    pub const ROULETTE_BELOW: f64 = 0.1;

    /// A scene of grains with index of refraction `eta` (>= 1) and surfaces.
    ///
    /// # Panics
    /// If the grains are periodic and there are surfaces (which are not).
    #[must_use]
    pub fn new(grains: &[Grain], surfaces: &[OracleSurface], eta: f64, search: Search) -> Self {
        let grains = GrainSearch::new(grains, search);
        assert!(grains.period().is_none() || surfaces.is_empty(), "surfaces do not repeat");
        Self { grains, surfaces: SurfaceSearch::new(surfaces), eta }
    }

    /// Follows the light that starts at `origin` along the unit `direction` to its end; its first
    /// event takes the numbers of event `first_event` of `key`. A start strictly inside a grain is
    /// a start in ice.
    #[must_use]
    pub fn trace(
        &self,
        origin: DVec3,
        direction: DVec3,
        key: PathKey,
        first_event: u32,
    ) -> OraclePath {
        self.trace_observed(origin, direction, key, first_event, |_| ())
    }

    /// [`Self::trace`], with the events of the path in order. In periodic snow positions are
    /// those in the first period.
    #[must_use]
    pub fn trace_events(
        &self,
        origin: DVec3,
        direction: DVec3,
        key: PathKey,
        first_event: u32,
    ) -> (OraclePath, Vec<Event>) {
        let mut events = Vec::new();
        let path =
            self.trace_observed(origin, direction, key, first_event, |event| events.push(event));
        (path, events)
    }

    fn trace_observed(
        &self,
        origin: DVec3,
        direction: DVec3,
        key: PathKey,
        first_event: u32,
        mut observe: impl FnMut(Event),
    ) -> OraclePath {
        let mut walk = Walk::new(self, origin, direction, key, first_event);
        loop {
            match walk.step() {
                Ok(event) => observe(event),
                Err(end) => return OraclePath { end, ..walk.account.path },
            }
        }
    }

    /// Whether `point` lies strictly inside a grain.
    #[must_use]
    pub fn is_ice(&self, point: DVec3) -> bool {
        self.grains.holding(point).is_some()
    }

    /// The balls crossed by a ray in `ball`, each with the distance at which it is left for the
    /// next: while the end of one lies in another, the way goes on to the farthest such end.
    fn chain(&self, origin: DVec3, direction: DVec3, ball: Ball, exit: f64) -> Vec<(f64, Ball)> {
        let mut chain = vec![(exit, ball)];
        let (mut exit, mut ball) = (exit, ball);
        while let Some(next) = self.grains.farthest_cover(origin, direction, exit, &ball) {
            chain.push(next);
            (exit, ball) = next;
        }
        chain
    }
}

impl<'a> Walk<'a> {
    fn new(
        oracle: &'a Oracle,
        position: DVec3,
        direction: DVec3,
        key: PathKey,
        first_event: u32,
    ) -> Self {
        let mut walk = Self {
            oracle,
            account: Account::new(position, key, first_event),
            position,
            direction,
            medium: Medium::Air,
            leaving: None,
        };
        walk.move_to(position);
        if let Some(ball) = oracle.grains.holding(walk.position) {
            walk.medium = Medium::Ice { ball, exit: ball.exit(walk.position, direction) };
        }
        walk
    }

    /// The next event, or the end of the path.
    fn step(&mut self) -> Result<Event, PathEnd> {
        match self.medium {
            Medium::Air => self.step_in_air(),
            Medium::Ice { ball, exit } => self.step_in_ice(ball, exit),
        }
    }

    fn step_in_air(&mut self) -> Result<Event, PathEnd> {
        let (o, d) = (self.position, self.direction);
        let surface = self.oracle.surfaces.nearest(o, d, f64::INFINITY, self.leaving);
        let limit = surface.map_or(f64::INFINITY, |hit| hit.t);
        if let Some((t, ball)) = self.oracle.grains.first_entry(o, d, limit) {
            self.account.path.void_length += t;
            return Ok(self.arrive_from_air(ball, t));
        }
        let Some(hit) = surface else { return Err(PathEnd::Escaped(d)) };
        self.account.path.void_length += hit.t;
        let event = self.bounce(&hit, EventKind::DiffuseInAir)?;
        Ok(event)
    }

    fn step_in_ice(&mut self, ball: Ball, exit: f64) -> Result<Event, PathEnd> {
        let (o, d) = (self.position, self.direction);
        let chain = self.oracle.chain(o, d, ball, exit);
        let (end, last) = chain[chain.len() - 1];
        if let Some(hit) = self.oracle.surfaces.nearest(o, d, end, self.leaving) {
            let (_, around) = chain.into_iter().find(|&(t, _)| hit.t <= t).unwrap_or((end, last));
            self.account.path.ice_length += hit.t;
            self.account.count_turn()?;
            let event = self.bounce(&hit, EventKind::DiffuseInIce)?;
            let exit = around.exit(o + d * hit.t, self.direction);
            self.medium = Medium::Ice { ball: around, exit };
            return Ok(event);
        }
        self.account.path.ice_length += end;
        self.arrive_from_ice(last, end)
    }

    fn arrive_from_air(&mut self, ball: Ball, t: f64) -> Event {
        let point = ball.on_surface(self.position + self.direction * t);
        let normal = ball.normal(point);
        let interface = Interface::new(self.direction, normal, 1.0, self.oracle.eta);
        self.account.path.grain_visits += 1;
        let kind = if self.account.transmits(&interface) {
            self.direction = interface.refracted;
            self.account.enter_ice();
            self.medium = Medium::Ice { ball, exit: ball.chord(point, self.direction) };
            EventKind::Enter
        } else {
            self.direction = interface.reflected;
            EventKind::ReflectOutside
        };
        self.leave_interface(kind, point, ball)
    }

    fn arrive_from_ice(&mut self, ball: Ball, t: f64) -> Result<Event, PathEnd> {
        let point = ball.on_surface(self.position + self.direction * t);
        let normal = ball.normal(point);
        let interface = Interface::new(self.direction, -normal, self.oracle.eta, 1.0);
        let kind = if self.account.transmits(&interface) {
            self.direction = interface.refracted;
            self.medium = Medium::Air;
            EventKind::Leave
        } else {
            self.account.count_turn()?;
            self.direction = interface.reflected;
            self.medium = Medium::Ice { ball, exit: ball.chord(point, self.direction) };
            EventKind::ReflectInside
        };
        Ok(self.leave_interface(kind, point, ball))
    }

    fn leave_interface(&mut self, kind: EventKind, point: DVec3, ball: Ball) -> Event {
        self.leaving = None;
        self.move_to(point);
        Event { kind, position: self.position, direction: self.direction, body: ball.grain }
    }

    /// A diffuse reflection; the medium stays.
    fn bounce(&mut self, hit: &Hit, kind: EventKind) -> Result<Event, PathEnd> {
        let albedo = self.oracle.surfaces.albedo(hit.piece);
        let direction = self.account.reflect_diffusely(albedo, hit.normal)?;
        self.move_to(self.position + self.direction * hit.t);
        self.direction = direction;
        self.leaving = Some(hit.piece);
        let body = hit.piece.object;
        Ok(Event { kind, position: self.position, direction: self.direction, body })
    }

    /// Moves to `point`; in periodic snow to its twin in the first period, with the ball around.
    fn move_to(&mut self, point: DVec3) {
        let mut shift = DVec3::ZERO;
        if let Some([x, z]) = self.oracle.grains.period() {
            shift = DVec3::new((point.x / x).floor() * x, 0.0, (point.z / z).floor() * z);
        }
        self.position = point - shift;
        self.account.path.last_position = self.position;
        if let Medium::Ice { ball, .. } = &mut self.medium {
            ball.center -= shift;
        }
    }
}
