//! Prints what each deposition rule fills at several depths, and how fast.
//!
//! `cargo run --release -p snowgrain-grains --example fills -- [ray|stick|roll] [grains] [width] [speed]`
//! (equal grains on a level periodic floor `width` radii wide, no slope discard).

use snowgrain_geometry::Quantisation;
use snowgrain_grains::measures::mean_surface_height;
use snowgrain_grains::{Amount, DepositRule, DepositSettings, Extent, PackReport, Radii, Snowfall};
use snowgrain_math::DVec3;
use std::time::Instant;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let rule = match arguments.first().map(String::as_str) {
        Some("stick") => DepositRule::Stick,
        Some("roll") => DepositRule::Roll,
        _ => DepositRule::Ray,
    };
    let grains = arguments.get(1).map_or(Ok(1_000_000), |text| text.parse())?;
    let width: f64 = arguments.get(2).map_or(Ok(120.0), |text| text.parse())?;
    let radius = 0.5e-3;
    let quantisation = Quantisation::for_grains(DVec3::ZERO, radius);
    let mut snow = Snowfall::on_level_floor(quantisation, [width * radius, width * radius])?;
    let start = Instant::now();
    let report = snow.deposit(&DepositSettings {
        amount: Amount::Grains(grains),
        radii: Radii::Uniform { mean: radius, variation: 0.0 },
        density: None,
        rule: Some(rule),
        max_slope_degrees: 90.0,
        direction: DepositSettings::DOWN,
        area: None,
        seed: 0,
    })?;
    let seconds = start.elapsed().as_secs_f64();
    let bytes = snow.bytes() as f64 / grains as f64;
    let period = snow.period().ok_or("a level floor repeats")?;
    let field = snow.into_field();
    println!(
        "{rule:?}: {report:?}, {:.2} M grains/s, {bytes:.1} B/grain",
        grains as f64 / seconds / 1e6
    );
    if arguments.get(3).is_some_and(|text| text == "speed") {
        return Ok(());
    }
    let floor = radius * (1.0 + 1e-3);
    let start = Instant::now();
    let pack = PackReport::of(&field, Extent::Periodic(period), &|grain| grain.center.y <= floor);
    let depth = mean_surface_height(&field, period);
    println!("{:.1} r deep: {pack}", depth / radius);
    println!("measured in {:.2} s", start.elapsed().as_secs_f64());
    Ok(())
}
