"""How `denoise` does on depth maps, whose noise neighbours share, and whether it sees that they are such.

    python benchmarks/denoising_cameras.py [--half looked_at|unseen] [--only text,text]

Scenes are put before simulated cameras: structured light, whose disparity is matched over windows and rounded; time of flight,
whose noise is partly smoothed; level sets fused from many maps; and two cameras with independent noise, which must not be taken
for the others. Scenes are in two halves; constants were looked at on one. Prints what kind is found of each map and of its truth,
and the mean angles to the true normals of nothing, of the choice, and of what is chosen where shared noise is not looked for.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterator
from typing import NamedTuple

import igl
import numpy as np
from denoising_choice import left_out
from denoising_metrics import Floats, Ints, NoisyPair, measured, used_alone
from denoising_pairs import between_rows
from scipy.ndimage import gaussian_filter, map_coordinates
from scipy.spatial.transform import Rotation

from pymeshfair.filters.denoising import Setting, automatic_choice

#: heights in mm above the background, at places in mm; not a number where there is nothing to see
Scene = Callable[[Floats, Floats], Floats]


class Camera(NamedTuple):
    """A depth camera: focal length in pixels, distance of the background in mm, and its noise.

    Attributes:
        kind: "light" (structured light), "flight" (time of flight), "view" (independent noise along the view) or "fused".
        distance: how far the background is.
        level: the standard deviation of the noise, in steps of the disparity (light), in mm at 1 m (flight), in pixels (view).
        width: over how many pixels noise is shared, as a standard deviation.
        step: the step of the disparity in pixels.
        focal: the focal length in pixels; in fused maps the size of a cell in mm.
    """

    kind: str
    distance: float = 850.0
    level: float = 0.5
    width: float = 2.0
    step: float = 0.125
    focal: float = 570.0


#: Structured light: 75 mm between projector and camera, steps of an eighth of a pixel. Time of flight: fewer pixels.
CAMERAS: dict[str, Camera] = {
    "light": Camera("light"),
    "light_far": Camera("light", distance=1200.0),
    "light_narrow": Camera("light", level=0.4, width=1.2),
    "light_wide": Camera("light", level=0.6, width=3.5),
    "light_fine": Camera("light", step=0.0625, level=0.8),
    "light_coarse": Camera("light", step=0.2, level=0.4, focal=800.0),
    "flight": Camera("flight", level=1.2, width=1.0, focal=365.0),
    "flight_near": Camera("flight", distance=650.0, level=1.5, width=1.5, focal=365.0),
    "flight_far": Camera("flight", distance=1200.0, level=1.2, width=0.8, focal=500.0),
    "fused": Camera("fused", level=1.0, focal=1.6),
    "fused_fine": Camera("fused", level=0.6, focal=2.2),
    "view": Camera("view", level=0.3),
    "view_weak": Camera("view", level=0.12, focal=365.0),
}


def _bust(seed: int) -> Scene:
    """A face: an oval with nose, brows, eyes, a mouth, and strands of hair."""
    rng = np.random.default_rng(seed)
    a, b, nose, hair = rng.uniform((70, 95, 14, 1.0), (85, 115, 24, 2.0))
    bumps = [(*rng.uniform((-50, -70), (50, 30)), *rng.uniform((8, 3), (20, 7))) for _ in range(8)]

    def height(x: Floats, y: Floats) -> Floats:
        inside = 1.0 - (x / a) ** 2 - (y / b) ** 2
        z = 75.0 * np.sqrt(np.maximum(inside, 0.0))
        z += nose * np.exp(-((x / 10) ** 2) - ((y + 5) / 20) ** 2) - 9.0 * np.exp(-((abs(x) - 28) ** 2 + (y - 18) ** 2) / 130)
        z += 5.0 * np.exp(-((y - 32) ** 2) / 60 - (x / 45) ** 2) - 5.0 * np.exp(-((y + 42) ** 2) / 20 - (x / 22) ** 2)
        z += sum(h * np.exp(-((x - u) ** 2 + (y - v) ** 2) / r**2) for u, v, r, h in bumps)
        z += hair * 1.5 * np.where(y > 45, np.sin(x / 3.5 + 0.04 * y * np.sin(y / 15)), 0.0)
        return np.where(inside > 0.08, z, np.nan)

    return height


def _pointed(away: Scene, height: float, slope: float, reach: float) -> Scene:
    """It falls with the distance from its tip."""
    return lambda x, y: np.where(away(x, y) < reach, height - slope * away(x, y), np.nan)


def _stairs(x: Floats, y: Floats) -> Floats:
    """Treads facing up and to the camera, as if seen from above at 45 degrees."""
    t = (y + 0.3 * x + 200.0) % 45.0
    z = np.where(t < 22.5, t, 45.0 - t)
    return np.where((abs(x) < 105) & (abs(y) < 100), z, np.nan)


def _ball(x: Floats, y: Floats) -> Floats:
    r = np.hypot(x, y)
    relief = 4.0 * np.sin(x / 9) * np.sin(y / 11) * (r < 60)
    return np.where(r < 92, np.sqrt(np.maximum(100.0**2 - r**2, 0.0)) + relief, np.nan)


def _desk(x: Floats, y: Floats) -> Floats:
    """A ball, a roof and a cylinder on a sloping plane."""
    z = 0.25 * y
    z = np.maximum(z, np.sqrt(np.maximum(45.0**2 - (x + 50) ** 2 - (y - 40) ** 2, 0.0)) + 5.0)
    z = np.where((abs(x - 45) < 40) & (abs(y - 35) < 45), np.maximum(z, 45.0 - 1.0 * abs(x - 45)), z)
    return np.where(abs(y + 55) < 28, np.maximum(z, np.sqrt(np.maximum(30.0**2 - (y + 55) ** 2, 0.0))), z)


def _person(x: Floats, y: Floats) -> Floats:
    """A trunk with a head and arms, as bumps that run into each other."""
    parts = ((0, -25, 48, 60, 50), (0, 65, 26, 32, 42), (-62, -20, 18, 55, 30), (62, -30, 18, 55, 34), (20, -10, 14, 18, 12))
    fields = [np.exp(-(((x - u) / a) ** 2) - ((y - v) / b) ** 2) * h for u, v, a, b, h in parts]
    z = np.sum(fields, axis=0) + 2.0 * np.sin(y / 8 + x / 25) * np.exp(-((x / 45) ** 2) - ((y + 25) / 45) ** 2)
    return np.where(z > 6.0, 1.6 * z, np.nan)


#: the half that constants may be looked at on, and the other
SCENES: dict[str, dict[str, Scene]] = {
    "looked_at": {
        "cone": _pointed(np.hypot, 150.0, 1.3, 105.0),
        "bust1": _bust(3),
        "stairs": _stairs,
        "hills": lambda x, y: 25.0 * np.sin(x / 28) * np.cos(y / 33) + 22.0 * np.exp(-((x - 15) ** 2 + (y + 20) ** 2) / 900),
    },
    "unseen": {
        "pyramid": _pointed(lambda x, y: np.maximum(abs(0.88 * x + 0.47 * y), abs(0.88 * y - 0.47 * x)), 130.0, 1.2, 95.0),
        "bust2": _bust(8),
        "ball": _ball,
        "desk": _desk,
        "person": _person,
    },
}


def pairs(half: str, only: list[str]) -> Iterator[NoisyPair]:
    """Every scene of a half before every camera."""
    for at, (scene, height) in enumerate(SCENES[half].items()):
        for number, (name, camera) in enumerate(CAMERAS.items()):
            if not only or any(text in f"{scene}_{name}" for text in only):
                rng = np.random.default_rng([17 if half == "looked_at" else 29, at, number])
                made = fused_map(height, camera, rng) if camera.kind == "fused" else depth_map(height, camera, rng)
                yield NoisyPair(f"{scene}_{name}", *made)


def depth_map(height: Scene, camera: Camera, rng: np.random.Generator) -> tuple[Floats, Floats, Ints]:
    """Noisy vertices, true vertices and faces: a pixel a vertex, moved along its line of sight; jumps of depth are cut."""
    half = int(115.0 / (camera.distance - 60.0) * camera.focal) + 3
    slope = np.arange(-half, half + 1) / camera.focal
    x, y = np.meshgrid(slope, slope)
    depth = _ray_cast(height, x, y, camera.distance)
    hit = np.isfinite(depth)
    filled = np.where(hit, depth, camera.distance)
    pixel = camera.distance / camera.focal

    def shared(width: float) -> Floats:
        field = gaussian_filter(rng.normal(size=depth.shape), width)
        return np.asarray(field / field.std())

    if camera.kind == "light":
        base = 75.0 * camera.focal
        rows, columns = np.indices(depth.shape)
        moved = [rows + 0.5 * shared(1.0), columns + 0.5 * shared(1.0)]
        disparity = map_coordinates(gaussian_filter(base / filled, 0.5 * camera.width), moved, order=1, mode="nearest")
        disparity += camera.step * (camera.level * shared(camera.width) + 0.1 * rng.normal(size=depth.shape))
        found = base / (np.round(disparity / camera.step) * camera.step)
    elif camera.kind == "flight":
        sigma = camera.level * (filled / 1000.0) ** 2
        found = filled + sigma * (0.85 * shared(camera.width) + 0.35 * rng.normal(size=depth.shape))
    else:
        found = filled + camera.level * pixel * rng.normal(size=depth.shape)
    # The border is where the camera lost the object.
    ragged = gaussian_filter(hit.astype(float), 1.5) + 0.12 * shared(1.5) > 0.8
    faces = between_rows(np.arange(depth.size).reshape(depth.shape))
    seen = (hit & ragged).ravel()[faces].all(axis=1) & (np.ptp(filled.ravel()[faces], axis=1) < 5 * pixel)
    noisy, truth = (np.column_stack([(x * z).ravel(), (y * z).ravel(), -z.ravel()]) for z in (found, filled))
    return used_alone(faces[seen], noisy, truth)


def _ray_cast(height: Scene, x: Floats, y: Floats, distance: float) -> Floats:
    """The depth at which each line of sight meets the surface first; not a number where it does not."""
    depth, before = np.full(x.shape, np.nan), np.full(x.shape, -1.0)
    steps = np.arange(distance - 260.0, distance + 80.0, 1.0)
    for z in steps:
        above = height(x * z, y * z) - (distance - z)
        met = np.isnan(depth) & (above >= 0.0) & (before < 0.0)
        depth[met] = z - above[met] / (above[met] - before[met])
        before = np.where(np.isnan(above), -np.inf, above)
    return depth


def fused_map(height: Scene, camera: Camera, rng: np.random.Generator) -> tuple[Floats, Floats, Ints]:
    """A level set in cells, its errors shared over 10, 4, 2 and 1 cells, as those of a Kinect, weaker ones, and the truth."""
    cell = camera.focal
    plan, deep = np.arange(-115.0, 115.0, cell), np.arange(-60.0, 190.0, cell)
    n = len(plan)
    turn = Rotation.from_rotvec(rng.uniform(-0.4, 0.4, size=3)).as_matrix()
    z, y, x = (a.ravel() for a in np.meshgrid(deep, plan, plan, indexing="ij"))
    grid = np.column_stack([x, y, z])
    error = np.zeros((n, n))
    for width, size in ((10.0, 0.7), (4.0, 0.35), (2.0, 0.3), (1.0, 0.25), (0.0, 0.2)):
        layer = rng.normal(size=(n, n))
        layer = gaussian_filter(layer, width) if width > 0 else layer
        error += camera.level * size * cell * layer / layer.std()
    seen = grid @ turn
    surface = np.nan_to_num(height(seen[:, 0], seen[:, 1]), nan=-200.0)
    # The distance along the view, over the slope, is nearly the distance to the surface.
    values = seen[:, 2] - surface
    values -= map_coordinates(error, (seen[:, 1::-1].T + 115.0) / cell, order=1, mode="nearest")
    found, faces, *_ = igl.marching_cubes(values, grid, n, n, len(deep), 0.0)
    true = found @ turn
    true[:, 2] = height(true[:, 0], true[:, 1])
    known = np.isfinite(true).all(axis=1) & (abs((found @ turn)[:, 2] - true[:, 2]) < 6.0 * cell)
    true = true @ turn.T
    faces = faces[known[faces].all(axis=1)]
    corners = true[faces]
    faces = faces[np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) > 1e-3 * cell**2]
    return used_alone(faces, found, true)


def main() -> int:
    """Make, denoise and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--half", choices=sorted(SCENES), default="looked_at")
    parser.add_argument("--only", default="", help="parts of names, with commas; all by default")
    options = parser.parse_args()
    rows, wrong = [], 0
    print("map                    faces       kind  of truth  nothing  chosen  not looked for")
    for pair in pairs(options.half, [part for part in options.only.split(",") if part]):
        choice = automatic_choice(pair.noisy, pair.faces)
        truth = automatic_choice(pair.truth, pair.faces).kind
        shared = "view" not in pair.name
        wrong += ((choice.kind == "correlated") != shared) + (truth == "correlated")
        with left_out(["shared", "rounding"]):
            other = automatic_choice(pair.noisy, pair.faces).setting
        results = (setting.apply(pair.noisy, pair.faces) for setting in (Setting(), choice.setting, other))
        found = [measured(result, pair.truth, pair.faces)[0] for result in results]
        if shared:
            rows.append(np.log(found))
        told = "{:9.2f} {:7.2f} {:15.2f}".format(*found)
        print(f"{pair.name:20} {len(pair.faces):7} {choice.kind:>10} {truth:>9}{told}", flush=True)
    if not rows:
        raise SystemExit(f"no map of a camera has a name with {options.only}")
    print(f"{wrong} kinds are wrong; geometric means over {len(rows)} maps:", np.exp(np.mean(rows, axis=0)).round(2))
    return 0


if __name__ == "__main__":
    sys.exit(main())
