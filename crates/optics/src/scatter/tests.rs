use super::*;
use crate::PhaseTable;
use crate::sphere::{self, Polarisation};

const ICE: Dielectric = Dielectric { eta: 1.31 };

fn cosine_of_bin(bin: usize) -> f64 {
    let half_sine = (bin as f64 + 0.5) / BINS as f64;
    1.0 - 2.0 * half_sine * half_sine
}

fn energies(table: &ScatterTable) -> impl Iterator<Item = (f64, f64)> + '_ {
    (0..BINS).map(|bin| {
        let edge = |bin: usize| bin as f64 / BINS as f64;
        let solid_angle = 4.0 * PI * (edge(bin + 1) + edge(bin)) / BINS as f64;
        (cosine_of_bin(bin), table.density(cosine_of_bin(bin)) * solid_angle)
    })
}

#[test]
fn a_table_for_air_is_the_phase_function() {
    let table = ScatterTable::for_air(ICE);
    let total: f64 = energies(&table).map(|(_, energy)| energy).sum();
    let cosine: f64 = energies(&table).map(|(cosine, energy)| cosine * energy).sum();
    assert!((total - 1.0).abs() < 1e-5, "{total}");
    assert!((cosine - sphere::asymmetry(ICE)).abs() < 1e-4, "{cosine}");
    let phase = PhaseTable::new(ICE, Polarisation::Redrawn, &[0.0], 64);
    let mut sums = [0.0; 64];
    for (cosine, energy) in energies(&table) {
        sums[((0.5 + 0.5 * cosine) * 64.0) as usize] += energy;
    }
    for (bin, sum) in sums.iter().enumerate() {
        let expected = f64::from(phase.at((bin as f32 + 0.5) / 32.0 - 1.0)[0]) / 64.0;
        assert!((sum - expected).abs() < 4e-4 + 0.02 * expected, "{bin}: {sum} {expected}");
    }
}

#[test]
fn from_ice_comes_out_what_is_within_the_critical_angle() {
    for eta in [1.2, 1.31, 1.6, 0.98] {
        let table = ScatterTable::for_ice(Dielectric { eta });
        let total: f64 = energies(&table).map(|(_, energy)| energy).sum();
        let expected = (1.0 / (eta * eta)).min(1.0);
        assert!((total - expected).abs() < 1e-4, "{eta}: {total}");
    }
}

/// Every way must lead from the entry by its chords to its exit and there into the wanted direction.
#[test]
fn ways_lead_into_the_wanted_direction() {
    let tables = [(ScatterTable::for_air(ICE), true), (ScatterTable::for_ice(ICE), false)];
    for (table, from_air) in tables {
        let mut checked = 0;
        for bin in (0..BINS).step_by(7) {
            let cosine = cosine_of_bin(bin);
            let theta = trig::acos(cosine);
            for k in 0..20 {
                let random = [(f64::from(k) + 0.5) / 20.0, 0.3];
                let Some(way) = table.way(cosine, random) else { continue };
                checked += 1;
                // Incidence at the exit, from the wanted direction.
                let outside = wrapped(way.exit - theta).abs();
                assert!(outside <= FRAC_PI_2 + 0.05, "{theta} {way:?}");
                let sine = trig::sin_cos(outside.min(FRAC_PI_2)).0;
                let cos_t = (1.0 - sine * sine / (ICE.eta * ICE.eta)).sqrt();
                let chords = way.length / cos_t;
                // Whole chords, or odd halves of them.
                let count = chords / 2.0 - if from_air { 0.0 } else { 0.5 };
                let error = (count - count.round()).abs();
                assert!(error < 0.03 * (1.0 + count), "{theta} {way:?} {count}");
            }
        }
        assert!(checked > 2000, "{checked}");
    }
}

use core::f64::consts::FRAC_PI_2;
