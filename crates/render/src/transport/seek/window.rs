//! Parts of a pixel in which images of the sun are looked for.

/// A part of a pixel, which goes on at its other edge.
#[derive(Clone, Copy)]
pub(super) struct Window {
    pixel: [f64; 2],
    /// Low corner within the pixel.
    corner: [f64; 2],
    edge: f64,
}

impl Window {
    /// A window of this edge (pixels, at most 1) that holds a place of the image: where in it, is random.
    pub(super) fn around(image: [f64; 2], edge: f64, random: [f64; 2]) -> Self {
        let pixel = image.map(f64::floor);
        let corner =
            [0, 1].map(|axis: usize| fraction(image[axis] - pixel[axis] - edge * random[axis]));
        Self { pixel, corner, edge }
    }

    pub(super) fn contains(&self, image: [f64; 2]) -> bool {
        image.map(f64::floor) == self.pixel
            && (0..2).all(|axis| fraction(image[axis] - self.corner[axis]) < self.edge)
    }

    /// The place of two numbers in [0, 1).
    pub(super) fn at(&self, random: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|axis: usize| {
            self.pixel[axis] + fraction(self.corner[axis] + self.edge * random[axis])
        })
    }
}

fn fraction(x: f64) -> f64 {
    x - x.floor()
}
