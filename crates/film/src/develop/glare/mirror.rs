//! Convolution of a picture that goes on mirrored beyond its edges.
//!
//! With mirrored edges the convolution is a symmetric matrix whose rows add up to the sum of the kernel. So do its
//! columns: no light is lost at an edge, and a constant picture stays as it is. Its
//! eigenvectors are those of the discrete cosine transform (DCT-II), which is found by a complex
//! transform of the same length (J. Makhoul 1980, IEEE Trans. ASSP 28, 27); as everything
//! is linear, two channels go through it as one complex picture.

use super::fft::{Complex, Fft};
use crate::FilmError;

/// A cosine transform of one length.
struct Dct {
    fft: Fft,
    /// `e^(-i pi k / (2 length))`.
    turns: Vec<Complex>,
    scratch: [Vec<Complex>; 2],
}

impl Dct {
    fn new(length: usize) -> Self {
        let turn = |k: usize| Complex::turned_back(0.25 * k as f64 / length as f64);
        Self {
            fft: Fft::new(length),
            turns: (0..length).map(turn).collect(),
            scratch: [(); 2].map(|()| vec![Complex::default(); length]),
        }
    }

    /// `row[k] = 2 sum over n of row[n] cos(pi k (2 n + 1) / (2 length))`.
    fn forward(&mut self, row: &mut [Complex]) {
        let length = row.len();
        let [ordered, transformed] = &mut self.scratch;
        for n in 0..length {
            ordered[Self::place(n, length)] = row[n];
        }
        self.fft.forward(ordered, transformed);
        for (k, value) in row.iter_mut().enumerate() {
            let turn = self.turns[k];
            let opposite = transformed[(length - k) % length];
            *value = transformed[k] * turn + opposite * turn.conjugate();
        }
    }

    fn inverse(&mut self, row: &mut [Complex]) {
        let length = row.len();
        let [spectrum, ordered] = &mut self.scratch;
        for k in 0..length {
            let opposite = if k == 0 { Complex::default() } else { row[length - k] };
            let turned = Complex { re: row[k].re + opposite.im, im: row[k].im - opposite.re };
            spectrum[k] = (turned * self.turns[k].conjugate()).scaled(0.5);
        }
        self.fft.inverse(spectrum, ordered);
        for n in 0..length {
            row[n] = ordered[Self::place(n, length)];
        }
    }

    /// Even places forward, then odd ones backward.
    fn place(n: usize, length: usize) -> usize {
        if n.is_multiple_of(2) { n / 2 } else { length - 1 - n / 2 }
    }
}

/// A convolution by a kernel that is the same in all four quadrants.
pub(super) struct Mirror {
    width: usize,
    height: usize,
    rows: Dct,
    columns: Dct,
    /// Of the convolution, column by column.
    eigenvalues: Vec<f64>,
}

impl Mirror {
    /// `quadrant` holds, row by row, the weights of offsets of `0..width` columns and `0..height` rows.
    ///
    /// # Errors
    /// More than memory.
    pub(super) fn new(width: usize, height: usize, quadrant: &[f64]) -> Result<Self, FilmError> {
        let (rows, columns) = (Dct::new(width), Dct::new(height));
        let mut mirror = Self { width, height, rows, columns, eigenvalues: Vec::new() };
        let weight = |x: usize, y: usize| {
            if x < width && y < height { quadrant[y * width + x] } else { 0.0 }
        };
        // What the convolution makes of a light in the corner, and that of the light itself.
        let mut corner: Vec<Complex> = zeros(width * height)?;
        for (index, value) in corner.iter_mut().enumerate() {
            let (x, y) = (index % width, index / width);
            value.re = weight(x, y) + weight(x + 1, y) + weight(x, y + 1) + weight(x + 1, y + 1);
        }
        let spread = mirror.transformed(corner)?;
        mirror.eigenvalues.try_reserve_exact(spread.len()).map_err(|_| too_large(spread.len()))?;
        let (rows, columns) = (&mirror.rows.turns, &mirror.columns.turns);
        let alone = rows.iter().flat_map(|x| columns.iter().map(move |y| 4.0 * x.re * y.re));
        mirror
            .eigenvalues
            .extend(spread.iter().zip(alone).map(|(spread, alone)| spread.re / alone));
        Ok(mirror)
    }

