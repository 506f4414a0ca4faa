//! Files that were made to do harm: each is refused in one line, in little memory, and leads nowhere else.
//!
//! Names begin with what a file is given as. All are kept in `tests/data/hostile`.

use crate::Workplace;
use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant};

/// Most memory that a refusal may take, KiB (of private memory, what `ulimit -d` counts).
const MOST_KIB: u32 = 200 * 1024;

/// Far longer than a refusal takes: whoever hangs is ended here.
const HANGS: Duration = Duration::from_secs(20);

const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

const SCENE: &str = "version = 1\n[camera]\nfrom = [0, 1, 3]\nat = [0, 0, 0]\n";

/// How a file is given to the program; a scene that refers to it is written first.
fn command(place: &Workplace, name: &str) -> Vec<String> {
    let scene = |more: &str| {
        place.file("inside/refers.toml", format!("{SCENE}{more}\nfile = \"{name}\"\n"));
        "inside/refers.toml".to_owned()
    };
    let sky = "[[light]]\nkind = \"sky\"\n";
    let file = format!("inside/{name}");
    let kind = name.split('-').next().unwrap();
    let render = |scene: String| {
        ["render", &scene, "-o", "out.png", "--threads", "1"].map(str::to_owned).to_vec()
    };
    match kind {
        "scene" if name.contains("frames") => {
            [render(file), vec!["--frame".into(), "1".into()]].concat()
        }
        "scene" | "mesh" | "shot" => render(file),
        "grains" => render(scene(&format!("{sky}[[snow]]\nsource = \"file\""))),
        "map" => render(scene("[[object]]\nshape = \"box\"\n[[light]]\nkind = \"environment\"")),
        "texture" => {
            let object = format!("{sky}[[object]]\nshape = \"box\"\nalbedo_texture = \"{name}\"\n");
            place.file("inside/refers.toml", format!("{SCENE}{object}"));
            render("inside/refers.toml".into())
        }
        "picture" => vec!["compare".into(), file.clone(), file],
        "film" => ["merge", &file, "-o", "out.film"].map(str::to_owned).to_vec(),
        "job" => ["job", "run", &file, "--task", "0"].map(str::to_owned).to_vec(),
        other => panic!("{name}: nothing is known of {other}"),
    }
}

#[test]
fn every_hostile_file_is_65_in_little_memory_and_leads_nowhere() {
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/data/hostile");
    let mut names: Vec<_> = std::fs::read_dir(&data)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    assert!(names.len() >= 60, "{} files", names.len());
    let mut wrong = Vec::new();
    let mut slowest = (Duration::ZERO, "");
    for name in &names {
        let place = Workplace::new();
        std::fs::create_dir(place.path("inside")).unwrap();
        // What would be read if a name led out of the folder.
        for outside in ["secret.obj", "secret.png", "secret.hdr", "secret.ply", "secret.glb"] {
            place.file(outside, TRIANGLE);
        }
        std::fs::copy(data.join(name), place.path("inside").join(name)).unwrap();
        let began = Instant::now();
        let limited = format!("ulimit -d {MOST_KIB}; exec \"$0\" \"$@\"");
        let ended = Command::new("sh")
            .current_dir(place.path("."))
            .args(["-c", &limited])
            .arg(crate::program())
            .args(command(&place, name))
            .output()
            .unwrap();
        let took = began.elapsed();
        slowest = slowest.max((took, name));
        let said = String::from_utf8(ended.stderr).unwrap();
        let leads_out = ["-up", "-absolute", "-web", "-scheme", "-device", "-percent", "-dots"];
        let must_say = if leads_out.iter().any(|part| name.contains(part)) { "which" } else { "" };
        let is_right = ended.status.code() == Some(65)
            && said.lines().count() == 1
            && said.starts_with("snowgrain: error: ")
            && said.contains(must_say)
            && said.len() < 2000
            && took < HANGS
            && !place.path("out.png").exists()
            && !place.path("out.film").exists();
        if !is_right {
            wrong.push(format!("{name}: {:?}: {said}", ended.status.code()));
        }
    }
    println!("{} files; the slowest, {}, took {:?}", names.len(), slowest.1, slowest.0);
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Links, which a copy of the folder could not keep.
#[cfg(unix)]
#[test]
fn links_that_leave_the_folder_are_65() {
    let place = Workplace::new();
    std::fs::create_dir(place.path("inside")).unwrap();
    place.file("secret.obj", TRIANGLE);
    std::os::unix::fs::symlink(place.path("secret.obj"), place.path("inside/a.obj")).unwrap();
    let scene = format!(
        "{SCENE}[[light]]\nkind = \"sky\"\n[[object]]\nshape = \"mesh\"\nfile = \"a.obj\"\n"
    );
    place.file("inside/a.toml", scene);
    let render = ["render", "inside/a.toml", "--size", "8x8", "--spp", "1", "-o", "out.png"];
    let ended = place.run(&render);
    assert!(ended.code == Some(65) && ended.stderr.contains("by a link"), "{}", ended.stderr);
    // What the user names may lie anywhere.
    let outside = format!("object.file={}", place.path("secret.obj").display());
    place.succeed(&[&render[..], &["--set", &outside]].concat());
}
