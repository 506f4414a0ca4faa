//! Renders that last: parts and merging, stops and resuming.

use crate::{TINY, Workplace};
use std::process::{Command, Stdio};
use std::time::Duration;

/// Renders the tiny scene with other samples than its own; gives exit code and words.
fn run(place: &Workplace, arguments: &[&str]) -> (i32, String) {
    let few = [&TINY[..2], &TINY[4..]].concat();
    let ended = place.run(&[&["render", "snowy-teapot"], &few[..], arguments].concat());
    (ended.code.unwrap_or(-1), ended.stderr)
}

fn render(place: &Workplace, arguments: &[&str]) -> String {
    let (code, said) = run(place, arguments);
    assert_eq!(code, 0, "{arguments:?}: {said}");
    said
}

#[test]
fn parts_of_samples_and_of_crops_merge_to_the_bytes_of_one_render() {
    let place = Workplace::new();
    render(&place, &["--spp", "6", "-o", "whole.film", "-o", "whole.exr"]);
    for (samples, name) in [("0..1", "a.film"), ("1-3", "b.film"), ("4..6", "c.film")] {
        render(&place, &["--samples", samples, "-o", name, "--threads", "1"]);
    }
    let merge = |arguments: &[&str]| place.run(&[&["merge"], arguments].concat());
    place.succeed(&["merge", "c.film", "a.film", "b.film", "-o", "m.film", "-o", "m.exr"]);
    assert_eq!(place.bytes("m.film"), place.bytes("whole.film"));
    assert_eq!(place.bytes("m.exr"), place.bytes("whole.exr"));
    for (crop, name) in
        [("0,0,48,17", "x.film"), ("0,17,20,48", "y.film"), ("20,17,48,48", "z.film")]
    {
        render(&place, &["--spp", "6", "--crop", crop, "-o", name]);
    }
    place.succeed(&["merge", "z.film", "x.film", "y.film", "-o", "m.film"]);
    assert_eq!(place.bytes("m.film"), place.bytes("whole.film"));
    for (films, code, said) in [
        (&["a.film", "c.film"][..], 75, "samples 1..4 are missing"),
        (&["a.film", "b.film", "--require", "0..8"], 75, "samples 4..8 are missing"),
        (&["a.film", "a.film"], 65, "a.film: samples 0..1 are in the film already"),
        (&["x.film", "z.film"], 65, "open; render those, too"),
        (&["x.film", "whole.film"], 65, "overlap"),
        (&["a.film", "y.film"], 65, "samples"),
    ] {
        let ended = merge(&[films, &["-o", "n.film"]].concat());
        assert_eq!(ended.code, Some(code), "{films:?}: {}", ended.stderr);
        assert!(ended.stderr.contains(said), "{films:?}: {}", ended.stderr);
        assert!(!place.path("n.film").exists());
    }
    let ended = merge(&["a.film", "c.film", "--allow-missing", "-o", "n.film"]);
    assert!(ended.code == Some(0) && ended.stderr.contains("1..4"), "{}", ended.stderr);
    render(&place, &["--spp", "6", "--seed", "4", "-o", "other.film"]);
    let ended = merge(&["a.film", "other.film", "-o", "n.film"]);
    assert!(ended.code == Some(65) && ended.stderr.contains("differ in"), "{}", ended.stderr);
    let mut damaged = place.bytes("b.film");
    let middle = damaged.len() / 2;
    damaged[middle] ^= 1;
    place.file("b.film", damaged);
    let ended = merge(&["a.film", "b.film", "-o", "n.film"]);
    assert!(ended.code == Some(65) && ended.stderr.contains("checksum"), "{}", ended.stderr);
    let before = place.bytes("whole.film");
    let ended = merge(&["a.film", "-o", "whole.film"]);
    assert!(ended.code == Some(2) && ended.stderr.contains("samples 0..6"), "{}", ended.stderr);
    assert_eq!(place.bytes("whole.film"), before);
    place.succeed(&["merge", "whole.film", "-o", "a.film"]);
    let said = place.succeed(&["merge", "whole.film", "-o", "other.film"]).stderr;
    assert!(said.contains("other.film: the film of another render that is there"), "{said}");
}

