//! Where light goes in snow, on the command line of the laboratory, and its plots.

use crate::Workplace;
use crate::laboratory::rows;

#[test]
fn reflectance_factors_come_for_every_direction_and_are_the_same_on_any_machine() {
    let place = Workplace::new();
    let brdf = ["optics", "brdf", "--ssa", "2:3:1", "--sza", "50", "--wavelengths", "900,1300"];
    let views = ["--vza", "0:60:30", "--azimuth", "0,90", "--stderr", "0.1"];
    let run = |more: &[&str]| place.run(&[&brdf[..], &views, more].concat());
    let one =
        run(&["--method", "homogeneous,kokhanovsky-breon", "--threads", "1", "--simd", "sse2"]);
    assert_eq!(one.code, Some(0), "{}", one.stderr);
    let names = "method,wavelength_nm,radius_um,sza_deg,depth_m,vza_deg,azimuth_deg,BRF,BRF_stderr";
    assert!(one.stdout.starts_with(names), "{}", one.stdout);
    let table = rows(&one.stdout);
    assert_eq!(table.len(), 2 * 2 * 2 * 3 * 2);
    let number = |row: usize, column: usize| table[row][column].parse::<f64>().unwrap();
    // From the vertical, azimuths do not count; against the light, snow is brighter than from the side.
    assert!((number(0, 7) - number(1, 7)).abs() < 1e-6);
    assert!(number(4, 7) > number(5, 7) + 0.1 && number(4, 8) > 0.0, "{:?}", table[4]);
    let three = run(&["--method", "homogeneous,kokhanovsky-breon", "--threads", "3"]);
    assert_eq!(three.stdout, one.stdout);
    assert!(three.stderr.contains("BRDF, 4 cases"), "{}", three.stderr);
    for (more, told) in [
        (vec!["--method", "kokhanovsky-breon", "--depth", "1cm"], "infinite depth"),
        (vec!["--vza", "95"], "--vza"),
        (vec!["--azimuth", "400"], "-360 to 360"),
        (vec!["--vza", "0:80"], "FROM:TO:STEP"),
    ] {
        let ended = place.run(&[&brdf[..], &more].concat());
        assert!(ended.code == Some(2) && ended.stderr.contains(told), "{more:?} {}", ended.stderr);
    }
    let ended = place.run(&["optics", "brdf", "--radius", "1mm"]);
    assert!(ended.code == Some(2) && ended.stderr.contains("--sza"), "{}", ended.stderr);
}

#[test]
fn light_falls_off_inside_snow() {
    let place = Workplace::new();
    let run = |more: &[&str]| {
        let grains = ["optics", "profile", "--radius", "500um", "--wavelengths", "800", "-q"];
        place.run(&[&grains[..], &["--stderr", "0.05"], more].concat())
    };
    let ended = run(&["--at", "0,1cm,4cm", "--sza", "40"]);
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    let table = rows(&ended.stdout);
    let number = |row: usize, column: usize| table[row][column].parse::<f64>().unwrap();
    assert_eq!((table.len(), number(0, 4), table[2][8]), (3, 1.0, ""));
    assert!(number(0, 6) > 0.6 && number(1, 4) > number(2, 4) && number(2, 4) > number(2, 6));
    assert!((0.02..0.2).contains(&number(1, 8)), "{table:?}");
    for (more, told) in [
        (vec!["--at", "2cm,1cm"], "from the top down"),
        (vec!["--at", "2cm", "--depth", "1cm"], "below the snow"),
        (vec!["--at", "1cm", "--ground", "0.5"], "black ground"),
    ] {
        let ended = run(&more);
        assert!(ended.code == Some(2) && ended.stderr.contains(told), "{more:?} {}", ended.stderr);
    }
}

