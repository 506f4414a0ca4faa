"""Turns the figures of a run into Markdown. `python3 report.py FILE.json` prints the table of a kept run."""

import json
import math
import sys

import scenes

# An earlier Embree tracer written by hand for the same scenes, M interface events per CPU second on two
# cores of a Sapphire Rapids class machine with AVX-512 at 2.75 to 3.9 GHz: a measure of how good this one is.
# Its deposit had another shape, and it found every surface by a ray.
EARLIER = {"cube-32": 8.5, "cube-64": 7.25, "cube-120": 6.2, "deposit-1m": 2.65}
EARLIER_GHZ = (2.75, 3.9)


def find(runs, tracer, scene):
    """The main row of a tracer on a scene."""
    return next((r for r in runs if r["tracer"] == tracer and r["scene"] == scene and not r.get("variant_of_main")), None)


def table(heads, rows):
    lines = ["| " + " | ".join(heads) + " |", "|" + "---|" * len(heads)]
    return "\n".join(lines + ["| " + " | ".join(row) + " |" for row in rows])


def number(value, digits=3):
    """A number with this many significant digits and no exponent."""
    if value is None:
        return "-"
    if value == 0:
        return "0"
    places = max(digits - 1 - math.floor(math.log10(abs(value))), 0)
    return f"{value:.{places}f}"


def sigmas(pair, other, other_error):
    both = math.hypot(pair[1], other_error)
    return "-" if both == 0 else f"{(pair[0] - other) / both:+.1f}"


def mean(pair):
    return f"{pair[0]:.4f} ± {pair[1]:.4f}"


def rates(run, what):
    """Per CPU second, of this row and of its repeats."""
    return [r[what] / r["render_cpu_seconds"] for r in [run, *run.get("repeats", [])]]


def speed_row(run, exact):
    if "samples" not in run:
        return [run["tracer"], "-", run.get("unavailable") or "failed: " + run["failed"].splitlines()[0][:120]] + ["-"] * 7
    rate = max(rates(run, "samples"))
    if run["events"] is not None:
        of_events = sorted(x / 1e6 for x in rates(run, "events"))
        events = number(of_events[-1])
        if len(of_events) > 1:
            events += f" (from {number(of_events[0])})"
    elif exact and "events" in exact:
        events = "≈ " + number(exact["events"] / exact["samples"] * rate / 1e6)
    else:
        events = "-"
    visits = run["visits"] and max(rates(run, "visits")) / 1e6
    ratio = exact and "samples" in exact and max(rates(exact, "samples")) / rate
    return [
        run["tracer"], run["version"], run["variant"], number(rate / 1e6), number(run["samples"] / run["render_seconds"] / 1e6),
        events, number(visits), number(ratio) if ratio else "-",
        number(run["load_cpu_seconds"], 2), f"{run['bytes'] / run['grains']:.0f}",
    ]


def mean_row(run, exact, truth):
    if "interior" not in run:
        return None
    interior, hull = run["interior"], run["hull"]
    of_exact = of_truth = relative = "-"
    if exact and exact is not run and "interior" in exact:
        of_exact = sigmas(interior, *exact["interior"])
        relative = f"{100 * (interior[0] / exact['interior'][0] - 1):+.2f} %"
    if truth:
        of_truth = sigmas(interior, truth[0], scenes.TRUTH_TOLERANCE)
    cap = "none" if run["path_cap"] is None else str(run["path_cap"])
    return [run["tracer"], run["variant"], mean(interior), relative, of_exact, of_truth, mean(hull), number(run["highest_pixel"]), cap]


def scene_part(scene, runs):
    mine = [r for r in runs if r["scene"] == scene.name]
    if not mine:
        return []
    exact = find(runs, "snowgrain", scene.name)
    speed = table(["tracer", "version", "settings", "M samples/CPU-s", "M samples/s", "M events/CPU-s", "M visits/CPU-s",
                   "Snowgrain is faster by", "load + build, CPU-s", "bytes/grain"], [speed_row(r, exact) for r in mine])
    radiance = table(["tracer", "settings", "mean radiance, interior", "from Snowgrain", "in σ", "from truth, in σ", "hull",
                      "highest pixel", "path cap"],
                     [row for row in (mean_row(r, exact, scene.truth) for r in mine) if row])
    title = f"## {scene.name}"
    if scene.truth:
        title += f" (truth: interior {scene.truth[0]}, hull {scene.truth[1]})"
    return [title, speed, radiance]


def caps_part(runs):
    main = [r for r in runs if r["tracer"] == "embree" and "light_within_cap" in r and not r.get("variant_of_main")]
    if not main:
        return []
    caps = list(main[0]["light_within_cap"])
    rows = [[r["scene"], *(f"{100 * r['light_within_cap'][cap]:.2f} %" for cap in caps), number(r["events"] / r["samples"]),
             str(r["longest_path"])] for r in main]
    return ["## What a cap on the path costs",
            "Light of the interior pixels that arrives after at most so many interface events, in percent of all of it "
            "(Embree tracer, which has no cap).",
            table(["scene", *caps, "events/sample", "longest path"], rows)]


def clock_part(runs):
    clocks = [c for r in runs for c in r.get("clock_ghz", [])]
    if not clocks:
        return []
    lines = [f"Clock while the Embree tracer ran: {min(clocks):.2f} to {max(clocks):.2f} GHz (chain of dependent additions)."]
    rows = []
    for scene, earlier in EARLIER.items():
        best = [max(rates(r, "events")) / 1e6 for r in runs
                if r["tracer"] == "embree" and r["scene"] == scene and "events" in r]
        if best:
            low, high = (max(best) / earlier / (max(clocks) / ghz) for ghz in reversed(EARLIER_GHZ))
            rows.append([scene, number(max(best)), number(earlier), number(max(best) / earlier, 2),
                         f"{number(min(low, high), 2)} to {number(max(low, high), 2)}"])
    if rows:
        lines += [f"Is the opponent good? An earlier tracer on cores with AVX-512 at {EARLIER_GHZ[0]} to {EARLIER_GHZ[1]} GHz "
                  "(Embree 4.4, one ray at a time) made so many M events/CPU-s:",
                  table(["scene", "now, best settings", "earlier", "ratio", "ratio at equal clock"], rows)]
    return ["## The opponent and the clock", *lines]


def markdown(kept):
    host = kept["machine"]
    parts = [
        "# Snowgrain and its peers: the same grains, the same camera",
        f"{kept['date']}, commit {host['commit']}; {host['processors']} processors {host['processor']} (family, model "
        f"{', '.join(map(str, host['family_model']))}; {host['widest_simd']}), {host['memory']}; {host['compiler']}; Python "
        f"{host['python']}; {kept['threads']} threads; {kept['whole_seconds'] / 60:.0f} minutes"
        f"{', quick run' if kept['quick'] else ''}. Printed by `benches/peers/run.sh`; what each column means: "
        "[README.md](README.md).",
    ]
    for scene in scenes.SCENES:
        parts += scene_part(scene, kept["runs"])
    parts += caps_part(kept["runs"]) + clock_part(kept["runs"])
    fine = "the tracers that claim to be exact agree with the truth and with each other."
    parts += ["## Self-check", "\n".join("- " + f for f in kept["self_check"]) if kept["self_check"] else "Passed: " + fine]
    return "\n\n".join(parts) + "\n"


if __name__ == "__main__":
    with open(sys.argv[1]) as file:
        print(markdown(json.load(file)))
