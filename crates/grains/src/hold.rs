//! Grains of shapes that hold on to each other.
//!
//! Snow falls and is packed as spheres that touch. As the shapes that they are, turned at random, some grains reach no
//! other, and float. Those are turned anew, as often as it takes, until they touch one that is held; where that does not
//! help, as spheres look alike from all sides, one that is held is turned to touch them, if it lets go of nothing. The others
//! stay as they are. What hangs together is a set of spheres that do: the largest part of each set holds the rest.

use crate::measures::TOUCH_TOLERANCE_QUANTA;
use crate::measures::bodies::Body;
use crate::measures::buckets::Buckets;
use crate::measures::meeting::meet;
use crate::{FieldShapes, GrainField};
use rayon::prelude::*;
use snowgrain_geometry::{GrainShape, QuantisedGrain};
use snowgrain_math::DVec3;
use std::sync::Arc;

/// Turns of a grain in each of so many rounds: what holds it may itself be turned meanwhile.
const TURNS: u32 = 16;
const ROUNDS: u32 = 8;

/// A neighbour: its index, and where it lies as seen from the grain.
type Near = (u32, DVec3);

/// Turns grains of `field`, which repeats with these periods along x, y and z (quanta; 0 where it does not), until
/// what hangs together as spheres does as the shapes that they are, as far as turning goes. `turned` gives the grain of a
/// number turned for the so manieth time, the first being 1; `None` for one that must stay as it is. A pure function of
/// its arguments.
pub fn turned_to_touch(
    field: GrainField,
    period: [i64; 3],
    turned: impl Fn(usize, QuantisedGrain, u32) -> Option<GrainShape> + Sync,
) -> GrainField {
    let Some(FieldShapes { prototypes, .. }) = field.shapes() else { return field };
    let prototypes = Arc::clone(prototypes);
    let buckets = Buckets::repeating(&field, period);
    let mut holding = Holding::new(buckets);
    for round in 0..ROUNDS {
        let before = holding.floating();
        if before == 0 {
            break;
        }
        for index in 0..holding.held.len() {
            if holding.held[index] {
                continue;
            }
            let turn = |index: usize, turn: u32| {
                let (number, grain) = (holding.buckets.number(index), holding.grain(index));
                turned(number, grain, round * TURNS + turn + 1)
            };
            let own = holding.shape_that_touches(index, turn).map(|shape| (index, shape));
            if let Some((which, shape)) = own.or_else(|| holding.holder_that_touches(index, turn)) {
                holding.buckets.turn(which, shape);
                holding.hold(which);
            }
        }
        if holding.floating() == before {
            break;
        }
    }
    let of_grains = holding.buckets.shapes_in_order_of_field();
    field.with_shapes(FieldShapes { prototypes, of_grains })
}

/// Which grains are held.
struct Holding {
    buckets: Buckets,
    /// Of each grain those whose spheres it touches, or whose bodies it may meet.
    near: Vec<Vec<Near>>,
    held: Vec<bool>,
}

impl Holding {
    fn new(buckets: Buckets) -> Self {
        let count = buckets.grains().len();
        let found: Vec<(Vec<Near>, Vec<u32>, Vec<u32>)> =
            (0..count).into_par_iter().map(|index| neighbours(&buckets, index)).collect();
        let (mut near, mut touching, mut meeting) = (Vec::new(), Vec::new(), Vec::new());
        for (all, spheres, bodies) in found {
            near.push(all);
            touching.push(spheres);
            meeting.push(bodies);
        }
        let spheres = components(&touching);
        let bodies = components(&meeting);
        let held = largest_parts(&spheres, &bodies);
        Self { buckets, near, held }
    }

    fn floating(&self) -> usize {
        self.held.iter().filter(|held| !**held).count()
    }

