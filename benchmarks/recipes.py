"""Recipes against scans: what suits what, and whether a recipe inside its stated range is as good as the best of three.

    python benchmarks/recipes.py FOLDER [--only text,text] [--suggest]

FOLDER has `NAME_noisy.ply` and `NAME_truth.ply` whose faces have the same numbers, and may have scans beside them. Prints for
every pair and recipe the measure that the head of the recipe names under Judged, over the best of MeshLab's Taubin
(`smooth_taubin`), MeshLab's two steps (`denoise_meshlab_only`) and `denoise`: 1.00 is as good, more is worse. In brackets where
the pair is outside of what the recipe says that it fits. Last, every case inside its range that is worse; the head must say so,
by "after denoise".

--suggest compares the first recipe that `pymeshfair suggest` names with those that were written down as right, before it was run.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pymeshlab
from denoising_metrics import Floats, Ints, errors

from pymeshfair import MeshSet, Recipe
from pymeshfair.filters.inspection.surface_measures import surface_measures
from pymeshfair.recipe import load_recipe
from pymeshfair.running.suitability import judged, traits_of

SAMPLES = Path(pymeshlab.__file__).parent / "tests/sample_meshes"
#: those that take away noise, the three that others are compared with first
RIVALS = ("smooth_taubin", "denoise_meshlab_only", "denoise")
RECIPES = (
    *RIVALS,
    "denoise_sharp",
    "denoise_smooth",
    "denoise_kinect",
    "smooth_implicit",
    "smooth_laplacian",
    "spectral_low_pass",
)
#: what each recipe may be judged by: lower is better
MEASURES = ("normals", "distance", "dimensions")
#: a result may be worse by this share and still counts as good: the spread of choices that are made from noise
TOLERANCE = 0.05

#: the right first recipes, written down before `suggest` had ranked any of these
RIGHT: dict[str, tuple[str, ...]] = {
    "block_n4_noisy.ply": ("denoise", "denoise_sharp"),
    "bunny_n2_noisy.ply": ("denoise", "denoise_smooth"),
    "child_n3_noisy.ply": ("denoise", "denoise_smooth"),
    "fandisk_n3_noisy.ply": ("denoise", "denoise_sharp"),
    "fandisk_n7_noisy.ply": ("denoise",),
    "fertility_n3_noisy.ply": ("denoise", "denoise_smooth"),
    "julius_n2_noisy.ply": ("denoise", "denoise_smooth"),
    "kinect_cone_noisy.ply": ("denoise_kinect", "denoise"),
    "nicolo_n2_noisy.ply": ("denoise", "denoise_smooth"),
    "sharpsphere_n3_noisy.ply": ("denoise", "denoise_sharp"),
    "twelve_i5_noisy.ply": ("denoise", "denoise_sharp"),
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


def cleaned(recipe: str, vertices: Floats, faces: Ints) -> Floats:
    """The vertices after a recipe, or as they were where it removes some: there they cannot be compared one by one."""
    meshes = MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(vertices, faces))
    Recipe.load(recipe).apply(meshes)
    found: Floats = meshes.current_mesh().vertex_matrix()
    return found if found.shape == vertices.shape else vertices


def measured(vertices: Floats, truth: Floats, faces: Ints) -> dict[str, float]:
    """Each of `MEASURES`: degrees between normals, mean edges from the true surface, and percent of the sides of the true box."""
    found = errors(vertices, truth, faces)
    sides, true = np.ptp(vertices[np.unique(faces)], axis=0), np.ptp(truth[np.unique(faces)], axis=0)
    return {
        "normals": found.mad,
        "distance": found.distance,
        "dimensions": 100.0 * float(np.abs(sides / np.where(true > 0, true, 1.0) - 1.0).max()),
    }


def matrix(folder: Path, only: list[str]) -> Iterator[str]:
    """A row for every pair; last what is worse than it should be."""
    yield f"{'pair':16} {'noise':>5} {'sharp':>5} " + " ".join(f"{name[-11:]:>13}" for name in RECIPES)
    said: list[str] = []
    unsaid: list[str] = []
    for path in sorted(folder.rglob("*_noisy.ply")):
        pair = path.stem.removesuffix("_noisy")
        if only and not any(text in pair for text in only):
            continue
        vertices, faces = read(path)
        truth, _ = read(path.with_name(f"{pair}_truth.ply"))
        traits = traits_of(vertices, faces, surface_measures(vertices, faces), set())
        results = {name: measured(cleaned(name, vertices, faces), truth, faces) for name in RECIPES}
        cells = []
        for name in RECIPES:
            info = load_recipe(name).info
            by = info.measure or "normals"
            ratio = results[name][by] / max(min(results[rival][by] for rival in RIVALS), 1e-9)
            inside = judged(name, info, traits).fits
            cells.append(f"{ratio:.2f} {by[:4]}" if inside else f"({ratio:.2f} {by[:4]})")
            if inside and ratio > 1.0 + TOLERANCE:
                (said if info.behind in RIVALS else unsaid).append(f"{name} on {pair} {ratio:.2f}")
        yield f"{pair:16} {traits['noise']:5.2f} {traits['sharpness']:5.2f} " + " ".join(f"{cell:>13}" for cell in cells)
        best = {by: min(results[r][by] for r in RIVALS) for by in MEASURES}
        for by in MEASURES:
            ratios = " ".join(f"{results[name][by] / max(best[by], 1e-9):13.2f}" for name in RECIPES)
            yield f"  {by:10} best {best[by]:8.3f}    {ratios}"
    yield f"worse than the best of three inside the range, as the head says: {'; '.join(said) or 'none'}"
    yield f"and without its saying so: {'; '.join(unsaid) or 'none'}"


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
    parser.add_argument("--suggest", action="store_true")
    options = parser.parse_args()
    only = [text for text in options.only.split(",") if text]
    for line in (suggestions if options.suggest else matrix)(options.folder, only):
        print(line, flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
