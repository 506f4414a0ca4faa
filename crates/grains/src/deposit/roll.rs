//! Rolling to a stable rest, without inertia (Visscher & Bolsterli 1972, "Random packing of equal
//! and unequal spheres in two and three dimensions", Nature 239, 504).
//!
//! A grain falls, along the wind where there is one, until it touches. One that touches others moves along the projection of gravity on the directions that none
//! of its contacts forbids. With one contact that holds it, its centre runs along a great circle
//! in the vertical plane through the other centre; with two, along a circle about the axis that
//! joins them; where no direction is left, it rests: its centre lies, in plan, within the triangle
//! of three contacts. Both circles are followed exactly: the angle of the next contact, and the
//! one at which a contact stops pressing, are roots of `p cos t + q sin t = k`.

use super::arc::{Arc, SPEED_MARGIN, TOUCH_MARGIN};
use super::ground::{Ground, GroundContact};
use super::looks::Look;
use super::pile::Lying;
use super::rules::{Drop, Fate, center};
use crate::GrainsError;
use snowgrain_accel::{Fall, GrainSlot, SphereContact};
use snowgrain_geometry::QuantisedGrain;
use snowgrain_math::sampler::{PathKey, pcg3d};
use snowgrain_math::{DVec3, trig};

/// Turns (contacts, releases and falls) after which a grain is left where it is.
const MOST_TURNS: u32 = 400;

/// A sphere that falls and rolls; quanta.
#[derive(Clone, Copy, Debug)]
pub(super) struct RollingSphere {
    /// Its radius where it meets the ground.
    pub(super) to_ground: f64,
    /// Its radius where it meets other grains.
    pub(super) to_grains: f64,
    /// Probability with which it rolls on from a contact, and from the end of each arc, rather than stick
    /// there.
    pub(super) roll: f64,
    /// What decides.
    pub(super) key: PathKey,
}

/// Events of random numbers that belong to the start of a drop.
const FIRST_EVENT: u32 = 1;

impl RollingSphere {
    fn rolls_on(&self, turn: u32) -> bool {
        self.roll >= 1.0 || {
            let word = pcg3d(self.key.lo, self.key.hi, FIRST_EVENT + turn)[0];
            f64::from(word) < self.roll * 4_294_967_296.0
        }
    }
}

/// Where a rolling grain ends.
pub(super) enum Rest {
    Stable(DVec3),
    Unsettled(DVec3),
    TooSteep,
    Missed,
}

impl Rest {
    /// The fate, with the centre turned into a grain by `rounded`.
    pub(super) fn fate(
        self,
        rounded: impl Fn(DVec3) -> Result<QuantisedGrain, GrainsError>,
    ) -> Result<Fate, GrainsError> {
        Ok(match self {
            Self::Stable(center) => Fate::Rests(rounded(center)?),
            Self::Unsettled(center) => Fate::Unsettled(rounded(center)?),
            Self::TooSteep => Fate::TooSteep,
            Self::Missed => Fate::Missed,
        })
    }
}

/// A grain that the rolling one touches.
#[derive(Clone, Copy, Debug)]
struct Contact {
    slot: GrainSlot,
    center: DVec3,
}

/// What a grain does next.
enum Motion {
    Rests,
    Falls,
    /// Rolls over one or two contacts (indices; equal where there is one).
    Rolls {
        over: [usize; 2],
        arc: Arc,
    },
}

/// What ends an arc.
enum End {
    Touches(Contact),
    /// The contact with this index stops pressing.
    Releases(usize),
    Ground,
}

/// Rolls grains, with buffers that are used again.
pub(super) struct Roller<'a> {
    ground: &'a Ground<'a>,
    least_cosine: f64,
    /// Height below which there is nothing to meet.
    lowest: f64,
    contacts: Vec<Contact>,
    neighbours: Vec<(GrainSlot, QuantisedGrain)>,
    /// Grains just rolled off, which a fall that follows at once leaves behind.
    ignored: Vec<GrainSlot>,
    surfaces: Vec<SphereContact>,
    /// Where the last grain looked for others.
    looks: Vec<Look>,
    /// Radius of the sphere that rolls where it meets the ground, quanta.
    to_ground: f64,
}

