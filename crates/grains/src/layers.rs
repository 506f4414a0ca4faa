//! Slabs of crystals: square layers of equal grains, one over the other, that repeat for ever.

use crate::{GrainField, GrainsError, ICE_DENSITY};
use core::f64::consts::{FRAC_1_SQRT_2, PI, SQRT_2};
use snowgrain_geometry::{Quantisation, QuantisedGrain};
use snowgrain_math::{DVec3, trig};

/// Most layers: more are no slab.
const MOST_LAYERS: f64 = 1e6;
/// A density that is this much above that of touching grains is theirs.
const SLACK: f64 = 1e-3;

/// How a layer lies on the one below.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stacking {
    /// Grain on grain: the simple cubic lattice on (001).
    SimpleCubic,
    /// Over the gaps, as deep as neighbours are apart: the face-centred cubic lattice on (001).
    FaceCentredCubic,
}

/// A slab to make: x and z lie along rows of nearest neighbours.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LayerSettings {
    /// How layers lie on each other.
    pub stacking: Stacking,
    /// Radius of the grains, metres.
    pub radius: f64,
    /// Density, kg/m^3, which sets the distance of neighbours.
    pub density: f64,
    /// Depth, metres: as many layers as come nearest to it.
    pub depth: f64,
}

/// Whole layers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Layers {
    /// Distance of nearest neighbours, metres.
    pub spacing: f64,
    /// Of one layer from the next, metres.
    pub step: f64,
    /// How many there are.
    pub count: u32,
}

impl Stacking {
    /// Highest density, that of touching grains, kg/m^3.
    #[must_use]
    pub fn most_density(self) -> f64 {
        match self {
            Self::SimpleCubic => ICE_DENSITY * PI / 6.0,
            Self::FaceCentredCubic => ICE_DENSITY * PI * SQRT_2 / 6.0,
        }
    }

    /// Of one layer from the next, where neighbours are 1 apart.
    fn step(self) -> f64 {
        match self {
            Self::SimpleCubic => 1.0,
            Self::FaceCentredCubic => FRAC_1_SQRT_2,
        }
    }
}

impl LayerSettings {
    /// The layers that come nearest to the depth.
    ///
    /// # Errors
    /// A density above that of touching grains; a depth of less than half a layer, or of too many.
    pub fn layers(&self) -> Result<Layers, GrainsError> {
        let most = self.stacking.most_density();
        if !(self.density > 0.0 && self.density <= most * (1.0 + SLACK)) {
            let reason = format!(
                "{} kg/m^3 is out of reach for this lattice: ask for at most {most:.0}",
                self.density
            );
            return Err(GrainsError::setting("density", reason));
        }
        // As many radii apart as leave a grain its share of the volume.
        let spacing = 2.0 * self.radius * trig::cbrt((most / self.density).max(1.0));
        let step = spacing * self.stacking.step();
        let count = (self.depth / step).round();
        if !(1.0..=MOST_LAYERS).contains(&count) {
            let reason = format!(
                "{} m is less than half a layer of grains, or more than {MOST_LAYERS} of them; a \
                 layer is {step:.3e} m",
                self.depth
            );
            return Err(GrainsError::setting("depth", reason));
        }
        Ok(Layers { spacing, step, count: count as u32 })
    }