    /// Convolves two pictures, one in the real and one in the imaginary part.
    ///
    /// # Errors
    /// More than memory.
    pub(super) fn convolve(&mut self, pictures: Vec<Complex>) -> Result<Vec<Complex>, FilmError> {
        let mut spectrum = self.transformed(pictures)?;
        let scaled = spectrum.iter_mut().zip(&self.eigenvalues);
        scaled.for_each(|(value, factor)| *value = value.scaled(*factor));
        spectrum.chunks_exact_mut(self.height).for_each(|column| self.columns.inverse(column));
        let mut pictures = transposed(&spectrum, self.height)?;
        drop(spectrum);
        pictures.chunks_exact_mut(self.width).for_each(|row| self.rows.inverse(row));
        Ok(pictures)
    }

    /// The cosine transform, column by column.
    fn transformed(&mut self, mut pictures: Vec<Complex>) -> Result<Vec<Complex>, FilmError> {
        pictures.chunks_exact_mut(self.width).for_each(|row| self.rows.forward(row));
        let mut spectrum = transposed(&pictures, self.width)?;
        spectrum.chunks_exact_mut(self.height).for_each(|column| self.columns.forward(column));
        Ok(spectrum)
    }
}

/// The columns of rows of this length, one after another.
fn transposed(rows: &[Complex], length: usize) -> Result<Vec<Complex>, FilmError> {
    let mut columns = zeros(rows.len())?;
    let height = rows.len() / length;
    for (y, row) in rows.chunks_exact(length).enumerate() {
        row.iter().enumerate().for_each(|(x, value)| columns[x * height + y] = *value);
    }
    Ok(columns)
}

/// So many zeros.
pub(super) fn zeros<T: Clone + Default>(count: usize) -> Result<Vec<T>, FilmError> {
    let mut values = Vec::new();
    values.try_reserve_exact(count).map_err(|_| too_large(count))?;
    values.resize(count, T::default());
    Ok(values)
}

fn too_large(pixels: usize) -> FilmError {
    FilmError::TooLarge { pixels: pixels as u64, bytes: pixels as u128 * 112 }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Distances of a place from a source and from its mirror images beyond both edges.
    fn distances(place: usize, source: usize, length: usize) -> [usize; 3] {
        [place.abs_diff(source), place + 1 + source, 2 * length - 1 - source - place]
    }

    /// The convolution as it is defined: every source and its mirror images.
    fn by_hand(width: usize, height: usize, quadrant: &[f64], light: &[f64]) -> Vec<f64> {
        let received = |index: usize| {
            let mut sum = 0.0;
            for (source, light) in light.iter().enumerate() {
                for dx in distances(index % width, source % width, width) {
                    for dy in distances(index / width, source / width, height) {
                        if dx < width && dy < height {
                            sum += light * quadrant[dy * width + dx];
                        }
                    }
                }
            }
            sum
        };
        (0..light.len()).map(received).collect()
    }

    #[test]
    fn it_is_the_convolution_of_the_mirrored_picture() {
        for (width, height) in [(1, 1), (5, 1), (6, 4), (7, 9), (37, 5)] {
            let count = width * height;
            let quadrant: Vec<f64> = (0..count).map(|i| 1.0 / (1.0 + i as f64)).collect();
            let first: Vec<f64> = (0..count).map(|i| (i * 7 % 11) as f64).collect();
            let second: Vec<f64> =
                (0..count).map(|i| if i == 2 % count { 50.0 } else { 0.0 }).collect();
            let both = first.iter().zip(&second).map(|(&re, &im)| Complex { re, im }).collect();
            let mut mirror = Mirror::new(width, height, &quadrant).unwrap();
            let found = mirror.convolve(both).unwrap();
            let expected = [first, second].map(|light| by_hand(width, height, &quadrant, &light));
            for (index, found) in found.iter().enumerate() {
                let error =
                    (found.re - expected[0][index]).abs() + (found.im - expected[1][index]).abs();
                assert!(error < 1e-9 * (1.0 + expected[0][index]), "{width}x{height}: {error}");
            }
        }
    }
}
