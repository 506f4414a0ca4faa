//! How densely cells are filled.

use core::f64::consts::PI;

/// How many grains a cell lists: memory against speed.
///
/// The pictures are equal but for noise, not bit for bit: light is followed through other cells, so
/// that its positions are rounded otherwise.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum Packing {
    /// One block of 16 grains a cell that is seldom overrun: the fastest.
    #[default]
    Fast,
    /// Large cells of two blocks or more: half the memory or less, at two thirds of the speed.
    Compact,
}

impl Packing {
    /// Wanted grains listed in a cell that lies within snow. Fast: few enough that a block of 16
    /// seldom runs over, many enough that memory and steps from cell to cell stay few. Compact: few
    /// of the listed grains reach into several cells, and blocks are nearly full. Where grains have shapes light takes as long from 11
    /// grains a cell to 22, as steps cost what blocks do; so cells are as large as that.
    fn grains_per_cell(self, have_shapes: bool) -> f64 {
        match (self, have_shapes) {
            (Self::Fast, false) => 10.5,
            (Self::Fast, true) => 22.0,
            (Self::Compact, false) => 26.0,
            (Self::Compact, true) => 40.0,
        }
    }

    /// Edge of a cell that lists as many grains as wanted, in snow of so many grains of about one `radius` in the unit of
    /// volume, which may have shapes.
    pub(super) fn cell_side(self, radius: f64, density: f64, have_shapes: bool) -> f64 {
        let wanted = self.grains_per_cell(have_shapes);
        let ball = 4.0 / 3.0 * PI * radius * radius * radius;
        // Grains whose balls reach into a cube of edge s: their centres fill its parallel body.
        let listed = |s: f64| {
            density * (s * s * s + 6.0 * s * s * radius + 3.0 * PI * s * radius * radius + ball)
        };
        let mut side = 1.5 * radius;
        while listed(side * 1.02) <= wanted && side < f64::from(u16::MAX) {
            side *= 1.02;
        }
        side
    }
}
