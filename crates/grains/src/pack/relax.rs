//! Overlaps removed: spheres that overlap push each other apart, in a box that repeats along all axes,
//! until none overlap any more.
//!
//! The energy, half the square of each overlap, is minimised by FIRE (Bitzek et al. 2006, "Structural
//! relaxation made simple", Phys. Rev. Lett. 97, 170201), as in O'Hern et al. 2003, "Jamming at zero
//! temperature and zero applied stress", Phys. Rev. E 68, 011306. Below the jamming density, .64 for
//! equal spheres, the least energy is 0. Forces on a sphere are summed in one order by whatever thread,
//! and sums over spheres by one: the result does not depend on threads.

use rayon::prelude::*;
use snowgrain_math::DVec3;

/// Steps after which the search ends.
const MOST_STEPS: u32 = 6000;
/// Distance, in largest radii, beyond contact up to which neighbours are listed.
const SKIN: f64 = 0.25;
/// FIRE's constants, as its authors give them.
const STEPS_BEFORE_SPEEDING: u32 = 5;
const FASTER: f64 = 1.1;
const SLOWER: f64 = 0.5;
const MIXING: f64 = 0.1;
const MIXING_DECAY: f64 = 0.99;
/// Time steps: spheres of mass 1 and contacts of stiffness 1 swing once in about 4.
const FIRST_STEP: f64 = 0.1;
const LONGEST_STEP: f64 = 0.5;

/// Spheres in a box that repeats along all axes; any unit of length.
#[derive(Clone, Debug)]
pub(crate) struct Spheres {
    pub(crate) centers: Vec<DVec3>,
    pub(crate) radii: Vec<f64>,
    pub(crate) period: DVec3,
}

impl Spheres {
    /// The image of a difference, of less than a period and a half, that is nearest to 0.
    #[inline(always)]
    fn nearest(&self, difference: DVec3) -> DVec3 {
        let half = 0.5 * self.period;
        let low = DVec3::select(difference.cmplt(-half), self.period, DVec3::ZERO);
        let high = DVec3::select(difference.cmpgt(half), self.period, DVec3::ZERO);
        difference + low - high
    }

    /// The neighbours of each sphere whose surfaces are within `gap` of its own, in a fixed order.
    pub(crate) fn neighbours(&self, gap: f64) -> Vec<Vec<u32>> {
        self.neighbours_of(gap, &|_| true)
    }

    /// The same for some spheres; none for others.
    pub(crate) fn neighbours_of(
        &self,
        gap: f64,
        counts: &(dyn Fn(usize) -> bool + Sync),
    ) -> Vec<Vec<u32>> {
        let largest = self.radii.iter().copied().fold(0.0, f64::max);
        let cells = Cells::new(self, 2.0 * largest + gap);
        (0..self.centers.len())
            .into_par_iter()
            .map(|index| {
                let mut near = Vec::new();
                if !counts(index) {
                    return near;
                }
                cells.around(self.centers[index], |other| {
                    let reach = self.radii[index] + self.radii[other as usize] + gap;
                    let d = self.nearest(self.centers[other as usize] - self.centers[index]);
                    if other as usize != index && d.length_squared() < reach * reach {
                        near.push(other);
                    }
                });
                near
            })
            .collect()
    }

    /// From the centre of one sphere to that of another, at the nearest image.
    pub(crate) fn towards(&self, a: usize, b: usize) -> DVec3 {
        self.nearest(self.centers[b] - self.centers[a])
    }

    /// Distance of two spheres' centres.
    pub(crate) fn distance(&self, a: usize, b: usize) -> f64 {
        self.towards(a, b).length()
    }

