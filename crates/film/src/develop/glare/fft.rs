//! The discrete Fourier transform of any length, with the same bits on every machine.
//!
//! Cooley and Tukey's, by the prime factors of the length (and 4); where one of them is large, Bluestein's, by a
//! transform of a power of two. Twiddle factors come from `snowgrain_math::trig`: libraries take them
//! from the platform, and choose instructions by the machine.

use core::f64::consts::PI;
use core::ops::{Add, Mul, Sub};
use snowgrain_math::trig;

/// A complex number.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Complex {
    pub(super) re: f64,
    pub(super) im: f64,
}

impl Complex {
    /// `e^(-2 pi i turns)`.
    pub(super) fn turned_back(turns: f64) -> Self {
        let (sin, cos) = trig::sin_cos(2.0 * PI * turns);
        Self { re: cos, im: -sin }
    }

    pub(super) fn conjugate(self) -> Self {
        Self { re: self.re, im: -self.im }
    }

    pub(super) fn scaled(self, factor: f64) -> Self {
        Self { re: self.re * factor, im: self.im * factor }
    }

    /// Times -i.
    fn quarter_back(self) -> Self {
        Self { re: self.im, im: -self.re }
    }
}

impl Add for Complex {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self { re: self.re + other.re, im: self.im + other.im }
    }
}

impl Sub for Complex {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        Self { re: self.re - other.re, im: self.im - other.im }
    }
}

impl Mul for Complex {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        Self {
            re: self.re * other.re - self.im * other.im,
            im: self.re * other.im + self.im * other.re,
        }
    }
}

/// Largest factor that is taken by its definition.
const LARGEST_FACTOR: usize = 31;

/// A transform of one length.
pub(super) struct Fft {
    factors: Vec<usize>,
    /// `e^(-2 pi i k / length)`.
    roots: Vec<Complex>,
    chirp: Option<Box<Chirp>>,
}

/// Bluestein's way to a length with a large prime factor.
struct Chirp {
    /// `e^(-pi i k^2 / length)`.
    chirp: Vec<Complex>,
    /// The transform of its conjugate, wrapped around.
    filter: Vec<Complex>,
    inner: Fft,
}

impl Fft {
    /// Of a length, at least 1.
    pub(super) fn new(length: usize) -> Self {
        let factors = factors(length);
        if factors.iter().any(|&factor| factor > LARGEST_FACTOR) {
            let chirp = Some(Box::new(Chirp::new(length)));
            return Self { factors: Vec::new(), roots: Vec::new(), chirp };
        }
        let root = |k: usize| Complex::turned_back(k as f64 / length as f64);
        Self { factors, roots: (0..length).map(root).collect(), chirp: None }
    }

    /// `output[k] = sum over j of input[j] e^(-2 pi i j k / length)`.
    pub(super) fn forward(&self, input: &[Complex], output: &mut [Complex]) {
        match &self.chirp {
            Some(chirp) => chirp.forward(input, output),
            None => self.part(input, 1, output, &self.factors),
        }
    }

    /// The inverse, with its factor 1 / length.
    pub(super) fn inverse(&self, input: &mut [Complex], output: &mut [Complex]) {
        let scale = 1.0 / input.len() as f64;
        input.iter_mut().for_each(|x| *x = x.conjugate());
        self.forward(input, output);
        output.iter_mut().for_each(|x| *x = x.conjugate().scaled(scale));
    }