#[test]
fn light_that_enters_at_a_point_spreads() {
    let place = Workplace::new();
    let run = |more: &[&str]| {
        let spread = ["optics", "spread", "--radius", "500um", "--wavelengths", "700"];
        place.run(&[&spread[..], &["--stderr", "0.02"], more].concat())
    };
    let both = ["--density", "250", "--depth", "1cm", "--method", "homogeneous,grains"];
    let one = run(&[&both[..], &["--threads", "1", "--simd", "sse2"]].concat());
    assert_eq!(one.code, Some(0), "{}", one.stderr);
    let names =
        "method,wavelength_nm,radius_um,sza_deg,depth_m,quantity,from,to,value,value_stderr";
    assert!(one.stdout.starts_with(names), "{}", one.stdout);
    assert_eq!(run(&[&both[..], &["--threads", "3", "-q"]].concat()).stdout, one.stdout);
    let table = rows(&one.stdout);
    for method in ["homogeneous", "grains"] {
        let value = |quantity: &str| -> Vec<f64> {
            let of = table.iter().filter(|row| row[0] == method && row[5] == quantity);
            of.map(|row| row[8].parse().unwrap()).collect()
        };
        let one = |quantity: &str| value(quantity)[0];
        assert!((one("R") + one("T") - 1.0).abs() < 0.05 && one("R") > 0.2);
        for quantity in ["R_per_area", "R_within", "T_per_width", "T_per_path", "T_per_time"] {
            assert!(value(quantity).len() > 15, "{method} {quantity}");
        }
        assert!((value("R_within").last().unwrap() - one("R")).abs() < 1e-5);
        assert!(one("R_median_radius_m") < one("R_radius_90_m"));
        // Light takes 3.3 ps for a millimetre, and 13 mm are the least way through ice and air.
        assert!((one("T_mean_time_ps") / one("T_mean_path_m") / 3335.64 - 1.0).abs() < 1e-3);
        assert!(one("T_mean_path_m") > 0.011, "{}", one("T_mean_path_m"));
    }
    let deep = run(&["--diffuse", "--sza", "30", "-q"]);
    assert!(deep.code == Some(0) && !deep.stdout.contains(",T,"), "{}", deep.stderr);
    for (more, code, told) in [
        (vec!["--ground", "0.5"], 2, "--ground"),
        (vec!["--method", "grains"], 65, "need a depth"),
        (
            vec!["--method", "grains", "--depth", "1cm", "--polarisation", "tracked"],
            2,
            "--polarisation",
        ),
    ] {
        let ended = run(&more);
        assert_eq!(ended.code, Some(code), "{more:?} {}", ended.stderr);
        assert!(ended.stderr.contains(told), "{more:?} {}", ended.stderr);
    }
}

#[test]
fn plots_are_drawn_as_svg_and_png() {
    let place = Workplace::new();
    let snow = ["--radius", "500um,1mm", "--stderr", "0.1", "-q", "-o", "table.csv"];
    let run = |kind: &str, more: &[&str]| {
        let snow = if kind == "phase" { &snow[5..] } else { &snow[..] };
        place.run(&[&["optics", kind], snow, more].concat())
    };
    let commands: [(&str, &[&str]); 6] = [
        ("albedo", &["--wavelengths", "800:1200:100", "--depth", "1cm"]),
        ("phase", &[]),
        ("profile", &["--wavelengths", "900", "--at", "0:2cm:1cm"]),
        ("brdf", &["--wavelengths", "1300", "--sza", "40", "--azimuth", "0:180:60"]),
        ("brdf", &["--wavelengths", "1300", "--sza", "40", "--azimuth", "0,180"]),
        ("spread", &["--wavelengths", "1000", "--depth", "1cm"]),
    ];
    for (kind, more) in commands {
        for file in ["plot.svg", "plot.png"] {
            let ended = run(kind, &[more, &["--plot", file]].concat());
            assert_eq!(ended.code, Some(0), "{kind} {file}: {}", ended.stderr);
        }
        let svg = String::from_utf8(place.bytes("plot.svg")).unwrap();
        assert!(svg.starts_with("<svg width=\"") && svg.trim_end().ends_with("</svg>"), "{kind}");
        let names = ["nm", "degrees", "cm", "BRF", "mm"];
        assert!(names.iter().any(|name| svg.contains(name)), "{kind}");
        assert!(place.bytes("plot.png").starts_with(b"\x89PNG"), "{kind}");
    }
    let bad = run("albedo", &["--plot", "plot.pdf"]);
    assert!(bad.code == Some(2) && bad.stderr.contains(".svg or .png"), "{}", bad.stderr);
    let bands = run("albedo", &["--broadband", "--plot", "plot.svg"]);
    assert!(bands.code == Some(2) && bands.stderr.contains("--broadband"), "{}", bands.stderr);
}
