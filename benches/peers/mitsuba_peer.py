"""Renders a job with Mitsuba 3: `sphere` shapes of smooth dielectric, unlimited path length, no roulette."""

import time

import drjit as dr
import mitsuba as mi
import numpy as np

import common


def sky():
    """Radiance 1 above the horizon, 0 below. The rows on either side of the horizon lie symmetrically about
    it, so that the linear interpolation between them changes nothing on average."""
    rows = np.zeros((2048, 4, 3), dtype=np.float32)
    rows[:1024] = 1.0
    return {"type": "envmap", "bitmap": mi.Bitmap(rows)}


def scene(job, centres, radii, shift):
    up = [0, 1, 0]
    described = {
        "type": "scene",
        "integrator": {"type": "path", "max_depth": -1, "rr_depth": 1 << 30},
        "sensor": {
            "type": "perspective",
            "fov": job["fov"],
            "fov_axis": "y",
            "near_clip": 0.01,
            "far_clip": 1e6,
            "to_world": mi.ScalarTransform4f().look_at(
                origin=list(np.array(job["from"]) - shift), target=list(np.array(job["at"]) - shift), up=up
            ),
            "film": {
                "type": "hdrfilm",
                "width": job["size"],
                "height": job["size"],
                "pixel_format": "rgb",
                "component_format": "float32",
                "rfilter": {"type": "box"},
            },
            "sampler": {"type": "independent", "sample_count": 1},
        },
        "light": sky(),
        "ice": {"type": "dielectric", "int_ior": job["ior"], "ext_ior": 1.0},
    }
    if job["ground"]:
        described["ground"] = {
            "type": "rectangle",
            "to_world": mi.ScalarTransform4f()
            .translate([0, -shift[1], 0])
            .rotate([1, 0, 0], -90)
            .scale([1e4, 1e4, 1]),
            "bsdf": {"type": "diffuse", "reflectance": {"type": "rgb", "value": 0.0}},
        }
    ice = {"type": "ref", "id": "ice"}
    for i, (centre, radius) in enumerate(zip((centres - shift).tolist(), radii.tolist())):
        described[f"g{i}"] = {"type": "sphere", "center": centre, "radius": radius, "bsdf": ice}
    return mi.load_dict(described)


def main():
    job = common.read_job()
    mi.set_variant("scalar_rgb")
    dr.set_thread_count(job["threads"])
    mi.set_log_level(mi.LogLevel.Error)
    # Ray offsets in Mitsuba grow with the distance from the origin: the grains are centred there.
    centres, radii = common.read_grains(job["grains"])
    shift = 0.5 * (centres.min(axis=0) + centres.max(axis=0))
    mi.render(scene(job, centres[:1], radii[:1], shift), spp=1)
    empty = common.status_bytes("VmRSS")

    start = common.cpu_seconds()
    loaded = scene(job, centres, radii, shift)
    load = common.cpu_seconds() - start

    batches = []
    start, start_wall = common.cpu_seconds(), time.monotonic()
    for batch in range(job["batches"]):
        picture = mi.render(loaded, spp=job["samples_per_batch"], seed=1000 + batch)
        batches.append(np.array(picture)[:, :, 0])
    common.answer(
        job,
        batches,
        version=mi.__version__,
        variant="scalar_rgb",
        load_cpu_seconds=load,
        render_cpu_seconds=common.cpu_seconds() - start,
        render_seconds=time.monotonic() - start_wall,
        empty_bytes=empty,
        peak_bytes=common.status_bytes("VmHWM"),
        path_cap=None,
    )


main()
