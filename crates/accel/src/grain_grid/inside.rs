//! Whether a point lies in ice.

use super::block::RADIUS_MASK;
use super::{CellEntry, GRAINS_PER_BLOCK, GrainGrid, Storage};
use snowgrain_math::DVec3;

impl GrainGrid {
    /// Whether `point`, metres, lies inside a grain.
    #[must_use]
    pub fn is_inside_grain(&self, point: DVec3) -> bool {
        self.grains_at(point, 1) > 0
    }

    /// In how many grains `point`, metres, lies; no more than `most` are counted. Of grains of a lattice that stores nothing,
    /// which do not overlap, one at most.
    #[must_use]
    pub fn grains_at(&self, point: DVec3, most: usize) -> usize {
        let bounds = self.bounds();
        let outside = point.cmplt(bounds.min).any() || point.cmpgt(bounds.max).any();
        if self.grains() == 0 || outside || !point.is_finite() {
            return 0;
        }
        if let Storage::Sites(sites) = &self.storage {
            return sites.is_inside_grain(self.quanta(point)).into();
        }
        let place = self.locate(point);
        let entry = self.entry(place.cell);
        if entry == CellEntry::EMPTY_BRICK {
            return 0;
        }
        let local = DVec3::from_array(place.local.map(f64::from));
        let slots =
            entry.blocks().flat_map(|number| (0..GRAINS_PER_BLOCK).map(move |slot| (number, slot)));
        slots.filter(|&(number, slot)| self.contains((number, slot), local)).take(most).count()
    }

    /// Whether a grain of a block contains a place of the block's cell.
    fn contains(&self, (number, slot): (usize, usize), local: DVec3) -> bool {
        let block = &self.blocks[number];
        let center = [block.x[slot], block.y[slot], block.z[slot]].map(f64::from);
        let radius = f64::from(block.radius[slot] & RADIUS_MASK);
        let from_center = local - DVec3::from_array(center);
        if from_center.length_squared() >= radius * radius {
            return false;
        }
        self.shapes.as_ref().is_none_or(|shapes| {
            let placement = shapes.placement(shapes.blocks[number][slot], block.radius[slot]);
            shapes.of(&placement).contains(placement.to_prototype(from_center))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Packing, Surfaces};
    use snowgrain_geometry::Quantisation;
    use snowgrain_math::sampler::{PathKey, numbers};

    #[test]
    fn points_are_inside_as_distances_say() {
        let quantisation = Quantisation::for_grains(DVec3::ZERO, 0.5);
        let random = |index, event| numbers(PathKey::new(1, index, 0), event).map(f64::from);
        let grains: Vec<_> = (0..1000)
            .map(|index| {
                let center = DVec3::from_array(random(index, 0)) * DVec3::new(6.0, 6.0, 60.0);
                quantisation.round(center, 0.25 + 0.25 * random(index, 1)[0]).unwrap()
            })
            .collect();
        let grid =
            GrainGrid::build(quantisation, &grains, &Surfaces::default(), Packing::Fast).unwrap();
        let (mut inside, mut overlaps) = (0, 0);
        for index in 0..20_000 {
            let point = DVec3::from_array(random(index, 2)) * DVec3::new(9.0, 9.0, 63.0) - 1.5;
            let depths: Vec<f64> = grains
                .iter()
                .map(|&grain| quantisation.grain(grain))
                .map(|grain| grain.radius - (point - grain.center).length())
                .collect();
            if depths.iter().all(|depth| depth.abs() > 1e-4) {
                let count = depths.iter().filter(|depth| **depth > 0.0).count();
                assert_eq!(grid.is_inside_grain(point), count > 0, "{point} {count}");
                assert_eq!(grid.grains_at(point, 9), count, "{point}");
                inside += u32::from(count > 0);
                overlaps += u32::from(count > 1);
            }
        }
        assert!(inside > 100 && overlaps > 10, "{inside} {overlaps}");
        assert!(!grid.is_inside_grain(DVec3::NAN));
    }
}
