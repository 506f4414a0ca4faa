//! The sizes of grains.

use super::super::super::SceneError;
use super::super::super::quantity::Length;
use super::super::ReadSizes;
use super::Body;
use snowgrain_grains::Radii;
use snowgrain_math::trig;

impl Body<'_> {
    pub(super) fn radius(&self) -> Result<f64, SceneError> {
        let radius = self.needed("radius", self.table.radius, "write radius = \"0.5 mm\"")?;
        Ok(self.checks.size(&self.key("radius"), radius)? * self.growth()?)
    }

    /// By how much water makes grains larger: it joins them (the paper, section 3).
    fn growth(&self) -> Result<f64, SceneError> {
        match self.table.wetness.unwrap_or(0.0) {
            wetness if (0.0..=1.0).contains(&wetness) => Ok(trig::cbrt(1.0 + wetness)),
            _ => Err(self.bad("wetness", "must be 0 to 1, the volume of water by that of ice")),
        }
    }

    pub(super) fn radii(&self, read_sizes: &mut ReadSizes<'_>) -> Result<Radii, SceneError> {
        let table = self.table;
        let one_of = |name: &str| {
            let mend = "`variation`, `spread` and `sizes` each say how radii differ; keep one";
            self.checks.misplaced(&self.key(name), mend)
        };
        match (table.variation, table.spread, &table.sizes) {
            (variation, None, None) => self.uniform(variation),
            (None, Some(deviation), None) => {
                let median = self.radius()?;
                Radii::log_normal(median, deviation)
                    .map_err(|_| self.bad("spread", "must be above 1 and at most 3, as 1.3"))
            }
            (None, None, Some(file)) => {
                if table.radius.is_some() {
                    let mend = "`sizes` says all radii; remove one of the two";
                    return Err(self.checks.misplaced(&self.key("radius"), mend));
                }
                let key = self.key("sizes");
                let path = self.checks.reference(&key, file)?;
                let classes =
                    read_sizes(&path).map_err(|cause| self.checks.unusable(&key, cause))?;
                let radii = Radii::measured(&classes)
                    .map_err(|cause| self.checks.unusable(&key, cause.into()))?;
                Ok(radii.in_units_of(1.0 / self.growth()?))
            }
            (_, Some(_), _) => Err(one_of("spread")),
            (Some(_), None, Some(_)) => Err(one_of("sizes")),
        }
    }

    fn uniform(&self, variation: Option<Length>) -> Result<Radii, SceneError> {
        let mean = self.radius()?;
        let variation = variation.unwrap_or(Length { metres: 0.0 }).metres;
        let variation = variation * self.growth()?;
        if !(variation >= 0.0 && variation <= mean) {
            let mend = format!("must be 0 to the radius, {mean} m");
            return Err(self.bad("variation", &mend));
        }
        Ok(Radii::Uniform { mean, variation })
    }
}
