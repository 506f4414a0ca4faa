//! Refractive indices for which paths are traced, and how results between them follow.

use snowgrain_optics::ice;

/// Greatest distance between two nodes, and most nodes.
const STEP: f64 = 0.02;
const MOST_NODES: usize = 6;

/// The indices that serve a set of wavelengths: equally far apart from the least to the greatest.
pub(super) fn nodes_for(wavelengths_nm: &[f64]) -> Vec<f64> {
    let indices = wavelengths_nm.iter().map(|&wavelength| ice::refractive_index(wavelength));
    let [low, high] = indices.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], index| {
        [low.min(index), high.max(index)]
    });
    if high - low < 1e-5 {
        return vec![0.5 * (low + high)];
    }
    let steps = ((high - low) / STEP).ceil().clamp(1.0, (MOST_NODES - 1) as f64);
    (0..=steps as usize).map(|i| low + (high - low) * i as f64 / steps).collect()
}

/// Weights of the values at the nodes for the value at `index`: the polynomial through all of them
/// (Lagrange).
pub(super) fn weights_at(nodes: &[f64], index: f64) -> Vec<f64> {
    let weight = |i: usize| {
        let others = nodes.iter().enumerate().filter(|&(j, _)| j != i);
        others.map(|(_, other)| (index - other) / (nodes[i] - other)).product()
    };
    (0..nodes.len()).map(weight).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn polynomials_pass_through_their_nodes() {
        let nodes = nodes_for(&[350.0, 500.0, 1290.0]);
        assert_eq!(nodes.len(), 3, "{nodes:?}");
        let parabola = |n: f64| 1.0 + n * (2.0 - 0.3 * n);
        for index in [nodes[0], nodes[1], 1.31, 1.3017] {
            let weights = weights_at(&nodes, index);
            let sum: f64 = weights.iter().zip(&nodes).map(|(w, &n)| w * parabola(n)).sum();
            assert!((sum - parabola(index)).abs() < 1e-9, "{index}");
        }
        assert_eq!(nodes_for(&[500.0]).len(), 1);
        assert_eq!(weights_at(&[1.3], 1.31), [1.0]);
    }
}
