use super::*;
use crate::measures::{Slab, nominal_solid_fraction};
use crate::{
    Amount, DepositRule, DepositSettings, LatticeKind, LatticeSettings, PackSettings, Radii,
    Snowfall, lattice_grains,
};
use core::f64::consts::PI;
use snowgrain_geometry::Quantisation;
use snowgrain_math::{DVec3, trig};

const R: f64 = 0.5e-3;

/// Snow by a rule, on a floor of so many radii.
fn fallen(rule: DepositRule, width: f64) -> (GrainField, [f64; 2]) {
    let quantisation = Quantisation::for_grains(DVec3::ZERO, R);
    let mut snow = Snowfall::on_level_floor(quantisation, [width * R; 2]).unwrap();
    snow.deposit(&DepositSettings {
        amount: Amount::Depth(60.0 * R),
        radii: Radii::equal(R),
        density: None,
        rule: Some(rule),
        max_slope_degrees: 90.0,
        direction: DepositSettings::DOWN,
        area: None,
        seed: 1,
    })
    .unwrap();
    let period = snow.period().unwrap();
    (snow.into_field(), period)
}

#[test]
fn mean_chords_in_air_are_those_of_the_theorem() {
    for (rule, width) in
        [(DepositRule::Stick, 160.0), (DepositRule::Roll, 130.0), (DepositRule::Ray, 120.0)]
    {
        let (field, period) = fallen(rule, width);
        let found = Structure::of(&field, Extent::Periodic(period), &|_| false);
        // 4 (1 - phi) / S_v (Underwood 1970), with the surface found by points on grains.
        let theorem = 4.0 * (1.0 - found.solid_fraction) / found.surface_per_volume;
        let off = found.mean_air_chord / theorem - 1.0;
        assert!(off.abs() < 0.01, "{rule:?}: {off}");
        if rule != DepositRule::Ray {
            // No overlaps: the surface is that of all grains.
            let slab = Slab::between_parts_of_depth(&field, Some(period), [0.2, 0.8]);
            let surface = 3.0 * nominal_solid_fraction(&field, &slab) / R;
            assert!((found.surface_per_volume / surface - 1.0).abs() < 0.01, "{rule:?}");
            let specific = found.specific_surface() * ICE_DENSITY * R / 3.0;
            assert!((specific - 1.0).abs() < 0.015, "{specific}");
        }
    }
}

#[test]
fn correlation_goes_from_the_solid_fraction_to_its_square_as_the_surface_says() {
    let (field, period) = fallen(DepositRule::Roll, 100.0);
    let found = Structure::of(&field, Extent::Periodic(period), &|_| false);
    let phi = found.solid_fraction;
    for directed in &found.along {
        let at = |index: usize| directed.correlation[index].1;
        assert!((at(0) / phi - 1.0).abs() < 0.02, "{}", at(0));
        // Debye, Anderson and Brumberger 1957: the slope at 0 is -S_v / 4.
        let step = directed.correlation[1].0;
        let expected = at(0) - step * found.surface_per_volume / 4.0;
        assert!((at(1) / expected - 1.0).abs() < 0.03, "{} {expected}", at(1));
        let far = directed.correlation.last().unwrap().1;
        assert!((far / (phi * phi) - 1.0).abs() < 0.06, "{far} {}", phi * phi);
    }
    assert!((0.9..1.15).contains(&found.anisotropy), "{}", found.anisotropy);
}

#[test]
fn draped_and_periodic_measures_of_the_same_snow_agree() {
    for rule in [DepositRule::Stick, DepositRule::Roll] {
        let (field, period) = fallen(rule, 140.0);
        let periodic = Structure::of(&field, Extent::Periodic(period), &|_| false);
        let draped = Structure::of(&field, Extent::Draped, &|_| false);
        let off = draped.density() / periodic.density() - 1.0;
        assert!(off.abs() < 0.03, "{rule:?}: {off}");
        let off = draped.surface_per_volume / periodic.surface_per_volume - 1.0;
        assert!(off.abs() < 0.03, "{rule:?}: {off}");
        let middle: f64 = draped.profile[2..8].iter().sum::<f64>() / 6.0;
        assert!((middle / draped.solid_fraction - 1.0).abs() < 0.05, "{:?}", draped.profile);
    }
}

#[test]
fn a_crystal_has_its_surface_and_its_neighbours() {
    let quantisation = Quantisation::for_grains(DVec3::ZERO, R);
    let (kind, counts) = (LatticeKind::Sc, [40; 3]);
    let settings = LatticeSettings { kind, counts, radius: R, spacing: None, density: None };
    let field = lattice_grains(&settings, &quantisation).unwrap();
    let found = Structure::of(&field, Extent::Block, &|_| false);
    // A sphere in each cube of two radii.
    assert!((found.surface_per_volume * R / (PI / 2.0) - 1.0).abs() < 0.01);
    assert!((found.solid_fraction / (PI / 6.0) - 1.0).abs() < 0.03, "{}", found.solid_fraction);
    assert_eq!(found.connections.connected_fraction, 1.0);
}

