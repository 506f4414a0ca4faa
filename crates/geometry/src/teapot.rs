//! Newell's teapot.

use crate::TriangleMesh;
use snowgrain_math::DVec3;
use std::collections::BTreeMap;

const VERTICES: &str = include_str!("../data/teapot/vertices.csv");
const PATCHES: &str = include_str!("../data/teapot/patches.csv");

/// Control points of one bicubic Bezier patch, row by row, y up.
type Patch = [[DVec3; 4]; 4];

/// Newell's teapot as triangles, each of its 32 Bezier patches diced into `divisions` x `divisions`
/// quads; in his units, turned y up and standing on y = 0.
///
/// The spout points along +x, the handle along -x; the box around it is about `[-3, 3.43] x
/// [0, 3.15] x [-2, 2]`. Triangles wind counterclockwise seen from outside (from the side of the
/// air where a wall has air on both sides: the rim). Patches that share a border share its
/// vertices exactly; borders that the model leaves open stay open (the lip under the lid, and the
/// ends of handle and spout, which run into the body). Quads that shrink to a triangle at the
/// poles of lid and bottom give one triangle, so there are somewhat fewer than
/// `64 * divisions^2`. `divisions` of 0 counts as 1. Each patch has the whole of a
/// picture, by its parameters.
///
/// ```
/// let mesh = snowgrain_geometry::teapot(8);
/// let bounds = mesh.bounds();
/// assert!(bounds.min.y.abs() < 1e-12 && (bounds.max.y - 3.15).abs() < 1e-12);
/// ```
#[must_use]
pub fn teapot(divisions: u32) -> TriangleMesh {
    let divisions = divisions.max(1);
    let mut mesh = TriangleMesh::default();
    let mut known = BTreeMap::new();
    for patch in patches() {
        dice(&patch, divisions, &mut mesh, &mut known);
    }
    mesh
}

/// The numbers of a comma-separated table whose comments start with `#`.
fn rows(table: &'static str) -> impl Iterator<Item = Vec<f64>> {
    table.lines().filter(|line| !line.starts_with('#') && !line.is_empty()).map(|line| {
        line.split(',')
            .map(|field| field.trim().parse().expect("the table is part of the program"))
            .collect()
    })
}

fn patches() -> Vec<Patch> {
    let points: Vec<DVec3> = rows(VERTICES).map(|p| DVec3::new(p[0], p[2], -p[1])).collect();
    rows(PATCHES)
        .map(|row| {
            std::array::from_fn(|i| std::array::from_fn(|j| points[row[4 * i + j] as usize]))
        })
        .collect()
}

/// Adds the triangles of one patch; `known` finds a vertex by the bits of its position.
fn dice(
    patch: &Patch,
    divisions: u32,
    mesh: &mut TriangleMesh,
    known: &mut BTreeMap<[u64; 3], u32>,
) {
    let mut vertex = |i: u32, j: u32, mesh: &mut TriangleMesh| {
        // Adding zero turns -0 into 0.
        let p = point(patch, [i, j], divisions) + DVec3::ZERO;
        let next = mesh.positions.len() as u32;
        *known.entry(p.to_array().map(f64::to_bits)).or_insert_with(|| {
            mesh.positions.push(p);
            next
        })
    };
    for i in 0..divisions {
        for j in 0..divisions {
            let quad = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)];
            let [a, b, c, d] = quad.map(|(i, j)| vertex(i, j, mesh));
            let place = |(i, j): (u32, u32)| [j, i].map(|k| k as f32 / divisions as f32);
            let [at_a, at_b, at_c, at_d] = quad.map(place);
            for (corners, places) in
                [([a, d, c], [at_a, at_d, at_c]), ([a, c, b], [at_a, at_c, at_b])]
            {
                let [p, q, r] = corners.map(|v| mesh.positions[v as usize]);
                if (q - p).cross(r - p) != DVec3::ZERO {
                    mesh.triangles.push(corners);
                    mesh.coordinates.push(places);
                }
            }
        }
    }
}

/// The point of the patch at `(i, j) / divisions`.
///
/// Symmetric in its control points: read from either end, along a row or a column, a border gives
/// the same bits, so that neighbours share its vertices without a tolerance.
fn point(patch: &Patch, [i, j]: [u32; 2], divisions: u32) -> DVec3 {
    bezier(patch.map(|row| bezier(row, j, divisions)), i, divisions)
}

