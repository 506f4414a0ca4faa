//! Light that diffuses from where it falls on the surface of snow to where it comes out again, by a dipole.
//!
//! Jensen, Marschner, Levoy and Hanrahan 2001, "A Practical Model for Subsurface Light Transport", eq. 4: the diffusion from a
//! point of a level half space by two sources, one below and a negative one above the surface; its light is even over all
//! directions. Snow ends in no step of the index, so A = 1 and both Fresnel transmittances are 1. Of the grains: sigma_s' = sigma (1 - g),
//! sigma_a = sigma (1 - w), sigma the area of their discs by volume. Light that was scattered once is not told apart, as in the
//! hierarchy.
//!
//! Jensen and Buhler 2002, "A Rapid Hierarchical Rendering Technique for Translucent Materials": the light on the surface
//! is found once, at points; where one is shaded, points are taken together that fill less than a solid angle.

use super::skin::Piece;
use core::f64::consts::PI;
use snowgrain_math::{DVec3, trig};

/// Greatest solid angle of points that are taken together, sr.
const SOLID_ANGLE: f64 = 0.05;
/// Most points of a leaf.
const LEAF: usize = 8;

/// How a half space diffuses light of one channel. Lengths in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Diffusion {
    /// sigma_s' / sigma_t'.
    reduced_albedo: f64,
    /// Effective extinction, sqrt(3 sigma_a sigma_t').
    effective: f64,
    /// Depth of the source below, and height of the one above.
    below: f64,
    above: f64,
}

impl Diffusion {
    /// Reduced scattering and absorption, 1/m.
    pub(super) fn new(reduced_scattering: f64, absorption: f64) -> Self {
        let reduced = reduced_scattering + absorption;
        let below = 1.0 / reduced;
        Self {
            reduced_albedo: reduced_scattering / reduced,
            effective: (3.0 * absorption * reduced).sqrt(),
            below,
            above: below * (1.0 + 4.0 / 3.0),
        }
    }

    /// Exitance by irradiance and area, 1/m^2, at a squared distance along the surface.
    fn reflectance(&self, distance_squared: f64) -> f64 {
        let of_source = |depth: f64| {
            let squared = distance_squared + depth * depth;
            let distance = squared.sqrt();
            let optical = self.effective * distance;
            let left = if optical > 0.0 { trig::exp(-optical) } else { 1.0 };
            depth * (1.0 + optical) * left / (squared * distance)
        };
        self.reduced_albedo / (4.0 * PI) * (of_source(self.below) + of_source(self.above))
    }

    /// Albedo of a half space under even light: the integral of the reflectance.
    #[cfg(test)]
    fn albedo(&self) -> f64 {
        let of_source = |depth: f64| trig::exp(-self.effective * depth);
        0.5 * self.reduced_albedo * (of_source(self.below) + of_source(self.above))
    }
}

/// Light on a piece of the surface.
#[derive(Clone, Debug)]
pub(super) struct LitPiece {
    pub(super) piece: Piece,
    /// Irradiance of each slot.
    pub(super) irradiance: Vec<[f64; 3]>,
}

/// A surface that is lit, and how light diffuses below it.
#[derive(Clone, Debug)]
pub(super) struct Dipole {
    diffusion: [Diffusion; 3],
    slots: usize,
    nodes: Vec<Node>,
    /// Of each node the flux of each slot.
    flux: Vec<[f64; 3]>,
}

/// Points that may be taken together.
#[derive(Clone, Copy, Debug)]
struct Node {
    /// Centre of the light, and area.
    center: DVec3,
    area: f64,
    /// Half the diagonal of the box around its points.
    reach: f64,
    /// The nodes below; one point where there are none.
    children: (u32, u32),
}

impl Dipole {
    pub(super) fn new(diffusion: [Diffusion; 3], slots: usize, mut pieces: Vec<LitPiece>) -> Self {
        let mut dipole = Self { diffusion, slots, nodes: Vec::new(), flux: Vec::new() };
        if !pieces.is_empty() {
            dipole.reserve(1);
            dipole.fill(0, &mut pieces);
        }
        dipole
    }

    /// Room for so many nodes side by side; the number of the first.
    fn reserve(&mut self, count: usize) -> usize {
        let first = self.nodes.len();
        let empty = Node { center: DVec3::ZERO, area: 0.0, reach: 0.0, children: (0, 0) };
        self.nodes.resize(first + count, empty);
        self.flux.resize((first + count) * self.slots, [0.0; 3]);
        first
    }