    fn body(&self, index: usize) -> Body<'_> {
        self.buckets.body(index, center_of(self.grain(index)))
    }

    fn grain(&self, index: usize) -> QuantisedGrain {
        self.buckets.grains()[index]
    }

    /// Those of the grains near one that are held, and what they are.
    fn held_near(&self, index: usize) -> impl Iterator<Item = (usize, Body<'_>)> {
        let near = self.near[index].iter().map(|&(other, center)| (other as usize, center));
        let held = near.filter(|&(other, _)| self.held[other]);
        held.map(|(other, center)| (other, self.buckets.body(other, center)))
    }

    /// The first turn of a grain by which it touches one that is held.
    fn shape_that_touches(
        &self,
        index: usize,
        turned: impl Fn(usize, u32) -> Option<GrainShape>,
    ) -> Option<GrainShape> {
        let held: Vec<Body<'_>> = self.held_near(index).map(|(_, body)| body).collect();
        if held.is_empty() {
            return None;
        }
        (0..TURNS).find_map(|turn| {
            let shape = turned(index, turn)?;
            let body = self.buckets.body_as(index, shape, center_of(self.grain(index)));
            held.iter().any(|other| meet(&body, other, 0.0)).then_some(shape)
        })
    }

    /// The first that is held which can be turned to touch a grain and all that it touched before, and its first such turn.
    fn holder_that_touches(
        &self,
        index: usize,
        turned: impl Fn(usize, u32) -> Option<GrainShape>,
    ) -> Option<(usize, GrainShape)> {
        self.held_near(index).find_map(|(holder, _)| {
            let (&(_, floating), body) = (
                self.near[holder].iter().find(|(other, _)| *other as usize == index)?,
                self.body(holder),
            );
            let held = self.held_near(holder).map(|(_, other)| other);
            let mut touched: Vec<Body<'_>> = held.filter(|other| meet(&body, other, 0.0)).collect();
            touched.push(self.buckets.body(index, floating));
            (0..TURNS).find_map(|turn| {
                let shape = turned(holder, turn)?;
                let body = self.buckets.body_as(holder, shape, center_of(self.grain(holder)));
                touched.iter().all(|other| meet(&body, other, 0.0)).then_some((holder, shape))
            })
        })
    }

    /// Holds a grain, and all that it holds.
    fn hold(&mut self, index: usize) {
        self.held[index] = true;
        let mut open = vec![index];
        while let Some(index) = open.pop() {
            let body = self.body(index);
            let meets = |(other, center): &&Near| {
                let other = *other as usize;
                !self.held[other] && meet(&body, &self.buckets.body(other, *center), 0.0)
            };
            let caught: Vec<usize> =
                self.near[index].iter().filter(meets).map(|(other, _)| *other as usize).collect();
            for other in caught {
                if !self.held[other] {
                    self.held[other] = true;
                    open.push(other);
                }
            }
        }
    }
}

fn center_of(grain: QuantisedGrain) -> DVec3 {
    let [x, y, z] = grain.center.map(f64::from);
    DVec3::new(x, y, z)
}

/// Grains whose bounding spheres overlap that of one, those whose spheres touch it, and those whose bodies meet it.
fn neighbours(buckets: &Buckets, index: usize) -> (Vec<Near>, Vec<u32>, Vec<u32>) {
    let body = buckets.body(index, center_of(buckets.grains()[index]));
    let (mut near, mut touching, mut meeting) = (Vec::new(), Vec::new(), Vec::new());
    buckets.around(body.center, |other, center, radius| {
        let distance = (center - body.center).length();
        if other == index {
            return;
        }
        if distance <= body.radius + radius + TOUCH_TOLERANCE_QUANTA {
            touching.push(other as u32);
        }
        let body_of_other = buckets.body(other, center);
        // A shape may be exchanged for another orientation, not for another reach.
        if distance <= body.reach() + body_of_other.reach() {
            near.push((other as u32, center));
            if meet(&body, &body_of_other, 0.0) {
                meeting.push(other as u32);
            }
        }
    });
    (near, touching, meeting)
}

/// For each node the least of those that it is linked with.
fn components(links: &[Vec<u32>]) -> Vec<u32> {
    let mut of = vec![u32::MAX; links.len()];
    for start in 0..links.len() {
        if of[start] != u32::MAX {
            continue;
        }
        of[start] = start as u32;
        let mut open = vec![start];
        while let Some(node) = open.pop() {
            for &other in &links[node] {
                if of[other as usize] == u32::MAX {
                    of[other as usize] = start as u32;
                    open.push(other as usize);
                }
            }
        }
    }
    of
}