impl<'a> Roller<'a> {
    pub(super) fn new(drop: &Drop<'a>) -> Self {
        Self {
            ground: drop.ground,
            least_cosine: drop.least_cosine,
            lowest: drop.lowest,
            contacts: Vec::new(),
            neighbours: Vec::new(),
            ignored: Vec::new(),
            surfaces: Vec::new(),
            looks: Vec::new(),
            to_ground: 0.0,
        }
    }

    /// Drops a sphere along x, z and follows it to its rest.
    pub(super) fn settle(
        &mut self,
        lying: &Lying<'_, '_>,
        [x, z]: [f64; 2],
        sphere: RollingSphere,
    ) -> Rest {
        let radius = sphere.to_grains;
        self.to_ground = sphere.to_ground;
        self.contacts.clear();
        self.ignored.clear();
        self.looks.clear();
        let mut at = match self.fall(lying, [x, z], f64::INFINITY, radius) {
            Ok(at) => at,
            Err(end) => return end,
        };
        for turn in 0..MOST_TURNS {
            if !sphere.rolls_on(turn) {
                return Rest::Stable(at);
            }
            match self.motion(at) {
                Motion::Rests => return Rest::Stable(at),
                Motion::Falls => {
                    self.ignored.extend(self.contacts.drain(..).map(|contact| contact.slot));
                    let fallen = if self.ground.leans() {
                        self.fall_straight(lying, at, radius)
                    } else {
                        self.fall(lying, [at.x, at.z], at.y, radius)
                    };
                    at = match fallen {
                        Ok(at) => at,
                        Err(end) => return end,
                    };
                }
                Motion::Rolls { over, arc } => {
                    let (angle, end) = self.end_of(&arc, over, lying, radius);
                    at = arc.at(angle);
                    self.ignored.clear();
                    match end {
                        End::Ground => return Rest::Stable(at),
                        End::Touches(contact) => {
                            self.keep(over);
                            self.contacts.push(contact);
                        }
                        End::Releases(index) => {
                            let kept = if over[0] == index { over[1] } else { over[0] };
                            self.ignored.extend(over.map(|i| self.contacts[i].slot));
                            self.keep([kept; 2]);
                            if kept == index {
                                self.contacts.clear();
                            }
                        }
                    }
                }
            }
        }
        Rest::Unsettled(at)
    }

    /// Where the last grain looked for others.
    pub(super) fn take_looks(&mut self) -> Vec<Look> {
        std::mem::take(&mut self.looks)
    }

    fn keep(&mut self, over: [usize; 2]) {
        let [a, b] = over.map(|index| self.contacts[index]);
        self.contacts.clear();
        self.contacts.push(a);
        if over[0] != over[1] {
            self.contacts.push(b);
        }
    }

    /// Lets the sphere fall on, from height `from`, along the line of fall at this place of the plan;
    /// the error is where that is the end.
    fn fall(
        &mut self,
        lying: &Lying<'_, '_>,
        [x, z]: [f64; 2],
        from: f64,
        radius: f64,
    ) -> Result<DVec3, Rest> {
        let down_to = f64::NEG_INFINITY;
        let fall = Fall { x, z, radius, from, down_to, ignored: &self.ignored };
        let hit = lying.first_contact(&fall);
        let down_to = hit.map_or(down_to, |hit| hit.height);
        let ground = self.ground.drop_sphere(x, z, self.to_ground, [from, down_to]);
        let to = ground.map_or(down_to, |ground| ground.height);
        self.looks.push(Look::Line { place: [x, z], from, to, radius });
        self.land(lying.region.point(x, z, to), ground, hit.map(|hit| (hit.slot, hit.grain)))
    }

    /// Lets the sphere fall straight down from `at`, where lines of fall lean.
    fn fall_straight(
        &mut self,
        lying: &Lying<'_, '_>,
        at: DVec3,
        radius: f64,
    ) -> Result<DVec3, Rest> {
        let ground =
            self.ground.drop_straight(at.x, at.z, self.to_ground, [at.y, f64::NEG_INFINITY]);
        let down_to = ground.map_or(self.lowest, |ground| ground.height);
        match self.look_straight_down(lying, at, radius, down_to) {
            Some((height, slot, grain)) => {
                self.land(DVec3::new(at.x, height, at.z), None, Some((slot, grain)))
            }
            None => self.land(DVec3::new(at.x, down_to, at.z), ground, None),
        }
    }

