//! The snow laboratory on the command line.

use crate::Workplace;

const COLUMNS: &str = "method,wavelength_nm,radius_um,sza_deg,depth_m,R,R_stderr,T,T_stderr,A";

/// Rows of a table of comma-separated values, without the line of names.
pub(super) fn rows(csv: &str) -> Vec<Vec<&str>> {
    csv.lines().skip(1).map(|line| line.split(',').collect()).collect()
}

#[test]
fn albedos_come_for_every_combination_and_are_the_same_on_any_machine() {
    let place = Workplace::new();
    let arguments = [
        "optics",
        "albedo",
        "--radius",
        "150 um,1mm",
        "--density",
        "250",
        "--depth",
        "0.03,inf",
        "--wavelengths",
        "420,1030",
        "--diffuse",
        "--sza",
        "45",
        "--impurity",
        "black-carbon=0ppb,100ppb",
        "--method",
        "homogeneous,two-stream",
        "--stderr",
        "0.02",
    ];
    let with = |more: &[&str]| place.run(&[&arguments[..], more].concat());
    let one = with(&["--threads", "1", "--simd", "sse2"]);
    assert_eq!(one.code, Some(0), "{}", one.stderr);
    assert!(one.stdout.starts_with(COLUMNS));
    let table = rows(&one.stdout);
    assert_eq!(table.len(), 2 * 2 * 2 * 2 * 2 * 2);
    for row in &table {
        let number = |column: usize| row[column].parse::<f64>().unwrap();
        assert!((0.0..=1.0).contains(&number(5)) && number(7) >= 0.0, "{row:?}");
        assert!((number(5) + number(7) + number(9) - 1.0).abs() < 1e-5, "{row:?}");
        assert_eq!(row[0] == "homogeneous", number(6) > 0.0, "{row:?}");
        assert!(
            ["diffuse", "45"].contains(&row[3]) && ["inf", "0.03"].contains(&row[4]),
            "{row:?}"
        );
    }
    assert_eq!(with(&["--threads", "3", "-q"]).stdout, one.stdout);
    let json = with(&["--format", "json", "-o", "albedo.json"]);
    assert_eq!((json.code, json.stdout.as_str()), (Some(0), ""), "{}", json.stderr);
    let values: Vec<serde_json::Value> =
        serde_json::from_slice(&place.bytes("albedo.json")).unwrap();
    assert_eq!(values.len(), table.len());
    assert_eq!(values[0]["method"], "homogeneous");
    assert!(values[0]["R"].is_number() && values[0]["sza_deg"] == "diffuse");
}

#[test]
fn bands_are_those_of_a_clear_or_an_overcast_day() {
    let place = Workplace::new();
    let ended = place.run(&[
        "optics",
        "albedo",
        "--radius",
        "100um,1mm",
        "--sza",
        "60",
        "--diffuse",
        "--broadband",
        "--method",
        "two-stream",
    ]);
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    let table = rows(&ended.stdout);
    let bands: Vec<&str> = table.iter().map(|row| row[1]).collect();
    assert_eq!(bands, ["solar", "visible", "near-infrared"].repeat(4));
    let reflectance = |row: usize| table[row][5].parse::<f64>().unwrap();
    for first in [0, 3, 6, 9] {
        let [solar, visible, infrared] = [0, 1, 2].map(|band| reflectance(first + band));
        assert!(visible > 0.9 && infrared < 0.8 && (infrared..visible).contains(&solar));
    }
    // Coarse snow is darker, by its infrared; clouds leave the infrared less weight only by angle.
    assert!(reflectance(0) > reflectance(6) + 0.05 && reflectance(3) > reflectance(9) + 0.05);
}

#[test]
fn layers_of_a_file_are_one_stack() {
    let place = Workplace::new();
    place.file(
        "pack.toml",
        "[[layer]]\nbottom = \"2 cm\"\nradius = \"60 um\"\ndensity = 120\n\
         [[layer]]\nbottom = \"inf\"\nssa = 12\ndensity = 320\n\
         impurities = { dust-sahara = \"20 ppm\" }\n",
    );
    let run = |file: &str| {
        place.run(&[
            "optics",
            "albedo",
            "--layers",
            file,
            "--wavelengths",
            "500",
            "--stderr",
            "0.01",
            "-q",
        ])
    };
    let ended = run("pack.toml");
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    let table = rows(&ended.stdout);
    assert_eq!((table.len(), table[0][2], table[0][4]), (1, "layers", "inf"));
    place.file("bad.toml", "[[layer]]\nbottom = 1\nradius = 1e-4\ndensity = 950\n");
    let ended = run("bad.toml");
    assert_eq!(ended.code, Some(65), "{}", ended.stderr);
    assert!(ended.stderr.contains("bad.toml") && ended.stderr.contains("layer.0.density"));
}

