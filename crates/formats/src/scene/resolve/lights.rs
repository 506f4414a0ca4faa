//! What `[[light]]` means.

mod clear_day;

use super::super::SceneError;
use super::super::document::{
    LightFindingName, LightKindName, LightTable, ShapeKind, SpectrumName,
};
use super::super::quantity::{Length, Triple};
use super::ReadEnvironment;
use super::checks::Checks;
use super::surfaces;
use clear_day::ClearDay;
use core::ops::{Range, RangeInclusive};
use snowgrain_math::DVec3;
use snowgrain_optics::Illuminant;
use snowgrain_render::description::{
    LightDescription, LightFinding, LightKind, SearchSettings, Sought,
};
use std::sync::Arc;

/// Sine of the angle between edges up to which they are parallel.
const FLAT: f64 = 1e-9;

/// Paths that may measure a search.
const CALIBRATION_PATHS: RangeInclusive<u64> = 1_024..=1_000_000_000;

/// Keys that every kind takes, and that all but points do.
const SHARED: [&str; 3] = ["kind", "spectrum", "group"];
const VISIBLE: &str = "visible_to_camera";

/// Keys that a kind takes beside those.
fn keys_of(kind: LightKindName) -> &'static [&'static str] {
    match kind {
        LightKindName::Sky | LightKindName::Uniform | LightKindName::Overcast => &["radiance"],
        LightKindName::ClearSky => {
            &["strength", "units", "elevation", "azimuth", "time", "latitude", "longitude"]
        }
        LightKindName::Sun | LightKindName::SunSky => &[
            "strength",
            "units",
            "elevation",
            "azimuth",
            "time",
            "latitude",
            "longitude",
            "angular_diameter",
        ],
        LightKindName::Environment => &["file", "strength", "rotation"],
        LightKindName::Sphere => &["radiance", "center", "radius"],
        LightKindName::Quad => &["radiance", "corner", "edges"],
        LightKindName::Point => &["intensity", "position"],
        LightKindName::Spot => {
            &["intensity", "position", "direction", "inner_angle", "outer_angle"]
        }
    }
}

/// The lights of `[[light]]`, then those of the shot.
pub(super) fn lights(
    checks: &Checks<'_>,
    of_shot: Vec<LightDescription>,
    read_environment: &mut ReadEnvironment<'_>,
) -> Result<Vec<LightDescription>, SceneError> {
    let tables = &checks.document().light;
    let emits = checks.document().object.iter().any(|object| object.emission.is_some());
    if tables.is_empty() && of_shot.is_empty() && !emits {
        let mend = "the picture would be black; add [[light]] with kind = \"sky\"";
        return Err(checks.missing("light", mend));
    }
    let mut lights = Vec::new();
    for (index, table) in tables.iter().enumerate() {
        let light = Light { checks, index, table };
        light.refuse_foreign_keys()?;
        check_group(checks, &light.key("group"), table.group.as_deref())?;
        lights.extend(light.describe(read_environment)?);
    }
    lights.extend(of_shot);
    Ok(lights)
}

/// The light of the objects of this index in the file, by their indices in the scene; none where they are not
/// luminous.
pub(super) fn of_objects(
    checks: &Checks<'_>,
    index: usize,
    objects: Range<usize>,
) -> Result<Vec<LightDescription>, SceneError> {
    let table = &checks.document().object[index];
    let key = |name: &str| format!("object.{index}.{name}");
    let Some(emission) = table.emission else {
        let path = format!("object.{index}");
        let mut written = checks.written_keys(&path);
        return match written.find(|key| key.starts_with("emission_")) {
            Some(name) => Err(checks.misplaced(&key(name), "the object has no emission")),
            None => Ok(Vec::new()),
        };
    };
    if table.shape == ShapeKind::Plane {
        let mend = "a plane has no end and cannot be a lamp; use kind = \"quad\" of [[light]]";
        return Err(checks.misplaced(&key("emission"), mend));
    }
    let path = format!("object.{index}");
    let is_material = |key: &&str| surfaces::is_of_material(key) || key.ends_with(".albedo");
    if let Some(name) = checks.written_keys(&path).find(is_material) {
        let last = name.rsplit('.').next().unwrap_or(name);
        let mend = format!("an object with emission is black; remove the {last} or the emission");
        return Err(checks.misplaced(&key(name), mend));
    }
    let strength = checks.radiance(&key("emission"), emission)?;
    check_group(checks, &key("emission_group"), table.emission_group.as_deref())?;
    let light = |object| {
        let light = LightDescription::new(LightKind::Object { object }, strength);
        LightDescription {
            spectrum: table.emission_spectrum.map_or(Illuminant::D65, illuminant),
            group: table.emission_group.clone().unwrap_or(light.group.clone()),
            ..light
        }
    };
    Ok(objects.map(light).collect())
}

