//! A bit a cell of a box, in rows of whole words.

/// Bits of the cells of a box; beyond it none is set.
#[derive(Clone, Debug)]
pub(super) struct CellBits {
    cells: [i32; 3],
    words_per_row: usize,
    words: Vec<u64>,
}

impl CellBits {
    pub(super) fn new(cells: [i32; 3]) -> Self {
        let words_per_row = (cells[0] as usize).div_ceil(64);
        let rows = cells[1] as usize * cells[2] as usize;
        Self { cells, words_per_row, words: vec![0; words_per_row * rows] }
    }

    #[inline]
    pub(super) fn get(&self, cell: [i32; 3]) -> bool {
        let inside = (0..3).all(|axis| (0..self.cells[axis]).contains(&cell[axis]));
        inside && self.words[self.word(cell)] >> (cell[0] & 63) & 1 != 0
    }

    pub(super) fn set(&mut self, cell: [i32; 3]) {
        let word = self.word(cell);
        self.words[word] |= 1 << (cell[0] & 63);
    }

    pub(super) fn any(&self) -> bool {
        self.words.iter().any(|&word| word != 0)
    }

    pub(super) fn memory_bytes(&self) -> u64 {
        size_of_val(self.words.as_slice()) as u64
    }

    #[inline]
    fn word(&self, [x, y, z]: [i32; 3]) -> usize {
        let row = z as usize * self.cells[1] as usize + y as usize;
        row * self.words_per_row + (x as usize >> 6)
    }

    /// Those all of whose neighbours, up to so many cells away along each axis, are set.
    pub(super) fn eroded(&self, rings: u32) -> Self {
        let mut eroded = self.clone();
        for _ in 0..rings {
            eroded.erode_rows();
            eroded.erode_across(self.words_per_row);
            eroded.erode_planes();
        }
        eroded
    }

    fn erode_rows(&mut self) {
        for row in self.words.chunks_mut(self.words_per_row.max(1)) {
            let mut below = 0;
            for at in 0..row.len() {
                let word = row[at];
                let above = row.get(at + 1).copied().unwrap_or(0);
                row[at] = word & (word << 1 | below >> 63) & (word >> 1 | above << 63);
                below = word;
            }
        }
    }

    /// Along y, plane by plane.
    fn erode_across(&mut self, stride: usize) {
        let plane = stride * self.cells[1] as usize;
        self.words.chunks_mut(plane.max(1)).for_each(|plane| erode_along(plane, stride));
    }

    fn erode_planes(&mut self) {
        let plane = self.words_per_row * self.cells[1] as usize;
        erode_along(&mut self.words, plane);
    }
}

/// Erodes by one along the axis whose neighbours lie `stride` words apart.
fn erode_along(words: &mut [u64], stride: usize) {
    let mut below = vec![0; stride];
    for first in (0..words.len()).step_by(stride.max(1)) {
        for (at, below) in (first..).zip(&mut below) {
            let word = words[at];
            words[at] = word & *below & words.get(at + stride).copied().unwrap_or(0);
            *below = word;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_block_is_eroded_on_all_sides() {
        let cells = [140, 8, 10];
        let mut block = CellBits::new(cells);
        for (z, y) in (1..9).flat_map(|z| (1..8).map(move |y| (z, y))) {
            (2..139).for_each(|x| block.set([x, y, z]));
        }
        let twice = block.eroded(2);
        let mut count = 0;
        for (z, y) in (0..10).flat_map(|z| (0..8).map(move |y| (z, y))) {
            for x in 0..140 {
                let inside = (4..137).contains(&x) && (3..6).contains(&y) && (3..7).contains(&z);
                assert_eq!(twice.get([x, y, z]), inside, "{x} {y} {z}");
                count += i32::from(inside);
            }
        }
        assert_eq!(count, 133 * 3 * 4);
        assert!(twice.any() && !block.eroded(4).any());
        assert!(!block.get([-1, 3, 3]) && !block.get([140, 3, 3]), "beyond the box nothing is set");
    }
}