#[test]
fn sizes_are_those_that_were_asked_for() {
    let radii = Radii::log_normal(R, 1.2).unwrap();
    let quantum = Quantisation::for_grains(DVec3::ZERO, radii.largest()).quantum();
    let settings = PackSettings { radii: radii.clone(), density: 250.0, seed: 0 };
    let sizes = Sizes::of(&settings.make(quantum).unwrap().field);
    assert!((sizes.mean / radii.mean() - 1.0).abs() < 0.01);
    assert!((sizes.classes.iter().map(|class| class.1).sum::<f64>() - 1.0).abs() < 1e-9);
    assert!(sizes.range[0] < 0.7 * R && sizes.range[1] > 1.5 * R, "{:?}", sizes.range);
}

#[test]
fn nothing_is_measured_of_no_grains() {
    let quantisation = Quantisation::for_grains(DVec3::ZERO, R);
    let none = GrainField::new(quantisation, Vec::new());
    for extent in [Extent::Block, Extent::Draped, Extent::Periodic([1.0; 2])] {
        let found = Structure::of(&none, extent, &|_| false);
        assert_eq!((found.grains, found.solid_fraction), (0, 0.0));
    }
}

/// Upright cubes in a cubic lattice: all that is measured is known.
#[test]
fn cubes_in_a_lattice_have_their_own_volume_surface_and_chords() {
    use crate::FieldShapes;
    use snowgrain_geometry::{GrainShape, Shape, ShapeKind};
    let quantisation = Quantisation::for_grains(DVec3::ZERO, R);
    let (kind, counts, spacing) = (LatticeKind::Sc, [40; 3], Some(2.5 * R));
    let settings = LatticeSettings { kind, counts, radius: R, spacing, density: None };
    let field = lattice_grains(&settings, &quantisation).unwrap();
    let cube = Shape::new(ShapeKind::Cube { rounding: 0.0 }).unwrap();
    let of_grains = vec![GrainShape::upright(0); field.len()];
    let field = field.with_shapes(FieldShapes { prototypes: [cube].into(), of_grains });
    let found = Structure::of(&field, Extent::Block, &|_| false);
    let (edge, step) = (trig::cbrt(4.0 / 3.0 * PI) * R, 2.5 * R);
    let close = |found: f64, expected: f64, allowed: f64| {
        assert!((found / expected - 1.0).abs() < allowed, "{found} {expected}");
    };
    let cell = step * step * step;
    // The region holds no whole number of cells.
    close(found.solid_fraction, edge * edge * edge / cell, 0.04);
    close(found.surface_per_volume, 6.0 * edge * edge / cell, 0.04);
    for directed in &found.along {
        close(directed.mean_ice_chord, edge, 0.02);
        // Every chord in air along an axis that meets cubes is the gap.
        let (mut sum, mut all) = (0.0, 0.0);
        for (at, density) in &directed.air_chords {
            (sum, all) = (sum + at * density, all + density);
        }
        let class = directed.air_chords[1].0 - directed.air_chords[0].0;
        assert!((sum / all - (step - edge)).abs() <= 0.5 * class, "{}", sum / all);
        // Both ends of a shift of less than a gap lie in one cube.
        let (shift, both) = directed.correlation[2];
        close(both, found.solid_fraction * (1.0 - shift / edge), 0.03);
    }
    assert_eq!(found.connections.overlaps_per_grain, 0.0);
    assert!(found.connections.connected_fraction < 1e-3);
}

/// The same snow, once with spheres and once with spheres traced as shapes that are nearly spheres, has the same
/// structure.
#[test]
fn spheroids_that_are_nearly_spheres_are_measured_as_spheres() {
    use crate::FieldShapes;
    use snowgrain_geometry::{GrainShape, Shape, ShapeKind};
    let (spheres, period) = fallen(DepositRule::Ray, 60.0);
    let round = Shape::new(ShapeKind::Spheroid { aspect: 1.0001 }).unwrap();
    let of_grains = vec![GrainShape::upright(0); spheres.len()];
    let shaped = spheres.clone().with_shapes(FieldShapes { prototypes: [round].into(), of_grains });
    let [one, other] =
        [spheres, shaped].map(|field| Structure::of(&field, Extent::Periodic(period), &|_| false));
    let close = |a: f64, b: f64, allowed: f64| assert!((a / b - 1.0).abs() < allowed, "{a} {b}");
    close(other.solid_fraction, one.solid_fraction, 1e-3);
    close(other.surface_per_volume, one.surface_per_volume, 0.02);
    close(other.mean_air_chord, one.mean_air_chord, 5e-3);
    let (a, b) = (other.connections, one.connections);
    close(
        a.overlaps_per_grain + a.contacts_per_grain,
        b.overlaps_per_grain + b.contacts_per_grain,
        0.02,
    );
    close(a.mean_overlap_depth, b.mean_overlap_depth, 0.02);
    close(a.connected_fraction, b.connected_fraction, 0.01);
}