/// The cubic Bezier curve at `i / divisions`, in Bernstein form.
fn bezier(p: [DVec3; 4], i: u32, divisions: u32) -> DVec3 {
    if p == [p[0]; 4] {
        // A pole: the rounded weights do not sum to exactly 1.
        return p[0];
    }
    let t = f64::from(i) / f64::from(divisions);
    let s = f64::from(divisions - i) / f64::from(divisions);
    (p[0] * (s * s * s) + p[3] * (t * t * t))
        + (p[1] * (3.0 * (s * s * t)) + p[2] * (3.0 * (t * t * s)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area(mesh: &TriangleMesh) -> f64 {
        (0..mesh.triangles.len())
            .map(|t| {
                let [a, b, c] = mesh.corners(t);
                (b - a).cross(c - a).length() * 0.5
            })
            .sum()
    }

    /// How often each edge is used in the one and in the other direction.
    fn edges(mesh: &TriangleMesh) -> BTreeMap<(u32, u32), (u32, u32)> {
        let mut edges = BTreeMap::new();
        for t in &mesh.triangles {
            for (a, b) in [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])] {
                let uses: &mut (u32, u32) = edges.entry((a.min(b), a.max(b))).or_default();
                if a < b {
                    uses.0 += 1;
                } else {
                    uses.1 += 1;
                }
            }
        }
        edges
    }

    #[test]
    fn bounds_are_newells_at_any_division() {
        for divisions in [4, 8, 32] {
            let bounds = teapot(divisions).bounds();
            assert_eq!(bounds.min, DVec3::new(-3.0, 0.0, -2.0), "{divisions}");
            assert_eq!((bounds.max.y, bounds.max.z), (3.15, 2.0), "{divisions}");
            assert!((bounds.max.x - 3.434).abs() < 1e-2, "{divisions}: {}", bounds.max.x);
        }
    }

    #[test]
    fn neighbours_share_borders_and_winding() {
        for n in [3u32, 4, 7, 8, 16, 31] {
            let mesh = teapot(n);
            let (mut open, mut shared) = (0, 0);
            for (edge, uses) in edges(&mesh) {
                match uses {
                    (1, 1) => shared += 1,
                    (1, 0) | (0, 1) => open += 1,
                    _ => panic!("{n} divisions: edge {edge:?} is used {uses:?} times"),
                }
            }
            // Open: rim and lid (4 patches each), both ends of the handle and of the spout (2 each).
            assert_eq!(open, 16 * n, "{n} divisions");
            assert_eq!(2 * shared + open, 3 * mesh.triangles.len() as u32);
            // Eight patches (4 of the knob, 4 of the bottom) end in a pole.
            assert_eq!(mesh.triangles.len() as u32, 64 * n * n - 8 * n);
        }
    }

    #[test]
    fn normals_point_outwards() {
        let mesh = teapot(12);
        let mut checked = 0;
        for t in 0..mesh.triangles.len() {
            let [a, b, c] = mesh.corners(t);
            let (center, normal) = ((a + b + c) / 3.0, (b - a).cross(c - a));
            let radius = (center.x * center.x + center.z * center.z).sqrt();
            if center.y < 1e-3 {
                assert!(normal.y < 0.0, "bottom at {center}");
            } else if radius < 1.2 && center.y > 2.45 {
                assert!(normal.y > 0.0 || center.y > 2.7, "lid at {center}");
            } else if (0.2..2.0).contains(&center.y) && radius < 1.45 && center.x < 1.0 {
                let outwards = DVec3::new(center.x, 0.0, center.z);
                assert!(normal.dot(outwards) > 0.0, "body at {center}");
            } else {
                continue;
            }
            checked += 1;
        }
        assert!(checked > 1000, "{checked}");
    }

    #[test]
    fn area_converges_as_the_square_of_the_step() {
        let [a, b, c, d] = [8, 16, 32, 64].map(|n| area(&teapot(n)));
        assert!(a < b && b < c && c < d);
        for ratio in [(b - a) / (c - b), (c - b) / (d - c)] {
            assert!((3.5..4.5).contains(&ratio), "{ratio}");
        }
    }

    #[test]
    fn no_triangle_is_without_area() {
        for n in [1, 2, 9, 32] {
            let mesh = teapot(n);
            let checked =
                TriangleMesh::new(mesh.positions.clone(), mesh.triangles.clone()).unwrap();
            let checked_count = checked.triangles.len();
            assert_eq!((checked.positions, checked.triangles), (mesh.positions, mesh.triangles));
            assert_eq!(mesh.coordinates.len(), checked_count);
        }
    }
}
