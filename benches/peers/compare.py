"""Runs every tracer on every scene, one at a time, and prints and keeps a table. Start it through run.sh."""

import argparse
import datetime
import json
import math
import pathlib
import platform
import subprocess
import sys
import time

import report
import scenes
import tracers

HERE = pathlib.Path(__file__).parent

# Settings of the Embree tracer that are measured beside its main row: (scene, share of the samples, settings).
VARIANTS = [
    ("cube-32", 1.0, {"packets": 16}),
    ("cube-32", 1.0, {"robust": "yes"}),
    ("cube-32", 1.0, {"quality": "high"}),
    ("cube-120", 0.5, {"packets": 16}),
    ("deposit-1m", 0.5, {"overlap": "traced"}),
    ("deposit-1m", 0.25, {"overlap": "surfaces"}),
]


REPEATS, SHARE_OF_REPEATS = 2, 0.25
COUNTED = ("snowgrain", "embree")  # whose rates are compared with care


def arguments():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true", help="about three minutes: fewer samples, scenes and peers")
    parser.add_argument("--only", default=",".join(tracers.TRACERS), help="tracers, as embree,snowgrain")
    parser.add_argument("--scenes", default=",".join(s.name for s in scenes.SCENES), help="scenes, as cube-32,stick-1m")
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--snowgrain", required=True, help="the program (run.sh builds it)")
    parser.add_argument("--tracer", required=True, help="the Embree tracer (run.sh builds it)")
    parser.add_argument("--folder", required=True, help="where intermediate files go")
    parser.add_argument("--keep", action="store_true", help="also writes RESULTS.md and runs/DATE-MACHINE.json")
    chosen = parser.parse_args()
    for names, known in ((chosen.only, tracers.TRACERS), (chosen.scenes, [s.name for s in scenes.SCENES])):
        for name in names.split(","):
            if name not in known:
                parser.error(f"{name} is none of {', '.join(known)}")
    return chosen


def machine():
    def first(path, key):
        try:
            lines = pathlib.Path(path).read_text().splitlines()
        except OSError:
            return None
        return next((line.split(":", 1)[1].strip() for line in lines if line.startswith(key)), None)

    def output(*command):
        try:
            return subprocess.run(command, capture_output=True, text=True).stdout.strip().splitlines()[0]
        except (OSError, IndexError):
            return None

    flags = (first("/proc/cpuinfo", "flags") or "").split()
    widest = next((name for name in ("avx512f", "avx2", "sse4_2") if name in flags), platform.machine())
    return {
        "processor": first("/proc/cpuinfo", "model name") or platform.machine(),
        "family_model": [first("/proc/cpuinfo", "cpu family"), first("/proc/cpuinfo", "model\t")],
        "processors": len([l for l in pathlib.Path("/proc/cpuinfo").read_text().splitlines() if l.startswith("processor")]),
        "widest_simd": widest,
        "memory": first("/proc/meminfo", "MemTotal"),
        "system": platform.platform(),
        "compiler": output("c++", "--version"),
        "python": platform.python_version(),
        "commit": output("git", "-C", str(HERE), "rev-parse", "--short=12", "HEAD"),
    }


def say(text):
    print(text, file=sys.stderr, flush=True)


def measure(name, place, scene, camera, seen, samples, **settings):
    say(f"{scene.name}: {name} {settings or ''} {samples} samples a pixel")
    result = {"tracer": name, "scene": scene.name, "samples_per_pixel": samples}
    start = time.monotonic()
    try:
        result.update(tracers.TRACERS[name](place, scene, camera, seen, samples, **settings))
    except tracers.Unavailable as reason:
        result["unavailable"] = str(reason)
        say(f"  not run: {reason}")
    except Exception as error:  # a peer that breaks on a scene is a result, and must not lose the others
        result["failed"] = str(error)
        say(f"  failed: {error}")
    result["whole_seconds"] = time.monotonic() - start
    return result


def repeat_rates(runs, again):
    """Runs the main rows once more with fewer samples, in turn, and keeps all rates: on a shared machine the
    neighbours' use of caches and memory slows a tracer down for a while, so the best of three is compared."""
    for _ in range(REPEATS):
        for run in runs:
            if "samples" in run:
                more = again(run)
                if "samples" in more:
                    run["repeats"] = run.get("repeats", []) + [more]


