//! Signals: the first keeps what there is.

use crate::Workplace;
use snowgrain_formats::image::read_picture;
use snowgrain_formats::read_film;
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

/// A render of far too many samples.
fn endless(place: &Workplace) -> Child {
    Command::new(crate::program())
        .current_dir(place.path("."))
        .args(["render", "snowy-teapot", "--size", "32x32", "--spp", "4000000000"])
        .args(["--set", "snow.grains=500", "-o", "a.png", "-o", "a.film"])
        .stderr(Stdio::piped())
        .spawn()
        .unwrap()
}

fn wait_for_file(place: &Workplace, name: &str) {
    let start = Instant::now();
    while !place.path(name).exists() {
        assert!(start.elapsed() < Duration::from_secs(60), "no {name}");
        std::thread::sleep(Duration::from_millis(20));
    }
}

fn send(child: &Child, signal: &str) {
    let sent = Command::new("kill").args(["-s", signal, &child.id().to_string()]).status();
    assert!(sent.unwrap().success());
}

/// Whether SIGINT was ignored when these tests were started (a script's background jobs inherit
/// that, and the program respects it).
fn interrupt_is_ignored() -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).is_some_and(|m| m & 2 != 0)
}

/// Waits for the child to end of itself, at most a minute.
fn ended(mut child: Child) -> Output {
    let start = Instant::now();
    while child.try_wait().unwrap().is_none() {
        if start.elapsed() > Duration::from_secs(60) {
            child.kill().unwrap();
            panic!("the signal did not stop the program");
        }
        std::thread::sleep(Duration::from_millis(20));
    }
    child.wait_with_output().unwrap()
}

#[test]
fn a_signal_stops_a_render_and_leaves_film_and_picture() {
    for (signal, code) in [("INT", 130), ("TERM", 143)] {
        if signal == "INT" && interrupt_is_ignored() {
            continue;
        }
        let place = Workplace::new();
        let child = endless(&place);
        wait_for_file(&place, "a.png"); // refreshed after the first pass
        assert!(!place.path("a.film").exists());
        send(&child, signal);
        let output = ended(child);
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(code), "{said}");
        assert!(said.contains("stopped by a signal after"), "{said}");
        let film = read_film(&place.path("a.film")).unwrap();
        assert!(film.samples().total() >= 1 && film.samples().total() < 4_000_000_000);
        read_picture(&place.path("a.png")).unwrap();
        assert_eq!(place.names(), ["a.film", "a.png"]);
    }
}
