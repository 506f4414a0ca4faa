//! Flat layers of snow and what lights them.

use super::Scatterers;
use super::scatterers::Grain;
use snowgrain_optics::Impurity;
use snowgrain_optics::ice::{self, ICE_DENSITY, IceAbsorption};
use snowgrain_optics::sphere::Polarisation;
use snowgrain_optics::theory::SingleScattering;

/// How light arrives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Incidence {
    /// The same radiance from all directions above.
    Diffuse,
    /// Parallel light at this angle from the vertical, degrees, in [0, 90).
    Sun {
        /// Angle from the vertical, degrees.
        zenith_degrees: f64,
    },
}

/// A layer of grains of ice of equal size.
#[derive(Clone, Debug, PartialEq)]
pub struct SnowLayer {
    /// What the grains are.
    pub scatterers: Scatterers,
    /// Radius of the grains, that of spheres of equal volume, metres.
    pub radius: f64,
    /// Density, kg/m^3, above 0 and at most 917.
    pub density: f64,
    /// Depth, metres; infinite for the last layer of deep snow.
    pub depth: f64,
    /// What lies between the grains.
    pub impurities: Vec<Impurity>,
}

/// Layers from the top down, on a ground.
#[derive(Clone, Debug, PartialEq)]
pub struct SnowStack {
    /// From the top down; only the last may be infinite.
    pub layers: Vec<SnowLayer>,
    /// Albedo of the ground, 0 to 1, which reflects light diffusely.
    pub ground_albedo: f64,
    /// Which measurements of the absorption of ice.
    pub ice: IceAbsorption,
}

impl SnowLayer {
    /// Extinction by grains, 1/m: the projected area of all grains in a volume.
    #[must_use]
    pub fn extinction_per_metre(&self) -> f64 {
        0.75 * (self.density / ICE_DENSITY) / self.radius * self.scatterers.shadow()
    }

    /// Optical depth.
    #[must_use]
    pub fn optical_depth(&self) -> f64 {
        self.extinction_per_metre() * self.depth
    }

    /// What a grain does to light, for theories.
    pub(super) fn single_scattering(
        &self,
        ice: IceAbsorption,
        polarisation: Polarisation,
        wavelength_nm: f64,
    ) -> SingleScattering {
        let grain = self.scatterers.at(ice::refractive_index(wavelength_nm));
        let absorption = self.absorption_per_metre(ice, wavelength_nm) * self.radius;
        let co_albedo = grain.co_albedo(absorption);
        SingleScattering { co_albedo, asymmetry: grain.asymmetry(polarisation) }
    }

    /// Absorption a metre of ice, with that of the impurities: such that the co-albedo of a grain is that of
    /// its ice and what each impurity absorbs beside it (an external mixture): `4 c MAC / SSA` for convex grains.
    #[must_use]
    pub fn absorption_per_metre(&self, ice: IceAbsorption, wavelength_nm: f64) -> f64 {
        if self.impurities.is_empty() {
            return ice.per_metre(wavelength_nm);
        }
        let grain = self.scatterers.at(ice::refractive_index(wavelength_nm));
        let enhancement = grain.enhancement();
        let impurities = self.impurities.iter();
        let beside: f64 = impurities.map(|i| i.per_metre_of_ice(wavelength_nm, enhancement)).sum();
        let pure = ice.per_metre(wavelength_nm) * self.radius;
        let first_order = pure + beside * self.radius;
        let added = beside * self.radius * grain.mean_length();
        let co_albedo = (grain.co_albedo(pure) + added).min(MOST_CO_ALBEDO);
        with_co_albedo(&grain, co_albedo, first_order) / self.radius
    }
}

/// Greatest co-albedo of a grain: what is reflected outside cannot be absorbed.
const MOST_CO_ALBEDO: f64 = 0.9;
/// Absorption per radius below which the co-albedo is proportional to it, to 2e-4 of it.
const WEAK: f64 = 1e-4;

/// The absorption per radius of a grain with this co-albedo, which is about `first_order`.
fn with_co_albedo(grain: &Grain, co_albedo: f64, first_order: f64) -> f64 {
    if first_order < WEAK {
        return first_order;
    }
    // Secants: the co-albedo rises ever more slowly.
    let off = |absorption: f64| grain.co_albedo(absorption) - co_albedo;
    let (mut last, mut last_off) = (0.0, -co_albedo);
    let mut absorption = first_order;
    for _ in 0..12 {
        let here = off(absorption);
        if here.abs() < 1e-9 || here == last_off {
            break;
        }
        let next = absorption - here * (absorption - last) / (here - last_off);
        (last, last_off) = (absorption, here);
        absorption = next.max(0.5 * absorption);
    }
    absorption
}

impl SnowStack {
    /// Whether no light reaches the ground.
    #[must_use]
    pub fn is_deep(&self) -> bool {
        self.layers.last().is_some_and(|layer| layer.depth.is_infinite())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use snowgrain_optics::{Dielectric, ImpurityKind, Load, sphere};

    #[test]
    fn a_grain_absorbs_what_its_ice_and_its_impurities_do_together() {
        for (radius, load, wavelength) in
            [(1e-4, 1e-8, 400.0), (1e-3, 1e-5, 400.0), (5e-4, 1e-6, 900.0), (1e-3, 1e-3, 500.0)]
        {
            let kind = ImpurityKind::BlackCarbonBond2006;
            let soot = Impurity { kind, load: Load::MassFraction(load) };
            let impurities = vec![soot];
            let layer = SnowLayer {
                scatterers: Scatterers::Spheres,
                radius,
                density: 300.0,
                depth: 1.0,
                impurities,
            };
            let ice = IceAbsorption::default();
            let medium = Dielectric { eta: ice::refractive_index(wavelength) };
            let alone = sphere::co_albedo(medium, ice.per_metre(wavelength) * radius);
            let mac = kind.absorption_cross_section(wavelength);
            let added = 4.0 * load * mac / ice::specific_surface_area(radius);
            let found =
                sphere::co_albedo(medium, layer.absorption_per_metre(ice, wavelength) * radius);
            let expected = (alone + added).min(MOST_CO_ALBEDO);
            assert!((found / expected - 1.0).abs() < 3e-4, "{radius} {load}: {found} {expected}");
        }
    }
}