    /// The slab between y = 0 and the depth of its layers, and its periods along x and z in quanta, which
    /// hold one grain of a layer.
    ///
    /// # Errors
    /// As [`Self::layers`]; a slab beyond the lattice of quanta.
    pub fn slab(&self) -> Result<(GrainField, [i64; 2]), GrainsError> {
        let layers = self.layers()?;
        let quantisation = Quantisation::for_grains(DVec3::ZERO, self.radius);
        let (quantum, radius) = (quantisation.quantum(), Quantisation::MAX_RADIUS_QUANTA);
        // Equal cells of at most three radii must fill the period.
        let cells = (layers.spacing / quantum / (3.0 * f64::from(radius))).ceil().max(1.0);
        let edge = cells * (layers.spacing / quantum / cells).ceil();
        let low = 0.5 * (layers.depth(self.radius) - f64::from(layers.count - 1) * layers.step);
        let center = |layer: u32| {
            let shifted = self.stacking == Stacking::FaceCentredCubic && layer % 2 == 1;
            let aside = if shifted { 0.75 } else { 0.25 } * edge * quantum;
            DVec3::new(aside, low + f64::from(layer) * layers.step, aside)
        };
        let grain = |layer: u32| {
            let QuantisedGrain { center, .. } = quantisation.round(center(layer), self.radius)?;
            Ok(QuantisedGrain { center, radius })
        };
        let grains = (0..layers.count).map(grain).collect::<Result<Vec<_>, GrainsError>>()?;
        Ok((GrainField::new(quantisation, grains), [edge as i64; 2]))
    }
}

impl Layers {
    /// From the bottom of the slab to its top, metres: whole layers, or, where these overlap in height,
    /// from the lowest point of the grains to the highest.
    #[must_use]
    pub fn depth(&self, radius: f64) -> f64 {
        let count = f64::from(self.count);
        (count * self.step).max((count - 1.0) * self.step + 2.0 * radius)
    }

    /// Optical depth: projected area of all grains over that of the ground.
    #[must_use]
    pub fn optical_depth(&self, radius: f64) -> f64 {
        PI * radius * radius / (self.spacing * self.spacing) * f64::from(self.count)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn settings(stacking: Stacking, density: f64, depth: f64) -> LayerSettings {
        LayerSettings { stacking, radius: 1e-3, density, depth }
    }

    #[test]
    fn neighbours_are_as_far_apart_as_the_density_says_and_none_overlap() {
        for stacking in [Stacking::SimpleCubic, Stacking::FaceCentredCubic] {
            for part in [1.0, 0.5, 0.03] {
                let settings = settings(stacking, part * stacking.most_density(), 0.03);
                let layers = settings.layers().unwrap();
                let (field, period) = settings.slab().unwrap();
                assert_eq!(field.len(), layers.count as usize);
                let quantum = field.quantisation.quantum();
                let edge = period[0] as f64 * quantum;
                assert!((edge / layers.spacing - 1.0).abs() < 1e-3);
                let volume = edge * edge * f64::from(layers.count) * layers.step;
                let ball = 4.0 / 3.0 * PI * 1e-9 * f64::from(layers.count);
                let density = ICE_DENSITY * ball / volume;
                assert!((density / settings.density - 1.0).abs() < 2e-3, "{density}");
                let wrapped = |d: f64| (d - edge * (d / edge).round()).abs();
                let all: Vec<DVec3> = field.iter().map(|grain| grain.center).collect();
                for (index, a) in all.iter().enumerate() {
                    assert!(a.y > 0.999e-3 && a.y < layers.depth(1e-3) - 0.999e-3);
                    for b in &all[index + 1..] {
                        let d = *b - *a;
                        let apart = DVec3::new(wrapped(d.x), d.y, wrapped(d.z)).length();
                        assert!(apart > 2e-3 * (1.0 - 1e-3), "{apart}");
                    }
                }
            }
        }
    }

    #[test]
    fn slabs_have_whole_layers_within_reach() {
        let three = settings(Stacking::SimpleCubic, 480.0, 5.5e-3).layers().unwrap();
        assert_eq!(three.count, 3);
        assert!((three.optical_depth(1e-3) - 2.356).abs() < 2e-3);
        let dense = settings(Stacking::SimpleCubic, 500.0, 1.0).layers().unwrap_err();
        assert!(dense.to_string().contains("at most 480"), "{dense}");
        assert!(settings(Stacking::FaceCentredCubic, 679.0, 1e-4).layers().is_err());
    }
}
