//! Films to pictures on the command line: groups of lights and the display.

use crate::Workplace;
use snowgrain_formats::image::read_picture;

const RENDER: [&str; 9] = [
    "render",
    "snowy-sphere-thin",
    "--size",
    "40x30",
    "--spp",
    "4",
    "--set",
    "snow.grains=30000",
    "-q",
];

/// A place with a film that keeps its groups of lights apart: sky and backdrop.
fn with_film() -> Workplace {
    let place = Workplace::new();
    let film = ["--keep", "light-groups", "--keep", "ice-paths", "-o", "a.film", "-o", "a.exr"];
    place.succeed(&[&RENDER[..], &film].concat());
    place
}

#[test]
fn groups_are_mixed_without_tracing() {
    let place = with_film();
    let mean = |name: &str| read_picture(&place.path(name)).unwrap().mean_radiance().unwrap();
    place.succeed(&["develop", "a.film", "--group", "sky=1", "-o", "same.exr"]);
    assert_eq!(place.bytes("same.exr"), place.bytes("a.exr"));
    let half = ["develop", "a.film", "--group", "sky=0.5", "--group", "backdrop=0.5"];
    place.succeed(&[&half[..], &["-o", "half.exr", "-o", "half.png"]].concat());
    let (whole, half) = (mean("a.exr"), mean("half.exr"));
    assert!((0..3).all(|c| (half[c] - 0.5 * whole[c]).abs() < 1e-6), "{whole:?} {half:?}");
    let soot = ["--impurity", "soot=2ppm"];
    let develop = |more: &[&str]| place.succeed(&[&["develop", "a.film"], more].concat());
    let warm = ["--group", "sky=2,#ff8040", "--group", "backdrop=2,#ff8040", "-o", "warm.exr"];
    develop(&[&soot[..], &warm].concat());
    develop(&[&soot[..], &["-o", "sooty.exr"]].concat());
    let (warm, sooty) = (mean("warm.exr"), mean("sooty.exr"));
    assert!((warm[0] / sooty[0] - 2.0).abs() < 0.02, "{warm:?} {sooty:?}");
    assert!(warm[2] / sooty[2] < 0.2, "{warm:?} {sooty:?}");
}

#[test]
fn a_picture_is_shown_as_asked_and_the_same_way_by_both_commands() {
    let place = with_film();
    let display = [
        "--exposure",
        "auto",
        "--curve",
        "agx",
        "--glare",
        "eye,2",
        "--white-balance",
        "sunlit",
        "--gamut",
        "compress",
        "--bits",
        "16",
    ];
    let develop = [&["develop", "a.film", "-o", "a.png", "-o", "b.exr"], &display[..]].concat();
    let run = place.succeed(&develop);
    assert!(run.stderr.starts_with("exposure ") && run.stderr.contains("stops"), "{}", run.stderr);
    place.succeed(&[&RENDER[..], &["-o", "b.png"], &display].concat());
    assert_eq!(place.bytes("a.png"), place.bytes("b.png"));
    assert_eq!(place.bytes("a.png")[24], 16, "bits of a channel in the header of a PNG file");
    assert_eq!(place.bytes("b.exr"), place.bytes("a.exr"), "the display is not for EXR files");
    for other in [["--curve", "filmic"], ["--roll-off", "0.7"], ["--glare", "lens"]] {
        place.succeed(&[&["develop", "a.film", "-o", "c.png"], &other[..]].concat());
        assert_ne!(place.bytes("c.png"), place.bytes("a.png"));
    }
}

#[test]
fn what_cannot_be_mixed_or_shown_is_said() {
    let place = with_film();
    place.succeed(&[&RENDER[..], &["-o", "plain.film"]].concat());
    let refused = |film: &str, arguments: &[&str], code: i32, said: &str| {
        let run = place.run(&[&["develop", film, "-o", "x.png"], arguments].concat());
        assert_eq!(run.code, Some(code), "{}", run.stderr);
        assert!(run.stderr.contains(said), "{}", run.stderr);
    };
    refused(
        "a.film",
        &["--group", "moon=1"],
        65,
        "a.film: the film has no group of lights moon; it has sky, backdrop",
    );
    refused("plain.film", &["--group", "sky=1"], 65, "--keep light-groups");
    refused("a.film", &["--group", "sky"], 2, "sky=2,#ffd0a0");
    refused("a.film", &["--group", "sky=1,pink"], 2, "3200K");
    refused("a.film", &["--white-balance", "3200"], 2, "3200K");
    refused("a.film", &["--glare", "star"], 2, "eye,0.5");
    refused("a.film", &["--curve", "agx", "--roll-off", "0.5"], 2, "--curve plain");
    refused("a.film", &["--bits", "12"], 2, "possible values: 8, 16");
    refused("a.film", &["--exposure", "bright"], 2, "auto");
    assert!(!place.path("x.png").exists());
}