    /// The first grain that the sphere meets straight below `at`, and the height where it does.
    fn look_straight_down(
        &mut self,
        lying: &Lying<'_, '_>,
        at: DVec3,
        radius: f64,
        down_to: f64,
    ) -> Option<(f64, GrainSlot, QuantisedGrain)> {
        let step = 4.0 * radius;
        let mut top = at.y;
        while top > down_to {
            let middle = DVec3::new(at.x, top - 0.5 * step, at.z);
            self.look_around(lying, middle, 0.5 * step + radius);
            let mut first: Option<(f64, GrainSlot, QuantisedGrain)> = None;
            for &(slot, grain) in &self.neighbours {
                let reach = radius + f64::from(grain.radius);
                let d = center(grain) - at;
                let square = reach * reach - d.x * d.x - d.z * d.z;
                let height = at.y + d.y + square.max(0.0).sqrt();
                let counts = square >= 0.0 && height > down_to && height <= at.y;
                let higher = first.is_none_or(|(held, ..)| height > held);
                if counts && higher && !self.ignored.contains(&slot) {
                    first = Some((height, slot, grain));
                }
            }
            top -= step;
            if let Some(found) = first.filter(|(height, ..)| *height >= top) {
                return Some(found);
            }
        }
        None
    }

    /// Finds the `neighbours` whose surface comes within `reach` of a point.
    fn look_around(&mut self, lying: &Lying<'_, '_>, center: DVec3, reach: f64) {
        self.looks.push(Look::Ball { center, reach });
        self.neighbours.clear();
        lying.near(center, reach, &mut self.neighbours);
    }

    /// What a fall that ended at `at` has met: the ground, a grain, or nothing.
    fn land(
        &mut self,
        at: DVec3,
        ground: Option<GroundContact>,
        hit: Option<(GrainSlot, QuantisedGrain)>,
    ) -> Result<DVec3, Rest> {
        if let Some(ground) = ground {
            let steep = ground.normal.y < self.least_cosine;
            return Err(if steep { Rest::TooSteep } else { Rest::Stable(at) });
        }
        let (slot, grain) = hit.ok_or(Rest::Missed)?;
        self.ignored.clear();
        self.contacts.push(Contact { slot, center: center(grain) });
        Ok(at)
    }

    /// The motion that the contacts leave: the projection of gravity on the directions that lead
    /// into none of them, with at most two contacts pressing.
    fn motion(&self, at: DVec3) -> Motion {
        let normal = |index: usize| (at - self.contacts[index].center).normalize();
        let count = self.contacts.len();
        let allowed = |velocity: DVec3, pressing: [usize; 2]| {
            (0..count).all(|i| pressing.contains(&i) || velocity.dot(normal(i)) >= -SPEED_MARGIN)
        };
        if allowed(DVec3::NEG_Y, [count; 2]) {
            return Motion::Falls;
        }
        for i in 0..count {
            let n = normal(i);
            let velocity = DVec3::NEG_Y + n * n.y;
            if n.y > 0.0 && allowed(velocity, [i; 2]) {
                return self.roll(at, [i; 2], self.contacts[i].center, velocity);
            }
        }
        for i in 0..count {
            for j in i + 1..count {
                let (a, b) = (normal(i), normal(j));
                let c = a.dot(b);
                let determinant = 1.0 - c * c;
                if determinant < 1e-12 {
                    continue;
                }
                let (press_a, press_b) =
                    ((a.y - c * b.y) / determinant, (b.y - c * a.y) / determinant);
                let velocity = DVec3::NEG_Y + a * press_a + b * press_b;
                if press_a > 0.0 && press_b > 0.0 && allowed(velocity, [i, j]) {
                    let from = self.contacts[i].center;
                    let axis = (self.contacts[j].center - from).normalize();
                    let middle = from + axis * (at - from).dot(axis);
                    return self.roll(at, [i, j], middle, velocity);
                }
            }
        }
        Motion::Rests
    }