#[test]
fn a_finished_part_is_not_rendered_again_and_a_film_of_another_render_is_not_resumed() {
    let place = Workplace::new();
    render(&place, &["--samples", "2..4", "-o", "a.film"]);
    let before = place.bytes("a.film");
    let said = render(&place, &["--samples", "2..4", "-o", "a.film", "-o", "a.exr"]);
    assert!(said.contains("nothing is traced"), "{said}");
    assert_eq!(place.bytes("a.film"), before);
    assert!(place.path("a.exr").exists());
    for (arguments, code, reason) in [
        (&["--samples", "0..6"][..], 2, "unfinished film of this render (samples 2..4 of 0..6)"),
        (&["--samples", "0..3", "--resume"], 65, "it holds samples 2..4, outside 0..3"),
        (&["--spp", "9", "--resume", "--seed", "3"], 65, "another scene or seed"),
        (&["--spp", "9", "--resume", "--crop", "0,0,9,9"], 65, "its crop is"),
        (&["--spp", "9", "--resume", "--noise-target", "0.1"], 65, "noise target"),
        (&["--spp", "9", "--resume", "--set", "camera.vertical_fov=20"], 65, "another scene"),
    ] {
        let (ended, said) = run(&place, &[arguments, &["-o", "a.film"]].concat());
        assert_eq!(ended, code, "{arguments:?}: {said}");
        assert!(said.contains(reason), "{arguments:?}: {said}");
        assert_eq!(place.bytes("a.film"), before);
    }
    render(&place, &["--spp", "7", "--resume", "-o", "a.film"]);
    render(&place, &["--spp", "7", "-o", "whole.film"]);
    assert_eq!(place.bytes("a.film"), place.bytes("whole.film"));
    let (code, said) = run(&place, &["--spp", "2", "--resume", "-o", "a.png"]);
    assert!(code == 2 && said.contains("-o FILE.film"), "{said}");
    place.file("a.film", "SNOWFILM");
    assert_eq!(run(&place, &["--spp", "2", "--resume", "-o", "a.film"]).0, 65);
}

/// A render with a checkpoint every moment is killed, stopped and killed again until it is done.
#[test]
fn a_render_that_is_killed_again_and_again_ends_with_the_bytes_of_one_that_is_not() {
    let place = Workplace::new();
    let common = [&["render", "snowy-teapot"], &TINY[..2], &TINY[4..], &["--spp", "300"]].concat();
    let quiet = ["--quiet", "--threads", "1"];
    let whole = [&common[..], &quiet, &["-o", "whole.film"]].concat();
    place.succeed(&whole);
    let resumed = [&common[..], &quiet, &["--resume", "--checkpoint-every", "1ms", "-o", "a.film"]];
    let resumed = resumed.concat();
    let (mut kills, mut left_behind) = (0, 0);
    for round in 0..12 {
        let mut child = Command::new(crate::program())
            .current_dir(place.path("."))
            .args(&resumed)
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        std::thread::sleep(Duration::from_millis(60 + 40 * (round % 5)));
        if let Some(status) = child.try_wait().unwrap() {
            assert!(status.success(), "{status}");
            break;
        }
        child.kill().unwrap();
        child.wait().unwrap();
        kills += 1;
        let stale = place.names().iter().filter(|name| name.ends_with(".partial")).count();
        assert!(stale <= 1, "what was left before is swept");
        left_behind += stale;
    }
    place.succeed(&resumed);
    println!("{kills} kills, {left_behind} of them while a film was written");
    assert_eq!(place.bytes("a.film"), place.bytes("whole.film"));
    assert_eq!(place.names(), ["a.film", "whole.film"]);
}

#[test]
fn a_job_of_scenes_that_cannot_be_loaded_is_refused() {
    let place = Workplace::new();
    place.file("sweep.toml", "snow.radius = [\"1 mm\", \"-1 mm\"]\n");
    let plan = ["job", "plan", "--samples", "5", "--per-task", "3", "-o", "job.json"];
    for (arguments, code, said) in [
        (&["missing.toml"][..], 66, "missing.toml"),
        (&["snowy-teapot", "--set", "snow.radus=3"], 65, "snow.radus"),
        (&["snowy-teapot", "--sweep", "sweep.toml"], 65, "must be a finite length above 0"),
        (&["snowy-teapot", "--frames", "3-1"], 2, "--frames"),
    ] {
        let ended = place.run(&[&plan[..], arguments].concat());
        assert_eq!(ended.code, Some(code), "{arguments:?}: {}", ended.stderr);
        assert!(ended.stderr.contains(said), "{arguments:?}: {}", ended.stderr);
        assert!(!place.path("job.json").exists());
    }
}

