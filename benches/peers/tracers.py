"""Runs one tracer on one scene and returns what it measured, in the same form for all."""

import json
import os
import pathlib
import subprocess
import sys

import numpy as np
import OpenEXR

import scenes

HERE = pathlib.Path(__file__).parent


class Unavailable(Exception):
    """A tracer cannot run here; the message says why."""


def call(command, **options):
    done = subprocess.run([str(part) for part in command], capture_output=True, text=True, **options)
    if done.returncode:
        raise RuntimeError(f"{command[0]} failed ({done.returncode}): {(done.stderr or done.stdout)[-2000:]}")
    return done.stdout


class Workplace:
    """Programs, folders and threads that all runs share."""

    def __init__(self, folder, snowgrain, tracer, threads):
        self.folder, self.snowgrain, self.tracer, self.threads = pathlib.Path(folder), snowgrain, tracer, threads
        self.folder.mkdir(parents=True, exist_ok=True)

    def scene_text(self, scene):
        path = HERE / "scenes" / scene.source
        return path.read_text() if path.exists() else call([self.snowgrain, "scenes", scene.source, "--print"])

    def source(self, scene):
        path = HERE / "scenes" / scene.source
        return path if path.exists() else scene.source

    def grains(self, scene):
        """The scene's grains as a PLY, made once a run, and the figures of the snowfall."""
        path, stats = self.folder / scene.grains_path, self.folder / f"{scene.name}-deposit.json"
        call([self.snowgrain, "deposit", self.source(scene), "-q", "-o", path, "--json-stats", stats])
        return path, json.loads(stats.read_text())


def means(values, variance, seen):
    interior, hull = seen
    mean, error = scenes.mean_of(values, variance, interior)
    hull_mean, hull_error = scenes.mean_of(values, variance, hull)
    return {"interior": [mean, error], "hull": [hull_mean, hull_error], "highest_pixel": float(values.max())}


def snowgrain(place, scene, camera, seen, samples):
    def render(spp, *changes):
        picture, stats = place.folder / "snowgrain.exr", place.folder / "snowgrain.json"
        call([place.snowgrain, "render", place.source(scene), "-q", "--size", f"{scenes.SIZE}x{scenes.SIZE}", "--spp", spp,
              "--threads", place.threads, "-o", picture, "--json-stats", stats, *changes])
        return picture, json.loads(stats.read_text())

    few = "snow.grains=1" if scene.side is None else "snow.counts=[1,1,1]"
    _, empty = render(2, "--set", few)
    picture, stats = render(samples)
    with OpenEXR.File(str(picture), separate_channels=True) as file:
        values, variance = (file.channels()[name].pixels.astype(float) for name in ("R", "Variance.R"))
    return {
        "version": stats["version"],
        "variant": stats["simd"],
        "grains": stats["grains"],
        "load_cpu_seconds": stats["build_cpu_seconds"],
        "bytes": stats["peak_rss_bytes"] - empty["peak_rss_bytes"],
        "render_cpu_seconds": stats["render_cpu_seconds"],
        "render_seconds": stats["render_seconds"],
        "samples": stats["samples"],
        "events": stats["interface_events"],
        "visits": stats["grain_visits"],
        "trapped": stats["trapped_paths"],
        "path_cap": None,
        **means(values, variance, seen),
    }


