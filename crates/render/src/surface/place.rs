//! Where an object stands, and the coordinates of pictures on it.

use core::f64::consts::{PI, TAU};
use snowgrain_accel::SurfaceShape;
use snowgrain_math::{DAffine3, DVec3, trig};

/// Where an object stands.
#[derive(Clone, Debug)]
pub(crate) struct Place {
    shape: SurfaceShape,
    /// World to own space.
    to_own: DAffine3,
    /// Metres to one unit of own x and z.
    metres: [f64; 2],
}

impl Place {
    pub(crate) fn new((shape, transform): &(SurfaceShape, DAffine3)) -> Self {
        let axes = [transform.matrix3.x_axis, transform.matrix3.z_axis];
        Self {
            shape: shape.clone(),
            to_own: transform.inverse(),
            metres: axes.map(|axis| axis.length()),
        }
    }

    /// A vector to the outside of the piece at a point of it, of any length.
    pub(crate) fn outwards(&self, piece: u32, position: DVec3) -> DVec3 {
        let own = match &self.shape {
            SurfaceShape::Sphere => self.to_own.transform_point3(position),
            SurfaceShape::Box => {
                let axis = [DVec3::X, DVec3::Y, DVec3::Z][(piece / 2).min(2) as usize];
                if piece.is_multiple_of(2) { -axis } else { axis }
            }
            SurfaceShape::Plane => DVec3::Y,
            SurfaceShape::Mesh(mesh) => {
                let [a, b, c] = mesh.corners(piece as usize);
                (b - a).cross(c - a)
            }
        };
        // Normals move by the inverse of the transpose, whichever way the object is mirrored.
        self.to_own.matrix3.transpose() * own
    }

    /// Where a point of a piece lies in a picture: to the right and upwards, 0 to 1 across it.
    ///
    /// A sphere has longitude (the middle of the picture looks along +z) and latitude, each face of a box
    /// the whole picture, upright seen from outside; a plane a picture `metres` wide and high, upright
    /// seen along -z; a mesh its own coordinates.
    pub(super) fn coordinates(&self, piece: u32, position: DVec3, metres: f64) -> [f64; 2] {
        let p = self.to_own.transform_point3(position);
        match &self.shape {
            SurfaceShape::Sphere => {
                let height = (p.y / p.length()).clamp(-1.0, 1.0);
                [trig::atan2(p.x, p.z) / TAU + 0.5, trig::asin(height) / PI + 0.5]
            }
            SurfaceShape::Box => {
                let [right, up] = match piece {
                    0 => [p.z, p.y],
                    1 => [-p.z, p.y],
                    2 => [p.x, p.z],
                    3 => [p.x, -p.z],
                    4 => [-p.x, p.y],
                    _ => [p.x, p.y],
                };
                [0.5 + 0.5 * right, 0.5 + 0.5 * up]
            }
            SurfaceShape::Plane => [p.x * self.metres[0] / metres, -p.z * self.metres[1] / metres],
            SurfaceShape::Mesh(mesh) => {
                let Some(&[a, b, c]) = mesh.coordinates.get(piece as usize) else {
                    return [0.0; 2];
                };
                let [p_a, p_b, p_c] = mesh.corners(piece as usize);
                let (ab, ac, ap) = (p_b - p_a, p_c - p_a, p - p_a);
                let normal = ab.cross(ac);
                let area = normal.length_squared();
                let (of_b, of_c) =
                    (ap.cross(ac).dot(normal) / area, ab.cross(ap).dot(normal) / area);
                std::array::from_fn(|i| {
                    let [a, b, c] = [a[i], b[i], c[i]].map(f64::from);
                    a + (b - a) * of_b + (c - a) * of_c
                })
            }
        }
    }
}
