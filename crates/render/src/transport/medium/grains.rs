//! Grains that are met at random in a density.
//!
//! A sphere of which a path strikes the side towards it has its centre ahead. So spheres are met by the density at their centres: what a grain
//! does is drawn first, and with it where its centre would be. In the void of real snow a path is free for the mean chord 4 r (1 - phi) / (3 phi):
//! the density is divided by the part of the place that is void. Then uniform light stays so, however the density varies: of its radiance
//! there is at each place the part that is void, as among real grains, and light visits 2 tau of them.

use super::density::{Density, Matter};
use super::scattering::{Azimuths, Passage, Scattering};
use super::uniform::Uniform;
use super::{CALIBRATION, Calibration};
use crate::transport::ice::IceLength;
use snowgrain_math::{DVec3, Exponential, Ray};

/// Greatest solid fraction: where grains overlap, their volumes may add to more than there is room.
const MOST_SOLID: f64 = 0.9;
/// Binary logarithm of the nodes along each edge of a block, over which the greatest extinction is taken.
const BLOCK: u32 = 2;
/// By so much of a cell a path is set beyond the face of a block.
const BEYOND: f64 = 1e-6;
/// Most cells that a path goes between faces that are infinitely far apart.
const MOST_CELLS: f64 = 1e6;

/// What a path meets of the snow.
#[derive(Clone, Debug)]
pub(super) struct Grains {
    pub(super) scattering: Scattering,
    azimuths: Azimuths,
    exponential: Exponential,
    calibration: Vec<Calibration>,
    pub(super) uniform: Option<UniformGrains>,
    /// Of each block the greatest extinction, 1/m: x fastest.
    most: Vec<f32>,
    blocks: [usize; 3],
}

/// Grains where the snow is the same all around.
#[derive(Clone, Debug)]
pub(super) struct UniformGrains {
    pub(super) uniform: Uniform,
    /// Mean free path, metres; by the mean shadow where grains do not lie in all orientations alike.
    pub(super) free_path: f64,
    calibration: Calibration,
}

/// A grain that is met.
#[derive(Clone, Copy, Debug)]
pub(super) struct Meeting {
    /// How far along the ray, metres.
    pub(super) t: f64,
    /// Radius, metres.
    pub(super) radius: f64,
    /// What it does.
    pub(super) passage: Passage,
    /// Whether it lets the path pass straight.
    pub(super) is_straight: bool,
}

impl Grains {
    /// Levels out the density where it is the same all around.
    pub(super) fn new(density: &mut Density, scattering: Scattering) -> Self {
        let mut grains = Self {
            scattering,
            azimuths: Azimuths::new(),
            exponential: Exponential::new(),
            calibration: CALIBRATION.to_vec(),
            uniform: None,
            most: Vec::new(),
            blocks: density.nodes.map(|count| ((count - 1) >> BLOCK) + 1),
        };
        grains.uniform = Uniform::level_out(density).map(|uniform| UniformGrains {
            free_path: 1.0 / grains.extinction(uniform.matter.area, uniform.matter.solid),
            calibration: grains.calibration_of(uniform.matter.solid),
            uniform,
        });
        grains.most = grains.most(density);
        grains
    }

    /// Takes another calibration.
    pub(super) fn calibrate(&mut self, table: &[Calibration]) {
        self.calibration = table.to_vec();
        if let Some(mut uniform) = self.uniform.take() {
            uniform.calibration = self.calibration_of(uniform.uniform.matter.solid);
            self.uniform = Some(uniform);
        }
    }

    /// Memory, bytes.
    pub(super) fn memory_bytes(&self) -> u64 {
        let uniform = self.uniform.as_ref().map_or(0, |grains| grains.uniform.reach.memory_bytes());
        size_of_val(self.most.as_slice()) as u64 + uniform + self.scattering.memory_bytes()
    }

    /// Meetings by length of discs of this area by volume, 1/m, where so much is solid.
    fn extinction(&self, area: f64, solid: f64) -> f64 {
        match self.scattering {
            Scattering::Refracted(_) => area,
            Scattering::Sphere(..) | Scattering::Shapes(_) => area / (1.0 - solid.min(MOST_SOLID)),
        }
    }

    /// Mean free path of light of a direction in the uniform snow, metres.
    #[inline]
    fn free_path(&self, grains: &UniformGrains, direction: DVec3) -> f64 {
        grains.free_path / self.scattering.shadow(direction, &grains.uniform.parts)
    }