    fn roll(&self, at: DVec3, over: [usize; 2], middle: DVec3, velocity: DVec3) -> Motion {
        let arm = at - middle;
        let radius = arm.length();
        let u = arm / radius;
        let tangent = velocity - u * velocity.dot(u);
        let speed = tangent.length();
        // Balanced on top to within rounding: no direction is better than another.
        if speed < SPEED_MARGIN || radius < TOUCH_MARGIN {
            return Motion::Rests;
        }
        Motion::Rolls { over, arc: Arc { center: middle, radius, u, v: tangent / speed } }
    }

    /// How far along `arc` the sphere gets, and what stops it.
    fn end_of(
        &mut self,
        arc: &Arc,
        over: [usize; 2],
        lying: &Lying<'_, '_>,
        radius: f64,
    ) -> (f64, End) {
        let (mut angle, mut end) = self.release(arc, over);
        let (middle, half_width) = arc.ball_around(angle);
        self.look_around(lying, middle, half_width + radius);
        for &(slot, grain) in &self.neighbours {
            let other = center(grain);
            let rolled_over =
                |&i: &usize| self.contacts[i].slot == slot && self.contacts[i].center == other;
            if over.iter().any(rolled_over) {
                continue;
            }
            if let Some(touch) = arc.meets(other, radius + f64::from(grain.radius))
                && touch < angle
            {
                (angle, end) = (touch, End::Touches(Contact { slot, center: other }));
            }
        }
        if let Some(touch) = self.meets_ground(arc, angle) {
            (angle, end) = (touch, End::Ground);
        }
        (angle, end)
    }

    /// Where the first of the contacts rolled over stops pressing.
    fn release(&self, arc: &Arc, over: [usize; 2]) -> (f64, End) {
        let at = arc.at(0.0);
        let [a, b] = over.map(|i| (at - self.contacts[i].center).normalize());
        if over[0] == over[1] {
            return (arc.sinks(a), End::Releases(over[0]));
        }
        let c = a.dot(b);
        let (first, second) = (arc.sinks(a - b * c), arc.sinks(b - a * c));
        if first <= second {
            (first, End::Releases(over[0]))
        } else {
            (second, End::Releases(over[1]))
        }
    }

    /// First angle up to `until` at which the sphere meets the ground.
    fn meets_ground(&mut self, arc: &Arc, until: f64) -> Option<f64> {
        let radius = self.to_ground;
        if let Some(floor) = self.ground.floor() {
            // The centre sinks to floor + radius.
            let above = arc.center.y - floor - radius;
            let (p, q) = (arc.u.y * arc.radius, arc.v.y * arc.radius);
            let amplitude = (p * p + q * q).sqrt();
            if above.abs() >= amplitude {
                return None;
            }
            let angle = trig::atan2(q, p) + trig::acos(-above / amplitude);
            let angle = angle.rem_euclid(core::f64::consts::TAU);
            return (angle <= until).then_some(angle);
        }
        let (middle, half_width) = arc.ball_around(until);
        if !self.ground.surface_within(middle, half_width + radius, &mut self.surfaces) {
            return None;
        }
        // Solid surfaces have no closed form: short steps, then bisection to within a quantum.
        let steps = (until * arc.radius / (radius / 8.0)).ceil().max(1.0);
        let mut free = 0.0;
        for step in 1..=steps as u32 {
            let angle = until * f64::from(step) / steps;
            if self.ground.surface_within(arc.at(angle), radius, &mut self.surfaces) {
                return Some(self.last_free(arc, free, angle, radius));
            }
            free = angle;
        }
        None
    }

    fn last_free(&mut self, arc: &Arc, mut free: f64, mut touching: f64, radius: f64) -> f64 {
        while (touching - free) * arc.radius > 0.25 {
            let middle = (free + touching) * 0.5;
            if self.ground.surface_within(arc.at(middle), radius, &mut self.surfaces) {
                touching = middle;
            } else {
                free = middle;
            }
        }
        free
    }
}