#[test]
fn a_job_is_done_task_by_task_and_tells_what_is_missing() {
    let place = Workplace::new();
    let scene = place.succeed(&["scenes", "snowy-teapot", "--print"]).stdout;
    let animate =
        "[[animate]]\nkey = \"camera.vertical_fov\"\nframes = [1, 2]\nvalues = [20, 30]\n";
    place.file("scene.toml", format!("{scene}\n{animate}"));
    place.file("sweep.toml", "snow.seed = [1, 2]\n");
    let small = ["--size", "16x16", "--set", "snow.grains=500", "--set", "snow.radius=4mm"];
    let plan = ["job", "plan", "scene.toml", "--samples", "5", "--per-task", "3", "-o", "job.json"];
    let more = ["--sweep", "sweep.toml", "--frames", "1-2"];
    let said = place.succeed(&[&plan[..], &small, &more].concat()).stderr;
    assert!(said.contains("tasks 0 to 7"), "{said}");
    let status = || place.run(&["job", "status", "job.json"]);
    assert_eq!((status().code, status().stdout.lines().count()), (Some(75), 8));
    for task in (0..8).rev() {
        place.succeed(&["job", "run", "job.json", "--task", &task.to_string(), "--quiet"]);
    }
    let said = place.succeed(&["job", "run", "job.json", "--task", "3"]).stderr;
    assert!(said.contains("nothing is traced"), "{said}");
    let (ended, parts) = (status(), place.path("job-parts"));
    assert_eq!((ended.code, ended.stdout.as_str()), (Some(0), ""));
    // The second point at frame 2.
    let part = |first: u64| format!("job-parts/p00001-f00002-s{first:010}.film");
    place.succeed(&["merge", &part(0), &part(3), "--require", "0..5", "-o", "m.film"]);
    let whole = ["render", "scene.toml", "--set", "snow.seed=2", "--spp", "5", "--frame", "2"];
    let quiet = ["--quiet", "-o", "w.##.film"];
    place.succeed(&[&whole[..], &small, &quiet].concat());
    assert_eq!(place.bytes("w.02.film"), place.bytes("m.film"));
    std::fs::remove_file(parts.join("p00000-f00001-s0000000003.film")).unwrap();
    std::fs::write(parts.join("p00000-f00002-s0000000000.film"), "damaged").unwrap();
    let ended = status();
    assert_eq!(ended.code, Some(75));
    for said in ["task 1: point 0 frame 1 samples 3..5 missing", "task 2: point 0 frame 2"] {
        assert!(ended.stdout.contains(said), "{}", ended.stdout);
    }
    assert_eq!(place.run(&["job", "run", "job.json", "--task", "8"]).code, Some(2));
    // Another job by this name would take the films of this one for its own, and so would another scene.
    let ended = place.run(&[&plan[..], &["--size", "20x20"]].concat());
    assert!(ended.code == Some(2) && ended.stderr.contains("another job"), "{}", ended.stderr);
    place.succeed(&[&plan[..], &small, &more].concat());
    place.file("scene.toml", format!("{scene}\n{animate}").replace("[20, 30]", "[20, 31]"));
    let said = status().stdout;
    assert!(said.contains("task 6: point 1 frame 2 samples 0..3 of another scene"), "{said}");
    assert!(!said.contains("task 4: "), "frame 1 is as it was: {said}");
    assert_eq!(place.run(&[&whole[..5], &["-o", "x.####.png"]].concat()).code, Some(2));
}

/// Names of the temporary files that are there.
fn partial(place: &Workplace) -> Vec<String> {
    place.names().into_iter().filter(|name| name.ends_with(".partial")).collect()
}

/// Runs the program with a fault at a step of the writing of a film.
fn with_fault(place: &Workplace, arguments: &[&str], fault: &str) -> std::process::Output {
    let few = [&TINY[..2], &TINY[4..]].concat();
    let mut command = Command::new(crate::program());
    command.current_dir(place.path(".")).args(["render", "snowy-teapot"]).args(few);
    command.args(arguments).env("SNOWGRAIN_FAULT", fault).output().unwrap()
}

#[cfg(unix)]
#[test]
fn a_kill_at_any_step_of_the_writing_of_a_film_leaves_the_old_or_the_new_one() {
    use std::os::unix::process::ExitStatusExt as _;
    let place = Workplace::new();
    render(&place, &["--spp", "2", "-o", "whole.film"]);
    let whole = place.bytes("whole.film");
    render(&place, &["--samples", "0..1", "-o", "first.film"]);
    let first = place.bytes("first.film");
    for (step, is_named) in [
        ("create", false),
        ("write:0", false),
        ("write:1", false),
        ("write:300000", false),
        ("sync", false),
        ("rename", false),
        ("sync-folder", true),
        ("end", true),
    ] {
        place.file("a.film", &first);
        let resume = ["--spp", "2", "--resume", "-o", "a.film"];
        let ended = with_fault(&place, &resume, &format!("film-{step}=kill")).status;
        assert_eq!(ended.signal(), Some(9), "{step}: {ended}");
        let there = place.bytes("a.film");
        assert!(there == if is_named { &whole[..] } else { &first }, "{step}");
        assert_eq!(partial(&place).len(), usize::from(!is_named), "{step}");
        render(&place, &resume);
        assert!(place.bytes("a.film") == whole, "{step}: the resumed film differs");
        assert_eq!(place.names(), ["a.film", "first.film", "whole.film"], "{step}: swept");
    }
}

