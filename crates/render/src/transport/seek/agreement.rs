//! What a search finds of uniform light, part by part, against what paths meet.

use super::gains::{
    ANGLES, CELLS, Class, DEPTH_COUNT, DEPTHS, Gains, HEIGHTS, ORDERS, Tally, VIEWS,
};
use snowgrain_math::trig;

/// Least paths that a part must end by to be told.
const LEAST_MET: f64 = 100.0;

/// Numbers of grains on the way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Orders {
    /// The least.
    pub first: u32,
    /// The greatest; `None`: any.
    pub last: Option<u32>,
}

/// What is told apart where a search is compared with chance. Angles in degrees, from one to another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Part {
    /// All light.
    All,
    /// That which arrived at its last grain through the ice of another.
    FromIce,
    /// That of so many grains.
    After(Orders),
    /// The same, which goes to the light at these elevations.
    Elevation(Orders, [f64; 2]),
    /// The same, which goes to the light at these angles from the way back to the camera.
    Turn(Orders, [f64; 2]),
}

/// What a search finds of a part of uniform light, against what paths meet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Agreement {
    /// Of which light.
    pub part: Part,
    /// Share of all light that paths meet.
    pub share: f64,
    /// What is found over what is met, less 1.
    pub bias: f64,
    /// Its standard error, without that of the factors of the search.
    pub standard_error: f64,
}

/// Light of a class belongs to it?
type Holds = Box<dyn Fn(&Class) -> bool>;

impl Tally {
    /// What a search with these factors finds, part by part; parts that hardly any path meets are left out.
    pub(super) fn agreements(&self, gains: &Gains) -> Vec<Agreement> {
        let all: f64 = self.escaped.iter().map(|&count| count as f64).sum();
        let agreement = |(part, holds): (Part, Holds)| {
            let [mut met, mut found, mut variance] = [0.0; 3];
            for cell in 0..CELLS {
                let class = Class::of_cell(cell);
                if holds(&class) {
                    let gain = gains.gain(&class);
                    met += self.escaped[cell] as f64;
                    found += gain * self.found_in(cell);
                    variance += self.escaped[cell] as f64 + gain * gain * self.squares_in(cell);
                }
            }
            let (bias, standard_error) = (found / met - 1.0, variance.sqrt() / met);
            let told = Agreement { part, share: met / all, bias, standard_error };
            (met >= LEAST_MET).then_some(told)
        };
        parts().into_iter().filter_map(agreement).collect()
    }
}

fn parts() -> Vec<(Part, Holds)> {
    let mut parts: Vec<(Part, Holds)> = vec![
        (Part::All, Box::new(|_| true)),
        (Part::FromIce, Box::new(|class| class.way >= ORDERS.len() * ANGLES)),
    ];
    for order in 0..ORDERS.len() {
        let holds: Holds = Box::new(move |class| class.order() == order);
        parts.push((Part::After(orders(|other| other == order)), holds));
    }
    for depth in 0..DEPTH_COUNT {
        let orders = orders(|order| DEPTHS[order] == depth);
        for height in 0..HEIGHTS {
            let at = |bin: usize| degrees(trig::asin(2.0 * bin as f64 / HEIGHTS as f64 - 1.0));
            let holds: Holds =
                Box::new(move |class| class.depth == depth && class.height == height);
            parts.push((Part::Elevation(orders, [at(height), at(height + 1)]), holds));
        }
        for view in 0..VIEWS {
            let at = |bin: usize| degrees(2.0 * trig::asin(bin as f64 / VIEWS as f64));
            let holds: Holds = Box::new(move |class| class.depth == depth && class.view == view);
            parts.push((Part::Turn(orders, [at(view), at(view + 1)]), holds));
        }
    }
    parts
}

/// The numbers of grains of the classes of orders that hold.
fn orders(holds: impl Fn(usize) -> bool) -> Orders {
    let of_class = |class: usize| ORDERS[class];
    let held = || (0..ORDERS.len()).filter(|&class| holds(class));
    let next = held().last().and_then(|class| ORDERS.get(class + 1));
    Orders { first: held().next().map_or(0, of_class), last: next.map(|next| next - 1) }
}

fn degrees(radians: f64) -> f64 {
    radians.to_degrees()
}
