//! Paths in ice: along a chord, on into the next grain where ice goes on, out or back where it ends.

use super::body::{interval, left, may_hold};
use super::interface::Interface;
use super::lane::{BodyPart, Inside};
use super::near::{self, Window, near};
use super::{SURFACE_FIRST, ShapeFlight, passes};
use crate::flight::{ArrivalFrom, FlightEvent, MAX_TURNS_IN_ICE};
use crate::grain_grid::{MEETS_SURFACE, OVERLAPS};
use fearless_simd::prelude::*;

impl ShapeFlight<'_> {
    /// Follows a path in ice for as long as what its cells hold is known: from the origin of a stretch that stands on
    /// the part `on` of the surface of its body or, without one, from the end of a chord.
    #[inline(always)]
    pub(super) fn go_on_in_ice<S: Simd>(&mut self, simd: S, index: usize, mut on: Option<u16>) {
        loop {
            if let Some(on) = on
                && !self.begin_chord(index, on)
            {
                return;
            }
            let lane = &mut self.lanes[index];
            if lane.inside.overlaps {
                lane.seek_cell(&self.cells, lane.inside.leave);
                if lane.cell != lane.entry_of {
                    self.wait_in_ice(index);
                    return;
                }
                if let Some(next) = self.farthest_cover(simd, index) {
                    let lane = &mut self.lanes[index];
                    lane.count_ice(lane.inside.leave);
                    lane.travelled = lane.inside.leave;
                    let (from, at) = (lane.inside.body, lane.travelled);
                    // From part to part of one grain it does not arrive.
                    if (from.center, from.word) != (next.body.center, next.body.word) {
                        self.note(index, ArrivalFrom::Ice, &next, at);
                    }
                    let lane = &mut self.lanes[index];
                    lane.inside = next;
                    if next.meets_surface && self.meets_surface_in_ice(index) {
                        return;
                    }
                    on = None;
                    continue;
                }
            }
            on = self.turn(index);
            if on.is_none() {
                return;
            }
        }
    }

    /// From the origin of a stretch to the end of the chord in its body, unless a surface is met before.
    #[inline(always)]
    pub(super) fn begin_chord(&mut self, index: usize, on: u16) -> bool {
        let shapes = self.shapes;
        let lane = &mut self.lanes[index];
        let Inside { body, placement, .. } = lane.inside;
        let part = &shapes.of(&placement).parts[usize::from(body.part)];
        let ray = lane.ray_to(body.center, &placement);
        let (leave, through) = left(part, &ray, on);
        (lane.inside.leave, lane.inside.through) = (leave * placement.radius, through);
        !(lane.inside.meets_surface && self.meets_surface_in_ice(index))
    }

    /// Of the bodies that hold the end of the chord (their interval begins before or there and ends
    /// behind), the one that is left last.
    #[inline(always)]
    pub(super) fn farthest_cover<S: Simd>(&self, simd: S, index: usize) -> Option<Inside> {
        let lane = &self.lanes[index];
        let end = lane.inside.leave;
        let position = lane.local(end).to_array().map(|x| x as f32);
        let direction = lane.direction.to_array().map(|x| x as f32);
        let mut best: Option<Inside> = None;
        for number in lane.entry.blocks() {
            let block = &self.grid.blocks()[number];
            let window = Window { begins: true, last: 0.0 };
            let near = near(simd, block, (position, direction), window, near::NOWHERE);
            let mut slots = near.to_bitmask() as u32;
            while slots != 0 {
                let slot = slots.trailing_zeros() as usize & 15;
                slots &= slots - 1;
                let center = self.center(lane, number, slot);
                let own = lane.inside.body;
                if center == own.center && self.is_alone(&lane.inside) {
                    continue;
                }
                let word = self.shapes.blocks[number][slot];
                let placement = self.shapes.placement(word, block.radius[slot]);
                let radius = placement.radius;
                let parts = &self.shapes.of(&placement).parts;
                let point = placement.to_prototype(lane.origin + lane.direction * end - center);
                for (at, part) in parts.iter().enumerate() {
                    let body = BodyPart { center, radius, word, part: at as u16 };
                    if body == own || !may_hold(part, point) {
                        continue;
                    }
                    let ray = lane.ray_to(center, &placement);
                    let Some(ends) = interval(part, &ray) else { continue };
                    let [enter, leave] = ends.map(|t| t * placement.radius);
                    let holds = enter <= end && end < leave;
                    if holds && best.is_none_or(|best| leave > best.leave) {
                        let flags = block.radius[slot];
                        best = Some(Inside {
                            body,
                            placement,
                            leave,
                            through: left(part, &ray, super::body::NOWHERE).1,
                            meets_surface: flags & MEETS_SURFACE != 0,
                            overlaps: flags & OVERLAPS != 0 || parts.len() > 1,
                            stratum: self.stratum(number, slot),
                        });
                    }
                }
            }
        }
        best
    }

    /// Whether no other body has the centre of the one that a path is in, as far as is known without looking.
    #[inline(always)]
    fn is_alone(&self, inside: &Inside) -> bool {
        !self.shapes.concentric && self.shapes.of(&inside.placement).parts.len() == 1
    }

    /// At an interface from within: out (`None`, as where the path is trapped), or reflected, standing on the
    /// part of the surface that is given, at the origin of a new stretch.
    #[inline(always)]
    fn turn(&mut self, index: usize) -> Option<u16> {
        let (shapes, eta, cells) = (self.shapes, self.eta, &self.cells);
        let lane = &mut self.lanes[index];
        let end = lane.inside.leave;
        lane.count_ice(end);
        lane.travelled = end;
        if lane.turns > MAX_TURNS_IN_ICE {
            self.stop(index, FlightEvent::Trapped);
            return None;
        }
        let interface = Interface::new(lane.direction, -lane.outward(shapes), eta);
        if passes(lane, &interface) {
            lane.begin_stretch(cells, end, interface.refracted());
            lane.leaving = Some(lane.inside.body);
            self.go_on_in_air(index);
            return None;
        }
        lane.begin_stretch(cells, end, interface.reflected());
        lane.turns += 1;
        Some(lane.inside.through)
    }

    /// Whether the chord meets a surface, at which the path then stands.
    #[inline(never)]
    fn meets_surface_in_ice(&mut self, index: usize) -> bool {
        let grid = self.grid;
        let surfaces = self.surfaces;
        let lane = &mut self.lanes[index];
        let reach = (lane.inside.leave + SURFACE_FIRST) * grid.quantum();
        let ray = lane.stretch(grid);
        let Some(hit) = surfaces.intersect(&ray, reach, lane.left_surface) else { return false };
        let at = hit.t / grid.quantum();
        lane.count_ice(at);
        lane.travelled = at;
        lane.turns += 1;
        self.stop(index, FlightEvent::Surface(hit));
        true
    }
}