#[test]
fn a_disk_that_fails_at_any_step_is_told_and_costs_a_checkpoint_or_the_end() {
    let place = Workplace::new();
    render(&place, &["--samples", "0..1", "-o", "first.film"]);
    let first = place.bytes("first.film");
    for (fault, is_named, said) in [
        ("create=enospc", false, "no storage space"),
        ("write:200000=enospc", false, "no storage space"),
        ("sync=eio", false, "the file that was there before is untouched"),
        ("rename=eio", false, "the file that was there before is untouched"),
        ("sync-folder=eio", true, "does not confirm"),
    ] {
        place.file("a.film", &first);
        let resume = ["--spp", "2", "--resume", "-o", "a.film"];
        let ended = with_fault(&place, &resume, &format!("film-{fault}"));
        let words = String::from_utf8(ended.stderr).unwrap();
        assert_eq!(ended.status.code(), Some(74), "{fault}: {words}");
        assert!(words.contains(said), "{fault}: {words}");
        assert_eq!(place.bytes("a.film") != first, is_named, "{fault}");
        assert_eq!(place.names(), ["a.film", "first.film"], "{fault}");
    }
    place.file("a.film", &first);
    let often = ["--spp", "300", "--resume", "--checkpoint-every", "1ms", "-o", "a.film"];
    let ended = with_fault(&place, &often, "film-sync=enospc@2");
    let words = String::from_utf8(ended.stderr).unwrap();
    assert!(ended.status.success() && words.contains("no checkpoint"), "{words}");
    let ended = with_fault(&place, &often, "film-sinc=kill");
    let words = String::from_utf8(ended.stderr).unwrap();
    assert!(ended.status.code() == Some(73) && words.contains("is not a fault"), "{words}");
}

#[test]
fn samples_are_not_lost_to_a_render_of_fewer_or_others() {
    let place = Workplace::new();
    render(&place, &["--samples", "2..6", "-o", "a.film"]);
    let before = place.bytes("a.film");
    for resume in [&[][..], &["--resume"]] {
        let fewer = [&["--samples", "3..5", "-o", "a.film", "-o", "a.exr"], resume].concat();
        let said = render(&place, &fewer);
        assert!(said.contains("and more (2..6)") && said.contains("nothing is traced"), "{said}");
        std::fs::remove_file(place.path("a.exr")).unwrap();
        assert_eq!(place.bytes("a.film"), before);
    }
    let (code, said) = run(&place, &["--samples", "0..4", "-o", "a.film"]);
    assert!(code == 2 && said.contains("samples 2..6, of which 0..4 would not keep all"), "{said}");
    let (code, said) = run(&place, &["--samples", "0..4", "--resume", "-o", "a.film"]);
    assert!(code == 65 && said.contains("it holds samples 2..6, outside 0..4"), "{said}");
    assert_eq!(place.bytes("a.film"), before);
    let said = render(&place, &["--spp", "1", "--seed", "3", "-o", "a.film"]);
    assert!(
        said.contains("a.film: the film that is there (samples 2..6) will be replaced"),
        "{said}"
    );
    assert!(said.contains("another scene or seed"), "{said}");
    let (code, said) = run(&place, &["--spp", "1", "-o", "b.png", "-o", "./b.png"]);
    assert!(code == 2 && said.contains("name two"), "{said}");
}

/// A run that waits in the middle of a write keeps another from its film, until it is killed.
#[test]
fn two_runs_do_not_work_on_one_film() {
    let place = Workplace::new();
    let few = [&TINY[..2], &TINY[4..]].concat();
    let mut command = Command::new(crate::program());
    command.current_dir(place.path(".")).args(["render", "snowy-teapot"]).args(few);
    command.args(["--spp", "2", "-o", "a.film"]).env("SNOWGRAIN_FAULT", "film-write:1000=hold");
    let mut first = command.stderr(Stdio::null()).spawn().unwrap();
    let is_there = || partial(&place).iter().any(|name| place.bytes(name).len() == 1000);
    while !is_there() {
        assert!(first.try_wait().unwrap().is_none(), "it ended before it was held");
        std::thread::sleep(Duration::from_millis(5));
    }
    let second = ["--spp", "2", "--resume", "-o", "a.film"];
    let (code, said) = run(&place, &second);
    let process = format!("another run (process {})", first.id());
    assert!(code == 75 && said.contains(&process), "{said}");
    assert_eq!(partial(&place).len(), 1, "what another run writes is not swept");
    render(&place, &["--spp", "1", "-o", "b.film"]);
    assert_eq!(partial(&place).len(), 1, "what another run writes is not swept");
    first.kill().unwrap();
    first.wait().unwrap();
    render(&place, &second);
    assert_eq!(place.names(), ["a.film", "b.film"]);
}
