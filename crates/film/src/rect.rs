//! Rectangles of pixels.

use std::fmt;

/// A half-open rectangle of pixels: columns `x0..x1`, rows `y0..y1`, row 0 at the top.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct PixelRect {
    /// First column.
    pub x0: u32,
    /// First row.
    pub y0: u32,
    /// Column after the last.
    pub x1: u32,
    /// Row after the last.
    pub y1: u32,
}

impl PixelRect {
    /// Columns `x0..x1`, rows `y0..y1`.
    #[must_use]
    pub const fn new(x0: u32, y0: u32, x1: u32, y1: u32) -> Self {
        Self { x0, y0, x1, y1 }
    }

    /// Pixels across; 0 where `x1 <= x0`.
    #[must_use]
    pub const fn width(&self) -> u32 {
        self.x1.saturating_sub(self.x0)
    }

    /// Pixels down; 0 where `y1 <= y0`.
    #[must_use]
    pub const fn height(&self) -> u32 {
        self.y1.saturating_sub(self.y0)
    }

    /// Number of pixels.
    #[must_use]
    pub const fn area(&self) -> u64 {
        self.width() as u64 * self.height() as u64
    }

    /// Whether it holds no pixel.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.area() == 0
    }

    /// Whether pixel `(x, y)` lies inside.
    #[must_use]
    pub const fn contains(&self, x: u32, y: u32) -> bool {
        self.x0 <= x && x < self.x1 && self.y0 <= y && y < self.y1
    }

    /// Whether every pixel of `other` lies inside.
    #[must_use]
    pub const fn encloses(&self, other: &Self) -> bool {
        self.x0 <= other.x0 && other.x1 <= self.x1 && self.y0 <= other.y0 && other.y1 <= self.y1
    }

    /// The pixels of both.
    #[must_use]
    pub fn intersection(&self, other: &Self) -> Self {
        let (x0, y0) = (self.x0.max(other.x0), self.y0.max(other.y0));
        Self { x0, y0, x1: self.x1.min(other.x1).max(x0), y1: self.y1.min(other.y1).max(y0) }
    }

    /// Index of pixel `(x, y)` in row-major order; `None` outside.
    #[must_use]
    pub fn index(&self, x: u32, y: u32) -> Option<usize> {
        self.contains(x, y)
            .then(|| (y - self.y0) as usize * self.width() as usize + (x - self.x0) as usize)
    }

    /// The pixel with this index in row-major order, the inverse of [`PixelRect::index`].
    #[must_use]
    pub fn pixel(&self, index: usize) -> (u32, u32) {
        let width = self.width().max(1) as usize;
        (self.x0 + (index % width) as u32, self.y0 + (index / width) as u32)
    }

    /// The squares of `side` x `side` pixels, aligned with the picture, of which it has pixels, in
    /// row-major order; each cut to the rectangle.
    pub fn tiles(self, side: u32) -> impl Iterator<Item = Self> {
        let side = side.max(1);
        let starts = move |first: u32, end: u32| (first - first % side..end).step_by(side as usize);
        let rows = if self.is_empty() { 0..0 } else { self.y0..self.y1 };
        starts(rows.start, rows.end).flat_map(move |y| {
            starts(self.x0, self.x1).map(move |x| {
                Self::new(x, y, x.saturating_add(side), y.saturating_add(side)).intersection(&self)
            })
        })
    }
}

impl fmt::Display for PixelRect {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{},{},{},{}", self.x0, self.y0, self.x1, self.y1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_cover_every_pixel_once() {
        let rect = PixelRect::new(3, 5, 20, 17);
        let mut seen = vec![0; rect.area() as usize];
        for tile in rect.tiles(8) {
            assert!(rect.encloses(&tile) && tile.width() <= 8 && tile.height() <= 8);
            assert!(tile.x0 / 8 == (tile.x1 - 1) / 8 && tile.y0 / 8 == (tile.y1 - 1) / 8);
            for index in 0..tile.area() as usize {
                let (x, y) = tile.pixel(index);
                seen[rect.index(x, y).unwrap()] += 1;
            }
        }
        assert!(seen.iter().all(|&n| n == 1));
    }

    #[test]
    fn an_inverted_rectangle_is_empty() {
        let rect = PixelRect::new(5, 5, 2, 9);
        assert!(rect.is_empty() && rect.index(3, 6).is_none() && rect.tiles(4).count() == 0);
    }
}