    /// Pushes spheres apart until none of those that `moves` overlaps another by more than
    /// `tolerance`; the rest stay in place. Gives the greatest overlap that is left.
    pub(crate) fn relax(&mut self, moves: &[bool], tolerance: f64) -> f64 {
        let largest = self.radii.iter().copied().fold(0.0, f64::max);
        let skin = SKIN * largest;
        let mut fire = Fire::new(self.centers.len());
        let mut neighbours = self.neighbours(skin);
        let mut listed_at = self.centers.clone();
        let mut greatest = f64::INFINITY;
        for _ in 0..MOST_STEPS {
            let forces: Vec<(DVec3, f64)> = self.forces(&neighbours, moves);
            greatest = forces.iter().map(|force| force.1).fold(0.0, f64::max);
            if greatest <= tolerance {
                break;
            }
            fire.step(&mut self.centers, &forces);
            let moved =
                self.centers.iter().zip(&listed_at).map(|(a, b)| (*a - *b).length_squared());
            if moved.fold(0.0, f64::max) > 0.25 * skin * skin {
                neighbours = self.neighbours(skin);
                listed_at.clone_from(&self.centers);
            }
        }
        greatest
    }

    /// The force on each sphere that moves, and its greatest overlap.
    fn forces(&self, neighbours: &[Vec<u32>], moves: &[bool]) -> Vec<(DVec3, f64)> {
        let force = |(index, near): (usize, &Vec<u32>)| {
            let (mut sum, mut greatest) = (DVec3::ZERO, 0.0f64);
            if !moves[index] {
                return (sum, greatest);
            }
            for &other in near {
                let d = self.nearest(self.centers[index] - self.centers[other as usize]);
                let reach = self.radii[index] + self.radii[other as usize];
                let square = d.length_squared();
                if square < reach * reach && square > 0.0 {
                    let distance = square.sqrt();
                    greatest = greatest.max(reach - distance);
                    sum += d * ((reach - distance) / distance);
                }
            }
            (sum, greatest)
        };
        neighbours.par_iter().enumerate().with_min_len(512).map(force).collect()
    }
}

/// The state of FIRE.
struct Fire {
    velocities: Vec<DVec3>,
    step: f64,
    mixing: f64,
    /// Steps since the motion last went uphill.
    downhill: u32,
}

impl Fire {
    fn new(count: usize) -> Self {
        let velocities = vec![DVec3::ZERO; count];
        Self { velocities, step: FIRST_STEP, mixing: MIXING, downhill: 0 }
    }

    fn step(&mut self, centers: &mut [DVec3], forces: &[(DVec3, f64)]) {
        let (mut power, mut force_square, mut speed_square) = (0.0, 0.0, 0.0);
        for (velocity, (force, _)) in self.velocities.iter().zip(forces) {
            power += velocity.dot(*force);
            force_square += force.length_squared();
            speed_square += velocity.length_squared();
        }
        if power > 0.0 {
            self.downhill += 1;
            if self.downhill > STEPS_BEFORE_SPEEDING {
                self.step = (self.step * FASTER).min(LONGEST_STEP);
                self.mixing *= MIXING_DECAY;
            }
        } else {
            self.downhill = 0;
            self.step *= SLOWER;
            self.mixing = MIXING;
            self.velocities.fill(DVec3::ZERO);
            speed_square = 0.0;
        }
        let towards = self.mixing * (speed_square / force_square.max(f64::MIN_POSITIVE)).sqrt();
        for ((velocity, (force, _)), center) in self.velocities.iter_mut().zip(forces).zip(centers)
        {
            // What nothing pushes any more stays where it is, and goes on touching what pushed it.
            let is_pushed = *force != DVec3::ZERO;
            let moving = *velocity * (1.0 - self.mixing) + *force * (towards + self.step);
            *velocity = if is_pushed { moving } else { DVec3::ZERO };
            *center += *velocity * self.step;
        }
    }
}

/// Spheres sorted into boxes.
struct Cells {
    counts: [i64; 3],
    period: DVec3,
    starts: Vec<u32>,
    spheres: Vec<u32>,
}