#[test]
fn grains_are_traced_where_a_pack_of_them_can_be_made() {
    let place = Workplace::new();
    let run = |density: &str, depth: &str| {
        place.run(&[
            "optics",
            "albedo",
            "--radius",
            "200um",
            "--density",
            density,
            "--depth",
            depth,
            "--wavelengths",
            "500,1100",
            "--method",
            "grains",
            "--stderr",
            "0.02",
            "-q",
        ])
    };
    let ended = run("250", "4mm");
    assert_eq!((ended.code, rows(&ended.stdout).len()), (Some(0), 2), "{}", ended.stderr);
    for (density, depth, told) in [
        ("400", "4mm", "at most 321"),
        ("250", "inf", "need a depth"),
        ("250", "0.2mm", "less than"),
    ] {
        let ended = run(density, depth);
        assert_eq!((ended.code, ended.stdout.as_str()), (Some(65), ""), "{}", ended.stderr);
        assert!(ended.stderr.contains(told), "{}", ended.stderr);
    }
}

#[test]
fn lattices_have_whole_layers_and_densities_within_their_reach() {
    let place = Workplace::new();
    let run = |pack: &str, density: &str, depth: &str| {
        let grains = ["optics", "albedo", "--method", "grains", "--radius", "500um", "-q"];
        let light = ["--wavelengths", "500", "--stderr", "0.05"];
        let snow = ["--pack", pack, "--density", density, "--depth", depth];
        place.run(&[&grains[..], &light, &snow].concat())
    };
    let ended = run("sc", "480", "4.4mm");
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    let table = rows(&ended.stdout);
    let depth: f64 = table[0][4].parse().unwrap();
    assert!(table[0][0] == "grains-sc" && (depth - 0.004).abs() < 1e-5, "{table:?}");
    assert_eq!(run("fcc", "300", "4mm").code, Some(0));
    for (pack, density, depth, told) in [
        ("sc", "500", "4mm", "at most 480"),
        ("fcc", "800", "4mm", "at most 679"),
        ("fcc", "300", "inf", "need a depth"),
        ("sc", "300", "0.3mm", "half a layer"),
    ] {
        let ended = run(pack, density, depth);
        assert_eq!(ended.code, Some(65), "{}", ended.stderr);
        assert!(ended.stderr.contains(told), "{}", ended.stderr);
    }
    let unknown = run("bcc", "300", "4mm");
    assert!(
        unknown.code == Some(2) && unknown.stderr.contains("random, sc, fcc"),
        "{}",
        unknown.stderr
    );
}

/// What a method cannot heed is refused, not ignored.
#[test]
fn grains_refuse_polarised_light_and_packs_beyond_the_memory() {
    let place = Workplace::new();
    let run = |more: &[&str]| {
        let grains = ["optics", "albedo", "--method", "grains", "--radius", "200um", "-q"];
        place.run(&[&grains[..], more].concat())
    };
    let tracked = run(&["--depth", "4mm", "--polarisation", "tracked"]);
    assert!(
        tracked.code == Some(2) && tracked.stderr.contains("unpolarised"),
        "{}",
        tracked.stderr
    );
    let large = run(&["--depth", "5m", "--max-memory", "100MB"]);
    assert!(large.code == Some(69) && large.stderr.contains("--max-memory"), "{}", large.stderr);
    let endless = run(&["--depth", "9000m", "--max-memory", "900TB"]);
    assert!(endless.code == Some(69), "{}", endless.stderr);
}

#[test]
fn colours_come_from_above_and_below_with_a_picture() {
    let place = Workplace::new();
    let ended = place.run(&[
        "optics",
        "colour",
        "--radius",
        "500um",
        "--depth",
        "3cm,inf",
        "--impurity",
        "dust-sahara=0ppb,100ppm",
        "--stderr",
        "0.02",
        "--swatches",
        "snow.svg",
        "-q",
    ]);
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    let table = rows(&ended.stdout);
    // Nothing is seen from below deep snow.
    assert_eq!(table.iter().filter(|row| row[0] == "R").count(), 4);
    assert_eq!(table.iter().filter(|row| row[0] == "T").count(), 2);
    let number = |row: &[&str], column: usize| row[column].parse::<f64>().unwrap();
    for row in &table {
        assert!((0.2..0.5).contains(&number(row, 6)) && number(row, 4) <= 1.0, "{row:?}");
    }
    // Dust is red.
    assert!(number(&table[2], 6) > number(&table[0], 6) + 0.005, "{table:?}");
    let picture = String::from_utf8(place.bytes("snow.svg")).unwrap();
    assert!(picture.starts_with("<svg") && picture.matches("<rect").count() == 9);
    let ended = place.run(&["optics", "colour", "--radius", "1mm", "--swatches", "snow.png"]);
    assert!(ended.code == Some(2) && ended.stderr.contains(".svg"), "{}", ended.stderr);
}