    /// Of every `stride`th value of the input.
    fn part(&self, input: &[Complex], stride: usize, output: &mut [Complex], factors: &[usize]) {
        let Some((&factor, others)) = factors.split_first() else {
            output[0] = input[0];
            return;
        };
        let length = output.len() / factor;
        for (index, part) in output.chunks_exact_mut(length).enumerate() {
            self.part(&input[index * stride..], stride * factor, part, others);
        }
        let root = |k: usize| self.roots[k % self.roots.len()];
        let mut terms = [Complex::default(); LARGEST_FACTOR];
        for k in 0..length {
            for (index, term) in terms[..factor].iter_mut().enumerate() {
                *term = output[k + index * length] * root(index * k * stride);
            }
            let [a, b, c, d, ..] = terms;
            match factor {
                2 => (output[k], output[k + length]) = (a + b, a - b),
                4 => {
                    let (sum, difference) = (b + d, (b - d).quarter_back());
                    output[k] = a + c + sum;
                    output[k + length] = a - c + difference;
                    output[k + 2 * length] = a + c - sum;
                    output[k + 3 * length] = a - c - difference;
                }
                _ => {
                    for q in 0..factor {
                        let turned = |(index, &term): (usize, &Complex)| {
                            term * root(index * q * length * stride)
                        };
                        let all = terms[..factor].iter().enumerate().map(turned);
                        output[k + q * length] = all.fold(Complex::default(), Add::add);
                    }
                }
            }
        }
    }
}

impl Chirp {
    fn new(length: usize) -> Self {
        let double = 2 * length as u64;
        let chirp = |k: u64| Complex::turned_back(0.5 * (k * k % double) as f64 / length as f64);
        let chirp: Vec<_> = (0..length as u64).map(chirp).collect();
        let inner_length = (2 * length).next_power_of_two();
        let inner = Fft::new(inner_length);
        let mut wrapped = vec![Complex::default(); inner_length];
        for (k, turn) in chirp.iter().enumerate() {
            wrapped[k] = turn.conjugate();
            wrapped[(inner_length - k) % inner_length] = turn.conjugate();
        }
        let mut filter = vec![Complex::default(); inner_length];
        inner.forward(&wrapped, &mut filter);
        Self { chirp, filter, inner }
    }

    fn forward(&self, input: &[Complex], output: &mut [Complex]) {
        let mut padded = vec![Complex::default(); self.filter.len()];
        let turned = input.iter().zip(&self.chirp).map(|(x, turn)| *x * *turn);
        padded.iter_mut().zip(turned).for_each(|(to, x)| *to = x);
        let mut transformed = padded.clone();
        self.inner.forward(&padded, &mut transformed);
        transformed.iter_mut().zip(&self.filter).for_each(|(x, filter)| *x = *x * *filter);
        self.inner.inverse(&mut transformed, &mut padded);
        for ((to, x), turn) in output.iter_mut().zip(&padded).zip(&self.chirp) {
            *to = *x * *turn;
        }
    }
}

/// 4 as often as it goes, then primes.
fn factors(length: usize) -> Vec<usize> {
    let (mut rest, mut factors, mut factor) = (length, Vec::new(), 4);
    while rest > 1 {
        if rest.is_multiple_of(factor) {
            factors.push(factor);
            rest /= factor;
        } else {
            factor = match factor {
                4 => 2,
                2 => 3,
                odd if odd * odd > rest => rest,
                odd => odd + 2,
            };
        }
    }
    factors
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn any_length_is_transformed_as_defined_and_back() {
        for length in [1, 2, 3, 4, 8, 12, 30, 31, 37, 49, 60, 64, 74, 101, 128, 961] {
            let value = |k: usize| Complex::turned_back(0.37 * (k * k) as f64).scaled(k as f64);
            let input: Vec<_> = (0..length).map(value).collect();
            let fft = Fft::new(length);
            let mut output = vec![Complex::default(); length];
            fft.forward(&input, &mut output);
            for (k, found) in output.iter().enumerate().step_by(length / 16 + 1) {
                let terms = input.iter().enumerate().map(|(j, &x)| {
                    x * Complex::turned_back((j * k % length) as f64 / length as f64)
                });
                let error = *found - terms.fold(Complex::default(), Add::add);
                let size = (length * length) as f64;
                assert!(error.re.abs() + error.im.abs() < 1e-13 * size, "{length} {k}");
            }
            let mut back = vec![Complex::default(); length];
            fft.inverse(&mut output, &mut back);
            for (x, y) in back.iter().zip(&input) {
                let error = *x - *y;
                assert!(error.re.abs() + error.im.abs() < 1e-12 * length as f64, "{length}");
            }
        }
    }
}
