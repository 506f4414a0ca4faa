//! The first grain that a camera sees, where it has a shape of its own: its images of small lights, exactly.
//!
//! A face mirrors a sun into the camera or it does not, wherever a ray strikes it. So light is not sought from
//! the sun, but the chain of all that the grain makes of the ray ([`GrainGrid::chain`]) is followed both
//! ways at each interface, and what leaves towards a sun and finds its way out counts, by its weight.
//! Where other grains may overlap this one only the first chord is known to end in an interface; further
//! ones, and grains that are not convex, meet the sun by chance.
//!
//! [`GrainGrid::chain`]: snowgrain_accel::GrainGrid::chain

use super::shadow::{Brings, Condition};
use super::{PathState, SOLVED_ORDERS_OF_OVERLAPPED, Seeker, Trail, product, scaled};
use crate::light::LightRole;
use crate::transport::Contribution;
use snowgrain_accel::{GrainVisit, Outgoing, ShapedArrival};
use snowgrain_math::DVec3;

impl Seeker<'_> {
    /// Looks for the images of all suns in the first grain of a path.
    pub(super) fn at_first_shape(
        &mut self,
        (visit, shaped): (&GrainVisit, &ShapedArrival),
        trail: &mut Trail,
        state: &PathState,
    ) {
        if visit.meets_surface {
            return;
        }
        let radius = f64::from(visit.radius);
        let along = DVec3::from_array(visit.direction.map(f64::from)).normalize();
        let chain = self.world.grid.chain(shaped, along, radius, self.search.medium.eta);
        let Some(chain) = chain else { return };
        let most = if visit.overlaps { SOLVED_ORDERS_OF_OVERLAPPED } else { chain.chords };
        trail.solved_orders = Some(most);
        for out in chain.outgoing.iter().filter(|out| out.chords <= most) {
            for light in 0..self.search.lights.count() {
                if self.search.roles[light] == LightRole::Sun {
                    self.towards_sun(visit, light, out, state);
                }
            }
        }
    }

    /// Looks whether a ray that leaves the grain meets a sun.
    fn towards_sun(&mut self, visit: &GrainVisit, light: usize, out: &Outgoing, state: &PathState) {
        let lights = &self.search.lights;
        let direction = out.ray.direction.normalize();
        let radiance = lights.radiance_at_infinity(light, direction);
        if radiance == [0.0; 3] {
            return;
        }
        let length = out.ice_length * f64::from(visit.radius) * self.world.grid.quantum();
        let mut ice_in_strata = [0.0; snowgrain_accel::STRATA];
        if let Some(stratum) = usize::from(visit.stratum).checked_sub(1) {
            ice_in_strata[stratum] = length;
        }
        let brings = Brings::Light(Contribution {
            slot: lights.slot_of(light),
            glint: true,
            event: visit.event,
            weight: scaled(product(state.throughput, radiance), out.weight),
            ice_length: length,
            ice_in_strata,
        });
        let towards = (direction, f64::INFINITY, None);
        let reach = out.ray.origin.length();
        let from = (out.ray.origin / reach, (reach * f64::from(visit.radius)) as f32);
        self.want(visit, from, towards, brings, Condition::Nothing);
    }
}