#[test]
fn what_snow_cannot_be_is_refused() {
    let place = Workplace::new();
    for (option, value, told) in [
        ("--radius", "1um", "out of range"),
        ("--ssa", "0", "m^2/kg"),
        ("--density", "918", "solid ice"),
        ("--depth", "0", "above 0"),
        ("--wavelengths", "299", "300 to 2500"),
        ("--sza", "90", "vertical"),
        ("--impurity", "black-carbon=-1ppb", "negative"),
        ("--impurity", "coal=1ppb", "no impurity is called 'coal'"),
        ("--method", "guess", "homogeneous"),
        ("--ice-k", "mine", "picard-2016"),
        ("--density", "300:200:50", "FROM:TO:STEP"),
        ("--ground", "0:2:0.5", "0 to 1"),
    ] {
        let grains: &[&str] =
            if ["--radius", "--ssa"].contains(&option) { &[] } else { &["--radius", "1mm"] };
        let ended = place.run(&[&["optics", "albedo", option, value], grains].concat());
        assert_eq!(ended.code, Some(2), "{option} {value}");
        assert!(ended.stderr.contains(told), "{option} {value}: {}", ended.stderr);
    }
}

#[test]
fn a_phase_function_has_the_mean_1_and_the_asymmetry_that_is_told() {
    let place = Workplace::new();
    let ended = place.run(&["optics", "phase", "--ior", "1.31", "--bins", "720"]);
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    assert!(ended.stdout.contains("# g 0.78165") && ended.stdout.contains("# B 1.25352"));
    let (remarks, table): (Vec<&str>, Vec<&str>) =
        ended.stdout.lines().partition(|line| line.starts_with('#'));
    assert_eq!((remarks.len(), table.len()), (9, 721));
    let energies = table[1..].iter().map(|line| line.split(',').nth(2).unwrap());
    let sum: f64 = energies.map(|energy| energy.parse::<f64>().unwrap()).sum();
    assert!((sum - 1.0).abs() < 1e-4, "{sum}");
    let ended = place.run(&["optics", "phase", "--wavelength", "100"]);
    assert!(ended.code == Some(2) && ended.stderr.contains("300 to 2500"), "{}", ended.stderr);
}

#[test]
fn shapes_of_grains_are_named_and_what_does_not_know_them_says_so() {
    let place = Workplace::new();
    let albedo = |more: &[&str]| {
        let common =
            ["optics", "albedo", "--radius", "200um", "--wavelengths", "1300", "--stderr", "0.02"];
        place.run(&[&common[..], more].concat())
    };
    place.file("round.toml", "[[shapes]]\nshape = \"spheroid\"\naspect = 1.2\n");
    let found = albedo(&["--shapes", "spheres,round.toml", "--method", "homogeneous,two-stream"]);
    assert_eq!(found.code, Some(0), "{}", found.stderr);
    let table = rows(&found.stdout);
    let shapes: Vec<&str> = table.iter().map(|row| row[13]).collect();
    assert_eq!(shapes, ["spheres", "spheres", "round.toml", "round.toml"]);
    for (arguments, told) in [
        (vec!["--shapes", "slush"], "depth-hoar"),
        (vec!["--shapes", "none.toml"], "none.toml"),
        (vec!["--shapes", "round.toml", "--polarisation", "tracked"], "--polarisation"),
        (
            vec!["--shapes", "round.toml", "--method", "grains", "--depth", "1cm"],
            "--method homogeneous",
        ),
        (vec!["--shapes", "round.toml", "--method", "bohren-barkstrom"], "of spheres"),
    ] {
        let refused = albedo(&arguments);
        assert_ne!(refused.code, Some(0), "{arguments:?}");
        assert!(refused.stderr.contains(told), "{arguments:?}: {}", refused.stderr);
    }
    let spread =
        ["optics", "spread", "--radius", "200um", "--depth", "1cm", "--shapes", "round.toml"];
    let refused = place.run(&spread);
    assert!(refused.code != Some(0) && refused.stderr.contains("--shapes"), "{}", refused.stderr);
    let mix = ["optics", "phase", "--shapes", "round.toml", "--paths", "5000", "--bins", "2"];
    let found = place.run(&mix);
    assert_eq!(found.code, Some(0), "{}", found.stderr);
    assert!(found.stdout.contains("# B_standard_error"), "{}", found.stdout);
}