def embree(place, scene, camera, seen, samples, overlap=None, **options):
    """`overlap` and `options` are those of the tracer; see embree/tracer.cpp."""
    sums, marks = place.folder / "embree.bin", place.folder / "embree.marks"
    seen[0].astype(np.uint8).tofile(marks)
    overlap = overlap or ("neighbours" if scene.overlaps else "none")
    command = [place.tracer, place.folder / scene.grains_path, sums, "--overlap", overlap, "--marks", marks,
               "--from", ",".join(map(repr, camera.origin.tolist())), "--at", ",".join(map(repr, camera.target.tolist())),
               "--fov", camera.fov, "--ior", camera.ior, "--ground", "yes" if camera.ground else "no",
               "--size", scenes.SIZE, "--spp", samples, "--threads", place.threads]
    for key, value in options.items():
        command += [f"--{key}", value]
    stats = json.loads(call(command))
    values = np.fromfile(sums, dtype=np.uint32).reshape(scenes.SIZE, scenes.SIZE) / samples
    # A sample is worth 0 or 1, so the mean gives the variance.
    variance = values * (1.0 - values) / max(samples - 1, 1)
    settings = [overlap] if scene.overlaps else []
    settings += [f"{key} {value}" for key, value in options.items()]
    return {
        "version": stats["version"],
        "variant": ", ".join(settings) or "one ray at a time",
        "grains": stats["grains"],
        "load_cpu_seconds": stats["load_cpu_seconds"] + stats["build_cpu_seconds"],
        "bytes": stats["peak_bytes"] - stats["empty_bytes"],
        "render_cpu_seconds": stats["render_cpu_seconds"],
        "render_seconds": stats["render_seconds"],
        "samples": stats["samples"],
        "events": stats["events"],
        "visits": stats["visits"] if overlap != "surfaces" else None,
        "trapped": stats["trapped"],
        "path_cap": None,
        "longest_path": stats["longest_path"],
        "light_within_cap": stats["light_within_cap"],
        "clock_ghz": [stats["clock_ghz"], stats["clock_ghz_after"]],
        **means(values, variance, seen),
    }


BYTES_A_GRAIN = {"mitsuba": 7500, "cycles": 3000}  # rough, to refuse what would not fit
# Independent pictures, whose scatter is the standard error. Cycles prepares each anew, so it gets fewer, and
# more than one sample in each, or preparing could not be told from sampling.
BATCHES = {"mitsuba": 4, "cycles": 2}
LEAST_SAMPLES = {"mitsuba": 1, "cycles": 2}
MODULE = {"mitsuba": "mitsuba", "cycles": "bpy"}


def available_bytes():
    with open("/proc/meminfo") as file:
        return next(int(line.split()[1]) * 1024 for line in file if line.startswith("MemAvailable:"))


def in_python(peer):
    """A tracer that is a Python module: a process of its own renders the job."""

    def run(place, scene, camera, seen, samples):
        if subprocess.run([sys.executable, "-c", f"import {MODULE[peer]}"], capture_output=True).returncode:
            raise Unavailable(f"`pip install {MODULE[peer]}` has not worked on this Python ({sys.version.split()[0]})")
        path = place.folder / scene.grains_path
        count = path.stat().st_size // 28
        if count * BYTES_A_GRAIN[peer] > available_bytes():
            raise Unavailable(f"{count} grains need about {count * BYTES_A_GRAIN[peer] / 1e9:.0f} GB, which is not free")
        batches = BATCHES[peer]
        job = {
            "grains": str(path), "from": camera.origin.tolist(), "at": camera.target.tolist(), "fov": camera.fov,
            "ior": camera.ior, "ground": camera.ground, "size": scenes.SIZE, "threads": place.threads,
            "batches": batches, "samples_per_batch": max(samples // batches, LEAST_SAMPLES[peer]), "subdivisions": 6,
            "pictures": str(place.folder / f"{peer}.npy"), "answer": str(place.folder / f"{peer}.json"),
        }
        described = place.folder / f"{peer}-job.json"
        described.write_text(json.dumps(job))
        call([sys.executable, HERE / f"{peer}_peer.py", described], env={**os.environ, "PYTHONWARNINGS": "ignore"})
        stats = json.loads(pathlib.Path(job["answer"]).read_text())
        pictures = np.load(job["pictures"]).astype(float)
        stats["bytes"] = stats.pop("peak_bytes") - stats.pop("empty_bytes")
        stats["samples"] = batches * job["samples_per_batch"] * scenes.SIZE**2
        return {"grains": count, "events": None, "visits": None, **stats, **means(*scenes.batch_variance(pictures), seen)}

    return run


TRACERS = {"snowgrain": snowgrain, "embree": embree, "mitsuba": in_python("mitsuba"), "cycles": in_python("cycles")}