impl Cells {
    /// Boxes whose edges are at least `edge`.
    fn new(spheres: &Spheres, edge: f64) -> Self {
        let counts = (spheres.period / edge).floor().to_array().map(|count| count.max(1.0) as i64);
        let mut cells = Self {
            counts,
            period: spheres.period,
            starts: vec![0; counts.iter().product::<i64>() as usize + 1],
            spheres: vec![0; spheres.centers.len()],
        };
        let of: Vec<usize> =
            spheres.centers.iter().map(|&at| cells.index(cells.cell(at))).collect();
        of.iter().for_each(|&cell| cells.starts[cell + 1] += 1);
        for cell in 1..cells.starts.len() {
            cells.starts[cell] += cells.starts[cell - 1];
        }
        let mut next = cells.starts.clone();
        for (sphere, cell) in of.into_iter().enumerate() {
            cells.spheres[next[cell] as usize] = sphere as u32;
            next[cell] += 1;
        }
        cells
    }

    fn cell(&self, at: DVec3) -> [i64; 3] {
        let part = at / self.period;
        let part = part - part.floor();
        [0, 1, 2]
            .map(|axis| ((part[axis] * self.counts[axis] as f64) as i64).min(self.counts[axis] - 1))
    }

    fn index(&self, [x, y, z]: [i64; 3]) -> usize {
        ((z * self.counts[1] + y) * self.counts[0] + x) as usize
    }

    /// Shows the spheres of the boxes around a point, each once.
    fn around(&self, at: DVec3, mut show: impl FnMut(u32)) {
        let cell = self.cell(at);
        // Fewer than three boxes along an axis are all its neighbours once.
        let range =
            |axis: usize| if self.counts[axis] < 3 { 0..=self.counts[axis] - 1 } else { -1..=1 };
        let of = |axis: usize, step: i64| {
            if self.counts[axis] < 3 {
                step
            } else {
                (cell[axis] + step).rem_euclid(self.counts[axis])
            }
        };
        for z in range(2) {
            for y in range(1) {
                for x in range(0) {
                    let index = self.index([of(0, x), of(1, y), of(2, z)]);
                    let (from, to) = (self.starts[index] as usize, self.starts[index + 1] as usize);
                    self.spheres[from..to].iter().for_each(|&sphere| show(sphere));
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use snowgrain_math::sampler::pcg3d;

    fn random(count: u32, fill: f64) -> Spheres {
        let unit = |word: u32| f64::from(word) / 4_294_967_296.0;
        let radii: Vec<f64> = (0..count).map(|i| 1.0 + 0.2 * unit(pcg3d(i, 1, 0)[0])).collect();
        let volume: f64 = radii.iter().map(|r| 4.0 / 3.0 * core::f64::consts::PI * r * r * r).sum();
        let period = DVec3::splat(snowgrain_math::trig::cbrt(volume / fill));
        let centers = (0..count).map(|i| DVec3::from(pcg3d(i, 0, 7).map(unit)) * period).collect();
        Spheres { centers, radii, period }
    }

    #[test]
    fn spheres_at_random_places_part_below_the_jamming_density_and_do_not_above() {
        let mut loose = random(800, 0.55);
        assert!(loose.relax(&[true; 800], 1e-5) <= 1e-5);
        for (index, near) in loose.neighbours(0.0).iter().enumerate() {
            for &other in near {
                let reach = loose.radii[index] + loose.radii[other as usize];
                assert!(loose.distance(index, other as usize) >= reach - 1e-5);
            }
        }
        assert!(random(200, 0.75).relax(&[true; 200], 1e-5) > 1e-3);
    }

    #[test]
    fn neighbours_are_those_of_a_search_of_all_images() {
        let spheres = random(300, 0.3);
        for (index, near) in spheres.neighbours(0.4).iter().enumerate() {
            let all = (0..300).filter(|&other| {
                let reach = spheres.radii[index] + spheres.radii[other] + 0.4;
                other != index && spheres.distance(index, other) < reach
            });
            let mut near: Vec<usize> = near.iter().map(|&other| other as usize).collect();
            near.sort_unstable();
            assert_eq!(near, all.collect::<Vec<_>>());
        }
    }
}