    fn calibration_of(&self, solid: f64) -> Calibration {
        match self.scattering {
            Scattering::Refracted(_) => CALIBRATION[0],
            Scattering::Sphere(..) | Scattering::Shapes(_) => {
                Calibration::of(&self.calibration, solid)
            }
        }
    }

    /// Of each block the greatest extinction, by the nodes that weigh for what is met in it.
    fn most(&self, density: &Density) -> Vec<f32> {
        let [bx, by, bz] = self.blocks;
        let blocks =
            (0..bz).flat_map(|z| (0..by).flat_map(move |y| (0..bx).map(move |x| [x, y, z])));
        let of_block = |block: [usize; 3]| {
            let [xs, ys, zs] = [0, 1, 2].map(|axis| density.nodes_around(axis, block[axis], BLOCK));
            let mut most = [0.0f32; 2];
            for &z in &zs {
                for &y in &ys {
                    for &x in &xs {
                        let [area, solid, _] = density.values[density.number([x, y, z])];
                        most = [most[0].max(area), most[1].max(solid)];
                    }
                }
            }
            let [area, solid] = most.map(f64::from);
            (self.scattering.largest_shadow() * self.extinction(area, solid)) as f32
        };
        blocks.map(of_block).collect()
    }

    /// The grain that a ray meets next before `far`, metres; `random` gives uniform numbers.
    ///
    /// Where the snow is the same all around the free path is drawn; elsewhere tracking is by the greatest extinction of a block
    /// (Woodcock et al. 1965), from block to block.
    #[inline]
    pub(super) fn meeting(
        &self,
        density: &Density,
        ray: &Ray,
        far: f64,
        mut random: impl FnMut() -> [f64; 3],
    ) -> Option<Meeting> {
        let mut t = 0.0;
        if let Some(grains) = &self.uniform {
            let room = grains.uniform.reach.room(density, density.coordinates(ray.origin));
            if room > 0.0 {
                let (numbers, room) = (random(), room * density.shortest_edge());
                let free = self.exponential.of(numbers[0]);
                let length = free * self.free_path(grains, ray.direction);
                if length < room {
                    let met = || self.in_uniform(grains, ray.direction, length, numbers);
                    return (length < far).then(met);
                }
                t = room;
            }
        }
        self.meeting_beyond(density, ray, (t, far), random)
    }

    /// As [`Self::meeting`], from so far along the ray.
    fn meeting_beyond(
        &self,
        density: &Density,
        ray: &Ray,
        (start, far): (f64, f64),
        mut random: impl FnMut() -> [f64; 3],
    ) -> Option<Meeting> {
        let (mut t, end) = density.bounds.intersect(ray)?;
        let end = end.min(far).min(t + MOST_CELLS * density.edges.max_element());
        t = t.max(start);
        while t < end {
            let at = density.coordinates(ray.at(t));
            let numbers = random();
            let free = self.exponential.of(numbers[0]);
            if let Some(grains) = &self.uniform {
                let room = grains.uniform.reach.room(density, at) * density.shortest_edge();
                if room > 0.0 {
                    let length = free * self.free_path(grains, ray.direction);
                    t += length.min(room);
                    if length < room {
                        let met = || self.in_uniform(grains, ray.direction, t, numbers);
                        return (t < end).then(met);
                    }
                    continue;
                }
            }
            let (most, exit) = self.block(density, at, ray.direction);
            let length = free / most;
            if most == 0.0 || length >= exit {
                t += exit;
                continue;
            }
            t += length;
            if t >= end {
                return None;
            }
            let met = self.candidate(density, ray, (t, most), [numbers, random()]);
            if met.is_some() {
                return met;
            }
        }
        None
    }

    /// How far around a place there is but uniform snow, metres; negative where that is not so there.
    pub(super) fn uniform_room(&self, density: &Density, place: DVec3) -> f64 {
        let room =
            |grains: &UniformGrains| grains.uniform.reach.room(density, density.coordinates(place));
        self.uniform.as_ref().map_or(-1.0, room) * density.shortest_edge()
    }

    /// What a grain of this radius does to a path that arrives at it; three uniform numbers.
    pub(super) fn meeting_of(
        &self,
        density: &Density,
        arrival: &Ray,
        radius: f64,
        [_, way, turn]: [f64; 3],
    ) -> Meeting {
        let calibration = self.calibration_of(density.at(arrival.origin).solid);
        let parts = density.parts_near(arrival.origin);
        let of = (parts, [way, turn]);
        let (passage, is_straight) = self.draw(arrival.direction, &calibration, of);
        Meeting { t: 0.0, radius, passage, is_straight }
    }

