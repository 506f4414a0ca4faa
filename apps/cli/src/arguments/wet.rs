//! `snowgrain optics wet` as typed.

use super::{MachineArguments, PlotFile, Series, TableFormat, laboratory_values, values};
use clap::{ArgGroup, Args};
use snowgrain_optics::IceAbsorption;
use std::path::PathBuf;

/// Wet snow: a layer whose pores fill with water, over black ground.
///
/// Three lines for each amount of water and wavelength, by model. `films`: grains at random places, each
/// coated with a film of water; films join and fill the pores; light meets every surface of air, water and
/// ice with its relative index (exact). `larger-grains`, the first thing that water does alone: spheres that
/// have the volume of ice and water together and their surface to air. `submerged`, the second alone: grains
/// as large as dry ones, of which the part that is as large as the saturation lies in water and hardly turns
/// light (asymptotic theory). The saturation is the part of the pores that is filled; liquid_water_percent,
/// the liquid water content, is water by volume of snow; wetness, the paper's W, water by volume of ice.
#[derive(Debug, Args)]
#[command(group = ArgGroup::new("water").args(["saturation", "liquid_water", "wetness"]))]
#[command(after_help = "Examples:\n  \
    snowgrain optics wet --radius 500um --density 300 --depth 2cm --wavelengths 550\n  \
    snowgrain optics wet --radius 500um --density 250 --depth 3cm --liquid-water 0,2,5,10 \\\n    \
        --wavelengths 450,550,650,1030 --paths 20000 -o wet.csv")]
pub(crate) struct WetArguments {
    /// Radius of the grains, as 500um
    #[arg(long, value_name = "LENGTH", value_parser = laboratory_values::radius)]
    pub(crate) radius: f64,

    /// Density of the dry snow, kg/m^3, at most 321
    #[arg(long, value_name = "KG/M3", default_value = "300",
          value_parser = laboratory_values::density)]
    pub(crate) density: f64,

    /// Depth, as 2cm
    #[arg(long, value_name = "LENGTH", value_parser = values::length)]
    pub(crate) depth: f64,

    /// Part of the pores that water fills, 0 to 1: a list, or FIRST:LAST:STEP [default: 0:1:0.1]
    #[arg(long, value_name = "S,...|FROM:TO:STEP", value_parser = laboratory_values::albedos)]
    pub(crate) saturation: Option<Series>,

    /// Liquid water content instead, per cent of the volume of snow
    #[arg(long, value_name = "PERCENT,...|FROM:TO:STEP",
          value_parser = laboratory_values::amounts)]
    pub(crate) liquid_water: Option<Series>,

    /// The paper's wetness W instead, volume of water by volume of ice
    #[arg(long, value_name = "W,...|FROM:TO:STEP", value_parser = laboratory_values::amounts)]
    pub(crate) wetness: Option<Series>,

    /// Wavelengths, nm: a list, or FIRST:LAST:STEP; 300 to 2500
    #[arg(long, value_name = "NM,...|FROM:TO:STEP", default_value = "550",
          value_parser = laboratory_values::wavelengths)]
    pub(crate) wavelengths: Series,

    /// Parallel light at this zenith angle, degrees [default: light from all of the sky alike]
    #[arg(long, value_name = "DEGREES", value_parser = laboratory_values::zenith)]
    pub(crate) sza: Option<f64>,

    /// Measurements of the absorption of ice: picard-2016 or warren-brandt-2008
    #[arg(long, value_name = "NAME", default_value = "picard-2016",
          value_parser = laboratory_values::ice_absorption)]
    pub(crate) ice_k: IceAbsorption,

    /// Paths for each amount of water and wavelength
    #[arg(long, value_name = "N", default_value_t = 10_000,
          value_parser = clap::value_parser!(u64).range(2..=1_000_000_000))]
    pub(crate) paths: u64,

    /// Seed of the random numbers
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub(crate) seed: u64,

    /// Draws it too, as SVG or PNG: R and T over the saturation
    #[arg(long, value_name = "FILE.svg|.png")]
    pub(crate) plot: Option<PlotFile>,

    /// What is printed
    #[arg(long, value_enum, default_value = "csv")]
    pub(crate) format: TableFormat,

    /// Writes it to a file instead
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,

    #[command(flatten)]
    pub(crate) machine: MachineArguments,

    /// Tells nothing but results and errors
    #[arg(short, long)]
    pub(crate) quiet: bool,
}
