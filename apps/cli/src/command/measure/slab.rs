//! `snowgrain measure slab`.

use super::Figure;
use super::snow::{self, MeasuredSnow, USUAL_RADIUS};
use crate::arguments::{Side, SlabArguments};
use crate::budget::Budget;
use crate::failure::Failure;
use crate::output;
use crate::progress::Progress;
use crate::summary::grouped;
use crate::threads::pool;
use core::f64::consts::PI;
use serde::Serialize;
use snowgrain_accel::SimdLevel;
use snowgrain_formats::read_grains;
use snowgrain_grains::{Amount, DepositSettings, Radii};
use snowgrain_optics::{Dielectric, sphere};
use snowgrain_render::CostEstimate;
use snowgrain_render::measure::{Estimate, Incidence, SlabMeasure, SlabSettings, measure_slab};
use std::fmt::Write;

pub(super) fn run(arguments: &SlabArguments) -> Result<u8, Failure> {
    let tracing = &arguments.tracing;
    let progress = Progress::new(tracing.quiet, false);
    let level = tracing.machine.simd.unwrap_or_else(SimdLevel::detect);
    let pool = pool(&tracing.machine)?;
    progress.stage("snow");
    let snow = snow(arguments)?;
    progress.stage("measuring");
    let size = snow.hull.size();
    let settings = SlabSettings {
        top: snow.hull.max.y,
        bottom: snow.hull.min.y,
        period: [size.x, size.z],
        incidence: arguments.incidence,
        from_below: false,
        absorption_per_metre: arguments.absorption,
        paths: tracing.paths,
        seed: tracing.seed,
        level,
    };
    let face = |from_below| measure_slab(&snow.world, &SlabSettings { from_below, ..settings });
    let (measure, from) = pool.install(|| match arguments.from {
        Side::Above => (face(false), "above"),
        Side::Below => (face(true), "below"),
        Side::Both => (mean_of(&face(false), &face(true)), "both"),
    });
    progress.finish();
    let figures = Figures::new(&snow, &settings, from, &measure);
    output::print(&if tracing.json { output::json(&figures)? } else { figures.text() })?;
    Ok(0)
}

/// The mean of two measures of as many paths each.
fn mean_of(above: &SlabMeasure, below: &SlabMeasure) -> SlabMeasure {
    let mean = |part: fn(&SlabMeasure) -> Estimate| {
        let (a, b) = (part(above), part(below));
        let variance = a.standard_error * a.standard_error + b.standard_error * b.standard_error;
        Estimate { mean: 0.5 * (a.mean + b.mean), standard_error: 0.5 * variance.sqrt() }
    };
    let means = |part: fn(&SlabMeasure) -> &[f64]| {
        part(above).iter().zip(part(below)).map(|(a, b)| 0.5 * (a + b)).collect()
    };
    SlabMeasure {
        paths: above.paths + below.paths,
        reflectance: mean(|m| m.reflectance),
        transmittance: mean(|m| m.transmittance),
        grain_visits: mean(|m| m.grain_visits),
        interface_events: mean(|m| m.interface_events),
        ice_path: mean(|m| m.ice_path),
        void_path: mean(|m| m.void_path),
        visits_histogram: means(|m| &m.visits_histogram),
        reflected_by_visits: means(|m| &m.reflected_by_visits),
        trapped_paths: above.trapped_paths + below.trapped_paths,
    }
}

fn snow(arguments: &SlabArguments) -> Result<MeasuredSnow, Failure> {
    let tracing = &arguments.tracing;
    let budget = Budget::of_this_machine(tracing.machine.max_memory);
    let fits = |grains: u64| {
        budget.map_or(Ok(()), |budget| budget.check(&CostEstimate::of_grains(grains)))
    };
    let radius = tracing.radius.unwrap_or(USUAL_RADIUS);
    if let (Some(kind), Some(layers)) = (arguments.lattice, arguments.layers) {
        return snow::crystal(kind, [1, layers, 1], radius, true, tracing.ior);
    }
    if let (Some(path), Some(period)) = (&arguments.file, arguments.period) {
        let field = read_grains(path)?;
        fits(field.len() as u64)?;
        return snow::repeated(field, period, tracing.ior)
            .map_err(|failure| failure.of(&path.display().to_string()));
    }
    let (Some(rule), Some(width), Some(grains)) =
        (arguments.rule, arguments.width, arguments.grains)
    else {
        return Err(Failure::usage(
            "give --lattice with --layers, --rule with --width and --grains, or --file with \
             --period",
        ));
    };
    fits(grains)?;
    let settings = DepositSettings {
        amount: Amount::Grains(grains),
        radii: Radii::Uniform { mean: radius, variation: arguments.variation.unwrap_or(0.0) },
        density: None,
        rule: Some(rule),
        max_slope_degrees: 90.0,
        direction: DepositSettings::DOWN,
        area: None,
        seed: tracing.seed,
    };
    snow::fallen(&settings, width, tracing.ior)
}