    /// Makes a node of pieces: halves them along the longest edge of their box until few are left.
    fn fill(&mut self, at: usize, pieces: &mut [LitPiece]) {
        let mut low = DVec3::INFINITY;
        let mut high = DVec3::NEG_INFINITY;
        let (mut area, mut weight, mut moment) = (0.0, 0.0, DVec3::ZERO);
        for LitPiece { piece, irradiance } in pieces.iter() {
            (low, high) = (low.min(piece.position), high.max(piece.position));
            area += piece.area;
            let light: f64 = irradiance.iter().flatten().sum();
            // Dark pieces have a place, too.
            let light = (light + f64::MIN_POSITIVE) * piece.area;
            weight += light;
            moment += piece.position * light;
            for (slot, light) in irradiance.iter().enumerate() {
                for (flux, light) in self.flux[at * self.slots + slot].iter_mut().zip(light) {
                    *flux += light * piece.area;
                }
            }
        }
        let size = high - low;
        let center = if weight > 0.0 { moment / weight } else { 0.5 * (low + high) };
        let count = pieces.len();
        let children = match count {
            1 => (0, 0),
            _ if count <= LEAF => {
                let first = self.reserve(count);
                for (child, piece) in pieces.chunks_mut(1).enumerate() {
                    self.fill(first + child, piece);
                }
                (first as u32, (first + count) as u32)
            }
            _ => {
                let axis = [DVec3::X, DVec3::Y, DVec3::Z]
                    .into_iter()
                    .max_by(|a, b| a.dot(size).total_cmp(&b.dot(size)))
                    .unwrap_or(DVec3::X);
                pieces.sort_by(|a, b| {
                    a.piece.position.dot(axis).total_cmp(&b.piece.position.dot(axis))
                });
                let first = self.reserve(2);
                let (lower, upper) = pieces.split_at_mut(count / 2);
                self.fill(first, lower);
                self.fill(first + 1, upper);
                (first as u32, first as u32 + 2)
            }
        };
        self.nodes[at] = Node { center, area, reach: 0.5 * size.length(), children };
    }

    /// Adds the radiance that leaves the surface at a point to that of each slot.
    pub(super) fn add_radiances(&self, position: DVec3, radiances: &mut [[f32; 3]]) {
        if self.nodes.is_empty() {
            return;
        }
        let mut sums = vec![[0.0f64; 3]; self.slots];
        let mut open = vec![0u32];
        while let Some(at) = open.pop() {
            let Node { center, area, reach, children } = self.nodes[at as usize];
            let distance_squared = position.distance_squared(center);
            let is_point = children.0 == children.1;
            let is_apart = distance_squared > reach * reach;
            if !is_point && (!is_apart || area > SOLID_ANGLE * distance_squared) {
                open.extend(children.0..children.1);
                continue;
            }
            let reflectances = self.diffusion.map(|channel| channel.reflectance(distance_squared));
            let flux = &self.flux[at as usize * self.slots..];
            for (sum, flux) in sums.iter_mut().zip(flux) {
                for channel in 0..3 {
                    sum[channel] += flux[channel] * reflectances[channel];
                }
            }
        }
        for (radiance, sum) in radiances.iter_mut().zip(sums) {
            for (radiance, exitance) in radiance.iter_mut().zip(sum) {
                *radiance += (exitance / PI) as f32;
            }
        }
    }

    /// Memory, bytes.
    pub(super) fn memory_bytes(&self) -> u64 {
        (size_of_val(self.nodes.as_slice()) + size_of_val(self.flux.as_slice())) as u64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A wide level surface under even light has the albedo of the closed form, in each of three channels.
    #[test]
    fn a_half_space_has_its_albedo() {
        let channels = [0.005, 0.05, 0.3].map(|absorption| Diffusion::new(1.0, absorption));
        let (half, step) = (120i32, 0.25);
        let mut pieces = Vec::new();
        for z in -half..half {
            for x in -half..half {
                let position =
                    DVec3::new((f64::from(x) + 0.5) * step, 0.0, (f64::from(z) + 0.5) * step);
                let piece = Piece { position, normal: DVec3::Y, area: step * step };
                pieces.push(LitPiece { piece, irradiance: vec![[1.0; 3]] });
            }
        }
        let dipole = Dipole::new(channels, 1, pieces);
        let mut radiance = [[0.0f32; 3]];
        dipole.add_radiances(DVec3::new(0.03, 0.0, -0.05), &mut radiance);
        for (channel, radiance) in channels.into_iter().zip(radiance[0]) {
            let (found, albedo) = (PI * f64::from(radiance), channel.albedo());
            // The square ends at 30 free paths, and the solid angle of nodes is not nothing.
            assert!((found / albedo - 1.0).abs() < 0.015, "{found} instead of {albedo}");
        }
    }

    #[test]
    fn without_absorption_all_light_comes_back() {
        assert!((Diffusion::new(7.0, 0.0).albedo() - 1.0).abs() < 1e-15);
    }
}