/// Which grains are in the largest part of their set; of parts of one size, in the first.
fn largest_parts(sets: &[u32], parts: &[u32]) -> Vec<bool> {
    let mut sizes = vec![0u32; parts.len()];
    parts.iter().for_each(|&part| sizes[part as usize] += 1);
    let mut largest: Vec<Option<u32>> = vec![None; sets.len()];
    for (&set, &part) in sets.iter().zip(parts) {
        let best = &mut largest[set as usize];
        if best.is_none_or(|best| sizes[part as usize] > sizes[best as usize]) {
            *best = Some(part);
        }
    }
    sets.iter().zip(parts).map(|(&set, &part)| largest[set as usize] == Some(part)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measures::connections;
    use crate::{
        Amount, DepositRule, DepositSettings, MixedShape, Orientation, Radii, ShapeMix, Snowfall,
    };
    use snowgrain_geometry::{Grain, Quantisation, Shape, ShapeKind};

    const R: f64 = 0.3e-3;

    /// Of this density, or of grains that stick.
    fn snow(density: Option<f64>) -> (GrainField, [f64; 2]) {
        let quantisation = Quantisation::for_grains(DVec3::ZERO, R);
        let mut snow = Snowfall::on_level_floor(quantisation, [40.0 * R; 2]).unwrap();
        snow.deposit(&DepositSettings {
            amount: Amount::Depth(30.0 * R),
            radii: Radii::equal(R),
            density,
            rule: density.is_none().then_some(DepositRule::Stick),
            max_slope_degrees: 90.0,
            direction: DepositSettings::DOWN,
            area: None,
            seed: 1,
        })
        .unwrap();
        let period = snow.period().unwrap();
        (snow.into_field(), period)
    }

    fn mix(kind: ShapeKind, orientation: Orientation) -> ShapeMix {
        let shape = Arc::new(Shape::new(kind).unwrap());
        ShapeMix::new(vec![MixedShape { shape, orientation, fraction: 1.0 }], 3).unwrap()
    }

    /// Snow that floats in pieces where plates and columns are turned at random hangs together, and only what floated is
    /// turned.
    #[test]
    fn what_floated_is_turned_until_it_touches() {
        let (field, period) = snow(None);
        let quantum = field.quantisation.quantum();
        let [x, z] = period.map(|edge| (edge / quantum).round() as i64);
        for aspect in [0.1, 2.5] {
            let mix = mix(ShapeKind::HexagonalPrism { aspect, rounding: 0.0 }, Orientation::Random);
            let loose = mix.drawn(field.clone());
            let turned = |_, grain, turn| {
                let (which, quaternion) = mix.draw_again(grain, turn);
                Some(GrainShape::new(which, quaternion))
            };
            let hold = || turned_to_touch(loose.clone(), [x, 0, z], turned);
            let held = hold();
            let [before, after] = [&loose, &held]
                .map(|field| connections(field, Some(period), &|_| false).connected_fraction);
            println!("aspect {aspect}: {before} {after}");
            assert!(before < 0.97 && after > 0.95, "{before} {after}");
            let of = |field: &GrainField| field.shapes().unwrap().of_grains.clone();
            let same = of(&loose).iter().zip(of(&held)).filter(|(a, b)| **a == *b).count();
            assert!(same as f64 > 0.3 * field.len() as f64, "{same} of {}", field.len());
            // The same again, on any number of threads.
            let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap();
            assert!(pool.install(hold) == held);
        }
    }

    #[test]
    fn grains_that_cannot_be_turned_stay_as_they_are() {
        let (field, _) = snow(None);
        let upright = Orientation::Aligned { axis: DVec3::Y, spread_degrees: 0.0 };
        let mix = mix(ShapeKind::HexagonalPrism { aspect: 0.1, rounding: 0.0 }, upright);
        let loose = mix.drawn(field);
        let same = turned_to_touch(loose.clone(), [0; 3], |_, _, _| None);
        assert!(same == loose);
    }

    /// Spheres look alike from all sides: what stands beside them is turned.
    #[test]
    fn spheres_that_floated_are_touched_by_what_is_turned() {
        let (field, period) = snow(Some(250.0));
        let quantum = field.quantisation.quantum();
        let [x, z] = period.map(|edge| (edge / quantum).round() as i64);
        let of = |aspect: f64, fraction: f64| MixedShape {
            shape: Arc::new(Shape::new(ShapeKind::Spheroid { aspect }).unwrap()),
            orientation: Orientation::Random,
            fraction,
        };
        let mix = ShapeMix::new(vec![of(1.0, 0.5), of(0.7, 0.5)], 3).unwrap();
        let loose = mix.drawn(field.clone());
        let turned = |_, grain, turn| {
            let (which, quaternion) = mix.draw_again(grain, turn);
            Some(GrainShape::new(which, quaternion))
        };
        let held = turned_to_touch(loose.clone(), [x, 0, z], turned);
        // All that hangs together as spheres.
        let ground = |grain: &Grain| grain.center.y < 1.5 * R;
        let [spheres, before, after] = [&field, &loose, &held]
            .map(|field| connections(field, Some(period), &ground).connected_fraction);
        assert!(before < 0.9 * spheres && after > 0.95 * spheres, "{spheres} {before} {after}");
    }
}