/// What the measure found; lengths in metres.
#[derive(Debug, Serialize)]
struct Figures {
    grains: u64,
    period: [f64; 2],
    faces: [f64; 2],
    tau: f64,
    solid_fraction: f64,
    incidence: String,
    from: &'static str,
    paths: u64,
    trapped_paths: u64,
    reflectance: Figure,
    transmittance: Figure,
    grain_visits: Figure,
    interface_events: Figure,
    events_per_visit: f64,
    ice_path: Figure,
    void_path: Figure,
    void_chord: Figure,
    visits_histogram: Vec<f64>,
    reflected_by_visits: Vec<f64>,
}

impl Figures {
    fn new(
        snow: &MeasuredSnow,
        settings: &SlabSettings,
        from: &'static str,
        measure: &SlabMeasure,
    ) -> Self {
        let size = snow.hull.size();
        let area = size.x * size.z;
        let tau = PI * snow.sums.squares / area;
        let phi = snow.sums.volume() / (area * size.y);
        let radius = snow.sums.effective_radius();
        let ice = sphere::absorption_enhancement(Dielectric { eta: snow.world.eta });
        let (visits, void) = (measure.grain_visits, measure.void_path);
        let chord = Figure {
            mean: void.mean / visits.mean,
            // Void and visits of a path rise together: the error of their ratio is no more.
            standard_error: void.standard_error / visits.mean,
            expected: None,
        };
        // The identities are those of diffuse light.
        let expecting = |figure: Figure, value: f64| match settings.incidence {
            Incidence::Lambertian => figure.expecting(value),
            Incidence::Collimated { .. } => figure,
        };
        Self {
            grains: snow.sums.grains,
            period: settings.period,
            faces: [settings.bottom, settings.top],
            tau,
            solid_fraction: phi,
            incidence: match settings.incidence {
                Incidence::Lambertian => "lambertian".into(),
                Incidence::Collimated { zenith_degrees } => format!("{zenith_degrees} degrees"),
            },
            from,
            paths: measure.paths,
            trapped_paths: measure.trapped_paths,
            reflectance: Figure::of(measure.reflectance),
            transmittance: Figure::of(measure.transmittance),
            grain_visits: expecting(Figure::of(visits), 2.0 * tau),
            interface_events: expecting(Figure::of(measure.interface_events), 4.0 * tau),
            events_per_visit: measure.interface_events.mean / visits.mean,
            ice_path: expecting(Figure::of(measure.ice_path), 2.0 * tau * 4.0 / 3.0 * ice * radius),
            void_path: Figure::of(void),
            void_chord: expecting(chord, 4.0 / 3.0 * radius * (1.0 - phi) / phi),
            visits_histogram: measure.visits_histogram.clone(),
            reflected_by_visits: measure.reflected_by_visits.clone(),
        }
    }

    fn text(&self) -> String {
        let [x, z] = self.period;
        let [bottom, top] = self.faces;
        let mut text = format!(
            "snow        {} grains in a period of {x:.6} x {z:.6} m between y = {bottom:.6} and \
             {top:.6} m\n\
             tau         {:.6}\n\
             phi         {:.6}\n\
             light       {} from {}, {} paths, {} trapped\n\
             R           {}\n\
             T           {}\n\
             R + T       {:.9}\n\
             visits      {}\n\
             events      {}, {:.5} a visit\n\
             ice path    {} (m)\n\
             void path   {} (m)\n\
             void chord  {} (m)\n\
             visits  fraction of paths  reflected fraction\n",
            grouped(self.grains),
            self.tau,
            self.solid_fraction,
            self.incidence,
            self.from,
            grouped(self.paths),
            self.trapped_paths,
            self.reflectance.text(""),
            self.transmittance.text(""),
            self.reflectance.mean + self.transmittance.mean,
            self.grain_visits.text("2 tau"),
            self.interface_events.text("4 tau"),
            self.events_per_visit,
            self.ice_path.text("2 tau (4/3) B r"),
            self.void_path.text(""),
            self.void_chord.text("(4/3) r (1 - phi) / phi"),
        );
        let last = self.visits_histogram.len().saturating_sub(1);
        let rows = self.visits_histogram.iter().zip(&self.reflected_by_visits);
        for (order, (fraction, reflected)) in rows.enumerate() {
            let more = if order == last { "+" } else { " " };
            // Writing to a string does not fail.
            let _ = writeln!(text, "{order:5}{more}  {fraction:17.6}  {reflected:18.6}");
        }
        text
    }
}
