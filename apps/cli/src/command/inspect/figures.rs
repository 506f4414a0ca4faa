//! What `snowgrain inspect` says.

use crate::summary::grouped;
use serde::Serialize;
use snowgrain_grains::measures::{Directed, Structure};
use std::fmt::Write;

/// All figures; lengths in metres.
#[derive(Debug, Serialize)]
pub(super) struct Figures {
    grains: u64,
    /// Looked at, cubic metres.
    volume: f64,
    /// kg/m^3.
    density: f64,
    nominal_density: f64,
    solid_fraction: f64,
    porosity: f64,
    /// Of the union: 1/m, and m^2/kg.
    surface_per_volume: f64,
    specific_surface_area: f64,
    /// Of equal grains with this surface and mass.
    optical_radius: f64,
    mean_air_chord: f64,
    /// 4 (1 - solid fraction) / surface per volume.
    mean_air_chord_by_theorem: f64,
    mean_ice_chord: f64,
    anisotropy: f64,
    radius: RadiusFigures,
    contacts_per_grain: f64,
    overlaps_per_grain: f64,
    greatest_overlap: f64,
    connected_fraction: f64,
    /// Whether that is with the ground, or the largest piece.
    reaches_ground: bool,
    /// kg/m^3 in tenths of the depth from the surface down.
    density_profile: Vec<f64>,
    along_x: DirectedFigures,
    along_y: DirectedFigures,
    along_z: DirectedFigures,
}

#[derive(Debug, Serialize)]
struct RadiusFigures {
    mean: f64,
    standard_deviation: f64,
    /// Sum of cubes by sum of squares.
    effective: f64,
    least: f64,
    greatest: f64,
    /// Radius, and part of all grains.
    histogram: Vec<(f64, f64)>,
}

/// What is measured along an axis.
#[derive(Debug, Serialize)]
struct DirectedFigures {
    mean_air_chord: f64,
    mean_ice_chord: f64,
    /// Distance, and probability that two points so far apart are both in ice.
    two_point_correlation: Vec<(f64, f64)>,
    /// Length, and density of the distribution, 1/m.
    air_chords: Vec<(f64, f64)>,
    ice_chords: Vec<(f64, f64)>,
}

impl DirectedFigures {
    fn of(directed: &Directed) -> Self {
        Self {
            mean_air_chord: directed.mean_air_chord,
            mean_ice_chord: directed.mean_ice_chord,
            two_point_correlation: directed.correlation.clone(),
            air_chords: directed.air_chords.clone(),
            ice_chords: directed.ice_chords.clone(),
        }
    }
}

impl Figures {
    pub(super) fn of(structure: &Structure) -> Self {
        let ice = structure.density() / structure.solid_fraction.max(f64::MIN_POSITIVE);
        let porosity = 1.0 - structure.solid_fraction;
        let by_positive = |a: f64, b: f64| if b > 0.0 { a / b } else { 0.0 };
        let sizes = &structure.sizes;
        let [along_x, along_y, along_z] =
            [0, 1, 2].map(|axis| DirectedFigures::of(&structure.along[axis]));
        Self {
            grains: structure.grains,
            volume: structure.volume,
            density: structure.density(),
            nominal_density: ice * structure.nominal_solid_fraction,
            solid_fraction: structure.solid_fraction,
            porosity,
            surface_per_volume: structure.surface_per_volume,
            specific_surface_area: structure.specific_surface(),
            optical_radius: by_positive(
                3.0 * structure.solid_fraction,
                structure.surface_per_volume,
            ),
            mean_air_chord: structure.mean_air_chord,
            mean_air_chord_by_theorem: by_positive(4.0 * porosity, structure.surface_per_volume),
            mean_ice_chord: structure.mean_ice_chord,
            anisotropy: structure.anisotropy,
            radius: RadiusFigures {
                mean: sizes.mean,
                standard_deviation: sizes.deviation,
                effective: sizes.effective,
                least: sizes.range[0],
                greatest: sizes.range[1],
                histogram: sizes.classes.clone(),
            },
            contacts_per_grain: structure.connections.contacts_per_grain,
            overlaps_per_grain: structure.connections.overlaps_per_grain,
            greatest_overlap: structure.connections.greatest_overlap_depth.max(0.0),
            connected_fraction: structure.connections.connected_fraction,
            reaches_ground: structure.connections.reaches_ground,
            density_profile: structure.profile.iter().map(|part| ice * part).collect(),
            along_x,
            along_y,
            along_z,
        }
    }

    /// How much hangs together: a file of grains does not hold the ground that joins them.
    fn connected(&self) -> (&'static str, String) {
        let percent = 100.0 * self.connected_fraction;
        if self.reaches_ground {
            ("connected", format!("{percent:.2} % of the mass, with the ground"))
        } else {
            ("largest piece", format!("{percent:.2} % of the mass; no ground is known"))
        }
    }

    /// The figures as a table.
    pub(super) fn table(&self) -> String {
        let mm = |metres: f64| format!("{:.4} mm", 1e3 * metres);
        let radius = &self.radius;
        let axes = |of: fn(&DirectedFigures) -> f64| {
            [&self.along_x, &self.along_y, &self.along_z].map(|along| mm(of(along))).join(", ")
        };
        let profile: Vec<String> =
            self.density_profile.iter().map(|part| format!("{part:.0}")).collect();
        let rows = [
            ("grains", grouped(self.grains)),
            ("volume looked at", format!("{:.3} cm3", 1e6 * self.volume)),
            ("density (union)", format!("{:.1} kg/m3", self.density)),
            ("density (nominal)", format!("{:.1} kg/m3", self.nominal_density)),
            ("porosity", format!("{:.4}", self.porosity)),
            ("density by depth", format!("{} kg/m3 (surface to bottom)", profile.join(" "))),
            ("specific surface", format!("{:.3} m2/kg", self.specific_surface_area)),
            ("optical radius", mm(self.optical_radius)),
            (
                "radius",
                format!(
                    "{} +- {}, effective {}, {} to {}",
                    mm(radius.mean),
                    mm(radius.standard_deviation),
                    mm(radius.effective),
                    mm(radius.least),
                    mm(radius.greatest)
                ),
            ),
            ("contacts a grain", format!("{:.2}", self.contacts_per_grain)),
            (
                "overlaps a grain",
                format!(
                    "{:.2}, at most {} deep",
                    self.overlaps_per_grain,
                    mm(self.greatest_overlap)
                ),
            ),
            self.connected(),
            (
                "mean chord in air",
                format!(
                    "{} (by the surface: {}); along x, y, z {}",
                    mm(self.mean_air_chord),
                    mm(self.mean_air_chord_by_theorem),
                    axes(|along| along.mean_air_chord)
                ),
            ),
            (
                "mean chord in ice",
                format!(
                    "{}; along x, y, z {}",
                    mm(self.mean_ice_chord),
                    axes(|along| along.mean_ice_chord)
                ),
            ),
            ("anisotropy", format!("{:.4} (chords in ice, upright by level)", self.anisotropy)),
        ];
        rows.iter().fold(String::new(), |mut text, (name, value)| {
            // Writing to a string does not fail.
            let _ = writeln!(text, "{name:<18} {value}");
            text
        })
    }
}
