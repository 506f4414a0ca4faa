//! Numerical integration.

use core::f64::consts::PI;
use snowgrain_math::trig;
use std::sync::LazyLock;

/// Points of the rule: far more than the smooth integrands of a sphere need for 1e-12.
const POINTS: u32 = 200;

/// The integral of `f` from `a` to `b` by one Gauss-Legendre rule (exact for polynomials of degree
/// below 400; never asks for the ends).
pub(crate) fn integrate(a: f64, b: f64, f: impl Fn(f64) -> f64) -> f64 {
    let (middle, half) = (0.5 * (a + b), 0.5 * (b - a));
    half * NODES.iter().map(|(node, weight)| weight * f(middle + half * node)).sum::<f64>()
}

/// Nodes and weights of the rule, found once: that takes a hundred times as long as to use them.
static NODES: LazyLock<Vec<(f64, f64)>> =
    LazyLock::new(|| (0..POINTS).map(legendre_node).collect());

/// Node and weight number `i`: Newton's iteration on the Legendre polynomial from Tricomi's
/// estimate of its root.
fn legendre_node(i: u32) -> (f64, f64) {
    let n = f64::from(POINTS);
    let mut x = trig::sin_cos(PI * (f64::from(i) + 0.75) / (n + 0.5)).1;
    let mut slope = 1.0;
    for _ in 0..8 {
        let (value, previous) = legendre(x);
        slope = n * (previous - x * value) / (1.0 - x * x);
        x -= value / slope;
    }
    (x, 2.0 / ((1.0 - x * x) * slope * slope))
}

/// The Legendre polynomials of degree `POINTS` and one less, by their three-term recurrence.
fn legendre(x: f64) -> (f64, f64) {
    let (mut value, mut previous) = (x, 1.0);
    for degree in 2..=POINTS {
        let k = f64::from(degree);
        (value, previous) = (((2.0 * k - 1.0) * x * value - (k - 1.0) * previous) / k, value);
    }
    (value, previous)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn polynomials_and_sines_come_out_exact() {
        assert!((integrate(0.0, 2.0, |x| x * x * x) - 4.0).abs() < 1e-12);
        assert!((integrate(0.0, PI, |x| trig::sin_cos(x).0) - 2.0).abs() < 1e-12);
        assert!((integrate(-1.0, 3.0, |_| 1.0) - 4.0).abs() < 1e-12);
    }
}