def run_scene(place, scene, chosen, runs):
    wanted = [n for n in chosen.only.split(",") if n in scene.samples and (not chosen.quick or n in scene.quick)]
    if not wanted:
        return
    grains, deposit = place.grains(scene)
    camera = scenes.Camera.of_scene(place.scene_text(scene))
    seen = scenes.masks(scene, camera)
    part = 0.25 if chosen.quick else 1.0
    count = lambda name, share=1.0: max(int(scene.samples[name] * part * share), 2)
    mine = []
    for name in wanted:
        runs.append(measure(name, place, scene, camera, seen, count(name)))
        mine.append(runs[-1])
        runs[-1]["deposit"] = deposit if name == "snowgrain" and scene.side is None else None
    repeat_rates([r for r in mine if r["tracer"] in COUNTED],
                 lambda r: measure(r["tracer"], place, scene, camera, seen, count(r["tracer"], SHARE_OF_REPEATS)))
    for of_scene, share, settings in VARIANTS:
        if of_scene == scene.name and "embree" in wanted and not chosen.quick:
            runs.append(measure("embree", place, scene, camera, seen, count("embree", share), **settings))
            runs[-1]["variant_of_main"] = True
    grains.unlink()


def self_check(runs):
    """The tracers that claim to be exact must agree with the truth of the 32 cube, and with each other."""
    faults = []
    for run in runs:
        if run.get("failed") and run["tracer"] in ("snowgrain", "embree"):
            faults.append(f"{run['tracer']} failed on {run['scene']}")
        if "interior" not in run or run["tracer"] not in ("snowgrain", "embree") or "surfaces" in run["variant"]:
            continue
        mean, error = run["interior"]
        scene = next(s for s in scenes.SCENES if s.name == run["scene"])
        if scene.truth:
            away = abs(mean - scene.truth[0])
            allowed = 4.0 * error + scenes.TRUTH_TOLERANCE
            if away > allowed:
                faults.append(f"{run['tracer']} ({run['variant']}) on {scene.name}: {mean:.5f} is {away:.5f} from the truth")
        exact = report.find(runs, "snowgrain", run["scene"])
        if exact and "interior" in exact and run is not exact:
            both = math.hypot(error, exact["interior"][1])
            if abs(mean - exact["interior"][0]) > 4.5 * both:
                faults.append(f"embree ({run['variant']}) and snowgrain differ on {scene.name}: "
                              f"{mean:.5f}, {exact['interior'][0]:.5f}, sigma {both:.5f}")
    return faults


def main():
    chosen = arguments()
    place = tracers.Workplace(chosen.folder, chosen.snowgrain, chosen.tracer, chosen.threads)
    runs = []
    started = time.monotonic()
    date = datetime.date.today().isoformat()
    for scene in scenes.SCENES:
        if scene.name not in chosen.scenes.split(","):
            continue
        run_scene(place, scene, chosen, runs)
        kept = {
            "date": date, "machine": machine(), "threads": chosen.threads, "quick": chosen.quick,
            "whole_seconds": time.monotonic() - started, "runs": runs, "self_check": self_check(runs),
        }
        # After every scene, so that an interrupted run leaves what it has.
        (place.folder / "last.json").write_text(json.dumps(kept, indent=1))
    table = report.markdown(kept)
    (place.folder / "RESULTS.md").write_text(table)
    if chosen.keep:
        simd, model = kept["machine"]["widest_simd"], kept["machine"]["processor"].split(" @")[0]
        label = "-".join("".join(c if c.isalnum() else " " for c in f"{model} {simd}").lower().split())
        (HERE / "runs").mkdir(exist_ok=True)
        (HERE / "runs" / f"{date}-{label}.json").write_text(json.dumps(kept, indent=1) + "\n")
        (HERE / "RESULTS.md").write_text(table)
    print(table)
    for fault in kept["self_check"]:
        say(f"self-check: {fault}")
    return 1 if kept["self_check"] else 0


if __name__ == "__main__":
    sys.exit(main())
