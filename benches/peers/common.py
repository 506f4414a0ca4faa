"""What the runner and the peers' processes share: grains, CPU time, memory, means of batches."""

import json
import resource
import sys

import numpy as np

GRAIN = np.dtype([("x", "<f8"), ("y", "<f8"), ("z", "<f8"), ("radius", "<f4")])


def read_grains(path):
    """Centres (n, 3) and radii (n) from a PLY that `snowgrain deposit` wrote."""
    with open(path, "rb") as file:
        header = file.readline() + file.readline()
        while not header.endswith(b"end_header\n"):
            line = file.readline()
            if not line:
                raise ValueError(f"{path}: no end_header")
            header += line
        data = np.fromfile(file, dtype=GRAIN)
    centres = np.stack([data["x"], data["y"], data["z"]], axis=1)
    return centres, data["radius"]


def cpu_seconds():
    usage = resource.getrusage(resource.RUSAGE_SELF)
    return usage.ru_utime + usage.ru_stime


def status_bytes(key):
    """`VmRSS` (now) or `VmHWM` (the most so far) of this process, in bytes."""
    with open("/proc/self/status") as file:
        for line in file:
            if line.startswith(key + ":"):
                return int(line.split()[1]) * 1024
    raise KeyError(key)


def read_job():
    """The job that the runner hands to a peer's process as its only argument."""
    with open(sys.argv[1]) as file:
        return json.load(file)


def answer(job, batches, **figures):
    """Keeps the pictures of all batches (k, height, width) and the figures for the runner."""
    np.save(job["pictures"], np.asarray(batches, dtype=np.float32))
    with open(job["answer"], "w") as file:
        json.dump(figures, file)