    /// The greatest extinction of the block around a place, told in cells, 1/m, and how far its faces are, metres.
    fn block(&self, density: &Density, at: DVec3, direction: DVec3) -> (f64, f64) {
        let block = [at.x as usize >> BLOCK, at.y as usize >> BLOCK, at.z as usize >> BLOCK];
        let [bx, by, _] = self.blocks;
        let most = self.most[(block[2] * by + block[1]) * bx + block[0]];
        let mut exit = f64::INFINITY;
        for axis in 0..3 {
            let along = direction[axis] / density.edges[axis];
            let face = match along > 0.0 {
                true => ((block[axis] + 1) << BLOCK).min(density.nodes[axis]) as f64 + BEYOND,
                false => (block[axis] << BLOCK) as f64 - BEYOND,
            };
            if along != 0.0 {
                exit = exit.min((face - at[axis]) / along);
            }
        }
        (f64::from(most), exit)
    }

    /// The grain that is met next where the snow is uniform; three uniform numbers.
    #[inline]
    pub(super) fn meeting_in_uniform(
        &self,
        grains: &UniformGrains,
        direction: DVec3,
        numbers: [f64; 3],
    ) -> Meeting {
        let t = self.exponential.of(numbers[0]) * self.free_path(grains, direction);
        self.in_uniform(grains, direction, t, numbers)
    }

    /// A length in the ice of the uniform snow, shared out among the strata of its kinds as these have parts of it.
    pub(super) fn shared(&self, length: f64, stratum: impl Fn(usize) -> u8) -> IceLength {
        let parts = self.uniform.as_ref().map_or(&[][..], |grains| &grains.uniform.parts);
        let all: f64 = parts.iter().map(|&part| f64::from(part)).sum();
        if parts.is_empty() || all == 0.0 {
            return IceLength::of(length, stratum(0));
        }
        let of_kind = |(kind, &part): (usize, &u8)| {
            IceLength::of(length * f64::from(part) / all, stratum(kind))
        };
        parts.iter().enumerate().map(of_kind).fold(IceLength::default(), |sum, ice| sum + ice)
    }

    /// A unit vector across a direction, by a uniform number.
    #[inline]
    pub(super) fn across(&self, direction: DVec3, random: f64) -> DVec3 {
        self.azimuths.across(direction, random)
    }

    #[inline(always)]
    fn in_uniform(
        &self,
        grains: &UniformGrains,
        direction: DVec3,
        t: f64,
        [_, way, turn]: [f64; 3],
    ) -> Meeting {
        let UniformGrains { uniform, calibration, .. } = grains;
        let of = (&*uniform.parts, [way, turn]);
        let (passage, is_straight) = self.draw(direction, calibration, of);
        Meeting { t, radius: uniform.matter.radius, passage, is_straight }
    }

    /// A grain that may be met, if there is one.
    fn candidate(
        &self,
        density: &Density,
        ray: &Ray,
        (t, most): (f64, f64),
        [[_, way, turn], [chance, node, _]]: [[f64; 3]; 2],
    ) -> Option<Meeting> {
        let place = ray.at(t);
        if let Some(grains) = &self.uniform
            && grains.uniform.reach.room(density, density.coordinates(place)) >= 0.0
        {
            let is_met = chance * most * self.free_path(grains, ray.direction) < 1.0;
            return is_met.then(|| self.in_uniform(grains, ray.direction, t, [0.0, way, turn]));
        }
        let here = density.at(place);
        let (radius, parts) = (here.radius, density.parts_near(place));
        let (passage, is_straight) =
            self.draw(ray.direction, &self.calibration_of(here.solid), (parts, [way, turn]));
        let center = passage.entry.map_or(place, |entry| place - entry * radius);
        let Matter { area, .. } = density.near(center, node);
        let shadow = self.scattering.shadow(ray.direction, parts);
        let is_met = chance * most < shadow * self.extinction(area, here.solid);
        is_met.then_some(Meeting { t, radius, passage, is_straight })
    }

    /// What a grain does to a path, as [`Scattering::draw`].
    #[inline(always)]
    fn draw(
        &self,
        direction: DVec3,
        calibration: &Calibration,
        of: (&[u8], [f64; 2]),
    ) -> (Passage, bool) {
        self.scattering.draw(direction, (&self.azimuths, calibration), of)
    }
}
