"""Recipes against scans: what suits what, and whether a recipe inside its stated range is as good as the best of three.

    python benchmarks/recipes.py FOLDER [--only text,text] [--made] [--scans FOLDER] [--suggest]

FOLDER has `NAME_noisy.ply` and `NAME_truth.ply` whose faces have the same numbers, and may have scans beside them. --made takes
pairs of `denoising_pairs` in place of them: generated shapes, samples, and scans made smooth. For every pair and recipe there is
the measure that the head of the recipe names under Judged, over the best of its rivals: 1.00 is as good, more is worse. In
brackets where the pair is outside of what the recipe says that it fits.

Rivals are MeshLab's Taubin filter (10 steps) and its two-step filter, each with its defaults, and `denoise`; of a recipe that is
judged "in plain MeshLab" the first two. "normals" is the mean angle to the true normals; "waves" is measured on the surface
without noise, see `recipe_waves`. Last, every case inside its range that is worse.

--suggest compares the first recipe that `pymeshfair suggest` names with those that were written down as right, before it was run.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
from collections.abc import Iterable, Iterator
from functools import partial
from pathlib import Path

import numpy as np
import pymeshlab
from denoising_metrics import Floats, Ints, NoisyPair, errors
from denoising_pairs import looked_at, made, unseen
from recipe_waves import waves_of_sizes, wrong

from pymeshfair import MeshSet, Recipe
from pymeshfair.mesh_data import MeshData
from pymeshfair.recipe import load_recipe
from pymeshfair.running.measuring import measure
from pymeshfair.running.suitability import judged, traits_of

SAMPLES = Path(pymeshlab.__file__).parent / "tests/sample_meshes"
#: MeshLab's own filters with their defaults, by the names of their columns
MESHLAB = {"Taubin": "apply_coord_taubin_smoothing", "two steps": "apply_coord_two_steps_smoothing"}
RECIPES = ("denoise", "denoise_meshlab_only", "smooth_taubin", "smooth_implicit", "spectral_low_pass")
#: a result may be worse by this share and still counts as good: the spread of choices that are made from noise
TOLERANCE = 0.05
#: the made pairs: every kind of shape, sharp and smooth, from weak noise to strong, and impulses
MADE = (
    "bracket_n3",
    "lens_n2",
    "blobs_n2",
    "torus_n1",
    "terrain_n1",
    "rabbit_n2",
    "cow_n3",
    "bunny10k_n1",
    "gear_n2",
    "gear_n6",
    "house_n2",
    "chest_n3",
    "chest_i8",
    "dodecahedron_a3",
    "bone_n2",
    "airplane_n2",
    "gyroid_n3",
    "knot_n3",
    "angel_n2",
    "iron_n1",
)

#: the right first recipes, written down before `suggest` had ranked any of these
RIGHT: dict[str, tuple[str, ...]] = {
    "block_n4_noisy.ply": ("denoise",),
    "bunny_n2_noisy.ply": ("denoise",),
    "child_n3_noisy.ply": ("denoise",),
    "fandisk_n3_noisy.ply": ("denoise",),
    "fandisk_n7_noisy.ply": ("denoise",),
    "fertility_n3_noisy.ply": ("denoise",),
    "julius_n2_noisy.ply": ("denoise",),
    "kinect_cone_noisy.ply": ("denoise",),
    "nicolo_n2_noisy.ply": ("denoise",),
    "sharpsphere_n3_noisy.ply": ("denoise",),
    "twelve_i5_noisy.ply": ("denoise",),
    "angel.obj": ("clean_range_map", "denoise"),
    "rabbit.obj": ("clean_range_map", "denoise"),
    "iron.ply": ("clean_range_map", "denoise"),
    "bone.ply": ("prepare_for_print", "prepare_for_simulation", "improve_triangles"),
    "bunny.obj": ("prepare_for_print", "prepare_for_simulation", "improve_triangles"),
    "bunny10k_textured.obj": ("clean_photogrammetry", "fill_holes_smoothly"),
    "cow.obj": ("prepare_for_simulation", "improve_triangles", "prepare_for_print"),
    "airplane.obj": ("prepare_for_print", "prepare_for_simulation", "improve_triangles"),
    "rangemaps/face000.ply": ("clean_range_map", "register_ready"),
}


def read(path: Path) -> tuple[Floats, Ints]:
    """Vertices and faces of a file."""
    meshes = pymeshlab.MeshSet()
    meshes.load_new_mesh(str(path))
    mesh = meshes.current_mesh()
    return mesh.vertex_matrix(), np.ascontiguousarray(mesh.face_matrix(), dtype=np.int32)


def cleaned(recipe: str, vertices: Floats, faces: Ints, *settings: str) -> Floats:
    """The vertices after a recipe."""
    meshes = MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(vertices, faces))
    chosen = Recipe.load(recipe)
    chosen.set(*settings)
    chosen.apply(meshes)
    return np.asarray(meshes.current_mesh().vertex_matrix())


def smoothed(method: str, vertices: Floats, faces: Ints) -> Floats:
    """The vertices after one of `MESHLAB`."""
    meshes = pymeshlab.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(vertices, faces))
    meshes.apply_filter(MESHLAB[method])
    return np.asarray(meshes.current_mesh().vertex_matrix())


def pairs(folder: Path, only: list[str]) -> Iterator[NoisyPair]:
    """Those of a folder."""
    for path in sorted(folder.rglob("*_noisy.ply")):
        name = path.stem.removesuffix("_noisy")
        if not only or any(text in name for text in only):
            vertices, faces = read(path)
            yield NoisyPair(name, vertices, read(path.with_name(f"{name}_truth.ply"))[0], faces)


def made_pairs(scans: Path | None, only: list[str]) -> Iterator[NoisyPair]:
    """Those of `MADE`."""
    names = [name for name in MADE if not only or any(text in name for text in only)]
    for shape in (*looked_at(scans), *unseen(scans)):
        yield from made([shape], [name for name in names if name.rpartition("_")[0] == shape.name] or ["none"])


def matrix(found: Iterable[NoisyPair]) -> Iterator[str]:
    """A row for every pair; last what is worse than it should be."""
    columns = (*MESHLAB, *RECIPES)
    yield f"{'pair':16} {'noise':>5} {'sharp':>5} " + " ".join(f"{name[-12:]:>14}" for name in columns)
    worse: list[str] = []
    for pair in found:
        vertices, truth, faces = pair.noisy, pair.truth, pair.faces
        traits = traits_of(measure(MeshData(vertices=vertices, faces=faces)))
        fits = {name: judged(name, load_recipe(name).info, traits).fits for name in RECIPES}
        results = {name: smoothed(name, vertices, faces) for name in MESHLAB}
        results |= {name: cleaned(name, vertices, faces) for name in RECIPES}
        angles = {name: errors(result, truth, faces).mad for name, result in results.items()}
        left = (
            waves_left(truth, faces) if any(fits[name] and load_recipe(name).info.measure == "waves" for name in RECIPES) else {}
        )
        cells = {name: f"{angle:.2f} deg" for name, angle in angles.items()}
        for name in RECIPES:
            info = load_recipe(name).info
            values = left if info.measure == "waves" else angles
            if name not in values:
                cells[name] = "(-)"
                continue
            rivals = MESHLAB if "in plain MeshLab" in info.judged else (*MESHLAB, "denoise")
            ratio = values[name] / min(values[rival] for rival in rivals)
            cells[name] = f"{ratio:.2f} {info.measure}" if fits[name] else f"({ratio:.2f} {info.measure})"
            if fits[name] and ratio > 1.0 + TOLERANCE:
                worse.append(f"{name} on {pair.name} {ratio:.2f}")
        row = " ".join(f"{cells[name]:>14}" for name in columns)
        yield f"{pair.name:16} {traits['noise']:5.2f} {traits['sharpness']:5.2f} {row}"
        yield f"  {'degrees':27} " + " ".join(f"{angles[name]:14.2f}" for name in columns)
        if left:
            yield f"  {'waves':27} " + " ".join(f"{left[name]:14.2f}" if name in left else " " * 14 for name in columns)
    yield f"worse than the best of their rivals inside the range: {'; '.join(worse) or 'none'}"


def waves_left(truth: Floats, faces: Ints) -> dict[str, float]:
    """What `recipe_waves.wrong` says of each recipe that is judged by waves and of its rivals, the worst of several sizes."""
    given = waves_of_sizes(truth, faces)

    def filtered(name: str, vertices: Floats, size: float) -> Floats:
        if name in MESHLAB:
            return smoothed(name, vertices, faces)
        return cleaned(name, vertices, faces, *([] if name == "denoise" else [f"detail_size={size!r}"]))

    judged_by_it = [name for name in RECIPES if load_recipe(name).info.measure == "waves"]
    return {name: wrong(partial(filtered, name), truth, faces, given) for name in (*MESHLAB, "denoise", *judged_by_it)}


def suggestions(folder: Path, only: list[str]) -> Iterator[str]:
    """For every input of `RIGHT` what is suggested first, and whether that is right."""
    hits = count = 0
    for name, right in RIGHT.items():
        if only and not any(text in name for text in only):
            continue
        places = [SAMPLES / name, *folder.rglob(name)]
        path = next((place for place in places if place.is_file()), None)
        if path is None:
            yield f"{name}: not there"
            continue
        command = [sys.executable, "-m", "pymeshfair", "suggest", str(path), "--json"]
        done = subprocess.run(command, capture_output=True, text=True)
        first = json.loads(done.stdout)["recipes"][0]["recipe"]
        count += 1
        hits += first in right
        yield f"{name:26} {first:24} {'right' if first in right else 'wrong, should be ' + ' or '.join(right)}"
    yield f"{hits} of {count} right"


def main() -> int:
    """Run and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--only", default="", help="parts of names, with commas; all by default")
    parser.add_argument("--made", action="store_true", help="pairs that are made here")
    parser.add_argument("--scans", type=Path, help="of which some of these are made")
    parser.add_argument("--suggest", action="store_true")
    options = parser.parse_args()
    only = [text for text in options.only.split(",") if text]
    found = made_pairs(options.scans, only) if options.made else pairs(options.folder, only)
    for line in suggestions(options.folder, only) if options.suggest else matrix(found):
        print(line, flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
