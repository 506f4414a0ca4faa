//! Bodies of packed grains: `source = "pack"` and `"fill"`.

use super::super::super::SceneError;
use super::super::super::quantity::{Length, Triple};
use super::super::objects::{self, Placement};
use super::{Body, SnowFiles};
use snowgrain_geometry::TriangleMesh;
use snowgrain_grains::{Body as Filled, FillSettings, HeightField, PackSettings, PlanImage, Solid};
use snowgrain_math::{Aabb, DVec3};
use std::path::Path;
use std::sync::Arc;

impl Body<'_> {
    pub(super) fn pack(
        &self,
        files: &mut SnowFiles<'_, '_, '_>,
    ) -> Result<FillSettings, SceneError> {
        let mend = "say what is filled, as box = [0, 0, 0, 0.1, 0.05, 0.1]";
        let corners = self.needed("box", self.table.block, mend)?;
        let [x0, y0, z0, x1, y1, z1] = self.checks.coordinates(&self.key("box"), corners)?;
        if !(x0 < x1 && y0 < y1 && z0 < z1) {
            let mend = "must be [x0, y0, z0, x1, y1, z1] with x0 < x1, y0 < y1 and z0 < z1";
            return Err(self.bad("box", mend));
        }
        let block = Aabb::new(DVec3::new(x0, y0, z0), DVec3::new(x1, y1, z1));
        Ok(FillSettings {
            pack: self.packed(files)?,
            body: Filled::Box(block),
            mask: None,
            density_map: None,
        })
    }

    pub(super) fn fill(
        &self,
        files: &mut SnowFiles<'_, '_, '_>,
    ) -> Result<FillSettings, SceneError> {
        let mend = "name a mesh or a picture of heights, as file = \"drift.obj\"";
        let file = self.needed("file", self.table.file.as_deref(), mend)?;
        let extension = Path::new(file).extension().unwrap_or_default().to_ascii_lowercase();
        let is_picture =
            ["png", "jpg", "jpeg", "exr", "hdr"].iter().any(|picture| extension == *picture);
        let body = if is_picture {
            self.refuse_keys(&["scale", "rotate", "translate"], "a picture", "a mesh")?;
            Filled::Heights(Arc::new(self.heights(file, files)?))
        } else {
            self.refuse_keys(&["height"], "a mesh", "a picture of heights")?;
            if self.table.mask.is_none() && self.table.density_map.is_none() {
                self.refuse_keys(
                    &["area"],
                    "a mesh",
                    "a mask, a density map or a picture of heights",
                )?;
            }
            Filled::Solid(Arc::new(self.solid(file, files)?))
        };
        let mask = match &self.table.mask {
            Some(mask) => Some(Arc::new(self.plan_image("mask", mask, files)?)),
            None => None,
        };
        let density_map = match &self.table.density_map {
            Some(map) => {
                let parts = self.plan_image("density_map", map, files)?.check_parts();
                let key = self.key("density_map");
                Some(Arc::new(parts.map_err(|cause| self.checks.unusable(&key, cause.into()))?))
            }
            None => None,
        };
        Ok(FillSettings { pack: self.packed(files)?, body, mask, density_map })
    }

    /// # Errors
    /// A key that was written though it belongs to something else.
    fn refuse_keys(&self, keys: &[&str], this: &str, owner: &str) -> Result<(), SceneError> {
        let path = format!("snow.{}", self.index);
        let foreign = self.checks.written_keys(&path).find(|key| keys.contains(key));
        foreign.map_or(Ok(()), |key| {
            let mend = format!("the file is {this}, but this is a key of {owner}; remove it");
            Err(self.checks.misplaced(&self.key(key), mend))
        })
    }

    /// The snow that it is filled with.
    fn packed(&self, files: &mut SnowFiles<'_, '_, '_>) -> Result<PackSettings, SceneError> {
        let radii = self.radii(files.sizes)?;
        let mend = "say how dense the snow is, in kg/m^3, as density = 250";
        let density = self.needed("density", self.density()?, mend)?;
        let pack = PackSettings { radii, density, seed: self.table.seed.unwrap_or(0) };
        let ratio = self.grains.absorption.density_ratio();
        let counted = if ratio == 1.0 {
            String::new()
        } else {
            format!(
                "; that is of ice of the same solid fraction, and this is {ratio:.3} times as dense"
            )
        };
        pack.check().map_err(|cause| self.bad("density", &format!("{cause}{counted}")))?;
        Ok(pack)
    }

    /// The inside of a mesh in its place.
    fn solid(&self, file: &str, files: &mut SnowFiles<'_, '_, '_>) -> Result<Solid, SceneError> {
        let key = self.key("file");
        let mesh = objects::mesh(self.checks, &key, file, files.objects)?;
        let placement = Placement {
            scale: self.table.scale.unwrap_or(Triple([1.0; 3])),
            rotate: self.table.rotate.unwrap_or([0.0; 3]),
            translate: self.table.translate.unwrap_or([Length { metres: 0.0 }; 3]),
        };
        let path = format!("snow.{}", self.index);
        let transform = objects::transform(self.checks, &path, &placement)?;
        objects::check_reach(self.checks, &format!("{path}.scale"), &mesh.bounds(), &transform)?;
        let placed = TriangleMesh {
            positions: mesh.positions.iter().map(|&at| transform.transform_point3(at)).collect(),
            triangles: mesh.triangles.clone(),
            coordinates: Vec::new(),
        };
        let solid = match self.base()? {
            Some(base) => Solid::under(&placed, base),
            None => Solid::new(&placed),
        };
        solid.map_err(|cause| self.checks.unusable(&key, cause.into()))
    }

    fn heights(
        &self,
        file: &str,
        files: &mut SnowFiles<'_, '_, '_>,
    ) -> Result<HeightField, SceneError> {
        let mend = "say how high white is, as height = \"10 cm\"";
        let height = self.needed("height", self.table.height, mend)?;
        let height = self.checks.size(&self.key("height"), height)?;
        let base = self.base()?.unwrap_or(0.0);
        Ok(HeightField { image: self.plan_image("file", file, files)?, height, base })
    }

    fn base(&self) -> Result<Option<f64>, SceneError> {
        let Some(base) = self.table.base else { return Ok(None) };
        self.checks.coordinates(&self.key("base"), [base]).map(|[base]| Some(base))
    }

    /// A picture over `area`.
    fn plan_image(
        &self,
        name: &str,
        file: &str,
        files: &mut SnowFiles<'_, '_, '_>,
    ) -> Result<PlanImage, SceneError> {
        let key = self.key(name);
        let mend = "say over what the picture lies, as area = [-0.1, -0.1, 0.1, 0.1]";
        let area = self.needed("area", self.area()?, mend)?;
        let path = self.checks.reference(&key, file)?;
        let unusable = |cause| self.checks.unusable(&key, cause);
        let (size, values) = (files.plan_image)(&path).map_err(unusable)?;
        PlanImage::new(size, values, area).map_err(|cause| self.checks.unusable(&key, cause.into()))
    }
}
