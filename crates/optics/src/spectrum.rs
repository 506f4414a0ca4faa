//! Functions of wavelength.

/// A function of wavelength: values at increasing wavelengths, straight between them, and at the
/// ends' values beyond.
#[derive(Clone, Debug, PartialEq)]
pub struct Spectrum {
    wavelengths_nm: Vec<f64>,
    values: Vec<f64>,
}

impl Spectrum {
    /// The spectrum through these points; `None` where there is none, a number is not finite, or the
    /// wavelengths do not increase.
    #[must_use]
    pub fn new(wavelengths_nm: Vec<f64>, values: Vec<f64>) -> Option<Self> {
        let increase = wavelengths_nm.windows(2).all(|pair| pair[0] < pair[1]);
        let finite = wavelengths_nm.iter().chain(&values).all(|value| value.is_finite());
        let same = wavelengths_nm.len() == values.len() && !values.is_empty();
        (increase && finite && same).then_some(Self { wavelengths_nm, values })
    }

    /// The value at a wavelength, nm.
    #[must_use]
    pub fn at(&self, wavelength_nm: f64) -> f64 {
        let after = self.wavelengths_nm.partition_point(|&known| known <= wavelength_nm);
        let Some(before) = after.checked_sub(1) else { return self.values[0] };
        let Some(&next) = self.wavelengths_nm.get(after) else { return self.values[before] };
        let start = self.wavelengths_nm[before];
        let part = (wavelength_nm - start) / (next - start);
        self.values[before] + (self.values[after] - self.values[before]) * part
    }

    /// The same with all values times a number.
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Self {
        let values = self.values.iter().map(|value| value * factor).collect();
        Self { wavelengths_nm: self.wavelengths_nm.clone(), values }
    }

    /// First and last wavelength, nm.
    #[must_use]
    pub fn range_nm(&self) -> [f64; 2] {
        [self.wavelengths_nm[0], self.wavelengths_nm[self.wavelengths_nm.len() - 1]]
    }

    /// The points: wavelength in nm and value.
    pub fn points(&self) -> impl Iterator<Item = (f64, f64)> + '_ {
        self.wavelengths_nm.iter().copied().zip(self.values.iter().copied())
    }

    /// The integral over wavelength of its product with `other` between `from_nm` and `to_nm`, by
    /// steps of 1 nm (the trapezium rule on products at whole steps from `from_nm`): per nm, as the
    /// spectra are.
    #[must_use]
    pub fn integral_with(&self, from_nm: f64, to_nm: f64, other: impl Fn(f64) -> f64) -> f64 {
        let steps = (to_nm - from_nm).max(0.0).ceil().max(1.0);
        let step = (to_nm - from_nm) / steps;
        (0..=steps as u32)
            .map(|i| {
                let at = from_nm + step * f64::from(i);
                let end = i == 0 || f64::from(i) == steps;
                self.at(at) * other(at) * if end { 0.5 } else { 1.0 }
            })
            .sum::<f64>()
            * step
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_between_points_lie_on_a_line_and_beyond_them_stay() {
        let spectrum = Spectrum::new(vec![400.0, 500.0, 520.0], vec![1.0, 2.0, 0.0]).unwrap();
        for (wavelength, value) in
            [(300.0, 1.0), (400.0, 1.0), (450.0, 1.5), (500.0, 2.0), (515.0, 0.5), (600.0, 0.0)]
        {
            assert!((spectrum.at(wavelength) - value).abs() < 1e-12, "{wavelength}");
        }
        assert!((spectrum.integral_with(400.0, 520.0, |_| 1.0) - 170.0).abs() < 1e-9);
        assert!((spectrum.integral_with(400.0, 500.0, |_| 2.0) - 300.0).abs() < 1e-9);
    }

    #[test]
    fn points_that_are_no_function_are_refused() {
        assert!(Spectrum::new(vec![], vec![]).is_none());
        assert!(Spectrum::new(vec![400.0], vec![]).is_none());
        assert!(Spectrum::new(vec![400.0, 400.0], vec![1.0, 2.0]).is_none());
        assert!(Spectrum::new(vec![400.0, 500.0], vec![1.0, f64::NAN]).is_none());
    }
}