/// Refuses points, which no path meets, where light is only met.
fn refuse_points(checks: &Checks<'_>, lights: &[LightDescription]) -> Result<(), SceneError> {
    if !lights.iter().any(|light| light.kind.is_point()) {
        return Ok(());
    }
    let mend = "no path meets a light of kind \"point\" or \"spot\"; leave this out, or use kind = \"sphere\" \
                with a small radius";
    Err(checks.bad("integrator.light", mend))
}

/// How lights are found; never looked for where grains have shapes.
pub(super) fn finding(
    checks: &Checks<'_>,
    lights: &[LightDescription],
) -> Result<LightFinding, SceneError> {
    let table = &checks.document().integrator;
    let sought = match table.light {
        LightFindingName::Auto if lights.iter().all(LightDescription::is_sky) => None,
        LightFindingName::Exact => None,
        LightFindingName::Auto | LightFindingName::Sampled => Some(Sought::NotSkies),
        LightFindingName::AllSampled => Some(Sought::All),
    };
    let key = "integrator.calibration_paths";
    let paths = table.calibration_paths;
    let Some(sought) = sought else {
        refuse_points(checks, lights)?;
        return match paths {
            Some(_) => {
                Err(checks.misplaced(key, "no light is looked for in this scene; remove it"))
            }
            None => Ok(LightFinding::Exact),
        };
    };
    if paths.is_some_and(|paths| !CALIBRATION_PATHS.contains(&paths)) {
        return Err(checks.bad(key, "must be a whole number from 1024 to 1e9"));
    }
    let mut settings = SearchSettings::of(sought);
    settings.calibration_paths = paths.unwrap_or(settings.calibration_paths);
    Ok(LightFinding::Sampled(settings))
}

fn check_group(checks: &Checks<'_>, key: &str, group: Option<&str>) -> Result<(), SceneError> {
    match group {
        Some(group) if group.is_empty() || group.chars().any(char::is_control) => {
            Err(checks.bad(key, "must be a name, as \"lamps\""))
        }
        _ => Ok(()),
    }
}

/// One `[[light]]` under examination.
struct Light<'a> {
    checks: &'a Checks<'a>,
    index: usize,
    table: &'a LightTable,
}

