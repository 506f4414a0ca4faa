//! `snowgrain measure search`.

use crate::arguments::LightSearchArguments;
use crate::budget::Budget;
use crate::failure::Failure;
use crate::load;
use crate::output;
use crate::progress::Progress;
use crate::threads::pool;
use serde::Serialize;
use snowgrain_accel::SimdLevel;
use snowgrain_film::PixelRect;
use snowgrain_render::transport::seek::{Agreement, Orders, Part};
use snowgrain_render::{CostEstimate, Scene};

pub(super) fn run(arguments: &LightSearchArguments) -> Result<u8, Failure> {
    let progress = Progress::new(arguments.quiet, false);
    let loaded = load::load(&arguments.scene, Vec::new())?;
    loaded.assumptions.iter().for_each(|line| progress.note(line));
    let description = &loaded.description;
    let size = [description.film.width, description.film.height];
    let whole = PixelRect::new(0, 0, size[0], size[1]);
    if let Some(budget) = Budget::of_this_machine(arguments.machine.max_memory) {
        let fits = budget.check(&CostEstimate::of(description, whole));
        fits.map_err(|failure| failure.of(&loaded.name))?;
    }
    let level = arguments.machine.simd.unwrap_or_else(SimdLevel::detect);
    let pool = pool(&arguments.machine)?;
    let agreements = pool.install(|| {
        let mut stage = |stage| progress.build_stage(stage, &description.snow);
        let scene = Scene::build_at(description, level, &mut stage)
            .map_err(|error| Failure::from(error).of(&loaded.name))?;
        let Some(search) = &scene.search else {
            let mend = "no light is looked for in this scene: give it a sun, a lamp or a map, or \
                        --set integrator.light=all-sampled";
            return Err(Failure::bad_input(mend).of(&loaded.name));
        };
        progress.stage("measuring");
        let (seen, paths) = ((&scene.world, &scene.camera), (size, arguments.paths));
        Ok(search.agreements(seen, paths, scene.film.seed, level))
    })?;
    progress.finish();
    let rows: Vec<Row> = agreements.iter().map(Row::new).collect();
    output::print(&if arguments.json { output::json(&rows)? } else { table(&rows) })?;
    Ok(0)
}

/// A part of the light.
#[derive(Debug, Serialize)]
struct Row {
    part: String,
    share: f64,
    bias: f64,
    standard_error: f64,
}

impl Row {
    fn new(agreement: &Agreement) -> Self {
        let Agreement { share, bias, standard_error, part } = *agreement;
        Self { part: name(part), share, bias, standard_error }
    }
}

fn name(part: Part) -> String {
    match part {
        Part::All => "all light".to_owned(),
        Part::FromIce => "from grain to grain through ice".to_owned(),
        Part::After(orders) => grains(orders),
        Part::Elevation(orders, [from, to]) => {
            format!("{}, elevation {from:+.0} to {to:+.0} degrees", grains(orders))
        }
        Part::Turn(orders, [from, to]) => {
            format!("{}, {from:.0} to {to:.0} degrees from the way back", grains(orders))
        }
    }
}

fn grains(Orders { first, last }: Orders) -> String {
    match last {
        None => format!("{first} grains or more"),
        Some(1) => "1 grain".to_owned(),
        Some(last) if first == last => format!("{first} grains"),
        Some(last) => format!("{first} to {last} grains"),
    }
}

fn table(rows: &[Row]) -> String {
    let width = rows.iter().map(|row| row.part.len()).max().unwrap_or(0);
    let header =
        format!("{:width$}  {:>7}  {:>8}  {:>14}\n", "light", "share", "bias", "standard error");
    let percent = |number: f64| 100.0 * number;
    rows.iter().fold(header, |text, row| {
        let Row { part, share, bias, standard_error } = row;
        let (share, bias, error) = (percent(*share), percent(*bias), percent(*standard_error));
        format!("{text}{part:width$}  {share:>5.2} %  {bias:>+6.2} %  {error:>12.2} %\n")
    })
}
