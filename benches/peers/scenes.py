"""The scenes that every tracer renders, how many samples each gets, and which pixels count."""

import dataclasses
import pathlib
import tomllib

import numpy as np

HERE = pathlib.Path(__file__).parent
SIZE = 256


@dataclasses.dataclass
class Scene:
    name: str
    source: str  # a scene file, or the name of a built-in scene
    side: int | None  # of a cube, in grains
    overlaps: bool
    samples: dict  # samples a pixel for each tracer; peers in Python also split them into batches
    truth: tuple | None = None  # mean radiance of the interior and of the hull, from an independent walker
    quick: tuple = ("snowgrain", "embree")  # tracers of the quick run

    @property
    def grains_path(self):
        return f"{self.name}.ply"


# The truth of the cubes is what the tests use (tests/src/reference.rs): a double-precision walker of the
# lattice's cells, given to four and three decimals.
ALL = ("snowgrain", "embree", "mitsuba", "cycles")
SCENES = [
    Scene("cube-32", "cube-32.toml", 32, False, {"snowgrain": 128, "embree": 64, "mitsuba": 16, "cycles": 16},
          (0.4063, 0.372), ALL),
    Scene("cube-64", "cube-64.toml", 64, False, {"snowgrain": 64, "embree": 32, "mitsuba": 8, "cycles": 8},
          (0.4947, 0.472)),
    Scene("cube-120", "snow-cube-sc", 120, False, {"snowgrain": 64, "embree": 32, "mitsuba": 4, "cycles": 8},
          (0.5571, 0.543)),
    Scene("deposit-1m", "deposit-1m.toml", None, True, {"snowgrain": 32, "embree": 8, "mitsuba": 4, "cycles": 8}),
    Scene("stick-1m", "stick-1m.toml", None, False, {"snowgrain": 32, "embree": 16, "mitsuba": 4, "cycles": 8},
          quick=()),
    Scene("deposit-10m", "deposit-10m.toml", None, True, {"snowgrain": 8, "embree": 2}, quick=()),
]
TRUTH_TOLERANCE = 0.0005  # rounding and noise of the truth, as in Snowgrain's own tests


@dataclasses.dataclass
class Camera:
    origin: np.ndarray
    target: np.ndarray
    fov: float
    ior: float
    ground: bool

    @classmethod
    def of_scene(cls, text):
        """From a scene in TOML."""
        scene = tomllib.loads(text)
        camera = scene["camera"]
        return cls(np.array(camera["from"], float), np.array(camera["at"], float), camera["vertical_fov"],
                   scene["ice"]["ior"], bool(scene.get("object")))

    def corner_directions(self):
        """Directions through the corners of the pixels, (SIZE + 1, SIZE + 1, 3)."""
        forward = self.target - self.origin
        forward /= np.linalg.norm(forward)
        right = np.cross(forward, [0.0, 1.0, 0.0])
        right /= np.linalg.norm(right)
        up = np.cross(right, forward)
        half = np.tan(np.radians(self.fov) / 2)
        at = np.linspace(-half, half, SIZE + 1)
        return forward + at[None, :, None] * right - at[:, None, None] * up

    def sees_box(self, low, high):
        """Pixels whose four corner rays all meet the box [low, high]^3."""
        directions = self.corner_directions()
        a, b = (low - self.origin) / directions, (high - self.origin) / directions
        near, far = np.minimum(a, b).max(axis=-1), np.maximum(a, b).min(axis=-1)
        hit = (near <= far) & (far > 0)
        return hit[:-1, :-1] & hit[1:, :-1] & hit[:-1, 1:] & hit[1:, 1:]


def masks(scene, camera):
    """Interior and hull pixels; in the deposits every pixel is both."""
    if scene.side is None:
        everything = np.ones((SIZE, SIZE), dtype=bool)
        return everything, everything
    return camera.sees_box(1.0, scene.side - 1.0), camera.sees_box(0.0, float(scene.side))


def mean_of(values, variance_of_mean, mask):
    """Mean over the pixels of a mask and its standard error."""
    n = mask.sum()
    return float(values[mask].mean()), float(np.sqrt(variance_of_mean[mask].sum()) / n)


def batch_variance(batches):
    """Mean of independent pictures, and the variance of that mean, pixel by pixel."""
    return batches.mean(axis=0), batches.var(axis=0, ddof=1) / len(batches)