impl Light<'_> {
    fn key(&self, name: &str) -> String {
        format!("light.{}.{name}", self.index)
    }

    fn bad(&self, name: &str, mend: &str) -> SceneError {
        self.checks.bad(&self.key(name), mend)
    }

    fn refuse_foreign_keys(&self) -> Result<(), SceneError> {
        let own = keys_of(self.table.kind);
        let is_point = |kind| matches!(kind, LightKindName::Point | LightKindName::Spot);
        let takes = |kind: LightKindName, key: &str| {
            keys_of(kind).contains(&key) || (key == VISIBLE && !is_point(kind))
        };
        let path = format!("light.{}", self.index);
        let mut written = self.checks.written_keys(&path);
        let foreign = |key: &&str| !SHARED.contains(key) && !takes(self.table.kind, key);
        let Some(name) = written.find(foreign) else {
            return Ok(());
        };
        let owners: Vec<String> = LightKindName::ALL
            .into_iter()
            .filter(|other| takes(*other, name))
            .map(|other| format!("\"{}\"", other.name()))
            .collect();
        let mend = format!(
            "not a key of kind = \"{}\" but of {}; remove it or change the kind ({} takes: {})",
            self.table.kind.name(),
            owners.join(", "),
            self.table.kind.name(),
            own.join(", "),
        );
        Err(self.checks.misplaced(&self.key(name), mend))
    }

    /// The lights that the table stands for.
    fn describe(
        &self,
        read_environment: &mut ReadEnvironment<'_>,
    ) -> Result<Vec<LightDescription>, SceneError> {
        let kind = match self.table.kind {
            LightKindName::Sky => LightKind::Sky,
            LightKindName::Uniform => LightKind::Uniform,
            LightKindName::Overcast => LightKind::Overcast,
            LightKindName::ClearSky => return Ok(vec![ClearDay::of(self)?.sky(self)?]),
            LightKindName::Sun => return Ok(vec![ClearDay::of(self)?.sun(self)?]),
            LightKindName::SunSky => {
                let day = ClearDay::of(self)?;
                return Ok(vec![day.sun(self)?, day.sky(self)?]);
            }
            LightKindName::Environment => return Ok(vec![self.environment(read_environment)?]),
            LightKindName::Sphere => self.sphere()?,
            LightKindName::Quad => self.quad()?,
            LightKindName::Point | LightKindName::Spot => return Ok(vec![self.point()?]),
        };
        let radiance = self.table.radiance.unwrap_or(Triple([1.0; 3]));
        let radiance = self.checks.radiance(&self.key("radiance"), radiance)?;
        Ok(vec![self.light(kind, radiance, Illuminant::D65)])
    }

    /// A light with this spectrum, where the table says none.
    fn light(&self, kind: LightKind, strength: [f32; 3], spectrum: Illuminant) -> LightDescription {
        let group = self.table.group.clone();
        LightDescription {
            group: group.unwrap_or_else(|| kind.default_group().to_owned()),
            kind,
            strength,
            spectrum: self.table.spectrum.map_or(spectrum, illuminant),
            visible_to_camera: self.table.visible_to_camera,
        }
    }

    fn environment(
        &self,
        read_environment: &mut ReadEnvironment<'_>,
    ) -> Result<LightDescription, SceneError> {
        let mend = "name the map, as file = \"sky.hdr\"";
        let key = self.key("file");
        let file = self.table.file.as_deref().ok_or_else(|| self.checks.missing(&key, mend))?;
        let path = self.checks.reference(&key, file)?;
        let rotation = self.table.rotation.unwrap_or(0.0);
        let [rotation] = self.checks.finite(&self.key("rotation"), [rotation])?;
        let strength = self.table.strength.unwrap_or(Triple([1.0; 3]));
        let strength = self.checks.radiance(&self.key("strength"), strength)?;
        let map = read_environment(&path).map_err(|cause| self.checks.unusable(&key, cause))?;
        let kind = LightKind::Environment {
            map: Arc::new(map),
            rotation_degrees: rotation.rem_euclid(360.0),
        };
        Ok(self.light(kind, strength, Illuminant::D65))
    }

    /// A place that the kind needs.
    fn place(&self, name: &str, place: Option<[Length; 3]>) -> Result<DVec3, SceneError> {
        let key = self.key(name);
        let mend = format!("say where, as {name} = [0, 1, 0]");
        self.checks.position(&key, place.ok_or_else(|| self.checks.missing(&key, mend))?)
    }

    fn sphere(&self) -> Result<LightKind, SceneError> {
        let key = self.key("radius");
        let mend = "say how large it is, as radius = \"1 cm\"";
        let radius = self.table.radius.ok_or_else(|| self.checks.missing(&key, mend))?;
        let radius = self.checks.size(&key, radius)?;
        Ok(LightKind::Sphere { center: self.place("center", self.table.center)?, radius })
    }

    fn quad(&self) -> Result<LightKind, SceneError> {
        let corner = self.place("corner", self.table.corner)?;
        let key = self.key("edges");
        let mend = "say how far it reaches, as edges = [[1, 0, 0], [0, 0, 1]]";
        let [u, v] = self.table.edges.ok_or_else(|| self.checks.missing(&key, mend))?;
        let [u, v] = [self.checks.position(&key, u)?, self.checks.position(&key, v)?];
        if u.cross(v).length() <= FLAT * u.length() * v.length() {
            let mend =
                "the edges are parallel or 0, so that no area shines; give two that span one";
            return Err(self.bad("edges", mend));
        }
        Ok(LightKind::Quad { corner, edges: [u, v] })
    }

    /// A point or a spot.
    fn point(&self) -> Result<LightDescription, SceneError> {
        let position = self.place("position", self.table.position)?;
        let kind = if self.table.kind == LightKindName::Spot {
            self.spot(position)?
        } else {
            LightKind::Point { position }
        };
        let intensity = self.table.intensity.unwrap_or(Triple([1.0; 3]));
        let intensity = self.checks.radiance(&self.key("intensity"), intensity)?;
        Ok(self.light(kind, intensity, Illuminant::D65))
    }

    fn spot(&self, position: DVec3) -> Result<LightKind, SceneError> {
        let direction = self.table.direction.unwrap_or([0.0, -1.0, 0.0]);
        let direction = DVec3::from(self.checks.finite(&self.key("direction"), direction)?);
        let Some(direction) = (direction / direction.abs().max_element()).try_normalize() else {
            return Err(self.bad("direction", "must not be zero; [0, -1, 0] is straight down"));
        };
        let inner_degrees = self.table.inner_angle.unwrap_or(20.0);
        let outer_degrees = self.table.outer_angle.unwrap_or(30.0);
        if !(0.0..180.0).contains(&inner_degrees) {
            return Err(self.bad("inner_angle", "must be at least 0 and below 180 degrees"));
        }
        if !(outer_degrees > inner_degrees && outer_degrees <= 180.0) {
            let mend =
                format!("must be above inner_angle, {inner_degrees}, and at most 180 degrees");
            return Err(self.bad("outer_angle", &mend));
        }
        Ok(LightKind::Spot { position, direction, inner_degrees, outer_degrees })
    }
}

fn illuminant(name: SpectrumName) -> Illuminant {
    match name {
        SpectrumName::D65 => Illuminant::D65,
        SpectrumName::D55 => Illuminant::D55,
        SpectrumName::A => Illuminant::A,
        SpectrumName::EqualEnergy => Illuminant::EqualEnergy,
    }
}
